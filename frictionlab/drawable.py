"""What results of analyses share: a method `plot`.

Results lie below `frictionlab.plotting`, which draws them, so that plotting is imported when it is asked for,
here alone.
"""

from __future__ import annotations

from typing import Any, ClassVar


class Drawable:
    """A result that a function of :mod:`frictionlab.plotting` draws."""

    drawn_by: ClassVar[str]  # the name of that function

    def plot(self, ax: Any = None, **options: Any) -> Any:
        """Draw the result by the function of :mod:`frictionlab.plotting` that `drawn_by` names.

        Parameters
        ----------
        ax : Axes or None
            None draws into a new figure.
        **options
            Further keywords of that function.

        Returns
        -------
        Axes
            Those drawn into; a notebook shows the picture.
        """
        from frictionlab import plotting

        ax = plotting.axes_or_new(ax)
        getattr(plotting, self.drawn_by)(self, ax, **options)
        return ax
