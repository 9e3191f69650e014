"""Checks of arguments, with errors that name the argument."""

import json
import os
from collections.abc import Iterable, Mapping
from numbers import Integral, Real
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from .errors import InputError

#: A name, or a file.
NameOrPath: TypeAlias = str | os.PathLike[str]

#: ``{"path": value}``, or ``["path=value", ...]`` as on the command line.
Assignments: TypeAlias = Mapping[str, object] | Iterable[str]


def name_or_path(argument: str, value: NameOrPath) -> str:
    """The text of a name or of a path."""
    if isinstance(value, str):
        return value
    if isinstance(value, os.PathLike):
        path = os.fspath(value)
        if isinstance(path, str):
            return path
    raise InputError(f"{argument}={value!r}: accepted: a name or a path, as str or os.PathLike")


def finite(argument: str, value: float) -> float:
    """A finite number."""
    if isinstance(value, Real) and not isinstance(value, bool | np.bool_):
        try:
            found = float(value)
        except OverflowError:
            found = float("inf")
        if np.isfinite(found):
            return found
    raise InputError(f"{argument}={value!r}: accepted: a finite number")


def switch(argument: str, value: bool) -> bool:
    """True or false, and nothing that only behaves like it (``"off"`` is true in Python)."""
    if isinstance(value, bool | np.bool_):
        return bool(value)
    raise InputError(f"{argument}={value!r}: accepted: True or False")


def workers_of(value: int | None) -> int:
    """A number of threads; that of the cores for None."""
    if value is None:
        return os.cpu_count() or 1
    if isinstance(value, Integral) and not isinstance(value, bool) and 1 <= value <= 1024:
        return int(value)
    raise InputError(f"workers={value!r}: accepted: 1 to 1024")


def seed_text(value: int) -> str:
    """The assignment of a seed."""
    if isinstance(value, Integral) and not isinstance(value, bool) and 0 <= value < 2**63:
        return f"seed={int(value)}"
    raise InputError(f"seed={value!r}: accepted: an integer from 0 to 2**63 - 1")


#: Most speeds in one request, as on the command line.
_MOST_SPEEDS = 100_000
#: Above any bicycle; beyond it, following the modes from speed to speed would have to be coarse.
_MOST_SPEED_M_S = 1000.0


def speeds(values: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Speeds as a contiguous array, shape (n,), every one of them finite and in range."""
    accepted = (
        f"accepted: a one-dimensional array of 1 to {_MOST_SPEEDS} finite speeds, "
        f"0 to {_MOST_SPEED_M_S:g} m/s"
    )
    try:
        found = np.asarray(values)
    except ValueError as error:
        raise InputError(f"speeds_m_s: {error}; {accepted}") from None
    if found.dtype.kind not in "iuf":
        raise InputError(f"speeds_m_s has the dtype {found.dtype}; {accepted}")
    if found.ndim != 1 or not 1 <= found.size <= _MOST_SPEEDS:
        raise InputError(f"speeds_m_s has the shape {found.shape}; {accepted}")
    array = np.ascontiguousarray(found, dtype=np.float64)
    wrong = np.flatnonzero(~((array >= 0.0) & (array <= _MOST_SPEED_M_S)))
    if wrong.size:
        raise InputError(f"speeds_m_s[{wrong[0]}] is {array[wrong[0]]}; {accepted}")
    return array


def assignments(values: Assignments | None) -> list[str]:
    """``path=value`` texts, the values as TOML."""
    if values is None:
        return []
    if isinstance(values, Mapping):
        return [f"{path}={_toml(path, value)}" for path, value in values.items()]
    if not isinstance(values, str) and isinstance(values, Iterable):
        texts = list(values)
        if all(isinstance(text, str) for text in texts):
            return texts
    raise InputError(
        f"set={values!r}: accepted: a mapping such as {{'duration_s': 20.0}}, or a list such as "
        "['duration_s=20.0']"
    )


def _toml(path: str, value: Any) -> str:
    if isinstance(value, bool | np.bool_):
        return "true" if value else "false"
    if isinstance(value, Integral):
        return str(int(value))
    if isinstance(value, Real):
        return repr(float(value))
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, os.PathLike):
        return _toml(path, os.fspath(value))
    if isinstance(value, Mapping):
        inner = (f"{_toml(path, str(key))} = {_toml(path, item)}" for key, item in value.items())
        return f"{{ {', '.join(inner)} }}"
    if isinstance(value, list | tuple | np.ndarray):
        return f"[{', '.join(_toml(path, item) for item in value)}]"
    raise InputError(
        f"set: {path!r} is {value!r}; accepted: a bool, a number, a str, a path, or lists and "
        "mappings of these"
    )
