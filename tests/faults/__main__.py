"""``python -m tests.faults``: all suites, each in a process of its own, or those that are named."""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from importlib import import_module
from pathlib import Path

SUITES = {
    "code": "compiled_code",
    "files": "stored_files",
    "disks": "full_disks",
    "kills": "kills",
    "values": "bad_values",
}


def main() -> int:
    """Run the suites; the exit code is how many cases were not withstood, 100 at most."""
    parser = argparse.ArgumentParser(prog="python -m tests.faults", description="Faults, and what they do.")
    parser.add_argument("suites", nargs="*", metavar="SUITE", help=f"{', '.join(SUITES)} (default: all)")
    parser.add_argument("--truncations", type=int, default=20, help="places in each kind of file")
    parser.add_argument("--flips", type=int, default=200, help="random bits in each kind of file")
    parser.add_argument("--mutations", type=int, default=120, help="entries changed in each kind of file")
    parser.add_argument("--rooms", type=int, default=7, help="places at which the disk of a sweep is full")
    parser.add_argument("--kills", type=int, default=200, help="times that a command is ended")
    parser.add_argument("--seed", type=int, default=0, help="of the moments at which commands are ended")
    chosen = parser.parse_args()
    if unknown := [name for name in chosen.suites if name not in SUITES]:
        parser.error(f"a suite must be one of {', '.join(SUITES)}, got {unknown[0]!r}")
    if len(chosen.suites) != 1:
        rest = [word for word in sys.argv[1:] if word not in SUITES]
        command = [sys.executable, "-m", "tests.faults"]
        codes = [
            subprocess.run([*command, name, *rest], check=False).returncode
            for name in chosen.suites or SUITES
        ]
        return min(sum(map(abs, codes)), 100)
    with tempfile.TemporaryDirectory() as scratch:
        return min(_run(chosen.suites[0], Path(scratch), chosen), 100)


def _run(suite: str, scratch: Path, chosen: argparse.Namespace) -> int:
    if suite == "code":  # before the package is imported, which chooses the folder then
        os.environ["FRICTIONLAB_CACHE_DIR"] = str(scratch / "cache")
        os.environ["FRICTIONLAB_COMPILE_KERNELS"] = "1"  # by numba, into that folder
    module = import_module(f"tests.faults.{SUITES[suite]}")
    if suite == "kills":
        return module.main(scratch, chosen.kills, chosen.seed)
    if suite == "disks":
        return module.main(scratch, chosen.rooms)
    if suite == "files":
        return module.main(scratch, chosen.truncations, chosen.flips, chosen.mutations)
    return module.main(scratch, chosen.truncations, chosen.flips)


if __name__ == "__main__":
    sys.exit(main())
