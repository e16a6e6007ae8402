"""Laws in pieces: piecewise, minimum, maximum, absolute, sign, interpolate.  Each border is an event."""

import math
import pickle
from dataclasses import dataclass, replace

import numpy as np
import pytest
import sympy
from scipy.integrate import solve_ivp
from scipy.interpolate import PchipInterpolator

import frictionlab as fl
from frictionlab.stability import jacobian

functions = fl.functions


@fl.model
class Bilinear(fl.MechanicalModel):
    """A spring that is stiffer on one side of its border."""

    k1: float = 1.0
    k2: float = 4.0
    c: float = 0.0
    d: float = 0.0
    F: float = 0.0
    coordinates = ("x",)
    period = 5.0

    def mechanics(self, q, v):
        u = q.x - self.d
        energy = functions.piecewise(q.x, (self.d,), (self.k1 * u**2 / 2, self.k2 * u**2 / 2))
        return fl.Mechanics(v.x**2 / 2, energy, self.c * v.x**2 / 2, loads={"x": self.F})


def one_mass(force):
    """A mass of 1 kg under a force(x, v)."""

    class OneMass(fl.MechanicalModel):
        coordinates = ("x",)
        period = 3.0

        def mechanics(self, q, v):
            return fl.Mechanics(v.x**2 / 2, loads={"x": force(q.x, v.x)})

    return fl.model(OneMass)()


def run(model, t_end, x0):
    return fl.simulate(model, t_end, x0=x0, progress=False)


def test_a_bilinear_oscillator_has_two_half_periods():
    """T = pi (m/k_1)^(1/2) + pi (m/k_2)^(1/2); the border is passed each time, at times known to rounding."""
    model = Bilinear()
    motion = run(model, 20.0, [1.0, 0.0])
    period = math.pi * (1 + 1 / 2)
    out = motion.events[motion.events.source == "x > d"].t
    assert out == pytest.approx(math.pi / 4 + period * np.arange(5), abs=2e-14)
    orbit = fl.periodic_orbit(model, motion)
    assert orbit.period == pytest.approx(period, abs=1e-14)
    assert np.abs(orbit.multipliers) == pytest.approx([1.0, 1.0], abs=1e-10)
    assert fl.energy_audit(motion, progress=False).error < 1e-14


def test_a_border_that_parameters_move_needs_no_new_modes():
    moved = Bilinear(d=0.3)
    assert moved.automaton().modes is Bilinear().automaton().modes
    out = run(moved, 2.0, [1.3, 0.0]).events.t
    assert out == pytest.approx([math.pi / 4], abs=1e-15)


def test_equilibria_and_eigenvalues_of_each_piece():
    """F/k_2 above the border and F/k_1 below it, with that side's eigenvalues; on the border it is said."""
    damped = Bilinear(c=0.1)
    for F, k in ((1.0, 4.0), (-1.0, 1.0)):
        model = damped.replace(F=F)
        assert fl.equilibrium(model).q == pytest.approx([F / k], rel=1e-15)
        expected = -0.05 + 1j * math.sqrt(k - 0.05**2)
        assert fl.eigenvalues(model).values[-1] == pytest.approx(expected, rel=1e-14)
    with pytest.warns(RuntimeWarning, match="on the border x = d"):
        fl.eigenvalues(damped)
    locus = fl.root_locus(damped, "F", [-1.0, -0.5, 0.5, 1.0]).values[:, 0]
    assert np.abs(locus) == pytest.approx([1.0, 1.0, 2.0, 2.0], rel=1e-14)


def test_a_hopf_points_amplitude_holds_as_far_as_a_border():
    """x'' = mu x' - x'^3 - x - max(x - d, 0): the amplitude (4 mu/3)^(1/2) comes to d at mu = 3 d^2/4."""

    @fl.model
    class SelfExcited(fl.MechanicalModel):
        mu: float = -0.1
        d: float = 0.2
        coordinates = ("x",)
        period = 6.0

        def mechanics(self, q, v):
            bumper = functions.maximum(q.x - self.d, 0)
            return fl.Mechanics(v.x**2 / 2, q.x**2 / 2, loads={"x": self.mu * v.x - v.x**3 - bumper})

    assert fl.hopf(SelfExcited(), "mu", (-0.3, 0.4)).valid_until == pytest.approx(0.03, rel=1e-9)


def test_multipliers_with_borders_obey_liouville():
    """Their product is exp of the integral of the divergence: a border of a continuous law adds no factor."""

    @fl.model
    class Bumpers(fl.MechanicalModel):
        coordinates = ("x",)
        period = 6.0

        def mechanics(self, q, v):
            bumpers = functions.piecewise(q.x, (-0.5, 0.5), (q.x + 0.5, 0, q.x - 0.5))
            return fl.Mechanics(v.x**2 / 2, q.x**2 / 2, loads={"x": 0.2 * v.x - v.x**3 - 3 * bumpers})

    model = Bumpers()
    orbit = fl.periodic_orbit(model, run(model, 100.0, [0.6, 0.0]).final_state, t_max=20.0)
    square = {"v^2": model.automaton().states[1] ** 2}
    turn = fl.simulate(model, orbit.period, x0=orbit.state, quadratures=square, progress=False)
    expected = math.exp(0.2 * orbit.period - 3.0 * turn.quadratures["v^2"])
    assert len(turn.events) == 4
    assert np.prod(orbit.multipliers).real == pytest.approx(expected, rel=1e-11)


def test_all_equilibria_are_found_on_all_sides():
    snap = one_mass(lambda x, v: -functions.piecewise(x, (-1, 1), (2 * x + 3, -x, 2 * x - 3)) - v / 10)
    found = fl.equilibria(snap)
    assert found.complete
    assert sorted(one.q[0] for one in found) == pytest.approx([-1.5, 0.0, 1.5], abs=1e-15)
    slopes = {round(one.q[0], 1): jacobian(snap, one.state)[1, 0] for one in found}
    assert slopes == pytest.approx({-1.5: -2.0, 0.0: 1.0, 1.5: -2.0})


def test_a_change_of_stability_at_a_border():
    """A friction curve that falls up to v_r = 1 and rises beyond: the damping jumps there."""

    @fl.model
    class Falling(fl.MechanicalModel):
        v: float = 0.5
        coordinates = ("x",)
        period = 3.0

        def mechanics(self, q, v):
            mu = functions.interpolate(self.v - v.x, (0, 1, 2), (1.0, 0.5, 0.8), kind="linear")
            return fl.Mechanics(v.x**2 / 2, q.x**2 / 2, v.x**2 / 20, loads={"x": mu})

    locus = fl.root_locus(Falling(), "v", [0.5, 1.5, 2.5]).values[:, 0]
    assert locus.real == pytest.approx([0.2, -0.2, -0.05], rel=1e-13)  # minus half of slope and damping
    (change,) = fl.stability_changes(Falling(), "v", (0.1, 1.9))
    assert (change.kind, change.direction) == ("border", "regain")
    assert change.value == pytest.approx(1.0, abs=1e-12)


@fl.model
class Machine(fl.MechanicalModel):
    """A backlash, a saturated drive, drag and a soft floor."""

    d: float = 0.3
    e: float = 0.5
    coordinates = ("x", "y")
    states = ("i",)
    period = 3.0

    def mechanics(self, q, v, s):
        u = q.x - q.y
        gear = functions.piecewise(u, (-self.d, self.d), (u + self.d, 0, u - self.d))
        drive = functions.minimum(functions.maximum(2 * s.i, -self.e), self.e)
        drag = 0.1 * functions.absolute(v.x) * v.x
        floor = 0.2 * functions.maximum(0, q.y)
        return fl.Mechanics(
            v.x**2 / 2 + v.y**2,
            q.x**2 + q.y**2 / 2,
            loads={"x": drive - 5 * gear - drag, "y": 5 * gear - floor},
            rates={"i": q.y + functions.absolute(u) - 0.2 - s.i},
        )


def machine_rates(t, z):
    x, y, u, w, i = z
    gap = x - y
    gear = gap + 0.3 if gap < -0.3 else gap - 0.3 if gap > 0.3 else 0.0
    drive = min(max(2 * i, -0.5), 0.5)
    rates = -2 * x - 5 * gear + drive - 0.1 * abs(u) * u, (-y + 5 * gear - 0.2 * max(0.0, y)) / 2
    return [u, w, *rates, y + abs(gap) - 0.2 - i]


MACHINE_BORDERS = (
    lambda t, z: z[0] - z[1] + 0.3,
    lambda t, z: z[0] - z[1] - 0.3,
    lambda t, z: 2 * z[4] - 0.5,
    lambda t, z: 2 * z[4] + 0.5,
    lambda t, z: z[2],
    lambda t, z: z[1],
    lambda t, z: z[0] - z[1],
)


def in_pieces(rates, z, t_end, borders):
    """Final state and the times of borders, by DOP853 from border to border."""
    t, times = 0.0, []
    for border in borders:
        border.terminal = True
    while t < t_end:
        part = solve_ivp(rates, (t, t_end), z, method="DOP853", rtol=1e-12, atol=1e-14, events=borders)
        t, z = part.t[-1], part.y[:, -1]
        if part.status == 1:
            times.append(t)
            t, z = t + 1e-10, z + 1e-10 * np.array(rates(t, z))
    return z, np.array(times)


def test_many_borders_against_an_independent_integration():
    """96 modes, of which those are made that the run comes to; nested borders too."""
    start = [1.0, -0.2, 0.3, 0.0, 0.0]
    motion = run(Machine(), 6.0, start)
    state, times = in_pieces(machine_rates, start, 6.0, MACHINE_BORDERS)
    assert len(times) == len(motion.events) > 20
    assert motion.events.t == pytest.approx(times, abs=1e-8)  # of DOP853 by its dense output
    assert motion.final_state == pytest.approx(state, abs=1e-9)
    assert motion.automaton.on_demand
    assert len(motion.automaton.names) == 96 > len(motion.time_in_mode)


def test_a_run_with_modes_on_demand_is_saved_and_pickled(tmp_path):
    motion = run(Machine(), 2.0, [1.0, -0.2, 0.3, 0.0, 0.0])
    for other in (
        pickle.loads(pickle.dumps(motion)),
        fl.load(motion.save(tmp_path / "run"), model=Machine()),
    ):
        assert (other.final_state == motion.final_state).all()
        assert other.time_in_mode == motion.time_in_mode


SPEEDS = tuple(np.linspace(0.0, 3.0, 16).round(1).tolist())
MEASURED = tuple(0.3 + 0.5 * math.exp(-u / 0.3) + 0.01 * math.sin(40 * u) for u in SPEEDS)


@dataclass(frozen=True)
class Measured(fl.FrictionLaw):
    """A friction curve through measured points."""

    mu_s: float = fl.parameter(0.85, symbol=r"\mu_s", meaning="at rest", minimum=0.0, range=(0.0, 2.0))
    speeds: tuple = SPEEDS
    points: tuple = MEASURED

    def kinetic(self, normal_force, speed):
        return functions.interpolate(speed, self.speeds, self.points) * normal_force

    def static_limit(self, normal_force):
        return self.mu_s * normal_force


def test_a_measured_friction_curve_against_scipy():
    """16 pieces for each direction of slip; DOP853 goes from knot to knot of scipy's interpolator."""
    curve = PchipInterpolator(SPEEDS, MEASURED)
    model = fl.MassOnBelt(friction=Measured(), v=1.95, c=0.0)

    def rates(t, z):
        return [z[1], float(curve(1.95 - z[1])) - z[0]]

    knots = [lambda t, z, u=u: 1.95 - z[1] - u for u in SPEEDS]
    state, times = in_pieces(rates, [1.0, 0.0], 4.0, knots)
    motion = run(model, 4.0, [1.0, 0.0])
    assert len(motion.events) == len(times) > 8
    assert len(model.automaton().names) == 33
    assert motion.events.t == pytest.approx(times, abs=1e-8)  # of DOP853 by its dense output
    assert motion.final_state == pytest.approx(state, abs=1e-9)
    assert fl.equilibrium(model).q == pytest.approx([float(curve(1.95))], rel=1e-14)
    growth = -float(curve.derivative()(1.95)) / 2
    assert fl.eigenvalues(model).growth_rates == pytest.approx([growth, growth], rel=1e-12)
    fl.testing.check_law(Measured())


@fl.model
class Spring(fl.MechanicalModel):
    """A spring whose force goes through points that are parameters."""

    a: float = 0.5
    y1: float = 0.4
    y2: float = 1.5
    coordinates = ("x",)
    period = 5.0

    def mechanics(self, q, v):
        force = functions.interpolate(q.x, (0.0, self.a, 1.0, 2.0), (-0.5, self.y1, self.y2, 0.9))
        return fl.Mechanics(v.x**2 / 2, loads={"x": -force})


@pytest.mark.parametrize("changes", [{}, {"y1": 3.0, "y2": 1.0}, {"a": 0.01, "y1": 5.0}, {"y2": 0.4}])
def test_a_curve_through_points_that_are_parameters(changes):
    model = Spring(**changes)
    xs = (0.0, model.a, 1.0, 2.0)
    curve = PchipInterpolator(xs, (-0.5, model.y1, model.y2, 0.9))

    def rates(t, z):
        return [z[1], -float(curve(min(max(z[0], 0.0), 2.0)))]

    state, _ = in_pieces(rates, [1.9, 0.0], 2.0, [lambda t, z, x=x: z[0] - x for x in xs])
    assert run(model, 2.0, [1.9, 0.0]).final_state == pytest.approx(state, abs=1e-9)
    assert model.automaton().modes is Spring().automaton().modes  # values derive nothing


@pytest.mark.slow
def test_stick_slip_under_a_measured_curve():
    model = fl.MassOnBelt(friction=Measured(), v=0.55, c=0.02)
    settled = fl.steady_state(model, transient=50, window=30, progress=False)
    orbit = fl.periodic_orbit(model, settled)
    assert orbit.stable
    assert orbit.period == pytest.approx(settled.period, rel=1e-9)
    assert fl.verify(model, 10.0, x0=[0.0, 0.0], progress=False).ok


def test_a_law_without_contact_keeps_its_modes():
    """In separation nothing depends on the curve."""
    slider = fl.SliderOnRigidBelt(friction=Measured())
    names = slider.automaton().names
    assert "separation" in names
    assert "stick" in names
    assert "slip+ | 0.2 < " in ", ".join(names)


@pytest.mark.slow
def test_the_equilibrium_of_a_contact_in_pieces():
    """K q = f with the stiffness of the piece that the penetration is in."""

    @dataclass(frozen=True)
    class Layers(fl.ContactLaw):
        k2: float = 5e3
        hard: float = fl.parameter(
            5e4, unit="N/m", symbol="h", meaning="stiffness of the base", range=(1.0, 1e6)
        )
        depth: float = fl.parameter(0.005, unit="m", symbol="d", meaning="of the layer", range=(0.0, 0.1))

        def force(self, penetration):
            pressed = self.k2 * penetration
            return functions.piecewise(
                penetration, (self.depth,), (pressed, pressed + self.hard * (penetration - self.depth))
            )

    model = fl.SliderOnBelt(contact=Layers(), mu_k=1.0)
    point = fl.equilibrium(model)
    assert point.normal_force == pytest.approx(Layers().force(point.penetration), rel=1e-12)
    stiff = model.replace(contact=fl.LinearContact(k2=5.5e4))  # the same but for a preload of hard * depth
    assert point.penetration > 0.005
    assert fl.equilibrium(stiff).penetration < point.penetration
    motion = run(model, 0.5, "rest")
    assert motion.status.ok
    assert fl.energy_audit(motion, progress=False).error < 1e-13


@pytest.mark.parametrize(
    ("offset", "crossings"), [(-1e-9, 0), (0.0, None), (1e-9, 6)], ids=["below", "touches", "above"]
)
def test_grazing_a_border(offset, crossings):
    """x = a sin t with a just below, at and above the border."""
    model = one_mass(lambda x, v: -x + functions.maximum(0, x - 1))
    motion = run(model, 20.0, [0.0, 1.0 + offset])
    assert motion.status.ok
    assert motion.final_state == pytest.approx([math.sin(20.0), math.cos(20.0)], abs=1e-7)
    if crossings is not None:
        assert len(motion.events) == crossings


def test_a_start_on_a_border_goes_by_the_rate():
    pushed = one_mass(lambda x, v: 1 - 3 * functions.maximum(x, 0) + functions.minimum(x, 0))
    motion = run(pushed, 1.0, [0.0, 0.0])
    assert not len(motion.events)
    assert motion.final_state[0] == pytest.approx((1 - math.cos(math.sqrt(3.0))) / 3, rel=1e-13)


def test_a_force_that_jumps_at_a_place():
    """x'' = -sign(x) from x = a: a quarter of a period takes (2 a)^(1/2)."""
    motion = run(one_mass(lambda x, v: -functions.sign(x)), 10.0, [0.5, 0.0])
    assert motion.events.t == pytest.approx(1.0 + 2.0 * np.arange(5), abs=1e-13)


def test_a_force_that_jumps_against_a_velocity_is_said_to_need_a_contact():
    motion = run(one_mass(lambda x, v: -x - functions.sign(v) / 2), 10.0, [1.2, 0.0])
    assert motion.t[-1] == pytest.approx(math.pi, abs=1e-12)
    assert not motion.status.ok
    assert "needs a Friction contact" in str(motion.status)


def test_a_border_given_by_parameters_alone_is_no_event():
    @fl.model
    class Chosen(fl.MechanicalModel):
        k: float = 2.0
        coordinates = ("x",)
        period = 3.0

        def mechanics(self, q, v):
            return fl.Mechanics(
                v.x**2 / 2, loads={"x": functions.piecewise(self.k, (3.0,), (-q.x, -4 * q.x**3 - q.x))}
            )

    assert Chosen().automaton().names == ("only",)
    assert run(Chosen(), 1.0, [1.0, 0.0]).final_state[0] == pytest.approx(math.cos(1.0), rel=1e-13)
    assert run(Chosen(k=5.0), 1.0, [1.0, 0.0]).final_state[0] < 0.0


@fl.model
class Two(fl.MechanicalModel):
    """Two masses on a belt, with a backlash between them."""

    coordinates = ("x", "y")
    friction: fl.FrictionLaw = fl.Coulomb(mu_k=0.3, mu_s=0.5)
    period = 3.0

    def mechanics(self, q, v):
        u = q.x - q.y
        gear = functions.piecewise(u, (-0.1, 0.1), (u + 0.1, 0, u - 0.1))
        rubbing = (fl.Friction(0.5 - w, 1.0, self.friction) for w in (v.x, v.y))
        return fl.Mechanics(
            (v.x**2 + v.y**2) / 2, q.x**2 / 2, loads={"x": -gear, "y": gear}, contacts=tuple(rubbing)
        )


def test_several_contacts_have_modes_of_all_sides():
    motion = run(Two(), 10.0, [0.0, 0.3, 0.0, 0.0])
    assert motion.status.ok
    assert "slip+ | slip+ | x - y < -0.1" in motion.time_in_mode
    assert fl.energy_audit(motion, progress=False).error < 1e-13
    assert pickle.loads(pickle.dumps(motion)).time_in_mode == motion.time_in_mode


def test_borders_ascend_at_the_values_of_parameters():
    with pytest.raises(ValueError, match=r"x - y = -d, which is 0.1, before d, which is -0.1"):
        Machine(d=-0.1).automaton()
    with pytest.raises(ValueError, match="borders must ascend, got 0 after 1"):
        functions.piecewise(0.5, (1, 0), (1.0, 2.0, 3.0))
    assert run(Machine(d=0.0), 1.0, [1.0, -0.2, 0.3, 0.0, 0.0]).status.ok  # a backlash without play


def test_a_dynamic_law_with_its_absolute_value():
    """v_r = 0 is an event of the contact already: no other border is there."""

    @dataclass(frozen=True)
    class Bristles(fl.FrictionLaw):
        mu_k: float = 0.4
        sigma_0: float = 100.0
        states = ("z",)

        def force(self, normal_force, relative_velocity, z):
            return self.sigma_0 * z * normal_force

        def rates(self, normal_force, relative_velocity, z):
            decay = self.sigma_0 * functions.absolute(relative_velocity) / self.mu_k
            return {"z": relative_velocity - decay * z}

    model = fl.MassOnBelt(friction=Bristles(), c=0.1)
    assert model.automaton().names == ("slip+", "slip-")
    known = model.replace(friction=fl.Dahl(mu_k=0.4, sigma_0=100.0))
    assert run(model, 5.0, "rest").final_state == pytest.approx(
        run(known, 5.0, "rest").final_state, rel=1e-12
    )


def test_a_restitution_that_depends_on_the_speed():
    """A ball falls from h, at the speed u = (2 g h)^(1/2), and rises with e(u) u."""

    @dataclass(frozen=True)
    class Softening(fl.ImpactLaw):
        def impulse(self, material_rate, penetration_rate, compliance):
            e = functions.interpolate(penetration_rate, (0.0, 4.0, 8.0), (0.9, 0.5, 0.3), kind="linear")
            return (1 + e) * penetration_rate / compliance

    model = fl.BouncingBall(impact=Softening())
    motion = run(model, 1.0, "rest")
    first = motion.events[motion.events.guard == "impact"]
    before, after = first.before[0], first.state[0]
    u = abs(before[1])
    e = float(np.interp(u, [0.0, 4.0, 8.0], [0.9, 0.5, 0.3]))
    assert abs(after[1]) == pytest.approx(e * u, rel=1e-12)


def test_an_automaton_of_ones_own():
    x, v, k = sympy.symbols("x v k", real=True)
    swing = fl.HybridAutomaton(
        (x, v), (fl.Mode("on", (v, -k * functions.maximum(x, 0) - functions.minimum(x, 0))),), {k: 4.0}, 1
    )
    assert swing.names == ("on | x < 0", "on | x > 0")
    motion = fl.solve(swing, 10.0, x0=[1.0, 0.0], progress=False)
    assert motion.events.t[:2] == pytest.approx([math.pi / 4, math.pi * 5 / 4], abs=1e-14)
    assert fl.equilibria(swing)[0].state.tolist() == [0.0, 0.0]


def test_fl_testing_takes_them():
    fl.testing.check_model(Bilinear(c=0.1))


@pytest.mark.parametrize("method", ["RK4", "DOP853"])
def test_other_methods_find_the_borders(method):
    chosen = fl.RK4(step=1e-3) if method == "RK4" else method
    motion = fl.simulate(Bilinear(), 3.0, x0=[1.0, 0.0], method=chosen, progress=False)
    assert motion.events.t == pytest.approx([math.pi / 4], abs=1e-6)


@fl.model
class BeltToAndFro(fl.MechanicalModel):
    """A mass on a belt whose speed changes its sign with the phase."""

    friction: fl.FrictionLaw = fl.Coulomb(mu_k=0.3, mu_s=0.5)
    coordinates = ("x",)

    def mechanics(self, q, v):
        speed = functions.piecewise(q.phase, (math.pi,), (0.5, -0.5))
        rubbing = fl.Friction(speed - v.x, 1.0, self.friction)
        return fl.Mechanics(v.x**2 / 2, q.x**2 / 2, contacts=(rubbing,), frequency=1.0)


def test_steps_of_the_paper_go_on_where_a_border_reverses_a_belt():
    """The side that is left counted as one to enter, for its guard is zero: events without end."""
    runs = [
        fl.simulate(BeltToAndFro(), 7.0, method=method, progress=False)
        for method in ("taylor", fl.RK4(step=1e-2, max_events=100))
    ]
    assert runs[1].events.target.tolist() == runs[0].events.target.tolist()
    assert runs[1].final_state == pytest.approx(runs[0].final_state, abs=1e-7)


@pytest.mark.parametrize(
    ("force", "name"),
    [
        (lambda x: abs(x), "absolute"),
        (lambda x: sympy.Max(x, 0), "maximum"),
        (lambda x: sympy.sign(x), "sign"),
        (lambda x: sympy.Piecewise((x, x > 0), (0, True)), "piecewise"),
    ],
)
def test_what_has_no_borders_is_refused_by_name(force, name):
    with pytest.raises(ValueError, match=f"fl.functions.{name}"):
        run(one_mass(lambda x, v: -force(x)), 1.0, [1.0, 0.0])


def test_the_equations_are_printed_as_cases():
    text = Bilinear().equations("only")._repr_latex_()
    assert r"\begin{cases}" in text
    x = sympy.Symbol("x", real=True)
    assert sympy.latex(functions.absolute(x)) == r"\left|{x}\right|"
    assert str(functions.minimum(x, 1)) == "Min(1, x)"


def test_a_side_has_the_equations_of_all_sides():
    model = Bilinear()
    assert str(model.equations("x < d")) == str(model.equations("only"))


X = sympy.Symbol("X")


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: functions.piecewise(0.3, (float("nan"),), (1, 2)), "borders must be numbers .* got nan"),
        (
            lambda: functions.piecewise((X, X < 0), (2 * X, True), (X, X > 3), (0, True)),
            r"x must be what the borders are of, got a pair .* write Piecewise.* as piecewise\(x, ",
        ),
        (lambda: functions.piecewise(X, (X < 0,), (X, 2 * X)), "borders must be .* got the condition X < 0"),
        (lambda: functions.absolute("x"), "x must hold numbers, got 'x'"),
        (lambda: functions.sign([None]), "x must hold numbers"),
        (lambda: fl.table(0.3, {}), "values must be given at two times at least, got {}"),
        (lambda: fl.table(0.3, np.array([1.0, 0.2])), r"a value for each time, .* list\(zip\(times, values"),
        (lambda: fl.table(0.3, {0: 1, 2: 1, 1: 0}), "the times of values must ascend, got .* sort"),
        (
            lambda: fl.table(0.3, {0: 1, 2: float("nan")}),
            "ys must be finite numbers, got .* leave out points",
        ),
        *(
            (lambda y=y: functions.interpolate(1.5, (0, 1, 2), (1, y, 2)), "ys must be finite numbers")
            for y in (sympy.nan, sympy.oo)
        ),
        (lambda: functions.interpolate(1.5, (0, sympy.Rational(1, 2), 0.25), (1, 2, 3)), "xs must ascend"),
    ],
)
def test_bad_arguments_of_functions_get_one_error(make, message):
    with pytest.raises(ValueError, match=message):
        make()


def test_a_missing_number_has_no_side():
    x = np.array([np.nan, -1.0, 0.5])
    assert np.isnan(functions.piecewise(float("nan"), (0.0,), (1, 2)))
    np.testing.assert_array_equal(functions.interpolate(x, (0, 1), (0, 2)), [np.nan, 0.0, 1.0])
    assert isinstance(functions.piecewise(1, (1,), (1, 2)), int)  # where none is missing


def in_potential(energy, *coordinates):
    """A mass of 1 kg in a potential energy(parameters, q)."""

    class InPotential(fl.MechanicalModel):
        k: float = 3.0
        d: float = 0.1
        lift: float = 0.0

        def mechanics(self, q, v):
            kinetic = sum(rate**2 for rate in v) / 2
            return fl.Mechanics(kinetic, energy(self, q))

    InPotential.coordinates = coordinates
    return fl.model(InPotential)


def radius(q):
    return functions.sqrt(q.x**2 + q.y**2)


@pytest.mark.parametrize(
    ("energy", "coordinates", "border"),
    [
        (lambda p, q: functions.piecewise(q.x, (p.d,), (0.0, p.k * q.x**2)), "x", "x = d"),
        (lambda p, q: p.k * functions.sign(q.x - q.y), "xy", "x - y = 0"),
        (
            lambda p, q: functions.piecewise(radius(q), (p.d,), (0.0, p.k * radius(q))),
            "xy",
            r"sqrt\(x\*\*2 \+ y\*\*2\) = d",
        ),
    ],
)
def test_an_energy_that_jumps_is_refused(energy, coordinates, border):
    model = in_potential(energy, *coordinates)()
    with pytest.raises(ValueError, match=f"potential energy of InPotential .* above the border {border}: an"):
        model.automaton()


@pytest.mark.parametrize(
    ("energy", "coordinates"),
    [
        (lambda p, q: p.k * functions.absolute(q.x), "x"),
        (lambda p, q: p.k * functions.absolute(q.x) * functions.sign(q.x), "x"),
        (lambda p, q: functions.interpolate(q.x, [-1.0, 0.0, 0.2, 3.0], [2.0, 0.0, 0.1, 9.0]), "x"),
        (lambda p, q: functions.piecewise(radius(q), (p.d,), (p.k * p.d, p.k * radius(q))), "xy"),
        (lambda p, q: functions.piecewise(q.t, (1.0,), (p.k, 2 * p.k)) * q.x**2, "x"),
    ],
)
def test_an_energy_with_a_kink_or_a_step_in_time_is_taken(energy, coordinates):
    in_potential(energy, *coordinates)().automaton()


def test_parameters_decide_whether_an_energy_jumps():
    model = in_potential(
        lambda p, q: functions.piecewise(q.x, (p.d,), (0.0, p.k * (q.x - p.d) ** 2 + p.lift)), "x"
    )
    model(d=-2e3).automaton()
    with pytest.raises(ValueError, match=r"got 0 J below and 0\.5 J above the border x = d"):
        fl.simulate(model(lift=0.5), 1.0)


def test_a_mass_that_jumps_is_refused():
    class Heavier(fl.MechanicalModel):
        coordinates = ("x",)

        def mechanics(self, q, v):
            return fl.Mechanics(functions.piecewise(q.x, (0.0,), (1.0, 2.0)) * v.x**2)

    with pytest.raises(ValueError, match="the kinetic energy of Heavier must be continuous"):
        fl.model(Heavier)().automaton()


def test_the_friction_curve_is_that_of_scipy_and_its_speeds_ascend():
    law = fl.FrictionCurve(mu_2=0.5)
    points = [getattr(law, f"mu_{i}") for i in range(5)]
    curve = PchipInterpolator([0.0, law.v_1, law.v_2, law.v_3, law.v_4], points)
    speeds = np.linspace(0.0, law.v_4, 101)
    np.testing.assert_allclose(law.kinetic(200.0, speeds), 200.0 * curve(speeds), rtol=1e-14)
    assert law.kinetic(1.0, 9.0) == law.mu_4
    assert law.static_limit(2.0) == 2 * law.mu_0
    with pytest.raises(ValueError, match=r"^v_2 must be above v_1 \(0.4\), got 0.3: raise v_2 or lower v_1$"):
        fl.FrictionCurve(v_1=0.4)


@fl.model
class SquareWave(fl.MechanicalModel):
    """A force of 1 N in the first half of a period and -1 N in the second."""

    Omega: float = 3.0
    coordinates = ("x",)

    def mechanics(self, q, v):
        force = fl.functions.piecewise(q.phase, (math.pi,), (1.0, -1.0))
        return fl.Mechanics(v.x**2 / 2, q.x**2 / 2, loads={"x": force}, frequency=self.Omega)


@fl.model
class Backwards(SquareWave):
    """Its frequency is a number."""

    def mechanics(self, q, v):
        return replace(super().mechanics(q, v), frequency=-3.0)


def test_a_law_in_pieces_of_the_phase_repeats_from_any_phase():
    starts = {"phase": -1.0}, {"phase": 2 * math.pi - 1.0}
    below, within = (fl.simulate(SquareWave(), 20.0, x0=x0, progress=False) for x0 in starts)
    assert len(below.events) == len(within.events) == 19
    assert below.final_state == pytest.approx(within.final_state, abs=1e-13)
    automaton = SquareWave().automaton().replace(Omega=-3.0)
    for model in (SquareWave(Omega=-3.0), Backwards(), automaton):
        with pytest.raises(ValueError, match=r"^frequency, .*, must be at least 0, got -3( at O.*)?: give"):
            fl.simulate(model, 20.0)
    with pytest.raises(ValueError, match=r"^frequency, .*, must be at least 0, got -3 at Omega = -3: give"):
        fl.solve(automaton, 20.0, x0=[0.0, 0.0, 0.0])
