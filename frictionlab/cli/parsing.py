"""What the commands share: a parser with errors of one line, spellings, checks before a run, and output to
streams that may be closed or full.
"""

from __future__ import annotations

import argparse
import os
import re
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NoReturn

from frictionlab.validation import nearest_name

# Negative numbers, "-1e-3" and "-inf" included, and lists of them: argparse mistakes some for options.
NEGATIVE_NUMBER = re.compile(r"-(\d|\.\d|inf|nan)", re.IGNORECASE)

PICTURE_FORMATS = (".png", ".pdf", ".svg", ".eps", ".jpg", ".webp")


class OneLineParser(argparse.ArgumentParser):
    """A parser whose errors are one line."""

    def error(self, message: str) -> NoReturn:
        flush_output()
        self.exit(2, f"{self.prog}: error: {' '.join(message.split())}\n")


def add_command(commands: Any, name: str, about: str, description: str, epilog: str) -> OneLineParser:
    """A command's parser, whose help keeps the lines of its texts."""
    return commands.add_parser(
        name,
        help=about,
        description=description,
        epilog=epilog,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )


def flush_output() -> None:
    """Write what standard output still holds; OSError where that fails.  There may be none (pythonw)."""
    if sys.stdout is not None:
        sys.stdout.flush()


def complain(program: str, text: str) -> None:
    """Write a line to standard error, if that can be done."""
    from frictionlab.interruption import tell

    tell(f"{program}: {text}")


def discard(stream: Any) -> None:
    """Write all that the stream still holds, and all that follows, to nowhere."""
    handle = os.open(os.devnull, os.O_WRONLY)
    os.dup2(handle, stream.fileno())
    os.close(handle)


def discard_unwritten(stream: Any) -> None:
    """Discard what cannot be written: the interpreter would try again when it ends, and complain."""
    try:
        if stream is not None:
            stream.flush()
    except OSError:
        discard(stream)


def normalise_arguments(argv: Sequence[str]) -> list[str]:
    """The arguments with --mu_k written as --mu-k, and negative values joined to their options."""
    found: list[str] = []
    for word in argv:
        if NEGATIVE_NUMBER.match(word) and found and found[-1].startswith("--") and "=" not in found[-1]:
            found[-1] += f"={word}"
        else:
            found.append(_with_dashes(word))
    return found


def _with_dashes(word: str) -> str:
    if not word.startswith("--"):
        return word
    option, equals, value = word.partition("=")
    return option.replace("_", "-") + equals + value


def unknown_option_text(words: Sequence[str], parser: argparse.ArgumentParser) -> str:
    """The message for words that belong to no option, with the most similar options as suggestions."""
    word = words[0]
    if not word.startswith("-"):
        return f"unexpected argument {word!r}: values follow their option, as in --mu-k 1.4"
    option = word.partition("=")[0]
    known = [name for action in parser._actions for name in action.option_strings]
    bare = {name.lstrip("-"): name for name in known}  # the dashes, which all options have, do not count
    near = nearest_name(option.lstrip("-"), bare)
    hint = f"see {parser.prog} --help" if near is None else f"did you mean {bare[near]!r}?"
    return f"unknown option {option!r}: {hint}"


def add_sweep_options(group: Any) -> None:
    """Workers and resuming, of commands that run sweeps."""
    group.add_argument("--workers", type=int, metavar="N", help="threads (default: one for each processor)")
    group.add_argument(
        "--resume", metavar="FOLDER", help="keep sweeps there as they come, and go on with those found there"
    )


def check_workers(workers: int | None) -> None:
    """Raise for less than one."""
    from frictionlab.validation import check_number

    if workers is not None:
        check_number("--workers", workers, integer=True, least=1, cure="leave it out for one each processor")


def check_files(chosen: argparse.Namespace) -> None:
    """Refuse files that could not be written after the run."""
    if chosen.output is not None:
        _check_picture(Path(chosen.output))
        check_writable(Path(chosen.output), "-o")
    if chosen.save is not None:
        path = Path(chosen.save)
        check_writable(path if path.suffix == ".npz" else path.with_name(path.name + ".npz"), "--save")


def _check_picture(path: Path) -> None:
    if path.suffix.lower() not in PICTURE_FORMATS:
        raise ValueError(f"-o must end in one of {', '.join(PICTURE_FORMATS)}, got {str(path)!r}: take .png")


def check_writable(path: Path, option: str) -> None:
    """Raise where a file could not be written after the run."""
    folder = path.parent
    if not folder.is_dir():
        raise ValueError(f"{option} needs an existing folder, there is no {str(folder)!r}: make it first")
    if path.is_dir():
        raise ValueError(f"{option} must be a file, {str(path)!r} is a folder: add a file name")
    if not os.access(path if path.exists() else folder, os.W_OK):
        raise ValueError(f"{option} cannot be written to {str(path)!r}: permission denied, choose another")
