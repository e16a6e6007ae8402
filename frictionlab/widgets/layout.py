"""The layout of an explorer: messages, buttons and code beside the picture, below it on a narrow screen; full
screen, and what the browser tells of the place."""

from __future__ import annotations

from collections.abc import Iterable
from importlib import resources
from typing import Any

import anywidget
import ipywidgets
import traitlets

from .messages import equilibrium_text, run_end_text
from .result import python_snippet, to_json
from .update_scheduler import has_event_loop


class Screen(anywidget.AnyWidget):
    """The button "full screen", and what the browser tells of the place where the explorer is.

    Attributes
    ----------
    pixels : int
        Of a panel's width; 0 before it is shown.
    dark : bool
        Whether the page around is dark.
    """

    _esm = resources.files("frictionlab.widgets").joinpath("screen.js").read_text(encoding="utf-8")
    _css = resources.files("frictionlab.widgets").joinpath("layout.css").read_text(encoding="utf-8")
    pixels = traitlets.Int(0).tag(sync=True)
    dark = traitlets.Bool(False).tag(sync=True)

    @property
    def is_watched(self) -> bool:
        """Whether a browser shows it, or, as in a script, nothing could go on later."""
        return self.pixels > 0 or not has_event_loop()


class Layout:
    """The widgets that are not controls of the model.

    Attributes
    ----------
    message, equilibrium, comparison : HTML
        The error, if any; the sliding equilibrium and its stability; what is dotted.
    python, json : Textarea
        The state to copy.
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

    def describe(self, result: Any) -> None:
        """Show the texts that describe a result."""
        self.equilibrium.value = equilibrium_text(result)
        self.python.value, self.json.value = python_snippet(result.settings), to_json(result.settings)
        self.show_message(run_end_text(result))

    def show_message(self, text: str) -> None:
        """Show a message, or none where it is empty."""
        _show(self.message, text)

    def show_comparison(self, text: str) -> None:
        """Show what is dotted; nothing is where the text is empty."""
        _show(self.comparison, text)
        self.swap.disabled = not text

    def mark(self, before: bool, after: bool) -> None:
        """Enable undo and redo where there is a state before and after."""
        self.undo.disabled, self.redo.disabled = not before, not after

    def arrange(self, busy: Any, controls: Iterable[Any], panels: Iterable[Any], files: Any) -> Any:
        """Controls and picture side by side where there is room."""
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
