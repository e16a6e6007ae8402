"""Structures with contacts: models of the library, closed forms, and numpy's dense matrices."""

import pickle
from typing import Any

import numpy as np
import pytest
from scipy import linalg

import frictionlab as fl
from frictionlab.structures.sliding_equilibrium import Statics, newton_of_many
from tests.helpers.finite_elements import beam
from tests.helpers.flat_slider import slider_on_belt


def is_same(found, expected):
    """Whether numbers agree to 1e-12."""
    return np.allclose(found, expected, rtol=1e-12, atol=0.0)


SLIDERS = [
    fl.SliderOnBelt(mu_k=1.4, geometry=fl.FixedLoad()),
    fl.SliderOnBelt(geometry=fl.FixedLoad(), friction=fl.Stribeck(mu_k=0.5, mu_s=1.2), v=0.3),
    fl.SliderOnBelt(geometry=fl.FixedLoad(), contact=fl.HertzContact(), v=-1.0),
    fl.SliderOnBelt(geometry=fl.FixedLoad(), friction=fl.PressureDependent(mu_k=0.5, mu_s=1.2), v=0.3),
]


@pytest.mark.parametrize("model", SLIDERS, ids=lambda one: f"{one.contact!r} {one.friction!r}")
def test_slider_on_belt_as_a_structure(model):
    structure = slider_on_belt(model)
    mine: Any = fl.equilibrium(structure)
    its = fl.equilibrium(model)
    assert is_same(mine.q, its.q)
    forces = [(one.penetration, one.normal_force, one.friction_force) for one in (mine, its)]
    assert is_same(*forces)
    assert mine.open.tolist() == [False]
    found, expected = fl.eigenvalues(structure).values, fl.eigenvalues(model).values
    assert np.allclose(found, expected, rtol=0.0, atol=1e-12 * np.abs(expected).max())


def test_hysteretic_damping_leaves_the_equilibrium():
    plain = slider_on_belt(SLIDERS[0])
    K = plain.K.at({}).toarray()
    damped = plain.replace(K=(1.0 + 0.05j) * K)
    assert is_same(fl.equilibrium(damped).q, fl.equilibrium(plain).q)
    M, C, tangent = (part.toarray() for part in plain.pencil.parts)
    rates = np.hstack([-np.linalg.solve(M, tangent + 0.05j * K), -np.linalg.solve(M, C)])
    expected = np.linalg.eigvals(np.vstack([np.eye(4, 8, 4), rates]))
    values = fl.eigenvalues(damped).values
    assert np.abs(values[:, None] - expected).min(axis=1).max() < 1e-12 * np.abs(expected).max()
    assert np.isfinite(fl.eigenvalues(damped).sensitivities("mu_k")).all()


def test_critical_values_of_slider_on_belt():
    model = SLIDERS[0]
    found, expected = (fl.critical_value(one, "mu_k", (0, 4)) for one in (slider_on_belt(model), model))
    assert found is not None
    assert is_same(found, expected)


def test_given_normal_forces():
    """MassOnBelt and TwoBlocks, whose normal forces do not depend on their motion."""
    law = fl.Stribeck(mu_k=0.3, mu_s=0.6)
    mass = fl.MassOnBelt(friction=law, v=0.3)
    contacts = fl.SlidingContacts([[1.0]], N=mass.N, friction=law, v=mass.v)
    one = fl.Structure([[mass.m]], [[mass.k]], [[mass.c]], contacts=contacts)
    blocks = fl.TwoBlocks(friction=law)
    contacts = fl.SlidingContacts(np.eye(2), N=1.0, friction=law, v=blocks.v, area=[blocks.N1, blocks.N2])
    K = [[blocks.k1 + blocks.k12, -blocks.k12], [-blocks.k12, blocks.k2 + blocks.k12]]
    two = fl.Structure(np.diag([blocks.m1, blocks.m2]), K, blocks.c * np.eye(2), contacts=contacts)
    for structure, model in ((one, mass), (two, blocks)):
        assert is_same(fl.equilibrium(structure).q, fl.equilibrium(model).q)
        found, expected = fl.eigenvalues(structure).values, fl.eigenvalues(model).values
        assert np.allclose(found, expected, rtol=0.0, atol=1e-12 * np.abs(expected).max())
        assert len(fl.eigenvalues(structure).growing) > 0


def mode_coupling():
    model = fl.ModeCoupling(c=0.0)
    k11, k12, k22 = model.stiffnesses
    contacts = fl.SlidingContacts([[1.0, 0.0]], [[0.0, 1.0]], fl.LinearContact(k2=model.k3), fl.Coulomb(0.5))
    structure = fl.Structure(
        model.m * np.eye(2), [[k11, k12], [k12, k22 - model.k3]], contacts=contacts, load=[0.0, model.F]
    )
    return structure, model


def test_critical_friction_in_closed_form():
    structure, model = mode_coupling()
    assert np.isclose(fl.critical_value(structure, "mu_k", (0, 2)) or 0.0, model.critical_friction, rtol=1e-9)
    again = pickle.loads(pickle.dumps(structure))
    assert (fl.eigenvalues(again).values == fl.eigenvalues(structure).values).all()


def random_structure(seed, n=12, k=5):
    rng = np.random.default_rng(seed)
    A, B = rng.standard_normal((2, n, n))
    given = {
        "K": A @ A.T + np.eye(n),
        "M": B @ B.T / n + np.eye(n),
        "G": rng.standard_normal((k, n)),
        "T": rng.standard_normal((k, n)),
        "load": 10.0 * rng.standard_normal(n),
        "area": rng.uniform(0.5, 2.0, k),
        "penetration": rng.uniform(-0.1, 0.1, k),
    }
    contacts = fl.SlidingContacts(
        given["T"],
        given["G"],
        fl.CubicContact(k2=30.0, k_nl=400.0),
        fl.Coulomb(mu_k=0.4, mu_s=5.0),
        penetration=given["penetration"],
        area=given["area"],
    )
    K = given["K"]
    return fl.Structure(given["M"], K, 0.01 * K, contacts=contacts, load=given["load"]), given


@pytest.mark.parametrize("seed", range(4))
def test_random_structures_against_dense_matrices(seed):
    """Some contacts are open; the static equations and the eigenvalues are written out with numpy."""
    structure, one = random_structure(seed)
    found: Any = fl.equilibrium(structure)
    G, T, K, n = one["G"], one["T"], one["K"], len(one["K"])
    depth = G @ found.q + one["penetration"]
    closed = depth > 0.0
    force = np.where(closed, one["area"] * (30.0 * depth + 400.0 * depth**3), 0.0)
    slope = np.where(closed, one["area"] * (30.0 + 1200.0 * depth**2), 0.0)
    assert (found.open == ~closed).all()
    assert 0 < closed.sum() < 5
    assert np.allclose(found.normal_forces, force, rtol=1e-12)
    left_over = K @ found.q - one["load"] + (G - 0.4 * T).T @ force
    assert np.abs(left_over).max() < 1e-12 * np.abs(one["load"]).max() * np.linalg.cond(K)
    tangent = K + (G - 0.4 * T).T @ (slope[:, None] * G)
    lower = np.hstack([-np.linalg.solve(one["M"], tangent), -np.linalg.solve(one["M"], 0.01 * K)])
    expected = np.linalg.eigvals(np.vstack([np.eye(n, 2 * n, n), lower]))
    values = fl.eigenvalues(structure).values
    assert np.abs(values[:, None] - expected).min(axis=1).max() < 1e-12 * np.abs(expected).max()


@pytest.mark.slow
def test_a_contact_that_opens_may_change_stability():
    structure, _ = random_structure(2)
    change = fl.stability_changes(structure, "mu_k", (0.76, 0.8))[0]
    assert change.kind == "border"
    before, after = (fl.equilibrium(structure.replace(mu_k=change.value + step)) for step in (-1e-6, 1e-6))
    assert isinstance(before, fl.SlidingEquilibrium)
    assert isinstance(after, fl.SlidingEquilibrium)
    assert (before.open != after.open).sum() == 1


def test_sensitivities_count_how_the_equilibrium_moves():
    structure = slider_on_belt(SLIDERS[1])
    found = fl.eigenvalues(structure)
    for name, share in (("mu_k", 1e-5), ("k_nl", 1e-4), ("F", 1e-5), ("v", 1e-5)):
        step = share * structure.parameters[name]
        low, high = (
            fl.eigenvalues(structure.replace(**{name: structure.parameters[name] + d})).values
            for d in (-step, step)
        )
        slopes = (high - low) / (2 * step)
        assert np.allclose(found.sensitivities(name), slopes, rtol=1e-5, atol=1e-6 * np.abs(slopes).max())


def beam_under_pads(elements):
    """Two beams side by side, of which one bends along the belt; pads press on the middle of the other."""
    M, K = (one.toarray() for one in beam(elements, stiffness=20.0))
    n = len(M)
    zero = np.zeros((n, n))
    lowest = np.linalg.eigvals(np.linalg.solve(M, K)).real.min()
    cross = 0.3 * lowest * M
    pads = np.arange(elements // 2 - 2, elements // 2 + 3) * 2
    normal, tangential = np.zeros((len(pads), 2 * n)), np.zeros((len(pads), 2 * n))
    normal[range(len(pads)), pads - 1], tangential[range(len(pads)), n + pads - 1] = 1.0, 1.0
    load = np.zeros(2 * n)
    load[pads - 1] = 1.0
    contacts = fl.SlidingContacts(
        tangential, normal, fl.CubicContact(k2=40.0, k_nl=1e4), fl.Coulomb(0.1, 3.0)
    )
    return fl.Structure(
        np.block([[M, zero], [zero, M]]),
        np.block([[K, cross], [cross, 1.3 * K]]),
        fl.RayleighDamping(alpha=0.02),
        contacts=contacts,
        load=[("F", load)],
        parameters={"F": 2.0},
        window=(0.0, 20.0),
    )


@pytest.mark.slow
def test_many_freedoms_are_as_few(monkeypatch):
    """By GMRES, Arnoldi's method and reductions, and by full matrices."""
    structure = beam_under_pads(8)
    whole = fl.equilibrium(structure), fl.eigenvalues(structure)
    changes = fl.stability_changes(structure, "mu_k", (0.0, 2.5))
    assert len(changes) > 0
    for module in ("window_eigenvalues", "sliding_equilibrium"):
        monkeypatch.setattr(f"frictionlab.structures.{module}.MOST_DENSE", 10)
    monkeypatch.setattr("frictionlab.structures.mode_paths.MOST_SCANNED", 10)
    structure = beam_under_pads(8)
    assert np.allclose(fl.equilibrium(structure).q, whole[0].q, rtol=1e-11)
    assert np.allclose(fl.eigenvalues(structure).values, whole[1].values, rtol=1e-8)
    found = fl.stability_changes(structure, "mu_k", (0.0, 2.5))
    assert np.allclose([c.value for c in found], [c.value for c in changes], rtol=1e-8)


def test_pairs_of_freedoms():
    assert fl.relative_rows([(0, 2), (1, -1)], 3).toarray().tolist() == [[1, 0, -1], [0, 1, 0]]
    for pairs in ([(0, 0)], [(0, 5)], [0, 1], [(0.5, 1)], []):
        with pytest.raises(ValueError, match="pairs must be"):
            fl.relative_rows(pairs, 3)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"normal": None}, "normal must be rows of the freedoms, got None"),
        ({"tangential": None}, "tangential must be rows of the freedoms, got None"),
        ({"normal": [[0.0, 1.0], [1.0, 0.0]]}, "rows of the same contacts"),
        ({"normal": [[0.0, 0.0]]}, "rows that are not zero, got row 0"),
        ({"normal": [[0.0, np.nan]]}, "finite numbers, got nan"),
        ({"normal": [[0.0, 1.0]] * 2, "tangential": [[1.0, 0.0]] * 2}, "the same rows for 0 and 1"),
        ({"N": 3.0}, "N must be None where there are rows of normal"),
        ({"area": -1.0}, "area must be above 0"),
        ({"area": [1.0, 2.0]}, "area must be of 1 contacts"),
        ({"normal": [0.0, 1.0]}, "normal must be a matrix"),
    ],
)
def test_contacts_that_are_refused(changes, message):
    with pytest.raises(ValueError, match=message):
        fl.SlidingContacts(**{"tangential": [[1.0, 0.0]], "normal": [[0.0, 1.0]], **changes})


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"load": [0.0, -1.0]}, "a contact must be closed, and all 1 are open"),
        ({"load": None}, "a contact must be closed, and all 1 are open"),
        ({"K": np.diag([0.0, 1.0])}, "K and the contacts must hold all freedoms"),
        ({"load": [("F", [0.0, 1.0])]}, "names 'F', which is no parameter"),
        ({"parameters": {"mu_k": 0.2}}, "must not contradict SlidingContacts, got mu_k = 0.2"),
        (
            {"contacts": fl.SlidingContacts([[1.0, 0.0]], [[0.0, 1.0]], v=0.0)},
            "v must not be 0 for steady sliding",
        ),
    ],
)
def test_structures_with_contacts_that_are_refused(changes, message):
    contacts = fl.SlidingContacts([[1.0, 0.0]], [[0.0, 1.0]])
    with pytest.raises(ValueError, match=message):
        fl.eigenvalues(
            fl.Structure(**{"M": np.eye(2), "K": np.eye(2), "contacts": contacts, "load": [0, 1], **changes})
        )


def test_pads_with_laws_and_speeds_of_their_own():
    """Three pads on a chain: the eigenvalues are those of matrices made by hand."""
    stiffness, friction, speeds = (100.0, 200.0, 300.0), (0.3, 0.6, 0.9), (1.0, 2.0, -1.5)
    unit, springs = np.eye(6), 1e2 * (2 * np.eye(6) - np.eye(6, k=1) - np.eye(6, k=-1))
    pads = [
        fl.SlidingContacts(
            unit[[i]], unit[[i + 3]], fl.LinearContact(k2=k), fl.Coulomb(mu, 1.0), v, name=name
        )
        for i, (k, mu, v, name) in enumerate(zip(stiffness, friction, speeds, "abc"))
    ]
    structure = fl.Structure(unit, springs, contacts=pads, load=[0, 0, 0, 25.0, 35.0, 45.0])
    full = springs.copy()
    for i, (k, mu, v) in enumerate(zip(stiffness, friction, speeds)):
        full[i + 3, i + 3] += k
        full[i, i + 3] -= np.sign(v) * mu * k
    squares = -np.linalg.eigvals(full)
    values = fl.eigenvalues(structure).values
    assert np.abs(values[:, None] ** 2 - squares).min(axis=1).max() < 1e-9 * np.abs(squares).max()
    changed = structure.replace(mu_k_b=0.5, v_c=1.0)
    assert (changed.contacts[1].friction.mu_k, changed.contacts[2].v) == (0.5, 1.0)
    again = fl.Structure.from_dict(changed.to_dict())
    assert np.allclose(fl.eigenvalues(again).values, fl.eigenvalues(changed).values, rtol=1e-14)


def test_a_moving_and_a_resting_counterpart():
    """A mass is drawn by a belt and rubs at a wall: x = X (1 - cos t), then it sticks to the wall."""
    belt = fl.SlidingContacts([[1.0]], N=1.0, friction=fl.Coulomb(1.0, 1.0), v=1.0, name="belt")
    wall = fl.SlidingContacts([[1.0]], N=0.5, friction=fl.Coulomb(0.8, 0.9), v=0.0, name="wall")
    run = fl.simulate(fl.Structure([[1.0]], [[1.0]], contacts=[belt, wall]), 10.0, x0=[0.0, 0.0])
    assert run.events.t == pytest.approx([np.pi], rel=1e-12)
    assert run.mode[-1] == "slip+ | stick"
    t = np.linspace(0.0, 3.0, 7)
    assert np.allclose(run(t)[:, 0], 0.6 * (1.0 - np.cos(t)), rtol=0, atol=1e-13)
    assert np.allclose(run.final_state, [1.2, 0.0], rtol=0, atol=1e-13)
    assert fl.energy_audit(run).error < 1e-12


def test_contacts_at_rest_stick_in_the_linear_structure():
    """A disc slides on the first freedom; of two guides at rest one is open: matrices and statics by hand."""
    rng, n, F = np.random.default_rng(5), 6, np.array([1.0, 0.5, 0.0, 0.3, 1.0, -0.5])
    K = (basis := np.linalg.qr(rng.standard_normal((n, n)))[0]) @ np.diag(np.linspace(2.0, 9.0, n)) @ basis.T
    g, t = np.eye(n)[[0, 4, 5]], rng.standard_normal((3, n))
    disc = fl.SlidingContacts(t[:1], g[:1], fl.LinearContact(3.0), fl.Coulomb(0.4, 0.5), name="disc")
    law = fl.Coulomb(0.1, 9.0)
    bounce = fl.RestitutionImpact(e=0.5)  # has no part in it
    guides = fl.SlidingContacts(t[1:], g[1:], fl.LinearContact(5.0), law, v=0.0, impact=bounce, name="guide")
    given = {"contacts": [disc, guides], "load": [("F", F)], "parameters": {"F": 1.0}}
    structure = fl.Structure(np.eye(n), (K + K.T) / 2, **given)
    held = structure.in_stick()
    Z = linalg.null_space(t[1:2])
    stiffness = K + 3.0 * (np.outer(g[0], g[0]) - 0.4 * np.outer(t[0], g[0])) + 5.0 * np.outer(g[1], g[1])
    q = Z @ np.linalg.solve(Z.T @ stiffness @ Z, Z.T @ F)
    assert q[4] > 0.0 > q[5]
    assert np.allclose(held.basis @ fl.equilibrium(held).q, q, rtol=1e-12)
    exact = linalg.eigvals(Z.T @ stiffness @ Z)  # -s^2
    found = fl.eigenvalues(held.replace(F=2.0)).values
    assert len(found) == 2 * n - 2
    assert np.abs(-(found[:, None] ** 2) - exact).min(axis=1).max() < 1e-11
    assert np.isnan(fl.root_locus(held, "v_disc", [0.0, 1.0]).values[0]).all()  # in stick all would rest
    needed = abs(t[1] @ (stiffness @ q - F)) / (t[1] @ t[1]) / (5.0 * q[4])  # of F_N
    structure.replace(mu_k_guide=0.0, mu_s_guide=1.001 * needed).in_stick()
    with pytest.raises(ValueError, match=r"hold by less than their static limits to stick, .* raise mu_s"):
        structure.replace(mu_k_guide=0.0, mu_s_guide=0.999 * needed).in_stick()
    with pytest.raises(ValueError, match="v_guide must not be 0"):
        held.error_bounds()


def test_groups_of_contacts():
    first = fl.SlidingContacts([[1.0, 0.0]], [[0.0, 1.0]])
    with pytest.raises(ValueError, match=r"one value, got mu_k = 0\.3 and 0\.1"):
        fl.Structure(
            np.eye(2),
            np.eye(2),
            contacts=[first, fl.SlidingContacts([[1.0, 1.0]], N=1.0, friction=fl.Coulomb(0.1))],
        )
    with pytest.raises(ValueError, match="got v = 1 and 2: name the contacts"):
        fl.Structure(np.eye(2), np.eye(2), contacts=[first, fl.SlidingContacts([[1.0, 1.0]], N=1.0, v=2.0)])
    with pytest.raises(ValueError, match="a column for each of 3 freedoms, got 2"):
        fl.Structure(np.eye(3), np.eye(3), contacts=first)
    with pytest.raises(TypeError, match="contacts must be SlidingContacts, got 3"):
        fl.Structure(np.eye(2), np.eye(2), contacts=[3])
    structure = fl.Structure(np.eye(2), np.eye(2), contacts=first, load=[0.0, 1.0])
    assert structure.replace(mu_k=0.2).contacts[0].friction == fl.Coulomb(mu_k=0.2)
    assert dict(structure.replace(contacts=None).parameters) == {}
    with pytest.raises(ValueError, match="mu_s must be at least mu_k"):
        structure.replace(mu_k=4.0)


def test_many_values_at_once_are_as_each(monkeypatch):
    """A load opens one contact, or both; then, and beside a counterpart at rest, there is no equilibrium."""
    contacts = fl.SlidingContacts(
        [[1.0, 0.0], [1.0, 0.3]],
        [[0.0, 1.0], [0.2, 1.0]],
        fl.CubicContact(k2=4 / 3, k_nl=0.5),
        fl.Stribeck(mu_k=0.3, mu_s=0.9, v_s=0.5),
        penetration=[0.0, -0.5],
    )
    load, springs = [("F", [0.0, 1.0])], [[1.125, 0.21650635], [0.21650635, 0.375]]
    structure = fl.Structure(np.eye(2), springs, contacts=contacts, load=load, parameters={"F": 2.0})
    points = {"F": np.array([2.0, 0.1, -1.0, 9.0, 2.0]), "v": np.array([1.0, 0.2, 1.0, -0.4, 0.0])}
    known, alone, solve = 0, [], Statics.solve
    with monkeypatch.context() as patch:
        patch.setattr(Statics, "solve", lambda self, *at: alone.append(self.values["F"]) or solve(self, *at))
        stacks = structure.stacks(points)
    assert 0.1 not in alone  # Newton's method finds it beside a counterpart at rest
    for F, v, *parts in zip(*points.values(), *stacks, strict=True):
        try:
            expected = structure.at_values({"F": F, "v": v}).pencil.parts
        except ValueError:
            assert np.isnan(parts[1:]).all()
            continue
        known += 1
        for part, each in zip(parts, expected, strict=True):
            np.testing.assert_allclose(part, each.toarray(), rtol=1e-12, atol=1e-14)
    assert known == 3


def test_a_singular_tangent_ends_the_search_at_its_point_alone():
    """The first structure has no stiffness along the belt, where no friction is."""
    contacts = fl.SlidingContacts([[1.0, 0.0]], [[0.0, 1.0]], fl.LinearContact(k2=1.0), friction=None)
    K = np.array([np.diag([k, 3.0]) for k in (0.0, 2.0, 1.0)])
    loads, start = np.tile([1.0, 4.0], (3, 1)), np.array([0.0, 0.5])
    q, found = newton_of_many(K, loads, (contacts.full(),), {"k2": np.ones(3)}, start)
    assert found.tolist() == [False, True, True]
    np.testing.assert_allclose(q[1:], [[0.5, 1.0], [1.0, 1.0]], rtol=1e-15)
