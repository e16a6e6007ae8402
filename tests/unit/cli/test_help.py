"""The help of every command is quick: it loads nothing heavy."""

import subprocess
import sys

from frictionlab.cli.command import build_parsers, program_parser

HELP = """
import sys
from frictionlab.cli.command import main
for command in sys.argv[1:]:
    try: main([command, '--help'])
    except SystemExit as ended: assert ended.code == 0
heavy = {'numpy', 'scipy', 'sympy', 'numba', 'matplotlib'} & set(sys.modules)
sys.exit(str(heavy) if heavy else 0)
"""


def test_help_loads_nothing_heavy():
    commands = sorted(build_parsers()[1])
    program = [sys.executable, "-c", HELP, *commands]
    said = subprocess.run(program, check=True, capture_output=True, text=True).stdout
    assert [line.split()[2] for line in said.splitlines() if line.startswith("usage: ")] == commands


def test_the_parser_that_completes_in_shells_is_that_of_the_command():
    assert program_parser().prog == "frictionlab"
    assert all(f"    {name}" in program_parser().format_help() for name in build_parsers()[1])
