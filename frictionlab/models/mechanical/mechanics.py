"""What a mechanical model states: energies, loads and contacts, in arithmetic that needs no sympy."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any

from frictionlab.automaton.mode import check_elements
from frictionlab.components.contact import Interface, StickSlipSeparation
from frictionlab.components.friction import FrictionLaw
from frictionlab.components.impact import ImpactLaw
from frictionlab.validation import abbreviate


@dataclass(frozen=True, eq=False)
class Friction:
    """A contact with dry friction; its modes are "stick", "slip+", "slip-" and, where the bodies can
    separate, "separation".

    The friction force F_T acts along the relative velocity v_r: where velocities of the bodies change v_r by
    dv_r, its power on the bodies is -F_T dv_r.

    Parameters
    ----------
    relative_velocity : Expr
        v_r, linear in the velocities, m/s.
    normal_force : Expr or callable
        F_N, N.  Where the bodies can separate, it should be a function of the penetration, such as
        ``contact.force`` of a law: its integral is the energy that the contact stores.
    law : FrictionLaw
    penetration : Expr or None
        Penetration, m, positive in contact, of bodies that can separate: F_N is zero where it is zero, and
        there is no force where it is negative.  None for a contact that is never lost, and whose normal force
        does no work.
    normal : tuple of Expr or None
        W_N, the factors of F_N in the equations of all coordinates; by default the gradient of the gap, which
        is minus that of the penetration, so that the contact does no work but that of its spring.
        :class:`Geometry` gives the paper's.
    impact : ImpactLaw or None
        The impact law where the gap closes; by default there is no impact, as the contact has no mass.
    interface : Interface or None
        The regimes that the contact has; by default those of the model's `interface`.
    """

    relative_velocity: Any
    normal_force: Any
    law: FrictionLaw
    penetration: Any = None
    normal: tuple[Any, ...] | None = None
    impact: ImpactLaw | None = None
    interface: Interface | None = None

    @property
    def pressing(self) -> Any:
        """F_N (N) as an expression."""
        return self.normal_force(self.penetration) if callable(self.normal_force) else self.normal_force

    @property
    def modes(self) -> tuple[str, ...]:
        """Names of the regimes, in the order in which they are tried; a contact without a penetration cannot
        separate."""
        names = (self.interface or StickSlipSeparation()).modes
        return (
            names if self.penetration is not None else tuple(name for name in names if name != "separation")
        )


@dataclass(frozen=True, eq=False)
class Stop:
    """A rigid stop; its modes are "flight" and "contact".

    Parameters
    ----------
    distance : Expr
        Distance from the stop, m, at least 0.
    law : ImpactLaw
        The impact law where the distance comes to 0.
    interface : Interface or None
        The regimes of the contact; by default those of the model's `interface`.  If "separation" is not one
        of them, the stop has no effect.
    """

    distance: Any
    law: ImpactLaw
    interface: Interface | None = None

    @property
    def modes(self) -> tuple[str, ...]:
        """Names of the regimes."""
        names = (self.interface or StickSlipSeparation()).modes
        return ("flight", "contact") if "separation" in names else ("flight",)


@dataclass(frozen=True, eq=False)
class Mechanics:
    """Energies, loads and contacts.

    Parameters
    ----------
    kinetic : Expr
        Energy T(q, v), J.
    potential : Expr or mapping of str to Expr
        Energy V(q), J; or its parts by name, such as "springs" and "gravity", of which V is the sum.
    dissipation : Expr
        Rayleigh's dissipation function D(v), W: half the power that the dampers take.
    contacts : tuple of Friction or Stop
    loads : mapping of str to Expr
        Forces (N) along coordinates that come from no energy, such as ``F * cos(q.phase)``.
    frequency : Expr or None
        Angular frequency (rad/s) of a force that depends on time: the rate of the state ``q.phase``, which
        goes from 0 to 2 pi and starts again at 0.  None where nothing depends on time.
    """

    kinetic: Any
    potential: Any = 0
    dissipation: Any = 0
    contacts: tuple[Friction | Stop, ...] = ()
    loads: Mapping[str, Any] = field(default_factory=dict)
    frequency: Any = None

    def __post_init__(self) -> None:
        if not isinstance(self.loads, Mapping):
            raise TypeError(
                f"loads must map coordinates to forces, got {abbreviate(self.loads)}: write "
                'loads={"x": self.F}'
            )
        check_elements("contacts", self.contacts, Friction, Stop)
        potential = self.potential.values() if isinstance(self.potential, Mapping) else [self.potential]
        given = [self.kinetic, *potential, self.dissipation, *self.loads.values(), self.frequency]
        given += [getattr(contact, about.name) for contact in self.contacts for about in fields(contact)]
        if texts := [one for one in given if isinstance(one, str)]:  # which sympy would run as Python
            raise TypeError(
                f"energies, loads and contacts must be expressions, got the text {abbreviate(texts[0])}: "
                "write it with the coordinates q, the velocities v and the parameters, as in self.k * q.x**2"
            )

    @property
    def stored(self) -> Any:
        """The potential energy V (J), the sum of all its parts."""
        return sum(self.potential.values()) if isinstance(self.potential, Mapping) else self.potential


def quadratic_form(matrix: Any, x: Sequence[Any]) -> Any:
    """x^T A x, by which matrices of finite elements become energies.

    With M, K and C of a structure, `kinetic`, `potential` and `dissipation` of :class:`Mechanics` are
    ``quadratic_form(M, velocities) / 2``, ``quadratic_form(K, coordinates) / 2`` and
    ``quadratic_form(C, velocities) / 2``, multiplied by parameters where these are to be factors.

    Parameters
    ----------
    matrix : array (n, n)
        Numbers; it may be a sparse matrix of scipy.
    x : sequence of Expr
        The coordinates, or the velocities, in the order of the matrix's rows.

    Returns
    -------
    Expr

    Raises
    ------
    ValueError
        If the matrix does not have one row and one column for each of `x`.

    Examples
    --------
    >>> import sympy
    >>> from frictionlab.models import quadratic_form
    >>> quadratic_form([[2.0, -1.0], [-1.0, 3.0]], sympy.symbols("x y"))
    2.0*x**2 - 2.0*x*y + 3.0*y**2
    """
    from sympy import Add

    given = matrix.toarray() if hasattr(matrix, "toarray") else matrix
    rows = [list(map(float, row)) for row in given]
    if {len(x)} != {len(rows), *map(len, rows)}:
        raise ValueError(
            f"matrix must have one row and one column for each of the {len(x)} entries of x, got {len(rows)} "
            f"rows of {sorted({*map(len, rows)})} entries: leave out those of coordinates that are held"
        )
    terms = [rows[i][i] * one**2 for i, one in enumerate(x) if rows[i][i]]
    for i, one in enumerate(x):
        pairs = ((rows[i][j] + rows[j][i], x[j]) for j in range(i))
        terms += [both * one * other for both, other in pairs if both]
    return Add(*terms)  # all at once: sum() would sort the terms again for each new one


@dataclass(frozen=True)
class SlidingStatics:
    """Declares that the equilibria of a model follow from the penetration of its one contact.

    All but the contact is linear, and F_N is a function of the penetration.  So all coordinates follow from
    the penetration, and one scalar equation is left, of which all roots are found; for polynomial laws it is
    a polynomial.

    Parameters
    ----------
    height : str
        The coordinate that only the contact holds where no spring does.
    """

    height: str
