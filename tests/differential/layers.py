"""How exact and how quick the solver is where friction has a layer, against the same law without one.

    python -m tests.differential.layers [--quick]

Layers are 1, 0.1, 1e-2, 1e-3, 1e-4 m/s wide.  The table gives the largest error of a state by its size, the
run time by that of Coulomb's law with the same mu_k and mu_s, and whether events and states are those of the
reference.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from time import perf_counter
from typing import Any

import numpy as np
from tqdm import tqdm

import frictionlab as fl
from tests.differential import laws
from tests.differential.case import Case
from tests.differential.judge import AGREES, compared
from tests.differential.predict import predict, sizes
from tests.differential.twin import full
from tests.reference.hybrid import Undecided

WIDTHS = (1.0, 0.1, 1e-2, 1e-3, 1e-4)
LIGHT, STEEP = {"mu_k": 0.3, "mu_s": 1.0}, {"mu_k": 1.2, "mu_s": 2.0}  # both with stick and slip in turn
SCENES = {
    "mass on belt": Case(fl.MassOnBelt(c=0.02, v=2.5, **LIGHT), (4.0, 0.0), 60.0),
    "two blocks": Case(fl.TwoBlocks(c=0.02, v=0.7, **LIGHT), (1.5, -0.5, 0.0, 0.0), 60.0),
    "slider": Case(fl.SliderOnBelt(impact=fl.PlasticImpact("full"), **STEEP), (0.0,) * 10, 0.5),
}


def curves(width: float, model: Any) -> dict[str, Any]:
    """Laws with a layer of a width, by name, with the coefficients of a model."""
    mu = {"mu_k": model.mu_k, "mu_s": model.mu_s}
    return {
        "Stribeck": fl.Stribeck(v_s=width, mu_v=0.02, **mu),
        "exponential": fl.ExponentialDecay(v_s=width, **mu),
        "tanh": laws.Smooth(v_s=width, **mu),
        "fall by tanh": laws.Edge(v_s=width, u_0=0.3, **mu),
        "sum": laws.TwoLayers(v_s=width, v_2=10 * width, **mu),
        "product": laws.Product(v_s=width, v_2=10 * width, **mu),
    }


def row(case: Case) -> tuple[str, float, float]:
    """Verdict, largest error of a predictable state by its size, seconds."""
    run = fl.simulate(case.model, case.t_end, x0=case.x0, method=case.method, progress=False)
    seconds = min(_timed(case) for _ in range(3))
    try:
        known = predict(case)
    except Undecided as reason:
        return f"undecided: {reason}", np.nan, seconds
    if not run.status.ok:
        return run.status.name.lower(), np.inf, seconds
    run = fl.simulate(case.model, case.t_end, x0=case.x0, method=case.method, t_eval=known.t, progress=False)
    verdict = compared(case, known, run)
    states = full(case.model, run.states[:, : len(case.x0)].T).T
    use = known.t <= known.horizon
    off = (np.abs(states - known.states) / sizes(known.states))[use].max()
    return "agree" if verdict.kind == AGREES else verdict.words or verdict.kind, float(off), seconds


def _timed(case: Case) -> float:
    start = perf_counter()
    fl.simulate(case.model, case.t_end, x0=case.x0, method=case.method, t_eval=[case.t_end], progress=False)
    return perf_counter() - start


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(prog="python -m tests.differential.layers", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="every other width")
    widths = WIDTHS[:: 2 if parser.parse_args().quick else 1]
    print(
        f"{'scene':13s} {'law':13s} {'v_s':>7s} {'error':>8s} {'time':>7s} {'ratio':>6s}  events and states"
    )
    for name, scene in SCENES.items():
        usual = row(scene)[2]
        cases = [
            (law, w, replace(scene, model=scene.model.replace(friction=curve)))
            for w in widths
            for law, curve in curves(w, scene.model).items()
        ]
        for law, width, case in tqdm(cases, desc=name, leave=False):
            words, off, seconds = row(case)
            numbers = f"{width:7g} {off:8.1e} {seconds * 1e3:6.1f}m {seconds / usual:6.1f}"
            tqdm.write(f"{name:13s} {law:13s} {numbers}  {words}")


if __name__ == "__main__":
    main()
