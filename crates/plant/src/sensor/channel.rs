//! The errors of one measured number.
//!
//! What: scale, bias, noise, range and resolution of one channel. Equation:
//!   y = q round(clamp((1 + s) x + b + σ n, ±range)/q),  σ = N √(f/2),  b' = b + K √(1/f) n',
//! with N the noise density, f the sample rate (noise white up to f/2), K the bias random walk,
//! s and the first b drawn once. Source: the error model of IEEE Std 952 (angle random walk, rate
//! random walk), without bias instability (flicker). Assumes and ignores: no temperature, no
//! dependence on acceleration, no hysteresis. Valid for: any rate. Checked by: tests below
//! (mean, standard deviation and walk within their confidence; quantisation; range).

use crate::noise::{Gaussian, stream};

/// Error figures of one channel, in the unit of the channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChannelError {
    /// White noise, unit/√Hz.
    pub noise_per_sqrt_hz: f64,
    /// Standard deviation of the constant bias.
    pub bias_sd: f64,
    /// Random walk of the bias, unit/√s.
    pub bias_walk_per_sqrt_s: f64,
    /// Standard deviation of the scale error.
    pub scale_sd_ratio: f64,
    /// Resolution; 0 for none.
    pub quantum: f64,
    /// Largest magnitude that is measured.
    pub range: f64,
}

/// Declares the TOML form of a channel's errors, with the unit in every name.
macro_rules! channel_errors {
    ($($(#[$doc:meta])* $name:ident ($unit:literal, ideal range $range:literal):
        $noise:ident $bias:ident $walk:ident $quantum:ident $limit:ident;)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(deny_unknown_fields)]
        pub struct $name {
            #[doc = concat!("White noise, ", $unit, "/√Hz.")]
            pub $noise: f64,
            #[doc = concat!("Standard deviation of the constant bias, ", $unit, ".")]
            pub $bias: f64,
            #[doc = concat!("Random walk of the bias, ", $unit, "/√s.")]
            pub $walk: f64,
            /// Standard deviation of the scale error.
            pub scale_sd_ratio: f64,
            #[doc = concat!("Resolution, ", $unit, "; 0 for none.")]
            pub $quantum: f64,
            #[doc = concat!("Largest magnitude that is measured, ", $unit, ".")]
            pub $limit: f64,
        }

        impl $name {
            /// No error at all.
            pub const IDEAL: Self =
                Self { $noise: 0.0, $bias: 0.0, $walk: 0.0, scale_sd_ratio: 0.0, $quantum: 0.0, $limit: $range };

            /// Checks every figure.
            pub fn validate(&self) -> Result<(), $crate::admissible::OutOfRange> {
                use $crate::admissible::within;
                within(stringify!($noise), self.$noise, 0.0, $range)?;
                within(stringify!($bias), self.$bias, 0.0, $range)?;
                within(stringify!($walk), self.$walk, 0.0, $range)?;
                within("scale_sd_ratio", self.scale_sd_ratio, 0.0, 1.0)?;
                within(stringify!($quantum), self.$quantum, 0.0, $range)?;
                within(stringify!($limit), self.$limit, 1e-6, $range)
            }

            /// The figures without their unit.
            pub fn figures(&self) -> $crate::sensor::ChannelError {
                $crate::sensor::ChannelError {
                    noise_per_sqrt_hz: self.$noise,
                    bias_sd: self.$bias,
                    bias_walk_per_sqrt_s: self.$walk,
                    scale_sd_ratio: self.scale_sd_ratio,
                    quantum: self.$quantum,
                    range: self.$limit,
                }
            }
        }
    )*};
}

channel_errors! {
    /// Errors of a measured rate.
    RateError ("rad/s", ideal range 1e6): noise_rad_s_per_sqrt_hz bias_sd_rad_s bias_walk_rad_s_per_sqrt_s quantum_rad_s range_rad_s;
    /// Errors of a measured specific force.
    ForceError ("m/s²", ideal range 1e6): noise_m_s2_per_sqrt_hz bias_sd_m_s2 bias_walk_m_s2_per_sqrt_s quantum_m_s2 range_m_s2;
    /// Errors of a measured angle.
    AngleError ("rad", ideal range 1e6): noise_rad_per_sqrt_hz bias_sd_rad bias_walk_rad_per_sqrt_s quantum_rad range_rad;
    /// Errors of a reported torque.
    TorqueError ("Nm", ideal range 1e6): noise_nm_per_sqrt_hz bias_sd_nm bias_walk_nm_per_sqrt_s quantum_nm range_nm;
    /// Errors of a measured voltage.
    VoltageError ("V", ideal range 1e6): noise_v_per_sqrt_hz bias_sd_v bias_walk_v_per_sqrt_s quantum_v range_v;
    /// Errors of a measured current.
    CurrentError ("A", ideal range 1e6): noise_a_per_sqrt_hz bias_sd_a bias_walk_a_per_sqrt_s quantum_a range_a;
    /// Errors of a measured temperature.
    TemperatureError ("K", ideal range 1e6): noise_k_per_sqrt_hz bias_sd_k bias_walk_k_per_sqrt_s quantum_k range_k;
}

/// A channel in use.
#[derive(Clone, Debug)]
pub struct Channel {
    scale: f64,
    bias: f64,
    noise_sd: f64,
    walk_sd: f64,
    quantum: f64,
    range: f64,
    noise: Gaussian,
    walk: Gaussian,
}

impl Channel {
    /// The channel called `name` (its random streams carry that name), sampled at `rate_hz`.
    pub fn new(error: &ChannelError, rate_hz: f64, seed: u64, name: &str) -> Self {
        let mut constant = stream(seed, &format!("sensor.{name}.constant"));
        Self {
            scale: 1.0 + error.scale_sd_ratio * constant.normal(),
            bias: error.bias_sd * constant.normal(),
            noise_sd: error.noise_per_sqrt_hz * libm::sqrt(0.5 * rate_hz),
            walk_sd: error.bias_walk_per_sqrt_s * libm::sqrt(1.0 / rate_hz),
            quantum: error.quantum,
            range: error.range,
            noise: stream(seed, &format!("sensor.{name}.noise")),
            walk: stream(seed, &format!("sensor.{name}.walk")),
        }
    }

    /// One sample of `truth`.
    pub fn measure(&mut self, truth: f64) -> f64 {
        let mut y = self.scale * truth + self.bias;
        if self.noise_sd > 0.0 {
            y += self.noise_sd * self.noise.normal();
        }
        if self.walk_sd > 0.0 {
            self.bias += self.walk_sd * self.walk.normal();
        }
        y = y.clamp(-self.range, self.range);
        if self.quantum > 0.0 {
            libm::rint(y / self.quantum) * self.quantum
        } else {
            y
        }
    }

    /// The bias now: what an estimator should find.
    pub fn bias(&self) -> f64 {
        self.bias
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NONE: ChannelError = ChannelError {
        noise_per_sqrt_hz: 0.0,
        bias_sd: 0.0,
        bias_walk_per_sqrt_s: 0.0,
        scale_sd_ratio: 0.0,
        quantum: 0.0,
        range: 1e6,
    };

    /// |z| < 5: one false alarm in two million seeds; the seed is fixed.
    const Z: f64 = 5.0;

    #[test]
    fn noise_has_its_declared_mean_and_standard_deviation() {
        let error = ChannelError {
            noise_per_sqrt_hz: 0.02,
            ..NONE
        };
        let mut channel = Channel::new(&error, 800.0, 3, "test");
        let n = 200_000;
        let sd = 0.02 * libm::sqrt(400.0);
        let (mut sum, mut square) = (0.0, 0.0);
        for _ in 0..n {
            let e = channel.measure(1.5) - 1.5;
            sum += e;
            square += e * e;
        }
        let n = f64::from(n);
        assert!((sum / n).abs() < Z * sd / n.sqrt(), "mean {}", sum / n);
        let variance = square / n;
        assert!(
            (variance / (sd * sd) - 1.0).abs() < Z * (2.0 / n).sqrt(),
            "variance {variance}"
        );
    }

    #[test]
    fn bias_and_scale_have_their_declared_spread_over_seeds_and_the_bias_walks_as_declared() {
        let error = ChannelError {
            bias_sd: 0.3,
            scale_sd_ratio: 0.05,
            bias_walk_per_sqrt_s: 0.1,
            ..NONE
        };
        let n = 4_000;
        let mut sums = [0.0; 3];
        for seed in 0..n {
            let mut channel = Channel::new(&error, 100.0, seed, "test");
            let start = channel.bias();
            sums[0] += start * start;
            sums[1] += (channel.scale - 1.0) * (channel.scale - 1.0);
            for _ in 0..100 {
                channel.measure(0.0);
            }
            sums[2] += (channel.bias() - start) * (channel.bias() - start);
        }
        let n = n as f64;
        for (sum, sd) in sums.iter().zip([0.3, 0.05, 0.1]) {
            let ratio = sum / n / (sd * sd);
            assert!(
                (ratio - 1.0).abs() < Z * (2.0 / n).sqrt(),
                "{ratio} at {sd}"
            );
        }
    }

    #[test]
    fn quantisation_errs_by_half_a_step_at_most_and_the_range_holds() {
        let error = ChannelError {
            quantum: 0.01,
            range: 2.0,
            ..NONE
        };
        let mut channel = Channel::new(&error, 100.0, 1, "test");
        let mut worst: f64 = 0.0;
        for i in -1_500..1_500 {
            let x = f64::from(i) * 0.0013;
            let y = channel.measure(x);
            worst = worst.max((y - x).abs());
            let steps = y / 0.01;
            assert!((steps - steps.round()).abs() < 1e-9);
        }
        assert!(worst <= 0.005 + 1e-12 && worst > 0.0045, "worst {worst}");
        assert_eq!(channel.measure(100.0), 2.0);
        assert_eq!(channel.measure(-100.0), -2.0);
    }
}
