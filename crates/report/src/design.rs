//! The page of a designed schedule: the tube over speed, what is proved, and what a loss does.

use crate::chart::{Band, Chart, Level, Panel, Series};
use crate::page::{Cells, Page, Tone};

/// What the page shows. Lists over speed have one entry for each node.
#[derive(Clone, Debug, Default)]
pub struct DesignPage {
    /// What was designed for whom, in a line.
    pub lead: String,
    /// The result, in a sentence.
    pub sentence: String,
    /// Something is proved with a pair that is not zero.
    pub good: bool,
    /// Nodes, m/s, rising.
    pub speeds_m_s: Vec<f64>,
    /// The schedule, Nm.
    pub torque_nm: Vec<f64>,
    /// Lower edge of the tube, Nm.
    pub from_nm: Vec<f64>,
    /// Upper edge of the tube, Nm.
    pub to_nm: Vec<f64>,
    /// Largest growth rate of all riders and boxes, 1/s.
    pub growth_per_s: Vec<f64>,
    /// The same after the pair is lost at once, 1/s.
    pub loss_growth_per_s: Vec<f64>,
    /// The largest that is allowed, 1/s.
    pub loss_limit_per_s: f64,
    /// Stretches that are proved, m/s.
    pub proved_m_s: Vec<[f64; 2]>,
    /// Stretches without proof: from, to, rider, what stops it.
    pub stops: Vec<[String; 4]>,
    /// What was asked for: name and value.
    pub plan: Vec<[String; 2]>,
}

impl DesignPage {
    fn chart(&self) -> String {
        let line = |name, style, y| Series {
            name,
            style,
            x: &self.speeds_m_s,
            y,
        };
        let bands = self.proved_m_s.iter().map(|[from, to]| Band {
            from: *from,
            to: *to,
            name: "proved",
        });
        Chart {
            title: "Schedule and growth rates over speed",
            x_title: "speed, m/s",
            x_range: None,
            panels: vec![
                Panel {
                    title: "pair",
                    unit: "Nm",
                    series: vec![
                        line("lower edge", 5, &self.from_nm),
                        line("upper edge", 5, &self.to_nm),
                        line("schedule", 0, &self.torque_nm),
                    ],
                    levels: vec![],
                },
                Panel {
                    title: "growth rate",
                    unit: "1/s",
                    series: vec![
                        line("with the pair", 0, &self.growth_per_s),
                        line("after its loss", 1, &self.loss_growth_per_s),
                    ],
                    levels: vec![Level {
                        value: self.loss_limit_per_s,
                        name: "allowed after a loss",
                    }],
                },
            ],
            bands: bands.collect(),
            panel_height_px: 180.0,
        }
        .svg()
    }
}

/// The page as HTML.
pub fn design_page(content: &DesignPage) -> String {
    let mut page = Page::new("Design: a schedule with its proof", &content.lead);
    let tone = if content.good { Tone::Good } else { Tone::Bad };
    page.verdict(tone, &content.sentence);
    page.section("Over speed");
    page.picture(&content.chart());
    page.note(
        "Growth rates are the largest of all riders and bicycles at a node. Shaded: proved between the nodes \
         too, while the pair moves inside the tube and speed changes.",
    );
    if !content.stops.is_empty() {
        page.section("What is not proved, and what stops it");
        let columns = [
            ("from, m/s", Cells::Number),
            ("to, m/s", Cells::Number),
            ("rider", Cells::Text),
            ("certain instead, each alone would help", Cells::Text),
        ];
        let rows: Vec<Vec<String>> = content.stops.iter().map(|r| r.to_vec()).collect();
        page.table(&columns, &rows);
    }
    page.section("What was asked for");
    let rows: Vec<Vec<String>> = content.plan.iter().map(|r| r.to_vec()).collect();
    page.table(&[("", Cells::Text), ("", Cells::Text)], &rows);
    page.html()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_shows_the_tube_and_what_stops_it() {
        let page = DesignPage {
            lead: "a bicycle <b>".to_owned(),
            sentence: "proved 5 to 6 m/s".to_owned(),
            good: true,
            speeds_m_s: vec![4.0, 5.0, 6.0],
            torque_nm: vec![0.0, 10.0, 0.0],
            from_nm: vec![0.0, 5.0, 0.0],
            to_nm: vec![5.0, 15.0, 5.0],
            growth_per_s: vec![-0.1, -0.5, -1.0],
            loss_growth_per_s: vec![-0.1, 0.2, -1.0],
            loss_limit_per_s: 0.7,
            proved_m_s: vec![[5.0, 6.0]],
            stops: vec![["4", "5", "young", "the distance of the nodes"].map(str::to_owned)],
            plan: vec![["mass", "0.9 to 1.1"].map(str::to_owned)],
        };
        let html = design_page(&page);
        for part in [
            "a bicycle &lt;b&gt;",
            "the distance of the nodes",
            "class=\"band\"",
            "allowed after a loss",
            "upper edge",
        ] {
            assert!(html.contains(part), "{part}");
        }
    }
}
