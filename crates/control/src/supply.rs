//! What the battery gives and takes, and what the motors can do at a speed.
//!
//! # What
//! Three limits of power as limits of the wheels' forces: the bus out of the battery, the bus back into
//! it, and each motor's mechanical power.
//!
//! # Equation
//! With efficiency `e` each way, pair force `F`, net drive `D` and speed `v` the bus gives
//! `v ((F + D) / e - e F)` while the rear drives: a balanced pair costs `v F (1 / e - e)`, what the front
//! regenerates taken off. So `F <= (P_out / v - D / e) / (1 / e - e)`, `D <= e P_out / v`, and braking
//! returns at most `-v e D <= P_in`.
//!
//! # Source
//! Energy balance; 85 % each way, as the energies of the league.
//!
//! # Assumes and ignores
//! One efficiency for both motors and all loads; both wheels at the bicycle's speed.
//!
//! # Valid for
//! Any speed; below [`SLOWEST_M_S`] powers are those of that speed.
//!
//! # Checked by
//! `crates/design/tests/oracle.rs`: against the program that it solves, on random cases.

use crate::bounded::Bounded as _;
use crate::config::Limits;

/// Efficiency of motor and drive, each way.
pub const EFFICIENCY: f32 = 0.85;
/// Speed below which power limits no force further, m/s.
pub const SLOWEST_M_S: f32 = 0.5;

/// Powers, W; infinite where nothing limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Supply {
    out_max_w: f32,
    in_max_w: f32,
    motor_max_w: f32,
}

/// What they leave at a speed, N.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SupplyForces {
    /// Largest force of either motor.
    pub motor_n: f32,
    /// Power of the battery over speed.
    pub out_n: f32,
    /// Power that it takes back over speed.
    pub in_n: f32,
}

impl Supply {
    /// The limits of a configuration.
    pub fn new(limits: &Limits) -> Self {
        let or_none = |limit: Option<f32>| limit.unwrap_or(f32::INFINITY);
        Self {
            out_max_w: or_none(limits.battery_out_max_w),
            in_max_w: or_none(limits.battery_in_max_w),
            motor_max_w: or_none(limits.motor_power_max_w),
        }
    }

    /// At this speed, m/s.
    pub fn at(&self, speed_m_s: f32) -> SupplyForces {
        let v = speed_m_s.at_least(SLOWEST_M_S);
        SupplyForces {
            motor_n: self.motor_max_w / v,
            out_n: self.out_max_w / v,
            in_n: self.in_max_w / v,
        }
    }
}

impl SupplyForces {
    /// The net drive nearest to `wanted_n` that they carry, N; negative brakes.
    pub fn drive_n(&self, wanted_n: f32) -> f32 {
        let most_n = (EFFICIENCY * self.out_n).at_most(self.motor_n);
        let least_n = -(self.in_n / EFFICIENCY).at_most(self.motor_n);
        wanted_n.at_least(least_n).at_most(most_n)
    }

    /// The largest pair beside a net drive of `drive_n`, N.
    pub fn pair_n(&self, drive_n: f32) -> f32 {
        let loss = 1.0 / EFFICIENCY - EFFICIENCY;
        let by_battery_n = (self.out_n - drive_n / EFFICIENCY) / loss;
        let by_motors_n = self.motor_n - drive_n.at_least(0.0);
        by_battery_n.at_most(by_motors_n).at_least(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::Config;

    fn limits() -> Limits {
        Limits {
            battery_out_max_w: Some(300.0),
            battery_in_max_w: Some(50.0),
            motor_power_max_w: Some(600.0),
            ..Config::NO_TORQUE.limits
        }
    }

    /// Power on the bus, W, of a pair and a net drive at a speed.
    fn bus_w(pair_n: f32, drive_n: f32, v: f32) -> f32 {
        let rear_n = pair_n + drive_n;
        let of = |force_n: f32| {
            if force_n > 0.0 {
                force_n / EFFICIENCY
            } else {
                force_n * EFFICIENCY
            }
        };
        v * (of(rear_n) + of(-pair_n))
    }

    #[test]
    fn the_bus_is_used_up_and_never_exceeded() {
        for v in [1.0, 3.0, 6.0] {
            let forces = Supply::new(&limits()).at(v);
            for wanted_n in [-400.0, -30.0, 0.0, 20.0, 400.0] {
                let drive_n = forces.drive_n(wanted_n);
                let pair_n = forces.pair_n(drive_n);
                for share in [0.0, 0.3, 1.0] {
                    let power_w = bus_w(share * pair_n, drive_n, v);
                    assert!(
                        (-50.01..=300.01).contains(&power_w),
                        "{power_w} W at {v} m/s"
                    );
                    assert!(v * (share * pair_n + drive_n).abs() < 600.01);
                }
                let full_w = bus_w(pair_n, drive_n, v);
                let motor_w = v * pair_n.max(pair_n + drive_n);
                assert!(
                    full_w > 299.0 || motor_w > 599.0,
                    "{full_w} W, motor {motor_w} W"
                );
            }
        }
    }

    #[test]
    fn without_limits_nothing_is_limited() {
        let forces = Supply::new(&Config::NO_TORQUE.limits).at(8.0);
        assert_eq!(forces.drive_n(-300.0), -300.0);
        assert!(forces.pair_n(-300.0) > 1e6 && forces.pair_n(300.0) > 1e6);
    }
}
