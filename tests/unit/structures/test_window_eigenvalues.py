"""Eigenvalues of structures: closed forms, models, and scipy's dense solution of the same problem."""

import numpy as np
import pytest
from scipy import linalg, sparse

import frictionlab as fl
from frictionlab.structures.quadratic_pencil import QuadraticPencil, Spectrum, factorised
from tests.helpers.cases import slow_but
from tests.helpers.finite_elements import beam, beam_frequencies, unsymmetric_chain

pytestmark = pytest.mark.blas


def dense_eigenvalues(M, C, K):
    """Of the first companion form, by scipy's QZ: it shares no code with the package."""
    n = M.shape[0]
    unit, zero = np.eye(n), np.zeros((n, n))
    M, C, K = (one.toarray() for one in (M, C, K))
    return linalg.eigvals(np.block([[zero, unit], [-K, -C]]), linalg.block_diag(unit, M))


def in_window(values, window):
    return values[
        (np.abs(values.imag) <= 2 * np.pi * window[1]) & (np.abs(values.imag) >= 2 * np.pi * window[0])
    ]


def distance(values, others):
    return np.abs(values[:, None] - others).min(axis=1).max()


@pytest.mark.parametrize("elements", [8, 16])
def test_beam_converges_with_the_order_of_its_elements(elements):
    """Frequencies of cubic elements err by (wave number x length)^4/720 (Strang and Fix 1973)."""
    found = fl.eigenvalues(fl.Structure(*beam(elements))).frequencies[::2][:3]
    errors = found / beam_frequencies(3) - 1.0
    waves = np.arange(1, 4) * np.pi / elements
    assert np.allclose(errors, waves**4 / 1440, rtol=0.05)


def test_large_beam_has_its_exact_frequencies():
    """By the sparse solver: 420 freedoms, 12 modes in the window."""
    exact = beam_frequencies(13)
    structure = fl.Structure(*beam(210), window=(0.0, float(0.5 * (exact[11] + exact[12]))))
    found = fl.eigenvalues(structure)
    assert np.allclose(found.frequencies[::2], exact[:12], rtol=1e-6)
    assert found.marginal
    assert (found.growth_rates == 0.0).all()
    assert found.backward_errors.max() < 1e-14


@pytest.mark.parametrize("window", slow_but([(0.0, 1.0)], [(0.0, 1.0), (0.6, 1.0)]))
def test_all_of_the_window_is_found_as_by_a_full_matrix(window, monkeypatch):
    monkeypatch.setattr("frictionlab.structures.window_eigenvalues.MOST_DENSE", 10)
    M, C, K, G, N = unsymmetric_chain(120)
    structure = fl.Structure(M, K, C, gyroscopic=G, circulatory=N, window=window)
    found = fl.eigenvalues(structure)
    expected = in_window(dense_eigenvalues(M, C + G, K + N), window)
    assert len(found.values) == len(expected) > 12
    assert distance(found.values, expected) < 1e-9 * np.abs(expected).max()
    assert distance(expected, found.values) < 1e-9 * np.abs(expected).max()
    assert found.residuals.max() < 1e-10
    assert found.backward_errors.max() < 1e-13
    assert found.error_estimates.max() < 1e-9
    assert len(found.growing) > 0


def test_a_window_beyond_all_eigenvalues(monkeypatch):
    monkeypatch.setattr("frictionlab.structures.window_eigenvalues.MOST_DENSE", 3)
    M, C, K, G, N = unsymmetric_chain(6)
    found = fl.eigenvalues(fl.Structure(M, K, C, gyroscopic=G, circulatory=N, window=(0.0, 100.0)))
    expected = dense_eigenvalues(M, C + G, K + N)
    assert len(found.values) == 12
    assert distance(expected, found.values) < 1e-9 * np.abs(expected).max()


def test_equal_eigenvalues_are_all_found():
    """Two equal beams side by side: each eigenvalue is there twice, of which a Krylov space sees one."""
    M, K = beam(110)
    exact = beam_frequencies(9)
    window = (0.0, float(0.5 * (exact[7] + exact[8])))
    twice = [sparse.block_diag([one, one], format="csc") for one in (M, K)]
    found = fl.eigenvalues(fl.Structure(*twice, window=window))
    assert np.allclose(found.frequencies[::2], np.repeat(exact[:8], 2), rtol=1e-5)
    products = found.structure.pencil.products_of_modes(
        Spectrum(found.values, found.left_vectors),
        Spectrum(found.values, found.vectors[: found.structure.size]),
    )
    assert np.allclose(np.diag(products), 1.0)


def test_rigid_bodies_and_freedoms_without_mass():
    """Two masses and a spring between them, in the middle of which is a point without mass."""
    k = 8.0
    K = k * np.array([[1.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]])
    structure = fl.Structure(np.diag([2.0, 0.0, 2.0]), K)
    assert structure.massless == (1,)
    found = fl.eigenvalues(structure)
    assert np.allclose(np.abs(found.values), [0, 0, 2.0, 2.0], atol=1e-6)  # k/2 and the half of 2 kg


def test_hysteretic_stiffness_has_the_loss_factor_of_its_modes(monkeypatch):
    monkeypatch.setattr("frictionlab.structures.window_eigenvalues.MOST_DENSE", 10)
    M, K = beam(100)
    structure = fl.Structure(M, K * (1 + 0.02j), window=(0.0, 50.0))
    found = fl.eigenvalues(structure)
    expected = 1j * 2 * np.pi * beam_frequencies(5) * np.sqrt(1 + 0.02j)
    assert np.allclose(found.values, expected, rtol=1e-6)


def test_a_window_around_an_eigenvalue(monkeypatch):
    """Its middle, from which the search begins, is the eigenvalue to the last bits, or nearly."""
    M, K = beam(40)
    exact = fl.eigenvalues(fl.Structure(M, K))
    monkeypatch.setattr("frictionlab.structures.window_eigenvalues.MOST_DENSE", 10)
    for share in (0.0, 1e-10):
        middle = exact.frequencies[exact.values.imag > 0][8] * (1 + share)
        near = fl.eigenvalues(fl.Structure(M, K, window=(0.7 * middle, 1.3 * middle)))
        inside = np.abs(exact.frequencies - middle) <= 0.3 * middle
        assert inside.sum() == len(near.values) >= 6
        assert np.allclose(np.sort_complex(near.values), np.sort_complex(exact.values[inside]), rtol=1e-8)
        assert near.residuals.max() < 1e-10


def test_sensitivities_are_slopes(monkeypatch):
    monkeypatch.setattr("frictionlab.structures.window_eigenvalues.MOST_DENSE", 10)
    M, C, K, _, N = unsymmetric_chain(120)
    structure = fl.Structure(
        M, K, [("c**2", C)], circulatory=[("mu/c", N)], parameters={"mu": 0.9, "c": 1.0}, window=(0.0, 0.4)
    )
    found = fl.eigenvalues(structure)
    for name in ("mu", "c"):
        low, high = (
            fl.eigenvalues(structure.replace(**{name: structure.parameters[name] + step})).values
            for step in (-1e-4, 1e-4)
        )
        slopes = found.sensitivities(name)
        nearest = [np.abs(other[:, None] - found.values).argmin(axis=0) for other in (low, high)]
        differences = (high[nearest[1]] - low[nearest[0]]) / 2e-4
        assert np.allclose(slopes, differences, rtol=1e-4, atol=1e-5 * np.abs(slopes).max())


def structure_of(model):
    """The structure of a model near steady sliding, from its state matrix; the masses are 1."""
    A = fl.linearize(model).A
    n = len(A) // 2
    K, C = -A[n:, :n], -A[n:, n:]
    parts = {
        "K": (K + K.T) / 2,
        "C": (C + C.T) / 2,
        "gyroscopic": (C - C.T) / 2,
        "circulatory": (K - K.T) / 2,
    }
    return fl.Structure(np.eye(n), **parts)


@pytest.mark.parametrize(
    "model",
    [
        fl.SliderOnBelt(mu_k=1.4),
        fl.SliderOnBelt(mu_k=2.0),
        fl.MassOnBelt(),
        fl.TwoBlocks(),
        fl.ModeCoupling(mu_k=0.6),
    ],
    ids=repr,
)
def test_models_as_structures(model):
    expected, found = fl.eigenvalues(model), fl.eigenvalues(structure_of(model))
    scale = np.abs(expected.values).max()
    assert np.allclose(found.values, expected.values, rtol=0.0, atol=1e-12 * scale)
    assert (found.stable, found.marginal) == (expected.stable, expected.marginal)
    assert np.allclose(found.participation, expected.participation, atol=1e-8)


def test_modes_are_compared_by_their_shapes():
    found = fl.eigenvalues(fl.Structure(*beam(8)))
    criterion = found.mac(found)
    assert np.allclose(np.diag(criterion), 1.0)
    assert criterion[0, 2] < 0.1  # another mode; entry 1 is the conjugate of the first


def test_what_is_shown():
    M, C, K, _, N = unsymmetric_chain(20, coupling=5.0)
    found = fl.eigenvalues(fl.Structure(M, K, C, circulatory=N))
    assert repr(found).startswith("WindowEigenvalues(20 modes, ")
    assert " growing: +" in repr(found)
    assert list(found.to_dataframe().columns)[-2:] == ["residual", "backward_error"]


def test_mass_without_full_rank():
    """M has rank 2 and no zero row: the third motion follows the others without inertia."""
    factor = np.array([[1.0, 0.0], [1.0, 1.0], [0.0, 2.0]])
    stiffness = np.diag([1.0, 2.0, 3.0])
    found = fl.eigenvalues(fl.Structure(factor @ factor.T, stiffness))
    # K x = w^2 F F^T x: with y = F^T x, y = w^2 F^T K^-1 F y
    exact = np.sqrt(1.0 / np.linalg.eigvalsh(factor.T @ np.linalg.inv(stiffness) @ factor))[::-1]
    assert np.allclose(found.values[found.values.imag > 0.0], 1j * exact, rtol=1e-13)
    assert (found.backward_errors < 1e-14).all()


def test_rigid_motions_beside_a_freedom_without_mass():
    found = fl.eigenvalues(fl.Structure(np.diag([1.0, 1.0, 1.0, 0.0]), np.diag([0.0, 0.0, 4.0, 1.0])))
    assert np.allclose(found.values.imag, [0, 0, 0, 0, -2, 2], rtol=1e-14)
    assert np.isfinite(found.residuals).all()


def test_a_motion_that_nothing_holds():
    stiffness = np.array([[2.0, 0.0, 0.0], [0.0, 1.0, -1.0], [0.0, -1.0, 1.0]])
    with pytest.raises(ArithmeticError, match="common null vector"):
        fl.eigenvalues(fl.Structure(np.diag([1.0, 0.0, 0.0]), stiffness))


def test_a_free_structure_needs_no_warning():
    """Its rigid motion has terms that are all zero, and the eigenvalue 0 twice."""
    found = fl.eigenvalues(fl.Structure(np.eye(2), [[1.0, -1.0], [-1.0, 1.0]]))
    assert np.allclose(found.values.imag, [0, 0, -np.sqrt(2), np.sqrt(2)], rtol=1e-14)
    assert (found.residuals < 1e-15).all()
    assert (found.backward_errors < 1e-15).all()


@pytest.mark.parametrize("n", [60, 420])
def test_rigid_motions_are_exact_zeros(n):
    """A free chain of masses with springs between them, and dampers in proportion."""
    differences = sparse.csc_array(np.diff(np.eye(n), axis=0))
    K, damping = differences.T @ differences, fl.RayleighDamping(beta=1e-3)
    found = fl.eigenvalues(fl.Structure(sparse.eye_array(n), K, damping, window=(0, 0.02)))
    assert found.values[:2].tolist() == [0.0, 0.0]
    assert found.marginal
    assert found.residuals.max() < 1e-8
    exact = 2 * np.sin(np.arange(1, 3) * np.pi / (2 * n))
    assert np.allclose(np.abs(found.values[2:6:2]), exact, rtol=1e-9)


def test_factors_in_an_order_solve_the_same(monkeypatch):
    M, C, K, G, N = unsymmetric_chain(40)
    matrix = QuadraticPencil(M, C + G, K + N).at(0.3)
    right = np.random.default_rng(0).standard_normal(40)
    expected = np.linalg.solve(matrix.toarray(), right)
    order = np.random.default_rng(1).permutation(40)
    monkeypatch.setattr("frictionlab.structures.quadratic_pencil._nested_dissection", lambda _: order)
    solve = factorised(matrix)
    assert solve is not None
    assert np.allclose(solve(right), expected, rtol=1e-10)


def test_nested_dissection_by_metis(monkeypatch):
    pytest.importorskip("pymetis", reason="the extra structures is not installed")
    monkeypatch.setattr("frictionlab.structures.quadratic_pencil.DISSECTED", 10)
    _, K = beam(60)
    solve = factorised(K)
    assert solve is not None
    assert np.allclose(K @ solve(np.ones(120)), 1.0, rtol=1e-6)


def test_one_mode_next_to_a_guess():
    """With both its vectors, from one factorisation; the derivative is that of a difference."""
    M, C, K, G, N = unsymmetric_chain(60, coupling=1.0, damping=0.02)
    structure = fl.Structure(M, K, C, gyroscopic=G, circulatory=[("mu", N)], parameters={"mu": 0.3})
    values = fl.eigenvalues(structure).values
    exact = values[values.imag > 1.0][3]
    mode = structure.pencil.mode_at(exact * (1 + 1e-4j))
    assert mode is not None
    assert abs(mode.value - exact) < 1e-12 * abs(exact)
    slope = -mode.left @ structure.pencil_derivative("mu").at(mode.value) @ mode.right
    low, high = (structure.replace(mu=mu).pencil.mode_at(exact) for mu in (0.3 - 1e-5, 0.3 + 1e-5))
    assert low is not None
    assert high is not None
    expected = (high.value - low.value) / 2e-5
    assert abs(slope - expected) < 1e-8 * abs(expected)
