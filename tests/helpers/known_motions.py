"""Automata whose orbits, multipliers or branches are known in closed form."""

import sympy as sp

import frictionlab as fl
from tests.helpers.automata import V, X, automaton

FLAT = fl.SliderOnBelt(impact=fl.PlasticImpact("full")).without("geometry")
TILTED = fl.SliderOnBelt(impact=fl.PlasticImpact("full"))
W, C, S = sp.symbols("w c s")
HALF, TENTH = sp.Rational(1, 2), sp.Rational(1, 10)


def bistable(speed):
    """x'' + 0.1 x' + x = -sgn(v_r) (1 + exp(-2 |v_r|))/2, which sticks up to 1.

    The exponential is a state of its own: w' = -2 w |v_r|' keeps w = exp(-2 |v_r|), events set it to 1.
    """
    belt = sp.Symbol("v_d")

    def slip(name, sign, targets):
        acceleration = -TENTH * V - X - sign * HALF * (1 + W)
        event = fl.Event("v_r", sign * (V - belt), targets, fl.Reset({V: belt, W: sp.S.One}))
        return fl.Mode(name, (V, acceleration, -2 * W * sign * acceleration), (event,))

    pull = X + TENTH * belt
    ends = fl.Event("cone+", 1 - pull, ("slip-",)), fl.Event("cone-", 1 + pull, ("slip+",))
    stick = fl.Mode("stick", (V, sp.S.Zero, sp.S.Zero), ends, (V - belt,))
    modes = stick, slip("slip-", -1, ("stick", "slip+")), slip("slip+", 1, ("stick", "slip-"))
    return automaton(*modes, states=(X, V, W), v_d=speed)


def thrown(after, states, coordinates=1, **parameters):
    """A ball over a floor that it leaves with the speed `after`, of its speed -V at the impact."""
    floor = fl.Event("floor", X, ("flight",), fl.Reset({X: sp.S.Zero, **after}))
    flow = (V, -sp.S.One, *(sp.S.Zero for _ in states[2:]))
    return automaton(fl.Mode("flight", flow, (floor,)), states=states, coordinates=coordinates, **parameters)


def logistic(a):
    """Speeds u -> a u (1 - u)."""
    return thrown({V: sp.Symbol("a") * -V * (1 + V)}, (X, V), a=a)


def settled(model, x0="rest", **options):
    return fl.steady_state(model, x0, progress=False, **options)
