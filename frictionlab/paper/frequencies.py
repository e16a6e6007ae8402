"""Fig. 18: frequencies of steady motions against the unstable eigenfrequencies of the linearised system."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from matplotlib.colors import LogNorm
from numpy.typing import NDArray

from frictionlab.analysis.steady_state import steady_state
from frictionlab.hybrid.methods import Method
from frictionlab.plotting import RunFigure
from frictionlab.plotting.palette import VERMILLION
from frictionlab.plotting.parameters import parameter_label
from frictionlab.stability import root_locus

from . import scenes
from .result import PaperFigure
from .setting import Setting
from .sweeps import results
from .wording import AT_REST

Array = NDArray[np.float64]
F_MAX = 60.0
BINS = 240  # of the picture; the strongest line of each is shown
DECADES = 3.0
# Panel -> nonlinearities left out.
LEFT_OUT = {
    "all three": (),
    "contact stiffness only": ("nonsmooth", "geometry"),
    "geometry only": ("cubic", "nonsmooth"),
    "non-smooth only": ("cubic", "geometry"),
}
GROWING = "geometry only"  # without bound, so that the number of steps has to have one
MOST = 300_000


@dataclass(frozen=True, eq=False)
class Panel:
    """Spectra of x1 against mu_k.

    Parameters
    ----------
    model : SliderOnBelt
    mu_k : array (N,)
    kinds : tuple of str (N,)
    amplitudes : array (N, 240)
        m; the strongest line in every quarter of a hertz.
    strongest : array (N,)
        Hz; NaN at rest.
    unstable : array (N, n)
        Frequencies (Hz) of the eigenvalues that grow; NaN for the others.
    fastest : array (N,)
        Frequency (Hz) of the eigenvalue that grows fastest; NaN where none grows.
    """

    model: Any
    mu_k: Array
    kinds: tuple[str, ...]
    amplitudes: Array
    strongest: Array
    unstable: Array
    fastest: Array

    @property
    def deviations(self) -> Array:
        """|f - f_e|/f_e of the strongest line where both exist, (K,)."""
        both = np.isfinite(self.strongest) & np.isfinite(self.fastest)
        return np.abs(self.strongest - self.fastest)[both] / self.fastest[both]


@dataclass(frozen=True, eq=False)
class Frequencies:
    """What Fig. 18 shows, by what is left in."""

    panels: dict[str, Panel]


def figure(number: int, setting: Setting) -> PaperFigure:
    """Fig. 18."""
    data = Frequencies({name: panel(name, setting) for name in LEFT_OUT})
    summary = tuple(f"{name}: {in_words(each)}" for name, each in data.panels.items())
    return PaperFigure(number, "spectra of x1 against mu_k", data, summary, _draw, str(setting))


def panel(name: str, setting: Setting) -> Panel:
    """One of the four."""
    model = scenes.STIFF.without(*LEFT_OUT[name])
    values = scenes.mu_k_stiff(setting)
    times, method = scenes.times_of(model, setting), setting.method
    if name == GROWING:
        method = replace(method, max_steps=MOST)
    study = partial(lines_of, times=times, method=method, tolerance=setting.tolerance)
    about = f"lines {method.describe()} {times} {setting.tolerance}"
    rows = results(about, study, model, {"mu_k": values}, setting).results
    strongest = np.array([np.nan if r["strongest"] is None else r["strongest"] for r in rows], dtype=float)
    amplitudes = np.array([r["amplitudes"] for r in rows])
    return Panel(
        model, values, tuple(r["kind"] for r in rows), amplitudes, strongest, *_unstable(model, values)
    )


def lines_of(model: Any, times: scenes.Times, method: Method, tolerance: float) -> dict[str, Any]:
    """Kind and spectrum of x1 in a steady state from rest, or up to where the run ended early."""
    found = steady_state(model, method=method, tolerance=tolerance, progress=False, **times._asdict())
    spectrum = found.spectrum(f_max=F_MAX)
    if spectrum is None or found.kind == AT_REST:
        return {"kind": found.kind, "strongest": None, "amplitudes": [0.0] * BINS}
    bins = np.minimum((spectrum.frequencies * (BINS / F_MAX)).astype(int), BINS - 1)
    amplitudes = np.zeros(BINS)
    np.maximum.at(amplitudes, bins, spectrum.amplitudes)
    strongest = float(spectrum.peaks()[0][0])
    return {"kind": found.kind, "strongest": strongest, "amplitudes": amplitudes.tolist()}


def _unstable(model: Any, values: Array) -> tuple[Array, Array]:
    locus = root_locus(model, "mu_k", values)
    growth = np.where(np.isfinite(locus.growth_rates), locus.growth_rates, -np.inf)
    unstable = np.where(growth > 0, locus.frequencies, np.nan)
    rows, best = np.arange(len(values)), growth.argmax(axis=1)
    return unstable, unstable[rows, best]


def in_words(each: Panel) -> str:
    """How far the strongest line is from the eigenvalue that grows fastest."""
    apart = each.deviations
    if not len(apart):
        return "no motion where an eigenvalue grows"
    return (
        f"strongest line {np.nanmin(each.strongest):.2f} to {np.nanmax(each.strongest):.2f} Hz, "
        f"off the unstable eigenfrequency by {100 * np.median(apart):.1f} % (median, {len(apart)} values), "
        f"{100 * apart.max():.1f} % at most"
    )


def _draw(result: PaperFigure) -> RunFigure:
    picture = RunFigure(figsize=(11.0, 8.0), layout="constrained")
    axes = picture.subplots(2, 2, sharex=True, sharey=True)
    for ax, (name, each), letter in zip(axes.flat, result.data.panels.items(), "abcd"):
        top = max(each.amplitudes.max(), np.finfo(float).tiny)
        foot = top * 10.0**-DECADES
        scale, shown = LogNorm(foot, top), np.maximum(each.amplitudes.T, foot)
        grid = np.linspace(0.0, F_MAX, BINS + 1)
        mesh = ax.pcolormesh(_edges(each.mu_k), grid, shown, norm=scale, cmap="viridis", rasterized=True)
        picture.colorbar(mesh, ax=ax, label="amplitude of $x_1$ (m)")
        style = {"color": VERMILLION, "marker": "o", "markersize": 3.0, "linestyle": "none"}
        marks = ax.plot(each.mu_k, each.unstable, **style)
        marks[0].set_label("unstable eigenfrequency")
        ax.set_title(f"({letter}) {name}")
    for ax in axes[1]:
        ax.set_xlabel(parameter_label(scenes.STIFF, "mu_k"))
    for ax in axes[:, 0]:
        ax.set_ylabel("frequency (Hz)")
    axes[0, 0].legend(loc="upper left", fontsize=8.0)
    picture.suptitle(result.heading("spectra of $x_1$ in steady states from rest"))
    return picture


def _edges(values: Array) -> Array:
    middles = 0.5 * (values[1:] + values[:-1])
    return np.concatenate([[values[0]], middles, [values[-1]]])
