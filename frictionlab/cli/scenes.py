"""Models on the command line: `frictionlab models` lists them; `--model`, `--set`, `--without` choose
one; and `--json`.
"""

from __future__ import annotations

import argparse
import ast
import json
import math
from collections.abc import Mapping
from typing import Any

from frictionlab.cli.parsing import OneLineParser, add_command

DEFAULT_MODEL = "SliderOnBelt"
SHOWN = {"SliderOnBelt": {"mu_k": 1.4}}  # what its commands begin with, where the paper's cycle is


def add_model_options(group: Any) -> None:
    """Which model, with which values."""
    text = f"of `frictionlab models`, with laws as in Python if you like (default: {DEFAULT_MODEL})"
    group.add_argument("--model", metavar="NAME", default=DEFAULT_MODEL, help=text)
    add_values(group)
    text = "leave nonlinearities out: cubic, nonsmooth, geometry, as far as the model has them"
    group.add_argument("--without", nargs="+", action="extend", default=[], metavar="NAME", help=text)


def add_values(group: Any) -> None:
    """Values of parameters, `--set mu_k=1.4 v=-1`."""
    text = "values of parameters, such as mu_k=1.4 v=-1; `frictionlab models NAME` lists them"
    group.add_argument(
        "--set", nargs="+", action="extend", default=[], metavar="P=X", dest="values", help=text
    )


def add_json(group: Any) -> None:
    """One JSON object instead of words."""
    group.add_argument("--json", action="store_true", help="print one JSON object, and nothing else")


def model_from_options(chosen: argparse.Namespace) -> Any:
    """The model with its laws and values; ValueError or TypeError as the model raises."""
    model = model_of(chosen.model)
    given = SHOWN.get(chosen.model, {}) | values_of(chosen.values)
    return model.without(*chosen.without).replace(**given) if chosen.without else model.replace(**given)


def values_of(words: list[str]) -> dict[str, float]:
    """Numbers by name of words such as mu_k=1.4; ValueError for any other."""
    return dict(_value_of(word) for word in words)


def _value_of(word: str) -> tuple[str, float]:
    name, equals, text = word.partition("=")
    try:
        if not (name.isidentifier() and equals):
            raise ValueError
        return name, float(text)
    except ValueError:
        rule = "--set takes a parameter, = and a number without spaces"
        raise ValueError(f"{rule}, got {word!r}: write --set mu_k=1.4") from None


def model_of(text: str) -> Any:
    """The model that a text names: `DenHartog` or `MassOnBelt(friction=Stribeck(v_s=0.1), c=0.1)`.

    Raises
    ------
    ValueError, TypeError
        For names that are no models or laws, and for values that the model refuses.
    """
    from frictionlab.validation import did_you_mean

    name, known = text.partition("(")[0].strip().removeprefix("fl."), model_names()
    if name not in known:
        listed = ", ".join(known)
        hint = did_you_mean(name, known) or ": `frictionlab models` says what each is"
        raise ValueError(f"--model must be one of {listed}, got {name!r}{hint}")
    try:
        node = ast.parse(text if "(" in text else f"{text}()", mode="eval").body
    except SyntaxError:
        raise ValueError(f"--model must be a name or a call, got {text!r}: close what is open") from None
    return _component(node, text)


def model_names() -> list[str]:
    """Names of the package's models, in the order of their table."""
    from frictionlab.models.library.catalogue import MODEL_ROWS

    return list(dict.fromkeys(row.call.partition("(")[0] for row in MODEL_ROWS))


def _component(node: ast.expr, text: str) -> Any:
    """A model or law that is called with numbers, texts and laws by name; else the value of a literal."""
    import frictionlab as fl
    from frictionlab.components.component import Component

    if not isinstance(node, ast.Call):
        return _literal(node, text)
    name = node.func.id if isinstance(node.func, ast.Name) else getattr(node.func, "attr", "")
    kind = getattr(fl, name) if name in fl.__all__ else None
    if node.args or not (isinstance(kind, type) and issubclass(kind, Component)):
        laws = "laws by their names, values as keywords"
        raise ValueError(
            f"--model takes {laws}, got {ast.unparse(node)!r}: write MassOnBelt(friction=Stribeck())"
        )
    return kind(**{str(each.arg): _component(each.value, text) for each in node.keywords})


def _literal(node: ast.expr, text: str) -> Any:
    try:
        return ast.literal_eval(node)
    except ValueError:
        rule = "--model takes numbers, texts and laws as values"
        raise ValueError(f"{rule}, got {ast.unparse(node)!r} in {text!r}: write numbers out") from None


def model_data(model: Any) -> dict[str, Any]:
    """What JSON says of a model."""
    return {"model": type(model).__name__, "call": repr(model), "parameters": dict(model.parameters)}


def print_json(data: Mapping[str, Any]) -> None:
    """One JSON object on standard output; numbers as numpy has them too."""
    print(json.dumps(_plain(data), indent=2, ensure_ascii=True, allow_nan=False))


def _plain(value: Any) -> Any:
    """The same as what JSON knows: lists, objects, texts, finite numbers, and null for those that are not."""
    value = value.tolist() if hasattr(value, "tolist") else value
    if isinstance(value, Mapping):
        return {str(name): _plain(each) for name, each in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(each) for each in value]
    if isinstance(value, complex):
        return {"real": _plain(value.real), "imag": _plain(value.imag)}
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value if value is None or isinstance(value, bool | int) else str(value)


DESCRIPTION = """\
List the models, each with a line and a reference; with a NAME the parameters
of that model, with symbol, value, unit and meaning."""

EPILOG = """\
examples:
  frictionlab models
  frictionlab models DenHartog
  frictionlab models "MassOnBelt(friction=Stribeck())" --json

exit status: 0 listed; 2 bad arguments."""


def add_models(commands: Any) -> OneLineParser:
    """Add the command `models`; returns its parser."""
    parser = add_command(commands, "models", "list the models, or the parameters of one", DESCRIPTION, EPILOG)
    parser.add_argument("name", nargs="?", metavar="NAME", help="a model, with laws if you like")
    add_json(parser)
    return parser


def models_command(chosen: argparse.Namespace, parser: OneLineParser) -> int:
    """Print the list, or one model; returns the exit status."""
    try:
        data, text = _all_models() if chosen.name is None else _one_model(chosen.name)
    except (ValueError, TypeError) as error:
        parser.error(str(error).replace("--model", "NAME"))
    print_json(data) if chosen.json else print(text)
    return 0


def _all_models() -> tuple[dict[str, Any], str]:
    from frictionlab.models.library.catalogue import MODEL_ROWS

    rows = [{**row._asdict(), "call": row.call.replace("fl.", "")} for row in MODEL_ROWS]
    lines = [f"{row['call']}\n    {row['about']}\n    {row['reference']}" for row in rows]
    hint = "\nRun one: frictionlab run --model DenHartog; its parameters: frictionlab models DenHartog"
    return {"models": rows}, "\n".join([*lines, hint])


def _one_model(name: str) -> tuple[dict[str, Any], str]:
    model = model_of(name)
    rows = [
        {"name": row.name, "value": row.value, "unit": row.unit, "meaning": row.meaning}
        for row in model.describe()
    ]
    width = max(len(row["name"]) for row in rows)
    lines = [
        f"  {row['name']:{width}}  {row['value']:>10g} {row['unit']:7} {row['meaning']}".rstrip()
        for row in rows
    ]
    head = [f"{model!r}", f"coordinates {', '.join(model.coordinates)}; without: {_switches(model)}"]
    about = {"coordinates": list(model.coordinates), "nonlinearities": list(model.nonlinearities)}
    return {**model_data(model), **about, "described": rows}, "\n".join([*head, *lines])


def _switches(model: Any) -> str:
    return ", ".join(model.nonlinearities) or "nothing"
