"""Every challenge is unsolved at first, has a solution, and refuses what may not be changed."""

import json

import pytest

import frictionlab as fl
from frictionlab.models.library.challenges import CHALLENGES
from tests.helpers.cases import slow_but
from tests.helpers.explorers import said

CHALLENGE = {each.name: each for each in CHALLENGES}


def beside_equilibrium(name, distance):
    state = fl.equilibrium(CHALLENGE[name].model).state.tolist()
    return {"start": "own", "own": ", ".join(str(x) for x in [state[0] + distance, *state[1:]])}


SOLUTIONS = {
    "silence": lambda: {"mu_k": 0.25},
    "the other fate": lambda: beside_equilibrium("the other fate", 0.003),
    "a knock": lambda: beside_equilibrium("a knock", 0.03),
    "squeal": lambda: {"mu_k": 2.0},
    "flutter": lambda: {"mu_k": 0.2},
    "faster": lambda: {"v": 1.5},
    "damper": lambda: {"c": 1.0},
    "a falling curve": lambda: {"mu_2": 0.5},
    "a silent curve": lambda: {"mu_0": 0.33, "mu_1": 0.33, "mu_2": 0.33},
    "grazing": lambda: {"d": 0.4},
}


def answer(explorer, name):
    """What the front end says."""
    scene, state = (json.dumps(one) for one in (explorer.widget.scene, explorer.values()))
    asked = f"({scene}).challenges.find(({{ name }}) => name === {name!r})"
    return said(explorer.widget, f"challengeAnswer({asked}, {scene}, {state}, result)")


def test_there_is_a_solution_of_each():
    assert list(SOLUTIONS) == list(CHALLENGE)


@pytest.mark.parametrize("name", slow_but(["faster", "grazing"], list(CHALLENGE)))
def test_a_challenge_is_unsolved_at_first_and_has_a_solution(name):
    explorer = fl.explore(CHALLENGE[name].model, panels=["response"])
    explorer.set_values({"start": CHALLENGE[name].start})
    assert answer(explorer, name) == {"solved": False, "text": "Not yet."}
    explorer.set_values(SOLUTIONS[name]())
    found = answer(explorer, name)
    assert found["solved"]
    assert found["text"].startswith("Solved: ")
    explorer.set_values({"duration": explorer.initial["duration"] / 2})
    assert answer(explorer, name) == {"solved": False, "text": "Set duration back to where it began."}
