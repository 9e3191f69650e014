//! What: the riders of Bulsink (2017), as printed, and as riders that can ride.
//!
//! Equation: table 6.2: steer torque; 6.3: steer angle; 6.4: lean of the upper body; each
//! (P + D s) e^(-τ s) of the roll angle.
//!
//! Source: Bulsink (2017), tables 6.2 to 6.4 (`data/bulsink2017_riders.toml`, which says how units
//! and signs are read).
//!
//! Assumes and ignores: signs are read from axes with z up: P < 0 pulls or steers into the lean, and
//! leans the trunk against the roll. Angles are imposed by stiff limbs. No lag of muscles was
//! fitted; 200 rad/s stands for none. Remnants are not published and left out.
//!
//! Valid for: the printed speeds; riders over speed interpolate between them, with the mean of the
//! printed delays.
//!
//! Checked by: `rider/tests`: which of them keep which bicycle up.

use super::{
    AngleGains, AngleParameters, Channels, PedalsParameters, RiderFile, SteerAngleParameters,
    SteerTorqueParameters, TorqueGains, TrunkLeanParameters,
};
use serde::Deserialize;
use std::sync::OnceLock;

/// The tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
pub enum Table {
    /// Table 6.2.
    #[serde(rename = "6.2")]
    SteerTorque,
    /// Table 6.3.
    #[serde(rename = "6.3")]
    SteerAngle,
    /// Table 6.4.
    #[serde(rename = "6.4")]
    TrunkLean,
}

/// The groups of riders.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Group {
    /// 25.3 ± 2.8 years.
    Young,
    /// 58.1 ± 2.1 years.
    Older,
}

/// Mean and standard deviation over the subjects of a group.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Spread {
    /// Mean.
    pub mean: f64,
    /// Standard deviation.
    pub sd: f64,
}

/// One printed row. P and D are in Nm/rad and Nm s/rad (steer torque) or rad/rad and s (angles).
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Row {
    /// The table.
    pub table: Table,
    /// The group.
    pub group: Group,
    /// Speed, m/s.
    pub speed_m_s: f64,
    /// Proportional gain, sign as printed.
    pub p: Spread,
    /// Derivative gain, sign as printed.
    pub d: Spread,
    /// Delay, s.
    pub delay_s: Spread,
    /// Variance accounted for by the fit, percent.
    pub vaf_percent: Spread,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    source: String,
    row: Vec<Row>,
}

/// Frequency of the muscles' lag that stands for none, rad/s.
const NO_LAG_RAD_S: f64 = 200.0;
/// Stiffness and damping of arms that impose a steer angle, Nm/rad and Nm s/rad: a guess, twenty
/// times what steering needs.
const STIFF_ARMS: (f64, f64) = (500.0, 20.0);
/// The same for the trunk on its passive 1000 Nm/rad.
const STIFF_TRUNK: (f64, f64) = (2000.0, 200.0);

fn file() -> &'static File {
    static FILE: OnceLock<File> = OnceLock::new();
    FILE.get_or_init(|| {
        toml::from_str(include_str!("../../data/bulsink2017_riders.toml"))
            .expect("the shipped file is what its test reads")
    })
}

/// The rows of a table, as printed: young then older, fastest first.
pub fn rows(table: Table) -> Vec<Row> {
    let of_table = |row: &&Row| row.table == table;
    file().row.iter().filter(of_table).copied().collect()
}

/// Where the tables stand.
pub fn source() -> &'static str {
    &file().source
}

impl Table {
    /// All tables.
    pub const ALL: [Self; 3] = [Self::SteerTorque, Self::SteerAngle, Self::TrunkLean];

    /// Its number in the thesis.
    pub const fn number(self) -> &'static str {
        match self {
            Self::SteerTorque => "6.2",
            Self::SteerAngle => "6.3",
            Self::TrunkLean => "6.4",
        }
    }

    /// The channel of the registry.
    pub const fn channel(self) -> &'static str {
        match self {
            Self::SteerTorque => "steer_torque",
            Self::SteerAngle => "steer_angle",
            Self::TrunkLean => "trunk_lean",
        }
    }
}

impl Group {
    /// Both groups.
    pub const ALL: [Self; 2] = [Self::Young, Self::Older];

    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Young => "young",
            Self::Older => "older",
        }
    }
}

impl Row {
    /// The rider of this row alone.
    pub fn rider(&self) -> RiderFile {
        rider_of(&[*self])
    }
}

/// The rider of a table and group over all its speeds.
pub fn rider(table: Table, group: Group) -> RiderFile {
    let mut rows = rows(table);
    rows.retain(|row| row.group == group);
    rider_of(&rows)
}

/// A rider with the gains of `rows`, all of one table and group, and the mean of their delays.
fn rider_of(rows: &[Row]) -> RiderFile {
    let mut rows = rows.to_vec();
    rows.sort_by(|a, b| a.speed_m_s.total_cmp(&b.speed_m_s));
    let first = rows[0];
    let delay_s = rows.iter().map(|r| r.delay_s.mean).sum::<f64>() / rows.len() as f64;
    let mut channels = Channels::default();
    let angle =
        |(stiffness_nm_rad, damping_nm_s_rad), sign: f64, torque_limit_nm| AngleParameters {
            delay_s,
            neuromuscular_rad_s: NO_LAG_RAD_S,
            neuromuscular_damping_ratio: 1.0,
            remnant_sd_rad: 0.0,
            remnant_bandwidth_rad_s: 6.0,
            stiffness_nm_rad,
            damping_nm_s_rad,
            angle_limit_rad: 1.0,
            torque_limit_nm,
            gains: rows
                .iter()
                .map(|r| AngleGains {
                    speed_m_s: r.speed_m_s,
                    roll_ratio: sign * r.p.mean,
                    roll_rate_s: sign * r.d.mean,
                    heading_ratio: 0.0,
                })
                .collect(),
        };
    match first.table {
        Table::SteerTorque => {
            channels.steer_torque = Some(SteerTorqueParameters {
                delay_s,
                neuromuscular_rad_s: NO_LAG_RAD_S,
                neuromuscular_damping_ratio: 1.0,
                remnant_sd_nm: 0.0,
                remnant_bandwidth_rad_s: 6.0,
                torque_limit_nm: 60.0,
                gains: rows
                    .iter()
                    .map(|r| TorqueGains {
                        speed_m_s: r.speed_m_s,
                        roll_nm_rad: r.p.mean,
                        roll_rate_nms_rad: r.d.mean,
                        ..TorqueGains::default()
                    })
                    .collect(),
            });
        }
        Table::SteerAngle => {
            channels.steer_angle = Some(SteerAngleParameters(angle(STIFF_ARMS, 1.0, 100.0)));
        }
        // Lean keeps its sign when z turns down, steer does not.
        Table::TrunkLean => {
            channels.trunk_lean = Some(TrunkLeanParameters(angle(STIFF_TRUNK, -1.0, 500.0)));
        }
    }
    RiderFile {
        schema_version: 1,
        about: format!(
            "Table {} of the thesis as printed, {} riders",
            first.table.number(),
            first.group.name()
        ),
        source: format!("{}, table {}", source(), first.table.number()),
        rider: channels,
        pedals: PedalsParameters {
            speed_gain_ns_m: 1000.0,
            force_limit_n: 150.0,
        },
    }
}
