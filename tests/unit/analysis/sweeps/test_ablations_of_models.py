"""Ablations of several models with alternatives that are named: scenes, workers, files, answers by name."""

import math

import numpy as np
import pytest

import frictionlab as fl
from tests.helpers.cases import slow_but

QUIET = {"progress": False}
ONSET = fl.CriticalValue("mu_k", (0.0, 4.0))


def impacts(model):
    """How many there are in 20 s."""
    run = fl.simulate(model, 20.0, **QUIET)
    return int((run.events.guard == "impact").sum())


def stick_time(model):
    return float(fl.simulate(model, 10.0, **QUIET).time_in_mode.get("stick", 0.0))


def force(model):
    return fl.equilibrium(model).normal_force


# model, switches, study, then the changes of each level by hand, the switches in their order
CASES = {
    "contacts and dampers": (
        fl.SliderOnBelt(),
        {
            "contact": [fl.LinearContact(), fl.CubicContact(), fl.HertzContact()],
            "damping": {"as it is": {}, "none": {"c1": 0.0, "c2": 0.0}},
            "geometry": None,
        },
        force,
        [
            [{"contact": law} for law in (fl.LinearContact(), fl.CubicContact(), fl.HertzContact())],
            [{}, {"c1": 0.0, "c2": 0.0}],
            [{}, {"geometry": fl.FixedLoad()}],
        ],
    ),
    "friction laws": (
        fl.MassOnBelt(),
        {"friction": {"Coulomb": fl.Coulomb(), "Stribeck": fl.Stribeck()}, "c": [0.0, 0.05]},
        stick_time,
        [[{"friction": fl.Coulomb()}, {"friction": fl.Stribeck()}], [{"c": 0.0}, {"c": 0.05}]],
    ),
    "springs": (
        fl.ModeCoupling(c=0.1),
        {"k1": [0.9, 1.0, 1.1], "k3": [1.2, 1.4]},
        ONSET,
        [[{"k1": k1} for k1 in (0.9, 1.0, 1.1)], [{"k3": k3} for k3 in (1.2, 1.4)]],
    ),
    "impacts": (
        fl.ImpactOscillator(Omega=2.8, d=0.05, c=0.02),
        {"e": [0.9, 0.5], "stop": {"near": {"d": 0.05}, "far": {"d": 0.5}}},
        impacts,
        [[{"e": 0.9}, {"e": 0.5}], [{"d": 0.05}, {"d": 0.5}]],
    ),
}


def by_hand(model, changes):
    """The models of all scenes, the last switch changing first."""
    models = [model]
    for levels in changes:
        models = [one.replace(**level) for one in models for level in levels]
    return models


@pytest.mark.parametrize("case", slow_but([case for case in CASES if case != "springs"], CASES))
def test_every_scene_is_the_model_that_one_would_make(case):
    model, switches, study, changes = CASES[case]
    found = fl.ablation(model, study, switches, **QUIET)
    expected = [study(one) for one in by_hand(model, changes)]
    assert list(found.results) == expected
    assert len({*expected}) > 1
    table = found.to_dataframe()
    assert table.shape == (len(expected), 1)
    assert list(table.index.names) == list(switches)


def test_what_sets_the_amplitude_is_answered_by_name():
    """X = sqrt(a^2 + v^2/w^2), a = (mu_s - mu_k) N/k: effects are differences of it."""
    switches = {"mu_s": [0.8, 1.2], "v": [0.10, 0.15], "m": [1.0, 1.05]}
    found = fl.ablation(fl.MassOnBelt(), fl.OrbitAmplitude("x"), switches, workers=2, **QUIET)
    model = fl.MassOnBelt()
    mu_s, v, m = np.meshgrid(*switches.values(), indexing="ij")
    exact = np.hypot((mu_s - model.mu_k) * model.N / model.k, v * np.sqrt(m / model.k))
    assert found.numbers().ravel() == pytest.approx(exact.ravel(), rel=1e-10)
    effects = found.effects()
    assert effects.strongest == "mu_s"
    assert effects["mu_s"] == pytest.approx((exact[1] - exact[0]).mean(), rel=1e-9)
    assert effects["v"] == pytest.approx((exact[:, 1] - exact[:, 0]).mean(), rel=1e-9)
    alone = found.leave_one_out()
    assert list(alone) == ["mu_s 1.2", "v 0.15", "m 1.05"]
    assert alone["v 0.15"] == pytest.approx(exact[0, 1, 0] - exact[0, 0, 0], rel=1e-9)


@pytest.mark.slow
def test_what_moves_the_onset_is_answered_by_name():
    """Hoffmann's closed form: springs do, the mass does not."""
    model = fl.ModeCoupling(c=0.0)
    switches = {"m": [1.0, 2.0], "k1": [0.95, 1.05], "k3": [1.3, 1.4]}
    found = fl.ablation(model, ONSET, switches, **QUIET)
    exact = [one.critical_friction for one in found.models]
    assert found.numbers().ravel() == pytest.approx(exact, rel=1e-8)
    effects, table = found.effects(), np.reshape(exact, (2, 2, 2))
    sizes = {name: np.abs(np.diff(table, axis=i)).mean() for i, name in enumerate(switches)}
    assert effects.strongest == max(sizes, key=sizes.__getitem__) != "m"
    assert effects["m"] == pytest.approx(0.0, abs=1e-8)


def test_a_quantity_that_does_not_vary_or_lacks_values_has_no_share_of_a_variance():
    switches = {"c": [0.0, 0.1]}
    same = fl.ablation(fl.MassOnBelt(), lambda model: 1.0, switches, **QUIET).effects()
    assert repr(same).endswith("c: 0 (nothing varies)")
    lacks = fl.ablation(fl.MassOnBelt(), lambda model: 1.0 if model.c else math.nan, switches, **QUIET)
    assert repr(lacks.effects()).endswith("c: unknown, as a scene lacks it")


def test_what_removes_a_kind_of_motion_is_answered_by_name():
    """A mass sticks and slips where static friction exceeds kinetic; else, being damped, it comes to rest."""

    def kind(model):
        return {"kind": str(fl.steady_state(model, transient=400.0, window=100.0, **QUIET).kind)}

    switches = {"static friction": {"higher": {"mu_s": 1.0}, "as kinetic": {"mu_s": 0.5}}, "k": [1.0, 1.1]}
    found = fl.ablation(fl.MassOnBelt(c=0.05, mu_k=0.5), kind, switches, workers=2, **QUIET)
    alone = found.leave_one_out("kind = periodic")
    assert alone == {"static friction as kinetic": -1.0, "k 1.1": 0.0}
    assert found.effects("kind = periodic").strongest == "static friction"
    assert found.effects("kind = equilibrium")["static friction"] == 1.0


def test_on_a_belt_at_rest_nothing_can_only_slide():
    """Friction has no direction there: without it there would be none, which is no effect of "nonsmooth"."""
    studied = []
    rests, moves = fl.SliderOnBelt(v=0.0), fl.SliderOnBelt(v=1.0)
    assert fl.ablation(rests, force, **QUIET).switches == ("cubic", "geometry")
    for attempt in (
        lambda: rests.without("nonsmooth"),
        lambda: fl.ablation(rests, studied.append, ["nonsmooth"], **QUIET),
        lambda: fl.ablation(moves, studied.append, {"v": [1.0, 0.0], "nonsmooth": None}, **QUIET),
        lambda: fl.ablation(moves, studied.append, ["nonsmooth"], over={"v": [1.0, 0.0]}, **QUIET),
    ):
        with pytest.raises(
            ValueError, match="must rub a belt that moves where it only slides, got one at rest"
        ):
            attempt()
    assert not studied
    assert len(fl.ablation(moves, force, ["geometry"], over={"v": [1.0, 0.0]}, **QUIET).scenes) == 2
