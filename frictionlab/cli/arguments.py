"""Spellings of arguments that argparse alone would refuse, and help with those that nobody knows."""

from __future__ import annotations

import argparse
import re
from collections.abc import Sequence
from difflib import get_close_matches

# Negative numbers, "-1e-3" and "-inf" included, and lists of them: argparse takes some for options.
NEGATIVE = re.compile(r"-(\d|\.\d|inf|nan)", re.IGNORECASE)


def normalised(argv: Sequence[str]) -> list[str]:
    """The arguments with --mu_k written as --mu-k, and negative values joined to their options."""
    found: list[str] = []
    for word in argv:
        if NEGATIVE.match(word) and found and found[-1].startswith("--") and "=" not in found[-1]:
            found[-1] += f"={word}"
        else:
            found.append(_dashed(word))
    return found


def _dashed(word: str) -> str:
    if not word.startswith("--"):
        return word
    option, equals, value = word.partition("=")
    return option.replace("_", "-") + equals + value


def unknown_options(words: Sequence[str], parser: argparse.ArgumentParser) -> str:
    """What is wrong with words that no option took; options are suggested by likeness."""
    word = words[0]
    if not word.startswith("-"):
        return f"unexpected argument {word!r}: values follow their option, as in --mu-k 1.4"
    option = word.partition("=")[0]
    known = [name for action in parser._actions for name in action.option_strings]
    same = [name for name in known if name.lower() == option.lower()]
    bare = {name.lstrip("-"): name for name in known}  # the dashes that all have are no likeness
    near = same or [bare[name] for name in get_close_matches(option.lstrip("-"), bare, n=1)]
    hint = f"did you mean {near[0]!r}?" if near else f"see {parser.prog} --help"
    return f"unknown option {option!r}: {hint}"
