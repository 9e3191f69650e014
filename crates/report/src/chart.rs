//! Line charts: panels above each other with one x axis.

use std::fmt::Write as _;

use crate::axis::{Axis, extent, roomy, snapped, ticks};
use crate::line;
use crate::text::escape;

/// Colours and lines; goes into the page once, or into the picture with
/// [`standalone`](Chart::standalone).
pub const STYLE: &str = "\
.tc{--ink:#1b1f24;--soft:#5b6470;--grid:#e6e9ee;--paper:#fff;--band:#8a94a3;--s0:#0072b2;--s1:#d55e00;--s2:#009e73;--s3:#a0569a;--s4:#b07d00;--s5:#5b6470;font:12px system-ui,-apple-system,'Segoe UI',Roboto,sans-serif;font-variant-numeric:tabular-nums;max-width:100%;height:auto;display:block}\
@media(prefers-color-scheme:dark){.tc{--ink:#e8ebef;--soft:#a3adb9;--grid:#2b3038;--paper:#14171b;--band:#8a94a3;--s0:#5cb8f2;--s1:#f59a52;--s2:#43c79b;--s3:#dd9fd6;--s4:#e8c04a;--s5:#a3adb9}}\
@media print{.tc{--ink:#000;--soft:#444;--grid:#ddd;--paper:#fff;--s0:#0072b2;--s1:#d55e00;--s2:#009e73;--s3:#a0569a;--s4:#b07d00;--s5:#5b6470}}\
.tc text{fill:var(--ink)}.tc .soft{fill:var(--soft)}.tc .head{font-size:13px;font-weight:600}\
.tc .paper{fill:var(--paper)}.tc .grid{stroke:var(--grid)}.tc .zero{stroke:var(--soft);stroke-width:.8}.tc .frame{fill:none;stroke:var(--grid)}\
.tc .band{fill:var(--band);opacity:.16}.tc .level{stroke:var(--soft);stroke-dasharray:3 3}\
.tc .s{fill:none;stroke-width:1.5;stroke-linejoin:round;stroke-linecap:round}\
.tc .s0{stroke:var(--s0)}.tc .s1{stroke:var(--s1)}.tc .s2{stroke:var(--s2);stroke-dasharray:7 4}.tc .s3{stroke:var(--s3);stroke-dasharray:2 4}.tc .s4{stroke:var(--s4);stroke-dasharray:9 3 2 3}.tc .s5{stroke:var(--s5)}";

/// Number of line styles; each has a colour that colour-blind readers can tell from the others
/// (Okabe and Ito), and from the third on a dash pattern of its own.
pub const STYLES: usize = 6;

/// One line.
#[derive(Clone, Copy, Debug)]
pub struct Series<'a> {
    /// Name in the legend.
    pub name: &'a str,
    /// Line style, below [`STYLES`]; the same run or quantity has the same style everywhere.
    pub style: usize,
    /// x values, rising.
    pub x: &'a [f64],
    /// y values; NaN is a gap.
    pub y: &'a [f64],
}

/// A horizontal line: a limit.
#[derive(Clone, Copy, Debug)]
pub struct Level<'a> {
    /// Where.
    pub value: f64,
    /// What it is.
    pub name: &'a str,
}

/// A shaded stretch of the x axis, in all panels.
#[derive(Clone, Copy, Debug)]
pub struct Band<'a> {
    /// Where it begins.
    pub from: f64,
    /// Where it ends.
    pub to: f64,
    /// What it is; written above it if there is room, else shown when pointed at.
    pub name: &'a str,
}

/// One panel.
#[derive(Clone, Debug, Default)]
pub struct Panel<'a> {
    /// Quantity.
    pub title: &'a str,
    /// Its unit.
    pub unit: &'a str,
    /// Lines, the first at the back.
    pub series: Vec<Series<'a>>,
    /// Limits.
    pub levels: Vec<Level<'a>>,
}

/// Panels above each other with one x axis.
#[derive(Clone, Debug)]
pub struct Chart<'a> {
    /// What it shows, for readers who cannot see it.
    pub title: &'a str,
    /// Name and unit of the x axis.
    pub x_title: &'a str,
    /// Range of the x axis; that of the data if `None`.
    pub x_range: Option<(f64, f64)>,
    /// The panels from top to bottom.
    pub panels: Vec<Panel<'a>>,
    /// Shaded stretches.
    pub bands: Vec<Band<'a>>,
    /// Height of the lines of one panel, px.
    pub panel_height_px: f64,
}

impl Default for Chart<'_> {
    fn default() -> Self {
        Self {
            title: "",
            x_title: "time, s",
            x_range: None,
            panels: Vec::new(),
            bands: Vec::new(),
            panel_height_px: 130.0,
        }
    }
}

const WIDTH: f64 = 960.0;
const LEFT: f64 = 62.0;
const RIGHT: f64 = WIDTH - 16.0;
/// Title and legend of a panel.
const HEAD: f64 = 20.0;
const LINE: f64 = 16.0;
const GAP: f64 = 16.0;
const FOOT: f64 = 42.0;
/// Length of the sample in the legend, with the space after it.
const SAMPLE: f64 = 28.0;

/// Width that text of the legend takes at most, px: wide enough for every font in the list.
fn text_px(text: &str) -> f64 {
    7.2 * text.chars().count() as f64
}

/// Where a legend entry stands: line of the head, x.
struct Entry<'a> {
    row: usize,
    x: f64,
    name: &'a str,
    style: Option<usize>,
}

impl Panel<'_> {
    /// Legend entries to the right of the title, on as many lines as they need.
    fn legend(&self) -> Vec<Entry<'_>> {
        let begin = LEFT + text_px(self.title) * 1.15 + text_px(self.unit) + 40.0;
        let names = self.series.iter().map(|s| (s.name, Some(s.style % STYLES)));
        let mut entries: Vec<Entry<'_>> = Vec::new();
        let (mut row, mut x) = (0, begin);
        for (name, style) in names.chain(self.levels.iter().map(|l| (l.name, None))) {
            if name.is_empty() || entries.iter().any(|e| e.name == name && e.style == style) {
                continue;
            }
            let width = SAMPLE + text_px(name) + 14.0;
            if x + width > RIGHT && x > begin {
                (row, x) = (row + 1, begin);
            }
            entries.push(Entry {
                row,
                x,
                name,
                style,
            });
            x += width;
        }
        entries
    }

    fn range(&self, x: &Axis) -> Option<(f64, f64)> {
        let seen = self.series.iter().flat_map(|s| {
            s.x.iter()
                .zip(s.y)
                .filter(|(t, _)| (x.low..=x.high).contains(*t))
                .map(|(_, v)| v)
        });
        extent(seen.chain(self.levels.iter().map(|level| &level.value)))
    }
}

impl Chart<'_> {
    /// The chart as an `<svg>` element for a page that has [`STYLE`].
    pub fn svg(&self) -> String {
        self.draw("")
    }

    /// The chart as a picture of its own.
    pub fn standalone(&self) -> String {
        self.draw(&format!("<style>{STYLE}</style>"))
    }

    fn x_axis(&self) -> Axis {
        let series = self.panels.iter().flat_map(|panel| &panel.series);
        let data = || extent(series.clone().flat_map(|s| s.x));
        let (low, high) = self
            .x_range
            .filter(|(low, high)| low < high && (high - low).is_finite())
            .or_else(|| {
                data()
                    .filter(|(low, high)| low < high)
                    .map(|range| snapped(range, 10.0))
            })
            .unwrap_or((0.0, 1.0));
        Axis {
            low,
            high,
            from_px: LEFT,
            to_px: RIGHT,
        }
    }

    fn draw(&self, style: &str) -> String {
        let x = self.x_axis();
        let named = self.bands.iter().any(|band| !band.name.is_empty());
        let mut body = String::new();
        let mut top = if named { 20.0 } else { 4.0 };
        if named {
            self.name_bands(&mut body, &x);
        }
        for panel in &self.panels {
            let legend = panel.legend();
            let rows = legend.iter().map(|entry| entry.row).max().unwrap_or(0);
            let lines_top = top + HEAD + LINE * rows as f64;
            let lines_bottom = lines_top + self.panel_height_px;
            draw_head(&mut body, panel, &legend, top);
            self.draw_panel(&mut body, panel, &x, (lines_top, lines_bottom));
            top = lines_bottom + GAP;
        }
        let bottom = (top - GAP).max(0.0);
        for (value, label) in ticks(x.low, x.high, 10.0) {
            let (px, y) = (x.at(value), bottom + 16.0);
            let _ = write!(
                body,
                "<text class=\"soft\" x=\"{px:.1}\" y=\"{y:.1}\" text-anchor=\"middle\">{label}</text>"
            );
        }
        let (middle, y) = (0.5 * (LEFT + RIGHT), bottom + 34.0);
        let _ = write!(
            body,
            "<text x=\"{middle}\" y=\"{y:.1}\" text-anchor=\"middle\">{}</text>",
            escape(self.x_title)
        );
        let height = (bottom + FOOT).ceil();
        format!(
            "<svg class=\"tc\" xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height}\" \
             width=\"{WIDTH}\" height=\"{height}\" role=\"img\"><title>{}</title>{style}\
             <rect class=\"paper\" width=\"{WIDTH}\" height=\"{height}\"/>{body}</svg>\n",
            escape(self.title)
        )
    }

    /// Names above the bands, where they do not run into each other.
    fn name_bands(&self, body: &mut String, x: &Axis) {
        let mut free_from = LEFT;
        for band in &self.bands {
            let Some((from, to)) = clip(band, x) else {
                continue;
            };
            let middle = 0.5 * (from + to);
            let half = 0.5 * text_px(band.name);
            let at = middle.clamp(LEFT + half, (RIGHT - half).max(LEFT + half));
            if band.name.is_empty() || at - half < free_from {
                continue;
            }
            free_from = at + half + 8.0;
            let _ = write!(
                body,
                "<text class=\"soft\" x=\"{at:.1}\" y=\"14\" text-anchor=\"middle\">{}</text>",
                escape(band.name)
            );
        }
    }

    fn draw_panel(
        &self,
        body: &mut String,
        panel: &Panel<'_>,
        x: &Axis,
        (top, bottom): (f64, f64),
    ) {
        let (width, height) = (RIGHT - LEFT, bottom - top);
        let count = (self.panel_height_px / 30.0).clamp(2.0, 8.0);
        for band in &self.bands {
            let Some((from, to)) = clip(band, x) else {
                continue;
            };
            let _ = write!(
                body,
                "<rect class=\"band\" x=\"{from:.1}\" y=\"{top:.1}\" width=\"{:.1}\" height=\"{height:.1}\"><title>{}</title></rect>",
                (to - from).max(1.0),
                escape(band.name)
            );
        }
        for (value, _) in ticks(x.low, x.high, 10.0) {
            let _ = write!(
                body,
                "<path class=\"grid\" d=\"M{:.1} {top:.1}v{height:.1}\"/>",
                x.at(value)
            );
        }
        let range = panel.range(x);
        let (low, high) = roomy(range.unwrap_or((0.0, 1.0)));
        let y = Axis {
            low,
            high,
            from_px: bottom,
            to_px: top,
        };
        if range.is_some() {
            for (value, label) in ticks(low, high, count) {
                let px = y.at(value);
                let class = if value == 0.0 { "zero" } else { "grid" };
                let _ = write!(
                    body,
                    "<path class=\"{class}\" d=\"M{LEFT} {px:.1}h{width}\"/>\
                     <text class=\"soft\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{label}</text>",
                    LEFT - 7.0,
                    px + 4.0
                );
            }
        } else {
            let _ = write!(
                body,
                "<text class=\"soft\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">no data</text>",
                0.5 * (LEFT + RIGHT),
                0.5 * (top + bottom) + 4.0
            );
        }
        let _ = write!(
            body,
            "<rect class=\"frame\" x=\"{LEFT}\" y=\"{top:.1}\" width=\"{width}\" height=\"{height:.1}\"/>"
        );
        for level in panel.levels.iter().filter(|level| level.value.is_finite()) {
            let _ = write!(
                body,
                "<path class=\"level\" d=\"M{LEFT} {:.1}h{width}\"/>",
                y.at(level.value)
            );
        }
        for series in &panel.series {
            let d = line::path(series.x, series.y, x, &y);
            if !d.is_empty() {
                let style = series.style % STYLES;
                let _ = write!(body, "<path class=\"s s{style}\" d=\"{d}\"/>");
            }
        }
    }
}

fn draw_head(body: &mut String, panel: &Panel<'_>, legend: &[Entry<'_>], top: f64) {
    let baseline = top + 14.0;
    let _ = write!(
        body,
        "<text class=\"head\" x=\"{LEFT}\" y=\"{baseline:.1}\">{}<tspan class=\"soft\" font-weight=\"400\">{}{}</tspan></text>",
        escape(panel.title),
        if panel.unit.is_empty() { "" } else { ", " },
        escape(panel.unit)
    );
    for entry in legend {
        let y = baseline + LINE * entry.row as f64;
        let class = entry
            .style
            .map_or("level".to_string(), |style| format!("s s{style}"));
        let _ = write!(
            body,
            "<path class=\"{class}\" d=\"M{:.1} {:.1}h22\"/><text x=\"{:.1}\" y=\"{y:.1}\">{}</text>",
            entry.x,
            y - 4.0,
            entry.x + SAMPLE,
            escape(entry.name)
        );
    }
}

/// Pixels of the part of `band` that is in the picture.
fn clip(band: &Band<'_>, x: &Axis) -> Option<(f64, f64)> {
    let (from, to) = (band.from.max(x.low), band.to.min(x.high));
    (from <= to && from.is_finite() && to.is_finite()).then(|| (x.at(from), x.at(to)))
}
