"""`Model`, the base of all models: one namespace of parameters, copies with changes, an automaton.

Also what a study needs of its subject, which may be a model or an automaton: values of parameters by name,
copies with others (`replace` of both), the automaton, and data that a file can hold.
"""

from __future__ import annotations

import inspect
import sys
from collections.abc import Mapping, Sequence
from dataclasses import FrozenInstanceError, dataclass, replace
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Self, TypeAlias, TypeVar

from frictionlab.automaton import HybridAutomaton
from frictionlab.components.component import (
    Component,
    Parameter,
    StructureKey,
    inherited_fields,
    is_decorated,
    parameter_of_field,
    parameters_of,
    value_repr,
)
from frictionlab.letters import symbol_of
from frictionlab.models.mechanical.mechanics import SlidingStatics
from frictionlab.presentation import PHASE, TIME, is_angle
from frictionlab.validation import abbreviate, unknown_parameter

from .composition import (
    Nonlinearity,
    ParameterTable,
    check_component,
    is_number_of_class,
    model_signature,
    nonlinearities_of,
    owner_hint,
    parameter_owners,
    parameter_table,
    parameters_of_model,
    refuse_positional,
    refuse_unknown,
    roles_of,
    structural_defaults,
    structural_fields,
    structural_values,
    with_values,
    without,
)
from .mechanism import Mechanism
from .serialisation import component_from_dict, component_to_dict, loaded_class

if TYPE_CHECKING:
    from frictionlab.models.equations import Equations

M = TypeVar("M", bound="Model")
AUTOMATON, REST, PROBLEM = "_automaton", "_state_at_rest", "_equilibrium_problem"
# What a model notes of itself, as it never changes.
NOTES = AUTOMATON, REST, PROBLEM, "structure_key", "components", "parameters", "nonlinearities"
PITCH = 200.0  # Hz: pitch at which an oscillation is played
MAKE_ONE = "make one, such as fl.SliderOnBelt()"


class Tone(NamedTuple):
    """The quantity of a model that is played as sound, and how many times faster than the motion."""

    signal: str
    pitch: float


class MovingSystem:
    """Base of what is no model and has coordinates, parameters and an automaton, as a structure has."""

    if TYPE_CHECKING:
        coordinates: Any
        parameters: Any
        period: Any
        units: Any

    def automaton(self) -> HybridAutomaton:
        """The hybrid automaton."""
        raise NotImplementedError

    def near_equilibrium(self) -> Any:
        """The state for ``x0="near"`` of :func:`frictionlab.simulate`."""
        raise NotImplementedError

    def states_of_laws(self) -> Any:
        """What is known of states of friction laws where a run begins, as `StatesOfLaws`."""
        raise NotImplementedError

    def eigenvalue_derivatives(self, value: complex) -> Mapping[str, complex]:
        """Derivatives of an eigenvalue at the equilibrium by parameters that the automaton has as numbers."""
        return {}

    def energy_balance(self, automaton: HybridAutomaton, mode_names: Sequence[str]) -> Any:
        """Energies and powers along a run with these modes, for :func:`frictionlab.energy_audit`."""
        raise NotImplementedError

    def replace(self, **changes: Any) -> Self:
        """The same with other values of parameters."""
        raise NotImplementedError

    def to_dict(self) -> dict[str, Any]:
        """The system as data that JSON can hold."""
        raise NotImplementedError

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Self:
        """The system that :meth:`to_dict` described."""
        raise NotImplementedError


@dataclass(frozen=True, init=False, repr=False)
class Model(Component):
    """Base of the models: a frozen composition of parameters and components.

    The constructor takes the components and all parameters, the model's own and those of its components, as
    keywords.

    **A model of your own** is a class decorated with :func:`~frictionlab.model`, that has

    * its parameters: ``m: float = 1.0``, or :func:`~frictionlab.parameter`, which adds unit, symbol, meaning
      and range;
    * its laws: ``friction: fl.FrictionLaw = fl.Stribeck()``.  The annotation is the kind of law that may take
      the place (its *role*), and the parameters of the law are parameters of the model.  All other fields
      belong to the structure, on which the equations depend: a number of masses, the name of a variant;
    * `coordinates`: the names of its n coordinates;
    * either :meth:`~frictionlab.models.MechanicalModel.mechanics` (derive from
      :class:`~frictionlab.models.MechanicalModel`): energies and contacts, from which modes and equations
      follow, and `states`, the names of further states, if it has any; or :meth:`derive`: the automaton
      itself, whose states are the coordinates, their velocities (named with a prime), and further states.

    A class that derives from a model has all of this, and states what is different.  A default set anew, as
    ``m = 2.0``, keeps unit, symbol, meaning, bounds and range.  A new parameter stands behind the one that it
    follows in the class.

    It may have `reference` (its source), `period` (the approximate period of an oscillation; pictures show a
    multiple of it), :meth:`release` (where a run from rest begins), `mechanism` (its picture),
    `nonlinearities` (those that can be switched off), `sound` and `statics`.  Everything else then works:
    `simulate`, `eigenvalues`, `bifurcation`, `explore`, `plot_run`, files; with energies `energy_audit`, with
    a mechanism `animate` and `watch`.

    Plots and checks recognise the modes "stick", "slip+", "slip-", "separation" and the outputs
    "penetration", "normal_force", "friction_force", "relative_velocity" by these names.  Steady sliding is
    searched for in the modes without constraints.

    Examples
    --------
    >>> import frictionlab as fl
    >>> @fl.model
    ... class Pendulum(fl.MechanicalModel):
    ...     l: float = 1.0
    ...     coordinates = ("phi",)
    ...
    ...     def mechanics(self, q, v):
    ...         height = self.l * (1 - fl.functions.cos(q.phi))
    ...         return fl.Mechanics(kinetic=(self.l * v.phi) ** 2 / 2, potential=9.81 * height)
    >>> Pendulum(l=2.0).equations("only")
    only:
    l**2*Derivative(phi(t), (t, 2)) + 9.81*l*sin(phi(t)) = 0
    """

    roles: ClassVar[Mapping[str, type]] = MappingProxyType({})
    reference: ClassVar[str] = ""
    statics: ClassVar[SlidingStatics | None] = None
    __signature__: ClassVar[inspect.Signature]

    def __new__(cls, *unnamed: Any, **given: Any) -> Self:
        """Refuse a class with fields that is not decorated: its parameters and laws would not be known."""
        if not is_decorated(cls):
            raise TypeError(
                f"{cls.__name__} has fields that are not known as parameters: write @fl.model above it"
            )
        for kind in cls.__mro__[: cls.__mro__.index(Model)]:  # the constructor of a dataclass is inherited
            if "__dataclass_fields__" in vars(kind) and "__signature__" not in vars(kind):
                raise TypeError(
                    f"{kind.__name__} must take parameters of laws: write @fl.model in place of @dataclass"
                )
        return super().__new__(cls, *unnamed, **given)

    def __init__(self, *unnamed: Any, **given: Any) -> None:
        cls = type(self)
        refuse_positional(unnamed, cls)
        components = {
            role: check_component(role, base, given.pop(role, getattr(cls, role)))
            for role, base in self.roles.items()
        }
        structure = structural_values(cls, given)
        owner = parameter_owners(cls, components)
        refuse_unknown(given, cls, owner, components)
        for name, value in structure.items():
            object.__setattr__(self, name, value)
        for name, about in parameters_of(cls).items():
            object.__setattr__(self, name, given.get(name, about.default))
        for role, component in components.items():
            values = {name: value for name, value in given.items() if owner[name] == role}
            object.__setattr__(self, role, with_values(component, values))
        self.__post_init__()

    if TYPE_CHECKING:  # a model may state these as properties, or as plain attributes of its class
        coordinates: ClassVar[Any]
        period: ClassVar[Any]
    else:

        @property
        def coordinates(self) -> tuple[str, ...]:
            """Names of the coordinates."""
            raise NotImplementedError(f"{type(self).__name__} must define coordinates")

        @property
        def period(self) -> float | None:
            """Approximate period of an oscillation, s: pictures and explorers show multiples of it.

            None where it is to be found in the motion.
            """
            return None

    def release(self) -> Mapping[str, float]:
        """The states that are not zero when a run starts from rest, by name."""
        return {}

    def derive(self) -> HybridAutomaton:
        """The automaton without parameter values.

        Called once for every structure, on a copy of the model whose parameters are sympy symbols:
        ``self.mu_k`` is one, and ``self.friction`` a law whose parameters are.  The automaton's states are
        symbols made with ``frictionlab.models.symbols.symbol``.
        """
        raise NotImplementedError(f"{type(self).__name__} must define derive()")

    def check(self) -> None:
        """Raise ValueError if two of the names that become symbols are one."""
        if isinstance(self.coordinates, str):  # its letters are no names
            raise ValueError(
                f"coordinates must be a tuple of names, got the text {self.coordinates!r}: write "
                f"coordinates = ({self.coordinates!r},)"
            )
        for name in self.coordinates:
            if name in (PHASE, TIME) or self.coordinates.count(name) > 1:
                raise ValueError(
                    f"coordinates must have different names, and none of {PHASE!r} and {TIME!r}, "
                    f"got {name!r}: rename it"
                )
        for name in (*self.coordinates, PHASE, "chatter"):  # the last is the solver's
            if name in self.parameters:
                like = "like the solver's limit" if name == "chatter" else "like the coordinate"
                raise ValueError(f"a parameter must not be named {like} {name!r}: rename it")

    @cached_property
    def components(self) -> Mapping[str, Component]:
        """Role -> component."""
        return MappingProxyType({role: getattr(self, role) for role in self.roles})

    @cached_property
    def parameters(self) -> Mapping[str, float]:
        """Name -> value of every parameter (SI units), read-only; change them with :meth:`replace`."""
        parts = (self, *self.components.values())
        return MappingProxyType(
            {name: getattr(part, name) for part in parts for name in parameters_of(type(part))}
        )

    def replace(self, **changes: Any) -> Self:
        """A new model with other parameters or components.

        A new component comes with its own parameters; parameters named as well overwrite them.

        Raises
        ------
        TypeError
            For an unknown name.
        ValueError
            For a value that breaks a rule.
        """
        names = (*parameters_of(type(self)), *structural_fields(type(self)))
        own = {name: getattr(self, name) for name in names}
        return type(self)(**{**own, **self.components, **changes})

    def without(self, *names: str) -> Self:
        """The model without some of its :attr:`nonlinearities`.

        Parameters
        ----------
        *names : str
            For a SliderOnBelt "cubic", "nonsmooth" and "geometry": LinearContact with the same k2,
            SlidingOnly and FixedLoad take the places of its components.

        Raises
        ------
        ValueError
            For any other name, and for "cubic" where the contact law has no k2.
        """
        return self.replace(**without(self, names))

    @property
    def sound(self) -> Tone | None:
        """What `listen` plays: v_r, or the first coordinate's velocity, at 200 Hz for one `period`.

        None where no period is stated.
        """
        return None if self.period is None else tone_of(self.automaton(), self.period)

    @property
    def mechanism(self) -> Mechanism | None:
        """The mechanism for `animate` and `watch`; None where the model has none."""
        return None

    @cached_property
    def nonlinearities(self) -> Mapping[str, Nonlinearity]:
        """The nonlinearities that can be switched off, by name, in `without`, `ablation` and `explore`.

        They follow from the kinds of the components; a model of your own may have others.
        """
        return MappingProxyType(nonlinearities_of(self))

    def outputs_of_events(self, events: Any, states: Any) -> Mapping[str, Any]:
        """What `run.events` has besides states, such as impulses: columns (E,) by their names; here none.

        `states` (N, states) are those of the run's samples.
        """
        return {}

    def describe(self) -> ParameterTable:
        """Table of the parameters: symbol, value, unit, meaning."""
        return parameter_table(self)

    def automaton(self) -> HybridAutomaton:
        """The hybrid automaton; models that differ only in parameter values share its `modes` object.

        Raises
        ------
        ValueError
            Where a law has no real value, a mass is not above 0, a damper or a given normal force is below 0,
            borders of a law in pieces do not ascend, or an energy jumps at one, at the values of parameters.
        """
        if AUTOMATON not in vars(self):  # once for each model, as it never changes
            from .automaton_of_model import automaton_of_model

            self._check_mechanics()
            vars(self)[AUTOMATON] = automaton_of_model(self)
        return vars(self)[AUTOMATON]

    @cached_property
    def structure_key(self) -> StructureKey:
        """Its structure as it was when first asked for: a model never changes."""
        return super().structure_key

    def _check_mechanics(self) -> None:
        """Raise ValueError where masses or contacts are impossible at the values of the parameters."""

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in vars(self).items() if name not in NOTES}

    @property
    def rotational_outputs(self) -> tuple[str, ...]:
        """Outputs of contacts whose bodies turn: they are in rad, rad/s and N m in place of m, m/s and N."""
        from .automaton_of_model import rotational_outputs_of

        return rotational_outputs_of(self.structure_key) if any(map(is_angle, self.coordinates)) else ()

    @property
    def turning_roles(self) -> Mapping[str, bool]:
        """Roles of the laws of contacts whose bodies turn, and whether they serve no others.

        Nothing tells which contacts of an automaton of one's own a law serves.
        """
        return {}

    def equations(self, mode: str) -> Equations:
        """The equations of a mode as sympy equations; LaTeX in a notebook.

        Raises
        ------
        ValueError
            If the model has no such mode.
        """
        from frictionlab.models.equations import flow_equations

        return flow_equations(self, mode)

    def to_dict(self) -> dict[str, Any]:
        """The model as data that JSON can hold."""
        return component_to_dict(self)

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Self:
        """The model that :meth:`to_dict` described.

        Raises
        ------
        ValueError
            If the data is malformed, or a law of your own is not defined in this session.
        """
        return component_from_dict(data, cls)

    def __getattr__(self, name: str) -> Any:
        # Called for a component's parameter, as model.mu_k, and where a property raises AttributeError.
        if not name.startswith("_"):
            for role in type(self).roles:
                component = self.__dict__.get(role)
                if component is not None and name in parameters_of(type(component)):
                    return getattr(component, name)
        if hasattr(type(self), name):  # a property failed: its error says why
            return object.__getattribute__(self, name)
        raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self.parameters]

    def __repr__(self) -> str:
        given = ", ".join(f"{name}={value_repr(value)}" for name, value in differences(self).items())
        return f"{type(self).__name__}({given})"


ModelOrAutomaton: TypeAlias = Model | MovingSystem | HybridAutomaton  # the subject of a study


def model(cls: type[M]) -> type[M]:
    """Make a class a model: fields that are numbers are parameters, annotations of laws are roles.

    Parameters
    ----------
    cls : type
        A class derived from :class:`MechanicalModel`, or from :class:`Model`, which says what it needs.

    Returns
    -------
    type
        The same class as a frozen dataclass.  Its constructor takes laws and all parameters, also those of
        the laws, as keywords; help and tab completion show them.

    Raises
    ------
    TypeError
        If `cls` is no such class, or where a law has no default, or an annotation that is not known there.

    Examples
    --------
    >>> import frictionlab as fl
    >>> @fl.model
    ... class Popp(fl.MechanicalModel):
    ...     m: float = 1.0
    ...     k: float = 1.0
    ...     v: float = 0.2
    ...     friction: fl.FrictionLaw = fl.Stribeck()
    ...     coordinates = ("x",)
    ...
    ...     def mechanics(self, q, v):
    ...         contact = fl.Friction(self.v - v.x, 9.81 * self.m, self.friction)
    ...         return fl.Mechanics(self.m * v.x**2 / 2, self.k * q.x**2 / 2, contacts=(contact,))
    >>> Popp(mu_k=0.4, m=2.0)
    Popp(m=2.0, mu_k=0.4)
    """
    if not (isinstance(cls, type) and issubclass(cls, Model)):
        raise TypeError(
            f"fl.model is for classes of models, got {abbreviate(cls)}: write class Mine(fl.MechanicalModel)"
        )
    if "__dataclass_params__" in vars(cls):
        raise TypeError(
            f"fl.model is written once above a class, got {cls.__name__}, which is a model: leave it"
        )
    inherited = inherited_fields(cls)
    cls = dataclass(frozen=True, init=False, repr=False)(cls)
    _tell_of_replace(cls)
    _order_parameters(cls, inherited)
    for name in parameters_of(cls):
        if name != "period" and not is_number_of_class(cls, name):
            raise TypeError(
                f"a parameter of {cls.__name__} must not be named like the model's own {name!r}: rename it"
            )
    where = sys._getframe(1)
    own = roles_of(cls, {**where.f_globals, **where.f_locals})
    known: Mapping[str, type] = getattr(super(cls, cls), "roles", {})
    cls.roles = MappingProxyType(own | {role: kind for role, kind in known.items() if role not in own})
    cls.__signature__ = model_signature(cls, {role: getattr(cls, role) for role in cls.roles})
    return cls


def _tell_of_replace(cls: Any) -> None:
    """Let the error for a field that is set name what makes another model."""
    set_frozen = cls.__setattr__

    def set_attribute(self: Any, name: str, value: Any) -> None:
        try:
            set_frozen(self, name, value)
        except FrozenInstanceError as error:
            raise FrozenInstanceError(_words_on_setting(self, name, error)) from None

    cls.__setattr__ = set_attribute


def _words_on_setting(model: Model, name: str, error: FrozenInstanceError) -> str:
    try:
        refuse_unknown([name], type(model), model.parameters, model.components)
    except TypeError as unknown:
        return f"{unknown}; and a model never changes"
    return f"{error}: a model never changes, write model = model.replace({name}=...)"


def _order_parameters(cls: type, inherited: Mapping[str, Any]) -> None:
    """Put each new parameter behind the one that it follows in the class; at the end if it follows none."""
    fields, order, last = cls.__dataclass_fields__, list(inherited), ""
    for name in [name for name in vars(cls) if name in fields and parameter_of_field(fields[name])]:
        if name not in inherited:
            order.insert(order.index(last) + 1 if last else len(order), name)
        last = name
    cls.__dataclass_fields__ = {name: fields[name] for name in dict.fromkeys([*order, *fields])}


def require_model(
    model: object,
    kinds: str = "a model such as SliderOnBelt",
    cure: str = MAKE_ONE,
) -> Model:
    """Return the model; raise TypeError, which names the accepted `kinds`, for anything else."""
    if isinstance(model, Model):
        return model
    if isinstance(model, type) and issubclass(model, Model):
        got, cure = f"the class {model.__name__}", f"write {model.__name__}()"
    elif isinstance(model, HybridAutomaton):
        got = "a HybridAutomaton"
        cure = "run it with fl.solve, or return it from derive() of a class of fl.Model"
    else:
        got = abbreviate(model)
    raise TypeError(f"model must be {kinds}, got {got}: {cure}")


def values_of(model: ModelOrAutomaton) -> Mapping[str, float]:
    """The parameters of a model or an automaton by name.

    Raises
    ------
    TypeError
        If it is neither.
    """
    named = isinstance(model, (Model, MovingSystem))
    return model.parameters if named else automaton_of(model).values


def parameters_about(
    model: ModelOrAutomaton, moving_as: ModelOrAutomaton | None = None
) -> Mapping[str, Parameter]:
    """What is known of each parameter of a model by name; of an automaton its symbols' letters and signs.

    `moving_as` is a model that differs in its laws alone, whose automaton is at hand.
    """
    if isinstance(model, Model):
        return parameters_of_model(model, moving_as)
    return {each.name: _about_symbol(each, value) for each, value in automaton_of(model).parameters.items()}


def _about_symbol(given: Any, value: float) -> Parameter:
    about = Parameter(symbol_of(given.name))
    if given.is_positive and value > 0.0:
        return replace(about, exclusive_minimum=0.0)
    return replace(about, minimum=0.0) if given.is_nonnegative and value >= 0.0 else about


def nonlinearities_in(model: ModelOrAutomaton) -> Mapping[str, Nonlinearity]:
    """The nonlinearities of a model that can be switched off; an automaton names none."""
    return model.nonlinearities if isinstance(model, Model) else {}


def roles_in(model: ModelOrAutomaton) -> Mapping[str, type[Any]]:
    """The kind of law of each role of a model; an automaton has none."""
    return model.roles if isinstance(model, Model) else {}


def tone_of(automaton: HybridAutomaton, period: float) -> Tone:
    """A relative velocity, or the first velocity or state, at 200 Hz for one period (s)."""
    heard = next((name for name in automaton.outputs if name.startswith("relative_velocity")), None)
    return Tone(heard or automaton.state_names[automaton.coordinates], float(f"{PITCH * period:.3g}"))


def check_parameter_name(model: ModelOrAutomaton, name: Any) -> None:
    """Raise TypeError, with a suggestion, unless `name` is a parameter of the model or automaton."""
    known = list(values_of(model))
    if not isinstance(name, str) or name not in known:
        hint = owner_hint(name, type(model), model.components) if isinstance(model, Model) else ""
        kind = HybridAutomaton if isinstance(model, HybridAutomaton) else type(model)
        raise unknown_parameter(kind.__name__, name, known, hint)


def check_varied(model: ModelOrAutomaton, name: Any) -> None:
    """Raise ValueError for a parameter on which M of a structure depends, which is a number in its automaton.

    TypeError for what is no parameter.
    """
    check_parameter_name(model, name)
    if name not in automaton_of(model).values:
        raise ValueError(
            f"{name} must not be one on which M of the structure depends, as motions have no derivatives "
            "by it: take fl.sweep or fl.bifurcation, which need none"
        )


def require_model_or_automaton(model: object, cure: str = MAKE_ONE) -> ModelOrAutomaton:
    """Return the model or automaton, or the structure for which it stands; raise TypeError for others."""
    if isinstance(model, HybridAutomaton) and model.source is not None:
        return model.source
    if isinstance(model, (HybridAutomaton, MovingSystem, Model)):
        return model
    return require_model(model, "a model such as SliderOnBelt, a Structure or a HybridAutomaton", cure)


def automaton_of(model: ModelOrAutomaton) -> HybridAutomaton:
    """The automaton of a model, or the automaton itself.

    Raises
    ------
    TypeError
        If it is neither.
    """
    if isinstance(model, HybridAutomaton):
        return model
    known: Any = require_model_or_automaton(model)
    return known.automaton()


def data_of(model: ModelOrAutomaton) -> dict[str, Any]:
    """A model or an automaton as data that JSON can hold: equal ones have equal data.

    That of a class of one's own has a digest of its equations: the class may change until the file is read.

    Raises
    ------
    ValueError
        Where a file cannot hold the automaton.
    """
    from frictionlab.tape.automaton_data import equations_digest, storable_automaton  # imports numpy

    from .kept_structures import is_of_library

    model = require_model_or_automaton(model)  # of an automaton that an explorer shows, its structure
    if isinstance(model, MovingSystem) or (isinstance(model, Model) and is_of_library(model.structure_key)):
        return model.to_dict()
    if isinstance(model, Model):
        return model.to_dict() | {"equations": equations_digest(model.automaton())}
    stored = storable_automaton(model)
    if isinstance(stored, str):
        raise ValueError(
            f"the automaton must be one that a file can hold, got one that it cannot, {stored}: write it "
            "with the functions of fl.functions"
        )
    return {"automaton": stored, "parameters": dict(model.values)}


def model_from_data(data: Mapping[str, Any]) -> ModelOrAutomaton:
    """The model or automaton that :func:`data_of` described.

    Raises
    ------
    ValueError
        If the data is malformed, or a law of your own is not defined in this session.
    """
    if "automaton" not in data:
        kind = loaded_class(data.get("system"), MovingSystem) if "system" in data else Model
        return kind.from_dict(data)
    from .automaton_of_model import automaton_from_stored

    return automaton_from_stored(data["automaton"], data["parameters"], Model)


def differences(model: Model) -> dict[str, Any]:
    """Differences from the defaults: the keywords that recreate the model."""
    structure = {name: getattr(model, name) for name in structural_fields(type(model))}
    defaults = structural_defaults(type(model))
    usual = type(model)(**{name: value for name, value in structure.items() if name not in defaults})
    other = {n: v for n, v in structure.items() if n not in defaults or v != defaults[n]}
    same = {
        role for role, component in model.components.items() if type(component) is type(getattr(usual, role))
    }
    names = parameter_owners(type(model), model.components)
    values = [
        n for n, role in names.items() if not role or (role in same and not _restructured(model, usual, role))
    ]
    moved = {n: model.parameters[n] for n in values if model.parameters[n] != usual.parameters[n]}
    whole = [role for role in model.roles if role not in same or _restructured(model, usual, role)]
    return moved | other | {role: getattr(model, role) for role in whole}


def _restructured(model: Model, usual: Model, role: str) -> bool:
    """Whether a component differs in more than parameters from the usual one, which has the same class."""
    mine, its = getattr(model, role), getattr(usual, role)
    return with_values(its, {n: getattr(mine, n) for n in parameters_of(type(its))}) != mine
