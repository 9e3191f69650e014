//! Frames that no bicycle sends: what the sensors say in the worst of cases, to find the most
//! expensive tick and the first different bit.
//!
//! Most of the time the bicycle rides on as it should, so that every mode is reached; for a while
//! one sensor is silent; then words of the measurement and of the rider's wishes are overwritten:
//! NaN, infinities, denormals, extremes, zeros of both signs, random bits. Stamps break with them:
//! too old, from the future, never. The clock jumps and stands still, the switch is thrown, levers
//! are pulled.

use crate::replay::header;
use twinhub_types::{NEVER_NS, PlantFrame, Wire};

/// Bit patterns that arithmetic likes least.
const WORDS: [u32; 20] = [
    0x7fc0_0000, // NaN
    0xffc0_0001, // NaN of the other sign, with a payload
    0x7f80_0001, // signalling NaN
    0x7f80_0000, // infinity
    0xff80_0000, // minus infinity
    0x0000_0001, // the smallest denormal
    0x807f_ffff, // the largest denormal, negative
    0x0080_0000, // the smallest normal number
    0x7f7f_ffff, // the largest number
    0xff7f_ffff, // its negative
    0x0000_0000, // zero
    0x8000_0000, // minus zero
    0x3f80_0000, // 1
    0xbf80_0000, // -1
    0x4049_0fdb, // pi
    0xc0c9_0fdb, // -2 pi
    0x3fc9_0fdb, // pi/2: the worst for a tangent
    0x4b00_0000, // 2^23
    0xffff_ffff, // half of a stamp that was never taken
    0x7149_f2ca, // 1e30
];
/// Ticks of a stretch of the one or the other kind; ten stretches make a round. Four sound ones give
/// the supervisor the second in which its flags clear.
const STRETCH: u64 = 400;
const TICK_NS: u64 = twinhub_types::conventions::TICK.as_nanos();

/// `count` frames; the same for the same seed.
pub fn frames(count: u64, seed: u64) -> Vec<PlantFrame> {
    let mut random = Random(seed);
    let mut time_ns = 0;
    let frame = |tick| {
        let stretch = tick / STRETCH % 10;
        let hostile = stretch >= 8;
        time_ns = match random.below(200) {
            0 if hostile => time_ns + TICK_NS * random.below(100),
            1 if hostile => time_ns.saturating_sub(TICK_NS * random.below(30)),
            2 if hostile => time_ns,
            _ => time_ns + TICK_NS,
        };
        let mut frame = riding(tick, time_ns, &mut random);
        if stretch == 4 {
            silence(&mut frame, tick / STRETCH / 10);
        }
        if hostile {
            let words = 1 << random.below(6);
            frame.measurement = spoil(frame.measurement, words, &mut random);
            if random.below(3) == 0 {
                frame.intent = spoil(frame.intent, 1 + random.below(3), &mut random);
            }
        }
        frame
    };
    (0..count).map(frame).collect()
}

/// A bicycle that weaves at the speeds between standing still and 12 m/s.
fn riding(tick: u64, time_ns: u64, random: &mut Random) -> PlantFrame {
    let mut noise = || random.below(2001) as f32 * 1e-3 - 1.0;
    // A triangle, so that no function of the platform is in it.
    let sway = ((tick % 1000) as f32 - 500.0).abs() * 4e-3 - 1.0;
    let speed_m_s = ((tick % 24_000) as f32 * 1e-3 - 12.0).abs();
    let mut frame = PlantFrame {
        header: header(tick, time_ns),
        ..PlantFrame::default()
    };
    let m = &mut frame.measurement;
    m.imu.stamp_ns = time_ns;
    m.imu.gyro_rad_s = [0.3 * sway + 0.01 * noise(), 0.01 * noise(), 0.2 * sway];
    m.imu.accel_m_s2 = [0.1 * noise(), sway + 0.2 * noise(), -9.81];
    m.roll.stamp_ns = time_ns;
    m.roll.roll_rad = 0.1 * sway + 0.005 * noise();
    m.roll.roll_rate_rad_s = 0.3 * sway;
    m.steer.stamp_ns = time_ns;
    m.steer.steer_rad = 0.1 * sway;
    m.steer.steer_rate_rad_s = if tick % 7 == 0 { f32::NAN } else { 0.2 * sway };
    m.wheels.stamp_ns = time_ns;
    m.wheels.speed_m_s = speed_m_s;
    m.wheels.front_rad_s = speed_m_s / 0.343 + 0.05 * noise();
    m.wheels.rear_rad_s = speed_m_s / 0.343 + 0.05 * noise();
    m.motors.stamp_ns = time_ns;
    m.motors.bus_v = 36.0;
    m.motors.front_brake_nm = 10.0 + noise();
    m.motors.rear_traction_nm = 10.0 + noise();
    frame.intent.stamp_ns = time_ns;
    frame.intent.assist_on = u32::from(tick % 5000 > 300);
    frame.intent.pedalling = u32::from(tick % 3000 > 500);
    frame.intent.front_brake_ratio = if tick % 9000 > 8800 { 0.5 } else { 0.0 };
    frame
}

/// Takes one sensor away, or the rider's wishes.
fn silence(frame: &mut PlantFrame, which: u64) {
    let m = &mut frame.measurement;
    let stamp_ns = match which % 4 {
        0 => &mut m.steer.stamp_ns,
        1 => &mut m.imu.stamp_ns,
        2 => &mut m.wheels.stamp_ns,
        _ => &mut frame.intent.stamp_ns,
    };
    *stamp_ns = NEVER_NS;
}

/// `message` with up to `words` of its 32-bit words overwritten.
fn spoil<M: Wire>(message: M, words: u64, random: &mut Random) -> M {
    let mut bytes = vec![0; M::SIZE];
    let _full = message.put(&mut bytes);
    for _ in 0..words {
        let word = match random.below(3) {
            0 => random.next() as u32,
            _ => WORDS[random.below(WORDS.len() as u64) as usize],
        };
        let at = 4 * random.below(M::SIZE as u64 / 4) as usize;
        bytes[at..at + 4].copy_from_slice(&word.to_le_bytes());
    }
    M::get(&bytes).map_or(message, |(spoiled, _)| spoiled)
}

/// SplitMix64 (Steele, Lea, Flood 2014, "Fast splittable pseudorandom number generators").
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, end: u64) -> u64 {
        self.next() % end
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;
    use twinhub_control::Controller;
    use twinhub_types::Health;

    #[test]
    fn every_mode_and_almost_every_fault_is_reached_and_every_answer_is_finite() {
        let laws = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates/control/laws");
        let config = crate::read_law(&laws.join("scheduled.toml")).expect("a law");
        let mut controller = Controller::new(&config);
        let mut modes = BTreeSet::new();
        let mut health = Health::OK;
        let mut torque_nm = 0.0f32;
        for frame in frames(20_000, 7) {
            let output = controller.answer(&frame).output;
            modes.insert(output.mode);
            health = health.with(Health::from_bits(output.health));
            let (front, rear) = (
                output.command.front_brake_nm,
                output.command.rear_traction_nm,
            );
            assert!(front.is_finite() && rear.is_finite() && output.estimate.roll_rad.is_finite());
            torque_nm = torque_nm.max(front);
        }
        assert_eq!(modes.into_iter().collect::<Vec<_>>(), [0, 1, 2, 3, 4]);
        for flag in [
            Health::ROLL_MISSING,
            Health::STEER_MISSING,
            Health::SPEED_MISSING,
            Health::INTENT_MISSING,
            Health::TIME_JUMP,
        ] {
            assert!(health.any(flag), "{flag:?} in {health:?}");
        }
        assert!(torque_nm > 1.0, "the pair acts in between: {torque_nm} Nm");
    }

    #[test]
    fn a_seed_gives_the_same_frames() {
        let bytes = |seed| {
            let mut bytes = vec![0; PlantFrame::SIZE];
            let all = frames(1000, seed).into_iter().flat_map(move |frame| {
                assert!(frame.put(&mut bytes).is_some());
                bytes.clone()
            });
            all.collect::<Vec<u8>>()
        };
        assert_eq!(bytes(3), bytes(3));
        assert_ne!(bytes(3), bytes(4));
    }
}
