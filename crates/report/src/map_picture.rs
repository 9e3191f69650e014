//! Stability over speed and motor torque: a heat map of the largest growth rate, with the lines where
//! oscillations and slow modes turn stable. One SVG without scripts or outside parts.

use crate::axis::{Axis, ticks};
use crate::page::{Page, Tone};
use crate::text::escape;
use std::fmt::Write;

const WIDTH: f64 = 760.0;
const LEFT: f64 = 64.0;
const RIGHT: f64 = 640.0;
const TOP: f64 = 64.0;
const BOTTOM: f64 = 424.0;
const HEIGHT: f64 = 478.0;

/// Bounds of the colours, 1/s, and their colours: green decays, red grows. The first is for what
/// lies below the first bound.
const BOUNDS_1_S: [f64; 11] = [-2.0, -1.0, -0.5, -0.2, -0.1, 0.0, 0.2, 0.5, 1.0, 2.0, 4.0];
const COLOURS: [&str; 12] = [
    "#00441b", "#1b7837", "#41a35a", "#7fc97f", "#b3dfae", "#dcf0d8", "#fde3d4", "#fbc0a3",
    "#f4956f", "#e06648", "#bf3328", "#8c0a1c",
];

const STYLE: &str = "\
.tmap{--ink:#1b1f24;--soft:#5b6470;--paper:#fff;--none:#c9ced6;font:13px system-ui,-apple-system,'Segoe UI',sans-serif}\
@media(prefers-color-scheme:dark){.tmap{--ink:#e8ebef;--soft:#a3adb9;--paper:#14171b;--none:#3b424b}}\
.tmap .paper{fill:var(--paper)}.tmap text{fill:var(--ink)}.tmap .soft{fill:var(--soft)}.tmap .title{font-size:16px;font-weight:600}\
.tmap .frame{fill:none;stroke:var(--soft)}.tmap .none{fill:var(--none)}.tmap .cells{shape-rendering:crispEdges}\
.tmap .line{fill:none;stroke:#000;stroke-width:2;stroke-linejoin:round;stroke-linecap:round}.tmap .slow{stroke-dasharray:7 5}.tmap .key{stroke:var(--ink)}";

/// Growth rates on a grid: one row per torque, one entry per speed; `None` where there is no steady
/// state.
pub type Grid = Vec<Vec<Option<f64>>>;

/// What is drawn.
pub struct MapPicture<'a> {
    /// Heading, for instance the bicycle.
    pub title: &'a str,
    /// Second line.
    pub subtitle: &'a str,
    /// Speeds, ascending, m/s.
    pub speeds_m_s: &'a [f64],
    /// Torques of the pair, ascending, Nm.
    pub torques_nm: &'a [f64],
    /// Largest real part of all lateral modes, 1/s: the colours.
    pub growth_1_s: &'a Grid,
    /// Of the modes that oscillate: a full line where it is zero.
    pub oscillating_1_s: &'a Grid,
    /// Of those that do not: a broken line.
    pub slow_1_s: &'a Grid,
}

/// Half-way between neighbours, and as far beyond the ends.
fn edges(values: &[f64], alone: f64) -> Vec<f64> {
    let n = values.len();
    let Some(&first) = values.first() else {
        return Vec::new();
    };
    if n == 1 {
        return vec![first - alone, first + alone];
    }
    let mut edges: Vec<f64> = values.windows(2).map(|w| 0.5 * (w[0] + w[1])).collect();
    edges.insert(0, values[0] - 0.5 * (values[1] - values[0]));
    edges.push(values[n - 1] + 0.5 * (values[n - 1] - values[n - 2]));
    edges
}

/// Colour of a growth rate.
fn colour(growth: f64) -> usize {
    BOUNDS_1_S.iter().filter(|b| growth > **b).count()
}

/// Segments of the line where a grid passes zero, in grid coordinates (marching squares; a saddle is
/// cut by its mean).
fn zero_line(grid: &Grid) -> Vec<[(f64, f64); 2]> {
    let mut segments = Vec::new();
    for (r, rows) in grid.windows(2).enumerate() {
        for c in 0..rows[0].len().saturating_sub(1) {
            let corners = [rows[0][c], rows[0][c + 1], rows[1][c + 1], rows[1][c]];
            let Some(v) = corners.into_iter().collect::<Option<Vec<f64>>>() else {
                continue;
            };
            let place = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
            let mut cuts = Vec::new();
            for k in 0..4 {
                let (a, b) = (v[k], v[(k + 1) % 4]);
                if (a > 0.0) != (b > 0.0) {
                    let t = a / (a - b);
                    let (p, q) = (place[k], place[(k + 1) % 4]);
                    let at = (p.0 + t * (q.0 - p.0), p.1 + t * (q.1 - p.1));
                    cuts.push((c as f64 + at.0, r as f64 + at.1));
                }
            }
            match cuts[..] {
                [a, b] => segments.push([a, b]),
                [a, b, c, d] => {
                    let middle: f64 = v.iter().sum();
                    if (middle > 0.0) == (v[0] > 0.0) {
                        segments.extend([[a, b], [c, d]]);
                    } else {
                        segments.extend([[d, a], [b, c]]);
                    }
                }
                _ => {}
            }
        }
    }
    segments
}

/// The value at a place between entries.
fn between(values: &[f64], at: f64) -> f64 {
    let k = (at as usize).min(values.len().saturating_sub(2));
    let next = values.get(k + 1).copied().unwrap_or(values[k]);
    values[k] + (at - k as f64) * (next - values[k])
}

impl MapPicture<'_> {
    /// The picture as an `<svg>` element, for a file of its own or inline.
    pub fn svg(&self) -> String {
        let across = edges(self.speeds_m_s, 0.5);
        let up = edges(self.torques_nm, 0.5);
        let range = |e: &[f64]| {
            (
                e.first().copied().unwrap_or(0.0),
                e.last().copied().unwrap_or(1.0),
            )
        };
        let ((x0, x1), (y0, y1)) = (range(&across), range(&up));
        let x = Axis {
            low: x0,
            high: x1,
            from_px: LEFT,
            to_px: RIGHT,
        };
        let y = Axis {
            low: y0,
            high: y1,
            from_px: BOTTOM,
            to_px: TOP,
        };
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"tmap\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"{}\"><style>{STYLE}</style><rect class=\"paper\" width=\"{WIDTH}\" height=\"{HEIGHT}\"/>",
            escape(self.title)
        );
        let _ = write!(
            svg,
            "<text class=\"title\" x=\"{LEFT}\" y=\"26\">{}</text><text class=\"soft\" x=\"{LEFT}\" y=\"46\">{}</text>",
            escape(self.title),
            escape(self.subtitle)
        );
        svg.push_str("<g class=\"cells\">");
        for (r, row) in self.growth_1_s.iter().enumerate() {
            // Neighbours of one colour are one box.
            let class = |c: usize| row[c].map(colour);
            let mut from = 0;
            for c in 0..row.len() {
                if c + 1 < row.len() && class(c + 1) == class(c) {
                    continue;
                }
                let fill = class(c).map_or("class=\"none\"".to_owned(), |k| {
                    format!("fill=\"{}\"", COLOURS[k])
                });
                let (left, right) = (x.at(across[from]), x.at(across[c + 1]));
                let (high, low) = (y.at(up[r + 1]), y.at(up[r]));
                let _ = write!(
                    svg,
                    "<rect {fill} x=\"{left:.1}\" y=\"{high:.1}\" width=\"{:.1}\" height=\"{:.1}\"/>",
                    right - left,
                    low - high
                );
                from = c + 1;
            }
        }
        svg.push_str("</g>");
        for (grid, class) in [(self.oscillating_1_s, "line"), (self.slow_1_s, "line slow")] {
            let mut d = String::new();
            for [a, b] in zero_line(grid) {
                let px = |(c, r): (f64, f64)| {
                    (
                        x.at(between(self.speeds_m_s, c)),
                        y.at(between(self.torques_nm, r)),
                    )
                };
                let (a, b) = (px(a), px(b));
                let _ = write!(d, "M{:.1} {:.1}L{:.1} {:.1}", a.0, a.1, b.0, b.1);
            }
            let _ = write!(svg, "<path class=\"{class}\" d=\"{d}\"/>");
        }
        let _ = write!(
            svg,
            "<rect class=\"frame\" x=\"{LEFT}\" y=\"{TOP}\" width=\"{}\" height=\"{}\"/>",
            RIGHT - LEFT,
            BOTTOM - TOP
        );
        for (value, label) in ticks(x0, x1, 10.0) {
            let _ = write!(
                svg,
                "<text text-anchor=\"middle\" x=\"{:.1}\" y=\"{}\">{label}</text>",
                x.at(value),
                BOTTOM + 18.0
            );
        }
        for (value, label) in ticks(y0, y1, 6.0) {
            let _ = write!(
                svg,
                "<text text-anchor=\"end\" x=\"{}\" y=\"{:.1}\">{label}</text>",
                LEFT - 8.0,
                y.at(value) + 4.0
            );
        }
        let _ = write!(
            svg,
            "<text class=\"soft\" text-anchor=\"middle\" x=\"{}\" y=\"{}\">speed, m/s</text><text class=\"soft\" text-anchor=\"middle\" transform=\"translate(18 {}) rotate(-90)\">torque of the pair, Nm</text>",
            0.5 * (LEFT + RIGHT),
            BOTTOM + 42.0,
            0.5 * (TOP + BOTTOM)
        );
        legend(&mut svg);
        svg.push_str("</svg>");
        svg
    }

    /// The picture on a page of its own, with the result in a sentence.
    pub fn html(&self, sentence: &str) -> String {
        let mut page = Page::new(self.title, self.subtitle);
        page.verdict(Tone::Even, sentence).picture(&self.svg());
        page.note(
            "Colour: largest real part of all lateral modes about straight running at that speed under that torque. Full line: where the modes that oscillate (weave) turn stable; broken line: those that do not (capsize). Where both lines run together in steps nothing turns stable: there two slow modes become one oscillation. Grey: no steady state, the tyres cannot carry the torque.",
        );
        page.html()
    }
}

fn legend(svg: &mut String) {
    let (x, step) = (RIGHT + 16.0, 22.0);
    let _ = write!(
        svg,
        "<text class=\"soft\" x=\"{x}\" y=\"{}\">growth, 1/s</text>",
        TOP + 8.0
    );
    for (k, colour) in COLOURS.iter().rev().enumerate() {
        let y = TOP + 18.0 + step * k as f64;
        let _ = write!(
            svg,
            "<rect x=\"{x}\" y=\"{y}\" width=\"18\" height=\"{step}\" fill=\"{colour}\"/>"
        );
        if let Some(bound) = BOUNDS_1_S.iter().rev().nth(k) {
            let _ = write!(
                svg,
                "<text x=\"{}\" y=\"{}\">{}</text>",
                x + 26.0,
                y + step + 4.0,
                format!("{bound}").replace('-', "\u{2212}")
            );
        }
    }
    let y = TOP + 18.0 + step * COLOURS.len() as f64 + 20.0;
    for (k, (class, what)) in [("line key", "weave"), ("line slow key", "capsize")]
        .into_iter()
        .enumerate()
    {
        let y = y + 20.0 * k as f64;
        let _ = write!(
            svg,
            "<path class=\"{class}\" d=\"M{x} {y}h30\"/><text x=\"{}\" y=\"{}\">{what}</text>",
            x + 38.0,
            y + 4.0
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(growth: &Grid) -> String {
        let other = vec![vec![Some(1.0); 4]; 2];
        MapPicture {
            title: "A & B",
            subtitle: "",
            speeds_m_s: &[1.0, 2.0, 3.0, 4.0],
            torques_nm: &[0.0, 10.0],
            growth_1_s: growth,
            oscillating_1_s: growth,
            slow_1_s: &other,
        }
        .svg()
    }

    #[test]
    fn equal_neighbours_are_one_box_and_gaps_are_grey() {
        let growth = vec![
            vec![Some(0.3), Some(0.3), Some(-0.3), None],
            vec![Some(0.3); 4],
        ];
        let svg = picture(&growth);
        let document = roxmltree::Document::parse(&svg).expect("well formed");
        let cells: Vec<_> = document
            .descendants()
            .find(|n| n.attribute("class") == Some("cells"))
            .expect("cells")
            .children()
            .collect();
        assert_eq!(cells.len(), 4, "{svg}");
        assert_eq!(cells[2].attribute("class"), Some("none"));
        assert_eq!(cells[0].attribute("fill"), Some(COLOURS[colour(0.3)]));
    }

    #[test]
    fn the_line_lies_where_growth_passes_zero() {
        let growth: Grid = (0..3)
            .map(|r| {
                (0..5)
                    .map(|c| Some(f64::from(c) - 1.25 - 0.5 * f64::from(r)))
                    .collect()
            })
            .collect();
        let line = zero_line(&growth);
        assert!(!line.is_empty());
        for (c, r) in line.into_iter().flatten() {
            assert!((c - 1.25 - 0.5 * r).abs() < 1e-12, "{c} {r}");
        }
        assert!(zero_line(&vec![vec![Some(1.0); 3]; 3]).is_empty());
    }

    #[test]
    fn one_speed_and_one_torque_make_a_picture() {
        let growth = vec![vec![Some(-1.0)]];
        let picture = MapPicture {
            title: "one",
            subtitle: "",
            speeds_m_s: &[5.0],
            torques_nm: &[0.0],
            growth_1_s: &growth,
            oscillating_1_s: &growth,
            slow_1_s: &growth,
        };
        assert!(roxmltree::Document::parse(&picture.svg()).is_ok());
        assert!(!picture.svg().contains("NaN") && picture.html("x").contains("<svg"));
    }
}
