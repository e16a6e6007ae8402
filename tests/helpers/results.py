"""One small result of every class that a function of the package returns, each computed once in a process."""

from functools import cache

import numpy as np
from scipy import stats

import frictionlab as fl

from .known_motions import logistic

QUIET = {"progress": False}
COUPLED = fl.ModeCoupling(c=0.1)
BELT = fl.MassOnBelt()
STICK_SLIP = fl.MassOnBelt(c=0.05, mu_k=0.5, mu_s=1.0)
RESTING = fl.ModeCoupling(c=0.5)
SLIDER = fl.SliderOnBelt()
TURNING = SLIDER.automaton().states[5]  # the rate of x1
DISTRIBUTIONS = {"F": stats.uniform(150.0, 100.0), "mu_k": stats.norm(1.5, 0.1)}
STARTS = ("x", [0.0, 0.5, 1.0]), ("x'", [0.0, 0.1])


def preload(model):
    return model.F


def preload_from(model, x0):
    return model.F


def short_motion(model):
    return fl.steady_state(model, transient=5.0, window=2.0, **QUIET)


def short_bifurcation(model):
    return fl.bifurcation(model, "mu_k", [0.2, 0.3, 0.9], transient=5.0, window=5.0, **QUIET)


def steady_state():
    found = fl.steady_state(STICK_SLIP, transient=50.0, window=20.0, **QUIET)
    assert found.kind == "periodic"
    return found


def orbit():
    return fl.periodic_orbit(STICK_SLIP, result("steady state"))


def branch_with_special_point():
    speed = 1 - 1 / 2.5
    doubling = fl.periodic_orbit(logistic(2.5), [speed**2 / 2, 0.0], period=2 * speed)
    return fl.continue_orbit(doubling, "a", (2.5, 3.1), **QUIET)


def run():
    return fl.simulate(SLIDER.replace(mu_k=1.4), 0.15, sections={"turns": (TURNING, -1)}, **QUIET)


def run_of_two_contacts():
    return fl.simulate(fl.TwoBlocks(), 20.0, **QUIET)


def fit():
    t = np.linspace(0.1, 10.0, 40)
    positions = fl.simulate(STICK_SLIP, 10.0, **QUIET)(t)[:, 0]
    record = fl.TimeRecord(t, {"x": positions + 1e-3 * np.sin(37.0 * t)}, error=1e-3)
    return fl.fit(STICK_SLIP, record, ["k"], segments=1)


def optimum():
    return fl.optimum(SLIDER, fl.GrowthRate(), {"c1": (0.1, 5.0), "c2": (0.1, 5.0)})


def basins():
    return fl.basins(STICK_SLIP, *STARTS, transient=50.0, window=20.0, **QUIET)


def basin_stability():
    ranges = {"x": (0.0, 1.0), "x'": (0.0, 0.1)}
    return fl.basin_stability(STICK_SLIP, ranges, 6, transient=50.0, window=20.0, **QUIET)


STRUCTURE = fl.Structure(
    [[1.0, 0.0], [0.0, 1.0]],
    [[2.0, 0.0], [0.0, 1.0]],
    circulatory=[("mu", [[0.0, 1.0], [-1.0, 0.0]])],
    parameters={"mu": 0.6},
)


PRESSED = fl.Structure(
    [[1.0, 0.0], [0.0, 1.0]],
    [[100.0, 0.0], [0.0, 200.0]],
    load=[0.0, 1.0],
    contacts=(
        fl.SlidingContacts(
            tangential=[[1.0, 0.0]],
            normal=[[0.0, 1.0]],
            contact=fl.LinearContact(k2=500.0),
            friction=fl.Coulomb(mu_k=0.3, mu_s=0.5),
            v=1.0,
        ),
    ),
)

BUILDERS = {
    "run": run,
    "run of two contacts": run_of_two_contacts,
    "sweep": lambda: fl.sweep(SLIDER, preload, {"F": [100.0, 200.0]}, **QUIET),
    "plane": lambda: fl.sweep(SLIDER, preload, {"F": [100.0, 200.0, 300.0], "mu_k": [0.1, 0.2]}, **QUIET),
    "from two states": lambda: fl.sweep(
        SLIDER, preload_from, {"F": [100.0, 200.0]}, x0=["rest", "near"], **QUIET
    ),
    "sensitivity": lambda: fl.sensitivity(SLIDER, fl.GrowthRate()),
    "uncertainty": lambda: fl.uncertainty(SLIDER, fl.GrowthRate(), DISTRIBUTIONS, n=16, **QUIET),
    "fit": fit,
    "optimum": optimum,
    "Sobol indices": lambda: fl.sobol_indices(SLIDER, fl.GrowthRate(), DISTRIBUTIONS, n=16, **QUIET),
    "effects": lambda: result("ablation").effects(),
    "ablation over a parameter": lambda: fl.ablation(SLIDER, lambda m: m.F, over={"F": [1.0, 2.0]}, **QUIET),
    "ablation": lambda: fl.ablation(SLIDER, lambda m: m.k1, **QUIET),
    "ablation of motions": lambda: fl.ablation(COUPLED, short_motion, **QUIET),
    "ablation of bifurcations": lambda: fl.ablation(STICK_SLIP, short_bifurcation, **QUIET),
    "locus": lambda: fl.root_locus(SLIDER, "mu_k", [0.5, 1.0, 1.5, 2.0]),
    "eigenvalues": lambda: fl.eigenvalues(SLIDER.replace(mu_k=2.0)),
    "eigenvalues of a structure": lambda: fl.eigenvalues(STRUCTURE),
    "reduced structure": lambda: fl.reduce(STRUCTURE.replace(window=(0.0, 1.0))),
    "linear system": lambda: fl.linearize(SLIDER),
    "frequency response": lambda: result("linear system").frequency_response([5.0, 10.0, 15.0, 20.0]),
    "stability change": lambda: fl.stability_changes(SLIDER, "mu_k", (0, 3))[0],
    "curve": lambda: fl.critical_curve(SLIDER, "mu_k", (0, 3), over=("F", [200.0, 400.0])),
    "map": lambda: fl.stability_map(COUPLED, ("k3", [0.8, 1.3, 2.0]), ("mu_k", [0.1, 1.0])),
    "boundary": lambda: result("map").boundary[0],
    "ends": lambda: fl.ensemble([SLIDER.replace(mu_k=mu) for mu in (0.1, 0.2)], 0.05, **QUIET),
    "steady state": steady_state,
    "equilibrium as steady state": lambda: fl.steady_state(
        RESTING, "near", transient=50.0, window=5.0, **QUIET
    ),
    "bifurcation": lambda: fl.bifurcation(
        STICK_SLIP, "v", [0.2, 0.3, 0.5, 2.5], transient=50.0, window=40.0, **QUIET
    ),
    "CEA and motions": lambda: fl.cea_against_motion(
        fl.ModeCoupling(c=0.1), "mu_k", [0.1, 1.0], f_max=0.5, **QUIET
    ),
    "orbit": orbit,
    "branch": lambda: fl.continue_orbit(result("orbit"), "v", (0.1, 0.4), max_points=4, **QUIET),
    "branch with a special point": branch_with_special_point,
    "special orbit": lambda: result("branch with a special point").special[0],
    "exponents": lambda: fl.lyapunov(COUPLED, transient=1.0, t_end=2.0, blocks=2, **QUIET),
    "energies": lambda: fl.energy_audit(result("run"), **QUIET),
    "equilibrium": lambda: fl.equilibrium(SLIDER),
    "equilibrium of a structure": lambda: fl.equilibrium(PRESSED),
    "equilibrium of an automaton": lambda: fl.equilibrium(SLIDER.without("cubic", "geometry").automaton()),
    "Hopf point": lambda: fl.hopf(SLIDER, "mu_k", (0, 4)),
    "tangent flow": lambda: fl.tangent_flow(fl.simulate(COUPLED, 0.5, x0="near", **QUIET), **QUIET),
    "verification": lambda: fl.verify(BELT, 2.0, **QUIET),
    "spectrum": lambda: fl.amplitude_spectrum(fl.simulate(COUPLED, 20 * COUPLED.period, **QUIET)),
    "basins": basins,
    "shares of basins": basin_stability,
    "attractor": lambda: result("basins").attractors[0],
    "events": lambda: result("run").events,
    "section points": lambda: result("run").sections["turns"],
}


@cache
def result(name):
    """The result of that name in `BUILDERS`."""
    return BUILDERS[name]()
