"""The short form of ``python -m tests.faults``; the cache of compiled code has its own test."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SHORT = {
    "files": ["--truncations", "3", "--flips", "5", "--mutations", "12"],
    "disks": ["--rooms", "3"],
    "kills": ["--kills", "12"],
}
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not hasattr(os, "fork"), reason="cases run in forked processes"),
]


@pytest.mark.parametrize("suite", SHORT)
def test_every_fault_is_withstood(suite):
    command = [sys.executable, "-m", "tests.faults", suite, *SHORT[suite]]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "cases, 0 not withstood" in done.stdout
