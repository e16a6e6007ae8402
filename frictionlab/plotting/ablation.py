"""Small multiples of an ablation: the result of a study for each scene."""

from __future__ import annotations

from collections.abc import Iterable
from numbers import Real
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from frictionlab.analysis.spectrum import Spectrum
from frictionlab.analysis.steady_state.result import SteadyState
from frictionlab.analysis.sweeps.ablation import all_of
from frictionlab.analysis.sweeps.bifurcation_result import Bifurcation
from frictionlab.plotting.runs.spectrum import plot_amplitudes

from .appearance import crowding, font_size, pen
from .bifurcation import LOG_SCALE_RATIO, plot_bifurcation
from .figure import RunAxes, axes_or_new, new_figure, wrap_label
from .motions import plot_steady_state
from .style import BLUE, GREY

RUN_AXES = {"axes_class": RunAxes}
COLUMNS = 4  # panels side by side
LABEL_LENGTH = 34  # letters of a line below a small panel
PANEL_SHARE = 0.7  # of its cell that a panel takes, the rest for labels and title


def plot_ablation(ablation: Any, ax: Axes | None = None, *, name: str | None = None) -> list[Axes]:
    """Draw what a study gave for each scene: a small panel for each, or bars of numbers.

    Parameters
    ----------
    ablation : Ablation
        With results that are SteadyState (drawn as phase planes), Bifurcation (section points), Spectrum,
        or numbers (None: no such number).
    ax : Axes or None
        Where bars, or all panels side by side, stand; None draws into a new figure.
    name : str or None
        The coordinate to draw; None takes the first.

    Returns
    -------
    list of Axes
        One for each scene, of its own scale, or one of bars; the figure is ``axes[0].figure``.

    Raises
    ------
    TypeError
        For results that are none of these.
    """
    known = [result for result in ablation.results if result is not None]
    if all(isinstance(result, Real) for result in known):
        return [_bars(ablation, axes_or_new(ax))]
    draw = _panel_for(known)
    count = len(ablation.results)
    columns = min(COLUMNS, count)
    rows = -(-count // columns)
    panels = _panels(rows, columns, ax)
    for ax, (without, result) in zip(panels, ablation, strict=True):
        if result is None:
            ax.text(0.5, 0.5, "not done", ha="center", va="center", transform=ax.transAxes)
        else:
            draw(result, ax, name)
        ax.set_title(
            _scene_title(without, ablation.switches) + _motion_title(result), fontsize=font_size(9.0)
        )
    _share_labels(panels)
    return panels


def _panels(rows: int, columns: int, ax: Axes | None) -> list[Axes]:
    """Axes in rows: of a new figure, or in the place of axes that are given."""
    if ax is None:
        figure = new_figure(3.25 * columns, 3.0 * rows)
        return list(figure.subplots(rows, columns, squeeze=False, subplot_kw=RUN_AXES).ravel())
    ax.set_axis_off()
    width, height = 1.0 / columns, 1.0 / rows
    corners = [(column * width, 1.0 - (row + 1) * height) for row in range(rows) for column in range(columns)]
    return [ax.inset_axes((x, y, PANEL_SHARE * width, PANEL_SHARE * height)) for x, y in corners]


def _panel_for(results: Iterable[Any]) -> Any:
    kinds = {type(result) for result in results}
    panels = {SteadyState: _phase_plane, Bifurcation: _points, Spectrum: _spectrum}
    if len(kinds) != 1 or not kinds <= panels.keys():
        got = ", ".join(sorted(kind.__name__ for kind in kinds))
        raise TypeError(
            f"results must all be SteadyState, Bifurcation, Spectrum or numbers, got {got}: let the study "
            "return one of these"
        )
    return panels[kinds.pop()]


def _share_labels(panels: list[Axes]) -> None:
    """Labels at the outer panels only, and one legend for all."""
    for i, ax in enumerate(panels):
        ax.set_xlabel(wrap_label(ax.get_xlabel(), LABEL_LENGTH))
        ax.tick_params(labelsize=font_size(8.0))
        ax.locator_params(axis="x", nbins=4)
        if i < len(panels) - COLUMNS:
            ax.set_xlabel("")
        if i % COLUMNS:
            ax.set_ylabel("")
    handles = {str(text): h for ax in panels for h, text in zip(*ax.get_legend_handles_labels())}
    if handles:
        panels[0].figure.legend(handles=list(handles.values()), loc="outside right center", frameon=False)


def _phase_plane(result: Any, ax: Axes, name: str | None) -> None:
    plot_steady_state(result, ax, name=name)


def _points(result: Any, ax: Axes, name: str | None) -> None:
    plot_bifurcation(result, ax, name=name, legend=False)


def _spectrum(result: Any, ax: Axes, name: str | None) -> None:
    plot_amplitudes(result, ax)


def _scene_title(without: tuple[str, ...], switches: tuple[str, ...]) -> str:
    if not without:
        return all_of(len(switches)).replace("it", switches[0]) if switches else "all"
    left = [name for name in switches if name not in without]
    return f"only {left[0]}" if len(left) == 1 else f"without {', '.join(without)}" if left else "none"


def _motion_title(result: Any) -> str:
    kind = getattr(result, "kind", "")
    return f"\n{kind}" if isinstance(kind, str) and kind else ""


def _bars(ablation: Any, ax: Axes) -> Axes:
    values = np.array([np.nan if result is None else result for _, result in ablation], dtype=float)
    bars = ax.barh(range(len(values)), np.nan_to_num(values), color=BLUE)
    ax.bar_label(bars, ["" if np.isnan(v) else f"{v:.5g}" for v in values], padding=4)
    for i in np.flatnonzero(np.isnan(values)):
        ax.text(0.01, float(i), "none", va="center", transform=ax.get_yaxis_transform())
    ax.set_yticks(range(len(values)), [_scene_title(without, ablation.switches) for without, _ in ablation])
    ax.invert_yaxis()
    known = values[~np.isnan(values)]
    if len(known) and known.min() > 0 and known.max() > LOG_SCALE_RATIO * known.min():
        ax.set_xscale("log")
    ax.axvline(0.0, **pen(GREY, 0.8, ax))
    ax.margins(x=0.15 * crowding())
    return ax
