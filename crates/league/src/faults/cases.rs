//! What breaks, and what is promised.

use super::ONSET_S;
use twinhub_link::fault::{Channel, LinkFault, LinkFaultKind};
use twinhub_plant::sensor::{Fault, FaultKind, FaultTarget};

/// Within which time a value that contradicts another sensor is doubted, s.
const DOUBT_S: f64 = 1.0;
/// Within which time the drives take the torque out when answers do not arrive, s: watchdog and ramp.
const DRIVES_S: f64 = 0.25;

/// What breaks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum What {
    /// A sensor.
    Sensor(Fault),
    /// The link.
    Link(LinkFault),
}

/// A line of the matrix: what breaks, and what is promised.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// `steer_angle sign_swap`.
    pub name: String,
    /// What breaks.
    pub what: What,
    /// The sensors of the bicycle: `as_bought`, or `laboratory` for what measures roll itself.
    pub suite: &'static str,
    /// Within which time a flag is promised, s; `None`: the fault cannot be told from a ride by its
    /// values alone, it has to be harmless.
    pub stated_s: Option<f64>,
}

/// Every fault: each sensor stuck, offset, spiked, not a number, late, gone, and wrong in sign; each
/// way of the link lossy, late, repeating, corrupting, stuck, dead.
pub fn cases() -> Vec<Case> {
    use FaultTarget as T;
    // Channels with the size of an offset that is large for them, and the flag's patience.
    let channels = [
        (T::GyroX, "gyro_x", 0.2, "as_bought"),
        (T::GyroZ, "gyro_z", 0.2, "as_bought"),
        (T::AccelY, "accel_y", 1.0, "as_bought"),
        (T::RollAngle, "roll_angle", 0.1, "laboratory"),
        (T::RollRate, "roll_rate", 0.2, "laboratory"),
        (T::SteerAngle, "steer_angle", 0.1, "as_bought"),
        (T::SteerRate, "steer_rate", 0.5, "as_bought"),
        (T::FrontWheel, "front_wheel", 3.0, "as_bought"),
        (T::RearWheel, "rear_wheel", 3.0, "as_bought"),
        (T::Speed, "speed", 1.5, "as_bought"),
        (T::FrontTorque, "front_torque", 10.0, "as_bought"),
        (T::BusVoltage, "bus_voltage", 5.0, "as_bought"),
    ];
    let sensors = [
        (T::Imu, "imu", 0.025, "as_bought"),
        (T::Roll, "roll", 0.025, "laboratory"),
        (T::Steer, "steer", 0.025, "as_bought"),
        (T::Wheels, "wheels", 0.055, "as_bought"),
        (T::Motors, "motors", 0.025, "as_bought"),
    ];
    let mut list = Vec::new();
    let mut sensor = |target, name: &str, kind: FaultKind, word: &str, suite, stated_s| {
        list.push(Case {
            name: format!("{name} {word}"),
            what: What::Sensor(Fault {
                target,
                start_s: ONSET_S,
                end_s: None,
                kind,
            }),
            suite,
            stated_s,
        });
    };
    for (target, name, amount, suite) in channels {
        let spike = FaultKind::Spike {
            amount: 10.0 * amount,
            share_ratio: 0.05,
        };
        // What contradicts another sensor is doubted; what is no number is missed.
        let wheel = matches!(target, T::FrontWheel | T::RearWheel | T::Speed);
        let doubted_s = (wheel || target == T::SteerAngle).then_some(DOUBT_S);
        let missed_s = match target {
            T::GyroX | T::GyroZ | T::AccelY | T::SteerAngle => Some(0.025),
            _ if wheel => Some(0.055),
            _ => None,
        };
        let by_wheels_s = doubted_s.filter(|_| wheel);
        sensor(target, name, FaultKind::Stuck {}, "stuck", suite, None);
        sensor(
            target,
            name,
            FaultKind::Offset { amount },
            "offset",
            suite,
            doubted_s,
        );
        sensor(target, name, spike, "spiked", suite, by_wheels_s);
        sensor(
            target,
            name,
            FaultKind::SignSwap {},
            "sign_swap",
            suite,
            by_wheels_s,
        );
        sensor(target, name, FaultKind::Nan {}, "nan", suite, missed_s);
    }
    for (target, name, patience_s, suite) in sensors {
        let late = FaultKind::Late { delay_s: 0.1 };
        let gone = FaultKind::Dropout { share_ratio: 1.0 };
        // What the motors report is not fed back: nothing is promised about it.
        let stated_s = (target != T::Motors).then_some(patience_s);
        sensor(target, name, late, "late", suite, stated_s);
        sensor(target, name, gone, "gone", suite, stated_s);
    }
    for channel in [Channel::ToController, Channel::ToPlant] {
        let kinds = [
            (
                "lost 20 %",
                LinkFaultKind::Dropout { share_ratio: 0.2 },
                None,
            ),
            (
                "lost",
                LinkFaultKind::Dropout { share_ratio: 1.0 },
                Some(0.025),
            ),
            (
                "late 10 ms",
                LinkFaultKind::Late {
                    delay_s: 0.01,
                    jitter_s: 0.005,
                },
                None,
            ),
            (
                "late 50 ms",
                LinkFaultKind::Late {
                    delay_s: 0.05,
                    jitter_s: 0.0,
                },
                Some(0.025),
            ),
            ("repeated", LinkFaultKind::Repeat { share_ratio: 0.2 }, None),
            // Nobody can tell a flipped bit of a plausible number; what lies beyond is missed.
            (
                "corrupted",
                LinkFaultKind::Corrupt { share_ratio: 0.2 },
                Some(0.1),
            ),
            ("stuck", LinkFaultKind::Stuck {}, Some(0.025)),
        ];
        for (word, kind, stated_s) in kinds {
            list.push(Case {
                name: format!("{} {word}", channel.name()),
                what: What::Link(LinkFault {
                    channel,
                    start_s: ONSET_S,
                    end_s: None,
                    kind,
                }),
                suite: "as_bought",
                stated_s: match channel {
                    Channel::ToController => stated_s,
                    // Wrong answers are refused one by one; none at all is for the drives.
                    Channel::ToPlant if word == "corrupted" => None,
                    Channel::ToPlant => stated_s.map(|_| DRIVES_S),
                },
            });
        }
    }
    list
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sensor_and_both_ways_of_the_link_break_in_every_way() {
        let cases = cases();
        for word in [
            "stuck",
            "offset",
            "spiked",
            "nan",
            "sign_swap",
            "late",
            "gone",
        ] {
            assert!(
                cases.iter().filter(|c| c.name.ends_with(word)).count() >= 5,
                "{word}"
            );
        }
        for word in ["lost", "late 10 ms", "repeated", "corrupted"] {
            for way in ["to_controller", "to_plant"] {
                assert!(cases.iter().any(|c| c.name == format!("{way} {word}")));
            }
        }
        let mut names: Vec<&String> = cases.iter().map(|c| &c.name).collect();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), cases.len());
    }
}
