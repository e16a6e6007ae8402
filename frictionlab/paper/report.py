"""All claims and figures, written as pages with pictures: what `frictionlab reproduce` does.

reproduction.md has a block for each claim and every figure in each way that makes a difference to it,
step-size.md the study of fixed steps.
"""

from __future__ import annotations

import re
import time
from collections import Counter
from collections.abc import Iterator
from html import escape
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from frictionlab._version import __version__
from frictionlab.file_writing import write_file, write_text
from frictionlab.interruption import progress_bar
from frictionlab.paper.results import (
    EVERY_CLAIM,
    EVERY_FIGURE,
    FIGURES,
    WITHOUT_GEOMETRY,
    Claim,
    Claims,
    Verdict,
    check,
    figure,
)
from frictionlab.paper.scenes import CHATTER_LIMIT, IMPACTS, PAPER_STEP, RETURN_TOLERANCES, Setting
from frictionlab.paper.step_sizes import IMPACT_LAW_NAMES, StepStudy, step_study

STEP_SIZE_PAGE = "step-size.md"
EXAMPLE_MU_K = 1.4

STEP_SIZE_TEXT = """\
# What a fixed step does to a motion

Written by `frictionlab reproduce`. The same model, the same start (rest), two ways to solve it: the paper's
algorithm, which looks at the conditions of stick, slip and separation when a fixed step is over, at several
steps; and the exact solver, which locates every event.

![Intensity and strongest frequency against mu_k]({picture})

With Eq. (13) as printed (left) an impact leaves the slider with the rate (x1' - x2') phi away from the belt.
Where that is positive it flies again at once, in flights of microseconds and less, until they have come to
nothing. A fixed step sees a flight only where it lasts longer than the step; each step therefore solves
another problem, and no step that one would take is small enough. With the gap's full rate in the law
(right) there are no such flights, and the steps agree with the exact solver.

{errors}

At mu_k = {example:g}:

{table}

The paper prints its algorithm (its Fig. 19) but no step. At {step:g} s it gives a motion that repeats
at 1.58 Hz, as the paper reports (its strongest line is the seventh harmonic); neither a larger nor a smaller
step does, nor does locating the events. So a figure of a non-smooth system is to be trusted only where it
stays the same when the step is halved *and* where the impact law leaves nothing to land between two steps.
frictionlab locates every event to rounding, so that there is no step to choose: see
[tutorials/06-trust-your-solver.ipynb](../tutorials/06-trust-your-solver.ipynb).
"""

REPRODUCTION_PAGE = "reproduction.md"
IMAGES = Path("images", "reproduction")
DPI = 90
COLOURS = 128  # of a picture's palette: lines and points need no more, and the file is a third as large
SOLVER_VARIANTS = {
    "exact": {"algorithm": "exact", "impact": "paper"},
    "full-gap-rate": {"algorithm": "exact", "impact": "full gap rate"},
    "paper-algorithm": {"algorithm": "paper", "impact": "paper"},
}
REPRODUCTION_HEAD = """\
# Reproduction

N. Liu, H. Ouyang, "Friction-induced vibration considering multiple types of nonlinearities", Nonlinear
Dynamics (2020), computed again. This page is written by `frictionlab reproduce`{quick}, version
{version}, in {minutes:.0f} min.

Every claim that a computation can check is computed in up to three ways: by the exact solver (every event
located, chatter replaced by its limit once flights last less than {chatter:g} s) with the impact law as
printed, Eq. (13); by the exact solver with the gap's full rate in that law; and by the paper's algorithm,
fixed steps of {step:g} s. A motion counts as periodic where its whole state returns at the onset of stick
within {exact:g} of its size, for the paper's algorithm, which sees an event up to a step late, within
{paper:g}. The verdict is the exact solver's with Eq. (13); "{by_paper}" means that only the column of
that algorithm shows all that the paper says. E1 to E5 are errata found by deriving the equations again;
E3: after an impact by Eq. (13) the gap still changes at the rate (x1' - x2') phi, so that the slider may
leave again at once; E5: what follows depends on the algorithm.

"""

SIGNS = {
    Verdict.REPRODUCED: "✔",
    Verdict.IN_PART: "◐",
    Verdict.BY_PAPER: "△",
    Verdict.NOT_REPRODUCED: "✘",
}
CLAIM_HEAD = "| claim | verdict | the paper says | pictures |\n|---|---|---|---|"
BLOCK = """\
<details class="claim" id="claim-{name}">
<summary><b>{id}</b> <span class="verdict verdict-{kind}">{sign} {verdict}</span> {where}: {short}</summary>

{rows}

</details>
"""
LONGEST_SUMMARY = 90  # characters of what the paper says, in the line that is always seen


def step_size_page(study: StepStudy, picture: str) -> str:
    """The page, in Markdown."""
    return STEP_SIZE_TEXT.format(
        picture=picture,
        errors=_error_table(study),
        table=_series_table(study),
        example=EXAMPLE_MU_K,
        step=PAPER_STEP,
    )


def _error_table(study: StepStudy) -> str:
    """Relative errors of L_s, by step and impact law."""
    printed_law, full_law = IMPACT_LAW_NAMES["paper"], IMPACT_LAW_NAMES["full gap rate"]
    head = f"| step (s) | error of L_s, {printed_law}: median, largest | {full_law} |"
    printed, full = (study.errors(impact) for impact in IMPACTS)
    rows = [f"| {step:g} | {_error_range(printed[step])} | {_error_range(full[step])} |" for step in printed]
    return "\n".join([head, "|---|---|---|", *rows])


def _error_range(errors: Any) -> str:
    return f"{np.median(errors):.2g}, {errors.max():.2g}"


def _series_table(study: StepStudy) -> str:
    i = int(np.argmin(np.abs(study.mu_k - EXAMPLE_MU_K)))
    rows = [
        f"| {s.label} | {IMPACT_LAW_NAMES[s.impact]} "
        f"| {s.kinds[i]} | {s.intensity[i]:.4g} | {s.strongest[i]:.2f} |"
        for s in study.series
    ]
    head = "| algorithm | impact law | motion | L_s (m^2) | strongest line (Hz) |\n|---|---|---|---|---|"
    return "\n".join([head, *rows])


def reproduce(folder: str | Path, setting: Setting) -> Path:
    """Check every claim, draw every figure, and write the page.

    Parameters
    ----------
    folder : path
        Takes reproduction.md and step-size.md, and the pictures in images/reproduction/.
    setting : Setting
        Its algorithm and impact law are not used, as all are computed.

    Returns
    -------
    Path
        The page.

    Raises
    ------
    KeyboardInterrupt
        After ctrl-C; sweeps are kept where the setting has a folder to resume from.
    """
    begin, folder = time.monotonic(), Path(folder)
    (folder / IMAGES).mkdir(parents=True, exist_ok=True)
    pictures = list(figure_variants())
    count = len(EVERY_CLAIM) + len(pictures) + 1
    with progress_bar(total=count, desc="reproduce", shown=setting.progress, delay=0.0, position=0) as bar:
        table = Claims(tuple(_run_and_count(bar, name, check, name, setting) for name in EVERY_CLAIM))
        drawn = [
            _run_and_count(bar, f"Fig. {n}", _draw_figure, n, way, folder, setting) for n, way in pictures
        ]
        _run_and_count(bar, "step sizes", _write_step_size_page, folder, setting)
    page = folder / REPRODUCTION_PAGE
    minutes = (time.monotonic() - begin) / 60
    text = (
        _head_text(setting, minutes)
        + f"## Claims\n\n{claim_summary(table)}\n\n{claim_blocks(table)}\n## Figures\n"
        + "".join(_figure_text(*each) for each in drawn)
    )
    return write_text(page, text)


def figure_variants() -> Iterator[tuple[int, str]]:
    """The number of every figure, with the name of each solver variant that makes a difference to it."""
    for number in (*FIGURES, *range(7, 19)):
        for way, options in SOLVER_VARIANTS.items():
            if number in FIGURES and way != "exact":
                continue
            if number in WITHOUT_GEOMETRY and options["impact"] != "paper":
                continue
            yield number, way


def _run_and_count(bar: Any, text: str, function: Any, *arguments: Any) -> Any:
    bar.set_postfix_str(text)
    result = function(*arguments)
    bar.update()
    return result


def _draw_figure(number: int, way: str, folder: Path, setting: Setting) -> tuple[Any, Path]:
    """The figure, and its picture's path in the folder."""
    options: dict[str, Any] = {} if number in FIGURES else dict(SOLVER_VARIANTS[way])
    common = {"quick": setting.quick, "workers": setting.workers, "progress": setting.progress}
    result = figure(number, **options, **common, resume=setting.resume)
    path = _picture_path(number, way)
    _save_picture(result.plot(), folder / path)
    return result, path


def _picture_path(number: int, way: str) -> Path:
    return IMAGES / (f"fig{number:02d}.png" if way == "exact" else f"fig{number:02d}-{way}.png")


def _write_step_size_page(folder: Path, setting: Setting) -> None:
    """The page on what a fixed step does."""
    study, picture = step_study(setting), IMAGES / "step-size.png"
    _save_picture(study.plot(), folder / picture)
    write_text(folder / STEP_SIZE_PAGE, step_size_page(study, picture.as_posix()))


def _save_picture(picture: Any, path: Path) -> None:
    """Save a PNG with a palette, by pillow, which is installed with matplotlib."""
    from PIL import Image

    buffer = BytesIO()
    picture.savefig(buffer, dpi=DPI)
    with write_file(path) as beside:
        Image.open(buffer).convert("RGB").quantize(COLOURS).save(beside, optimize=True)


def _head_text(setting: Setting, minutes: float) -> str:
    return REPRODUCTION_HEAD.format(
        quick=" --quick" if setting.quick else "",
        version=__version__,
        minutes=minutes,
        chatter=CHATTER_LIMIT,
        step=PAPER_STEP,
        exact=RETURN_TOLERANCES["exact"],
        paper=RETURN_TOLERANCES["paper"],
        by_paper="only by the paper's algorithm",
    )


def _figure_text(result: Any, path: Path) -> str:
    how = f" ({result.how})" if result.how else ""
    rows = "\n".join(f"* {line}" for line in result.summary)
    heading = f"\n### Fig. {result.number}{how}\n\n{result.caption[0].upper()}{result.caption[1:]}.\n\n"
    return f"{heading}{rows}\n\n![Fig. {result.number}{how}]({path.as_posix()})\n"


def claim_summary(table: Claims) -> str:
    """How many claims have each verdict; then a row for each, with the pictures that it speaks of."""
    verdicts = Counter(row.verdict for row in table)
    words = ", ".join(f"{verdict} {verdicts[verdict]}" for verdict in Verdict if verdicts[verdict])
    rows = [
        f'| <a href="#claim-{row.id.lower()}">{row.id}</a> '
        f"| {SIGNS[row.verdict]} {row.verdict} | {row.where}: {_shortened(row.says)} "
        f"| {_thumbnails(row.where)} |"
        for row in table
    ]
    return "\n".join([f"{len(table)} claims: {words}.", "", CLAIM_HEAD, *rows])


def _thumbnails(where: str) -> str:
    """The pictures of the figures that `where` names, such as "Figs 2, 3"."""
    numbers = map(int, re.findall(r"\d+", where)) if where.startswith("Fig") else ()
    paths = (_picture_path(number, "exact") for number in numbers if number in EVERY_FIGURE)
    return " ".join(f"![{path.stem}]({path.as_posix()})" for path in paths)


def claim_blocks(table: Claims) -> str:
    """One folded block for each claim: the verdict outside, all numbers inside."""
    return "\n".join(map(_block, table))


def _block(row: Claim) -> str:
    return BLOCK.format(
        name=row.id.lower(),
        id=row.id,
        kind=row.verdict.name.lower().replace("_", "-"),
        sign=SIGNS[row.verdict],
        verdict=row.verdict,
        where=escape(row.where),
        short=escape(_shortened(row.says)),
        rows="\n".join(f"* **{head}**: {text}" for head, text in _rows(row) if text),
    )


def _rows(row: Claim) -> tuple[tuple[str, str], ...]:
    return (
        ("the paper says", row.says),
        ("computed, exact solver", row.computed),
        ("with the full gap rate", row.full_gap_rate),
        ("by the paper's algorithm", row.paper_algorithm),
        ("why", row.note),
    )


def _shortened(text: str) -> str:
    if len(text) <= LONGEST_SUMMARY:
        return text
    return text[:LONGEST_SUMMARY].rpartition(" ")[0] + " …"
