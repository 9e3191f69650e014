"""Modes of the benchmark bicycle over speed."""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from . import _twinhub
from ._arguments import Assignments, NameOrPath, assignments, finite, speeds
from ._plot import Drawn
from ._things import Bicycle, of
from .errors import UnknownNameError


@dataclass(frozen=True)
class Crossing:
    """A speed at which a mode gains or loses stability.

    Attributes
    ----------
    speed_m_s : float
        The speed, m/s.
    mode : str
        ``"weave"``, ``"capsize"``, ``"caster"`` or ``"other"``.
    kind : str
        ``"divergence"`` (a real eigenvalue through zero) or ``"oscillation"`` (a conjugate pair).
    stable_above : bool
        Whether the mode is stable just above that speed.
    """

    speed_m_s: float
    mode: str
    kind: Literal["divergence", "oscillation"]
    stable_above: bool


@dataclass(frozen=True, eq=False)
class Modes(Drawn):
    """Modes of a bicycle over speed, under a constant pair of motor torques.

    Attributes
    ----------
    bicycle : str
        Name of the bicycle.
    source : str
        Where its values come from.
    remarks : tuple of str
        What is doubtful about them, or was set by hand.
    front_brake_nm, rear_traction_nm : float
        Torques of the motors, Nm; positive brakes and positive drives.
    longitudinal_accel_m_s2 : float
        Forward acceleration under these torques, m/s^2; 0 for a balanced pair. If it is not 0, the
        modes are those of the moment at each speed.
    speed_m_s : numpy.ndarray, shape (n,)
        Speeds as asked for, m/s.
    eigenvalues : numpy.ndarray of complex, shape (n, 4)
        Eigenvalues, 1/s (imaginary part: rad/s), in each row sorted by real, then imaginary part;
        conjugates are exact.
    names : numpy.ndarray of str, shape (n, 4)
        Name of the mode of each eigenvalue, followed over speed: ``"weave"`` (twice), ``"capsize"``
        and ``"caster"``.
    weave_speed_m_s, capsize_speed_m_s : float or None
        Speed above which weave is stable, and speed above which capsize is not, m/s, within the
        speeds asked for; None where there is no such speed.
    weave, capsize : str
        ``"crosses"``, ``"always_stable"`` or ``"always_unstable"`` within the speeds asked for.
    stable_ranges_m_s : numpy.ndarray, shape (k, 2)
        Where all modes decay, m/s, within the speeds asked for.
    crossings : tuple of Crossing
        Every gain and loss of stability, ascending in speed.
    """

    bicycle: str
    source: str
    remarks: tuple[str, ...]
    front_brake_nm: float
    rear_traction_nm: float
    longitudinal_accel_m_s2: float
    speed_m_s: npt.NDArray[np.float64]
    eigenvalues: npt.NDArray[np.complex128]
    names: npt.NDArray[np.str_]
    weave_speed_m_s: float | None
    capsize_speed_m_s: float | None
    weave: Literal["crosses", "always_stable", "always_unstable"]
    capsize: Literal["crosses", "always_stable", "always_unstable"]
    stable_ranges_m_s: npt.NDArray[np.float64]
    crossings: tuple[Crossing, ...]

    def eigenvalues_of(self, mode: str) -> npt.NDArray[np.complex128]:
        """Eigenvalues of one mode over speed, ready to be plotted.

        Parameters
        ----------
        mode : str
            ``"weave"``, ``"capsize"`` or ``"caster"``.

        Returns
        -------
        numpy.ndarray of complex, shape (n, m)
            1/s; two columns for weave, one for the others.

        Raises
        ------
        UnknownNameError
            If the bicycle has no such mode.
        """
        chosen = self.names == mode
        count = int(chosen[0].sum())
        if count == 0:
            known = ", ".join(sorted(np.unique(self.names).tolist()))
            raise UnknownNameError(f"no mode {mode!r}; accepted: {known}")
        values: npt.NDArray[np.complex128] = self.eigenvalues[chosen]
        return values.reshape(len(self.speed_m_s), count)

    def _draw(self, ax: Any) -> None:
        """Real parts of the eigenvalues over speed."""
        order = np.argsort(self.speed_m_s)
        for name in np.unique(self.names).tolist():
            growth = np.where(self.names == name, self.eigenvalues.real, np.nan)[order]
            ax.plot(self.speed_m_s[order], growth, ".", markersize=3, label=name)
        ax.axhline(0.0, color="0.5", linewidth=0.8)
        ax.set(xlabel="speed, m/s", ylabel="growth, 1/s", title=f"{self.bicycle}, {self.front_brake_nm:g} Nm")

    def _repr_html_(self) -> str:
        order = np.argsort(self.speed_m_s)
        v = self.speed_m_s[order]
        real, imaginary = self.eigenvalues.real[order], np.abs(self.eigenvalues.imag[order])

        def lines(values: npt.NDArray[np.float64]) -> list[tuple[str, list[float], list[float]]]:
            return [(f"{k + 1}", v.tolist(), values[:, k].tolist()) for k in range(values.shape[1])]

        return _twinhub.line_chart(
            f"Eigenvalues of {self.bicycle}, {self.front_brake_nm:g} Nm",
            "speed, m/s",
            [("growth", "1/s", lines(real)), ("frequency", "rad/s", lines(imaginary))],
        )

    def __repr__(self) -> str:
        return (
            f"Modes({self.bicycle!r}, front_brake_nm={self.front_brake_nm:g}, "
            f"{len(self.speed_m_s)} speeds, weave_speed_m_s={self.weave_speed_m_s}, "
            f"capsize_speed_m_s={self.capsize_speed_m_s})"
        )


def modes(
    bicycle: NameOrPath | Bicycle = "meijaard2007_benchmark",
    torque_nm: float = 0.0,
    speeds_m_s: npt.ArrayLike | None = None,
    rear_torque_nm: float | None = None,
    set: Assignments | None = None,
) -> Modes:
    """Weave, capsize and caster over speed, and where they are stable.

    The numbers are those of ``twinhub modes --json``.

    Parameters
    ----------
    bicycle : str or os.PathLike
        As for `parameters`.
    torque_nm : float
        Torque of the front motor, Nm, positive brakes; the rear motor balances it, so that the
        speed stays.
    speeds_m_s : array_like, shape (n,), optional
        Speeds, 0 to 1000 m/s, in any order, at most 100,000; 0 to 10 m/s in steps of 0.5 m/s if
        not given.
        Crossings and ranges are looked for between the least and the greatest of them.
    rear_torque_nm : float, optional
        Torque of the rear motor, Nm, positive drives, instead of the balancing one.
    set : mapping or list of str, optional
        Parameters to change, as for `parameters`.

    Returns
    -------
    Modes

    Raises
    ------
    InputError
        If an argument is wrong, or the bicycle cannot be.

    Examples
    --------
    >>> import numpy as np, twinhub
    >>> m = twinhub.modes(speeds_m_s=np.linspace(0.0, 10.0, 101))
    >>> round(m.weave_speed_m_s, 6), round(m.capsize_speed_m_s, 6)
    (4.292383, 6.024262)
    >>> m.eigenvalues_of("weave").shape
    (101, 2)
    """
    asked = speeds(np.arange(21) * 0.5 if speeds_m_s is None else speeds_m_s)
    name, changes = of("bicycle", bicycle)
    answer = _twinhub.modes(
        name,
        finite("torque_nm", torque_nm),
        asked,
        None if rear_torque_nm is None else finite("rear_torque_nm", rear_torque_nm),
        [*changes, *assignments(set)],
    )
    return Modes(
        bicycle=answer["bicycle"],
        source=answer["source"],
        remarks=tuple(answer["remarks"]),
        front_brake_nm=answer["front_brake_nm"],
        rear_traction_nm=answer["rear_traction_nm"],
        longitudinal_accel_m_s2=answer["longitudinal_accel_m_s2"],
        speed_m_s=answer["speed_m_s"],
        eigenvalues=answer["eigenvalues"],
        names=np.array(answer["names"], dtype=np.str_).reshape(len(asked), -1),
        weave_speed_m_s=answer["weave_speed_m_s"],
        capsize_speed_m_s=answer["capsize_speed_m_s"],
        weave=answer["weave"],
        capsize=answer["capsize"],
        stable_ranges_m_s=answer["stable_ranges_m_s"],
        crossings=tuple(Crossing(*crossing) for crossing in answer["crossings"]),
    )
