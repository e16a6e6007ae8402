"""Results as tables: pandas and xarray where they are installed, and Markdown."""

from __future__ import annotations

from collections.abc import Iterable
from importlib import import_module
from typing import Any


def import_optional(package: str, what: str) -> Any:
    """The package of the extra ``data``.

    Raises
    ------
    ImportError
        Where it is not installed, with the command that does it.
    """
    try:
        return import_module(package)
    except ImportError as error:
        raise ImportError(f"{what} needs {package}: pip install 'frictionlab[data]'") from error


def markdown_table(head: str, lines: Iterable[str]) -> str:
    """A table."""
    rule = "|".join("---" for _ in head.split("|"))
    return "\n".join([f"| {head} |", f"|{rule}|", *(f"| {line} |" for line in lines)])
