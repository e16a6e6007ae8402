"""Processors and systems that kernels are compiled for, and which of them fit this machine."""

from __future__ import annotations

import platform
import sys
from dataclasses import dataclass

# Features of x86-64-v3 beyond the baseline; a processor must have all of them.
V3_FEATURES = "avx avx2 bmi bmi2 f16c fma lzcnt movbe".split()
X86, ARM = ("x86_64", "amd64"), ("aarch64", "arm64")  # as machines name themselves


@dataclass(frozen=True)
class Target:
    """A processor and a system.

    Parameters
    ----------
    name : str
        Name of the target, and of an object's file without its ending.
    triple, cpu, features : str
        As LLVM names them.
    system : str
        What ``sys.platform`` begins with.
    machines : tuple of str
        Names that machines give such a processor, in lower case.
    wheel : str
        The platform tag of a wheel that carries the object.
    needs : tuple of str
        Features of the processor that the code uses beyond the baseline.
    """

    name: str
    triple: str
    cpu: str
    features: str
    system: str
    machines: tuple[str, ...]
    wheel: str
    needs: tuple[str, ...] = ()

    @property
    def file(self) -> str:
        """Name of the file in the folder of objects."""
        return "kernels.wasm" if self.system == "emscripten" else self.name + ".o.xz"


# MCJIT loads ELF objects on Windows too; numba uses it so.
_WINDOWS = "pc-windows-msvc-elf"
# The objects call nothing of the system, so this is the oldest one that Python and numpy have wheels for.
_LINUX = "manylinux_2_17"
_X86_LINUX = ("linux", X86, f"{_LINUX}_x86_64")
_X86_WINDOWS = ("win32", X86, "win_amd64")
# In the order in which they are tried.
TARGETS = (
    Target("linux-x86-64-v3", "x86_64-unknown-linux-gnu", "x86-64-v3", "", *_X86_LINUX, tuple(V3_FEATURES)),
    Target("linux-x86-64", "x86_64-unknown-linux-gnu", "x86-64", "", *_X86_LINUX),
    Target("linux-aarch64", "aarch64-unknown-linux-gnu", "generic", "", "linux", ARM, f"{_LINUX}_aarch64"),
    Target("macos-aarch64", "arm64-apple-macosx11", "apple-m1", "", "darwin", ARM, "macosx_11_0_arm64"),
    Target("windows-x86-64-v3", f"x86_64-{_WINDOWS}", "x86-64-v3", "", *_X86_WINDOWS, tuple(V3_FEATURES)),
    Target("windows-x86-64", f"x86_64-{_WINDOWS}", "x86-64", "", *_X86_WINDOWS),
)
WEB = Target(
    "web", "wasm32-unknown-unknown", "generic",
    "+simd128,+bulk-memory,+nontrapping-fptoint,+sign-ext,+mutable-globals", "emscripten", ("wasm32",),
    "",
)  # fmt: skip


def targets_of_system() -> list[Target]:
    """The targets for this system and kind of processor, whatever its features."""
    machine = platform.machine().lower()
    return [each for each in TARGETS if sys.platform.startswith(each.system) and machine in each.machines]


def targets_of_machine() -> list[Target]:
    """The targets whose code runs here, the best one first."""
    fitting = targets_of_system()
    features = processor_features() if any(target.needs for target in fitting) else {}
    return [target for target in fitting if all(features.get(name) for name in target.needs)]


def processor_features() -> dict[str, bool]:
    """What this processor can do, by LLVM's names."""
    import llvmlite.binding as llvm

    try:
        return dict(llvm.get_host_cpu_features())
    except RuntimeError:  # LLVM does not know the processor
        return {}
