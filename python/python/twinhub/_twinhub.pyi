from collections.abc import Callable, Mapping
from typing import Any, Final, Literal, TypedDict, final, type_check_only

import numpy as np
import numpy.typing as npt

__all__ = [
    "_Controller",
    "_Stepper",
    "_Stop",
    "__version__",
    "batch",
    "bicycles",
    "courses",
    "design",
    "diagnose",
    "experiment",
    "frontier_picture",
    "gradients",
    "law_kinds",
    "laws",
    "league_part",
    "league_spec",
    "league_table",
    "line_chart",
    "linearise",
    "modes",
    "parameter_units",
    "parameters",
    "read_log",
    "ride",
    "rider_growth",
    "simulate",
    "stability_map",
    "thing_names",
    "thing_toml",
    "tyre_forces",
]

__version__: Final[str]

_Verdict = Literal["crosses", "always_stable", "always_unstable"]

@type_check_only
class _ModesAnswer(TypedDict):
    bicycle: str
    source: str
    remarks: list[str]
    front_brake_nm: float
    rear_traction_nm: float
    longitudinal_accel_m_s2: float
    speed_m_s: npt.NDArray[np.float64]
    eigenvalues: npt.NDArray[np.complex128]
    names: list[str]
    weave_speed_m_s: float | None
    capsize_speed_m_s: float | None
    weave: _Verdict
    capsize: _Verdict
    stable_ranges_m_s: npt.NDArray[np.float64]
    crossings: list[tuple[float, str, Literal["divergence", "oscillation"], bool]]

@type_check_only
class _LogAnswer(TypedDict):
    topics: dict[str, dict[str, npt.NDArray[np.float64]]]
    texts: dict[str, list[tuple[float, str]]]
    undecoded: dict[str, str]
    metadata: dict[str, dict[str, str]]
    attachments: dict[str, bytes]
    config: str | None
    recovery: tuple[int, int, str] | None
    digest: str
    stated_digest: str | None

@type_check_only
class _MetricsAnswer(TypedDict):
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

@type_check_only
class _RideAnswer(_LogAnswer):
    metrics: _MetricsAnswer
    course: str
    seed: int

def bicycles() -> list[str]: ...
def parameter_units() -> dict[str, str]: ...
def parameters(bicycle: str, assignments: list[str]) -> dict[str, float]: ...
def modes(
    bicycle: str,
    torque_nm: float,
    speeds_m_s: npt.NDArray[np.float64],
    rear_torque_nm: float | None,
    assignments: list[str],
) -> _ModesAnswer: ...
def courses() -> list[str]: ...
def ride(
    course: str,
    stabilizer: bool,
    assignments: list[str],
    log: str | None,
    law: Callable[[tuple[float, ...], float], object] | None,
    rider: Callable[[tuple[float, ...], float], object] | None,
) -> _RideAnswer: ...
def batch(
    rides: list[tuple[str, bool, list[str]]],
    workers: int | None,
    progress: Callable[[int, int], object] | None,
) -> dict[str, npt.NDArray[Any]]: ...
def laws() -> list[str]: ...
def law_kinds() -> list[str]: ...
def linearise(
    bicycle: str, speed_m_s: float, torque_nm: float, assignments: list[str]
) -> dict[str, Any]: ...
def gradients(
    bicycle: str, speed_m_s: float, torque_nm: float, mode: str, assignments: list[str]
) -> dict[str, Any]: ...
def design(ask: str, progress: Callable[[str], object] | None) -> tuple[str, str, str]: ...
def diagnose(
    study: str,
    data: str | None,
    assignments: list[str],
    without: list[str],
    only: list[str],
    progress: Callable[[str], object] | None,
) -> tuple[str, str | None]: ...
def experiment(
    study: str, data: str | None, assignments: list[str], progress: Callable[[str], object] | None
) -> str: ...
def league_spec(
    seed: int,
    riders: int,
    classes: list[str],
    duration_s: float,
    controllers: list[tuple[str, str]],
    profile: str | None,
) -> str: ...
@final
class _Stop:
    def __new__(cls) -> _Stop: ...
    def set(self) -> None: ...

def league_part(
    spec: str,
    part: int,
    laws: dict[str, Callable[[], Callable[[tuple[float, ...], float], object]]],
    stop: _Stop | None,
    rider: Callable[[], Callable[[tuple[float, ...], float], tuple[float, float]]] | None,
) -> str: ...
def league_table(spec: str, parts: list[str]) -> str: ...
def stability_map(
    bicycle: str, speeds_m_s: list[float], torques_nm: list[float], assignments: list[str], workers: int
) -> dict[str, Any]: ...
def thing_names(kind: str) -> list[str]: ...
def thing_toml(kind: str, name: str, assignments: list[str]) -> str: ...
def rider_growth(
    rider: str, bicycle: str, assignments: list[str], speeds_m_s: list[float], pair_nm: float
) -> dict[str, npt.NDArray[np.float64]]: ...
def tyre_forces(
    tyre: str,
    load_n: list[float],
    slip_angle_rad: list[float],
    camber_rad: list[float],
    slip_ratio: list[float],
    friction_ratio: float,
    radius_m: float,
    speed_m_s: float,
) -> dict[str, npt.NDArray[np.float64]]: ...
def simulate(scenario: str, assignments: list[str]) -> tuple[dict[str, npt.NDArray[np.float64]], str]: ...
def line_chart(
    title: str,
    x_title: str,
    panels: list[tuple[str, str, list[tuple[str, list[float], list[float]]]]],
) -> str: ...
def frontier_picture(dots: list[tuple[str, float, float, bool]]) -> str: ...
@final
class _Controller:
    def __new__(cls, law: str, assignments: list[str]) -> _Controller: ...
    @staticmethod
    def of_ride(config: str) -> _Controller: ...
    def reset(self) -> None: ...
    def to_toml(self) -> str: ...
    def settled_nm(self, speed_m_s: float) -> list[float]: ...
    def step(
        self,
        t_ns: int,
        imu: tuple[int, tuple[float, float, float], tuple[float, float, float]],
        roll: tuple[int, float, float],
        steer: tuple[int, float, float],
        wheels: tuple[int, float, float, float],
        motors: tuple[int, float, float, float, float, float],
        intent: tuple[int, bool, bool, float, float, float, float],
    ) -> tuple[float, float, float, str, list[str], list[str], list[float]]: ...
    def belief(self) -> list[tuple[str, float, float, float]]: ...

@final
class _Stepper:
    def __new__(cls, course: str, stabilizer: bool, assignments: list[str]) -> _Stepper: ...
    def step(self, ticks: int, pair_nm: float | None) -> dict[str, Any]: ...
    def metrics(self) -> _MetricsAnswer: ...

def read_log(path: str) -> _LogAnswer: ...
