"""`frictionlab course`: the notebooks, copied into a folder."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from .parsing import EXIT_FAILED, OneLineParser, add_command, add_json, complain, print_json

NOTEBOOKS = "*.ipynb"
DATA = "diagrams.py", "diagrams/*.*"  # the diagrams that notebooks draw, and the script that computes them

COURSE_DESCRIPTION = """\
Copy the course, notebooks with exercises and solutions and the data of their
dense diagrams, into a folder. What is there already and differs is left as it
is, and the command says so."""

COURSE_EPILOG = """\
examples:
  frictionlab course lessons
  jupyter lab lessons/00-index.ipynb        (pip install "frictionlab[lab]")

exit status: 0 copied; 1 files there are other ones, or nothing can be
written; 2 bad arguments."""


def add_course(commands: Any) -> OneLineParser:
    """Add the command `course`; returns its parser."""
    parser = add_command(commands, "course", "copy the course's notebooks", COURSE_DESCRIPTION, COURSE_EPILOG)
    parser.add_argument("folder", metavar="FOLDER", help="is made if it is not there")
    add_json(parser)
    return parser


def course_folder() -> Path:
    """The folder of the course: within an installed package, beside it in a clone."""
    package = Path(__file__).parents[1]
    folders = (package / "tutorials", package.parent / "tutorials")
    return next((each for each in folders if any(each.glob(NOTEBOOKS))), folders[0])


def course_command(args: argparse.Namespace, parser: OneLineParser) -> int:
    """Copy the course; returns the exit status."""
    folder, source = Path(args.folder), course_folder()
    notebooks = [path.name for path in sorted(source.glob(NOTEBOOKS))]
    if not notebooks:
        cure = "take the folder tutorials/ of the source, which PyPI has as well"
        complain(parser.prog, f"error: this installation has no notebooks: {cure}")
        return EXIT_FAILED
    if folder.exists() and not folder.is_dir():
        parser.error(f"FOLDER must be a folder, {str(folder)!r} is a file: choose another name")
    data = [str(path.relative_to(source)) for each in DATA for path in sorted(source.glob(each))]
    others = [name for name in (*notebooks, *data) if _is_another(folder / name, source / name)]
    if others:
        text = f"{folder} has other versions of {', '.join(others)}: take a new folder, your work stays there"
        complain(parser.prog, f"error: {text}")
        return EXIT_FAILED
    for name in (*notebooks, *data):
        _copy(source / name, folder / name)
    if args.json:
        print_json({"folder": str(folder), "notebooks": notebooks, "data": data})
    else:
        print(f"{len(notebooks)} notebooks in {folder}\nBegin: jupyter lab {folder / notebooks[0]}")
    return 0


def _is_another(there: Path, ours: Path) -> bool:
    return there.exists() and there.read_bytes() != ours.read_bytes()


def _copy(path: Path, target: Path) -> None:
    from frictionlab.file_writing import write_file

    target.parent.mkdir(parents=True, exist_ok=True)
    with write_file(target) as beside:
        Path(beside).write_bytes(path.read_bytes())
