//! Recorded frames, given to two controllers: do they answer with the same bits?

use twinhub_control::{Config, Controller};
use twinhub_link::{ControllerPort, LinkError};
use twinhub_types::messages::PROTOCOL_HASH;
use twinhub_types::{
    ControllerFrame, Header, Measurement, Output, PlantFrame, RideState, RiderIntent, Wire,
};

/// What a comparison found.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Comparison {
    /// Frames given to both.
    pub ticks: u64,
    /// Answers that differ in at least one bit.
    pub different: u64,
    /// The first of them.
    pub first_different: Option<Difference>,
}

/// Two answers that differ.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Difference {
    /// The tick.
    pub tick: u64,
    /// What the controller here answers.
    pub expected: String,
    /// What the other one answered.
    pub found: String,
}

/// The frames of a ride from what its log holds, one every tick.
pub fn frames(
    time_ns: &[u64],
    measurements: &[Measurement],
    intents: &[RiderIntent],
) -> Vec<PlantFrame> {
    let rows = time_ns.iter().zip(measurements).zip(intents);
    let frames = rows
        .enumerate()
        .map(|(tick, ((&time_ns, m), intent))| PlantFrame {
            header: header(tick as u64, time_ns),
            measurement: *m,
            intent: *intent,
        });
    frames.collect()
}

/// The header of a frame in the middle of a ride.
pub(crate) fn header(tick: u64, time_ns: u64) -> Header {
    Header {
        protocol_hash: PROTOCOL_HASH,
        sequence: tick,
        tick,
        time_ns,
        state: RideState::Running as u32,
        reserved: 0,
    }
}

/// Gives every frame to a new controller here and to the one behind `port`; the last frame tells
/// the other one that the ride is over.
///
/// # Errors
/// If the link fails.
pub fn compare(
    frames: &[PlantFrame],
    config: &Config,
    port: &mut impl ControllerPort,
) -> Result<Comparison, LinkError> {
    let mut controller = Controller::new(config);
    let mut comparison = Comparison {
        ticks: frames.len() as u64,
        different: 0,
        first_different: None,
    };
    for (index, frame) in frames.iter().enumerate() {
        let mut frame = *frame;
        if index + 1 == frames.len() {
            frame.header.state = RideState::Finished as u32;
        }
        let expected = controller.answer(&frame);
        let found = port.exchange(&frame)?;
        if found.map(|found| bytes(&found)) != Some(bytes(&expected)) {
            comparison.different += 1;
            comparison
                .first_different
                .get_or_insert_with(|| Difference {
                    tick: index as u64,
                    expected: words(&expected.output),
                    found: found.map_or("nothing".to_owned(), |found| words(&found.output)),
                });
        }
    }
    Ok(comparison)
}

/// Bits, because a NaN would not equal itself.
fn bytes(frame: &ControllerFrame) -> [u8; ControllerFrame::SIZE] {
    let mut bytes = [0; ControllerFrame::SIZE];
    let _full = frame.put(&mut bytes);
    bytes
}

fn words(output: &Output) -> String {
    format!("{output:?}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use twinhub_link::InProcess;

    #[test]
    fn one_bit_is_found() {
        let config = Config::NO_TORQUE;
        let frames = crate::adversarial::frames(500, 1);
        let mut controller = Controller::new(&config);
        let mut same = InProcess::new(|frame: &PlantFrame| controller.answer(frame));
        let found = compare(&frames, &config, &mut same).expect("in process");
        assert_eq!((found.ticks, found.different), (500, 0));
        let mut controller = Controller::new(&config);
        let mut flipped = InProcess::new(|frame: &PlantFrame| {
            let mut answer = controller.answer(frame);
            if frame.header.tick == 250 {
                let nm = &mut answer.output.command.rear_traction_nm;
                *nm = f32::from_bits(nm.to_bits() ^ 0x8000_0000);
            }
            answer
        });
        let found = compare(&frames, &config, &mut flipped).expect("in process");
        assert_eq!(found.different, 1);
        assert_eq!(found.first_different.expect("there is one").tick, 250);
    }
}
