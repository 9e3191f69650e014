//! What: which gains of a torque rider keep a bicycle up.
//!
//! Equation: T = -k_p φ(t - τ) - k_d φ'(t - τ); k_p is inside a window if some k_d makes the
//! largest growth rate negative. For each k_p growth is minimised over k_d (scan, then golden
//! section); borders of a window are found by bisection.
//!
//! Source: growth of `closed_loop`.
//!
//! Assumes and ignores: no lag of muscles, as in the thesis; k_d within ±20 Nm s/rad.
//!
//! Valid for: as `closed_loop`.
//!
//! Checked by: `rider/tests`: cells of a table computed by an independent prototype (±1.5 Nm/rad).

use super::closed_loop::ClosedLoop;
use super::{LateralBicycle, Limb, LinearChannel, Signals};

/// Gains that keep the bicycle up, with some derivative gain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Smallest k_p, Nm/rad.
    pub from_nm_rad: f64,
    /// Largest k_p, Nm/rad.
    pub to_nm_rad: f64,
}

/// Largest derivative gain that is tried, Nm s/rad.
const RATE_GAIN_NMS_RAD: f64 = 20.0;
/// Steps of the scan on either side of zero.
const SCAN: i32 = 20;
/// Rounds of golden section after it.
const GOLDEN_ROUNDS: usize = 12;

/// The loop of a torque rider with these gains, without lag.
fn torque_rider(delay_s: f64, roll: f64, roll_rate: f64) -> LinearChannel {
    LinearChannel {
        limb: Limb::Bar,
        lag: None,
        delay_s,
        delayed: Signals {
            roll,
            roll_rate,
            ..Signals::default()
        },
        stiffness_nm_rad: 0.0,
        damping_nm_s_rad: 0.0,
    }
}

/// Least growth rate over the derivative gain, 1/s, and that gain, Nm s/rad.
pub fn least_growth(bicycle: &LateralBicycle, delay_s: f64, roll_nm_rad: f64) -> (f64, f64) {
    let growth = |rate_gain: f64| {
        ClosedLoop::new(bicycle, &[torque_rider(delay_s, roll_nm_rad, rate_gain)])
            .growth_of_finite_per_s()
    };
    // Finer near zero, where good gains lie.
    let scanned = |i: i32| {
        let share = f64::from(i) / f64::from(SCAN);
        RATE_GAIN_NMS_RAD * share * share.abs()
    };
    let (best, _) = (-SCAN..=SCAN)
        .map(|i| (i, growth(scanned(i))))
        .fold((0, f64::INFINITY), |a, b| if b.1 < a.1 { b } else { a });
    let (mut low, mut high) = (
        scanned((best - 1).max(-SCAN)),
        scanned((best + 1).min(SCAN)),
    );
    let ratio = 0.5 * (libm::sqrt(5.0) - 1.0);
    let mut at = [high - ratio * (high - low), low + ratio * (high - low)];
    let mut value = at.map(growth);
    for _ in 0..GOLDEN_ROUNDS {
        if value[0] < value[1] {
            high = at[1];
            (at[1], value[1]) = (at[0], value[0]);
            at[0] = high - ratio * (high - low);
            value[0] = growth(at[0]);
        } else {
            low = at[0];
            (at[0], value[0]) = (at[1], value[1]);
            at[1] = low + ratio * (high - low);
            value[1] = growth(at[1]);
        }
    }
    let (k, g) = if value[0] < value[1] {
        (at[0], value[0])
    } else {
        (at[1], value[1])
    };
    let scan = growth(scanned(best));
    if g < scan {
        (g, k)
    } else {
        (scan, scanned(best))
    }
}

/// The windows of k_p between `from_nm_rad` and `to_nm_rad`, borders to 0.05 Nm/rad.
pub fn windows(
    bicycle: &LateralBicycle,
    delay_s: f64,
    from_nm_rad: f64,
    to_nm_rad: f64,
) -> Vec<Window> {
    let stable = |k: f64| least_growth(bicycle, delay_s, k).0 < 0.0;
    // Narrow windows are a Nm/rad wide.
    let steps = (to_nm_rad - from_nm_rad).max(1.0).ceil() as usize;
    let grid: Vec<(f64, bool)> = (0..=steps)
        .map(|i| from_nm_rad + (to_nm_rad - from_nm_rad) * i as f64 / steps as f64)
        .map(|k| (k, stable(k)))
        .collect();
    let border = |mut inside: f64, mut outside: f64| {
        while (inside - outside).abs() > 0.05 {
            let middle = 0.5 * (inside + outside);
            if stable(middle) {
                inside = middle;
            } else {
                outside = middle;
            }
        }
        inside
    };
    let mut found = Vec::new();
    let mut from = grid[0].1.then_some(grid[0].0);
    for pair in grid.windows(2) {
        let ((a, was), (b, is)) = (pair[0], pair[1]);
        match (was, is) {
            (false, true) => from = Some(border(b, a)),
            (true, false) => found.push(Window {
                from_nm_rad: from.take().unwrap_or(a),
                to_nm_rad: border(a, b),
            }),
            _ => {}
        }
    }
    found.extend(from.map(|from_nm_rad| Window {
        from_nm_rad,
        to_nm_rad,
    }));
    found
}
