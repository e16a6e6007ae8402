"""Random mechanisms, each from its seed and number alone, in any units."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import pi, sqrt
from random import Random
from typing import Any

from tests.doors.mechanism import NOTHING, Law, Mechanism, Rub, Touch, Wall

CURVES = (
    *("Coulomb", "Coulomb", "ExponentialDecay", "Stribeck", "Smooth", "Bump", "Edge", "TwoLayers"),
    *("Quotient", "Power"),
)


@dataclass(frozen=True)
class Units:
    """How many of the case's units a metre, a second and a kilogram are."""

    length: float = 1.0
    time: float = 1.0
    mass: float = 1.0


SI = Units()


@dataclass
class Maker:
    """Draws numbers in SI, and writes them in the units asked for."""

    rng: Random
    units: Units

    def value(self, x: float, L: float = 0, T: float = 0, M: float = 0) -> float:
        """A number of the dimension L, T, M in the units."""
        units = self.units
        return x * units.length**L * units.time**T * units.mass**M

    def number(self, x: float, L: float = 0, T: float = 0, M: float = 0) -> str:
        """The same as text."""
        return f"({self.value(x, L, T, M)!r})"

    def about(self, x: float, L: float = 0, T: float = 0, M: float = 0) -> str:
        """A number near x."""
        return self.number(short(x * log(self.rng, 0.5, 2.0)), L, T, M)

    def maybe(self, chance: float) -> bool:
        """True with a chance."""
        return self.rng.random() < chance


def short(x: float) -> float:
    """Three digits of a number."""
    return float(f"{x:.3g}")


def log(rng: Random, low: float, high: float) -> float:
    """A number between two, uniform in its logarithm."""
    return low * (high / low) ** rng.random()


def generate(seed: int, number: int, units: Units = SI) -> Mechanism:
    """Case `number` of a seed; the same in all units."""
    make = Maker(Random(f"door {seed} {number}"), units)
    rng = make.rng
    n = rng.choice([1, 1, 2, 2, 2, 3, 4])
    forced = make.maybe(0.6)
    Omega = short(log(rng, 0.2, 4.0)) if forced else 0.0
    kinetic = kinetic_energy(make, n, forced, Omega)
    potential = potential_energy(make, n, forced)
    dissipation = " + ".join(f"{make.about(0.05, T=-1, M=1)}*v{i + 1}**2/2" for i in range(n))
    loads = tuple(load(make, forced and (i == 0 or make.maybe(0.3))) for i in range(n))
    contacts = tuple(contact(make, n, forced, Omega) for _ in range(rng.choice([0, 1, 1, 1, 2, 2, 3])))
    walls = [c for c in contacts if isinstance(c, Wall)]
    if len(walls) > 1:  # one at most, as two close at one instant by design only
        contacts = tuple(c for c in contacts if c is walls[0] or not isinstance(c, Wall))
    x0 = tuple(make.value(short(rng.uniform(-1, 1)), L=1) for _ in range(n))
    x0 += tuple(make.value(short(rng.uniform(-1, 1)), L=1, T=-1) for _ in range(n))
    return Mechanism(
        n,
        kinetic,
        potential,
        dissipation,
        loads,
        make.value(Omega, T=-1),
        contacts,
        x0,
        period=make.value(2 * pi / max(3.0, Omega), T=1),
    )


def kinetic_energy(make: Maker, n: int, forced: bool, Omega: float) -> str:
    """Masses; some depend on a place or on time, some bases move."""
    terms = []
    for i in range(1, n + 1):
        m = make.about(1.0, M=1)
        kind = make.rng.choice(["plain", "plain", "place", "other place", "time", "base"])
        if kind == "place":
            m += f"*(1 + {short(make.rng.uniform(0.05, 0.5))}*sin({make.about(1.5, L=-1)}*q{i}))"
        elif kind == "other place" and n > 1:
            j = make.rng.choice([k for k in range(1, n + 1) if k != i])
            m += f"*(1 + {short(make.rng.uniform(0.05, 0.5))}*cos({make.about(1.2, L=-1)}*q{j}))"
        elif kind == "time" and forced:
            m += f"*(1 + {short(make.rng.uniform(0.05, 0.4))}*cos(p))"
        v = f"v{i}"
        if kind == "base" and forced:
            v = f"(v{i} - {make.about(0.3 * Omega, L=1, T=-1)}*sin(p))"
        terms.append(f"{m}*{v}**2/2")
    if n > 1 and make.maybe(0.4):
        turn = f"*cos({make.about(1.0, L=-1)}*(q1 - q2))" if make.maybe(0.5) else ""
        terms.append(f"{make.number(short(make.rng.uniform(-0.3, 0.3)), M=1)}*v1*v2{turn}")
    return " + ".join(terms)


def potential_energy(make: Maker, n: int, forced: bool) -> str:
    """Springs to the ground and between neighbours; some cubic, some that change with time; pendulums."""
    terms = []
    for i in range(1, n + 1):
        k = make.about(2.0, T=-2, M=1)
        if forced and make.maybe(0.2):
            k += f"*(1 + {short(make.rng.uniform(0.05, 0.3))}*sin(p))"
        terms.append(f"{k}*q{i}**2/2")
        if make.maybe(0.3):
            terms.append(f"{make.about(1.0, L=-2, T=-2, M=1)}*q{i}**4/4")
        if make.maybe(0.25):
            terms.append(f"{make.about(1.0, L=2, T=-2, M=1)}*cos({make.about(1.5, L=-1)}*q{i})")
    terms += [f"{make.about(1.0, T=-2, M=1)}*(q{i} - q{i + 1})**2/2" for i in range(1, n) if make.maybe(0.7)]
    return " + ".join(terms)


def load(make: Maker, forced: bool) -> str:
    """A harmonic, sometimes with a higher one."""
    if not forced:
        return NOTHING
    text = f"{make.about(1.0, L=1, T=-2, M=1)}*cos(p)"
    if make.maybe(0.3):
        text += f" + {make.about(0.5, L=1, T=-2, M=1)}*sin({make.rng.randint(2, 9)}*p)"
    return text


def law(make: Maker) -> Law:
    """A friction law with its own layers."""
    rng = make.rng
    mu_k = short(rng.uniform(0.05, 0.6))
    mu_s = short(mu_k + rng.uniform(0.02, 0.6))
    name = rng.choice(CURVES)
    speeds = {
        "v_s": make.value(short(log(rng, 1e-3, 0.5)), L=1, T=-1),
        "v_2": make.value(short(log(rng, 1e-2, 0.5)), L=1, T=-1),
        "u_0": make.value(short(rng.uniform(0.1, 1.0)), L=1, T=-1),
    }
    shares = {"h": short(rng.uniform(0.0, 0.5) * (mu_s - mu_k)), "n": short(rng.uniform(0.1, 0.9))}
    uses = {
        "Coulomb": (),
        "ExponentialDecay": ("v_s",),
        "Stribeck": ("v_s",),
        "Smooth": ("v_s",),
        "Bump": ("v_s", "u_0", "h"),
        "Edge": ("v_s", "u_0"),
        "TwoLayers": ("v_s", "v_2"),
        "Quotient": ("v_s",),
        "Power": ("v_s", "n"),
    }[name]
    own = tuple((key, value) for key, value in (speeds | shares).items() if key in uses)
    if name == "Stribeck":
        own += (("mu_v", 0.0),)
    return Law(name, (("mu_k", mu_k), ("mu_s", mu_s), *own))


def direction(make: Maker, n: int, letter: str) -> str:
    """A combination of coordinates or velocities."""
    i = make.rng.randint(1, n)
    if n > 1 and make.maybe(0.3):
        j = make.rng.choice([k for k in range(1, n + 1) if k != i])
        return f"({letter}{i} {make.rng.choice('+-')} {short(make.rng.uniform(0.2, 1.2))}*{letter}{j})"
    return f"{letter}{i}"


def belt(make: Maker, forced: bool) -> str:
    """The speed of a belt, which may change with time."""
    if make.maybe(0.3):
        return make.number(0.0, L=1, T=-1)
    speed = make.number(short(make.rng.choice([-1, 1]) * log(make.rng, 0.1, 1.0)), L=1, T=-1)
    if forced and make.maybe(0.2):
        speed += f"*(1 + {short(make.rng.uniform(0.1, 0.8))}*cos(p))"
    return speed


def contact(make: Maker, n: int, forced: bool, Omega: float) -> Any:
    """A contact of any kind."""
    kind = make.rng.choice(["rub", "rub", "rub", "touch", "wall", "wall"])
    return KINDS[kind](make, n, forced, Omega)


def rub(make: Maker, n: int, forced: bool, Omega: float) -> Rub:
    """Friction with a given normal force; its lever may depend on a place, but never vanishes."""
    moved = direction(make, n, "v")
    if make.maybe(0.25):
        moved = f"(1 + {short(make.rng.uniform(0.1, 0.5))}*sin({make.about(1.0, L=-1)}*q1))*{moved}"
    normal = make.about(1.0, L=1, T=-2, M=1)
    if forced and make.maybe(0.3):
        normal += f"*(1 + {short(make.rng.uniform(0.1, 0.8))}*cos(p))"
    return Rub(f"{belt(make, forced)} - {moved}", normal, law(make))


def touch(make: Maker, n: int, forced: bool, Omega: float) -> Touch:
    """A contact that may be lost; its base may move."""
    i, j = make.rng.randint(1, n), make.rng.randint(1, n)
    base = f" + {make.about(0.3, L=1)}*cos(p)" if forced and make.maybe(0.3) else ""
    k3 = make.rng.choice([0.0, 1.0])
    return Touch(
        f"{belt(make, forced)} - v{j}",
        f"q{i} + {make.number(short(make.rng.uniform(-0.3, 0.5)), L=1)}{base}",
        make.value(short(log(make.rng, 1.0, 20.0)), T=-2, M=1),
        make.value(k3, L=-2, T=-2, M=1),
        law(make),
    )


def wall(make: Maker, n: int, forced: bool, Omega: float) -> Wall:
    """A stop beyond the start; it may move, or be corrugated."""
    i, sign = make.rng.randint(1, n), make.rng.choice("+-")
    distance, wave = f"{make.number(short(make.rng.uniform(1.1, 1.8)), L=1)} {sign} q{i}", 0.0
    if forced and make.maybe(0.3):
        distance += f" + {make.about(0.1, L=1)}*sin(p)"
    if n > 1 and i != 1 and make.maybe(0.4):
        wave = make.value(short(log(make.rng, 0.01, 0.5)), L=1)
        distance += f" + {make.number(0.1 * sqrt(0.01), L=1)}*sin(q1*{2 * pi / wave!r})"
    return Wall(distance, short(make.rng.choice([0.0, 0.5, make.rng.uniform(0.2, 0.95), 1.0])), wave)


KINDS: dict[str, Callable[..., Any]] = {"rub": rub, "touch": touch, "wall": wall}
