"""Which affine sums of a tape, and which states, native code computes as one vector.

The accelerations of a mechanical model are sums of much the same displacements, velocities and forces, each
with its own factors.  A vector does for two or four of them what scalars do for one.  Each sum has its terms
in the sequence of the tape, so its bits are the same.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from operator import ne

from frictionlab.hybrid.kernels.arithmetic import PARTS
from frictionlab.tape.functions import AFFINE
from frictionlab.tape.tape import Tape

Group = tuple[int, ...]  # of slots, whose coefficients are one vector
LEAST_TERMS, NEAR = 3, 8  # of the sums, and among how many operations they are
TERMS_FOR_EACH = 4  # of them with different slots, as these must be brought together first


def sums_side_by_side(tape: Tape, flow: Sequence[int]) -> list[Group]:
    """Groups of affine sums of mostly the same slots, of which nothing is needed before the last one.

    The sums of a group are all derivatives of states, whose slots are the `flow`, or none is.
    """
    groups, taken = list[Group](), set[int]()
    slots = {
        slot: tape.slots_of(a, b)
        for slot, (kind, a, b) in enumerate(tape.ops, start=tape.inputs)
        if kind == AFFINE and b - a >= LEAST_TERMS
    }
    for first in slots:
        group = [first]
        for slot in range(first + 1, first + NEAR):
            free = first not in taken and slot in slots and slot not in taken
            free = free and (first in flow) == (slot in flow)
            if free and _are_alike(slots[first], slots[slot]) and not _is_used(tape, group, slot):
                group.append(slot)
        group = group[: PARTS if len(group) >= PARTS else 2]
        if len(group) > 1:
            groups.append(tuple(group))
            taken.update(group)
    return groups


def _are_alike(some: list[int], others: list[int]) -> bool:
    """Whether few terms of two sums have different slots."""
    return len(some) == len(others) and TERMS_FOR_EACH * sum(map(ne, some, others)) <= len(some)


def _is_used(tape: Tape, group: list[int], last: int) -> bool:
    """Whether an operation up to the one of slot `last` needs a slot of a group that begins before."""
    operations = range(group[0] + 1 - tape.inputs, last + 1 - tape.inputs)
    return any(slot in group for op in operations for slot in tape.operands(op))


def states_side_by_side(flow: Sequence[int], sums: Iterable[Group]) -> list[Group]:
    """All states, in groups whose derivatives are `sums` of one vector, or states of such a group."""
    groups, states, taken = list(sums), list[Group](), set[int]()
    state_of = dict(zip(flow, range(len(flow)), strict=True))
    for group in groups:  # grows
        some = tuple(state_of[slot] for slot in group if slot in state_of)
        if len(some) == len(group) and taken.isdisjoint(some):
            taken.update(some)
            groups.append(some)
            states.append(some)
    return states + [(state,) for state in range(len(flow)) if state not in taken]
