"""`fl.steady_state`: run a model until transients have died away, and classify the motion that is left.

`SteadyState` holds kind, period, intensity, section points and time in each mode of that motion.  The
intensity L_s, Eq. (20), is the mean squared distance from the sliding equilibrium.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, NamedTuple, Unpack

import numpy as np
from numpy.typing import NDArray

from frictionlab.analysis.initial_states import initial_state_of
from frictionlab.analysis.motion_scales import Spectrum, amplitude_spectrum
from frictionlab.analysis.options import SteadyStateKeywords, SteadyStateOptions, settings_of
from frictionlab.analysis.steady_state.classification import (
    MotionKind,
    classify_run,
    largest_coordinate,
    onsets_per_period,
)
from frictionlab.analysis.steady_state.drift import mean_rates
from frictionlab.analysis.steady_state.poincare_sections import Section, section_function, sections_to_record
from frictionlab.automaton import HybridAutomaton
from frictionlab.hybrid.run_events import SectionPoints
from frictionlab.hybrid.solve import end_of, solve_from_end
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.lazy_names import sympy
from frictionlab.models.model import automaton_of
from frictionlab.presentation import Drawable, FrozenMapping
from frictionlab.stability import equilibrium
from frictionlab.stability.equilibrium_points.frozen_time import refuse_time
from frictionlab.validation import check_flag

if TYPE_CHECKING:
    from frictionlab.models.model import ModelOrAutomaton

Array = NDArray[np.float64]
SQUARED_DISTANCE = "square"
INTENSITY_SAMPLES = 100_001  # samples of a run whose method integrates no quadratures


def equilibrium_coordinates(model: ModelOrAutomaton) -> Array | None:
    """Coordinates (n,) of the sliding equilibrium; None where there is none."""
    try:
        return equilibrium(model).q
    except ValueError:
        return None


def with_equilibrium_parameters(automaton: HybridAutomaton, point: Array) -> HybridAutomaton:
    """The automaton with the equilibrium (n,) as additional parameters.

    As numbers in the integrand they would need a new program for every value of a parameter.
    """
    resting = {_equilibrium_symbol(x): float(e) for x, e in zip(automaton.states, point)}
    return replace(automaton.derived(), parameters={**automaton.parameters, **resting})


def displacements(automaton: HybridAutomaton) -> list[Any]:
    """x_i - x_e,i for each coordinate of an automaton that has the equilibrium as parameters."""
    pairs = ((x, _equilibrium_symbol(x)) for x in automaton.states)
    return [x - e for x, e in pairs if e in automaton.parameters]


def squared_distance(automaton: HybridAutomaton) -> Any:
    """The integrand of Eq. (20), the sum of the squared displacements."""
    return sum((d**2 for d in displacements(automaton)), sympy.S.Zero)


def _equilibrium_symbol(state: sympy.Symbol) -> sympy.Symbol:
    return sympy.Symbol(f"{state.name} at rest")


def intensity(run: Trajectory, period: float) -> float:
    """L_s, Eq. (20): the mean over the last period of a run, or over all of it where `period` is NaN.

    Runs of the Taylor method carry the integral as the quadrature `SQUARED_DISTANCE`.  NaN where there is no
    equilibrium.
    """
    if SQUARED_DISTANCE not in run.quadratures:
        point = equilibrium_coordinates(run.source)
        return float("nan") if point is None else _intensity_of_samples(run, point, period)
    if np.isnan(period):
        return run.quadratures[SQUARED_DISTANCE] / run.raw.t
    start, square = run(run.raw.t - period), {SQUARED_DISTANCE: squared_distance(run.automaton)}
    mode = str(run.modes_at(run.raw.t - period))
    again = solve_from_end(run.automaton, period, start, mode, quadratures=square, progress=False)
    return again.quadratures[SQUARED_DISTANCE] / period


def _intensity_of_samples(run: Trajectory, point: Array, period: float) -> float:
    span = run.raw.t if np.isnan(period) else run.raw.t // period * period
    states = run(np.linspace(run.raw.t - span, run.raw.t, INTENSITY_SAMPLES))[:, : len(point)]
    return float(((states - point) ** 2).mean(axis=0).sum())


@dataclass(frozen=True, eq=False)
class SteadyState(Drawable):
    """What a motion settles to.

    Parameters
    ----------
    model : Model or HybridAutomaton
    kind : MotionKind
        One of "equilibrium", "periodic", "non-periodic", "not settled yet" and "ended early", the last where
        the solver did not reach the end of the run: ``trajectory.status`` says why.
    period : float
        s; NaN where the motion is not periodic.
    onsets_per_period : int
        Transitions from slip to stick in a period; 0 where the motion is not periodic.
    intensity : float
        L_s, Eq. (20): mean of the squared distance from the sliding equilibrium, the coordinates summed (m^2
        and rad^2).  Taken over the last period where there is one, else over the window.  NaN without an
        equilibrium, with a drift, or where the run ended early.
    section : SectionPoints
        Crossings of the section in the window: times (K,), states (K, 2n).  For a run that ended early, its
        final state.
    deviation : float
        Difference between the state and that one period before, as a share of the motion's size.
    time_in_mode : mapping
        Share of the window spent in each mode.
    trajectory : Trajectory
        The run over the window; its time starts at zero.
    transient : float
        Seconds before the window.
    drift : mapping of str to float
        Mean rates (per s) of the states whose shift the motion repeats with, such as the place of a cart or
        the angle of a disc; of a motion that is not settled, those of all states that grow or fall throughout
        the window.  Empty where there are none.
    """

    drawn_by = "plot_steady_state"

    model: ModelOrAutomaton
    kind: MotionKind
    period: float
    onsets_per_period: int
    intensity: float
    section: SectionPoints
    deviation: float
    time_in_mode: Mapping[str, float]
    trajectory: Trajectory
    transient: float
    drift: Mapping[str, float] = field(default_factory=lambda: FrozenMapping({}))

    @property
    def warning(self) -> str | None:
        """A warning where steps of the window are far less exact than the tolerance; else None."""
        return self.trajectory.warning

    @property
    def settled(self) -> bool:
        """Whether the transient was long enough to tell."""
        return self.kind in (MotionKind.EQUILIBRIUM, MotionKind.PERIODIC, MotionKind.NON_PERIODIC)

    def spectrum(self, name: str | None = None, *, f_max: float | None = None) -> Spectrum | None:
        """Amplitude spectrum of the whole window: amplitudes in the state's unit at frequencies in Hz; see
        :func:`frictionlab.analysis.motion_scales.amplitude_spectrum`.
        """
        return amplitude_spectrum(self.trajectory, name, f_max=f_max, start=0.0)

    def __repr__(self) -> str:
        if self.kind == MotionKind.ENDED_EARLY:
            return f"SteadyState({MotionKind.ENDED_EARLY}: {self.trajectory.status})"
        onsets = "onset" if self.onsets_per_period == 1 else "onsets"
        period = f", period {self.period:.6g} s, {self.onsets_per_period} {onsets} of stick in it"
        period = period if self.kind == MotionKind.PERIODIC else ""
        moving = "".join(f", {name} drifts by {rate:.4g}/s" for name, rate in self.drift.items())
        return f"SteadyState({self.kind}{period}{moving}, L_s {self.intensity:.5g})"


def steady_state_of_window(
    model: ModelOrAutomaton,
    run: Trajectory,
    section: Section | None,
    tolerance: float,
    *,
    passed: float,
    reach: Callable[[], float] = float,
) -> SteadyState:
    """The kind of motion in a run, its period, intensity and so on; arguments as of `steady_state`.

    `reach` gives the largest coordinate before.
    """
    classified = classify_run(run, section, tolerance, reach)
    compared = (
        classified.kind != MotionKind.ENDED_EARLY and classified.drift is None
    )  # a drift leaves any equilibrium
    drifts = classified.drift is not None or classified.kind == MotionKind.NOT_SETTLED
    return SteadyState(
        model=model,
        kind=classified.kind,
        period=classified.period,
        onsets_per_period=onsets_per_period(run, classified.period)
        if classified.kind == MotionKind.PERIODIC
        else 0,
        intensity=intensity(run, classified.period) if compared else np.nan,
        section=classified.section,
        deviation=classified.returns.deviation,
        time_in_mode={name: seconds / (run.raw.t or 1.0) for name, seconds in run.time_in_mode.items()},
        trajectory=run,
        transient=passed,
        drift=FrozenMapping(mean_rates(run) if drifts else {}),
    )


def steady_state(
    model: ModelOrAutomaton,
    x0: Any = "rest",
    *,
    progress: bool = True,
    **keywords: Unpack[SteadyStateKeywords],
) -> SteadyState:
    """Run a model until transients have died away, and classify the motion that is left.

    A motion is periodic if, over the second half of the window, the whole state at a section returns within
    `tolerance` of the motion's size, or within a thousandth and ever more closely.  It is at an equilibrium
    if there are no more events and the remaining motion decays and is less than a thousandth of the
    coordinates, or of those at which it began, or if friction holds it through a whole period of a force.

    If it is neither, it is not settled yet where it approaches one of them, repeats within a thousandth but
    no better, drifts in one direction, doubles or halves its size, or has a part that decays or grows,
    however slowly; also where the window has fewer than 24 crossings of the section.  Else it is
    non-periodic.

    A motion that turns for ever, or whose place grows, is compared modulo that shift, if neither flow nor
    events depend on it: a rotating pendulum and a block that is dragged along are periodic, a disc that turns
    evenly is at an equilibrium.  `SteadyState.drift` says how fast.

    Parameters
    ----------
    model : Model or HybridAutomaton
    x0 : "rest", "near", mapping or array_like (2n,)
        For an automaton "rest" means all states zero.
    progress : bool
    **keywords
        Fields of :class:`SteadyStateOptions`: ``transient=60.0``.

    Returns
    -------
    SteadyState

    Raises
    ------
    TypeError
        Where `model` is no model, or a keyword is unknown.
    ValueError
        For other bad arguments.  Both are raised before any run starts.
    KeyboardInterrupt
        After ctrl-C; :func:`partial_result` then returns the run that was stopped, transient or window.

    Examples
    --------
    >>> import frictionlab as fl
    >>> fl.steady_state(fl.SliderOnBelt(mu_k=1.4).without("geometry"), transient=60, window=10)
    SteadyState(periodic, period 0.0905161 s, 1 onset of stick in it, L_s 0.0011701)
    """
    check_flag("progress", progress)
    (options,) = settings_of("steady_state", keywords, SteadyStateOptions, unused="rtol")
    return settled_motion(model, x0, options, progress)


def settled_motion(
    model: ModelOrAutomaton, x0: Any, options: SteadyStateOptions, progress: bool
) -> SteadyState:
    """As :func:`steady_state`, with its options as an object."""
    refuse_time(model, "a steady state")
    check_section(model, options.section)
    return find_steady_state(model, initial_state_of(model, x0), options, progress)


def check_section(model: ModelOrAutomaton, section: Section | None) -> None:
    """Raise unless a motion of the model can have the section."""
    automaton = automaton_of(model)
    if section is not None:
        section_function(automaton, section)


def find_steady_state(
    model: ModelOrAutomaton, x0: Any, options: SteadyStateOptions, progress: bool, mode: str | None = None
) -> SteadyState:
    """The steady state from an initial state (n,), or from where a run has ended in a mode; other arguments
    as of :func:`steady_state`, already checked."""
    start = WindowStart(x0, mode)
    if options.transient > 0:
        run = run_transient(model, x0, mode, options, progress)
        if not run.status.ok:
            return steady_state_of_window(model, run, options.section, options.tolerance, passed=0.0)
        start = WindowStart(*end_of(run), options.transient, reach=largest_coordinate(run))
    return settle(model, start, options, progress)[0]


class WindowStart(NamedTuple):
    """Where a window starts, and what was before it.

    Parameters
    ----------
    state : array (n,)
    mode : str or None
    transient : float
        Seconds before the window.
    first_reach : callable
        Gives the largest coordinate in the first of these seconds; called only where it decides.
    reach : float
        The largest coordinate in the others.
    """

    state: Any
    mode: str | None
    transient: float = 0.0
    first_reach: Callable[[], float] = float
    reach: float = 0.0

    def largest_coordinate(self) -> float:
        """The largest coordinate so far."""
        return max(self.first_reach(), self.reach)


def settle(
    model: ModelOrAutomaton, start: WindowStart, options: SteadyStateOptions, progress: bool
) -> tuple[SteadyState, WindowStart]:
    """The steady state found window by window, up to `t_max`, and where the next window would start."""
    section, t_max = options.section, options.t_max
    while True:
        run = _run_window(model, start, options, progress)
        steady = steady_state_of_window(
            model,
            run,
            section,
            options.tolerance,
            passed=start.transient,
            reach=start.largest_coordinate,
        )
        passed, reach = start.transient + options.window, max(start.reach, largest_coordinate(run))
        start = WindowStart(*end_of(run), passed, start.first_reach, reach)
        if steady.settled or t_max is None or passed + options.window > t_max or not run.status.ok:
            return steady, start


def run_transient(
    model: ModelOrAutomaton, x0: Any, mode: str | None, settings: SteadyStateOptions, progress: bool
) -> Trajectory:
    """The run over the transient from an initial state (n,)."""
    options: dict[str, Any] = {"method": settings.solver, "progress": progress, "source": model}
    return solve_from_end(automaton_of(model), settings.transient, x0, mode, **options)


def _run_window(
    model: ModelOrAutomaton, start: WindowStart, settings: SteadyStateOptions, progress: bool
) -> Trajectory:
    """A run with the section and the integrand of L_s along it, where the method can record them."""
    method = settings.solver
    options: dict[str, Any] = {"method": method, "progress": progress, "source": model}
    automaton, point = automaton_of(model), equilibrium_coordinates(model)
    if method.records_sections:
        options["sections"] = sections_to_record(automaton, settings.section)
    if method.records_sections and point is not None:
        automaton = with_equilibrium_parameters(automaton, point)
        options["quadratures"] = {SQUARED_DISTANCE: squared_distance(automaton)}
    return solve_from_end(automaton, settings.window, start.state, start.mode, **options)
