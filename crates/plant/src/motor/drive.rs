//! One drive: from commands to torque on one wheel.
//!
//! What: watchdog, dead time of bus and computation, first-order lag of the current loop, then
//! the motor. Equation: T_lag' = (T_cmd(t - dead) - T_lag)/lag, exact over a tick. Source: usual
//! small-signal model of a current-controlled drive. Assumes and ignores: the dead time is a
//! whole number of ticks (rounded). Valid for: fixed ticks. Checked by: the conformance suite.

use serde::{Deserialize, Serialize};
use twinhub_types::{Duration, Instant};

use super::{MotorDrive, MotorModel, MotorState, OperatingPoint, Watchdog};
use crate::admissible::{OutOfRange, within};

/// Longest dead time, ticks.
pub const MAX_DEAD_TICKS: usize = 63;

/// Parameters of one drive.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DriveParameters {
    /// Time from a command to its first effect, s.
    pub dead_time_s: f64,
    /// Time constant of the torque after that, s.
    pub lag_s: f64,
    /// What the drive does when commands stop.
    pub watchdog: Watchdog,
    /// The motor.
    pub motor: MotorDrive,
}

impl DriveParameters {
    /// Checks every parameter.
    pub fn validate(&self) -> Result<(), OutOfRange> {
        within("dead_time_s", self.dead_time_s, 0.0, 0.063)?;
        within("lag_s", self.lag_s, 0.0, 10.0)?;
        self.watchdog.validate()?;
        self.motor.validate()
    }
}

/// What a drive did in one tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DriveOutput {
    /// Torque on the wheel, positive forward, Nm.
    pub torque_nm: f64,
    /// Torque that the drive believes in, from its current, Nm.
    pub reported_nm: f64,
    /// Torque-producing current, A.
    pub current_a: f64,
    /// Power taken from the bus, W; negative when it regenerates.
    pub electrical_w: f64,
    /// Power given to the wheel, W; negative when it brakes.
    pub mechanical_w: f64,
    /// All losses together, W.
    pub heat_w: f64,
    /// Power that went into the rotor's motion and the cogging's potential, W.
    pub stored_w: f64,
    /// Temperature of the winding, °C.
    pub winding_celsius: f64,
    /// The watchdog holds the torque back.
    pub watchdog_active: bool,
    /// The peak current, the bus voltage, the heat or the supply hold the torque back.
    pub limited: bool,
}

/// A drive in motion.
#[derive(Clone, Debug)]
pub struct Drive {
    parameters: DriveParameters,
    state: MotorState,
    heard: Option<(Instant, f64)>,
    line: [f64; MAX_DEAD_TICKS + 1],
    head: usize,
    lagged_nm: f64,
    timing: Timing,
    on: bool,
    watchdog_active: bool,
}

/// What depends on the tick's length alone.
#[derive(Clone, Copy, Debug)]
struct Timing {
    step: Duration,
    dead_ticks: usize,
    gain: f64,
}

impl Timing {
    fn new(parameters: &DriveParameters, step: Duration) -> Self {
        let step_s = step.as_secs_f64();
        let ticks = if step_s > 0.0 {
            libm::round(parameters.dead_time_s / step_s)
        } else {
            0.0
        };
        let gain = if parameters.lag_s > 0.0 {
            -libm::expm1(-step_s / parameters.lag_s)
        } else {
            1.0
        };
        Self {
            step,
            dead_ticks: (ticks as usize).min(MAX_DEAD_TICKS),
            gain,
        }
    }
}

impl Drive {
    /// A drive at rest, cold, without a command.
    pub fn new(parameters: DriveParameters) -> Result<Self, OutOfRange> {
        parameters.validate()?;
        let ambient = match parameters.motor {
            MotorDrive::DirectDrive(m) => m.thermal.ambient_celsius,
            MotorDrive::GearedFreewheel(m) => m.thermal.ambient_celsius,
            MotorDrive::Ideal(_) | MotorDrive::FixedEfficiency(_) => 25.0,
        };
        Ok(Self {
            parameters,
            state: MotorState {
                winding_celsius: ambient,
                ..MotorState::default()
            },
            heard: None,
            line: [0.0; MAX_DEAD_TICKS + 1],
            head: 0,
            lagged_nm: 0.0,
            timing: Timing::new(&parameters, twinhub_types::conventions::TICK),
            on: false,
            watchdog_active: false,
        })
    }

    /// The parameters.
    pub fn parameters(&self) -> &DriveParameters {
        &self.parameters
    }

    /// Rotor, angle and temperature.
    pub fn state(&self) -> &MotorState {
        &self.state
    }

    /// Sets the winding's temperature, °C: a ride may start with a warm motor.
    pub fn set_winding_celsius(&mut self, celsius: f64) {
        self.state.winding_celsius = celsius;
    }

    /// One tick of length `step` that begins at `now`, with the torque held over it.
    ///
    /// `command` is the torque on the wheel, positive forward, of a command that is new in this
    /// tick; `None`, or a number that is not finite, counts as silence.
    pub fn step(
        &mut self,
        now: Instant,
        command_nm: Option<f64>,
        wheel_rate_rad_s: f64,
        bus_v: f64,
        step: Duration,
    ) -> DriveOutput {
        let wanted_nm = self.listen(now, command_nm, step);
        let point = self.point(wanted_nm, wheel_rate_rad_s, bus_v);
        self.finish(&point, wheel_rate_rad_s, false)
    }

    /// Watchdog, dead time and lag: the torque that the current loop holds in this tick, Nm.
    pub(super) fn listen(&mut self, now: Instant, command_nm: Option<f64>, step: Duration) -> f64 {
        if step != self.timing.step {
            self.timing = Timing::new(&self.parameters, step);
        }
        if let Some(nm) = command_nm.filter(|nm| nm.is_finite()) {
            self.heard = Some((now, nm));
        }
        let (share, nm) = match self.heard {
            Some((at, nm)) => (self.parameters.watchdog.share(now.since(at)), nm),
            None => (0.0, 0.0),
        };
        self.watchdog_active = share < 1.0;
        self.on = share > 0.0;
        if !self.on {
            self.line = [0.0; MAX_DEAD_TICKS + 1];
            self.lagged_nm = 0.0;
            return 0.0;
        }
        self.head = (self.head + 1) % self.line.len();
        self.line[self.head] = share * nm;
        let at = (self.head + self.line.len() - self.timing.dead_ticks) % self.line.len();
        self.lagged_nm += self.timing.gain * (self.line[at] - self.lagged_nm);
        self.lagged_nm
    }

    /// Where the motor would run at `wanted_nm`.
    pub(super) fn point(
        &self,
        wanted_nm: f64,
        wheel_rate_rad_s: f64,
        bus_v: f64,
    ) -> OperatingPoint {
        if self.on {
            self.parameters
                .motor
                .point(wanted_nm, wheel_rate_rad_s, &self.state, bus_v)
        } else {
            OperatingPoint::OFF
        }
    }

    /// Ends the tick at `point`.
    pub(super) fn finish(
        &mut self,
        point: &OperatingPoint,
        wheel_rate_rad_s: f64,
        supply_limited: bool,
    ) -> DriveOutput {
        let motor = &self.parameters.motor;
        let step_s = self.timing.step.as_secs_f64();
        let shaft = motor.finish(point, wheel_rate_rad_s, &mut self.state, step_s);
        DriveOutput {
            torque_nm: shaft.torque_nm,
            reported_nm: motor.reported_nm(point),
            current_a: point.current_a,
            electrical_w: point.electrical_w,
            mechanical_w: shaft.torque_nm * wheel_rate_rad_s,
            heat_w: point.copper_w + point.drive_w + shaft.friction_w,
            stored_w: shaft.stored_w,
            winding_celsius: self.state.winding_celsius,
            watchdog_active: self.watchdog_active,
            limited: supply_limited
                || point.current_limited
                || point.voltage_limited
                || point.heat_limited,
        }
    }
}
