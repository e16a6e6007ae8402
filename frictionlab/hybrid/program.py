"""An automaton packed into arrays for the kernels: every mode's tape, guards, resets and sections.

The packing depends on the structure alone and is remembered; :meth:`Program.numbers` fills in parameter
values, which costs microseconds.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
import sympy as sp

from frictionlab.automaton import Event, HybridAutomaton, Mode, Reset
from frictionlab.hybrid.checks import check_structure
from frictionlab.hybrid.tape import Tape, TapeBuilder

NONE = -1  # "no reset" in the arrays


class Code(NamedTuple):
    """The structure of an automaton as integers; the parameter values are in :class:`Numbers`.

    Functions are numbered through all modes: first the event functions (guards), then the constraints.
    """

    inputs: int  # number of states
    ops: np.ndarray  # (operations, 3): kind, a, b
    term_slots: np.ndarray  # (terms,)
    mode_ops: np.ndarray  # (modes + 1,) range of each mode's operations
    flow: np.ndarray  # (modes, states) slot that holds a state's derivative
    mode_guards: np.ndarray  # (modes + 1,)
    mode_constraints: np.ndarray  # (modes + 1,) numbered after all guards
    function_slots: np.ndarray  # (guards + constraints,)
    targets: np.ndarray  # (guards, modes) in the order in which they are tried
    resets: np.ndarray  # (guards, 2) number of the reset, and of the one that closes an accumulation
    declared: np.ndarray  # (guards, 2, functions) leading coefficients that vanish after those two
    reset_ops: np.ndarray  # (resets + 1,)
    reset_out: np.ndarray  # (resets, states) slot that holds a state's new value
    sections: np.ndarray  # (modes, sections) slots
    directions: np.ndarray  # (sections,) +1 rising, -1 falling, 0 both
    groups: np.ndarray  # (4,) bounds of the coordinates, the velocities, the other states; integrals follow


class Numbers(NamedTuple):
    """The coefficients of the affine operations for one set of parameter values."""

    constants: np.ndarray  # (operations,)
    terms: np.ndarray  # (terms,)


class Section(NamedTuple):
    """A zero crossing that is recorded but changes no mode; `direction` +1 rising, -1 falling, 0 both."""

    function: sp.Expr
    direction: int = 0


@dataclass(frozen=True, eq=False)
class Program:
    """What :func:`lower` makes of an automaton's structure."""

    code: Code
    tapes: tuple[Tape, ...]
    resets: tuple[Tape, ...]
    slots: int
    modes: tuple[str, ...]
    guards: tuple[str, ...]
    guard_modes: np.ndarray
    _fill: Callable[..., Sequence[float]]

    def numbers(self, values: Sequence[float]) -> Numbers:
        """Coefficients for parameter values in the order of the automaton's parameters."""
        filled = np.array(self._fill(*values), dtype=float)
        split = len(self.code.ops)
        return Numbers(filled[:split].copy(), filled[split:].copy())

    @cached_property
    def initial(self) -> np.ndarray:
        """Modes in the order in which they are tried at the start."""
        return np.arange(len(self.modes), dtype=np.int64)

    def cost(self) -> dict[str, dict[str, int]]:
        """What each mode costs: operations by kind, guards, states."""
        first = self.code.mode_guards
        return {
            name: self.tapes[i].counts()
            | {"guards": int(first[i + 1] - first[i]), "states": self.code.inputs}
            for i, name in enumerate(self.modes)
        }


def program_of(
    automaton: HybridAutomaton,
    sections: Mapping[str, Section] | None = None,
    quadratures: Mapping[str, sp.Expr] | None = None,
) -> tuple[Program, Numbers]:
    """Program and numbers of an automaton; the program is remembered per structure.

    Raises
    ------
    ValueError
        Where the automaton is not well formed: the message names the mode and what is missing.
    TapeError
        Where an expression needs an operation that the tape lacks.
    """
    parameters = tuple(automaton.parameters)
    riders = (tuple((sections or {}).values()), tuple((quadratures or {}).items()))
    program = lower(automaton.states, automaton.modes, parameters, automaton.coordinates, *riders)
    return program, program.numbers(tuple(automaton.parameters.values()))


@lru_cache(maxsize=256)
def lower(
    states: tuple[sp.Symbol, ...],
    modes: tuple[Mode, ...],
    parameters: tuple[sp.Symbol, ...],
    coordinates: int,
    sections: tuple[Section, ...] = (),
    quadratures: tuple[tuple[str, sp.Expr], ...] = (),
) -> Program:
    """Lower every mode and reset to its tape and pack them."""
    check_structure(states, modes, parameters, coordinates)
    packer = _Packer(states, modes, sections, quadratures)
    return packer.pack(parameters, coordinates)


class _Lowered(NamedTuple):
    """A mode's tape, and the slots of what is asked of it."""

    flow: list[int]
    guards: list[int]
    constraints: list[int]
    sections: list[int]
    tape: Tape


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
        self.reset_tapes: list[Tape] = []
        self.reset_out: list[list[int]] = []

    def pack(self, parameters, coordinates) -> Program:
        names = [mode.name for mode in self.modes]
        lowered = [self._mode(mode) for mode in self.modes]
        tapes = [mode.tape for mode in lowered]
        resets = [self._event_resets(event) for _, event in self.events]
        every = tapes + self.reset_tapes
        code = Code(
            inputs=len(self.states),
            ops=_ops(every),
            term_slots=_slots([slot for tape in every for slot, _ in tape.terms]),
            mode_ops=_ranges([len(tape.ops) for tape in tapes]),
            flow=_slots([mode.flow for mode in lowered]),
            mode_guards=_ranges([len(mode.events) for mode in self.modes]),
            mode_constraints=_ranges([len(m.constraints) for m in self.modes], start=len(self.events)),
            function_slots=_slots(
                sum([m.guards for m in lowered], []) + sum([m.constraints for m in lowered], [])
            ),
            targets=_ints([_order(event, names) for _, event in self.events], columns=len(names)),
            resets=_ints(resets, columns=2),
            declared=_ints([self._declared(*pair) for pair in self.events]).reshape(
                len(self.events), 2, len(self.functions)
            ),
            reset_ops=_ranges([len(t.ops) for t in self.reset_tapes], start=sum(len(t.ops) for t in tapes)),
            reset_out=_slots(self.reset_out, columns=len(self.states)),
            sections=_slots([mode.sections for mode in lowered], columns=len(self.sections)),
            directions=_ints([section.direction for section in self.sections]),
            groups=_ints([0, coordinates, 2 * coordinates, len(self.physical)]),
        )
        exprs = [c for tape in every for c in tape.constants] + [c for tape in every for _, c in tape.terms]
        fill = sp.lambdify(parameters, exprs, modules="math", cse=True)
        guard_modes = _ints([names.index(mode.name) for mode, _ in self.events])
        guards = tuple(event.name for _, event in self.events)
        slots = max(tape.slots for tape in every)
        return Program(
            code, tuple(tapes), tuple(self.reset_tapes), slots, tuple(names), guards, guard_modes, fill
        )

    def _mode(self, mode: Mode) -> _Lowered:
        builder = TapeBuilder(self.states)
        return _Lowered(
            flow=[builder.slot(expr) for expr in (*mode.flow, *(_resolve(e, mode) for e in self.integrands))],
            guards=[builder.slot(event.function) for event in mode.events],
            constraints=[builder.slot(expr) for expr in mode.constraints],
            sections=[builder.slot(_resolve(section.function, mode)) for section in self.sections],
            tape=builder.tape,
        )

    def _event_resets(self, event: Event) -> list[int]:
        plain = self._reset(event.reset)
        return [plain, plain if event.accumulation is None else self._reset(event.accumulation)]

    def _reset(self, reset: Reset) -> int:
        if not reset.jump:
            return NONE
        builder = TapeBuilder(self.states)
        self.reset_out.append([builder.slot(reset.jump.get(state, state)) for state in self.states])
        self.reset_tapes.append(builder.tape)
        return len(self.reset_tapes) - 1

    def _declared(self, mode: Mode, event: Event) -> list[list[int]]:
        resets = (event.reset, event.accumulation or event.reset)
        return [self._vanishing(mode, event, reset) for reset in resets]

    def _vanishing(self, mode: Mode, event: Event, reset: Reset) -> list[int]:
        """How many leading coefficients of every function are zero by construction after the event."""
        zero = dict(reset.vanishing)
        for function in (event.function, *mode.constraints):
            if not any(_same(function, known) for known in zero) and _survives(function, reset):
                zero[function] = 1
        return [max([n for known, n in zero.items() if _same(f, known)], default=0) for f in self.functions]


def _resolve(function: sp.Expr | str, mode: Mode) -> sp.Expr:
    return mode.outputs[function] if isinstance(function, str) else function


def _survives(function: sp.Expr, reset: Reset) -> bool:
    """Whether a function that was zero before the reset is zero after it."""
    if function.free_symbols.isdisjoint(reset.jump):
        return True
    return sp.expand(function.xreplace(dict(reset.jump))) == 0


def _same(f: sp.Expr, g: sp.Expr) -> bool:
    return f == g or f == -g or sp.expand(f - g) == 0 or sp.expand(f + g) == 0


def _order(event: Event, names: list[str]) -> list[int]:
    first = [names.index(name) for name in event.targets]
    return first + [i for i in range(len(names)) if i not in first]


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
