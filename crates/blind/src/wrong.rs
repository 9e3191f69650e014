//! Which sets were answered wrongly, in words, with the command that writes them for inspection.

use crate::run::Outcome;

/// One set that deserves a look.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Wrong {
    pub set: String,
    pub hidden: String,
    pub said: String,
    pub command: String,
}

/// Sets whose answer is not what it should be, given how large the effects are.
pub fn wrong(outcomes: &[Outcome]) -> Vec<Wrong> {
    outcomes
        .iter()
        .filter(|o| !right(o))
        .map(describe)
        .collect()
}

fn right(o: &Outcome) -> bool {
    let sizable = o
        .multiples
        .iter()
        .all(|m| m.is_some_and(|m| m >= crate::gates::DETECTED_FROM - 1e-9));
    match o.planned.kind.as_str() {
        "clean" | "mismatched" => !o.found.names_a_cause(),
        "shifted" | "mixed" => matches!(o.found.verdict.as_str(), "bad_data" | "unknown"),
        "outside" => !o.found.causes.iter().any(|c| c.confirmed) && o.found.detects(),
        _ if sizable => o.truth.effects.iter().all(|e| o.found.covers(&e.mechanism)),
        _ => {
            !o.found.names_a_cause() || o.truth.effects.iter().any(|e| o.found.covers(&e.mechanism))
        }
    }
}

fn describe(o: &Outcome) -> Wrong {
    let hidden = o
        .truth
        .effects
        .iter()
        .zip(o.multiples.iter().chain(std::iter::repeat(&None)));
    let hidden: Vec<String> = hidden
        .map(|(e, multiple)| {
            let times = multiple.map_or(String::new(), |m| format!(", {m:.1} limits"));
            format!("{} {:.4}{times}", e.mechanism, e.value)
        })
        .collect();
    let causes: Vec<String> = (o.found.causes.iter())
        .map(|c| {
            format!(
                "{}{} of {{{}}}",
                c.mechanism,
                if c.confirmed { "" } else { " (provisional)" },
                c.set.join(", ")
            )
        })
        .collect();
    let places: Vec<&str> = o.found.places.iter().map(|p| p.equation.as_str()).collect();
    let sizes: Vec<String> = o
        .truth
        .effects
        .iter()
        .map(|e| format!("{:.5}", e.size.abs()))
        .collect();
    let size = if sizes.is_empty() {
        String::new()
    } else {
        format!(" --size {}", sizes.join(","))
    };
    Wrong {
        set: format!("{} {}", o.planned.kind, o.planned.seed),
        hidden: if hidden.is_empty() {
            "nothing".to_owned()
        } else {
            hidden.join("; ")
        },
        said: format!(
            "{}: {} at {}",
            o.found.verdict,
            causes.join("; "),
            places.join(", ")
        ),
        command: format!(
            "twinhub blind --write DIR --kinds {} --set-seed {}{size}",
            o.planned.kind, o.planned.seed
        ),
    }
}
