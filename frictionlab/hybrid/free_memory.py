"""The memory that this process can still allocate: what the machine, its container and its limits leave."""

from __future__ import annotations

import math
import os
from contextlib import suppress
from pathlib import Path

BYTES_PER_KILOBYTE = 1024
MEMORY_INFORMATION = Path("/proc/meminfo")
PROCESS_SIZE = Path("/proc/self/statm")  # in pages: all, ..., data and stack
GROUP = Path("/sys/fs/cgroup")  # of a container, whose limit may be below the machine's memory


def free_memory() -> float:
    """Bytes that this process can still allocate; infinite where the system does not tell."""
    return min(_free_on_machine(), _free_in_group(), _free_in_process())


def _free_on_machine() -> float:
    with suppress(OSError, ValueError, IndexError):
        for line in MEMORY_INFORMATION.read_text().splitlines():
            if line.startswith("MemAvailable:"):
                return float(line.split()[1]) * BYTES_PER_KILOBYTE
    with suppress(OSError, ValueError, AttributeError):
        return float(os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    return math.inf


def _free_in_group() -> float:
    with suppress(OSError, ValueError):
        limit, used = ((GROUP / f"memory.{name}").read_text() for name in ("max", "current"))
        return float(limit) - float(used)  # without a limit the first is the word "max"
    return math.inf


def _free_in_process() -> float:
    """What the limits of this process leave, as ``ulimit -v`` sets them; there are none on Windows."""
    with suppress(ImportError, OSError, ValueError, IndexError):
        import resource

        limits = [resource.getrlimit(kind)[0] for kind in (resource.RLIMIT_AS, resource.RLIMIT_DATA)]
        if limits != [resource.RLIM_INFINITY] * 2:
            pages = PROCESS_SIZE.read_text().split()
            size, data = (int(pages[i]) * resource.getpagesize() for i in (0, 5))
            free = [
                limit - used for limit, used in zip(limits, (size, data)) if limit != resource.RLIM_INFINITY
            ]
            return float(min(free))
    return math.inf
