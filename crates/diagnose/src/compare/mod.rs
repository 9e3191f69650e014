//! How far the model is off: prediction of measured rides.
//!
//! The model's state comes from a predictor on past samples only; then it runs free, driven by the
//! measured inputs, for each horizon, and starts again every [`RESTART_S`]. VAF and RMSE of a
//! horizon are over all readings of its runs, from their start to the horizon; the error at the end
//! of the runs stands beside it, and so does the yardstick: holding the last reading.

mod build;
pub(crate) use build::noise_range;
mod kinematics;
mod result;
mod words;

pub use kinematics::{Relation, relations};
pub use result::{ChannelResult, Comparison, HorizonResult, Noise, RideTrace, Trace, Worst};

use crate::data::RideData;
use crate::quantity::Quantity;
use crate::study::{Place, Study};
use build::Problem;
use result::Scores;
use std::collections::BTreeMap;
use twinhub_ident::forecast::{self, Forecast};
use twinhub_ident::{Equations, Levels, NoiseEstimate, Ride, Track, noise};
use twinhub_linear::MotorPair;

/// Horizons of the comparison.
pub const HORIZONS_S: [f64; 3] = [0.1, 0.5, 2.0];
/// The horizon of a `vaf` without one.
pub const MAIN_HORIZON: usize = 1;
/// Free runs start this often.
pub const RESTART_S: f64 = 0.5;
/// A free run is shown for at most so many growth times of the unstable mode.
pub const GROWTH_TIMES: f64 = 3.0;

/// Why rides cannot be compared.
#[non_exhaustive]
#[derive(Debug, thiserror::Error)]
pub enum CompareError {
    #[error(
        "{study}: model = \"multibody\"; accepted: model = \"benchmark\": compare predicts with the benchmark bicycle"
    )]
    Model { study: String },
    #[error(
        "{study}: no [[ride]]; accepted: at least one, for [[modes]] alone cannot be predicted"
    )]
    NoRide { study: String },
    #[error("{place}: found {found}; accepted: {accepted}")]
    Channel {
        place: Place,
        found: String,
        accepted: String,
    },
    #[error(transparent)]
    Bicycle(Box<twinhub_linear::BicycleError>),
    #[error("{place}: {source}")]
    Track {
        place: Place,
        source: twinhub_ident::track::TrackError,
    },
    #[error("{study}: {source}")]
    Noise {
        study: String,
        source: noise::NoiseError,
    },
}

/// Sets the rides against the study's bicycle; `progress` hears what is going on.
pub fn compare(
    study: &Study,
    data: &[RideData],
    mut progress: impl FnMut(&str),
) -> Result<Comparison, CompareError> {
    let name = study.file.display().to_string();
    let Some(bicycle) = &study.bicycle else {
        return Err(CompareError::Model { study: name });
    };
    if data.is_empty() {
        return Err(CompareError::NoRide { study: name });
    }
    let equations = Equations::new(bicycle).map_err(|e| CompareError::Bicycle(Box::new(e)))?;
    let problem = Problem::new(&equations, data)?;
    let tracks = tracks(&equations, data, &problem.rides)?;
    let estimate = fit_noise(&name, &equations, data, &problem, &tracks, &mut progress)?;
    let mut scores: BTreeMap<(Quantity, String), Scores> = BTreeMap::new();
    let mut traces = vec![];
    let mut weighted = (0.0, 0.0);
    for (index, (ride, track)) in problem.rides.iter().zip(&tracks).enumerate() {
        progress(&format!("predicting {}", data[index].spec.file));
        let levels = Levels::new(ride, &estimate.levels);
        let forecasts = forecast::forecast(track, &levels, &HORIZONS_S, RESTART_S);
        for (sensor, channel) in problem.channels[index].iter().enumerate() {
            let spec = &data[index].channels[*channel].spec;
            let score = scores
                .entry((spec.quantity, spec.column.clone()))
                .or_default();
            score.add(track, sensor, &forecasts, levels.sensor[sensor]);
        }
        let (sum, count) = mean_speed(ride, track);
        weighted = (weighted.0 + sum, weighted.1 + count);
        traces.push(trace(
            &data[index],
            track,
            &problem.channels[index],
            &forecasts[MAIN_HORIZON],
        ));
    }
    let mean_speed_m_s = weighted.0 / weighted.1;
    let growth =
        forecast::growth(&equations.closed_loop(&problem.rides[0], mean_speed_m_s, MotorPair::OFF));
    let worst = result::worst_stretch(&traces);
    if let Some(worst) = &worst {
        let index = worst.ride_index;
        let levels = Levels::new(&problem.rides[index], &estimate.levels);
        let longest = if growth.rate_1_s > 0.0 {
            GROWTH_TIMES / growth.rate_1_s
        } else {
            f64::INFINITY
        };
        free_run(
            &mut traces[index],
            &tracks[index],
            &levels,
            worst.start_s,
            longest,
        );
    }
    let relations = data
        .iter()
        .flat_map(|d| kinematics::relations(&equations, d))
        .collect();
    Ok(result::assemble(
        study,
        data,
        scores,
        traces,
        worst,
        growth,
        mean_speed_m_s,
        &estimate,
        &problem.free,
        relations,
    ))
}

fn tracks(
    equations: &Equations,
    data: &[RideData],
    rides: &[Ride],
) -> Result<Vec<Track>, CompareError> {
    let track = |(ride, data): (&Ride, &RideData)| {
        Track::new(equations, ride).map_err(|source| CompareError::Track {
            place: data.spec.place.clone(),
            source,
        })
    };
    rides.iter().zip(data).map(track).collect()
}

/// Noise levels from the windows meant for fitting, or from all if none is.
fn fit_noise(
    study: &str,
    equations: &Equations,
    data: &[RideData],
    problem: &Problem,
    tracks: &[Track],
    progress: &mut impl FnMut(&str),
) -> Result<NoiseEstimate, CompareError> {
    let some = data.iter().any(|d| d.fit_windows().next().is_some());
    let all = data
        .iter()
        .all(|d| d.fit_windows().count() == d.windows.len());
    let rounds = |round: usize| progress(&format!("noise levels, round {}", round + 1));
    let wrap = |source| CompareError::Noise {
        study: study.to_owned(),
        source,
    };
    if all || !some {
        return noise::estimate(&problem.rides, tracks, &problem.ranges, rounds).map_err(wrap);
    }
    let mut rides = problem.rides.clone();
    for (ride, data) in rides.iter_mut().zip(data) {
        ride.windows.retain(|w| {
            data.fit_windows()
                .any(|f| f.start_s == w.start_s && f.end_s == w.end_s)
        });
    }
    let fit = self::tracks(equations, data, &rides)?;
    noise::estimate(&rides, &fit, &problem.ranges, rounds).map_err(wrap)
}

fn mean_speed(ride: &Ride, track: &Track) -> (f64, f64) {
    track.steps.iter().fold((0.0, 0.0), |(sum, time), s| {
        (sum + s.dt_s * ride.speed.at(s.t_s).0, time + s.dt_s)
    })
}

fn trace(data: &RideData, track: &Track, channels: &[usize], forecast: &Forecast) -> RideTrace {
    let of = |(sensor, channel): (usize, &usize)| {
        let spec = &data.channels[*channel].spec;
        let readings = track.readings.iter().filter(|r| r.sensor == sensor);
        let predictions = forecast
            .predictions
            .iter()
            .filter(|p| track.readings[p.reading].sensor == sensor);
        Trace {
            quantity: spec.quantity,
            column: spec.column.clone(),
            measured: readings.map(|r| [r.t_s, r.value]).collect(),
            predicted: predictions
                .map(|p| {
                    [
                        track.readings[p.reading].t_s,
                        p.predicted,
                        track.readings[p.reading].value,
                        p.lead_s,
                    ]
                })
                .collect(),
            free_run: vec![],
        }
    };
    RideTrace {
        ride: data.spec.file.clone(),
        windows_s: data.windows.iter().map(|w| [w.start_s, w.end_s]).collect(),
        channels: channels.iter().enumerate().map(of).collect(),
    }
}

/// One free run from `start_s` (or as soon after as its window has a past), no longer than allowed.
fn free_run(trace: &mut RideTrace, track: &Track, levels: &Levels, start_s: f64, longest_s: f64) {
    let Some(stretch) = track
        .stretches
        .iter()
        .find(|s| s.window.start_s <= start_s + 1e-6 && start_s < s.window.end_s)
    else {
        return;
    };
    let steps = &track.steps[stretch.steps.clone()];
    let from = start_s.max(steps[0].t_s + RESTART_S);
    let origin = stretch.steps.start + steps.partition_point(|s| s.t_s < from - 1e-6);
    let Some(found) = forecast::origins(track, levels, &[origin]).pop() else {
        return;
    };
    let t0 = track.steps[origin].t_s;
    let end = stretch.steps.start + steps.partition_point(|s| s.t_s <= t0 + longest_s);
    found
        .estimate
        .free_run(track, origin + 1..end.max(origin + 1), |reading, value| {
            let reading = &track.readings[reading];
            trace.channels[reading.sensor]
                .free_run
                .push([reading.t_s, value]);
        });
}
