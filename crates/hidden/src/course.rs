//! What a ride is meant to be: speed, pushes, torques asked for.

use crate::random::Stream;

/// How the motors are driven.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motors {
    /// No measured torque: a rider pedals, or a treadmill pulls.
    Prescribed,
    /// Front and rear with profiles of their own.
    Independent,
    /// Front brakes what the rear drives, at one time.
    Common,
    /// As independent, then all off: rolling out.
    CoastDown,
}

/// One ride's plan.
#[derive(Clone, Debug, PartialEq)]
pub struct Course {
    pub name: String,
    pub held_out: bool,
    pub duration_s: f64,
    pub speed_m_s: f64,
    /// Slow swing of the speed about it.
    pub swing_m_s: f64,
    pub motors: Motors,
    pub hands_on: bool,
    /// -1: on the way back.
    pub direction: f64,
    /// Factor on torques asked for and on pulls.
    pub amplitude: f64,
    pub development_m: f64,
}

/// A sum of sines.
#[derive(Clone, Debug)]
pub struct Multisine {
    parts: Vec<[f64; 3]>,
}

impl Multisine {
    /// Sines from `from_hz` to `to_hz`, evenly on a logarithmic scale, with this effective value
    /// altogether and phases at random.
    pub fn new(from_hz: f64, to_hz: f64, count: usize, rms: f64, stream: &mut Stream) -> Self {
        let ratio = libm::log(to_hz / from_hz) / (count - 1) as f64;
        let amplitude = rms * libm::sqrt(2.0 / count as f64);
        let part = |k: usize| {
            let phase = stream.between(0.0, 2.0 * core::f64::consts::PI);
            let hz = from_hz * libm::exp(ratio * k as f64);
            [amplitude, 2.0 * core::f64::consts::PI * hz, phase]
        };
        Self {
            parts: (0..count).map(part).collect(),
        }
    }

    pub fn at(&self, t_s: f64) -> f64 {
        let one = |[a, w, phase]: &[f64; 3]| a * libm::sin(w * t_s + phase);
        self.parts.iter().map(one).sum()
    }
}

/// Pulls at a rope: half sines.
#[derive(Clone, Debug)]
pub struct Pulls {
    each: Vec<[f64; 3]>,
}

impl Pulls {
    /// A pull about every five seconds, from 60 to 130 N times `amplitude`, to either side.
    pub fn new(duration_s: f64, amplitude: f64, stream: &mut Stream) -> Self {
        let mut each = vec![];
        let mut t = stream.between(2.0, 4.0);
        while t < duration_s - 1.0 {
            let peak = stream.sign() * amplitude * stream.between(60.0, 130.0);
            each.push([t, stream.between(0.25, 0.45), peak]);
            t += stream.between(3.5, 6.5);
        }
        Self { each }
    }

    pub fn at(&self, t_s: f64) -> f64 {
        let one = |[start, length, peak]: &[f64; 3]| {
            let part = (t_s - start) / length;
            match (0.0..1.0).contains(&part) {
                true => peak * libm::sin(core::f64::consts::PI * part),
                false => 0.0,
            }
        };
        self.each.iter().map(one).sum()
    }
}

/// A torque that switches between levels at random times, on the grid of samples.
#[derive(Clone, Debug)]
pub struct Switching {
    /// Time from which a level holds.
    levels: Vec<[f64; 2]>,
}

impl Switching {
    /// Holds levels between `low` and `high` for 0.3 to 1.5 s each.
    pub fn new(duration_s: f64, low: f64, high: f64, stream: &mut Stream) -> Self {
        let mut levels = vec![];
        let mut t = 0.0;
        while t < duration_s {
            levels.push([t, stream.between(low, high)]);
            t += libm::round(stream.between(30.0, 150.0)) / 100.0;
        }
        Self { levels }
    }

    pub fn at(&self, t_s: f64) -> f64 {
        let after = self.levels.partition_point(|l| l[0] <= t_s + 1e-9);
        after.checked_sub(1).map_or(0.0, |k| self.levels[k][1])
    }
}

/// How the rides of a study are laid out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layout {
    pub motors: Motors,
    /// One speed for all rides instead of a ladder.
    pub one_speed: bool,
    /// Half of the rides the other way.
    pub out_and_back: bool,
    /// Every second ride with small torques and pulls.
    pub two_amplitudes: bool,
    /// The hands hold the bar in no ride, in all, or in all but one of each use.
    pub hands: Hands,
    pub duration_s: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hands {
    Off,
    On,
    Mixed,
}

impl Layout {
    /// Four rides to fit and three held out, at seven speeds.
    pub fn standard(motors: Motors) -> Self {
        Self {
            motors,
            one_speed: false,
            out_and_back: false,
            two_amplitudes: false,
            hands: Hands::Mixed,
            duration_s: 40.0,
        }
    }

    pub fn courses(&self, stream: &mut Stream) -> Vec<Course> {
        let ladder = [3.2, 4.3, 5.4, 6.5, 3.7, 4.8, 5.9];
        let ride = |k: usize| {
            let held_out = k >= 4;
            let hands_on = match self.hands {
                Hands::Off => false,
                Hands::On => true,
                Hands::Mixed => k != 2 && k != 6,
            };
            Course {
                name: format!("ride_{:02}", k + 1),
                held_out,
                duration_s: self.duration_s,
                speed_m_s: if self.one_speed { 4.6 } else { ladder[k] }
                    + stream.between(-0.15, 0.15),
                swing_m_s: if self.one_speed { 0.05 } else { 0.3 },
                motors: self.motors,
                hands_on,
                direction: if self.out_and_back && k % 2 == 1 {
                    -1.0
                } else {
                    1.0
                },
                amplitude: if self.two_amplitudes && k % 2 == 1 {
                    0.25
                } else {
                    1.0
                },
                development_m: [4.6, 5.2, 5.9][stream.index(3)],
            }
        };
        (0..7).map(ride).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_multisine_has_its_effective_value() {
        let sines = Multisine::new(0.2, 4.0, 12, 1.5, &mut Stream::new(1, "m"));
        let squares: f64 = (0..100_000)
            .map(|k| sines.at(0.01 * f64::from(k)).powi(2))
            .sum();
        assert!(((squares / 1e5).sqrt() / 1.5 - 1.0).abs() < 0.02);
    }

    #[test]
    fn switching_changes_on_the_grid_of_samples() {
        let torque = Switching::new(20.0, -5.0, 5.0, &mut Stream::new(1, "s"));
        for k in 0..2000 {
            let t = 0.01 * f64::from(k);
            assert_eq!(torque.at(t), torque.at(t + 0.009));
        }
    }
}
