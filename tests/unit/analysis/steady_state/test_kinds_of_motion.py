"""Kinds of steady states with known answers: slow decay, touched sections, motions that are stuck."""

import numpy as np
import pytest
import sympy as sp

import frictionlab as fl
from frictionlab.analysis.steady_state.poincare_sections import covers_period, phase_on_circle, phase_resets
from tests.helpers.automata import V, X, automaton
from tests.helpers.cases import slow_but
from tests.helpers.impact_map import Oscillator
from tests.helpers.known_motions import settled

SLIDES = {"v": 2.0}  # a belt too fast for the masses to come up to it
APART = [0.1, 0.2, 0.0, 0.0]  # both modes of two blocks
LONG = {"transient": 0.0, "window": 200.0, "t_max": 3e4}


@pytest.mark.parametrize("c", [1e-2, 1e-3, 1e-4, 1e-5])
@pytest.mark.parametrize("window", [40.0, 100.0, 400.0])
def test_a_slow_decay_is_not_settled_yet(c, window):
    for model in (fl.MassOnBelt(c=c, **SLIDES), fl.TwoBlocks(c=c, **SLIDES)):
        assert settled(model, transient=100.0, window=window).kind == "not settled yet"
    assert settled(fl.TwoBlocks(c=c, **SLIDES), APART, window=window).kind == "not settled yet"


@pytest.mark.parametrize(
    ("model", "x0"),
    [
        (fl.MassOnBelt(c=1e-2, **SLIDES), "rest"),
        pytest.param(fl.MassOnBelt(c=2e-3, **SLIDES), "rest", marks=pytest.mark.slow),
        (fl.TwoBlocks(c=1e-2, **SLIDES), APART),
        pytest.param(fl.TwoBlocks(c=2e-3, k2=2.5, **SLIDES), APART, marks=pytest.mark.slow),
    ],
)
def test_a_slow_decay_goes_on_to_the_equilibrium(model, x0):
    found = settled(model, x0, **LONG)
    assert found.kind == "equilibrium"
    rest = fl.equilibrium(model).q
    assert found.trajectory.final_state[: len(rest)] == pytest.approx(rest, rel=2e-3)
    # It shrinks with exp(-c t/2) from its whole size to a thousandth, a window more or less.
    assert found.transient == pytest.approx(2 * np.log(1e3) / model.c, rel=0.3, abs=200.0)


def test_a_structure_without_load_comes_to_rest_at_zero():
    """With alpha M as damping the motion shrinks with exp(-alpha t/2): to a thousandth of its start."""
    springs = [[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 2.0]]
    structure = fl.Structure(np.eye(3), springs, fl.RayleighDamping(alpha=0.02, beta=0.0))
    found = settled(structure, [0.1, 0.0, 0.0, 0.0, 0.0, 0.0], **(LONG | {"transient": 100.0}))
    assert found.kind == "equilibrium"
    assert found.transient == pytest.approx(2 * np.log(1e3) / 0.02, abs=200.0)
    undamped = fl.Structure(np.eye(3), springs)
    assert settled(undamped, [0.1, 0.0, 0.0, 0.0, 0.0, 0.0], window=400.0).kind == "non-periodic"


@pytest.mark.parametrize(("rest", "kind"), [(0.0, "equilibrium"), (5e-4, "not settled yet")])
def test_a_small_vibration_about_another_place_than_zero_is_not_at_rest(rest, kind):
    """Thrown at 1 m, of which 5e-4 m are left; 80 % of that are still there at the end of the window."""
    spring = automaton(fl.Mode("on", (V, rest - X - V / 100)))
    assert settled(spring, [1.0, 0.0], transient=200 * np.log(2e3), window=45.0).kind == kind


def test_two_frequencies_without_damping_are_no_decay():
    model = fl.TwoBlocks(**SLIDES)  # 1 and sqrt(3.4)
    assert settled(model, APART, transient=0.0, window=400.0).kind == "non-periodic"
    few = settled(model, APART, transient=0.0, window=100.0)
    assert len(few.section.t) < 24
    assert few.kind == "not settled yet"


def test_contact_that_is_lost_now_and_then_does_not_hide_a_decay():
    model = fl.ModeCoupling(m=2.0, c=1e-3, mu_k=0.2, v=8.0)
    for window in (100.0, 200.0, 400.0, 1600.0):
        found = settled(model, transient=333.0, window=window)
        assert found.time_in_mode["separation"] > 0.0
        assert found.kind == "not settled yet"
    assert settled(model, transient=2e4, window=400.0, t_max=4e4).kind == "equilibrium"


def test_a_forced_motion_that_decays_slowly_nears_the_period_of_the_force():
    model = fl.DenHartog(c=1e-3, N=0.0)
    for window in (100.0, 200.0, 400.0, 1600.0):
        assert settled(model, window=window).kind in ("not settled yet", "periodic")
    found = settled(model, transient=4e4, window=100.0)  # exp(-20) is left
    assert (found.kind, found.period) == ("periodic", pytest.approx(2 * np.pi / 0.8, rel=1e-9))


@pytest.mark.parametrize("mu", [0.3, 0.5, 0.7, 1.0])
@pytest.mark.parametrize("transient", slow_but([0.0, 333.0], [0.0, 100.0, 200.0, 333.0]))
@pytest.mark.parametrize("section", [None, "stick"])
def test_sliding_that_just_touches_the_belts_speed_has_the_period_of_the_spring(mu, transient, section):
    """With mu_s = mu_k the mass leaves the belt on the circle that touches v_r = 0, where it may stick."""
    model = fl.MassOnBelt(mu_k=mu, mu_s=mu)
    found = settled(model, transient=transient, section=section)
    assert (found.kind, found.period) == ("periodic", pytest.approx(2 * np.pi, rel=1e-7))
    assert found.intensity == pytest.approx(0.5 * model.v**2, rel=1e-4)


@pytest.mark.parametrize("window", [60.0, 100.0, 333.0])
def test_every_circle_inside_the_stick_slip_cycle_has_the_period_of_the_spring(window):
    for speed in (0.01, 0.1, 0.19999):
        found = settled(fl.MassOnBelt(), [0.5, speed], transient=0.0, window=window)
        assert (found.kind, found.period) == ("periodic", pytest.approx(2 * np.pi, rel=1e-10))


@pytest.mark.parametrize("N", [1.001, 1.2, 1.5, 10.0])
@pytest.mark.parametrize("section", [None, "stick", "x"])
def test_what_friction_holds_against_the_force_is_at_rest(N, section):
    found = settled(fl.DenHartog(N=N), transient=20.0, section=section)
    assert (found.kind, found.time_in_mode["stick"]) == ("equilibrium", 1.0)
    assert found.settled
    assert np.isnan(found.period)


def test_stuck_for_less_than_a_period_of_the_force_may_slip_yet():
    """N = 0.9 sticks for half of the time, and N = 1.5 for ever: a short window cannot tell."""
    sticks = settled(fl.DenHartog(N=0.9), transient=200.0, window=100.0)
    run = sticks.trajectory
    onset = run.events.t[run.events.target == "stick"][0]
    state = run(onset + 1e-3)
    assert settled(fl.DenHartog(N=0.9), state, transient=0.0, window=0.5).kind == "not settled yet"
    period = 2 * np.pi / 0.8
    for share, kind in ((0.3, "not settled yet"), (0.95, "not settled yet"), (1.05, "equilibrium")):
        for phase in (0.0, 1.0, 3.0, 6.0):
            start = [0.3, 0.0, phase]
            found = settled(fl.DenHartog(N=1.5), start, transient=0.0, window=share * period)
            assert found.kind == kind


def test_a_mass_that_the_belt_carries_along_is_not_at_rest():
    model = fl.MassOnBelt(k=1e-3)  # it slips after mu_s N/(k v) = 5000 s
    found = settled(model, transient=10.0, window=100.0)
    assert (found.kind, found.time_in_mode["stick"]) == ("not settled yet", 1.0)


def test_other_ways_to_stop_for_ever():
    for model in (fl.FreeCoulomb(), fl.BouncingBall(), fl.MassOnBelt(v=0.0)):
        assert settled(model).kind == "equilibrium"


def test_what_no_force_moves_may_still_be_set_back():
    """A clock that is set back is no event; what throws a mass back is, even where it is done at once."""
    force = sp.Symbol("s")
    turn = fl.Event("turn", 1 - force, ("only",), fl.Reset({force: sp.S.Zero}))
    throw = fl.Event("turn", 1 - force, ("only",), fl.Reset({force: sp.S.Zero, X: X + 1}))
    for event, kind in ((turn, "equilibrium"), (throw, "not settled yet")):
        scene = automaton(fl.Mode("only", (V, -V, sp.S.One), (event,)), states=(X, V, force))
        assert settled(scene, [1.0, 0.0, 0.5], transient=0.0, window=10.0).kind == kind


def test_a_clock_goes_round_a_circle():
    run = fl.simulate(fl.DenHartog(N=1.5), 20.0, x0=[0.3, 0.0, 1.0])
    assert phase_resets(run).all()
    assert covers_period(run)
    t = np.linspace(0.0, 20.0, 101)
    angle = 1.0 + 0.8 * t
    assert phase_on_circle(run, run(t)) == pytest.approx(
        np.column_stack([np.full(101, 0.3), np.zeros(101), np.cos(angle), np.sin(angle)]), abs=1e-12
    )


def test_two_blocks_that_come_to_move_by_turns_are_periodic_in_the_end():
    """They start alike and fall apart by rounding; what they come to is a cycle."""
    found = settled(fl.TwoBlocks(), transient=1000.0, window=200.0)
    assert found.kind == "periodic"
    run = found.trajectory
    assert run(run.raw.t - found.period) == pytest.approx(run.final_state, abs=1e-9)


def share_at_the_stop(beside):
    """Share of a period of the force for which a mass rests at its stop after complete chatter, if it does.

    Released where the force no longer presses it, it comes back by impacts to the same state; the last ones
    are those under a constant acceleration.
    """
    period, release = 2 * np.pi / beside.Omega, np.arccos(beside.k * beside.d / beside.F) / beside.Omega
    t, v, impacts = release, -1e-7, 0
    while impacts < 2 or abs(v) > 1e-5:
        (t, v, _), impacts = beside.impact(t, v), impacts + 1
    pressed = beside.acceleration(t, 0.0)
    assert pressed > 0.0
    assert t < release + period
    return 1.0 - (t - 2 * v / (pressed * (1 - beside.e)) - release) / period


@pytest.mark.parametrize(
    "beside", [Oscillator(c=0.02, d=0.1, Omega=0.37, e=0.6), Oscillator(Omega=0.6, e=0.5)]
)
@pytest.mark.parametrize("periods", slow_but([50], [50, 400]))
def test_infinitely_many_impacts_in_each_period_are_periodic(beside, periods):
    """How many of them are seen in a period is rounding, as they end in rest at the stop."""
    m, c, k, d, force, speed, e = beside
    model = fl.ImpactOscillator(m=m, c=c, k=k, d=d, F=force, Omega=speed, impact=fl.RestitutionImpact(e=e))
    period = 2 * np.pi / speed
    found = settled(model, transient=50 * period, window=periods * period)
    assert (found.kind, found.period) == ("periodic", pytest.approx(period, rel=1e-9))
    assert found.time_in_mode["contact"] == pytest.approx(share_at_the_stop(beside), abs=1e-6)


def test_infinitely_many_impacts_are_periodic_without_a_phase_too():
    """The same, with a force that is the state of another oscillator."""
    c, s, pull = *sp.symbols("c s"), 1 - sp.Symbol("c") ** 2 - sp.Symbol("s") ** 2
    w, d, e, c0 = 0.37, 0.1, 0.6, 0.02
    clock = -w * s + c * pull, w * c + s * pull
    hit = fl.Event("hit", d - X, ("flight",), fl.Reset({X: d, V: -e * V}), fl.Reset({X: d, V: 0}, {d - X: 2}))
    flight = fl.Mode("flight", (V, c - X - c0 * V, *clock), (hit,))
    rest = fl.Mode("rest", (V, sp.S.Zero, *clock), (fl.Event("off", c - d, ("flight",)),), (d - X, V))
    scene = automaton(flight, rest, states=(X, V, c, s))
    found = settled(scene, [0.0, 0.0, 1.0, 0.0], transient=800.0, window=1000.0)
    assert (found.kind, found.period) == ("periodic", pytest.approx(2 * np.pi / w, rel=1e-9))
    assert found.time_in_mode["rest"] == pytest.approx(
        share_at_the_stop(Oscillator(c=c0, d=d, Omega=w, e=e)), abs=0.02
    )


def test_onsets_of_stick_are_counted_of_each_contact():
    """Two blocks without a spring between are two masses on a belt, each of which sticks once a period."""
    model, period = fl.TwoBlocks(k12=0.0), 5 + 2 * np.pi - 2 * np.arctan(2.5)
    found = settled(model, [0.1, -0.2, 0.0, 0.0], transient=100.0, window=100.0, section="stick")
    assert (found.kind, found.period) == ("periodic", pytest.approx(period, rel=1e-9))
    assert found.onsets_per_period == 2
    assert {*found.trajectory.events.target} >= {"stick | slip+", "slip+ | stick"}
    swept = fl.bifurcation(
        model, "v", [0.2], [0.1, -0.2, 0.0, 0.0], transient=100, window=100, progress=False
    )
    assert swept.onsets.tolist() == [2]


@pytest.mark.parametrize("r", [2.5, 2.8, 3.2])
def test_a_map_that_alternates_by_rounding_has_its_own_period(r):
    """The logistic map once a second: the product of r (1 - 2 a) over a period is the multiplier."""
    a, clock = sp.symbols("a clock")
    tick = fl.Event("tick", 1 - clock, ("on",), fl.Reset({a: r * a * (1 - a), clock: 0}))
    scene = fl.HybridAutomaton((a, clock), (fl.Mode("on", (sp.S.Zero, sp.S.One), (tick,)),))
    found = settled(scene, [0.2, 0.0], transient=200.0, window=50.0)
    period = 1.0 if r < 3.0 else 2.0
    assert (found.kind, found.period) == ("periodic", pytest.approx(period, rel=1e-12))
    points = 1 - 1 / r if r < 3.0 else (r + 1 + np.array([1, -1]) * np.sqrt((r - 3) * (r + 1))) / (2 * r)
    orbit = fl.periodic_orbit(scene, found)
    assert orbit.multipliers == pytest.approx([1.0, np.prod(r * (1 - 2 * points))], abs=1e-9)
