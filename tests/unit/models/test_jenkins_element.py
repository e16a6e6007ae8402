"""Jenkins' element: a spring in series with a slider, whose stick is elastic; and Iwan's, of several."""

import math

import numpy as np
import pytest

import frictionlab as fl

MU, K_T, N = 0.4, 30.0, 2.0
ELEMENT = fl.Jenkins(mu_k=MU, k_t=K_T)


@fl.model
class Driven(fl.MechanicalModel):
    """A mass on a spring, held by the element and driven."""

    F: float = 2.0
    k: float = 4.0
    friction: fl.FrictionLaw = ELEMENT
    coordinates = ("x",)
    period = 2.0 * math.pi / 3.0

    def mechanics(self, q, v):
        loads = {"x": self.F * fl.functions.cos(q.phase)}
        rubbing = fl.Friction(-v.x, N, self.friction)
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


def test_a_cycle_takes_the_energy_of_its_loop():
    """4 mu N (X - mu N/k) at the amplitude X, and the orbit's multipliers are inside the unit circle."""
    settled = fl.steady_state(Driven(), transient=80.0, window=20.0, progress=False)
    orbit = fl.periodic_orbit(Driven(), settled)
    assert orbit.stable
    run = fl.simulate(Driven(), orbit.period, x0=orbit.state, sections={"turn": "x'"}, progress=False)
    amplitude = np.ptp(run.sections["turn"].state[:, 0]) / 2.0
    work = fl.energy_audit(run, progress=False).works["friction"][-1]
    assert work == pytest.approx(-4.0 * MU * N * (amplitude - MU * N / K_T), rel=1e-9)


def test_steady_sliding_is_coulombs():
    """Where the slider slips the deflection is at its limit, and has no eigenvalue."""
    model, coulomb = fl.MassOnBelt(friction=ELEMENT, c=0.1), fl.MassOnBelt(mu_k=MU, mu_s=MU, c=0.1)
    point = fl.equilibrium(model)
    assert point.state == pytest.approx([*fl.equilibrium(coulomb).state, MU / K_T], rel=1e-13)
    assert fl.eigenvalues(model).values == pytest.approx(fl.eigenvalues(coulomb).values, rel=1e-12)
    assert fl.eigenvalues(model.without("nonsmooth")).values == pytest.approx(
        fl.eigenvalues(coulomb).values, rel=1e-12
    )


STRENGTHS = (0.1, 0.3, 0.6)


@fl.model
class Iwan(fl.MechanicalModel):
    """Three elements side by side, of different strengths."""

    coordinates = ("x",)

    def mechanics(self, q, v):
        elements = [fl.Jenkins(mu_k=mu, k_t=K_T) for mu in STRENGTHS]
        contacts = tuple(fl.Friction(-v.x, N, element) for element in elements)
        return fl.Mechanics(v.x**2 / 2, q.x**2, contacts=contacts)


def test_an_iwan_element_is_several_contacts():
    """Its backbone is the sum of min(k_t x, mu_i N)."""
    run = fl.simulate(Iwan(), 0.5, x0={"x'": 0.5}, progress=False)
    assert run.names == ("x", "x'", "z_1", "z_2", "z_3")
    first = np.flatnonzero(np.diff(run["x"], append=0.0) < 0.0)[0]
    x = run["x"][:first]
    force = sum(run[f"friction_force_{i}"][:first] for i in (1, 2, 3))
    assert len({*run.mode[:first]}) >= 3
    assert np.allclose(force, -sum(np.minimum(K_T * x, mu * N) for mu in STRENGTHS), atol=1e-12)
    assert fl.energy_audit(run, progress=False).error < 1e-13


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

    with pytest.raises(ValueError, match="whose limit does not depend on velocities"):
        fl.simulate(Damped(), 1.0, progress=False)


@pytest.mark.slow
def test_the_papers_slider_with_an_element_slides_lifts_off_and_lands():
    """Its eigenvalues are those with Coulomb's law; verify finds nothing, past re-contacts."""
    model = fl.SliderOnBelt(friction=fl.Jenkins(k_t=1e4, mu_k=0.4), F=100.0).without("geometry")
    coulomb = fl.SliderOnBelt(mu_k=0.4, mu_s=0.4, F=100.0).without("geometry")
    assert np.allclose(fl.eigenvalues(model).values, fl.eigenvalues(coulomb).values, rtol=1e-8)
    run = fl.simulate(model, 1.0, x0={"y1": 0.02}, progress=False)
    assert {"stick", "slip+", "separation"} <= {*run.mode.tolist()}
    assert run.status.ok
    assert fl.verify(model, 0.5, x0={"y1": 0.02}, progress=False).ok
    assert fl.verify(Driven(), 6.0, progress=False).ok
