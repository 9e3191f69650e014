//! The page that sets published figures beside ours: verdict, table, what moves the misses, and the
//! figures drawn again.

use crate::chart::{Band, Chart, Level, Panel, Series};
use crate::page::{Cells, Page, Tone};

/// A line of a plot that owns its numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Line {
    /// Name in the legend.
    pub name: String,
    /// Line style, below [`crate::chart::STYLES`].
    pub style: usize,
    /// x values, rising.
    pub x: Vec<f64>,
    /// y values; NaN is a gap.
    pub y: Vec<f64>,
}

/// One panel of a plot.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlotPanel {
    /// Quantity.
    pub title: String,
    /// Its unit.
    pub unit: String,
    /// Lines.
    pub lines: Vec<Line>,
    /// Horizontal lines: value and name.
    pub levels: Vec<(f64, String)>,
}

/// A figure of the source, drawn again.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plot {
    /// Short name for a file, as `figure_3_4`.
    pub name: String,
    /// Heading.
    pub title: String,
    /// What it shows, and what the source says about it.
    pub note: String,
    /// Name and unit of the x axis.
    pub x_title: String,
    /// Range of the x axis; that of the data if `None`.
    pub x_range: Option<(f64, f64)>,
    /// Panels.
    pub panels: Vec<PlotPanel>,
    /// Places on the x axis that the source names: value and name.
    pub marks: Vec<(f64, String)>,
}

impl Plot {
    fn chart(&self) -> Chart<'_> {
        Chart {
            title: &self.title,
            x_title: &self.x_title,
            x_range: self.x_range,
            panels: self
                .panels
                .iter()
                .map(|p| Panel {
                    title: &p.title,
                    unit: &p.unit,
                    series: p
                        .lines
                        .iter()
                        .map(|l| Series {
                            name: &l.name,
                            style: l.style,
                            x: &l.x,
                            y: &l.y,
                        })
                        .collect(),
                    levels: p
                        .levels
                        .iter()
                        .map(|(value, name)| Level {
                            value: *value,
                            name,
                        })
                        .collect(),
                })
                .collect(),
            bands: self
                .marks
                .iter()
                .map(|(at, name)| Band {
                    from: *at,
                    to: *at,
                    name,
                })
                .collect(),
            panel_height_px: if self.panels.len() > 2 { 110.0 } else { 190.0 },
        }
    }

    /// As a picture of its own.
    pub fn picture(&self) -> String {
        self.chart().standalone()
    }
}

/// Everything on the page.
#[derive(Clone, Debug, Default)]
pub struct ReproducePage {
    /// The assumptions that all rows share.
    pub assumed: String,
    /// How many rows agree, and of how many.
    pub agree: [usize; 2],
    /// id, thesis, ours, unit, ratio, verdict, note.
    pub rows: Vec<[String; 7]>,
    /// Where the thesis's own method was tried: name, linearised, four poles, difference.
    pub method: Vec<[String; 4]>,
    /// Figures.
    pub plots: Vec<Plot>,
}

impl ReproducePage {
    /// The page.
    pub fn html(&self) -> String {
        let mut page = Page::new(
            "Bulsink (2017) reproduced",
            "V. E. Bulsink, Bicycling stability, University of Twente, 2017: its figures beside those of the multibody model.",
        );
        let [agree, all] = self.agree;
        let tone = if 2 * agree >= all {
            Tone::Good
        } else {
            Tone::Even
        };
        page.verdict(
            tone,
            &format!("{agree} of {all} rows agree: numbers within 5 %, words the same."),
        );
        page.text(&format!(
            "One set of assumptions for all rows: {}.",
            self.assumed
        ));
        page.section("Figures and words");
        page.table(
            &[
                ("row", Cells::Code),
                ("thesis", Cells::Text),
                ("ours", Cells::Text),
                ("unit", Cells::Unit),
                ("ratio", Cells::Number),
                ("verdict", Cells::Text),
                ("note", Cells::Text),
            ],
            &self.rows.iter().map(|r| r.to_vec()).collect::<Vec<_>>(),
        );
        page.section("The thesis's own method");
        page.text(
            "A push of 0.1 N for 0.1 s on the nonlinear model, a state-space model with four poles fitted to roll and steer, and the speed at which its weave mode turns stable, beside the linearised model.",
        );
        page.table(
            &[
                ("", Cells::Text),
                ("linearised, m/s", Cells::Number),
                ("four poles, m/s", Cells::Number),
                ("difference, %", Cells::Number),
            ],
            &self.method.iter().map(|r| r.to_vec()).collect::<Vec<_>>(),
        );
        for plot in &self.plots {
            page.section(&plot.title);
            page.note(&plot.note);
            page.picture(&plot.chart().svg());
        }
        page.html()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_holds_rows_and_figures_and_escapes_text() {
        let plot = Plot {
            name: "figure_1".to_owned(),
            title: "Figure 1".to_owned(),
            note: "a < b".to_owned(),
            x_title: "speed, m/s".to_owned(),
            panels: vec![PlotPanel {
                title: "real part".to_owned(),
                unit: "1/s".to_owned(),
                lines: vec![Line {
                    name: "weave".to_owned(),
                    style: 0,
                    x: vec![1.0, 2.0],
                    y: vec![1.0, -1.0],
                }],
                levels: Vec::new(),
            }],
            marks: vec![(1.5, "thesis 1.5".to_owned())],
            ..Plot::default()
        };
        let page = ReproducePage {
            assumed: "none".to_owned(),
            agree: [1, 2],
            rows: vec![
                ["case<1>", "4.9", "4.88", "m/s", "0.996", "met", "note"].map(str::to_owned),
            ],
            plots: vec![plot.clone()],
            ..ReproducePage::default()
        };
        let html = page.html();
        for text in [
            "1 of 2 rows agree",
            "case&lt;1&gt;",
            "a &lt; b",
            "thesis 1.5",
            "<svg",
        ] {
            assert!(html.contains(text), "{text}");
        }
        assert!(!html.contains("<script") && !html.contains("http-equiv"));
        let picture = plot.picture();
        assert!(
            picture.starts_with("<svg") && picture.contains("<style>") && !picture.contains("NaN")
        );
    }
}
