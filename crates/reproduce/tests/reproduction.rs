//! The committed table is what the command computes, enough rows agree, and the thesis's own method
//! agrees with linearisation.

use twinhub_plant::multibody::Course;
use twinhub_reproduce::method::TRIALS;
use twinhub_reproduce::{Assumed, IDS, push, reproduce, stability};

const COMMITTED: &str = include_str!("../reproduction.md");

/// The rows without the search for what moves the misses, which takes a minute of its own.
fn quick() -> Assumed {
    Assumed {
        explain_misses: false,
        ..Assumed::default()
    }
}

#[test]
fn the_committed_table_is_what_comes_out() {
    let all: Vec<String> = IDS.iter().map(|id| (*id).to_owned()).collect();
    let found = reproduce(&quick(), &all, 2, &|_, _| {}).unwrap();
    assert_eq!(
        found.rows.iter().map(|r| r.id).collect::<Vec<_>>(),
        IDS,
        "no row is left out"
    );
    let table = found.table();
    for line in table.lines() {
        assert!(COMMITTED.contains(line), "not in reproduction.md: {line}");
    }
    assert!(
        found.agreeing() >= 14,
        "{} rows agree:\n{table}",
        found.agreeing()
    );
    let words = format!("**{} of {} rows agree**", found.agreeing(), IDS.len());
    assert!(COMMITTED.contains(&words), "reproduction.md lacks {words}");
    assert!(COMMITTED.contains(&found.assumed.to_string()));
    // Each miss says what would meet it, or that nothing in range does.
    for row in found.rows.iter().filter(|r| r.missed()) {
        let note = COMMITTED
            .lines()
            .find(|l| l.starts_with(&format!("* **{}**", row.id)))
            .unwrap_or_else(|| panic!("{} has no note", row.id));
        assert!(
            note.contains("met with") || note.contains("meets it"),
            "{note}"
        );
    }
}

#[test]
fn only_what_is_asked_for_is_computed() {
    let only = ["case1_capsize".to_owned()];
    let found = reproduce(&quick(), &only, 1, &|done, of| {
        assert!(done == 1 && of == 1)
    })
    .unwrap();
    assert_eq!(found.rows.len(), 1);
    assert_eq!(found.rows[0].id, "case1_capsize");
    assert!(found.method.is_empty());
}

/// Half a percent below the weave speed of the linearised model the fitted weave mode grows, half a
/// percent above it decays: so the speeds of both methods lie within half a percent.
#[test]
fn four_poles_and_linearisation_agree_on_weave_speed() {
    let assumed = Assumed::default();
    for trial in TRIALS {
        let p = trial.parameters(&assumed).unwrap();
        let course = trial.course();
        let weave = stability::critical(&p, &course)
            .unwrap()
            .weave_m_s
            .expect("a weave speed");
        let growth = |factor: f64| {
            let at = Course {
                speed_m_s: factor * weave,
                ..course
            };
            push::weave(&p, &at).unwrap().expect("an oscillation").re
        };
        let (below, above) = (growth(0.995), growth(1.005));
        println!(
            "{}: weave at {weave:.3} m/s; fitted growth {below:+.4} below, {above:+.4} above",
            trial.name
        );
        assert!(
            below > 0.0 && above < 0.0,
            "{}: {below} and {above}",
            trial.name
        );
    }
}

/// Without slip and with a rigid rider the model has four lateral states: the fit finds its poles.
#[test]
fn four_poles_of_the_benchmark_are_its_eigenvalues() {
    let p = TRIALS[0].parameters(&Assumed::default()).unwrap();
    let bicycle = twinhub_linear::Bicycle::load("meijaard2007_benchmark").unwrap();
    let linear = twinhub_linear::Canonical::new(&bicycle).unwrap();
    for v in [4.0, 5.0, 6.5] {
        let record = push::Record::of(&p, &Course::straight(v)).unwrap();
        let found = record.four_poles().unwrap();
        for wanted in linear.eigenvalues(v, twinhub_linear::MotorPair::OFF) {
            let error = |p: &nalgebra::Complex<f64>| (p - wanted).norm_sqr().sqrt();
            let nearest = found.poles.iter().map(error).fold(f64::INFINITY, f64::min);
            println!("{v} m/s: {wanted}, off by {nearest:.1e}");
            assert!(
                nearest < 1.0e-3 * (1.0 + wanted.norm_sqr().sqrt()),
                "{v} m/s: {wanted}: {:?}",
                found.poles
            );
        }
    }
}
