"""Files of sweeps: damaged, of other versions, full disks, and two sweeps on one file."""

import math
import os
import random
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

import pytest

import frictionlab as fl
from frictionlab.analysis.sweeps.journal import Journal, read_journal, write_journal

MODEL = fl.SliderOnBelt()
VALUES = {"F": [100.0, 200.0, 300.0, 400.0]}
ROOT = Path(__file__).parents[4]


def load(model):
    return {"F": model.F, "third": model.F / 3.0}


def swept(path):
    return fl.sweep(MODEL, load, VALUES, resume=path, workers=2, progress=False)


CALLS = []


def count(model):
    CALLS.append(model)
    return {"F": model.F}


def test_an_ablation_goes_on_where_it_was_cut_off(tmp_path):
    CALLS.clear()
    path = tmp_path / "ablation.jsonl"
    first = fl.ablation(MODEL, count, resume=path, workers=2, progress=False)
    whole = path.read_bytes()
    path.write_bytes(b"".join(whole.splitlines(keepends=True)[:6]))
    again = fl.ablation(MODEL, count, resume=path, workers=2, progress=False)
    assert (len(CALLS), again.results) == (8 + 3, first.results)
    assert path.read_bytes() == whole
    with pytest.raises(
        ValueError, match=r"resume must be a file of the same sweep, .* differs in .*ablation"
    ):
        fl.ablation(MODEL, load, resume=path, progress=False)
    with pytest.raises(ValueError, match=r"differs in .*model"):
        fl.ablation(MODEL.replace(F=1.0), count, resume=path, progress=False)
    with pytest.raises(ValueError, match="differs in"):
        fl.sweep(MODEL, count, VALUES, resume=path, progress=False)


@pytest.fixture
def whole(tmp_path):
    path = tmp_path / "sweep.jsonl"
    swept(path)
    return path


def test_damaged_lines_are_computed_again(whole):
    content, lines = whole.read_bytes(), whole.read_bytes().splitlines(keepends=True)
    lines[2] = lines[2].replace(b"200.0", b"201.0")
    lines[4] = b"\x00" * 40 + b"\n"
    whole.write_bytes(b"".join(lines))
    with pytest.raises(ValueError, match=r"sweep.jsonl is damaged in line 3 and 1 more: use it as resume="):
        read_journal(whole)
    with pytest.warns(RuntimeWarning, match=r"sweep.jsonl is damaged in line 3 and 1 more: computed again"):
        found = swept(whole)
    assert [result["F"] for result in found.results] == VALUES["F"]
    assert whole.read_bytes() == content


@pytest.mark.filterwarnings("ignore:.*computed again:RuntimeWarning")
def test_no_flip_and_no_cut_gives_a_wrong_result(whole):
    content, draw = whole.read_bytes(), random.Random(1)
    right = swept(whole).results.tolist()
    messages = []
    for _ in range(150):
        damaged = bytearray(content[: draw.choice([len(content), draw.randrange(len(content))])])
        if damaged:
            damaged[draw.randrange(len(damaged))] ^= 1 << draw.randrange(8)
        whole.write_bytes(bytes(damaged))
        try:
            results = swept(whole).results.tolist()
        except ValueError as error:
            messages.append(str(error))
            unchanged = bytes(damaged)
        else:
            assert results == right
            unchanged = content
        assert whole.read_bytes() == unchanged
    assert 0 < len(messages) < 150
    assert all(str(whole) in message and "delete it" in message for message in messages)


def test_another_format_or_version_is_refused(whole, monkeypatch):
    content = whole.read_bytes()
    monkeypatch.setattr("frictionlab.analysis.sweeps.journal.__version__", "9.9")
    monkeypatch.setattr("frictionlab.analysis.sweeps.journal.PYTHON", "3.99")
    by_another = r"sweep.jsonl differs in version, by Python 3.\d\d and not 3.99: give another path"
    with pytest.raises(ValueError, match=by_another):
        swept(whole)
    assert read_journal(whole)[1][0]["F"] == 100.0
    monkeypatch.setattr("frictionlab.analysis.sweeps.journal.FORMAT", 2)
    with pytest.raises(ValueError, match=r"has format 1, this version reads 2: read it with frictionlab 0"):
        swept(whole)
    assert whole.read_bytes() == content


def test_two_sweeps_cannot_use_one_file(whole):
    other = (
        "import sys\n"
        "from frictionlab.analysis.sweeps.journal import Journal\n"
        "with Journal({}, sys.argv[1]):\n"
        "    print('has it', flush=True)\n"
        "    sys.stdin.read()\n"
    )
    whole.unlink()
    command = [sys.executable, "-c", other, str(whole)]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "has it\n"
        with pytest.raises(OSError, match=r"sweep.jsonl' is in use by another sweep.*: wait until"):
            swept(whole)
        process.kill()
    whole.unlink()
    assert len(swept(whole).results) == 4  # what is killed holds nothing


def test_the_file_is_free_after_an_error(tmp_path):
    def fails(model):
        raise ArithmeticError("no such thing")

    path = tmp_path / "sweep.jsonl"
    for _ in range(2):
        with pytest.raises(RuntimeError, match="F = 100 failed with ArithmeticError: no such thing"):
            fl.sweep(MODEL, fails, {"F": [100.0]}, resume=path, progress=False)


@contextmanager
def room_for(size):
    """Context in which files cannot become larger, as on a disk that is full."""
    resource = pytest.importorskip("resource", reason="limits of files are POSIX")
    usual = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, usual[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, usual)


def test_a_full_disk_leaves_whole_lines(tmp_path):
    path = tmp_path / "sweep.jsonl"
    with Journal({"a": 1}, path) as journal:
        journal.keep(0, 0.5)
        before = path.read_bytes()
        with (
            room_for(len(before) + 20),
            pytest.raises(OSError, match=r"cannot be written .*: make room") as full,
        ):
            journal.keep(1, 1.5)
    assert str(path) in str(full.value)
    assert "the 1 results in it are kept" in str(full.value)
    assert path.read_bytes() == before
    assert read_journal(path) == ({"a": 1}, {0: 0.5})


def test_a_file_that_cannot_be_written_is_kept(whole, monkeypatch):
    content = whole.read_bytes()

    def full(handle):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="No space left on device"):
        write_journal(whole, {}, {})
    assert whole.read_bytes() == content
    assert {file.name for file in whole.parent.iterdir()} == {"sweep.jsonl", "sweep.jsonl.lock"}


def test_a_model_of_ones_own_that_has_changed_begins_anew(tmp_path):
    """The class has the same name and the same numbers, but a spring four times as stiff."""

    def spring(factor):
        @fl.model
        class Spring(fl.MechanicalModel):
            k: float = 1.0
            coordinates = ("x",)

            def mechanics(self, q, v):
                return fl.Mechanics(v.x**2 / 2, factor * self.k * q.x**2 / 2)

        return Spring()

    def frequency(model):
        return float(fl.eigenvalues(model).frequencies[0])

    def results(model):
        path = tmp_path / "springs.jsonl"
        return fl.sweep(model, frequency, {"k": [1.0, 4.0]}, resume=path, progress=False).results.tolist()

    first = results(spring(1))
    assert results(spring(1)) == first == pytest.approx([0.5 / math.pi, 1 / math.pi])
    with pytest.raises(ValueError, match=r"springs.jsonl differs in model"):
        results(spring(4))
