"""What users of scipy, matplotlib and pandas write by habit: it works, or the message says what to write."""

import numpy as np
import pytest
from matplotlib.figure import Figure
from scipy import stats

import frictionlab as fl
from frictionlab.plotting import plot_eigenvalues, plot_frequencies, plot_root_locus, plot_sweep

MODEL = fl.SliderOnBelt(mu_k=1.4).without("geometry")
QUIET = {"progress": False}


@pytest.fixture(scope="module")
def run():
    return fl.simulate(MODEL, 0.3, **QUIET)


@pytest.mark.parametrize(
    ("keyword", "cure"),
    [
        ("t_span", "give its end as t_end"),
        ("rtol", r"write method=fl.Taylor\(tol=1e-10\)"),
        ("atol", r"write method=fl.Taylor\(tol=1e-10\)"),
        ("max_step", r"write method=fl.Scipy\(max_step=0.01\)"),
        ("y0", "given as x0"),
        ("args", r"write model.replace\(mu_k=1.4\)"),
        ("dense_output", r"write run\(t\)"),
        ("events", "recorded as sections"),
    ],
)
def test_keywords_of_solve_ivp(keyword, cure):
    with pytest.raises(TypeError, match=f"simulate takes no '{keyword}': .*{cure}"):
        fl.simulate(MODEL, 1.0, **{keyword: 0.0})
    with pytest.raises(TypeError, match=f"solve takes no '{keyword}': .*{cure}"):
        fl.solve(MODEL.automaton(), 1.0, x0=np.zeros(8), **{keyword: 0.0})


@pytest.mark.parametrize("span", [(0, 1), [0.0, 1.0], np.linspace(0.0, 1.0, 11)])
def test_a_span_of_time_is_told_its_end(span):
    with pytest.raises(ValueError, match=r"t_end must be .*: a run begins at 0, write t_end=1$"):
        fl.simulate(MODEL, span)


@pytest.mark.parametrize("wrong", [[None], ["a"], [[0.0, 1.0], [1.0, 2.0]], [10**400], ()])
def test_what_is_no_span_of_time_is_refused_too(wrong):
    with pytest.raises(ValueError, match=r"t_end must be a finite number.*: give the length of the run"):
        fl.simulate(MODEL, wrong)


@pytest.mark.parametrize("method", [fl.Taylor, fl.RK4])
def test_methods_and_bundles_of_settings_explain_keywords_too(method):
    with pytest.raises(TypeError, match=f"{method.__name__} takes no 'rtol': tolerances"):
        method(rtol=1e-6)
    with pytest.raises(TypeError, match="bifurcation takes no 'n_jobs': write workers=2"):
        fl.bifurcation(MODEL, "mu_k", [1.0], n_jobs=2)


@pytest.mark.parametrize(
    ("name", "cure"),
    [("y", "run.states"), ("sol", r"run\(t\)"), ("success", "run.status"), ("t_events", "run.events.t")],
)
def test_attributes_of_solve_ivps_result(run, name, cure):
    with pytest.raises(AttributeError, match=f"no attribute '{name}': .*{cure}"):
        getattr(run, name)


def test_a_result_is_no_array(run):
    for convert in (np.asarray, np.array, np.max, lambda r: np.array(r, dtype=float)):
        with pytest.raises(TypeError, match=r"array of Trajectory: write run.states, .* or run\['x1'\]"):
            convert(run)
    with pytest.raises(TypeError, match=r"array of Eigenvalues: write \.values"):
        np.asarray(fl.eigenvalues(MODEL))
    with pytest.raises(TypeError, match="array of Sweep: write to_array"):
        np.asarray(fl.sweep(MODEL, lambda m: m.F, {"F": [1.0]}, **QUIET))
    assert np.array([run, run], dtype=object).tolist() == [run, run]
    runs = fl.sweep(MODEL, lambda m: fl.simulate(m, 0.01, **QUIET), {"mu_k": [0.5, 1.0]}, **QUIET)
    assert all(isinstance(one, fl.Trajectory) for one in runs.results)


def test_generators_of_numpy_and_seeds_are_taken():
    ranges, quantity = {"k1": stats.norm(MODEL.k1, 10.0)}, fl.GrowthRate()

    def values(rng):
        return fl.uncertainty(MODEL, quantity, ranges, n=16, rng=rng, **QUIET).values

    assert np.array_equal(values(np.random.default_rng(5)), values(np.random.default_rng(5)))
    assert np.array_equal(values(3), values(3))
    assert not np.array_equal(values(None), values(None))
    with pytest.raises(TypeError, match="uncertainty takes no 'seed': random numbers are chosen by rng"):
        fl.uncertainty(MODEL, quantity, ranges, n=16, seed=1)
    with pytest.raises(ValueError, match=r"rng must be an integer, .*a numpy Generator"):
        values(np.random.RandomState(1))


def test_colours_and_lines_are_passed_on(run):
    ax = run.plot(color="tab:red", lw=3.0, alpha=0.5)
    drawn = [line for line in ax.lines if len(line.get_xdata()) > 2]
    assert {line.get_color() for line in drawn} == {"tab:red"}
    assert {line.get_linewidth() for line in drawn} == {3.0}
    locus = fl.root_locus(fl.SliderOnBelt(), "mu_k", [1.0, 1.5, 2.0])
    heavy = plot_frequencies(locus, color="k", linewidth=0.5)
    assert {line.get_color() for line in heavy} == {"k"}
    assert max(line.get_linewidth() for line in heavy) > 1.0  # where a mode grows
    legend = heavy[0].axes.get_legend()
    assert legend.get_lines()[0].get_color() == "k"
    swept = fl.sweep(MODEL, lambda m: m.F, {"F": [1.0, 2.0]}, **QUIET)
    assert plot_sweep(swept, linestyle="--")[0].get_linestyle() == "--"


def test_a_property_that_lines_do_not_have_draws_nothing(run):
    ax = Figure().add_subplot()
    with pytest.raises(TypeError, match="lines have no property 'colour': did you mean 'color'"):
        run.plot(ax, colour="red")
    assert not ax.lines


def test_axes_for_a_picture_of_several_panels(run):
    with pytest.raises(TypeError, match=r"plot_run takes no 'ax': .*run.plot\(ax=ax\)"):
        fl.plot_run(run, ax=Figure().add_subplot())


def test_frequencies_have_one_unit():
    model = fl.SliderOnBelt()
    values = fl.eigenvalues(model)
    upper = values.frequencies[values.values.imag >= 0]
    (points,) = plot_eigenvalues(values)
    assert points.get_ydata() == pytest.approx(upper)
    assert points.axes.get_ylabel() == "frequency (Hz)"
    locus = fl.root_locus(model, "mu_k", [0.5, 1.0])
    curve = plot_root_locus(locus, modes=[0])[0]
    assert curve.get_segments()[0][:, 1] == pytest.approx(locus.frequencies[:, 0])
    assert curve.axes.get_ylabel() == "frequency (Hz)"


def test_swept_values_have_units():
    pytest.importorskip("xarray", reason="the extra data is not installed")
    swept = fl.sweep(MODEL, lambda m: m.F, {"F": [1.0, 2.0], "mu_k": [0.1, 0.2]}, **QUIET).to_xarray()
    assert (swept.F.attrs, swept.mu_k.attrs) == ({"units": "N"}, {})
    diagram = fl.bifurcation(MODEL, "F", [100.0], transient=1.0, window=1.0, **QUIET).to_xarray()
    assert diagram.F.attrs == {"units": "N"}


def test_notebooks_show_tables(run):
    assert "<td>" in run._repr_html_()
    assert "stick" in run._repr_html_()
    pytest.importorskip("pandas", reason="the extra data is not installed")
    assert "frequency (Hz)" in fl.eigenvalues(MODEL)._repr_html_()
    long = fl.sweep(MODEL, lambda m: m.F, {"F": np.linspace(1.0, 2.0, 50)}, **QUIET)._repr_html_()
    assert "F (N)" in long
    assert "50 rows" in long
    assert long.count("<tr") < 15
    assert "&lt;" in fl.sweep(MODEL, Named(), {"F": [1.0]}, **QUIET)._repr_html_()


class Named:
    """A function with a name that HTML would take for a tag."""

    __name__ = "<b>"

    def __call__(self, model):
        return model.F
