"""Jenkins' element: a spring in series with a slider, whose stick is elastic; and Iwan's, of several."""

import math

import numpy as np
import pytest

import frictionlab as fl

MU, K_T, N = 0.4, 30.0, 2.0
ELEMENT = fl.Jenkins(mu_k=MU, k_t=K_T)
STRENGTHS, STIFFNESSES = (0.3, 0.1, 0.6), (1, 2, 1)  # the second element slips first
IWAN = fl.Iwan(mu_k=MU, k_t=K_T, strengths=STRENGTHS, stiffnesses=STIFFNESSES)
LIMITS = MU * N * np.array(STRENGTHS)  # N
SPRINGS = K_T * np.array(STIFFNESSES) / 4


@fl.model
class Driven(fl.MechanicalModel):
    """A mass on a spring, held by the element and driven."""

    F: float = 2.0
    k: float = 4.0
    a: float = 0.0
    friction: fl.FrictionLaw = ELEMENT
    coordinates = ("x",)
    period = 2.0 * math.pi / 3.0

    def mechanics(self, q, v):
        loads = {"x": self.F * fl.functions.cos(q.phase)}
        rubbing = fl.Friction(-v.x, N * (1.0 + self.a * fl.functions.cos(2 * q.phase)), self.friction)
        return fl.Mechanics(
            v.x**2 / 2, self.k * q.x**2 / 2, 0.1 * v.x**2, loads=loads, frequency=3.0, contacts=(rubbing,)
        )


def test_within_its_limit_it_is_a_spring():
    """x = a cos(w t) with w^2 = k + k_t, without a drive and a damper."""
    model = fl.MassOnBelt(friction=ELEMENT, v=0.0, N=N, k=4.0)
    run = fl.simulate(model, 5.0, x0={"x": 0.01}, progress=False)
    assert {*run.mode} == {"stick"}
    # it begins with z = 0 at x = 0.01
    mean, w = 0.01 * K_T / (4.0 + K_T), math.sqrt(4.0 + K_T)
    expected = mean + (0.01 - mean) * math.cos(w * 5.0)
    assert run["x"][-1] == pytest.approx(expected, rel=1e-12)
    # at rest it may have any deflection, so that k x = k_t z is a line of equilibria
    found = fl.equilibria(model)
    assert (len(found), found.complete) == (1, False)
    assert "in stick one is of a line of equilibria" in repr(found)
    audit = fl.energy_audit(run, progress=False)
    assert np.array_equal(audit.energies["bristles"], K_T * run["z"] ** 2 / 2)
    assert not audit.works["friction"].any()
    assert audit.error < 1e-14


@fl.model
class Joint(fl.MechanicalModel):
    """Masses on cubic springs, of which the element holds one with little force."""

    friction: fl.FrictionLaw = ELEMENT
    coordinates = ("x", "y")

    def mechanics(self, q, v):
        rubbing = fl.Friction(-v.y, 0.02, self.friction)
        springs = q.x**2 / 2 + q.x**4 / 4 + q.y**4 / 4 + (q.x - q.y) ** 2 - q.x
        return fl.Mechanics((v.x**2 + v.y**2) / 2, springs, contacts=(rubbing,))


def test_where_a_joint_sticks_its_spring_may_rest_anywhere():
    with pytest.raises(
        ValueError, match="may rest at any deflection: write it into the potential for its eig"
    ):
        fl.eigenvalues(Joint())


def test_its_state_is_that_of_the_stop_operator():
    """z = min(max(z + dv_r, -mu N/k), mu N/k) from one turning point of the motion to the next."""
    run = fl.simulate(Driven(), 8.0, sections={"turn": "x'"}, progress=False)
    t = np.unique(np.concatenate([[0.0], run.events.t, run.sections["turn"].t, np.linspace(0.0, 8.0, 300)]))
    x, expected, limit = run(t)[:, 0], [0.0], MU * N / K_T
    for moved in -np.diff(x):
        expected.append(min(max(expected[-1] + moved, -limit), limit))
    assert np.allclose(run(t)[:, 3], expected, atol=1e-13)
    assert {"stick", "slip+", "slip-"} == {*run.mode}
    assert np.allclose(run.output("friction_force", t), K_T * run(t)[:, 3], atol=1e-12)
    audit = fl.energy_audit(run, progress=False)
    assert audit.error < 1e-13
    slid = np.abs(np.diff(-x) - np.diff(expected)).sum()  # where the slider slips
    assert -audit.works["friction"][-1] == pytest.approx(MU * N * slid, rel=1e-12)


@pytest.mark.parametrize(("law", "F", "k"), [(ELEMENT, MU * N, K_T), (IWAN, LIMITS, SPRINGS)], ids=str)
def test_a_cycle_takes_the_energy_of_its_loop(law, F, k):
    """4 F (X - F/k) of each element at the amplitude X, where F is 0.8 N for the one of Jenkins; and the
    orbit's multipliers are inside the unit circle."""
    model = Driven(friction=law)
    settled = fl.steady_state(model, transient=80.0, window=20.0, progress=False)
    orbit = fl.periodic_orbit(model, settled)
    assert orbit.stable
    run = fl.simulate(model, orbit.period, x0=orbit.state, sections={"turn": "x'"}, progress=False)
    amplitude = np.ptp(run.sections["turn"].state[:, 0]) / 2.0
    work = fl.energy_audit(run, progress=False).works["friction"][-1]
    assert work == pytest.approx(-4.0 * np.sum(F * np.maximum(amplitude - F / k, 0.0)), rel=1e-9)


@pytest.mark.parametrize("law", [ELEMENT, IWAN], ids=str)
def test_steady_sliding_is_coulombs(law):
    """Where the sliders slip the deflections are at their limits, and have no eigenvalue."""
    model, coulomb = fl.MassOnBelt(friction=law, c=0.1), fl.MassOnBelt(mu_k=MU, mu_s=MU, c=0.1)
    point, limits = fl.equilibrium(model), [MU / K_T] if law is ELEMENT else LIMITS / N / SPRINGS
    assert point.state == pytest.approx([*fl.equilibrium(coulomb).state, *limits], rel=1e-13)
    assert fl.eigenvalues(model).values == pytest.approx(fl.eigenvalues(coulomb).values, rel=1e-12)
    assert fl.eigenvalues(model.without("nonsmooth")).values == pytest.approx(
        fl.eigenvalues(coulomb).values, rel=1e-12
    )


@fl.model
class SideBySide(fl.MechanicalModel):
    """A mass that elements hold, each with a contact of its own."""

    coordinates = ("x",)

    def mechanics(self, q, v):
        elements = [fl.Jenkins(mu_k=float(f) / N, k_t=float(k)) for f, k in zip(LIMITS, SPRINGS, strict=True)]
        contacts = tuple(fl.Friction(-v.x, N, element) for element in elements)
        return fl.Mechanics(v.x**2 / 2, q.x**2, contacts=contacts)


@fl.model
class Held(fl.MechanicalModel):
    """The same mass on one contact."""

    friction: fl.FrictionLaw = IWAN
    coordinates = ("x",)

    def mechanics(self, q, v):
        return fl.Mechanics(v.x**2 / 2, q.x**2, contacts=(fl.Friction(-v.x, N, self.friction),))


def test_an_iwan_element_is_jenkins_elements_side_by_side():
    """Its backbone is the sum of min(k_i x, F_i), its unloading is by Masing's rule."""
    run, other = (fl.simulate(model, 3.0, x0={"x'": 0.5}, progress=False) for model in (Held(), SideBySide()))
    assert run.names == ("x", "x'", "z1", "z2", "z3")
    assert run.mode[0] == "contact | stick | stick | stick"
    assert np.allclose(run.final_state, other.final_state, rtol=0.0, atol=1e-14)
    assert np.allclose(run.events.t, other.events.t, rtol=0.0, atol=1e-13)

    def backbone(x):
        return np.minimum(np.multiply.outer(x, SPRINGS), LIMITS).sum(axis=-1)

    t = np.linspace(0.0, 3.0, 3001)
    x, force = run(t)[:, 0], -run.output("friction_force", t)
    top, low = np.argmax(x), np.argmin(x)
    assert {*run.mode_names} >= {"contact | slip- | slip- | slip-", "contact | stick | slip+ | stick"}
    assert np.allclose(force[:top], backbone(x[:top]), atol=1e-12)
    turned = fl.simulate(Held(), 3.0, x0={"x'": 0.5}, sections={"turn": "x'"}, progress=False)
    highest = turned.sections["turn"].state[0, 0]
    unloading = backbone(highest) - 2.0 * backbone((highest - x[top + 1 : low]) / 2.0)
    assert np.allclose(force[top + 1 : low], unloading, atol=1e-12)
    assert fl.energy_audit(run, progress=False).error < 1e-13


def test_its_first_loading_is_that_of_iwans_uniform_distribution():
    """F = k x - (k x)^2/(4 mu N) midway between the deflections at which elements slip, for any number."""
    for n in (1, 3, 10):
        law = fl.Iwan(mu_k=MU, k_t=K_T, elements=n)
        limits = np.array([*law.state_limit(N).values()])
        x = 2 * MU * N / K_T * np.arange(1, n + 1) / n
        force = [law.force(N, 0.0, *np.minimum(limits, one)) for one in x]
        assert np.allclose(force, K_T * x - (K_T * x) ** 2 / (4 * MU * N), rtol=1e-12)


def stepped(model, t_end, n):
    """Midpoint steps of the motion, after which each deflection is cut at its limit."""
    h, spring, damping = t_end / n, model.k, 0.2
    state, z = np.zeros(2), np.zeros(3)

    def moved(z, dx, t):
        largest = LIMITS / SPRINGS * (1.0 + model.a * np.cos(6.0 * t))
        return np.clip(z - dx, -largest, largest)

    def rates(state, z, t):
        x, v = state
        return np.array([v, model.F * np.cos(3.0 * t) - spring * x - damping * v + SPRINGS @ z])

    for t in h * np.arange(n):
        half = state + h / 2 * rates(state, z, t)
        between = moved(z, half[0] - state[0], t + h / 2)
        following = state + h * rates(half, between, t + h / 2)
        z, state = moved(between, following[0] - half[0], t + h), following
    return np.array([*state, *z])


@pytest.mark.parametrize("a", [0.0, 0.6])
def test_it_moves_as_steps_that_cut_deflections(a):
    """Also where the limits breathe, so that elements slip in both directions at once."""
    model = Driven(friction=IWAN, a=a)
    run = fl.simulate(model, 4.0, progress=False)
    coarse, fine = (stepped(model, 4.0, n) for n in (4000, 8000))
    assert np.abs(fine - coarse).max() < 1e-5  # how exact the steps are
    assert np.allclose(run.final_state[[0, 1, 3, 4, 5]], fine, rtol=0.0, atol=1e-5)
    assert fl.verify(model, 4.0, progress=False).ok


def test_it_takes_the_place_of_any_law():
    """A run that is begun beside steady sliding, orbits, films and pages know nothing of its elements."""
    model = fl.MassOnBelt(c=0.1).replace(friction=fl.Iwan())
    fl.testing.check_law(model.friction)
    fl.testing.check_law(IWAN)
    fl.testing.check_model(model)
    assert fl.steady_state(model, transient=200.0, progress=False).kind == "equilibrium"
    assert fl.critical_value(model.replace(c=0.0), "k", bounds=(0.5, 2.0)) is None
    assert fl.eigenvalues(fl.FreeCoulomb(friction=IWAN)).frequencies.max() > 0.0


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"elements": 0}, "elements must be an integer, at least 1, at most 30, got 0"),
        ({"elements": 2.5}, "elements must be an integer, at least 1, at most 30, got 2.5"),
        ({"strengths": (1, 2)}, r"strengths must have one number for each of 3 elements, got 2: write"),
        ({"strengths": (1, 2, 4), "stiffnesses": (3, 1, 2)}, "strengths must be in different ratios to stif"),
        ({"stiffnesses": (1, 2, 0.0)}, "each of stiffnesses must be .*above 0, got 0.0"),
    ],
)
def test_wrong_elements_are_refused(given, words):
    with pytest.raises(ValueError, match=words):
        fl.Iwan(**given)


def test_elements_are_what_python_and_numpy_count_and_list():
    law = fl.Iwan(elements=2.0, strengths=np.array([1.0, 3.0]), stiffnesses=[2, 1])
    assert law == fl.Iwan(elements=2, strengths=(1.0, 3.0), stiffnesses=(2, 1))
    assert repr(law).endswith("elements=2, strengths=(1.0, 3.0), stiffnesses=(2, 1))")
    assert fl.simulate(fl.MassOnBelt(friction=law), 0.1, progress=False).names[2:] == ("z1", "z2")


def test_a_law_of_several_limits_names_them():
    class OneLimit(fl.Iwan):
        def state_limit(self, normal_force):
            return self.mu_k * normal_force

    with pytest.raises(
        ValueError, match=r"OneLimit.state_limit must give the limit of each of its states z1"
    ):
        fl.simulate(fl.MassOnBelt(friction=OneLimit()), 1.0, progress=False)


def test_its_equations_and_its_check():
    fl.testing.check_law(ELEMENT)
    fl.testing.check_model(Driven())
    assert "Abs(z(t)) <= mu_k*F_N(t)/k_t" in str(Driven().equations("stick"))
    assert "F_T(t) = mu_k*F_N(t)" in str(Driven().equations("slip+"))


def test_a_run_begins_with_a_deflection_within_the_limit():
    limit = MU * N / K_T
    run = fl.simulate(Driven(), 0.1, x0={"z": limit}, progress=False)
    assert run.status.ok
    with pytest.raises(
        ValueError, match=r"must have z within the limit of its friction law, 0\.0266667 here"
    ):
        fl.simulate(Driven(), 0.1, x0={"z": 1.0}, progress=False)


def test_a_deflection_carried_to_a_lower_limit_begins_there():
    model = Driven()
    diagram = fl.bifurcation(
        model, "mu_k", [0.4, 0.05], x0="continue", transient=20.0, window=10.0, progress=False
    )
    assert "ended early" not in map(str, diagram.kinds)
    orbit = fl.periodic_orbit(model.replace(mu_k=0.05), fl.simulate(model, 50.0, progress=False))
    assert orbit.period == pytest.approx(model.period, rel=1e-12)


def test_a_normal_force_with_a_damper_is_refused():
    @fl.model
    class Damped(fl.MechanicalModel):
        friction: fl.FrictionLaw = ELEMENT
        coordinates = ("x", "y")

        def mechanics(self, q, v):
            rubbing = fl.Friction(-v.x, 10.0 * q.y + v.y, self.friction, penetration=q.y)
            return fl.Mechanics((v.x**2 + v.y**2) / 2, contacts=(rubbing,))

    with pytest.raises(ValueError, match="a state_limit that does not depend on velocities"):
        fl.simulate(Damped(), 1.0, progress=False)


@pytest.mark.slow
@pytest.mark.parametrize("law", [fl.Jenkins(k_t=1e4, mu_k=0.4), fl.Iwan(k_t=1e4, mu_k=0.4)], ids=str)
def test_the_papers_slider_with_an_element_slides_lifts_off_and_lands(law):
    """Its eigenvalues are those with Coulomb's law; verify finds nothing, past re-contacts."""
    model = fl.SliderOnBelt(friction=law, F=100.0).without("geometry")
    coulomb = fl.SliderOnBelt(mu_k=0.4, mu_s=0.4, F=100.0).without("geometry")
    assert np.allclose(fl.eigenvalues(model).values, fl.eigenvalues(coulomb).values, rtol=1e-8)
    run = fl.simulate(model, 1.0, x0={"y1": 0.02}, progress=False)
    regimes = {regime for name in run.mode_names for regime in name.split(" | ")}
    assert {"stick", "slip+", "separation"} <= regimes
    assert run.status.ok
    assert fl.verify(model, 0.5, x0={"y1": 0.02}, progress=False).ok
    assert fl.verify(Driven(), 6.0, progress=False).ok


@pytest.mark.parametrize(
    ("law", "state", "place"),
    [(fl.Jenkins(mu_k=0.4, k_t=30.0), "z", 0), (fl.Iwan(mu_k=0.4, k_t=30.0), "z1", 1)],
    ids=["Jenkins", "Iwan"],
)
def test_elements_keep_to_a_limit_that_a_damper_moves(law, state, place):
    """Its rate has the acceleration of the bodies, which was left out."""

    class Pressed(fl.MechanicalModel):
        coordinates = ("x", "y")

        def mechanics(self, q, v):
            pad = fl.Friction(0.3 - v.x, lambda d: 100.0 * d, law, penetration=-q.y, damper=2.0)
            kinetic, dissipation = (v.x**2 + v.y**2) / 2, 0.02 * (v.x**2 + v.y**2)
            loads = {"y": fl.functions.cos(q.phase)}
            potential = q.x**2 + 8 * q.y
            return fl.Mechanics(
                kinetic, potential, dissipation=dissipation, loads=loads, contacts=(pad,), frequency=3.0
            )

    run = fl.simulate(fl.model(Pressed)(), 4.0, x0=[0.2, -0.08, 0.0, 0.0], progress=False)
    slips = np.array([name.split(" | ")[place] == "slip+" for name in run.mode])
    assert slips.any()
    force = -100.0 * run["y"] - 2.0 * run["y'"]
    share = run[state][slips] / force[slips]
    limit = law.state_limit(1.0)
    assert share == pytest.approx(limit if state == "z" else limit["z1"], rel=1e-12)
