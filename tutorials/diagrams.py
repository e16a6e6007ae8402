"""The dense diagrams of the course, computed once and kept in the folder `diagrams` beside this file.

    python diagrams.py                      computes all of them (four minutes on one processor)
    python diagrams.py slider-from-rest     computes that one

Notebooks draw what is kept.  Bifurcation diagrams have 300 values, basins 100 x 100 initial states.  The
files hold what a picture needs: nine digits, and a few section points of each steady state.
"""

import sys
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import frictionlab as fl

FOLDER = Path(__file__).parent / "diagrams"
DIGITS, STATE_DIGITS = 9, 6  # of numbers, and of the many states that are only drawn
POINTS = 24  # the most section points kept of one steady state
INTENSITY_ONLY = "all-three", "sliding-only"  # of which none are drawn
PATH_STEP = 4  # one of so many points of an attractor's path is kept

FRICTION = np.round(np.arange(300) * 0.01, 10)  # mu_k
PUSH_FRICTION = np.round(np.linspace(0.1, 2.08, 100), 10)
PERCENT = np.geomspace(1, 100, 100)  # off the equilibrium
FLAT = fl.SliderOnBelt(mu_k=1.4).without("geometry")
BELT = fl.SliderOnBelt(mu_k=1.4, impact=fl.PlasticImpact("full"))
STIFF = fl.SliderOnBelt(F=800.0, k_nl=1e7, k4=5e6, k5=5e6, k6=5e6, impact=fl.PlasticImpact("full"))
SETTLE = {"transient": 150.0, "window": 50.0, "section": "stick"}
CHAOS = {"transient": 60.0, "window": 20.0}
ONSET = {"transient": 60.0, "window": 10.0, "t_max": 250.0}
SMOOTH = {"transient": 300.0, "window": 50.0}


def falling_friction() -> fl.HybridAutomaton:
    """The mass on a belt of notebooks 8 and 9, whose friction falls with speed."""
    import sympy as sp

    x, v = sp.symbols("x v")
    damper, belt, drop, mu = sp.symbols("damper belt drop mu")
    v_r = belt - v
    rate = mu + drop / (1 + v_r) - x - damper * v
    pulled = fl.Event("pulled", mu + drop - x - damper * v, ("slip",))
    caught = fl.Event("caught", v_r, ("stick",), fl.Reset({v: belt}))
    modes = fl.Mode("stick", (v, sp.S.Zero), (pulled,), (v_r,)), fl.Mode("slip", (v, rate), (caught,))
    return fl.HybridAutomaton((x, v), modes, {damper: 0.1, belt: 1.35, drop: 0.5, mu: 0.5}, coordinates=1)


MASS_PLANE = {"x": ("x", np.linspace(-1, 2.5, 100)), "y": ("v", np.linspace(-1.5, 1.3, 100))}
KNOCKS = {"x": ("x1'", np.linspace(-0.6, 0.6, 100)), "y": ("y1'", np.linspace(-0.6, 0.6, 100))}


def push_fates(mu_k: float, percentages: np.ndarray) -> list[bool]:
    """Whether the slider still sticks after 40 s, for starts so many percent off the equilibrium, at rest."""
    model = FLAT.replace(mu_k=float(mu_k))
    q = fl.equilibrium(model).q
    starts = [np.append((1 - p / 100) * q, 0 * q) for p in percentages]
    runs = [fl.simulate(model, 40.0, x0=start, progress=False) for start in starts]
    return [bool((run.events.t > 39).any()) for run in runs]


# Each by the name of its file: what computes it.
DIAGRAMS = {
    "slider-from-rest": partial(fl.bifurcation, FLAT, "mu_k", FRICTION, "rest", **SETTLE),
    "slider-from-near": partial(fl.bifurcation, FLAT, "mu_k", FRICTION, "near", **SETTLE),
    "belt-from-rest": partial(fl.bifurcation, BELT, "mu_k", FRICTION, "rest", **SETTLE),
    "belt-from-near": partial(fl.bifurcation, BELT, "mu_k", FRICTION, "near", **SETTLE),
    "stiff": partial(
        fl.bifurcation, STIFF.without("geometry"), "mu_k", FRICTION, transient=60.0, window=20.0
    ),
    "all-three": partial(fl.bifurcation, STIFF, "mu_k", FRICTION, **ONSET),
    "sliding-only": partial(fl.bifurcation, STIFF.without("nonsmooth"), "mu_k", FRICTION, **SMOOTH),
    "mass-plane": partial(
        fl.basins, falling_friction(), **MASS_PLANE, transient=2500.0, window=200.0, rtol=1e-2
    ),
    "slider-knocks": partial(fl.basins, FLAT, **KNOCKS, x0="near", transient=150.0, window=20.0),
}
PUSHES = "slider-pushes"


def kept(name: str) -> Path:
    """The file of a diagram."""
    return FOLDER / (f"{name}.npz" if name == PUSHES else f"{name}.jsonl")


def compute(name: str) -> None:
    """Compute a diagram and keep it."""
    FOLDER.mkdir(exist_ok=True)
    if name == PUSHES:
        fates = np.array([push_fates(mu_k, PERCENT) for mu_k in PUSH_FRICTION])
        np.savez_compressed(kept(name), mu_k=PUSH_FRICTION, percent=PERCENT, sticks=fates)
    else:
        found = DIAGRAMS[name]()
        points = 0 if name in INTENSITY_ONLY else POINTS
        replace(found, results={i: thinned(row, points) for i, row in found.results.items()}).save(kept(name))
    print(f"{kept(name)}: {kept(name).stat().st_size / 1000:.0f} kB")


def thinned(row: dict, points: int) -> dict:
    """What a picture needs of a result: of section points one period, or so many."""
    row = {name: rounded(value, DIGITS) for name, value in row.items()}
    if "section" in row:
        last = min(row["onsets"] or points, points)
        row["section"] = rounded(row["section"][len(row["section"]) - last :], STATE_DIGITS)
    if "path" in row:
        row["path"] = rounded(row["path"][::PATH_STEP], STATE_DIGITS)
    return row


def rounded(value: Any, digits: int) -> Any:
    """Numbers with so many digits, in lists and mappings too."""
    if isinstance(value, dict):
        return {name: rounded(each, digits) for name, each in value.items()}
    if isinstance(value, list):
        return [rounded(each, digits) for each in value]
    return float(f"{value:.{digits}g}") if isinstance(value, float) else value


if __name__ == "__main__":
    for chosen in sys.argv[1:] or [*DIAGRAMS, PUSHES]:
        compute(chosen)
