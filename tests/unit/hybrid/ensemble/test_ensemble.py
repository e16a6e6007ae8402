"""Many runs side by side: each as it would be alone, to the last bit."""

from threading import Event as Sign
from time import sleep

import numpy as np
import pytest
import sympy as sp

import frictionlab as fl
from frictionlab.analysis.ensemble import advance_group, start_group
from frictionlab.automaton import Event, HybridAutomaton, Mode, Reset
from frictionlab.hybrid.codegen import native_cache
from frictionlab.hybrid.ensemble.arrays import select_runs
from frictionlab.hybrid.ensemble.batch import advance_batch
from frictionlab.interruption import Progress
from frictionlab.tape.packing import program_of
from tests.differential.laws import Smooth
from tests.helpers.automata import ball
from tests.helpers.cases import slow_but
from tests.helpers.laws import Undefined

FULL = fl.SliderOnBelt(mu_k=1.4, impact=fl.PlasticImpact("full"))
SCENES = {
    "stick, slip and separation": FULL,
    "without the moving load": FULL.without("geometry"),
    "chatter": fl.SliderOnBelt(mu_k=1.4),
    "sliding only": FULL.without("nonsmooth"),
    "linear": FULL.without("cubic", "nonsmooth", "geometry"),
}
MU = np.linspace(0.2, 1.1, 11)  # sliding only goes beyond all bounds from rest where it is larger


def compiled(model):
    """Have the code of all modes at hand, so that lanes are used from the first step."""
    automaton = model if isinstance(model, HybridAutomaton) else model.automaton()
    native = native_cache.native_code(program_of(automaton)[0])
    for mode in range(len(native.code.lanes)) if native_cache.machine_code.HAS_MACHINE_CODE else ():
        if not native.code.lanes[mode]:
            native.compile_step(mode)
        assert native.code.lanes[mode]


@pytest.mark.plain_python
@pytest.mark.parametrize("name", slow_but(["stick, slip and separation", "linear"], SCENES))
def test_each_run_is_what_it_would_be_alone(name):
    compiled(SCENES[name])
    models = [SCENES[name].replace(mu_k=float(mu)) for mu in MU]
    t_end = 0.03 if not native_cache.machine_code.HAS_MACHINE_CODE else 5.0
    ends = fl.ensemble(models, t_end, progress=False)
    for i, model in enumerate(models):
        run = fl.simulate(model, t_end, progress=False)
        np.testing.assert_array_equal(ends.states[i], run.final_state)
        assert (ends.steps[i], ends.events[i]) == (run.stats["steps"], len(run.events))
        assert ends.status[i] is run.status
        assert ends.t[i] == run.t[-1]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["stick, slip and separation", "sliding only"])
def test_one_code_of_lanes_serves_every_order(name):
    compiled(SCENES[name])
    models = [SCENES[name].replace(mu_k=float(mu)) for mu in MU[:5]]
    native = native_cache.native_code(program_of(models[0].automaton())[0])
    addresses = native.code.lanes.copy()
    for order in range(4, 61):
        t_end, method = (0.05 if order < 9 else 0.3), fl.Taylor(order=order)
        ends = fl.ensemble(models, t_end, method=method, progress=False)
        for i, model in enumerate(models):
            alone = fl.simulate(model, t_end, method=method, progress=False)
            np.testing.assert_array_equal(ends.states[i], alone.final_state)
            assert ends.steps[i] == alone.stats["steps"]
    np.testing.assert_array_equal(native.code.lanes, addresses)


def test_lanes_with_powers_serve_every_order():
    """Runs by themselves do not ask for such lanes; the benchmark has them compiled."""
    x, y, a = sp.symbols("x y a")
    spring = Mode("m", (y, -x * (1 + x**2) ** a), (), ())
    automata = [HybridAutomaton((x, y), (spring,), {a: value}, 1) for value in (0.2, 0.3, 0.4, 0.5)]
    compiled(automata[0])
    for order in (4, 9, 20, 33, 60):
        method, t_end = fl.Taylor(order=order), 0.05 if order < 9 else 0.5
        ends = fl.ensemble(automata, t_end, x0=[1.0, 0.5], method=method, progress=False)
        for automaton, end in zip(automata, ends.states):
            alone = fl.solve(automaton, t_end, x0=[1.0, 0.5], method=method, progress=False)
            np.testing.assert_array_equal(end, alone.final_state)


WIDTHS = (1.0, 0.1, 1e-3)  # of friction layers, m/s
TOLS = (1e-15, 1e-9, 1e-4)
MU_OF_LAYERS = {"mu_k": 0.5, "mu_s": 1.0}


def layered(name, width):
    """Models of one structure, their initial states, and the length of their runs."""
    if name == "slider":
        law = fl.ExponentialDecay(v_s=2.0 * width, **MU_OF_LAYERS)
        model = fl.SliderOnBelt(friction=law, interface=fl.SlidingOnly())
        return [model.replace(mu_k=float(mu)) for mu in np.linspace(0.2, 0.9, 6)], "rest", 0.3
    if name == "Den Hartog":
        models = [fl.DenHartog(Omega=float(w), N=0.3) for w in np.linspace(0.3, 1.5, 6)]
        return models, "rest", 40.0
    kinds = {"Stribeck": fl.Stribeck, "exponential": fl.ExponentialDecay, "tanh": Smooth}
    model = fl.MassOnBelt(c=0.02, friction=kinds[name](v_s=width, **MU_OF_LAYERS))
    starts = np.random.default_rng(1).normal(size=(6, 2))
    return [model.replace(v=float(v)) for v in np.linspace(0.2, 2.0, 6)], starts, 20.0


@pytest.mark.parametrize("width", slow_but([1e-3], WIDTHS))
@pytest.mark.parametrize("name", slow_but(["tanh"], ["Stribeck", "exponential", "tanh", "slider"]))
def test_steps_heed_friction_layers_as_those_of_a_run_alone(name, width):
    same_as_alone(*layered(name, width))


@pytest.mark.slow  # sine and cosine are among those of the next test
def test_steps_heed_functions_of_the_phase_as_those_of_a_run_alone():
    same_as_alone(*layered("Den Hartog", 1.0))


def same_as_alone(models, starts, t_end):
    """At all tolerances, from the orders that polynomials of high degree share with other functions."""
    compiled(models[0])
    each = [starts] * len(models) if isinstance(starts, str) else starts
    for tol in TOLS:
        method = fl.Taylor(tol=tol)
        ends = fl.ensemble(models, t_end, x0=starts, method=method, progress=False)
        for i, (model, start) in enumerate(zip(models, each)):
            alone = fl.simulate(model, t_end, x0=start, method=method, progress=False)
            np.testing.assert_array_equal(ends.states[i], alone.final_state)
            assert (ends.steps[i], ends.events[i]) == (alone.stats["steps"], len(alone.events))


def every_function():
    """A mode with each function of the tape, a quotient and a power, and parameters that set their scales."""
    x, y, a, p = sp.symbols("x y a p")
    bounded = (
        sp.tanh(a * x) + sp.sin(a * y) * sp.cos(x) + sp.atan(a * x) / (1 + y**2) + sp.exp(-((a * x) ** 2))
    )
    grown = sp.log(2 + sp.cosh(y / 3)) - sp.sinh(x / 3) + sp.tan(y / (2 + x**2 + y**2)) + (1 + x**2) ** p
    return HybridAutomaton(
        (x, y), (Mode("m", (y, -x - y / 2 + bounded / 4 - grown / 8), (), ()),), {a: 1.0, p: 0.3}, 1
    )


@pytest.mark.slow
def test_steps_heed_every_function_as_those_of_a_run_alone():
    scene = every_function()
    automata = [scene.replace(a=a) for a in (0.3, 1.0, 3.0, 10.0, 100.0)]
    compiled(scene)
    for tol in TOLS:
        method = fl.Taylor(tol=tol)
        ends = fl.ensemble(automata, 10.0, x0=[1.0, 0.5], method=method, progress=False)
        for automaton, end, steps in zip(automata, ends.states, ends.steps):
            alone = fl.solve(automaton, 10.0, x0=[1.0, 0.5], method=method, progress=False)
            np.testing.assert_array_equal(end, alone.final_state)
            assert steps == alone.stats["steps"]


@pytest.mark.parametrize("name", slow_but(["peak", "pole"], ["peak", "waves", "pole"]))
def test_guards_that_change_fast_are_those_of_a_run_alone(name):
    """They ask for far shorter steps than the states, down to what the clock resolves beside a pole."""
    x, v, a = sp.symbols("x v a")
    guards = {
        "peak": 2 - a * sp.exp(-((500 * (x - sp.Rational(1, 2))) ** 2)),
        "waves": a + sp.Rational(1, 4) + sp.sin(90 * x),
        "pole": 3 * a - 1 / (1 + 100 * x) ** 2,
    }
    hit = Event("hit", guards[name], ("m",), Reset({v: -v}))
    modes = (Mode("m", (v, -x), (hit,)),)
    automata = [HybridAutomaton((x, v), modes, {a: value}, 1) for value in np.linspace(0.7, 2.3, 6)]
    compiled(automata[0])
    for tol in TOLS:
        method = fl.Taylor(tol=tol)
        ends = fl.ensemble(automata, 6.0, x0=[0.1, 1.0], method=method, progress=False)
        assert ends.events.max() > 0
        for i, automaton in enumerate(automata):
            alone = fl.solve(automaton, 6.0, x0=[0.1, 1.0], method=method, progress=False)
            np.testing.assert_array_equal(ends.states[i], alone.final_state)
            assert (ends.steps[i], ends.events[i]) == (alone.stats["steps"], len(alone.events))


@pytest.mark.plain_python
@pytest.mark.parametrize("powers", slow_but([(1,), (3,)], [(1,), (3,), (3, 30)]))
def test_guards_that_begin_with_zeros_are_those_of_a_run_alone(powers):
    """Of y^3 at y = 0 three coefficients are zero, of y^30 all: the next mode is known by later orders or by
    none."""
    t, y, a = sp.symbols("t y a")
    back = Event("over", 2 - t, ("waits",), Reset({t: sp.S.Zero, y: sp.S.Zero}))
    flat = tuple(Event(f"power {n}", y**n, ("waits",)) for n in powers)
    waits = Mode("waits", (a, sp.S.Zero), (Event("goes", 1 - t, ("goes",)),))
    goes = Mode("goes", (a, a * sp.Rational(3, 2)), (*flat, back))
    automata = [HybridAutomaton((t, y), (waits, goes), {a: value}, 1) for value in np.linspace(0.7, 1.9, 7)]
    compiled(automata[0])
    ends = fl.ensemble(automata, 20.0, x0=[0.5, 0.0], progress=False)
    for i, automaton in enumerate(automata):
        alone = fl.solve(automaton, 20.0, x0=[0.5, 0.0], progress=False)
        np.testing.assert_array_equal(ends.states[i], alone.final_state)
        assert (ends.steps[i], ends.events[i]) == (alone.stats["steps"], len(alone.events))
        assert ends.events[i] > 10


def test_runs_end_on_the_constraints_of_their_own_numbers():
    """Those that stick have the speeds of their belts."""
    models = [fl.MassOnBelt(v=v, N=N) for v in (0.1, 0.2, 0.3) for N in (5.0, 10.0, 15.0)]
    ends = fl.ensemble(models, 2.0, progress=False)
    runs = [fl.simulate(model, 2.0, progress=False) for model in models]
    np.testing.assert_array_equal(ends.states, [run.final_state for run in runs])
    assert len(set(ends.states[ends.modes == ends.mode_names.index("stick"), 1].round(12))) > 1


def test_the_grouping_makes_no_difference():
    compiled(FULL)
    models = [FULL.replace(mu_k=float(mu)) for mu in MU]
    whole, shared = (fl.ensemble(models, 5.0, workers=n, progress=False) for n in (1, 3))
    parts = [fl.ensemble(models[i : i + 4], 5.0, progress=False).states for i in range(0, len(models), 4)]
    np.testing.assert_array_equal(whole.states, np.concatenate(parts))
    np.testing.assert_equal(vars(shared), vars(whole))


def test_an_error_in_one_thread_ends_the_others(monkeypatch):
    stopped = Sign()

    def advance(group, t_end, bar):
        if group.runs.states[0, 0] == 0.0:
            raise ArithmeticError("by design")
        for _ in range(500):
            if bar.stopped:
                return stopped.set()
            sleep(0.01)

    monkeypatch.setattr("frictionlab.analysis.ensemble.advance_batch", advance)
    states = [[0.0, 0.0], [1.0, 0.0]]
    with pytest.raises(ArithmeticError, match="by design"):
        fl.ensemble([fl.MassOnBelt()] * 2, 1.0, x0=states, workers=2, progress=False)
    assert stopped.wait(10.0)


def test_many_initial_states_of_one_model():
    states = np.random.default_rng(0).normal(scale=1e-3, size=(9, 10))
    ends = fl.ensemble([FULL] * 9, 1.0, x0=states, progress=False)
    for start, end in zip(states, ends.states):
        np.testing.assert_array_equal(fl.simulate(FULL, 1.0, x0=start, progress=False).final_state, end)


def test_runs_that_go_on_do_not_depend_on_those_that_are_left():
    compiled(FULL)
    states = np.random.default_rng(0).normal(scale=1e-3, size=(24, 10))
    whole, part = (start_group(FULL.automaton(), states, fl.Taylor()) for _ in range(2))
    some = np.array([0, 3, 4, 11, 12, 23])
    for t in (0.5, 0.7, 2.0):
        advance_group(whole, t)
        advance_group(part, t)
        part = select_runs(part, some) if t == 0.5 else part
    assert (part.runs.times[:, 0] == 2.0).all()
    np.testing.assert_array_equal(part.runs.states, whole.runs.states[some])
    np.testing.assert_array_equal(part.runs.totals, whole.runs.totals[some])
    assert (part.runs.totals[:, 1] > 20).all()
    for i in some[:3]:
        alone = fl.simulate(FULL, 2.0, x0=states[i], progress=False).final_state
        np.testing.assert_allclose(whole.runs.states[i], alone, rtol=0, atol=1e-9 * np.abs(states).max())


def test_a_run_goes_on_from_an_event_at_the_very_time_of_a_look():
    """From height 1 with g = 2 a ball lands after 1 s, and again 1 s later as it leaves at half its speed."""
    heights = np.array([1.0, 1.0, 9.0, 1.0])
    group = start_group(ball().replace(g=2.0), np.column_stack([heights, 0 * heights]), fl.Taylor())
    for t, height in ((1.0, 0.0), (1.5, 0.25), (2.0, 0.0), (2.25, 0.0625)):
        advance_group(group, t)
        exact = np.where(heights > 1, 9 - t**2, height)
        np.testing.assert_allclose(group.runs.states[:, 0], exact, rtol=0, atol=1e-14)
    assert group.runs.totals[:, 1].tolist() == [2, 2, 0, 2]


class StopAtOnce(Progress):
    def update(self, value: float) -> bool:
        return True


@pytest.mark.plain_python
def test_runs_that_are_stopped_have_come_about_as_far_whatever_their_mode(monkeypatch):
    """Ten runs fill the lanes of their mode for ever, four that of another mode in part, one is alone."""
    monkeypatch.setattr("frictionlab.hybrid.ensemble.batch.STEPS_PER_ROUND", 20_000)
    x, v, s = sp.symbols("x v s")
    rates = (v, -x - x**3, sp.S.Zero)
    guards = {"low": 1 - s, "middle": (s - 1) * (3 - s), "high": s - 3}
    modes = tuple(Mode(name, rates, (Event("leaves", guard, (name,)),)) for name, guard in guards.items())
    automaton = HybridAutomaton((x, v, s), modes, {}, 1)
    compiled(automaton)
    states = np.array([[1.0, 0.0, s] for s, count in ((0.0, 4), (2.0, 10), (4.0, 1)) for _ in range(count)])
    group = start_group(automaton, states, fl.Taylor())
    advance_batch(group, 1e6, StopAtOnce(1e6, False))
    steps = group.runs.totals[:, 0]
    assert 100 < steps.max() < 8 * steps.min()


def test_groups_too_small_for_a_second_round_have_their_steps_compiled():
    if not native_cache.machine_code.HAS_MACHINE_CODE:
        pytest.skip("there is nothing to compile")
    scene = FULL.without("geometry").automaton()
    native = native_cache.native_code(program_of(scene)[0])
    native.forget()
    fl.ensemble([scene] * 6, 60.0, x0=np.full(8, 1e-4), progress=False)
    for waiting in native.requested.values():
        waiting.result()
    assert native.code.lanes.any()


def test_each_ends_with_its_own_status():
    # without any of them the linear model grows without bound where mu_k is large
    models = [SCENES["linear"].replace(mu_k=mu) for mu in (0.1, 2.9, 0.2, 2.8)]
    ends = fl.ensemble(models, 3e3, progress=False)
    alone = [fl.simulate(model, 3e3, progress=False).status for model in models]
    assert list(ends.status) == alone
    assert len(set(alone)) == 2


def test_caps_hold_for_each():
    ends = fl.ensemble([FULL] * 5, 20.0, method=fl.Taylor(max_steps=100), progress=False)
    assert set(ends.status) == {fl.Status.STEP_CAP}
    assert (ends.steps == 100).all()


@pytest.mark.plain_python
def test_a_law_that_is_no_number_ends_the_runs():
    model = fl.MassOnBelt(friction=Undefined(mu_k=0.3, mu_s=0.5, limit=0.0), v=1.0)
    compiled(model)
    starts = np.linspace([0.1, -1.0], [0.5, -2.0], 6)
    batch = fl.ensemble([model] * 6, 20.0, x0=starts, progress=False)
    assert set(batch.status) == {fl.Status.NOT_FINITE}
    np.testing.assert_array_equal(batch.states, starts)


@pytest.mark.parametrize("starts", [["rest", [0.0, 1.0]], [{"x": 1.0}, [0.0, 1.0]], ("rest", {"x": 1.0})])
def test_each_run_may_have_an_initial_state_of_another_kind(starts):
    model = fl.MassOnBelt()
    ends = fl.ensemble([model, model], 1.0, x0=starts, progress=False)
    for end, start in zip(ends.states, starts):
        assert end.tolist() == fl.simulate(model, 1.0, x0=start, progress=False).final_state.tolist()
