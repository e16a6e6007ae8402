"""The scenes that are measured: runs with a known final state."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import mpmath
import numpy as np
import sympy

from frictionlab.automaton import Event, HybridAutomaton, Mode, Reset
from frictionlab.components import PlasticImpact
from frictionlab.hybrid.methods.taylor import Taylor
from frictionlab.hybrid.solve import solve
from frictionlab.models import SliderOnBelt

# Final states by tests/reference/slider_mpmath.py with 40 digits, which shares no code with the package.
REFERENCES = {
    "A": (
        -0.0046648651406953490495,
        -0.0028931216086977638414,
        0.01023096415463402731,
        -0.00688634954732124352,
        -1.6204621954968379352,
        -2.4085346113969358282,
        0.93970366749664052541,
        0.63342002886845983977,
    ),
    "B": (
        -0.01563171764918776,
        -0.024517895028636476,
        0.012009167802481643,
        -0.008104117695891856,
        -0.010657612762793766,
        0.01877919440799427,
        -2.599060934608227,
        -0.8632722791610545,
        0.43483137365689173,
        -0.011811320566702371,
    ),
    "C": (
        0.17854434151613961651,
        -0.022127279676025447113,
        -0.000165603000767934306,
        -3.1770553425094226808e-6,
        0.00023262863799583641996,
        21.313234889960279355,
        5.6071760568312409257,
        1.2365687016297735762,
        -0.0095870326449464019009,
        0.46489169620819055962,
    ),
}
STIFF_SLIDER = SliderOnBelt(mu_k=2.5, k_nl=1e7, F=800.0, k4=5e6, k5=5e6, k6=5e6).without("nonsmooth")
# Smallest and largest correct number of events: the last one of "Coulomb" may fall just after the end.
EVENT_COUNTS = {"A": (885, 885), "B": (886, 886), "Coulomb": (1999, 2000)}
COULOMB_PERIOD = 5 + 2 * np.pi - 2 * np.arctan(2.5)  # of the Coulomb mass on a belt

FULL_GAP_RATE_SLIDER = SliderOnBelt(mu_k=1.4, impact=PlasticImpact(penetration_rate="full"))


@dataclass(frozen=True, eq=False)
class ReferenceScene:
    """A run with a known final state.

    Parameters
    ----------
    name, text : str
    automaton : HybridAutomaton
    x0 : array
    t_end : float
    reference : callable
        State at `t_end`.
    model : SliderOnBelt or None
        The automaton's model, if it has non-smooth behaviour that can be regularised.
    events : (int, int) or None
        Smallest and largest correct number of events, where it does not depend on the method.
    """

    name: str
    text: str
    automaton: HybridAutomaton
    x0: np.ndarray
    t_end: float
    reference: Callable[[], np.ndarray]
    model: SliderOnBelt | None = None
    events: tuple[int, int] | None = None

    def missed(self, count: int) -> int | None:
        """Number of missed events; negative where there are too many."""
        return None if self.events is None else min(max(count, self.events[0]), self.events[1]) - count

    def error(self, state: np.ndarray) -> float:
        """Largest deviation of a state."""
        return float(np.abs(state - self.reference()).max())


@cache
def scenes() -> dict[str, ReferenceScene]:
    """All scenes by name."""
    usual = SliderOnBelt(mu_k=1.4)
    bare = usual.without("cubic", "nonsmooth", "geometry")
    every = (
        _model("A", "stick, slip and separation without the moving load", usual.without("geometry"), 20.0),
        _model("B", "with it, full gap rate", usual.replace(impact=PlasticImpact("full")), 20.0),
        _model("C", "sliding only, stiff, strongly nonlinear", STIFF_SLIDER, 1.0),
        _chatter(usual),
        _coulomb(),
        _linear(bare),
    )
    return {scene.name: scene for scene in every}


def _model(name: str, text: str, model: SliderOnBelt, t_end: float) -> ReferenceScene:
    automaton = model.automaton()
    rest = np.zeros(len(automaton.states))
    unlike = model if "separation" in model.interface.modes else None
    return ReferenceScene(
        name, text, automaton, rest, t_end, lambda: np.array(REFERENCES[name]), unlike, EVENT_COUNTS.get(name)
    )


def _chatter(model: SliderOnBelt) -> ReferenceScene:
    """Chatter, which has no closed form: the reference is the solver itself with another order and a much
    shorter limit of chatter."""
    automaton, rest, t_end = model.automaton(), np.zeros(10), 1.0
    finest = Taylor(order=34, chatter=1e-9)

    @cache
    def reference() -> np.ndarray:
        return solve(automaton, t_end, x0=rest, method=finest, progress=False).final_state

    return ReferenceScene("D", "Eq. (13) as printed: chatter", automaton, rest, t_end, reference, model)


def _coulomb() -> ReferenceScene:
    """A thousand cycles of a mass on a belt: m = k = 1, v = 0.2, friction 1 in stick and 0.5 in slip."""
    x, v, belt = sympy.symbols("x v belt", real=True)
    held = Reset({v: belt})
    stick = Mode("stick", (v, sympy.S.Zero), (Event("pulled", 1 - x, ("slip",)),), (belt - v,))
    slip = Mode("slip", (v, sympy.Rational(1, 2) - x), (Event("v_r", belt - v, ("stick",), held),))
    automaton, start = HybridAutomaton((x, v), (stick, slip), {belt: 0.2}, 1), np.array([0.0, 0.2])
    text, t_end = "1000 cycles of stick and slip", 1000 * COULOMB_PERIOD
    return ReferenceScene(
        "Coulomb", text, automaton, start, t_end, lambda: start, events=EVENT_COUNTS["Coulomb"]
    )


def _linear(model: SliderOnBelt) -> ReferenceScene:
    """All nonlinearities left out: a linear system, solved by the exponential of its matrix, with 40 digits.

    scipy's exponential, in double precision, is wrong by 8e-13 here: more than what is measured.
    """
    automaton, t_end = model.automaton(), 10.0
    rest = np.zeros(len(automaton.states))

    @cache
    def reference() -> np.ndarray:
        values = {symbol: sympy.Rational(value) for symbol, value in automaton.parameters.items()}
        flow = sympy.Matrix(automaton.modes[0].flow).subs(values)
        constant = flow.subs(dict.fromkeys(automaton.states, 0))
        affine = flow.jacobian(automaton.states).row_join(constant).col_join(sympy.zeros(1, len(rest) + 1))
        with mpmath.workdps(40):
            entries = [[mpmath.mpf(entry.p) / entry.q for entry in row] for row in affine.tolist()]
            end = mpmath.expm(mpmath.matrix(entries) * t_end)
            return np.array([float(end[i, len(rest)]) for i in range(len(rest))])

    return ReferenceScene("linear", "all three nonlinearities left out", automaton, rest, t_end, reference)
