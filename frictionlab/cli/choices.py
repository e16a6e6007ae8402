"""From options to a model, a method, an initial state and files; everything is checked before the run."""

from __future__ import annotations

import argparse
import math
import os
from dataclasses import replace
from pathlib import Path
from typing import Any

from .parser import METHODS, MU_K

IMPACTS = ("material", "full", "restitution")
PICTURES = (".png", ".pdf", ".svg", ".eps", ".jpg", ".webp")


def model_of(chosen: argparse.Namespace) -> Any:
    """The model; raises ValueError or TypeError as the model does."""
    from frictionlab.components import PlasticImpact, RestitutionImpact
    from frictionlab.components.parameter import parameters_of
    from frictionlab.components.validation import checked
    from frictionlab.hybrid.validation import check_choice
    from frictionlab.models import SliderOnBelt

    check_choice("--impact", chosen.impact, IMPACTS)
    impact = RestitutionImpact() if chosen.impact == "restitution" else PlasticImpact(chosen.impact)
    # First the laws, then the numbers: one that belongs to a law left out is refused, not ignored.
    laws = SliderOnBelt(impact=impact).without(*chosen.without)
    values = {"mu_k": MU_K, **_given(chosen)}
    usual = replace(parameters_of(type(laws.friction))["mu_k"], default=MU_K)
    checked("mu_k", values["mu_k"], usual)  # here, as the model's own message names another default
    return laws.replace(**values)


def _given(chosen: argparse.Namespace) -> dict[str, float]:
    options = {name.removeprefix("parameter "): v for name, v in vars(chosen).items() if " " in name}
    return {name: value for name, value in options.items() if value is not None}


def method_of(chosen: argparse.Namespace) -> Any:
    """The method with its settings."""
    from frictionlab.hybrid import choice
    from frictionlab.hybrid.rk4 import RK4

    by_lower = {name.lower(): name for name in METHODS}
    method = choice.method_of(by_lower.get(chosen.method.lower(), chosen.method))
    fixed = isinstance(method, RK4)
    if chosen.step is not None and not fixed:
        raise ValueError(f"--step is an option of --method rk4, got --method {chosen.method}: leave it out")
    if chosen.tol is not None and fixed:
        raise ValueError("--tol is no option of --method rk4, which has a fixed step: give --step instead")
    tolerance = "tol" if method.name == "taylor" else "rtol"
    given = {"step": chosen.step, tolerance: chosen.tol, "max_steps": chosen.max_steps}
    return type(method)(**_settings(method) | {k: v for k, v in given.items() if v is not None})


def _settings(method: Any) -> dict[str, Any]:
    return {name: value for name, value in method.describe().items() if name != "name"}


def start_of(chosen: argparse.Namespace, model: Any) -> Any:
    """The state that --x0 names, or the numbers it holds."""
    from frictionlab.analysis.simulate import initial_state

    text, n = chosen.x0, 2 * len(model.coordinates)
    if "," not in text:
        return initial_state(model, text)
    try:
        state = [float(part) for part in text.split(",")]
    except ValueError:
        state = []
    if len(state) != n or not all(map(math.isfinite, state)):
        names = [*model.coordinates, *(f"{name}'" for name in model.coordinates)]
        raise ValueError(f"--x0 must be rest, near or {n} numbers ({', '.join(names)}), got {text!r}")
    return state


def check_files(chosen: argparse.Namespace) -> None:
    """Refuse files that could not be written after the run."""
    if chosen.output is not None:
        _check_picture(Path(chosen.output))
        _check_writable(Path(chosen.output), "-o")
    if chosen.save is not None:
        path = Path(chosen.save)
        _check_writable(path if path.suffix == ".npz" else path.with_name(path.name + ".npz"), "--save")


def _check_picture(path: Path) -> None:
    if path.suffix.lower() not in PICTURES:
        raise ValueError(f"-o must end in one of {', '.join(PICTURES)}, got {str(path)!r}: take .png")


def _check_writable(path: Path, option: str) -> None:
    folder = path.parent
    if not folder.is_dir():
        raise ValueError(f"{option} needs an existing folder, there is no {str(folder)!r}: make it first")
    if path.is_dir():
        raise ValueError(f"{option} must be a file, {str(path)!r} is a folder: add a file name")
    if not os.access(path if path.exists() else folder, os.W_OK):
        raise ValueError(f"{option} cannot be written to {str(path)!r}: permission denied, choose another")
