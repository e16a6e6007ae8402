"""`fl.export_page`: a model as one HTML file that needs neither a server nor a network.

It holds two things from `frictionlab.compilation`: the kernels as WebAssembly (``kernels.wasm``),
and from ``manifest.json`` how to call them: the results and arguments in the table of words that each takes.
"""

from __future__ import annotations

import base64
import gzip
import hashlib
import html
import json
import re
from collections.abc import Mapping, Sequence
from importlib import resources
from pathlib import Path
from types import MappingProxyType
from typing import Any

from frictionlab._version import __version__
from frictionlab.analysis.period_of_motion import oscillation_period
from frictionlab.compilation.llvm_instructions import EXP2_COEFFICIENTS
from frictionlab.compilation.manifest import compiled_object
from frictionlab.compilation.targets import WEB
from frictionlab.file_writing import check_folder, write_text
from frictionlab.hybrid.kernels.event_location import COEFFICIENT_ROUNDING
from frictionlab.hybrid.kernels.jets import LOG2_LEAST_RATIO
from frictionlab.hybrid.methods.base import STATUS_OF_CODE
from frictionlab.hybrid.methods.taylor import Taylor
from frictionlab.models.model import ModelOrAutomaton
from frictionlab.pages.javascript import JavaScript
from frictionlab.pages.page_data import (
    chosen_sliders,
    page_laws,
    scene_menu,
    structure_data,
    structures,
    switch_names,
)
from frictionlab.pages.scene import (
    Shown,
    name_of,
    panels_of,
    scene_controls,
    scene_data,
    shown_model,
    usual_duration,
)
from frictionlab.tape.formulas import ELEMENTARY
from frictionlab.tape.functions import FUNCTIONS
from frictionlab.validation import check_path, check_t_end, check_text

BUILD_COMMAND = "python -m frictionlab.compilation --web"
CURE = f'in a clone, run `pip install -e ".[pages]"` and `{BUILD_COMMAND}` once'
MORE_LAWS = "; fl.explore in Python has further ones, and those of contact and impact"
# In the order of loading: while it loads, each needs only those before it.
EQUILIBRIUM = "vendor/ml-matrix", "linear_algebra", "displaced_equilibrium"
SOLVER_SCRIPTS = ("functions", "assembler", "jets", "solver", "sampling", *EQUILIBRIUM)
PICTURES = ("text", "svg", "plot", "turns", "layout", "friction", "panels")
FRONT_END = (*PICTURES, "words", "controls", "state", "challenge", "lesson", "touch", "explorer")
SCRIPTS = (*FRONT_END, *SOLVER_SCRIPTS, "browser_engine", "page")


# What an exported page may do: run its own scripts, by their digests, and WebAssembly; show itself in its own
# style.  It requests nothing, and sends nothing.
POLICY = (
    "default-src 'none'; script-src {scripts} 'wasm-unsafe-eval'; style-src {styles}; base-uri 'none'; "
    "form-action 'none'"
)


class SolverNotBuiltError(FileNotFoundError):
    """The WebAssembly of these kernels has not been built."""


def export_page(
    model: ModelOrAutomaton,
    path: str | Path,
    *,
    x0: Any = "rest",
    sliders: Mapping[str, tuple[float, float]] | Sequence[str] | None = None,
    switches: Sequence[str] | None = None,
    presets: Mapping[str, Mapping[str, Any]] | None = None,
    laws: Sequence[str] | None = None,
    t_end: float | None = None,
    title: str | None = None,
) -> Path:
    """Write a model or an automaton as one HTML file with sliders and the exact solver in it.

    The file needs neither a server nor a network: it can be mailed, put on a stick or into a course's pages.
    The browser runs the same kernels, compiled to WebAssembly, so that states and events are those of
    :func:`frictionlab.simulate` with the Taylor method, to the last bit.

    Parameters
    ----------
    model : Model, Structure or HybridAutomaton
        One of :func:`frictionlab.list_models`, or your own; laws of your own are exported with it.
        A structure is shown by its automaton, with at most 100 freedoms.
    path : path
        Where to write the file, such as ``"slider.html"``.
    x0 : "rest", "near", mapping or array_like (n,)
        Where the run begins, as :func:`frictionlab.simulate` takes it; an automaton is at rest where all its
        states are zero.
    sliders : sequence of names, mapping of name to (low, high), or None
        Parameters whose sliders are shown at first; None chooses some.  All others are under "more
        parameters".
    switches : sequence of names or None
        Nonlinearities that get a switch; None takes all that the model can do without.
    presets : mapping of name to mapping, or None
        Values by name, such as ``{"flutter": {"mu_k": 1.4, "without": ["geometry"]}}``.
    laws : sequence of names or None
        Laws of friction in a menu, by their names in that of :func:`frictionlab.explore`, such as "LuGre".
        None takes five that follow from the speed alone, where the model has few modes.  The others of the
        menu need Python.
    t_end : float or None
        End time in seconds; None takes 200 periods, fewer for a stiff model, but 10 at least.
    title : str or None
        None takes the model's name; that of an automaton is "hybrid automaton".

    Returns
    -------
    Path
        That of the file.

    Raises
    ------
    SolverNotBuiltError
        Where the package was built without WebAssembly; it says how to build it.
    ValueError
        For unknown names, bad values, parameters that are named like another control, a model of more than
        64 modes, or a structure of more than 100 freedoms.
    TypeError
        If `model` is neither a model nor a structure nor an automaton.

    Examples
    --------
    >>> import frictionlab as fl
    >>> fl.export_page(fl.SliderOnBelt(mu_k=1.4), "slider.html")  # doctest: +SKIP
    PosixPath('slider.html')
    """
    name = name_of(model)
    model, start = shown_model(model, x0, "write export_page(model, path)")
    path = check_path("path", path, (".html", ".htm"))
    check_folder(path)
    title = name if title is None else check_text("title", title, "leave it out for the model's name")
    options = {"sliders": sliders, "switches": switches, "presets": presets, "laws": laws, "t_end": t_end}
    return write_text(path, model_page(model, title, start, **options))


def model_page(
    model: Shown,
    title: str,
    start: str | tuple[float, ...] = "rest",
    *,
    sliders: Any = None,
    switches: Any = None,
    presets: Any = None,
    laws: Any = None,
    t_end: float | None = None,
    own: Mapping[str, Any] = MappingProxyType({}),
    mark: str = "",
) -> str:
    """The page of a model, with the options of :func:`export_page`; `own` says more of its scene, and `mark`
    stands in its head.

    A law of the menu is there with all nonlinearities of the model.

    Raises
    ------
    SolverNotBuiltError, ValueError
        As of :func:`export_page`.
    """
    names, with_laws = switch_names(model, switches), page_laws(model, laws)
    models, period = [model, *with_laws.values()], oscillation_period(model, start)
    t_end = usual_duration(model, period) if t_end is None else float(check_t_end(t_end))
    about = ". ".join(filter(None, (getattr(model, name, "") for name in ("about", "reference"))))
    controls = scene_controls(
        models,
        names,
        {"friction": with_laws} if with_laws else {},
        (period, t_end, start),
        sliders=chosen_sliders(model, sliders),
        more_laws=MORE_LAWS,
    )
    scene = scene_data(model, controls, panels_of(model), period, title=title) | {
        "about": f"{about or 'exact solver, in your browser'}; frictionlab {__version__}",
        "switches": names,
        "menu": scene_menu(model, names, presets),
        "method": method_data(),
    }
    script = script_text(SCRIPTS)
    constants = {"SCENE": {**scene, **own}, "SOLVER": solver_data(script)}
    of_laws = {f"|{law}": each for law, each in list(with_laws.items())[1:]}
    derived = {key: structure_data(each) for key, each in (structures(model, names) | of_laws).items()}
    return html_page(title, constants, f"const STRUCTURES = {_javascript(derived)};\n{script}", mark)


def method_data() -> dict[str, Any]:
    """Settings and constants of the method that the page runs."""
    method = Taylor()
    return {
        "tol": method.tol,
        "rounding": COEFFICIENT_ROUNDING,
        "chatter_share": method.chatter_share,
        "elementary": [function.__name__ for function in ELEMENTARY.values()],
        "least_ratio": LOG2_LEAST_RATIO,
        "exp2": EXP2_COEFFICIENTS,
        "endings": {code: status.value for code, status in STATUS_OF_CODE.items()},
        "kinds": {function.name: function.kind for function in FUNCTIONS},
    }


def script_text(names: Sequence[str]) -> str:
    """Scripts of the front end, after the drawing of mechanisms; that of the explorer with its elements."""
    drawing = resources.files("frictionlab.plotting.animation").joinpath("drawing.js")
    markup = f"const MARKUP = {_json(text_of('explorer.html'))};\n" if "explorer" in names else ""
    return drawing.read_text(encoding="utf-8") + markup + "".join(text_of(f"{name}.js") for name in names)


def text_of(name: str) -> str:
    """A file of the front end."""
    return (resources.files("frictionlab.pages") / "scripts" / name).read_text(encoding="utf-8")


def html_page(title: str, constants: Mapping[str, Any], script: str, mark: str = "") -> str:
    """A page that runs a script after these constants, in the style of the front end."""
    data = "".join(f"const {name} = {_json(value)};\n" for name, value in constants.items())
    parts = {
        "MARK": html.escape(f"frictionlab {__version__} {mark}".strip()),
        "TITLE": html.escape(title),
        "STYLE": text_of("explorer.css"),
        "SCRIPT": data + script,
    }
    page = text_of("page.html")
    for name, part in parts.items():
        page = page.replace(f"<!--{name}-->", part)
    policy = POLICY.format(scripts=_digests(page, "script"), styles=_digests(page, "style"))
    return page.replace("<!--POLICY-->", policy, 1)


def _digests(page: str, element: str) -> str:
    """The digests of a page's scripts or styles, as a content security policy names them."""
    texts = re.findall(rf"<{element}>(.*?)</{element}>", page, re.DOTALL)
    digests = (hashlib.sha256(text.encode()).digest() for text in texts)
    return " ".join(f"'sha256-{base64.b64encode(digest).decode()}'" for digest in digests)


def _json(data: Any) -> str:
    # No "<": the browser would read "<!--<script>" in a text as the end of what it runs.
    return json.dumps(data, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")


def _javascript(data: Any) -> str:
    """Data as JavaScript: as JSON, but functions as code."""
    if isinstance(data, JavaScript):
        return data
    if isinstance(data, dict):
        return "{" + ",".join(f"{_json(name)}:{_javascript(value)}" for name, value in data.items()) + "}"
    if isinstance(data, list):
        return "[" + ",".join(map(_javascript, data)) + "]"
    return _json(data)


def solver_data(script: str) -> dict[str, Any]:
    """The compressed WebAssembly module as text, and the argument tables of the functions a script calls.

    Raises
    ------
    SolverNotBuiltError
        Where the files are missing, damaged, or older than the kernels.
    """
    compiled = compiled_object([WEB.file])
    if isinstance(compiled, str):
        raise SolverNotBuiltError(f"export_page needs the solver as WebAssembly, but {compiled}: {CURE}")
    manifest = compiled.manifest
    functions = {name: each for name, each in manifest.functions.items() if f'"{name}"' in script}
    tables = {
        name: {"results": each.results, "arguments": each.arguments} for name, each in functions.items()
    }
    packed = gzip.compress(compiled.content, 9, mtime=0)
    return {"module": base64.b64encode(packed).decode(), "tables": tables}
