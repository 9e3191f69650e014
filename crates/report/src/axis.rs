//! Axes: the range that data need, and round numbers on it.

/// A linear map from a range of values to pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    /// Value at `from_px`.
    pub low: f64,
    /// Value at `to_px`; above `low`.
    pub high: f64,
    /// Pixel of `low`.
    pub from_px: f64,
    /// Pixel of `high`.
    pub to_px: f64,
}

impl Axis {
    /// Pixel of `value`.
    pub fn at(&self, value: f64) -> f64 {
        self.from_px + (value - self.low) / (self.high - self.low) * (self.to_px - self.from_px)
    }
}

/// Step of about `count` ticks over `span`: 1, 2 or 5 times a power of ten.
pub fn tick_step(span: f64, count: f64) -> f64 {
    if !(span.is_finite() && span > 0.0) {
        return 1.0;
    }
    let raw = span / count;
    let power = 10.0_f64.powf(raw.log10().floor());
    let lead = raw / power;
    power
        * if lead < 1.5 {
            1.0
        } else if lead < 3.5 {
            2.0
        } else if lead < 7.5 {
            5.0
        } else {
            10.0
        }
}

/// Round numbers from `low` to `high`, about `count` of them, and their labels.
pub fn ticks(low: f64, high: f64, count: f64) -> Vec<(f64, String)> {
    let step = tick_step(high - low, count);
    let (first, last) = ((low / step - 1e-6).ceil(), (high / step + 1e-6).floor());
    let places = (-step.log10() - 1e-9).ceil().clamp(0.0, 12.0) as usize;
    // At most a few dozen, whatever the range is.
    (0..=(last - first).clamp(0.0, 60.0) as u32)
        .map(|k| (first + f64::from(k)) * step)
        .map(|value| {
            let value = if value == 0.0 { 0.0 } else { value };
            (value, format!("{value:.places$}").replace('-', "−"))
        })
        .collect()
}

/// Smallest and largest finite value.
pub fn extent<'a>(values: impl IntoIterator<Item = &'a f64>) -> Option<(f64, f64)> {
    values
        .into_iter()
        .filter(|v| v.is_finite())
        .fold(None, |range, &v| match range {
            None => Some((v, v)),
            Some((low, high)) => Some((low.min(v), high.max(v))),
        })
}

/// A range a little wider than the data, so that no line lies on the frame; data without width
/// get some.
pub fn roomy((low, high): (f64, f64)) -> (f64, f64) {
    let width = high - low;
    let smallest = 1e-9 * low.abs().max(high.abs()).max(1e-3);
    let margin = if width > smallest {
        0.06 * width
    } else if low == 0.0 {
        1.0
    } else {
        0.1 * low.abs()
    };
    (low - margin, high + margin)
}

/// A range whose ends are on a tick if they are almost on one: a ride of 60 s ends at 59.999 s.
pub fn snapped((low, high): (f64, f64), count: f64) -> (f64, f64) {
    let step = tick_step(high - low, count);
    let near = 0.004 * (high - low);
    let snap = |value: f64| {
        let tick = (value / step).round() * step;
        if (tick - value).abs() <= near {
            tick
        } else {
            value
        }
    };
    (snap(low), snap(high))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn ticks_are_round_and_inside() {
        let labels = |low, high| -> Vec<String> {
            ticks(low, high, 5.0)
                .into_iter()
                .map(|(_, label)| label)
                .collect()
        };
        assert_eq!(labels(0.0, 10.0), ["0", "2", "4", "6", "8", "10"]);
        assert_eq!(
            labels(-0.06, 0.06),
            ["−0.06", "−0.04", "−0.02", "0.00", "0.02", "0.04", "0.06"]
        );
        assert_eq!(
            labels(0.0, 60_000.0),
            ["0", "10000", "20000", "30000", "40000", "50000", "60000"]
        );
    }

    #[test]
    fn a_ride_of_a_minute_ends_at_sixty() {
        assert_eq!(snapped((0.0, 59.999), 10.0), (0.0, 60.0));
        assert_eq!(snapped((0.9, 57.0), 10.0), (0.9, 57.0));
    }

    #[test]
    fn gaps_do_not_count() {
        assert_eq!(
            extent(&[f64::NAN, 2.0, f64::INFINITY, -1.0]),
            Some((-1.0, 2.0))
        );
        assert_eq!(extent(&[f64::NAN]), None);
    }

    proptest! {
        #[test]
        fn a_range_holds_its_data_and_few_ticks(a in -1e6..1e6f64, width in 0.0..1e6f64) {
            let (low, high) = roomy((a, a + width));
            prop_assert!(low < a && a + width < high);
            let marks = ticks(low, high, 5.0);
            prop_assert!((3..=9).contains(&marks.len()), "{} ticks on {low}..{high}", marks.len());
        }
    }
}
