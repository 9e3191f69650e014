//! What is written about a mechanism: everything that `explain`, the report and the search need.

use serde::Serialize;

/// Where in the system a mechanism sits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Family {
    Tyre,
    Rider,
    Actuator,
    Sensor,
    Environment,
    Structure,
}

/// Which balance a mechanism disturbs first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Equation {
    Roll,
    Steer,
    Lateral,
    Longitudinal,
    WheelFront,
    WheelRear,
    Rider,
    Sensor,
}

impl Equation {
    /// The word of the answer.
    pub fn name(self) -> &'static str {
        match self {
            Self::Roll => "roll",
            Self::Steer => "steer",
            Self::Lateral => "lateral",
            Self::Longitudinal => "longitudinal",
            Self::WheelFront => "wheel_front",
            Self::WheelRear => "wheel_rear",
            Self::Rider => "rider",
            Self::Sensor => "sensor",
        }
    }
}

/// One parameter of a mechanism.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Param {
    /// With its unit at the end.
    pub name: &'static str,
    /// Value at which the mechanism is absent; not a number: the bicycle's own value of `symbol`.
    pub null: f64,
    /// Physical bounds; a sign bound is one of them.
    pub least: f64,
    pub most: f64,
    /// Size of the first probe, away from null towards the allowed side.
    pub probe: f64,
    /// Where a fit starts, beside the linear estimate: lags and delays have several optima.
    pub starts: &'static [f64],
    pub about: &'static str,
}

/// What a study must have, beyond lateral outputs, before a mechanism can be looked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Requirement {
    /// A channel that is used or looked at.
    Channel(crate::Quantity),
    /// An input that drives the model, and that varies.
    Input(crate::Quantity),
    /// An output that is compared.
    Output(crate::Quantity),
    /// The rider's hands hold the bar.
    HandsOn,
    /// Someone sits on the bicycle.
    Rider,
    /// A known feedback law.
    Law,
    Road,
    Treadmill,
    /// The speed is predicted, not prescribed.
    PredictedSpeed,
    /// The speed varies by this ratio (highest over lowest ride mean).
    SpeedRange(f64),
}

/// Everything that is written about a mechanism.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Card {
    pub name: &'static str,
    pub family: Family,
    /// Equations whose residual it explains, the first one most.
    pub equations: &'static [Equation],
    /// What it says about the bicycle.
    pub claim: &'static str,
    pub equation: &'static str,
    pub source: &'static str,
    pub parameters: &'static [Param],
    pub requires: &'static [Requirement],
    pub confounded_with: &'static [&'static str],
    /// The experiment that separates it from those.
    pub separated_by: &'static str,
}

impl std::fmt::Display for Card {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        writeln!(f, "mechanism {}: {}", self.name, self.claim)?;
        writeln!(f, "Equation: {}", self.equation)?;
        writeln!(f, "Source: {}", self.source)?;
        let equations: Vec<&str> = self.equations.iter().map(|e| e.name()).collect();
        writeln!(f, "Acts on: {}", equations.join(", "))?;
        for p in self.parameters {
            let null = if p.null.is_nan() {
                "the bicycle's own".to_owned()
            } else {
                p.null.to_string()
            };
            writeln!(
                f,
                "  {} (absent: {null}; {} to {}): {}",
                p.name, p.least, p.most, p.about
            )?;
        }
        let with = if self.confounded_with.is_empty() {
            "nothing in the list".to_owned()
        } else {
            self.confounded_with.join(", ")
        };
        writeln!(f, "Confounded with: {with}")?;
        write!(f, "Separated by: {}", self.separated_by)
    }
}
