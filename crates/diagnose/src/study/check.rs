//! From the file to a checked study.

use super::raw::{RawModes, RawStudy, RawTolerance};
use super::{ModelKind, ModesSpec, Place, Study, StudyError, Tolerance, Use};
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;
use toml::Spanned;
use twinhub_linear::{Bicycle, SYMBOLS};

/// Longest delay, running mean and jitter that make sense.
pub(super) const LONGEST_LAG_S: f64 = 10.0;

pub(super) struct Checker<'a> {
    text: &'a str,
    path: &'a Path,
    pub(super) model: ModelKind,
}

pub(super) fn parse(text: &str, path: &Path) -> Result<Study, StudyError> {
    let line = |at: usize| {
        1 + text.as_bytes()[..at.min(text.len())]
            .iter()
            .filter(|b| **b == b'\n')
            .count()
    };
    let raw: RawStudy = toml::from_str(text).map_err(|error| StudyError::Syntax {
        place: Place {
            file: path.to_owned(),
            line: error.span().map_or(1, |s| line(s.start)),
        },
        message: error.message().trim().replace('\n', ", "),
    })?;
    Checker {
        text,
        path,
        model: raw.bicycle.model,
    }
    .study(raw)
}

impl Checker<'_> {
    pub(super) fn place(&self, span: &Range<usize>) -> Place {
        let until = span.start.min(self.text.len());
        let line = 1 + self.text.as_bytes()[..until]
            .iter()
            .filter(|b| **b == b'\n')
            .count();
        Place {
            file: self.path.to_owned(),
            line,
        }
    }

    pub(super) fn refuse<T>(
        &self,
        span: &Range<usize>,
        found: impl Into<String>,
        accepted: impl Into<String>,
    ) -> Result<T, StudyError> {
        Err(StudyError::Value {
            place: self.place(span),
            found: found.into(),
            accepted: accepted.into(),
        })
    }

    /// A number that satisfies `ok`, or the default.
    pub(super) fn number(
        &self,
        key: &str,
        value: &Option<Spanned<f64>>,
        default: f64,
        ok: impl Fn(f64) -> bool,
        accepted: &str,
    ) -> Result<f64, StudyError> {
        match value {
            None => Ok(default),
            Some(v) if v.get_ref().is_finite() && ok(*v.get_ref()) => Ok(*v.get_ref()),
            Some(v) => self.refuse(&v.span(), format!("{key} = {}", v.get_ref()), accepted),
        }
    }

    fn study(&self, raw: RawStudy) -> Result<Study, StudyError> {
        if *raw.schema_version.get_ref() != 1 {
            return self.refuse(
                &raw.schema_version.span(),
                format!("schema_version = {}", raw.schema_version.get_ref()),
                "1",
            );
        }
        if raw.name.get_ref().trim().is_empty() {
            return self.refuse(&raw.name.span(), "an empty name", "a name for the report");
        }
        if raw.ride.is_empty() && raw.modes.is_empty() {
            return self.refuse(
                &raw.name.span(),
                "neither [[ride]] nor [[modes]]",
                "at least one of them",
            );
        }
        let bicycle = match self.model {
            ModelKind::Benchmark => Some(self.bicycle(&raw)?),
            ModelKind::Multibody => None,
        };
        let tolerance_ratio = self.number(
            "tolerance_ratio",
            &raw.bicycle.tolerance_ratio,
            0.0,
            |x| (0.0..=1.0).contains(&x),
            "a number from 0 to 1",
        )?;
        let mut tolerances = BTreeMap::new();
        for (symbol, tolerance) in &raw.bicycle.tolerances {
            if self.model == ModelKind::Benchmark && !SYMBOLS.contains(&symbol.get_ref().as_str()) {
                return self.refuse(
                    &symbol.span(),
                    format!("tolerance of `{}`", symbol.get_ref()),
                    SYMBOLS.join(", "),
                );
            }
            tolerances.insert(symbol.get_ref().clone(), self.tolerance(tolerance)?);
        }
        let mut values = BTreeMap::new();
        for (key, value) in &raw.bicycle.values {
            if !value.get_ref().is_finite() {
                return self.refuse(
                    &value.span(),
                    format!("{} = {}", key.get_ref(), value.get_ref()),
                    "a finite number",
                );
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
            rides: raw
                .ride
                .iter()
                .map(|r| self.ride(r))
                .collect::<Result<_, _>>()?,
            modes: raw
                .modes
                .iter()
                .map(|m| self.modes(m))
                .collect::<Result<_, _>>()?,
        })
    }

    fn bicycle(&self, raw: &RawStudy) -> Result<Bicycle, StudyError> {
        let parameters = &raw.bicycle.parameters;
        let wrap = |span: Range<usize>, source| StudyError::Bicycle {
            place: self.place(&span),
            source: Box::new(source),
        };
        let beside = self
            .path
            .parent()
            .unwrap_or(Path::new(""))
            .join(parameters.get_ref());
        let name = if beside.is_file() {
            beside.to_string_lossy().into_owned()
        } else {
            parameters.get_ref().clone()
        };
        let mut bicycle = Bicycle::load(&name).map_err(|e| wrap(parameters.span(), e))?;
        for (symbol, value) in &raw.bicycle.values {
            bicycle
                .set(symbol.get_ref(), *value.get_ref())
                .map_err(|e| wrap(symbol.span(), e))?;
        }
        // The last value is where the whole set is complete.
        let span = raw
            .bicycle
            .values
            .values()
            .map(|v| v.span())
            .max_by_key(|s| s.start)
            .unwrap_or(parameters.span());
        twinhub_linear::Canonical::new(&bicycle).map_err(|e| wrap(span, e))?;
        Ok(bicycle)
    }

    fn tolerance(&self, raw: &Spanned<RawTolerance>) -> Result<Tolerance, StudyError> {
        let positive = |x: f64| x.is_finite() && x > 0.0;
        match raw.get_ref() {
            RawTolerance {
                ratio: Some(x),
                abs: None,
            } if positive(*x) => Ok(Tolerance::Ratio(*x)),
            RawTolerance {
                ratio: None,
                abs: Some(x),
            } if positive(*x) => Ok(Tolerance::Absolute(*x)),
            RawTolerance { ratio, abs } => self.refuse(
                &raw.span(),
                format!("ratio {ratio:?}, abs {abs:?}"),
                "either { ratio = NUMBER } or { abs = NUMBER }, above zero",
            ),
        }
    }

    fn modes(&self, raw: &Spanned<RawModes>) -> Result<ModesSpec, StudyError> {
        let modes = raw.get_ref();
        let sd = modes.sd.get_ref();
        if [sd.sigma_1_s, sd.omega_rad_s]
            .iter()
            .any(|x| !x.is_finite() || *x <= 0.0)
        {
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
