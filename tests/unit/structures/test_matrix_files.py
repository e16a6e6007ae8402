"""Matrices from files: what scipy writes is read as it was, and what cannot be read is said."""

import numpy as np
import pytest
from scipy import io, sparse

import frictionlab as fl

K = sparse.csc_array([[2.0, -1.0, 0.0], [-1.0, 3.0, 0.5], [0.0, 0.5, 1.0]])


def test_each_format_gives_the_matrix(tmp_path):
    io.mmwrite(tmp_path / "full.mtx", K, symmetry="general")
    io.mmwrite(tmp_path / "half.mtx", K, symmetry="symmetric")
    io.savemat(tmp_path / "one.mat", {"K": K})
    io.savemat(tmp_path / "dense.mat", {"K": K.toarray()})
    sparse.save_npz(tmp_path / "K.npz", K)
    entries = K.tocoo()
    rows = [f"{i + 1}, {j + 1}, {x!r}" for i, j, x in zip(entries.row, entries.col, entries.data.tolist())]
    (tmp_path / "abaqus.mtx").write_text("\n".join(rows))
    (tmp_path / "fortran.mtx").write_text("\n".join(rows).replace(".5", ".5D+00").replace("2.0", "2.0d0"))
    for path in tmp_path.iterdir():
        assert (fl.read_matrix(path).toarray() == K.toarray()).all(), path.name


def test_a_variable_is_named_where_there_are_several(tmp_path):
    io.savemat(tmp_path / "two.mat", {"K": K, "M": 2 * K})
    assert fl.read_matrix(tmp_path / "two.mat", "M")[0, 0] == 4.0
    with pytest.raises(
        ValueError, match=r"variable must name a matrix of two\.mat, got None: known are K, M"
    ):
        fl.read_matrix(tmp_path / "two.mat")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1 2\n3 4\n", "three numbers in each row, got 2"),
        ("1 0 5.0", "integers from 1"),
        ("a b c", "rows of"),
    ],
)
def test_text_that_holds_no_entries_is_refused(tmp_path, text, message):
    (tmp_path / "K.txt").write_text(text)
    with pytest.raises(ValueError, match=message):
        fl.read_matrix(tmp_path / "K.txt")


def test_a_file_that_is_not_there_or_of_another_kind(tmp_path):
    with pytest.raises(FileNotFoundError, match="check the path"):
        fl.read_matrix(tmp_path / "none.mat")
    with pytest.raises(ValueError, match=r"path must end in \.mtx or \.mat"):
        fl.read_matrix("K.op4")
    (tmp_path / "K.npz").write_bytes(b"no archive")
    with pytest.raises(ValueError, match="cannot be read"):
        fl.read_matrix(tmp_path / "K.npz")


def test_a_structure_takes_paths(tmp_path):
    sparse.save_npz(tmp_path / "K.npz", K)
    structure = fl.Structure(np.eye(3), tmp_path / "K.npz")
    assert structure.size == 3


@pytest.mark.parametrize("text", ["", "%%MatrixMarket matrix coordinate real general\n2 2 3\n1 1 3\n"])
def test_errors_name_files_that_are_empty_or_end_early(tmp_path, text):
    path = tmp_path / "cut.mtx"
    path.write_text(text)
    with pytest.raises(ValueError, match=r"cut\.mtx must hold a matrix"):
        fl.read_matrix(path)
