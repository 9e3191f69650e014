"""Bicycles, tyres, riders, motors, sensors, roads, winds, laws, courses, scenarios as objects."""

import json
import os
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar, TypeVar

import numpy as np
import numpy.typing as npt

from . import _twinhub
from ._arguments import Assignments, NameOrPath, assignments, finite, name_or_path, speeds
from ._log import Columns
from .errors import InputError, UnknownNameError

if sys.version_info >= (3, 11):
    import tomllib
else:  # pragma: no cover
    import tomli as tomllib

_Self = TypeVar("_Self", bound="Thing")


class Thing:
    """Something that has a name and a file: its values, with changes, from the same TOML as the command
    line.

    Parameters
    ----------
    name : str or os.PathLike
        A name that ships (see `names`), or a file.
    set : mapping or list of str, optional
        Values to change, by path.
    **values
        Values to change, dots of the path written as two underscores:
        ``Rider("older", rider__steer_torque__delay_s=0.25)``.

    Attributes
    ----------
    name : str
        The name or file that it began as.
    changes : list of str
        What was changed, ``path=value``.

    Raises
    ------
    InputError
        If there is no such thing, no such value, or a value is out of range.
    """

    kind: ClassVar[str] = ""

    def __init__(self, name: NameOrPath, set: Assignments | None = None, **values: object) -> None:
        if not self.kind:
            raise InputError(f"{type(self).__name__}: accepted: Bicycle, Tyre, Rider, Motors and their like")
        self.name = name_or_path("name", name)
        dotted = {path.replace("__", "."): value for path, value in values.items()}
        self.changes = [*assignments(set), *assignments(dotted)]
        self._toml = _twinhub.thing_toml(self.kind, self.name, self.changes)

    @classmethod
    def names(cls) -> list[str]:
        """Names of what ships."""
        return _twinhub.thing_names(cls.kind)

    def changed(self: _Self, set: Assignments | None = None, **values: object) -> _Self:
        """The same with further changes; this one stays as it is."""
        return type(self)(self.name, [*self.changes, *assignments(set)], **values)

    @property
    def values(self) -> dict[str, Any]:
        """All values, nested as in the file."""
        return tomllib.loads(self._toml)

    def __getitem__(self, path: str) -> Any:
        place: Any = self.values
        for part in path.split("."):
            if isinstance(place, list) and part.isdecimal() and int(part) < len(place):
                place = place[int(part)]
            elif isinstance(place, Mapping) and part in place:
                place = place[part]
            else:
                known = ", ".join(place) if isinstance(place, Mapping) else f"0 to {len(place) - 1}" if isinstance(place, list) else "nothing below a value"
                raise UnknownNameError(f"no {part!r} in {self.kind} {self.name!r}; accepted: {known}")
        return place

    def to_toml(self) -> str:
        """The file, TOML."""
        return self._toml

    def save(self, path: NameOrPath) -> Path:
        """Write the file; its path is a name wherever one is accepted.

        Parameters
        ----------
        path : str or os.PathLike
            The file.

        Returns
        -------
        pathlib.Path
            The same.
        """
        file = Path(os.fspath(path))
        file.write_text(self.to_toml(), encoding="utf-8")
        return file

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and isinstance(other, Thing) and self._toml == other._toml

    def __hash__(self) -> int:
        return hash(self._toml)

    def __repr__(self) -> str:
        changes = "".join(f", {change}" for change in self.changes)
        return f"{type(self).__name__}({self.name!r}{changes})"


class Course(Thing):
    """A course: speed, bicycle, road, wind, rider, law, motors, sensors, disturbances, seed."""

    kind = "course"


class Law(Thing):
    """A law file: profile, limits, law. `Controller` runs it."""

    kind = "law"


class Motors(Thing):
    """Motor drives and battery."""

    kind = "motors"


class Sensors(Thing):
    """A suite of sensors, and what is wrong with them."""

    kind = "sensors"


class Road(Thing):
    """A road: friction, slope, bank, patches, bumps."""

    kind = "road"


class Wind(Thing):
    """A wind, with gusts."""

    kind = "wind"


class Bicycle(Thing):
    """A bicycle, of the benchmark or of the multibody model."""

    kind = "bicycle"


class Rider(Thing):
    """A rider: channels with delay, muscles, gains over speed, noise; pedals."""

    kind = "rider"

    def growth(
        self,
        bicycle: NameOrPath | Bicycle = "bulsink2017_bicycle1_full",
        speeds_m_s: npt.ArrayLike | None = None,
        pair_nm: float = 0.0,
    ) -> Columns:
        """Does this rider keep a bicycle up?

        Parameters
        ----------
        bicycle : str, os.PathLike or Bicycle
            A multibody bicycle.
        speeds_m_s : array_like, shape (n,), optional
            Speeds, m/s; 3 to 8 m/s in steps of 0.5 if not given.
        pair_nm : float
            Pair of motor torques, Nm.

        Returns
        -------
        Columns
            ``speed_m_s``; ``growth_1_s``, of the fastest growing mode of the closed loop with its exact
            delay: negative stays up; ``frequency_rad_s``, its frequency. Shape (n,) each.
        """
        name, changes = of("bicycle", bicycle)
        v = speeds(np.arange(3.0, 8.01, 0.5) if speeds_m_s is None else speeds_m_s)
        return Columns(
            _twinhub.rider_growth(self._toml, name, changes, v.tolist(), finite("pair_nm", pair_nm))
        )


class Tyre(Thing):
    """A tyre."""

    kind = "tyre"

    def forces(
        self,
        slip_angle_rad: npt.ArrayLike = 0.0,
        camber_rad: npt.ArrayLike = 0.0,
        slip_ratio: npt.ArrayLike = 0.0,
        load_n: npt.ArrayLike = 400.0,
        friction_ratio: float = 1.0,
        radius_m: float = 0.35,
        speed_m_s: float = 5.0,
    ) -> Columns:
        """Forces and torques at the contact, ISO axes.

        Parameters
        ----------
        slip_angle_rad, camber_rad, slip_ratio, load_n : array_like
            Slip angle, camber, longitudinal slip (driving positive), load, N; broadcast against each
            other.
        friction_ratio : float
            Friction of the road.
        radius_m : float
            Radius of the wheel, m.
        speed_m_s : float
            Forward speed, m/s.

        Returns
        -------
        Columns
            ``longitudinal_n``, ``lateral_n``, ``overturning_nm``, ``rolling_resistance_nm``,
            ``aligning_nm``, of the broadcast shape.
        """
        try:
            arrays = np.broadcast_arrays(
                *(np.asarray(x, dtype=np.float64) for x in (load_n, slip_angle_rad, camber_rad, slip_ratio))
            )
        except (ValueError, TypeError) as error:
            raise InputError(f"forces: {error}; accepted: numbers, arrays of shapes that broadcast") from None
        if not all(np.isfinite(a).all() for a in arrays) or (arrays[0] < 0.0).any():
            raise InputError("forces: accepted: finite numbers, load_n 0 or more")
        load, angle, camber, slip = (a.ravel().tolist() for a in arrays)
        found = _twinhub.tyre_forces(
            self._toml,
            load,
            angle,
            camber,
            slip,
            finite("friction_ratio", friction_ratio),
            finite("radius_m", radius_m),
            finite("speed_m_s", speed_m_s),
        )
        return Columns({name: values.reshape(arrays[0].shape) for name, values in found.items()})


class Scenario(Thing):
    """An open-loop run of the multibody bicycle."""

    kind = "scenario"

    def run(self) -> "Run":
        """Run it.

        Returns
        -------
        Run
            Rows as columns, and what it came to.
        """
        columns, summary = _twinhub.simulate(self.name, self.changes)
        return Run(columns, json.loads(summary))


class Study(Thing):
    """A study: a bicycle with tolerances, and measured rides. `diagnose` and `experiment` take it.

    Its `values` are those of the file; changes hold where it is used.
    """

    kind = "study"

    def to_toml(self) -> str:
        """The file, TOML; refused if there are changes, which it would not hold."""
        if self.changes:
            raise InputError(
                f"{self!r}: its changes hold where it is used and stand in no file; accepted: a study without changes"
            )
        return super().to_toml()

    def __eq__(self, other: object) -> bool:
        return super().__eq__(other) and isinstance(other, Study) and self.changes == other.changes

    def __hash__(self) -> int:
        return hash((self._toml, *self.changes))


class Run(Columns):
    """Rows of an open-loop run, a column for each quantity.

    Attributes
    ----------
    summary : dict
        What it came to: ``fell``, largest angles, energies.
    """

    def __init__(self, columns: Mapping[str, npt.NDArray[np.float64]], summary: dict[str, Any]) -> None:
        super().__init__(columns)
        self.summary = summary


#: Where each kind of thing stands in a course: what names it, and what its values begin with.
_PLACES = {
    "rider": ("rider", "rider."),
    "law": ("law", "law."),
    "motors": ("motors", "motors."),
    "sensors": ("sensors", "sensors."),
    "road": ("plant.multibody.road", "plant.multibody.road."),
    "wind": ("plant.multibody.wind", "plant.multibody.wind."),
    "bicycle": ("plant.multibody.bicycle", "plant.multibody.set."),
}


def of(kind: str, value: "NameOrPath | Thing") -> tuple[str, list[str]]:
    """Name and changes of a thing, or a name."""
    if isinstance(value, Thing):
        if value.kind != kind:
            raise InputError(f"{kind}={value!r}: accepted: a {kind}")
        return value.name, value.changes
    return name_or_path(kind, value), []


def placed(**things: object) -> list[str]:
    """The assignments that put things into a course, by kind; None leaves the course's."""
    return [text for kind, value in things.items() if value is not None for text in _placed(kind, value)]


def _placed(kind: str, value: object) -> list[str]:
    if not isinstance(value, str | os.PathLike | Thing):
        raise InputError(f"{kind}={value!r}: accepted: a {kind}, a name or a path")
    name, changes = of(kind, value)
    place, prefix = _PLACES[kind]
    return [f"{place}={json.dumps(name)}", *(prefix + change for change in changes)]
