"""What an explorer gives away: its state, its figure and its data as files, and what takes a state back."""

from __future__ import annotations

import io
from collections.abc import Callable
from importlib import resources
from typing import Any, NamedTuple

import anywidget
import ipywidgets
import numpy as np
import traitlets

from .state import state_text


class MadeFile(NamedTuple):
    """A file for a browser: its name, its media type, its content."""

    name: str
    type: str
    content: bytes


class FileButton(anywidget.AnyWidget):
    """Asks for a file, or a text, when it is pressed.

    Parameters
    ----------
    label, hint : str
    make : callable
        Gives a `MadeFile`, or a text to copy.
    failed : callable
        Is given the error where `make` raises one.
    """

    _esm = resources.files("frictionlab.widgets").joinpath("file_button.js").read_text(encoding="utf-8")
    label = traitlets.Unicode().tag(sync=True)
    hint = traitlets.Unicode().tag(sync=True)  # the name tooltip makes views fail

    def __init__(
        self, label: str, hint: str, make: Callable[[], MadeFile | str], failed: Callable[[Exception], None]
    ) -> None:
        super().__init__(label=label, hint=hint)
        self.make, self._failed = make, failed
        self.on_msg(self._pressed)

    def _pressed(self, *_: Any) -> None:
        try:
            made = self.make()
        except Exception as error:  # told beside the picture: a missing library, a full disk
            self._failed(error)
            return
        if isinstance(made, str):
            self.send({"text": made})
        else:
            self.send({"name": made.name, "type": made.type}, [made.content])


FIGURES = {"svg": "image/svg+xml", "pdf": "application/pdf", "png": "image/png"}
PRINT_DPI = 300  # dots in an inch of a png
DATA = {"csv": "text/csv", "parquet": "application/vnd.apache.parquet"}


def figure_file(explorer: Any, kind: str) -> MadeFile:
    """The picture to print, on white paper: svg and pdf in lines and letters."""
    buffer = io.BytesIO()
    explorer.picture.figure_to_print().savefig(buffer, format=kind, dpi=PRINT_DPI)
    return MadeFile(f"{_stem(explorer)}.{kind}", FIGURES[kind], buffer.getvalue())


def data_file(explorer: Any, kind: str) -> MadeFile:
    """Time, states, outputs and mode of the part of the run that is shown.

    Raises
    ------
    ImportError
        For parquet without the libraries that write it.
    """
    columns = _columns(explorer.result)
    content = _csv(columns) if kind == "csv" else _parquet(columns)
    return MadeFile(f"{_stem(explorer)}.{kind}", DATA[kind], content)


def state_file(explorer: Any) -> MadeFile:
    """The state, which the explorer of the same model loads."""
    text = state_text(explorer.start_model, explorer.changed())
    return MadeFile(f"{_stem(explorer)}.json", "application/json", text.encode())


def _stem(explorer: Any) -> str:
    return type(explorer.model).__name__


def _columns(result: Any) -> dict[str, Any]:
    run, t = result.run, result.times()
    states = {name: result.states[:, i] for i, name in enumerate(run.names)}
    outputs = {name: run.output(name, t) for name in run.automaton.outputs}
    return {"t": t, **states, **outputs, "mode": result.modes}


def _csv(columns: dict[str, Any]) -> bytes:
    """A line for each time, numbers with all their digits."""
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
        Is given the content of a file that is loaded.
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
        self.load.observe(self.load_state, names="value")
        layout = ipywidgets.Layout(flex_flow="row wrap")
        self.widget = ipywidgets.Box([*self.buttons.values(), self.load], layout=layout)

    def load_state(self, change: Any) -> None:
        """Take the files that were chosen, as an observer."""
        for each in change["new"]:
            try:
                self.take(bytes(each["content"]))
            except (TypeError, ValueError) as error:
                self._failed(error)


HINTS = {
    "figure": "the picture to print, on white paper",
    "data": "time, states, outputs and mode of the part of the run that is shown",
    "save": "what the controls are set to, as a file that is loaded here again",
    "copy": "the same as text",
}
