"""`ZooModel`, the base of the systems of the literature, and why some do not take some analyses."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar

from frictionlab.models.mechanical.mechanical_model import MechanicalModel
from frictionlab.validation import check_number

MOST_PARTS = 100
NO_EQUILIBRIUM = MappingProxyType({"eigenvalues": "The force depends on time, so there is no equilibrium."})
LINEAR: Mapping[str, str] = MappingProxyType(
    dict.fromkeys(
        ("steady_state", "periodic_orbit", "continue_orbit"),
        "The model is linear: about an unstable equilibrium motions grow for ever, and none is periodic.",
    )
)
UNBOUNDED: Mapping[str, str] = MappingProxyType(
    {
        "ablation": 'Without "nonsmooth" no motion is bounded: beyond v_r = 0 friction that falls with speed '
        "drives it for ever."
    }
)


def of_what_ends(why: str) -> Mapping[str, str]:
    """Why no analysis of a state or a motion that lasts applies."""
    return MappingProxyType(
        dict.fromkeys(("eigenvalues", "steady_state", "periodic_orbit", "continue_orbit", "bifurcation"), why)
    )


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
