//! The table and the page of `twinhub ride`.

use crate::ride::Run;
use anyhow::Context;
use std::path::Path;
use twinhub_log::{PLANT_TRUTH, RIDER_STATE};
use twinhub_plant::disturbance::Disturbance;
use twinhub_report::ride::{self as report, RidePage, Signals, Stretch, ride_page};
use twinhub_sim::Ride;
use twinhub_sim::plant::PlantChoice;

/// The table that ends a ride: at most 12 lines of 80 columns, then what to try next.
pub fn table(ride: &Ride, runs: &[Run]) -> String {
    let m = |f: &dyn Fn(&Run) -> String| -> Vec<String> { runs.iter().map(f).collect() };
    let degrees = |rad: f64| format!("{:.2} deg", rad.to_degrees());
    let rows: [(&str, Vec<String>); 10] = [
        ("stabilizer", m(&|r| if r.on { "on" } else { "off" }.into())),
        (
            "fell",
            m(&|r| if r.outcome.metrics.fell { "yes" } else { "no" }.into()),
        ),
        ("roll rms", m(&|r| degrees(r.outcome.metrics.roll_rms_rad))),
        (
            "steer rms",
            m(&|r| degrees(r.outcome.metrics.steer_rms_rad)),
        ),
        (
            "rider effort rms",
            m(&|r| format!("{:.2} Nm", r.outcome.metrics.rider_effort_rms_nm)),
        ),
        (
            "motor energy",
            m(&|r| format!("{:.0} J", r.outcome.metrics.energy_j)),
        ),
        (
            "ticks, missed",
            m(&|r| {
                format!(
                    "{}, {}",
                    r.outcome.metrics.ticks, r.outcome.metrics.missed_ticks
                )
            }),
        ),
        (
            "real-time factor",
            m(&|r| format!("{:.1}", r.timing.real_time_factor)),
        ),
        (
            "round trip p50, p99",
            m(&|r| {
                let t = &r.timing.round_trip_us;
                format!("{:.2}, {:.2} us", t.p50, t.p99)
            }),
        ),
        (
            "digest",
            m(&|r| {
                r.outcome
                    .digest
                    .get(..24)
                    .unwrap_or(&r.outcome.digest)
                    .to_owned()
            }),
        ),
    ];
    let mut text = format!("{}: {}\n", ride.name, ride.course.about);
    for (name, values) in rows {
        text += &format!("  {name:<20}");
        for value in values {
            text += &format!("{value:>26}");
        }
        text.push('\n');
    }
    text
}

/// How the clock was kept in real time; empty in lockstep.
pub fn punctuality(runs: &[Run]) -> String {
    let mut text = String::new();
    for run in runs {
        let t = &run.timing;
        if t.lateness_us.count == 0 {
            continue;
        }
        let name = if run.on { "on" } else { "off" };
        let rights = t.rights.as_ref().map(ToString::to_string);
        text += &format!(
            "\nstabilizer {name}, real time with {}\n  overruns {}, slipped ticks {}, missed answers {}, late answers {}\n  us                p50      p99    p99.9      max\n",
            rights.unwrap_or_default(),
            t.overruns,
            t.slipped_ticks,
            t.missed_answers,
            t.late_answers
        );
        let c = t.controller.clone().unwrap_or_default();
        for (name, q) in [
            ("lateness", t.lateness_us),
            ("round trip", t.round_trip_us),
            ("wake-up", c.wake_up_us),
            ("compute", c.compute_us),
        ] {
            text += &format!(
                "  {name:<12} {:8.2} {:8.2} {:8.2} {:8.0}\n",
                q.p50, q.p99, q.p999, q.max
            );
        }
        if !c.health.is_empty() {
            text += &format!("  controller's flags: {}\n", c.health.join(", "));
        }
    }
    text
}

/// What to try after a ride.
fn next_commands() -> Vec<String> {
    [
        "twinhub ride --set law=scheduled --set rider=young",
        "twinhub modes --bicycle bulsink2017_bicycle1 --torque-nm 40 --speeds-m-s 0:10:0.5",
        "twinhub compare davis_instrumented_105 --data DIR",
        "twinhub list",
    ]
    .map(str::to_owned)
    .into()
}

/// The lines below the table; a ride without a log has no page.
pub fn footer(page: Option<&Path>) -> String {
    let mut text = "\n".to_owned();
    if let Some(page) = page {
        let dir = page.parent().unwrap_or(Path::new("."));
        text += &format!(
            "report  {}\nlogs    {1}/off.mcap {1}/on.mcap\n",
            page.display(),
            dir.display()
        );
    }
    text += "try\n";
    for command in next_commands() {
        text += &format!("  {command}\n");
    }
    text
}

/// Writes the page.
///
/// # Errors
/// If a log cannot be read back or the file cannot be written.
pub fn write(page: &Path, ride: &Ride, runs: &[Run]) -> anyhow::Result<()> {
    let (version, git_hash) = crate::ride::program();
    let config_text = ride.to_toml();
    let content = RidePage {
        title: format!("Ride: {}", ride.name),
        lead: format!(
            "{} Bicycle {}, rider {}, law {}.",
            ride.course.about, ride.bicycle.name, ride.course.rider, ride.course.law
        ),
        rides: runs.iter().map(one).collect::<anyhow::Result<_>>()?,
        stretches: stretches(ride),
        no_slip: !ride.bicycle.has_tyres(),
        notes: notes(ride),
        provenance: vec![
            ("version".into(), version),
            ("commit".into(), git_hash),
            ("seed".into(), ride.course.seed.to_string()),
            (
                "configuration".into(),
                twinhub_log::digest_text(&config_text),
            ),
            (
                "rider".into(),
                format!("{} ({})", ride.rider.about, ride.rider.source),
            ),
            ("bicycle".into(), ride.bicycle.source.clone()),
        ],
        config_text,
        commands: next_commands(),
    };
    std::fs::write(page, ride_page(&content))
        .with_context(|| format!("{}: cannot be written", page.display()))
}

/// What a reader of the page should know about the plant.
fn notes(ride: &Ride) -> Vec<String> {
    match ride.course.plant {
        PlantChoice::Multibody(_) if ride.bicycle.has_tyres() => vec![report::TYRES_NOTE.into()],
        _ => Vec::new(),
    }
}

/// One ride with its signals, read back from its log.
fn one(run: &Run) -> anyhow::Result<report::Ride> {
    let m = &run.outcome.metrics;
    let mut ride = report::Ride {
        name: format!("stabilizer {}", if run.on { "on" } else { "off" }),
        fell: m.fell,
        roll_rms_rad: m.roll_rms_rad,
        steer_rms_rad: m.steer_rms_rad,
        rider_effort_rms_nm: m.rider_effort_rms_nm,
        energy_j: m.energy_j,
        distance_m: m.distance_m,
        ticks: m.ticks,
        missed_ticks: m.missed_ticks,
        digest: run.outcome.digest.clone(),
        ..report::Ride::default()
    };
    if let Some(path) = &run.outcome.log {
        ride.log = path.display().to_string();
        let log = twinhub_log::read(path)?;
        let truth = |column: &str| log.column(PLANT_TRUTH, column).map(<[f64]>::to_vec);
        ride.signals = Signals {
            t_s: (0..m.ticks)
                .map(|tick| tick as f64 * twinhub_sim::TICK_S)
                .collect(),
            roll_rad: truth("roll_rad")?,
            steer_rad: truth("steer_rad")?,
            rider_torque_nm: log.column(RIDER_STATE, "steer_torque_nm")?.to_vec(),
            speed_m_s: truth("speed_m_s")?,
            front_brake_nm: truth("front_brake_nm")?,
            rear_traction_nm: truth("rear_traction_nm")?,
        };
    }
    Ok(ride)
}

/// The short disturbances of the course, to be shaded.
fn stretches(ride: &Ride) -> Vec<Stretch> {
    ride.course
        .disturbance
        .iter()
        .filter_map(|timed| {
            let length_s = match timed.what {
                Disturbance::Push(d) => d.duration_s,
                Disturbance::HalfSine(d) => d.duration_s,
                Disturbance::Kick(d) => d.duration_s,
                Disturbance::Gust(d) => d.duration_s,
                Disturbance::HandlebarPull(d) => d.duration_s,
                _ => return None,
            };
            let name = timed.what.name().replace('_', " ");
            Some(Stretch {
                from_s: timed.start_s,
                to_s: timed.start_s + length_s,
                name,
            })
        })
        .collect()
}
