"""Solver settings, models and parameter grids of the paper's computations, and their steady states.

`Setting` says by which algorithm, with which impact law and how finely figures 7 to 18 are computed.  The
paper gives no grids: mu_k goes in steps of 0.05 or 0.1, with further values that its text names, and the
preload is varied over the range of Fig. 4.  What several figures and claims share is computed once:
`steady_states`, `sweep_results` and `cea_and_motions` are `fl.bifurcation`, `fl.sweep` and
`fl.cea_against_motion` with the options of a Setting, and keep results in files where it has a folder; the
other functions name what each figure needs.  The paper's printed numbers are kept as text, so that their last
digit is known: a value agrees with one if it rounds to it.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from itertools import groupby, pairwise
from math import pi
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionlab.analysis.options import SteadyStateKeywords
from frictionlab.analysis.steady_state.classification import MotionKind
from frictionlab.analysis.steady_state.steady_state import SteadyState, steady_state
from frictionlab.analysis.sweeps.bifurcation import bifurcation
from frictionlab.analysis.sweeps.cea_against_motion import CEAAgainstMotion, cea_against_motion
from frictionlab.analysis.sweeps.sweep import sweep
from frictionlab.components import PlasticImpact
from frictionlab.hybrid.methods.base import Method
from frictionlab.hybrid.methods.one_step import RK4
from frictionlab.hybrid.methods.taylor import Taylor
from frictionlab.models import SliderOnBelt
from frictionlab.validation import check_choice

if TYPE_CHECKING:
    from frictionlab.analysis.sweeps.bifurcation import Bifurcation

Array = NDArray[Any]

ALGORITHMS = ("exact", "paper")
IMPACTS = ("paper", "full gap rate")
PAPER_STEP = 2e-4  # s, of the paper's algorithm: that at which it gives the paper's 1.58 Hz
# s.  Under Eq. (13) there are thousands of ever shorter flights: below this dwell time their limit replaces
# them, which leaves errors of 1e-8 in the usual structure.
CHATTER_LIMIT = 1e-5
MAX_EVENTS_AND_STEPS = 1_000_000  # events, and steps, of a run: one that grows without bound ends there
TAYLOR = Taylor(chatter=CHATTER_LIMIT, max_events=MAX_EVENTS_AND_STEPS, max_steps=MAX_EVENTS_AND_STEPS)
HIGHEST_FREQUENCY = 20.0  # Hz, of a mode of the usual structure
# The exact solver returns to a state within rounding.  A fixed step detects an event up to a step late, in
# which a state moves by 2 pi f h of its size, 2.5 %: at both crossings, and at an event or more before each,
# hence the factor 4.
RETURN_TOLERANCES = {"exact": 1e-6, "paper": round(4 * 2 * pi * HIGHEST_FREQUENCY * PAPER_STEP, 3)}

USUAL = SliderOnBelt()
STIFF = SliderOnBelt(F=800.0, k_nl=1e7, k4=5e6, k5=5e6, k6=5e6)  # Figs 16 to 18
CONTACT_STIFFNESSES = (0.0, 1e4, 1e7)  # k_nl in N/m^3
MU_K_NAMED_IN_TEXT = (0.05, 0.75)  # further mu_k that the text on Fig. 11 names
MU_K_SMALL = (0.01, 0.02, 0.03, 0.04, 0.05, 0.38)  # without GN: "very small", and where Fig. 13 begins

MU_K_AT_ONSET = (1.35, 1.4)  # in sliding only: where Fig. 17b begins
CACHE: dict[str, Any] = {}
START_NAMES = {"near": "near the equilibrium", "rest": "far from it (at rest)"}
EXAMPLES = (0.3, 1.4, 2.5)  # mu_k of Fig. 7
STICK_SECTION = "stick"
TURNING_SECTION = "x1'"  # the section of Fig. 17b, crossed in either direction
MU_K_PRELOAD = 2.5
GEOMETRY_NAMES = {True: "with GN", False: "without GN"}
MAX_INTERVALS = 7  # intervals that a text lists at most
GRID_TOLERANCE = 1e-9  # for values that are the same but for rounding
ROUNDING_MARGIN = 1 + 1e-9  # a value that lies exactly between two roundings agrees with both


@dataclass(frozen=True)
class Setting:
    """The options with which Figs 7 to 18 can be computed; see :func:`frictionlab.paper.figure`."""

    algorithm: str = "exact"
    impact: str = "paper"
    quick: bool = False
    workers: int | None = field(default=None, compare=False)
    progress: bool = field(default=True, compare=False)
    resume: Path | None = field(default=None, compare=False)

    def __post_init__(self) -> None:
        check_choice("algorithm", self.algorithm, ALGORITHMS)
        check_choice("impact", self.impact, IMPACTS)

    @property
    def method(self) -> Method:
        """The solver."""
        return TAYLOR if self.algorithm == "exact" else RK4(step=PAPER_STEP)

    @property
    def tolerance(self) -> float:
        """To which share of its size a motion has to return to count as periodic."""
        return RETURN_TOLERANCES[self.algorithm]

    def adapt_model(self, model: SliderOnBelt) -> Any:
        """The model with the impact law asked for; without GN both laws are the same."""
        if self.impact == "paper" or "phi" not in model.coordinates:
            return model
        return model.replace(impact=PlasticImpact(penetration_rate="full"))

    def with_solver(self, algorithm: str, impact: str) -> Setting:
        """The setting with another algorithm and impact law."""
        return replace(self, algorithm=algorithm, impact=impact)

    @property
    def solver(self) -> str:
        """The algorithm in words."""
        return "exact solver" if self.algorithm == "exact" else f"paper's algorithm, step {PAPER_STEP:g} s"

    def __str__(self) -> str:
        return f"{self.solver}, {'Eq. (13)' if self.impact == 'paper' else 'full gap rate'}"


class Times(NamedTuple):
    """Seconds of transient, and of the window that is classified."""

    transient: float
    window: float


USUAL_TIMES = Times(300.0, 100.0)  # by Eq. (13) the belt's rotation takes 200 s to settle
FIXED_STEP_TIMES = Times(300.0, 60.0)
STIFF_TIMES = Times(150.0, 50.0)  # at 30 Hz; in sliding only it settles as slowly as the usual one


def times_of(model: SliderOnBelt, setting: Setting) -> Times:
    """The times for a model, by the cost of its motion and by how slowly it settles."""
    if setting.algorithm == "paper":
        return FIXED_STEP_TIMES
    smooth = "separation" not in model.interface.modes
    return STIFF_TIMES if model.k4 == STIFF.k4 and not smooth else USUAL_TIMES


def mu_k(setting: Setting) -> Array:
    """0.05, 0.1, ... 3: Figs 9 and 10."""
    return _sorted_grid(np.arange(1, 61)[_grid_slice(setting)] * 0.05)


def mu_k_coarse(setting: Setting, *further: float) -> Array:
    """0.1, 0.2, ... 3 and the further values that the text names, for figures of many sweeps."""
    return _sorted_grid(np.append(np.arange(1, 31)[_grid_slice(setting)] * 0.1, further))


def mu_k_near(setting: Setting) -> Array:
    """0.2, 0.4, ... 3, for starts near the equilibrium, whose stability the eigenvalues give exactly."""
    return mu_k(setting)[1::2] if setting.quick else mu_k(setting)[3::4]


def mu_k_stiff(setting: Setting) -> Array:
    """0.1, 0.2, ... 3, and closer together at the lower end."""
    return _sorted_grid(np.append(np.arange(1, 31)[_grid_slice(setting)] * 0.1, (0.05, 0.1, 0.15)))


def mu_k_sliding(setting: Setting) -> Array:
    """The values for the stiff structure in sliding only: as fine as for Fig. 9."""
    return np.union1d(mu_k(setting), MU_K_AT_ONSET)


def preloads(setting: Setting) -> Array:
    """F in N: 50, 100, ... 1000."""
    return _sorted_grid(np.arange(1, 21)[_grid_slice(setting)] * 50.0)


def _grid_slice(setting: Setting) -> slice:
    return slice(3, None, 4) if setting.quick else slice(None)


def _sorted_grid(values: Array) -> Array:
    """Ascending, each once, without the rounding of steps."""
    return np.unique(np.round(values, 10))


def steady_states(
    model: SliderOnBelt,
    values: Any,
    setting: Setting,
    x0: str = "rest",
    *,
    parameter: str = "mu_k",
    section: Any = None,
) -> Any:
    """`fl.bifurcation` as the setting says.

    Raises
    ------
    KeyboardInterrupt
        After ctrl-C; what was done is in the file, if there is a folder.
    """
    model = setting.adapt_model(model)
    options: dict[str, Any] = {"section": section, "tolerance": setting.tolerance}
    options |= times_of(model, setting)._asdict()
    identity = [model.to_dict(), parameter, list(values), x0, setting.method.describe(), options]

    def compute(path: Path | None) -> Any:
        return bifurcation(
            model,
            parameter,
            values,
            x0,
            method=setting.method,
            workers=setting.workers,
            resume=path,
            progress=setting.progress,
            **options,
        )

    return _cached(identity, setting, compute)


def sweep_results(
    name: str, function: Callable[[Any], Any], model: SliderOnBelt, over: dict[str, Any], setting: Setting
) -> Any:
    """`fl.sweep` of a function; `name` identifies it and all that it depends on except the model."""
    model = setting.adapt_model(model)
    identity = [name, model.to_dict(), {key: list(values) for key, values in over.items()}]

    def compute(path: Path | None) -> Any:
        options: dict[str, Any] = {"workers": setting.workers, "progress": setting.progress}
        return sweep(model, function, over, resume=path, **options)

    return _cached(identity, setting, compute)


def cea_and_motions(
    model: SliderOnBelt, values: Array, options: SteadyStateKeywords, f_max: float, setting: Setting
) -> CEAAgainstMotion:
    """`fl.cea_against_motion` over mu_k, from rest."""
    model = setting.adapt_model(model)
    about = f"CEA against motion up to {f_max} Hz {options}"

    def compute(path: Path | None) -> Any:
        how = {"workers": setting.workers, "progress": setting.progress, "resume": path}
        return cea_against_motion(model, "mu_k", values, "rest", f_max=f_max, **options, **how)

    return _cached([about, model.to_dict(), list(values)], setting, compute)


def _cached(identity: Any, setting: Setting, compute: Callable[[Path | None], Any]) -> Any:
    key = hashlib.sha256(json.dumps(identity, sort_keys=True).encode()).hexdigest()[:16]
    if key not in CACHE:
        path = None
        if setting.resume is not None:
            setting.resume.mkdir(parents=True, exist_ok=True)
            path = setting.resume / f"{key}.jsonl"
        CACHE[key] = compute(path)
    return CACHE[key]


def model_with_contact(k_nl: float, geometry: bool = True) -> Any:
    """The usual model with another contact, with or without the geometrical nonlinearity (GN)."""
    model = USUAL.replace(k_nl=k_nl)
    return model if geometry else model.without("geometry")


def example_steady_states(start: str, setting: Setting) -> Any:
    """Fig. 7: mu_k 0.3, 1.4 and 2.5."""
    return steady_states(USUAL, EXAMPLES, setting, start, section=STICK_SECTION)


def sweep_from_rest(k_nl: float, setting: Setting, geometry: bool = True) -> Any:
    """Figs 9, 11 and 13: from rest, against mu_k."""
    if k_nl == USUAL.k_nl and geometry:
        values = mu_k(setting)
    else:
        values = mu_k_coarse(setting, *(MU_K_NAMED_IN_TEXT if geometry else MU_K_SMALL))
    return steady_states(model_with_contact(k_nl, geometry), values, setting, section=STICK_SECTION)


def sweep_from_near(k_nl: float, setting: Setting, geometry: bool = True) -> Any:
    """Figs 10, 12 and 14: from near the equilibrium, against mu_k."""
    return steady_states(
        model_with_contact(k_nl, geometry), mu_k_near(setting), setting, "near", section=STICK_SECTION
    )


def preload_sweep(geometry: bool, setting: Setting) -> Any:
    """Fig. 15: against the preload."""
    model = model_with_contact(1e7, geometry).replace(mu_k=MU_K_PRELOAD)
    return steady_states(model, preloads(setting), setting, parameter="F", section=STICK_SECTION)


def stiff_model(nonsmooth: bool) -> Any:
    """The model of Figs 16 to 18, with or without the non-smooth behaviours."""
    return STIFF if nonsmooth else STIFF.without("nonsmooth")


def stiff_sweep(nonsmooth: bool, setting: Setting, start: str = "rest") -> Any:
    """Fig. 17: against mu_k."""
    values = mu_k_stiff(setting) if nonsmooth else mu_k_sliding(setting)
    return steady_states(
        stiff_model(nonsmooth),
        values,
        setting,
        start,
        section=STICK_SECTION if nonsmooth else TURNING_SECTION,
    )


def sliding_sweep_downwards(setting: Setting) -> Any:
    """The sliding-only model of Fig. 17b along its vibration, from mu_k = 3 down."""
    values = mu_k_sliding(setting)[::-1]
    return steady_states(stiff_model(False), values, setting, "continue", section=TURNING_SECTION)


def steady_state_of(model: SliderOnBelt, setting: Setting, section: Any = STICK_SECTION) -> SteadyState:
    """The steady state of one model from rest, with its run; a figure and its claim share it."""
    model = setting.adapt_model(model)
    options: dict[str, Any] = times_of(model, setting)._asdict() | {"tolerance": setting.tolerance}
    identity = ["one steady state", model.to_dict(), section, setting.method.describe(), options]

    def compute(_: Path | None) -> SteadyState:
        how: dict[str, Any] = {"method": setting.method, "progress": setting.progress}
        return steady_state(model, section=section, **options, **how)

    return _cached(identity, setting, compute)


def is_vibration(sweep: Bifurcation) -> NDArray[np.bool_]:
    """Where a sweep found a vibration, periodic or not, as booleans."""
    return np.isin(sweep.kinds, (MotionKind.PERIODIC, MotionKind.NON_PERIODIC))


def is_kind(sweep: Bifurcation, kind: str) -> NDArray[np.bool_]:
    """Where a sweep found this kind of motion, as booleans."""
    return np.array(sweep.kinds) == kind


def in_range(sweep: Bifurcation, first: float, last: float, *, open_end: bool = False) -> NDArray[np.bool_]:
    """Which values lie in [first, last], or in [first, last)."""
    return (sweep.values >= first - GRID_TOLERANCE) & (
        sweep.values < last + (-GRID_TOLERANCE if open_end else GRID_TOLERANCE)
    )


def intervals_text(sweep: Bifurcation) -> str:
    """ "equilibrium 0.05 to 0.35, periodic 0.4 to 3"; where they alternate often, how often each."""
    groups = [(kind, [v for _, v in group]) for kind, group in groupby(zip(sweep.kinds, sweep.values), _kind)]
    if len(groups) <= MAX_INTERVALS:
        return ", ".join(f"{kind} {_range_text(values)}" for kind, values in groups)
    return ", ".join(_share_text(sweep, kind) for kind in dict.fromkeys(sweep.kinds))


def count(held: Any) -> str:
    """ "3 of 10"."""
    return f"{int(np.sum(held))} of {len(held)}"


def _kind(pair: tuple[str, float]) -> str:
    return pair[0]


def _range_text(values: list[float]) -> str:
    return f"{values[0]:g}" if len(values) == 1 else f"{values[0]:g} to {values[-1]:g}"


def _share_text(sweep: Bifurcation, kind: str) -> str:
    of_kind = is_kind(sweep, kind)
    values = sweep.values[of_kind]
    return f"{kind} at {count(of_kind)} values ({_range_text(values.tolist())})"


def regimes(sweep: Bifurcation) -> list[tuple[str, int]]:
    """Kind of every motion that has settled, and the onsets of stick in its period if it has one."""
    steady = is_vibration(sweep) | is_kind(sweep, MotionKind.EQUILIBRIUM)
    return [(kind, int(n)) for kind, n, is_steady in zip(sweep.kinds, sweep.onsets, steady) if is_steady]


def regime_changes(sweep: Bifurcation) -> int:
    """How often neighbours along a sweep are of different regimes."""
    each = regimes(sweep)
    return sum(a != b for a, b in pairwise(each))


def agrees_with_printed(value: float, printed: str) -> bool:
    """Whether a value rounds to the number printed."""
    return abs(value - float(printed)) <= half_unit(printed) * ROUNDING_MARGIN


def half_unit(printed: str) -> float:
    """Half a unit of the last digit."""
    return 0.5 * 10.0 ** -len(printed.partition(".")[2])


def list_text(values: Iterable[float]) -> str:
    """Numbers in brackets, as the paper prints a state."""
    return f"[{', '.join(f'{value:.6f}' for value in values)}]"
