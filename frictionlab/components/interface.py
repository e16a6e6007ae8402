"""Interfaces: which regimes of contact a model has.  They are data: a tuple of mode names."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from .component import Component


@dataclass(frozen=True, repr=False)
class Interface(Component):
    """Base of the interfaces: `modes` in the order in which they are tried where no event says otherwise."""

    modes: ClassVar[tuple[str, ...]]


@dataclass(frozen=True, repr=False)
class StickSlipSeparation(Interface):
    """All the non-smooth behaviours of the paper: Eqs. (3), (4), (5), (8), (9)."""

    modes: ClassVar[tuple[str, ...]] = ("stick", "slip+", "slip-", "separation")


@dataclass(frozen=True, repr=False)
class StickSlip(Interface):
    """Stick and slip with bilateral contact: Eqs. (2), (3) hold as printed for F_N < 0 too."""

    modes: ClassVar[tuple[str, ...]] = ("stick", "slip+", "slip-")


@dataclass(frozen=True, repr=False)
class SlidingSeparation(Interface):
    """Unilateral contact without stick: the friction force keeps the sign of the belt's speed."""

    modes: ClassVar[tuple[str, ...]] = ("slip", "separation")


@dataclass(frozen=True, repr=False)
class SlidingOnly(Interface):
    """One smooth regime: bilateral contact, the friction force keeps the sign of the belt's speed."""

    modes: ClassVar[tuple[str, ...]] = ("slip",)
