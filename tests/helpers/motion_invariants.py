"""How far a run of a slider breaks the laws of contact and friction, and how far it may."""

import numpy as np

SIGNS = {"slip+": 1.0, "slip-": -1.0}


def unilateral(model):
    return "separation" in model.interface.modes


def violations(model, run):
    """Name -> worst violation relative to its scale, on a dense grid and just after every event."""
    t = np.unique(np.concatenate([np.linspace(0.0, run.t[-1], 400), run.t, run.events.t]))
    mode = run.modes_at(t)
    z = run(t)
    names = list(run.names)
    out = {
        name: run.output(name, t)
        for name in ("penetration", "normal_force", "friction_force", "relative_velocity")
    }
    gap, F_N, F_T, v_r = out.values()
    assert all(np.isfinite(values).all() for values in (z, *out.values()))
    length = 1e-6 + np.abs(z[:, : len(model.coordinates)]).max()
    speed = (
        np.abs(z[:, names.index("x1'")]).max() + np.abs(z[:, names.index("x2'")]).max() + abs(model.v) + 1e-6
    )
    force = 1e-3 + np.abs(F_N).max() + model.F + np.abs(F_T).max()
    contact, stick = mode != "separation", mode == "stick"
    worst = {
        "stick: v_r": (np.abs(v_r[stick]) / speed).max(initial=0.0),
        "stick: cone": ((np.abs(F_T) - model.mu_s * F_N)[stick] / force).max(initial=0.0),
        "flight: gap": (gap[~contact] / length).max(initial=0.0),
        "flight: force": np.abs(F_N[~contact]).max(initial=0.0),
        "contact: F_N": (-F_N[contact] / force).max(initial=0.0) if unilateral(model) else 0.0,
        "contact: gap": (-gap[contact] / length).max(initial=0.0) if unilateral(model) else 0.0,
        "slip: v_r": max((-s * v_r[mode == name] / speed).max(initial=0.0) for name, s in SIGNS.items()),
        "events: order": -np.diff(run.events.t).min(initial=0.0),
    }
    return worst


LIMITS = {
    "stick: v_r": 1e-10,
    "stick: cone": 1e-9,
    "flight: gap": 1e-11,
    "flight: force": 0.0,
    "contact: F_N": 1e-11,
    "contact: gap": 1e-11,
    "slip: v_r": 1e-11,
    "events: order": 0.0,
}
