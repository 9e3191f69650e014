//! What: the linearised equations of the Whipple-Carvallo bicycle with a torque pair of its motors,
//! M q'' + v C1 q' + [g K0 + v² K2 + pair] q = f, with q = (roll, steer), f = (roll torque, steer
//! torque).
//!
//! Source: Meijaard, Papadopoulos, Ruina and Schwab (2007), appendix A, for the four matrices;
//! `motor_pair` for the torques.
//!
//! Assumes and ignores: rigid bodies, knife-edge wheels without slip, rigid rider, small angles.
//!
//! Valid for: straight running at any speed, also backwards; with an unbalanced pair the speed is
//! that of the moment.
//!
//! Checked by: eigenvalues of table 2 of the paper (1e-12 relative + 2e-14); a nonlinear model of
//! its own in `tests/linear/no_slip.rs` (1e-6; reached 1e-9).

use crate::added::matrix;
use crate::bicycle::Bicycle;
use crate::error::BicycleError;
use crate::motor_pair::{MotorPair, PairCoefficients};
use nalgebra::{Matrix2, Matrix4, Matrix4x2, Vector2};

/// The canonical matrices of one bicycle.
#[derive(Debug, Clone, PartialEq)]
pub struct Canonical {
    m: Matrix2<f64>,
    m_inverse: Matrix2<f64>,
    c1: Matrix2<f64>,
    k0: Matrix2<f64>,
    k2: Matrix2<f64>,
    g: f64,
    /// Beyond rigid bodies: damping and stiffness at any speed.
    added_damping: Matrix2<f64>,
    added_stiffness: Matrix2<f64>,
    /// Yaw rate per speed and steer angle, cos(lam)/w; and per steer rate.
    yaw: [f64; 2],
    pair: PairCoefficients,
}

/// Least reciprocal condition number (of the matrix scaled to unit diagonal) that is inverted.
const LEAST_RCOND: f64 = 1e-13;

impl Canonical {
    /// The matrices of `bicycle`; an error if its values cannot be or its mass matrix is singular.
    #[allow(non_snake_case)]
    pub fn new(bicycle: &Bicycle) -> Result<Self, BicycleError> {
        bicycle.validate()?;
        let p = &bicycle.parameters;
        let (sin, cos) = libm::sincos(p.lam);
        // Whole bicycle (A 1)-(A 6).
        let mT = p.mR + p.mB + p.mH + p.mF;
        let mxT = p.xB * p.mB + p.xH * p.mH + p.w * p.mF;
        let mzT = -p.rR * p.mR + p.zB * p.mB + p.zH * p.mH - p.rF * p.mF;
        let ITxx = p.IRxx
            + p.IBxx
            + p.IHxx
            + p.IFxx
            + p.mR * p.rR * p.rR
            + p.mB * p.zB * p.zB
            + p.mH * p.zH * p.zH
            + p.mF * p.rF * p.rF;
        let ITxz = p.IBxz + p.IHxz - p.mB * p.xB * p.zB - p.mH * p.xH * p.zH + p.mF * p.w * p.rF;
        let ITzz = p.IRxx
            + p.IBzz
            + p.IHzz
            + p.IFxx
            + p.mB * p.xB * p.xB
            + p.mH * p.xH * p.xH
            + p.mF * p.w * p.w;
        // Front assembly with wheel (A 7)-(A 12); without mass its centre is that of the fork.
        let mA = p.mH + p.mF;
        let (xA, zA) = if mA > 0.0 {
            (
                (p.xH * p.mH + p.w * p.mF) / mA,
                (p.zH * p.mH - p.rF * p.mF) / mA,
            )
        } else {
            (p.xH, p.zH)
        };
        let IAxx =
            p.IHxx + p.IFxx + p.mH * (p.zH - zA) * (p.zH - zA) + p.mF * (p.rF + zA) * (p.rF + zA);
        let IAxz = p.IHxz - p.mH * (p.xH - xA) * (p.zH - zA) + p.mF * (p.w - xA) * (p.rF + zA);
        let IAzz =
            p.IHzz + p.IFxx + p.mH * (p.xH - xA) * (p.xH - xA) + p.mF * (p.w - xA) * (p.w - xA);
        // About the steer axis (A 13)-(A 17).
        let uA = (xA - p.w - p.c) * cos - zA * sin;
        let IAll = mA * uA * uA + IAxx * sin * sin + 2.0 * IAxz * sin * cos + IAzz * cos * cos;
        let IAlx = -mA * uA * zA + IAxx * sin + IAxz * cos;
        let IAlz = mA * uA * xA + IAxz * sin + IAzz * cos;
        let mu = p.c / p.w * cos;
        // Wheels (A 18), a skate does not spin; and the static moment (A 19).
        let SR = if p.rR > 0.0 { p.IRyy / p.rR } else { 0.0 };
        let SF = if p.rF > 0.0 { p.IFyy / p.rF } else { 0.0 };
        let ST = SR + SF;
        let SA = mA * uA + mu * mxT;
        // The matrices (A 20)-(A 24).
        let Mxd = IAlx + mu * ITxz;
        let m = Matrix2::new(ITxx, Mxd, Mxd, IAll + 2.0 * mu * IAlz + mu * mu * ITzz)
            + matrix(&bicycle.added.mass_kg_m2);
        let k0 = Matrix2::new(mzT, -SA, -SA, -SA * sin);
        let k2 = Matrix2::new(
            0.0,
            (ST - mzT) / p.w * cos,
            0.0,
            (SA + SF * sin) / p.w * cos,
        );
        let c1 = Matrix2::new(
            0.0,
            mu * ST + SF * cos + ITxz / p.w * cos - mu * mzT,
            -(mu * ST + SF * cos),
            IAlz / p.w * cos + mu * (SA + ITzz / p.w * cos),
        );
        let det = m[(0, 0)] * m[(1, 1)] - m[(0, 1)] * m[(1, 0)];
        let rcond = det / (m[(0, 0)] * m[(1, 1)]);
        if !(rcond > LEAST_RCOND && m[(0, 0)] > 0.0) {
            let rcond = if rcond.is_finite() { rcond } else { 0.0 };
            return Err(BicycleError::SingularMass {
                bicycle: bicycle.name.clone(),
                rcond,
            });
        }
        let m_inverse = Matrix2::new(
            m[(1, 1)] / det,
            -m[(0, 1)] / det,
            -m[(1, 0)] / det,
            m[(0, 0)] / det,
        );
        let pair = PairCoefficients::new(p, mT, mzT, mA * uA, SA, SF, ST, mu, &c1);
        Ok(Self {
            m,
            m_inverse,
            c1,
            k0,
            k2,
            g: p.g,
            added_damping: matrix(&bicycle.added.damping_nms_rad),
            added_stiffness: matrix(&bicycle.added.stiffness_nm_rad),
            yaw: [cos / p.w, mu],
            pair,
        })
    }

    /// M, kg m².
    pub fn mass(&self) -> Matrix2<f64> {
        self.m
    }

    /// v C1 and what is added to it, N m s.
    pub fn damping(&self, speed_m_s: f64) -> Matrix2<f64> {
        self.c1 * speed_m_s + self.added_damping
    }

    /// g K0 + v² K2, the pair's part and what is added, N m.
    pub fn stiffness(&self, speed_m_s: f64, pair: MotorPair) -> Matrix2<f64> {
        let [roll_steer, steer_steer] = self.pair.stiffness(pair);
        self.k0 * self.g
            + self.k2 * (speed_m_s * speed_m_s)
            + self.added_stiffness
            + Matrix2::new(0.0, roll_steer, 0.0, steer_steer)
    }

    /// C1, without the speed, kg m.
    pub fn c1(&self) -> Matrix2<f64> {
        self.c1
    }

    /// K0, without gravity, kg m.
    pub fn k0(&self) -> Matrix2<f64> {
        self.k0
    }

    /// K2, without the speed, kg.
    pub fn k2(&self) -> Matrix2<f64> {
        self.k2
    }

    /// A of x' = A x + B f, x = (roll, steer, roll rate, steer rate).
    pub fn state_matrix(&self, speed_m_s: f64, pair: MotorPair) -> Matrix4<f64> {
        let k = -self.m_inverse * self.stiffness(speed_m_s, pair);
        let c = -self.m_inverse * self.damping(speed_m_s);
        let mut a = Matrix4::zeros();
        a[(0, 2)] = 1.0;
        a[(1, 3)] = 1.0;
        a.fixed_view_mut::<2, 2>(2, 0).copy_from(&k);
        a.fixed_view_mut::<2, 2>(2, 2).copy_from(&c);
        a
    }

    /// B of x' = A x + B f, f = (roll torque, steer torque).
    pub fn input_matrix(&self) -> Matrix4x2<f64> {
        let mut b = Matrix4x2::zeros();
        b.fixed_view_mut::<2, 2>(2, 0).copy_from(&self.m_inverse);
        b
    }

    /// Roll and steer acceleration, rad/s².
    pub fn acceleration(
        &self,
        speed_m_s: f64,
        pair: MotorPair,
        angle_rad: Vector2<f64>,
        rate_rad_s: Vector2<f64>,
        torque_nm: Vector2<f64>,
    ) -> Vector2<f64> {
        self.m_inverse
            * (torque_nm
                - self.damping(speed_m_s) * rate_rad_s
                - self.stiffness(speed_m_s, pair) * angle_rad)
    }

    /// Yaw rate of the rear frame: (v steer + c steer rate) cos(lam)/w, paper's (4.6).
    pub fn yaw_rate_rad_s(&self, speed_m_s: f64, steer_rad: f64, steer_rate_rad_s: f64) -> f64 {
        self.yaw[0] * speed_m_s * steer_rad + self.yaw[1] * steer_rate_rad_s
    }

    /// Forward acceleration that an unbalanced pair causes, m/s²; zero for a balanced one.
    pub fn longitudinal_accel_m_s2(&self, pair: MotorPair) -> f64 {
        self.pair.acceleration_m_s2(pair)
    }

    /// Steer stiffness per newton of balanced pair force, c (w + c)/w cos²(lam), m/rad.
    pub fn pair_stiffness_per_force_m(&self) -> f64 {
        self.pair.per_force_m()
    }
}
