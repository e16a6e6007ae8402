"""What every model can say of itself: energies, nonlinearities, a mechanism, a sound."""

import numpy as np
import pytest

import frictionlab as fl

NAMES = {name: getattr(fl, name) for name in fl.__all__ if name[0].isupper()}
CALLS = [row.call for row in fl.list_models()]


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


def test_ablation_has_a_scene_for_each_choice(model):
    found = fl.ablation(model, lambda m: len(m.automaton().modes), progress=False)
    names = tuple(model.nonlinearities)
    assert len(found.results) == 2 ** len(names)
    assert found.switches == names
    assert found.models[0] == model
    assert found[names] == 1 <= found[()]


def test_it_is_animated(run):
    animation = fl.animate(run, fps=2)
    assert animation.to_jshtml().count("data:image/png") > 10


def test_it_is_watched(run):
    canvas = fl.watch(run)
    columns = list(canvas.scene["columns"])
    rows = np.frombuffer(canvas.rows, "<f4").reshape(-1, len(columns))
    assert np.isfinite(rows).all()
    assert len(rows) > 500
    shown = rows[:, columns.index(canvas.scene["axes"][0])]
    assert np.ptp(shown) > 0
    assert shown[-1] == np.float32(run[canvas.scene["axes"][0]][-1])
