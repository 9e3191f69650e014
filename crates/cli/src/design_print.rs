//! What `twinhub design` prints: text, a page.

use twinhub_design::certificate::{Certificate, Stop};
use twinhub_design::check;
use twinhub_design::summary::worst;
use twinhub_report::design::DesignPage;

fn because(stop: &Stop) -> String {
    if stop.because.is_empty() {
        "no single uncertainty".to_owned()
    } else {
        stop.because.join(", or ")
    }
}

/// The answer as text.
pub fn print(certificate: &Certificate) {
    let plan = &certificate.plan;
    let proved = check::stretches(&certificate.schedule, &certificate.cells);
    let (growth, loss) = (
        worst(certificate, |n| n.growth_per_s),
        worst(certificate, |n| n.loss_growth_per_s),
    );
    println!("{}: proved {}", plan.bicycle, check::in_words(&proved));
    println!("\n  speed    pair   tube            growth   after a loss   below it");
    println!("    m/s      Nm     Nm               1/s            1/s");
    for (k, point) in certificate.schedule.iter().enumerate() {
        let cell = match k.checked_sub(1).map(|c| certificate.cells[c]) {
            None => "",
            Some(true) => "proved",
            Some(false) => "not proved",
        };
        println!(
            "  {:5.2}  {:6.1}  {:5.1} to {:5.1}  {:8.2}  {:13.2}   {cell}",
            point.speed_m_s, point.torque_nm, point.from_nm, point.to_nm, growth[k], loss[k],
        );
    }
    for stop in &certificate.stops {
        let because = because(stop);
        let [from, to] = stop.speeds_m_s;
        println!(
            "\n{from} to {to} m/s, rider {}: stopped by {because}",
            stop.rider
        );
    }
}

/// The answer as a page.
pub fn page(certificate: &Certificate) -> DesignPage {
    let plan = &certificate.plan;
    let proved = check::stretches(&certificate.schedule, &certificate.cells);
    let of = |value: fn(&twinhub_design::certificate::Point) -> f64| -> Vec<f64> {
        certificate.schedule.iter().map(value).collect()
    };
    let most_nm = of(|p| p.torque_nm).into_iter().fold(0.0, f64::max);
    let riders: Vec<&str> = plan.riders.iter().map(|e| e.rider.name.as_str()).collect();
    let range = |[a, b]: [f64; 2]| format!("{a} to {b} times");
    let asked = [
        ("mass", range(plan.uncertainty.mass)),
        ("tyre load", range(plan.uncertainty.load)),
        ("twisting torque", range(plan.uncertainty.twisting)),
        ("boxes", certificate.pieces.len().to_string()),
        (
            "half the width of the tube",
            format!("{} Nm", plan.half_width_nm),
        ),
        (
            "fastest change of speed",
            format!("{} m/s²", plan.rate_m_s2),
        ),
        ("largest pair", format!("{} Nm", plan.torque_max_nm)),
    ];
    DesignPage {
        lead: format!("{}; riders {}", plan.bicycle, riders.join(", ")),
        sentence: format!(
            "Proved {}; the largest pair is {most_nm:.1} Nm.",
            check::in_words(&proved)
        ),
        good: most_nm > 0.0 && !proved.is_empty(),
        speeds_m_s: of(|p| p.speed_m_s),
        torque_nm: of(|p| p.torque_nm),
        from_nm: of(|p| p.from_nm),
        to_nm: of(|p| p.to_nm),
        growth_per_s: worst(certificate, |n| n.growth_per_s),
        loss_growth_per_s: worst(certificate, |n| n.loss_growth_per_s),
        loss_limit_per_s: plan.loss_growth_per_s,
        stops: (certificate.stops.iter())
            .map(|s| {
                let [from, to] = s.speeds_m_s.map(|v| format!("{v:.2}"));
                [from, to, s.rider.clone(), because(s)]
            })
            .collect(),
        proved_m_s: proved,
        plan: asked.map(|(name, value)| [name.to_owned(), value]).to_vec(),
    }
}
