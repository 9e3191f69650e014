//! Gains that follow speed: straight lines between the rows of a table, constant beyond it.

use super::{RiderError, in_range};
use serde::{Deserialize, Serialize};

/// One row of a gain table.
pub trait GainRow: Copy {
    /// Speed of this row, m/s.
    fn speed_m_s(&self) -> f64;
    /// The row at `speed_m_s`, a share `s` of the way from this row to `other`.
    fn mixed(&self, other: &Self, s: f64, speed_m_s: f64) -> Self;
    /// Every gain with its key.
    fn gains(&self) -> Vec<(&'static str, f64)>;
}

/// The gains at a speed; the table has at least one row.
pub fn gains_at<R: GainRow>(table: &[R], speed_m_s: f64) -> R {
    match table.iter().position(|row| row.speed_m_s() > speed_m_s) {
        None => table[table.len() - 1],
        Some(0) => table[0],
        Some(i) => {
            let (a, b) = (&table[i - 1], &table[i]);
            let s = (speed_m_s - a.speed_m_s()) / (b.speed_m_s() - a.speed_m_s());
            a.mixed(b, s, speed_m_s)
        }
    }
}

/// Refuses an empty table, speeds that do not rise, and absurd numbers.
pub(super) fn check_table<R: GainRow>(table: &[R]) -> Result<(), RiderError> {
    let rising = |w: &[R]| w[0].speed_m_s() < w[1].speed_m_s();
    if table.is_empty() || !table.windows(2).all(rising) {
        return Err(RiderError::GainTable);
    }
    for row in table {
        in_range("gains.speed_m_s", row.speed_m_s(), 0.0, 30.0, "0 to 30 m/s")?;
        for (key, value) in row.gains() {
            in_range(key, value, -1e3, 1e3, "-1000 to 1000")?;
        }
    }
    Ok(())
}

/// Gains from what is perceived to torque on the handlebar.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TorqueGains {
    /// Speed of this row, m/s.
    pub speed_m_s: f64,
    /// k_p, Nm/rad: torque out of the lean per roll angle.
    pub roll_nm_rad: f64,
    /// k_d, Nm s/rad: torque out of the lean per roll rate.
    pub roll_rate_nms_rad: f64,
    /// k_h, Nm/rad: torque against the heading error.
    pub heading_nm_rad: f64,
    /// k_s, Nm/rad: torque against the steer angle; absent means none.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub steer_nm_rad: f64,
    /// k_r, Nm s/rad: torque against the steer rate; absent means none.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub steer_rate_nms_rad: f64,
}

/// Gains from what is perceived to an angle that is asked for: of the handlebar, the trunk or the
/// knees.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AngleGains {
    /// Speed of this row, m/s.
    pub speed_m_s: f64,
    /// Angle against the lean per roll angle, rad/rad.
    pub roll_ratio: f64,
    /// Angle against the lean per roll rate, rad per rad/s.
    pub roll_rate_s: f64,
    /// Angle against the heading error, rad/rad; absent means none.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub heading_ratio: f64,
}

#[allow(clippy::trivially_copy_pass_by_ref)] // the signature that serde asks for
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

fn mix(x: f64, y: f64, s: f64) -> f64 {
    x + s * (y - x)
}

impl GainRow for TorqueGains {
    fn speed_m_s(&self) -> f64 {
        self.speed_m_s
    }
    fn mixed(&self, b: &Self, s: f64, speed_m_s: f64) -> Self {
        Self {
            speed_m_s,
            roll_nm_rad: mix(self.roll_nm_rad, b.roll_nm_rad, s),
            roll_rate_nms_rad: mix(self.roll_rate_nms_rad, b.roll_rate_nms_rad, s),
            heading_nm_rad: mix(self.heading_nm_rad, b.heading_nm_rad, s),
            steer_nm_rad: mix(self.steer_nm_rad, b.steer_nm_rad, s),
            steer_rate_nms_rad: mix(self.steer_rate_nms_rad, b.steer_rate_nms_rad, s),
        }
    }
    fn gains(&self) -> Vec<(&'static str, f64)> {
        vec![
            ("gains.roll_nm_rad", self.roll_nm_rad),
            ("gains.roll_rate_nms_rad", self.roll_rate_nms_rad),
            ("gains.heading_nm_rad", self.heading_nm_rad),
            ("gains.steer_nm_rad", self.steer_nm_rad),
            ("gains.steer_rate_nms_rad", self.steer_rate_nms_rad),
        ]
    }
}

impl GainRow for AngleGains {
    fn speed_m_s(&self) -> f64 {
        self.speed_m_s
    }
    fn mixed(&self, b: &Self, s: f64, speed_m_s: f64) -> Self {
        Self {
            speed_m_s,
            roll_ratio: mix(self.roll_ratio, b.roll_ratio, s),
            roll_rate_s: mix(self.roll_rate_s, b.roll_rate_s, s),
            heading_ratio: mix(self.heading_ratio, b.heading_ratio, s),
        }
    }
    fn gains(&self) -> Vec<(&'static str, f64)> {
        vec![
            ("gains.roll_ratio", self.roll_ratio),
            ("gains.roll_rate_s", self.roll_rate_s),
            ("gains.heading_ratio", self.heading_ratio),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gains_follow_speed_and_stay_constant_beyond_the_table() {
        let row = |speed_m_s, roll_ratio| AngleGains {
            speed_m_s,
            roll_ratio,
            ..AngleGains::default()
        };
        let table = [row(4.0, 20.0), row(6.0, 10.0)];
        assert_eq!(gains_at(&table, 5.0).roll_ratio, 15.0);
        assert_eq!(gains_at(&table, 1.0).roll_ratio, 20.0);
        assert_eq!(gains_at(&table, 9.0).roll_ratio, 10.0);
        assert!(check_table(&table).is_ok());
        assert_eq!(
            check_table(&[table[1], table[0]]),
            Err(RiderError::GainTable)
        );
        assert_eq!(check_table::<AngleGains>(&[]), Err(RiderError::GainTable));
        assert!(check_table(&[row(4.0, f64::NAN)]).is_err());
    }
}
