"""A case: a model, where it starts, how long it runs, how exactly; written as one line of code."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import frictionlab as fl
from frictionlab.components import CubicContact, FixedLoad, LinearContact, StickSlip, StickSlipSeparation
from tests.differential.laws import OWN

MAX_STEPS = 300_000  # a case is made for some thousand; a run that needs more does not get on


@dataclass(frozen=True)
class Case:
    """A run to compare; x0 holds coordinates, then velocities."""

    model: Any
    x0: tuple[float, ...]
    t_end: float
    tol: float = 1e-15
    order: int | None = None

    @property
    def method(self) -> fl.Taylor:
        return fl.Taylor(tol=self.tol, order=self.order, max_steps=MAX_STEPS)

    def __repr__(self) -> str:
        parts = [repr(self.model), repr(tuple(self.x0)), repr(self.t_end)]
        parts += [f"tol={self.tol!r}"] if self.tol != 1e-15 else []
        parts += [f"order={self.order!r}"] if self.order is not None else []
        return f"Case({', '.join(parts)})"


MODELS = (
    fl.MassOnBelt,
    fl.DenHartog,
    fl.ImpactOscillator,
    fl.TwoBlocks,
    fl.BouncingBall,
    fl.ModeCoupling,
    fl.SliderOnBelt,
)
LAWS = (fl.Coulomb, fl.ExponentialDecay, fl.Stribeck, fl.WeakeningStrengthening, fl.PressureDependent)
OTHER = (
    fl.PlasticImpact,
    fl.RestitutionImpact,
    CubicContact,
    LinearContact,
    FixedLoad,
    fl.MovingLoad,
    StickSlip,
    StickSlipSeparation,
)
NAMES = {kind.__name__: kind for kind in (Case, *MODELS, *LAWS, *OTHER)} | OWN


def read(line: str) -> Case:
    """The case that a line of code makes."""
    return eval(line, dict(NAMES))
