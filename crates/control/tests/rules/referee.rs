//! Checks commands against the promises of the guard, in `f64` and without any of its code.

use twinhub_control::guard::{
    BLIND_RAMP_S, GuardLimits, LEVER_THRESHOLD_RATIO, LINK_RAMP_S, PEAK_GAIN, STANDSTILL_M_S,
    THERMAL_TAU_S, TURNING_NM_PER_M2_S2,
};
use twinhub_types::{Command, Instant, LimitedBy, Measurement, RiderIntent};

pub struct Referee {
    limits: GuardLimits,
    last: Option<(u64, Command)>,
    power_w: f64,
    average_w: f64,
}

fn fresh(now: Instant, stamp_ns: u64, age_ms: u64) -> bool {
    let now_ns = now.as_nanos();
    stamp_ns != u64::MAX && stamp_ns <= now_ns && now_ns - stamp_ns <= age_ms * 1_000_000
}

impl Referee {
    pub fn new(limits: GuardLimits) -> Self {
        Self {
            limits,
            last: None,
            power_w: 0.0,
            average_w: 0.0,
        }
    }

    /// The promise that `command` breaks, if any.
    pub fn check(
        &mut self,
        now: Instant,
        meas: &Measurement,
        rider: &RiderIntent,
        command: &Command,
        limited_by: LimitedBy,
    ) -> Result<(), String> {
        let (front_nm, rear_nm) = (
            command.front_brake_nm as f64,
            command.rear_traction_nm as f64,
        );
        let most_nm = self.limits.torque_max_nm as f64;
        let (r_f, r_r) = (
            self.limits.front_wheel_radius_m as f64,
            self.limits.rear_wheel_radius_m as f64,
        );
        let ramp_nm_s = self.limits.ramp_up_nm_s as f64;
        let eps_nm = 1e-4;
        let rule = |holds: bool, what: &str| {
            if holds {
                return Ok(());
            }
            Err(format!(
                "{what}: {command:?} after {:?} at {now:?}",
                self.last
            ))
        };

        rule(front_nm.is_finite() && rear_nm.is_finite(), "finite")?;
        rule(
            (0.0..=most_nm).contains(&front_nm),
            "front within 0 and the largest torque",
        )?;
        rule(rear_nm.abs() <= most_nm, "rear within the largest torque")?;

        let last_ns = self.last.map_or(now.as_nanos(), |(ns, _)| ns);
        let span_s = now.as_nanos().saturating_sub(last_ns) as f64 * 1e-9;
        let (credit_s, debit_s) = (span_s.min(0.02), if span_s > 0.0 { span_s } else { 1e-3 });
        let last = self.last.map_or(Command::default(), |(_, command)| command);
        let (last_front_nm, last_rear_nm) =
            (last.front_brake_nm as f64, last.rear_traction_nm as f64);
        let up_nm = ramp_nm_s * credit_s;
        rule(
            front_nm - last_front_nm <= up_nm + eps_nm,
            "the pair grows along the ramp",
        )?;
        let net_nm = rear_nm - front_nm * r_r / r_f;
        let last_net_nm = last_rear_nm - last_front_nm * r_r / r_f;
        rule(
            net_nm.max(0.0) - last_net_nm.max(0.0) <= up_nm + eps_nm,
            "drive grows along the ramp",
        )?;

        let lever = rider.front_brake_ratio > LEVER_THRESHOLD_RATIO
            || rider.rear_brake_ratio > LEVER_THRESHOLD_RATIO;
        if lever {
            rule(
                front_nm == 0.0 && rear_nm == 0.0,
                "nothing while a lever is pulled",
            )?;
        }

        let w = &meas.wheels;
        let wheels = fresh(now, w.stamp_ns, 50)
            && w.front_rad_s.abs() <= 300.0
            && w.rear_rad_s.abs() <= 300.0
            && w.speed_m_s.abs() <= 30.0;
        let (front_m_s, rear_m_s) = (w.front_rad_s as f64 * r_f, w.rear_rad_s as f64 * r_r);
        if wheels && front_m_s < STANDSTILL_M_S as f64 - 1e-6 {
            rule(front_nm == 0.0, "no wheel that stands is braked (front)")?;
        }
        if !wheels || rear_m_s < STANDSTILL_M_S as f64 - 1e-6 {
            rule(rear_nm >= 0.0, "no wheel that stands is braked (rear)")?;
        }
        let turning = |m_s: f64| m_s * m_s * TURNING_NM_PER_M2_S2 as f64 + eps_nm;
        if wheels {
            rule(
                front_nm <= turning(front_m_s.max(0.0)),
                "a slow wheel goes on turning (front)",
            )?;
            rule(
                -rear_nm <= turning(rear_m_s.max(0.0)),
                "a slow wheel goes on turning (rear)",
            )?;
        }
        if wheels && w.speed_m_s as f64 - front_m_s > 0.151 * w.speed_m_s.abs() as f64 + 0.301 {
            rule(
                front_nm == 0.0 && rear_nm == 0.0,
                "nothing while the front wheel slips",
            )?;
        }

        let pedals = fresh(now, rider.stamp_ns, 50)
            && rider.pedalling == 1
            && rider.assist_on <= 1
            && rider.pedal_nm.is_finite()
            && rider.front_brake_ratio.is_finite()
            && rider.rear_brake_ratio.is_finite();
        let slow = wheels && (w.speed_m_s as f64).max(front_m_s).max(rear_m_s) <= 25.0 / 3.6 + 1e-6;
        if !pedals || !slow {
            rule(
                net_nm <= eps_nm,
                "no drive without pedalling or above 25 km/h",
            )?;
        }

        let at_once = LimitedBy::LEVER
            .with(LimitedBy::SLIP)
            .with(LimitedBy::STANDSTILL)
            .with(LimitedBy::TURNING)
            .with(LimitedBy::FRICTION)
            .with(LimitedBy::POWER);
        if !limited_by.any(at_once) {
            // Which ramp is the guard's affair; none is steeper than the link's.
            let link = LimitedBy::LINK.with(LimitedBy::MODE);
            let ramp_s = if limited_by.any(link) {
                LINK_RAMP_S
            } else if limited_by.any(LimitedBy::BLIND) {
                BLIND_RAMP_S
            } else {
                self.limits.ramp_down_s
            };
            let down_nm = most_nm.max(1.0) * debit_s / ramp_s as f64;
            rule(
                last_front_nm - front_nm <= down_nm + eps_nm,
                "the pair falls along the ramp",
            )?;
        }

        if let Some(limit_w) = self.limits.power_average_max_w {
            let share = (debit_s / THERMAL_TAU_S as f64).min(1.0 / (1.0 + PEAK_GAIN as f64));
            if self.last.is_some() {
                self.average_w += share * (self.power_w - self.average_w);
            }
            rule(
                self.average_w <= limit_w as f64 * (1.0 + 1e-4),
                "average power within the profile",
            )?;
            if wheels {
                self.power_w = (front_nm * w.front_rad_s.abs() as f64)
                    .max(rear_nm.abs() * w.rear_rad_s.abs() as f64);
            } else {
                self.power_w = 0.0;
            }
        }
        self.last = Some((now.as_nanos(), *command));
        Ok(())
    }
}
