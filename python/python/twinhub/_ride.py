"""Simulated rides."""

from dataclasses import dataclass
from pathlib import Path

from . import _twinhub
from ._arguments import Assignments, NameOrPath, assignments, name_or_path, seed_text, switch
from ._log import Log


@dataclass(frozen=True)
class Metrics:
    """What a ride comes to in a few numbers.

    Attributes
    ----------
    fell : bool
        The bicycle fell; the ride ends there.
    roll_rms_rad, steer_rms_rad : float
        Root mean square of roll and steer angle, rad.
    rider_effort_rms_nm : float
        Root mean square of the rider's torque on the handlebar, Nm.
    energy_j : float
        Energy out of the battery, net of what came back, J.
    distance_m : float
        Distance, m.
    ticks : int
        Ticks ridden, of 1 ms each.
    missed_ticks : int
        Ticks for which the controller had no answer in time.
    """

    fell: bool
    roll_rms_rad: float
    steer_rms_rad: float
    rider_effort_rms_nm: float
    energy_j: float
    distance_m: float
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


def courses() -> list[str]:
    """Names of the courses that ship.

    Returns
    -------
    list of str
        As `ride` takes them.
    """
    return _twinhub.courses()


def ride(
    course: NameOrPath = "three_to_eight",
    stabilizer: bool = True,
    set: Assignments | None = None,
    seed: int | None = None,
    log: NameOrPath | None = None,
) -> Ride:
    """Ride a course, controller and plant in this process.

    Other threads go on meanwhile. Ctrl-C ends the ride with `KeyboardInterrupt`; the log, if you
    gave one, then holds everything up to there.

    Parameters
    ----------
    course : str or os.PathLike
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
    texts = assignments(set)
    if seed is not None:
        texts.append(seed_text(seed))
    on = switch("stabilizer", stabilizer)
    file = None if log is None else name_or_path("log", log)
    answer = _twinhub.ride(name_or_path("course", course), on, texts, file)
    return Ride(answer, on, None if file is None else Path(file))
