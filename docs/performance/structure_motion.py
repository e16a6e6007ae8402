"""Motion of a beam on a belt, reduced to modes: Taylor series, DOP853 and Moreau's scheme.

Prints the rows of the table in docs/how-to/structures.md.  DOP853 (scipy) takes the regimes and the times of
the events from the run; Moreau's scheme finds its own and shares no code with the package.  Seconds are of
the processor.

    python docs/performance/structure_motion.py 10 1 1.0     modes, contacts, seconds of motion
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.linalg
from scipy.integrate import solve_ivp

import frictionlab as fl

BENDING, MASS, SPEED, STEP = 200.0, 2.0, 0.05, 1e-5  # N m^2, kg/m, m/s, s
CONTACT, CUBIC, SUPPORT, LOAD = 4e4, 1e10, 6e3, 20.0  # N/m, N/m^3, N/m, N


def bending_matrices(elements: int) -> tuple[np.ndarray, np.ndarray]:
    """Masses and stiffness of a simply supported beam of length 1 m, by Hermite's cubics."""
    h = 1.0 / elements
    stiff = [[12, 6 * h, -12, 6 * h], [6 * h, 4 * h * h, -6 * h, 2 * h * h]]
    stiff += [[-12, -6 * h, 12, -6 * h], [6 * h, 2 * h * h, -6 * h, 4 * h * h]]
    heavy = [[156, 22 * h, 54, -13 * h], [22 * h, 4 * h * h, 13 * h, -3 * h * h]]
    heavy += [[54, 13 * h, 156, -22 * h], [-13 * h, -3 * h * h, -22 * h, 4 * h * h]]
    M, K = np.zeros((2, 2 * elements + 2, 2 * elements + 2))
    for i in range(elements):
        place = slice(2 * i, 2 * i + 4)
        K[place, place] += BENDING / h**3 * np.array(stiff)
        M[place, place] += MASS * h / 420 * np.array(heavy)
    free = [i for i in range(2 * elements + 2) if i not in (0, 2 * elements)]
    return M[np.ix_(free, free)], K[np.ix_(free, free)]


def beam_on_belt(modes: int, contacts: int) -> fl.Structure:
    """A beam that bends in two directions, which a slanted spring couples in its middle."""
    one, bent = bending_matrices(max(modes // 2 + 4, 2 * contacts + 4, 12))
    n = len(one)
    M, K = (np.asarray(scipy.linalg.block_diag(a, b)) for a, b in ((one, one), (bent, 1.45 * bent)))
    deflections = np.arange(1, n - 1, 2)
    middle = deflections[len(deflections) // 2]
    K[np.ix_([middle, n + middle], [middle, n + middle])] += SUPPORT
    nodes = deflections[np.linspace(0, len(deflections) - 1, contacts + 2).round().astype(int)[1:-1]]
    G, T = np.zeros((2, contacts, 2 * n))
    G[np.arange(contacts), nodes] = T[np.arange(contacts), n + nodes] = 1.0
    basis = scipy.linalg.eigh(K + G.T @ G * CONTACT / contacts, M)[1][:, :modes]
    M, K, G, T = basis.T @ M @ basis, basis.T @ K @ basis, G @ basis, T @ basis
    pads = fl.SlidingContacts(
        T,
        G,
        contact=fl.CubicContact(k2=CONTACT / contacts, k_nl=CUBIC / contacts),
        friction=fl.Coulomb(mu_k=0.5, mu_s=0.5),
        v=SPEED,
    )
    return fl.Structure(
        (M + M.T) / 2,
        (K + K.T) / 2,
        fl.RayleighDamping(alpha=0.5, beta=2e-7),
        contacts=pads,
        load=G.sum(axis=0) * LOAD / contacts,
    )


@dataclass(frozen=True)
class Matrices:
    """The structure's numbers, for the methods that are not the package's."""

    M: np.ndarray
    C: np.ndarray
    K: np.ndarray
    G: np.ndarray
    T: np.ndarray
    load: np.ndarray
    contacts: int

    @staticmethod
    def of(structure: Any) -> Matrices:
        """Those of a structure."""
        values, (pads,) = structure.parameters, structure.contacts
        M, K = (matrix.at(values).toarray() for matrix in (structure.M, structure.K))
        C = values["alpha"] * M + values["beta"] * K
        G, T = pads.normal.toarray(), pads.tangential.toarray()
        return Matrices(M, C, K, G, T, structure.load_vector, len(G))

    def pressing(self, q: np.ndarray) -> np.ndarray:
        """Normal forces (contacts,)."""
        depth = np.maximum(self.G @ q, 0.0)
        return (CONTACT * depth + CUBIC * depth**3) / self.contacts


def start(structure: fl.Structure, of: Matrices) -> np.ndarray:
    """At the equilibrium, with three times the belt's speed in the first mode that rubs."""
    stiff = of.K + of.G.T @ of.G * CONTACT / of.contacts
    shapes = scipy.linalg.eigh(stiff, of.M)[1]
    along, across = (np.abs(rows @ shapes).max(axis=0) for rows in (of.T, of.G))
    rubs = along * (along > 3 * across)
    mode = shapes[:, np.argmax(rubs > 0.3 * rubs.max())]
    speeds = of.T @ mode
    return np.concatenate([structure.displacements, mode * 3 * SPEED / speeds[np.argmax(np.abs(speeds))]])


def dop853(of: Matrices, run: Any, x0: np.ndarray) -> np.ndarray:
    """The state at the end, by DOP853 from event to event of a run."""
    inverse, n = np.linalg.inv(of.M), len(of.M)
    pushed, softness = inverse @ of.T.T, of.T @ inverse @ of.T.T

    def rates(words: list[str]) -> Callable[[float, np.ndarray], np.ndarray]:
        sign = np.array([{"slip+": 1.0, "slip-": -1.0}.get(word, 0.0) for word in words])
        held = [i for i, word in enumerate(words) if word == "stick"]
        stiff = np.linalg.inv(softness[np.ix_(held, held)])

        def function(_: float, x: np.ndarray) -> np.ndarray:
            q, v = x[:n], x[n:]
            force = of.pressing(q)
            a = inverse @ (of.load - of.K @ q - of.C @ v - of.G.T @ force) + pushed @ (sign * 0.5 * force)
            return np.concatenate([v, a - pushed[:, held] @ (stiff @ (of.T[held] @ a))])

        return function

    times = [0.0, *run.events.t, run.t[-1]]
    names = [str(run.mode[0]), *map(str, run.events.target)]
    x = x0
    for begin, end, name in zip(times, times[1:], names, strict=False):
        if end > begin:
            x = solve_ivp(rates(name.split(" | ")), (begin, end), x, "DOP853", rtol=1e-9, atol=1e-12).y[:, -1]
    return x


def moreau(of: Matrices, x0: np.ndarray, t_end: float) -> np.ndarray:
    """The state at the end, by Moreau's time-stepping with the midpoint rule; impulses by projection."""
    n, h = len(of.M), STEP
    inverse = np.linalg.inv(of.M + h / 2 * of.C + h * h / 4 * of.K)
    softness, pushed, pressed = of.T @ inverse @ of.T.T, inverse @ of.T.T, h * inverse @ of.G.T
    by_q, by_v, by_load = -h * inverse @ of.K, -h * inverse @ (of.C + h / 2 * of.K), h * inverse @ of.load
    q, v, impulse = x0[:n].copy(), x0[n:].copy(), np.zeros(of.contacts)
    for _ in range(round(t_end / h)):
        force = of.pressing(q + h / 2 * v)
        free = v + by_q @ q + by_v @ v + by_load - pressed @ force
        wanted, limit = SPEED - of.T @ free, h * 0.5 * force
        for _ in range(50):
            largest = 0.0
            for i in range(of.contacts):
                new = impulse[i] + (wanted[i] - softness[i] @ impulse) / softness[i, i]
                new = min(max(new, -limit[i]), limit[i])
                largest, impulse[i] = max(largest, abs(new - impulse[i])), new
            if largest <= 1e-10 * limit.max():
                break
        new = free + pushed @ impulse
        q, v = q + h / 2 * (v + new), new
    return np.concatenate([q, v])


def timed(function: Callable[[], Any]) -> tuple[Any, float]:
    """What a function gives, and its processor time."""
    begin = time.process_time()
    value = function()
    return value, time.process_time() - begin


def main() -> None:
    """Print one row of the table."""
    modes, contacts, t_end = int(sys.argv[1]), int(sys.argv[2]), float(sys.argv[3])
    structure = beam_on_belt(modes, contacts)
    of = Matrices.of(structure)
    x0 = start(structure, of)

    def run() -> Any:
        return fl.simulate(structure, t_end, x0=x0, progress=False)

    _, first = timed(run)
    exact, again = timed(run)

    def error(q: np.ndarray) -> float:
        """By the largest coordinate."""
        return float(np.abs(q - exact.q[-1]).max() / np.abs(exact.q[-1]).max())

    by_dop, dop = timed(lambda: dop853(of, exact, x0))
    by_steps, steps = timed(lambda: moreau(of, x0, t_end))
    stiff = of.K + of.G.T @ of.G * CONTACT / contacts
    fastest = np.sqrt(scipy.linalg.eigh(stiff, of.M, eigvals_only=True)[-1]) / (2e3 * np.pi)
    modes_of_run: Any = structure.automaton().modes
    known = len(modes_of_run.derived if contacts > 1 else modes_of_run)
    cells = [2 * modes, contacts, f"{fastest:.1f} kHz", len(exact.events), known]
    cells += [f"{first:.2g} s", f"{again:.2g} s"]
    cells += [
        f"{dop:.2g} s",
        f"{error(by_dop[:modes]):.0e}",
        f"{steps:.2g} s",
        f"{error(by_steps[:modes]):.0e}",
    ]
    print("|", " | ".join(map(str, cells)), "|", exact.status.name)


if __name__ == "__main__":
    main()
