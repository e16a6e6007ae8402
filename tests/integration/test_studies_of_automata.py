"""Studies take an automaton for a model: a neuron, a thermostat, a buck converter, a ball on a table.

What they must give is closed forms and published numbers.
"""

from math import acos, log, pi, sin
from typing import Any

import numpy as np
import pytest
import sympy as sp
from scipy import stats

import frictionlab as fl
from tests.helpers.automata import V, X, thermostat

QUIET: dict[str, Any] = {"progress": False}
SETTLED: dict[str, Any] = {"transient": 1.0, "window": 1.0, **QUIET}
PERIOD = {I: 0.02 * log(I / (I - 1.0)) for I in (1.2, 1.5)}  # of spikes: tau log(I/(I - threshold))


def neuron():
    """A membrane that leaks, charged by a current; a spike at the threshold discharges it."""
    current, tau, threshold = sp.symbols("I tau threshold")
    spike = fl.Event("spike", threshold - V, ("rest",), fl.Reset({V: sp.S.Zero}))
    mode = fl.Mode("rest", ((current - V) / tau,), (spike,))
    return fl.HybridAutomaton((V,), (mode,), {current: 1.5, tau: 0.02, threshold: 1.0})


def buck_converter():
    """The converter of Hamill and Deane (1990): voltage, current, and a ramp that controls the switch."""
    voltage, current, ramp = sp.symbols("V I ramp")
    R, L, C, E, T = sp.symbols("R L C E T")
    control = 8.4 * (voltage - 11.3) - (3.8 + 4.4 * ramp)

    def mode(name, other, source, sign):
        period = fl.Event("period", 1 - ramp, (name, other), fl.Reset({ramp: sp.S.Zero}))
        flow = ((current - voltage / R) / C, (source - voltage) / L, 1 / T)
        return fl.Mode(name, flow, (fl.Event("switch", sign * control, (other,)), period))

    modes = mode("on", "off", E, -1), mode("off", "on", sp.S.Zero, 1)
    values = {R: 22.0, L: 20e-3, C: 47e-6, E: 22.0, T: 400e-6}
    return fl.HybridAutomaton((voltage, current, ramp), modes, values)


def ball_on_table():
    """A ball that bounces on a table, whose height is a sin(phase)."""
    phase, g, a, omega, e = sp.symbols("phase g a omega e")
    table, speed, lifts = a * sp.sin(phase), a * omega * sp.cos(phase), g - a * omega**2 * sp.sin(phase)
    land = fl.Event(
        "gap",
        X - table,
        ("flight", "rest"),
        fl.Reset({X: table, V: speed - e * (V - speed)}),
        accumulation=fl.Reset({X: table, V: speed}),
    )

    def mode(name, rate, *events, constraints=()):
        turn = fl.Event("period", 2 * sp.pi - phase, (name,), fl.Reset({phase: phase - 2 * sp.pi}))
        return fl.Mode(name, (V, rate, omega), (*events, turn), constraints)

    flight = mode("flight", -g, land)
    rest = mode("rest", lifts - g, fl.Event("lift", lifts, ("flight",)), constraints=(X - table, V - speed))
    return fl.HybridAutomaton((X, V, phase), (flight, rest), {g: 9.81, a: 1e-3, omega: 100.0, e: 0.5}, 1)


def spike_rate(automaton):
    return 1.0 / fl.steady_state(automaton, **SETTLED).period


def test_a_bifurcation_diagram_of_spikes_and_its_file(tmp_path):
    file = tmp_path / "spikes.jsonl"
    found = fl.bifurcation(neuron(), "I", [0.5, 1.2, 1.5], resume=file, **SETTLED)
    assert found.kinds == ("equilibrium", "periodic", "periodic")
    np.testing.assert_allclose(found.periods[1:], [*PERIOD.values()], rtol=1e-8)
    read = fl.load_bifurcation(file)
    assert read.model.values == neuron().values
    assert read.plot().get_ylabel() == "$v$ at the section"
    assert fl.bifurcation(neuron(), "I", [0.5, 1.2, 1.5], resume=file, **SETTLED).kinds == found.kinds
    with pytest.raises(ValueError, match="differs in model"):
        fl.bifurcation(neuron().replace(tau=0.03), "I", [0.5, 1.2, 1.5], resume=file, **SETTLED)


def test_sweep_ablation_and_uncertainty_of_spikes(tmp_path):
    swept = fl.sweep(neuron(), spike_rate, {"I": [1.2, 1.5]}, resume=tmp_path / "sweep.jsonl", **QUIET)
    np.testing.assert_allclose(swept.to_array(), [1.0 / period for period in PERIOD.values()], rtol=1e-8)
    ablation = fl.ablation(neuron(), spike_rate, {"tau": [0.02, 0.04]}, **QUIET)
    assert ablation.leave_one_out()["tau 0.04"] == pytest.approx(-0.5 / PERIOD[1.5], rel=1e-8)
    room, height = thermostat().replace(heat=0.5), {"heat": stats.uniform(0.5, 0.2)}
    spread = fl.uncertainty(room, fl.EquilibriumCoordinate("x"), height, n=64, **QUIET)
    assert spread.mean.value == pytest.approx(10.0 + 0.6 / 0.1, abs=4 * spread.mean.error)


def test_an_ablation_of_an_automaton_wants_alternatives():
    for switches in (None, ["cubic"], {"cubic": None}):
        with pytest.raises(ValueError, match="alternatives"):
            fl.ablation(neuron(), spike_rate, switches, **QUIET)


def test_a_fit_and_an_optimum_of_an_automaton():
    times = np.linspace(0.0, 10.0, 21)
    warm = 15.0 + 4.0 * np.exp(-0.1 * times)  # with a heater that is always on
    room = thermostat().replace(heat=0.5)
    record, guess = fl.TimeRecord(times, {"x": warm}, 1e-3), room.replace(k=0.2, heat=1.0)
    found = fl.fit(guess, record, ["k", "heat"], x0=[19.0], segments=1)
    assert [found["k"], found["heat"]] == pytest.approx([0.1, 0.5], rel=1e-9)
    best = fl.optimum(room, fl.EquilibriumCoordinate("x"), {"heat": (0.2, 0.8)})
    assert best.value == pytest.approx(12.0)


@fl.model
class Room(fl.Model):
    """The thermostat as a model, or with a velocity that has a name of its own."""

    moves: bool = False
    k: float = 0.1
    coordinates = ()

    def derive(self):
        states = (X, V) if self.moves else (X,)
        return fl.HybridAutomaton(
            states, (fl.Mode("on", (-self.k * X,) * len(states)),), {}, len(states) // 2
        )


def test_a_model_by_its_automaton_has_velocities_with_a_prime_and_pictures_of_coordinates():
    assert fl.simulate(Room(), 1.0, x0=[1.0], **QUIET).final_state[0] == pytest.approx(np.exp(-0.1))
    assert fl.explore(Room(), x0=[1.0]).run.final_state[0] < 1.0
    with pytest.raises(ValueError, match="got x, v with coordinates=1: name velocities by a prime"):
        fl.simulate(Room(moves=True), 1.0, **QUIET)


def test_near_is_close_to_the_equilibrium_of_an_automaton():
    found = fl.steady_state(neuron().replace(I=0.5), "near", transient=0.0, window=1.0, **QUIET)
    assert found.trajectory(0.0)[0] == pytest.approx(0.505)
    assert found.kind == "equilibrium"


def test_the_energy_balance_that_an_automaton_states():
    audit = fl.energy_audit(fl.solve(thermostat(), 50.0, x0=[15.0], **QUIET), **QUIET)
    assert audit.error < 1e-14
    assert set(audit.works) == {"the wall", "the heater", "resets"}
    with pytest.raises(ValueError, match="energy of the spring"):
        fl.energy_audit(fl.solve(neuron(), 0.1, x0=[0.0], **QUIET))
    off = thermostat()
    bare = fl.Mode("off", off.modes[1].flow, off.modes[1].events)
    lacking = fl.HybridAutomaton(off.states, (off.modes[0], bare), off.parameters)
    with pytest.raises(ValueError, match=r"every mode must have the same outputs, got \[\] in 'off'"):
        fl.energy_audit(fl.solve(lacking, 50.0, x0=[15.0], **QUIET))


@pytest.mark.slow  # two seconds of bounces: the closed form of the steady bounce, once a period
def test_the_ball_bounces_once_a_period_at_the_phase_of_the_closed_form():
    omega, e, g = 100.0, 0.5, 9.81
    least = pi * (1 - e) / (1 + e)  # of the relative acceleration a omega^2/g
    phase, a = acos(1 / 1.2), 1.2 * least * g / omega**2
    start = [1e-3 + a * sin(phase), g * pi / omega, phase]
    found = fl.steady_state(ball_on_table().replace(a=a), start, transient=20.0, window=5.0, **QUIET)
    assert found.kind == "periodic"
    assert found.period == pytest.approx(2 * pi / omega, rel=1e-12)
    events = found.trajectory.events
    landing = events.before[events.guard == "gap"][-1]
    assert landing[1:] == pytest.approx([-g * pi / omega, phase], rel=1e-9)


@pytest.mark.slow  # seconds of chaos
def test_the_buck_converter_doubles_its_period_where_the_literature_says():
    start = [12.0, 0.5, 0.0]
    settled = fl.steady_state(buck_converter(), start, transient=0.4, window=0.05, **QUIET)
    branch = fl.continue_orbit(fl.periodic_orbit(buck_converter(), settled), "E", (22.0, 26.0), **QUIET)
    doubling = next(point for point in branch.special if "doubling" in point.kind)
    assert doubling.value == pytest.approx(24.516, abs=1e-3)  # Fossas and Olivar 1996
    times: dict[str, Any] = {"transient": 0.3, "window": 0.05, **QUIET}
    found = fl.bifurcation(buck_converter(), "E", [22.0, 28.0, 33.0], start, **times)
    assert found.kinds == ("periodic", "periodic", "non-periodic")
    assert found.periods[:2] / 400e-6 == pytest.approx([1.0, 2.0])
    chaotic = fl.lyapunov(buck_converter().replace(E=33.0), start, transient=0.2001, t_end=0.401, **QUIET)
    assert chaotic.chaotic
