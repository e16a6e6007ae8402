"""The same mechanism in other words: runs that must not differ."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from tests.doors.generate import SI, Units, generate
from tests.doors.judge import INSTANT, happenings, merged, predict, run_of, states_of
from tests.doors.mechanism import Mechanism, Rub
from tests.reference.hybrid import Happening

UNITS = (Units(1e3, 1e6, 1e-3), Units(1e-6, 1e-3, 1e6), Units(1.0, 1e-6, 1.0), Units(1e9, 1.0, 1e-9))
SAMPLES = 25
Runs = tuple[list[Happening], np.ndarray]
Maker = Callable[..., Mechanism]  # of a case in units


def outcome(one: Mechanism, t_end: float, samples: np.ndarray) -> Runs:
    """Events and states of a run."""
    run = run_of(one, t_end, t_eval=np.union1d(samples, [t_end]))
    at = np.searchsorted(run.t, samples[samples <= run.t[-1]])
    return merged(happenings(run), INSTANT * one.period), states_of(one, run.states[at])


def in_other_units(make: Maker, number: int, t_end: float, samples: np.ndarray) -> Runs:
    """The run in other units, its results in SI."""
    units = UNITS[number % len(UNITS)]
    one = make(units)
    events, states = outcome(one, t_end * units.time, samples * units.time)
    sizes = [a.size / b.size for a, b in zip(one.further, make(SI).further, strict=True)]
    scale = np.array([*[units.length] * one.n, *[units.length / units.time] * one.n, *sizes])
    return [e._replace(t=e.t / units.time) for e in events], states / scale


def longer(make: Maker, number: int, t_end: float, samples: np.ndarray) -> Runs:
    """The run as the beginning of one that is three times as long, and of one that ends a little later."""
    one = make(SI)
    return outcome(one, t_end * (3.0 if number % 2 else 1.0371), samples)


def contacts_reversed(make: Maker, number: int, t_end: float, samples: np.ndarray) -> Runs:
    """The run with the contacts in the opposite order, its modes named in the first one."""
    one = make(SI)
    events, states = outcome(replace(one, contacts=one.contacts[::-1]), t_end, samples)
    turned = [e._replace(source=_turned(e.source), target=_turned(e.target)) for e in events]
    return turned, states


def _turned(mode: str) -> str:
    return " | ".join(mode.split(" | ")[::-1])


def split_in_two(make: Maker, number: int, t_end: float, samples: np.ndarray) -> Runs:
    """The run with each given normal force on two pads, half of it on each; modes named by one of them."""
    one = make(SI)
    contacts: list[Any] = []
    for contact in one.contacts:
        half = replace(contact, normal=f"({contact.normal})*0.5") if isinstance(contact, Rub) else contact
        contacts += [half, half] if isinstance(contact, Rub) else [half]
    events, states = outcome(replace(one, contacts=tuple(contacts)), t_end, samples)
    named = [e._replace(source=_joined(e.source, one), target=_joined(e.target, one)) for e in events]
    return [e for e in named if e.source != e.target or "flight" in e.source], states


def _joined(mode: str, one: Mechanism) -> str:
    words, kept = mode.split(" | "), []
    for contact in one.contacts:
        word = words.pop(0)
        if isinstance(contact, Rub):
            other = words.pop(0)
            word = word if word == other else f"{word}/{other}"
        kept.append(word)
    return " | ".join(kept)


def phase_from_elsewhere(make: Maker, number: int, t_end: float, samples: np.ndarray) -> Runs:
    """The run with the origin of the phase moved: p + a starts from -a."""
    one = make(SI)
    shift = 1.234
    turned = replace(
        one,
        kinetic=_shifted(one.kinetic, shift),
        potential=_shifted(one.potential, shift),
        loads=tuple(_shifted(load, shift) for load in one.loads),
        contacts=tuple(
            replace(c, **{n: _shifted(x, shift) for n, x in vars(c).items() if isinstance(x, str)})
            for c in one.contacts
        ),
        further=tuple(
            replace(f, rate=_shifted(f.rate, shift), steep=_shifted(f.steep, shift)) for f in one.further
        ),
        phase=2 * np.pi - shift,
    )
    return outcome(turned, t_end, samples)


def _shifted(text: str, shift: float) -> str:
    return re.sub(r"\bp\b", f"(p + {shift!r})", text)


OTHER_WORDS: dict[str, Callable[..., Runs]] = {
    "longer": longer,
    "other units": in_other_units,
    "contacts reversed": contacts_reversed,
    "split in two": split_in_two,
    "phase from elsewhere": phase_from_elsewhere,
}


def applies(name: str, one: Mechanism) -> bool:
    """Whether other words make a difference to a mechanism."""
    if name == "contacts reversed":
        return len(one.contacts) > 1
    if name == "split in two":
        return any(isinstance(c, Rub) for c in one.contacts) and len(one.contacts) < 3
    return name != "phase from elsewhere" or one.frequency != 0.0


def complaint(name: str, seed: int, number: int, t_end: float, generator: Any = generate) -> str:
    """What differs in other words, up to where runs nearby part; nothing if nothing does."""
    make = partial(generator, seed, number)
    one = make(SI)
    known = predict(one, t_end)
    horizon = known.horizon
    samples = known.motion.t[known.motion.t < horizon]
    if len(samples) < 2:
        return ""
    events, states = outcome(one, t_end, samples)
    others, again = OTHER_WORDS[name](make, number, t_end, samples)
    widths = np.append(known.times, np.full(max(len(events), len(others)), np.inf))
    for i, width in enumerate(widths[: len(known.times)]):
        pair = [some[i] if i < len(some) else None for some in (events, others)]
        if all(e is None or e.t + width >= horizon for e in pair):
            break
        if None in pair or pair[0][1:3] != pair[1][1:3] or abs(pair[0].t - pair[1].t) > width:
            return f"event {i}: {pair[0]} becomes {pair[1]}"
    count = min(len(states), len(again))
    if count < len(samples) and len(again) < len(states):
        return f"it ends at sample {count} of {len(samples)}"
    shares = np.abs(states[:count] - again[:count]) / (known.bounds[:count] + 1e-300)
    i, j = np.unravel_index(shares.argmax(), shares.shape)
    if shares[i, j] <= 1.0:
        return ""
    return f"state {j} at {samples[i]:.6g} is off by {again[i, j] - states[i, j]:.2e}"
