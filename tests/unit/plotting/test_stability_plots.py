"""Pictures of stability show what was computed, with symbols and units, and legends beside the data."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import frictionlab as fl
from frictionlab import plotting
from frictionlab.plotting.root_locus import GROWING_LINE_WIDTH

MODEL = fl.SliderOnBelt(F=1000.0, l1=0.1, l2=0.3)
AXIS = r"coefficient of kinetic friction $\mu_{\mathrm{k}}$"


@pytest.fixture(scope="module")
def locus():
    return fl.root_locus(MODEL, "mu_k", np.linspace(0.0, 3.0, 121))


@pytest.fixture(scope="module")
def curves():
    models = (MODEL, MODEL.without("geometry"))
    over = "F", [200.0, 600.0, 1000.0]
    with pytest.warns(RuntimeWarning, match="no critical mu_k in 0 to 1"):
        return [fl.critical_curve(m, "mu_k", (0.0, 1.0), over=over) for m in models]


def beside(ax):
    """Whether the legend covers nothing of the panel, once all is laid out."""
    ax.figure.draw_without_rendering()
    return not ax.get_legend().get_window_extent().overlaps(ax.get_window_extent())


@pytest.mark.parametrize(
    ("plot", "values", "unit"),
    [
        (plotting.plot_frequencies, "frequencies", "frequency (Hz)"),
        (plotting.plot_growth_rates, "growth_rates", "growth rate (1/s)"),
    ],
)
def test_lines_are_those_of_the_locus_and_heavy_where_a_mode_grows(locus, plot, values, unit):
    lines = plot(locus)
    growing = np.flatnonzero((locus.growth_rates > 0).any(axis=0))
    assert len(lines) == 5 + len(growing) == 7
    for mode, line in enumerate(lines[:5]):
        assert np.array_equal(line.get_xdata(), locus.at)
        assert np.array_equal(line.get_ydata(), getattr(locus, values)[:, mode])
        assert line.get_label() == f"mode {mode}"
    for mode, line in zip(growing, lines[5:], strict=True):
        assert line.get_linewidth() == GROWING_LINE_WIDTH
        assert np.array_equal(np.isfinite(line.get_ydata()), locus.growth_rates[:, mode] > 0)
        assert line.get_color() == lines[mode].get_color()
    ax = lines[0].axes
    assert (ax.get_xlabel(), ax.get_ylabel()) == (AXIS, unit)
    assert "heavy: the mode grows" in [text.get_text() for text in ax.get_legend().get_texts()]
    assert beside(ax)


def test_no_equilibrium_is_a_gap():
    locus = fl.root_locus(fl.SliderOnBelt(), "F", [1.0, 100.0, 200.0])
    values = locus.values.copy()
    values[0] = complex(np.nan, np.nan)
    gappy = replace(locus, values=values)
    line = plotting.plot_frequencies(gappy)[0]
    assert np.isnan(line.get_ydata()).tolist() == [True, False, False]
    assert line.axes.get_xlabel() == "preload on the slider $F$ (N)"
    (curve, *_) = plotting.plot_root_locus(gappy)
    assert len(curve.get_segments()) == 1


@pytest.mark.slow
def test_the_root_locus_runs_along_the_eigenvalues(locus):
    curves = plotting.plot_root_locus(locus, modes=[0, 1])
    for mode, curve in enumerate(curves):
        starts = np.array([piece[0] for piece in curve.get_segments()])
        assert np.array_equal(starts[:, 0], locus.growth_rates[:-1, mode])
        assert np.array_equal(starts[:, 1], locus.frequencies[:-1, mode])
        assert curve.get_clim() == (0.0, 3.0)
        assert np.array_equal(curve.get_array(), 0.5 * (locus.at[1:] + locus.at[:-1]))
    ax = curves[0].axes
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("growth rate (1/s)", "frequency (Hz)")
    assert any(np.array_equal(line.get_xdata(), [0.0, 0.0]) for line in ax.lines)
    bar = next(other for other in ax.figure.axes if other is not ax)
    assert bar.get_ylabel() == AXIS
    ends = [text.get_text() for text in ax.get_legend().get_texts()]
    assert ends == [r"$\mu_{\mathrm{k}}$ = 0", r"$\mu_{\mathrm{k}}$ = 3"]
    assert beside(ax)
    left, right = ax.get_xlim()
    assert left < locus.growth_rates[:, :2].min() < locus.growth_rates[:, :2].max() < right


def test_critical_curves_have_gaps_and_names(curves):
    lines = plotting.plot_critical(curves, labels=["with", "without"])
    for line, curve in zip(lines, curves, strict=True):
        assert np.array_equal(line.get_xdata(), curve.at)
        assert np.array_equal(line.get_ydata(), curve.values, equal_nan=True)
    assert np.isnan(curves[1].values).all()
    ax = lines[0].axes
    assert ax.get_xlabel() == "preload on the slider $F$ (N)"
    assert ax.get_ylabel() == f"critical {AXIS}"
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["with", "without"]
    assert beside(ax)


@pytest.mark.slow
def test_a_map_of_the_model():
    x, y = ("F", np.linspace(0.0, 1000.0, 9)), ("mu_k", np.linspace(0.0, 3.0, 7))
    plane = fl.stability_map(MODEL, x=x, y=y)
    mesh, boundary = plotting.plot_stability_map(plane)
    counts = mesh.get_array()
    assert np.array_equal(np.ma.filled(counts, -1), plane.unstable)
    assert len(boundary) >= len(plane.boundary) > 0
    ax = mesh.axes
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("preload on the slider $F$ (N)", AXIS)
    assert (ax.get_xlim(), ax.get_ylim()) == ((0.0, 1000.0), (0.0, 3.0))
    names = [text.get_text() for text in ax.get_legend().get_texts()]
    assert names == ["stable", "1 mode grows", "2 modes grow", "no equilibrium", "flutter"]
    assert beside(ax)


@pytest.fixture
def plane():
    """A map with all that a map can have."""

    def curve(*frequencies):
        points = np.column_stack([np.linspace(100.0, 200.0, len(frequencies))] * 2)
        return SimpleNamespace(points=points, frequencies=np.array(frequencies), unstable=(0, 1))

    return SimpleNamespace(
        model=MODEL,
        x="F",
        y="k1",
        x_values=np.array([100.0, 150.0, 200.0]),
        y_values=np.array([100.0, 200.0]),
        unstable=np.array([[0, 1, 4], [3, 1, -1]]),
        boundary=(curve(0.0, 0.0, 12.0, 13.0), curve(np.nan, np.nan), curve(14.0, 15.0)),
    )


def test_every_kind_of_boundary_has_its_line(plane):
    mesh, boundary = plotting.plot_stability_map(plane)
    styles = {str(line.get_label()): line.get_linestyle() for line in boundary}
    assert styles == {"divergence": "--", "flutter": "-", "end of the equilibrium": "--"}
    assert len(boundary) == 4
    flutter = next(line for line in boundary if line.get_label() == "flutter")
    assert np.isnan(flutter.get_xdata()).tolist() == [True, True, False, False]
    assert mesh.axes.get_ylabel().endswith("(N/m)")


def test_a_plane_without_equilibrium_is_hatched_and_many_modes_share_a_colour(plane):
    mesh, _ = plotting.plot_stability_map(plane)
    counts = mesh.get_array()
    assert np.ma.getmaskarray(counts).tolist() == [[False, False, False], [False, False, True]]
    assert counts.max() == 3
    assert mesh.axes.patch.get_hatch()
    names = [text.get_text() for text in mesh.axes.get_legend().get_texts()]
    assert names[:4] == ["stable", "1 mode grows", "3 modes or more grow", "no equilibrium"]
    assert len(set(names)) == len(names) == 7
