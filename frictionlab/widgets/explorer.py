"""`fl.explore`: a model with sliders, and what it does."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import ipywidgets

from frictionlab.models import Model, SliderOnBelt

from .busy import Busy
from .components import ComponentControls
from .latest import Latest
from .panels import panels_of
from .parameters import ParameterControls
from .picture import Picture
from .result import Result
from .running import RunControls
from .settings import Settings, snippet, to_json
from .words import end_text, equilibrium_text, error_text

DEFAULT = ("response", "phase", "forces", "spectrum", "eigenvalues")
CONTROLS_WIDTH = "340px"


class Explorer:
    """Controls made from a model's parameters, and a picture that follows them; a notebook shows it.

    Attributes
    ----------
    result : Result
        Of the last values that worked: ``result.run``, ``result.eigenvalues``, ``result.settings``.
    error : Exception or None
        What is wrong with the values of now.
    picture : Picture
    parameters, components, running : ParameterControls, ComponentControls, RunControls
        The controls; set the ``value`` of one and the picture follows.
    widget : Box
        All of it, to be put into an application.
    """

    def __init__(self, settings: Settings, panels: dict[str, Any]) -> None:
        self.settings, self.result, self.error = settings, Result(settings, progress=True), None
        self.updates = 0  # computed so far
        self.components = ComponentControls(settings.model)
        self.parameters = ParameterControls(settings.model, self._changed)
        self.running = RunControls(settings)
        self.picture, self.busy = Picture(panels), Busy()
        self.latest = Latest(self._update)
        self._make_texts()
        self.extra = {n: c for panel in panels.values() for n, c in getattr(panel, "controls", {}).items()}
        for control in (
            *self.components.controls.values(),
            *self.running.controls.values(),
            *self.extra.values(),
        ):
            control.observe(self._changed, names="value")
        self.widget = self._arranged()
        self.latest.request()

    @property
    def model(self) -> Any:
        """The model of the last values that worked."""
        return self.result.model

    @property
    def run(self) -> Any:
        """Its run; simulated now where no panel has asked for it."""
        return self.result.run

    @property
    def controls(self) -> dict[str, Any]:
        """Every control by its name, which is its CSS class too, after ``fl-``."""
        parts = self.components.controls, self.running.controls, self.extra
        buttons = {"compare": self.compare, "reset": self.reset_button}
        return {**self.parameters.sliders, **{n: c for part in parts for n, c in part.items()}, **buttons}

    def reset(self, _: Any = None) -> None:
        """All controls back to the values of the start."""
        with self.latest.held():
            self.parameters.reset()
            self.components.reset()
            self.running.reset()
            self.compare.value = False

    def close(self) -> None:
        """Take the widgets away and free what they hold."""
        for control in (*self.controls.values(), *self.picture.images.values(), self.widget):
            control.close()

    def _repr_mimebundle_(self, **options: Any) -> Any:
        return self.widget._repr_mimebundle_(**options)

    def _changed(self, _: Any) -> None:
        self.latest.request()

    def _update(self) -> None:
        with self.busy.mark():
            try:
                settings = self._read()
                result = self.result if settings == self.settings else Result(settings)
                self.picture.draw(result)
                self._describe(result)
            except Exception as error:  # whatever a law of one's own may raise is told, not lost in a log
                self.error = error
                self._tell(error_text(error))
                return
            self.settings, self.result, self.error = settings, result, None
            self.updates += 1
            self._tell(end_text(result))

    def _read(self) -> Settings:
        model = self.components.model()
        model = model.replace(**self.parameters.values(model))
        return self.running.settings(model)

    def _describe(self, result: Result) -> None:
        self.running.widget.layout.display = "" if result.ran else "none"
        self.equilibrium.value = equilibrium_text(result)
        self.python.value, self.json.value = snippet(result.settings), to_json(result.settings)

    def _tell(self, text: str) -> None:
        self.message.value = text
        self.message.layout.display = "" if text else "none"

    def _make_texts(self) -> None:
        self.message = _text("error", color="#B00020")
        self.equilibrium = _text("equilibrium")
        self.python, self.json = _code("python"), _code("json")
        self.compare = ipywidgets.ToggleButton(
            description="compare", tooltip="keep the curves as they are now in grey"
        ).add_class("fl-compare")
        self.reset_button = ipywidgets.Button(
            description="reset", tooltip="all controls back to the values of the start"
        ).add_class("fl-reset")
        for button in (self.compare, self.reset_button):
            button.layout.width = "90px"
        self.reset_button.on_click(self.reset)
        self.compare.observe(self._compare, names="value")

    def _compare(self, change: Any) -> None:
        if change["new"]:
            self.picture.keep()
        else:
            self.picture.forget()
        self.latest.request()

    def _arranged(self) -> Any:
        """Controls and picture side by side where there is room, else one below the other."""
        wrap = ipywidgets.Layout(flex_flow="row wrap", align_items="flex-start", width="100%")
        code = ipywidgets.Accordion([self.python, self.json], titles=("as Python", "as JSON"))
        buttons = ipywidgets.HBox([self.compare, self.reset_button, self.busy.widget])
        column = [
            buttons,
            self.message,
            *self.extra.values(),
            *self.components.controls.values(),
            self.parameters.widget,
            self.running.widget,
            self.equilibrium,
            code.add_class("fl-code"),
        ]
        layout = ipywidgets.Layout(flex=f"0 1 {CONTROLS_WIDTH}", min_width="0", max_width="100%")
        controls = ipywidgets.VBox(column, layout=layout).add_class("fl-controls")
        return ipywidgets.Box([controls, self.picture.widget], layout=wrap).add_class("fl-explorer")


def explore(model: Any = None, panels: Iterable[Any] = DEFAULT) -> Explorer:
    """Change a model with sliders and watch what it does.

    Every parameter has a slider, made from its symbol, unit, meaning and range: those of your own laws too.
    The nonlinearities can be switched off and on, and the curves of now kept in grey beside those to come.
    The model and its run are ``explorer.model`` and ``explorer.run``, and there as Python and JSON to copy.

    Parameters
    ----------
    model : SliderOnBelt or None
        Where to start; None takes the paper's.
    panels : iterable of str or callable
        "response", "phase", "forces", "spectrum", "eigenvalues", or functions that take a
        :class:`~frictionlab.widgets.result.Result` and return a :class:`~frictionlab.widgets.Drawing`.  What no
        panel asks for is not computed.

    Returns
    -------
    Explorer

    Raises
    ------
    TypeError
        If it is no model.
    ValueError
        For an unknown panel.

    Examples
    --------
    >>> import frictionlab as fl
    >>> explorer = fl.explore(panels=["eigenvalues"])
    >>> explorer.controls["mu_k"].value = 1.6
    >>> explorer.model, explorer.result.eigenvalues.stable
    (SliderOnBelt(mu_k=1.6), False)
    """
    return Explorer(Settings(start_of(model)), panels_of(panels))


def start_of(model: Any) -> Any:
    """The model to start from.

    Raises
    ------
    TypeError
        If it is none.
    """
    model = SliderOnBelt() if model is None else model
    if not isinstance(model, Model):
        raise TypeError(f"model must be a model such as SliderOnBelt, got {model!r}")
    return model


def _text(name: str, **style: Any) -> Any:
    text = ipywidgets.HTML().add_class(f"fl-{name}")
    if style:
        text.style.text_color = style["color"]
    return text


def _code(name: str) -> Any:
    area = ipywidgets.Textarea(layout=ipywidgets.Layout(width="100%", height="120px"))
    return area.add_class(f"fl-{name}")
