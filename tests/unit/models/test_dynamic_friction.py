"""Friction laws with states of their own: LuGre, Dahl, rate and state, and those of one's own."""

import itertools
import math
from dataclasses import dataclass
from functools import partial

import numpy as np
import pytest

import frictionlab as fl
from tests.reference.phases import until_events

pytestmark = pytest.mark.blas

BRISTLES = fl.LuGre(mu_k=0.3, mu_s=0.6, v_s=0.1, sigma_0=200.0, sigma_1=0.5, sigma_2=0.02)


def stribeck(v, mu_k=0.3, mu_s=0.6, v_s=0.1):
    """The coefficient of friction in steady sliding of `BRISTLES`, and its slope."""
    decay = (mu_s - mu_k) * math.exp(-((v / v_s) ** 2))
    return mu_k + decay, -2.0 * v / v_s**2 * decay


@fl.model
class Block(fl.MassOnBelt):
    """A block on a spring and a belt; rubbed by N = 2."""

    m = 0.5
    k = 3.0
    N = 2.0
    friction = BRISTLES
    period = 2.5


@fl.model
class Fault(fl.MassOnBelt):
    """A spring slider on a fault that creeps."""

    m = 100.0
    k = 5e6
    N = 10.0
    v = 1e-3
    friction = fl.RateAndState()
    period = 0.1


def test_steady_sliding_deflects_the_bristles_by_mu_over_their_stiffness():
    """z = mu(v)/sigma_0 and k x = (mu(v) + sigma_2 v) N."""
    point = fl.equilibrium(Block())
    mu, _ = stribeck(0.2)
    assert np.allclose(point.state, [(mu + 0.02 * 0.2) * 2.0 / 3.0, 0.0, mu / 200.0], rtol=1e-13)
    backwards = fl.equilibrium(Block(v=-0.2))
    assert np.allclose(backwards.state, -point.state, rtol=1e-13)


def test_eigenvalues_are_those_of_the_jacobian_by_hand():
    m, k, N, v, s0, s1, s2 = 0.5, 3.0, 2.0, 0.2, 200.0, 0.5, 0.02
    mu, slope = stribeck(v)
    z = mu / s0
    by_speed = 1.0 - s0 * z / mu + s0 * v * z * slope / mu**2  # of z' by v_r
    by_state = -s0 * v / mu
    force = N * (s0 + s1 * by_state), N * (s1 * by_speed + s2)
    A = [[0.0, 1.0, 0.0], [-k / m, -force[1] / m, force[0] / m], [0.0, -by_speed, by_state]]
    expected = np.linalg.eigvals(A)
    found = fl.eigenvalues(Block()).values
    assert np.allclose(np.sort_complex(found), np.sort_complex(expected), rtol=1e-12)


def test_a_run_agrees_with_an_independent_integrator_split_where_v_r_is_zero():
    """Stick-slip of the bristles by scipy, from one zero of v_r to the next."""
    run = fl.simulate(Block(), 4.0, x0={"z": 1e-4}, progress=False)

    def rates(t, state, sign):
        x, v, z = state
        v_r = 0.2 - v
        deflecting = v_r - 200.0 * sign * v_r / stribeck(v_r)[0] * z
        return [v, (2.0 * (200.0 * z + 0.5 * deflecting + 0.02 * v_r) - 3.0 * x) / 0.5, deflecting]

    phases = {
        sign: (partial(rates, sign=sign), ((lambda t, z, sign=sign: sign * (0.2 - z[1]), -sign),))
        for sign in (1.0, -1.0)
    }
    state, crossings = until_events(phases, 1.0, [0.0, 0.0, 1e-4], 4.0)
    assert len(run.events) == len(crossings) > 3
    assert np.allclose(run.events.t, [t for t, *_ in crossings], atol=1e-8)
    assert np.allclose(run.final_state, state, atol=1e-8)
    assert {*run.mode} == {"slip+", "slip-"}
    assert np.array_equal(run["z"], run.states[:, 2])
    audit = fl.energy_audit(run, progress=False)
    assert audit.error < 1e-13
    assert np.allclose(audit.energies["bristles"], 200.0 * run["z"] ** 2 / 2 * 2.0, rtol=1e-15, atol=0.0)
    assert np.diff(audit.works["friction"]).max() < 0.0  # what is dissipated never comes back


def test_dahls_loops_are_exponentials_of_the_displacement():
    """Between reversals z = z_s - (z_s - z_0) exp(-sigma_0 s/mu), whatever the motion; so in F_T over x."""
    mu, s0 = 0.3, 50.0
    model = Block(v=0.0, friction=fl.Dahl(mu_k=mu, sigma_0=s0))
    run = fl.simulate(model, 8.0, x0={"x": 0.7}, progress=False)
    turns = np.concatenate([[0.0], run.events.t, [8.0]])
    assert len(turns) > 6
    for begin, end in itertools.pairwise(turns):
        t = np.linspace(begin, end, 9)
        x, z = run(t)[:, 0], run(t)[:, 2]
        sign = np.sign(x[0] - x[-1])  # v_r = -x'
        moved = np.abs(x - x[0])
        expected = sign * mu / s0 + (z[0] - sign * mu / s0) * np.exp(-s0 * moved / mu)
        assert np.allclose(z, expected, atol=1e-14)
        assert np.allclose(run.output("friction_force", t), 2.0 * s0 * expected, atol=1e-11)


@pytest.mark.parametrize("law", [fl.RateAndState, fl.RateAndStateSlip])
def test_a_spring_slider_is_stable_above_the_critical_stiffness(law):
    """k_c = (b - a) N/D_c (1 + m v^2/(N a D_c)), Rice and Ruina 1983; w^2 = (b - a)/a (v/D_c)^2 there."""
    a, b, D_c, m, N, v = 0.008, 0.02, 1e-5, 100.0, 10.0, 1e-3
    model = Fault(friction=law(a=a, b=b, D_c=D_c))
    stiffness = (b - a) * N / D_c * (1.0 + m * v**2 / (N * a * D_c))
    (change,) = fl.stability_changes(model, "k", bounds=(0.1 * stiffness, 5.0 * stiffness))
    assert change.value == pytest.approx(stiffness, rel=1e-9)
    assert change.direction == "regain"
    assert 2.0 * math.pi * change.frequency == pytest.approx(math.sqrt((b - a) / a) * v / D_c, rel=1e-9)
    heaviest = 5e6 * D_c / (b - a) - m * v**2 / (a * D_c)  # N at which 5e6 N/m is critical
    found = fl.critical_value(model, "N", bounds=(0.1, 10.0 * heaviest))
    assert found == pytest.approx(heaviest, rel=1e-9)
    point = fl.equilibrium(model)
    assert point.state == pytest.approx(
        [N / 5e6 * (0.6 + (a - b) * math.log(v / 1e-6)), 0, math.log(1e-6 / v)]
    )


@pytest.mark.parametrize("m", [1e-9, 1e-6, 1e-3, 1.0])
def test_a_mode_many_decades_slower_than_the_fastest_loses_stability_where_it_does(m):
    """The critical stiffness as above; the mode's 0.08 1/s are up to 15 decades below the fastest."""
    a, b, D_c, N, v = 0.01, 0.015, 1e-5, 10.0, 1.1e-6
    model = Fault(m=m, v=v, friction=fl.RateAndState(a=a, b=b))
    stiffness = (b - a) * N / D_c * (1.0 + m * v**2 / (N * a * D_c))
    (change,) = fl.stability_changes(model, "k", bounds=(500.0, 25000.0))
    assert change.value == pytest.approx(stiffness, rel=1e-12)
    assert 2.0 * math.pi * change.frequency == pytest.approx(math.sqrt((b - a) / a) * v / D_c, rel=1e-9)
    verdicts = [fl.eigenvalues(model.replace(k=stiffness * (1.0 + s))).stable for s in (-1e-6, 1e-6)]
    assert verdicts == [False, True]
    heaviest = fl.sensitivity(model.replace(k=5e3), fl.CriticalValue("N", (1.0, 90.0)))
    assert heaviest.value == pytest.approx(5e3 * D_c / (b - a) - m * v**2 / (a * D_c), rel=1e-12)
    assert heaviest["k"] == pytest.approx(D_c / (b - a), rel=1e-9)


def test_contacts_of_one_law_have_states_of_their_own():
    """Two blocks with bristles; their states are numbered as their forces are."""
    model = fl.TwoBlocks(friction=BRISTLES)
    assert model.automaton().state_names == ("x1", "x2", "x1'", "x2'", "z_1", "z_2")
    run = fl.simulate(model, 3.0, x0={"z_2": 1e-3}, progress=False)
    assert run["z_2"][0] == 1e-3
    assert run["z_1"][0] == 0.0
    assert fl.energy_audit(run, progress=False).error < 1e-13


@pytest.mark.slow
def test_other_models_take_such_a_law_by_replace():
    """Steady sliding of the paper's slider is that with Coulomb's coefficient."""
    flat = fl.SliderOnBelt(F=100.0).without("geometry")
    bristles, coulomb = flat.replace(friction=fl.Dahl(mu_k=0.4)), flat.replace(mu_k=0.4)
    one, other = fl.equilibrium(bristles), fl.equilibrium(coulomb)
    assert np.allclose(one.q, other.q, rtol=1e-9)
    assert one.friction_force == pytest.approx(other.friction_force, rel=1e-9)
    assert bristles.without("nonsmooth").automaton().names == ("slip+", "slip-")
    assert fl.eigenvalues(bristles.without("nonsmooth")).values == pytest.approx(
        fl.eigenvalues(bristles).values, rel=1e-12
    )


@pytest.mark.parametrize("interface", [fl.SlidingOnly(), fl.SlidingSeparation()])
@pytest.mark.parametrize("law", [fl.LuGre(), fl.Jenkins()])
def test_a_law_with_states_turns_its_force_also_where_slip_keeps_its_direction(law, interface):
    """The motion is that with stick and slip; bristles stay within mu_s/sigma_0."""
    sliding, x0 = fl.MassOnBelt(friction=law, v=0.2, interface=interface), {"x": -0.5, "x'": 0.5}
    run = fl.simulate(sliding, 3.0, x0=x0, progress=False)
    other = fl.simulate(sliding.replace(interface=fl.StickSlip()), 3.0, x0=x0, progress=False)
    assert np.array_equal(run.final_state, other.final_state)
    assert {"slip+", "slip-"} <= {*run.mode.tolist()}
    if isinstance(law, fl.LuGre):
        assert np.abs(run["z"]).max() < law.mu_s / law.sigma_0


@dataclass(frozen=True)
class Returning(fl.Dahl):
    """Bristles that return slowly while the bodies are apart."""

    def rates_in_separation(self, z):
        return {"z": -30.0 * z}


@fl.model
class Lifted(fl.MechanicalModel):
    """A block that a force lifts off an elastic belt once in a period."""

    friction: fl.FrictionLaw = fl.Dahl(mu_k=0.3, sigma_0=100.0)
    coordinates = ("x", "y")
    period = 2.0

    def mechanics(self, q, v):
        rubbing = fl.Friction(0.5 - v.x, lambda depth: 400.0 * depth, self.friction, penetration=q.y)
        lift = 15.0 * fl.functions.cos(q.phase)
        return fl.Mechanics(
            (v.x**2 + v.y**2) / 2,
            20.0 * q.x**2 + 5.0 * q.y**2,
            dissipation=v.y**2,
            loads={"y": 10.0 - lift},
            frequency=3.0,
            contacts=(rubbing,),
        )


def test_bristles_spring_back_where_the_contact_is_lost_unless_the_law_says_otherwise():
    run = fl.simulate(Lifted(), 12.0, progress=False)
    opens = np.flatnonzero(run.events.target == "separation")
    assert len(opens)
    assert np.abs(run.events.before[opens, 5]).max() > 1e-4
    assert not run.events.state[opens, 5].any()
    assert not run["z"][run.mode == "separation"].any()
    assert fl.energy_audit(run, progress=False).error < 1e-12

    run = fl.simulate(Lifted(friction=Returning(mu_k=0.3, sigma_0=100.0)), 12.0, progress=False)
    opens = np.flatnonzero(run.events.target == "separation")[1]
    begin, end = run.events.t[opens : opens + 2]
    assert np.array_equal(run.events.before[opens], run.events.state[opens])
    assert run.events.before[opens + 1, 5] == pytest.approx(
        run.events.state[opens, 5] * math.exp(-30.0 * (end - begin)), rel=1e-12
    )


def test_a_run_that_begins_in_flight_has_no_deflection_unless_the_law_says_otherwise():
    x0 = {"y": -0.05, "z": 0.01}
    assert not fl.simulate(Lifted(), 0.01, x0=x0, progress=False)["z"].any()
    assert fl.simulate(Lifted(), 0.01, x0={"y": 0.05, "z": 0.01}, progress=False)["z"][0] == 0.01
    kept = Lifted(friction=Returning(mu_k=0.3, sigma_0=100.0))
    assert fl.simulate(kept, 0.01, x0=x0, progress=False)["z"][0] == 0.01


@dataclass(frozen=True)
class Worn(fl.FrictionLaw):
    """A law of one's own with two states: bristles, and a film that sliding wears off."""

    mu_film: float = 0.4
    sigma_film: float = 80.0
    states = ("z", "film")

    def force(self, normal_force, relative_velocity, z, film):
        return self.sigma_film * z * normal_force / (1 + film**2)

    def rates(self, normal_force, relative_velocity, z, film):
        return {
            "film": 0.1 - abs(relative_velocity) * film,
            "z": relative_velocity - self.sigma_film / self.mu_film * abs(relative_velocity) * z,
        }


def test_a_law_of_ones_own_needs_no_sympy():
    """In steady sliding the film is 0.1/v and z = mu/sigma."""
    fl.testing.check_law(Worn())
    model = Block(friction=Worn())
    film = 0.1 / 0.2
    assert fl.equilibrium(model).state == pytest.approx(
        [0.4 * 2.0 / 3.0 / (1 + film**2), 0.0, 0.4 / 80.0, film], rel=1e-12
    )
    assert "Derivative(film(t), t) = -film(t)*Abs(v_r(t)) + 0.1" in str(model.equations("slip"))
    assert "Derivative(film(t), t) = -film(t)*v_r(t) + 0.1" in str(model.equations("slip+"))
    fl.testing.check_model(model)


@pytest.mark.parametrize("law", [fl.LuGre(), fl.Dahl(), fl.RateAndState(), fl.RateAndStateSlip()])
def test_the_laws_pass_their_check(law):
    fl.testing.check_law(law)


def test_an_orbit_of_bristles_closes():
    """Stick-slip settles to a stable orbit; one of its multipliers is 1."""
    model = Block()
    settled = fl.steady_state(model, transient=60.0, window=30.0, progress=False)
    assert settled.kind == "periodic"
    orbit = fl.periodic_orbit(model, settled)
    assert orbit.stable
    assert len(orbit.multipliers) == 3
    assert np.abs(orbit.multipliers - 1.0).min() < 1e-8


@pytest.mark.slow
@pytest.mark.parametrize("model", [Block(), Lifted(), fl.TwoBlocks(friction=BRISTLES)])
def test_verify_finds_nothing(model):
    assert fl.verify(model, 6.0, progress=False).ok


def test_a_force_that_jumps_with_the_sign_of_v_r_fails_the_check():
    @dataclass(frozen=True)
    class Jumping(fl.Dahl):
        def force(self, normal_force, relative_velocity, z):
            return 0.1 * normal_force * relative_velocity / abs(relative_velocity)

    with pytest.raises(AssertionError, match="must not jump where the relative velocity changes its sign"):
        fl.testing.check_law(Jumping())


@dataclass(frozen=True)
class NoRates(fl.FrictionLaw):
    states = ("z",)

    def force(self, normal_force, relative_velocity, z):
        return z


@dataclass(frozen=True)
class OtherRates(NoRates):
    def rates(self, normal_force, relative_velocity, z):
        return {"y": z}


@dataclass(frozen=True)
class Named(fl.Dahl):
    states = ("x",)


@dataclass(frozen=True)
class Renamed(fl.Dahl):
    states = ("bristle",)


@pytest.mark.parametrize(
    ("law", "error", "message"),
    [
        (NoRates(), NotImplementedError, r"NoRates must define rates\(normal_force, relative_velocity, z\)"),
        (
            OtherRates(),
            ValueError,
            r'OtherRates.rates must give the rate of each of its states z, got y: write return \{"z": ...\}',
        ),
        (Named(), ValueError, "the state 'x' of a friction law must differ from the coordinates"),
    ],
)
def test_errors_name_the_cure(law, error, message):
    with pytest.raises(error, match=message):
        fl.simulate(Block(friction=law), 1.0, progress=False)


def own_law(states=("z",), **methods):
    """A law like Dahl's, with other states or methods."""

    def force(self, normal_force, relative_velocity, *z):
        return 100.0 * z[0] * normal_force

    def rates(self, normal_force, relative_velocity, *z):
        return {
            name: relative_velocity - 300.0 * abs(relative_velocity) * one for name, one in zip(states, z)
        }

    return dataclass(frozen=True)(
        type("Own", (fl.FrictionLaw,), {"states": states, "force": force, "rates": rates} | methods)
    )


@pytest.mark.parametrize(
    ("states", "message"),
    [
        ((1,), "must be different names of letters, digits and _, got 1"),
        (("my z",), "must be different names of letters, digits and _, got 'my z'"),
        (("",), "must be different names of letters, digits and _, got ''"),
        (("z", "z"), "must be different names of letters, digits and _, got 'z'"),
        (("normal_force",), "must not have the name 'normal_force'"),
        (("phase",), "must not have the name 'phase'"),
        (("t",), "must not have the name 't'"),  # a structure took it
        ("z", "must be a sequence such as a list, got 'z'"),
    ],
)
def test_states_have_names_of_their_own(states, message):
    with pytest.raises(ValueError, match=rf"states of Own {message}.*: write states = \(\"z\",\)"):
        own_law(states)()


def limit(self, normal_force):
    return 3e-3 * normal_force


@pytest.mark.parametrize(
    ("methods", "message"),
    [
        ({"rates": lambda self, n, v, z: np.array([v * z])}, r"Own\.rates must give the rate of each of its"),
        ({"rates": lambda self, n, v, z: {"z": np.array([v])}}, r"Own\.rates must return a formula, got \["),
        ({"rates": lambda self, n, v, z: {"z": "v"}}, r"Own\.rates must return a formula, got 'v'"),
        ({"force": lambda self, n, v, z: "z"}, r"Own\.force must return a formula, got 'z'"),
        ({"state_limit": lambda self, n: "0.3"}, r"Own\.state_limit must return a formula, got '0\.3'"),
        (
            {"rates_in_separation": lambda self, z: [0.0]},
            r"Own\.rates_in_separation must give the rate of each",
        ),
        ({"state_limit": limit}, r"Own must not have abs\(relative_velocity\) in force and rates"),
    ],
)
def test_methods_return_formulas(methods, message):
    with pytest.raises((TypeError, ValueError), match=message):
        fl.simulate(Lifted(friction=own_law(**methods)()), 1.0, progress=False)
    if "rates_in_separation" not in methods:
        with pytest.raises((TypeError, ValueError), match=message):
            fl.testing.check_law(own_law(**methods)())


def test_a_derived_class_renames_the_state():
    assert fl.simulate(Block(friction=Renamed()), 0.1, progress=False)["bristle"][-1] > 0.0
