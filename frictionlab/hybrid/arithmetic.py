"""Two operations that Python does not have: a fused multiply-add, and a call by address.

Intrinsics of numba, for use in a @kernel; without numba the first is plain arithmetic and the second is
never reached, as there are no addresses.
"""

from __future__ import annotations

from typing import Any

from frictionlab.hybrid.compiled import NUMBA


def _plain_fma(a, b, c):
    return a * b + c


def _plain_call(address, z, constants, terms, J):
    raise NotImplementedError("there is no native code without numba")


def _intrinsics() -> tuple[Any, Any]:
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

    @intrinsic
    def call(typing_context, address, z, constants, terms, J):
        """Call native(z, constants, terms, J) at an address, with pointers to the arrays' data."""

        def code(context, builder, signature, arguments):
            pointers = [
                context.make_array(kind)(context, builder, array).data
                for kind, array in zip(signature.args[1:], arguments[1:], strict=True)
            ]
            kind = ir.FunctionType(ir.VoidType(), [pointer.type for pointer in pointers])
            builder.call(builder.inttoptr(arguments[0], kind.as_pointer()), pointers)
            return context.get_dummy_value()

        return types.void(types.int64, z, constants, terms, J), code

    return fma, call


fma, call_native = (_plain_fma, _plain_call) if NUMBA is None else _intrinsics()
