"""A structure holds its matrices as they are, and refuses those that are not what they must be."""

import copy
import json
import pickle

import numpy as np
import pytest
import sympy as sp
from scipy import linalg, sparse

import frictionlab as fl
from tests.helpers.finite_elements import beam

UNIT = np.eye(2)
STIFF = np.array([[2.0, -1.0], [-1.0, 2.0]])
SKEW = np.array([[0.0, 1.0], [-1.0, 0.0]])


def test_coefficients_are_texts_numbers_or_functions():
    terms = [(1, STIFF), ("r**2 - 1", UNIT), (lambda r, mu: mu / r, UNIT)]
    structure = fl.Structure(UNIT, terms, parameters={"r": 2.0, "mu": 0.5})
    assert np.allclose(structure.pencil.K.toarray(), STIFF + (3.0 + 0.25) * UNIT, rtol=1e-15)
    assert np.allclose(structure.pencil_derivative("r").K.toarray(), (4.0 - 0.125) * UNIT, rtol=1e-15)
    assert not structure.pencil_derivative("r").M.count_nonzero()


D, G, R = (one + one.T for one in np.random.default_rng(0).standard_normal((3, 4, 4)))
FORMATS = [
    f"{name}_{kind}"
    for name in ("bsr", "coo", "csc", "csr", "dia", "dok", "lil")
    for kind in ("array", "matrix")
]


@pytest.mark.parametrize("form", [np.array, *(getattr(sparse, name) for name in FORMATS)])
@pytest.mark.parametrize(
    "function",
    [
        lambda r, D, G, R: D + r * G + (1 / r - 1) * R,
        lambda r, D, G, R: (-G * r - D / r) + 0.1 * (R - (r * G).T) * np.float64(3.0),
        lambda r, D, G, R: sum([np.sin(r) * G, D, 2**r * R]) / (1 + np.sqrt(r)),
        lambda r, D, G, R: fl.functions.arctan(r / 3.0) * (D @ (r * D)) + np.pi * r**-0.5 * R,
    ],
)
def test_a_function_gives_a_matrix(function, form):
    """As numpy computes it from dense matrices."""
    given = [form(one) for one in (D, G, R)]
    structure = fl.Structure(np.eye(4), lambda r: function(r, *given), parameters={"r": 1.0})
    for r in np.random.default_rng(1).uniform(0.2, 3.0, 3):
        there = copy.deepcopy(pickle.loads(pickle.dumps(structure))).replace(r=r)
        assert np.allclose(there.pencil.K.toarray(), function(r, D, G, R), rtol=1e-13, atol=1e-13)


@pytest.mark.parametrize("form", [np.array, sparse.csr_array])
@pytest.mark.parametrize("kind", [bool, np.int8, np.uint8, np.int32, np.int64])
def test_integers_of_a_function_do_not_wrap_round(kind, form):
    largest = 1 if kind is bool else np.iinfo(kind).max
    A = form(np.full((2, 2), largest, kind))
    structure = fl.Structure(UNIT, lambda r: r * A + r * A + A @ (r * A), parameters={"r": 1.0})
    expected = 2.0 * largest + 2.0 * float(largest) ** 2
    assert np.allclose(structure.K.at({"r": 1.0}).toarray(), expected, rtol=1e-15)


@pytest.mark.parametrize(
    "function",
    [
        lambda a, b: [[2 * a * (1 + a), -a * (1 + a)], [-a - a**2, 3 + b]],
        lambda a, b: [[3 * (a + b) ** 2, -((a + b) ** 2)], [-(a * a + 2 * a * b + b * b), 3]],
        lambda a, b: STIFF + b * UNIT + a * (1 + a) * SKEW - (a + a**2) * SKEW,
        lambda a, b: (1 / a - 1) * np.triu(STIFF) + np.tril(STIFF, -1) / a - b * np.tril(STIFF, -1) / b,
        lambda a, b: sum(np.sin(i * a) / (i + 1 / 3) for i in range(90)) * STIFF + b * UNIT,  # is long
    ],
)
def test_coefficients_that_are_equal_may_be_written_differently(function):
    values = {"a": 0.7, "b": 1.3}
    own = {name: values[name] for name in ("a", "b")}
    structure = fl.Structure(UNIT, [(1, STIFF), ("b", UNIT)], C=function, parameters=own)
    again = fl.Structure.from_dict(json.loads(json.dumps(structure.to_dict())))
    for each in (structure, again):
        assert np.allclose(each.pencil.C.toarray(), np.array(function(**values)), rtol=1e-13)


def test_functions_are_lists_of_terms():
    """In every place that takes such a list, and in files."""
    N = np.array([[0.0, 1.0], [-1.0, 0.0]])
    values = {"r": 1.7, "mu": 0.3, "k": 2.0, "F": 2.0}
    made = fl.Structure(
        lambda r: (1 + r) * UNIT,
        lambda k, mu: [[2 * k * (1 + 0.1j * mu), -k], [-k, 2 * k + np.sqrt(mu)]],
        C=lambda r, stiff=STIFF: 0.01 * r * stiff,  # an argument with a value is no parameter
        gyroscopic=lambda r: r * np.triu(N) - r * np.triu(N).T,  # skew, though no term by itself is
        circulatory=lambda mu: mu * N,
        load=lambda F: F * np.array([1.0, 0.0]),
        parameters=values,
    )
    hysteretic, held = np.diag([0.2j, 0.0]), np.diag([0.0, 1.0])
    listed = fl.Structure(
        [("1 + r", UNIT)],
        [("k", STIFF), ("k*mu", hysteretic), ("sqrt(mu)", held)],
        C=[("0.01*r", STIFF)],
        gyroscopic=[("r", N)],
        circulatory=[("mu", N)],
        load=[("F", [1.0, 0.0])],
        parameters=values,
    )
    again = fl.Structure.from_dict(json.loads(json.dumps(made.to_dict())))
    expected = fl.eigenvalues(listed)
    for found in map(fl.eigenvalues, (made, again)):
        assert np.allclose(found.values, expected.values, rtol=1e-14)
        for name in ("r", "mu", "k"):
            assert np.allclose(
                found.sensitivities(name), expected.sensitivities(name), rtol=1e-12, atol=1e-14
            )
    assert np.allclose(made.load_vector, listed.load_vector)


def entry_by_index(k):
    K = STIFF.copy()
    K[0, 0] = k
    return K


@pytest.mark.parametrize(
    "function",
    [
        entry_by_index,
        lambda k: (k * STIFF) @ (k * UNIT),
        lambda k: (k * STIFF) * UNIT,
        lambda k: STIFF if k > 1 else UNIT,
        lambda k: STIFF if k == 1 else UNIT,
        lambda k: STIFF if k else UNIT,
        lambda k: np.add(STIFF, k * UNIT, out=STIFF.copy()),
        lambda k: STIFF + k,
        lambda k: k * STIFF + np.eye(3),
        lambda k: np.block([[k * UNIT]]),
        lambda k: abs(k) * STIFF,
        lambda k: 2 * k,
        lambda k: None,
    ],
)
def test_a_function_that_is_no_sum_is_refused(function):
    with pytest.raises(ValueError, match=r"K must be a sum of .* or give the list K=\[\(1, D\)"):
        fl.Structure(UNIT, function, parameters={"k": 1.0})
    with pytest.raises(ValueError, match=r"K takes 'k', which is no parameter: give parameters="):
        fl.Structure(UNIT, function)


def test_new_values_leave_the_matrices_alone():
    structure = fl.Structure(UNIT, [("k", STIFF)], parameters={"k": 2.0}, window=(0, 5))
    other = structure.replace(k=3.0, window=(0, 2))
    assert other.K.matrices[0] is structure.K.matrices[0]
    assert (other.pencil.K.toarray() == 3.0 * STIFF).all()
    assert (dict(other.parameters), other.window) == ({"k": 3.0}, (0, 2))
    with pytest.raises(TypeError, match="Structure has no parameter 'kk'"):
        structure.replace(kk=1.0)


def test_rayleigh_damping_follows_the_matrices_and_its_parameters():
    structure = fl.Structure(UNIT, [("k", STIFF)], fl.RayleighDamping(0.1, 0.01), parameters={"k": 4.0})
    assert np.allclose(structure.pencil.C.toarray(), 0.1 * UNIT + 0.04 * STIFF)
    assert np.allclose(structure.replace(beta=1.0).pencil.C.toarray(), 0.1 * UNIT + 4.0 * STIFF)


def test_it_can_be_pickled():
    structure = fl.Structure(UNIT, [("k", STIFF)], parameters={"k": 2.0})
    assert fl.eigenvalues(structure).stable is False
    again = pickle.loads(pickle.dumps(structure))
    assert (fl.eigenvalues(again).values == fl.eigenvalues(structure).values).all()
    assert again.replace(k=1.0).parameters == {"k": 1.0}


def test_what_a_notebook_shows():
    structure = fl.Structure(UNIT, [(1, STIFF), ("r", UNIT)], parameters={"r": 2.0})
    assert repr(structure) == "Structure(2 freedoms, r=2)"
    assert "4 entries + (r) × 2 entries" in structure._repr_html_()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"K": np.ones((2, 3))}, r"K must be square, got the shape \(2, 3\)"),
        ({"K": np.eye(3)}, "K must have the size of M, 2, got 3"),
        ({"K": [[1.0, np.nan], [0.0, 1.0]]}, "K must hold finite numbers, got nan at row 0, column 1"),
        ({"K": [[1.0, 0.5], [-0.5, 1.0]]}, "K must be symmetric, got .* as circulatory"),
        ({"K": [[1.0, 0.0], [-0.5, 1.0]]}, "one triangle of a matrix"),
        ({"K": "K.op2"}, "path must end in"),
        ({"K": "stiff"}, "path must end in"),
        ({"K": 5}, "K must have the size of M, 2, got 1"),
        ({"K": [("q", STIFF)]}, "names 'q', which is no parameter: give parameters"),
        ({"K": [("q", STIFF)], "parameters": {"k": 1.0}}, "no parameter: known are k"),
        ({"K": [("k", STIFF)], "parameters": {"k": "big"}}, "k must be a finite number"),
        ({"K": [("k +", STIFF)], "parameters": {"k": 1.0}}, "must be an expression"),
        ({"K": [(lambda k: float(k), STIFF)], "parameters": {"k": 1.0}}, "must be a formula"),
        (
            {"K": lambda k: UNIT + k * np.array([[0, 1], [2, 0]]), "parameters": {"k": 1.0}},
            "of 'k' in K must",
        ),
        ({"K": lambda k: np.exp(1j * k) * UNIT, "parameters": {"k": 1.0}}, "no finite real number"),
        ({"K": lambda k: np.sqrt(k**2) * UNIT, "parameters": {"k": 1.0}}, r"Abs\(k\) is neither arithmetic"),
        ({"K": lambda k: abs(k) * UNIT, "parameters": {"k": 1.0}}, r"absolute\(k\) is neither arithmetic"),
        ({"load": lambda k: UNIT[0] + k * np.ones(3), "parameters": {"k": 1.0}}, "load must be a sum"),
        (
            {"load": lambda k: np.ones(3) + k * np.ones(3), "parameters": {"k": 1.0}},
            "^load must have one force",
        ),
        ({"K": [(1, STIFF), (2, np.eye(3))]}, "all terms of K must have the same shape"),
        ({"K": [(1, STIFF), ([1], UNIT)]}, "must be a number, a text or a function"),
        ({"parameters": {"r": 1.0}}, "parameters must be named by a coefficient, got 'r'"),
        ({"parameters": [1.0]}, "parameters must be a mapping"),
        (
            {"K": [("alpha", STIFF)], "C": fl.RayleighDamping(), "parameters": {"alpha": 0.0}},
            "a coefficient of K must not name 'alpha', which is RayleighDamping's own",
        ),
        ({"parameters": {"M": 1.0}}, "no field of Structure, got 'M'"),
        ({"M": [[1.0, 2.0], [2.0, 1.0]]}, "negative kinetic energy"),
        ({"M": [[1.0, 0.0], [0.0, -1.0]]}, "M must be positive, got -1 on the diagonal at 1"),
        ({"M": np.zeros((2, 2))}, "M must give a freedom a mass"),
        ({"M": 1j * UNIT}, "M must be real"),
        ({"C": [[0.0, 1.0], [-1.0, 0.0]]}, "C must be symmetric, .* as gyroscopic"),
        ({"gyroscopic": UNIT}, "gyroscopic must be skew"),
        ({"load": [1.0]}, "load must have one force for each of 2 freedoms, got 1"),
        ({"window": (5, 1)}, "window must be two numbers in ascending order"),
        ({"window": (-1, 1)}, "the lower end of window must be"),
    ],
)
def test_what_is_refused(changes, message):
    with pytest.raises(ValueError, match=message):
        fl.Structure(**{"M": UNIT, "K": STIFF, **changes})


def test_a_large_structure_needs_a_window():
    M, K = beam(205)
    with pytest.raises(ValueError, match="window must be given for more than 400 freedoms, got None for 410"):
        fl.Structure(M, K)
    indefinite = M - sparse.diags_array(0.9 * M.diagonal())
    with pytest.raises(ValueError, match="negative kinetic energy"):
        fl.Structure(indefinite, K, window=(0, 1))


def test_an_unknown_keyword_is_explained():
    with pytest.raises(TypeError, match="did you mean 'gyroscopic'"):
        fl.Structure(UNIT, STIFF, **{"gyroscopics": UNIT})


def test_rayleigh_damping_and_its_parameters_are_one():
    structure = fl.Structure(UNIT, STIFF, fl.RayleighDamping(0.1, 0.2))
    other = structure.replace(C=fl.RayleighDamping(0.3, 0.4))
    assert dict(other.parameters) == {"alpha": 0.3, "beta": 0.4}
    assert np.allclose(other.pencil.C.toarray(), 0.3 * UNIT + 0.4 * STIFF, rtol=1e-15)
    assert fl.RayleighDamping(0.5, 0.2) == structure.replace(alpha=0.5).C
    assert not structure.replace(C=None).parameters
    with pytest.raises(ValueError, match="alpha must be at least 0"):
        structure.replace(alpha=-1.0)
    with pytest.raises(ValueError, match="must not contradict RayleighDamping"):
        fl.Structure(UNIT, STIFF, fl.RayleighDamping(0.1, 0.2), parameters={"alpha": 5.0})


TEXTS = np.array([["1.0", "0"], ["0", "1.0"]], dtype=object)  # as of a table read without its types
IMAGINARY = np.array([[np.complex128(1 + 1j), 0], [0, 1]], dtype=object)


@pytest.mark.parametrize("wrong", [None, fl.RayleighDamping(0.1, 0.2), TEXTS, IMAGINARY])
def test_mass_and_stiffness_are_matrices(wrong):
    with pytest.raises(ValueError, match="K must be a matrix of numbers"):
        fl.Structure(UNIT, wrong)
    with pytest.raises(ValueError, match="M must be a matrix of numbers"):
        fl.Structure(wrong, UNIT)


@pytest.mark.parametrize("of", [lambda a: a.astype(object), sp.Matrix], ids=["spreadsheet", "sympy"])
def test_numbers_of_python_and_sympy_are_numbers(of):
    given = np.array([[2.0, -1.0], [-1.0, 2.0]])  # frequencies 1 and sqrt(3) rad/s
    found = fl.eigenvalues(fl.Structure(of(np.eye(2)), of(given), window=(0, 1)))
    np.testing.assert_allclose(np.sort(found.frequencies)[::2], np.sqrt([1, 3]) / (2 * np.pi), rtol=1e-14)


def test_a_coefficient_must_be_finite():
    structure = fl.Structure([[1.0]], [("1/r", [[1.0]])], parameters={"r": 1.0})
    for ask in (
        lambda: fl.eigenvalues(structure.replace(r=0.0)),
        lambda: fl.root_locus(structure, "r", [0, 1]),
    ):
        with pytest.raises(ValueError, match="the coefficient 1/r must be finite"):
            ask()


def test_cures_for_what_is_not_skew():
    with pytest.raises(ValueError, match=r"so give A - A\.T"):
        fl.Structure(UNIT, STIFF, gyroscopic=[[0.0, 1.0], [0.0, 0.0]])
    with pytest.raises(ValueError, match="give its symmetric part"):
        fl.Structure(UNIT, STIFF, gyroscopic=UNIT)


def test_modal_damping_of_equal_ratios_is_a_root_of_the_stiffness():
    """C = 2 zeta M (M^-1 K)^(1/2), by which no modes are computed."""
    rng = np.random.default_rng(3)
    M, K = (a @ a.T + np.eye(5) for a in rng.standard_normal((2, 5, 5)))
    expected = 2 * 0.02 * M @ linalg.sqrtm(np.linalg.solve(M, K))
    assert np.allclose(fl.modal_damping(M, K, 0.02), expected, rtol=0, atol=1e-12 * np.abs(expected).max())
    damped = fl.Structure(M, K, [("zeta", fl.modal_damping(M, K))], parameters={"zeta": 0.02})
    assert np.allclose(fl.eigenvalues(damped).damping_ratios, 0.02, rtol=1e-9)
    free = fl.modal_damping(np.eye(2), [[1.0, -1.0], [-1.0, 1.0]], 0.1)  # its translation is undamped
    assert np.allclose(free, 0.1 * np.sqrt(2) * np.array([[1.0, -1.0], [-1.0, 1.0]]), rtol=1e-12)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ((np.eye(2), np.eye(3), 0.1), "M and K must have the same size, got 2 and 3"),
        ((np.eye(2), np.eye(2), [0.1, 0.1, 0.1]), "of at most 2 modes"),
        ((np.eye(2), np.eye(2), -0.1), "ratios must be at least 0"),
        ((np.diag([1.0, 0.0]), np.eye(2), 0.1), "M must give each motion a mass"),
        ((np.eye(2), -np.eye(2), 0.1), "K must not be negative"),
        ((np.eye(2), [[1.0, 0.3], [0.1, 1.0]], 0.1), "K must be symmetric"),
        ((np.eye(2), (1 + 0.1j) * np.eye(2), 0.1), "K must be real"),
        ((sparse.eye_array(1001), sparse.eye_array(1001), 0.1), "at most 1000 freedoms"),
    ],
)
def test_modal_damping_refuses(given, message):
    with pytest.raises(ValueError, match=message):
        fl.modal_damping(*given)


def test_data_of_a_structure_with_hysteretic_damping_have_its_matrices():
    K = (1.0 + 0.05j) * np.array([[2.0, -1.0], [-1.0, 2.0]])
    structure = fl.Structure(np.eye(2), K)
    again = fl.Structure.from_dict(json.loads(json.dumps(structure.to_dict())))
    np.testing.assert_array_equal(again.K.at({}).toarray(), K)
