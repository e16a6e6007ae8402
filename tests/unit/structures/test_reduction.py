"""`fl.reduce`: the eigenvalues of a reduced structure against those of the large one."""

import pickle
import tracemalloc
from functools import partial

import numpy as np
import pytest
from scipy import linalg, sparse
from scipy.optimize import linear_sum_assignment

import frictionlab as fl
from frictionlab.structures import bases, eigenvalue_bounds
from frictionlab.structures.quadratic_pencil import QuadraticPencil, real_modes
from frictionlab.structures.reduction import contact_responses
from tests.helpers.finite_elements import beam, unsymmetric_chain
from tests.helpers.laws import Circle
from tests.unit.structures.test_sliding_contacts import beam_under_pads


def errors(small, large):
    """Shares by which the eigenvalues of a reduced structure miss those of the large one."""
    found, exact = fl.eigenvalues(small).values, fl.eigenvalues(large).values
    return np.abs(exact[:, None] - found).min(axis=1) / np.abs(exact)


def chain(n=80, window=(0.0, 0.6)):
    M, C, K, G, N = unsymmetric_chain(n, coupling=1.0, damping=0.02)
    return fl.Structure(M, K, C, gyroscopic=G, circulatory=[("mu", N)], parameters={"mu": 0.3}, window=window)


@pytest.mark.slow  # estimates are compared with errors at once
def test_modes_over_a_range():
    large = chain()
    small = fl.reduce(large, {"mu": (0.0, 0.5)}, tol=1e-7)
    assert small.size < 40
    assert small.error < 1e-7
    for mu in (0.05, 0.31, 0.44):  # none is a sample
        there = small.replace(mu=mu)
        missed = errors(there, large.replace(mu=mu))[:-4]  # but those next to the window's end
        assert missed.max() < 1e-7
    rougher = fl.reduce(large, {"mu": (0.0, 0.5)}, tol=1e-2)
    assert rougher.size < small.size
    assert fl.reduce(large).size <= rougher.size
    assert repr(pickle.loads(pickle.dumps(small))) == repr(small)


def test_a_hysteretic_structure_is_reduced():
    M, C, K, _, N = unsymmetric_chain(40, coupling=1.0, damping=0.02)
    parts = {"circulatory": [("mu", N)], "parameters": {"mu": 0.05}, "window": (0.0, 0.3)}
    small = fl.reduce(fl.Structure(M, (1.0 + 0.02j) * K, C, **parts)).replace(mu=0.1)
    M, C, K, N = (part.toarray() for part in map(sparse.csc_array, (M, C, K, N)))
    rates = -np.linalg.solve(M, np.hstack([(1.0 + 0.02j) * K + 0.1 * N, C]))
    exact = np.linalg.eigvals(np.vstack([np.eye(40, 80, 40), rates]))
    values = fl.eigenvalues(small).values
    missed = np.abs(values[:, None] - exact).min(axis=1)
    assert (missed < 1e-6 * np.abs(values)).all()
    assert np.allclose(small.error_estimates(), missed, rtol=0.05)


def test_estimates_are_the_errors():
    """Of a basis that is too small, by a half, in the sum over all modes."""
    large = chain()
    small = fl.reduce(large, tol=1e-2).replace(mu=0.5)
    estimates = small.error_estimates()
    found, exact = fl.eigenvalues(small).values, fl.eigenvalues(large.replace(mu=0.5)).values
    distances = np.abs(found[:, None] - exact).min(axis=1)
    inside = np.abs(found.imag) < 0.9 * 2 * np.pi * 0.6
    assert 0.5 < estimates[inside].sum() / distances[inside].sum() < 2.0


@pytest.mark.slow  # of 30 such chains errors are up to 1.45 times the estimates, and 1.16 times the tolerance
@pytest.mark.parametrize("seed", range(6))
def test_random_chains_err_as_estimated_between_the_samples(seed):
    rng = np.random.default_rng(seed)
    n, k, N = 90, rng.uniform(5e3, 2e4, 91), np.zeros((90, 90))
    m = rng.uniform(5e-3, 2e-2, n)
    K = np.diag(k[:-1] + k[1:]) - np.diag(k[1:-1], 1) - np.diag(k[1:-1], -1)
    N[tuple(rng.integers(n, size=(2, 6)))] = rng.uniform(-2e3, 2e3, 6)
    edge = 1.02 * np.sqrt(np.linalg.eigvalsh(K / np.sqrt(np.outer(m, m)))[14]) / (2 * np.pi)
    parts = {"circulatory": [("mu", N)], "parameters": {"mu": 0.3}}
    large = fl.Structure(np.diag(m), K, fl.RayleighDamping(alpha=1.0, beta=1e-7), window=(0.0, edge), **parts)
    tol = 10 ** rng.uniform(-7, -2)
    small = fl.reduce(large, {"mu": (0.0, 1.0)}, tol=tol)
    for mu in rng.uniform(0.0, 1.0, 4):
        there = small.replace(mu=mu)
        found, exact = (fl.eigenvalues(one).values for one in (there, large.replace(mu=mu, window=None)))
        missed = np.abs(found[:, None] - exact).min(axis=1)
        assert (missed <= 2.0 * there.error_estimates() + 1e-12 * np.abs(found)).all()
        assert (missed <= there.error_bounds()).all()
        weak = (np.abs(found.real) < 0.05 * np.abs(found)) & (np.abs(found.imag) < 0.98 * 2 * np.pi * edge)
        assert (missed[weak] <= 1.5 * tol * np.abs(found[weak])).all()


@pytest.mark.parametrize("hysteretic", [False, True])
def test_bounds_hold_for_doublets(hysteretic):
    """Of two chains that are nearly alike, coupled by friction and rotation, against LAPACK."""
    shares = []
    for seed in range(4):
        rng = np.random.default_rng(seed)
        n, split = 40, 10.0 ** rng.uniform(-12, -1)
        k, m = rng.uniform(5e3, 2e4, n + 1), np.tile(rng.uniform(5e-3, 2e-2, n), 2)
        one = np.diag(k[:-1] + k[1:]) - np.diag(k[1:-1], 1) - np.diag(k[1:-1], -1)
        K, skew = np.kron(np.diag([1.0, 1.0 + split]), one), np.zeros((2 * n, 2 * n))
        skew[7, n + 7], skew[n + 7, 7] = 1.0, -1.0
        N, G = 10.0 ** rng.uniform(0, 4) * skew, 10.0 ** rng.uniform(-4, 0) * skew
        edge = 1.02 * np.sqrt(np.linalg.eigvalsh(K / np.sqrt(np.outer(m, m)))[16]) / (2 * np.pi)
        C, K = (0.0 * K, (1.0 + 0.02j) * K) if hysteretic else (np.diag(m) + 1e-7 * K, K)
        parts = {"gyroscopic": G, "circulatory": [("mu", N)], "parameters": {"mu": 0.3}}
        large = fl.Structure(np.diag(m), K, C, window=(0.0, edge), **parts)
        small = fl.reduce(large, {"mu": (0.0, 1.0)}, tol=10.0 ** rng.uniform(-9, -2))
        for mu in (0.21, 0.77):  # none is a sample
            there = small.replace(mu=mu)
            values, bounds = fl.eigenvalues(there).values, there.error_bounds()
            rates = -np.hstack([K + mu * N, C + G]) / m[:, None]
            exact = np.linalg.eigvals(np.vstack([np.eye(2 * n, 4 * n, 2 * n), rates]))
            distances = np.abs(values[:, None] - exact)
            rows, columns = linear_sum_assignment(distances)  # as many exact ones as there are here
            assert (distances[rows, columns] <= bounds + 1e-12 * np.abs(values)).all()
            shares.extend(distances.min(axis=1) / bounds)
    assert len(shares) >= 90 * (2 - hysteretic)
    assert np.median(shares) > 0.9


def test_bounds_of_a_uniform_chain():
    """Its eigenvalues are 2i sin(k pi / (2 n + 2)); the bounds hold to rounding."""
    springs = 2 * np.eye(90) - np.eye(90, k=1) - np.eye(90, k=-1)
    small = fl.reduce(fl.Structure(np.eye(90), springs, window=(0, 0.05)))
    values, bounds = fl.eigenvalues(small).values, small.error_bounds()
    exact = 2j * np.sin(np.arange(1, len(values) // 2 + 1) * np.pi / 182)
    assert (np.abs(values[values.imag > 0] - exact) <= bounds[values.imag > 0]).all()
    assert bounds.max() < 1e-12
    assert np.array_equal(small.error_bounds([3]), bounds[3:4])
    with pytest.raises(IndexError, match="modes must be places of the"):
        small.error_bounds([len(values)])


@pytest.mark.parametrize("share", [0.0, 0.01])
def test_bounds_of_a_free_chain(share):
    """With C = share K they are the roots of s^2 + share k s + k, where sqrt(k) = 2 sin(i pi / 2n)."""
    n = 60
    springs = 2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    springs[0, 0] = springs[-1, -1] = 1.0
    small = fl.reduce(fl.Structure(np.eye(n), springs, share * springs, window=(0, 0.1)))
    values, bounds = fl.eigenvalues(small).values, small.error_bounds()
    k = (2 * np.sin(np.arange(n) * np.pi / (2 * n))) ** 2
    exact = -share * k / 2 + 1j * np.sqrt(k - (share * k / 2) ** 2)
    exact = np.concatenate([exact, exact.conj()])  # 0 twice, of the translation
    distances = np.abs(values[:, None] - exact)
    rows, columns = linear_sum_assignment(distances)
    assert (distances[rows, columns] <= bounds).all()
    assert bounds.max() < 1e-12


def test_a_basis_that_is_too_small_has_no_bounds():
    small = chain().projected(np.eye(80)[:, :12])
    assert np.isinf(small.error_bounds()).any()


def test_a_window_without_eigenvalues_has_no_errors():
    springs = 2 * np.eye(90) - np.eye(90, k=1) - np.eye(90, k=-1)
    small = fl.reduce(fl.Structure(np.eye(90), springs, window=(0, 0.05))).replace(window=(0.06, 0.07))
    assert small.error_bounds().shape == small.error_bounds([]).shape == small.error_estimates().shape == (0,)
    with pytest.raises(IndexError, match="modes must be places of the 0"):
        small.error_bounds([0])
    with pytest.raises(ValueError, match=r"got none from 0 to 0\.001 Hz"):
        fl.reduce(small.full.replace(window=(0, 0.001)))


@pytest.mark.parametrize("free", [False, True])
def test_vibrations_that_are_all_strongly_damped_are_kept(free):
    """With C = 0.02 M their eigenvalues are -0.01 +- i sqrt(w^2 - 1e-4)."""
    springs = 2 * np.eye(60) - np.eye(60, k=1) - np.eye(60, k=-1)
    if free:
        springs[0, 0] = springs[-1, -1] = 1.0
    large = fl.Structure(np.eye(60), springs, 0.02 * np.eye(60), window=(0, 0.15 / (2 * np.pi)))
    found = fl.eigenvalues(fl.reduce(large, tol=1e-4)).values
    w = 2.0 * np.sin(np.arange(1, 3) * np.pi / (120 if free else 122))
    exact = -0.01 + 1j * np.sqrt(w**2 - 1e-4)
    assert np.allclose(found[found.imag > 0.0], exact, rtol=1e-4)


@pytest.mark.parametrize("later", [None, np.linalg.LinAlgError("Singular matrix")])
def test_a_bound_stays_where_later_orders_have_none(monkeypatch, later):
    """The value of an oscillator is known to 1e-3, and to first order within 0.1."""
    shift = 1.001j + 1.001e-3
    orders = iter([(np.array([1j - shift]), 0.1)])

    def near_shift(terms, *_):
        if later is not None and len(terms) > 2:
            raise later
        return next(orders, None)

    monkeypatch.setattr(eigenvalue_bounds, "_near_shift", near_shift)
    assert bounds_of(1.0, 0.0, 1.0, [1.001j], [[1.0]]) == pytest.approx([0.101])


def bounds_of(M, C, K, values, vectors):
    """Bounds of values and vectors that are nearly those of M s^2 + C s + K."""
    pencil = QuadraticPencil(*(sparse.csc_array(np.atleast_2d(part)) for part in (M, C, K)))
    values, vectors = np.array(values, complex), np.array(vectors, complex)
    return eigenvalue_bounds.eigenvalue_bounds(pencil, values, vectors, np.arange(len(values)))


@pytest.mark.parametrize("n", [2, 30])
@pytest.mark.parametrize("beside", [0.0, 1e-12, 1e-8, -1e-8])
def test_modes_that_coalesce_have_bounds(n, beside):
    """Of s^4 + 3 s^2 + 2 + mu^2 = 0, where the modes of Hoffmann et al. meet at mu = 1/2."""
    K, mu = np.diag(np.r_[2.0, 1.0, np.linspace(4.0, 40.0, n - 2)]), 0.5 + beside
    K[0, 1], K[1, 0] = mu, -mu
    turn = np.linalg.qr(np.random.default_rng(0).standard_normal((n, n)))[0]
    springs = np.diag(K.diagonal())
    found = fl.eigenvalues(fl.Structure(np.eye(n), springs, circulatory=K - springs))
    own = np.flatnonzero(np.abs(found.values - 1j * np.sqrt(1.5)) < 0.1)
    bounds = bounds_of(np.eye(n), np.zeros((n, n)), turn @ K @ turn.T, found.values, turn @ found.shapes)[own]
    exact = 1j * np.sqrt(1.5 + np.array([1.0, -1.0]) * np.sqrt(0.25 - mu**2 + 0j))
    assert len(own) == 2
    assert (np.abs(found.values[own, None] - exact).min(axis=1) <= bounds).all()
    assert bounds.max() < 1e-6


def test_a_value_at_zero_has_a_bound():
    """Two free masses in a viscous fluid, of whose common motion, with s = 0 and -1, the shape is rough."""
    bounds = bounds_of(np.eye(2), np.eye(2), [[1, -1], [-1, 1]], [0.0, -1.0], [[1.0, 1.0], [1.001, 1.001]])
    assert (bounds < 1e-12).all()


def test_a_shift_at_which_the_slope_is_zero_has_no_bound():
    """Q'(s) = 2 s + 2 is zero at s = -1, where the shift is exactly, and the border with it."""
    value = -1.0 / (1.0 - eigenvalue_bounds.ASIDE)
    assert value + eigenvalue_bounds.ASIDE * abs(value) == -1.0
    assert np.isinf(bounds_of(1.0, 2.0, 5.0, [value], [[1.0]])).all()


@pytest.mark.parametrize(("apart", "count"), [(20, 298), (12, 300)])
def test_responses_of_many_contacts_are_held_few_times(apart, count):
    """With all the work on them they took ten times their own memory; of 498 the softest 300 are taken."""
    n, places = 3000, np.arange(10, 2990, apart)
    springs = sparse.diags_array([-np.ones(n - 1), 2.1 * np.ones(n), -np.ones(n - 1)], offsets=[-1, 0, 1])
    rows = [fl.relative_rows([(i + j, -1) for i in places], n) for j in (0, 1)]
    pads = fl.SlidingContacts(*rows, fl.LinearContact(k2=1.0), penetration=1.0)
    chain = fl.Structure(sparse.eye_array(n), springs, contacts=pads, load=np.ones(n), window=(0.0, 0.1))
    assert len(fl.equilibrium(chain).normal_forces) == len(places)
    tracemalloc.start()
    responses = contact_responses(chain)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert responses.shape == (n, count)
    assert peak < 5 * responses.nbytes


@pytest.mark.slow
def test_static_displacements_under_contacts():
    """Responses to the contact forces make the equilibrium right at other loads too."""
    large = beam_under_pads(30)
    small = fl.reduce(large, {"F": (1.0, 3.0)})
    assert small.size < 60 < large.size
    for F in (1.0, 1.7, 3.0):
        q = small.basis @ fl.equilibrium(small.replace(F=F)).q
        assert np.allclose(q, fl.equilibrium(large.replace(F=F)).q, rtol=1e-7, atol=1e-9)


BASES = (fl.ComplexModes(), fl.RealModes(), fl.CraigBampton(), fl.CraigBampton(interface=[3, 40, 41]))


@pytest.mark.parametrize("contacts", [0, 1, 4])
@pytest.mark.parametrize("basis", BASES, ids=repr)
def test_each_basis_has_the_modes_of_a_random_structure(basis, contacts):
    """Linear springs with Coulomb friction, pressed by their own length, against LAPACK and own matrices."""
    rng = np.random.default_rng(contacts)
    n, k, m = 60, rng.uniform(5e3, 2e4, 61), rng.uniform(5e-3, 2e-2, 60)
    K, N = np.diag(k[:-1] + k[1:]) - np.diag(k[1:-1], 1) - np.diag(k[1:-1], -1), np.zeros((n, n))
    normal, tangential = sparse.random(contacts, n, 0.05, rng=rng).toarray(), np.zeros((contacts, n))
    normal[:, :contacts], tangential[:, 20 : 20 + contacts] = np.eye(contacts), -np.eye(contacts)
    added = 300.0 * (normal - 0.3 * tangential).T @ normal
    edge = 1.02 * np.sqrt(np.linalg.eigvalsh(K / np.sqrt(np.outer(m, m)))[9]) / (2 * np.pi)
    parts = {"window": (0.0, edge), "C": sparse.coo_array(np.diag(m))}
    if contacts:
        laws = fl.LinearContact(k2=300.0), fl.Coulomb(mu_k=0.3, mu_s=0.5)
        bounce = fl.RestitutionImpact(e=0.5)  # has no part in it
        pads = fl.SlidingContacts(sparse.csc_array(tangential), normal, *laws, impact=bounce, penetration=1.0)
        parts |= {"contacts": pads}
    else:
        N[5, 9] = added[5, 9] = 2e3
        parts |= {"circulatory": sparse.lil_array(N)}
    large = fl.Structure(sparse.dia_array(np.diag(m)), sparse.csr_array(K), **parts)
    assert not contacts or not fl.equilibrium(large).open.any()
    small = fl.reduce(large, {"mu_k": (0.1, 0.3)} if contacts else None, tol=1e-4, basis=basis)
    rates = -np.hstack([K + added, np.diag(m)]) / m[:, None]
    exact = np.linalg.eigvals(np.vstack([np.eye(n, 2 * n, n), rates]))
    values = fl.eigenvalues(small).values
    missed = np.abs(values[:, None] - exact).min(axis=1)
    inside = np.abs(values.imag) < 0.98 * 2 * np.pi * edge
    assert inside.sum() >= 16
    assert (missed <= 1e-4 * np.abs(values))[inside].all()
    assert (missed <= small.error_bounds() + 1e-11 * np.abs(values)).all()
    assert small.size < n
    assert pickle.loads(pickle.dumps(basis)) == basis


def test_real_modes_of_a_free_pair_of_chains_are_doublets():
    """w = 2 sin(k pi / 2n) of each, the rigid motion at 0 included: none of two equal ones is missing."""
    one = 2 * np.eye(50) - np.eye(50, k=1) - np.eye(50, k=-1)
    one[0, 0] = one[-1, -1] = 1.0
    K, M = np.kron(np.eye(2), one), np.eye(100)
    solve = partial(np.linalg.solve, K + 0.01 * M)
    w, shapes = real_modes(K.__matmul__, M.__matmul__, solve, 100, 0.7, 0.1)
    assert np.allclose(w, np.repeat(2 * np.sin(np.arange(12) * np.pi / 100), 2), atol=1e-7)
    assert np.allclose(shapes.T @ K @ shapes, np.diag(w**2), atol=1e-12)


def test_an_interface_may_be_all_freedoms():
    """Then its modes are those of the structure."""
    springs = 2 * np.eye(60) - np.eye(60, k=1) - np.eye(60, k=-1)
    large = fl.Structure(np.eye(60), springs, window=(0, 0.05))
    small = fl.reduce(large, basis=fl.CraigBampton(interface=range(60)))
    assert small.size == fl.reduce(large, basis=fl.RealModes()).size < 10
    assert np.allclose(fl.eigenvalues(small).values, fl.eigenvalues(large).values)


@pytest.mark.parametrize(
    "basis", [fl.CraigBampton(interface=[5]), fl.RealModes(), fl.ComplexModes()], ids=repr
)
def test_a_freedom_without_mass_moves_no_faster_on_a_basis(basis):
    """With the modes of all others held the basis is full."""

    def frequencies(one):
        return np.sort(fl.eigenvalues(one).values.imag)

    springs = 2 * np.eye(12) - np.eye(12, k=1) - np.eye(12, k=-1)
    large = fl.Structure(np.diag(1.0 * (np.arange(12) != 5)), springs, window=(0, 0.3))
    small = fl.reduce(large, basis=basis)
    assert small.error < 1e-12
    assert np.allclose(frequencies(small), frequencies(large), atol=1e-12)
    assert np.abs(fl.eigenvalues(small).values.real).max() < 1e-12
    springs[0, 0] = springs[-1, -1] = 1.0
    free = large.replace(K=springs)
    assert np.allclose(frequencies(fl.reduce(free, basis=basis)), frequencies(free), atol=1e-12)


@pytest.mark.parametrize("elements", [20, 60])  # K is singular, or nearly by rounding
@pytest.mark.parametrize("interface", [[0, 1], [0, -2], [14]])
def test_interfaces_of_a_free_beam(interface, elements):
    """Held by an end, by two deflections, and not by one, about which it turns: the textbook's algebra."""
    M, K = (one.toarray() for one in beam(elements, stiffness=3.7, held=[]))
    held = np.arange(len(M))[interface]
    exact = linalg.eigh(K, M)[0][2:7]
    large = fl.Structure(M, K, window=(0.0, 1.05 * np.sqrt(exact[-1]) / (2 * np.pi)))
    small = fl.reduce(large, tol=1e-4, basis=fl.CraigBampton(interface=held))
    free = np.delete(np.arange(len(M)), held)
    inner = K[np.ix_(free, free)]
    basis = np.zeros((len(M), small.size))
    basis[held, : len(held)] = np.eye(len(held))
    basis[free, : len(held)] = -np.linalg.pinv(inner, rcond=1e-12) @ K[np.ix_(free, held)]
    basis[free, len(held) :] = linalg.eigh(inner, M[np.ix_(free, free)])[1][:, : small.size - len(held)]
    textbook = linalg.eigh(basis.T @ K @ basis, basis.T @ M @ basis)[0]
    values = fl.eigenvalues(small).values
    squares = np.sort(values[values.imag > 1.0].imag ** 2)
    assert small.size < 30
    assert np.allclose(squares, exact, rtol=2e-4)
    assert np.allclose(squares, textbook[2:7], rtol=1e-7)
    assert (np.abs(values) < 1e-3).sum() == 4  # of two rigid motions


def test_a_tolerance_that_a_basis_does_not_reach_is_told(monkeypatch):
    monkeypatch.setattr(bases, "MOST_FREEDOMS", 40)
    with pytest.warns(RuntimeWarning, match=r"more than tol = 1\.0e-10: take fl.ComplexModes") as told:
        small = fl.reduce(chain(), tol=1e-10, basis=fl.RealModes())
    assert told[0].filename == __file__
    assert small.error > 1e-10
    assert 40 <= small.size < 60


def test_modes_end_where_freedoms_have_no_mass():
    """Of 60 freedoms 40 have some, in directions that are no freedoms; dampers move the others."""
    rng = np.random.default_rng(0)
    turn = np.linalg.qr(rng.standard_normal((60, 60)))[0]
    M, K = turn[:, :40] @ turn[:, :40].T, 2 * np.eye(60) - np.eye(60, k=1) - np.eye(60, k=-1)
    large = fl.Structure(0.5 * (M + M.T), K, np.diag(rng.uniform(0.0, 0.1, 60)), window=(0.0, 0.02))
    with pytest.warns(RuntimeWarning, match="more than tol"):
        small = fl.reduce(large, tol=1e-10, basis=fl.RealModes())
    assert small.size <= 40
    assert 1e-10 < small.error < 0.1


@pytest.mark.parametrize(
    ("interface", "message"),
    [
        ([], "different freedoms"),
        ([1, 1], "different freedoms"),
        ([-1], "at least 0"),
        ([80], "0 to 79, got 80"),
    ],
)
def test_interfaces_that_are_none(interface, message):
    with pytest.raises(ValueError, match=message):
        fl.reduce(chain(), basis=fl.CraigBampton(interface))


def test_refused():
    large = chain()
    with pytest.raises(ValueError, match="must have contacts or a circulatory matrix to have an interface"):
        fl.reduce(large.replace(circulatory=None, parameters=None), basis=fl.CraigBampton())
    with pytest.raises(TypeError, match="basis must be one of displacements, got 'real'"):
        fl.reduce(large, basis="real")
    with pytest.raises(ValueError, match="must have a window of frequencies to be reduced"):
        fl.reduce(large.replace(window=None))
    with pytest.raises(TypeError, match="has no parameter 'r'"):
        fl.reduce(large, {"r": (0.0, 1.0)})
    with pytest.raises(ValueError, match="only parameters and window of a reduced structure"):
        fl.reduce(large).replace(K=np.eye(3))


@pytest.mark.parametrize("basis", [fl.ComplexModes(), fl.RealModes()], ids=lambda b: type(b).__name__)
def test_a_range_is_reduced_where_it_has_an_equilibrium(basis):
    """The states of the law settle below 1 m/s alone."""
    n = 40
    K = 100.0 * (2.0 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1))
    contacts = fl.SlidingContacts(np.eye(1, n, 0), N=5.0, friction=Circle(), v=0.5)
    structure = fl.Structure(np.eye(n), K, 1e-4 * K, contacts=contacts, window=(0.0, 1.2))
    small = fl.reduce(structure, {"v": (0.1, 1.5)}, tol=1e-6, basis=basis)
    for v in (0.15, 0.6, 0.9):
        reduced, every = (one.replace(v=v).find_eigenvalues().values for one in (small, structure))
        assert np.abs(reduced[:, None] - every).min(axis=1).max() < 1e-5 * np.abs(every).max()
        assert len(reduced) == len(every)
