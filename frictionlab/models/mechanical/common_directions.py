"""Contacts that rub along one direction, as several pads on one body: they stick and slip together.

Where v_r of one contact is a multiple of that of another, one cannot slip while the other sticks, and the
equations of motion give only the sum of the forces that hold, as W^T M^-1 W is singular.  The rule: each
contact has a share in proportion to its limit.  So all reach their limits at once, and stick ends where the
load exceeds the sum of all limits, as in the limit of contacts that are a little compliant.

Speeds of belts may be given by parameters of different names.  Then these contacts stick together only where
the parameters are equal.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import sympy

from frictionlab.models.symbols import expand_products

LEAST_LIMIT = 1e-290  # N, no summand of any limit but zero: of contacts that are only touched shares are 0/0
RUBBING = {"stick": 0, "slip+": 1, "slip-": -1}  # the sign of v_r in the regimes of a contact that can stick
SLIP = "slip+", "slip-"
Row = tuple[Any, ...]


@dataclass(frozen=True, eq=False)
class CommonDirection:
    """Contacts i whose relative velocity is `ratios`_i v + `offsets`_i, where v is that of the first.

    Parameters
    ----------
    contacts : tuple of int
        Indices of the contacts.
    ratios, offsets : tuple of Expr
        Expressions of parameters; the ratios are not zero.
    """

    contacts: tuple[int, ...]
    ratios: tuple[Any, ...]
    offsets: tuple[Any, ...]

    def ratio(self, i: int, of: int) -> Any:
        """How many times faster contact `i` rubs than contact `of`, but for the belts' speeds."""
        ratios = dict(zip(self.contacts, self.ratios, strict=True))
        return ratios[i] / ratios[of]

    def sign(self, i: int, of: int) -> int | None:
        """The sign of this ratio; None where it depends on parameters."""
        sign = sympy.sign(self.ratio(i, of))
        return int(sign) if sign.is_Integer else None

    def at_one_speed(self, i: int, of: int) -> bool:
        """Whether v_r of one is zero wherever that of the other is, whatever the parameters."""
        offsets = dict(zip(self.contacts, self.offsets, strict=True))
        return expand_products(offsets[i] - self.ratio(i, of) * offsets[of]) == 0

    def rubbing(self, names: Sequence[str]) -> tuple[int, ...]:
        """The contacts that stick or slip, where these are the names of all contacts' regimes."""
        return tuple(i for i in self.contacts if names[i] in RUBBING)

    def allows(self, names: Sequence[str]) -> bool:
        """Whether contacts at one speed all stick or all slip, in the same direction."""
        some = self.rubbing(names)
        return all(
            self._agree(i, j, RUBBING[names[i]], RUBBING[names[j]])
            for n, i in enumerate(some)
            for j in some[:n]
            if self.at_one_speed(i, j)
        )

    def _agree(self, i: int, j: int, one: int, other: int) -> bool:
        sign = self.sign(i, j)
        return abs(one) == abs(other) and (sign is None or one == sign * other)

    def leader(self, i: int, names: Sequence[str]) -> int:
        """The contact at which the events of contact `i` are looked for: the first for which they are the
        same."""
        if names[i] == "stick":
            return next(j for j in self.contacts if names[j] == "stick")
        same = (
            j
            for j in self.rubbing(names)
            if names[j] != "stick" and self.sign(j, i) is not None and self.at_one_speed(j, i)
        )
        return next(same, i)

    def together(self, i: int, names: Sequence[str], name: str) -> tuple[dict[int, str], ...]:
        """Regimes that contacts may enter as contact `i` enters that of this name, by their indices.

        First all contacts, which may have belts of one speed; then those that are known to.
        """
        some = self.rubbing(names)
        groups = [some] if name == "stick" or names[i] == "stick" else []
        groups.append(tuple(j for j in some if self.at_one_speed(j, i)))
        return tuple({j: self._seen_from(j, i, name) for j in group} for group in dict.fromkeys(groups))

    def _seen_from(self, j: int, i: int, name: str) -> str:
        """The regime of contact `j` where contact `i` has the regime of this name."""
        reverse = self.sign(j, i) == -1
        return {"slip+": "slip-", "slip-": "slip+"}[name] if reverse and RUBBING[name] else name

    def shares(self, leader: int, force: Any, limits: dict[int, Any]) -> tuple[dict[int, Any], Any]:
        """The force of each contact, by its limit, and the sum of the limits seen from the leader.

        The leader alone would hold with `force`.  Contacts that are only touched have no share.
        """
        ratios = {i: self.ratio(i, leader) for i in limits}
        total = sum((sympy.Abs(ratios[i]) * limit for i, limit in limits.items()), sympy.S.Zero)
        shares = {i: sympy.sign(ratios[i]) * limit for i, limit in limits.items()}
        some = total if all((share / total).is_number for share in shares.values()) else total + LEAST_LIMIT
        return {i: share * force / some for i, share in shares.items()}, total


def common_directions(
    rows: Sequence[Row | None], offsets: Sequence[Any], states: Sequence[Any]
) -> tuple[CommonDirection, ...]:
    """Groups of contacts whose v_r are multiples of each other; those that are alone are left out.

    Parameters
    ----------
    rows : sequence of tuple of Expr
        Gradient of the relative velocity of each contact by the velocities; None for contacts that cannot
        stick.
    offsets : sequence of Expr
        Its value at rest.
    states : sequence of Symbol
    """
    groups: list[list[tuple[int, Any, Any]]] = []
    for i, row in enumerate(rows):
        for group in groups if row is not None else ():
            first = group[0][0]
            ratio = _ratio(row, rows[first])
            offset = None if ratio is None else expand_products(offsets[i] - ratio * offsets[first])
            if ratio is not None and not _depends(ratio, states) and not _depends(offset, states):
                group.append((i, ratio, offset))
                break
        else:
            if row is not None and any(row):
                groups.append([(i, sympy.S.One, sympy.S.Zero)])
    return tuple(CommonDirection(*zip(*group, strict=True)) for group in groups if len(group) > 1)


def _depends(expression: Any, states: Sequence[Any]) -> bool:
    return bool(expression.free_symbols.intersection(states))


def _ratio(row: Any, of: Any) -> Any:
    """The number by which one row is a multiple of another; None where it is none."""
    pairs = [(a, b) for a, b in zip(row, of, strict=True) if a != 0 or b != 0]
    if any(a == 0 or b == 0 for a, b in pairs):
        return None
    one, other = pairs[0]
    return one / other if all(expand_products(a * other - b * one) == 0 for a, b in pairs[1:]) else None
