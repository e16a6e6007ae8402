"""Models that can be made as large as one likes: a chain of blocks, and a rod of finite elements."""

from __future__ import annotations

from itertools import pairwise
from typing import Any, ClassVar

import numpy as np

import frictionlab as fl
from frictionlab.components.friction import FrictionLaw
from frictionlab.models import Friction, MechanicalModel, Mechanics, quadratic_form


@fl.model
class Chain(MechanicalModel):
    """Blocks in a row on one belt, each with a contact, a spring to the ground and one to the next block."""

    k: float = fl.parameter(1.0, unit="N/m", symbol="k", meaning="stiffness to the ground", range=(0.1, 10.0))
    kc: float = fl.parameter(1.2, unit="N/m", symbol="k_c", meaning="stiffness between", range=(0.1, 10.0))
    v: float = fl.parameter(0.2, unit="m/s", symbol="v", meaning="speed of the belt", range=(0.0, 10.0))
    friction: FrictionLaw = fl.Coulomb(mu_k=0.5, mu_s=1.0)
    contacts: ClassVar[int]

    @property
    def coordinates(self) -> tuple[str, ...]:
        """The displacements x1, x2, ..."""
        return tuple(f"x{i + 1}" for i in range(self.contacts))

    def mechanics(self, q: Any, v: Any) -> Mechanics:
        """Masses of 1 kg, pressed on the belt by 1 N each."""
        springs = sum(self.k * one**2 for one in q)
        springs += sum(self.kc * (one - other) ** 2 for one, other in pairwise(q))
        return Mechanics(
            kinetic=sum(one**2 for one in v) / 2,
            potential=springs / 2,
            contacts=tuple(Friction(self.v - one, 1.0, self.friction) for one in v),
        )


def chain(contacts: int) -> Chain:
    """A chain of so many blocks."""
    return type("Chain", (Chain,), {"contacts": contacts})()


@fl.model
class Rod(MechanicalModel):
    """A rod of linear finite elements, clamped at one end; at the other it rubs on a belt along it."""

    E: float = fl.parameter(2.1e11, unit="N/m^2", symbol="E", meaning="Young's modulus", range=(1e10, 1e12))
    rho: float = fl.parameter(7850.0, unit="kg/m^3", symbol=r"\rho", meaning="density", range=(1e3, 1e4))
    c: float = fl.parameter(1e-8, unit="s", symbol="c", meaning="damping per stiffness", range=(0.0, 1e-5))
    N: float = fl.parameter(500.0, unit="N", symbol="N", meaning="normal force", range=(0.0, 1e4))
    v: float = fl.parameter(0.02, unit="m/s", symbol="v", meaning="speed of the belt", range=(0.0, 10.0))
    friction: FrictionLaw = fl.Coulomb(mu_k=0.3, mu_s=0.5)
    elements: int = 10
    length: ClassVar[float] = 0.5  # m
    area: ClassVar[float] = 1e-4  # m^2

    @property
    def coordinates(self) -> tuple[str, ...]:
        """The displacements of all nodes but the clamped one."""
        return tuple(f"u{i + 1}" for i in range(self.elements))

    def mechanics(self, q: Any, v: Any) -> Mechanics:
        """The energies, from the matrices of a rod with unit mass and unit axial stiffness per length."""
        mass, stiffness = rod_matrices(self.elements, self.length / self.elements)
        return Mechanics(
            kinetic=self.rho * self.area * quadratic_form(mass, v) / 2,
            potential=self.E * self.area * quadratic_form(stiffness, q) / 2,
            dissipation=self.c * self.E * self.area * quadratic_form(stiffness, v) / 2,
            contacts=(Friction(self.v - v[-1], self.N, self.friction),),
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
