"""The stick machine of SciML/OrdinaryDiffEq.jl issue 3222: a valve spool with friction between two stops.

A pressure that swings at 250 Hz pushes a spool against a spring with preload and 1 N of dry friction, between
stops 1.016 mm apart with a coefficient of restitution of 0.3.  There a velocity that turns round within stick
was missed.  The numbers are the issue's; its equations are read off them:
M x'' = A P(t) - F_sp - k_f x - F_f sgn(x').
"""

import numpy as np
import pytest
from scipy.optimize import brentq

import frictionlab as fl
from frictionlab.components import functions
from frictionlab.models import Friction, Mechanics, Stop

M, K, SPRING, TRAVEL = 0.0003361185937456267, 1488.578099595049, 8.54503372291542, 0.001016
FRICTION, E, AREA, PA = 1.0, 0.3, 7.373657906574696e-5, 6895.0
OMEGA, END = 2 * np.pi * 250.0, 0.04
STEADY, SWING = 18 * PA * AREA, 4 * PA * AREA  # N


@fl.model
class Spool(fl.MechanicalModel):
    """A spool between two stops, with friction."""

    F: float = fl.parameter(SWING, unit="N", symbol="F", meaning="swing of the force", range=(0.0, 5.0))
    friction: fl.FrictionLaw = fl.Coulomb(mu_k=FRICTION, mu_s=FRICTION)
    impact: fl.ImpactLaw = fl.RestitutionImpact(e=E)
    coordinates = ("x",)
    period = 0.004

    def mechanics(self, q, v):
        return Mechanics(
            kinetic=M * v.x**2 / 2,
            potential=K * q.x**2 / 2 + (SPRING - STEADY) * q.x,
            contacts=(
                Friction(-v.x, 1.0, self.friction),
                Stop(q.x, self.impact),
                Stop(TRAVEL - q.x, self.impact),
            ),
            loads={"x": self.F * functions.sin(q.phase)},
            frequency=OMEGA,
        )


def net(t, x):
    """Force without friction and stops (N)."""
    return STEADY + SWING * np.sin(OMEGA * t) - SPRING - K * x


def slide(t0, x0, v0, sign):
    """x(t) and v(t) of sliding in a direction, in closed form."""
    w, level = np.sqrt(K / M), (STEADY - SPRING - sign * FRICTION) / K
    forced = SWING / (K - M * OMEGA**2)
    a = x0 - level - forced * np.sin(OMEGA * t0)
    b = (v0 - forced * OMEGA * np.cos(OMEGA * t0)) / w

    def x(t):
        s = w * (t - t0)
        return level + forced * np.sin(OMEGA * t) + a * np.cos(s) + b * np.sin(s)

    def v(t):
        s = w * (t - t0)
        return forced * OMEGA * np.cos(OMEGA * t) + w * (b * np.cos(s) - a * np.sin(s))

    return x, v


def first_root(functions, t0, step=2e-7):
    """First change of sign of any of them after t0, seen on a fine grid: its time, and which; END if none."""
    for k in range(int((END - t0) / step) + 1):
        low, high = t0 + (k * step or 1e-9), t0 + (k + 1) * step
        turned = [i for i, f in enumerate(functions) if f(low) * f(high) <= 0]
        if turned:
            return min((brentq(functions[i], low, high, xtol=1e-18, rtol=1e-15), i) for i in turned)
    return END, -1


def held(t, x):
    """When and whither a mass at rest sets off: friction holds it up to 1 N, a stop against any force."""
    ways = [sign for sign, free in ((1.0, x < TRAVEL), (-1.0, x > 0.0)) if free]
    for sign in ways:
        if sign * net(t, x) > FRICTION:
            return t, sign
    t, i = first_root([lambda s, sign=sign: sign * net(s, x) - FRICTION for sign in ways], t)
    return t, ways[i]


def marched():
    """Turns, impacts, departures (t, x, v after) without the package: closed forms, roots on a grid."""
    t, x, v, reached = 0.0, 0.0, 0.0, []
    while True:
        begin, (t, sign) = t, held(t, x) if v == 0.0 else (t, np.sign(v))
        if t >= END:
            return reached
        if t > begin:
            reached.append((t, x, 0.0))
        place, rate = slide(t, x, v, sign)
        t, which = first_root([rate, place, lambda s, place=place: TRAVEL - place(s)], t)
        if which < 0:
            return reached
        x = (float(place(t)), 0.0, TRAVEL)[which]
        v = 0.0 if which == 0 else -E * float(rate(t))
        reached.append((t, x, v))


@pytest.fixture(scope="module")
def run():
    found = fl.simulate(Spool(), END, progress=False)
    assert found.status is fl.Status.FINISHED
    return found


def test_every_turn_and_every_impact_is_found(run):
    """Ten periods against closed forms: 130 events, among them turns within 6 ns of an impact."""
    exact = np.array(marched())
    chosen = run.events.guard != "period"
    times, states = run.events.t[chosen], run.events.state[chosen]
    assert len(times) == len(exact) > 100
    assert times == pytest.approx(exact[:, 0], abs=1e-13)
    assert states[:, 0] == pytest.approx(exact[:, 1], abs=1e-15)
    assert states[:, 1] == pytest.approx(exact[:, 2], abs=1e-10)


def test_the_spool_stays_between_its_stops(run):
    x = run(np.linspace(0.0, END, 200_001))[:, 0]
    assert x.min() >= -1e-18
    assert x.max() <= TRAVEL * (1 + 1e-15)


def test_a_turn_may_lead_straight_on_or_into_stick(run):
    """What was missed: at v = 0 the one velocity guard goes out, and the other is zero from the start."""
    turns = run.events.guard == "v_r_1"
    ways = {target.split(" ")[0] for target in run.events.target[turns]}
    assert ways == {"stick", "slip+", "slip-"}
    moving = np.abs(run.v[:, 0])
    assert moving[run.mode == "stick | flight | flight"].max() == 0.0


def test_its_energy_is_accounted_for(run):
    """Work of the force, less friction's and what the impacts take, is what spring and mass have."""
    x, v, phase = (symbol for symbol in run.automaton.states)
    work = {"force": STEADY * v - SPRING * v + SWING * fl.functions.sin(phase) * v}
    again = fl.simulate(Spool(), END, quadratures=work, progress=False)
    before, after = run.events.before, run.events.state
    lost = M / 2 * (before[:, 1] ** 2 - after[:, 1] ** 2).sum()
    t = np.unique(np.concatenate([[0.0, END], run.events.t]))
    rubbed = FRICTION * np.abs(np.diff(run(t)[:, 0])).sum()
    stored = M / 2 * run.final_state[1] ** 2 + K / 2 * run.final_state[0] ** 2
    assert again.quadratures["force"] - rubbed - lost == pytest.approx(stored, abs=1e-14)
    assert lost > 1e-4
    assert str(x) == "x"
