"""Schedules of the pair, with a proof."""

import json
from collections.abc import Callable, Iterable
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _html, _twinhub
from ._arguments import NameOrPath, finite, name_or_path, speeds, switch
from ._things import Bicycle, of
from .errors import InputError


class Design:
    """A schedule of the pair over speed with the tube that is proved around it.

    Attributes
    ----------
    bicycle : str
        The bicycle.
    speeds_m_s, torque_nm, from_nm, to_nm : numpy.ndarray, shape (n,)
        Nodes, m/s; the pair and both edges of the tube, Nm.
    growth_per_s, loss_growth_per_s : numpy.ndarray, shape (n,)
        Largest growth rate of all riders and bicycles in the tube, and after a sudden loss of the pair, 1/s.
    cells_proved : numpy.ndarray of bool, shape (n - 1,)
        Stretches between nodes that are proved.
    proved_m_s : list of tuple of float
        Stretches of speed that are proved, m/s.
    stops : list of dict
        What stops the proof elsewhere: ``speeds_m_s``, ``rider``, ``because``.
    law : str
        The law for the controller, TOML.
    """

    def __init__(self, answer: dict[str, Any], law: str, proof: str) -> None:
        def column(name: str) -> npt.NDArray[np.float64]:
            return np.array([point[name] for point in answer["schedule"]])

        self.bicycle = str(answer["bicycle"])
        self.speeds_m_s, self.torque_nm = column("speed_m_s"), column("torque_nm")
        self.from_nm, self.to_nm = column("from_nm"), column("to_nm")
        self.growth_per_s = np.array(answer["growth_per_s"])
        self.loss_growth_per_s = np.array(answer["loss_growth_per_s"])
        self.cells_proved = np.array(answer["cells_proved"], dtype=bool)
        self.proved_m_s = [(float(a), float(b)) for a, b in answer["proved_m_s"]]
        self.stops: list[dict[str, Any]] = answer["stops"]
        self.law = law
        self._proof = proof

    def save(self, path: NameOrPath) -> Path:
        """Write the law, and its proof beside it as ``.certificate.json``: ``twinhub certify`` checks both.

        Raises
        ------
        InputError
            If the name does not end in ``.toml``.
        """
        file = Path(name_or_path("path", path))
        if file.suffix != ".toml":
            raise InputError(f"path={str(file)!r}; accepted: a name that ends in .toml")
        file.with_suffix(".certificate.json").write_text(self._proof)
        file.write_text(self.law)
        return file

    def __repr__(self) -> str:
        proved = ", ".join(f"{a:g} to {b:g} m/s" for a, b in self.proved_m_s) or "nowhere"
        return f"Design({self.bicycle!r}: proved {proved}, up to {self.torque_nm.max():g} Nm)"

    def _repr_html_(self) -> str:
        rows = zip(self.speeds_m_s, self.torque_nm, self.from_nm, self.to_nm, self.growth_per_s, self.loss_growth_per_s)
        columns = ("speed, m/s", "pair, Nm", "tube from, Nm", "to, Nm", "growth, 1/s", "after a loss, 1/s")
        return f"<p>{escape(repr(self))}</p>{_html.table(columns, list(rows))}"


def design(
    bicycle: NameOrPath | Bicycle = "bulsink2017_bicycle1_full",
    riders: Iterable[str] = ("young",),
    speeds_m_s: npt.ArrayLike | None = None,
    mass: float = 0.1,
    load: float = 0.1,
    twisting: tuple[float, float] = (0.5, 2.0),
    boxes: tuple[int, int, int] | None = None,
    torque_nm: float = 40.0,
    half_width_nm: float = 5.0,
    rate_m_s2: float = 0.3,
    slope_nm_per_m_s: float = 30.0,
    loss_growth_per_s: float = 0.7,
    friction: float = 0.6,
    free_joints: bool = False,
    progress: Callable[[str], object] | None = None,
) -> Design:
    """Find the largest schedule of the pair that can be proved for a bicycle and riders who are used to it.

    Minutes of work for a narrow range, an hour for a wide one; Ctrl-C ends it.

    Parameters
    ----------
    bicycle : Bicycle, str or os.PathLike
        A multibody bicycle that ships, or its file.
    riders : iterable of str
        Riders who give torque: ``"young"``, ``"older"``, or ``"NAME:DELAY_S"``.
    speeds_m_s : array_like, shape (n,), optional
        Nodes, m/s, rising; 3 to 7.5 by 0.25 if absent. The schedule is zero at both ends.
    mass : float
        Share by which the rider's mass may differ.
    load : float
        Share by which side forces and moments of the tyres may differ.
    twisting : tuple of float
        Factors between which the twisting torque of the tyres may lie.
    boxes : tuple of int, optional
        Boxes that mass, load and twisting torque are cut into; as many as usually can be proved if absent.
    torque_nm : float
        Largest pair, Nm.
    half_width_nm : float
        Half the width of the tube, Nm.
    rate_m_s2 : float
        Fastest change of speed, m/s^2.
    slope_nm_per_m_s : float
        Steepest schedule, Nm per m/s.
    loss_growth_per_s : float
        Largest growth rate after a sudden loss of the pair, 1/s.
    friction : float
        Least friction of the road that has to carry the pair.
    free_joints : bool
        Whether the rider's joints move: many times slower.
    progress : callable, optional
        Called with a sentence now and then.

    Returns
    -------
    Design

    Raises
    ------
    InputError
        If an argument is out of range; the message says what is accepted.
    """
    name, changes = of("bicycle", bicycle)
    if changes:
        raise InputError(f"bicycle with changes {changes}; accepted: its file, for the proof names the bicycle")
    ask: dict[str, Any] = {
        "bicycle": name,
        "riders": [str(rider) for rider in riders],
        "mass": finite("mass", mass),
        "load": finite("load", load),
        "twisting": [finite("twisting", factor) for factor in twisting],
        "boxes": None if boxes is None else [int(part) for part in boxes],
        "torque_nm": finite("torque_nm", torque_nm),
        "half_width_nm": finite("half_width_nm", half_width_nm),
        "rate_m_s2": finite("rate_m_s2", rate_m_s2),
        "slope_nm_per_m_s": finite("slope_nm_per_m_s", slope_nm_per_m_s),
        "loss_growth_per_s": finite("loss_growth_per_s", loss_growth_per_s),
        "friction": finite("friction", friction),
        "free_joints": switch("free_joints", free_joints),
    }
    if speeds_m_s is not None:
        ask["speeds_m_s"] = speeds(speeds_m_s).tolist()
    answer, law, proof = _twinhub.design(json.dumps(ask), progress)
    return Design(json.loads(answer), law, proof)
