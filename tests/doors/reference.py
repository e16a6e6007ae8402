"""The reference system of a mechanism: masses and forces by Lagrange's equations, as numbers of a state.

d/dt dT/dv - dT/dq = Q is written out for T(q, v, t): M a = Q + dT/dq - (d2T/dv dq) v - d2T/dv dt.  sympy
differentiates, and prints one function of numbers.  The forces of contacts that hold a velocity follow
from one linear system.  Nothing comes from the package.
"""

from __future__ import annotations

from itertools import product
from operator import mul
from types import SimpleNamespace
from typing import Any

import numpy as np
import sympy

from tests.doors.mechanism import FUNCTIONS, Law, Mechanism, Rub, Touch, Wall, evaluated
from tests.reference.friction import law as friction_law
from tests.reference.hybrid import Next, System, Undecided

SIGN = {"slip+": 1.0, "slip-": -1.0}
DEAD = 1e-7  # compliance of a direction, by the largest, below which it can hold nothing
SINGULAR = 1e-12  # share of a matrix's largest entry, below which a pivot is none
FAINT = 1e-6  # speed of an impact, by the fastest so far, at which an accumulation is left alone


class Reference(System):
    """Contacts decide one by one, the others kept; those that can be lost by their springs, too."""

    def __init__(self, one: Mechanism) -> None:
        self.one, self.n, self.period = one, one.n, one.period
        self.laws_of = [None if isinstance(c, Wall) else _law(c.law) for c in one.contacts]
        self.layers = tuple(layer for law in self.laws_of if law is not None for layer in law.layers)
        self.layers += tuple(state.layer for state in one.further if state.layer is not None)
        self.further = len(one.further)
        self.numbers = _numbers(one)
        self.fastest = [0.0] * len(one.contacts)
        self.now = 0.0

    # --- one state

    def at(self, t: float, z: Any) -> SimpleNamespace:
        """Mass matrix, forces, and of each contact what it needs; short lists are faster than arrays."""
        n, more = self.n, self.further
        flat = self.numbers(t, *z)
        first, row = n * n + n, 4 + 2 * n
        contacts = [flat[first + i * row : first + (i + 1) * row] for i in range(len(self.one.contacts))]
        return SimpleNamespace(
            mass=[flat[i * n : i * n + n] for i in range(n)],
            free=flat[n * n : first],
            value=[c[0] for c in contacts],  # v_r, or the rate of the distance
            bias=[c[1] for c in contacts],  # what its rate has besides J a
            place=[c[2] for c in contacts],  # penetration or distance
            normal=[c[3] for c in contacts],
            J=[c[4 : 4 + n] for c in contacts],
            out=[c[4 + n :] for c in contacts],  # direction of the normal force
            rates=flat[len(flat) - 2 * more : len(flat) - more],  # of further states
            steep=flat[len(flat) - more :],
        )

    def forces(self, mode: Any, t: float, z: Any) -> tuple[list[float], list[float], Any]:
        """Accelerations, the force of each contact along -J, and the numbers of the state."""
        at = self.at(t, z)
        total, force = at.free, [0.0] * len(mode)
        held = []
        for i, word in enumerate(mode):
            if isinstance(self.one.contacts[i], Touch) and word != "separation":
                total = _plus(total, at.normal[i], at.out[i])
            if word in SIGN:
                force[i] = SIGN[word] * self.laws_of[i].kinetic(at.normal[i], SIGN[word] * at.value[i])
                total = _plus(total, -force[i], at.J[i])
            elif word in ("stick", "contact"):
                held.append(i)
        rates, *pushes = _solved(at.mass, [total, *(at.J[i] for i in held)])
        if held:
            drive = [_dot(at.J[i], rates) + at.bias[i] for i in held]
            for i, push, holding in zip(held, pushes, _holding(at, held, pushes, drive), strict=True):
                rates, force[i] = _plus(rates, -holding, push), holding
        return rates, force, at

    def rate(self, mode: Any, t: float, z: np.ndarray) -> Any:
        self.now, z = t, z.tolist()
        accelerations, _, at = self.forces(mode, t, z)
        return [*z[self.n : 2 * self.n], *accelerations, *at.rates]

    def speeds(self, mode: Any, z: np.ndarray) -> list[float]:
        at = self.at(self.now, z.tolist())
        sliding = [SIGN[word] * at.value[i] for i, word in enumerate(mode) if word in SIGN]
        steep = [at.steep[i] for i, state in enumerate(self.one.further) if state.layer is not None]
        return sliding + steep

    def longest_step(self, mode: Any, z: np.ndarray, rate: np.ndarray) -> float:
        waves = [c.wave for c in self.one.contacts if isinstance(c, Wall) and c.wave]
        limit = min(waves, default=np.inf) / (12 * abs(z[self.n]) + 1e-300)
        return min(limit, self.period / 6)

    # --- events

    def named(self, mode: Any, t: float, z: Any) -> list[tuple[int, str, float]]:
        """Event functions of a mode: contact, name, value."""
        if "stick" in mode or "contact" in mode:
            _, force, at = self.forces(mode, t, z)
        else:  # the others' guards are not those of forces
            force, at = [], self.at(t, z)
        rows = []
        for i, word in enumerate(mode):
            if word == "separation":
                rows.append((i, "land", -at.place[i]))
            elif word == "flight":
                rows.append((i, "impact", at.place[i]))
            elif word == "contact":
                rows.append((i, "off", -force[i]))  # the reaction acts along +J
            else:
                if word == "stick":
                    limit = self.laws_of[i].static(at.normal[i])
                    rows += [(i, "slip+", limit - force[i]), (i, "slip-", limit + force[i])]
                else:
                    rows.append((i, "stop", SIGN[word] * at.value[i]))
                if isinstance(self.one.contacts[i], Touch):
                    rows.append((i, "separation", at.place[i]))
        return rows

    def guards(self, mode: Any, t: Any, z: Any) -> np.ndarray:
        if np.ndim(t) == 0:
            return np.array([value for *_, value in self.named(mode, float(t), z.tolist())])
        return np.array([self.guards(mode, s, z[:, j]) for j, s in enumerate(t)]).T

    def start(self, z: np.ndarray) -> tuple[str, ...]:
        at = self.at(0.0, z.tolist())
        words = []
        for i, contact in enumerate(self.one.contacts):
            if isinstance(contact, Wall):
                words.append("flight")
            elif isinstance(contact, Touch) and at.place[i] < 0:
                words.append("separation")
            else:
                words.append("slip+" if at.value[i] > 0 else "slip-")
        return tuple(words)

    def leave(self, mode: Any, guard: int, t: float, z: np.ndarray) -> Next:
        i, kind, _ = self.named(mode, t, z.tolist())[guard]
        at = self.at(t, z.tolist())
        if kind == "land":
            return Next(_with(mode, i, "slip+" if at.value[i] > 0 else "slip-"), z)
        if kind == "impact":
            return self.impact(mode, i, t, z, at)
        if kind in ("off", "separation"):
            return Next(_with(mode, i, "flight" if kind == "off" else kind), z)
        if kind != "stop":
            return Next(self.settled(mode, i, (kind,), t, z), z)
        return self.stop(mode, i, t, z, at)

    def settled(self, mode: Any, i: int, first: tuple[str, ...], t: float, z: Any) -> tuple[str, ...]:
        """The mode in which the rates agree with the regimes of all contacts at v_r = 0.

        The others are kept if they can be; else all combinations are tried, and one only may do.
        """
        for word in first:
            if self.lasts(_with(mode, i, word), i, t, z, mode[i] == "stick"):
                return _with(mode, i, word)
        still = [j for j, word in enumerate(mode) if word == "stick" or j == i]
        some = []
        for words in product(("stick", "slip+", "slip-"), repeat=len(still)):
            tried = list(mode)
            for j, word in zip(still, words, strict=True):
                tried[j] = word
            if all(self.lasts(tuple(tried), j, t, z) for j in still):
                some.append(tuple(tried))
        if len(some) != 1:
            raise Undecided(f"{len(some)} modes may follow {mode} at {t!r} s")
        return some[0]

    def lasts(self, mode: Any, i: int, t: float, z: Any, breaks: bool = False) -> bool:
        """Whether contact i, at v_r = 0, and those that stick agree with the forces of a mode.

        `breaks` says that its holding force has just reached its limit.
        """
        try:
            rates, force, at = self.forces(mode, t, z.tolist())
        except np.linalg.LinAlgError:
            return False
        for j, word in enumerate(mode):
            if word == "stick" and not abs(force[j]) < self.laws_of[j].static(at.normal[j]):
                return False
            if word in SIGN and j == i:
                # Zero up to rounding at breakaway under a law that is continuous at rest: rates decide later.
                slack = 1e-9 * max(map(abs, at.J[j])) * max(map(abs, rates)) if breaks else 0.0
                if not SIGN[word] * (_dot(at.J[j], rates) + at.bias[j]) > -slack:
                    return False
        return True

    def stop(self, mode: Any, i: int, t: float, z: np.ndarray, at: Any) -> Next:
        """Stick where v_r comes to zero, if the force allows; slip the other way else."""
        (along,) = _solved(at.mass, [at.J[i]])
        softness = _dot(at.J[i], along)
        other = "slip-" if mode[i] == "slip+" else "slip+"
        if softness * max(map(max, at.mass)) < DEAD**2:
            raise Undecided(f"a dead centre at {t!r} s")
        stuck = _with(mode, i, "stick")
        if self.may_hold_together(stuck, i, t, z):
            raise Undecided(f"contacts of one direction come to rest together at {t!r} s")
        held = [j for j, word in enumerate(stuck) if word in ("stick", "contact")]
        pushes = _solved(at.mass, [at.J[j] for j in held])
        z = z.copy()
        for push, impulse in zip(
            pushes, _holding(at, held, pushes, [at.value[j] for j in held]), strict=True
        ):
            z[self.n : 2 * self.n] -= impulse * np.array(push)
        return Next(self.settled(mode, i, ("stick", other), t, z), z)

    def may_hold_together(self, stuck: Any, i: int, t: float, z: np.ndarray) -> bool:
        """Whether contact i sticks with others that rub along its direction and are at rest too.

        Only the sum of such forces is known, which `forces` cannot share.
        """
        _, force, at = self.forces(stuck, t, z.tolist())
        speed = max(map(abs, z[: self.n])) / self.period
        needed, most = force[i], self.laws_of[i].static(at.normal[i])
        alike = False
        for j, word in enumerate(stuck):
            ratio = _dot(at.J[j], at.J[i]) / _dot(at.J[i], at.J[i])
            along = max(abs(a - ratio * b) for a, b in zip(at.J[j], at.J[i], strict=True))
            if word in SIGN and along <= 1e-9 * abs(ratio) and abs(at.value[j]) <= 1e-9 * speed:
                alike = True
                needed += ratio * force[j]
                most += abs(ratio) * self.laws_of[j].static(at.normal[j])
        return alike and abs(needed) < most

    def impact(self, mode: Any, i: int, t: float, z: np.ndarray, at: Any) -> Next:
        """Newton's restitution along the gradient of the distance; other contacts slip as they then move."""
        e = self.one.contacts[i].e
        speed = -at.value[i]
        self.fastest[i] = max(self.fastest[i], speed)
        if e > 0 and speed < FAINT * self.fastest[i]:
            raise Undecided(f"impacts accumulate at {t!r} s")
        z = z.copy()
        (push,) = _solved(at.mass, [at.J[i]])
        z[self.n : 2 * self.n] += np.array(push) * (1 + e) * speed / _dot(at.J[i], push)
        after = self.at(t, z.tolist())
        words = [
            ("slip+" if after.value[j] > 0 else "slip-")
            if word in ("stick", "slip+", "slip-") and abs(after.value[j]) > 1e-12
            else word
            for j, word in enumerate(mode)
        ]
        words[i] = "flight"
        if e == 0:
            words[i] = "contact"
            if self.forces(words, t, z.tolist())[1][i] > 0:
                words[i] = "flight"
        return Next(tuple(words), z, abs(speed))


def _dot(a: list[float], b: list[float]) -> float:
    return sum(map(mul, a, b))


def _plus(a: list[float], factor: float, b: list[float]) -> list[float]:
    """a + factor b."""
    return [x + factor * y for x, y in zip(a, b, strict=True)]


def _holding(at: Any, held: list[int], pushes: list[list[float]], drive: list[float]) -> list[float]:
    """The forces of the held contacts that take `drive` away, where `pushes` are M^-1 J."""
    return _solved([[_dot(at.J[i], push) for push in pushes] for i in held], [drive])[0]


def _solved(matrix: list[list[float]], sides: list[list[float]]) -> list[list[float]]:
    """The solutions of a few equations for each right side, by Gauss with pivots."""
    n = len(matrix)
    rows = [[*row, *(side[i] for side in sides)] for i, row in enumerate(matrix)]
    least = SINGULAR * max(abs(x) for row in matrix for x in row)
    for i in range(n):
        pivot = max(range(i, n), key=lambda j: abs(rows[j][i]))
        if not abs(rows[pivot][i]) > least:
            raise np.linalg.LinAlgError("Singular matrix")
        rows[i], rows[pivot] = rows[pivot], rows[i]
        rows[i] = [x / rows[i][i] for x in rows[i]]
        for j in range(n):
            if j != i and rows[j][i] != 0.0:
                rows[j] = _plus(rows[j], -rows[j][i], rows[i])
    return [[row[n + k] for row in rows] for k in range(len(sides))]


def _with(mode: Any, i: int, word: str) -> tuple[str, ...]:
    return (*mode[:i], word, *mode[i + 1 :])


def _law(law: Law) -> Any:
    return friction_law(law.name, SimpleNamespace(**dict(law.numbers)))


def _numbers(one: Mechanism) -> Any:
    """A function of t, coordinates, velocities and further states: M, forces without contacts, the rows of
    contacts, the rates of further states and what these are steep in.
    """
    n = one.n
    t = sympy.Symbol("t", real=True)
    q = sympy.symbols(f"q1:{n + 1}", real=True)
    v = sympy.symbols(f"v1:{n + 1}", real=True)
    names = {name: getattr(sympy, name) for name in FUNCTIONS}
    names |= {f"q{i + 1}": x for i, x in enumerate(q)} | {f"v{i + 1}": x for i, x in enumerate(v)}
    s = sympy.symbols(one.names, real=True)
    names |= {"p": one.frequency * t, **dict(zip(one.names, s, strict=True))}
    energies = (one.kinetic, one.potential, one.dissipation)
    T, V, D = (sympy.sympify(evaluated(text, names)) for text in energies)
    loads = [evaluated(text, names) for text in one.loads]
    momenta = [T.diff(x) for x in v]
    mass = [[p.diff(x) for x in v] for p in momenta]
    free = [
        load + T.diff(x) - V.diff(x) - D.diff(u) - sum(p.diff(y) * w for y, w in zip(q, v)) - p.diff(t)
        for load, x, u, p in zip(loads, q, v, momenta, strict=True)
    ]
    flat = [entry for row in mass for entry in row] + free
    for contact in one.contacts:
        zero = sympy.S.Zero
        if isinstance(contact, Wall):
            place = sympy.sympify(evaluated(contact.distance, names))
            value = sum(place.diff(x) * w for x, w in zip(q, v)) + place.diff(t)
            normal, out = zero, [zero] * n
        else:
            value = sympy.sympify(evaluated(contact.speed, names))
            if isinstance(contact, Rub):
                place, normal, out = zero, sympy.sympify(evaluated(contact.normal, names)), [zero] * n
            else:
                place = sympy.sympify(evaluated(contact.penetration, names))
                normal, out = contact.k * place + contact.k3 * place**3, [-place.diff(x) for x in q]
        bias = sum(value.diff(x) * w for x, w in zip(q, v)) + value.diff(t)
        flat += [value, bias, place, normal, *(value.diff(w) for w in v), *out]
    flat += [sympy.sympify(evaluated(state.rate, names)) for state in one.further]
    flat += [sympy.sympify(evaluated(state.steep, names)) for state in one.further]
    return sympy.lambdify((t, *q, *v, *s), flat, modules="math", cse=True)
