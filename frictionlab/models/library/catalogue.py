"""`fl.list_models`: the models of the package by topic, with a line and a reference each; and presets.

The classics are listed here.  Other topics are those of the zoo, which is loaded when its rows are asked for.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

from frictionlab.components.friction import FrictionCurve, Stribeck
from frictionlab.models.model import Model
from frictionlab.presentation import html_rows
from frictionlab.validation import check_choice

from .dry_friction_oscillators import DenHartog, FreeCoulomb, MassOnBelt, TwoBlocks
from .impact_oscillators import BouncingBall, ImpactOscillator
from .sliders import ModeCoupling, SliderOnBelt, SliderOnRigidBelt

# The models of the rows, made here so that the text of a call need not be run as Python.
ROW_MODELS: tuple[Model, ...] = (
    SliderOnBelt(),
    MassOnBelt(),
    MassOnBelt(friction=Stribeck(mu_k=0.5, mu_s=1.0), c=0.1),
    ModeCoupling(),
    SliderOnRigidBelt(),
    DenHartog(),
    FreeCoulomb(),
    BouncingBall(),
    ImpactOscillator(),
    TwoBlocks(),
)


CLASSICS = "classics"  # the topic of the models that are listed here


class ModelRow(NamedTuple):
    """A model: Python that makes it, what it shows, where it comes from, what it is about."""

    call: str
    about: str
    reference: str
    topic: str = CLASSICS


@dataclass(frozen=True, repr=False)
class ModelTable:
    """Rows of a call, a line, a reference and a topic; prints as a table, a heading for each topic."""

    rows: tuple[ModelRow, ...]

    def __iter__(self) -> Iterator[ModelRow]:
        return iter(self.rows)

    def __len__(self) -> int:
        return len(self.rows)

    @property
    def topics(self) -> tuple[str, ...]:
        """The topics of the rows, in their order."""
        return tuple(dict.fromkeys(row.topic for row in self.rows))

    def __repr__(self) -> str:
        lines = []
        for topic in self.topics:
            lines.append(f"# {topic}")
            rows = (row for row in self.rows if row.topic == topic)
            lines += (f"fl.{row.call}\n    {row.about}\n    {row.reference}" for row in rows)
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        rows = ((f"fl.{row.call}", row.about, row.reference, row.topic) for row in self.rows)
        return html_rows(("model", "what it shows", "reference", "topic"), rows)


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
        "your own friction curve",
        MassOnBelt(friction=FrictionCurve(), c=0.1, v=0.5),
        "Drag the points of the curve: where it falls at the belt's speed, friction is a damper below zero, "
        "and steady sliding is lost.",
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


@cache
def rows_of_the_zoo() -> tuple[ModelRow, ...]:
    """The systems of the literature, by topic."""
    from frictionlab.models.zoo.topics import TOPICS

    return tuple(
        ModelRow(f"{cls.__name__}()", cls.about, cls.reference, topic)
        for topic, classes in TOPICS.items()
        for cls in classes
    )


def list_models(topic: str | None = None) -> ModelTable:
    """The models of the package, by topic.

    Parameters
    ----------
    topic : str or None
        "classics", or a topic of the systems of the literature, such as "impacts"; None for all.

    Returns
    -------
    ModelTable
        Rows of Python that makes the model, a line on what it shows, a reference, and the topic; prints as a
        table.

    Raises
    ------
    ValueError
        For another topic.

    Examples
    --------
    >>> import frictionlab as fl
    >>> fl.list_models().topics[:3]
    ('classics', 'oscillators on a belt', 'mode coupling')
    >>> next(iter(fl.list_models("classics"))).call
    'SliderOnBelt()'
    """
    if isinstance(topic, str) and topic == CLASSICS:
        return ModelTable(MODEL_ROWS)
    rows = (*MODEL_ROWS, *rows_of_the_zoo())
    if topic is None:
        return ModelTable(rows)
    topics = ModelTable(rows).topics
    check_choice("topic", topic, topics, "leave it out for all")
    return ModelTable(tuple(row for row in rows if row.topic == topic))
