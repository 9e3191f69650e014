//! How much of the demand the tyres carry, and which wheel gets which torque. Closed form.
//!
//! # What
//! Side force comes first: what the friction ellipse leaves beside it may brake and drive.
//!
//! # Equation
//! In a steady turn side force and load have the ratio `tan(phi)` at both wheels, so of the
//! friction `mu` there remains `sqrt(mu² - tan²(phi))`, and `T <= R F_z sqrt(mu² - tan²(phi))`.
//! Net drive `F` takes the load `F h / w` from the front wheel; a balanced pair moves none. What battery
//! and motors leave: `supply`.
//!
//! # Source
//! Friction ellipse with equal axes; Bulsink (2017), chapter 7, for the pair.
//!
//! # Assumes and ignores
//! Level road; friction is one declared number for both wheels.
//!
//! # Valid for
//! Any state; lean beyond the friction angle leaves no torque.
//!
//! # Checked by
//! `published_limits_*` below: the limits at 15 degrees of lean, within 2 %.

use twinhub_types::{Estimate, LimitedBy};

use crate::bounded::Bounded as _;
use crate::config::Config;
use crate::estimator::GRAVITY_M_S2;
use crate::guard::Request;
use crate::law::Demand;
use crate::supply::{Supply, SupplyForces};

/// Largest uncertainty of roll that is added to the lean, rad.
const ROLL_SD_MAX_RAD: f32 = 0.05;

/// Largest uncertainty of speed that is added to it where power counts, m/s.
const SPEED_SD_MAX_M_S: f32 = 1.0;

/// What torques are possible now.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Largest pair that configuration and mode allow, Nm of the front motor.
    pub pair_max_nm: f32,
    /// True if the mode holds the pair below the configuration.
    pub by_mode: bool,
    /// True if the fork's life holds it there.
    pub by_fork: bool,
    /// Largest force of the front wheel that friction leaves, N.
    pub front_force_n: f32,
    /// Largest force of the rear wheel that friction leaves, N.
    pub rear_force_n: f32,
    /// Loss of front force per newton of net drive, dimensionless.
    pub transfer_ratio: f32,
    /// What battery and motors leave.
    pub supply: SupplyForces,
}

/// Limits as functions of the state.
#[derive(Clone, Copy, Debug)]
pub struct Envelope {
    pair_max_nm: f32,
    friction_ratio: f32,
    front_load_n: f32,
    rear_load_n: f32,
    load_transfer_ratio: f32,
    supply: Supply,
}

impl Envelope {
    /// The limits of a configuration that keeps the rules.
    pub fn new(config: &Config) -> Self {
        let bicycle = &config.bicycle;
        Self {
            pair_max_nm: config.limits.torque_max_nm * (1.0 / bicycle.balance_ratio()).at_most(1.0),
            friction_ratio: config.limits.friction_ratio(),
            front_load_n: bicycle.front_load_n,
            rear_load_n: bicycle.rear_load_n,
            load_transfer_ratio: bicycle.com_height_m / bicycle.wheelbase_m,
            supply: Supply::new(&config.limits),
        }
    }

    /// The limits in state `x`, when the mode allows `share_ratio` and the fork's life `fork_ratio` of the
    /// largest pair.
    pub fn at(&self, x: &Estimate, share_ratio: f32, fork_ratio: f32) -> Bounds {
        let lean_rad = (x.roll_rad.abs() + x.roll_sd_rad.at_most(ROLL_SD_MAX_RAD)).at_most(1.5);
        let by_roll = libm::tanf(lean_rad);
        let by_yaw = (x.speed_m_s * x.yaw_rate_rad_s).abs() / GRAVITY_M_S2;
        let side_ratio = by_roll.at_least(by_yaw);
        let left = self.friction_ratio * self.friction_ratio - side_ratio * side_ratio;
        let left_ratio = libm::sqrtf(left.at_least(0.0));
        Bounds {
            pair_max_nm: self.pair_max_nm * share_ratio * fork_ratio,
            by_mode: share_ratio < 1.0,
            by_fork: fork_ratio < 1.0,
            front_force_n: left_ratio * self.front_load_n,
            rear_force_n: left_ratio * self.rear_load_n,
            transfer_ratio: left_ratio * self.load_transfer_ratio,
            supply: self
                .supply
                .at(x.speed_m_s + x.speed_sd_m_s.at_most(SPEED_SD_MAX_M_S)),
        }
    }
}

/// Splits a demand over two motors.
#[derive(Clone, Copy, Debug)]
pub struct Allocation {
    front_wheel_radius_m: f32,
    rear_wheel_radius_m: f32,
}

impl Allocation {
    /// The allocation for these wheels.
    pub fn new(config: &Config) -> Self {
        Self {
            front_wheel_radius_m: config.bicycle.front_wheel_radius_m,
            rear_wheel_radius_m: config.bicycle.rear_wheel_radius_m,
        }
    }

    /// The torques within `bounds` that come closest to `demand`: the pair first, then the trim.
    pub fn split(&self, demand: &Demand, bounds: &Bounds) -> Request {
        let (r_f, r_r) = (self.front_wheel_radius_m, self.rear_wheel_radius_m);
        let mut limited_by = LimitedBy::NONE;
        let pair_nm = demand.pair_nm.at_least(0.0).at_most(bounds.pair_max_nm);
        if demand.pair_nm > bounds.pair_max_nm {
            let limit = if bounds.by_mode {
                LimitedBy::MODE
            } else if bounds.by_fork {
                LimitedBy::FORK
            } else {
                LimitedBy::MAGNITUDE
            };
            limited_by = limited_by.with(limit);
        }
        // No trim where the mode allows no torque.
        let wanted_n = if bounds.pair_max_nm > 0.0 {
            demand.trim_nm / r_r
        } else {
            0.0
        };
        // The pair's force may be no larger than either wheel carries beside the trim.
        let front_n = bounds.front_force_n - bounds.transfer_ratio * wanted_n.at_least(0.0);
        let rear_n = bounds.rear_force_n - wanted_n.at_least(0.0);
        let carried_nm = front_n.at_most(rear_n).at_least(0.0) * r_f;
        let held_n = wanted_n
            .at_least(-bounds.rear_force_n)
            .at_most(bounds.rear_force_n);
        if pair_nm > carried_nm || held_n != wanted_n {
            limited_by = limited_by.with(LimitedBy::FRICTION);
        }
        let trim_n = bounds.supply.drive_n(held_n);
        let powered_nm = bounds.supply.pair_n(trim_n) * r_f;
        if pair_nm > powered_nm || trim_n != held_n {
            limited_by = limited_by.with(LimitedBy::SUPPLY);
        }
        let ceiling_nm = carried_nm.at_most(powered_nm);
        Request {
            pair_nm,
            trim_nm: trim_n * r_r,
            pair_ceiling_nm: ceiling_nm,
            limited_by,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::tests::shipped;

    fn ceiling_nm(friction: Option<f32>, x: &Estimate) -> f32 {
        let mut config = shipped("constant");
        config.limits.friction_assumed_ratio = friction;
        let demand = Demand {
            pair_nm: 40.0,
            trim_nm: 0.0,
            ..Demand::default()
        };
        Allocation::new(&config)
            .split(&demand, &Envelope::new(&config).at(x, 1.0, 1.0))
            .pair_ceiling_nm
    }

    #[test]
    fn published_limits_of_the_front_tyre_are_met() {
        // Front tyre limits: 117, 70, 35 Nm upright, 63 and 16 Nm at 15 degrees of lean.
        let upright = Estimate::default();
        let leaning = Estimate {
            roll_rad: 15f32.to_radians(),
            ..upright
        };
        for (friction, x, expected_nm) in [
            (1.0, &upright, 117.0),
            (0.6, &upright, 70.0),
            (0.3, &upright, 35.0),
            (0.6, &leaning, 63.0),
            (0.3, &leaning, 16.0),
        ] {
            let found_nm = ceiling_nm(Some(friction), x);
            assert!(
                (found_nm / expected_nm - 1.0).abs() < 0.02,
                "{friction}: {found_nm} Nm"
            );
        }
        assert_eq!(ceiling_nm(None, &upright), ceiling_nm(Some(0.3), &upright));
    }

    #[test]
    fn a_turn_counts_as_lean_even_if_roll_says_upright() {
        let turning = Estimate {
            speed_m_s: 5.0,
            yaw_rate_rad_s: 0.7,
            ..Estimate::default()
        };
        assert_eq!(
            ceiling_nm(Some(0.3), &turning),
            0.0,
            "0.36 g of side force, friction 0.3"
        );
    }

    #[test]
    fn a_balanced_pair_balances_whatever_the_wheels() {
        let mut config = shipped("constant");
        config.bicycle.rear_wheel_radius_m = 0.25;
        let bounds = Envelope::new(&config).at(&Estimate::default(), 1.0, 1.0);
        let demand = Demand {
            pair_nm: 30.0,
            trim_nm: -50.0,
            ..Demand::default()
        };
        let split = Allocation::new(&config).split(&demand, &bounds);
        assert_eq!(split.pair_nm, 30.0);
        assert_eq!(split.trim_nm, -50.0);
        let demand = Demand {
            pair_nm: 30.0,
            trim_nm: 200.0,
            ..Demand::default()
        };
        let split = Allocation::new(&config).split(&demand, &bounds);
        assert!(split.trim_nm <= 0.8 * 700.0 * 0.25 + 1e-3);
        assert!(split.limited_by.any(LimitedBy::FRICTION) && split.pair_ceiling_nm == 0.0);
    }
}
