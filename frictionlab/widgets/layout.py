"""The layout of an explorer: messages, buttons and code beside the picture, below it on a narrow screen."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import ipywidgets

from .messages import equilibrium_text, run_end_text
from .settings import python_snippet, to_json

# Controls beside the picture, which stays visible and scrolls by itself where it is higher than the window;
# on a narrow screen below it, its panels side by side, of the second one an edge as a hint.  A sticky box
# keeps to the nearest ancestor that could scroll; notebooks let every output do so, but not this one.
STYLE_SHEET = """<style>
.jupyter-widgets:is(.fl-explorer, .fl-scenes) { overflow: visible; }
:is(.jp-OutputArea, .jp-OutputArea-child, .jp-OutputArea-output):has(.fl-explorer) {
  overflow: visible; min-width: 0; }
.fl-explorer .fl-picture { position: sticky; top: 0; z-index: 2; background: white; max-height: 90vh; }
.fl-explorer .fl-range .widget-readout { min-width: 95px; }
.fl-explorer :is(.fl-equilibrium, .fl-error) .widget-html-content { line-height: 1.35; }
.fl-explorer .fl-equilibrium span { display: inline-block; margin-right: 1em; }
@media (max-width: 800px) {
  .fl-explorer { flex-direction: column !important; }
  .fl-explorer .fl-picture { order: -1; flex: none !important; width: 100%;
                             flex-flow: row nowrap !important; overflow-x: auto; }
  .fl-explorer .fl-panel { flex: 0 0 auto; max-width: 88% !important; }
  .fl-explorer .fl-controls { width: 100%; flex: none !important; }
  .fl-explorer .fl-control { width: 98% !important; }
}
</style>"""
CONTROLS_WIDTH = "335px"


class Layout:
    """The widgets that are not controls of the model.

    Attributes
    ----------
    message, equilibrium : HTML
        The error, if any; the sliding equilibrium and its stability.
    python, json : Textarea
        The state to copy.
    compare : ToggleButton
    reset, undo, redo : Button
    """

    def __init__(self) -> None:
        self.message, self.equilibrium = _message_widget("error"), _message_widget("equilibrium")
        self.message.style.text_color = "#B00020"
        self.python, self.json = _code_area("python"), _code_area("json")
        text = "keep the curves as they are now, dotted"
        self.compare = ipywidgets.ToggleButton(description="compare", tooltip=text)
        text = "all controls back to the values of the start"
        self.reset = ipywidgets.Button(description="reset", tooltip=text)
        self.undo = ipywidgets.Button(description="undo", tooltip="back to what was set before")
        self.redo = ipywidgets.Button(description="redo", tooltip="forth to what was undone")
        self.mark(False, False)
        for button in (self.compare, self.reset, self.undo, self.redo):
            button.layout.width = "75px"
            button.add_class(f"fl-{button.description}")

    def describe(self, result: Any) -> None:
        """Show the texts that describe a result."""
        self.equilibrium.value = equilibrium_text(result)
        self.python.value, self.json.value = python_snippet(result.settings), to_json(result.settings)
        self.show_message(run_end_text(result))

    def show_message(self, text: str) -> None:
        """Show a message, or none where it is empty."""
        self.message.value = text
        self.message.layout.display = "" if text else "none"

    def mark(self, before: bool, after: bool) -> None:
        """Enable undo and redo where there is a state before and after."""
        self.undo.disabled, self.redo.disabled = not before, not after

    def arrange(self, busy: Any, controls: Iterable[Any], picture: Any, kept: Any) -> Any:
        """Controls and picture side by side where there is room."""
        titles = "as Python", "as JSON", "figure, data, state"
        code = ipywidgets.Accordion([self.python, self.json, kept], titles=titles)
        code.add_class("fl-code")
        buttons = ipywidgets.HBox([self.compare, self.reset, self.undo, self.redo])
        column = [
            buttons,
            busy,
            self.message,
            self.equilibrium,
            *controls,
            code,
            ipywidgets.HTML(STYLE_SHEET),
        ]
        layout = ipywidgets.Layout(flex=f"0 0 {CONTROLS_WIDTH}", max_width="100%")
        left = ipywidgets.VBox(column, layout=layout).add_class("fl-controls")
        wrap = ipywidgets.Layout(flex_flow="row nowrap", align_items="flex-start", width="100%")
        return ipywidgets.Box([left, picture], layout=wrap).add_class("fl-explorer")


def _message_widget(name: str) -> Any:
    return ipywidgets.HTML().add_class(f"fl-{name}")


def _code_area(name: str) -> Any:
    area = ipywidgets.Textarea(layout=ipywidgets.Layout(width="100%", height="120px"))
    return area.add_class(f"fl-{name}")
