"""`fl.explore`, `fl.explore_stability`, `fl.explore_bifurcation`: a model with sliders, and what it does.

`Explorer` is the engine of a front end: a change of a control is read into Settings, a Result is made of
them, and its data go to the browser.  The three functions differ in their panels.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from frictionlab.automaton import HybridAutomaton
from frictionlab.models.model import ModelOrAutomaton, check_parameter_name, values_of
from frictionlab.pages.scene import Shown, last_value, panels_of, scene_data
from frictionlab.presentation import count
from frictionlab.widgets.panels.bifurcation import BifurcationPanel
from frictionlab.widgets.panels.critical_value import CriticalValuePanel
from frictionlab.widgets.panels.standard import Panel, needed_of, select_panels

from .controls import State, chosen_model, chosen_settings, controls_of, set_state
from .front_end import FrontEnd, progress_of, result_data
from .result import Result, Settings, starting_settings
from .update_scheduler import PAUSE_AFTER_CHANGE, UpdateScheduler, in_this_thread, running_loop

if TYPE_CHECKING:
    from frictionlab.plotting.figure import Drawing


class Explorer:
    """Controls made from a model's parameters, and pictures that follow them; a notebook shows it.

    Attributes
    ----------
    result : Result
        That of the last values that worked: ``result.run``, ``result.eigenvalues``, ``result.settings``.
    error : BaseException or None
        The error raised for the current values.
    controls : dict of str to Control
        Set the ``value`` of one and the pictures follow; link it to any widget.
    drawings : dict of str to Drawing or bytes
        What panels of one's own show; what they draw on axes is SVG.
    widget : FrontEnd
        The whole explorer, to be placed in an application.
    """

    def __init__(
        self,
        settings: Settings,
        panels: dict[str, Panel | None],
        widget: FrontEnd | None = None,
        **about: Any,
    ) -> None:
        self.result = Result(settings)
        self.error: BaseException | None = None
        self.start_model, self.panels, self._needed = settings.model, panels, needed_of(panels)
        self.drawings: dict[str, Drawing | bytes] = {}
        self.updates = 0  # computed so far
        self.progress: list[int] | None = None  # parts done and their total, where panels go on
        self.controls = controls_of(settings)
        for panel in panels.values():
            self.controls |= getattr(panel, "controls", {})
        self.initial = self.values()
        self.scheduler = UpdateScheduler(self._update, self._fail)
        self.widget = widget or FrontEnd()
        abouts = [control.about for control in self.controls.values()]
        scene = scene_data(settings.model, abouts, list(panels), settings.period)
        with self.widget.hold_sync():
            self.widget.scene = scene | {"initial": self.initial} | about
            self.widget.state, self.widget.picture = self.initial, {}
        self._sent = self.initial  # the state that Python has set last
        for control in self.controls.values():
            control.observe(lambda _: self.scheduler.request(), names="value")
        answers = {"state": self._moved, "sliding": self._stopped, "shown": self._go_on}
        self._answers = {name: in_this_thread(answer) for name, answer in answers.items()}
        for name, answer in self._answers.items():
            self.widget.observe(answer, names=name)
        self.widget.answers["stop"] = in_this_thread(self._stop)
        self.scheduler.request()

    @property
    def model(self) -> Any:
        """The model of the last values that worked."""
        return self.result.model

    @property
    def run(self) -> Any:
        """The run of that model; simulated now if no panel has asked for it."""
        return self.result.run

    def reset(self) -> None:
        """Reset all controls to their initial values."""
        self.set_values(self.initial)

    def values(self) -> State:
        """What the controls are set to, as data."""
        return {name: control.data for name, control in self.controls.items()}

    def changed(self) -> State:
        """The values that differ from those at the start."""
        return {name: value for name, value in self.values().items() if self.initial[name] != value}

    def set_values(self, values: Mapping[str, Any]) -> None:
        """Set controls to values as :meth:`values` gives them, all at once.

        Raises
        ------
        ValueError
            If no control has such a name, or a control cannot have its value; then nothing is changed.
        """
        with self.scheduler.batch():
            set_state(self.controls, values)

    def close(self) -> None:
        """Close the widget and free its resources."""
        self.release()
        self.widget.close()

    def release(self) -> None:
        """Leave the widget to another explorer."""
        self.scheduler.cancel()
        for name, answer in self._answers.items():
            self.widget.unobserve(answer, names=name)

    def _repr_mimebundle_(self, **options: Any) -> Any:
        return self.widget._repr_mimebundle_(**options)

    def _moved(self, change: Any) -> None:
        """Set the controls as the browser says; what they cannot have is told there."""
        if change["new"] is self._sent:
            return
        state = {name: data for name, data in change["new"].items() if name in self.controls}
        if not self.error and state == self.values():  # an answer that was sent to the browser
            return
        try:
            self.set_values(state)
        except (TypeError, ValueError) as error:
            self._fail(error)

    def _stopped(self, change: Any) -> None:
        """The slider stands still: what has waited for that is computed."""
        if not (change["new"] or self.error or self.widget.picture.get("complete")):
            self.scheduler.request()

    def _go_on(self, _: Any) -> None:
        if self.progress:  # the rest has waited until a browser shows it
            self.scheduler.request_later()

    def _stop(self, _: Any) -> None:
        """End what is computed in parts; ctrl-C has ended what is computed at once."""
        if self.progress:
            self.scheduler.cancel()
            self._fail(KeyboardInterrupt())

    def _update(self) -> None:
        self.widget.computing = True
        asked = self.widget.state
        try:
            model, present = chosen_model(self.start_model, self.controls), self.result.settings
            if isinstance(model, HybridAutomaton) and model.values == values_of(present.model):
                model = present.model  # an automaton equals none but itself
            settings = chosen_settings(model, self.controls, present.period)
            moved = settings != present
            result = Result(settings) if moved else self.result
            self.drawings |= self._drawn(result, goes_on=bool(self.progress) and not moved)
            picture = result_data(result, self.drawings, self._needed, complete=not self.widget.sliding)
        except Exception as error:  # any error of a user's law is shown, not lost in a log
            self._fail(error)
            return
        for name, data in picture["drawings"].items():
            data["pick"] = getattr(self.panels[name], "pick", None)
        self.result, self.error, self.progress = result, None, picture["progress"]
        self.updates += 1
        self.widget.run = result.run if picture.get("samples") else None
        with self.widget.hold_sync():
            self.widget.error, self.widget.picture, self.widget.computing = "", picture, False
            if self.widget.state == asked:  # else the browser has moved on, and an update follows
                self._sent = self.widget.state = self.values()  # in this order: it is heard at once
        if self.progress and (self.widget.shown or not running_loop()):
            self.scheduler.request_later(PAUSE_AFTER_CHANGE if moved else 0.0)

    def _drawn(self, result: Result, goes_on: bool) -> dict[str, Drawing | bytes]:
        """What the panels of one's own draw; where their work goes on, those that are complete do not."""

        def asked(name: str, panel: Panel) -> bool:
            return not goes_on or hasattr(panel, "controls") or bool(progress_of(self.drawings[name]))

        return {name: panel(result) for name, panel in self.panels.items() if panel and asked(name, panel)}

    def _fail(self, error: BaseException) -> None:
        self.error, self.progress = error, None
        with self.widget.hold_sync():
            self.widget.error, self.widget.limits = error_text(error), self._limits()
            self.widget.computing = False

    def _limits(self) -> dict[str, float]:
        """The last value at which the model's rules hold, of a single parameter that was moved beyond it."""
        good, known = self.result.model, values_of(self.result.model)
        moved = [name for name in known if self.controls[name].value != known[name]]
        if len(moved) != 1:
            return {}
        (name,) = moved
        beyond = self.controls[name].value
        last = last_value(good, name, beyond)
        return {name: known[name] if last == beyond else last}  # at its value the error is another one


def error_text(error: BaseException) -> str:
    """The message of an error; its class comes first, except for ValueError and TypeError."""
    if isinstance(error, KeyboardInterrupt):
        return "The computation was stopped: the pictures are those of the last values that worked."
    kind = "" if isinstance(error, (ValueError, TypeError)) else f"{type(error).__name__}: "
    return f"{kind}{str(error) or type(error).__name__}"


def explore(
    model: ModelOrAutomaton | None = None,
    panels: Iterable[Any] | None = None,
    *,
    x0: Any = "rest",
    t_end: float | None = None,
) -> Explorer:
    """Change a model or an automaton with sliders and watch its motion.

    Every parameter has a slider, made from its symbol, unit, meaning and range; so have those of your own
    laws.  An automaton states no ranges: sliders of its parameters go from zero to twice a positive value,
    and to twice the size of a negative one on both sides of zero.  The mechanism moves beside its curves, and
    can be heard.  The nonlinearities can be switched off and on.  A scene can be kept, dotted, to compare
    others with it.  A button fills the screen.  The model and its run are ``explorer.model`` and
    ``explorer.run``; Python that recreates them can be copied.  The initial method is quick: its tolerance is
    1e-7, and flights too short to be seen are replaced by their limit.

    Parameters
    ----------
    model : Model, Structure, HybridAutomaton or None
        Where to start; None takes the paper's.  A structure is shown by its automaton, with at most 100
        freedoms.
    panels : iterable of str or callable, or None
        "mechanism", which moves, "friction", "response", "phase", "forces", "spectrum", "eigenvalues";
        functions ``panel(run, ax)`` that draw with matplotlib; or functions that take a
        :class:`~frictionlab.widgets.result.Result` and return a
        :class:`~frictionlab.plotting.figure.Drawing`.  What no panel asks for is not computed.  None takes
        all that have names; "mechanism" where the model has one, "friction" where it is a
        :class:`~frictionlab.FrictionCurve`, whose points are dragged.
    x0 : "rest", "near", mapping or array_like (n,)
        Where the run begins, as :func:`simulate` takes it; an automaton is at rest where all its states are
        zero.
    t_end : float or None
        Its length, s.  None takes 200 periods: those that are stated, or else found in the motion from
        `x0`.  Those that are found are kept while sliders move.

    Returns
    -------
    Explorer

    Raises
    ------
    TypeError
        If `model` is neither a model nor a structure nor an automaton.
    ValueError
        For an unknown panel, a bad `x0` or `t_end`, and parameters named like another control.

    Examples
    --------
    >>> import frictionlab as fl
    >>> explorer = fl.explore(panels=["eigenvalues"])
    >>> explorer.controls["mu_k"].value = 1.6
    >>> explorer.model, explorer.result.eigenvalues.stable
    (SliderOnBelt(mu_k=1.6), False)
    """
    settings = starting_settings(model, x0, t_end)
    return Explorer(settings, select_panels(panels_of(settings.model) if panels is None else panels))


def explore_stability(
    model: ModelOrAutomaton | None = None, parameter: str | None = None, over: str | None = None
) -> Explorer:
    """Move a model through a plane of two parameters and watch its eigenvalues.

    Sliders move it, or a click into the plane.

    Parameters
    ----------
    model : Model, Structure, HybridAutomaton or None
        Where to start; None takes the paper's.
    parameter, over : str or None
        The parameter whose critical value is drawn, and the one against which it is drawn.  None takes mu_k
        and F, or the model's first parameters where it has no such ones.

    Returns
    -------
    Explorer

    Raises
    ------
    TypeError
        If `model` is neither a model nor a structure nor an automaton, or has no such parameter.
    ValueError
        If both are the same parameter, or the model has fewer than two.

    Examples
    --------
    >>> import frictionlab as fl
    >>> explorer = fl.explore_stability()
    >>> explorer.controls["mu_k"].value = 1.6
    >>> explorer.result.eigenvalues.stable
    False
    """
    settings = starting_settings(model)
    model = settings.model
    if len(known := values_of(model)) < 2:
        raise ValueError(
            f"model must have two parameters, got {count(len(known), 'parameter')}"
            f"{' (' + ', '.join(known) + ')' if known else ''}: take fl.eigenvalues(model)"
        )
    for name in (parameter, over):
        if name is not None:
            check_parameter_name(model, name)
    parameter = _usual_parameter(model, "mu_k", over) if parameter is None else parameter
    over = _usual_parameter(model, "F", parameter) if over is None else over
    if parameter == over:
        raise ValueError(f"over must be another parameter than {parameter!r}: take for example 'F'")
    return Explorer(settings, {"eigenvalues": None, "critical": CriticalValuePanel(model, parameter, over)})


def _usual_parameter(model: Shown, name: str, other: str | None = None) -> str:
    """The parameter of this name, or the model's first one that is not the `other`."""
    known = [one for one in values_of(model) if one != other]
    return name if name in known else next(iter(known), name)


def explore_bifurcation(
    model: ModelOrAutomaton | None = None, parameter: str | None = None, *, x0: Any = "rest"
) -> Explorer:
    """Zoom into a bifurcation diagram, and see the motion at any value of the parameter.

    The fields of the range set what is shown: 24 values at first, in a notebook or an application 300 in the
    end.  The parameter's own slider selects the value whose response is shown; so does a click into the
    diagram.

    Parameters
    ----------
    model : Model, Structure, HybridAutomaton or None
        None takes the paper's.
    parameter : str or None
        None takes mu_k, or the model's first parameter where it has no such one.
    x0 : "rest", "near", mapping or array_like (n,)
        Where each motion begins, as :func:`explore` takes it.

    Returns
    -------
    Explorer

    Raises
    ------
    TypeError
        If `model` is neither a model nor a structure nor an automaton, or has no such parameter.

    Examples
    --------
    >>> import frictionlab as fl
    >>> explorer = fl.explore_bifurcation(fl.SliderOnBelt().without("geometry"))
    >>> explorer.controls["range"].value = (1.2, 1.5)
    >>> explorer.drawings["bifurcation"].xlim
    (1.2, 1.5)
    """
    settings = starting_settings(model, x0)
    model = settings.model
    parameter = _usual_parameter(model, "mu_k") if parameter is None else parameter
    check_parameter_name(model, parameter)
    panels = {
        "bifurcation": BifurcationPanel(model, parameter, settings.period),
        "response": None,
        "phase": None,
    }
    return Explorer(settings, panels | {"spectrum": None}, settles=parameter)
