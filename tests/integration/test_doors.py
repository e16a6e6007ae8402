"""Mechanisms that are not the library's, against a reference that shares no code, and against themselves.

Many more: python -m tests.doors --count 2000 --seed 1 [--further] [--words] [--automata]
"""

from dataclasses import replace

import pytest
import sympy

import frictionlab as fl
from frictionlab.models.symbols import expand_products
from tests.doors import automata
from tests.doors.further import generate_further
from tests.doors.generate import generate
from tests.doors.judge import AGREES, compared, judge, predict, run_of
from tests.doors.metamorphic import OTHER_WORDS, applies, complaint
from tests.helpers.cases import slow_but

PERIODS = 6.0  # of slow cases; half of them shows as much at once
# Masses that depend on time (17, 24); several contacts that come to rest at one instant (25); a contact that
# turns back while another sticks, and could slip as well (112); an exponential function times 1e95 (286); a
# contact that comes to rest while another sticks, where either may go on to stick (71, 10); three contacts
# that hold a body whose mass depends on its place, of which sympy sought common factors for hours (71, 110).
CASES = [
    (1, 24, PERIODS / 2),
    *(
        pytest.param(*case, PERIODS, marks=pytest.mark.slow)
        for case in ((1, 17), (1, 25), (71, 10), (71, 110), (7001, 112), (7001, 286))
    ),
]


@pytest.mark.parametrize(("seed", "number", "periods"), CASES)
def test_a_random_mechanism_moves_as_the_reference(seed, number, periods):
    one = generate(seed, number)
    verdict = judge(one, periods * one.period)
    assert (verdict.kind, verdict.words) == (AGREES, "")
    assert verdict.events > 0 or not one.contacts


# A current and a filter on a pad (6), and between a wall and a contact that is lost (13); a temperature that
# softens friction (18); bristles (19).
@pytest.mark.parametrize(
    ("number", "periods"),
    [(19, PERIODS / 2), *(pytest.param(number, PERIODS, marks=pytest.mark.slow) for number in (6, 13, 18))],
)
def test_a_random_mechanism_with_further_states_moves_as_the_reference(number, periods):
    one = generate_further(41, number)
    verdict = judge(one, periods * one.period)
    assert (verdict.kind, verdict.words) == (AGREES, "")
    assert verdict.events > 1


@pytest.mark.slow
@pytest.mark.parametrize("words", ["other units", "split in two"])
def test_further_states_move_alike_in_other_words(words):
    assert complaint(words, 41, 18, PERIODS * generate_further(41, 18).period, generate_further) == ""


@pytest.mark.parametrize("words", slow_but(["longer"], OTHER_WORDS))
def test_the_same_mechanism_in_other_words_moves_alike(words):
    number = next(k for k in range(20, 60) if applies(words, generate(1, k)) and generate(1, k).n < 3)
    assert complaint(words, 1, number, PERIODS * generate(1, number).period) == ""


# A step and a power (5), a peak in a guard (7), waves and a run that is ten times longer (11), resets (19).
@pytest.mark.parametrize(
    ("number", "longer"),
    [(5, 1.0), *(pytest.param(*case, marks=pytest.mark.slow) for case in ((7, 1.0), (11, 10.0), (19, 1.0)))],
)
def test_a_random_automaton_moves_as_the_reference(number, longer):
    assert automata.judge(automata.generate(1, number), longer) == ""


def test_an_automaton_moves_alike_in_another_unit_and_in_two_halves():
    one, other = automata.generate(1, 3), automata.generate(1, 3, unit=1024.0)
    t_end = automata.PERIODS * one.period

    def run_of(which, t_end, x0=one.x0, mode=automata.MODES[0]):
        return fl.solve(which.automaton(), t_end, x0=x0, mode=mode, progress=False)

    whole, scaled = run_of(one, t_end), run_of(other, 1024.0 * t_end)
    assert scaled.events.t / 1024.0 == pytest.approx(whole.events.t, rel=1e-12)
    half = run_of(one, 0.37 * t_end)
    rest = run_of(one, 0.63 * t_end, half.final_state, str(half.mode[-1]))
    times = [*half.events.t, *(0.37 * t_end + rest.events.t)]
    assert times == pytest.approx(whole.events.t, rel=1e-11)


@pytest.mark.slow
def test_a_run_with_another_mass_is_seen():
    one = generate(1, 16)
    heavier = replace(one, kinetic=f"({one.kinetic})*1.00001")
    known = predict(one, PERIODS * one.period)
    run = run_of(heavier, PERIODS * one.period, t_eval=known.motion.t)
    assert compared(one, known, run, 1e-15).failed


@pytest.mark.slow
def test_a_further_state_with_another_rate_is_seen():
    one = generate_further(41, 18)
    (heat,) = one.further
    hotter = replace(one, further=(replace(heat, rate=f"({heat.rate})*1.00001"),))
    known = predict(one, PERIODS * one.period)
    run = run_of(hotter, PERIODS * one.period, t_eval=known.motion.t)
    assert compared(one, known, run, 1e-15).failed


def test_products_are_expanded_without_the_arguments_of_functions():
    v, q = sympy.symbols("v q")
    peak = sympy.exp(-(((0.2 - v) / 0.0035) ** 2))  # exp(-3265), a part of it, is zero in floats
    expanded = expand_products((1.0 + peak) * (q + 2.0))
    assert peak in expanded.atoms(sympy.exp)
    assert float(expanded.subs({v: 0.2, q: 1.0})) == 6.0
