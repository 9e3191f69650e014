//! What the equations say at one moment: torques, accelerations, readings.

use super::course::Ends;
use super::ride::{Ride, Sensor};
use super::setup::Setup;
use crate::quantity::Quantity;
use nalgebra::{Matrix2, Vector2};
use twinhub_linear::MotorPair;
use twinhub_mechanism::{Inputs, Moment, SensorModel, Wrench};

/// Speed and what goes with it, at one end of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pace {
    pub speed_m_s: f64,
    /// Just after the end of the step, with the inputs that a sensor meets.
    pub accel_m_s2: f64,
    /// Just before it.
    pub ending_m_s2: f64,
    pub travel_m: f64,
}

impl Pace {
    /// As the step ends, before inputs that are held take their new values.
    pub fn at_end(&self) -> Self {
        Self {
            accel_m_s2: self.ending_m_s2,
            ..*self
        }
    }
}

/// The motors' part in the lateral equations: the front brake as it is, the rear such that the
/// acceleration comes out.
pub fn pair(setup: &Setup, ends: &Ends, pace: &Pace) -> MotorPair {
    let body = &setup.plant.body;
    let p = &body.parameters;
    let per = |torque: f64, radius: f64| if radius > 0.0 { torque / radius } else { 0.0 };
    MotorPair {
        front_brake_nm: ends.brake_nm,
        rear_traction_nm: p.rR
            * (pace.accel_m_s2 * body.effective_mass_kg + per(ends.brake_nm, p.rF)),
    }
}

/// Damping, stiffness and known torque at one moment.
#[derive(Clone, Copy, Debug)]
pub struct Balance {
    pub damping: Matrix2<f64>,
    pub stiffness: Matrix2<f64>,
    pub torque: Vector2<f64>,
}

impl Balance {
    pub fn new(setup: &Setup, ends: &Ends, pace: &Pace) -> Self {
        let body = &setup.plant.body;
        let mut torque = Vector2::zeros();
        for (value, arm) in ends.drive.iter().zip(&setup.arms) {
            torque.x += arm[0] * value;
            torque.y += arm[1] * value;
        }
        Self {
            damping: body.damping(pace.speed_m_s),
            stiffness: body.stiffness(pace.speed_m_s, pair(setup, ends, pace)),
            torque,
        }
    }

    /// Torque that accelerates roll and steer, without mechanisms that push.
    pub fn net(&self, x: &[f64]) -> Vector2<f64> {
        self.torque
            - self.damping * Vector2::new(x[2], x[3])
            - self.stiffness * Vector2::new(x[0], x[1])
    }
}

/// A state as mechanisms see it.
pub fn moment<'a>(
    setup: &'a Setup,
    ride: &Ride,
    ends: &Ends,
    pace: &Pace,
    x: &[f64],
    accel: Vector2<f64>,
    t_s: f64,
    dt_s: f64,
) -> Moment<'a> {
    let some = |v: f64| (!v.is_nan()).then_some(v);
    let mut inputs = Inputs {
        front_brake_nm: ends.brake_nm,
        rear_traction_nm: ends.traction_nm,
        ..Inputs::default()
    };
    for ((drive, arm), value) in ride.drives.iter().zip(&setup.arms).zip(&ends.drive) {
        match drive.quantity {
            Quantity::LateralForce => {
                inputs.side_force_n += value;
                // The steer torque of a side force is its yaw torque times c cos(lam)/w.
                inputs.yaw_torque_nm += arm[1] / setup.plant.body.yaw[1] * value;
            }
            Quantity::SteerTorque => inputs.steer_torque_nm += value,
            Quantity::RollTorque => inputs.roll_torque_nm += value,
            _ => {}
        }
    }
    Moment {
        body: &setup.plant.body,
        t_s,
        dt_s,
        speed_m_s: pace.speed_m_s,
        accel_m_s2: pace.accel_m_s2,
        travel_m: pace.travel_m,
        angle_rad: [x[0], x[1]],
        rate_rad_s: [x[2], x[3]],
        accel_rad_s2: [accel.x, accel.y],
        inputs,
        crank_rad: some(ends.crank_rad),
        wheel_rad: some(ends.wheel_rad - setup.wheel_phase_rad),
        trunk_lean_rad: some(ends.trunk_rad),
        way: ride.way,
    }
}

/// Which mechanisms are asked.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Which {
    All,
    /// Those that a predictor linearises.
    Feedback,
}

/// What mechanisms and known laws add.
pub fn wrench(setup: &Setup, ride: &Ride, at: &Moment<'_>, memory: &[f64], which: Which) -> Wrench {
    let mut sum = Wrench::default();
    for &(index, start) in &setup.pushing {
        let a = &setup.plant.active[index];
        if which == Which::All || a.mechanism.feeds_back() {
            let end = start + a.mechanism.memory();
            sum += a.mechanism.wrench(&a.p, at, &memory[start..end]);
        }
    }
    for law in &ride.laws {
        let delay = law.delay_s + setup.law_delay_s;
        let (value, rate) = match law.of {
            Quantity::Roll => (at.angle_rad[0], at.rate_rad_s[0]),
            Quantity::Steer => (at.angle_rad[1], at.rate_rad_s[1]),
            Quantity::SteerRate => (at.rate_rad_s[1], at.accel_rad_s2[1]),
            Quantity::YawRate => (at.yaw_rate_rad_s(), at.yaw_accel_rad_s2()),
            _ => (at.rate_rad_s[0], at.accel_rad_s2[0]),
        };
        let torque =
            (law.gain.at(at.speed_m_s) * (value - delay * rate)).clamp(-law.limit_nm, law.limit_nm);
        sum.roll_nm += law.arm[0] * torque;
        sum.steer_nm += law.arm[1] * torque;
    }
    sum
}

/// Whether anything pushes at all.
pub fn is_pushed(setup: &Setup, ride: &Ride) -> bool {
    !setup.pushing.is_empty() || !ride.laws.is_empty()
}

/// Moves all memories over a step.
pub fn remember(setup: &Setup, at: &Moment<'_>, memory: &mut [f64], fresh: bool) {
    for &(index, start) in &setup.pushing {
        let a = &setup.plant.active[index];
        let end = start + a.mechanism.memory();
        if end > start {
            a.mechanism
                .remember(&a.p, at, &mut memory[start..end], fresh);
        }
    }
}

/// What a lateral sensor reads, without its bias: `yaw_slip` is the yaw rate that slip adds.
pub fn reading(
    setup: &Setup,
    sensor: &Sensor,
    model: &SensorModel,
    at: &Moment<'_>,
    yaw_rad: f64,
    yaw_slip: f64,
) -> f64 {
    let yaw_rate = at.yaw_rate_rad_s() + yaw_slip;
    let truth = match sensor.quantity {
        Quantity::Roll => at.angle_rad[0],
        Quantity::Steer => at.angle_rad[1],
        Quantity::RollRate => at.rate_rad_s[0],
        Quantity::SteerRate => at.rate_rad_s[1],
        Quantity::Yaw => yaw_rad,
        Quantity::YawRate => yaw_rate,
        _ => {
            // Lateral specific force: v psi' + x psi'' - z roll'' - g roll.
            let [x, z] = sensor.point_m;
            at.speed_m_s * yaw_rate + x * at.yaw_accel_rad_s2()
                - z * at.accel_rad_s2[0]
                - at.body.gravity_m_s2 * at.angle_rad[0]
        }
    };
    let mut read = model.gain * truth + model.offset + model.yaw_share * yaw_rate;
    if setup.reads {
        for a in &setup.plant.active {
            read += a.mechanism.reading(&a.p, sensor.quantity, at);
        }
    }
    read
}

/// Time derivative of what a lateral sensor reads, for small delays.
pub fn reading_rate(sensor: &Sensor, at: &Moment<'_>) -> f64 {
    match sensor.quantity {
        Quantity::Roll => at.rate_rad_s[0],
        Quantity::Steer => at.rate_rad_s[1],
        Quantity::RollRate => at.accel_rad_s2[0],
        Quantity::SteerRate => at.accel_rad_s2[1],
        Quantity::Yaw => at.yaw_rate_rad_s(),
        Quantity::YawRate => at.yaw_accel_rad_s2(),
        _ => 0.0,
    }
}
