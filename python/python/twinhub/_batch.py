"""Many rides at once."""

from collections.abc import Callable, Iterable, Mapping
from typing import Any, NoReturn

import numpy as np
import numpy.typing as npt

from . import _twinhub
from ._arguments import Assignments, NameOrPath, assignments, seed_text, switch, workers_of
from ._things import Bicycle, Course, Law, Motors, Rider, Road, Sensors, Wind, of, placed
from .errors import InputError, UnknownNameError


class Batch(dict[str, npt.NDArray[Any]]):
    """Numbers of many rides: a dict from name to numpy array, a value for each ride.

    Names carry their units: ``fell`` (bool), ``roll_rms_rad``, ``steer_rms_rad``,
    ``steer_rate_rms_rad_s``, ``roll_max_rad``, ``swing_hz``, ``rider_effort_rms_nm``, ``energy_j``,
    ``distance_m``, ``front_locked_ticks``, ``ticks``, and ``seed`` where seeds were given.
    ``pandas.DataFrame(batch)`` and ``polars.DataFrame(batch)`` take it as it is.
    """

    def __missing__(self, name: str) -> NoReturn:
        raise UnknownNameError(f"no column {name!r}; accepted: {', '.join(self)}")

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><td>{name}</td><td>{float(np.mean(values)):.4g}</td>"
            f"<td>{float(np.min(values)):.4g}</td><td>{float(np.max(values)):.4g}</td></tr>"
            for name, values in self.items()
        )
        count = len(next(iter(self.values()), np.empty(0)))
        return (
            f"<table><caption>{count} rides</caption><thead><tr><th></th><th>mean</th><th>least</th>"
            f"<th>most</th></tr></thead><tbody>{rows}</tbody></table>"
        )


def batch(
    course: NameOrPath | Course = "three_to_eight",
    seeds: Iterable[int] | None = None,
    stabilizer: bool = True,
    set: Assignments | None = None,
    vary: Iterable[Mapping[str, object]] | None = None,
    workers: int | None = None,
    progress: Callable[[int, int], object] | None = None,
    law: Law | NameOrPath | None = None,
    rider: Rider | NameOrPath | None = None,
    bicycle: Bicycle | NameOrPath | None = None,
    motors: Motors | NameOrPath | None = None,
    sensors: Sensors | NameOrPath | None = None,
    road: Road | NameOrPath | None = None,
    wind: Wind | NameOrPath | None = None,
) -> Batch:
    """Ride many rides, on all cores.

    Parameters
    ----------
    course : str, os.PathLike or Course
        As for `ride`.
    seeds : iterable of int, optional
        A ride for each seed; the course's own if not given.
    stabilizer : bool
        The rider's switch: the stabilizer is on.
    set : mapping or list of str, optional
        Values to change in all rides, as for `ride`.
    vary : iterable of mappings, optional
        Further values, a set of rides (one for each seed) for each mapping.
    workers : int, optional
        Number of threads; all cores if not given. Results do not depend on it.
    progress : callable, optional
        Called now and then with the number of rides done and of all.
    law : Law, str or os.PathLike, optional
        A law in place of the course's; one written in Python rides with `ride`.
    rider : Rider, str or os.PathLike, optional
        A rider in place of the course's; one written in Python rides with `ride`.
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
    Batch
        Columns in the order of ``vary``, and within it of ``seeds``.

    Raises
    ------
    InputError
        If an argument, the course, or a file that it names is wrong.
    RideError
        If a ride could not go on.

    Examples
    --------
    >>> import twinhub
    >>> rides = twinhub.batch(seeds=range(3), set={"duration_s": 2.0})
    >>> rides["roll_rms_rad"].shape
    (3,)
    """
    name, changes = of("course", course)
    places = placed(law=law, rider=rider, bicycle=bicycle, motors=motors, sensors=sensors, road=road, wind=wind)
    on, common = switch("stabilizer", stabilizer), [*changes, *places, *assignments(set)]
    threads = workers_of(workers)
    if seeds is not None and not isinstance(seeds, Iterable):
        raise InputError(f"seeds={seeds!r}: accepted: several seeds, as range(10)")
    if vary is not None and (isinstance(vary, Mapping) or not isinstance(vary, Iterable)):
        raise InputError(f"vary={vary!r}: accepted: a list of mappings, one for each set of rides")
    chosen = None if seeds is None else list(seeds)
    seed_texts: list[list[str]] = [[]] if chosen is None else [[seed_text(seed)] for seed in chosen]
    sets: list[list[str]] = [[]] if vary is None else [assignments(values) for values in vary]
    wanted = [(name, on, common + extra + seed) for extra in sets for seed in seed_texts]
    answer = Batch(_twinhub.batch(wanted, threads, progress))
    if chosen is not None:
        answer["seed"] = np.array(chosen * len(sets), dtype=np.int64)
    return answer
