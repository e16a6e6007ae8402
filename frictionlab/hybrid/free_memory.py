"""How much memory is free, as far as the system tells."""

from __future__ import annotations

import math
import os
from contextlib import suppress
from pathlib import Path

BYTES_PER_KILOBYTE = 1024
MEMORY_INFORMATION = Path("/proc/meminfo")
GROUP = Path("/sys/fs/cgroup")  # of a container, whose limit may be lower than what the machine has


def free_memory() -> float:
    """Bytes that a process may yet take; infinite where the system does not tell."""
    return min(_of_machine(), _of_group())


def _of_machine() -> float:
    with suppress(OSError, ValueError, IndexError):
        for line in MEMORY_INFORMATION.read_text().splitlines():
            if line.startswith("MemAvailable:"):
                return float(line.split()[1]) * BYTES_PER_KILOBYTE
    with suppress(OSError, ValueError, AttributeError):
        return float(os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    return math.inf


def _of_group() -> float:
    with suppress(OSError, ValueError):
        limit, used = ((GROUP / f"memory.{name}").read_text() for name in ("max", "current"))
        return float(limit) - float(used)  # the limit is a word where there is none
    return math.inf
