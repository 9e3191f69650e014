"""What goes into a controller and what comes out."""

import math
from dataclasses import dataclass, field
from typing import NamedTuple

from ._log import Columns

#: Stamp of a sample that was never taken, ns.
NEVER_NS = 2**64 - 1


@dataclass(frozen=True)
class ImuSample:
    """Inertial measurement unit on the rear frame, body axes (x forward, y right, z down).

    Attributes
    ----------
    stamp_ns : int
        When the sample was taken, ns of ride time; `NEVER_NS` for never.
    gyro_rad_s : tuple of float
        Rates about x, y, z, rad/s.
    accel_m_s2 : tuple of float
        Specific force along x, y, z, m/s^2.
    """

    stamp_ns: int = NEVER_NS
    gyro_rad_s: tuple[float, float, float] = (0.0, 0.0, 0.0)
    accel_m_s2: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class RollSample:
    """Measured roll, where a sensor for it exists.

    Attributes
    ----------
    stamp_ns : int
        When the sample was taken, ns of ride time.
    roll_rad, roll_rate_rad_s : float
        Roll, rad, and its rate, rad/s; a rate of NaN is none.
    """

    stamp_ns: int = NEVER_NS
    roll_rad: float = 0.0
    roll_rate_rad_s: float = 0.0


@dataclass(frozen=True)
class SteerSample:
    """Steer encoder.

    Attributes
    ----------
    stamp_ns : int
        When the sample was taken, ns of ride time.
    steer_rad, steer_rate_rad_s : float
        Steer angle, rad, and its rate, rad/s; a rate of NaN is none.
    """

    stamp_ns: int = NEVER_NS
    steer_rad: float = 0.0
    steer_rate_rad_s: float = 0.0


@dataclass(frozen=True)
class WheelSample:
    """Wheel-speed sensors.

    Attributes
    ----------
    stamp_ns : int
        When the sample was taken, ns of ride time.
    front_rad_s, rear_rad_s : float
        Wheel rates, forward positive, rad/s.
    speed_m_s : float
        Forward speed of the bicycle's own speedometer, m/s.
    """

    stamp_ns: int = NEVER_NS
    front_rad_s: float = 0.0
    rear_rad_s: float = 0.0
    speed_m_s: float = 0.0


@dataclass(frozen=True)
class MotorSample:
    """What the motor drives report.

    Attributes
    ----------
    stamp_ns : int
        When the sample was taken, ns of ride time.
    front_brake_nm, rear_traction_nm : float
        Torques from the drives' currents, Nm.
    bus_v, bus_a : float
        Bus voltage, V, and current out of the battery, A.
    winding_celsius : float
        Hottest winding, degrees Celsius.
    """

    stamp_ns: int = NEVER_NS
    front_brake_nm: float = 0.0
    rear_traction_nm: float = 0.0
    bus_v: float = 0.0
    bus_a: float = 0.0
    winding_celsius: float = 0.0


@dataclass(frozen=True)
class Measurement:
    """Everything that the controller is told about the bicycle in one tick.

    Attributes
    ----------
    imu : ImuSample
        Inertial measurement unit.
    roll : RollSample
        Measured roll.
    steer : SteerSample
        Steer encoder.
    wheels : WheelSample
        Wheel speeds.
    motors : MotorSample
        Motor drives.
    """

    imu: ImuSample = field(default_factory=ImuSample)
    roll: RollSample = field(default_factory=RollSample)
    steer: SteerSample = field(default_factory=SteerSample)
    wheels: WheelSample = field(default_factory=WheelSample)
    motors: MotorSample = field(default_factory=MotorSample)


@dataclass(frozen=True)
class RiderIntent:
    """What the rider wants, from levers, pedals and the switch on the bar.

    Attributes
    ----------
    stamp_ns : int
        When it was read, ns of ride time.
    assist_on, pedalling : bool
        The switch is on; the pedals are driven forward.
    front_brake_ratio, rear_brake_ratio : float
        Brake levers, 0 released to 1 fully pulled.
    pedal_nm, cadence_rad_s : float
        Torque at the crank, Nm, and its rate, rad/s.
    """

    stamp_ns: int = NEVER_NS
    assist_on: bool = False
    pedalling: bool = False
    front_brake_ratio: float = 0.0
    rear_brake_ratio: float = 0.0
    pedal_nm: float = 0.0
    cadence_rad_s: float = 0.0


class Estimate(NamedTuple):
    """What the controller believes about the bicycle.

    Attributes
    ----------
    roll_rad, roll_rate_rad_s : float
        Roll, rad, and its rate, rad/s.
    steer_rad, steer_rate_rad_s : float
        Steer, rad, and its rate, rad/s.
    speed_m_s : float
        Forward speed, m/s.
    yaw_rate_rad_s : float
        Yaw rate, rad/s.
    roll_sd_rad, speed_sd_m_s : float
        One standard deviation of roll, rad, and of speed, m/s.
    """

    roll_rad: float
    roll_rate_rad_s: float
    steer_rad: float
    steer_rate_rad_s: float
    speed_m_s: float
    yaw_rate_rad_s: float
    roll_sd_rad: float
    speed_sd_m_s: float


@dataclass(frozen=True)
class Output:
    """What the controller says in one tick.

    Attributes
    ----------
    front_brake_nm, rear_traction_nm : float
        Torques of the motors, Nm.
    demand_nm : float
        Pair that the law asked for before limits, Nm.
    mode : str
        ``"off"``, ``"ready"``, ``"active"``, ``"degraded"`` or ``"fault"``.
    health, limited_by : tuple of str
        Flags that are raised, and what held the command back.
    estimate : Estimate
        The state that the command rests on.
    """

    front_brake_nm: float
    rear_traction_nm: float
    demand_nm: float
    mode: str
    health: tuple[str, ...]
    limited_by: tuple[str, ...]
    estimate: Estimate


class Known(NamedTuple):
    """A quantity that is believed.

    Attributes
    ----------
    value : float
        The value, in the unit of its name.
    sd : float
        One standard deviation.
    age_s : float
        Age of the reading that it rests on, s; infinite if it was never measured.
    """

    value: float
    sd: float
    age_s: float


def _stamp(columns: Columns, name: str, i: int) -> int:
    value = float(columns[name][i])
    return NEVER_NS if math.isnan(value) else int(value)


def measurement(c: Columns, i: int) -> Measurement:
    """What the sensors said in row `i` of a log's measurements."""

    def at(name: str) -> float:
        return float(c[name][i])

    return Measurement(
        ImuSample(
            _stamp(c, "imu.stamp_ns", i),
            (at("imu.gyro_rad_s.0"), at("imu.gyro_rad_s.1"), at("imu.gyro_rad_s.2")),
            (at("imu.accel_m_s2.0"), at("imu.accel_m_s2.1"), at("imu.accel_m_s2.2")),
        ),
        RollSample(_stamp(c, "roll.stamp_ns", i), at("roll.roll_rad"), at("roll.roll_rate_rad_s")),
        SteerSample(_stamp(c, "steer.stamp_ns", i), at("steer.steer_rad"), at("steer.steer_rate_rad_s")),
        WheelSample(
            _stamp(c, "wheels.stamp_ns", i),
            at("wheels.front_rad_s"),
            at("wheels.rear_rad_s"),
            at("wheels.speed_m_s"),
        ),
        MotorSample(
            _stamp(c, "motors.stamp_ns", i),
            at("motors.front_brake_nm"),
            at("motors.rear_traction_nm"),
            at("motors.bus_v"),
            at("motors.bus_a"),
            at("motors.winding_celsius"),
        ),
    )


def intent(c: Columns, i: int) -> RiderIntent:
    """What the rider wanted in row `i` of a log's intents."""
    return RiderIntent(
        _stamp(c, "stamp_ns", i),
        bool(c["assist_on"][i]),
        bool(c["pedalling"][i]),
        float(c["front_brake_ratio"][i]),
        float(c["rear_brake_ratio"][i]),
        float(c["pedal_nm"][i]),
        float(c["cadence_rad_s"][i]),
    )
