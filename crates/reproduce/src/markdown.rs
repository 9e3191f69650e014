//! The table as markdown, for readers and for the repository.

use crate::Reproduction;
use crate::row::{Figure, Row, Verdict};
use std::fmt::Write as _;

/// Cells of a row without its note: id, thesis, ours, unit, ratio, verdict.
pub fn cells(row: &Row) -> [String; 6] {
    [
        row.id.to_owned(),
        row.thesis.text(),
        row.ours.text(),
        row.unit.to_owned(),
        row.ratio.map_or(String::new(), |r| format!("{r:.3}")),
        row.verdict.as_str().to_owned(),
    ]
}

impl Reproduction {
    /// The whole as a markdown document.
    pub fn markdown(&self) -> String {
        let mut out = format!(
            "# Bulsink (2017) reproduced\n\nV. E. Bulsink, *Bicycling stability*, University of Twente, 2017: every figure that its text states,\nbeside that of the multibody model. Written by `twinhub reproduce --markdown`.\n\nOne set of assumptions for all rows: {}.\n\n**{} of {} rows agree** (numbers within 5 %, words the same).\n\n",
            self.assumed,
            self.agreeing(),
            self.rows.len()
        );
        out.push_str(&self.table());
        out.push_str("\n## Conditions, and what moves the misses\n\n");
        for row in &self.rows {
            let _ = writeln!(out, "* **{}** ({}): {}.", row.id, row.source, row.note);
        }
        if !self.method.is_empty() {
            out.push_str("\n## The thesis's own method\n\nA lateral push of 0.1 N for 0.1 s on the nonlinear model, four poles fitted to roll and steer, and\nthe speed at which the fitted weave mode turns stable.\n\n");
            out.push_str(&self.method_table());
        }
        out
    }

    /// The table of rows.
    pub fn table(&self) -> String {
        let mut out = String::from(
            "| row | thesis | ours | unit | ratio | verdict |\n|---|---|---|---|---|---|\n",
        );
        for row in &self.rows {
            let _ = writeln!(out, "| {} |", cells(row).join(" | "));
        }
        out
    }

    /// The table of the method.
    pub fn method_table(&self) -> String {
        let mut out = String::from(
            "| bicycle | linearised, m/s | four poles, m/s | difference |\n|---|---|---|---|\n",
        );
        for m in &self.method {
            let [name, linearised, four, difference] = m.cells();
            let _ = writeln!(out, "| {name} | {linearised} | {four} | {difference} % |");
        }
        out
    }

    /// The table for a terminal: a line for each row, with its note below a miss or other words.
    pub fn text(&self) -> String {
        let mut out = format!("{}\n\n", self.assumed);
        let width = self.rows.iter().map(|r| r.id.len()).max().unwrap_or(0);
        for row in &self.rows {
            let [id, thesis, ours, unit, ratio, verdict] = cells(row);
            match row.thesis {
                Figure::Number(_) => {
                    let _ = writeln!(
                        out,
                        "{id:width$}  thesis {thesis:>6}  ours {ours:>6} {unit:5} ratio {ratio:>6}  {verdict}"
                    );
                }
                Figure::Words(_) => {
                    let _ = writeln!(
                        out,
                        "{id:width$}  {verdict}: thesis: {thesis}; ours: {ours}"
                    );
                }
            }
            if matches!(row.verdict, Verdict::Missed | Verdict::OtherWords) {
                let _ = writeln!(out, "{:width$}    {}", "", row.note);
            }
        }
        if !self.method.is_empty() {
            let _ = writeln!(
                out,
                "\nweave speed, linearised and by four poles fitted to the response to a push:"
            );
            for m in &self.method {
                let [name, linearised, four, difference] = m.cells();
                let _ = writeln!(
                    out,
                    "{name:24} {linearised:>8} {four:>8} m/s  {difference:>7} %"
                );
            }
        }
        let _ = writeln!(
            out,
            "\n{} of {} rows agree",
            self.agreeing(),
            self.rows.len()
        );
        out
    }
}

impl crate::Method {
    /// Name, linearised, four poles, difference in percent.
    pub fn cells(&self) -> [String; 4] {
        let speed = |v: Option<f64>| v.map_or("none".to_owned(), |v| format!("{v:.3}"));
        [
            self.name.to_owned(),
            speed(self.linearised_m_s),
            speed(self.four_poles_m_s),
            self.difference_percent()
                .map_or("none".to_owned(), |d| format!("{d:+.2}")),
        ]
    }
}
