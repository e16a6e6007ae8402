"""`fl.hopf`: how vibration begins where a flutter instability sets in, by the normal form of the Hopf point.

It is w' = (i omega + slope (p - p0)) w + cubic w |w|^2, x = x0 + 2 Re(w q).  Derivatives along directions
are formulas made of the flow's formulas, once for a flow.  Yu. A. Kuznetsov, "Elements of Applied
Bifurcation Theory", 3rd ed., Springer, 2004; also Scholarpedia 1(10) (2006) 1858.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionlab.models.model import ModelOrAutomaton, MovingSystem, check_varied
from frictionlab.presentation import Drawable
from frictionlab.stability.equilibrium_points.equilibria import (
    Equilibrium,
    equilibrium_branches,
    equilibrium_problem,
)
from frictionlab.stability.equilibrium_problem import EquilibriumProblem, check_bounds, check_masses_of
from frictionlab.stability.flow import EquilibriumDerivatives
from frictionlab.stability.state_matrices import (
    Eigenpair,
    eigenpair,
    eigenvalues_of_matrices,
    growth_scales,
)
from frictionlab.tape.formulas import Formulas
from frictionlab.validation import float_array

from .stability_changes import StabilityChange, StabilityKind, changes_on_lines

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
ZERO_RTOL = 1e-9  # what is below this share of its terms, or of the largest eigenvalue, counts as zero
# Eigenvalues nearer to each other than this share count as one: rounding separates a double one so far.
DOUBLE_EIGENVALUE_RTOL = 1e-6
SAME_VALUE_RTOL = 1e-9  # share of the value or the range: two points so close belong to symmetric equilibria


def critical_pair(matrix: Array, frequency: float) -> Eigenpair | None:
    """The pair of that frequency (Hz); None if it is double, or another mode neither grows nor decays."""
    values = eigenvalues_of_matrices(matrix[None])[0]
    k = int(np.argmin(np.abs(values - 2j * np.pi * frequency)))
    partner = int(np.argmin(np.abs(values - values[k].conjugate())))
    others: Any = np.delete(np.arange(len(values)), [k, partner])
    neutral = np.abs(values[others].real) < ZERO_RTOL * growth_scales(values)[others]
    distance = np.abs(values[others] - values[k]).min(initial=np.inf)
    if neutral.any() or distance < DOUBLE_EIGENVALUE_RTOL * abs(values[k]):
        return None
    return eigenpair(matrix, complex(values[k])).normalised


def cubic_coefficient(at: EquilibriumDerivatives, pair: Eigenpair) -> complex:
    """The coefficient of w |w|^2; its real part is exactly zero where it is zero to rounding."""
    rates, omega, q, p = at.flow.rates, pair.value.imag, pair.right, pair.left
    shift = -np.linalg.solve(at.matrix, at.along(rates, q, q.conj()))
    second = np.linalg.solve(2j * omega * np.eye(len(q)) - at.matrix, at.along(rates, q, q))
    terms = [
        at.along(rates, q, q, q.conj()),
        2 * at.along(rates, q, shift),
        at.along(rates, q.conj(), second),
    ]
    coefficient = 0.5 * complex(p @ sum(terms))
    size = 0.5 * float(sum(np.abs(p) @ np.abs(term) for term in terms))
    return coefficient if abs(coefficient.real) > ZERO_RTOL * size else complex(0.0, coefficient.imag)


@dataclass(frozen=True, eq=False)
class HopfPoint(Drawable):
    """A value of a parameter at which flutter sets in or ends, and the cycle born there.

    Near it the state is x0 + 2 Re(w q) with
    w' = (i omega + `slope` (p - `value`)) w + `cubic` w |w|^2.

    Parameters
    ----------
    model : Model or HybridAutomaton
    parameter : str
    change : StabilityChange
        Where it is: value, frequency, direction, numbers of growing modes below and above.
    coordinates : tuple of str
        Names of the n coordinates, or of all states of an automaton that has none.
    state : array (m,)
        The equilibrium x0.
    vector : complex array (m,)
        The critical eigenvector q, of length 1 in the units of the states: coordinates, then velocities.
    slope : complex
        d(eigenvalue)/d(parameter), 1/s per unit of the parameter.
    cubic : complex
        1/s; depends on the length of q.
    reach : float
        |w| at which v_r or the penetration on the cycle first becomes zero, to leading order; inf if never.
    """

    drawn_by = "plot_hopf"

    model: ModelOrAutomaton
    parameter: str
    change: StabilityChange
    coordinates: tuple[str, ...]
    state: Array
    vector: ComplexArray
    slope: complex
    cubic: complex
    reach: float

    @property
    def value(self) -> float:
        """The parameter's value."""
        return self.change.value

    @property
    def frequency(self) -> float:
        """Of the critical mode, Hz."""
        return self.change.frequency

    @property
    def crossing_speed(self) -> float:
        """d(growth rate)/d(parameter); negative where the equilibrium regains stability."""
        return self.slope.real

    @property
    def first_lyapunov(self) -> float:
        """Kuznetsov's first Lyapunov coefficient, Re(cubic)/omega for an eigenvector of length 1.

        Its sign is the same in all units of the states; its size is not.
        """
        return self.cubic.real / (2 * np.pi * self.frequency)

    @property
    def criticality(self) -> str:
        """Either "supercritical" or "subcritical"; "degenerate" where the coefficient is zero to rounding."""
        return {-1.0: "supercritical", 1.0: "subcritical"}.get(float(np.sign(self.cubic.real)), "degenerate")

    @property
    def shape(self) -> ComplexArray:
        """The critical mode (n,): the coordinates, the largest of them 1."""
        part = self.vector[: len(self.coordinates)]
        return part / part[np.abs(part).argmax()]

    @property
    def valid_until(self) -> float:
        """The parameter's value at which the predicted cycle first reaches stick or separation.

        Infinite if the model has neither; NaN if degenerate.  Beyond it the cycle of the smooth flow is not
        one of the model, and what there is instead has to be simulated.
        """
        rate = self.cubic.real / self.slope.real
        return float(self.value - rate * self.reach**2) if rate else float("nan")

    def __repr__(self) -> str:
        where = f"{self.criticality} at {self.parameter} = {self.value:.6g}, {self.frequency:.4g} Hz"
        return f"HopfPoint({where}, {self.change.direction} of stability, valid until {self.valid_until:.6g})"

    def amplitude(self, value: Any) -> Array:
        """Amplitudes of the coordinates on the cycle near the critical value, to leading order.

        They are those of the first harmonic, half peak to peak while the cycle is small.  Their error, as a
        share of the largest, falls in proportion to the distance from the critical value.

        Parameters
        ----------
        value : float or array_like (...)
            The parameter's.

        Returns
        -------
        array (..., n)
            m and rad; NaN where there is no such cycle, and if degenerate.
        """
        return 2 * np.sqrt(self._square(value))[..., None] * np.abs(self.vector[: len(self.coordinates)])

    def cycle_frequency(self, value: Any) -> Any:
        """Frequency (...) of the cycle, Hz, to first order in the distance; NaN where there is none.

        Parameters
        ----------
        value : float or array_like (...)
            The parameter's.
        """
        distance = float_array("value", value, f"give values of {self.parameter}") - self.value
        shift = self.slope.imag * distance + self.cubic.imag * self._square(value)
        return self.frequency + shift / (2 * np.pi)

    def _square(self, value: Any) -> Array:
        """|w|^2 of the cycle."""
        distance = float_array("value", value, f"give values of {self.parameter}") - self.value
        rate = -self.slope.real / self.cubic.real if self.cubic.real else float("nan")
        return np.where(rate * distance >= 0, rate * distance, np.nan)


def hopf(
    model: ModelOrAutomaton, parameter: str, bounds: Any, *, equilibrium: Equilibrium | None = None
) -> HopfPoint:
    """The first point in a range where flutter sets in or ends, and the kind of vibration that begins there.

    It is the first on any of the equilibria that exist in the range, wherever they begin and end; `state`
    tells on which.

    The eigenvalues say where steady sliding loses its stability, not what follows.  That is decided by the
    second and third derivatives of the flow, through the first Lyapunov coefficient

        l1 = Re<p, C(q, q, q*) - 2 B(q, A^-1 B(q, q*)) + B(q*, (2i omega - A)^-1 B(q, q))> / (2 omega)

    of the Jacobian A, its vectors A q = i omega q and A^T p = -i omega p with <q, q> = <p, q> = 1, and the
    multilinear forms B and C of the derivatives.  Yu. A. Kuznetsov, "Elements of Applied Bifurcation
    Theory", 3rd ed., Springer, 2004.

    * **Supercritical** (l1 < 0): on the unstable side there is a stable vibration whose amplitude grows from
      zero like the square root of the distance.  Where the eigenvalues promise rest, small disturbances die
      out and no vibration is near: the complex eigenvalue analysis can be trusted.
    * **Subcritical** (l1 > 0): on the *stable* side there is an unstable vibration, smaller the nearer the
      critical value is.  A disturbance beyond it grows, so that vibration can begin before the critical
      value; past it the amplitude jumps.  The complex eigenvalue analysis is not on the safe side.
    * **Degenerate** (l1 = 0): the smooth flow does not decide, as in a linear scene; stick and separation
      alone limit the amplitude.

    All this holds for smooth sliding and small vibrations.  Where the cycle reaches stick or separation it
    ends (`valid_until`), and stick-slip may exist beside a stable equilibrium whatever the sign of l1.  If
    other modes grow at the point (`change.unstable`), so do disturbances of the cycle in either case.

    Parameters
    ----------
    model : Model or HybridAutomaton
    parameter : str
    bounds : (float, float)
        Narrow them to reach a later point.
    equilibrium : Equilibrium, optional
        One of ``equilibria(model)``, to follow it alone.  By default all that are found at 9 values in the
        range are followed; of a SliderOnBelt only the one with F_N > 0 and the smallest penetration.

    Returns
    -------
    HopfPoint

    Raises
    ------
    ValueError
        If there is no such point in the range, or it is double (undamped modes that coalesce); and as
        :func:`stability_changes`.

    Examples
    --------
    >>> import frictionlab as fl
    >>> point = fl.hopf(fl.SliderOnBelt(), "mu_k", bounds=(0, 4))
    >>> point.criticality
    'subcritical'
    """
    if isinstance(model, MovingSystem):
        check_varied(model, parameter)
    low, high = check_bounds(model, parameter, bounds)
    check_masses_of(model, {parameter: (low, high)})
    if equilibrium is None:
        problems = equilibrium_branches(model, parameter, (low, high))
    else:
        problems = [equilibrium_problem(model, equilibrium)]
    candidates = [
        (change, problem)
        for problem in [each for each in problems if not each.holds_all] or problems
        for change in changes_on_lines(problem, parameter, (low, high), {})[0]
    ]
    flutter = [pair for pair in candidates if pair[0].kind == StabilityKind.FLUTTER]
    if not flutter:
        changes = sorted((change for change, _ in candidates), key=lambda change: change.value)
        raise ValueError(_no_hopf_message(parameter, bounds, changes))
    first = min(change.value for change, _ in flutter)
    # Of symmetric equilibria always take the same one, whatever the rounding of their points.
    alike = first + SAME_VALUE_RTOL * max(abs(first), high - low)
    change, problem = next(pair for pair in flutter if pair[0].value <= alike)
    return _hopf_point(problem, parameter, change)


def _no_hopf_message(parameter: str, bounds: Any, changes: Sequence[StabilityChange]) -> str:
    words = ", ".join(f"{c.kind} at {c.value:.6g}" for c in changes) or "no change of stability"
    return (
        f"the bounds of {parameter} must enclose a point where flutter sets in or ends, got {words} "
        f"in {tuple(bounds)}: widen them, or see stability_changes and eigenvalues"
    )


def _hopf_point(problem: EquilibriumProblem, parameter: str, change: StabilityChange) -> HopfPoint:
    motion = _critical_motion(problem, parameter, change.value, change.frequency)
    if motion is None:
        raise ValueError(
            f"one pair of eigenvalues must cross the imaginary axis at {parameter} = {change.value:.9g}, "
            "got two that coalesce, or others without growth or decay: give every mode some damping"
        )
    at, pair = motion
    slope = complex(at.bilinear(pair.left, pair.right)[problem.parameter_names.index(parameter)])
    cubic = cubic_coefficient(at, pair)
    # What is above ZERO_RTOL of its terms may still be zero at the point itself, which is known to rounding.
    near = ZERO_RTOL * abs(pair.value) / abs(slope) if slope else 0.0
    beside = [
        _critical_motion(problem, parameter, change.value + step, change.frequency) for step in (-near, near)
    ]
    signs = {np.sign(cubic_coefficient(*one).real) for one in beside if one is not None}
    if len(signs) == 2:
        cubic = complex(0.0, cubic.imag)
    return HopfPoint(
        problem.model,
        parameter,
        change,
        problem.names,
        at.x,
        pair.right,
        slope,
        cubic,
        _amplitude_at_guard(at, problem.derive_guards(), pair.right),
    )


def _critical_motion(
    problem: EquilibriumProblem, parameter: str, value: float, frequency: float
) -> tuple[EquilibriumDerivatives, Eigenpair] | None:
    """The equilibrium at a value, and its pair of that frequency (Hz); None where it has none of its own."""
    states, matrices = problem.linearised({parameter: value})
    state, matrix = states[:, 0], matrices[0]
    pair = critical_pair(problem.without_following(matrix), frequency) if np.isfinite(matrix).all() else None
    if pair is None:
        return None
    left = problem.with_following(pair.left[:, None])[:, 0]
    right = problem.with_following(pair.right[:, None], matrix)[:, 0]
    values = {**problem.parameters, parameter: value}
    at = EquilibriumDerivatives(problem.flow, state, tuple(values.values()))
    return at, Eigenpair(pair.value, left, right, complex(left @ right)).normalised


def _amplitude_at_guard(at: EquilibriumDerivatives, guards: Formulas, vector: ComplexArray) -> float:
    """The least |w| at which a guard becomes zero on x0 + 2 Re(w q), to leading order."""
    swings = 2 * np.abs(at.along(guards, vector))
    levels = at.along(guards)
    return min((level / swing for level, swing in zip(levels, swings) if swing > 0), default=float("inf"))
