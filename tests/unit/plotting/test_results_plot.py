"""Every result has `plot`: it draws into given axes or into a figure of its own, and returns the axes."""

import inspect

import numpy as np
import pytest
import sympy
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import frictionlab as fl
from frictionlab.models.mechanism import Block, Forces, Load, Mechanism, Point
from frictionlab.plotting.animation.parts import LONGEST
from frictionlab.plotting.appearance import BLACK
from frictionlab.plotting.figure import RunFigure
from tests.helpers.cases import slow_but
from tests.helpers.results import BUILDERS, result

MODEL = fl.ModeCoupling(c=0.1)
BELT = fl.MassOnBelt()
SLIDER = fl.SliderOnBelt()
LINEAR = SLIDER.without("cubic", "nonsmooth", "geometry")
QUIET = {"progress": False}
PARTS_OF_RESULTS = {"stability change", "boundary", "special orbit", "attractor", "events", "section points"}
MODELS = {"reduced structure"}


def drawn_with_a_legend(y, **options):
    """Whether the legend is within the panel, once the figure is shown."""
    ax = RunFigure(figsize=(4, 3), layout="constrained").subplots()
    ax.plot(np.linspace(0.0, 1.0, len(y)), y, label="a line with a long name", **options.pop("line", {}))
    legend = ax.legend(**options)
    ax.figure._repr_png_()
    return legend.get_window_extent().x1 < ax.bbox.x1


def test_a_legend_that_would_cover_a_line_stands_beside_the_panel():
    waves = np.cos(np.linspace(0.0, 60.0, 600))
    assert not drawn_with_a_legend(waves)
    assert not drawn_with_a_legend(waves, line={"marker": ".", "linestyle": "none"})
    assert drawn_with_a_legend(waves, loc="upper right")  # as somebody wants it
    assert drawn_with_a_legend(np.linspace(0.0, 1.0, 9))


WHOLE = [name for name in BUILDERS if name not in PARTS_OF_RESULTS | MODELS]


@pytest.mark.parametrize("name", slow_but(WHOLE[::3], WHOLE))  # most have tests of what is drawn
def test_a_result_draws_itself(name):
    found = result(name)
    alone = found.plot()
    assert isinstance(alone, Axes)
    assert alone._repr_png_().startswith(b"\x89PNG")  # a notebook shows it
    assert alone.has_data()
    ax = Figure().add_subplot()
    assert found.plot(ax).figure is ax.figure
    drawn = ax.child_axes or [ax]  # an ablation of motions draws panels
    assert all(one.has_data() for one in drawn)


def test_a_sweep_that_is_no_picture_is_refused():
    with pytest.raises(TypeError, match="results must be numbers to be drawn"):
        fl.sweep(SLIDER, lambda m: "text", {"F": [100.0]}, **QUIET).plot()
    values = {"F": [100.0], "mu_k": [0.5], "k1": [1.0]}
    with pytest.raises(ValueError, match="one parameter, or two and one initial state"):
        fl.sweep(SLIDER, lambda m: m.F, values, **QUIET).plot()


def test_no_class_that_a_public_function_returns_is_without_a_picture():
    shown_otherwise = {"Explorer", "FrontEnd", "Sound", "ModelTable", "ReducedStructure"}
    functions = filter(inspect.isfunction, (getattr(fl, name) for name in fl.__all__))
    returned = {inspect.signature(function).return_annotation for function in functions}
    results = returned & set(fl.__all__) - shown_otherwise
    assert {"Equilibrium", "HopfPoint", "TangentFlow", "Verification"} <= results
    assert [name for name in sorted(results) if not callable(getattr(getattr(fl, name), "plot", None))] == []


def labels_of(ax):
    return [text.get_text() for text in ax.get_legend().get_texts()]


def test_an_equilibrium_is_the_mechanism_displaced_to_it():
    model = fl.SliderOnRigidBelt()
    found = fl.equilibrium(model)
    ax = found.plot()
    body = max(ax.patches, key=lambda patch: patch.get_zorder())
    factor = float(ax.get_xlabel().removeprefix("displacements × "))
    centre = body.get_xy()[:4].mean(axis=0)
    assert centre == pytest.approx([factor * found.q[0], 0.8 - factor * found.q[1]])  # y is into the belt
    assert labels_of(ax) == [f"$F_N$ = {found.normal_force:.4g} N", f"$F_T$ = {found.friction_force:.4g} N"]


@pytest.mark.slow
def test_an_equilibrium_without_a_mechanism_is_bars_of_the_displacements():
    found = fl.equilibrium(SLIDER.automaton())
    ax = found.plot()
    assert [bar.get_height() for bar in ax.patches] == pytest.approx(found.q.tolist())
    assert [tick.get_text() for tick in ax.get_xticklabels()][3:] == ["$y_{2}$", r"$\varphi$"]
    assert ax.get_ylabel() == "state"  # an automaton tells no units


def test_a_hopf_point_shows_the_vibration_on_its_side():
    point = fl.hopf(SLIDER, "mu_k", (0, 4))
    ax = point.plot(name="x2")
    below, above, vibration, end, critical = ax.lines
    assert [line.get_linestyle() for line in (below, above, vibration)] == ["-", "--", "--"]
    values, amplitudes = vibration.get_data()
    assert values.max() == pytest.approx(point.value)
    assert amplitudes == pytest.approx(point.amplitude(values)[:, 2])
    assert end.get_xdata()[0] == pytest.approx(point.valid_until, abs=1e-9)
    assert critical.get_xdata()[0] == point.value
    assert ax.get_ylabel() == "amplitude of $x_{2}$ (m)"
    assert ax.get_title().startswith("Subcritical")
    with pytest.raises(ValueError, match="name"):
        point.plot(name="z")


def test_a_load_on_a_body_with_two_contacts_keeps_its_name_colour_and_size():
    @fl.model
    class Loaded(fl.MechanicalModel):
        P: float = 200.0
        friction: fl.FrictionLaw = fl.Coulomb()
        coordinates = "x", "y"

        def mechanics(self, q, v):
            contacts = (fl.Friction(0.5 - rate, self.P, self.friction) for rate in v)
            return fl.Mechanics((v.x**2 + v.y**2) / 2, 5 * (q.x**2 + q.y**2), contacts=tuple(contacts))

        @property
        def mechanism(self):
            body = Point(0.0, 0.0, right="x", up="y")
            return Mechanism(Block(body), Load(body, "P"), Forces(body, "_1"))

    point = fl.equilibrium(Loaded())
    assert np.isnan(point.normal_force)  # one number cannot be that of two contacts
    ax = point.plot()
    (entry,) = ax.get_legend().get_lines()
    assert (entry.get_label(), entry.get_color()) == ("$P$ = 200 N", BLACK)
    arrow = next(line for line in ax.lines if line.get_color() == BLACK)
    assert np.ptp(arrow.get_ydata()) == pytest.approx(LONGEST)


def test_a_supercritical_vibration_is_solid_where_no_other_mode_grows():
    x, v = sympy.symbols("x v")
    mu = sympy.Symbol("mu")
    mode = fl.Mode("only", (v, mu * v - x - x**2 * v))
    automaton = fl.HybridAutomaton((x, v), (mode,), {mu: -0.1})
    assert fl.equilibrium(automaton).plot().get_ylabel() == "state"
    point = fl.hopf(automaton, "mu", (-1, 1))
    ax = point.plot()
    vibration = next(line for line in ax.lines if line.get_label() == "stable vibration")
    assert vibration.get_linestyle() == "-"
    values, amplitudes = vibration.get_data()
    assert amplitudes == pytest.approx(2 * np.sqrt(np.maximum(values, 0.0)), abs=1e-7)  # van der Pol's
    assert ax.get_ylabel() == "amplitude of $x$"  # of no known unit
    assert "reaches stick or separation" not in labels_of(ax)


def test_a_degenerate_hopf_point_shows_no_vibration():
    ax = fl.hopf(LINEAR, "mu_k", (0, 6)).plot()
    assert labels_of(ax)[:2] == ["stable equilibrium", "unstable equilibrium"]
    assert len(ax.lines) == 3


def test_a_tangent_flow_is_its_matrix_in_colours_and_numbers():
    flow = fl.tangent_flow(fl.simulate(MODEL, 0.5, x0="near", **QUIET), **QUIET)
    ax = flow.plot()
    (mesh,) = ax.collections
    assert np.array_equal(mesh.get_array(), flow.matrix)
    assert mesh.norm(0.0) == pytest.approx(0.5)  # white
    assert [text.get_text() for text in ax.texts] == [f"{entry:.2g}" for entry in flow.matrix.ravel()]
    assert [tick.get_text() for tick in ax.get_xticklabels()] == ["$x$", "$y$", r"$\dot{x}$", r"$\dot{y}$"]
    top, bottom = ax.get_ylim()[::-1]
    assert top < bottom  # the first row is on top


def test_a_verification_shows_what_it_found_beside_the_limits():
    found = fl.verify(BELT, 2.0, **QUIET)
    ax = found.plot()
    sizes, limits = (line.get_xdata() for line in ax.lines)
    names = [tick.get_text() for tick in ax.get_yticklabels()]
    assert names == ["deviation from other runs", *(f"defect in mode {mode}" for mode in found.defect)]
    assert sizes[0] == max(found.error, np.finfo(float).eps)
    assert limits[0] == 1e-4
    assert (sizes < limits).all()
    assert ax.get_xscale() == "log"
    assert ax.get_title() == "To be trusted up to t = 2 s; the events agree"


def test_a_run_not_to_be_trusted_stands_beyond_its_limit():
    found = fl.verify(BELT, 6.0, method=fl.RK4(1.0), **QUIET)
    assert not found.ok
    ax = found.plot()
    assert ax.get_title().startswith("Not to be trusted")
    sizes, limits = (line.get_xdata() for line in ax.lines)
    assert sizes[0] == found.error
    assert np.isnan(limits[1:]).all()  # RK4 has no tolerance
