"""What results of analyses share: a method `plot`.

Results lie below `frictionlab.plotting`, which draws them, so that plotting is imported when it is asked for,
here alone.
"""

from __future__ import annotations

from typing import Any, ClassVar


class Drawable:
    """A result that a function of ``frictionlab.plotting`` draws."""

    drawn_by: ClassVar[str]  # the name of that function
    several_axes: ClassVar[bool] = False  # whether it may make several, and returns them

    def plot(self, ax: Any = None, **options: Any) -> Any:
        """Draw the result by the function of ``frictionlab.plotting`` that `drawn_by` names.

        Parameters
        ----------
        ax : Axes or None
            None draws into a new figure.
        **options
            Further keywords of that function.

        Returns
        -------
        Axes
            Those drawn into, the first where there are several; a notebook shows the picture.
        """
        from frictionlab import plotting

        draw = getattr(plotting, self.drawn_by)
        if self.several_axes:
            return draw(self, ax, **options)[0]
        ax = plotting.axes_or_new(ax)
        draw(self, ax, **options)
        return ax
