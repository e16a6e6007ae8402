"""Periodic orbits and their multipliers: closed forms, Liouville's formula, differences of the return map."""

from dataclasses import dataclass
from itertools import product

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp
from scipy.special import ellipk

import frictionlab as fl
from frictionlab.analysis.orbits.pseudo_arclength import with_parameter_as_state
from frictionlab.automaton.modes_on_demand import ModesOnDemand
from tests.helpers.automata import V, X, automaton, ball, coulomb, oscillator
from tests.helpers.cases import slow_but
from tests.helpers.known_motions import FLAT, TILTED, W, bistable
from tests.helpers.mode_coupling_cycle import by_differences, cycle
from tests.reference.phases import until_events

BELT = coulomb(0.2, 1.0, 0.5)


def circle(direction):
    """Radius' = +- radius (1 - radius^2) in a plane that turns once in 2 pi; a third state dies with e^-t."""
    grow = sp.Symbol("direction") * (1 - X**2 - V**2)
    flow = (X * grow - V, V * grow + X, -W)
    return automaton(fl.Mode("only", flow), states=(X, V, W), coordinates=0, direction=direction)


def van_der_pol(mu, time=1):
    """With time = -1 the same orbit backwards."""
    strength, sense = sp.symbols("mu sense")
    flow = (sense * V, sense * (strength * (1 - X**2) * V - X))
    return automaton(fl.Mode("only", flow), coordinates=0, mu=mu, sense=time)


def hysteresis():
    """Two modes that are both admissible where |x| < 5: circles of radius 1 in 2 pi and in 2 pi / 3."""

    def mode(name, speed, room, other):
        grow = 1 - X**2 - V**2
        return fl.Mode(
            name, (X * grow - speed * V, V * grow + speed * X), (fl.Event("leaves", room, (other,)),)
        )

    scale = sp.Symbol("scale")
    return automaton(
        mode("slow", scale, 5 - X, "fast"), mode("fast", 3 * scale, 5 + X, "slow"), coordinates=0, scale=1.0
    )


def multipliers(orbit):
    """Without that along the orbit, the largest first."""
    return np.delete(orbit.multipliers, np.argmin(np.abs(orbit.multipliers - 1)))


GUESSES = {
    "state": lambda: [0.5, 0.1],
    "stick": lambda: [0.0, 0.2],
    "run": lambda: fl.solve(BELT, 50.0, x0=[0.0, 0.2]),
    "steady state": lambda: fl.steady_state(BELT, [0.0, 0.2], transient=30.0, window=60.0, progress=False),
}


@pytest.mark.parametrize("guess", ["stick", "run", "steady state"])
def test_a_mass_on_a_belt_has_its_closed_form(guess):
    orbit = fl.periodic_orbit(BELT, GUESSES[guess]())
    exact = 5 + 2 * np.pi - 2 * np.arctan(2.5)
    assert exact == pytest.approx(8.902605407815, abs=1e-12)
    assert orbit.period == pytest.approx(exact, abs=1e-12)
    assert orbit.multipliers == pytest.approx([1.0, 0.0], abs=1e-12)
    assert [name for name, _ in orbit.modes] == ["stick", "+"]
    assert [seconds for _, seconds in orbit.modes] == pytest.approx([5.0, exact - 5.0], abs=1e-12)
    assert orbit.stable
    assert orbit.residual < 1e-14
    assert orbit.trajectory(orbit.period) == pytest.approx(orbit.state, abs=1e-13)


def test_inside_the_cycle_of_stick_and_slip_there_are_those_without_stick():
    """|v| < 0.2 about x = 0.5: a family of circles, on which both multipliers are 1."""
    orbit = fl.periodic_orbit(BELT, GUESSES["state"]())
    assert orbit.period == pytest.approx(2 * np.pi, abs=1e-12)
    assert orbit.multipliers == pytest.approx([1.0, 1.0], abs=1e-7)  # a double root: the root of rounding
    assert [name for name, _ in orbit.modes] == ["+"]


def test_the_bistable_oscillator_sticks_as_long_as_it_should():
    orbit = fl.periodic_orbit(bistable(1.5), [0.5, 1.5, 1.0])
    assert orbit.period == pytest.approx(6.31630635789, abs=1e-11)
    assert dict(orbit.modes)["stick"] == pytest.approx(0.505485542356, abs=1e-12)
    assert orbit.multipliers == pytest.approx([1.0, 0.0, 0.0], abs=1e-10)
    v = orbit.state[1]
    assert orbit.state[2] == pytest.approx(np.exp(-2 * abs(v - 1.5)), rel=1e-12)


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_the_unit_circle_attracts_or_repels(direction):
    radius = 1.0 + 1e-7  # one turn magnifies what is missing to 1 by e^(4 pi)
    orbit = fl.periodic_orbit(circle(direction), [radius * np.cos(0.3), radius * np.sin(0.3), 1e-3])
    assert orbit.period == pytest.approx(2 * np.pi, abs=1e-11)
    assert np.hypot(*orbit.state[:2]) == pytest.approx(1.0, abs=1e-12)
    exact = sorted([np.exp(-4 * np.pi * direction), np.exp(-2 * np.pi)], reverse=True)
    assert multipliers(orbit) == pytest.approx(exact, rel=1e-8)
    assert orbit.stable == (direction > 0)
    kind = "stable" if direction > 0 else "unstable"
    assert repr(orbit) == f"PeriodicOrbit({kind}, period 6.28319 s, only)"


@pytest.mark.parametrize(("strength", "kind"), [(1e-9, "stable"), (-1e-9, "unstable"), (0.0, "neutral")])
def test_a_weak_attraction_is_told_from_none(strength, kind):
    """Deviations from the unit circle shrink by exp(-4 pi strength) a turn: that is no rounding."""
    scene = circle(strength)
    orbit = fl.periodic_orbit(scene, [1.0, 0.0, 0.0], period=2 * np.pi)
    exact = [1.0, np.exp(-4 * np.pi * strength), np.exp(-2 * np.pi)]
    assert np.sort(orbit.multipliers.real) == pytest.approx(np.sort(exact), abs=1e-13)
    assert orbit.stability == kind


def test_a_pendulum_near_its_upper_rest_is_neutral():
    """No friction: the multiplier 1 is double, with an error of some 1e-5, as the period varies fast."""
    orbit = fl.periodic_orbit(
        automaton(fl.Mode("only", (V, -sp.sin(X))), coordinates=1), [3.1, 0.0], period=18.0
    )
    x, v = orbit.state
    assert orbit.period == pytest.approx(4 * ellipk((v**2 / 2 + 1 - np.cos(x)) / 2), rel=1e-10)
    assert orbit.stability == "neutral"


def test_the_monodromy_matrix_of_impacts_is_that_of_differences_by_another_integrator():
    """x'' = F cos(phase) - c x' - k x below a stop at d, where x' becomes -e x'; DOP853 finds the impacts."""
    m, c, k, d, F, omega, e = 1.0, 0.1, 1.0, 0.3, 1.0, 2.5, 0.6
    model = fl.ImpactOscillator(m=m, c=c, k=k, d=d, F=F, Omega=omega, impact=fl.RestitutionImpact(e=e))
    orbit = fl.periodic_orbit(model, fl.steady_state(model, progress=False))
    assert "impact" in orbit.trajectory.events.guard

    def flight(_, z):
        return [z[1], (F * np.cos(z[2]) - c * z[1] - k * z[0]) / m, omega]

    impact = (lambda _, z: d - z[0], lambda _, z: ("flight", [d, -e * z[1], z[2]]))

    def end(start):
        phases = {"flight": (flight, (impact,))}
        return until_events(phases, "flight", start, orbit.period, rtol=1e-13, atol=1e-14)[0]

    size = np.ptp(orbit.trajectory.states, axis=0)

    def differences(h):
        steps = h * np.diag(size)
        ends = [(end(orbit.state + s) - end(orbit.state - s)) / (2 * h) for s in steps]
        return np.column_stack(ends) / size[:, None]

    expected = (4 * differences(5e-5) - differences(1e-4)) / 3  # extrapolated from two steps
    np.testing.assert_allclose(orbit.monodromy * size / size[:, None], expected, atol=1e-8)


def test_an_unstable_bounce_is_found():
    """A ball that leaves the floor at V^2/c: at speed c for ever; u -> u^2/c doubles what is off."""
    c, g = sp.symbols("c g")
    floor = fl.Event("floor", X, ("flight",), fl.Reset({X: sp.S.Zero, V: V**2 / c}))
    scene = automaton(fl.Mode("flight", (V, -g), (floor,)), c=3.0, g=9.81)
    orbit = fl.periodic_orbit(scene, [1.01 * 9.0 / (2 * 9.81), 0.0], period=0.6)
    assert orbit.period == pytest.approx(6.0 / 9.81, rel=1e-13)
    assert orbit.multipliers == pytest.approx([2.0, 1.0], rel=1e-12)
    assert orbit.trajectory.events.before[0] == pytest.approx([0.0, -3.0], abs=1e-13)
    assert not orbit.stable


@pytest.mark.parametrize("time", [1, -1])
def test_van_der_pol_keeps_to_liouvilles_formula(time):
    """det M = exp(integral of the divergence).

    The period at mu = 1: Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I, exercise 1 of
    section I.16.
    """
    scene = van_der_pol(1.0, time)
    guess = fl.solve(van_der_pol(1.0), 60.0, x0=[2.0, 0.0])
    orbit = fl.periodic_orbit(scene, guess)
    assert orbit.period == pytest.approx(6.6632868593231301896996820305, abs=1e-11)
    run = fl.solve(scene, orbit.period, x0=orbit.state, quadratures={"div": time * (1 - X**2)})
    assert multipliers(orbit)[0].real == pytest.approx(np.exp(run.quadratures["div"]), rel=1e-10)
    assert orbit.stable == (time > 0)


def test_what_comes_back_to_its_state_in_another_mode_is_no_orbit():
    """At v_r = 0 both slip and stick may begin where static friction is larger than kinetic."""
    model = fl.SliderOnBelt(mu_k=1.51278)
    found, rest = fl.eigenvalues(model), fl.equilibrium(model).q
    i = int(np.argmax(found.growth_rates))
    shape = found.vectors[:, i].real / np.abs(found.vectors[:5, i]).max()
    guess = np.concatenate([rest, np.zeros(5)]) + 1e-2 * shape
    with pytest.raises(ValueError, match=r"begins in mode 'slip\+' and comes back to .* in mode 'stick'"):
        fl.periodic_orbit(model, guess, period=1.0 / found.frequencies[i])


@dataclass(frozen=True, repr=False)
class Rooted(fl.FrictionLaw):
    """Friction that falls with the fourth root of the speed, whose slope is infinite where slip begins."""

    mu: float = fl.parameter(0.5, symbol=r"\mu")

    def kinetic(self, normal_force, speed):
        return (self.mu - 0.3 * speed**0.25) * normal_force

    def static_limit(self, normal_force):
        return self.mu * normal_force


def test_a_law_without_a_slope_is_not_called_too_unstable():
    model = fl.MassOnBelt(friction=Rooted(), v=0.3)
    run = fl.simulate(model, 100.0, progress=False)
    with pytest.raises(ValueError, match=r"by more than 1\.\d in a period, so a law may lack a finite slope"):
        fl.periodic_orbit(model, run)


def return_map(model, orbit, i, z):
    """Where the motion from `z` meets the plane that state i is constant on, about one period later."""
    scene = model.automaton()
    level = scene.states[i] - float(orbit.state[i])
    end = 1.2 * orbit.period
    run = fl.solve(scene, end, x0=z, sections={"plane": level}, progress=False)
    points = run.sections["plane"]
    return points.state[np.argmin(np.abs(points.t - orbit.period))]


SLIDERS = [*product((FLAT, TILTED), (0.4, 1.4, 2.5))]


@pytest.mark.parametrize(("base", "mu_k"), slow_but(SLIDERS[:3:2] + SLIDERS[4:5], SLIDERS, several=True))
def test_the_sliders_multipliers_are_those_of_its_return_map(base, mu_k):
    model = base.replace(mu_k=mu_k)
    guess = fl.simulate(model, 60.0, progress=False)
    orbit = fl.periodic_orbit(model, guess)
    size = np.ptp(orbit.trajectory.states, axis=0)
    i = int(np.argmax(np.abs(fl.simulate(model, 1e-4, x0=orbit.state).final_state - orbit.state) / size))
    others = np.delete(np.arange(len(size)), i)

    def differences(h):
        steps = h * np.diag(size)[others]
        ends = [
            return_map(model, orbit, i, orbit.state + s) - return_map(model, orbit, i, orbit.state - s)
            for s in steps
        ]
        return (np.column_stack(ends) / size[:, None])[others] / (2 * h)

    # Eigenvalues of central differences, extrapolated from two steps.
    coarse, fine = differences(2e-5), differences(1e-5)
    found = np.linalg.eigvals((4 * fine - coarse) / 3)
    exact = multipliers(orbit)
    assert len(found) == len(exact)
    assert all(np.abs(found - value).min() < 1e-6 for value in exact if abs(value) > 1e-3)
    assert np.abs(found).max() == pytest.approx(np.abs(exact).max(), abs=1e-6)
    assert np.abs(exact).min() < 1e-10
    assert orbit.stable
    assert [name for name, _ in orbit.modes] == ["slip+", "stick", "slip+", "separation"]


# At 0.7431 and 0.9369 the gap is rounding on the wrong side of zero where the flight begins.
@pytest.mark.parametrize("mu_k", [0.7, 0.7431, 0.84, 0.9369, 0.98])
def test_a_cycle_with_loss_of_contact_is_that_of_another_integrator(mu_k):
    model = fl.ModeCoupling(c=0.1, mu_k=mu_k)
    orbit = fl.periodic_orbit(model, fl.steady_state(model, progress=False))
    events = orbit.trajectory.events
    (onset,) = events.state[events.target == "stick"][:, [0, 1, 3]]
    again, times = cycle(onset, 0.1, mu_k)
    assert again == pytest.approx(onset, abs=1e-10)
    stays = dict(zip(["stick", "slip+", "separation", "slip+ again"], times))
    assert [name for name, _ in orbit.modes] == ["slip+", "stick", "slip+", "separation"]
    ours = [seconds for _, seconds in orbit.modes]
    assert ours == pytest.approx(
        [stays[n] for n in ("slip+ again", "stick", "slip+", "separation")], abs=1e-10
    )
    found = np.linalg.eigvals(by_differences(onset, 0.1, mu_k))
    exact = multipliers(orbit)[:2]
    assert all(np.abs(found - value).min() < 1e-7 for value in exact)
    assert orbit.stable


def test_no_condition_is_measured_by_its_own_rounding():
    for mu_k in np.linspace(0.7, 0.98, 5):
        model = fl.ModeCoupling(c=0.1, mu_k=mu_k)
        orbit = fl.periodic_orbit(model, fl.steady_state(model, progress=False))
        assert orbit.trajectory.violation < 1e-13


def test_the_orbit_is_what_the_motion_settles_to():
    model = FLAT.replace(mu_k=1.4)
    settled = fl.steady_state(model, transient=60.0, window=20.0, progress=False)
    orbit = fl.periodic_orbit(model, settled)
    assert orbit.period == pytest.approx(settled.period, rel=1e-9)
    assert sum(seconds for _, seconds in orbit.modes) == pytest.approx(orbit.period, rel=1e-12)
    shares = {name: share for name, share in settled.time_in_mode.items() if share}
    in_mode = orbit.trajectory.time_in_mode
    whole = {name: seconds / orbit.period for name, seconds in in_mode.items() if seconds}
    assert whole == pytest.approx(shares, abs=0.1 / 20.0)


def test_the_motion_of_an_orbit_knows_its_model():
    """What drives it in a period is taken by friction, dampers and impacts."""
    model = FLAT.replace(mu_k=1.4)
    orbit = fl.periodic_orbit(model, fl.simulate(model, 60.0))
    works = fl.energy_audit(orbit.trajectory, progress=False).works
    assert works["belt drive"][-1] > 3.0
    assert abs(sum(work[-1] for work in works.values())) < 1e-9
    assert orbit.plot().get_xlabel() == "$x_{1}$ (m)"
    bare = fl.periodic_orbit(model.automaton(), orbit.state, period=orbit.period)
    assert bare.trajectory.source is None


def test_a_guess_of_two_periods_gives_the_shortest():
    orbit = fl.periodic_orbit(BELT, [0.0, 0.2], period=17.8)
    assert orbit.period == pytest.approx(8.902605407815, abs=1e-11)


@pytest.mark.parametrize("periods", [60, 100, 101])
def test_a_run_of_whole_periods_ends_before_or_after_the_reset_of_its_phase(periods):
    model = fl.RattlingGear()
    orbit = fl.periodic_orbit(model, fl.simulate(model, periods * model.period, progress=False))
    assert orbit.period == pytest.approx(model.period, rel=1e-13)
    several = fl.periodic_orbit(model, orbit.state, period=11 * model.period)
    assert several.period == pytest.approx(model.period, rel=1e-13)


def test_a_guess_of_other_parameters_will_do():
    one, other = FLAT.replace(mu_k=1.4), FLAT.replace(mu_k=1.5)
    orbit = fl.periodic_orbit(other, fl.simulate(one, 60.0, progress=False))
    again = fl.periodic_orbit(other, fl.simulate(other, 60.0, progress=False))
    assert orbit.period == pytest.approx(again.period, rel=1e-12)


def test_what_grows_is_cyclic_only_if_a_shift_of_it_changes_nothing():
    """x does; y is unstable, and z, which heats up, is no coordinate."""
    y, z = sp.symbols("y z")
    growing = automaton(
        fl.Mode("only", (V, W, sp.S.Zero, y, sp.S.One)), states=(X, y, V, W, z), coordinates=2
    )
    with pytest.raises(ValueError, match="or list x in cyclic, as"):
        fl.periodic_orbit(growing, fl.solve(growing, 10.0, x0=[0.0, 1.0, 1.0, 1.0, 0.0]))


def test_what_is_no_orbit_says_what_was_reached():
    at_rest = fl.steady_state(ball(), [1.0, 0.0], transient=5.0, window=5.0, progress=False)
    with pytest.raises(ValueError, match="guess must be periodic, the steady state is 'equilibrium'"):
        fl.periodic_orbit(ball(), at_rest)
    damped = automaton(fl.Mode("only", (V, -X - V / 2)))
    with pytest.raises(ValueError, match="guess must come back within 10% of the size of its motion"):
        fl.periodic_orbit(damped, [1.0, 0.0])
    with pytest.raises(ValueError, match=r"no periodic orbit found .*(equilibrium|residual)"):
        fl.periodic_orbit(damped, [1.0, 0.0], period=6.0)
    with pytest.raises(ValueError, match="Newton's method reached an equilibrium"):
        fl.periodic_orbit(coulomb(0.0, 1.0, 1.0), [0.3, 0.0], period=1.0)
    with pytest.raises(ValueError, match="accumulation of events was closed"):
        fl.periodic_orbit(fl.SliderOnBelt(mu_k=1.4), fl.simulate(fl.SliderOnBelt(mu_k=1.4), 30.0))


def test_a_vibration_that_decays_beside_a_rotation_reaches_an_equilibrium():
    a, x, w, u = sp.symbols("a x w u")
    turning = fl.HybridAutomaton(
        (a, x, w, u), (fl.Mode("only", (w, u, 1 - w, -x - u / 50)),), {}, coordinates=2, cyclic=("a",)
    )
    run = fl.solve(turning, 60.0, x0=[0.0, 1.0, 1.0, 0.0], progress=False)
    with pytest.raises(ValueError, match="Newton's method reached an equilibrium"):
        fl.periodic_orbit(turning, run)


def test_a_ball_that_comes_to_rest_on_its_table_in_each_period():
    """It leaves where A Omega^2 sin(phase) = g, and its bounces come to an end: it forgets where it was."""
    model = fl.BallOnTable(e=0.2)
    orbit = fl.periodic_orbit(model, [1.192, -0.2365, 1.885], period=model.period)
    events = orbit.trajectory.events
    left = events.state[events.guard == "off", 2]
    assert left == pytest.approx([np.arcsin(1 / 1.2)], abs=1e-12)
    assert orbit.period == pytest.approx(2 * np.pi, rel=1e-12)
    assert orbit.multipliers == pytest.approx([1.0, 0.0, 0.0], abs=1e-9)


def test_an_oscillator_is_a_family_of_orbits():
    orbit = fl.periodic_orbit(oscillator(), [0.3, 0.4])
    assert orbit.period == pytest.approx(2 * np.pi, abs=1e-12)
    assert np.hypot(*orbit.state) == pytest.approx(0.5, abs=0.01)  # that next to the guess
    assert orbit.multipliers == pytest.approx([1.0, 1.0], abs=1e-7)
    assert not orbit.stable


@fl.model
class Gears(fl.MechanicalModel):
    """An eccentric wheel that a torque drives, and a gear that sines couple to it by a ratio."""

    ratio: float = 1.5
    coordinates = cyclic = ("a", "b")

    def mechanics(self, q, v):
        mesh = 30.0 * (1 - fl.functions.cos(q.b - self.ratio * q.a))
        return fl.Mechanics(
            kinetic=(v.a**2 + v.b**2) / 2,
            potential=mesh - 0.3 * fl.functions.cos(q.a),
            dissipation=0.1 * (v.a**2 + v.b**2),
            loads={"a": 1.0},
        )


@pytest.mark.slow
@pytest.mark.parametrize("ratio", [1.5, 1.2345])
def test_gears_that_sines_couple_close_after_a_turn_of_one_and_a_part_of_one_of_the_other(ratio):
    model = Gears(ratio=ratio)
    run = fl.simulate(model, 150.0, x0={"a'": 2.0, "b'": 2.0 * ratio}, progress=False)
    orbit = fl.periodic_orbit(model, run)

    def rates(_, z):
        tooth = 30.0 * np.sin(z[1] - ratio * z[0])
        ahead = 1.0 - 0.3 * np.sin(z[0]) + ratio * tooth - 0.2 * z[2]
        return [z[2], z[3], ahead, -tooth - 0.2 * z[3]]

    moved = solve_ivp(rates, (0.0, orbit.period), orbit.state, method="DOP853", rtol=1e-12, atol=1e-13)
    away = moved.y[:, -1] - orbit.state
    assert away == pytest.approx([2 * np.pi, 2 * np.pi * ratio, 0.0, 0.0], abs=1e-8)
    settled = fl.steady_state(model, run.final_state, transient=0.0, window=60.0, progress=False)
    assert str(settled.kind) == "periodic"
    assert settled.period == pytest.approx(orbit.period, rel=1e-9)


def test_continuation_of_many_contacts_derives_no_mode_in_advance():
    automaton = fl.BeamOnBelt(3, nodes=(1, 2, 3), angle=0.0).automaton()
    modes = with_parameter_as_state(automaton, "mu_k").modes
    assert isinstance(modes, ModesOnDemand)
    assert modes.derived == ()
    assert len(modes.named("slip+ | slip+ | stick").flow) == len(automaton.states) + 1
    assert modes.derived == ("slip+ | slip+ | stick",)


def test_a_motion_with_hysteresis_goes_on_in_its_mode():
    two, times = hysteresis(), {"transient": 10.0, "window": 30.0, "progress": False}
    fast = fl.steady_state(two, [5.5, 0.0], **times)
    assert fast.period == pytest.approx(2 * np.pi / 3, rel=1e-9)
    orbit = fl.periodic_orbit(two, fl.solve(two, 20.0, x0=[0.5, 0.0], mode="fast"))
    assert orbit.period == pytest.approx(2 * np.pi / 3, rel=1e-9)
    branch = fl.continue_orbit(orbit, "scale", (0.99, 1.01), max_points=3, progress=False)
    assert branch.periods * branch.values == pytest.approx(2 * np.pi / 3, rel=1e-9)
    whole, part = (fl.simulate(two, t_end, x0=[5.5, 0.0], progress=False) for t_end in (5.0, 2.0))
    rest = fl.simulate(two, 3.0, x0=part.final_state, mode=part.mode[-1], progress=False)
    assert rest.final_state == pytest.approx(whole.final_state, abs=1e-13)


def test_amplitude_and_frequency_over_friction():
    """Of stick-slip under Coulomb's law: slip is an arc of a circle around mu_k N/k, stick its chord."""
    model = fl.MassOnBelt()
    N, k, m, v, mu_k = (model.parameters[name] for name in ("N", "k", "m", "v", "mu_k"))
    orbit = fl.periodic_orbit(model, fl.simulate(model, 60.0))
    branch = fl.continue_orbit(orbit, "mu_s", (model.mu_s, model.mu_s + 0.4), progress=False)
    a, w = (branch.values - mu_k) * N / k, np.sqrt(k / m)
    assert branch.amplitudes("x") == pytest.approx(np.hypot(a, v / w), rel=1e-9)
    periods = 2 * a / v + (2 * np.pi - 2 * np.arctan(a * w / v)) / w
    assert branch.frequencies == pytest.approx(1 / periods, rel=1e-9)
    table = branch.to_dataframe()
    assert set(table["stability"]) == {"stable"}
    assert table["largest_multiplier"].max() < 1e-6  # of states that stick before they slip again
    with pytest.raises(ValueError, match="name must be one of 'x'"):
        branch.amplitudes("x'")


def test_pieces_of_a_fit_go_on_in_their_mode():
    two, t = hysteresis(), np.linspace(0.1, 6.0, 60)
    record = fl.TimeRecord(t, {"x": fl.solve(two, 6.1, x0=[5.5, 0.0])(t)[:, 0]}, error=1e-3)
    found = fl.fit(two.replace(scale=1.1), record, ["scale"], x0=[5.5, 0.0], segments=6)
    assert found["scale"] == pytest.approx(1.0, rel=1e-9)


def test_attractors_at_the_same_states_are_told_apart_by_their_modes():
    times = {"transient": 10.0, "window": 30.0, "progress": False}
    reached = fl.basins(hysteresis(), x=("x", [0.5, 5.5, 6.0]), y=("v", [0.0, 0.1]), **times)
    names = [each.name for each in reached.attractors]
    assert reached.labels[:, 0].tolist() == [names.index("period 6.283 s")] * 2
    assert (reached.labels[:, 1:] == names.index("period 2.094 s")).all()


@pytest.mark.parametrize("rate", [1e-9, 1.0, 1e9])
def test_a_relay_returns_in_its_mode(rate):
    """x passes each value twice in a period, in modes that are both admissible there."""
    speed, events = sp.Symbol("rate"), {"on": 0.7 - X, "off": X - 0.3}
    on = fl.Mode("on", (speed * (1 - X),), (fl.Event("high", events["on"], ("off",)),))
    off = fl.Mode("off", (-speed * X,), (fl.Event("low", events["off"], ("on",)),))
    relay, period = automaton(on, off, states=(X,), coordinates=0, rate=rate), 2 * np.log(7 / 3) / rate
    orbit = fl.periodic_orbit(relay, fl.solve(relay, 10.3 * period, x0=[0.5]))
    assert orbit.period == pytest.approx(period, rel=1e-12)


@fl.model
class Beside(fl.MechanicalModel):
    """Stick-slip on a belt beside a state that decays, s' = -s."""

    v0: float = 0.5
    friction: fl.FrictionLaw = fl.Coulomb(mu_k=0.3, mu_s=0.5)
    coordinates = ("x",)
    states = ("s",)

    def mechanics(self, q, v, s):
        belt = fl.Friction(self.v0 - v.x, 1.0, self.friction)
        return fl.Mechanics(v.x**2 / 2, q.x**2 / 2, contacts=(belt,), rates={"s": -s.s})


@pytest.mark.parametrize("s", [0.0, 1.0])
def test_a_state_beside_that_decays_changes_no_branch(s):
    """Period by its slip and its stick; s is 0, or what is left of it after a hundred periods."""
    model = Beside()
    branch = fl.continue_orbit(
        fl.periodic_orbit(model, fl.simulate(model, 40.0, x0=[0.5, 0.5, s], progress=False)),
        "v0", (0.4, 2.0), progress=False,
    )  # fmt: skip
    assert branch.ends == ("bound", "bound")
    sliding = 2 * np.pi - 2 * np.arctan(0.2 / branch.values)  # from x = 0.5 back to the belt's speed
    np.testing.assert_allclose(branch.periods, sliding + 2 * 0.2 / branch.values, rtol=1e-8)
    smallest = np.exp(-branch.periods)
    assert np.abs(branch.multipliers - smallest[:, None]).min(axis=1).max() < 1e-8
