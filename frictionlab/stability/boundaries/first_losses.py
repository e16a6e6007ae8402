"""First losses of stability on thousands of lines: some are scanned, the others solved from predictions.

A scan takes some 250 spectra for a line, as it looks for every change, however narrow its window.  If the
first change on all scanned lines is a loss by flutter, these lines predict the losses on the others.  The
others are searched only up to a little beyond the prediction, in intervals that are long at first.  As in any
scan, an interval is halved if growth rates come near zero or eigenvalues near each other.  If this does not
find exactly one loss on a line, or does not resolve all intervals, the line is scanned in full.  So the
result is that of full scans, in a fifth of the spectra.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize.elementwise import find_root

from frictionlab.stability.equilibrium_problem import EquilibriumProblem
from frictionlab.stability.state_matrices import growth_rates, growth_scales

from .sign_changes import resolved_sign_changes
from .stability_changes import StabilityKind, changes_on_lines, first_loss_change

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
PILOTS = 48  # lines that are scanned
MIN_LINES = 4 * PILOTS  # with fewer lines all are scanned: there is little to save
ERROR_FACTOR = 3.0  # errors of the prediction on scanned lines: how far beyond it a search goes
MIN_WIDTH = 1e-6  # share of the bounds: the least of this distance
ROOT_STEPS = 60
SIDE_RTOL = 1e-7  # share of the bounds: how far from the root, on either side, growth is checked
ROOT_RATE_RTOL = 1e-9  # of the largest eigenvalue: a growth rate that is larger at a root has jumped


class FirstLosses(NamedTuple):
    """First losses on L lines: the parameter's value, and the frequency there in Hz; NaN for none."""

    values: Array
    frequencies: Array


def first_losses(
    problem: EquilibriumProblem, parameter: str, bounds: tuple[float, float], fixed: Mapping[str, Array]
) -> FirstLosses:
    """The first loss on each of L lines: `parameter` varies along a line, `fixed` (L,) from line to line."""
    count = max((len(column) for column in fixed.values()), default=1)
    losses = FirstLosses(np.full(count, np.nan), np.full(count, np.nan))
    left = np.arange(count)
    if count >= MIN_LINES:
        pilots = np.unique(np.linspace(0, count - 1, PILOTS).astype(int))
        alike = _scan(problem, parameter, bounds, fixed, pilots, losses)
        left = np.setdiff1d(left, pilots)
        if alike:
            left = left[~_solve(problem, parameter, bounds, fixed, (pilots, left), losses)]
    if len(left):
        _scan(problem, parameter, bounds, fixed, left, losses)
    return losses


def _scan(
    problem: EquilibriumProblem,
    parameter: str,
    bounds: tuple[float, float],
    fixed: Mapping[str, Array],
    lines: Indices,
    losses: FirstLosses,
) -> bool:
    """Scan some lines; returns whether the first change on each is a loss by flutter."""
    some = {name: column[lines] for name, column in fixed.items()}
    alike = True
    for line, changes in zip(lines, changes_on_lines(problem, parameter, bounds, some), strict=True):
        change = first_loss_change(changes)
        alike = alike and change is not None and change is changes[0] and change.kind == StabilityKind.FLUTTER
        if change is not None:
            losses.values[line], losses.frequencies[line] = change.value, change.frequency
    return alike


def _solve(
    problem: EquilibriumProblem,
    parameter: str,
    bounds: tuple[float, float],
    fixed: Mapping[str, Array],
    lines: tuple[Indices, Indices],
    losses: FirstLosses,
) -> Any:
    """Solve lines by the predictions of those scanned before; returns which of them are solved."""
    pilots, others = lines
    guess, error = _predict(fixed, pilots, others, losses.values[pilots])
    width = np.maximum(ERROR_FACTOR * error, MIN_WIDTH * (bounds[1] - bounds[0]))
    low, high = np.full(len(others), bounds[0]), np.clip(guess + width, *bounds)

    def spectra(line: Any, at: Array) -> Any:
        chosen = others[np.asarray(line, dtype=int)]
        return problem.spectra({**{n: column[chosen] for n, column in fixed.items()}, parameter: at})

    changes, resolved = resolved_sign_changes(spectra, low, high)
    alone = np.bincount(changes.line, minlength=len(others)) == 1
    held = (resolved & alone)[changes.line]  # of the changes
    on_line, ends = changes.line[held], (changes.low[held], changes.high[held])
    roots = find_root(
        lambda at, line: spectra(line, at)[:, 0].real, ends, args=(on_line.astype(float),), maxiter=ROOT_STEPS
    ).x
    critical: Any = np.full(len(on_line), complex(np.nan))
    solved = np.flatnonzero(np.isfinite(roots))
    critical[solved] = _critical(spectra, on_line[solved], roots[solved], SIDE_RTOL * (bounds[1] - bounds[0]))
    good = np.isfinite(critical)
    losses.values[others[on_line[good]]] = roots[good]
    losses.frequencies[others[on_line[good]]] = np.abs(critical[good].imag) / (2 * np.pi)
    return np.isin(np.arange(len(others)), on_line[good])


def _critical(spectra: Any, lines: Indices, roots: Array, side: float) -> Any:
    """The eigenvalue on the imaginary axis at each root; NaN if none passes the axis there, or one jumps."""
    at: Any = spectra(lines, roots)
    before, after = (spectra(lines, roots + shift) for shift in (-side, side))
    pair = (growth_rates(before) > 0).sum(axis=1), (growth_rates(after) > 0).sum(axis=1)
    passes = (pair[0] == 0) & (pair[1] == 2) & (at[:, 0].imag != 0.0)
    smooth = np.abs(at[:, 0].real) <= ROOT_RATE_RTOL * growth_scales(at)[:, 0]
    return np.where(passes & smooth, at[:, 0], complex(np.nan))


def _predict(
    fixed: Mapping[str, Array], pilots: Indices, others: Indices, values: Array
) -> tuple[Array, Array]:
    """Values on lines by a polynomial fitted to those scanned, and its error on these, each left out in turn.

    The polynomial is quadratic where enough lines are scanned, else linear.
    """
    columns = [np.asarray(column, dtype=float) for column in fixed.values()]
    centred = [(c - c[pilots].mean()) / (np.ptp(c[pilots]) or 1.0) for c in columns if np.ptp(c) > 0]
    at = np.column_stack([np.ones(len(columns[0])), *centred])
    squares = [a * b for i, a in enumerate(centred) for b in centred[i:]]
    if 2 * (len(squares) + at.shape[1]) <= len(pilots):
        at = np.column_stack([at, *squares])
    inverse = np.linalg.pinv(at[pilots])
    fitted = inverse @ values
    leverage = np.clip((at[pilots] * inverse.T).sum(axis=1), 0.0, 0.9)
    missed = (values - at[pilots] @ fitted) / (1.0 - leverage)
    return at[others] @ fitted, np.full(len(others), np.abs(missed).max())
