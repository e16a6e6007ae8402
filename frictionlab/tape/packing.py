"""An automaton packed into arrays for the kernels: every mode's tape, guards, resets and sections.

The packing depends on the structure alone and is remembered; :meth:`Program.numbers` fills in parameter
values, which costs microseconds.  Part of the structure is which functions are zero by construction after an
event, and to which order: what the reset declares, the event function itself, and the constraints of the mode
that ends.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache, partial
from itertools import accumulate
from threading import Lock
from typing import Any
from weakref import WeakKeyDictionary, ref

import numpy as np

from frictionlab.automaton import Event, HybridAutomaton, Mode, Reset
from frictionlab.automaton.mode import Symbol
from frictionlab.automaton.modes_on_demand import Combination, KnownModes, ModesOnDemand
from frictionlab.lazy_names import sympy as sp
from frictionlab.tape.arguments import check_mode, check_structure
from frictionlab.tape.functions import AFFINE, POWER, QUOTIENT
from frictionlab.tape.lowering import (
    LoweredMode,
    LoweredReset,
    LoweredTape,
    int_array,
    lower_mode,
    lower_reset,
    number_formulas,
    slot_array,
    undefined_number,
)
from frictionlab.tape.program import (
    NO_RESET,
    Code,
    Demand,
    Numbers,
    Program,
    Section,
    kept_program,
    numbers_at,
)
from frictionlab.tape.structural_zeros import sign_normal_form, structural_zeros
from frictionlab.tape.tape import FIRST_SHARED, ProductTerms

NO_MODE = -1  # "no mode" in the arrays
_ONE_AT_A_TIME = Lock()


def program_of(
    automaton: HybridAutomaton,
    sections: Mapping[str, Section] | None = None,
    quadratures: Mapping[str, Any] | None = None,
    *,
    complete: bool = True,
) -> tuple[Program, Numbers]:
    """Program and numbers of an automaton; the program is remembered per structure.

    Of modes on demand, a `complete` program has all, in the automaton's order.  Otherwise it has those
    derived so far, in the order in which they were, or all where such a program is kept.

    Raises
    ------
    ValueError
        Where the automaton is not well formed: the message names the mode and what is missing.
    TapeError
        Where an expression needs an operation that the tape lacks.
    """
    derivations, on_demand = automaton.derivations, automaton.on_demand
    grows = on_demand and not complete
    if derivations is not None and grows == on_demand and not sections and not quadratures:
        with _ONE_AT_A_TIME:
            name = "program on demand" if on_demand else "program"
            program = kept_program(derivations, name, partial(_packed, automaton))
        return program, numbers_at(program, automaton.values.values())
    modes, parameters = automaton.modes, tuple(automaton.parameters)
    asked = (tuple((sections or {}).values()), tuple((quadratures or {}).items()))
    about = parameters, automaton.coordinates, *asked
    with _ONE_AT_A_TIME:  # else two threads might have two programs of one structure
        if grows:
            program = _growing_program(automaton.states, modes, *about).with_known_modes()
        else:
            program = pack_program(automaton.states, tuple(modes), *about)
    return program, numbers_at(program, automaton.parameters.values())


def _packed(automaton: HybridAutomaton) -> Program:
    modes, about = automaton.modes, (tuple(automaton.parameters), automaton.coordinates)
    if isinstance(modes, ModesOnDemand):
        return _pack_modes(automaton.states, modes, modes.all(), *about)
    return pack_program(automaton.states, modes, *about)


@lru_cache(maxsize=256)
def pack_program(
    states: tuple[Symbol, ...],
    modes: tuple[Mode, ...],
    parameters: tuple[Symbol, ...],
    coordinates: int,
    sections: tuple[Section, ...] = (),
    quadratures: tuple[tuple[str, Any], ...] = (),
) -> Program:
    """Lower every mode and reset to its tape and pack them."""
    check_structure(states, modes, parameters, coordinates)
    packer = Packer(states, sections, quadratures)
    for mode in modes:
        packer.add(mode)
    return packer.pack(parameters, coordinates)


def program_of_modes(automaton: HybridAutomaton, names: tuple[str, ...]) -> tuple[Program, Numbers]:
    """Program and numbers with these modes on demand, in this order, for runs from another process."""
    modes: Any = automaton.modes
    about = tuple(automaton.parameters), automaton.coordinates
    with _ONE_AT_A_TIME:
        program = _pack_modes(automaton.states, modes, modes.chosen(names), *about)
    return program, program.numbers(tuple(automaton.parameters.values()))


@lru_cache(maxsize=64)
def _pack_modes(
    states: tuple[Symbol, ...],
    modes: ModesOnDemand,
    known: KnownModes,
    parameters: tuple[Symbol, ...],
    coordinates: int,
) -> Program:
    packer, sound = Packer(states, (), (), modes), dict[int, Any]()
    for mode in known.modes:
        check_mode(mode, modes.names, states, frozenset((*states, *parameters)), sound)
        packer.add(mode)
    return packer.pack(parameters, coordinates, known)


@lru_cache(maxsize=64)
def _growing_program(states: tuple[Symbol, ...], modes: ModesOnDemand, *about: Any) -> _GrowingProgram:
    return _GrowingProgram(states, modes, *about)


class _GrowingProgram:
    """The program of modes that are derived on demand, to which modes are added as they are derived."""

    def __init__(
        self,
        states: tuple[Symbol, ...],
        modes: ModesOnDemand,
        parameters: tuple[Symbol, ...],
        coordinates: int,
        sections: tuple[Section, ...],
        quadratures: tuple[tuple[str, Any], ...],
    ) -> None:
        self._modes, self._parameters, self._coordinates = modes, parameters, coordinates
        self._states, self._packer = states, Packer(states, sections, quadratures, modes)
        self._known, self._sound = frozenset((*states, *parameters)), dict[int, Any]()
        self._packed: tuple[tuple[int, int], Program | None] = (0, 0), None

    def with_known_modes(self) -> Program:
        """The program of all modes that are derived by now."""
        known = self._modes.known()
        counts = len(known.modes), len(known.refused)
        before, program = self._packed
        if program is None or counts != before:
            for mode in known.modes[len(self._packer.modes) :]:
                check_mode(mode, self._modes.names, self._states, self._known, self._sound)
                self._packer.add(mode)
            program = self._packer.pack(self._parameters, self._coordinates, known)
            program = replace(program, grown_from=None if self._packed[1] is None else ref(self._packed[1]))
            self._packed = counts, program
        return program


class GrowingArray:
    """An array of integers to which others are appended; arrays that it has given stay as they are.

    Programs that grow by one mode at a time share it, as a copy for each would fragment the memory.
    """

    def __init__(self, first: Sequence[int] = ()) -> None:
        self._room, self.length = np.zeros(1024, dtype=np.int64), 0
        self.extend(first)

    def extend(self, values: Sequence[int]) -> None:
        """Append integers."""
        end = self.length + len(values)
        if end > len(self._room):
            self._room = np.concatenate([self._room, np.zeros(max(end, len(self._room)), dtype=np.int64)])
        self._room[self.length : end] = values
        self.length = end

    @property
    def array(self) -> np.ndarray:
        """The integers so far."""
        return self._room[: self.length]


def shared_ranges(ops: np.ndarray) -> np.ndarray:
    """Which operations (operations, 3) have ranges of the terms of products."""
    return (ops[:, 0] == AFFINE) & (ops[:, 1] >= FIRST_SHARED)


class SharedTerms:
    """Terms of products of matrices, once for all tapes on which their factors have the same slots."""

    def __init__(self) -> None:
        self.slots, self.coefficients = np.zeros(0, dtype=np.uint32), np.zeros(0)
        self._places: dict[tuple[int, bytes], int] = {}
        self._placed: WeakKeyDictionary[LoweredTape, np.ndarray] = WeakKeyDictionary()

    def ops_of(self, lowered: LoweredTape) -> np.ndarray:
        """The operations of a tape, with ranges of the terms of its products as these are numbered here."""
        if not lowered.tape.products:
            return lowered.ops
        if lowered not in self._placed:
            ops = lowered.ops.copy()
            self._place_ranges(ops, shared_ranges(ops), lowered.tape.products)
            self._placed[lowered] = ops
        return self._placed[lowered]

    def _place_ranges(self, ops: np.ndarray, shared: np.ndarray, products: Sequence[ProductTerms]) -> None:
        before = FIRST_SHARED
        ranges = ops[shared, 1:].copy()
        for one in products:
            product, slots = one.product, one.slots
            inside = (ranges[:, 0] >= before) & (ranges[:, 0] < before + len(slots))
            moved = ranges[inside] - np.uint32(before - FIRST_SHARED) + np.uint32(self._place(product, slots))
            ops[np.flatnonzero(shared)[inside], 1:] = moved
            before += len(slots)

    def _place(self, product: Any, slots: np.ndarray) -> int:
        key = product.number, slots.tobytes()
        if key not in self._places:
            self._places[key] = len(self.slots)
            self.slots = np.concatenate([self.slots, slots])
            self.coefficients = np.concatenate([self.coefficients, product.entries])
        return self._places[key]


class Packer:
    """Collects the arrays of a :class:`Program`, mode by mode."""

    def __init__(
        self,
        states: tuple[Symbol, ...],
        sections: tuple[Section, ...],
        quadratures: tuple[tuple[str, Any], ...],
        demand: ModesOnDemand | None = None,
    ) -> None:
        self.sections, self.demand = sections, demand
        self.integrands = tuple(expr for _, expr in quadratures)
        self.physical = states
        self.states = (*states, *(sp.Symbol(f"integral of {name}") for name, _ in quadratures))
        self.modes: list[Mode] = []
        self.lowered: list[LoweredMode] = []
        self.resets: list[LoweredReset] = []
        self.event_resets: list[list[int]] = []
        self.classes: dict[Any, int] = {}  # numbers of classes of functions, by `sign_normal_form`
        self.guard_classes: list[int] = []
        self.constraint_classes: list[int] = []
        self.zeros = GrowingArray([0])  # for both resets of each event, where its part of these ends:
        self.zero_classes = GrowingArray()  # classes of functions that are zero after the reset,
        self.zero_counts = GrowingArray()  # and how many leading coefficients of each are zero
        self.listed: list[Combination] = []  # the targets of all events, where modes are on demand,
        self.listed_lengths: list[int] = []  # and how many each event has
        self.products = SharedTerms()
        self._reset_numbers: dict[int, int] = {}  # by the identity of the jumps
        self._conditions: Mode | None = None

    def add(self, mode: Mode) -> None:
        """Append a mode."""
        self.modes.append(mode)
        self.lowered.append(
            lower_mode(mode, self.states, self.sections, self.integrands, self._common_products)
        )
        self.guard_classes += [self._class(event.function) for event in mode.events]
        self.constraint_classes += map(self._class, mode.constraints)
        for event in mode.events:
            self._add_event(mode, event)

    @property
    def _common_products(self) -> tuple[Any, ...]:
        return () if self.demand is None else self.demand.products

    def _add_event(self, mode: Mode, event: Event) -> None:
        plain = self._reset(event.reset)
        closing = event.accumulation or event.reset
        self.event_resets.append([plain, plain if event.accumulation is None else self._reset(closing)])
        for reset in (event.reset, closing):
            zeros = structural_zeros(mode, event, reset)
            self.zero_classes.extend([self._number_of_class(function) for function in zeros])
            self.zero_counts.extend(list(zeros.values()))
            self.zeros.extend([self.zero_counts.length])
        if self.demand is not None:
            self.listed += filter(None, map(self.demand.names.combination_of, event.targets))
            self.listed_lengths.append(len(event.targets))

    def _class(self, function: Any) -> int:
        return self._number_of_class(sign_normal_form(function))

    def _number_of_class(self, normal_form: Any) -> int:
        return self.classes.setdefault(normal_form, len(self.classes))

    def _reset(self, reset: Reset) -> int:
        if not reset.jump:
            return NO_RESET
        # Modes on demand have many resets in common; elsewhere each event has its own.
        number = self._reset_numbers.get(id(reset.jump)) if self.demand is not None else None
        if number is None:
            number = self._reset_numbers[id(reset.jump)] = len(self.resets)
            self.resets.append(lower_reset(reset, self.states))
        return number

    def _conditions_mode(self, modes: ModesOnDemand) -> Mode:
        """A mode that stands for those not derived; its constraints are the conditions of all regimes."""
        if self._conditions is None:
            every = (condition for part in modes.parts for regime in part for condition in regime.conditions)
            self._conditions = Mode("", (sp.S.Zero,) * len(self.states), constraints=tuple(every))
        return self._conditions

    def pack(
        self, parameters: tuple[Symbol, ...], coordinates: int, known: KnownModes | None = None
    ) -> Program:
        """The program of the modes so far; where modes are on demand, with what is `known` of the others."""
        lowered, constraint_classes, demand = self.lowered, self.constraint_classes, None
        if self.demand is not None and known is not None:
            conditions = self._conditions_mode(self.demand)
            lowered = [*lowered, lower_mode(conditions, self.states, (), (), self._common_products)]
            constraint_classes = [*constraint_classes, *map(self._class, conditions.constraints)]
            targets = int_array(self.listed, columns=len(self.demand.parts))
            demand = _demand_arrays(self.demand, known, _ranges(self.listed_lengths), targets)
        names = tuple(mode.name for mode in self.modes)
        initial = [i for i, mode in enumerate(self.modes) if not mode.limit] if known is None else []
        classes = int_array([*self.guard_classes, *constraint_classes])
        code = self._code(lowered, coordinates, initial)._replace(function_classes=classes)
        every: list[LoweredTape] = [*lowered, *self.resets]
        guards = tuple(event.name for mode in self.modes for event in mode.events)
        guard_modes = int_array([i for i, mode in enumerate(self.modes) for _ in mode.events])
        return Program(
            code,
            tuple(one.tape for one in lowered),
            tuple(one.tape for one in self.resets),
            max(one.tape.slots for one in every),
            names,
            guards,
            guard_modes,
            int_array(initial),
            number_formulas(parameters).of(every),
            partial(undefined_number, parameters, tuple(every)),
            demand,
            self.products.coefficients,
        )

    def _code(self, lowered: Sequence[LoweredMode], coordinates: int, initial: Sequence[int]) -> Code:
        every: list[LoweredTape] = [*lowered, *self.resets]
        inputs, count = len(self.states), len(lowered)
        guards, mode_ops = sum(len(one.guards) for one in lowered), sum(len(one.tape.ops) for one in lowered)
        sections = [one.sections or [0] * len(self.sections) for one in lowered]
        return Code(
            inputs=inputs,
            ops=self._ops(every),
            term_slots=_joined([*(one.term_slots for one in every), self.products.slots], np.uint32),
            mode_ops=_ranges([len(one.tape.ops) for one in lowered]),
            flow=np.array([one.flow_slots for one in lowered]),
            mode_guards=_ranges([len(one.guards) for one in lowered]),
            mode_constraints=_ranges([len(one.constraints) for one in lowered], start=guards),
            function_slots=_joined(
                [*(one.guard_slots for one in lowered), *(one.constraint_slots for one in lowered)], np.uint32
            ),
            targets=self._targets(initial),
            limits=int_array([i for i, mode in enumerate(self.modes) if mode.limit]),
            resets=int_array(self.event_resets, columns=2),
            function_classes=int_array([]),
            zeros=self.zeros.array,
            zero_classes=self.zero_classes.array,
            zero_counts=self.zero_counts.array,
            reset_ops=_ranges([len(one.tape.ops) for one in self.resets], start=mode_ops),
            reset_out=np.array([one.out_slots for one in self.resets], np.uint32).reshape(-1, inputs),
            sections=slot_array(sections, columns=len(self.sections)),
            directions=int_array([section.direction for section in self.sections]),
            native=np.zeros(count, dtype=np.int64),
            lanes=np.zeros(count, dtype=np.int64),
            built=int_array([i < len(self.modes) for i in range(count)]),
            powers=int_array([one.has(POWER) for one in lowered]),
            quotients=int_array([one.has(QUOTIENT) for one in lowered]),
            degrees=int_array([one.degree for one in lowered]),
            ranges=_joined([one.ranges[inputs:] for one in lowered], np.int64),
            state_ranges=np.array([one.ranges[:inputs] for one in lowered]),
            polynomial=_joined([one.polynomial[inputs:] for one in lowered], np.int64),
            polynomial_degrees=int_array([one.polynomial_degree for one in lowered]),
            guard_degrees=_joined([one.guard_degrees for one in lowered], np.int64),
            groups=int_array([0, coordinates, 2 * coordinates, len(self.physical)]),
        )

    def _ops(self, every: Sequence[LoweredTape]) -> np.ndarray:
        """All operations in one array; ranges of terms are shifted to their places among all terms."""
        every_ops = (self.products.ops_of(one) for one in every)
        ops = np.concatenate([np.zeros((0, 3), dtype=np.uint32), *every_ops])
        lengths = [len(one.tape.ops) for one in every]
        counts = [len(one.tape.terms) for one in every]
        first = [0, *accumulate(counts)][:-1]
        shift = np.repeat(np.array(first, dtype=np.uint32), lengths)
        shared = shared_ranges(ops)
        own = (ops[:, 0] == AFFINE) & ~shared
        ops[own, 1:] += shift[own, None]
        ops[shared, 1:] -= np.uint32(FIRST_SHARED - sum(counts))
        return ops

    def _targets(self, initial: Sequence[int]) -> np.ndarray:
        """For each event its targets, then all others but limit modes; empty where modes are on demand.

        Only events of limit modes may lead to one.  Rows are filled up by their first mode, tried already.
        """
        if not initial:
            return np.zeros((len(self.event_resets), 0), dtype=np.int64)
        places, tried = {mode.name: i for i, mode in enumerate(self.modes)}, {*initial}
        rows = []
        for mode in self.modes:
            for event in mode.events:
                named = [places[name] for name in event.targets]
                rows.append([*dict.fromkeys([i for i in named if mode.limit or i in tried] + [*initial])])
        columns = max(map(len, rows), default=len(initial))
        return int_array([row + row[:1] * (columns - len(row)) for row in rows], columns=columns)


def _demand_arrays(
    modes: ModesOnDemand, known: KnownModes, listed: np.ndarray, targets: np.ndarray
) -> Demand:
    """What kernels have to know of modes that are not derived."""
    parts = len(modes.parts)
    numbers = [*range(len(known.modes)), *(NO_MODE for _ in known.refused)]
    conditions = [len(regime.conditions) for part in modes.parts for regime in part]
    return Demand(
        regimes=_ranges([len(part) for part in modes.parts]),
        conditions=_ranges(conditions),
        combinations=int_array([*known.combinations, *known.refused], columns=parts),
        modes=int_array(numbers),
        listed=listed,
        targets=targets,
    )


def _joined(arrays: Sequence[np.ndarray], kind: type) -> np.ndarray:
    return np.concatenate([np.zeros(0, dtype=kind), *arrays])


def _ranges(lengths: Sequence[int], start: int = 0) -> np.ndarray:
    return start + np.concatenate([[0], np.cumsum(lengths, dtype=np.int64)]).astype(np.int64)
