"""The kernels that Python and native code call: one list, for objects and for WebAssembly.

Each entry point comes with specimens of its arguments, of which only the types count: numbers, arrays with
their number of axes, named tuples of these.  The functions that make the arguments of runs make the specimens
too, so that a field added or removed there needs no change here.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy as sp

from frictionlab.automaton import Event, HybridAutomaton, Mode
from frictionlab.hybrid.accuracy import StoredSteps, measure_defects, new_defect_scratch
from frictionlab.hybrid.codegen.jet_codegen import KERNELS
from frictionlab.hybrid.ensemble import lanes
from frictionlab.hybrid.ensemble.arrays import new_batch
from frictionlab.hybrid.kernels import jets, mode_selection, step_length, taylor_steps
from frictionlab.hybrid.kernels.event_handling import handle_event, handle_event_on_demand
from frictionlab.hybrid.kernels.event_location import GuardZero
from frictionlab.hybrid.kernels.impacts import note_resolution
from frictionlab.hybrid.kernels.mode_selection import select_combination
from frictionlab.hybrid.kernels.run_state import (
    StepData,
    Truncation,
    new_queue,
    new_record,
    new_run_state,
    new_scratch,
)
from frictionlab.hybrid.methods import runge_kutta, taylor
from frictionlab.hybrid.problem import Problem
from frictionlab.hybrid.variational import tangent_flow, tangent_jets
from frictionlab.tape.formulas import ELEMENTARY
from frictionlab.tape.packing import program_of
from frictionlab.tape.program import Demand, system_of

ORDER, TOL, STEP = 8, 1e-6, 1e-3


@dataclass(frozen=True)
class EntryPoint:
    """A kernel that is called from outside, and specimens of its arguments by their names."""

    kernel: Any
    arguments: dict[str, Any]

    @property
    def name(self) -> str:
        return self.kernel.__name__


@dataclass(frozen=True)
class Symbol:
    """A kernel that native code calls by a name, with its signature as numba writes it."""

    name: str
    function: Callable[..., float]
    signature: str


def entry_points() -> list[EntryPoint]:
    """The kernels that Python calls."""
    specimens = _specimens()
    return [_entry_point(kernel, specimens) for kernel in _KERNELS]


def symbols() -> list[Symbol]:
    """The kernels that native code calls, and the elementary functions, which pages in a browser call."""
    called = [Symbol(name, each.function, each.signature) for name, each in KERNELS.items()]
    return called + [
        Symbol(f"frictionlab_{each.__name__}", each, "float64(float64)") for each in ELEMENTARY.values()
    ]


_KERNELS = (
    mode_selection.select_mode,
    select_combination,
    taylor_steps.advance_taylor,
    taylor.advance_affine,
    taylor_steps.sample_states,
    handle_event,
    handle_event_on_demand,
    note_resolution,
    runge_kutta.advance_runge_kutta,
    runge_kutta.enter_next_mode,
    runge_kutta.enter_next_mode_on_demand,
    runge_kutta.failed_guard,
    runge_kutta.guard_at_stop,
    runge_kutta.step_before_stop,
    step_length.base_of_root,
    jets.run_tape,
    jets.majorant,
    jets.state_rates,
    jets.states_at,
    jets.slot_gradients,
    measure_defects,
    lanes.begin_runs,
    lanes.advance_batch_kernel,
    tangent_jets.linearise,
    tangent_jets.carry_steps,
    tangent_flow.carry_orthonormal_steps,
)


def _entry_point(kernel: Any, specimens: dict[str, Any]) -> EntryPoint:
    function: Any = getattr(kernel, "py_func", kernel)
    names = function.__code__.co_varnames[: function.__code__.co_argcount]
    special = _SPECIAL.get(str(function.__name__), {})
    return EntryPoint(kernel, {name: specimens[special.get(str(name), str(name))] for name in names})


# Kernels in which an argument's name means something else than in the others.
_SPECIAL = {
    "sample_states": {"steps": "step_data"},
    "carry_steps": {"steps": "step_data", "scratch": "tangent_scratch"},
    "carry_orthonormal_steps": {"steps": "step_data", "scratch": "tangent_scratch"},
    "linearise": {"scratch": "tangent_scratch"},
    "measure_defects": {"scratch": "defect_scratch"},
}


def _specimens() -> dict[str, Any]:
    """A specimen for each name of an argument, made for an oscillator with a stop."""
    x, v = sp.symbols("x v")
    modes = (Mode("free", (v, -x), (Event("stop", x, ("free",)),)),)
    program, numbers = program_of(HybridAutomaton((x, v), modes, coordinates=1))
    code, method, matrix = program.code, taylor.Taylor(), np.zeros((1, 1))
    row, places = np.zeros(2), np.zeros(1, dtype=np.int64)
    batch = new_batch([Problem(program, numbers, row, 1.0)], method)
    step_data = StepData(matrix, places, matrix)
    tangent_scratch = tangent_jets.TangentScratch(matrix, np.zeros((1, 1, 1)))
    of_program = {"system": system_of(code, numbers), "code": code, "numbers": numbers, "magnitudes": numbers}
    of_runs = {
        "truncation": Truncation(ORDER, TOL),
        "event": GuardZero(0.0, 0, 1),
        "queue": new_queue(_demand()),
        "run": new_run_state(2, 0),
        "record": new_record(code, 1, 1, 1),
        "scratch": new_scratch(program.slots, code, ORDER),
        "rounding": mode_selection.Rounding(row, TOL),
        "change": taylor.new_affine_map(code),
        "scheme": runge_kutta.new_scheme(_tableau(), STEP, ORDER, 2),
        "runs": batch.runs,
        "lanes": batch.lanes,
        "steps": StoredSteps(matrix, places, matrix, matrix, matrix),
        "step_data": step_data,
        "defect_scratch": new_defect_scratch(program.slots, 2, ORDER),
        "tangent_scratch": tangent_scratch,
        "growth": tangent_flow.Growth(row, row),
    }
    vectors = dict.fromkeys(("z", "times", "worst", "dz"), row)
    matrices = dict.fromkeys(("J", "jets", "values", "T", "frame", "starts", "out"), matrix)
    integers = dict.fromkeys(("candidates", "initial", "which", "chosen"), places)
    whole = dict.fromkeys(("order", "guard", "mode", "rounds", "slot"), 0)
    others = {"flow": code.flow[0], "operations": (0, 1), "orders": (0, 1), "sign": -1.0}
    lengths = {"h": STEP, "s": STEP}
    return of_program | of_runs | vectors | matrices | integers | whole | others | lengths


def _demand() -> Demand:
    row, rows = np.zeros(2, dtype=np.int64), np.zeros((1, 1), dtype=np.int64)
    return Demand(row, row, rows, row, row, rows)


def _tableau() -> runge_kutta.Tableau:
    return runge_kutta.Tableau(stages=((),), weights=(1.0,))
