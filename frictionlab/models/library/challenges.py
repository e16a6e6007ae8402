"""Challenges of explorers and exported pages as data: question, model, what may be changed, goal.

The front end checks an answer by the result that its values give, so a link to it is the proof.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from frictionlab.components.friction import FrictionCurve, Stribeck
from frictionlab.models.model import Model

from .dry_friction_oscillators import MassOnBelt
from .impact_oscillators import ImpactOscillator
from .sliders import SliderOnBelt, SliderOnRigidBelt

POINTS = "mu_0", "mu_1", "mu_2", "mu_3", "mu_4", "v_1", "v_2", "v_3", "v_4"


class Challenge(NamedTuple):
    """A question that is answered by changing controls.

    Parameters
    ----------
    name, question : str
    model : Model
        Its parameters are what the controls are set to at first.
    goal : mapping
        What has to be so: "stable" (steady sliding), "vibrates" (the motion goes on, as the words say),
        "strikes" (there are impacts in what is shown), each true or false; "from": the start.
    may : tuple of str
        Controls that may be changed; none stands for all parameters.
    most : int
        So many may be changed at once.
    start : str
        Where the run starts at first.
    """

    name: str
    question: str
    model: Model
    goal: Mapping[str, Any]
    may: tuple[str, ...] = ()
    most: int = 1
    start: str = "rest"


TWO_FATES = SliderOnBelt(mu_k=0.8)  # the silent fate is reached by hand: from 5 mm on each side
STICK_SLIP = MassOnBelt(friction=Stribeck(mu_k=0.5, mu_s=1.0), c=0.1)
CURVE = MassOnBelt(friction=FrictionCurve(), c=0.1, v=0.5)
SILENT, SINGS = {"vibrates": False, "stable": True}, {"vibrates": True}

CHALLENGES = (
    Challenge("silence", "From rest the slider sings for ever. Silence it by one slider.", TWO_FATES, SILENT),
    Challenge(
        "the other fate",
        "Steady sliding is stable, and yet the slider sings. Change no parameter: drag it to where it can be "
        "let go and falls silent.",
        TWO_FATES,
        SILENT | {"from": "own"},
        ("start", "own"),
        2,
    ),
    Challenge(
        "a knock",
        "Near steady sliding the slider is silent. Drag it so far that it sings for ever.",
        TWO_FATES,
        SINGS | {"from": "own"},
        ("start", "own"),
        2,
        "near",
    ),
    Challenge(
        "squeal", "Raise friction until steady sliding is lost.", TWO_FATES, {"stable": False}, ("mu_k",)
    ),
    Challenge(
        "flutter",
        "Two modes flutter. Keep them apart by friction alone.",
        SliderOnRigidBelt(),
        {"stable": True},
        ("mu_k",),
    ),
    Challenge("faster", "End the stick-slip by the belt's speed alone.", STICK_SLIP, SILENT, ("v",)),
    Challenge("damper", "End the stick-slip by the damper alone.", STICK_SLIP, SILENT, ("c",)),
    Challenge(
        "a falling curve",
        "Steady sliding is stable. Bend the friction curve until it is lost.",
        CURVE,
        {"stable": False},
        POINTS,
        len(POINTS),
    ),
    Challenge(
        "a silent curve",
        "From rest the mass sticks and slips. Bend the friction curve until it falls silent.",
        CURVE,
        SILENT,
        POINTS,
        len(POINTS),
    ),
    Challenge(
        "grazing",
        "The mass just misses its stop. Move the stop until it strikes.",
        ImpactOscillator(c=2.0, Omega=1.2, d=0.41),
        {"strikes": True},
        ("d",),
    ),
)
