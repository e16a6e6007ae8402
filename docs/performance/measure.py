"""Measure wall time and error of this solver and of others; print Markdown, or write docs/performance.md.

    python docs/performance/measure.py                               all, some minutes
    python docs/performance/measure.py --scene B --picture b.png     one scene, with its picture
    python docs/performance/measure.py --quick --json rows.json
    python docs/performance/measure.py -o docs                       writes performance.md, exact-and-fast.md

What is measured: scenes whose end is known, what each nonlinearity costs, Fig. 9's sweep, linear stability,
Floquet multipliers, basins, a step of an explorer's slider, a slider of an exported page, and how time and
memory grow.  heyoka, CVODE, PathSim and diffrax are measured where they are installed:
`pip install -r docs/performance/requirements.txt`.

Files, from the bottom up:

    reference_scenes        runs with a known final state
    external, adapters      base of the adapters, and other tools on the same automaton
    compared_methods        ours and theirs by name; the regularised model, without events
    timing, work_precision  runs in turns; a row for each method on a scene
    single_costs            the eight scenes without nonlinearities; first calls; native code of each mode;
                            where the time of a run goes
    stability_costs         many eigenvalue problems at once; exact derivatives; Floquet multipliers
    many_runs               runs side by side in lanes; Fig. 9's sweep; basin stability
    growth, chain_and_rod   time and memory against contacts, states, events, length, values, workers
    response_times          a step of an explorer's slider; size and frames of exported pages
    page_figures, pages     pictures and text of the two pages
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Callable, Sequence
from pathlib import Path

import growth
import many_runs
import page_figures
import pages
import response_times
import single_costs
import stability_costs
import work_precision
from frictionlab.file_writing import write_text
from reference_scenes import ReferenceScene, scenes
from single_costs import NonlinearityCost
from work_precision import WorkPrecisionRow


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure, print and write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="one repetition, short sweep: rougher, faster")
    parser.add_argument("--scene", action="append", choices=scenes(), help="only this one (repeat)")
    parser.add_argument("-o", "--output", type=Path, metavar="FOLDER", help="write all of it as pages")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the rows as JSON, after each scene")
    parser.add_argument("--picture", type=Path, metavar="FILE", help="draw error against wall time")
    chosen = parser.parse_args(arguments)
    if chosen.scene and chosen.output:
        parser.error("-o needs all scenes: leave --scene out, or take --picture")
    loads = [pages.load_average()]
    rows = measure_scenes([scenes()[name] for name in chosen.scene or scenes()], chosen.quick, chosen.json)
    loads.append(pages.load_average())
    if chosen.picture:
        page_figures.draw_work_precision(rows).savefig(chosen.picture, dpi=110)
    if chosen.scene:
        return
    switched = single_costs.nonlinearity_costs(repeats=3 if chosen.quick else 15)
    tables = measure_others(chosen.quick, switched, chosen.output)
    if chosen.output:
        page = pages.write_performance(chosen.output, rows, tables, loads)
        print(f"Pages in {page} and {pages.write_exact_and_fast(chosen.output, rows, switched)}")


def measure_scenes(
    measured: Sequence[ReferenceScene], quick: bool, file: Path | None
) -> list[WorkPrecisionRow]:
    """The rows of all scenes; after each scene `file` is written with the rows so far."""
    rows: list[WorkPrecisionRow] = []
    for scene in measured:
        new = work_precision.measure(scene, repeats=1 if quick else 3)
        table = work_precision.work_precision_table(new)
        print(f"\n{scene.name}: {scene.text}, {scene.t_end:.6g} s\n\n{table}", flush=True)
        rows += new
        if file:
            write_text(file, json.dumps(work_precision.as_json(rows), indent=1))
    return rows


def measure_others(quick: bool, switched: Sequence[NonlinearityCost], folder: Path | None) -> list[str]:
    """The tables of the page below the scenes, in its order; the picture of growth goes into `folder`."""
    repeats = 1 if quick else 3

    def costs() -> str:
        starts = single_costs.starts(repeats)
        return single_costs.nonlinearity_table(switched, starts.first, starts.imported)

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
        "A slider of an exported page": lambda: response_times.page_table(
            response_times.page_frames(20 if quick else 100)
        ),
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


def _explorer_table(count: int) -> str:
    return response_times.latency_table(
        {name: response_times.latencies(m, count=count) for name, m in response_times.LATENCY_SCENES.items()}
    )


def _growth_table(folder: Path | None, largest: float) -> str:
    rows = growth.growth_curves(largest)
    if folder:
        file = folder / pages.GROWTH_PICTURE
        file.parent.mkdir(parents=True, exist_ok=True)
        growth.draw_growth_curves(rows).savefig(file, dpi=110)
    return growth.growth_table(rows)


if __name__ == "__main__":
    main()
