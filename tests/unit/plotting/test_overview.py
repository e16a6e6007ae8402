"""The picture of a run."""

import numpy as np
import pytest
import sympy as sp
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

import frictionlab as fl
from frictionlab import plotting
from tests.helpers.results import result

MODEL = fl.SliderOnBelt(mu_k=1.4)


def drawn(run):
    figure = fl.plot_run(run)
    FigureCanvasAgg(figure).draw()
    return figure


@pytest.mark.plain_python
def test_four_panels_with_units_everywhere():
    figure = fl.plot_run(fl.simulate(MODEL, 0.2, progress=False))
    assert len(figure.axes) == 5  # the angle beside the displacements has an axis
    labels = [text for ax in figure.axes[:4] for text in (ax.get_xlabel(), ax.get_ylabel())]
    assert all(text.endswith(("(s)", "(m)", "(N)", "(Hz)", "(m/s)")) for text in labels)
    assert all(ax.get_title() for ax in figure.axes[:4])
    assert "SliderOnBelt(mu_k=1.4), 0.2 s" in figure.get_suptitle()


@pytest.mark.slow
@pytest.mark.plain_python
def test_a_very_short_run_is_drawn():
    assert len(drawn(fl.simulate(MODEL, 1e-9, progress=False)).axes) == 5


@pytest.mark.slow
@pytest.mark.parametrize(
    ("interface", "method"),
    [(fl.StickSlip(), "taylor"), (fl.SlidingSeparation(), "rk4"), (fl.SlidingOnly(), "DOP853")],
    ids=str,
)
def test_every_interface_and_method(interface, method):
    model = MODEL.without("geometry").replace(interface=interface)
    run = fl.simulate(model, 0.2, method=method, progress=False)
    figure = drawn(run)
    assert len(figure.axes) == 4
    shown = {text.get_text() for text in figure.legends[0].get_texts()}
    assert shown == {name for name, seconds in run.time_in_mode.items() if seconds > 0}


def test_a_figure_given_is_used_and_a_run_that_ended_early_says_so():
    run = fl.simulate(MODEL, 2.0, method=fl.Taylor(max_steps=20), progress=False)
    figure = Figure()
    assert fl.plot_run(run, figure) is figure
    assert "step cap" in figure.get_suptitle()


def test_an_automaton_without_contact_forces_shows_its_rates():
    h, w = sp.symbols("h w")
    mode = fl.Mode("fall", flow=(w, sp.Integer(-1)), events=())
    automaton = fl.HybridAutomaton(states=(h, w), modes=(mode,), coordinates=1, parameters={})
    run = fl.solve(automaton, 1.0, x0=[1.0, 0.0], progress=False)
    assert np.isclose(run.final_state[0], 0.5)
    assert fl.plot_run(run).axes[2].get_ylabel() == "rate"  # of which nothing tells the unit


def test_an_automaton_without_coordinates_shows_its_states():
    u, w = sp.symbols("u w")
    both = fl.HybridAutomaton((u, w), (fl.Mode("on", (w, -u)),))
    run = fl.solve(both, 20.0, x0=[1.0, 0.0], progress=False)
    states, plane, _ = drawn(run).axes
    for line, x in zip(states.lines, (np.cos, lambda t: -np.sin(t)), strict=True):
        assert line.get_ydata() == pytest.approx(x(line.get_xdata()), abs=1e-12)
    assert (plane.get_xlabel(), plane.get_ylabel()) == ("$u$", "$w$")
    one = fl.solve(fl.HybridAutomaton((u,), (fl.Mode("on", (-u,)),)), 1.0, x0=[1.0], progress=False)
    assert [ax.get_xlabel() for ax in drawn(one).axes] == ["time (s)", "frequency (Hz)"]


def test_a_cyclic_coordinate_whose_rate_has_any_name_has_the_spectrum_of_that_rate():
    phi, omega = sp.symbols("phi omega")
    turning = fl.HybridAutomaton((phi, omega), (fl.Mode("on", (omega, -sp.sin(phi))),), {}, 1, ("phi",))
    run = fl.solve(turning, 60.0, x0=[0.0, 3.0], progress=False)
    assert fl.plot_run(run).axes[3].get_ylabel() == "amplitude of $omega$"


@pytest.mark.filterwarnings("error")
def test_many_coordinates_leave_room_for_the_panels():
    structure = fl.Structure(np.eye(60), 100 * np.eye(60))
    run = fl.simulate(structure, 1.0, x0={"q0": 1e-3}, progress=False)
    figure = fl.plot_run(run)
    figure.draw_without_rendering()
    legend = figure.axes[0].get_legend()
    assert legend is not None
    assert [text.get_text() for text in legend.get_texts()][-1] == "and 48 more"


def test_names_of_modes_stand_beside_their_lines_in_place_of_a_legend():
    ax = result("orbit").plot()
    texts = fl.label_modes(ax)
    lines = {str(line.get_label()): line for line in ax.lines}
    assert {text.get_text() for text in texts} == {"stick", "slip+"}
    assert not ax.figure.legends
    assert ax.get_legend() is None
    FigureCanvasAgg(ax.figure).draw()
    for text in texts:
        points = ax.transAxes.inverted().transform(
            ax.transData.transform(lines[text.get_text()].get_xydata())
        )
        assert np.nanmin(np.hypot(*(points - text.xy).T)) < 0.01
        assert ax.get_window_extent().contains(*text.get_window_extent().get_points().mean(axis=0))


def test_labels_of_modes_need_axes_and_lines():
    assert fl.label_modes(Figure().add_subplot()) == []
    with pytest.raises(TypeError, match=r"ax must be axes of matplotlib, got None: write fl.label_modes"):
        fl.label_modes(None)


def test_states_of_an_automaton_have_no_unit_that_nobody_states():
    """They were metres in phase planes, spectra and tables; so was the current of a motor."""
    x, v = sp.symbols("x v")
    swing = fl.HybridAutomaton((x, v), (fl.Mode("on", (v, -x - 0.1 * v)),), coordinates=1)
    run = fl.solve(swing, 60.0, x0=[1.0, 0.0], progress=False)
    axes = plotting.plot_phase_plane(run, window=None)[0].axes
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("$x$", r"$\dot{x}$")
    assert plotting.plot_spectrum(run, f_max=2.0)[0].axes.get_ylabel() == "amplitude of $x$"
    assert repr(fl.equilibrium(swing)) == "Equilibrium(x 0)"
    assert run.to_dataframe().attrs["units"] == run.events.to_dataframe().attrs["units"] == {"t": "s"}
    motor = fl.simulate(fl.MotorAndCart(), 0.1, progress=False).to_dataframe().attrs["units"]
    assert "i" not in motor


def test_a_model_may_have_a_field_named_units():
    @fl.model
    class Pendulum(fl.MechanicalModel):
        units: float = 2.0
        coordinates = ("x",)

        def mechanics(self, q, v):
            return fl.Mechanics(v.x**2 / 2, self.units * q.x**2 / 2)

    run = fl.simulate(Pendulum(), 1.0, x0=[0.1, 0.0], progress=False)
    assert run.to_dataframe().attrs["units"] == {"t": "s", "x": "m", "x'": "m/s"}
