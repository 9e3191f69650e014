//! Two drives on one bus.
//!
//! What: both hub motors, their drives and the battery, one tick at a time. Equation: each drive
//! by itself; if the sum of their powers exceeds what the battery gives (or, braking, what battery
//! and chopper take), the torque of the drives that cause it is reduced by one common factor,
//! found by 24 bisections between nothing and all. Source: our own rule; real drives on one bus
//! limit by bus voltage, with the same result. Assumes and ignores: drives see the bus voltage of
//! the tick before. Valid for: 1 ms ticks. Checked by: the conformance suite.

use serde::{Deserialize, Serialize};
use twinhub_types::{Command, Duration, Instant};

use super::{Battery, Bus, BusEnergy, Drive, DriveOutput, DriveParameters};
use crate::admissible::OutOfRange;

/// Parameters of both drives and the battery.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PowerTrainParameters {
    /// Drive of the front wheel.
    pub front: DriveParameters,
    /// Drive of the rear wheel.
    pub rear: DriveParameters,
    /// Supply of both.
    pub battery: Battery,
}

/// What the power train did in one tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PowerOutput {
    /// Brake torque on the front wheel, friction of the motor included, Nm.
    pub front_brake_nm: f64,
    /// Traction torque on the rear wheel, friction of the motor included, Nm.
    pub rear_traction_nm: f64,
    /// Front brake torque that the drive believes in, from its current, Nm.
    pub front_reported_nm: f64,
    /// Rear traction torque that the drive believes in, from its current, Nm.
    pub rear_reported_nm: f64,
    /// Bus voltage, V.
    pub bus_v: f64,
    /// Bus current, positive out of the battery, A.
    pub bus_a: f64,
    /// State of charge, 0 to 1.
    pub charge_ratio: f64,
    /// Energy counters since the start.
    pub energy: BusEnergy,
    /// Temperature of the hotter winding, °C.
    pub winding_celsius: f64,
    /// The front drive.
    pub front: DriveOutput,
    /// The rear drive.
    pub rear: DriveOutput,
}

/// Both drives and the bus in motion.
#[derive(Clone, Debug)]
pub struct PowerTrain {
    front: Drive,
    rear: Drive,
    bus: Bus,
}

const BISECTIONS: u32 = 24;

impl PowerTrain {
    /// At rest, cold, without a command.
    pub fn new(parameters: &PowerTrainParameters) -> Result<Self, OutOfRange> {
        Ok(Self {
            front: Drive::new(parameters.front)?,
            rear: Drive::new(parameters.rear)?,
            bus: Bus::new(parameters.battery)?,
        })
    }

    /// The front drive.
    pub fn front_mut(&mut self) -> &mut Drive {
        &mut self.front
    }

    /// The rear drive.
    pub fn rear_mut(&mut self) -> &mut Drive {
        &mut self.rear
    }

    /// The bus.
    pub fn bus(&self) -> &Bus {
        &self.bus
    }

    /// One tick of length `step` that begins at `now`; torques are held over it.
    ///
    /// `command` is a command that is new in this tick, `None` if none came. The front motor
    /// brakes only: a negative front brake torque counts as zero.
    pub fn step(
        &mut self,
        now: Instant,
        command: Option<Command>,
        front_rate_rad_s: f64,
        rear_rate_rad_s: f64,
        step: Duration,
    ) -> PowerOutput {
        let front_cmd = command.map(|c| brake_to_torque(c.front_brake_nm));
        let rear_cmd = command.map(|c| f64::from(c.rear_traction_nm));
        let bus_v = self.bus.voltage_v();
        let front_nm = self.front.listen(now, front_cmd, step);
        let rear_nm = self.rear.listen(now, rear_cmd, step);
        let mut front = self.front.point(front_nm, front_rate_rad_s, bus_v);
        let mut rear = self.rear.point(rear_nm, rear_rate_rad_s, bus_v);

        let (out_w, in_w) = self.bus.limits_w();
        let net_w = front.electrical_w + rear.electrical_w;
        let over = net_w > out_w;
        let limited = over || -net_w > in_w;
        if limited {
            // scale the drives that push the net power over its limit, and only them
            let guilty = |w: f64| if over { w > 0.0 } else { w < 0.0 };
            let (scale_front, scale_rear) = (guilty(front.electrical_w), guilty(rear.electrical_w));
            let (mut low, mut high) = (0.0, 1.0);
            let at = |share: f64| {
                let f = if scale_front {
                    share * front_nm
                } else {
                    front_nm
                };
                let r = if scale_rear { share * rear_nm } else { rear_nm };
                (
                    self.front.point(f, front_rate_rad_s, bus_v),
                    self.rear.point(r, rear_rate_rad_s, bus_v),
                )
            };
            (front, rear) = at(0.0);
            for _ in 0..BISECTIONS {
                let share = 0.5 * (low + high);
                let (f, r) = at(share);
                let w = f.electrical_w + r.electrical_w;
                if w > out_w || -w > in_w {
                    high = share;
                } else {
                    low = share;
                    (front, rear) = (f, r);
                }
            }
        }
        self.bus
            .step(front.electrical_w + rear.electrical_w, step.as_secs_f64());
        let front = self.front.finish(&front, front_rate_rad_s, limited);
        let rear = self.rear.finish(&rear, rear_rate_rad_s, limited);
        PowerOutput {
            front_brake_nm: -front.torque_nm,
            rear_traction_nm: rear.torque_nm,
            front_reported_nm: -front.reported_nm,
            rear_reported_nm: rear.reported_nm,
            bus_v: self.bus.voltage_v(),
            bus_a: self.bus.current_a(),
            charge_ratio: self.bus.charge_ratio(),
            energy: *self.bus.energy(),
            winding_celsius: front.winding_celsius.max(rear.winding_celsius),
            front,
            rear,
        }
    }
}

/// The torque on the front wheel, positive forward, of a brake command; NaN stays NaN (silence).
fn brake_to_torque(front_brake_nm: f32) -> f64 {
    if front_brake_nm < 0.0 {
        0.0
    } else {
        -f64::from(front_brake_nm)
    }
}
