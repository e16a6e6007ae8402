"""The processors and systems that kernels are compiled for, and which of them this machine is."""

from __future__ import annotations

import platform
import sys
from dataclasses import dataclass

# What x86-64-v3 has and the baseline has not; all of it has to be there.
V3_FEATURES = "avx avx2 bmi bmi2 f16c fma lzcnt movbe".split()
X86, ARM = ("x86_64", "amd64"), ("aarch64", "arm64")  # as machines call themselves


@dataclass(frozen=True)
class Target:
    """A processor and a system.

    Parameters
    ----------
    name : str
        Of the object's file.
    triple, cpu, features : str
        As LLVM knows them.
    system : str
        As ``sys.platform`` begins.
    machines : tuple of str
        Names that such a processor has, in small letters.
    needs : tuple of str
        Features of the processor that the code uses beyond the baseline.
    """

    name: str
    triple: str
    cpu: str
    features: str
    system: str
    machines: tuple[str, ...]
    needs: tuple[str, ...] = ()


# MCJIT loads ELF on Windows too, as numba has it do.
_WINDOWS = "pc-windows-msvc-elf"
# In the order in which they are tried.
TARGETS = (
    Target("linux-x86-64-v3", "x86_64-unknown-linux-gnu", "x86-64-v3", "", "linux", X86, tuple(V3_FEATURES)),
    Target("linux-x86-64", "x86_64-unknown-linux-gnu", "x86-64", "", "linux", X86),
    Target("linux-aarch64", "aarch64-unknown-linux-gnu", "generic", "", "linux", ARM),
    Target("macos-aarch64", "arm64-apple-macosx11", "apple-m1", "", "darwin", ARM),
    Target("windows-x86-64-v3", f"x86_64-{_WINDOWS}", "x86-64-v3", "", "win32", X86, tuple(V3_FEATURES)),
    Target("windows-x86-64", f"x86_64-{_WINDOWS}", "x86-64", "", "win32", X86),
)
WEB = Target(
    "web", "wasm32-unknown-unknown", "generic",
    "+simd128,+bulk-memory,+nontrapping-fptoint,+sign-ext,+mutable-globals", "emscripten", ("wasm32",),
)  # fmt: skip


def targets_of_machine() -> list[Target]:
    """The targets whose code runs here, the best one first."""
    machine = platform.machine().lower()
    fitting = [t for t in TARGETS if sys.platform.startswith(t.system) and machine in t.machines]
    features = _features() if any(target.needs for target in fitting) else {}
    return [target for target in fitting if all(features.get(name) for name in target.needs)]


def _features() -> dict[str, bool]:
    import llvmlite.binding as llvm

    try:
        return dict(llvm.get_host_cpu_features())
    except RuntimeError:  # LLVM does not know the processor
        return {}
