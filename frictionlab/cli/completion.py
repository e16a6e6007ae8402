"""`frictionlab completion` prints the script by which a shell completes commands, options and models."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from typing import Any

from frictionlab.cli.parsing import OneLineParser, add_command, model_names

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

# For each command: its options, and the values that may follow a word.
Table = Mapping[str, tuple[list[str], dict[str, list[str]]]]


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


def _words(name: str, parser: argparse.ArgumentParser) -> tuple[list[str], dict[str, list[str]]]:
    """Options of a command, and the values that may follow an option, or the command itself."""
    options, values = [], {}
    for action in parser._actions:
        options += [option for option in action.option_strings if option.startswith("--")]
        known = model_names() if action.dest == "model" or (name, action.dest) == ("models", "name") else None
        for before in action.option_strings or [name]:
            if choices := [*map(str, action.choices or known or ())]:
                values[before] = choices
    return options, values


def _about(parser: argparse.ArgumentParser) -> str:
    """The first sentence of a command's description, on one line."""
    return " ".join((parser.description or "").split()).partition(". ")[0].rstrip(".").replace("'", "")


def _bash(table: Table, about: Mapping[str, str]) -> str:
    values = [
        f'      "{name} {before}") words="{" ".join(choices)}" ;;'
        for name, (_, known) in table.items()
        for before, choices in known.items()
    ]
    options = [f'      {name}) words="{" ".join(choices)}" ;;' for name, (choices, _) in table.items()]
    return BASH.format(commands=" ".join(table), values="\n".join(values), options="\n".join(options))


def _zsh(table: Table, about: Mapping[str, str]) -> str:
    values = [
        f'    "{name} {before}") found=({" ".join(choices)}) ;;'
        for name, (_, known) in table.items()
        for before, choices in known.items()
    ]
    options = [
        f'    {name}) [[ "${{words[CURRENT]}}" == -* ]] && found=({" ".join(choices)}) ;;'
        for name, (choices, _) in table.items()
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
