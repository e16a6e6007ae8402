"""A model's energies, loads and contacts as a hybrid automaton, by Lagrange's equations.

M q'' = r + sum of W F, where r is what energies, dampers and loads give and F are the forces of the contacts.
A contact that holds a velocity at zero gives the force that keeps it there; several are solved for at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import product
from types import SimpleNamespace
from typing import Any

import sympy

from frictionlab.automaton import Event, HybridAutomaton, Mode, Reset
from frictionlab.automaton.on_demand import ModesOnDemand, Sketch

from .mechanics import Friction, Mechanics, Stop
from .regimes import CLOSING, PHASE, End, Regime, rate_after, regimes
from .symbols import multiplied_out, symbol

JOINT = " | "  # between the regimes of several contacts in a mode's name


@dataclass(frozen=True, eq=False)
class System:
    """Lagrange's equations of a model: M q'' = r + W F."""

    mechanics: Mechanics
    q: tuple[Any, ...]
    v: tuple[Any, ...]
    mass: Any
    internal: tuple[Any, ...]
    loads: tuple[Any, ...]

    @cached_property
    def inverse(self) -> Any:
        """M^-1."""
        return self.mass.inv()

    @cached_property
    def combinations(self) -> dict[str, tuple[Regime, ...]]:
        """All combinations of regimes by their names, but those in which two contacts hold one velocity."""
        each = [regimes(contact, self.rate) for contact in self.mechanics.contacts]
        return {name_of(chosen): chosen for chosen in product(*each) if _independent(self, chosen)}

    @property
    def phase(self) -> tuple[Any, ...]:
        """The phase as a state, where something depends on time."""
        return () if self.mechanics.frequency is None else (symbol(PHASE),)

    def rate(self, expression: Any) -> Any:
        """Derivative by time of a function of coordinates and phase."""
        pairs = [*zip(self.q, self.v, strict=True), *((x, self.mechanics.frequency) for x in self.phase)]
        return sum((sympy.diff(expression, x) * rate for x, rate in pairs), sympy.S.Zero)

    def direction(self, contact: Friction | Stop) -> Any:
        """W: where the contact's force enters, (n, 1)."""
        if isinstance(contact, Friction):
            return -sympy.Matrix([sympy.diff(contact.relative_velocity, rate) for rate in self.v])
        return sympy.Matrix([sympy.diff(contact.distance, x) for x in self.q])

    def pressed(self, contact: Friction | Stop, regime: str) -> Any:
        """W_N: where the normal force of a contact that may be lost enters, -grad gap, (n, 1)."""
        if isinstance(contact, Stop) or contact.gap is None or regime == "separation":
            return sympy.zeros(len(self.q), 1)
        return -sympy.Matrix([sympy.diff(contact.gap, x) for x in self.q])


def normal_force(contact: Friction | Stop) -> Any:
    """F_N of a contact with friction; that of a stop is what holds it."""
    return contact.normal_force if isinstance(contact, Friction) else 0


def system(model: Any) -> System:
    """Lagrange's equations of a symbolic copy of a model."""
    names = model.coordinates
    q, v = (tuple(symbol(name + prime) for name in names) for prime in ("", "'"))
    at = SimpleNamespace(**dict(zip(names, q, strict=True)), phase=symbol(PHASE))
    about = model.mechanics(at, SimpleNamespace(**dict(zip(names, v, strict=True))))
    momenta = [sympy.diff(about.kinetic, rate) for rate in v]
    mass = sympy.Matrix(momenta).jacobian(v)
    turning = sympy.Matrix(momenta).jacobian(q) * sympy.Matrix(v)
    slopes = [sympy.diff(about.potential - about.kinetic, x) for x in q]
    damping = [sympy.diff(about.dissipation, rate) for rate in v]
    internal = tuple(map(sympy.factor_terms, map(sum, zip(turning, slopes, damping, strict=True))))
    loads = tuple(sympy.sympify(about.loads.get(name, 0)) for name in names)
    return System(about, q, v, mass, internal, loads)


def derived(model: Any) -> HybridAutomaton:
    """States and modes of a symbolic copy of a model, one mode for each combination of regimes.

    Several contacts have many combinations, of which a run visits few: each is derived once it is asked for.
    """
    found = system(model)
    chosen, states = found.combinations, (*found.q, *found.v, *found.phase)
    if len(found.mechanics.contacts) > 1:
        sketches = (_sketch(name, some, len(states)) for name, some in chosen.items())
        modes: Any = ModesOnDemand(sketches, lambda name: _mode(found, chosen[name]))
    else:
        modes = tuple(_mode(found, some) for some in chosen.values())
    return HybridAutomaton(states, modes, {}, len(found.q))


def _sketch(name: str, chosen: Sequence[Regime], states: int) -> Sketch:
    """What can be said without solving for forces: sticking needs v_r = 0, sliding v_r of its sign."""
    needs: list[Any] = []
    for regime in chosen:
        if regime.force is None:
            needs += [sign * c for c in regime.constraints for sign in (1, -1)]
        else:
            needs += [end.function for end in regime.ends(regime.force)]
    held = any(regime.held is not None for regime in chosen)
    return Sketch(name, (sympy.S.Zero,) * states, constraints=tuple(needs), held=held)


def name_of(chosen: Sequence[Regime | str]) -> str:
    """The mode's name: that of its regime, or of all of them."""
    return JOINT.join(r if isinstance(r, str) else r.name for r in chosen) or "only"


def _independent(found: System, chosen: Sequence[Regime]) -> bool:
    held = [regime.held for regime in chosen if regime.held is not None]
    rows = tuple(tuple(sympy.diff(velocity, v) for v in found.v) for velocity in held)
    return len(rows) < 2 or _rank(rows) == len(rows)


@lru_cache(maxsize=256)  # one for many combinations
def _rank(rows: tuple[tuple[Any, ...], ...]) -> int:
    return sympy.Matrix(rows).rank()


def solved(found: System, chosen: Sequence[Regime]) -> tuple[list[Any], list[Any]]:
    """Accelerations, and the force of each contact."""
    inverse, contacts = found.inverse, found.mechanics.contacts
    free = sympy.Matrix([load - rest for load, rest in zip(found.loads, found.internal, strict=True)])
    directions = [found.direction(contact) for contact in contacts]
    for contact, w, regime in zip(contacts, directions, chosen, strict=True):
        free += w * (0 if regime.force is None else regime.force)
        free += found.pressed(contact, regime.name) * normal_force(contact)
    held = [i for i, regime in enumerate(chosen) if regime.force is None]
    forces = [regime.force for regime in chosen]
    if not held:
        return list(inverse * free), forces
    rows = sympy.Matrix([[sympy.diff(chosen[i].held, rate) for rate in found.v] for i in held])
    along = sympy.Matrix([found.rate(chosen[i].held) for i in held]) + rows * inverse * free
    columns = sympy.Matrix.hstack(*(directions[i] for i in held))
    holding = (rows * inverse * columns).LUsolve(-along)
    for i, force in zip(held, holding, strict=True):
        forces[i] = multiplied_out(force)
    # Expanded, what cancels is gone: a held velocity keeps its value to the last bit.
    return [multiplied_out(a) for a in inverse * (free + columns * holding)], forces


def _mode(found: System, chosen: Sequence[Regime]) -> Mode:
    accelerations, forces = solved(found, chosen)
    name = name_of(chosen)
    events = [
        _event(found, chosen, i, end) for i, regime in enumerate(chosen) for end in regime.ends(forces[i])
    ]
    clock = [found.mechanics.frequency for _ in found.phase]
    events += [
        Event("period", 2 * sympy.pi - phase, (name,), Reset({phase: phase - 2 * sympy.pi}))
        for phase in found.phase
    ]
    constraints = tuple(c for regime in chosen for c in regime.constraints)
    outputs = _outputs(found, chosen, forces)
    return Mode(name, (*found.v, *accelerations, *clock), tuple(events), constraints, outputs)


def _event(found: System, chosen: Sequence[Regime], i: int, end: End) -> Event:
    names, known = [regime.name for regime in chosen], found.combinations
    targets = (name_of([*names[:i], target, *names[i + 1 :]]) for target in end.targets)
    targets = tuple(target for target in targets if target in known)
    contact, label = found.mechanics.contacts[i], end.name + number(found, i)
    if isinstance(contact, Stop) and end.jump == "impact":
        resets = (_impact(found, contact, law) for law in (contact.law, CLOSING))
        return Event(label, end.function, targets, *resets)
    reset = _projection(found, contact) if end.jump == "project" else Reset()
    return Event(label, end.function, targets, reset)


def number(found: System, i: int) -> str:
    """What tells the contacts apart where there are several: _1, _2 ..."""
    return f"_{i + 1}" if len(found.mechanics.contacts) > 1 else ""


def _kick(found: System, w: Any, impulse: Any) -> dict[Any, Any]:
    """M dv = W p: the velocities that jump, after the impulse p."""
    change = found.inverse * w
    return {rate: rate + part * impulse for rate, part in zip(found.v, change, strict=True) if part != 0}


def compliance(found: System, w: Any) -> Any:
    """W^T M^-1 W (1/kg)."""
    return (w.T * found.inverse * w)[0]


def _projection(found: System, contact: Any) -> Reset:
    """v_r = 0 by an impulse along W: it removes only the rounding of the root."""
    w = found.direction(contact)
    jump = _kick(found, w, contact.relative_velocity / compliance(found, w))
    return Reset({rate: multiplied_out(after) for rate, after in jump.items()})


def _impact(found: System, contact: Stop, law: Any) -> Reset:
    """The impulse of an impact law; the distance is zero there, its rate if the law makes it so."""
    w, rate = found.direction(contact), found.rate(contact.distance)
    impulse = law.impulse(-rate, -rate, compliance(found, w))
    order = 2 if rate_after(law, symbol("rate")) == 0 else 1
    # The place is put right as well, which removes only the rounding of the root: what comes to rest on the
    # stop is on it to the last bit.
    moved = zip(found.q, found.inverse * w * (contact.distance / compliance(found, w)), strict=True)
    placed = {x: multiplied_out(x - change) for x, change in moved if change != 0}
    kicked = {v: multiplied_out(after) for v, after in _kick(found, w, impulse).items()}
    return Reset({**placed, **kicked}, {contact.distance: order})


def _outputs(found: System, chosen: Sequence[Regime], forces: Sequence[Any]) -> dict[str, Any]:
    outputs = {}
    for i, (contact, regime, force) in enumerate(zip(found.mechanics.contacts, chosen, forces, strict=True)):
        outputs |= {name + number(found, i): value for name, value in _quantities(contact, regime, force)}
    return outputs


def _quantities(contact: Friction | Stop, regime: Regime, force: Any) -> Any:
    if isinstance(contact, Stop):
        return ("distance", contact.distance), ("reaction", force)
    normal = sympy.S.Zero if regime.name == "separation" else contact.normal_force
    shown = (
        ("normal_force", normal),
        ("friction_force", force),
        ("relative_velocity", contact.relative_velocity),
    )
    return shown if contact.gap is None else (("gap", contact.gap), *shown)
