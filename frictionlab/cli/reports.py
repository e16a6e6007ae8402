"""Commands that compute pictures and pages: `frictionlab figure` and `frictionlab reproduce` for the paper's
results; `frictionlab bench` for run time against error, other tools included.
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from frictionlab.cli import parsing
from frictionlab.cli.parsing import (
    OneLineParser,
    add_command,
    add_json,
    add_sweep_options,
    check_workers,
    complain,
    print_json,
)

EXIT_FAILED = 1

FIGURE_DESCRIPTION = """\
Compute a figure of the paper (Liu & Ouyang 2020), print its numbers and draw
it."""

FIGURE_EPILOG = """\
examples:
  frictionlab figure 2                 (writes fig2.png)
  frictionlab figure 6 -o pairs.pdf
  frictionlab figure 9 --algorithm paper -o fig9.png
  frictionlab figure 12 --impact full --quick

exit status: 0 the picture was written; 1 it could not be; 2 bad arguments;
130 stopped by ctrl-C."""

DEFAULT_FOLDER = "docs"

REPRODUCE_DESCRIPTION = """\
Check every claim of the paper (Liu & Ouyang 2020) by the exact solver, with both
impact laws, and by the paper's algorithm; draw every figure; write
reproduction.md with the pictures beside it."""

REPRODUCE_EPILOG = """\
examples:
  frictionlab reproduce                          (docs/reproduction.md)
  frictionlab reproduce --quick -o check         (a few minutes, coarser grids)
  frictionlab reproduce --resume sweeps          (goes on after ctrl-C)

exit status: 0 the page was written; 1 it could not be; 2 bad arguments;
130 stopped by ctrl-C (with --resume, what was computed is kept)."""


def add_figure(commands: Any) -> OneLineParser:
    """Add the command `figure`; returns its parser."""
    parser = add_command(
        commands, "figure", "compute and draw a figure of the paper", FIGURE_DESCRIPTION, FIGURE_EPILOG
    )
    parser.add_argument("number", type=int, metavar="N", help="the paper's number: 2 to 18")
    parser.add_argument(
        "-o", "--output", metavar="FILE", help="picture, e.g. fig2.png or .pdf (default: figN.png)"
    )
    _add_figure_options(
        parser.add_argument_group("figures 7 to 18, which are of steady states and take minutes")
    )
    add_json(parser)
    parser.set_defaults(save=None)
    return parser


def _add_figure_options(group: Any) -> None:
    group.add_argument(
        "--algorithm",
        default="exact",
        metavar="NAME",
        help="exact, or paper: fixed steps of 0.0002 s (default: exact)",
    )
    group.add_argument(
        "--impact",
        default="paper",
        metavar="LAW",
        help="paper: Eq. 13 as printed; full: the gap's full rate; not for 13 and 14 (default: paper)",
    )
    group.add_argument("--quick", action="store_true", help="a coarser grid")
    add_sweep_options(group)


def figure_command(chosen: argparse.Namespace, parser: OneLineParser) -> int:
    """Check, compute, print and draw; returns the exit status."""
    from frictionlab.paper import figure
    from frictionlab.paper.results import check_figure

    chosen.output = f"fig{chosen.number}.png" if chosen.output is None else chosen.output
    try:
        options = _figure_options(chosen)
        check_figure(chosen.number, options["algorithm"], options["impact"])
        check_workers(chosen.workers)
        parsing.check_files(chosen)
    except ValueError as error:
        parser.error(str(error))
    try:
        result = figure(chosen.number, **options)
    except ValueError as error:  # a file in --resume that is damaged, or of another sweep
        complain(parser.prog, f"error: {error}")
        return EXIT_FAILED
    if not chosen.json:
        print(result, flush=True)
    return _write_picture(result, chosen, parser)


def _figure_options(chosen: argparse.Namespace) -> dict[str, Any]:
    impact = {"full": "full gap rate"}.get(chosen.impact, chosen.impact)
    names = "algorithm", "quick", "workers", "resume"
    return {name: getattr(chosen, name) for name in names} | {"impact": impact}


def _write_picture(result: Any, chosen: argparse.Namespace, parser: OneLineParser) -> int:
    path = chosen.output
    try:
        result.plot().savefig(path)
    except OSError as error:  # a full disk, or a folder that has gone since the check
        complain(parser.prog, f"error: {error}")
        return EXIT_FAILED
    if chosen.json:
        about = {name: getattr(result, name) for name in ("number", "how", "caption", "summary")}
        print_json({**about, "file": path})
    else:
        print(f"Picture in {path}")
    return 0


def add_reproduce(commands: Any) -> OneLineParser:
    """Add the command `reproduce`; returns its parser."""
    parser = add_command(
        commands,
        "reproduce",
        "check every claim of the paper and draw every figure",
        REPRODUCE_DESCRIPTION,
        REPRODUCE_EPILOG,
    )
    parser.add_argument(
        "-o",
        "--output",
        default=DEFAULT_FOLDER,
        metavar="FOLDER",
        help=f"takes the page (default: {DEFAULT_FOLDER})",
    )
    parser.add_argument("--quick", action="store_true", help="coarser grids: a quarter of the time")
    parser.add_argument("-q", "--quiet", action="store_true", help="no progress bar")
    add_json(parser)
    add_sweep_options(parser)
    return parser


def reproduce_command(chosen: argparse.Namespace, parser: OneLineParser) -> int:
    """Check, compute and write; returns the exit status."""
    from frictionlab.paper.report import reproduce
    from frictionlab.paper.scenes import Setting

    try:
        check_workers(chosen.workers)
        for option, path in (("-o", chosen.output), ("--resume", chosen.resume)):
            _check_folder(option, path)
    except ValueError as error:
        parser.error(str(error))
    resume = None if chosen.resume is None else Path(chosen.resume)
    options = {"quick": chosen.quick, "workers": chosen.workers, "progress": not chosen.quiet}
    try:
        page = reproduce(chosen.output, Setting(**options, resume=resume))
    except (OSError, ValueError) as error:  # ValueError: a file in --resume that is damaged
        complain(parser.prog, f"error: {error}")
        return EXIT_FAILED
    print_json({"page": page}) if chosen.json else print(f"Page in {page}")
    return 0


def _check_folder(option: str, path: str | None) -> None:
    if path is not None and Path(path).exists() and not Path(path).is_dir():
        raise ValueError(f"{option} must be a folder, {path!r} is a file: give another")


DESCRIPTION = """\
Measure wall time and error of this solver and of others on scenes whose end is
known, what each nonlinearity costs, Fig. 9's sweep, linear stability, Floquet
multipliers, basins, a step of an explorer's slider, and a slider of an exported
page. Times are medians of interleaved runs on this machine. Prints Markdown.
heyoka, CVODE, PathSim and diffrax are measured where they are installed (extra
"bench")."""

EPILOG = """\
examples:
  frictionlab bench                              (all, some minutes)
  frictionlab bench --scene B --picture b.png    (one scene, with its picture)
  frictionlab bench --quick --json bench.json
  frictionlab bench -o docs                      (writes performance.md and
                                                  exact-and-fast.md there)"""


def add_bench(commands: Any) -> OneLineParser:
    """Add the command `bench`; returns its parser."""
    parser = add_command(commands, "bench", "measure run time and error of the methods", DESCRIPTION, EPILOG)
    parser.add_argument("--quick", action="store_true", help="one repetition, short sweep: rougher, faster")
    parser.add_argument(
        "--scene", action="append", metavar="NAME", help="A, B, C, D, Coulomb or linear; only these (repeat)"
    )
    parser.add_argument("-o", "--output", metavar="FOLDER", help="write all of it as pages with pictures")
    parser.add_argument("--json", metavar="FILE", help="write the rows as JSON, after each scene")
    parser.add_argument("--picture", metavar="FILE", help="draw error against wall time into a file")
    return parser


def bench_command(chosen: argparse.Namespace, parser: OneLineParser) -> int:
    """Measure and print; returns the exit status."""
    from frictionlab.bench.harness import scenes

    known = scenes()
    if chosen.scene and chosen.output:
        parser.error("-o needs all scenes: leave --scene out, or take --picture")
    names = chosen.scene or list(known)
    for name in names:
        if name not in known:
            parser.error(f"--scene must be one of {', '.join(known)}, got {name!r}")
    try:
        _measure_and_write(chosen, [known[name] for name in names])
    except OSError as error:
        complain(parser.prog, f"error: {error}")
        return 1
    return 0


def _measure_and_write(chosen: argparse.Namespace, measured: Sequence[Any]) -> None:
    from frictionlab.bench import page_figures, performance_page, single_costs

    loads = [performance_page.load_average()]
    rows = _measure_scenes(chosen, measured)
    loads.append(performance_page.load_average())
    switched = [] if chosen.scene else single_costs.nonlinearity_costs(repeats=3 if chosen.quick else 15)
    folder = Path(chosen.output) if chosen.output else None
    tables = [] if chosen.scene else _measure_others(chosen.quick, switched, folder)
    if folder is not None:
        written = (
            performance_page.write_performance(folder, rows, tables, loads),
            performance_page.write_exact_and_fast(folder, rows, switched),
        )
        print(f"Pages in {written[0]} and {written[1]}")
    if chosen.picture:
        page_figures.draw_work_precision(rows).savefig(chosen.picture, dpi=110)


def _measure_scenes(chosen: argparse.Namespace, measured: Sequence[Any]) -> list[Any]:
    """The rows of all scenes; after each scene the JSON file is written with the rows so far."""
    from frictionlab.bench import harness
    from frictionlab.file_writing import write_text

    rows: list[Any] = []
    for scene in measured:
        found = harness.measure(scene, repeats=1 if chosen.quick else 3)
        table = harness.work_precision_table(found)
        print(f"\n{scene.name}: {scene.text}, {scene.t_end:.6g} s\n\n{table}", flush=True)
        rows += found
        if chosen.json:
            write_text(Path(chosen.json), json.dumps(harness.as_json(rows), indent=1))
    return rows


def _measure_others(quick: bool, switched: list[Any], folder: Path | None) -> list[str]:
    from frictionlab.bench import many_runs, single_costs, stability_costs

    def costs() -> str:
        starts = single_costs.starts(repeats)
        return single_costs.nonlinearity_table(switched, starts.first, starts.imported)

    repeats = 1 if quick else 3
    measured = {
        "Where the time goes": lambda: single_costs.time_share_table(
            single_costs.time_shares(repeats=5 * repeats)
        ),
        "What each nonlinearity costs": costs,
        "Native code": lambda: single_costs.native_table(single_costs.native_code_times(repeats)),
        "Starting": lambda: single_costs.start_table(single_costs.start_times(repeats)),
        "Many runs": lambda: many_runs.ensemble_table(many_runs.ensemble_times(repeats=repeats)),
        "Fig. 9's sweep": lambda: many_runs.sweep_table(many_runs.sweep_times(30.0 if quick else 300.0, 1)),
        "Linear stability": lambda: stability_costs.eigenproblem_table(
            stability_costs.eigenproblem_times(10_000, repeats)
        ),
        "Floquet multipliers": lambda: stability_costs.multiplier_table(
            stability_costs.multiplier_times(repeats)
        ),
        "Basins": lambda: many_runs.basin_table(many_runs.basin_times(10_000, 20 if quick else 200)),
        "A step of an explorer's slider": lambda: _explorer_table(3 if quick else 10),
        "A slider of an exported page": lambda: _page_table(20 if quick else 100),
        "Growth": lambda: _growth_table(folder, 1e4 if quick else math.inf),
    }
    tables = []
    for title, measure in measured.items():
        tables.append(_table_or_reason(measure))
        print(f"\n{title}\n\n{tables[-1]}", flush=True)
    return tables


def _table_or_reason(measure: Callable[[], str]) -> str:
    """A table, or why there is none: one that fails must not prevent the others."""
    try:
        return measure()
    except Exception as error:
        return f"Not measured: {type(error).__name__}: {error}\n"


def _page_table(count: int) -> str:
    from frictionlab.bench import response_times

    return response_times.page_table(response_times.page_frames(count))


def _growth_table(folder: Path | None, largest: float) -> str:
    from frictionlab.bench import growth, performance_page

    rows = growth.growths(largest)
    if folder is not None:
        file = folder / performance_page.GROWTH_PICTURE
        file.parent.mkdir(parents=True, exist_ok=True)
        growth.draw_growths(rows).savefig(file, dpi=110)
    return growth.growth_table(rows)


def _explorer_table(count: int) -> str:
    from frictionlab.bench import response_times

    return response_times.latency_table(
        {name: response_times.latencies(m, count=count) for name, m in response_times.LATENCY_SCENES.items()}
    )
