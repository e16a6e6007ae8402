"""Damping of a structure that is not given as a matrix."""

from __future__ import annotations

from dataclasses import dataclass

from frictionlab.components.component import Component, parameter


@dataclass(frozen=True, repr=False)
class RayleighDamping(Component):
    """C = alpha M + beta K; circulatory forces have no part in it.

    A mode of the undamped structure with the angular frequency omega has the damping ratio
    (alpha/omega + beta omega)/2.  Both numbers are parameters of the structure.

    Parameters
    ----------
    alpha : float
        1/s, at least 0.
    beta : float
        s, at least 0.

    Examples
    --------
    >>> import frictionlab as fl
    >>> one = fl.Structure([[1.0]], [[100.0]], fl.RayleighDamping(alpha=0.2, beta=0.004))
    >>> fl.eigenvalues(one).damping_ratios.round(6).tolist()
    [0.03, 0.03]
    """

    alpha: float = parameter(
        0.0, unit="1/s", symbol=r"\alpha", meaning="damping proportional to mass", minimum=0.0
    )
    beta: float = parameter(
        0.0, unit="s", symbol=r"\beta", meaning="damping proportional to stiffness", minimum=0.0
    )
