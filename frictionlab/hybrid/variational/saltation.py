"""Saltation matrices: what an event does to a small perturbation of the motion.

A neighbouring motion reaches the guard g at another time, jumps there by the reset R, and flows on with f+
instead of f-.  To first order S = DR + (f+ - DR f-) (grad g)^T / (grad g . f-).  Only the values of R on g =
0 matter: S is the same whatever R is elsewhere.  Source: Leine & Nijmeijer, Dynamics and Bifurcations of
Non-Smooth Mechanical Systems, Springer 2004.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from frictionlab.hybrid.kernels.jets import mode_operations
from frictionlab.hybrid.tape.program import Numbers, Program
from frictionlab.hybrid.variational.tangent_jets import TangentScratch, linearise

GRAZING_SHARE = 1e-7  # a guard that would turn back within this share of the time in the mode is grazed
# another guard that vanishes within this share of that time makes a double event
COINCIDENT_EVENT_SHARE = 1e-9
CONSTRAINT_SHARE = (
    1e-6  # share of the saltation matrix by which neighbouring motions may miss the next mode's constraints
)


class SaltationError(ValueError):
    """A motion whose derivative by its initial state does not exist, or is not known."""


class LinearisedTape(NamedTuple):
    """A tape at a state: jets (slots, 3) of its slots, and their gradients (slots, states)."""

    jets: np.ndarray
    gradients: np.ndarray


class EventCrossing(NamedTuple):
    """An event: number of the guard, mode entered, states before and after, time spent in the mode left."""

    guard: int
    target: int
    before: np.ndarray
    after: np.ndarray
    dwell: float


def saltation_matrix(program: Program, numbers: Numbers, event: EventCrossing) -> np.ndarray:
    """Saltation matrix (n, n) of an event.

    Raises
    ------
    SaltationError
        Where the motion grazes the guard, meets two guards at once, or satisfies the next mode's constraints
        only by coincidence.
    """
    code, source = program.code, int(program.guard_modes[event.guard])
    left, entered = (
        linearise_mode(program, numbers, mode, z)
        for mode, z in ((source, event.before), (event.target, event.after))
    )
    slot = code.function_slots[event.guard]
    _check_grazing(left.jets[slot], event.dwell)
    others = code.function_slots[code.mode_guards[source] : code.mode_guards[source + 1]]
    _check_alone(left.jets[others[others != slot]], event.dwell)
    jump = _reset_jacobian(program, numbers, code.resets[event.guard, 0], event.before)
    before, after = left.jets[code.flow[source], 0], entered.jets[code.flow[event.target], 0]
    matrix = jump + np.outer(after - jump @ before, left.gradients[slot]) / left.jets[slot, 1]
    _check_constraints(constraint_gradients(program, event.target, entered) @ matrix, matrix)
    return matrix


def linearise_mode(program: Program, numbers: Numbers, mode: int, z: np.ndarray) -> LinearisedTape:
    """A mode's tape at a state, linearised."""
    code = program.code
    return _linear(program, numbers, mode_operations(code, mode), code.flow[mode], z)


def constraint_gradients(program: Program, mode: int, at: LinearisedTape) -> np.ndarray:
    """Gradients (constraints, n) of a mode's constraints."""
    code = program.code
    chosen = slice(code.mode_constraints[mode], code.mode_constraints[mode + 1])
    return at.gradients[code.function_slots[chosen]]


def _linear(program, numbers, operations: tuple[int, int], flow: np.ndarray, z: np.ndarray) -> LinearisedTape:
    code, n = program.code, len(z)
    scratch = TangentScratch(np.zeros((program.slots, 3)), np.zeros((program.slots, 1, n)))
    with np.errstate(all="ignore"):
        linearise(code, numbers, operations, flow, z, scratch)
    return LinearisedTape(scratch.J, scratch.T[:, 0])


def _reset_jacobian(program: Program, numbers: Numbers, reset: int, z: np.ndarray) -> np.ndarray:
    if reset < 0:
        return np.eye(len(z))
    code, first = program.code, program.code.reset_ops
    # The order is 0 but for the jets of `_linear`, which take the new values for rates and are not used.
    tape = _linear(program, numbers, (first[reset], first[reset + 1]), code.reset_out[reset], z)
    return tape.gradients[code.reset_out[reset]]


def _check_grazing(guard: np.ndarray, dwell: float) -> None:
    if not dwell > 0.0:
        raise SaltationError("two events at one instant: which neighbours meet first depends on the side")
    if not abs(guard[1]) > GRAZING_SHARE * dwell * abs(guard[2]):
        raise SaltationError("the event function has a double zero (grazing): some neighbours miss it")


def _check_alone(others: np.ndarray, dwell: float) -> None:
    """Raise where another guard of the mode reaches zero at the same time; guards that are identically zero
    do not count."""
    if (np.abs(others[:, 0]) < COINCIDENT_EVENT_SHARE * dwell * np.abs(others[:, 1])).any():
        raise SaltationError("two event functions vanish at one instant: neighbours meet only one of them")


def _check_constraints(rates: np.ndarray, matrix: np.ndarray) -> None:
    if rates.size and np.abs(rates).max() > CONSTRAINT_SHARE * np.abs(matrix).max():
        raise SaltationError("the next mode's constraints hold by a coincidence: neighbours do not enter it")
