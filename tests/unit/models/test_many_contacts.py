"""Thirty contacts have 3^30 modes: only those that a run comes to are derived, named, packed and tried."""

import numpy as np
import pytest

import frictionlab as fl
from chain_and_rod import chain
from frictionlab.hybrid.solve import problem_of

MANY = 30


class Clock:
    """A progress bar that notes the times it is shown."""

    def __init__(self):
        self.times = []

    def update(self, t):
        self.times.append(float(t))
        return False


def start(count, stretch=1.0, speed=0.0):
    return np.append(stretch * np.sin(1.0 + np.arange(count)), np.full(count, speed))


@pytest.mark.slow
def test_thirty_contacts_take_what_a_run_visits():
    """The program grows with the modes that were visited, not with those that there are."""
    model = chain(MANY)
    run = fl.simulate(model, 1.0, x0=start(MANY), progress=False)
    visited, modes = {*run.mode, *run.events.target}, model.automaton().modes
    assert run.status.ok
    assert len(run.events) > 8
    assert visited <= set(modes.derived)
    assert len(modes.derived) < 2 * len(visited)
    program = run.problem.program
    code = program.code
    assert len(code.built) == len(modes.derived) + 1  # that of the conditions
    assert code.targets.size == 0
    assert len(program.demand.targets) <= 2 * len(code.resets)
    assert len(code.zero_classes) <= 2 * len(code.resets) * (MANY + 1)
    assert code.function_classes.max() < 5 * MANY
    assert set(run.time_in_mode) <= visited
    assert " | ".join(["slip+"] * MANY) in run.automaton.names
    assert "stick/slip+/slip- | " in repr(run.automaton)
    with pytest.raises(ValueError, match="mode must have one regime for each contact"):
        fl.solve(model.automaton(), 1.0, x0=start(MANY), mode="slip", progress=False)


@pytest.mark.slow
@pytest.mark.parametrize("method", [fl.Taylor(), fl.RK4(step=5e-3), fl.Scipy("RK45")], ids=lambda m: m.name)
def test_a_run_goes_on_where_a_mode_was_missing(method):
    """It never begins anew: its clock is never set back, however many modes are derived."""
    automaton, clock = chain(5).automaton(), Clock()
    problem = problem_of(automaton, start(5), 5.0)
    raw = method.integrate(problem, method.order_of(problem.program), clock)
    assert raw.t == 5.0
    assert len(automaton.modes.derived) > 5
    assert clock.times == sorted(clock.times)
    whole = fl.solve(chain(5).automaton(), 5.0, x0=start(5), method=method)
    assert whole.final_state.tolist() == raw.state.tolist()


def test_contacts_that_change_at_one_instant():
    """A chain and its mirror image: two contacts slip at once, to which no event leads in one step."""
    half = np.sin(1.0 + np.arange(4))
    x0 = np.append([*half, *half[::-1]], np.zeros(8))
    model = chain(8)
    run = fl.simulate(model, 6.0, x0=x0, progress=False)
    assert run.status.ok
    np.testing.assert_allclose(run.final_state[:4], run.final_state[7:3:-1], rtol=1e-9)
    pairs = zip(run.events.source, run.events.target, strict=True)
    changes = [sum(a != b for a, b in zip(x.split(" | "), y.split(" | "), strict=True)) for x, y in pairs]
    assert 2 in changes
    assert len(model.automaton().modes.derived) < 60


@pytest.mark.slow
@pytest.mark.parametrize("stretch", [0.1, 1.0], ids=["all stick", "some slip"])
def test_a_start_at_which_any_combination_may_be_entered(stretch):
    """All blocks move with the belt, so that all 3^12 modes have v_r of the right sign."""
    model = chain(12)
    run = fl.simulate(model, 1e-3, x0=start(12, stretch, model.v), progress=False)
    assert run.status.ok
    slips = {name for name in run.mode[0].split(" | ") if name != "stick"}
    assert bool(slips) == (stretch == 1.0)
    slipping = run.mode[0].split(" | ").count("slip+") + run.mode[0].split(" | ").count("slip-")
    assert len(model.automaton().modes.derived) <= 2**slipping


def test_equal_contacts_that_slip_at_one_instant():
    """Blocks that move alike leave the springs between them at rest: each is a block alone."""
    model = chain(12)
    run = fl.simulate(model, 20.0, progress=False)
    one = fl.simulate(fl.MassOnBelt(m=1.0, k=1.0, c=0.0, v=0.2, N=1.0, friction=model.friction), 20.0)
    assert set(one.events.target) == {"stick", "slip+"}
    in_turn = [" | ".join([target] * 12) for target in one.events.target]
    assert [name for name in run.events.target if name in in_turn] == in_turn
    np.testing.assert_allclose(run.raw.state[:12], one.raw.state[0], rtol=0, atol=1e-12)
    assert len(model.automaton().modes.derived) < 40


def test_an_ensemble_derives_what_its_runs_visit():
    model, starts = chain(12), [start(12, stretch) for stretch in (1.0, 0.3)]
    ends = fl.ensemble([model] * 2, 2.0, x0=starts, progress=False)
    assert len(model.automaton().modes.derived) < 200
    for i, x0 in enumerate(starts):
        run = fl.simulate(model, 2.0, x0=x0, progress=False)
        assert ends.states[i].tobytes() == run.raw.state.tobytes()
        assert ends.mode_names[ends.modes[i]] == run.mode[-1]
        assert (ends.steps[i], ends.events[i]) == (run.stats["steps"], len(run.events))
