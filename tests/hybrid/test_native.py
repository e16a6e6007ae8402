"""Native jets against the interpreter: the same to the last bit, over all laws, modes and orders."""

from concurrent.futures import wait
from itertools import combinations

import numpy as np
import pytest
import sympy as sp

import frictionlab as fl
from frictionlab.automaton import HybridAutomaton, Mode
from frictionlab.components import SlidingSeparation, StickSlip
from frictionlab.hybrid import compiled, natives
from frictionlab.hybrid.jets import mode_jets
from frictionlab.hybrid.program import program_of
from frictionlab.hybrid.tape import FUNCTIONS

pytestmark = pytest.mark.skipif(compiled.NUMBA is None, reason="needs numba")
SWITCHES = ("cubic", "nonsmooth", "geometry")
SCENES = [fl.SliderOnBelt(mu_k=1.4).without(*off) for n in range(4) for off in combinations(SWITCHES, n)]
LAWS = [
    fl.SliderOnBelt(mu_k=1.4, impact=fl.PlasticImpact("full")),
    fl.SliderOnBelt(mu_k=1.4, impact=fl.RestitutionImpact(e=0.5)),
    fl.SliderOnBelt(mu_k=2.5, k_nl=1e10, interface=SlidingSeparation()),
    fl.SliderOnBelt(mu_k=0.0, v=-1.0, interface=StickSlip()),
]


def stiffened():
    """Powers, products of many factors and quotients: every operation, with constants in all places."""
    x, y, u, a, b = sp.symbols("x y u a b")
    flow = (
        u / (1 + x**2) + a,
        x * y * u - y**5 / (2 + b * x),
        sp.Integer(0),
    )
    guard = (x + y) ** 3 - a * u / (x * y)
    return HybridAutomaton((x, y, u), (Mode("m", flow, (), (guard,)),), {a: 0.3, b: 1.7}, 0)


def functions():
    """Every function, within another, and powers with exponents of all kinds."""
    x, y, a = sp.symbols("x y a")
    inner = x * y + a
    flow = (
        sum((f(inner / 3) for f in FUNCTIONS if f is not sp.log), sp.log(2 + y**2)),
        sp.tanh(sp.exp(-(x**2))) + (1 + x**2) ** a - (2 + y**2) ** sp.Rational(-3, 2),
    )
    return HybridAutomaton((x, y), (Mode("m", flow, (), (sp.sqrt(1 + x**2) - y,)),), {a: 0.3}, 0)


AUTOMATA = [model.automaton() for model in (*SCENES, *LAWS)] + [stiffened(), functions()]


def same(automaton, mode, order, states):
    """Compare native jets with the interpreter's, in the rows that native code keeps."""
    program, numbers = program_of(automaton)
    native = natives.Natives(program, order, order + 1)
    native.compile(mode)
    assert native.code.native[mode] != 0
    rows = sorted(native._functions[mode].kept | set(range(len(automaton.states))))
    for state in states:
        jets, interpreted = (np.full((program.slots, order + 1), np.nan) for _ in range(2))
        mode_jets(native.code, numbers, mode, order, state, jets)
        mode_jets(program.code, numbers, mode, order, state, interpreted)
        np.testing.assert_array_equal(jets[rows], interpreted[rows])
        assert np.isfinite(interpreted[rows]).all()


@pytest.mark.parametrize("number", range(len(AUTOMATA)))
def test_every_mode_of_every_scene_to_the_last_bit(number):
    automaton = AUTOMATA[number]
    states = np.random.default_rng(number).normal(size=(3, len(automaton.states)))
    for mode in range(len(automaton.modes)):
        same(automaton, mode, 9, states)


@pytest.mark.parametrize("order", [0, 1, 2, 3, 5, 26, 40, 60])
def test_every_order(order):
    state = np.random.default_rng(order).normal(size=10)
    for automaton, size in ((SCENES[0].automaton(), 10), (stiffened(), 3), (functions(), 2)):
        same(automaton, 0, order, [state[:size]])


def test_a_run_may_change_over_at_any_step(monkeypatch):
    model, alone = LAWS[0], {}
    for limit in (10**9, 100, 0):
        monkeypatch.setattr(natives, "LONG", limit)
        program = program_of(model.automaton())[0]
        program.natives.clear()
        if limit == 0:
            native = natives.natives(program, 26, 27)
            for mode in range(len(native.code.native)):
                native.compile(mode)
        run = fl.simulate(model, 20.0, progress=False)
        used = program.natives[26, 27].code.native
        if limit == 100:
            wait(program.natives[26, 27]._asked.values())
            assert (used != 0).sum() >= 3  # sliding backwards is rare
        alone[limit] = run.final_state, run.events.t, used.copy()
    assert (alone[0][2] != 0).all()
    for limit in (100, 0):
        np.testing.assert_array_equal(alone[limit][0], alone[10**9][0])
        np.testing.assert_array_equal(alone[limit][1], alone[10**9][1])


def test_what_one_process_compiled_the_next_one_finds(tmp_path, monkeypatch):
    monkeypatch.setattr(compiled, "FOLDER", str(tmp_path))
    program = program_of(LAWS[1].automaton())[0]
    first = natives.Natives(program, 9, 10)
    assert not first.code.native.any()
    first.compile(1)
    assert len(list(tmp_path.glob("jets-*.o"))) == 1
    second = natives.Natives(program, 9, 10)
    assert (second.code.native != 0).tolist() == [False, True, False, False]
    assert not natives.Natives(program, 10, 11).code.native.any()


@pytest.mark.parametrize("folder", ["", "/proc/no/such/folder"])
def test_without_a_folder_it_is_compiled_in_memory(folder, monkeypatch):
    monkeypatch.setattr(compiled, "FOLDER", folder)
    native = natives.Natives(program_of(LAWS[1].automaton())[0], 4, 5)
    native.compile(0)
    assert native.code.native[0] != 0


def test_parameter_values_compile_nothing(monkeypatch):
    """All models of one structure share their program, and so its code."""
    one, other = LAWS[0], LAWS[0].replace(mu_k=0.7, k_nl=1e7, M=3.0)
    assert program_of(one.automaton())[0] is program_of(other.automaton())[0]


def test_short_runs_compile_nothing(monkeypatch, tmp_path):
    monkeypatch.setattr(compiled, "FOLDER", str(tmp_path))
    model = fl.SliderOnBelt(mu_k=1.4, interface=SlidingSeparation(), impact=fl.RestitutionImpact(e=0.9))
    fl.simulate(model, 0.5, progress=False)
    program = program_of(model.automaton())[0]
    assert all(not each._asked for each in program.natives.values())
    assert list(tmp_path.glob("jets*")) == []
