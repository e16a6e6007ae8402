"""Files of sweeps whose checksums are right, but which this package did not write."""

import pytest

import frictionlab as fl
from frictionlab.analysis.sweeps.journal import _content, _json_line

QUIET = {"progress": False, "workers": 1}
BELT = fl.MassOnBelt()
SHORT = {"transient": 9.0, "window": 9.0, **QUIET}
MADE = {
    "bifurcation": lambda path: fl.bifurcation(BELT, "v", [0.2, 0.3], resume=path, **SHORT),
    "basins": lambda path: fl.basins(BELT, ("x", [0.0, 0.1]), ("x'", [0.0, 0.1]), resume=path, **SHORT),
    "shares": lambda path: fl.basin_stability(BELT, {"x": (0.0, 0.2)}, 5, resume=path, **SHORT),
}
READ = {"bifurcation": fl.load_bifurcation, "basins": fl.load_basins, "shares": fl.load_basins}


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("stored")
    for name, make in MADE.items():
        make(folder / name)
    return {name: (folder / name).read_bytes() for name in MADE}


def changed(content, line, *place, value):
    """The file with another value at a place in a line, its checksum computed anew."""
    lines = content.split(b"\n")[:-1]
    line %= len(lines)
    data = _content(lines[line])
    inner = data
    for key in place[:-1]:
        inner = inner[key]
    inner[place[-1]] = value
    return b"\n".join([*lines[:line], _json_line(data)[:-1], *lines[line + 1 :], b""])


RESULT = "result"
CASES = {
    "no states": ("basins", 0, ("states",), None),
    "other axes": ("basins", 0, ("x",), 1),
    "too few states": ("basins", 0, ("count",), 5),
    "no kind": ("basins", 1, (RESULT,), {}),
    "a label without an attractor": ("basins", -1, (RESULT, "labels", 0), 7),
    "a text": ("shares", 0, ("samples",), "four"),
    "a period": ("bifurcation", 1, (RESULT, "period"), "one"),
    "a section": ("bifurcation", 1, (RESULT, "section"), [[1.0]]),
}


@pytest.mark.parametrize("case", CASES)
def test_one_error_names_file_and_cure(files, tmp_path, case):
    kind, line, place, value = CASES[case]
    path = tmp_path / "sweep.jsonl"
    path.write_bytes(changed(files[kind], line, *place, value=value))
    with pytest.raises(ValueError, match=r"sweep.jsonl is damaged \(.*\): delete it"):
        READ[kind](path)
