"""The processor that is measured, and the environment of a process that does not see its AVX-512."""

from __future__ import annotations

import os
import platform
import subprocess
from pathlib import Path
from tempfile import mkdtemp

PRELOADED = "LD_PRELOAD"
VECTORS = {"avx512f": "AVX-512", "avx2": "AVX2"}


def vectors() -> str:
    """The widest vectors that LLVM has on this processor."""
    import llvmlite.binding as llvm

    has = llvm.get_host_cpu_features()
    return next((name for key, name in VECTORS.items() if has.get(key)), "neither AVX2 nor AVX-512")


def processor() -> str:
    """Name of the processor, where the system knows it."""
    file = Path("/proc/cpuinfo")
    lines = file.read_text(encoding="utf-8").splitlines() if file.exists() else []
    names = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(names, platform.processor() or platform.machine())


def environment_without_avx512() -> dict[str, str]:
    """The environment with a library before all others that hides AVX-512 (Linux on Intel, cc): see its
    source."""
    library = Path(mkdtemp(), "without_avx512.so")
    source = Path(__file__).with_name("without_avx512.c")
    subprocess.run(["cc", "-O2", "-shared", "-fPIC", "-o", library, source], check=True)
    return os.environ | {PRELOADED: str(library)}
