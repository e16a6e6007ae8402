"""The verdict on a case: the package's run against the reference, up to where runs nearby part."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np

import frictionlab as fl
from tests.differential import judge as judge_of_models
from tests.differential.judge import AGREES, UNDECIDED
from tests.doors.mechanism import Mechanism, model_of
from tests.doors.reference import Reference
from tests.reference.hybrid import START, Happening, Undecided, Walker, _advance

REFUSED = "refused"
NEAR = 1e-9  # share by which the starts of the runs nearby differ
FAR = 1e-3  # spread, by the motion's size, beyond which nothing is foretold
SLACK = 3.0
ROUNDING = 1e-8  # what runs may always differ by: times by periods, states by their size
INSTANT = 1e-9  # of a period: events so near to each other count as one
STEPS = 5_000  # of the reference
LONG = 15.0  # periods


@dataclass(frozen=True)
class Verdict(judge_of_models.Verdict):
    """What a case came to, "refused" where the package refuses it, and how many events were compared."""

    events: int = 0

    @property
    def failed(self) -> bool:
        return super().failed and self.kind != REFUSED


@dataclass(frozen=True, eq=False)
class Motion:
    """A run of the reference, up to where it could go: the times of its samples, states, events, the end."""

    t: np.ndarray
    states: np.ndarray
    events: list[Happening]
    end: float
    why: str


def reference_motion(system: Reference, shift: float, times: np.ndarray, rtol: float = 1e-12) -> Motion:
    """The reference's motion from a start that is shifted by a share."""
    one, system.fastest = system.one, [0.0] * len(system.one.contacts)
    sizes = system.grouped(np.abs(one.starts))
    sizes[2 * one.n :] = [state.size for state in one.further]
    z = np.array(one.starts) + shift * sizes * np.where(np.arange(len(sizes)) % 2, 1.0, -1.0)
    run = Walker(system, times, rtol, 0.0, z, system.start(z), np.zeros(len(z)), STEPS)
    run.h, why = START * system.period, ""
    with np.errstate(all="ignore"):
        try:
            while run.t < times[-1]:
                _advance(run)
                if not np.abs(run.z).max() < 1e6 * max(sizes.max(), 1e-300):
                    raise Undecided("the motion is unbounded")
        except (Undecided, np.linalg.LinAlgError, OverflowError, ZeroDivisionError, ValueError) as reason:
            why = str(reason)
    while not why and len(run.found.t) < len(times):
        run.found.t.append(float(times[-1]))
        run.found.states.append(np.array(run.z))
    end = run.t if why else float(times[-1])
    keep = [i for i, t in enumerate(run.found.t) if t < end or not why]
    return Motion(
        np.array([run.found.t[i] for i in keep]),
        np.array([run.found.states[i] for i in keep]).reshape(len(keep), len(z)),
        [e for e in merged(run.found.events, INSTANT * one.period) if e.t < end or not why],
        end,
        why,
    )


@dataclass(frozen=True, eq=False)
class Prediction:
    """The reference's motion up to a horizon, with bounds of times and states."""

    motion: Motion
    times: np.ndarray
    bounds: np.ndarray
    horizon: float


def predict(one: Mechanism, t_end: float) -> Prediction:
    """What the reference foretells."""
    grid, system = np.linspace(0.0, t_end, 41), Reference(one)
    exact = reference_motion(system, 0.0, grid)
    horizon, spreads, widths = exact.end, [], []
    if not len(exact.t):
        return Prediction(exact, np.zeros(0), np.zeros((0, 2)), 0.0)
    size = system.grouped(np.abs(exact.states)).max(axis=0)
    for shift in (NEAR, -NEAR):
        other = reference_motion(system, shift, grid)
        horizon = min(horizon, other.end)
        pairs = list(zip(exact.events, other.events, strict=False))
        for i, (a, b) in enumerate(pairs):
            if a[1:3] != b[1:3] or abs(a.t - b.t) > FAR * one.period:
                horizon = min(horizon, a.t, b.t)
                pairs = pairs[:i]
                break
        else:
            longer = exact.events[len(pairs) :] + other.events[len(pairs) :]
            horizon = min([horizon, *(e.t for e in longer)])
        spreads.append([abs(a.t - b.t) for a, b in pairs])
        count = min(len(exact.t), len(other.t))
        apart = np.zeros_like(exact.states)
        apart[:count] = np.abs(exact.states[:count] - other.states[:count])
        widths.append(system.grouped(apart))
    count = min(map(len, spreads))
    times = np.max([s[:count] for s in spreads], axis=0) if count else np.zeros(0)
    times = SLACK * np.maximum.accumulate(times) + ROUNDING * one.period if count else times
    bounds = SLACK * np.maximum.accumulate(np.max(widths, axis=0), axis=0)
    for event, width in zip(exact.events, times, strict=False):  # between two runs' events states jump
        bounds[np.abs(exact.t - event.t) < 3 * width + 1e-12] = np.inf
    bounds += ROUNDING * size
    lost = (bounds > FAR * size).any(axis=1) & np.isfinite(bounds).all(axis=1)
    horizon = min(horizon, exact.t[lost].min(initial=np.inf))
    return Prediction(exact, times, bounds, float(horizon))


def run_of(one: Mechanism, t_end: float, tol: float = 1e-15, t_eval: Any = None) -> Any:
    """The package's run."""
    phase = [one.phase] if one.frequency else []
    x0 = [*one.x0, *phase, *one.starts[2 * one.n :]]
    given = {"x0": x0, "method": fl.Taylor(tol=tol, max_steps=400_000), "t_eval": t_eval, "progress": False}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return fl.simulate(model_of(one), t_end, **given)


def states_of(one: Mechanism, states: np.ndarray) -> np.ndarray:
    """Coordinates, velocities and further states of a run, without the phase."""
    return np.delete(states, 2 * one.n, axis=1) if one.frequency else states


def judge(one: Mechanism, t_end: float, further: float = 1.0, tol: float = 1e-15) -> Verdict:
    """Compare a run over `further` times t_end with the reference up to t_end."""
    known = predict(one, t_end)
    if known.horizon < 0.02 * t_end:
        return Verdict(UNDECIDED, known.motion.why)
    grid = np.union1d(known.motion.t, [further * t_end])
    try:
        run = run_of(one, further * t_end, tol, grid)
    except ValueError as error:
        return Verdict(REFUSED, str(error), horizon=known.horizon)
    except Exception as error:
        return Verdict(f"raises {type(error).__name__}", str(error), horizon=known.horizon)
    return compared(one, known, run, tol)


def compared(one: Mechanism, known: Prediction, run: Any, tol: float) -> Verdict:
    """The first complaint about a run, or that there is none."""
    horizon, slack = known.horizon, max(1.0, 1e3 * tol / ROUNDING)
    words = event_complaint(known, merged(happenings(run), INSTANT * one.period), slack)
    if words:
        return Verdict("events", words, horizon=horizon, events=len(known.motion.events))
    if run.raw.t < horizon * (1 - 1e-9):
        return Verdict("ends", f"at {run.raw.t:.9g}: {run.status}", horizon=horizon)
    at = np.searchsorted(run.t, known.motion.t)
    use = known.motion.t < horizon
    states = states_of(one, run.states[at])
    shares = np.abs(states - known.motion.states) / (slack * known.bounds + 1e-300)
    shares[~use] = 0.0
    i, j = np.unravel_index(shares.argmax(), shares.shape)
    if not shares[i, j] <= 1.0:
        off = states[i, j] - known.motion.states[i, j]
        return Verdict("states", f"state {j} at {known.motion.t[i]:.6g}: off by {off:.2e}", horizon=horizon)
    return Verdict(AGREES, horizon=horizon, events=len([e for e in known.motion.events if e.t < horizon]))


def happenings(run: Any) -> list[Happening]:
    """The run's events without those of the clock."""
    rows = zip(run.events.t, run.events.source, run.events.target, run.events.guard, strict=True)
    return [
        Happening(float(t), str(source), str(target))
        for t, source, target, guard in rows
        if guard != "period"
    ]


def merged(events: list[Happening], instant: float) -> list[Happening]:
    """The events, those at one instant as one; those that change nothing, as it seems, are left out."""
    one: list[Happening] = []
    for event in events:
        if one and event.t - one[-1].t <= instant:
            one[-1] = one[-1]._replace(target=event.target)
        else:
            one.append(event)
    return [e for e in one if e.source != e.target or "flight" in e.source]


def event_complaint(known: Prediction, events: list[Happening], slack: float) -> str:
    """What is wrong with the events; nothing if they agree up to the horizon."""
    expected = known.motion.events
    for i, event in enumerate(expected[: len(known.times)]):
        width = slack * known.times[i]
        if event.t + width >= known.horizon:
            return ""
        if i >= len(events) or events[i][1:3] != event[1:3]:
            have = [f"{e.source} -> {e.target} at {e.t:.9g}" for e in events[i : i + 1]] or ["no event"]
            text = f"event {i}: {event.source} -> {event.target} at {event.t:.9g}, got {have[0]}"
            return f"{text}; horizon {known.horizon:.6g}"
        if not abs(events[i].t - event.t) <= width:
            return f"event {i} at {event.t:.9g}: off by {events[i].t - event.t:.2e} of {width:.1e}"
    extra = events[len(expected) : len(expected) + 1]
    if len(known.times) == len(expected) and extra and extra[0].t < known.horizon * (1 - 1e-9):
        event = extra[0]
        return f"event {len(expected)}: {event.source} -> {event.target} at {event.t:.9g} is not there"
    return ""
