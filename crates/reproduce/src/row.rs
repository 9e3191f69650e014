//! One figure of the source beside ours.

use serde::Serialize;

/// A figure: a number, or words where the source gives words.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Figure {
    /// A number in the unit of the row.
    Number(f64),
    /// Words.
    Words(String),
}

/// How ours stands to the source's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Verdict {
    /// Within 5 %.
    #[serde(rename = "met")]
    Met,
    /// Further away.
    #[serde(rename = "missed")]
    Missed,
    /// The source says it in words, and ours says the same.
    #[serde(rename = "same words")]
    SameWords,
    /// Ours says something else.
    #[serde(rename = "other words")]
    OtherWords,
}

impl Verdict {
    /// As in the JSON answer.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Met => "met",
            Self::Missed => "missed",
            Self::SameWords => "same words",
            Self::OtherWords => "other words",
        }
    }

    /// Met, or the same words.
    pub const fn agrees(self) -> bool {
        matches!(self, Self::Met | Self::SameWords)
    }
}

/// Relative distance up to which a figure counts as met.
pub const TOLERANCE: f64 = 0.05;

/// An assumption, and the value of it that would meet the source's figure with all else as it is.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Assumption {
    /// What is assumed.
    pub name: &'static str,
    /// The value in the set that all rows share.
    pub ours: f64,
    /// The value that would meet the figure; none if no value within `searched` does.
    pub would_meet: Option<f64>,
    /// The values that were searched.
    pub searched: [f64; 2],
}

/// One row of the table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Stable name.
    pub id: &'static str,
    /// What the source says.
    pub thesis: Figure,
    /// What we find.
    pub ours: Figure,
    /// Unit of both numbers; empty for words.
    pub unit: &'static str,
    /// Ours over the source's; none for words.
    pub ratio: Option<f64>,
    /// The judgement.
    pub verdict: Verdict,
    /// Conditions, and for a miss what moves it.
    pub note: String,
    /// What moves a miss.
    pub assumptions: Vec<Assumption>,
    /// Where the source says it.
    pub source: &'static str,
}

impl Row {
    /// A row of numbers; `ours` is `None` where we find no such figure.
    pub fn number(id: &'static str, thesis: f64, ours: Option<f64>, unit: &'static str) -> Self {
        let ratio = ours.map(|v| v / thesis);
        let met = ratio.is_some_and(|r| (r - 1.0).abs() <= TOLERANCE);
        Self {
            id,
            thesis: Figure::Number(thesis),
            ours: ours.map_or(Figure::Words("none".to_owned()), Figure::Number),
            unit,
            ratio,
            verdict: if met { Verdict::Met } else { Verdict::Missed },
            note: String::new(),
            assumptions: Vec::new(),
            source: "",
        }
    }

    /// A row of words: `same` says whether ours are those of the source.
    pub fn words(id: &'static str, thesis: &str, ours: String, same: bool) -> Self {
        Self {
            id,
            thesis: Figure::Words(thesis.to_owned()),
            ours: Figure::Words(ours),
            unit: "",
            ratio: None,
            verdict: if same {
                Verdict::SameWords
            } else {
                Verdict::OtherWords
            },
            note: String::new(),
            assumptions: Vec::new(),
            source: "",
        }
    }

    /// The same row with conditions and where the source says it.
    pub fn noted(mut self, source: &'static str, note: impl Into<String>) -> Self {
        self.source = source;
        self.note = note.into();
        self
    }

    /// Is this a number that was missed?
    pub fn missed(&self) -> bool {
        self.verdict == Verdict::Missed
    }

    /// The number of the source.
    pub fn target(&self) -> Option<f64> {
        match self.thesis {
            Figure::Number(v) => Some(v),
            Figure::Words(_) => None,
        }
    }

    /// Adds an assumption that was searched, to the list and to the note.
    pub fn explain(&mut self, assumption: Assumption) {
        let Assumption {
            name,
            ours,
            would_meet,
            searched: [low, high],
        } = &assumption;
        let text = match would_meet {
            Some(value) => format!("met with {name} {value:.3} instead of {ours:.3}"),
            None => format!("no {name} from {low} to {high} meets it"),
        };
        if !self.note.is_empty() {
            self.note.push_str("; ");
        }
        self.note.push_str(&text);
        self.assumptions.push(assumption);
    }
}

impl Figure {
    /// As in the table.
    pub fn text(&self) -> String {
        match self {
            Self::Number(v) if v.abs() >= 100.0 => format!("{v:.0}"),
            Self::Number(v) if v.abs() >= 10.0 => format!("{v:.1}"),
            Self::Number(v) => format!("{v:.2}"),
            Self::Words(words) => words.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn five_percent_is_met_and_more_is_not() {
        let verdict = |ours| Row::number("x", 10.0, ours, "m").verdict;
        assert_eq!(verdict(Some(10.499)), Verdict::Met);
        assert_eq!(verdict(Some(9.501)), Verdict::Met);
        assert_eq!(verdict(Some(10.51)), Verdict::Missed);
        assert_eq!(verdict(Some(9.49)), Verdict::Missed);
        assert_eq!(verdict(Some(f64::NAN)), Verdict::Missed);
        assert_eq!(verdict(None), Verdict::Missed);
        let negative = Row::number("x", -3.0, Some(3.0), "%");
        assert!(negative.missed(), "the wrong sign is a miss");
    }

    #[test]
    fn json_has_the_names_that_scripts_rely_on() {
        let row = Row::number("case6_weave", 9.3, Some(9.05), "m/s");
        let json = serde_json::to_value(&row).unwrap();
        for (key, value) in [
            ("id", serde_json::json!("case6_weave")),
            ("thesis", 9.3.into()),
            ("ours", 9.05.into()),
            ("unit", "m/s".into()),
            ("verdict", "met".into()),
        ] {
            assert_eq!(json[key], value, "{key}");
        }
        assert!((json["ratio"].as_f64().unwrap() - 0.973).abs() < 1.0e-3);
        let words = Row::words("case6_capsize_stable", "stable", "stable".to_owned(), true);
        let json = serde_json::to_value(&words).unwrap();
        assert_eq!(json["verdict"], "same words");
        assert!(json["ratio"].is_null() && json["thesis"] == "stable");
    }

    #[test]
    fn a_miss_says_what_would_meet_it() {
        let mut row = Row::number("x", 9.3, Some(8.0), "m/s").noted("section 3", "case 6");
        row.explain(Assumption {
            name: "k",
            ours: 0.43,
            would_meet: Some(0.2),
            searched: [0.1, 0.6],
        });
        row.explain(Assumption {
            name: "h",
            ours: 1.0,
            would_meet: None,
            searched: [0.5, 2.0],
        });
        assert_eq!(
            row.note,
            "case 6; met with k 0.200 instead of 0.430; no h from 0.5 to 2 meets it"
        );
    }
}
