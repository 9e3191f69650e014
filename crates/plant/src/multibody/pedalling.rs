//! What: legs that pedal: crank, cadence, pedal forces, and what they do to the bicycle.
//!
//! Equation: with θ the angle of the right crank from its upper dead centre, Ω the cadence, L the
//! crank, and F the driving force that the rider asks for at the rear contact (mean over a turn):
//!
//! ```text
//! crank torque      T(θ) = T0 (1 - cos 2θ),      T0 Ω = F R ω_rear  (power)
//! torque on wheel   F R (1 - cos 2θ)
//! right pedal down  P(θ) = P_rest + 2 A (1/π + sin θ / 2 - 2/(3π) cos 2θ),   A = T0 / L
//! left pedal        P(θ + π)
//! pedals' moment about x     M = q (P(θ) - P(θ + π)) = 2 q A sin θ
//! a leg's centre of mass     d(θ) = L (a_x cos θ + b_x sin θ, a_z cos θ + b_z sin θ)
//! legs' moment on the frame  (2 y m Ω² d_z, 0, -2 y m Ω² d_x)
//! ```
//!
//! P is a half-wave rectified sine of amplitude 2 A to second order: the leg pushes down on the way
//! down. Since P is vertical, its torque L sin θ (P(θ) - P(θ + π)) is exactly T(θ). So the roll
//! moments go once a turn, the driving torque and the sum of the pedal forces twice: the orders that
//! Bulsink (2017), section 5.3, found in his measurements and residuals.
//!
//! Source: Bulsink (2017), chapter 5 (what the model has to hold: crank, pedal forces on the way
//! down, frequencies of saddle forces); the equations are our own working out. Harmonics of a
//! leg's centre of mass: two links between hip and crank with the segments of A.3
//! (`rider_body`), worked out for the 1.80 m rider.
//!
//! Assumes and ignores: cadence is constant while the rider pedals (he shifts gears), and the crank
//! stands still while he does not; starting and stopping are sudden. The legs' motion is prescribed
//! to first order of the crank angle: their inertia as seen by joints and frame stays that of rest,
//! and coupling with the frame's own rates is left out. With a pelvis held by the saddle the pedal
//! forces are internal and leave no moment; `through_trunk_ratio` is the share of their roll moment
//! that the trunk balances instead (a guess to be varied). Lateral pedal forces and the pedals'
//! angle are left out.
//!
//! Valid for: 0 to 15 rad/s of cadence.
//!
//! Checked by: the tests of this file: power over a turn (1e-9), orders of moments and forces,
//! mirror symmetry half a turn later, nothing without pedalling.

use super::error::MultibodyError;
use super::model::Input;
use super::ride::Ride;
use super::state::SPIN;
use crate::explain::Explain;
use core::f64::consts::{PI, TAU};
use serde::{Deserialize, Serialize};

/// Parameters of pedalling legs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pedalling {
    /// Rate of the crank while the rider pedals, rad/s.
    pub cadence_rad_s: f64,
    /// Length of the crank, m.
    pub crank_length_m: f64,
    /// Middle of each pedal from the middle of the frame, m.
    pub pedal_offset_m: f64,
    /// Force on each pedal while the legs rest, downward, N.
    pub resting_force_n: f64,
    /// Share of the pedals' roll moment that the trunk balances instead of the saddle, 0 to 1.
    pub through_trunk_ratio: f64,
    /// Mass of each leg, kg, whether it is a body of its own or part of a rigid rider.
    pub leg_mass_kg: f64,
    /// Its centre of mass from the middle of the frame, m.
    pub leg_aside_m: f64,
    /// Forward motion of a leg's centre of mass over crank length, with cos θ.
    pub leg_forward_cos_ratio: f64,
    /// Forward motion of a leg's centre of mass over crank length, with sin θ.
    pub leg_forward_sin_ratio: f64,
    /// Downward motion of a leg's centre of mass over crank length, with cos θ.
    pub leg_down_cos_ratio: f64,
    /// Downward motion of a leg's centre of mass over crank length, with sin θ.
    pub leg_down_sin_ratio: f64,
}

impl Default for Pedalling {
    /// 60 turns a minute on a 170 mm crank; the legs of the 1.80 m rider of Bulsink (2017). Pedal
    /// offset and resting force (half a leg) are guesses.
    fn default() -> Self {
        Self {
            cadence_rad_s: TAU,
            crank_length_m: 0.17,
            pedal_offset_m: 0.12,
            resting_force_n: 60.0,
            through_trunk_ratio: 0.0,
            leg_mass_kg: 12.6,
            leg_aside_m: 0.086,
            leg_forward_cos_ratio: 0.178,
            leg_forward_sin_ratio: 0.2135,
            leg_down_cos_ratio: -0.5672,
            leg_down_sin_ratio: -0.0731,
        }
    }
}

/// What `twinhub explain pedalling` says.
pub const PEDALLING: Explain = Explain {
    name: "pedalling",
    what: "legs that pedal: crank, cadence, pedal forces, inertia of the legs; a table of the plant file, off where it is absent (set pedalling=default)",
    equation: "crank torque T0 (1 - cos 2θ) with T0 Ω = F R ω_rear; pedal force P_rest + 2 A (1/π + sin θ/2 - 2/(3π) cos 2θ), A = T0/L; legs' moment (2 y m Ω² d_z, 0, -2 y m Ω² d_x) with d the first harmonic of a leg's centre of mass",
    source: "Bulsink (2017), chapter 5, for what is modelled and for the orders of the forces; equations and harmonics our own working out; pedal offset, resting force and the trunk's share are guesses",
    assumes: "constant cadence while pedalling; first order of the legs' motion; inertia of the legs as at rest; vertical pedal forces, internal where the saddle holds the pelvis",
};

/// What the pedals do at one moment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stroke {
    /// Angle of the right crank from its upper dead centre, rad, in [0, 2π).
    pub crank_rad: f64,
    /// Rate of the crank, rad/s.
    pub cadence_rad_s: f64,
    /// Torque at the crank, Nm.
    pub crank_torque_nm: f64,
    /// Torque on the rear wheel, Nm.
    pub wheel_torque_nm: f64,
    /// Forces on left and right pedal, downward, N.
    pub pedals_n: [f64; 2],
    /// Moment of the pedal forces about the forward axis of the frame, Nm.
    pub pedals_roll_moment_nm: f64,
    /// Moment of the legs' inertia on the frame: forward, right, down, Nm.
    pub legs_moment_nm: [f64; 3],
}

impl Pedalling {
    /// Refuses what no legs can do.
    pub(super) fn validate(&self) -> Result<(), MultibodyError> {
        for (key, found, low, high, accepted) in [
            ("cadence_rad_s", self.cadence_rad_s, 0.1, 15.0, "0.1 to 15"),
            (
                "crank_length_m",
                self.crank_length_m,
                0.05,
                0.3,
                "0.05 to 0.3",
            ),
            ("pedal_offset_m", self.pedal_offset_m, 0.0, 0.5, "0 to 0.5"),
            (
                "resting_force_n",
                self.resting_force_n,
                0.0,
                1000.0,
                "0 to 1000",
            ),
            (
                "through_trunk_ratio",
                self.through_trunk_ratio,
                0.0,
                1.0,
                "0 to 1",
            ),
            ("leg_mass_kg", self.leg_mass_kg, 0.0, 50.0, "0 to 50"),
            ("leg_aside_m", self.leg_aside_m, 0.0, 0.5, "0 to 0.5"),
            (
                "leg_forward_cos_ratio",
                self.leg_forward_cos_ratio,
                -1.0,
                1.0,
                "-1 to 1",
            ),
            (
                "leg_forward_sin_ratio",
                self.leg_forward_sin_ratio,
                -1.0,
                1.0,
                "-1 to 1",
            ),
            (
                "leg_down_cos_ratio",
                self.leg_down_cos_ratio,
                -1.0,
                1.0,
                "-1 to 1",
            ),
            (
                "leg_down_sin_ratio",
                self.leg_down_sin_ratio,
                -1.0,
                1.0,
                "-1 to 1",
            ),
        ] {
            if !(found >= low && found <= high) {
                return Err(MultibodyError::OutOfRange {
                    path: format!("pedalling.{key}"),
                    found,
                    accepted,
                });
            }
        }
        Ok(())
    }

    /// The stroke at a crank angle, driving the wheel with `wheel_nm` (mean over a turn) at
    /// `wheel_rad_s`. Nothing moves unless `wheel_nm` is positive.
    pub fn stroke(&self, crank_rad: f64, wheel_nm: f64, wheel_rad_s: f64) -> Stroke {
        let crank_rad = crank_rad.rem_euclid(TAU);
        if wheel_nm <= 0.0 {
            return Stroke {
                crank_rad,
                pedals_n: [self.resting_force_n; 2],
                ..Stroke::default()
            };
        }
        let cadence = self.cadence_rad_s;
        let (s, c) = libm::sincos(crank_rad);
        let twice = 1.0 - libm::cos(2.0 * crank_rad);
        let mean_nm = wheel_nm * wheel_rad_s / cadence;
        let push = mean_nm / self.crank_length_m;
        let pedal = |angle: f64| {
            let wave =
                1.0 / PI + 0.5 * libm::sin(angle) - 2.0 / (3.0 * PI) * libm::cos(2.0 * angle);
            self.resting_force_n + 2.0 * push * wave
        };
        let lever = 2.0 * self.leg_aside_m * self.leg_mass_kg;
        let reach = self.crank_length_m * cadence * cadence * lever;
        let forward = self.leg_forward_cos_ratio * c + self.leg_forward_sin_ratio * s;
        let down = self.leg_down_cos_ratio * c + self.leg_down_sin_ratio * s;
        Stroke {
            crank_rad,
            cadence_rad_s: cadence,
            crank_torque_nm: mean_nm * twice,
            wheel_torque_nm: wheel_nm * twice,
            pedals_n: [pedal(crank_rad + PI), pedal(crank_rad)],
            pedals_roll_moment_nm: 2.0 * self.pedal_offset_m * push * s,
            legs_moment_nm: [reach * down, 0.0, -reach * forward],
        }
    }
}

impl Ride {
    /// The legs' parameters, if they pedal.
    pub fn pedals(&self) -> Option<&Pedalling> {
        self.model().parameters().pedalling.as_ref()
    }

    /// The stroke now, where the rider asks for `pedal_force_n` at the rear contact. Without
    /// pedalling legs the force acts evenly.
    pub fn pedal_stroke(&self, pedal_force_n: f64) -> Stroke {
        let parameters = self.model().parameters();
        let wheel_nm = pedal_force_n * parameters.rear_wheel.radius_m;
        match &parameters.pedalling {
            None => Stroke {
                wheel_torque_nm: wheel_nm,
                ..Stroke::default()
            },
            Some(pedalling) => pedalling.stroke(self.crank_rad, wheel_nm, self.state()[SPIN]),
        }
    }

    /// `input` with what the pedals add now.
    pub fn with_pedals(&self, input: &Input, pedal_force_n: f64) -> Input {
        let stroke = self.pedal_stroke(pedal_force_n);
        let share = self.pedals().map_or(0.0, |p| p.through_trunk_ratio);
        let mut with = *input;
        with.rear_traction_nm += stroke.wheel_torque_nm;
        for (moment, legs) in with.moment_nm.iter_mut().zip(stroke.legs_moment_nm) {
            *moment += legs;
        }
        with.trunk_torque_nm[0] -= share * stroke.pedals_roll_moment_nm;
        with
    }

    /// Goes on by `step_s` seconds under `input` and the pedals.
    pub fn pedal(&mut self, input: &Input, pedal_force_n: f64, step_s: f64) {
        let with = self.with_pedals(input, pedal_force_n);
        let cadence = self.pedal_stroke(pedal_force_n).cadence_rad_s;
        self.advance(&with, step_s);
        self.crank_rad = (self.crank_rad + cadence * step_s).rem_euclid(TAU);
    }
}

#[cfg(test)]
mod tests {
    use super::super::{BulsinkBicycle, Case, Parameters, Reading};
    use super::*;
    use crate::PlantModel;
    use crate::truth::PlantInput;

    const N: usize = 720;

    fn turn(p: &Pedalling) -> Vec<Stroke> {
        (0..N)
            .map(|k| p.stroke(TAU * k as f64 / N as f64, 7.0, 14.0))
            .collect()
    }

    /// Amplitude of harmonic `n` of a quantity over a turn.
    fn order(turn: &[Stroke], n: f64, of: impl Fn(&Stroke) -> f64) -> f64 {
        let sum = |f: fn(f64) -> f64| -> f64 {
            let terms = turn.iter().map(|s| of(s) * f(n * s.crank_rad));
            terms.sum::<f64>() * 2.0 / N as f64
        };
        libm::hypot(sum(libm::cos), sum(libm::sin))
    }

    #[test]
    fn mean_power_is_mean_torque_times_cadence() {
        let p = Pedalling::default();
        let turn = turn(&p);
        let mean = |of: fn(&Stroke) -> f64| turn.iter().map(of).sum::<f64>() / N as f64;
        let power = mean(|s| s.crank_torque_nm * s.cadence_rad_s);
        assert!((power - 7.0 * 14.0).abs() < 1e-9 * power, "{power}");
        assert!((mean(|s| s.wheel_torque_nm) - 7.0).abs() < 1e-9);
        // The vertical pedal forces make that torque at every angle.
        for s in &turn {
            let [left, right] = s.pedals_n;
            let torque = p.crank_length_m * libm::sin(s.crank_rad) * (right - left);
            assert!((torque - s.crank_torque_nm).abs() < 1e-9, "{s:?}");
            let roll = p.pedal_offset_m * (right - left);
            assert!((roll - s.pedals_roll_moment_nm).abs() < 1e-9, "{s:?}");
        }
    }

    #[test]
    fn roll_goes_once_a_turn_and_drive_twice() {
        let turn = turn(&Pedalling::default());
        for of in [
            (|s| s.legs_moment_nm[0]) as fn(&Stroke) -> f64,
            |s| s.legs_moment_nm[2],
            |s| s.pedals_roll_moment_nm,
        ] {
            assert!(order(&turn, 1.0, of) > 0.1);
            assert!(order(&turn, 2.0, of) < 1e-9);
        }
        for of in [(|s| s.crank_torque_nm) as fn(&Stroke) -> f64, |s| {
            s.pedals_n[0] + s.pedals_n[1]
        }] {
            assert!(order(&turn, 2.0, of) > 0.1);
            assert!(order(&turn, 1.0, of) < 1e-9);
        }
    }

    #[test]
    fn half_a_turn_later_left_and_right_are_exchanged() {
        let turn = turn(&Pedalling::default());
        for (now, later) in turn.iter().zip(turn[N / 2..].iter()) {
            let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-9, "{now:?} {later:?}");
            near(now.pedals_n[0], later.pedals_n[1]);
            near(now.pedals_n[1], later.pedals_n[0]);
            near(now.crank_torque_nm, later.crank_torque_nm);
            near(now.pedals_roll_moment_nm, -later.pedals_roll_moment_nm);
            near(now.legs_moment_nm[0], -later.legs_moment_nm[0]);
            near(now.legs_moment_nm[2], -later.legs_moment_nm[2]);
        }
    }

    #[test]
    fn legs_that_rest_do_nothing() {
        let p = Pedalling::default();
        let s = p.stroke(1.0, 0.0, 14.0);
        assert_eq!(s.legs_moment_nm, [0.0; 3]);
        assert_eq!((s.crank_torque_nm, s.cadence_rad_s), (0.0, 0.0));
        assert_eq!(s.pedals_n, [p.resting_force_n; 2]);
    }

    #[test]
    fn a_pedalling_rider_drives_and_sways_as_the_even_one_drives() {
        let even =
            Parameters::bulsink2017(BulsinkBicycle::One, Case::TyresRigid, &Reading::default());
        let mut pedalling = even.clone();
        pedalling.pedalling = Some(Pedalling::default());
        let ride = |p: &Parameters| {
            let mut ride = Ride::new(p, None, 10.0).unwrap();
            let mut sway: f64 = 0.0;
            for _ in 0..3000 {
                let push = PlantInput {
                    pedal_force_n: 20.0,
                    ..PlantInput::default()
                };
                ride.step(&push, 1e-3);
                sway = sway.max(ride.truth().roll_rad.abs());
            }
            (ride.truth().speed_m_s, sway, ride.crank_rad)
        };
        let (a, b) = (ride(&even), ride(&pedalling));
        assert!(a.0 > 10.02 && (a.0 - b.0).abs() < 2e-3, "{a:?} {b:?}");
        assert!(a.1 < 1e-12, "{a:?}");
        assert!(b.1 > 1e-5, "{b:?}");
        // Three seconds at one turn a second.
        assert!(b.2 < 1e-9 || TAU - b.2 < 1e-9, "{}", b.2);
    }
}
