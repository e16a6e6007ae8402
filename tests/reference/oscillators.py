"""The textbook systems, written down from mechanics: who pushes whom, and how hard."""

from types import SimpleNamespace
from typing import Any

import numpy as np

from tests.reference.friction import Law
from tests.reference.hybrid import Next, System
from tests.reference.rubbing import Rubbing

REST = 1e-7  # speed of impacts, by the largest so far, below which the rest of them is summed as a series


class MassOnBelt(Rubbing):
    """m x'' = F_T - c x' - k x, on a belt of the speed v."""

    def __init__(self, p: SimpleNamespace, law: Law) -> None:
        super().__init__(p, law)
        self.period = 2 * np.pi * np.sqrt(p.m / p.k)

    def drive(self, t: Any) -> Any:
        """Force from outside."""
        return 0.0

    def v_r(self, i: int, z: Any) -> Any:
        return self.p.v - z[1]

    def normal(self, i: int, z: Any) -> Any:
        return self.p.N + 0 * z[0]

    def holding(self, i: int, t: Any, z: Any) -> Any:
        return self.p.k * z[0] + self.p.c * self.p.v - self.drive(t)

    def stopped(self, i: int, z: np.ndarray) -> np.ndarray:
        return np.array([z[0], self.p.v])

    def accelerations(self, t: float, z: Any, friction: list[Any], pressed: bool) -> list[Any]:
        p = self.p
        return [(friction[0] + self.drive(t) - p.c * z[1] - p.k * z[0]) / p.m]


class DenHartog(MassOnBelt):
    """The same on the ground, driven by F cos(Omega t)."""

    def __init__(self, p: SimpleNamespace, law: Law) -> None:
        p.v = 0.0
        super().__init__(p, law)
        self.period = min(self.period, 2 * np.pi / p.Omega)

    def drive(self, t: Any) -> Any:
        return self.p.F * np.cos(self.p.Omega * t)


class TwoBlocks(Rubbing):
    """Two masses on one belt, each on a spring and a damper, a spring between them."""

    contacts = 2

    def __init__(self, p: SimpleNamespace, law: Law) -> None:
        super().__init__(p, law)
        stiff = max((p.k1 + p.k12) / p.m1, (p.k2 + p.k12) / p.m2)
        self.period = 2 * np.pi / np.sqrt(stiff)

    def v_r(self, i: int, z: Any) -> Any:
        return self.p.v - z[2 + i]

    def normal(self, i: int, z: Any) -> Any:
        return (self.p.N1, self.p.N2)[i] + 0 * z[0]

    def pull(self, i: int, z: Any) -> Any:
        """Force of the springs, towards where they are slack."""
        own = (self.p.k1, self.p.k2)[i]
        return own * z[i] + self.p.k12 * (z[i] - z[1 - i])

    def holding(self, i: int, t: Any, z: Any) -> Any:
        return self.pull(i, z) + self.p.c * self.p.v

    def stopped(self, i: int, z: np.ndarray) -> np.ndarray:
        z = z.copy()
        z[2 + i] = self.p.v
        return z

    def accelerations(self, t: float, z: Any, friction: list[Any], pressed: bool) -> list[Any]:
        masses = (self.p.m1, self.p.m2)
        return [(friction[i] - self.pull(i, z) - self.p.c * z[2 + i]) / masses[i] for i in (0, 1)]


class ModeCoupling(Rubbing):
    """A mass in the plane on two inclined springs, pressed by F on a belt through a contact spring."""

    unilateral = True

    def __init__(self, p: SimpleNamespace, law: Law) -> None:
        super().__init__(p, law)
        springs = [(p.k1, np.cos(p.a1), np.sin(p.a1)), (p.k2, np.cos(p.a2), np.sin(p.a2))]
        self.springs = [tuple(map(float, spring)) for spring in springs]
        self.period = 2 * np.pi * np.sqrt(p.m / (p.k1 + p.k2 + p.k3))

    def pull(self, z: Any) -> tuple[Any, Any]:
        """Force of the inclined springs along x and y; each pulls along its own axis."""
        stretch = [(k * (c * z[0] + s * z[1]), c, s) for k, c, s in self.springs]
        return sum(f * c for f, c, _ in stretch), sum(f * s for f, _, s in stretch)

    def v_r(self, i: int, z: Any) -> Any:
        return self.p.v - z[2]

    def gap(self, z: Any) -> Any:
        return z[1]

    def normal(self, i: int, z: Any) -> Any:
        return self.p.k3 * z[1]

    def holding(self, i: int, t: Any, z: Any) -> Any:
        return self.pull(z)[0] + self.p.c * self.p.v

    def stopped(self, i: int, z: np.ndarray) -> np.ndarray:
        return np.array([z[0], z[1], self.p.v, z[3]])

    def accelerations(self, t: float, z: Any, friction: list[Any], pressed: bool) -> list[Any]:
        p, (along, across) = self.p, self.pull(z)
        normal = p.k3 * z[1] if pressed else 0.0
        return [
            (friction[0] - p.c * z[2] - along) / p.m,
            (p.F - p.c * z[3] - across - normal) / p.m,
        ]


class Stopped(System):
    """One coordinate before a rigid stop at d, on the side `side`; it comes back at -e times its speed."""

    side = -1.0  # the body is below the stop

    def __init__(self, p: SimpleNamespace) -> None:
        self.p, self.fastest = p, 0.0

    def force(self, t: Any, z: Any) -> Any:
        """Force over mass."""
        raise NotImplementedError

    def start(self, z: np.ndarray) -> tuple[str, ...]:
        if self.distance(z) > 0 or z[1] * self.side > 0:
            return ("flight",)
        return ("flight" if self.force(0.0, z) * self.side > 0 else "contact",)

    def distance(self, z: Any) -> Any:
        return self.side * (z[0] - self.p.d)

    def rate(self, mode: Any, t: float, z: np.ndarray) -> Any:
        return [0.0, 0.0] if mode[0] == "contact" else [z[1], self.force(t, z)]

    def guards(self, mode: Any, t: Any, z: Any) -> np.ndarray:
        held = mode[0] == "contact"
        return np.array([-self.side * self.force(t, z) if held else self.distance(z)])

    def leave(self, mode: Any, guard: int, t: float, z: np.ndarray) -> Next:
        if mode[0] == "contact":
            return Next(("flight",), z)
        speed, push = abs(z[1]), -self.side * self.force(t, np.array([self.p.d, 0.0]))
        self.fastest = max(self.fastest, speed)
        if push > 0 and self.p.e < 1 and (self.p.e == 0 or speed * self.p.e < REST * self.fastest):
            delay = (
                2 * self.p.e * speed / (push * (1 - self.p.e))
            )  # flights of e, e^2, e^3 ... times the first
            return Next(("contact",), np.array([self.p.d, 0.0]), speed, delay)
        first = 0.2 * self.p.e * speed / push if push > 0 else np.inf
        return Next(("flight",), np.array([self.p.d, -self.p.e * z[1]]), speed, first=first)

    def laws(self, mode: Any, t: Any, z: Any) -> dict[str, Any]:
        return {f"{mode[0]}: guard": self.guards(mode, t, z)[0]}


class ImpactOscillator(Stopped):
    """m x'' + c x' + k x = F cos(Omega t) while x < d."""

    def __init__(self, p: SimpleNamespace) -> None:
        super().__init__(p)
        self.period = 2 * np.pi * min(np.sqrt(p.m / p.k), 1 / p.Omega)

    def force(self, t: Any, z: Any) -> Any:
        p = self.p
        return (p.F * np.cos(p.Omega * t) - p.c * z[1] - p.k * z[0]) / p.m


class BouncingBall(Stopped):
    """y'' = -g above the ground."""

    side = 1.0

    def __init__(self, p: SimpleNamespace) -> None:
        p.d = 0.0
        super().__init__(p)
        self.period = np.sqrt(2 * max(p.h, 0.1) / p.g)

    def force(self, t: Any, z: Any) -> Any:
        return -self.p.g + 0 * z[0]
