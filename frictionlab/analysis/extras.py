"""Packages that come with an extra."""

from __future__ import annotations

from importlib import import_module
from typing import Any


def needed(package: str, what: str) -> Any:
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
