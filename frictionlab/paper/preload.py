"""Fig. 15: steady states against the preload, with and without the geometrical nonlinearity (GN)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from frictionlab.plotting import RunFigure, plot_bifurcation, plot_intensity
from frictionlab.plotting.legends import legend_beside
from frictionlab.plotting.parameters import parameter_value

from . import motions
from .result import PaperFigure
from .setting import Setting
from .wording import regime_changes, stretches


@dataclass(frozen=True, eq=False)
class Preload:
    """What Fig. 15 shows: sweeps over F by "with GN" and "without GN"."""

    sweeps: dict[str, Any]


def figure(number: int, setting: Setting) -> PaperFigure:
    """Fig. 15."""
    data = Preload({name: motions.over_preload(geometry, setting) for geometry, name in motions.GN.items()})
    summary = [
        f"{name}: {stretches(b)} N; {regime_changes(b)} changes of regime" for name, b in data.sweeps.items()
    ]
    caption = "steady states from rest against the preload, mu_k = 2.5, k_nl = 1e7 N/m^3"
    return PaperFigure(number, caption, data, tuple(summary), _draw, str(setting))


def _draw(result: PaperFigure) -> RunFigure:
    picture = RunFigure(figsize=(11.0, 7.5), layout="constrained")
    panels = picture.subplots(2, 2, sharex=True, squeeze=False)
    for i, (name, found) in enumerate(result.data.sweeps.items()):
        plot_bifurcation(found, panels[0, i], legend=False)
        plot_intensity(found, panels[1, i], legend=False)
        panels[0, i].set_title(f"({'ab'[i]}) {name}")
        panels[1, i].set_title(f"({'cd'[i]}) {name}")
        panels[0, i].set_xlabel("")
    handles = {h.get_label(): h for ax in panels[0] for h in ax.get_legend_handles_labels()[0]}
    legend_beside(panels[0, -1], list(handles.values()))
    model = next(iter(result.data.sweeps.values())).model
    values = ", ".join(parameter_value(model, name, getattr(model, name)) for name in ("mu_k", "k_nl"))
    picture.suptitle(result.heading(f"against the preload from rest, {values}"))
    return picture
