//! The thresholds of a diagnosis, read from the one file that holds them.

use serde::Deserialize;
use std::sync::LazyLock;

const TEXT: &str = include_str!("../../thresholds.toml");

/// See `thresholds.toml` for what each one means.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Thresholds {
    pub calibration_box_sd: f64,
    pub calibration_least_nats: f64,
    pub false_discovery_rate: f64,
    pub refits: usize,
    pub tolerance_refits: usize,
    pub sketch_share: f64,
    pub screened: usize,
    pub block_s: f64,
    pub held_out_z: f64,
    pub held_out_nats: f64,
    pub evidence_nats: f64,
    pub sparse_nats: f64,
    pub later_nats: f64,
    pub random_share_of_blocks: f64,
    pub set_z: f64,
    pub set_nats: f64,
    pub set_correlation: f64,
    pub set_share: f64,
    pub near_share: f64,
    pub believed_deviation_sd: f64,
    pub most_causes: usize,
    pub least_share: f64,
    pub most_confirmed: usize,
    pub elimination_nats: f64,
    pub clean_p_value: f64,
    pub least_vaf: f64,
    pub foreseeable_vaf: f64,
    pub most_vaf_loss: f64,
    pub unknown_p_value: f64,
    pub refuted_share: f64,
    pub band_p_value: f64,
    pub agreement_p_value: f64,
    pub agreement_share: f64,
    pub one_bicycle_p_value: f64,
    pub dead_input_gain: f64,
    pub dead_input_z: f64,
    pub limit_nats: f64,
    pub limit_z: f64,
    pub pair_correlation: f64,
    pub clock_jitter_sd: f64,
}

/// The thresholds in force.
pub static THRESHOLDS: LazyLock<Thresholds> =
    LazyLock::new(|| toml::from_str(TEXT).expect("thresholds.toml is part of the program"));

/// Hash of the file, 16 digits.
pub fn hash() -> String {
    blake3::hash(TEXT.as_bytes()).to_hex()[..16].to_owned()
}
