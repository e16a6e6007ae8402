"""Modes of models with several contacts are derived when a run comes to try them, which changes no run."""

import pickle
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest

import frictionlab as fl
from frictionlab.automaton import Mode
from frictionlab.automaton.modes_on_demand import ModesOnDemand, Regime, names_of_parts
from frictionlab.components.friction import FrictionLaw
from frictionlab.components.impact import ImpactLaw
from frictionlab.hybrid.solve import problem_of
from frictionlab.models import MechanicalModel, Mechanics
from frictionlab.models.automaton_of_model import automaton_of_structure
from frictionlab.models.mechanical.mechanics import Friction, Stop

pytestmark = pytest.mark.plain_python


@fl.model
class ThreeBlocks(MechanicalModel):
    """A chain: 27 modes."""

    k: float = fl.parameter(1.0, unit="N/m", symbol="k", meaning="stiffness", range=(0.1, 10.0))
    v: float = fl.parameter(0.2, unit="m/s", symbol="v", meaning="speed", range=(0.0, 10.0))
    friction: FrictionLaw = fl.Coulomb(mu_k=0.5, mu_s=1.0)
    coordinates = ("x1", "x2", "x3")

    def mechanics(self, q, v):
        springs = self.k * q.x1**2 + 2 * q.x2**2 + q.x3**2 + (q.x1 - q.x2) ** 2 + (q.x2 - q.x3) ** 2
        return Mechanics(
            kinetic=(v.x1**2 + v.x2**2 + v.x3**2) / 2,
            potential=springs / 2,
            contacts=tuple(Friction(self.v - u, 1.0, self.friction) for u in (v.x1, v.x2, v.x3)),
        )


@fl.model
class Landing(MechanicalModel):
    """A block that may lift off its belt, and that a stop holds back: 7 modes."""

    k: float = fl.parameter(4.0, unit="N/m", symbol="k", meaning="stiffness", range=(0.1, 10.0))
    friction: FrictionLaw = fl.Coulomb(mu_k=0.5, mu_s=1.0)
    impact: ImpactLaw = fl.PlasticImpact("full")
    coordinates = ("x", "y")

    def mechanics(self, q, v):
        friction = Friction(0.3 - v.x, -30 * q.y, self.friction, -q.y)
        return Mechanics(
            kinetic=(v.x**2 + v.y**2) / 2,
            potential=self.k * q.x**2 / 2 + 0.8 * q.x * q.y + q.y**2 / 2 + q.y,
            contacts=(friction, Stop(0.4 - q.x, self.impact)),
        )


TWO, THREE = (fl.TwoBlocks(), [0.1, 0.0, 0.0, 0.0]), (ThreeBlocks(), [0.1, -0.2, 0.4, 0.0, 0.3, 0.0])
SCENES = pytest.mark.parametrize(("model", "x0"), [TWO, THREE], ids=["two", "three"])
ARRAYS = "step_times", "step_states", "event_times", "event_states", "state"


def fresh(model):
    """The model's automaton, of which no mode is derived yet."""
    return replace(
        automaton_of_structure.__wrapped__(model.structure_key),
        parameters=model.automaton().parameters,
    )


@cache
def all_modes(key):
    """The automaton of a structure, all of whose modes are derived."""
    automaton = automaton_of_structure.__wrapped__(key)
    assert all(isinstance(mode, Mode) for mode in automaton.modes)
    assert set(automaton.modes.derived) == set(automaton.names)
    return automaton


def complete(model):
    """The same with all modes derived."""
    return replace(all_modes(model.structure_key), parameters=model.automaton().parameters)


def assert_same(run, other):
    for name in ARRAYS:
        assert getattr(run.raw, name).tobytes() == getattr(other.raw, name).tobytes(), name
    numbers = ((one.raw.step_modes.tolist(), one.mode_names) for one in (run, other))
    in_steps, others = ([names[i] for i in modes] for modes, names in numbers)
    assert in_steps == others
    for name in ("source", "target", "guard", "closed"):
        assert getattr(run.events, name).tolist() == getattr(other.events, name).tolist()
    assert run.status is other.status
    assert run.states.tobytes() == other.states.tobytes()
    assert dict(run.time_in_mode) == dict(other.time_in_mode)


@pytest.mark.parametrize("method", ["taylor", fl.RK4(step=5e-3), "DOP853"], ids=["taylor", "rk4", "scipy"])
@SCENES
def test_a_run_is_that_with_all_modes_to_the_last_bit(model, x0, method):
    few = fresh(model)
    run = fl.solve(few, 20.0, x0=x0, method=method)
    assert_same(run, fl.solve(complete(model), 20.0, x0=x0, method=method))
    assert set(run.mode) <= set(few.modes.derived) < set(few.names)
    assert len(run.events) > 8


@SCENES
def test_only_modes_that_may_be_entered_are_derived(model, x0):
    """At the start every block slides forwards over the belt or backwards: one mode in question."""
    few = fresh(model)
    assert few.names == complete(model).names
    assert few.modes.derived == ()
    run = fl.solve(few, 1e-3, x0=x0)
    assert few.modes.derived == (run.mode[0],)
    assert few.outputs == tuple(few.modes[few.names.index(run.mode[0])].outputs)
    assert len(few.modes.derived) == 1


def test_how_many_modes_are_derived():
    few = fresh(THREE[0])
    run = fl.solve(few, 50.0, x0=THREE[1])
    visited = {*run.mode, *run.events.target}
    assert visited <= set(few.modes.derived)
    assert len(few.names) == 27
    assert len(few.modes.derived) <= 16


@SCENES
def test_sections_and_quadratures_ride_along(model, x0):
    asked = {
        "sections": {"turn": model.automaton().states[len(x0) // 2], "force": ("friction_force_1", 0)},
        "quadratures": {"travel": "relative_velocity_1"},
    }
    run, other = (fl.solve(make(model), 15.0, x0=x0, **asked) for make in (fresh, complete))
    assert_same(run, other)
    assert run.quadratures == other.quadratures
    for name in ("turn", "force"):
        assert run.sections[name].t.tobytes() == other.sections[name].t.tobytes()
    assert len(run.sections["turn"].t) > 1


@SCENES
def test_a_run_goes_on_from_modes_derived_by_others(model, x0):
    one, other = fresh(model), fresh(model)
    fl.solve(one, 30.0, x0=-np.array(x0))
    assert_same(fl.solve(one, 20.0, x0=x0), fl.solve(other, 20.0, x0=x0))


@pytest.mark.parametrize("x0", [[-0.5, -1.5, 3.0, 0.0], [0.3, 0.2, 0.5, -0.5]])
def test_with_gaps_and_stops_as_well(x0):
    few = fresh(Landing())
    run = fl.solve(few, 6.0, x0=x0)
    assert_same(run, fl.solve(complete(Landing()), 6.0, x0=x0))
    assert {"gap_1", "impact_2", "off_2", "v_r_1"} <= set(run.events.guard)
    assert len(few.names) == 7
    assert len(few.modes.derived) < 7


@pytest.mark.parametrize("start", [[0.0, 0.0], [0.3, 0.2], [1.0, -0.7]], ids=["rest", "carried", "free"])
@pytest.mark.parametrize("model", [TWO[0], THREE[0]], ids=["two", "three"])
def test_events_at_one_instant(model, start):
    """Blocks that start alike: all reach the belt's speed together."""
    x0, few = np.repeat(start, len(model.coordinates)), fresh(model)
    assert_same(fl.solve(few, 20.0, x0=x0), fl.solve(complete(model), 20.0, x0=x0))


def test_the_mode_asked_for_is_derived():
    model, x0 = TWO
    few = fresh(model)
    run = fl.solve(few, 0.1, x0=x0, mode="slip+ | slip+")
    assert run.mode[0] == "slip+ | slip+"
    assert few.modes.derived == ("slip+ | slip+",)


@pytest.mark.parametrize("mode", ["stick | stick", "slip- | slip+"])
def test_a_mode_that_cannot_be_entered_is_refused(mode):
    for automaton in (fresh(TWO[0]), complete(TWO[0])):
        with pytest.raises(ValueError, match="cannot start in mode '" + mode.replace("|", r"\|")):
            fl.solve(automaton, 1.0, x0=TWO[1], mode=mode)


def test_an_unknown_mode_is_refused_before_any_is_derived():
    few = fresh(TWO[0])
    with pytest.raises(ValueError, match=r"mode must be one of 'stick \| stick'.*did you mean"):
        fl.solve(few, 1.0, x0=TWO[1], mode="slip+ | stik")
    assert few.modes.derived == ()


@SCENES
def test_a_saved_run_comes_back(model, x0, tmp_path):
    run = fl.solve(fresh(model), 20.0, x0=x0)
    for automaton in (fresh(model), complete(model)):
        assert_same(fl.load(run.save(tmp_path / "run"), automaton), run)
    whole = fl.solve(complete(model), 20.0, x0=x0)
    assert_same(fl.load(whole.save(tmp_path / "whole"), fresh(model)), run)


def test_pickled_they_are_derived_again_where_they_are_used():
    """A pickle has as little to hold as the modes are known, however many there are."""
    few = fresh(THREE[0])
    run = fl.solve(few, 20.0, x0=THREE[1])
    text = pickle.dumps(few.modes)
    assert len(text) < 1000
    assert pickle.loads(text) is automaton_of_structure(THREE[0].structure_key).modes
    assert_same(pickle.loads(pickle.dumps(run)), run)


def test_they_are_a_sequence_that_remembers():
    modes = fresh(TWO[0]).modes
    assert modes[-1] is modes[8]
    assert modes[:2] == (modes[0], modes[1])
    assert modes.known().modes == (modes[8], modes[0], modes[1])
    assert modes.known().combinations == ((2, 2), (0, 0), (0, 1))
    for index in (9, -10):
        with pytest.raises(IndexError, match="no mode number"):
            _ = modes[index]
    assert len(list(modes)) == len(modes) == 9
    assert len(modes.known().modes) == 9
    assert TWO[0].automaton().modes is TWO[0].replace(v=0.3).automaton().modes


def test_names_are_a_sequence_made_as_they_are_read():
    names, others = fresh(TWO[0]).names, fresh(ThreeBlocks()).names
    assert names[:4] == ("stick | stick", "stick | slip+", "stick | slip-", "slip+ | stick")
    assert names[-1] == "slip- | slip-"
    assert names.index("slip+ | stick") == names.place_of("slip+ | stick") == 3
    assert "slip+ | slip" not in names
    assert "slip+" not in names
    assert names == tuple(names)
    assert names != others
    assert hash(names) == hash(fresh(TWO[0]).names)
    assert repr(names) == "stick/slip+/slip- | stick/slip+/slip-"


def test_samples_have_all_regimes_of_modes():
    part = tuple(map(Regime, "abc"))
    names = names_of_parts((part, part), lambda combination: combination not in {(0, 0), (2, 2)})
    modes = ModesOnDemand((part, part), lambda combination: Mode(names.name_of(combination), ()), names)
    pairs = [mode.name.split(" | ") for mode in modes.samples()]
    assert [{*some} for some in zip(*pairs, strict=True)] == [{*"abc"}] * 2


def test_threads_are_given_one_mode():
    part = (Regime("a"), Regime("b"))
    modes = ModesOnDemand((part,), lambda combination: Mode(part[combination[0]].name, ()))
    with ThreadPoolExecutor(8) as pool:
        found = list(pool.map(modes.__getitem__, [0, 1] * 100))
    assert {id(mode) for mode in found} == {id(modes[0]), id(modes[1])}


def test_one_contact_has_all_its_modes_at_once():
    assert isinstance(fl.MassOnBelt().automaton().modes, tuple)
    assert isinstance(fl.DenHartog().automaton().modes, tuple)


@dataclass
class Bar:
    """A progress bar whose user has pressed ctrl-C, or has not."""

    stop: bool

    def update(self, t):
        return self.stop


@pytest.mark.parametrize("method", [fl.Taylor(), fl.RK4(step=5e-3), fl.Scipy("RK45")], ids=lambda m: m.name)
def test_ctrl_c_keeps_what_was_computed_where_a_mode_is_missing(method):
    model, x0 = TWO
    automaton = fresh(model)
    problem = problem_of(automaton, np.array(x0), 20.0)
    raw = method.integrate(problem, method.order_of(problem.program), Bar(stop=True))
    run = fl.solve(complete(model), 20.0, x0=x0, method=method)
    assert raw.status is fl.Status.INTERRUPTED
    assert raw.t == run.events.t[0]
    assert raw.state.tolist() == run.events.before[0].tolist()
    assert automaton.modes.derived == ("slip+ | slip+",)
    assert raw.mode == 0
    assert len(raw.event_times) == 0
    problem = problem_of(automaton, np.array(x0), 20.0)
    raw = method.integrate(problem, method.order_of(problem.program), Bar(stop=False))
    assert raw.state.tolist() == run.final_state.tolist()


def test_runs_in_threads_share_the_modes():
    few, (model, x0) = fresh(THREE[0]), THREE

    def run(v):
        return fl.solve(few.replace(v=v), 20.0, x0=x0)

    speeds = [0.1, 0.2, 0.3, 0.4]
    alone = {v: fl.solve(complete(model.replace(v=v)), 20.0, x0=x0) for v in speeds}
    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(run, speeds * 2))
    for v, other in zip(speeds * 2, found, strict=True):
        assert_same(other, alone[v])


def test_a_steady_state_derives_few():
    model, x0 = THREE
    before = set(automaton_of_structure(model.structure_key).modes.derived)
    found = fl.steady_state(model, x0=x0, transient=20.0, window=20.0, progress=False)
    derived = set(automaton_of_structure(model.structure_key).modes.derived)
    assert set(found.trajectory.mode) <= derived
    assert len(derived - before) < 20
