"""High-precision reference for the slider on the belt: a stand-alone Taylor integrator written in mpmath.

Nothing here comes from frictionlab; the equations are in slider_equations.py. Chatter, the impacts that pile
up under Eq. (13), is walked through flight by flight; with `chatter` > 0 two flights in a row that are
shorter end the walk, and its limit takes over. Computed with 40 digits; ten digits more, or in A and B
half the steps, change none of the 25 that are stored. write_tables.py writes what the tests read.
"""

from typing import NamedTuple

from mpmath import mp, mpf

from tests.reference.slider_equations import guards, parameters, series

NUMERICS = {"dps": 40, "order": 44, "tol": "1e-40", "scale": 1}  # scale shortens the steps


class Happening(NamedTuple):
    """An event: time, mode before and after, state (q, w) before and after."""

    t: mpf
    source: str
    target: str
    before: list
    after: list


class Start(NamedTuple):
    """Where a run begins; `zeros` are guards known to vanish there (name: order)."""

    t: mpf
    mode: str
    state: list
    zeros: dict


REST = Start(mpf(0), "slip+", [mpf(0)] * 10, {"gap": 2})


def value(c, t):
    """Value at t of the polynomial with coefficients c, lowest first."""
    return mp.polyval(c[::-1], t)


def step_length(s, tol, scale):
    """Step whose last two Taylor terms stay below tol in every coordinate and velocity, times scale."""
    sizes = [(k, max(abs(c[k]) for c in s.q + s.w)) for k in (len(s.gap) - 2, len(s.gap) - 1)]
    return scale * min([mpf("0.02")] + [(tol / size) ** (mpf(1) / k) for k, size in sizes if size])


def first_root(c, h):
    """First root of a polynomial in (0, h] or None; c[0] must be positive.

    A grid is refined where the mean value bound |f(middle)| > max|f'| half cannot exclude a root, until the
    same bound on f' shows that f is monotonic there; then a bracketed secant method (Illinois) finishes.
    """
    if not c[0] > 0:
        raise ArithmeticError("the mode entered is not admissible")
    d, dd = [k * a for k, a in enumerate(c)][1:], [k * (k - 1) * a for k, a in enumerate(c)][2:]
    slope, curvature = (value([abs(a) for a in b], h) for b in (d, dd))
    stack = [(h * i / 8, h * (i + 1) / 8) for i in reversed(range(8))]
    while stack:
        a, b = stack.pop()
        middle, half = (a + b) / 2, (b - a) / 2
        if abs(value(c, middle)) > slope * half:
            continue
        if abs(value(d, middle)) <= curvature * half:
            if half < mpf(10) ** (-mp.dps / 2):
                raise ArithmeticError("a grazing root cannot be decided at this precision")
            stack += [(middle, b), (a, middle)]
        elif value(c, b) <= 0:
            options = {"tol": mpf(10) ** (-2 * mp.dps), "maxsteps": 99, "verify": False}
            return mp.findroot(lambda x: value(c, x), (a, b), solver="illinois", **options)
    return None


def struck(state, impact, p):
    """State after the plastic impact, Eqs. (10) to (17)."""
    x1, _, x2, _, phi, vx1, vy1, vx2, vy2, vphi = state
    closing = vy2 - vy1 - (x1 - x2) * vphi - ((vx1 - vx2) * phi if impact == "full" else 0)
    impulse = closing / (1 / p.M + 1 / p.m + (x1 - x2) ** 2 * p.inverse_J)
    vphi += impulse * (x1 - x2) * p.inverse_J
    return [*state[:5], vx1, vy1 + impulse / p.M, vx2, vy2 - impulse / p.m, vphi]


def pressed(s):
    """The mode of slip, by the sign of v_r."""
    return "slip+" if s.v_r[0] > 0 else "slip-"


def land(state, impact, p):
    """Mode, state and known zeros after the plastic impact: the first non-zero gap coefficient decides."""
    state = struck(state, impact, p)
    s, zeros = series(state, "separation", p, 2), 2 if impact == "full" or not p.geometry else 1
    return pressed(s) if s.gap[zeros] > 0 else "separation", state, {"gap": zeros}


def transition(mode, guard, state, impact, p):
    """Mode, state and guards known to vanish (name: order) after an event."""
    if mode == "chatter" and guard == "rate":
        return pressed(series(state, "separation", p, 0)), state, {"gap": 2}
    if guard == "gap" and mode != "separation":
        return "separation", state, {"gap": 1}
    if guard in ("gap", "flight"):
        return land(state, impact, p)
    if mode == "stick":
        return guard, state, {"v_r": 1}
    held = series(state, "stick", p, 0)
    F_N, F_T = held.F_N[0], held.F_T[0]
    if abs(F_T) < p.mu_s * F_N:
        return "stick", state, {}
    return "slip+" if F_T > 0 else "slip-", state, {"v_r": 1}


def limit(state, p):
    """The limit of chatter after an impact that leaves no gap rate; None where it cannot be entered."""
    state = struck(state, "full", p)
    fine = all(c[0] > 0 for c in guards(series(state, "chatter", p, 0), "chatter", p).values())
    return ("chatter", state, {}) if fine else None


def advance(mode, state, zeros, left, p, numerics):
    """A step, up to the first event in it: its length, the event's guard or None, the state."""
    s = series(state, mode, p, numerics["order"])
    h = min(step_length(s, mpf(numerics["tol"]), numerics["scale"]), left)
    roots = [(first_root(c[zeros.get(g, 0) :], h), g) for g, c in guards(s, mode, p).items()]
    h, guard = min((root for root in roots if root[0] is not None), default=(h, None))
    return h, guard, [value(c, h) for c in s.q + s.w]


def integrate(p, impact, n, t_stop, numerics, start=REST):
    """Run until n events or t_stop: list of Happening, and the final state (q, w)."""
    (t, mode, state, zeros), events = start, []
    entered, short = t, 0  # when the mode began; short flights in a row
    while len(events) < n and t < t_stop:
        h, guard, state = advance(mode, state, zeros, t_stop - t, p, numerics)
        t, zeros = t + h, {}
        if guard is None:
            continue
        source, before = mode, state
        short = short + (mode == "separation") if t - entered < p.chatter else 0
        after = limit(state, p) if short == 2 else None
        short, entered = short % 2, t
        mode, state, zeros = after or transition(mode, guard, state, impact, p)
        events.append(Happening(t, source, mode, before, state))
    return events, state


def first_events(n, mu_k="1.4", geometry=True, impact="full", numerics=NUMERICS, **overrides):
    """First events from rest, within five seconds.

    Parameters
    ----------
    n, mu_k, geometry : int, str or float, bool
        Number of events; friction coefficient (floats are read as they print); whether the belt rotates.
    impact : {"full", "material"}
        What the plastic impact brings to zero: the full gap rate, or the relative velocity of Eq. (13).
    numerics, **overrides
        Like NUMERICS; other parameters by the names in BASE.

    Returns
    -------
    list of (time, mode before, mode after) : (mpf, str, str)
    """
    with mp.workdps(numerics["dps"]):
        p = parameters(geometry, {**overrides, "mu_k": mu_k})
        return [event[:3] for event in integrate(p, impact, n, mpf(5), numerics)[0]]


def motion(t_stop, mu_k="1.4", geometry=True, impact="full", numerics=NUMERICS, start=REST, **overrides):
    """Events as Happening, and the state at t_stop; without geometry states are without phi."""
    with mp.workdps(numerics["dps"]):
        p = parameters(geometry, {**overrides, "mu_k": mu_k})
        events, state = integrate(p, impact, mp.inf, mpf(str(t_stop)), numerics, start)
    if geometry:
        return events, state
    return [e._replace(before=flat(e.before), after=flat(e.after)) for e in events], flat(state)


def flat(state):
    """A state without phi and its rate."""
    return state[:4] + state[5:9]


def state_at(t_stop, **options):
    """State [coordinates, velocities] at a time, from rest; options as for :func:`motion`."""
    return motion(t_stop, **options)[1]
