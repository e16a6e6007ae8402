"""`fl.explore`: a model with sliders, and what it does."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from typing import Any

from frictionlab.models import SliderOnBelt
from frictionlab.models.given import given_model

from .busy import Busy
from .components import ComponentControls
from .face import Face
from .latest import Latest
from .panels import panels_of
from .parameters import ParameterControls
from .picture import Picture
from .result import Result
from .running import RunControls
from .settings import Settings, settings_of
from .sliders import refine, same
from .words import error_text

DEFAULT = ("response", "phase", "forces", "spectrum", "eigenvalues")


class Explorer:
    """Controls made from a model's parameters, and a picture that follows them; a notebook shows it.

    Attributes
    ----------
    result : Result
        Of the last values that worked: ``result.run``, ``result.eigenvalues``, ``result.settings``.
    error : Exception or None
        What is wrong with the values of now.
    controls : mapping of str to widget
        Set the ``value`` of one and the picture follows.  Each has its name as a CSS class, ``fl-<name>``.
    picture : Picture
    face : Face
        What it says in words.
    widget : Box
        All of it, to be put into an application.
    """

    def __init__(self, settings: Settings, panels: dict[str, Any]) -> None:
        self.settings, self.result, self.error = settings, Result(settings), None
        self.updates = 0  # computed so far
        self.latest = Latest(self._update)
        self.components, self.running = ComponentControls(settings.model), RunControls(settings)
        self.parameters = ParameterControls(settings.model, self._changed)
        self.extra = {n: c for panel in panels.values() for n, c in getattr(panel, "controls", {}).items()}
        self._first = {name: control.value for name, control in self._others.items()}
        self.picture, self.busy, self.face = Picture(panels), Busy(), Face()
        for control in self._others.values():
            control.observe(self._changed, names="value")
        self.face.compare.observe(self._compare, names="value")
        self.face.reset.on_click(self.reset)
        for name, panel in panels.items():
            if hasattr(panel, "pick"):
                self.picture.images[name].on_click(partial(self._clicked, name))
        shown = *self.extra.values(), *self.components.controls.values()
        shown = *shown, self.parameters.widget, self.running.widget
        self.widget = self.face.arranged(self.busy.widget, shown, self.picture.widget)
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
        """Every control by its name."""
        buttons = {"compare": self.face.compare, "reset": self.face.reset}
        return {**self.parameters.sliders, **self._others, **buttons}

    @property
    def _others(self) -> dict[str, Any]:
        """Controls that are there from the start to the end."""
        return {**self.components.controls, **self.running.controls, **self.extra}

    def reset(self, _: Any = None) -> None:
        """All controls back to the values of the start."""
        with self.latest.held():
            self.parameters.reset()
            for name, control in self._others.items():
                control.value = self._first[name]
            self.face.compare.value = False

    def click(self, panel: str, x: float, y: float) -> None:
        """Do what a click at these data coordinates of a panel does."""
        with self.latest.held():
            for name, value in self.picture.panels[panel].pick(x, y).items():
                refine(self.controls[name], value)
                self.controls[name].value = value

    def close(self) -> None:
        """Take the widgets away and free what they hold."""
        self.latest.cancel()
        for control in (*self.controls.values(), *self.picture.images.values(), self.widget):
            control.close()

    def _repr_mimebundle_(self, **options: Any) -> Any:
        return self.widget._repr_mimebundle_(**options)

    def _clicked(self, panel: str, x: float, y: float) -> None:
        place = self.picture.tiles[panel].place(x, y)
        if place is not None:
            self.click(panel, *place)

    def _changed(self, change: Any) -> None:
        if not same(change["new"], change["old"]):
            self.latest.request()

    def _update(self) -> None:
        with self.busy.mark():
            try:
                settings = self._read()
                result = self.result if settings == self.settings else Result(settings)
                self.busy.left = self.picture.draw(result)
                self.face.describe(result)
            except Exception as error:  # whatever a law of one's own may raise is told, not lost in a log
                self.error, self.busy.left = error, None
                self.face.tell(error_text(error))
                return
            self.settings, self.result, self.error = settings, result, None
            self.running.widget.layout.display = "" if result.ran else "none"
            self.updates += 1
        if self.busy.left:
            self.latest.soon()

    def _read(self) -> Settings:
        model = self.components.model()
        model = model.replace(**self.parameters.values(model))
        return self.running.settings(model)

    def _compare(self, change: Any) -> None:
        if change["new"]:
            self.picture.keep()
        else:
            self.picture.forget()
        self.latest.request()


def explore(model: Any = None, panels: Iterable[Any] = DEFAULT) -> Explorer:
    """Change a model with sliders and watch what it does.

    Every parameter has a slider, made from its symbol, unit, meaning and range: those of your own laws too.
    The nonlinearities can be switched off and on, and the curves of now kept in grey beside those to come.
    The model and its run are ``explorer.model`` and ``explorer.run``, and there as Python and JSON to copy.
    The method is quick at first: to a tolerance of 1e-7, and flights too short to be seen are replaced by
    their limit.

    Parameters
    ----------
    model : Model or None
        Where to start; None takes the paper's.
    panels : iterable of str or callable
        "response", "phase", "forces", "spectrum", "eigenvalues", "mechanism", or functions that take a
        :class:`~frictionlab.widgets.result.Result` and return a
        :class:`~frictionlab.widgets.drawing.Drawing`.  What no panel asks for is not computed.

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
    return Explorer(settings_of(start_of(model)), panels_of(panels))


def start_of(model: Any) -> Any:
    """The model to start from.

    Raises
    ------
    TypeError
        If it is none.
    """
    return SliderOnBelt() if model is None else given_model(model)
