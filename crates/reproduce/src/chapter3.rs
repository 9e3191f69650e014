//! What: the figures of chapter 3: benchmark, cases 1 to 7, tyre properties, arms.
//!
//! Equation: eigenvalues of the linearised model; `push` has the thesis's own method beside it.
//!
//! Source: Bulsink (2017), sections 3.3.1 to 3.3.4, table 3.3.
//!
//! Assumes and ignores: one set of assumptions for all rows (`assumed`). Where a condition is not
//! printed it is named in the row's note.
//!
//! Valid for: bicycle 1 of table A.1.
//!
//! Checked by: `tests/reproduction.rs`.

use crate::assumed::{Assumed, Measured};
use crate::error::ReproduceError;
use crate::misses::{Lever, explain, on_tyres};
use crate::row::{Assumption, Row};
use crate::stability::{
    Critical, best_growth_per_s, critical, growth_per_s, solve, stable_range_m_s, weave_m_s,
};
use twinhub_linear::Bicycle;
use twinhub_plant::multibody::{Case, Course, Multibody, Parameters};
use twinhub_plant::tyre::MagicFormula;

type Rows = Result<Vec<Row>, ReproduceError>;

/// Doubt about table A.1 and the tyres: what a missed weave speed on tyres is put down to.
const ON_TYRES: &[Lever] = &[
    Lever::WheelInertia,
    Lever::Twisting,
    Lever::ForkProduct,
    Lever::RiderHeight,
];
/// The same without slip.
const NO_SLIP: &[Lever] = &[Lever::WheelInertia, Lever::ForkProduct, Lever::RiderHeight];

fn straight() -> Course {
    Course::straight(5.0)
}

fn weave_of(p: &Parameters) -> Option<f64> {
    weave_m_s(p).ok().flatten()
}

/// The benchmark bicycle, without slip or on the source's tyres.
pub fn benchmark_bicycle(assumed: &Assumed, tyres: bool) -> Result<Parameters, ReproduceError> {
    let mut p = Parameters::from_whipple(&Bicycle::load("meijaard2007_benchmark")?);
    if tyres {
        assumed.fit_tyres(&mut p, Measured::At400N, &|_| {});
    }
    Ok(p)
}

/// Does every lateral mode decay from just above `weave_m_s` to 10 m/s?
fn stable_above(p: &Parameters, weave_m_s: Option<f64>) -> Result<bool, ReproduceError> {
    let Some(weave) = weave_m_s else {
        return Ok(false);
    };
    let model = Multibody::new(p)?;
    let mut v = weave + 0.05;
    while v <= 10.0 {
        if growth_per_s(&model, &Course::straight(v))? >= 0.0 {
            return Ok(false);
        }
        v += 0.25;
    }
    Ok(true)
}

fn capsize_row(id: &'static str, p: &Parameters, found: &Critical) -> Result<Row, ReproduceError> {
    let stable = found.capsize_m_s.is_none() && stable_above(p, found.weave_m_s)?;
    let ours = match found.capsize_m_s {
        _ if stable => "stable".to_owned(),
        Some(v) => format!("unstable above {v:.2} m/s"),
        None => "unstable".to_owned(),
    };
    Ok(Row::words(id, "stable", ours, stable))
}

/// The benchmark bicycle (section 3.3.1).
pub fn benchmark(assumed: &Assumed) -> Rows {
    let section = "section 3.3.1, figure 3.4";
    let p = benchmark_bicycle(assumed, false)?;
    let rigid = critical(&p, &straight())?;
    let mut rows = vec![
        Row::number("benchmark_weave", 4.292, rigid.weave_m_s, "m/s")
            .noted(section, "Meijaard et al. (2007), no slip"),
        Row::number("benchmark_capsize", 6.024, rigid.capsize_m_s, "m/s")
            .noted(section, "Meijaard et al. (2007), no slip"),
    ];
    let p = benchmark_bicycle(assumed, true)?;
    let found = critical(&p, &straight())?;
    let mut weave = Row::number("benchmark_mf_weave", 7.4, found.weave_m_s, "m/s")
        .noted(section, "benchmark on the tyres of table A3");
    explain(&mut weave, assumed, &p, &[Lever::Twisting], &weave_of);
    rows.push(weave);
    rows.push(
        capsize_row("benchmark_mf_capsize_stable", &p, &found)?
            .noted(section, "judged up to 10 m/s"),
    );
    Ok(rows)
}

/// Cases 1 to 4: no slip.
pub fn no_slip_cases(assumed: &Assumed) -> Rows {
    let section = "section 3.3.2, figure 3.5";
    let at = |case| critical(&assumed.case(case), &straight());
    let one = at(Case::NoSlipRigid)?;
    let p = assumed.case(Case::NoSlipRigid);
    let mut weave = Row::number("case1_weave", 4.9, one.weave_m_s, "m/s")
        .noted(section, "no slip, rigid rider");
    explain(&mut weave, assumed, &p, NO_SLIP, &weave_of);
    let mut capsize = Row::number("case1_capsize", 6.8, one.capsize_m_s, "m/s")
        .noted(section, "no slip, rigid rider");
    explain(&mut capsize, assumed, &p, NO_SLIP, &|p| {
        critical(p, &straight()).ok()?.capsize_m_s
    });
    let mut rows = vec![weave, capsize];
    let (Some(w1), Some(c1)) = (one.weave_m_s, one.capsize_m_s) else {
        return Ok(rows);
    };
    for (id, case, thesis, judge, note) in EFFECTS {
        let found = at(*case)?;
        let (w, c) = (
            found.weave_m_s.unwrap_or(f64::NAN) - w1,
            found.capsize_m_s.unwrap_or(f64::NAN) - c1,
        );
        let same = judge(w / w1, c / c1);
        let ours = if same {
            (*thesis).to_owned()
        } else {
            format!("weave {w:+.2} m/s, capsize {c:+.2} m/s")
        };
        rows.push(Row::words(id, thesis, ours, same).noted(
            section,
            format!("against case 1: weave {w:+.2} m/s, capsize {c:+.2} m/s; {note}"),
        ));
    }
    Ok(rows)
}

/// Relative changes of weave and capsize speed to the words of the source.
type Judge = fn(f64, f64) -> bool;

/// Cases that the source judges by words: id, case, words, the same in numbers, and in words again.
const EFFECTS: &[(&str, Case, &str, Judge, &str)] = &[
    (
        "case2_effect",
        Case::NoSlipPassive,
        "very small effect on weave, none of note on capsize",
        |w, c| w.abs() < 0.02 && c.abs() < 0.02,
        "the same words if both stay within 2 %",
    ),
    (
        "case3_effect",
        Case::NoSlipArmMass,
        "small effect: raises weave speed, lowers capsize speed",
        |w, c| (0.0..0.1).contains(&w) && (-0.1..0.0).contains(&c),
        "the same words if weave rises and capsize falls, both by less than 10 %",
    ),
    (
        "case4_effect",
        Case::NoSlipArmDamping,
        "small rise of weave speed, no effect of note on capsize",
        |w, c| (0.0..0.1).contains(&w) && c.abs() < 0.02,
        "the same words if weave rises by less than 10 % and capsize stays within 2 %",
    ),
];

/// Case 5 with arms of this torsional stiffness.
fn stiff_arms(assumed: &Assumed, stiffness_nm_rad: f64) -> Parameters {
    let mut p = assumed.case(Case::NoSlipArmStiffness);
    p.arms.stiffness_n_m = 0.0;
    p.arms.torsional_stiffness_nm_rad = stiffness_nm_rad;
    p
}

/// Case 5: arm stiffness without slip.
pub fn arm_stiffness(assumed: &Assumed) -> Rows {
    let section = "section 3.3.4";
    let p = stiff_arms(assumed, 3.2);
    let range = |p: &Parameters| stable_range_m_s(p, [1.0, 8.0]).ok().flatten();
    let found = range(&p);
    let edge = |k: usize| move |p: &Parameters| range(p).map(|r| r[k]);
    let mut rows = Vec::new();
    for (k, id, thesis) in [(0, "case5_range_low", 3.65), (1, "case5_range_high", 4.20)] {
        let mut row = Row::number(id, thesis, found.map(|r| r[k]), "m/s").noted(
            section,
            "stable range with arms of 3.2 Nm/rad, no slip, rigid rider",
        );
        explain(&mut row, assumed, &p, NO_SLIP, &edge(k));
        rows.push(row);
    }
    // The stiffness up to which some speed is stable.
    let limit_of = |p: &Parameters| {
        let stable = |stiffness: f64| {
            let mut q = p.clone();
            q.arms.torsional_stiffness_nm_rad = stiffness;
            best_growth_per_s(&q).is_ok_and(|g| g < 0.0)
        };
        let (mut low, mut high) = (0.0, 10.0);
        if !stable(low) || stable(high) {
            return None;
        }
        while high - low > 1.0e-3 {
            let middle = 0.5 * (low + high);
            if stable(middle) {
                low = middle
            } else {
                high = middle
            }
        }
        Some(0.5 * (low + high))
    };
    let mut limit = Row::number("case5_limit", 4.0, limit_of(&p), "Nm/rad").noted(
        section,
        "arm stiffness beyond which no speed is stable; the source gives 3.2 as stable and above 4 as not",
    );
    explain(
        &mut limit,
        assumed,
        &p,
        &[Lever::WheelInertia, Lever::ForkProduct],
        &limit_of,
    );
    rows.push(limit);
    Ok(rows)
}

/// Cases 6 and 7: tyres.
pub fn tyre_cases(assumed: &Assumed) -> Rows {
    let p = assumed.case(Case::TyresRigid);
    let six = critical(&p, &straight())?;
    let mut weave = Row::number("case6_weave", 9.3, six.weave_m_s, "m/s")
        .noted("section 3.3.2, figure 3.5", "tyres, rigid rider, no arms");
    explain(&mut weave, assumed, &p, ON_TYRES, &weave_of);
    let capsize = capsize_row("case6_capsize_stable", &p, &six)?
        .noted("section 3.3.2, figure 3.5", "judged up to 10 m/s");
    let mut rows = vec![weave, capsize];
    for (id, thesis, measured, note) in [
        (
            "case7_weave_400n",
            9.7,
            Measured::At400N,
            "table A3 as printed, coefficients follow the load",
        ),
        (
            "case7_weave_600n",
            8.3,
            Measured::At600N,
            "table A3 taken to 600 N: what was measured at 600 N is not published",
        ),
    ] {
        let mut p = assumed.case(Case::Full);
        assumed.fit_tyres(&mut p, measured, &|_| {});
        let mut row =
            Row::number(id, thesis, weave_of(&p), "m/s").noted("section 3.3.3, figure 3.6", note);
        let mut levers = ON_TYRES.to_vec();
        levers.push(Lever::TrunkTwist);
        explain(&mut row, assumed, &p, &levers, &weave_of);
        rows.push(row);
    }
    Ok(rows)
}

/// A change of a tyre.
type Change = fn(&mut MagicFormula, f64);

/// Tyre properties that the source varies: name, change by a factor.
pub const PROPERTIES: &[(&str, Change)] = &[
    ("cornering stiffness", |t, f| t.cornering_gain *= f),
    ("camber stiffness", |t, f| t.camber_gain *= f),
    ("twisting torque", |t, f| t.twisting_gain *= f),
    ("pneumatic trail", |t, f| t.trail_gain *= f),
    ("overturning torque", |t, f| t.overturning_gain *= f),
];

/// Change of weave speed when a property of both tyres is scaled by `factor`, percent.
pub fn sensitivity_percent(p: &Parameters, property: usize, factor: f64) -> Option<f64> {
    let mut changed = p.clone();
    on_tyres(&mut changed, &|t| (PROPERTIES[property].1)(t, factor));
    Some(100.0 * (weave_of(&changed)? / weave_of(p)? - 1.0))
}

/// Weave speed when one property of the tyres doubles (section 3.3.3).
pub fn sensitivities(assumed: &Assumed) -> Rows {
    let section = "section 3.3.3, figure 3.7";
    let p = assumed.case(Case::Full);
    let doubled = |k: usize| move |p: &Parameters| sensitivity_percent(p, k, 2.0);
    let cornering = doubled(0)(&p).unwrap_or(f64::NAN);
    let small = cornering < 0.0 && cornering > -1.0;
    let thesis = "falls by less than 1 %";
    let ours = if small {
        thesis.to_owned()
    } else {
        format!("{cornering:+.1} %")
    };
    let mut rows = vec![
        Row::words("sens_cornering", thesis, ours, small)
            .noted(section, format!("case 7; ours {cornering:+.2} %")),
    ];
    for (id, k, thesis) in [
        ("sens_camber", 1, 9.0),
        ("sens_twisting", 2, 25.0),
        ("sens_trail", 3, 4.0),
        ("sens_overturning", 4, -3.0),
    ] {
        let mut row = Row::number(id, thesis, doubled(k)(&p), "%")
            .noted(section, format!("case 7, {} doubled", PROPERTIES[k].0));
        explain(
            &mut row,
            assumed,
            &p,
            &[Lever::WheelInertia, Lever::Twisting],
            &doubled(k),
        );
        rows.push(row);
    }
    Ok(rows)
}

/// Arm damping of figure 3.10 that is compared, Nm s/rad: ten times that of case 7. A guess: the text
/// only says "much larger".
const HIGH_DAMPING_NMS_RAD: f64 = 9.0;

/// Case 7 without arm stiffness, with this arm damping.
pub fn damped_arms(assumed: &Assumed, damping_nm_s_rad: f64) -> Parameters {
    let mut p = assumed.case(Case::Full);
    p.arms.stiffness_n_m = 0.0;
    p.arms.damping_n_s_m = 0.0;
    p.arms.torsional_stiffness_nm_rad = 0.0;
    p.arms.torsional_damping_nm_s_rad = damping_nm_s_rad;
    p
}

/// Arm damping on tyres (section 3.3.4).
pub fn arm_damping(assumed: &Assumed) -> Rows {
    let at = |damping: f64| weave_of(&damped_arms(assumed, damping));
    let mut row = Row::number("arm_damping_weave", 11.5, at(HIGH_DAMPING_NMS_RAD), "m/s").noted(
        "section 3.3.4, figure 3.10",
        "case 7 without arm stiffness, damping 9 Nm s/rad: ten times that of case 7, a guess, for the source says \"much larger\"",
    );
    if assumed.explain_misses {
        // Not only where it is missed: the source's damping is unknown.
        let searched = [0.9, 18.0];
        row.explain(Assumption {
            name: "arm damping, Nm s/rad,",
            ours: HIGH_DAMPING_NMS_RAD,
            would_meet: solve(searched, HIGH_DAMPING_NMS_RAD, 11.5, &at),
            searched,
        });
    }
    Ok(vec![row])
}
