//! What: a run of the nonlinear model under a law that looks at the state.
//!
//! Equation: the model's own integration at 1 ms (`twinhub_plant::multibody::Ride`).
//!
//! Source: Bulsink (2017), sections 7.2.2.2 and 7.3 (time signals).
//!
//! Assumes and ignores: a level road with friction 1.
//!
//! Valid for: as the model; a run goes on after a fall, and stays finite.
//!
//! Checked by: `tests/reproduction.rs`.

use crate::error::ReproduceError;
use twinhub_plant::multibody::{Course, Input, Parameters, Ride, StateAccess, state};

/// Integration step, s.
const STEP_S: f64 = 1.0e-3;
/// Steps to a sample of the trace.
const STEPS_PER_SAMPLE: usize = 10;

/// What a law sees.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    /// Time, s.
    pub t_s: f64,
    /// Roll, rad.
    pub roll_rad: f64,
    /// Forward component of the frame's angular velocity, rad/s.
    pub roll_rate_rad_s: f64,
    /// Steer, rad.
    pub steer_rad: f64,
    /// Steer rate, rad/s.
    pub steer_rate_rad_s: f64,
    /// Forward speed, m/s.
    pub speed_m_s: f64,
}

/// Time signals, sampled every 10 ms.
#[derive(Clone, Debug, Default)]
pub struct Trace {
    /// Time, s.
    pub t_s: Vec<f64>,
    /// Roll, rad.
    pub roll_rad: Vec<f64>,
    /// Steer, rad.
    pub steer_rad: Vec<f64>,
    /// Heading, rad.
    pub yaw_rad: Vec<f64>,
    /// Forward speed, m/s.
    pub speed_m_s: Vec<f64>,
    /// Torque on the handlebar, Nm.
    pub steer_torque_nm: Vec<f64>,
}

impl Trace {
    /// Rides `seconds` from the steady state of `course`; `law` turns what it sees, and the input of
    /// the steady state, into the input of a step.
    ///
    /// # Errors
    /// Where the course has no steady state.
    pub fn ride(
        parameters: &Parameters,
        course: &Course,
        seconds: f64,
        mut law: impl FnMut(&Seen, &Input) -> Input,
    ) -> Result<Self, ReproduceError> {
        let mut ride = Ride::new(parameters, None, course.speed_m_s)?;
        let steady = ride.model().steady(course, None)?;
        ride.set_state(&steady.state);
        let mut trace = Self::default();
        for k in 0..(seconds / STEP_S) as usize {
            let x = ride.state();
            let (yaw, roll, _) = x.yaw_roll_pitch_rad();
            let seen = Seen {
                t_s: k as f64 * STEP_S,
                roll_rad: roll,
                roll_rate_rad_s: x[state::ANGULAR],
                steer_rad: x[state::STEER],
                steer_rate_rad_s: x[state::STEER_RATE],
                speed_m_s: x[state::VELOCITY],
            };
            let input = law(&seen, &steady.input);
            if k % STEPS_PER_SAMPLE == 0 {
                trace.t_s.push(seen.t_s);
                trace.roll_rad.push(roll);
                trace.steer_rad.push(seen.steer_rad);
                trace.yaw_rad.push(yaw);
                trace.speed_m_s.push(seen.speed_m_s);
                trace.steer_torque_nm.push(input.steer_torque_nm);
            }
            ride.advance(&input, STEP_S);
        }
        Ok(trace)
    }

    /// Largest magnitude of `signal` between two times, rad.
    pub fn amplitude(&self, signal: &[f64], from_s: f64, to_s: f64) -> f64 {
        let within = |t: &f64| (from_s..to_s).contains(t);
        self.t_s
            .iter()
            .zip(signal)
            .filter(|(t, _)| within(t))
            .fold(0.0, |a, (_, v)| v.abs().max(a))
    }
}
