//! Free runs of the lateral predictor from where it stands.

use super::course::Course;
use super::lateral::walk;
use super::pass::Pass;
use super::ride::Ride;
use super::setup::{Model, Setup};
use super::state::Pace;

/// A free run: when it started, and what it says of each reading that it met.
pub struct FreeRun {
    pub start_s: f64,
    /// Reading, and what it should be.
    pub said: Vec<(usize, f64)>,
}

/// Free runs of up to `horizon_s`, started every `restart_s` within each window.
pub fn free_runs(
    ride: &Ride,
    course: &Course,
    setup: &Setup,
    model: &Model,
    paces: &[Pace],
    horizon_s: f64,
    restart_s: f64,
) -> Vec<FreeRun> {
    let mut pass = Pass::empty(course);
    let mut runs = vec![];
    let mut next_s = f64::INFINITY;
    walk(
        ride,
        course,
        setup,
        model,
        paces,
        &mut pass,
        &mut |work, index| {
            let step = &course.steps[index];
            if step.fresh {
                next_s = step.t_s + restart_s;
            }
            if step.t_s < next_s - 1e-6 {
                return;
            }
            next_s += restart_s;
            let mut free = work.clone();
            free.blind = true;
            let mut sink = Pass::empty(course);
            let mut pace = paces[index];
            for (k, later) in course.steps.iter().enumerate().skip(index + 1) {
                if later.fresh || later.t_s > step.t_s + horizon_s + 1e-6 {
                    break;
                }
                let slip = if later.dt_s > 0.0 {
                    free.advance(later, &pace, &paces[k], &mut sink)
                } else {
                    0.0
                };
                free.read(course, k, &paces[k], slip, &mut sink);
                pace = paces[k];
            }
            runs.push(FreeRun {
                start_s: step.t_s,
                said: std::mem::take(&mut free.said),
            });
        },
    );
    runs
}
