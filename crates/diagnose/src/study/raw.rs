//! The study file as serde reads it, with the place of everything that is checked afterwards.

use crate::quantity::Quantity;
use crate::study::{Ground, Hands, HoldKind, LawKind, ModelKind, Role, Use};
use serde::Deserialize;
use std::collections::BTreeMap;
use toml::Spanned;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawStudy {
    pub schema_version: Spanned<i64>,
    pub name: Spanned<String>,
    pub bicycle: RawBicycle,
    #[serde(default)]
    pub ride: Vec<Spanned<RawRide>>,
    #[serde(default)]
    pub modes: Vec<Spanned<RawModes>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawBicycle {
    pub model: ModelKind,
    pub parameters: Spanned<String>,
    pub tolerance_ratio: Option<Spanned<f64>>,
    #[serde(default)]
    pub values: BTreeMap<Spanned<String>, Spanned<f64>>,
    #[serde(default)]
    pub tolerances: BTreeMap<Spanned<String>, Spanned<RawTolerance>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawTolerance {
    pub ratio: Option<f64>,
    pub abs: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawRide {
    pub file: Spanned<String>,
    #[serde(rename = "use")]
    pub usage: Use,
    pub rider: Option<String>,
    pub hands: Option<Hands>,
    pub ground: Option<Ground>,
    pub time: Option<Spanned<RawTime>>,
    pub windows: Option<Vec<Spanned<RawWindow>>>,
    #[serde(default)]
    pub channel: Vec<Spanned<RawChannel>>,
    #[serde(default)]
    pub law: Vec<Spanned<RawLaw>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawTime {
    pub column: Option<String>,
    pub rate_hz: Option<f64>,
    pub clock_jitter_sd_s: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawWindow {
    pub s: [f64; 2],
    #[serde(rename = "use")]
    pub usage: Option<Use>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawChannel {
    pub column: Spanned<String>,
    pub quantity: Spanned<Quantity>,
    pub role: Spanned<Role>,
    pub scale: Option<Spanned<f64>>,
    pub offset: Option<Spanned<f64>>,
    pub arm_m: Option<Spanned<[f64; 2]>>,
    pub point_m: Option<Spanned<[f64; 2]>>,
    pub noise_sd: Option<Spanned<f64>>,
    pub bias_sd: Option<Spanned<f64>>,
    pub delay_s: Option<Spanned<f64>>,
    pub quantum: Option<Spanned<f64>>,
    pub lowpass_hz: Option<Spanned<f64>>,
    pub moving_average_s: Option<Spanned<f64>>,
    pub hold: Option<Spanned<HoldKind>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawLaw {
    pub quantity: Spanned<Quantity>,
    pub kind: LawKind,
    pub of: Spanned<Quantity>,
    pub gain: Spanned<f64>,
    pub speed0_m_s: Option<Spanned<f64>>,
    pub limit_nm: Option<Spanned<f64>>,
    pub delay_s: Option<Spanned<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawModes {
    pub file: Spanned<String>,
    #[serde(rename = "use")]
    pub usage: Use,
    pub columns: RawModeColumns,
    pub sd: Spanned<RawModeSd>,
    pub law: Option<Spanned<RawLaw>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawModeColumns {
    pub speed_m_s: String,
    pub sigma_1_s: String,
    pub omega_rad_s: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawModeSd {
    pub sigma_1_s: f64,
    pub omega_rad_s: f64,
}
