"""The options of `frictionlab run`; those of the parameters are made from the parameters themselves."""

from __future__ import annotations

import argparse
import sys
from functools import partial
from typing import Any, NoReturn

DESCRIPTION = """\
Simulate the 5-degree-of-freedom slider on a moving belt of Liu & Ouyang (2020)
and print a summary: sliding equilibrium, eigenvalues, events, share of time in
each mode. With -o a picture of the run is drawn as well.

Without options: mu_k = 1.4 and the paper's other values, 20 s from rest. There
the sliding equilibrium is stable, yet from rest the system settles on a
stick-slip vibration with lift-off; compare --x0 near."""

EPILOG = """\
examples:
  frictionlab run -o first-run.png
  frictionlab run --mu-k 2.5 --F 1000 --t-end 50 -o strong.pdf
  frictionlab run --without geometry nonsmooth --x0 near
  frictionlab run --impact full --save run.npz
  frictionlab run --method rk4 --step 1e-4        (the paper's algorithm)

Units are SI, angles are in radians.
A saved run is read in Python with frictionlab.load("run.npz").

exit status: 0 the end time was reached; 1 the run ended early;
2 bad arguments; 130 stopped by ctrl-C (what was computed is kept)."""

METHODS = ("taylor", "rk4", "RK23", "RK45", "DOP853", "Radau", "BDF", "LSODA")
MU_K = 1.4


class OneLineParser(argparse.ArgumentParser):
    """A parser whose errors are one line."""

    def error(self, message: str) -> NoReturn:
        sys.stdout.flush()
        self.exit(2, f"{self.prog}: error: {' '.join(message.split())}\n")


def add_run(commands: Any) -> OneLineParser:
    """Add the command `run`; returns its parser."""
    parser = commands.add_parser(
        "run",
        help="simulate the slider on a belt, print a summary, draw a picture",
        description=DESCRIPTION,
        epilog=EPILOG,
        formatter_class=partial(argparse.RawDescriptionHelpFormatter, max_help_position=28),
        allow_abbrev=False,
    )
    _add_output(parser.add_argument_group("output"))
    _add_run(parser.add_argument_group("run"))
    _add_laws(parser.add_argument_group("laws"))
    _add_parameters(parser)
    return parser


def _add_output(group: Any) -> None:
    group.add_argument("-o", "--output", metavar="FILE", help="picture, e.g. run.png or .pdf (default: none)")
    group.add_argument("--save", metavar="FILE", help="save the run as .npz (default: not saved)")
    group.add_argument("-q", "--quiet", action="store_true", help="no progress bar")


def _add_run(group: Any) -> None:
    group.add_argument("--t-end", type=float, default=20.0, metavar="S", help="end time (default: 20 s)")
    text = (
        "initial state: rest, near (equilibrium displaced by 1 %%), "
        "or numbers with commas, coordinates then velocities (default: rest)"
    )
    group.add_argument("--x0", default="rest", metavar="STATE", help=text)
    group.add_argument("--method", default="taylor", help=f"{', '.join(METHODS)} (default: taylor)")
    group.add_argument(
        "--tol", type=float, help="tolerance of taylor (1e-15) or, relative, of scipy's (1e-10)"
    )
    group.add_argument("--step", type=float, metavar="S", help="step of rk4 (default: 0.0002 s)")
    group.add_argument("--max-steps", type=int, metavar="N", help="end the run after so many steps")


def _add_laws(group: Any) -> None:
    group.add_argument(
        "--without",
        nargs="+",
        action="extend",
        default=[],
        metavar="NAME",
        help="leave nonlinearities out: any of cubic, nonsmooth, geometry",
    )
    group.add_argument(
        "--impact",
        default="material",
        metavar="LAW",
        help="what a re-contact brings to zero: material (the approach to the belt's material point, Eq. 13) "
        "or full (the gap's full rate); restitution reverses it (default: material)",
    )


def _add_parameters(parser: argparse.ArgumentParser) -> None:
    from frictionlab.components import RestitutionImpact
    from frictionlab.components.parameter import parameters_of
    from frictionlab.models import SliderOnBelt

    groups = {"parameters of the structure": SliderOnBelt, "parameters of the contact": SliderOnBelt.contact}
    groups |= {"parameters of the friction": SliderOnBelt.friction}
    groups |= {"parameters of --impact restitution": RestitutionImpact}
    for title, component in groups.items():
        group = parser.add_argument_group(title)
        kind = component if isinstance(component, type) else type(component)
        for name, about in parameters_of(kind).items():
            _add_parameter(group, name, about)


def _add_parameter(group: Any, name: str, about: Any) -> None:
    default = MU_K if name == "mu_k" else about.default
    text = f"{about.meaning} (default: {default:g}{' ' * bool(about.unit)}{about.unit})"
    option = f"--{name.replace('_', '-')}"
    # No default here: only what was given must fit the laws chosen.
    group.add_argument(
        option, dest=f"parameter {name}", type=float, metavar="X", help=text.replace("%", "%%")
    )
