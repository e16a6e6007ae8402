"""Random cases, each from its seed and number alone."""

from __future__ import annotations

from collections.abc import Callable
from math import factorial, pi
from random import Random
from typing import Any

import frictionlab as fl
from frictionlab.components import FixedLoad, StickSlip
from tests.differential.case import Case
from tests.differential.laws import OWN
from tests.differential.twin import twin

TOLERANCES = [10.0**-k for k in range(3, 17)]
STEPS = 30_000  # of the package, at most, by estimate: low orders with tight tolerances would take millions
STIFF = 3000.0  # rates of decay times length: what a law that rises steeply costs an explicit method
RISING = ("Smooth", "RiseAndFall", "Bump", "Ripple", "Logarithm")  # laws with a branch that damps


def generate(seed: int, number: int, model: str | None = None, exact: bool = False) -> Case:
    """Case `number` of a seed, of any model or the one named; `exact` leaves tolerance and order alone."""
    rng = Random(f"{seed} {number} {model}")
    name = model or rng.choices(list(MAKERS), [weight for weight, _ in MAKERS.values()])[0]
    made, x0 = MAKERS[name][1](rng)
    made = _without_touching(made)
    period = float(twin(made).period)
    t_end = period * _log(rng, 4.0, 30.0)
    t_end = _short(min(t_end, STIFF / stiffness(made)))
    if exact:
        return Case(made, tuple(x0), t_end)
    tol = 1e-15 if rng.random() < 0.35 else rng.choice(TOLERANCES)
    return Case(made, tuple(x0), t_end, tol, order(rng, tol, 2 * pi * t_end / period))


def _without_touching(made: Any) -> Any:
    """With a damper, where without one slip that begins at v_r = 0 touches v_r = 0 a period later."""
    p = made.parameters
    same = p.get("mu_k", 0.0) == p.get("mu_s", 1.0)
    return made.replace(c=0.02) if same and p.get("c") == 0.0 else made


def order(rng: Random, tol: float, radians: float) -> int | None:
    """An order that reaches the end at a bearable cost, or none."""
    choice = rng.randint(4, 30)
    if rng.random() < 0.6:
        return None
    step = (tol * factorial(choice - 1)) ** (1 / (choice - 1))  # the last term but one of a sine is below tol
    return choice if radians / step < STEPS else None


def stiffness(model: Any) -> float:
    """Fastest decay that a rising branch of the law can cause, 1/s."""
    law, p = getattr(model, "friction", None), model.parameters
    if type(law).__name__ not in RISING:
        return 1e-9
    width = min(p[name] for name in ("v_s", "v_2") if name in p)
    force = max(p.get(name, 0.0) for name in ("N", "N1", "N2", "F"))
    mass = min(p[name] for name in ("m", "M", "m1", "m2") if name in p)
    height = max(p["mu_k"], p.get("h", 0.0))
    return max(height * force / (width * mass), 1e-9)


def friction(rng: Random, speed: float, force: float) -> fl.FrictionLaw:
    """Any law, with layers from the speed down to a ten thousandth of it."""
    mu_k = _short(rng.choice([0.0, 0.1, 0.3, rng.uniform(0.05, 1.5)]))
    mu_s = _short(mu_k + rng.choice([0.0, 0.1, 0.5, rng.uniform(0.0, 1.5)]))
    kind = rng.choice([fl.Coulomb, fl.Coulomb, *KINDS])
    own = {
        "v_s": speed * 10 ** rng.uniform(-4, 0),
        "v_2": speed * 10 ** rng.uniform(-4, 0),
        "u_0": speed * rng.choice([0.5, 1.0, rng.uniform(0.1, 2.0)]),
        "mu_v": rng.choice([0.0, rng.uniform(0.0, 0.1)]),
        "h": rng.uniform(0.0, 1.0) * min(mu_s - mu_k, 0.5),
        "n": rng.uniform(0.1, 0.9),
        "F_ref": force,
    }
    if kind is fl.WeakeningStrengthening:  # mu_v is per v_s there
        own["mu_v"] *= own["v_s"] / speed
    if kind is OWN["Nested"]:  # cosh(710) overflows, in the law itself
        own["v_2"] = max(own["v_2"], speed / 50)
    if kind is OWN["Ripple"]:  # thousands of waves cost the reference seconds
        own["v_2"] = max(own["v_2"], speed / 100)
    fields = kind.__dataclass_fields__
    return kind(mu_k=mu_k, mu_s=mu_s, **{n: _short(x) for n, x in own.items() if n in fields})


KINDS = [
    fl.ExponentialDecay,
    fl.Stribeck,
    fl.WeakeningStrengthening,
    fl.PressureDependent,
    *OWN.values(),
]


def _log(rng: Random, low: float, high: float) -> float:
    return low * (high / low) ** rng.random()


def _short(x: float, digits: int = 3) -> float:
    return float(f"{x:.{digits}g}")


def _about(rng: Random) -> float:
    return rng.choice([1.0, _short(_log(rng, 0.3, 3.0))])


def _damper(rng: Random) -> float:
    return rng.choice([0.0, 0.0, 0.02, 0.3])


def _place(rng: Random, size: float) -> float:
    return rng.choice([0.0, _short(size * rng.uniform(-1, 1)), size * rng.uniform(-1, 1)])


def mass_on_belt(rng: Random) -> tuple[Any, list[float]]:
    v = rng.choice([0.0, 0.2, 1.0, 2.5, _short(_log(rng, 0.01, 5.0))])
    speed, N = v or 1.0, _about(rng)
    model = fl.MassOnBelt(
        m=_about(rng), c=_damper(rng), k=_about(rng), N=N, v=v, friction=friction(rng, speed, N)
    )
    start = v if rng.random() < 0.25 else _place(rng, 2 * speed)
    return model, [_place(rng, 2 * (N + speed)), start]


def den_hartog(rng: Random) -> tuple[Any, list[float]]:
    N = rng.choice([0.3, 0.8, _short(rng.uniform(0.0, 1.5))])
    model = fl.DenHartog(
        m=_about(rng),
        c=_damper(rng),
        k=_about(rng),
        N=N,
        F=_about(rng),
        Omega=_short(_log(rng, 0.1, 3.0)),
        friction=friction(rng, 1.0, max(N, 0.1)),
    )
    return model, [_place(rng, 2.0), _place(rng, 2.0)]


def impact_oscillator(rng: Random) -> tuple[Any, list[float]]:
    d = rng.choice([0.0, _short(rng.uniform(-0.5, 1.0))])
    model = fl.ImpactOscillator(
        m=_about(rng),
        c=_damper(rng),
        k=_about(rng),
        d=d,
        F=_about(rng),
        Omega=_short(_log(rng, 0.1, 4.0)),
        e=rng.choice([0.0, 0.5, 0.8, 1.0, _short(rng.uniform(0.1, 0.95))]),
    )
    return model, [d - abs(_place(rng, 1.0)) - 0.01, _place(rng, 1.0)]


def bouncing_ball(rng: Random) -> tuple[Any, list[float]]:
    model = fl.BouncingBall(g=_short(_log(rng, 1.0, 20.0)), e=rng.choice([0.0, 0.5, _short(rng.random())]))
    return model, [abs(_place(rng, 2.0)) + 0.01, _place(rng, 3.0)]


def two_blocks(rng: Random) -> tuple[Any, list[float]]:
    v, N1, N2 = rng.choice([0.2, 1.0, _short(_log(rng, 0.05, 3.0))]), _about(rng), _about(rng)
    model = fl.TwoBlocks(
        m1=_about(rng),
        m2=_about(rng),
        c=_damper(rng),
        k1=_about(rng),
        k2=_about(rng),
        k12=_short(_log(rng, 0.1, 3.0)),
        N1=N1,
        N2=N2,
        v=v,
        friction=friction(rng, v, N1),
    )
    return model, [_place(rng, 2 * N1) for _ in range(2)] + [_place(rng, v) for _ in range(2)]


def mode_coupling(rng: Random) -> tuple[Any, list[float]]:
    v, F = rng.choice([1.0, _short(_log(rng, 0.1, 3.0))]), rng.choice([1.0, _short(_log(rng, 0.1, 3.0))])
    model = fl.ModeCoupling(
        c=rng.choice([0.0, 0.02, 0.1]),
        k1=_about(rng),
        k2=_about(rng),
        k3=_about(rng),
        F=F,
        v=v,
        friction=friction(rng, v, F),
    )
    return model, [_place(rng, 2.0), _short(rng.uniform(0.05, 1.5)), _place(rng, v), _place(rng, v)]


def slider(rng: Random) -> tuple[Any, list[float]]:
    v = rng.choice([1.0, _short(_log(rng, 0.1, 3.0)), -1.0])
    plain, bilateral = rng.random() < 0.5, rng.random() < 0.2
    impact = rng.choice([fl.PlasticImpact("full"), fl.PlasticImpact("full"), fl.RestitutionImpact(e=0.5)])
    model = fl.SliderOnBelt(
        F=rng.choice([200.0, _short(_log(rng, 50.0, 800.0))]),
        k_nl=rng.choice([1e4, 1e6]),
        c1=rng.choice([0.1, 5.0]),
        v=v,
        friction=friction(rng, abs(v), 200.0),
        impact=impact,
    )
    if plain:
        model = model.replace(geometry=FixedLoad())
    if bilateral:
        model = model.replace(interface=StickSlip())
    n = len(model.coordinates)
    if rng.random() < 0.5:
        return model, [0.0] * 2 * n
    places = [_place(rng, 0.005) for _ in range(n)]
    places[1] = -0.02 - abs(places[1])  # the slider above the belt is y1 > 0; below, the contact is pressed
    return model, places + [_place(rng, 0.5) for _ in range(n)]


Maker = Callable[[Random], tuple[Any, list[float]]]
MAKERS: dict[str, tuple[float, Maker]] = {
    "MassOnBelt": (0.3, mass_on_belt),
    "DenHartog": (0.16, den_hartog),
    "ImpactOscillator": (0.12, impact_oscillator),
    "TwoBlocks": (0.15, two_blocks),
    "BouncingBall": (0.04, bouncing_ball),
    "ModeCoupling": (0.11, mode_coupling),
    "SliderOnBelt": (0.12, slider),
}
