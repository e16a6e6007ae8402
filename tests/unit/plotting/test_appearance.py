"""Styles, the user's settings of matplotlib, and contrast on dark backgrounds."""

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.axis import Tick, XTick
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.quiver import Quiver
from matplotlib.spines import Spine
from matplotlib.style import context
from matplotlib.text import Text

import frictionlab as fl
from frictionlab import plotting
from frictionlab.plotting import appearance
from tests.helpers.pictures import figures
from tests.helpers.results import result

SEEN_CONTRAST = (
    3.0  # that WCAG 2 asks for lines; ours are made for 4.5, before they are blended at their edges
)
FIGURES = figures()
SHOWN = (Line2D, Text, LineCollection, Quiver)


@pytest.fixture(autouse=True)
def settings_as_they_were():
    with mpl.rc_context():
        yield


def luminances(pixels):
    colour = pixels[..., :3] / 255.0
    linear = np.where(colour <= 0.04045, colour / 12.92, ((colour + 0.055) / 1.055) ** 2.4)
    return linear @ [0.2126, 0.7152, 0.0722]


def in_view(tick):
    """Whether a tick is within the limits of its axis; others are kept but not drawn."""
    low, high = sorted(tick.axes.get_xlim() if isinstance(tick, XTick) else tick.axes.get_ylim())
    return low <= tick.get_loc() <= high


def around(artist, renderer, shape):
    """Rows and columns of the pixels that an artist may change."""
    box = artist.get_window_extent(renderer).padded(20.0)
    (left, low), (right, high) = np.clip(box.get_points(), 0, [shape[1], shape[0]]).astype(int)
    return slice(shape[0] - high, shape[0] - low), slice(left, right)


def contrasts(figure):
    """Contrast of every line and text that is drawn with what is behind it, by the artist."""
    canvas = FigureCanvasAgg(figure)
    figure.set_dpi(100.0)
    canvas.draw()
    hidden = {part for tick in figure.findobj(Tick) if not in_view(tick) for part in tick.get_children()}
    found = {*figure.findobj(lambda artist: isinstance(artist, SHOWN))} - hidden
    artists = [artist for artist in found if artist.get_visible()]
    for artist in [*artists, *figure.findobj(Spine)]:  # lines may lie on the frame of the axes
        artist.set_visible(False)
    figure.set_layout_engine("none")
    canvas.draw()
    renderer, empty = canvas.get_renderer(), np.array(canvas.buffer_rgba())
    kept, found = renderer.copy_from_bbox(figure.bbox), {}
    for artist in artists:
        artist.set_visible(True)
        renderer.restore_region(kept)
        artist.draw(renderer)
        artist.set_visible(False)
        part = around(artist, renderer, empty.shape)
        now, before = np.asarray(canvas.buffer_rgba())[part], empty[part]
        changed = (now != before).any(axis=-1)
        if changed.any():
            low, high = np.sort([luminances(now[changed]), luminances(before[changed])], axis=0)
            found[artist] = float(np.quantile((high + 0.05) / (low + 0.05), 0.95))
    return found


DARK = [*(("dark_background", n) for n in FIGURES), *(("dark", n) for n in ("overview", "map", "basins"))]


@pytest.mark.slow
@pytest.mark.parametrize(("way", "name"), DARK)
def test_every_line_and_text_is_seen_on_a_dark_background(way, name):
    with context("dark_background") if way == "dark_background" else fl.style("dark"):
        figure = FIGURES[name]()
        found = contrasts(figure)
    assert len(found) >= 8
    unseen = {str(artist): round(ratio, 2) for artist, ratio in found.items() if ratio < SEEN_CONTRAST}
    assert unseen == {}


def test_the_measure_of_contrast_sees_what_is_hidden():
    with context("dark_background"):
        figure = Figure()
        line, seen = (figure.add_subplot().plot([0, 1], [0, 1], color=c)[0] for c in ("black", "white"))
        found = contrasts(figure)
    assert found.get(line, 1.0) < 1.5
    assert found[seen] > 15.0


def test_axes_that_are_dark_themselves_have_light_lines():
    figure = Figure()
    ax = figure.add_subplot(facecolor="black")
    line = plotting.plot_displacements(result("run"), ax)[0]
    assert appearance.luminance(line.get_color()) > 0.8


def plain_line():
    return plotting.plot_displacements(result("run"))[0]


def test_the_width_of_lines_is_the_users():
    assert plain_line().get_linewidth() == 1.2
    mpl.rcParams["lines.linewidth"] = 3.0
    assert plain_line().get_linewidth() == pytest.approx(3.0)
    assert plotting.plot_spectrum(result("run of two contacts"))[0].get_linewidth() == pytest.approx(2.5)


@pytest.mark.parametrize(
    "name", ["overview", "run", *(pytest.param(n, marks=pytest.mark.slow) for n in ("energies", "animation"))]
)
def test_the_size_of_figures_is_the_users(name):
    usual = FIGURES[name]().get_size_inches()
    mpl.rcParams["figure.figsize"] = (5.0, 3.5)
    assert tuple(FIGURES[name]().get_size_inches()) == (5.0, 3.5)
    assert tuple(usual) != (5.0, 3.5)


@pytest.mark.slow
def test_a_style_holds_within_its_block_or_from_then_on():
    before = dict(mpl.rcParams)
    with fl.style("projector"):
        inside = plain_line()
    assert dict(mpl.rcParams) == before
    assert inside.get_linewidth() == pytest.approx(2.4)
    fl.style("paper")
    assert plain_line().get_linewidth() == pytest.approx(1.0)
    assert tuple(plain_line().figure.get_size_inches()) == appearance.STYLES["paper"]["figure.figsize"]
    fl.style("screen")
    after = plain_line()
    assert (after.get_linewidth(), tuple(after.figure.get_size_inches())) == (1.2, (7.0, 4.0))


def test_the_users_settings_prevail_over_a_style():
    with fl.style("projector"):
        mpl.rcParams["lines.linewidth"] = 5.0
        assert plain_line().get_linewidth() == pytest.approx(5.0)


def test_legible_changes_only_what_is_hidden():
    assert appearance.legible(appearance.YELLOW) == appearance.YELLOW  # on white as it was
    with context("dark_background"):
        assert appearance.legible(appearance.YELLOW) == appearance.YELLOW
        assert appearance.legible(appearance.BLACK) == "#ffffff"
        for colour in ("#0072B2", "#444444", "#00008B", "#300000"):
            assert appearance.contrast(appearance.legible(colour), "black") >= appearance.MIN_CONTRAST
    assert appearance.contrast("black", "white") == pytest.approx(21.0)


def lightness(colour):
    """L* of CIELAB, from 0 for black to 100 for white."""
    return 116.0 * appearance.luminance(colour) ** (1 / 3) - 16.0


def test_in_print_lightness_alone_tells_colours_apart():
    shades = sorted(map(lightness, appearance.PRINT_COLOURS.values()))
    assert min(np.diff(shades)) > 7.0


@pytest.mark.parametrize("name", ["paper", "book"])
def test_a_grey_copy_tells_modes_apart_by_dashes_and_hatching(name):
    run = result("run")
    with fl.style(name):
        ax = Figure().add_subplot()
        lines = [
            (line["linestyle"], line["linewidth"] > 1.5) for line in appearance.mode_lines(run, ax).values()
        ]
        fills = [(fill["facecolor"], fill["hatch"]) for fill in appearance.mode_fills(run, ax).values()]
    assert len({*lines}) == len({*fills}) == len(run.mode_names) == 5


def test_any_number_of_modes_is_drawn_in_print():
    assert {*appearance.MODE_COLOURS.values()} <= {*appearance.PRINTED_MODES}
    with fl.style("paper"):
        figure = fl.plot_run(result("run of two contacts"))
    assert len(figure.legends[0].get_texts()) > 1


def test_each_of_sixty_modes_has_a_line_and_an_area_of_its_own():
    looks = appearance.looks_of_modes((i, f"mode {i}") for i in range(60)).values()
    for lines, areas in (
        (
            [(look.colour, look.dashes) for look in looks],
            [(look.colour, look.hatch) for look in looks],
        ),
        (
            [(look.printed.dashes, look.printed.width, look.printed.grey) for look in looks],
            [(look.printed.fill, "".join(sorted(look.printed.hatch))) for look in looks],
        ),
    ):
        assert len({*lines}) == len({*areas}) == 60
    for place, look in enumerate([*looks][:27]):  # those of one colour differ in lightness
        shades = [lightness(other.colour) for other in [*looks][place % 9 : place : 9]]
        assert all(abs(shade - lightness(look.colour)) > 5.0 for shade in shades)


def test_a_mode_of_another_name_has_not_the_colour_of_stick():
    looks = appearance.looks_of_modes(enumerate(["stick", "slip", "flight", "rest"]))
    assert len({look.colour for look in looks.values()}) == 4


@pytest.mark.parametrize("name", ["overview", "run"])
def test_pictures_in_print_have_no_titles_and_one_font(name):
    with fl.style("book"):
        figure = FIGURES[name]()
        assert [ax.get_title() for ax in figure.axes] == [""] * len(figure.axes)
        assert figure.get_suptitle() == ""
        assert mpl.rcParams["mathtext.fontset"] == "stix"
        assert {text.get_fontname() for text in figure.findobj(Text) if text.get_text()} == {"STIXGeneral"}
