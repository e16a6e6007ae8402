"""Roots of a polynomial on [0, 1], in order and none missed: Bernstein form, Descartes, safeguarded Newton.

In Bernstein form the number of sign changes of the coefficients bounds the number of roots in the interval
(Descartes' rule): none means no root, one means exactly one.  Otherwise the interval is halved (de
Casteljau). Source: Rouillier & Zimmermann, J. Comput. Appl. Math. 162 (2004) 33-50.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from frictionlab.hybrid.compilation import kernel

MAX_DEPTH = 60  # nested halvings, so at most as many intervals wait
# Roots closer than this, relative to their place, cannot be told from a double root in double precision.
ROOT_RESOLUTION = 1e-8


class RootScratch(NamedTuple):
    """A polynomial on [0, 1], its roots, and what it takes to find them."""

    stack: np.ndarray  # (MAX_DEPTH + 1, order + 1) Bernstein coefficients on the intervals that wait
    intervals: np.ndarray  # (MAX_DEPTH + 1, 2)
    scaled: np.ndarray  # (order + 1,) coefficients of the polynomial, lowest first
    places: np.ndarray  # (order + 2,) of its roots
    multiplicity: np.ndarray  # (order + 2,)


def new_root_scratch(order: int) -> RootScratch:
    """For polynomials up to a degree."""
    return RootScratch(
        stack=np.zeros((MAX_DEPTH + 1, order + 1)),
        intervals=np.zeros((MAX_DEPTH + 1, 2)),
        scaled=np.zeros(order + 1),
        places=np.zeros(order + 2),
        multiplicity=np.zeros(order + 2, dtype=np.int64),
    )


@kernel
def to_bernstein(a, n, b):
    """Bernstein coefficients `b` on [0, 1] of the polynomial sum a[k] x^k of degree `n`."""
    binomial = 1.0
    total = a[0]
    b[0] = a[0]
    for k in range(1, n + 1):
        total += a[k]
        binomial = binomial * (n - k + 1) / k
        b[k] = a[k] / binomial
    for i in range(1, n + 1):
        for j in range(n, i - 1, -1):
            b[j] += b[j - 1]
    b[n] = total  # the value at 1, without the rounding errors above


@kernel
def sign_changes(b, n):
    """Number of sign changes in b[0..n], zeros left out."""
    changes = 0
    last = 0.0
    for j in range(n + 1):
        if b[j] != 0.0:
            if last * b[j] < 0.0:
                changes += 1
            last = 1.0 if b[j] > 0.0 else -1.0
    return changes


@kernel
def bisect_bernstein(b, n, left, right):
    """Split Bernstein coefficients at the middle (de Casteljau); `right` may be `b` itself."""
    for j in range(n + 1):
        right[j] = b[j]
    left[0] = right[0]
    for i in range(1, n + 1):
        for j in range(n - i + 1):
            right[j] = 0.5 * (right[j] + right[j + 1])
        left[i] = right[0]


@kernel
def refine_root(a, n, lo, hi, falling):
    """The one root of sum a[k] x^k in (lo, hi); `falling` says it goes from + to -."""
    x = 0.5 * (lo + hi)
    for _ in range(100):
        value = a[n]
        slope = 0.0
        for k in range(n - 1, -1, -1):
            slope = slope * x + value
            value = value * x + a[k]
        if value == 0.0:
            return x
        if (value > 0.0) == falling:
            lo = x
        else:
            hi = x
        new = x - value / slope if slope != 0.0 else lo
        if not (lo < new < hi):
            new = 0.5 * (lo + hi)
        if abs(new - x) <= 1e-16 * x:
            return new
        x = new
    return x


@kernel
def trailing_zeros(b, n):
    """Multiplicity of the root at the right end; 0 where there is none or everything is zero."""
    for j in range(n + 1):
        if b[n - j] != 0.0:
            return j
    return 0


@kernel
def isolate_roots(n, limit, roots):
    """First `limit` roots in (0, 1], ascending, of the polynomial of degree `n` in ``roots.scaled``.

    Writes places and multiplicities, returns how many there are.  Roots that cannot be told apart
    count as one of that multiplicity.
    """
    count = 0
    a, stack, bounds = roots.scaled, roots.stack, roots.intervals
    to_bernstein(a, n, stack[0])
    bounds[0, 0] = 0.0
    bounds[0, 1] = 1.0
    top = 0
    while top >= 0 and count < limit:
        b = stack[top]
        lo = bounds[top, 0]
        hi = bounds[top, 1]
        changes = sign_changes(b, n)
        at_end = trailing_zeros(b, n)
        place = -1.0
        order = changes
        if changes == 0:
            if at_end > 0:
                place = hi
                order = at_end
        elif changes == 1 and at_end == 0:
            place = refine_root(a, n, lo, hi, b[n] < 0.0)
        elif hi - lo <= ROOT_RESOLUTION * hi or top == MAX_DEPTH - 1:
            place = 0.5 * (lo + hi)
        else:
            middle = 0.5 * (lo + hi)
            bisect_bernstein(b, n, stack[top + 1], b)
            bounds[top, 0] = middle
            bounds[top + 1, 0] = lo
            bounds[top + 1, 1] = middle
            top += 1
            continue
        top -= 1
        if place >= 0.0:
            roots.places[count] = place
            roots.multiplicity[count] = order
            count += 1
    return count
