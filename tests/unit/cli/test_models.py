"""Models by name, their values, and JSON, in all commands that compute."""

import json

import pytest

import frictionlab as fl
from frictionlab.cli.command import main
from frictionlab.cli.parsing import model_names, model_of

STRIBECK = "MassOnBelt(friction=Stribeck(mu_k=0.5, mu_s=1.0), c=0.1)"


@pytest.fixture
def said(capsys):
    """Run a command that must end with code 0 and say nothing on standard error; returns what it prints."""

    def said(*words):
        assert main(list(words)) == 0
        out, err = capsys.readouterr()
        assert err == ""
        return out

    return said


def test_a_call_of_the_table_is_the_model_that_python_makes():
    for row in fl.list_models():
        assert model_of(row.call) == model_of(row.call.replace("fl.", ""))
    assert model_of(STRIBECK) == fl.MassOnBelt(friction=fl.Stribeck(mu_k=0.5, mu_s=1.0), c=0.1)
    assert model_of("DenHartog") == fl.DenHartog()


def test_the_list_names_every_model_and_each_has_its_parameters(said):
    rows = json.loads(said("models", "--json"))["models"]
    assert [row["call"] for row in rows] == [row.call.replace("fl.", "") for row in fl.list_models()]
    text = said("models")
    for name in model_names():
        assert f"{name}(" in text
        found = json.loads(said("models", name, "--json"))
        assert found["parameters"] == dict(model_of(name).parameters)
        assert [row["name"] for row in found["described"]] == list(found["parameters"])


def test_eigenvalues_are_those_of_the_model(said):
    found = json.loads(said("eig", "--set", "mu_k=2.5", "F=300", "--json"))
    exact = fl.eigenvalues(fl.SliderOnBelt(mu_k=2.5, F=300.0))
    assert [complex(each["real"], each["imag"]) for each in found["eigenvalues"]] == exact.values.tolist()
    assert found["stable"] is False
    assert found["equilibrium"]["x1"] == exact.equilibrium.q[0]
    assert "(unstable: 2 do not decay)" in said("eig", "--set", "mu_k=2.5", "F=300")


def test_critical_values_are_the_closed_form(said):
    model = fl.ModeCoupling(c=0.0)
    words = ("critical", "mu_k", "0", "2", "--model", "ModeCoupling", "--set", "c=0")
    (change,) = json.loads(said(*words, "--json"))["changes"]
    assert change["value"] == pytest.approx(model.critical_friction, abs=1e-9)
    assert (change["kind"], change["direction"]) == ("flutter", "loss")
    assert f"{model.critical_friction:.8f}  loss by flutter" in said(*words)
    assert "no change of stability" in said("critical", "mu_k", "0", "0.1")


@pytest.mark.parametrize("name", model_names("classics"))
def test_every_model_runs_and_tells_its_summary_as_json(name, said):
    found = json.loads(said("run", "--model", name, "--t-end", "0.5", "--json"))
    begin = {"mu_k": 1.4} if name == "SliderOnBelt" else {}
    run = fl.simulate(model_of(name).replace(**begin), 0.5, progress=False)
    assert found["finished"]
    assert list(found["final_state"].values()) == run.final_state.tolist()
    assert found["events"] == run.events.counts()
    assert f"{run.source!r}\n" in said("run", "-q", "--model", name, "--t-end", "0.5")


def test_values_and_switches_reach_any_model(said):
    text = said("run", "-q", "--model", STRIBECK, "--set", "v=-0.3", "--without", "nonsmooth", "--t-end", "1")
    expected = fl.MassOnBelt(friction=fl.Stribeck(mu_k=0.5, mu_s=1.0), c=0.1).without("nonsmooth")
    assert text.startswith(f"{expected.replace(v=-0.3)!r}\n")
