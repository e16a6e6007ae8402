"""Sweeps that several figures and claims share: computed once, kept in files where there is a folder."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from frictionlab.analysis.bifurcation import bifurcation
from frictionlab.analysis.sweep import sweep

from .scenes import times_of
from .setting import Setting

_DONE: dict[str, Any] = {}


def steady_states(
    model: Any,
    values: Any,
    setting: Setting,
    x0: str = "rest",
    *,
    parameter: str = "mu_k",
    section: Any = None,
) -> Any:
    """`fl.bifurcation` as the setting says.

    Raises
    ------
    KeyboardInterrupt
        After ctrl-C; what was done is in the file, if there is a folder.
    """
    model = setting.adapted(model)
    options: dict[str, Any] = {"section": section, "tolerance": setting.tolerance}
    options |= times_of(model, setting)._asdict()
    asked = [model.to_dict(), parameter, list(values), x0, setting.method.describe(), options]

    def compute(path: Path | None) -> Any:
        found = bifurcation(
            model,
            parameter,
            values,
            x0,
            method=setting.method,
            workers=setting.workers,
            resume=path,
            progress=setting.progress,
            **options,
        )
        return found, "" not in found.kinds

    return _once(asked, setting, compute)


def results(
    name: str, function: Callable[[Any], Any], model: Any, over: dict[str, Any], setting: Setting
) -> Any:
    """`fl.sweep` of a function; `name` says which, with all that it depends on but for the model."""
    model = setting.adapted(model)
    asked = [name, model.to_dict(), {key: list(values) for key, values in over.items()}]

    def compute(path: Path | None) -> Any:
        options: dict[str, Any] = {"workers": setting.workers, "progress": setting.progress}
        found = sweep(function, model, over, resume=path, **options)
        return found, all(result is not None for result in found.results.flat)

    return _once(asked, setting, compute)


def _once(asked: Any, setting: Setting, compute: Callable[[Path | None], tuple[Any, bool]]) -> Any:
    key = hashlib.sha256(json.dumps(asked, sort_keys=True).encode()).hexdigest()[:16]
    if key not in _DONE:
        path = None
        if setting.resume is not None:
            setting.resume.mkdir(parents=True, exist_ok=True)
            path = setting.resume / f"{key}.jsonl"
        found, complete = compute(path)
        if not complete:
            raise KeyboardInterrupt
        _DONE[key] = found
    return _DONE[key]
