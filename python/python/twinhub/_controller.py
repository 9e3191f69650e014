"""The stabilizer itself, tick by tick."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple, TypeAlias

import numpy as np

from . import _twinhub
from ._arguments import Assignments, NameOrPath, assignments
from ._log import Columns, Log
from ._things import Law, of
from .errors import InputError

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


#: A law written in Python: `Estimate` and the time since the last tick (s) in; the pair (Nm) out, or
#: the pair and the rear trim (Nm).
LawFunction: TypeAlias = Callable[[Estimate, float], float | tuple[float, float]]


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


def laws() -> list[str]:
    """Names of the law files that ship.

    Returns
    -------
    list of str
        As `Controller` and `league` take them.
    """
    return _twinhub.laws()


class Controller:
    """The stabilizer: the code that the firmware runs, bit for bit.

    Parameters
    ----------
    law : Law, str or os.PathLike
        A law that ships (see `laws`), or a law ``.toml``.
    set : mapping or list of str, optional
        Values to change, by their path in the law file: ``{"limits.torque_max_nm": 30.0}``.

    Raises
    ------
    InputError
        If the law cannot be read or breaks a rule.

    Examples
    --------
    >>> import twinhub
    >>> controller = twinhub.Controller("scheduled")
    >>> controller.step(0, twinhub.Measurement(), twinhub.RiderIntent()).front_brake_nm
    0.0
    """

    def __init__(self, law: NameOrPath | Law = "scheduled", set: Assignments | None = None) -> None:
        name, changes = of("law", law)
        self._inner = _twinhub._Controller(name, [*changes, *assignments(set)])

    @classmethod
    def of(cls, log: Log) -> "Controller":
        """The controller that a logged ride was ridden with.

        Parameters
        ----------
        log : Log
            A ride, or the log of one.

        Returns
        -------
        Controller
            At rest.

        Raises
        ------
        InputError
            If the log has no configuration.
        """
        if log.config is None:
            raise InputError("this log has no configuration; accepted: a log of twinhub")
        controller = cls.__new__(cls)
        controller._inner = _twinhub._Controller.of_ride(log.config)
        return controller

    def reset(self) -> None:
        """Come to rest again, as if never stepped."""
        self._inner.reset()

    def to_toml(self) -> str:
        """The law file, TOML."""
        return self._inner.to_toml()

    def settled_nm(self, speed_m_s: float) -> tuple[float, float]:
        """Least and most pair that the law settles at, upright at a speed, before limits, Nm."""
        low, high = self._inner.settled_nm(speed_m_s)
        return low, high

    def step(self, t_ns: int, measurement: Measurement, intent: RiderIntent) -> Output:
        """One tick: what the motors should do, given what the sensors and the rider say.

        Parameters
        ----------
        t_ns : int
            Ride time, ns; all stamps share its clock. Ticks are 1 ms apart.
        measurement : Measurement
            What the sensors say. Any value is accepted: what is missing, stale or absurd raises a
            health flag and ramps the torque.
        intent : RiderIntent
            What the rider wants.

        Returns
        -------
        Output
        """
        m = measurement
        if not (isinstance(m, Measurement) and isinstance(intent, RiderIntent)):
            raise InputError(
                f"step({t_ns!r}, {type(m).__name__}, {type(intent).__name__}): accepted: t_ns, a "
                "Measurement, a RiderIntent"
            )
        try:
            front, rear, demand, mode, health, limited_by, x = self._inner.step(
                t_ns,
                (m.imu.stamp_ns, m.imu.gyro_rad_s, m.imu.accel_m_s2),
                (m.roll.stamp_ns, m.roll.roll_rad, m.roll.roll_rate_rad_s),
                (m.steer.stamp_ns, m.steer.steer_rad, m.steer.steer_rate_rad_s),
                (m.wheels.stamp_ns, m.wheels.front_rad_s, m.wheels.rear_rad_s, m.wheels.speed_m_s),
                (
                    m.motors.stamp_ns,
                    m.motors.front_brake_nm,
                    m.motors.rear_traction_nm,
                    m.motors.bus_v,
                    m.motors.bus_a,
                    m.motors.winding_celsius,
                ),
                (
                    intent.stamp_ns,
                    intent.assist_on,
                    intent.pedalling,
                    intent.front_brake_ratio,
                    intent.rear_brake_ratio,
                    intent.pedal_nm,
                    intent.cadence_rad_s,
                ),
            )
        except (TypeError, ValueError, OverflowError) as error:
            raise InputError(f"step: {error}; accepted: numbers, stamps from 0 to 2**64 - 1") from None
        return Output(
            front, rear, demand, mode, tuple(health), tuple(limited_by), Estimate(*x)
        )

    def replay(self, log: Log) -> Columns:
        """Tell the controller again what it was told on a ride.

        Parameters
        ----------
        log : Log
            A ride, or the log of one.

        Returns
        -------
        Columns
            ``t_s``, ``front_brake_nm``, ``rear_traction_nm``, ``demand_nm``, shape (n,) each; of a
            controller at rest that is of the ride's own kind (`of`), bit for bit those of
            ``log["/control/output"]``.
        """
        told, wanted = log["/sensor/measurement"], log["/rider/intent"]
        out = {name: np.empty(len(told["t_s"])) for name in ("front_brake_nm", "rear_traction_nm", "demand_nm")}
        for i in range(len(told["t_s"])):
            output = self.step(
                round(float(told["t_s"][i]) * 1e9), _measurement(told, i), _intent(wanted, i)
            )
            out["front_brake_nm"][i] = output.front_brake_nm
            out["rear_traction_nm"][i] = output.rear_traction_nm
            out["demand_nm"][i] = output.demand_nm
        return Columns({"t_s": told["t_s"].copy(), **out})

    def __repr__(self) -> str:
        first = next((line for line in self.to_toml().splitlines() if line.startswith("[law.")), "[law.?]")
        return f"Controller({first[5:-1]})"


def _stamp(columns: Columns, name: str, i: int) -> int:
    value = float(columns[name][i])
    return NEVER_NS if math.isnan(value) else int(value)


def _measurement(c: Columns, i: int) -> Measurement:
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


def _intent(c: Columns, i: int) -> RiderIntent:
    return RiderIntent(
        _stamp(c, "stamp_ns", i),
        bool(c["assist_on"][i]),
        bool(c["pedalling"][i]),
        float(c["front_brake_ratio"][i]),
        float(c["rear_brake_ratio"][i]),
        float(c["pedal_nm"][i]),
        float(c["cadence_rad_s"][i]),
    )
