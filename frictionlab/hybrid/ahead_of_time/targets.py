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


# MCJIT loads ELF on Windows too, as numba has it do.
_WINDOWS = "pc-windows-msvc-elf"
# The objects call nothing of the system; the oldest one that Python and numpy have wheels for.
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
