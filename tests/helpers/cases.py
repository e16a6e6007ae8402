"""Cases of parametrised tests, of which some run at once and the others in the slow leg."""

import pytest


def slow_but(at_once, cases, several=False):
    """The names or values `cases`, those that are not in `at_once` marked as slow.

    With `several` each case is a tuple of values of several arguments.
    """
    assert all(case in cases for case in at_once)
    rows = [(case, case if several else (case,)) for case in cases]
    return [case if case in at_once else pytest.param(*row, marks=pytest.mark.slow) for case, row in rows]
