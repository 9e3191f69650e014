"""What the model gets wrong about measured rides, and why."""

import json
from collections.abc import Callable, Iterable
from html import escape
from typing import Any

from . import _html, _twinhub
from ._arguments import Assignments, NameOrPath, assignments, name_or_path
from ._things import Study, of
from .errors import InputError


class Diagnosis:
    """The answer of a diagnosis.

    Attributes
    ----------
    verdict : str
        One of the closed list: ``"no_effect"``, ``"tolerance"``, ``"cause"``, ``"causes"``,
        ``"partial"``, ``"unknown"``, ``"bad_data"``, ``"not_testable"``.
    statements : tuple of str
        The answer in sentences.
    answer : dict
        All of it, as ``twinhub diagnose --json`` prints it.
    extended_plant : str or None
        The extended plant, TOML: save it, and give its name as a bicycle.
    """

    def __init__(self, answer: dict[str, Any], extended_plant: str | None) -> None:
        self.answer = answer
        self.verdict = str(answer["verdict"])
        self.statements: tuple[str, ...] = tuple(answer.get("statements", ()))
        self.extended_plant = extended_plant

    @property
    def causes(self) -> list[dict[str, Any]]:
        """Causes that are named, with sizes and intervals."""
        causes: list[dict[str, Any]] = self.answer.get("causes", [])
        return causes

    @property
    def gain(self) -> dict[str, Any]:
        """What mending gains on rides that were held out, by channel."""
        gain: dict[str, Any] = self.answer.get("gain", {})
        return gain

    def __repr__(self) -> str:
        return f"Diagnosis({self.verdict!r}: {' '.join(self.statements)})"

    def _repr_html_(self) -> str:
        lines = "".join(f"<p>{escape(text)}</p>" for text in self.statements)
        rows = [
            (name, g.get("nominal_vaf"), g.get("calibrated_vaf"), g.get("extended_vaf"), g.get("ceiling_vaf"))
            for name, g in self.gain.items()
        ]
        columns = ("channel, VAF on held-out rides", "nominal", "calibrated", "extended", "ceiling")
        gain = _html.table(columns, rows) if rows else ""
        return f"<p><b>{escape(self.verdict)}</b></p>{lines}{gain}"


class Experiment:
    """What rides like those of a study could show.

    Attributes
    ----------
    answer : dict
        All of it, as ``twinhub experiment --json`` prints it.
    """

    def __init__(self, answer: dict[str, Any]) -> None:
        self.answer = answer

    @property
    def visible(self) -> list[dict[str, Any]]:
        """Mechanisms that would show, with the smallest size that would."""
        visible: list[dict[str, Any]] = self.answer["visible"]
        return visible

    @property
    def pairs(self) -> list[dict[str, Any]]:
        """Pairs of mechanisms that could hardly be told apart."""
        pairs: list[dict[str, Any]] = self.answer["pairs"]
        return pairs

    def __repr__(self) -> str:
        return f"Experiment({len(self.visible)} visible, {len(self.pairs)} pairs hardly told apart)"

    def _repr_html_(self) -> str:
        rows = [(v["mechanism"], v["parameter"], v["smallest"]) for v in self.visible]
        return _html.table(("mechanism", "parameter", "smallest size that shows"), rows)


def diagnose(
    study: NameOrPath | Study,
    data: NameOrPath | None = None,
    set: Assignments | None = None,
    without: Iterable[str] = (),
    only: Iterable[str] = (),
    progress: Callable[[str], object] | None = None,
) -> Diagnosis:
    """Say what the model of a study gets wrong about its measured rides, why, and what mending gains.

    Parameters
    ----------
    study : str, os.PathLike or Study
        A study ``.toml``, or the name of one that ships (``twinhub list studies``).
    data : str or os.PathLike, optional
        Folder that holds the rides, after the study's own folder.
    set : mapping or list of str, optional
        Keys of the study to change.
    without : iterable of str
        Mechanisms to leave out.
    only : iterable of str
        Mechanisms to look for, and no others.
    progress : callable, optional
        Called with a sentence now and then.

    Returns
    -------
    Diagnosis

    Raises
    ------
    InputError
        If the study or a ride is wrong; the message says where.
    """
    name, changes = of("study", study)
    text, plant = _twinhub.diagnose(
        name,
        None if data is None else name_or_path("data", data),
        [*changes, *assignments(set)],
        _names("without", without),
        _names("only", only),
        progress,
    )
    return Diagnosis(json.loads(text), plant)


def experiment(
    study: NameOrPath | Study,
    data: NameOrPath | None = None,
    set: Assignments | None = None,
    progress: Callable[[str], object] | None = None,
) -> Experiment:
    """Say which causes rides like those of a study could show at all, and which not apart.

    Parameters
    ----------
    study : str, os.PathLike or Study
        As for `diagnose`.
    data : str or os.PathLike, optional
        As for `diagnose`.
    set : mapping or list of str, optional
        As for `diagnose`.
    progress : callable, optional
        Called with a sentence now and then.

    Returns
    -------
    Experiment

    Raises
    ------
    InputError
        If the study or a ride is wrong; the message says where.
    """
    name, changes = of("study", study)
    text = _twinhub.experiment(
        name,
        None if data is None else name_or_path("data", data),
        [*changes, *assignments(set)],
        progress,
    )
    return Experiment(json.loads(text))


def _names(argument: str, values: Iterable[str]) -> list[str]:
    names = [] if isinstance(values, str) else list(values)
    if isinstance(values, str) or not all(isinstance(name, str) for name in names):
        raise InputError(f"{argument}={values!r}: accepted: a list of names of mechanisms")
    return names
