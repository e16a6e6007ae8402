"""`frictionlab eig` and `frictionlab critical`: steady sliding, and where it loses stability."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from frictionlab.presentation import output_unit, unit_of_state

from .parsing import (
    OneLineParser,
    add_command,
    add_json,
    add_model_options,
    model_data,
    model_from_options,
    print_json,
)

if TYPE_CHECKING:
    from frictionlab.models.model import ModelOrAutomaton
    from frictionlab.stability.boundaries.stability_changes import StabilityChange

EIG_DESCRIPTION = """\
Print the equilibrium of steady sliding and its eigenvalues: frequencies,
growth rates, and whether it is stable."""

EIG_EPILOG = """\
examples:
  frictionlab eig
  frictionlab eig --set mu_k=2.5
  frictionlab eig --model ModeCoupling --json

exit status: 0 computed; 2 bad arguments, or there is no steady sliding."""

CRITICAL_DESCRIPTION = """\
Print every value of a parameter between LOW and HIGH at which steady sliding
loses or regains stability, with the frequency there and the kind."""

CRITICAL_EPILOG = """\
examples:
  frictionlab critical mu_k 0 4
  frictionlab critical mu_k 0 4 --without geometry
  frictionlab critical v 0.05 3 --model "MassOnBelt(friction=WeakeningStrengthening(), c=0.1)"

exit status: 0 computed; 2 bad arguments, or there is no steady sliding."""


def add_eig(commands: Any) -> OneLineParser:
    """Add the command `eig`; returns its parser."""
    parser = add_command(commands, "eig", "eigenvalues of steady sliding", EIG_DESCRIPTION, EIG_EPILOG)
    add_model_options(parser)
    add_json(parser)
    return parser


def add_critical(commands: Any) -> OneLineParser:
    """Add the command `critical`; returns its parser."""
    about = "where a parameter makes steady sliding unstable"
    parser = add_command(commands, "critical", about, CRITICAL_DESCRIPTION, CRITICAL_EPILOG)
    parser.add_argument("parameter", metavar="PARAMETER", help="such as mu_k")
    parser.add_argument("low", type=float, metavar="LOW", help="from this value")
    parser.add_argument("high", type=float, metavar="HIGH", help="to this one")
    add_model_options(parser)
    add_json(parser)
    return parser


def eig_command(args: argparse.Namespace, parser: OneLineParser) -> int:
    """Print equilibrium and eigenvalues; returns the exit status."""
    from frictionlab.stability import eigenvalues

    try:
        model = model_from_options(args)
        eigenvalues(model)  # raises before anything is printed
    except (ValueError, TypeError) as error:
        parser.error(str(error))
    if args.json:
        print_json({**model_data(model), **stability_data(model)})
    else:
        print(f"{model!r}\n" + "\n".join(equilibrium_lines(model)))
    return 0


def equilibrium_lines(model: ModelOrAutomaton) -> Iterator[str]:
    """Equilibrium and eigenvalues, or one line that says why there are none."""
    from frictionlab.models.model import automaton_of
    from frictionlab.stability import equilibrium
    from frictionlab.stability.equilibrium_points.equilibria import contact_forces

    try:
        point = equilibrium(model)
        yield "\nSliding equilibrium"
        for name, value in zip(automaton_of(model).shown_states, point.q, strict=True):
            yield f"  {name:4} {value:+.6f} {unit_of_state(model, name)}"
        forces = [f"{symbol} {value:.4f} {unit}" for symbol, value, unit in contact_forces(point).values()]
        if math.isfinite(point.penetration):
            unit = output_unit("penetration", model)
            forces = [f"penetration  {point.penetration:+.6f} {unit}", *forces]
        if forces:  # of a model with one contact
            yield f"  {', '.join(forces)}"
        yield from _eigenvalue_lines(model)
    except ValueError as error:
        yield f"\nNo sliding equilibrium: {error}"


def _eigenvalue_lines(model: ModelOrAutomaton) -> Iterator[str]:
    from frictionlab.stability import eigenvalues

    try:
        at_equilibrium = eigenvalues(model)
    except ValueError as error:
        yield f"\nNo eigenvalues: {error}"
        return
    lasting = f"{sum(at_equilibrium.growth_rates >= 0)} do not decay"
    kind = "stable" if at_equilibrium.stable else "marginal" if at_equilibrium.marginal else "unstable"
    verdict = kind if at_equilibrium.stable else f"{kind}: {lasting}"
    yield f"\nEigenvalues there ({verdict})\n  frequency (Hz)  growth rate (1/s)  value (1/s)"
    # Of a conjugate pair the one in the upper half-plane stands for both.
    for value, frequency in zip(at_equilibrium.values, at_equilibrium.frequencies, strict=True):
        if value.imag >= 0:
            pair = f" +- {value.imag:.4f}i" if value.imag else ""
            yield f"  {frequency:14.4f}  {value.real:+17.5f}  {value.real:+.5f}{pair}"


def stability_data(model: ModelOrAutomaton) -> dict[str, Any]:
    """Equilibrium and eigenvalues for JSON; raises ValueError where there are none."""
    from frictionlab.models.model import automaton_of
    from frictionlab.stability import eigenvalues

    at_equilibrium = eigenvalues(model)
    point = at_equilibrium.equilibrium
    forces = {"normal_force": point.normal_force, "friction_force": point.friction_force}
    q = dict(zip(automaton_of(model).shown_states, point.q.tolist(), strict=True))
    return {
        "equilibrium": {**q, "penetration": point.penetration, **forces},
        "eigenvalues": at_equilibrium.values.tolist(),
        "stable": at_equilibrium.stable,
        "marginal": at_equilibrium.marginal,
    }


def critical_command(args: argparse.Namespace, parser: OneLineParser) -> int:
    """Print the changes of stability; returns the exit status."""
    from frictionlab.stability import stability_changes

    try:
        model = model_from_options(args)
        changes = stability_changes(model, args.parameter, (args.low, args.high))
    except (ValueError, TypeError) as error:
        parser.error(str(error))
    rows = [_change_data(change) for change in changes]
    if args.json:
        interval = {"parameter": args.parameter, "bounds": [args.low, args.high]}
        print_json({**model_data(model), **interval, "changes": rows})
    else:
        print("\n".join([f"{model!r}", *map(_change_line, rows)] if rows else _no_change(args, model)))
    return 0


def _change_data(change: StabilityChange) -> dict[str, Any]:
    names = ("value", "kind", "direction", "frequency", "unstable")
    return {name: getattr(change, name) for name in names}


def _change_line(row: dict[str, Any]) -> str:
    before, after = row["unstable"]
    at = f" at {row['frequency']:.4f} Hz" if row["kind"] == "flutter" else ""
    return (
        f"  {row['value']:.8f}  {row['direction']} by {row['kind']}{at}, unstable pairs {before} -> {after}"
    )


def _no_change(args: argparse.Namespace, model: ModelOrAutomaton) -> list[str]:
    between = f"{args.parameter} from {args.low:g} to {args.high:g}"
    return [f"{model!r}", f"  no change of stability with {between}: `frictionlab eig` says which it is"]
