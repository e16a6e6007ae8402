"""Small automata with known answers, for the tests; nothing here knows the slider on the belt."""

import pytest
import sympy as sp

import frictionlab as fl

X, V = sp.symbols("x v")
ONCE = pytest.mark.plain_python  # quick enough for a run without numba


def automaton(*modes, states=(X, V), coordinates=1, **parameters):
    numbers = {sp.Symbol(name): value for name, value in parameters.items()}
    return fl.HybridAutomaton(states, modes, numbers, coordinates)


def oscillator(**more):
    return automaton(fl.Mode("only", (V, -X), **more))


def ball():
    g, e = sp.symbols("g e")
    bounce = fl.Reset({X: sp.S.Zero, V: -e * V})
    lie = fl.Reset({X: sp.S.Zero, V: sp.S.Zero}, {X: 2})
    flight = fl.Mode("flight", (V, -g), (fl.Event("floor", X, ("flight",), bounce, lie),))
    rest = fl.Mode("rest", (V, sp.S.Zero), (fl.Event("pressed", g),), (X, V))
    return automaton(flight, rest, g=9.81, e=0.5)


def coulomb(v, mu_s, mu_k):
    """A unit mass on a unit spring, rubbed by a belt of speed v."""
    belt, static, kinetic = sp.symbols("belt mu_s mu_k")
    relative = belt - V
    stop = fl.Reset({V: belt})
    stick = fl.Mode(
        "stick",
        (V, sp.S.Zero),
        (fl.Event("+", static - X, ("+",)), fl.Event("-", static + X, ("-",))),
        (relative,),
    )
    plus = fl.Mode("+", (V, kinetic - X), (fl.Event("v_r", relative, ("stick", "-"), stop),))
    minus = fl.Mode("-", (V, -kinetic - X), (fl.Event("v_r", -relative, ("stick", "+"), stop),))
    return automaton(stick, plus, minus, belt=v, mu_s=mu_s, mu_k=mu_k)


def thermostat():
    """A room that cools, and a heater that is on between two temperatures; energies per heat capacity."""
    k, heat, outside, low, high = sp.symbols("k heat outside low high")
    loss = k * (outside - X)

    def mode(name, other, power, event):
        outputs = {"energy of the room": X, "power of the wall": loss, "power of the heater": power}
        return fl.Mode(name, (loss + power,), (fl.Event("limit", event, (other,)),), outputs=outputs)

    modes = mode("on", "off", heat, high - X), mode("off", "on", sp.S.Zero, X - low)
    values = {k: 0.1, heat: 5.0, outside: 10.0, low: 19.0, high: 21.0}
    return fl.HybridAutomaton((X,), modes, values)


def clock(*events):
    return automaton(
        fl.Mode("on", (sp.S.One,), events), fl.Mode("off", (sp.S.Zero,)), states=(X,), coordinates=0
    )


def named():
    """A swing whose names are LaTeX, words, and signs of HTML; its spring yields, so that it is in pieces."""
    angle, rate = sp.symbols([r"\varphi", r"\dot\varphi"])
    names = r"\kappa_{eff}", "limit of spring", "x0", "<b>'\"&"
    k, limit, x0, sign = (sp.Symbol(name, positive=True) for name in names)
    spring = k * fl.functions.minimum(angle, limit)
    top = fl.Event("ünder & <i>", x0 - angle, ('"swing"',), fl.Reset({rate: -rate / 2}))
    mode = fl.Mode('"swing"', (rate, -spring - sign * rate), (top,))
    values = {k: 4.0, limit: 0.3, x0: 0.5, sign: 0.05}
    return fl.HybridAutomaton((angle, rate), (mode,), values, 1)
