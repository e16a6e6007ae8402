"""One step of the Dormand-Prince method of order 8, with its dense output of order 7.

E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed., Springer 1993,
section II.10.  The numbers of the method are those that scipy holds; hybrid.py controls steps and events.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.integrate import DOP853

A, B, C, D, E3, E5 = (getattr(DOP853, name) for name in "A B C D E3 E5".split())
A_DENSE, C_DENSE = DOP853.A_EXTRA, DOP853.C_EXTRA
STAGES = len(B)


@dataclass(frozen=True, eq=False)
class Step:
    """A step from `t` over `h`: state before and after, rates of all stages."""

    t: float
    h: float
    z: np.ndarray
    z_end: np.ndarray
    K: np.ndarray


def step(rate: Any, t: float, z: np.ndarray, f: np.ndarray, h: float) -> Step:
    """A step of length h; f is rate(t, z)."""
    K = np.empty((STAGES + 1 + len(A_DENSE), len(z)))
    K[0] = f
    for s in range(1, STAGES):
        K[s] = rate(t + C[s] * h, z + h * (A[s, :s] @ K[:s]))
    z_end = z + h * (B @ K[:STAGES])
    K[STAGES] = rate(t + h, z_end)
    return Step(t, h, z, z_end, K)


def error(done: Step, scale: np.ndarray) -> float:
    """Estimated error of a step, as a share of `scale`."""
    K = done.K[: STAGES + 1]
    fifth, third = (np.sum((E @ K / scale) ** 2) for E in (E5, E3))
    if fifth == 0.0:
        return 0.0
    return float(done.h * fifth / np.sqrt((fifth + 0.01 * third) * len(scale)))


def dense(rate: Any, done: Step) -> Any:
    """The states within a step as a function of the share x of it, 0 to 1: (n,) or (n, samples)."""
    K, h = done.K, done.h
    for s, (a, c) in enumerate(zip(A_DENSE, C_DENSE, strict=True), start=STAGES + 1):
        K[s] = rate(done.t + c * h, done.z + h * (a[:s] @ K[:s]))
    change = done.z_end - done.z
    first = [change, h * K[0] - change, 2 * change - h * (K[STAGES] + K[0])]
    F = np.vstack([*first, h * (D @ K)])

    def at(x: Any) -> np.ndarray:
        x, y = np.asarray(x, dtype=float), 0.0
        for i, row in enumerate(F[::-1]):
            column = row if x.ndim == 0 else row[:, None]
            y = (y + column) * (x if i % 2 == 0 else 1 - x)
        return (done.z if x.ndim == 0 else done.z[:, None]) + y

    return at
