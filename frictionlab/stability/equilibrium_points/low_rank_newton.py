r"""Newton's steps in large systems of which few states enter nonlinearly, by one inverse matrix.

In large systems, as those of finite elements, few states enter nonlinearly.  Only their columns of the
Jacobian J(x) change from point to point: J(x) = J_0 + C(x) S, where S has the rows of the unit matrix that
select these states.  With the inverse of J_0, computed once, a step costs a product of that matrix and a
vector and the solution of one equation for each such state (Sherman, Morrison and Woodbury):

.. math:: J^{-1} b = y - J_0^{-1} C (1 + S J_0^{-1} C)^{-1} S y, \qquad y = J_0^{-1} b

instead of the elimination of a whole matrix at every point.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionlab.stability.flow import Flow
from frictionlab.stability.state_matrices import inverse_of

Array = NDArray[np.float64]
LEAST_STATES = 32  # below, whole matrices at all points take less than a tenth of a second
MOST_NONLINEAR_SHARE = 0.25  # of the states: with more, whole matrices cost about as much
REFERENCES_TRIED = 8  # points at which J_0 may be taken


@dataclass(frozen=True, eq=False)
class LowRankNewton:
    """Newton's steps at all points by one inverse matrix.

    Parameters
    ----------
    flow : Flow
    values : sequence of float
        Of the parameters.
    inverse : (m, m) array
        Of the Jacobian at a point of reference.
    columns : (m, k) array
        The columns of that Jacobian that change.
    """

    flow: Flow
    values: Sequence[float]
    inverse: Array
    columns: Array

    def step(self, x: Array) -> Array:
        """The step (m, N) towards a zero; not finite where the flow is not."""
        nonlinear = self.flow.nonlinear
        with np.errstate(all="ignore"):
            plain = self.inverse @ self.flow.rhs(x, self.values)
            change = self.flow.nonlinear_columns(x, self.values) - self.columns
            effect = self.inverse @ change  # (N, m, k)
            small = np.eye(len(nonlinear)) + effect[:, nonlinear, :]
            usable: Any = np.isfinite(small).all(axis=(1, 2)) & np.isfinite(plain).all(axis=0)
            usable[usable] = np.linalg.det(small[usable]) != 0
            step = np.full_like(x, np.nan)
            parts = np.linalg.solve(small[usable], plain.T[usable][:, nonlinear, None])
            step[:, usable] = -plain[:, usable] + (effect[usable] @ parts)[..., 0].T
        return step


def low_rank_newton(flow: Flow, values: Sequence[float], x: Array) -> LowRankNewton | None:
    """Newton's steps by the inverse at one of the points (m, N); None where that saves nothing or fails."""
    m = flow.size
    if m < LEAST_STATES or flow.linear or len(flow.nonlinear) > MOST_NONLINEAR_SHARE * m:
        return None
    for point in x.T[:REFERENCES_TRIED]:
        with np.errstate(all="ignore"):
            matrix = flow.jacobian(point, values)
        inverse = inverse_of(matrix) if np.isfinite(matrix).all() else None
        if inverse is not None:
            return LowRankNewton(flow, values, inverse, matrix[:, flow.nonlinear])
    return None
