"""How runs end, and what is refused before they begin."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

import frictionlab as fl
from frictionlab.hybrid import free_memory
from frictionlab.hybrid.methods import base
from frictionlab.hybrid.methods.base import RECORD_CAPACITY
from tests.helpers.automata import ONCE, V, X, automaton, coulomb, oscillator

ROOT = Path(__file__).parents[4]


@ONCE
def test_the_step_cap_keeps_what_was_computed():
    run = fl.solve(oscillator(), 1e4, x0=[1.0, 0.0], method=fl.Taylor(max_steps=7))
    assert run.status is fl.Status.STEP_CAP
    assert run.stats["steps"] == 7
    assert 0 < run.t[-1] < 1e4
    assert run["x"] == pytest.approx(np.cos(run.t), abs=1e-13)


@ONCE
def test_the_event_cap_keeps_what_was_computed():
    run = fl.solve(coulomb(0.2, 1.0, 0.5), 1e4, x0=[0.0, 0.2], method=fl.Taylor(max_events=3))
    assert run.status is fl.Status.EVENT_CAP
    assert len(run.events) == 3
    assert run.t[-1] == run.events.t[-1]


@ONCE
def test_a_run_that_would_fill_the_memory_keeps_what_was_computed(monkeypatch):
    monkeypatch.setattr(base, "BYTES_BETWEEN_LOOKS", 1000)
    free = iter([1e9, 1e9, 0.0])
    monkeypatch.setattr(base, "free_memory", lambda: next(free))
    run = fl.solve(oscillator(), 1e5, x0=[1.0, 0.0], method=fl.Taylor(), progress=False)
    assert run.status is fl.Status.MEMORY_CAP
    assert run.stats["steps"] == 3 * RECORD_CAPACITY
    assert 0 < run.t[-1] < 1e5
    assert "memory" in str(run.status)
    on = fl.solve(oscillator(), 1.0, x0=run.final_state, progress=False)
    assert on.status is fl.Status.FINISHED


# A process of its own: a fork of one with threads, as that of tests has, may wait for a lock for ever.
LIMITED = """
import json, resource
import frictionlab as fl
from frictionlab.hybrid import free_memory
from tests.helpers.automata import oscillator

fl.solve(oscillator(), 1.0, x0=[1.0, 0.0], progress=False)
size = int(free_memory.PROCESS_SIZE.read_text().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (size + {room}, resource.RLIM_INFINITY))
run = fl.solve(oscillator(), 1e7, x0=[1.0, 0.0], progress=False)
print(json.dumps([run.status.name, run.stats["steps"], run.final_state.tolist()]))
"""


@pytest.mark.slow  # processes of their own, with a limit
@ONCE
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="the size of a process is read from /proc")
@pytest.mark.parametrize("room", [8_000_000, 40_000_000])
def test_under_a_limit_of_memory_a_run_keeps_what_it_has(room):
    """The steps are those of a run without a limit that ends after as many."""
    command = [sys.executable, "-c", LIMITED.format(room=room)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    status, steps, end = json.loads(done.stdout)
    assert status == "MEMORY_CAP"
    assert steps * 5 * 8 > room / 20  # a share of the memory is used
    whole = fl.solve(oscillator(), 1e7, x0=[1.0, 0.0], method=fl.Taylor(max_steps=steps), progress=False)
    assert whole.final_state.tolist() == end


def test_the_free_memory_is_what_the_system_tells(monkeypatch, tmp_path):
    information, group = tmp_path / "meminfo", tmp_path / "group"
    monkeypatch.setattr(free_memory, "MEMORY_INFORMATION", information)
    monkeypatch.setattr(free_memory, "GROUP", group)
    assert free_memory.free_memory() > 0.0  # by sysconf, or unknown
    information.write_text("MemTotal: 9 kB\nMemAvailable:   2000 kB\n")
    assert free_memory.free_memory() == 2000 * 1024
    group.mkdir()
    (group / "memory.max").write_text("max\n")
    (group / "memory.current").write_text("1000\n")
    assert free_memory.free_memory() == 2000 * 1024
    (group / "memory.max").write_text("5000\n")
    assert free_memory.free_memory() == 4000.0


@ONCE
def test_no_admissible_mode_after_an_event_is_a_status():
    run = fl.solve(
        automaton(fl.Mode("only", (sp.Integer(-1),), (fl.Event("x", X),)), states=(X,), coordinates=0),
        2.0,
        x0=[1.0],
    )
    assert run.status is fl.Status.NO_ADMISSIBLE_MODE
    assert run.events.t == pytest.approx([1.0])
    assert run.events.target.tolist() == [""]
    assert run.t[-1] == pytest.approx(1.0)
    assert run.final_state == pytest.approx([0.0], abs=1e-15)


@ONCE
def test_no_admissible_mode_at_the_start_is_a_status():
    run = fl.solve(automaton(fl.Mode("only", (V, -X), (fl.Event("x", X),))), 2.0, x0=[-1.0, 0.0])
    assert run.status is fl.Status.NO_ADMISSIBLE_MODE
    assert len(run.events) == 0
    assert run.final_state.tolist() == [-1.0, 0.0]
    assert run.t.tolist() == [0.0]
    with pytest.warns(RuntimeWarning, match="behind a stop: 'distance' is -1"):
        overlapped = fl.simulate(fl.BouncingBall(), 2.0, x0=[-1.0, 0.0], progress=False)
    assert np.isnan(overlapped["reaction"]).all()  # as it is in no mode
    with pytest.raises(ValueError, match="its motion ends early: no admissible mode"):
        fl.periodic_orbit(fl.BouncingBall(), overlapped)


@pytest.mark.parametrize("method", ["taylor", "rk4", "DOP853"])
def test_a_motion_that_escapes_in_finite_time_ends_with_a_status(method):
    escape = automaton(fl.Mode("only", (X**2,)), states=(X,), coordinates=0)
    run = fl.solve(escape, 2.0, x0=[1.0], method=method)
    assert run.status in (fl.Status.NOT_FINITE, fl.Status.STALLED)
    assert np.isfinite(run.states).all()
    assert np.isfinite(run.t).all()
    assert run.t[-1] == pytest.approx(1.0, abs=1e-3)


@ONCE
def test_division_by_zero_ends_with_a_status():
    run = fl.solve(automaton(fl.Mode("only", (1 / X,)), states=(X,), coordinates=0), 2.0, x0=[0.0])
    assert run.status is fl.Status.NOT_FINITE
    assert np.isfinite(run.states).all()


@ONCE
def test_a_motion_from_rest_whose_first_coefficients_vanish():
    """x'' = sin t from rest: the series of x starts at t^3."""
    s, c = sp.symbols("s c")
    forced = automaton(fl.Mode("only", (V, s, c, -s)), states=(X, V, s, c))
    run = fl.solve(forced, 5.0, x0=[0.0, 0.0, 0.0, 1.0])
    assert run.status.ok
    assert run.final_state[:2] == pytest.approx([5 - np.sin(5), 1 - np.cos(5)], abs=1e-13)


@ONCE
def test_nothing_moves_in_a_state_of_rest():
    run = fl.solve(oscillator(), 1e7, x0=[0.0, 0.0])
    assert run.status.ok
    assert run.final_state.tolist() == [0.0, 0.0]


@ONCE
def test_the_first_mode_can_be_chosen():
    twins = automaton(fl.Mode("a", (V, -X)), fl.Mode("b", (V, -4 * X)))
    assert fl.solve(twins, 1.0, x0=[1.0, 0.0]).mode[0] == "a"
    run = fl.solve(twins, 1.0, x0=[1.0, 0.0], mode="b")
    assert run.mode[0] == "b"
    assert run.final_state[0] == pytest.approx(np.cos(2), abs=1e-14)


@ONCE
@pytest.mark.parametrize("miss", [1e-12, -1e-12, 1e-9, -1e-9])
def test_a_start_in_stick_beside_the_belts_speed_breaks_away_as_one_at_it(miss):
    model = fl.MassOnBelt(friction=fl.ExponentialDecay(mu_k=0.4, mu_s=0.8, v_s=0.2), v=0.5)
    run, exact = (
        fl.solve(model.automaton(), 2.0, x0=[0.5, 0.5 * (1 + share)], mode="stick") for share in (miss, 0.0)
    )
    assert run.status.ok
    assert run.events.target.tolist() == ["slip+"]
    assert run.final_state == pytest.approx(exact.final_state, abs=1e-14)


@ONCE
def test_a_mode_that_cannot_be_entered_is_refused():
    with pytest.raises(ValueError, match="cannot start in mode 'stick'"):
        fl.solve(coulomb(0.2, 1.0, 0.5), 1.0, x0=[0.0, 0.0], mode="stick")
    with pytest.raises(ValueError, match="did you mean 'stick'"):
        fl.solve(coulomb(0.2, 1.0, 0.5), 1.0, x0=[0.0, 0.2], mode="stik")


@ONCE
@pytest.mark.parametrize("value", ["a", np.nan, None, sp.oo, sp.Symbol("c")], ids=str)
def test_a_parameter_without_a_value_is_refused(value):
    stiff = automaton(fl.Mode("only", (V, -sp.Symbol("k") * X)), k=value)
    with pytest.raises(ValueError, match=r"parameter k must be a finite number, got .* replace\(k=1.0\)"):
        fl.solve(stiff, 1.0, x0=[1.0, 0.0])


@ONCE
def test_parameters_may_be_numbers_of_sympy():
    stiff = automaton(fl.Mode("only", (V, -sp.Symbol("k") * X)), k=sp.pi**2)
    assert fl.solve(stiff, 1.0, x0=[1.0, 0.0]).final_state[0] == pytest.approx(-1.0, abs=1e-14)


@ONCE
@pytest.mark.parametrize(
    ("broken", "message"),
    [
        (automaton(), "at least one mode"),
        (automaton(fl.Mode("a", (V, -X)), fl.Mode("a", (V, -X))), "must differ"),
        (automaton(fl.Mode("a", (V,))), "one expression per state"),
        (automaton(fl.Mode("a", (V, -X), (fl.Event("e", X, ("b",)),))), r"leads to \['b'\]"),
        (automaton(fl.Mode("a", (V, -sp.Symbol("k") * X))), r"the flow of mode 'a' uses \['k'\]"),
        (automaton(fl.Mode("a", (V, -X), (fl.Event("e", X - sp.Symbol("c")),))), "event 'e'"),
        (
            automaton(fl.Mode("a", (V, -X), (fl.Event("e", X, (), fl.Reset({V: sp.Symbol("w")})),))),
            "the reset of event 'e'",
        ),
        (
            automaton(fl.Mode("a", (V, -X), (fl.Event("e", X, (), fl.Reset({sp.Symbol("k"): 0})),)), k=1.0),
            r"the reset of event 'e' of mode 'a' may give values to states only \(v, x\), got one for k",
        ),
        (
            automaton(fl.Mode("a", (V, -X), (fl.Event("e", X, (), fl.Reset(), fl.Reset({"v": 0})),))),
            "states only .* got one for v",
        ),
        (automaton(fl.Mode("a", (V, -X), outputs={"energy": sp.Symbol("k") * X})), "output 'energy'"),
        (automaton(fl.Mode("a", (V, -X)), coordinates=2), "coordinates"),
    ],
)
def test_malformed_automata_are_refused(broken, message):
    with pytest.raises(ValueError, match=message):
        fl.solve(broken, 1.0, x0=[1.0, 0.0])
