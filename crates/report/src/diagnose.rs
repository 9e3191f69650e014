//! The page of a diagnosis: pictures first, then the causes, the gain, what could not be seen and
//! the next experiment.

use crate::chart::{Chart, Panel, Series};
use crate::page::{Cells, Page, Tone};
use crate::text::escape;
use std::fmt::Write as _;

/// One channel over a stretch.
#[derive(Clone, Debug, Default)]
pub struct ChannelTrace {
    pub ride: String,
    pub quantity: String,
    pub t_s: Vec<f64>,
    pub measured: Vec<f64>,
    pub calibrated: Vec<f64>,
    pub extended: Vec<f64>,
}

/// Residual power of one equation, 1 where only noise acts.
#[derive(Clone, Debug, Default)]
pub struct SpectrumPlot {
    pub equation: String,
    pub frequency_hz: Vec<f64>,
    pub before: Vec<f64>,
    pub after: Vec<f64>,
    pub limit: Vec<f64>,
}

/// The torque that has no name.
#[derive(Clone, Debug, Default)]
pub struct LatentPlot {
    pub equation: String,
    pub ride: String,
    pub t_s: Vec<f64>,
    pub torque_nm: Vec<f64>,
    /// Over the quantity with which it goes, if it goes with any.
    pub curve: Option<CurvePlot>,
}

/// Mean torque over a quantity, with 95 % interval.
#[derive(Clone, Debug, Default)]
pub struct CurvePlot {
    pub over: String,
    pub x: Vec<f64>,
    pub torque_nm: Vec<f64>,
    pub low_nm: Vec<f64>,
    pub high_nm: Vec<f64>,
}

/// One refitted candidate.
#[derive(Clone, Debug, Default)]
pub struct CandidateBar {
    pub name: String,
    pub nats: f64,
    /// Half of the 95 % interval.
    pub half_width: f64,
    /// Cannot be told apart from the cause.
    pub bracketed: bool,
}

/// One parameter of one cause.
#[derive(Clone, Debug, Default)]
pub struct CauseRow {
    pub mechanism: String,
    pub state: String,
    pub parameter: String,
    pub value: f64,
    pub ci95: [f64; 2],
    pub set: String,
}

/// One channel and horizon: nominal, calibrated, extended.
#[derive(Clone, Debug, Default)]
pub struct GainRow {
    pub channel: String,
    pub horizon_s: String,
    pub rmse: Option<[f64; 3]>,
    /// Nominal, calibrated, extended, ceiling, at 0.5 s.
    pub vaf: [Option<f64>; 4],
}

/// Everything on the page.
#[derive(Clone, Debug)]
pub struct DiagnosePage {
    pub title: String,
    pub verdict: String,
    pub tone: Tone,
    pub statements: Vec<String>,
    pub traces: Vec<ChannelTrace>,
    pub spectra: Vec<SpectrumPlot>,
    pub latent: Option<LatentPlot>,
    pub candidates: Vec<CandidateBar>,
    pub causes: Vec<CauseRow>,
    pub gains: Vec<GainRow>,
    pub next: Option<String>,
    /// Mechanism, and what of it could not have been seen.
    pub unseen: Vec<[String; 2]>,
    pub details: String,
}

/// The page as HTML.
pub fn diagnose_page(data: &DiagnosePage) -> String {
    let mut page = Page::new(&data.title, "What the model gets wrong about these rides");
    let first = data.statements.first().map_or("", String::as_str);
    page.verdict(data.tone, &format!("{}: {first}", data.verdict));
    for statement in data.statements.iter().skip(1) {
        page.text(statement);
    }
    if !data.traces.is_empty() {
        page.section("Measured against simulated");
        page.note(
            "Each run starts from what was known half a second before; worst held-out stretch.",
        );
        page.picture(&traces(&data.traces));
    }
    if !data.spectra.is_empty() {
        page.section("What is left in each equation");
        page.note("Power of the torque that the model lacks, by frequency; 1 is what noise gives. Of noise alone, 99 % lies below the dashed line.");
        page.picture(&spectra(&data.spectra));
    }
    if let Some(latent) = &data.latent {
        page.section("What has no name");
        page.note(&format!(
            "The {} torque that the model lacks, as the predictor sees it, over the stretch where it is largest ({}).",
            latent.equation, latent.ride
        ));
        page.picture(&force(latent));
        if let Some(curve) = &latent.curve {
            page.note(&format!(
                "Its mean over {}, with 95 % interval. The shape may have a name: a step is friction, a straight line stiffness or damping.",
                curve.over
            ));
            page.picture(&force_curve(curve));
        }
    }
    if !data.candidates.is_empty() {
        page.section("Candidates");
        page.note("Gain in log likelihood on held-out rides (on the fit rides where none was held out), with 95 % interval; those in brackets cannot be told apart.");
        page.picture(&bars(&data.candidates));
    }
    if !data.causes.is_empty() {
        page.section("Causes");
        let rows: Vec<Vec<String>> = data.causes.iter().map(cause).collect();
        page.table(
            &[
                ("cause", Cells::Text),
                ("", Cells::Text),
                ("parameter", Cells::Code),
                ("value", Cells::Number),
                ("95 % interval", Cells::Number),
                ("cannot be told apart from", Cells::Text),
            ],
            &rows,
        );
    }
    if !data.gains.is_empty() {
        page.section("Gain on held-out rides");
        let rows: Vec<Vec<String>> = data.gains.iter().map(gain).collect();
        page.table(
            &[
                ("channel", Cells::Text),
                ("s ahead", Cells::Number),
                ("RMSE nominal", Cells::Number),
                ("calibrated", Cells::Number),
                ("extended", Cells::Number),
                ("VAF nominal", Cells::Number),
                ("calibrated", Cells::Number),
                ("extended", Cells::Number),
                ("noise floor", Cells::Number),
            ],
            &rows,
        );
        page.note("VAF is the one half a second ahead.");
    }
    if let Some(next) = &data.next {
        page.section("Next experiment");
        page.text(next);
    }
    if !data.unseen.is_empty() {
        page.section("What could not be seen");
        page.note("An effect below its limit may be there.");
        let rows: Vec<Vec<String>> = data.unseen.iter().map(|r| r.to_vec()).collect();
        page.table(&[("mechanism", Cells::Text), ("", Cells::Text)], &rows);
    }
    page.folded("Details", &data.details);
    page.html()
}

fn cause(row: &CauseRow) -> Vec<String> {
    vec![
        row.mechanism.clone(),
        row.state.clone(),
        row.parameter.clone(),
        format!("{:.4}", row.value),
        format!("{:.4} to {:.4}", row.ci95[0], row.ci95[1]),
        row.set.clone(),
    ]
}

fn gain(row: &GainRow) -> Vec<String> {
    let number = |x: Option<f64>| x.map_or("-".to_owned(), |x| format!("{x:.3}"));
    let rmse = |i: usize| row.rmse.map_or("-".to_owned(), |r| format!("{:.4}", r[i]));
    let mut cells = vec![row.channel.clone(), row.horizon_s.clone()];
    cells.extend((0..3).map(rmse));
    cells.extend(row.vaf.iter().map(|v| number(*v)));
    cells
}

fn traces(list: &[ChannelTrace]) -> String {
    let panels = list
        .iter()
        .map(|t| Panel {
            title: &t.quantity,
            unit: "",
            series: vec![
                Series {
                    name: "measured",
                    style: 5,
                    x: &t.t_s,
                    y: &t.measured,
                },
                Series {
                    name: "calibrated",
                    style: 1,
                    x: &t.t_s,
                    y: &t.calibrated,
                },
                Series {
                    name: "extended",
                    style: 0,
                    x: &t.t_s,
                    y: &t.extended,
                },
            ],
            levels: vec![],
        })
        .collect();
    Chart {
        title: "Measured and predicted channels",
        panels,
        ..Chart::default()
    }
    .svg()
}

fn spectra(list: &[SpectrumPlot]) -> String {
    let panels = list
        .iter()
        .map(|s| Panel {
            title: &s.equation,
            unit: "power ratio",
            series: vec![
                Series {
                    name: "calibrated",
                    style: 1,
                    x: &s.frequency_hz,
                    y: &s.before,
                },
                Series {
                    name: "extended",
                    style: 0,
                    x: &s.frequency_hz,
                    y: &s.after,
                },
                Series {
                    name: "99 % of noise",
                    style: 2,
                    x: &s.frequency_hz,
                    y: &s.limit,
                },
            ],
            levels: vec![],
        })
        .collect();
    Chart {
        title: "Residual power by equation",
        x_title: "frequency, Hz",
        panels,
        ..Chart::default()
    }
    .svg()
}

fn force(latent: &LatentPlot) -> String {
    Chart {
        title: "Torque that the model lacks",
        panels: vec![Panel {
            title: &latent.equation,
            unit: "Nm",
            series: vec![Series {
                name: "torque",
                style: 0,
                x: &latent.t_s,
                y: &latent.torque_nm,
            }],
            levels: vec![],
        }],
        ..Chart::default()
    }
    .svg()
}

fn force_curve(curve: &CurvePlot) -> String {
    let series = |name, style, y| Series {
        name,
        style,
        x: &curve.x,
        y,
    };
    Chart {
        title: "Mean torque that the model lacks",
        x_title: &curve.over,
        panels: vec![Panel {
            title: "torque",
            unit: "Nm",
            series: vec![
                series("95 % from", 2, &curve.low_nm),
                series("95 % to", 2, &curve.high_nm),
                series("mean", 0, &curve.torque_nm),
            ],
            levels: vec![],
        }],
        ..Chart::default()
    }
    .svg()
}

/// Horizontal bars with intervals.
fn bars(list: &[CandidateBar]) -> String {
    const WIDTH: f64 = 960.0;
    const LEFT: f64 = 260.0;
    const ROW: f64 = 26.0;
    let mut sorted: Vec<&CandidateBar> = list.iter().collect();
    sorted.sort_by(|a, b| b.nats.total_cmp(&a.nats));
    let high = sorted
        .iter()
        .map(|b| b.nats + b.half_width)
        .fold(1.0, f64::max);
    let low = sorted
        .iter()
        .map(|b| b.nats - b.half_width)
        .fold(0.0, f64::min);
    let x = |v: f64| LEFT + (v - low) / (high - low) * (WIDTH - LEFT - 80.0);
    let height = ROW * sorted.len() as f64 + 10.0;
    let mut svg = format!(
        "<svg class=\"tc\" viewBox=\"0 0 {WIDTH} {height}\" role=\"img\"><title>Candidates by held-out gain</title>"
    );
    for (index, bar) in sorted.iter().enumerate() {
        let y = ROW * index as f64 + 18.0;
        let name = if bar.bracketed {
            format!("[ {} ]", bar.name)
        } else {
            bar.name.clone()
        };
        let (a, b) = (x(bar.nats.min(0.0)), x(bar.nats.max(0.0)));
        let _ = write!(
            svg,
            "<text x=\"{:.0}\" y=\"{y:.0}\" text-anchor=\"end\">{}</text>\
             <rect x=\"{a:.1}\" y=\"{:.0}\" width=\"{:.1}\" height=\"12\" fill=\"var(--s{})\" opacity=\".75\"/>\
             <path class=\"zero\" d=\"M{:.1} {:.0}H{:.1}\" stroke=\"currentColor\"/>\
             <text class=\"soft\" x=\"{:.0}\" y=\"{y:.0}\">{:.1}</text>",
            LEFT - 10.0,
            escape(&name),
            y - 11.0,
            (b - a).max(1.0),
            if bar.bracketed { 1 } else { 0 },
            x(bar.nats - bar.half_width),
            y - 5.0,
            x(bar.nats + bar.half_width),
            x(bar.nats + bar.half_width).max(b) + 8.0,
            bar.nats
        );
    }
    svg.push_str("</svg>");
    svg
}
