"""Taylor series of the variational equation, and saltation matrices.

The tape is differentiated operation by operation.  A saltation matrix is what an event does to a small
perturbation of the motion.

An array T of tangent jets has T[slot, k, d], coefficient k of the slot's derivative in direction d: all
directions side by side, so that they are computed together.

A neighbouring motion reaches the guard g at another time, jumps there by the reset R, and flows on with f+
instead of f-.  To first order S = DR + (f+ - DR f-) (grad g)^T / (grad g . f-).  Only the values of R on
g = 0 matter: S is the same whatever R is elsewhere.  Tangent vectors keep the constraints of the mode that
ends.  After S they must all keep the constraints of the mode that begins.  Two guards that all of them
reach at one instant are as one: on a rigid cam the phase tells both.

An event may leave mode, rates and tangent vectors as they are, as where a phase begins anew.  This is no
event of the motion.  S is the unit matrix then, whatever else happens at that instant.  Source: Leine &
Nijmeijer, Dynamics and Bifurcations of Non-Smooth Mechanical Systems, Springer 2004.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from frictionlab.compilation.decorators import inlined, kernel
from frictionlab.compilation.loaded_kernels import prepared_call
from frictionlab.hybrid.codegen.native_cache import interpreted_code
from frictionlab.hybrid.kernels.event_location import COEFFICIENT_ROUNDING
from frictionlab.hybrid.kernels.jets import (
    copy_vector,
    has_series,
    mode_operations,
    run_tape,
    states_at,
    term_slot,
    term_step,
)
from frictionlab.hybrid.kernels.step_length import step_length
from frictionlab.hybrid.methods.base import ROUNDINGS_AT_START
from frictionlab.tape.functions import AFFINE, POWER, PRODUCT, RATE, SQUARE
from frictionlab.tape.program import Numbers, Program

MIN_TANGENT_STEP_SHARE = (
    1e-9  # share of a run's step below which the series of its tangents are taken to diverge
)


class TangentScratch(NamedTuple):
    """Jets of a tape's slots, and their tangent jets."""

    J: np.ndarray  # (slots, order + 1)
    T: np.ndarray  # (slots, order + 1, directions)


@inlined
def add_multiple(factor, row, total):
    """Add a multiple of a row of derivatives to `total`."""
    for d in range(total.shape[0]):
        total[d] += factor * row[d]


@inlined
def add_convolution(sign, J, a, T, b, first, k, total):
    """Add sign times the sum of J[a, j] T[b, k - j] over first <= j <= k to `total`."""
    for j in range(first, k + 1):
        add_multiple(sign * J[a, j], T[b, k - j], total)


@kernel
def power_tangent(exponent, a, out, k, J, T, total):
    """Add coefficient k of a power's derivatives, from a u' = p u a'; nothing if the power has no series."""
    if J[a, 0] > 0.0 and (k == 0 or has_series(J, a, k, J.shape[1] - 1)):
        add_convolution(exponent, J, out, T, a, 0, k, total)
        add_convolution(-1.0, J, a, T, out, 1, k, total)
        for d in range(total.shape[0]):
            total[d] /= J[a, 0]


@kernel
def operation_tangent(code, numbers, op, out, k, J, T):
    """Coefficient k of the derivatives of an operation's result, whose jets are `J`."""
    kind, a, b, total = code.ops[op, 0], code.ops[op, 1], code.ops[op, 2], T[out, k]
    for d in range(total.shape[0]):
        total[d] = 0.0
    if kind == AFFINE:
        for j in range(a, b, term_step(code, a)):
            if numbers.terms[j] != 0.0:
                add_multiple(numbers.terms[j], T[term_slot(code, j), k], total)
    elif kind == PRODUCT:
        add_convolution(1.0, J, a, T, b, 0, k, total)
        add_convolution(1.0, J, b, T, a, 0, k, total)
    elif kind == SQUARE:
        add_convolution(2.0, J, a, T, a, 0, k, total)
    elif kind == RATE:
        add_multiple(float(k), T[a, k], total)
    elif kind == POWER:
        power_tangent(numbers.constants[op], a, out, k, J, T, total)
    elif kind > POWER:
        add_convolution(1.0, J, b, T, a, 0, k, total)
    else:
        add_multiple(1.0, T[a, k], total)
        add_convolution(-1.0, J, out, T, b, 0, k, total)
        add_convolution(-1.0, J, b, T, out, 1, k, total)
        for d in range(total.shape[0]):
            total[d] /= J[b, 0]


@kernel
def tangent_jets(code, numbers, operations, order, flow, scratch):
    """Tangent jets of the slots that `operations`, a range (first, last + 1), write.

    The jets and column 0 of the states' tangents are given; ``flow`` is as in ``run_tape``.
    """
    inputs, J, T = code.inputs, scratch.J, scratch.T
    first, last = operations
    for k in range(order + 1):
        for op in range(first, last):
            operation_tangent(code, numbers, op, inputs + op - first, k, J, T)
        if k < order:
            share = 1.0 / (k + 1)
            for i in range(inputs):
                for d in range(T.shape[2]):
                    T[i, k + 1, d] = T[flow[i], k, d] * share


@kernel
def linearise(code, numbers, operations, flow, z, scratch):
    """Jets up to order 2, and gradients, at `z` of the slots that a range of operations write."""
    J, T = scratch.J, scratch.T
    for i in range(z.shape[0]):
        J[i, 0] = z[i]
        for d in range(z.shape[0]):
            T[i, 0, d] = 1.0 if i == d else 0.0
    run_tape(code, numbers, operations, (0, 2), flow, -1.0, J, J)
    tangent_jets(code, numbers, operations, 0, flow, scratch)


@inlined
def tangent_at(T, order, s, d, out):
    """Write the tangent vector number `d` at time `s` after the expansion point."""
    for i in range(out.shape[0]):
        total = T[i, order, d]
        for k in range(order - 1, -1, -1):
            total = total * s + T[i, k, d]
        out[i] = total


@kernel
def carry_step(code, numbers, truncation, mode, longest, z, frame, scratch):
    """Propagate the state `z` and the rows of `frame`, tangent vectors, by one step in a mode.

    The step is as long as the series of the tangents allow: near an equilibrium the state's would allow any.
    Returns its length.  If the series diverge, this is not positive, or NaN.
    """
    operations, flow = mode_operations(code, mode), code.flow[mode]
    order, J, T = truncation.order, scratch.J, scratch.T
    copy_vector(z, J[: z.shape[0], 0])
    run_tape(code, numbers, operations, (0, order), flow, -1.0, J, J)
    for d in range(frame.shape[0]):
        copy_vector(frame[d], T[: z.shape[0], 0, d])
    tangent_jets(code, numbers, operations, order, flow, scratch)
    step = longest
    for d in range(frame.shape[0]):
        step = min(step, step_length(code, order, truncation.tol, T[:, :, d]))
    states_at(J, order, step, z)
    for d in range(frame.shape[0]):
        tangent_at(T, order, step, d, frame[d])
    return step


@kernel
def carry_steps(code, numbers, truncation, steps, z, frame, scratch):
    """:func:`carry_step` over the steps of a run; returns the number of the step that failed, or -1."""
    for i in range(steps.modes.shape[0]):
        copy_vector(steps.states[i], z)
        left = steps.times[i, 1]
        while left > 0.0:
            step = carry_step(code, numbers, truncation, steps.modes[i], left, z, frame, scratch)
            if not (step == left or step > MIN_TANGENT_STEP_SHARE * steps.times[i, 1]):
                return i
            left -= step
    return -1


GRAZING_SHARE = 1e-7  # a guard that would turn back within this share of the time in the mode is grazed
# another guard that vanishes within this share of that time makes a double event
COINCIDENT_EVENT_SHARE = 1e-9
# share of the terms by which neighbouring motions may miss the next mode's constraints
CONSTRAINT_SHARE = 1e-6
ROUNDING_SHARE = 1e-14  # of a constraint's largest slope and a matrix's largest entry
SAME_RATES_SHARE = 1e-9  # share of the rates by which an event that changes nothing may change them
MAX_SQUARINGS = 40  # of a projection: of two directions whose cosine is 1 - 1e-12 too


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


class Saltation(NamedTuple):
    """What an event does to tangent vectors: DR, f+ - DR f- over the guard's rate, the guard's gradient."""

    jump: np.ndarray
    leap: np.ndarray
    gradient: np.ndarray

    @property
    def matrix(self) -> np.ndarray:
        """The saltation matrix (n, n)."""
        return self.jump + np.outer(self.leap, self.gradient)

    def carried(self, rows: np.ndarray) -> np.ndarray:
        """Rows, tangent vectors, after the event.

        Before an impact with a small rate u the leap is of the size 1/u, and a distance of the size u.  The
        matrix, which subtracts its coordinates after multiplying them, would leave errors of the size 1/u.
        """
        return rows @ self.jump.T + np.outer(rows @ self.gradient, self.leap)


def saltation(program: Program, numbers: Numbers, event: EventCrossing, closes: bool = False) -> Saltation:
    """Saltation of an event, which may be the one that closes an accumulation.

    Raises
    ------
    SaltationError
        Where the motion grazes the guard, meets two guards at once, or satisfies the next mode's constraints
        only by coincidence.
    """
    code, source = program.code, int(program.guard_modes[event.guard])
    if source == event.target and changes_nothing(program, numbers, event.guard, event.before):
        zero = np.zeros(len(event.before))
        return Saltation(np.eye(len(zero)), zero, zero)
    left, entered = (
        linearise_mode(program, numbers, mode, z)
        for mode, z in ((source, event.before), (event.target, event.after))
    )
    slot = code.function_slots[event.guard]
    _check_grazing(left.jets[slot], event.dwell)
    tangents = admissible_tangents(constraint_gradients(program, source, left))
    for other in _other_guards_at_zero(program, source, event.guard, left, event.dwell):
        together = _met_together(left, slot, code.function_slots[other], tangents)
        if not together and not changes_nothing(program, numbers, other, event.before):
            raise SaltationError(
                "two event functions vanish at one instant: neighbours meet only one of them"
            )
    jump = _reset_jacobian(program, numbers, code.resets[event.guard, 0], event.before)
    before, after = left.jets[code.flow[source], 0], entered.jets[code.flow[event.target], 0]
    if closes and not is_plastic(program, event.guard):
        own, jump = jump, _closing_jacobian(program, numbers, event)
        _check_accumulation(own, jump, before, after)
    gradient, rate = left.gradients[slot], left.jets[slot, 1]
    saltation = Saltation(jump, (after - jump @ before) / rate, gradient)
    # The flow after the event keeps the constraints, and that before it those of its own mode.  Rates that
    # contacts hold at zero are rounding errors of the forces, which this leaves out.
    delayed = tangents - np.outer(tangents @ before, gradient @ tangents / rate)
    # The terms that may cancel: a plastic impact leaves a rounding error of the velocity before.
    sizes = np.eye(len(jump)) + np.abs(jump)
    sizes += np.outer(sizes @ np.abs(before), np.abs(gradient / rate))
    fixed = constraint_gradients(program, event.target, entered)
    _check_constraints(fixed, jump @ tangents @ delayed, sizes @ np.abs(tangents))
    return saltation


def admissible_tangents(fixed: np.ndarray) -> np.ndarray:
    """Projection (n, n) onto tangent vectors that keep constraints with these gradients (constraints, n)."""
    unit = np.eye(fixed.shape[1])
    return unit - np.linalg.pinv(fixed) @ fixed if len(fixed) else unit


def changes_nothing(program: Program, numbers: Numbers, guard: int, z: np.ndarray) -> bool:
    """Whether the event of a guard leaves mode, rates and tangent vectors as they are: a phase begins anew.

    Its reset then moves states by constants, no rate depends on these, and the guard is positive after it.
    """
    code, mode, reset = program.code, int(program.guard_modes[guard]), int(program.code.resets[guard, 0])
    if reset < 0:
        return False
    tape = _reset_tape(program, numbers, reset, z)
    out = code.reset_out[reset]
    if not np.array_equal(tape.gradients[out], np.eye(len(z))):
        return False
    before, after = (linearise_mode(program, numbers, mode, at) for at in (z, tape.jets[out, 0]))
    flow, slot = code.flow[mode], code.function_slots[guard]
    rates, apart = before.jets[flow, 0], after.jets[flow, 0] - before.jets[flow, 0]
    same = np.abs(apart).max(initial=0.0) <= SAME_RATES_SHARE * np.abs(rates).max(initial=0.0)
    return bool(same and after.jets[slot, 0] > 0.0)


def is_plastic(program: Program, guard: int) -> bool:
    """Whether a guard's own reset leaves it at zero with its rate: no flights follow that accumulate."""
    code, row = program.code, 2 * guard
    some = slice(code.zeros[row], code.zeros[row + 1])
    own = code.zero_classes[some] == code.function_classes[guard]
    return bool((code.zero_counts[some][own] > 1).any())


def linearise_mode(program: Program, numbers: Numbers, mode: int, z: np.ndarray) -> LinearisedTape:
    """A mode's tape at a state, linearised."""
    code = program.code
    return _linear(program, numbers, mode_operations(code, mode), code.flow[mode], z)


def constraint_gradients(program: Program, mode: int, at: LinearisedTape) -> np.ndarray:
    """Gradients (constraints, n) of a mode's constraints."""
    code = program.code
    chosen = slice(code.mode_constraints[mode], code.mode_constraints[mode + 1])
    return at.gradients[code.function_slots[chosen]]


def state_on_constraints(program: Program, numbers: Numbers, mode: int, z: np.ndarray) -> np.ndarray:
    """As :func:`states_on_constraints`, of one run."""
    of_runs = Numbers(numbers.constants[None], numbers.terms[None])
    return states_on_constraints(program, of_runs, mode, z[None])[0]


def states_on_constraints(program: Program, numbers: Numbers, mode: int, states: np.ndarray) -> np.ndarray:
    """The states (N, n) at the ends of runs, back on the constraints of their mode if rounding has moved them
    off these by more than a share of their terms; states of which nothing but rounding is left are zero.

    `numbers` have a row for each run.  Rounding moves a body that rests on two feet off them, by 1e-16 m, and
    where all bodies rest nothing else in the state tells that this is rounding.
    """
    chosen = slice(*program.code.mode_constraints[mode : mode + 2])
    if chosen.start == chosen.stop:
        return states
    missed, gradients = _constraints_of_runs(program, numbers, mode, states)
    terms = (np.abs(gradients) @ np.abs(states)[:, :, None])[:, :, 0]
    ends = states.copy()
    for i in np.flatnonzero(~(np.abs(missed) <= ROUNDINGS_AT_START[-1] * terms).all(axis=1)):
        ends[i] = _moved_back(states[i], missed[i], gradients[i])
    return ends


def start_on_constraints(program: Program, numbers: Numbers, mode: int, z: np.ndarray) -> np.ndarray:
    """The state (n,) where a run starts in a mode, on its constraints if it misses them by little.

    A start in stick may miss v_r = 0 by 1e-9 of its terms.  Where stick ends, the forces of a law that falls
    with speed would miss their balance by as much, which is more than rounding, and no mode would follow.
    """
    if program.code.mode_constraints[mode] == program.code.mode_constraints[mode + 1]:
        return z
    of_run = Numbers(numbers.constants[None], numbers.terms[None])
    missed, gradients = (one[0] for one in _constraints_of_runs(program, of_run, mode, z[None]))
    terms = np.abs(gradients) @ np.abs(z) + np.abs(missed - gradients @ z)  # of states, and of parameters
    rounding, most = (np.abs(missed) <= share * terms for share in ROUNDINGS_AT_START[::2])
    return z if rounding.all() or not most.all() else _moved_back(z, missed, gradients)


def _moved_back(z: np.ndarray, missed: np.ndarray, gradients: np.ndarray) -> np.ndarray:
    """A state (n,) that misses constraints, moved onto them."""
    back = np.linalg.pinv(gradients)
    state, rounding = z - back @ missed, COEFFICIENT_ROUNDING * (np.abs(back) @ np.abs(missed))
    return np.where(np.abs(state) <= rounding, 0.0, state)


def _constraints_of_runs(
    program: Program, numbers: Numbers, mode: int, states: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Values (N, constraints) and gradients (N, constraints, n) of a mode's constraints."""
    code, (count, n) = program.code, states.shape
    slots = code.function_slots[slice(*code.mode_constraints[mode : mode + 2])]
    values, gradients = np.empty((count, len(slots))), np.empty((count, len(slots), n))
    own, z = Numbers(np.empty(numbers.constants.shape[1]), np.empty(numbers.terms.shape[1])), np.empty(n)
    scratch, operations = _tangent_scratch(program, n), mode_operations(code, mode)
    arguments = interpreted_code(program), own, operations, code.flow[mode], z, scratch
    call = prepared_call(linearise, arguments, place=2)
    with np.errstate(all="ignore"):
        for i in range(count):
            own.constants[:], own.terms[:], z[:] = numbers.constants[i], numbers.terms[i], states[i]
            call(operations)
            values[i], gradients[i] = scratch.J[slots, 0], scratch.T[slots, 0]
    return values, gradients


def _tangent_scratch(program: Program, n: int) -> TangentScratch:
    return TangentScratch(np.zeros((program.slots, 3)), np.zeros((program.slots, 1, n)))


def _linear(program, numbers, operations: tuple[int, int], flow: np.ndarray, z: np.ndarray) -> LinearisedTape:
    scratch = _tangent_scratch(program, len(z))
    with np.errstate(all="ignore"):
        linearise(interpreted_code(program), numbers, operations, flow, z, scratch)
    return LinearisedTape(scratch.J, scratch.T[:, 0])


def _reset_jacobian(program: Program, numbers: Numbers, reset: int, z: np.ndarray) -> np.ndarray:
    if reset < 0:
        return np.eye(len(z))
    return _reset_tape(program, numbers, reset, z).gradients[program.code.reset_out[reset]]


def _reset_tape(program: Program, numbers: Numbers, reset: int, z: np.ndarray) -> LinearisedTape:
    code, first = program.code, program.code.reset_ops
    # Only order 0 counts: the higher jets of `_linear` take the new values for rates, and are not used.
    return _linear(program, numbers, (first[reset], first[reset + 1]), code.reset_out[reset], z)


def _closing_jacobian(program: Program, numbers: Numbers, event: EventCrossing) -> np.ndarray:
    """Jacobian of the resets that close an accumulation, of all contacts that the mode entered holds."""
    code = program.code
    jacobian = _reset_jacobian(program, numbers, code.resets[event.guard, 1], event.before)
    impacts = np.flatnonzero(code.resets[:, 0] != code.resets[:, 1])
    held = slice(code.mode_constraints[event.target], code.mode_constraints[event.target + 1])
    own = code.function_classes[event.guard]
    contacts = {code.function_classes[g]: g for g in impacts if code.function_classes[g] != own}
    others = [contacts[c] for c in code.function_classes[held] if c in contacts]
    for guard in others:
        jacobian = _reset_jacobian(program, numbers, code.resets[guard, 1], event.before) @ jacobian
    for _ in range(MAX_SQUARINGS if others else 0):  # in turn, until all rates are zero
        jacobian = jacobian @ jacobian
    return jacobian


def _check_accumulation(own: np.ndarray, closing: np.ndarray, before: np.ndarray, after: np.ndarray) -> None:
    """Raise unless the errors of impacts with ever smaller rates are taken out where they are closed."""
    apart, sizes = np.abs(closing @ own - closing), np.abs(closing) @ (np.abs(own) + np.eye(len(own)))
    missed, rates = np.abs(after - closing @ before), np.abs(after) + np.abs(closing) @ np.abs(before)
    if apart.max() > SAME_RATES_SHARE * sizes.max() or missed.max() > SAME_RATES_SHARE * rates.max():
        raise SaltationError(
            "an accumulation of events was closed, and the mode entered has other rates than the mean of the "
            "flights, as with friction"
        )


def _check_grazing(guard: np.ndarray, dwell: float) -> None:
    if not dwell > 0.0:
        raise SaltationError("two events at one instant: which neighbours meet first depends on the side")
    if not abs(guard[1]) > GRAZING_SHARE * dwell * abs(guard[2]):
        raise SaltationError("the event function has a double zero (grazing): some neighbours miss it")


def _other_guards_at_zero(
    program: Program, mode: int, guard: int, left: LinearisedTape, dwell: float
) -> list[int]:
    """Other guards of the mode that reach zero at the same time, without those that are zero all along."""
    code = program.code
    guards = np.arange(code.mode_guards[mode], code.mode_guards[mode + 1])
    jets = left.jets[code.function_slots[guards]]
    zero = np.abs(jets[:, 0]) < COINCIDENT_EVENT_SHARE * dwell * np.abs(jets[:, 1])
    return guards[zero & (code.function_slots[guards] != code.function_slots[guard])].tolist()


def _met_together(left: LinearisedTape, slot: int, other: int, tangents: np.ndarray) -> bool:
    """Whether all neighbours reach two functions at one instant: on a rigid cam the phase tells both."""
    delays = [left.gradients[one] / left.jets[one, 1] for one in (slot, other)]
    apart, terms = np.abs((delays[0] - delays[1]) @ tangents), np.abs(delays) @ np.abs(tangents)
    return bool(apart.max() <= CONSTRAINT_SHARE * terms.max())


def _check_constraints(fixed: np.ndarray, neighbours: np.ndarray, sizes: np.ndarray) -> None:
    """Raise unless `neighbours`, columns after the event but for the flow from there on, keep the next mode's
    constraints but for rounding; `sizes` are sums of their absolute terms."""
    missed = np.abs(fixed @ neighbours).max(axis=1, initial=0.0)
    terms = (np.abs(fixed) @ sizes).max(axis=1, initial=0.0)
    # A velocity that is held at zero may be a rounding error, and all terms with it.
    rounding = ROUNDING_SHARE * np.abs(fixed).max(axis=1, initial=0.0) * max(1.0, np.abs(neighbours).max())
    if (missed > CONSTRAINT_SHARE * terms + rounding).any():
        raise SaltationError("the next mode's constraints hold by a coincidence: neighbours do not enter it")
