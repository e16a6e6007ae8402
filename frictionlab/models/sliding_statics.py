"""Statics of steady sliding that come down to one equation."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class SlidingStatics:
    """What a model says whose equilibria follow from the gap of its one contact.

    Its structure is linear, its F_N a function of the gap.  So all coordinates follow from the gap, and what
    is left is one scalar equation, of which all roots are found; for polynomial laws it is a polynomial.

    Parameters
    ----------
    height : str
        The coordinate, if there is no spring, that the contact alone holds.
    """

    height: str
