//! The whole controller on arbitrary bit patterns: whatever comes in, what goes out is in bounds.

use crate::frames::{config, healthy};
use crate::referee::Referee;
use proptest::prelude::*;
use twinhub_control::guard::GuardLimits;
use twinhub_control::{Config, Controller, Profile};
use twinhub_types::{Instant, LimitedBy, Measurement, PlantFrame, RiderIntent, Wire};

/// How one frame of a sequence comes about.
#[derive(Clone, Debug)]
enum Frame {
    /// As a healthy bicycle sends it.
    Healthy,
    /// Healthy, with one 4-byte word overwritten.
    Word { at: usize, bits: u32 },
    /// All bits arbitrary.
    Wild(Vec<u8>),
    /// Never sent.
    Missing,
}

/// Milliseconds of time steps: mostly regular, sometimes anything.
fn span() -> impl Strategy<Value = i64> {
    prop_oneof![40 => Just(1_000_000), 1 => Just(0), 1 => any::<i64>(), 2 => 0i64..100_000_000]
}

fn word() -> impl Strategy<Value = u32> {
    prop_oneof![
        any::<u32>(),
        Just(f32::NAN.to_bits()),
        Just(f32::INFINITY.to_bits()),
        Just(f32::NEG_INFINITY.to_bits()),
        Just(f32::MAX.to_bits()),
        Just(1u32),
        Just(0u32),
        (-100f32..100.0).prop_map(f32::to_bits),
    ]
}

fn frame() -> impl Strategy<Value = Frame> {
    let words = PlantFrame::SIZE / 4;
    prop_oneof![
        60 => Just(Frame::Healthy),
        20 => (0..words, word()).prop_map(|(at, bits)| Frame::Word { at, bits }),
        2 => proptest::collection::vec(any::<u8>(), PlantFrame::SIZE).prop_map(Frame::Wild),
        2 => Just(Frame::Missing),
    ]
}

fn build(
    frame: &Frame,
    now_ns: u64,
    speed_m_s: f32,
    config: &Config,
) -> (Measurement, RiderIntent) {
    let (mut measurement, mut intent) = healthy(0, speed_m_s, config);
    for stamp_ns in [
        &mut measurement.imu.stamp_ns,
        &mut measurement.steer.stamp_ns,
        &mut measurement.wheels.stamp_ns,
        &mut measurement.motors.stamp_ns,
        &mut intent.stamp_ns,
    ] {
        *stamp_ns = now_ns;
    }
    let mut bytes = [0u8; PlantFrame::SIZE];
    let whole = PlantFrame {
        measurement,
        intent,
        ..PlantFrame::default()
    };
    assert!(whole.put(&mut bytes).is_some());
    match frame {
        Frame::Healthy => {}
        Frame::Word { at, bits } => bytes[4 * at..4 * at + 4].copy_from_slice(&bits.to_le_bytes()),
        Frame::Wild(wild) => bytes.copy_from_slice(wild),
        Frame::Missing => return (Measurement::default(), RiderIntent::default()),
    }
    let (frame, _) = PlantFrame::get(&bytes).expect("long enough");
    (frame.measurement, frame.intent)
}

proptest! {
    // The same cases in every run; `PROPTEST_CASES` asks for more of them.
    #![proptest_config(ProptestConfig {
        failure_persistence: None,
        rng_seed: proptest::test_runner::RngSeed::Fixed(4),
        ..ProptestConfig::default()
    })]

    #[test]
    fn whatever_comes_in_what_goes_out_is_in_bounds(
        law in 0..twinhub_control::Law::NAMES.len(),
        road in any::<bool>(),
        speed_m_s in 0f32..12.0,
        warm in 0u64..4_000,
        ticks in proptest::collection::vec((span(), frame()), 200),
    ) {
        let mut config = config(twinhub_control::Law::NAMES[law]);
        config.profile = if road { Profile::En15194 } else { Profile::Laboratory };
        let limits = GuardLimits::new(&config);
        let (mut controller, mut referee) = (Controller::new(&config), Referee::new(limits));
        let mut now_ns = 0u64;
        let warm = (0..warm).map(|_| (1_000_000, Frame::Healthy));
        for (span_ns, frame) in warm.chain(ticks) {
            now_ns = now_ns.wrapping_add_signed(span_ns);
            let now = Instant::from_nanos(now_ns);
            let (meas, rider) = build(&frame, now_ns, speed_m_s, &config);
            let output = controller.step(now, &meas, &rider);
            let limited_by = LimitedBy::from_bits(output.limited_by);
            if let Err(broken) = referee.check(now, &meas, &rider, &output.command, limited_by) {
                prop_assert!(false, "{}", broken);
            }
            let x = output.estimate;
            for value in [
                x.roll_rad, x.roll_rate_rad_s, x.steer_rad, x.steer_rate_rad_s, x.speed_m_s,
                x.yaw_rate_rad_s, x.roll_sd_rad, x.speed_sd_m_s, output.demand_nm,
            ] {
                prop_assert!(value.is_finite(), "{:?}", output);
            }
        }
    }

    #[test]
    fn any_configuration_at_all_stays_in_bounds(
        words in proptest::collection::vec(word(), 14),
        spoilt in 0usize..15,
    ) {
        let mut config = config("constant");
        let c = &mut config;
        let slots = [
            &mut c.bicycle.front_wheel_radius_m, &mut c.bicycle.rear_wheel_radius_m,
            &mut c.bicycle.wheelbase_m, &mut c.bicycle.steer_tilt_rad, &mut c.bicycle.front_load_n,
            &mut c.bicycle.rear_load_n, &mut c.bicycle.com_height_m, &mut c.limits.torque_max_nm,
            &mut c.limits.speed_min_m_s, &mut c.limits.speed_max_m_s, &mut c.limits.ramp_up_nm_s,
            &mut c.limits.ramp_down_s,
        ];
        for (index, (slot, word)) in slots.into_iter().zip(&words).enumerate() {
            if spoilt == index || spoilt == 14 {
                *slot = f32::from_bits(*word);
            }
        }
        let mut controller = Controller::new(&config);
        let sound = crate::frames::config("constant");
        for ms in 0..500 {
            let (meas, rider) = healthy(ms, 5.0, &sound);
            let command = controller.step(Instant::from_nanos(ms * 1_000_000), &meas, &rider).command;
            prop_assert!((0.0..=100.0).contains(&command.front_brake_nm));
            prop_assert!(command.rear_traction_nm.abs() <= 100.0);
            if config.check().is_err() {
                prop_assert_eq!(command.front_brake_nm, 0.0);
                prop_assert_eq!(command.rear_traction_nm, 0.0);
            }
        }
    }
}
