"""How derivation, equilibrium and run grow with the number of contacts, and with that of the states.

Each row is measured in a process of its own, as its memory is the largest that the process ever had:
``python -m frictionlab.bench.many_contacts`` measures all and prints them as Markdown.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from itertools import pairwise
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np

import frictionlab as fl
from frictionlab.components.friction import FrictionLaw
from frictionlab.models import Friction, MechanicalModel, Mechanics, with_signature
from frictionlab.presentation import markdown_table
from frictionlab.validation import check_choice

CHAIN_CONTACTS = (2, 4, 6, 7, 8, 10, 20, 30)
BEAM_STATES = (20, 40, 100, 200)
CHAIN_SECONDS = 20.0  # length of a run of a chain, in which it sticks and slips
BEAM_SECONDS = 0.02  # length of a run of a beam: some periods of its first bending mode
LONGEST = 600.0  # s: what takes longer is ended


@with_signature
@dataclass(frozen=True, init=False, repr=False)
class Chain(MechanicalModel):
    """Blocks in a row on one belt, each on a spring of its own and one to the next, each with a contact."""

    k: float = fl.parameter(1.0, unit="N/m", symbol="k", meaning="stiffness to the ground", range=(0.1, 10.0))
    kc: float = fl.parameter(1.2, unit="N/m", symbol="k_c", meaning="stiffness between", range=(0.1, 10.0))
    v: float = fl.parameter(0.2, unit="m/s", symbol="v", meaning="speed of the belt", range=(0.0, 10.0))
    friction: FrictionLaw = fl.Coulomb(mu_k=0.5, mu_s=1.0)
    roles: ClassVar[Any] = MappingProxyType({"friction": FrictionLaw})
    contacts: ClassVar[int]

    @property
    def coordinates(self) -> tuple[str, ...]:
        """The displacements x1, x2, ..."""
        return tuple(f"x{i + 1}" for i in range(self.contacts))

    def mechanics(self, q: Any, v: Any) -> Mechanics:
        """Masses of 1 kg, pressed on the belt by 1 N each."""
        x, u = ([getattr(at, name) for name in self.coordinates] for at in (q, v))
        springs = sum(self.k * one**2 for one in x)
        springs += sum(self.kc * (one - other) ** 2 for one, other in pairwise(x))
        return Mechanics(
            kinetic=sum(one**2 for one in u) / 2,
            potential=springs / 2,
            contacts=tuple(Friction(self.v - one, 1.0, self.friction) for one in u),
        )


def chain(contacts: int) -> Chain:
    """A chain of so many blocks."""
    return type("Chain", (Chain,), {"contacts": contacts})()


@with_signature
@dataclass(frozen=True, init=False, repr=False)
class Beam(MechanicalModel):
    """A clamped beam of finite elements by Hermite's polynomials, with a belt that rubs at its end."""

    E: float = fl.parameter(2.1e11, unit="N/m^2", symbol="E", meaning="Young's modulus", range=(1e10, 1e12))
    c: float = fl.parameter(1e-5, unit="s", symbol="c", meaning="damping per stiffness", range=(0.0, 1e-3))
    N: float = fl.parameter(50.0, unit="N", symbol="N", meaning="normal force", range=(0.0, 1e3))
    v: float = fl.parameter(0.1, unit="m/s", symbol="v", meaning="speed of the belt", range=(0.0, 10.0))
    friction: FrictionLaw = fl.Coulomb(mu_k=0.3, mu_s=0.5)
    roles: ClassVar[Any] = MappingProxyType({"friction": FrictionLaw})
    elements: ClassVar[int]
    length: ClassVar[float] = 0.5  # m
    side: ClassVar[float] = 0.01  # m, of its square section
    density: ClassVar[float] = 7850.0  # kg/m^3

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Deflection and slope of each node but the clamped one."""
        return tuple(f"{what}{i + 1}" for i in range(self.elements) for what in ("w", "r"))

    def mechanics(self, q: Any, v: Any) -> Mechanics:
        """The energies of the elements, by their matrices."""
        mass, stiffness = element_matrices(self.length / self.elements)
        x, u = ([0, 0, *(getattr(at, name) for name in self.coordinates)] for at in (q, v))
        parts = [slice(2 * i, 2 * i + 4) for i in range(self.elements)]
        bending = self.E * self.side**4 / 12
        return Mechanics(
            kinetic=self.density * self.side**2 * sum(quadratic_form(mass, u[part]) for part in parts) / 2,
            potential=bending * sum(quadratic_form(stiffness, x[part]) for part in parts) / 2,
            dissipation=self.c * bending * sum(quadratic_form(stiffness, u[part]) for part in parts) / 2,
            contacts=(Friction(self.v - u[-2], self.N, self.friction),),
        )


def element_matrices(h: float) -> tuple[np.ndarray, np.ndarray]:
    """Mass and stiffness of an element of the length `h`, (4, 4), for unit density and bending stiffness."""
    mass = [
        [156, 22 * h, 54, -13 * h],
        [22 * h, 4 * h**2, 13 * h, -3 * h**2],
        [54, 13 * h, 156, -22 * h],
        [-13 * h, -3 * h**2, -22 * h, 4 * h**2],
    ]
    stiffness = [
        [12, 6 * h, -12, 6 * h],
        [6 * h, 4 * h**2, -6 * h, 2 * h**2],
        [-12, -6 * h, 12, -6 * h],
        [6 * h, 2 * h**2, -6 * h, 4 * h**2],
    ]
    return np.array(mass) * h / 420, np.array(stiffness) / h**3


def quadratic_form(matrix: np.ndarray, x: Sequence[Any]) -> Any:
    """x^T A x."""
    return sum(float(a) * one * other for row, one in zip(matrix, x) for a, other in zip(row, x))


def beam(states: int) -> Beam:
    """A beam of so many states, a multiple of 4."""
    return type("Beam", (Beam,), {"elements": states // 4})()


@dataclass(frozen=True)
class GrowthRow:
    """Seconds of one processor, the largest memory (MB), and counts of the run."""

    scene: str
    size: int
    derivation: float
    run: float
    equilibrium: float
    memory: float
    steps: int
    events: int
    modes: int


SCENES: dict[str, Any] = {"chain": (chain, CHAIN_SECONDS), "beam": (beam, BEAM_SECONDS)}


def measure_growth(scene: str, size: int) -> GrowthRow:
    """Measure one scene in this process."""
    make, t_end = SCENES[scene]
    fl.simulate(fl.TwoBlocks(), 1.0, progress=False)  # compiles the kernels
    fl.equilibrium(fl.MassOnBelt())
    model, times = make(size), [time.process_time()]
    automaton = model.automaton()
    times.append(time.process_time())
    x0 = np.zeros(len(automaton.states))
    if scene == "chain":
        x0[:size] = np.sin(1.0 + np.arange(size))
    run = fl.simulate(model, t_end, x0=x0, progress=False)
    times.append(time.process_time())
    fl.equilibrium(model)
    times.append(time.process_time())
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    visited = len({*run.mode, *run.events.target})
    derivation, ran, rested = np.diff(times).tolist()
    events, steps = len(run.events), int(run.stats["steps"])
    return GrowthRow(scene, size, derivation, ran, rested, memory, steps, events, visited)


def measure_apart(scene: str, size: int) -> GrowthRow | str:
    """The same in a process of its own; what went wrong where it does not end well."""
    command = [sys.executable, "-m", "frictionlab.bench.many_contacts", scene, str(size)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=LONGEST, check=False)
    except subprocess.TimeoutExpired:
        return f"more than {LONGEST:g} s"
    if done.returncode:
        return (done.stderr.strip().splitlines() or [f"ended by signal {-done.returncode}"])[-1]
    return GrowthRow(**json.loads(done.stdout))


def growth_table(rows: Sequence[tuple[str, int, GrowthRow | str]]) -> str:
    """The rows as Markdown."""
    heads = "scene | size | derivation | run | equilibrium | memory | steps | events | modes visited"
    return markdown_table(heads, (f"{scene} | {size} | {_cells(row)}" for scene, size, row in rows))


def _cells(row: GrowthRow | str) -> str:
    if isinstance(row, str):
        return row + " | " * 6
    seconds = (f"{value:.2g} s" for value in (row.derivation, row.run, row.equilibrium))
    return " | ".join([*seconds, f"{row.memory:.0f} MB", str(row.steps), str(row.events), str(row.modes)])


def main(arguments: Sequence[str]) -> None:
    """Print one row as JSON, or all as Markdown."""
    if arguments:
        check_choice("scene", arguments[0], tuple(SCENES))
        print(json.dumps(asdict(measure_growth(arguments[0], int(arguments[1])))))
        return
    sizes = [*(("chain", n) for n in CHAIN_CONTACTS), *(("beam", n) for n in BEAM_STATES)]
    print(growth_table([(scene, n, measure_apart(scene, n)) for scene, n in sizes]))


if __name__ == "__main__":
    main(sys.argv[1:])
