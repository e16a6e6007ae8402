"""Structures of finite elements: masses coupled by numbers, on which a contact sticks and slips."""

import numpy as np
import pytest
import scipy.linalg
import sympy

import frictionlab as fl
from chain_and_rod import rod, rod_matrices
from frictionlab.models import Friction, Mechanics, quadratic_form
from frictionlab.models.mechanical.coupled_masses import inverse_of
from frictionlab.models.symbols import gradient
from tests.helpers.cases import slow_but

STATE = np.random.default_rng(3).normal(size=12) * 1e-6


def matrices(model):
    """Mass, damping and stiffness of a rod."""
    mass, stiffness = rod_matrices(model.elements, model.length / model.elements)
    stiffness *= model.E * model.area
    return model.rho * model.area * mass, model.c * stiffness, stiffness


def rates_in(model, name, state):
    """Rates and outputs of a mode by its expressions."""
    automaton = model.automaton()
    mode = next(mode for mode in automaton.modes if mode.name == name)
    at = dict(zip(automaton.states, state, strict=True)) | dict(automaton.parameters)
    numbers = [sympy.sympify(expr).subs(at) for expr in (*mode.flow, mode.outputs["friction_force"])]
    return np.array(numbers, dtype=float)


@pytest.mark.parametrize("name", slow_but(["slip-", "stick"], ["slip+", "slip-", "stick"]))
def test_the_accelerations_are_those_of_the_matrices(name):
    model = rod(12)
    n = model.elements
    mass, damping, stiffness = matrices(model)
    free, end = -stiffness @ STATE[:n] - damping @ STATE[n:], np.eye(n)[-1]
    if name == "stick":  # the last node keeps its speed
        bordered = np.block([[mass, -end[:, None]], [end[None], np.zeros((1, 1))]])
        *accelerations, friction = np.linalg.solve(bordered, [*free, 0.0])
    else:
        friction = (1 if name == "slip+" else -1) * model.friction.mu_k * model.N
        accelerations = np.linalg.solve(mass, free + friction * end)
    found = rates_in(model, name, STATE)
    np.testing.assert_allclose(found, [*STATE[n:], *accelerations, friction], rtol=1e-9, atol=1e-9)


def test_what_sticks_keeps_its_speed_to_the_last_bit():
    mode = next(mode for mode in rod(12).automaton().modes if mode.name == "stick")
    assert mode.flow[-1] == 0
    run = fl.simulate(rod(12), 0.002, x0=np.zeros(12), progress=False)
    slip = run.relative_velocity[run.mode == "stick"]
    assert len(run.events) >= 2
    assert slip.size
    assert not slip.any()


class Pair(fl.MechanicalModel):
    """Two masses with an inertia between them, of which one rubs."""

    heavy, between, light = 2.0, 0.5, 1.0
    coordinates = ("x", "y")

    def mechanics(self, q, v):
        """The inertia between them makes the mass matrix none of two masses."""
        rubs = Friction(0.1 - v.y, 1.0, fl.Coulomb(mu_k=0.3, mu_s=0.5))
        inertia = self.heavy * v.x**2 + self.between * v.x * v.y + self.light * v.y**2
        return Mechanics(inertia, (q.x - q.y) ** 2 + 3 * q.x**2, contacts=(rubs,))


@fl.model
class PairInSymbols(Pair):
    """The same with parameters, of which the mass matrix is no single one times numbers."""

    heavy: float = fl.parameter(2.0, unit="kg", symbol="a", meaning="of x", range=(1.0, 3.0))
    between: float = fl.parameter(0.5, unit="kg", symbol="b", meaning="between", range=(0.0, 1.0))
    light: float = fl.parameter(1.0, unit="kg", symbol="c", meaning="of y", range=(1.0, 3.0))


def test_masses_coupled_by_numbers_give_what_sympy_gives():
    both = Pair(), PairInSymbols()
    assert both[0].system().coupled is not None
    assert both[1].system().coupled is None
    for name in ("slip+", "stick"):
        found = [rates_in(model, name, STATE[:4] * 1e6) for model in both]
        np.testing.assert_allclose(*found, rtol=1e-13, atol=1e-14)
    runs = [fl.simulate(model, 20.0, x0=np.zeros(4), progress=False) for model in both]
    assert len(runs[0].events) == len(runs[1].events) > 4
    np.testing.assert_allclose(runs[0].final_state, runs[1].final_state, rtol=1e-9, atol=1e-11)


def test_a_motion_without_kinetic_energy_is_refused():
    class Massless(fl.MechanicalModel):
        coordinates = ("x", "y")

        def mechanics(self, q, v):
            return Mechanics((v.x + v.y) ** 2 / 2, q.x**2 + q.y**2)

    with pytest.raises(ValueError, match="give each coordinate a mass"):
        Massless().automaton()


def test_the_inverse_is_that_of_linear_algebra():
    matrix = rod_matrices(20, 0.1)[0] * np.geomspace(1, 1e6, 20)[:, None] * np.geomspace(1, 1e6, 20)
    np.testing.assert_allclose(inverse_of(matrix) @ matrix, np.eye(20), atol=1e-8)


def test_the_gradient_is_that_of_sympy():
    x, y, z, k = sympy.symbols("x y z k", real=True)
    expr = k * (x - y) ** 2 / 2 + 3 * (k + 2) * x * y + sympy.cos(x * z) * y + 0.5 * k * (x + 2 * y + 4 * z)
    assert gradient(expr, (x, y, z)) == [sympy.diff(expr, one) for one in (x, y, z)]


def test_a_quadratic_form_takes_sparse_matrices_and_names_what_does_not_fit():
    from scipy.sparse import csr_array

    x = sympy.symbols("x y")
    matrix = np.array([[2.0, -1.0], [-1.0, 0.0]])
    assert (
        quadratic_form(matrix, x)
        == quadratic_form(csr_array(matrix), x)
        == 2.0 * x[0] ** 2 - 2.0 * x[0] * x[1]
    )
    with pytest.raises(ValueError, match="one row and one column for each of the 2"):
        quadratic_form(np.eye(3), x)
    for wrong in (("x", "y"), ([1.0, 2.0], x[1])):
        with pytest.raises(TypeError, match=r"x must hold expressions such as q.x, got .*order of the rows"):
            quadratic_form(matrix, wrong)


MATRIX = np.array([[2.0, -1.0], [-1.0, 3.0]])
REFUSED = {
    "asymmetric": (
        [[2.0, -1.0], [1.0, 3.0]],
        r"symmetric, got -1 in row 0, column 1 and 1 in row 1.* as loads",
    ),
    "a triangle": (np.triu(MATRIX), "one triangle of a symmetric one: give A"),
    "asymmetric beside large entries": ([[1.0, 1.0], [2.0, 1e8]], "must be symmetric"),
    "complex": (MATRIX * (1 + 0.02j), "finite real numbers"),
    "not a number": ([[np.nan, 0.0], [0.0, 1.0]], "finite real numbers"),
    "masked": (np.ma.masked_less(MATRIX, 0), "finite real numbers"),
    "text": ([["a", "b"], ["c", "d"]], "finite real numbers"),
    "numbers as texts": ([["2", "0"], ["0", "3"]], "finite real numbers"),
    "complex objects": (np.array([[2.0, 0], [0, np.complex128(3j)]], object), "finite real numbers"),
    "one number": (2.0, "one row and one column for each of the 2 entries of x, got a single number"),
}


@pytest.mark.parametrize(("matrix", "message"), REFUSED.values(), ids=REFUSED)
def test_a_matrix_whose_energy_is_not_meant_is_refused(matrix, message):
    with pytest.raises(ValueError, match=message):
        quadratic_form(matrix, sympy.symbols("x y"))


@pytest.mark.filterwarnings("ignore:the matrix subclass")
def test_matrices_of_other_kinds_are_read_as_meant():
    pandas = pytest.importorskip("pandas", reason="one of the matrices is its DataFrame; it is not installed")
    x = sympy.symbols("x y")
    expected = 2 * x[0] ** 2 - 2 * x[0] * x[1] + 3 * x[1] ** 2
    turned = pandas.DataFrame(MATRIX[::-1, ::-1], ["y", "x"], ["y", "x"])
    rounded = MATRIX + np.array([[0, 1e-15], [0, 0]])
    for one in (np.asmatrix(MATRIX), pandas.DataFrame(MATRIX), turned, MATRIX.astype(int).tolist()):
        assert sympy.simplify(quadratic_form(one, x) - expected) == 0
    assert quadratic_form(rounded, x).subs({x[0]: 1.0, x[1]: 1.0}) == pytest.approx(3.0, rel=1e-15)
    with pytest.raises(ValueError, match="same labels for rows and columns"):
        quadratic_form(pandas.DataFrame(MATRIX, ["a", "b"], ["b", "a"]), x)


def test_the_skew_part_of_a_brake_as_loads_flutters():
    """M x'' + C x' + K x = 0 with circulatory and gyroscopic parts, against scipy's eigenvalues."""
    random = np.random.default_rng(3)
    mass, damping, stiffness, skew, turning = random.normal(size=(5, 3, 3))
    mass, stiffness = mass @ mass.T + np.eye(3), 100 * (stiffness @ stiffness.T + np.eye(3))
    damping, skew, turning = 0.01 * damping @ damping.T, 1000 * (skew - skew.T), 0.5 * (turning - turning.T)
    whole, rates = stiffness + skew, damping + turning

    @fl.model
    class Brake(fl.MechanicalModel):
        """Matrices with skew parts."""

        scale: float = fl.parameter(1.0, symbol="s", meaning="of the skew parts", range=(0.0, 2.0))
        coordinates = ("a", "b", "c")
        period = 0.5

        def mechanics(self, q, v):
            follow = -(whole - whole.T) / 2 @ q - (rates - rates.T) / 2 @ v
            return Mechanics(
                quadratic_form(mass, v) / 2,
                quadratic_form((whole + whole.T) / 2, q) / 2,
                quadratic_form((rates + rates.T) / 2, v) / 2,
                loads={
                    name: self.scale * force for name, force in zip(self.coordinates, follow, strict=True)
                },
            )

    one, none = np.eye(3), np.zeros((3, 3))
    values = scipy.linalg.eigvals(
        np.block([[none, one], [-whole, -rates]]), scipy.linalg.block_diag(one, mass)
    )
    found = fl.eigenvalues(Brake())
    assert values.real.max() > 1.0
    assert found.growth_rates.max() == pytest.approx(values.real.max(), rel=1e-10)
    np.testing.assert_allclose(
        np.sort(found.frequencies), np.sort(np.abs(values.imag)) / (2 * np.pi), rtol=1e-10
    )
    assert fl.eigenvalues(Brake(scale=0.0)).stable


def test_a_parameter_changes_a_rod_without_a_new_derivation():
    model = rod(12)
    stiffer = model.replace(E=4 * model.E, c=0.0)
    assert stiffer.automaton().modes is model.automaton().modes
    found = [fl.eigenvalues(one).frequencies for one in (model.replace(c=0.0), stiffer)]
    np.testing.assert_allclose(found[1], 2 * found[0], rtol=1e-9)


def test_a_quadratic_form_of_an_integer_beyond_floats_is_refused():
    with pytest.raises(ValueError, match="x must hold numbers within floats, got 1000"):
        fl.quadratic_form(np.eye(2), [10**400, 1])
    assert float(fl.quadratic_form(np.eye(2), [1e200, 0.0])) == np.inf
