"""Native code on demand: compiled in the background once a mode has been run for long, and kept in a folder.

Only structure is compiled, never parameter values.  Since native code gives what the interpreter gives to the
last bit, it does not matter when a run changes over to it.
"""

from __future__ import annotations

import gc
import hashlib
import logging
from collections.abc import Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import replace
from functools import cache
from itertools import accumulate
from pathlib import Path
from typing import Any
from weakref import WeakKeyDictionary, ref

import numpy as np

from frictionlab import cache_folder
from frictionlab.compilation import llvm_instructions, machine_code
from frictionlab.compilation.decorators import prepare_arrays
from frictionlab.hybrid.codegen import jet_codegen, remainder_codegen, side_by_side, step_codegen
from frictionlab.hybrid.codegen.jet_codegen import ModeTape, jets_module
from frictionlab.hybrid.codegen.remainder_codegen import StepStructure
from frictionlab.hybrid.codegen.step_codegen import lane_step_module
from frictionlab.hybrid.free_memory import free_memory
from frictionlab.hybrid.kernels import arithmetic
from frictionlab.tape import functions, tape
from frictionlab.tape.program import Code, Numbers, Program, System, system_of
from frictionlab.tape.tape import Tape

LOGGER = logging.getLogger(__name__)
# number of a mode's jets after which compiling pays: interpreted, they take as long as the compilation
COMPILE_AFTER = 20_000
# Terms of a mode's affine sums, as of finite elements.  With more, its jets are not compiled: the kernel's
# loops take no longer, and LLVM would take hundreds of MB.
MOST_TERMS = 4000
ROOM_TO_COMPILE = (
    2**28
)  # bytes of free memory below which nothing is compiled: LLVM ends a process without them
NAME, STEP = "jets", "step"
_MADE: WeakKeyDictionary[Program, NativeCode] = WeakKeyDictionary()
_INTERPRETED: WeakKeyDictionary[Program, Code] = WeakKeyDictionary()
_ENGINES: list[Any] = []  # engines own the code, so they live as long as the process


class NativeCode:
    """The native code of a program's modes: their jets of all orders up to MAX_ORDER, and their lane steps.

    Attributes
    ----------
    interpreted, code : Code
        The program's arrays, without and with the addresses of what is compiled.
    tapes : dict of int to ModeTape
        By mode, what its jets are compiled from.
    requested : dict of int to Future
        Compilations in the background, also those that are done.  The key for jets is the mode, for steps of
        several runs ~mode.
    """

    def __init__(self, program: Program, before: NativeCode | None = None) -> None:
        count, known = len(program.tapes), 0 if before is None else len(before.tapes)
        modes = range(known, len(program.modes))
        self.tapes = {mode: _mode_tape(program, mode) for mode in modes}
        self._of_steps = {mode: _step_structure(program.code, mode) for mode in modes}
        self.requested: dict[int, Future[None]] = {}
        self._used, addresses, steps = np.zeros((3, count), dtype=np.int64)
        self.interpreted = interpreted_code(program)
        self.code: Code = prepare_arrays(program.code._replace(native=addresses, lanes=steps))
        self._last: System | None = None
        # of this program and those that it grew from or grows into; weak, as only the last one is in use
        self._family: list[ref[NativeCode]] = [] if before is None else before._family
        self._family.append(ref(self))
        if before is not None:
            before._share_with(self, known)
        for mode in modes:
            addresses[mode] = _load_from_cache(_path(self.tapes[mode]))
            steps[mode] = _load_from_cache(_path(self.tapes[mode], STEP, self._of_steps[mode]))

    def system(self, numbers: Numbers) -> System:
        """The program's arrays with numbers; those asked for last are remembered, for the next run."""
        last = self._last
        if last is None or last.numbers is not numbers:
            last = self._last = system_of(self.code, numbers)
        return last

    def _share_with(self, after: NativeCode, known: int) -> None:
        """Share what is compiled, now and later, with the code of a program with more modes after these."""
        after.tapes = self.tapes | after.tapes
        after._of_steps = self._of_steps | after._of_steps
        after.requested = self.requested
        after._used[:known] = self._used[:known]
        after.code.native[:known] = self.code.native[:known]
        after.code.lanes[:known] = self.code.lanes[:known]

    def _set_address(self, kind: str, mode: int, address: int) -> None:
        for member in filter(None, (one() for one in self._family)):
            if mode in member.tapes:
                getattr(member.code, kind)[mode] = address

    def used(self, modes: np.ndarray) -> None:
        """Count the jets computed in each mode; start the compilation of modes with many."""
        if not machine_code.HAS_MACHINE_CODE:
            return
        addresses = self.code.native.tolist()
        if all(addresses):
            return
        self._used += np.bincount(modes, minlength=len(self._used))
        for mode, (count, address) in enumerate(zip(self._used.tolist(), addresses, strict=True)):
            if address == 0 and count > COMPILE_AFTER:
                self._request(mode)

    def _request(self, mode: int) -> None:
        """Start the compilation of a mode, unless it is under way or there is no room for it."""
        tape = self.tapes[mode].tape
        small = len(tape.terms) <= MOST_TERMS and not tape.products
        if small and mode not in self.requested and free_memory() > ROOM_TO_COMPILE:
            self.requested[mode] = _worker().submit(self.compile, mode)

    def compile(self, mode: int) -> None:
        """Compile a mode now."""
        LOGGER.info("compiling machine code of mode number %d", mode)
        function = self.tapes[mode]
        with _garbage_collection_off():
            code = _emit_object(jets_module(function, NAME))
        _store(code, _path(function))
        self._set_address("native", mode, _load_object(code))

    def compile_step(self, mode: int) -> None:
        """Compile a mode's step of several runs now."""
        LOGGER.info("compiling machine code of mode number %d, for several runs", mode)
        function, more = self.tapes[mode], self._of_steps[mode]
        with _garbage_collection_off():
            code = _emit_object(lane_step_module(function, more, NAME))
        _store(code, _path(function, STEP, more))
        self._set_address("lanes", mode, _load_object(code))

    def forget(self) -> None:
        """Interpret all modes from now on, until code is asked for anew."""
        for addresses in (self.code.native, self.code.lanes):
            addresses[:] = 0
        self._used[:] = 0
        self.requested.clear()

    def share(self, modes: Iterable[int]) -> None:
        """Start the compilation of the lane steps of these modes."""
        for mode in modes if machine_code.HAS_MACHINE_CODE else ():
            known = self.code.lanes[mode] or self.code.powers[mode] or ~mode in self.requested
            if not known and not self.tapes[mode].tape.products and free_memory() > ROOM_TO_COMPILE:
                self.requested[~mode] = _worker().submit(self.compile_step, mode)


def interpreted_code(program: Program) -> Code:
    """The program's arrays without native code, prepared for kernels that take them again and again."""
    if program not in _INTERPRETED:
        _INTERPRETED[program] = prepare_arrays(program.code)
    return _INTERPRETED[program]


def native_code(program: Program) -> NativeCode:
    """The native code of a program, created once."""
    made = _MADE.get(program)
    if made is None:
        before = None if program.grown_from is None else program.grown_from()
        made = _MADE[program] = NativeCode(program, None if before is None else _MADE.get(before))
    return made


@contextmanager
def _garbage_collection_off() -> Iterator[None]:
    """Context without garbage collection, which would scan the many instruction objects again and again."""
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()


def _mode_tape(program: Program, mode: int) -> ModeTape:
    code = program.code
    flow = tuple(map(int, code.flow[mode]))
    kept = {*map(int, code.sections[mode])}
    for ranges in (code.mode_guards, code.mode_constraints):
        kept.update(map(int, code.function_slots[ranges[mode] : ranges[mode + 1]]))
    terms = [0, *accumulate(len(tape.terms) for tape in program.tapes)]
    first = int(code.mode_ops[mode]), terms[mode]
    return ModeTape(_with_units(program, mode, terms[mode]), first, flow, frozenset(kept))


def _with_units(program: Program, mode: int, first: int) -> Tape:
    """A mode's tape, which has as factors of its terms 1 and -1, and None for others."""
    tape, split = program.tapes[mode], len(program.code.ops) + first
    numbers = map(program.distinct.fixed, program.number_places[split : split + len(tape.terms)].tolist())
    units = (number if number in (1.0, -1.0) else None for number in numbers)
    terms = [(slot, unit) for (slot, _), unit in zip(tape.terms, units, strict=True)]
    return replace(tape, terms=terms)


@cache
def _worker() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(1, "frictionlab-compiler")


@cache
def _llvm() -> Any:
    """llvmlite's binding, ready to compile for this machine."""
    import llvmlite.binding as llvm

    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return llvm


@cache
def _machine() -> Any:
    llvm = _llvm()
    features = llvm.get_host_cpu_features().flatten()
    target = llvm.Target.from_default_triple()
    # More optimisation takes twice as long and gains nothing.
    return target.create_target_machine(cpu=llvm.get_host_cpu_name(), features=features, opt=1, jit=True)


@cache
def _host() -> str:
    """The sources, versions and processor on which compiled code depends; they enter the names of files."""
    import llvmlite

    llvm = _llvm()
    writers: Any = (jet_codegen, side_by_side, step_codegen, remainder_codegen)
    writers = (*writers, arithmetic, llvm_instructions, tape, functions)
    writer = "".join(module.__loader__.get_data(module.__file__).decode() for module in writers)
    cpu = llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()
    return "\n".join([writer, llvmlite.__version__, llvm.get_default_triple(), *cpu])


def _step_structure(code: Code, mode: int) -> StepStructure:
    first, last = code.mode_guards[mode : mode + 2]
    guards = tuple(map(int, code.function_slots[first:last]))
    groups = tuple(map(int, code.groups))
    return StepStructure(guards, groups, int(code.degrees[mode]), int(code.polynomial_degrees[mode]))


def _path(function: ModeTape, what: str = NAME, more: object = None) -> Path | None:
    if not machine_code.CACHE_FOLDER:
        return None
    tape = function.tape
    if tape.products:  # it is not compiled
        return None
    structure = (tape.inputs, tape.ops, tape.terms, sorted(function.kept))
    text = repr((structure, function.first, function.flow, more)) + _host()
    return Path(machine_code.CACHE_FOLDER) / f"{what}-{hashlib.sha256(text.encode()).hexdigest()[:24]}.o"


def _load_from_cache(path: Path | None) -> int:
    """Address of code that an earlier process has compiled, else 0."""
    if not machine_code.HAS_MACHINE_CODE or path is None:
        return 0
    code = cache_folder.read(path)
    LOGGER.debug("machine code %s %s the cache", path.name, "is not in" if code is None else "found in")
    return 0 if code is None else _load_object(code)


def _store(code: bytes, path: Path | None) -> None:
    if path is not None:
        cache_folder.write(path, code)


def _emit_object(module: Any) -> bytes:
    return _machine().emit_object(_llvm().parse_assembly(str(module)))


def _load_object(code: bytes) -> int:
    llvm = _llvm()
    jet_codegen.register_used(code)
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), _machine_of_engine())
    engine.add_object_file(llvm.ObjectFileRef.from_data(code))
    engine.finalize_object()
    _ENGINES.append(engine)
    return int(engine.get_function_address(NAME))


def _machine_of_engine() -> Any:
    """An engine takes its machine over, so each has one of its own."""
    return _llvm().Target.from_default_triple().create_target_machine(jit=True)
