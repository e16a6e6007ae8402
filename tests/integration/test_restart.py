"""An automaton has no clock and no memory: from any event on, and from a file, a run goes on as it did."""

import numpy as np
import pytest

import frictionlab as fl
from tests.helpers.cases import slow_but
from tests.helpers.energy_balance import assert_balanced

MODELS = {
    "A": fl.SliderOnBelt(mu_k=1.4).without("geometry"),
    "B": fl.SliderOnBelt(mu_k=1.4, impact=fl.PlasticImpact("full")),
    "D": fl.SliderOnBelt(mu_k=1.4),
}


def followed(scene, whole, number):
    """The rest of a run, solved from the state right after an event."""
    events = whole.events
    state, mode = events.state[number], str(events.target[number])
    left = whole.t[-1] - events.t[number]
    run = fl.solve(MODELS[scene].automaton(), left, x0=state, mode=mode, progress=False)
    assert run.status is fl.Status.FINISHED
    return run


def numbers(scene, events):
    """All events but the last; of D every tenth, and those where a limit of chatter begins or ends.

    Two flights before a limit begins there is no going on: how many short flights there have been in a row
    is the solver's to know, not the state's, and the limit would come a flight later.
    """
    if scene != "D":
        return range(len(events) - 1)
    limits = np.flatnonzero((events.target == "chatter") | (events.source == "chatter"))
    begin = np.flatnonzero(events.target == "chatter")
    return sorted({*range(0, len(events) - 1, 10), *limits} - {*(begin - 1), *(begin - 2)})


@pytest.mark.parametrize("scene", slow_but([scene for scene in MODELS if scene != "D"], [*MODELS]))
def test_after_every_event_the_rest_is_the_same_at_another_time(scene):
    """Intervals to the rounding of the time that is left out (4e-16 s, in D 2e-15 s), states to 1e-13."""
    whole = fl.simulate(MODELS[scene], 1.0, progress=False)
    assert_balanced(whole)
    events = whole.events
    for number in numbers(scene, events):
        run = followed(scene, whole, number)
        later = slice(number + 1, None)
        assert run.events.source.tolist() == events.source[later].tolist()
        assert run.events.target.tolist() == events.target[later].tolist()
        assert np.abs(run.events.t - (events.t[later] - events.t[number])).max() < 1e-14
        assert np.abs(run.events.state - events.state[later]).max() < 1e-13
        # The last step ends at another bit of time, at accelerations of some 1000 m/s^2.
        assert np.abs(run.final_state - whole.final_state).max() < 1e-11


@pytest.mark.parametrize("scene", MODELS)
@pytest.mark.parametrize("cut", [0.02, 0.0925, 0.3137, 0.5])
def test_a_run_goes_on_from_its_file_as_it_does_without(scene, cut, tmp_path):
    """In stick, in flight, amidst chatter: the same bits."""
    first = fl.simulate(MODELS[scene], cut, progress=False)
    stored = fl.load(first.save(tmp_path / "first"))
    ends = []
    for run in (first, stored):
        start = {"x0": run.final_state, "mode": str(run.mode[-1])}
        ends.append(fl.solve(run.automaton, 0.5, **start, progress=False))
    assert_balanced(first)
    assert_balanced(stored)
    assert ends[0].final_state.tobytes() == ends[1].final_state.tobytes()
    assert ends[0].events.t.tobytes() == ends[1].events.t.tobytes()
    assert ends[0].events.state.tobytes() == ends[1].events.state.tobytes()
