"""Angles that turn are drawn modulo a turn, in matplotlib's pictures and in the page's panels alike."""

import json

import numpy as np
import pytest
import sympy as sp
from matplotlib.figure import Figure

import frictionlab as fl
from frictionlab import plotting
from frictionlab.pages.export import script_text, text_of
from frictionlab.plotting.turns import cut_at_turns
from tests.unit.pages.test_javascript import run_in_node

T = np.linspace(0.0, 9.0, 401)
ANGLES = {"forth": 5.0 * T, "back and forth": 9.0 * np.sin(T), "at rest": 7.0 + 0.0 * T}


@pytest.mark.parametrize("angle", ANGLES.values(), ids=ANGLES)
def test_an_angle_is_cut_where_it_comes_to_half_a_turn(angle):
    shown, time = cut_at_turns(angle, T)
    exact, seen = np.interp(time, T, angle), ~np.isnan(shown)
    assert np.abs(shown[seen]).max() <= np.pi
    assert np.allclose(np.exp(1j * shown[seen]), np.exp(1j * exact[seen]), rtol=0, atol=1e-12)
    assert np.nanmax(np.abs(np.diff(shown))) < np.pi / 4  # no line across
    assert (~seen).sum() == np.count_nonzero(np.diff(np.floor(angle / (2 * np.pi) + 0.5)))
    script = f"""{text_of("turns.js")}
        const found = cutAtTurns({json.dumps(angle.tolist())}, {json.dumps(T.tolist())});
        console.log(JSON.stringify(found.map((values) => Array.from(values))));"""
    in_page = np.array([[np.nan if v is None else v for v in column] for column in run_in_node(script)])
    assert np.array_equal(in_page, [shown, time], equal_nan=True)


def test_points_more_than_half_a_turn_apart_are_not_joined():
    angle = 15.0 * np.arange(9.0)
    script = f"""{text_of("turns.js")}
        console.log(JSON.stringify(Array.from(cutAtTurns({angle.tolist()}, {angle.tolist()})[0])));"""
    for shown in (cut_at_turns(angle, angle)[0], np.array(run_in_node(script), float)):
        assert np.array_equal(np.flatnonzero(~np.isnan(shown)), 4 * np.arange(9))


PHI, OMEGA = sp.symbols("phi omega")
FREE, SPRING = (fl.Mode("only", (OMEGA, torque)) for torque in (sp.S.Zero, -PHI))


def automaton(mode, *cyclic):
    return fl.HybridAutomaton((PHI, OMEGA), (mode,), {}, 1, cyclic)


def test_a_cyclic_angle_turns_and_no_other():
    for model, x0, turns in (
        (fl.DrillString(), "rest", True),
        (fl.FroudePendulum(), "rest", False),
        (fl.FroudePendulum(), [0.0, 40.0], False),  # over the top
        (automaton(FREE, "phi"), [0.0, 1.0], True),
        (automaton(SPRING), [5.0, 0.0], False),
    ):
        run = fl.simulate(model, 60.0, x0=x0, progress=False)
        for lines, axis in (
            (plotting.plot_phase_plane(run), "x"),
            (plotting.plot_displacements(run), "y"),
        ):
            drawn = np.concatenate([getattr(line, f"get_{axis}data")() for line in lines])
            assert np.nanmax(np.abs(drawn)) <= (np.pi if turns else np.inf)
            ticks = [text.get_text() for text in getattr(lines[0].axes, f"get_{axis}ticklabels")()]
            assert (r"$\pi/2$" in ticks) == turns


def in_page(expression):
    scripts = script_text(("turns", "layout", "touch"))
    return run_in_node(f"{scripts}\nconsole.log(JSON.stringify({expression}));")


def test_of_two_cyclic_angles_the_one_that_is_dragged_changes_the_twist_by_the_drag_alone():
    structure = '{ states: ["phi1", "phi2", "w"], cyclic: ["phi1", "phi2"], turning: ["phi1", "phi2"] }'
    shown = "[{ column: (name) => [{ phi1: 100, phi2: 98.5, w: 7 }[name]] }, 0]"
    start = in_page(
        f"startState({{ structure: {structure}, equilibrium: {{ state: [0, 9, 6] }} }}, "
        f"{{ phi1: withinTurn(100.3) }}, {shown})"
    )
    assert abs(start[0]) <= np.pi
    assert np.isclose(start[0] - start[1], 1.8)
    assert start[2] == 6  # as in steady rotation


@pytest.mark.parametrize(("states", "moved"), [(["x", "phi"], ["phi"]), (["x"], ["x"])])
def test_what_turns_is_moved_by_its_angle_where_that_is_a_state(states, moved):
    place = '{ right: "x", up: "", turn: { angle: "phi", right: 1, up: 1, start: 0 } }'
    assert in_page(f"Object.keys(movesOf({place}, 1, {json.dumps(states)}, 0))") == moved


@pytest.mark.parametrize("draw", [plotting.plot_displacements, plotting.plot_phase_plane])
def test_axes_that_show_turns_take_a_second_run(draw):
    ax = Figure().add_subplot()
    for model in (fl.DrillString(), fl.DrillString(), fl.FroudePendulum()):
        draw(fl.simulate(model, 20.0, progress=False), ax)
    axis = ax.xaxis if draw is plotting.plot_phase_plane else ax.yaxis
    assert r"$\pi/2$" in [text.get_text() for text in axis.get_ticklabels()]


def test_a_small_part_of_a_turn_has_the_usual_ticks():
    run = fl.simulate(fl.MotorAndCart(U=0.1), 20.0, progress=False)
    ax = plotting.plot_displacements(run, window=5.0)[0].axes
    low, high = ax.get_ylim()
    assert high - low < np.pi / 2
    assert sum(low <= tick <= high for tick in ax.get_yticks()) > 2
    script = f"""{text_of("turns.js")}{text_of("plot.js")}
        const found = [[0.1, 0.3], [-1, 3]].map((needed) => turnLimits(null, needed));
        const texts = (limits) => new Axis(limits, [0, 300], false, true).ticks(30).texts;
        console.log(JSON.stringify([found, found.map(texts)]));"""
    (part, whole), (texts, halves) = run_in_node(script)
    assert part[0] <= 0.1 < 0.3 <= part[1] < 0.5
    assert np.allclose(whole, [-np.pi / 2, np.pi])
    assert len(texts) > 2
    assert halves == ["−π/2", "0", "π/2", "π"]


def test_a_steady_rotation_is_marked_within_a_turn():
    steady = fl.steady_state(fl.DrillString(Omega=25.0), progress=False)
    (cross,) = plotting.plot_steady_state(steady)
    (x,), (rate,) = cross.get_data()
    final = dict(zip(steady.trajectory.names, steady.trajectory.final_state))
    assert abs(x) <= np.pi
    assert np.exp(1j * x) == pytest.approx(np.exp(1j * final["phi1"]), abs=1e-9)
    low, high = cross.axes.get_ylim()
    assert low < rate == final["phi1'"] < high


def test_ends_and_attractors_of_what_turns_are_drawn_within_a_turn():
    slow, steady = (fl.DrillString(Omega=speed) for speed in (6.0, 25.0))
    ends = fl.ensemble(
        [slow] * 3, 60.0, x0=[[0.0, twist, 6.0, 6.0] for twist in (0.0, 1.0, 9.0)], progress=False
    )
    (points,) = ends.plot().get_lines()
    assert np.abs(ends.states[:, 0]).max() > 100.0
    assert np.abs(points.get_xdata()).max() <= np.pi
    assert np.allclose(np.exp(1j * points.get_xdata()), np.exp(1j * ends.states[:, 0]))
    angles = np.linspace(2.0, 8.0, 3)  # a turn about 5
    for model in (slow, steady):
        basins = fl.basins(model, ("phi1", angles), ("phi1'", [6.0, 25.0]), progress=False)
        for line in plotting.plot_basins(basins).attractors:
            x, path = line.get_xdata(), basins.attractors[0].path[:, 0]
            assert np.nanmax(np.abs(x - 5.0)) <= np.pi
            shown = np.exp(1j * x[~np.isnan(x)])
            assert np.abs(shown[:, None] - np.exp(1j * path)).min(axis=0).max() < 1e-9


def test_angles_are_dashed_beside_lengths_alone():
    for model, dashed in ((fl.FroudePendulum(), {False}), (fl.Woodpecker(), {False, True})):
        run = fl.simulate(model, 1.0, progress=False)
        for draw in (plotting.plot_displacements, plotting.plot_rates):
            assert {line.get_linestyle() != "-" for line in draw(run)} == dashed
