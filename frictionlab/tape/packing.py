"""An automaton packed into arrays for the kernels: every mode's tape, guards, resets and sections.

The packing depends on the structure alone and is remembered; :meth:`Program.numbers` fills in parameter
values, which costs microseconds.  Part of the structure is which functions are zero by construction after an
event, and to which order: what the reset declares, the event function itself, and the constraints of the mode
that ends.
"""

from __future__ import annotations

from array import array
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache, partial
from itertools import accumulate
from threading import Lock
from typing import Any
from weakref import ref

import numpy as np

from frictionlab.automaton import Event, HybridAutomaton, Mode, Reset
from frictionlab.automaton.mode import Symbol
from frictionlab.automaton.modes_on_demand import Combination, KnownModes, ModesOnDemand
from frictionlab.lazy_names import sympy as sp
from frictionlab.tape.arguments import check_mode, check_structure
from frictionlab.tape.functions import AFFINE, POWER, QUOTIENT
from frictionlab.tape.lowering import (
    LoweredMode,
    LoweredTape,
    NumberPlaces,
    int_array,
    lower_mode,
    lower_reset,
    slot_array,
    undefined_number,
)
from frictionlab.tape.panels import ROWS, panels_of
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
from frictionlab.tape.tape import FIRST_SHARED, Tape

NO_MODE = -1  # "no mode" in the arrays
_ONE_AT_A_TIME = Lock()


def program_of(
    automaton: HybridAutomaton,
    sections: Mapping[str, Section] | None = None,
    quadratures: Mapping[str, Any] | None = None,
    *,
    complete: bool = True,
    combinations: Sequence[Combination] = (),
) -> tuple[Program, Numbers]:
    """Program and numbers of an automaton; the program is remembered per structure.

    Of modes on demand, a `complete` program has all, in the automaton's order.  Otherwise it has those
    derived so far, in the order in which they were, or all where such a program is kept.  One with sections
    or quadratures then has those of `combinations`, and those for which it was asked before.

    Raises
    ------
    ValueError
        Where the automaton is not well formed: the message names the mode and what is missing.
    TapeError
        Where an expression needs an operation that the tape lacks.
    """
    values = array("d", automaton.values.values()).tobytes()
    derivations, on_demand = automaton.derivations, automaton.on_demand
    grows = on_demand and not complete
    if derivations is not None and grows == on_demand and not sections and not quadratures:
        with _ONE_AT_A_TIME:
            name = "program on demand" if on_demand else "program"
            program = kept_program(derivations, name, partial(_packed, automaton))
        return program, numbers_at(program, values)
    modes, parameters = automaton.modes, tuple(automaton.parameters)
    functions = (tuple((sections or {}).values()), tuple((quadratures or {}).items()))
    about = parameters, automaton.coordinates, *functions
    with _ONE_AT_A_TIME:  # else two threads might have two programs of one structure
        if grows:
            growing = _growing_program(automaton.states, modes, *about)
            program = growing.with_modes(combinations) if any(functions) else growing.with_known_modes()
        else:
            program = pack_program(automaton.states, tuple(modes), *about)
    return program, numbers_at(program, values)


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
    packer = Packer(states, parameters, sections, quadratures)
    for mode in modes:
        packer.add(mode)
    return packer.pack(coordinates)


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
    packer, sound = Packer(states, parameters, demand=modes), dict[int, Any]()
    for mode in known.modes:
        check_mode(mode, modes.names, states, frozenset((*states, *parameters)), sound)
        packer.add(mode)
    return packer.pack(coordinates, known)


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
        self._modes, self._coordinates, self._states = modes, coordinates, states
        self._packer = Packer(states, parameters, sections, quadratures, modes)
        self._known, self._sound = frozenset((*states, *parameters)), dict[int, Any]()
        self._asked: dict[Combination, Mode] = {}
        self._packed: tuple[tuple[int, int], Program | None] = (0, 0), None

    def with_known_modes(self) -> Program:
        """The program of all modes that are derived by now."""
        return self._grown(self._modes.known())

    def with_modes(self, combinations: Sequence[Combination]) -> Program:
        """The program of these modes, and of those for which it was asked before."""
        for one in combinations:
            if one not in self._asked and (mode := self._modes.mode(one)) is not None:
                self._asked[one] = mode
        known = KnownModes(tuple(self._asked.values()), tuple(self._asked), self._modes.known().refused)
        return self._grown(known)

    def _grown(self, known: KnownModes) -> Program:
        counts = len(known.modes), len(known.refused)
        before, program = self._packed
        if program is None or counts != before:
            for mode in known.modes[len(self._packer.modes) :]:
                check_mode(mode, self._modes.names, self._states, self._known, self._sound)
                self._packer.add(mode)
            program = self._packer.pack(self._coordinates, known)
            program = replace(program, grown_from=None if self._packed[1] is None else ref(self._packed[1]))
            self._packed = counts, program
        return program


class GrowingArray:
    """An array to which others are appended; arrays that it has given stay as they are.

    Programs that grow by one mode at a time share it, as a copy for each would fragment the memory.
    """

    def __init__(self, kind: Any = np.int64, columns: tuple[int, ...] = ()) -> None:
        self._room, self.length = np.zeros((64, *columns), dtype=kind), 0

    def extend(self, values: Sequence[Any] | np.ndarray) -> None:
        """Append what has the same columns."""
        end = self.length + len(values)
        if end > len(self._room):
            more = np.zeros((max(end, len(self._room)), *self._room.shape[1:]), dtype=self._room.dtype)
            self._room = np.concatenate([self._room, more])
        if len(values):
            self._room[self.length : end] = values
        self.length = end

    @property
    def array(self) -> np.ndarray:
        """What is there so far."""
        return self._room[: self.length]


class TapeArrays:
    """Operations, terms and numbers of tapes, one tape after another.

    Numbers are places among the formulas of the parameters.
    """

    def __init__(self) -> None:
        self.ops = GrowingArray(np.uint32, (3,))
        self.slots, self.constants, self.terms = GrowingArray(np.uint32), GrowingArray(), GrowingArray()
        self.tapes: list[Tape] = []

    def add(self, lowered: LoweredTape, ops: np.ndarray, numbers: tuple[np.ndarray, np.ndarray]) -> None:
        """Append a tape, whose ranges of own terms `ops` has from 0, and of terms of products elsewhere."""
        own = lowered.affine & ~shared_ranges(ops)
        self.ops.extend(_shifted(ops, own, self.slots.length))
        self.slots.extend(lowered.term_slots)
        for kept, places in zip((self.constants, self.terms), numbers, strict=True):
            kept.extend(places)
        self.tapes.append(lowered.tape)

    def ops_behind(self, terms: int) -> np.ndarray:
        """The operations, where there are as many own terms before these."""
        ops = self.ops.array
        return _shifted(ops, (ops[:, 0] == AFFINE) & ~shared_ranges(ops), terms) if terms else ops


def _shifted(ops: np.ndarray, which: np.ndarray, by: int) -> np.ndarray:
    ops = ops.copy()
    ops[which, 1:] += np.uint32(by)
    return ops


def _arrays_of_mode(one: LoweredMode, sections: int) -> dict[str, np.ndarray]:
    """What `Code` has of a mode beside its operations and numbers."""
    inputs = one.tape.inputs
    return {
        "flow": slot_array(one.flow)[None],
        "guards": slot_array(one.guards),
        "constraints": slot_array(one.constraints),
        "lengths": int_array([[len(one.guards), len(one.constraints)]]),
        "sections": slot_array([one.sections or [0] * sections], columns=sections),
        "powers": int_array([one.has(POWER)]),
        "quotients": int_array([one.has(QUOTIENT)]),
        "degrees": int_array([one.degree]),
        "ranges": one.ranges[inputs:],
        "state_ranges": one.ranges[None, :inputs],
        "polynomial": one.polynomial[inputs:],
        "polynomial_degrees": int_array([one.polynomial_degree]),
        "guard_degrees": one.guard_degrees,
    }


def shared_ranges(ops: np.ndarray) -> np.ndarray:
    """Which operations (operations, 3) have ranges of the terms of products."""
    return (ops[:, 0] == AFFINE) & (ops[:, 1] >= FIRST_SHARED)


class SharedTerms:
    """Terms of products of matrices, once for all tapes on which their factors have the same slots.

    They are in panels: a slot for each column of one, and ROWS coefficients.
    """

    def __init__(self) -> None:
        self.slots, self.coefficients = GrowingArray(np.uint32), GrowingArray(np.float64)
        self._places: dict[tuple[int, bytes], int] = {}

    def ops_of(self, lowered: LoweredTape) -> np.ndarray:
        """The operations of a tape, with ranges of the terms of its products as these are numbered here."""
        if not lowered.tape.products:
            return lowered.ops
        ops = lowered.ops.copy()
        shared, before = shared_ranges(ops), FIRST_SHARED
        ranges = ops[shared, 1:].copy()
        for one in lowered.tape.products:
            product, slots, count = one.product, one.slots, ROWS * len(one.slots)
            inside = (ranges[:, 0] >= before) & (ranges[:, 0] < before + count)
            moved = ranges[inside] - np.uint32(before - FIRST_SHARED) + np.uint32(self._place(product, slots))
            ops[np.flatnonzero(shared)[inside], 1:] = moved
            before += count
        return ops

    def _place(self, product: Any, slots: np.ndarray) -> int:
        key = (product.like or product).number, slots.tobytes()
        if key not in self._places:
            self._places[key] = ROWS * self.slots.length
            self.slots.extend(slots)
            self.coefficients.extend(panels_of(product).entries)
        return self._places[key]


class Packer:
    """Collects the arrays of a :class:`Program`, mode by mode."""

    def __init__(
        self,
        states: tuple[Symbol, ...],
        parameters: tuple[Symbol, ...],
        sections: tuple[Section, ...] = (),
        quadratures: tuple[tuple[str, Any], ...] = (),
        demand: ModesOnDemand | None = None,
    ) -> None:
        self.parameters, self.sections, self.demand = parameters, sections, demand
        self.integrands = tuple(expr for _, expr in quadratures)
        self.physical = states
        self.states = (*states, *(sp.Symbol(f"integral of {name}") for name, _ in quadratures))
        self.modes: list[Mode] = []
        self.of_modes, self.of_resets = TapeArrays(), TapeArrays()
        self.arrays: dict[str, GrowingArray] = {}
        self.reset_out = GrowingArray(np.uint32, (len(self.states),))
        self.event_resets = GrowingArray(columns=(2,))
        self.guards: list[str] = []
        self.guard_modes = GrowingArray()
        self.classes: dict[Any, int] = {}  # numbers of classes of functions, by `sign_normal_form`
        self.guard_classes, self.constraint_classes = GrowingArray(), GrowingArray()
        self.zeros = GrowingArray()  # for both resets of each event, where its part of these ends:
        self.zeros.extend([0])
        self.zero_classes = GrowingArray()  # classes of functions that are zero after the reset,
        self.zero_counts = GrowingArray()  # and how many leading coefficients of each are zero
        parts = 0 if demand is None else len(demand.parts)
        self.listed = GrowingArray(columns=(parts,))  # the targets of all events, where modes are on demand,
        self.listed_lengths = GrowingArray()  # and how many each event has
        self.products, self.numbers = SharedTerms(), NumberPlaces(parameters)
        self._reset_numbers: dict[int, int] = {}  # by the identity of the jumps
        self._conditions: tuple[LoweredMode, TapeArrays, np.ndarray] | None = None

    def add(self, mode: Mode) -> None:
        """Append a mode."""
        number = len(self.modes)
        self.modes.append(mode)
        lowered = lower_mode(mode, self.states, self.sections, self.integrands, self._common_products)
        self._add_tape(lowered, self.of_modes)
        for name, values in _arrays_of_mode(lowered, len(self.sections)).items():
            if name not in self.arrays:
                self.arrays[name] = GrowingArray(values.dtype, values.shape[1:])
            self.arrays[name].extend(values)
        self.guards += [event.name for event in mode.events]
        self.guard_modes.extend([number] * len(mode.events))
        self.guard_classes.extend([self._class(event.function) for event in mode.events])
        self.constraint_classes.extend([*map(self._class, mode.constraints)])
        for event in mode.events:
            self._add_event(mode, event)

    def _add_tape(self, lowered: LoweredTape, arrays: TapeArrays) -> None:
        arrays.add(lowered, self.products.ops_of(lowered), self.numbers.of(lowered))

    @property
    def _common_products(self) -> tuple[Any, ...]:
        return () if self.demand is None else self.demand.products

    def _add_event(self, mode: Mode, event: Event) -> None:
        plain = self._reset(event.reset)
        closing = event.accumulation or event.reset
        self.event_resets.extend([[plain, plain if event.accumulation is None else self._reset(closing)]])
        for reset in (event.reset, closing):
            zeros = structural_zeros(mode, event, reset)
            self.zero_classes.extend([self._number_of_class(function) for function in zeros])
            self.zero_counts.extend(list(zeros.values()))
            self.zeros.extend([self.zero_counts.length])
        if self.demand is not None:
            self.listed.extend([*filter(None, map(self.demand.names.combination_of, event.targets))])
            self.listed_lengths.extend([len(event.targets)])

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
            number = self._reset_numbers[id(reset.jump)] = self.reset_out.length
            lowered = lower_reset(reset, self.states)
            self._add_tape(lowered, self.of_resets)
            self.reset_out.extend(slot_array(lowered.out)[None])
        return number

    def _conditions_of(self, modes: ModesOnDemand) -> tuple[LoweredMode, TapeArrays, np.ndarray]:
        """A mode that stands for those not derived; its constraints are the conditions of all regimes."""
        if self._conditions is None:
            every = (condition for part in modes.parts for regime in part for condition in regime.conditions)
            mode = Mode("", (sp.S.Zero,) * len(self.states), constraints=tuple(every))
            lowered, arrays = lower_mode(mode, self.states, (), (), self._common_products), TapeArrays()
            self._add_tape(lowered, arrays)
            self._conditions = lowered, arrays, int_array([*map(self._class, mode.constraints)])
        return self._conditions

    def pack(self, coordinates: int, known: KnownModes | None = None) -> Program:
        """The program of the modes so far; where modes are on demand, with what is `known` of the others."""
        others, classes, demand = (
            list[tuple[LoweredMode, TapeArrays]](),
            [self.constraint_classes.array],
            None,
        )
        if self.demand is not None and known is not None:
            lowered, arrays, of_conditions = self._conditions_of(self.demand)
            others, classes = [(lowered, arrays)], [*classes, of_conditions]
            demand = _demand_arrays(self.demand, known, _ranges(self.listed_lengths.array), self.listed.array)
        initial = [i for i, mode in enumerate(self.modes) if not mode.limit] if known is None else []
        tapes = [self.of_modes, *(arrays for _, arrays in others), self.of_resets]
        code = self._code([lowered for lowered, _ in others], tapes, coordinates, initial)
        code = code._replace(function_classes=np.concatenate([self.guard_classes.array, *classes]))
        return Program(
            code,
            (*self.of_modes.tapes, *(one.tape for one, _ in others)),
            tuple(self.of_resets.tapes),
            max(tape.slots for one in tapes for tape in one.tapes),
            tuple(mode.name for mode in self.modes),
            tuple(self.guards),
            self.guard_modes.array,
            int_array(initial),
            self.numbers.formulas(),
            np.concatenate([*(one.constants.array for one in tapes), *(one.terms.array for one in tapes)]),
            partial(undefined_number, self.parameters, [tape for one in tapes for tape in one.tapes]),
            demand,
            self.products.coefficients.array,
        )

    def _code(
        self,
        others: Sequence[LoweredMode],
        tapes: Sequence[TapeArrays],
        coordinates: int,
        initial: Sequence[int],
    ) -> Code:
        """The arrays, of the modes and of `others` that stand for those not derived."""
        modes, count, inputs = len(self.modes), len(self.modes) + len(others), len(self.states)
        parts = [{name: array.array for name, array in self.arrays.items()}] if modes else []
        parts += [_arrays_of_mode(one, len(self.sections)) for one in others]
        of = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
        lengths = of["lengths"]
        mode_ops = _ranges([len(tape.ops) for one in tapes[:-1] for tape in one.tapes])
        before = [0, *accumulate(one.slots.length for one in tapes)]
        ops = np.concatenate([one.ops_behind(first) for one, first in zip(tapes, before[:-1], strict=True)])
        ops[shared_ranges(ops), 1:] -= np.uint32(FIRST_SHARED - before[-1])
        return Code(
            inputs=inputs,
            ops=ops,
            shared=before[-1],
            term_slots=np.concatenate([*(one.slots.array for one in tapes), self.products.slots.array]),
            mode_ops=mode_ops,
            flow=of["flow"],
            mode_guards=_ranges(lengths[:, 0]),
            mode_constraints=_ranges(lengths[:, 1], start=len(of["guards"])),
            function_slots=np.concatenate([of["guards"], of["constraints"]]),
            targets=self._targets(initial),
            limits=int_array([i for i, mode in enumerate(self.modes) if mode.limit]),
            resets=self.event_resets.array,
            function_classes=int_array([]),
            zeros=self.zeros.array,
            zero_classes=self.zero_classes.array,
            zero_counts=self.zero_counts.array,
            reset_ops=_ranges([len(tape.ops) for tape in self.of_resets.tapes], start=mode_ops[-1]),
            reset_out=self.reset_out.array,
            sections=of["sections"],
            directions=int_array([section.direction for section in self.sections]),
            native=np.zeros(count, dtype=np.int64),
            lanes=np.zeros(count, dtype=np.int64),
            built=int_array([i < modes for i in range(count)]),
            powers=of["powers"],
            quotients=of["quotients"],
            degrees=of["degrees"],
            ranges=of["ranges"],
            state_ranges=of["state_ranges"],
            polynomial=of["polynomial"],
            polynomial_degrees=of["polynomial_degrees"],
            guard_degrees=of["guard_degrees"],
            groups=int_array([0, coordinates, 2 * coordinates, len(self.physical)]),
        )

    def _targets(self, initial: Sequence[int]) -> np.ndarray:
        """For each event its targets, then all others but limit modes; empty where modes are on demand.

        Only events of limit modes may lead to one.  Rows are filled up by their first mode, tried already.
        """
        if not initial:
            return np.zeros((self.event_resets.length, 0), dtype=np.int64)
        places, tried = {mode.name: i for i, mode in enumerate(self.modes)}, {*initial}
        rows = []
        for mode in self.modes:
            for event in mode.events:
                places_of_targets = [places[name] for name in event.targets]
                rows.append(
                    [*dict.fromkeys([i for i in places_of_targets if mode.limit or i in tried] + [*initial])]
                )
        columns = max(map(len, rows), default=len(initial))
        return int_array([row + row[:1] * (columns - len(row)) for row in rows], columns=columns)


def _demand_arrays(
    modes: ModesOnDemand, known: KnownModes, listed: np.ndarray, targets: np.ndarray
) -> Demand:
    """What kernels have to know of modes that are not derived."""
    parts = len(modes.parts)
    numbers = [*range(len(known.modes)), *(-modes.names.conflict(one) for one in known.refused)]
    conditions = [len(regime.conditions) for part in modes.parts for regime in part]
    return Demand(
        regimes=_ranges([len(part) for part in modes.parts]),
        conditions=_ranges(conditions),
        combinations=int_array([*known.combinations, *known.refused], columns=parts),
        modes=int_array(numbers),
        listed=listed,
        targets=targets,
    )


def _ranges(lengths: Sequence[int] | np.ndarray, start: int = 0) -> np.ndarray:
    return start + np.concatenate([[0], np.cumsum(lengths, dtype=np.int64)]).astype(np.int64)
