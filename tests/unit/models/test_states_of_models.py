"""Further states of mechanical models: a current, a temperature, the speed of a belt that a motor drives."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import frictionlab as fl


@fl.model
class Motor(fl.MechanicalModel):
    """A motor with a coil, R = 2, L = 0.05, and a damped rotor."""

    U: float = 12.0
    K: float = 0.1
    coordinates = ("theta",)
    states = ("i",)

    def mechanics(self, q, v, s):
        loads = {"theta": self.K * s.i - 0.01 * v.theta}
        rates = {"i": (self.U - 2.0 * s.i - self.K * v.theta) / 0.05}
        return fl.Mechanics(0.02 * v.theta**2 / 2, loads=loads, rates=rates)


@fl.model
class Started(fl.MechanicalModel):
    """A mass on a belt that comes up to speed: w = U (1 - exp(-2 t))."""

    U: float = 1.0
    k: float = 20.0
    friction: fl.FrictionLaw = fl.Coulomb(mu_k=0.3, mu_s=0.5)
    coordinates = ("x",)
    states = ("w",)
    period = 1.0

    def mechanics(self, q, v, s):
        contact = fl.Friction(s.w - v.x, 10.0, self.friction)
        rates = {"w": 2.0 * (self.U - s.w)}
        return fl.Mechanics(v.x**2 / 2, self.k * q.x**2 / 2, contacts=(contact,), rates=rates)


@fl.model
class Warm(fl.MechanicalModel):
    """A driven block whose friction falls as it becomes warm; the phase comes before the temperature."""

    F: float = 3.0
    friction: fl.FrictionLaw = fl.Coulomb(mu_k=0.4, mu_s=0.4)
    impact: fl.ImpactLaw = fl.RestitutionImpact(e=0.6)
    coordinates = ("x",)
    states = ("T",)
    period = 2 * math.pi

    def mechanics(self, q, v, s):
        rub = fl.Friction(-v.x, 2.0 / (1.0 + 0.1 * s.T**2), self.friction)
        return fl.Mechanics(
            v.x**2 / 2,
            q.x**2,
            loads={"x": self.F * fl.functions.cos(q.phase)},
            frequency=1.0,
            contacts=(rub, fl.Stop(2.0 - q.x, self.impact)),
            rates={"T": v.x**2 - 0.3 * s.T},
        )


@fl.model
class Clutch(fl.MechanicalModel):
    """Two shafts that friction keeps together, a motor on one of them, a damper, and the heat of slip."""

    friction: fl.FrictionLaw = fl.Coulomb(mu_k=1.0, mu_s=1.0)
    coordinates = ("phi1", "phi2")
    cyclic = ("phi1", "phi2")
    states = ("i", "T")

    def mechanics(self, q, v, s):
        slip, loads = v.phi1 - v.phi2, {"phi1": 2.0 * s.i}
        rates = {"i": 1.0 - 2.0 * s.i, "T": 10.0 * fl.functions.absolute(slip) - 0.3 * s.T}
        contacts = (fl.Friction(slip, 10.0, self.friction),)
        kinetic = (v.phi1**2 + v.phi2**2) / 2
        return fl.Mechanics(kinetic, dissipation=v.phi2**2 / 2, loads=loads, rates=rates, contacts=contacts)


def test_a_motor_comes_to_the_speed_of_its_closed_form():
    """K U/(2 c + K^2), and before that the solution of two linear equations."""
    run = fl.simulate(Motor(), 300.0, progress=False)
    assert run["theta'"][-1] == pytest.approx(0.1 * 12.0 / (0.02 + 0.01), rel=1e-13)
    A = np.array([[-0.5, 5.0], [-2.0, -40.0]])
    rates, vectors = np.linalg.eig(A)
    still = -np.linalg.solve(A, [0.0, 240.0])
    shares = np.linalg.solve(vectors, -still)
    for t in (0.1, 1.0, 4.0):
        assert np.allclose(run(t)[1:], still + vectors @ (np.exp(rates * t) * shares), rtol=1e-12)


def test_its_eigenvalues_are_those_of_the_matrix():
    found = fl.eigenvalues(Started(friction=fl.Coulomb(mu_k=0.3, mu_s=0.5)))
    assert np.allclose(sorted(found.values.real), [-2.0, 0.0, 0.0], atol=1e-12)
    assert found.frequencies.max() == pytest.approx(math.sqrt(20.0) / (2 * math.pi), rel=1e-12)
    point = fl.equilibrium(Started())
    assert np.allclose(point.state, [0.15, 0.0, 1.0], rtol=1e-13)


def test_stick_on_a_belt_that_speeds_up_ends_where_the_closed_form_says():
    """x follows the belt until x'' + k x = mu_s N, with x'' = 2 U exp(-2 t)."""
    run = fl.simulate(Started(), 2.0, progress=False)

    def excess(t):
        return 2.0 * math.exp(-2.0 * t) + 20.0 * (t - (1.0 - math.exp(-2.0 * t)) / 2.0) - 5.0

    assert run.events.t[0] == pytest.approx(brentq(excess, 0.1, 1.0, xtol=1e-15), rel=1e-13)
    assert (run.events.source[0], run.events.target[0]) == ("stick", "slip+")
    assert run.violation < 1e-13
    audit = fl.energy_audit(run, progress=False)
    assert audit.error < 1e-13


def test_friction_that_a_temperature_softens_agrees_with_another_integrator():
    """Slip one way up to the first stop of the block, by scipy; verify agrees later, past stops and stick."""
    model = Warm()
    assert model.automaton().state_names == ("x", "x'", "phase", "T")
    run = fl.simulate(model, 40.0, x0={"T": 0.5}, progress=False)
    start = float(run.events.t[0])

    def rates(t, z):
        x, v, temperature = z
        pressed = 2.0 / (1.0 + 0.1 * temperature**2)
        return [v, 3.0 * math.cos(t) - 2.0 * x - 0.4 * pressed, v**2 - 0.3 * temperature]

    other = solve_ivp(rates, (0.0, start), [0.0, 0.0, 0.5], method="DOP853", rtol=1e-13, atol=1e-14)
    assert run.events.before[0, [0, 1, 3]] == pytest.approx(other.y[:, -1], rel=1e-11, abs=1e-11)
    assert {"impact_2"} <= {*run.events.guard.tolist()}
    assert fl.verify(model, 10.0, x0={"T": 0.5}, progress=False).ok
    assert fl.energy_audit(run, progress=False).error < 1e-12


def test_exponents_of_shafts_that_stick_together():
    """w' = -0.5 w + i and i' = 1 - 2 i, turning and a twist that stays; heat is gone, and decays at 0.3."""
    model = Clutch()
    exponents = fl.lyapunov(model, transient=100.0, t_end=200.0, progress=False).exponents
    assert exponents == pytest.approx([0.0, 0.0, -0.3, -0.5, -2.0, -np.inf], abs=0.02)


def test_the_equations_and_the_conformance_suite_have_them():
    text = str(Started().equations("stick"))
    assert "Derivative(w(t), t) = 2.0*U - 2.0*w(t)" in text
    fl.testing.check_model(Started(), t_end=3.0)


@pytest.mark.slow
def test_analyses_of_motions_take_them(tmp_path):
    settled = fl.steady_state(Warm(), transient=200.0, window=60.0, progress=False)
    assert settled.kind == "periodic"
    orbit = fl.periodic_orbit(Warm(), settled)
    assert len(orbit.multipliers) == 4
    assert (
        fl.load(fl.simulate(Started(), 1.0, progress=False).save(tmp_path / "run.npz")).final_state[2] > 0.8
    )


def of(states, rates=None, load=0, stored=0, rubbing=None):
    """A model of one mass with these states, rates and energies."""

    @fl.model
    class Mine(fl.MechanicalModel):
        k: float = 1.0
        coordinates = ("x",)

        def mechanics(self, q, v, s=None):
            named = rates(q, v, s) if rates else {}
            contacts = () if rubbing is None else (fl.Friction(rubbing(v, s), 1.0, fl.Coulomb()),)
            return fl.Mechanics(
                v.x**2 / 2, stored and stored(q, s), loads={"x": load}, contacts=contacts, rates=named
            )

    Mine.states = states
    return lambda: fl.simulate(Mine(), 1.0, progress=False)


@fl.model
class Worn(fl.MechanicalModel):
    """A mass on a belt, two depths of wear, and a temperature that settles."""

    wear: float = 0.01
    heat: float = 0.0
    friction: fl.FrictionLaw = fl.Coulomb(mu_k=0.3, mu_s=0.4)
    coordinates = ("x",)
    states = ("w", "u", "T")

    def mechanics(self, q, v, s):
        speed = 1.0 - v.x
        rub = fl.Friction(speed, 1.0 - 0.1 * s.w + 0.1 * s.T, self.friction)
        rates = {"w": self.wear * speed, "u": 2 * self.heat * speed - (1 - self.heat) * s.u, "T": 1 - s.T}
        return fl.Mechanics(v.x**2 / 2, q.x**2 / 2, contacts=(rub,), rates=rates)


@pytest.mark.parametrize(
    ("heat", "words"),
    [
        (0.0, "; with w held at zero, as parameters are, there is one, where w drifts by 0.01 per s: "),
        (1.0, "; with w, u held at zero, .* w drifts by 0.01 per s, u drifts by 2 per s: "),
    ],
)
def test_states_that_drift_are_named_where_there_is_no_equilibrium(heat, words):
    with pytest.raises(ValueError, match=words):
        fl.eigenvalues(Worn(heat=heat))


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (
            of(("k",)),
            ValueError,
            "states of Mine must be names that no coordinate and no parameter has, got 'k'",
        ),
        (of(("x'",)), ValueError, 'got "x\'": rename it'),
        (of(("i", "i")), ValueError, "got 'i': rename it"),
        (of(("t",)), ValueError, "got 't': rename it"),
        (of(("i",)), ValueError, "rates of Mine must be those of its states i, got none"),
        (of((), lambda q, v, s: {"i": v.x}), ValueError, r"its states \(it has none\), got i"),
        (of(("i",), lambda q, v, s: {"i": s.j}), AttributeError, "'j': known are i"),
        (of(("i",), lambda q, v, s: {"i": None}), TypeError, "the rate of 'i' of Mine must be an ex"),
        (
            of(("i",), lambda q, v, s: {"i": v.x}, stored=lambda q, s: s.i * q.x),
            ValueError,
            "must not depend on i, .* what a further state does to a body is a load",
        ),
        (
            of(("i",), lambda q, v, s: {"i": v.x}, rubbing=lambda v, s: 1 - s.i * v.x),
            ValueError,
            "relative_velocity of Mine must be linear in the velocities",
        ),
    ],
)
def test_errors_name_the_cure(call, error, message):
    with pytest.raises(error, match=message):
        call()
