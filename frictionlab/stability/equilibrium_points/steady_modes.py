"""The modes in which equilibria are searched for: the flow of each, its conditions and its outputs.

All are functions of the states and the parameters.  For models of the library they are kept in files, so that
sympy is not needed to find their equilibria again.  In an automaton all modes are searched.  In a model only
those are whose constraints give states, as those of rigid contacts do: in stick every position within the
friction cone is an equilibrium.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache, reduce
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionlab.automaton import HybridAutomaton, Mode
from frictionlab.automaton.modes_on_demand import NO_PARTS, ModeNames, ModesOnDemand, Regime
from frictionlab.lazy_names import sympy
from frictionlab.models.kept_structures import Derivations
from frictionlab.stability.equilibrium_points.borders import distances_from_borders
from frictionlab.stability.equilibrium_points.newton import (
    SAME_CANDIDATE_RTOL,
    Zeros,
    distinct_zeros,
    find_zeros,
)
from frictionlab.stability.equilibrium_points.steady_rates import (
    SteadyRates,
    clocks_of,
    is_free,
    states_by_constraints,
    static_rates,
    steady_rates,
)
from frictionlab.stability.flow import Flow
from frictionlab.stability.state_matrices import null_vector
from frictionlab.tape.formulas import Formulas, formulas_of, kept_formulas

Array = NDArray[np.float64]
MOST_MODES = 27  # in which equilibria are searched for: those of three contacts
LEAST_SLOPE = 1e-8  # of distances by the coordinates that they give, as a share of that by all
LINE_SHARES = 0.47, 1.0  # of the distance: at a round one alone another equilibrium may be
LINE_ROUNDING = 1e-12  # share of its terms by which a rate that is zero on a line may come out otherwise
CONSTRAINT_RTOL = 1e-9  # share of its terms to which a constraint has to hold at an equilibrium
# what an equilibrium shows, and the outputs that have it: F_N of a rigid contact is its reaction
SHOWN = ("penetration",), ("normal_force", "reaction"), ("friction_force",)


@dataclass(frozen=True)
class SteadyMode:
    """A mode in which equilibria are searched for, as functions of the states, then the parameters.

    Parameters
    ----------
    structure : hashable
        What is cached on disk of a model's structure, whose modes are derived only if they are not there; of
        an automaton that is nowhere on disk the mode itself, with all that its functions depend on.
    name : str
    automaton : HybridAutomaton
        Any of that structure, whatever its values.
    preferred : tuple of int
        Places of coordinates that distances of zero give, if they can.
    idle : tuple of int
        Places of the phase and the time where these move nothing, or stand; they count as zero.
    """

    structure: Any
    name: str
    automaton: HybridAutomaton = field(compare=False)
    preferred: tuple[int, ...] = ()
    idle: tuple[int, ...] = ()

    @property
    def in_words(self) -> str:
        """Its name; but "only" would read as an adverb."""
        return "its only mode" if self.name == NO_PARTS else self.name

    def derive(self) -> Mode:
        """The mode."""
        return self.automaton.mode(self.name)

    @cached_property
    def derivations(self) -> Derivations:
        """What is cached on disk of its structure."""
        return self.structure if isinstance(self.structure, Derivations) else Derivations(None)

    @cached_property
    def flow(self) -> Flow:
        """Its flow, with the margins that have to stay positive: event functions and normal force."""
        rates = self._formulas(f"rates{self._choice}", lambda mode: self._steady_rates(mode).rates)
        return Flow(tuple(self.automaton.values), rates, self._formulas("margins", _margins))

    @cached_property
    def statics(self) -> Flow:
        """What is zero at the equilibria, of the states and the reactions of rigid contacts; the flow itself
        where no balance of forces is known."""

        def rates(mode: Mode) -> Sequence[Any]:
            balances = mode.balance and is_free(self.automaton, mode)
            return static_rates(self.automaton, mode, self.idle) if balances else ()

        balance = self._formulas(f"statics{self._without_idle}", rates, _reactions)
        if not balance.outputs:
            return self.flow
        return Flow(tuple(self.automaton.values), balance, self._formulas("limits", _margins, _reactions))

    @cached_property
    def following(self) -> tuple[int, ...]:
        """Places of states that follow from the others where the motion is steady; see `SteadyRates`."""
        name = f"following states{self._choice} in {self.name}"
        return tuple(self.derivations.value(name, lambda: self._steady_rates(self.derive()).following))

    @cached_property
    def holds(self) -> bool:
        """Whether it has constraints that give no states; those on disk have none."""
        if self.derivations is self.structure:
            return False
        return bool(states_by_constraints(self.automaton, self.derive()).remainder)

    def _steady_rates(self, mode: Mode) -> SteadyRates:
        return steady_rates(self.automaton, mode, self.preferred, self.idle)

    @property
    def _choice(self) -> str:
        by = f" by {self.preferred}" if self.preferred else ""
        return by + self._without_idle

    @property
    def _without_idle(self) -> str:
        return f" without {self.idle}" if self.idle else ""

    def without_idle_clocks(self, values: Sequence[float]) -> SteadyMode:
        """The mode with the clocks at zero that are idle for values of the parameters."""
        idle = tuple(place for place in clocks_of(self.automaton) if self._is_idle(place, values).all())
        return _known(replace(self, idle=idle)) if idle else self

    def _is_idle(self, clock: int, values: Sequence[Any]) -> NDArray[np.bool_]:
        """Whether a clock (its place) does not run, or moves nothing, for values of the parameters."""

        def functions(mode: Mode) -> Sequence[Any]:
            others = (*mode.flow[:clock], *mode.flow[clock + 1 :], *mode.constraints)
            moved = {self.automaton.states[clock]}  # what sets the clock back says nothing of the others
            guards = replace(mode, events=tuple(one for one in mode.events if {*one.reset.jump} != moved))
            return (mode.flow[clock], *others, *_margins(guards))

        formulas, count = self._formulas(f"moved by {clock}", functions), len(self.automaton.state_names)
        if formulas.dependences[0] & {*range(count)}:
            return np.array(False)  # a further state of that name
        stands = np.equal(formulas.arrays(*np.zeros(count), *values)[0], 0.0)
        moved = reduce(np.logical_or, formulas.moved_by(clock, *[None] * count, *values))
        return np.logical_or(stands, np.logical_not(moved))

    def regular_at(self, x: Array, values: Sequence[float]) -> SteadyMode:
        """The mode with distances that give other coordinates, where slopes by the first ones vanish at x."""
        m, n = len(x), self.automaton.coordinates
        by_distances = [place for place in self.following if place < n and place + n in self.following]
        distances = Formulas(self.statics.rates.tape, self.statics.rates.outputs[m:])
        if not by_distances or not distances.outputs:
            return self
        places, formulas = distances.jacobian(range(m))
        slopes = formulas.arrays(*x, *np.zeros(len(distances.outputs)), *values)
        matrix = np.zeros((len(distances.outputs), m))
        for place, slope in zip(places, slopes, strict=True):
            matrix[place] = slope
        own, all_ = (np.linalg.svd(some, compute_uv=False)[-1] for some in (matrix[:, by_distances], matrix))
        if own > LEAST_SLOPE * all_:
            return self
        pivots = []
        for i, row in enumerate(matrix):
            pivots.append(int(np.abs(row).argmax()))
            matrix[i + 1 :] -= np.outer(matrix[i + 1 :, pivots[-1]] / row[pivots[-1]], row)
        return _known(replace(self, preferred=tuple(pivots)))

    @property
    def guards(self) -> Formulas:
        """The event functions, and the distances from borders of laws in pieces."""

        def guards(mode: Mode) -> list[Any]:
            borders = distances_from_borders(self.automaton.states, [*mode.flow, *mode.outputs.values()])
            return [*(event.function for event in mode.events), *borders]

        return self._formulas("guards", guards)

    def shown(self, x: Array, values: Sequence[float]) -> tuple[float, ...]:
        """The outputs `SHOWN` at a state (m,); NaN where the mode has no such output."""

        def outputs(mode: Mode) -> list[Any]:
            of_mode = mode.outputs
            return [next((of_mode[name] for name in names if name in of_mode), sympy.nan) for names in SHOWN]

        return tuple(map(float, self._formulas("shown", outputs).arrays(*x, *values)))

    def admits(self, x: Array, values: Sequence[Any]) -> Any:
        """At which states (m, N) the mode can last: inside its guards, and with its constraints satisfied."""
        with np.errstate(all="ignore"):
            lasts = self.flow.margin(x, values) > 0
            for clock in self.idle:
                lasts = lasts & self._is_idle(clock, values)
            if self.holds:
                for constraint, size in zip(*self._constraints(x, values), strict=True):
                    lasts = lasts & (np.abs(constraint) <= CONSTRAINT_RTOL * size)
        return lasts

    def _constraints(self, x: Array, values: Sequence[Any]) -> tuple[list[Any], Array]:
        """The constraints at states (m, N), and the sizes of the terms that cancel in each."""
        formulas = self._formulas("constraints", lambda mode: mode.constraints)
        places, slopes = formulas.jacobian(range(len(x)))
        sizes = np.zeros((len(formulas.outputs), *np.shape(x[0])))
        sizes += np.abs(np.array(formulas.arrays(*np.zeros(len(x)), *values))).reshape(
            -1, *[1] * (x.ndim - 1)
        )
        for (row, column), slope in zip(places, slopes.arrays(*x, *values), strict=True):
            sizes[row] += np.abs(slope * x[column])
        return formulas.arrays(*x, *values), sizes

    def equilibria_with(self, held: tuple[int, ...], values: tuple[float, ...]) -> Array:
        """Equilibria (m, K) inside its guards of the other states, with some (their places) held at zero."""
        points = _zeros_of_mode(_known(replace(self, idle=(*self.idle, *held))), values).points
        return points[:, self.admits(points, values)]

    def can_last_at_rest(self, values: Sequence[float]) -> bool:
        """Whether its conditions can hold at zero velocities: not in slip against a running belt."""

        def conditions(mode: Mode) -> list[Any]:
            return _without_states(self.automaton, [event.function for event in mode.events])

        zeros = np.zeros(len(self.automaton.state_names))
        formulas = self._formulas("at rest", conditions)
        return not any(value < 0 for value in formulas.arrays(*zeros, *values))

    def _formulas(
        self,
        name: str,
        expressions: Callable[[Mode], Sequence[Any]],
        reactions: Callable[[Mode], Sequence[Any]] = lambda _: (),
    ) -> Formulas:
        def derive() -> Formulas:
            mode, automaton = self.derive(), self.automaton
            return formulas_of(
                (*automaton.states, *reactions(mode), *automaton.parameters), [*expressions(mode)]
            )

        return kept_formulas(self.derivations, f"{name} in {self.name}", derive)


@lru_cache(maxsize=256)
def _known(mode: SteadyMode) -> SteadyMode:
    """The first of modes that are equal, with the functions that it has derived."""
    return mode


def steady_modes(automaton: HybridAutomaton, sliding: bool) -> Iterator[SteadyMode]:
    """The modes in which equilibria are searched for, derived one by one.

    For a model (`sliding`) those without stick; see `is_free`.
    """
    derivations = automaton.derivations
    if sliding and derivations is not None:
        modes = _cached_modes(automaton, derivations)
    else:
        modes = (_derived_mode(automaton, mode) for mode in _modes(automaton, sliding))
    values = parameter_values(automaton)
    lasting = (mode for mode in modes if mode.can_last_at_rest(values))
    return (mode.without_idle_clocks(values) for mode in lasting) if sliding else lasting


def parameter_values(automaton: HybridAutomaton) -> tuple[float, ...]:
    """The parameters' values."""
    return tuple(float(value) for value in automaton.values.values())


@dataclass(frozen=True)
class SearchKey:
    """The key under which equilibria of an automaton are cached: equal for equal structures and values.

    Parameters
    ----------
    structure : hashable
    values : tuple of float
    sliding : bool
    automaton : HybridAutomaton
    """

    structure: Any
    values: tuple[float, ...]
    sliding: bool
    automaton: HybridAutomaton = field(compare=False)


class ModeEquilibria(NamedTuple):
    """The equilibria of a mode.

    Parameters
    ----------
    mode : SteadyMode
    points : array (m, K)
        Those inside its guards.
    why : str
        In which mode, this or one searched before, others cannot be excluded, and why; empty if in none.
    """

    mode: SteadyMode
    points: Array
    why: str


def first_mode_equilibria(automaton: HybridAutomaton, sliding: bool) -> ModeEquilibria:
    """The equilibria of the first mode that has any inside its guards; if none has, of the last searched."""
    return _search(_search_key(automaton, sliding), True)[-1]


def all_mode_equilibria(automaton: HybridAutomaton, sliding: bool) -> tuple[ModeEquilibria, ...]:
    """The equilibria of each mode; where there are many modes, up to the first that has any."""
    return _search(_search_key(automaton, sliding), has_many_modes(automaton))


def has_many_modes(automaton: HybridAutomaton) -> bool:
    """Whether equilibria are searched for only up to the first mode that has any."""
    return isinstance(automaton.names, ModeNames) and automaton.names.more_than(MOST_MODES)


def _search_key(automaton: HybridAutomaton, sliding: bool) -> SearchKey:
    structure = automaton.derivations if sliding else None
    if structure is None:
        structure = automaton.modes, automaton.states, tuple(automaton.parameters), automaton.coordinates
    return SearchKey(structure, parameter_values(automaton), sliding, automaton)


@lru_cache(maxsize=64)
def _search(key: SearchKey, first: bool) -> tuple[ModeEquilibria, ...]:
    """The equilibria of the modes, one at least, until the first that has any or of all; cached, since one
    analysis asks for them several times.
    """
    automaton, why, searched = key.automaton, "", []
    for mode in steady_modes(automaton, key.sliding):
        points = np.zeros((len(automaton.state_names), 0))
        if not mode.holds or _allows_rest(automaton, mode.derive()):
            zeros = _zeros_of_mode(mode, key.values)
            why = why or (f"in {mode.in_words} {zeros.why}" if zeros.why else "")
            points = zeros.points[:, mode.admits(zeros.points, key.values)]
            if any(_is_of_line(mode.flow, x, key.values) for x in points.T):
                why = why or f"in {mode.in_words} one is of a line of equilibria"
                points = _one_of_each_line(mode.flow, points, key.values)
        searched.append(ModeEquilibria(mode, points, why))
        if points.size and first:
            break
    if not searched:
        mode = _derived_mode(automaton, automaton.modes[0])
        searched.append(ModeEquilibria(mode, np.zeros((len(automaton.state_names), 0)), why))
    return tuple(searched)


def _is_of_line(flow: Flow, x: Array, values: Sequence[float]) -> bool:
    """Whether equilibria lie beside x (m,) on a straight line, as with a deflection that rests anywhere.

    They are looked for as far from x as x is from the origin.  At the origin itself nothing gives a scale,
    and it is 1: rates are compared with their terms, and of powers that ratio depends on no unit.
    """
    with np.errstate(all="ignore"):
        along = null_vector(flow.jacobian(x, values))
        if along is None:
            return False
        away = along * (float(np.abs(x).max()) or 1.0) / np.abs(along).max()
        return all(_is_zero(flow, x + share * away, values) for share in LINE_SHARES)


def _one_of_each_line(flow: Flow, points: Array, values: Sequence[float]) -> Array:
    """Equilibria (m, K) without those that a straight line of equilibria joins with one before them.

    Where a law underflows to zero, as exp(-x) does beyond 745, each state that the search tries is one.
    """
    first: list[int] = []
    singular = [null_vector(flow.jacobian(x, values)) is not None for x in points.T]
    for i, x in enumerate(points.T):
        ways = [LINE_SHARES[0] * (points[:, j] - x) for j in first if singular[i] and singular[j]]
        if not any(_is_zero(flow, x + way, values) for way in ways):
            first.append(i)
    return points[:, first]


def _is_zero(flow: Flow, x: Array, values: Sequence[float]) -> bool:
    """Whether the rates at x (m,) are rounding of their terms."""
    terms = np.abs(flow.jacobian(x, values)) @ np.abs(x)
    return bool((np.abs(flow.rhs(x, values)) <= LINE_ROUNDING * terms).all())


@lru_cache(maxsize=256)
def _zeros_of_mode(mode: SteadyMode, values: tuple[float, ...]) -> Zeros:
    """The zeros of a mode's flow, inside its guards or not."""
    zeros, m = find_zeros(mode.statics, values), len(mode.automaton.state_names)
    if len(zeros.points) == m:
        return zeros
    states = zeros.points[:m]  # their distances from the origin are without the reactions
    return Zeros(distinct_zeros(states, SAME_CANDIDATE_RTOL * np.abs(states)), zeros.why)


def _cached_modes(automaton: HybridAutomaton, derivations: Derivations) -> Iterator[SteadyMode]:
    names = derivations.value(
        "steady modes", lambda: [m.name for m in automaton.modes if is_free(automaton, m)]
    )
    return (_known(SteadyMode(derivations, name, automaton)) for name in names)


def _derived_mode(automaton: HybridAutomaton, mode: Mode) -> SteadyMode:
    structure = mode, automaton.states, tuple(automaton.parameters), automaton.coordinates, automaton.cyclic
    return _known(SteadyMode(structure, mode.name, automaton))


def _reactions(mode: Mode) -> Sequence[Any]:
    return mode.balance.reactions if mode.balance else ()


def _modes(automaton: HybridAutomaton, sliding: bool) -> Iterator[Mode]:
    if isinstance(automaton.modes, ModesOnDemand):
        modes: Iterable[Mode] = automaton.modes.select(
            lambda regime: not (sliding and regime.sticks) and _can_rest(automaton, regime)
        )
    else:
        modes = automaton.modes
    return (mode for mode in modes if not sliding or is_free(automaton, mode))


def _margins(mode: Mode) -> tuple[Any, ...]:
    margins = [event.function for event in mode.events]
    margins += [mode.outputs["normal_force"]] if "normal_force" in mode.outputs else []
    return tuple(margins)


def _allows_rest(automaton: HybridAutomaton, mode: Mode) -> bool:
    """Whether a mode's constraints can hold at zero velocities: not in stick on a running belt."""
    return all(c == 0 for c in _constants_at_rest(automaton, mode.constraints))


def _can_rest(automaton: HybridAutomaton, regime: Regime) -> bool:
    """Whether a regime's conditions can hold at zero velocities, not in slip against a running belt; and its
    states rest, not in stick of a spring on such a belt."""
    moving = any(rate != 0 for rate in _constants_at_rest(automaton, regime.rates))
    return not moving and not any(c < 0 for c in _constants_at_rest(automaton, regime.conditions))


def _constants_at_rest(automaton: HybridAutomaton, functions: Sequence[Any]) -> list[Any]:
    """The values at zero velocities of those functions that do not depend on other states."""
    return [c.subs(automaton.parameters) for c in _without_states(automaton, functions)]


def _without_states(automaton: HybridAutomaton, functions: Sequence[Any]) -> list[Any]:
    """Functions at zero velocities, of coordinates that do not turn, those that depend on no other state."""
    n = automaton.coordinates
    pairs = zip(automaton.state_names, automaton.states[n : 2 * n])
    at_rest = {rate: 0 for name, rate in pairs if name not in automaton.cyclic}
    held = [sympy.sympify(c, strict=True).subs(at_rest) for c in functions]
    return [c for c in held if not c.free_symbols & set(automaton.states)]
