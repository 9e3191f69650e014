//! How well a model predicts: free runs from the predictor's state, by channel and horizon, with the
//! same horizons and restarts as `compare`.

use super::free::free_runs;
use super::pass::{Pass, Prepared};
use super::setup::{Model, Setup};
use super::speed;
use crate::compare::{HORIZONS_S, MAIN_HORIZON, RESTART_S};
use std::collections::BTreeMap;
use twinhub_ident::forecast::Score;

/// Sums of one channel.
#[derive(Clone, Debug, Default)]
pub struct Scores {
    horizons: [Score; HORIZONS_S.len()],
    noise_variance: f64,
    spread: f64,
    count: f64,
}

impl Scores {
    pub fn rmse(&self, horizon: usize) -> Option<f64> {
        self.horizons[horizon].rmse()
    }

    pub fn vaf(&self, horizon: usize) -> Option<f64> {
        self.horizons[horizon].vaf()
    }

    /// What a perfect model would reach: all but the sensor's noise.
    pub fn ceiling(&self) -> Option<f64> {
        (self.count > 1.0 && self.spread > 0.0)
            .then(|| (1.0 - self.noise_variance * self.count / self.spread).max(0.0))
    }
}

/// One channel of one ride, predicted up to the middle horizon ahead.
#[derive(Clone, Debug)]
pub struct Trace {
    pub ride: usize,
    pub quantity: String,
    /// Time, reading, prediction.
    pub points: Vec<[f64; 3]>,
}

/// Scores by channel, and traces.
pub struct Forecast {
    pub scores: BTreeMap<String, Scores>,
    pub traces: Vec<Trace>,
}

/// How a model predicts rides; none if the model cannot be.
pub fn forecast(rides: &[Prepared], model: &Model) -> Option<Forecast> {
    let plant = model.plant().ok()?;
    let longest = HORIZONS_S[HORIZONS_S.len() - 1];
    let mut all: BTreeMap<String, Scores> = BTreeMap::new();
    let mut traces = vec![];
    for (number, prepared) in rides.iter().enumerate() {
        let ride = &prepared.ride;
        let setup = Setup::new(&plant, ride);
        let course = super::course::Course::new(ride, &setup);
        let mut pass = Pass::empty(&course);
        let paces = speed::run(ride, &course, &setup, model, &mut pass);
        let mut runs: Vec<(f64, Vec<(usize, f64)>)> =
            free_runs(ride, &course, &setup, model, &paces, longest, RESTART_S)
                .into_iter()
                .map(|r| (r.start_s, r.said))
                .collect();
        if ride.speed.is_none() {
            for (start_s, said) in &mut runs {
                let from = course.steps.partition_point(|s| s.t_s < *start_s - 1e-9);
                let window = ride.windows.iter().find(|w| *start_s < w[1] + 1e-6);
                let end_s = (*start_s + longest + 1e-6).min(window.map_or(f64::MAX, |w| w[1]));
                let to = course.steps.partition_point(|s| s.t_s <= end_s);
                let range = (from + 1).min(to)..to;
                let begin = paces[from.min(paces.len() - 1)].speed_m_s;
                speed::free_run(ride, &course, &setup, begin, range, |r, value| {
                    said.push((r, value));
                });
            }
        }
        for (index, sensor) in ride.sensors.iter().enumerate() {
            let scores = all.entry(sensor.quantity.name().to_owned()).or_default();
            let late = sensor.delay_s + setup.sensors[index].delay_s;
            let mut points = vec![];
            for (k, horizon) in HORIZONS_S.iter().enumerate() {
                let mut pairs = vec![];
                for (start_s, said) in &runs {
                    let ends = ride.windows.iter().find(|w| *start_s < w[1] + 1e-6);
                    if ends.is_none_or(|w| start_s + horizon > w[1] + 1e-6) {
                        continue;
                    }
                    for (r, value) in said {
                        let reading = &course.readings[*r];
                        if reading.sensor == index && reading.t_s - late <= start_s + horizon + 1e-6
                        {
                            pairs.push((reading.value, *value));
                            if k == MAIN_HORIZON {
                                points.push([reading.t_s, reading.value, *value]);
                            }
                        }
                    }
                }
                scores.horizons[k].add(&pairs);
            }
            traces.push(Trace {
                ride: number,
                quantity: sensor.quantity.name().to_owned(),
                points,
            });
            let values = sensor.samples.iter().map(|s| s.1);
            let count = values.clone().count() as f64;
            let mean = values.clone().sum::<f64>() / count.max(1.0);
            scores.spread += values.map(|v| (v - mean) * (v - mean)).sum::<f64>();
            scores.count += count;
            let sd = model.noise_sd(sensor);
            scores.noise_variance = sd * sd + sensor.quantum * sensor.quantum / 12.0;
        }
    }
    Some(Forecast {
        scores: all,
        traces,
    })
}
