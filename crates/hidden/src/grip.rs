//! What grips and sticks: side forces of slipping tyres, dry friction of the steering.

use crate::motion::{Motion, STIFF_RAD_N};
use crate::state::*;

impl Motion {
    /// Side forces of slipping tyres.
    pub(crate) fn side_forces_n(&self, x: &State, accel: f64) -> [f64; 2] {
        let (t, s) = (&self.truth, &self.sums);
        let k = if t.compliance_rad_n > 0.0 {
            t.compliance_rad_n
        } else {
            STIFF_RAD_N
        };
        let v = x[SPEED].max(0.5);
        let front_slide =
            x[SIDE] + s.w * x[YAW_RATE] - s.cos * (s.c * x[STEER_RATE] + v * x[STEER]);
        let grip = |at_m: f64, load_n: f64| match t.patch {
            Some(p) => {
                let slippery = (p.at_m..p.at_m + p.length_m).contains(&at_m);
                if slippery { p.mu * load_n } else { load_n }
            }
            None => f64::INFINITY,
        };
        let front_grip = grip(x[DISTANCE] + s.w, s.front_load_n(accel));
        let rear_grip = grip(x[DISTANCE], s.rear_load_n(accel));
        [
            (-front_slide / (v * k)).clamp(-front_grip, front_grip),
            (-x[SIDE] / (v * k)).clamp(-rear_grip, rear_grip),
        ]
    }

    /// The torque of dry friction that would stop the steer within a step, within its limit.
    pub fn friction_nm(&self, x: &State, d: &Drive, step_s: f64) -> f64 {
        let limit = self.truth.coulomb_nm;
        if limit == 0.0 {
            return 0.0;
        }
        let at = |friction_nm: f64| self.change(x, &Drive { friction_nm, ..*d }).rate[STEER_RATE];
        let free = at(0.0);
        let per_nm = at(1.0) - free;
        (-(x[STEER_RATE] + step_s * free) / (step_s * per_nm)).clamp(-limit, limit)
    }
}
