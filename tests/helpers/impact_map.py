"""The impact oscillator from impact to impact, without the package.

It is m x'' + c x' + k x = F cos(Omega t), x < d.  Between impacts the motion is known in closed form; an
impact is where that comes to d for the first time, and leaves e of the speed.  The map takes the time t and
the velocity v at which the mass leaves the stop to the next.
"""

import math
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

STEP, AT_ONCE = 0.05, 50  # between the times looked at, and how many of them


class Oscillator(NamedTuple):
    m: float = 1.0
    c: float = 0.0
    k: float = 1.0
    d: float = 0.0
    F: float = 1.0
    Omega: float = 2.8
    e: float = 0.8

    def forced(self, t, on=math):
        """Position and velocity that the force alone would keep up."""
        stiff, damped = self.k - self.m * self.Omega**2, self.c * self.Omega
        gain, c, s = self.F / (stiff**2 + damped**2), on.cos(self.Omega * t), on.sin(self.Omega * t)
        return gain * (stiff * c + damped * s), gain * self.Omega * (damped * c - stiff * s)

    def transition(self, t, on=math):
        """The matrix [[a, b], [p, q]] of the free motion over a time t."""
        decay = self.c / (2 * self.m)
        w = math.sqrt(self.k / self.m - decay**2)
        fade, c, s = on.exp(-decay * t), on.cos(w * t), on.sin(w * t) / w
        return fade * (c + decay * s), fade * s, -fade * s * self.k / self.m, fade * (c - decay * s)

    def flight(self, t, v, after, on=math):
        """Position and velocity a time `after` the mass left the stop at t with the velocity v < 0."""
        x0, v0 = self.forced(t)
        x1, v1 = self.forced(t + after, on)
        a, b, p, q = self.transition(after, on)
        return x1 + a * (self.d - x0) + b * (v - v0), v1 + p * (self.d - x0) + q * (v - v0)

    def acceleration(self, t, v):
        """At the stop."""
        return (self.F * math.cos(self.Omega * t) - self.c * v - self.k * self.d) / self.m

    def flight_time(self, t, v):
        """Time to the next impact: the first root of (x - d)/after, which the impact before is none of."""
        last, first = 0.0, 0
        while True:
            after = STEP * np.arange(first + 1, first + AT_ONCE + 1)
            x, speed = self.flight(t, v, after, np)
            # Between two of the times the mass could come and go only where it turns round.
            turns = np.flatnonzero((speed[:-1] > 0) & (speed[1:] <= 0) & (x[:-1] < self.d))
            tops = [brentq(lambda s: self.flight(t, v, s)[1], after[i], after[i + 1]) for i in turns]
            there = [*after[x >= self.d][:1], *(s for s in tops if self.flight(t, v, s)[0] >= self.d)]
            if there:
                end = min(there)
                begin = max([last, *after[after < end]])
                return self._root(t, v, begin, end)
            first, last = first + AT_ONCE - 1, after[-2]

    def _root(self, t, v, begin, end):
        def share(s):
            return (self.flight(t, v, s)[0] - self.d) / s if s else v

        return brentq(share, begin, end, xtol=1e-15, rtol=1e-15)

    def impact(self, t, v):
        """The next (t, v), and the Jacobian of the map.

        At the impact x(t'; t, v) = d, so that dt' = -(x_t dt + x_v dv)/x', and v' = -e x' changes with all of
        t', t and v.  A start that is later by dt is on the motion that was dt before: its state differs
        by -(v, acceleration) dt.
        """
        after = self.flight_time(t, v)
        a, b, p, q = self.transition(after)
        rate, speed = self.acceleration(t, v), self.flight(t, v, after)[1]
        later = np.array([-(a * v + b * rate), b]), np.array([-(p * v + q * rate), q])
        times = -later[0] / speed
        speeds = -self.e * (self.acceleration(t + after, speed) * times + later[1])
        return t + after, -self.e * speed, np.array([times, speeds])


def growth(oscillator, t, v, impacts):
    """Logarithms (impacts, 2) by which both directions grow, times and speeds (impacts + 1,) at impacts."""
    frame, growths, course = np.eye(2), [], [(t, v)]
    for _ in range(impacts):
        t, v, jacobian = oscillator.impact(t, v)
        frame, r = np.linalg.qr(jacobian @ frame)
        growths.append(np.log(np.abs(np.diag(r))))
        course.append((t, v))
    return np.array(growths), *np.array(course).T


def exponents(growths, times, blocks=20):
    """Means over blocks of impacts (blocks, 2), a second."""
    parts = zip(np.array_split(growths, blocks), np.array_split(np.diff(times), blocks))
    return np.array([g.sum(axis=0) / t.sum() for g, t in parts])
