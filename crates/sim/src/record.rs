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
        /// Lean of the trunk relative to the frame, rad.
        trunk_lean_rad,
        /// Left leg about the hip-ankle line, outward positive, rad.
        left_leg_rad,
        /// Right leg about the hip-ankle line, outward positive, rad.
        right_leg_rad,
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
    /// How the link has done since the ride began. It tells about this run alone.
    pub struct LinkRow {
        /// Ticks without an answer that could be applied.
        missed_count,
        /// Ticks ridden on the answer to an earlier frame.
        late_count,
        /// Ticks that began a whole tick late or more.
        overrun_count,
        /// Ticks by which the clock was moved.
        slipped_count,
        /// Time ridden per time passed.
        real_time_ratio,
        /// From a frame to its answer: median, us.
        round_trip_p50_us,
        /// 99 of 100, us.
        round_trip_p99_us,
        /// 999 of 1000, us.
        round_trip_p999_us,
        /// Longest, us.
        round_trip_max_us,
        /// How late ticks began: median, us.
        lateness_p50_us,
        /// 99 of 100, us.
        lateness_p99_us,
        /// 999 of 1000, us.
        lateness_p999_us,
        /// Longest, us.
        lateness_max_us,
        /// The controller's process: from the sending of a frame to its arrival, median, us.
        wake_up_p50_us,
        /// 99 of 100, us.
        wake_up_p99_us,
        /// Longest, us.
        wake_up_max_us,
        /// From a frame's arrival to its answer, median, us.
        compute_p50_us,
        /// 99 of 100, us.
        compute_p99_us,
        /// Longest, us.
        compute_max_us,
        /// Frames that never reached the controller.
        frames_lost_count,
        /// Controller's ticks without a frame.
        silent_count,
        /// Controller's ticks that took longer than a tick.
        controller_overrun_count,
    }
}

impl From<&twinhub_link::Timing> for LinkRow {
    fn from(t: &twinhub_link::Timing) -> Self {
        let c = t.controller.clone().unwrap_or_default();
        Self {
            missed_count: t.missed_answers as f64,
            late_count: t.late_answers as f64,
            overrun_count: t.overruns as f64,
            slipped_count: t.slipped_ticks as f64,
            real_time_ratio: t.real_time_factor,
            round_trip_p50_us: t.round_trip_us.p50,
            round_trip_p99_us: t.round_trip_us.p99,
            round_trip_p999_us: t.round_trip_us.p999,
            round_trip_max_us: t.round_trip_us.max,
            lateness_p50_us: t.lateness_us.p50,
            lateness_p99_us: t.lateness_us.p99,
            lateness_p999_us: t.lateness_us.p999,
            lateness_max_us: t.lateness_us.max,
            wake_up_p50_us: c.wake_up_us.p50,
            wake_up_p99_us: c.wake_up_us.p99,
            wake_up_max_us: c.wake_up_us.max,
            compute_p50_us: c.compute_us.p50,
            compute_p99_us: c.compute_us.p99,
            compute_max_us: c.compute_us.max,
            frames_lost_count: c.frames_lost as f64,
            silent_count: c.silent_ticks as f64,
            controller_overrun_count: c.overruns as f64,
        }
    }
}

row! {
    /// What the rider does over the tick.
    pub struct RiderRow {
        /// Torque on the handlebar, Nm.
        steer_torque_nm,
        /// Torque that leans the trunk to the right, Nm.
        trunk_lean_torque_nm,
        /// Torque that turns the left leg outward, Nm.
        left_leg_torque_nm,
        /// Torque that turns the right leg outward, Nm.
        right_leg_torque_nm,
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
        trunk_lean_rad: t.trunk_lean_rad,
        left_leg_rad: t.legs_rad[0],
        right_leg_rad: t.legs_rad[1],
        ..TruthRow::default()
    }
}
