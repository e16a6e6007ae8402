"""Kernels as LLVM's intermediate representation, before any optimisation.

numba makes the types and the instructions; it neither optimises nor emits machine code, as both depend on the
processor.  (Optimised instructions have the sizes of pointers of this machine built in.)
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import Any
from unittest.mock import patch

import llvmlite.binding as llvm
from numba.core.codegen import CPUCodeLibrary, JITCodeLibrary, JITCPUCodegen
from numba.core.lowering import BaseLower

from frictionlab.hybrid.kernel_cache import KernelCache

NO_CODE = 1  # stands for an address that nothing calls


@contextmanager
def captured_libraries() -> Iterator[list[Any]]:
    """Context in which numba compiles to instructions that are not optimised, and to nothing else.

    The list that it gives is filled with the libraries of all functions compiled meanwhile, without those
    that they call.
    """
    libraries: list[Any] = []

    def keep_layout(library: Any, module: Any) -> None:
        module.data_layout = library._codegen._data_layout

    def finalize(library: Any) -> None:
        library._finalized = True
        libraries.append(library)

    def nothing(*arguments: Any) -> None:
        return None

    replaced = {
        CPUCodeLibrary: {"_optimize_functions": keep_layout, "finalize": finalize},
        JITCodeLibrary: {"get_pointer_to_function": lambda library, name: NO_CODE},
        JITCPUCodegen: {"set_env": nothing},
        KernelCache: {"load_overload": nothing, "save_overload": nothing},
        BaseLower: {"create_cpython_wrapper": nothing, "create_cfunc_wrapper": nothing},
    }
    with ExitStack() as stack:
        for owner, methods in replaced.items():
            for name, method in methods.items():
                stack.enter_context(patch.object(owner, name, method))
        yield libraries


def compiled(dispatcher: Any, types: tuple[Any, ...]) -> Any:
    """numba's result of compiling a function for these types."""
    dispatcher.compile(types)
    result = dispatcher.overloads[types]
    result.library._ensure_finalized()  # of what nothing else calls, numba has not finalized the library yet
    return result


def linked(libraries: list[Any]) -> Any:
    """One module with the functions of all libraries, each once."""
    whole = llvm.parse_assembly("")
    for library in libraries:
        module = library._final_module
        for function in module.functions:
            if not function.is_declaration and function.linkage == llvm.Linkage.external:
                function.linkage = "weak_odr"
        whole.link_in(module, preserve=True)
    return whole
