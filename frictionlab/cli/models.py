"""`frictionlab models`: the models, and the parameters of one."""

from __future__ import annotations

import argparse
from typing import Any

from .parsing import (
    OneLineParser,
    add_command,
    add_json,
    model_data,
    model_of,
    print_json,
)

MODELS_DESCRIPTION = """\
List the models, each with a line and a reference; with a NAME the parameters
of that model, with symbol, value, unit and meaning."""

MODELS_EPILOG = """\
examples:
  frictionlab models
  frictionlab models DenHartog
  frictionlab models "MassOnBelt(friction=Stribeck())" --json

exit status: 0 listed; 2 bad arguments."""


def add_models(commands: Any) -> OneLineParser:
    """Add the command `models`; returns its parser."""
    parser = add_command(
        commands, "models", "list the models, or the parameters of one", MODELS_DESCRIPTION, MODELS_EPILOG
    )
    parser.add_argument("name", nargs="?", metavar="NAME", help="a model, with laws if you like")
    add_json(parser)
    return parser


def models_command(args: argparse.Namespace, parser: OneLineParser) -> int:
    """Print the list, or one model; returns the exit status."""
    try:
        data, text = _all_models() if args.name is None else _one_model(args.name)
    except (ValueError, TypeError) as error:
        parser.error(str(error).replace("--model", "NAME"))
    print_json(data) if args.json else print(text)
    return 0


def _all_models() -> tuple[dict[str, Any], str]:
    from frictionlab.models.library.catalogue import list_models

    table = list_models()
    rows = [{**row._asdict(), "call": row.call.replace("fl.", "")} for row in table]
    hint = "\nRun one: frictionlab run --model DenHartog; its parameters: frictionlab models DenHartog"
    return {"models": rows}, f"{table!r}".replace("fl.", "") + f"\n{hint}"


def _one_model(name: str) -> tuple[dict[str, Any], str]:
    model = model_of(name)
    table, switches = model.describe(), ", ".join(model.nonlinearities) or "nothing"
    rows = [{"name": row.name, "value": row.value, "unit": row.unit, "meaning": row.meaning} for row in table]
    about = {"coordinates": list(model.coordinates), "nonlinearities": list(model.nonlinearities)}
    head = f"{model!r}\ncoordinates {', '.join(model.coordinates)}; without: {switches}"
    return {**model_data(model), **about, "described": rows}, f"{head}\n{table!r}"
