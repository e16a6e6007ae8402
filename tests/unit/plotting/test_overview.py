"""The picture of a run."""

import subprocess
import sys

import numpy as np
import pytest
import sympy as sp
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

import frictionlab as fl

MODEL = fl.SliderOnBelt(mu_k=1.4)


def drawn(run):
    figure = fl.plot_run(run)
    FigureCanvasAgg(figure).draw()
    return figure


@pytest.mark.plain_python
def test_four_panels_with_units_everywhere():
    figure = drawn(fl.simulate(MODEL, 0.2, progress=False))
    assert len(figure.axes) == 5  # the angle beside the displacements has an axis
    labels = [text for ax in figure.axes[:4] for text in (ax.get_xlabel(), ax.get_ylabel())]
    assert all(text.endswith(("(s)", "(m)", "(N)", "(Hz)", "(m/s)")) for text in labels)
    assert all(ax.get_title() for ax in figure.axes[:4])
    assert "SliderOnBelt(mu_k=1.4), 0.2 s" in figure.get_suptitle()


@pytest.mark.plain_python
def test_a_very_short_run_is_drawn():
    assert len(drawn(fl.simulate(MODEL, 1e-9, progress=False)).axes) == 5


@pytest.mark.parametrize("method", ["taylor", "rk4", "DOP853"])
@pytest.mark.parametrize("interface", [fl.StickSlip(), fl.SlidingSeparation(), fl.SlidingOnly()], ids=repr)
def test_every_interface_and_method(interface, method):
    model = MODEL.without("geometry").replace(interface=interface)
    run = fl.simulate(model, 0.2, method=method, progress=False)
    figure = drawn(run)
    assert len(figure.axes) == 4
    shown = {text.get_text() for text in figure.legends[0].get_texts()}
    assert shown == {name for name, seconds in run.time_in_mode.items() if seconds > 0}


def test_nothing_overlaps():
    figure = drawn(fl.simulate(MODEL, 2.0, progress=False))
    renderer = figure.canvas.get_renderer()
    panels = [ax.get_tightbbox(renderer) for ax in figure.axes[:4]]
    legends = [legend.get_window_extent() for legend in figure.legends]
    boxes = panels + legends
    pairs = [(a, b) for i, a in enumerate(boxes) for b in boxes[:i]]
    assert not any(a.overlaps(b) for a, b in pairs)
    angle = figure.axes[4].yaxis.get_tightbbox(renderer)
    assert not angle.overlaps(figure.axes[0].get_legend().get_window_extent())
    assert all(figure.bbox.containsx(box.x1) and figure.bbox.containsy(box.y1) for box in boxes)


def test_a_figure_given_is_used_and_a_run_that_ended_early_says_so():
    run = fl.simulate(MODEL, 2.0, method=fl.Taylor(max_steps=20), progress=False)
    figure = Figure()
    assert fl.plot_run(run, figure) is figure
    assert "step cap" in figure.get_suptitle()


def test_a_notebook_shows_the_figure_without_pyplot():
    code = (
        "import sys, frictionlab as fl\n"
        "figure = fl.plot_run(fl.simulate(fl.SliderOnBelt(), 0.1))\n"
        "assert figure._repr_png_()[:4] == b'\\x89PNG'\n"
        "assert 'matplotlib.pyplot' not in sys.modules\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_an_automaton_without_contact_forces_shows_its_rates():
    h, w = sp.symbols("h w")
    mode = fl.Mode("fall", flow=(w, sp.Integer(-1)), events=())
    automaton = fl.HybridAutomaton(states=(h, w), modes=(mode,), coordinates=1, parameters={})
    run = fl.solve(automaton, 1.0, x0=[1.0, 0.0], progress=False)
    assert np.isclose(run.final_state[0], 0.5)
    assert fl.plot_run(run).axes[2].get_ylabel() == "velocity (m/s)"
    run = fl.solve(fl.HybridAutomaton((h, w), (mode,)), 1.0, x0=[1.0, 0.0], progress=False)
    with pytest.raises(ValueError, match="must be of an automaton with coordinates"):
        fl.plot_run(run)


@pytest.mark.parametrize("draw", [fl.plot_run, fl.animate])
def test_a_model_in_the_place_of_its_run_is_refused(draw):
    with pytest.raises(
        TypeError, match=r"run must be a Trajectory, got SliderOnBelt.*: give what .*simulate"
    ):
        draw(fl.SliderOnBelt())


def test_a_long_title_stays_within_the_figure():
    law = fl.WeakeningStrengthening(mu_k=0.3125, mu_s=3.125, v_s=0.4375, mu_v=0.0625)
    run = fl.simulate(fl.SliderOnBelt(friction=law, k1=123456.0, k2=5125.0, F=212.5), 0.2)
    figure = fl.plot_run(run)
    figure.canvas.draw()
    (title,) = figure.texts
    box = title.get_window_extent()
    assert title.get_text().endswith("0.2 s, taylor")
    assert figure.bbox.x0 <= box.x0 < box.x1 <= figure.bbox.x1
    assert all(box.y0 >= ax.get_tightbbox().y1 for ax in figure.axes)
