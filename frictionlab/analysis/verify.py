"""`fl.verify`: whether a run can be trusted, from two more runs and one that starts a little beside."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from frictionlab.hybrid.choice import method_of
from frictionlab.hybrid.guards import EPSILON
from frictionlab.hybrid.jets import HIGHEST
from frictionlab.hybrid.methods import Method
from frictionlab.hybrid.scipy_methods import Scipy
from frictionlab.hybrid.solve import solve
from frictionlab.hybrid.status import Status
from frictionlab.hybrid.taylor import Taylor
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.hybrid.validation import check_number
from frictionlab.models import Model

from .agreement import TOGETHER, Agreement, agreement, longest_stay, pile_up, sizes_of, stays
from .recurrence import Array
from .steady_state import automaton_of, checked_start
from .trust import sentence

BESIDE = 1e-9  # of what moves at first: how far beside the start a run begins that shows what is predictable
AT_FIRST = 80  # samples, of ten steps: some periods of the fastest vibration
LOST = 1e-3  # of the motion's size: when that run is so far away, the motion is no longer predictable
TRUSTED = 1e-4  # of the motion's size: runs that agree so well draw one line in a picture
MORE_ORDERS, TIGHTER = 6, 0.1  # of the second run
INDEPENDENT = 1e-12  # relative tolerance of the independent method
STEPS = 20_000  # of the independent method, some ten seconds
AS_GOOD_AS_EQUAL = 1e-6  # share of a time by which two runs may differ that find the same
CHAOS = "a start changed by a billionth leads elsewhere."


@dataclass(frozen=True, eq=False, repr=False)
class Verification:
    """What several runs of one motion say about the first; printed, it is a verdict in a sentence or two.

    Parameters
    ----------
    run : Trajectory
        The run in question.
    error : float
        Largest deviation from the other runs up to `until`, as a share of the motion's size, which is that of
        the largest coordinate, velocity and other state.
    until : float
        s: how far the motion can be predicted.  Beyond, a start changed by a billionth leads elsewhere.
    independent_until : float
        s: how far the independent method was compared.  It ends where events pile up.
    events_agree : bool
        Whether the events up to `until` are the same, in the same sequence.
    defect : mapping
        That of the run: largest relative error of a step, by the mode.
    ok : bool
        Whether the run can be trusted up to `until`.
    verdict : str
    """

    run: Trajectory
    error: float
    until: float
    independent_until: float
    events_agree: bool
    defect: Mapping[str, float]
    ok: bool
    verdict: str

    def __str__(self) -> str:
        return self.verdict

    def __repr__(self) -> str:
        return f"Verification({self.verdict})"


def verify(
    model: Any, t_end: float, *, x0: Any = "rest", method: str | Method = "taylor", progress: bool = True
) -> Verification:
    """Run a model, and check the run by others.

    A second run has series of a higher order and a tighter tolerance.  A third is by DOP853 of scipy, which
    shares the equations but neither series nor root finder nor steps; where events pile up (chatter, a ball
    that comes to rest) it cannot follow, and is compared up to there.  A fourth begins a billionth beside
    the start and tells how far the motion can be predicted: what is chaotic is not compared.

    Parameters
    ----------
    model : Model or HybridAutomaton
    t_end : float
        End time in seconds, positive.
    x0 : "rest", "near" or array_like (n,)
        Of an automaton "rest" (all states zero) or an array.
    method : "taylor", Taylor, RK4, Scipy, ...
        Of the run in question.
    progress : bool

    Returns
    -------
    Verification

    Raises
    ------
    ValueError
        For bad arguments, before any work is done.
    KeyboardInterrupt
        After ctrl-C.

    Examples
    --------
    >>> import frictionlab as fl
    >>> found = fl.verify(fl.SliderOnBelt(mu_k=1.4).without("geometry"), 1.0)
    >>> found.ok, found.until, found.events_agree
    (True, 1.0, True)
    """
    chosen = method_of(method)
    check_number("t_end", t_end, above=0.0, cure="give the length of the run in seconds")
    start = checked_start(model, x0, automaton_of(model))
    motion = _Motion(model, start, float(t_end), progress)
    run = motion.run(chosen)
    if not run.raw.t > 0.0:
        raise ValueError(f"the motion must not end where it begins, it does: {run.status}")
    second = motion.run(_second(chosen), t_end=run.raw.t)
    size = sizes_of(second)
    until = agreement(motion.beside(second), second, size, LOST).until
    if math.isclose(until, run.raw.t, rel_tol=AS_GOOD_AS_EQUAL):  # the start beside ends a little earlier
        until = run.raw.t
    same = agreement(run, second, size, np.inf, until)
    third = _independent(motion, second, size, until, 0.5)
    other = _compared(run, third, size)
    if _differ(other) and not _differ(same):  # its steps may have passed over something
        third = _independent(motion, second, size, until, 0.0)
        other = _compared(run, third, size)
    found = same, other
    why = _doubt(run, second, *found)
    verdict = f"Do not trust this run: {why}." if why else _agreed(run, third, until, found)
    agree = all(each.parted == np.inf for each in found)
    error = max(each.error for each in found)
    return Verification(run, error, until, found[1].until, agree, run.defect, not why, verdict)


class _Motion:
    """What is run, by several methods."""

    def __init__(self, model: Any, start: Array, t_end: float, progress: bool) -> None:
        self._model, self._automaton, self._progress = model, automaton_of(model), progress
        self.start, self._t_end = start, t_end

    def run(self, method: Method, start: Array | None = None, t_end: float | None = None) -> Trajectory:
        run = solve(
            self._automaton,
            self._t_end if t_end is None else t_end,
            x0=self.start if start is None else start,
            method=method,
            progress=self._progress,
            source=None if self._model is self._automaton else self._model,
        )
        if run.status is Status.INTERRUPTED:
            raise KeyboardInterrupt
        if isinstance(self._model, Model):
            run.description["model"] = self._model.to_dict()
        return run

    def beside(self, run: Trajectory) -> Trajectory:
        """A run by the same method that starts a little beside another, in the same mode.

        In stick the velocities are held, at a stop both they and a coordinate: all states are moved where
        that is possible, else the coordinates, else the velocities.  The run itself where it is not.
        """
        method, n = method_of(Taylor(**_settings(run))), self._automaton.coordinates
        size = np.minimum(sizes_of(run, AT_FIRST), sizes_of(run))
        signs = BESIDE * size * np.where(np.arange(len(size)) % 2, -1.0, 1.0)
        group = np.minimum(np.arange(len(size)) // n, 2) if n else np.zeros(len(size), dtype=int)
        for moved in (group < 2, group == 0, group == 1):
            for start in (self.start + signs * moved, self.start - signs * moved):
                first = self.run(replace(method, max_steps=1), start).raw.step_modes
                if len(first) and first[0] == run.raw.step_modes[0]:
                    return self.run(method, start, run.raw.t)
        return run


def _settings(run: Trajectory) -> dict[str, Any]:
    return {name: value for name, value in run.description["method"].items() if name != "name"}


def _second(method: Method) -> Method:
    """Another order and a tighter tolerance; of other methods the Taylor method itself."""
    if not isinstance(method, Taylor):
        return Taylor()
    order = min(HIGHEST, method.degree + MORE_ORDERS)
    return replace(method, tol=TIGHTER * method.tol, order=order)


def _independent(
    motion: _Motion, second: Trajectory, size: Array, until: float, share: float
) -> Trajectory | None:
    """The run by another method, up to where it can follow; None where that is nowhere.

    Its steps are at most a `share` of the shortest stay in a mode, but for what would need too many.
    """
    end = min(until, pile_up(second))
    if not end > 0.0:
        return None
    lengths = _stays_up_to(second, end)[1]
    step = max(share * float(lengths.min()), end / STEPS)
    tolerances = INDEPENDENT, INDEPENDENT * float(size.min())
    return motion.run(Scipy("DOP853", *tolerances, step, max_steps=3 * STEPS), t_end=end)


def _compared(run: Trajectory, third: Trajectory | None, size: Array) -> Agreement:
    """With the independent run; that it misses what lasts less than two of its steps is no difference."""
    if third is None:
        return Agreement(0.0, 0.0, np.inf)
    found = agreement(run, third, size, np.inf)
    if found.parted < np.inf:
        begins, lengths = _stays_up_to(run, run.raw.t)
        near = np.searchsorted(begins, found.parted)
        if lengths[max(near - 1, 0) : near + 2].min() < 2.0 * _settings(third)["max_step"]:
            return found._replace(parted=np.inf)
    return found


def _stays_up_to(run: Trajectory, end: float) -> tuple[Array, Array]:
    """When the stays before `end` begin, and how long they last; the one under way there lasts on."""
    found = stays(run, TOGETHER * longest_stay(run, end))
    begins = np.append(0.0, found.last)
    lengths = np.append(found.first, max(run.raw.t, end)) - begins
    return begins[begins < end], lengths[begins < end]


def _differ(found: Agreement) -> bool:
    return found.parted < np.inf or not found.error <= TRUSTED


def _doubt(run: Trajectory, second: Trajectory, same: Agreement, other: Agreement) -> str:
    """Why a run is not to be trusted; nothing where it is."""
    for found, which in ((same, "a more exact one"), (other, "an independent one")):
        if found.parted < np.inf:
            return f"its events are not those of {which} from t = {found.parted:.4g} s on"
        if not found.error <= TRUSTED:
            return f"it deviates from {which} by {found.error:.1g} of the motion's size"
    if second.raw.t < run.raw.t * (1 - AS_GOOD_AS_EQUAL):
        return f"a more exact one ends already at t = {second.raw.t:.6g} s: {second.status}"
    tol = run.description["method"].get("tol")
    return "" if tol is None else sentence(run.defect, tol) or ""


def _agreed(
    run: Trajectory, third: Trajectory | None, until: float, found: tuple[Agreement, Agreement]
) -> str:
    """What runs that agree say."""
    count = int((run.raw.event_times <= until).sum())
    events = {0: "without an event", 1: "with the same event"}.get(count, f"with the same {count} events")
    agree = f"agree to {max(EPSILON, *(each.error for each in found)):.0e} of the motion's size"
    whole, independent = until == run.raw.t, found[1].until
    if whole and independent == until:
        text = f"All three runs {agree} over {until:.4g} s, {events}."
    elif whole:
        text = f"The runs {agree} over {until:.4g} s, {events}."
    else:
        text = (
            f"The runs {agree} up to t = {until:.4g} s, {events}; after that it cannot be predicted: {CHAOS}"
        )
    if independent < until:
        text += (
            f" The independent method was compared up to t = {independent:.4g} s, {_obstacle(run, third)}."
        )
    return text if run.status.ok else f"{text} There the run ended: {run.status}."


def _obstacle(run: Trajectory, third: Trajectory | None) -> str:
    """What ended the comparison with the independent method."""
    if third is not None and third.status is Status.STEP_CAP:
        return f"where it had taken {len(third.raw.step_modes)} steps"
    if third is not None and not third.status.ok:
        return f"where it ended ({third.status})"
    if third is None or math.isclose(third.raw.t, pile_up(run), rel_tol=AS_GOOD_AS_EQUAL):
        return "where events begin to pile up"
    return "where a mode lasts too short a time for its steps"
