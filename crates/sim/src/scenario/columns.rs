//! Names and values of a row.

use super::Scenario;
use twinhub_plant::Truth;
use twinhub_plant::disturbance::Wrench;
use twinhub_plant::motor::PowerOutput;
use twinhub_plant::multibody::state::{
    LEG_RATE, LEGS, NAMES, SPIN, STEER_RATE, TRUNK, TRUNK_RATE, WHEELS,
};
use twinhub_plant::multibody::{Input, Interaction, Pedalling, Ride};
use twinhub_types::Measurement;

/// What a row is made from.
pub(super) struct Now<'a> {
    pub t_s: f64,
    pub ride: &'a Ride,
    pub input: &'a Input,
    pub pedal_force_n: f64,
    pub truth: &'a Truth,
    pub interaction: &'a Interaction,
    pub disturbance: &'a Wrench,
    pub power: &'a PowerOutput,
    pub measured: Option<Measurement>,
}

/// The columns of a run.
#[derive(Clone, Debug)]
pub struct Columns {
    names: Vec<String>,
    motors: bool,
    sensors: bool,
    pedals: bool,
}

/// Columns that every run has, before those of the wheels.
const ALWAYS: [&str; 14] = [
    "t_s",
    "x_m",
    "y_m",
    "yaw_rad",
    "roll_rad",
    "pitch_rad",
    "speed_m_s",
    "roll_rate_rad_s",
    "yaw_rate_rad_s",
    "steer_rad",
    "steer_rate_rad_s",
    "specific_force_x_m_s2",
    "specific_force_y_m_s2",
    "specific_force_z_m_s2",
];

/// Places in the state that are columns under their own names.
fn state_places() -> impl Iterator<Item = usize> {
    (TRUNK..TRUNK + 3)
        .chain(LEGS..LEGS + 2)
        .chain(WHEELS..WHEELS + 2)
        .chain(TRUNK_RATE..TRUNK_RATE + 3)
        .chain(LEG_RATE..LEG_RATE + 2)
        .chain(SPIN..SPIN + 2)
}

/// Columns of each wheel, after `front_` or `rear_`.
const WHEEL: [&str; 10] = [
    "load_n",
    "deflection_m",
    "slip_ratio",
    "slip_angle_rad",
    "camber_rad",
    "longitudinal_n",
    "lateral_n",
    "overturning_nm",
    "rolling_resistance_nm",
    "aligning_nm",
];

/// What acts.
const INPUTS: [&str; 17] = [
    "front_brake_nm",
    "rear_traction_nm",
    "pedal_force_n",
    "steer_torque_nm",
    "trunk_lean_torque_nm",
    "trunk_pitch_torque_nm",
    "trunk_twist_torque_nm",
    "left_leg_torque_nm",
    "right_leg_torque_nm",
    "lateral_force_n",
    "roll_torque_nm",
    "pitch_torque_nm",
    "yaw_torque_nm",
    "wind_along_m_s",
    "wind_across_m_s",
    "rear_road_y_m",
    "rear_road_y_m_s",
];

/// What the rider does to the bicycle: seat, bar and pedals together, about the saddle, axes of the
/// frame; and the arms.
const RIDER: [&str; 9] = [
    "rider_force_x_n",
    "rider_force_y_n",
    "rider_force_z_n",
    "rider_moment_x_nm",
    "rider_moment_y_nm",
    "rider_moment_z_nm",
    "left_arm_n",
    "right_arm_n",
    "arms_steer_torque_nm",
];

const ENERGY: [&str; 3] = ["kinetic_j", "gravity_j", "springs_j"];

const PEDALS: [&str; 10] = [
    "crank_rad",
    "crank_torque_nm",
    "left_pedal_z_n",
    "right_pedal_z_n",
    "pedals_roll_moment_nm",
    "legs_roll_moment_nm",
    "legs_pitch_moment_nm",
    "legs_yaw_moment_nm",
    "saddle_and_bar_z_n",
    "saddle_and_bar_roll_moment_nm",
];

const MOTORS: [&str; 5] = [
    "front_reported_nm",
    "rear_reported_nm",
    "battery_w",
    "charge_ratio",
    "winding_celsius",
];

const SENSORS: [&str; 13] = [
    "measured_gyro_x_rad_s",
    "measured_gyro_y_rad_s",
    "measured_gyro_z_rad_s",
    "measured_accel_x_m_s2",
    "measured_accel_y_m_s2",
    "measured_accel_z_m_s2",
    "measured_roll_rad",
    "measured_roll_rate_rad_s",
    "measured_steer_rad",
    "measured_steer_rate_rad_s",
    "measured_front_wheel_rad_s",
    "measured_rear_wheel_rad_s",
    "measured_speed_m_s",
];

impl Columns {
    /// The columns of a scenario on a bicycle with or without pedalling legs.
    pub(super) fn new(scenario: &Scenario, pedals: Option<&Pedalling>) -> Self {
        let mut names: Vec<String> = ALWAYS.map(str::to_owned).to_vec();
        names.extend(state_places().map(|k| NAMES[k].to_owned()));
        for wheel in ["front", "rear"] {
            names.extend(WHEEL.map(|name| format!("{wheel}_{name}")));
        }
        let mut more = |list: &[&str]| names.extend(list.iter().map(|n| (*n).to_owned()));
        more(&INPUTS);
        more(&RIDER);
        more(&ENERGY);
        let columns = (
            pedals.is_some(),
            scenario.motors.is_some(),
            scenario.sensors.is_some(),
        );
        if columns.0 {
            more(&PEDALS);
        }
        if columns.1 {
            more(&MOTORS);
        }
        if columns.2 {
            more(&SENSORS);
        }
        Self {
            names,
            pedals: columns.0,
            motors: columns.1,
            sensors: columns.2,
        }
    }

    /// Their names; each ends with its unit.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The values of a row.
    pub(super) fn fill(&self, now: &Now, values: &mut Vec<f64>) {
        let (t, x) = (now.truth, now.ride.state());
        let [fx, fy, fz] = t.specific_force_m_s2;
        values.extend([
            now.t_s,
            t.x_m,
            t.y_m,
            t.yaw_rad,
            t.roll_rad,
            t.pitch_rad,
            t.speed_m_s,
            t.roll_rate_rad_s,
            t.yaw_rate_rad_s,
            t.steer_rad,
            x[STEER_RATE],
            fx,
            fy,
            fz,
        ]);
        values.extend(state_places().map(|k| x[k]));
        let [rear, front] = now.ride.contacts_under(now.input);
        for c in [front, rear] {
            values.extend([
                c.load_n,
                c.deflection_m,
                c.slip_ratio,
                c.slip_angle_rad,
                c.camber_rad,
                c.tyre.longitudinal_n,
                c.tyre.lateral_n,
                c.tyre.overturning_nm,
                c.tyre.rolling_resistance_nm,
                c.tyre.aligning_nm,
            ]);
        }
        let i = now.input;
        values.extend([
            i.front_brake_nm,
            i.rear_traction_nm,
            now.pedal_force_n,
            i.steer_torque_nm,
        ]);
        values.extend(i.trunk_torque_nm);
        values.extend(i.leg_torque_nm);
        values.push(i.force_n[1]);
        values.extend(i.moment_nm);
        values.extend([
            i.wind_m_s[0],
            i.wind_m_s[1],
            now.disturbance.rear_road_y_m,
            now.disturbance.rear_road_y_m_s,
        ]);
        let rider = now.interaction.forces(now.ride, now.input);
        values.extend(rider.force_n);
        values.extend(rider.moment_nm);
        values.extend(rider.arms_n);
        values.push(rider.arms_steer_torque_nm);
        let energy = now.ride.model().energy_on(x, now.ride.road());
        values.extend([energy.kinetic_j, energy.gravity_j, energy.springs_j]);
        if self.pedals {
            let p = now.ride.pedal_stroke(now.pedal_force_n);
            let [left, right] = p.pedals_n;
            values.extend([
                p.crank_rad,
                p.crank_torque_nm,
                left,
                right,
                p.pedals_roll_moment_nm,
                p.legs_moment_nm[0],
                p.legs_moment_nm[1],
                p.legs_moment_nm[2],
                rider.force_n[2] - left - right,
                rider.moment_nm[0] + p.legs_moment_nm[0] - p.pedals_roll_moment_nm,
            ]);
        }
        if self.motors {
            let p = now.power;
            values.extend([
                p.front_reported_nm,
                p.rear_reported_nm,
                p.bus_v * p.bus_a,
                p.charge_ratio,
                p.winding_celsius,
            ]);
        }
        if self.sensors {
            let m = now.measured.unwrap_or_default();
            values.extend(m.imu.gyro_rad_s.map(f64::from));
            values.extend(m.imu.accel_m_s2.map(f64::from));
            values.extend(
                [
                    m.roll.roll_rad,
                    m.roll.roll_rate_rad_s,
                    m.steer.steer_rad,
                    m.steer.steer_rate_rad_s,
                    m.wheels.front_rad_s,
                    m.wheels.rear_rad_s,
                    m.wheels.speed_m_s,
                ]
                .map(f64::from),
            );
        }
    }
}

/// The unit that a column's name ends with.
pub fn unit(column: &str) -> &'static str {
    twinhub_plant::multibody::unit(column)
}
