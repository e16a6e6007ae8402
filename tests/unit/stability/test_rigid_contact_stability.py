"""Equilibria in closed rigid contacts, against minimal coordinates, index-1 pencils and stiff layers."""

import math

import numpy as np
import pytest
import scipy.linalg
import scipy.optimize
import sympy as sp

import frictionlab as fl
from frictionlab.stability.equilibrium_points.equilibria import equilibrium_problem

sin, cos = fl.functions.sin, fl.functions.cos


@fl.model
class OnTheBelt(fl.MechanicalModel):
    """A mass on a belt under its weight, held above by a rigid contact: `MassOnBelt` with N = m g."""

    m: float = 1.0
    k: float = 20.0
    c: float = 0.1
    g: float = 10.0
    v: float = 0.5
    lift: float = 0.0
    friction: fl.FrictionLaw = fl.Stribeck(mu_k=0.2, mu_s=0.4, v_s=0.3)
    coordinates = ("x", "y")

    def mechanics(self, q, v):
        ground = fl.Stop(q.y, fl.PlasticImpact(), friction=self.friction, relative_velocity=self.v - v.x)
        return fl.Mechanics(
            kinetic=self.m * (v.x**2 + v.y**2) / 2,
            potential=self.k * q.x**2 / 2 + (self.m * self.g - self.lift) * q.y,
            dissipation=self.c * v.x**2 / 2,
            contacts=(ground,),
        )


@fl.model
class InOneCoordinate(fl.MechanicalModel):
    """The same without the coordinate that the contact holds."""

    m: float = 1.0
    k: float = 20.0
    c: float = 0.1
    g: float = 10.0
    v: float = 0.5
    friction: fl.FrictionLaw = fl.Stribeck(mu_k=0.2, mu_s=0.4, v_s=0.3)
    coordinates = ("x",)

    def mechanics(self, q, v):
        return fl.Mechanics(
            kinetic=self.m * v.x**2 / 2,
            potential=self.k * q.x**2 / 2,
            dissipation=self.c * v.x**2 / 2,
            contacts=(fl.Friction(self.v - v.x, self.m * self.g, self.friction),),
        )


def test_a_mass_that_a_rigid_contact_holds_is_the_mass_on_a_belt():
    held, flat = OnTheBelt(), InOneCoordinate()
    known = fl.equilibria(held)
    assert known.complete
    assert len(known) == 1
    assert known[0].normal_force == pytest.approx(10.0, rel=1e-15)
    assert known[0].q == pytest.approx([fl.equilibrium(flat).q[0], 0.0], rel=1e-14)
    one, other = fl.eigenvalues(held), fl.eigenvalues(flat)
    assert one.values == pytest.approx(other.values, rel=1e-12)
    assert one.vectors.shape == (4, 2)
    assert not one.vectors[1::2].any()
    for quantity in (fl.GrowthRate(), fl.CriticalValue("mu_s", (0.25, 9.0))):
        mine, theirs = (fl.sensitivity(model.replace(v=0.9), quantity) for model in (held, flat))
        slopes = dict(zip(mine.parameters, mine.derivatives, strict=True))
        for name, slope in zip(theirs.parameters, theirs.derivatives, strict=True):
            assert slopes[name] == pytest.approx(slope, rel=1e-10, abs=1e-12)


def test_a_rigid_contact_changes_and_regains_stability_with_its_hopf_point():
    held, flat = OnTheBelt(), InOneCoordinate()
    (change,), (known,) = (fl.stability_changes(model, "v", (0.01, 3.0)) for model in (held, flat))
    assert (change.kind, change.direction) == ("flutter", "regain")
    assert change.value == pytest.approx(known.value, rel=1e-12)
    one, other = (fl.hopf(model, "v", (0.01, 3.0)) for model in (held, flat))
    assert one.first_lyapunov == pytest.approx(other.first_lyapunov, rel=1e-10)
    at = change.value * np.array([1.01, 1.02])
    assert one.amplitude(at)[:, 0] == pytest.approx(other.amplitude(at)[:, 0], rel=1e-9)
    assert one.valid_until == pytest.approx(other.valid_until, rel=1e-9)
    values = [0.2, 0.5, 1.0]
    loci = [fl.root_locus(model, "v", values).values for model in (held, flat)]
    assert loci[0] == pytest.approx(loci[1], rel=1e-12)
    grid = [("v", values), ("k", [10.0, 30.0])]
    maps = [fl.stability_map(model, *grid, progress=False).unstable.tolist() for model in (held, flat)]
    assert maps[0] == maps[1]


def test_what_a_contact_holds_has_no_lyapunov_exponent():
    """Neighbours in flight are none of a motion in contact: it has the exponents of the free coordinate."""
    held, flat = (
        fl.lyapunov(model, transient=20.0, t_end=40.0, progress=False)
        for model in (OnTheBelt(v=3.0), InOneCoordinate(v=3.0))
    )
    assert held.exponents[:2] == pytest.approx(flat.exponents, rel=1e-2)
    decay = fl.eigenvalues(OnTheBelt(v=3.0)).growth_rates
    assert held.exponents[:2].sum() == pytest.approx(decay.sum(), rel=1e-6)
    assert (held.exponents[2:] == -np.inf).all()


def test_a_contact_that_would_pull_has_no_equilibrium():
    assert len(fl.equilibria(OnTheBelt(lift=9.9))) == 1
    assert not fl.equilibria(OnTheBelt(lift=10.1))
    with pytest.raises(ValueError, match=r"inside its guards, got none in flight \(stick, slip\+, slip-"):
        fl.eigenvalues(OnTheBelt(lift=10.1))


def test_forces_act_through_the_reaction_and_its_friction():
    held, flat = fl.linearize(OnTheBelt(), outputs=["x", "reaction"]), fl.linearize(InOneCoordinate())
    assert held.states == ("x", "x'")
    np.testing.assert_allclose(held.A, flat.A, rtol=1e-13)
    mu = 0.2 + 0.2 * math.exp(-((0.5 / 0.3) ** 2))
    np.testing.assert_allclose(held.B, [[0.0, 0.0], [1.0, -mu]], rtol=1e-13)
    np.testing.assert_allclose(held.D, [[0.0, 0.0], [0.0, -1.0]], atol=1e-15)


@fl.model
class RodOnBelt(fl.MechanicalModel):
    """A rod on springs, its lower end on a belt: sprung at its centre, where its weight and a load act."""

    m: float = 1.0
    l: float = 0.5
    k: float = 300.0
    turning: float = 40.0
    at: float = 0.9
    P: float = 40.0
    v: float = 1.0
    c: float = 0.05
    stiffness: float = 0.0
    friction: fl.FrictionLaw = fl.Coulomb(mu_k=0.3, mu_s=0.4)
    coordinates = ("x", "y", "theta")

    def end(self, q, v):
        return q.y - self.l * sin(q.theta), self.v - v.x - self.l * sin(q.theta) * v.theta

    def mechanics(self, q, v):
        distance, speed = self.end(q, v)
        return fl.Mechanics(
            kinetic=self.m * (v.x**2 + v.y**2) / 2 + self.m * self.l**2 * v.theta**2 / 6,
            potential=self.k * q.x**2 / 2 + self.turning * (q.theta - self.at) ** 2 / 2 + self.P * q.y,
            dissipation=self.c * (v.x**2 + v.y**2 + v.theta**2) / 2,
            contacts=self.contacts(distance, speed),
        )

    def contacts(self, distance, speed):
        return (fl.Stop(distance, fl.PlasticImpact(), friction=self.friction, relative_velocity=speed),)


@fl.model
class RodOnLayer(RodOnBelt):
    """The same rod on a layer that is stiff instead of rigid."""

    stiffness: float = 1e9

    def contacts(self, distance, speed):
        return (fl.Friction(speed, lambda depth: self.stiffness * depth, self.friction, -distance),)


def rod_pencil(rod, state, reaction):
    """The rod's equations as an index-1 pencil, with the reaction as an unknown, by sympy."""
    x, y, theta, vx, vy, w, push = unknowns = sp.symbols("x y theta vx vy w push")
    p = rod.parameters
    m, l, rub = p["m"], p["l"], p["mu_k"] * push
    ax = (-p["k"] * x - p["c"] * vx + rub) / m
    ay = (-p["P"] - p["c"] * vy + push) / m
    moment = -p["turning"] * (theta - p["at"]) - p["c"] * w + l * (rub * sp.sin(theta) - push * sp.cos(theta))
    aw = moment / (m * l**2 / 3)
    gap = y - l * sp.sin(theta)
    rate = vy - l * sp.cos(theta) * w
    closing = ay - l * sp.cos(theta) * aw + l * sp.sin(theta) * w**2
    rows = sp.Matrix([vx, gap, w, ax, rate, aw, closing])
    at = dict(zip(unknowns, [*state, reaction], strict=True))
    assert max(abs(float(row)) for row in rows.subs(at)) < 1e-11
    matrix = np.array(rows.jacobian(unknowns).subs(at), dtype=float)
    values = np.asarray(scipy.linalg.eigvals(matrix, np.diag([1.0, 0.0, 1.0, 1.0, 0.0, 1.0, 0.0])))
    return np.sort_complex(values[np.isfinite(values) & (np.abs(values) < 1e6)])


@pytest.mark.slow
def test_a_rod_that_slides_on_its_end_has_the_eigenvalues_of_its_pencil():
    rod = RodOnBelt()
    point, modes = fl.equilibrium(rod), fl.eigenvalues(rod)
    assert point.friction_force == pytest.approx(0.3 * point.normal_force, rel=1e-14)
    assert np.sort_complex(modes.values) == pytest.approx(
        rod_pencil(rod, point.state, point.normal_force), rel=1e-11
    )
    assert modes.vectors[1] == pytest.approx(0.5 * math.cos(point.q[2]) * modes.vectors[2], rel=1e-14)
    shapes = fl.root_locus(rod, "P", [30.0, 40.0]).shapes[-1]
    assert shapes[1] == pytest.approx(0.5 * math.cos(point.q[2]) * shapes[2], rel=1e-13)
    load = fl.linearize(rod, inputs=["y", "P"], outputs=["y", "reaction"])
    assert load.B[:, 0] == pytest.approx(-load.B[:, 1], rel=1e-12)
    assert load.D[:, 0] == pytest.approx(-load.D[:, 1], rel=1e-12)
    run = fl.simulate(rod, 0.5, x0="near", progress=False)
    assert set(run.mode) == {"slip+"}
    assert np.abs(run["distance"]).max() < 1e-14


@pytest.mark.slow  # its modes are derived
def test_a_rod_without_its_spring_has_all_its_equilibria_within_one_turn():
    """Where the contact's force passes through its centre, tan(theta) = 1/mu, above the belt and below it."""
    assert fl.equilibria(RodOnBelt()).complete  # with its spring it has one, of all angles
    known = fl.equilibria(RodOnBelt(turning=0.0))
    assert known.complete
    upright = math.atan(1 / 0.3)
    assert [point.q[2] for point in known] == pytest.approx([upright, upright - math.pi], rel=1e-14)
    assert [point.normal_force for point in known] == pytest.approx([40.0, 40.0], rel=1e-13)


@fl.model
class TwoArms(fl.MechanicalModel):
    """Two arms of length 1, with masses of 1 kg at knee and tip; that slides on a belt 0.3 m below."""

    pull: float = 0.0
    friction: fl.FrictionLaw = fl.Coulomb(mu_k=0.3, mu_s=0.3)
    coordinates = ("alpha", "beta")

    def mechanics(self, q, v):
        speed = -sin(q.alpha) * v.alpha - sin(q.beta) * v.beta
        rise = cos(q.alpha) * v.alpha + cos(q.beta) * v.beta
        weights = 10.0 * (2 * sin(q.alpha) + sin(q.beta))
        gap = sin(q.alpha) + sin(q.beta) + 0.3
        return fl.Mechanics(
            kinetic=(v.alpha**2 + speed**2 + rise**2) / 2,
            potential=weights - self.pull * (cos(q.alpha) + cos(q.beta)),
            contacts=(
                fl.Stop(gap, fl.PlasticImpact(), friction=self.friction, relative_velocity=1.0 - speed),
            ),
        )


def sliding_arms(pull, mu=0.3):
    """Angles and reaction where moments of loads and of the tip's force balance, along the contact."""

    def moments(a, b):
        loads = [20 * math.cos(a) + pull * math.sin(a), 10 * math.cos(b) + pull * math.sin(b)]
        return loads, [math.cos(x) - mu * math.sin(x) for x in (a, b)]

    def excess(a, elbow):
        (load, other), (arm, lever) = moments(a, below(a, elbow))
        return load * lever - other * arm

    def below(a, elbow):
        b = math.asin(-0.3 - math.sin(a))
        return b if elbow else -math.pi - b

    ends = math.asin(0.7)
    for elbow in (True, False):
        at = np.linspace(-math.pi - ends, ends, 2000)[1:-1]
        values = [excess(a, elbow) for a in at]
        for i in np.flatnonzero(np.diff(np.sign(values))):
            a = scipy.optimize.brentq(excess, at[i], at[i + 1], args=(elbow,), xtol=1e-15)
            loads, levers = moments(a, below(a, elbow))
            side = int(np.abs(levers).argmax())
            yield a, below(a, elbow), loads[side] / levers[side]


@pytest.mark.slow  # sympy takes 3 s to derive its modes
def test_arms_on_a_belt_have_all_equilibria_also_where_the_distance_does_not_change_with_an_arm():
    def sorted_by_turns(rows):
        return sorted([math.cos(a), math.sin(a), math.cos(b), math.sin(b), push] for a, b, push in rows)

    for pull in (0.0, -5.0, -12.0):
        known = fl.equilibria(TwoArms(pull=pull))
        assert known.complete
        points = [(*one.q, one.normal_force) for one in known if one.normal_force > 0]
        expected = [row for row in sliding_arms(pull) if row[2] > 0]
        np.testing.assert_allclose(sorted_by_turns(points), sorted_by_turns(expected), atol=1e-10)
    # At this pull an arm hangs straight down: its slope of the distance is zero.
    known = fl.equilibria(TwoArms(pull=-6.0))
    assert known.complete

    def chosen(one):
        return abs(math.cos(one.q[1])) < 1e-3

    hanging = [one for one in known if chosen(one)]
    assert sorted(one.q[0] for one in hanging) == pytest.approx([math.asin(0.7), math.pi - math.asin(0.7)])
    assert [one.normal_force for one in hanging] == pytest.approx([20.0, 20.0], rel=1e-12)
    # Beside it the distance gives that arm's angle, there the other's.
    rates = []
    for model in (TwoArms(pull=pull) for pull in (-6.001, -6.0, -5.999)):
        problems = (equilibrium_problem(model, one) for one in fl.equilibria(model) if chosen(one))
        rates.append([np.sort(problem.spectra({}).real) for problem in problems])
    assert rates[1] == pytest.approx(np.mean([rates[0], rates[2]], axis=0), rel=1e-5)


@pytest.mark.slow
def test_a_rigid_contact_is_the_limit_of_a_stiff_one():
    rigid = fl.eigenvalues(RodOnBelt()).values
    stiff = (fl.eigenvalues(RodOnLayer(stiffness=k)).values[:4] for k in (1e6, 1e8))
    first, second = (np.abs(values - rigid).max() for values in stiff)
    assert second < 1e-5
    assert second == pytest.approx(first / 100, rel=0.01)


@fl.model
class Bead(fl.MechanicalModel):
    """A bead in a round bowl, whose distance is linear in no coordinate; a load feeds energy in."""

    R: float = 0.5
    feed: float = 0.0
    coordinates = ("x", "y")

    def mechanics(self, q, v):
        return fl.Mechanics(
            kinetic=(v.x**2 + v.y**2) / 2,
            potential=9.81 * q.y,
            contacts=(fl.Stop(self.R**2 - q.x**2 - q.y**2, fl.PlasticImpact()),),
            loads={"x": self.feed * v.x - v.x**3 - q.x * v.x},
        )

    def release(self):
        return {"y": -self.R}


@fl.model
class BeadByAngle(fl.MechanicalModel):
    R: float = 0.5
    feed: float = 0.0
    coordinates = ("phi",)

    def mechanics(self, q, v):
        x, across = self.R * sin(q.phi), self.R * cos(q.phi)
        load = self.feed * across * v.phi - (across * v.phi) ** 3 - x * across * v.phi
        return fl.Mechanics(
            kinetic=self.R**2 * v.phi**2 / 2, potential=-9.81 * across, loads={"phi": load * across}
        )


@pytest.mark.slow
def test_a_distance_that_is_linear_in_no_coordinate_gives_the_same_cycle():
    at_rest = ((model, fl.equilibrium(model)) for model in (Bead(), BeadByAngle()))
    bowl, angle = (fl.hopf(model, "feed", (-1.0, 1.0), equilibrium=rest) for model, rest in at_rest)
    assert bowl.state == pytest.approx([0.0, -0.5, 0.0, 0.0], abs=1e-15)
    assert bowl.frequency == pytest.approx(math.sqrt(9.81 / 0.5) / (2 * math.pi), rel=1e-12)
    assert bowl.crossing_speed == pytest.approx(angle.crossing_speed, rel=1e-12)
    assert bowl.amplitude(0.01)[0] == pytest.approx(0.5 * angle.amplitude(0.01)[0], rel=1e-10)
    assert bowl.cycle_frequency(0.01) == pytest.approx(angle.cycle_frequency(0.01), rel=1e-12)


@fl.model
class TwoBlocksInARow(fl.MechanicalModel):
    """Two blocks on springs, pressed together: one coordinate holds the other."""

    push: float = 3.0
    c: float = 0.3
    coordinates = ("x1", "x2")

    def mechanics(self, q, v):
        return fl.Mechanics(
            kinetic=v.x1**2 + v.x2**2 / 2,
            potential=4.0 * q.x1**2 + 3.0 * q.x2**2,
            dissipation=self.c * v.x1**2 / 2,
            contacts=(fl.Stop(q.x2 - q.x1, fl.PlasticImpact()), fl.Stop(q.x1 + 5.0, fl.PlasticImpact())),
            loads={"x1": self.push},
        )


def test_several_stops_are_searched_in_all_modes():
    known = fl.equilibria(TwoBlocksInARow())
    assert known.complete
    (point,) = known
    assert point.q == pytest.approx([3.0 / 14.0] * 2, rel=1e-14)
    expected = np.roots([3.0, 0.3, 14.0])
    assert np.sort_complex(fl.eigenvalues(TwoBlocksInARow()).values) == pytest.approx(
        np.sort_complex(expected), rel=1e-12
    )
    assert fl.equilibrium(TwoBlocksInARow(push=-3.0)).q == pytest.approx([-3.0 / 8.0, 0.0], rel=1e-14)


def test_what_contacts_hold_altogether_has_no_eigenvalues():
    ball = fl.BouncingBall()
    assert fl.equilibrium(ball).q == pytest.approx([0.0], abs=0.0)
    for ask in (fl.eigenvalues, lambda model: fl.stability_changes(model, "g", (1.0, 9.0))):
        with pytest.raises(ValueError, match="must leave a coordinate free to have eigenvalues"):
            ask(ball)


def test_an_orbit_that_never_leaves_its_contact_is_that_of_minimal_coordinates():
    orbits = []
    for model in (OnTheBelt(v=0.75), InOneCoordinate(v=0.75)):
        guess = {"x": fl.equilibrium(model).q[0] + 0.03}
        orbits.append(fl.periodic_orbit(model, guess, period=1.405))
    held, flat = orbits
    assert held.modes[0][0] == "slip+"
    assert held.period == pytest.approx(flat.period, rel=1e-12)
    assert held.stability == flat.stability == "unstable"
    assert np.abs(held.multipliers)[:2] == pytest.approx(np.abs(flat.multipliers), rel=1e-9)
    assert not held.multipliers[2:].any()
    assert not held.trajectory["y"].any()


@pytest.mark.slow
def test_stick_and_slip_in_a_rigid_contact_is_followed_along_a_parameter():
    branches = []
    for model in (OnTheBelt(v=0.3), InOneCoordinate(v=0.3)):
        orbit = fl.periodic_orbit(model, fl.simulate(model, 60.0, progress=False))
        branches.append(fl.continue_orbit(orbit, "v", (0.2, 0.6), progress=False))
    held, flat = branches
    assert held.ends == flat.ends == ("bound", "bound")
    assert held.values == pytest.approx(flat.values, rel=1e-9)
    assert [one.period for one in held.orbits] == pytest.approx([one.period for one in flat.orbits], rel=1e-9)


@pytest.mark.slow
def test_an_orbit_on_a_curved_contact_is_followed_where_its_curve_is_the_parameter():
    branches = []
    for model, guess in ((Bead(feed=0.3), {"x": 0.3, "y": -0.4}), (BeadByAngle(feed=0.3), {"phi": 0.6435})):
        run = fl.simulate(model, 60.0, x0=guess, progress=False)
        branches.append(fl.continue_orbit(fl.periodic_orbit(model, run), "R", (0.4, 0.6), progress=False))
    bowl, angle = branches
    assert bowl.ends == angle.ends == ("bound", "bound")
    for end in (0, -1):
        one, other = bowl.orbits[end], angle.orbits[end]
        assert one.period == pytest.approx(other.period, rel=1e-9)
        assert np.abs(one.multipliers)[:2] == pytest.approx(np.abs(other.multipliers), rel=1e-6)
        place = one.trajectory["x"] ** 2 + one.trajectory["y"] ** 2
        assert place == pytest.approx(bowl.values[end] ** 2, rel=1e-12)
