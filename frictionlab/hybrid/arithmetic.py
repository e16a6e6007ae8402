"""Operations that Python does not have: a fused multiply-add, calls by address, quick logarithms.

Intrinsics of numba, for use in a @kernel; without numba they are plain arithmetic, and calls are never
reached, as there are no addresses.
"""

from __future__ import annotations

import math
from typing import Any

from frictionlab.hybrid import logarithms
from frictionlab.hybrid.compiled import NUMBA


def _plain_fma(a, b, c):
    return a * b + c


def _plain_log2(x):
    return math.log2(x) if x > 0.0 else -1023.0


def _plain_exp2(x):
    return 2.0 ** min(max(x, -1000.0), 1000.0)


def _plain_call(address, *arguments):
    raise NotImplementedError("there is no native code without numba")


def _intrinsics() -> tuple[Any, ...]:
    from llvmlite import ir
    from numba import types
    from numba.extending import intrinsic

    @intrinsic
    def fma(typing_context, a, b, c):
        """a*b + c, rounded once."""
        number = types.float64

        def code(context, builder, signature, arguments):
            return builder.fma(*arguments)

        return number(number, number, number), code

    def by_address(context, builder, signature, arguments):
        address, *arrays, order = arguments
        passed = [
            context.make_array(kind)(context, builder, array).data
            for kind, array in zip(signature.args[1:-1], arrays, strict=True)
        ] + [order]
        kind = ir.FunctionType(ir.VoidType(), [each.type for each in passed])
        builder.call(builder.inttoptr(address, kind.as_pointer()), passed)
        return context.get_dummy_value()

    @intrinsic
    def call(typing_context, address, z, constants, terms, J, order):
        """Call native(z, constants, terms, J, order) at an address, with pointers to the arrays' data."""
        return types.void(types.int64, z, constants, terms, J, types.int64), by_address

    @intrinsic
    def call_step(typing_context, address, z, constants, terms, J, control, order):
        """The same with one array more."""
        return types.void(types.int64, z, constants, terms, J, control, types.int64), by_address

    def of_one_number(emit: Any) -> Any:
        @intrinsic
        def function(typing_context, x):
            def code(context, builder, signature, arguments):
                return emit(ir, builder, arguments[0])

            return types.float64(types.float64), code

        return function

    return fma, call, call_step, of_one_number(logarithms.log2), of_one_number(logarithms.exp2)


_PLAIN = _plain_fma, _plain_call, _plain_call, _plain_log2, _plain_exp2
fma, call_native, call_native_step, log2, exp2 = _PLAIN if NUMBA is None else _intrinsics()
