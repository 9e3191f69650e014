//! What: the rider controllers of chapter 6 on the bicycle of chapter 3: do they keep it up?
//!
//! Equation: x' = A x + b T with s(t) = P φ(t - τ) + D φ'(t - τ). Table 6.2: T = -s on the bar. Table
//! 6.3: T = K (-s - δ) - C δ' (arms that impose the angle). Table 6.4: the same on trunk lean with
//! s for -s, for lean keeps its sign when z turns down and steer does not. The delay is a chain of
//! all-pass sections of first order, each (1 - s τ/2n) / (1 + s τ/2n).
//!
//! Source: Bulsink (2017), tables 6.2 to 6.4: means over riders who stayed up on rollers and
//! treadmill.
//!
//! Assumes and ignores: each table's channel alone; no lag of muscles; K and C are guesses, stiff
//! enough to impose the angle. Rigid rider (case 6) for tables 6.2 and 6.3, passive rider without
//! arms for 6.4.
//!
//! Valid for: the printed speeds.
//!
//! Checked by: `a_chain_of_sections_is_a_delay` here, `tests/reproduction.rs`.

use crate::assumed::Assumed;
use crate::error::ReproduceError;
use crate::row::Row;
use nalgebra::{DMatrix, DVector};
use twinhub_plant::multibody::{Case, Course, INPUTS, Multibody};
use twinhub_plant::rider::published::{self, Table};

/// Sections of a delay.
const SECTIONS: usize = 12;

/// A limb: the input that it drives, its sign, and how it imposes an angle (state, rate, K, C).
struct Limb {
    input: &'static str,
    sign: f64,
    imposes: Option<(&'static str, &'static str, f64, f64)>,
}

const BAR_TORQUE: Limb = Limb {
    input: "steer_torque_nm",
    sign: -1.0,
    imposes: None,
};
const BAR_ANGLE: Limb = Limb {
    input: "steer_torque_nm",
    sign: -1.0,
    imposes: Some(("steer_rad", "steer_rate_rad_s", 500.0, 20.0)),
};
const TRUNK_LEAN: Limb = Limb {
    input: "trunk_lean_torque_nm",
    sign: 1.0,
    imposes: Some(("trunk_lean_rad", "trunk_lean_rate_rad_s", 2000.0, 200.0)),
};

/// Largest growth rate of the bicycle with this rider, 1/s.
fn growth_per_s(
    model: &Multibody,
    limb: &Limb,
    row: &published::Row,
) -> Result<f64, ReproduceError> {
    let linear = model.linear(&Course::straight(row.speed_m_s))?.lateral();
    let n = linear.a.nrows();
    let unit = |name: &str| {
        let at = linear.index(name);
        DVector::from_fn(n, |i, _| if Some(i) == at { 1.0 } else { 0.0 })
    };
    let column = INPUTS.iter().position(|i| *i == limb.input).unwrap_or(0);
    let b = linear.b.column(column).into_owned();
    let signal = unit("roll_rad") * row.p.mean + unit("angular_velocity_x_rad_s") * row.d.mean;
    let mut a = linear.a.clone();
    let mut gain = limb.sign;
    if let Some((angle, rate, stiffness, damping)) = limb.imposes {
        a -= &b * (unit(angle) * stiffness + unit(rate) * damping).transpose();
        gain *= stiffness;
    }
    let whole = delayed(&a, &(&b * gain), &signal, row.delay_s.mean);
    let values = whole.complex_eigenvalues();
    Ok(values.iter().map(|z| z.re).fold(f64::MIN, f64::max))
}

/// State matrix of x' = a x + b s(t - τ), s = signal · x.
fn delayed(
    a: &DMatrix<f64>,
    b: &DVector<f64>,
    signal: &DVector<f64>,
    delay_s: f64,
) -> DMatrix<f64> {
    let n = a.nrows();
    let rate = 2.0 * SECTIONS as f64 / delay_s;
    let mut whole = DMatrix::zeros(n + SECTIONS, n + SECTIONS);
    whole.view_mut((0, 0), (n, n)).copy_from(a);
    // The signal on its way: z' = (s - z) 2n/τ, passed on as 2 z - s.
    let mut passed = DVector::zeros(n + SECTIONS);
    passed.rows_mut(0, n).copy_from(signal);
    for k in 0..SECTIONS {
        let mut row = passed.clone() * rate;
        row[n + k] -= rate;
        whole.set_row(n + k, &row.transpose());
        passed = -passed;
        passed[n + k] += 2.0;
    }
    for i in 0..n {
        for j in 0..n + SECTIONS {
            whole[(i, j)] += b[i] * passed[j];
        }
    }
    whole
}

/// Do the published riders keep the bicycle up?
pub fn riders(assumed: &Assumed) -> Result<Vec<Row>, ReproduceError> {
    let mut rows = Vec::new();
    let mut hands_off = assumed.case(Case::Full);
    hands_off.arms.torsional_stiffness_nm_rad = 0.0;
    hands_off.arms.torsional_damping_nm_s_rad = 0.0;
    hands_off.arms.stiffness_n_m = 0.0;
    hands_off.arms.damping_n_s_m = 0.0;
    let rigid = Multibody::new(&assumed.case(Case::TyresRigid))?;
    let passive = Multibody::new(&hands_off)?;
    for (id, table, limb, model, what) in [
        (
            "rider_table_6_2",
            Table::SteerTorque,
            BAR_TORQUE,
            &rigid,
            "steer torque, case 6",
        ),
        (
            "rider_table_6_3",
            Table::SteerAngle,
            BAR_ANGLE,
            &rigid,
            "steer angle, case 6",
        ),
        (
            "rider_table_6_4",
            Table::TrunkLean,
            TRUNK_LEAN,
            &passive,
            "lean of the upper body, case 7 without arms",
        ),
    ] {
        let printed = published::rows(table);
        let (mut up, mut growths) = (0, Vec::new());
        for row in &printed {
            let growth = growth_per_s(model, &limb, row)?;
            up += usize::from(growth < 0.0);
            growths.push(format!(
                "{} {} m/s {growth:+.2}",
                row.group.name(),
                row.speed_m_s
            ));
        }
        let thesis = "riders identified this way stayed up";
        let same = up == printed.len();
        let ours = if same {
            thesis.to_owned()
        } else {
            format!("{up} of {} printed riders stay up", printed.len())
        };
        rows.push(Row::words(id, thesis, ours, same).noted(
            "section 6.3.3",
            format!(
                "{what}, mean gains and delay of each printed row; growth in 1/s: {}; the source identified the riders in closed loop on rollers and treadmill, where they used more than this one channel",
                growths.join(", ")
            ),
        ));
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// x' = -k x(t - τ) is stable for k τ < π/2: a classical result.
    #[test]
    fn a_chain_of_sections_is_a_delay() {
        let growth = |k: f64| {
            let whole = delayed(
                &DMatrix::zeros(1, 1),
                &DVector::from_element(1, -k),
                &DVector::from_element(1, 1.0),
                0.2,
            );
            let values = whole.complex_eigenvalues();
            values.iter().map(|z| z.re).fold(f64::MIN, f64::max)
        };
        let limit = core::f64::consts::FRAC_PI_2 / 0.2;
        assert!(growth(0.99 * limit) < 0.0 && growth(1.01 * limit) > 0.0);
    }
}
