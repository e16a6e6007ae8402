"""Which models a topic of the zoo has, in the order of the table that `fl.list_models` shows."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from .belt_oscillators import (
    BrakedOscillator,
    DitheredOscillator,
    DoubleLayerPad,
    ExcitedBeltOscillator,
    ModularChain,
    NoisyOscillator,
    OscillatorChain,
    PoppStelter,
    WeakeningOscillator,
)
from .bristles_and_states import BoltedJoint, JenkinsOscillator, LuGreOscillator, SpringSlider
from .impacts import BallOnTable, NewtonsCradle, RattlingGear, RockingBlock, Woodpecker
from .mode_couplings import HultenOscillator, PadOnDisc, StrutPad
from .rotating_systems import DrillString, FroudePendulum, MotorAndCart, WobblingDisc
from .structures_in_modes import BowedString, DiscAndPads, MassOnBeam
from .zoo_model import ZooModel

TOPICS: Mapping[str, tuple[type[ZooModel], ...]] = MappingProxyType(
    {
        "oscillators on a belt": (
            PoppStelter,
            WeakeningOscillator,
            ExcitedBeltOscillator,
            OscillatorChain,
            DoubleLayerPad,
            BrakedOscillator,
            ModularChain,
            NoisyOscillator,
            DitheredOscillator,
        ),
        "mode coupling": (HultenOscillator, StrutPad, PadOnDisc),
        "rotating systems": (WobblingDisc, DrillString, FroudePendulum, MotorAndCart),
        "dynamic friction": (LuGreOscillator, SpringSlider, JenkinsOscillator, BoltedJoint),
        "impacts": (BallOnTable, RockingBlock, RattlingGear, NewtonsCradle, Woodpecker),
        "structures in modes": (BowedString, MassOnBeam, DiscAndPads),
    }
)
