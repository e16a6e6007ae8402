"""Structures of the library's models, derived beforehand for a wheel; no command of `frictionlab`.

``python -m frictionlab.cli.shipped_structures FILE`` derives the structures of the library's models, that is
the tapes and formulas that runs, equilibria and pictures need, and writes them to an archive for the wheel.
So not even the first process on a machine needs sympy.  The code that derives them for the cache folder does
it, and the archive's files are those of that folder.  :mod:`frictionlab.models.kept_structures` reads them,
if they were derived from its own sources.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterable, Iterator
from contextlib import suppress
from itertools import combinations
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

from .parsing import model_of

if TYPE_CHECKING:
    from frictionlab.models.model import Model


def shipped_models() -> Iterator[Any]:
    """The models that `list_models` lists, each with every subset of its nonlinearities left out."""
    from frictionlab import models

    for row in models.list_models():
        model = model_of(row.call)
        switches = tuple(model.nonlinearities)
        for count in range(len(switches) + 1):
            for names in combinations(switches, count):
                yield model.without(*names)


def derive(model: Model) -> None:
    """Derive all that a run, its picture and its summary need, and the nonlinearities for `without`."""
    import numpy as np

    from frictionlab.analysis.initial_states import initial_state_of
    from frictionlab.hybrid.chatter_limit import chatter_limit
    from frictionlab.hybrid.outputs import evaluate_outputs
    from frictionlab.stability import eigenvalues
    from frictionlab.tape.packing import program_of

    automaton, _ = model.automaton(), model.nonlinearities
    program_of(automaton, complete=False)
    chatter_limit(automaton, 1.0)
    initial_state_of(model, "rest", automaton)
    count = len(automaton.names)
    states = np.ones((count, len(automaton.state_names)))
    with np.errstate(all="ignore"):
        evaluate_outputs(automaton, automaton.outputs, states, np.arange(count), automaton.names)
    with suppress(ValueError):  # there need be no equilibrium
        eigenvalues(model)


def write_archive(path: Path, library: Iterable[Any]) -> None:
    """Derive the structures of models in a temporary cache folder, and write its files to an archive.

    What was derived of a model before this call is in the user's own cache folder, not in the archive:
    `library` should be an iterator that makes the models one by one.
    """
    from frictionlab import cache_folder
    from frictionlab.file_writing import write_file
    from frictionlab.models import kept_structures

    with TemporaryDirectory() as folder:
        os.environ[cache_folder.FOLDER_VARIABLE] = folder
        for model in library:
            derive(model)
        path.parent.mkdir(parents=True, exist_ok=True)
        with write_file(path) as beside, ZipFile(beside, "w", ZIP_DEFLATED, compresslevel=9) as archive:
            archive.comment = kept_structures.LOADED.digest.encode()
            for structure in sorted(Path(folder).rglob("*.structure")):
                entry = ZipInfo(structure.name)  # of no date, so that the archive is the same each time
                entry.compress_type = ZIP_DEFLATED
                archive.writestr(entry, cache_folder.read(structure) or b"", compresslevel=9)


def main() -> None:
    """Write the archive, unless one derived from the present sources is there already."""
    from frictionlab.models import kept_structures

    parser = argparse.ArgumentParser(description="Derive the structures of the library's models beforehand.")
    parser.add_argument("file", type=Path, metavar="FILE", help="the archive")
    path = parser.parse_args().file
    if kept_structures.archive_digest(path) != kept_structures.LOADED.digest:
        write_archive(path, shipped_models())


if __name__ == "__main__":
    main()
