//! The shell of a page and its parts: verdict, tables, notes, folded text. One file that needs
//! nothing else; every text is escaped here.

use std::fmt::Write as _;

use crate::chart;
use crate::text::escape;

const STYLE: &str = "\
:root{color-scheme:light dark;--ink:#1b1f24;--soft:#5b6470;--rule:#dde2e8;--paper:#fff;--card:#f5f7f9;--good:#1e7d46;--bad:#b3261e;--even:#8a6100}\
@media(prefers-color-scheme:dark){:root{--ink:#e8ebef;--soft:#a3adb9;--rule:#30363e;--paper:#14171b;--card:#1c2026;--good:#43c07a;--bad:#ff8a80;--even:#e8c04a}}\
@media print{.scroll svg{min-width:0}:root{color-scheme:light;--ink:#000;--soft:#444;--rule:#ccc;--paper:#fff;--card:#fff}details[open] pre{white-space:pre-wrap}h2{break-after:avoid}svg,table,.verdict{break-inside:avoid}}\
*{box-sizing:border-box}body{margin:0;background:var(--paper);color:var(--ink);font:15px/1.5 system-ui,-apple-system,'Segoe UI',Roboto,sans-serif}\
main{max-width:1000px;margin:0 auto;padding:28px 20px 56px}h1{font-size:26px;line-height:1.25;margin:0}h2{font-size:18px;margin:34px 0 10px}\
.lead{color:var(--soft);margin:4px 0 0}.verdict{margin:20px 0;padding:14px 18px;background:var(--card);border-left:5px solid var(--soft);border-radius:4px;font-size:17px}\
.verdict.good{border-color:var(--good)}.verdict.bad{border-color:var(--bad)}.verdict.even{border-color:var(--even)}\
.note{color:var(--soft);margin:10px 0;max-width:75ch}.scroll{overflow-x:auto}.scroll svg{min-width:680px}\
table{border-collapse:collapse;font-variant-numeric:tabular-nums}th,td{padding:5px 14px 5px 0;text-align:left;border-bottom:1px solid var(--rule);vertical-align:top}\
th{font-weight:600}thead th{color:var(--soft);font-weight:500}td.n,th.n{text-align:right;padding-left:14px}td.unit{color:var(--soft)}\
code,pre,.mono{font:13px/1.45 ui-monospace,SFMono-Regular,Menlo,Consolas,monospace}.mono{overflow-wrap:anywhere}\
pre{background:var(--card);padding:12px 14px;border-radius:4px;overflow-x:auto;margin:8px 0}summary{cursor:pointer;color:var(--soft)}";

/// What a verdict says at a glance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tone {
    /// Better, passed.
    Good,
    /// Neither.
    Even,
    /// Worse, failed.
    Bad,
}

/// How the cells of a column stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cells {
    /// Words.
    Text,
    /// Numbers, to the right.
    Number,
    /// Units.
    Unit,
    /// Hashes, paths, commands.
    Code,
}

/// A page that is being put together.
#[derive(Clone, Debug)]
pub struct Page {
    title: String,
    body: String,
}

impl Page {
    /// A page with a heading and a line below it.
    pub fn new(title: &str, lead: &str) -> Self {
        let mut body = format!("<h1>{}</h1>\n", escape(title));
        if !lead.is_empty() {
            let _ = writeln!(body, "<p class=\"lead\">{}</p>", escape(lead));
        }
        Self {
            title: escape(title),
            body,
        }
    }

    /// The result in a sentence.
    pub fn verdict(&mut self, tone: Tone, sentence: &str) -> &mut Self {
        let class = match tone {
            Tone::Good => "good",
            Tone::Even => "even",
            Tone::Bad => "bad",
        };
        let _ = writeln!(
            self.body,
            "<p class=\"verdict {class}\">{}</p>",
            escape(sentence)
        );
        self
    }

    /// A heading within the page.
    pub fn section(&mut self, title: &str) -> &mut Self {
        let _ = writeln!(self.body, "<h2>{}</h2>", escape(title));
        self
    }

    /// A paragraph.
    pub fn text(&mut self, text: &str) -> &mut Self {
        let _ = writeln!(self.body, "<p>{}</p>", escape(text));
        self
    }

    /// A remark in small print.
    pub fn note(&mut self, text: &str) -> &mut Self {
        let _ = writeln!(self.body, "<p class=\"note\">{}</p>", escape(text));
        self
    }

    /// A table; `columns` are headings and kinds. Rows that are too short end in empty cells.
    pub fn table(&mut self, columns: &[(&str, Cells)], rows: &[Vec<String>]) -> &mut Self {
        self.body.push_str("<div class=\"scroll\"><table>");
        if columns.iter().any(|(heading, _)| !heading.is_empty()) {
            self.body.push_str("<thead><tr>");
            for (heading, kind) in columns {
                let class = if *kind == Cells::Number {
                    " class=\"n\""
                } else {
                    ""
                };
                let _ = write!(
                    self.body,
                    "<th scope=\"col\"{class}>{}</th>",
                    escape(heading)
                );
            }
            self.body.push_str("</tr></thead>");
        }
        self.body.push_str("<tbody>\n");
        for row in rows {
            self.body.push_str("<tr>");
            for (index, (_, kind)) in columns.iter().enumerate() {
                let cell = escape(row.get(index).map_or("", String::as_str));
                let _ = match (index, kind) {
                    (0, _) => write!(self.body, "<th scope=\"row\">{cell}</th>"),
                    (_, Cells::Text) => write!(self.body, "<td>{cell}</td>"),
                    (_, Cells::Number) => write!(self.body, "<td class=\"n\">{cell}</td>"),
                    (_, Cells::Unit) => write!(self.body, "<td class=\"unit\">{cell}</td>"),
                    (_, Cells::Code) => write!(self.body, "<td class=\"mono\">{cell}</td>"),
                };
            }
            self.body.push_str("</tr>\n");
        }
        self.body.push_str("</tbody></table></div>\n");
        self
    }

    /// A picture: an `<svg>` element made by this crate.
    pub fn picture(&mut self, svg: &str) -> &mut Self {
        let _ = writeln!(self.body, "<div class=\"scroll\">{svg}</div>");
        self
    }

    /// Text as it is, folded away below `summary`.
    pub fn folded(&mut self, summary: &str, text: &str) -> &mut Self {
        let _ = writeln!(
            self.body,
            "<details><summary>{}</summary><pre>{}</pre></details>",
            escape(summary),
            escape(text)
        );
        self
    }

    /// Text as it is: commands to try.
    pub fn code(&mut self, text: &str) -> &mut Self {
        let _ = writeln!(self.body, "<pre>{}</pre>", escape(text));
        self
    }

    /// The page.
    pub fn html(&self) -> String {
        format!(
            "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"/>\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\
             <title>{}</title><style>{STYLE}\n{}</style></head>\n<body><main>\n{}</main></body></html>\n",
            self.title,
            chart::STYLE,
            self.body
        )
    }
}
