"""What depends on parts of numba that its manual does not describe: `UNDOCUMENTED` names them.

A test says which of them a new version of numba lacks.  Here are the options by which kernels are compiled,
the cache of what numba has compiled (`KernelCache`), and the context in which numba gives its instructions
in place of machine code (`captured_libraries`), from which objects are made ahead of time.
"""

from __future__ import annotations

import hashlib
import logging
import pickle
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import Any

from frictionlab.cache_folder import read, write

LOGGER = logging.getLogger(__name__)
NO_CODE = 1  # stands for an address that nothing calls
UNDOCUMENTED = (
    "numba.core.options:DefaultOptions",
    "numba.core.ccallback:CFunc.compile",
    "numba.core.sigutils:normalize_signature",
    "numba.core.compiler:CompileResult._rebuild",
    "numba.core.compiler:CompileResult._reduce",
    "numba.core.serialize:dumps",
    "numba.core.codegen:CPUCodeLibrary._optimize_functions",
    "numba.core.codegen:CPUCodeLibrary._ensure_finalized",
    "numba.core.codegen:CPUCodeLibrary.finalize",
    "numba.core.codegen:CPUCodeLibrary.has_dynamic_globals",
    "numba.core.codegen:JITCodeLibrary.get_pointer_to_function",
    "numba.core.codegen:JITCPUCodegen.set_env",
    "numba.core.codegen:JITCPUCodegen.magic_tuple",
    "numba.core.lowering:BaseLower.create_cpython_wrapper",
    "numba.core.lowering:BaseLower.create_cfunc_wrapper",
    "numba.core.types:BaseNamedTuple",
    "numba.np.arrayobj:populate_array",
)


def jit_options(numba: Any) -> dict[str, Any]:
    """Compile without reference counts: kernels allocate nothing, and counting would take most of their
    time."""
    counts = {"_nrt": False} if hasattr(numba.core.options.DefaultOptions, "_nrt") else {}
    return {"error_model": "numpy", "boundscheck": False, **counts}


def compiled_kernel(numba: Any, function: Callable, folder: str, further: dict[str, bool]) -> Any:
    """A function that numba compiles when it is called, and keeps in a folder."""
    dispatcher = numba.njit(nogil=True, **jit_options(numba), **further)(function)
    dispatcher._cache = KernelCache(function, folder)
    return dispatcher


@cache  # keeps the compiled function alive: its code is freed with it
def c_function(numba: Any, function: Callable, signature: str, folder: str) -> Any:
    """A function that C code can call, compiled by numba."""
    from numba.core.ccallback import CFunc
    from numba.core.sigutils import normalize_signature

    options = jit_options(numba)
    compiled: Any = CFunc(function, normalize_signature(signature), locals={}, options=options)
    compiled._cache = KernelCache(function, folder)
    compiled.compile()
    return compiled


class KernelCache:
    """The cache of one kernel, in place of numba's: a file for each of its signatures and processors.

    Numba's own cache finds the file of a signature by an index file, checks neither, and raises an error when
    one is damaged.
    """

    def __init__(self, function: Callable, folder: str) -> None:
        self._function = function
        self.cache_path = folder

    def load_overload(self, signature: Any, context: Any) -> Any:
        """A compilation's result if an earlier process has kept it, else None."""
        context.refresh()  # registers the types that the result is made of
        path = self._path(signature, context)
        content = None if path is None else read(path)
        if content is None:
            LOGGER.info("compiling kernel %s: not in the cache", self._function.__name__)
            return None
        LOGGER.debug("kernel %s found in the cache", self._function.__name__)
        from numba.core.compiler import CompileResult

        try:
            return CompileResult._rebuild(context, *pickle.loads(content))
        except Exception:  # written by another build of the same version of numba
            return None

    def save_overload(self, signature: Any, result: Any) -> None:
        """Keep the result of a compilation, unless it holds addresses of this process."""
        from numba.core.serialize import dumps

        path = self._path(signature, result.target_context)
        if path is not None and not result.library.has_dynamic_globals:
            write(path, dumps(result._reduce()))

    def flush(self) -> None:
        """Delete nothing: results from other sources have other names."""

    def _path(self, signature: Any, context: Any) -> Path | None:
        function = self._function
        source = _source_digest(function.__code__.co_filename, function.__globals__.get("__loader__"))
        what = signature, context.codegen().magic_tuple(), function.__module__, function.__qualname__
        text = repr((what, source))
        if not (self.cache_path and source) or function.__closure__ or " at 0x" in text:
            return None  # its code depends on more than its source and the types
        name = hashlib.blake2b(text.encode(), digest_size=16).hexdigest()
        return Path(self.cache_path) / f"{function.__name__}-{name}.kernel"


def has_kernel(folder: str, name: str) -> bool:
    """Whether the folder holds compiled code of a kernel of this name."""
    return any(Path(folder).glob(f"{name}-*.kernel"))


@cache
def _source_digest(file: str, loader: Any) -> str:
    """Digest of a source file, which may be in a zip file; "" where there is none, as at the prompt."""
    with suppress(OSError, AttributeError):
        return hashlib.blake2b(loader.get_data(file), digest_size=16).hexdigest()
    return ""


@contextmanager
def captured_libraries() -> Iterator[list[Any]]:
    """Context in which numba compiles to unoptimised instructions, and to nothing else.

    The list that it yields is filled with the libraries of all functions compiled within it.  The library of
    a function does not contain the functions that it calls.
    """
    from unittest.mock import patch

    from numba.core.codegen import CPUCodeLibrary, JITCodeLibrary, JITCPUCodegen
    from numba.core.lowering import BaseLower

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


def compile_for(dispatcher: Any, types: tuple[Any, ...]) -> Any:
    """numba's result of compiling a function for these types."""
    dispatcher.compile(types)
    result = dispatcher.overloads[types]
    result.library._ensure_finalized()  # numba has not yet done so for a function that no other calls
    return result


def linked(libraries: list[Any]) -> Any:
    """One module with the functions of all libraries, each once."""
    import llvmlite.binding as llvm

    whole = llvm.parse_assembly("")
    for library in libraries:
        module = library._final_module
        for function in module.functions:
            if not function.is_declaration and function.linkage == llvm.Linkage.external:
                function.linkage = "weak_odr"
        whole.link_in(module, preserve=True)
    return whole
