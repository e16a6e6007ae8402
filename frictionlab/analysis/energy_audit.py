"""`fl.energy_audit`: where the energy of a run comes from, where it is, and where it goes.

The balance has energies, powers, and jumps at impacts, each evaluated at the states of the run.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any

import numpy as np
import sympy as sp

from frictionlab.analysis.motion_scales import Array
from frictionlab.automaton import HybridAutomaton
from frictionlab.automaton.modes_on_demand import JOINT
from frictionlab.components.component import StructureKey
from frictionlab.hybrid.outputs import evaluate_outputs
from frictionlab.hybrid.trajectory import Trajectory, check_run
from frictionlab.interruption import progress_bar
from frictionlab.models import MechanicalModel
from frictionlab.models.mechanical.contact_regimes import (
    APART,
    CHATTER_MODE,
    DIRECTIONS,
    material_rate,
    rubbing_direction,
)
from frictionlab.models.mechanical.equations_of_motion import LagrangeSystem, system_of
from frictionlab.models.mechanical.friction_in_plane import STOP
from frictionlab.models.mechanical.impulses import impulse_terms
from frictionlab.models.mechanical.mechanics import AnyContact, Contact, Friction, Stop
from frictionlab.models.mechanical.modes import contact_suffix
from frictionlab.models.mechanical.stored_energies import (
    Bristles,
    Energies,
    borders_of_law,
    borders_within,
    energies_of_bristles,
    energy_of_spring,
)
from frictionlab.models.model import MovingSystem
from frictionlab.models.symbols import dot, parameter_symbols, structure_values
from frictionlab.presentation import Drawable, FrozenMapping, in_units_of, shorten
from frictionlab.tape.formulas import function_along_run
from frictionlab.validation import check_flag

GAP = sp.Symbol("gap_of_contact", real=True)
ENERGY_OF, POWER_OF = "energy of ", "power of "  # how the outputs of an automaton that states them begin
WORKS = (
    *("belt drive", "friction", "dampers", "impacts", "loads", "moving springs", "moving masses"),
    *("moving contacts", "contact", "moving load"),
)

# A step is at most a quarter of the radius of convergence, and a piece is shorter: ten nodes miss less than
# rounding.
PIECE_NODES, PIECE_WEIGHTS = np.polynomial.legendre.leggauss(10)
PIECES_PER_CHUNK = 20_000  # intervals of the run computed at once
# Share of the energy turned over up to which a work is rounding, as of resets that begin stick.
WORK_ROUNDING = 1e-15


@dataclass(frozen=True, eq=False)
class ContactTerms:
    """The terms of a contact in the energy balance.

    Parameters
    ----------
    number : str
        Suffix that tells its outputs from those of other contacts.
    place : int
        Index of this contact's regime among those in a mode's name.
    speeds : mapping of str to callable
        Speed of the belt (m/s) as a function of states and parameters, by the end of the names of outputs
        along it: "" for friction along a line, "_a" and "_b" in the plane; empty without friction.
    approach : callable or None
        Material penetration rate (m/s), -W_N . q' plus `moved`; None where the contact cannot be lost.
    moved : callable or None
        How fast (m/s) the penetration grows by time alone; None where the contact does not move with time.
    travel : callable or None
        Full less material penetration rate (m/s), with which F_N does work beyond that of the contact's
        spring; None where it is zero by construction.
    penetration, law : callable or None
        The penetration (m) as a function of states and parameters, and F_N (N) as one of penetration and
        parameters.
    borders : tuple of callable
        Functions of penetration and parameters at whose zeros a law in pieces changes its formula.
    normal : str
        The output that is its normal force.
    """

    number: str
    place: int
    speeds: Mapping[str, Callable[..., Any]] = field(default_factory=dict)
    approach: Callable[..., Any] | None = None
    moved: Callable[..., Any] | None = None
    travel: Callable[..., Any] | None = None
    penetration: Callable[..., Any] | None = None
    law: Callable[..., Any] | None = None
    borders: tuple[Callable[..., Any], ...] = ()
    normal: str = "normal_force"


@dataclass(frozen=True, eq=False)
class MovedMasses:
    """The power of what moves masses, or changes them: -dT/dt by the phase + d/dt (T_1 + 2 T_0).

    T_1 is the part of T with one velocity, b . q', and T_0 that with none.

    Parameters
    ----------
    energy : callable
        T_1 + 2 T_0, J.
    free : callable
        The power (W) without forces of contacts.
    along : tuple of (str, callable)
        Outputs that are forces of contacts, and b . M^-1 W, by which each has a part in the power.
    """

    energy: Callable[..., Any]
    free: Callable[..., Any]
    along: tuple[tuple[str, Callable[..., Any]], ...]


@dataclass(frozen=True, eq=False)
class Terms:
    """Energies (J) and powers (W) as functions of states and parameters, by their names."""

    kinetic: Callable[..., Any]
    potential: Mapping[str, Callable[..., Any]]
    powers: Mapping[str, Callable[..., Any]]
    contacts: tuple[ContactTerms, ...]
    bristles: Energies
    moved: MovedMasses | None


class Balance:
    """A model's energy balance at states (N, states) in modes (N,), which are indices into `mode_names`."""

    def __init__(self, model: MechanicalModel, automaton: HybridAutomaton, mode_names: Sequence[str]) -> None:
        self.automaton, self.mode_names, self._values = automaton, mode_names, structure_values(model)
        self._terms = terms_of(model.structure_key)
        self._striking = impulse_terms(model.structure_key).contacts
        self._bristles = Bristles(self._terms.bristles, automaton, mode_names)

    def energies(self, states: Array, modes: Any) -> dict[str, Array]:
        """The energies (J), each (N,)."""
        energies = {"kinetic": self._at(self._terms.kinetic, states)}
        energies |= {name: self._at(energy, states) for name, energy in self._terms.potential.items()}
        if any(contact.law is not None for contact in self._terms.contacts):
            energies["contact"] = self._stored(states, modes)
        if self._terms.bristles:
            energies["bristles"] = self._bristles.energy(states, modes)
        return energies

    def powers(self, states: Array, modes: Any) -> dict[str, Array]:
        """The powers (W), each (N,), that change the sum of the energies between events."""
        powers = {name: self._at(power, states) for name, power in self._terms.powers.items()}
        if (motion := self._terms.moved) is not None:
            powers["moving masses"] = self._at(motion.free, states) + sum(
                self._output(name, states, modes) * self._at(share, states) for name, share in motion.along
            )
        for contact in self._terms.contacts:
            for name, power in self._contact_powers(contact, states, modes):
                powers[name] = powers.get(name, 0.0) + power
        if self._terms.bristles:
            powers["friction"] += self._bristles.power(states, modes)
        return {name: powers[name] for name in WORKS if name in powers}

    def jumps(self, run: Trajectory) -> dict[str, Array]:
        """Energy (J) gained at each event: at impacts by velocities, at the end of a period by the phase."""
        before, after = run.events.before, run.events.state
        modes = [run.mode_names.index(name) if name else 0 for name in run.events.source]
        ends = run.events.guard == "period"
        gained = self._gain(self._terms.kinetic, before, after)
        jumps = {"impacts": np.where(ends, 0.0, gained)}
        if any(len(contact.speeds) > 1 for contact in self._terms.contacts):
            # a stop takes out what is left of the velocity across the slip
            stops = np.char.startswith(run.events.guard.astype(str), STOP)
            jumps = {"impacts": np.where(ends | stops, 0.0, gained), "friction": np.where(stops, gained, 0.0)}
        if (imposed := self._terms.moved) is not None:
            carried = np.where(ends, gained, self._gain(imposed.energy, before, after))
            jumps = {"impacts": gained - carried, "moving masses": carried}
        if ends.any():  # what depends on the phase may differ between 0 and 2 pi
            changes = [self._gain(energy, before, after) for energy in self._terms.potential.values()]
            jumps["moving springs"] = (
                np.where(ends, np.sum(changes, axis=0), 0.0) if changes else 0.0 * gained
            )
        if any(contact.moved is not None for contact in self._terms.contacts):
            work = self._work_of_moved_contacts(run)
            stored = self._stored(after, np.array(modes)) - self._stored(before, np.array(modes))
            by_contacts = work + np.where(ends, stored, 0.0)
            jumps |= {"impacts": jumps["impacts"] - work, "moving contacts": by_contacts}
        if self._terms.bristles:
            jumps["friction"] = self._bristles.gains(run.events)
        return jumps

    def _gain(self, energy: Any, before: Array, after: Array) -> Array:
        return self._at(energy, after) - self._at(energy, before)

    def _stored(self, states: Array, modes: Any) -> Array:
        """Energy (J) that all contacts store, each (N,)."""
        springs = [c for c in self._terms.contacts if c.law is not None]
        parts = [self._contact_energy(contact, states, modes) for contact in springs]
        return np.sum(parts, axis=0) if parts else np.zeros(len(states))

    def _work_of_moved_contacts(self, run: Trajectory) -> Array:
        """Work (J) that each event's impulses do because contacts move with time."""
        work = np.zeros(len(run.events))
        for one in self._striking:
            rate = self._terms.contacts[one.place].moved
            if rate is not None:
                work += run.events["impulse" + one.suffix] * self._at(rate, run.events.before)
        return work

    def _at(self, function: Any, states: Array) -> Array:
        return np.broadcast_to(np.asarray(function(*states.T, *self._values), dtype=float), len(states))

    def _output(self, name: str, states: Array, modes: Any) -> Array:
        return evaluate_outputs(self.automaton, [name], states, modes, self.mode_names)[name]

    def _contact_powers(self, contact: ContactTerms, states: Array, modes: Any) -> Any:
        """Names and powers (W) of a contact."""
        if contact.moved is not None:
            pushed = self._output(contact.normal + contact.number, states, modes)
            yield "moving contacts", pushed * self._at(contact.moved, states)
        for direction, speed in contact.speeds.items():
            of = direction + contact.number
            friction = self._output("friction_force" + of, states, modes)
            yield "belt drive", friction * self._at(speed, states)
            yield "friction", -friction * self._output("relative_velocity" + of, states, modes)
        if contact.approach is None:
            return
        normal = self._output("normal_force" + contact.number, states, modes)
        pressed = self._modes_in_contact(contact)[modes]
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
        beyond = [lambda depth, of=of: of(depth, *self._values) for of in contact.borders]
        borders = borders_within(beyond, penetration)
        energy = energy_of_spring(lambda depth: law(depth, *self._values), penetration, borders)
        return np.where(self._modes_in_contact(contact)[modes], energy, 0.0)

    def _modes_in_contact(self, contact: ContactTerms) -> np.ndarray:
        """Whether the contact's spring acts in each mode: not in flight, nor in the limit mode of chatter."""
        without_contact = *APART, CHATTER_MODE
        return np.array([name.split(JOINT)[contact.place] not in without_contact for name in self.mode_names])


class StatedBalance:
    """The energy balance of an automaton whose modes have the outputs "energy of ..." and "power of ..."."""

    def __init__(self, automaton: HybridAutomaton, mode_names: Sequence[str]) -> None:
        self.automaton, self.mode_names = automaton, mode_names

    def energies(self, states: Array, modes: Any) -> dict[str, Array]:
        """The energies (J), each (N,)."""
        return self._outputs(ENERGY_OF, states, modes)

    def powers(self, states: Array, modes: Any) -> dict[str, Array]:
        """The powers (W), each (N,), that change the sum of the energies between events."""
        return self._outputs(POWER_OF, states, modes)

    def jumps(self, run: Trajectory) -> dict[str, Array]:
        """Energy (J) gained at each event, by its reset and because the next mode has other energies."""
        events, gained = run.events, np.zeros(len(run.events))
        for states, names, sign in ((events.before, events.source, -1), (events.state, events.target, 1)):
            modes = np.array([run.mode_names.index(name) if name else 0 for name in names], dtype=int)
            gained += sign * np.sum(list(self.energies(states, modes).values()), axis=0)
        return {"resets": gained}

    def _outputs(self, prefix: str, states: Array, modes: Any) -> dict[str, Array]:
        names = [name for name in self.automaton.outputs if name.startswith(prefix)]
        values = evaluate_outputs(self.automaton, names, states, modes, self.mode_names)
        return {name.removeprefix(prefix): values[name] for name in names}


@lru_cache(maxsize=64)
def terms_of(key: StructureKey) -> Terms:
    """The terms of the energy balance of a structure."""
    system = system_of(key)
    mechanics = system.mechanics
    arguments = [*system.states, *parameter_symbols(key)]

    def compiled(expression: Any) -> Callable[..., Any]:
        return function_along_run(arguments, expression)

    energies = (
        mechanics.potential if isinstance(mechanics.potential, Mapping) else {"potential": mechanics.stored}
    )
    contacts = tuple(_contact(system, i, compiled, key) for i in range(len(mechanics.contacts)))
    return Terms(
        kinetic=compiled(mechanics.kinetic),
        potential={name: compiled(energy) for name, energy in energies.items() if energy != 0},
        powers={name: compiled(power) for name, power in _powers(system).items()},
        contacts=contacts,
        bristles=energies_of_bristles(system),
        moved=_moved_masses(system, compiled),
    )


def _moved_masses(system: LagrangeSystem, compiled: Callable[..., Any]) -> MovedMasses | None:
    """The power of what moves masses; None where T is quadratic in the velocities and free of the phase."""
    kinetic = sp.sympify(system.mechanics.kinetic, strict=True)
    momenta = [system.at_rest(momentum) for momentum in system.gradient(kinetic, system.v)]
    energy = dot(momenta, system.v) + 2 * system.at_rest(kinetic)
    explicit = system.explicit_rate(kinetic)
    if energy == 0 and explicit == 0:
        return None
    free = [load - rest for load, rest in zip(system.loads, system.internal, strict=True)]
    power = system.rate(energy) - explicit + dot(momenta, system.accelerations(free))
    forces: list[tuple[str, Any]] = []
    for i, contact in enumerate(system.mechanics.contacts if any(momenta) else ()):
        of = contact_suffix(system, i)
        if isinstance(contact, Friction):
            along = system.direction(contact)
            ends = [f"_{one}" for one in DIRECTIONS] if contact.in_plane else [""]
            forces += [("friction_force" + end + of, along[:, k]) for k, end in enumerate(ends)]
            forces += (
                [("normal_force" + of, system.normal(contact))] if contact.penetration is not None else []
            )
        elif isinstance(contact, Contact):
            forces += [("normal_force" + of, system.normal(contact))]
        else:
            forces += [("reaction" + of, system.direction(contact))]
            if contact.rubs:
                forces += [("friction_force" + of, rubbing_direction(system, contact))]
    shares = ((name, dot(momenta, system.accelerations(list(along)))) for name, along in forces)
    return MovedMasses(
        compiled(energy), compiled(power), tuple((name, compiled(one)) for name, one in shares)
    )


def _powers(system: LagrangeSystem) -> dict[str, Any]:
    """The powers of dampers, of loads, and of potentials that depend on time."""
    damping = [sp.diff(system.mechanics.dissipation, rate) for rate in system.v]
    powers = {"dampers": -dot(damping, system.v), "impacts": sp.S.Zero}
    if any(load != 0 for load in system.loads):
        powers["loads"] = dot(system.loads, system.v)
    power = system.explicit_rate(system.mechanics.stored)
    return powers if power == 0 else powers | {"moving springs": power}


def _contact(system: LagrangeSystem, i: int, compiled: Callable[..., Any], key: StructureKey) -> ContactTerms:
    contact, numbered = system.mechanics.contacts[i], contact_suffix(system, i)
    if isinstance(contact, Stop):
        belt = {"": compiled(system.at_rest(contact.relative_velocity))} if contact.rubs else {}
        return ContactTerms(numbered, i, belt, moved=_moved(system, contact, compiled), normal="reaction")
    belt: dict[str, Any] = {}
    if isinstance(contact, Friction):
        ends = [f"_{one}" for one in DIRECTIONS] if contact.in_plane else [""]
        velocities = zip(ends, contact.velocities, strict=True)
        belt = {end: compiled(system.at_rest(one)) for end, one in velocities}
    terms = ContactTerms(numbered, i, belt)
    if contact.penetration is None:
        return terms
    approach = material_rate(system, contact)
    terms = replace(terms, approach=compiled(approach), moved=_moved(system, contact, compiled))
    force = contact.normal_force(GAP) if callable(contact.normal_force) else None
    if force is None or not sp.sympify(force, strict=True).free_symbols.isdisjoint(system.states):
        return terms
    travel = sp.expand(system.rate(contact.penetration) - approach)
    return replace(
        terms,
        travel=None if contact.normal is None else compiled(travel),
        penetration=compiled(contact.penetration),
        law=function_along_run([GAP, *parameter_symbols(key)], force),
        borders=tuple(
            function_along_run([GAP, *parameter_symbols(key)], one) for one in borders_of_law(force, GAP)
        ),
    )


def _moved(system: LagrangeSystem, contact: AnyContact, compiled: Callable[..., Any]) -> Any:
    """How fast the gap of a contact closes by time alone; None where it does not move with time."""
    rate = system.explicit_rate(-contact.distance if isinstance(contact, Stop) else contact.penetration)
    return None if rate == 0 else compiled(rate)


@dataclass(frozen=True, eq=False)
class EnergyAudit(Drawable):
    """The energy balance of a run.

    Parameters
    ----------
    t : array (N,)
        Times (s), those of the run.
    energies : mapping of str to array (N,)
        J: "kinetic"; those that the model names, such as "springs" and "preload", else "potential";
        "contact", the integral of F_N over the penetration, zero in flight; and "bristles", what friction
        laws store in their states (`FrictionLaw.stored_energy`).
    powers : mapping of str to array (N,)
        W: "dampers"; "loads"; "moving springs", of a potential that depends on time; "moving masses", of what
        moves a base or a hoop, or changes a mass, -dT/dt by time alone + d/dt (T_1 + 2 T_0) with the parts
        of T that have one velocity and none; "moving contacts", of grounds and stops that move with time;
        "impacts", zero but in the limit mode of chatter.  At contacts with friction "belt drive" F_T v, with
        the belt's speed v; "friction" -F_T v_r, plus what bristles store, so that it is what
        is dissipated; "moving load" F_N (penetration rate + W_N . q') where W_N is
        not the gradient of the gap, which for the paper's model is -F_N phi (x1' - x2'); "contact", the power
        of an F_N that is not given as a function of the penetration.
    works : mapping of str to array (N,)
        J: the work of each power from 0 to t.  That of impacts includes the jumps of the kinetic energy, but
        for the work of the impulses on a base, a ground or a stop that moves.
    turned_over : float
        J: the largest sum of the energies' magnitudes, plus the magnitudes of all works, in or out.
    unit : str
        Of energies and works, if the run's source is a structure in units of its own.
    """

    drawn_by = "plot_energies"

    t: Array
    energies: Mapping[str, Array]
    powers: Mapping[str, Array]
    works: Mapping[str, Array]
    turned_over: float
    unit: str = "J"

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

    @property
    def works_above_rounding(self) -> dict[str, Array]:
        """The works (N,) that become more than rounding of the energy turned over, J."""
        least = WORK_ROUNDING * self.turned_over
        return {name: work for name, work in self.works.items() if not np.abs(work).max() <= least}

    def __repr__(self) -> str:
        works = self.works_above_rounding.items()
        ends = shorten(f"{name} {work[-1]:+.4g} {self.unit}" for name, work in works)
        return f"EnergyAudit(0 to {self.t[-1]:g} s, {ends or 'no work'}, error {self.error:.1g})"


def energy_audit(run: Trajectory, *, progress: bool = True) -> EnergyAudit:
    """The energy balance of a run: energies, powers, the work of each, and the residual.

    For the slider on a belt d/dt (kinetic + springs + preload + contact) = F_T v - F_T v_r - 2 D
    + F_N (penetration rate + W_N . q'), and velocities jump at impacts, Eqs. (10) to (12).  Every model that
    states its energies (`MechanicalModel`) has a balance, with the terms that it has.  An automaton has the
    one that it states: outputs of its modes named "energy of ..." and "power of ..."; "resets" is what
    events add.

    Works are Gauss quadratures of the run's Taylor polynomials, step by step, exact to rounding.  For runs of
    other methods the residual shows their error.

    Parameters
    ----------
    run : Trajectory
        Of a model by :func:`simulate`, or of an automaton by :func:`solve`.
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
        For a run of a model or an automaton that states no energies.

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
    check_flag("progress", progress)
    balance = _balance(run)
    edges = np.unique(np.concatenate([[0.0], run.raw.step_times[:, 0], run.t, [run.raw.t]]))
    net, gross = _work_integrals(run, balance, edges, progress)
    at = np.searchsorted(edges, run.t)
    powers = balance.powers(run.states, run.mode_indices)
    works = {name: net[i][at] for i, name in enumerate(powers)}
    gains = balance.jumps(run)
    passed = np.searchsorted(run.events.t, run.t, side="right")
    for name, gain in gains.items():
        summed = np.append(0.0, np.cumsum(gain, dtype=np.longdouble))
        works[name] = works.get(name, 0.0) + summed[passed]
    energies = balance.energies(run.states, run.mode_indices)
    largest = np.sum(np.abs(list(energies.values())), axis=0).max(initial=0.0)
    return EnergyAudit(
        t=run.t,
        energies=FrozenMapping(energies),
        powers=FrozenMapping(powers),
        works=FrozenMapping({name: np.asarray(work, dtype=float) for name, work in works.items()}),
        turned_over=float(largest + gross + sum(np.abs(gain).sum() for gain in gains.values())),
        unit=in_units_of(run.source, "J"),
    )


def _balance(run: Trajectory) -> Balance | StatedBalance:
    check_run(run)
    if not run.raw.t > 0.0:
        raise ValueError(
            f"run must have a step, got one that ended at once ({run.status}): choose another initial state"
        )
    if isinstance(run.source, MechanicalModel):
        return Balance(run.source, run.automaton, run.mode_names)
    if isinstance(run.source, MovingSystem):
        return run.source.energy_balance(run.automaton, run.mode_names)
    stated = [name for name in run.automaton.outputs if name.startswith((ENERGY_OF, POWER_OF))]
    if not any(name.startswith(ENERGY_OF) for name in stated):
        source = run.automaton if run.source is None else run.source
        of = (HybridAutomaton if isinstance(source, HybridAutomaton) else type(source)).__name__
        raise ValueError(
            f"run must be of a model that states its energies, got one of a {of}, which has no masses nor "
            "springs: simulate a MechanicalModel, or give the modes outputs such as 'energy of the spring' "
            "and 'power of the damper'"
        )
    return StatedBalance(run.automaton, run.mode_names)


def _work_integrals(
    run: Trajectory, balance: Balance | StatedBalance, edges: Array, progress: bool
) -> tuple[Any, float]:
    """Works (contributions, edges) since the first edge, and the sum of all magnitudes, J."""
    starts = range(0, len(edges) - 1, PIECES_PER_CHUNK)
    chunks = progress_bar(starts, desc="energy audit", shown=progress)
    parts = [_work_of_pieces(run, balance, edges[i : i + PIECES_PER_CHUNK + 1]) for i in chunks]
    net = np.concatenate([np.zeros((len(parts[0][0]), 1)), *(part for part, _ in parts)], axis=1)
    return np.cumsum(net, axis=1, dtype=np.longdouble), sum(size for _, size in parts)


def _work_of_pieces(run: Trajectory, balance: Balance | StatedBalance, edges: Array) -> tuple[Array, float]:
    """Works (contributions, pieces) on each piece of a run between two edges, and the sum of all sizes."""
    half = np.diff(edges)[:, None] / 2.0
    t = (edges[:-1, None] + half * (1.0 + PIECE_NODES)).ravel()
    powers = balance.powers(*run.states_and_modes(t))
    weights = half * PIECE_WEIGHTS
    each = [power.reshape(weights.shape) for power in powers.values()]
    net = np.array([(power * weights).sum(axis=1) for power in each]).reshape(len(each), len(weights))
    return net, float(sum((np.abs(power) * weights).sum() for power in each))
