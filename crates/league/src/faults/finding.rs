//! What a fault came to.

use super::ONSET_S;
use super::cases::{Case, What};
use serde::Serialize;
use twinhub_link::fault::Channel;
use twinhub_types::Health;

/// How much larger than that of the healthy ride the pair may be, Nm, if nobody notices: what the
/// schedule itself changes within half a metre per second.
pub const HARMLESS_NM: f32 = 10.0;
/// How fast the pair may be withdrawn without being called a fault's harm, Nm/s: the ramp of a healthy
/// torque path, 2 s from 40 Nm, and a quarter.
pub const WITHDRAWN_NM_S: f32 = 25.0;
/// Over which time the withdrawal is measured, ticks.
const WITHDRAWN_TICKS: usize = 100;
/// Mean torque that counts as out, Nm, and over how many ticks it is taken.
const OUT_NM: f32 = 1.0;
const OUT_TICKS: usize = 20;

/// What a fault came to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// The case.
    pub fault: String,
    /// Rides.
    pub rides: usize,
    /// Promised time to a flag, s.
    pub stated_s: Option<f64>,
    /// Longest time to a flag over the rides that had one, s.
    pub detected_s: Option<f64>,
    /// Rides in which a flag rose after the onset.
    pub detected: usize,
    /// Flags that rose.
    pub flags: Vec<&'static str>,
    /// Largest excess of the commanded pair over the healthy ride's, Nm.
    pub pair_more_nm: f32,
    /// Fastest withdrawal of the pair over a tenth of a second, Nm/s.
    pub withdrawn_nm_s: f32,
    /// Ticks in which a command broke a limit: magnitude, sign, or slew upwards.
    pub limits_broken: u64,
    /// Falls with the fault.
    pub falls: usize,
    /// Falls of the same riders, assisted, without the fault.
    pub falls_healthy: usize,
    /// Falls of the same people who were never assisted.
    pub falls_never_assisted: usize,
    /// `detected`, `harmless` or `open`.
    pub verdict: &'static str,
}

/// What was seen of a ride.
#[derive(Clone, Debug, Default)]
pub(super) struct Seen {
    pub fell: bool,
    /// Front torque that is asked for, by tick, Nm.
    pub front_nm: Vec<f32>,
    /// Front torque that the drive reports, by tick, Nm.
    pub drive_nm: Vec<f32>,
    /// Health bits by tick.
    pub health: Vec<u32>,
    pub limits_broken: u64,
}

/// Compares the rides with the fault to those without.
pub(super) fn finding(case: &Case, rides: &[Seen], healthy: &[Seen], never: usize) -> Finding {
    let onset = (ONSET_S * 1e3) as usize;
    let mut times = Vec::new();
    let mut bits = 0u32;
    let by_drives = matches!(case.what, What::Link(fault) if fault.channel == Channel::ToPlant);
    let (mut pair_more_nm, mut withdrawn_nm_s) = (0.0f32, 0.0f32);
    for (ride, reference) in rides.iter().zip(healthy) {
        let flagged = (onset..ride.health.len()).find(|tick| {
            if by_drives {
                // Out for a while, not for the tick of a wrong answer; the report is noisy.
                let next = &ride.drive_nm[*tick..(*tick + OUT_TICKS).min(ride.drive_nm.len())];
                return next.iter().sum::<f32>().abs() < OUT_NM * next.len() as f32;
            }
            let before = reference.health.get(*tick).copied().unwrap_or(0);
            ride.health[*tick] & !before != 0
        });
        if let Some(tick) = flagged {
            times.push((tick - onset) as f64 * 1e-3);
            bits |= ride.health[tick];
        }
        // What goes wrong after the controller shows at the drive; a tick of it moves nothing, so the
        // mean over a tenth of a second is looked at.
        let (mine, theirs) = if by_drives {
            (smooth(&ride.drive_nm), smooth(&reference.drive_nm))
        } else {
            (ride.front_nm.clone(), reference.front_nm.clone())
        };
        let until = mine.len().min(theirs.len());
        for tick in onset..until {
            pair_more_nm = pair_more_nm.max(mine[tick] - theirs[tick]);
            let lost_nm_s =
                (mine[tick - WITHDRAWN_TICKS] - mine[tick]) / (1e-3 * WITHDRAWN_TICKS as f32);
            withdrawn_nm_s = withdrawn_nm_s.max(lost_nm_s);
        }
    }
    let falls = rides.iter().filter(|r| r.fell).count();
    let falls_healthy = healthy.iter().filter(|r| r.fell).count();
    let detected_s = times.iter().copied().reduce(f64::max);
    let in_time = case
        .stated_s
        .is_some_and(|stated_s| times.len() == rides.len() && times.iter().all(|t| *t <= stated_s));
    let harmless =
        falls <= falls_healthy && pair_more_nm <= HARMLESS_NM && withdrawn_nm_s <= WITHDRAWN_NM_S;
    let raised = Health::from_bits(bits);
    Finding {
        fault: case.name.clone(),
        rides: rides.len(),
        stated_s: case.stated_s,
        detected_s,
        detected: times.len(),
        flags: Health::TABLE
            .iter()
            .filter(|entry| raised.any(entry.flag))
            .map(|entry| entry.code)
            .collect(),
        pair_more_nm,
        withdrawn_nm_s,
        limits_broken: rides.iter().map(|r| r.limits_broken).sum(),
        falls,
        falls_healthy,
        falls_never_assisted: never,
        verdict: if in_time {
            "detected"
        } else if harmless {
            "harmless"
        } else {
            "open"
        },
    }
}

/// Mean over the last tenth of a second.
fn smooth(values: &[f32]) -> Vec<f32> {
    let mut sum = 0.0f64;
    let mut mean = |i: usize, value: &f32| {
        sum += f64::from(*value);
        if let Some(old) = i.checked_sub(WITHDRAWN_TICKS) {
            sum -= f64::from(values[old]);
        }
        (sum / (i + 1).min(WITHDRAWN_TICKS) as f64) as f32
    };
    values.iter().enumerate().map(|(i, v)| mean(i, v)).collect()
}
