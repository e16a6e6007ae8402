"""Cases of parametrised tests, of which some run at once and the others in the slow leg."""

import pytest


def slow_but(at_once, cases):
    """The names or values `cases`, those that are not in `at_once` marked as slow."""
    assert all(case in cases for case in at_once)
    return [case if case in at_once else pytest.param(case, marks=pytest.mark.slow) for case in cases]
