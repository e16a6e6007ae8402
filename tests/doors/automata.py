"""Random automata of users against the reference: layers and waves in guards and flows, resets, any unit.

A state x moves up and down between two bounds, each of which a fast function of an oscillator y makes rough;
a further state w follows x through a layer.  sympy reads the texts and makes functions of numbers for the
reference; nothing else is shared with the package.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, pi
from random import Random
from typing import Any

import numpy as np
import sympy

import frictionlab as fl
from frictionlab.automaton import Event, HybridAutomaton, Mode, Reset
from tests.doors.generate import log, short
from tests.reference.hybrid import Happening, Next, System, Undecided, integrate

STATES = sympy.symbols("x y z w")
MODES = ("down", "up")
PERIODS = 12.0  # how long a run is
NEAR = 1e-11  # share by which starts of the reference differ, to see how errors grow
SLACK, ROUNDING = 100.0, 1e-10  # times that growth, and share of the period, that times may differ
TOO_FAR = 1e-4  # of a period: beyond, the motion is no test


@dataclass(frozen=True)
class Automaton:
    """Texts of flows, guards and resets of the two modes, and what in them is fast.

    Parameters
    ----------
    flows : two times four texts
    guards : two texts
    resets : two mappings of a state's name to a text
    period : float
    layers : tuple of (float, float)
        Centre and width of the layers, in x and y.
    wave : float
        Shortest wavelength in y, infinite for none.
    x0 : tuple of float
    """

    flows: tuple[tuple[str, ...], ...]
    guards: tuple[str, str]
    resets: tuple[dict[str, str], dict[str, str]]
    period: float
    layers: tuple[tuple[float, float], ...]
    wave: float
    x0: tuple[float, ...]

    def automaton(self) -> HybridAutomaton:
        """As a user writes it."""
        modes = []
        for i, name in enumerate(MODES):
            reset = {sympy.Symbol(k): sympy.sympify(v) for k, v in self.resets[i].items()}
            target = (MODES[1 - i],)
            event = Event("bound", sympy.sympify(self.guards[i]), target, *([Reset(reset)] if reset else []))
            modes.append(Mode(name, tuple(map(sympy.sympify, self.flows[i])), (event,)))
        return HybridAutomaton(STATES, tuple(modes))


def generate(seed: int, number: int, unit: float = 1.0) -> Automaton:
    """The automaton of this number; `unit` is how many of its units of time a unit of the case is."""
    rng = Random(f"automaton {seed} {number}")
    period = log(rng, 1e-5, 1e4) * unit
    layers: list[tuple[float, float]] = []
    waves: list[float] = []

    def number_of(low: float, high: float) -> float:
        return short(log(rng, low, high))

    def rough() -> str:
        """A fast function of y, above -0.6."""
        kind, place = rng.choice(("none", "wave", "peak", "step", "power")), short(rng.uniform(-0.4, 0.4))
        if kind == "wave":
            waves.append(number_of(1e-2, 1.0))
            return f"+ 0.3*sin({2 * pi / waves[-1]!r}*y)"
        if kind in ("peak", "step"):
            width = number_of(1e-5, 0.1)
            layers.append((place, width))
            shape = "exp(-((y - {0})/{1})**2)" if kind == "peak" else "tanh((y - {0})/{1})"
            return f"- {short(rng.uniform(0.2, 0.55))}*" + shape.format(place, width)
        return "- 0.3*(2 + y)**1.5/3" if kind == "power" else ""

    frequency, damping = number_of(0.3, 3.0) * 2 * pi, number_of(1e-3, 0.1)
    width = number_of(1e-4, 0.3)
    layers.append((0.0, width))
    flows = []
    for sign in "-+":
        speed, push = number_of(2.0, 6.0), number_of(0.05, 2.0)
        flow = (
            f"{sign}{speed} + {short(rng.uniform(-1, 1))}*y - {number_of(0.05, 0.5)}*x",
            "z",
            f"-{frequency**2!r}*y - {damping * frequency!r}*z {sign} {push}*cos(x)",
            f"{number_of(0.5, 3.0)}*(tanh(x/{width}) - w)",
        )
        flows.append(tuple(f"({text})/{period!r}" for text in flow))
    guards = f"1 + x {rough()}", f"1 - x {rough()}"
    choices: tuple[dict[str, str], ...] = ({}, {}, {"z": "-0.5*z"}, {"w": "w + 0.25"}, {"x": "0.9*x"})
    resets = rng.choice(choices), rng.choice(choices)
    x0 = 0.0, short(rng.uniform(-0.5, 0.5)), 0.0, 0.1
    return Automaton(tuple(flows), guards, resets, period, tuple(layers), min(waves, default=inf), x0)


class Reference(System):
    """The automaton as functions of numbers."""

    def __init__(self, one: Automaton) -> None:
        self.period, self.layers, self.wave, self.resets = one.period, one.layers, one.wave, one.resets
        self._rates = [_numbers(flow) for flow in one.flows]
        self._guards = [sympy.lambdify(STATES, sympy.sympify(text), "numpy") for text in one.guards]

    def start(self, z: np.ndarray) -> tuple[str, ...]:
        return (MODES[0],)

    def rate(self, mode: Any, t: float, z: np.ndarray) -> Any:
        return self._rates[MODES.index(mode[0])](*z)

    def guards(self, mode: Any, t: Any, z: Any) -> np.ndarray:
        return np.array([self._guards[MODES.index(mode[0])](*z)])

    def leave(self, mode: Any, guard: int, t: float, z: np.ndarray) -> Next:
        i, after = MODES.index(mode[0]), np.array(z)
        given = dict(zip(STATES, z, strict=True))
        for name, text in self.resets[i].items():
            after[[str(s) for s in STATES].index(name)] = float(sympy.sympify(text).subs(given))
        return Next((MODES[1 - i],), after)

    def speeds(self, mode: Any, z: np.ndarray) -> list[float]:
        return [z[0], z[1]]

    def longest_step(self, mode: Any, z: np.ndarray, rate: np.ndarray) -> float:
        return min(self.wave / (12 * abs(z[2]) / self.period + 1e-300), self.period / 6)


def _numbers(texts: tuple[str, ...]) -> Any:
    return sympy.lambdify(STATES, [sympy.sympify(text) for text in texts], "numpy")


def motion(one: Automaton, t_end: float, shift: float) -> tuple[list[Happening], np.ndarray]:
    """Events and the final state of the reference, from a start that is shifted by a share."""
    z = np.array(one.x0) + shift * np.array([1.0, 1.0, -1.0, 1.0])
    found = integrate(Reference(one), z, [t_end], 1e-13, 200_000)
    return found.events, found.states[-1]


def judge(one: Automaton, longer: float = 1.0, tol: float = 1e-15) -> str:
    """What differs between the package's run and the reference; "" for nothing, "undecided" for no test.

    The run is `longer` than it is compared, with this tolerance.
    """
    t_end = PERIODS * one.period
    try:
        (events, state), *others = (motion(one, t_end, shift) for shift in (0.0, NEAR, -NEAR))
    except (Undecided, ArithmeticError, ValueError) as reason:
        return f"undecided: {reason}"
    if any([e.target for e in found] != [e.target for e in events] for found, _ in others):
        return "undecided: events depend on the last digits"
    spread = np.zeros(len(events))
    for found, _ in others:
        spread = np.maximum(spread, [abs(a.t - b.t) for a, b in zip(events, found, strict=True)])
    share = max(1.0, tol / 1e-13)
    allowed = SLACK * share * np.maximum.accumulate(spread) + share * ROUNDING * one.period
    if (allowed > TOO_FAR * one.period).any():
        return "undecided: errors grow too far"
    run = fl.solve(
        one.automaton(),
        longer * t_end,
        x0=one.x0,
        mode=MODES[0],
        method=fl.Taylor(tol=tol),
        progress=False,
    )
    return _difference(run, events, allowed, state, others, t_end)


def _difference(run: Any, events: Any, allowed: Any, state: Any, others: Any, t_end: float) -> str:
    if run.t[-1] < t_end:
        return f"ends at {run.t[-1]!r}: {run.status}"
    times = run.events.t[run.events.t <= t_end]
    if abs(len(times) - len(events)) > 0 and not (events and t_end - events[-1].t < allowed[-1]):
        return f"{len(times)} events, {len(events)} expected"
    for i, (t, event) in enumerate(zip(times, events, strict=False)):
        if abs(t - event.t) > allowed[i]:
            return f"event {i} at {t!r}, expected {event.t!r}, to {allowed[i]:.1g}"
    bound = SLACK * max(np.abs(other - state).max() for _, other in others) + allowed.max(initial=0.0) * 1e3
    apart = np.abs(run(t_end) - state).max()
    limit = bound / min(1.0, t_end) + 1e-8
    return "" if apart <= limit else f"final state off by {apart:.1g}, {limit:.1g} allowed"
