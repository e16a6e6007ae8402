"""An event-driven integrator that shares nothing with the package: Runge-Kutta of order 8, Brent's method.

What a system is, see :class:`System`.  Two things a plain integrator gets wrong are taken care of here.  A
layer of the friction law, such as exp(-(u/v_s)^2), is invisible to the error estimate while it is flat: so
the sliding speed u may not change by more than a share of its distance from a layer within a step.  And dense
output is less exact than a step: so an event that was found in it is settled by steps that end there.
"""

from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from tests.reference.dop853 import Step, dense, error, step

GRID = np.linspace(0.0, 1.0, 9)  # where the guards are looked at within a step
START = 1e-3  # first step of a mode, in periods
LAYER = (
    0.5  # share of the distance from a layer (or of its width) that the sliding speed may change in a step
)
ROUNDING = 1e-11  # a guard below this, by its scale, is zero when a mode begins
CAP = 25_000  # steps after which a run is given up: some eight seconds


class Undecided(Exception):
    """The reference cannot go on: too many steps, or no mode that lasts."""


class Happening(NamedTuple):
    """An event: time, mode before and after, speed of an impact (else infinity)."""

    t: float
    source: str
    target: str
    speed: float = np.inf


class Next(NamedTuple):
    """What follows an event: mode, state; of an impact its speed, where impacts pile up the time until they
    are over, and a first step well below the next flight.
    """

    mode: Any
    z: np.ndarray
    speed: float = np.inf
    delay: float = 0.0
    first: float = np.inf


class System:
    """What is integrated.  States are coordinates, then velocities, then `further` ones; a mode has one word
    for each contact.

    `guards` are positive while a mode lasts, one row each; they take one state (n,) or many (n, samples).
    """

    period: float = 1.0
    layers: tuple[tuple[float, float], ...] = ()  # centre and width in the sliding speed
    further: int = 0

    def start(self, z: np.ndarray) -> tuple[str, ...]:
        """Mode at t = 0."""
        raise NotImplementedError

    def rate(self, mode: Any, t: float, z: np.ndarray) -> Any:
        """z' in a mode."""
        raise NotImplementedError

    def guards(self, mode: Any, t: Any, z: Any) -> np.ndarray:
        """Event functions of a mode."""
        raise NotImplementedError

    def leave(self, mode: Any, guard: int, t: float, z: np.ndarray) -> Next:
        """What follows where a guard has come to zero."""
        raise NotImplementedError

    def grouped(self, amounts: np.ndarray) -> np.ndarray:
        """The largest of the amounts (..., states) of coordinates, of velocities, and each further one."""
        half = (amounts.shape[-1] - self.further) // 2
        parts = amounts[..., :half], amounts[..., half : 2 * half]
        most = [np.repeat(part.max(axis=-1, keepdims=True), half, axis=-1) for part in parts]
        return np.concatenate([*most, amounts[..., 2 * half :]], axis=-1)

    def speeds(self, mode: Any, z: np.ndarray) -> list[float]:
        """Sliding speeds, which the friction law depends on; linear in the velocities."""
        return []

    def longest_step(self, mode: Any, z: np.ndarray, rate: np.ndarray) -> float:
        """Longest step (s) in which what only the guards see, as a corrugated ground, is not jumped over."""
        return np.inf

    def laws(self, mode: Any, t: Any, z: Any) -> dict[str, Any]:
        """What must not be negative in a mode, by name, for many states: for checks of other runs."""
        raise NotImplementedError


@dataclass
class Motion:
    """What a run found: events, states at the times asked for, the end."""

    events: list[Happening] = field(default_factory=list)
    t: list[float] = field(default_factory=list)
    states: list[np.ndarray] = field(default_factory=list)
    steps: int = 0


@dataclass
class Walker:
    """A run in progress."""

    system: System
    times: np.ndarray
    rtol: float
    t: float
    z: np.ndarray
    mode: Any
    size: np.ndarray
    cap: int
    found: Motion = field(default_factory=Motion)
    fresh: bool = True
    repeats: int = 0  # events at one instant
    h: float = 0.0

    def rate(self, t: float, z: np.ndarray) -> np.ndarray:
        return np.array(self.system.rate(self.mode, t, z))

    def scale(self) -> np.ndarray:
        """Largest coordinate and velocity so far, each for its group; 1e-3 of it where all began at zero."""
        self.size = np.maximum(self.size, self.system.grouped(np.abs(self.z)))
        return self.rtol * np.maximum(self.size, 1e-3)


def integrate(system: System, z: Any, times: Any, rtol: float = 1e-13, cap: int = CAP) -> Motion:
    """Run from z at 0 to the last of the ascending `times`, at which states are kept.

    Raises
    ------
    Undecided
        Where it takes too long, or a mode does not last.
    """
    z, times = np.array(z, dtype=float), np.asarray(times, dtype=float)
    run = Walker(system, times, rtol, 0.0, z, system.start(z), np.zeros(len(z)), cap)
    run.h = START * system.period
    with np.errstate(all="ignore"):  # a step may be tried that is far too long
        while run.t < times[-1]:
            _advance(run)
    for _ in range(len(times) - len(run.found.t)):
        _keep(run, float(times[-1]), run.z)
    return run.found


def _advance(run: Walker) -> None:
    done, at = _accepted(run)
    where = _first(run, done, at)
    if where is None:
        _sample(run, done, at, 1.0)
        run.t, run.z, run.fresh = done.t + done.h, done.z_end, False
        return
    guard, x = where
    done = _settled(run, done, guard, x)
    _sample(run, done, at, x)
    _event(run, guard, done)


def _accepted(run: Walker) -> tuple[Step, Any]:
    """A step whose error is below the tolerance and which jumps over no layer; sets the next length."""
    f = run.rate(run.t, run.z)
    h = min(run.h, _layer_limit(run, f), run.system.longest_step(run.mode, run.z, f))
    while True:
        run.found.steps += 1
        if run.found.steps > run.cap or h < 1e-15 * max(run.t, run.system.period):
            raise Undecided(f"at {run.t!r} s in {run.mode}, step {h!r} s")
        left = run.times[-1] - run.t
        done = step(run.rate, run.t, run.z, f, min(h, left))
        size = error(done, run.scale())
        if not size < 1.0:
            h = done.h * (max(0.2, 0.9 * size ** (-1 / 8)) if np.isfinite(size) else 0.1)
        elif _jumps(run, done):
            h = done.h / 2
        else:
            run.h = done.h * min(5.0, 0.9 * size ** (-1 / 8) if size else 5.0)
            return done, dense(run.rate, done)


def _layer_limit(run: Walker, f: np.ndarray) -> float:
    system = run.system
    if not system.layers:
        return np.inf
    now, then = system.speeds(run.mode, run.z), system.speeds(run.mode, run.z + f)
    rooms = [_room(system, u) / abs(w - u) for u, w in zip(now, then, strict=True) if w != u]
    return LAYER * min(rooms, default=np.inf)


def _room(system: System, u: float) -> float:
    return min(max(abs(u - centre), width) for centre, width in system.layers)


def _jumps(run: Walker, done: Step) -> bool:
    system = run.system
    if not system.layers:
        return False
    pairs = zip(system.speeds(run.mode, done.z), system.speeds(run.mode, done.z_end), strict=True)
    return any(abs(after - before) > 2 * LAYER * _room(system, before) for before, after in pairs)


def _first(run: Walker, done: Step, at: Any) -> tuple[int, float] | None:
    """The first guard that comes to zero in a step, and the share of the step where it does."""
    system, mode = run.system, run.mode
    values = np.atleast_2d(system.guards(mode, done.t + GRID * done.h, at(GRID)))
    found = []
    for i, g in enumerate(values):

        def along(x: float, i: int = i) -> float:
            return float(system.guards(mode, done.t + x * done.h, at(x))[i])

        zero = run.fresh and abs(g[0]) <= ROUNDING * max(1.0, np.abs(values).max())
        if zero and (g[1:] <= 0).all() and g[-1] < 0:  # due at the very start: another event at this instant
            if run.repeats > 2 * len(values):
                raise Undecided(f"{mode} at {run.t!r} s does not last")
            return i, 0.0
        root = _root(along, g, 1 if zero else 0)
        if root is not None:
            found.append((root, i))
    return None if not found else (min(found)[1], min(found)[0])


def _root(along: Any, g: np.ndarray, first: int) -> float | None:
    """First zero of a guard with the values g on the grid; `first` = 1 leaves out a zero at the start."""
    for j in range(first, len(g)):
        dip = _dip(along, g, j, first)
        if dip is not None:
            return _brent(along, GRID[j - 1], dip)
        if g[j] <= 0:
            return _brent(along, GRID[j - 1], GRID[j]) if j > 0 and g[j - 1] > 0 else float(GRID[j])
    return None


def _brent(along: Any, left: float, right: float) -> float:
    root: Any = brentq(along, left, right, xtol=1e-15)
    return float(root)


def _dip(along: Any, g: np.ndarray, j: int, first: int) -> float | None:
    """Where a guard dips below zero between points of the grid."""
    if not (max(first, 0) < j < len(g) - 1 and 0 < g[j] < min(g[j - 1], g[j + 1])):
        return None
    bend = g[j - 1] - 2 * g[j] + g[j + 1]
    if g[j] - (g[j + 1] - g[j - 1]) ** 2 / (8 * bend) > 0.5 * g[j]:  # the parabola stays well above
        return None
    options, bounds = {"xatol": 1e-10}, (GRID[j - 1], GRID[j + 1])
    low: Any = minimize_scalar(along, bounds=bounds, method="bounded", options=options)
    return float(low.x) if low.fun < 0 else None


def _settled(run: Walker, done: Step, guard: int, x: float) -> Step:
    """The step that ends at the event, corrected by Newton's method on the guard."""
    h = x * done.h
    for _ in range(3 if h else 0):
        done = step(run.rate, done.t, done.z, done.K[0], h)
        t, tiny = done.t + h, 1e-7 * run.system.period
        value = run.system.guards(run.mode, t, done.z_end)[guard]
        further = run.system.guards(run.mode, t + tiny, done.z_end + tiny * done.K[12])[guard]
        slope = (further - value) / tiny
        change = -value / slope if slope < 0 else 0.0
        if abs(change) > 0.01 * max(h, tiny):  # nearly tangential: the root of the dense output has to do
            break
        h = max(h + change, 0.0)
    return step(run.rate, done.t, done.z, done.K[0], h)


def _sample(run: Walker, done: Step, at: Any, x_end: float) -> None:
    """Keep the states at the times asked for, up to the share x_end of the step."""
    whole = done.h / x_end if x_end else 1.0
    while len(run.found.t) < len(run.times) and run.times[len(run.found.t)] <= done.t + done.h:
        t = float(run.times[len(run.found.t)])
        _keep(run, t, done.z_end if t == done.t + done.h else at((t - done.t) / whole))


def _keep(run: Walker, t: float, z: np.ndarray) -> None:
    run.found.t.append(t)
    run.found.states.append(np.array(z))


def _event(run: Walker, guard: int, done: Step) -> None:
    t, source = float(done.t + done.h), run.mode
    after = run.system.leave(run.mode, guard, t, done.z_end)
    run.mode, run.z, run.t, run.fresh = after.mode, np.array(after.z), float(t + after.delay), True
    happening = Happening(run.t, name(source), name(run.mode), float(after.speed))
    last = run.found.events[-1:]
    run.repeats = run.repeats + 1 if done.h == 0 else 0
    if run.repeats and last:  # one event, which leads from where the first began to where the last ends
        happening = last[0]._replace(target=happening.target)
        run.found.events.pop()
    run.found.events.append(happening)
    run.h = min(START * run.system.period, after.first)


def name(mode: tuple[str, ...]) -> str:
    """A mode as text."""
    return " | ".join(mode)
