"""How pictures look: `fl.style`, and colours and sizes that follow the user's settings of matplotlib.

With matplotlib's default settings, pictures have the package's colours on white.  Where settings in
``matplotlib.rcParams`` were changed, the widths and colours of lines and the sizes of texts, markers and
figures follow them.  On a dark background a colour that could not be seen is replaced by one that can:
`legible`.  Otherwise colours that mean something, such as those of modes, are the same everywhere.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from contextlib import ExitStack
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_hex, to_rgb, to_rgba
from matplotlib.patheffects import Normal, Stroke
from matplotlib.rcsetup import cycler

from frictionlab.validation import check_choice

if TYPE_CHECKING:
    from frictionlab.hybrid.trajectory import Trajectory

# Okabe & Ito 2008: colours that colour-blind readers can tell apart
BLACK, ORANGE, SKY, GREEN = "#000000", "#E69F00", "#56B4E9", "#009E73"
BLUE, VERMILLION, PURPLE, GREY = "#0072B2", "#D55E00", "#CC79A7", "#999999"
YELLOW, WHITE = "#F0E442", "#FFFFFF"

LINE_COLOURS = (BLACK, VERMILLION, BLUE, GREEN)
LINE_WIDTH = 1.2  # points
DASHED = (0, (4, 1.5))
PANEL_SIZE = 7.0, 4.0  # inches of a figure with one panel
MODE_COLOURS = MappingProxyType(
    {
        "stick": ORANGE,
        "slip+": GREY,
        "slip": GREY,
        "slip-": PURPLE,
        "breakaway": PURPLE,
        "separation": SKY,
        "chatter": YELLOW,
    },
)
# Colours of energies, of the works that change them, and spare ones for names of a model's own.
ENERGY_COLOURS = MappingProxyType(
    {"kinetic": BLUE, "springs": GREEN, "contact": VERMILLION, "preload": ORANGE},
)
WORK_COLOURS = MappingProxyType(
    {
        "belt drive": BLUE,
        "friction": VERMILLION,
        "dampers": GREEN,
        "impacts": ORANGE,
        "moving load": PURPLE,
    },
)
SPARE_COLOURS = (SKY, PURPLE, GREEN, ORANGE, YELLOW)

# In print each colour has a lightness of its own, so that a grey copy tells them apart.
PRINT_COLOURS = MappingProxyType(
    {
        BLUE: "#004166",
        PURPLE: "#754660",
        GREEN: "#007C5B",
        VERMILLION: "#D45D00",
        GREY: "#969696",
        SKY: "#5EB8EA",
        ORANGE: "#EEC057",
        YELLOW: "#F3E968",
    },
)

MIN_CONTRAST = 4.5  # ratio of luminances that WCAG 2 asks for between a text and its background
LIGHT_LUMINANCE = 0.18  # of a background: on a lighter one black is seen better than white
MIX_STEPS = 50  # shades tried between a colour and white
HALO_WIDTH = 2.0  # points on both sides of a line together

SHADE, DARK_SHADE = 0.35, 0.2  # opacity of the modes behind lines, on light and on dark backgrounds
LEGEND_SHADE = 0.6  # opacity of a mode in a legend, where no line crosses it


class PrintedMode(NamedTuple):
    """How print tells a mode from others without colour: its line, and the fill of its areas.

    Parameters
    ----------
    dashes
        A line style of matplotlib.
    width : float
        Points.
    grey : str
        Colour of the line.
    fill : str
    hatch : str
    """

    dashes: Any
    width: float
    grey: str
    fill: str
    hatch: str = ""


class ModeLook(NamedTuple):
    """How a mode looks: what the modes of one colour differ in stands beside it.

    Parameters
    ----------
    colour : str
    dashes : tuple of float
        Lengths of dashes and gaps of its line, in widths of the line; none where it is drawn through.
    hatch : str
        Of its areas, as matplotlib names it.
    printed : PrintedMode
    """

    colour: str
    dashes: tuple[float, ...]
    hatch: str
    printed: PrintedMode

    @property
    def linestyle(self) -> Any:
        """The dashes as a line style of matplotlib."""
        return (0, self.dashes) if self.dashes else "-"


class Round(NamedTuple):
    """What distinguishes the modes of one round through the palette from those of the others.

    Parameters
    ----------
    white, black : float
        Shares of white and black in their colours.
    dashes : tuple of float
    hatch : str
    width : float
        Of their lines in print, in widths of the first round's.
    printed_hatch : str
        In addition to that of the colour.
    """

    white: float
    black: float
    dashes: tuple[float, ...]
    hatch: str
    width: float
    printed_hatch: str


ROUNDS = (
    Round(0.0, 0.0, (), "", 1.0, ""),
    Round(0.0, 0.45, (4.0, 1.5), "////", 1.4, "oo"),
    Round(0.65, 0.0, (1.5, 1.0), "....", 1.9, "OO"),
    Round(0.0, 0.25, (6.0, 1.0, 1.0, 1.0), "xxxx", 2.5, "++"),
    Round(0.3, 0.0, (1.0, 2.5), "----", 0.6, "oo++"),
    Round(0.0, 0.6, (8.0, 2.5), "||||", 3.2, "OO++"),
    Round(0.8, 0.0, (3.0, 1.0, 1.0, 1.0, 1.0, 1.0), "++++", 4.0, "ooOO"),
)


# By the colours that modes have elsewhere: stick is orange, slip grey and purple, separation sky, chatter
# yellow.
PRINTED_MODES = MappingProxyType(
    {
        ORANGE: PrintedMode("-", 2.0, BLACK, "#C8C8C8"),
        GREY: PrintedMode("-", 0.8, "#6E6E6E", WHITE),
        PURPLE: PrintedMode((0, (4, 1.5)), 1.2, "#3C3C3C", WHITE, "////"),
        SKY: PrintedMode((0, (1, 1)), 1.2, "#3C3C3C", WHITE, "...."),
        YELLOW: PrintedMode((0, (4, 1, 1, 1)), 1.2, "#969696", "#DCDCDC", "xxxx"),
        GREEN: PrintedMode("-", 2.0, "#969696", "#DCDCDC"),
        BLUE: PrintedMode((0, (4, 1.5)), 2.0, "#6E6E6E", WHITE, "\\\\\\\\"),
        VERMILLION: PrintedMode((0, (1, 1)), 2.0, "#6E6E6E", WHITE, "||||"),
        BLACK: PrintedMode((0, (4, 1, 1, 1)), 2.0, BLACK, "#C8C8C8", "----"),
    },
)
PRINTED_DASHES = "-", "-", (0, (5, 1, 1, 1)), (0, (1, 1))  # of lines with the first four colours

# Any, as matplotlib's stubs admit only its own type of names for settings.
rcParams: Any = matplotlib.rcParams
rcParamsDefault: Any = matplotlib.rcParamsDefault

DARK, PALE = "#111111", "#E8E8E8"  # background and ink of the style "dark"
_INK_KEYS = "text.color axes.edgecolor axes.labelcolor xtick.color ytick.color patch.edgecolor hatch.color"
_PAPER_KEYS = "figure.facecolor figure.edgecolor axes.facecolor"


def _cycle(ink: str) -> Any:
    """Colours of lines that a user draws in addition to ours."""
    return cycler(color=[ink, VERMILLION, BLUE if ink == BLACK else SKY, GREEN, ORANGE, PURPLE])


_SCREEN: dict[str, Any] = {"axes.prop_cycle": _cycle(BLACK)}
# Lines that a user draws in addition to ours in print; pictures of the package know print by it.
_PRINT_CYCLE: Any = cycler(
    color=[BLACK, PRINT_COLOURS[VERMILLION], PRINT_COLOURS[BLUE], PRINT_COLOURS[GREEN]],
    linestyle=list(PRINTED_DASHES),
)
_PRINT: dict[str, Any] = {
    "axes.prop_cycle": _PRINT_CYCLE,
    "font.family": ["STIXGeneral"],  # serif, comes with matplotlib, and has the letters of mathematics
    "mathtext.fontset": "stix",
    "axes.formatter.use_mathtext": True,
    "image.cmap": "Greys",
    "hatch.linewidth": 0.4,
    "savefig.dpi": 300.0,
    "pdf.fonttype": 42,  # TrueType fonts, which journals ask for
}
STYLES: dict[str, dict[str, Any]] = {
    "screen": _SCREEN,
    # legible from the last row: few inches, large letters
    "projector": _SCREEN
    | {
        "figure.figsize": (8.0, 4.5),
        "font.size": 15.0,
        "lines.linewidth": 2.4,
        "lines.markersize": 9.0,
        "axes.linewidth": 1.4,
        "xtick.major.width": 1.4,
        "ytick.major.width": 1.4,
    },
    # one column of a journal; a figure of four panels, `plot_run`, is as wide as its page, 7.2 inches
    "paper": _PRINT
    | {
        "figure.figsize": (4.2, 2.4),
        "font.size": 8.0,
        "lines.linewidth": 1.0,
        "lines.markersize": 4.0,
        "axes.linewidth": 0.6,
        "xtick.major.width": 0.6,
        "ytick.major.width": 0.6,
    },
    # the text width of a book of 6 x 9 inches, letters nearly as large as those of its text
    "book": _PRINT
    | {
        "figure.figsize": (4.5, 2.8),
        "font.size": 9.5,
        "lines.linewidth": 1.1,
        "lines.markersize": 5.0,
        "axes.linewidth": 0.7,
        "xtick.major.width": 0.7,
        "ytick.major.width": 0.7,
    },
    "dark": {
        "axes.prop_cycle": _cycle(PALE),
        "lines.color": PALE,
        "grid.color": "#666666",
        **dict.fromkeys(_INK_KEYS.split(), PALE),
        **dict.fromkeys(_PAPER_KEYS.split(), DARK),
    },
}
_KEYS = sorted({key for settings in STYLES.values() for key in settings})
_CYCLES = [rcParamsDefault["axes.prop_cycle"], *(settings["axes.prop_cycle"] for settings in STYLES.values())]


def style(name: str) -> ExitStack:
    """Draw pictures in a style, from now on or within a ``with`` block.

    A style is a set of matplotlib's settings, so your own drawings have it too, and what you set
    afterwards in ``matplotlib.rcParams`` prevails.

    Parameters
    ----------
    name : "screen", "projector", "paper", "book" or "dark"
        "screen": black on white, as without a style.  "projector": large letters and heavy lines.  "dark":
        light on almost black.  "paper" and "book" are for print: as wide as the column of a journal or of a
        book, in serif letters, without titles, as the caption has their words; dashes, lightness and hatching
        tell in a grey copy what colours tell on a screen.

    Returns
    -------
    contextlib.ExitStack
        For ``with``, at whose end the settings are again what they were before.

    Raises
    ------
    ValueError
        For another name.

    Examples
    --------
    >>> import frictionlab as fl
    >>> eigenvalues = fl.eigenvalues(fl.SliderOnBelt(mu_k=1.4))
    >>> with fl.style("projector"):
    ...     ax = eigenvalues.plot()
    >>> ax.figure.get_size_inches().tolist()
    [8.0, 4.5]
    """
    check_choice("name", name, tuple(STYLES))
    applied = ExitStack()
    applied.callback(rcParams.update, {key: rcParams[key] for key in _KEYS})
    rcParams.update({key: STYLES[name].get(key, rcParamsDefault[key]) for key in _KEYS})
    return applied


def background(ax: Axes | None = None) -> str:
    """The background of lines in `ax`, in hexadecimal; without axes, that of new ones."""
    if ax is None:
        layers = rcParams["axes.facecolor"], rcParams["figure.facecolor"]
    else:
        figure: Any = ax.get_figure(root=True)
        patches = ax.patch, figure.patch
        layers = tuple(patch.get_facecolor() for patch in patches if patch.get_visible())  # a twin's is not
    return next((to_hex(layer) for layer in layers if to_rgba(layer)[3] > 0.5), WHITE)


def luminance(colour: Any) -> float:
    """Relative luminance of WCAG 2, 0 for black and 1 for white."""
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in to_rgb(colour)]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(one: Any, other: Any) -> float:
    """Contrast of two colours by WCAG 2, from 1 for equal ones to 21 for black and white."""
    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


def is_dark(ax: Axes | None = None) -> bool:
    """Whether white is seen better than black on the background."""
    return luminance(background(ax)) < LIGHT_LUMINANCE


def legible(colour: Any, ax: Axes | None = None) -> Any:
    """The colour; where a dark background hides it, the nearest lighter shade of it that can be seen.

    Greys are inverted instead: black becomes white.  In print it is that of the lightness of its own.
    """
    if in_print():
        return PRINT_COLOURS.get(colour, colour)
    behind = background(ax)
    if not is_dark(ax) or contrast(colour, behind) >= MIN_CONTRAST:
        return colour
    channels: Any = to_rgb(colour)
    if len({*channels}) == 1:
        grey = 1.0 - channels[0]
        return to_hex((grey, grey, grey))
    shares = (i / MIX_STEPS for i in range(1, MIX_STEPS + 1))
    mixes = (_mixed_with_white(channels, share) for share in shares)
    return next(mix for mix in mixes if contrast(mix, behind) >= MIN_CONTRAST)


def in_print() -> bool:
    """Whether pictures are for print: without titles, and without colours alone to tell things apart."""
    return rcParams["axes.prop_cycle"] == _PRINT_CYCLE


def _mixed_with_white(channels: Any, share: float) -> str:
    mix: Any = [c + (1.0 - c) * share for c in channels]
    return to_hex(mix)


def ink(ax: Axes | None = None) -> str:
    """Black, or white on a dark background."""
    return legible(BLACK, ax)


def ink_on(fill: Any) -> str:
    """Black or white, whichever is seen better on a filled area."""
    return WHITE if luminance(fill) < LIGHT_LUMINANCE else BLACK


def add_halo(line: Any, ax: Axes | None = None) -> None:
    """Give a line that crosses coloured areas edges in the colour of a dark background.

    On a light background it gets none: black is seen on all colours of the package.
    """
    if is_dark(ax):
        edges = max(np.atleast_1d(line.get_linewidth())) + HALO_WIDTH
        line.set_path_effects([Stroke(linewidth=edges, foreground=background(ax)), Normal()])


def add_halo_to_errors(errors: Any, ax: Axes | None = None) -> None:
    """Do the same for the caps and spans of error bars, which cross bars."""
    _, caps, spans = errors.lines
    for line in (*caps, *spans):
        add_halo(line, ax)


def cycled_style(index: int) -> dict[str, Any] | None:
    """Line properties at an index of the user's own ``axes.prop_cycle``; None where it was not changed."""
    cycle = rcParams["axes.prop_cycle"]
    if any(cycle == ours for ours in _CYCLES):
        return None
    properties = list(cycle)
    return properties[index % len(properties)] if properties else None


def line_width(width: float = LINE_WIDTH) -> float:
    """A width in points: as given, or scaled so that lines of LINE_WIDTH have the user's width."""
    own = rcParams["lines.linewidth"]
    return width if own == rcParamsDefault["lines.linewidth"] else width * own / LINE_WIDTH


def font_size(size: float) -> float:
    """The size of a text in points, in proportion to the user's."""
    return size * rcParams["font.size"] / rcParamsDefault["font.size"]


def marker_size(size: float) -> float:
    """The size of a marker in points, in proportion to the user's."""
    return size * rcParams["lines.markersize"] / rcParamsDefault["lines.markersize"]


def pen(colour: str = BLACK, width: float = LINE_WIDTH, ax: Axes | None = None) -> dict[str, Any]:
    """Colour and width of a line in `ax`, as keywords of matplotlib."""
    return {"color": legible(colour, ax), "linewidth": line_width(width)}


def mode_looks(run: Trajectory) -> dict[str, ModeLook]:
    """How every mode looks that a run knows, in the automaton's order.

    Modes that differ only in the pieces of laws look alike, unless all modes do.
    """
    return looks_by_whole(sorted(zip(run.mode_places, run.mode_names, strict=True)), whole_names(run))


def looks_by_whole(
    places_and_names: Sequence[tuple[int, str]], wholes: Mapping[str, str]
) -> dict[str, ModeLook]:
    """How every mode looks, the same for those of one whole mode, unless there is only one."""
    parts = dict.fromkeys(wholes[name] for _, name in places_and_names)
    if len(parts) in (1, len(places_and_names)):
        return looks_of_modes(places_and_names)
    looks = looks_of_modes(enumerate(parts))
    return {name: looks[wholes[name]] for _, name in places_and_names}


def whole_names(run: Trajectory) -> dict[str, str]:
    """For every mode that a run knows the name of that on all sides of borders of laws in pieces."""
    automaton = run.automaton
    if automaton.derivations is not None or automaton.whole is automaton:  # there are no such laws
        return {name: name for name in run.mode_names}
    wholes = {name: automaton.mode(name).whole for name in run.mode_names}
    return {name: name if whole is None else whole.name for name, whole in wholes.items()}


def looks_of_modes(places_and_names: Iterable[tuple[int, str]]) -> dict[str, ModeLook]:
    """How every mode looks: in its colour of MODE_COLOURS, or for other names in one of a palette.

    The places of modes in the automaton choose from what is left of the palette, so that a mode looks the
    same in all runs.  After the last colour come the same ones in the next of ROUNDS: other shades, with
    dashes and hatching.
    """
    places_and_names = list(places_and_names)
    taken = {MODE_COLOURS[name] for _, name in places_and_names if name in MODE_COLOURS}
    palette = (GREY, SKY, ORANGE, PURPLE, YELLOW, GREEN, BLUE, VERMILLION, BLACK)
    spare = [colour for colour in palette if colour not in taken]
    return {
        name: _look(MODE_COLOURS[name], ROUNDS[0])
        if name in MODE_COLOURS
        else _look(spare[place % len(spare)], ROUNDS[place // len(spare) % len(ROUNDS)])
        for place, name in places_and_names
    }


def _look(colour: str, one: Round) -> ModeLook:
    printed = PRINTED_MODES[colour]
    printed = printed._replace(width=one.width * printed.width, hatch=printed.hatch + one.printed_hatch)
    # black has no darker shade
    black, white = (0.0, one.white + one.black) if colour == BLACK else (one.black, one.white)
    channels: Any = [c * (1.0 - black) for c in to_rgb(colour)]
    return ModeLook(_mixed_with_white(channels, white).upper(), one.dashes, one.hatch, printed)


def mode_lines(run: Trajectory, ax: Axes) -> dict[str, dict[str, Any]]:
    """Keywords of a line for every mode that a run knows, in the automaton's order."""
    if not in_print():
        return {
            name: pen(look.colour, ax=ax) | {"linestyle": look.linestyle}
            for name, look in mode_looks(run).items()
        }
    return {
        name: {"color": mode.grey, "linestyle": mode.dashes, "linewidth": line_width(mode.width)}
        for name, (*_, mode) in mode_looks(run).items()
    }


def mode_fills(run: Trajectory, ax: Axes | None = None, shade: float | None = None) -> dict[str, Any]:
    """Keywords of an area for every mode that a run knows, as opaque as `shade`, else as behind lines."""
    looks = mode_looks(run).items()
    if in_print():
        return {
            name: {"facecolor": mode.fill, "hatch": mode.hatch, "edgecolor": "#5A5A5A", "linewidth": 0.0}
            for name, (*_, mode) in looks
        }
    alpha = shade or (DARK_SHADE if is_dark(ax) else SHADE)
    look: dict[str, Any] = {"linewidth": 0, "alpha": alpha}
    return {
        name: {"facecolor": legible(one.colour, ax), "hatch": one.hatch, "edgecolor": ink(ax)} | look
        for name, one in looks
    }


def line_style(index: int, ax: Axes | None = None, *, dashed: bool = False) -> dict[str, Any]:
    """Colour, width and dashes of a curve in `ax`; `dashed` if its unit is another one, as of an angle beside
    lengths.

    What the user has set in ``axes.prop_cycle`` takes the place of the package's colours.
    """
    own = cycled_style(index)
    if own is not None:
        usual = {"color": legible(BLACK, ax), "linestyle": "-", "linewidth": line_width()}
        return usual | own | ({"linestyle": DASHED} if dashed else {})
    place = index % len(LINE_COLOURS)
    dashes = PRINTED_DASHES[place] if in_print() else "-"
    dashes = DASHED if dashed or index >= len(LINE_COLOURS) else dashes
    colour = legible(LINE_COLOURS[place], ax)
    return {"color": colour, "linestyle": dashes, "linewidth": line_width()}


def crowding() -> float:
    """How much larger letters are, relative to a new figure, than without a style; at least 1.

    What has a fixed number of letters, as a title or the ticks of an axis, has to shrink by this factor.
    """
    return max(1.0, font_size(1.0) * PANEL_SIZE[0] / figure_size()[0])


def figure_size(width: float = PANEL_SIZE[0], height: float = PANEL_SIZE[1]) -> tuple[float, float]:
    """Size of a figure in inches: as given, scaled in a style of the package, or the user's own."""
    size = tuple(rcParams["figure.figsize"])
    if size == tuple(rcParamsDefault["figure.figsize"]):
        return width, height
    if size in [settings.get("figure.figsize") for settings in STYLES.values()]:
        return width * size[0] / PANEL_SIZE[0], height * size[1] / PANEL_SIZE[1]
    return size
