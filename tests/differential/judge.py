"""The verdict on a case: does the package's run agree with the reference, and keep to its own laws?"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

import frictionlab as fl
from tests.differential.case import Case
from tests.differential.predict import FAINT, Prediction, clear, near, predict
from tests.differential.twin import full, twin
from tests.reference.hybrid import Happening, Undecided

ALLOWED = 3.0  # spreads of the runs nearby by which a run may differ from the reference
GRID = 301  # samples at which the laws are checked
AGREES, UNDECIDED = "agrees", "undecided"


@dataclass(frozen=True)
class Verdict:
    """What a case came to: "agrees", "undecided" or a kind of failure; words; largest share of a bound."""

    kind: str
    words: str = ""
    share: float = 0.0
    horizon: float = 0.0

    @property
    def failed(self) -> bool:
        return self.kind not in (AGREES, UNDECIDED)


def judge(case: Case) -> Verdict:
    """Run a case both ways and compare."""
    try:
        known = predict(case)
    except Undecided as reason:
        return Verdict(UNDECIDED, str(reason))
    grid = np.union1d(np.linspace(0.0, case.t_end, GRID), known.t)
    try:
        run = fl.simulate(case.model, case.t_end, x0=case.x0, method=case.method, t_eval=grid, progress=False)
    except Exception as error:
        return Verdict(f"raises {type(error).__name__}", str(error))
    return compared(case, known, run)


def compared(case: Case, known: Prediction, run: Any) -> Verdict:
    """The first complaint about a run, or that there is none."""
    if not run.status.ok:
        return Verdict(run.status.name.lower().replace("_", " "), f"at {run.raw.t:.6g} of {case.t_end:g} s")
    found, share = ours(run), 0.0
    for check in (_events, _states, _laws):
        size, words = check(case, known, run, found)
        if not size <= 1.0:
            return Verdict(check.__name__.strip("_"), words, size, known.horizon)
        share = max(share, size)
    return Verdict(AGREES, "", share, known.horizon)


def ours(run: Any) -> list[Happening]:
    """Events of a run as the reference has them: without the clock of the force, without faint impacts."""
    events, names = run.events, list(run.names)
    rows = [
        Happening(t, source, target, _speed(names, source, target, before))
        for t, source, target, guard, before in zip(
            events.t, events.source, events.target, events.guard, events.before, strict=True
        )
        if guard != "period"
    ]
    fastest = max((e.speed for e in rows if np.isfinite(e.speed)), default=0.0)
    return [e for e in rows if e.source != e.target or e.speed > FAINT * fastest]


def _speed(names: list[str], source: str, target: str, z: np.ndarray) -> float:
    """Speed of an impact; infinite for what is none."""
    if source == "flight":
        return abs(float(z[1]))
    if source != "separation":
        return np.inf
    at = dict(zip(names, z, strict=True))
    rate = at["y2'"] - at["y1'"] if "y2'" in at else np.inf
    if "phi" in at:
        rate -= (at["x1'"] - at["x2'"]) * at["phi"] + (at["x1"] - at["x2"]) * at["phi'"]
    return abs(rate)


def _events(case: Case, known: Prediction, run: Any, found: list[Happening]) -> tuple[float, str]:
    """Share of the bound on times, or infinity where the sequence differs, up to the horizon."""
    worst, words = 0.0, ""
    for i, event in enumerate(known.events):
        width = ALLOWED * known.time_spread[i]
        if event.t + width >= known.horizon:
            return worst, words
        if i >= len(found) or found[i][1:3] != event[1:3]:
            have = [f"{e.source} -> {e.target} at {e.t:.9g}" for e in found[i : i + 1]] or ["no event"]
            text = f"event {i}: {event.source} -> {event.target} at {event.t:.9g}, found {have[0]}"
            return np.inf, text + f", horizon {known.horizon:.6g}"
        share = abs(found[i].t - event.t) / width
        if share > worst:
            worst, words = share, f"event {i} at {event.t:.9g}: off by {found[i].t - event.t:.2e}"
    extra = found[len(known.events) : len(known.events) + 1]
    if extra and extra[0].t < known.horizon * (1 - 1e-9):
        return (
            np.inf,
            f"event {len(known.events)}: {extra[0][1]} -> {extra[0][2]} at {extra[0].t:.9g} is not there",
        )
    return worst, words


def _states(case: Case, known: Prediction, run: Any, found: Any) -> tuple[float, str]:
    """Largest error of a state at the sampled times, by its bound."""
    use = clear(known.t, known.events, known.time_spread, case.t_end) & (known.t < known.horizon)
    use[-1] |= known.horizon >= case.t_end and clear(known.t, known.events, known.time_spread, case.t_end)[-1]
    n = len(case.x0)
    at = np.searchsorted(run.t, known.t)
    states = full(case.model, run.states[:, :n].T).T[at]
    shares = np.abs(states - known.states) / (ALLOWED * known.state_spread + 1e-300)
    shares[~use] = 0.0
    i, j = np.unravel_index(shares.argmax(), shares.shape)
    off = states[i, j] - known.states[i, j]
    return float(
        shares[i, j]
    ), f"state {j} at {known.t[i]:.6g}: off by {off:.2e}, horizon {known.horizon:.6g}"


def _laws(case: Case, known: Prediction, run: Any, found: Any) -> tuple[float, str]:
    """Largest violation of what a mode promises, by its bound."""
    system, worst, words = twin(case.model), 0.0, ""
    z = full(case.model, run.states[:, : len(case.x0)].T)
    usual = np.concatenate([z, np.zeros_like(z[:, :1])], axis=1)
    when = np.append(run.t, 0.0)
    for mode in np.unique(run.mode):
        here, word = run.mode == mode, tuple(str(mode).split(" | "))
        rows, scales = system.laws(word, run.t[here], z[:, here]), system.laws(word, when, usual)
        for name, values in rows.items():
            share = -np.min(values) / (near(case.tol) * (np.abs(scales[name]).max() or 1e-3))
            if share > worst:
                worst, words = share, f"{name}: {np.min(values):.2e} at {run.t[here][np.argmin(values)]:.6g}"
    return worst, words
