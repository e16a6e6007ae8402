"""Work against precision: scenes x methods, timed in turns, errors against reference states.

Everything is compiled before anything is timed: kernels, and native code of all modes, which a long run
would have.  Times are medians of interleaved runs, so that a slow moment affects all methods.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from functools import cache
from importlib.util import find_spec
from statistics import median
from typing import Any

import numpy as np
import sympy

from frictionlab.automaton import Event, HybridAutomaton, Mode, Reset
from frictionlab.bench.peers import methods
from frictionlab.bench.peers.external import ExternalMethod
from frictionlab.bench.peers.methods import METHODS, BenchMethod
from frictionlab.components import PlasticImpact
from frictionlab.hybrid.codegen.native_cache import native_code
from frictionlab.hybrid.compilation import HAS_MACHINE_CODE
from frictionlab.hybrid.methods.base import Method
from frictionlab.hybrid.methods.taylor import Taylor
from frictionlab.hybrid.problem import Status
from frictionlab.hybrid.solve import solve
from frictionlab.hybrid.tape.packing import program_of
from frictionlab.models import SliderOnBelt
from frictionlab.presentation import markdown_table, three_digits

# Final states by tests/reference/slider_mpmath.py with 40 digits, which shares no code with the package.
REFERENCES = {
    "A": (
        -0.0046648651406953490495,
        -0.0028931216086977638414,
        0.01023096415463402731,
        -0.00688634954732124352,
        -1.6204621954968379352,
        -2.4085346113969358282,
        0.93970366749664052541,
        0.63342002886845983977,
    ),
    "B": (
        -0.01563171764918776,
        -0.024517895028636476,
        0.012009167802481643,
        -0.008104117695891856,
        -0.010657612762793766,
        0.01877919440799427,
        -2.599060934608227,
        -0.8632722791610545,
        0.43483137365689173,
        -0.011811320566702371,
    ),
    "C": (
        0.17854434151613961651,
        -0.022127279676025447113,
        -0.000165603000767934306,
        -3.1770553425094226808e-6,
        0.00023262863799583641996,
        21.313234889960279355,
        5.6071760568312409257,
        1.2365687016297735762,
        -0.0095870326449464019009,
        0.46489169620819055962,
    ),
}
STIFF_SLIDER = SliderOnBelt(mu_k=2.5, k_nl=1e7, F=800.0, k4=5e6, k5=5e6, k6=5e6).without("nonsmooth")
# Smallest and largest correct number of events: the last one of "Coulomb" may fall just after the end.
EVENT_COUNTS = {"A": (885, 885), "B": (886, 886), "Coulomb": (1999, 2000)}
COULOMB_PERIOD = 5 + 2 * np.pi - 2 * np.arctan(2.5)  # of the Coulomb mass on a belt

FULL_GAP_RATE_SLIDER = SliderOnBelt(mu_k=1.4, impact=PlasticImpact(penetration_rate="full"))


@dataclass(frozen=True, eq=False)
class BenchScene:
    """A run with a known final state.

    Parameters
    ----------
    name, text : str
    automaton : HybridAutomaton
    x0 : array
    t_end : float
    reference : callable
        State at `t_end`.
    model : SliderOnBelt or None
        The automaton's model, if it has non-smooth behaviour that can be regularised.
    events : (int, int) or None
        Smallest and largest correct number of events, where it does not depend on the method.
    """

    name: str
    text: str
    automaton: HybridAutomaton
    x0: np.ndarray
    t_end: float
    reference: Callable[[], np.ndarray]
    model: Any = None
    events: tuple[int, int] | None = None

    def missed(self, found: int) -> int | None:
        """Number of missed events; negative where there are too many."""
        return None if self.events is None else min(max(found, self.events[0]), self.events[1]) - found

    def error(self, state: np.ndarray) -> float:
        """Largest deviation of a state."""
        return float(np.abs(state - self.reference()).max())


@cache
def scenes() -> dict[str, BenchScene]:
    """All scenes by name."""
    usual = SliderOnBelt(mu_k=1.4)
    bare = usual.without("cubic", "nonsmooth", "geometry")
    found = (
        _model("A", "stick, slip and separation without the moving load", usual.without("geometry"), 20.0),
        _model("B", "with it, full gap rate", usual.replace(impact=PlasticImpact("full")), 20.0),
        _model("C", "sliding only, stiff, strongly nonlinear", STIFF_SLIDER, 1.0),
        _chatter(usual),
        _coulomb(),
        _linear(bare),
    )
    return {scene.name: scene for scene in found}


def _model(name: str, text: str, model: Any, t_end: float) -> BenchScene:
    automaton = model.automaton()
    rest = np.zeros(len(automaton.states))
    unlike = model if "separation" in model.interface.modes else None
    return BenchScene(
        name, text, automaton, rest, t_end, lambda: np.array(REFERENCES[name]), unlike, EVENT_COUNTS.get(name)
    )


def _chatter(model: Any) -> BenchScene:
    """Chatter, which has no closed form: the reference is the solver itself with another order and a much
    shorter limit of chatter."""
    automaton, rest, t_end = model.automaton(), np.zeros(10), 1.0
    finest = Taylor(order=34, chatter=1e-9)

    @cache
    def reference() -> np.ndarray:
        return solve(automaton, t_end, x0=rest, method=finest, progress=False).final_state

    return BenchScene("D", "Eq. (13) as printed: chatter", automaton, rest, t_end, reference, model)


def _coulomb() -> BenchScene:
    """A thousand cycles of a mass on a belt: m = k = 1, v = 0.2, friction 1 in stick and 0.5 in slip."""
    x, v, belt = sympy.symbols("x v belt", real=True)
    held = Reset({v: belt})
    stick = Mode("stick", (v, sympy.S.Zero), (Event("pulled", 1 - x, ("slip",)),), (belt - v,))
    slip = Mode("slip", (v, sympy.Rational(1, 2) - x), (Event("v_r", belt - v, ("stick",), held),))
    automaton, start = HybridAutomaton((x, v), (stick, slip), {belt: 0.2}, 1), np.array([0.0, 0.2])
    text, t_end = "1000 cycles of stick and slip", 1000 * COULOMB_PERIOD
    return BenchScene("Coulomb", text, automaton, start, t_end, lambda: start, events=EVENT_COUNTS["Coulomb"])


def _linear(model: Any) -> BenchScene:
    """All nonlinearities left out: a linear system, solved by the exponential of its matrix."""
    automaton, t_end = model.automaton(), 10.0
    rest = np.zeros(len(automaton.states))

    @cache
    def reference() -> np.ndarray:
        from scipy.linalg import expm

        flow = sympy.Matrix(automaton.modes[0].flow).subs(dict(automaton.parameters))
        matrix = np.array(flow.jacobian(automaton.states), dtype=float)
        constant = np.array(flow.subs(dict.fromkeys(automaton.states, 0)), dtype=float)
        affine = np.vstack([np.hstack([matrix, constant]), np.zeros(len(rest) + 1)])
        return expm(affine * t_end)[:-1, -1]

    return BenchScene("linear", "all three nonlinearities left out", automaton, rest, t_end, reference)


BASE_METHOD = "frictionlab, tol 1e-15"
SINGLE_RUN_ABOVE = 3.0  # s: a run longer than this is timed once
# s: shorter runs are repeated for so long at each turn, as the first ones find cold caches
TURN_SECONDS = 0.1
SHORT_TURNS = 3  # times as many turns for these, as other work on the machine slows down a turn or two


def warm_up(automaton: HybridAutomaton, method: Method) -> None:
    """Compile what is missing, so that no mode is native code in one run and interpreted in the next."""
    solve(automaton, 1e-9, x0=np.zeros(len(automaton.states)), method=method, progress=False)
    if not isinstance(method, Taylor):
        return
    jets = native_code(program_of(automaton)[0])
    for mode in np.flatnonzero(jets.code.native == 0) if HAS_MACHINE_CODE else ():
        jets.compile(int(mode))


def warm_up_lanes(automaton: HybridAutomaton, method: Taylor) -> None:
    """Compile what the steps of several runs side by side need."""
    native = native_code(program_of(automaton)[0])
    for mode in np.flatnonzero(native.code.lanes == 0) if HAS_MACHINE_CODE else ():
        native.compile_step(int(mode))


def interleaved_medians(runs: Sequence[Callable[[], Any]], repeats: int) -> list[float]:
    """Median wall time of each, after one call to warm up; in turns, so that a slow moment affects all."""
    for run in runs:
        run()
    spent = [[_time_call(run) for run in runs] for _ in range(repeats)]
    return [median(column) for column in zip(*spent, strict=True)]


def _time_call(run: Callable[[], Any]) -> float:
    begin = time.perf_counter()
    run()
    return time.perf_counter() - begin


@dataclass(frozen=True)
class WorkPrecisionRow:
    """A method on a scene: its time, error, steps and missed events; `note` says why a number is missing."""

    scene: str
    family: str
    method: str
    seconds: float | None
    error: float | None
    events: int | None
    missed: int | None
    steps: int | None
    note: str = ""


def measure(
    scene: BenchScene, ways: Sequence[BenchMethod] = METHODS, repeats: int = 3
) -> list[WorkPrecisionRow]:
    """A row for every method; where its package is not installed the row says so."""
    there = [way for way in ways if not way.package or find_spec(way.package)]
    methods = {way.name: way.create(scene.automaton) for way in there}
    for method in methods.values():
        if isinstance(method, ExternalMethod):
            method.prepare(scene.x0)
        else:
            warm_up(scene.automaton, method)
    runs = {name: _time_run(scene, method) for name, method in methods.items()}
    spent = {name: [seconds] if seconds > SINGLE_RUN_ABOVE else [] for name, (_, seconds) in runs.items()}
    for turn in range(SHORT_TURNS * repeats):
        longest = SINGLE_RUN_ABOVE if turn < repeats else TURN_SECONDS
        for name in [name for name in methods if runs[name][1] <= longest]:
            spent[name].append(_time_of_turn(scene, methods[name]))
    rows = [
        _measured_row(scene, way, methods[way.name], runs[way.name][0], spent[way.name])
        if way in there
        else _row_without_package(scene, way)
        for way in ways
    ]
    return rows if scene.model is None else [*rows, _regularised_row(scene)]


def _regularised_row(scene: BenchScene) -> WorkPrecisionRow:
    """The row of the regularised model, whose error is that of the smoothing."""
    state, seconds, steps = methods.run(scene.model, scene.t_end)
    name = "model made smooth, LSODA"
    return WorkPrecisionRow(scene.name, "regularised", name, seconds, scene.error(state), 0, None, steps)


def _row_without_package(scene: BenchScene, way: BenchMethod) -> WorkPrecisionRow:
    return WorkPrecisionRow(
        scene.name, way.family, way.name, *[None] * 5, note=f"{way.package} is not installed"
    )


def _time_run(scene: BenchScene, method: Method) -> tuple[Any, float]:
    begin = time.perf_counter()
    run = solve(scene.automaton, scene.t_end, x0=scene.x0, method=method, progress=False)
    return run, time.perf_counter() - begin


def _time_of_turn(scene: BenchScene, method: Method) -> float:
    """Median time of the runs that fit into a turn, which is equally long for every method."""
    spent: list[float] = []
    while not spent or sum(spent) < TURN_SECONDS:
        spent.append(_time_run(scene, method)[1])
    return median(spent)


def _measured_row(
    scene: BenchScene, way: BenchMethod, method: Method, run: Any, spent: list[float]
) -> WorkPrecisionRow:
    note = "" if run.status is Status.FINISHED else run.status.name.lower().replace("_", " ")
    error = scene.error(run.final_state) if not note else None
    found, steps = len(run.events), method.steps if isinstance(method, ExternalMethod) else run.stats["steps"]
    missed = scene.missed(found)
    return WorkPrecisionRow(
        scene.name, way.family, way.name, median(spent), error, found, missed, steps, note
    )


def as_json(rows: Sequence[WorkPrecisionRow]) -> list[dict[str, Any]]:
    """The rows as dictionaries, for JSON."""
    return [asdict(row) for row in rows]


def work_precision_table(rows: Sequence[WorkPrecisionRow]) -> str:
    """One scene's rows as Markdown; times also as multiples of ours, events where the scene has any."""
    base = next(row.seconds for row in rows if row.method == BASE_METHOD)
    heads = ["method", "wall time", "x", "error", "steps", "per step"]
    heads += ["events", "missed"] if any(row.events for row in rows) else []
    return markdown_table(" | ".join(heads), (" | ".join(_cells(row, base)[: len(heads)]) for row in rows))


PEERS = ("heyoka", "diffrax Dopri8", "CVODE Adams", "scipy DOP853", "scipy LSODA", "PathSim RKDP87", "RK4")
OURS = "frictionlab"


def ratio_table(rows: Sequence[WorkPrecisionRow]) -> str:
    """A row for each tool, a column for each scene: its times divided by ours at no larger error."""
    names = list(dict.fromkeys(row.scene for row in rows))
    lines = (" | ".join([family, *(_ratio_cell(rows, name, family) for name in names)]) for family in PEERS)
    return markdown_table(" | ".join(["tool", *names]), lines)


def _ratio_cell(rows: Sequence[WorkPrecisionRow], scene: str, family: str) -> str:
    here = [row for row in rows if row.scene == scene and row.family == family and row.error is not None]
    ours = [row for row in rows if row.scene == scene and row.family == OURS]
    return ", ".join(_ratio_text(row, ours) for row in sorted(here, key=lambda row: row.error or 0.0))


def _ratio_text(row: WorkPrecisionRow, ours: Sequence[WorkPrecisionRow]) -> str:
    error = row.error or 0.0
    exact = [own.seconds for own in ours if own.seconds and (own.error or 0.0) <= error]
    best = min(ours, key=lambda own: own.error or 0.0).seconds
    text = three_digits((row.seconds or 0.0) / (min(exact) if exact else best or 1.0))
    return text if exact else f"({text})"


def _cells(row: WorkPrecisionRow, base: float | None) -> list[str]:
    if row.seconds is None or base is None:
        return [row.method, row.note, *[""] * 6]
    error = row.note if row.error is None else f"{row.error:.1e}"
    missed = "-" if row.missed is None else str(row.missed)
    times = [f"{three_digits(1e3 * row.seconds)} ms", three_digits(row.seconds / base)]
    each = f"{1e6 * row.seconds / row.steps:.2f} us" if row.steps else "-"
    return [row.method, *times, error, str(row.steps), each, str(row.events), missed]
