from typing import Final, Literal, TypedDict, type_check_only

import numpy as np
import numpy.typing as npt

__all__ = [
    "__version__",
    "bicycles",
    "courses",
    "modes",
    "parameter_units",
    "parameters",
    "read_log",
    "ride",
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
    rider_effort_rms_nm: float
    energy_j: float
    distance_m: float
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
def ride(course: str, stabilizer: bool, assignments: list[str], log: str | None) -> _RideAnswer: ...
def read_log(path: str) -> _LogAnswer: ...
