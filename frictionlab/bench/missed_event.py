"""One landing that a fixed step does not see, and what it does to the error: scene D."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from frictionlab.analysis.simulate import simulate
from frictionlab.hybrid.methods.base import Method
from frictionlab.hybrid.methods.one_step import RK4
from frictionlab.hybrid.methods.taylor import Taylor
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.models import SliderOnBelt
from frictionlab.presentation import markdown_table

MISSED_EVENT_MODEL = SliderOnBelt(mu_k=1.4)  # Eq. (13) as printed: short hops after each landing
T_END = 0.14  # s
TIMES_NEAR_LANDING = np.linspace(-0.1e-3, 0.78e-3, 2001)  # s after the first landing
TIMES_OF_ERRORS = np.linspace(-10e-3, 40e-3, 1000)  # start a little after the landing itself
TABLE_TIMES = (-1e-3, 1e-3, 30e-3)
REFERENCE = Taylor(order=34, chatter=1e-9)
COMPARED_METHODS: tuple[tuple[str, Method], ...] = (
    ("fixed step 0.2 ms", RK4(step=2e-4)),
    ("fixed step 0.02 ms", RK4(step=2e-5)),
    ("every event located, tol 1e-6", Taylor(tol=1e-6)),
    ("every event located, tol 1e-15", Taylor()),
)


@dataclass(frozen=True, eq=False)
class MethodResult:
    """The hops after the first landing as one method computes them; times count from the landing.

    Parameters
    ----------
    name : str
    height : array
        Height of the slider over the belt in m at the times TIMES_NEAR_LANDING.
    ends : array
        Ends of its steps within TIMES_NEAR_LANDING in s, and the heights there in m: two rows.
    error : array
        Largest error of a state at the times TIMES_OF_ERRORS.
    moments : tuple of float
        The same at TABLE_TIMES.
    landings : int
        Within TIMES_NEAR_LANDING, the first left out.
    """

    name: str
    height: np.ndarray
    ends: np.ndarray
    error: np.ndarray
    moments: tuple[float, ...]
    landings: int


@dataclass(frozen=True, eq=False)
class MissedEvent:
    """Time of the first landing in s, length of the first hop in s, largest state of the motion, methods."""

    landing: float
    hop: float
    size: float
    results: tuple[MethodResult, ...]


def missed_event(methods: Sequence[tuple[str, Method]] = COMPARED_METHODS) -> MissedEvent:
    """Run the methods and compare them with one of higher order."""
    exact = simulate(MISSED_EVENT_MODEL, T_END, method=REFERENCE, progress=False)
    landing, next_landing = exact.events.t[exact.events.source == "separation"][:2].tolist()
    results = tuple(_method_result(name, method, exact, landing) for name, method in methods)
    size = float(np.abs(exact(landing + TIMES_OF_ERRORS)).max())
    return MissedEvent(landing, next_landing - landing, size, results)


def _method_result(name: str, method: Method, exact: Trajectory, landing: float) -> MethodResult:
    run = simulate(MISSED_EVENT_MODEL, T_END, method=method, progress=False)

    def error(times: np.ndarray) -> np.ndarray:
        return np.abs(run(landing + times) - exact(landing + times)).max(axis=1)

    landings = run.events.t[run.events.source == "separation"]
    ends, landings = (times - landing for times in (run.raw.step_times[:, 0], landings))
    # The first landing is there by every method, earlier or later by its own error.
    later = (landings > 1e-6) & (landings < TIMES_NEAR_LANDING[-1])
    ends = ends[(ends > TIMES_NEAR_LANDING[0]) & (ends < TIMES_NEAR_LANDING[-1])]
    return MethodResult(
        name,
        -run.output("penetration", landing + TIMES_NEAR_LANDING),
        np.array([ends, -run.output("penetration", landing + ends)]),
        error(TIMES_OF_ERRORS),
        tuple(error(np.array(TABLE_TIMES)).tolist()),
        int(later.sum()),
    )


def missed_event_table(found: MissedEvent) -> str:
    """The methods as Markdown: the error around the landing."""
    times = " | ".join(f"error {1e3 * abs(t):g} ms {'before' if t < 0 else 'after'}" for t in TABLE_TIMES)
    errors = [" | ".join(f"{error:.0e}" for error in course.moments) for course in found.results]
    lines = (f"{c.name} | {error} | {c.landings}" for c, error in zip(found.results, errors, strict=True))
    return markdown_table(f"method | {times} | landings seen in the upper panel", lines)
