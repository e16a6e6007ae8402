"""Coordinates that turn for ever: steady rotation is an equilibrium, and orbits close up to turns."""

import math
from functools import partial

import numpy as np
import pytest
from scipy.optimize import brentq

import frictionlab as fl
from tests.reference.phases import until_events

J1, J2, K, C, DRIVE, TORQUE = 2000.0, 400.0, 500.0, 50.0, 400.0, 2000.0
MU_K, MU_S, DECAY = 0.5, 1.0, 3.0


@fl.model
class Drill(fl.MechanicalModel):
    """A drill string: a driven table, a shaft, and a bit with friction that falls with its speed."""

    Omega: float = 10.0
    friction: fl.FrictionLaw = fl.ExponentialDecay(mu_k=MU_K, mu_s=MU_S, v_s=DECAY)
    coordinates = ("table", "bit")
    cyclic = ("table", "bit")
    period = 5.0

    def mechanics(self, q, v):
        return fl.Mechanics(
            J1 * v.table**2 / 2 + J2 * v.bit**2 / 2,
            K * (q.table - q.bit) ** 2 / 2,
            C * (v.table - v.bit) ** 2 / 2 + DRIVE * (v.table - self.Omega) ** 2 / 2,
            contacts=(fl.Friction(-v.bit, TORQUE, self.friction),),
        )


def drill_speed(omega):
    """The speed at which the drive's torque is that of the bit."""
    return brentq(lambda w: DRIVE * (omega - w) - TORQUE * bit_friction(w), 0.0, omega)


def bit_friction(w):
    return MU_K + (MU_S - MU_K) * math.exp(-w / DECAY)


def drill_matrix(omega):
    """Of the twist and the two speeds, by hand."""
    slope = -(MU_S - MU_K) / DECAY * math.exp(-drill_speed(omega) / DECAY) * TORQUE
    return np.array(
        [
            [0.0, 1.0, -1.0],
            [-K / J1, -(C + DRIVE) / J1, C / J1],
            [K / J2, C / J2, -(C + slope) / J2],
        ]
    )


def test_steady_rotation_is_an_equilibrium():
    point = fl.equilibrium(Drill())
    w = drill_speed(10.0)
    assert np.allclose(point.state, [TORQUE * bit_friction(w) / K, 0.0, w, w], rtol=1e-13)
    assert "bit' 7.279" in repr(point)
    assert point.friction_force == pytest.approx(-TORQUE * bit_friction(w), rel=1e-13)


def test_its_eigenvalues_are_those_without_the_rotation():
    found = fl.eigenvalues(Drill())
    expected = np.linalg.eigvals(drill_matrix(10.0))
    assert np.allclose(np.sort_complex(found.values), np.sort_complex(expected), rtol=1e-12)
    assert found.vectors.shape == (4, 3)
    assert np.allclose(found.participation.sum(axis=0), 1.0)
    locus = fl.root_locus(Drill(), "Omega", [10.0, 12.0])
    assert np.allclose(locus.growth_rates[0].max(), expected.real.max(), rtol=1e-12)


def test_it_loses_stability_where_the_matrix_does():
    """At low speeds friction falls too fast; also by the Hopf point there."""

    def growth(omega):
        return np.linalg.eigvals(drill_matrix(omega)).real.max()

    expected = brentq(growth, 6.5, 9.0, xtol=1e-13)
    (change,) = fl.stability_changes(Drill(), "Omega", bounds=(6.5, 30.0))
    assert change.value == pytest.approx(expected, rel=1e-9)
    assert fl.hopf(Drill(), "Omega", bounds=(6.5, 30.0)).value == pytest.approx(expected, rel=1e-9)


def test_stick_slip_of_the_bit_is_an_orbit_that_closes_up_to_a_turn():
    """Also by scipy: what of twist and speeds an integration of slip, stick and slip comes back to."""
    model = Drill(Omega=5.0)
    settled = fl.steady_state(model, transient=200.0, window=50.0, progress=False)
    orbit = fl.periodic_orbit(model, settled)
    assert orbit.stable
    assert {mode for mode, _ in orbit.modes} == {"stick", "slip-"}
    assert np.abs(orbit.multipliers - 1.0).min() < 1e-9

    def rates(t, z, sticks):
        twist, table, bit = z
        string = K * twist + C * (table - bit)
        pull = 0.0 if sticks else (string - TORQUE * bit_friction(bit)) / J2
        return [table - bit, (DRIVE * (5.0 - table) - string) / J1, pull]

    def breaks(t, z):
        return TORQUE * MU_S - K * z[0] - C * z[1]

    phases = {
        "slip": (partial(rates, sticks=False), ((lambda t, z: z[2], lambda t, z: ("stick", [*z[:2], 0.0])),)),
        "stick": (partial(rates, sticks=True), ((breaks, "slip"),)),
    }
    table, bit, *speeds = orbit.state
    first = [table - bit, *speeds]
    z, _ = until_events(phases, "stick" if speeds[1] == 0.0 else "slip", first, orbit.period)
    assert np.allclose(z, first, atol=1e-7)


@fl.model
class Over(fl.MechanicalModel):
    """A pendulum that a torque turns over the top."""

    T: float = 3.0
    c: float = 0.5
    coordinates = ("phi",)
    cyclic = ("phi",)

    def mechanics(self, q, v):
        stored = 1 - fl.functions.cos(q.phi)
        return fl.Mechanics(v.phi**2 / 2, stored, self.c * v.phi**2 / 2, loads={"phi": self.T})


def test_a_pendulum_goes_over_the_top_on_an_orbit():
    """The product of the multipliers is exp(-c T), by Liouville's theorem."""
    settled = fl.steady_state(Over(), transient=60.0, window=20.0, progress=False)
    orbit = fl.periodic_orbit(Over(), settled)
    run = orbit.trajectory
    assert run.final_state[0] - orbit.state[0] == pytest.approx(2.0 * math.pi, rel=1e-12)
    assert np.prod(orbit.multipliers).real == pytest.approx(math.exp(-0.5 * orbit.period), rel=1e-9)


def test_where_something_depends_on_the_angle_equilibria_are_at_rest():
    found = fl.equilibria(Over(T=0.5))
    assert found[0].state == pytest.approx([math.asin(0.5), 0.0], rel=1e-12)


@fl.model
class Gears(fl.MechanicalModel):
    """Two wheels whose teeth are springs: one turns r times as fast."""

    r: float = 2.5
    coordinates = ("fast", "slow")
    cyclic = ("fast", "slow")

    def mechanics(self, q, v):
        return fl.Mechanics(
            v.fast**2 / 2 + 3.0 * v.slow**2 / 2,
            40.0 * (q.fast - self.r * q.slow) ** 2 / 2,
            0.2 * v.fast**2 / 2 + 0.1 * v.slow**2 / 2,
            loads={"fast": 5.0},
        )


def test_wheels_turn_in_their_ratio():
    """Of the teeth's deflection d = fast - r slow and the speeds, by hand."""
    r, k = 2.5, 40.0
    A = [[0.0, 1.0, -r], [-k, -0.2, 0.0], [r * k / 3.0, 0.0, -0.1 / 3.0]]
    found = fl.eigenvalues(Gears())
    assert np.allclose(np.sort_complex(found.values), np.sort_complex(np.linalg.eigvals(A)), rtol=1e-11)
    fast, slow, w, w_slow = found.equilibrium.state
    assert w == pytest.approx(r * w_slow, rel=1e-13)
    assert w_slow == pytest.approx(5.0 * r / (0.2 * r**2 + 0.1), rel=1e-12)
    assert fast - r * slow == pytest.approx(0.1 * w_slow / (r * k), rel=1e-12)


def test_an_automaton_and_its_files_know_cyclic_coordinates(tmp_path):
    automaton = Drill().automaton()
    assert automaton.cyclic == automaton.replace(Omega=7.0).cyclic == ("table", "bit")
    assert fl.eigenvalues(automaton).values == pytest.approx(fl.eigenvalues(Drill()).values)
    run = fl.solve(automaton.derived(), 1.0, x0=[0.0, 0.0, 5.0, 5.0], progress=False)
    assert fl.load(run.save(tmp_path / "run.npz")).automaton.cyclic == ("table", "bit")


@pytest.mark.slow
def test_analyses_of_rotation():
    """Runs from near it, a continued orbit, a bifurcation diagram."""
    run = fl.simulate(Drill(), 300.0, x0="near", progress=False)
    assert run["bit'"][-1] == pytest.approx(drill_speed(10.0), rel=1e-6)
    settled = fl.steady_state(Drill(Omega=6.0), transient=200.0, window=50.0, progress=False)
    orbit = fl.periodic_orbit(Drill(Omega=6.0), settled)
    branch = fl.continue_orbit(orbit, "Omega", (5.5, 6.5), progress=False)
    assert [branch.values.min(), branch.values.max()] == pytest.approx([5.5, 6.5])
    diagram = fl.bifurcation(
        Drill(), "Omega", [5.0, 20.0], transient=200, window=100, progress=False, workers=1
    )
    assert [str(kind) for kind in diagram.kinds] == ["periodic", "equilibrium"]


def test_a_name_that_is_no_coordinate_is_refused():
    @fl.model
    class Wrong(Over):
        cyclic = ("ph",)

    with pytest.raises(ValueError, match="cyclic must have names of coordinates, each once, got 'ph'"):
        Wrong()


@fl.model
class Towed(fl.MechanicalModel):
    """A sled on a rough floor that a motor tows over a coupling with play."""

    R: float = 1.0
    L: float = 0.05
    K: float = 2.0
    U: float = 6.0
    k: float = 200.0
    friction: fl.FrictionLaw = fl.Coulomb(mu_k=0.3, mu_s=0.39)
    coordinates = ("x", "y", "a")
    states = ("i",)
    cyclic = ("x", "a")

    def mechanics(self, q, v, further):
        stretch = q.a - q.x
        pull = self.k * (fl.functions.maximum(stretch - 0.01, 0) + fl.functions.minimum(stretch + 0.01, 0))
        return fl.Mechanics(
            kinetic=(v.x**2 + v.y**2 + 0.1 * v.a**2) / 2,
            potential=9.81 * q.y,
            dissipation=0.05 * v.a**2,
            loads={"x": pull, "a": self.K * further.i - pull},
            rates={"i": (self.U - self.R * further.i - self.K * v.a) / self.L},
            contacts=(fl.Stop(q.y, fl.PlasticImpact(), friction=self.friction, relative_velocity=-v.x),),
        )


@pytest.mark.slow  # its modes are derived
def test_a_motion_is_steady_where_a_law_in_pieces_depends_on_a_difference():
    """K i = mu m g + c v and U = R i + K v; eigenvalues of (stretch, x', a', i) by hand."""
    (point,) = fl.equilibria(Towed())
    force = 0.3 * 9.81
    speed = (6.0 - force / 2) / 2.05
    stretch = point.state[2] - point.state[0]
    assert [stretch, *point.state[[3, 5, 6]]] == pytest.approx(
        [0.01 + force / 200, speed, speed, (force + 0.1 * speed) / 2], rel=1e-12
    )
    matrix = [[0, -1, 1, 0], [200, 0, 0, 0], [-2000, 0, -1, 20], [0, 0, -40, -20]]
    assert np.sort_complex(fl.eigenvalues(Towed()).values) == pytest.approx(
        np.sort_complex(np.linalg.eigvals(np.array(matrix, dtype=float))), rel=1e-11
    )


@pytest.mark.parametrize("cyclic", [("a", "b"), ("b", "a"), ["b", "a"]])
def test_the_order_in_which_coordinates_are_called_cyclic_does_not_matter(cyclic):
    """Gears of ratio 3: a' = 3 b', and the accelerations are zero."""

    @fl.model
    class Gears(fl.MechanicalModel):
        Omega: float = 4.0
        coordinates = ("a", "b")

        def mechanics(self, q, v):
            drag = 0.1 * (v.a - self.Omega) ** 2 + 0.05 * v.b**2 + 0.2 * (v.a - 3 * v.b) ** 2
            return fl.Mechanics(
                kinetic=(v.a**2 + v.b**2) / 2, potential=20 * (q.a - 3 * q.b) ** 2, dissipation=drag
            )

    Gears.cyclic = cyclic
    state = fl.equilibrium(Gears()).state
    speed = 2 * 0.1 * 3 * 4.0 / (2 * 0.1 * 9 + 2 * 0.05)  # of b, where the moments on both together vanish
    assert state[2:] == pytest.approx([3 * speed, speed])
    run = fl.simulate(Gears(), 400.0, progress=False)
    assert run.v[-1] == pytest.approx(state[2:])


@fl.model
class InertiaDrive(fl.MechanicalModel):
    """A slider on a rod that goes forth slowly, with 2, and back fast, with 8: it follows forth alone."""

    friction: fl.FrictionLaw = fl.Coulomb(mu_k=0.3, mu_s=0.3)
    coordinates = ("x",)
    cyclic = ("x",)
    period = 1.0

    def mechanics(self, q, v):
        speed = fl.functions.piecewise(q.phase, (1.6 * math.pi,), (2.0, -8.0))
        rubbing = fl.Friction(speed - v.x, 20.0, self.friction)
        return fl.Mechanics(v.x**2 / 2, contacts=(rubbing,), frequency=2 * math.pi)


def test_an_inertia_drive_steps_on():
    """In slip its speed changes by 6 s: back for 0.2 s, and forth again for 0.2 s, until it sticks."""
    model = InertiaDrive()
    run = fl.simulate(model, 31.0, x0={"x'": 2.0}, progress=False)
    assert run.final_state[0] - run(30.0)[0] == pytest.approx(2.0 * 0.6 + 2 * (0.2 * (2.0 - 0.6)), rel=1e-12)
    # Both begin at the end of a period, where the clock may or may not have begun anew.
    fl.testing.check_model(model, t_end=4.0)
    exponents = fl.lyapunov(model, transient=20.0, t_end=20.0, progress=False).exponents
    assert exponents == pytest.approx([0.0, 0.0, -np.inf], abs=1e-9)


def test_an_orbit_whose_coordinate_grows_asks_for_its_name():
    growing = type("Growing", (InertiaDrive,), {"cyclic": (), "__module__": __name__, "__annotations__": {}})
    model = fl.model(growing)()
    with pytest.raises(ValueError, match="or list x in cyclic, as what grows for ever"):
        fl.periodic_orbit(model, fl.simulate(model, 30.0, progress=False))
