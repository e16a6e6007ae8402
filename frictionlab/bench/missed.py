"""One landing that a fixed step does not see, and what it does to the error: scene D."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from frictionlab.analysis.markdown import markdown
from frictionlab.analysis.simulate import simulate
from frictionlab.hybrid.methods import Method
from frictionlab.hybrid.rk4 import RK4
from frictionlab.hybrid.taylor import Taylor
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.models import SliderOnBelt

MODEL = SliderOnBelt(mu_k=1.4)  # Eq. (13) as printed: short hops after each landing
T_END = 0.14  # s
NEAR = np.linspace(-0.1e-3, 0.78e-3, 2001)  # s after the first landing
WHOLE = np.linspace(-10e-3, 40e-3, 1000)  # not at the landing itself
MOMENTS = (-1e-3, 1e-3, 30e-3)
REFERENCE = Taylor(order=34, chatter=1e-9)
METHODS: tuple[tuple[str, Method], ...] = (
    ("fixed step 0.2 ms", RK4(step=2e-4)),
    ("fixed step 0.02 ms", RK4(step=2e-5)),
    ("every event located, tol 1e-6", Taylor(tol=1e-6)),
    ("every event located, tol 1e-15", Taylor()),
)


@dataclass(frozen=True, eq=False)
class Course:
    """What one method makes of the hops after the first landing; times count from the landing.

    Parameters
    ----------
    name : str
    height : array
        Height of the slider over the belt in m at the times NEAR.
    ends : array
        Ends of its steps within NEAR in s, and the heights there in m: two rows.
    error : array
        Largest error of a state at the times WHOLE.
    moments : tuple of float
        The same at MOMENTS.
    landings : int
        Within NEAR, the first left out.
    """

    name: str
    height: np.ndarray
    ends: np.ndarray
    error: np.ndarray
    moments: tuple[float, ...]
    landings: int


@dataclass(frozen=True, eq=False)
class Missed:
    """Time of the first landing in s, length of the first hop in s, largest state of the motion, methods."""

    landing: float
    hop: float
    size: float
    courses: tuple[Course, ...]


def missed(methods: Sequence[tuple[str, Method]] = METHODS) -> Missed:
    """Run the methods and compare them with one of higher order."""
    exact = simulate(MODEL, T_END, method=REFERENCE, progress=False)
    landing, next_landing = exact.events.t[exact.events.source == "separation"][:2].tolist()
    courses = tuple(_course(name, method, exact, landing) for name, method in methods)
    size = float(np.abs(exact(landing + WHOLE)).max())
    return Missed(landing, next_landing - landing, size, courses)


def _course(name: str, method: Method, exact: Trajectory, landing: float) -> Course:
    run = simulate(MODEL, T_END, method=method, progress=False)

    def error(times: np.ndarray) -> np.ndarray:
        return np.abs(run(landing + times) - exact(landing + times)).max(axis=1)

    landings = run.events.t[run.events.source == "separation"]
    ends, landings = (times - landing for times in (run.raw.step_times[:, 0], landings))
    # The first landing is there by every method, earlier or later by its own error.
    later = (landings > 1e-6) & (landings < NEAR[-1])
    ends = ends[(ends > NEAR[0]) & (ends < NEAR[-1])]
    return Course(
        name,
        -run.output("gap", landing + NEAR),
        np.array([ends, -run.output("gap", landing + ends)]),
        error(WHOLE),
        tuple(error(np.array(MOMENTS)).tolist()),
        int(later.sum()),
    )


def table(found: Missed) -> str:
    """The methods as Markdown: the error around the landing."""
    times = " | ".join(f"error {1e3 * abs(t):g} ms {'before' if t < 0 else 'after'}" for t in MOMENTS)
    errors = [" | ".join(f"{error:.0e}" for error in course.moments) for course in found.courses]
    lines = (f"{c.name} | {error} | {c.landings}" for c, error in zip(found.courses, errors, strict=True))
    return markdown(f"method | {times} | landings seen in the upper panel", lines)
