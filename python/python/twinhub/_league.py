"""Controllers against each other over a population of riders."""

import json
import os
import warnings
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Executor, Future, ThreadPoolExecutor, wait
from numbers import Integral
from tempfile import TemporaryDirectory
from typing import Any, TypeAlias

from . import _html, _twinhub
from ._arguments import NameOrPath, finite, name_or_path
from ._controller import LawFunction
from ._messages import Estimate
from ._ride import Perception, RiderFunction, _action
from ._things import Law
from .errors import InputError

#: Makes a law for each ride: a class, or a function without arguments. To be sent to other processes
#: it has to be one that pickle knows: defined at the top of a module.
LawFactory: TypeAlias = Callable[[], LawFunction]

#: Makes a rider for each ride; as `LawFactory`.
RiderFactory: TypeAlias = Callable[[], RiderFunction]

#: What competes: laws by name or file; or a mapping from name to law, file, or `LawFactory`.
Controllers: TypeAlias = Iterable[NameOrPath] | Mapping[str, NameOrPath | Law | LawFactory]

_CLASSES = ("young", "older", "young_roll", "older_roll", "young_firm", "older_firm", "published")
#: The law file whose limits hold for a law written in Python.
_BASE = "constant"


class _Start:
    """A law for a ride, told of the estimate by its names."""

    def __init__(self, factory: LawFactory) -> None:
        self.factory = factory

    def __call__(self) -> Callable[[tuple[float, ...], float], object]:
        law = self.factory()
        return lambda x, dt_s: law(Estimate(*x), dt_s)


class _StartRider:
    """A rider for a ride, told of what is perceived by its names."""

    def __init__(self, factory: RiderFactory) -> None:
        self.factory = factory

    def __call__(self) -> Callable[[tuple[float, ...], float], tuple[float, float]]:
        rider = self.factory()
        return lambda x, step_s: _action(rider, Perception(*x), step_s)


def _part(
    spec: str,
    number: int,
    factories: dict[str, LawFactory],
    rider: RiderFactory | None,
    stop: _twinhub._Stop | None = None,
) -> str:
    """One part of a league; runs in any process that has twinhub."""
    laws: dict[str, Callable[[], Callable[[tuple[float, ...], float], object]]]
    laws = {name: _Start(f) for name, f in factories.items()}
    return _twinhub.league_part(spec, number, laws, stop, None if rider is None else _StartRider(rider))


class League:
    """What a league came to.

    Attributes
    ----------
    rows : list of dict
        By controller and class of riders (a class, or ``"all"``, ``"torque"``, ``"firm"``):
        ``falls_per_1000_km``, ``rider_effort_rms_nm``, ``roll_rms_rad``, ``energy_wh_per_km`` and
        others, each None or ``{"value": .., "ci95": [.., ..]}``.
    frontier : list of dict
        Benefit against energy, riders who give torque.
    harm : list of dict
        Falls against those without a stabilizer, by class, speed and surface.
    spec : str
        What the league is, JSON.
    parts : list of str
        Every part, JSON: `merge_leagues` puts shards together.
    """

    def __init__(self, spec: str, parts: list[str]) -> None:
        self.spec = spec
        self.parts = parts
        answer: dict[str, Any] = json.loads(_twinhub.league_table(spec, parts))
        self.rows: list[dict[str, Any]] = answer["rows"]
        self.frontier: list[dict[str, Any]] = answer["frontier"]
        self.harm: list[dict[str, Any]] = answer["harm"]

    def row(self, controller: str, riders: str) -> dict[str, Any]:
        """The row of a controller and a class of riders."""
        for row in self.rows:
            if row["controller"] == controller and row["class"] == riders:
                return row
        known = sorted({(row["controller"], row["class"]) for row in self.rows})
        raise InputError(f"no row {controller!r}, {riders!r}; accepted: {known}")

    def __repr__(self) -> str:
        names = [p["controller"] for p in self.frontier]
        return f"League({len(self.parts)} riders; {', '.join(names)})"

    def _repr_html_(self) -> str:
        def value(row: dict[str, Any], name: str) -> float | None:
            found = row[name]
            return None if found is None else float(found["value"])

        names = ("falls_per_1000_km", "rider_effort_rms_nm", "roll_rms_rad", "energy_wh_per_km")
        rows = [(r["controller"], r["class"], r["rides"], *(value(r, n) for n in names)) for r in self.rows]
        dots = [
            (p["controller"], p["energy_wh_per_km"], p["effort_saved_nm"], p["on_frontier"])
            for p in self.frontier
            if p["energy_wh_per_km"] is not None and p["effort_saved_nm"] is not None
        ]
        return _twinhub.frontier_picture(dots) + _html.table(("controller", "riders", "rides", *names), rows)


def league(
    riders: int = 10,
    seed: int = 1,
    controllers: Controllers | None = None,
    classes: Iterable[str] = _CLASSES,
    duration_s: float = 60.0,
    profile: str | None = None,
    executor: Executor | None = None,
    shard: tuple[int, int] | None = None,
    progress: Callable[[int, int], object] | None = None,
    rider: RiderFactory | None = None,
) -> League:
    """Let controllers compete on the same riders and courses.

    The numbers are those of ``twinhub league`` with the same riders and controllers. ``off`` always
    rides.

    Parameters
    ----------
    riders : int
        Riders of each class.
    seed : int
        Seed of riders, courses and noise.
    controllers : list or mapping, optional
        Names of laws that ship or law files; or a mapping from name to law, file, `Law`, or a class (or
        function without arguments) that gives a law written in Python: a callable that takes an
        `Estimate` and the time since the last tick, s, and gives the pair, Nm, or the pair and the
        rear trim. Limits of the law file ``constant`` hold for it.
    classes : iterable of str
        ``"young"``, ``"older"``, ``"young_roll"``, ``"older_roll"``, ``"young_firm"``, ``"older_firm"``,
        ``"published"``.
    duration_s : float
        Length of each ride, s.
    profile : str, optional
        ``"laboratory"`` or ``"en15194"`` in place of the law files' own.
    executor : concurrent.futures.Executor, optional
        Where parts run: processes, ``dask.distributed.Client.get_executor()``, a batch scheduler's;
        threads of this process if not given.
    shard : tuple of int, optional
        ``(i, n)``: only every n-th part, from the i-th, counted from 1.
    progress : callable, optional
        Called with the number of parts done and of all.
    rider : class or callable, optional
        Gives a rider written in Python for every ride, in place of the population's: a callable as
        `ride` takes it. The courses stay those of the classes.

    Returns
    -------
    League

    Raises
    ------
    InputError
        If an argument or a law is wrong.
    RideError
        If a ride could not go on.
    """
    named: dict[str, NameOrPath | Law | LawFactory]
    if controllers is None:
        named = {name: name for name in ("constant_80_nm", "constant", "scheduled", "scheduled_20_nm")}
    elif isinstance(controllers, Mapping):
        named = dict(controllers)
    else:
        named = {}
        for c in controllers:
            stem = os.path.splitext(os.path.basename(name_or_path("controllers", c)))[0]
            if stem in named:
                raise InputError(f"controllers: {stem!r} is named twice; accepted: every controller once")
            named[stem] = c
    factories: dict[str, LawFactory] = {}
    if rider is not None and not callable(rider):
        raise InputError(f"rider={rider!r}: accepted: what makes a rider, as a class of yours")
    with TemporaryDirectory(prefix="twinhub-") as written:
        files: list[tuple[str, str]] = []
        for name, what in named.items():
            if name == "off" and what != "off":
                raise InputError(
                    "controllers: 'off' is what all are measured against; accepted: another name for this one"
                )
            if isinstance(what, str | os.PathLike):
                files.append((name, name_or_path("controllers", what)))
            elif isinstance(what, Law):
                files.append((name, str(what.save(os.path.join(written, f"{len(files)}.toml")))))
            elif callable(what):
                factories[name] = what
                files.append((name, _BASE))
            else:
                raise InputError(f"controllers[{name!r}]={what!r}: accepted: a law, a file, or what makes a law")
        spec = _twinhub.league_spec(
            _whole("seed", seed, 0),
            _whole("riders", riders, 1),
            _names("classes", classes),
            finite("duration_s", duration_s),
            files,
            profile,
        )
    count = len(json.loads(spec)["classes"]) * int(riders)
    first, step = _shard(shard)
    numbers = range(first - 1, count, step)
    if executor is not None:
        return League(spec, _run(executor, spec, numbers, factories, rider, progress, None))
    threads = ThreadPoolExecutor(os.cpu_count())
    try:
        return League(spec, _run(threads, spec, numbers, factories, rider, progress, _twinhub._Stop()))
    finally:
        # After Ctrl-C nobody waits: what runs ends by itself.
        threads.shutdown(wait=False, cancel_futures=True)


def merge_leagues(leagues: Iterable[League]) -> League:
    """Put shards together: with all of them, exactly the league that one run in one piece gives.

    Parameters
    ----------
    leagues : iterable of League
        Shards of one league.

    Returns
    -------
    League

    Raises
    ------
    InputError
        If they are not of one league, or there are none.

    Warns
    -----
    UserWarning
        If parts are missing.
    """
    all_of_them = list(leagues)
    if not all_of_them:
        raise InputError("leagues: none; accepted: at least one")
    if any(league.spec != all_of_them[0].spec for league in all_of_them):
        raise InputError("leagues: they differ in seed, riders, classes or controllers; accepted: shards of one")
    parts = {json.loads(text)["part"]: text for league in all_of_them for text in league.parts}
    spec = json.loads(all_of_them[0].spec)
    missing = spec["riders"] * len(spec["classes"]) - len(parts)
    if missing > 0:
        warnings.warn(
            f"{missing} of {missing + len(parts)} parts are missing: not every shard is here, or not whole",
            stacklevel=2,
        )
    return League(all_of_them[0].spec, [parts[number] for number in sorted(parts)])


def _run(
    executor: Executor,
    spec: str,
    numbers: range,
    factories: dict[str, LawFactory],
    rider: RiderFactory | None,
    progress: Callable[[int, int], object] | None,
    stop: _twinhub._Stop | None,
) -> list[str]:
    rest = () if stop is None else (stop,)
    futures: list[Future[str]] = [executor.submit(_part, spec, number, factories, rider, *rest) for number in numbers]
    try:
        done = 0
        waiting = set(futures)
        while waiting:
            finished, waiting = wait(waiting, timeout=0.2)
            for future in finished:
                future.result()
            if finished and progress is not None:
                done += len(finished)
                progress(done, len(futures))
        return [future.result() for future in futures]
    except BaseException:
        # Ctrl-C or a failure: what has not begun does not begin, what runs here ends.
        if stop is not None:
            stop.set()
        for future in futures:
            future.cancel()
        raise


def _names(argument: str, names: Iterable[str]) -> list[str]:
    # A text is an iterable of texts, too.
    listed = [] if isinstance(names, str) or not isinstance(names, Iterable) else list(names)
    if not listed or not all(isinstance(name, str) for name in listed):
        raise InputError(f"{argument}={names!r}: accepted: a list of names, as {list(_CLASSES[:2])}")
    return listed


def _shard(shard: tuple[int, int] | None) -> tuple[int, int]:
    if shard is None:
        return 1, 1
    if isinstance(shard, tuple | list) and len(shard) == 2:
        first, step = shard
        whole = all(isinstance(n, Integral) and not isinstance(n, bool) for n in shard)
        if whole and 1 <= first <= step:
            return int(first), int(step)
    raise InputError(f"shard={shard!r}: accepted: (i, n) with i from 1 to n")


def _whole(argument: str, value: int, least: int) -> int:
    if isinstance(value, Integral) and not isinstance(value, bool) and least <= value < 2**63:
        return int(value)
    raise InputError(f"{argument}={value!r}: accepted: an integer, {least} or more")
