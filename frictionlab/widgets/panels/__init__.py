"""The panels by name.  A panel is a function of a result that returns a Drawing."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from types import MappingProxyType
from typing import Any

from frictionlab.components.names import did_you_mean
from frictionlab.widgets.drawing import Drawing

from .eigenvalues import eigenvalues
from .forces import forces
from .mechanism import mechanism
from .phase import phase
from .response import response
from .spectrum import spectrum

PANELS: Mapping[str, Callable[[Any], Drawing]] = MappingProxyType(
    {
        "response": response,
        "phase": phase,
        "forces": forces,
        "spectrum": spectrum,
        "eigenvalues": eigenvalues,
        "mechanism": mechanism,
    }
)


def panels_of(asked: Iterable[Any]) -> dict[str, Callable[[Any], Drawing]]:
    """Panels by name; those asked for may be names or functions, or one name alone.

    Raises
    ------
    ValueError
        For an unknown name, something that is no function, or none at all.
    """
    asked = [asked] if isinstance(asked, str) else asked
    found = {_name(panel): PANELS[panel] if isinstance(panel, str) else panel for panel in asked}
    if not found:
        raise ValueError(f"panels must hold at least one panel, got none: take some of {', '.join(PANELS)}")
    return found


def _name(panel: Any) -> str:
    if isinstance(panel, str) and panel in PANELS:
        return panel
    if callable(panel):
        return getattr(panel, "__name__", type(panel).__name__)
    known = ", ".join(map(repr, PANELS))
    raise ValueError(
        f"panels must be functions or some of {known}, got {panel!r}: {did_you_mean(panel, PANELS)}"
    )
