"""Friction-induced vibration: models, an exact event-driven solver, stability, figures.

>>> import frictionlab as fl
>>> model = fl.SliderOnBelt(mu_k=1.4)
>>> run = fl.simulate(model, 1.0)

Names are loaded when they are first used, so that the import itself costs nothing.  They are listed in the
stub beside this file, ``__init__.pyi``.
"""

from __future__ import annotations

import os
from importlib import import_module
from typing import Any


def _names_in_stub() -> dict[str, str]:
    """Public name -> module that holds it; a package of frictionlab has none.

    A line of the stub is ``from .analysis.ensemble import ensemble as ensemble``.
    """
    # by the loader, as the package may be in a zip file
    stub = __loader__.get_data(f"{__path__[0]}{os.sep}__init__.pyi").decode()
    imports = [line.split() for line in stub.splitlines() if line.startswith("from .")]
    return {words[3]: words[1].lstrip(".") for words in imports}


_HOME = _names_in_stub()
# a type checker reads the stub, and need not follow how this list is made
__all__ = list(_HOME)  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str) -> Any:
    if name in _HOME:
        if not _HOME[name]:
            return import_module(f"frictionlab.{name}")
        value = getattr(import_module(f"frictionlab.{_HOME[name]}"), name)
        globals()[name] = value
        return value
    from frictionlab.validation import did_you_mean

    raise AttributeError(f"module 'frictionlab' has no attribute {name!r}{did_you_mean(name, __all__)}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
