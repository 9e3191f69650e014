//! What a league came to: as text, JSON and page.

use serde_json::json;
use twinhub_league::frontier::reference;
use twinhub_league::harm::MARGIN;
use twinhub_league::{Cell, Estimate, Part, Row, Spec, frontier, harm, table};
use twinhub_report::league::{Dot, LeaguePage, league_page};

/// Controllers that are there to be compared with, not to be sold: the thesis's constant pair at its
/// full size, and those that use another actuator or show what does not work.
const COMPARATORS: [&str; 5] = [
    "constant",
    "constant_80_nm",
    "roll_steer_feedback",
    "steering_spring",
    "steering_motor",
];

/// True for a controller that is meant to be ridden with.
pub fn is_ours(controller: &str) -> bool {
    !COMPARATORS.contains(&controller)
}

/// Everything, for programs.
pub fn to_json(spec: &Spec, parts: &[Part]) -> serde_json::Value {
    json!({
        "schema_version": 1,
        "seed": spec.seed,
        "riders": spec.riders,
        "classes": spec.classes,
        "duration_s": spec.duration_s,
        "bicycle": spec.bicycle,
        "controllers": spec.controllers.iter().map(|c| json!({"name": c.name, "profile": c.law.profile})).collect::<Vec<_>>(),
        "parts": parts.len(),
        "parts_missing": spec.parts() - parts.len() as u64,
        "rows": table(spec, parts),
        "reference": reference(spec).map(|i| spec.controllers[i].name.clone()),
        "frontier": frontier(spec, parts),
        "harm_margin": MARGIN,
        "harm": harm(spec, parts),
    })
}

fn estimate(e: Option<Estimate>, scale: f64, digits: usize) -> String {
    e.map_or("-".to_owned(), |e| {
        let [low, high] = e.ci95.map(|x| x * scale);
        format!(
            "{:.digits$} ({low:.digits$} to {high:.digits$})",
            e.value * scale
        )
    })
}

const COLUMNS: [&str; 10] = [
    "controller",
    "riders",
    "rides",
    "falls/1000 km",
    "effort, Nm",
    "roll rms, deg",
    "worst 1 % roll, deg",
    "bar rms, deg/s",
    "swing shift, Hz",
    "energy, Wh/km",
];

fn cells(row: &Row) -> Vec<String> {
    let degrees = 180.0 / std::f64::consts::PI;
    vec![
        row.controller.clone(),
        row.class.to_owned(),
        row.rides.to_string(),
        estimate(row.falls_per_1000_km, 1.0, 0),
        estimate(row.rider_effort_rms_nm, 1.0, 3),
        estimate(row.roll_rms_rad, degrees, 2),
        estimate(row.roll_worst_1_percent_rad, degrees, 1),
        estimate(row.steer_rate_rms_rad_s, degrees, 1),
        estimate(row.swing_shift_hz, 1.0, 2),
        estimate(row.energy_wh_per_km, 1.0, 2),
    ]
}

fn verdicts(cells: &[Cell]) -> [usize; 3] {
    ["no worse", "worse", "undecided"]
        .map(|verdict| cells.iter().filter(|c| c.verdict == verdict).count())
}

/// The result in a sentence, and whether it is good.
fn sentence(spec: &Spec, parts: &[Part], cells: &[Cell]) -> (bool, String) {
    let points = frontier(spec, parts);
    let best = points
        .iter()
        .filter(|p| is_ours(&p.controller) && p.controller != "off")
        .filter_map(|p| Some((p, p.effort_share?, p.energy_share?)))
        .max_by(|a, b| a.1.value.total_cmp(&b.1.value));
    let worse: Vec<&Cell> = cells
        .iter()
        .filter(|c| c.verdict == "worse" && is_ours(&c.controller))
        .collect();
    let harm = if worse.is_empty() {
        "no cell of riders, speed and surface is shown to fall more".to_owned()
    } else {
        format!(
            "{} cells of riders, speed and surface fall more",
            worse.len()
        )
    };
    let text = match (best, reference(spec)) {
        (Some((p, effort, energy)), Some(r)) => format!(
            "{} saves {:.0} % of the steering effort that {} saves, for {:.0} % of its energy; {harm}",
            p.controller,
            100.0 * effort.value,
            spec.controllers[r].name,
            100.0 * energy.value
        ),
        _ => harm,
    };
    (worse.is_empty(), text)
}

/// The tables as text.
pub fn print(spec: &Spec, parts: &[Part]) {
    let rows = table(spec, parts);
    println!(
        "{} riders of each class, seed {}, {} s each; {} of {} parts\n",
        spec.riders,
        spec.seed,
        spec.duration_s,
        parts.len(),
        spec.parts()
    );
    let width = spec
        .controllers
        .iter()
        .map(|c| c.name.len())
        .max()
        .unwrap_or(0);
    println!(
        "{:width$}  {:10} {:>5} {:>22} {:>24} {:>22} {:>26}",
        COLUMNS[0], COLUMNS[1], COLUMNS[2], COLUMNS[3], COLUMNS[4], COLUMNS[5], COLUMNS[9]
    );
    let mut last = "";
    for row in &rows {
        if !last.is_empty() && last != row.class {
            println!();
        }
        last = row.class;
        let c = cells(row);
        println!(
            "{:width$}  {:10} {:>5} {:>22} {:>24} {:>22} {:>26}",
            c[0], c[1], c[2], c[3], c[4], c[5], c[9]
        );
    }
    if let Some(r) = reference(spec) {
        println!(
            "\nriders who give torque, as shares of {}",
            spec.controllers[r].name
        );
        println!(
            "{:width$}  {:>24} {:>24} {:>24}",
            "", "effort saved", "falls saved", "energy"
        );
        for p in frontier(spec, parts) {
            println!(
                "{:width$}  {:>24} {:>24} {:>24}{}",
                p.controller,
                estimate(p.effort_share, 1.0, 2),
                estimate(p.falls_share, 1.0, 2),
                estimate(p.energy_share, 1.0, 2),
                if p.on_frontier {
                    "  on the frontier"
                } else {
                    ""
                }
            );
        }
    }
    let cells = harm(spec, parts);
    let [no_worse, worse, undecided] = verdicts(&cells);
    println!(
        "\nfalls against riding without, by class, speed and surface: {no_worse} cells no worse (within \
         {:.0} %), {worse} worse, {undecided} with too few rides to tell",
        100.0 * MARGIN
    );
    for cell in cells.iter().filter(|c| c.verdict == "worse") {
        println!("  worse: {}", in_words(cell));
    }
    println!("\n{}", sentence(spec, parts, &cells).1);
}

fn in_words(cell: &Cell) -> String {
    format!(
        "{}, {}, {} to {} m/s, {}: {} of {} rides fall, {} without",
        cell.controller,
        cell.class,
        cell.speeds_m_s[0],
        cell.speeds_m_s[1].floor(),
        cell.surface,
        cell.falls_with,
        cell.rides,
        cell.falls_without
    )
}

/// The page.
pub fn to_page(spec: &Spec, parts: &[Part]) -> String {
    let found = harm(spec, parts);
    let (good, sentence) = sentence(spec, parts, &found);
    let dots = frontier(spec, parts)
        .into_iter()
        .filter_map(|p| {
            Some(Dot {
                energy_wh_per_km: p.energy_wh_per_km?,
                effort_saved_nm: p.effort_saved_nm?,
                name: p.controller,
                on_frontier: p.on_frontier,
            })
        })
        .collect();
    let shares = frontier(spec, parts)
        .into_iter()
        .filter(|p| p.effort_share.is_some())
        .map(|p| {
            [
                p.controller,
                estimate(p.effort_share, 1.0, 2),
                estimate(p.falls_share, 1.0, 2),
                estimate(p.energy_share, 1.0, 2),
            ]
        })
        .collect();
    let listed = found
        .iter()
        .filter(|c| c.verdict != "no worse" && is_ours(&c.controller))
        .map(|c| {
            [
                c.controller.clone(),
                c.class.to_owned(),
                format!("{} to {}", c.speeds_m_s[0], c.speeds_m_s[1].floor()),
                c.surface.to_owned(),
                c.rides.to_string(),
                c.falls_without.to_string(),
                c.falls_with.to_string(),
                format!(
                    "{:.3} ({:.3} to {:.3})",
                    c.difference, c.interval[0], c.interval[1]
                ),
                c.verdict.to_owned(),
            ]
        })
        .collect();
    league_page(&LeaguePage {
        lead: format!(
            "{} riders of each class, seed {}, {} s each, bicycle {}",
            spec.riders, spec.seed, spec.duration_s, spec.bicycle
        ),
        good,
        sentence,
        dots,
        columns: COLUMNS.map(str::to_owned).to_vec(),
        rows: table(spec, parts).iter().map(cells).collect(),
        shares,
        cells: listed,
        counts: verdicts(&found),
        notes: vec![
            "95 % intervals in brackets. Effort, roll, bar and swing are means over the rides that stay up \
             with every controller; falls and energy over all rides."
                .into(),
        ],
    })
}
