"""Equilibria of models with one contact: the static equations of sliding, K q = f + W_N F_N + W_T F_T.

sympy solves them for q at a given penetration.  The penetration determines F_N, that determines F_T, and both
determine q.  What remains is one scalar equation: the penetration of that q is the given one.

With polynomial laws the equation is a polynomial in the penetration.  Its roots are eigenvalues, and are
polished by Newton's method on the original equation.  With other laws bounds of the equation and of its slope
tell where roots are, for all values of the parameters at once (`root_boxes`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache, cached_property, lru_cache, partial, reduce
from math import factorial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionlab.components.component import StructureKey
from frictionlab.lazy_names import sympy
from frictionlab.models import Model
from frictionlab.models.kept_structures import Derivations, derivations_of
from frictionlab.models.model import ModelOrAutomaton
from frictionlab.models.symbolic_laws import check_laws, symbolic_copy
from frictionlab.models.symbols import parameter_symbols
from frictionlab.stability.equilibrium_points.borders import distances_from_borders
from frictionlab.stability.equilibrium_points.newton import find_zeros, follow_zero
from frictionlab.stability.equilibrium_points.root_boxes import (
    LARGEST,
    SMALLEST,
    Boxes,
    isolate_zeros,
    one_equation,
    values_of,
)
from frictionlab.stability.equilibrium_problem import EquilibriumProblem
from frictionlab.stability.flow import Flow
from frictionlab.stability.state_matrices import MACHINE_EPSILON
from frictionlab.tape.formulas import Formulas, formulas_of, kept_formulas
from frictionlab.tape.intervals import Interval, interval

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
REAL_ROOT_RTOL = 1e-4  # a double root comes out of the eigenvalues as a pair, some 1e-8 off the real axis
TERM_ROUNDING = 64 * MACHINE_EPSILON  # share of a polynomial's terms that is rounding of their sum
SUBNORMAL_ROUNDING = 64 * float(np.finfo(float).smallest_subnormal)  # the same where terms are that small
SAME_ROOT_RTOL = 1e-8  # of a root: rounding parts a double root so far
STATIC_RESIDUAL_RTOL = 1e-9  # share of the largest force: roots with a larger residual are none
NEWTON_STEPS, STEPS_TO_MULTIPLE_ROOTS = 4, 64
MOST_HALVINGS = 200  # from 1e30 to 1e-30


class Statics(NamedTuple):
    """Functions of the penetration, then of all parameters.

    Parameters
    ----------
    coordinates : Formulas
        q (n,), from all equations but the scalar one.
    forces : Formulas
        F_N and F_T, N.
    balance : Formulas
        The static equations (n,) as functions of q and the parameters, and the terms that tell their size.
    equation : Flow
        The scalar equation, as a flow whose one state is the penetration: zero at that of an equilibrium.
    tangent : Formulas
        The left side of the scalar equation, and its derivative by the penetration if that is not zero.
    derivatives : Formulas
        Of a polynomial: the left side of the scalar equation and all its derivatives by the penetration.
        Without outputs where a law is no polynomial.
    """

    coordinates: Formulas
    forces: Formulas
    balance: Formulas
    equation: Flow
    tangent: Formulas
    derivatives: Formulas

    def excess(self, penetration: Any, values: Sequence[Any]) -> Any:
        """The left side of the scalar equation."""
        return self.equation.rates.arrays(penetration, *values)[0]

    def polynomial(self, values: Sequence[Any], count: int = 1) -> Array | None:
        """The coefficients (degree + 1, count) of the left side as a polynomial in the penetration.

        They are its derivatives at zero over factorials.  With Eq. (2) the degree is at most 9.  None where a
        law is no polynomial.
        """
        if not self.derivatives.outputs:
            return None
        coefficients = np.empty((len(self.derivatives.outputs), count))
        for k, row in enumerate(self.derivatives.arrays(0.0, *values)):
            coefficients[k] = row / factorial(k)
        return coefficients

    def excess_and_slope(self, penetration: Any, values: Sequence[Any]) -> tuple[Any, Any]:
        """The left side of the scalar equation, and its derivative by the penetration."""
        excess, *slopes = self.tangent.arrays(penetration, *values)
        return excess, sum(slopes)  # one, or none

    def normal_force(self, penetration: Any, values: Sequence[Any]) -> Any:
        """F_N, N."""
        return self.forces.arrays(penetration, *values)[0]

    def is_static(
        self, penetration: Any, normal: Any, q: Sequence[Any], values: Sequence[Any], tolerance: float
    ) -> tuple[Array, Any]:
        """The largest residual force, relative to the largest force, and where it is small enough.

        Small enough is below the tolerance.  If a law is steep, it is below what the last digits of the
        penetration do.  If these do too much, the equations cannot be solved in double precision.
        """
        n, forces = len(q), list(map(np.abs, self.balance.arrays(*q, *values)))
        residual = reduce(np.maximum, forces[:n]) / reduce(np.maximum, forces[n:], SMALLEST_FORCE)
        if not (residual >= tolerance).any():
            return residual, residual < tolerance
        with np.errstate(all="ignore"):
            ahead = self.normal_force(np.nextafter(penetration, np.inf), values)
            _, slope = self.excess_and_slope(penetration, values)
            last_digit = np.abs((ahead - normal) / normal) * np.fmax(np.abs(slope), 1.0)
        return residual, residual < np.fmax(tolerance, np.fmin(LAST_DIGITS * last_digit, MOST_LAST_DIGIT))


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
        values = model.parameters
        check_laws(self.key, values)
        return tuple(values[name] for name in self.key.parameters)

    @cached_property
    def sticks(self) -> bool:
        """Whether the contact can stick."""
        return self.derivations.value("sticks", lambda: "stick" in self.system.rubbing.modes)

    @cached_property
    def belt_speed(self) -> Formulas:
        """The relative velocity at rest (m/s), a function of the parameters."""
        return self._of_parameters(
            "belt speed", lambda: [self.system.at_rest(self.system.rubbing.relative_velocity)]
        )

    @cached_property
    def stiffness(self) -> Formulas:
        """The entries of K, row by row, functions of the parameters."""
        return self._of_parameters("stiffness", lambda: list(self.system.stiffness))

    @cached_property
    def springs(self) -> list[int]:
        """Places of the parameters on which K depends."""
        return sorted(frozenset().union(*self.stiffness.dependences))

    def rests(self, values: Sequence[Any]) -> Any:
        """Where the belt rests and the contact can stick: there friction has no derivative."""
        return (np.asarray(self.belt_speed.arrays(*values)[0]) == 0) & self.sticks

    def _of_parameters(self, name: str, expressions: Callable[[], Sequence[Any]]) -> Formulas:
        return kept_formulas(self.derivations, name, lambda: formulas_of(self.parameters, expressions()))

    def _of_states(self, name: str, expressions: Callable[[], Sequence[Any]]) -> Formulas:
        def derive() -> Formulas:
            return formulas_of([*self.system.states, *self.parameters], expressions())

        return kept_formulas(self.derivations, name, derive)

    @cached_property
    def flow(self) -> Flow:
        """The flow of slip, friction in the sign of the belt's speed, whatever the model's other modes."""
        rates = self._of_states("rates of sliding", lambda: _rates_of_slip(self.system))
        margins = self._of_states("margins of sliding", lambda: [self.system.rubbing.pressing])
        return Flow(self.key.parameters, rates, margins)

    def guards(self, values: Sequence[float]) -> Formulas:
        """The functions that stay positive while the model slides as in the flow: +-v_r, the penetration."""
        forwards = bool(self.belt_speed.arrays(*values)[0] > 0)
        name = f"guards of sliding {'forwards' if forwards else 'backwards'}"
        return self._of_states(name, lambda: _guards_of_slip(self.system, forwards))

    def stiffness_at(self, values: Sequence[Any]) -> Array:
        """K (n, n), or (N, n, n) where a parameter in it is an array."""
        stacked = np.stack(np.broadcast_arrays(*self.stiffness.arrays(*values)), axis=-1).astype(float)
        return stacked.reshape(*stacked.shape[:-1], *[len(self.coordinates)] * 2)

    def on_springs(self, held_by_contact: bool) -> list[int]:
        """Indices of the coordinates that springs must hold; the contact may hold the height."""
        return [i for i in range(len(self.coordinates)) if not (held_by_contact and i == self.height)]


def sliding_equations(model: ModelOrAutomaton) -> SlidingEquations | None:
    """The equations of steady sliding of a model's structure; None of models without `statics`, and of those
    whose laws have states of their own: their equilibria do not follow from the penetration of a contact."""
    if not isinstance(model, Model) or model.statics is None:
        return None
    if any(getattr(component, "states", ()) for component in model.components.values()):
        return None
    return _equations_of_structure(model.structure_key)


@cache
def _equations_of_structure(key: StructureKey) -> SlidingEquations:
    derivations = derivations_of(key)
    names = tuple(derivations.value("coordinates", lambda: symbolic_copy(key).coordinates))
    return SlidingEquations(key, derivations, names, names.index(key.component.statics.height))


def _rates_of_slip(system: LagrangeSystem) -> tuple[Any, ...]:
    from frictionlab.models.mechanical.contact_regimes import regime  # which load sympy
    from frictionlab.models.mechanical.modes import solve_contact_forces

    slip = regime(system.rubbing, "slip", system)
    return system.flow(solve_contact_forces(system, (slip,)).accelerations)


def _guards_of_slip(system: LagrangeSystem, forwards: bool) -> list[Any]:
    from frictionlab.models.mechanical.contact_regimes import regime  # which loads sympy

    contact = system.rubbing
    name = "slip" if "slip" in contact.modes else "slip+" if forwards else "slip-"
    slip = regime(contact, name, system)
    borders = distances_from_borders(system.states, _rates_of_slip(system))
    return [*(end.function for end in slip.ends(slip.force, slip.limit)), *borders]


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
            lambda: _static_formulas(equations, held_by_contact)[name],
        )

    excess = formulas("excess")
    equation = Flow(tuple(equations.key.parameters), excess, Formulas(excess.tape, ()))
    slope = equation.derivative.formulas  # on the same tape, with more operations
    tangent = Formulas(slope.tape, (*excess.outputs, *slope.outputs))
    derivatives = kept_formulas(
        equations.derivations, f"derivatives of the excess{suffix}", lambda: _derivatives(excess)
    )
    functions = formulas("coordinates"), formulas("forces"), formulas("residual")
    return Statics(*functions, equation, tangent, derivatives)


def _derivatives(function: Formulas) -> Formulas:
    """A polynomial in the first input and its derivatives, up to the last that is not zero everywhere.

    Without outputs where the function is no polynomial.
    """
    slots: tuple[int, ...] = ()
    last, places = function, [(0, 0)] if function.is_polynomial_in(0) else []
    while places:
        slots += last.outputs
        places, last = last.jacobian([0])  # on the same tape, with more operations
    return Formulas(last.tape, slots)


@cache
def _static_formulas(equations: SlidingEquations, held_by_contact: bool) -> dict[str, Formulas]:
    system, p = equations.system, equations.parameters
    height = equations.height if held_by_contact else None
    penetration, normal, friction = sympy.symbols("compression normal friction", real=True)
    forces = dict(zip((normal, friction), _forces(system, penetration), strict=True))
    # Laws are put in at the end: their exponential functions are not to be taken apart.
    q = _deflections(system, height, normal, friction)
    excess = system.rubbing.penetration.xreplace(dict(zip(system.q, q, strict=True))) - penetration
    if height is not None:
        # The slider's height enters the penetration with the factor -1.
        q[height] = excess
        excess = _loads(system, q, normal, friction)[height]
    if not (excess.has(normal) and excess.xreplace(forces).is_polynomial(penetration)):
        excess = _by_horner(excess, normal, friction, _friction(system, normal) / normal, penetration)
    arguments = [penetration, *p]
    return {
        "coordinates": formulas_of(arguments, [each.xreplace(forces) for each in q]),
        "excess": formulas_of(arguments, [excess.xreplace(forces)]),
        "forces": formulas_of(arguments, [*forces.values()]),
        "residual": formulas_of([*system.q, *p], _balance(system)),
    }


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


def statics_at(equations: SlidingEquations, values: Sequence[float]) -> Statics:
    """The statics that apply at single values of the parameters.

    Raises
    ------
    ValueError
        If coordinates other than the slider's height are not held by the structure.
    """
    return _statics_of_springs(equations, tuple(map(values.__getitem__, equations.springs)))


@lru_cache(maxsize=64)
def _statics_of_springs(equations: SlidingEquations, springs: tuple[float, ...]) -> Statics:
    known = dict(zip(equations.springs, springs, strict=True))
    stiffness = equations.stiffness_at([known.get(i, 0.0) for i in range(len(equations.key.parameters))])
    held_by_contact = not stiffness[:, equations.height].any()
    some = equations.on_springs(held_by_contact)
    value, vector = _smallest_eigenvalue(stiffness[np.ix_(some, some)])
    if value <= SINGULAR_EIGENVALUE:
        loose = [equations.coordinates[i] for i, part in zip(some, vector) if abs(part) > LOOSE_SHARE]
        raise ValueError(
            f"no static equilibrium can be computed: the springs do not hold {', '.join(loose)} "
            "(singular stiffness matrix); give the springs there a positive stiffness"
        )
    return derive_statics(equations, held_by_contact)


def statics_groups(
    equations: SlidingEquations, values: Sequence[Any], count: int
) -> Iterator[tuple[Statics, NDArray[np.bool_], Sequence[Any]]]:
    """The statics that apply at some of `count` parameter values: at which, and the values there.

    If a coordinate is not held at a value, none applies there.

    Raises
    ------
    ValueError
        If a coordinate is not held whatever the values.
    """
    springs = tuple(map(values.__getitem__, equations.springs))
    if not any(map(np.ndim, springs)):
        yield _statics_of_springs(equations, springs), np.ones(count, dtype=bool), values
        return
    stiffness = equations.stiffness_at(values)
    without = ~stiffness[:, :, equations.height].any(axis=1)
    for held_by_contact in (False, True):
        some = equations.on_springs(held_by_contact)
        firm = _smallest_eigenvalue(stiffness[:, some][:, :, some])[0] > SINGULAR_EIGENVALUE
        if (group := firm & (without == held_by_contact)).any():
            there = [v if np.ndim(v) == 0 else np.broadcast_to(v, (count,))[group] for v in values]
            yield derive_statics(equations, held_by_contact), group, there


def _smallest_eigenvalue(stiffness: Array) -> tuple[Any, Any]:
    """Smallest eigenvalue of matrices (..., n, n) whose diagonals are scaled to 1, and its vector."""
    size = np.sqrt(np.einsum("...ii->...i", stiffness))
    size[size == 0] = 1.0
    values, vectors = np.linalg.eigh(stiffness / (size[..., :, None] * size[..., None, :]))
    return values[..., 0], vectors[..., 0]


def _least_penetration(statics: Statics, values: Sequence[Any], count: int) -> Array:
    """Penetrations (count,) in m; NaN where there is no equilibrium with F_N > 0."""
    excess = statics.polynomial(values, count)
    with np.errstate(all="ignore"):
        if excess is not None:
            return _least_pressed(statics, values, _polynomial_candidates(statics, values, excess))
        arrays = [v if np.ndim(v) == 0 else np.broadcast_to(v, (count,)) for v in values]
        search = PenetrationSearch(statics, arrays, count)
        candidates, settled_at = search.candidates(np.arange(count), search.is_pressed)
        least = _least_pressed(statics, values, candidates)
        # If the root that settled the search is no equilibrium to rounding, all roots are looked for.
        again = np.flatnonzero(np.isfinite(settled_at) & ~(least <= settled_at))
        if len(again):
            candidates, _ = search.candidates(again)
            least = np.fmin(least, _least_pressed(statics, values, candidates))
        return least


def _least_pressed(statics: Statics, values: Sequence[Any], penetrations: Array) -> Array:
    """The least (N,) of candidates (k, N) that are static with F_N > 0; NaN where there is none."""
    q, normal = statics.coordinates.arrays(penetrations, *values), statics.normal_force(penetrations, values)
    _, balanced = statics.is_static(penetrations, normal, q, values, STATIC_RESIDUAL_RTOL)
    pressed = balanced & (penetrations > 0) & (normal > 0)
    least = np.where(pressed, penetrations, np.inf).min(axis=0)
    return np.where(np.isfinite(least), least, np.nan)


def _polynomial_candidates(statics: Statics, values: Sequence[Any], excess: Array) -> Array:
    """Nearly real roots (k, N), polished by Newton's method on the original equation."""
    roots = _companion_roots(excess)
    real = np.abs(roots.imag) <= REAL_ROOT_RTOL * np.abs(roots.real)
    pressed = (roots.real > 0) & (statics.normal_force(roots.real, values) > 0)
    penetrations = np.sort(np.where(real & pressed, roots.real, np.nan), axis=0)
    penetrations = penetrations[: int(np.isfinite(penetrations).sum(axis=0).max(initial=1))]  # NaN comes last
    return _polish_roots(statics, values, penetrations)


def _polish_roots(
    statics: Statics, values: Sequence[Any], penetrations: Array, most: int = NEWTON_STEPS
) -> Array:
    """Newton's method on the original equation, which does not suffer from cancellation as the polynomial
    does."""
    excess, slope = statics.excess_and_slope(penetrations, values)
    for _ in range(most):
        trial = penetrations - excess / slope
        rest, slope_there = statics.excess_and_slope(trial, values)
        better = np.abs(rest) < np.abs(excess)
        if not better.any():  # nor would the next step change anything
            break
        penetrations, excess = np.where(better, trial, penetrations), np.where(better, rest, excess)
        slope = np.where(better, slope_there, slope)
    return penetrations


def _companion_roots(coefficients: Array) -> NDArray[np.complex128]:
    """All roots (degree, N).  Their reciprocals are eigenvalues, so a leading coefficient may vanish."""
    degree = len(coefficients) - 1
    # Without a preload the penetration is a factor: it is divided out, which leaves the other roots.
    coefficients = np.where(coefficients[0] == 0, np.roll(coefficients, -1, axis=0), coefficients)
    companion = np.zeros((coefficients.shape[1], degree, degree))
    companion[:, range(1, degree), range(degree - 1)] = 1.0
    with np.errstate(all="ignore"):
        # In units of the penetration without contact force, which is the constant term.
        scale = np.abs(coefficients[0]) ** np.arange(1, degree + 1)[:, None]
        companion[:, 0] = -(coefficients[1:] * scale / coefficients[0]).T
        broken = ~np.isfinite(companion[:, 0]).all(axis=1)
        companion[broken] = np.eye(degree)
        roots = np.abs(coefficients[0]) / np.linalg.eigvals(companion).astype(complex).T
    roots[:, broken] = np.nan
    return roots


class PenetrationSearch(NamedTuple):
    """A search for the roots of an equation that is no polynomial, at `count` values of the parameters.

    Those that are arrays have that length.
    """

    statics: Statics
    values: Sequence[Any]
    count: int

    def is_pressed(self, boxes: Boxes) -> NDArray[np.bool_]:
        """Which boxes are of positive penetrations with F_N > 0."""
        at, values = Interval(*boxes.ends[:, 0]), values_of(boxes.owners, self.values)
        return (boxes.ends[0, 0] > 0) & (interval(self.statics.normal_force(at, values)).low > 0)

    def candidates(
        self, owners: NDArray[np.intp], settles: Callable[[Boxes], NDArray[np.bool_]] | None = None
    ) -> tuple[Array, Array]:
        """Positive roots (k, count), NaN in columns with fewer than k, and above which penetration none was
        looked for, for some of the values."""
        # Of most laws one box ends at the penetration without contact force, and holds the only root.
        free = np.abs(self.statics.excess(np.zeros(len(owners)), values_of(owners, self.values)))
        free = np.where((free > SMALLEST) & (free < LARGEST), free, 1.0)
        from_zero = np.stack([np.full(len(owners), SMALLEST), free])
        upwards = np.stack([free, np.full(len(owners), LARGEST)])
        boxes = Boxes(np.hstack([from_zero, upwards])[:, None], np.tile(owners, 2))
        equation = one_equation(self.statics.equation, self.values)
        search = isolate_zeros(equation, boxes, settles)
        low, high = (_columns(end[0], search.single.owners, self.count) for end in search.single.ends)
        roots = _enclosed_roots(self.statics, self.values, low, high)
        for i in np.unique(np.append(search.narrow.owners, search.undecided.owners)):
            points = find_zeros(self.statics.equation, list(map(float, values_of(i, self.values)))).points[0]
            roots = np.vstack([roots, _columns(points, np.full(len(points), i), self.count)])
        # Without preload zero is a root, up to rounding: there is no contact.
        no_contact = _is_without_contact(self.statics, self.values, roots)
        return np.where(no_contact, np.nan, roots), search.settled_at


def _is_without_contact(statics: Statics, values: Sequence[Any], roots: Array) -> Any:
    """Which roots are zero up to rounding of the equation, so that there is no contact."""
    zero = interval(statics.excess(interval(np.zeros(())), values)).contains_zero()
    around = interval(statics.excess(interval(roots), values))
    _, slope = statics.excess_and_slope(np.zeros_like(roots), values)
    return zero & (np.abs(roots) <= (around.high - around.low) / np.abs(slope))


def _enclosed_roots(statics: Statics, values: Sequence[Any], low: Array, high: Array) -> Array:
    """The one root in each interval, by Newton's method, or by halving if a step leads out."""
    rises = statics.excess(high, values) > 0
    x = (low + high) / 2
    for _ in range(MOST_HALVINGS):
        excess, slope = statics.excess_and_slope(x, values)
        below = (excess > 0) != rises
        low, high = np.where(below, x, low), np.where(below, high, x)
        step = x - excess / slope
        inside = (step > low) & (step < high)
        after = np.where(excess == 0, x, np.where(inside, step, (low + high) / 2))
        still = np.abs(after - x) <= MACHINE_EPSILON * np.abs(x)
        x = after
        if (still | np.isnan(x)).all():
            break
    return x


def _columns(numbers: Array, owners: Any, count: int) -> Array:
    """The numbers of each owner as a column of (k, count), filled up with NaN."""
    order = np.argsort(owners, kind="stable")
    numbers, owners = numbers[order], owners[order]
    row = np.arange(len(owners)) - np.searchsorted(owners, owners)
    table = np.full((1 + row.max(initial=0), count), np.nan)
    table[row, owners] = numbers
    return table


def all_penetrations(statics: Statics, values: Sequence[float]) -> tuple[list[float], str]:
    """The penetrations at all equilibria, and why others are not excluded, if so."""
    excess = statics.polynomial(values)
    if excess is None:
        zeros = find_zeros(statics.equation, values)
        with np.errstate(all="ignore"):
            none = _is_without_contact(statics, values, zeros.points[0])
        return sorted(map(float, np.where(none, 0.0, zeros.points[0]))), zeros.why
    with np.errstate(all="ignore"):  # at a double root the slope vanishes
        return _real_roots(statics, values, excess), ""


def _real_roots(statics: Statics, values: Sequence[float], excess: Array) -> list[float]:
    """All real roots of the polynomial in ascending order, each once.

    A double root comes out of the eigenvalues as a pair off the real axis.  So a root is one at which the
    polynomial is zero up to rounding of its terms.
    """
    roots = _companion_roots(excess)[:, 0]
    near = roots.real[np.abs(roots.imag) <= REAL_ROOT_RTOL * np.abs(roots.real)]
    near = np.append(near, 0.0) if excess[0, 0] == 0.0 else near
    near = _polish_roots(statics, values, near, STEPS_TO_MULTIPLE_ROOTS)
    terms = excess * near ** np.arange(len(excess))[:, None]
    rounding = TERM_ROUNDING * np.abs(terms).sum(axis=0) + SUBNORMAL_ROUNDING
    zero = np.abs(terms.sum(axis=0)) <= rounding
    distinct: list[float] = []
    for root in np.sort(near[zero]).tolist():
        if not distinct or root - distinct[-1] > SAME_ROOT_RTOL * abs(root):
            distinct.append(root)
    return distinct


def sliding_problem(model: Model, equations: SlidingEquations, start: Array | None) -> EquilibriumProblem:
    """Steady sliding of a model at the equilibrium with F_N > 0 and the smallest penetration.

    With `start` (2n,) it is the equilibrium at this state, followed from there.
    """
    values, flow = equations.values(model), equations.flow

    def is_pressed(x: Array, values: Sequence[Any]) -> Any:
        return (flow.margin(x, values) > 0) & ~equations.rests(values)

    return EquilibriumProblem(
        model,
        equations.coordinates,
        equations.key.parameters,
        values,
        partial(_states, equations)
        if start is None
        else partial(follow_zero, flow, start, values, is_pressed),
        flow,
        lambda: equations.guards(values),
    )


def _states(equations: SlidingEquations, values: Sequence[Any], count: int) -> Array:
    """States (2n, count) at the smallest penetration; NaN where there is no equilibrium."""
    x = np.full((2 * len(equations.coordinates), count), np.nan)
    for statics, group, there in statics_groups(equations, values, count):
        penetrations = _least_penetration(statics, there, int(group.sum()))
        x[:, group] = np.where(np.isnan(penetrations), np.nan, 0.0)
        for row, q in zip(x, statics.coordinates.arrays(penetrations, *there)):
            row[group] = np.where(np.isnan(penetrations), np.nan, q)
    x[:, np.broadcast_to(equations.rests(values), (count,))] = np.nan
    return x
