"""Which figures and claims there are, and the modules that compute them, imported when asked."""

from __future__ import annotations

from importlib import import_module

from .claims import Claims
from .result import PaperFigure

# Number -> module with `figure(number)`.
FIGURES = {2: "coalescence", 3: "coalescence", 4: "critical", 5: "critical", 6: "two_pairs"}
# Claim -> module with `CHECKS`, name -> function that gives the Claim.
CLAIMS: dict[str, str] = {f"C{i}": "linear_claims" for i in range(1, 9)}


def figure(number: int) -> PaperFigure:
    """Compute a figure of the paper.

    Parameters
    ----------
    number : int
        The paper's.

    Returns
    -------
    PaperFigure
        With the numbers in ``.data`` and the picture from ``.plot()``.

    Raises
    ------
    ValueError
        For a figure that is not computed.

    Examples
    --------
    >>> import frictionlab as fl
    >>> fl.paper.figure(2).data.changes[1e7][0].value  # doctest: +ELLIPSIS
    1.14842...
    """
    check_number(number)
    return import_module(f"{__package__}.{FIGURES[number]}").figure(number)


def check_number(number: int) -> None:
    """Refuse a number that no module computes, with those that there are."""
    if number not in list(FIGURES):
        raise ValueError(f"the figure must be one of {', '.join(map(str, FIGURES))}, got {number!r}")


def claims(*names: str) -> Claims:
    """Check claims of the paper.

    Parameters
    ----------
    *names : str
        Such as "C5"; none checks all.

    Returns
    -------
    Claims
        A row for each, which prints as text and shows as a table in a notebook.

    Raises
    ------
    ValueError
        For an unknown name.

    Examples
    --------
    >>> import frictionlab as fl
    >>> fl.paper.claims("C8")["C8"].verdict.value
    'reproduced'
    """
    for name in names:
        if name not in CLAIMS:
            raise ValueError(f"a claim must be one of {', '.join(CLAIMS)}, got {name!r}")
    chosen = names or tuple(CLAIMS)
    return Claims(tuple(import_module(f"{__package__}.{CLAIMS[n]}").CHECKS[n]() for n in chosen))
