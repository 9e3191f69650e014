//! What moves a figure that is missed: named assumptions, each with the value that would meet it,
//! found by solving for it with all else as it is.

use crate::assumed::Assumed;
use crate::row::{Assumption, Row};
use crate::stability::solve;
use twinhub_plant::multibody::Parameters;
use twinhub_plant::tyre::{MagicFormula, Tyre};

/// An assumption that can be varied.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lever {
    /// Spin inertia of both wheels over m R²: not published.
    WheelInertia,
    /// Twisting torque of both tyres over that of table A3.
    Twisting,
    /// Camber stiffness of both tyres over that of table A3.
    Camber,
    /// Product of inertia of the fork: the footnote of table A.1 against the usual tensor.
    ForkProduct,
    /// Height of the rider's (or trunk's) centre of mass: geometry that is not published.
    RiderHeight,
    /// Stiffness of trunk twist.
    TrunkTwist,
}

impl Lever {
    /// Name with unit, our value and the range searched.
    fn about(self, assumed: &Assumed, p: &Parameters) -> (&'static str, f64, [f64; 2]) {
        let fork = p.fork.inertia_xz_kg_m2;
        match self {
            Self::WheelInertia => (
                "wheel inertia over m R²",
                assumed.reading.wheel_inertia_ratio,
                [0.25, 0.75],
            ),
            Self::Twisting => ("twisting torque over table A3's", 1.0, [0.2, 2.0]),
            Self::Camber => ("camber stiffness over table A3's", 1.0, [0.2, 2.0]),
            Self::ForkProduct => (
                "product of inertia of the fork, kg m²,",
                fork,
                [-0.10, 0.10],
            ),
            Self::RiderHeight => (
                "height of the rider's centre of mass, m,",
                height(p),
                [0.85, 1.25],
            ),
            Self::TrunkTwist => (
                "stiffness of trunk twist, Nm/rad,",
                p.joints.trunk_twist.stiffness_nm_rad,
                [25.0, 225.0],
            ),
        }
    }

    fn set(self, assumed: &Assumed, p: &mut Parameters, value: f64) {
        match self {
            Self::WheelInertia => {
                for wheel in [&mut p.rear_wheel, &mut p.front_wheel] {
                    let spin = value * wheel.mass_kg * wheel.radius_m * wheel.radius_m;
                    wheel.spin_inertia_kg_m2 = spin;
                    wheel.diameter_inertia_kg_m2 = 0.5 * spin;
                }
            }
            Self::Twisting => on_tyres(p, &|t| t.twisting_gain *= value),
            Self::Camber => on_tyres(p, &|t| t.camber_gain *= value),
            Self::ForkProduct => p.fork.inertia_xz_kg_m2 = value,
            Self::RiderHeight => {
                let (_, ours, _) = self.about(assumed, p);
                let rise = value - ours;
                let whole = p.rider.trunk.mass_kg == 0.0;
                let body = if whole {
                    &mut p.rider.pelvis
                } else {
                    &mut p.rider.trunk
                };
                body.z_m -= rise;
            }
            Self::TrunkTwist => p.joints.trunk_twist.stiffness_nm_rad = value,
        }
    }
}

/// Height of the centre of mass of trunk, or of the whole rider where he is one body, m.
fn height(p: &Parameters) -> f64 {
    let whole = p.rider.trunk.mass_kg == 0.0;
    -(if whole {
        p.rider.pelvis.z_m
    } else {
        p.rider.trunk.z_m
    })
}

/// Changes both tyres, if they are the source's.
pub fn on_tyres(p: &mut Parameters, change: &dyn Fn(&mut MagicFormula)) {
    for tyre in [&mut p.tyre.rear, &mut p.tyre.front] {
        if let Tyre::MagicFormula(tyre) = tyre {
            change(tyre);
        }
    }
}

/// If `row` is missed, says for each lever what value of it would meet the figure that `figure`
/// takes from parameters like `nominal`.
pub fn explain(
    row: &mut Row,
    assumed: &Assumed,
    nominal: &Parameters,
    levers: &[Lever],
    figure: &dyn Fn(&Parameters) -> Option<f64>,
) {
    let (true, Some(target)) = (row.missed() && assumed.explain_misses, row.target()) else {
        return;
    };
    for lever in levers {
        let (name, ours, searched) = lever.about(assumed, nominal);
        let at = |value: f64| {
            let mut p = nominal.clone();
            lever.set(assumed, &mut p, value);
            figure(&p)
        };
        row.explain(Assumption {
            name,
            ours,
            would_meet: solve(searched, ours, target, &at),
            searched,
        });
    }
}
