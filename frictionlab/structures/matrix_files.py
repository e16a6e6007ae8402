"""`fl.read_matrix`: a sparse matrix from a file of a finite-element program, of MATLAB or of scipy.

Files that name nodes and directions in place of rows have the freedoms that they name.  Matrices of one
structure get those that all its files name, as the mass may lack some and friction has few.
"""

from __future__ import annotations

import re
import warnings
import zlib
from collections.abc import Iterable, Iterator
from importlib import import_module
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple
from zipfile import BadZipFile, is_zipfile

import numpy as np
from scipy import io, sparse

from frictionlab.validation import (
    abbreviate,
    check_path,
    check_text,
    did_you_mean_or_known,
    with_cure,
)

DIRECTIONS = 64  # of a node: more than any program has
FORTRAN_EXPONENT = re.compile(r"(?<=[0-9.])[dD](?=[+-]?[0-9])")
MATRIX_MARKET = b"%%MatrixMarket"
CURE = (
    "give Matrix Market (.mtx), MATLAB (.mat), .npz, .npy, .csv, Harwell-Boeing (.hb, .rsa), Nastran's .op4 "
    "or .pch, or rows of row, column, entry"
)
FORTRAN_FORMAT = re.compile(r"[IEDFG](\d+)[^,)]*\)", re.IGNORECASE)  # of which only the width is needed
TRIANGLES = {"S": 1.0, "Z": -1.0}  # symmetric and skew matrices of Harwell-Boeing files
SMALL_FIELD, LARGE_FIELD = 8, 16  # characters of a field of Nastran's, but for the first of a line
SQUARE, SYMMETRIC = 1, 6  # forms of a matrix of Nastran's
COMPLEX_TYPES = (3, 4)
NASTRAN_EXPONENT = re.compile(r"(?<=[0-9.])(?=[+-][0-9])")  # 1.0+3 is 1.0e+3


class NodalEntries(NamedTuple):
    """Entries of a matrix whose rows and columns are directions of nodes.

    Parameters
    ----------
    rows, columns : int array (N,)
        DIRECTIONS times the node, and the direction.
    entries : array (N,)
    others : int array (K,)
        Freedoms that other matrices of the file name.
    """

    rows: Any
    columns: Any
    entries: Any
    others: Any = ()

    @property
    def freedoms(self) -> Any:
        """The freedoms that are named, ascending."""
        return np.unique(np.concatenate([self.rows, self.columns, np.asarray(self.others, dtype=int)]))

    def matrix(self, freedoms: Any) -> sparse.csc_array:
        """The matrix of these freedoms, ascending."""
        places = np.searchsorted(freedoms, self.rows), np.searchsorted(freedoms, self.columns)
        n = len(freedoms)
        return sparse.csc_array(sparse.coo_array((self.entries, places), (n, n)))


def read_matrix(path: Any, variable: str | None = None) -> sparse.csc_array:
    """A matrix from a file, sparse, as it is written there.

    Parameters
    ----------
    path : str or Path
        ``.mtx``: Matrix Market, or what Abaqus writes.  In its COORDINATE format a line has row, column and
        entry, counted from 1.  In its MATRIX INPUT format it has node, direction, node, direction and entry;
        a triangle stands for a symmetric matrix there, and rows are in the order of
        :func:`read_freedoms`.  ``.mat``: MATLAB up to version 7.  ``.npz``: by ``scipy.sparse.save_npz``.
        ``.op4``: Nastran (needs pyNastran).  ``.pch``: DMIG entries of Nastran, by nodes and directions; all
        matrices of the file have the freedoms that any of them names.  ``.txt``: as the rows of Abaqus.
        ``.npy``: by ``numpy.save``.  ``.csv``: all entries, with commas between.  ``.hb``, ``.rb``, ``.rsa``,
        ``.rua``, ``.csa``, ``.cua`` or ``.matrix``: Harwell-Boeing, as Ansys writes it; a triangle stands for
        a symmetric or a skew matrix there.
    variable : str, optional
        Name of the matrix in a file that holds several: ``.mat``, ``.npz``, ``.op4`` or ``.pch``.

    Returns
    -------
    csc_array (n, m)

    Raises
    ------
    FileNotFoundError, PermissionError
        As the system says, with the cure.
    ImportError
        For Nastran's files without pyNastran.
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
    given = _read(path, variable)
    return given.matrix(given.freedoms) if isinstance(given, NodalEntries) else given


def read_freedoms(path: Any, variable: str | None = None) -> Any:
    """Node and direction of each freedom of a matrix of Abaqus' MATRIX INPUT format, or Nastran's punch file.

    Parameters
    ----------
    path : str or Path
    variable : str, optional
        As of :func:`read_matrix`.

    Returns
    -------
    int array (n, 2)
        Ascending, in the order of the rows of :func:`read_matrix`.  A structure of several such files has
        the freedoms that any of them names.

    Raises
    ------
    FileNotFoundError, PermissionError
        As the system says, with the cure.
    ValueError
        For a file that names no nodes.

    Examples
    --------
    >>> import tempfile, pathlib, frictionlab as fl
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "K.mtx"
    >>> _ = path.write_text("7,1, 7,1, 2.0\\n9,2, 7,1, -1.0\\n9,2, 9,2, 3.0\\n")
    >>> fl.read_freedoms(path).tolist()
    [[7, 1], [9, 2]]
    >>> fl.read_matrix(path).toarray().tolist()
    [[2.0, -1.0], [-1.0, 3.0]]
    """
    given = _read(path, variable)
    if not isinstance(given, NodalEntries):
        raise ValueError(
            f"{Path(path).name} must name nodes to have freedoms, got a matrix of rows and columns: write it "
            "in Abaqus' MATRIX INPUT format"
        )
    return np.stack(np.divmod(given.freedoms, DIRECTIONS), axis=1)


def read_matrices(paths: Iterable[Any]) -> dict[Any, sparse.csc_array]:
    """The matrices of one structure by their paths; those that name nodes have the same freedoms."""
    read = {path: _read(path, None) for path in paths}
    named = [one.freedoms for one in read.values() if isinstance(one, NodalEntries)]
    freedoms = np.unique(np.concatenate(named)) if named else None
    return {
        path: one.matrix(freedoms) if isinstance(one, NodalEntries) else one for path, one in read.items()
    }


def _read(path: Any, variable: str | None) -> Any:
    """A matrix, or the entries of one by nodes."""
    file = check_path("path", path, tuple(_READERS), CURE)
    if variable is not None:
        check_text("variable", variable, "name a matrix of the file")
    try:
        file.open("rb").close()  # scipy's errors of files that are not there differ
        given = _READERS[file.suffix.lower()](file, variable)
        return given if isinstance(given, NodalEntries) else sparse.csc_array(given)
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
    """Rows as Abaqus writes them, commas or blanks between: of three numbers, or of five with nodes.

    Exponents may be those of Fortran, as in 1.0D+01.
    """
    text = FORTRAN_EXPONENT.sub("e", file.read_text())
    if not text.strip():
        raise TypeError("it is empty")
    try:
        rows = np.loadtxt(text.replace(",", " ").splitlines(), ndmin=2, comments=("%", "*", "#"))
    except ValueError as error:
        raise ValueError(f"{file.name} must hold rows of row, column, entry ({error}): {CURE}") from None
    if rows.shape[1] not in (3, 5) or not rows.size:
        raise ValueError(
            f"{file.name} must hold three numbers in each row, or five with nodes, got {rows.shape[1]}: "
            f"{CURE}"
        )
    places = rows[:, :-1].astype(int)
    if (rows[:, :-1] != places).any():
        raise ValueError(f"rows and columns in {file.name} must be integers: {CURE}")
    if rows.shape[1] == 5:
        return _nodal_entries(file, places, rows[:, -1])
    if (places < 1).any():
        raise ValueError(f"rows and columns in {file.name} must be integers from 1 on: {CURE}")
    size = int(places.max())
    return sparse.coo_array((rows[:, 2], tuple(places.T - 1)), (size, size))


def _nodal_entries(file: Path, places: Any, entries: Any) -> NodalEntries:
    """Entries by node and direction; those of a triangle, with a diagonal, and of the other one.

    Abaqus' rules: a symmetric matrix is one triangle, or both.
    """
    directions = places[:, 1::2]
    if (directions < 0).any() or (directions >= DIRECTIONS).any():
        raise ValueError(f"directions of nodes in {file.name} must be from 0 to {DIRECTIONS - 1}: {CURE}")
    rows, columns = DIRECTIONS * places[:, 0] + places[:, 1], DIRECTIONS * places[:, 2] + places[:, 3]
    given = NodalEntries(rows, columns, entries)
    aside = rows != columns
    across = given._replace(rows=columns[aside], columns=rows[aside], entries=entries[aside])
    pattern, other = (abs(one.matrix(given.freedoms)).astype(bool) for one in (given, across))
    if not aside.any() or not pattern.diagonal().all() or pattern.multiply(other).nnz:
        return given
    return NodalEntries(*map(np.concatenate, zip(given, across, strict=True)))


def _read_mat(file: Path, variable: str | None) -> Any:
    try:
        held = io.loadmat(file)
    except NotImplementedError:
        raise ValueError(
            f"{file.name} must be of MATLAB up to version 7, got one of version 7.3: save it with '-v7'"
        ) from None
    return _chosen(file, {name: one for name, one in held.items() if not name.startswith("__")}, variable)


def _chosen(file: Path, held: dict[str, Any], variable: str | None) -> Any:
    """The matrix of a file that is named, or its only one."""
    matrices = [
        name for name, one in held.items() if getattr(one, "ndim", 0) == 2 and one.dtype.kind in "iufc"
    ]
    if not matrices:
        raise ValueError(
            f"{file.name} must hold a matrix, got {abbreviate(list(held))}: save the matrix itself, not what "
            "it is part of"
        )
    if variable is None and len(matrices) == 1:
        return held[matrices[0]]
    if variable not in matrices:
        hint = did_you_mean_or_known(variable, matrices)
        raise ValueError(f"variable must name a matrix of {file.name}, got {abbreviate(variable)}{hint}")
    return held[variable]


def _read_npz(file: Path, variable: str | None) -> Any:
    if not is_zipfile(file):  # numpy takes it for a pickle
        raise BadZipFile("it is no archive")
    with np.load(file) as held:
        return sparse.load_npz(file) if "format" in held else _chosen(file, dict(held), variable)


def _read_pch(file: Path, variable: str | None) -> Any:
    """A matrix of Nastran's DMIG entries, by node and direction.

    Source: MSC Nastran Quick Reference Guide, DMIG.
    """
    cards = [fields for name, fields in _cards(file.read_text()) if name.rstrip("*") == "DMIG"]
    try:
        heads = [[*fields, "", ""][:6] for fields in cards if fields[1] == "0"]
        headers = {
            name: (int(form), int(kind), int(polar or 0) > 0) for name, _, form, kind, _, polar in heads
        }
        read: dict[str, list[Any]] = {name: [] for name in headers}
        for name, node, direction, _, *terms in (fields for fields in cards if fields[1] != "0"):
            column = _freedom(node, direction)
            groups = ([*terms[i : i + 4], "", ""][:4] for i in range(0, len(terms), 4) if terms[i])
            read[name] += [(_freedom(*term[:2]), column, *map(_number, term[2:])) for term in groups]
    except (KeyError, ValueError, IndexError) as error:
        raise TypeError(f"of its DMIG entries one is not as in the guide: {error!r}") from None
    names = [head[0] for head in heads]
    if len(headers) < len(names):
        raise ValueError(
            f"matrices of {file.name} must have different names, got {abbreviate(names)}: punch each subcase "
            "to a file of its own"
        )
    every = {name: np.array(entries).reshape(-1, 4) for name, entries in read.items()}
    named = np.unique(np.concatenate([np.zeros(0), *(entries[:, :2].ravel() for entries in every.values())]))
    if variable is None and len(every) == 1:
        (variable,) = every
    if variable not in every:
        hint = did_you_mean_or_known(variable, list(every)) if every else ", as none is there"
        raise ValueError(f"variable must name a matrix of {file.name}, got {abbreviate(variable)}{hint}")
    (form, kind, polar), entries = headers[variable], every[variable]
    if form not in (SQUARE, SYMMETRIC):
        raise ValueError(
            f"{variable} of {file.name} must be square or symmetric, got the form {form}: {CURE}"
        )
    rows, columns = entries[:, 0].astype(int), entries[:, 1].astype(int)
    values = entries[:, 2]
    if kind in COMPLEX_TYPES:
        phase = np.exp(1j * np.radians(entries[:, 3]))
        values = values * phase if polar else values + 1j * entries[:, 3]
    if form == SYMMETRIC:  # one triangle
        aside = rows != columns
        rows, columns = np.append(rows, columns[aside]), np.append(columns, rows[aside])
        values = np.append(values, values[aside])
    return NodalEntries(rows, columns, values, named.astype(int))


def _cards(text: str) -> Iterator[tuple[str, list[str]]]:
    """Names and fields of Nastran's cards, whose lines have fields of 8 or 16 characters, or commas."""
    card: tuple[str, list[str]] | None = None
    for line in text.splitlines():
        if line.startswith("$"):
            continue
        parts = [part.strip() for part in line.split(",")]
        if len(parts) == 1:
            large = line.startswith("*") or line[:SMALL_FIELD].rstrip().endswith("*")
            width = LARGE_FIELD if large else SMALL_FIELD
            ends = range(SMALL_FIELD, 9 * SMALL_FIELD, width)
            parts = [line[:SMALL_FIELD].strip(), *(line[end : end + width].strip() for end in ends)]
        if parts[0][:1] in ("", "*", "+"):
            if card is not None:
                card[1].extend(parts[1:9])
            continue
        if card is not None:
            yield card
        card = parts[0], parts[1:9]
    if card is not None:
        yield card


def _freedom(node: str, direction: str) -> int:
    return DIRECTIONS * int(node) + int(direction or 0)


def _number(field: str) -> float:
    """A number as Nastran writes it, whose exponent may lack its letter; 0 of an empty field."""
    return float(NASTRAN_EXPONENT.sub("e", FORTRAN_EXPONENT.sub("e", field)) or 0.0)


def _read_op4(file: Path, variable: str | None) -> Any:
    try:
        nastran: Any = import_module("pyNastran.op4.op4")
    except ImportError as error:
        raise ImportError(f"{file.name} is read by pyNastran: pip install pyNastran") from error
    try:
        held = nastran.read_op4(str(file), debug=False)
    except Exception as error:  # whatever it raises of a file that is damaged
        raise TypeError(error) from None
    return _chosen(file, {name: one.data for name, one in held.items()}, variable)


def _read_npy(file: Path, _: str | None) -> Any:
    try:
        held = np.load(file, allow_pickle=False)
    except (ValueError, EOFError) as error:  # of what is no array
        raise TypeError(error) from None
    return _chosen(file, {file.stem: held}, None)


def _read_csv(file: Path, _: str | None) -> Any:
    try:
        with warnings.catch_warnings(action="error"):  # numpy warns of a file without numbers
            return np.loadtxt(file, delimiter=",", ndmin=2)
    except (ValueError, UserWarning) as error:
        raise TypeError(error) from None


def _read_harwell_boeing(file: Path, _: str | None) -> Any:
    """A matrix by columns, in fields of fixed width.

    Source: I. S. Duff, R. G. Grimes, J. G. Lewis, "Users' guide for the Harwell-Boeing sparse matrix
    collection (release I)", 1992.
    """
    lines = iter(file.read_text(encoding="ascii").splitlines())
    try:
        next(lines)
        counts, (kind, *sizes) = [int(one) for one in next(lines).split()[1:]], next(lines).upper().split()
        if kind[0] not in "RC" or kind[1] not in "SUZR" or kind[2:] != "A":
            raise TypeError(f"its type is {kind}, where real or complex entries, assembled, are read")
        widths = [int(one) for one in FORTRAN_FORMAT.findall(next(lines))]
        if counts[3:] and counts[3]:  # the header of right-hand sides
            next(lines)
        columns, stored = int(sizes[1]), int(sizes[2])
        numbers = columns + 1, stored, stored * (1 + (kind[0] == "C"))
        starts, rows, entries = (
            np.array(_fields(list(islice(lines, count)), width, number), dtype=float)
            for count, width, number in zip(counts[:3], widths, numbers)
        )
        entries = entries.view(complex) if kind[0] == "C" else entries
        places = rows.astype(int) - 1, starts.astype(int) - 1
        matrix = sparse.csc_array((entries, *places), shape=(int(sizes[0]), columns))
    except (ValueError, IndexError, StopIteration) as error:
        raise TypeError(f"its fields are not as in the guide: {error!r}") from None
    sign = TRIANGLES.get(kind[1])
    if sign is not None and sparse.triu(matrix, 1).nnz:
        raise TypeError(f"its type {kind} stands for a lower triangle, and it has entries above the diagonal")
    return matrix if sign is None else matrix + sign * sparse.tril(matrix, -1).T


def _fields(lines: list[str], width: int, number: int) -> list[str]:
    """Fields, one after the other: between blanks, as scipy writes others than it says, or of fixed width."""
    lines = [FORTRAN_EXPONENT.sub("e", line.rstrip()) for line in lines]
    words = " ".join(lines).split()
    if len(words) == number:
        return words
    return [line[i : i + width] for line in lines for i in range(0, len(line), width)]


_READERS = {
    ".mtx": _read_mtx,
    ".mat": _read_mat,
    ".npz": _read_npz,
    ".txt": _read_coordinates,
    ".op4": _read_op4,
    ".pch": _read_pch,
    ".npy": _read_npy,
    ".csv": _read_csv,
    **dict.fromkeys((".hb", ".rb", ".rsa", ".rua", ".csa", ".cua", ".matrix"), _read_harwell_boeing),
}
