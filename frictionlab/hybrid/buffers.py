"""Growing storage: the kernel fills records of fixed size, which are cut and joined here."""

from __future__ import annotations

import numpy as np

from frictionlab.hybrid.bookkeeping import Record, Work
from frictionlab.hybrid.jets import COLUMNS
from frictionlab.hybrid.layout import Code
from frictionlab.hybrid.problem import Raw
from frictionlab.hybrid.roots import DEPTH
from frictionlab.hybrid.status import Status

LINE = 64  # bytes


def new_record(code: Code, steps: int, events: int, points: int) -> Record:
    """Empty buffers."""
    n = code.inputs
    return Record(
        np.empty((steps, 2)),
        np.empty(steps, dtype=np.int64),
        np.empty((steps, n)),
        np.empty(events),
        np.empty((events, 3), dtype=np.int64),
        np.empty((events, 2, n)),
        np.empty(points),
        np.empty(points, dtype=np.int64),
        np.empty((points, n)),
    )


def new_work(slots: int, code: Code, order: int) -> Work:
    """Scratch arrays for one run."""
    return Work(
        jets=np.zeros((slots, columns(order))),
        values=np.zeros((slots, columns(0))),
        bounds=np.zeros((slots, columns(order))),
        stack=np.zeros((DEPTH + 1, order + 1)),
        intervals=np.zeros((DEPTH + 1, 2)),
        scaled=np.zeros(order + 1),
        roots=np.zeros(order + 2),
        multiplicity=np.zeros(order + 2, dtype=np.int64),
        declared=np.zeros(len(code.function_slots), dtype=np.int64),
        zeros=np.zeros(max(1, len(code.targets)), dtype=np.int64),
        before=np.zeros(code.inputs),
    )


def columns(order: int) -> int:
    """Length of a row of jets: as native code has it, longer for orders that only the interpreter knows."""
    return max(COLUMNS, order + 1)


def aligned(*shape: int) -> np.ndarray:
    """Zeros that begin with a cache line, so that no vector of lanes lies across two."""
    size = int(np.prod(shape))
    room = np.zeros(size + LINE // 8)
    first = -room.ctypes.data % LINE // 8
    return room[first : first + size].reshape(shape)


class Pieces:
    """Records in the order in which they were filled."""

    def __init__(self) -> None:
        self._parts: list[Record] = []
        self.steps = self.events = 0

    def add(self, record: Record, steps: int, events: int, points: int) -> None:
        """Keep the filled part of a record."""
        lengths = [steps] * 3 + [events] * 3 + [points] * 3
        cut = (
            array[:n].copy() if n < len(array) else array for array, n in zip(record, lengths, strict=True)
        )
        self._parts.append(Record(*cut))
        self.steps += int(steps)
        self.events += int(events)

    def raw(self, code: Code, t: float, state: np.ndarray, mode: int, status: Status) -> Raw:
        """Everything joined."""
        parts = self._parts or [new_record(code, 0, 0, 0)]
        arrays = parts[0] if len(parts) == 1 else map(np.concatenate, zip(*parts, strict=True))
        joined = dict(zip(Record._fields, arrays))
        return Raw(**joined, t=float(t), state=state, mode=mode, status=status)
