"""Kernels that were compiled ahead of time: numba is not imported."""

import subprocess
import sys

import pytest

from frictionlab.hybrid import compilation

SCRIPT = """
import sys
import frictionlab as fl
model = fl.SliderOnBelt(mu_k=1.4)
fl.simulate(model, 0.1, progress=False).defect
fl.simulate(model, 0.01, method="rk4", progress=False)
fl.eigenvalues(model)
print("numba" in sys.modules)
"""


@pytest.mark.skipif(compilation.LOADED is None, reason="no kernels compiled ahead of time")
def test_numba_is_not_imported():
    done = subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, text=True, check=True)
    assert done.stdout == "False\n"
