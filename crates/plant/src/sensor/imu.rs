//! Inertial measurement unit on the rear frame.
//!
//! What: three gyros and three accelerometers in one package. Equation: both vectors turned by
//! one small rotation (mounting and package, drawn once), then the channel errors of
//! `channel.rs`. Source: as there. Assumes and ignores: no vibration of its own, no sensitivity
//! of the gyro to acceleration, no temperature; the frame's flexibility is nobody's. Valid for:
//! misalignments of a few degrees. Checked by: the conformance suite.

use serde::{Deserialize, Serialize};
use twinhub_types::{ImuSample, Instant, Measurement};

use super::{
    Channel, ForceError, RateError, Sampler, Sensor, SensorKind, SensorModel, SensorTruth, Timing,
};
use crate::admissible::{OutOfRange, within};
use crate::explain::Explain;
use crate::noise::stream;

/// Parameters of an inertial measurement unit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ImuParameters {
    /// Standard deviation of the misalignment about each axis, rad.
    pub misalignment_sd_rad: f64,
    /// Rate, delay, losses.
    pub timing: Timing,
    /// Errors of each gyro.
    pub gyro: RateError,
    /// Errors of each accelerometer.
    pub accel: ForceError,
}

/// An inertial measurement unit in use.
#[derive(Clone, Debug)]
pub struct Imu {
    rotation: [[f64; 3]; 3],
    gyro: [Channel; 3],
    accel: [Channel; 3],
    sampler: Sampler<ImuSample>,
}

impl SensorKind for ImuParameters {
    fn explain(&self) -> Explain {
        Explain {
            name: "imu",
            what: "gyros and accelerometers on the rear frame",
            equation: "y = quantise(clamp((1 + s) C x + b + N √(f/2) n)), db = K √dt n'",
            source: "error model of IEEE Std 952 without bias instability; figures: see the suite",
            assumes: "no vibration of its own, no temperature, no acceleration sensitivity of the gyro",
        }
    }

    fn validate(&self) -> Result<(), OutOfRange> {
        within("misalignment_sd_rad", self.misalignment_sd_rad, 0.0, 0.5)?;
        self.timing.validate()?;
        self.gyro.validate()?;
        self.accel.validate()
    }

    fn build(&self, seed: u64) -> Sensor {
        let mut mounting = stream(seed, "sensor.imu.misalignment");
        let angles = [(); 3].map(|()| self.misalignment_sd_rad * mounting.normal());
        let channel = |error, name: &str| Channel::new(&error, self.timing.rate_hz, seed, name);
        let (gyro, accel) = (self.gyro.figures(), self.accel.figures());
        Sensor::Imu(Imu {
            rotation: rotation(angles),
            gyro: ["imu.gyro_x", "imu.gyro_y", "imu.gyro_z"].map(|n| channel(gyro, n)),
            accel: ["imu.accel_x", "imu.accel_y", "imu.accel_z"].map(|n| channel(accel, n)),
            sampler: Sampler::new(&self.timing, seed, "imu", ImuSample::default()),
        })
    }
}

impl Imu {
    /// The biases now, gyro (rad/s) and accelerometer (m/s²): what an estimator should find.
    pub fn biases(&self) -> ([f64; 3], [f64; 3]) {
        let of = |c: &[Channel; 3]| [c[0].bias(), c[1].bias(), c[2].bias()];
        (of(&self.gyro), of(&self.accel))
    }
}

impl SensorModel for Imu {
    fn sample(&mut self, now: Instant, truth: &SensorTruth, into: &mut Measurement) {
        let Self {
            rotation,
            gyro,
            accel,
            sampler,
        } = self;
        into.imu = sampler.tick(now, || {
            let rates = apply(rotation, truth.body_rates_rad_s);
            let forces = apply(rotation, truth.specific_force_m_s2);
            ImuSample {
                stamp_ns: now.as_nanos(),
                gyro_rad_s: core::array::from_fn(|i| gyro[i].measure(rates[i]) as f32),
                accel_m_s2: core::array::from_fn(|i| accel[i].measure(forces[i]) as f32),
            }
        });
    }
}

/// Specific force at `arm_m` from a point where it is `force_m_s2`, all in body axes:
/// f + α × r + ω × (ω × r).
pub fn specific_force_at(
    force_m_s2: [f64; 3],
    rates_rad_s: [f64; 3],
    angular_m_s2_per_m: [f64; 3],
    arm_m: [f64; 3],
) -> [f64; 3] {
    let turn = cross(angular_m_s2_per_m, arm_m);
    let centripetal = cross(rates_rad_s, cross(rates_rad_s, arm_m));
    core::array::from_fn(|i| force_m_s2[i] + turn[i] + centripetal[i])
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

fn apply(m: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    core::array::from_fn(|i| m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2])
}

/// Rotation by the vector `w` (Rodrigues).
fn rotation(w: [f64; 3]) -> [[f64; 3]; 3] {
    let angle = libm::sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
    if angle == 0.0 {
        return [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    }
    let k = w.map(|c| c / angle);
    let (s, c) = libm::sincos(angle);
    let turn = |v: [f64; 3]| {
        let kv = cross(k, v);
        let along = (k[0] * v[0] + k[1] * v[1] + k[2] * v[2]) * (1.0 - c);
        core::array::from_fn::<f64, 3, _>(|i| v[i] * c + kv[i] * s + k[i] * along)
    };
    let columns = [
        turn([1.0, 0.0, 0.0]),
        turn([0.0, 1.0, 0.0]),
        turn([0.0, 0.0, 1.0]),
    ];
    core::array::from_fn(|i| core::array::from_fn(|j| columns[j][i]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_turn_about_z_takes_x_to_y_and_lengths_stay() {
        let m = rotation([0.0, 0.0, core::f64::consts::FRAC_PI_2]);
        let v = apply(&m, [1.0, 0.0, 0.0]);
        assert!((v[1] - 1.0).abs() < 1e-15 && v[0].abs() < 1e-15);
        let v = apply(&rotation([0.1, -0.2, 0.05]), [3.0, 4.0, 12.0]);
        assert!((v.iter().map(|c| c * c).sum::<f64>() - 169.0).abs() < 1e-12);
    }

    #[test]
    fn a_lever_arm_adds_centripetal_force_toward_the_axis() {
        // spinning about z at 2 rad/s, sensor 0.5 m ahead: pulled back by ω² r
        let f = specific_force_at([0.0; 3], [0.0, 0.0, 2.0], [0.0; 3], [0.5, 0.0, 0.0]);
        assert_eq!(f, [-2.0, 0.0, 0.0]);
        let f = specific_force_at([0.0; 3], [0.0; 3], [0.0, 0.0, 3.0], [0.5, 0.0, 0.0]);
        assert_eq!(f, [0.0, 1.5, 0.0]);
    }
}
