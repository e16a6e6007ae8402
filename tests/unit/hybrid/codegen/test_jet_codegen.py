"""Native jets against the interpreter: the same to the last bit, over all laws, modes and orders."""

import re
from concurrent.futures import wait
from itertools import combinations

import numpy as np
import pytest
import sympy as sp

import frictionlab as fl
from frictionlab.automaton import HybridAutomaton, Mode
from frictionlab.compilation import machine_code
from frictionlab.components import SlidingSeparation, StickSlip
from frictionlab.hybrid.codegen import native_cache
from frictionlab.hybrid.codegen.jet_codegen import KERNELS, jets_module
from frictionlab.hybrid.codegen.side_by_side import states_side_by_side, sums_side_by_side
from frictionlab.hybrid.kernels.jets import (
    JET_COLUMNS,
    LOG2_LEAST_RATIO,
    MAX_ORDER,
    has_native_jets,
    has_series,
    mode_jets,
)
from frictionlab.hybrid.kernels.run_state import jet_columns
from frictionlab.tape.functions import AFFINE, FUNCTIONS
from frictionlab.tape.packing import program_of
from frictionlab.tape.program import program_from_data, program_to_data
from frictionlab.tape.tape import Tape
from tests.helpers.cases import slow_but

pytestmark = pytest.mark.skipif(not machine_code.HAS_MACHINE_CODE, reason="needs numba")
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
    inner, every = x * y + a, [function.expression for function in FUNCTIONS]
    flow = (
        sum((f(inner / 3) for f in every if f is not sp.log), sp.log(2 + y**2)),
        sp.tanh(sp.exp(-(x**2))) + (1 + x**2) ** a - (2 + y**2) ** sp.Rational(-3, 2),
    )
    return HybridAutomaton((x, y), (Mode("m", flow, (), (sp.sqrt(1 + x**2) - y,)),), {a: 0.3}, 0)


def coupled():
    """Derivatives that are sums of much the same terms: four, then two, as vectors, and one alone."""
    x, v, k, (u, w, d) = sp.symbols("x:4"), sp.symbols("v:4"), sp.symbols("k:4"), sp.symbols("u w d")
    force = x[0] ** 2 * x[1]
    pulls = [sum(k[(i + j) % 4] * x[j] for j in range(4)) - d * v[i] + (i + 2) * force for i in range(4)]
    pair = x[2] + d * u * w - k[1] * u + v[0], x[2] - d * u * w + k[2] * w + v[0]
    flow = (*v, *pulls, *pair)
    values = dict(zip((*k, d), (0.3, 1.7, -0.9, 1.1, 0.2), strict=True))
    return HybridAutomaton((*x, *v, u, w), (Mode("m", flow, (), (sum(x) - 3,)),), values, 4)


AUTOMATA = [*(model.automaton for model in (*SCENES, *LAWS)), stiffened, functions, coupled]


def with_code(automaton, mode, native=None):
    """A program's native code, that of a mode at hand."""
    native = native or native_cache.NativeCode(program_of(automaton)[0])
    native.compile(mode)
    assert native.code.native[mode] != 0
    return native


def same(automaton, native, mode, order, states):
    """Compare native jets with the interpreter's, in the rows that native code keeps."""
    program, numbers = program_of(automaton)
    flow, kept = native.tapes[mode].flow, native.tapes[mode].kept
    rows = sorted(kept | set(range(len(automaton.states))))
    for state in states:
        jets, interpreted = (np.full((program.slots, jet_columns(order)), np.nan) for _ in range(2))
        mode_jets(native.code, numbers, mode, order, state, jets)
        mode_jets(program.code, numbers, mode, order, state, interpreted)
        np.testing.assert_array_equal(jets[rows], interpreted[rows])  # beyond the order both are not written
        np.testing.assert_array_equal(jets[flow, 0], interpreted[flow, 0])
        assert np.isfinite(interpreted[rows, : order + 1]).all()


@pytest.mark.parametrize("number", slow_but([13, 14], range(len(AUTOMATA))))
def test_every_mode_of_every_scene_to_the_last_bit(number):
    automaton = AUTOMATA[number]()
    states = np.random.default_rng(number).normal(size=(3, len(automaton.states)))
    native = native_cache.NativeCode(program_of(automaton)[0])
    for mode in range(len(automaton.modes)):
        same(automaton, with_code(automaton, mode, native), mode, 15, states)


@pytest.mark.slow
@pytest.mark.parametrize("make", [AUTOMATA[0], *AUTOMATA[-3:]])
def test_one_code_serves_every_order(make):
    automaton = make()
    native = with_code(automaton, 0)
    address = native.code.native[0]
    for order in (0, 1, 2, 3, 8, 19, 40, MAX_ORDER):
        state = np.random.default_rng(order).normal(size=len(automaton.states))
        same(automaton, native, 0, order, [state])
    assert native.code.native[0] == address


def test_sums_of_much_the_same_slots_are_one_vector_unless_one_is_needed_before_the_last():
    tape, same, other = Tape(5), (0, 1, 2, 3), (0, 1, 2, 4)
    for slots in (same, (0, 1, 2, 5), same, same, same, other, (0, 1, 4), other, other):
        first = len(tape.terms)
        tape.terms += [(slot, sp.S.One) for slot in slots]
        tape.emit(AFFINE, first, len(tape.terms), sp.S.Zero)
    # Slot 6 needs slot 5, slot 11 has another number of terms, and slot 12 is a derivative.
    assert sums_side_by_side(tape, [6, 7, 8, 9, 12]) == [(6, 7, 8, 9), (10, 13)]
    assert states_side_by_side([2, 3, 6, 7, 1], [(6, 7)]) == [(2, 3), (0, 1), (4,)]
    function = native_cache.NativeCode(program_of(coupled())[0]).tapes[0]
    assert sorted(map(len, sums_side_by_side(function.tape, function.flow))) == [2, 4]


def test_whether_a_power_has_a_series_depends_on_the_order():
    """Of x^a at x = s, x' = -1, there is one where s > 2^(-963/order), to the last bit of that."""
    x, a = sp.symbols("x a")
    automaton = HybridAutomaton((x,), (Mode("m", (x**a - 1,), (), (x**a,)),), {a: 1.5}, 0)
    program, numbers = program_of(automaton)
    native, guard = with_code(automaton, 0), program.code.function_slots[0]
    for order in range(4, MAX_ORDER + 1):
        first = 2.0 ** (LOG2_LEAST_RATIO / order)
        for start in (first * (1 - 2e-6), first, first * (1 + 2e-6)):
            jets, interpreted = np.zeros((2, program.slots, JET_COLUMNS))
            mode_jets(native.code, numbers, 0, order, np.array([start]), jets)
            mode_jets(program.code, numbers, 0, order, np.array([start]), interpreted)
            np.testing.assert_array_equal(jets[[0, guard]], interpreted[[0, guard]])
            assert (interpreted[guard, 2] != 0) == has_series(interpreted, 0, 2, order)
            assert has_series(interpreted, 0, 2, order) == (start > first) or start == first


def test_whether_a_power_has_a_series_depends_on_the_curvature_of_its_base():
    """Of (e + x^2)^a at x = 0, x' = 1, there is one where e > 2^(-2 963/order)."""
    x, a, e = sp.symbols("x a e")
    mode = Mode("m", (sp.S.One,), (), ((e + x**2) ** a,))
    automaton = HybridAutomaton((x,), (mode,), {a: 1.5, e: 1.0}, 0)
    native = with_code(automaton, 0)
    for order in (4, 11, 26, 32, MAX_ORDER):
        for share in (1 - 4e-6, 1 + 4e-6):
            changed = automaton.replace(e=share * 4.0 ** (LOG2_LEAST_RATIO / order))
            program, values = program_of(changed)
            guard = program.code.function_slots[0]
            jets, interpreted = np.full((2, program.slots, JET_COLUMNS), np.nan)
            mode_jets(native.code, values, 0, order, np.zeros(1), jets)
            mode_jets(program.code, values, 0, order, np.zeros(1), interpreted)
            np.testing.assert_array_equal(jets[guard, : order + 1], interpreted[guard, : order + 1])
            assert (interpreted[guard, 2] != 0) == (share > 1)


HELD = [SCENES[0].automaton(), stiffened(), functions()]


@pytest.mark.parametrize("automaton", slow_but(HELD[1:2], HELD))
def test_code_holds_nothing_that_differs_between_machines(automaton):
    """No multiply-add that is rounded once, no library; only the package's own kernels are called."""
    native = native_cache.NativeCode(program_of(automaton)[0])
    text = str(jets_module(native.tapes[0], "jets"))
    declared = set(re.findall(r'declare \S+ @"?([\w.]+)', text))
    assert "fmuladd" not in text
    assert "contract" not in text
    assert declared <= {*KERNELS, "llvm.fabs.f64"}


def test_orders_beyond_the_highest_are_interpreted():
    """No order above may be asked for, but a tolerance far below rounding leads to one."""
    model, method = LAWS[0], fl.Taylor(tol=1e-40)
    assert method.degree > MAX_ORDER
    native = with_code(model.automaton(), 0)
    jets = np.zeros((program_of(model.automaton())[0].slots, jet_columns(method.degree)))
    assert not has_native_jets(native.code, 0, jets)
    ends = fl.ensemble([model] * 3, 0.05, method=method, progress=False)
    run = fl.simulate(model, 0.05, method=method, progress=False)
    np.testing.assert_array_equal(ends.states, [run.final_state] * 3)


def test_a_run_may_change_over_at_any_step(monkeypatch):
    model, alone = LAWS[0], {}
    for limit in (10**9, 100, 0):
        monkeypatch.setattr(native_cache, "COMPILE_AFTER", limit)
        program = program_of(model.automaton())[0]
        native = native_cache.native_code(program)
        native.forget()
        if limit == 0:
            for mode in range(len(native.code.native)):
                native.compile(mode)
        run = fl.simulate(model, 10.0, progress=False)
        used = native.code.native
        if limit == 100:
            wait(native.requested.values())
            assert (used != 0).sum() >= 3  # sliding backwards is rare
        alone[limit] = run.final_state, run.events.t, used.copy()
    assert (alone[0][2] != 0).all()
    for limit in (100, 0):
        np.testing.assert_array_equal(alone[limit][0], alone[10**9][0])
        np.testing.assert_array_equal(alone[limit][1], alone[10**9][1])


def test_what_one_process_compiled_the_next_one_finds(tmp_path, monkeypatch):
    monkeypatch.setattr(machine_code, "CACHE_FOLDER", str(tmp_path))
    program = program_of(LAWS[1].automaton())[0]
    first = native_cache.NativeCode(program)
    assert not first.code.native.any()
    first.compile(1)
    assert len(list(tmp_path.glob("jets-*.o"))) == 1
    second = native_cache.NativeCode(program)
    assert (second.code.native != 0).tolist() == [False, True, False, False]


@pytest.mark.slow
def test_another_order_or_method_compiles_nothing(tmp_path, monkeypatch):
    """One that comes later finds the code there is, in this process and in the next."""
    monkeypatch.setattr(machine_code, "CACHE_FOLDER", str(tmp_path))
    monkeypatch.setattr(native_cache, "COMPILE_AFTER", 0)
    model = fl.SliderOnBelt(mu_k=1.4, impact=fl.RestitutionImpact(e=0.25))
    program = program_of(model.automaton())[0]
    native = native_cache.native_code(program)
    native.forget()
    for mode in range(len(program.modes)):
        native.compile(mode)
        native.compile_step(mode)
    kept, addresses = set(tmp_path.iterdir()), native.code.native.copy()
    methods = [*(fl.Taylor(order=order) for order in (4, 11, 26, 33, 60)), fl.RK4(), fl.Scipy()]
    for method in methods:
        fl.simulate(model, 0.3, method=method, progress=False)
    for method in methods[:5]:
        fl.ensemble([model] * 4, 0.3, method=method, progress=False)
    assert native_cache.native_code(program) is native
    assert not native.requested
    np.testing.assert_array_equal(native.code.native, addresses)
    assert set(tmp_path.iterdir()) == kept
    assert native_cache.NativeCode(program).code.native.all()
    assert set(tmp_path.iterdir()) == kept


@pytest.mark.parametrize("folder", ["", "/proc/no/such/folder"])
def test_without_a_folder_it_is_compiled_in_memory(folder, monkeypatch):
    monkeypatch.setattr(machine_code, "CACHE_FOLDER", folder)
    with_code(LAWS[1].automaton(), 0)


def test_parameter_values_compile_nothing(monkeypatch):
    """All models of one structure share their program, and so its code."""
    one, other = LAWS[0], LAWS[0].replace(mu_k=0.7, k_nl=1e7, M=3.0)
    assert program_of(one.automaton())[0] is program_of(other.automaton())[0]


def test_a_factor_of_one_in_the_equations_is_no_parameter_that_is_one(tmp_path, monkeypatch):
    monkeypatch.setattr(machine_code, "CACHE_FOLDER", str(tmp_path))
    x, y, a = sp.symbols("x y a")
    for factor in (1, -1, a):
        automaton = HybridAutomaton((x, y), (Mode("m", (y, x * y + factor * x), ()),), {a: 2.0}, 0)
        same(automaton, with_code(automaton, 0), 0, 9, [np.array([0.3, -0.7])])
        kept = program_from_data(program_to_data(program_of(automaton)[0]), str)
        assert native_cache.NativeCode(kept).code.native.all()  # the code of the one that was derived
    assert len(list(tmp_path.glob("jets-*.o"))) == 3


def test_short_runs_compile_nothing(monkeypatch, tmp_path):
    monkeypatch.setattr(machine_code, "CACHE_FOLDER", str(tmp_path))
    model = fl.SliderOnBelt(mu_k=1.4, interface=SlidingSeparation(), impact=fl.RestitutionImpact(e=0.9))
    fl.simulate(model, 0.5, progress=False)
    program = program_of(model.automaton())[0]
    assert not native_cache.native_code(program).requested
    assert list(tmp_path.glob("jets*")) == []
