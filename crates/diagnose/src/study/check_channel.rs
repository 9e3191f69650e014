//! Channels and laws of a study.

use super::check::{Checker, LONGEST_LAG_S};
use super::raw::{RawChannel, RawLaw};
use super::{ChannelSpec, HoldKind, LawKind, LawSpec, ModelKind, Role, StudyError};
use crate::quantity::Quantity;
use toml::Spanned;

impl Checker<'_> {
    pub(super) fn channel(&self, spanned: &Spanned<RawChannel>) -> Result<ChannelSpec, StudyError> {
        let raw = spanned.get_ref();
        let (quantity, role) = (*raw.quantity.get_ref(), *raw.role.get_ref());
        let benchmark = self.model == ModelKind::Benchmark;
        let list = |ok: fn(Quantity) -> bool| {
            let names = Quantity::NAMES
                .iter()
                .filter(|n| serde_json::from_value::<Quantity>((**n).into()).is_ok_and(ok));
            names.copied().collect::<Vec<_>>().join(", ")
        };
        if benchmark && role == Role::Input && !quantity.drives_benchmark() {
            let accepted = format!(
                "inputs of the benchmark model: {} (or role = \"output\" or \"check\")",
                list(Quantity::drives_benchmark)
            );
            return self.refuse(&raw.quantity.span(), format!("input {quantity}"), accepted);
        }
        if benchmark && role == Role::Output && !quantity.predicted_by_benchmark() {
            let accepted = format!(
                "outputs of the benchmark model: {} (or role = \"input\" or \"check\")",
                list(Quantity::predicted_by_benchmark)
            );
            return self.refuse(&raw.quantity.span(), format!("output {quantity}"), accepted);
        }
        let pair = |key: &str, value: &Option<Spanned<[f64; 2]>>| match value {
            Some(v) if v.get_ref().iter().any(|x| !x.is_finite() || x.abs() > 10.0) => self.refuse(
                &v.span(),
                format!("{key} = {:?}", v.get_ref()),
                "two finite numbers within 10 m",
            ),
            Some(v) => Ok(Some(*v.get_ref())),
            None => Ok(None),
        };
        let arm_m = pair("arm_m", &raw.arm_m)?;
        let point_m = pair("point_m", &raw.point_m)?;
        let force = role == Role::Input && quantity == Quantity::LateralForce;
        if force && (arm_m.is_some() == point_m.is_some()) {
            let found = "lateral_force_n with both or neither of arm_m and point_m";
            return self.refuse(
                &spanned.span(),
                found,
                "arm_m = [roll, steer torque per newton] or point_m = [x, z] of its application",
            );
        }
        let accelerometer = benchmark && role == Role::Output && quantity == Quantity::LateralAccel;
        if accelerometer && point_m.is_none() {
            return self.refuse(
                &spanned.span(),
                "lateral_accel_m_s2 without point_m",
                "point_m = [x, z] of the sensor from the rear contact",
            );
        }
        let hold = raw.hold.as_ref().map_or(HoldKind::Linear, |h| *h.get_ref());
        let not_negative = |x: f64| x >= 0.0;
        let lag = |x: f64| (0.0..=LONGEST_LAG_S).contains(&x);
        let lowpass_hz = self.number(
            "lowpass_hz",
            &raw.lowpass_hz,
            0.0,
            not_negative,
            "0 (none) or more",
        )?;
        if let Some(v) = &raw.lowpass_hz
            && lowpass_hz > 0.0
            && role == Role::Input
            && hold == HoldKind::Zero
        {
            return self.refuse(
                &v.span(),
                "lowpass_hz on an input with hold = \"zero\"",
                "hold = \"linear\": a step cannot have passed the filter",
            );
        }
        let noise_sd = match &raw.noise_sd {
            None => None,
            some => Some(self.number(
                "noise_sd",
                some,
                0.0,
                |x| x > 0.0,
                "a number above 0, or no noise_sd: then it is estimated",
            )?),
        };
        Ok(ChannelSpec {
            column: raw.column.get_ref().clone(),
            quantity,
            role,
            scale: self.number(
                "scale",
                &raw.scale,
                1.0,
                |x| x != 0.0,
                "a finite number other than 0",
            )?,
            offset: self.number("offset", &raw.offset, 0.0, |_| true, "a finite number")?,
            arm_m,
            point_m,
            noise_sd,
            bias_sd: self.number(
                "bias_sd",
                &raw.bias_sd,
                0.0,
                not_negative,
                "0 (none) or more",
            )?,
            delay_s: self.number("delay_s", &raw.delay_s, 0.0, lag, "0 to 10 s")?,
            quantum: self.number(
                "quantum",
                &raw.quantum,
                0.0,
                not_negative,
                "0 (none) or more",
            )?,
            lowpass_hz,
            moving_average_s: self.number(
                "moving_average_s",
                &raw.moving_average_s,
                0.0,
                lag,
                "0 (none) to 10 s",
            )?,
            hold,
            place: self.place(&raw.column.span()),
        })
    }

    pub(super) fn law(&self, raw: &Spanned<RawLaw>) -> Result<LawSpec, StudyError> {
        let law = raw.get_ref();
        let quantity = *law.quantity.get_ref();
        if !matches!(quantity, Quantity::SteerTorque | Quantity::RollTorque) {
            return self.refuse(
                &law.quantity.span(),
                format!("a law for {quantity}"),
                "steer_torque_nm, roll_torque_nm",
            );
        }
        let of = *law.of.get_ref();
        let states = [
            Quantity::Roll,
            Quantity::RollRate,
            Quantity::Steer,
            Quantity::SteerRate,
            Quantity::YawRate,
        ];
        if !states.contains(&of) {
            let accepted = states.map(Quantity::name).join(", ");
            return self.refuse(&law.of.span(), format!("a law of {of}"), accepted);
        }
        let speed0_m_s = match (law.kind, &law.speed0_m_s) {
            (LawKind::SpeedScheduledRate, None) => {
                return self.refuse(
                    &raw.span(),
                    "kind = \"speed_scheduled_rate\" without speed0_m_s",
                    "speed0_m_s = NUMBER",
                );
            }
            (LawKind::Linear, Some(v)) => {
                return self.refuse(
                    &v.span(),
                    "speed0_m_s with kind = \"linear\"",
                    "no speed0_m_s, or kind = \"speed_scheduled_rate\"",
                );
            }
            (_, None) => None,
            (_, some) => Some(self.number(
                "speed0_m_s",
                some,
                0.0,
                |x| x > 0.0 && x < 100.0,
                "above 0, below 100 m/s",
            )?),
        };
        Ok(LawSpec {
            quantity,
            kind: law.kind,
            of,
            gain: self.number(
                "gain",
                &Some(Spanned::new(law.gain.span(), *law.gain.get_ref())),
                0.0,
                |_| true,
                "a finite number",
            )?,
            speed0_m_s,
            limit_nm: self.number(
                "limit_nm",
                &law.limit_nm,
                f64::INFINITY,
                |x| x > 0.0,
                "above 0 Nm",
            )?,
            delay_s: self.number(
                "delay_s",
                &law.delay_s,
                0.0,
                |x| (0.0..=LONGEST_LAG_S).contains(&x),
                "0 to 10 s",
            )?,
        })
    }
}
