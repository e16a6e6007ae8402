"""All real roots of a polynomial, none missed and none invented.

Between two neighbouring real roots of its derivative a polynomial is monotonic, so it has a root there
exactly if its signs at the two ends differ.  The derivative's roots come from the same rule, down to the
constant.  Eigenvalues of a companion matrix would need a threshold on their imaginary parts instead.
"""

from __future__ import annotations

from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .bracket import bracketed

Array = NDArray[np.float64]
SPREAD = 300.0  # natural logarithm of the ratio of coefficients that can count in one polynomial


def real_roots(polynomial: Any) -> list[float]:
    """Real roots in ascending order, each once.

    Parameters
    ----------
    polynomial : array_like (degree + 1,)
        The coefficients, constant first.

    Raises
    ------
    ValueError
        If the polynomial is zero everywhere.
    """
    coefficients = np.asarray(polynomial, dtype=float)
    if not coefficients.any():
        raise ValueError("every number is a root of the zero polynomial")
    scaled, scale = _scaled(coefficients)
    return [scale * root for root in _roots(scaled.tolist())]


def _scaled(coefficients: Array) -> tuple[Array, float]:
    """Coefficients in x/scale with the largest 1, and no root beyond 2 (Fujiwara's bound)."""
    (degrees,) = np.nonzero(coefficients)
    logs = np.log(np.abs(coefficients[degrees]))
    gaps = degrees[-1] - degrees[:-1]
    log_scale = float(np.max((logs[:-1] - logs[-1]) / gaps)) if len(gaps) else 0.0
    # By logarithms, because powers of the scale may leave the range of floats where coefficients are tiny.
    logs += degrees * log_scale
    if np.ptp(logs) > SPREAD:  # a leading coefficient as good as zero, whose root lies at infinity
        return _scaled(coefficients[: degrees[-1]])
    scaled = np.zeros(degrees[-1] + 1)
    scaled[degrees] = np.sign(coefficients[degrees]) * np.exp(logs - logs.max())
    return np.trim_zeros(scaled, "b"), float(np.exp(log_scale))


def _roots(coefficients: list[float]) -> list[float]:
    """Real roots of the polynomial with these coefficients, constant first, the last not zero."""
    if len(coefficients) < 2:
        return []
    if coefficients[0] == 0.0:
        return sorted({0.0, *_roots(coefficients[1:])})
    bound = 1.0 + max(abs(c / coefficients[-1]) for c in coefficients[:-1])
    slope = [k * c for k, c in enumerate(coefficients)][1:]
    ends = [-bound, *(c for c in _roots(slope) if -bound < c < bound), bound]
    found = (bracketed(partial(_value, coefficients[::-1]), low, high) for low, high in pairwise(ends))
    return sorted({root for root in found if root is not None})


def _value(descending: list[float], x: float) -> float:
    # Horner's rule in plain floats: numpy's call takes ten times as long for ten coefficients.
    total = 0.0
    for coefficient in descending:
        total = total * x + coefficient
    return total
