//! What: a certificate as a law file: schedule, tube and bicycle for the controller.
//!
//! Source: own.
//!
//! Assumes and ignores: points that lie on the line between their neighbours are left out, since a
//! schedule of the controller has at most sixteen.
//!
//! Checked by: `tests/certificate.rs`; the file is read back and checked before it is given out.

use crate::DesignError;
use crate::certificate::{Certificate, Point};
use crate::check::{in_words, stretches};
use twinhub_control::{
    Bicycle, Certificate as Tube, Config, Law, Limits, Point as LawPoint, Profile, Schedule,
    law::Scheduled,
};

/// How far a point may lie from the line between its neighbours and be left out, Nm.
const LINE_NM: f64 = 0.05;

/// The controller's configuration on `bicycle`, as the bench tells it: no pair at all where nothing is
/// proved.
///
/// # Errors
/// If the schedule needs more points than the controller has.
pub fn config(certificate: &Certificate, bicycle: &Bicycle) -> Result<Config, DesignError> {
    let plan = &certificate.plan;
    let kept = needed(&certificate.schedule);
    let some = kept.iter().any(|p| p.torque_nm > 0.0);
    let largest_nm = kept.iter().map(|p| p.torque_nm).fold(0.0, f64::max);
    let bicycle = *bicycle;
    let (law, tube) = if some {
        let at = |value: fn(&Point) -> f64| -> Result<Schedule, DesignError> {
            let points: Vec<LawPoint> = kept
                .iter()
                .map(|p| LawPoint {
                    speed_m_s: p.speed_m_s as f32,
                    pair_nm: value(p) as f32,
                })
                .collect();
            Schedule::new(&points).map_err(|e| {
                DesignError::Plan(format!(
                    "{e}: fewer speeds, or a less ragged schedule (slope)"
                ))
            })
        };
        let scheduled = Scheduled {
            change_nm_s: 15.0,
            fade_start_rad: 0.15,
            fade_end_rad: 0.40,
            points: at(|p| p.torque_nm)?,
            activity: None,
            trim: None,
        };
        let tube = Tube {
            bicycle,
            friction_ratio: plan.friction_ratio as f32,
            lower: at(|p| if p.torque_nm > 0.0 { p.from_nm } else { 0.0 })?,
            upper: at(|p| if p.torque_nm > 0.0 { p.to_nm } else { 0.0 })?,
        };
        (Law::Scheduled(scheduled), Some(tube))
    } else {
        (Law::Off(twinhub_control::law::Off {}), None)
    };
    let speed = |k: usize| plan.speeds_m_s[k] as f32;
    let config = Config {
        schema_version: twinhub_control::config::SCHEMA_VERSION,
        profile: Profile::Laboratory,
        bicycle,
        limits: Limits {
            torque_max_nm: (largest_nm + plan.half_width_nm).min(100.0) as f32,
            speed_min_m_s: speed(0),
            speed_max_m_s: speed(plan.speeds_m_s.len() - 1),
            ramp_up_nm_s: 20.0,
            ramp_down_s: 2.0,
            friction_assumed_ratio: Some(plan.friction_ratio as f32),
            battery_out_max_w: None,
            battery_in_max_w: None,
            motor_power_max_w: None,
        },
        law,
        certificate: tube,
    };
    config
        .check()
        .map_err(|e| DesignError::Plan(e.to_string()))?;
    Ok(config)
}

/// The points that the controller needs: those that are not on a line, and one zero on either side of
/// a pair.
fn needed(points: &[Point]) -> Vec<Point> {
    let on_line = |a: &Point, p: &Point, b: &Point| {
        let share = (p.speed_m_s - a.speed_m_s) / (b.speed_m_s - a.speed_m_s);
        let line = |x: f64, y: f64| x + share * (y - x);
        let edge = |p: &Point, from: bool| match (p.torque_nm > 0.0, from) {
            (false, _) => 0.0,
            (true, true) => p.from_nm,
            (true, false) => p.to_nm,
        };
        (line(a.torque_nm, b.torque_nm) - p.torque_nm).abs() <= LINE_NM
            && line(edge(a, true), edge(b, true)) >= edge(p, true) - LINE_NM
            && line(edge(a, false), edge(b, false)) <= edge(p, false) + LINE_NM
    };
    let mut kept: Vec<Point> = Vec::new();
    for (k, point) in points.iter().enumerate() {
        let Some(next) = points.get(k + 1) else {
            kept.push(*point);
            break;
        };
        match kept.last() {
            Some(last) if on_line(last, point, next) => {}
            _ => kept.push(*point),
        }
    }
    kept
}

/// The law file: comments, and everything that the controller reads.
///
/// # Errors
/// As [`config`].
pub fn file(certificate: &Certificate, bicycle: &Bicycle) -> Result<String, DesignError> {
    let config = config(certificate, bicycle)?;
    let text = toml::to_string(&config).map_err(|e| DesignError::Plan(e.to_string()))?;
    let plan = &certificate.plan;
    let proved = in_words(&stretches(&certificate.schedule, &certificate.cells));
    let riders: Vec<&str> = plan.riders.iter().map(|e| e.rider.name.as_str()).collect();
    Ok(format!(
        "# Made by twinhub design for {}; riders {}; proved {proved}.\n\
         # Mass {:?}, tyre load {:?}, twisting torque {:?} times. Beside it lies the proof\n\
         # (.certificate.json): twinhub certify checks it without a solver.\n{text}",
        plan.bicycle,
        riders.join(", "),
        plan.uncertainty.mass,
        plan.uncertainty.load,
        plan.uncertainty.twisting,
    ))
}
