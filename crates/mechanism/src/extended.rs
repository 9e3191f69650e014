//! The extended plant: a bicycle with the causes that a diagnosis accepted, as a bicycle file that
//! every command takes.
//!
//! What mechanisms change in parameters and matrices is put into the bicycle itself, so that modes,
//! designs and certificates have it. What pushes besides (friction, lag, wind, pedals) is named in
//! the file and acts in rides.

use crate::body::Body;
use crate::hooks::Mechanism;
use crate::registry::find;
use nalgebra::Matrix2;
use twinhub_linear::{Added, Bicycle, BicycleError, MotorPair, NamedMechanism};

/// One accepted cause.
#[derive(Clone, Debug)]
pub struct Accepted {
    pub mechanism: &'static dyn Mechanism,
    pub confirmed: bool,
    /// In the order of the card.
    pub p: Vec<f64>,
    /// One standard deviation each; not a number where unknown.
    pub sd: Vec<f64>,
}

/// The bicycle with its causes; `base` is the calibrated one without them.
pub fn extended(
    base: &Bicycle,
    name: &str,
    source: &str,
    causes: &[Accepted],
) -> Result<Bicycle, BicycleError> {
    let list: Vec<(&'static dyn Mechanism, &[f64])> = causes
        .iter()
        .map(|c| (c.mechanism, c.p.as_slice()))
        .collect();
    let body = Body::with(base, &list)?;
    let rigid = Bicycle {
        added: Added::NONE,
        parameters: body.parameters,
        ..base.clone()
    };
    let rigid = Body::new(&rigid)?;
    let rows = |m: Matrix2<f64>| [[m[(0, 0)], m[(0, 1)]], [m[(1, 0)], m[(1, 1)]]];
    let mut bicycle = Bicycle::new(name, source, body.parameters)?;
    bicycle.added = Added {
        mass_kg_m2: rows(body.terms.mass - rigid.terms.mass),
        damping_nms_rad: rows(body.damping(0.0) - rigid.damping(0.0)),
        stiffness_nm_rad: rows(
            body.stiffness(0.0, MotorPair::OFF) - rigid.stiffness(0.0, MotorPair::OFF),
        ),
    };
    bicycle.standard_deviations = base.standard_deviations.clone();
    bicycle.mechanisms = base.mechanisms.clone();
    for cause in causes {
        let card = cause.mechanism.card();
        let named = |values: &[f64]| {
            let pairs = card.parameters.iter().zip(values);
            pairs
                .filter(|(_, x)| x.is_finite())
                .map(|(p, x)| (p.name.to_owned(), *x))
                .collect()
        };
        bicycle.mechanisms.push(NamedMechanism {
            name: card.name.to_owned(),
            confirmed: cause.confirmed,
            parameters: named(&cause.p),
            standard_deviations: named(&cause.sd),
        });
    }
    Ok(bicycle)
}

/// Why the causes named in a bicycle file cannot act in a ride.
#[non_exhaustive]
#[derive(Debug, thiserror::Error)]
pub enum ExtendedError {
    #[error("bicycle {bicycle}: found {found}; accepted: {accepted}")]
    Value {
        bicycle: String,
        found: String,
        accepted: String,
    },
}

/// The causes of a bicycle that push during a ride, with their parameters.
pub fn pushing(
    bicycle: &Bicycle,
) -> Result<Vec<(&'static dyn Mechanism, Vec<f64>)>, ExtendedError> {
    let mut all = vec![];
    for named in &bicycle.mechanisms {
        let refuse = |found: String, accepted: String| ExtendedError::Value {
            bicycle: bicycle.name.clone(),
            found,
            accepted,
        };
        let Some(mechanism) = find(&named.name) else {
            let names: Vec<&str> = crate::registry::names().collect();
            return Err(refuse(
                format!("mechanism `{}`", named.name),
                names.join(", "),
            ));
        };
        let card = mechanism.card();
        let mut p = mechanism.null(&bicycle.parameters);
        for (name, value) in &named.parameters {
            let Some(index) = card.parameters.iter().position(|q| q.name == name) else {
                let names: Vec<&str> = card.parameters.iter().map(|q| q.name).collect();
                return Err(refuse(format!("{}.{name}", named.name), names.join(", ")));
            };
            let range = card.parameters[index].least..=card.parameters[index].most;
            if !range.contains(value) {
                return Err(refuse(
                    format!("{}.{name} = {value}", named.name),
                    format!("{} to {}", range.start(), range.end()),
                ));
            }
            p[index] = *value;
        }
        if mechanism.pushes() {
            all.push((mechanism, p));
        }
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn file_keeps_everything() {
        let base = Bicycle::load("meijaard2007_benchmark").unwrap();
        let cause = |name: &str, p: Vec<f64>| Accepted {
            mechanism: find(name).unwrap(),
            confirmed: true,
            sd: p.iter().map(|x| 0.1 * x).collect(),
            p,
        };
        let causes = [
            cause("steer_damping", vec![0.7]),
            cause("arm_inertia", vec![0.1]),
            cause("payload", vec![5.0, 0.1, -0.8]),
            cause("steer_coulomb_friction", vec![0.3]),
        ];
        let bicycle = extended(&base, "longer", "a test", &causes).unwrap();
        let again = Bicycle::from_toml(&bicycle.to_toml(), Path::new("x.toml")).unwrap();
        assert_eq!(again.parameters, bicycle.parameters);
        assert_eq!(again.added, bicycle.added);
        assert_eq!(again.mechanisms, bicycle.mechanisms);
        assert!((again.added.damping_nms_rad[1][1] - 0.7).abs() < 1e-12);
        assert!((again.parameters.mB - base.parameters.mB - 5.0).abs() < 1e-12);
        let pushing = pushing(&again).unwrap();
        assert_eq!(pushing.len(), 1);
        assert_eq!(pushing[0].1, [0.3]);
    }
}
