"""isolate() finds every root in (0, 1], in order, with the right parity of its multiplicity."""

from fractions import Fraction

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictionlab.hybrid.kernels.event_location import (
    isolate_roots,
    monomials_in_bernstein_form,
    new_root_scratch,
    to_bernstein,
)

pytestmark = pytest.mark.plain_python

EPS = np.finfo(float).eps
places = st.lists(st.integers(1, 1023), min_size=1, max_size=5, unique=True).map(
    lambda numbers: [Fraction(n, 1024) for n in sorted(numbers)]
)
outside = st.lists(st.sampled_from([-3, -1, Fraction(-1, 8), Fraction(9, 8), 2, 5]), max_size=3)


def expand(roots, factor=1):
    """Coefficients, lowest first, of factor * prod (x - root), exact until the last rounding."""
    a = [Fraction(factor)]
    for root in roots:
        a = [low - Fraction(root) * high for low, high in zip([Fraction(0), *a], [*a, Fraction(0)])]
    return np.array([float(c) for c in a])


def find(coefficients, limit=None):
    """Places and multiplicities of the roots."""
    a = np.array(coefficients, dtype=float)
    n = len(a) - 1
    roots = new_root_scratch(n)
    roots.scaled[:] = a
    count = isolate_roots(n, n + 1 if limit is None else limit, roots)
    return roots.places[:count], roots.multiplicity[:count]


def uncertainty(a, root):
    """How far rounding of the coefficients, and of Bernstein's form of them, can move a simple root."""
    k = np.arange(len(a))
    slope = abs(np.sum(k[1:] * a[1:] * root ** (k[1:] - 1)))
    return 100 * EPS * np.sum(np.abs(a)) / slope


@given(inside=places, others=outside, factor=st.sampled_from([1, -1, 1000, Fraction(-1, 7)]))
def test_simple_roots_are_found_in_order(inside, others, factor):
    a = expand([*inside, *others], factor)
    found, multiplicity = find(a)
    assert multiplicity.tolist() == [1] * len(inside)
    assert (np.diff(found) > 0).all()
    for root, place in zip(inside, found, strict=True):
        assert abs(place - float(root)) <= uncertainty(a, float(root))


@given(inside=places, others=outside)
def test_the_first_root_alone_is_the_first_of_all(inside, others):
    a = expand([*inside, *others])
    assert find(a, limit=1)[0].tolist() == find(a)[0][:1].tolist()


@given(others=st.lists(st.sampled_from([-2, Fraction(-1, 4), Fraction(3, 2), 7]), max_size=6))
def test_no_root_is_invented(others):
    assert find(expand(others))[0].size == 0
    assert find(np.convolve(expand(others), [1.0, 0.0, 4.0]))[0].size == 0


@given(numerator=st.integers(1, 63), power=st.sampled_from([2, 3, 4]), other=st.sampled_from([-1, 2, 3]))
def test_a_multiple_root_counts_as_one_of_that_parity(numerator, power, other):
    root = Fraction(numerator, 64)
    found, multiplicity = find(expand([root] * power + [other]))
    # Rounding spreads an m-fold root over about eps^(1/m); the pieces keep the parity of their sum.
    assert np.abs(found - float(root)).max(initial=0.0) < 20 * EPS ** (1 / power)
    assert multiplicity.sum() % 2 == power % 2
    if power % 2:
        assert found.size >= 1


def test_an_exact_double_root_is_one_event():
    for root in (0.5, 0.25, 0.3125):
        found, multiplicity = find([root**2, -2 * root, 1.0])
        assert found == pytest.approx([root], abs=1e-8)
        assert multiplicity.tolist() == [2]


def test_an_exact_triple_root_has_odd_multiplicity():
    found, multiplicity = find(expand([Fraction(1, 2)] * 3))
    assert np.abs(found - 0.5).max() < 1e-4
    assert multiplicity.sum() % 2 == 1


@pytest.mark.parametrize("power", [1, 2, 3])
def test_a_root_at_the_end_of_the_interval_counts(power):
    found, multiplicity = find(expand([1] * power))
    assert found.tolist() == [1.0]
    assert multiplicity.tolist() == [power]


def test_a_root_at_the_end_and_one_inside():
    found, multiplicity = find(expand([Fraction(1, 4), 1]))
    assert found == pytest.approx([0.25, 1.0], rel=1e-15)
    assert multiplicity.tolist() == [1, 1]


@pytest.mark.parametrize("root", [0.5, 0.25, 0.75])
def test_a_root_where_the_interval_is_halved_counts_once(root):
    found, multiplicity = find(expand([Fraction(root), Fraction(9, 10), -1, -2]))
    assert found == pytest.approx([root, 0.9], rel=1e-14)
    assert multiplicity.tolist() == [1, 1]


@pytest.mark.parametrize("exponent", [3, 6, 9, 12, 15])
def test_a_tiny_first_root_is_as_exact_as_any(exponent):
    tiny = Fraction(1, 10**exponent)
    found, multiplicity = find(expand([tiny, Fraction(1, 2), 3]))
    assert found[0] == pytest.approx(float(tiny), rel=1e-14)
    assert found[1] == pytest.approx(0.5, rel=1e-14)
    assert multiplicity.tolist() == [1, 1]


@pytest.mark.parametrize("distance", [1e-3, 1e-5, 1e-7])
def test_two_close_roots_are_told_apart(distance):
    # x**2 - x + (1 - distance**2)/4, its roots are (1 +- distance)/2
    d = Fraction(distance)
    found, multiplicity = find([float((1 - d * d) / 4), -1.0, 1.0])
    assert found == pytest.approx([0.5 - distance / 2, 0.5 + distance / 2], abs=20 * EPS / distance)
    assert multiplicity.tolist() == [1, 1]


def test_two_roots_closer_than_the_resolution_count_as_a_double_one():
    # (x - 1/3)**2 with rounded coefficients: none, two, or one double root
    found, multiplicity = find([1 / 9, -2 / 3, 1.0])
    assert multiplicity.sum() % 2 == 0
    assert np.abs(found - 1 / 3).max(initial=0.0) < 1e-7


def test_what_is_zero_throughout_has_no_root():
    assert find([0.0, 0.0, 0.0])[0].size == 0


@given(st.integers(2, 20))
def test_a_high_order_series_has_the_roots_of_its_function(terms):
    # sin(pi s)/s on (0, 1]: a zero at 1 only; cos(pi s): a zero at 1/2 only
    order = 2 * terms + 16
    k = np.arange(order + 1)
    factorial = np.cumprod(np.concatenate([[1.0], k[1:]]))
    cosine = np.where(k % 2 == 0, (-1.0) ** (k // 2), 0.0) * np.pi**k / factorial
    found, multiplicity = find(cosine)
    assert found == pytest.approx([0.5], rel=1e-14)
    assert multiplicity.tolist() == [1]


@pytest.mark.parametrize("seed", range(4))
def test_a_first_root_is_as_exact_as_its_coefficients_allow(seed):
    """Against mpmath, along decaying series such as a step has; a bisection must not end the search."""
    random = np.random.default_rng(seed)
    for _ in range(150):
        a = random.normal(size=27) * 0.3 ** np.arange(27)
        a[0] = abs(a[0]) * random.choice([1.0, 1e-3, 1e-6])
        places, multiplicity = find(a, limit=1)
        if len(places) and multiplicity[0] == 1:
            x = float(places[0])
            with mpmath.workdps(40):
                value = mpmath.polyval([mpmath.mpf(c) for c in a[::-1]], x)
                slope = mpmath.polyval([k * mpmath.mpf(a[k]) for k in range(26, 0, -1)], x)
                error = abs(float(value / slope))
            size = np.abs(a) @ x ** np.arange(27)
            assert error <= 4 * EPS * (x + size / abs(float(slope)))


def test_a_double_root_of_a_low_degree_is_seen_in_a_series_of_a_high_order():
    places, multiplicity = find([1.0, -4.0, 4.0, *[0.0] * 24])
    assert places.tolist() == [0.5]
    assert multiplicity.tolist() == [2]


def test_bernstein_forms_of_a_table_and_of_a_low_degree_are_one_polynomial():
    """At the ends and in the mean: both are the polynomial's own."""
    a = np.random.default_rng(1).normal(size=14)
    scratch, plain = np.zeros(32), np.zeros(16)
    degree = to_bernstein(a, 13, monomials_in_bernstein_form(13), plain)
    assert degree == 13
    degree = to_bernstein(a, 13, monomials_in_bernstein_form(25), scratch)
    assert degree == 25
    for b in (plain[:14], scratch[:26]):
        assert b[0] == a[0]
        assert b[-1] == pytest.approx(a.sum(), abs=1e-14)
        assert b.mean() == pytest.approx(np.sum(a / np.arange(1, 15)), abs=1e-13)
