"""Sweeps that are cut off, by ctrl-C or worse, keep what is done and go on to the same file."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import frictionlab as fl
from tests.helpers.interrupted_sweep import MODEL, SETTINGS, VALUES

SCRIPT = Path(__file__).parents[2] / "helpers" / "interrupted_sweep.py"
ROOT = Path(__file__).parents[3]
posix = pytest.mark.skipif(os.name != "posix", reason="sends POSIX signals")


def started(path, kind):
    """The sweep in a process group of its own, as a terminal has it, once three tasks are in the file."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    process = subprocess.Popen(
        [sys.executable, str(SCRIPT), str(path), kind],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=environment,
        start_new_session=True,
    )
    deadline = time.monotonic() + 60.0
    while time.monotonic() < deadline and process.poll() is None:
        if path.exists() and path.read_text().count("\n") > 3:
            return process
        time.sleep(0.002)
    pytest.fail(f"the sweep did not begin: {process.communicate()}")


@posix
@pytest.mark.parametrize("kind", ["threads", "continue", "processes", "basins"])
def test_ctrl_c_keeps_what_is_done(kind, tmp_path):
    path = tmp_path / "sweep.jsonl"
    process = started(path, kind)
    os.killpg(process.pid, signal.SIGINT)
    out, err = process.communicate(timeout=60.0)
    assert process.returncode == 0, err
    assert "Traceback" not in err
    kept = path.read_text().count("\n") - 1
    assert 3 <= kept <= len(VALUES) + 1
    assert out == f"kept {kept}\n"


@posix
def test_a_killed_sweep_goes_on_to_the_file_of_an_undisturbed_one(tmp_path):
    path = tmp_path / "sweep.jsonl"
    process = started(path, "threads")
    os.killpg(process.pid, signal.SIGKILL)
    process.communicate(timeout=60.0)
    # The head and some results, so that there is something to go on from and something left.
    assert 4 <= len(path.read_text().splitlines()) <= len(VALUES)
    fl.bifurcation(MODEL, "mu_k", VALUES, resume=path, **SETTINGS)
    undisturbed = fl.bifurcation(MODEL, "mu_k", VALUES, workers=2, **SETTINGS)
    assert path.read_bytes() == undisturbed.save(tmp_path / "undisturbed").read_bytes()


@pytest.mark.parametrize("x0", ["rest", "continue"])
@pytest.mark.parametrize("lines", [0, 1, 3])
def test_a_file_that_was_cut_off_within_a_line_is_completed(x0, lines, tmp_path):
    path, values = tmp_path / "sweep.jsonl", VALUES[:4]
    fl.bifurcation(MODEL, "mu_k", values, x0, resume=path, **SETTINGS)
    whole = path.read_bytes()
    path.write_bytes(b"".join(whole.splitlines(keepends=True)[:lines]) + whole.splitlines()[lines][:-9])
    if lines == 0:
        with pytest.raises(ValueError, match="must be a file of a sweep"):
            fl.load_bifurcation(path)
        path.unlink()
    fl.bifurcation(MODEL, "mu_k", values, x0, resume=path, **SETTINGS)
    assert path.read_bytes() == whole


def test_a_file_of_another_sweep_is_refused_and_kept(tmp_path):
    path = tmp_path / "sweep.jsonl"
    fl.bifurcation(MODEL, "mu_k", [0.5], resume=path, **SETTINGS)
    before = path.read_bytes()
    for arguments, options, what in [
        (("mu_k", [0.6]), {}, "values"),
        (("F", [0.5]), {}, "parameter"),
        (("mu_k", [0.5], "near"), {}, "x0"),
        (("mu_k", [0.5]), {"window": 11.0}, "window"),
        (("mu_k", [0.5]), {"method": fl.Taylor(tol=1e-12)}, "method"),
    ]:
        with pytest.raises(ValueError, match=f"a file of the same sweep, .* differs in .*{what}"):
            fl.bifurcation(MODEL, *arguments, resume=path, **{**SETTINGS, **options})
    with pytest.raises(ValueError, match="a file of the same sweep"):
        fl.sweep(MODEL, abs, {"mu_k": [0.5]}, resume=path, progress=False)
    assert path.read_bytes() == before


@pytest.mark.parametrize("text", ["no JSON\n", "[1, 2]\n", '{"a": 1}\n{"b": 2}\n', "\x00\n"])
def test_a_file_that_is_no_sweep_is_refused_and_kept(text, tmp_path):
    path = tmp_path / "notes.txt"
    path.write_text(text)
    for use in (
        lambda: fl.load_bifurcation(path),
        lambda: fl.bifurcation(MODEL, "mu_k", [0.5], resume=path, **SETTINGS),
    ):
        with pytest.raises(ValueError, match="must be a file of a sweep, and is none"):
            use()
    assert path.read_text() == text


def test_a_sweep_is_no_bifurcation(tmp_path):
    path = tmp_path / "sweep.jsonl"
    fl.sweep(MODEL, lambda m: m.F, {"F": [1.0]}, resume=path, progress=False)
    with pytest.raises(ValueError, match="is one of another sweep"):
        fl.load_bifurcation(path)
