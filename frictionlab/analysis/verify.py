"""`fl.verify`: whether a run can be trusted, judged by what its model states, by two other runs and by one
from a neighbouring state."""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from frictionlab.analysis.independent_method import IndependentMethod
from frictionlab.analysis.initial_states import initial_state_of
from frictionlab.analysis.motion_scales import Array, motion_size
from frictionlab.analysis.run_comparison import (
    RunComparison,
    accumulation_time,
    compare_runs,
    standstill_time,
)
from frictionlab.analysis.run_conditions import broken_condition, judged_size, unjudged_steps
from frictionlab.hybrid.kernels.jets import MACHINE_EPSILON, MAX_ORDER
from frictionlab.hybrid.methods.base import Method
from frictionlab.hybrid.methods.taylor import Taylor
from frictionlab.hybrid.problem import Status
from frictionlab.hybrid.solve import RunOptions, method_of, run_automaton
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.hybrid.variational.tangent_flow import initial_frame
from frictionlab.models.model import ModelOrAutomaton, automaton_of
from frictionlab.presentation import Drawable
from frictionlab.validation import check_flag, check_t_end, explains_keywords

# share of the initial motion by which the neighbouring run's start is changed, to show how far the motion is
# predictable
NEIGHBOUR_OFFSET = 1e-9
FIRST_SAMPLES = 80  # samples of the first ten steps: some periods of the fastest vibration
# share of the motion's size: once the neighbouring run deviates by this, the motion is no longer predictable
UNPREDICTABLE_DEVIATION = 1e-3
TRUSTED_DEVIATION = 1e-4  # share of the motion's size: runs that agree so well coincide in a plot
EXTRA_ORDERS, TOLERANCE_FACTOR = 6, 0.1  # added to the order, and times the tolerance, for the second run
INDEPENDENT_RTOL = 1e-12  # relative tolerance of the independent method
INDEPENDENT_STEPS = 4_000  # most of the independent method: one from event to event takes some 5 ms
TIME_RTOL = 1e-6  # share by which times in two runs with the same events may differ
UNPREDICTABLE_MESSAGE = "a start changed by a billionth leads elsewhere."


@dataclass(frozen=True, eq=False, repr=False)
class Verification(Drawable):
    """The verification of a run by other runs of the same motion; prints as a verdict in a sentence or two.

    Parameters
    ----------
    run : Trajectory
        The run in question.
    error : float
        Largest deviation from the second and the independent run up to `until`, as a share of the motion's
        size: the largest range among coordinates, among velocities, and among other states.
    until : float
        s: time up to which the motion can be predicted.  After it, a run from an initial state changed by a
        billionth deviates.
    independent_until : float
        s: time up to which the run was compared with the independent one: at most up to a Zeno point, to
        where the run from the changed state deviates by a ten-thousandth, and as far as it came in 4000
        steps.
    events_agree : bool
        Whether the events up to `until` are the same, in the same sequence.
    defect : mapping
        Largest defect of the run's steps in each mode; see :attr:`Trajectory.defect`.
    ok : bool
        Whether the run can be trusted up to `until`.
    verdict : str
    """

    drawn_by = "plot_verification"

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


@explains_keywords
def verify(
    model: ModelOrAutomaton,
    t_end: float,
    *,
    x0: Any = "rest",
    method: str | Method = "taylor",
    progress: bool = True,
) -> Verification:
    """Run a model, and check the run by what the model states, and by other runs.

    Event functions and constraints of the modes are bounded all over the run, and rates compared with those
    of its polynomials.  A run of a :class:`MechanicalModel` must keep what the model states, without the
    equations and resets that were derived from it: Lagrange's equations by differences of the energies,
    holding forces within their limits, stick that lasts as long as it can, contacts that do not pull, the
    momentum, the energy and the law of impacts.

    The second run uses series of a higher order and a tighter tolerance.  The third is by DOP853 of scipy,
    which shares the equations, but not the series, the steps or the search for events.  It cannot follow Zeno
    behaviour (chatter, a ball that comes to rest) and is compared only up to there, and as far as it comes in
    4000 steps.  The fourth starts from an initial state changed by a billionth and shows how far the motion
    can be predicted: a chaotic motion is not compared beyond that time.  The verdict says what was not
    compared.

    Parameters
    ----------
    model : Model or HybridAutomaton
    t_end : float
        End time in seconds, positive.
    x0 : "rest", "near", mapping or array_like (n,)
        For an automaton "rest" means all states zero.
    method : "taylor", Taylor, RK4, Scipy, ...
        Method of the run in question.
    progress : bool

    Returns
    -------
    Verification

    Raises
    ------
    ValueError
        For bad arguments, before any work is done.
    KeyboardInterrupt
        After ctrl-C; :func:`partial_result` then returns the run that was stopped.

    Examples
    --------
    >>> import frictionlab as fl
    >>> verification = fl.verify(fl.SliderOnBelt(mu_k=1.4).without("geometry"), 1.0)
    >>> verification.ok, verification.until, verification.events_agree
    (True, 1.0, True)
    """
    check_flag("progress", progress)
    solver = method_of(method)
    t_end = check_t_end(t_end)
    start = initial_state_of(model, x0)
    motion = RunSetup(model, start, float(t_end), progress)
    run = motion.run(solver)
    if not run.raw.t > 0.0:
        raise ValueError(f"the motion must not end where it begins, it does: {run.status}")
    return verification_of(run, motion, solver)


def verification_of(run: Trajectory, motion: RunSetup, method: Method) -> Verification:
    """The verification of a run of a motion by a method."""
    exact = _more_exact_method(method, run.samples.order)
    second = motion.run(exact, t_end=run.raw.t)
    size = judged_size(second)
    neighbour, end = motion.neighbouring_run(second, exact), float(run.raw.t)
    until, clear = (
        _end_of_agreement(neighbour, second, size, share, end)
        for share in (UNPREDICTABLE_DEVIATION, TRUSTED_DEVIATION)
    )
    same = compare_runs(run, second, size, np.inf, until)
    third = _independent_run(motion, second, size, clear)
    comparisons = same, compare_runs(run, third, size, np.inf) if third else RunComparison(0.0, 0.0, np.inf)
    why = _reason_for_doubt(run, second, *comparisons)
    agreement = _agreement_message(run, second, third, until, comparisons)
    verdict = f"Do not trust this run: {why}." if why else agreement
    agree = all(each.differs_at == np.inf for each in comparisons)
    error = max(each.error for each in comparisons)
    return Verification(run, error, until, comparisons[1].until, agree, run.defect, not why, verdict)


class RunSetup:
    """What all runs of a verification share: the model, the initial state, the end time."""

    def __init__(self, model: ModelOrAutomaton, start: Array, t_end: float, progress: bool) -> None:
        self._model, self._automaton, self._progress = model, automaton_of(model), progress
        self.start, self._t_end = start, t_end

    def run(
        self,
        method: Method,
        start: Array | None = None,
        t_end: float | None = None,
        mode: str | None = None,
    ) -> Trajectory:
        source = None if self._model is self._automaton else self._model
        return run_automaton(
            self._automaton,
            self._t_end if t_end is None else t_end,
            self.start if start is None else start,
            method,
            RunOptions(mode, progress=self._progress, source=source),
        )

    def neighbouring_run(self, run: Trajectory, method: Taylor) -> Trajectory:
        """A run by the same method from a neighbouring state that keeps the constraints of its mode, as stick
        and closed rigid contacts have; the run itself where its mode cannot begin on either side.
        """
        if not len(run.raw.step_modes):
            return run
        mode = run.mode_names[int(run.raw.step_modes[0])]
        size = np.minimum(motion_size(run, FIRST_SAMPLES), motion_size(run))
        signs, n = np.where(np.arange(len(size)) % 2, -1.0, 1.0), self._automaton.coordinates
        signs[2 * n if n else len(size) :] = 0.0  # phases and states of laws stay
        if (moves := np.abs(run.states).max(axis=0) > 0.0)[:n].any() and not moves[n : 2 * n].any():
            signs[n : 2 * n] = 0.0  # at rest beside the origin no velocity has a size
        offset = NEIGHBOUR_OFFSET * (initial_frame(run) @ (size * signs))
        for start in (self.start + offset, self.start - offset):
            with suppress(ValueError):
                return self.run(method, start, run.raw.t, mode)
        return run


def _more_exact_method(method: Method, order: int) -> Taylor:
    """A Taylor method with an order above that of the run and a tighter tolerance; for others, Taylor's."""
    if not isinstance(method, Taylor):
        return Taylor()
    higher = min(MAX_ORDER, order + EXTRA_ORDERS)
    return replace(method, tol=TOLERANCE_FACTOR * method.tol, order=higher)


def _end_of_agreement(one: Trajectory, two: Trajectory, size: Array, share: float, end: float) -> float:
    """The time up to which two runs that end at `end` deviate by less than a share of the motion's size."""
    until = compare_runs(one, two, size, share).until
    return end if math.isclose(until, end, rel_tol=TIME_RTOL) else until  # one may end a little earlier


def _independent_run(motion: RunSetup, second: Trajectory, size: Array, until: float) -> Trajectory | None:
    """The run by an independent method, up to where this can follow; None where it cannot follow at all.

    Where the neighbouring run deviates, `until`, errors of a method with a tolerance have grown as well.
    """
    end = min(until, accumulation_time(second), standstill_time(second, size))
    if not end > 0.0:
        return None
    tolerances = INDEPENDENT_RTOL, INDEPENDENT_RTOL * float(size.min())
    return motion.run(IndependentMethod("DOP853", *tolerances, max_steps=INDEPENDENT_STEPS), t_end=end)


def _reason_for_doubt(run: Trajectory, second: Trajectory, same: RunComparison, other: RunComparison) -> str:
    """The reason why a run is not to be trusted; an empty text where it can be trusted."""
    # It needs sympy, which the plots that show verifications do without.
    from frictionlab.analysis.stated_conditions import broken_statement

    if broken := broken_condition(run) or broken_statement(run):
        return broken
    for comparison, which in ((same, "a more exact one"), (other, "an independent one")):
        if comparison.differs_at < np.inf:
            return f"its events are not those of {which} from t = {comparison.differs_at:.4g} s on"
        if not comparison.error <= TRUSTED_DEVIATION:
            return f"it deviates from {which} by {comparison.error:.1g} of the motion's size"
    if second.raw.t < run.raw.t * (1 - TIME_RTOL):
        return f"a more exact one ends already at t = {second.raw.t:.6g} s: {second.status}"
    return run.defect_warning() or ""


def _agreement_message(
    run: Trajectory,
    second: Trajectory,
    third: Trajectory | None,
    until: float,
    comparisons: tuple[RunComparison, RunComparison],
) -> str:
    """The verdict where the runs agree."""
    count = int((run.raw.event_times <= until).sum())
    events = {0: "without an event", 1: "with the same event"}.get(count, f"with the same {count} events")
    agree = f"agree to {max(MACHINE_EPSILON, *(each.error for each in comparisons)):.0e} of the motion's size"
    whole, independent = until == run.raw.t, comparisons[1].until
    if whole and independent == until:
        text = f"All three runs {agree} over {until:.4g} s, {events}."
    elif whole:
        text = f"The runs {agree} over {until:.4g} s, {events}."
    else:
        text = f"The runs {agree} up to t = {until:.4g} s, {events}; "
        text += f"after that it cannot be predicted: {UNPREDICTABLE_MESSAGE}"
    if independent < until:
        limit = _comparison_limit(second, third)
        text += f" The independent method was compared up to t = {independent:.4g} s, {limit}."
    if not run.status.ok:
        text += f" There the run ended: {run.status}."
    from frictionlab.analysis.stated_conditions import unjudged_statement  # needs sympy, as above

    return " ".join(filter(None, [text, unjudged_steps(run), unjudged_statement(run)]))


def _comparison_limit(second: Trajectory, third: Trajectory | None) -> str:
    """Why the comparison with the independent method ended."""
    if third is not None and third.status is Status.STEP_CAP:
        return f"where it had taken {len(third.raw.step_modes)} steps"
    if third is not None and not third.status.ok:
        return f"where it ended ({third.status})"
    if third is not None and third.raw.t == standstill_time(second, judged_size(second)):
        return "from where on nothing moves"
    if third is not None and third.raw.t < accumulation_time(second):
        return "where errors of its size have grown too large"
    return "at a Zeno accumulation of events"
