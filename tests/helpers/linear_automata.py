"""Linear automata q'' = -C q' - K q, whose eigenvalues a test knows."""

from __future__ import annotations

import numpy as np
import sympy

import frictionlab as fl

P = sympy.Symbol("p")


def linear(stiffness, damping=0.0, **values):
    """Of matrices whose entries may contain symbols; a number for C is a multiple of the unit matrix.

    `values` are those of the symbols; p is zero if not given.
    """
    K = sympy.Matrix(stiffness)
    n = K.shape[0]
    C = damping * sympy.eye(n) if np.ndim(damping) == 0 else sympy.Matrix(damping)
    q, v = sympy.symbols(f"q:{n}"), sympy.symbols(f"v:{n}")
    flow = (*v, *(-(K * sympy.Matrix(q) + C * sympy.Matrix(v))))
    parameters = {sympy.Symbol(name): value for name, value in {"p": 0.0, **values}.items()}
    return fl.HybridAutomaton((*q, *v), (fl.Mode("only", flow),), parameters, n)


def rotated(entries, seed):
    """A full matrix with these eigenvalues, and its orthogonal eigenvectors as columns."""
    vectors, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(len(entries), len(entries))))
    R = sympy.Matrix(vectors)
    return R * sympy.diag(*entries) * R.T, vectors
