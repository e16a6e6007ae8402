"""Preparations: `frictionlab course` and `frictionlab warmup` for lessons; models' structures for wheels.

``python -m frictionlab.cli.preparation FILE`` derives the structures of the library's models, that is the
tapes and formulas that runs, equilibria and pictures need, and writes them to an archive for the wheel.  So
not even the first process on a machine needs sympy.  They are derived by the code that derives them for the
cache folder, and the archive's files are those of that folder.  :mod:`frictionlab.models.serialisation` reads
them, if they were derived from its own sources.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Iterable, Iterator
from contextlib import suppress
from itertools import combinations
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from zipfile import ZIP_DEFLATED, ZipFile

from .parsing import OneLineParser, add_command, add_json, complain, model_of, print_json

EXIT_FAILED = 1
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

WARMUP_DESCRIPTION = """\
Compile what has to be compiled once on a machine, and run a second of the
slider, so that the first run of a lesson starts at once."""


def add_course(commands: Any) -> OneLineParser:
    """Add the command `course`; returns its parser."""
    parser = add_command(commands, "course", "copy the course's notebooks", COURSE_DESCRIPTION, COURSE_EPILOG)
    parser.add_argument("folder", metavar="FOLDER", help="is made if it is not there")
    add_json(parser)
    return parser


def add_warmup(commands: Any) -> OneLineParser:
    """Add the command `warmup`; returns its parser."""
    epilog = "exit status: 0 ready; 1 the run ended early; 2 bad arguments."
    parser = add_command(
        commands, "warmup", "compile the solver before the lesson", WARMUP_DESCRIPTION, epilog
    )
    add_json(parser)
    return parser


def lessons() -> Path:
    """The folder of the course: within an installed package, beside it in a clone."""
    package = Path(__file__).parents[1]
    folders = (package / "tutorials", package.parent / "tutorials")
    return next((each for each in folders if any(each.glob(NOTEBOOKS))), folders[0])


def course_command(chosen: argparse.Namespace, parser: OneLineParser) -> int:
    """Copy the course; returns the exit status."""
    folder, source = Path(chosen.folder), lessons()
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
    if chosen.json:
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


def warmup_command(chosen: argparse.Namespace, parser: OneLineParser) -> int:
    """Compile, and simulate one second of the slider twice; returns the exit status."""
    import frictionlab as fl
    from frictionlab.hybrid import compilation

    with fl.progress(not chosen.json):
        seconds = []
        for _ in range(2):
            begin = time.perf_counter()
            run = fl.simulate(fl.SliderOnBelt(mu_k=1.4), 1.0)
            seconds.append(time.perf_counter() - begin)
    if compilation.LOADED is not None:
        kind = "compiled ahead of time"
    else:
        kind = "compiled by numba" if compilation.NUMBA is not None else "plain Python"
    if chosen.json:
        print_json({"solver": kind, "first_run": seconds[0], "second_run": seconds[1]})
    else:
        first, second = seconds
        print(f"Ready. The solver is {kind}; the first run took {first:.3g} s, the next {second:.3g} s.")
    return 0 if run.status.ok else EXIT_FAILED


def shipped_models() -> Iterator[Any]:
    """The models that `list_models` lists, each with every subset of its nonlinearities left out."""
    from frictionlab import models

    for row in models.list_models():
        model = model_of(row.call)
        switches = tuple(model.nonlinearities)
        for count in range(len(switches) + 1):
            for names in combinations(switches, count):
                yield model.without(*names)


def derive(model: Any) -> None:
    """Derive all that a run, its picture and its summary need, and the nonlinearities for `without`."""
    import numpy as np

    from frictionlab.hybrid.problem import evaluate_output
    from frictionlab.hybrid.tape.packing import program_of
    from frictionlab.stability import eigenvalues

    automaton, _ = model.automaton(), model.nonlinearities
    program_of(automaton, complete=False)
    count = len(automaton.names)
    states = np.ones((count, len(automaton.state_names)))
    with np.errstate(all="ignore"):
        for name in automaton.outputs:
            evaluate_output(automaton, name, states, np.arange(count), automaton.names)
    with suppress(ValueError):  # there need be no equilibrium
        eigenvalues(model)


def write_archive(path: Path, library: Iterable[Any]) -> None:
    """Derive the structures of models in a temporary cache folder, and write its files to an archive.

    What was derived of a model before this call is in the user's own cache folder, not in the archive:
    `library` should be an iterator that makes the models one by one.
    """
    from frictionlab import cache_folder
    from frictionlab.file_writing import write_file
    from frictionlab.models import serialisation

    with TemporaryDirectory() as folder:
        os.environ[cache_folder.FOLDER_VARIABLE] = folder
        for model in library:
            derive(model)
        path.parent.mkdir(parents=True, exist_ok=True)
        with write_file(path) as beside, ZipFile(beside, "w", ZIP_DEFLATED, compresslevel=9) as archive:
            archive.comment = serialisation.LOADED.digest.encode()
            for kept in sorted(Path(folder).rglob("*.structure")):
                archive.writestr(kept.name, cache_folder.read(kept) or b"")


def main() -> None:
    """Write the archive, unless one derived from the present sources is there already."""
    from frictionlab.models import serialisation

    parser = argparse.ArgumentParser(description="Derive the structures of the library's models beforehand.")
    parser.add_argument("file", type=Path, metavar="FILE", help="the archive")
    path = parser.parse_args().file
    if serialisation.archive_digest(path) != serialisation.LOADED.digest:
        write_archive(path, shipped_models())


if __name__ == "__main__":
    main()
