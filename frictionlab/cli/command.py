"""The command `frictionlab`: `main`, its commands, its exit statuses; and `frictionlab completion`, which
prints the script by which a shell completes commands, options and models.
"""

from __future__ import annotations

import argparse
import gc
import sys
from collections.abc import Mapping, Sequence
from typing import Any

from frictionlab._version import __version__

from .media import add_animate, add_app, add_page, add_sound
from .models import add_critical, add_eig, add_models
from .parsing import (
    OneLineParser,
    add_command,
    complain,
    discard,
    discard_unwritten,
    flush_output,
    model_names,
    normalise_arguments,
    unknown_option_text,
)
from .preparation import add_course, add_warmup
from .reports import add_figure, add_reproduce
from .run import add_run

PROGRAM = "frictionlab"
EXIT_FAILED, EXIT_INTERRUPTED = 1, 130  # the latter is 128 + SIGINT, as in shells


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
    chosen, rest = parser.parse_known_args(normalise_arguments(argv))
    command = commands.get(chosen.command, parser)
    if rest:
        command.error(unknown_option_text(rest, command))
    if chosen.command is None:
        parser.print_help()
        return 0
    if chosen.command == "completion":
        print(completion_script(chosen.shell, commands), end="")
        return 0
    return _run_command(chosen, command)


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
    added = {"models": add_models, "run": add_run, "eig": add_eig, "critical": add_critical}
    added |= {"animate": add_animate, "sound": add_sound, "app": add_app, "page": add_page}
    added |= {"course": add_course, "warmup": add_warmup}
    added |= {"figure": add_figure, "reproduce": add_reproduce}
    added |= {"completion": add_completion}
    return parser, {name: add(commands) for name, add in added.items()}


def _run_command(chosen: argparse.Namespace, parser: OneLineParser) -> int:
    from .media import animate_command, app_command, page_command, sound_command
    from .models import critical_command, eig_command, models_command
    from .preparation import course_command, warmup_command
    from .reports import figure_command, reproduce_command
    from .run import run_command

    does = {"models": models_command, "run": run_command, "eig": eig_command, "critical": critical_command}
    does |= {"animate": animate_command, "sound": sound_command, "app": app_command, "page": page_command}
    does |= {"course": course_command, "warmup": warmup_command}
    does |= {"figure": figure_command, "reproduce": reproduce_command}
    return does[chosen.command](chosen, parser)


SHELLS = "bash", "zsh", "fish"

COMPLETION_DESCRIPTION = """\
Print a script by which a shell completes commands, options, models and
files."""

COMPLETION_EPILOG = """\
examples:
  source <(frictionlab completion bash)          in ~/.bashrc
  source <(frictionlab completion zsh)           in ~/.zshrc, after compinit
  frictionlab completion fish > ~/.config/fish/completions/frictionlab.fish

exit status: 0 printed; 2 bad arguments."""

BASH = """\
_frictionlab() {{
  local words= before="${{COMP_WORDS[COMP_CWORD-1]}}"
  if [ "$COMP_CWORD" -eq 1 ]; then words="{commands}"; else
    case "${{COMP_WORDS[1]}} $before" in
{values}
      *) case "${{COMP_WORDS[1]}}" in
{options}
      esac ;;
    esac
  fi
  COMPREPLY=($(compgen -W "$words" -- "${{COMP_WORDS[COMP_CWORD]}}"))
}}
complete -o default -F _frictionlab frictionlab
"""

ZSH = """\
_frictionlab() {{
  local -a found
  if (( CURRENT == 2 )); then found=({described}); _describe command found; return; fi
  case "${{words[2]}} ${{words[CURRENT-1]}}" in
{values}
    *) case "${{words[2]}}" in
{options}
    esac ;;
  esac
  (( $#found )) && compadd -a found || _files
}}
compdef _frictionlab frictionlab
"""


def add_completion(commands: Any) -> OneLineParser:
    """Add the command `completion`; returns its parser."""
    about = "print a script by which a shell completes"
    parser = add_command(commands, "completion", about, COMPLETION_DESCRIPTION, COMPLETION_EPILOG)
    parser.add_argument("shell", choices=SHELLS)
    return parser


def completion_script(shell: str, commands: Mapping[str, argparse.ArgumentParser]) -> str:
    """The script for a shell, made from the commands' parsers."""
    table = {name: _words(name, parser) for name, parser in commands.items()}
    return _FORMATS[shell](table, {name: _about(parser) for name, parser in commands.items()})


Table = Mapping[
    str, tuple[list[str], dict[str, list[str]]]
]  # for each command: its options, and the values that may follow a word


def _words(name: str, parser: argparse.ArgumentParser) -> tuple[list[str], dict[str, list[str]]]:
    """Options of a command, and the values that may follow an option, or the command itself."""
    options, values = [], {}
    for action in parser._actions:
        options += [option for option in action.option_strings if option.startswith("--")]
        known = model_names() if action.dest == "model" or (name, action.dest) == ("models", "name") else None
        for before in action.option_strings or [name]:
            if found := [*map(str, action.choices or known or ())]:
                values[before] = found
    return options, values


def _about(parser: argparse.ArgumentParser) -> str:
    """The first sentence of a command's description, on one line."""
    return " ".join((parser.description or "").split()).partition(". ")[0].rstrip(".").replace("'", "")


def _bash(table: Table, about: Mapping[str, str]) -> str:
    values = [
        f'      "{name} {before}") words="{" ".join(found)}" ;;'
        for name, (_, known) in table.items()
        for before, found in known.items()
    ]
    options = [f'      {name}) words="{" ".join(found)}" ;;' for name, (found, _) in table.items()]
    return BASH.format(commands=" ".join(table), values="\n".join(values), options="\n".join(options))


def _zsh(table: Table, about: Mapping[str, str]) -> str:
    values = [
        f'    "{name} {before}") found=({" ".join(found)}) ;;'
        for name, (_, known) in table.items()
        for before, found in known.items()
    ]
    options = [
        f'    {name}) [[ "${{words[CURRENT]}}" == -* ]] && found=({" ".join(found)}) ;;'
        for name, (found, _) in table.items()
    ]
    described = " ".join(f"'{name}:{about[name]}'" for name in table)
    return ZSH.format(described=described, values="\n".join(values), options="\n".join(options))


def _fish(table: Table, about: Mapping[str, str]) -> str:
    lines = [
        f"complete -c frictionlab -f -n __fish_use_subcommand -a {name} -d '{about[name]}'" for name in table
    ]
    for name, (options, known) in table.items():
        here = f"complete -c frictionlab -n '__fish_seen_subcommand_from {name}'"
        for option in options:
            follow = f" -x -a '{' '.join(known[option])}'" if option in known else ""
            lines.append(f"{here} -l {option.removeprefix('--')}{follow}")
        if name in known:
            lines.append(f"{here} -a '{' '.join(known[name])}'")
    return "\n".join(lines) + "\n"


_FORMATS = {"bash": _bash, "zsh": _zsh, "fish": _fish}
