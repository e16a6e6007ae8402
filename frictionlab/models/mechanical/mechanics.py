"""What a mechanical model states: energies, loads and contacts, in arithmetic that needs no sympy."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, Any, ClassVar

from frictionlab.automaton.mode import check_elements
from frictionlab.components.component import Component, expressions_of, laws_of_expressions
from frictionlab.components.contact import Interface, StickSlipSeparation
from frictionlab.components.friction import FrictionLaw
from frictionlab.components.impact import ImpactLaw
from frictionlab.models.composition import check_component
from frictionlab.validation import abbreviate, check_sequence, did_you_mean_or_known, float_array, is_sequence

if TYPE_CHECKING:
    from frictionlab.models.mechanical.mechanical_model import MechanicalModel

SYMMETRY_RTOL = 1e-8  # share of a_ij, or of the root of a_ii a_jj: what elements and exports round


class _PressedContact:
    """A contact whose normal force is stated, as that of elastic bodies; a dataclass states the rest."""

    normal_force: Any
    penetration: Any
    damper: Any
    interface: Interface | None

    @property
    def pressing(self) -> Any:
        """F_N (N) as an expression, without the damper."""
        return self._at_penetration(self.normal_force)

    @property
    def damping(self) -> Any:
        """Coefficient of the damper (N s/m) as an expression."""
        return self._at_penetration(self.damper)

    @property
    def modes(self) -> tuple[str, ...]:
        """Names of the regimes, in the order in which they are tried."""
        return (self.interface or StickSlipSeparation()).modes

    def _at_penetration(self, function: Any) -> Any:
        """A function as an expression; it may make a law of symbols, and return its force."""
        if not callable(function):
            return function
        with laws_of_expressions([]):
            return function(self.penetration)


@dataclass(frozen=True, eq=False)
class Friction(_PressedContact):
    """A contact with dry friction; its modes are "stick", "slip+", "slip-" and, where the bodies can
    separate, "separation".  In the plane they are "stick", "slip", "breakaway" and "separation".

    A contact does not pull: it is lost where F_N comes to zero, unless its interface is bilateral.

    The friction force F_T acts along the relative velocity v_r: where velocities of the bodies change v_r by
    dv_r, its power on the bodies is -F_T dv_r.

    In the plane F_T and v_r are vectors of two components, a and b, and the law is given the speed |v_r|.
    Stick lasts while |F_T| is within the static limit.  It ends by "breakaway": until v_r has a direction,
    from some 1e-8 s on, the friction force is along the one that held.

    Parameters
    ----------
    relative_velocity : Expr, or two of them
        v_r, linear in the velocities, m/s; in the plane a tuple of its components along two directions at
        right angles, as in ``(self.v - v.x, -v.y)``.
    normal_force : Expr or callable
        F_N, N.  Where the bodies can separate, it should be a function of the penetration that has its sign,
        such as ``contact.force`` of a law: its integral is the energy that the contact stores.  If it depends
        on anything else, as with a damper in the contact, the contact ends where F_N comes to zero, and has
        the mode "relaxation" while F_N would pull at a penetration above zero: the surface, which has no
        mass, returns without a force.
    law : FrictionLaw
    penetration : Expr or None
        Penetration, m, positive in contact, of bodies that can separate: there is no force where it is
        negative.  None for a contact whose normal force does no work; it is lost only where F_N depends on
        the state and becomes negative.
    normal : tuple of Expr or None
        W_N, the factors of F_N in the equations of all coordinates; by default the gradient of the gap, which
        is minus that of the penetration, so that the contact does no work but that of its spring.
        :class:`Geometry` gives the paper's.
    impact : ImpactLaw or None
        The impact law where the gap closes; by default there is no impact, as the contact has no mass.
    interface : Interface or None
        The regimes that the contact has, of those of the model's `interface`; by default all of these.
    damper : Expr or callable
        As of :class:`Contact`: its force is a part of F_N, so that friction grows and falls with it.
    """

    relative_velocity: Any
    normal_force: Any
    law: FrictionLaw
    penetration: Any = None
    normal: tuple[Any, ...] | None = None
    impact: ImpactLaw | None = None
    interface: Interface | None = None
    damper: Any = 0

    def __post_init__(self) -> None:
        check_component("law of a Friction", FrictionLaw, self.law)

    @property
    def in_plane(self) -> bool:
        """Whether v_r has two components."""
        return isinstance(self.relative_velocity, (tuple, list))

    @property
    def velocities(self) -> tuple[Any, ...]:
        """The components of v_r: one, or two in the plane."""
        return tuple(self.relative_velocity) if self.in_plane else (self.relative_velocity,)


@dataclass(frozen=True, eq=False)
class Contact(_PressedContact):
    """An elastic contact without friction, with or without a damper; its modes are "contact" and
    "separation".

    F_N = normal_force(penetration) + damper d(penetration)/dt.  A contact does not pull: it ends where F_N
    comes to zero.  With a damper this is before the gap opens; then it has the mode "relaxation" until the
    penetration is zero: the surface, which has no mass, returns without a force.

    Parameters
    ----------
    penetration : Expr
        Penetration, m, positive in contact.
    normal_force : Expr or callable
        F_N without the damper (N) as :class:`Friction` has it: a function of the penetration, such as
        ``contact.force`` of a law.
    damper : Expr or callable
        Coefficient of the damper, N s/m, or a function of the penetration that gives it.
        That of Hunt and Crossley, k d^1.5 (1 + c d'), has ``damper=lambda d: self.k * self.c * d**1.5``.
    interface : Interface or None
        As of :class:`Friction`; one without "separation" is bilateral.

    References
    ----------
    K. H. Hunt, F. R. E. Crossley, Journal of Applied Mechanics 42 (1975) 440-445.
    """

    penetration: Any
    normal_force: Any
    damper: Any = 0
    interface: Interface | None = None

    normal: ClassVar[None] = None
    impact: ClassVar[None] = None
    relative_velocity: ClassVar[Any] = None
    in_plane: ClassVar[bool] = False


@dataclass(frozen=True, eq=False)
class Stop:
    """A rigid stop, or a rigid contact of two bodies; its modes are "flight" and "contact", or with friction
    "flight", "stick", "slip+" and "slip-".

    With friction the reaction F_N and the friction force F_T follow together from what the contact keeps at
    zero.  Slip ends where these forces no longer exist (Painleve's paradox).  Friction in an impact is that
    of its law, such as :class:`FrictionalImpact`; other laws may have none.

    Impacts of several at one instant are a sequence of single ones, as with small gaps, the greatest first;
    equally great ones act together.

    Parameters
    ----------
    distance : Expr
        Distance from the stop, m, at least 0.
    law : ImpactLaw
        The impact law where the distance comes to 0.
    interface : Interface or None
        The regimes of the contact, of those of the model's `interface`; by default all of these.  If
        "separation" is not one of them, the stop has no effect.
    friction : FrictionLaw or None
        The law of friction, whose force is proportional to F_N and has no states; None without friction.
    relative_velocity : Expr or None
        v_r (m/s), linear in the velocities, of a contact with friction; its sign is that of
        :class:`Friction`.
    """

    distance: Any
    law: ImpactLaw
    interface: Interface | None = None
    friction: FrictionLaw | None = None
    relative_velocity: Any = None

    in_plane: ClassVar[bool] = False

    @property
    def rubs(self) -> bool:
        """Whether the contact has friction."""
        return self.friction is not None

    @property
    def modes(self) -> tuple[str, ...]:
        """Names of the regimes."""
        names = (self.interface or StickSlipSeparation()).modes
        if "separation" not in names:
            return ("flight",)
        return (
            ("flight", *(name for name in names if name != "separation"))
            if self.rubs
            else ("flight", "contact")
        )


AnyContact = Friction | Contact | Stop


@dataclass(frozen=True, eq=False)
class Mechanics:
    """Energies, loads and contacts.

    All of them may depend on ``q.phase`` and ``q.t``, that is on time, and on place: what a base, a hoop or a
    ground that moves does to T, V and the contacts is in the equations.  The phase of a periodic load starts
    again after each period; ``q.t`` is the time since the start, for ramps and tables.

    Parameters
    ----------
    kinetic : Expr
        Energy T(q, v), J, a polynomial of degree 2 in the velocities that is positive for every motion.  Of a
        body on a base that moves it has terms with one velocity and with none, too.
    potential : Expr or mapping of str to Expr
        Energy V(q), J; or its parts by name, such as "springs" and "gravity", of which V is the sum.
    dissipation : Expr
        Rayleigh's dissipation function D(v), W: half the power that the dampers take, where it is quadratic.
        It must not be negative for any motion; forces that drive are loads.
    contacts : tuple of Friction, Contact or Stop
    loads : mapping of str to Expr
        Forces (N) along coordinates that come from no energy, such as ``F * cos(q.phase)``.
    frequency : Expr or None
        Angular frequency (rad/s) of what depends on time, one number: the rate of the state ``q.phase``,
        which goes from 0 to 2 pi and starts again at 0.  At least 0; None where nothing depends on time.
    rates : mapping of str to Expr
        The rate of each of the model's further `states`, such as a current, a temperature, or what a filter
        lets through.  Rates, loads, dissipation, relative velocities, normal forces and what laws are given
        may depend on these states; energies and distances do not.
    """

    kinetic: Any
    potential: Any = 0
    dissipation: Any = 0
    contacts: tuple[AnyContact, ...] = ()
    loads: Mapping[str, Any] = field(default_factory=dict)
    frequency: Any = None
    rates: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not isinstance(self.loads, Mapping):
            raise TypeError(
                f"loads must map coordinates to forces, got {abbreviate(self.loads)}: write "
                'loads={"x": self.F}'
            )
        if not isinstance(self.rates, Mapping):
            raise TypeError(
                f"rates must map further states to their rates, got {abbreviate(self.rates)}: write "
                'rates={"i": (self.U - self.R * s.i) / self.L}'
            )
        check_elements("contacts", self.contacts, Friction, Contact, Stop)
        potential = self.potential.values() if isinstance(self.potential, Mapping) else [self.potential]
        given = [self.kinetic, *potential, self.dissipation, *self.loads.values(), self.frequency]
        given += self.rates.values()
        given += [getattr(contact, about.name) for contact in self.contacts for about in fields(contact)]
        given += [
            one for contact in self.contacts if isinstance(contact, Friction) for one in contact.velocities
        ]
        if texts := [one for one in given if isinstance(one, str)]:  # which sympy would run as Python
            raise TypeError(
                f"energies, loads and contacts must be expressions, got the text {abbreviate(texts[0])}: "
                "write it with the coordinates q, the velocities v and the parameters, as in self.k * q.x**2"
            )

    @property
    def law_states(self) -> tuple[tuple[str, ...], ...]:
        """Names of the states of each contact's friction law; numbered, as z_2, where there are several
        contacts."""
        return names_of_law_states([getattr(contact, "law", None) for contact in self.contacts])

    @property
    def expressions(self) -> list[Any]:
        """All that is stated but the frequency: energies, loads, rates, what contacts and laws are given."""
        potential = self.potential.values() if isinstance(self.potential, Mapping) else [self.potential]
        given = [self.kinetic, *potential, self.dissipation, *self.loads.values(), *self.rates.values()]
        for contact in self.contacts:
            if isinstance(contact, Stop):
                given.append(contact.distance)
            else:
                given += [contact.pressing, contact.damping, contact.penetration, *(contact.normal or ())]
                given += contact.velocities if isinstance(contact, Friction) else ()
            parts = (getattr(contact, about.name) for about in fields(contact))
            given += [
                each for law in parts if isinstance(law, Component) for each in expressions_of(law).values()
            ]
        return [one for one in given if hasattr(one, "free_symbols")]

    def depends_on(self, symbol: Any) -> bool:
        """Whether any of it depends on a symbol."""
        return any(symbol in one.free_symbols for one in self.expressions)

    @property
    def stored(self) -> Any:
        """The potential energy V (J), the sum of all its parts."""
        return sum(self.potential.values()) if isinstance(self.potential, Mapping) else self.potential


def names_of_law_states(laws: Sequence[Any]) -> tuple[tuple[str, ...], ...]:
    """Names of the states of contacts' friction laws, () where there is none; see `Mechanics.law_states`."""
    numbers = [f"_{i}" for i in range(1, len(laws) + 1)] if len(laws) > 1 else [""]
    return tuple(
        tuple(name + number for name in law.states) if isinstance(law, FrictionLaw) else ()
        for law, number in zip(laws, numbers)
    )


class _Named(tuple[Any, ...]):
    """Coordinates, velocities or further states: a tuple in their order, and each by its name."""

    def __new__(cls, names: Iterable[str], values: Iterable[Any], **clocks: Any) -> _Named:
        """With the phase and the time by name, which are none of the tuple."""
        named = super().__new__(cls, values)
        vars(named).update(clocks | dict(zip(names, named, strict=True)))
        return named

    def __getattr__(self, name: str) -> Any:
        hint = did_you_mean_or_known(name, vars(self))
        raise AttributeError(f"there is no coordinate or state {name!r}{hint}")


def mechanics_at(
    model: MechanicalModel,
    q: Iterable[Any],
    v: Iterable[Any],
    phase: Any,
    further: Iterable[Any],
    time: Any = 0.0,
    laws: list[Component] | None = None,
) -> Mechanics:
    """What a model states at coordinates, velocities, phase, further states and time: symbols or numbers.

    The laws that it makes of expressions are added to `laws`.
    """
    clock = {} if "t" in model.structure_key.parameters else {"t": time}  # a parameter may have the name
    at = _Named(model.coordinates, q, phase=phase, **clock)
    moving, others = _Named(model.coordinates, v), _Named(model.states, further)
    with laws_of_expressions([] if laws is None else laws):
        return model.mechanics(at, moving, others) if model.states else model.mechanics(at, moving)


def quadratic_form(matrix: Any, x: Sequence[Any]) -> Any:
    """x^T A x, by which symmetric matrices of finite elements become energies.

    With M, K and C of a structure, `kinetic`, `potential` and `dissipation` of :class:`Mechanics` are
    ``quadratic_form(M, velocities) / 2``, ``quadratic_form(K, coordinates) / 2`` and
    ``quadratic_form(C, velocities) / 2``, multiplied by parameters where these are to be factors.

    The skew part of a matrix is in no energy, since x^T A x does not have it.  Circulatory and gyroscopic
    forces, as of friction in a brake, are loads: ``skew = (K - K.T) / 2``, then
    ``loads=dict(zip(names, -skew @ coordinates))``.

    Parameters
    ----------
    matrix : array (n, n)
        Real numbers, symmetric but for rounding.  It may be a sparse matrix of scipy, or a DataFrame; one
        whose labels are the names of `x` is read by these.
    x : sequence of Expr
        The coordinates, or the velocities, in the order of the matrix's rows.

    Returns
    -------
    Expr

    Raises
    ------
    ValueError
        If `x` is no sequence, or holds an integer beyond floats; or the matrix does not have one row and one
        column for each of `x`, is not symmetric, or holds what is no finite real number.

    Examples
    --------
    >>> import sympy
    >>> import frictionlab as fl
    >>> fl.quadratic_form([[2.0, -1.0], [-1.0, 3.0]], sympy.symbols("x y"))
    2.0*x**2 - 2.0*x*y + 3.0*y**2
    """
    import numpy as np
    from sympy import Add

    cure = "give the coordinates, or the velocities, in the order of the rows"
    x = check_sequence("x", x, cure)
    if wrong := [one for one in x if isinstance(one, str) or is_sequence(one)]:
        raise TypeError(f"x must hold expressions such as q.x, got {abbreviate(wrong[0])}: {cure}")
    if wrong := [one for one in x if isinstance(one, int) and abs(one) > sys.float_info.max]:
        raise ValueError(f"x must hold numbers within floats, got {abbreviate(wrong[0])}: {cure}")
    entries = _numbers_of_matrix(matrix, x)
    _check_symmetry(entries)
    rows = entries.tolist()
    terms = [rows[i][i] * (one * one) for i, one in enumerate(x) if rows[i][i]]
    for i, j in np.argwhere(np.tril((entries != 0) | (entries.T != 0), -1)):
        terms += [both * x[i] * x[j]] if (both := rows[i][j] + rows[j][i]) else []
    return Add(*terms)  # all at once: sum() would sort the terms again for each new one


def _numbers_of_matrix(matrix: Any, x: Sequence[Any]) -> Any:
    """The entries (n, n) as a new array of floats, in the order of `x`."""
    given = matrix.toarray() if hasattr(matrix, "toarray") else _in_order(matrix, x)
    try:
        numbers = float_array("matrix", given, "", finite=True)
    except ValueError:
        raise ValueError(
            f"matrix must hold finite real numbers, got {abbreviate(given)}: leave out what is missing, and "
            "write the imaginary part of a complex stiffness as a dissipation"
        ) from None
    if numbers.shape != (len(x), len(x)):
        size = " x ".join(map(str, numbers.shape)) or "a single number"
        raise ValueError(
            f"matrix must have one row and one column for each of the {len(x)} entries of x, got {size}: "
            "leave out those of coordinates that are held"
        )
    return numbers


def _in_order(matrix: Any, x: Sequence[Any]) -> Any:
    """A DataFrame's numbers in the order of `x`, by its labels; anything else as it is."""
    if not hasattr(matrix, "to_numpy"):
        return matrix
    names = [str(one).rstrip("'") for one in x]
    rows, columns = list(matrix.index), list(matrix.columns)
    if {*rows} == {*columns} == {*names}:
        return matrix.loc[names, names].to_numpy()
    if rows != columns and rows != list(range(len(rows))):
        raise ValueError(
            f"matrix must have the same labels for rows and columns, got {abbreviate(rows)} and "
            f"{abbreviate(columns)}: sort them alike"
        )
    return matrix.to_numpy()


def _check_symmetry(entries: Any) -> None:
    """Raise ValueError where x^T A x would lose the skew part of a matrix."""
    import numpy as np

    sizes = np.sqrt(np.abs(entries.diagonal()))
    usual = np.maximum(np.outer(sizes, sizes), np.maximum(np.abs(entries), np.abs(entries.T)))
    skew = np.abs(entries - entries.T) > SYMMETRY_RTOL * usual
    if not skew.any():
        return
    i, j = map(int, np.argwhere(skew)[0])
    got = f"got {entries[i, j]:g} in row {i}, column {j} and {entries[j, i]:g} in row {j}, column {i}"
    if not np.tril(entries, -1).any() or not np.triu(entries, 1).any():
        raise ValueError(
            f"matrix must be symmetric, {got}, as if it were one triangle of a symmetric one: "
            "give A + A.T - np.diag(A.diagonal())"
        )
    raise ValueError(
        f"matrix must be symmetric, {got}: the skew part has no energy; give (A + A.T) / 2 here, and "
        "-(A - A.T) / 2 times x as loads"
    )


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
