//! Mode and health: what the stabilizer may do, why not, and how it comes back.
//!
//! A flag rises in the tick in which its cause is there and falls after the cause was away for
//! one second of regular ticks; only a refused configuration needs a restart. The causes carry
//! their own patience: [`senses`](crate::senses) bridges short gaps.

use twinhub_types::{Estimate, Health, Mode};

use crate::clock::Tick;
use crate::config::Config;
use crate::doubt::Doubts;
use crate::senses::Seen;

/// How long a cause has to be away before its flag falls, s.
pub const CLEAR_S: f32 = 1.0;
/// Roll beyond which the bicycle lies on its side, rad.
pub const FALLEN_RAD: f32 = 0.9;
/// How far beyond the edge of its range the speed may be before the pair is withdrawn, m/s.
pub const SPEED_HYSTERESIS_M_S: f32 = 0.3;
/// Share of the largest pair that a missing or doubted steer sensor leaves.
pub const SHARE_WITHOUT_STEER: f32 = 0.5;

/// Flags that stand for a fault; any other flag degrades.
pub const FAULTS: Health = Health::LINK_LOST
    .with(Health::TIME_JUMP)
    .with(Health::CONFIG_REFUSED)
    .with(Health::FALLEN);

/// Flags that say nothing worse than that steer is not known.
const WITHOUT_STEER: Health = Health::STEER_MISSING.with(Health::STEER_DOUBT);

/// One flag and how long its cause has been away.
#[derive(Clone, Copy, Debug)]
struct Watch {
    flag: Health,
    raised: bool,
    good_s: f32,
}

impl Watch {
    const fn new(flag: Health) -> Self {
        Self {
            flag,
            raised: false,
            good_s: 0.0,
        }
    }

    fn update(&mut self, bad: bool, credit_s: f32) -> Health {
        if bad {
            self.raised = true;
            self.good_s = 0.0;
        } else if self.raised {
            self.good_s += credit_s;
            self.raised = self.good_s < CLEAR_S;
        }
        if self.raised { self.flag } else { Health::OK }
    }
}

/// The supervisor's memory.
#[derive(Clone, Copy, Debug)]
pub struct Supervisor {
    refused: bool,
    speed_min_m_s: f32,
    speed_max_m_s: f32,
    link: Watch,
    roll: Watch,
    steer: Watch,
    speed: Watch,
    intent: Watch,
    time: Watch,
    fallen: Watch,
    steer_doubt: Watch,
    speed_doubt: Watch,
    health: Health,
    mode: Mode,
}

impl Supervisor {
    /// A supervisor before the first tick; `refused` is a fault for good.
    pub fn new(config: &Config, refused: bool) -> Self {
        Self {
            refused,
            speed_min_m_s: config.limits.speed_min_m_s,
            speed_max_m_s: config.limits.speed_max_m_s,
            link: Watch::new(Health::LINK_LOST),
            roll: Watch::new(Health::ROLL_MISSING),
            steer: Watch::new(Health::STEER_MISSING),
            speed: Watch::new(Health::SPEED_MISSING),
            intent: Watch::new(Health::INTENT_MISSING),
            time: Watch::new(Health::TIME_JUMP),
            fallen: Watch::new(Health::FALLEN),
            steer_doubt: Watch::new(Health::STEER_DOUBT),
            speed_doubt: Watch::new(Health::SPEED_DOUBT),
            health: Health::OK,
            mode: Mode::Off,
        }
    }

    /// The mode of this tick.
    pub fn update(&mut self, tick: &Tick, seen: &Seen, x: &Estimate, doubts: Doubts) -> Mode {
        let credit_s = tick.credit_s;
        let refused = if self.refused {
            Health::CONFIG_REFUSED
        } else {
            Health::OK
        };
        let roll_known = seen.roll.is_some() || seen.imu.is_some();
        self.health = refused
            .with(self.link.update(!seen.link, credit_s))
            .with(self.roll.update(!roll_known, credit_s))
            .with(self.steer.update(seen.steer.is_none(), credit_s))
            .with(self.speed.update(seen.wheels.is_none(), credit_s))
            .with(self.intent.update(seen.intent.is_none(), credit_s))
            .with(self.time.update(!tick.regular, credit_s))
            .with(self.fallen.update(x.roll_rad.abs() > FALLEN_RAD, credit_s))
            .with(self.steer_doubt.update(doubts.steer, credit_s))
            .with(self.speed_doubt.update(doubts.speed, credit_s));
        self.mode = self.next_mode(seen, x);
        self.mode
    }

    fn next_mode(&self, seen: &Seen, x: &Estimate) -> Mode {
        if self.health.any(FAULTS) {
            return Mode::Fault;
        }
        if seen.intent.is_some_and(|intent| intent.assist_on == 0) {
            return Mode::Off;
        }
        if !self.health.is_ok() {
            return Mode::Degraded;
        }
        let margin_m_s = if self.mode == Mode::Active {
            SPEED_HYSTERESIS_M_S
        } else {
            0.0
        };
        let fast_enough = x.speed_m_s >= self.speed_min_m_s - margin_m_s;
        let slow_enough = x.speed_m_s <= self.speed_max_m_s + margin_m_s;
        if fast_enough && slow_enough {
            Mode::Active
        } else {
            Mode::Ready
        }
    }

    /// Everything that is wrong.
    pub fn health(&self) -> Health {
        self.health
    }

    /// Share of the largest pair that the mode allows: all of it while active, half of it while
    /// nothing but the steer sensor is missing or doubted (the pair's magnitude does not rest on it),
    /// else none.
    pub fn share_ratio(&self) -> f32 {
        match self.mode {
            Mode::Active => 1.0,
            Mode::Degraded if self.health.without(WITHOUT_STEER).is_ok() => SHARE_WITHOUT_STEER,
            _ => 0.0,
        }
    }
}
