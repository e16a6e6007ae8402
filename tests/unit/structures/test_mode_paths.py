"""Modes of structures along a parameter: closed forms, models, and the two ways in which they are found."""

from typing import Any

import numpy as np
import pytest
from scipy.linalg import eigh

import frictionlab as fl
from tests.helpers.finite_elements import unsymmetric_chain

# Two modes that friction couples.  K = [[2, mu], [-mu, 1]] has the eigenvalues (3 -+ sqrt(1 - 4 mu^2))/2.
COUPLED = {
    "M": np.eye(2),
    "K": np.diag([2.0, 1.0]),
    "circulatory": [("mu", [[0.0, 1.0], [-1.0, 0.0]])],
    "parameters": {"mu": 0.0},
}
WITH_DAMPING = COUPLED | {"C": 0.1 * np.eye(2)}


def exact(mu, damping=0.0):
    roots: Any = np.sqrt(
        np.array(-((3 + np.array([-1, 1]) * np.sqrt(1 - 4 * mu**2 + 0j)) / 2 - damping**2 / 4))
    )
    return np.sort_complex(1j * np.abs(roots.imag) + roots.real * np.sign(roots.imag) - damping / 2)


def test_critical_friction_of_two_modes():
    structure = fl.Structure(**COUPLED)
    (change,) = fl.stability_changes(structure, "mu", (0.0, 1.0))
    assert (change.kind, change.direction, change.unstable) == ("flutter", "loss", (0, 1))
    assert np.isclose(change.value, 0.5, rtol=1e-9)
    assert np.isclose(change.frequency, np.sqrt(1.5) / (2 * np.pi), rtol=1e-4)


def test_critical_friction_with_damping():
    """Where the closed form of the eigenvalues is on the imaginary axis."""
    found = fl.critical_value(fl.Structure(**WITH_DAMPING), "mu", (0.0, 1.0))
    assert found is not None
    assert abs(exact(found, 0.1).real.max()) < 1e-9


def test_root_locus_of_two_modes():
    at = np.array([0.0, 0.2, 0.4, 0.6, 0.8])
    locus = fl.root_locus(fl.Structure(**COUPLED), "mu", at)
    for mu, values in zip(at, locus.values):
        assert np.allclose(np.sort_complex(values), exact(mu), atol=1e-7)
    assert locus.unstable.tolist() == [0, 0, 0, 1, 1]
    assert locus.shapes.shape == (5, 2, 2)


@pytest.mark.parametrize("damping", [0.0, 1e-4])
@pytest.mark.parametrize("masses", [[1.0] * 6, [1.0, 5.0, 1.0, 3.0, 1.0, 10.0]], ids=str)
def test_shares_of_a_free_chain(damping, masses):
    """Those of kinetic energy, also beside a rigid motion's double eigenvalue 0."""
    n = len(masses)
    springs = 1e3 * (np.diag([1.0, *[2.0] * (n - 2), 1.0]) - np.eye(n, k=1) - np.eye(n, k=-1))
    skew = np.zeros((n, n))
    skew[0, 1], skew[1, 0] = 1.0, -1.0
    free = fl.Structure(
        np.diag(masses), springs, damping * springs, circulatory=[("mu", skew)], parameters={"mu": 0.0}
    )
    expected = np.diag(masses) @ eigh(springs, np.diag(masses))[1] ** 2
    locus = fl.root_locus(free, "mu", [0.0, 1e-3, 1e-2])
    assert np.allclose(locus.participation, expected, atol=1e-5)
    assert np.allclose(locus.participation[0], expected, atol=1e-12)
    found = fl.eigenvalues(free)
    assert np.allclose(found.participation[:, ::2], expected, atol=1e-12)


def test_a_warning_where_it_is_unstable_from_the_start():
    structure = fl.Structure(**COUPLED)
    with pytest.warns(RuntimeWarning, match="unstable from mu = 0.6 on, in all of the range"):
        assert fl.critical_value(structure, "mu", (0.6, 1.0)) is None
    assert fl.critical_value(structure, "mu", (0.0, 0.4)) is None


@pytest.fixture
def chain():
    M, C, K, G, N = unsymmetric_chain(24, coupling=1.0, damping=0.02)
    return fl.Structure(
        M, K, C, gyroscopic=G, circulatory=[("mu", N)], parameters={"mu": 0.3}, window=(0.0, 0.7)
    )


@pytest.mark.slow
def test_large_structures_change_where_small_ones_do(chain, monkeypatch):
    expected = [c for c in fl.stability_changes(chain, "mu", (0.0, 0.5)) if c.frequency < 0.7]
    monkeypatch.setattr("frictionlab.structures.mode_paths.MOST_SCANNED", 10)
    found = fl.stability_changes(chain, "mu", (0.0, 0.5))
    assert len(found) == len(expected) > 2
    assert np.allclose([c.value for c in found], [c.value for c in expected], rtol=1e-9)
    assert np.allclose([c.frequency for c in found], [c.frequency for c in expected], rtol=1e-7)
    assert [(c.direction, c.unstable) for c in found] == [
        (c.direction, tuple(found[0].unstable[0] + (k - expected[0].unstable[0]) for k in c.unstable))
        for c in expected
    ]


def test_modes_of_large_structures_stay_in_their_columns(chain, monkeypatch):
    at = np.linspace(0.0, 0.5, 6)
    whole = fl.root_locus(chain, "mu", at)
    monkeypatch.setattr("frictionlab.structures.mode_paths.MOST_SCANNED", 10)
    locus = fl.root_locus(chain, "mu", at)
    assert locus.shapes.shape[1] == 0
    for column in locus.values.T:
        known = np.isfinite(column)
        distances = np.abs(whole.values[known] - column[known, None]).max(axis=0)
        assert distances.min() < 1e-8


def test_refused():
    structure = fl.Structure(**COUPLED)
    with pytest.raises(TypeError, match="Structure has no parameter 'r'"):
        fl.root_locus(structure, "r", [1.0])
    with pytest.raises(ValueError, match="values must be one number or more"):
        fl.root_locus(structure, "mu", [])
    with pytest.raises(ValueError, match="bounds must be two numbers in ascending order"):
        fl.critical_value(structure, "mu", (1.0, 0.0))


def test_coalescence_without_damping_in_many_freedoms():
    """More freedoms than full spectra are taken of; the growth rate has no slope where it begins."""
    n = 51
    coupling = np.zeros((n, n))
    coupling[0, 1], coupling[1, 0] = 1.0, -1.0
    stiffness = np.diag([2.0, 1.0, *(100.0 + np.arange(n - 2))])
    structure = fl.Structure(
        np.eye(n), stiffness, circulatory=[("mu", coupling)], parameters={"mu": 0.1}, window=(0.0, 0.5)
    )
    (change,) = fl.stability_changes(structure, "mu", (0.0, 0.9))
    assert np.isclose(change.value, 0.5, rtol=1e-11)
    assert np.isclose(change.frequency, np.sqrt(1.5) / (2 * np.pi), rtol=1e-9)


@pytest.mark.slow
def test_critical_friction_with_hysteretic_damping():
    """A root lambda = -s^2 that is real puts s on the imaginary axis."""
    eta = 0.02
    structure = fl.Structure(**COUPLED | {"K": np.diag([2.0, 1.0]) * (1 + 1j * eta)})
    found = fl.critical_value(structure, "mu", (0.0, 1.0))
    assert found is not None

    def squares(mu):
        return np.linalg.eigvals(np.array([[2.0 + 2j * eta, mu], [-mu, 1.0 + 1j * eta]]))

    assert abs(squares(found).imag.min()) < 1e-9


def test_a_locus_has_no_negative_mass():
    structure = fl.Structure([("r", [[1.0]])], [[1.0]], parameters={"r": 1.0})
    with pytest.raises(ValueError, match="M must be positive"):
        fl.root_locus(structure, "r", [-1.0, 1.0])


def changes_both_ways(structure, bounds, monkeypatch):
    """Values and frequencies of changes of stability by full spectra, and by reductions."""
    found = []
    for most in (50, 0):
        monkeypatch.setattr("frictionlab.structures.mode_paths.MOST_SCANNED", most)
        changes = fl.stability_changes(structure, "mu", bounds)
        found.append([(c.value, c.frequency, c.direction, c.unstable) for c in changes])
    return found


@pytest.mark.slow
def test_growing_and_decaying_modes_of_like_shapes_are_no_changes(monkeypatch):
    M, C, K, _, N = unsymmetric_chain(12, coupling=1.0, damping=1e-3)
    structure = fl.Structure(M, K, C, circulatory=[("mu", N)], parameters={"mu": 0.3}, window=(0.0, 0.4))
    full, reduced = changes_both_ways(structure, (0.0, 0.5), monkeypatch)
    assert [one[2:] for one in full] == [one[2:] for one in reduced]
    assert len(full) > 3
    for one, other in zip(full, reduced, strict=True):
        assert np.allclose(one[:2], other[:2], rtol=1e-8)


@pytest.mark.slow
def test_doublets_at_the_lower_bound(monkeypatch):
    """All frequencies are double at mu = 0, where any shapes of a doublet are modes."""
    rng = np.random.default_rng(1)
    directions, _ = np.linalg.qr(rng.standard_normal((8, 8)))
    squares = np.repeat([1.2, 2.0, 4.1, 9.0], 2)
    coupling = 0.3 * rng.standard_normal((8, 8))
    structure = fl.Structure(
        np.eye(8),
        0.5 * (directions * squares @ directions.T + (directions * squares @ directions.T).T),
        0.02 * np.eye(8),
        circulatory=[("mu", coupling - coupling.T)],
        parameters={"mu": 0.0},
        window=(0.0, 1.0),
    )
    full, reduced = changes_both_ways(structure, (0.0, 1.0), monkeypatch)
    assert len(full) == len(reduced) > 0
    assert np.allclose([one[:2] for one in full], [one[:2] for one in reduced], rtol=1e-8)
    locus = fl.root_locus(structure, "mu", [0.0, 0.1, 0.2])
    assert locus.values.shape == (3, 8)
    assert np.isfinite(locus.values).all()


def test_only_the_window_counts():
    """Of two pairs of modes one is in the window, whatever the number of freedoms."""
    pair = np.array([[0.0, 1.0], [-1.0, 0.0]])
    zero = np.zeros((2, 2))
    structure = fl.Structure(
        np.eye(4),
        np.diag([2.0, 1.0, 200.0, 199.4]),
        circulatory=[("mu", np.block([[pair, zero], [zero, pair]]))],
        parameters={"mu": 0.0},
    )
    both = fl.stability_changes(structure, "mu", (0.0, 1.0))
    assert np.allclose([c.value for c in both], [0.3, 0.5], rtol=1e-9)
    low, high = structure.replace(window=(0.0, 1.0)), structure.replace(window=(1.0, 3.0))
    assert [c.unstable for c in fl.stability_changes(low, "mu", (0.0, 1.0))] == [(0, 1)]
    critical = [fl.critical_value(one, "mu", (0.0, 1.0)) or np.nan for one in (low, high)]
    assert np.allclose(critical, [0.5, 0.3], rtol=1e-9)
    locus = fl.root_locus(low, "mu", [0.2, 0.4, 0.6])
    assert locus.values.shape == (3, 2)
    assert locus.unstable.tolist() == [0, 0, 1]


@pytest.mark.slow
def test_maps_of_structures(monkeypatch):
    """Two modes with damping: stable where mu < sqrt(1/4 + 3 c^2/2), by Hurwitz's determinants."""
    structure = fl.Structure(
        np.eye(2),
        np.diag([2.0, 1.0]),
        [("c", np.eye(2))],
        circulatory=[("mu", [[0.0, 1.0], [-1.0, 0.0]])],
        parameters={"mu": 0.0, "c": 0.1},
    )
    for most in (50, 0):
        monkeypatch.setattr("frictionlab.structures.mode_paths.MOST_SCANNED", most)
        plane = fl.stability_map(structure, ("mu", [0.3, 0.6, 0.9]), ("c", [0.1, 0.2]))
        assert plane.unstable.tolist() == [[0, 1, 1], [0, 1, 1]]
        (curve,) = plane.boundary
        mu, c = curve.points.T
        assert np.allclose(mu, np.sqrt(0.25 + 1.5 * c**2), rtol=1e-9)
    with pytest.raises(TypeError, match="Structure has no parameter 'F'"):
        fl.stability_map(structure, ("F", [1, 2]), ("c", [0.1, 0.2]))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(12))
def test_random_structures_change_where_full_spectra_do(seed, monkeypatch):
    """Long: both ways are taken for each of a dozen structures."""
    rng = np.random.default_rng(seed)
    n = int(rng.choice([8, 12, 16, 20]))
    A, B, N, S, R = rng.standard_normal((5, n, n))
    K = A @ A.T + np.eye(n)
    low = 0.1 if seed % 2 else 0.0
    structure = fl.Structure(
        B @ B.T / n + np.eye(n),
        [(1, K), ("mu", 0.3 * (S + S.T))],
        10 ** rng.uniform(-3, -1) * K,
        gyroscopic=[("mu", 0.05 * (R - R.T))],
        circulatory=[("mu", N - N.T if seed % 3 else N)],
        parameters={"mu": 0.3},
        window=(low, float(rng.uniform(0.3, 0.8))),
    )
    full, reduced = changes_both_ways(structure, (0.0, 1.0), monkeypatch)
    assert [one[2:] for one in full] == [one[2:] for one in reduced]
    assert np.allclose([one[:2] for one in full], [one[:2] for one in reduced], rtol=1e-7, atol=1e-9)


@pytest.mark.slow  # the scan of 52 freedoms takes some seconds
def test_many_freedoms_without_a_window():
    """Pairs of modes that do not touch each other lose stability where mu = |a - b|/2."""
    squares = np.arange(1.0, 53.0)
    squares[1::2] -= np.linspace(0.0, 0.9, 26)  # the second of each pair is nearer to the first
    pair = np.array([[0.0, 1.0], [-1.0, 0.0]])
    structure = fl.Structure(
        np.eye(52),
        np.diag(squares),
        0.01 * np.eye(52),
        circulatory=[("mu", np.kron(np.diag(np.arange(26) < 3), pair))],
        parameters={"mu": 0.0},
    )
    found = [one.value for one in fl.stability_changes(structure, "mu", (0.0, 1.0))]
    # K = [[a, mu], [-mu, b]] with damping c: c^2 (a + b)/2 = mu^2 - (a - b)^2/4, by Hurwitz's determinants
    a, b = squares[0:6:2], squares[1:6:2]
    assert np.allclose(found, np.sort(np.sqrt((a - b) ** 2 / 4 + 1e-4 * (a + b) / 2)), rtol=1e-9)
