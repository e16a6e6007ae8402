"""What a user does with results: print them, ask them for values, make tables of them."""

import inspect

import numpy as np
import pytest

import frictionlab as fl
from frictionlab.presentation import Drawable
from tests.helpers.assertions import assert_all
from tests.helpers.results import BUILDERS, result

MAX_LINES, MAX_CHARACTERS = 15, 180  # of a line


def public_classes():
    return {name: each for name in fl.__all__ if inspect.isclass(each := getattr(fl, name))}


@pytest.mark.parametrize("name", BUILDERS)
def test_a_result_prints_as_a_short_summary(name):
    found = result(name)
    for text in repr(found), str(found):
        lines = text.split("\n")
        assert len(lines) <= MAX_LINES
        assert max(map(len, lines)) <= MAX_CHARACTERS
        assert "array(" not in text
    assert repr(found).startswith(type(found).__name__) or name.startswith("ablation")


def test_every_public_class_of_results_is_printed_here():
    kinds = {type(result(name)).__name__ for name in BUILDERS}
    drawn = {name for name, each in public_classes().items() if issubclass(each, Drawable)}
    others = {
        "Events",
        "SectionPoints",
        "Attractor",
        "SpecialOrbit",
        "StabilityChange",
        "Boundary",
        "Spectrum",
    }
    assert drawn | others <= kinds


def test_one_time_gives_one_value_and_times_keep_their_shape():
    run = result("run")
    times = np.array([[0.05, 0.1, 0.15], [0.0, 0.02, 0.07]])
    n = len(run.names)
    assert run(0.05).shape == (n,)
    assert run(times[0]).shape == (3, n)
    assert run(times).shape == (2, 3, n)
    assert run(np.array(0.05)).shape == (n,)
    assert_all(run(times)[1, 2] == run(0.07))
    gap = run.output("gap", 0.05)
    assert isinstance(gap, float)
    assert run.output("gap", times).shape == times.shape
    assert run.output("gap", times)[0, 0] == gap
    assert isinstance(run.output("gap", np.array(0.05)), float)
    assert run.output("gap").shape == run.t.shape
    assert run.modes_at(times).shape == times.shape
    assert str(run.modes_at(0.05)) == run.modes_at([0.05])[0]


def test_several_states_by_name():
    run = result("run")
    both = run[["x1", "gap"]]
    assert_all(both == np.column_stack([run["x1"], run["gap"]]))
    assert_all(run["x1", "gap"] == both)
    with pytest.raises(KeyError, match=r"the run has no .*x_1.*did you mean"):
        run[["x1", "x_1"]]


def test_events_are_a_table():
    events = result("run").events
    assert len(events) == len(events.t) > 3
    lines = str(events).split("\n")
    assert lines[0] == repr(events)
    assert f"{events.t[0]:.6g}" in lines[2]
    assert events.source[0] in lines[2]
    first = events[0]
    assert (first.t, first.target) == (events.t[0], events.target[0])
    assert len(events[1:3]) == 2
    assert_all(events[events.target == "stick"].target == "stick")
    assert [event.t for event in events] == events.t.tolist()


def test_events_as_a_dataframe():
    pandas = pytest.importorskip("pandas", reason="the extra data is not installed")
    events = result("run").events
    table = events.to_dataframe()
    assert isinstance(table, pandas.DataFrame)
    assert len(table) == len(events)
    assert table.columns[:4].tolist() == ["source", "target", "guard", "closed"]
    assert_all(table["x1"] == events.state[:, 0])
    assert table.attrs["units"]["x1'"] == "m/s"
    assert table.index.name == "t"


def test_a_run_as_tables():
    pytest.importorskip("xarray", reason="the extra data is not installed")
    run = result("run")
    table, cube = run.to_dataframe(), run.to_xarray()
    assert table.attrs["units"] == {
        "t": "s", "x1": "m", "y1": "m", "x2": "m", "y2": "m", "phi": "rad",
        "x1'": "m/s", "y1'": "m/s", "x2'": "m/s", "y2'": "m/s", "phi'": "rad/s",
        "penetration": "m", "gap": "m", "relative_velocity": "m/s",
        "normal_force": "N", "friction_force": "N",
    }  # fmt: skip
    for name in (*run.names, *run.automaton.outputs):
        assert_all(table[name].to_numpy() == run[name])
        assert_all(cube[name].to_numpy() == run[name])
        assert cube[name].attrs["units"] == table.attrs["units"][name]
    assert_all(cube["mode"].to_numpy() == run.mode)
    assert_all(cube["t"].to_numpy() == run.t)
    assert cube["t"].attrs["units"] == "s"
    assert cube.attrs["status"] == str(run.status)
    assert cube.attrs["mu_k"] == run.source.mu_k


def test_eigenvalues_as_tables():
    pytest.importorskip("xarray", reason="the extra data is not installed")
    found = result("eigenvalues")
    table, cube = found.to_dataframe(), found.to_xarray()
    assert_all(table["growth_rate"] == found.growth_rates)
    assert_all(table["frequency"] == found.frequencies)
    assert_all(table["participation of y1"] == found.participation[1])
    assert table.attrs["units"]["frequency"] == "Hz"
    assert cube["participation"].dims == ("coordinate", "eigenvalue")
    assert_all(cube["growth_rate"].to_numpy() == found.growth_rates)
    shape = (cube["shape_real"] + 1j * cube["shape_imag"]).sel(coordinate="x2")
    assert_all(shape.to_numpy() == found.shapes[2])


def test_a_root_locus_as_tables():
    pytest.importorskip("xarray", reason="the extra data is not installed")
    found = result("locus")
    table, cube = found.to_dataframe(), found.to_xarray()
    assert table.index.names == ["mu_k", "mode"]
    assert table.shape[0] == found.values.size
    assert_all(table["frequency"].unstack().to_numpy() == found.frequencies)
    assert cube["growth_rate"].dims == ("mu_k", "mode")
    assert_all(cube["growth_rate"].to_numpy() == found.growth_rates)
    assert cube["participation"].sel(coordinate="phi").shape == found.values.shape
    assert cube["frequency"].attrs["units"] == "Hz"


def test_a_stability_map_as_tables():
    pytest.importorskip("xarray", reason="the extra data is not installed")
    found = result("map")
    table, cube = found.to_dataframe(), found.to_xarray()
    assert table.index.names == ["mu_k", "k3"]
    assert_all(table["unstable"].unstack().to_numpy() == found.unstable)
    assert cube["growth"].dims == ("mu_k", "k3")
    assert_all(cube["growth"].to_numpy() == found.growth)
    assert cube["k3"].attrs["units"] == "N/m"


@pytest.mark.parametrize("name", ["run", "events", "eigenvalues", "locus", "map", "bifurcation", "sweep"])
def test_tables_survive_parquet(name, tmp_path):
    pandas = pytest.importorskip("pandas", reason="the extra data is not installed")
    pytest.importorskip("pyarrow", reason="the extra data is not installed")
    table = result(name).to_dataframe()
    table.to_parquet(tmp_path / "table.parquet")
    again = pandas.read_parquet(tmp_path / "table.parquet")
    pandas.testing.assert_frame_equal(again, table)
    assert again.attrs == table.attrs


@pytest.mark.parametrize("name", ["run", "eigenvalues", "locus", "map"])
def test_datasets_hold_what_netcdf_can(name, tmp_path):
    pytest.importorskip("xarray", reason="the extra data is not installed")
    cube = result(name).to_xarray()
    assert {variable.dtype.kind for variable in cube.variables.values()} <= set("fiuUOb")
    plain = [cube.attrs, *(variable.attrs for variable in cube.variables.values())]
    assert all(isinstance(value, (str, float, int)) for attributes in plain for value in attributes.values())


@pytest.mark.parametrize("table", ["to_dataframe", "to_xarray"])
@pytest.mark.parametrize("name", ["run", "eigenvalues", "locus", "map", "bifurcation", "sweep"])
def test_without_the_package_the_command_is_named(name, table, monkeypatch):
    package = {"to_dataframe": "pandas", "to_xarray": "xarray"}[table]
    monkeypatch.setitem(__import__("sys").modules, package, None)
    with pytest.raises(ImportError, match=rf"{table} needs {package}: pip install 'frictionlab\[data\]'"):
        getattr(result(name), table)()
