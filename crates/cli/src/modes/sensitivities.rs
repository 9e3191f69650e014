//! How the weave speed hangs on every parameter.

use anyhow::anyhow;
use serde_json::{Value, json};
use twinhub_linear::{ModeName, Modes};
use twinhub_plant::multibody::{Course, Multibody, SpeedSensitivity, unit};

/// Most rows of the printed table.
const MOST_ROWS: usize = 30;

/// Sensitivities of the weave speed, largest effect per relative change first.
pub struct Sensitivities {
    speed_m_s: f64,
    found: SpeedSensitivity,
}

/// Works them out at the weave speed.
pub fn compute(model: &Multibody, course: &Course, modes: &Modes) -> anyhow::Result<Sensitivities> {
    let speed_m_s = modes.weave_speed_m_s().ok_or_else(|| {
        anyhow!(
            "--sensitivities: weave changes its stability nowhere in this range of speeds \
             ({}); accepted: a range that holds the weave speed",
            modes.weave.as_str()
        )
    })?;
    let at = Course {
        speed_m_s,
        ..*course
    };
    let mut found = model.speed_sensitivities(&at, ModeName::Weave)?;
    found.parameters.sort_by(|a, b| {
        let effect = |p: &twinhub_plant::multibody::Sensitivity| p.relative().re.abs();
        effect(b).total_cmp(&effect(a))
    });
    Ok(Sensitivities { speed_m_s, found })
}

impl Sensitivities {
    /// As part of the answer.
    pub fn json(&self) -> Value {
        let parameters: Vec<Value> = self
            .found
            .parameters
            .iter()
            .map(|p| {
                let speed = self.found.speed_per_unit(p);
                json!({
                    "path": p.path,
                    "value": p.value,
                    "unit": unit(&p.path),
                    "eigenvalue_per_unit": [p.per_unit.re, p.per_unit.im],
                    "weave_speed_m_s_per_unit": speed,
                    "weave_speed_m_s_per_percent": 0.01 * speed * p.value,
                })
            })
            .collect();
        let (value, per_speed) = (self.found.eigenvalue, self.found.per_speed);
        json!({
            "mode": "weave",
            "speed_m_s": self.speed_m_s,
            "eigenvalue": [value.re, value.im],
            "eigenvalue_per_m_s": [per_speed.re, per_speed.im],
            "parameters": parameters,
        })
    }

    /// As a table.
    pub fn print(&self) {
        println!(
            "Sensitivity of the weave speed ({:.3} m/s), largest first:",
            self.speed_m_s
        );
        println!("  m/s per unit   m/s per 1 %   parameter");
        for p in self.found.parameters.iter().take(MOST_ROWS) {
            let speed = self.found.speed_per_unit(p);
            println!(
                "  {speed:12.4}  {:12.5}   {} = {} {}",
                0.01 * speed * p.value,
                p.path,
                p.value,
                unit(&p.path)
            );
        }
        if self.found.parameters.len() > MOST_ROWS {
            eprintln!(
                "note: {MOST_ROWS} of {} parameters are shown; --json has all",
                self.found.parameters.len()
            );
        }
    }
}
