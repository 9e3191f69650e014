//! The page of a comparison: measured against predicted, the worst stretch, how well by channel
//! and horizon.

use crate::chart::{Band, Chart, Panel, Series};
use crate::page::{Cells, Page, Tone};

/// One output channel of one ride.
#[derive(Clone, Debug, Default)]
pub struct ChannelPlot {
    /// Quantity with its SI unit at the end, as `roll_rate_rad_s`.
    pub quantity: String,
    /// Times and readings, s and SI.
    pub measured: Vec<[f64; 2]>,
    /// Time, prediction, time since the start of its free run.
    pub predicted: Vec<[f64; 3]>,
    /// One longer free run.
    pub free_run: Vec<[f64; 2]>,
}

/// One ride.
#[derive(Clone, Debug, Default)]
pub struct RidePlot {
    pub name: String,
    pub channels: Vec<ChannelPlot>,
    /// Stretch to zoom into, s.
    pub worst_s: Option<[f64; 2]>,
}

/// One row of the table.
#[derive(Clone, Debug, Default)]
pub struct ScoreRow {
    pub channel: String,
    pub horizon_s: String,
    /// None: no window is longer than the horizon.
    pub vaf: Option<f64>,
    pub rmse: Option<f64>,
    pub rmse_at_end: Option<f64>,
    pub held_vaf: Option<f64>,
    pub held_rmse: Option<f64>,
}

/// Everything on the page.
#[derive(Clone, Debug, Default)]
pub struct ComparePage {
    pub title: String,
    pub lead: String,
    /// How wrong the model is; the first is the verdict.
    pub statements: Vec<String>,
    pub rides: Vec<RidePlot>,
    pub scores: Vec<ScoreRow>,
    /// What was seen in the data and what was done about it.
    pub findings: Vec<String>,
    /// Channel against channel: relation, slope, correlation.
    pub relations: Vec<[String; 3]>,
    /// The study and its noise levels as text.
    pub details: String,
}

/// Degrees on paper, radians elsewhere.
fn unit(quantity: &str) -> (String, &'static str, f64) {
    let endings = [
        ("_rad_s", "deg/s", 180.0 / std::f64::consts::PI),
        ("_rad", "deg", 180.0 / std::f64::consts::PI),
        ("_m_s2", "m/s²", 1.0),
        ("_m_s", "m/s", 1.0),
    ];
    let base = quantity.split(' ').next().unwrap_or(quantity);
    for (ending, unit, scale) in endings {
        if let Some(stem) = base.strip_suffix(ending) {
            return (
                format!("{}{}", stem.replace('_', " "), &quantity[base.len()..]),
                unit,
                scale,
            );
        }
    }
    (quantity.to_owned(), "", 1.0)
}

/// Columns of one line, thinned to what a screen can show; gaps where a free run starts.
struct Line {
    x: Vec<f64>,
    y: Vec<f64>,
}

impl Line {
    fn new(points: impl Iterator<Item = (f64, f64, bool)>, scale: f64) -> Self {
        let mut line = Self {
            x: vec![],
            y: vec![],
        };
        for (t, value, begins) in points {
            if begins && !line.x.is_empty() {
                line.x.push(t);
                line.y.push(f64::NAN);
            }
            line.x.push(t);
            line.y.push(value * scale);
        }
        line
    }
}

fn figure(ride: &RidePlot, range: Option<(f64, f64)>, title: &str) -> String {
    let inside = |t: f64| range.is_none_or(|(a, b)| (a..=b).contains(&t));
    let lines: Vec<(String, &str, [Line; 3])> = ride
        .channels
        .iter()
        .map(|channel| {
            let (name, unit, scale) = unit(&channel.quantity);
            let mut before = f64::INFINITY;
            let predicted = channel.predicted.iter().filter(|p| inside(p[0])).map(|p| {
                let begins = p[2] < before;
                before = p[2];
                (p[0], p[1], begins)
            });
            let predicted = Line::new(predicted, scale);
            // A break in time is a break in the line.
            let mut last = f64::NEG_INFINITY;
            let measured = channel.measured.iter().filter(|m| inside(m[0])).map(|m| {
                let begins = m[0] - last > 0.3;
                last = m[0];
                (m[0], m[1], begins)
            });
            let measured = Line::new(measured, scale);
            let free = channel
                .free_run
                .iter()
                .filter(|m| inside(m[0]) && range.is_some());
            let free = Line::new(free.map(|m| (m[0], m[1], false)), scale);
            (name, unit, [measured, predicted, free])
        })
        .collect();
    let names = [
        "measured",
        "predicted, up to 0.5 s ahead",
        "one longer free run",
    ];
    let panels = lines.iter().map(|(name, unit, lines)| Panel {
        title: name,
        unit,
        series: lines
            .iter()
            .zip(names)
            .enumerate()
            .filter(|(_, (line, _))| !line.x.is_empty())
            .map(|(style, (line, name))| Series {
                name,
                style,
                x: &line.x,
                y: &line.y,
            })
            .collect(),
        levels: vec![],
    });
    let bands = match (range, ride.worst_s) {
        (None, Some([from, to])) => vec![Band {
            from,
            to,
            name: "worst",
        }],
        _ => vec![],
    };
    Chart {
        title,
        x_range: range,
        panels: panels.collect(),
        bands,
        panel_height_px: 150.0,
        ..Chart::default()
    }
    .svg()
}

/// The page as HTML.
pub fn compare_page(content: &ComparePage) -> String {
    let mut page = Page::new(&content.title, &content.lead);
    for (index, statement) in content.statements.iter().enumerate() {
        match index {
            0 => page.verdict(Tone::Even, statement),
            _ => page.text(statement),
        };
    }
    page.section("How well it predicts");
    page.note(
        "The state comes from a predictor on past samples only; then the model runs free, driven by the measured \
         inputs, up to the horizon, and starts again every 0.5 s. VAF: share of the variance explained, over all \
         readings of the runs; it falls below zero where the error varies more than the signal. Held: the last \
         reading before the run, kept.",
    );
    let columns = [
        ("channel", Cells::Text),
        ("horizon, s", Cells::Number),
        ("VAF", Cells::Number),
        ("RMSE", Cells::Number),
        ("at the end", Cells::Number),
        ("VAF held", Cells::Number),
        ("RMSE held", Cells::Number),
        ("", Cells::Unit),
    ];
    let rows: Vec<Vec<String>> = content
        .scores
        .iter()
        .map(|s| {
            let (name, unit, scale) = unit(&s.channel);
            let share = |x: Option<f64>| x.map_or("-".to_owned(), |x| format!("{x:.2}"));
            let size = |x: Option<f64>| x.map_or("-".to_owned(), |x| format!("{:.3}", x * scale));
            let (vaf, held) = (share(s.vaf), share(s.held_vaf));
            vec![
                name,
                s.horizon_s.clone(),
                vaf,
                size(s.rmse),
                size(s.rmse_at_end),
                held,
                size(s.held_rmse),
                unit.to_owned(),
            ]
        })
        .collect();
    page.table(&columns, &rows);
    for ride in &content.rides {
        if let Some([from, to]) = ride.worst_s {
            page.section(&format!(
                "Worst stretch: {from:.2} to {to:.2} s of {}",
                ride.name
            ));
            page.picture(&figure(
                ride,
                Some((from, to)),
                "Measured and predicted in the worst stretch",
            ));
        }
    }
    for ride in &content.rides {
        page.section(&format!("Measured against predicted: {}", ride.name));
        page.picture(&figure(
            ride,
            None,
            "Measured and predicted over the whole ride",
        ));
    }
    if !content.relations.is_empty() {
        page.section("Channel against channel");
        page.note("Without any dynamics: a slope near one and a correlation near one say that signs, units and axes fit.");
        let columns = [
            ("relation", Cells::Text),
            ("slope", Cells::Number),
            ("correlation", Cells::Number),
        ];
        page.table(
            &columns,
            &content
                .relations
                .iter()
                .map(|r| r.to_vec())
                .collect::<Vec<_>>(),
        );
    }
    if !content.findings.is_empty() {
        page.section("Seen in the data");
        for finding in &content.findings {
            page.note(finding);
        }
    }
    page.folded("Noise levels and study", &content.details);
    page.html()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn page_shows_every_channel_and_breaks_between_runs() {
        let channel = ChannelPlot {
            quantity: "roll_rate_rad_s".into(),
            measured: (0..100).map(|k| [0.05 * f64::from(k), 0.1]).collect(),
            predicted: (1..100)
                .map(|k| [0.05 * f64::from(k), 0.2, 0.05 * f64::from(k % 10 + 1)])
                .collect(),
            free_run: vec![[1.0, 0.3], [1.5, 0.4]],
        };
        let ride = RidePlot {
            name: "a & b".into(),
            channels: vec![channel.clone()],
            worst_s: Some([1.0, 3.0]),
        };
        let row = ScoreRow {
            channel: "roll_rate_rad_s".into(),
            horizon_s: "2".into(),
            ..ScoreRow::default()
        };
        let content = ComparePage {
            title: "t".into(),
            statements: vec!["wrong by <half>".into()],
            rides: vec![ride],
            scores: vec![row],
            ..ComparePage::default()
        };
        let html = compare_page(&content);
        for text in [
            "roll rate",
            "deg/s",
            "wrong by &lt;half&gt;",
            "a &amp; b",
            "1.00 to 3.00 s",
            "one longer free run",
        ] {
            assert!(html.contains(text), "{text}");
        }
        assert!(!html.contains("NaN"));
        // Ten runs: nine gaps.
        let mut before = f64::INFINITY;
        let points = channel.predicted.iter().map(|p| {
            let begins = p[2] < before;
            before = p[2];
            (p[0], p[1], begins)
        });
        let line = Line::new(points, 1.0);
        assert_eq!(line.y.iter().filter(|y| y.is_nan()).count(), 9);
    }
}
