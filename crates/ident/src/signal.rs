//! A sampled signal and what happens between its samples.

/// What an input does between two samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hold {
    /// Keeps the value of the last sample.
    Zero,
    /// Straight line to the next sample.
    Linear,
}

/// Times ascend strictly; values are finite.
#[derive(Clone, Debug)]
pub struct Signal {
    t_s: Vec<f64>,
    value: Vec<f64>,
    hold: Hold,
}

/// Why samples do not make a signal.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SignalError {
    #[error("no sample at all")]
    Empty,
    #[error("sample {index} at {t_s} s is not after the one before it, at {before_s} s")]
    NotAscending {
        index: usize,
        t_s: f64,
        before_s: f64,
    },
    #[error("sample {index} is not finite")]
    NotFinite { index: usize },
}

impl Signal {
    /// From samples in the order of time; missing values are simply not among them.
    pub fn new(
        samples: impl IntoIterator<Item = (f64, f64)>,
        hold: Hold,
    ) -> Result<Self, SignalError> {
        let (t_s, value): (Vec<f64>, Vec<f64>) = samples.into_iter().unzip();
        if t_s.is_empty() {
            return Err(SignalError::Empty);
        }
        if let Some(index) = t_s
            .iter()
            .zip(&value)
            .position(|(t, v)| !t.is_finite() || !v.is_finite())
        {
            return Err(SignalError::NotFinite { index });
        }
        if let Some(index) = t_s.windows(2).position(|pair| pair[1] <= pair[0]) {
            return Err(SignalError::NotAscending {
                index: index + 1,
                t_s: t_s[index + 1],
                before_s: t_s[index],
            });
        }
        Ok(Self { t_s, value, hold })
    }

    /// The same value for ever.
    pub fn constant(value: f64) -> Self {
        Self {
            t_s: vec![0.0],
            value: vec![value],
            hold: Hold::Zero,
        }
    }

    /// Times of the samples.
    pub fn times_s(&self) -> &[f64] {
        &self.t_s
    }

    /// Values of the samples.
    pub fn values(&self) -> &[f64] {
        &self.value
    }

    /// Between-sample rule.
    pub fn hold(&self) -> Hold {
        self.hold
    }

    /// Value and slope just after `t_s`; before the first and after the last sample the nearest
    /// value holds.
    pub fn at(&self, t_s: f64) -> (f64, f64) {
        let next = self.t_s.partition_point(|t| *t <= t_s + 1e-9);
        if next == 0 {
            return (self.value[0], 0.0);
        }
        if next == self.t_s.len() || self.hold == Hold::Zero {
            return (self.value[next - 1], 0.0);
        }
        let slope =
            (self.value[next] - self.value[next - 1]) / (self.t_s[next] - self.t_s[next - 1]);
        (
            self.value[next - 1] + slope * (t_s - self.t_s[next - 1]),
            slope,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn holds() {
        let samples = [(0.0, 1.0), (1.0, 3.0), (3.0, -1.0)];
        let linear = Signal::new(samples, Hold::Linear).unwrap();
        assert_eq!(linear.at(-1.0), (1.0, 0.0));
        assert_eq!(linear.at(0.5), (2.0, 2.0));
        assert_eq!(linear.at(1.0), (3.0, -2.0));
        assert_eq!(linear.at(4.0), (-1.0, 0.0));
        let zero = Signal::new(samples, Hold::Zero).unwrap();
        assert_eq!(zero.at(0.5), (1.0, 0.0));
        assert_eq!(zero.at(2.9), (3.0, 0.0));
    }

    #[test]
    fn refuses_bad_samples() {
        assert_eq!(Signal::new([], Hold::Zero).unwrap_err(), SignalError::Empty);
        assert!(matches!(
            Signal::new([(0.0, 1.0), (0.0, 2.0)], Hold::Zero),
            Err(SignalError::NotAscending { index: 1, .. })
        ));
        assert!(matches!(
            Signal::new([(0.0, f64::NAN)], Hold::Zero),
            Err(SignalError::NotFinite { index: 0 })
        ));
    }
}
