"""Random mechanisms with further states: bristles, a temperature, a motor's current, a filter."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from random import Random
from typing import Any

from tests.doors.generate import SI, Maker, Units, belt, generate, log, short
from tests.doors.mechanism import NOTHING, Further, Mechanism, Rub


def generate_further(seed: int, number: int, units: Units = SI) -> Mechanism:
    """Case `number` of a seed with one or two further states; the same in all units."""
    one, make = generate(seed, number, units), Maker(Random(f"further {seed} {number}"), units)
    for _ in range(make.rng.choice([1, 1, 2])):
        one = make.rng.choice(STATES)(make, one)
    return one


def _with(one: Mechanism, state: Further, i: int, force: str = NOTHING, contacts: Any = None) -> Mechanism:
    """The mechanism with a further state, and a force of it on coordinate i."""
    loads = list(one.loads)
    loads[i - 1] = force if loads[i - 1] == NOTHING else f"{loads[i - 1]} + {force}"
    contacts = one.contacts if contacts is None else contacts
    return replace(one, loads=tuple(loads), contacts=contacts, further=(*one.further, state))


def _next_name(one: Mechanism) -> str:
    return f"s{len(one.further) + 1}"


def bristles(make: Maker, one: Mechanism) -> Mechanism:
    """The deflection of bristles that a belt bends: s' = u - k |u| s / g(u), |u| rounded off."""
    s, i, rng = _next_name(one), make.rng.randint(1, one.n), make.rng
    k, g, drop = short(log(rng, 3.0, 30.0)), short(rng.uniform(0.2, 0.8)), short(rng.uniform(0.0, 0.5))
    width, fall = (make.value(short(log(rng, low, 0.3)), L=1, T=-1) for low in (1e-2, 3e-2))
    u = f"({belt(make, one.frequency != 0.0)} - v{i})"
    limit = f"({make.number(g, L=1, T=-2, M=1)}*(1 + {drop}*exp(-({u}/{fall!r})**2)))"
    stiffness = make.number(k, T=-2, M=1)
    rate = f"{u} - {stiffness}*{u}*tanh({u}/{width!r})*{s}/{limit}"
    state = Further(rate, 0.0, make.value(g / k, L=1), u, (0.0, min(width, fall)))
    return _with(one, state, i, f"{stiffness}*{s}")


def temperature(make: Maker, one: Mechanism) -> Mechanism:
    """A temperature that motion raises; friction softens about some value of it, or else a damper does."""
    s, i, rng = _next_name(one), make.rng.randint(1, one.n), make.rng
    rate = f"{make.about(1.0, L=-2, T=1)}*v{i}**2 - {s}*{make.number(short(log(rng, 0.2, 5.0)), T=-1)}"
    centre, width = short(rng.uniform(0.1, 0.6)), short(log(rng, 3e-3, 0.3))
    soft = f"(1 - {short(rng.uniform(0.1, 0.5))}*tanh(({s} - {centre})/{width}))"
    state = Further(rate, short(rng.uniform(0.0, 0.5)), 1.0, s, (centre, width))
    pads = [k for k, contact in enumerate(one.contacts) if isinstance(contact, Rub)]
    if not pads:
        return _with(one, state, i, f"-{make.about(0.1, T=-1, M=1)}*v{i}*{soft}")
    k, contacts = rng.choice(pads), list(one.contacts)
    contacts[k] = replace(contacts[k], normal=f"({contacts[k].normal})*{soft}")
    return replace(one, contacts=tuple(contacts), further=(*one.further, state))


def current(make: Maker, one: Mechanism) -> Mechanism:
    """A motor's current, as the force that it makes: against the voltage that motion induces."""
    s, i = _next_name(one), make.rng.randint(1, one.n)
    voltage = make.about(0.5, L=1, T=-2, M=1) + ("*sin(p)" if one.frequency else "")
    lag = make.number(short(log(make.rng, 0.01, 0.5)), T=1)
    rate = f"({voltage} - {s} - {make.about(0.3, T=-1, M=1)}*v{i})/{lag}"
    return _with(one, Further(rate, 0.0, make.value(0.5, L=1, T=-2, M=1)), i, s)


def filtered(make: Maker, one: Mechanism) -> Mechanism:
    """A place that is seen late, and a force that holds against it."""
    s, rng = _next_name(one), make.rng
    seen, pushed = rng.randint(1, one.n), rng.randint(1, one.n)
    rate = f"(q{seen} - {s})/{make.number(short(log(rng, 0.03, 1.0)), T=1)}"
    state = Further(rate, make.value(short(rng.uniform(-0.5, 0.5)), L=1), make.value(1.0, L=1))
    return _with(one, state, pushed, f"-{make.about(0.3, T=-2, M=1)}*{s}")


STATES: tuple[Callable[[Maker, Mechanism], Mechanism], ...] = (bristles, temperature, current, filtered)
