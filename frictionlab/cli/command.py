"""The command `frictionlab`: `main`, its commands, its exit statuses."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from typing import NoReturn

from frictionlab._version import __version__

from .app import add_app
from .bench import add_bench
from .paper import add_figure, add_reproduce
from .parsing import OneLineParser, normalise_arguments, unknown_option_text
from .run import add_run

EXIT_INTERRUPTED = 130  # 128 + SIGINT, as shells have it


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command.

    Parameters
    ----------
    argv : sequence of str or None
        Arguments without the program's name; None takes those of the process.

    Returns
    -------
    int
        0: done.  1: the run ended early, or a file could not be written.  130: stopped by ctrl-C.

    Raises
    ------
    SystemExit
        With code 2 for bad arguments, after one line on stderr; with 0 after --help and --version.
    """
    parser, commands = _build_parsers()
    chosen, rest = parser.parse_known_args(normalise_arguments(sys.argv[1:] if argv is None else argv))
    command = commands.get(chosen.command, parser)
    if rest:
        command.error(unknown_option_text(rest, command))
    if chosen.command is None:
        parser.print_help()
        return 0
    return _run_command(chosen, command)


def _build_parsers() -> tuple[OneLineParser, dict[str, OneLineParser]]:
    parser = OneLineParser(
        prog="frictionlab",
        description="Friction-induced vibration with sticking, slipping, lifting off and impacts.",
        epilog="`frictionlab run --help` lists every option of a run, and so on for the others.",
        allow_abbrev=False,
    )
    parser.add_argument("--version", action="version", version=f"frictionlab {__version__}")
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", title="commands")
    added = {"run": add_run, "app": add_app, "figure": add_figure}
    added |= {"reproduce": add_reproduce, "bench": add_bench}
    return parser, {name: add(commands) for name, add in added.items()}


def _run_command(chosen: argparse.Namespace, parser: OneLineParser) -> int:
    from .app import app_command
    from .bench import bench_command
    from .paper import figure_command, reproduce_command
    from .run import run_command

    does = {"run": run_command, "app": app_command, "figure": figure_command}
    does |= {"reproduce": reproduce_command, "bench": bench_command}
    try:
        command = does[chosen.command]
        code = command(chosen, parser)
        sys.stdout.flush()
        return code
    except KeyboardInterrupt:  # a second ctrl-C, or one while the solver is compiled or a picture drawn
        sys.stderr.write(f"{parser.prog}: interrupted\n")
        return EXIT_INTERRUPTED
    except BrokenPipeError:  # the reader of the pipe, such as `head`, has closed it
        _quiet_exit()


def _quiet_exit() -> NoReturn:
    # Python would complain once more when it flushes stdout at its end.
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    sys.exit(1)
