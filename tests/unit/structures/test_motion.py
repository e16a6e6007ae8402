"""The motion of structures: the classics as matrices, an independent integrator, what is refused."""

from __future__ import annotations

import operator
import pickle
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
import sympy
from scipy.integrate import solve_ivp
from scipy.optimize import linprog, lsq_linear

import frictionlab as fl
from frictionlab.automaton.matrix_rows import matrix_rows
from frictionlab.plotting import plot_rates
from frictionlab.tape import packing
from tests.helpers.flat_slider import slider_on_belt
from tests.helpers.random_structures import degenerate_structure, random_structure
from tests.reference.moreau import RubbingSystem, rubbing_steps

FLAT = fl.SliderOnBelt(geometry=fl.FixedLoad())


def agree(model: Any, structure: fl.Structure, t_end: float, x0: Any) -> None:
    """The motions of a model and a structure have the same events and states, to rounding."""
    one, other = (fl.simulate(each, t_end, x0=x0, progress=False) for each in (model, structure))
    assert len(one.events) > 5
    for name in ("source", "target", "guard"):
        np.testing.assert_array_equal(getattr(one.events, name), getattr(other.events, name))
    np.testing.assert_allclose(one.events.t, other.events.t, atol=1e-10)
    np.testing.assert_allclose(one.events.state, other.events.state, atol=1e-10)
    np.testing.assert_allclose(one.final_state, other.final_state, atol=1e-10)


@pytest.mark.parametrize(
    "impact",
    [
        fl.PlasticImpact(),
        pytest.param(fl.RestitutionImpact(e=0.3), marks=pytest.mark.slow(reason="another impact law")),
        pytest.param(
            fl.FrictionalImpact(e=0.2, mu_i=0.3), marks=pytest.mark.slow(reason="another impact law")
        ),
    ],
)
def test_slider_on_belt_from_matrices_moves_as_the_model(impact):
    model = FLAT.replace(impact=impact, mu_k=2.5)
    agree(model, structure := slider_on_belt(model), 0.5, "rest")
    one, other = (fl.simulate(each, 0.5, progress=False).events for each in (model, structure))
    impulses = one.outputs().values
    assert any("friction" in name for name in impulses) == isinstance(impact, fl.FrictionalImpact)
    for name, expected in impulses.items():
        assert expected.any()
        assert other[name] == pytest.approx(expected, abs=1e-10)


def two_blocks() -> fl.Structure:
    contacts = fl.SlidingContacts(np.eye(2), N=1.0, friction=fl.Coulomb(0.5, 1.0), v=0.2)
    return fl.Structure(np.eye(2), [[2.2, -1.2], [-1.2, 2.2]], contacts=contacts)


def test_two_blocks_from_matrices_move_as_the_model():
    agree(fl.TwoBlocks(), two_blocks(), 20.0, [0.1, 0.3, 0.0, 0.1])


@dataclass(frozen=True)
class BilinearContact(fl.ContactLaw):
    k2: float = fl.parameter(10.0)
    d: float = fl.parameter(0.1)

    def force(self, penetration):
        return self.k2 * (penetration + 10 * fl.functions.maximum(penetration - self.d, 0.0))


@dataclass(frozen=True)
class BilinearFriction(fl.FrictionLaw):
    mu_c: float = fl.parameter(0.4)

    def kinetic(self, F_N, speed):
        return F_N * (self.mu_c + fl.functions.maximum(speed - 0.2, 0.0))

    def static_limit(self, F_N):
        return 0.5 * F_N


M, C, K = np.eye(4), 0.05 * np.eye(4), 23 * np.eye(4) - 3 * np.ones((4, 4))


@fl.model
class PadsOnBelt(fl.MechanicalModel):
    contact: fl.ContactLaw = BilinearContact()
    friction: fl.FrictionLaw = BilinearFriction()
    v: float = 0.3
    count: int = 1
    coordinates = ("q0", "q1", "q2", "q3")

    def mechanics(self, q, v):
        depths = [one + 0.05 for one in q[2 : 2 + self.count]]
        contacts = [
            fl.Friction(self.v - rate, self.contact.force, self.friction, penetration=depth)
            for rate, depth in zip(v, depths)
        ]
        kinetic, stored, lost = (fl.quadratic_form(one, x) / 2 for one, x in ((M, v), (K, q), (C, v)))
        return fl.Mechanics(kinetic, stored, lost, tuple(contacts), {"q2": 1.0, "q3": 1.0})


@pytest.mark.parametrize("count", [1, 2])  # all modes at once, and on demand
@pytest.mark.parametrize(
    "laws",
    [
        {"contact": BilinearContact(), "friction": fl.Coulomb(0.3, 0.5)},
        {"contact": fl.LinearContact(10.0), "friction": BilinearFriction()},
    ],
    ids=lambda laws: type(laws["friction"]).__name__,
)
def test_laws_in_pieces_move_as_those_of_the_model(laws, count):
    pads = fl.SlidingContacts(np.eye(4)[:count], np.eye(4)[2 : 2 + count], v=0.3, penetration=0.05, **laws)
    structure = fl.Structure(M, K, C, contacts=pads, load=[0.0, 0.0, 1.0, 1.0])
    x0 = [0.0, 0.1, 0.3, 0.2, 0.0, 0.0, 0.0, 0.0]
    model, structure = PadsOnBelt(**laws, count=count), pickle.loads(pickle.dumps(structure))
    agree(model, structure, 4.0, x0)
    for each in (model, structure):
        run = fl.simulate(each, 4.0, x0=x0, progress=False)
        assert any(" = " in guard for guard in run.events.guard)
        assert fl.energy_audit(run, progress=False).error < 1e-12


def test_many_contacts_may_be_open():
    """The name of their mode, with a regime of each, has more than 1000 characters."""

    def final_state(n):
        rows = np.eye(2 * n)
        pads = fl.SlidingContacts(rows[:n], rows[n:], fl.LinearContact(10.0), fl.Coulomb(), v=0.3)
        structure = fl.Structure(rows, 23 * rows, contacts=pads, load=[0.0] * n + [1.0] * n)
        x0 = [0.0] * n + [-0.1] * n + [0.0] * 2 * n
        return fl.simulate(structure, 0.2, x0=x0, progress=False).final_state

    assert final_state(90) == pytest.approx(np.repeat(final_state(1), 90), abs=1e-13)


def test_pads_on_one_body_share_its_friction():
    model = fl.MassOnBelt(N=3.0)
    rows = [[1.0], [1.0 + 1e-15]]  # the same rows twice are refused
    contacts = fl.SlidingContacts(rows, N=1.0, area=[1.0, 2.0], v=0.2, friction=fl.Coulomb(0.5, 1.0))
    one = fl.simulate(model, 30.0, progress=False)
    other = fl.simulate(fl.Structure([[1.0]], [[1.0]], contacts=contacts), 30.0, progress=False)
    assert len(one.events) > 2
    np.testing.assert_allclose(one.final_state, other.final_state, atol=1e-10)
    np.testing.assert_allclose(one.events.t, other.events.t, atol=1e-10)
    np.testing.assert_allclose(2 * other.friction_force_1, other.friction_force_2, atol=1e-12)


def test_pressures_on_an_area_are_forces():
    """Of twice the area: forces are twice those at half the normal force, also where the contact opens."""
    runs = []
    for area in (1.0, 2.0):
        friction = fl.PressureDependent(mu_k=0.3, mu_s=0.5, v_s=0.2, n=0.3, F_ref=2.0 / area)
        contact = fl.LinearContact(k2=6.0 / area)
        pads = fl.SlidingContacts([[1.0, 0.2]], [[0.1, 1.0]], contact, friction, v=0.3, area=area)
        structure = fl.Structure(np.eye(2), [[3.0, -1.0], [-1.0, 2.0]], contacts=pads, load=[0.0, 1.0])
        runs.append(fl.simulate(structure, 10.0, x0=[0.2, 0.1, 0.0, 1.0], progress=False))
    one, two = runs
    assert {"separation", "slip+", "stick"} <= {*one.events.target}
    np.testing.assert_allclose(two.events.t, one.events.t, rtol=1e-9)
    np.testing.assert_allclose(two.final_state, one.final_state, atol=1e-9)


def chain(contacts: int = 2, n: int = 4) -> fl.Structure:
    """Masses in a chain, coupled in both directions, pressed on a belt."""
    rng = np.random.default_rng(7)
    basis = np.linalg.qr(rng.standard_normal((n, n)))[0]
    K = basis @ np.diag([1.0, 2.0, 3.5, 5.0, *np.linspace(6.0, 9.0, n - 4)]) @ basis.T
    M = np.eye(n) + 0.1 * np.ones((n, n))
    rows = rng.standard_normal((2, contacts, n))
    sliding = fl.SlidingContacts(
        rows[0],
        0.3 * rows[1],
        contact=fl.CubicContact(k2=2.0, k_nl=1.0),
        friction=fl.Stribeck(mu_k=0.3, mu_s=0.6, v_s=0.5),
        v=0.4,
        penetration=0.5,
    )
    return fl.Structure(
        (M + M.T) / 2, (K + K.T) / 2, fl.RayleighDamping(alpha=0.01, beta=0.02), contacts=sliding
    )


class EventByEvent:
    """The chain's motion by DOP853 from event to event, with laws and regimes written again.

    A contact slips with v_r of the sign 1 or -1, sticks (0), or is open (None).
    """

    def __init__(self, structure: fl.Structure) -> None:
        (group,), self.p = structure.contacts, structure.parameters
        self.M, self.K = (matrix.at(self.p).toarray() for matrix in (structure.M, structure.K))
        self.C = self.p["alpha"] * self.M + self.p["beta"] * self.K
        self.T, self.G, self.gap = group.tangential.toarray(), group.normal.toarray(), group.penetration

    def normal(self, q):
        depth = np.maximum(self.G @ q + self.gap, 0.0)
        return self.p["k2"] * depth + self.p["k_nl"] * depth**3

    def speed(self, x):
        return self.p["v"] - self.T @ x[len(self.M) :]

    def forces(self, x, regimes):
        p, (q, w) = self.p, np.split(x, 2)
        pressing = self.normal(q)
        speed = np.abs(self.speed(x))
        falling = p["mu_k"] + (p["mu_s"] - p["mu_k"]) * np.exp(-((speed / p["v_s"]) ** 2)) + p["mu_v"] * speed
        friction = np.array([float(r or 0) for r in regimes]) * falling * pressing
        rest = -self.C @ w - self.K @ q - self.G.T @ pressing + self.T.T @ friction
        held = [i for i, r in enumerate(regimes) if r == 0]
        if held:
            reach = self.T[held] @ np.linalg.inv(self.M)
            friction[held] = np.linalg.solve(reach @ self.T[held].T, -reach @ rest)
            rest = rest + self.T[held].T @ friction[held]
        return pressing, friction, rest

    def rates(self, x, regimes):
        return np.concatenate([x[len(x) // 2 :], np.linalg.solve(self.M, self.forces(x, regimes)[2])])

    def guards(self, regimes):
        """Functions of the state that are positive while regimes last, each with what follows."""
        for i, regime in enumerate(regimes):
            depth = 1 if regime is not None else -1
            follows = "slip" if regime is None else None
            yield i, follows, lambda x, i=i, depth=depth: depth * (self.G @ x[: len(x) // 2] + self.gap)[i]
            if regime == 0:
                for sign in (1, -1):

                    def cone(x, i=i, sign=sign):
                        pressing, friction, _ = self.forces(x, regimes)
                        return self.p["mu_s"] * pressing[i] - sign * friction[i]

                    yield i, sign, cone
            elif regime is not None:
                yield i, 0, lambda x, i=i, sign=regime: sign * self.speed(x)[i]

    def run(self, x0, t_end):
        """Times of the events, and the state at the end."""
        t, x, times, fresh = 0.0, np.array(x0), [], set()
        open_ones = self.G @ x[: len(x) // 2] + self.gap < 0.0
        regimes = [None if o else int(np.sign(s)) for o, s in zip(open_ones, self.speed(x), strict=True)]
        while True:
            known = list(self.guards(regimes))
            watched = []
            for i, _, guard in known:
                # v_r is zero where slip begins, and rises from there

                def function(s, y, new=i in fresh, guard=guard, begins=t):
                    return 1.0 if new and s < begins + 1e-6 else guard(y)

                function.terminal, function.direction = True, -1
                watched.append(function)
            solved = solve_ivp(
                lambda _, y: self.rates(y, regimes),
                (t, t_end),
                x,
                "DOP853",
                events=watched,
                rtol=1e-10,
                atol=1e-12,
            )
            t, x = solved.t[-1], solved.y[:, -1]
            hit = next((n for n, when in enumerate(solved.t_events) if len(when)), None)
            if hit is None:
                return times, x
            times.append(t)
            i, follows, _ = known[hit]
            before, fresh = regimes[i], {i}
            regimes[i] = int(np.sign(self.speed(x)[i])) if follows == "slip" else follows
            if follows == 0:
                pressing, friction, _ = self.forces(x, regimes)
                if abs(friction[i]) > self.p["mu_s"] * pressing[i]:
                    regimes[i] = -int(before or 0)
            pressing, friction, _ = self.forces(x, regimes)
            for k in range(len(regimes)):  # a contact that stuck before may have to let go at this instant
                if k != i and regimes[k] == 0 and abs(friction[k]) > self.p["mu_s"] * pressing[k]:
                    regimes[k] = int(np.sign(friction[k]))
                    fresh.add(k)


@pytest.mark.slow(reason="DOP853 takes seconds; models of the library and the motion agree in the fast ones")
@pytest.mark.parametrize("n", [4, 18])  # 18 rows are two panels; one contact sticks as the other lets go
def test_a_motion_of_many_regimes_agrees_with_dop853_from_event_to_event(n):
    structure = chain(n=n)
    x0 = np.zeros((2, n))
    x0[:, :4] = [[0.5, -0.3, 0.4, 0.2], [0.3, 0.0, -0.2, 0.1]]
    x0 = x0.ravel()
    run = fl.simulate(structure, 12.0, x0=x0, progress=False)
    times, end = EventByEvent(structure).run(x0, 12.0)
    words = {word for name in run.events.target for word in name.split(" | ")}
    assert words == {"stick", "slip+", "slip-", "separation"}
    assert len(run.events) > 10
    np.testing.assert_allclose(run.events.t, times, atol=1e-7)
    np.testing.assert_allclose(run.final_state, end, atol=1e-7)


def test_friction_of_a_counterpart_at_rest_stops_an_oscillator_as_the_closed_form_says():
    rubbed = fl.SlidingContacts([[1.0]], N=1.0, friction=fl.Coulomb(0.1, 0.1), v=0.0)
    run = fl.simulate(fl.Structure([[1.0]], [[1.0]], contacts=rubbed), 20.0, x0=[1.05, 0.0], progress=False)
    # the amplitude falls by 2 mu N/k at each turn, until the spring does not overcome friction
    np.testing.assert_allclose(run.events.t, np.pi * np.arange(1, 6), rtol=1e-12)
    np.testing.assert_allclose(run.final_state, [-0.05, 0.0], atol=1e-14)
    # FrictionOscillator of siconos-tutorials comes to rest at 0.68204, in steps of 0.01 s
    strong = fl.Structure([[1.0]], [[1.0]], contacts=rubbed).replace(mu_k=1.0, mu_s=1.0)
    run = fl.simulate(strong, 100.0, x0=[12.0, 6.0], progress=False)
    np.testing.assert_allclose(run.final_state, [15 - np.hypot(13, 6), 0.0], atol=1e-12)
    assert run.final_state[0] == pytest.approx(0.6820441351954105, abs=2e-4)


def stuck_at_first(contacts: int) -> tuple[fl.Structure, np.ndarray]:
    """A body of two freedoms on more pads than these, which a belt takes along, and its start."""
    rng = np.random.default_rng(5)
    rows = np.column_stack([np.ones(contacts), rng.standard_normal(contacts)])
    pads = fl.SlidingContacts(
        rows, N=1.0, area=rng.uniform(0.5, 1.5, contacts), v=0.2, friction=fl.Coulomb(0.5, 0.5)
    )
    structure = fl.Structure(np.eye(2), [[1.0, 0.2], [0.2, 0.8]], [[0.05, 0.0], [0.0, 0.05]], contacts=pads)
    return structure, np.array([0.0, 0.0, 0.2, 0.0])


def rubs(structure: fl.Structure) -> RubbingSystem:
    """What Moreau's scheme knows of a structure with given normal forces."""
    (pads,), p = structure.contacts, structure.parameters
    zero = np.zeros((structure.size, structure.size))
    M, C, K = (sum((one.at(p).toarray() for one in terms), zero) for terms in structure.terms)
    return RubbingSystem(M, C, K, pads.tangential.toarray(), p["mu_k"] * p["N"] * pads.area, p["v"])


def test_more_stuck_contacts_than_freedoms_hold_up_to_the_load_of_limit_analysis():
    structure, x0 = stuck_at_first(5)
    run = fl.simulate(structure, 12.0, x0=x0, progress=False)
    held = np.array([name.split(" | ").count("stick") for name in run.events.target])
    assert run.mode[0].split(" | ").count("stick") == 2
    end = run.events.t[np.argmax(held < 2)]
    of = rubs(structure)
    # the longest time t at which forces within their limits balance the springs' and the dampers'
    push, still = of.stiffness @ [of.v, 0.0], of.damping @ [of.v, 0.0]
    balance = np.column_stack([of.tangents.T, -push])
    bounds = [*((-limit, limit) for limit in of.limits), (0.0, None)]
    longest = linprog([*np.zeros(5), -1.0], A_eq=balance, b_eq=still, bounds=bounds)
    assert end == pytest.approx(longest.x[-1], rel=1e-9)


@pytest.mark.slow(reason="Moreau's scheme takes seconds in Python")
def test_more_stuck_contacts_than_freedoms_move_as_moreaus_scheme_says():
    structure, x0 = stuck_at_first(5)
    run = fl.simulate(structure, 40.0, x0=x0, progress=False)
    assert len(run.events) > 4
    np.testing.assert_allclose(
        rubbing_steps(rubs(structure), x0[:2], x0[2:], 40.0, 2e-3), run.final_state, atol=2e-3
    )


@pytest.mark.slow(reason="Moreau's scheme takes seconds in Python")
@pytest.mark.parametrize("seed", [1, 2])
def test_contacts_that_change_together_change_at_the_first_trial(seed):
    n, rng = 10, np.random.default_rng(seed)
    A, B = rng.standard_normal((2, n, n))
    M, K = np.eye(n) + 0.3 * B @ B.T / n, np.eye(n) + A @ A.T / n
    q = rng.uniform(-1.0, 1.0, n)
    pads = fl.SlidingContacts(
        np.eye(n), N=1.0, area=np.abs(K @ (q + 0.1)), v=0.1, friction=fl.Coulomb(1.0, 1.0)
    )
    structure = fl.Structure((M + M.T) / 2, (K + K.T) / 2, contacts=pads)
    x0 = np.concatenate([q, np.full(n, 0.1)])  # no contact slips, and the forces that hold some are too large
    run = fl.simulate(structure, 1.3, x0=x0, progress=False)
    assert 1 < run.mode[0].count("slip") < n
    modes: Any = structure.automaton().modes
    assert len(modes.derived) <= len({*run.events.target}) + 3
    by_steps = rubbing_steps(rubs(structure), q, x0[n:], 1.3, 2e-3)
    np.testing.assert_allclose(by_steps, run.final_state, atol=2e-6)


def struck_at_once(seed: int) -> tuple[fl.Structure, np.ndarray]:
    """A structure on two to four contacts, more or fewer than its freedoms, which all close at 0.5 s."""
    rng = np.random.default_rng(seed)
    n, contacts, e = int(rng.integers(2, 6)), int(rng.integers(2, 5)), float(rng.uniform())
    v, shape = rng.standard_normal(n), rng.standard_normal((n, n))
    normal, tangent = rng.standard_normal((2, contacts, n))
    laws = fl.PlasticImpact("full"), fl.RestitutionImpact(e=e), fl.FrictionalImpact(e=e, mu_i=0.4)
    normal *= np.sign(normal @ v)[:, None]
    pads = fl.SlidingContacts(
        tangent,
        normal,
        contact=fl.LinearContact(k2=1e3),
        friction=fl.Coulomb(mu_k=0.3, mu_s=0.5),
        impact=laws[seed % len(laws)],
        v=0.0,
    )
    M = np.eye(n) + 0.3 * shape @ shape.T
    return fl.Structure((M + M.T) / 2, np.zeros((n, n)), contacts=pads), np.concatenate([-0.5 * v, v])


@pytest.mark.slow(reason="200 structures are derived")
def test_energy_never_grows_at_contacts_that_close_together():
    together = 0
    for seed in range(200):
        structure, x0 = struck_at_once(seed)
        n, M = structure.size, structure.M.at(structure.parameters).toarray()
        normal = structure.contacts[0].normal.toarray()

        def energies(x: np.ndarray, n: int = n, M: np.ndarray = M, normal: np.ndarray = normal) -> Any:
            depth = np.maximum(x[:, :n] @ normal.T, 0.0)
            return np.einsum("ij,jk,ik->i", x[:, n:], M, x[:, n:]) / 2 + 5e2 * (depth**2).sum(axis=1)

        run = fl.simulate(structure, 0.6, x0=x0, progress=False)
        (start,), (end,) = energies(x0[None]), energies(run.final_state[None])
        assert run.status.ok
        assert (energies(run.events.state) - energies(run.events.before) <= 1e-12 * start).all()
        assert end <= start * (1 + 1e-10)
        together += int((np.abs(run.events.t - 0.5) < 1e-12).sum() > 1)
    assert together > 20  # of the others the first impact opens what else closes


@pytest.mark.parametrize("place", [(0.0, 0.0), (0.4, -0.7)])
@pytest.mark.parametrize(
    ("impact", "cosine", "rates"),
    [(fl.PlasticImpact("full"), 0.5, (-0.2, 0.0)), (fl.RestitutionImpact(e=1.0), -0.5, (-0.9, -1.0))],
)
def test_each_contact_that_closes_at_one_instant_has_its_impact(impact, cosine, rates, place):
    """Closing rates 1 and 0.9 become 0 and 0.4, then -0.2 and 0; three reflections exchange them."""
    normal = np.array([[1.0, 0.0], [cosine, np.sqrt(1.0 - cosine**2)]])
    law, gap = fl.LinearContact(k2=1e3), -normal @ place
    tangent = normal[:, ::-1] * [1.0, -1.0]
    pads = fl.SlidingContacts(tangent, normal, law, v=0.0, impact=impact, penetration=gap)
    v = np.linalg.solve(normal, [1.0, 0.9])
    structure, x0 = fl.Structure(np.eye(2), np.zeros((2, 2)), contacts=pads), np.append(place - 0.1 * v, v)
    run = fl.simulate(structure, 0.2, x0=x0, progress=False)
    np.testing.assert_allclose(normal @ run.final_state[2:], rates, atol=1e-12)


def test_a_contact_slips_at_the_speed_that_others_stuck_give_it():
    """v_r = -v of the third, where the first two hold both freedoms: they let go as 2 N = k v t + N/2."""
    pads = fl.SlidingContacts(
        [[1.0, 0.0], [0.0, 1.0], [1.0, 1.0]],
        N=1.0,
        area=[4.0, 5.0, 1.0],
        v=0.2,
        friction=fl.Coulomb(0.5, 0.5),
    )
    structure = fl.Structure(np.eye(2), np.eye(2), contacts=pads)
    run = fl.simulate(structure, 8.0, x0=[0.0, 0.0, 0.2, 0.2], progress=False)
    assert run.mode[0] == "stick | stick | slip-"
    assert run.events.t[0] == pytest.approx((0.5 * 4.0 - 0.5) / 0.2, rel=1e-12)
    assert run.events.target[0] == "slip+ | stick | slip-"


def test_friction_that_is_not_unique_is_known_by_its_contacts():
    rows = [[1.0, 0.0], [0.0, 1.0], [0.0, 2.0], [1.0, 1.0]]
    structure = fl.Structure(np.eye(2), np.eye(2), contacts=fl.SlidingContacts(rows, N=1.0, v=0.2))
    # where the second sticks, the third and the fourth move at speeds of their own
    assert structure.undetermined_friction("stick | stick | slip- | slip-") == ()
    resting = structure.replace(v=0.0)
    assert resting.undetermined_friction("slip+ | stick | stick | slip+") == (2, 3)
    assert resting.undetermined_friction("stick | stick | stick | slip+") == (1, 2, 3, 4)
    with pytest.raises(ValueError, match="mode must be one of"):
        structure.undetermined_friction("stick")


def acceleration_by_least_squares(structure: fl.Structure, x: np.ndarray) -> np.ndarray:
    """q'' of a structure whose static limits are the friction in slip, as the minimum of a convex function.

    Forces F within their limits for which |q''|^2 in the metric of M is least: v_r' >= 0 at the upper limit,
    <= 0 at the lower one, and 0 between.  Contacts in other directions may have many such F, and one q''.
    """
    (group,), p, n = structure.contacts, structure.parameters, structure.size
    M, K = (one.at(p).toarray() for one in (structure.M, structure.K))
    T, G = group.tangential.toarray(), group.normal.toarray()
    pressing = p["k2"] * np.maximum(G @ x[:n] + group.penetration, 0.0)
    speed, limit = p["v"] - T @ x[n:], p["mu_k"] * pressing
    zero = (np.abs(speed) < 1e-9) & (limit > 1e-9)
    acting = structure.load_vector - K @ x[:n] - G.T @ pressing
    acting += T[~zero].T @ (np.sign(speed) * limit)[~zero]
    root = np.linalg.inv(np.linalg.cholesky(M))
    if zero.any():
        bounds = -limit[zero], limit[zero]
        acting += T[zero].T @ lsq_linear(root @ T[zero].T, -root @ acting, bounds, tol=1e-14).x
    return root.T @ root @ acting


@pytest.mark.parametrize(
    ("make", "seeds"),
    [
        (random_structure, (2, 17, 43, 205, 10059)),  # the last: plastic impacts without end
        (degenerate_structure, (43, 74, 191, 531, 558)),  # no mode was found at their starts
        pytest.param(random_structure, range(60), marks=pytest.mark.slow(reason="60 structures are derived")),
        pytest.param(
            degenerate_structure, range(150), marks=pytest.mark.slow(reason="150 structures are derived")
        ),
    ],
)
def test_random_structures_move_as_the_least_accelerations_say(make, seeds):
    stuck, t_end = 0, 3.0 if make is random_structure else 0.3
    for seed in seeds:
        structure, x0 = make(seed)
        run = fl.simulate(structure, t_end, x0=x0, progress=False)
        assert run.status.ok
        audit = fl.energy_audit(run, progress=False)
        assert audit.error < 1e-9
        p, n, h = structure.parameters, structure.size, 1e-7
        if not p["v"] and "impacts" in audit.works:
            assert np.diff(audit.works["impacts"]).max(initial=0.0) <= 1e-12 * max(audit.energies["kinetic"])
        known = zip([0.0, *run.events.t], [x0, *run.events.state], [*run.events.t, t_end], strict=True)
        for t, x, end in known if p["mu_k"] == p["mu_s"] else ():
            if end - t > 2 * h:
                found, exact = (run(t + h)[n:] - x[n:]) / h, acceleration_by_least_squares(structure, x)
                assert np.abs(found - exact).max() < 5e-3 * (1.0 + np.abs(exact).max()), seed
        stuck += sum("stick" in name for name in run.events.target)
    assert stuck >= len(seeds) or make is degenerate_structure


def _pad_by_energies(M, g, t, law, friction, v):
    """The body of a structure with one contact as a model."""

    class Pad(fl.MechanicalModel):
        m: float = 1.0
        coordinates = tuple(f"q{i}" for i in range(len(M)))

        def mechanics(self, q, u):
            depth, along = sum(map(operator.mul, g.tolist(), q)), sum(map(operator.mul, t.tolist(), u))
            pad = fl.Friction(v - along, 1.0 * depth, friction, penetration=depth, impact=law)
            return fl.Mechanics(fl.quadratic_form(M, u) / 2, contacts=(pad,))

    return fl.model(Pad)()


@pytest.mark.parametrize("seed", range(8))
def test_impulses_of_a_contact_whose_directions_are_coupled(seed):
    """Newton's law, a push in the cone, no energy but from what drives the counterpart; a model agrees."""
    rng = np.random.default_rng(seed)
    n, mu, v = int(rng.integers(2, 6)), float(rng.random()), float(rng.choice([0.0, 0.7]))
    (g, t, w), shape = rng.standard_normal((3, n)), rng.standard_normal((n, n))
    M, e = np.eye(n) + 0.3 * shape @ shape.T, float(rng.choice([0.0, 1.0, rng.random()]))
    g *= np.sign(g @ w)
    law, friction = fl.FrictionalImpact(e=e, mu_i=mu), fl.Coulomb(mu, mu)
    pads = fl.SlidingContacts([t], [g], fl.LinearContact(k2=1.0), friction, v=v, impact=law)
    structure = fl.Structure((M + M.T) / 2, np.zeros((n, n)), contacts=pads)
    run = fl.simulate(structure, 0.2, x0=[*(-0.1 * w), *w], progress=False)
    after = run.events.state[0, n:]
    model = fl.simulate(
        _pad_by_energies(M, g, t, law, friction, v), 0.2, x0=[*(-0.1 * w), *w], progress=False
    )
    assert model.events.state[0, n:] == pytest.approx(after, abs=1e-11)
    (p_N, p_T), *_ = np.linalg.lstsq(np.column_stack([-g, t]), M @ (after - w))
    assert g @ after == pytest.approx(-e * (g @ w), abs=1e-12)
    assert abs(p_T) <= mu * p_N + 1e-12
    assert after @ M @ after / 2 - w @ M @ w / 2 <= p_T * v + 1e-12


@pytest.mark.parametrize("law", [fl.PlasticImpact("full"), fl.RestitutionImpact(e=1.0)])
def test_an_impact_without_friction_pushes_along_the_normal_alone(law):
    """Also where the contact rubs nearly along its normal, in which friction would have to be large."""
    g, w, e = np.array([1.0, 1e-3]), np.array([1.0, 0.3]), getattr(law, "e", 0.0)
    pads = fl.SlidingContacts([[1.0, 0.0]], [g], fl.LinearContact(k2=1.0), v=0.5, impact=law)
    structure = fl.Structure(np.eye(2), np.zeros((2, 2)), contacts=pads)
    run = fl.simulate(structure, 0.2, x0=[*(-0.1 * w), *w], progress=False)
    np.testing.assert_allclose(run.events.state[0, 2:], w - (1 + e) * g * (g @ w) / (g @ g), atol=1e-15)


class HalfStopping(fl.FrictionalImpact):
    def friction(self, impulse, stopping_impulse):
        return stopping_impulse / 2


@pytest.mark.parametrize(("inclined", "e", "mu_i"), [(0.0, 0.4, 0.1), (0.4, 0.4, 0.0), (0.4, 0.0, 0.1)])
def test_an_impact_law_with_friction_of_its_own_is_asked_for_it(inclined, e, mu_i):
    """Here p_T halves v_r at the impulse without friction; p_N leaves -e times the rate that was there."""
    g, t, w = np.array([0.0, 1.0]), np.array([1.0, inclined]), np.array([0.3, 1.0])
    law, friction = HalfStopping(e=e, mu_i=mu_i), fl.Coulomb(0.1, 0.1)
    pads = fl.SlidingContacts([t], [g], fl.LinearContact(k2=1.0), friction, v=0.0, impact=law)
    structure = fl.Structure(np.eye(2), np.zeros((2, 2)), contacts=pads)
    run = fl.simulate(structure, 0.2, x0=[*(-0.1 * w), *w], progress=False)
    sliding = t @ w - (1 + e) * inclined  # after the normal impulse (1 + e) alone
    np.testing.assert_allclose(run.events.state[0, 2:], [w[0] - sliding / 2, -e], atol=1e-12)


def test_units_are_those_of_the_matrices():
    structure = chain().replace(units=("mm", "kN"))
    run = fl.simulate(structure, 1.0, progress=False)
    assert run.to_dataframe().attrs["units"]["normal_force_1"] == "kN"
    labels = [ax.get_ylabel() for ax in fl.plot_run(run).axes]
    assert {"displacement (mm)", "contact force (kN)"} <= {*labels}
    assert plot_rates(run)[0].axes.get_ylabel() == "velocity (mm/s)"
    assert repr(fl.equilibrium(structure)).endswith(" kN)")
    grids = {"x": ("q1", [0.0, 0.1]), "y": ("q2'", [0.0, 0.1])}
    axes = fl.basins(structure, **grids, transient=1.0, window=1.0, progress=False).plot()
    assert [axes.get_xlabel()[-4:], axes.get_ylabel()[-6:]] == ["(mm)", "(mm/s)"]
    quantities = fl.OrbitAmplitude("q1"), fl.OrbitIntensity(), fl.CriticalValue("N", (0, 1))
    assert [one.label_of(structure) for one in quantities] == [
        "amplitude of q1 (mm)",
        "L_s (mm²)",
        "critical N",
    ]
    assert "kN mm" in repr(fl.energy_audit(run))
    assert fl.Structure.from_dict(structure.to_dict()).units == ("mm", "kN")
    with pytest.raises(ValueError, match="units must be two texts"):
        structure.replace(units=("mm",))


def test_values_of_parameters_derive_nothing():
    structure = chain()
    modes = structure.automaton().modes
    assert structure.replace(mu_k=0.2, v=0.1, alpha=0.5).automaton().modes is modes
    run = fl.simulate(structure, 2.0, progress=False)
    again = pickle.loads(pickle.dumps(run))
    np.testing.assert_array_equal(again.final_state, run.final_state)
    np.testing.assert_array_equal(again.friction_force_2, run.friction_force_2)


def test_motions_have_no_derivatives_by_what_the_mass_depends_on():
    """m q'' = -q - q' m/10, so that omega^2 = 1/m - 1/400: motions have none by m, eigenvalues have."""
    body = fl.Structure([("m", [[1.0]])], [[1.0]], [("m", [[0.1]])], parameters={"m": 2.0})
    exact = fl.solve(fl.Structure([[2.0]], [[1.0]], [[0.2]]).automaton(), 1.0, x0=[1.0, 0.0], progress=False)
    run = fl.simulate(body, 1.0, x0=[1.0, 0.0], progress=False)
    np.testing.assert_allclose(run.final_state, exact.final_state, rtol=1e-12)
    omega = np.sqrt(1 / 2.0 - 1 / 400)
    frequency = fl.sensitivity(body, fl.ModeFrequency(0))
    assert frequency["m"] == pytest.approx(-1 / (4 * np.pi * 2.0**2 * omega), rel=1e-12)
    assert fl.sensitivity(body, fl.GrowthRate())["m"] == pytest.approx(0.0, abs=1e-15)
    assert "left out, without derivatives: m" in repr(fl.sensitivity(body, fl.EquilibriumCoordinate("q0")))
    measured = fl.Frequencies({0: 0.1}, 0.001)
    assert fl.fit(body, measured, ["m"])["m"] == pytest.approx(1 / ((0.2 * np.pi) ** 2 + 1 / 400), rel=1e-9)
    record = fl.TimeRecord([0.5, 1.0], {"q0": run([0.5, 1.0])[:, 0]}, error=1e-3)
    with pytest.raises(ValueError, match="m must not be one on which M of the structure depends"):
        fl.fit(body, [measured, record], ["m"])
    with pytest.raises(ValueError, match="m must not be one on which M of the structure depends"):
        fl.GrowthRate().values(body, {"m": np.array([1.0, 3.0])})
    with pytest.raises(ValueError, match="m must not be one on which M of the structure depends"):
        fl.optimum(body, fl.GrowthRate(), {"m": (1.0, 3.0)})
    with pytest.raises(ValueError, match="m must not be one on which M of the structure depends"):
        fl.hopf(body, "m", (1.0, 3.0))


def test_steady_states_over_a_parameter_are_those_of_the_model(tmp_path):
    structure = two_blocks()
    given = {"x0": [0.1, 0.3, 0.0, 0.1], "transient": 30.0, "window": 20.0, "progress": False}
    exact = fl.bifurcation(fl.TwoBlocks(), "v", [0.2, 0.4], **given)
    bent = fl.bifurcation(structure, "v", [0.2, 0.4], resume=tmp_path / "bent.jsonl", **given)
    assert bent.kinds == exact.kinds
    np.testing.assert_allclose(bent.periods, exact.periods, rtol=1e-9)
    np.testing.assert_allclose(bent.intensities, exact.intensities, rtol=1e-6, atol=1e-15)
    again = fl.load_bifurcation(tmp_path / "bent.jsonl")
    np.testing.assert_array_equal(again.intensities, bent.intensities)
    stored: Any = again.model
    np.testing.assert_array_equal(fl.eigenvalues(stored).values, fl.eigenvalues(structure).values)
    assert stored.to_dict() == structure.to_dict()


def test_a_saved_run_of_a_structure_is_loaded_with_it(tmp_path):
    structure = two_blocks()
    run = fl.simulate(structure, 1.0, progress=False)
    run.save(tmp_path / "run.npz")
    again = fl.load(tmp_path / "run.npz")
    np.testing.assert_array_equal(again.final_state, run.final_state)
    assert again.source.to_dict() == structure.to_dict()


def test_a_run_with_an_integral_lowers_only_the_modes_to_which_it_comes(monkeypatch):
    structure, lowered, lower = chain(), set(), packing.lower_mode
    x0 = fl.simulate(structure, 5.0, x0=[0.5, -0.3, 0.4, 0.2, 0.3, 0.0, -0.2, 0.1], progress=False)
    plain = fl.simulate(structure, 3.0, x0=x0.final_state, progress=False)
    monkeypatch.setattr(packing, "lower_mode", lambda mode, *a: (lowered.add(mode.name), lower(mode, *a))[1])
    square = {"square": "q1**2"}
    run = fl.solve(structure.automaton(), 3.0, x0=x0.final_state, quadratures=square, progress=False)
    modes: Any = structure.automaton().modes
    assert lowered - {""} == {*plain.mode, *plain.events.target} < {*modes.derived}
    np.testing.assert_array_equal(run.final_state, plain.final_state)
    for name in ("source", "target", "guard", "state"):
        np.testing.assert_array_equal(getattr(run.events, name), getattr(plain.events, name))


def test_near_begins_along_the_least_stable_mode():
    model = FLAT.replace(mu_k=1.4)
    structure = slider_on_belt(model)
    run = fl.simulate(structure, 0.02, x0="near", progress=False)
    rest = fl.equilibrium(model).q
    shift = run.q[0] - rest
    assert 0.0 < np.abs(shift).max() < 0.02 * np.abs(rest).max()
    assert not len(run.events)


def test_rows_of_a_matrix_are_expressions():
    x, y, z = sympy.symbols("x y z", real=True)
    one, other, single = matrix_rows([[1.0, 2.0], [3.0, -1.0], [0.0, 4.0]], (x, y))
    assert single == 4.0 * y
    assert one != other
    assert one.free_symbols == {x, y}
    assert sympy.diff(one**2 * z, y).subs({x: 1, y: 1, z: 1}) == 12.0
    assert sympy.expand(other.xreplace({x: z, y: 0})) == 3.0 * z


@pytest.mark.parametrize(
    ("M", "K", "what"),
    [
        (np.diag([1.0, 0.0]), np.eye(2), "M must give each freedom a mass to move"),
        (np.eye(2), (1 + 0.1j) * np.eye(2), "K must be real to move"),
    ],
)
def test_what_cannot_move_is_refused(M, K, what):
    with pytest.raises(ValueError, match=what):
        fl.simulate(fl.Structure(M, K), 1.0)


def test_the_energy_balance_of_impacts_closes():
    structure = slider_on_belt(FLAT.replace(impact=fl.RestitutionImpact(e=0.3), mu_k=2.5))
    audit = fl.energy_audit(fl.simulate(structure, 0.5, progress=False))
    assert audit.error < 1e-12
    works = {name: work[-1] for name, work in audit.works.items()}
    assert works["belt drive"] > 0.0 > works["friction"]
    assert works["impacts"] < -1e-3


def test_the_energy_balance_of_two_contacts_closes():
    run = fl.simulate(chain(), 5.0, x0=[0.5, -0.3, 0.4, 0.2, 0.3, 0.0, -0.2, 0.1], progress=False)
    audit = fl.energy_audit(run)
    assert audit.error < 1e-12
    assert audit.works["friction"][-1] < 0.0


def test_a_limit_cycle_of_many_freedoms_is_found_by_shooting():
    n, rng = 12, np.random.default_rng(0)
    K = np.diag([1.125, 0.375, *(2.0 + 1.3 * np.arange(2, n)) ** 2])
    K[0, 1] = K[1, 0] = 0.21650635
    tangent, normal = np.eye(n)[:2]
    tangent[2:], normal[2:] = 0.1 * rng.standard_normal((2, n - 2))
    contacts = fl.SlidingContacts(
        [tangent], [normal], fl.LinearContact(k2=4 / 3), fl.Coulomb(mu_k=1.0, mu_s=1.1), v=1.0
    )
    damping = fl.RayleighDamping(alpha=0.1, beta=2e-4)
    structure = fl.Structure(np.eye(n), K, damping, contacts=contacts, load=5.0 * normal)
    settled = fl.steady_state(structure, x0="near", transient=600.0, window=60.0, progress=False)
    orbit = fl.periodic_orbit(structure, settled)
    assert orbit.stable
    again = fl.simulate(structure, orbit.period, x0=orbit.state, progress=False)
    np.testing.assert_allclose(again.final_state, orbit.state, atol=1e-9)
    # the monodromy matrix by differences, of a start in slip
    start = again.states[np.argmax(again.mode == "slip+")]
    flow = np.array(
        [
            fl.simulate(structure, orbit.period, x0=start + e, progress=False).final_state
            - fl.simulate(structure, orbit.period, x0=start - e, progress=False).final_state
            for e in 1e-6 * np.eye(2 * n)
        ]
    )
    sizes = np.sort(np.abs(np.linalg.eigvals(flow.T / 2e-6)))[::-1]
    np.testing.assert_allclose(sizes[:4], np.sort(np.abs(orbit.multipliers))[::-1][:4], atol=1e-4)
