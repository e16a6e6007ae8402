"""Branches of periodic orbits against closed forms: periods, folds, bifurcations, grazing."""

import numpy as np
import pytest
import sympy as sp

import frictionlab as fl
from tests.helpers.assertions import assert_all
from tests.helpers.automata import V, X, automaton, coulomb
from tests.helpers.known_motions import FLAT, TILTED, bistable, logistic, thrown
from tests.helpers.mode_coupling_cycle import cycle

pytestmark = pytest.mark.blas

W = sp.Symbol("w")


def followed(orbit, *arguments, **options):
    return fl.continue_orbit(orbit, *arguments, progress=False, **options)


def specials(branch):
    return [(special.kind, special.value) for special in branch.special]


def lobes(strength):
    """r' = r (s + 2 r^2 - r^4) in a plane that turns once in 2 pi: circles r^2 = 1 +- sqrt(1 + s)."""
    square, s = X**2 + V**2, sp.Symbol("s")
    grow = s + 2 * square - square**2
    return automaton(fl.Mode("only", (X * grow - V, V * grow + X)), coordinates=0, s=strength)


def delayed(a):
    """Speeds u -> a u (1 - the u before)."""
    return thrown({V: sp.Symbol("a") * -V * (1 - W), W: -V}, (X, V, W), a=a)


def test_the_period_of_a_mass_on_a_belt_follows_its_closed_form():
    """It sticks for 2 d/v, d = mu_s - mu_k, and slips for 2 pi - 2 arctan(d/v), with unit mass and spring."""
    orbit = fl.periodic_orbit(coulomb(0.2, 1.0, 0.5), [0.0, 0.2])
    branch = followed(orbit, "belt", (0.05, 2.0))
    v, d = branch.values, 0.5
    assert branch.ends == ("bound", "bound")
    assert (v[0], v[-1]) == (0.05, 2.0)
    assert (np.diff(v) > 0).all()
    assert branch.periods == pytest.approx(2 * d / v + 2 * np.pi - 2 * np.arctan(d / v), abs=1e-11)
    assert np.abs(branch.multipliers - [1.0, 0.0]).max() < 1e-10
    assert branch.stable.all()
    assert specials(branch) == []
    for value, found in zip(v, branch.orbits):
        assert {s.name: p for s, p in found.model.parameters.items()}["belt"] == value
        assert dict(found.modes)["stick"] == pytest.approx(2 * d / value, abs=1e-11)


def test_static_friction_grows_the_same_cycle():
    orbit = fl.periodic_orbit(coulomb(0.2, 1.0, 0.5), [0.0, 0.2])
    branch = followed(orbit, "mu_s", (0.6, 3.0))
    d, v = branch.values - 0.5, 0.2
    assert branch.periods == pytest.approx(2 * d / v + 2 * np.pi - 2 * np.arctan(d / v), abs=1e-11)


def test_stick_slip_of_the_bistable_oscillator_ends_by_grazing():
    """The mass just comes up to the speed of the belt; found independently with 40 digits."""
    branch = followed(fl.periodic_orbit(bistable(1.5), [0.5, 1.5, 1.0]), "v_d", (1.2, 2.5))
    assert branch.ends == ("bound", "grazing")
    ((kind, value),) = specials(branch)
    assert kind == "grazing"
    assert value == pytest.approx(1.83660097221, abs=1e-11)
    (last,) = (special.orbit for special in branch.special)
    assert dict(last.modes)["stick"] < 1e-4
    assert branch.stable.all()


def test_a_fold_joins_two_circles_and_the_small_one_ends_in_a_hopf_point():
    start = fl.periodic_orbit(lobes(1.0), [np.sqrt(1 + np.sqrt(2.0)), 0.0], period=2 * np.pi)
    branch = followed(start, "s", (-3.0, 2.0), step=0.05)
    square = np.array([orbit.state @ orbit.state for orbit in branch.orbits])
    assert branch.values == pytest.approx((square - 1) ** 2 - 1, abs=1e-10)
    assert branch.periods == pytest.approx(2 * np.pi, abs=1e-10)
    hopf, fold = branch.special
    assert (hopf.kind, fold.kind) == ("Hopf", "fold")
    assert fold.value == pytest.approx(-1.0, abs=1e-12)
    assert hopf.value == pytest.approx(0.0, abs=1e-12)
    assert branch.ends == ("Hopf", "bound")
    away = np.abs(square - 1) > 1e-3
    assert np.array_equal(branch.stable[away], square[away] > 1)
    exact = np.exp(2 * np.pi * 4 * square * (1 - square))
    found = np.array([np.delete(m, np.argmin(np.abs(m - 1))) for m in branch.multipliers[away]])[:, 0]
    assert found == pytest.approx(exact[away], rel=1e-6, abs=1e-12)


def test_a_period_doubling_is_that_of_the_logistic_map():
    speed = 1 - 1 / 2.5
    orbit = fl.periodic_orbit(logistic(2.5), [speed**2 / 2, 0.0], period=2 * speed)
    branch = followed(orbit, "a", (1.5, 3.6))
    ((kind, value),) = specials(branch)
    assert kind == "period doubling"
    assert value == pytest.approx(3.0, abs=1e-10)
    a = branch.values
    assert branch.periods == pytest.approx(2 * (1 - 1 / a), abs=1e-12)
    assert np.array_equal(branch.stable, a < 3.0)
    doubled = branch.special[0].orbit
    assert np.abs(doubled.multipliers + 1).min() < 1e-9


def test_a_neimark_sacker_point_is_that_of_the_delayed_logistic_map():
    speed = 1 - 1 / 1.8
    start = fl.periodic_orbit(delayed(1.8), [speed**2 / 2, 0.0, speed], period=2 * speed)
    branch = followed(start, "a", (1.6, 2.2))
    ((kind, value),) = specials(branch)
    assert kind == "Neimark-Sacker"
    assert value == pytest.approx(2.0, abs=1e-10)
    around = np.exp(1j * np.pi / 3)
    assert np.abs(branch.special[0].orbit.multipliers - around).min() < 1e-9
    assert np.array_equal(branch.stable, branch.values < 2.0)


def test_every_orbit_of_the_slider_is_what_newtons_method_finds_there():
    model = FLAT.replace(mu_k=1.4)
    orbit = fl.periodic_orbit(model, fl.simulate(model, 40.0, progress=False))
    branch = followed(orbit, "mu_k", (0.0, 3.0))
    assert branch.ends == ("bound", "bound")
    assert (branch.values[0], branch.values[-1]) == (0.0, 3.0)
    assert branch.stable.all()  # it is born at no mu_k: with mu_s = 3 it sticks and slips at mu_k = 0 too
    assert specials(branch) == []
    for found in branch.orbits[::4]:
        again = fl.periodic_orbit(found.model, found.state, period=found.period)
        assert again.period == pytest.approx(found.period, rel=1e-11)
        assert again.multipliers[:3] == pytest.approx(found.multipliers[:3], abs=1e-7)
        assert found.residual < 1e-9


def test_a_cycle_with_loss_of_contact_goes_on_to_both_bounds():
    model = fl.ModeCoupling(c=0.1, mu_k=0.84)
    orbit = fl.periodic_orbit(model, fl.steady_state(model, progress=False))
    branch = followed(orbit, "mu_k", (0.7, 0.98))
    assert branch.ends == ("bound", "bound")
    assert specials(branch) == []
    assert branch.stable.all()
    for mu_k, found in zip(branch.values[::3], branch.orbits[::3]):
        events = found.trajectory.events
        (onset,) = events.state[events.target == "stick"][:, [0, 1, 3]]
        again, times = cycle(onset, 0.1, mu_k)
        assert again == pytest.approx(onset, abs=1e-8)  # orbits of a branch close to 1e-9 of their size
        assert sum(times) == pytest.approx(found.period, abs=1e-8)


def test_the_sliders_cycle_ends_where_stick_would_begin_at_the_static_limit():
    model = FLAT.replace(mu_k=0.3)
    orbit = fl.periodic_orbit(
        model, fl.simulate(model, 40.0, x0=fl.simulate(FLAT.replace(mu_k=1.4), 20.0).final_state)
    )
    branch = followed(orbit, "mu_s", (0.3, 3.0))
    assert branch.ends == ("mode change", "bound")
    at = branch.special[0].orbit
    run = at.trajectory
    (onset,) = run.events.t[run.events.target == "stick"]
    force, normal = (run.output(name, np.array([onset]))[0] for name in ("friction_force", "normal_force"))
    assert abs(force) == pytest.approx(branch.special[0].value * normal, rel=1e-6)


def test_the_unstable_cycle_of_the_slider_lives_from_its_hopf_point_to_grazing():
    """A subcritical Hopf point; its cycle soon comes to the speed of the belt, where sliding ends."""
    point = fl.hopf(FLAT, "mu_k", (0.0, 3.0))
    model = FLAT.replace(mu_k=point.value - 1e-6)
    shape = fl.eigenvalues(model).vectors
    growing = shape[:, int(np.argmax(fl.eigenvalues(model).values.real))]
    growing = growing / np.abs(growing[:4]).max()
    start = np.append(fl.equilibrium(model).q, np.zeros(4))
    start = start + point.amplitude(model.mu_k).max() * growing.real
    branch = followed(fl.periodic_orbit(model, start, period=1 / point.frequency), "mu_k", (0.0, 3.0))
    assert branch.ends == ("grazing", "Hopf")
    grazing, hopf = branch.special
    assert grazing.value == pytest.approx(point.valid_until, abs=1e-10)
    assert hopf.value == pytest.approx(point.value, abs=1e-10)
    assert np.abs(grazing.orbit.trajectory["relative_velocity"]).min() < 1e-3
    assert not branch.stable[branch.values < point.value - 1e-8].any()


def test_ctrl_c_keeps_what_there_is(monkeypatch):
    from frictionlab.analysis.orbits import branches

    count = iter(range(100))
    usual = branches.continuation_step

    def interrupted(*arguments):
        if next(count) > 12:
            raise KeyboardInterrupt
        return usual(*arguments)

    monkeypatch.setattr(branches, "continuation_step", interrupted)
    orbit = fl.periodic_orbit(coulomb(0.2, 1.0, 0.5), [0.0, 0.2])
    with pytest.raises(KeyboardInterrupt, match="the branch was stopped after"):
        followed(orbit, "belt", (0.05, 2.0))
    branch = fl.partial_result()
    assert "interrupted" in branch.ends
    assert len(branch.orbits) > 5


@pytest.mark.parametrize(("k_nl", "hopf"), [(0.0, 1.5), (1e4, 1.5), (1e7, 0.6)])
def test_the_bistable_range_of_fig_12_ends_at_the_hopf_point_and_begins_nowhere(k_nl, hopf):
    """The paper reads off [0.4, 1.5], [0.4, 1.5], (0, 0.6]; the cycle attracts at mu_k = 0 too."""
    model = TILTED.replace(k_nl=k_nl, mu_k=1.4)
    orbit = fl.periodic_orbit(model, fl.simulate(model, 60.0, progress=False))
    branch = followed(orbit, "mu_k", (0.0, 3.0))
    assert branch.ends == ("bound", "bound")
    assert branch.stable.all()
    first = fl.stability_changes(model, "mu_k", (0.0, 3.0))[0]
    assert first.direction == "loss"
    assert first.value == pytest.approx(hopf, abs=0.02)


def test_where_an_impact_leads_back_to_its_mode_the_sequence_changes_all_the_same():
    """A forced mass that just reaches a stop, f = sigma |1 - r^2 + 2 i zeta r|; there is but one mode."""
    c, s, f = sp.symbols("c s f")
    pull = 1 - c**2 - s**2
    flow = (V, f * c - X - V / 5, pull * c - s * 4 / 5, pull * s + c * 4 / 5)
    stop = fl.Event("stop", 1 - X, ("free",), fl.Reset({X: sp.S.One, V: -V * 4 / 5}))
    scene = automaton(fl.Mode("free", flow, (stop,)), states=(X, V, c, s), f=0.2)
    orbit = fl.periodic_orbit(scene, fl.solve(scene, 200.0, x0=[0.0, 0.0, 1.0, 0.0]))
    beyond = []
    for end in (0.6, 1.0, 3.0):
        branch = followed(orbit, "f", (0.05, end))
        (value,) = [special.value for special in branch.special if special.kind == "grazing"]
        assert value == pytest.approx(np.hypot(1 - 0.64, 0.16), abs=1e-9)
        impacts = np.array([len(found.trajectory.events) for found in branch.orbits])
        assert_all(impacts[branch.values < value - 1e-6] == 0)
        beyond += [*impacts[branch.values > value + 1e-6]]
    # A branch may end where it grazes, as the return map has a corner there; not all of the three do.
    assert_all(np.array(beyond) > 0)


@pytest.mark.parametrize(("force", "bounds"), [(0.45, (0.39, 3.0)), (0.45, (0.05, 1.0)), (0.6, (0.39, 3.0))])
def test_an_impact_becomes_a_touch_at_one_force_whatever_the_bounds(force, bounds):
    """Free motion just reaches the stop at F = d |k - m Omega^2 + i c Omega|.

    At F = 0.45 it hits once in two periods of the force: there the orbits one period apart meet at the touch.
    """
    model = fl.ImpactOscillator(c=0.2, d=1.0, F=force, Omega=0.8)
    steady = fl.steady_state(model, transient=400.0, window=100.0, progress=False)
    branch = followed(fl.periodic_orbit(model, steady), "F", bounds)
    grazing = [value for kind, value in specials(branch) if kind == "grazing"]
    assert grazing[0] == pytest.approx(np.hypot(1 - 0.64, 0.16), abs=1e-12)
    assert "fold" not in [kind for kind, _ in specials(branch)]


@pytest.mark.parametrize(("low", "step"), [(-0.999, 0.3), (-0.9, 1.0)])
def test_no_orbit_of_a_branch_lies_outside_the_bounds(low, step):
    """The circles r^2 = 1 + sqrt(1 + s) turn back at s = -1, outside."""
    start = fl.periodic_orbit(lobes(1.0), [np.sqrt(1 + np.sqrt(2.0)), 0.0], period=2 * np.pi)
    branch = followed(start, "s", (low, 2.0), step=step)
    assert (branch.ends, branch.values.min(), branch.values.max()) == (("bound", "bound"), low, 2.0)
    assert specials(branch) == []


def test_a_branch_at_one_value_of_its_parameter_has_no_folds():
    """x'' = s x' - x has closed orbits at s = 0 only, of any amplitude: multipliers 1 and 1."""
    scene = automaton(fl.Mode("only", (V, sp.Symbol("s") * V - X)), coordinates=1, s=0.0)
    orbit = fl.periodic_orbit(scene, [1.0, 0.0])
    branch = followed(orbit, "s", (-1.0, 2.0), max_points=10)
    assert np.abs(branch.values).max() < 1e-13
    assert specials(branch) == []
    assert (orbit.stability, orbit.stable) == ("neutral", False)


def test_a_hopf_point_outside_the_bounds_is_none_of_the_branch():
    """r' = r (s - r^2): circles of radius sqrt(s), down to the bound, though they become small."""
    grow = sp.Symbol("s") - X**2 - V**2
    scene = automaton(fl.Mode("only", (X * grow - V, V * grow + X)), coordinates=0, s=1.0)
    branch = followed(fl.periodic_orbit(scene, [1.0, 0.0], period=2 * np.pi), "s", (1e-5, 1.0))
    assert (branch.ends, branch.values.min(), specials(branch)) == (("bound", "bound"), 1e-5, [])
    sizes = [np.linalg.norm(orbit.state) for orbit in branch.orbits]
    assert sizes == pytest.approx(np.sqrt(branch.values), rel=1e-7)
    at_bound = followed(branch.orbits[0], "s", (0.0, 1.0), max_points=40)
    assert at_bound.special[0].kind == "Hopf"
    assert 0.0 <= at_bound.special[0].value < 1e-6
