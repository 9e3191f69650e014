//! Loads, slip and friction as the controller believes them, against the plant's, with sensors as bought.

use crate::lay_road;
use twinhub_control::belief::{Belief, Believer, FRICTION_MEMORY_S, NEVER_S};
use twinhub_plant::road::{Patch, Road};
use twinhub_sim::{Ride, Stepped, Stepper};
use twinhub_types::Instant;

/// When the speed begins to change, and the slippery spot begins, s.
const CHANGE_S: f64 = 3.0;

fn set(speed: &str, seed: u64, more: &[&str]) -> Vec<String> {
    let mut set = vec![
        "sensors=\"as_bought\"".to_owned(),
        "duration_s=8.0".to_owned(),
        format!("seed={seed}"),
        format!("speed={speed}"),
    ];
    set.extend(more.iter().map(|s| (*s).to_owned()));
    set
}

/// What is believed after a tick.
fn believe(believer: &mut Believer, step: &Stepped) -> Belief {
    let now = Instant::from_nanos(step.told.header.time_ns);
    let estimate = &step.output.estimate;
    *believer.update(now, &step.told.measurement, &step.told.intent, estimate)
}

#[test]
fn loads_move_with_acceleration_and_their_uncertainty_is_honest() {
    let (mut squares, mut count) = ([0.0f64; 2], 0.0);
    let (mut least_n, mut most_n) = (f64::INFINITY, 0.0f64);
    for seed in 1..=20 {
        let speed = "[{t_s=0.0,speed_m_s=7.0},{t_s=3.0,speed_m_s=7.0},{t_s=5.0,speed_m_s=3.5}]";
        let ride =
            Ride::load("three_to_eight", &set(speed, seed, &["law=\"off\""])).expect("a ride");
        let mut stepper = Stepper::new(&ride).expect("starts");
        // The plant's loads bounce: their mean over a quarter of a second is what is asked for.
        let mut mean = [0.0f64; 2];
        let mut believer = Believer::new(&ride.law.bicycle);
        while let Some(step) = stepper.step(None) {
            let belief = believe(&mut believer, &step);
            let truth = [step.truth.front_load_n, step.truth.rear_load_n];
            for (mean, truth) in mean.iter_mut().zip(truth) {
                *mean += (truth - *mean) * 0.001 / 0.1;
            }
            let t_s = stepper.time_s();
            if t_s < 1.0 || !((t_s * 1000.0).round() as u64).is_multiple_of(500) {
                continue;
            }
            let known = [belief.front_load_n, belief.rear_load_n];
            for ((square, known), truth) in squares.iter_mut().zip(known).zip(mean) {
                assert!(known.age_s < 0.05, "{known:?}");
                let error = (f64::from(known.value) - truth) / f64::from(known.sd);
                *square += error * error;
            }
            count += 1.0;
            least_n = least_n.min(f64::from(known[0].value));
            most_n = most_n.max(f64::from(known[0].value));
        }
        assert!(!stepper.fell());
    }
    let [front, rear] = squares.map(|s| s / count);
    println!(
        "front load from {least_n:.0} to {most_n:.0} N; squared error by claimed variance: {front:.2} front, {rear:.2} rear"
    );
    assert!(
        most_n - least_n > 60.0,
        "braking moves load: {least_n} to {most_n} N"
    );
    for ratio in [front, rear] {
        assert!(
            (0.2..2.0).contains(&ratio),
            "squared error by claimed variance: {ratio}"
        );
    }
}

#[test]
fn friction_is_unknown_until_a_wheel_slips_and_then_less_than_what_was_asked() {
    let mut found = vec![];
    for friction_ratio in [0.15, 0.3] {
        for seed in 1..=6 {
            let more = ["law=\"constant_80_nm\"", "law.limits.ramp_up_nm_s=50.0"];
            let speed = "[{t_s=0.0,speed_m_s=5.0}]";
            let mut ride = Ride::load("three_to_eight", &set(speed, seed, &more)).expect("a ride");
            let start_m = 5.0 * CHANGE_S;
            let mut road = Road::level(1.0);
            road.patches = vec![Patch {
                x_m: [start_m, start_m + 4.0],
                y_m: None,
                friction_ratio,
                edge_m: 0.05,
            }];
            lay_road(&mut ride, road);
            let mut stepper = Stepper::new(&ride).expect("starts");
            let mut told = None;
            let mut believer = Believer::new(&ride.law.bicycle);
            while let Some(step) = stepper.step(None) {
                let belief = believe(&mut believer, &step);
                let t_s = stepper.time_s();
                if t_s < CHANGE_S - 0.5 {
                    assert!(
                        belief.friction_ratio.is_none(),
                        "nothing has slipped: {belief:?}"
                    );
                    let slip = f64::from(belief.front_slip_ratio.value);
                    let error = slip - step.truth.front_slip_ratio;
                    assert!(
                        t_s < 1.0 || error.abs() < 5.0 * f64::from(belief.front_slip_ratio.sd),
                        "slip {slip}, is {}",
                        step.truth.front_slip_ratio
                    );
                }
                told = belief.friction_ratio.or(told);
                assert_eq!(
                    belief.road_lean_rad.age_s, NEVER_S,
                    "no sensor feels the road"
                );
            }
            let told = told.expect("a wheel slips");
            assert!(told.age_s <= FRICTION_MEMORY_S);
            found.push((friction_ratio, f64::from(told.value), f64::from(told.sd)));
        }
    }
    println!("road, believed, standard deviation: {found:.2?}");
    for (truth, value, sd) in &found {
        assert!(
            (value - truth).abs() < 2.0 * sd,
            "road {truth}, believed {value} ({sd})"
        );
        assert!(
            value + 1.8 * sd < 1.0,
            "a slip under 80 Nm says less than a dry road: {value} ({sd})"
        );
    }
}
