"""`Fit`: fitted parameters, how sure they are, and which cannot be told apart."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionlab.presentation import Drawable, dataframe, text_table
from frictionlab.validation import check_number

Array = NDArray[np.float64]
STRONG_CORRELATION = 0.95  # from here on two parameters are named as hard to tell apart
RANK_RTOL = 1e-8  # singular values of the scaled derivatives below it: the data say nothing in that direction
NULL_SHARE = 1e-4  # share of a direction that is not identifiable from which on a parameter is part of it


@dataclass(frozen=True, eq=False)
class Fit(Drawable):
    """A model fitted to measurements.

    Parameters
    ----------
    model : Model
        With the fitted values.
    parameters : tuple of str
        Then the states at the start that were fitted, as "x1 at 0".
    values : array (P,)
    covariance : array (P, P)
        inf for those that the data do not determine.
    residuals : array (N,)
        (predicted - measured) / error.
    times : array (N,)
        Of the measurements, s; NaN for frequencies and spectra.
    rank : int
        How many combinations of parameters the data determine.
    undetermined : tuple of tuple of str
        Parameters that appear in each combination that they do not.
    message : str
        Why the search ended.
    """

    drawn_by = "plot_fit"

    model: Any
    parameters: tuple[str, ...]
    values: Array
    covariance: Array
    residuals: Array
    times: Array
    rank: int
    undetermined: tuple[tuple[str, ...], ...]
    message: str

    def __repr__(self) -> str:
        rows = [
            f"  {name} = {v:.6g} ± {e:.2g}" for name, v, e in zip(self.parameters, self.values, self.errors)
        ]
        return text_table([f"Fit({len(self.residuals)} numbers, reduced chi² {self.chi_square:.3g}):", *rows])

    def __getitem__(self, parameter: str) -> float:
        """The fitted value of a parameter."""
        if parameter not in self.parameters:
            raise KeyError(f"no parameter {parameter!r}: name one of {', '.join(self.parameters)}")
        return float(self.values[self.parameters.index(parameter)])

    @property
    def errors(self) -> Array:
        """Standard errors (P,); inf for what the data do not determine."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def degrees_of_freedom(self) -> int:
        """Measured numbers less determined combinations of parameters."""
        return len(self.residuals) - self.rank

    @property
    def chi_square(self) -> float:
        """Sum of squared residuals by the degrees of freedom: near 1 where model and errors are right."""
        return float(self.residuals @ self.residuals) / max(self.degrees_of_freedom, 1)

    @property
    def correlation(self) -> Array:
        """Correlations (P, P) of the parameters; NaN for what the data do not determine."""
        errors = np.where(np.isfinite(self.errors) & (self.errors > 0), self.errors, np.nan)
        return self.covariance / np.outer(errors, errors)

    @property
    def correlated(self) -> tuple[tuple[str, str, float], ...]:
        """Pairs of parameters that are hard to tell apart, and their correlation."""
        found, names = self.correlation, self.parameters
        pairs = [(i, j) for j in range(len(names)) for i in range(j) if abs(found[i, j]) > STRONG_CORRELATION]
        return tuple((names[i], names[j], float(found[i, j])) for i, j in pairs)

    def interval(self, parameter: str, level: float = 0.95) -> tuple[float, float]:
        """The confidence interval of a parameter, by the measurements' errors.

        Parameters
        ----------
        parameter : str
        level : float
            Share of such intervals that hold the truth.
        """
        from scipy.stats import norm

        check_number("level", level, above=0.0, below=1.0, cure="0.95 is usual")
        value = self[parameter]
        half = float(norm.ppf(0.5 + 0.5 * level)) * float(self.errors[self.parameters.index(parameter)])
        return value - half, value + half

    def summary(self) -> str:
        """The fit in words: values, intervals, and what the data do not tell."""
        ends = {name: self.interval(name) for name in self.parameters}
        rows = [f"{name} = {self[name]:.6g}, 95 % from {a:.6g} to {b:.6g}" for name, (a, b) in ends.items()]
        rows += [f"not determined: a combination of {', '.join(names)}" for names in self.undetermined]
        rows += [f"hard to tell apart: {a} and {b}, correlation {r:+.4f}" for a, b, r in self.correlated]
        freedom = f"{self.degrees_of_freedom} degrees of freedom"
        return "\n".join([*rows, f"reduced chi² {self.chi_square:.4g}, {freedom}"])

    def to_dataframe(self) -> Any:
        """One row for each parameter (needs the extra ``data``)."""
        columns = {"value": self.values, "error": self.errors}
        return dataframe(columns, {"parameter": list(self.parameters)}, {})


def covariance_of(slopes: Array, names: tuple[str, ...], scales: Array) -> tuple[Array, int, tuple[Any, ...]]:
    """Covariance (P, P), rank and undetermined combinations, of derivatives (N, P) of residuals."""
    scaled = slopes * scales
    _, sizes, directions = np.linalg.svd(scaled, full_matrices=True)
    sizes = np.concatenate([sizes, np.zeros(len(directions) - len(sizes))])
    known = sizes > RANK_RTOL * sizes[0] if sizes[0] > 0 else np.zeros(len(sizes), dtype=bool)
    kept = directions[known] / sizes[known, None]
    covariance = kept.T @ kept * np.outer(scales, scales)
    lost = np.abs(directions[~known])
    part = (lost > NULL_SHARE).any(axis=0)
    covariance[part, part] = np.inf
    undetermined = tuple(tuple(name for name, share in zip(names, row) if share > NULL_SHARE) for row in lost)
    return covariance, int(known.sum()), undetermined
