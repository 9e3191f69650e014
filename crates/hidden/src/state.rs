//! What moves, what drives it, and what its rates of change tell.

/// Number of states.
pub const STATES: usize = 20;
pub const ROLL: usize = 0;
pub const STEER: usize = 1;
pub const ROLL_RATE: usize = 2;
pub const STEER_RATE: usize = 3;
pub const YAW: usize = 4;
/// Lateral velocity of the rear contact.
pub const SIDE: usize = 5;
pub const YAW_RATE: usize = 6;
pub const SPEED: usize = 7;
pub const FRONT_ANGLE: usize = 8;
pub const CRANK: usize = 9;
/// Torques of the motors behind their lags.
pub const FRONT_MOTOR: usize = 10;
pub const REAR_MOTOR: usize = 11;
/// Torque of the rider's arms and its rate.
pub const TORQUE: usize = 12;
pub const TORQUE_RATE: usize = 13;
/// What swings on the rear frame, relative to it.
pub const SWING: usize = 14;
pub const SWING_RATE: usize = 15;
pub const BAR: usize = 16;
pub const BAR_RATE: usize = 17;
/// Memory of a damper or of hysteresis.
pub const MEMORY: usize = 18;
pub const DISTANCE: usize = 19;

pub type State = [f64; STATES];

/// What acts during one step.
#[derive(Clone, Copy, Debug, Default)]
pub struct Drive {
    /// What the rider's nerves ask of the arms.
    pub asked_nm: f64,
    /// Side force on the frame and where.
    pub pull_n: f64,
    pub pull_at_m: [f64; 2],
    pub front_brake_nm: f64,
    pub rear_traction_nm: f64,
    /// Force of a rider who pedals or a treadmill that pulls, without a torque that is measured.
    pub push_n: f64,
    pub road_roll_nm: f64,
    pub road_steer_nm: f64,
    pub gust_n: f64,
    pub hands_on: bool,
    /// -1 on the way back.
    pub direction: f64,
    /// Travel per turn of the cranks.
    pub development_m: f64,
    /// Steer torque of dry friction, found by `friction_nm`.
    pub friction_nm: f64,
}

/// Rates of change, and what a sensor or the answer wants to know besides.
#[derive(Clone, Copy, Debug)]
pub struct Change {
    pub rate: State,
    pub accel_m_s2: f64,
    pub yaw_rate_rad_s: f64,
    /// Roll and steer torque of what no library names.
    pub outside_nm: [f64; 2],
}
