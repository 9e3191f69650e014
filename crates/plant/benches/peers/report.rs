//! Table, verdicts, JSON.

use crate::measure::Cost;
use crate::rows::{Bench, STEP_S};
use serde_json::{Value, json};

/// One target, and whether it is met.
struct Verdict {
    target: &'static str,
    /// What was measured; none where a peer or valgrind was missing.
    found: Option<f64>,
    required: f64,
    goal: f64,
    /// Whether less is better.
    at_most: bool,
    unit: &'static str,
}

impl Verdict {
    fn reaches(&self, limit: f64) -> Option<bool> {
        self.found
            .map(|v| if self.at_most { v <= limit } else { v >= limit })
    }

    fn word(&self) -> &'static str {
        match (self.reaches(self.required), self.reaches(self.goal)) {
            (None, _) => "not measured",
            (_, Some(true)) => "met, goal too",
            (Some(true), _) => "met",
            (Some(false), _) => "missed",
        }
    }
}

/// What came out.
pub struct Answer<'a> {
    bench: &'a Bench,
    costs: &'a [Cost],
    verdicts: Vec<Verdict>,
    processor: String,
}

fn processor() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    text.lines()
        .find_map(|line| line.strip_prefix("model name")?.split_once(": "))
        .map_or_else(
            || "unknown processor".to_owned(),
            |(_, name)| name.trim().to_owned(),
        )
}

fn real_time_factor(cost: &Cost) -> f64 {
    STEP_S / (1e-9 * cost.least_ns)
}

impl<'a> Answer<'a> {
    pub fn new(bench: &'a Bench, costs: &'a [Cost]) -> Self {
        let cost = |name: &str| {
            bench
                .rows
                .iter()
                .position(|row| row.name == name)
                .map(|k| costs[k])
        };
        let least = |names: [&str; 2]| {
            names
                .iter()
                .filter_map(|n| cost(n))
                .min_by(|a, b| a.least_ns.total_cmp(&b.least_ns))
        };
        let rhs = cost("rhs").expect("our own row");
        let aba = least(["pinocchio_aba", "pinocchio_aba_world"]);
        let lanes = least(["step_4_lanes", "step_8_lanes"]);
        let verdicts = vec![
            Verdict {
                target: "right-hand side over Pinocchio's aba, time",
                found: aba.map(|aba| rhs.least_ns / aba.least_ns),
                required: 0.5,
                goal: 0.25,
                at_most: true,
                unit: "",
            },
            Verdict {
                target: "right-hand side",
                found: rhs.instructions,
                required: 8000.0,
                goal: 4800.0,
                at_most: true,
                unit: "instructions",
            },
            Verdict {
                target: "plant at 1 ms RK4, one core",
                found: cost("step").map(|c| real_time_factor(&c)),
                required: 250.0,
                goal: 450.0,
                at_most: false,
                unit: "times real time",
            },
            Verdict {
                target: "the same, scenarios in lanes",
                found: lanes.map(|c| real_time_factor(&c)),
                required: 1000.0,
                goal: 2200.0,
                at_most: false,
                unit: "times real time",
            },
        ];
        Self {
            bench,
            costs,
            verdicts,
            processor: processor(),
        }
    }

    /// Whether every target that could be measured is met and every peer computes the same.
    pub fn all_met(&self) -> bool {
        let same = self.bench.peers.iter().all(|peer| {
            peer.found
                .as_ref()
                .map_or(true, |(_, difference)| *difference <= peer.accepted)
        });
        same && self
            .verdicts
            .iter()
            .all(|v| v.reaches(v.required) != Some(false))
    }

    pub fn print(&self) {
        println!("{}", self.processor);
        println!(
            "{:38} {:>9} {:>9} {:>12} {:>10}",
            "per result", "least ns", "median", "instructions", "real time"
        );
        for (row, cost) in self.bench.rows.iter().zip(self.costs) {
            let instructions = cost
                .instructions
                .map_or("-".to_owned(), |n| format!("{n:.0}"));
            let factor = if row.name.contains("step") {
                format!("{:.0} x", real_time_factor(cost))
            } else {
                String::new()
            };
            println!(
                "{:38} {:9.1} {:9.1} {:>12} {:>10}",
                row.about, cost.least_ns, cost.median_ns, instructions, factor
            );
        }
        println!(
            "our step is divided into {} part(s) at this speed",
            self.bench.parts
        );
        for peer in &self.bench.peers {
            match &peer.found {
                Ok((version, difference)) => println!(
                    "{} {version}: difference to ours {difference:.1e} ({}), at most {:.0e} accepted: {}",
                    peer.name,
                    peer.what,
                    peer.accepted,
                    if *difference <= peer.accepted {
                        "the same physics"
                    } else {
                        "NOT the same"
                    }
                ),
                Err(why) => println!("{}: NOT COMPARED: {why}", peer.name),
            }
        }
        for v in &self.verdicts {
            let found = v.found.map_or("-".to_owned(), |f| {
                if f < 10.0 {
                    format!("{f:.2}")
                } else {
                    format!("{f:.0}")
                }
            });
            println!(
                "{:44} {found:>6} {} ({} {}, goal {}): {}",
                v.target,
                v.unit,
                if v.at_most { "at most" } else { "at least" },
                v.required,
                v.goal,
                v.word()
            );
        }
    }

    pub fn json(&self) -> Value {
        let rows: Vec<Value> = self
            .bench
            .rows
            .iter()
            .zip(self.costs)
            .map(|(row, cost)| {
                json!({
                    "id": row.name,
                    "about": row.about,
                    "lanes": row.results,
                    "least_ns": cost.least_ns,
                    "median_ns": cost.median_ns,
                    "instructions": cost.instructions,
                    "real_time_factor": row.name.contains("step").then(|| real_time_factor(cost)),
                })
            })
            .collect();
        let peers: Vec<Value> = self
            .bench
            .peers
            .iter()
            .map(|peer| {
                let (version, difference, missing) = match &peer.found {
                    Ok((version, difference)) => (Some(version), Some(difference), None),
                    Err(why) => (None, None, Some(why)),
                };
                json!({
                    "name": peer.name,
                    "version": version,
                    "difference": difference,
                    "accepted_difference": peer.accepted,
                    "difference_of": peer.what,
                    "missing_because": missing,
                })
            })
            .collect();
        let verdicts: Vec<Value> = self
            .verdicts
            .iter()
            .map(|v| {
                json!({
                    "target": v.target,
                    "found": v.found,
                    "required": v.required,
                    "goal": v.goal,
                    "unit": v.unit,
                    "verdict": v.word(),
                })
            })
            .collect();
        json!({
            "schema_version": 1,
            "processor": self.processor,
            "parts_of_a_step": self.bench.parts,
            "rows": rows,
            "peers": peers,
            "verdicts": verdicts,
        })
    }
}
