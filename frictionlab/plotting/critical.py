"""Critical values of one parameter against another."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from .figure import axes_or_new
from .legends import legend_beside
from .palette import line_style
from .parameters import distinct_names, parameter_label


def plot_critical(
    curves: Any, ax: Axes | None = None, *, labels: Sequence[str] | None = None, legend: bool = True
) -> list[Line2D]:
    """Draw critical values of a parameter against another: below a line steady sliding is stable.

    Parameters
    ----------
    curves : CriticalCurve, or a sequence of them
        Of the same two parameters.
    ax : Axes or None
        None draws into a new figure, ``lines[0].axes.figure``.
    labels : sequence of str or None
        A name for each curve; None takes what their models differ in.
    legend : bool
        Whether to put a legend beside the panel, where there is more than one curve.

    Returns
    -------
    list of Line2D
        One for every curve, broken where there is no critical value (NaN).

    Raises
    ------
    ValueError
        Where the curves are of different parameters, or there are not as many labels as curves.

    Examples
    --------
    >>> import frictionlab as fl
    >>> from frictionlab.plotting import plot_critical
    >>> curve = fl.critical_curve(fl.SliderOnBelt(), "mu_k", (0, 3), over=("F", [200.0, 400.0]))
    >>> [line.axes.get_xlabel() for line in plot_critical(curve)]
    ['preload on the slider $F$ (N)']
    """
    curves = [curves] if hasattr(curves, "over") else list(curves)
    labels = _labels(curves) if labels is None else list(labels)
    _refuse_mixed(curves, labels)
    ax = axes_or_new(ax)
    lines = []
    for i, (curve, label) in enumerate(zip(curves, labels)):
        lines += ax.plot(curve.at, curve.values, label=label, **line_style(i, ""))
    first = curves[0]
    ylabel = f"critical {parameter_label(first.model, first.parameter)}"
    ax.set(xlabel=parameter_label(first.model, first.over), ylabel=ylabel)
    ax.margins(x=0)
    if legend and len(curves) > 1:
        legend_beside(ax)
    return lines


def _labels(curves: list[Any]) -> list[str]:
    varied = {name for curve in curves for name in (curve.parameter, curve.over)}
    return distinct_names([curve.model for curve in curves], varied) if curves else []


def _refuse_mixed(curves: list[Any], labels: list[str]) -> None:
    pairs = sorted({f"{curve.parameter} over {curve.over}" for curve in curves})
    if len(pairs) != 1:
        got = ", ".join(pairs) or "no curve"
        raise ValueError(f"curves must be of one parameter over one other, got {got}: draw them apart")
    if len(labels) != len(curves):
        raise ValueError(f"there must be a label for each of {len(curves)} curves, got {len(labels)}")
