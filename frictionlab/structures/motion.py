"""The motion of a structure: its matrices and contacts as a hybrid automaton.

M q'' = load - (C + G) q' - (K + N) q - sum of g^T F_N + sum of t^T F_T, each contact in a regime of its own:
separation, slip in either direction, or stick.  M^-1 times all matrices is computed once, with numbers, and
each acceleration is one row of a product (:mod:`frictionlab.automaton.matrix_rows`).  Sympy sees the laws of
the contacts alone.  A mode differs from another in what its contacts add, F_T of those that stick being

    F = -(T M^-1 T^T)^-1 (T a - d v/dt),  a: accelerations without these forces, T: rows t of these contacts.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
import sympy
from numpy.typing import NDArray

from frictionlab.automaton import HybridAutomaton, Mode, Reset
from frictionlab.automaton.hybrid_automaton import module_of_pieces
from frictionlab.automaton.matrix_rows import MatrixProduct, MatrixRow, matrix_rows
from frictionlab.automaton.modes_on_demand import JOINT, Combination, ModesOnDemand, check_mode_name
from frictionlab.components.contact import StickSlipSeparation
from frictionlab.components.friction import FrictionLaw
from frictionlab.components.impact import ImpactLaw, has_friction
from frictionlab.models.mechanical.common_directions import CommonDirection
from frictionlab.models.mechanical.contact_regimes import (
    CLOSING,
    ContactRegime,
    impulse_of_friction,
    rate_after,
)
from frictionlab.models.mechanical.coupled_masses import inverse_of, product
from frictionlab.models.mechanical.dynamic_laws import check_elastic, limits_of_states, zeros_at_landing
from frictionlab.models.mechanical.equations_of_motion import LagrangeSystem, Regimes, names_with_states
from frictionlab.models.mechanical.impulses import impulses_along
from frictionlab.models.mechanical.law_states_at_start import StatesOfLaws, contacts_with_states
from frictionlab.models.mechanical.mechanics import AnyContact, Contact, Friction, Mechanics, Stop
from frictionlab.models.mechanical.modes import (
    HoldingForce,
    Solution,
    conditions_of_regimes,
    contact_suffix,
    expressions_of,
    mode_of,
)
from frictionlab.models.mechanical.stored_energies import Energies, energies_of_bristles
from frictionlab.models.symbols import expand_products, state_symbols, symbol
from frictionlab.presentation import shorten
from frictionlab.structures.parametric_matrix import parse_coefficient
from frictionlab.structures.sliding_contacts import SlidingContacts
from frictionlab.tape.formulas import formulas_of

if TYPE_CHECKING:
    from frictionlab.structures.structure import Structure

Array = NDArray[np.float64]
MOST_FREEDOMS = 1000  # of a structure that moves: matrices are full
DEPENDENT = 1e-10  # share of the largest compliance below which contacts hold the same velocities
SAME_SPEED = 1e-9  # share of the speeds of contacts whose sum is zero but for rounding
PARALLEL = 1e-12  # sine of the angle between two rows that are one direction


def automaton_of_structure(structure: Structure) -> HybridAutomaton:
    """The automaton of a structure; those that differ in values of parameters alone share its modes.

    Raises
    ------
    ValueError
        For a structure that is too large, has freedoms without mass, or complex stiffness.
    """
    _check_motion(structure)
    states, modes = _modes_of(_Identity(_identity_of(structure), structure))
    parameters = {symbol(name): structure.parameters[name] for name in _named(structure)}
    return HybridAutomaton(states, modes, parameters, structure.size)


def _named(structure: Structure) -> tuple[str, ...]:
    """Parameters of the automaton: those on which M depends are numbers in the modes, as M^-1 is."""
    return tuple(name for name in structure.parameters if name not in structure.M.parameters)


def states_of_laws(structure: Structure) -> StatesOfLaws:
    """What is known of the states of friction laws where a run begins."""
    return _states_of_laws(_Identity(_identity_of(structure), structure))


def bristles_of_structure(structure: Structure) -> Energies:
    """The energies in the states of friction laws."""
    return energies_of_bristles(_system_of(_Identity(_identity_of(structure), structure)))


@lru_cache(maxsize=16)
def _states_of_laws(of: _Identity) -> StatesOfLaws:
    system, names = _system_of(of), _named(of.structure)
    contacts = contacts_with_states(system)
    inputs = [*system.states, *map(symbol, names)]
    formulas = formulas_of(inputs, [one for _, some in contacts for one in some])
    return StatesOfLaws([about for about, _ in contacts], formulas, names)


def _check_motion(structure: Structure) -> None:
    if structure.size > MOST_FREEDOMS:
        raise ValueError(
            f"a structure must have at most {MOST_FREEDOMS} freedoms to move, got {structure.size}: reduce "
            "it to its modes"
        )
    if structure.massless:
        listed = shorten(map(str, structure.massless))
        raise ValueError(
            f"M must give each freedom a mass to move, got none for {listed}: eliminate or reduce them"
        )
    for name in structure.M.parameters:
        if any(name in one.parameters for one in structure.contacts):
            raise ValueError(
                f"M must not depend on a parameter of contacts to move, got {name}: rename one of the two"
            )
    if any(matrix.dtype.kind == "c" for matrix in structure.K.matrices):
        raise ValueError(
            "K must be real to move, got hysteretic damping, which is one of vibrations at one frequency: "
            "give its real part, and viscous damping C"
        )


@dataclass(frozen=True)
class _Identity:
    """What the modes of a structure depend on, by content, and a structure that has it."""

    content: Hashable
    structure: Any

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Identity) and self.content == other.content

    def __hash__(self) -> int:
        return hash(self.content)


def _identity_of(structure: Structure) -> Hashable:
    """The matrices, rows and kinds of laws; values of parameters only where M depends on them."""
    matrices = [one for terms in (*structure.terms, (structure.load,)) for one in terms if one is not None]
    mass = tuple(structure.parameters[name] for name in structure.M.parameters)
    contacts = tuple(_identity_of_contacts(one) for one in structure.contacts)
    content = tuple((one.coefficients, tuple(map(_bytes, one.matrices))) for one in matrices)
    kinds = tuple(len(terms) for terms in structure.terms)
    return tuple(structure.parameters), kinds, content, mass, contacts, tuple(_speeds(structure))


def _speeds(structure: Structure) -> Array:
    """Speeds of the contacts' counterparts (contacts,), as shares of the largest; 0 where they rest."""
    values = [structure.parameters.get(one.parameter("v"), 0.0) for one in structure.contacts]
    speeds = np.repeat(values, [one.count for one in structure.contacts])
    return speeds / speeds[np.abs(speeds).argmax()] if speeds.any() else speeds


def _identity_of_contacts(one: SlidingContacts) -> Hashable:
    keys = tuple(law if law is None else law.structure_key for law in (one.contact, one.friction, one.impact))
    keys = (*keys, one.name)
    rows = tuple(None if given is None else _bytes(given) for given in (one.normal, one.tangential))
    return keys, rows, one.penetration.tobytes(), one.area.tobytes(), one.N is None


def _bytes(matrix: Any) -> Hashable:
    return matrix.shape, matrix.indptr.tobytes(), matrix.indices.tobytes(), matrix.data.tobytes()


@lru_cache(maxsize=16)
def _system_of(of: _Identity) -> StructureSystem:
    return structure_system(of.structure)


@lru_cache(maxsize=16)
def _modes_of(of: _Identity) -> tuple[tuple[Any, ...], Any]:
    structure, system = of.structure, _system_of(of)

    def derive(combination: Combination) -> Mode:
        return mode_of(system, combination, system.hold)

    again = modes_of_structure, (structure,)
    if len(system.parts) <= 1:
        modes: Any = tuple(map(derive, system.names.combinations()))
    else:
        modes = ModesOnDemand(
            conditions_of_regimes(system), derive, system.names, again, products=system.products
        )
    pieces = module_of_pieces()
    if pieces is not None and pieces.has_pieces(expressions := list(expressions_of(system))):
        modes = pieces.split_modes(modes, system.states, expressions, again)
    return system.states, modes


def modes_of_structure(structure: Structure) -> Any:
    """The modes of a structure, the same object throughout a process."""
    return structure.automaton().modes


def structure_system(structure: Structure) -> StructureSystem:
    """The equations of motion of a structure, with symbols for its parameters."""
    contacts = [one for group in structure.contacts for one in _contacts(group, structure)]
    n = structure.size
    states = state_symbols(structure.coordinates)
    rows = {
        name: np.vstack([np.zeros((0, n)), *(_full(getattr(one, name), one) for one in structure.contacts)])
        for name in ("normal", "tangential")
    }
    inverse = inverse_of(structure.M.at(structure.parameters).toarray())
    return StructureSystem(
        Mechanics(0, contacts=tuple(contacts)),
        states[:n],
        states[n:],
        (),
        (),
        (),
        of_laws=_checked_states(contacts, structure),
        free=_free_motion(structure, inverse),
        normals=rows["normal"],
        tangents=rows["tangential"],
        masses_inverse=inverse,
        belts=tuple(symbol(one.parameter("v")) for one in structure.contacts for _ in range(one.count)),
        speeds=_speeds(structure),
    )


def impulses_by_name(structure: Structure, events: Any) -> dict[str, Array]:
    """The impulses (E,) of a run's events, N s: v+ - v- = M^-1 (T^T p_T - G^T p_N) where a gap closes."""
    system, by_name = _system_of(_Identity(_identity_of(structure), structure)), dict[str, Array]()
    jumps = (events.state - events.before)[:, structure.size : 2 * structure.size]
    for i, contact in enumerate(system.mechanics.contacts):
        if not isinstance(contact, Friction) or contact.impact is None:
            continue
        suffix, columns = contact_suffix(system, i), system.directions_of_impact(i, contact.impact)
        impulses, struck = np.zeros((len(columns), len(events))), events.guard == "gap" + suffix
        impulses[:, struck] = impulses_along(columns.T, jumps[struck].T)
        by_name |= dict(zip(("impulse" + suffix, "friction_impulse" + suffix), impulses))
    return by_name


def _checked_states(contacts: Sequence[AnyContact], structure: Structure) -> tuple[tuple[Any, ...], ...]:
    """The states of the contacts' friction laws, which are such that events end their regimes."""
    states = tuple(tuple(map(symbol, names)) for names in structure.law_states)
    for contact, some in zip(contacts, states, strict=True):
        if isinstance(contact, Friction) and limits_of_states(contact):
            check_elastic(contact.law, some)
    return states


def contacts_with_undetermined_friction(structure: Structure, mode: str) -> tuple[int, ...]:
    """Numbers, from 1 on, of the contacts of a mode whose friction forces the equations do not determine.

    Their v_r are zero and depend on each other.  States of a friction law determine its force.
    """
    names = structure.automaton().names
    check_mode_name(mode, names)
    zero = np.zeros((0, structure.size))
    rows = np.vstack([zero, *(_full(one.tangential, one) for one in structure.contacts)])
    size = np.linalg.norm(rows, axis=1, keepdims=True)
    unit = rows / np.where(size > 0.0, size, 1.0)
    speeds = np.hstack([unit, _speeds(structure)[:, None] / np.where(size > 0.0, size, np.inf)])
    regimes = ["" if some else name for name, some in zip(mode.split(JOINT), structure.law_states)]
    stuck = [i for i, name in enumerate(regimes) if name == "stick"]
    rubbing = [i for i, name in enumerate(regimes) if name.startswith("slip")]
    stuck += [i for i in rubbing if stuck and _distance(speeds[i], speeds[stuck]) < SAME_SPEED]
    others = {i: [j for j in stuck if j != i] for i in sorted(stuck)}
    return tuple(i + 1 for i, some in others.items() if some and _distance(unit[i], unit[some]) < SAME_SPEED)


def _distance(row: Array, rows: Array) -> float:
    """Of a row (n,) from the span of rows (k, n)."""
    return float(np.linalg.norm(row - rows.T @ np.linalg.lstsq(rows.T, row)[0]))


def _full(rows: Any, one: SlidingContacts) -> Array:
    return np.zeros((one.count, one.size)) if rows is None else rows.toarray()


def _free_motion(structure: Structure, inverse: Array) -> MatrixProduct:
    """M^-1 (load - (C + G) q' - (K + N) q).

    A matrix that is in K and in C, as with Rayleigh's damping, is one product with a q + b q'.
    """
    q, v = _split(state_symbols(structure.coordinates))
    _, damping, stiffness = structure.terms
    coefficients: dict[Hashable, list[Any]] = {}
    matrices: dict[Hashable, Any] = {}
    for place, terms in enumerate((stiffness, damping)):
        for coefficient, matrix in (each for one in terms for each in _coefficients(one, structure)):
            key = _bytes(matrix)
            matrices[key] = matrix
            coefficients.setdefault(key, [sympy.S.Zero, sympy.S.Zero])[place] += coefficient
    blocks, factors = [np.zeros((structure.size, 0))], list[Any]()
    for key, (of_q, of_v) in coefficients.items():
        block = -_without_rounding(inverse, matrices[key].toarray())
        moving: list[int] = np.flatnonzero(block.any(axis=0)).tolist()
        blocks.append(block[:, moving])
        factors += [of_q * q[j] + of_v * v[j] for j in moving]
    for coefficient, column in () if structure.load is None else _coefficients(structure.load, structure):
        blocks.append(product(inverse, column.toarray()))
        factors.append(coefficient)
    return MatrixProduct(np.hstack(blocks), tuple(factors))


def _without_rounding(one: Array, other: Array) -> Array:
    """The product of two matrices; entries that may be rounding errors are zero, as those of M^-1 M."""
    entries = product(one, other)
    errors = len(other) * np.finfo(float).eps * product(np.abs(one), np.abs(other))
    return np.where(np.abs(entries) > errors, entries, 0.0)


def _coefficients(one: Any, structure: Structure) -> Iterator[tuple[Any, Any]]:
    symbols = {name: symbol(name) for name in one.parameters}
    fixed = {symbol(name): structure.parameters[name] for name in structure.M.parameters}
    for text, matrix in zip(one.coefficients, one.matrices, strict=True):
        yield parse_coefficient(text, symbols).subs(fixed), matrix


def _contacts(group: SlidingContacts, structure: Structure) -> Iterator[AnyContact]:
    """The contacts of a group, in symbols."""
    q, v = _split(state_symbols(structure.coordinates))
    depths = [None] * group.count if group.normal is None else matrix_rows(group.normal.toarray(), q)
    rates = [None] * group.count
    if group.tangential is not None and group.friction is not None:
        rates = matrix_rows(group.tangential.toarray(), v)
    law, friction, impact = map(group.symbolic_law, ("contact", "friction", "impact"))
    given, belt = symbol(group.parameter("N")), symbol(group.parameter("v"))
    for i in range(group.count):
        depth, area = depths[i], float(group.area[i])
        names = StickSlipSeparation().modes
        if depth is None:
            names = tuple(name for name in names if name != "separation")
            force: Any = given * area if area != 1.0 else given
        else:
            depth = depth + float(group.penetration[i]) if group.penetration[i] else depth
            force = _per_area(law, area)
        if friction is None:
            yield Contact(depth, force, interface=_regimes(("contact", "separation")))
            continue
        shared: Any = friction if area == 1.0 else FrictionOnArea(friction, area)
        rubs = Friction(belt - rates[i], force, shared, depth, impact=impact, interface=_regimes(names))
        yield replace(rubs, interface=_regimes(names_with_states(rubs, names))) if shared.states else rubs


def _split(states: Sequence[Any]) -> tuple[Sequence[Any], Sequence[Any]]:
    n = len(states) // 2
    return states[:n], states[n:]


def _regimes(names: tuple[str, ...]) -> Any:
    return Regimes(names)


def _per_area(law: Any, area: float) -> Any:
    return law.force if area == 1.0 else lambda depth: area * law.force(depth)


@dataclass(frozen=True, eq=False, repr=False)
class FrictionOnArea(FrictionLaw):
    """A friction law of pressures, as one of forces on an area."""

    law: Any
    area: Any

    def kinetic(self, normal_force: Any, speed: Any) -> Any:
        """F_T in slip."""
        return self.area * self.law.kinetic(normal_force / self.area, speed)

    def static_limit(self, normal_force: Any) -> Any:
        """The largest F_T in stick."""
        return self.area * self.law.static_limit(normal_force / self.area)

    @property
    def states(self) -> tuple[str, ...]:
        """Those of the law."""
        return self.law.states

    def force(self, normal_force: Any, relative_velocity: Any, *states: Any) -> Any:
        """F_T of a law with states."""
        return self.area * self.law.force(normal_force / self.area, relative_velocity, *states)

    def rates(self, normal_force: Any, relative_velocity: Any, *states: Any) -> Any:
        """The rates of the states."""
        return self.law.rates(normal_force / self.area, relative_velocity, *states)

    def rates_in_separation(self, *states: Any) -> Any:
        """The rates while the bodies are apart."""
        return self.law.rates_in_separation(*states)

    def stored_energy(self, normal_force: Any, *states: Any) -> Any:
        """Energy in the states, J."""
        energy = self.law.stored_energy(normal_force / self.area, *states)
        return None if energy is None else self.area * energy

    def state_limit(self, normal_force: Any) -> Any:
        """The largest magnitudes of the states."""
        return self.law.state_limit(normal_force / self.area)


@dataclass(frozen=True, eq=False)
class StructureSystem(LagrangeSystem):
    """The equations of motion of a structure: q'' = free + M^-1 (T^T F_T - G^T F_N).

    Parameters
    ----------
    free : MatrixProduct (n,)
        Accelerations without contacts.
    normals, tangents : array (contacts, n)
        Rows g and t; zero where a contact has none.
    masses_inverse : array (n, n)
        M^-1.
    belts : tuple of Symbol (contacts,)
        Speeds of the contacts' counterparts.
    speeds : array (contacts,)
        Their values, as shares of the largest; 0 where they rest.
    """

    free: MatrixProduct = field(default_factory=lambda: MatrixProduct(np.zeros((0, 0)), ()))
    normals: Array = field(default_factory=lambda: np.zeros((0, 0)))
    tangents: Array = field(default_factory=lambda: np.zeros((0, 0)))
    masses_inverse: Array = field(default_factory=lambda: np.zeros((0, 0)))
    belts: tuple[Any, ...] = ()
    speeds: Array = field(default_factory=lambda: np.zeros(0))

    @cached_property
    def _pushed_by_normals(self) -> Array:
        """-M^-1 G^T (n, contacts)."""
        return -product(self.masses_inverse, self.normals.T)

    @cached_property
    def _pushed_by_tangents(self) -> Array:
        """M^-1 T^T (n, contacts)."""
        return product(self.masses_inverse, self.tangents.T)

    @cached_property
    def _compliance(self) -> Array:
        """T M^-1 T^T (contacts, contacts), 1/kg."""
        return product(self.tangents, self._pushed_by_tangents)

    @cached_property
    def _free(self) -> list[Any]:
        """Accelerations without contacts, (n,)."""
        return self.free.rows()

    @cached_property
    def _free_along_tangents(self) -> list[Any]:
        """T times these accelerations, (contacts,)."""
        return matrix_rows(product(self.tangents, self.free.matrix), self.free.factors)

    @cached_property
    def products(self) -> tuple[MatrixProduct, ...]:
        """The products of which modes have rows, whatever the regimes."""
        parts = [*self._free, *self._free_along_tangents]
        for one in self.mechanics.contacts:
            parts += [] if isinstance(one, Stop) or one.penetration is None else [one.penetration]
            parts += [one.relative_velocity] if isinstance(one, Friction) else []
        rows = sympy.Tuple(*parts).atoms(MatrixRow)
        return tuple(sorted({row.product for row in rows}, key=lambda product: product.number))

    def hold(self, chosen: Sequence[ContactRegime], leading: Sequence[int]) -> Solution:
        """Accelerations, the force of each contact, and those of the contacts `leading`, which stick."""
        forces = [regime.force for regime in chosen]
        acting = [one.pressing for one in chosen] + [force or sympy.S.Zero for force in forces]
        held, count = list(leading), len(chosen)
        holding: list[Any] = []
        if held:
            given = [k for k, force in enumerate(acting) if force != 0]
            pushed = product(self.tangents[held], self._pushed[:, given])
            stiff = -inverse_of(self._compliance[np.ix_(held, held)])
            holding = matrix_rows(
                product(stiff, np.hstack([np.eye(len(held)), pushed])),
                [*(self._free_along_tangents[i] for i in held), *(acting[k] for k in given)],
            )
            for i, force in zip(held, holding, strict=True):
                forces[i] = acting[count + i] = force
        known = zip(held, holding, strict=True)
        return self._accelerations(acting), forces, {i: [HoldingForce(force)] for i, force in known}

    def _accelerations(self, acting: Sequence[Any]) -> list[Any]:
        """Those of all normal and friction forces; modes share the terms unless most forces are zero."""
        moving = [k for k, force in enumerate(acting) if force != 0]
        if 2 * len(moving) >= len(acting):
            return self._by_forces.with_own(acting).rows()
        return matrix_rows(
            np.hstack([np.eye(len(self.q)), self._pushed[:, moving]]),
            [*self._free, *(acting[k] for k in moving)],
        )

    @cached_property
    def _by_forces(self) -> MatrixProduct:
        """The accelerations: those without contacts, and what all normal and friction forces add."""
        factors = (*self.free.factors, *[sympy.S.Zero] * self._pushed.shape[1])
        return MatrixProduct(np.hstack([self.free.matrix, self._pushed]), factors)

    @cached_property
    def _pushed(self) -> Array:
        """[-M^-1 G^T, M^-1 T^T] (n, 2 contacts)."""
        return np.hstack([self._pushed_by_normals, self._pushed_by_tangents])

    def direction(self, contact: AnyContact) -> Array:
        """W (n,): the direction of the friction force of a contact."""
        return self.tangents[self.mechanics.contacts.index(contact)]

    def stick_reset(self, contact: AnyContact) -> Reset:
        """v_r is zero after the event that begins stick; what rounding leaves of it does not grow."""
        i = self.mechanics.contacts.index(contact)
        direction = self.direction_of(i)
        together = (
            [i]
            if direction is None
            else [j for j in direction.contacts if j == i or direction.at_one_speed(j, i)]
        )
        speeds = [self.mechanics.contacts[j].relative_velocity for j in together]
        return Reset(vanishing={sign * speed: 1 for speed in speeds for sign in (1, -1)})

    def impact_resets(self, contact: AnyContact) -> tuple[Reset, Reset]:
        """The impact by the contact's law, and the one that closes a Zeno accumulation of impacts."""
        assert isinstance(contact, Friction)
        assert contact.impact is not None
        if contact not in self._impacts:
            self._impacts[contact] = self._impact(contact, contact.impact), self._impact(contact, CLOSING)
        return self._impacts[contact]

    @cached_property
    def _impacts(self) -> dict[Any, tuple[Reset, Reset]]:
        return {}

    def directions_of_impact(self, i: int, law: ImpactLaw) -> Array:
        """v+ - v- (1 or 2, n) by unit impulses of contact `i`: along the normal, and of friction if the law
        has any and it does not act along the normal."""
        along_normal, along_tangent = self._pushed_by_normals[:, i], self._pushed_by_tangents[:, i]
        normal, softness = self.normals[i], self._compliance[i, i]
        soft = softness + (normal @ along_tangent) ** 2 / (normal @ along_normal)
        both = has_friction(law) and soft > DEPENDENT * softness
        return np.array([along_normal, along_tangent] if both else [along_normal])

    def _impact(self, contact: Friction, law: ImpactLaw) -> Reset:
        """The reset by an impact law: an impulse along the normal, and one of friction if it has any."""
        i = self.mechanics.contacts.index(contact)
        along_normal, along_tangent = self._pushed_by_normals[:, i], self._pushed_by_tangents[:, i]
        normal = self.normals[i]
        (rate,) = matrix_rows(normal[None], self.v)
        softness = sympy.Float(-float(normal @ along_normal))
        impulse = law.impulse(rate, rate, softness)
        opening = rate_after(law, -rate, softness)
        order = 2 if opening == 0 else 1
        coupling = -float(normal @ along_tangent)
        share = coupling / float(softness)
        rubbing: Any = sympy.S.Zero
        if len(self.directions_of_impact(i, law)) > 1:
            sliding = contact.relative_velocity - coupling * impulse
            soft = float(self._compliance[i, i]) - coupling * share
            least = (sliding + share * opening) / soft
            rubbing = impulse_of_friction(law, impulse, sliding / soft, least, share)
        pressing = impulse - share * rubbing
        jump = {
            v: v + float(p) * pressing + float(r) * rubbing
            for v, p, r in zip(self.v, along_normal, along_tangent, strict=True)
            if p or (r and rubbing != 0)
        }
        landed = zeros_at_landing(contact, self.law_states(contact))
        return Reset(jump, {contact.penetration: order, -contact.penetration: order, **landed})

    @cached_property
    def directions(self) -> tuple[CommonDirection, ...]:
        """Contacts that rub along one direction, in groups."""
        groups: list[list[tuple[int, Any, Any]]] = []
        for i, row in enumerate(self.tangents):
            if not row.any() or self.of_laws[i]:
                continue
            for group in groups:
                first = self.tangents[group[0][0]]
                ratio = float(row @ first / (first @ first))
                if np.linalg.norm(row - ratio * first) <= PARALLEL * np.linalg.norm(row):
                    number = sympy.Integer(round(ratio)) if ratio in (1.0, -1.0) else sympy.Float(ratio)
                    offset = expand_products(self.belts[i] - number * self.belts[group[0][0]])
                    group.append((i, number, offset))
                    break
            else:
                groups.append([(i, sympy.S.One, sympy.S.Zero)])
        return tuple(CommonDirection(*zip(*group, strict=True)) for group in groups if len(group) > 1)

    def allows(self, combination: Combination) -> bool:
        """Whether contacts of one direction agree, and all velocities held at zero are independent."""
        if not self._states_agree(combination):
            return False
        held = [i for i, (stick, one) in enumerate(zip(self._sticks, combination)) if one == stick]
        if self.directions:
            names = self.names_of_regimes(combination)
            if not all(direction.allows(names) for direction in self.directions):
                return False
            held = [i for i in held if self.leader(i, names) == i]
        return self._are_independent(tuple(held))

    @cached_property
    def _sticks(self) -> tuple[int | None, ...]:
        """The number of the regime in which each contact sticks; None where it has none."""
        return tuple(next((j for j, one in enumerate(some) if one.held), None) for some in self.regimes)

    def _are_independent(self, held: tuple[int, ...]) -> bool:
        if held not in self._independences:
            self._independences[held] = _independent(self._compliance[np.ix_(held, held)])
        return self._independences[held]

    @cached_property
    def _independences(self) -> dict[tuple[int, ...], bool]:
        return {}

    def _choose(self, combination: Combination) -> tuple[ContactRegime, ...]:
        """The regimes; a contact whose v_r is zero where others stick is at its limit of stick."""
        chosen = self._regimes_in(combination)
        names = tuple(one.name for one in chosen)
        held = [i for i, one in enumerate(chosen) if one.held and self.leader(i, names) == i]
        for i, one in enumerate(chosen) if held else ():
            if one.resting is not None and self._rests(i, held):
                chosen[i] = one.resting
        return tuple(chosen)

    def _rests(self, i: int, held: list[int]) -> bool:
        """Whether v_r of contact `i` is zero where those of the contacts `held` are, which are independent.

        Where t_i = sum of c_j t_j over these, it is v_i - sum of c_j v_j, of the counterparts' speeds v.
        """
        if self._are_independent((*held, i)):
            return False
        shares = np.linalg.lstsq(self.tangents[held].T, self.tangents[i])[0]
        v, others = self.speeds[i], self.speeds[held]
        return bool(abs(v - shares @ others) <= SAME_SPEED * (abs(v) + np.abs(shares) @ np.abs(others)))


def _independent(compliance: Array) -> bool:
    """Whether forces of contacts with this compliance (held, held) can hold each its own velocity."""
    if len(compliance) < 2:
        return True
    size = np.sqrt(compliance.diagonal())
    return bool(np.linalg.eigvalsh(compliance / size[:, None] / size)[0] > DEPENDENT)
