"""Friction-induced vibration: models, an exact event-driven solver, stability, figures.

>>> import frictionlab as fl
>>> model = fl.SliderOnBelt(mu_k=1.4)
>>> run = fl.simulate(model, 1.0)

Names are loaded when they are first used, so that the import itself costs nothing.  They are listed in the
stub beside this file, ``__init__.pyi``.
"""

from __future__ import annotations

import logging

from frictionlab.lazy_names import homes_in_stub, loader_of_names

logging.getLogger(__name__).addHandler(logging.NullHandler())  # whether logs are shown is the user's choice

_HOME = homes_in_stub(__loader__, __path__[0])
# a type checker reads the stub, and need not follow how this list is made
__all__ = list(_HOME)  # pyright: ignore[reportUnsupportedDunderAll]  # it reads literals only
__getattr__ = loader_of_names(__name__, _HOME, globals())


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
