"""Tuning a stabilizer: schedules, ramps and thresholds against effort, falls and energy."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field
from numbers import Integral
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from . import _html, _twinhub
from ._arguments import Assignments, NameOrPath, assignments, finite
from ._batch import Batch, batch
from ._plot import Drawn
from ._things import Bicycle, Course, Law, Rider, placed
from .errors import InputError


@dataclass(frozen=True)
class Weighted:
    """An objective: effort, energy and falls in one number.

    Attributes
    ----------
    effort_per_nm : float
        Weight of the rider's effort, per Nm of root mean square.
    energy_per_wh_km : float
        Weight of the energy, per Wh/km net from the battery.
    fall : float
        Weight of a fall, per share of rides that fall.
    """

    effort_per_nm: float = 1.0
    energy_per_wh_km: float = 0.01
    fall: float = 10.0

    def __call__(self, rides: Batch) -> float:
        """The number for these rides; smaller is better."""
        return (
            self.effort_per_nm * effort_nm(rides)
            + self.energy_per_wh_km * energy_wh_per_km(rides)
            + self.fall * float(np.mean(rides["fell"]))
        )


def effort_nm(rides: Batch) -> float:
    """Rider's effort.

    Parameters
    ----------
    rides : Batch
        Rides.

    Returns
    -------
    float
        Root mean square over all rides of the torque on the handlebar, Nm.
    """
    effort = rides["rider_effort_rms_nm"].astype(np.float64)
    return float(np.sqrt(np.mean(effort**2)))


def energy_wh_per_km(rides: Batch) -> float:
    """Energy.

    Parameters
    ----------
    rides : Batch
        Rides.

    Returns
    -------
    float
        Out of the battery, net, Wh/km.
    """
    joule = float(np.sum(rides["energy_j"].astype(np.float64)))
    metres = float(np.sum(rides["distance_m"].astype(np.float64)))
    return joule / 3.6 / max(metres, 1e-9)


@dataclass(frozen=True, eq=False)
class Trial:
    """One set of values that was ridden.

    Attributes
    ----------
    values : dict of str to float
        The values, by path.
    objective : float
        What the objective gave.
    effort_nm, energy_wh_per_km, fall_share : float
        Effort, energy, and share of rides that fell.
    """

    values: dict[str, float]
    objective: float
    effort_nm: float
    energy_wh_per_km: float
    fall_share: float


@dataclass(frozen=True, eq=False)
class Tuning(Drawn):
    """What tuning came to.

    Attributes
    ----------
    best : Trial
        The best set of values.
    trials : tuple of Trial
        Everything that was ridden, in order.
    """

    best: Trial
    trials: tuple[Trial, ...]

    @property
    def frontier(self) -> tuple[Trial, ...]:
        """Trials without more falls than the best, of which none has less effort for less energy."""
        fair = [t for t in self.trials if t.fall_share <= self.best.fall_share]
        fair.sort(key=lambda t: (t.energy_wh_per_km, t.effort_nm))
        chosen: list[Trial] = []
        for trial in fair:
            if not chosen or trial.effort_nm < chosen[-1].effort_nm:
                chosen.append(trial)
        return tuple(chosen)

    def _draw(self, ax: Any) -> None:
        """Effort over energy, the frontier as a line."""
        ax.plot([t.energy_wh_per_km for t in self.trials], [t.effort_nm for t in self.trials], ".", color="0.6")
        front = self.frontier
        ax.plot([t.energy_wh_per_km for t in front], [t.effort_nm for t in front], "o-", label="frontier")
        ax.set(xlabel="energy, Wh/km", ylabel="effort, Nm")

    def __repr__(self) -> str:
        b = self.best
        return (
            f"Tuning({len(self.trials)} trials, best: {b.values}, effort {b.effort_nm:.3g} Nm, "
            f"{b.energy_wh_per_km:.3g} Wh/km)"
        )

    def _repr_html_(self) -> str:
        front = self.frontier
        count = np.arange(len(self.trials), dtype=np.float64)
        best = np.minimum.accumulate([t.objective for t in self.trials])
        picture = _twinhub.line_chart(
            "Tuning",
            "trial",
            [("best objective so far", "", [("objective", count.tolist(), best.tolist())])],
        )
        if len(front) > 1:
            x, y = [t.energy_wh_per_km for t in front], [t.effort_nm for t in front]
            panel = [("effort on the frontier", "Nm", [("effort", x, y)])]
            picture += _twinhub.line_chart("Effort against energy", "energy, Wh/km", panel)
        rows = [(path, value) for path, value in self.best.values.items()]
        return picture + _html.table(("best", "value"), rows)


#: ``minimise(function, x0, bounds)``, coordinates from 0 to 1: as ``scipy.optimize.minimize`` and its
#: kin have it.
Minimiser: TypeAlias = Callable[..., object]


@dataclass
class _Bench:
    """Rides sets of values and remembers."""

    objective: Callable[[Batch], float]
    paths: list[str]
    low: npt.NDArray[np.float64]
    high: npt.NDArray[np.float64]
    ride: Callable[[Mapping[str, float]], Batch]
    most: int
    progress: Callable[[Trial], object] | None
    trials: list[Trial] = field(default_factory=list)

    def at(self, values: Mapping[str, float]) -> float:
        if len(self.trials) >= self.most:
            raise _Enough
        rides = self.ride(values)
        trial = Trial(
            dict(values),
            float(self.objective(rides)),
            effort_nm(rides),
            energy_wh_per_km(rides),
            float(np.mean(rides["fell"])),
        )
        if not np.isfinite(trial.objective):
            raise InputError(f"the objective gave {trial.objective} at {trial.values}; accepted: a finite number")
        self.trials.append(trial)
        if self.progress is not None:
            self.progress(trial)
        return trial.objective

    def cube(self, x: npt.ArrayLike) -> float:
        """The objective at a place of the unit cube."""
        share = np.clip(np.asarray(x, dtype=np.float64).ravel(), 0.0, 1.0)
        values = self.low + share * (self.high - self.low)
        return self.at(dict(zip(self.paths, values.tolist(), strict=True)))


class _Enough(Exception):
    """All trials are spent."""


def tune(
    objective: Callable[[Batch], float] | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    optimiser: object = None,
    course: NameOrPath | Course = "three_to_eight",
    start: Mapping[str, float] | None = None,
    set: Assignments | None = None,
    seeds: Iterable[int] = (1, 2, 3, 4),
    trials: int = 100,
    executor: Executor | None = None,
    progress: Callable[[Trial], object] | None = None,
    law: Law | NameOrPath | None = None,
    rider: Rider | NameOrPath | None = None,
    bicycle: Bicycle | NameOrPath | None = None,
) -> Tuning:
    """Find values of a stabilizer that make an objective small, on the same rides every time.

    Parameters
    ----------
    objective : callable, optional
        Takes the `Batch` of rides under a set of values and gives a number, smaller is better;
        `Weighted` if not given.
    bounds : mapping
        Least and greatest value by path, as for `ride`:
        ``{"law.law.scheduled.points.1.pair_nm": (0.0, 60.0)}``.
    optimiser : optional
        Anything of the ask-tell kind, with coordinates from 0 to 1 (``cma.CMAEvolutionStrategy``), an
        ``optuna`` study, or a callable ``minimise(function, x0, bounds)`` with coordinates from 0 to
        1 (``lambda f, x0, b: scipy.optimize.minimize(f, x0, bounds=b, method="Powell")``).
        Steps along the axes, halved where none helps, if not given.
    course : str, os.PathLike or Course
        As for `ride`.
    start : mapping, optional
        Values to begin with, by path; the middle of the bounds if not given. Ask-tell optimisers have
        their own start.
    set : mapping or list of str, optional
        Values of the course that stay, as for `ride`.
    seeds : iterable of int
        A ride for each; every set of values rides them all.
    trials : int
        Most sets of values to ride.
    executor : concurrent.futures.Executor, optional
        Where rides run; on all cores of this process if not given.
    progress : callable, optional
        Called with each `Trial`.
    law : Law, str or os.PathLike, optional
        A law in place of the course's: what is tuned.
    rider : Rider, str or os.PathLike, optional
        A rider in place of the course's.
    bicycle : Bicycle, str or os.PathLike, optional
        A multibody bicycle in place of the course's.

    Returns
    -------
    Tuning

    Raises
    ------
    InputError
        If an argument is wrong, or a value is none that the controller accepts.
    """
    if not bounds or not isinstance(bounds, Mapping):
        raise InputError(f"bounds={bounds!r}: accepted: a mapping from path to (least, greatest)")
    for path, pair in bounds.items():
        if not isinstance(pair, Sequence) or len(pair) != 2:
            raise InputError(f"bounds[{path!r}]={pair!r}: accepted: (least, greatest), finite and in that order")
        if not finite(f"bounds[{path!r}][0]", pair[0]) < finite(f"bounds[{path!r}][1]", pair[1]):
            raise InputError(f"bounds[{path!r}]={pair!r}: accepted: (least, greatest), finite and in that order")
    paths = list(bounds)
    low = np.array([bounds[path][0] for path in paths], dtype=np.float64)
    high = np.array([bounds[path][1] for path in paths], dtype=np.float64)
    if not isinstance(trials, Integral) or isinstance(trials, bool) or trials < 1:
        raise InputError(f"trials={trials!r}: accepted: an integer, 1 or more")
    if not isinstance(seeds, Iterable):
        raise InputError(f"seeds={seeds!r}: accepted: several seeds, as range(10)")
    x0 = np.full(len(paths), 0.5)
    if start is not None:
        missing = [path for path in paths if path not in start]
        if missing or len(start) != len(paths):
            raise InputError(f"start={dict(start)!r}: accepted: a value for each of {', '.join(paths)}")
        x0 = (np.array([start[path] for path in paths]) - low) / (high - low)
        if not ((x0 >= 0.0) & (x0 <= 1.0)).all():
            raise InputError(f"start={dict(start)!r}: accepted: values within the bounds")
    chosen, common = list(seeds), [*placed(law=law, rider=rider, bicycle=bicycle), *assignments(set)]
    if not chosen:
        raise InputError("seeds: none; accepted: several seeds, as range(10)")

    def ride(values: Mapping[str, float]) -> Batch:
        if executor is None:
            return batch(course, chosen, set=common, vary=[values])
        parts = list(executor.map(_ride_one, [(course, seed, common, dict(values)) for seed in chosen]))
        return Batch({name: np.concatenate([part[name] for part in parts]) for name in parts[0]})

    bench = _Bench(objective or Weighted(), paths, low, high, ride, int(trials), progress)
    try:
        _search(bench, optimiser, x0)
    except _Enough:
        pass
    if not bench.trials:
        raise InputError(f"optimiser={optimiser!r}: it asked for nothing; accepted: one that tries values")
    best = min(bench.trials, key=lambda trial: trial.objective)
    return Tuning(best, tuple(bench.trials))


def _compass(
    function: Callable[[npt.NDArray[np.float64]], float],
    x0: npt.NDArray[np.float64],
    bounds: Sequence[tuple[float, float]],
) -> None:
    """Steps along the axes, the last good direction first; halved where none helps."""
    x, step = np.array(x0, dtype=np.float64), 0.25
    best = function(x)
    axes = [sign * unit for unit in np.eye(len(x)) for sign in (1.0, -1.0)]
    while step > 1e-3:
        for k, axis in enumerate(axes):
            there = np.clip(x + step * axis, 0.0, 1.0)
            if (there != x).any() and (value := function(there)) < best:
                x, best = there, value
                axes.insert(0, axes.pop(k))
                break
        else:
            step *= 0.5


def _ride_one(job: tuple[NameOrPath | Course, int, Assignments | None, dict[str, float]]) -> dict[str, Any]:
    course, seed, values, vary = job
    return dict(batch(course, [seed], set=values, vary=[vary], workers=1))


def _one_of_optuna(bench: _Bench, trial: Any, tell: Callable[..., object]) -> None:
    try:
        values = {
            path: float(trial.suggest_float(path, a, b))
            for path, a, b in zip(bench.paths, bench.low, bench.high, strict=True)
        }
        found = bench.at(values)
    except BaseException:
        # Not left as one that still runs.
        from optuna.trial import TrialState

        tell(trial, state=TrialState.FAIL)
        raise
    tell(trial, found)


def _asked(asked: object, count: int) -> npt.NDArray[np.float64]:
    """Places that an optimiser asks for, shape (k, count)."""
    try:
        places = np.asarray(asked, dtype=np.float64)
    except (TypeError, ValueError):
        places = np.empty(0)
    if places.ndim != 2 or places.shape[0] == 0 or places.shape[1] != count or not np.isfinite(places).all():
        raise InputError(
            f"optimiser: ask() gave {asked!r}; accepted: a list of one or more places, each of {count} finite "
            "numbers from 0 to 1"
        )
    return places


def _search(bench: _Bench, optimiser: Any, x0: npt.NDArray[np.float64]) -> None:
    ask, tell = getattr(optimiser, "ask", None), getattr(optimiser, "tell", None)
    if callable(ask) and callable(tell):
        stop = getattr(optimiser, "stop", None)
        while len(bench.trials) < bench.most:
            asked = ask()
            if hasattr(asked, "suggest_float"):
                _one_of_optuna(bench, asked, tell)
                continue
            tell(asked, [bench.cube(x) for x in _asked(asked, len(bench.paths))])
            if callable(stop) and not hasattr(optimiser, "optimize_trials") and stop():
                break
        return
    minimise: Minimiser
    if optimiser is None:
        minimise = _compass
    elif callable(optimiser):
        minimise = optimiser
    else:
        raise InputError(
            f"optimiser={optimiser!r}: accepted: something with ask and tell, or minimise(function, x0, bounds)"
        )
    bounds: Sequence[tuple[float, float]] = [(0.0, 1.0)] * len(bench.paths)
    minimise(bench.cube, x0, bounds)
