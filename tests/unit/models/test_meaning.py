"""What a model states is a mechanical system, or it is refused with its cause before anything is computed."""

from __future__ import annotations

import numpy as np
import pytest
import sympy

import frictionlab as fl
from frictionlab.components import Coulomb, PlasticImpact
from frictionlab.models import MechanicalModel
from frictionlab.models.mechanical.mechanics import Friction, Mechanics, SlidingStatics, Stop

cos, sin = fl.functions.cos, fl.functions.sin


def energy(v):
    """Of both coordinates with mass 1."""
    return (v.x**2 + v.y**2) / 2


def rubbing(speed, pressing=1.0, **about):
    """A contact with friction."""
    return (Friction(speed, pressing, Coulomb(), **about),)


# What is stated wrong, and what the error says.
WRONG = {
    "cubic": (lambda s, q, v: Mechanics(v.x**3 + energy(v)), r"kinetic of .* degree 2 .* depend on x'"),
    "no mass": (lambda s, q, v: Mechanics(v.x**2 / 2), r"the coordinate 'y' has none: add .* v.y\*\*2"),
    "only place": (
        lambda s, q, v: Mechanics(energy(q)),
        "of 'x' and 'y' together has none",
    ),
    "dependent": (
        lambda s, q, v: Mechanics(s.m * (v.x + q.x * v.y) ** 2 / 2),
        r"a motion of 'x' and 'y' together has none",
    ),
    "dependent numbers": (lambda s, q, v: Mechanics((v.x - v.y) ** 2), "of 'x' and 'y' together has none"),
    "velocity in V": (
        lambda s, q, v: Mechanics(energy(v), s.m * v.x * q.x),
        "'potential' of Stated must not depend on x'.* is a load",
    ),
    "infinite": (
        lambda s, q, v: Mechanics(energy(v), {"well": q.x / sympy.S.Zero}),
        "'well' .* finite and real",
    ),
    "damper of place": (
        lambda s, q, v: Mechanics(energy(v), 0, s.m * q.x**2),
        "dissipation of Stated must be a function of the velocities",
    ),
    "damper below zero": (
        lambda s, q, v: Mechanics(energy(v), contacts=(fl.Contact(-q.y, 2 * q.y, damper=-1.0),)),
        "damper of a Contact of Stated must be at least 0, got -1.0",
    ),
    "no phase": (
        lambda s, q, v: Mechanics(energy(v), loads={"x": cos(q.phase)}),
        "the load on 'x' of Stated must not depend on phase: give Mechanics the frequency too",
    ),
    "frequency of place": (
        lambda s, q, v: Mechanics(energy(v), frequency=1 + q.x**2),
        "frequency of Stated must not depend on x: it is one number",
    ),
    "unknown": (
        lambda s, q, v: Mechanics(energy(v), sympy.Symbol("k") * q.x**2),
        "'potential' of Stated must not depend on k: it is no coordinate, .* write self.k",
    ),
    "no expression": (lambda s, q, v: Mechanics(energy(v), [q.x]), "must be an expression of .*, got"),
    "square speed": (
        lambda s, q, v: Mechanics(energy(v), contacts=rubbing(v.x**2 - 1)),
        "relative_velocity of Stated must be linear in the velocities",
    ),
    "rate in a gap": (
        lambda s, q, v: Mechanics(energy(v), contacts=rubbing(v.x, lambda d: d, penetration=v.y)),
        "penetration of Stated must not depend on y'",
    ),
    "two of three": (
        lambda s, q, v: Mechanics(
            energy(v), contacts=rubbing(v.x, lambda d: d, penetration=q.y, normal=(1.0,))
        ),
        "normal of Stated must have one entry for each of its 2 coordinates, got 1",
    ),
    "fixed stop": (
        lambda s, q, v: Mechanics(energy(v), contacts=(Stop(s.m, PlasticImpact()),)),
        "distance of a Stop of Stated must depend on a coordinate",
    ),
    "no penetration": (
        lambda s, q, v: Mechanics(energy(v), contacts=rubbing(v.x, lambda d: d)),
        "normal_force of Stated must be an expression, got a function",
    ),
}
# What has no meaning at these values only.
WRONG_VALUES = {
    "negative": (lambda s, q, v: Mechanics(s.m * energy(v)), "the mass of 'x' is -1 at m = -1: give"),
    "in time": (
        lambda s, q, v: Mechanics((2 + cos(q.phase) + s.m * 1.5) * energy(v), frequency=1.0),
        "the mass of 'x' is -0.207107 at m = -1, phase = 2.35619",
    ),
    "coupled": (
        lambda s, q, v: Mechanics(energy(v) + (3 + s.m) * v.x * v.y),
        "that of 'x' and 'y' together is not at m = -1",
    ),
    "in place": (
        lambda s, q, v: Mechanics((s.m - q.x**2) * energy(v)),
        "the mass of 'x' is -1 at m = -1",
    ),
}


@fl.model
class Stated(MechanicalModel):
    """Two coordinates, and what a variant states of them."""

    m: float = fl.parameter(1.0, unit="kg", symbol="m", meaning="mass", range=(-1.0, 1.0))
    variant: str = ""
    coordinates = ("x", "y")

    def mechanics(self, q, v):
        """As the variant has it."""
        return (WRONG | WRONG_VALUES)[self.variant][0](self, q, v)


@pytest.mark.parametrize("variant", WRONG)
def test_what_is_no_mechanical_system_is_refused(variant):
    with pytest.raises((ValueError, TypeError), match=WRONG[variant][1]):
        fl.simulate(Stated(variant=variant), 1.0)


def _root_locus(model):
    """Its root locus to m = -1, from a model whose masses are positive."""
    return fl.root_locus(model.replace(m=-2.5 if model.variant == "coupled" else 1.0), "m", [-1.0])


@pytest.mark.parametrize(
    "use",
    [lambda m: fl.simulate(m, 1.0), fl.equilibria, _root_locus],
    ids=["simulate", "equilibria", "root_locus"],
)
@pytest.mark.parametrize("variant", WRONG_VALUES)
def test_masses_that_are_not_positive_are_refused_by_value(variant, use):
    with pytest.raises(ValueError, match=WRONG_VALUES[variant][1]):
        use(Stated(variant=variant, m=-1.0))
    Stated(variant=variant, m=1.0 if variant != "coupled" else -2.5).automaton()


PHASES = {
    "half": lambda s, phase: cos(phase / 2),
    "ratio": lambda s, phase: sin((s.m + 3) * phase / 4) * 2,
    "coefficient": lambda s, phase: (1 + cos(s.m * phase * 0.3)) * s.m,
    "squared": lambda s, phase: cos((s.m + 2) * phase / 2) ** 2,
    "rectified": lambda s, phase: fl.functions.absolute(sin((s.m + 2) * phase / 2)),
    "sawtooth": lambda s, phase: phase * s.m + sin((s.m + 4) * phase),
    "pulse": lambda s, phase: fl.functions.piecewise(phase, [1.0], [sin(np.pi * phase), 0.0]),
    "burst": lambda s, phase: fl.functions.exp(-9 * phase) * sin(3.3 * phase),
    "difference": lambda s, phase: sin((s.m + 3) * phase) - sin(2.0 * phase),
}


@pytest.mark.parametrize(("wave", "jumps"), [*zip(PHASES, [True] * 3 + [False] * 6, strict=True)])
def test_sines_that_jump_where_the_phase_starts_again_are_refused(wave, jumps):
    WRONG[wave] = (
        lambda s, q, v: Mechanics(energy(v), loads={"x": PHASES[wave](s, q.phase)}, frequency=2.0),
        "",
    )
    if not jumps:
        assert Stated(variant=wave, m=-1.0).automaton()
        return
    with pytest.raises(ValueError, match=r"q.phase must have its period, 2 pi, got .*write q\.t"):
        fl.simulate(Stated(variant=wave, m=-1.0), 1.0)
    if wave == "ratio":
        assert Stated(variant=wave, m=1.0).automaton()


def test_a_path_of_masses_needs_no_rule_between_parameters():
    """No eigenvalue depends on the rule, as on that of mu_s and mu_k."""

    @fl.model
    class Rotor(fl.MechanicalModel):
        m: float = 1.0
        most: float = 2.0
        coordinates = ("x",)

        def __post_init__(self):
            super().__post_init__()
            if self.m > self.most:
                raise ValueError("m must be at most `most`")

        def mechanics(self, q, v):
            return Mechanics(self.m * v.x**2 / 2, q.x**2 / 2)

    frequencies = fl.root_locus(Rotor(), "m", [1.0, 4.0]).frequencies
    np.testing.assert_allclose(2 * np.pi * frequencies.max(axis=1), [1.0, 0.5], rtol=1e-12)


def test_masses_of_a_map_are_checked_at_its_own_values():
    """m y'^2 is more than (r x' y')^2 / x'^2 where m > r^2, which the model's own r does not say."""

    @fl.model
    class Pair(fl.MechanicalModel):
        m: float = 1.0
        r: float = 0.9
        coordinates = ("x", "y")

        def mechanics(self, q, v):
            return Mechanics(v.x**2 / 2 + self.m * v.y**2 / 2 + self.r * v.x * v.y, energy(q))

    assert not fl.stability_map(Pair(), ("m", [0.5, 1.0]), ("r", [0.0, 0.6])).unstable.any()
    with pytest.raises(ValueError, match=r"that of 'x' and 'y' together is not at m = 0\.1, r = 0\.6"):
        fl.stability_map(Pair(r=0.0), ("m", [0.1, 1.0]), ("r", [0.0, 0.6]))


def test_masses_that_depend_on_place_are_checked_where_the_run_starts():
    model = Stated(variant="in place", m=1.0)
    assert fl.simulate(model, 0.1, x0=[0.5, 0, 0.1, 0], progress=False).status.ok
    with pytest.raises(ValueError, match="the mass of 'x' is -3 at m = 1, x = 2, y = 0"):
        fl.simulate(model, 0.1, x0=[2.0, 0, 0.1, 0])


def test_terms_that_cancel_are_no_cubes():
    WRONG["cancel"] = (lambda s, q, v: Mechanics((v.x + 1) ** 3 / 6 - v.x**3 / 6 + v.y**2 / 2), "")
    run = fl.simulate(Stated(variant="cancel"), 1.0, x0=[0, 0, 0.5, 0.25], progress=False)
    np.testing.assert_allclose(run.final_state, [0.5, 0.25, 0.5, 0.25], rtol=1e-14)


@fl.model
class Hanging(MechanicalModel):
    """A mass on a belt with equilibria by statics, and one thing that is not linear, or moves."""

    variant: str = "mass"
    coordinates = ("x", "y")
    statics = SlidingStatics("y")

    def mechanics(self, q, v):
        """The paper's plane slider, but for the variant."""
        about = {
            "mass": {"kinetic": (1 + q.x**2) * energy(v)},
            "turning": {"kinetic": energy(v) + q.x**2 / 2},
            "spring": {"potential": q.x**4},
            "damper": {"dissipation": v.x**4},
            "force": {"loads": {"x": cos(q.phase)}, "frequency": 1.0},
        }[self.variant]
        contact = rubbing(1 - v.x, lambda depth: 10 * depth, penetration=q.y)
        return Mechanics(**{"kinetic": energy(v), "potential": q.x**2 - q.y, "contacts": contact} | about)


@pytest.mark.parametrize("variant", ["mass", "turning", "spring", "damper", "force"])
def test_statics_are_for_what_is_linear_and_at_rest(variant):
    with pytest.raises(ValueError, match="of Hanging does not go with statics"):
        fl.equilibria(Hanging(variant=variant))
