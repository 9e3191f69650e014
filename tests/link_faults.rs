//! Faults of the link and hostile peers, in the closed loop: the plant stays up, the controller
//! stays within its limits, and everything is in the log.

use proptest::prelude::*;
use std::path::Path;
use twinhub_link::fault::{Channel, LinkFault, LinkFaultKind};
use twinhub_link::protocol::TORQUE_MAX_NM;
use twinhub_link::{ControllerPort, InProcess, LinkError};
use twinhub_log::{EVENT, LogFile, PLANT_TRUTH};
use twinhub_sim::{Ending, Outcome, Ride, RideError, Settings};
use twinhub_types::messages::PROTOCOL_HASH;
use twinhub_types::{ControllerFrame, Instant, PlantFrame, Wire};

fn course(duration_s: f64, faults: &[LinkFault]) -> Ride {
    let assignments = [
        format!("duration_s={duration_s}"),
        "law.limits.ramp_up_nm_s=50".to_owned(),
        "law.law.scheduled.change_nm_s=100".to_owned(),
    ];
    let mut ride = Ride::load("first_ride", &assignments).expect("ships");
    ride.course.link_fault = faults.to_vec();
    ride
}

fn ride(ride: &Ride, log: &Path, port: &mut impl ControllerPort) -> Result<Outcome, RideError> {
    let settings = Settings {
        log: Some(log.to_owned()),
        version: "test".into(),
        git_hash: "test".into(),
    };
    twinhub_sim::ride(ride, &settings, port, &mut |_| true)
}

fn with_faults(faults: &[LinkFault], log: &Path) -> (Outcome, LogFile) {
    let course = course(6.0, faults);
    let mut port = InProcess::new(twinhub_sim::in_process(&course.law));
    let outcome = ride(&course, log, &mut port).expect("the plant stays up");
    (outcome, twinhub_log::read(log).expect("opens"))
}

fn fault(channel: Channel, kind: LinkFaultKind) -> LinkFault {
    LinkFault {
        channel,
        start_s: 3.0,
        end_s: Some(4.0),
        kind,
    }
}

const KINDS: [LinkFaultKind; 7] = [
    LinkFaultKind::Late {
        delay_s: 0.005,
        jitter_s: 0.01,
    },
    LinkFaultKind::Late {
        delay_s: 0.1,
        jitter_s: 0.0,
    },
    LinkFaultKind::Dropout { share_ratio: 0.3 },
    LinkFaultKind::Repeat { share_ratio: 0.3 },
    LinkFaultKind::Corrupt { share_ratio: 0.3 },
    LinkFaultKind::Stuck {},
    LinkFaultKind::Death {},
];

#[test]
fn every_fault_on_every_channel_is_survived_and_logged_with_one_digest() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let clean = with_faults(&[], &dir.path().join("clean")).0.digest;
    for channel in [Channel::ToController, Channel::ToPlant] {
        for (i, kind) in KINDS.iter().enumerate() {
            let log = dir.path().join(format!("{channel:?}{i}"));
            let (outcome, log) = with_faults(&[fault(channel, *kind)], &log);
            let name = format!("{channel:?} {kind:?}");
            assert_ne!(outcome.ending, Ending::Stopped, "{name}");
            assert_ne!(outcome.digest, clean, "{name} changes the ride");
            let (again, _) = with_faults(&[fault(channel, *kind)], &dir.path().join("again"));
            assert_eq!(outcome.digest, again.digest, "{name}: one digest");
            let torque = log.column(PLANT_TRUTH, "front_brake_nm").expect("logged");
            // A corrupted answer is believed as far as a drive believes any.
            let most_nm = match (channel, kind) {
                (Channel::ToPlant, LinkFaultKind::Corrupt { .. }) => f64::from(TORQUE_MAX_NM),
                _ => 40.0,
            };
            let worst_nm = torque.iter().copied().fold(0.0, f64::max);
            assert!(worst_nm <= most_nm, "{name}: {worst_nm} Nm");
            let told = log.texts.get(EVENT).expect("events").iter();
            let told = told
                .filter(|event| event.text.contains("link.fault"))
                .count();
            let news = if matches!(kind, LinkFaultKind::Death {}) {
                1
            } else {
                2
            };
            assert_eq!(told, news, "{name}");
        }
    }
}

#[test]
fn a_silent_controller_brings_the_drives_watchdog_and_a_silent_plant_the_controllers_ramp() {
    let dir = tempfile::tempdir().expect("temporary directory");
    for channel in [Channel::ToPlant, Channel::ToController] {
        let log = dir.path().join(format!("{channel:?}"));
        let (_, log) = with_faults(&[fault(channel, LinkFaultKind::Stuck {})], &log);
        let torque = log.column(PLANT_TRUTH, "front_brake_nm").expect("logged");
        assert!(
            torque[2999] > 20.0,
            "{channel:?}: {} Nm before",
            torque[2999]
        );
        assert!(torque[3015] > 0.9 * torque[2999], "20 ms are allowed");
        assert!(
            torque[3201..4000].iter().all(|nm| *nm == 0.0),
            "{channel:?}: zero 200 ms after the last frame"
        );
        assert!(
            torque[5990] > 0.0,
            "{channel:?}: back after the fault has cleared"
        );
    }
}

#[test]
fn a_link_without_faults_is_the_link_itself() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let late = fault(
        Channel::ToPlant,
        LinkFaultKind::Late {
            delay_s: 0.0,
            jitter_s: 0.0,
        },
    );
    let clean = with_faults(&[], &dir.path().join("clean")).0;
    let same = with_faults(&[late], &dir.path().join("late")).0;
    assert_eq!(clean.metrics, same.metrics);
}

/// Answers with whatever bytes it is given.
struct Hostile {
    answers: Vec<Vec<u8>>,
    keep_header: bool,
}

impl ControllerPort for Hostile {
    fn exchange_during(
        &mut self,
        frame: &PlantFrame,
        meanwhile: &mut dyn FnMut(),
    ) -> Result<Option<ControllerFrame>, LinkError> {
        meanwhile();
        let tick = frame.header.tick as usize;
        let bytes = &self.answers[tick % self.answers.len()];
        let mut answer = ControllerFrame::get(bytes).expect("long enough").0;
        if self.keep_header {
            answer.header = frame.header;
            answer.header.protocol_hash = PROTOCOL_HASH;
        }
        twinhub_link::protocol::check_answer(&answer, frame.header.tick, frame.header.sequence)?;
        Ok(Some(answer))
    }
}

/// Bytes of a frame: anything, with a taste for numbers that are none, huge or tiny.
fn hostile_bytes(size: usize) -> impl Strategy<Value = Vec<u8>> {
    let word = prop_oneof![
        any::<u32>(),
        Just(f32::NAN.to_bits()),
        Just(f32::INFINITY.to_bits()),
        Just(f32::NEG_INFINITY.to_bits()),
        Just(f32::MAX.to_bits()),
        Just(f32::MIN_POSITIVE.to_bits()),
        Just(u32::MAX),
        (-100.0f32..100.0).prop_map(f32::to_bits),
    ];
    proptest::collection::vec(word, size / 4)
        .prop_map(|words| words.into_iter().flat_map(u32::to_le_bytes).collect())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn the_plant_stays_up_whatever_the_controller_answers(
        answers in proptest::collection::vec(hostile_bytes(ControllerFrame::SIZE), 1..20),
        keep_header in prop::bool::weighted(0.9),
    ) {
        let dir = tempfile::tempdir().expect("temporary directory");
        let log = dir.path().join("log");
        let course = course(0.5, &[]);
        let mut hostile = Hostile { answers, keep_header };
        match ride(&course, &log, &mut hostile) {
            Ok(outcome) => prop_assert!(outcome.metrics.roll_rms_rad.is_finite()),
            Err(RideError::Link(LinkError::BadFrame { .. })) => prop_assert!(!keep_header),
            Err(other) => prop_assert!(false, "{other}"),
        }
        let log = twinhub_log::read(&log).expect("the log opens");
        let torque = log.column(PLANT_TRUTH, "front_brake_nm").expect("logged");
        prop_assert!(torque.iter().all(|nm| nm.is_finite()));
    }

    #[test]
    fn the_controller_stays_within_its_limits_whatever_the_plant_sends(
        frames in proptest::collection::vec(hostile_bytes(PlantFrame::SIZE), 1..40),
        on in any::<bool>(),
    ) {
        let course = course(1.0, &[]);
        let mut controller = twinhub_control::Controller::new(&course.law);
        for (i, bytes) in frames.iter().cycle().take(400).enumerate() {
            let mut frame = PlantFrame::get(bytes).expect("long enough").0;
            if on {
                // A clock and a switch that are believed, so that torque is in reach.
                frame.header.time_ns = i as u64 * 1_000_000;
                frame.intent.stamp_ns = frame.header.time_ns;
                frame.intent.assist_on = 1;
            }
            let answer = controller.answer(&frame);
            let command = &answer.output.command;
            prop_assert!((0.0..=40.0).contains(&command.front_brake_nm), "{command:?}");
            prop_assert!(command.rear_traction_nm.abs() <= 40.0, "{command:?}");
            prop_assert_eq!(answer.header.protocol_hash, PROTOCOL_HASH);
            let _ = Instant::from_nanos(answer.header.time_ns);
        }
    }
}
