//! What: a diagnosis from fitted modes alone, where the rides were not published.
//!
//! Equation: r = (sigma - sigma_measured)/sd, (omega - omega_measured)/sd over all rows, for the
//! complex pair nearest to the measured one, with the known law closed; calibration parameters z
//! minimise sum r² + z² within their box.
//!
//! Source: Gauss-Newton on eigenvalues.
//!
//! Assumes and ignores: the law acts at once and below its limit.
//!
//! Valid for: modes that oscillate. Eigenvalues do not tell friction from guessed inertias, so no
//! cause is ever named here: what would help is listed as candidates.
//!
//! Checked by: `tests` of the search: own modes are explained, others are not.

use super::answer::{Answer, Candidate, Verdict, Where};
use super::fitting::{Calibrated, Columns, calibrated, is_at_end};
use super::run::{DiagnoseError, empty};
use super::step::bounded_step;
use super::thresholds::THRESHOLDS;
use super::words;
use crate::data::{DataError, DataFolders};
use crate::engine::small::dot;
use crate::quantity::Quantity;
use crate::study::{LawKind, LawSpec, ModesSpec, Study};
use nalgebra::{Matrix2, Matrix4};
use statrs::distribution::{ChiSquared, ContinuousCDF};
use twinhub_linear::{Bicycle, MotorPair};
use twinhub_mechanism::{ALL, Body, Mechanism};

struct Row {
    speed_m_s: f64,
    sigma_1_s: f64,
    omega_rad_s: f64,
    sd: [f64; 2],
    law: Option<LawSpec>,
}

fn read(spec: &ModesSpec, folders: &DataFolders) -> Result<Vec<Row>, DiagnoseError> {
    let path = folders.find(&spec.file, &spec.place)?;
    let wrong = |found: String, accepted: &str| {
        DiagnoseError::Data(DataError::File {
            path: path.clone(),
            found,
            accepted: accepted.to_owned(),
        })
    };
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .from_path(&path)
        .map_err(|e| wrong(e.to_string(), "a CSV file"))?;
    let header = reader
        .headers()
        .map_err(|e| wrong(e.to_string(), "a header line"))?
        .clone();
    let index = |name: &str| {
        header.iter().position(|h| h == name).ok_or_else(|| {
            wrong(
                format!("no column `{name}`"),
                &header.iter().collect::<Vec<_>>().join(", "),
            )
        })
    };
    let columns = [
        index(&spec.speed_column)?,
        index(&spec.sigma_column)?,
        index(&spec.omega_column)?,
    ];
    let mut rows = vec![];
    for record in reader.records() {
        let record = record.map_err(|e| wrong(e.to_string(), "rows as long as the header"))?;
        let mut values = [0.0; 3];
        for (value, column) in values.iter_mut().zip(columns) {
            let cell = record.get(column).unwrap_or("");
            *value = cell
                .parse()
                .ok()
                .filter(|x: &f64| x.is_finite())
                .ok_or_else(|| wrong(format!("`{cell}`"), "a finite number"))?;
        }
        rows.push(Row {
            speed_m_s: values[0],
            sigma_1_s: values[1],
            omega_rad_s: values[2],
            sd: [spec.sigma_sd_1_s, spec.omega_sd_rad_s],
            law: spec.law.clone(),
        });
    }
    Ok(rows)
}

/// Residuals of all rows, or none if the bicycle cannot be.
fn residuals(rows: &[Row], body: &Body) -> Vec<f64> {
    rows.iter()
        .flat_map(|row| {
            let v = row.speed_m_s;
            let (mut k, mut c) = (body.stiffness(v, MotorPair::OFF), body.damping(v));
            if let Some(law) = &row.law {
                let gain = match (law.kind, law.speed0_m_s) {
                    (LawKind::SpeedScheduledRate, Some(v0)) => law.gain * (v0 - v).max(0.0),
                    _ => law.gain,
                };
                let axis = usize::from(law.quantity != Quantity::RollTorque);
                match law.of {
                    Quantity::Roll => k[(axis, 0)] -= gain,
                    Quantity::Steer => k[(axis, 1)] -= gain,
                    Quantity::SteerRate => c[(axis, 1)] -= gain,
                    Quantity::YawRate => {
                        k[(axis, 1)] -= gain * body.yaw[0] * v;
                        c[(axis, 1)] -= gain * body.yaw[1];
                    }
                    _ => c[(axis, 0)] -= gain,
                }
            }
            let (k, c) = (-body.mass_inverse * k, -body.mass_inverse * c);
            let mut a = Matrix4::zeros();
            a.fixed_view_mut::<2, 2>(0, 2)
                .copy_from(&Matrix2::identity());
            a.fixed_view_mut::<2, 2>(2, 0).copy_from(&k);
            a.fixed_view_mut::<2, 2>(2, 2).copy_from(&c);
            let nearest = a
                .complex_eigenvalues()
                .iter()
                .map(|z| {
                    [
                        (z.re - row.sigma_1_s) / row.sd[0],
                        (z.im.abs() - row.omega_rad_s) / row.sd[1],
                    ]
                })
                .min_by(|p, q| dot(p, p).total_cmp(&dot(q, q)));
            nearest.unwrap_or([0.0; 2])
        })
        .collect()
}

/// Calibration parameters and, if given, one mechanism's first parameter, fitted to the rows: sum of
/// squares with prior, and the parameters.
fn fit(
    rows: &[Row],
    bicycle: &Bicycle,
    all: &[Calibrated],
    mechanism: Option<&'static dyn Mechanism>,
) -> Option<(f64, Vec<f64>)> {
    let limit = THRESHOLDS.calibration_box_sd;
    let extra = usize::from(mechanism.is_some());
    let n = all.len();
    let body = |x: &[f64]| {
        let mut b = bicycle.clone();
        for (c, z) in all.iter().zip(x) {
            b.set(c.symbol, c.value + z * c.sd).ok()?;
        }
        let p = mechanism.map(|m| {
            let mut p = m.null(&bicycle.parameters);
            p[0] += x[n] * m.card().parameters[0].probe;
            p
        });
        let list: Vec<(&'static dyn Mechanism, &[f64])> = match (mechanism, &p) {
            (Some(m), Some(p)) => vec![(m, p.as_slice())],
            _ => vec![],
        };
        Body::with(&b, &list).ok()
    };
    let (mut least, mut most) = (vec![-limit; n], vec![limit; n]);
    let mut precision = vec![1.0; n];
    if let Some(m) = mechanism {
        let param = &m.card().parameters[0];
        let ends = [
            (param.least - param.null) / param.probe,
            (param.most - param.null) / param.probe,
        ];
        least.push(ends[0].min(ends[1]));
        most.push(ends[0].max(ends[1]));
        precision.push(0.0);
    }
    let mut x = vec![0.0; n + extra];
    let cost = |r: &[f64], x: &[f64]| dot(r, r) + dot(&x[..n], &x[..n]);
    let mut r = residuals(rows, &body(&x)?);
    for _ in 0..12 {
        let columns: Vec<Vec<f64>> = (0..x.len())
            .map(|i| {
                let mut there = x.clone();
                let step = if x[i] > 0.0 { -0.05 } else { 0.05 };
                there[i] += step;
                match body(&there) {
                    Some(b) => residuals(rows, &b)
                        .iter()
                        .zip(&r)
                        .map(|(p, q)| (p - q) / step)
                        .collect(),
                    None => vec![0.0; r.len()],
                }
            })
            .collect();
        let list: Vec<&Vec<f64>> = columns.iter().collect();
        let step = bounded_step(
            &r,
            &Columns::default(),
            &list,
            &precision,
            &x,
            &vec![0.0; x.len()],
            &least,
            &most,
        );
        let before = cost(&r, &x);
        let mut share = 1.0;
        let mut better = false;
        while share > 0.02 {
            let there: Vec<f64> = x.iter().zip(&step).map(|(a, d)| a + share * d).collect();
            if let Some(b) = body(&there) {
                let next = residuals(rows, &b);
                if cost(&next, &there) < before - 1e-6 {
                    (x, r, better) = (there, next, true);
                    break;
                }
            }
            share *= 0.4;
        }
        if !better {
            break;
        }
    }
    Some((cost(&r, &x), x))
}

/// Diagnoses a study that has modes only.
pub fn diagnose_modes(
    study: &Study,
    folders: &DataFolders,
    library: &[&'static dyn Mechanism],
) -> Result<Answer, DiagnoseError> {
    let name = study.file.display().to_string();
    let Some(bicycle) = &study.bicycle else {
        return Err(DiagnoseError::Model { study: name });
    };
    let mut rows = vec![];
    for spec in &study.modes {
        rows.extend(read(spec, folders)?);
    }
    let all = calibrated(study, bicycle);
    let mut answer = empty(study, Verdict::NoEffect);
    let not_finite = || DiagnoseError::NotFinite {
        study: name.clone(),
    };
    let nominal = residuals(&rows, &Body::new(bicycle).map_err(Box::new)?);
    let (cost, z) = fit(&rows, bicycle, &all, None).ok_or_else(not_finite)?;
    for (c, z) in all.iter().zip(&z) {
        answer
            .calibration
            .insert(c.symbol.to_owned(), c.value + z * c.sd);
        if is_at_end(*z) {
            answer.out_of_tolerance.push(c.symbol.to_owned());
        }
    }
    let count = 2.0 * rows.len() as f64;
    let p_value = ChiSquared::new(count).map_or(1.0, |d| d.sf(cost));
    let linear = library.iter().filter(|m| {
        let mut terms = Body::new(bicycle).map(|b| b.terms).ok();
        let before = terms;
        if let Some(terms) = &mut terms {
            let p = m.probes(&bicycle.parameters).remove(0);
            m.terms(&p, terms);
        }
        terms != before
    });
    for mechanism in linear {
        if let Some((with, _)) = fit(&rows, bicycle, &all, Some(*mechanism)) {
            answer.candidates.push(Candidate {
                mechanism: mechanism.card().name.to_owned(),
                fit_gain_nats: 0.5 * (cost - with),
                held_out_gain_nats: None,
                held_out_error_nats: None,
            });
        }
    }
    answer
        .candidates
        .sort_by(|a, b| b.fit_gain_nats.total_cmp(&a.fit_gain_nats));
    if p_value < THRESHOLDS.band_p_value {
        answer.verdict = Verdict::Unknown;
        let omegas = rows
            .iter()
            .map(|r| r.omega_rad_s / (2.0 * std::f64::consts::PI));
        let (low, high) = omegas.fold((f64::INFINITY, 0.0), |(a, b): (f64, f64), f| {
            (a.min(f), b.max(f))
        });
        answer.places.push(Where {
            equation: "steer".to_owned(),
            band_hz: Some([low, high]),
            order: None,
            time_s: None,
            ride: None,
            p_value,
            with: Some("the weave".to_owned()),
        });
    }
    answer.statements = words::statements(&answer);
    answer.statements.push(format!(
        "weave modes: mean square error {:.2} as declared, {:.2} within tolerance (1: what the measurement's error explains); eigenvalues alone name no cause",
        dot(&nominal, &nominal) / count,
        cost / count
    ));
    let ahead: Vec<&str> = ALL
        .iter()
        .map(|m| m.card().name)
        .filter(|n| answer.candidates.iter().take(3).any(|c| c.mechanism == *n))
        .collect();
    if answer.verdict == Verdict::Unknown {
        answer.statements.push(format!(
            "what would bring the modes nearest, none of it told apart from wrong inertias: {}",
            ahead.join(", ")
        ));
    }
    Ok(answer)
}
