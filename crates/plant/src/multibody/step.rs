//! What: one step of the plant on tyres, with the creep of the wheels treated exactly.
//!
//! Equation: on tyres the fastest motion is the creep of a wheel towards rolling,
//! J Ω' = -l Fx(κ), κ = (Ω l - v) / s: it dies out at the rate C l² / (J s) with C = dFx/dκ at the
//! present slip, about 900 1/s at 5 m/s and 1.5e4 1/s at 0.3 m/s. This decay is integrated exactly
//! (`rk4_decaying`), the rest by fourth-order Runge-Kutta. A step is divided where what is left is
//! too fast for that (2.78 times one over the step; 2 is used): the side slip below 1 m/s, at the
//! rate Cα Fz / (m s) with m the mass that a side force in the contact moves, and a sliding wheel
//! that may grip again, by the difference between the rates at zero and at present slip.
//!
//! Source: Cox and Matthews (2002), Journal of Computational Physics 176 (exponential
//! Runge-Kutta); Hairer and Wanner (1996), Solving Ordinary Differential Equations II, section
//! IV.2 (stability of explicit methods).
//!
//! Assumes and ignores: no input changes over a step. Relaxed slip is not stiff and decays by no
//! rate here.
//!
//! Valid for: 0.3 to 12 m/s; a fall stays finite.
//!
//! Checked by: `a_step_of_a_millisecond_is_exact_enough_at_any_speed` and
//! `riding_keeps_the_fourth_order` in `multibody/tests`, tests of `integrate`.

use super::constraint::{along, unit_forces};
use super::contact::{WheelContact, contact_points};
use super::model::{Input, Multibody};
use super::state::{SPIN, STATES, State};
use crate::Scalar;
use crate::dual::Dual;
use crate::integrate::{Decay, rk4, rk4_decaying};
use crate::road::Road;
use crate::tyre::{TyreInput, TyreModel};

/// Parts of a step at most.
const PARTS: f64 = 64.0;
/// Step times fastest rate that a part may reach.
const STIFFNESS_LIMIT: f64 = 2.0;

/// How fast contact forces act back on the tyres' slip: rates times speed per newton of load,
/// m/(s² N), of rear and front wheel.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Stiffness {
    /// Longitudinal slip: C / Fz without slip, times 1/J; times l² in use.
    creep: [f64; 2],
    /// Side slip: Cα / Fz over the mass that a side force moves.
    side: [f64; 2],
}

impl Stiffness {
    /// Of a model, upright. Zero without slip, or if slip is relaxed.
    pub(super) fn of(model: &Multibody) -> Self {
        let mut found = Self::default();
        if model.no_slip {
            return found;
        }
        let x: State = model.upright(1.0);
        let pose = model.tree.pose(&x);
        let grounds = model.grounds(&x, &pose, None);
        let points = contact_points(&model.tree, &x, &pose, &grounds, true);
        let factored = model.tree.factor(&x, &pose, model.parameters.gravity_m_s2);
        let rows = unit_forces(&model.tree, &points);
        let (front, rear) = model.static_loads_n();
        for (k, load_n) in [rear, front].into_iter().enumerate() {
            let (tyre, part) = (&model.tyres[k], &model.tree.wheels[k]);
            if tyre.relaxation_length_m().is_some() || load_n <= 0.0 {
                continue;
            }
            let constant = Dual::<1>::constant;
            let slipping = tyre.output(&TyreInput {
                load_n: constant(load_n),
                slip_ratio: constant(0.0),
                slip_angle_rad: Dual::variable(0.0, 0),
                camber_rad: constant(0.0),
                speed_m_s: constant(1.0),
                friction_ratio: constant(1.0),
                radius_m: part.radius,
            });
            found.creep[k] = slipping.longitudinal_stiffness_n.re / load_n * part.inverse_inertia;
            let sideways = factored.response(&model.tree, &rows[3 * k + 1]);
            let per_mass = along(
                &rows[3 * k + 1],
                &sideways.base,
                sideways.steer,
                sideways.spin,
            );
            found.side[k] = -slipping.lateral_n.eps[0] / load_n * per_mass;
        }
        found
    }
}

/// Rates at which creep dies out, 1/s, and the fastest of what is left.
struct Rates<T> {
    creep: [T; 2],
    rest: T,
}

impl Multibody {
    /// Rates in these contacts.
    #[inline(always)]
    fn rates<T: Scalar>(&self, contacts: &[WheelContact<T>; 2]) -> Rates<T> {
        let zero = T::zero();
        let floor = self.parameters.tyre.slip_speed_floor_m_s;
        let mut rates = Rates {
            creep: [zero; 2],
            rest: zero,
        };
        for (k, c) in contacts.iter().enumerate() {
            let (part, stiff) = (&self.tree.wheels[k], &self.stiff);
            let per_speed =
                T::one() / (c.speed_m_s * c.speed_m_s + T::from_f64(floor * floor)).sqrt();
            let radius = T::from_f64(part.radius) - c.deflection_m;
            let lever = radius * radius * per_speed;
            let rolling = lever * c.load_n.scale(stiff.creep[k]);
            if stiff.creep[k] != 0.0 {
                // Past the peak of the force nothing decays.
                let slope = c.tyre.longitudinal_stiffness_n.scale(part.inverse_inertia);
                rates.creep[k] = (lever * slope).max(zero);
            }
            let side = per_speed * c.load_n.scale(stiff.side[k]);
            rates.rest = rates.rest.max(rolling - rates.creep[k]).max(side);
        }
        rates
    }

    /// Parts into which a step is divided, given the fastest rate that is left.
    fn parts<T: Scalar>(rates: &Rates<T>, step_s: f64) -> usize {
        let parts = rates.rest.largest() * step_s / STIFFNESS_LIMIT;
        (parts.clamp(1.0, PARTS).ceil() as usize).max(1)
    }

    /// Goes on by `step_s` seconds; gives the number of parts that it took. `rhs` is the
    /// right-hand side, compiled for this processor; `first` is the same where it is called first,
    /// in the state in which the step begins.
    #[inline(always)]
    pub(super) fn step_by<T: Scalar>(
        &self,
        x: &mut State<T>,
        step_s: f64,
        first: impl FnOnce(&State<T>, &mut State<T>) -> Option<[WheelContact<T>; 2]>,
        rhs: impl Fn(&State<T>, &mut State<T>) -> Option<[WheelContact<T>; 2]>,
    ) -> usize {
        let mut slope = [T::zero(); STATES];
        let Some(contacts) = first(x, &mut slope) else {
            rk4(x, step_s, |x, dx| {
                rhs(x, dx);
            });
            self.project(x);
            return 1;
        };
        let mut rates = self.rates(&contacts);
        let parts = Self::parts(&rates, step_s);
        let part_s = step_s / parts as f64;
        for part in 0..parts {
            if part > 0
                && let Some(contacts) = rhs(x, &mut slope)
            {
                rates = self.rates(&contacts);
            }
            let decays = [
                Decay::new(rates.creep[0], part_s),
                Decay::new(rates.creep[1], part_s),
            ];
            rk4_decaying(x, part_s, SPIN, &decays, &slope, |x, dx| {
                rhs(x, dx);
            });
            self.project(x);
        }
        parts
    }

    /// Parts into which a step of `step_s` would be divided in state `x`.
    pub fn parts_of_step(
        &self,
        x: &State,
        input: &Input,
        road: Option<&Road>,
        step_s: f64,
    ) -> usize {
        let mut dx = [0.0; STATES];
        self.rhs_inlined(x, input, road, &mut dx)
            .map_or(1, |contacts| Self::parts(&self.rates(&contacts), step_s))
    }
}
