"""Figs 4 and 5: the critical mu_k against the preload, for three contacts, and with and without GN.

GN is the geometrical nonlinearity.  The text gives neither the range of F nor, for Fig. 5, k_nl: the preload
goes up to that of Fig. 3, and k_nl is the 1e4 N/m^3 that the paper takes unless it says otherwise.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from frictionlab.models import SliderOnBelt
from frictionlab.plotting import RunFigure, plot_critical
from frictionlab.plotting.parameters import parameter_value
from frictionlab.stability import CriticalCurve, critical_curve

from .coalescence import MU_K, STIFFNESSES
from .result import PaperFigure

# N: closer together where the curves bend, and the paper's usual 200 N.
PRELOADS = np.sort(np.append(1000.0 * np.linspace(0.0, 1.0, 61)[1:] ** 2, 200.0))
JUMP = 0.15  # between neighbours: a curve that changes by more is computed between them too
HALVINGS = 5
WITH, WITHOUT = "with GN", "without GN"


@dataclass(frozen=True, eq=False)
class CriticalPreload:
    """What Figs 4 and 5 show: curves of the first loss of stability, by k_nl (N/m^3) or by name."""

    curves: Mapping[float | str, CriticalCurve]


def figure(number: int) -> PaperFigure:
    """Fig. 4 or 5."""
    data, what = (
        (by_stiffness(), "for three values of k_nl")
        if number == 4
        else (by_geometry(), "with and without GN")
    )
    names = (key if isinstance(key, str) else f"k_nl = {key:g} N/m^3" for key in data.curves)
    summary = tuple(f"{name}: {_ends(curve)}" for name, curve in zip(names, data.curves.values()))
    return PaperFigure(number, f"critical mu_k against the preload {what}", data, summary, _draw)


def by_stiffness() -> CriticalPreload:
    """Fig. 4."""
    return CriticalPreload({k: _curve(SliderOnBelt(k_nl=k)) for k in STIFFNESSES})


def by_geometry() -> CriticalPreload:
    """Fig. 5."""
    model = SliderOnBelt()
    return CriticalPreload({WITH: _curve(model), WITHOUT: _curve(model.without("geometry"))})


@cache
def _curve(model: SliderOnBelt) -> CriticalCurve:
    at = PRELOADS
    curve = critical_curve(model, "mu_k", MU_K, over=("F", at))
    for _ in range(HALVINGS):
        steep = np.array(jumps_of(curve), dtype=int)
        if not steep.size:
            break
        between = 0.5 * (curve.at[steep] + curve.at[steep + 1])
        curve = _joined(curve, critical_curve(model, "mu_k", MU_K, over=("F", between)))
    curve.at.flags.writeable = curve.values.flags.writeable = False  # the cache gives it out again
    return curve


def _joined(curve: CriticalCurve, more: CriticalCurve) -> CriticalCurve:
    at = np.append(curve.at, more.at)
    order = np.argsort(at)
    return replace(curve, at=at[order], values=np.append(curve.values, more.values)[order])


def _ends(curve: CriticalCurve) -> str:
    ends = ", ".join(at_preload(curve, i) for i in (0, -1))
    jumps = ", ".join(f"{curve.at[i]:.0f} N" for i in jumps_of(curve))
    return f"critical mu_k {ends}" + (f"; jumps at F = {jumps}, as another mode comes first" if jumps else "")


def at_preload(curve: CriticalCurve, i: int) -> str:
    """A point of a curve in words."""
    return f"{curve.values[i]:.4f} at F = {curve.at[i]:.4g} N"


def jumps_of(curve: CriticalCurve) -> list[int]:
    """Indices of the points right before a jump."""
    return np.flatnonzero(np.abs(np.diff(curve.values)) > JUMP).tolist()


def _draw(result: PaperFigure) -> RunFigure:
    curves = result.data.curves
    labels = [k if isinstance(k, str) else parameter_value(c.model, "k_nl", k) for k, c in curves.items()]
    picture = RunFigure(figsize=(7.5, 4.2), layout="constrained")
    ax = picture.add_subplot()
    plot_critical(list(curves.values()), ax, labels=labels)
    ax.set_xlim(left=0.0)
    ax.set_ylim(bottom=0.0)
    ax.set_title(f"Fig. {result.number}: first loss of stability")
    return picture
