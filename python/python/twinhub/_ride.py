"""Simulated rides."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from . import _html, _twinhub
from ._arguments import Assignments, NameOrPath, assignments, name_or_path, seed_text, switch
from ._controller import LawFunction
from ._log import Log
from ._messages import Estimate
from ._things import Bicycle, Course, Law, Motors, Rider, Road, Sensors, Wind, of, placed


class Perception(NamedTuple):
    """What a rider can perceive in one tick.

    Attributes
    ----------
    roll_rad, roll_rate_rad_s : float
        Roll, rad, and its rate, rad/s.
    steer_rad, steer_rate_rad_s : float
        Steer, rad, and its rate, rad/s.
    heading_rad : float
        Heading, rad.
    speed_m_s, wanted_speed_m_s : float
        Speed, and the speed that the course asks for, m/s.
    """

    roll_rad: float
    roll_rate_rad_s: float
    steer_rad: float
    steer_rate_rad_s: float
    heading_rad: float
    speed_m_s: float
    wanted_speed_m_s: float


#: A rider written in Python: `Perception` and the length of the tick (s) in; torque on the handlebar
#: (Nm) out, or that and the driving force of the pedals (N).
RiderFunction: TypeAlias = Callable[[Perception, float], float | tuple[float, float]]


@dataclass(frozen=True)
class Metrics:
    """What a ride comes to in a few numbers.

    Attributes
    ----------
    fell : bool
        The bicycle fell; the ride ends there.
    roll_rms_rad, steer_rms_rad : float
        Root mean square of roll and steer angle, rad.
    steer_rate_rms_rad_s : float
        Root mean square of the steer rate, rad/s.
    roll_max_rad : float
        Largest roll, either side, rad.
    swing_hz : float
        How fast the bicycle swings: upward zero crossings of the roll rate per second, Hz.
    rider_effort_rms_nm : float
        Root mean square of the rider's torque on the handlebar, Nm.
    energy_j : float
        Energy out of the battery, net of what came back, J.
    distance_m : float
        Distance, m.
    front_locked_ticks : int
        Ticks in which the front motor braked a standing wheel.
    ticks : int
        Ticks ridden, of 1 ms each.
    missed_ticks : int
        Ticks for which the controller had no answer in time.
    """

    fell: bool
    roll_rms_rad: float
    steer_rms_rad: float
    steer_rate_rms_rad_s: float
    roll_max_rad: float
    swing_hz: float
    rider_effort_rms_nm: float
    energy_j: float
    distance_m: float
    front_locked_ticks: int
    ticks: int
    missed_ticks: int


class Ride(Log):
    """A simulated ride: its numbers, and its log.

    Everything that holds for `Log` holds here: ``ride["/plant/truth"]["roll_rad"]``.

    Attributes
    ----------
    course : str
        Name of the course.
    stabilizer : bool
        Whether the stabilizer was on.
    seed : int
        Seed of everything random.
    metrics : Metrics
        The ride in a few numbers.
    digest : str
        Digest of the log, 32 hex characters: equal rides have equal digests, here and on the
        command line.
    """

    def __init__(self, answer: "_twinhub._RideAnswer", stabilizer: bool, path: Path | None) -> None:
        super().__init__(answer, path)
        self.course = answer["course"]
        self.seed = answer["seed"]
        self.stabilizer = stabilizer
        self.metrics = Metrics(**answer["metrics"])

    def _repr_html_(self) -> str:
        truth, rider = self["/plant/truth"], self["/rider/state"]
        # A picture of at most some thousand points.
        every = max(1, len(truth["t_s"]) // 2000)
        t = truth["t_s"][::every].tolist()

        def line(name: str, values: npt.NDArray[np.float64]) -> tuple[str, list[float], list[float]]:
            return (name, t, values[::every].tolist())

        picture = _twinhub.line_chart(
            f"Ride {self.course}",
            "time, s",
            [
                ("roll", "deg", [line("roll", np.degrees(truth["roll_rad"]))]),
                ("rider's torque", "Nm", [line("torque", rider["steer_torque_nm"])]),
                ("front brake", "Nm", [line("pair", truth["front_brake_nm"])]),
                ("speed", "m/s", [line("speed", truth["speed_m_s"])]),
            ],
        )
        names = ("fell", "roll_rms_rad", "rider_effort_rms_nm", "energy_j", "distance_m")
        return picture + _html.table(names, [[getattr(self.metrics, name) for name in names]])


def courses() -> list[str]:
    """Names of the courses that ship.

    Returns
    -------
    list of str
        As `ride` takes them.
    """
    return _twinhub.courses()


def ride(
    course: NameOrPath | Course = "three_to_eight",
    stabilizer: bool = True,
    set: Assignments | None = None,
    seed: int | None = None,
    log: NameOrPath | None = None,
    law: LawFunction | Law | NameOrPath | None = None,
    rider: RiderFunction | Rider | NameOrPath | None = None,
    bicycle: Bicycle | NameOrPath | None = None,
    motors: Motors | NameOrPath | None = None,
    sensors: Sensors | NameOrPath | None = None,
    road: Road | NameOrPath | None = None,
    wind: Wind | NameOrPath | None = None,
) -> Ride:
    """Ride a course, controller and plant in this process.

    Other threads go on meanwhile. Ctrl-C ends the ride with `KeyboardInterrupt`; the log, if you
    gave one, then holds everything up to there.

    Parameters
    ----------
    course : str, os.PathLike or Course
        A course that ships (see `courses`), or a course ``.toml``.
    stabilizer : bool
        The rider's switch: the stabilizer is on.
    set : mapping or list of str, optional
        Values to change, by their path in the course; those of rider and law have ``rider.`` and
        ``law.`` in front: ``{"duration_s": 20.0, "law.limits.torque_max_nm": 30.0}``.
    seed : int, optional
        Seed of everything random, 0 or more; the course's own if not given.
    log : str or os.PathLike, optional
        File of the log (MCAP); one that exists is replaced. If not given, no file is left.
    law : callable, Law, str or os.PathLike, optional
        A law in place of the course's. One of your own takes an `Estimate` and the time since the last
        tick, s, and gives the pair, Nm, or the pair and the rear trim; every limit of the course's law
        file still holds.
    rider : callable, Rider, str or os.PathLike, optional
        A rider in place of the course's. One of your own takes a `Perception` and the length of the
        tick, s, and gives the torque on the handlebar, Nm, or that and the driving force of the pedals,
        N; with torque alone, the pedals hold the speed that the course asks for.
    bicycle : Bicycle, str or os.PathLike, optional
        A multibody bicycle in place of the course's.
    motors : Motors, str or os.PathLike, optional
        Motors and battery in place of the course's.
    sensors : Sensors, str or os.PathLike, optional
        Sensors in place of the course's.
    road : Road, str or os.PathLike, optional
        A road in place of the course's.
    wind : Wind, str or os.PathLike, optional
        A wind in place of the course's.

    Returns
    -------
    Ride
        Metrics, digest, and the columns of every topic. A fall is a result, no error.

    Raises
    ------
    InputError
        If an argument, the course, or a file that it names is wrong.
    LogError
        If the log cannot be written.
    RideError
        If the ride could not go on.

    Examples
    --------
    >>> import twinhub
    >>> ride = twinhub.ride(stabilizer=False, set={"duration_s": 2.0})
    >>> ride.metrics.ticks
    2000
    >>> ride["/plant/truth"]["roll_rad"].shape
    (2000,)
    """
    name, changes = of("course", course)
    own_law, own_rider = _own(law), _own(rider)
    places = placed(
        law=None if own_law is not None else law,
        rider=None if own_rider is not None else rider,
        bicycle=bicycle,
        motors=motors,
        sensors=sensors,
        road=road,
        wind=wind,
    )
    texts = [*changes, *places, *assignments(set)]
    if seed is not None:
        texts.append(seed_text(seed))
    on = switch("stabilizer", stabilizer)
    file = None if log is None else name_or_path("log", log)
    answer = _twinhub.ride(
        name,
        on,
        texts,
        file,
        None if own_law is None else lambda x, dt_s: own_law(Estimate(*x), dt_s),
        None if own_rider is None else lambda x, dt_s: _action(own_rider, Perception(*x), dt_s),
    )
    return Ride(answer, on, None if file is None else Path(file))


def _own(what: Any) -> Any:
    """A law or rider written in Python; None for one that has a name."""
    return what if callable(what) else None


#: How the shipped riders hold the speed: N per m/s, and the most, N.
_PEDAL_NS_M, _PEDAL_MOST_N = 1000.0, 150.0


def _action(rider: RiderFunction, perceived: Perception, dt_s: float) -> tuple[float, float]:
    action = rider(perceived, dt_s)
    if isinstance(action, tuple):
        return action
    missing_m_s = perceived.wanted_speed_m_s - perceived.speed_m_s
    return action, min(max(_PEDAL_NS_M * missing_m_s, 0.0), _PEDAL_MOST_N)
