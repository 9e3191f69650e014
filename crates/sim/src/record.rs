//! What a ride logs once a tick, beside the messages of the link.

use twinhub_log::row;
use twinhub_plant::Truth;

row! {
    /// The true state of the plant at the tick.
    pub struct TruthRow {
        /// Roll, rad.
        roll_rad,
        /// Steer, rad.
        steer_rad,
        /// Heading, rad.
        yaw_rad,
        /// Pitch, rad.
        pitch_rad,
        /// Roll rate, rad/s.
        roll_rate_rad_s,
        /// Steer rate, rad/s.
        steer_rate_rad_s,
        /// Yaw rate, rad/s.
        yaw_rate_rad_s,
        /// Rear contact, forward on the map, m.
        x_m,
        /// Rear contact, to the right on the map, m.
        y_m,
        /// Forward speed, m/s.
        speed_m_s,
        /// Front wheel rate, rad/s.
        front_wheel_rate_rad_s,
        /// Rear wheel rate, rad/s.
        rear_wheel_rate_rad_s,
        /// Front tyre load, N.
        front_load_n,
        /// Rear tyre load, N.
        rear_load_n,
        /// Front longitudinal slip.
        front_slip_ratio,
        /// Rear longitudinal slip.
        rear_slip_ratio,
        /// Front motor's brake torque over the tick, Nm.
        front_brake_nm,
        /// Rear motor's traction torque over the tick, Nm.
        rear_traction_nm,
        /// Lateral force over the tick, N.
        lateral_force_n,
        /// Power out of the battery over the tick, W.
        battery_w,
    }
}

row! {
    /// What the rider does over the tick.
    pub struct RiderRow {
        /// Torque on the handlebar, Nm.
        steer_torque_nm,
        /// Force of the pedals at the rear contact, N.
        pedal_force_n,
        /// Speed that the course asks for, m/s.
        wanted_speed_m_s,
    }
}

/// The truth as a row; what acts over the tick is filled in by the loop.
pub fn truth_row(t: &Truth) -> TruthRow {
    TruthRow {
        roll_rad: t.roll_rad,
        steer_rad: t.steer_rad,
        yaw_rad: t.yaw_rad,
        pitch_rad: t.pitch_rad,
        roll_rate_rad_s: t.roll_rate_rad_s,
        steer_rate_rad_s: t.steer_rate_rad_s,
        yaw_rate_rad_s: t.yaw_rate_rad_s,
        x_m: t.x_m,
        y_m: t.y_m,
        speed_m_s: t.speed_m_s,
        front_wheel_rate_rad_s: t.front_wheel_rate_rad_s,
        rear_wheel_rate_rad_s: t.rear_wheel_rate_rad_s,
        front_load_n: t.front_load_n,
        rear_load_n: t.rear_load_n,
        front_slip_ratio: t.front_slip_ratio,
        rear_slip_ratio: t.rear_slip_ratio,
        ..TruthRow::default()
    }
}
