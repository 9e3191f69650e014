"""Drawing with matplotlib, where it is there."""

from typing import Any

from .errors import InputError


class Drawn:
    """What draws itself with matplotlib."""

    def plot(self, ax: Any = None) -> Any:
        """Draw it, with matplotlib.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Where to draw; new axes if not given.

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        InputError
            If matplotlib is not there (``pip install 'twinhub[plot]'``).
        """
        if ax is None:
            try:
                from matplotlib import pyplot
            except ImportError:
                raise InputError("plot: matplotlib is not there; accepted: pip install 'twinhub[plot]'") from None
            ax = pyplot.figure().add_subplot()
        self._draw(ax)
        return ax

    def _draw(self, ax: Any) -> None:
        raise NotImplementedError
