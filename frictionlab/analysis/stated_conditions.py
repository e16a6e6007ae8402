"""Whether a run is a motion of what its mechanical model states: energies, loads, laws of contacts.

The compiled automaton has no part in it, but for the names of the modes, each of which is a claim: v_r = 0 in
stick, a distance of zero in contact.  Judged are

* the claims, and that friction opposes v_r, that no contact pulls and none is overlapped in flight;
* Lagrange's equations, with the sliding forces of the laws, and with holding forces that must be within their
  limits, where these depend on each other in any way that is possible;
* that what slips could not be held at rest;
* impacts: impulses act where contacts are closed, none pulls, they keep the impact law of a single contact;
  together they give no energy, and take none where all laws are elastic.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from frictionlab.analysis.run_conditions import (
    evenly_spread,
    is_of_series,
    judged_size,
    largest_violation,
    steps_to_stops,
)
from frictionlab.analysis.stated_mechanics import Array, StatedContact, StatedMechanics, differences
from frictionlab.automaton.modes_on_demand import JOINT, regimes_in
from frictionlab.components.impact import ImpactLaw, PlasticImpact, RestitutionImpact
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.models import MechanicalModel
from frictionlab.models.mechanical.contact_regimes import APART, CHATTER_MODE
from frictionlab.models.mechanical.friction_in_plane import STOP
from frictionlab.models.mechanical.mechanics import Stop, mechanics_at
from frictionlab.presentation import PHASE, TIME

RUBBING = {"stick": 0, "slip+": 1, "slip-": -1}
SLIPPING = "slip+", "slip-"
OF_CONTACTS = {*RUBBING, "slip", "breakaway", *APART, CHATTER_MODE, "flight", "contact"}
CLOSED_REGIMES = [*RUBBING, "slip", "breakaway", "contact"]
LEAST_TOLERANCE = 1e-6  # share of the forces in an equation by which differences may miss it
PLACES_PER_MODE, LONGEST_STEPS = 12, 4
MOST_COORDINATES = 12  # of models with more, contacts and energies alone are judged
SAMPLES = 2000
MOST_EVENTS = 400
SAMPLES_OF_STAY = 8
STEP_SHARE, TIME_LEVELS = 1.0 / 9.0, 4  # of a step, between the points of differences by time
ROUNDING = 1e-14  # of a velocity, or a time, in such differences
NEAR_START = 0.02  # the middle of such differences in steps of methods whose dense output need not reach far
BREAKAWAY_SLACK = 0.03  # share of the limits of static friction by which stick may end too early
RESTING = 1e-9  # share of its size below which v_r counts as zero at an event
STOP_JUMP = 1e-3  # share of the velocities' size that other methods than series may lose at a stop
CLOSED = 1e-7  # share of its size below which a gap counts as zero at an impact
IMPACT_RTOL = 1e-6


def broken_statement(run: Trajectory) -> str:
    """What a run breaks of its model's statement, and where; an empty text where it keeps all of it.

    There is none to break where the run is of an automaton, or has states that the statement does not know.
    """
    check = _check_of(run)
    if check is None or not check.knows_run:
        return ""
    rules = (check.claims, check.balance, check.breakaway, check.impacts)
    return next((words for broken_rule in rules if (words := broken_rule())), "")


def unjudged_statement(run: Trajectory) -> str:
    """Which part of its model's statement a run was not compared with; an empty text where there is none."""
    check = _check_of(run)
    if check is None:
        return ""
    if not check.knows_run:
        return "What the model states was not compared: the run has other states or modes."
    if check.stated.n > MOST_COORDINATES:
        return f"Lagrange's equations were not compared: there are more than {MOST_COORDINATES} coordinates."
    if any(contact.across is not None for contact in check.stated.contacts):
        return "Whether friction in the plane could have held what slips was not compared."
    return ""


def _check_of(run: Trajectory) -> _StatementCheck | None:
    """The check of a run by its mechanical model; None for other runs."""
    model = run.source
    if not isinstance(model, MechanicalModel) or not len(run.raw.step_modes):
        return None
    return _StatementCheck(run, StatedMechanics(model, judged_size(run)))


class Places(NamedTuple):
    """Places of a run: times, states, modes."""

    t: Array
    states: Array
    modes: Array


def places_within_steps(run: Trajectory, stated: StatedMechanics) -> tuple[Places, Array, Array]:
    """Places within steps of each mode, accelerations there by differences along the run, their errors."""
    begins, lengths = run.raw.step_times.T
    modes = run.raw.step_modes
    steps = np.concatenate([_some_steps(run, np.flatnonzero(modes == mode)) for mode in np.unique(modes)])
    steps = np.setdiff1d(steps, steps_to_stops(run))
    share = 0.5 if is_of_series(run) else NEAR_START
    t, first = begins[steps] + share * lengths[steps], share * lengths[steps] * 2.0 * STEP_SHARE
    n = stated.n
    clear = (t - 4.0 * first > begins[steps]) & (t + 4.0 * first < begins[steps] + lengths[steps])
    t, first = t[clear], first[clear]

    def velocities(h: Array) -> Array:
        return run((t + h).ravel())[:, n : 2 * n].reshape(*h.shape, n)

    accelerations, errors = differences(velocities, first, TIME_LEVELS)
    fastest = np.abs(run.raw.step_states).max(axis=0)[n : 2 * n]
    errors += ROUNDING * (fastest + np.abs(accelerations) * t[:, None]) / first[:, None]
    finite = np.isfinite(errors).all(axis=1)
    t = t[finite]
    return Places(t, *run.states_and_modes(t)), accelerations[finite], errors[finite]


def _some_steps(run: Trajectory, steps: Array) -> Array:
    """The longest of some steps, and others all over them."""
    longest = steps[np.argsort(-run.raw.step_times[steps, 1])][:LONGEST_STEPS]
    return np.union1d(longest, steps[evenly_spread(len(steps), PLACES_PER_MODE)])


class Jumps(NamedTuple):
    """Jumps of velocities: times, states before them, and with the velocities after them; whether each is of
    one event, and closes an accumulation."""

    t: Array
    before: Array
    after: Array
    single: Array
    closed: Array


class ImpactTerms(NamedTuple):
    """A contact at jumps: its number and law, whether it is closed, the directions of its impulses, the rate
    of the gap by time alone, the speed of the belt, the rate of the gap before; and whether the normal force
    acts along the gradient of the gap, so that it does no work but by that rate."""

    number: int
    law: Any
    closed: Array
    normal: Array
    along: Array | None
    moved: Array
    belt: Array
    before: Array
    conservative: bool


class Forces(NamedTuple):
    """Given forces (N, n) of contacts and the magnitudes of their parts, and directions (N, k, n) of forces
    that hold, with the least and the most that each can be (N, k)."""

    given: Array
    sizes: Array
    columns: Array
    least: Array
    most: Array

    def at(self, k: int) -> tuple[Array, Array, Array]:
        """The directions, as columns, and limits of the forces that can hold at one place."""
        some = self.most[k] > 0.0
        return self.columns[k][some].T, self.least[k][some], self.most[k][some]


class Held(NamedTuple):
    """By how much the equations are missed, as a share; the worst of them; whether forces without limits
    would do."""

    miss: float
    worst: int
    bounded: bool


def held_forces(values: Array, forces: tuple[Array, Array, Array], rooms: Array, scale: Array) -> Held:
    """The least by which holding forces miss the balance `values` - W lambda = 0."""
    W, least, most = forces
    some = np.isfinite(rooms)
    scale = np.maximum(scale, _sizes_of_holding(values[some], W[some], some))
    matrix, right = (W / scale[:, None])[some], (values / scale)[some]
    shares, names = (rooms / scale)[some], np.flatnonzero(some)

    def missed(forces: Array) -> tuple[float, int]:
        misses = np.abs(right - matrix @ forces) - shares
        return (float(misses.max()), int(names[misses.argmax()])) if len(misses) else (0.0, 0)

    free = np.linalg.lstsq(matrix, right)[0] if W.shape[1] else np.zeros(0)
    slack = 1e-6 * np.where(np.isfinite(most), most, 0.0)
    if not W.shape[1] or ((free >= least - slack) & (free <= most + slack)).all():
        return Held(*missed(free), False)
    from scipy.optimize import lsq_linear

    solution = lsq_linear(matrix, right, (least - slack - 1e-300, most + slack), tol=1e-14).x
    return Held(*missed(solution), missed(free)[0] < missed(solution)[0])


def _sizes_of_holding(values: Array, W: Array, some: Array) -> Array:
    """Sizes of the forces that hold in each equation, which may be all that is in it."""
    sizes, arms = np.zeros(len(some)), np.abs(W).max(axis=1, initial=0.0)
    arms[arms == 0.0] = 1.0
    forces = np.linalg.lstsq(W / arms[:, None], values / arms)[0]
    sizes[some] = np.abs(W) @ np.abs(forces)
    return sizes


def can_hold(matrix: Array, right: Array, least: Array, most: Array) -> bool:
    """Whether forces within limits solve matrix @ forces = right."""
    from scipy.optimize import lsq_linear

    rows = np.abs(matrix).max(axis=1, initial=0.0) > 0.0
    if not rows.any():
        return False
    sizes = np.abs(matrix[rows]).max(axis=1)
    matrix, right = matrix[rows] / sizes[:, None], right[rows] / sizes
    free = most > least
    scale = max(float(np.abs(right).max(initial=0.0)), float(most[free & np.isfinite(most)].max(initial=0.0)))
    if not free.any() or scale == 0.0:
        return False
    forces = lsq_linear(matrix[:, free], right, (least[free], most[free]), tol=1e-14).x
    return bool(np.abs(matrix[:, free] @ forces - right).max() <= 1e-8 * scale)


class _StatementCheck:
    """Compares a run with the statement of its model."""

    def __init__(self, run: Trajectory, stated: StatedMechanics) -> None:
        self.run, self.stated, self.limit = run, stated, largest_violation(run)
        self.regimes = [name.split(JOINT)[: len(stated.contacts)] for name in run.mode_names]
        t = np.concatenate([np.linspace(0.0, run.raw.t, SAMPLES), *self._in_steps()])
        t = np.unique(t[t < run.raw.t])
        self.samples = Places(t, *run.states_and_modes(t))

    def _in_steps(self) -> list[Array]:
        begins, lengths = self.run.raw.step_times.T
        some = evenly_spread(len(begins), SAMPLES)
        inside = [begins[some] + lengths[some] * s for s in (0.3, 0.8)] if is_of_series(self.run) else []
        return [begins[some], *inside]

    @property
    def knows_run(self) -> bool:
        """Whether the run has the states and modes of the statement."""
        return self.stated.statement.names == self.run.names and self._knows_modes

    @property
    def _knows_modes(self) -> bool:
        """Whether the visited modes are named by regimes of the contacts."""
        return all(
            len(self.regimes[mode]) == len(self.stated.contacts) and {*self.regimes[mode]} <= OF_CONTACTS
            for mode in np.unique(self.run.raw.step_modes)
        )

    def _regimes_of(self, i: int, modes: Array) -> Array:
        """The regime of contact `i` in each mode."""
        return np.array([regimes[i] for regimes in self.regimes])[modes]

    # --- what the names of the modes claim

    def claims(self) -> str:
        """The rule that the regimes of a contact state, and the run breaks; an empty text for none."""
        for i, contact in enumerate(self.stated.contacts):
            regimes = self._regimes_of(i, self.samples.modes)
            for rule, amounts in self._amounts(contact, regimes):
                if (amounts > self.limit).any():
                    first = int(np.argmax(amounts > self.limit))
                    return (
                        f"{rule} at contact {i + 1} from t = {self.samples.t[first]:.6g} s on, in the worst "
                        f"case by {amounts.max():.1g} of its size"
                    )
        return ""

    def _amounts(self, contact: StatedContact, regimes: Array) -> Any:
        """Rules and by how much, as shares of sizes, they are broken at the samples."""
        if contact.speed is not None and contact.elastic is None:
            speed = self._share(contact.speed)
            yield "v_r is not zero in stick", np.where(regimes == "stick", np.abs(speed), 0.0)
            if contact.across is not None:
                across = np.abs(self._share(contact.across))
                yield "v_r is not zero in stick", np.where(regimes == "stick", across, 0.0)
            for name, sign in (("slip+", 1), ("slip-", -1)):
                yield f"v_r has not the sign of {name}", np.where(regimes == name, -sign * speed, 0.0)
        if contact.gap is not None:
            gap = self._share(contact.gap)
            in_flight = (regimes == "separation") | (regimes == "flight")
            yield "bodies overlap in flight", np.where(in_flight, -gap, 0.0)
            closed = np.isin(regimes, CLOSED_REGIMES) & contact.rigid
            yield "a closed contact is open", np.where(closed, np.abs(gap), 0.0)
        if contact.pressing is not None and self._separates(contact):
            force, pressed = self._share(contact.pressing), np.isin(regimes, CLOSED_REGIMES)
            yield "the normal force pulls", np.where(pressed, -force, 0.0)
            if contact.gap is not None:
                yield "forces act on a contact that is open", np.where(pressed, gap, 0.0)

    def _separates(self, contact: StatedContact) -> bool:
        """Whether the contact has regimes without forces, so that it does not pull."""
        i, few = self.stated.contacts.index(contact), len(self.stated.contacts) < 4
        return few and bool(regimes_in(self.run.automaton.names, slice(i, i + 1)) & {*APART})

    def _share(self, function: Any) -> Array:
        """A function at the samples as a share of its size: its slopes times the sizes of the states."""
        return self.stated.at(function, self.samples.states) / self._size_of(function)

    # --- Lagrange's equations

    def balance(self) -> str:
        """Lagrange's equations in steps of each mode, with holding forces within their limits."""
        if self.stated.n > MOST_COORDINATES:
            return ""
        places, accelerations, errors = places_within_steps(self.run, self.stated)
        if not len(places.t):
            return ""
        forces = self._forces(places)
        values, rooms, sizes = self.stated.imbalance(places.states, accelerations)
        there = self.stated.imbalance(places.states, accelerations + errors)[0]
        rooms = rooms + np.abs(there - values)
        values, sizes = values - forces.given, sizes + forces.sizes
        for k, mode in enumerate(places.modes):
            scale = np.where(sizes.max(axis=0) > 0.0, sizes.max(axis=0), 1.0)
            solution = held_forces(values[k], forces.at(k), rooms[k], scale)
            if solution.miss > max(LEAST_TOLERANCE, self.limit):
                name = self.run.automaton.state_names[solution.worst]
                why = (
                    "with forces of its contacts within their limits" if solution.bounded else "by any force"
                )
                return (
                    f"at t = {places.t[k]:.6g} s, in mode {self.run.mode_names[mode]!r}, "
                    f"Lagrange's equation of {name!r} is not kept {why}: "
                    f"{solution.miss:.1g} of the forces in it are missing"
                )
        return ""

    def _forces(self, places: Places, slack: float = 0.0) -> Forces:
        """The forces of all contacts, given or holding, at places, with a share less of static friction."""
        shape = len(places.t), self.stated.n
        total, sizes = np.zeros(shape), np.zeros(shape)
        columns, least, most = [], [], []
        for i, contact in enumerate(self.stated.contacts):
            regimes = self._regimes_of(i, places.modes)
            normal = self.stated.normal_direction(contact, places.states)
            closed = regimes == "contact"
            if contact.pressing is not None and contact.speed is None:
                pressing = np.where(closed, self.stated.at(contact.pressing, places.states), 0.0)
                force = pressing[:, None] * normal
                total, sizes = total + force, sizes + np.abs(force)
                continue
            if contact.speed is None:
                columns.append(normal)
                least.append(np.zeros(len(regimes)))
                most.append(np.where(closed, np.inf, 0.0))
                continue
            if contact.rigid:
                for edge, closed in self._cone(contact, regimes, normal, places, slack):
                    columns.append(edge)
                    least.append(np.zeros(len(regimes)))
                    most.append(np.where(closed, np.inf, 0.0))
                continue
            if contact.across is not None:
                for force, direction, largest in self._in_plane(contact, regimes, normal, places, slack):
                    total += force[:, None] * direction
                    sizes += np.abs(force[:, None] * direction)
                    columns.append(direction)
                    least.append(-largest)
                    most.append(largest)
                continue
            at, along = self.stated.at, self.stated.rubbing_direction(contact, places.states)
            open_contact = np.isin(regimes, [*APART, CHATTER_MODE])
            pressing = np.where(open_contact, 0.0, at(contact.pressing, places.states))
            speed, sign = at(contact.speed, places.states), self._signs(contact, regimes, places)
            still = (
                (regimes != "slip")
                & (contact.limit is not None)
                & (np.abs(speed) <= RESTING * self._speed_size(contact, along))
                & ~open_contact
            )
            friction = np.where(sign > 0, *(at(contact.sliding[s], places.states) for s in (1, -1)))
            if contact.elastic is not None:
                signs = np.where(regimes == "slip-", -1, np.where(regimes == "slip+", 1, sign))
                friction = np.where(signs > 0, *(at(contact.sliding[s], places.states) for s in (1, -1)))
                friction = np.where(regimes == "stick", at(contact.elastic, places.states), friction)
            friction = np.where(still | open_contact, 0.0, friction)
            for force, direction in ((pressing, normal), (friction, along)):
                total += force[:, None] * direction
                sizes += np.abs(force[:, None] * direction)
            limit = 0.0 * speed
            if contact.limit is not None:
                limit = np.where(
                    still, (1.0 - slack) * np.maximum(at(contact.limit, places.states), 0.0), 0.0
                )
            columns += [along, normal]
            least += [-limit, 0.0 * limit]
            most += [limit, np.where(regimes == CHATTER_MODE, np.inf, 0.0)]
        if not columns:
            return Forces(total, sizes, np.zeros((shape[0], 0, shape[1])), *np.zeros((2, shape[0], 0)))
        return Forces(total, sizes, np.stack(columns, axis=1), *(np.array(x).T for x in (least, most)))

    def _in_plane(
        self, contact: StatedContact, regimes: Array, normal: Array, places: Places, slack: float
    ) -> Iterator[tuple[Array, Array, Array]]:
        """The normal force and both components of friction of a contact in the plane.

        Given forces (N,), their directions (N, n), and the largest holding forces (N,), where each component
        may be as large as both.
        """
        at, states, stated = self.stated.at, places.states, self.stated
        pressed = np.isin(regimes, CLOSED_REGIMES)
        yield np.where(pressed, at(contact.pressing, states), 0.0), normal, np.zeros(len(regimes))
        holds = np.isin(regimes, ["stick", "breakaway"])  # breakaway has no direction of v_r yet
        limit = np.where(holds, (1.0 - slack) * np.maximum(at(contact.limit, states), 0.0), 0.0)
        share = np.where(regimes == "slip", at(contact.sliding[1], states), 0.0)
        for component, of in (
            (contact.speed, stated.rubbing_direction),
            (contact.across, stated.direction_across),
        ):
            slides = np.where(regimes == "slip", share * at(component, states), 0.0)
            yield slides, of(contact, states), limit

    def _cone(
        self, contact: StatedContact, regimes: Array, normal: Array, places: Places, slack: float
    ) -> list[tuple[Array, Array]]:
        """The edges (N, n) of a rigid contact's friction cone, and where the force has a part along each.

        In slip its force is along one of them, whose angle is that of kinetic friction.
        """
        at, along = self.stated.at, self.stated.rubbing_direction(contact, places.states)
        speed, sign = at(contact.speed, places.states), self._signs(contact, regimes, places)
        closed = np.isin(regimes, CLOSED_REGIMES)
        resting = (regimes != "slip") & (np.abs(speed) <= RESTING * self._speed_size(contact, along))
        still = closed & (resting | (regimes == "stick"))
        edges = []
        for side in (1, -1):
            limit = (1.0 - slack) * side * at(contact.limit, places.states)
            share = np.where(still, limit, at(contact.sliding[side], places.states))
            edges.append((normal + share[:, None] * along, still | (closed & (sign == side))))
        return edges

    def _speed_size(self, contact: StatedContact, along: Array) -> float:
        n = self.stated.n
        moving = float((np.abs(along) * self.stated.sizes[n : 2 * n]).sum(axis=1).max(initial=0.0))
        some = self.samples.states[:: max(1, len(self.samples.t) // 50)]
        return max(moving, float(np.abs(self.stated.at(contact.speed, some)).max(initial=0.0)))

    def _signs(self, contact: StatedContact, regimes: Array, places: Places) -> Array:
        """The direction of slip: that of v_r, or of the belt where sliding keeps its direction."""
        at_rest = places.states.copy()
        at_rest[:, self.stated.n : 2 * self.stated.n] = 0.0
        belt = self.stated.at(contact.speed, np.zeros_like(at_rest))
        # In polar directions v_r at the origin is 0/0.
        belt = np.where(np.isnan(belt), self.stated.at(contact.speed, at_rest), belt)
        return np.where(
            regimes == "slip", np.sign(belt), np.sign(self.stated.at(contact.speed, places.states))
        )

    # --- stick that ends or does not begin

    def breakaway(self) -> str:
        """What leaves stick, or does not enter it, could not have been held."""
        events: Any = self.run.events
        n = self.stated.n
        contacts = self.stated.contacts
        if n > MOST_COORDINATES or not any(c.speed is not None for c in contacts):
            return ""
        if any(c.across is not None for c in contacts):  # the limits of a vector are no linear program
            return ""
        continuous = (events.state[:, : 2 * n] == events.before[:, : 2 * n]).all(axis=1)
        index = {name: k for k, name in enumerate(self.run.mode_names)}
        rows = []
        for e in np.flatnonzero(continuous & (events.source != "") & (events.target != ""))[:MOST_EVENTS]:
            old, new = self.regimes[index[events.source[e]]], self.regimes[index[events.target[e]]]
            pairs = zip(contacts, old, new, strict=True)
            if any(a == "stick" and b in SLIPPING and self._moves(c, e + 1) for c, a, b in pairs):
                rows.append((events.t[e], events.before[e], index[events.target[e]], "leaves stick"))
        first = self.regimes[self.run.raw.step_modes[0]]
        if any(word in SLIPPING and self._moves(c, 0) for word, c in zip(first, contacts, strict=True)):
            rows.append(
                (0.0, self.run.problem.x0, int(self.run.raw.step_modes[0]), "does not start in stick")
            )
        if not rows:
            return ""
        t, states, modes, words = zip(*rows, strict=True)
        places = Places(np.array(t), np.array(states), np.array(modes))
        for k in self._holdable(places):
            return (
                f"at t = {t[k]:.6g} s a contact {words[k]}, though static friction holds it with "
                f"{BREAKAWAY_SLACK:.0%} to spare"
            )
        return ""

    def _moves(self, contact: StatedContact, stay: int) -> bool:
        """Whether v_r becomes other than zero in a stay, of which each but the first begins with an event.

        Of stays of no length it is the next one that lasts.  Of several contacts at rest together some stick,
        and others, which are called slip, stay at rest.
        """
        times = np.concatenate([[0.0], self.run.events.t, [self.run.raw.t]])
        lasting = np.flatnonzero(np.diff(times[stay:]) > 0.0)
        if not len(lasting):
            return False
        stay += int(lasting[0])
        states = self.run(np.linspace(times[stay], times[stay + 1], SAMPLES_OF_STAY))
        speeds = np.abs(self.stated.at(contact.speed, states)) / self._size_of(contact.speed)
        return not speeds.max() <= self.limit  # NaN is no rest

    def _holdable(self, places: Places) -> list[int]:
        """Places at which forces well within their limits hold all velocities that are zero."""
        forces, stated = self._forces(places, BREAKAWAY_SLACK), self.stated
        masses, free = stated.masses(places.states), stated.imbalance(places.states)[0] - forces.given
        rows, rates, resting, at = [], [], [], 0
        for i, contact in enumerate(stated.contacts):
            held = []
            if contact.rigid:
                row = stated.normal_direction(contact, places.states)
                second = lambda z, c=contact: stated.rate_of(c.gap, z)  # noqa: E731  this contact's
                held.append((np.isin(self._regimes_of(i, places.modes), CLOSED_REGIMES), row, second))
            still = np.zeros(len(places.t), dtype=bool)
            if contact.speed is not None:
                # A rigid contact at rest has both edges of its cone, others a friction force.
                still = (forces.most[:, at : at + 1 + contact.rigid] > 0.0).all(axis=1)
                row = stated.rubbing_direction(contact, places.states)
                second = lambda z, c=contact: -stated.at(c.speed, z)  # noqa: E731  this contact's
                held.append((still, row, second))
            for there, row, second in held:
                rate = stated.slope(second, places.states, stated.rates(places.states))[0]
                rows.append(np.where(there[:, None], row, 0.0))
                rates.append(np.where(there, rate, 0.0))
            resting.append(still)
            at += 2 if contact.speed is not None else int(contact.rigid)
        holdable = []
        for k in range(len(places.t)):
            W, inverse = forces.columns[k].T, np.linalg.inv(masses[k])
            J = np.array([row[k] for row in rows])
            limits = forces.least[k], forces.most[k]
            slipping = any(
                word in SLIPPING and resting[i][k] for i, word in enumerate(self.regimes[places.modes[k]])
            )
            # J (M^-1 (W lambda - free)) + rate = 0
            right = J @ inverse @ free[k] - np.array([rate[k] for rate in rates])
            if slipping and can_hold(J @ inverse @ W, right, *limits):
                holdable.append(k)
        return holdable

    # --- impacts

    def impacts(self) -> str:
        """Impacts, of which those at one instant are one."""
        jumps = self._jumps()
        if self.stated.n > MOST_COORDINATES:
            return ""
        terms = self._impact_terms(jumps)
        for k in range(len(jumps.t)):
            if words := self._broken_impact(jumps, terms, k):
                return f"at t = {jumps.t[k]:.6g} s {words}"
        return ""

    def _jumps(self) -> Jumps:
        """The instants at which velocities jump."""
        events: Any = self.run.events
        n = self.stated.n
        begins = np.flatnonzero(np.diff(events.t, prepend=-np.inf) > 0.0)
        ends = np.append(begins[1:], len(events.t))[: len(begins)] - 1
        before, after = events.before[begins], events.before[begins].copy()
        after[:, n : 2 * n] = events.state[ends][:, n : 2 * n]
        least = np.full((len(begins), 1), RESTING)
        if not is_of_series(self.run):  # their last step comes near to |v_r| = 0, not to it
            least[np.char.startswith(events.guard[begins].astype(str), STOP)] = STOP_JUMP
        moves = (np.abs(after - before) > least * self.stated.sizes).any(axis=1)
        some = np.flatnonzero(moves)[:MOST_EVENTS]
        closed = np.array(
            [events.closed[a : b + 1].any() for a, b in zip(begins, ends, strict=True)], dtype=bool
        )
        return Jumps(events.t[begins][some], before[some], after[some], (begins == ends)[some], closed[some])

    def _impact_terms(self, jumps: Jumps) -> list[ImpactTerms]:
        """What each contact that has an impact law needs."""
        rows, stated = [], self.stated
        still = np.zeros_like(jumps.before)
        still[:, 2 * stated.n :] = stated.rates(jumps.before)[:, 2 * stated.n :]
        for i, (contact, law) in enumerate(zip(stated.contacts, self._laws(), strict=True)):
            if contact.gap is None or law is None:
                continue
            gap = contact.gap
            motion = stated.slope(lambda z, g=gap: stated.at(g, z), jumps.before, still)[0]
            share = np.abs(stated.at(gap, jumps.before)) / self._size_of(gap)
            normal = stated.normal_direction(contact, jumps.before)
            along, belt = None, 0.0 * motion
            if contact.speed is not None and type(law).friction is not ImpactLaw.friction:
                along = stated.rubbing_direction(contact, jumps.before)
                resting = jumps.before.copy()
                resting[:, stated.n : 2 * stated.n] = 0.0
                belt = stated.at(contact.speed, resting)
            rate = stated.rate_of(gap, jumps.before)
            terms = normal, along, motion, belt, rate, contact.normal is None
            rows.append(ImpactTerms(i, law, share <= CLOSED, *terms))
        return rows

    def _laws(self) -> list[Any]:
        """The impact laws of all contacts, with numbers."""
        model, start = self.run.source, self.run.problem.x0[: len(self.run.names)].tolist()
        n, further = self.stated.n, len(model.states)
        others = start[
            2 * n : 2 * n + len(self.stated.statement.others)
        ]  # without the states of friction laws
        values = dict(zip(self.run.names, start))
        clocks = (values.get(name, 0.0) for name in (PHASE, TIME))
        phase, time = clocks
        about = mechanics_at(model, start[:n], start[n : 2 * n], phase, others[len(others) - further :], time)
        laws = [c.law if isinstance(c, Stop) else c.impact for c in about.contacts]
        return [None if law is None else law.reduced() for law in laws]

    def _broken_impact(self, jumps: Jumps, terms: list[ImpactTerms], k: int) -> str:
        n, before, after = self.stated.n, jumps.before[k], jumps.after[k]
        change = (self.stated.momenta(after[None]) - self.stated.momenta(before[None]))[0]
        closed = [one for one in terms if one.closed[k]]
        pairs = [(one, one.normal[k], 0.0) for one in closed]
        pairs += [(one, one.along[k], -np.inf) for one in closed if one.along is not None]
        columns = np.array([column for _, column, _ in pairs]).reshape(-1, n).T
        floor = self.limit * self._momentum_size(before)
        size = float(np.abs(change).max()) + floor / IMPACT_RTOL
        impulses = np.linalg.lstsq(columns, change)[0] if pairs else np.zeros(0)
        if np.abs(columns @ impulses - change).max() > IMPACT_RTOL * size:
            return "velocities jump where no contact is closed that has an impact"
        least = np.array([low for *_, low in pairs])
        allowed = IMPACT_RTOL * np.abs(impulses).max() + floor / np.maximum(
            np.abs(columns).max(axis=0), 1e-300
        )
        if (impulses < least - allowed).any():
            from scipy.optimize import lsq_linear

            impulses = lsq_linear(columns, change, (least - 1e-300, np.inf), tol=1e-14).x
            if np.abs(columns @ impulses - change).max() > IMPACT_RTOL * size:
                return "an impact pulls"
        acting = [j for j, one in enumerate(closed) if impulses[j] > allowed[j]]
        if all(closed[j].conservative for j in acting) and (
            words := self._broken_energy(jumps, pairs, impulses, acting, change, floor, k)
        ):
            return words
        if len(closed) == 1 and jumps.single[k] and closed[0].along is None:
            return self._broken_law(closed[0], jumps, k, float(impulses[0]), float(allowed[0]))
        return ""

    def _broken_energy(
        self,
        jumps: Jumps,
        pairs: Any,
        impulses: Array,
        acting: list[int],
        change: Array,
        floor: float,
        k: int,
    ) -> str:
        """Whether impulses do work on the bodies and on the grounds, stops and belts that move, or take
        energy where all laws are elastic."""
        n, before, after = self.stated.n, jumps.before[k], jumps.after[k]
        carried = sum(
            impulse * (one.moved[k] if low == 0.0 else -one.belt[k])
            for impulse, (one, _, low) in zip(impulses, pairs, strict=True)
        )
        work = change @ (0.5 * (before + after)[n : 2 * n]) + carried
        speeds = (np.abs(before) + np.abs(after) + self.stated.sizes)[n : 2 * n]
        room = IMPACT_RTOL * float(np.abs(change) @ speeds) + floor * float(speeds.max())
        if work > room:
            return f"an impact gives the energy {work:.3g} J, and takes none"
        laws = [pairs[j][0].law for j in acting]
        elastic = all(isinstance(law, RestitutionImpact) and law.e == 1 for law in laws)
        if elastic and all(pairs[j][0].along is None for j in acting) and work < -room:
            return f"an elastic impact takes the energy {-work:.3g} J"
        return ""

    def _momentum_size(self, state: Array) -> float:
        n, masses = self.stated.n, self.stated.masses(state[None])[0]
        return float((np.abs(masses) @ self.stated.sizes[n : 2 * n]).max())

    def _broken_law(self, one: ImpactTerms, jumps: Jumps, k: int, impulse: float, room: float) -> str:
        """Whether the impulse of a single contact is that of its law, or of the impact that closes an
        accumulation."""
        n = self.stated.n
        inverse = np.linalg.inv(self.stated.masses(jumps.before[k][None])[0])
        soft, full = one.normal[k] @ inverse @ one.normal[k], -one.before[k]
        material = -one.normal[k] @ jumps.before[k, n : 2 * n] - one.moved[k]
        laws = (one.law, PlasticImpact("full")) if jumps.closed[k] else (one.law,)
        allowed = [float(law.impulse(material, full, soft)) for law in laws]
        if min(abs(impulse - each) for each in allowed) <= room:
            return ""
        return (
            f"an impact of contact {one.number + 1} is not that of its law: the impulse is {impulse:.6g} N s "
            f"instead of {allowed[0]:.6g} N s"
        )

    def _size_of(self, function: Any) -> float:
        some = self.samples.states[:: max(1, len(self.samples.t) // 50)]
        size = np.abs(self.stated.at(function, some)).max(initial=0.0)
        for i in range(len(self.stated.sizes)):
            along = np.zeros_like(some)
            along[:, i] = self.stated.sizes[i]
            slope = self.stated.slope(lambda z: self.stated.at(function, z), some, along)[0]
            size = max(size, float(np.abs(slope).max(initial=0.0)))
        return size or 1.0
