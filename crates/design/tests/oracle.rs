//! The closed form of the allocation against the cone program that it solves.
//!
//! `TWINHUB_ORACLE_CASES=5000` makes it a short run.

use twinhub_control::Config;
use twinhub_control::allocation::{Allocation, Envelope};
use twinhub_control::law::Demand;
use twinhub_control::supply::EFFICIENCY;
use twinhub_design::{Oracle, Power, Road, Wish};
use twinhub_types::Estimate;

/// xorshift64*.
struct Dice(u64);

impl Dice {
    fn within(&mut self, low: f64, high: f64) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        let bits = self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11;
        low + (high - low) * bits as f64 / (1u64 << 53) as f64
    }
}

#[test]
fn the_closed_form_agrees_with_the_cone_program() {
    let cases: u32 = std::env::var("TWINHUB_ORACLE_CASES")
        .ok()
        .and_then(|text| text.parse().ok())
        .unwrap_or(100_000);
    let mut dice = Dice(0x9e37_79b9_7f4a_7c15);
    let (mut limited, mut free, mut nothing) = (0, 0, 0);
    for case in 0..cases {
        let mut config = Config::NO_TORQUE;
        config.limits.torque_max_nm = dice.within(0.0, 80.0) as f32;
        config.limits.friction_assumed_ratio = Some(dice.within(0.1, 1.2) as f32);
        config.bicycle.front_wheel_radius_m = dice.within(0.25, 0.37) as f32;
        config.bicycle.rear_wheel_radius_m = dice.within(0.25, 0.37) as f32;
        config.bicycle.front_load_n = dice.within(150.0, 600.0) as f32;
        config.bicycle.rear_load_n = dice.within(200.0, 900.0) as f32;
        config.bicycle.com_height_m = dice.within(0.5, 1.3) as f32;
        let mut sometimes = |low: f64, high: f64| {
            let value = dice.within(low, high) as f32;
            (dice.within(0.0, 1.0) < 0.5).then_some(value)
        };
        config.limits.battery_out_max_w = sometimes(10.0, 800.0);
        config.limits.battery_in_max_w = sometimes(0.0, 200.0);
        config.limits.motor_power_max_w = sometimes(50.0, 900.0);
        let x = Estimate {
            roll_rad: dice.within(-0.5, 0.5) as f32,
            speed_m_s: dice.within(0.0, 9.0) as f32,
            ..Estimate::default()
        };
        let demand = Demand {
            pair_nm: dice.within(0.0, 120.0) as f32,
            trim_nm: dice.within(-30.0, 30.0) as f32,
            ..Demand::default()
        };
        let bounds = Envelope::new(&config).at(&x, 1.0, 1.0);
        let split = Allocation::new(&config).split(&demand, &bounds);
        let ours_nm = f64::from(split.pair_nm.min(split.pair_ceiling_nm));

        let b = &config.bicycle;
        let r_f = f64::from(b.front_wheel_radius_m);
        let road = Road {
            friction_ratio: f64::from(config.limits.friction_ratio()),
            side_ratio: f64::from(x.roll_rad).abs().tan(),
            front_load_n: f64::from(b.front_load_n),
            rear_load_n: f64::from(b.rear_load_n),
            transfer_ratio: f64::from(b.com_height_m) / f64::from(b.wheelbase_m),
        };
        let over_speed = |most_w: Option<f32>| {
            most_w.map_or(f64::INFINITY, |w| {
                f64::from(w) / f64::from(x.speed_m_s).max(0.5)
            })
        };
        let power = Power {
            efficiency: f64::from(EFFICIENCY),
            motor_n: over_speed(config.limits.motor_power_max_w),
            out_n: over_speed(config.limits.battery_out_max_w),
            in_n: over_speed(config.limits.battery_in_max_w),
        };
        let most_nm = f64::from(bounds.pair_max_nm);
        let r_r = f64::from(b.rear_wheel_radius_m);
        // Where no pair is allowed, no drive is either.
        let drive_n = if most_nm > 0.0 {
            f64::from(demand.trim_nm) / r_r
        } else {
            0.0
        };
        let wish = Wish {
            pair_n: f64::from(demand.pair_nm) / r_f,
            most_n: most_nm / r_f,
            drive_n,
        };
        let held_n = Oracle
            .drive_n(&road, &power, &wish)
            .unwrap_or_else(|e| panic!("case {case}: {e}; {road:?} {power:?} {wish:?}"));
        let near_edge = (road.friction_ratio - road.side_ratio).abs() < 1e-3;
        let ours_n = f64::from(split.trim_nm) / r_r;
        assert!(
            (ours_n - held_n).abs() <= 5e-3 + 1e-4 * held_n.abs() || near_edge,
            "case {case}: closed form drives {ours_n} N, cone program {held_n} N; {config:?} {x:?} {demand:?}"
        );
        let oracle_n = Oracle
            .pair_n(&road, &power, &wish, ours_n)
            .unwrap_or_else(|e| panic!("case {case}: {e}; {road:?} {power:?} {wish:?}"));
        let oracle_nm = oracle_n * r_f;
        // Where next to no friction is left, the root of a difference magnifies the rounding.
        let close_nm = 2e-3 + 1e-4 * oracle_nm.abs();
        assert!(
            (ours_nm - oracle_nm).abs() <= close_nm || near_edge && ours_nm <= oracle_nm + 2.0,
            "case {case}: closed form {ours_nm} Nm, cone program {oracle_nm} Nm; {config:?} {x:?} {demand:?}"
        );
        if ours_nm < 1e-6 {
            nothing += 1;
        } else if ours_nm < f64::from(demand.pair_nm).min(most_nm) - 1e-3 {
            limited += 1;
        } else {
            free += 1;
        }
    }
    let least = cases / 50;
    assert!(
        limited > least && free > least && nothing > least,
        "every kind of case occurs: {limited} limited, {free} free, {nothing} without"
    );
}
