"""The compiled kernels that fit this machine, as functions that Python calls."""

from __future__ import annotations

import ctypes
import logging
import lzma
import struct
import sys
from array import array
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import cache, update_wrapper
from typing import Any, TypeVar

import numpy as np

from frictionlab.compilation.kernel_sources import digest
from frictionlab.compilation.manifest import Function, Manifest, compiled_object
from frictionlab.compilation.targets import targets_of_machine

LOGGER = logging.getLogger(__name__)
GAPS = "with gaps"  # stands for the type of an array that is not contiguous
FLOAT, INTEGER = "<f80", "<i80"  # the type and the number of axes
AXES = "0123456789"
ENTRY = ctypes.CFUNCTYPE(ctypes.c_int32, ctypes.c_void_p)
DOUBLE = struct.Struct("d")
RESULTS = {"i8": "q", "f8": "d", "b1": "?7x"}  # words of results, as `struct` reads them
DATA_OFFSET = 16  # bytes of an array's object before the address of its data (numpy's PyArrayObject)
T = TypeVar("T", bound=tuple)


@dataclass(frozen=True)
class LoadedKernels:
    """The functions of an object.

    Parameters
    ----------
    manifest : Manifest
    digest : str
        Of the sources and of the object.
    engine : Any
        LLVM's, which owns the code.
    """

    manifest: Manifest
    digest: str
    engine: Any

    def function(self, kernel: Callable) -> Callable:
        """The compiled function of a kernel; the kernel itself where it is no entry point."""
        table = self.manifest.functions.get(kernel.__name__)
        return kernel if table is None else CompiledKernel(kernel, table, self.address(kernel.__name__))

    def address(self, name: str) -> int:
        """Address of a function's code, by its name."""
        return int(self.engine.get_function_address(name))


def load_kernels() -> tuple[LoadedKernels | None, str]:
    """The kernels compiled from these sources for this machine; else None, and why there are none."""
    try:
        import llvmlite.binding as llvm

        llvm.initialize_native_target()
        llvm.initialize_native_asmprinter()
    except Exception as error:  # it is not installed, or its library cannot be loaded
        return None, f"llvmlite cannot be imported ({type(error).__name__}: {error})"
    targets = targets_of_machine()
    if not targets:
        return None, "there are no kernels compiled ahead of time for this processor and system"
    compiled = compiled_object([target.file for target in targets])
    if isinstance(compiled, str):
        return None, compiled
    LOGGER.debug("kernels compiled ahead of time: %s", compiled.name)
    code, manifest = lzma.decompress(compiled.content), compiled.manifest
    sources = "".join(each.code for each in manifest.sources.values()).encode()
    return LoadedKernels(manifest, digest(sources + code), _engine(llvm, code)), ""


def _engine(llvm: Any, code: bytes) -> Any:
    machine = llvm.Target.from_default_triple().create_target_machine(jit=True)
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine)
    engine.add_object_file(llvm.ObjectFileRef.from_data(code))
    engine.finalize_object()
    return engine


class CompiledKernel:
    """A kernel as machine code, called like the Python function that it was compiled from.

    Its arguments go into a table of words (see the docstring of the package).
    """

    def __init__(self, kernel: Callable, table: Function, address: int) -> None:
        update_wrapper(self, kernel)
        self._name = kernel.__name__
        self._call = ENTRY(address)
        self._arguments = table.arguments
        self._kinds = "".join(f"<{kind}{axes}" for _, kind, axes in table.arguments)
        self._results = struct.Struct("=" + "".join(RESULTS[kind] for _, kind, _ in table.results))
        self._room = array("q", bytes(self._results.size))  # for the results, at the beginning
        self._returns = _named_tuple(kernel, table.returns)

    @property
    def py_func(self) -> Callable:
        """The Python function that was compiled, by the name that it has in numba's functions."""
        return self.__wrapped__  # pyright: ignore[reportAttributeAccessIssue]  # wraps sets it

    def __call__(self, *arguments: Any) -> Any:
        words, kinds = self._room[:], []
        _append(arguments, words, kinds)
        if "".join(kinds) == self._kinds:
            return self._called(words)
        words, copies = self._converted(arguments)
        result = self._called(words)
        for own, copy in copies:
            own[...] = copy
        return result

    def _called(self, table: array[int]) -> Any:
        """What the code returns for the arguments in a table."""
        if status := self._call(table.buffer_info()[0]):
            raise RuntimeError(f"the kernel {self._name} ended with status {status}")
        results = self._results.unpack_from(table)
        if self._returns is not None:
            return self._returns(*results)
        return results[0] if results else None

    def prepared(self, arguments: tuple[Any, ...], place: int) -> Callable[[Any], Any]:
        """See :func:`prepared_call`."""
        table, kinds = self._room[:], []
        _append(arguments[:place], table, kinds)
        begin = len(table)
        _append(arguments[place:], table, kinds)
        if "".join(kinds) != self._kinds:  # some would have to be copied at each call
            return _partial(self, arguments, place)

        def call(value: Any, _kept: tuple[Any, ...] = arguments) -> Any:  # kept alive: the table points to it
            words = array("q")
            _append((value,), words, [])
            table[begin : begin + len(words)] = words
            return self._called(table)

        return call

    def _converted(self, arguments: Any) -> tuple[array[int], list[tuple[np.ndarray, np.ndarray]]]:
        """Words where arguments must be converted, and pairs of a given array and the copy to write back.

        Numbers take the expected type.  Arrays with gaps, or with other integers than expected, are copied.
        """
        leaves = list(_leaves(arguments))
        if len(leaves) != len(self._arguments):
            expected = f"{len(self._arguments)} numbers and arrays"
            raise TypeError(f"{self._name} takes {expected}, got {len(leaves)}: see its docstring")
        words, copies = self._room[:], []
        for leaf, (name, kind, axes) in zip(leaves, self._arguments, strict=True):
            if axes == 0:
                _append([float(leaf) if kind == "f8" else int(leaf)], words, [])
                continue
            if not (isinstance(leaf, np.ndarray) and _suits(leaf, kind) and leaf.ndim == axes):
                got = f"{leaf.dtype} with {leaf.ndim}" if isinstance(leaf, np.ndarray) else repr(leaf)
                rule = f"an array of numpy's type {kind!r} with {axes} axes"
                raise TypeError(f"{name} of {self._name} must be {rule}, got {got}: convert it")
            whole = np.ascontiguousarray(leaf, dtype=kind)
            copies.append((leaf, whole))
            _append([whole], words, [])
        return words, [(own, copy) for own, copy in copies if copy is not own and own.flags.writeable]


def prepared_call(function: Callable, arguments: tuple[Any, ...], place: int) -> Callable[[Any], Any]:
    """A kernel as a function of one of its arguments, a number or a tuple of numbers, the others fixed.

    For many calls with the same arrays, whose content may change: the table of arguments is made only once.

    Parameters
    ----------
    function : callable
        A kernel, compiled or not.
    arguments : tuple
        All arguments; that at `place` is an example.
    place : int
        Index of the argument that changes.
    """
    if isinstance(function, CompiledKernel):
        return function.prepared(arguments, place)
    return _partial(function, arguments, place)


def _partial(function: Callable, arguments: tuple[Any, ...], place: int) -> Callable[[Any], Any]:
    before, after = arguments[:place], arguments[place + 1 :]
    return lambda value: function(*before, value, *after)


def _suits(leaf: np.ndarray, kind: str) -> bool:
    """Whether an array's elements are of a type, or both are integers, signed or not, of any size."""
    return leaf.dtype.str[1:] == kind or {leaf.dtype.kind, kind[0]} <= {"i", "u"}


def _named_tuple(kernel: Callable, name: str) -> Any:
    """The class of that name in the module of a kernel; None for ""."""
    return kernel.__globals__[name] if name else None


def _data_address(values: np.ndarray) -> int:
    """Address of an array's data, seven times faster than asking numpy for it."""
    return ctypes.c_int64.from_address(id(values) + DATA_OFFSET).value


def _data_address_of_interface(values: np.ndarray) -> int:
    return values.__array_interface__["data"][0]


_example = np.zeros(1)
if sys.implementation.name != "cpython" or _data_address(_example) != _data_address_of_interface(_example):
    _data_address = _data_address_of_interface


class _Types(dict):
    """The names of numpy's types, remembered because numpy takes long to make them."""

    def __missing__(self, kind: np.dtype) -> str:
        self[kind] = kind.str
        return self[kind]


_TYPES = _Types()


def _append(arguments: Iterable[Any], words: array[int], kinds: list[str]) -> None:
    """Append the words of arguments to `words`, and the type and number of axes of each to `kinds`."""
    for each in arguments:
        if type(each) is np.ndarray:
            shape = each.shape
            words.append(_data_address(each))
            words.extend(shape)
            kinds.append(_TYPES[each.dtype] if each.flags.c_contiguous else GAPS)
            kinds.append(AXES[len(shape)])
        elif isinstance(each, tuple):
            table = getattr(each, "table", None)
            if table is None:
                _append(each, words, kinds)
            else:
                words.extend(table[0])
                kinds.append(table[1])
        elif isinstance(each, (float, np.floating)):
            words.frombytes(DOUBLE.pack(each))
            kinds.append(FLOAT)
        elif each is not None:
            words.append(int(each))
            kinds.append(INTEGER)


@cache
def _class_with_table(kind: type) -> type:
    """A subclass of a named tuple with the attribute `table`."""
    return type(kind.__name__, (kind,), {"table": None, "__module__": kind.__module__})


def with_table(arrays: T) -> T:
    """The same named tuple of arrays with a table of its words, for what is passed again and again."""
    words, kinds = array("q"), []
    _append(arrays, words, kinds)
    with_words = _class_with_table(type(arrays))(*arrays)
    with_words.table = words, "".join(kinds)
    return with_words


def _leaves(arguments: Iterable[Any]) -> Iterator[Any]:
    """The numbers and arrays in nested tuples, one after the other; None is left out."""
    for each in arguments:
        if isinstance(each, tuple):
            yield from _leaves(each)
        elif each is not None:
            yield each
