//! The page of the blind suite: metrics against their gates, the detection curve, what went wrong.

use crate::chart::{Chart, Level, Panel, Series};
use crate::page::{Cells, Page, Tone};

/// Everything on the page.
#[derive(Clone, Debug, Default)]
pub struct BlindPage {
    pub lead: String,
    /// Metrics, and those of them that fail.
    pub passed: usize,
    pub failed: usize,
    /// Id, what, value, interval, sets, pass, moonshot, verdict.
    pub rows: Vec<[String; 8]>,
    /// Multiple of the printed limit, share detected.
    pub curve: Vec<[f64; 2]>,
    /// Sets that were answered wrongly: kind and seed, what was hidden, what was said, command.
    pub wrong: Vec<[String; 4]>,
    pub details: String,
}

/// The page as HTML.
pub fn blind_page(content: &BlindPage) -> String {
    let mut page = Page::new(
        "Blind suite: sealed data through the diagnosis",
        &content.lead,
    );
    let tone = if content.failed == 0 {
        Tone::Good
    } else {
        Tone::Bad
    };
    let sentence = format!("{} metrics pass, {} fail", content.passed, content.failed);
    page.verdict(tone, &sentence);
    page.section("Metrics");
    page.note(
        "Shares with Wilson's 95 % interval, medians with the bootstrap's. Sizes count in the detection limits \
         that the diagnosis itself prints for the same rides without the effect.",
    );
    let columns = [
        ("metric", Cells::Text),
        ("what", Cells::Text),
        ("ours", Cells::Number),
        ("95 %", Cells::Number),
        ("sets", Cells::Number),
        ("pass", Cells::Text),
        ("moonshot", Cells::Text),
        ("verdict", Cells::Text),
    ];
    let rows: Vec<Vec<String>> = content.rows.iter().map(|r| r.to_vec()).collect();
    page.table(&columns, &rows);
    if content.curve.len() > 1 {
        page.section("Detection");
        let x: Vec<f64> = content.curve.iter().map(|p| p[0]).collect();
        let y: Vec<f64> = content.curve.iter().map(|p| p[1]).collect();
        let chart = Chart {
            title: "Share of single effects detected against their size",
            x_title: "size, in printed limits",
            panels: vec![Panel {
                title: "detected",
                unit: "share",
                series: vec![Series {
                    name: "detected",
                    style: 0,
                    x: &x,
                    y: &y,
                }],
                levels: vec![Level {
                    value: 0.9,
                    name: "90 %",
                }],
            }],
            ..Chart::default()
        };
        page.picture(&chart.svg());
    }
    if !content.wrong.is_empty() {
        page.section("Answered wrongly");
        let columns = [
            ("set", Cells::Text),
            ("hidden", Cells::Text),
            ("said", Cells::Text),
            ("to see it", Cells::Code),
        ];
        let rows: Vec<Vec<String>> = content.wrong.iter().map(|r| r.to_vec()).collect();
        page.table(&columns, &rows);
    }
    page.folded("details", &content.details);
    page.html()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_is_well_formed_and_says_what_failed() {
        let content = BlindPage {
            passed: 3,
            failed: 1,
            rows: vec![
                [
                    "M1",
                    "named <cause>",
                    "0.01",
                    "0 to 0.05",
                    "99",
                    "<= 0.02",
                    "<= 0",
                    "pass",
                ]
                .map(str::to_owned),
            ],
            curve: vec![[0.0, 0.0], [2.0, 0.9]],
            wrong: vec![
                [
                    "clean 7",
                    "nothing",
                    "cause: payload",
                    "twinhub blind --write x",
                ]
                .map(str::to_owned),
            ],
            ..BlindPage::default()
        };
        let html = blind_page(&content);
        assert!(html.contains("3 metrics pass, 1 fail") && html.contains("named &lt;cause&gt;"));
        let body = html.split_once('\n').map_or("", |p| p.1);
        assert!(roxmltree::Document::parse(body).is_ok());
    }
}
