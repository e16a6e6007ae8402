"""`fl.lyapunov`: how fast neighbouring motions separate, in every direction."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from frictionlab.analysis.initial_states import initial_state_of
from frictionlab.automaton import HybridAutomaton
from frictionlab.hybrid.solve import end_of, solve_from_end
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.hybrid.variational.tangent_flow import tangent_growth
from frictionlab.interruption import interruption, progress_bar
from frictionlab.models.model import automaton_of
from frictionlab.presentation import Drawable, shorten
from frictionlab.stability.equilibrium_points.frozen_time import refuse_time
from frictionlab.validation import check_flag, check_number, check_t_end, explains_keywords

from .motion_scales import Array, state_scales

if TYPE_CHECKING:
    from frictionlab.models.model import ModelOrAutomaton

MAX_BLOCKS = 1_000_000  # each is a run


@dataclass(frozen=True, eq=False, repr=False)
class LyapunovSpectrum(Drawable):
    """Lyapunov exponents of a motion.

    Parameters
    ----------
    exponents : array (n,)
        1/s, the largest first; -inf for a direction that events remove (onsets of stick, plastic impacts),
        or that constraints never leave free (a contact that stays closed).
    standard_errors : array (n,)
        Of the exponents, from the scatter of `blocks`; NaN where the exponent is -inf.
    blocks : array (K, n)
        Exponents of each of K parts of the run.
    final_state : array (n,)
        Where the run ended; give it as `x0` to go on.
    """

    drawn_by = "plot_lyapunov"

    exponents: Array
    standard_errors: Array
    blocks: Array
    final_state: Array

    def __repr__(self) -> str:
        pairs = zip(self.exponents, self.standard_errors)
        return f"LyapunovSpectrum({shorten(f'{mean:.4g} +- {error:.2g}' for mean, error in pairs)} 1/s)"

    @property
    def chaotic(self) -> bool:
        """Whether the largest exponent is positive by more than three standard errors."""
        return bool(self.exponents[0] > 3.0 * self.standard_errors[0])


@explains_keywords
def lyapunov(
    model: ModelOrAutomaton,
    x0: Any = "rest",
    *,
    transient: float = 200.0,
    t_end: float = 1000.0,
    blocks: int = 20,
    progress: bool = True,
) -> LyapunovSpectrum:
    """Lyapunov exponents, by the tangent flow of the motion, orthonormalised after every step.

    The tangent flow is that of :func:`frictionlab.tangent_flow`: series of the tape and a saltation matrix at
    every event.  Source: Benettin et al., Meccanica 15 (1980) 9-20.

    Parameters
    ----------
    model : Model or HybridAutomaton
    x0 : "rest", "near", mapping or array_like (n,)
        For an automaton "rest" means all states zero.
    transient : float
        Seconds that are discarded.
    t_end : float
        Seconds over which the exponents are averaged.  They begin after the transient and one extra block, in
        which the tangent vectors find their directions.
    blocks : int
        Number of parts of the run, at least two, whose scatter gives the standard errors.
    progress : bool

    Returns
    -------
    LyapunovSpectrum

    Raises
    ------
    ValueError
        For bad arguments; where the run ends early; where it has no tangent flow, see `tangent_flow`.
    KeyboardInterrupt
        After ctrl-C; :func:`partial_result` then returns the spectrum of the blocks that were done, or None
        for fewer than two.

    Examples
    --------
    >>> import frictionlab as fl
    >>> model = fl.SliderOnBelt(mu_k=1.4).without("geometry")
    >>> lyapunov = fl.lyapunov(model, transient=20.0, t_end=20.0)
    >>> lyapunov.chaotic
    False
    """
    check_flag("progress", progress)
    transient = check_number("transient", transient, least=0.0, cure="give the seconds to throw away")
    t_end = check_t_end(t_end, "give the seconds to average over")
    blocks = check_number("blocks", blocks, integer=True, least=2, most=MAX_BLOCKS, cure="20 parts are usual")
    automaton = automaton_of(model)
    refuse_time(model, "Lyapunov exponents")
    state, mode = initial_state_of(model, x0, automaton), None
    if transient:
        state, mode = end_of(_run(automaton, transient, state, None, progress))
    motion = _run(automaton, t_end / blocks, state, mode, progress).states
    size = state_scales(motion, automaton.coordinates)
    rows = np.linalg.qr(np.random.default_rng(0).normal(size=(len(size),) * 2))[0] * size
    growths: list[Array] = []
    try:
        for _ in progress_bar(range(blocks + 1), desc="lyapunov", shown=progress):
            run = _run(automaton, t_end / blocks, state, mode, False)
            rows, growth = tangent_growth(run, rows, size)
            growths.append(growth)
            state, mode = end_of(run)
    except KeyboardInterrupt as error:
        blocks_done = len(growths) - 1
        so_far = _spectrum(np.array(growths[1:]) * blocks / t_end, state) if blocks_done > 1 else None
        raise interruption(
            f"the average was stopped after {max(blocks_done, 0)} of {blocks} blocks", so_far
        ) from error
    return _spectrum(np.array(growths[1:]) * blocks / t_end, state)


def _run(
    automaton: HybridAutomaton, t_end: float, state: Array, mode: str | None, progress: bool
) -> Trajectory:
    run = solve_from_end(automaton, t_end, state, mode, progress=progress)
    if not run.status.ok:
        raise ValueError(f"the motion must not end early, it does after {run.raw.t:g} s: {run.status}")
    return run


def _spectrum(blocks: Array, state: Array) -> LyapunovSpectrum:
    exponents = blocks.mean(axis=0)
    order = np.argsort(-exponents, kind="stable")
    with np.errstate(invalid="ignore"):
        errors = blocks.std(axis=0, ddof=1) / np.sqrt(len(blocks))
    return LyapunovSpectrum(exponents[order], errors[order], blocks[:, order], state)
