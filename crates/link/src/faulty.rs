//! The wrapper that lays [faults](crate::fault) over a port.

use crate::account::ControllerTiming;
use crate::fault::{Channel, LinkFault, LinkFaultKind};
use crate::newest::Newest;
use crate::timing::Timing;
use crate::{ControllerPort, LinkError, LinkEvent};
use rand::{Rng as _, SeedableRng as _};
use rand_pcg::Pcg64;
use std::collections::VecDeque;
use twinhub_types::wire::{HASH_START, hash_str, hash_u64};
use twinhub_types::{ControllerFrame, Measurement, Output, PlantFrame, RiderIntent, Wire};

/// Old frames that may be repeated.
const PAST: usize = 10;

/// What a plant frame carries beside its header.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Load {
    measurement: Measurement,
    intent: RiderIntent,
}

/// Any port, with faults on both channels.
pub struct Faulty<P> {
    port: P,
    to_controller: Vec<Line<Load>>,
    to_plant: Vec<Line<Option<ControllerFrame>>>,
    newest: Newest,
    events: VecDeque<LinkEvent>,
}

impl<P: ControllerPort> Faulty<P> {
    /// Lays `faults` over `port`, with the random streams of `seed`. Without faults it is `port`.
    pub fn new(port: P, faults: &[LinkFault], seed: u64) -> Self {
        let lines = |channel| {
            faults
                .iter()
                .enumerate()
                .filter(move |(_, fault)| fault.channel == channel)
        };
        Self {
            port,
            to_controller: lines(Channel::ToController)
                .map(|(i, fault)| Line::new(i, *fault, seed))
                .collect(),
            to_plant: lines(Channel::ToPlant)
                .map(|(i, fault)| Line::new(i, *fault, seed))
                .collect(),
            newest: Newest::default(),
            events: VecDeque::new(),
        }
    }
}

impl<P: ControllerPort> ControllerPort for Faulty<P> {
    #[inline]
    fn exchange_during(
        &mut self,
        frame: &PlantFrame,
        meanwhile: &mut dyn FnMut(),
    ) -> Result<Option<ControllerFrame>, LinkError> {
        if self.to_controller.is_empty() && self.to_plant.is_empty() {
            return self.port.exchange_during(frame, meanwhile);
        }
        let header = frame.header;
        let mut load = Load {
            measurement: frame.measurement,
            intent: frame.intent,
        };
        for line in &mut self.to_controller {
            load = line.pass(header.time_ns, load, &mut self.events);
        }
        let told = PlantFrame {
            header,
            measurement: load.measurement,
            intent: load.intent,
        };
        let mut answer = self.port.exchange_during(&told, meanwhile)?;
        for line in &mut self.to_plant {
            answer = line.pass(header.time_ns, answer, &mut self.events);
        }
        if self.to_plant.is_empty() {
            return Ok(answer);
        }
        Ok(answer.filter(|answer| self.newest.take(answer, header.sequence)))
    }

    fn next_event(&mut self) -> Option<LinkEvent> {
        self.events.pop_front().or_else(|| self.port.next_event())
    }

    fn controller_timing(&self) -> Option<ControllerTiming> {
        self.port.controller_timing()
    }

    fn instructions(&self) -> Option<u64> {
        self.port.instructions()
    }

    fn timing(&self) -> Option<Timing> {
        self.port.timing()
    }
}

/// Something that can be hit by bit flips.
trait Bits: Copy + Default {
    /// Flips bit `bit` of its contents, counted from the front; beyond the end, nothing.
    fn flip(&mut self, bit: u64);
}

fn flip_in<W: Wire>(value: &mut W, bit: u64) {
    let mut bytes = vec![0; W::SIZE];
    let byte = (bit / 8) as usize % W::SIZE;
    if value.put(&mut bytes).is_some() {
        bytes[byte] ^= 1 << (bit % 8);
        if let Some((changed, _)) = W::get(&bytes) {
            *value = changed;
        }
    }
}

impl Bits for Load {
    fn flip(&mut self, bit: u64) {
        let measured = 8 * Measurement::SIZE as u64;
        let bit = bit % (measured + 8 * RiderIntent::SIZE as u64);
        if bit < measured {
            flip_in(&mut self.measurement, bit);
        } else {
            flip_in(&mut self.intent, bit - measured);
        }
    }
}

impl Bits for Option<ControllerFrame> {
    fn flip(&mut self, bit: u64) {
        if let Some(frame) = self {
            flip_in::<Output>(&mut frame.output, bit);
        }
    }
}

/// One fault at work on one channel.
struct Line<T> {
    fault: LinkFault,
    start_ns: u64,
    end_ns: u64,
    draw: Pcg64,
    was_on: bool,
    hits: u64,
    /// What was delivered last.
    delivered: T,
    /// What was sent, newest first.
    past: VecDeque<T>,
    /// What is on its way, by the tick in which it arrives.
    flying: VecDeque<(u64, T)>,
}

impl<T: Bits> Line<T> {
    fn new(index: usize, fault: LinkFault, seed: u64) -> Self {
        let ns = |s: f64| (s * 1e9).round() as u64;
        let stream = hash_u64(
            hash_str(hash_u64(HASH_START, seed), "link_fault"),
            index as u64,
        );
        Self {
            fault,
            start_ns: ns(fault.start_s),
            end_ns: match fault.kind {
                LinkFaultKind::Death {} => u64::MAX,
                _ => fault.end_s.map_or(u64::MAX, ns),
            },
            draw: Pcg64::seed_from_u64(stream),
            was_on: false,
            hits: 0,
            delivered: T::default(),
            past: VecDeque::new(),
            flying: VecDeque::new(),
        }
    }

    /// What arrives in the tick in which `sent` is sent.
    fn pass(&mut self, now_ns: u64, sent: T, events: &mut VecDeque<LinkEvent>) -> T {
        let on = (self.start_ns..self.end_ns).contains(&now_ns);
        if on != self.was_on {
            self.was_on = on;
            let (kind, channel) = (self.fault.kind.name(), self.fault.channel.name());
            events.push_back(if on {
                self.hits = 0;
                LinkEvent::warning(
                    "link.fault",
                    format!("fault `{kind}` on `{channel}` begins"),
                )
            } else {
                let text = format!(
                    "fault `{kind}` on `{channel}` ends; it hit {} frames",
                    self.hits
                );
                LinkEvent::info("link.fault", text)
            });
        }
        if on {
            self.delivered = self.hit(now_ns, sent);
        } else {
            self.flying.clear();
            self.delivered = sent;
        }
        self.past.push_front(sent);
        self.past.truncate(PAST);
        self.delivered
    }

    /// Uniform on [0, 1), 53 bits.
    fn uniform(&mut self) -> f64 {
        (self.draw.next_u64() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// One of the whole numbers below `end`.
    fn below(&mut self, end: u64) -> u64 {
        ((u128::from(self.draw.next_u64()) * u128::from(end)) >> 64) as u64
    }

    fn strikes(&mut self, share_ratio: f64) -> bool {
        let strikes = self.uniform() < share_ratio;
        self.hits += u64::from(strikes);
        strikes
    }

    fn hit(&mut self, now_ns: u64, sent: T) -> T {
        match self.fault.kind {
            LinkFaultKind::Late { delay_s, jitter_s } => {
                self.hits += 1;
                let late_s = delay_s + jitter_s * self.uniform();
                let tick = now_ns / 1_000_000;
                let at = tick + (late_s * 1e3).round() as u64;
                self.flying.push_back((at, sent));
                let mut arrived = self.delivered;
                self.flying.retain(|(at, frame)| {
                    let here = *at <= tick;
                    if here {
                        arrived = *frame;
                    }
                    !here
                });
                arrived
            }
            LinkFaultKind::Dropout { share_ratio } => {
                if self.strikes(share_ratio) {
                    self.delivered
                } else {
                    sent
                }
            }
            LinkFaultKind::Repeat { share_ratio } => {
                if self.past.is_empty() || !self.strikes(share_ratio) {
                    return sent;
                }
                let back = self.below(self.past.len() as u64);
                self.past[back as usize]
            }
            LinkFaultKind::Corrupt { share_ratio } => {
                let mut hit = sent;
                if self.strikes(share_ratio) {
                    for _ in 0..=self.below(64) {
                        hit.flip(self.draw.next_u64());
                    }
                }
                hit
            }
            LinkFaultKind::Stuck {} | LinkFaultKind::Death {} => {
                self.hits += 1;
                self.delivered
            }
        }
    }
}
