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
    np.save(tmp_path / "K.npy", K.toarray())
    np.savetxt(tmp_path / "K.csv", K.toarray(), delimiter=",")
    io.hb_write(tmp_path / "K.hb", K)
    entries = K.tocoo()
    rows = [f"{i + 1}, {j + 1}, {x!r}" for i, j, x in zip(entries.row, entries.col, entries.data.tolist())]
    (tmp_path / "abaqus.mtx").write_text("\n".join(rows))
    (tmp_path / "fortran.mtx").write_text("\n".join(rows).replace(".5", ".5D+00").replace("2.0", "2.0d0"))
    for path in tmp_path.iterdir():
        assert (fl.read_matrix(path).toarray() == K.toarray()).all(), path.name


def harwell_boeing(kind, entries):
    """The lower triangle of K, or other entries at these places, in narrow fields as Ansys writes them."""
    fields = "".join(f"{x:+.4e}".replace("e", "D") + "\n" for x in entries)
    return (
        f"{'K':72}stiff\n{13:14}{1:14}{1:14}{len(entries):14}{1:14}\n{kind:14}{3:14}{3:14}{5:14}{0:14}\n"
        f"{'(4I2)':16}{'(8I1)':16}{'(1P,1D11.4)':20}(1D11.4)\nF{1:27}{0:14}\n 1 3 5 6\n12233\n{fields}"
    )


@pytest.mark.parametrize(
    ("kind", "entries", "exact"),
    [
        ("RSA", [2.0, -1.0, 3.0, 0.5, 1.0], K.toarray()),
        ("rua", [2.0, -1.0, 3.0, 0.5, 1.0], sparse.tril(K).toarray()),
        ("RZA", [0.0, -1.0, 0.0, 0.5, 0.0], [[0.0, 1.0, 0.0], [-1.0, 0.0, -0.5], [0.0, 0.5, 0.0]]),
        ("CSA", [2, 1, -1, 0, 3, 0, 0.5, 0, 1, 0], K.toarray() + np.diag([1j, 0, 0])),
    ],
)
def test_harwell_boeing_files_have_fields_of_fixed_width(tmp_path, kind, entries, exact):
    (tmp_path / "K.matrix").write_text(harwell_boeing(kind, entries))
    assert (fl.read_matrix(tmp_path / "K.matrix").toarray() == exact).all()


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("K.hb", harwell_boeing("PSA", [])),
        ("K.rsa", harwell_boeing("RSA", [2.0, -1.0])),
        ("K.hb", "no matrix"),
        ("K.npy", "no array"),
        ("K.npy", ""),
        ("K.csv", ""),
        ("K.csv", "node,x\n1,2\n"),
        ("K.rsa", harwell_boeing("RSA", [2.0, -1.0, 3.0, 0.5, 1.0]).replace("12233", "12133")),
    ],
)
def test_damaged_files_are_refused(tmp_path, name, text):
    (tmp_path / name).write_text(text)
    with pytest.raises(ValueError, match=f"{name} must hold a matrix, got a file that cannot be read"):
        fl.read_matrix(tmp_path / name)


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
        ("1 2\n3 4\n", "three numbers in each row, or five with nodes, got 2"),
        ("1 0 5.0", "integers from 1"),
        ("a b c", "rows of"),
        ("1 70 1 70 2.0", "directions of nodes"),
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
        fl.read_matrix("K.full")
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


def test_a_mat_file_without_a_matrix_of_numbers(tmp_path):
    io.savemat(tmp_path / "model.mat", {"model": {"K": K.toarray()}})
    with pytest.raises(
        ValueError, match=r"model\.mat must hold a matrix, got \['model'\]: save the matrix itself"
    ):
        fl.read_matrix(tmp_path / "model.mat")
    (tmp_path / "new.mat").write_bytes(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM" + bytes(400))
    with pytest.raises(ValueError, match=r"got one of version 7\.3: save it with '-v7'"):
        fl.read_matrix(tmp_path / "new.mat")


def nodal_text(matrix, freedoms):
    """A matrix in the MATRIX INPUT format of Abaqus."""
    places = zip(*(part.tolist() for part in matrix.nonzero()), strict=True)
    lines = ["** Abaqus"]
    for i, j in places:
        (a, b), (c, d) = freedoms[i], freedoms[j]
        lines.append(f"{a},{b}, {c},{d}, {float(matrix[i, j])!r}")
    return "\n".join(lines)


def test_matrices_by_nodes_have_the_freedoms_of_all_files(tmp_path):
    freedoms = [(-1, 0), (4, 1), (4, 2), (17, 1)]  # an internal node, then two others
    stiffness = (
        np.diag([3.0, 5.0, 7.0, 9.0]) + np.diag([-1.0, -2.0, -0.5], k=1) + np.diag([-1.0, -2.0, -0.5], k=-1)
    )
    friction = np.zeros((4, 4))
    friction[1, 2], friction[3, 2] = 0.4, -0.4
    (tmp_path / "STIF.mtx").write_text(nodal_text(np.tril(stiffness), freedoms))
    (tmp_path / "both.mtx").write_text(nodal_text(stiffness, freedoms))
    (tmp_path / "MASS.mtx").write_text(nodal_text(np.diag([0.0, 1.0, 1.0, 2.0]), freedoms))
    (tmp_path / "FRIC.mtx").write_text(nodal_text(friction, freedoms))
    assert (fl.read_freedoms(tmp_path / "STIF.mtx") == freedoms).all()
    for name in ("STIF.mtx", "both.mtx"):
        assert (fl.read_matrix(tmp_path / name).toarray() == stiffness).all()
    structure = fl.Structure(
        tmp_path / "MASS.mtx", tmp_path / "STIF.mtx", circulatory=[(1.0, tmp_path / "FRIC.mtx")]
    )
    given = fl.Structure(np.diag([0.0, 1.0, 1.0, 2.0]), stiffness, circulatory=friction)
    assert structure.massless == (0,)
    assert (fl.eigenvalues(structure).values == fl.eigenvalues(given).values).all()
    sparse.save_npz(tmp_path / "K.npz", K)
    with pytest.raises(ValueError, match=r"K\.npz must name nodes to have freedoms"):
        fl.read_freedoms(tmp_path / "K.npz")


def test_matrices_of_nastran(tmp_path):
    nastran = pytest.importorskip("pyNastran.op4.op4", reason="pyNastran is not installed")
    nastran.OP4(debug=False).write_op4(str(tmp_path / "K.op4"), {"KAA": (6, K.toarray())}, is_binary=False)
    assert (fl.read_matrix(tmp_path / "K.op4").toarray() == K.toarray()).all()


PUNCH = """\
$TITLE   = two nodes, one of which is a scalar point
DMIG    KAAX           0       6       2       0
DMIG*   KAAX                           7               1
*                      7               1 2.000000000D+01
*                      9               0-1.000000000D+01
DMIG*   KAAX                           9               0
*                      9               0 3.0+1
DMIG,MAAX,0,6,2,0
DMIG,MAAX,7,1,,7,1,1.5
DMIG    FAAX           0       1       3       0
DMIG    FAAX           7       1               9       0      .5     .25
"""


def test_punched_matrices_of_nastran(tmp_path):
    """The guide's three forms of a field; K is a triangle, M lacks the scalar point, F is complex."""
    path = tmp_path / "brake.pch"
    path.write_text(PUNCH)
    stiffness = fl.read_matrix(path, "KAAX")
    assert stiffness.toarray().tolist() == [[20.0, -10.0], [-10.0, 30.0]]
    assert fl.read_matrix(path, "MAAX").toarray().tolist() == [[1.5, 0.0], [0.0, 0.0]]
    assert fl.read_matrix(path, "FAAX").toarray().tolist() == [[0.0, 0.0], [0.5 + 0.25j, 0.0]]
    assert fl.read_freedoms(path, "MAAX").tolist() == [[7, 1], [9, 0]]
    with pytest.raises(ValueError, match=r"variable must name a matrix of brake\.pch, got None.*KAAX"):
        fl.read_matrix(path)
    path.write_text(PUNCH.replace("\n*  ", "\n*K1"))  # continuations have labels
    assert (fl.read_matrix(path, "KAAX") != stiffness).nnz == 0
    path.write_text(PUNCH.replace("1       3       0", "1       3       0       1").replace(".25", "90."))
    polar = fl.read_matrix(path, "FAAX").toarray()  # amplitude and phase
    np.testing.assert_allclose(polar, [[0.0, 0.0], [0.5j, 0.0]], atol=1e-16)
    path.write_text(PUNCH + PUNCH)  # of two subcases
    with pytest.raises(ValueError, match=r"brake\.pch must have different names, got .*: punch each subcase"):
        fl.read_matrix(path, "KAAX")
    path.write_text(PUNCH.replace("9               0-1", "9               x-1"))
    with pytest.raises(ValueError, match=r"brake\.pch must hold a matrix.*DMIG"):
        fl.read_matrix(path, "KAAX")
