"""What is loaded when it is first used: names of a package, as its stub `__init__.pyi` lists them; sympy.

A stub serves those who read it and the package alike: type checkers and editors see what is where, and no
import is written twice.  sympy takes as long to load as all else that a run needs, and most runs do without:
what has been derived of a library's model is kept.
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
        setattr(self, name, value)  # where it is found without this method
        return value


if TYPE_CHECKING:
    import sympy as sympy
else:
    sympy = LazyModule("sympy")


def homes_in_stub(loader: Any, folder: str) -> dict[str, str]:
    """Public name of a package -> module in it that holds it; "" where the name is a package itself.

    A line of the stub is ``from .analysis.ensemble import ensemble as ensemble``.
    """
    # by the loader, as the package may be in a zip file
    stub = loader.get_data(f"{folder}{os.sep}__init__.pyi").decode()
    imports = [line.split() for line in stub.splitlines() if line.startswith("from .")]
    return {words[3]: words[1].lstrip(".") for words in imports}


def loader_of_names(package: str, homes: dict[str, str], into: dict[str, Any]) -> Callable[[str], Any]:
    """The function `__getattr__` of a package, which puts what it has loaded `into` its namespace."""

    def load(name: str) -> Any:
        if name not in homes:
            from frictionlab.validation import did_you_mean

            raise AttributeError(f"module {package!r} has no attribute {name!r}{did_you_mean(name, homes)}")
        value = _load(package, homes[name], name)
        into[name] = value
        return value

    return load


def _load(package: str, home: str, name: str) -> Any:
    """What a name stands for; where a package of others is missing, as ipywidgets on a cluster, which."""
    if not home:
        return import_module(f"{package}.{name}")
    try:
        return getattr(import_module(f"{package}.{home}"), name)
    except ModuleNotFoundError as error:
        missing = str(error.name).partition(".")[0]
        if missing == "frictionlab":
            raise
        cure = f"pip install {'pillow' if missing == 'PIL' else missing.lower()}"
        shown = "fl" if package == "frictionlab" else package
        message = f"{shown}.{name} needs {missing}, which is not installed: {cure}"
        raise ImportError(message, name=missing) from error
