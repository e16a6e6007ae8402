"""What runs, equilibria and pictures have to know of the library's models, derived beforehand.

``python -m frictionlab.cli.shipped_structures FILE`` writes it to an archive, which a wheel carries: the
first process on a machine then needs no sympy either.  What is asked for here is derived by the code that
derives it for the cache folder, and its files are those of that folder.  See
:mod:`frictionlab.models.structure_data`, which reads them, and of which sources they have to be.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterable, Iterator
from contextlib import suppress
from itertools import combinations
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from zipfile import ZIP_DEFLATED, ZipFile

import numpy as np

from frictionlab import cache_folder, models
from frictionlab.cli.parsing import model_of
from frictionlab.file_writing import write_file
from frictionlab.hybrid.problem import evaluate_output
from frictionlab.hybrid.tape.packing import program_of
from frictionlab.models import structure_data
from frictionlab.stability import eigenvalues


def shipped_models() -> Iterator[Any]:
    """The models of the table, each with all of its nonlinearities and with some of them left out."""
    for row in models.list_models():
        model = model_of(row.call)
        switches = tuple(model.nonlinearities)
        for count in range(len(switches) + 1):
            for names in combinations(switches, count):
                yield model.without(*names)


def derive(model: Any) -> None:
    """Ask for all that a run, its picture and its summary ask for, and `without`."""
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
    """Derive the structures of models, in a cache folder of their own, and write its files to an archive.

    What is asked of a model before goes to the user's own folder: give models that are made one by one.
    """
    with TemporaryDirectory() as folder:
        os.environ[cache_folder.FOLDER_VARIABLE] = folder
        for model in library:
            derive(model)
        path.parent.mkdir(parents=True, exist_ok=True)
        with write_file(path) as beside, ZipFile(beside, "w", ZIP_DEFLATED, compresslevel=9) as archive:
            archive.comment = structure_data.LOADED.digest.encode()
            for kept in sorted(Path(folder).rglob("*.structure")):
                archive.writestr(kept.name, cache_folder.read(kept) or b"")


def main() -> None:
    """Write the archive, unless there is one that was derived from these sources."""
    parser = argparse.ArgumentParser(description="Derive the structures of the library's models beforehand.")
    parser.add_argument("file", type=Path, metavar="FILE", help="the archive")
    path = parser.parse_args().file
    if structure_data.archive_digest(path) != structure_data.LOADED.digest:
        write_archive(path, shipped_models())


if __name__ == "__main__":
    main()
