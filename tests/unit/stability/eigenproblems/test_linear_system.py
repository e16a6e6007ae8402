"""Linearised systems with inputs and outputs, against closed forms, scipy.signal and shifted equilibria."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import signal

import frictionlab as fl

SLIDER = fl.SliderOnBelt(mu_k=1.4)


@fl.model
class Loaded(fl.MechanicalModel):
    """A coupled pair of masses with a motor, whose base carries a load: every entry of B is known."""

    m: float = 2.0
    a: float = 0.5
    k: float = 50.0
    c: float = 0.7
    U: float = 3.0
    F: float = 0.0
    coordinates = ("x", "y")
    states = ("i",)

    def mechanics(self, q, v, s):
        return fl.Mechanics(
            kinetic=self.m * v.x**2 / 2 + v.y**2 / 2 + self.a * v.x * v.y,
            potential=self.k * (q.x**2 + (q.y - q.x) ** 2) / 2,
            dissipation=self.c * (v.x**2 + v.y**2) / 2,
            loads={"x": self.F + 0.1 * s.i},
            rates={"i": self.U - 2.0 * s.i - 0.3 * v.x},
        )


def test_coupled_masses_with_a_motor_respond_as_their_dynamic_stiffness_says():
    model = Loaded()
    system = fl.linearize(model)
    mass = np.array([[model.m, model.a], [model.a, 1.0]])
    assert system.B[2:4] == pytest.approx(np.linalg.inv(mass))
    assert not system.B[[0, 1, 4]].any()
    f = np.linspace(0.1, 3.0, 7)
    omega, stiffness = 2 * np.pi * f, model.k * np.array([[2.0, -1.0], [-1.0, 1.0]])
    for w, got in zip(omega, system.frequency_response(f).values):
        # the current follows the velocity: i = -0.3 v / (2 + i w)
        motor = np.diag([0.03 * 1j * w / (2.0 + 1j * w), 0.0])
        dynamic = stiffness + 1j * w * model.c * np.eye(2) + motor - w**2 * mass
        assert got == pytest.approx(np.linalg.inv(dynamic), rel=1e-10)


def test_responses_of_a_structure_to_forces_are_derived_once(monkeypatch):
    fl.linearize(Loaded())
    monkeypatch.setattr("frictionlab.stability.eigenproblems.linear_system.formulas_of", None)
    mass = [[4.0, 0.5], [0.5, 1.0]]
    assert fl.linearize(Loaded(m=4.0)).B[2:4] == pytest.approx(np.linalg.inv(mass), rel=1e-14)


def test_poles_are_the_eigenvalues_and_damping_ratios_those_of_the_modes():
    system, known = fl.linearize(SLIDER), fl.eigenvalues(SLIDER)
    assert np.sort_complex(system.eigenvalues) == pytest.approx(np.sort_complex(known.values), rel=1e-9)
    assert known.damping_ratios == pytest.approx(-known.values.real / np.abs(known.values))
    assert np.sort(system.damping_ratios) == pytest.approx(np.sort(known.damping_ratios), rel=1e-6)


@pytest.mark.filterwarnings("ignore::scipy.signal.BadCoefficients")  # scipy makes a ratio of polynomials
def test_scipy_signal_takes_the_matrices():
    system = fl.linearize(fl.ModeCoupling(), ["x"], ["y"])
    f = np.linspace(0.05, 0.4, 5)
    _, expected = signal.freqresp(signal.StateSpace(*system), 2 * np.pi * f)
    assert system.frequency_response(f).values[:, 0, 0] == pytest.approx(expected, rel=1e-8)


@pytest.mark.parametrize("model", [SLIDER, fl.SliderOnBelt(mu_k=0.3).without("geometry"), fl.ModeCoupling()])
def test_at_rest_the_response_to_a_parameter_is_the_shift_of_the_equilibrium(model):
    names, shown = ["F", "mu_k"], [model.coordinates[0], "normal_force", "penetration"]
    gain = fl.linearize(model, names, shown).frequency_response([0.0]).values[0].real
    for column, name in zip(gain.T, names):
        step = 1e-5 * getattr(model, name)
        there, back = (
            fl.equilibrium(model.replace(**{name: getattr(model, name) + s})) for s in (step, -step)
        )
        shift = [
            there.q[0] - back.q[0],
            there.normal_force - back.normal_force,
            there.penetration - back.penetration,
        ]
        assert column == pytest.approx(np.array(shift) / (2 * step), rel=1e-6)


def test_what_depends_on_a_parameter_at_once_is_in_d():
    belt = fl.MassOnBelt(friction=fl.Stribeck())
    system = fl.linearize(belt, ["N"], ["normal_force", "x"])
    assert system.D.tolist() == [[1.0], [0.0]]


@fl.model
class Rotor(fl.MechanicalModel):
    """A shaft that a constant moment turns against a damper."""

    J: float = 2.0
    c: float = 0.5
    T: float = 3.0
    coordinates = ("theta",)
    cyclic = ("theta",)

    def mechanics(self, q, v):
        kinetic, drag = self.J * v.theta**2 / 2, self.c * v.theta**2 / 2
        return fl.Mechanics(kinetic=kinetic, dissipation=drag, loads={"theta": self.T})


def test_what_turns_for_ever_responds_about_its_steady_rotation():
    system = fl.linearize(Rotor(), ["T", "theta"], ["theta", "theta'"])
    assert system.A.tolist() == [[0.0, 1.0], [0.0, -0.25]]
    speed = 1.0 / (2.0 * 2j * np.pi * 0.1 + 0.5)
    gain = system.frequency_response([0.1]).values[0]
    assert gain == pytest.approx(np.array([[speed / (2j * np.pi * 0.1)] * 2, [speed] * 2]))


def test_a_deflection_at_its_limit_follows_from_the_normal_force():
    """A Jenkins element that slips is Coulomb friction: k_t z = F_T at every frequency."""
    elastic = fl.ModeCoupling(friction=fl.Jenkins(mu_k=0.2, k_t=50.0))
    system = fl.linearize(elastic, outputs=["x", "y", "z", "friction_force"])
    assert "z" not in system.states
    values = system.frequency_response([0.0, 0.1, 0.3]).values
    assert 50.0 * values[:, 2] == pytest.approx(values[:, 3], rel=1e-12)
    coulomb = fl.linearize(fl.ModeCoupling(mu_k=0.2)).frequency_response([0.0, 0.1, 0.3]).values
    assert values[:, :2] == pytest.approx(coulomb, rel=1e-10)


def test_states_of_a_friction_law_are_states_of_the_system():
    model = fl.MassOnBelt(friction=fl.LuGre())
    system = fl.linearize(model)
    assert system.states == ("x", "x'", *model.automaton().state_names[2:])
    assert np.sort_complex(system.eigenvalues) == pytest.approx(np.sort_complex(fl.eigenvalues(model).values))
    assert system.B[1, 0] == pytest.approx(1.0 / model.m)


@pytest.mark.slow
def test_an_automaton_has_its_parameters_as_inputs():
    automaton = SLIDER.automaton()
    system = fl.linearize(automaton, ["F"], ["y1"])
    assert np.array_equal(system.B, fl.linearize(SLIDER, ["F"], ["y1"]).B)
    assert set(fl.linearize(fl.MassOnBelt().automaton()).inputs) >= {"N", "k", "mu_k"}


def test_a_response_is_taken_by_names_and_is_drawn():
    response = fl.linearize(SLIDER).frequency_response(np.linspace(5.0, 30.0, 50))
    assert response.response("y1", "x2") == pytest.approx(response.values[:, 1, 2])
    pytest.importorskip("xarray", reason="the extra data is not installed")
    assert float(response.to_xarray().gain.sel(output="y1", input="x2")[3]) == abs(response.values[3, 1, 2])
    assert response.system.plot().get_ylabel() == "gain (m/N, rad/N)"
    upper, lower = response.plot().figure.axes
    assert (upper.get_ylabel(), lower.get_xlabel()) == ("gain (m/N, rad/N)", "frequency (Hz)")
    alone = response.plot(upper, output="phi", input="phi", color="red")
    assert alone.get_ylabel() == r"gain of $\varphi$ (rad/(N m))"
    assert alone.lines[-1].get_color() == "red"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((["z1"], None), "inputs must be known, got 'z1': known are x1"),
        ((None, ["normal"]), "outputs must be known, got 'normal'"),
        ((3, None), "inputs must be a sequence"),
    ],
)
def test_unknown_names_are_refused(arguments, message):
    with pytest.raises((TypeError, ValueError), match=message):
        fl.linearize(SLIDER, *arguments)


def test_an_undamped_mode_has_no_response_at_its_frequency():
    drifting = replace(fl.linearize(fl.ModeCoupling()), A=np.eye(4, k=2))
    with pytest.raises(ValueError, match="frequencies must be others than those of undamped modes"):
        drifting.frequency_response([0.0])
