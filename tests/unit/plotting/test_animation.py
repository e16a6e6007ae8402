"""The animation shows the run: places, contact, forces and colours, frame by frame."""

import re
import sys
from io import BytesIO
from types import SimpleNamespace

import numpy as np
import pytest
import sympy as sp
from matplotlib import rc_context, rcParams
from matplotlib.animation import FuncAnimation, writers
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from PIL import Image

import frictionlab as fl
from frictionlab.models.mechanism import Belt, Block, Mechanism, Point
from frictionlab.plotting.animation.animate import HistoryPicture, check_film_path, frame_times
from frictionlab.plotting.animation.parts import belt_outline, outlines_of, parts, spring_outline
from frictionlab.plotting.appearance import BLUE, MODE_COLOURS
from frictionlab.plotting.figure import AnimatedFigure
from tests.helpers.cases import slow_but
from tests.helpers.results import result

MODEL = fl.SliderOnBelt(mu_k=1.4)
SCENES = {
    "all": MODEL,
    "4 dof": MODEL.without("geometry"),
    "sliding only": MODEL.without("nonsmooth"),
    "stick-slip": MODEL.replace(interface=fl.StickSlip()),
    "backwards, one wheel": MODEL.replace(v=-1.0, l1=0.0, l2=0.3),
    "light": MODEL.replace(F=0.5, v=0.01),
}
T = frame_times(0.0, 0.4, 0.002)


@pytest.fixture(scope="module", params=slow_but(["all"], SCENES))
def run(request):
    return fl.simulate(SCENES[request.param], 0.4, t_eval=T, progress=False)


def drawn(run, **options):
    """The picture of a run, and the rows of its shapes by kind."""
    picture = parts(run, run.source.mechanism, T, **options)
    kinds = {shape.kind for shape in picture.shapes}
    return picture, {kind: [s.rows for s in picture.shapes if s.kind == kind] for kind in kinds}


def magnification(picture):
    return float(picture.note.split(" × ")[1].split(",")[0])


def surface(row, x):
    """Height of the drawn belt's upper side at x, from its outline alone."""
    corners = outlines_of("belt", row)[0]
    top = corners[:, : corners.shape[1] // 5]  # the first fifth of its way lies on the upper side
    slope, height = np.polyfit(*top, 1)
    return slope * x + height


@pytest.mark.parametrize("magnify", [None, 3.0])
def test_the_slider_is_where_the_run_has_it_magnified(run, magnify):
    picture, rows = drawn(run, magnify=magnify)
    s, (slider,) = magnification(picture), rows["block"]
    assert magnify in (None, s)
    assert slider[:, 0] == pytest.approx(s * run["x1"], abs=1e-12)
    assert slider[:, 1] - slider[0, 1] == pytest.approx(s * (run["y1"] - run["y1"][0]), abs=1e-12)


def test_the_foot_is_on_the_belt_in_contact_and_above_it_in_flight(run):
    picture, rows = drawn(run)
    s, (belt,) = magnification(picture), rows["belt"]
    (place,) = (i for i, shape in enumerate(picture.shapes) if "nl" in shape.label)
    foot, plate = picture.shapes[place].rows, picture.shapes[place + 1].rows
    assert plate == pytest.approx(foot[:, [0, 1, 0, 1]] + [0.1, 0.0, -0.1, 0.0])
    for k in range(0, len(T), 3):
        x, y, above, top = foot[k]
        flying = run.mode[k] == "separation"
        # What is drawn between slider and belt is the gap of the run, magnified.
        gap = y - surface(belt[k], x)
        assert gap == pytest.approx(-s * run.penetration[k] if flying else 0.0, abs=1e-11)
        assert not flying or gap > 0
        assert 0.8 - (top - y) == pytest.approx(0.0 if flying else s * run.penetration[k], abs=1e-11)
        assert above == pytest.approx(x)
        assert picture.mode[k] == run.mode[k]


def test_the_belt_tilts_about_wheels_of_its_size(run):
    _, rows = drawn(run)
    (x1, y1, x2, y2, *_), p = rows["belt"][0].T, run.source.parameters
    phi = run["phi"] if "phi" in run.names else 0.0 * T
    assert (y2 - y1) / (x2 - x1) == pytest.approx(-phi, abs=1e-12)
    ends = [max(p[name] / max(p["l1"], p["l2"]), 0.25) for name in ("l1", "l2")]
    assert np.hypot(x2 - x1, y2 - y1) == pytest.approx(sum(ends))


def test_springs_along_the_axes_stay_so_as_their_energies_have_it(run):
    picture, _ = drawn(run)
    ends = {shape.label: shape.rows.T for shape in picture.shapes if shape.kind == "spring"}
    for name, axis in ("$k_1$", 1), ("$k_4$", 1), ("$k_5$", 0), ("$k_6$", 0):
        assert ends[name][axis] == pytest.approx(ends[name][axis + 2], abs=1e-12)


def test_a_slider_that_sticks_moves_with_the_marks_on_the_belt():
    run = fl.simulate(SCENES["4 dof"], 0.4, t_eval=T, progress=False)
    _, rows = drawn(run)
    (slider,), (belt,) = rows["block"], rows["belt"]
    apart = np.diff(slider[:, 0] - belt[:, 0] - belt[:, 5])
    edges = np.searchsorted(run.events.t, T)
    stuck = (run.mode[:-1] == "stick") & (edges[1:] == edges[:-1])
    assert stuck.sum() > 20
    assert np.abs(apart[stuck]).max() < 1e-12
    assert np.abs(apart[~stuck]).max() > 1e-4


def test_arrows_are_the_forces_and_vanish_in_flight(run):
    _, rows = drawn(run)
    normal, friction, load = (vectors[:, 2:] for vectors in rows["arrow"])
    preload = run.source.F
    scale = preload / -load[0, 1]
    assert load == pytest.approx(np.tile([0.0, -preload / scale], (len(T), 1)))
    assert scale * normal[:, 1] == pytest.approx(run.normal_force)
    assert scale * friction[:, 0] == pytest.approx(run.friction_force)
    assert not np.any([normal[:, 0], friction[:, 1]])
    for k in np.flatnonzero(run.mode == "separation"):
        assert np.isnan(outlines_of("arrow", rows["arrow"][0][k])[0]).all()
    largest = max(np.abs(run.normal_force).max(), np.abs(run.friction_force).max(), preload)
    assert largest / scale == pytest.approx(0.6)


def test_the_animation_follows_mode_time_and_state(run):
    figure = Figure()
    animation = fl.animate(run, window=None, speed=0.04, fps=20, figure=figure)
    assert isinstance(animation, FuncAnimation)
    FigureCanvasAgg(figure)
    picture, phase = figure.axes
    slider = max(picture.patches, key=lambda patch: patch.get_zorder())  # drawn last
    arrow = next(line for line in picture.lines if to_hex(line.get_color()).upper() == BLUE)
    count, s = 0, float(picture.get_xlabel().split(" × ")[1].split(",")[0])
    for k, _ in enumerate(animation.new_frame_seq()):
        animation._draw_frame(k)
        count += 1
        assert to_hex(slider.get_facecolor()).upper() == MODE_COLOURS[run.mode[k]]
        # What is on the figure: the slider's centre, and the foot of the arrow of its normal force there.
        centre = slider.get_xy()[:4].mean(axis=0)
        assert centre[0] == pytest.approx(s * run["x1"][k], abs=1e-12)
        assert centre[1] - 0.95 == pytest.approx(s * run["y1"][k], abs=1e-12)
        if run.normal_force[k] > 0:
            assert np.transpose(arrow.get_data())[0] == pytest.approx(centre)
        x, rate = phase.lines[-1].get_data()
        assert (x[0], rate[0]) == (run["x1"][k], run["x1'"][k])
        assert picture.get_title() == f"t = {T[k]:.3f} s: {run.mode[k]}; 25 times slower"
    assert count == len(T)
    animation._draw_was_started = True  # nothing was written on purpose
    assert re.fullmatch(r"displacements × [\d.e+]+(, angles × 1)?", picture.get_xlabel())
    shown = {text.get_text() for text in figure.legends[0].get_texts()}
    assert set(run.mode) <= shown
    assert len(shown) == len(set(run.mode)) + 3


@pytest.mark.slow
def test_a_run_that_does_not_move_is_drawn():
    model = MODEL.without("nonsmooth").replace(F=0.0)
    run = fl.simulate(model, 0.02, progress=False)
    assert not run.states.any()
    assert fl.animate(run, speed=0.05, fps=5).to_jshtml().count("data:image/png") == 3


def test_the_belt_runs_around_its_wheels():
    length, r = 0.4, 0.05
    loop = 2 * (length + np.pi * r)
    points = belt_outline(np.linspace(0.0, loop, 20001), length, r)
    steps = np.hypot(*np.diff(points))
    assert steps.sum() == pytest.approx(loop, rel=1e-7)
    assert np.allclose(points[:, 0], points[:, -1])
    axis = np.clip(points[0], 0.0, length)  # nearest point between the wheels' centres
    assert np.allclose(np.hypot(points[0] - axis, points[1]), r)


def test_a_spring_joins_its_ends_and_stays_within_its_width():
    points = spring_outline((1.0, 1.0), (4.0, 5.0), 0.5)
    assert np.allclose(points[:, 0], (1.0, 1.0))
    assert np.allclose(points[:, -1], (4.0, 5.0))
    across = np.array([-0.8, 0.6]) @ (points - 1.0)
    assert np.abs(across).max() == pytest.approx(0.25)


@pytest.mark.slow
def test_an_automaton_of_a_model_is_animated_without_the_model():
    run = fl.solve(MODEL.automaton(), 0.05, x0=np.zeros(10), progress=False)
    animation = fl.animate(run, speed=0.05, fps=1)
    assert animation.to_jshtml().count("data:image/png") == 2


def test_an_automaton_without_coordinates_is_animated_by_its_states():
    x, y = sp.symbols("x y")
    spiral = fl.HybridAutomaton((x, y), (fl.Mode("on", (y - x / 9, -x)),), {}, period=6.0)
    run = fl.solve(spiral, 12.0, x0=[1.0, 0.5], progress=False)
    animation, ends = fl.animate(run, window=12.0, fps=1, speed=6.0), []
    animation._draw_was_started = True  # it is not shown, which matplotlib warns of
    for frame in (0, 2):
        animation._func(frame)
        ends.append(np.ravel(animation._fig.axes[1].lines[-1].get_data()))
    assert np.allclose(ends, [[1.0, 0.5], run.final_state])
    assert [ax.get_xlabel() for ax in animation._fig.axes] == ["time (s)", "$x$"]
    alone = fl.HybridAutomaton((x,), (fl.Mode("on", (-x,)),), {})
    with pytest.raises(ValueError, match="run must have two states, got x alone"):
        fl.animate(fl.solve(alone, 1.0, x0=[1.0], progress=False), window=1.0)


def test_a_belt_travels_where_no_point_is_displaced():
    run = fl.simulate(fl.MassOnBelt(v=0.5), 2.0, progress=False)
    picture = parts(run, Mechanism(Belt("v"), Block(Point(0.0, 0.2))), np.array([0.0, 2.0]))
    assert picture.shapes[0].rows[:, 5].tolist() == [0.0, 1.0]
    assert picture.note == "angles × 1"


def test_the_legend_of_a_history_has_all_coordinates_and_no_modes():
    run, ax = result("run"), Figure().add_subplot()
    HistoryPicture(run, run.t).draw(ax)
    (legend,) = (each.get_legend() for each in ax.figure.axes if each.get_legend())
    assert len(legend.get_texts()) == run.automaton.coordinates


@pytest.mark.slow
def test_a_file_is_written(tmp_path):
    run = fl.simulate(MODEL, 0.1, progress=False)
    fl.animate(run, speed=0.1, fps=6).save(tmp_path / "run.gif", writer="pillow")
    with Image.open(tmp_path / "run.gif") as image:
        assert image.n_frames == 7


@pytest.mark.slow
def test_a_page_holds_all_its_frames(tmp_path):
    """One file, which can be sent to someone."""
    page = tmp_path / "run.html"
    fl.animate(fl.simulate(MODEL, 0.1, progress=False), speed=0.1, fps=2).save(page)
    assert page.read_text(encoding="utf-8").count("data:image/png") == 3
    assert list(tmp_path.iterdir()) == [page]


@pytest.mark.slow
def test_frames_are_those_that_matplotlib_draws_in_full():
    run = fl.simulate(MODEL, 0.4, t_eval=T, progress=False)
    figure = AnimatedFigure(figsize=(8.0, 4.0), dpi=80, layout="constrained")
    animation = fl.animate(run, window=None, speed=0.08, fps=2, figure=figure)
    animation._draw_was_started = True
    for frame, dpi in ((0, 80), (5, 80), (3, 120), (9, 80)):
        animation._func(frame)
        figure.savefig(part := BytesIO(), format="rgba", dpi=dpi)
        figure.savefig(png := BytesIO(), format="png", dpi=dpi)
        Figure.savefig(figure, whole := BytesIO(), format="rgba", dpi=dpi)
        assert part.getvalue() == whole.getvalue()
        with Image.open(png) as image:
            assert image.convert("RGBA").tobytes() == whole.getvalue()


def test_a_film_that_needs_ffmpeg_is_refused_before_it_is_drawn(monkeypatch, tmp_path):
    monkeypatch.setattr(writers, "is_available", lambda name: False)
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    film = fl.animate(result("run"), speed=0.1, fps=6)
    film._draw_was_started = True  # else matplotlib warns of a film that nobody saw
    with pytest.raises(ValueError, match=r"got '.*run.mp4': pip install imageio-ffmpeg, or write run.gif"):
        film.save(tmp_path / "run.mp4", progress_callback=lambda *_: pytest.fail("a frame was drawn"))


def test_a_film_takes_the_ffmpeg_of_a_package(monkeypatch):
    known = []
    monkeypatch.setattr(writers, "is_available", lambda name: bool(known))
    package = SimpleNamespace(get_ffmpeg_exe=lambda: known.append("there") or "/somewhere/ffmpeg")
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", package)
    with rc_context():
        assert check_film_path("filename", "run.MP4").name == "run.MP4"
        assert rcParams["animation.ffmpeg_path"] == "/somewhere/ffmpeg"
