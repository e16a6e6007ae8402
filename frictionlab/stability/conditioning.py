"""Which growth rates are zero but for rounding: by the backward error of the eigenvalue problem.

Computed eigenvalues of A are exact ones of A + E, where |E| is about m eps |A|; A is rounded by as much.
Source: Golub and Van Loan, Matrix Computations, 4th ed., sections 7.2 and 7.5.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eig, matrix_balance

Array = NDArray[np.float64]
ROUNDING = 4.0 * float(np.finfo(float).eps)  # of both, with a factor of two to spare


def neutral(matrix: Array, values: NDArray[np.complex128]) -> NDArray[np.bool_]:
    """Whether the real part of each eigenvalue (m,) of a real matrix (m, m) is nothing but rounding.

    To first order E moves an eigenvalue by |E| times its condition number.  Where two coalesce that number
    is infinite and tells nothing, as at critical damping: there has to be an E as well that puts an
    eigenvalue on the imaginary axis at this frequency.  Both are looked at for the balanced matrix.
    """
    balanced: Any = matrix_balance(matrix, permute=False)[0]
    error = len(matrix) * ROUNDING * np.linalg.norm(balanced, 2)
    system: Any = eig(balanced, left=True)
    known, left, right = system
    nearest = np.abs(values[:, None] - known).argmin(axis=1)
    product = np.abs((left.conj() * right).sum(axis=0))[nearest]
    on_axis = balanced - 1j * values.imag[:, None, None] * np.eye(len(matrix))
    distance = np.linalg.svd(on_axis, compute_uv=False)[:, -1]
    return (np.abs(values.real) * product <= error) & (distance <= error)
