"""Every result has `plot`: it draws into given axes or into a figure of its own, and returns the axes."""

import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import frictionlab as fl

MODEL = fl.ModeCoupling(c=0.1)
BELT = fl.MassOnBelt()
SLIDER = fl.SliderOnBelt()
QUIET = {"progress": False}


RESULTS = {
    "run": lambda: fl.simulate(MODEL, 0.5, **QUIET),
    "sweep": lambda: fl.sweep(SLIDER, lambda m: m.F, {"F": [100.0, 200.0]}, **QUIET),
    "plane": lambda: fl.sweep(
        SLIDER, lambda m: m.F, {"F": [100.0, 200.0, 300.0], "mu_k": [0.1, 0.2]}, **QUIET
    ),
    "from two states": lambda: fl.sweep(
        SLIDER, lambda m, x0: m.F, {"F": [100.0, 200.0]}, x0=["rest", "near"], **QUIET
    ),
    "ablation": lambda: fl.ablation(SLIDER, lambda m: m.k1, **QUIET),
    "locus": lambda: fl.root_locus(SLIDER, "mu_k", [0.5, 1.0, 2.0]),
    "eigenvalues": lambda: fl.eigenvalues(SLIDER.replace(mu_k=2.0)),
    "curve": lambda: fl.critical_curve(SLIDER, "mu_k", (0, 3), over=("F", [200.0, 400.0])),
    "map": lambda: fl.stability_map(SLIDER, ("F", [100, 500, 1000]), ("mu_k", [0.5, 1.5])),
    "ends": lambda: fl.ensemble([SLIDER.replace(mu_k=mu) for mu in (0.1, 0.2)], 0.05, **QUIET),
    "steady state": lambda: fl.steady_state(MODEL, transient=5.0, window=2.0, **QUIET),
    "bifurcation": lambda: fl.bifurcation(BELT, "mu_k", [0.2, 0.3], transient=5.0, window=5.0, **QUIET),
    "exponents": lambda: fl.lyapunov(MODEL, transient=1.0, t_end=2.0, blocks=2, **QUIET),
    "energies": lambda: fl.energy_audit(fl.simulate(SLIDER, 0.1, **QUIET), **QUIET),
    "spectrum": lambda: fl.amplitude_spectrum(fl.simulate(MODEL, 20 * MODEL.period, **QUIET)),
}


@pytest.mark.parametrize("name", RESULTS)
def test_a_result_draws_itself(name):
    found = RESULTS[name]()
    alone = found.plot()
    assert isinstance(alone, Axes)
    assert alone._repr_png_().startswith(b"\x89PNG")  # a notebook shows it
    assert alone.has_data()
    ax = Figure().add_subplot()
    assert found.plot(ax).figure is ax.figure
    assert ax.has_data()


def test_panels_of_an_ablation_stand_in_the_axes_given():
    found = fl.ablation(MODEL, lambda m: fl.steady_state(m, transient=5.0, window=2.0, **QUIET), **QUIET)
    ax = Figure().add_subplot()
    first = found.plot(ax)
    assert len(ax.child_axes) == len(found.results)
    assert first is ax.child_axes[0]
    assert found.plot().has_data()


def test_a_sweep_that_is_no_picture_is_refused():
    with pytest.raises(TypeError, match="results must be numbers to be drawn"):
        fl.sweep(SLIDER, lambda m: "text", {"F": [100.0]}, **QUIET).plot()
    values = {"F": [100.0], "mu_k": [0.5], "k1": [1.0]}
    with pytest.raises(ValueError, match="one parameter, or two and one initial state"):
        fl.sweep(SLIDER, lambda m: m.F, values, **QUIET).plot()
