"""Matrices of finite elements for tests: a beam of Hermite elements, and a chain of masses."""

import numpy as np
from scipy import sparse


def beam(elements, length=1.0, stiffness=1.0, mass=1.0, held=(0, -2)):
    """M and K of an Euler-Bernoulli beam, simply supported: Hermite elements, deflections and slopes.

    `stiffness` is E I, `mass` is that per length, `held` are freedoms at rest.
    """
    h = length / elements
    k = np.array(
        [
            [12, 6 * h, -12, 6 * h],
            [6 * h, 4 * h**2, -6 * h, 2 * h**2],
            [-12, -6 * h, 12, -6 * h],
            [6 * h, 2 * h**2, -6 * h, 4 * h**2],
        ]
    )
    m = np.array(
        [
            [156, 22 * h, 54, -13 * h],
            [22 * h, 4 * h**2, 13 * h, -3 * h**2],
            [54, 13 * h, 156, -22 * h],
            [-13 * h, -3 * h**2, -22 * h, 4 * h**2],
        ]
    )
    free = np.delete(np.arange(2 * (elements + 1)), held)
    M, K = (sparse.lil_array((2 * (elements + 1), 2 * (elements + 1))) for _ in range(2))
    for i in range(elements):
        places = np.ix_(range(2 * i, 2 * i + 4), range(2 * i, 2 * i + 4))
        M[places] += mass * h / 420 * m
        K[places] += stiffness / h**3 * k
    return tuple(sparse.csc_array(sparse.csc_array(one)[free][:, free]) for one in (M, K))


def beam_frequencies(count, length=1.0, stiffness=1.0, mass=1.0):
    """Exact frequencies of the simply supported beam, Hz."""
    wave = np.arange(1, count + 1) * np.pi / length
    return wave**2 * np.sqrt(stiffness / mass) / (2 * np.pi)


def unsymmetric_chain(n, coupling=0.1, damping=1e-3, rng=0):
    """M, C, K, G, N of two chains of n/2 masses, which circulatory and gyroscopic forces couple."""
    half = n // 2
    numbers = np.random.default_rng(rng)
    M = sparse.diags_array(1.0 + 0.1 * numbers.random(n))
    second = sparse.csc_array(2 * np.eye(half) - np.eye(half, k=1) - np.eye(half, k=-1))
    K = sparse.block_diag([second, 1.01 * second]) * (n * n / 100.0)
    K = K + sparse.diags_array(0.1 + 0.05 * numbers.random(n))
    cross = coupling * sparse.block_array(
        [[None, sparse.eye_array(half)], [-sparse.eye_array(half), None]], format="csc"
    )
    return tuple(map(sparse.csc_array, (M, damping * (M + 0.01 * K), K, 0.1 * cross, cross)))
