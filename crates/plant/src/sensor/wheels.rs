//! Wheel-speed sensors: pulses, and speed from the time between them.
//!
//! What: `edges_per_turn` edges on each wheel (hall signals of a hub motor: six per pole pair),
//! not quite evenly placed. Equation: rate = k s/(t_n - t_{n-k}) with s = 2π/edges and k at
//! least `edges_averaged`; while the next
//! edge is overdue, the rate is at most s/(t - t_n), and that is reported; after `standstill_s` it
//! is zero. Stamp: the time of the newest edge, or now while an edge is overdue; the older of the
//! two wheels. Speed: rear rate times the radius that the bicycle's computer believes. Source:
//! definition. Assumes and ignores: no missed or double edges (inject them as faults). Valid for:
//! both directions. Checked by: the conformance suite (speed, staleness at low speed, direction).

use serde::{Deserialize, Serialize};
use twinhub_types::{Instant, Measurement, WheelSample};

use super::{Sampler, Sensor, SensorKind, SensorModel, SensorTruth, Timing};
use crate::admissible::{OutOfRange, within};
use crate::explain::Explain;
use crate::noise::stream;

/// Parameters of the wheel-speed sensors.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WheelHallParameters {
    /// Edges in one turn of each wheel; 0 for a sensor that knows the rate exactly.
    pub edges_per_turn: u32,
    /// Standard deviation of the place of an edge, rad.
    pub edge_placement_sd_rad: f64,
    /// Edges over which a rate is averaged, 1 to 64; six make one electrical period of a hub motor,
    /// over which the uneven places of its edges average out.
    pub edges_averaged: u32,
    /// Resolution of the timer, s.
    pub timer_s: f64,
    /// Without an edge for so long, the wheel counts as standing, s.
    pub standstill_s: f64,
    /// Rear wheel radius, m.
    pub rear_radius_m: f64,
    /// Error of that radius: tyre pressure and load.
    pub radius_error_ratio: f64,
    /// Rate, delay, losses of the report.
    pub timing: Timing,
}

/// Wheel-speed sensors in use.
#[derive(Clone, Debug)]
pub struct WheelHall {
    exact: bool,
    radius_m: f64,
    timer_ns: u64,
    standstill_ns: u64,
    front: Wheel,
    rear: Wheel,
    sampler: Sampler<WheelSample>,
}

/// Edges, angle and timer of one wheel.
#[derive(Clone, Debug)]
struct Wheel {
    spacing_rad: f64,
    places_rad: Vec<f64>,
    angle_rad: f64,
    /// The edge behind: the wheel stands between `behind` and `behind` + 1.
    behind: i64,
    last: Option<(Instant, f64)>,
    newest: Option<Edge>,
    /// Edges counted since the last reversal, and when: the last few, in a ring.
    counted: u64,
    ring: Vec<(u64, u64)>,
    ring_next: usize,
    averaged: u64,
    speed_rad_s: f64,
}

/// An edge that went by.
#[derive(Clone, Copy, Debug)]
struct Edge {
    at_ns: u64,
    forward: bool,
}

/// Edges that one tick can hold; a wheel beyond it is faster than any bicycle.
const EDGES_PER_TICK: u32 = 64;

impl Wheel {
    fn new(parameters: &WheelHallParameters, seed: u64, name: &str) -> Self {
        let edges = parameters.edges_per_turn;
        let spacing_rad = 2.0 * core::f64::consts::PI / f64::from(edges.max(1));
        let mut source = stream(seed, name);
        let limit = 0.4 * spacing_rad;
        let places_rad = (0..edges)
            .map(|_| (parameters.edge_placement_sd_rad * source.normal()).clamp(-limit, limit))
            .collect();
        // between edge 0 and edge 1
        let angle_rad = 0.5 * spacing_rad;
        Self {
            spacing_rad,
            places_rad,
            angle_rad,
            behind: 0,
            last: None,
            newest: None,
            counted: 0,
            ring: vec![(0, 0); parameters.edges_averaged as usize + 1],
            ring_next: 0,
            averaged: u64::from(parameters.edges_averaged),
            speed_rad_s: 0.0,
        }
    }

    /// Notes that `passed` edges went by, the newest at `at_ns`, and gives the edges and the time
    /// over which the rate is averaged.
    fn count(&mut self, passed: u32, at_ns: u64) -> Option<(u64, u64)> {
        self.counted += u64::from(passed);
        // The youngest entry that lies at least as many edges back as are averaged, or the oldest.
        let back = |(count, _): &&(u64, u64)| *count > 0 && self.counted - count >= self.averaged;
        let known = |(count, _): &&(u64, u64)| *count > 0;
        let from = self
            .ring
            .iter()
            .filter(back)
            .max_by_key(|(count, _)| *count)
            .or_else(|| {
                self.ring
                    .iter()
                    .filter(known)
                    .min_by_key(|(count, _)| *count)
            })
            .copied();
        let slot = self.ring_next;
        self.ring[slot] = (self.counted, at_ns);
        self.ring_next = (slot + 1) % self.ring.len();
        from.map(|(count, then_ns)| (self.counted - count, at_ns.saturating_sub(then_ns)))
    }

    /// Forgets the edges counted so far: the wheel has turned round.
    fn forget(&mut self) {
        self.counted = 0;
        self.ring.fill((0, 0));
    }

    /// Angle of edge `n`, rad.
    fn edge_rad(&self, n: i64) -> f64 {
        let place = self.places_rad[n.rem_euclid(self.places_rad.len() as i64) as usize];
        n as f64 * self.spacing_rad + place
    }

    /// Turns the wheel to `now`; the rate is taken as linear since the last tick.
    fn turn(&mut self, now: Instant, rate_rad_s: f64, timer_ns: u64) {
        let Some((before, rate_before)) = self.last.replace((now, rate_rad_s)) else {
            return;
        };
        let step = now.since(before);
        let start_rad = self.angle_rad;
        let turn_rad = 0.5 * (rate_before + rate_rad_s) * step.as_secs_f64();
        if !turn_rad.is_finite()
            || turn_rad.abs() > f64::from(EDGES_PER_TICK - 1) * self.spacing_rad
        {
            return;
        }
        self.angle_rad = start_rad + turn_rad;
        let forward = turn_rad > 0.0;
        let mut passed = 0u32;
        let mut newest_ns = 0;
        for _ in 0..EDGES_PER_TICK {
            let next = if forward {
                self.behind + 1
            } else {
                self.behind
            };
            let edge_rad = self.edge_rad(next);
            let reached = if forward {
                self.angle_rad >= edge_rad
            } else {
                self.angle_rad < edge_rad
            };
            if !reached {
                break;
            }
            self.behind += if forward { 1 } else { -1 };
            let share = if turn_rad == 0.0 {
                1.0
            } else {
                (edge_rad - start_rad) / turn_rad
            };
            let after_ns = libm::floor(share.clamp(0.0, 1.0) * step.as_nanos() as f64) as u64;
            let at_ns = before.as_nanos() + after_ns;
            newest_ns = at_ns - at_ns % timer_ns;
            passed += 1;
        }
        if passed == 0 {
            return;
        }
        // The first edge after a reversal is the one that went by last: it starts the count anew.
        if self
            .newest
            .is_some_and(|previous| previous.forward != forward)
        {
            self.forget();
            self.speed_rad_s = 0.0;
        }
        if let Some((edges, apart_ns)) = self.count(passed, newest_ns) {
            let sign = if forward { 1.0 } else { -1.0 };
            let apart_s = apart_ns.max(timer_ns) as f64 * 1e-9;
            self.speed_rad_s = sign * edges as f64 * self.spacing_rad / apart_s;
        }
        self.newest = Some(Edge {
            at_ns: newest_ns,
            forward,
        });
        // keep the numbers small: whole turns change nothing
        let edges = self.places_rad.len() as i64;
        if self.behind.abs() > 4 * edges {
            let turns = self.behind / edges;
            self.behind -= turns * edges;
            self.angle_rad -= turns as f64 * edges as f64 * self.spacing_rad;
        }
    }

    /// Rate and stamp as reported at `now`.
    fn report(&self, now: Instant, standstill_ns: u64) -> (f64, u64) {
        let Some(edge) = self.newest else {
            return (0.0, now.as_nanos());
        };
        let silence_ns = now.as_nanos().saturating_sub(edge.at_ns);
        if silence_ns >= standstill_ns {
            return (0.0, now.as_nanos());
        }
        let bound = self.spacing_rad / (silence_ns.max(1) as f64 * 1e-9);
        if self.speed_rad_s.abs() > bound {
            (bound.copysign(self.speed_rad_s), now.as_nanos())
        } else {
            (self.speed_rad_s, edge.at_ns)
        }
    }
}

impl SensorKind for WheelHallParameters {
    fn explain(&self) -> Explain {
        Explain {
            name: "wheel_hall",
            what: "wheel rates from the time between pulses, and the bicycle computer's speed",
            equation: "rate = k s/(t_n - t_{n-k}), at most s/(t - t_n) while an edge is overdue; speed = rear rate × radius",
            source: "definition; six edges per pole pair are the hall signals of a hub motor",
            assumes: "no missed or double edges; speed from the rear wheel slips with it",
        }
    }

    fn validate(&self) -> Result<(), OutOfRange> {
        within(
            "edges_per_turn",
            f64::from(self.edges_per_turn),
            0.0,
            4096.0,
        )?;
        within(
            "edge_placement_sd_rad",
            self.edge_placement_sd_rad,
            0.0,
            1.0,
        )?;
        within("edges_averaged", f64::from(self.edges_averaged), 1.0, 64.0)?;
        within("timer_s", self.timer_s, 1e-9, 0.01)?;
        within("standstill_s", self.standstill_s, 0.01, 10.0)?;
        within("rear_radius_m", self.rear_radius_m, 0.05, 1.0)?;
        within("radius_error_ratio", self.radius_error_ratio, -0.2, 0.2)?;
        self.timing.validate()
    }

    fn build(&self, seed: u64) -> Sensor {
        let nanos = |s: f64| libm::round(s * 1e9) as u64;
        Sensor::WheelHall(WheelHall {
            exact: self.edges_per_turn == 0,
            radius_m: self.rear_radius_m * (1.0 + self.radius_error_ratio),
            timer_ns: nanos(self.timer_s).max(1),
            standstill_ns: nanos(self.standstill_s),
            front: Wheel::new(self, seed, "sensor.wheels.front_edges"),
            rear: Wheel::new(self, seed, "sensor.wheels.rear_edges"),
            sampler: Sampler::new(&self.timing, seed, "wheels", WheelSample::default()),
        })
    }
}

impl SensorModel for WheelHall {
    fn sample(&mut self, now: Instant, truth: &SensorTruth, into: &mut Measurement) {
        if !self.exact {
            self.front
                .turn(now, truth.front_wheel_rate_rad_s, self.timer_ns);
            self.rear
                .turn(now, truth.rear_wheel_rate_rad_s, self.timer_ns);
        }
        let Self {
            exact,
            radius_m,
            standstill_ns,
            front,
            rear,
            sampler,
            ..
        } = self;
        into.wheels = sampler.tick(now, || {
            if *exact {
                return WheelSample {
                    stamp_ns: now.as_nanos(),
                    front_rad_s: truth.front_wheel_rate_rad_s as f32,
                    rear_rad_s: truth.rear_wheel_rate_rad_s as f32,
                    speed_m_s: truth.speed_m_s as f32,
                    reserved: 0,
                };
            }
            let (front_rad_s, front_ns) = front.report(now, *standstill_ns);
            let (rear_rad_s, rear_ns) = rear.report(now, *standstill_ns);
            WheelSample {
                stamp_ns: front_ns.min(rear_ns),
                front_rad_s: front_rad_s as f32,
                rear_rad_s: rear_rad_s as f32,
                speed_m_s: (rear_rad_s * *radius_m) as f32,
                reserved: 0,
            }
        });
    }
}
