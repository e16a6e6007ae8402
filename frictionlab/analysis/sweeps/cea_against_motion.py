"""`fl.cea_against_motion`: does the complex eigenvalue analysis tell what a small disturbance becomes?"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum
from math import log
from typing import Any, Unpack

import numpy as np
from numpy.typing import NDArray

from frictionlab.analysis.initial_states import initial_state_of
from frictionlab.analysis.motion_scales import highest_frequency
from frictionlab.analysis.options import Execution, SteadyStateOptions, StudyKeywords, settings_of
from frictionlab.analysis.period_of_motion import oscillation_period
from frictionlab.analysis.steady_state.classification import MotionKind
from frictionlab.analysis.steady_state.steady_state import check_section, settled_motion
from frictionlab.analysis.sweeps.sweep import sweep
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.models.composition import parameter_unit
from frictionlab.models.model import ModelOrAutomaton, automaton_of, require_model_or_automaton
from frictionlab.presentation import Drawable, count, dataframe, span, tally
from frictionlab.stability import RootLocus, eigenvalues, root_locus
from frictionlab.stability.equilibrium_points.frozen_time import refuse_time
from frictionlab.validation import check_choice, check_number

Array = NDArray[np.float64]
FREQUENCY_BINS = 240  # of the picture; the strongest line of each is shown
GROWTH = log(1e6)  # by which the fastest mode grows, or the slowest decays, in the transient
LEAST_PERIODS, MOST_PERIODS = 100.0, 500.0  # of the transient
WINDOW_PERIODS = 50.0
SAMPLES_PER_PERIOD = 256
LAST_PERIODS = 5000.0  # windows follow each other until then
VIBRATIONS = (MotionKind.PERIODIC, MotionKind.NON_PERIODIC)


class Agreement(StrEnum):
    """Whether the motion does what the eigenvalues say."""

    AGREES = "agrees"
    VIBRATES = "vibrates though stable"
    RESTS = "rests though unstable"
    OPEN = "not settled"


@dataclass(frozen=True, eq=False)
class CEAAgainstMotion(Drawable):
    """What the eigenvalues say at N values of a parameter, and what the motion does.

    Parameters
    ----------
    model : Model or HybridAutomaton
    parameter : str
    values : array (N,)
    locus : RootLocus
        The eigenvalues at the equilibrium.
    state : str
        The state whose motion is measured.
    kinds : tuple of str (N,)
        Of the steady state after the disturbance, see :class:`SteadyState`; "" where none was computed.
    amplitudes : array (N,)
        Half the range of the state in it, in its unit.
    dominant : array (N,)
        Frequency (Hz) of the strongest line of its spectrum; NaN at rest.
    lines : array (N, 240)
        Amplitude of the strongest line in each of 240 equal bands of frequency.
    f_max : float
        The upper end of the last band, Hz.
    """

    drawn_by = "plot_cea_against_motion"

    model: ModelOrAutomaton
    parameter: str
    values: Array
    locus: RootLocus
    state: str
    kinds: tuple[str, ...]
    amplitudes: Array
    dominant: Array
    lines: Array
    f_max: float

    @property
    def unstable(self) -> Array:
        """Frequencies (N, n) of the modes that grow, Hz; NaN for the others."""
        return np.where(self.locus.growth_rates > 0.0, self.locus.frequencies, np.nan)

    @property
    def growth_rates(self) -> Array:
        """The largest growth rate at each value (N,), 1/s; NaN without an equilibrium."""
        rates = self.locus.growth_rates
        finite = np.isfinite(rates).any(axis=1)
        return np.where(finite, np.max(np.where(np.isfinite(rates), rates, -np.inf), axis=1), np.nan)

    @property
    def fastest(self) -> Array:
        """Frequency (N,) of the mode that grows fastest, Hz; NaN where none grows."""
        rates = np.where(np.isfinite(self.locus.growth_rates), self.locus.growth_rates, -np.inf)
        return self.unstable[np.arange(len(self.values)), rates.argmax(axis=1)]

    @property
    def deviations(self) -> Array:
        """|f - f_e|/f_e of the dominant frequency f and the fastest mode's f_e, where both exist, (K,)."""
        both = np.isfinite(self.dominant) & np.isfinite(self.fastest)
        return np.abs(self.dominant - self.fastest)[both] / self.fastest[both]

    @property
    def agreement(self) -> tuple[Agreement, ...]:
        """Of each value: whether it vibrates where a mode grows, and rests where none does.

        "not settled" where the motion, or without an equilibrium the eigenvalues, do not tell.
        """
        return tuple(map(_agreement, self.growth_rates > 0.0, np.isfinite(self.growth_rates), self.kinds))

    def to_dataframe(self) -> Any:
        """One row for each value, as a pandas DataFrame (needs the extra ``data``)."""
        columns: dict[str, Any] = {
            "growth_rate": self.growth_rates,
            "unstable_frequency": self.fastest,
            "kind": np.array(self.kinds, dtype=object),
            "amplitude": self.amplitudes,
            "dominant_frequency": self.dominant,
            "agreement": np.array(self.agreement, dtype=object),
        }
        units = {self.parameter: parameter_unit(self.model, self.parameter)}
        units |= {"growth_rate": "1/s", "unstable_frequency": "Hz", "dominant_frequency": "Hz"}
        return dataframe(columns, {self.parameter: self.values}, units)

    def __repr__(self) -> str:
        at = f"{self.parameter} {span(self.values)}, {count(len(self.values), 'value')}"
        return f"CEAAgainstMotion({at}: {tally(map(str, self.agreement))})"


def _agreement(unstable: bool, has_equilibrium: bool, kind: str) -> Agreement:
    if not has_equilibrium or kind not in (*VIBRATIONS, MotionKind.EQUILIBRIUM):
        return Agreement.OPEN
    if unstable == (kind in VIBRATIONS):
        return Agreement.AGREES
    return Agreement.RESTS if unstable else Agreement.VIBRATES


@dataclass(frozen=True)
class SettledMotion:
    """What the motion of a model settles to, as data that JSON can hold.

    Parameters
    ----------
    state : str
    f_max : float
    options : SteadyStateOptions
    chosen : frozenset of str
        Which of transient, window and t_max the caller has chosen; the others follow from the eigenvalues.
    """

    state: str
    f_max: float
    options: SteadyStateOptions
    chosen: frozenset[str]

    @property
    def __name__(self) -> str:
        """By which a file tells settings apart."""
        return f"motion of {self.state} up to {self.f_max} Hz, {self.options}, {sorted(self.chosen)}"

    def __call__(self, model: ModelOrAutomaton, x0: Any) -> dict[str, Any]:
        times = {name: each for name, each in _times(model).items() if name not in self.chosen}
        options = replace(self.options, **times)
        steady = settled_motion(model, x0, options, progress=False)
        spectrum = steady.spectrum(self.state, f_max=self.f_max)
        result = {"kind": steady.kind, "amplitude": _amplitude(steady.trajectory, self.state)}
        if spectrum is None or steady.kind == MotionKind.EQUILIBRIUM:
            return result | {"dominant": None, "lines": [0.0] * FREQUENCY_BINS}
        bands = (spectrum.frequencies * (FREQUENCY_BINS / self.f_max)).astype(int)
        lines = np.zeros(FREQUENCY_BINS)
        np.maximum.at(lines, np.minimum(bands, FREQUENCY_BINS - 1), spectrum.amplitudes)
        peaks = spectrum.peaks()[0]
        return result | {"dominant": float(peaks[0]) if len(peaks) else None, "lines": lines.tolist()}


def _times(model: ModelOrAutomaton) -> dict[str, float]:
    """Seconds of transient, window and longest run, by the fastest or the slowest mode and its period."""
    period, rate = _period_and_rate(model)
    least, most = LEAST_PERIODS * period, MOST_PERIODS * period
    transient = min(max(GROWTH / rate, least), most) if rate else most
    return {"transient": transient, "window": WINDOW_PERIODS * period, "t_max": LAST_PERIODS * period}


def _period_and_rate(model: ModelOrAutomaton) -> tuple[float, float]:
    """Of the mode that grows fastest or decays most slowly, s and 1/s."""
    try:
        values = eigenvalues(model).values
    except (ValueError, ArithmeticError):  # without an equilibrium
        return oscillation_period(model), 0.0
    turning = values[values.imag > 0.0]
    if not len(turning):
        return oscillation_period(model), 0.0
    first = turning[turning.real.argmax()]
    return float(2 * np.pi / first.imag), abs(float(first.real))


def _amplitude(run: Trajectory, state: str) -> float:
    """Half the range of a state over the last periods of a run."""
    end, period = float(run.raw.t), _period_and_rate(run.source)[0]
    span = min(WINDOW_PERIODS * period, end)
    t = np.linspace(end - span, end, SAMPLES_PER_PERIOD * max(round(span / period), 1))
    return float(np.ptp(run(t)[:, run.names.index(state)])) / 2


def cea_against_motion(
    model: ModelOrAutomaton,
    parameter: str,
    values: Any,
    x0: Any = "near",
    *,
    state: str | None = None,
    f_max: float | None = None,
    **keywords: Unpack[StudyKeywords],
) -> CEAAgainstMotion:
    """What the complex eigenvalue analysis says at values of a parameter, beside what the motion does.

    The eigenvalues at the equilibrium say which modes grow, and with which frequencies.  The motion after a
    small disturbance may rest or vibrate, and at another frequency: large motions stick, and lose contacts.
    It is Fig. 18 of Liu and Ouyang (2020), for any model.

    Parameters
    ----------
    model : Model, Structure or HybridAutomaton
    parameter : str
    values : array_like (N,)
        Ascending.
    x0 : "near", "rest", mapping or array_like (2n,)
        Where the motion begins; "near" is a small disturbance of the equilibrium.
    state : str or None
        The state that is measured; None takes the first coordinate, or what figures show.
    f_max : float or None
        Highest frequency of the spectra, Hz; None takes about six times the model's own.
    **keywords
        As for :func:`steady_state` and :func:`sweep`.  Times that are not given follow from the growth rates:
        the transient lasts until the fastest mode would have grown a millionfold, at most 500 periods, and
        windows of 50 periods follow until the motion settles, up to 5,000.

    Returns
    -------
    CEAAgainstMotion

    Raises
    ------
    TypeError
        For an unknown parameter or keyword, or where `model` is no model.
    ValueError
        For other bad arguments.  Both are raised before any run starts.
    RuntimeError, KeyboardInterrupt
        As of :func:`sweep`.

    Examples
    --------
    >>> import frictionlab as fl
    >>> model = fl.ModeCoupling(c=0.1)
    >>> fl.cea_against_motion(model, "mu_k", [0.1, 1.0], progress=False)
    CEAAgainstMotion(mu_k 0.1 to 1, 2 values: 2 agrees)
    """
    options, how = settings_of("cea_against_motion", keywords, SteadyStateOptions, Execution, unused="rtol")
    require_model_or_automaton(model, cure="write cea_against_motion(model, parameter, values)")
    refuse_time(model, "a comparison with eigenvalues")
    check_section(model, options.section)
    automaton = automaton_of(model)
    observed: str = automaton.shown_state if state is None else state
    check_choice("state", observed, automaton.state_names)
    if f_max is None:
        f_max = highest_frequency(oscillation_period(model, x0))
    f_max = float(check_number("f_max", f_max, above=0.0, cure="leave it out for six times the model's own"))
    initial_state_of(model, x0)
    locus = root_locus(model, parameter, values)
    own_times = frozenset(keywords) & {"transient", "window", "t_max"}
    study = SettledMotion(observed, f_max, options, own_times)
    swept = sweep(model, study, {parameter: locus.at}, x0=[x0], **vars(how))
    return _result(model, locus, study, swept.results[:, 0])


def _result(
    model: ModelOrAutomaton, locus: RootLocus, study: SettledMotion, results: Any
) -> CEAAgainstMotion:
    rows = [{} if row is None else row for row in results]
    nothing = [np.nan] * FREQUENCY_BINS
    return CEAAgainstMotion(
        model=model,
        parameter=locus.parameter,
        values=locus.at,
        locus=locus,
        state=study.state,
        kinds=tuple(row.get("kind", "") for row in rows),
        amplitudes=np.array([row.get("amplitude", np.nan) for row in rows]),
        dominant=np.array([row.get("dominant") for row in rows], dtype=float),
        lines=np.array([row.get("lines", nothing) for row in rows]),
        f_max=study.f_max,
    )
