//! Plant, rider, sensors, motors and controller in one loop, in process.

use std::path::Path;
use twinhub_link::{ControllerPort, InProcess, LinkError};
use twinhub_log::{CONTROL_OUTPUT, LogFile, PLANT_TRUTH, SENSOR_MEASUREMENT};
use twinhub_sim::{Ending, Outcome, Ride, RideError, Settings};
use twinhub_types::{ControllerFrame, PlantFrame};

fn load(assignments: &[&str]) -> Ride {
    let assignments: Vec<String> = assignments.iter().map(|s| (*s).to_owned()).collect();
    Ride::load("first_ride", &assignments).expect("ships")
}

fn settings(log: Option<&Path>) -> Settings {
    Settings {
        log: log.map(Path::to_owned),
        version: "test".into(),
        git_hash: "test".into(),
    }
}

fn ride_with(
    ride: &Ride,
    log: &Path,
    port: &mut impl ControllerPort,
) -> Result<Outcome, RideError> {
    twinhub_sim::ride(ride, &settings(Some(log)), port, &mut |_| true)
}

fn ride(ride: &Ride, log: &Path) -> (Outcome, LogFile) {
    let mut port = InProcess::new(twinhub_sim::in_process(&ride.law));
    let outcome = ride_with(ride, log, &mut port).expect("rides");
    (outcome, twinhub_log::read(log).expect("reads back"))
}

#[test]
fn the_first_course_is_ridden_with_and_without_the_pair_by_the_same_rider() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let course = load(&[]);
    for on in [false, true] {
        let (outcome, log) = ride(
            &course.with_stabilizer(on),
            &dir.path().join(format!("{on}.mcap")),
        );
        assert_eq!(outcome.ending, Ending::Finished, "stabilizer {on}");
        assert_eq!(outcome.metrics.ticks, 60_000);
        let torque = log.column(PLANT_TRUTH, "front_brake_nm").expect("logged");
        let most = torque.iter().copied().fold(0.0, f64::max);
        if on {
            assert!(
                most > 30.0 && most <= 40.0,
                "the pair reaches its schedule: {most} Nm"
            );
            assert!(outcome.metrics.energy_j > 0.0);
        } else {
            assert_eq!(most, 0.0);
            assert_eq!(outcome.metrics.energy_j, 0.0);
        }
        let roll = log.column(PLANT_TRUTH, "roll_rad").expect("logged");
        let worst = roll.iter().fold(0.0, |w: f64, r| w.max(r.abs()));
        assert!(
            worst > 0.005,
            "the disturbances reach the bicycle: {worst} rad"
        );
        log.verify()
            .expect("the digest of the file is the digest of its records");
        twinhub_log::check_layouts(&log).expect("every path in the shipped layouts is in the log");
    }
}

/// The course on the multibody plant.
fn multibody(assignments: &[&str]) -> Result<Ride, twinhub_sim::SetupError> {
    let assignments: Vec<String> = assignments.iter().map(|s| (*s).to_owned()).collect();
    Ride::load("three_to_eight", &assignments)
}

#[test]
fn from_3_to_8_m_s_on_tyres_one_rider_stays_up_without_and_with_the_pair() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let course = multibody(&[]).expect("ships");
    for on in [false, true] {
        let path = dir.path().join(format!("{on}.mcap"));
        let (outcome, log) = ride(&course.with_stabilizer(on), &path);
        assert_eq!(outcome.ending, Ending::Finished, "stabilizer {on}");
        let column = |name: &str| log.column(PLANT_TRUTH, name).expect("logged");
        let speed = column("speed_m_s");
        assert!((speed[0] - 3.0).abs() < 0.01 && (speed[speed.len() - 1] - 8.0).abs() < 0.3);
        let most = column("front_brake_nm").iter().copied().fold(0.0, f64::max);
        assert_eq!(most > 15.0, on, "{most} Nm");
        let worst = |name: &str| column(name).iter().fold(0.0, |w: f64, r| w.max(r.abs()));
        assert!(
            worst("roll_rad") > 0.005,
            "the disturbances reach the bicycle"
        );
        assert!(worst("trunk_lean_rad") > 1e-5 && worst("right_leg_rad") > 1e-6);
        assert!(
            worst("rear_slip_ratio") > 1e-4,
            "it stands on tyres that slip"
        );
        twinhub_log::check_layouts(&log).expect("every path in the shipped layouts is in the log");
    }
}

#[test]
fn every_part_of_a_course_can_be_written_out_and_set() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let plain = multibody(&["duration_s=4"]).expect("ships");
    let run = |assignments: &[&str]| {
        let mut all = vec!["duration_s=4"];
        all.extend(assignments);
        let course = multibody(&all).unwrap_or_else(|e| panic!("{assignments:?}: {e}"));
        // What the log holds is the ride again, bit for bit.
        let again: Ride = toml::from_str(&course.to_toml()).expect("reads back");
        assert_eq!(again, course, "{assignments:?}");
        ride(&course, &dir.path().join("log")).0
    };
    let reference = run(&[]).digest;
    assert_eq!(reference, ride(&plain, &dir.path().join("again")).0.digest);
    for assignments in [
        &["motors=direct_drive_250w"][..],
        &["motors.rear.lag_s=0.05"],
        &[
            "motors=direct_drive_250w",
            "motors.battery.lithium_ion.start_charge_ratio=0.2",
        ],
        &["sensors=as_bought"],
        &["sensors.sensor.roll.timing.delay_s=0.02"],
        &["sensors.sensor.imu.gyro.bias_sd_rad_s=0.02"],
        &[
            "plant.multibody.road=wet",
            "plant.multibody.road.bank_rad=0.01",
        ],
        &[
            "plant.multibody.road.patches=[{ x_m = [0.5, 2.0], friction_ratio = 0.3, edge_m = 0.1 }]",
        ],
        &["plant.multibody.wind=gusty"],
        &["plant.multibody.wind.across_m_s=2"],
        &["plant.multibody.bicycle.tyre.front.twisting_gain=0.1"],
        &["plant.multibody.set.tyre.rear.relaxation_length_m=0.1"],
        &["plant.multibody.set.joints.legs.free=false"],
        &["plant.multibody.bicycle=bulsink2017_bicycle1_case6"],
        &["rider.rider.steer_torque.delay_s=0.12"],
        &["rider=older_firm"],
        &[
            "disturbance.0.what.side_force.rms_n=30",
            "disturbance.0.start_s=0",
        ],
        &[
            "disturbance=[{ start_s = 0.0, what = { rig_multisine = { amplitude_m = 0.0125, slope = 1.0, duration_s = 100.0, fade_s = 0.2 } } }]",
        ],
    ] {
        assert_ne!(run(assignments).digest, reference, "{assignments:?}");
    }
}

#[test]
fn wrong_multibody_courses_say_what_is_accepted() {
    for (assignments, parts) in [
        (
            &["plant.multibody.bicycle=unicycle"][..],
            &["unicycle", "bulsink2017_bicycle1_full"][..],
        ),
        (
            &["plant.multibody.set.tyre.front.twistin_gain=1"],
            &["twistin_gain"],
        ),
        (
            &["plant.multibody.bicycle.geometry.wheelbase_m=-1"],
            &["wheelbase_m", "0.1 to 10"],
        ),
        (&["plant.multibody.road=mud"], &["mud", "wet"]),
        (
            &["plant.multibody.road.slop_rad=0.1"],
            &["slop_rad", "slope_rad"],
        ),
        (
            &["plant.multibody.road.slope_rad=1"],
            &["slope_rad", "0.35"],
        ),
        (
            &["plant.multibody.wind.across_m_s=99"],
            &["across_m_s", "50"],
        ),
        (
            &[
                "plant.multibody.set.air.drag_area_m2=0",
                "plant.multibody.set.air.side_area_m2=0",
                "plant.multibody.wind=gusty",
            ],
            &["no air areas"],
        ),
        (
            &["plant.multibody.sensor_at_m=[9.0, 0.0, 0.0]"],
            &["sensor_at_m", "-5 to 5"],
        ),
        (&["motors.front.lag_ms=1"], &["lag_ms", "lag_s"]),
        (&["motors.front.lag_s=-1"], &["lag_s", "-1"]),
        (
            &["sensors.sensor.roll.timing.delay_s=-1"],
            &["delay_s", "-1"],
        ),
        (
            &[
                "plant.multibody.bicycle=bulsink2017_bicycle1_case1",
                "disturbance=[{ start_s = 0.0, what = { rig_multisine = { amplitude_m = 0.01, slope = 1.0, duration_s = 9.0, fade_s = 0.2 } } }]",
            ],
            &["rig_multisine", "tyres"],
        ),
        (
            &[
                "plant.multibody.bicycle=bulsink2017_bicycle1_case6",
                "rider=bulsink2017_trunk_lean_young",
            ],
            &["trunk_lean", "joints.trunk_lean.free"],
        ),
        (
            &["plant.benchmark.bicycle=meijaard2007_benchmark"],
            &["benchmark", "multibody"],
        ),
    ] {
        let error = multibody(assignments)
            .expect_err(assignments[0])
            .to_string();
        for part in parts {
            assert!(error.contains(part), "`{part}` is missing in: {error}");
        }
    }
}

#[test]
fn equal_rides_have_equal_digests_and_other_seeds_others() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let digest = |name: &str, assignments: &[&str]| {
        let mut all = vec!["duration_s=4"];
        all.extend(assignments);
        ride(&load(&all), &dir.path().join(name)).0.digest
    };
    let first = digest("a", &[]);
    assert_eq!(first.len(), 32);
    assert_eq!(first, digest("b", &[]));
    assert_ne!(first, digest("c", &["seed=2"]));
    assert_ne!(
        first,
        digest("d", &["rider.rider.steer_torque.delay_s=0.12"])
    );
}

#[test]
fn the_controllers_roll_follows_the_truth() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let (_, log) = ride(&load(&["duration_s=20"]), &dir.path().join("log"));
    let truth = log.column(PLANT_TRUTH, "roll_rad").expect("logged");
    let estimate = log
        .column(CONTROL_OUTPUT, "estimate.roll_rad")
        .expect("logged");
    let error: Vec<f64> = truth
        .iter()
        .zip(estimate)
        .skip(1000)
        .map(|(t, e)| t - e)
        .collect();
    let rms = (error.iter().map(|e| e * e).sum::<f64>() / error.len() as f64).sqrt();
    assert!(
        rms.to_degrees() < 0.5,
        "roll estimate is {} degrees rms off",
        rms.to_degrees()
    );
    assert_eq!(
        truth.len(),
        log.column(SENSOR_MEASUREMENT, "imu.stamp_ns")
            .expect("logged")
            .len()
    );
}

#[test]
fn nobody_at_the_bar_at_walking_pace_is_a_fall_and_an_outcome() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let mut course = load(&["duration_s=30"]);
    course.rider.rider = twinhub_plant::rider::Channels::default();
    for point in &mut course.course.speed {
        point.speed_m_s = 2.0;
    }
    let (outcome, log) = ride(&course.with_stabilizer(false), &dir.path().join("log"));
    assert_eq!(outcome.ending, Ending::Fell);
    assert!(outcome.metrics.fell && outcome.metrics.ticks < 30_000);
    let roll = log.column(PLANT_TRUTH, "roll_rad").expect("logged");
    assert!(roll.iter().all(|r| r.is_finite()));
}

/// A controller that dies at a tick.
struct Dies<P> {
    at: u64,
    port: P,
}

impl<P: ControllerPort> ControllerPort for Dies<P> {
    fn exchange_during(
        &mut self,
        frame: &PlantFrame,
        meanwhile: &mut dyn FnMut(),
    ) -> Result<Option<ControllerFrame>, LinkError> {
        if frame.header.tick >= self.at {
            return Err(LinkError::PeerDied {
                pid: 1,
                tick: frame.header.tick,
            });
        }
        self.port.exchange_during(frame, meanwhile)
    }
}

#[test]
fn when_the_controller_dies_the_drives_ramp_to_zero_within_200_ms_and_the_log_opens() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let course = load(&["duration_s=20"]);
    let log = dir.path().join("log");
    let mut port = Dies {
        at: 10_000,
        port: InProcess::new(twinhub_sim::in_process(&course.law)),
    };
    let error = ride_with(&course, &log, &mut port).expect_err("the link is lost");
    assert!(error.to_string().contains("died at tick 10000"), "{error}");
    let log = twinhub_log::read(&log).expect("opens");
    let torque = log.column(PLANT_TRUTH, "front_brake_nm").expect("logged");
    assert!(
        torque[9_999] > 30.0,
        "there was torque before: {}",
        torque[9_999]
    );
    assert!(
        torque.len() <= 10_250,
        "and the ride ends soon after: {} ticks",
        torque.len()
    );
    assert!(
        torque.iter().skip(10_200).all(|&t| t == 0.0),
        "zero 200 ms after the last command"
    );
    let fastest = torque
        .windows(2)
        .skip(9_999)
        .map(|w| w[0] - w[1])
        .fold(0.0, f64::max);
    assert!(fastest < 2.0, "ramped, not cut: {fastest} Nm in a tick");
}

#[test]
fn a_ride_that_is_stopped_ramps_out_first() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let course = load(&["duration_s=20"]);
    let path = dir.path().join("log");
    let mut port = InProcess::new(twinhub_sim::in_process(&course.law));
    let mut watch = |p: twinhub_sim::Progress| p.tick < 10_000;
    let outcome =
        twinhub_sim::ride(&course, &settings(Some(&path)), &mut port, &mut watch).expect("stops");
    assert_eq!(outcome.ending, Ending::Stopped);
    let log = twinhub_log::read(&path).expect("opens");
    let torque = log.column(PLANT_TRUTH, "front_brake_nm").expect("logged");
    assert_eq!(torque.last(), Some(&0.0));
    let fastest = torque.windows(2).map(|w| w[0] - w[1]).fold(0.0, f64::max);
    assert!(
        fastest < 0.5,
        "as slowly as a healthy path allows: {fastest} Nm in a tick"
    );
}

#[test]
fn wrong_courses_say_file_key_and_what_is_accepted() {
    let error = |assignment: &str| {
        Ride::load("first_ride", &[assignment.to_owned()])
            .expect_err(assignment)
            .to_string()
    };
    assert!(error("duration=3").contains("duration_s"));
    assert!(error("duration_s=-1").contains("at most 36000"));
    assert!(error("duration_s=nan").contains("duration_s"));
    assert!(error("rider=nobody").contains("older_6_to_7"));
    assert!(error("law=sheduled").contains("scheduled"));
    assert!(error("sensors=none").contains("laboratory"));
    assert!(error("plant.benchmark.bicycle=nothing").contains("bulsink2017_bicycle1"));
    assert!(error("law.limits.torque_max_nm=1000").contains("torque_max_nm"));
    assert!(error("rider.rider.steer_torque.delay_s=5").contains("0 to 1 s"));
    assert!(
        Ride::load("no_such_course", &[])
            .expect_err("no such file")
            .to_string()
            .contains("first_ride")
    );
}
