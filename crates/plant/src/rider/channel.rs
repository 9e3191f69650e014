//! What every rider channel shares: a dead time and the lag of the muscles.

/// The longest delay that a rider may have, s.
pub const MAX_DELAY_S: f64 = 1.0;

/// A dead time of whole ticks.
#[derive(Clone, Debug)]
pub struct DelayLine<const N: usize> {
    past: Vec<[f64; N]>,
    next: usize,
}

impl<const N: usize> DelayLine<N> {
    /// A line of `delay_s`, rounded to whole ticks of `step_s`, filled with zeros.
    pub fn new(delay_s: f64, step_s: f64) -> Self {
        let ticks = libm::round(delay_s.clamp(0.0, MAX_DELAY_S) / step_s) as usize;
        Self {
            past: vec![[0.0; N]; ticks],
            next: 0,
        }
    }

    /// Takes in the present and gives back what was taken in `delay_s` ago.
    pub fn push(&mut self, present: [f64; N]) -> [f64; N] {
        let Some(slot) = self.past.get_mut(self.next) else {
            return present;
        };
        let delayed = core::mem::replace(slot, present);
        self.next = (self.next + 1) % self.past.len();
        delayed
    }
}

/// Second-order lag of the neuromuscular system.
///
/// Equation: y'' + 2 ζ ω y' + ω² y = ω² u, integrated exactly enough by the semi-implicit Euler
/// rule at the tick (ω times step is 0.03).
/// Source: form and values (ω = 30 rad/s, ζ = 0.707) of Hess, Moore and Hubbard (2012), IEEE
/// Trans. Syst. Man Cybern. A 42, as used for bicycle riders.
#[derive(Clone, Copy, Debug)]
pub struct NeuromuscularLag {
    frequency_rad_s: f64,
    damping_ratio: f64,
    value: f64,
    rate: f64,
}

impl NeuromuscularLag {
    /// At rest.
    pub fn new(frequency_rad_s: f64, damping_ratio: f64) -> Self {
        Self {
            frequency_rad_s,
            damping_ratio,
            value: 0.0,
            rate: 0.0,
        }
    }

    /// One tick towards `target`.
    pub fn step(&mut self, target: f64, step_s: f64) -> f64 {
        let w = self.frequency_rad_s;
        self.rate +=
            step_s * (w * w * (target - self.value) - 2.0 * self.damping_ratio * w * self.rate);
        self.value += step_s * self.rate;
        self.value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_delay_line_delays_by_whole_ticks() {
        let mut line = DelayLine::<1>::new(0.003, 0.001);
        let out: Vec<f64> = (1..=6).map(|i| line.push([f64::from(i)])[0]).collect();
        assert_eq!(out, [0.0, 0.0, 0.0, 1.0, 2.0, 3.0]);
        assert_eq!(DelayLine::<1>::new(0.0, 0.001).push([4.0]), [4.0]);
    }

    #[test]
    fn the_lag_settles_with_the_damping_it_is_given() {
        let mut lag = NeuromuscularLag::new(30.0, 0.707);
        let path: Vec<f64> = (0..1000).map(|_| lag.step(2.0, 0.001)).collect();
        let peak = path.iter().copied().fold(0.0, f64::max);
        assert!((path[999] - 2.0).abs() < 1e-6);
        // Overshoot of a second-order lag: exp(-pi zeta / sqrt(1 - zeta²)) = 4.3 %.
        assert!((peak / 2.0 - 1.043).abs() < 0.01, "peak {peak}");
    }
}
