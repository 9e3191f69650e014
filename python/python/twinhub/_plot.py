"""Axes of matplotlib, where it is there."""

from typing import Any

from .errors import InputError


def axes(ax: Any) -> Any:
    """The axes that were given, or new ones."""
    if ax is not None:
        return ax
    try:
        from matplotlib import pyplot
    except ImportError:
        raise InputError("plot: matplotlib is not there; accepted: pip install 'twinhub[plot]'") from None
    return pyplot.figure().add_subplot()
