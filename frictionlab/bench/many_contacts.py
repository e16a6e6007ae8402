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
from pathlib import Path
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np

import frictionlab as fl
from frictionlab.components.friction import FrictionLaw
from frictionlab.models import Friction, MechanicalModel, Mechanics, quadratic_form, with_signature
from frictionlab.presentation import markdown_table
from frictionlab.validation import check_choice

CHAIN_CONTACTS = (2, 4, 6, 7, 8, 10, 20, 30)
ROD_STATES = (20, 50, 100, 200)
CHAIN_SECONDS = 20.0  # length of a run of a chain, in which it sticks and slips
ROD_SECONDS = 0.005  # length of a run of a rod: a dozen periods of its first mode
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
class Rod(MechanicalModel):
    """A rod of linear finite elements, clamped at one end; at the other it rubs on a belt along it."""

    E: float = fl.parameter(2.1e11, unit="N/m^2", symbol="E", meaning="Young's modulus", range=(1e10, 1e12))
    rho: float = fl.parameter(7850.0, unit="kg/m^3", symbol=r"\rho", meaning="density", range=(1e3, 1e4))
    c: float = fl.parameter(1e-8, unit="s", symbol="c", meaning="damping per stiffness", range=(0.0, 1e-5))
    N: float = fl.parameter(500.0, unit="N", symbol="N", meaning="normal force", range=(0.0, 1e4))
    v: float = fl.parameter(0.02, unit="m/s", symbol="v", meaning="speed of the belt", range=(0.0, 10.0))
    friction: FrictionLaw = fl.Coulomb(mu_k=0.3, mu_s=0.5)
    roles: ClassVar[Any] = MappingProxyType({"friction": FrictionLaw})
    elements: int = 10
    length: ClassVar[float] = 0.5  # m
    area: ClassVar[float] = 1e-4  # m^2

    @property
    def coordinates(self) -> tuple[str, ...]:
        """The displacements of all nodes but the clamped one."""
        return tuple(f"u{i + 1}" for i in range(self.elements))

    def mechanics(self, q: Any, v: Any) -> Mechanics:
        """The energies by matrices; those are of a rod of unit density and stiffness."""
        mass, stiffness = rod_matrices(self.elements, self.length / self.elements)
        x, u = ([getattr(at, name) for name in self.coordinates] for at in (q, v))
        return Mechanics(
            kinetic=self.rho * self.area * quadratic_form(mass, u) / 2,
            potential=self.E * self.area * quadratic_form(stiffness, x) / 2,
            dissipation=self.c * self.E * self.area * quadratic_form(stiffness, u) / 2,
            contacts=(Friction(self.v - u[-1], self.N, self.friction),),
        )


def rod_matrices(elements: int, h: float) -> tuple[np.ndarray, np.ndarray]:
    """Consistent mass and stiffness, (elements, elements), of elements of the length `h`."""
    mass, stiffness = np.zeros((2, elements + 1, elements + 1))
    for i in range(elements):
        mass[i : i + 2, i : i + 2] += np.array([[2.0, 1.0], [1.0, 2.0]]) * h / 6
        stiffness[i : i + 2, i : i + 2] += np.array([[1.0, -1.0], [-1.0, 1.0]]) / h
    return mass[1:, 1:], stiffness[1:, 1:]


def rod(states: int) -> Rod:
    """A rod of so many states."""
    return Rod(elements=states // 2)


@dataclass(frozen=True)
class GrowthRow:
    """Seconds of one processor, the largest memory (MB), and counts of the run."""

    scene: str
    size: int
    derivation: float
    run: float
    equilibrium: float
    eigenvalues: float
    memory: float
    steps: int
    events: int
    modes: int


SCENES: dict[str, Any] = {"chain": (chain, CHAIN_SECONDS), "rod": (rod, ROD_SECONDS)}


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
    fl.eigenvalues(model)
    times.append(time.process_time())
    memory = largest_memory()
    visited = len({*run.mode, *run.events.target})
    derivation, ran, rested, linearised = np.diff(times).tolist()
    events, steps = len(run.events), int(run.stats["steps"])
    return GrowthRow(scene, size, derivation, ran, rested, linearised, memory, steps, events, visited)


def largest_memory() -> float:
    """The largest memory that this process ever had, MB."""
    status = Path("/proc/self/status")
    if status.exists():  # resource would count the process that started this one, before it was replaced
        (line,) = (line for line in status.read_text().splitlines() if line.startswith("VmHWM:"))
        return int(line.split()[1]) / 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


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
    heads = "scene | size | derivation | run | equilibrium | eigenvalues | memory | steps | events | modes"
    return markdown_table(heads, (f"{scene} | {size} | {_cells(row)}" for scene, size, row in rows))


def _cells(row: GrowthRow | str) -> str:
    if isinstance(row, str):
        return row + " | " * 7
    seconds = (f"{value:.2g} s" for value in (row.derivation, row.run, row.equilibrium, row.eigenvalues))
    return " | ".join([*seconds, f"{row.memory:.0f} MB", str(row.steps), str(row.events), str(row.modes)])


def main(arguments: Sequence[str]) -> None:
    """Print one row as JSON, or all as Markdown."""
    if arguments:
        check_choice("scene", arguments[0], tuple(SCENES))
        print(json.dumps(asdict(measure_growth(arguments[0], int(arguments[1])))))
        return
    sizes = [*(("chain", n) for n in CHAIN_CONTACTS), *(("rod", n) for n in ROD_STATES)]
    print(growth_table([(scene, n, measure_apart(scene, n)) for scene, n in sizes]))


if __name__ == "__main__":
    main(sys.argv[1:])
