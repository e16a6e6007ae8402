"""The slider on the belt for the high-precision reference: parameters, Taylor coefficients, event functions.

Nothing here comes from frictionlab. The equations are Eqs. (1)-(17) of N. Liu and H. Ouyang,
"Friction-induced vibration considering multiple types of nonlinearities", Nonlinear Dynamics (2020), with
Eq. (16) corrected: y2' changes by -p/m. Parameters are decimals: 0.1 is one tenth, not the nearest double.
"""

from types import SimpleNamespace

from mpmath import mp, mpf

BASE = {
    **dict.fromkeys(("M", "m", "v"), 1),
    **dict.fromkeys(("J", "c1", "c2", "c4", "c5", "c6"), "0.1"),
    **dict.fromkeys(("k1", "k4", "k5", "k6", "k_nl"), 10000),
    **{"k2": 5000, "k3": 6000, "l1": "0.2", "l2": "0.2", "mu_s": 3, "mu_k": "1.4", "F": 200},
    "chatter": 0,  # s; two flights in a row shorter than this are taken for chatter
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
    if mode == "chatter":
        force = mean_impulse(s, k, r, p)
    s.F_N.append(mpf(0) if mode == "separation" else force)
    stick = (p.m * r[0] - p.M * r[2]) / (p.M + p.m)
    s.F_T.append(stick if mode == "stick" else SIGN.get(mode, 0) * p.mu_k * s.F_N[k])


def mean_impulse(s, k, r, p):
    """Coefficient k of F_N in chatter; appends that of s.rate and s.closing.

    After an impact by Eq. (13) the gap opens at `rate` = (x1' - x2') phi, in flight it closes with the
    acceleration `closing`. So a flight lasts T = 2 rate/closing, and the impact at its end changes the gap's
    rate by -2 rate: per time by -closing. That is the impulse p (1/M + 1/m + (x1 - x2)^2/J); for T -> 0 the
    impulses per time are the force that keeps the gap's rate at zero.
    """
    x1, y1, x2, y2, phi = (-force * inverse for force, inverse in zip(r, p.inverse_inertia))
    s.slide.append(s.w[0][k] - s.w[2][k])
    s.slide_rate.append(x1 - x2)
    s.tilt.append(phi)
    turning = product(s.offset, s.tilt, k) + 2 * product(s.slide, s.w[4], k)
    s.closing.append(y2 - y1 - turning - product(s.slide_rate, s.q[4], k))
    s.rate.append(product(s.slide, s.q[4], k))
    s.compliance.append((0 if k else 1 / p.M + 1 / p.m) + product(s.offset, s.offset, k) * p.inverse_J)
    known = mp.fdot(s.compliance[1:], s.F_N[::-1])  # closing = compliance F_N, solved for coefficient k
    return (s.closing[k] - known) / s.compliance[0]


def series(state, mode, p, order):
    """Taylor coefficients of coordinates q, velocities w, gap, F_N, F_T and v_r about a state (q, w)."""
    q, w = [[c] for c in state[:5]], [[c] for c in state[5:]]
    lists = "offset gap square F_N F_T slide slide_rate tilt closing rate compliance"
    s = SimpleNamespace(q=q, w=w, **{name: [] for name in lists.split()})
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
    if mode == "chatter":  # flights come to nothing, or last twice as long as those replaced
        return {"rate": s.rate, "flight": [p.chatter * c - r for c, r in zip(s.closing, s.rate)]}
    return {"gap": s.gap, "v_r": [SIGN[mode] * c for c in s.v_r]}
