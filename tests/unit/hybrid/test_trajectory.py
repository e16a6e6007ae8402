"""A run as a table."""

import sys

import pytest

import frictionlab as fl


@pytest.fixture(scope="module")
def run():
    return fl.simulate(fl.SliderOnBelt(mu_k=1.4), 0.05)


def test_columns_are_states_outputs_and_mode(run):
    table = run.to_dataframe()
    assert table.index.name == "t"
    assert (table.index == run.t).all()
    assert (table["x1'"] == run["x1'"]).all()
    assert (table["normal_force"] == run.normal_force).all()
    assert (table["mode"] == run.mode).all()


def test_without_pandas_the_extra_is_named(run, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)  # as if it were not installed
    with pytest.raises(ImportError, match=r"frictionlab\[data\]"):
        run.to_dataframe()


def test_a_state_with_labels_is_read_by_them():
    """By place a Series with x' first had its velocity for the place."""
    pandas = pytest.importorskip("pandas")
    start = pandas.Series({"x'": 2.0, "x": 1.0})
    model = fl.MassOnBelt()
    assert fl.simulate(model, 0.1, x0=start, progress=False)(0.0).tolist() == [1.0, 2.0]
    assert fl.solve(model.automaton(), 0.1, x0=start, progress=False)(0.0).tolist() == [1.0, 2.0]
    with pytest.raises(ValueError, match="x0 has no state 'y'"):
        fl.simulate(model, 0.1, x0=pandas.Series({"y": 2.0}))
