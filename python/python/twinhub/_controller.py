"""The stabilizer itself, tick by tick."""

from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from . import _twinhub
from ._arguments import Assignments, NameOrPath, assignments
from ._log import Columns, Log
from ._messages import Estimate, Known, Measurement, Output, RiderIntent, intent, measurement
from ._things import Law, of
from .errors import InputError

#: A law written in Python: `Estimate` and the time since the last tick (s) in; the pair (Nm) out, or
#: the pair and the rear trim (Nm).
LawFunction: TypeAlias = Callable[[Estimate, float], float | tuple[float, float]]


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

    def belief(self) -> dict[str, Known]:
        """What is believed after the last `step`, each quantity with its uncertainty and its age.

        Returns
        -------
        dict of str to Known
            ``roll_rad``, ``roll_rate_rad_s``, ``steer_rad``, ``steer_rate_rad_s``, ``yaw_rate_rad_s``,
            ``speed_m_s``, ``road_lean_rad``, ``front_load_n``, ``rear_load_n``, ``front_slip_ratio``,
            ``rear_slip_ratio``; and ``friction_ratio``, only after a wheel has slipped: until then it
            is unknown.
        """
        return {name: Known(*known) for name, *known in self._inner.belief()}

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
                round(float(told["t_s"][i]) * 1e9), measurement(told, i), intent(wanted, i)
            )
            out["front_brake_nm"][i] = output.front_brake_nm
            out["rear_traction_nm"][i] = output.rear_traction_nm
            out["demand_nm"][i] = output.demand_nm
        return Columns({"t_s": told["t_s"].copy(), **out})

    def __repr__(self) -> str:
        first = next((line for line in self.to_toml().splitlines() if line.startswith("[law.")), "[law.?]")
        return f"Controller({first[5:-1]})"
