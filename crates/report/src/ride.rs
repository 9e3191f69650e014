//! The page of a ride: the same course ridden several times, the first time as reference.

use crate::chart::{Band, Chart, Panel, Series};
use crate::page::{Cells, Page, Tone};
use crate::text::number;

/// Signals of one ride; all as long as `t_s`.
#[derive(Clone, Debug, Default)]
pub struct Signals {
    /// Time, s.
    pub t_s: Vec<f64>,
    /// Roll, rad.
    pub roll_rad: Vec<f64>,
    /// Steer, rad.
    pub steer_rad: Vec<f64>,
    /// Torque of the rider on the handlebar, Nm.
    pub rider_torque_nm: Vec<f64>,
    /// Forward speed, m/s.
    pub speed_m_s: Vec<f64>,
    /// Front brake torque of the motor, Nm.
    pub front_brake_nm: Vec<f64>,
    /// Rear traction torque of the motor, Nm.
    pub rear_traction_nm: Vec<f64>,
}

/// One ride.
#[derive(Clone, Debug, Default)]
pub struct Ride {
    /// What sets it apart: `stabilizer off`.
    pub name: String,
    /// The bicycle fell.
    pub fell: bool,
    /// Root mean square of roll, rad.
    pub roll_rms_rad: f64,
    /// Root mean square of steer, rad.
    pub steer_rms_rad: f64,
    /// Root mean square of the rider's torque, Nm.
    pub rider_effort_rms_nm: f64,
    /// Energy out of the battery, J.
    pub energy_j: f64,
    /// Distance, m.
    pub distance_m: f64,
    /// Ticks ridden.
    pub ticks: u64,
    /// Ticks without an answer of the controller in time.
    pub missed_ticks: u64,
    /// Digest of the log.
    pub digest: String,
    /// The log.
    pub log: String,
    /// Signals.
    pub signals: Signals,
}

impl Ride {
    fn duration_s(&self) -> f64 {
        match (self.signals.t_s.first(), self.signals.t_s.last()) {
            (Some(first), Some(last)) => last - first,
            _ => 0.0,
        }
    }
}

/// A stretch of time that something acted in: a gust, a push.
#[derive(Clone, Debug)]
pub struct Stretch {
    /// Where it begins, s.
    pub from_s: f64,
    /// Where it ends, s.
    pub to_s: f64,
    /// What it is.
    pub name: String,
}

/// What the page of a ride tells.
#[derive(Clone, Debug, Default)]
pub struct RidePage {
    /// Heading: the course.
    pub title: String,
    /// Line below it: bicycle, rider, law.
    pub lead: String,
    /// The rides; the first is the reference.
    pub rides: Vec<Ride>,
    /// Stretches of time to shade.
    pub stretches: Vec<Stretch>,
    /// The tyres of the plant do not slip.
    pub no_slip: bool,
    /// Further remarks.
    pub notes: Vec<String>,
    /// How it was made: version, commit, seed, configuration digest.
    pub provenance: Vec<(String, String)>,
    /// The resolved configuration.
    pub config_text: String,
    /// Commands to try next.
    pub commands: Vec<String>,
}

/// What riding on wheels that cannot slip means for the pair.
pub const NO_SLIP_NOTE: &str = "The tyres of this plant do not slip. Without slip, the motor pair \
acts on the steering only as a centring stiffness that grows with its torque (for front brake \
torque T: T/R·c·(w+c)/w·cos²λ): it trades weave for capsize. Weave becomes stable from a lower \
speed on, and capsize unstable from a lower speed on. How much of this is left on a real tyre \
hangs on the tyre's twisting torque, so this ride shows that the loop works, not how large the \
benefit is.";

/// What riding on tyres means for the pair.
pub const TYRES_NOTE: &str = "The tyres of this plant slip. Straight and upright the motor pair has \
no lateral force of its own: through the tyres it acts as a spring that centres the steering, about \
10 Nm/rad at 80 Nm. A passive spring of that stiffness does the same without energy. Whether the \
pair helps hangs on the tyre's twisting torque: with a tenth of it, the pair makes things worse \
(--set plant.multibody.set.tyre.front.twisting_gain=0.1). How much it helps hangs on the rider: \
one who holds the bars stiffly overrides a steering spring.";

/// Changes below this share are called none.
const SAME: f64 = 0.02;

/// What came out, in a sentence or two: the last ride against the first.
pub fn verdict(rides: &[Ride]) -> (Tone, String) {
    let (Some(reference), Some(ride)) = (rides.first(), rides.last()) else {
        return (Tone::Even, "There was no ride.".into());
    };
    let after = |ride: &Ride| format!("{} s", number(ride.duration_s(), 3));
    if rides.len() == 1 {
        return if ride.fell {
            (
                Tone::Bad,
                format!("The bicycle fell after {} ({}).", after(ride), ride.name),
            )
        } else {
            (
                Tone::Even,
                format!("The bicycle rode all {} ({}).", after(ride), ride.name),
            )
        };
    }
    let (a, b) = (&reference.name, &ride.name);
    match (reference.fell, ride.fell) {
        (true, true) => (
            Tone::Bad,
            format!(
                "The bicycle fell in both rides: after {} ({a}) and after {} ({b}).",
                after(reference),
                after(ride)
            ),
        ),
        (true, false) => (
            Tone::Good,
            format!(
                "The bicycle fell after {} ({a}) and rode all {} ({b}).",
                after(reference),
                after(ride)
            ),
        ),
        (false, true) => (
            Tone::Bad,
            format!(
                "The bicycle rode all {} ({a}) and fell after {} ({b}).",
                after(reference),
                after(ride)
            ),
        ),
        (false, false) => {
            let effort = ride.rider_effort_rms_nm / reference.rider_effort_rms_nm - 1.0;
            let roll = ride.roll_rms_rad / reference.roll_rms_rad - 1.0;
            let better = |change: f64| change < -SAME;
            let worse = |change: f64| change > SAME;
            let tone = match () {
                () if better(effort) && !worse(roll) || better(roll) && !worse(effort) => {
                    Tone::Good
                }
                () if worse(effort) && !better(roll) || worse(roll) && !better(effort) => Tone::Bad,
                () => Tone::Even,
            };
            let sentence = format!(
                "The bicycle stayed up in all rides. With {b}, compared with {a}, the rider's effort was {} ({} against {} Nm rms) and roll was {} ({}° against {}° rms). The motors took {} J out of the battery, {} J more.",
                change(effort, "smaller", "larger"),
                number(ride.rider_effort_rms_nm, 3),
                number(reference.rider_effort_rms_nm, 3),
                change(roll, "smaller", "larger"),
                number(ride.roll_rms_rad.to_degrees(), 3),
                number(reference.roll_rms_rad.to_degrees(), 3),
                number(ride.energy_j, 3),
                number(ride.energy_j - reference.energy_j, 3),
            );
            (tone, sentence)
        }
    }
}

fn change(share: f64, smaller: &str, larger: &str) -> String {
    if !share.is_finite() {
        "not comparable".into()
    } else if share.abs() <= SAME {
        "about the same".into()
    } else {
        let word = if share < 0.0 { smaller } else { larger };
        format!("{} % {word}", number(100.0 * share.abs(), 2))
    }
}

/// The page.
pub fn ride_page(ride: &RidePage) -> String {
    let mut page = Page::new(&ride.title, &ride.lead);
    let (tone, sentence) = verdict(&ride.rides);
    page.verdict(tone, &sentence);
    if ride.no_slip {
        page.note(NO_SLIP_NOTE);
    }
    for note in &ride.notes {
        page.note(note);
    }
    metrics(&mut page, &ride.rides);
    page.section("Signals").picture(&signals(ride));
    page.section("How it was made");
    let mut rows: Vec<Vec<String>> = ride
        .provenance
        .iter()
        .map(|(key, value)| vec![key.clone(), value.clone()])
        .collect();
    for run in &ride.rides {
        rows.push(vec![format!("log, {}", run.name), run.log.clone()]);
        rows.push(vec![format!("digest, {}", run.name), run.digest.clone()]);
    }
    page.table(&[("", Cells::Text), ("", Cells::Code)], &rows);
    if !ride.config_text.is_empty() {
        page.folded("Configuration", &ride.config_text);
    }
    if !ride.commands.is_empty() {
        page.section("Next").code(&ride.commands.join("\n"));
    }
    page.html()
}

fn metrics(page: &mut Page, rides: &[Ride]) {
    type Value = fn(&Ride) -> String;
    let rows: [(&str, &str, Value); 9] = [
        ("Fell", "", |r| if r.fell { "yes" } else { "no" }.into()),
        ("Roll, rms", "°", |r| {
            number(r.roll_rms_rad.to_degrees(), 3)
        }),
        ("Steer, rms", "°", |r| {
            number(r.steer_rms_rad.to_degrees(), 3)
        }),
        ("Rider effort, rms", "Nm", |r| {
            number(r.rider_effort_rms_nm, 3)
        }),
        ("Battery energy", "J", |r| number(r.energy_j, 4)),
        ("Distance", "m", |r| number(r.distance_m, 4)),
        ("Time", "s", |r| number(r.duration_s(), 4)),
        ("Ticks", "", |r| r.ticks.to_string()),
        ("Missed ticks", "", |r| r.missed_ticks.to_string()),
    ];
    let mut columns = vec![("", Cells::Text)];
    columns.extend(rides.iter().map(|run| (run.name.as_str(), Cells::Number)));
    columns.push(("", Cells::Unit));
    let rows: Vec<Vec<String>> = rows
        .iter()
        .map(|(name, unit, value)| {
            let mut cells = vec![(*name).to_string()];
            cells.extend(rides.iter().map(value));
            cells.push((*unit).to_string());
            cells
        })
        .collect();
    page.section("Numbers").table(&columns, &rows);
}

/// Line style of ride `index`: the reference in the second colour, so that the ride that matters
/// has the first.
fn style(index: usize) -> usize {
    match index {
        0 => 1,
        1 => 0,
        other => other,
    }
}

fn signals(page: &RidePage) -> String {
    let degrees = |values: &[f64]| -> Vec<f64> { values.iter().map(|v| v.to_degrees()).collect() };
    let roll: Vec<Vec<f64>> = page
        .rides
        .iter()
        .map(|r| degrees(&r.signals.roll_rad))
        .collect();
    let steer: Vec<Vec<f64>> = page
        .rides
        .iter()
        .map(|r| degrees(&r.signals.steer_rad))
        .collect();
    fn series<'a>(page: &'a RidePage, y: impl Fn(usize) -> &'a [f64]) -> Vec<Series<'a>> {
        let rides = page.rides.iter().enumerate();
        rides
            .map(|(i, ride)| Series {
                name: &ride.name,
                style: style(i),
                x: &ride.signals.t_s,
                y: y(i),
            })
            .collect()
    }
    let panel = |title, unit, series| Panel {
        title,
        unit,
        series,
        levels: Vec::new(),
    };
    let torque_names: Vec<[String; 2]> = page
        .rides
        .iter()
        .map(|r| {
            [
                format!("front brake, {}", r.name),
                format!("rear traction, {}", r.name),
            ]
        })
        .collect();
    let mut torques = Vec::new();
    for (i, ride) in page.rides.iter().enumerate() {
        let s = &ride.signals;
        for (k, y) in [&s.front_brake_nm, &s.rear_traction_nm]
            .into_iter()
            .enumerate()
        {
            // A motor that never did anything would only hide the others.
            if y.iter().any(|v| v.abs() > 0.0) {
                let style = if k == 0 { style(i) } else { 2 + i };
                torques.push(Series {
                    name: &torque_names[i][k],
                    style,
                    x: &s.t_s,
                    y,
                });
            }
        }
    }
    let mut panels = vec![
        panel("Roll", "°", series(page, |i| &roll[i])),
        panel("Steer", "°", series(page, |i| &steer[i])),
        panel(
            "Rider on the handlebar",
            "Nm",
            series(page, |i| &page.rides[i].signals.rider_torque_nm),
        ),
        panel(
            "Speed",
            "m/s",
            series(page, |i| &page.rides[i].signals.speed_m_s),
        ),
    ];
    if !torques.is_empty() {
        panels.push(panel("Motor torques", "Nm", torques));
    }
    let bands = page
        .stretches
        .iter()
        .map(|s| Band {
            from: s.from_s,
            to: s.to_s,
            name: &s.name,
        })
        .collect();
    let chart = Chart {
        title: "Roll, steer, rider torque, speed and motor torques over time",
        panels,
        bands,
        ..Chart::default()
    };
    chart.svg()
}
