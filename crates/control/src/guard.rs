//! The last word: lets no torque out that breaks a limit, whatever the other parts ask for.
//!
//! The guard reads time, sensors and levers itself, keeps its own clock, and trusts neither the
//! estimate nor the request. What it promises, for any input bit pattern:
//!
//! * both torques are finite, within the largest torque, and the front one is never negative;
//! * the pair grows no faster than the ramp up; it falls at once for a brake lever, a slipping
//!   wheel, a wheel that stands still, and where friction or power leave less; else in the time
//!   that the fault allows: `ramp_down_s` with a healthy torque path, [`BLIND_RAMP_S`] without
//!   wheel speeds, [`LINK_RAMP_S`] on a lost link or a fault;
//! * the wheels' forces never add up to drive unless the rider pedals, below 25 km/h;
//! * no wheel is braked that does not turn forward, and a slow one no harder than
//!   [`TURNING_NM_PER_M2_S2`] allows: it could stop before its slip is seen;
//! * the thermal average of each motor's power stays within the profile's.

use twinhub_types::{Command, Instant, LimitedBy, Measurement, Mode, RiderIntent};

use crate::bounded::Bounded as _;
use crate::clock::{Clock, Tick};
use crate::config::ASSIST_SPEED_MAX_M_S;
use crate::senses;

mod limits;

pub(crate) use limits::tolerated_slip_m_s;
pub use limits::{
    BLIND_RAMP_S, GuardLimits, LEVER_THRESHOLD_RATIO, LINK_RAMP_S, PEAK_GAIN, Request, SLIP_HOLD_S,
    SLIP_MARGIN_M_S, SLIP_RATIO, STANDSTILL_M_S, THERMAL_TAU_S, TURNING_NM_PER_M2_S2,
};

/// The wheels as the guard sees them, tread speeds in m/s.
#[derive(Clone, Copy, Debug)]
struct Wheels {
    front_m_s: f32,
    rear_m_s: f32,
    speed_m_s: f32,
}

/// The guard's memory.
#[derive(Clone, Copy, Debug)]
pub struct Guard {
    limits: GuardLimits,
    clock: Clock,
    /// What went out in the last tick: pair and trim, Nm.
    pair_nm: f32,
    trim_nm: f32,
    /// The pair when it last did not fall, Nm: ramps down are timed from here.
    onset_nm: f32,
    slip_hold_s: f32,
    /// Last known tread speeds, for power.
    front_m_s: f32,
    rear_m_s: f32,
    power_w: f32,
    power_average_w: f32,
    limited_by: LimitedBy,
}

impl Guard {
    /// A guard at rest.
    pub fn new(limits: GuardLimits) -> Self {
        Self {
            limits,
            clock: Clock::default(),
            pair_nm: 0.0,
            trim_nm: 0.0,
            onset_nm: 0.0,
            slip_hold_s: 0.0,
            front_m_s: 0.0,
            rear_m_s: 0.0,
            power_w: 0.0,
            power_average_w: 0.0,
            limited_by: LimitedBy::NONE,
        }
    }

    /// What held the last command back.
    pub fn limited_by(&self) -> LimitedBy {
        self.limited_by
    }

    /// The thermal average of the more loaded motor's mechanical power, W.
    pub fn power_average_w(&self) -> f32 {
        self.power_average_w
    }

    /// The command of this tick: `request` as far as the limits allow.
    pub fn apply(
        &mut self,
        now: Instant,
        meas: &Measurement,
        rider: &RiderIntent,
        mode: Mode,
        request: &Request,
    ) -> Command {
        self.limited_by = request.limited_by;
        let tick = self.clock.tick(now);
        let wheels = self.wheels(now, meas);
        let intent_known =
            now.fresh(rider.stamp_ns, senses::INTENT_MAX_AGE) && senses::plausible_intent(rider);

        let link = senses::link_alive(now, meas, rider);
        let cut = self.must_cut(&tick, rider, wheels.as_ref());
        self.average_power(&tick);
        let ramp_s = self.ramp_s(link, wheels.is_some(), mode);
        let allowed = link
            && wheels.is_some()
            && intent_known
            && matches!(mode, Mode::Active | Mode::Degraded);
        self.say(LimitedBy::INTENT, !intent_known);
        self.say(
            LimitedBy::MODE,
            !matches!(mode, Mode::Active | Mode::Degraded),
        );

        let wanted_nm = if allowed {
            finite(request.pair_nm)
        } else {
            0.0
        };
        let pair_nm = self.slew_pair(&tick, wanted_nm, ramp_s);
        let ceiling_nm = self.ceiling_nm(pair_nm, request, wheels.as_ref());
        self.pair_nm = if cut {
            0.0
        } else {
            pair_nm.at_most(ceiling_nm)
        };
        self.onset_nm = if self.pair_nm > 0.0 {
            self.onset_nm.at_least(self.pair_nm)
        } else {
            0.0
        };

        let drive = intent_known
            && rider.pedalling == 1
            && wheels.is_some_and(|wheels| wheels.fastest_m_s() <= ASSIST_SPEED_MAX_M_S);
        let wanted_nm = if allowed {
            finite(request.trim_nm)
        } else {
            0.0
        };
        self.trim_nm = if cut {
            0.0
        } else {
            self.slew_trim(&tick, wanted_nm, ramp_s, drive)
        };

        let command = self.command(wheels.as_ref());
        let (front_rad_s, rear_rad_s) = self.rates_rad_s();
        self.power_w = (command.front_brake_nm * front_rad_s)
            .at_least(command.rear_traction_nm.abs() * rear_rad_s);
        command
    }

    fn say(&mut self, limit: LimitedBy, holds: bool) {
        if holds {
            self.limited_by = self.limited_by.with(limit);
        }
    }

    /// Tread speeds of this very sample, if it is fresh and plausible.
    fn wheels(&mut self, now: Instant, meas: &Measurement) -> Option<Wheels> {
        let sample = &meas.wheels;
        let known =
            now.fresh(sample.stamp_ns, senses::WHEELS_MAX_AGE) && senses::plausible_wheels(sample);
        if !known {
            self.say(LimitedBy::BLIND, true);
            return None;
        }
        let wheels = Wheels {
            front_m_s: sample.front_rad_s * self.limits.front_wheel_radius_m,
            rear_m_s: sample.rear_rad_s * self.limits.rear_wheel_radius_m,
            speed_m_s: sample.speed_m_s,
        };
        self.front_m_s = wheels.front_m_s.abs();
        self.rear_m_s = wheels.rear_m_s.abs();
        Some(wheels)
    }

    /// True if the rider brakes or a wheel slips, now or within the last second.
    fn must_cut(&mut self, tick: &Tick, rider: &RiderIntent, wheels: Option<&Wheels>) -> bool {
        // However old the reading: a lever that was pulled is believed.
        let lever = rider.front_brake_ratio > LEVER_THRESHOLD_RATIO
            || rider.rear_brake_ratio > LEVER_THRESHOLD_RATIO;
        self.slip_hold_s = (self.slip_hold_s - tick.credit_s).at_least(0.0);
        if wheels.is_some_and(Wheels::slip) {
            self.slip_hold_s = SLIP_HOLD_S;
        }
        let slip = self.slip_hold_s > 0.0;
        self.say(LimitedBy::LEVER, lever);
        self.say(LimitedBy::SLIP, slip);
        lever || slip
    }

    /// The largest pair that may go out in this tick, Nm: holds at once. `pair_nm` would go out.
    fn ceiling_nm(&mut self, pair_nm: f32, request: &Request, wheels: Option<&Wheels>) -> f32 {
        if wheels.is_some_and(|wheels| wheels.front_m_s < STANDSTILL_M_S) {
            self.say(LimitedBy::STANDSTILL, pair_nm > 0.0);
            return 0.0;
        }
        let ratio = self.balance_ratio();
        let most_nm = self
            .limits
            .torque_max_nm
            .at_most(self.limits.torque_max_nm / ratio);
        self.say(LimitedBy::MAGNITUDE, request.pair_nm > most_nm);
        let turning_nm = wheels.map_or(f32::INFINITY, |w| limits::turning_nm(w.front_m_s));
        self.say(LimitedBy::TURNING, pair_nm > turning_nm);
        let (front_rad_s, rear_rad_s) = self.rates_rad_s();
        let power_nm =
            self.power_left_w() / front_rad_s.at_least(rear_rad_s * ratio).at_least(1e-3);
        self.say(LimitedBy::POWER, pair_nm > power_nm);
        // A ceiling that is no number is none that can be trusted.
        let carried_nm = if request.pair_ceiling_nm > 0.0 {
            request.pair_ceiling_nm
        } else {
            0.0
        };
        self.say(LimitedBy::FRICTION, pair_nm > carried_nm);
        most_nm
            .at_most(power_nm)
            .at_most(carried_nm)
            .at_most(turning_nm)
    }

    /// Heat so far: a first-order low pass of the power that went out.
    fn average_power(&mut self, tick: &Tick) {
        // No longer step than the one for which the limit of `power_left_w` still holds.
        let share = (tick.debit_s / THERMAL_TAU_S).at_most(1.0 / (1.0 + PEAK_GAIN));
        self.power_average_w += (self.power_w - self.power_average_w) * share;
    }

    /// `P <= P_c + k (P_c - P_average)`: the average approaches `P_c` and never passes it.
    fn power_left_w(&self) -> f32 {
        self.limits
            .power_average_max_w
            .map_or(f32::INFINITY, |most_w| {
                (most_w + PEAK_GAIN * (most_w - self.power_average_w)).at_least(0.0)
            })
    }

    fn ramp_s(&mut self, link: bool, wheels: bool, mode: Mode) -> f32 {
        self.say(LimitedBy::LINK, !link);
        if !link || mode == Mode::Fault {
            LINK_RAMP_S
        } else if !wheels {
            BLIND_RAMP_S
        } else {
            self.limits.ramp_down_s
        }
    }

    /// The pair one tick on: slowly up, down from its onset to zero in `ramp_s`.
    fn slew_pair(&mut self, tick: &Tick, wanted_nm: f32, ramp_s: f32) -> f32 {
        if wanted_nm >= self.pair_nm {
            self.onset_nm = self.pair_nm;
            let up_nm = self.pair_nm + self.limits.ramp_up_nm_s * tick.credit_s;
            self.say(LimitedBy::RAMP, wanted_nm > up_nm);
            return wanted_nm.at_most(up_nm);
        }
        let down_nm = self.pair_nm - self.onset_nm.at_least(1.0) * tick.debit_s / ramp_s;
        self.say(LimitedBy::RAMP, down_nm > wanted_nm);
        wanted_nm.at_least(down_nm).at_least(0.0)
    }

    /// The trim one tick on: the ramp up both ways, faster out when the ramp down is; no drive
    /// where there must be none, at once.
    fn slew_trim(&mut self, tick: &Tick, wanted_nm: f32, ramp_s: f32, drive: bool) -> f32 {
        let most_nm = self.limits.torque_max_nm;
        let wanted_nm = wanted_nm.at_least(-most_nm).at_most(most_nm);
        let away_nm = self.limits.ramp_up_nm_s * tick.credit_s;
        let back_nm = away_nm.at_least(most_nm * tick.debit_s / ramp_s);
        // Back ends at zero; beyond it, away begins.
        let lowest_nm = (self.trim_nm - back_nm)
            .at_least(0.0)
            .at_most(self.trim_nm - away_nm);
        let highest_nm = (self.trim_nm + back_nm)
            .at_most(0.0)
            .at_least(self.trim_nm + away_nm);
        let trim_nm = wanted_nm.at_least(lowest_nm).at_most(highest_nm);
        if drive || trim_nm <= 0.0 {
            return trim_nm;
        }
        self.say(LimitedBy::NET_DRIVE, true);
        0.0
    }

    /// Pair and trim as torques of two motors, each within its own limits.
    fn command(&mut self, wheels: Option<&Wheels>) -> Command {
        let most_nm = self.limits.torque_max_nm;
        let balance_nm = self.pair_nm * self.balance_ratio();
        let mut rear_nm = (balance_nm + self.trim_nm)
            .at_least(-most_nm)
            .at_most(most_nm);
        let (_, rear_rad_s) = self.rates_rad_s();
        let power_nm = self.power_left_w() / rear_rad_s.at_least(1e-3);
        rear_nm = rear_nm.at_least(-power_nm).at_most(power_nm);
        let rolls = wheels.is_some_and(|wheels| wheels.rear_m_s >= STANDSTILL_M_S);
        if rear_nm < 0.0 && !rolls {
            self.say(LimitedBy::STANDSTILL, true);
            rear_nm = 0.0;
        }
        let turning_nm = wheels.map_or(0.0, |w| limits::turning_nm(w.rear_m_s));
        if rear_nm < -turning_nm {
            self.say(LimitedBy::TURNING, true);
            rear_nm = -turning_nm;
        }
        // What the limits took from the trim comes back along the ramp.
        self.trim_nm = rear_nm - balance_nm;
        Command {
            front_brake_nm: self.pair_nm,
            rear_traction_nm: rear_nm,
        }
    }

    fn balance_ratio(&self) -> f32 {
        self.limits.rear_wheel_radius_m / self.limits.front_wheel_radius_m
    }

    fn rates_rad_s(&self) -> (f32, f32) {
        (
            self.front_m_s / self.limits.front_wheel_radius_m,
            self.rear_m_s / self.limits.rear_wheel_radius_m,
        )
    }
}

impl Wheels {
    fn fastest_m_s(&self) -> f32 {
        self.front_m_s
            .at_least(self.rear_m_s)
            .at_least(self.speed_m_s)
    }

    /// True if the front wheel lags behind the bicycle or the rear wheel leads it.
    fn slip(&self) -> bool {
        let tolerated_m_s = tolerated_slip_m_s(self.speed_m_s);
        self.speed_m_s - self.front_m_s > tolerated_m_s
            || self.rear_m_s - self.speed_m_s > tolerated_m_s
    }
}

/// `value`, or 0 if it is no number.
fn finite(value: f32) -> f32 {
    if value.is_finite() { value } else { 0.0 }
}
