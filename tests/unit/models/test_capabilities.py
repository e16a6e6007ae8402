"""What every model can say of itself: energies, nonlinearities, a mechanism, a sound."""

import numpy as np
import pytest

import frictionlab as fl
from frictionlab.components import ContactLaw, FrictionLaw, ImpactLaw
from frictionlab.models import Friction, Mechanics, Mechanism
from frictionlab.models.mechanism import Belt, Block, Forces, Point, Spring
from tests.helpers.cases import slow_but
from tests.helpers.explorers import columns

NAMES = {name: getattr(fl, name) for name in fl.__all__ if name[0].isupper()}
CALLS = [row.call for row in fl.list_models("classics")]
ON_THE_GROUND = fl.DenHartog, fl.FreeCoulomb  # at rest, so that sliding only would have no direction


@pytest.fixture(params=CALLS)
def model(request):
    return eval(request.param, {"fl": fl, **NAMES})


@pytest.fixture
def run(model):
    return fl.simulate(model, 10 * model.period, progress=False)


def test_the_energy_balance_closes(run):
    audit = fl.energy_audit(run, progress=False)
    assert audit.turned_over > 0
    assert audit.error < 1e-12
    assert np.ptp(audit.energies["kinetic"]) > 0
    assert (audit.powers["dampers"] <= 0).all()
    if "friction" in audit.powers:
        assert (audit.powers["friction"] <= 1e-12 * max(1.0, np.abs(audit.powers["belt drive"]).max())).all()


def test_it_can_be_without_each_of_its_nonlinearities(model):
    names = tuple(model.nonlinearities)
    if isinstance(model, ON_THE_GROUND):
        assert not names
        with pytest.raises(ValueError, match="must rub a belt that moves"):
            model.without("nonsmooth")
        return
    assert names
    for name in names:
        less = model.without(name)
        assert model.nonlinearities[name].missing(less)
        assert not model.nonlinearities[name].missing(model)
        assert less.without(name) == less
        assert fl.Model.from_dict(less.to_dict()) == less
        assert fl.simulate(less, model.period, progress=False).status.ok
    flow = model.without("nonsmooth").automaton()
    assert [event.name for mode in flow.modes for event in mode.events if event.name != "period"] == []
    with pytest.raises(ValueError, match="a model can be without '"):
        model.without("friction")


def test_it_is_watched(run):
    found, name = columns(fl.watch(run)), run.source.coordinates[0]
    assert all(np.isfinite(found[each]).all() for each in run.names)
    assert len(found["t"]) > 500
    assert np.ptp(found[name]) > 0
    assert found[name][-1] == run[name][-1]


def test_it_is_heard(model, run):
    sound = fl.listen(run)
    assert (sound.signal, sound.pitch) == model.sound
    assert sound.pitch == pytest.approx(200 * model.period, rel=5e-3)
    assert np.abs(sound.samples).max() == pytest.approx(0.9)


@pytest.mark.parametrize("model", slow_but([CALLS[-1]], CALLS), indirect=True)
def test_it_is_explored_with_a_switch_for_each_nonlinearity_and_its_mechanism(model):
    explorer = fl.explore(model, panels=("response", "mechanism"))
    assert explorer.error is None
    switches = {name for name in explorer.controls if name.startswith("switch-")}
    assert switches == {f"switch-{name}" for name in model.nonlinearities}
    for name, one in model.nonlinearities.items():
        switch = explorer.controls[f"switch-{name}"]
        assert switch.value
        switch.value = False
        assert explorer.error is None
        assert explorer.model == model.without(name)
        assert one.missing(explorer.model)
        switch.value = True
        assert explorer.model == model
    explorer.close()


@fl.model
class Lifted(fl.MechanicalModel):
    """A mass that a spring holds above a conveyor: a model as a user writes one."""

    k: float = fl.parameter(4.0, unit="N/m", symbol="k", meaning="stiffness", range=(0.1, 10.0))
    v: float = fl.parameter(0.3, unit="m/s", symbol="v", meaning="speed", range=(0.0, 1.0))
    contact: ContactLaw = fl.CubicContact(k2=30.0, k_nl=100.0)
    friction: FrictionLaw = fl.Coulomb(mu_k=0.4, mu_s=0.7)
    coordinates = ("x", "y")
    period = 3.0

    @property
    def mechanism(self):
        body = Point(0.0, 0.5, right="x", up="-y")
        return Mechanism(Belt("v"), Spring(Point(-1.5, 0.5), body), Block(body), Forces(body))

    def mechanics(self, q, v):
        return Mechanics(
            kinetic=(v.x**2 + v.y**2) / 2,
            potential={"spring": self.k * q.x**2 / 2, "weight": -9.81 * q.y},
            contacts=(Friction(self.v - v.x, self.contact.force, self.friction, penetration=q.y),),
        )


def test_a_model_of_ones_own_has_all_of_them():
    model = Lifted()
    run = fl.simulate(model, 10.0, x0=[0.0, 0.1, 0.0, 0.0], progress=False)
    audit = fl.energy_audit(run, progress=False)
    assert list(audit.energies) == ["kinetic", "spring", "weight", "contact"]
    assert audit.error < 1e-12
    assert tuple(model.nonlinearities) == ("cubic", "nonsmooth")
    assert len(fl.ablation(model, lambda m: m.period, progress=False).results) == 4
    assert len(columns(fl.watch(run))["t"]) > 0
    assert fl.listen(run).signal == "relative_velocity"
    plain = fl.simulate(Plain(), 1.0, x0=[0.0, 0.1, 0.0, 0.0], progress=False)
    assert fl.watch(plain).scene["panels"] == ["response", "phase"]
    assert fl.animate(plain, fps=1).to_jshtml().count("data:image/png") > 1


class Plain(Lifted):
    """The same that does not say what it looks like."""

    mechanism = None


@fl.model
class Tilting(fl.MechanicalModel):
    """The paper's system by other names: nothing in the derivation knows it."""

    F: float = fl.parameter(200.0, unit="N", symbol="F", meaning="preload", range=(0.0, 500.0))
    contact: ContactLaw = fl.CubicContact()
    friction: FrictionLaw = fl.Coulomb(mu_k=1.4)
    impact: ImpactLaw = fl.PlasticImpact()
    coordinates = ("s", "h", "b", "w", "turn")

    def mechanics(self, q, v):
        wheels = (q.w + 0.2 * q.turn) ** 2 + (q.w - 0.2 * q.turn) ** 2
        rolling = (v.w + 0.2 * v.turn) ** 2 + (v.w - 0.2 * v.turn) ** 2
        springs = (1e4 * (q.s**2 + q.b**2 + wheels) + 3e3 * (q.s - q.h) ** 2) / 2
        moving = v.s**2 + v.h**2 + v.b**2 + v.w**2 + 0.1 * v.turn**2
        return Mechanics(
            kinetic=moving / 2,
            potential=springs + self.F * q.h,
            dissipation=0.1 * (v.s**2 + v.h**2 + v.b**2 + rolling) / 2,
            contacts=(
                Friction(
                    1.0 - v.s + v.b,
                    self.contact.force,
                    self.friction,
                    penetration=q.w - (q.s - q.b) * q.turn - q.h,
                    normal=(0, 1, 0, -1, q.s - q.b),
                    impact=self.impact,
                ),
            ),
        )


@pytest.mark.slow
@pytest.mark.parametrize(
    "impact",
    [pytest.param(fl.PlasticImpact(), marks=pytest.mark.slow), fl.RestitutionImpact(e=0.5)],
    ids=["plastic", "e"],
)
def test_a_moving_load_an_impact_law_and_chatter_are_for_any_model(impact):
    mine, paper = Tilting(impact=impact), fl.SliderOnBelt(mu_k=1.4, impact=impact)
    assert mine.automaton().names == paper.automaton().names
    run, other = (fl.simulate(model, 0.5, progress=False) for model in (mine, paper))
    assert run.events.guard.tolist() == other.events.guard.tolist()
    assert run.events.target.tolist() == other.events.target.tolist()
    assert "separation" in run.events.source
    # The same but for rounding, which the motion magnifies.
    assert run.events.t == pytest.approx(other.events.t, abs=1e-9)
    assert run.final_state == pytest.approx(other.final_state, abs=1e-8)
    audit, paper_audit = fl.energy_audit(run, progress=False), fl.energy_audit(other, progress=False)
    assert audit.works["moving load"][-1] == pytest.approx(paper_audit.works["moving load"][-1], abs=1e-7)
    assert fl.equilibrium(mine.replace(mu_k=0.3)).q == pytest.approx(
        fl.equilibrium(paper.replace(mu_k=0.3)).q, rel=1e-9
    )
