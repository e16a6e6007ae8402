"""`fl.energy_audit`: where the energy of a run comes from, where it is, and where it goes.

The balance has energies, powers, and jumps at impacts, each evaluated at the states of the run.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import sympy as sp

from frictionlab.analysis.motion_scales import Array
from frictionlab.automaton import HybridAutomaton
from frictionlab.automaton.mode import JOINT
from frictionlab.hybrid.expression_functions import array_function
from frictionlab.hybrid.problem import evaluate_output
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.interruption import progress_bar
from frictionlab.models import MechanicalModel
from frictionlab.models.mechanical.contact_regimes import CHATTER_MODE
from frictionlab.models.mechanical.equations_of_motion import LagrangeSystem, system_of
from frictionlab.models.mechanical.mechanics import Friction
from frictionlab.models.mechanical.modes import contact_suffix
from frictionlab.models.symbols import Structure, parameter_symbols, structure_of_component, structure_values
from frictionlab.presentation import Drawable, FrozenMapping, shorten

# Exact for contact laws that are polynomials in sqrt(penetration).
CONTACT_NODES, CONTACT_WEIGHTS = np.polynomial.legendre.leggauss(12)
GAP = sp.Symbol("gap_of_contact", real=True)
WORKS = ("belt drive", "friction", "dampers", "impacts", "loads", "moving springs", "contact", "moving load")

PIECE_NODES, PIECE_WEIGHTS = np.polynomial.legendre.leggauss(10)
PIECES_PER_CHUNK = 20_000  # intervals of the run computed at once


@dataclass(frozen=True, eq=False)
class ContactTerms:
    """The terms of a contact in the energy balance.

    Parameters
    ----------
    number : str
        Suffix that tells its outputs from those of other contacts.
    place : int
        Index of this contact's regime among those in a mode's name.
    speed : callable or None
        Speed of the belt (m/s) as a function of states and parameters; None for a stop.
    approach : callable or None
        Material penetration rate -W_N . q' (m/s); None where the contact cannot be lost.
    travel : callable or None
        Full less material penetration rate (m/s), with which F_N does work beyond that of the contact's
        spring; None where it is zero by construction.
    penetration, law : callable or None
        The penetration (m) as a function of states and parameters, and F_N (N) as one of penetration and
        parameters.
    """

    number: str
    place: int
    speed: Callable[..., Any] | None = None
    approach: Callable[..., Any] | None = None
    travel: Callable[..., Any] | None = None
    penetration: Callable[..., Any] | None = None
    law: Callable[..., Any] | None = None


@dataclass(frozen=True, eq=False)
class Terms:
    """Energies (J) and powers (W) as functions of states and parameters, by their names."""

    kinetic: Callable[..., Any]
    potential: Mapping[str, Callable[..., Any]]
    powers: Mapping[str, Callable[..., Any]]
    contacts: tuple[ContactTerms, ...]


class Balance:
    """A model's energy balance at states (N, states) in modes (N,), which are indices into `mode_names`."""

    def __init__(self, model: Any, automaton: HybridAutomaton, mode_names: Sequence[str]) -> None:
        self.automaton, self.mode_names, self._values = automaton, mode_names, structure_values(model)
        self._terms = terms_of(structure_of_component(model))

    def energies(self, states: Array, modes: Any) -> dict[str, Array]:
        """The energies (J), each (N,)."""
        found = {"kinetic": self._at(self._terms.kinetic, states)}
        found |= {name: self._at(energy, states) for name, energy in self._terms.potential.items()}
        springs = [c for c in self._terms.contacts if c.law is not None]
        if springs:
            found["contact"] = np.sum(
                [self._contact_energy(contact, states, modes) for contact in springs], axis=0
            )
        return found

    def powers(self, states: Array, modes: Any) -> dict[str, Array]:
        """The powers (W), each (N,), that change the sum of the energies between events."""
        found = {name: self._at(power, states) for name, power in self._terms.powers.items()}
        for contact in self._terms.contacts:
            for name, power in self._contact_powers(contact, states, modes):
                found[name] = found.get(name, 0.0) + power
        return {name: found[name] for name in WORKS if name in found}

    def jumps(self, before: Array, after: Array) -> Array:
        """Energy (J) gained at events: velocities jump there, coordinates do not."""
        return self._at(self._terms.kinetic, after) - self._at(self._terms.kinetic, before)

    def _at(self, function: Any, states: Array) -> Array:
        return np.broadcast_to(np.asarray(function(*states.T, *self._values), dtype=float), len(states))

    def _output(self, name: str, contact: ContactTerms, states: Array, modes: Any) -> Array:
        return evaluate_output(self.automaton, name + contact.number, states, modes, self.mode_names)

    def _contact_powers(self, contact: ContactTerms, states: Array, modes: Any) -> Any:
        """Names and powers (W) of a contact with friction."""
        if contact.speed is None:
            return
        friction = self._output("friction_force", contact, states, modes)
        yield "belt drive", friction * self._at(contact.speed, states)
        yield "friction", -friction * self._output("relative_velocity", contact, states, modes)
        if contact.approach is None:
            return
        normal, pressed = (
            self._output("normal_force", contact, states, modes),
            self._modes_in_contact(contact)[modes],
        )
        approaching = self._at(contact.approach, states)
        yield "impacts", np.where(pressed, 0.0, -normal * approaching)
        # without a law the energy that the contact stores is not known: all power of F_N counts as work
        if contact.law is None:
            yield "contact", np.where(pressed, -normal * approaching, 0.0)
        elif contact.travel is not None:
            yield "moving load", np.where(pressed, normal * self._at(contact.travel, states), 0.0)

    def _contact_energy(self, contact: ContactTerms, states: Array, modes: Any) -> Array:
        """Energy stored by the contact (J): the integral of F_N from 0 to the penetration; none in flight."""
        law: Any = contact.law
        penetration = self._at(contact.penetration, states)
        # integrated over sqrt(penetration), in which penetration^1.5 is a polynomial too
        shares = (1.0 + CONTACT_NODES) / 2.0
        at = (law(penetration * share**2, *self._values) * share for share in shares)
        energy = penetration * sum(w * f for w, f in zip(CONTACT_WEIGHTS, at, strict=True))
        return np.where(self._modes_in_contact(contact)[modes], energy, 0.0)

    def _modes_in_contact(self, contact: ContactTerms) -> np.ndarray:
        """Whether the contact's spring acts in each mode: not in flight, nor in the limit mode of chatter."""
        apart = "separation", CHATTER_MODE
        return np.array([name.split(JOINT)[contact.place] not in apart for name in self.mode_names])


@lru_cache(maxsize=64)
def terms_of(key: Structure) -> Terms:
    """The terms of the energy balance of a structure."""
    found = system_of(key)
    mechanics = found.mechanics
    arguments = [*found.states, *parameter_symbols(key)]

    def compiled(expression: Any) -> Callable[..., Any]:
        return array_function(arguments, sp.sympify(expression, strict=True))

    given = (
        mechanics.potential if isinstance(mechanics.potential, Mapping) else {"potential": mechanics.stored}
    )
    return Terms(
        kinetic=compiled(mechanics.kinetic),
        potential={name: compiled(energy) for name, energy in given.items() if energy != 0},
        powers={name: compiled(power) for name, power in _powers(found).items()},
        contacts=tuple(_contact(found, i, compiled, key) for i in range(len(mechanics.contacts))),
    )


def _powers(found: LagrangeSystem) -> dict[str, Any]:
    """The powers of dampers, of loads, and of energies that depend on time."""
    damping = [sp.diff(found.mechanics.dissipation, rate) for rate in found.v]
    powers = {"dampers": -_dot(damping, found.v), "impacts": sp.S.Zero}
    if any(load != 0 for load in found.loads):
        powers["loads"] = _dot(found.loads, found.v)
    for phase in found.phase:
        moved = sp.diff(found.mechanics.stored, phase) * found.mechanics.frequency
        powers |= {} if moved == 0 else {"moving springs": moved}
    return powers


def _contact(found: LagrangeSystem, i: int, compiled: Callable[..., Any], key: Structure) -> ContactTerms:
    contact, numbered = found.mechanics.contacts[i], contact_suffix(found, i)
    if not isinstance(contact, Friction):
        return ContactTerms(numbered, i)
    speed = compiled(found.at_rest(contact.relative_velocity))
    if contact.penetration is None:
        return ContactTerms(numbered, i, speed)
    approach = -_dot(found.normal(contact), found.v)
    travel = (
        None if contact.normal is None else compiled(sp.expand(found.rate(contact.penetration) - approach))
    )
    if not callable(contact.normal_force):
        return ContactTerms(numbered, i, speed, compiled(approach))
    law = array_function([GAP, *parameter_symbols(key)], contact.normal_force(GAP))
    return ContactTerms(numbered, i, speed, compiled(approach), travel, compiled(contact.penetration), law)


def _dot(one: Any, other: Any) -> Any:
    return sum((a * b for a, b in zip(one, other, strict=True)), sp.S.Zero)


@dataclass(frozen=True, eq=False)
class EnergyAudit(Drawable):
    """The energy balance of a run.

    Parameters
    ----------
    t : array (N,)
        Times (s), those of the run.
    energies : mapping of str to array (N,)
        J: "kinetic"; those that the model names, such as "springs" and "preload", else "potential"; and
        "contact", the integral of F_N over the penetration, zero in flight.
    powers : mapping of str to array (N,)
        W: "dampers"; "loads"; "moving springs", of a potential that depends on time; "impacts", zero but in
        the limit mode of chatter.  At contacts with friction "belt drive" F_T v, with the belt's speed v;
        "friction" -F_T v_r; "moving load" F_N (penetration rate + W_N . q') where W_N is not the gradient of
        the gap, which for the paper's model is -F_N phi (x1' - x2'); "contact", the power of an F_N that is
        not given as a function of the penetration.
    works : mapping of str to array (N,)
        J: the work of each power from 0 to t; that of impacts includes the jumps of the kinetic energy.
    turned_over : float
        J: the largest sum of the energies' magnitudes, plus the magnitudes of all works, in or out.
    """

    drawn_by = "plot_energies"

    t: Array
    energies: Mapping[str, Array]
    powers: Mapping[str, Array]
    works: Mapping[str, Array]
    turned_over: float

    @property
    def total(self) -> Array:
        """Sum (N,) of the energies, J."""
        return np.sum(list(self.energies.values()), axis=0)

    @property
    def residual(self) -> Array:
        """Residual of the balance (N,), J: gain of the total since the first sample, less all works."""
        gained = self.total - np.sum(list(self.works.values()), axis=0)
        return gained - gained[:1]

    @property
    def error(self) -> float:
        """Largest residual as a share of the energy turned over; rounding, for the exact solver."""
        return float(np.abs(self.residual).max(initial=0.0) / (self.turned_over or 1.0))

    def __repr__(self) -> str:
        ends = shorten(f"{name} {work[-1]:+.4g} J" for name, work in self.works.items() if work[-1])
        return f"EnergyAudit(0 to {self.t[-1]:g} s, {ends or 'no work'}, error {self.error:.1g})"


def energy_audit(run: Trajectory, *, progress: bool = True) -> EnergyAudit:
    """The energy balance of a run: energies, powers, the work of each, and the residual.

    For the slider on a belt d/dt (kinetic + springs + preload + contact) = F_T v - F_T v_r - 2 D
    + F_N (penetration rate + W_N . q'), and velocities jump at impacts, Eqs. (10) to (12).  Every model that
    states its energies (`MechanicalModel`) has a balance, with the terms that it has.

    Works are Gauss quadratures of the run's Taylor polynomials, step by step, exact to rounding.  For runs of
    other methods the residual shows their error.

    Parameters
    ----------
    run : Trajectory
        Of a model, by :func:`simulate`.
    progress : bool
        Show a progress bar where it takes more than a second.

    Returns
    -------
    EnergyAudit

    Raises
    ------
    TypeError
        Where `run` is no Trajectory.
    ValueError
        For a run of an automaton, or of a model that gives only an automaton: it has no masses or springs.

    Examples
    --------
    >>> import frictionlab as fl
    >>> run = fl.simulate(fl.SliderOnBelt(mu_k=1.4), 1.0)
    >>> audit = fl.energy_audit(run)
    >>> audit.error < 1e-12
    True
    >>> bool(audit.works["belt drive"][-1] > 0 > audit.works["friction"][-1])
    True
    """
    balance = _balance(run)
    edges = np.unique(np.concatenate([[0.0], run.raw.step_times[:, 0], run.t, [run.raw.t]]))
    net, gross = _work_integrals(run, balance, edges, progress)
    at = np.searchsorted(edges, run.t)
    powers = balance.powers(run.states, run.mode_indices)
    works = {name: net[i][at] for i, name in enumerate(powers)}
    gains = balance.jumps(run.events.before, run.events.state)
    summed = np.append(0.0, np.cumsum(gains, dtype=np.longdouble))
    works["impacts"] = works["impacts"] + summed[np.searchsorted(run.events.t, run.t, side="right")]
    energies = balance.energies(run.states, run.mode_indices)
    largest = np.sum(np.abs(list(energies.values())), axis=0).max(initial=0.0)
    return EnergyAudit(
        t=run.t,
        energies=FrozenMapping(energies),
        powers=FrozenMapping(powers),
        works=FrozenMapping({name: np.asarray(work, dtype=float) for name, work in works.items()}),
        turned_over=float(largest + gross + np.abs(gains).sum()),
    )


def _balance(run: Any) -> Balance:
    if not isinstance(run, Trajectory):
        raise TypeError(f"run must be a Trajectory, got {run!r}: give what frictionlab.simulate returns")
    if not isinstance(run.source, MechanicalModel):
        of = type(run.automaton if run.source is None else run.source).__name__
        raise ValueError(
            f"run must be of a model that states its energies, got one of a {of}, which has no masses nor "
            "springs: simulate a MechanicalModel"
        )
    return Balance(run.source, run.automaton, run.mode_names)


def _work_integrals(run: Trajectory, balance: Balance, edges: Array, progress: bool) -> tuple[Any, float]:
    """Works (contributions, edges) since the first edge, and the sum of all magnitudes, J."""
    starts = range(0, len(edges) - 1, PIECES_PER_CHUNK)
    shown = progress_bar(starts, desc="energy audit", shown=progress)
    parts = [_work_of_pieces(run, balance, edges[i : i + PIECES_PER_CHUNK + 1]) for i in shown]
    net = np.concatenate([np.zeros((len(parts[0][0]), 1)), *(part for part, _ in parts)], axis=1)
    return np.cumsum(net, axis=1, dtype=np.longdouble), sum(size for _, size in parts)


def _work_of_pieces(run: Trajectory, balance: Balance, edges: Array) -> tuple[Array, float]:
    """Works (contributions, pieces) on each piece of a run between two edges, and the sum of all sizes."""
    half = np.diff(edges)[:, None] / 2.0
    t = (edges[:-1, None] + half * (1.0 + PIECE_NODES)).ravel()
    found = balance.powers(*run.states_and_modes(t))
    weights = half * PIECE_WEIGHTS
    each = [power.reshape(weights.shape) for power in found.values()]
    net = np.array([(power * weights).sum(axis=1) for power in each])
    return net, float(sum((np.abs(power) * weights).sum() for power in each))
