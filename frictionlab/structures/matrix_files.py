"""`fl.read_matrix`: a sparse matrix from a file of a finite-element program, of MATLAB or of scipy."""

from __future__ import annotations

import re
import zlib
from pathlib import Path
from typing import Any
from zipfile import BadZipFile, is_zipfile

import numpy as np
from scipy import io, sparse

from frictionlab.validation import abbreviate, check_path, check_text, did_you_mean_or_known, with_cure

SUFFIXES = (".mtx", ".mat", ".npz", ".txt")
FORTRAN_EXPONENT = re.compile(r"(?<=[0-9.])[dD](?=[+-]?[0-9])")
MATRIX_MARKET = b"%%MatrixMarket"
CURE = "give Matrix Market (.mtx), MATLAB (.mat), scipy's .npz, or rows of three numbers: row, column, entry"


def read_matrix(path: Any, variable: str | None = None) -> sparse.csc_array:
    """A matrix from a file, sparse, as it is written there.

    Parameters
    ----------
    path : str or Path
        ``.mtx``: Matrix Market, or the text that Abaqus writes in its COORDINATE format: in each line row,
        column and entry, counted from 1.  ``.mat``: MATLAB up to version 7.  ``.npz``: by
        ``scipy.sparse.save_npz``.  ``.txt``: rows of three numbers.
    variable : str, optional
        Name of the matrix in a ``.mat`` file that holds several.

    Returns
    -------
    csc_array (n, m)

    Raises
    ------
    FileNotFoundError, PermissionError
        As the system says, with the cure.
    ValueError
        For a file that is not of these kinds or holds no matrix, or several where no `variable` is named.

    Examples
    --------
    >>> import scipy.sparse, tempfile, pathlib, frictionlab as fl
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "K.npz"
    >>> scipy.sparse.save_npz(path, scipy.sparse.diags_array([2.0, 3.0]))
    >>> fl.read_matrix(path).toarray().tolist()
    [[2.0, 0.0], [0.0, 3.0]]
    """
    file = check_path("path", path, SUFFIXES, CURE)
    if variable is not None:
        check_text("variable", variable, "name a matrix of the file")
    try:
        file.open("rb").close()  # scipy's errors of files that are not there differ
        return sparse.csc_array(_READERS[file.suffix.lower()](file, variable))
    except OSError as error:
        raise with_cure(error, file, "check the path") from None
    except (TypeError, KeyError, NotImplementedError, UnicodeDecodeError, BadZipFile, zlib.error) as error:
        raise ValueError(
            f"{file.name} must hold a matrix, got a file that cannot be read ({error}): {CURE}"
        ) from None


def _read_mtx(file: Path, variable: str | None) -> Any:
    with file.open("rb") as stream:
        start = stream.read(len(MATRIX_MARKET))
    if start != MATRIX_MARKET:
        return _read_coordinates(file, variable)
    try:
        return io.mmread(file)
    except ValueError as error:  # which does not name the file
        raise TypeError(error) from None


def _read_coordinates(file: Path, _: str | None) -> Any:
    """Rows of row, column, entry, counted from 1, as Abaqus writes them; commas or blanks between.

    Exponents may be those of Fortran, as in 1.0D+01.
    """
    text = FORTRAN_EXPONENT.sub("e", file.read_text())
    if not text.strip():
        raise TypeError("it is empty")
    try:
        rows = np.loadtxt(text.replace(",", " ").splitlines(), ndmin=2, comments=("%", "*", "#"))
    except ValueError as error:
        raise ValueError(f"{file.name} must hold rows of row, column, entry ({error}): {CURE}") from None
    if rows.shape[1] != 3 or not rows.size:
        raise ValueError(f"{file.name} must hold three numbers in each row, got {rows.shape[1]}: {CURE}")
    i, j = rows[:, :2].T
    if (rows[:, :2] < 1).any() or (rows[:, :2] != rows[:, :2].astype(int)).any():
        raise ValueError(f"rows and columns in {file.name} must be integers from 1 on: {CURE}")
    size = int(max(i.max(), j.max()))
    return sparse.coo_array((rows[:, 2], (i.astype(int) - 1, j.astype(int) - 1)), (size, size))


def _read_mat(file: Path, variable: str | None) -> Any:
    held: dict[str, Any] = {
        name: value for name, value in io.loadmat(file).items() if not name.startswith("__")
    }
    matrices = [name for name, value in held.items() if getattr(value, "ndim", 0) == 2]
    if variable is None and len(matrices) == 1:
        return held[matrices[0]]
    if variable not in matrices:
        hint = did_you_mean_or_known(variable, matrices)
        raise ValueError(f"variable must name a matrix of {file.name}, got {abbreviate(variable)}{hint}")
    return held[variable]


def _read_npz(file: Path, _: str | None) -> Any:
    if not is_zipfile(file):  # numpy takes it for a pickle
        raise BadZipFile("it is no archive")
    return sparse.load_npz(file)


_READERS = {".mtx": _read_mtx, ".mat": _read_mat, ".npz": _read_npz, ".txt": _read_coordinates}
