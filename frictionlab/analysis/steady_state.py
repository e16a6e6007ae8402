"""`fl.steady_state`: what a motion settles to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionlab.hybrid.choice import method_of
from frictionlab.hybrid.methods import Method
from frictionlab.hybrid.trajectory import Points, Trajectory
from frictionlab.hybrid.validation import check_number

from .intensity import intensity, resting_point
from .recurrence import NEVER, SETTLING, SHORTEST, Recurrence, recurrence, repeats, sizes
from .sections import STICK, Section, asked, points, stick_onsets
from .simulate import simulate
from .spectrum import F_MAX, Spectrum, amplitude_spectrum

Array = NDArray[np.float64]
EQUILIBRIUM, PERIODIC, NON_PERIODIC, UNSETTLED = "equilibrium", "periodic", "non-periodic", "not settled yet"
AT_REST = 1e-3  # distance from the equilibrium, as a share of it, within which linear decay does the rest
ROUNDING = 1e-9


@dataclass(frozen=True, eq=False)
class SteadyState:
    """What a motion settles to.

    Parameters
    ----------
    model : Model
    kind : "equilibrium", "periodic", "non-periodic" or "not settled yet"
    period : float
        s; NaN where the motion is not periodic.
    onsets_per_period : int
        Transitions from slip to stick in a period; 0 where the motion is not periodic.
    intensity : float
        L_s, Eq. (20): mean of the squared distance from the sliding equilibrium, the coordinates summed (m^2
        and rad^2).  Over one period where there is one, else over the window.  NaN without an equilibrium.
    section : Points
        Crossings of the section in the window: times (K,), states (K, 2n).
    deviation : float
        How far the state is from that one period before, as a share of the motion's size.
    time_in_mode : mapping
        Share of the window spent in each mode.
    trajectory : Trajectory
        The window; its time starts at zero.
    transient : float
        Seconds before the window.
    """

    model: Any
    kind: str
    period: float
    onsets_per_period: int
    intensity: float
    section: Points
    deviation: float
    time_in_mode: Mapping[str, float]
    trajectory: Trajectory
    transient: float

    @property
    def settled(self) -> bool:
        """Whether the transient was long enough to tell."""
        return self.kind != UNSETTLED

    def spectrum(self, name: str = "x1", *, f_max: float = F_MAX) -> Spectrum | None:
        """Amplitude spectrum (the state's unit, over Hz) of the whole window, Hann-weighted; see
        :func:`frictionlab.analysis.spectrum.amplitude_spectrum`.
        """
        return amplitude_spectrum(self.trajectory, name, f_max=f_max, start=0.0)

    def __repr__(self) -> str:
        period = f", period {self.period:.6g} s, {self.onsets_per_period} onsets of stick in it"
        return f"SteadyState({self.kind}{period if self.kind == PERIODIC else ''}, L_s {self.intensity:.5g})"


def steady_state(
    model: Any,
    x0: Any = "rest",
    *,
    transient: float = 200.0,
    window: float = 100.0,
    longest: float | None = None,
    method: str | Method = "taylor",
    section: Section | None = None,
    tolerance: float = 1e-6,
    progress: bool = True,
) -> SteadyState:
    """Run a model until transients have died away, and tell what is left.

    A motion is periodic where the whole state at a section returns within `tolerance` of the motion's size
    for the second half of the window, or within a thousandth and ever more nearly.  It is at rest where
    it slides towards an equilibrium without any event and is within a thousandth of it.

    Parameters
    ----------
    model : SliderOnBelt
    x0 : "rest", "near" or array_like (2n,)
    transient, window : float
        Seconds that are thrown away, and that are looked at.
    longest : float or None
        Go on, window by window, until the motion has settled or so many seconds have passed; None looks at
        one window only.
    method : "taylor", Taylor, RK4, ...
    section : None, "stick", str or (str, int)
        Where recurrence is looked at: transitions from slip to stick, or where an expression of the states
        passes zero.  None takes the first where there are such transitions, else ("x1'", -1).
    tolerance : float
    progress : bool

    Returns
    -------
    SteadyState

    Raises
    ------
    ValueError
        For bad arguments, before any work is done.
    """
    check_number("window", window, above=0.0, cure="give the seconds to look at")
    check_number("transient", transient, least=0.0, cure="give the seconds to throw away")
    check_number("tolerance", tolerance, above=0.0, cure="1e-6 suits the exact solver")
    chosen, start = method_of(method), x0
    if transient > 0:
        start = simulate(model, transient, x0=x0, method=chosen, progress=progress).final_state
    passed = transient
    while True:
        found = _window(model, start, window, passed, chosen, section, tolerance, progress)
        passed += window
        if found.settled or longest is None or passed + window > longest or not found.trajectory.status.ok:
            return found
        start = found.trajectory.final_state


def _window(
    model: Any,
    x0: Any,
    window: float,
    passed: float,
    method: Method,
    section: Any,
    tolerance: float,
    progress: bool,
) -> SteadyState:
    turning = (f"{model.coordinates[0]}'", -1)
    riders = {"sections": asked(model.automaton(), section or turning)} if method.riders else {}
    run = simulate(model, window, x0=x0, method=method, progress=progress, **riders)
    if section is None:
        section = STICK if stick_onsets(run).sum() >= SHORTEST else turning
    crossings = points(run, section)
    size = sizes(run.raw.step_states) if len(run.raw.step_states) else np.zeros(len(run.final_state))
    returns = recurrence(crossings.t, crossings.state, size, tolerance)
    kind = _kind(model, run, returns, tolerance)
    periodic = kind == PERIODIC
    period = returns.period if periodic else np.nan
    onsets = _onsets(run, period) if periodic else 0
    strength = intensity(run, crossings.state[-1] if periodic else None, period)
    shares = {name: seconds / run.raw.t for name, seconds in run.time_in_mode.items()}
    return SteadyState(
        model, kind, period, onsets, strength, crossings, returns.deviation, shares, run, passed
    )


def _kind(model: Any, run: Trajectory, returns: Recurrence, tolerance: float) -> str:
    if not run.status.ok:
        return UNSETTLED
    at_rest = _at_rest(model, run)
    if at_rest is not None:
        return EQUILIBRIUM if at_rest else UNSETTLED
    if repeats(returns, tolerance):
        return PERIODIC
    return UNSETTLED if returns is NEVER or returns.shrinking > SETTLING else NON_PERIODIC


def _at_rest(model: Any, run: Trajectory) -> bool | None:
    """Whether a motion without events has reached the equilibrium; None where it is not on its way there."""
    point = resting_point(model)
    if point is None or len(run.events):
        return None
    parts = np.array_split(run.raw.step_states[:, : len(point)], 4)
    away = [np.abs(part - point).max() / np.abs(point).max() for part in (parts[0], parts[-1]) if len(part)]
    if away[-1] < ROUNDING:
        return True
    return bool(away[-1] < AT_REST) if away[-1] < away[0] / SETTLING**0.5 else None


def _onsets(run: Trajectory, period: float) -> int:
    """Transitions from slip to stick in the last period; half a step aside, so that none is at its ends."""
    times = run.events.t[stick_onsets(run)]
    if not len(times):
        return 0
    return int(((times > times[-1] - 0.999 * period) & (times <= times[-1])).sum())
