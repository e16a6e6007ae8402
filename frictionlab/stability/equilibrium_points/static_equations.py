"""The static equations of sliding, K q = f + W_N F_N + W_T F_T, solved by sympy for q at a given penetration.

The penetration determines F_N, that determines F_T, and both determine q.  What remains is one scalar
equation: the penetration of that q is the given one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import TYPE_CHECKING, Any, NamedTuple, TypeGuard

import numpy as np
from numpy.typing import NDArray

from frictionlab.components.component import StructureKey
from frictionlab.lazy_names import sympy
from frictionlab.models import Model
from frictionlab.models.model import ModelOrAutomaton
from frictionlab.models.serialisation import Derivations, derivations_of
from frictionlab.models.symbols import check_laws, parameter_symbols, symbolic_copy
from frictionlab.stability.flow import Flow
from frictionlab.tape.formulas import Formulas, formulas_of, kept_formulas

if TYPE_CHECKING:
    from frictionlab.models.mechanical.equations_of_motion import LagrangeSystem

Array = NDArray[np.float64]
# A stiffness matrix scaled to a unit diagonal counts as singular if an eigenvalue is smaller than this.
SINGULAR_EIGENVALUE = 1e-13
# N: parts of smaller forces may be subnormal numbers, which lose digits.
SMALLEST_FORCE = float(np.finfo(float).tiny / np.finfo(float).eps)
LAST_DIGITS = 16.0  # of a penetration: what rounding may make of it
# Share of the largest force: if the last digit of a penetration changes forces by more, they are not known.
MOST_LAST_DIGIT = 0.1
LOOSE_SHARE = 0.1  # a coordinate with this share of a unit vector moves in a motion that no spring resists


class Statics(NamedTuple):
    """Functions of the penetration, then of all parameters.  Inputs are numbers or arrays; laws that are
    polynomials also take polynomials.

    Parameters
    ----------
    coordinates : callable
        q as a list (n,), from all equations but the scalar one.
    forces : callable
        F_N and F_T, N.
    residual : callable of (*q, *parameters)
        The static equations (n,), and the terms in them that tell their size.
    equation : Flow
        The scalar equation, as a flow whose one state is the penetration: zero at that of an equilibrium.
    """

    coordinates: Callable[..., Any]
    forces: Callable[..., Any]
    residual: Callable[..., Any]
    equation: Flow

    def excess(self, penetration: Any, values: Sequence[Any]) -> Any:
        """The left side of the scalar equation; with polynomial laws it takes a polynomial and gives one."""
        return self.equation.bounds([penetration], values)[0]

    def slope(self, penetration: Any, values: Sequence[Any]) -> Any:
        """Its derivative by the penetration."""
        return self.equation.jacobian([penetration], values)[..., 0, 0]


@dataclass(frozen=True, eq=False)
class SlidingEquations:
    """The equations of steady sliding of one structure, derived once for all computations.

    Parameters
    ----------
    key : StructureKey
    derivations : Derivations
        What is cached on disk of it.
    coordinates : tuple of str
    height : int
        Index of the coordinate that the contact alone may hold.
    """

    key: StructureKey
    derivations: Derivations
    coordinates: tuple[str, ...]
    height: int

    @cached_property
    def system(self) -> LagrangeSystem:
        """Lagrange's equations."""
        from frictionlab.models.mechanical.equations_of_motion import system_of  # which derives them

        return system_of(self.key)

    @cached_property
    def parameters(self) -> tuple[Any, ...]:
        """The parameters' symbols."""
        return parameter_symbols(self.key)

    def values(self, model: Model) -> tuple[float, ...]:
        """The model's parameters, in the order of `parameters`; ValueError where a law has no value there."""
        known = model.parameters
        check_laws(self.key, known)
        return tuple(known[name] for name in self.key.parameters)

    @cached_property
    def sticks(self) -> bool:
        """Whether the contact can stick."""
        return self.derivations.value("sticks", lambda: "stick" in self.system.rubbing.modes)

    def belt_speed(self, *values: Any) -> Any:
        """The relative velocity at rest (m/s) at values of the parameters."""
        return self._of_parameters(
            "belt speed", lambda: [self.system.at_rest(self.system.rubbing.relative_velocity)]
        ).arrays(*values)[0]

    def rests(self, values: Sequence[Any]) -> Any:
        """Where the belt rests and the contact can stick: there friction has no derivative."""
        return (np.asarray(self.belt_speed(*values)) == 0) & self.sticks

    def _of_parameters(self, name: str, expressions: Callable[[], Sequence[Any]]) -> Formulas:
        return kept_formulas(self.derivations, name, lambda: formulas_of(self.parameters, expressions()))

    def formulas_of_states(self, expressions: Sequence[Any]) -> Formulas:
        """Formulas of the states, then the parameters."""
        return formulas_of([*self.system.states, *self.parameters], expressions)

    def stiffness(self, values: Sequence[Any]) -> Array:
        """K (n, n), or (N, n, n) where a parameter in it is an array."""
        entries = self._of_parameters("stiffness", lambda: list(self.system.stiffness))
        stacked = np.stack(np.broadcast_arrays(*entries.arrays(*values)), axis=-1).astype(float)
        return stacked.reshape(*stacked.shape[:-1], *[len(self.coordinates)] * 2)

    def held(self, by_contact: bool) -> list[int]:
        """Indices of the coordinates that springs must hold; `by_contact`: the contact holds the height."""
        return [i for i in range(len(self.coordinates)) if not (by_contact and i == self.height)]


def sliding_equations(model: Model) -> SlidingEquations:
    """The equations of steady sliding of a model's structure."""
    return _equations_of_structure(model.structure_key)


@cache
def _equations_of_structure(key: StructureKey) -> SlidingEquations:
    derivations = derivations_of(key, key.parameters)
    names = tuple(derivations.value("coordinates", lambda: symbolic_copy(key).coordinates))
    return SlidingEquations(key, derivations, names, names.index(key.component.statics.height))


def by_penetration(model: ModelOrAutomaton) -> TypeGuard[Model]:
    """Whether a model's equilibria follow from the penetration of its contact."""
    return isinstance(model, Model) and model.statics is not None


@cache
def derive_statics(equations: SlidingEquations, held_by_contact: bool) -> Statics:
    """The statics of a structure.

    With `held_by_contact` only the contact holds the slider's height, and no spring does.
    """
    suffix = ", held by the contact" if held_by_contact else ""

    def formulas(name: str) -> Formulas:
        return kept_formulas(
            equations.derivations,
            f"{name}{suffix}",
            lambda: getattr(_static_formulas(equations, held_by_contact), name),
        )

    excess = formulas("excess")
    return Statics(
        formulas("coordinates").arrays,
        formulas("forces").arrays,
        formulas("residual").arrays,
        Flow(tuple(equations.key.parameters), excess, Formulas(excess.tape, ())),
    )


class StaticFormulas(NamedTuple):
    """What :class:`Statics` are made of."""

    coordinates: Formulas
    excess: Formulas
    forces: Formulas
    residual: Formulas


@cache
def _static_formulas(equations: SlidingEquations, held_by_contact: bool) -> StaticFormulas:
    system, p = equations.system, equations.parameters
    height = equations.height if held_by_contact else None
    penetration, normal, friction = sympy.symbols("compression normal friction", real=True)
    forces = dict(zip((normal, friction), _forces(system, penetration), strict=True))
    # Laws are put in at the end: their exponential functions are not to be taken apart.
    q = _deflections(system, height, normal, friction)
    excess = _penetration(system, q) - penetration
    if height is not None:
        # The slider's height enters the penetration with the factor -1.
        q[height] = excess
        excess = _loads(system, q, normal, friction)[height]
    if not (excess.has(normal) and excess.xreplace(forces).is_polynomial(penetration)):
        excess = _by_horner(excess, normal, friction, _friction(system, normal) / normal, penetration)
    arguments = [penetration, *p]
    return StaticFormulas(
        formulas_of(arguments, [each.xreplace(forces) for each in q]),
        formulas_of(arguments, [excess.xreplace(forces)]),
        formulas_of(arguments, [*forces.values()]),
        formulas_of([*system.q, *p], _balance(system)),
    )


def _by_horner(excess: Any, normal: Any, friction: Any, ratio: Any, penetration: Any) -> Any:
    """The scalar equation times its denominator, by Horner's rule.

    So its bounds are narrow, and have a sign even if forces are beyond floats.  F_T is `ratio` times F_N.
    """
    above, below = sympy.fraction(sympy.together(excess))
    unit = sympy.Poly(below, normal, friction).coeff_monomial(1) or sympy.S.One
    unknowns = [normal, friction, penetration]
    if ratio.has(normal):
        return _nested(above, unknowns, unit)
    # F_T = mu F_N: all is a polynomial in F_N.
    return _nested(sympy.expand(above.xreplace({friction: friction * normal})), unknowns, unit).xreplace(
        {friction: ratio}
    )


def _nested(polynomial: Any, unknowns: Sequence[Any], unit: Any) -> Any:
    """A polynomial by Horner's rule, its coefficients in terms of the unit."""
    if not unknowns:
        return sympy.factor(polynomial / unit)
    total = sympy.S.Zero
    for coefficient in sympy.Poly(polynomial, unknowns[0]).all_coeffs():
        total = total * unknowns[0] + _nested(coefficient, unknowns[1:], unit)
    return total


def _forces(system: LagrangeSystem, penetration: Any) -> tuple[Any, Any]:
    """F_N, Eq. (2), and F_T while sliding at the belt's speed, Eq. (3)."""
    contact: Any = system.rubbing  # F_N is a function of the penetration
    normal = contact.normal_force(penetration)
    return normal, _friction(system, normal)


def _friction(system: LagrangeSystem, normal: Any) -> Any:
    """F_T while sliding at the belt's speed, Eq. (3)."""
    contact: Any = system.rubbing
    speed = system.at_rest(contact.relative_velocity)
    return sympy.sign(speed) * contact.law.kinetic(normal, abs(speed))


def _penetration(system: LagrangeSystem, q: Sequence[Any]) -> Any:
    return system.rubbing.penetration.xreplace(dict(zip(system.q, q, strict=True)))


def _deflections(
    system: LagrangeSystem, held_by_contact: int | None, normal: Any, friction: Any
) -> list[Any]:
    q, passes = [sympy.S.Zero] * len(system.q), 2
    stiffness, lever = system.stiffness, system.normal(system.rubbing).jacobian(system.q)
    flexibility = _flexibility(stiffness, held_by_contact)
    # With the paper's W_N the lever depends on coordinates that its moment does not move: two passes suffice.
    if not (flexibility * lever * flexibility * lever).is_zero_matrix:
        flexibility, passes = _flexibility(stiffness - normal * lever, held_by_contact), 1
    for _ in range(passes):
        q = list(flexibility * sympy.Matrix(_loads(system, q, normal, friction)))
    return q


def _loads(system: LagrangeSystem, q: Sequence[Any], normal: Any, friction: Any) -> list[Any]:
    at = dict(zip(system.q, q, strict=True))
    rows = zip(
        system.dead_loads, system.normal(system.rubbing), system.direction(system.rubbing), strict=True
    )
    return [f + w.xreplace(at) * normal + t.xreplace(at) * friction for f, w, t in rows]


def _flexibility(stiffness: Any, held_by_contact: int | None) -> Any:
    """Inverse of K, block by block, with zeros for the coordinate that the contact alone holds."""
    inverse = sympy.zeros(*stiffness.shape)
    for block in sympy.SparseMatrix(stiffness).connected_components():
        held = [i for i in block if i != held_by_contact]
        if held:
            part = stiffness.extract(held, held)
            inverse_part = part.adjugate() / sympy.factor(part.det())
            for row, i in enumerate(held):
                for column, j in enumerate(held):
                    inverse[i, j] = inverse_part[row, column]
    return inverse


def _balance(system: LagrangeSystem) -> list[Any]:
    elastic = list(system.stiffness * sympy.Matrix(system.q))
    normal, friction = _forces(system, system.rubbing.penetration)
    rows = zip(_loads(system, system.q, normal, friction), elastic, strict=True)
    return [*(load - held for load, held in rows), *elastic, *system.dead_loads, normal]


def static_residual(statics: Statics, q: Sequence[Any], values: Sequence[Any]) -> Array:
    """Largest residual force at `q`, relative to the largest force in the equations."""
    n = len(q)
    rows = np.abs(np.stack(np.broadcast_arrays(*statics.residual(*q, *values), np.zeros(np.shape(q[0])))))
    return rows[:n].max(axis=0) / np.maximum(rows[n:].max(axis=0), SMALLEST_FORCE)


def is_static(
    statics: Statics, penetration: Any, q: Sequence[Any], values: Sequence[Any], tolerance: float
) -> tuple[Array, Any]:
    """The residual of :func:`static_residual`, and where it is small enough.

    Small enough is below the tolerance.  If a law is steep, it is below what the last digits of the
    penetration do.  If these do too much, the equations cannot be solved in double precision.
    """
    residual = static_residual(statics, q, values)
    with np.errstate(all="ignore"):
        normal, ahead = (
            statics.forces(d, *values)[0] for d in (penetration, np.nextafter(penetration, np.inf))
        )
        last_digit = np.abs((ahead - normal) / normal) * np.fmax(
            np.abs(statics.slope(penetration, values)), 1.0
        )
    return residual, residual < np.fmax(tolerance, np.fmin(LAST_DIGITS * last_digit, MOST_LAST_DIGIT))


def statics_for_values(equations: SlidingEquations, values: Sequence[float]) -> Statics:
    """The statics that apply at the values of the parameters.

    Raises
    ------
    ValueError
        If coordinates other than the slider's height are not held by the structure.
    """
    stiffness = equations.stiffness(values)
    held_by_contact = not stiffness[:, equations.height].any()
    held = equations.held(held_by_contact)
    _refuse_singular(stiffness[np.ix_(held, held)], [equations.coordinates[i] for i in held])
    return derive_statics(equations, held_by_contact)


def statics_groups(
    equations: SlidingEquations, values: Sequence[Any], count: int
) -> Iterator[tuple[Statics, Any]]:
    """The statics that apply at some of `count` parameter values, each with booleans that say at which.

    If a coordinate is not held at a value, none applies there.

    Raises
    ------
    ValueError
        If a coordinate is not held whatever the values.
    """
    stiffness = equations.stiffness(values)
    if stiffness.ndim == 2:
        yield statics_for_values(equations, values), np.ones(count, dtype=bool)
        return
    without = ~stiffness[:, :, equations.height].any(axis=1)
    for held_by_contact in (False, True):
        held = equations.held(held_by_contact)
        firm = _smallest_eigenvalue(stiffness[:, held][:, :, held])[0] > SINGULAR_EIGENVALUE
        if (chosen := firm & (without == held_by_contact)).any():
            yield derive_statics(equations, held_by_contact), chosen


def _smallest_eigenvalue(stiffness: Array) -> tuple[Any, Any]:
    """Smallest eigenvalue of matrices (..., n, n) whose diagonals are scaled to 1, and its vector."""
    size = np.sqrt(np.einsum("...ii->...i", stiffness))
    size[size == 0] = 1.0
    values, vectors = np.linalg.eigh(stiffness / (size[..., :, None] * size[..., None, :]))
    return values[..., 0], vectors[..., 0]


def _refuse_singular(stiffness: Array, names: Sequence[str]) -> None:
    value, vector = _smallest_eigenvalue(stiffness)
    if value > SINGULAR_EIGENVALUE:
        return
    loose = [name for name, part in zip(names, vector, strict=True) if abs(part) > LOOSE_SHARE]
    raise ValueError(
        f"no static equilibrium can be computed: the springs do not hold {', '.join(loose)} "
        "(singular stiffness matrix); give the springs there a positive stiffness"
    )
