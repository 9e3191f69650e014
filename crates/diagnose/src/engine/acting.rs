//! Inputs as they truly act, which need not be as they were commanded or read: gains, limits, delays and
//! lags between the two.

use super::course::{Ends, Felt, MOST_DRIVES, SAME_TIME_S};
use super::ride::Ride;
use super::setup::Setup;
use twinhub_ident::{Hold, Signal};
use twinhub_mechanism::InputModel;

/// A prescribed speed is differentiated over twice this.
const SLOPE_S: f64 = 0.25;

/// The inputs of a ride as they act.
pub(super) struct Truth {
    pub(super) drives: Vec<Signal>,
    pub(super) brake: Option<Acting>,
    pub(super) traction: Option<Acting>,
    pub(super) speed: Option<Signal>,
}

/// A torque as it acts: its mean between samples, and what it is at a moment.
pub(super) struct Acting {
    pub(super) mean: Signal,
    lag: Option<Lag>,
}

/// A held input behind a lag: what it is told at each sample, and where it then is.
struct Lag {
    time_s: f64,
    told: Signal,
    there: Vec<f64>,
}

impl Truth {
    pub(super) fn new(ride: &Ride, setup: &Setup) -> Self {
        let torque = |signal: &Option<Signal>, model: &InputModel| {
            signal.as_ref().map(|s| Acting::new(s, model))
        };
        Self {
            drives: ride
                .drives
                .iter()
                .zip(&setup.drives)
                .map(|(d, m)| shaped(&d.signal, m))
                .collect(),
            brake: torque(&ride.front_brake, &setup.brake),
            traction: torque(&ride.rear_traction, &setup.traction),
            speed: ride.speed.as_ref().map(|s| shaped(s, &setup.speed)),
        }
    }

    pub(super) fn ends(&self, ride: &Ride, from_s: f64, dt_s: f64) -> (Ends, Ends) {
        // Past the sample that stands there, however its time was rounded.
        let from_s = from_s + 2.0 * SAME_TIME_S;
        let mut pair = [Ends {
            drive: [0.0; MOST_DRIVES],
            brake_nm: 0.0,
            traction_nm: 0.0,
            speed_m_s: f64::NAN,
            accel_m_s2: 0.0,
            crank_rad: f64::NAN,
            wheel_rad: f64::NAN,
            trunk_rad: f64::NAN,
        }; 2];
        let both = |signal: &Signal| {
            let (value, slope) = signal.at(from_s);
            [value, value + slope * dt_s]
        };
        for (i, (signal, drive)) in self.drives.iter().zip(&ride.drives).enumerate() {
            let (value, slope) = signal.at(from_s);
            let value = value + drive.lag_s * slope;
            pair[0].drive[i] = value;
            pair[1].drive[i] = value + slope * dt_s;
        }
        let mut put = |signal: Option<&Signal>, set: fn(&mut Ends, f64)| {
            if let Some(signal) = signal {
                let [a, b] = both(signal);
                set(&mut pair[0], a);
                set(&mut pair[1], b);
            }
        };
        put(self.brake.as_ref().map(|a| &a.mean), |e, x| e.brake_nm = x);
        put(self.traction.as_ref().map(|a| &a.mean), |e, x| {
            e.traction_nm = x
        });
        put(self.speed.as_ref(), |e, x| e.speed_m_s = x);
        put(ride.crank.as_ref(), |e, x| e.crank_rad = x);
        put(ride.wheel.as_ref(), |e, x| e.wheel_rad = x);
        put(ride.trunk.as_ref(), |e, x| e.trunk_rad = x);
        if let Some(speed) = &self.speed {
            let middle = from_s + 0.5 * dt_s;
            let times = speed.times_s();
            let (first, last) = (times[0], times[times.len() - 1]);
            let (a, b) = ((middle - SLOPE_S).max(first), (middle + SLOPE_S).min(last));
            if b > a {
                let slope = (speed.at(b).0 - speed.at(a).0) / (b - a);
                pair[0].accel_m_s2 = slope;
                pair[1].accel_m_s2 = slope;
            }
        }
        (pair[0], pair[1])
    }

    /// Torques that an accelerometer feels which is read at `t_s` by a clock that errs by `jitter_s`: a
    /// reading where a torque steps may lie before the step or after it.
    pub(super) fn felt(&self, t_s: f64, jitter_s: f64) -> Felt {
        let at = |torque: &Option<Acting>| -> [f64; 2] {
            let Some(torque) = torque else {
                return [0.0; 2];
            };
            if jitter_s > 0.0 {
                let (early, late) = (torque.at(t_s - jitter_s), torque.at(t_s + jitter_s));
                [0.5 * (late + early), 0.5 * (late - early)]
            } else {
                [torque.at(t_s + 2.0 * SAME_TIME_S), 0.0]
            }
        };
        let ([brake_nm, brake_half_nm], [traction_nm, traction_half_nm]) =
            (at(&self.brake), at(&self.traction));
        Felt {
            brake_nm,
            brake_half_nm,
            traction_nm,
            traction_half_nm,
        }
    }
}

impl Acting {
    fn new(signal: &Signal, model: &InputModel) -> Self {
        let mean = shaped(signal, model);
        let lag = (model.lag_s > 0.0 && signal.hold() == Hold::Zero).then(|| {
            let told = shaped(
                signal,
                &InputModel {
                    lag_s: 0.0,
                    ..*model
                },
            );
            let mut there = vec![told.values()[0]];
            for (times, values) in told.times_s().windows(2).zip(told.values()) {
                let decay = libm::exp(-(times[1] - times[0]) / model.lag_s);
                there.push(values + (there[there.len() - 1] - values) * decay);
            }
            Lag {
                time_s: model.lag_s,
                told,
                there,
            }
        });
        Self { mean, lag }
    }

    /// What it is at a moment.
    fn at(&self, t_s: f64) -> f64 {
        let Some(lag) = &self.lag else {
            return self.mean.at(t_s).0;
        };
        let times = lag.told.times_s();
        let next = times.partition_point(|t| *t <= t_s);
        let Some(last) = next.checked_sub(1) else {
            return lag.there[0];
        };
        let (told, there) = (lag.told.values()[last], lag.there[last]);
        told + (there - told) * libm::exp(-(t_s - times[last]) / lag.time_s)
    }
}

/// An input as it truly acts.
fn shaped(signal: &Signal, model: &InputModel) -> Signal {
    if *model == InputModel::IDEAL {
        return signal.clone();
    }
    let limit = model.limit;
    let values: Vec<(f64, f64)> = signal
        .times_s()
        .iter()
        .map(|&t| {
            let raw = signal.at(t).0;
            let value = if raw == 0.0 {
                model.idle_drag
            } else {
                model.gain * raw
            };
            (
                t + model.delay_s,
                (value + model.offset).clamp(-limit, limit),
            )
        })
        .collect();
    let lagged = if model.lag_s > 0.0 {
        lagged(&values, model.lag_s, signal.hold())
    } else {
        values
    };
    Signal::new(lagged, signal.hold()).unwrap_or_else(|_| signal.clone())
}

/// First-order lag, exact for the hold between the samples. A held signal becomes the mean of the
/// lagged one over each interval.
fn lagged(values: &[(f64, f64)], tau: f64, hold: Hold) -> Vec<(f64, f64)> {
    let mut y = values[0].1;
    let mut out = Vec::with_capacity(values.len());
    match hold {
        Hold::Linear => {
            out.push((values[0].0, y));
            for pair in values.windows(2) {
                let (h, u0, u1) = (pair[1].0 - pair[0].0, pair[0].1, pair[1].1);
                let slope = (u1 - u0) / h;
                y = u1 - tau * slope + (y - u0 + tau * slope) * libm::exp(-h / tau);
                out.push((pair[1].0, y));
            }
        }
        Hold::Zero => {
            let mut length = 0.0;
            for (k, (t, u)) in values.iter().enumerate() {
                length = values.get(k + 1).map_or(length, |next| next.0 - t);
                if length <= 0.0 {
                    out.push((*t, *u));
                    continue;
                }
                let decay = libm::exp(-length / tau);
                out.push((*t, u + (y - u) * tau / length * (1.0 - decay)));
                y = u + (y - u) * decay;
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A lag that vanishes changes nothing, whatever the hold; a step answers exponentially.
    #[test]
    fn lag() {
        let values: Vec<(f64, f64)> = (0..200)
            .map(|k| (k as f64 * 0.01, if k < 50 { 0.0 } else { 2.0 }))
            .collect();
        for hold in [Hold::Zero, Hold::Linear] {
            let same = lagged(&values, 1e-9, hold);
            for (a, b) in same.iter().zip(&values) {
                assert!((a.1 - b.1).abs() < 1e-5, "{a:?} {b:?}");
            }
            let out = lagged(&values, 0.1, hold);
            let expected = 2.0 * (1.0 - libm::exp(-5.0));
            assert!(
                (out[100].1 - expected).abs() < 0.01,
                "{hold:?} {}",
                out[100].1
            );
        }
    }
    /// What a lagging torque is at each moment has the mean that moves the bicycle.
    #[test]
    fn moments_of_a_lag_have_its_mean() {
        let told = Signal::new([(0.0, 0.0), (0.01, 3.0), (0.02, 1.0)], Hold::Zero).unwrap();
        let model = InputModel {
            lag_s: 0.004,
            ..InputModel::IDEAL
        };
        let acting = Acting::new(&told, &model);
        let count = 1000;
        let moments = (0..count).map(|k| acting.at(0.01 + 0.01 * (k as f64 + 0.5) / count as f64));
        let mean = moments.sum::<f64>() / count as f64;
        assert!((mean - acting.mean.values()[1]).abs() < 1e-5, "{mean}");
        // It has not moved yet where it is told to, and is continuous there.
        assert!(acting.at(0.01).abs() < 1e-12);
        assert!((acting.at(0.02 - 1e-9) - acting.at(0.02 + 1e-9)).abs() < 1e-5);
    }

    /// A reading on a step lies before it or after it, if the clock errs.
    #[test]
    fn a_step_is_felt_by_halves() {
        let signal = Signal::new([(0.0, 1.0), (0.01, 5.0)], Hold::Zero).unwrap();
        let truth = Truth {
            drives: vec![],
            brake: Some(Acting::new(&signal, &InputModel::IDEAL)),
            traction: None,
            speed: None,
        };
        let felt = truth.felt(0.01, 3e-4);
        assert_eq!((felt.brake_nm, felt.brake_half_nm), (3.0, 2.0));
        let exact = truth.felt(0.01, 0.0);
        assert_eq!((exact.brake_nm, exact.brake_half_nm), (5.0, 0.0));
        let between = truth.felt(0.015, 3e-4);
        assert_eq!((between.brake_nm, between.brake_half_nm), (5.0, 0.0));
    }
}
