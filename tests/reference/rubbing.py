"""Bodies that rub, by Coulomb's rules: stick, slip and separation of each contact, whatever the friction law.

The force that keeps a relative velocity as it is (`holding`) depends on the state alone in all of these
systems, so that contacts decide one by one: they stick where it is within the static limit, and else slip its
way.
"""

from types import SimpleNamespace
from typing import Any

import numpy as np

from tests.reference.friction import Law
from tests.reference.hybrid import Next, System

SIGN = {"slip+": 1.0, "slip-": -1.0}


class Rubbing(System):
    """Base of the systems with friction.  A subclass says how its forces move it."""

    law: Law
    contacts = 1
    unilateral = False
    margin = 0.0  # share by which the static limit differs where stick is decided: for runs nearby

    def __init__(self, p: SimpleNamespace, law: Law) -> None:
        self.p, self.law, self.layers = p, law, law.layers

    def v_r(self, i: int, z: Any) -> Any:
        """Relative velocity of a contact."""
        raise NotImplementedError

    def normal(self, i: int, z: Any) -> Any:
        """Normal force of a contact that is closed."""
        raise NotImplementedError

    def holding(self, i: int, t: Any, z: Any) -> Any:
        """Friction force that keeps v_r as it is."""
        raise NotImplementedError

    def gap(self, z: Any) -> Any:
        """Compression of a contact that may open."""
        raise NotImplementedError

    def accelerations(self, t: float, z: Any, friction: list[Any], pressed: bool) -> list[Any]:
        """Of all coordinates, under friction forces, with or without the normal force."""
        raise NotImplementedError

    def stopped(self, i: int, z: np.ndarray) -> np.ndarray:
        """The state with v_r = 0, from which it differs by rounding."""
        raise NotImplementedError

    def landed(self, t: float, z: np.ndarray) -> Next:
        """After a re-contact; without an impact slip begins."""
        return Next((self.sliding(z),), z)

    def sliding(self, z: np.ndarray) -> str:
        """Direction of slip by the sign of v_r."""
        return "slip+" if self.v_r(0, z) > 0 else "slip-"

    def start(self, z: np.ndarray) -> tuple[str, ...]:
        if self.unilateral and self.gap(z) < 0:
            return ("separation",)
        return tuple(
            self.decided(i, 0.0, z) if self.v_r(i, z) == 0 else ("slip+" if self.v_r(i, z) > 0 else "slip-")
            for i in range(self.contacts)
        )

    def decided(self, i: int, t: float, z: np.ndarray) -> str:
        """Stick or slip where v_r = 0."""
        force, limit = self.holding(i, t, z), self.law.static(self.normal(i, z)) * (1 + self.margin)
        return "stick" if abs(force) < limit else "slip+" if force > 0 else "slip-"

    def friction(self, i: int, word: str, t: Any, z: Any) -> Any:
        """F_T of a contact."""
        if word == "separation":
            return 0.0
        if word == "stick":
            return self.holding(i, t, z)
        return SIGN[word] * self.law.kinetic(self.normal(i, z), SIGN[word] * self.v_r(i, z))

    def rate(self, mode: Any, t: float, z: np.ndarray) -> Any:
        values = z.tolist()
        forces = [self.friction(i, word, t, values) for i, word in enumerate(mode)]
        return [*values[len(values) // 2 :], *self.accelerations(t, values, forces, mode[0] != "separation")]

    def speeds(self, mode: Any, z: np.ndarray) -> list[float]:
        return [SIGN[word] * self.v_r(i, z) for i, word in enumerate(mode) if word in SIGN]

    def named(self, mode: Any, t: Any, z: Any) -> list[tuple[int, str, Any]]:
        """Event functions of a mode: contact, name, value."""
        rows = []
        for i, word in enumerate(mode):
            if word == "separation":
                rows.append((i, "land", -self.gap(z)))
                continue
            if word == "stick":
                force, limit = self.holding(i, t, z), self.law.static(self.normal(i, z))
                rows += [(i, "slip+", limit - force), (i, "slip-", limit + force)]
            else:
                rows.append((i, "stop", SIGN[word] * self.v_r(i, z)))
            if self.unilateral:
                rows.append((i, "separation", self.gap(z)))
        return rows

    def guards(self, mode: Any, t: Any, z: Any) -> np.ndarray:
        return np.array([value for *_, value in self.named(mode, t, z)])

    def leave(self, mode: Any, guard: int, t: float, z: np.ndarray) -> Next:
        i, kind, _ = self.named(mode, t, z)[guard]
        if kind == "land":
            return self.landed(t, z)
        if kind == "stop":
            z = self.stopped(i, z)
            kind = self.decided(i, t, z)
        return Next((*mode[:i], kind, *mode[i + 1 :]), z)

    def laws(self, mode: Any, t: Any, z: Any) -> dict[str, Any]:
        found = {f"{'|'.join(mode)}: {what} {i}": value for i, what, value in self.named(mode, t, z)}
        for i, word in enumerate(mode):
            if word == "stick":
                found[f"{'|'.join(mode)}: v_r {i}"] = -abs(self.v_r(i, z))
        return found
