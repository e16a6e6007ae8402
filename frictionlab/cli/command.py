"""The command `frictionlab`: `main`, its commands, its exit statuses."""

from __future__ import annotations

import gc
import sys
from collections.abc import Sequence

from frictionlab._version import __version__

from .app import add_app, app_command
from .course import add_course, course_command
from .film_and_sound import add_animate, add_sound, animate_command, sound_command
from .models import add_models, models_command
from .page import add_page, page_command
from .paper import add_figure, add_reproduce, figure_command, reproduce_command
from .parsing import (
    EXIT_FAILED,
    OneLineParser,
    complain,
    discard,
    discard_unwritten,
    flush_output,
    normalise_arguments,
    unknown_option_text,
)
from .run import add_run, run_command
from .stability import add_critical, add_eig, critical_command, eig_command
from .warmup import add_warmup, warmup_command

PROGRAM = "frictionlab"
EXIT_INTERRUPTED = 130  # 128 + SIGINT, as in shells
# What adds a command's parser, and what runs it, by the command's name.
COMMANDS = {
    "models": (add_models, models_command),
    "run": (add_run, run_command),
    "eig": (add_eig, eig_command),
    "critical": (add_critical, critical_command),
    "animate": (add_animate, animate_command),
    "sound": (add_sound, sound_command),
    "app": (add_app, app_command),
    "page": (add_page, page_command),
    "course": (add_course, course_command),
    "warmup": (add_warmup, warmup_command),
    "figure": (add_figure, figure_command),
    "reproduce": (add_reproduce, reproduce_command),
}


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command.

    Parameters
    ----------
    argv : sequence of str or None
        Arguments without the program's name; None takes those of the process.

    Returns
    -------
    int
        0: done.  1: the run ended early, or a file or standard output could not be written.  130: stopped by
        ctrl-C.

    Raises
    ------
    SystemExit
        With code 2 for bad arguments, after one line on stderr; with 0 after --help and --version.
    """
    try:
        try:
            return _parse_and_run(sys.argv[1:] if argv is None else argv)
        finally:
            flush_output()
    except KeyboardInterrupt:
        complain(PROGRAM, "stopped by ctrl-C")
        return EXIT_INTERRUPTED
    except BrokenPipeError:  # the reader of the pipe, such as `head`, has closed it
        discard(sys.stdout)
        return EXIT_FAILED
    except OSError as error:
        # An error about a file has the file's path, or a message of this package and no error number.
        ours = error.filename is not None or error.errno is None
        text = str(error) if ours else f"standard output cannot be written ({error}): send it elsewhere"
        complain(PROGRAM, f"error: {text}")
        return EXIT_FAILED
    finally:
        for stream in (sys.stdout, sys.stderr):
            discard_unwritten(stream)
        if argv is not None:  # the process goes on, and no objects stay exempt from garbage collection
            gc.unfreeze()


def _parse_and_run(argv: Sequence[str]) -> int:
    parser, commands = build_parsers()
    args, rest = parser.parse_known_args(normalise_arguments(argv))
    command = commands.get(args.command, parser)
    if rest:
        command.error(unknown_option_text(rest, command))
    if args.command is None:
        parser.print_help()
        return 0
    return COMMANDS[args.command][1](args, command)


def build_parsers() -> tuple[OneLineParser, dict[str, OneLineParser]]:
    """The parser of the program, and that of each command by its name."""
    parser = OneLineParser(
        prog=PROGRAM,
        description="Friction-induced vibration with sticking, slipping, lifting off and impacts.",
        epilog="`frictionlab run --help` lists every option of a run, and so on for the others. "
        "With --json those that compute print one JSON object.",
        allow_abbrev=False,
    )
    parser.add_argument("--version", action="version", version=f"frictionlab {__version__}")
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", title="commands")
    return parser, {name: add(commands) for name, (add, _) in COMMANDS.items()}


def program_parser() -> OneLineParser:
    """The parser of the program alone, from which shtab makes completions of shells."""
    return build_parsers()[0]
