"""`fl.model`: numbers are parameters, annotations of laws are roles."""

import math
from dataclasses import dataclass, replace

import numpy as np
import pytest

import frictionlab as fl
from frictionlab.components.component import parameters_of


@fl.model
class Popp(fl.MechanicalModel):
    """One mass on a belt, in the lines of a textbook."""

    m: float = 1.0
    k: float = 4
    v: float = 0.2
    friction: fl.FrictionLaw = fl.Stribeck()
    coordinates = ("x",)
    period = 3.0

    def mechanics(self, q, v):
        contact = fl.Friction(self.v - v.x, 9.81 * self.m, self.friction)
        return fl.Mechanics(self.m * v.x**2 / 2, self.k * q.x**2 / 2, contacts=(contact,))


class Slower(Popp):
    """Without fields of its own a class needs no decorator."""

    period = 5.0


@fl.model
class Stopped(Popp):
    """With a stop, whose law is another role."""

    d: float = 100.0
    impact: fl.ImpactLaw = fl.RestitutionImpact(e=0.5)

    def mechanics(self, q, v):
        about = super().mechanics(q, v)
        contacts = (*about.contacts, fl.Stop(self.d - q.x, self.impact))
        return fl.Mechanics(about.kinetic, about.potential, contacts=contacts)


def test_numbers_are_parameters_and_annotations_of_laws_are_roles():
    assert dict(Popp.roles) == {"friction": fl.FrictionLaw, "interface": fl.Interface}
    assert list(Popp().parameters) == ["m", "k", "v", "mu_k", "mu_s", "v_s", "mu_v"]
    assert Popp().k == 4.0
    assert repr(Popp(m=2, mu_k=0.5)) == "Popp(m=2.0, mu_k=0.5)"
    assert Popp(friction=fl.Coulomb()).replace(mu_s=1.0, m=3).parameters["mu_s"] == 1.0
    assert isinstance(Slower(m=2.0), Popp)
    assert Slower.roles is Popp.roles


def test_it_moves_and_rests_as_the_textbook_says():
    """x = mu_k N/k in steady sliding, about which it moves with sqrt(k/m)."""
    model = Popp(friction=fl.Coulomb(mu_k=0.3, mu_s=0.3), m=2.0, k=9.0)
    assert fl.equilibrium(model).q[0] == pytest.approx(0.3 * 9.81 * 2.0 / 9.0, rel=1e-14)
    assert fl.eigenvalues(model).frequencies.max() == pytest.approx(
        math.sqrt(9.0 / 2.0) / (2 * math.pi), rel=1e-13
    )
    fl.testing.check_model(model, t_end=3.0)


def test_a_derived_model_has_the_roles_of_both():
    assert set(Stopped.roles) == {"friction", "interface", "impact"}
    model = Stopped(e=0.25, d=3.0, k=0.1)
    assert (model.impact.e, model.friction) == (0.25, fl.Stribeck())
    run = fl.simulate(model.replace(friction=fl.Coulomb(mu_k=0.0, mu_s=0.0)), 2.0, x0=[2.9, 1.0])
    before, after = run.events.before[0, 1], run.events.state[0, 1]
    assert after == pytest.approx(-0.25 * before, rel=1e-13)


@fl.model
class Other(fl.MassOnBelt):
    """With defaults set anew, and parameters between those of its base."""

    m = 2.0
    a: float = 0.1
    b: float = 0.2
    k: float = 3.0
    friction = fl.Stribeck()


@dataclass(frozen=True)
class Slippery(fl.Coulomb):
    """A law with a default set anew."""

    mu_k: float = 0.1


def test_a_default_set_anew_keeps_what_is_known_of_the_parameter():
    class Heavier(Other):
        pass

    for cls in (Other, Heavier):
        assert list(cls().parameters)[:7] == ["m", "a", "b", "c", "k", "N", "v"]
        assert (cls().m, cls().k, cls.__signature__.parameters["m"].default) == (2.0, 3.0, 2.0)
        assert cls().friction == fl.Stribeck()
    known, base = (parameters_of(cls) for cls in (Other, fl.MassOnBelt))
    assert (replace(known["m"], default=1.0), replace(known["k"], default=1.0)) == (base["m"], base["k"])
    assert Slippery() == Slippery(mu_k=0.1, mu_s=3.0)
    assert parameters_of(Slippery)["mu_k"].meaning == "coefficient of kinetic friction"


class Undecorated(fl.MassOnBelt):
    m = 2.0
    friction = fl.Stribeck()


class Mixin:
    m = 2.0
    friction = fl.Stribeck()


@pytest.mark.parametrize(
    "bases", [(Undecorated,), (Mixin, fl.MassOnBelt), (fl.model(type("Plain", (fl.MassOnBelt,), {})), Other)]
)
def test_a_default_is_that_of_the_nearest_base_that_sets_it(bases):
    cls = fl.model(type("Mine", bases, {}))
    assert (cls().m, cls.m, cls().friction) == (2.0, 2.0, fl.Stribeck())
    assert parameters_of(cls)["m"].unit == "kg"
    law = dataclass(frozen=True)(type("Law", (type("Base", (fl.Coulomb,), {"mu_k": 0.2}),), {}))
    assert (law(), law.mu_k) == (law(mu_k=0.2), 0.2)


def test_the_error_of_a_property_says_why_it_failed():
    """It was told as a name that the model does not have."""

    @fl.model
    class Mine(fl.MechanicalModel):
        coordinates = ("phi",)

        def mechanics(self, q, v):
            return fl.Mechanics(v.phy**2 / 2)

    with pytest.raises(AttributeError, match="did you mean 'phi'"):
        _ = Mine().rotational_outputs


def test_annotations_may_be_texts_of_a_function():
    law = fl.Stribeck

    @fl.model
    class Local(Popp):
        friction: "law" = law(mu_k=0.1)

    assert Local.roles["friction"] is fl.Stribeck
    with pytest.raises(TypeError, match="friction must be a Stribeck, got Coulomb"):
        Local(friction=fl.Coulomb())


def test_a_law_annotated_as_an_object_is_structure():
    """Two laws of one kind have parameters of the same names."""

    @fl.model
    class Two(Popp):
        other: object = fl.Coulomb(mu_k=0.1, mu_s=0.1)

    assert "other" not in Two.roles
    assert Two(mu_k=0.7).other.mu_k == 0.1

    @fl.model
    class Clash(Popp):
        other: fl.FrictionLaw = fl.Coulomb()

    with pytest.raises(ValueError, match=r"'mu_k' of .* must differ .* or write \w+: object"):
        Clash()


def undecorated():
    class Mine(Popp):
        z: float = 1.0

    Mine()


def a_dataclass():
    @dataclass(frozen=True)
    class Mine(Popp):
        z: float = 1.0

    Mine()


def a_model_of_a_dataclass():
    @dataclass(frozen=True)
    class Base(Popp):
        z: float = 1.0

    @fl.model
    class Mine(Base):
        w: float = 2.0

    Mine(mu_k=0.4)


class OfSpeed(fl.Coulomb):
    def kinetic(self, speed):
        return self.mu_k * speed


def anew(base=Popp, **values):
    """A class that sets defaults anew, not yet a model."""
    return lambda: type("Mine", (base,), values)


def an_unknown_annotation():
    @fl.model
    class Mine(Popp):
        friction: "Nowhere" = fl.Coulomb()  # noqa: F821  that is the fault


def no_default():
    @fl.model
    class Mine(Popp):
        impact: fl.ImpactLaw


def of_functions(function):
    @fl.model
    class Mine(fl.MechanicalModel):
        coordinates = ("x",)

        def mechanics(self, q, v):
            return fl.Mechanics(v.x**2 / 2, function(q.x))

    return Mine().automaton


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (undecorated, "Mine has fields that are not known as parameters: write @fl.model above it"),
        (a_dataclass, "write @fl.model in place of @dataclass"),
        (a_model_of_a_dataclass, "Base must take parameters of laws: write @fl.model in place of @dataclass"),
        (lambda: anew(m=2.0)()(), "Mine has fields that are not known as parameters: write @fl.model"),
        (lambda: fl.model(anew(u=0.5)())(u=1), r"Mine has no parameter 'u', but .* write u: float = 0\.5 in"),
        (anew(fl.MassOnBelt, m="x"), r"m must be one real number, got 'x' .* \(its default is 1 kg"),
        (anew(fl.MassOnBelt, m=property(abs)), "m of Mine must be a value, .* got a property: write m = "),
        (anew(fl.ModularChain, masses=property(abs)), "masses of Mine must be a value, .* got a property"),
        (lambda: fl.model(anew(flag=True)())(flag=False), "Mine has no parameter 'flag': known are"),
        (lambda: fl.model(anew(friction=3)()), "the default of friction in Mine must be a FrictionLaw"),
        (an_unknown_annotation, "the annotation of friction in Mine must name a kind of law, got 'Nowhere'"),
        (no_default, "the default of impact in Mine must be an ImpactLaw, got None"),
        (lambda: fl.model(Popp()), r"fl.model is for classes of models, got Popp\(\)"),
        (lambda: fl.model(Popp), "fl.model is written once above a class, got Popp"),
        (of_functions(np.cos), r"Mine.mechanics must be a formula .* write fl.functions.cos"),
        (of_functions(lambda x: np.hypot(x + 1, 2)), r"Mine.mechanics must be a formula .* fl.functions.cos"),
        (of_functions(math.cos), r"Mine.mechanics must be a formula .* write fl.functions.cos"),
        (of_functions(lambda x: max(x, 0)), r"Mine.mechanics must be a formula .* no if, min or max"),
        (lambda: fl.model(anew(mechanics=lambda self, q, v: None)())().automaton(), "got None: write return"),
        (
            lambda: fl.model(anew(mechanics=lambda q, v: None)())().automaton(),
            r"must take \(self, q, v\), got",
        ),
        (lambda: fl.SliderOnBelt(friction=OfSpeed()).automaton(), r"OfSpeed.kinetic must take 2 .*\(speed\)"),
        (lambda: fl.Friction(1.0, 1.0, law=0.3), r"law of a Friction must be a FrictionLaw, got 0\.3: take"),
        (lambda: fl.simulate(Popp(), 1.0, method=fl.RK4), r"got the class RK4: write RK4\(\)"),
        (lambda: Popp(friction="Stribeck"), r"got the text 'Stribeck': write Stribeck\(\)"),
    ],
    ids=lambda one: getattr(one, "__name__", None),
)
def test_errors_name_the_cure(call, message):
    with pytest.raises(TypeError, match=message):
        call()


@pytest.mark.parametrize("names", [("x", "x"), ("t",), ("x", "phase"), "phi"])
def test_coordinates_have_names_of_their_own(names):
    """A coordinate named t stood for the time: such a model was refused every steady state."""

    @fl.model
    class Mine(fl.MechanicalModel):
        k: float = 1.0
        coordinates = names

        def mechanics(self, q, v):
            return fl.Mechanics(v.x**2 / 2)

    rule = "have different names, and none of 'phase' and 't'|be a tuple of names, got the text 'phi'"
    with pytest.raises(ValueError, match=f"coordinates must ({rule})"):
        Mine()


@pytest.mark.parametrize("name", ["replace", "parameters", "equations", "states", "statics", "interface"])
def test_a_parameter_does_not_hide_what_a_model_has(name):
    with pytest.raises(TypeError, match=f"must not be named like the model's own '{name}': rename it"):
        fl.model(type("Mine", (fl.MechanicalModel,), {"__annotations__": {name: "float"}, name: 1.0}))


def test_a_parameter_is_not_named_like_the_limit_that_the_solver_sets():
    @fl.model
    class Mine(fl.MechanicalModel):
        chatter: float = 4.0
        coordinates = ("x",)

        def mechanics(self, q, v):
            return fl.Mechanics(v.x**2 / 2, self.chatter * q.x**2 / 2)

    with pytest.raises(ValueError, match="like the solver's limit 'chatter': rename it"):
        Mine()


def test_a_parameter_of_a_law_is_set_in_the_law():
    """Else model.mu_k was one number, and friction had another."""
    with pytest.raises(ValueError, match=r"must not hide .* of Coulomb: write friction = Coulomb\(mu_k="):
        fl.model(anew(fl.MassOnBelt, mu_k=0.4)())()


@pytest.mark.parametrize("name", ["period", "sound"])
def test_a_parameter_of_a_law_is_not_named_like_what_a_model_has(name):
    law = dataclass(frozen=True)(
        type("Law", (fl.FrictionLaw,), {"__annotations__": {name: float}, name: 1.0})
    )
    with pytest.raises(ValueError, match=f"'{name}' of Mine must not hide .* of Law: rename that of Law"):
        fl.model(anew(friction=law(), period=3.0)())()


def test_coordinates_are_as_many_as_a_field_says():
    assert fl.ModularChain(masses=2).coordinates == ("u1", "u2", "w1", "w2")
    with pytest.raises(ValueError, match=r"balls must be .*at least 2.*, got 1"):
        fl.NewtonsCradle(balls=1)
    with pytest.raises(
        ValueError, match=r"count must name an integer of the model, got 'm': write m: int = 3"
    ):
        fl.model(anew(fl.OscillatorChain, coordinates=fl.numbered("x", count="m"))())()
