"""Pictures of sweeps and ablations show what was computed, every kind of motion in a style of its own."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.colors import to_hex

import frictionlab as fl
from frictionlab import plotting
from frictionlab.plotting.studies.sweeps import EARLY_END_HEIGHT, MOTION_STYLES

MODEL = fl.SliderOnBelt()
AXIS = r"coefficient of kinetic friction $\mu_{\mathrm{k}}$"
KINDS = ("equilibrium", "periodic", "non-periodic", "not settled yet", "ended early", "")


@pytest.fixture(scope="module")
def swept():
    """A sweep in which every kind occurs, and one value was not done."""
    model = MODEL.without("geometry")
    values = [0.3, 0.5, 1.4, 1.9, 2.5, 2.9]
    found = fl.bifurcation(model, "mu_k", values, transient=5.0, window=5.0, progress=False)
    intensities = np.array([1e-14, 1e-3, 2e-3, 1e-2, np.nan, np.nan])
    return replace(found, kinds=KINDS, intensities=intensities)


def test_every_kind_has_points_of_its_own(swept):
    lines = plotting.plot_bifurcation(swept, name="x1'")
    by_kind = {str(line.get_label()): line for line in lines}
    assert list(by_kind) == ["periodic", "non-periodic", "not settled yet", "ended early", "equilibrium"]
    for i, kind in enumerate(KINDS[1:4], start=1):
        states = swept.sections[i][:, swept.names.index("x1'")]
        assert np.array_equal(by_kind[kind].get_ydata(), states)
        assert set(by_kind[kind].get_xdata()) == {swept.values[i]}
    ended = by_kind["ended early"]
    assert set(ended.get_xdata()) == {swept.values[4]}
    assert len(ended.get_ydata()) == len(swept.sections[4])
    assert set(ended.get_ydata()) == {EARLY_END_HEIGHT}
    still = by_kind["equilibrium"]
    assert (still.get_xdata().tolist(), len(still.get_ydata())) == ([0.3], 1)
    assert still.get_ydata()[0] == swept.results[0]["final"][swept.names.index("x1'")]
    assert to_hex(by_kind["periodic"].get_color()) != to_hex(by_kind["non-periodic"].get_color())
    ax = lines[0].axes
    assert ax.get_xlabel() == AXIS
    assert ax.get_ylabel() == r"$\dot{x}_{1}$ at the section (m/s)"
    assert len(ax.get_legend().get_texts()) == len(MOTION_STYLES)
    ax.figure.draw_without_rendering()
    assert not ax.get_legend().get_window_extent().overlaps(ax.get_window_extent())


def test_what_grew_beyond_all_bounds_is_marked_at_the_foot_and_leaves_the_scale():
    model = MODEL.without("geometry", "cubic", "nonsmooth")
    found = fl.bifurcation(model, "mu_k", [0.3, 2.5], transient=100.0, window=5.0, progress=False)
    assert found.kinds[1] == "ended early"
    assert np.abs(found.sections[1]).max() > 1e100
    lines = plotting.plot_bifurcation(found)
    (ended,) = (line for line in lines if line.get_label() == "ended early")
    assert np.abs(ended.axes.get_ylim()).max() < 1.0
    heights = ended.get_transform().transform(ended.get_xydata())[:, 1]
    bottom, top = ended.axes.bbox.intervaly
    assert np.all((bottom < heights) & (heights < bottom + 0.1 * (top - bottom)))


def test_intensities_that_span_decades_have_a_logarithmic_axis_with_a_zero(swept):
    (line,) = plotting.plot_intensity(
        replace(swept, intensities=np.array([0.0, 1e-5, 1e-3, 1e-2, 0.1, np.nan]))
    )
    ax = line.axes
    assert ax.get_yscale() == "symlog"
    assert ax.get_ylim()[0] <= 0.0
    assert (ax.get_xlabel(), ax.get_ylabel()) == (AXIS, r"intensity $L_{\mathrm{s}}$ (m$^{2}$)")
    assert ax.get_legend() is None
    hollow = next(other for other in ax.lines if other is not line)
    assert (hollow.get_xdata().tolist(), hollow.get_ydata().tolist()) == ([0.3], [0.0])


def test_intensities_of_one_size_have_a_linear_axis(swept):
    lines = plotting.plot_intensity([swept, swept], labels=["here", "there"])
    assert lines[0].axes.get_yscale() == "linear"
    for line in lines:
        assert np.array_equal(line.get_ydata(), swept.intensities, equal_nan=True)
    assert [text.get_text() for text in lines[0].axes.get_legend().get_texts()] == ["here", "there"]


@pytest.fixture(scope="module")
def ablated():
    return fl.ablation(
        MODEL, lambda m: fl.steady_state(m, transient=2.0, window=2.0, progress=False), progress=False
    )


@pytest.mark.slow
def test_eight_phase_planes(ablated):
    panels = plotting.plot_ablation(ablated)
    assert len(panels) == 8
    titles = [ax.get_title() for ax in panels]
    assert titles[0] == f"all three\n{ablated.results[0].kind}"
    assert titles[1].startswith("without geometry")
    assert titles[-1].startswith("none")
    assert [t.splitlines()[0] for t in titles].count("only cubic") == 1
    assert all(ax.lines for ax in panels)
    assert panels[4].get_xlabel() == "$x_{1}$ (m)"
    assert panels[0].get_ylabel() == r"$\dot{x}_{1}$ (m/s)"
    assert panels[1].get_ylabel() == panels[0].get_xlabel() == ""
    (legend,) = panels[0].figure.legends
    assert {"slip+", "slip"} <= {text.get_text() for text in legend.get_texts()}


@pytest.mark.slow
def test_an_equilibrium_is_a_mark(ablated):
    results = tuple(replace(result, kind="equilibrium") for result in ablated.results)
    panels = plotting.plot_ablation(replace(ablated, results=results), name="y2")
    (mark,) = panels[0].lines
    assert mark.get_xdata()[0] == results[0].trajectory.final_state[results[0].trajectory.names.index("y2")]


@pytest.mark.slow
def test_eight_spectra_and_what_was_not_done(ablated):
    spectra = tuple(result.spectrum() for result in ablated.results)
    panels = plotting.plot_ablation(replace(ablated, results=(*spectra[:7], None)))
    assert np.array_equal(panels[2].lines[0].get_ydata(), spectra[2].amplitudes)
    assert panels[0].get_yscale() == "log"
    assert [text.get_text() for text in panels[7].texts] == ["not done"]


@pytest.mark.slow
def test_numbers_are_bars(ablated):
    values = (1.0, 2.0, None, -0.5, 0.0, 1.0, 1.0, 3.0)
    (ax,) = plotting.plot_ablation(replace(ablated, results=values))
    assert [bar.get_width() for bar in ax.patches] == [v or 0.0 for v in values]
    assert [text.get_text() for text in ax.texts] == ["1", "2", "", "-0.5", "0", "1", "1", "3", "none"]
    assert ax.get_yticklabels()[1].get_text() == "without geometry"
    assert ax.get_xscale() == "linear"
    (decades,) = plotting.plot_ablation(replace(ablated, results=tuple(10.0**k for k in range(8))))
    assert decades.get_xscale() == "log"
    (none,) = plotting.plot_ablation(replace(ablated, results=(None,) * 8))
    assert len(none.patches) == 8
