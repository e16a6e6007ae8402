"""`fl.linearize`: the system linearised about steady sliding with inputs and outputs, x' = A x + B u and
y = C x + D u, and its frequency responses.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionlab.automaton import HybridAutomaton
from frictionlab.components.component import StructureKey
from frictionlab.hybrid.outputs import output_formulas
from frictionlab.lazy_names import sympy
from frictionlab.models.composition import parameter_unit
from frictionlab.models.mechanical.mechanical_model import MechanicalModel
from frictionlab.models.model import Model, ModelOrAutomaton, automaton_of
from frictionlab.models.symbols import parameter_symbols
from frictionlab.presentation import (
    Drawable,
    count,
    dataset,
    is_angle,
    output_unit,
    shorten,
    span,
    unit_of_state,
)
from frictionlab.stability.eigenproblems.eigenvalues import ComplexArray, damping_ratios, jacobian
from frictionlab.stability.equilibrium_points.equilibria import Equilibrium, equilibrium, equilibrium_problem
from frictionlab.stability.equilibrium_points.sliding import sliding_equations
from frictionlab.stability.equilibrium_points.steady_modes import first_mode_equilibria
from frictionlab.stability.equilibrium_problem import EquilibriumProblem
from frictionlab.tape.formulas import Formulas, formulas_of
from frictionlab.validation import (
    abbreviate,
    check_sequence,
    did_you_mean_or_known,
    float_array,
)

Array = NDArray[np.float64]
DRAWN_RANGE = 0.001, 1.3  # of frequencies in a picture, in units of the largest eigenvalue's
DRAWN_POINTS = 2000


@dataclass(frozen=True, eq=False)
class LinearSystem(Drawable):
    """x' = A x + B u and y = C x + D u, for small departures from an equilibrium.

    ``A, B, C, D = system`` gives the matrices, so ``control.ss(*system)`` of python-control takes them, and
    ``scipy.signal.StateSpace(*system)``.

    Parameters
    ----------
    A : array (m, m)
        The state matrix, whose eigenvalues are those of :func:`eigenvalues`, and zeros where cyclic
        coordinates turn: steady rotation does not care where it began.  A state that follows from others,
        such as the deflection of a Jenkins element that slips, is none of the system's.
    B : array (m, inputs)
    C : array (outputs, m)
    D : array (outputs, inputs)
    states, inputs, outputs : tuple of str
        Their names.
    equilibrium : Equilibrium
        Where the system was linearised.
    """

    drawn_by = "plot_frequency_response"
    instead_of_array = "write A, B, C, D = system"

    A: Array
    B: Array
    C: Array
    D: Array
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    equilibrium: Equilibrium

    def __iter__(self) -> Iterator[Array]:
        return iter((self.A, self.B, self.C, self.D))

    def __repr__(self) -> str:
        sizes = (
            count(len(self.states), "state"),
            f"from {shorten(self.inputs)}",
            f"to {shorten(self.outputs)}",
        )
        return f"LinearSystem({', '.join(sizes)})"

    @property
    def eigenvalues(self) -> ComplexArray:
        """The poles, 1/s, (m,)."""
        values: ComplexArray = np.linalg.eigvals(self.A).astype(complex)
        return values

    def gain_unit(self, output: str, input: str) -> str:
        """SI unit of the response of an output to an input; "" where it is not known."""
        model = self.equilibrium.model
        above = unit_of_state(model, output) if output in self.states else output_unit(output, model)
        if input in self.states:
            below = "N m" if is_angle(input) else "N"
        else:
            below = parameter_unit(model, input) if isinstance(model, Model) else ""
        below = f"({below})" if " " in below or "/" in below else below
        return f"{above}/{below}" if above and below else ""

    @property
    def damping_ratios(self) -> Array:
        """-Re/|lambda| of the poles, (m,)."""
        return damping_ratios(self.eigenvalues)

    def plot(self, ax: Any = None, **options: Any) -> Any:
        """Draw the response over a range in which all resonances lie; as :meth:`FrequencyResponse.plot`."""
        highest = float(np.abs(self.eigenvalues).max()) / (2 * np.pi) or 1.0
        at = highest * np.linspace(*DRAWN_RANGE, DRAWN_POINTS)
        return self.frequency_response(at).plot(ax, **options)

    def frequency_response(self, frequencies: Any) -> FrequencyResponse:
        """The response to inputs that oscillate: C (i omega - A)^-1 B + D.

        Parameters
        ----------
        frequencies : array_like (N,)
            Hz.

        Returns
        -------
        FrequencyResponse

        Raises
        ------
        ValueError
            For what is no list of finite numbers, or the frequency of an undamped mode, of which there is no
            response.

        Examples
        --------
        >>> import frictionlab as fl
        >>> response = fl.linearize(fl.ModeCoupling()).frequency_response([0.0, 0.1])
        >>> response.values.shape
        (2, 2, 2)
        """
        cure = "give frequencies in Hz, such as np.linspace(0, 40, 400)"
        at = float_array("frequencies", frequencies, cure, finite=True).ravel()
        unit = np.eye(len(self.A))
        shifted: Any = 2j * np.pi * at[:, None, None] * unit - self.A
        try:
            state_response: Any = np.linalg.solve(shifted, np.broadcast_to(self.B, (len(at), *self.B.shape)))
        except np.linalg.LinAlgError:
            raise ValueError(
                "frequencies must be others than those of undamped modes, where there is no response: "
                f"add damping, or leave them out of {abbreviate(frequencies)}"
            ) from None
        return FrequencyResponse(at, self.C @ state_response + self.D, self)


@dataclass(frozen=True, eq=False)
class FrequencyResponse(Drawable):
    """Complex amplitudes of outputs for inputs of amplitude 1.

    Parameters
    ----------
    frequencies : array (N,)
        Hz.
    values : complex array (N, outputs, inputs)
        Their units are those of the outputs, over those of the inputs.
    system : LinearSystem
    """

    drawn_by = "plot_frequency_response"
    several_axes = True
    instead_of_array = "write response.values"

    frequencies: Array
    values: ComplexArray
    system: LinearSystem

    def __repr__(self) -> str:
        at = f"at {count(len(self.frequencies), 'value')} of the frequency, {span(self.frequencies)} Hz"
        return (
            f"FrequencyResponse({at}, from {shorten(self.system.inputs)} to {shorten(self.system.outputs)})"
        )

    def response(self, output: str, input: str) -> ComplexArray:
        """The response (N,) of one output to one input, by their names."""
        i = _place("output", output, self.system.outputs)
        return self.values[:, i, _place("input", input, self.system.inputs)]

    def to_xarray(self) -> Any:
        """Gain and phase (rad) as an xarray Dataset (needs the extra ``data``), with the dimensions
        "frequency", "output" and "input"."""
        dimensions = ("frequency", "output", "input")
        variables = {
            "gain": (dimensions, np.abs(self.values)),
            "phase": (dimensions, np.angle(self.values)),
        }
        names = {"output": list(self.system.outputs), "input": list(self.system.inputs)}
        coordinates = {"frequency": self.frequencies, **names}
        return dataset(variables, coordinates, {"frequency": "Hz", "phase": "rad"})


def linearize(
    model: ModelOrAutomaton,
    inputs: Sequence[str] | None = None,
    outputs: Sequence[str] | None = None,
) -> LinearSystem:
    """The system linearised about its equilibrium of steady sliding, with inputs and outputs.

    Parameters
    ----------
    model : Model or HybridAutomaton
    inputs : sequence of str or None
        Coordinates, along which forces (N) or moments act; parameters, by which changes are meant.  None
        takes all coordinates, and all parameters of an automaton that comes from no mechanical model.
    outputs : sequence of str or None
        States, such as "x1" or "x1'", and outputs of the model, such as "normal_force".  None takes all
        coordinates, or all states where there are none.

    Returns
    -------
    LinearSystem

    Raises
    ------
    TypeError
        If `model` is neither a model nor an automaton.
    ValueError
        For an unknown name, and where :func:`eigenvalues` raises one.

    Examples
    --------
    >>> import frictionlab as fl
    >>> system = fl.linearize(fl.ModeCoupling(), outputs=["x", "normal_force"])
    >>> A, B, C, D = system
    >>> system
    LinearSystem(4 states, from x, y, to x, normal_force)
    """
    automaton, point = automaton_of(model).whole, equilibrium(model)
    problem, (mode, given_by_others) = equilibrium_problem(model), _mode_of_equilibrium(model)
    coordinates = tuple(model.coordinates) if isinstance(model, MechanicalModel) else ()
    states = tuple(automaton.state_names)
    input_names = _names("inputs", inputs, coordinates or problem.parameter_names)
    output_names = _names("outputs", outputs, states[: automaton.coordinates] or states)
    for name in input_names:
        _place("inputs", name, [*coordinates, *problem.parameter_names])
    for name in output_names:
        _place("outputs", name, [*states, *automaton.outputs])
    A: Any = jacobian(model, point.state)
    forces = ForceResponse(np.zeros((0, 0)), {})
    if isinstance(model, MechanicalModel) and not {*input_names}.isdisjoint(coordinates):
        forces = _force_response(model, mode, point.state)
    moved: dict[str, Array] = dict(zip(coordinates, forces.accelerations.T))
    B = _input_matrix(problem, moved, point.state, input_names)
    C: Any = np.zeros((len(output_names), len(states)))
    D: Any = np.zeros((len(output_names), len(input_names)))
    for row, name in enumerate(output_names):
        slopes = _slopes_of_output(automaton, mode, name, point.state)
        C[row] = [slopes.get(state, 0.0) for state in states]
        by_force = forces.outputs.get(name, np.zeros(len(coordinates)))
        direct = slopes | dict(zip(coordinates, by_force.tolist(), strict=True))
        D[row] = [direct.get(one, 0.0) for one in input_names]
    for name in automaton.cyclic:  # there measured from others that turn with it; here each by itself
        place = states.index(name)
        A[place], B[place] = np.eye(len(states))[automaton.coordinates + place], 0.0
    for place in given_by_others:  # its row says z' = (what it is) - z, and no other rate depends on it
        B[place, [name in coordinates for name in input_names]] = 0.0
        C, D = (
            C + np.outer(C[:, place], A[place] + np.eye(len(states))[place]),
            D + np.outer(C[:, place], B[place]),
        )
        C[:, place] = 0.0
    free = [place for place in range(len(states)) if place not in given_by_others]
    names = tuple(states[place] for place in free)
    return LinearSystem(
        A[np.ix_(free, free)], B[free], C[:, free], D, names, input_names, output_names, point
    )


def _input_matrix(
    problem: EquilibriumProblem, moved: Mapping[str, Array], state: Array, inputs: Sequence[str]
) -> Array:
    """B (m, inputs): accelerations by forces along coordinates, `moved`, and rates by parameters."""
    matrix = np.zeros((len(state), len(inputs)))
    by_parameter = problem.flow.by_parameter.at(state, problem.values)
    for k, name in enumerate(inputs):
        if name in moved:
            matrix[len(moved) : 2 * len(moved), k] = moved[name]
        else:
            matrix[:, k] = by_parameter[:, problem.parameter_names.index(name)]
    return matrix


def _slopes_of_output(automaton: HybridAutomaton, mode: str, name: str, state: Array) -> dict[str, float]:
    """Derivatives of a state or an output by the states and the parameters, by their names."""
    if name in automaton.state_names:
        return {name: 1.0}
    places, entries = output_formulas(automaton, mode, name).jacobian()
    inputs = [*automaton.state_names, *automaton.values]
    numbers = entries.numbers(*state, *automaton.values.values())
    return {inputs[column]: number for (_, column), number in zip(places, numbers.tolist(), strict=True)}


def _mode_of_equilibrium(model: ModelOrAutomaton) -> tuple[str, list[int]]:
    """The mode of the equilibrium, and the places of states that follow from others, such as a deflection at
    its limit."""
    automaton = automaton_of(model).whole
    equations = sliding_equations(model)
    if equations is not None:
        if "slip" in automaton.names:
            return "slip", []
        speed = equations.belt_speed.arrays(*equilibrium_problem(model).values)[0]
        return "slip+" if speed > 0 else "slip-", []
    mode, *_ = first_mode_equilibria(automaton, isinstance(model, Model))
    cyclic = {automaton.state_names.index(name) for name in automaton.cyclic}
    return mode.name, [place for place in mode.following if place not in cyclic]


class ForceResponse(NamedTuple):
    """Derivatives by forces along the coordinates: of accelerations (n, n); of outputs (n,), by their names,
    where contacts hold, as what these do follows the forces."""

    accelerations: Array
    outputs: Mapping[str, Array]


def _force_response(model: MechanicalModel, mode: str, state: Array) -> ForceResponse:
    names, formulas = _force_formulas(model.structure_key, mode)
    values = [model.parameters[name] for name in model.structure_key.parameters]
    pushes = np.zeros(len(model.coordinates))
    rows: Any = formulas.numbers(*state, *values, *pushes).reshape(-1, len(pushes))
    if not names:
        return ForceResponse(np.linalg.inv(rows), {})
    split = len(rows) - len(names)
    return ForceResponse(rows[:split], dict(zip(names, rows[split:], strict=True)))


@cache
def _force_formulas(key: StructureKey, mode: str) -> tuple[list[str], Formulas]:
    """The outputs of a mode in which contacts hold, and the derivatives by forces of the accelerations and of
    these; of other modes no outputs, and the masses."""
    from frictionlab.models.mechanical.equations_of_motion import system_of  # which load sympy
    from frictionlab.models.mechanical.modes import contact_outputs, solve_contact_forces

    system = system_of(key)
    pushes = [sympy.Dummy(f"push {name}", real=True) for name in system.q]
    inputs = [*system.states, *parameter_symbols(key), *pushes]
    regimes = system.chosen(system.names.combination_of(mode) or ())
    if not any(one.force is None or one.by_holding is not None for one in regimes):
        return [], formulas_of(inputs, list(system.mass))
    loads = tuple(load + push for load, push in zip(system.loads, pushes, strict=True))
    forces = solve_contact_forces(replace(system, loads=loads), regimes)
    outputs = contact_outputs(system, regimes, forces)
    slopes = [sympy.diff(one, push) for one in (*forces.accelerations, *outputs.values()) for push in pushes]
    return [*outputs], formulas_of(inputs, slopes)


def _names(what: str, names: Any, usual: Sequence[str]) -> tuple[str, ...]:
    if names is None:
        return tuple(usual)
    return check_sequence(what, [names] if isinstance(names, str) else names, 'write ["x1"]')


def _place(what: str, name: Any, names: Sequence[str]) -> int:
    if not isinstance(name, str) or name not in names:
        raise ValueError(f"{what} must be known, got {abbreviate(name)}{did_you_mean_or_known(name, names)}")
    return list(names).index(name)
