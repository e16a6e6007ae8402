"""`frictionlab run`: check the options, simulate, summarise, draw, save.

All options are checked before the run.  What is printed is plain ASCII, so that every terminal shows it.
"""

from __future__ import annotations

import argparse
import gc
import math
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from . import parsing
from .parsing import (
    EXIT_FAILED,
    OneLineParser,
    add_command,
    add_json,
    add_model_options,
    model_data,
    model_from_options,
    print_json,
)
from .stability import equilibrium_lines, stability_data

if TYPE_CHECKING:
    from frictionlab.hybrid.trajectory import Trajectory
    from frictionlab.models.model import ModelOrAutomaton

RUN_DESCRIPTION = """\
Simulate the 5-degree-of-freedom slider on a moving belt of Liu & Ouyang (2020),
or another --model, and print a summary: sliding equilibrium, eigenvalues,
events, share of time in each mode. With -o a picture of the run is drawn as
well.

Without options: mu_k = 1.4 and the paper's other values, 20 s from rest. There
the sliding equilibrium is stable, yet from rest the system settles on a
stick-slip vibration with lift-off; compare --x0 near."""

RUN_EPILOG = """\
examples:
  frictionlab run -o first-run.png
  frictionlab run --set mu_k=2.5 F=1000 --t-end 50 -o strong.pdf
  frictionlab run --without geometry nonsmooth --x0 near --save run.npz
  frictionlab run --model "SliderOnBelt(impact=RestitutionImpact(e=0.5), mu_k=1.4)"
  frictionlab run --method rk4 --step 1e-4        (the paper's algorithm)
  frictionlab run --model DenHartog --set F=1.2 -o den-hartog.png
  frictionlab run --json --set mu_k=2.5

Units are SI, angles are in radians.
A saved run is read in Python with frictionlab.load("run.npz").

exit status: 0 the end time was reached; 1 the run ended early;
2 bad arguments; 130 stopped by ctrl-C (what was computed is kept)."""

METHOD_NAMES = ("taylor", "rk4", "RK23", "RK45", "DOP853", "Radau", "BDF", "LSODA")


def add_run(commands: Any) -> OneLineParser:
    """Add the command `run`; returns its parser."""
    about = "simulate the slider on a belt, print a summary, draw a picture"
    parser = add_command(commands, "run", about, RUN_DESCRIPTION, RUN_EPILOG)
    _add_output(parser.add_argument_group("output"))
    add_json(parser)
    _add_run(parser.add_argument_group("run"))
    add_model_options(parser.add_argument_group("model"))
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
    group.add_argument("--method", default="taylor", help=f"{', '.join(METHOD_NAMES)} (default: taylor)")
    group.add_argument(
        "--tol", type=float, help="tolerance of taylor (1e-15) or, relative, of scipy's (1e-10)"
    )
    group.add_argument("--step", type=float, metavar="S", help="step of rk4 (default: 0.0002 s)")
    group.add_argument("--max-steps", type=int, metavar="N", help="end the run after so many steps")


def method_from_options(args: argparse.Namespace) -> Any:
    """The method with its settings."""
    from frictionlab.hybrid import solve
    from frictionlab.hybrid.methods.one_step import RK4

    by_lower = {name.lower(): name for name in METHOD_NAMES}
    method = solve.method_of(by_lower.get(args.method.lower(), args.method))
    fixed = isinstance(method, RK4)
    if args.step is not None and not fixed:
        raise ValueError(f"--step is an option of --method rk4, got --method {args.method}: leave it out")
    if args.tol is not None and fixed:
        raise ValueError("--tol is no option of --method rk4, which has a fixed step: give --step instead")
    tolerance = "tol" if method.name == "taylor" else "rtol"
    options = {"step": args.step, tolerance: args.tol, "max_steps": args.max_steps}
    return replace(method, **{name: value for name, value in options.items() if value is not None})


def initial_state_from_options(args: argparse.Namespace, model: ModelOrAutomaton) -> Any:
    """The state that --x0 names, or the numbers it holds."""
    from frictionlab.analysis.initial_states import initial_state_of
    from frictionlab.models.model import Model, automaton_of

    names, text = automaton_of(model).state_names, args.x0
    names = names[: 2 * len(model.coordinates)] if isinstance(model, Model) else names
    if "," not in text:
        return initial_state_of(model, text)
    try:
        state = [float(part) for part in text.split(",")]
    except ValueError:
        state = []
    if len(state) != len(names) or not all(map(math.isfinite, state)):
        raise ValueError(
            f"--x0 must be rest, near or {len(names)} numbers ({', '.join(names)}), got {text!r}"
        )
    return state


def before(model: ModelOrAutomaton, method: Any, args: argparse.Namespace) -> str:
    """The lines printed before the run: what is run, and what is known without running it."""
    return "\n".join([_job_line(model, method, args), *equilibrium_lines(model)])


def after(run: Trajectory) -> str:
    """The lines printed after the run: its results."""
    doubt = [] if run.warning is None else [f"Do not trust this run: {run.warning}"]
    return "\n".join([f"\nRun: {run.status}", *doubt, *_event_lines(run), *_time_lines(run), _cost_line(run)])


def _job_line(model: ModelOrAutomaton, method: Any, args: argparse.Namespace) -> str:
    start = {"rest": "from rest", "near": "from near the equilibrium"}.get(args.x0, f"from {args.x0}")
    return f"{model!r}\n{args.t_end:g} s {start}, {_method_line(method)}"


def _method_line(method: Any) -> str:
    about = method.describe()
    name = about.get("integrator", about["name"])
    return f"method {name}, " + ", ".join(f"{k} {about[k]:g}" for k in ("tol", "step", "rtol") if k in about)


def _event_lines(run: Trajectory) -> Iterator[str]:
    yield f"Events: {run.stats['events']}, accumulations closed: {run.stats['accumulations']}"
    counts = run.events.counts()
    width = max(map(len, counts), default=0)
    for kind, count in counts.items():
        yield f"  {kind:{width}}  {count:7d}"


def _time_lines(run: Trajectory) -> Iterator[str]:
    total = sum(run.time_in_mode.values())
    shares = (f"{name} {100 * seconds / (total or 1):.2f} %" for name, seconds in run.time_in_mode.items())
    yield f"Time: {', '.join(shares)}"


def _cost_line(run: Trajectory) -> str:
    return (
        f"Computed {run.raw.t:g} s in {run.stats['steps']} steps, {run.stats['wall_time']:.3g} s of wall time"
    )


def run_command(args: argparse.Namespace, parser: OneLineParser) -> int:
    """Simulate, summarise, draw and save as the options say; returns the exit status."""
    with _without_collection():
        try:
            model, options = _check_options(args)
        except (ValueError, TypeError) as error:
            parser.error(str(error))
    if not args.json:
        print(before(model, options["method"], args), flush=True)
    run, stopped = _simulate(model, args, options, parser)
    if run is None:
        raise stopped or KeyboardInterrupt
    print_json(run_data(run, args)) if args.json else print(after(run), flush=True)
    with _without_collection():
        _write_files(run, args)
    if stopped:
        raise stopped
    return 0 if run.status.ok else EXIT_FAILED


@contextmanager
def _without_collection() -> Iterator[None]:
    """Suspend garbage collection, the search for cycles of objects, and exempt all present objects from it.

    Imports and derivations make many objects and few cycles: the searches would take a tenth of their time,
    and as long again when the process ends.
    """
    before_this = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        gc.freeze()
        if before_this:
            gc.enable()


def _check_options(args: argparse.Namespace) -> tuple[Any, dict[str, Any]]:
    from frictionlab.validation import check_number

    check_number("--t-end", args.t_end, above=0.0, cure="give the length of the run in seconds")
    parsing.check_files(args)
    model = model_from_options(args)
    return model, {"method": method_from_options(args), "x0": initial_state_from_options(args, model)}


def _simulate(
    model: ModelOrAutomaton, args: argparse.Namespace, options: dict[str, Any], parser: OneLineParser
) -> tuple[Any, KeyboardInterrupt | None]:
    """The run, or None if there is none, and the interruption if ctrl-C has stopped it."""
    from frictionlab.analysis.simulate import simulate
    from frictionlab.partial_results import partial_result

    try:
        with warnings.catch_warnings():  # the summary has it
            warnings.filterwarnings("ignore", "do not trust this run", RuntimeWarning)
            return simulate(model, args.t_end, progress=not (args.quiet or args.json), **options), None
    except KeyboardInterrupt as stopped:
        return partial_result(), stopped
    except ValueError as error:
        parser.error(str(error))


def _say(text: str, args: argparse.Namespace) -> None:
    """Print a line, unless standard output is for JSON."""
    if not args.json:
        print(text)


def run_data(run: Trajectory, args: argparse.Namespace) -> dict[str, Any]:
    """The summary of a run for JSON; `sliding` is null where there is no steady sliding."""
    try:
        sliding = stability_data(run.source)
    except ValueError:
        sliding = None
    return {
        **model_data(run.source),
        "x0": args.x0,
        "t": run.raw.t,
        "status": str(run.status),
        "warning": run.warning,
        "finished": run.status.ok,
        "sliding": sliding,
        "events": run.events.counts(),
        "time_in_mode": run.time_in_mode,
        "final_state": dict(zip(run.names, run.final_state, strict=True)),
        "stats": run.stats,
    }


def _write_files(run: Trajectory, args: argparse.Namespace) -> None:
    if args.save is not None:
        saved = run.save(args.save)
        _say(f"Saved as {saved}", args)
    if args.output is not None:
        from frictionlab.plotting import plot_run

        plot_run(run).savefig(args.output)
        _say(f"Picture in {args.output}", args)
