"""Contacts of structures whose friction laws have states of their own."""

from __future__ import annotations

import pickle
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import frictionlab as fl
from tests.helpers.laws import Circle


@dataclass(frozen=True)
class Ruina(fl.FrictionLaw):
    """The slip law of A. Ruina, J. Geophys. Res. 88 (1983) 10359: its logarithm has no value at zero."""

    a: float = fl.parameter(0.05)
    b: float = fl.parameter(0.03)
    D: float = fl.parameter(0.05, exclusive_minimum=0.0)
    states = ("theta",)

    def force(self, F_N, v, theta):
        log = fl.functions.log
        return F_N * v / abs(v) * (0.6 + self.a * log(abs(v) / 0.1) + self.b * log(theta * 0.1 / self.D))

    def rates(self, F_N, v, theta):
        slips = abs(v) * theta / self.D
        return {"theta": -slips * fl.functions.log(slips)}


@dataclass(frozen=True)
class BoucWen(fl.FrictionLaw):
    """Of the exponent 2: its rate has no slope at zero."""

    mu: float = fl.parameter(0.3, exclusive_minimum=0.0)
    states = ("z",)

    def force(self, F_N, v, z):
        return self.mu * z * F_N

    def rates(self, F_N, v, z):
        return {"z": 40.0 * (v - 0.5 * abs(v) * fl.functions.absolute(z) * z - 0.5 * v * z**2)}


@dataclass(frozen=True)
class CubicBristles(fl.FrictionLaw):
    mu: float = fl.parameter(0.3, exclusive_minimum=0.0)
    states = ("z",)

    def force(self, F_N, v, z):
        return 50.0 * z**3 * F_N

    def rates(self, F_N, v, z):
        return {"z": v - 50.0 * abs(v) * z**3 / self.mu}


@dataclass(frozen=True)
class Asperities(fl.FrictionLaw):
    """Its state settles at -0.9 and 0.6, and between them at 0.1, from which it grows."""

    rate: float = fl.parameter(1.0)
    states = ("z",)

    def force(self, F_N, v, z):
        return v / abs(v) * (z + 0.9) * F_N

    def rates(self, F_N, v, z):
        return {"z": -self.rate * (z + 0.9) * (z - 0.1) * (z - 0.6)}


@dataclass(frozen=True)
class Latch(fl.FrictionLaw):
    """Its state settles at -1 and 1, which are as near to zero; the mass is nearer to zero at -1."""

    states = ("z",)

    def force(self, F_N, v, z):
        return v / abs(v) * (0.5 + 0.2 * z) * F_N

    def rates(self, F_N, v, z):
        return {"z": z - z**3}


LAWS = [
    fl.LuGre(),
    fl.Dahl(),
    fl.Jenkins(),
    fl.Iwan(),
    fl.RateAndState(a=0.05, b=0.03, D_c=0.05, v_0=0.1),
    Ruina(),
    BoucWen(),
    CubicBristles(),
    Asperities(),
    Latch(),
]


@pytest.mark.parametrize("v", [0.2, -0.2])
@pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
def test_a_mass_on_a_belt_is_the_model(law, v):
    model = fl.MassOnBelt(friction=law, v=v, N=2.0)
    # a pressure on an area of 2
    belt = fl.SlidingContacts([[1.0]], N=model.N / 2, friction=law, v=v, area=2.0)
    if isinstance(law, (fl.Jenkins, fl.Iwan)):  # whose stiffness is no pressure's
        belt = fl.SlidingContacts([[1.0]], N=model.N, friction=law, v=v)
    structure = fl.Structure([[model.m]], [[model.k]], contacts=belt)
    one, other = fl.eigenvalues(model), fl.eigenvalues(structure)
    np.testing.assert_allclose(other.values, one.values, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(other.equilibrium.state, one.equilibrium.state, rtol=1e-12)
    x0 = [-0.05, 0.3, *0.5 * one.equilibrium.state[2:]]
    first, second = (fl.simulate(each, 5.0, x0=x0, progress=False) for each in (model, structure))
    assert first.names[2:] == second.names[2:]
    assert len(first.events) == len(second.events)
    np.testing.assert_allclose(second.final_state, first.final_state, rtol=1e-12, atol=1e-12)


def test_a_state_that_settles_at_several_values_is_where_it_does_not_grow_and_nearest_to_zero():
    """At -0.9 the mass is nearest to zero, at 0.1 the state."""
    models = [fl.MassOnBelt(friction=Asperities(rate=rate), v=0.2) for rate in (1.0, -1.0)]
    found = [[each.state[2] for each in fl.equilibria(model)] for model in models]
    np.testing.assert_allclose(found[0], [0.6, -0.9, 0.1], rtol=1e-12)
    # With the other sign 0.1 alone is where it does not grow.
    assert found[1][0] == pytest.approx(0.1, rel=1e-12)
    assert [fl.eigenvalues(model).equilibrium.state[2] for model in models] == [row[0] for row in found]


def test_states_at_zero_to_rounding_leave_the_equilibrium_that_is_nearest_to_the_origin():
    @dataclass(frozen=True)
    class Fading(fl.FrictionLaw):
        states = ("z",)

        def force(self, F_N, v, z):
            return v / abs(v) * (0.3 + z) * F_N

        def rates(self, F_N, v, z):
            return {"z": 1 - fl.functions.exp(z)}

    @fl.model
    class Wells(fl.MechanicalModel):
        load: float = 0.0
        coordinates = ("x",)

        def mechanics(self, q, u):
            pads = (fl.Friction(2.0 - u.x, 0.1, Fading()),)
            return fl.Mechanics(u.x**2 / 2, -self.load * q.x - q.x**2 / 2 + q.x**4 / 4, contacts=pads)

    for load in (0.1, 0.0, -0.1):  # beside that of friction
        found = [each.state[0] for each in fl.equilibria(Wells(load=load))]
        expected = sorted(np.roots([1.0, 0.0, -1.0, -load - 0.03]).real, key=abs)
        np.testing.assert_allclose(found, expected, rtol=1e-12)


M, K, LOAD = np.diag([1.0, 1.0, 2.0, 2.0]), np.diag([30.0, 40.0, 25.0, 35.0]), np.array([0.0, 1.0, 0.0, 1.0])
K[0, 2] = K[2, 0] = -8.0
K[1, 3] = K[3, 1] = -9.0


def pair(**changes) -> fl.Structure:
    """Two masses in the plane, each on a belt of its own with another law."""
    bristles = fl.LuGre(mu_k=0.3, mu_s=0.5, v_s=0.2, sigma_0=50.0, sigma_1=2.0, sigma_2=0.1)
    left = fl.SlidingContacts(
        [[1, 0, 0, 0]],
        [[0, 1, 0, 0]],
        fl.CubicContact(50.0, 20.0),
        bristles,
        0.4,
        penetration=0.4,
        name="left",
    )
    ageing = fl.RateAndState(mu_0=0.4, a=0.05, b=0.03, D_c=0.05, v_0=0.1)
    right = fl.SlidingContacts(
        [[0, 0, 1, 0.2]], [[0, 0, 0, 1]], fl.LinearContact(40.0), ageing, -0.3, penetration=0.5, area=2.0,
        name="right",
    )  # fmt: skip
    return fl.Structure(M, K, 0.05 * np.eye(4), contacts=[left, right], load=LOAD, **changes)


def rates(y, signs):
    """The pair's equations, written again; |v_r| is v_r times its sign."""
    q, v, z, psi = y[:4], y[4:8], y[8], y[9]
    depth, speed = q[1] + 0.4, 0.4 - v[0]
    mu = 0.3 + 0.2 * np.exp(-((speed / 0.2) ** 2))
    dz = speed - 50.0 * signs[0] * speed / mu * z
    pressed = 50.0 * depth + 20.0 * depth**3
    rubbed = (50.0 * z + 2.0 * dz + 0.1 * speed) * pressed
    other, speed = 2.0 * 40.0 * (q[3] + 0.5), -0.3 - v[2] - 0.2 * v[3]
    ageing = 0.05 * np.arcsinh(speed / 0.2 * np.exp((0.4 + 0.03 * psi) / 0.05)) * other
    forces = LOAD - K @ q - 0.05 * v + np.array([rubbed, -pressed, ageing, 0.2 * ageing - other])
    return np.array([*v, *forces / np.diag(M), dz, (0.1 * np.exp(-psi) - signs[1] * speed) / 0.05])


def test_eigenvalues_and_derivatives_of_two_contacts_with_different_laws():
    structure = pair()
    found = fl.eigenvalues(structure)
    at = found.equilibrium.state
    assert np.abs(rates(at, (1, -1))).max() < 1e-13
    columns = [np.imag(rates(at + 1e-30j * one, (1, -1))) / 1e-30 for one in np.eye(10)]
    expected = np.linalg.eigvals(np.array(columns).T)
    assert np.abs(found.values[:, None] - expected).min(axis=1).max() < 1e-12 * np.abs(expected).max()
    assert (fl.eigenvalues(pickle.loads(pickle.dumps(structure))).values == found.values).all()
    assert (fl.eigenvalues(fl.Structure.from_dict(structure.to_dict())).values == found.values).all()
    for name in ("sigma_1_left", "k2_left", "D_c_right", "v_right"):
        p = structure.parameters[name]
        ends = (fl.eigenvalues(structure.replace(**{name: p * (1 + h)})).values for h in (1e-5, -1e-5))
        slopes = np.subtract(*ends) / (2e-5 * p)
        assert np.abs(slopes - found.sensitivities(name)).max() < 1e-6 * np.abs(slopes).max()


def test_two_contacts_with_different_laws_move_as_their_equations():
    """v_r changes its sign at both; each sign is a smooth piece for the other integrator."""
    structure, y = pair(), np.array([0.5, -0.25, -0.23, -0.37, 0.0, 0.0, 0.7, 0.0, 0.0, 0.0])
    run = fl.simulate(structure, 4.0, x0=y, progress=False)
    assert run.names[8:] == ("z_1", "psi_2")
    assert {"slip+ | slip-", "slip- | slip+"} <= {*run.mode}
    for low, high in zip([0.0, *run.events.t], [*run.events.t, 4.0], strict=True):
        (middle,), _ = run.states_and_modes(np.array([0.5 * (low + high)]))
        signs = np.sign([0.4 - middle[4], -0.3 - middle[6] - 0.2 * middle[7]])
        solved = solve_ivp(
            lambda _, y, by: rates(y, by), (low, high), y, "DOP853", args=(signs,), rtol=1e-12, atol=1e-13
        )
        y = solved.y[:, -1]
    np.testing.assert_allclose(run.final_state, y, atol=1e-9)
    assert fl.energy_audit(run).error < 1e-12


def test_spectra_at_many_points_are_those_of_each():
    """Beside an open contact, whose states are gone."""
    structure = pair()
    left, right = structure.contacts
    gap = fl.SlidingContacts(
        [[1, 1, 0, 0]], [[0, 0.1, 0, 0]], friction=fl.Dahl(), penetration=-5.0, name="gap"
    )
    structure = structure.replace(contacts=[left, gap, right])
    values = np.array([-0.3, -0.2, 0.3])
    locus = fl.root_locus(structure, "v_right", values)
    for v, row in zip(values, locus.values, strict=True):
        expected = fl.eigenvalues(structure.replace(v_right=float(v))).values
        expected = expected[expected.imag >= 0.0]
        assert (len(row), len(expected)) == (6, 6)
        distances = np.abs(row[:, None] - expected)
        assert max(distances.min(axis=0).max(), distances.min(axis=1).max()) < 1e-10


def test_a_reduced_structure_keeps_the_states_of_its_contacts():
    structure = pair(window=(0.0, 3.0))
    basis = np.linalg.qr(np.random.default_rng(0).standard_normal((4, 3)))[0]
    small = structure.projected(basis)
    exact, found = fl.eigenvalues(structure).values, fl.eigenvalues(small)
    distances = np.abs(found.values[:, None] - exact).min(axis=1)
    assert (distances <= small.error_bounds() * (1 + 1e-9)).all()
    whole = structure.projected(np.linalg.qr(basis @ basis.T + np.eye(4))[0])
    found = fl.eigenvalues(whole).values
    assert np.abs(found[:, None] - exact).min(axis=1).max() < 1e-10
    assert whole.error_bounds().max() < 1e-9


def test_large_structures_have_their_states_in_the_window():
    n = 420
    chain = 2.0 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    pads = fl.SlidingContacts(np.eye(n)[:3], N=1.0, friction=fl.LuGre(sigma_0=5.0, sigma_1=0.1, v_s=0.5))
    structure = fl.Structure(np.eye(n), 1e4 * chain, contacts=pads, window=(0.0, 4.0))
    found = fl.eigenvalues(structure)
    A, B = (np.block(one) for one in companion(structure))
    expected = np.linalg.eigvals(np.linalg.solve(B, A))
    upper = expected[(expected.imag > 0.0) & (expected.imag < 8 * np.pi)]
    assert len(upper) == (found.values.imag > 0.0).sum()
    assert np.abs(upper[:, None] - found.values).min(axis=1).max() < 1e-9 * 8 * np.pi


def companion(structure):
    """(q, v, z) of z' = v_r - a z, of bristles at v_r = 1 and F_N = 1, in matrices written again."""
    n, law = structure.size, structure.contacts[0].friction
    bump = (law.mu_s - law.mu_k) * np.exp(-((1.0 / law.v_s) ** 2))
    mu, slope = law.mu_k + bump, -2.0 / law.v_s**2 * bump
    a, by_speed = law.sigma_0 / mu, slope / mu  # 1 - (v/mu)' sigma_0 z, with sigma_0 z = mu
    rows, zero = np.eye(n)[:3], np.zeros((n, 3))
    K, unit = structure.K.at({}).toarray(), np.eye(n)
    C = law.sigma_1 * by_speed * rows.T @ rows
    top = [[np.zeros((n, n)), unit, zero], [-K, -C, (law.sigma_0 - law.sigma_1 * a) * rows.T]]
    return [*top, [np.zeros((3, n)), -by_speed * rows, -a * np.eye(3)]], [
        [unit, np.zeros((n, n)), zero],
        [np.zeros((n, n)), unit, zero],
        [zero.T, zero.T, np.eye(3)],
    ]


@pytest.mark.parametrize("law", [fl.Jenkins(mu_k=0.4, k_t=30.0), fl.LuGre(sigma_0=30.0, sigma_1=1.0)])
def test_states_are_lost_with_their_contact(law):
    """Two contacts that hop, beside one of Coulomb's that rubs along the first one's direction."""
    rows = [[1, 0, 0, 0], [0, 0, 1, 0]], [[0, 1, 0, 0], [0, 0, 0, 1]]
    hops = fl.SlidingContacts(
        *rows, fl.LinearContact(50.0), law, 0.4, impact=fl.PlasticImpact(), area=[1.0, 2.0]
    )
    rubs = fl.SlidingContacts([[1, 0, 0, 0]], N=1.0, friction=fl.Coulomb(0.2, 0.4), v=0.4, name="c")
    structure = fl.Structure(M, K, 0.05 * np.eye(4), contacts=[hops, rubs], load=LOAD)
    run = fl.simulate(structure, 4.0, x0=[0.3, -0.1, 0.2, 0.5, 0.0, 2.0, 0.3, -1.0], progress=False)
    apart = np.char.startswith(run.mode.astype(str), "separation")
    assert 0 < apart.sum() < len(apart)
    assert not run["z_1"][apart].any()
    assert fl.energy_audit(run).error < 1e-12
    assert {*fl.simulate(structure, 0.1, x0="near", progress=False).mode} == {"slip+ | slip+ | slip+"}


@pytest.mark.parametrize("count", [1, 2])
def test_elements_land_by_rk4_too(count):
    """RK4, and Taylor from the second start, found no mode: forces are zero there but for rounding."""
    rows, law = np.eye(4)[:3:2][:count], fl.Iwan(mu_k=0.4, k_t=30.0)
    hops = fl.SlidingContacts(
        rows, np.roll(rows, 1, axis=1), fl.LinearContact(50.0), law, 0.4, impact=fl.PlasticImpact()
    )
    structure = fl.Structure(M, K, 0.05 * np.eye(4), contacts=hops, load=LOAD)
    for x0 in ([0.3, -0.1, 0.2, -0.1, 0.0, 2.0, 0.3, 1.0], [0.3, -0.1, 0.2, 0.5, 0.0, 2.0, 0.3, -1.0]):
        one, other = (
            fl.simulate(structure, 1.2, x0=x0, method=each, progress=False)
            for each in (fl.RK4(step=1e-3), fl.Taylor())
        )
        assert other.status.ok
        np.testing.assert_allclose(one.final_state, other.final_state, atol=1e-9)


def test_what_has_no_meaning_is_refused():
    rows, law = [[1.0]], fl.Jenkins()
    structure = fl.Structure([[1.0]], [[1.0]], contacts=fl.SlidingContacts(rows, N=1.0, friction=law))
    with pytest.raises(ValueError, match="within the limit of its friction law"):
        fl.simulate(structure, 1.0, x0={"z": 1.0})
    with pytest.raises(ValueError, match="laws without states to stick"):
        structure.replace(v=0.0).in_stick()
    with pytest.raises(ValueError, match="the state 'z' of a friction law must differ"):
        fl.Structure([[1.0]], [("z", [[1.0]])], parameters={"z": 1.0}, contacts=structure.contacts)


def test_a_range_in_which_nothing_slides_has_no_eigenvalues():
    """v = 0 alone, or a contact that is open."""
    rows = np.array([[1.0, 0.0]]), np.array([[0.0, 1.0]])
    pads = fl.SlidingContacts(*rows, fl.LinearContact(k2=50.0), fl.LuGre())
    one = fl.Structure(
        np.eye(2), np.eye(2), 0.1 * np.eye(2), contacts=pads, load=[("F", [0.0, 1.0])], parameters={"F": 1.0}
    )
    assert np.isnan(fl.root_locus(one, "v", [0.0]).values).all()
    assert np.isnan(fl.root_locus(one, "F", [-2.0, -1.0]).values).all()


def test_an_impact_without_friction_law_is_refused():
    """It was left out without a word; a law whose coefficients are zero has impacts without friction."""
    rows = np.array([[1.0, 0.0]]), np.array([[0.0, 1.0]])
    with pytest.raises(ValueError, match="impact must be None where contacts have no friction law"):
        fl.SlidingContacts(*rows, friction=None, impact=fl.RestitutionImpact(e=0.5))
    smooth = fl.Coulomb(mu_k=0.0, mu_s=0.0)
    pads = fl.SlidingContacts(*rows, fl.LinearContact(k2=50.0), smooth, impact=fl.RestitutionImpact(e=0.5))
    ball = fl.Structure(np.eye(2), np.eye(2), contacts=pads)
    run = fl.simulate(ball, 2.0, x0=[0.0, -1.0, 1.0, 2.0], progress=False)
    (event,) = run.events
    assert event.state == pytest.approx(event.before * [1.0, 1.0, 1.0, -0.5])


def on_belt(law: fl.FrictionLaw, v: float = 0.3, k: complex = 1.0, n: int = 1, **given: Any) -> fl.Structure:
    """A mass on a belt, beside n - 1 others."""
    contacts = fl.SlidingContacts(np.eye(1, n), N=2.0, friction=law, v=v)
    springs = np.diag([k, *[100.0] * (n - 1)])
    return fl.Structure(np.eye(n), springs, 0.05 * np.eye(n), contacts=contacts, **given)


@pytest.mark.parametrize("k", [1.0, 1.0 + 0.02j])
def test_flutter_with_the_slip_law_is_where_its_equation_puts_it(k):
    """(s^2 + g s + k)(s + w) = N b/D s with g = c + N a/v and w = v/D; k may be hysteretic."""
    law = fl.RateAndStateSlip(mu_0=2.0, a=0.05, b=0.12, D_c=0.05, v_0=0.1) if k.imag else Ruina(b=0.12)
    (change,) = fl.stability_changes(on_belt(law, k=k), "v", (0.05, 4.0))
    g, w, s = 0.05 + 2.0 * 0.05 / change.value, change.value / 0.05, 2j * np.pi * change.frequency
    assert (s**2 + g * s + k) * (s + w) == pytest.approx(2.0 * 0.12 / 0.05 * s, rel=1e-9)


def test_rayleigh_damping_of_a_complex_stiffness():
    """It is complex too, and its cast to real numbers warned; det Q(s) = 0 with C = alpha + beta k."""
    law, k = fl.LuGre(), 1.0 + 0.02j
    structure = on_belt(law, k=k).replace(C=fl.RayleighDamping(0.1, 0.05))
    C = on_belt(law).pencil.C.toarray() + (0.05 + 0.05 * k) * np.diag([1.0, 0.0])
    K = on_belt(law).pencil.K.toarray() + (k - 1.0) * np.diag([1.0, 0.0])
    for s in fl.eigenvalues(structure).values:
        terms = s**2 * np.diag([1.0, 0.0]), s * C, K
        assert abs(np.linalg.det(sum(terms))) < 1e-9 * np.prod([np.abs(one).max() for one in terms[1:]])


@pytest.mark.parametrize("rate", [1.0, 1e-170])  # whose squares underflow
def test_states_that_settle_at_some_speeds(rate):
    settles = on_belt(Circle(rate))
    z = np.sqrt(1.0 - 0.3**2)
    np.testing.assert_allclose(fl.equilibrium(settles).state[2:], [z, 0.1 * z], rtol=1e-12)
    for structure in (settles, on_belt(Circle(rate), 2.0)):
        locus = fl.root_locus(structure, "v", [0.3, 0.6, 1.2])
        assert (np.isnan(locus.values).all(axis=1) == [False, False, True]).all()
        for study in (fl.root_locus, fl.stability_changes):
            with pytest.raises(ValueError, match="friction must have states that settle"):
                study(structure, "v", (1.2, 1.5))


@pytest.mark.parametrize("n", [1, 60])
@pytest.mark.parametrize(("window", "v"), [(None, 0.3), ((0.0, 0.5), 2.0)])  # at 2.0 nothing settles
def test_structures_of_all_sizes_have_nothing_where_no_state_settles(n, window, v):
    known, structure = on_belt(Circle()), on_belt(Circle(), v, n=n, window=window)
    locus = fl.root_locus(structure, "v", [1.2, 0.3, 1.5, 0.6])
    assert (np.isnan(locus.values).all(axis=1) == [True, False, True, False]).all()
    assert np.isfinite(locus.values[[1, 3]]).all(axis=0).any()  # one mode in one column
    for bounds in ((0.1, 1.5), (-1.5, -0.1)):
        expected, found = (fl.stability_changes(one, "v", bounds) for one in (known, structure))
        assert [one.unstable for one in found] == [one.unstable for one in expected]
        values = [[one.value for one in some] for some in (found, expected)]
        np.testing.assert_allclose(*values, rtol=1e-8)
    for study in (fl.root_locus, fl.stability_changes):
        with pytest.raises(ValueError, match="friction must have states that settle"):
            study(structure, "v", (1.2, 1.5))
