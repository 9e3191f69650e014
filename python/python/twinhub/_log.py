"""Ride logs as numpy columns."""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, NoReturn

import numpy as np
import numpy.typing as npt

from . import _twinhub
from ._arguments import NameOrPath, name_or_path
from .errors import UnknownNameError


class Columns(dict[str, npt.NDArray[np.float64]]):
    """Columns of one topic: a dict from name to numpy array, all of the same length.

    Names carry their units (``"roll_rad"``); fields of nested messages are dotted
    (``"imu.gyro_rad_s.0"``). ``"t_s"``, the first, is the time at which each sample was taken, in
    seconds from the start of the ride. Integers are given as float64; the stamp of a sample that
    was never taken is NaN. ``pandas.DataFrame(columns)`` and ``polars.DataFrame(columns)`` take it
    as it is.
    """

    def __missing__(self, name: str) -> NoReturn:
        raise UnknownNameError(f"no column {name!r}; accepted: {', '.join(self)}")


@dataclass(frozen=True)
class Event:
    """Something that happened on a ride.

    Attributes
    ----------
    t_s : float
        When, s from the start of the ride.
    level : str
        ``"info"``, ``"warning"`` or ``"error"``.
    code : str
        Who says it, and what: ``"supervisor.mode"``.
    text : str
        A sentence.
    """

    t_s: float
    level: Literal["info", "warning", "error"]
    code: str
    text: str


@dataclass(frozen=True)
class Recovery:
    """How a log that has no proper end was read.

    Attributes
    ----------
    used_bytes, lost_bytes : int
        Bytes from the start of the file that were used, and bytes after them that were not.
    reason : str
        What stopped the reader.
    """

    used_bytes: int
    lost_bytes: int
    reason: str


class Log(Mapping[str, Columns]):
    """A ride log: a mapping from topic to columns.

    ``log["/plant/truth"]["roll_rad"]`` is a numpy array; `Columns` says more.

    Attributes
    ----------
    path : pathlib.Path or None
        The file; None if there is none any more.
    metadata : dict of str to dict of str to str
        ``"twinhub"``: version, git hash, config digest, seed, course, bicycle, rider, law;
        ``"twinhub_end"``: what came out.
    config : str or None
        The resolved configuration of the ride, TOML.
    digest : str
        Digest of the records as read, 32 hex characters.
    stated_digest : str or None
        The digest that the file states; None in a log that was cut off.
    recovery : Recovery or None
        Set if the file has no proper end; then everything up to its last whole chunk is here.
    events : tuple of Event
        What happened rarely: changes of mode, health flags, falls.
    texts : dict of str to list of (float, str)
        Topics in JSON, ``"/event"`` and ``"/scene"`` among them: time in s, and the JSON text.
    undecoded : dict of str to str
        Topics without columns, and why.
    attachments : dict of str to bytes
        Files in the log, the configuration among them.
    """

    def __init__(self, answer: "_twinhub._LogAnswer", path: Path | None) -> None:
        self.path = path
        self.metadata = answer["metadata"]
        self.config = answer["config"]
        self.digest = answer["digest"]
        self.stated_digest = answer["stated_digest"]
        recovery = answer["recovery"]
        self.recovery = None if recovery is None else Recovery(*recovery)
        self.texts = answer["texts"]
        self.undecoded = answer["undecoded"]
        self.attachments = answer["attachments"]
        self.events = tuple(_event(t_s, text) for t_s, text in self.texts.get("/event", []))
        self._topics = {topic: Columns(columns) for topic, columns in answer["topics"].items()}

    @property
    def recovered(self) -> bool:
        """True if the file has no proper end, and a part of the ride may be missing."""
        return self.recovery is not None

    def __getitem__(self, topic: str) -> Columns:
        try:
            return self._topics[topic]
        except KeyError:
            raise UnknownNameError(f"no topic {topic!r} with columns; accepted: {', '.join(self)}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._topics)

    def __len__(self) -> int:
        return len(self._topics)

    def __eq__(self, other: object) -> bool:
        return self is other

    def __hash__(self) -> int:
        return id(self)

    def __repr__(self) -> str:
        cut = ", recovered" if self.recovered else ""
        where = "" if self.path is None else f"{str(self.path)!r}, "
        return f"{type(self).__name__}({where}digest={self.digest!r}{cut}, topics: {', '.join(self)})"


def read_log(path: NameOrPath) -> Log:
    """Read a ride log (MCAP).

    A log that was cut off or damaged is read up to its last whole chunk, and ``log.recovery`` says
    so.

    Parameters
    ----------
    path : str or os.PathLike
        The file.

    Returns
    -------
    Log
        A mapping from topic to columns.

    Raises
    ------
    LogError
        If the file cannot be read, is no MCAP file, or nothing in it can be recovered.
    """
    file = name_or_path("path", path)
    return Log(_twinhub.read_log(file), Path(file))


_LEVELS: dict[int, Literal["info", "warning", "error"]] = {2: "info", 3: "warning", 4: "error"}


def _event(t_s: float, text: str) -> Event:
    try:
        fields = json.loads(text)
        return Event(
            t_s, _LEVELS.get(fields["level"], "info"), str(fields["name"]), str(fields["message"])
        )
    except (ValueError, KeyError, TypeError):
        # Not ours: the text as it is.
        return Event(t_s, "info", "", text)
