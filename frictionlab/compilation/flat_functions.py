"""Kernels as LLVM's intermediate representation, before any optimisation, and for each entry point a function
of one table of words, which calls the kernel.

numba infers the types and writes the instructions; here it neither optimises nor emits machine code, as both
depend on the processor.  (Optimised instructions have this machine's size of pointers built in.)

The words of a table are the results, then the arguments in their order, fields of named tuples one after the
other: a number is one word (of a float its bits), an array its address and its length along each axis.  The
layout is the same on every processor, and a caller needs to know nothing else about numba.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import count
from typing import Any

import numba
import numpy as np
from llvmlite import ir
from numba import njit, typeof, types
from numba.core import sigutils
from numba.extending import intrinsic
from numba.np.arrayobj import populate_array

from frictionlab.compilation.entry_points import EntryPoint, Symbol
from frictionlab.compilation.manifest import Function, Word
from frictionlab.compilation.numba_internals import compile_for, jit_options

WORD = ir.IntType(64)
KINDS = {types.int64: "i8", types.float64: "f8", types.boolean: "b1"}


@dataclass(frozen=True)
class FlatFunction:
    """A compiled function: of a table, for an entry point, or of numbers, with an empty `table`.

    Parameters
    ----------
    name : str
    symbol : str
        The name that numba gave it in LLVM's module.
    table : Function
    """

    name: str
    symbol: str
    table: Function


@intrinsic
def integer_at(typing_context: Any, table: Any, place: Any) -> Any:
    """A word of the table as an integer."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.load(builder.gep(arguments[0], [arguments[1]]))

    return types.int64(table, types.int64), code


@intrinsic
def float_at(typing_context: Any, table: Any, place: Any) -> Any:
    """A word of the table, taken as the bits of a float."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.bitcast(builder.load(builder.gep(arguments[0], [arguments[1]])), ir.DoubleType())

    return types.float64(table, types.int64), code


@intrinsic
def put(typing_context: Any, table: Any, place: Any, value: Any) -> Any:
    """Write a number into a word of the table."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        table, place, value = arguments
        if isinstance(value.type, ir.DoubleType):
            value = builder.bitcast(value, WORD)
        elif value.type.width < WORD.width:
            value = builder.zext(value, WORD)
        builder.store(value, builder.gep(table, [place]))
        return context.get_dummy_value()

    return types.void(table, types.int64, value), code


def _array_at(kind: Any) -> Any:
    element, axes = kind.dtype, kind.ndim

    @intrinsic
    def array_at(typing_context: Any, table: Any, place: Any) -> Any:
        """The array whose address and lengths are in the table's words from `place` on."""

        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            table, place = arguments
            address, *shape = (
                builder.load(builder.gep(table, [builder.add(place, WORD(i))])) for i in range(1 + axes)
            )
            size = WORD(context.get_abi_sizeof(context.get_data_type(element)))
            strides = [size]
            for length in shape[:0:-1]:
                strides.insert(0, builder.mul(strides[0], length))
            array = context.make_array(kind)(context, builder)
            data = builder.inttoptr(address, array.data.type)
            populate_array(array, data=data, shape=shape, strides=strides, itemsize=size, meminfo=None)
            return array._getvalue()

        return kind(table, types.int64), code

    return array_at


def flat_function(entry: EntryPoint) -> FlatFunction:
    """Compile the function of an entry point, within :func:`captured_libraries`."""
    inner = compile_for(entry.kernel, tuple(map(typeof, entry.arguments.values())))
    results = _results(inner.signature.return_type)
    names: dict[str, Any] = {
        "integer_at": integer_at,
        "float_at": float_at,
        "put": put,
        "kernel": entry.kernel,
    }
    leaves: list[Word] = []
    place = count(len(results))
    read = [_expression(name, value, names, leaves, place) for name, value in entry.arguments.items()]
    lines = [f"def {entry.name}(table):", f"    result = kernel({', '.join(read)})"]
    if len(results) > 1:
        lines += [f"    put(table, {i}, result[{i}])" for i in range(len(results))]
    elif results:
        lines.append("    put(table, 0, result)")
    exec("\n".join(lines), names)
    function = njit(**jit_options(numba))(names[entry.name])
    result = compile_for(function, (types.CPointer(types.int64),))
    table = Function(tuple(results), tuple(leaves), _class_name(inner.signature.return_type))
    return FlatFunction(entry.name, result.fndesc.llvm_func_name, table)


def scalar_function(symbol: Symbol) -> FlatFunction:
    """Compile a function of numbers, within :func:`captured_libraries`."""
    arguments, _ = sigutils.normalize_signature(symbol.signature)
    function = getattr(symbol.function, "py_func", symbol.function)
    result = compile_for(njit(**jit_options(numba))(function), arguments)
    return FlatFunction(symbol.name, result.fndesc.llvm_func_name, Function((), ()))


def _is_named_tuple(kind: Any) -> bool:
    return isinstance(kind, types.BaseNamedTuple)


def _class_name(kind: Any) -> str:
    return kind.instance_class.__name__ if _is_named_tuple(kind) else ""


def _results(kind: Any) -> list[Word]:
    if isinstance(kind, types.NoneType):
        return []
    if _is_named_tuple(kind):
        return [(name, KINDS[each], 0) for name, each in zip(kind.fields, kind.types, strict=True)]
    kind = types.unliteral(kind)
    return [("result", "i8" if isinstance(kind, types.Integer) else KINDS[kind], 0)]


def _expression(name: str, value: Any, names: dict[str, Any], leaves: list[Any], place: Any) -> str:
    """Python text that reads an argument from the table; appends its numbers and arrays to `leaves`."""
    if isinstance(value, tuple):
        fields = getattr(value, "_fields", range(len(value)))
        parts = [
            _expression(f"{name}.{f}", each, names, leaves, place)
            for f, each in zip(fields, value, strict=True)
        ]
        if not hasattr(value, "_fields"):
            return f"({', '.join(parts)},)"
        names[type(value).__name__] = type(value)
        return f"{type(value).__name__}({', '.join(parts)})"
    at = next(place)
    if isinstance(value, np.ndarray):
        element, axes = value.dtype.str[1:], value.ndim
        leaves.append((name, element, axes))
        kind = typeof(value)  # as the kernel was compiled for: some arrays are read only
        reader = f"array_{element}_{axes}_{kind.mutable}"
        if reader not in names:
            names[reader] = _array_at(kind)
        for _ in range(axes):
            next(place)
        return f"{reader}(table, {at})"
    leaves.append((name, "f8" if isinstance(value, float) else "i8", 0))
    return f"{'float_at' if isinstance(value, float) else 'integer_at'}(table, {at})"
