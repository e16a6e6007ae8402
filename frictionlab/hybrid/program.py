"""An automaton packed into arrays for the kernels: every mode's tape, guards, resets and sections.

The packing depends on the structure alone and is remembered; :meth:`Program.numbers` fills in parameter
values, which costs microseconds.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache
from itertools import chain
from threading import Lock
from typing import Any, NamedTuple

import numpy as np
import sympy as sp

from frictionlab.automaton import Event, HybridAutomaton, Mode, Reset
from frictionlab.hybrid.checks import check_structure
from frictionlab.hybrid.layout import NONE, Code, Numbers, Program, Section
from frictionlab.hybrid.tape import POWER, ResetBuilder, Tape, TapeBuilder
from frictionlab.hybrid.vanishing import vanishing

_ONE_AT_A_TIME = Lock()


def program_of(
    automaton: HybridAutomaton,
    sections: Mapping[str, Section] | None = None,
    quadratures: Mapping[str, Any] | None = None,
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
    with _ONE_AT_A_TIME:  # else two threads might have two programs of one structure
        program = lower(automaton.states, automaton.modes, parameters, automaton.coordinates, *riders)
    return program, program.numbers(tuple(automaton.parameters.values()))


@lru_cache(maxsize=256)
def lower(
    states: tuple[sp.Symbol, ...],
    modes: tuple[Mode, ...],
    parameters: tuple[sp.Symbol, ...],
    coordinates: int,
    sections: tuple[Section, ...] = (),
    quadratures: tuple[tuple[str, Any], ...] = (),
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
        initial = _ints([i for i, mode in enumerate(self.modes) if not mode.limit])
        code = Code(
            inputs=len(self.states),
            ops=_ops(every),
            term_slots=_slots([slot for tape in every for slot, _ in tape.terms]),
            mode_ops=_ranges([len(tape.ops) for tape in tapes]),
            flow=_slots([mode.flow for mode in lowered]),
            mode_guards=_ranges([len(mode.events) for mode in self.modes]),
            mode_constraints=_ranges([len(m.constraints) for m in self.modes], start=len(self.events)),
            function_slots=_slots(
                [*_joined(m.guards for m in lowered), *_joined(m.constraints for m in lowered)]
            ),
            targets=_ints([self._targets(event) for _, event in self.events], columns=len(initial)),
            limits=_ints([i for i, mode in enumerate(self.modes) if mode.limit]),
            resets=_ints(resets, columns=2),
            declared=_ints([self._declared(*pair) for pair in self.events]).reshape(
                len(self.events), 2, len(self.functions)
            ),
            reset_ops=_ranges([len(t.ops) for t in self.reset_tapes], start=sum(len(t.ops) for t in tapes)),
            reset_out=_slots(self.reset_out, columns=len(self.states)),
            sections=_slots([mode.sections for mode in lowered], columns=len(self.sections)),
            directions=_ints([section.direction for section in self.sections]),
            native=np.zeros(len(names), dtype=np.int64),
            lanes=np.zeros(len(names), dtype=np.int64),
            jets=np.array([-1, 0]),
            powers=_ints([any(op[0] == POWER for op in tape.ops) for tape in tapes]),
            groups=_ints([0, coordinates, 2 * coordinates, len(self.physical)]),
        )
        exprs = [c for tape in every for c in tape.constants] + [c for tape in every for _, c in tape.terms]
        fill = sp.lambdify(parameters, exprs, modules="math", cse=True)
        guard_modes = _ints([names.index(mode.name) for mode, _ in self.events])
        guards = tuple(event.name for _, event in self.events)
        slots = max(tape.slots for tape in every)
        tapes, resets = tuple(tapes), tuple(self.reset_tapes)
        return Program(code, tapes, resets, slots, tuple(names), guards, guard_modes, initial, fill)

    def _mode(self, mode: Mode) -> _Lowered:
        builder = TapeBuilder(self.states)
        return _Lowered(
            flow=[builder.slot(expr) for expr in (*mode.flow, *(_resolve(e, mode) for e in self.integrands))],
            guards=[builder.slot(event.function) for event in mode.events],
            constraints=[builder.slot(expr) for expr in mode.constraints],
            sections=[builder.slot(_resolve(section.function, mode)) for section in self.sections],
            tape=builder.tape,
        )

    def _targets(self, event: Event) -> list[int]:
        names = [mode.name for mode in self.modes]
        order = dict.fromkeys((*event.targets, *names))
        return [names.index(name) for name in order if not self.modes[names.index(name)].limit]

    def _event_resets(self, event: Event) -> list[int]:
        plain = self._reset(event.reset)
        return [plain, plain if event.accumulation is None else self._reset(event.accumulation)]

    def _reset(self, reset: Reset) -> int:
        if not reset.jump:
            return NONE
        builder = ResetBuilder(self.states)
        self.reset_out.append([builder.slot(reset.jump.get(state, state)) for state in self.states])
        self.reset_tapes.append(builder.tape)
        return len(self.reset_tapes) - 1

    def _declared(self, mode: Mode, event: Event) -> list[list[int]]:
        resets = (event.reset, event.accumulation or event.reset)
        return [vanishing(mode, event, reset, self.functions) for reset in resets]


def _joined(lists: Iterable[list[int]]) -> Iterable[int]:
    return chain.from_iterable(lists)


def _resolve(function: Any | str, mode: Mode) -> Any:
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
