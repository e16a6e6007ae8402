"""What the writers of machine code say in LLVM's instructions: arithmetic, places in arrays, numbers.

A value is one number, or a vector with a number for each of several runs, which are the last axis of arrays.
"""

from __future__ import annotations

from typing import Any

from frictionlab.hybrid.logarithms import number


class Instructions:
    """Instructions on values; `row` is the length of a row of J, in values."""

    width = 1  # numbers in a value

    def __init__(self, ir: Any, build: Any, row: int) -> None:
        self.ir, self.build, self.row, self.whole = ir, build, row, ir.IntType(64)
        self.kind = ir.VectorType(ir.DoubleType(), self.width) if self.width > 1 else ir.DoubleType()
        self.called: dict[str, Any] = {}

    def _abs(self, a: Any) -> Any:
        return self._intrinsic("fabs", a)

    def _fma(self, a: Any, b: Any, c: Any) -> Any:
        return self._intrinsic("fma", a, b, c)

    def _intrinsic(self, name: str, *arguments: Any) -> Any:
        """One instruction for a number or for a vector."""
        kind = arguments[0].type
        vector = f"v{kind.count}" if hasattr(kind, "count") else ""
        return self._called(f"llvm.{name}.{vector}f64", kind, *arguments)

    def _call(self, name: str, *arguments: Any) -> Any:
        return self._called(name, self.ir.DoubleType(), *arguments)

    def _called(self, name: str, kind: Any, *arguments: Any) -> Any:
        if name not in self.called:
            signature = self.ir.FunctionType(kind, [kind] * len(arguments))
            self.called[name] = self.ir.Function(self.build.module, signature, name)
        return self.build.call(self.called[name], arguments)

    def _at(self, slot: int, column: Any) -> Any:
        return self._load(column, slot * self.row)

    def _place(self, slot: int, column: Any) -> Any:
        return self._ahead(column, self.whole(slot * self.row))

    def _ahead(self, place: Any, count: Any) -> Any:
        """So many values further."""
        numbers = count if self.width == 1 else self.build.mul(count, self.whole(self.width))
        return self.build.gep(place, [numbers])

    def _load(self, array: Any, i: int) -> Any:
        return self._vector(array, i, self.kind)

    def _store(self, value: Any, array: Any, i: int) -> None:
        self.build.store(value, self._pointer(array, i, self.kind), align=8)

    def _vector(self, array: Any, i: int, kind: Any) -> Any:
        return self.build.load(self._pointer(array, i, kind), align=8)

    def _pointer(self, array: Any, i: int, kind: Any) -> Any:
        place = self.build.gep(array, [self.whole(i * self.width)])
        return self.build.bitcast(place, kind.as_pointer())

    def _spread(self, value: Any) -> Any:
        """A number as a value."""
        return value

    def _as_number(self, count: Any) -> Any:
        return self._spread(self.build.sitofp(count, self.ir.DoubleType()))

    def _number(self, value: float) -> Any:
        return number(self.ir, self.kind, value)
