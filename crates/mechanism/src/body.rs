//! What: the bicycle's rigid-body coefficients, with what mechanisms add to its matrices.
//!
//! Equation: M q'' + (C0 + v C1) q' + (K0 + v K1 + v² K2) q = f, q = (roll, steer). Slip that adds
//! a yaw rate r to the kinematic one pushes with
//! roll: mT zT v r - ITxz r' - v ST r,
//! front side force: F = (mT xT v r + ITzz r')/w,
//! steer: -(mA uA v r + IAlz r' + v SF sin(lam) r) - c cos(lam) F.
//!
//! Source: Meijaard et al. (2007), equations (4.1)-(4.3) and appendix A; the slip terms own, by
//! putting psi' = kinematic + r into (4.1)-(4.3) and eliminating the side force as the paper does.
//!
//! Assumes and ignores: small angles; side forces of driven or braked wheels are those of free ones.
//!
//! Valid for: riding forward.
//!
//! Checked by: `tests`: a yaw rate that follows from an additional steer angle pushes as K2 and C1
//! of that steer angle do.

use crate::hooks::Mechanism;
use crate::moment::{Moment, Wrench};
use nalgebra::{Matrix2, Vector2};
use twinhub_linear::{Bicycle, BicycleError, Canonical, MotorPair, Parameters};

/// Coefficients of one bicycle.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    pub parameters: Parameters,
    pub canonical: Canonical,
    pub terms: Terms,
    /// Inverse of the mass matrix of all.
    pub mass_inverse: Matrix2<f64>,
    /// Yaw rate per speed and steer angle, and per steer rate.
    pub yaw: [f64; 2],
    pub mass_kg: f64,
    /// With the wheels' spin.
    pub effective_mass_kg: f64,
    /// Centre of mass of all: forward of the rear contact, and above the ground.
    pub centre_m: [f64; 2],
    pub gravity_m_s2: f64,
    slip: Slip,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Slip {
    mz: f64,
    mx: f64,
    ixz: f64,
    izz: f64,
    spin: f64,
    wheelbase_m: f64,
    front: [f64; 3],
    trail_cos: f64,
}

/// Matrices of roll and steer by power of speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Terms {
    pub mass: Matrix2<f64>,
    pub damping: [Matrix2<f64>; 2],
    pub stiffness: [Matrix2<f64>; 3],
    /// Of the steer axis tilt.
    pub sin_tilt: f64,
    pub cos_tilt: f64,
    /// c cos(lam)/w.
    pub trail_ratio: f64,
}

impl Terms {
    fn new(canonical: &Canonical, p: &Parameters) -> Self {
        let (sin_tilt, cos_tilt) = libm::sincos(p.lam);
        Self {
            sin_tilt,
            cos_tilt,
            trail_ratio: p.c / p.w * cos_tilt,
            mass: canonical.mass(),
            damping: [Matrix2::zeros(), canonical.c1()],
            stiffness: [canonical.k0() * p.g, Matrix2::zeros(), canonical.k2()],
        }
    }
}

impl Body {
    /// The bicycle with mechanisms; an error if a value cannot be.
    pub fn with(
        bicycle: &Bicycle,
        mechanisms: &[(&'static dyn Mechanism, &[f64])],
    ) -> Result<Self, BicycleError> {
        let mut changed = bicycle.clone();
        for (mechanism, p) in mechanisms {
            mechanism.reshape(p, &mut changed.parameters);
        }
        let mut body = Self::new(&changed)?;
        for (mechanism, p) in mechanisms {
            mechanism.terms(p, &mut body.terms);
        }
        let inverse = body.terms.mass.try_inverse();
        body.mass_inverse = inverse
            .filter(|m| m[(0, 0)] > 0.0 && m[(1, 1)] > 0.0)
            .ok_or_else(|| BicycleError::SingularMass {
                bicycle: bicycle.name.clone(),
                rcond: 0.0,
            })?;
        Ok(body)
    }

    /// The bicycle without any mechanism.
    pub fn new(bicycle: &Bicycle) -> Result<Self, BicycleError> {
        let canonical = Canonical::new(bicycle)?;
        let p = bicycle.parameters;
        let mass_kg = p.mR + p.mB + p.mH + p.mF;
        let moment = [
            p.mB * p.xB + p.mH * p.xH + p.mF * p.w,
            -p.rR * p.mR + p.mB * p.zB + p.mH * p.zH - p.mF * p.rF,
        ];
        let spin = |i: f64, r: f64| if r > 0.0 { i / r } else { 0.0 };
        let (rear, front) = (spin(p.IRyy, p.rR), spin(p.IFyy, p.rF));
        let per = |s: f64, r: f64| if r > 0.0 { s / r } else { 0.0 };
        let (sin, cos) = libm::sincos(p.lam);
        let front_mass = p.mH + p.mF;
        let (xa, za) = if front_mass > 0.0 {
            (
                (p.xH * p.mH + p.w * p.mF) / front_mass,
                (p.zH * p.mH - p.rF * p.mF) / front_mass,
            )
        } else {
            (p.xH, p.zH)
        };
        let ua = (xa - p.w - p.c) * cos - za * sin;
        let ixz = p.IHxz - p.mH * (p.xH - xa) * (p.zH - za) + p.mF * (p.w - xa) * (p.rF + za);
        let izz =
            p.IHzz + p.IFxx + p.mH * (p.xH - xa) * (p.xH - xa) + p.mF * (p.w - xa) * (p.w - xa);
        Ok(Self {
            mass_inverse: canonical
                .input_matrix()
                .fixed_view::<2, 2>(2, 0)
                .into_owned(),
            terms: Terms::new(&canonical, &p),
            yaw: [
                canonical.yaw_rate_rad_s(1.0, 1.0, 0.0),
                canonical.yaw_rate_rad_s(0.0, 0.0, 1.0),
            ],
            mass_kg,
            effective_mass_kg: mass_kg + per(rear, p.rR) + per(front, p.rF),
            centre_m: [moment[0] / mass_kg, -moment[1] / mass_kg],
            gravity_m_s2: p.g,
            slip: Slip {
                mz: moment[1],
                mx: moment[0],
                ixz: p.IBxz + p.IHxz - p.mB * p.xB * p.zB - p.mH * p.xH * p.zH + p.mF * p.w * p.rF,
                izz: p.IRxx
                    + p.IBzz
                    + p.IHzz
                    + p.IFxx
                    + p.mB * p.xB * p.xB
                    + p.mH * p.xH * p.xH
                    + p.mF * p.w * p.w,
                spin: rear + front,
                wheelbase_m: p.w,
                front: [
                    front_mass * ua,
                    front_mass * ua * xa + ixz * sin + izz * cos,
                    front * sin,
                ],
                trail_cos: p.c * cos,
            },
            parameters: p,
            canonical,
        })
    }

    /// What an additional yaw rate and its derivative push with.
    pub fn slip_wrench(&self, speed_m_s: f64, rate_rad_s: f64, accel_rad_s2: f64) -> Wrench {
        let (s, v) = (&self.slip, speed_m_s);
        let side = (s.mx * v * rate_rad_s + s.izz * accel_rad_s2) / s.wheelbase_m;
        let [mass, inertia, spin] = s.front;
        Wrench {
            roll_nm: s.mz * v * rate_rad_s - s.ixz * accel_rad_s2 - v * s.spin * rate_rad_s,
            steer_nm: -(mass * v * rate_rad_s + inertia * accel_rad_s2 + v * spin * rate_rad_s)
                - s.trail_cos * side,
            yaw_rate_rad_s: rate_rad_s,
            ..Wrench::default()
        }
    }

    /// A of z' = A z + b, what slip of both wheels does: z is the lateral velocity of the rear contact
    /// and the yaw rate that is added to the kinematic one, for wheels whose side slip per side force
    /// is `compliance_rad_n`. From the lateral and the yaw balance, with F_R = -u/(v k) and
    /// F_F = -(u + w r)/(v k).
    pub fn slip_matrix(&self, speed_m_s: f64, compliance_rad_n: f64) -> Matrix2<f64> {
        const LEAST_M_S: f64 = 0.2;
        let (s, v, m) = (&self.slip, speed_m_s, self.mass_kg);
        let stiffness = 1.0 / (v.abs().max(LEAST_M_S) * compliance_rad_n);
        let w = s.wheelbase_m;
        let forces =
            -stiffness * Matrix2::new(2.0, w, w, w * w) - Matrix2::new(0.0, m * v, 0.0, s.mx * v);
        self.slip_inverse() * forces
    }

    /// b of the same: the side forces that would be needed without slip.
    pub fn slip_load(&self, at: &Moment<'_>) -> Vector2<f64> {
        let (s, v, m) = (&self.slip, at.speed_m_s, self.mass_kg);
        let [front_mass, front_inertia, front_spin] = s.front;
        let (yaw, turn) = (at.yaw_rate_rad_s(), at.yaw_accel_rad_s2());
        let ([roll_accel, steer_accel], [roll_rate, steer_rate]) = (at.accel_rad_s2, at.rate_rad_s);
        // Side forces without slip: their sum, and the front one times the wheelbase.
        let without = Vector2::new(
            m * v * yaw + s.mx * turn - s.mz * roll_accel + front_mass * steer_accel
                - at.inputs.side_force_n,
            s.mx * v * yaw + s.izz * turn + s.ixz * roll_accel + front_inertia * steer_accel
                - v * (s.spin * roll_rate + front_spin * steer_rate)
                - at.inputs.yaw_torque_nm,
        );
        -(self.slip_inverse() * without)
    }

    fn slip_inverse(&self) -> Matrix2<f64> {
        let s = &self.slip;
        Matrix2::new(self.mass_kg, s.mx, s.mx, s.izz)
            .try_inverse()
            .unwrap_or_else(Matrix2::zeros)
    }

    /// Torques of a lateral acceleration of the rear contact.
    pub fn slide_wrench(&self, accel_m_s2: f64) -> Wrench {
        let s = &self.slip;
        Wrench {
            roll_nm: s.mz * accel_m_s2,
            steer_nm: -(s.front[0] + s.trail_cos * s.mx / s.wheelbase_m) * accel_m_s2,
            ..Wrench::default()
        }
    }

    /// Weight share of the front wheel.
    pub fn front_share(&self) -> f64 {
        self.centre_m[0] / self.parameters.w
    }

    /// Torque per steer acceleration while the frame is free to roll.
    pub fn steer_inertia_kg_m2(&self) -> f64 {
        1.0 / self.mass_inverse[(1, 1)]
    }

    /// C of all.
    pub fn damping(&self, speed_m_s: f64) -> Matrix2<f64> {
        self.terms.damping[0] + self.terms.damping[1] * speed_m_s
    }

    /// K of all with the motors' part.
    pub fn stiffness(&self, speed_m_s: f64, pair: MotorPair) -> Matrix2<f64> {
        let bare =
            self.canonical.stiffness(0.0, pair) - self.canonical.stiffness(0.0, MotorPair::OFF);
        let [k0, k1, k2] = self.terms.stiffness;
        k0 + (k1 + k2 * speed_m_s) * speed_m_s + bare
    }

    /// Roll and steer torque per newton of a side force on the rear frame at (x, z).
    pub fn side_force_arm_m(&self, x_m: f64, z_m: f64) -> [f64; 2] {
        [-z_m, self.yaw[1] * x_m]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An additional steer angle e seen by the wheels alone turns the bicycle by v e cos(lam)/w:
    /// what that pushes with is -v² K2 e plus what the gyroscopic part of the turned axle does, and
    /// -v C1 e' in roll.
    #[test]
    fn slip_pushes_as_a_steer_angle_does() {
        let bicycle = Bicycle::load("meijaard2007_benchmark").unwrap();
        let body = Body::new(&bicycle).unwrap();
        let p = &bicycle.parameters;
        let (v, e) = (4.0, 0.01);
        let w = body.slip_wrench(v, body.yaw[0] * v * e, 0.0);
        let k2 = body.canonical.k2();
        assert!((w.roll_nm + v * v * k2[(0, 1)] * e).abs() < 1e-12);
        assert!((w.steer_nm + v * v * k2[(1, 1)] * e).abs() < 1e-12);
        // With a rate: the part of C1 that comes with v e'.
        let rate = 0.02;
        let w = body.slip_wrench(v, 0.0, body.yaw[0] * v * rate);
        let itxz = p.IBxz + p.IHxz - p.mB * p.xB * p.zB - p.mH * p.xH * p.zH + p.mF * p.w * p.rF;
        assert!((w.roll_nm + v * rate * itxz / p.w * libm::cos(p.lam)).abs() < 1e-12);
    }
}
