//! One ride: hello, law, frames, report.

use crate::counter::Counter;
use crate::line::{Inbox, Line};
use crate::stack;
use twinhub_control::{Config, Controller};
use twinhub_types::messages::PROTOCOL_HASH;
use twinhub_types::stream::{Kind, Packet, ROLE_CONTROLLER, StreamHello, TargetReport};
use twinhub_types::{PlantFrame, RideState, Wire};

/// Why a ride ended.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Ended {
    /// The plant's last frame is answered.
    LastFrame,
    /// The plant left, or never fitted.
    Left,
}

/// Rides once.
pub fn ride(line: &mut Line, counter: &Counter) -> Ended {
    match try_ride(line, counter) {
        Some(()) => Ended::LastFrame,
        None => Ended::Left,
    }
}

fn try_ride(line: &mut Line, counter: &Counter) -> Option<()> {
    let mut inbox = Inbox::default();
    let ours = StreamHello::new(ROLE_CONTROLLER);
    let (theirs, _) = StreamHello::get(inbox.wait(line, Kind::Hello)?)?;
    let law = inbox.wait(line, Kind::Law)?;
    let config = postcard::from_bytes::<Config>(law);
    let fits = ours.mismatch(&theirs).is_none() && config.is_ok();
    let hello = StreamHello {
        refused: u32::from(!fits),
        ..ours
    };
    line.write(Packet::of(Kind::Hello, &hello).bytes())?;
    let config = config.ok().filter(|_| fits)?;
    let mut controller = Controller::new(&config);
    let mut report = TargetReport {
        loop_counts: counter.loop_counts(),
        stack_bytes: stack::bytes(),
        ..TargetReport::default()
    };
    loop {
        let payload = inbox.wait(line, Kind::Plant)?;
        let Some((frame, [])) = PlantFrame::get(payload) else {
            report.broken_packets += 1;
            continue;
        };
        if frame.header.protocol_hash != PROTOCOL_HASH {
            report.broken_packets += 1;
            continue;
        }
        let before = counter.now();
        let answer = controller.answer(&frame);
        let step_counts = counter.since(before);
        let packet = Packet::of(Kind::Controller, &answer);
        let tick_counts = counter.since(inbox.arrived());
        line.write(packet.bytes())?;

        if step_counts > report.step_counts_max {
            report.step_counts_max = step_counts;
            report.step_max_tick = report.ticks;
        }
        report.tick_counts_max = report.tick_counts_max.max(tick_counts);
        report.step_counts_sum += u64::from(step_counts);
        report.tick_counts_sum += u64::from(tick_counts);
        report.ticks = report.ticks.wrapping_add(1);
        if RideState::from_u32(frame.header.state) != RideState::Running {
            report.broken_packets += inbox.broken();
            report.stack_used_bytes = stack::used_bytes();
            return line.write(Packet::of(Kind::Report, &report).bytes());
        }
    }
}
