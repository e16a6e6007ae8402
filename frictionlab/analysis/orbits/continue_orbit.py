"""`fl.continue_orbit`: a periodic orbit followed through a parameter, around folds, stable or not."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from frictionlab.analysis.motion_scales import Array
from frictionlab.analysis.orbits.branches import (
    INTERRUPTED,
    MAX_POINTS,
    BranchHalf,
    SpecialKind,
    follow_branch,
)
from frictionlab.analysis.orbits.periodic_orbit import (
    PeriodicOrbit,
    mode_to_state,
    orbit_of_run,
    transverse_multipliers,
)
from frictionlab.analysis.orbits.pseudo_arclength import (
    BranchPoint,
    first_point,
    reversed_point,
    with_parameter_as_state,
)
from frictionlab.hybrid.solve import solve
from frictionlab.interruption import interruption, progress_bar
from frictionlab.models.composition import parameter_unit
from frictionlab.models.model import ModelOrAutomaton, automaton_of, check_varied
from frictionlab.presentation import Drawable, dataframe, shorten
from frictionlab.validation import abbreviate, check_flag, check_limits, check_number


@dataclass(frozen=True, eq=False)
class SpecialOrbit:
    """A special point of a branch.

    Parameters
    ----------
    kind : str
        "fold", "period doubling", "Neimark-Sacker"; "grazing", where a stay that interrupts a mode
        appears or vanishes; "mode change", any other change of the sequence of modes; "Hopf", where the orbit
        shrinks to an equilibrium within the bounds.
    value : float
        Value of the parameter.
    orbit : PeriodicOrbit
        The orbit there; for "grazing", "mode change" and "Hopf" the last one before.  The value of "Hopf" is
        extrapolated to zero amplitude.
    """

    kind: SpecialKind
    value: float
    orbit: PeriodicOrbit

    def __repr__(self) -> str:
        return f"SpecialOrbit({self.kind} at {self.value:.6g}, period {self.orbit.period:.6g} s)"


@dataclass(frozen=True, eq=False)
class OrbitBranch(Drawable):
    """A branch of periodic orbits.

    Parameters
    ----------
    parameter : str
    values : array (N,)
        The parameter along the branch: it turns back at folds.
    orbits : tuple of PeriodicOrbit
    special : tuple of SpecialOrbit
        In their order along the branch.
    ends : (str, str)
        Why the branch ends at its first and at its last orbit: "bound", "grazing", "mode change", "Hopf",
        "no orbit found", "most orbits" or "interrupted".
    """

    drawn_by = "plot_orbit_branch"

    parameter: str
    values: Array
    orbits: tuple[PeriodicOrbit, ...]
    special: tuple[SpecialOrbit, ...]
    ends: tuple[str, str]

    @property
    def periods(self) -> Array:
        """Periods (N,), s."""
        return np.array([orbit.period for orbit in self.orbits])

    @property
    def frequencies(self) -> Array:
        """1/period (N,), Hz."""
        return 1.0 / self.periods

    def amplitudes(self, name: str) -> Array:
        """Half the range of a coordinate along each orbit (N,), m or rad.

        Raises
        ------
        ValueError
            For what is no coordinate.
        """
        from frictionlab.analysis.quantities.orbit_quantities import amplitude_along

        return np.array([amplitude_along(orbit, name) for orbit in self.orbits])

    @property
    def multipliers(self) -> Array:
        """Floquet multipliers (N, n), the largest first."""
        return np.array([orbit.multipliers for orbit in self.orbits])

    @property
    def stable(self) -> np.ndarray:
        """Whether each orbit is stable (N,)."""
        return np.array([orbit.stable for orbit in self.orbits])

    def to_dataframe(self) -> Any:
        """One row for each orbit, as a pandas DataFrame (needs the extra ``data``).

        Columns: period, frequency, stability, and the size of the largest multiplier but for that along the
        orbit.
        """
        columns: dict[str, Any] = {"period": self.periods, "frequency": self.frequencies}
        columns |= {"stability": [orbit.stability for orbit in self.orbits]}
        others = np.abs([transverse_multipliers(orbit.multipliers) for orbit in self.orbits])
        columns |= {"largest_multiplier": others.max(axis=1, initial=0.0)}
        units = {"period": "s", "frequency": "Hz"}
        units |= {self.parameter: parameter_unit(self.orbits[0].model, self.parameter)}
        return dataframe(columns, {self.parameter: self.values}, units)

    def __repr__(self) -> str:
        special = shorten(f"{s.kind} at {s.value:.6g}" for s in self.special) or "nothing special"
        low, high = self.values.min(), self.values.max()
        return f"OrbitBranch({self.parameter} {low:.6g} to {high:.6g}, {len(self.orbits)} orbits, {special})"


def continue_orbit(
    orbit: PeriodicOrbit,
    parameter: str,
    bounds: tuple[float, float],
    *,
    step: float = 0.1,
    max_points: int = 400,
    progress: bool = True,
) -> OrbitBranch:
    """Follow a periodic orbit through a parameter, by pseudo-arclength continuation.

    The branch is followed both ways from the orbit, to the bounds or to where it ends.  The derivative by the
    parameter is that of the tangent flow, with the parameter as an additional state.  Folds are located where
    the parameter turns back, period doublings and Neimark-Sacker points by the multipliers, changes of the
    sequence of modes by halving the step until both sides meet.  Source: Seydel, Practical Bifurcation and
    Stability Analysis (2010).

    Parameters
    ----------
    orbit : PeriodicOrbit
    parameter : str
        A parameter of its model, on which the structure of the equations must not depend.
    bounds : (float, float)
        Smallest and largest value of the parameter.
    step : float
        Longest step, in the norm of all unknowns: the state by the motion's size, the period by its own, the
        parameter by the distance of the bounds.
    max_points : int
        Largest number of orbits in each direction.
    progress : bool
        Show a progress bar where it takes more than a second.

    Returns
    -------
    OrbitBranch

    Raises
    ------
    TypeError
        For an unknown parameter, or where `orbit` is no PeriodicOrbit.
    ValueError
        For other bad arguments, and for an orbit of a family at one value of the parameter.  All errors but
        the last are raised before any orbit is computed.
    KeyboardInterrupt
        After ctrl-C; :func:`partial_result` then returns the OrbitBranch with the orbits found so far, whose
        `ends` say which side was interrupted.

    Examples
    --------
    >>> import frictionlab as fl
    >>> model = fl.SliderOnBelt(mu_k=1.4).without("geometry")
    >>> orbit = fl.periodic_orbit(model, fl.simulate(model, 30.0))
    >>> branch = fl.continue_orbit(orbit, "mu_k", (1.3, 1.5))
    >>> branch.ends, bool(branch.stable.all())
    (('bound', 'bound'), True)
    """
    check_flag("progress", progress)
    value = _check(orbit, parameter, bounds, step, max_points)
    automaton = with_parameter_as_state(automaton_of(orbit.model), parameter)
    state, mode = np.append(orbit.state, value), mode_to_state(orbit.trajectory, 0.0)
    start = first_point(automaton, state, orbit.period, bounds[1] - bounds[0], mode)
    halves = []
    for point in (reversed_point(start), start):
        half = BranchHalf([], [], MAX_POINTS)
        try:
            for now in _with_progress_bar(
                follow_branch(automaton, point, bounds, step, max_points), bounds, progress
            ):
                half = now
        except KeyboardInterrupt:
            halves.append(half._replace(end=INTERRUPTED))
            break
        halves.append(half)
    if len(halves) < 2:
        halves.append(BranchHalf([], [], INTERRUPTED))
    back, ahead = halves
    points = [*back.points[::-1], start, *ahead.points]
    special = [*back.special[::-1], *ahead.special]
    branch = OrbitBranch(
        parameter=parameter,
        values=np.array([point.value for point in points]),
        orbits=tuple(_orbit_at(orbit.model, parameter, point) for point in points),
        special=tuple(
            SpecialOrbit(each.kind, each.value, _orbit_at(orbit.model, parameter, each.point))
            for each in special
        ),
        ends=(back.end, ahead.end),
    )
    if INTERRUPTED in branch.ends:
        raise interruption(f"the branch was stopped after {len(points)} orbits", branch)
    return branch


def _check(orbit: Any, parameter: str, bounds: Any, step: float, max_points: int) -> float:
    """Check the arguments, and return the parameter's value at the orbit."""
    if not isinstance(orbit, PeriodicOrbit):
        raise TypeError(
            f"orbit must be a PeriodicOrbit, got {abbreviate(orbit)}: find one with fl.periodic_orbit"
        )
    check_varied(orbit.model, parameter)
    value = automaton_of(orbit.model).values[parameter]
    low, high = check_limits("bounds", bounds, "give (low, high)")
    check_number("bounds[0]", low, most=value, cure=f"the orbit is at {parameter} = {value:g}")
    check_number("bounds[1]", high, least=value, above=low, cure=f"the orbit is at {parameter} = {value:g}")
    for bound in bounds:
        try:
            orbit.model.replace(**{parameter: bound})
        except ValueError as error:
            raise ValueError(
                f"bounds must be values that {parameter} can have, got {bound:g}: {error}"
            ) from error
    check_number("step", step, above=0.0, cure="0.1 is usual")
    check_number(
        "max_points", max_points, integer=True, least=1, cure="give the number of orbits to stop after"
    )
    return value


def _with_progress_bar(
    halves: Iterator[BranchHalf], bounds: tuple[float, float], progress: bool
) -> Iterator[BranchHalf]:
    bar = progress_bar(halves, desc="continue orbit", unit=" orbits", shown=progress)
    for half in bar:
        if half.points:
            at = f"{half.points[-1].value:.4g} in {bounds[0]:.4g} to {bounds[1]:.4g}"
            bar.set_postfix_str(at, refresh=False)  # else the bar would be shown before its time
        yield half


def _orbit_at(model: ModelOrAutomaton, parameter: str, point: BranchPoint) -> PeriodicOrbit:
    """The periodic orbit of a branch point, for the model with the parameter's value there."""
    here = model.replace(**{parameter: point.value})
    start = point.shot.run.raw.step_states[0][:-1]
    begins = mode_to_state(point.shot.run, 0.0)
    run = solve(automaton_of(here), point.period, x0=start, mode=begins, progress=False)
    return orbit_of_run(here, run, point.monodromy.copy(), point.shot.residual)
