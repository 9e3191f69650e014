//! Channel against channel, without any dynamics: signs, scales and axes show here first.
//!
//! yaw rate = (v steer + c steer rate) cos(lam)/w; an angle's change = integral of its rate.

use crate::data::{Channel, RideData};
use crate::quantity::Quantity;
use serde::Serialize;
use twinhub_ident::{Equations, Hold, Signal};

/// One relation: `measured` = `slope` * `expected` + offset, with correlation `r`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Relation {
    pub ride: String,
    pub measured: String,
    pub expected: String,
    pub slope: f64,
    pub r: f64,
    /// What it means, if it is not as it should be.
    pub warning: Option<String>,
}

/// Over how long an angle's change is set against its rate.
const SPAN_S: f64 = 0.25;

/// All relations that the channels allow.
pub fn relations(equations: &Equations, data: &RideData) -> Vec<Relation> {
    let find = |q: Quantity| {
        data.channels
            .iter()
            .find(|c| c.spec.quantity == q && c.samples.len() > 2)
    };
    let signal = |c: &Channel| {
        Signal::new(
            c.samples.iter().map(|(t, v)| (t - c.spec.delay_s, *v)),
            Hold::Linear,
        )
        .ok()
    };
    let inside = |t: f64| {
        data.windows
            .iter()
            .any(|w| t >= w.start_s && t + SPAN_S < w.end_s)
    };
    let mut all = vec![];
    let mut add = |measured: &str, expected: &str, pairs: Vec<(f64, f64)>| {
        if let Some((slope, r)) = regress(&pairs) {
            let warning = match () {
                () if r < -0.5 => Some(format!("{measured} has the wrong sign against {expected}")),
                () if r > 0.8 && !(0.8..1.25).contains(&slope) => Some(format!(
                    "{measured} is {slope:.2} times what {expected} says: scale, unit or axis?"
                )),
                () => None,
            };
            all.push(Relation {
                ride: data.spec.file.clone(),
                measured: measured.to_owned(),
                expected: expected.to_owned(),
                slope,
                r,
                warning,
            });
        }
    };
    for (angle, rate) in [
        (Quantity::Roll, Quantity::RollRate),
        (Quantity::Steer, Quantity::SteerRate),
        (Quantity::Yaw, Quantity::YawRate),
    ] {
        if let (Some(a), Some(b)) = (find(angle), find(rate))
            && let Some(position) = signal(a)
        {
            let shift = b.spec.delay_s;
            let samples: Vec<(f64, f64)> = b.samples.iter().map(|(t, v)| (t - shift, *v)).collect();
            let mut pairs = vec![];
            let mut from = 0;
            while from < samples.len() {
                let t0 = samples[from].0;
                let to = samples.partition_point(|s| s.0 < t0 + SPAN_S - 1e-9);
                if to >= samples.len() {
                    break;
                }
                if inside(t0) {
                    let turned: f64 = samples[from..=to]
                        .windows(2)
                        .map(|p| 0.5 * (p[0].1 + p[1].1) * (p[1].0 - p[0].0))
                        .sum();
                    pairs.push((
                        (position.at(samples[to].0).0 - position.at(t0).0) / SPAN_S,
                        turned / SPAN_S,
                    ));
                }
                from = to.max(from + 1);
            }
            add(rate.name(), &format!("the change of {angle}"), pairs);
        }
    }
    if let (Some(yaw), Some(steer), Some(speed)) = (
        find(Quantity::YawRate),
        find(Quantity::Steer),
        data.used(Quantity::Speed),
    ) && let (Some(angle), Some(v)) = (signal(steer), signal(speed))
    {
        let pairs = yaw
            .samples
            .iter()
            .map(|(t, y)| (t - yaw.spec.delay_s, *y))
            .filter(|(t, _)| inside(*t));
        let pairs = pairs.map(|(t, y)| {
            let (delta, slope) = angle.at(t);
            (
                equations
                    .canonical()
                    .yaw_rate_rad_s(v.at(t).0, delta, slope),
                y,
            )
        });
        add(
            Quantity::YawRate.name(),
            "speed_m_s and steer_rad",
            pairs.collect(),
        );
    }
    all
}

/// Slope of y over x and their correlation.
fn regress(pairs: &[(f64, f64)]) -> Option<(f64, f64)> {
    let n = pairs.len() as f64;
    let (mx, my) = (
        pairs.iter().map(|p| p.0).sum::<f64>() / n,
        pairs.iter().map(|p| p.1).sum::<f64>() / n,
    );
    let sum =
        |f: &dyn Fn(f64, f64) -> f64| pairs.iter().map(|(x, y)| f(x - mx, y - my)).sum::<f64>();
    let (xx, yy, xy) = (sum(&|x, _| x * x), sum(&|_, y| y * y), sum(&|x, y| x * y));
    (pairs.len() > 10 && xx > 0.0 && yy > 0.0).then(|| (xy / xx, xy / (xx * yy).sqrt()))
}
