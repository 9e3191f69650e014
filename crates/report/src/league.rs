//! The page of a league: benefit against energy, the table, and whether anybody is harmed.

use std::fmt::Write as _;

use crate::axis::{Axis, extent, roomy, ticks};
use crate::chart::STYLE;
use crate::page::{Cells, Page, Tone};
use crate::text::escape;

/// A controller in the picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Dot {
    /// The controller.
    pub name: String,
    /// Energy, Wh/km.
    pub energy_wh_per_km: f64,
    /// Effort saved against riding without, Nm.
    pub effort_saved_nm: f64,
    /// No other controller saves as much for less.
    pub on_frontier: bool,
}

/// Everything on the page.
#[derive(Clone, Debug, Default)]
pub struct LeaguePage {
    /// A line below the heading.
    pub lead: String,
    /// Nobody is harmed: what the verdict says.
    pub good: bool,
    /// The result in a sentence.
    pub sentence: String,
    /// The picture's controllers.
    pub dots: Vec<Dot>,
    /// Headings of the table.
    pub columns: Vec<String>,
    /// The table: controller, riders, numbers.
    pub rows: Vec<Vec<String>>,
    /// Shares of the reference: controller, effort, falls, energy.
    pub shares: Vec<[String; 4]>,
    /// Cells that are worse or undecided: controller, riders, speeds, surface, rides, falls without
    /// and with, interval, verdict.
    pub cells: Vec<[String; 9]>,
    /// How many cells are no worse, worse, undecided.
    pub counts: [usize; 3],
    /// Remarks.
    pub notes: Vec<String>,
}

const WIDTH: f64 = 760.0;
const HEIGHT: f64 = 420.0;
const LEFT: f64 = 64.0;
const RIGHT: f64 = 740.0;
const TOP: f64 = 20.0;
const BOTTOM: f64 = 366.0;

/// Effort saved against energy, a dot for each controller; the frontier joined by a line.
pub fn frontier_svg(dots: &[Dot], style: bool) -> String {
    let energies: Vec<f64> = dots
        .iter()
        .map(|d| d.energy_wh_per_km)
        .chain([0.0])
        .collect();
    let saved: Vec<f64> = dots
        .iter()
        .map(|d| d.effort_saved_nm)
        .chain([0.0])
        .collect();
    let axis = |values: &[f64], from_px, to_px| {
        let (low, high) = roomy(extent(values).unwrap_or((0.0, 1.0)));
        Axis {
            low,
            high: if high > low { high } else { low + 1.0 },
            from_px,
            to_px,
        }
    };
    let (x, y) = (axis(&energies, LEFT, RIGHT), axis(&saved, BOTTOM, TOP));
    let mut svg = format!(
        "<svg class=\"tc\" xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" \
         width=\"{WIDTH}\" height=\"{HEIGHT}\" role=\"img\"><title>Effort saved against energy, a dot for \
         each controller</title>"
    );
    if style {
        let _ = write!(svg, "<style>{STYLE}</style>");
    }
    let _ = write!(
        svg,
        "<rect class=\"paper\" width=\"{WIDTH}\" height=\"{HEIGHT}\"/>"
    );
    for (value, label) in ticks(x.low, x.high, 8.0) {
        let at = x.at(value);
        let _ = write!(
            svg,
            "<line class=\"grid\" x1=\"{at:.1}\" x2=\"{at:.1}\" y1=\"{TOP}\" y2=\"{BOTTOM}\"/>\
             <text class=\"soft\" text-anchor=\"middle\" x=\"{at:.1}\" y=\"{:.1}\">{label}</text>",
            BOTTOM + 16.0
        );
    }
    for (value, label) in ticks(y.low, y.high, 6.0) {
        let at = y.at(value);
        let _ = write!(
            svg,
            "<line class=\"{}\" x1=\"{LEFT}\" x2=\"{RIGHT}\" y1=\"{at:.1}\" y2=\"{at:.1}\"/>\
             <text class=\"soft\" text-anchor=\"end\" x=\"{:.1}\" y=\"{:.1}\">{label}</text>",
            if value == 0.0 { "zero" } else { "grid" },
            LEFT - 6.0,
            at + 4.0
        );
    }
    let _ = write!(
        svg,
        "<text text-anchor=\"middle\" x=\"{:.1}\" y=\"{:.1}\">energy, net from the battery, Wh/km</text>\
         <text text-anchor=\"middle\" transform=\"translate(16 {:.1}) rotate(-90)\">less steering effort than \
         without, Nm</text>",
        0.5 * (LEFT + RIGHT),
        HEIGHT - 12.0,
        0.5 * (TOP + BOTTOM)
    );
    let mut front: Vec<&Dot> = dots.iter().filter(|d| d.on_frontier).collect();
    front.sort_by(|a, b| a.energy_wh_per_km.total_cmp(&b.energy_wh_per_km));
    let points: Vec<String> = front
        .iter()
        .map(|d| {
            format!(
                "{:.1},{:.1}",
                x.at(d.energy_wh_per_km),
                y.at(d.effort_saved_nm)
            )
        })
        .collect();
    let _ = write!(
        svg,
        "<polyline class=\"s s5\" points=\"{}\"/>",
        points.join(" ")
    );
    // Labels from the top down, each at least a line below the one before.
    let mut order: Vec<&Dot> = dots.iter().collect();
    order.sort_by(|a, b| b.effort_saved_nm.total_cmp(&a.effort_saved_nm));
    let mut taken: Vec<(f64, f64)> = Vec::new();
    for dot in order {
        let (cx, cy) = (x.at(dot.energy_wh_per_km), y.at(dot.effort_saved_nm));
        let mut label_y = cy + 4.0;
        while taken
            .iter()
            .any(|(tx, ty)| (tx - cx).abs() < 150.0 && (ty - label_y).abs() < 13.0)
        {
            label_y += 4.0;
        }
        taken.push((cx, label_y));
        let right = cx > RIGHT - 150.0;
        let (anchor, dx) = if right { ("end", -9.0) } else { ("start", 9.0) };
        let style = if dot.on_frontier { "0" } else { "1" };
        let _ = write!(
            svg,
            "<circle cx=\"{cx:.1}\" cy=\"{cy:.1}\" r=\"5\" style=\"fill:var(--s{style})\"/>\
             <text text-anchor=\"{anchor}\" x=\"{:.1}\" y=\"{label_y:.1}\">{}</text>",
            cx + dx,
            escape(&dot.name)
        );
    }
    svg.push_str("</svg>");
    svg
}

/// The page as HTML.
pub fn league_page(content: &LeaguePage) -> String {
    let mut page = Page::new("League: does it help?", &content.lead);
    let tone = if content.good { Tone::Good } else { Tone::Bad };
    page.verdict(tone, &content.sentence);
    if content.dots.len() > 1 {
        page.section("Benefit against energy");
        page.picture(&frontier_svg(&content.dots, false));
        page.note(
            "Riders who give torque. Blue: no other controller saves as much effort for less energy.",
        );
    }
    if !content.shares.is_empty() {
        page.section("Measured in the largest constant pair");
        let columns = [
            ("controller", Cells::Text),
            ("effort saved, share", Cells::Number),
            ("falls saved, share", Cells::Number),
            ("energy, share", Cells::Number),
        ];
        let rows: Vec<Vec<String>> = content.shares.iter().map(|r| r.to_vec()).collect();
        page.table(&columns, &rows);
    }
    page.section("Every controller, every class of riders");
    let columns: Vec<(&str, Cells)> = content
        .columns
        .iter()
        .enumerate()
        .map(|(i, name)| {
            (
                name.as_str(),
                if i < 2 { Cells::Text } else { Cells::Number },
            )
        })
        .collect();
    page.table(&columns, &content.rows);
    for note in &content.notes {
        page.note(note);
    }
    page.section("Is anybody harmed?");
    let [no_worse, worse, undecided] = content.counts;
    page.text(&format!(
        "Class by class, speed by speed, surface by surface, on the same riders and courses: {no_worse} cells \
         are no worse than without a stabilizer, {worse} are worse, {undecided} have too few rides to tell."
    ));
    if !content.cells.is_empty() {
        let columns = [
            ("controller", Cells::Text),
            ("riders", Cells::Text),
            ("speed, m/s", Cells::Number),
            ("surface", Cells::Text),
            ("rides", Cells::Number),
            ("falls without", Cells::Number),
            ("falls with", Cells::Number),
            ("difference of shares", Cells::Number),
            ("verdict", Cells::Text),
        ];
        let rows: Vec<Vec<String>> = content.cells.iter().map(|r| r.to_vec()).collect();
        page.table(&columns, &rows);
    }
    page.html()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_is_well_formed_and_shows_every_controller() {
        let dot = |name: &str, energy, saved, on_frontier| Dot {
            name: name.into(),
            energy_wh_per_km: energy,
            effort_saved_nm: saved,
            on_frontier,
        };
        let content = LeaguePage {
            good: false,
            sentence: "one cell is worse".into(),
            dots: vec![
                dot("off", 0.0, 0.0, true),
                dot("<mine>", 10.0, 0.4, true),
                dot("dear", 20.0, 0.4, false),
            ],
            columns: ["controller", "riders", "falls"]
                .map(str::to_owned)
                .to_vec(),
            rows: vec![["off", "older", "3"].map(str::to_owned).to_vec()],
            counts: [10, 1, 2],
            ..LeaguePage::default()
        };
        let html = league_page(&content);
        assert!(html.contains("&lt;mine&gt;") && html.contains("1 are worse"));
        let body = html.split_once('\n').map_or("", |p| p.1);
        assert!(roxmltree::Document::parse(body).is_ok());
        assert_eq!(
            frontier_svg(&content.dots, true).matches("<circle").count(),
            3
        );
        // Nothing that cannot be drawn.
        assert!(!frontier_svg(&[], true).contains("NaN"));
    }
}
