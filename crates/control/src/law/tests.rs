use super::trim::trim_nm;
use super::*;
use crate::config::tests::shipped;

fn riding(speed_m_s: f32, roll_rad: f32) -> Estimate {
    Estimate {
        speed_m_s,
        roll_rad,
        ..Estimate::default()
    }
}

#[test]
fn every_law_is_even_in_lean_and_bounded() {
    for name in Law::NAMES {
        let law = shipped(name).law;
        for speed_m_s in [0.0, 2.0, 3.5, 6.5, 9.0, 30.0] {
            for roll_rad in [0.0, 0.1, 0.3, 1.0] {
                let last = Demand::default();
                let right = law.demand(&last, &riding(speed_m_s, roll_rad), 10.0);
                let left = law.demand(&last, &riding(speed_m_s, -roll_rad), 10.0);
                assert_eq!(right, left, "{name}: the pair knows no side");
                assert!(right.pair_nm >= 0.0 && right.pair_nm <= 100.0, "{name}");
            }
        }
    }
}

#[test]
fn the_scheduled_pair_changes_slowly_and_fades_with_lean() {
    let Law::Scheduled(law) = shipped("scheduled").law else {
        panic!("the file is named after its law")
    };
    let full_nm = law.points.pair_nm(5.0);
    assert!(full_nm > 0.0);
    let mut demand = Demand::default();
    let mut ticks = 0;
    while demand.pair_nm < full_nm {
        let next = law.demand(&demand, &riding(5.0, 0.0), 1e-3);
        assert!(next.pair_nm - demand.pair_nm <= law.change_nm_s * 1e-3 * 1.01);
        demand = next;
        ticks += 1;
    }
    let expected_ticks = full_nm / law.change_nm_s * 1e3;
    assert!(
        (ticks as f32 - expected_ticks).abs() < 0.01 * expected_ticks + 2.0,
        "{ticks}"
    );
    let middle_rad = 0.5 * (law.fade_start_rad + law.fade_end_rad);
    let half = law.demand(&demand, &riding(5.0, middle_rad), 10.0);
    assert!((half.pair_nm - 0.5 * full_nm).abs() < 1e-3 * full_nm);
    assert_eq!(
        law.demand(&demand, &riding(5.0, law.fade_end_rad), 10.0)
            .pair_nm,
        0.0
    );
}

#[test]
fn trim_brakes_when_too_fast() {
    let trim = Some(SpeedTrim {
        target_m_s: 5.0,
        gain_nm_s_m: 10.0,
        largest_nm: 8.0,
    });
    assert_eq!(trim_nm(&trim, &riding(4.5, 0.0)), 5.0);
    assert_eq!(trim_nm(&trim, &riding(9.0, 0.0)), -8.0);
    assert_eq!(trim_nm(&None, &riding(9.0, 0.0)), 0.0);
}

#[test]
fn a_quiet_ride_gets_less_and_the_level_does_not_flutter() {
    let Law::Scheduled(mut law) = shipped("scheduled").law else {
        panic!("the file is named after its law")
    };
    law.activity = Some(Activity {
        quiet_ratio: 0.5,
        busy_rad_s: 0.3,
        calm_rad_s: 0.1,
        memory_s: 1.0,
    });
    let full_nm = law.points.pair_nm(5.0);
    let with_rate = |rate_rad_s: f32| Estimate {
        roll_rate_rad_s: rate_rad_s,
        ..riding(5.0, 0.0)
    };
    let mut demand = Demand::default();
    let ride = |demand: &mut Demand, rate_rad_s: f32| {
        for _ in 0..20_000 {
            *demand = law.demand(demand, &with_rate(rate_rad_s), 1e-3);
        }
        demand.pair_nm / full_nm
    };
    assert!((ride(&mut demand, 0.0) - 0.5).abs() < 1e-3);
    assert!(
        (ride(&mut demand, 0.2) - 0.5).abs() < 1e-3,
        "between the edges it stays quiet"
    );
    assert!((ride(&mut demand, 0.4) - 1.0).abs() < 1e-3);
    assert!(
        (ride(&mut demand, 0.2) - 1.0).abs() < 1e-3,
        "between the edges it stays busy"
    );
    assert!((ride(&mut demand, 0.05) - 0.5).abs() < 1e-3);
    let _ = ride(&mut demand, f32::NAN);
    assert!(demand.pair_nm.is_finite() && demand.activity_rad2_s2.is_finite());
    assert_eq!(law.settled_nm(5.0), [0.5 * full_nm, full_nm]);
}

#[test]
fn comparators_leave_the_hub_motors_alone() {
    for name in ["steering_spring", "steering_motor"] {
        let law = shipped(name).law;
        assert_ne!(law.device(), Device::None, "{name}");
        let x = Estimate {
            roll_rate_rad_s: 0.5,
            steer_rad: 0.1,
            ..riding(3.0, 0.2)
        };
        assert_eq!(law.demand(&Demand::default(), &x, 1e-3), Demand::default());
    }
}
