"""`fl.list_models`: the models of the package, with a line and a reference each; and presets of explorers."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from html import escape
from typing import NamedTuple

from frictionlab.components.friction import Stribeck, WeakeningStrengthening
from frictionlab.models.model import Model

from .dry_friction_oscillators import DenHartog, FreeCoulomb, MassOnBelt, TwoBlocks
from .impact_oscillators import BouncingBall, ImpactOscillator
from .sliders import ModeCoupling, SliderOnBelt, SliderOnRigidBelt

PAPANGELO_REFERENCE = "A. Papangelo, M. Ciavarella, N. Hoffmann, Nonlinear Dynamics 90 (2017)"
WEAKENING_CALL = "MassOnBelt(friction=fl.WeakeningStrengthening(mu_k=0.5, mu_s=1.0), c=0.1, v=1.0)"

# The models of the rows, made here so that the text of a call need not be run as Python.
ROW_MODELS: tuple[Model, ...] = (
    SliderOnBelt(),
    MassOnBelt(),
    MassOnBelt(friction=Stribeck(mu_k=0.5, mu_s=1.0), c=0.1),
    MassOnBelt(friction=WeakeningStrengthening(mu_k=0.5, mu_s=1.0), c=0.1, v=1.0),
    ModeCoupling(),
    SliderOnRigidBelt(),
    DenHartog(),
    FreeCoulomb(),
    BouncingBall(),
    ImpactOscillator(),
    TwoBlocks(),
)


class ModelRow(NamedTuple):
    """A model: Python that makes it, what it shows, where it comes from."""

    call: str
    about: str
    reference: str


@dataclass(frozen=True, repr=False)
class ModelTable:
    """Rows of a call, a line and a reference; prints as a table."""

    rows: tuple[ModelRow, ...]

    def __iter__(self) -> Iterator[ModelRow]:
        return iter(self.rows)

    def __len__(self) -> int:
        return len(self.rows)

    def __repr__(self) -> str:
        return "\n".join(f"fl.{row.call}\n    {row.about}\n    {row.reference}" for row in self.rows)

    def _repr_html_(self) -> str:
        head = "".join(f"<th>{name}</th>" for name in ("model", "what it shows", "reference"))
        cells = (
            (f"<code>fl.{escape(r.call)}</code>", escape(r.about), escape(r.reference)) for r in self.rows
        )
        body = "".join("<tr>" + "".join(f"<td>{cell}</td>" for cell in row) + "</tr>" for row in cells)
        return f"<table><tr>{head}</tr>{body}</table>"


MODEL_ROWS = (
    ModelRow(
        "SliderOnBelt()",
        "a slider on an elastic, tilting belt that separates",
        SliderOnBelt.reference,
    ),
    ModelRow("MassOnBelt()", "Coulomb friction on a belt: the stick-slip cycle", MassOnBelt.reference),
    ModelRow(
        "MassOnBelt(friction=fl.Stribeck(mu_k=0.5, mu_s=1.0), c=0.1)",
        "friction that falls with speed: negative damping",
        "B. Armstrong-Helouvry, P. Dupont, C. Canudas de Wit, Automatica 30 (1994) 1083-1138",
    ),
    ModelRow(WEAKENING_CALL, "weakening, then strengthening: a subcritical Hopf point", PAPANGELO_REFERENCE),
    ModelRow("ModeCoupling()", "two modes that constant friction merges", ModeCoupling.reference),
    ModelRow(
        "SliderOnRigidBelt()",
        "flutter that a harder pressure sets in and ends, with loss of contact",
        SliderOnRigidBelt.reference,
    ),
    ModelRow("DenHartog()", "dry friction and a harmonic force", DenHartog.reference),
    ModelRow("FreeCoulomb()", "dry friction alone: it stops for ever", FreeCoulomb.reference),
    ModelRow("BouncingBall()", "infinitely many impacts in a finite time", BouncingBall.reference),
    ModelRow("ImpactOscillator()", "a driven mass before a stop", ImpactOscillator.reference),
    ModelRow("TwoBlocks()", "two blocks on a belt that stick and slip by turns", TwoBlocks.reference),
)


class Preset(NamedTuple):
    """A model worth seeing: its name, the model, and a few words that say what to look at."""

    name: str
    model: Model
    about: str


# Explorers and pages offer these; the first is what the app opens with.
PRESETS = (
    Preset(
        "two fates",
        SliderOnBelt(mu_k=1.4),
        "Steady sliding is stable, and yet from rest the slider vibrates for ever: where it starts decides. "
        "Choose the start near the equilibrium to see the other fate.",
    ),
    Preset(
        "flutter",
        SliderOnRigidBelt(),
        "Friction couples two modes until one of them grows: the slider vibrates, and leaves the belt.",
    ),
    Preset(
        "stick-slip",
        MassOnBelt(friction=Stribeck(mu_k=0.5, mu_s=1.0), c=0.1),
        "Friction that falls with speed feeds the vibration: the mass sticks to the belt and is torn off, "
        "again and again.",
    ),
    Preset(
        "chaos",
        ImpactOscillator(Omega=2.8, e=0.8, d=0.0),
        "A driven mass hits a stop and never repeats itself: two starts that differ by a hair part for good.",
    ),
    Preset(
        "grazing",
        ImpactOscillator(c=2.0, Omega=1.2, d=0.41),
        "The mass just fails to touch its stop: move d from 0.41 m to 0.4 m, and every swing strikes it.",
    ),
)


def list_models() -> ModelTable:
    """The models of the package.

    Returns
    -------
    ModelTable
        Rows of Python that makes the model, a line on what it shows, and a reference; prints as a table.

    Examples
    --------
    >>> import frictionlab as fl
    >>> len(fl.list_models())
    11
    >>> next(iter(fl.list_models())).call
    'SliderOnBelt()'
    """
    return ModelTable(MODEL_ROWS)
