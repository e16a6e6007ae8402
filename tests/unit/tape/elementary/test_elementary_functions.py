"""The solver's own elementary functions: against mpmath, at special values, compiled and as plain Python."""

import hashlib
import math
import os
import random
import struct
import subprocess
import sys
from pathlib import Path

import mpmath
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictionlab.tape.elementary import exponentials, trigonometry

ROOT = Path(__file__).parents[4]
NAMES = {
    exponentials: "exp expm1 sinh cosh tanh sech2 log log1p asinh acosh atanh",
    trigonometry: "sin cos tan atan asin acos",
}
FUNCTIONS = {name: getattr(module, name) for module, names in NAMES.items() for name in names.split()}
EXACT = {name: getattr(mpmath, name) for name in FUNCTIONS if name not in ("sech2", "log1p")} | {
    "sech2": lambda x: mpmath.sech(x) ** 2,
    "log1p": lambda x: mpmath.log(1 + x),
}
DOMAINS = {"log": (0.0, math.inf), "log1p": (-1.0, math.inf), "acosh": (1.0, math.inf)}
DOMAINS |= dict.fromkeys(("atanh", "asin", "acos"), (-1.0, 1.0))
DIGITS = 1250  # binary ones, for the largest angles, and for 1 + x
FEWER = dict.fromkeys(("exp", "expm1", "sinh", "cosh", "tanh", "sech2"), 200)  # mpmath adds what x needs
MOST_ULPS = 0.6
LARGEST, SMALLEST_NORMAL = sys.float_info.max, sys.float_info.min
# Where logarithms and exponentials change their ways, next to multiples of pi/2, and the double that is
# nearest to one of them (Muller, Elementary Functions, 3rd ed., section 11.1).
HARD = (
    *(
        0.0,
        5e-324,
        1e-310,
        1e-160,
        1e-20,
        2.0**-28,
        1e-8,
        0.0625,
        0.1875,
        0.3465735902799726,
        0.5,
        0.7071067811865475,
    ),
    *(
        0.7853981633974483,
        1 - 2**-53,
        1.0,
        1 + 2**-52,
        1.4142135623730951,
        1.5707963267948966,
        math.pi,
        2 * math.pi,
    ),
    *(19.99, 20.01, 22.0, 37.9, 355.0, 354.9, 372.5, 709.78, 710.4, 744.9, 1e5, 1e9 + 1, 1e18, 1e22, 1e300),
    *(5319372648326541416707072.0, 6381956970095103 * 2.0**797, 4e-5 * 2.0**1023, LARGEST),
)


def random_numbers(name, count=400):
    """Numbers of the domain: of all magnitudes, of ordinary ones, and close to its ends and to 1."""
    source = random.Random(name)
    low, high = DOMAINS.get(name, (-math.inf, math.inf))
    found = []
    while len(found) < count:
        tiny = 10.0 ** source.uniform(-16, 0)
        any_bits = struct.unpack("<d", struct.pack("<Q", source.getrandbits(64)))[0]
        ends = [end + sign * tiny for end in (low, high, 1.0) for sign in (1, -1) if math.isfinite(end)]
        drawn = [any_bits, source.uniform(-30, 30), source.uniform(-1, 1), 10 ** source.uniform(-9, 9), *ends]
        found += [x for x in drawn if low < x < high]
    return found + [sign * x for x in HARD for sign in (1, -1) if low <= sign * x <= high]


def error_in_ulps(name, x, got=None):
    """Distance from the exact value; of one beyond the range of numbers, 0 where the result says so."""
    got = FUNCTIONS[name](x) if got is None else got
    with mpmath.workprec(FEWER.get(name, DIGITS)):
        exact = EXACT[name](mpmath.mpf(x))
        if not mpmath.isfinite(exact) or abs(exact) > LARGEST:
            return 0.0 if math.isinf(got) and (got > 0) == (exact > 0) else math.inf
        return float(abs(got - exact) / math.ulp(float(exact)))


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_function_is_exact_to_rounding(name):
    for x in random_numbers(name):
        limit = MOST_ULPS if abs(FUNCTIONS[name](x)) >= SMALLEST_NORMAL else 1.0
        assert error_in_ulps(name, x) <= limit, x


@given(st.sampled_from(["exp", "expm1", "sin", "cos", "tan", "tanh", "atan", "asinh"]), st.floats(-1e6, 1e6))
def test_a_function_is_exact_anywhere(name, x):
    assert error_in_ulps(name, x) <= (MOST_ULPS if abs(FUNCTIONS[name](x)) >= SMALLEST_NORMAL else 1.0)


@given(st.floats(0.0, exclude_min=True, allow_infinity=False), st.floats(-40, 40))
def test_a_power_is_exact_to_rounding(x, y):
    got = exponentials.power(x, y)
    with mpmath.workprec(200):
        exact = mpmath.power(x, y)
        if exact > LARGEST:
            assert got == math.inf
        else:
            limit = MOST_ULPS if exact >= SMALLEST_NORMAL else 1.0
            assert abs(got - exact) <= limit * math.ulp(float(exact))


@pytest.mark.parametrize(
    ("x", "y", "value"), [(4.0, 0.5, 2.0), (8.0, 1 / 3, 2.0), (2.0, -1074.0, 5e-324), (9.0, 1.5, 27.0)]
)
def test_a_power_that_is_a_number_is_that_number(x, y, value):
    assert exponentials.power(x, y) == value


@pytest.mark.parametrize("name", [name for name in FUNCTIONS if name != "sech2"])
@pytest.mark.parametrize("x", [0.0, -0.0, math.inf, -math.inf, math.nan, 1.0, -1.0, 2.0, -2.0, 1e308, -1e308])
def test_special_values_are_those_of_the_library(name, x):
    got = FUNCTIONS[name](x)
    try:
        expected = getattr(math, name)(x)
    except OverflowError:
        expected = -math.inf if name in ("sinh", "expm1") and x < 0 else math.inf
    except ValueError:  # numbers instead of exceptions, as C has them
        infinite = {
            ("log", 0.0): -math.inf,
            ("log1p", -1.0): -math.inf,
            ("atanh", 1.0): math.inf,
            ("atanh", -1.0): -math.inf,
        }
        expected = infinite.get((name, x), math.nan)
    if expected == 0.0 or not math.isfinite(expected):
        assert str(got) == str(expected)
    else:
        assert got == pytest.approx(expected, rel=3e-16)


@pytest.mark.parametrize("x", [0.0, 0.5, 1.0, 2.0, math.inf])
@pytest.mark.parametrize("y", [0.0, -1.5, 1.5, math.inf, -math.inf])
def test_special_powers_are_those_of_the_library(x, y):
    expected = math.inf if x == 0.0 and y < 0.0 else math.pow(x, y)
    assert exponentials.power(x, y) == pytest.approx(expected, rel=3e-16)


def test_a_power_of_what_is_no_number_is_none():
    for x, y in (math.nan, 2.0), (2.0, math.nan), (-1.0, 0.5):
        assert math.isnan(exponentials.power(x, y))


def digest_of_values():
    """All values of all functions, to the last bit."""
    digest = hashlib.sha256()
    for name, function in FUNCTIONS.items():
        values = [function(x) for x in random_numbers(name)]
        digest.update(struct.pack(f"<{len(values)}d", *(math.inf if v != v else v for v in values)))
    powers = [exponentials.power(x, y) for x in map(abs, HARD) for y in (-2.5, 1e-3, 0.4, 1.5, 7.0)]
    digest.update(struct.pack(f"<{len(powers)}d", *powers))
    return digest.hexdigest()


@pytest.mark.slow
@pytest.mark.plain_python
def test_plain_python_gives_the_same_bits():
    program = f"import sys; sys.path.insert(0, {str(Path(__file__).parent)!r})\n"
    program += f"import {Path(__file__).stem} as these; print(these.digest_of_values())"
    environment = {**os.environ, "FRICTIONLAB_DISABLE_NUMBA": "1", "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-c", program]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == digest_of_values()
