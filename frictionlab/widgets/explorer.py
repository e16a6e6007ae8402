"""`fl.explore`, `fl.explore_stability`, `fl.explore_bifurcation`: a model with sliders, and what it does.

`Explorer` connects controls and picture: a change of a control is read into Settings, a Result is made of
them, and the panels draw it.  The three functions differ in their panels.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from typing import TYPE_CHECKING, Any

from frictionlab.compilation.decorators import needs_compilation
from frictionlab.models.model import check_parameter_name
from frictionlab.widgets.controls import ComponentControls, ParameterControls, RunControls
from frictionlab.widgets.number_control import equal_within_rounding
from frictionlab.widgets.panels.bifurcation import BifurcationPanel
from frictionlab.widgets.panels.picture import Picture
from frictionlab.widgets.panels.standard import (
    NAMES,
    CriticalValuePanel,
    eigenvalues,
    phase,
    response,
    select_panels,
    spectrum,
)

from .canvas import MovingMechanism
from .layout import Layout, close_all, error_text
from .result import Result, Settings, default_settings, starting_model
from .state import Comparison, Files, History, State, check_names, control_data, set_control, state_from_text
from .update_scheduler import PAUSE_AFTER_CHANGE, BusyIndicator, UpdateScheduler, in_this_thread

if TYPE_CHECKING:
    from frictionlab.models.model import Model


class Explorer:
    """Controls made from a model's parameters, and a picture that follows them; a notebook shows it.

    Attributes
    ----------
    result : Result
        That of the last values that worked: ``result.run``, ``result.eigenvalues``, ``result.settings``.
    error : Exception or None
        The error raised for the current values.
    controls : mapping of str to widget
        Set the ``value`` of one and the picture follows.  Each has its name as a CSS class, ``fl-<name>``.
    picture : Picture
    layout : Layout
        The arrangement, with its texts and buttons.
    widget : Box
        The whole explorer, to be placed in an application.
    """

    def __init__(self, settings: Settings, panels: dict[str, Any]) -> None:
        self.settings, self.result, self.error = settings, Result(settings), None
        self.start_model, self.history = settings.model, History()
        self.updates = 0  # computed so far
        self.scheduler = UpdateScheduler(self._update, lambda: self.busy.show_waiting())
        self.components, self.running = ComponentControls(settings.model), RunControls(settings)
        self.parameters = ParameterControls(settings.model, self._changed)
        self.extra = {n: c for panel in panels.values() for n, c in getattr(panel, "controls", {}).items()}
        self._first = {name: control.value for name, control in self._others.items()}
        moving = [panel for panel in panels.values() if isinstance(panel, MovingMechanism)]
        self.mechanism = moving[0] if moving else None
        drawn = {name: panel for name, panel in panels.items() if panel not in moving}
        self.picture, self.busy, self.layout = Picture(drawn), BusyIndicator(), Layout()
        self.comparison = Comparison(self.picture, self.layout)
        for control in self._others.values():
            control.observe(self._changed, names="value")
        self.layout.compare.observe(in_this_thread(self._compare), names="value")
        self.layout.screen.observe(in_this_thread(self._restyle), names=("pixels", "dark"))
        self.layout.reset.on_click(in_this_thread(self.reset))
        self.layout.swap.on_click(in_this_thread(lambda _: self.swap()))
        self.layout.undo.on_click(in_this_thread(lambda _: self.undo()))
        self.layout.redo.on_click(in_this_thread(lambda _: self.redo()))
        self.files = Files(self, self._failed, self.load)
        for name, panel in drawn.items():
            if hasattr(panel, "pick"):
                self.picture.images[name].on_click(in_this_thread(partial(self._clicked, name)))
        shown = *self.extra.values(), *self.components.controls.values()
        shown = *shown, self.parameters.widget, self.running.widget
        outputs = [self.picture.images[name] if name in drawn else panels[name].canvas for name in panels]
        self.widget = self.layout.arrange(self.busy.widget, shown, outputs, self.files.widget)
        self.scheduler.request()

    @property
    def model(self) -> Any:
        """The model of the last values that worked."""
        return self.result.model

    @property
    def run(self) -> Any:
        """The run of that model; simulated now if no panel has asked for it."""
        return self.result.run

    @property
    def controls(self) -> dict[str, Any]:
        """Every control by its name."""
        buttons = {name: getattr(self.layout, name) for name in ("compare", "swap", "reset", "undo", "redo")}
        return {**self.parameters.sliders, **self._others, **buttons}

    @property
    def _others(self) -> dict[str, Any]:
        """All controls but the sliders of parameters, which depend on the components."""
        return {**self.components.controls, **self.running.controls, **self.extra}

    def reset(self, _: Any = None) -> None:
        """Reset all controls to their initial values."""
        with self.scheduler.batch():
            self.parameters.reset()
            for name, control in self._others.items():
                control.value = self._first[name]
            self.layout.compare.value = False

    def values(self) -> State:
        """What the controls are set to, as data, without sliders of components that the model lacks."""
        names = self.components.model().parameters
        sliders = {name: self.parameters.sliders[name] for name in names if name in self.parameters.sliders}
        return {name: control_data(control) for name, control in {**self._others, **sliders}.items()}

    def changed(self) -> State:
        """The values that differ from those at the start."""
        return {name: value for name, value in self.values().items() if self.initial.get(name) != value}

    def set_values(self, values: State) -> None:
        """Set controls to values as :meth:`values` gives them, all at once.

        Raises
        ------
        ValueError
            If no control has such a name, or a control cannot have its value; then nothing is changed.
        """
        before = self.values()
        with self.scheduler.batch():
            try:
                self._set(values)
            except ValueError:
                self._set(before)
                raise

    def undo(self) -> None:
        """Set the controls back to the state before, if there is one."""
        self._step(-1)

    def redo(self) -> None:
        """Set the controls to the state that was undone last, if there is one."""
        self._step(1)

    def swap(self) -> None:
        """Keep the present scene and set the controls to the one kept before, if there is one."""
        if (other := self.comparison.state) is not None:
            self._keep()
            self.set_values(other)

    def load(self, content: str | bytes) -> None:
        """Set the controls to a state that was saved.

        Raises
        ------
        ValueError
            If `content` is no saved state, or that of another model.
        """
        model, changed = state_from_text(content)
        if model != self.start_model:
            what = f"got that of {model!r}: open it by fl.explore(fl.{model!r})"
            raise ValueError(f"the state must be that of {self.start_model!r}, {what}")
        self.set_values({**self.initial, **changed})

    def click(self, panel: str, x: float, y: float) -> None:
        """Do what a click at these data coordinates of a panel does."""
        with self.scheduler.batch():
            for name, value in self.picture.panels[panel].pick(x, y).items():
                self.controls[name].value = value

    def close(self) -> None:
        """Close the widgets and free their resources.

        All are closed: a box that stays open when its parts are closed keeps a page from being shown.
        """
        self.scheduler.cancel()
        self.parameters.close()
        close_all(self.widget)

    def _repr_mimebundle_(self, **options: Any) -> Any:
        return self.widget._repr_mimebundle_(**options)

    def _set(self, values: State) -> None:
        """Set lists and switches first, as they decide which sliders there are."""
        others = self._others
        for name in values.keys() & others.keys():
            set_control(name, others[name], values[name])
        self.parameters.show(self.components.model())
        check_names(values, {**others, **self.parameters.sliders})
        for name in values.keys() - others.keys():
            set_control(name, self.parameters.sliders[name], values[name])

    def _step(self, by: int) -> None:
        present = self.history.present
        # Values that gave no picture are not in the history: undo leads from them to the last that did.
        state = present if by < 0 and self.values() != present else self.history.step(by)
        if state is not None:
            self.set_values(state)

    def _record(self) -> None:
        """Add the state that is shown to the history."""
        self.history.record(self.values())
        self.layout.mark(self.history.place > 0, self.history.place + 1 < len(self.history.states))

    @property
    def initial(self) -> State:
        """What the controls were set to at the start."""
        return self.history.initial

    def _failed(self, error: Exception) -> None:
        self.layout.show_message(error_text(error))

    def _clicked(self, panel: str, x: float, y: float) -> None:
        data_coordinates = self.picture.tiles[panel].data_coordinates(x, y)
        if data_coordinates is not None:
            self.click(panel, *data_coordinates)

    def _changed(self, change: Any) -> None:
        if not equal_within_rounding(change["new"], change["old"]):
            self.scheduler.request()

    def _update(self) -> None:
        with self.busy.show_while_busy():
            try:
                settings = self._read()
                self.busy.announce_compilation(needs_compilation(settings.method.entry))
                result = self.result if settings == self.settings else Result(settings)
                moved = result is not self.result
                self.busy.left = self.picture.draw(result, goes_on=bool(self.busy.left) and not moved)
                if self.mechanism is not None:
                    self.mechanism.show(result, self.picture.dark)
                self.layout.describe(result)
                self.comparison.describe(self.values())
            except Exception as error:  # any error of a user's law is shown, not lost in a log
                self.error, self.busy.left = error, None
                self.layout.show_message(error_text(error))
                return
            self.settings, self.result, self.error = settings, result, None
            self.running.widget.layout.display = "" if result.has_run else "none"
            self.updates += 1
            self._record()
        if self.busy.left and self.layout.screen.is_watched:
            self.scheduler.request_later(PAUSE_AFTER_CHANGE if moved else 0.0)

    def _read(self) -> Settings:
        model = self.components.model()
        model = model.replace(**self.parameters.values(model))
        return self.running.settings(model)

    def _compare(self, change: Any) -> None:
        if change["new"]:
            self._keep()
        else:
            self.comparison.forget()
        self.scheduler.request()

    def _keep(self) -> None:
        """Keep the scene that is shown; values that gave no picture are not kept."""
        self.comparison.keep(self.history.present or self.values(), self.result, self.mechanism)

    def _restyle(self, _: Any) -> None:
        """Draw in the size and the colours that the page asks for."""
        screen, dark_before = self.layout.screen, self.picture.dark
        self.picture.set_look(screen.pixels, screen.dark)
        if self.mechanism is not None and self.picture.dark != dark_before:
            self.mechanism.show(self.result, self.picture.dark)
            self.comparison.restyle()
        if self.busy.left:  # the rest has waited until a browser shows it
            self.scheduler.request_later()


def explore(model: Model | None = None, panels: Iterable[Any] | None = None) -> Explorer:
    """Change a model with sliders and watch its motion.

    Every parameter has a slider, made from its symbol, unit, meaning and range; so have those of your own
    laws.  The mechanism moves beside its curves, and can be heard.  The nonlinearities can be switched off
    and on.  A scene can be kept, dotted, to compare others with it.  A button fills the screen.  The model
    and its run are ``explorer.model`` and ``explorer.run``; Python and JSON that recreate them can be copied.
    The initial method is quick: its tolerance is 1e-7, and flights too short to be seen are replaced by their
    limit.

    Parameters
    ----------
    model : Model or None
        Where to start; None takes the paper's.
    panels : iterable of str or callable, or None
        "mechanism", which moves, "response", "phase", "forces", "spectrum", "eigenvalues", or functions that
        take a :class:`~frictionlab.widgets.result.Result` and return a
        :class:`~frictionlab.plotting.figure.Drawing`.  What no panel asks for is not computed.  None takes
        all that have names; "mechanism" where the model has one.

    Returns
    -------
    Explorer

    Raises
    ------
    TypeError
        If `model` is not a model.
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
    model = starting_model(model)
    if panels is None:
        panels = NAMES[model.mechanism is None :]
    return Explorer(default_settings(model), select_panels(panels))


def explore_stability(model: Model | None = None, parameter: str = "mu_k", over: str = "F") -> Explorer:
    """Move a model through a plane of two parameters and watch its eigenvalues.

    Sliders move it, or a click into the plane.

    Parameters
    ----------
    model : Model or None
        Where to start; None takes the paper's.
    parameter, over : str
        The parameter whose critical value is drawn, and the one against which it is drawn.

    Returns
    -------
    Explorer

    Raises
    ------
    TypeError
        If `model` is not a model, or has no such parameter.
    ValueError
        If both are the same parameter.

    Examples
    --------
    >>> import frictionlab as fl
    >>> explorer = fl.explore_stability()
    >>> explorer.controls["mu_k"].value = 1.6
    >>> explorer.result.eigenvalues.stable
    False
    """
    model = starting_model(model)
    for name in (parameter, over):
        check_parameter_name(model, name)
    if parameter == over:
        raise ValueError(f"over must be another parameter than {parameter!r}: take for example 'F'")
    panels = {"eigenvalues": eigenvalues, "critical": CriticalValuePanel(model, parameter, over)}
    return Explorer(default_settings(model), panels)


def explore_bifurcation(model: Model | None = None, parameter: str | None = None) -> Explorer:
    """Zoom into a bifurcation diagram, and see the motion at any value of the parameter.

    The range slider sets the range shown: 24 values at first, in a notebook or an application 300 in the end.
    The parameter's own slider selects the value whose response is shown; so does a click into the diagram.

    Parameters
    ----------
    model : Model or None
        None takes the paper's.
    parameter : str or None
        None takes mu_k, or the model's first parameter where it has no such one.

    Returns
    -------
    Explorer

    Raises
    ------
    TypeError
        If `model` is not a model, or has no such parameter.

    Examples
    --------
    >>> import frictionlab as fl
    >>> explorer = fl.explore_bifurcation(fl.SliderOnBelt().without("geometry"))
    >>> explorer.controls["range"].value = (1.2, 1.5)
    >>> [round(float(x), 3) for x in explorer.picture.tiles["bifurcation"].ax.get_xlim()]
    [1.2, 1.5]
    """
    model = starting_model(model)
    if parameter is None:
        parameter = "mu_k" if "mu_k" in model.parameters else next(iter(model.parameters), "mu_k")
    check_parameter_name(model, parameter)
    panels = {"bifurcation": BifurcationPanel(model, parameter)}
    panels |= {"response": response, "phase": phase, "spectrum": spectrum}
    explorer = Explorer(default_settings(model), panels)
    for name, slider in explorer.parameters.sliders.items():
        # Another parameter means another diagram: it is computed when the slider is let go.
        slider.continuous_update = name == parameter
    return explorer
