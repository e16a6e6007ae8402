"""What an explorer shows beside its picture, or below it on a narrow screen: messages, buttons and code; the
full screen, and what the browser tells about the page.

The messages describe a result: the equilibrium and its stability, what the run does, why it ended.
"""

from __future__ import annotations

from collections.abc import Iterable
from html import escape
from importlib import resources
from typing import TYPE_CHECKING, Any

import anywidget
import ipywidgets
import numpy as np
import traitlets

from frictionlab.presentation import state_unit

from .result import python_snippet, time_of_rest, to_json
from .update_scheduler import has_event_loop

if TYPE_CHECKING:
    from frictionlab.models.model import Model
    from frictionlab.stability.eigenproblems.eigenvalues import Eigenvalues
    from frictionlab.widgets.result import Result

NOTHING_SLIDES = (
    "Steady sliding and its stability are not of this model: nothing in it slides on something that moves."
)
STARTS = {"rest": "from rest", "near": "from near the equilibrium"}
VERBS = {"stick": "sticks", "slip+": "slips", "slip-": "slips", "slip": "slips", "separation": "separates"}


class Screen(anywidget.AnyWidget):
    """The button "full screen", and what the browser tells about the page around the explorer.

    Attributes
    ----------
    pixels : int
        Width of a panel in pixels; 0 before it is shown.
    dark : bool
        Whether the page is dark.
    """

    _esm = resources.files("frictionlab.widgets").joinpath("screen.js").read_text(encoding="utf-8")
    _css = resources.files("frictionlab.widgets").joinpath("layout.css").read_text(encoding="utf-8")
    pixels = traitlets.Int(0).tag(sync=True)
    dark = traitlets.Bool(False).tag(sync=True)

    @property
    def is_watched(self) -> bool:
        """Whether a browser shows it; also true without an event loop, where nothing could go on later."""
        return self.pixels > 0 or not has_event_loop()


class Layout:
    """The widgets that are not controls of the model.

    Attributes
    ----------
    message, equilibrium, comparison : HTML
        The error, if any; the sliding equilibrium and its stability; which scene is dotted.
    python, json : Textarea
        Model and run, as code to copy.
    compare : ToggleButton
    swap, reset, undo, redo : Button
    screen : Screen
    pictures : Box
        The panels.
    """

    def __init__(self) -> None:
        self.message, self.equilibrium = _message_widget("error"), _message_widget("equilibrium")
        self.comparison = _message_widget("comparison")
        self.python, self.json = _code_area("python"), _code_area("json")
        text = "keep this scene, dotted, and change another one"
        self.compare = ipywidgets.ToggleButton(description="compare", tooltip=text)
        self.swap = _button("swap", "change the scene that is kept, and keep this one")
        self.reset = _button("reset", "all controls back to the values of the start")
        self.undo = _button("undo", "back to what was set before")
        self.redo = _button("redo", "forth to what was undone")
        self.screen, self.pictures = Screen(), ipywidgets.Box().add_class("fl-picture")
        self.buttons = self.compare, self.swap, self.reset, self.undo, self.redo
        for button in self.buttons:
            button.layout.width = "auto"
            button.add_class(f"fl-{button.description}")
        self.mark(False, False)
        self.show_comparison("")

    def describe(self, result: Result) -> None:
        """Show the texts that describe a result."""
        self.equilibrium.value = equilibrium_text(result)
        self.python.value, self.json.value = python_snippet(result.settings), to_json(result.settings)
        self.show_message(run_end_text(result))

    def show_message(self, text: str) -> None:
        """Show a message, or none where it is empty."""
        _show(self.message, text)

    def show_comparison(self, text: str) -> None:
        """Show which scene is dotted; an empty text says that none is."""
        _show(self.comparison, text)
        self.swap.disabled = not text

    def mark(self, before: bool, after: bool) -> None:
        """Enable undo where there is a state before, redo where there is one after."""
        self.undo.disabled, self.redo.disabled = not before, not after

    def arrange(self, busy: Any, controls: Iterable[Any], panels: Iterable[Any], files: Any) -> Any:
        """The whole explorer: controls and picture side by side where there is room."""
        titles = "as Python", "as JSON", "figure, data, state"
        code = ipywidgets.Accordion([self.python, self.json, files], titles=titles)
        code.add_class("fl-code")
        row = ipywidgets.Layout(flex_flow="row wrap")
        buttons = ipywidgets.Box([*self.buttons, self.screen, busy], layout=row)
        texts = self.message, self.comparison, self.equilibrium
        left = ipywidgets.VBox([buttons, *texts, *controls, code]).add_class("fl-controls")
        self.pictures.children = tuple(panels)
        wrap = ipywidgets.Layout(flex_flow="row nowrap", align_items="flex-start", width="100%")
        return ipywidgets.Box([left, self.pictures], layout=wrap).add_class("fl-explorer")


def close_all(widget: Any) -> None:
    """Close a widget and all within it."""
    for part in getattr(widget, "children", ()):
        close_all(part)
    widget.close()


def _show(message: Any, text: str) -> None:
    message.value = text
    message.layout.display = "" if text else "none"


def _button(name: str, text: str) -> Any:
    return ipywidgets.Button(description=name, tooltip=text)


def _message_widget(name: str) -> Any:
    return ipywidgets.HTML().add_class(f"fl-{name}")


def _code_area(name: str) -> Any:
    area = ipywidgets.Textarea(layout=ipywidgets.Layout(width="100%", height="9em"))
    return area.add_class(f"fl-{name}")


def equilibrium_text(result: Result) -> str:
    """The verdict on steady sliding and the run, then the coordinates and forces of the equilibrium."""
    eigenvalues = result.eigenvalues
    if eigenvalues is None:
        return no_sliding_text(result)
    point = eigenvalues.equilibrium
    rows = [(name, x, state_unit(name)) for name, x in zip(result.model.coordinates, point.q)]
    rows += [
        ("penetration", point.penetration, "m"),
        ("F_N", point.normal_force, "N"),
        ("F_T", point.friction_force, "N"),
    ]
    rows = [row for row in rows if not np.isnan(row[1])]
    numbers = " ".join(f"<span>{escape(n)} = {x:.5g} {u}</span>" for n, x, u in rows)
    return f"{verdict_text(result)}<br>{numbers}"


def verdict_text(result: Result) -> str:
    """Whether steady sliding is stable, and what the run does, in a sentence."""
    eigenvalues = result.eigenvalues
    if eigenvalues is None:
        return no_sliding_text(result)
    happens = run_text(result)
    joint = "but" if eigenvalues.stable else "and"
    run = f", {joint} {happens}" if happens else ""
    return f"<b>Steady sliding is {stability_text(eigenvalues)}{escape(run, quote=False)}.</b>"


def no_sliding_text(result: Result) -> str:
    """Why there is no steady sliding, and what the run does; with the cure, where something can slide."""
    happens = run_text(result)
    run = f" {happens[0].upper()}{happens[1:]}." if happens else ""
    if not can_slide_steadily(result.model):
        text = f"<b>{escape(NOTHING_SLIDES + run, quote=False)}</b>"
    else:
        reason = escape(result.no_equilibrium_reason + run, quote=False)
        text = f"<b>No steady sliding</b>: {reason}"
    return text


def can_slide_steadily(model: Model) -> bool:
    """Whether something in a model slides while all coordinates are at rest: on a belt, say."""
    mode = next(iter(model.automaton().modes))
    velocities = [e for name, e in mode.outputs.items() if name.startswith("relative_velocity")]
    return any(e.subs({s: 0 for s in e.free_symbols if s.name.endswith("'")}) != 0 for e in velocities)


def run_text(result: Result) -> str:
    """A clause: what the run does at its end; empty where it settles to the equilibrium."""
    if not result.has_run or not result.run.status.ok:
        return ""
    start = STARTS.get(str(result.settings.x0), "from your own state")
    if not result.is_moving:
        stops = "slip" not in result.run.mode[-1]  # in slip it is the equilibrium that it came to
        return f"{start} this run is over after {time_of_rest(result.run):.3g} s" if stops else ""
    what = _motion(result)
    if not what and result.decays:
        return ""
    spectrum = result.spectrum if result.has_spectrum else None  # computed where a panel shows it
    strongest = 0.0 if spectrum is None else spectrum.strongest
    pitch = f" at {strongest:.3g} Hz" if strongest > 0 else ""
    return f"{start} this run {what or 'vibrates'}{pitch}"


def _motion(result: Result) -> str:
    """What the run does in the part shown, as its modes tell; empty where they tell nothing."""
    modes, times = set(result.modes), result.times()
    regimes = {regime for mode in modes for regime in mode.split(" | ")}
    struck = bool(np.any(result.run.events.t > times[0]))
    if regimes == {"flight"}:
        return "hits its stop" if struck else ""
    verbs = list(dict.fromkeys(verb for regime, verb in VERBS.items() if regime in regimes))
    if len(verbs) > 1:
        return f"{', '.join(verbs[:-1])} and {verbs[-1]}"
    return "slips to and fro" if {"slip+", "slip-"} <= regimes else ""


def stability_text(eigenvalues: Eigenvalues) -> str:
    """Stable, or which mode grows, how fast and at what frequency."""
    upper = eigenvalues.values[eigenvalues.values.imag >= 0]
    growing = upper[upper.real > 0]
    if not len(growing):
        slowest = upper.real.max()
        return "stable" if slowest < 0 else "neither stable nor unstable: a mode neither grows nor decays"
    worst = growing[np.argmax(growing.real)]
    modes = "1 mode grows" if len(growing) == 1 else f"{len(growing)} modes grow"
    return f"unstable: {modes}, at {worst.real:.4g} 1/s and {worst.imag / (2 * np.pi):.4g} Hz"


def error_text(error: Exception) -> str:
    """The message of an error; its class comes first, except for ValueError and TypeError."""
    kind = "" if isinstance(error, (ValueError, TypeError)) else f"{type(error).__name__}: "
    return (
        f"<b>{escape(kind + (str(error) or type(error).__name__), quote=False)}</b><br>"
        "The picture is that of the last values that worked."
    )


def run_end_text(result: Result) -> str:
    """A warning if the run did not reach its end, or its steps are less exact than they should be."""
    if not result.has_run:
        return ""
    if result.run.status.ok:
        warning = result.run.warning
        return "" if warning is None else escape(f"Do not trust this picture: {warning}.")
    return escape(f"The run ended at {result.run.raw.t:.4g} s: {result.run.status}.")
