//! Rigid bodies in the plane of symmetry, and several taken as one.

use crate::parameters::Parameters;

/// Mass, centre of mass and inertia about it, in the axes of Meijaard et al. (2007).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RigidBody {
    pub mass_kg: f64,
    pub x_m: f64,
    pub z_m: f64,
    pub ixx_kg_m2: f64,
    pub iyy_kg_m2: f64,
    pub izz_kg_m2: f64,
    pub ixz_kg_m2: f64,
}

impl RigidBody {
    /// The two bodies joined rigidly.
    pub fn and(self, other: Self) -> Self {
        let mass_kg = self.mass_kg + other.mass_kg;
        if mass_kg == 0.0 {
            return self;
        }
        let mean = |a: f64, b: f64| (self.mass_kg * a + other.mass_kg * b) / mass_kg;
        let (x_m, z_m) = (mean(self.x_m, other.x_m), mean(self.z_m, other.z_m));
        // Parallel axes, twice.
        let sum = |body: &dyn Fn(&Self, f64, f64) -> f64| {
            [self, other]
                .iter()
                .map(|b| body(b, b.x_m - x_m, b.z_m - z_m))
                .sum()
        };
        Self {
            mass_kg,
            x_m,
            z_m,
            ixx_kg_m2: sum(&|b, _, z| b.ixx_kg_m2 + b.mass_kg * z * z),
            iyy_kg_m2: sum(&|b, x, z| b.iyy_kg_m2 + b.mass_kg * (x * x + z * z)),
            izz_kg_m2: sum(&|b, x, _| b.izz_kg_m2 + b.mass_kg * x * x),
            ixz_kg_m2: sum(&|b, x, z| b.ixz_kg_m2 - b.mass_kg * x * z),
        }
    }

    /// Body B of a bicycle.
    pub fn rear_body(p: &Parameters) -> Self {
        Self {
            mass_kg: p.mB,
            x_m: p.xB,
            z_m: p.zB,
            ixx_kg_m2: p.IBxx,
            iyy_kg_m2: p.IByy,
            izz_kg_m2: p.IBzz,
            ixz_kg_m2: p.IBxz,
        }
    }

    /// Writes this body as body B.
    pub fn store_rear_body(self, p: &mut Parameters) {
        p.mB = self.mass_kg;
        p.xB = self.x_m;
        p.zB = self.z_m;
        p.IBxx = self.ixx_kg_m2;
        p.IByy = self.iyy_kg_m2;
        p.IBzz = self.izz_kg_m2;
        p.IBxz = self.ixz_kg_m2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_points_make_a_dumb_bell() {
        let point = |mass_kg, x_m, z_m| RigidBody {
            mass_kg,
            x_m,
            z_m,
            ixx_kg_m2: 0.0,
            iyy_kg_m2: 0.0,
            izz_kg_m2: 0.0,
            ixz_kg_m2: 0.0,
        };
        // 1 kg at (0, 0) and 3 kg at (0.4, -0.8): reduced mass 0.75 kg.
        let b = point(1.0, 0.0, 0.0).and(point(3.0, 0.4, -0.8));
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-15, "{a} {b}");
        close(b.mass_kg, 4.0);
        close(b.x_m, 0.3);
        close(b.z_m, -0.6);
        close(b.ixx_kg_m2, 0.75 * 0.64);
        close(b.iyy_kg_m2, 0.75 * 0.80);
        close(b.izz_kg_m2, 0.75 * 0.16);
        // -∫xz dm = -0.75 * 0.4 * (-0.8).
        close(b.ixz_kg_m2, 0.24);
    }
}
