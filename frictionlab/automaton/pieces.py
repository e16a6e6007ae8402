"""Functions in pieces, and modes with such functions as modes that are smooth.

A function in pieces is a formula between each two neighbouring *borders* of some x, such as |x| on either
side of x = 0.  Each mode that has it becomes one mode for each piece.  Where x reaches a border there is an
event, which resets nothing; so a Taylor step never crosses a kink.

A border that depends on parameters alone is no event: which piece holds is a number.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import islice, pairwise, product
from math import prod
from typing import Any

import sympy

from frictionlab.automaton.expressions import multiply_out
from frictionlab.automaton.matrix_rows import MatrixProduct, MatrixRow
from frictionlab.automaton.mode import Event, Mode, Reset
from frictionlab.automaton.modes_on_demand import (
    JOINT,
    NO_PARTS,
    Combination,
    ModeNames,
    ModesOnDemand,
    Regime,
    names_of_parts,
)

MOST_AT_ONCE = 27  # up to so many modes are all made; where there are more, each is when a run comes to it
MOST_LISTED = 200  # targets that an event names
MOST_PRINTED = 8  # pieces that are printed as cases
LONGEST_NAME = 40  # characters of x in the name of a mode


class Pieces(sympy.Function):
    """``Pieces(x, *borders, *values)``: the first value where x is below the first border, and so on.

    There is one more value than there are borders, which ascend.  On a border the value above it holds.
    """

    is_commutative = True

    @classmethod
    def eval(cls, x: Any, *rest: Any) -> Any:
        """A simpler expression, where it is known on which sides of borders x is."""
        count = len(rest) // 2
        borders, values = list(rest[:count]), list(rest[count:])
        sides = [_is_above(x, border) for border in borders]
        below = sides.index(False) if False in sides else count
        above = max((i + 1 for i in range(below) if sides[i]), default=0)
        borders, values = borders[above:below], values[above : below + 1]
        if all(value == values[0] for value in values):
            return values[0]
        return None if len(borders) == count else cls(x, *borders, *values)

    @property
    def x(self) -> Any:
        """What the borders are borders of."""
        return self.args[0]

    @property
    def borders(self) -> tuple[Any, ...]:
        """The borders, in ascending order."""
        return self.args[1 : len(self.args) // 2]

    @property
    def values(self) -> tuple[Any, ...]:
        """The value of each piece."""
        return self.args[len(self.args) // 2 :]

    def _eval_derivative(self, s: Any) -> Any:
        """The derivative of each piece; jumps do not show in it."""
        return Pieces(self.x, *self.borders, *(sympy.diff(value, s) for value in self.values))

    def _eval_is_extended_real(self) -> bool | None:
        return True if all(value.is_extended_real for value in self.values) else None

    def _eval_is_finite(self) -> bool | None:
        return True if all(value.is_finite for value in self.values) else None

    def as_known(self) -> Any:
        """The same as sympy's function: Abs, sign, Min, Max, else Piecewise."""
        x, values = self.x, self.values
        if self.borders == (0,):
            plain = x.is_Symbol  # of others sympy would look for a sign for seconds
            if values == (-x, x):
                return sympy.Abs(x, evaluate=plain)
            if values == (sympy.S.NegativeOne, sympy.S.One):
                return sympy.sign(x, evaluate=plain)
        if values == (x, *self.borders):
            return sympy.Min(*values, evaluate=False)
        if values == (*self.borders, x):
            return sympy.Max(*values, evaluate=False)
        if any(one.has(Pieces, sympy.Piecewise) for one in (x, *self.borders)):
            return self._by_signs()
        conditions = [x < border for border in self.borders]
        return sympy.Piecewise(*zip(values, [*conditions, True], strict=True), evaluate=False)

    def _by_signs(self) -> Any:
        """The same by signs: sympy takes minutes for conditions that contain functions in pieces."""
        half = sympy.Rational(1, 2)
        above = [half + sympy.sign(half + sympy.sign(self.x - border)) / 2 for border in self.borders]
        shares = [low - high for low, high in pairwise([sympy.S.One, *above, sympy.S.Zero])]
        return sympy.Add(*(share * value for share, value in zip(shares, self.values, strict=True)))

    def _latex(self, printer: Any) -> str:
        if len(self.values) > MOST_PRINTED:
            return rf"\operatorname{{pieces}}_{{{len(self.values)}}}\left({printer.doprint(self.x)}\right)"
        return printer.doprint(self.as_known())

    def _sympystr(self, printer: Any) -> str:
        if len(self.values) > MOST_PRINTED:
            return f"pieces_{len(self.values)}({printer.doprint(self.x)})"
        return printer.doprint(self.as_known())


def _is_above(x: Any, border: Any) -> bool | None:
    """Whether x is above a border; None where it depends on what is not known."""
    if not border.is_number:
        return None
    if x.is_number:
        return bool(x >= border)
    if not (x.is_Symbol or (-x).is_Symbol):  # of sums it would take long to know
        return None
    if x.is_nonnegative and border <= 0:
        return True
    return False if x.is_nonpositive and border > 0 else None


@dataclass(frozen=True)
class Division:
    """What divides modes: a function of the state and its borders, in ascending order.

    Parameters
    ----------
    x : Expr
    borders : tuple of Expr
    label : str
        What stands for `x` in names of modes and events.
    """

    x: Any
    borders: tuple[Any, ...]
    label: str

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the sides, one more than there are borders."""
        texts = [_text(border) for border in self.borders]
        between = (f"{low} < {self.label} < {high}" for low, high in pairwise(texts))
        return (f"{self.label} < {texts[0]}", *between, f"{self.label} > {texts[-1]}")

    def name_of_border(self, i: int) -> str:
        """The name of a border, such as "x = d"."""
        return f"{self.label} = {_text(self.borders[i])}"

    def bounds(self, side: int) -> Iterator[tuple[int, Any, int]]:
        """The borders of a side: index, the function that is positive on this side, and the side beyond."""
        if side > 0:
            yield side - 1, self.x - self.borders[side - 1], side - 1
        if side < len(self.borders):
            yield side, self.borders[side] - self.x, side + 1

    def divides(self, part: Pieces) -> bool:
        """Whether the borders of a function in pieces are among these."""
        return self.x == part.x and {*part.borders} <= {*self.borders}

    def value(self, part: Pieces, side: int) -> Any:
        """The value of a function in pieces on a side."""
        below = {*self.borders[:side]}
        return part.values[sum(border in below for border in part.borders)]


Sides = tuple[int | None, ...]  # for each division a side; None where a mode does not depend on it


def _text(expression: Any) -> str:
    if expression.is_Float:
        return f"{float(expression):.15g}"
    return sympy.sstr(expression, full_prec=False)


def divisions_of(states: Sequence[Any], expressions: Iterable[Any]) -> tuple[Division, ...]:
    """What divides modes whose expressions these are; borders of one function that are numbers are joined."""
    moving, by_argument = frozenset(states), dict[tuple[Any, bool], dict[Any, None]]()
    parts = dict.fromkeys(part for one in expressions for part in _parts(one))
    for part in sorted(parts, key=lambda one: len(one.borders), reverse=True):
        if not _moves(part, moving):
            continue
        numbers = all(border.is_number for border in part.borders)
        decisions = (
            borders
            for (x, _), borders in by_argument.items()
            if x == part.x and {*part.borders} <= {*borders}
        )
        if next(decisions, None) is None:
            key = part.x, True if numbers else part.borders
            by_argument.setdefault(key, {}).update(dict.fromkeys(part.borders))
    divisions = []
    for number, ((x, numbers), borders) in enumerate(by_argument.items(), 1):
        label = _text(x)
        ordered = sorted(borders, key=float) if numbers is True else borders
        divisions.append(Division(x, tuple(ordered), label if len(label) <= LONGEST_NAME else f"({number})"))
    return tuple(divisions)


def has_pieces(expressions: Iterable[Any]) -> bool:
    """Whether any of the expressions has a function in pieces."""
    # What is no expression is refused later, in words.
    return any(_parts(one) for one in expressions if hasattr(one, "atoms"))


def borders_in(expression: Any) -> tuple[tuple[Any, Any], ...]:
    """Each border of functions in pieces in an expression, with what it is a border of."""
    parts = sorted(_parts(expression), key=str)
    return tuple(dict.fromkeys((part.x, border) for part in parts for border in part.borders))


def beside_border(expression: Any, x: Any, border: Any, side: int) -> Any:
    """An expression as it is next to a border of x, above (1) or below (0)."""
    return expression.replace(
        lambda part: isinstance(part, Pieces) and part.x == x and border in part.borders,
        lambda part: part.values[part.borders.index(border) + side],
    )


def mode_expressions(mode: Mode) -> Iterator[Any]:
    """All expressions of a mode."""
    yield from (*mode.flow, *mode.constraints, *mode.outputs.values())
    for event in mode.events:
        yield event.function
        for reset in filter(None, (event.reset, event.accumulation)):
            yield from (*reset.jump.values(), *reset.vanishing)


def split_modes(
    modes: Any, states: Sequence[Any], expressions: Iterable[Any] = (), again: Any = None, origin: Any = None
) -> Any:
    """Smooth modes in place of those with functions in pieces: a tuple of modes, or modes on demand.

    Parameters
    ----------
    modes : tuple of Mode, or ModesOnDemand
    states : sequence of Symbol
    expressions : iterable of Expr
        Where modes are on demand, expressions that hold all functions in pieces of these.
    again, origin
        As of :class:`ModesOnDemand`.
    """
    if isinstance(modes, ModesOnDemand):
        return _on_demand(_Split(states, divisions_of(states, expressions)), modes, again, origin)
    if not any(has_pieces(mode_expressions(mode)) for mode in modes):
        return modes
    split = _Split(states, divisions_of(states, [one for mode in modes for one in mode_expressions(mode)]))
    if sum(split.count(mode) for mode in modes) > MOST_AT_ONCE:
        return _on_demand(split, modes, again, origin)
    every = [(mode, sides) for mode in modes for sides in product(*split.sides(mode))]
    names = _NamesOfAll(split, every)
    return tuple(split.smooth(mode, sides, names) for mode, sides in every)


class _Split:
    """Takes modes apart along divisions of the state space."""

    def __init__(self, states: Sequence[Any], divisions: tuple[Division, ...]) -> None:
        self.moving, self.divisions = frozenset(states), divisions
        self._sides: dict[Mode, tuple[tuple[int | None, ...], ...]] = {}

    def sides(self, mode: Mode) -> tuple[tuple[int | None, ...], ...]:
        """For each division the sides on which a mode can be; None where it does not depend on it."""
        if mode not in self._sides:
            parts = {part for one in mode_expressions(mode) for part in _parts(one)}
            self._sides[mode] = tuple(self._sides_of(mode, parts, one) for one in self.divisions)
        return self._sides[mode]

    def count(self, mode: Mode) -> int:
        """How many smooth modes there are in place of one."""
        return prod(map(len, self.sides(mode)))

    def _sides_of(self, mode: Mode, parts: set[Any], division: Division) -> tuple[int | None, ...]:
        if not any(division.divides(part) for part in parts):
            return (None,)
        sides = range(len(division.borders) + 1)
        # A guard of the mode may be on a border: then the mode is on one side of it.
        guards = [event.function for event in mode.events]
        for side in sides:
            for _, function, beyond in division.bounds(side):
                if any(_equal(guard, function) for guard in guards):
                    sides = [one for one in sides if (one <= side if beyond > side else one >= side)]
        return tuple(sides)

    def smooth(self, mode: Mode, sides: Sides, names: _Names) -> Mode:
        """The smooth mode of a mode on these sides."""
        if all(side is None for side in sides) and not has_pieces(mode_expressions(mode)):
            return self._with_targets(mode, mode, sides, names)
        value = _OnSides(self.moving, self.divisions, sides)
        events = [
            replace(
                event,
                function=value(event.function),
                reset=_on_sides(event.reset, value),
                accumulation=None if event.accumulation is None else _on_sides(event.accumulation, value),
            )
            for event in mode.events
        ]
        guards = [event.function for event in mode.events]
        for i, (division, side) in enumerate(zip(self.divisions, sides, strict=True)):
            for border, function, beyond in division.bounds(side) if side is not None else ():
                if not any(_equal(guard, function) for guard in guards):
                    crossed = (*sides[:i], beyond, *sides[i + 1 :])
                    name = division.name_of_border(border)
                    events.append(Event(name, value(function), (names.name(mode, crossed),)))
        flow, constraints = tuple(map(value, mode.flow)), tuple(map(value, mode.constraints))
        outputs = {name: value(one) for name, one in mode.outputs.items()}
        piece = replace(mode, flow=flow, events=tuple(events), constraints=constraints, outputs=outputs)
        return self._with_targets(piece, mode, sides, names)

    def _with_targets(self, piece: Mode, mode: Mode, sides: Sides, names: _Names) -> Mode:
        events = [
            replace(event, targets=names.targets(event.targets, sides)) if i < len(mode.events) else event
            for i, event in enumerate(piece.events)
        ]
        return replace(piece, name=names.name(mode, sides), events=tuple(events), whole=mode)


class _Names:
    """Names of smooth modes."""

    def name(self, mode: Mode, sides: Sides) -> str:
        """The name of a mode on these sides."""
        raise NotImplementedError

    def targets(self, names: Sequence[str], sides: Sides) -> tuple[str, ...]:
        """The smooth modes of an event's targets: those on the same sides, as far as a target has them."""
        raise NotImplementedError


def _agree(sides: Sides, others: Sides) -> bool:
    return all(one == other or one is None or other is None for one, other in zip(sides, others, strict=True))


class _NamesOfAll(_Names):
    """Names of smooth modes that are all made."""

    def __init__(self, split: _Split, every: Sequence[tuple[Mode, Sides]]) -> None:
        self._split = split
        self._of: dict[str, dict[str, Sides]] = {}
        for mode, sides in every:
            self._of.setdefault(mode.name, {})[self.name(mode, sides)] = sides

    def name(self, mode: Mode, sides: Sides) -> str:
        """The mode's name and those of the sides, where there are several."""
        about = zip(self._split.divisions, sides, self._split.sides(mode), strict=True)
        first = () if mode.name == NO_PARTS else (mode.name,)
        return (
            JOINT.join(
                [*first, *(d.names[side] for d, side, all_ in about if side is not None and len(all_) > 1)]
            )
            or NO_PARTS
        )

    def targets(self, names: Sequence[str], sides: Sides) -> tuple[str, ...]:
        """As in the base class."""
        return tuple(
            one
            for name in names
            for one, others in self._of.get(name, {name: sides}).items()
            if _agree(sides, others)
        )


class _NamesOnDemand(_Names):
    """Names of smooth modes that are made as runs come to them.

    Parameters
    ----------
    names : ModeNames
        Those of the smooth modes.
    count : int
        How many parts come before the divisions.
    combinations : callable
        The combinations of what comes before, by a mode's name.
    sides : callable
        The sides of a mode, by its name.
    """

    def __init__(
        self,
        names: ModeNames,
        combination: Callable[[str], Combination | None],
        sides: Callable[[str], Sequence[Sequence[int | None]]],
    ) -> None:
        self._names, self._combination, self._sides = names, combination, sides

    def name(self, mode: Mode, sides: Sides) -> str:
        """As in the base class."""
        return self._names.name_of((*(self._combination(mode.name) or ()), *_places(sides)))

    def targets(self, names: Sequence[str], sides: Sides) -> tuple[str, ...]:
        """As in the base class; of many the first, as the others follow by the conditions of regimes."""
        return tuple(islice((one for name in names for one in self._on(name, sides)), MOST_LISTED))

    def _on(self, name: str, sides: Sides) -> Iterator[str]:
        before = self._combination(name)
        if before is None:
            yield name  # which is refused as unknown
            return
        own = [
            [side] if side is not None and side in known else known
            for side, known in zip(sides, self._sides(name), strict=True)
        ]
        yield from (self._names.name_of((*before, *_places(one))) for one in product(*own))


def _places(sides: Sides) -> tuple[int, ...]:
    """Places among the regimes of divisions, of which the first stands for None."""
    return tuple(0 if side is None else side + 1 for side in sides)


def _on_demand(split: _Split, modes: Any, again: Any, origin: Any) -> ModesOnDemand:
    """Smooth modes, each made when a run first comes to it."""
    few = not isinstance(modes, ModesOnDemand)
    count, parts = (1, (tuple(map(_as_regime, modes)),)) if few else (len(modes.parts), modes.parts)
    places = {mode.name: (i,) for i, mode in enumerate(modes)} if few else {}
    every = tuple(tuple(range(len(one.borders) + 1)) for one in split.divisions)

    def whole(combination: Combination) -> Mode | None:
        return modes[combination[0]] if few else modes.mode(combination[:count])

    def sides_of(name: str) -> Sequence[Sequence[int | None]]:
        return split.sides(modes[places[name][0]]) if few else every

    def allows(combination: Combination) -> bool:
        sides = [place - 1 if place else None for place in combination[count:]]
        if few:
            return all(map(_contains, split.sides(modes[combination[0]]), sides))
        return None not in sides and modes.names.allows(combination[:count])

    def derive(combination: Combination) -> Mode:
        mode = whole(combination)
        assert mode is not None  # it is allowed
        sides = tuple(place - 1 if place else None for place in combination[count:])
        return split.smooth(mode, sides, names)

    smooth_parts = tuple(
        tuple(replace(one, conditions=_without_pieces(one.conditions)) for one in part) for part in parts
    )
    all_parts = (*smooth_parts, *map(_part, split.divisions))
    names_of_all, products = names_of_parts(all_parts, allows), () if few else modes.products
    on_demand = ModesOnDemand(all_parts, derive, names_of_all, again, origin, modes, products)
    names = _NamesOnDemand(on_demand.names, places.get if few else modes.names.combination_of, sides_of)
    for i, mode in enumerate(modes if few else ()):  # limit modes are tried in no other way
        for sides in product(*split.sides(mode)) if mode.limit else ():
            on_demand.mode((i, *_places(sides)))
    return on_demand


def _contains(sides: Sequence[Any], side: Any) -> bool:
    return side in sides


def _as_regime(mode: Mode) -> Regime:
    name = "" if mode.name == NO_PARTS else mode.name
    if mode.limit:  # a condition that never holds, as a limit mode is entered at an accumulation only
        return Regime(name, (sympy.S.NegativeOne,), mode.holds)
    held = [sign * one for one in mode.constraints for sign in (1, -1)]
    return Regime(name, (*(event.function for event in mode.events), *held), mode.holds)


def _part(division: Division) -> tuple[Regime, ...]:
    """The sides of a division as regimes, after one without a name: of a mode that does not depend on it."""
    sides = (
        Regime(name, _without_pieces([function for _, function, _ in division.bounds(side)]))
        for side, name in enumerate(division.names)
    )
    return (Regime(""), *sides)


def _without_pieces(conditions: Iterable[Any]) -> tuple[Any, ...]:
    return tuple(one for one in conditions if not has_pieces([one]))


def _equal(one: Any, other: Any) -> bool:
    return one == other or (_symbols(one) == _symbols(other) and multiply_out(one - other) == 0)


@lru_cache(maxsize=4096)
def _symbols(expression: Any) -> frozenset[Any]:
    """The free symbols: a table of n points has thousands of terms, and is asked at each of its borders."""
    return frozenset(expression.free_symbols)


@lru_cache(maxsize=4096)
def _parts(expression: Any) -> frozenset[Any]:
    """The functions in pieces of an expression, and of the factors of its matrix products."""
    if not hasattr(expression, "atoms"):
        return frozenset()
    found = _atoms(expression)
    products = {one.product for one in found if isinstance(one, MatrixRow)}
    own = (one for one in found if isinstance(one, Pieces))
    return frozenset(own).union(*map(_parts_of_product, products))


@lru_cache(maxsize=4096)
def _atoms(expression: Any) -> frozenset[Any]:
    return frozenset(expression.atoms(Pieces, MatrixRow))


@lru_cache(maxsize=4096)
def _parts_of_product(of: MatrixProduct) -> frozenset[Any]:
    return frozenset[Any]().union(*map(_parts, of.factors))


@lru_cache(maxsize=4096)
def _moves(part: Pieces, moving: frozenset[Any]) -> bool:
    """Whether any border of a function in pieces depends on the state."""
    return any(not moving.isdisjoint((part.x - border).free_symbols) for border in part.borders)


class _OnSides:
    """Expressions without functions in pieces, on some sides of divisions."""

    def __init__(self, moving: frozenset[Any], divisions: tuple[Division, ...], sides: Sides) -> None:
        self._moving = moving
        self._known = [(d, side) for d, side in zip(divisions, sides, strict=True) if side is not None]
        self._values: dict[Any, Any] = {}
        self._products: dict[MatrixProduct, MatrixProduct] = {}

    def __call__(self, expression: Any) -> Any:
        """The expression there."""
        if not _parts(expression):
            return expression
        atoms = _atoms(expression)
        return expression.xreplace(
            {one: self._row(one) if isinstance(one, MatrixRow) else self._value(one) for one in atoms}
        )

    def _row(self, row: MatrixRow) -> Any:
        if not _parts_of_product(row.product):
            return row
        if row.product not in self._products:
            self._products[row.product] = row.product.with_factors(map(self, row.product.factors))
        return self._products[row.product].row(row.index)

    def _value(self, part: Pieces) -> Any:
        if part not in self._values:
            self._values[part] = self._on_side(part) if _moves(part, self._moving) else self._by_numbers(part)
        return self._values[part]

    def _on_side(self, part: Pieces) -> Any:
        for division, side in self._known:
            if division.divides(part):
                return self(division.value(part, side))
        raise ValueError(
            f"the border {part.x} = {part.borders[0]} must be one of the model's, and is not: write the law "
            "in pieces of the coordinates and velocities that mechanics is given"
        )

    def _by_numbers(self, part: Pieces) -> Any:
        """A sum of all values times numbers, of which one is 1, the others 0."""
        if self._moving.isdisjoint(part.free_symbols):
            return self(part.as_known())
        units = [[int(i == k) for k in range(len(part.values))] for i in range(len(part.values))]
        holds = [Pieces(part.x, *part.borders, *unit) for unit in units]
        return sympy.Add(
            *(
                self(getattr(one, "as_known", lambda one=one: one)()) * self(value)
                for one, value in zip(holds, part.values)
            )
        )


def _on_sides(reset: Reset, value: Callable[[Any], Any]) -> Reset:
    if not has_pieces([*reset.jump.values(), *reset.vanishing]):
        return reset
    return Reset(
        {state: value(one) for state, one in reset.jump.items()},
        {value(one): count for one, count in reset.vanishing.items()},
    )
