//! What: how well the model predicts: from the predictor's state it runs free for a while, again
//! and again, and what it says is set against what was read.
//!
//! Equation: VAF = 1 - var(e)/var(y), RMSE = sqrt(mean e²), over the readings of all free runs of
//! one horizon, from just after the start to the horizon; means per ride.
//!
//! Assumes and ignores: the measured inputs and the speed are known during the free run.
//!
//! Valid for: windows longer than the horizon. Runs start every `restart_s` from the window's start,
//! the first after one such interval; where none fits so, one starts as late as the window allows.
//!
//! Checked by: `tests`: exact prediction without noise, horizons, causality.

use crate::filter::{Estimate, Filter, Levels, Listener};
use crate::track::{Stretch, Track};

/// One reading within a free run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prediction {
    /// Index into the track's readings.
    pub reading: usize,
    pub predicted: f64,
    /// The sensor's last reading at the start of the run; none if it had none in this window.
    pub held: Option<f64>,
    /// Time since the start of the run.
    pub lead_s: f64,
    /// Whether it is the sensor's last reading in its run.
    pub last: bool,
}

/// All free runs of one horizon over one track.
#[derive(Clone, Debug)]
pub struct Forecast {
    pub horizon_s: f64,
    pub predictions: Vec<Prediction>,
    pub runs: usize,
}

/// The predictor's estimate at a step.
#[derive(Clone, Debug)]
pub struct Origin {
    pub step: usize,
    pub estimate: Estimate,
}

struct Keep<'a> {
    wanted: &'a [usize],
    found: Vec<Origin>,
}

impl Listener for Keep<'_> {
    fn innovation(&mut self, _reading: usize, _error: f64, _variance: f64) {}

    fn step(&mut self, step: usize, estimate: &Estimate) {
        if self.wanted.binary_search(&step).is_ok() {
            self.found.push(Origin {
                step,
                estimate: estimate.clone(),
            });
        }
    }
}

/// Estimates after the given steps (ascending), each from the readings up to there.
pub fn origins(track: &Track, levels: &Levels, steps: &[usize]) -> Vec<Origin> {
    let mut keep = Keep {
        wanted: steps,
        found: vec![],
    };
    Filter::new(track, levels).run(&mut keep);
    keep.found
}

/// Free runs of every horizon.
pub fn forecast(
    track: &Track,
    levels: &Levels,
    horizons_s: &[f64],
    restart_s: f64,
) -> Vec<Forecast> {
    let starts: Vec<Vec<usize>> = horizons_s
        .iter()
        .map(|h| {
            track
                .stretches
                .iter()
                .flat_map(|s| start_steps(track, s, *h, restart_s))
                .collect()
        })
        .collect();
    let mut all: Vec<usize> = starts.concat();
    all.sort_unstable();
    all.dedup();
    let origins = origins(track, levels, &all);
    let sensors = track.quantum_variance.len();
    horizons_s
        .iter()
        .zip(&starts)
        .map(|(&horizon_s, starts)| {
            let mut predictions = vec![];
            for start in starts {
                let Ok(index) = origins.binary_search_by_key(start, |o| o.step) else {
                    continue;
                };
                run(track, &origins[index], horizon_s, sensors, &mut predictions);
            }
            Forecast {
                horizon_s,
                predictions,
                runs: starts.len(),
            }
        })
        .collect()
}

fn run(
    track: &Track,
    origin: &Origin,
    horizon_s: f64,
    sensors: usize,
    predictions: &mut Vec<Prediction>,
) {
    let Some(stretch) = track
        .stretches
        .iter()
        .find(|s| s.steps.contains(&origin.step))
    else {
        return;
    };
    let t0 = track.steps[origin.step].t_s;
    let first_reading = track.steps[stretch.steps.start].readings.start;
    let held: Vec<Option<f64>> = (0..sensors)
        .map(|sensor| {
            let past = &track.readings[first_reading..track.steps[origin.step].readings.end];
            past.iter()
                .rev()
                .find(|r| r.sensor == sensor)
                .map(|r| r.value)
        })
        .collect();
    let end = track.steps[..stretch.steps.end]
        .partition_point(|s| s.t_s <= t0 + horizon_s + 1e-6 || s.t_s <= t0);
    let end = end.clamp(origin.step + 1, stretch.steps.end);
    let from = predictions.len();
    let mut lead = (origin.step + 1..end).flat_map(|s| {
        track.steps[s]
            .readings
            .clone()
            .map(move |_| track.steps[s].t_s - t0)
    });
    origin
        .estimate
        .free_run(track, origin.step + 1..end, |reading, predicted| {
            let sensor = track.readings[reading].sensor;
            let lead_s = lead.next().unwrap_or(horizon_s);
            predictions.push(Prediction {
                reading,
                predicted,
                held: held[sensor],
                lead_s,
                last: false,
            });
        });
    let mut seen = vec![false; sensors];
    for prediction in predictions[from..].iter_mut().rev() {
        let sensor = track.readings[prediction.reading].sensor;
        prediction.last = !seen[sensor];
        seen[sensor] = true;
    }
}

/// Steps at whose end free runs of one horizon start.
fn start_steps(track: &Track, stretch: &Stretch, horizon_s: f64, restart_s: f64) -> Vec<usize> {
    let steps = &track.steps[stretch.steps.clone()];
    let (Some(first), Some(last)) = (steps.first(), steps.last()) else {
        return vec![];
    };
    // A reading stands for the interval that follows it: the last one ends with the window.
    let interval = (last.t_s - first.t_s) / (steps.len().max(2) - 1) as f64;
    let end = last.t_s + interval + 1e-6;
    let at = |t: f64| stretch.steps.start + steps.partition_point(|s| s.t_s < t - 1e-6);
    let mut starts: Vec<usize> = (1..)
        .map(|k| first.t_s + restart_s * f64::from(k))
        .take_while(|t| t + horizon_s <= end)
        .map(at)
        .collect();
    let latest = end - horizon_s;
    if starts.is_empty() && latest > first.t_s + 2.0 * interval {
        starts.push(
            stretch.steps.start + steps.partition_point(|s| s.t_s <= latest).saturating_sub(1),
        );
    }
    starts.retain(|s| s + 1 < stretch.steps.end);
    starts.dedup();
    starts
}

/// Sums for VAF and RMSE of one channel, over rides.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Score {
    count: f64,
    squares: f64,
    /// Sums of squares about the ride's mean.
    error_spread: f64,
    reading_spread: f64,
}

impl Score {
    /// Adds one ride's readings and predictions.
    pub fn add(&mut self, pairs: &[(f64, f64)]) {
        if pairs.is_empty() {
            return;
        }
        let count = pairs.len() as f64;
        let mean = |f: fn(&(f64, f64)) -> f64| pairs.iter().map(f).sum::<f64>() / count;
        let (my, me) = (mean(|p| p.0), mean(|p| p.0 - p.1));
        for (y, predicted) in pairs {
            let e = y - predicted;
            self.squares += e * e;
            self.error_spread += (e - me) * (e - me);
            self.reading_spread += (y - my) * (y - my);
        }
        self.count += count;
    }

    /// Root mean square of the error; none without readings.
    pub fn rmse(&self) -> Option<f64> {
        (self.count > 0.0).then(|| (self.squares / self.count).sqrt())
    }

    /// Variance accounted for, at most 1; none if the reading does not vary.
    pub fn vaf(&self) -> Option<f64> {
        (self.count > 1.0 && self.reading_spread > 0.0)
            .then(|| 1.0 - self.error_spread / self.reading_spread)
    }

    /// Number of readings.
    pub fn count(&self) -> usize {
        self.count as usize
    }
}

/// The fastest growing mode: its rate, and its frequency (0: it does not oscillate).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Growth {
    pub rate_1_s: f64,
    pub omega_rad_s: f64,
}

/// Of a matrix of the bicycle's four states.
pub fn growth(a: &[[f64; 4]; 4]) -> Growth {
    let matrix = nalgebra::Matrix4::from_fn(|i, j| a[i][j]);
    let worst = matrix
        .complex_eigenvalues()
        .iter()
        .copied()
        .reduce(|p, q| if q.re > p.re { q } else { p });
    worst.map_or(
        Growth {
            rate_1_s: 0.0,
            omega_rad_s: 0.0,
        },
        |z| Growth {
            rate_1_s: z.re,
            omega_rad_s: z.im.abs(),
        },
    )
}
