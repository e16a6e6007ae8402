"""q.t, the time that does not wrap: ramps, tables, belts that brake, and eigenvalues with time frozen."""

import math
import pickle

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import frictionlab as fl
from tests.reference.phases import until_events

V0, T, C, MU_K, MU_S, DECAY = 1.0, 40.0, 0.02, 0.2, 0.5, 0.3


@fl.model
class BrakingBelt(fl.MechanicalModel):
    """A friction oscillator whose belt comes to rest, as V. Pilipchuk, R. Olejnik, J. Awrejcewicz (2015)."""

    v0: float = V0
    T: float = T
    c: float = C
    friction: fl.FrictionLaw = fl.ExponentialDecay(mu_k=MU_K, mu_s=MU_S, v_s=DECAY)
    coordinates = ("x",)
    period = 2.0 * math.pi

    def mechanics(self, q, v):
        belt = fl.ramp(q.t, start=self.v0, end=0.0, duration=self.T)
        rubbing = fl.Friction(belt - v.x, 1.0, self.friction)
        return fl.Mechanics(v.x**2 / 2, q.x**2 / 2, self.c * v.x**2 / 2, contacts=(rubbing,))


def braking_reference(z, t_end):
    """Slip and stick by DOP853 from event to event."""

    def belt(t):
        return V0 * (1 - t / T)

    def slip(t, z):
        mu = MU_K + (MU_S - MU_K) * math.exp(-(belt(t) - z[1]) / DECAY)
        return [z[1], mu - z[0] - C * z[1]]

    def stops(t, z):
        return belt(t) - z[1]

    def breaks(t, z):
        return MU_S - (-V0 / T + z[0] + C * belt(t))

    phases = {
        "slip": (slip, ((stops, lambda t, z: ("stick", [z[0], belt(t)])),)),
        "stick": (lambda t, z: [belt(t), -V0 / T], ((breaks, "slip"),)),
    }
    z, events = until_events(phases, "slip", z, t_end, atol=1e-14)
    return np.array([t for t, *_ in events]), z


def test_a_belt_that_brakes_against_an_independent_integration():
    """The oscillation grows as the belt slows down, becomes stick-slip, and ends where the belt rests."""
    run = fl.simulate(BrakingBelt(), 38.0, x0={"x": 0.3}, progress=False)
    times, state = braking_reference([0.3, 0.0], 38.0)
    assert len(run.events) == len(times) >= 3
    assert run.events.t == pytest.approx(times, abs=1e-8)
    assert run.final_state == pytest.approx([*state, 38.0], abs=1e-8)
    assert run["t"] == pytest.approx(run.t, rel=1e-14)
    assert fl.energy_audit(run, progress=False).error < 1e-13
    assert fl.simulate(BrakingBelt(), 60.0, progress=False).mode[-1] == "stick | t > T"
    assert pickle.loads(pickle.dumps(run)).time_in_mode == run.time_in_mode


def test_eigenvalues_with_time_frozen():
    """Re = -(c + mu'(v))/2: steady sliding loses its stability where the falling curve is steep enough."""
    times = np.array([0.0, 10.0, 20.0, 30.0, 38.0])
    v = V0 * (1 - times / T)
    slope = -(MU_S - MU_K) / DECAY * np.exp(-v / DECAY)
    locus = fl.root_locus(BrakingBelt(), "t", times)
    assert locus.growth_rates[:, 0] == pytest.approx(-(C + slope) / 2, rel=1e-9)


@pytest.mark.parametrize(
    "study", [fl.equilibria, fl.eigenvalues, lambda m: fl.critical_value(m, "v0", (0.1, 2))]
)
def test_what_needs_equilibria_says_what_to_do(study):
    with pytest.raises(ValueError, match=r"must not depend on the time q\.t .*root_locus"):
        study(BrakingBelt())


def test_an_orbit_needs_a_model_without_time():
    run = fl.simulate(BrakingBelt(), 10.0, progress=False)
    with pytest.raises(ValueError, match=r"must not depend on the time q\.t to have a periodic"):
        fl.periodic_orbit(BrakingBelt(), run)


@pytest.mark.parametrize(
    ("study", "what"),
    [
        (lambda m: fl.steady_state(m, progress=False), "a steady state"),
        (lambda m: fl.ablation(m, fl.steady_state, progress=False), "a steady state"),
        (lambda m: fl.ablation(m, {"rates": fl.eigenvalues}, progress=False), "an equilibrium"),
        (lambda m: fl.bifurcation(m, "v0", [0.5, 1.0], progress=False), "a bifurcation diagram"),
        (lambda m: fl.lyapunov(m, progress=False), "Lyapunov exponents"),
        (lambda m: fl.basins(m, ("x", [0.0, 1.0]), ("x'", [0.0, 1.0]), progress=False), "basins"),
        (lambda m: fl.basin_stability(m, {"x": (0.0, 1.0)}, 10, progress=False), "basins"),
    ],
)
def test_what_motions_settle_to_needs_a_model_without_time(study, what):
    with pytest.raises(ValueError, match=rf"must not depend on the time q\.t to have {what}"):
        study(BrakingBelt())


def test_a_ramp_has_a_duration():
    with pytest.raises(ValueError, match=r"duration must be a number above 0, got 0(\.0)?: write piecewise"):
        fl.ramp(1.0, 0.0, 1.0, 0.0)


@fl.model
class Pressed(fl.MechanicalModel):
    """A mass on a spring under a table of forces, and a damper that a ramp opens."""

    kind: str = "linear"
    coordinates = ("x",)
    period = 6.0

    def mechanics(self, q, v):
        force = fl.table(q.t, {1.0: 0.0, 2.0: 1.0, 4.0: 1.0}, kind=self.kind)
        return fl.Mechanics(v.x**2 / 2, q.x**2 / 2, loads={"x": force})


def test_a_table_of_forces():
    """x = (t - 1) - sin(t - 1) along the ramp of 1 s, then 1 and two free vibrations of it."""
    run = fl.simulate(Pressed(), 6.0, progress=False)
    expected = [0.0, 0.5 - math.sin(0.5), 1.0 - math.sin(5.0) + math.sin(4.0)]
    assert run(np.array([1.0, 1.5, 6.0]))[:, 0] == pytest.approx(expected, abs=1e-14)
    assert run.events.t == pytest.approx([1.0, 2.0, 4.0], abs=1e-15)
    assert fl.energy_audit(run, progress=False).error < 1e-14


def test_a_table_of_smooth_forces_against_scipy():
    from scipy.interpolate import PchipInterpolator

    curve = PchipInterpolator([1.0, 2.0, 4.0], [0.0, 1.0, 1.0])
    z = [0.0, 0.0]
    for begin, end in ((1.0, 2.0), (2.0, 4.0)):
        rates = lambda t, z: [z[1], float(curve(t)) - z[0]]  # noqa: E731  a line of two formulas
        z = solve_ivp(rates, (begin, end), z, method="DOP853", rtol=1e-13, atol=1e-15).y[:, -1]
    run = fl.simulate(Pressed(kind="pchip"), 4.0, progress=False)
    assert run.final_state[:2] == pytest.approx(z, abs=1e-12)


def test_time_in_energies_and_distances():
    """A spring whose end moves as a t^2/2 is a load k a t^2/2, whose power is that of moving springs."""

    @fl.model
    class Pulled(fl.MechanicalModel):
        a: float = 0.3
        coordinates = ("x",)
        period = 6.0

        def mechanics(self, q, v):
            return fl.Mechanics(v.x**2 / 2, (q.x - self.a * q.t**2 / 2) ** 2 / 2)

    run = fl.simulate(Pulled(), 3.0, progress=False)
    expected = 0.3 * (3.0**2 / 2 - 1 + math.cos(3.0))
    assert run["x"][-1] == pytest.approx(expected, rel=1e-13)
    audit = fl.energy_audit(run, progress=False)
    assert audit.error < 1e-14
    assert "moving springs" in audit.works
    assert fl.verify(Pulled(), 3.0, progress=False).ok


def test_time_in_the_damper_alone_of_a_contact_with_friction():
    @fl.model
    class Landed(fl.MechanicalModel):
        coordinates = ("x", "y")
        period = 6.0

        def mechanics(self, q, v):
            damper = fl.ramp(q.t, start=1.0, end=5.0, duration=2.0)
            rubbing = fl.Friction(v.x - 1.0, -100 * q.y, fl.Coulomb(), penetration=-q.y, damper=damper)
            return fl.Mechanics((v.x**2 + v.y**2) / 2, 20 * q.x**2, 0, (rubbing,), {"y": -5.0})

    rates = lambda t, y: [y[1], -5.0 - 100 * y[0] - (1 + 2 * t) * y[1]]  # noqa: E731  one line of two formulas
    run = fl.simulate(Landed(), 2.0, x0={"y": -0.03}, progress=False)
    pressed = solve_ivp(rates, (0.0, 2.0), [-0.03, 0.0], method="DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
    assert run.final_state[[1, 3]] == pytest.approx(pressed, abs=1e-10)
    assert fl.energy_audit(run, progress=False).error < 1e-13


def test_a_parameter_may_have_its_name():
    @fl.model
    class Named(fl.MechanicalModel):
        t: float = 2.0
        coordinates = ("x",)
        period = 6.0

        def mechanics(self, q, v):
            return fl.Mechanics(v.x**2 / 2, self.t * q.x**2 / 2)

    class Both(Named):
        def mechanics(self, q, v):
            return fl.Mechanics(v.x**2 / 2, loads={"x": q.t - self.t * q.x})

    with pytest.raises(AttributeError, match="no coordinate or state 't'"):
        fl.model(Both)().automaton()
    assert Named().automaton().state_names == ("x", "x'")
    run = fl.simulate(Named(), 1.0, x0=[1.0, 0.0], progress=False)
    assert run["x"][-1] == pytest.approx(math.cos(math.sqrt(2.0)), rel=1e-13)
