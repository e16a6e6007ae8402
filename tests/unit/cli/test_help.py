"""The help of every command is quick: it loads nothing heavy."""

import subprocess
import sys

import pytest

from frictionlab.cli.command import build_parsers
from frictionlab.paper.results import EVERY_FIGURE

HELP = """
import sys
from frictionlab.cli.command import main
try: main([sys.argv[1], '--help'])
except SystemExit as ended: assert ended.code == 0
heavy = {'numpy', 'scipy', 'sympy', 'numba', 'matplotlib'} & set(sys.modules)
sys.exit(str(heavy) if heavy else 0)
"""


def answer(command):
    return subprocess.run([sys.executable, "-c", HELP, command], check=True, capture_output=True, text=True)


@pytest.mark.parametrize("command", sorted(build_parsers()[1]))
def test_help_loads_nothing_heavy(command):
    assert answer(command).stdout.startswith(f"usage: frictionlab {command}")


def test_help_names_the_figures():
    assert f"the paper's number: {min(EVERY_FIGURE)} to {max(EVERY_FIGURE)}" in answer("figure").stdout
