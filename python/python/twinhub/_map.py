"""Stability over speed and motor torque."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _twinhub
from ._arguments import Assignments, NameOrPath, assignments, speeds, workers_of
from ._plot import Drawn
from ._things import Bicycle, of
from .errors import InputError

#: Below, slip means nothing.
_SLOWEST_M_S = 0.05
_MOST_POINTS = 2_000_000


@dataclass(frozen=True, eq=False)
class StabilityMap(Drawn):
    """Growth of small disturbances over speed and motor torque.

    Attributes
    ----------
    bicycle : str
        The bicycle.
    speeds_m_s : numpy.ndarray, shape (n,)
        Speeds, m/s.
    torques_nm : numpy.ndarray, shape (m,)
        Pairs of motor torques (front brake), Nm.
    growth_1_s : numpy.ndarray, shape (m, n)
        Largest real part of all lateral modes, 1/s; NaN where there is no steady state.
    oscillating_growth_1_s, slow_growth_1_s : numpy.ndarray, shape (m, n)
        The same of the modes that oscillate, and of those that do not.
    svg : str
        The picture.
    """

    bicycle: str
    speeds_m_s: npt.NDArray[np.float64]
    torques_nm: npt.NDArray[np.float64]
    growth_1_s: npt.NDArray[np.float64]
    oscillating_growth_1_s: npt.NDArray[np.float64]
    slow_growth_1_s: npt.NDArray[np.float64]
    svg: str

    @property
    def stable(self) -> npt.NDArray[np.bool_]:
        """Where everything decays, shape (m, n)."""
        stable: npt.NDArray[np.bool_] = self.growth_1_s < 0.0
        return stable

    def __repr__(self) -> str:
        m, n = self.growth_1_s.shape
        return f"StabilityMap({self.bicycle!r}, {m} torques, {n} speeds, {self.stable.mean():.0%} stable)"

    def _draw(self, ax: Any) -> None:
        """Growth over speed and torque, and the border of stability."""
        most = float(np.nanmax(np.abs(self.growth_1_s), initial=1e-9))
        mesh = ax.pcolormesh(
            self.speeds_m_s, self.torques_nm, self.growth_1_s, cmap="RdBu_r", vmin=-most, vmax=most, shading="nearest"
        )
        if min(self.growth_1_s.shape) > 1:
            ax.contour(self.speeds_m_s, self.torques_nm, self.growth_1_s, levels=[0.0], colors="k")
        ax.figure.colorbar(mesh, ax=ax, label="growth, 1/s")
        ax.set(xlabel="speed, m/s", ylabel="torque of the pair, Nm", title=self.bicycle)

    def _repr_html_(self) -> str:
        return self.svg


def stability_map(
    bicycle: NameOrPath | Bicycle = "bulsink2017_bicycle1_full",
    speeds_m_s: npt.ArrayLike | None = None,
    torques_nm: npt.ArrayLike | None = None,
    set: Assignments | None = None,
    workers: int | None = None,
) -> StabilityMap:
    """Where a bicycle is stable by itself, over speed and motor torque.

    The numbers are those of ``twinhub map``.

    Parameters
    ----------
    bicycle : Bicycle, str or os.PathLike
        A bicycle, as for `linearise`.
    speeds_m_s : array_like, shape (n,), optional
        Speeds, 0.05 to 1000 m/s, rising; 1 to 10 m/s in steps of 0.25 if not given.
    torques_nm : array_like, shape (m,), optional
        Pairs of motor torques, Nm, 0 or more, rising; 0 to 100 Nm in steps of 5 if not given.
    set : mapping or list of str, optional
        Parameters to change.
    workers : int, optional
        Number of threads; all cores if not given. Results do not depend on it.

    Returns
    -------
    StabilityMap

    Raises
    ------
    InputError
        If an argument is wrong.

    Examples
    --------
    >>> import twinhub
    >>> twinhub.stability_map(speeds_m_s=[4.0, 8.0], torques_nm=[0.0, 80.0]).growth_1_s.shape
    (2, 2)
    """
    v = speeds(np.arange(1.0, 10.01, 0.25) if speeds_m_s is None else speeds_m_s)
    t = np.asarray(np.arange(0.0, 100.1, 5.0) if torques_nm is None else torques_nm, dtype=np.float64)
    if t.ndim != 1 or t.size == 0 or not (np.isfinite(t).all() and (t >= 0.0).all() and (np.diff(t) > 0).all()):
        raise InputError("torques_nm: accepted: a one-dimensional array of rising torques, 0 Nm or more")
    if (v < _SLOWEST_M_S).any() or not (np.diff(v) > 0).all():
        raise InputError(f"speeds_m_s: accepted: rising speeds, {_SLOWEST_M_S} m/s or more")
    if v.size * t.size > _MOST_POINTS:
        raise InputError(f"{v.size * t.size} points; accepted: at most {_MOST_POINTS}")
    name, changes = of("bicycle", bicycle)
    answer = _twinhub.stability_map(
        name, v.tolist(), t.tolist(), [*changes, *assignments(set)], workers_of(workers)
    )
    return StabilityMap(
        answer["bicycle"],
        v,
        t,
        answer["growth_1_s"],
        answer["oscillating_growth_1_s"],
        answer["slow_growth_1_s"],
        answer["svg"],
    )
