"""The slider on the belt in doubles, by slider_equations.py; full gap rate or restitution."""

from types import SimpleNamespace
from typing import Any

import numpy as np

from tests.reference.friction import Law
from tests.reference.hybrid import Next
from tests.reference.rubbing import Rubbing
from tests.reference.slider_equations import structure_forces

REST = 1e-7  # speed of impacts, by the largest so far, below which the rest of them is summed as a series


class Slider(Rubbing):
    """Ten states x1, y1, x2, y2, phi and their rates; without geometry phi stays zero.

    `e` is the coefficient of restitution, 0 for impacts that bring the full gap rate to zero.
    """

    unilateral = True

    def __init__(self, p: SimpleNamespace, law: Law) -> None:
        super().__init__(p, law)
        p.inverse_J = 1 / p.J if p.geometry else 0.0
        self.fastest, self.unilateral = 0.0, p.unilateral
        stiff = max((p.k1 + p.k3 / 2) / p.M, (p.k3 / 2 + p.k2) / p.M, (p.k5 + p.k6 + p.k2) / p.m, p.k4 / p.m)
        self.period = 2 * np.pi / np.sqrt(stiff)

    def v_r(self, i: int, z: Any) -> Any:
        return self.p.v + z[7] - z[5]

    def gap(self, z: Any) -> Any:
        return z[3] - (z[0] - z[2]) * z[4] - z[1]

    def gap_rate(self, z: Any) -> Any:
        return z[8] - z[6] - (z[5] - z[7]) * z[4] - (z[0] - z[2]) * z[9]

    def normal(self, i: int, z: Any) -> Any:
        gap = self.gap(z)
        return self.p.k2 * gap + self.p.k_nl * gap * gap * gap

    def structure(self, z: Any) -> Any:
        """Forces of springs, dampers and preload, as the left side of Eq. (1)."""
        return structure_forces([(x,) for x in z[:5]], [(w,) for w in z[5:]], 0, self.p)

    def holding(self, i: int, t: Any, z: Any) -> Any:
        r = self.structure(z)
        return (self.p.m * r[0] - self.p.M * r[2]) / (self.p.M + self.p.m)

    def stopped(self, i: int, z: np.ndarray) -> np.ndarray:
        z, p = z.copy(), self.p
        impulse = self.v_r(0, z) / (1 / p.M + 1 / p.m)
        z[5] += impulse / p.M
        z[7] = z[5] - p.v
        return z

    def accelerations(self, t: float, z: Any, friction: list[Any], pressed: bool) -> list[Any]:
        p, r, F = self.p, self.structure(z), friction[0]
        N = self.normal(0, z) if pressed else 0.0
        return [
            (F - r[0]) / p.M,
            (N - r[1]) / p.M,
            (-F - r[2]) / p.m,
            (-N - r[3]) / p.m,
            (N * (z[0] - z[2]) - r[4]) * p.inverse_J,
        ]

    def landed(self, t: float, z: np.ndarray) -> Next:
        speed = abs(self.gap_rate(z))
        self.fastest = max(self.fastest, speed)
        closed = self.struck(z, 0.0)
        closing = self.closing(t, closed)
        if closing > 0 and self.p.e < 1 and (self.p.e == 0 or speed * self.p.e < REST * self.fastest):
            delay = 2 * self.p.e * speed / (closing * (1 - self.p.e))
            later = self.struck(closed + delay * np.array(self.rate(("separation",), t, closed)), 0.0)
            return Next((self.sliding(later),), later, speed, delay)
        first = 0.2 * self.p.e * speed / closing if closing > 0 else np.inf
        return Next(("separation",), self.struck(z, self.p.e), speed, first=first)

    def struck(self, z: np.ndarray, e: float) -> np.ndarray:
        """After an impulse along (1, -1, x1 - x2) on y1, y2, phi that turns the gap rate into -e times it."""
        p, z, lever = self.p, z.copy(), z[0] - z[2]
        impulse = (1 + e) * self.gap_rate(z) / (1 / p.M + 1 / p.m + lever**2 * p.inverse_J)
        z[6] += impulse / p.M
        z[8] -= impulse / p.m
        z[9] += impulse * lever * p.inverse_J
        return z

    def closing(self, t: float, z: np.ndarray) -> float:
        """Second derivative of the gap in flight."""
        a = self.accelerations(t, z.tolist(), [0.0], False)
        turning = 2 * (z[5] - z[7]) * z[9] + (z[0] - z[2]) * a[4]
        return float(a[3] - a[1] - (a[0] - a[2]) * z[4] - turning)
