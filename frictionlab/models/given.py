"""Is what was given a model?"""

from __future__ import annotations

from typing import Any

from .model import Model


def given_model(
    model: Any, kinds: str = "a model such as SliderOnBelt", cure: str = "make one, such as fl.SliderOnBelt()"
) -> Model:
    """The model itself; TypeError, with the `kinds` that are taken, for anything else."""
    if isinstance(model, Model):
        return model
    if isinstance(model, type) and issubclass(model, Model):
        got, cure = f"the class {model.__name__}", f"write {model.__name__}()"
    else:
        got = repr(model)
    raise TypeError(f"model must be {kinds}, got {got}: {cure}")
