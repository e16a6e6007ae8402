"""`fl.BeamOnBelt` and `fl.DiscBrake` against the closed forms of beams and plates."""

import pickle

import numpy as np
import pytest
from scipy import linalg, optimize, special

import frictionlab as fl


def free_frequencies(M, K):
    """Angular frequencies (n,), 1/s, ascending."""
    return np.sqrt(linalg.eigh(K, M, eigvals_only=True))


def order_of_convergence(errors):
    """From errors with some elements and with twice as many."""
    return np.log2(errors[0] / errors[1])


def test_a_beam_vibrates_as_the_clamped_one():
    """Roots of cos b cosh b = -1, with the fourth power of an element; a bar's with the second."""
    length, bending, axial, mass = 0.5, 20.0, 3e7, 0.8
    roots = np.array(
        [optimize.brentq(lambda b: np.cos(b) * np.cosh(b) + 1, *ends) for ends in ((1, 3), (4, 6))]
    )
    exact = (roots / length) ** 2 * np.sqrt(bending / mass)
    bar = np.pi / 2 / length * np.sqrt(axial / mass)
    errors = []
    for elements in (4, 8):
        beam = fl.BeamOnBelt(
            elements, length=length, bending=bending, axial=axial, mass=mass
        ).structural_pencil
        found = free_frequencies(beam.M.toarray(), beam.K.toarray())
        errors.append([*(found[:2] / exact - 1), np.abs(found / bar - 1).min()])
    assert (np.abs(errors[1]) < [1e-5, 1e-4, 2e-3]).all()
    assert order_of_convergence(np.array(errors)) == pytest.approx([4, 4, 2], abs=0.2)


def plate_frequency(inner, n, poisson, guess):
    """lambda^2 of an annular plate of outer radius 1, clamped inside and free outside, next to a guess.

    W = a J_n + b Y_n + c I_n + d K_n of lambda r, W = W' = 0 inside, and outside no moment, which is
    W'' + nu (W' - n^2 W), and no shear force, (lap W)' + (1 - nu) n^2 (W - W') (Leissa 1969).
    """

    def determinant(square):
        k = np.sqrt(square)
        columns = []
        for function, sign in ((special.jvp, -1), (special.yvp, -1), (special.ivp, 1), (special.kvp, 1)):
            at = [function(n, k * inner, i) * k**i for i in range(2)]
            W, W1, W2 = (function(n, k, i) * k**i for i in range(3))
            moment = W2 + poisson * (W1 - n**2 * W)
            shear = sign * k**2 * W1 + (1 - poisson) * n**2 * (W - W1)
            columns.append(np.array([*at, moment, shear]) / abs(function(n, k, 0)))
        return np.linalg.det(np.array(columns).T)

    return optimize.brentq(determinant, 0.99 * guess, 1.01 * guess, xtol=1e-12)


@pytest.mark.parametrize("n", range(4))
def test_a_plate_vibrates_as_bessel_functions_say(n):
    errors = []
    for elements in (8, 16):
        plate = fl.AnnularPlate(0.4, 1.0, 0.01, 12e6, 0.3, 100.0, elements, n)  # E h^3/12 and rho h are 1
        mass, stiffness = (part.toarray() for part in plate.matrices())
        last = slice(-2 * elements, None)
        found = free_frequencies(mass[last, last], stiffness[last, last])[0] * np.sqrt(1 - 0.3**2)
        errors.append(found / plate_frequency(0.4, n, 0.3, found) - 1)
    assert 0 < errors[1] < 1e-5
    assert order_of_convergence(errors) == pytest.approx(4, abs=0.2)


def test_modes_of_a_plate_come_in_pairs():
    plate = fl.AnnularPlate(elements=2, diameters=2)
    mass, stiffness = (part.toarray() for part in plate.matrices())
    first = free_frequencies(mass, stiffness)[:5]
    assert first[[1, 3]] == pytest.approx(first[[2, 4]])
    at = np.array([0.07, 0.12]), np.array([0.3, 2.0])
    rows, slopes = plate.rows(*at)
    ahead = plate.rows(at[0], at[1] + 1e-6)[0]
    assert slopes == pytest.approx((ahead - rows) / 1e-6 / at[0][:, None], abs=1e-3 * np.abs(slopes).max())


def test_pads_press_and_friction_splits_a_doublet():
    brake = fl.DiscBrake()
    balance = fl.equilibrium(brake)
    assert balance.normal_force == pytest.approx(2 * 2000.0)
    assert balance.friction_force == pytest.approx(0.4 * balance.normal_force)
    growing = fl.eigenvalues(brake)
    assert len(growing.growing) == 1
    assert fl.eigenvalues(brake.replace(mu_k=0.25)).stable
    shape = growing.vectors[4 : brake.size, growing.growing[0]].reshape(13, -1)
    assert np.abs(shape).sum(axis=1).argsort()[-2:] == pytest.approx([7, 8], abs=1)  # cos and sin of 4 theta
    assert repr(pickle.loads(pickle.dumps(brake))) == repr(brake)
    assert brake.replace(F=1000.0).plate == brake.plate


def test_refused():
    with pytest.raises(ValueError, match=r"pad_radius must be .* most 0\.14"):
        fl.DiscBrake(pad_radius=0.2)
    with pytest.raises(ValueError, match=r"outer must be .* above 0\.2"):
        fl.AnnularPlate(inner=0.2)
    with pytest.raises(ValueError, match="nodes must not be clamped, got 0"):
        fl.BeamOnBelt(nodes=(0,))
    with pytest.raises(ValueError, match="nodes must name one"):
        fl.BeamOnBelt(nodes=())
    with pytest.raises(ValueError, match="plate must stay"):
        fl.DiscBrake().replace(plate=fl.AnnularPlate())
    with pytest.raises(TypeError, match="DiscBrake takes no 'pad_mas'"):
        fl.DiscBrake(pad_mas=1.0)
