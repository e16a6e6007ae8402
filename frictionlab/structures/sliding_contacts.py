"""`fl.SlidingContacts`: contacts of a structure that slide steadily, by rows of the freedoms.

A contact has a row g of penetrations, delta = g q + delta_0, and a row t of tangential displacements: its
forces enter as -g^T F_N + t^T F_T.  Laws are the library's, differentiated by their formulas.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from frictionlab.components.component import Component, parameters_of
from frictionlab.components.contact import ContactLaw, LinearContact
from frictionlab.components.friction import Coulomb, FrictionLaw
from frictionlab.components.impact import ImpactLaw
from frictionlab.models.mechanical.stored_energies import borders_of_law, borders_within, energy_of_spring
from frictionlab.models.symbolic_laws import symbolic_copy
from frictionlab.models.symbols import symbol
from frictionlab.structures.steady_friction import (
    SteadyFriction,
    UnsettledStatesError,
    lagging_states,
    steady_friction,
)
from frictionlab.tape.formulas import Formulas, formulas_of
from frictionlab.validation import (
    abbreviate,
    check_number,
    check_text,
    explains_fields,
    float_array,
    with_article,
)

Array = NDArray[np.float64]
NAME_CURE = 'name the contacts, such as "inner"'
COMPLEX_STEP = 1e-30  # of a derivative by an imaginary step, which cancels nothing


NO_STATES = np.zeros((0, 0))


class ContactForces(NamedTuple):
    """Forces of contacts, and how they change.

    Parameters
    ----------
    penetration : array (k,)
        m; NaN where the normal force is given.
    normal, friction : array (k,)
        F_N and F_T, N; 0 where the contact is open.
    normal_slope, friction_slope : array (k,)
        Their derivatives by the penetration, N/m.
    damping : array (k,)
        Derivative of the friction force by the sliding speed, N s/m.
    states : array (all states of the law, k)
        Of the friction law in steady sliding; 0 where the contact is open.
    by_states : array (s, k)
        Derivatives of the friction force by the states that lag; those above do without these.
    lag, rates_by_penetration, rates_by_speed : array (s, k)
        Factors and derivatives of the rates of these states, all times a factor that makes forces of them.
    rates_by_states : array (s, s, k)
        The same of their derivatives by the states.
    """

    penetration: Any
    normal: Any
    friction: Any
    normal_slope: Any
    friction_slope: Any
    damping: Any
    states: Any = NO_STATES
    by_states: Any = NO_STATES
    lag: Any = NO_STATES
    rates_by_penetration: Any = NO_STATES
    rates_by_speed: Any = NO_STATES
    rates_by_states: Any = NO_STATES[None]

    @property
    def steady_slope(self) -> Any:
        """Derivative of the friction force by the penetration (k,), which the states of the law follow."""
        if not len(self.lag):
            return self.friction_slope
        matrices = np.moveaxis(self.rates_by_states, (0, 1), (-2, -1))
        moved = np.linalg.solve(-matrices, np.moveaxis(self.rates_by_penetration, 0, -1)[..., None])
        moved = np.moveaxis(moved[..., 0], -1, 0)
        return self.friction_slope + (self.by_states * moved).sum(axis=0)


class StateRows(NamedTuple):
    """What m states of friction laws add to a pencil: C_z z' + C_q q' + K_z z + K_q q = 0, and -F z in N.

    Of forces at N points all are full, with N in front.

    Parameters
    ----------
    forces : sparse array (n, m)
        What the states add to the equations of the freedoms.
    stiffness, damping : sparse array (m, n)
        K_q and C_q.
    own_stiffness : array (k, s, s)
        The blocks of K_z, one for each contact.
    own_damping : array (m,)
        The diagonal of C_z.
    """

    forces: Any
    stiffness: Any
    damping: Any
    own_stiffness: Any
    own_damping: Any


@explains_fields
@dataclass(frozen=True, eq=False, repr=False)
class SlidingContacts:
    """Contacts of a structure that slide steadily, each with a row of the freedoms.

    The penetration of a contact is g q + delta_0, its relative velocity v - t q'.  With F_N by the contact
    law, 0 where the contact is open, and F_T by the friction law, the forces on the structure are

        -g^T F_N + t^T F_T

    Values of the laws' parameters, v and N are parameters of the structure.  Groups of contacts share those
    of the same name, unless the groups have names.

    Parameters
    ----------
    tangential : matrix (k, n), optional
        Rows t, see :func:`relative_rows`.  None without friction.
    normal : matrix (k, n), optional
        Rows g, whose positive direction presses the bodies together.  None where N is given.
    contact : ContactLaw
        Of the normal force; per area, if there are areas.
    friction : FrictionLaw, optional
        Of a law with states, such as LuGre's, each contact has its own.  They are states of motions, named as
        those of models: z of one contact, z_1 and z_2 of two, numbered through all groups.  None: contacts
        without friction.
    v : float
        Velocity (m/s) with which the counterpart moves along the tangent.  At 0 friction damps motions, but
        there is no steady sliding, thus no equilibrium nor eigenvalues but those in stick, see
        :meth:`Structure.in_stick`.
    N : float, optional
        Normal force (N) of each contact, where no penetration determines it.
    impact : ImpactLaw, optional
        Of motions, where a gap closes.  None: no impact, as the contact has no mass.
    penetration : float or array (k,)
        delta_0, that without displacements, m; negative for a gap.
    area : float or array (k,)
        Factors of the forces.
    name : str, optional
        At the end of the names of its parameters: those of "inner" are mu_k_inner, v_inner, ...

    Raises
    ------
    ValueError
        For rows that are not of the same number, not finite, zero, or there twice.

    Examples
    --------
    The slider of Hoffmann et al. (2002), whose contact spring is one of two in the normal direction:

    >>> import frictionlab as fl
    >>> contacts = fl.SlidingContacts([[1.0, 0.0]], [[0.0, 1.0]], fl.LinearContact(k2=4 / 3), fl.Coulomb(0.5))
    >>> springs = [[1.125, 0.21650635], [0.21650635, 0.375]]
    >>> structure = fl.Structure([[1, 0], [0, 1]], springs, contacts=contacts, load=[0.0, 1.0])
    >>> round(fl.critical_value(structure, "mu_k", (0, 1)), 6)
    0.457069
    """

    tangential: Any = None
    normal: Any = None
    contact: ContactLaw = LinearContact()
    friction: FrictionLaw | None = Coulomb()
    v: float = 1.0
    N: float | None = None
    impact: ImpactLaw | None = None
    penetration: Any = 0.0
    area: Any = 1.0
    name: str | None = None

    def __post_init__(self) -> None:
        self._check_laws()
        if self.name is not None and not check_text("name", self.name, NAME_CURE).isidentifier():
            raise ValueError(f"name must be a word of letters and digits, got {self.name!r}: {NAME_CURE}")
        cures = {"normal": "or a normal force N", "tangential": "or friction=None"}
        for name, needed in (("normal", self.N is None), ("tangential", self.friction is not None)):
            rows = getattr(self, name)
            if rows is None and needed:
                raise ValueError(f"{name} must be rows of the freedoms, got None: give them, {cures[name]}")
            if rows is not None:
                object.__setattr__(self, name, _rows(name, rows))
        if self.normal is not None and self.N is not None:
            raise ValueError(f"N must be None where there are rows of normal, got {self.N}: leave one out")
        if self.normal is None and self.tangential is None:
            raise ValueError("contacts must have rows, got none: give normal or tangential")
        shapes = [one.shape for one in (self.normal, self.tangential) if one is not None]
        if shapes[0] != shapes[-1]:
            raise ValueError(
                f"normal and tangential must have rows of the same contacts, got the shapes {shapes[0]} and "
                f"{shapes[1]}: give one row each"
            )
        self._check_repeats()
        for name in ("penetration", "area"):
            cure = "give one number, or one for each contact"
            given = float_array(name, getattr(self, name), cure, finite=True)
            if given.shape not in ((), (self.count,)):
                raise ValueError(
                    f"{name} must be of {self.count} contacts, got the shape {given.shape}: {cure}"
                )
            object.__setattr__(self, name, np.broadcast_to(given, (self.count,)).copy())
        if not (self.area > 0.0).all():
            raise ValueError(f"area must be above 0, got {self.area.min():g}: leave out such contacts")

    @property
    def count(self) -> int:
        """The number k of contacts."""
        return self._any_rows.shape[0]

    @property
    def size(self) -> int:
        """The number n of freedoms."""
        return self._any_rows.shape[1]

    @cached_property
    def parameters(self) -> Mapping[str, float]:
        """Values of the laws' parameters, of v and of N."""
        values = {name: getattr(law, name) for law in self.laws for name in parameters_of(type(law))}
        values |= {} if self.friction is None else {"v": self.v}
        values |= {} if self.N is None else {"N": self.N}
        return {self.parameter(name): value for name, value in values.items()}

    def parameter(self, name: str) -> str:
        """What a parameter of a law, v or N is called in the structure."""
        return name if self.name is None else f"{name}_{self.name}"

    def symbolic_law(self, role: str) -> Any:
        """The law of contact, friction or impact with symbols for its parameters; None without one."""
        law: Component | None = getattr(self, role)
        if law is None:
            return None
        copy = symbolic_copy(law.structure_key)
        for name in parameters_of(type(law)):
            object.__setattr__(copy, name, symbol(self.parameter(name)))
        return copy

    def with_values(self, values: Mapping[str, float]) -> Self:
        """The same contacts with other values of parameters, checked by their rules."""
        given = {name: values[each] for name in ("v", "N") if (each := self.parameter(name)) in values}
        changes: dict[str, Any] = dict(given)
        for role in ("contact", "friction", "impact"):
            law: Component | None = getattr(self, role)
            if law is None:
                continue
            own = ((name, self.parameter(name)) for name in parameters_of(type(law)))
            if inner := {name: values[each] for name, each in own if each in values}:
                changes[role] = replace(law, **inner)
        return self._with(changes)

    def without_friction(self) -> Self:
        """The same contacts, whose forces are normal, without impacts."""
        return self._with({"friction": None, "impact": None, "tangential": None})

    def _with(self, changes: dict[str, Any]) -> Self:
        copy = object.__new__(type(self))
        copy.__setstate__(self.__getstate__() | changes)
        copy._check_laws()
        return copy

    def projected(self, basis: Array) -> Self:
        """The contacts of a structure whose displacements are in the span of a basis (n, r)."""
        return self._with_rows(lambda rows: sparse.csr_array(rows @ basis))

    def full(self) -> Self:
        """The same contacts, with rows as full matrices."""
        return self._with_rows(lambda rows: rows.toarray())

    def _with_rows(self, change: Callable[[Any], Any]) -> Self:
        copy = object.__new__(type(self))
        copy.__setstate__(vars(self))  # with the formulas
        for name in ("normal", "tangential"):
            if (rows := getattr(self, name)) is not None:
                object.__setattr__(copy, name, change(rows))
        return copy

    def forces(self, q: Any, values: Mapping[str, Any]) -> ContactForces:
        """The forces at displacements q (n,) and values of the parameters; both may be complex.

        Of many displacements (N, n) and values (N, 1) each force is (N, k).
        """
        one = np.ones((*np.shape(q)[:-1], self.count))
        if self.normal is None:
            penetration, closed = np.nan * one, one > 0.0
            pressure, stiffness = values[self.parameter("N")] * one, 0.0 * one
        else:
            penetration = (self.normal @ q.T).T + self.penetration
            closed = penetration.real > 0.0
            law, slope = self._contact_formulas
            given = [np.where(closed, penetration, 0.0), *self._values(self.contact, values)]
            pressure, stiffness = _evaluated(law, given), _evaluated(slope, given)
        normal = np.where(closed, self.area * pressure, 0.0)
        normal_slope = np.where(closed, self.area * stiffness, 0.0)
        if self.friction is None:
            return ContactForces(penetration, normal, 0.0 * normal, normal_slope, 0.0 * normal, 0.0 * normal)
        v = values[self.parameter("v")]
        sign = np.sign(np.real(v))
        if not np.all(sign):
            raise ValueError(
                f"{self.parameter('v')} must not be 0 for steady sliding, got 0.0: give the counterpart a "
                "speed, let the contact stick by structure.in_stick(), or take friction=None"
            )
        # the pressure of an open contact is put to any number, as laws may have no slope at 0
        pressed = np.where(closed, pressure, 1.0)
        if self.friction.states:
            given = self._values(self.friction, values)
            steady = steady_friction(self.friction, pressed, v, given)
            if q.ndim == 1 and np.isnan(steady.force[closed]).any():
                names = map(self.parameter, (*self._names(self.friction), "v"))
                at = ", ".join(f"{one} = {np.real(x):.6g}" for one, x in zip(names, (*given, v), strict=True))
                raise UnsettledStatesError(
                    "friction must have states that settle in steady sliding, got "
                    f"{type(self.friction).__name__} at {at}, where none were found whose rates are zero: "
                    "change its parameters, or the speed v"
                )
            known = ContactForces(penetration, normal, None, normal_slope, None, None)
            return self._with_states(known, steady, stiffness, closed)
        law, by_force, by_speed = self._friction_formulas
        given = [pressed, sign * v * one, *self._values(self.friction, values)]
        parts = [
            np.where(closed, self.area * _evaluated(each, given), 0.0) for each in (law, by_force, by_speed)
        ]
        friction, friction_slope = sign * parts[0], sign * parts[1] * stiffness
        return ContactForces(penetration, normal, friction, normal_slope, friction_slope, parts[2])

    def _with_states(
        self, known: ContactForces, steady: SteadyFriction, stiffness: Any, closed: Any
    ) -> ContactForces:
        """The forces with those of a friction law with states; states of open contacts are at rest."""
        by_states = np.where(closed, self.area * steady.by_states, 0.0)
        at_rest = -np.eye(len(by_states)).reshape(*(len(by_states),) * 2, *(1,) * closed.ndim)
        own = np.where(closed, steady.rates_by_states, at_rest)
        sizes = np.abs(np.real(own)).max(axis=1, initial=0.0)
        lag = np.abs(np.real(by_states)) / np.where(sizes > 0.0, sizes, 1.0)
        lag = np.where(closed, np.where(lag > 0.0, lag, 1.0), 0.0)
        scale = np.where(closed, lag, 1.0)
        return known._replace(
            friction=np.where(closed, self.area * steady.force, 0.0),
            friction_slope=np.where(closed, self.area * steady.by_force * stiffness, 0.0),
            damping=np.where(closed, self.area * steady.by_speed, 0.0),
            states=np.where(closed, steady.states, 0.0),
            by_states=by_states,
            lag=lag,
            rates_by_penetration=lag * steady.rates_by_force * stiffness,
            rates_by_speed=lag * steady.rates_by_speed,
            rates_by_states=scale[:, None] * own,
        )

    def state_rows(self, forces: ContactForces) -> StateRows:
        """What the states of the friction law that lag add to a pencil, those of one contact together."""
        count = self.count * len(self.lagging)
        contacts = np.repeat(np.arange(self.count), len(self.lagging))

        def of_states(values: Array) -> Array:
            return np.moveaxis(values, 0, -1).reshape(*values.shape[1:-1], count)

        tangential = self.tangential[contacts]
        damping = tangential * of_states(forces.rates_by_speed)[..., None]
        stiffness = 0.0 * damping
        if self.normal is not None:
            stiffness = -(self.normal[contacts] * of_states(forces.rates_by_penetration)[..., None])
        return StateRows(
            -(tangential.T * of_states(forces.by_states)[..., None, :]),
            stiffness,
            damping,
            -np.moveaxis(forces.rates_by_states, (0, 1), (-2, -1)),
            of_states(forces.lag),
        )

    @cached_property
    def lagging(self) -> tuple[str, ...]:
        """Names of the states of the friction law that lag behind motions about steady sliding."""
        return lagging_states(self.friction)

    def stored_energy(self, q: Array, values: Mapping[str, float]) -> Array:
        """The energy (N,) of the contacts at displacements (N, n), J: the integral of F_N, by Gauss' rule."""
        depth = np.maximum(q @ self.normal.toarray().T + self.penetration, 0.0)
        law, given = self._contact_formulas[0], self._values(self.contact, values)
        beyond = [lambda one, of=of: _evaluated(of, [one, *given]) for of in self._borders_of_contact]
        borders = borders_within(beyond, depth)
        energy = energy_of_spring(lambda one: _evaluated(law, [one, *given]), depth, borders)
        return energy @ self.area

    def on_structure(self, forces: ContactForces) -> Any:
        """What forces put on the structure (n,), or on each of many."""
        pressed = 0.0 if self.normal is None else -(forces.normal @ self.normal)
        return pressed if self.tangential is None else pressed + forces.friction @ self.tangential

    def reach(
        self, forces: ContactForces, shape: Any, value: complex, values: Mapping[str, float]
    ) -> list[float]:
        """How many times a motion Re(shape e^(value t)) about steady sliding may be for its first event."""
        reach: list[float] = []
        with np.errstate(divide="ignore"):
            if self.normal is not None:
                reach += (np.abs(forces.penetration) / np.abs(self.normal @ shape)).tolist()
            if self.tangential is not None and self.friction is not None:
                closed = forces.normal > 0.0
                v = abs(values[self.parameter("v")])
                reach += (v / np.abs(value * (self.tangential @ shape))[closed]).tolist()
        return reach

    def damping(self, forces: ContactForces) -> Any:
        """What friction adds to C (n, n), or to each of many; 0 without friction."""
        if self.tangential is None:
            return 0
        return (self.tangential.T * forces.damping[..., None, :]) @ self.tangential

    def stiffness(self, forces: ContactForces) -> Any:
        """What contacts add to K (n, n), or to each of many; 0 where their normal forces are given.

        It is that with the states of friction laws held.
        """
        if self.normal is None:
            return 0
        pressing = self.normal.T * forces.normal_slope[..., None, :]
        if self.tangential is not None:
            pressing = pressing - self.tangential.T * forces.friction_slope[..., None, :]
        return pressing @ self.normal

    def steady_stiffness(self, forces: ContactForces) -> Any:
        """The same of steady sliding, with states that follow."""
        return self.stiffness(forces._replace(friction_slope=forces.steady_slope))

    def secant_stiffness(self, force: float, values: Mapping[str, float]) -> Array:
        """Stiffnesses (k,), N/m, of contacts that carry a normal force together, for a start."""
        law, given = self._contact_formulas[0], self._values(self.contact, values)
        depth = np.finfo(float).eps
        while depth < 1.0:
            carried = float(self.area.sum() * _evaluated(law, [depth, *given]))
            if carried >= force and carried > 0.0:
                break
            depth *= 2.0
        return self.area / self.area.sum() * max(carried, np.finfo(float).tiny) / depth

    @property
    def laws(self) -> list[Component]:
        """Those that act, of contact, friction and impact."""
        laws: list[Component] = [] if self.normal is None else [self.contact]
        laws += [] if self.friction is None else [self.friction]
        return laws if self.impact is None else [*laws, self.impact]

    @property
    def _any_rows(self) -> Any:
        return self.tangential if self.normal is None else self.normal

    @cached_property
    def _contact_formulas(self) -> tuple[Formulas, Formulas]:
        at = symbol("penetration")
        law = symbolic_copy(self.contact.structure_key).force(at)
        formulas = formulas_of([at, *map(symbol, self._names(self.contact))], [law])
        return formulas, formulas.jacobian([0])[1]

    @cached_property
    def _borders_of_contact(self) -> tuple[Formulas, ...]:
        at = symbol("penetration")
        law = symbolic_copy(self.contact.structure_key).force(at)
        given = [at, *map(symbol, self._names(self.contact))]
        return tuple(formulas_of(given, [one]) for one in borders_of_law(law, at))

    @cached_property
    def _friction_formulas(self) -> tuple[Formulas, Formulas, Formulas]:
        assert self.friction is not None
        force, speed = symbol("normal_force"), symbol("speed")
        law = symbolic_copy(self.friction.structure_key).kinetic(force, speed)
        formulas = formulas_of([force, speed, *map(symbol, self._names(self.friction))], [law])
        return formulas, formulas.jacobian([0])[1], formulas.jacobian([1])[1]

    def _values(self, law: Component, values: Mapping[str, Any]) -> list[Any]:
        return [values[self.parameter(name)] for name in self._names(law)]

    @staticmethod
    def _names(law: Component) -> tuple[str, ...]:
        return law.structure_key.parameters

    def _check_laws(self) -> None:
        kinds = (("contact", ContactLaw), ("friction", FrictionLaw), ("impact", ImpactLaw))
        for name, kind in kinds:
            law = getattr(self, name)
            if not isinstance(law, kind) and not (law is None and name != "contact"):
                raise TypeError(f"{name} must be {with_article(kind)}, got {abbreviate(law)}: give one")
        if self.impact is not None and self.friction is None:
            raise ValueError(
                f"impact must be None where contacts have no friction law, got {abbreviate(self.impact)}: "
                "give friction, such as Coulomb(mu_k=0.0, mu_s=0.0) for impacts without friction"
            )
        object.__setattr__(self, "v", float(check_number("v", self.v)))
        if self.N is not None:
            object.__setattr__(self, "N", float(check_number("N", self.N, above=0.0)))

    def _check_repeats(self) -> None:
        rows: Any = [one for one in (self.normal, self.tangential) if one is not None]
        seen: dict[bytes, int] = {}
        for i in range(self.count):
            parts = [one[[i]].tocoo() for one in rows]
            key = b"".join(part.col.tobytes() + part.data.tobytes() + b"|" for part in parts)
            if (other := seen.setdefault(key, i)) != i:
                raise ValueError(
                    f"each contact must be there once, got the same rows for {other} and {i}: leave one out"
                )

    def __getstate__(self) -> dict[str, Any]:  # formulas are made again where they are needed
        return {each.name: getattr(self, each.name) for each in fields(self)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        for name, value in state.items():
            object.__setattr__(self, name, value)

    def __repr__(self) -> str:
        laws = ", ".join(map(repr, self.laws))
        return f"SlidingContacts({self.count} x {self.size}, {laws})"


def _evaluated(formulas: Formulas, given: list[Any]) -> Any:
    """The one value of a formula, 0 where it has none as it vanishes everywhere."""
    with np.errstate(all="ignore"):
        values = formulas.arrays(*given)
    return values[0] if values else 0.0


def _rows(name: str, given: Any) -> Any:
    """Rows of the freedoms, sparse; none is zero."""
    cure = "give one row for each contact and one column for each freedom"
    values = given if sparse.issparse(given) else float_array(name, given, cure)
    if values.ndim != 2 or values.dtype.kind not in "iuf":
        raise ValueError(f"{name} must be a matrix of numbers, got {abbreviate(given)}: {cure}")
    rows: Any = sparse.csr_array(values).astype(float)
    rows.sum_duplicates()
    rows.eliminate_zeros()
    if not np.isfinite(rows.data).all():
        raise ValueError(
            f"{name} must hold finite numbers, got {rows.data[~np.isfinite(rows.data)][0]}: {cure}"
        )
    if not rows.shape[0] or not (empty := np.diff(rows.indptr) > 0).all():
        at = int(empty.argmin()) if rows.shape[0] else 0
        raise ValueError(f"{name} must have rows that are not zero, got row {at}: {cure}")
    return rows


def relative_rows(pairs: Any, size: int) -> sparse.csr_array:
    """Rows of q[i] - q[j] for pairs (i, j) of freedoms, as of node pairs in contact.

    Parameters
    ----------
    pairs : array_like (k, 2)
        Freedoms, counted from 0.  -1 stands for a counterpart that is no part of the structure.
    size : int
        The number n of freedoms.

    Returns
    -------
    csr_array (k, n)

    Raises
    ------
    ValueError
        For what are no pairs of freedoms, or pairs of one with itself.

    Examples
    --------
    >>> import frictionlab as fl
    >>> fl.relative_rows([(0, 2), (1, -1)], 3).toarray().tolist()
    [[1.0, 0.0, -1.0], [0.0, 1.0, 0.0]]
    """
    n = check_number("size", size, integer=True, least=1, most=np.iinfo(np.int32).max)
    cure = "give rows of two freedoms, such as [(0, 2), (1, -1)]"
    given = float_array("pairs", pairs, cure, finite=True)
    if given.ndim != 2 or given.shape[1] != 2 or not len(given) or (given != given.astype(int)).any():
        raise ValueError(f"pairs must be rows of two freedoms, got {abbreviate(pairs)}: {cure}")
    places = given.astype(int)
    if (places < -1).any() or (places >= n).any() or (places[:, 0] == places[:, 1]).any():
        raise ValueError(
            f"pairs must be two different freedoms from 0 to {n - 1}, or -1, got {abbreviate(pairs)}: {cure}"
        )
    row, side = np.nonzero(places >= 0)
    signs = np.array([1.0, -1.0])[side]
    return sparse.csr_array((signs, (row, places[row, side])), shape=(len(places), n))
