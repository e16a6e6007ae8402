"""What this numba lacks of the parts that its manual does not describe."""

import pkgutil

import pytest

from frictionlab.compilation.numba_internals import UNDOCUMENTED

pytestmark = pytest.mark.plain_python


@pytest.mark.parametrize("name", UNDOCUMENTED)
def test_numba_has_what_the_compilation_takes_from_it(name):
    numba = pytest.importorskip("numba")
    try:
        pkgutil.resolve_name(name)
    except (ImportError, AttributeError):
        pytest.fail(
            f"numba {numba.__version__} has no {name}: mend frictionlab/compilation/numba_internals.py"
        )
