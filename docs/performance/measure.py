"""Measure wall time and error of this solver and of others; print Markdown, or write docs/performance.md.

    python docs/performance/measure.py                               all, some minutes
    python docs/performance/measure.py --scene B --picture b.png     one scene, with its picture
    python docs/performance/measure.py --scene C --avx2              the same on a processor without AVX-512
    python docs/performance/measure.py --quick --json rows.json
    python docs/performance/measure.py -o docs                       writes performance.md, exact-and-fast.md
    python docs/performance/measure.py -o docs --part Starting       one part of performance.md; others stay

What is measured: scenes whose end is known, what each nonlinearity costs, Fig. 9's sweep, linear stability,
Floquet multipliers, basins, a slider of an exported page, and how time and memory grow.  heyoka, CVODE,
PathSim and diffrax are measured where they are installed:
`pip install -r docs/performance/requirements.txt`.

Files, from the bottom up:

    reference_scenes        runs with a known final state
    external, adapters      base of the adapters, and other tools on the same automaton
    compared_methods        ours and theirs by name; the regularised model, without events
    timing, work_precision  runs in turns; a row for each method on a scene
    processors              name and vectors of the processor; a process that does not see AVX-512
    beside_heyoka           ours and heyoka at the same tolerance
    single_costs            the eight scenes without nonlinearities; first calls; native code of each mode;
                            where the time of a run goes
    stability_costs         many eigenvalue problems at once; exact derivatives; Floquet multipliers
    many_runs               runs side by side in lanes; Fig. 9's sweep; basin stability
    growth, chain_and_rod   time and memory against contacts, states, events, length, values, workers
    response_times          size and frames of exported pages
    page_figures, pages     pictures and text of the two pages
"""

from __future__ import annotations

import argparse
import json
import math
import os
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

import beside_heyoka
import growth
import many_runs
import page_figures
import pages
import response_times
import single_costs
import stability_costs
import work_precision
from frictionlab.file_writing import write_text
from processors import PRELOADED, environment_without_avx512
from reference_scenes import ReferenceScene, scenes
from work_precision import WorkPrecisionRow


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure, print and write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="one repetition, short sweep: rougher, faster")
    parser.add_argument("--scene", action="append", choices=scenes(), help="only this one (repeat)")
    parser.add_argument("-o", "--output", type=Path, metavar="FOLDER", help="write all of it as pages")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the rows as JSON, after each scene")
    parser.add_argument("--picture", type=Path, metavar="FILE", help="draw error against processor time")
    parser.add_argument("--part", action="append", choices=pages.PARTS, help="only this part (repeat)")
    parser.add_argument(
        "--avx2", action="store_true", help="hide AVX-512 from all tools (Linux on Intel, cc)"
    )
    chosen = parser.parse_args(arguments)
    if chosen.avx2 and PRELOADED not in os.environ:
        os.execve(sys.executable, [sys.executable, *sys.argv], environment_without_avx512())
    if chosen.scene and chosen.output:
        parser.error("-o needs all scenes: leave --scene out, or take --picture")
    rows: list[WorkPrecisionRow] = []
    if not chosen.part:
        when = pages.measured_on()
        names = chosen.scene or scenes()
        rows = measure_scenes([scenes()[name] for name in names], chosen.quick, chosen.json)
        if chosen.picture:
            page_figures.draw_work_precision(rows).savefig(chosen.picture, dpi=110)
        if chosen.scene:
            return
        if chosen.output:
            pages.write_performance(chosen.output, pages.scene_parts(rows, when))
            pages.draw_scenes(chosen.output, rows)
            print("Written:", pages.write_exact_and_fast(chosen.output, rows))
    measure_parts(chosen.part or pages.PARTS, chosen.quick, chosen.output)


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


def measure_parts(titles: Iterable[str], quick: bool, folder: Path | None) -> None:
    """Measure parts of the page below the scenes; each is written into `folder` as soon as it is measured."""
    repeats = 1 if quick else 3

    def costs() -> str:
        starts = single_costs.starts(repeats)
        switched = single_costs.nonlinearity_costs(repeats=5 * repeats)
        if folder:
            pages.draw_switches(folder, switched)
        return single_costs.nonlinearity_table(switched, starts.first, starts.imported)

    ways: dict[str, Callable[[], str]] = {
        "At heyoka's tolerance": lambda: beside_heyoka.share_table(
            beside_heyoka.measured_rows(3 if quick else beside_heyoka.TURNS)
        ),
        "Where the time goes": lambda: single_costs.time_share_table(
            single_costs.time_shares(repeats=20 * repeats)
        ),
        "What each nonlinearity costs": costs,
        "Native code": lambda: single_costs.native_table(single_costs.native_code_times(repeats)),
        "Starting": lambda: single_costs.start_table(single_costs.start_times(repeats)),
        "Many runs at once": lambda: many_runs.ensemble_table(many_runs.ensemble_times(repeats=3 * repeats)),
        "Fig. 9's sweep": lambda: many_runs.sweep_table(many_runs.sweep_times(30.0 if quick else 300.0, 1)),
        "Linear stability": lambda: stability_costs.eigenproblem_table(
            stability_costs.eigenproblem_times(10_000, repeats)
        ),
        "Floquet multipliers": lambda: stability_costs.multiplier_table(
            stability_costs.multiplier_times(repeats)
        ),
        "Basins of attraction": lambda: many_runs.basin_table(
            many_runs.basin_times(10_000, 20 if quick else 200)
        ),
        "A slider of an exported page": lambda: response_times.page_table(
            response_times.page_frames(20 if quick else 100)
        ),
        "How it grows": lambda: _growth_table(folder, 1e4 if quick else math.inf),
    }
    for title in titles:
        when, begin, table = pages.measured_on(), time.perf_counter(), _table_or_reason(ways[title])
        print(f"\n{title}, {time.perf_counter() - begin:.0f} s\n\n{table}", flush=True)
        if folder:
            print("Written:", pages.write_performance(folder, {title: pages.part(title, table, when)}))


def _table_or_reason(measure: Callable[[], str]) -> str:
    """A table, or why there is none: one that fails must not prevent the others."""
    try:
        return measure()
    except Exception as error:
        return f"Not measured: {type(error).__name__}: {error}\n"


def _growth_table(folder: Path | None, largest: float) -> str:
    rows = growth.growth_curves(largest)
    if folder:
        file = folder / pages.GROWTH_PICTURE
        file.parent.mkdir(parents=True, exist_ok=True)
        growth.draw_growth_curves(rows).savefig(file, dpi=110)
    return growth.growth_table(rows)


if __name__ == "__main__":
    main()
