"""Names a user may have meant."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches


def did_you_mean(name: object, known: Iterable[str]) -> str:
    """Half a sentence that says what `name` may have been meant to be, and what there is.

    Parameters
    ----------
    name : object
        What was given.
    known : iterable of str
        What is understood.

    Returns
    -------
    str
        ``"did you mean 'mu_k'?"``, or the list of what is known where nothing is near.
    """
    names = list(known)
    near = [n for n in names if n.lower() == str(name).lower()] or get_close_matches(str(name), names, n=1)
    if near:
        return f"did you mean {near[0]!r}?"
    return f"known are {', '.join(names)}" if names else "there are none"
