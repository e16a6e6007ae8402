"""`ZooModel`, the base of the systems of the literature, and how their parameters are written."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar

from frictionlab.components.component import parameter
from frictionlab.models.mechanical.mechanical_model import MechanicalModel
from frictionlab.validation import check_number

MOST_PARTS = 100
RANGE = 10.0  # a slider goes from a tenth of a positive parameter's default to ten times it
NO_EQUILIBRIUM = "The force depends on time, so there is no equilibrium."
LINEAR = "The model is linear: about an unstable equilibrium motions grow for ever, and none is periodic."
# analyses of a state or a motion that lasts
OF_WHAT_LASTS = ("eigenvalues", "steady_state", "periodic_orbit", "continue_orbit", "bifurcation")


class ZooModel(MechanicalModel):
    """Base of the systems of the literature.

    `about` says what the system shows, `reference` where it comes from.  `not_applicable` has a sentence for
    each analysis that it does not take, by the analysis' name.
    """

    about: ClassVar[str] = ""
    not_applicable: ClassVar[Mapping[str, str]] = MappingProxyType({})

    if TYPE_CHECKING:  # those that derive from a classic take more keywords than it does

        def __init__(self, **given: Any) -> None: ...

    def check_count(self, name: str, least: int) -> None:
        """Raise ValueError unless a number of parts is an integer for which equations can be derived."""
        check_number(name, getattr(self, name), integer=True, least=least, most=MOST_PARTS)


def positive(default: float, unit: str, symbol: str, meaning: str) -> Any:
    """A parameter above 0, such as a mass; its slider is logarithmic."""
    around = (default / RANGE, default * RANGE)
    return parameter(
        default, unit=unit, symbol=symbol, meaning=meaning, exclusive_minimum=0.0, range=around, log=True
    )


def not_negative(default: float, most: float, unit: str, symbol: str, meaning: str) -> Any:
    """A parameter of at least 0, such as a damper; its slider goes up to `most`."""
    return parameter(default, unit=unit, symbol=symbol, meaning=meaning, minimum=0.0, range=(0.0, most))


def of_either_sign(default: float, most: float, unit: str, symbol: str, meaning: str) -> Any:
    """A parameter of either sign, such as a speed; its slider goes from -`most` to `most`."""
    return parameter(default, unit=unit, symbol=symbol, meaning=meaning, range=(-most, most))
