"""The reference system of a model: its numbers handed over, by name; nothing else of the model is used."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any
from zlib import crc32

import numpy as np

from tests.reference.friction import law
from tests.reference.hybrid import System
from tests.reference.oscillators import (
    BouncingBall,
    DenHartog,
    ImpactOscillator,
    MassOnBelt,
    ModeCoupling,
    TwoBlocks,
)
from tests.reference.rubbing import Rubbing
from tests.reference.slider import Slider

PLAIN = {kind.__name__: kind for kind in (MassOnBelt, DenHartog, TwoBlocks, ModeCoupling)}
STOPPED = {kind.__name__: kind for kind in (ImpactOscillator, BouncingBall)}


def weight(name: str) -> float:
    """By which a parameter is shifted, from 0.5 to 1, up or down; alike for all coefficients of friction."""
    if name.startswith("mu_"):
        return 1.0
    digits = crc32(name.encode())
    return (0.5 + digits % 1000 / 2000) * (1 if digits % 2 else -1)


def shifted(model: Any, shift: float) -> SimpleNamespace:
    """The model's numbers, each changed by a share of about `shift`."""
    return SimpleNamespace(**{n: x * (1 + shift * weight(n)) for n, x in model.parameters.items()})


def twin(model: Any, shift: float = 0.0) -> System:
    """The reference system of a model, or one nearby.

    Nearby, stick is also decided a little earlier or later than it ends: by symmetry a slip may begin and end
    at the static limit, whatever the numbers are.
    """
    found = _twin(model, shift)
    if isinstance(found, Rubbing):
        found.margin = shift
    return found


def _twin(model: Any, shift: float) -> System:
    p, kind = shifted(model, shift), type(model).__name__
    if kind in STOPPED:
        p.e = restitution(model, p)
        return STOPPED[kind](p)
    curve = law(type(model.friction).__name__, p)
    if kind in PLAIN:
        return PLAIN[kind](p, curve)
    p.geometry = "phi" in model.coordinates
    p.unilateral = "separation" in model.interface.modes
    p.e, p.k_nl = restitution(model, p), getattr(p, "k_nl", 0.0)
    return Slider(p, curve)


def restitution(model: Any, p: SimpleNamespace) -> float:
    """Coefficient of restitution: none of a plastic impact, never above 1."""
    law = model.impact
    if getattr(law, "penetration_rate", "full") != "full" and "phi" in model.coordinates:
        raise ValueError(
            f"impact must bring the full gap rate to zero, got {law!r}: the twin knows no chatter"
        )
    return min(getattr(p, "e", 0.0), 1.0)


def initial(model: Any, x0: Any, shift: float = 0.0) -> np.ndarray:
    """The initial state, or one nearby; a body at the belt's speed keeps it, so that stick is stick."""
    z = np.array(x0, dtype=float)
    half, belt = len(z) // 2, model.parameters.get("v", 0.0)
    size = np.repeat([np.abs(z[:half]).max(), np.abs(z[half:]).max()], half)
    signs = np.array([weight(f"state {i}") for i in range(len(z))])
    z += shift * size * signs
    held = np.array(x0)[half:] == belt
    z[half:][held] = shifted(model, shift).v if belt else 0.0
    return full(model, z)


def full(model: Any, z: np.ndarray) -> np.ndarray:
    """The reference's state: ten of the slider, with phi = 0 where it has none."""
    return np.insert(z, [4, 8], 0.0, axis=0) if type(model).__name__ == "SliderOnBelt" and len(z) == 8 else z
