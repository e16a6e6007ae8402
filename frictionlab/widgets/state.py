"""The state of an explorer as data: what its controls are set to, earlier states, and a state kept for
comparison; state, figure and data saved as files, and the loading of a state.
"""

from __future__ import annotations

import io
import json
import time
from collections.abc import Callable, Mapping
from html import escape
from importlib import resources
from typing import TYPE_CHECKING, Any, NamedTuple

import anywidget
import ipywidgets
import numpy as np
import traitlets

from frictionlab.models import Model
from frictionlab.validation import abbreviate, did_you_mean

from .canvas import MovingMechanism
from .layout import Layout, verdict_text
from .number_control import NumberControl, number_from_text
from .panels.picture import Picture
from .update_scheduler import in_this_thread

if TYPE_CHECKING:
    from frictionlab.widgets.result import Result

SAME_MOVE = 0.7  # s: steps of one control that follow each other faster than this are undone together
MAX_STATES = 200  # states of a history, at most
FORMAT = "frictionlab explorer"
KEPT, DOTTED, SOLID = "kept", "dotted, kept", "solid, now"
FIGURES = {"svg": "image/svg+xml", "pdf": "application/pdf", "png": "image/png"}
PRINT_DPI = 300  # dots in an inch of a png
DATA = {"csv": "text/csv", "parquet": "application/vnd.apache.parquet"}
HINTS = {
    "figure": "the picture to print, on white paper",
    "data": "time, states, outputs and mode of the part of the run that is shown",
    "save": "what the controls are set to, as a file that is loaded here again",
    "copy": "the same as text",
}
State = dict[str, Any]


class History:
    """The states an explorer has been in, and which of them is the present one.

    Attributes
    ----------
    states : list of dict
    place : int
        Index of the present state.
    initial : dict
        The first state.
    """

    def __init__(self) -> None:
        self.states: list[State] = []
        self.initial: State = {}
        self.place = -1
        self._moved, self._since = "", 0.0

    @property
    def present(self) -> State | None:
        """The state that was shown last."""
        return self.states[self.place] if self.states else None

    def record(self, state: State) -> None:
        """Record the present state; if it is a new one, the states that had been undone are dropped."""
        now, before = time.monotonic(), self.present
        if state == before:
            return
        self.initial = self.initial or state
        changed = _only_change(before, state)
        together = changed and changed == self._moved and now - self._since < SAME_MOVE
        del self.states[self.place + (0 if together else 1) :]
        self.states = [*self.states, state][-MAX_STATES:]
        self.place, self._moved, self._since = len(self.states) - 1, changed, now

    def step(self, by: int) -> State | None:
        """Make the state before (-1) or after (1) the present one; returns it, or None if there is none."""
        if not 0 <= self.place + by < len(self.states):
            return None
        self.place, self._moved = self.place + by, ""
        return self.states[self.place]


def _only_change(before: State | None, state: State) -> str:
    """The name of the control that differs; empty unless it is exactly one."""
    if before is None or before.keys() != state.keys():
        return ""
    changed = [name for name in state if state[name] != before[name]]
    return changed[0] if len(changed) == 1 else ""


def control_data(control: Any) -> Any:
    """What a control is set to, as data that JSON can hold; for a list, the label chosen."""
    if isinstance(control, ipywidgets.Dropdown):
        return control.label
    return list(control.value) if isinstance(control.value, tuple) else control.value


def set_control(name: str, control: Any, data: Any) -> None:
    """Set a control to what :func:`control_data` gave, or to the text of a link.

    Raises
    ------
    ValueError
        If it cannot be set to that.
    """
    if isinstance(control, NumberControl):
        number = number_from_text(name, data) if isinstance(data, str) else float(data)
        control.check(number)
        control.value = number
        return
    try:
        if isinstance(control, ipywidgets.Dropdown):
            control.label = str(data)
        elif isinstance(control.value, bool):
            control.value = {"true": True, "false": False}[str(data).lower()]
        elif isinstance(control.value, tuple):
            control.value = tuple(float(each) for each in data)
        else:
            control.value = type(control.value)(data)
    except Exception as error:  # the widgets raise errors of several kinds
        raise ValueError(
            f"{name} must be a value of its control, got {abbreviate(data)}: take one that the explorer shows"
        ) from error


def check_names(given: Mapping[str, Any], known: Mapping[str, Any]) -> None:
    """Raise ValueError for a name that no control has."""
    for name in given:
        if name not in known:
            hint = did_you_mean(name, list(known))
            raise ValueError(f"the explorer must have the control {name!r}, got none of that name{hint}")


def state_text(model: Model, changed: State) -> str:
    """The text of a file with the model at the start and what was changed since."""
    return json.dumps({"format": FORMAT, "model": model.to_dict(), "changed": changed}, indent=1)


def state_from_text(text: str | bytes) -> tuple[Any, State]:
    """The model and the changes that :func:`state_text` wrote.

    Raises
    ------
    ValueError
        If it is no such file.
    """
    try:
        data = json.loads(text)
        is_state = data["format"] == FORMAT and isinstance(data["changed"], dict)
        model = data["model"]
    except (ValueError, KeyError, TypeError) as error:
        raise ValueError(
            f"the file must be one that an explorer saved, got {abbreviate(text[:40])}"
        ) from error
    if not is_state:
        raise ValueError(f"the file must be one that an explorer saved, got the format {data['format']!r}")
    return Model.from_dict(model), data["changed"]


class Comparison:
    """The scene that is kept.

    Attributes
    ----------
    state : dict or None
        What the controls were set to; None where nothing is kept.
    result : Result or None
    mechanism : MovingMechanism or None
        That of the kept scene, where the explorer shows one.
    """

    def __init__(self, picture: Picture, layout: Layout) -> None:
        self._picture, self._layout = picture, layout
        self.state: State | None = None
        self.result: Any = None
        self.mechanism: MovingMechanism | None = None

    def keep(self, state: State, result: Result, beside: MovingMechanism | None) -> None:
        """Keep the scene that is shown; its mechanism is shown next to `beside`, the one that moves on."""
        self.state, self.result = state, result
        self._picture.freeze()
        if beside is not None:
            old, self.mechanism = self.mechanism, self.mechanism or MovingMechanism(KEPT)
            self.mechanism.show(result, self._picture.dark)
            if old is None:
                shown = list(self._layout.pictures.children)
                shown.insert(shown.index(beside.canvas) + 1, self.mechanism.canvas)
                self._layout.pictures.children = shown

    def forget(self) -> None:
        """Drop the kept scene."""
        self.state = self.result = None
        self._picture.unfreeze()
        self._layout.show_comparison("")
        if self.mechanism is not None:
            left = [each for each in self._layout.pictures.children if each is not self.mechanism.canvas]
            self._layout.pictures.children = left
            self.mechanism.canvas.close()
            self.mechanism = None

    def restyle(self) -> None:
        """Draw the kept scene's mechanism in the colours of the page."""
        if self.mechanism is not None:
            self.mechanism.show(self.result, self._picture.dark)

    def describe(self, now: State) -> None:
        """Show in what the two scenes differ, and what the kept one does."""
        if self.state is None:
            return
        before = self.state
        names = [name for name in {**before, **now} if before.get(name) != now.get(name)]
        if not names:
            text = "The scene is kept, dotted: move a control, and both are seen."
        else:
            rows = (f"<b>{what}</b>: {_values(names, of)}" for what, of in ((DOTTED, before), (SOLID, now)))
            text = f"{'<br>'.join(rows)}<br>Kept: {verdict_text(self.result)}"
        self._layout.show_comparison(text)


def _values(names: list[str], state: State) -> str:
    return ", ".join(escape(f"{name} = {_shown(state[name])}") for name in names if name in state)


def _shown(value: Any) -> str:
    if isinstance(value, bool):
        return "on" if value else "off"
    return f"{value:.7g}" if isinstance(value, float) else str(value)


class MadeFile(NamedTuple):
    """A file to be saved by the browser: its name, its media type, its content."""

    name: str
    type: str
    content: bytes


class FileButton(anywidget.AnyWidget):
    """A button that saves a file, or copies a text, when it is pressed.

    Parameters
    ----------
    label, hint : str
    make : callable
        Returns a `MadeFile`, or a text to copy.
    failed : callable
        Called with the error if `make` raises one.
    """

    _esm = resources.files("frictionlab.widgets").joinpath("file_button.js").read_text(encoding="utf-8")
    label = traitlets.Unicode().tag(sync=True)
    hint = traitlets.Unicode().tag(sync=True)  # the name tooltip makes views fail

    def __init__(
        self, label: str, hint: str, make: Callable[[], MadeFile | str], failed: Callable[[Exception], None]
    ) -> None:
        super().__init__(label=label, hint=hint)
        self.make, self._failed = make, failed
        self.on_msg(in_this_thread(self._pressed))

    def _pressed(self, *_: Any) -> None:
        try:
            made = self.make()
        except Exception as error:  # shown beside the picture: a missing library, a full disk
            self._failed(error)
            return
        if isinstance(made, str):
            self.send({"text": made})
        else:
            self.send({"name": made.name, "type": made.type}, [made.content])


def figure_file(explorer: Any, kind: str) -> MadeFile:
    """The picture to print, on white paper; svg and pdf hold lines and letters, not pixels."""
    buffer = io.BytesIO()
    explorer.picture.figure_to_print().savefig(buffer, format=kind, dpi=PRINT_DPI)
    return MadeFile(f"{_file_stem(explorer)}.{kind}", FIGURES[kind], buffer.getvalue())


def data_file(explorer: Any, kind: str) -> MadeFile:
    """Time, states, outputs and mode of the part of the run that is shown.

    Raises
    ------
    ImportError
        For parquet without the libraries that write it.
    """
    columns = _columns(explorer.result)
    content = _csv(columns) if kind == "csv" else _parquet(columns)
    return MadeFile(f"{_file_stem(explorer)}.{kind}", DATA[kind], content)


def state_file(explorer: Any) -> MadeFile:
    """The state as a file, which an explorer of the same model can load."""
    text = state_text(explorer.start_model, explorer.changed())
    return MadeFile(f"{_file_stem(explorer)}.json", "application/json", text.encode())


def _file_stem(explorer: Any) -> str:
    return type(explorer.model).__name__


def _columns(result: Result) -> dict[str, Any]:
    run, t = result.run, result.times()
    states = {name: result.states[:, i] for i, name in enumerate(run.names)}
    outputs = {name: run.output(name, t) for name in run.automaton.outputs}
    return {"t": t, **states, **outputs, "mode": result.modes}


def _csv(columns: dict[str, Any]) -> bytes:
    """A line of names, then one for each time; numbers have all their digits."""
    rows = zip(*(values.tolist() for values in map(np.asarray, columns.values())), strict=True)
    lines = (",".join(each if isinstance(each, str) else repr(each) for each in row) for row in rows)
    return "\n".join([",".join(columns), *lines, ""]).encode()


def _parquet(columns: dict[str, Any]) -> bytes:
    try:
        import pandas

        buffer = io.BytesIO()
        pandas.DataFrame(columns).to_parquet(buffer, index=False)
    except ImportError as error:
        cure = "pip install pandas pyarrow, or save csv"
        raise ImportError(f"parquet needs pandas and pyarrow, which are not installed: {cure}") from error
    return buffer.getvalue()


class Files:
    """The buttons that save figure, data and state, and the field that loads a state.

    Attributes
    ----------
    buttons : dict of str to FileButton
    load : FileUpload
    take : callable
        Called with the content of a file that is loaded.
    widget : Box
    """

    def __init__(
        self, explorer: Any, failed: Callable[[Exception], None], load: Callable[[bytes], None]
    ) -> None:
        made = {
            **{f"figure {kind}": lambda kind=kind: figure_file(explorer, kind) for kind in FIGURES},
            **{f"data {kind}": lambda kind=kind: data_file(explorer, kind) for kind in DATA},
            "save state": lambda: state_file(explorer),
            "copy state": lambda: state_text(explorer.start_model, explorer.changed()),
        }
        self.buttons = {
            name: FileButton(name, HINTS[name.split()[0]], make, failed) for name, make in made.items()
        }
        self.load = ipywidgets.FileUpload(accept=".json", description="load state", multiple=False)
        self.load.tooltip = "set all controls to what a saved state says"
        self._failed, self.take = failed, load
        self.load.observe(in_this_thread(self.load_state), names="value")
        layout = ipywidgets.Layout(flex_flow="row wrap")
        self.widget = ipywidgets.Box([*self.buttons.values(), self.load], layout=layout)

    def load_state(self, change: Any) -> None:
        """Load the files that were chosen; an observer of `load`."""
        for each in change["new"]:
            try:
                self.take(bytes(each["content"]))
            except (TypeError, ValueError) as error:
                self._failed(error)
