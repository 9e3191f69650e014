"""Linear models of a bicycle, and gradients of its modes."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _twinhub
from ._arguments import Assignments, NameOrPath, assignments, finite
from ._things import Bicycle, of
from .errors import InputError, UnknownNameError


@dataclass(frozen=True, eq=False)
class Linear:
    """Lateral motion about straight running at one speed: x' = a x + b u.

    Attributes
    ----------
    bicycle : str
        The bicycle.
    speed_m_s, torque_nm : float
        Speed, m/s, and pair of motor torques (front brake), Nm.
    a : numpy.ndarray, shape (n, n)
        State matrix, SI.
    b : numpy.ndarray, shape (n, m)
        Input matrix, SI.
    states, inputs : tuple of str
        What x and u are, with units.
    mass, c1, k0, k2 : numpy.ndarray, shape (2, 2), or None
        Of the benchmark model: M q'' + v C1 q' + (g K0 + v^2 K2) q = T, q = (roll, steer), as in
        Meijaard et al. (2007); kg m^2, kg m, kg m, kg. None for a multibody bicycle.
    """

    bicycle: str
    speed_m_s: float
    torque_nm: float
    a: npt.NDArray[np.float64]
    b: npt.NDArray[np.float64]
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    mass: npt.NDArray[np.float64] | None
    c1: npt.NDArray[np.float64] | None
    k0: npt.NDArray[np.float64] | None
    k2: npt.NDArray[np.float64] | None

    def eigenvalues(self) -> npt.NDArray[np.complex128]:
        """Eigenvalues, 1/s, shape (n,), fastest growth first."""
        values = np.linalg.eigvals(self.a).astype(np.complex128)
        ordered: npt.NDArray[np.complex128] = values[np.lexsort((values.imag, -values.real))]
        return ordered

    def to_control(self) -> Any:
        """The model as a ``control.StateSpace`` (package ``control``), every state an output."""
        import control

        c, d = self._outputs()
        return control.ss(
            self.a, self.b, c, d, states=list(self.states), inputs=list(self.inputs), outputs=[f"y_{s}" for s in self.states]
        )

    def to_scipy(self) -> Any:
        """The model as a ``scipy.signal.StateSpace``, every state an output."""
        from scipy.signal import StateSpace

        return StateSpace(self.a, self.b, *self._outputs())

    def _outputs(self) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        return np.eye(len(self.states)), np.zeros((len(self.states), len(self.inputs)))


@dataclass(frozen=True, eq=False)
class Gradients:
    """How an eigenvalue depends on everything.

    Attributes
    ----------
    mode : str
        The mode.
    eigenvalue : complex
        Its eigenvalue, 1/s.
    per_speed : complex
        Derivative with respect to speed, 1/m.
    values : dict of str to float
        Value of each parameter of the multibody model, by its dotted path, SI.
    per_unit : dict of str to complex
        Derivative of the eigenvalue with respect to each, 1/s per unit of the parameter.
    """

    mode: str
    eigenvalue: complex
    per_speed: complex
    values: dict[str, float]
    per_unit: dict[str, complex]

    def relative(self, path: str) -> complex:
        """Change of the eigenvalue per relative change of a parameter, 1/s."""
        try:
            return self.per_unit[path] * self.values[path]
        except KeyError:
            raise UnknownNameError(f"no parameter {path!r}; accepted: {', '.join(self.values)}") from None

    def largest(self, count: int = 10) -> list[str]:
        """Paths of the parameters whose relative change moves the mode's growth most."""
        return sorted(self.values, key=lambda path: -abs(self.relative(path).real))[:count]


def linearise(
    bicycle: NameOrPath | Bicycle = "meijaard2007_benchmark",
    speed_m_s: float = 5.0,
    torque_nm: float = 0.0,
    set: Assignments | None = None,
) -> Linear:
    """Lateral state space of a bicycle, straight and upright at one speed.

    Parameters
    ----------
    bicycle : Bicycle, str or os.PathLike
        As for `parameters`, or a multibody bicycle (``twinhub list bicycles``), or its file.
    speed_m_s : float
        Speed, 0 to 1000 m/s; a bicycle on tyres needs one above 0.
    torque_nm : float
        Torque of the front motor, Nm, positive brakes; the rear motor balances it.
    set : mapping or list of str, optional
        Parameters to change.

    Returns
    -------
    Linear

    Raises
    ------
    InputError
        If an argument is wrong, or the bicycle has no steady state there.

    Examples
    --------
    >>> import twinhub
    >>> twinhub.linearise(speed_m_s=5.0).states
    ('roll_rad', 'steer_rad', 'roll_rate_rad_s', 'steer_rate_rad_s')
    """
    name, changes = of("bicycle", bicycle)
    speed, torque = _speed(speed_m_s), finite("torque_nm", torque_nm)
    answer = _twinhub.linearise(name, speed, torque, [*changes, *assignments(set)])
    return Linear(
        name,
        speed,
        torque,
        answer["a"],
        answer["b"],
        tuple(answer["states"]),
        tuple(answer["inputs"]),
        answer.get("mass"),
        answer.get("c1"),
        answer.get("k0"),
        answer.get("k2"),
    )


def gradients(
    bicycle: NameOrPath | Bicycle = "bulsink2017_bicycle1_full",
    mode: str = "weave",
    speed_m_s: float = 5.0,
    torque_nm: float = 0.0,
    set: Assignments | None = None,
) -> Gradients:
    """Derivatives of a mode's eigenvalue with respect to every parameter.

    Parameters
    ----------
    bicycle : Bicycle, str or os.PathLike
        A bicycle, as for `linearise`; a benchmark bicycle is taken as the multibody bicycle that it
        is.
    mode : str
        ``"weave"``, ``"capsize"`` or ``"caster"``; of several of that name the one nearest to its
        border of stability.
    speed_m_s : float
        Speed, m/s.
    torque_nm : float
        Torque of the front motor, Nm; the rear motor balances it.
    set : mapping or list of str, optional
        Parameters to change.

    Returns
    -------
    Gradients

    Raises
    ------
    InputError
        If an argument is wrong, or there is no such mode.
    """
    name, changes = of("bicycle", bicycle)
    answer = _twinhub.gradients(
        name,
        _speed(speed_m_s),
        finite("torque_nm", torque_nm),
        _mode(mode),
        [*changes, *assignments(set)],
    )
    found = answer["parameters"]
    return Gradients(
        mode,
        complex(*answer["eigenvalue"]),
        complex(*answer["per_speed"]),
        {path: value for path, (value, _) in found.items()},
        {path: complex(*per_unit) for path, (_, per_unit) in found.items()},
    )


def _mode(mode: str) -> str:
    if isinstance(mode, str):
        return mode
    raise InputError(f"mode={mode!r}: accepted: a name, as 'weave'")


def _speed(value: float) -> float:
    speed = finite("speed_m_s", value)
    if not 0.0 <= speed <= 1000.0:
        raise InputError(f"speed_m_s={value!r}: accepted: 0 to 1000 m/s")
    return speed
