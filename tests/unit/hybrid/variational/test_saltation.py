"""Fundamental matrices against closed forms, the matrix exponential, and finite differences of the flow."""

from copy import copy

import numpy as np
import pytest
import sympy as sp
from scipy.linalg import expm

import frictionlab as fl
from frictionlab.hybrid.variational.tangent_flow import end_rates, tangent_growth
from frictionlab.hybrid.variational.tangent_jets import EventCrossing, saltation
from frictionlab.tape.packing import program_of
from tests.helpers.automata import ONCE, V, X, automaton, ball, clock, coulomb, oscillator

STEPS = (1e-4, 1e-5, 1e-6, 1e-7)
# A central difference with step h errs by c h^2, and by rounding errors of the flow, some 1e-15, over h.
AGREES = 1e-8
FLAT = fl.SliderOnBelt(mu_k=1.4).without("geometry")
MODELS = {
    "plastic": FLAT,
    "moving load": fl.SliderOnBelt(mu_k=1.4, impact=fl.PlasticImpact("full")),
    "restitution": fl.SliderOnBelt(mu_k=1.4, impact=fl.RestitutionImpact(e=0.3)).without("geometry"),
}
BELT = coulomb(0.2, 1.0, 0.5)


def flow(scene, t_end):
    return lambda z: fl.solve(scene, t_end, x0=z, progress=False)


def scale(z, coordinates):
    """Coordinates of the slider move by centimetres, velocities by metres per second."""
    return np.where(np.arange(len(z)) < coordinates, 1e-2, 1.0)


def deviation(scene, z, t_end, size, directions=None):
    """Least deviation of the matrix from central differences of several steps, as a share of the matrix."""
    directions = np.diag(size) if directions is None else directions
    final = flow(scene, t_end)
    exact = fl.tangent_flow(final(z)).matrix @ directions / size[:, None]

    def differences(h):
        ends = [
            final(z + h * column).final_state - final(z - h * column).final_state for column in directions.T
        ]
        return np.column_stack(ends) / (2 * h) / size[:, None]

    return min(np.abs(exact - differences(h)).max() for h in STEPS) / np.abs(exact).max()


def linear_matrix(scene):
    field = sp.Matrix(scene.modes[0].flow).subs(dict(scene.parameters))
    return np.array(field.jacobian(scene.states), dtype=float)


@ONCE
@pytest.mark.parametrize("t_end", [0.1, 1.0, 20.0])
def test_an_oscillator_turns(t_end):
    found = fl.tangent_flow(fl.solve(oscillator(), t_end, x0=[0.3, -2.0])).matrix
    c, s = np.cos(t_end), np.sin(t_end)
    assert found == pytest.approx(np.array([[c, s], [-s, c]]), abs=1e-13)


@pytest.mark.parametrize("start", ["rest", "near", "equilibrium"])
@pytest.mark.parametrize("t_end", [0.3, 10.0])
def test_a_linear_scene_is_the_exponential_of_its_matrix(start, t_end):
    model = fl.SliderOnBelt(mu_k=0.7).without("cubic", "nonsmooth", "geometry")
    # At the equilibrium nothing moves: the state's own series would allow a step of any length.
    x0 = np.append(fl.equilibrium(model).q, np.zeros(4)) if start == "equilibrium" else start
    found = fl.tangent_flow(fl.simulate(model, t_end, x0=x0)).matrix
    exact = expm(linear_matrix(model.automaton()) * t_end)
    assert np.abs(found - exact).max() < 1e-11 * np.abs(exact).max()


@ONCE
def test_every_operation_of_the_tape_has_its_variational_equation():
    """x' = x^2 has x0/(1 - x0 t); y' = -y/(2 + z)^2 with z = t and w' = 1/w have closed forms too."""
    y, z, w = sp.symbols("y z w")
    mode = fl.Mode("only", (X**2, -y / (2 + z) ** 2, sp.S.One, 1 / w))
    scene = automaton(mode, states=(X, y, z, w), coordinates=0)
    x0, y0, z0, w0, t = 0.5, 1.3, 0.4, 0.8, 1.1
    found = fl.tangent_flow(fl.solve(scene, t, x0=[x0, y0, z0, w0])).matrix
    decay = np.exp(1 / (2 + z0 + t) - 1 / (2 + z0))
    exact = np.diag([(1 - x0 * t) ** -2, decay, 1.0, w0 / np.sqrt(w0**2 + 2 * t)])
    exact[1, 2] = y0 * decay * (1 / (2 + z0) ** 2 - 1 / (2 + z0 + t) ** 2)
    assert found == pytest.approx(exact, rel=1e-13, abs=1e-14)


def test_the_variational_equation_of_a_cubic_contact():
    model = fl.SliderOnBelt(mu_k=2.5, k_nl=1e7, F=800.0, k4=5e6, k5=5e6, k6=5e6).without("nonsmooth")
    z = fl.simulate(model, 0.7).final_state
    assert deviation(model.automaton(), z, 0.2, scale(z, 5)) < AGREES


@ONCE
@pytest.mark.parametrize("e", [1.0, 0.5])
def test_the_saltation_of_a_bounce_has_a_closed_form(e):
    run = fl.solve(ball().replace(e=e), 1.0, x0=[1.0, 0.3])
    found = fl.tangent_flow(run)
    assert found.events.target.tolist() == ["flight"] * len(found.saltations)
    for matrix, (_, rate) in zip(found.saltations, run.events.before):
        assert matrix == pytest.approx(np.array([[-e, 0.0], [-(1 + e) * 9.81 / rate, -e]]), rel=1e-12)
    # Each bounce scales areas by e^2, flight keeps them.
    assert np.linalg.det(found.matrix) == pytest.approx(e ** (2 * len(run.events)), rel=1e-11)


ONE_EVENT = {  # state, end, event
    "switch of slip direction": ([-5.0, 0.1], 0.5, "+ -> -"),
    "onset of stick": ([0.3, -0.4], 3.0, "+ -> stick"),
}


@ONCE
@pytest.mark.parametrize("kind", ONE_EVENT)
def test_one_event_of_a_mass_on_a_belt(kind):
    z, t_end, event = ONE_EVENT[kind]
    run = fl.solve(BELT, t_end, x0=z)
    assert run.events.counts() == {event: 1}
    assert deviation(BELT, np.array(z), t_end, np.ones(2)) < AGREES


@ONCE
def test_stick_takes_a_dimension_and_its_end_gives_none_back():
    run = fl.solve(BELT, 8.0, x0=[0.3, -0.4])
    assert run.events.counts() == {"+ -> stick": 1, "stick -> +": 1}
    onset, end = fl.tangent_flow(run).saltations
    # Onset: the velocity is the belt's for all.  End: who is ahead by dx left dx/v earlier, and a = -0.5.
    assert onset == pytest.approx(np.array([[1.0, 0.0], [0.0, 0.0]]), abs=1e-14)
    assert end[:, 0] == pytest.approx([1.0, -0.5 / 0.2], abs=1e-12)
    assert np.linalg.matrix_rank(fl.tangent_flow(run).matrix, tol=1e-12) == 1


@ONCE
def test_in_a_run_that_starts_in_stick_perturbations_keep_sticking():
    found = fl.tangent_flow(fl.solve(BELT, 6.0, x0=[0.1, 0.2])).matrix
    slid = 6.0 - 0.9 / 0.2  # from x = 1, where f- = (0.2, 0) becomes f+ = (0.2, -0.5)
    c, s = np.cos(slid), np.sin(slid)
    assert found == pytest.approx(np.array([[c - 2.5 * s, 0.0], [-s - 2.5 * c, 0.0]]), abs=1e-12)


LONG = 1e-3  # seconds in a mode; the steps of the differences are too long for the ever shorter bounces


def stays(model, seconds=2.0):
    """Times, states and modes in the middle of each longer stay, of a motion that has settled."""
    start = fl.simulate(model, 30.0, progress=False).final_state
    run = fl.simulate(model, seconds, x0=start, progress=False)
    t = run.events.t
    chosen = np.flatnonzero(np.diff(t) > LONG)
    times = 0.5 * (t[chosen] + t[chosen + 1])
    return times, run(times), run.events.target[chosen]


def admissible_directions(scene, mode, size):
    """Perturbations that keep the mode's constraints, which are linear."""
    constraints = next(m.constraints for m in scene.modes if m.name == mode)
    if not constraints:
        return np.diag(size)
    gradient = sp.Matrix(constraints).jacobian(scene.states).subs(dict(scene.parameters))
    scaled = np.array(gradient, dtype=float) * size
    return np.diag(size) @ np.linalg.svd(scaled)[2][len(constraints) :].T


@pytest.mark.parametrize("name", MODELS)
def test_each_kind_of_event_of_the_slider(name):
    model = MODELS[name]
    scene, seen = model.automaton(), set()
    times, states, modes = stays(model)
    size = scale(states[0], len(model.coordinates))
    for t_end, z, mode in zip(np.diff(times), states, modes):
        run = flow(scene, t_end)(z)
        kind = next(iter(run.events.counts()), None)
        if len(run.events) != 1 or kind in seen:
            continue
        seen.add(kind)
        directions = admissible_directions(scene, mode, size)
        assert deviation(scene, z, t_end, size, directions) < 1e-7, kind
    # With restitution bounces come between, too many and too short to part them.
    landing = {"separation -> slip+", "slip+ -> stick"}
    expected = {"separation -> separation"} if name == "restitution" else landing
    assert {"stick -> slip+", "slip+ -> separation"} | expected <= seen


@pytest.mark.parametrize("name", ["plastic", "moving load"])
def test_a_whole_cycle_of_the_slider(name):
    model = MODELS[name]
    _, states, modes = stays(model)
    z = states[modes == "separation"][0]
    run = fl.simulate(model, 0.3, x0=z)
    assert len(run.events) >= 10
    assert deviation(model.automaton(), z, 0.3, scale(z, len(model.coordinates))) < 1e-6


def test_the_matrix_of_two_runs_in_a_row_is_the_product():
    states = stays(FLAT)[1]
    whole = fl.simulate(FLAT, 0.3, x0=states[0])
    first = fl.simulate(FLAT, 0.17, x0=states[0])
    second = fl.simulate(FLAT, 0.3 - 0.17, x0=first.final_state)
    product = fl.tangent_flow(second).matrix @ fl.tangent_flow(first).matrix
    exact = fl.tangent_flow(whole).matrix
    assert np.abs(product - exact).max() < 1e-10 * np.abs(exact).max()


def test_saved_runs_and_runs_with_riders_have_it_too(tmp_path):
    z = stays(FLAT)[1][0]
    run = fl.simulate(
        FLAT, 0.2, x0=z, sections={"turn": "relative_velocity"}, quadratures={"gap": "penetration"}
    )
    exact = fl.tangent_flow(fl.simulate(FLAT, 0.2, x0=z)).matrix
    found = fl.tangent_flow(run).matrix
    assert np.abs(found - exact).max() < 1e-11 * np.abs(exact).max()
    again = fl.tangent_flow(fl.load(run.save(tmp_path / "run"))).matrix
    assert again.tolist() == found.tolist()


def test_the_direction_of_the_flow_is_a_tangent_vector():
    """M f(z(0)) = f(z(T)), through all events."""
    model = MODELS["moving load"]
    z = stays(model)[1][0]
    run = fl.simulate(model, 1.0, x0=z)
    first, last = end_rates(run)
    found = fl.tangent_flow(run).matrix @ first
    assert np.abs((found - last) / scale(z, 5)).max() < 1e-9 * np.abs(last / scale(z, 5)).max()


@fl.model
class OnSprings(fl.MechanicalModel):
    """Balls above a table that hangs on a spring; one comes to rest on it, before the other hits it."""

    coordinates = ("table", "one", "other")

    def mechanics(self, q, v):
        law = fl.RestitutionImpact(e=0.4), fl.RestitutionImpact(e=0.3)
        stops = fl.Stop(q.one - q.table, law[0]), fl.Stop(q.other - q.table, law[1])
        kinetic = (2 * v.table**2 + v.one**2 + 0.5 * v.other**2) / 2
        return fl.Mechanics(
            kinetic, 15 * q.table**2 + 9.81 * (2 * q.table + q.one + 0.5 * q.other), contacts=stops
        )


def test_an_accumulation_that_was_closed_has_a_derivative():
    """Against differences of runs, in which the last impacts are at other times."""
    z, h = np.array([0.0, 0.2, 0.9, 0.0, 0.0, 0.0]), 1e-4
    run = fl.simulate(OnSprings(), 0.8, x0=z, progress=False)
    assert run.stats["accumulations"] > 0

    def end(z):
        return fl.simulate(OnSprings(), 0.8, x0=z, progress=False).final_state

    columns = []
    for d in np.eye(len(z)) * h:
        near, far = ([end(z + s * k * d) for s in (1, -1)] for k in (1, 2))
        columns.append((8 * (near[0] - near[1]) - (far[0] - far[1])) / (12 * h))
    assert fl.tangent_flow(run, progress=False).matrix == pytest.approx(np.array(columns).T, abs=1e-8)


def test_what_has_no_derivative_says_so():
    chatter = fl.simulate(fl.SliderOnBelt(mu_k=1.4), 2.0)
    assert chatter.stats["accumulations"] > 0
    with pytest.raises(ValueError, match=r"accumulation of events was closed.*end the run before"):
        fl.tangent_flow(chatter)
    with pytest.raises(TypeError, match="run must be a Trajectory"):
        fl.tangent_flow(FLAT)
    with pytest.raises(ValueError, match="needs a run of method 'taylor', got 'rk4'"):
        fl.tangent_flow(fl.solve(oscillator(), 1.0, x0=[1.0, 0.0], method="rk4"))


@ONCE
def test_grazing_and_coincidence_are_refused():
    double = clock(fl.Event("touch", (X - 1) ** 2, ("off",)))
    run = fl.solve(double, 2.0, x0=[0.0])
    assert run.events.target.tolist() == ["off"]
    with pytest.raises(ValueError, match="double zero"):
        fl.tangent_flow(run)
    events = fl.Event("one", 1 - X, ("off",)), fl.Event("other", (1 - V) * (2 + X), ("off",))
    both = automaton(fl.Mode("on", (sp.S.One, sp.S.One), events), fl.Mode("off", (sp.S.Zero, sp.S.Zero)))
    with pytest.raises(ValueError, match="two event functions vanish at one instant"):
        fl.tangent_flow(fl.solve(both, 2.0, x0=[0.0, 0.0]))
    one = clock(fl.Event("one", 1 - X, ("off",)), fl.Event("other", (1 - X) * (2 + X), ("off",)))
    assert fl.tangent_flow(fl.solve(one, 2.0, x0=[0.0])).matrix == 0.0  # all neighbours meet both at X = 1
    program, numbers = program_of(BELT)
    z = np.array([0.1, 0.2])
    with pytest.raises(ValueError, match="two events at one instant"):
        saltation(program, numbers, EventCrossing(2, 0, z, z, 0.0))


@ONCE
def test_an_event_where_a_run_starts_has_one_side_only_unless_the_run_goes_on():
    run = fl.solve(clock(fl.Event("touch", 1 - X, ("off",))), 2.0, x0=[1.0], mode="on")
    assert run.events.t.tolist() == [0.0]
    with pytest.raises(ValueError, match="two events at one instant"):
        fl.tangent_flow(run)
    assert tangent_growth(run, np.eye(1), np.ones(1))[1] == [-np.inf]


@ONCE
def test_a_mode_entered_by_coincidence_is_refused():
    """The hold needs x = v = 0, but only x = 0 is the event: of the neighbours none has v = 0 there."""
    hold = fl.Mode("hold", (sp.S.Zero, sp.S.Zero), (), (X, V + 1))
    fall = fl.Mode("fall", (V, sp.S.Zero), (fl.Event("floor", X, ("hold",)),))
    run = fl.solve(automaton(fall, hold), 2.0, x0=[1.0, -1.0])
    assert run.events.target.tolist() == ["hold"]
    with pytest.raises(ValueError, match="hold by a coincidence"):
        fl.tangent_flow(run)


@ONCE
def test_the_check_of_the_modes_conditions_sees_a_wrong_mode():
    run = fl.solve(BELT, 20.0, x0=[0.3, -0.4])
    wrong = copy(run)
    assert run.violation < 1e-13
    wrong.raw = run.raw._replace(step_modes=np.full_like(run.raw.step_modes, BELT.names.index("-")))
    assert wrong.violation == pytest.approx(1.0)  # v_r > 0 all along, and it should be negative


@pytest.mark.parametrize("seed", range(4))
def test_events_of_one_contact_while_another_sticks(seed):
    """Two blocks, each on the belt: what sticks before and after an event of the other is no coincidence."""
    model = fl.TwoBlocks()
    z = np.random.default_rng(seed).normal(size=4)
    run = fl.simulate(model, 20.0, x0=z)
    assert any(
        any(a == b == "stick" for a, b in zip(one.split(" | "), other.split(" | ")))
        for one, other in zip(run.events.source, run.events.target)
    )
    assert deviation(model.automaton(), z, 20.0, np.ones(4)) < AGREES


STICKING = fl.DenHartog(Omega=0.25)  # the phase begins anew in stick


@ONCE
def test_a_phase_that_begins_anew_is_no_event_of_the_motion():
    """From stick, through its end, slip and stick again, for each of some phases."""
    scene = STICKING.automaton()
    for start in (60.0, 65.0, 70.0, 75.0):
        z = fl.simulate(STICKING, start).final_state
        run = fl.solve(scene, 30.0, x0=z)
        periods = run.events.guard == "period"
        assert "stick" in run.events.source[periods]
        for matrix in fl.tangent_flow(run).saltations[periods]:
            assert matrix.tolist() == np.eye(3).tolist()
        directions = admissible_directions(scene, run.mode[0], np.ones(3))
        assert deviation(scene, z, 30.0, np.ones(3), directions) < AGREES


def test_orbits_and_exponents_where_the_phase_begins_anew_in_stick():
    orbit = fl.periodic_orbit(STICKING, fl.simulate(STICKING, 200.0))
    assert "stick > stick" in repr(orbit)
    sizes = np.sort(np.abs(orbit.multipliers))
    assert sizes[0] < 1e-12  # stick forgets
    assert sizes[2] == pytest.approx(1.0, abs=1e-9)
    found = fl.lyapunov(STICKING, t_end=40 * orbit.period).exponents
    assert found[:2] == pytest.approx([0.0, np.log(sizes[1]) / orbit.period], abs=1e-3)
    assert found[2] == -np.inf


@ONCE
def test_the_phase_begins_anew_at_the_instant_of_another_event():
    """A ball bounces at t = 1, and so ends the period of a clock, in either order."""
    phase = sp.Symbol("phase")
    period = fl.Event("period", 1 - phase, ("air",), fl.Reset({phase: phase - 1}))
    bounce = fl.Event("floor", X, ("air",), fl.Reset({V: -V / 2}))
    for events in ((period, bounce), (bounce, period)):
        air = fl.Mode("air", (V, sp.Integer(-2), sp.S.One), events)
        run = fl.solve(automaton(air, states=(X, V, phase)), 1.5, x0=[1.0, 0.0, 0.0])
        assert sorted(run.events.guard) == ["floor", "period"]
        matrices = dict(zip(run.events.guard, fl.tangent_flow(run).saltations))
        assert matrices["period"].tolist() == np.eye(3).tolist()
        exact = np.array([[-0.5, 0.0, 0.0], [1.5, -0.5, 0.0], [0.0, 0.0, 1.0]])  # -g (1 + e)/v, v = -2
        assert matrices["floor"] == pytest.approx(exact, abs=1e-12)
