"""The kernels as ordinary Python: the same results where numba is not installed."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

import frictionlab as fl
from tests.helpers.assertions import assert_same_times

pytestmark = pytest.mark.plain_python

ROOT = Path(__file__).parents[2]
SCENES = json.loads((ROOT / "tests" / "reference" / "first_events.json").read_text(encoding="utf-8"))[
    "scenes"
]
MODELS = {
    "A": fl.SliderOnBelt(mu_k=1.4).without("geometry"),
    "B": fl.SliderOnBelt(mu_k=1.4, impact=fl.PlasticImpact("full")),
}


@pytest.mark.parametrize("scene", ["A", "B"])
def test_the_first_events_are_those_of_the_reference(scene):
    expected = [event for event in SCENES[scene]["events"] if float(event[0]) < 0.1]
    run = fl.simulate(MODELS[scene], 0.1)
    assert len(run.events) == len(expected) >= 4
    assert run.events.t == pytest.approx([float(t) for t, _, _ in expected], abs=1e-11, rel=0)
    assert run.events.target.tolist() == [target for _, _, target in expected]


def test_a_bouncing_ball_accumulates():
    x, v = sp.symbols("x v")
    bounce, lie = fl.Reset({x: sp.S.Zero, v: -v / 2}), fl.Reset({x: sp.S.Zero, v: sp.S.Zero}, {x: 2})
    flight = fl.Mode("flight", (v, -sp.Float(9.81)), (fl.Event("floor", x, (), bounce, lie),))
    rest = fl.Mode("rest", (v, sp.S.Zero), (), (x, v))
    run = fl.solve(fl.HybridAutomaton((x, v), (flight, rest), {}, 1), 2.0, x0=[1.0, 0.0])
    assert run.events.t[-1] == pytest.approx(1.354570922957, abs=1e-11)
    assert run.mode[-1] == "rest"


def test_rk4_takes_a_few_steps():
    run = fl.simulate(MODELS["A"], 0.02, method=fl.RK4(step=1e-3))
    exact = fl.simulate(MODELS["A"], 0.02)
    assert run.events.target.tolist() == ["stick"]
    assert run.final_state == pytest.approx(exact.final_state, abs=1e-5)


PROGRAM = """
import json
import frictionlab as fl
from frictionlab.compilation import machine_code
run = fl.simulate(fl.SliderOnBelt(mu_k=1.4, impact=fl.PlasticImpact("full")), 0.1)
print(json.dumps([machine_code.NUMBA is None, run.final_state.tolist(), run.events.t.tolist()]))
"""


def test_without_numba_the_result_is_the_same():
    environment = {**os.environ, "FRICTIONLAB_DISABLE_NUMBA": "1", "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM], env=environment, capture_output=True, text=True, check=True
    )
    plain, state, times = json.loads(done.stdout)
    run = fl.simulate(MODELS["B"], 0.1)
    assert plain
    assert np.array(state) == pytest.approx(run.final_state, abs=1e-12)
    assert_same_times(times, run.events.t, abs=1e-13)
