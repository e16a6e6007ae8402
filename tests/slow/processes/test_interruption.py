"""Ctrl-C, as a real signal in a process of its own: it always ends a computation, and nothing is lost."""

import os
import signal
import subprocess
import sys
import textwrap
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
pytestmark = pytest.mark.skipif(os.name != "posix", reason="sends POSIX signals")
HEAD = """
import signal, sys, time
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell ignores it in the background
import frictionlab as fl
model = fl.SliderOnBelt(mu_k=1.4)
flat = model.without("geometry")
"""


def pressed(script, presses=1):
    """Standard output, standard error and exit status of a script that gets ctrl-C after its sign."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-u", "-c", HEAD + textwrap.dedent(script)]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment
    ) as process:
        assert process.stdout is not None
        for line in process.stdout:
            if line.startswith("ready"):
                break
        for _ in range(presses):
            time.sleep(1.0)
            process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=900)
    return out, err, process.returncode


def test_one_press_ends_a_loop_of_short_runs():
    script = """
    fl.simulate(model, 0.02, progress=False)
    print("ready")
    for i in range(100_000):
        fl.simulate(model, 0.02, progress=False)
    print("swallowed")
    """
    out, err, status = pressed(script)
    assert "swallowed" not in out
    assert "KeyboardInterrupt" in err.splitlines()[-1]
    assert status == -signal.SIGINT  # so that a loop of the shell ends, too


@pytest.mark.parametrize(
    ("call", "presses", "kept"),
    [
        (
            "fl.simulate(model, 1e6, progress=False)",
            1,
            "found.raw.t > 0 and found.status.name == 'INTERRUPTED'",
        ),
        ("fl.steady_state(model, transient=1e6, progress=False)", 1, "found.raw.t > 0"),
        ("fl.ensemble([flat] * 20, 1e6, progress=False)", 1, "(found.t > 0).all()"),
        ("fl.verify(model, 1e6, progress=False)", 1, "found.raw.t > 0"),
        ("fl.continue_orbit(orbit, 'mu_k', (0.5, 3.0), step=1e-3)", 1, "'interrupted' in found.ends"),
        (
            "fl.sweep(model, slow, {'mu_k': mus}, progress=False)",
            1,
            "0 < sum(r == 1 for r in found.results) < 999",
        ),
        ("fl.sweep(model, long, {'mu_k': mus}, progress=False)", 2, "len(found.results) == 999"),
        (
            "fl.bifurcation(flat, 'mu_k', mus[:40], transient=1e6, progress=False)",
            2,
            "set(found.kinds) == {''}",
        ),
        ("fl.ablation(flat, long, progress=False)", 2, "set(found.results) == {None}"),
        ("fl.basins(flat, *speeds, transient=1e6, progress=False)", 2, "found is None"),
    ],
)
def test_a_computation_that_was_stopped_keeps_what_it_has(call, presses, kept):
    script = f"""
    def slow(model):
        time.sleep(0.05)
        return 1

    def long(model):
        return fl.simulate(model, 1e6, progress=False).raw.t

    mus = [0.5 + 1e-3 * i for i in range(999)]
    speeds = ("x1'", mus[:20]), ("y1'", mus[:20])
    orbit = fl.periodic_orbit(flat, fl.simulate(flat, 30.0, progress=False))
    # Now the solver is compiled and the model derived, so that ctrl-C comes when there is something to keep.
    fl.simulate(model, 0.02, progress=False)
    fl.ensemble([flat] * 20, 0.1, progress=False)
    print("ready")
    try:
        {call}
        print("returned")
    except KeyboardInterrupt as stopped:
        found = fl.partial_result()
        assert {kept}, found
        assert "by ctrl-C" in str(stopped), stopped
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
        print("kept")
    """
    out, err, status = pressed(script, presses)
    assert (out, status) == ("kept\n", 0), err
