"""All claims and figures, written as a page with pictures: what `frictionlab reproduce` does."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from frictionlab._version import __version__

from . import steps_page
from .claims import Claims
from .registry import EVERY_CLAIM, FIGURES, WITHOUT_GEOMETRY, check, figure
from .setting import CHATTER, STEP, TOLERANCES, Setting
from .steps import study_of

PAGE = "reproduction.md"
IMAGES = Path("images", "reproduction")
DPI = 90
COLOURS = 128  # of a picture's palette: lines and points need no more, and the file is a third as large
WAYS = {
    "exact": {"algorithm": "exact", "impact": "paper"},
    "full-gap-rate": {"algorithm": "exact", "impact": "full gap rate"},
    "paper-algorithm": {"algorithm": "paper", "impact": "paper"},
}
HEAD = """\
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
E3: after an impact by Eq. (13) the gap still changes at the rate -(x1' - x2') phi, so that the slider may
leave again at once; E5: what follows depends on the algorithm.

"""


def reproduce(folder: str | Path, setting: Setting) -> Path:
    """Check every claim, draw every figure, and write the page.

    Parameters
    ----------
    folder : path
        Takes reproduction.md and step-size.md, and the pictures in images/reproduction/.
    setting : Setting
        Its algorithm and impact law are not used: all are.

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
    pictures = list(_figures())
    with _bar(len(EVERY_CLAIM) + len(pictures) + 1, setting.progress) as bar:
        table = Claims(tuple(_counted(bar, name, check, name, setting) for name in EVERY_CLAIM))
        drawn = [_counted(bar, f"Fig. {n}", _drawn, n, way, folder, setting) for n, way in pictures]
        _counted(bar, "step sizes", _step_sizes, folder, setting)
    page = folder / PAGE
    minutes = (time.monotonic() - begin) / 60
    page.write_text(_head(setting, minutes) + _summary(table) + _figures_text(drawn), encoding="utf-8")
    return page


def _figures() -> Iterator[tuple[int, str]]:
    """Every figure, in each way that makes a difference to it."""
    for number in (*FIGURES, *range(7, 19)):
        for way, options in WAYS.items():
            if number in FIGURES and way != "exact":
                continue
            if number in WITHOUT_GEOMETRY and options["impact"] != "paper":
                continue
            yield number, way


def _bar(total: int, shown: bool) -> Any:
    from tqdm.auto import tqdm

    return tqdm(total=total, desc="reproduce", disable=not shown, leave=False, position=0)


def _counted(bar: Any, text: str, function: Any, *arguments: Any) -> Any:
    bar.set_postfix_str(text)
    result = function(*arguments)
    bar.update()
    return result


def _drawn(number: int, way: str, folder: Path, setting: Setting) -> tuple[Any, Path]:
    """The figure, and its picture's path in the folder."""
    options: dict[str, Any] = {} if number in FIGURES else dict(WAYS[way])
    common = {"quick": setting.quick, "workers": setting.workers, "progress": setting.progress}
    found = figure(number, **options, **common, resume=setting.resume)
    path = IMAGES / (f"fig{number:02d}.png" if way == "exact" else f"fig{number:02d}-{way}.png")
    _write(found.plot(), folder / path)
    return found, path


def _step_sizes(folder: Path, setting: Setting) -> None:
    """The page on what a fixed step does."""
    study, picture = study_of(setting), IMAGES / "step-size.png"
    _write(study.plot(), folder / picture)
    (folder / steps_page.PAGE).write_text(steps_page.page(study, picture.as_posix()), encoding="utf-8")


def _write(picture: Any, path: Path) -> None:
    """A PNG with a palette, where pillow is installed, as it is with matplotlib."""
    from PIL import Image

    picture.savefig(path, dpi=DPI)
    with Image.open(path) as image:
        small = image.convert("RGB").quantize(COLOURS)
    small.save(path, optimize=True)


def _head(setting: Setting, minutes: float) -> str:
    return HEAD.format(
        quick=" --quick" if setting.quick else "",
        version=__version__,
        minutes=minutes,
        chatter=CHATTER,
        step=STEP,
        exact=TOLERANCES["exact"],
        paper=TOLERANCES["paper"],
        by_paper="only by the paper's algorithm",
    )


def _summary(table: Claims) -> str:
    counts = Counter(row.verdict for row in table)
    words = ", ".join(f"{verdict} {count}" for verdict, count in counts.items())
    return f"## Claims\n\n{len(table)} claims: {words}.\n\n{table.to_markdown()}\n\n## Figures\n"


def _figures_text(drawn: list[tuple[Any, Path]]) -> str:
    return "".join(_figure_text(*each) for each in drawn)


def _figure_text(found: Any, path: Path) -> str:
    how = f" ({found.how})" if found.how else ""
    rows = "\n".join(f"* {line}" for line in found.summary)
    heading = f"\n### Fig. {found.number}{how}\n\n{found.caption[0].upper()}{found.caption[1:]}.\n\n"
    return f"{heading}{rows}\n\n![Fig. {found.number}{how}]({path.as_posix()})\n"
