"""Sections: expressions, directions, and crossings that are searched against those that are recorded."""

import numpy as np
import pytest

import frictionlab as fl
from frictionlab.analysis.steady_state.poincare_sections import (
    section_crossings,
    section_function,
    stick_onsets,
    turning_section,
)
from tests.helpers.automata import oscillator

MODEL = fl.SliderOnBelt(mu_k=1.4).without("geometry")
AUTOMATON = MODEL.automaton()


@pytest.mark.parametrize("direction", [-1, 0, 1])
@pytest.mark.parametrize("text", ["x1'", "x1 - x2", "penetration"])
def test_searched_crossings_are_those_recorded(text, direction):
    section = (text, direction)
    run = fl.simulate(MODEL, 3.0, sections=section_function(AUTOMATON, section), progress=False)
    recorded = section_crossings(run, section)
    assert len(recorded.t) > 20
    # The same run without its record: the crossings between its samples.
    plain = fl.simulate(MODEL, 3.0, progress=False)
    searched = section_crossings(plain, section)
    assert np.allclose(searched.t, recorded.t, atol=1e-11)
    assert np.allclose(searched.state, recorded.state, atol=1e-7)


@pytest.mark.parametrize("section", [("x1'", -1), ("x1 - x2", 0), ("penetration", -1)])
def test_the_papers_algorithm_crosses_where_the_exact_solver_does(section):
    exact = fl.simulate(MODEL, 1.5, sections=section_function(AUTOMATON, section), progress=False)
    stepped = fl.simulate(MODEL, 1.5, method=fl.RK4(step=1e-4), progress=False)
    expected, found = section_crossings(exact, section), section_crossings(stepped, section)
    assert len(found.t) == len(expected.t)
    assert np.allclose(found.t, expected.t, atol=5e-5)


def test_crossings_of_a_sine():
    run = fl.solve(oscillator(), 20.0, x0=[0.0, 1.0], method=fl.RK4(step=1e-3), progress=False)
    for direction, first in (1, 2 * np.pi), (-1, np.pi), (0, np.pi):
        found = section_crossings(run, ("x", direction))
        expected = np.arange(first, 20.0, 2 * np.pi if direction else np.pi)
        assert np.allclose(found.t, expected, atol=1e-9)
        assert np.allclose(found.state[:, 0], 0.0, atol=1e-11)
    assert len(section_crossings(run, ("x - 2", 0)).t) == 0


def test_onsets_of_stick_come_from_slip():
    run = fl.simulate(MODEL, 5.0, progress=False)
    chosen = stick_onsets(run)
    assert set(run.events.target[chosen]) == {"stick"}
    assert set(run.events.source[chosen]) <= {"slip+", "slip-"}
    assert np.array_equal(section_crossings(run, "stick").t, run.events.t[chosen])
    assert turning_section(AUTOMATON) == ("x1'", -1)
