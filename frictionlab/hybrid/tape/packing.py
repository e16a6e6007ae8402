"""An automaton packed into arrays for the kernels: every mode's tape, guards, resets and sections.

The packing depends on the structure alone and is remembered; :meth:`Program.numbers` fills in parameter
values, which costs microseconds.  Part of the structure is which functions are zero by construction after an
event, and to which order: what the reset declares, the event function itself, and the constraints of the mode
that ends.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import lru_cache, partial
from itertools import chain
from threading import Lock
from typing import Any, NamedTuple

import numpy as np
import sympy as sp

from frictionlab.automaton import Event, HybridAutomaton, Mode, Reset
from frictionlab.automaton.modes_on_demand import ModesOnDemand, Sketch
from frictionlab.automaton.undefined_numbers import undefined_part
from frictionlab.hybrid.tape.automaton_checks import check_structure
from frictionlab.hybrid.tape.operations import POWER
from frictionlab.hybrid.tape.program import NO_RESET, NOT_POLYNOMIAL, Code, Numbers, Program, Section
from frictionlab.hybrid.tape.tape import Range, ResetBuilder, Tape, TapeBuilder

NO_FUNCTIONS = np.zeros(0, dtype=np.int64)
_ONE_AT_A_TIME = Lock()


@lru_cache(maxsize=4096)
def structural_zeros(mode: Mode, event: Event, reset: Reset) -> Mapping[Any, int]:
    """How many leading Taylor coefficients are zero after the event's reset, by function up to its sign.

    What the reset declares; besides, the function that triggered the event and the constraints of the
    mode that ends were zero before it, and stay so unless the reset changes them.
    """
    zero: dict[Any, int] = {}
    for function, count in reset.vanishing.items():
        zero[sign_normal_form(function)] = max(count, zero.get(sign_normal_form(function), 0))
    for function in (event.function, *mode.constraints):
        if sign_normal_form(function) not in zero and _survives(function, reset):
            zero[sign_normal_form(function)] = 1
    return zero


def _survives(function: sp.Expr, reset: Reset) -> bool:
    """Whether a function that was zero before the reset is zero after it."""
    if function.free_symbols.isdisjoint(reset.jump):
        return True
    return sp.expand(function.xreplace(dict(reset.jump))) == 0


@lru_cache(maxsize=4096)
def sign_normal_form(function: sp.Expr) -> sp.Expr:
    """The same for f and for -f, however they are written: both are zero together."""
    expanded = sp.expand(function)
    return -expanded if expanded.could_extract_minus_sign() else expanded


def program_of(
    automaton: HybridAutomaton,
    sections: Mapping[str, Section] | None = None,
    quadratures: Mapping[str, Any] | None = None,
    modes: tuple[Mode, ...] | None = None,
) -> tuple[Program, Numbers]:
    """Program and numbers of an automaton; the program is remembered per structure.

    `modes` are the automaton's, some of them as sketches; by default all are derived.

    Raises
    ------
    ValueError
        Where the automaton is not well formed: the message names the mode and what is missing.
    TapeError
        Where an expression needs an operation that the tape lacks.
    """
    parameters = tuple(automaton.parameters)
    riders = (tuple((sections or {}).values()), tuple((quadratures or {}).items()))
    chosen, apart = modes or tuple(automaton.modes), isinstance(automaton.modes, ModesOnDemand)
    remembered = pack_partial_program if any(isinstance(mode, Sketch) for mode in chosen) else pack_program
    with _ONE_AT_A_TIME:  # else two threads might have two programs of one structure
        program = remembered(automaton.states, chosen, parameters, automaton.coordinates, *riders, apart)
    return program, program.numbers(tuple(map(float, automaton.parameters.values())))


@lru_cache(maxsize=256)
def pack_program(
    states: tuple[sp.Symbol, ...],
    modes: tuple[Mode, ...],
    parameters: tuple[sp.Symbol, ...],
    coordinates: int,
    sections: tuple[Section, ...] = (),
    quadratures: tuple[tuple[str, Any], ...] = (),
    apart: bool = False,
) -> Program:
    """Lower every mode and reset to its tape and pack them; `apart` evaluates each number on its own."""
    check_structure(states, modes, parameters, coordinates)
    packer = _Packer(states, modes, sections, quadratures)
    return packer.pack(parameters, coordinates, apart)


# Soon replaced by one with more modes: the last few will do.
pack_partial_program = lru_cache(maxsize=16)(pack_program.__wrapped__)


class _ModeTape(NamedTuple):
    """A mode's tape, and the slots of what is asked of it."""

    flow: list[int]
    guards: list[int]
    constraints: list[int]
    sections: list[int]
    tape: Tape

    @property
    def degrees(self) -> list[float]:
        return self.tape.degrees(self.guards)

    @property
    def ranges(self) -> list[Range]:
        """How the range of each slot is found."""
        return self.tape.ranges((*self.flow, *self.guards, *self.sections), self.guards)

    @property
    def polynomial(self) -> list[bool]:
        return [degree < math.inf for degree in self.degrees]

    @property
    def polynomial_degree(self) -> float:
        return max(degree for degree in self.degrees if degree < math.inf)

    @property
    def guard_degrees(self) -> list[float]:
        degrees = self.degrees
        return [degrees[slot] for slot in self.guards]


class _Packer:
    """Collects the arrays of a :class:`Program`."""

    def __init__(self, states, modes, sections, quadratures) -> None:
        self.modes, self.sections = modes, sections
        self.integrands = tuple(expr for _, expr in quadratures)
        self.physical = states
        self.states = (*states, *(sp.Symbol(f"integral of {name}") for name, _ in quadratures))
        self.events = [(mode, event) for mode in modes for event in mode.events]
        self.functions = [event.function for _, event in self.events]
        self.functions += [c for mode in modes for c in mode.constraints]
        self.places = {mode.name: i for i, mode in enumerate(modes)}
        self.initial = [i for i, mode in enumerate(modes) if not mode.limit]
        self.reset_tapes: list[Tape] = []
        self.reset_out: list[list[int]] = []

    def pack(self, parameters, coordinates, apart) -> Program:
        names = [mode.name for mode in self.modes]
        lowered = [_lower_mode(mode, self.states, self.sections, self.integrands) for mode in self.modes]
        tapes = [mode.tape for mode in lowered]
        resets = [self._event_resets(event) for _, event in self.events]
        every, inputs = tapes + self.reset_tapes, len(self.states)
        code = Code(
            inputs=inputs,
            ops=_ops(every),
            term_slots=_slots([slot for tape in every for slot, _ in tape.terms]),
            mode_ops=_ranges([len(tape.ops) for tape in tapes]),
            flow=_slots([mode.flow for mode in lowered]),
            mode_guards=_ranges([len(mode.events) for mode in self.modes]),
            mode_constraints=_ranges([len(m.constraints) for m in self.modes], start=len(self.events)),
            function_slots=_slots(
                [*_joined(m.guards for m in lowered), *_joined(m.constraints for m in lowered)]
            ),
            targets=_ints([self._targets(event) for _, event in self.events], columns=len(self.initial)),
            limits=_ints([i for i, mode in enumerate(self.modes) if mode.limit]),
            resets=_ints(resets, columns=2),
            declared=self._declared(),
            reset_ops=_ranges([len(t.ops) for t in self.reset_tapes], start=sum(len(t.ops) for t in tapes)),
            reset_out=_slots(self.reset_out, columns=len(self.states)),
            sections=_slots([mode.sections for mode in lowered], columns=len(self.sections)),
            directions=_ints([section.direction for section in self.sections]),
            native=np.zeros(len(names), dtype=np.int64),
            lanes=np.zeros(len(names), dtype=np.int64),
            built=_ints([not isinstance(mode, Sketch) for mode in self.modes]),
            powers=_ints([any(op[0] == POWER for op in tape.ops) for tape in tapes]),
            degrees=_ints([_finite(max(mode.degrees)) for mode in lowered]),
            ranges=_ints([*_joined(mode.ranges[inputs:] for mode in lowered)]),
            state_ranges=_ints([mode.ranges[:inputs] for mode in lowered], columns=inputs),
            polynomial=_ints([*_joined(mode.polynomial[inputs:] for mode in lowered)]),
            polynomial_degrees=_ints([_finite(mode.polynomial_degree) for mode in lowered]),
            guard_degrees=_ints([_finite(d) for mode in lowered for d in mode.guard_degrees]),
            groups=_ints([0, coordinates, 2 * coordinates, len(self.physical)]),
        )
        exprs = [c for tape in every for c in tape.constants] + [c for tape in every for _, c in tape.terms]
        fill = (
            _fill_separately(parameters, exprs) if apart else sp.lambdify(parameters, exprs, "math", cse=True)
        )
        guard_modes = _ints([self.places[mode.name] for mode, _ in self.events])
        guards = tuple(event.name for _, event in self.events)
        slots = max(tape.slots for tape in every)
        tapes, resets = tuple(tapes), tuple(self.reset_tapes)
        initial = _ints(self.initial)
        undefined = partial(_undefined_number, parameters, tuple(exprs))
        return Program(
            code, tapes, resets, slots, tuple(names), guards, guard_modes, initial, fill, undefined
        )

    def _targets(self, event: Event) -> list[int]:
        order = dict.fromkeys((*(self.places[name] for name in event.targets), *self.initial))
        return [i for i in order if not self.modes[i].limit]

    def _event_resets(self, event: Event) -> list[int]:
        plain = self._reset(event.reset)
        return [plain, plain if event.accumulation is None else self._reset(event.accumulation)]

    def _reset(self, reset: Reset) -> int:
        if not reset.jump:
            return NO_RESET
        out, tape = _lower_reset(reset, self.states)
        self.reset_out.append(out)
        self.reset_tapes.append(tape)
        return len(self.reset_tapes) - 1

    def _declared(self) -> np.ndarray:
        declared = np.zeros((len(self.events), 2, len(self.functions)), dtype=np.int64)
        lists = defaultdict(list)
        for f, function in enumerate(self.functions):
            lists[sign_normal_form(function)].append(f)
        same = {function: _ints(places) for function, places in lists.items()}
        for row, (mode, event) in enumerate(self.events):
            for column, reset in enumerate((event.reset, event.accumulation or event.reset)):
                for function, count in structural_zeros(mode, event, reset).items():
                    declared[row, column, same.get(function, NO_FUNCTIONS)] = count
        return declared


@lru_cache(maxsize=4096)  # modes that are derived one by one are packed again and again
def _lower_mode(mode: Mode, states: tuple, sections: tuple[Section, ...], integrands: tuple) -> _ModeTape:
    builder = TapeBuilder(states)
    return _ModeTape(
        flow=[
            builder.slot(expr) for expr in (*mode.flow, *(_section_expression(e, mode) for e in integrands))
        ],
        guards=[builder.slot(event.function) for event in mode.events],
        constraints=[builder.slot(expr) for expr in mode.constraints],
        sections=[builder.slot(_section_expression(section.function, mode)) for section in sections],
        tape=builder.tape,
    )


@lru_cache(maxsize=4096)
def _lower_reset(reset: Reset, states: tuple) -> tuple[list[int], Tape]:
    builder = ResetBuilder(states)
    return [builder.slot(reset.jump.get(state, state)) for state in states], builder.tape


def _finite(degree: float) -> int:
    return int(min(degree, NOT_POLYNOMIAL))


def _joined(lists: Iterable[Sequence[int]]) -> Iterable[int]:
    return chain.from_iterable(lists)


def _undefined_number(parameters: tuple[Any, ...], exprs: tuple[Any, ...], values: Sequence[float]) -> str:
    """The first expression without a value, in words; empty where none is found."""
    at = dict(zip(parameters, values, strict=True))
    return next(filter(None, (undefined_part(expr, at) for expr in exprs)), "")


def _fill_separately(parameters: tuple[Any, ...], exprs: Sequence[Any]) -> Callable[..., Any]:
    """Values of expressions, each to the same bits whatever the others are: no shared subexpressions."""
    places = {expr: i for i, expr in enumerate(dict.fromkeys(exprs))}
    fills, where = [_number(parameters, expr) for expr in places], _ints([places[expr] for expr in exprs])
    return lambda *values: np.array([fill(*values) for fill in fills], dtype=float)[where]


@lru_cache(maxsize=4096)
def _number(parameters: tuple[Any, ...], expr: Any) -> Callable[..., float]:
    return sp.lambdify(parameters, expr, "math")


def _section_expression(function: Any | str, mode: Mode) -> Any:
    if isinstance(mode, Sketch):
        return sp.S.Zero
    return mode.outputs[function] if isinstance(function, str) else function


def _ops(tapes: Sequence[Tape]) -> np.ndarray:
    """All operations in one array, the affine ones' ranges moved to the common list of terms."""
    rows, terms = [], 0
    for tape in tapes:
        rows += [(kind, a + terms, b + terms) if kind == 0 else (kind, a, b) for kind, a, b in tape.ops]
        terms += len(tape.terms)
    return _slots(rows, columns=3)


def _ints(rows, columns: int | None = None, kind: type = np.int64) -> np.ndarray:
    array = np.array(rows, dtype=kind)
    return array if columns is None else array.reshape(len(rows), columns)


def _slots(rows, columns: int | None = None) -> np.ndarray:
    # Unsigned, which spares the kernels the check for negative indices.
    return _ints(rows, columns, np.uint32)


def _ranges(lengths: Sequence[int], start: int = 0) -> np.ndarray:
    return start + np.concatenate([[0], np.cumsum(lengths, dtype=np.int64)]).astype(np.int64)
