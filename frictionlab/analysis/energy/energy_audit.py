"""`fl.energy_audit`: where the energy of a run comes from, where it is, and where it goes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from frictionlab.analysis.motion_scales import Array
from frictionlab.drawable import Drawable
from frictionlab.frozen_mapping import FrozenMapping
from frictionlab.hybrid.progress import PROGRESS_DELAY
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.models import MechanicalModel

from .balance_terms import Balance

PIECE_NODES, PIECE_WEIGHTS = np.polynomial.legendre.leggauss(10)
PIECES_PER_CHUNK = 20_000  # intervals of the run computed at once


@dataclass(frozen=True, eq=False)
class EnergyAudit(Drawable):
    """The energy balance of a run.

    Parameters
    ----------
    t : array (N,)
        Times (s), those of the run.
    energies : mapping of str to array (N,)
        J: "kinetic"; those that the model names, as "springs" and "preload", or "potential"; and "contact",
        the integral of F_N over the penetration, none in flight.
    powers : mapping of str to array (N,)
        W: "dampers"; "impacts", in the limit mode that replaces them; of contacts with friction "belt drive"
        F_T v, v the speed of the belt, and "friction" -F_T v_r; where W_N is not the gradient of the gap
        "moving load" F_N (penetration rate + W_N . q'), -F_N phi (x1' - x2') with the paper's; and "loads".
        "contact" is the power of an F_N that is not given as a function of the penetration.
    works : mapping of str to array (N,)
        J: the work of each from 0 to t, that of impacts with their jumps.
    turned_over : float
        J: the largest sum of the energies' sizes, plus the sizes of all works, whether in or out.
    """

    drawn_by = "plot_energies"

    t: Array
    energies: Mapping[str, Array]
    powers: Mapping[str, Array]
    works: Mapping[str, Array]
    turned_over: float

    @property
    def total(self) -> Array:
        """Sum (N,) of the energies, J."""
        return np.sum(list(self.energies.values()), axis=0)

    @property
    def residual(self) -> Array:
        """Residual of the balance (N,), J: gain of the total since the first sample, less all works."""
        gained = self.total - np.sum(list(self.works.values()), axis=0)
        return gained - gained[:1]

    @property
    def error(self) -> float:
        """Largest residual as a share of the energy turned over; rounding, for the exact solver."""
        return float(np.abs(self.residual).max(initial=0.0) / (self.turned_over or 1.0))

    def __repr__(self) -> str:
        ends = ", ".join(f"{name} {work[-1]:+.4g} J" for name, work in self.works.items() if work[-1])
        return f"EnergyAudit(0 to {self.t[-1]:g} s, {ends or 'no work'}, error {self.error:.1g})"


def energy_audit(run: Trajectory, *, progress: bool = True) -> EnergyAudit:
    """The energy balance of a run: energies, powers, the work of each, and what is missing.

    Of the slider on a belt d/dt (kinetic + springs + preload + contact) = F_T v - F_T v_r - 2 D
    + F_N (penetration rate + W_N . q'), and velocities jump at impacts, Eqs. (10) to (12).  Every model that
    states its energies (`MechanicalModel`) has a balance, with the terms that it has.

    Works are Gauss quadratures of the run's Taylor polynomials, step by step, exact to rounding.  Runs of
    other methods are audited as they are: the residual is their error.

    Parameters
    ----------
    run : Trajectory
        Of a model, by :func:`simulate`.
    progress : bool
        Show a progress bar where it takes more than a second.

    Returns
    -------
    EnergyAudit

    Raises
    ------
    ValueError
        For a run of an automaton, or of a model that gives only an automaton: it has no masses or springs.

    Examples
    --------
    >>> import frictionlab as fl
    >>> run = fl.simulate(fl.SliderOnBelt(mu_k=1.4), 1.0)
    >>> audit = fl.energy_audit(run)
    >>> audit.error < 1e-12
    True
    >>> bool(audit.works["belt drive"][-1] > 0 > audit.works["friction"][-1])
    True
    """
    balance = _balance(run)
    edges = np.unique(np.concatenate([[0.0], run.raw.step_times[:, 0], run.t, [run.raw.t]]))
    net, gross = _work_integrals(run, balance, edges, progress)
    at = np.searchsorted(edges, run.t)
    powers = balance.powers(run.states, run.mode_indices)
    works = {name: net[i][at] for i, name in enumerate(powers)}
    gains = balance.jumps(run.events.before, run.events.state)
    summed = np.append(0.0, np.cumsum(gains, dtype=np.longdouble))
    works["impacts"] = works["impacts"] + summed[np.searchsorted(run.events.t, run.t, side="right")]
    energies = balance.energies(run.states, run.mode_indices)
    largest = np.sum(np.abs(list(energies.values())), axis=0).max(initial=0.0)
    return EnergyAudit(
        t=run.t,
        energies=FrozenMapping(energies),
        powers=FrozenMapping(powers),
        works=FrozenMapping({name: np.asarray(work, dtype=float) for name, work in works.items()}),
        turned_over=float(largest + gross + np.abs(gains).sum()),
    )


def _balance(run: Any) -> Balance:
    if not isinstance(run, Trajectory):
        raise TypeError(f"run must be a Trajectory, got {run!r}: give what frictionlab.simulate returns")
    if not isinstance(run.source, MechanicalModel):
        of = type(run.automaton if run.source is None else run.source).__name__
        raise ValueError(
            f"run must be of a model that states its energies, got one of a {of}, which has no masses nor "
            "springs: simulate a MechanicalModel"
        )
    return Balance(run.source, run.automaton)


def _work_integrals(run: Trajectory, balance: Balance, edges: Array, progress: bool) -> tuple[Any, float]:
    """Works (contributions, edges) since the first edge, and the sum of all sizes, J."""
    from tqdm.auto import tqdm

    starts = range(0, len(edges) - 1, PIECES_PER_CHUNK)
    shown = tqdm(starts, desc="energy audit", leave=False, delay=PROGRESS_DELAY, disable=not progress)
    parts = [_work_of_pieces(run, balance, edges[i : i + PIECES_PER_CHUNK + 1]) for i in shown]
    net = np.concatenate([np.zeros((len(parts[0][0]), 1)), *(part for part, _ in parts)], axis=1)
    return np.cumsum(net, axis=1, dtype=np.longdouble), sum(size for _, size in parts)


def _work_of_pieces(run: Trajectory, balance: Balance, edges: Array) -> tuple[Array, float]:
    """The work (contributions, pieces) on each piece of a run between two edges, and the sum of all sizes."""
    half = np.diff(edges)[:, None] / 2.0
    t = (edges[:-1, None] + half * (1.0 + PIECE_NODES)).ravel()
    found = balance.powers(*run.states_and_modes(t))
    weights = half * PIECE_WEIGHTS
    each = [power.reshape(weights.shape) for power in found.values()]
    net = np.array([(power * weights).sum(axis=1) for power in each])
    return net, float(sum((np.abs(power) * weights).sum() for power in each))
