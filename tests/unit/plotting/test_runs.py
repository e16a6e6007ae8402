"""What the panels show is what the run computed, with units."""

import re
from itertools import pairwise

import numpy as np
import pytest
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

import frictionlab as fl
from frictionlab import plotting
from frictionlab.models.mechanism import Block, Forces, Mechanism, Point
from frictionlab.pages.scene import formula_controls, quantity_data
from frictionlab.plotting.animation.parts import parts
from frictionlab.plotting.labels import state_label
from frictionlab.plotting.time_histories import Periods, mode_intervals, window_limits
from frictionlab.presentation import state_unit
from tests.helpers.automata import oscillator

SCENES = {
    "all": fl.SliderOnBelt(mu_k=1.4),
    "4 dof": fl.SliderOnBelt(mu_k=1.4).without("geometry"),
    "sliding only": fl.SliderOnBelt(mu_k=1.4).without("nonsmooth", "cubic"),
    "stick-slip": fl.SliderOnBelt(mu_k=1.4, interface=fl.StickSlip()),
    "sliding, separation": fl.SliderOnBelt(mu_k=1.4, interface=fl.SlidingSeparation()),
}


@pytest.fixture(scope="module")
def run():
    return fl.simulate(SCENES["4 dof"], 2.0, progress=False)


@pytest.mark.parametrize("model", SCENES.values(), ids=SCENES)
def test_displacements_are_those_of_the_run(model):
    run = fl.simulate(model, 0.3, progress=False)
    lines = plotting.plot_displacements(run, window=(0.1, 0.2))
    assert len(lines) == len(model.coordinates)
    for i, line in enumerate(lines):
        t, x = line.get_data()
        assert (t[0], t[-1]) == (0.1, 0.2)
        assert np.array_equal(x, run(t)[:, i])


def test_forces_are_those_of_the_run(run):
    normal, friction = plotting.plot_contact_forces(run)
    t = normal.get_xdata()
    assert np.array_equal(normal.get_ydata(), run.output("normal_force", t))
    assert np.array_equal(friction.get_ydata(), run.output("friction_force", t))
    assert normal.axes.get_ylabel() == "contact force (N)"


@pytest.mark.parametrize(
    ("lever", "shared", "of_friction", "of_contact"),
    [(1, True, "", "N/m"), (1, False, "rad/s", "N/m"), (1.0, True, "m/s", "N/m"), (2, True, "m/s", "N/m")],
)
def test_laws_have_the_units_of_the_contacts_that_they_serve(lever, shared, of_friction, of_contact):
    @fl.model
    class BrakedSlider(fl.MechanicalModel):
        contact: fl.ContactLaw = fl.CubicContact()
        friction: fl.FrictionLaw = fl.Stribeck()
        coordinates = ("theta", "x", "y")

        def mechanics(self, q, v):
            brake = fl.Friction(2.0 - lever * v.theta, 3.0, self.friction)
            law = self.friction if shared else fl.Coulomb(0.3, 0.4)
            pad = fl.Friction(1.0 - v.x, self.contact.force, law, penetration=q.y)
            kinetic = (v.theta**2 + v.x**2 + v.y**2) / 2
            return fl.Mechanics(kinetic, (q.theta**2 + q.x**2 + q.y**2) / 2 - q.y, contacts=(brake, pad))

    units = {row.name: row.unit for row in BrakedSlider().describe()}
    assert (units["v_s"], units["k2"]) == (of_friction, of_contact)


@pytest.mark.parametrize(
    ("lever", "forces", "speed", "of_friction"),
    [(1, ["M_N", "M_T"], "rad/s", "rad/s"), (2, ["M_N", "F_N", "M_T", "F_T"], "", "")],
)
def test_two_contacts_have_units_of_their_own(lever, forces, speed, of_friction):
    @fl.model
    class Pads(fl.MechanicalModel):
        friction: fl.FrictionLaw = fl.FrictionCurve()
        contact: fl.ContactLaw = fl.PolynomialContact()
        coordinates = ("phi", "psi")
        mechanism = Mechanism(Block(Point(0, 0), 1, 1), Forces(Point(0, 0), "_1"), Forces(Point(0, 0), "_2"))

        def mechanics(self, q, v):
            one = fl.Friction(2.0 - v.phi, self.contact.force, self.friction, penetration=q.phi)
            two = fl.Friction(2.0 - lever * v.psi, 3.0, self.friction)
            potential = (q.phi**2 + q.psi**2) / 2 - q.phi
            return fl.Mechanics((v.phi**2 + v.psi**2) / 2, potential, contacts=(one, two))

    model = Pads()
    units = {row.name: row.unit for row in model.describe()}
    assert (units["v_1"], units["a2"]) == (of_friction, "N m")
    legend = parts(fl.simulate(model, 1.0, progress=False), model.mechanism, np.linspace(0.0, 1.0, 5)).forces
    found = [(text[1:4], text.split(" ", 4)[-1]) for text in legend]
    assert found == [(name, "N m" if name[0] == "M" else "N") for name in forces]
    assert quantity_data(model, model.automaton())["sliding_units"]["speed"] == speed
    (formula,) = formula_controls([model])
    assert f"sliding speed v{of_friction and ' in rad/s'}, on" in formula["hint"]


def test_a_contact_that_turns_without_a_lever_has_moments():
    model = fl.DrillString(Omega=25.0)
    lines = plotting.plot_contact_forces(fl.simulate(model, 5.0, progress=False))
    assert [line.get_label() for line in lines] == ["$M_N$ (N m)", "$M_T$ (N m)"]
    assert lines[0].axes.get_ylabel() == "contact moment (N m)"
    # N = T, and the motor's torque at the speed of the bit balances friction
    point = fl.equilibrium(model)
    assert repr(point).endswith(f"M_N {model.T:.4g} N m, M_T {-model.c_m * (25.0 - point.state[2]):.4g} N m)")
    assert fl.simulate(fl.RockingBlock(), 0.1).to_dataframe().attrs["units"]["distance"] == "rad"
    units = {row.name: row.unit for row in model.describe()}
    assert (units["v_s"], units["k"]) == ("rad/s", "N m")
    pendulum = fl.FroudePendulum()  # its shaft has a radius
    assert pendulum.rotational_outputs == ()
    assert {row.name: row.unit for row in pendulum.describe()}["v_s"] == "m/s"


def test_phase_plane_holds_every_sample_in_the_colour_of_its_mode(run):
    lines = plotting.plot_phase_plane(run, window=0.5)
    t = np.linspace(1.5, 2.0, 12001)
    modes = run_modes(run, t)
    assert {line.get_label() for line in lines} == set(modes)
    for line in lines:
        x, rate = line.get_data()
        own = modes == line.get_label()
        assert np.array_equal(x[own], run(t)[own, 0])
        assert np.array_equal(rate[own], run(t)[own, 4])
        assert np.isnan(x).sum() > len(t) * 0.05
    assert "(m)" in lines[0].axes.get_xlabel()
    assert "(m/s)" in lines[0].axes.get_ylabel()


def run_modes(run, t):
    """Modes at times, from the event table alone."""
    after = np.searchsorted(run.events.t, t, side="right")
    return np.append(run.events.source[:1], run.events.target)[after]


def test_shading_covers_the_window_once_and_matches_the_time_in_each_mode(run):
    ax = Figure().add_subplot()
    shades = plotting.shade_modes(run, ax, window=None)
    assert all(isinstance(shade, PolyCollection) for shade in shades)
    widths = {shade.get_label(): shaded_seconds(shade) for shade in shades}
    assert widths == pytest.approx({k: s for k, s in run.time_in_mode.items() if s > 0}, rel=1e-9)
    assert sum(widths.values()) == pytest.approx(2.0)


def shaded_seconds(shade):
    return sum(np.ptp(path.vertices[:, 0]) for path in shade.get_paths())


def test_chatter_does_not_divide_the_shading():
    run = fl.simulate(SCENES["all"], 0.3, progress=False)
    edges, names = mode_intervals(run)
    assert len(run.events) > 50 > len(names)
    assert len(edges) == len(names) + 1
    assert all(a != b for a, b in pairwise(names))
    assert (np.diff(edges) > 0).all()


def test_spectrum_of_a_known_vibration():
    # Without coupling to the contact x2 of the belt is a free oscillator: 10 Hz, 0.02 m, hardly damped.
    k4 = (2 * np.pi * 10.0) ** 2
    model = fl.SliderOnBelt(mu_k=0.0, k4=k4, c4=0.0).without("geometry", "nonsmooth")
    run = fl.simulate(model, 20.0, x0=[0, 0, 0.02, 0, 0, 0, 0, 0], progress=False)
    found = plotting.amplitude_spectrum(run, "x2")
    assert found is not None
    assert found.resolution == pytest.approx(0.1)
    assert found.strongest == pytest.approx(10.0)
    assert found.amplitudes.max() == pytest.approx(0.02, rel=1e-3)
    assert found.frequencies[-1] <= 60.0


def test_spectrum_states_its_resolution_and_unit(run):
    (line,) = plotting.plot_spectrum(run)
    assert re.search(r"resolution 1 Hz.*strongest line 1\d Hz", line.axes.get_title())
    assert "(m)" in line.axes.get_ylabel()
    assert "(Hz)" in line.axes.get_xlabel()
    assert line.axes.get_xlim() == (0, 60)


def test_a_run_too_short_for_a_spectrum_says_so():
    ax = Figure().add_subplot()
    run = fl.simulate(SCENES["all"], 0.02, progress=False)
    assert plotting.amplitude_spectrum(run) is None
    assert plotting.plot_spectrum(run, ax) == []
    assert "too short" in ax.texts[0].get_text()


@pytest.mark.parametrize("window", [(0.5, 3.0), (1.0, 0.5), (-0.1, 1.0), (1.0, 1.0), -1.0])
def test_a_window_outside_the_run_is_refused(run, window):
    with pytest.raises(ValueError, match="window must lie within the run, 0 to 2 s"):
        plotting.plot_displacements(run, window=window)


@pytest.mark.parametrize("name", ["displacements", "contact_forces", "phase_plane", "spectrum", "rates"])
def test_a_panel_is_of_a_run(name):
    with pytest.raises(TypeError, match=r"run must be a Trajectory, got SliderOnBelt\(\): give what"):
        getattr(plotting, f"plot_{name}")(fl.SliderOnBelt())


def test_a_spectrogram_has_the_amplitude_of_a_sine_in_decibels():
    """Of a mass that slides without stick, which is linear."""
    model = fl.ExcitedBeltOscillator(v=30.0, Omega=np.pi)
    orbit = fl.periodic_orbit(model, fl.simulate(model, 200.0, progress=False))
    run = fl.simulate(model, 100.0, x0=orbit.state, progress=False)
    mesh = fl.plot_spectrogram(run, name="x", f_max=2.0, window=10.0)
    levels = np.asarray(mesh.get_array())
    amplitude = model.u / np.hypot(1 - np.pi**2, model.c * np.pi)
    assert levels.max(axis=0) == pytest.approx(20 * np.log10(amplitude), abs=0.05)
    frequencies = np.linspace(0.0, 2.0, 21)
    assert np.all(frequencies[levels.argmax(axis=0)] == 0.5)
    assert mesh.axes.get_xlabel() == "time (s)"
    short = fl.plot_spectrogram(fl.simulate(model, 8.0, x0=orbit.state, progress=False), name="x", f_max=2.0)
    assert short.get_array().shape[0] == 6  # lines 0.4 Hz apart, as five periods of 2 Hz last 2.5 s


@pytest.mark.parametrize(
    ("keywords", "said"),
    [
        ({"name": "z"}, "name must be one of"),
        ({"window": 0.01}, "window must be .* at least"),
        ({"window": 1.5}, "window must be .* at most 1"),
        ({"f_max": -1.0}, "f_max must be .* above 0"),
        ({"f_max": 1e9}, "number of samples must be .* lower f_max"),
    ],
)
def test_what_has_no_spectrogram_is_refused(run, keywords, said):
    with pytest.raises(ValueError, match=said):
        fl.plot_spectrogram(run, **keywords)


def test_coordinates_with_greek_names_are_angles():
    labels = {
        "alpha": r"$\alpha$",
        "theta2'": r"$\dot{\theta}_{2}$",
        "phi_M": r"$\varphi_{M}$",
        "x_left": r"$x_{\mathrm{left}}$",
        "gap_left": "gap_left",
        "a$b": r"a\$b",
    }
    assert {name: state_label(name) for name in labels} == labels
    units = {"alpha": "rad", "beta1'": "rad/s", "phi_M": "rad", "a": "m", "x_left'": "m/s"}
    assert {name: state_unit(name) for name in units} == units


def test_the_first_coordinate_that_does_not_turn_for_ever_is_shown():
    systems = fl.Woodpecker(), fl.DrillString(), fl.MassOnBelt(), oscillator()
    assert [each.automaton().shown_state for each in systems[:3]] == ["phi_M", "phi1", "x"]
    assert systems[3].shown_state == "x"


def test_where_nothing_moves_at_the_end_what_moved_is_shown():
    run = fl.simulate(fl.RockingBlock(), 60.0, progress=False)
    start, stop = window_limits(run)
    assert start == 0.0
    assert run.events.t[-1] < stop < 60.0
    assert window_limits(run, Periods(1.0))[1] == 60.0
