//! What happens to the torque when something goes wrong, and how it comes back.

use crate::frames::{Ride, config, healthy};
use twinhub_control::{ForkLife, Profile, guard, supervisor};
use twinhub_types::{Health, Instant, LimitedBy, Mode, NEVER_NS};

fn limited(ride: &Ride, limit: LimitedBy) -> bool {
    LimitedBy::from_bits(ride.last.limited_by).any(limit)
}

#[test]
fn the_pair_comes_slowly_and_balances() {
    let mut ride = Ride::new(config("scheduled"));
    let mut last_nm = 0.0;
    while ride.front_nm() < 39.99 {
        ride.go(1, |_, _| {});
        let step_nm = ride.front_nm() - last_nm;
        assert!(
            (0.0..=15.01e-3).contains(&step_nm),
            "15 Nm/s: {step_nm} Nm at {} ms",
            ride.ms
        );
        last_nm = ride.front_nm();
        assert!(ride.ms < 4_000);
    }
    assert!(
        ride.ms > 2_600,
        "40 Nm at 15 Nm/s take 2.7 s, not {} ms",
        ride.ms
    );
    assert!(
        (ride.last.command.rear_traction_nm - ride.front_nm()).abs() < 1e-4,
        "same radii"
    );
}

#[test]
fn the_off_law_never_asks_for_torque() {
    let mut ride = Ride::new(config("off"));
    ride.go(3_000, |_, _| {});
    assert_eq!(
        (ride.front_nm(), ride.last.command.rear_traction_nm),
        (0.0, 0.0)
    );
    assert_eq!(ride.mode(), Mode::Active);
}

#[test]
fn a_brake_lever_ends_the_pair_within_the_tick_and_it_comes_back_slowly() {
    for front in [true, false] {
        let mut ride = Ride::settled(config("scheduled"));
        ride.go(1, |_, intent| {
            let lever = if front {
                &mut intent.front_brake_ratio
            } else {
                &mut intent.rear_brake_ratio
            };
            *lever = 0.05;
        });
        assert_eq!(
            (ride.front_nm(), ride.last.command.rear_traction_nm),
            (0.0, 0.0)
        );
        assert!(limited(&ride, LimitedBy::LEVER));
        ride.go(100, |_, _| {});
        let nm = ride.front_nm();
        assert!(nm > 1.5 && nm <= 2.01, "20 Nm/s for 0.1 s, not {nm}");
    }
}

#[test]
fn a_lost_link_is_zero_within_200_ms_and_clears_after_a_second() {
    let mut ride = Ride::settled(config("scheduled"));
    let (meas, intent) = healthy(ride.ms - 1, 5.0, &ride.config);
    let frozen = move |m: &mut _, i: &mut _| {
        *m = meas;
        *i = intent;
    };
    ride.go(19, frozen);
    assert!(
        ride.health().is_ok() && (ride.front_nm() - 40.0).abs() < 1e-3,
        "20 ms are bridged"
    );
    ride.go(3, frozen);
    assert!(ride.health().any(Health::LINK_LOST) && ride.mode() == Mode::Fault);
    assert!(ride.front_nm() > 35.0, "ramped, not dropped");
    ride.go(178, frozen);
    assert_eq!(
        (ride.front_nm(), ride.last.command.rear_traction_nm),
        (0.0, 0.0)
    );
    ride.go(999, |_, _| {});
    assert!(
        ride.health().any(Health::LINK_LOST) && ride.front_nm() == 0.0,
        "not yet"
    );
    ride.go(3, |_, _| {});
    assert!(ride.health().is_ok() && ride.mode() == Mode::Active);
    ride.go(3_000, |_, _| {});
    assert!((ride.front_nm() - 40.0).abs() < 1e-3);
}

#[test]
fn a_speed_that_is_no_number_degrades_then_ramps_out_then_recovers() {
    let mut ride = Ride::settled(config("scheduled"));
    ride.go(51, |meas, _| meas.wheels.speed_m_s = f32::NAN);
    assert!(
        ride.health().any(Health::SPEED_MISSING),
        "{:?}",
        ride.health()
    );
    assert_eq!(ride.mode(), Mode::Degraded);
    assert!(ride.front_nm() > 30.0);
    ride.go(500, |meas, _| meas.wheels.speed_m_s = f32::NAN);
    assert_eq!(
        (ride.front_nm(), ride.last.command.rear_traction_nm),
        (0.0, 0.0)
    );
    assert_eq!(ride.last.estimate.speed_m_s, 5.0, "held");
    ride.go(1_002, |_, _| {});
    assert_eq!(ride.mode(), Mode::Active);
}

#[test]
fn every_lost_sensor_has_its_flag_its_ramp_and_its_way_back() {
    type Loss = fn(&mut twinhub_types::Measurement, &mut twinhub_types::RiderIntent);
    let cases: [(Health, f32, Loss); 4] = [
        (Health::ROLL_MISSING, 0.0, |meas, _| {
            meas.imu.gyro_rad_s[1] = f32::INFINITY
        }),
        (Health::STEER_MISSING, 20.0, |meas, _| {
            meas.steer.stamp_ns = NEVER_NS
        }),
        (Health::INTENT_MISSING, 0.0, |_, intent| {
            intent.rear_brake_ratio = f32::NAN
        }),
        (Health::SPEED_MISSING, 0.0, |meas, _| {
            meas.wheels.front_rad_s = 1e9
        }),
    ];
    for (flag, left_nm, lose) in cases {
        let mut ride = Ride::settled(config("scheduled"));
        ride.go(100, lose);
        assert_eq!((ride.health(), ride.mode()), (flag, Mode::Degraded));
        assert!(ride.front_nm() > 10.0, "{flag:?}: ramped, not dropped");
        ride.go(2_100, lose);
        assert!(
            (ride.front_nm() - left_nm).abs() < 0.01,
            "{flag:?}: {}",
            ride.front_nm()
        );
        ride.go(1_002, |_, _| {});
        assert_eq!(
            (ride.health(), ride.mode()),
            (Health::OK, Mode::Active),
            "{flag:?}"
        );
    }
}

#[test]
fn one_bad_frame_raises_nothing() {
    let mut ride = Ride::settled(config("scheduled"));
    ride.go(1, |meas, _| {
        meas.imu.accel_m_s2[1] = f32::NAN;
        meas.steer.steer_rad = 99.0;
    });
    assert!(ride.health().is_ok() && ride.front_nm() > 39.9);
}

#[test]
fn time_that_stands_still_or_jumps_back_is_a_fault_that_clears() {
    let mut ride = Ride::settled(config("scheduled"));
    let (meas, intent) = healthy(ride.ms, 5.0, &ride.config);
    let now = Instant::from_nanos((ride.ms - 1) * 1_000_000);
    for _ in 0..200 {
        ride.last = ride.controller.step(now, &meas, &intent);
    }
    assert!(ride.health().any(Health::TIME_JUMP) && ride.mode() == Mode::Fault);
    assert_eq!(
        ride.front_nm(),
        0.0,
        "a clock that stands still does not stop the ramp"
    );
    ride.ms = 0;
    ride.go(1, |_, _| {});
    assert!(ride.health().any(Health::TIME_JUMP));
    ride.go(1_001, |_, _| {});
    assert_eq!(
        (ride.health(), ride.mode()),
        (Health::OK, Mode::Active),
        "an hour's wait is no rule"
    );
}

#[test]
fn fallen_is_a_fault_until_the_bicycle_stands_again() {
    let mut ride = Ride::settled(config("scheduled"));
    let lying = |meas: &mut twinhub_types::Measurement, _: &mut _| {
        meas.roll.stamp_ns = meas.imu.stamp_ns;
        meas.roll.roll_rad = 1.3;
    };
    ride.go(400, lying);
    assert!(ride.health().any(Health::FALLEN) && ride.mode() == Mode::Fault);
    assert_eq!(
        (ride.front_nm(), ride.last.command.rear_traction_nm),
        (0.0, 0.0)
    );
    ride.go(3_000, |meas, _| {
        meas.roll.stamp_ns = meas.imu.stamp_ns;
        meas.roll.roll_rad = 0.0;
    });
    assert!(ride.health().is_ok());
}

#[test]
fn switching_off_and_leaving_the_speed_range_ramp_out_over_two_seconds() {
    let mut ride = Ride::settled(config("scheduled"));
    ride.go(1_000, |_, intent| intent.assist_on = 0);
    assert_eq!(ride.mode(), Mode::Off);
    assert!(
        (ride.front_nm() - 20.0).abs() < 0.2,
        "half-way: {}",
        ride.front_nm()
    );
    ride.go(1_001, |_, intent| intent.assist_on = 0);
    assert_eq!(ride.front_nm(), 0.0);

    let mut ride = Ride::settled(config("constant"));
    ride.speed_m_s = ride.config.limits.speed_max_m_s + 0.2;
    ride.go(10, |_, _| {});
    assert_eq!(ride.mode(), Mode::Active, "inside the hysteresis");
    ride.speed_m_s += 0.2;
    ride.go(10, |_, _| {});
    assert_eq!(ride.mode(), Mode::Ready);
    ride.speed_m_s -= 0.2;
    ride.go(10, |_, _| {});
    assert_eq!(ride.mode(), Mode::Ready, "hysteresis on the way back");
}

#[test]
fn a_slipping_front_wheel_is_let_go_within_the_tick() {
    let mut ride = Ride::settled(config("scheduled"));
    ride.go(1, |meas, _| meas.wheels.front_rad_s *= 0.75);
    assert_eq!(ride.front_nm(), 0.0);
    assert!(limited(&ride, LimitedBy::SLIP));
    ride.go((guard::SLIP_HOLD_S * 1e3) as u64 - 2, |_, _| {});
    assert_eq!(ride.front_nm(), 0.0, "held");
    ride.go(100, |_, _| {});
    assert!(
        ride.front_nm() > 0.0 && ride.front_nm() < 3.0,
        "and comes back slowly"
    );
}

#[test]
fn a_wheel_that_stands_is_not_braked() {
    let mut ride = Ride::settled(config("constant"));
    ride.speed_m_s = 0.1;
    ride.go(1, |_, _| {});
    assert_eq!(ride.front_nm(), 0.0);
    assert!(ride.last.command.rear_traction_nm >= 0.0);
}

#[test]
fn unknown_friction_holds_the_pair_to_35_nm() {
    let mut config = config("scheduled");
    config.limits.friction_assumed_ratio = None;
    let mut ride = Ride::new(config);
    ride.go(5_000, |_, _| {});
    assert!((ride.front_nm() - 35.0).abs() < 1.0, "{}", ride.front_nm());
    assert!(limited(&ride, LimitedBy::FRICTION));
}

#[test]
fn the_road_profile_allows_the_peak_for_seconds_and_250_w_for_hours() {
    let mut config = config("constant");
    config.profile = Profile::En15194;
    config.limits.torque_max_nm = 80.0;
    config.limits.friction_assumed_ratio = Some(1.0);
    let twinhub_control::Law::Constant(law) = &mut config.law else {
        panic!("constant")
    };
    law.pair_nm = 80.0;
    let mut ride = Ride::new(config);
    let (mut most_nm, mut above_70_s, mut last_nm) = (0f32, 0.0, 0.0);
    for _ in 0..30_000 {
        ride.go(1, |_, _| {});
        most_nm = most_nm.max(ride.front_nm());
        above_70_s += if ride.front_nm() > 70.0 { 1e-3 } else { 0.0 };
        assert!(last_nm - ride.front_nm() < 0.02, "eased down, not dropped");
        last_nm = ride.front_nm();
    }
    assert!(
        most_nm > 75.0 && above_70_s > 1.0 && above_70_s < 15.0,
        "{most_nm} Nm, {above_70_s} s"
    );
    ride.go(300_000, |_, _| {});
    // 250 W / (5 m/s / 0.35 m) for good.
    assert!((ride.front_nm() - 17.5).abs() < 0.2, "{}", ride.front_nm());
    assert!(limited(&ride, LimitedBy::POWER));
}

#[test]
fn a_refused_configuration_is_a_fault_without_torque() {
    for spoil in [
        (|c| c.bicycle.front_wheel_radius_m = f32::NAN) as fn(&mut twinhub_control::Config),
        |c| c.limits.torque_max_nm = 101.0,
        |c| c.schema_version = 2,
        |c| c.limits.ramp_up_nm_s = f32::INFINITY,
    ] {
        let mut config = config("constant");
        spoil(&mut config);
        let mut ride = Ride::new(config);
        ride.config = crate::frames::config("constant");
        ride.go(3_000, |_, _| {});
        assert_eq!(
            (ride.health(), ride.mode()),
            (Health::CONFIG_REFUSED, Mode::Fault)
        );
        assert_eq!(
            (ride.front_nm(), ride.last.command.rear_traction_nm),
            (0.0, 0.0)
        );
    }
    assert!(supervisor::FAULTS.any(Health::CONFIG_REFUSED));
}

#[test]
fn a_fork_near_the_end_of_its_life_carries_less() {
    let mut fork = ForkLife::new(0);
    while fork.used_ratio() < 0.75 {
        [600.0, 0.0].iter().for_each(|force_n| fork.add(*force_n));
    }
    let mut ride = Ride::new(config("scheduled"));
    ride.controller = ride.controller.on_fork(fork);
    ride.go(6_000, |_, _| {});
    // Half of the 40 Nm: the upper half of the life takes them all.
    assert!(
        (ride.front_nm() - 20.0).abs() < 0.02,
        "{} Nm",
        ride.front_nm()
    );
    assert!(limited(&ride, LimitedBy::FORK) && ride.mode() == Mode::Active);
    assert!(ride.controller.fork().used() >= fork.used());
}
