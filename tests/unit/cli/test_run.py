"""The command line: what it prints, writes and returns."""

import gc
import re
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

import frictionlab as fl
from frictionlab.cli import command, parsing
from frictionlab.cli.run import METHOD_NAMES
from frictionlab.hybrid.methods.scipy_methods import INTEGRATORS

SHORT = ["run", "-q", "--t-end", "0.1"]


@pytest.mark.plain_python
def test_summary_holds_the_numbers_of_the_run(capsys):
    assert command.main(SHORT) == 0
    out, err = capsys.readouterr()
    run = fl.simulate(fl.SliderOnBelt(mu_k=1.4), 0.1)
    assert err == ""
    assert out.startswith("SliderOnBelt(mu_k=1.4)\n0.1 s from rest, method taylor, tol 1e-15\n")
    assert re.search(r"x1 +\+0.005253 m\n +y1 +-0.026339 m\n(.*\n){2} +phi +\+0.002628 rad", out)
    assert "Eigenvalues there (stable)" in out
    assert "15.7122           -0.04955  -0.04955 +- 98.7226i" in out
    assert f"Events: {len(run.events)}, accumulations closed: {run.stats['accumulations']}" in out
    for kind, count in run.events.counts().items():
        assert re.search(rf"  {re.escape(kind)} +{count}\n", out)
    assert f"stick {100 * run.time_in_mode['stick'] / 0.1:.2f} %" in out
    assert str(run.status) in out
    assert "icture" not in out


def test_no_equilibrium_takes_one_line_and_the_run_goes_on(capsys):
    assert command.main([*SHORT, "--set", "F=0"]) == 0
    out = capsys.readouterr().out
    assert re.search(r"^No sliding equilibrium: .*F_N > 0.*$", out, flags=re.MULTILINE)
    assert "finished: the end time was reached" in out


def test_a_belt_at_rest_has_an_equilibrium_but_no_eigenvalues(capsys):
    assert command.main([*SHORT, "--set", "v=0"]) == 0
    out = capsys.readouterr().out
    assert "Sliding equilibrium" in out
    assert "No eigenvalues: v must not be 0" in out


def test_picture_and_run_are_written(tmp_path, capsys):
    picture, saved = tmp_path / "a.png", tmp_path / "b"
    assert command.main([*SHORT, "-o", str(picture), "--save", str(saved)]) == 0
    out = capsys.readouterr().out
    assert f"Picture in {picture}" in out
    assert f"Saved as {saved}.npz" in out
    assert picture.read_bytes()[:4] == b"\x89PNG"
    # The command leaves cycles to the end of its process; where Python goes on they are searched for.
    assert gc.isenabled()
    assert gc.get_freeze_count() == 0
    run = fl.simulate(fl.SliderOnBelt(mu_k=1.4), 0.1)
    assert np.array_equal(fl.load(f"{saved}.npz").final_state, run.final_state)


OPTIONS = {
    "--set mu_k=0.9 k_nl=5e3 --set v=-1e-1": "SliderOnBelt(v=-0.1, k_nl=5000.0, mu_k=0.9)",
    "--without geometry cubic --without nonsmooth": "SliderOnBelt(mu_k=1.4, "
    "contact=LinearContact(k2=5000.0), interface=SlidingOnly(), geometry=FixedLoad())",
    "--model SliderOnBelt(impact=RestitutionImpact(e=0.25))": "impact=RestitutionImpact(e=0.25))",
    "--method rk4 --step 1e-3": "method rk4, step 0.001",
    "--method dop853 --tol 1e-8": "method DOP853, rtol 1e-08",
    "--tol 1e-9": "method taylor, tol 1e-09",
    "--x0 near": "from near the equilibrium",
    "--x0 -1e-3,0,0,0,0,0,0,0,0,0": "from -1e-3,0,0,0,0,0,0,0,0,0",
}


@pytest.mark.parametrize(("options", "shown"), OPTIONS.items(), ids=OPTIONS)
def test_options_reach_the_run(options, shown, capsys):
    assert command.main([*SHORT, *options.split()]) == 0
    assert shown in capsys.readouterr().out


def test_methods_offered_are_those_there_are():
    assert ("taylor", "rk4", *INTEGRATORS) == METHOD_NAMES


def test_a_file_that_cannot_be_written_after_all_does_not_lose_the_summary(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(parsing, "check_files", lambda chosen: None)
    assert command.main([*SHORT, "-o", str(tmp_path / "gone" / "a.png")]) == 1
    captured = capsys.readouterr()
    assert "finished: the end time was reached" in captured.out
    assert captured.err.count("\n") == 1


def test_a_run_that_ends_early_is_kept_and_code_is_1(tmp_path, capsys):
    saved = tmp_path / "early.npz"
    assert command.main(["run", "-q", "--max-steps", "5", "--save", str(saved)]) == 1
    assert "step cap: max_steps was reached" in capsys.readouterr().out
    assert not fl.load(saved).status.ok


def test_module_version_and_help_of_the_command():
    def answer(*words):
        command = [sys.executable, "-m", "frictionlab", *words]
        return subprocess.run(command, capture_output=True, text=True)

    assert answer("--version").stdout == f"frictionlab {fl.__version__}\n"
    assert "run" in answer().stdout
    wrong = answer("rnu")
    assert (wrong.returncode, wrong.stdout, wrong.stderr.count("\n")) == (2, "", 1)


def heed_ctrl_c():
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell ignores it in the background


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="no SIGINT for another process on Windows")
def test_ctrl_c_prints_what_was_computed():
    command = [sys.executable, "-u", "-m", "frictionlab", "run", "-q", "--t-end", "1e7"]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=heed_ctrl_c
    ) as process:
        assert process.stdout is not None
        for line in process.stdout:  # the summary's first part ends with the last eigenvalue
            if "161.0" in line:
                break
        time.sleep(3.0)  # into the run; where it has not begun, the second part is missing below
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=120)
    assert (process.returncode, err) == (130, "frictionlab: stopped by ctrl-C\n")
    assert "interrupted: stopped by ctrl-C" in out
    assert "Events:" in out
