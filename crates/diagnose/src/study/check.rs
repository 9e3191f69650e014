//! From the file to a checked study.

use super::raw::{RawChannel, RawLaw, RawModes, RawRide, RawStudy, RawTolerance};
use super::{
    ChannelSpec, HoldKind, LawKind, LawSpec, ModelKind, ModesSpec, Place, RideSpec, Role, Study, StudyError, TimeSpec,
    Tolerance, Use, WindowSpec,
};
use crate::quantity::Quantity;
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;
use toml::Spanned;
use twinhub_linear::{Bicycle, SYMBOLS};

/// Longest delay, running mean and jitter that make sense.
const LONGEST_LAG_S: f64 = 10.0;

struct Checker<'a> {
    text: &'a str,
    path: &'a Path,
    model: ModelKind,
}

pub(super) fn parse(text: &str, path: &Path) -> Result<Study, StudyError> {
    let line = |at: usize| 1 + text.as_bytes()[..at.min(text.len())].iter().filter(|b| **b == b'\n').count();
    let raw: RawStudy = toml::from_str(text).map_err(|error| StudyError::Syntax {
        place: Place { file: path.to_owned(), line: error.span().map_or(1, |s| line(s.start)) },
        message: error.message().trim().replace('\n', ", "),
    })?;
    Checker { text, path, model: raw.bicycle.model }.study(raw)
}

/// Puts `path=value` overrides into the text.
pub(super) fn with_overrides(text: &str, overrides: &[String]) -> Result<String, StudyError> {
    let refuse = |assignment: &str, message: String| StudyError::Override { assignment: assignment.to_owned(), message };
    let mut root: toml::Value = toml::from_str::<toml::Table>(text)
        .map(toml::Value::Table)
        .map_err(|e| refuse("", e.message().to_owned()))?;
    for assignment in overrides {
        let (path, value) = assignment
            .split_once('=')
            .ok_or_else(|| refuse(assignment, "accepted: PATH=VALUE, for instance bicycle.values.IBxx=9.2".to_owned()))?;
        // A bare word is a string.
        let parsed: toml::Table = toml::from_str(&format!("v = {value}"))
            .or_else(|_| toml::from_str(&format!("v = {}", toml::Value::String(value.to_owned()))))
            .map_err(|e| refuse(assignment, e.message().to_owned()))?;
        let mut at = &mut root;
        let (parents, key) = path.trim().rsplit_once('.').unwrap_or(("", path.trim()));
        for part in parents.split('.').filter(|p| !p.is_empty()) {
            at = match at {
                toml::Value::Table(table) => {
                    table.entry(part).or_insert_with(|| toml::Value::Table(toml::Table::new()))
                }
                toml::Value::Array(items) => {
                    let count = items.len();
                    part.parse::<usize>().ok().and_then(|i| items.get_mut(i)).ok_or_else(|| {
                        refuse(assignment, format!("`{part}` is no index; accepted: 0 to {}", count.saturating_sub(1)))
                    })?
                }
                _ => return Err(refuse(assignment, format!("`{part}` lies below a plain value"))),
            };
        }
        match (at, parsed.get("v")) {
            (toml::Value::Table(table), Some(value)) => table.insert(key.to_owned(), value.clone()),
            _ => return Err(refuse(assignment, format!("`{key}` is not a key of a table"))),
        };
    }
    toml::to_string(&root).map_err(|e| refuse(&overrides.join(" "), e.to_string()))
}

impl Checker<'_> {
    fn place(&self, span: &Range<usize>) -> Place {
        let until = span.start.min(self.text.len());
        let line = 1 + self.text.as_bytes()[..until].iter().filter(|b| **b == b'\n').count();
        Place { file: self.path.to_owned(), line }
    }

    fn refuse<T>(&self, span: &Range<usize>, found: impl Into<String>, accepted: impl Into<String>) -> Result<T, StudyError> {
        Err(StudyError::Value { place: self.place(span), found: found.into(), accepted: accepted.into() })
    }

    /// A number that satisfies `ok`, or the default.
    fn number(
        &self, key: &str, value: &Option<Spanned<f64>>, default: f64, ok: impl Fn(f64) -> bool, accepted: &str,
    ) -> Result<f64, StudyError> {
        match value {
            None => Ok(default),
            Some(v) if v.get_ref().is_finite() && ok(*v.get_ref()) => Ok(*v.get_ref()),
            Some(v) => self.refuse(&v.span(), format!("{key} = {}", v.get_ref()), accepted),
        }
    }

    fn study(&self, raw: RawStudy) -> Result<Study, StudyError> {
        if *raw.schema_version.get_ref() != 1 {
            return self.refuse(&raw.schema_version.span(), format!("schema_version = {}", raw.schema_version.get_ref()), "1");
        }
        if raw.name.get_ref().trim().is_empty() {
            return self.refuse(&raw.name.span(), "an empty name", "a name for the report");
        }
        if raw.ride.is_empty() && raw.modes.is_empty() {
            return self.refuse(&raw.name.span(), "neither [[ride]] nor [[modes]]", "at least one of them");
        }
        let bicycle = match self.model {
            ModelKind::Benchmark => Some(self.bicycle(&raw)?),
            ModelKind::Multibody => None,
        };
        let tolerance_ratio =
            self.number("tolerance_ratio", &raw.bicycle.tolerance_ratio, 0.0, |x| (0.0..=1.0).contains(&x), "a number from 0 to 1")?;
        let mut tolerances = BTreeMap::new();
        for (symbol, tolerance) in &raw.bicycle.tolerances {
            if self.model == ModelKind::Benchmark && !SYMBOLS.contains(&symbol.get_ref().as_str()) {
                return self.refuse(&symbol.span(), format!("tolerance of `{}`", symbol.get_ref()), SYMBOLS.join(", "));
            }
            tolerances.insert(symbol.get_ref().clone(), self.tolerance(tolerance)?);
        }
        let mut values = BTreeMap::new();
        for (key, value) in &raw.bicycle.values {
            if !value.get_ref().is_finite() {
                return self.refuse(&value.span(), format!("{} = {}", key.get_ref(), value.get_ref()), "a finite number");
            }
            values.insert(key.get_ref().clone(), *value.get_ref());
        }
        Ok(Study {
            name: raw.name.get_ref().clone(),
            file: self.path.to_owned(),
            model: self.model,
            parameters: raw.bicycle.parameters.get_ref().clone(),
            tolerance_ratio,
            values,
            tolerances,
            bicycle,
            rides: raw.ride.iter().map(|r| self.ride(r)).collect::<Result<_, _>>()?,
            modes: raw.modes.iter().map(|m| self.modes(m)).collect::<Result<_, _>>()?,
        })
    }

    fn bicycle(&self, raw: &RawStudy) -> Result<Bicycle, StudyError> {
        let parameters = &raw.bicycle.parameters;
        let wrap = |span: Range<usize>, source| StudyError::Bicycle { place: self.place(&span), source };
        let beside = self.path.parent().unwrap_or(Path::new("")).join(parameters.get_ref());
        let name = if beside.is_file() { beside.to_string_lossy().into_owned() } else { parameters.get_ref().clone() };
        let mut bicycle = Bicycle::load(&name).map_err(|e| wrap(parameters.span(), e))?;
        for (symbol, value) in &raw.bicycle.values {
            bicycle.set(symbol.get_ref(), *value.get_ref()).map_err(|e| wrap(symbol.span(), e))?;
        }
        // The last value is where the whole set is complete.
        let span = raw.bicycle.values.values().map(|v| v.span()).max_by_key(|s| s.start).unwrap_or(parameters.span());
        twinhub_linear::Canonical::new(&bicycle).map_err(|e| wrap(span, e))?;
        Ok(bicycle)
    }

    fn tolerance(&self, raw: &Spanned<RawTolerance>) -> Result<Tolerance, StudyError> {
        let positive = |x: f64| x.is_finite() && x > 0.0;
        match raw.get_ref() {
            RawTolerance { ratio: Some(x), abs: None } if positive(*x) => Ok(Tolerance::Ratio(*x)),
            RawTolerance { ratio: None, abs: Some(x) } if positive(*x) => Ok(Tolerance::Absolute(*x)),
            RawTolerance { ratio, abs } => self.refuse(
                &raw.span(),
                format!("ratio {ratio:?}, abs {abs:?}"),
                "either { ratio = NUMBER } or { abs = NUMBER }, above zero",
            ),
        }
    }

    fn ride(&self, raw: &Spanned<RawRide>) -> Result<RideSpec, StudyError> {
        let ride = raw.get_ref();
        let (time, jitter) = self.time(ride)?;
        let channels = ride.channel.iter().map(|c| self.channel(c)).collect::<Result<Vec<_>, _>>()?;
        self.channel_set(&raw.span(), &channels, &ride.channel)?;
        Ok(RideSpec {
            file: ride.file.get_ref().clone(),
            place: self.place(&ride.file.span()),
            usage: ride.usage,
            rider: ride.rider.clone().unwrap_or_else(|| "none".to_owned()),
            hands: ride.hands,
            ground: ride.ground,
            time,
            clock_jitter_sd_s: jitter,
            windows: self.windows(ride)?,
            laws: ride.law.iter().map(|l| self.law(l)).collect::<Result<_, _>>()?,
            channels,
        })
    }

    fn time(&self, ride: &RawRide) -> Result<(TimeSpec, f64), StudyError> {
        let log = ride.file.get_ref().ends_with(".mcap");
        let Some(raw) = &ride.time else {
            return match log {
                true => Ok((TimeSpec::Log, 0.0)),
                false => self.refuse(&ride.file.span(), "a CSV ride without time", "time = { column = NAME } or { rate_hz = NUMBER }"),
            };
        };
        let (time, span) = (raw.get_ref(), raw.span());
        let spec = match (&time.column, time.rate_hz) {
            (None, None) if log => TimeSpec::Log,
            (Some(_), _) | (_, Some(_)) if log => {
                return self.refuse(&span, "a time column or rate for an MCAP log", "no such key: every topic has its own sample times");
            }
            (Some(column), None) => TimeSpec::Column(column.clone()),
            (None, Some(rate)) if rate.is_finite() && rate > 0.0 && rate <= 1e5 => TimeSpec::RateHz(rate),
            (column, rate) => {
                let found = format!("time with column {column:?} and rate_hz {rate:?}");
                return self.refuse(&span, found, "either { column = NAME } or { rate_hz = NUMBER } above 0, at most 1e5");
            }
        };
        let jitter = time.clock_jitter_sd_s.unwrap_or(0.0);
        match (0.0..=LONGEST_LAG_S).contains(&jitter) {
            true => Ok((spec, jitter)),
            false => self.refuse(&span, format!("clock_jitter_sd_s = {jitter}"), "0 to 10 s"),
        }
    }

    fn windows(&self, ride: &RawRide) -> Result<Option<Vec<WindowSpec>>, StudyError> {
        let Some(raw) = &ride.windows else { return Ok(None) };
        let mut windows: Vec<WindowSpec> = vec![];
        for window in raw {
            let [start_s, end_s] = window.get_ref().s;
            let before = windows.last().map(|w| w.end_s);
            let ordered = start_s.is_finite() && end_s.is_finite() && start_s < end_s;
            if !ordered || before.is_some_and(|b| start_s < b) {
                let found = match before {
                    Some(b) if ordered => format!("window [{start_s}, {end_s}] after one that ends at {b}"),
                    _ => format!("window [{start_s}, {end_s}]"),
                };
                return self.refuse(&window.span(), found, "[a, b] in seconds with a < b, ordered and not overlapping");
            }
            windows.push(WindowSpec {
                start_s,
                end_s,
                usage: window.get_ref().usage.unwrap_or(ride.usage),
                place: self.place(&window.span()),
            });
        }
        match windows.is_empty() {
            true => self.refuse(&ride.file.span(), "windows = []", "at least one window, or no `windows` for the whole ride"),
            false => Ok(Some(windows)),
        }
    }

    fn channel_set(&self, ride: &Range<usize>, channels: &[ChannelSpec], raw: &[Spanned<RawChannel>]) -> Result<(), StudyError> {
        let used = |c: &&ChannelSpec| c.role != Role::Check;
        match channels.iter().filter(used).filter(|c| c.quantity == Quantity::Speed).count() {
            1 => {}
            0 => return self.refuse(ride, "a ride without speed_m_s", "one speed_m_s channel with role input or output"),
            n => {
                let second = raw.iter().filter(|c| *c.get_ref().quantity.get_ref() == Quantity::Speed && *c.get_ref().role.get_ref() != Role::Check).nth(1);
                return self.refuse(&second.map_or(ride.clone(), |c| c.span()), format!("{n} speed_m_s channels"), "one with role input or output, others as check");
            }
        }
        if !channels.iter().any(|c| c.role == Role::Output) {
            return self.refuse(ride, "a ride without outputs", "at least one channel with role output");
        }
        for (index, channel) in channels.iter().enumerate() {
            let again = channels[..index].iter().any(|c| c.role == Role::Input && channel.role == Role::Input && c.quantity == channel.quantity);
            // Two ropes may pull at two places.
            if again && channel.quantity != Quantity::LateralForce {
                return self.refuse(&raw[index].span(), format!("a second input {}", channel.quantity), "each input quantity once");
            }
        }
        Ok(())
    }

    fn channel(&self, spanned: &Spanned<RawChannel>) -> Result<ChannelSpec, StudyError> {
        let raw = spanned.get_ref();
        let (quantity, role) = (*raw.quantity.get_ref(), *raw.role.get_ref());
        let benchmark = self.model == ModelKind::Benchmark;
        let list = |ok: fn(Quantity) -> bool| {
            let names = Quantity::NAMES.iter().filter(|n| serde_json::from_value::<Quantity>((**n).into()).is_ok_and(ok));
            names.copied().collect::<Vec<_>>().join(", ")
        };
        if benchmark && role == Role::Input && !quantity.drives_benchmark() {
            let accepted = format!("inputs of the benchmark model: {} (or role = \"output\" or \"check\")", list(Quantity::drives_benchmark));
            return self.refuse(&raw.quantity.span(), format!("input {quantity}"), accepted);
        }
        if benchmark && role == Role::Output && !quantity.predicted_by_benchmark() {
            let accepted = format!("outputs of the benchmark model: {} (or role = \"input\" or \"check\")", list(Quantity::predicted_by_benchmark));
            return self.refuse(&raw.quantity.span(), format!("output {quantity}"), accepted);
        }
        let pair = |key: &str, value: &Option<Spanned<[f64; 2]>>| match value {
            Some(v) if v.get_ref().iter().any(|x| !x.is_finite() || x.abs() > 10.0) => {
                self.refuse(&v.span(), format!("{key} = {:?}", v.get_ref()), "two finite numbers within 10 m")
            }
            Some(v) => Ok(Some(*v.get_ref())),
            None => Ok(None),
        };
        let arm_m = pair("arm_m", &raw.arm_m)?;
        let point_m = pair("point_m", &raw.point_m)?;
        let force = role == Role::Input && quantity == Quantity::LateralForce;
        if force && (arm_m.is_some() == point_m.is_some()) {
            let found = "lateral_force_n with both or neither of arm_m and point_m";
            return self.refuse(&spanned.span(), found, "arm_m = [roll, steer torque per newton] or point_m = [x, z] of its application");
        }
        let accelerometer = benchmark && role == Role::Output && quantity == Quantity::LateralAccel;
        if accelerometer && point_m.is_none() {
            return self.refuse(&spanned.span(), "lateral_accel_m_s2 without point_m", "point_m = [x, z] of the sensor from the rear contact");
        }
        let hold = raw.hold.as_ref().map_or(HoldKind::Linear, |h| *h.get_ref());
        let not_negative = |x: f64| x >= 0.0;
        let lag = |x: f64| (0.0..=LONGEST_LAG_S).contains(&x);
        let lowpass_hz = self.number("lowpass_hz", &raw.lowpass_hz, 0.0, not_negative, "0 (none) or more")?;
        if let Some(v) = &raw.lowpass_hz
            && lowpass_hz > 0.0
            && role == Role::Input
            && hold == HoldKind::Zero
        {
            return self.refuse(&v.span(), "lowpass_hz on an input with hold = \"zero\"", "hold = \"linear\": a step cannot have passed the filter");
        }
        let noise_sd = match &raw.noise_sd {
            None => None,
            some => Some(self.number("noise_sd", some, 0.0, |x| x > 0.0, "a number above 0, or no noise_sd: then it is estimated")?),
        };
        Ok(ChannelSpec {
            column: raw.column.get_ref().clone(),
            quantity,
            role,
            scale: self.number("scale", &raw.scale, 1.0, |x| x != 0.0, "a finite number other than 0")?,
            offset: self.number("offset", &raw.offset, 0.0, |_| true, "a finite number")?,
            arm_m,
            point_m,
            noise_sd,
            bias_sd: self.number("bias_sd", &raw.bias_sd, 0.0, not_negative, "0 (none) or more")?,
            delay_s: self.number("delay_s", &raw.delay_s, 0.0, lag, "0 to 10 s")?,
            quantum: self.number("quantum", &raw.quantum, 0.0, not_negative, "0 (none) or more")?,
            lowpass_hz,
            moving_average_s: self.number("moving_average_s", &raw.moving_average_s, 0.0, lag, "0 (none) to 10 s")?,
            hold,
            place: self.place(&raw.column.span()),
        })
    }

    fn law(&self, raw: &Spanned<RawLaw>) -> Result<LawSpec, StudyError> {
        let law = raw.get_ref();
        let quantity = *law.quantity.get_ref();
        if !matches!(quantity, Quantity::SteerTorque | Quantity::RollTorque) {
            return self.refuse(&law.quantity.span(), format!("a law for {quantity}"), "steer_torque_nm, roll_torque_nm");
        }
        let of = *law.of.get_ref();
        let states = [Quantity::Roll, Quantity::RollRate, Quantity::Steer, Quantity::SteerRate, Quantity::YawRate];
        if !states.contains(&of) {
            let accepted = states.map(Quantity::name).join(", ");
            return self.refuse(&law.of.span(), format!("a law of {of}"), accepted);
        }
        let speed0_m_s = match (law.kind, &law.speed0_m_s) {
            (LawKind::SpeedScheduledRate, None) => {
                return self.refuse(&raw.span(), "kind = \"speed_scheduled_rate\" without speed0_m_s", "speed0_m_s = NUMBER");
            }
            (LawKind::Linear, Some(v)) => {
                return self.refuse(&v.span(), "speed0_m_s with kind = \"linear\"", "no speed0_m_s, or kind = \"speed_scheduled_rate\"");
            }
            (_, None) => None,
            (_, some) => Some(self.number("speed0_m_s", some, 0.0, |x| x > 0.0 && x < 100.0, "above 0, below 100 m/s")?),
        };
        Ok(LawSpec {
            quantity,
            kind: law.kind,
            of,
            gain: self.number("gain", &Some(Spanned::new(law.gain.span(), *law.gain.get_ref())), 0.0, |_| true, "a finite number")?,
            speed0_m_s,
            limit_nm: self.number("limit_nm", &law.limit_nm, f64::INFINITY, |x| x > 0.0, "above 0 Nm")?,
            delay_s: self.number("delay_s", &law.delay_s, 0.0, |x| (0.0..=LONGEST_LAG_S).contains(&x), "0 to 10 s")?,
        })
    }

    fn modes(&self, raw: &Spanned<RawModes>) -> Result<ModesSpec, StudyError> {
        let modes = raw.get_ref();
        let sd = modes.sd.get_ref();
        if [sd.sigma_1_s, sd.omega_rad_s].iter().any(|x| !x.is_finite() || *x <= 0.0) {
            let found = format!("sd of {} 1/s and {} rad/s", sd.sigma_1_s, sd.omega_rad_s);
            return self.refuse(&modes.sd.span(), found, "two numbers above 0");
        }
        Ok(ModesSpec {
            file: modes.file.get_ref().clone(),
            place: self.place(&modes.file.span()),
            usage: modes.usage,
            speed_column: modes.columns.speed_m_s.clone(),
            sigma_column: modes.columns.sigma_1_s.clone(),
            omega_column: modes.columns.omega_rad_s.clone(),
            sigma_sd_1_s: sd.sigma_1_s,
            omega_sd_rad_s: sd.omega_rad_s,
            law: modes.law.as_ref().map(|l| self.law(l)).transpose()?,
        })
    }
}

impl Use {
    /// Whether parameters or noise levels may be fitted on it.
    pub fn is_fit(self) -> bool {
        self == Self::Fit
    }
}
