"""Files of sweeps whose checksums are right, but which this package did not write."""

import json
import re
import tracemalloc

import pytest

import frictionlab as fl
from frictionlab.analysis.sweeps.journal import _content, _json_line
from tests.faults.mutations import mutate
from tests.faults.processes import CURES

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
    "probes of 10**10": ("basins", 0, ("probes",), 10**10, "probes must be .*at most 4"),
    "states of 10**10": ("basins", 0, ("count",), 10**10, "count must be .*at most 1e"),
    "other states": ("basins", 0, ("count",), 5, "count must be .*got 5"),
    "a float": ("basins", 0, ("group",), 250.0, "group must be an integer"),
    "no mapping": ("basins", 0, ("x",), 1, "x must be a mapping"),
    "an unknown state": ("basins", 0, ("x", "name"), "z", r"x\['name'\] must be one of 'x', \"x'\""),
    "the same state": ("basins", 0, ("x", "name"), "x'", r"y\['name'\] must be one of"),
    "samples": ("shares", 0, ("samples",), 4, "count must be .*got 5"),
    "a reversed range": (
        "shares",
        0,
        ("ranges", "x"),
        [1.0, 0.0],
        r"ranges\['x'\] must be two numbers",
    ),
    "a kind": ("basins", 1, (RESULT, "kind"), "chaos", r"results\[0\]\['kind'\] must be one of"),
    "a state": ("basins", 1, (RESULT, "state"), [0.0], r"results\[0\]\['state'\] must have the shape 2"),
    "NaN": ("basins", 1, (RESULT, "state", 0), float("nan"), r"results\[0\]\['state'\] must hold finite"),
    "a label": (
        "basins",
        -1,
        (RESULT, "labels", 0),
        7,
        r"results\[4\]\['labels'\] must be a list",
    ),
    "a few labels": ("basins", -1, (RESULT, "labels"), [0], r"results\[4\]\['labels'\] must be a list of 4"),
    "a task": ("basins", 1, ("task",), 99, "task must be .* below 5"),
    "a negative task": ("basins", 1, ("task",), -1, r"line 2\['task'\] must be an integer, at least 0"),
    "a version": ("basins", 0, ("version",), 7, "version must be a text"),
    "a parameter": ("bifurcation", 0, ("parameter",), "w", "MassOnBelt has no parameter 'w'"),
    "a model": ("bifurcation", 0, ("model", "fields", "m"), -1.0, "m must be greater than 0"),
    "values": ("bifurcation", 0, ("values",), [[0.2], [0.3]], "values must have the shape any"),
    "a period": (
        "bifurcation",
        1,
        (RESULT, "period"),
        "1",
        r"results\[0\]\['period'\] must be a finite number",
    ),
    "onsets": ("bifurcation", 1, (RESULT, "onsets"), 1.5, r"results\[0\]\['onsets'\] must be an integer"),
    "shares": ("bifurcation", 1, (RESULT, "shares"), [], r"results\[0\]\['shares'\] must be a mapping"),
    "sections": ("bifurcation", 1, (RESULT, "section"), [[1.0]], r"results\[0\]\['section'\] must have"),
}


@pytest.mark.parametrize("case", CASES)
def test_one_error_names_file_field_rule_and_cure(files, tmp_path, case):
    """Before memory is taken, which tracemalloc measures; also where the sweep goes on from the file."""
    kind, line, place, value, message = CASES[case]
    path = tmp_path / "sweep.jsonl"
    path.write_bytes(changed(files[kind], line, *place, value=value))
    tracemalloc.start()
    try:
        with pytest.raises(ValueError, match=rf"sweep.jsonl is damaged, {message}.*: delete it"):
            READ[kind](path)
        assert tracemalloc.get_traced_memory()[1] < 20e6
    finally:
        tracemalloc.stop()
    if line != 0:
        content = path.read_bytes()
        with pytest.raises(ValueError, match=rf"sweep.jsonl is damaged, {message}.*: delete it"):
            MADE[kind](path)
        assert path.read_bytes() == content


@pytest.mark.parametrize("kind", MADE)
def test_no_mutation_leads_to_a_raw_error(files, tmp_path, kind):
    """The whole is ``python -m tests.faults files --mutations 1000``."""
    path, refused = tmp_path / kind, 0
    for seed in range(100):
        path.write_bytes(files[kind])
        mutate(path, seed)
        message = refusal(READ[kind], path)
        refused += bool(message)
        assert not message or (str(path) in message and re.search(CURES, message)), message
    assert refused > 50


def refusal(read, path):
    """The error with which a file is refused, "" where it is read."""
    try:
        repr(read(path))
    except ValueError as error:
        return str(error)
    return ""


def test_results_of_a_sweep_are_of_its_tasks(tmp_path):
    path = tmp_path / "sweep.jsonl"

    def load(model):
        return {"v": model.v}

    def swept():
        return fl.sweep(BELT, load, {"v": [0.2, 0.3]}, resume=path, **QUIET)

    swept()
    path.write_bytes(changed(path.read_bytes(), 2, "task", value=2))
    with pytest.raises(ValueError, match=r"damaged, task must be a finite number, below 2, got 2: delete it"):
        swept()


def test_what_json_cannot_read_is_a_damaged_line(tmp_path):
    path = tmp_path / "sweep.jsonl"
    MADE["bifurcation"](path)
    first = path.read_bytes().split(b"\n")[0]
    for text in ('{"task": 0, "result": ' + "[" * 100_000, '{"task": 0, "result": ' + "1" * 5000):
        line = _json_line({"task": 0, "result": text})
        whole = line.replace(json.dumps(text).encode(), text[22:].encode())
        path.write_bytes(first + b"\n" + with_checksum(whole))
        with pytest.raises(ValueError, match=r"is damaged in line 2: use it as resume="):
            fl.load_bifurcation(path)


def with_checksum(line):
    import zlib

    text = line.rpartition(b', "crc32"')[0]
    return b'%b, "crc32": "%08x"}\n' % (text, zlib.crc32(text))
