"""Names that are loaded when they are first used: those in a package's stub `__init__.pyi`, and sympy.

Type checkers and editors read the stub, and the package loads by it, so that no import is written twice.
sympy takes as long to load as all else that a run needs.  Most runs do without it, as what has been derived
of the library's models is kept.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from importlib import import_module
from typing import TYPE_CHECKING, Any


class LazyModule:
    """A module that is imported when one of its names is first used."""

    def __init__(self, name: str) -> None:
        self.__name__ = name

    def __getattr__(self, name: str) -> Any:
        value = getattr(import_module(self.__name__), name)
        setattr(self, name, value)  # from now on found without this method
        return value


if TYPE_CHECKING:
    import sympy as sympy
else:
    sympy = LazyModule("sympy")


def homes_in_stub(loader: Any, folder: str) -> dict[str, str]:
    """The module that holds each public name of a package, by name; "" where the name is itself a module.

    A line of the stub is ``from .analysis.ensemble import ensemble as ensemble``.
    """
    # read by the loader, as the package may be in a zip file
    stub = loader.get_data(f"{folder}{os.sep}__init__.pyi").decode()
    imports = [line.split() for line in stub.splitlines() if line.startswith("from .")]
    return {words[3]: words[1].lstrip(".") for words in imports}


def loader_of_names(package: str, homes: dict[str, str], into: dict[str, Any]) -> Callable[[str], Any]:
    """The function `__getattr__` of a package: it loads a name and stores it in the namespace `into`."""

    def load(name: str) -> Any:
        if name not in homes:
            from frictionlab.validation import did_you_mean

            # Tools ask every module for names such as __wrapped__; to find near ones takes milliseconds.
            hint = "" if name.startswith("_") else did_you_mean(name, homes)
            raise AttributeError(f"module {package!r} has no attribute {name!r}{hint}")
        value = _load(package, homes[name], name)
        into[name] = value
        return value

    return load


def _load(package: str, home: str, name: str) -> Any:
    """What a name stands for; ImportError where a package it needs is missing, as ipywidgets may be."""
    if not home:
        return import_module(f"{package}.{name}")
    try:
        return getattr(import_module(f"{package}.{home}"), name)
    except ModuleNotFoundError as error:
        missing = str(error.name).partition(".")[0]
        if missing == "frictionlab":
            raise
        cure = f"pip install {'pillow' if missing == 'PIL' else missing.lower()}"
        prefix = "fl" if package == "frictionlab" else package
        message = f"{prefix}.{name} needs {missing}, which is not installed: {cure}"
        raise ImportError(message, name=missing) from error
