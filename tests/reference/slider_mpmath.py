"""High-precision reference for the slider on the belt: a stand-alone Taylor integrator written in mpmath.

Nothing here comes from frictionlab. The equations are Eqs. (1)-(17) of N. Liu and H. Ouyang,
"Friction-induced vibration considering multiple types of nonlinearities", Nonlinear Dynamics (2020), with
Eq. (16) corrected: y2' changes by -p/m. Parameters are decimals: 0.1 is one tenth, not the nearest double.
Running the file writes first_events.json.
"""

import json
from pathlib import Path
from types import SimpleNamespace

from mpmath import mp, mpf

BASE = {
    **dict.fromkeys(("M", "m", "v"), 1),
    **dict.fromkeys(("J", "c1", "c2", "c4", "c5", "c6"), "0.1"),
    **dict.fromkeys(("k1", "k4", "k5", "k6", "k_nl"), 10000),
    **{"k2": 5000, "k3": 6000, "l1": "0.2", "l2": "0.2", "mu_s": 3, "mu_k": "1.4", "F": 200},
}
NUMERICS = {"dps": 40, "order": 44, "tol": "1e-40", "scale": 1}  # scale shortens the steps
SCENES = {
    name: {"mu_k": "1.4", "geometry": geometry, "impact": impact}
    for name, geometry, impact in (("A", False, "full"), ("B", True, "full"), ("D", True, "material"))
}
SIGN = {"slip+": 1, "slip-": -1}  # of v_r, hence of F_T


def parameters(geometry, overrides):
    """Parameters as mpf; without geometry 1/J is zero: phi stays zero and the impact does not see J."""
    if not set(overrides) <= set(BASE):
        raise TypeError(f"unknown parameters {sorted(set(overrides) - set(BASE))}; known: {sorted(BASE)}")
    p = SimpleNamespace(**{name: mpf(str(value)) for name, value in {**BASE, **overrides}.items()})
    p.geometry, p.inverse_J = geometry, 1 / p.J if geometry else mpf(0)
    p.inverse_inertia = (1 / p.M, 1 / p.M, 1 / p.m, 1 / p.m, p.inverse_J)
    return p


def product(a, b, k):
    """Coefficient k of the product of two series."""
    return mp.fdot(a[: k + 1], b[k::-1])


def value(c, t):
    """Value at t of the polynomial with coefficients c, lowest first."""
    return mp.polyval(c[::-1], t)


def structure_forces(q, w, k, p):
    """Coefficient k of everything on the left of Eq. (1) except inertia, for x1, y1, x2, y2, phi."""
    x1, y1, x2, y2, phi = (c[k] for c in q)
    vx1, vy1, vx2, vy2, vphi = (c[k] for c in w)
    wheel_1 = p.c5 * (vy2 + p.l1 * vphi) + p.k5 * (y2 + p.l1 * phi)
    wheel_2 = p.c6 * (vy2 - p.l2 * vphi) + p.k6 * (y2 - p.l2 * phi)
    diagonal, preload = p.k3 / 2 * (x1 - y1), 0 if k else p.F
    slider = (p.c1 * vx1 + p.k1 * x1 + diagonal, p.c2 * vy1 - diagonal + preload)
    belt = (p.c4 * vx2 + p.k4 * x2, wheel_1 + wheel_2, p.l1 * wheel_1 - p.l2 * wheel_2)
    return slider + belt


def append_forces(s, k, mode, r, p):
    """Append coefficient k of x1 - x2, gap (positive if pressed), F_N (Eq. 2), F_T (Eq. 3 or x1'' = x2'')."""
    s.offset.append(s.q[0][k] - s.q[2][k])
    s.gap.append(s.q[3][k] - product(s.offset, s.q[4], k) - s.q[1][k])
    s.square.append(product(s.gap, s.gap, k))
    force = p.k2 * s.gap[k] + p.k_nl * product(s.square, s.gap, k)
    s.F_N.append(mpf(0) if mode == "separation" else force)
    stick = (p.m * r[0] - p.M * r[2]) / (p.M + p.m)
    s.F_T.append(stick if mode == "stick" else SIGN.get(mode, 0) * p.mu_k * s.F_N[k])


def series(state, mode, p, order):
    """Taylor coefficients of coordinates q, velocities w, gap, F_N, F_T and v_r about a state (q, w)."""
    q, w = [[c] for c in state[:5]], [[c] for c in state[5:]]
    s = SimpleNamespace(q=q, w=w, offset=[], gap=[], square=[], F_N=[], F_T=[])
    for k in range(order + 1):
        r = structure_forces(q, w, k, p)
        append_forces(s, k, mode, r, p)
        contact = (s.F_T[k], s.F_N[k], -s.F_T[k], -s.F_N[k], product(s.F_N, s.offset, k))
        for i in range(5):
            q[i].append(w[i][k] / (k + 1))
            w[i].append((contact[i] - r[i]) * p.inverse_inertia[i] / (k + 1))
    s.v_r = [p.v + w[2][0] - w[0][0]] + [b - a for a, b in zip(w[0][1:], w[2][1:])]
    return s


def guards(s, mode, p):
    """Event functions of a mode by name, as coefficients; each is positive while the mode lasts."""
    if mode == "separation":
        return {"gap": [-c for c in s.gap]}
    if mode == "stick":
        return {name: [p.mu_s * n - sign * t for n, t in zip(s.F_N, s.F_T)] for name, sign in SIGN.items()}
    return {"gap": s.gap, "v_r": [SIGN[mode] * c for c in s.v_r]}


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


def land(state, impact, p):
    """Mode, state and known zeros after the plastic impact: the first non-zero gap coefficient decides."""
    x1, _, x2, _, phi, vx1, vy1, vx2, vy2, vphi = state
    closing = vy2 - vy1 - (x1 - x2) * vphi - ((vx1 - vx2) * phi if impact == "full" else 0)
    impulse = closing / (1 / p.M + 1 / p.m + (x1 - x2) ** 2 * p.inverse_J)
    vphi += impulse * (x1 - x2) * p.inverse_J
    state = [*state[:5], vx1, vy1 + impulse / p.M, vx2, vy2 - impulse / p.m, vphi]
    s, zeros = series(state, "separation", p, 2), 2 if impact == "full" or not p.geometry else 1
    pressed = "slip+" if s.v_r[0] > 0 else "slip-"
    return pressed if s.gap[zeros] > 0 else "separation", state, {"gap": zeros}


def transition(mode, guard, state, impact, p):
    """Mode, state and guards known to vanish (name: order) after an event."""
    if guard == "gap":
        return land(state, impact, p) if mode == "separation" else ("separation", state, {"gap": 1})
    if mode == "stick":
        return guard, state, {"v_r": 1}
    held = series(state, "stick", p, 0)
    F_N, F_T = held.F_N[0], held.F_T[0]
    if abs(F_T) < p.mu_s * F_N:
        return "stick", state, {}
    return "slip+" if F_T > 0 else "slip-", state, {"v_r": 1}


def integrate(p, impact, n, t_stop, numerics):
    """Run from rest until n events or t_stop: list of (time, source, target), and the final state (q, w)."""
    t, state, mode, zeros, events = mpf(0), [mpf(0)] * 10, "slip+", {"gap": 2}, []
    while len(events) < n and t < t_stop:
        s = series(state, mode, p, numerics["order"])
        h = min(step_length(s, mpf(numerics["tol"]), numerics["scale"]), t_stop - t)
        roots = [(first_root(c[zeros.get(g, 0) :], h), g) for g, c in guards(s, mode, p).items()]
        h, guard = min((root for root in roots if root[0] is not None), default=(h, None))
        t, state, zeros = t + h, [value(c, h) for c in s.q + s.w], {}
        if guard is not None:
            source, (mode, state, zeros) = mode, transition(mode, guard, state, impact, p)
            events.append((t, source, mode))
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
        return integrate(parameters(geometry, {**overrides, "mu_k": mu_k}), impact, n, mpf(5), numerics)[0]


def state_at(t_stop, mu_k="1.4", geometry=True, impact="full", numerics=NUMERICS, **overrides):
    """State [coordinates, velocities] at a time, from rest; without geometry phi is left out."""
    with mp.workdps(numerics["dps"]):
        p = parameters(geometry, {**overrides, "mu_k": mu_k})
        state = integrate(p, impact, mp.inf, mpf(str(t_stop)), numerics)[1]
    return state if geometry else state[:4] + state[5:9]


def scene_record(scene, with_state):
    """First twenty events of a scene, and its state at 0.2 s if wanted, as text with 30 digits."""
    text = {"n": 30, "strip_zeros": False}
    events = [[mp.nstr(t, **text), source, target] for t, source, target in first_events(20, **scene)]
    state = {"state_at_0.2": [mp.nstr(x, **text) for x in state_at("0.2", **scene)]} if with_state else {}
    return {**scene, "events": events, **state}


if __name__ == "__main__":
    record = {name: scene_record(scene, with_state=name != "D") for name, scene in SCENES.items()}
    command = "python tests/reference/slider_mpmath.py"
    text = json.dumps({"command": command, "digits": 30, "scenes": record}, indent=1)
    Path(__file__).with_name("first_events.json").write_text(text + "\n")
