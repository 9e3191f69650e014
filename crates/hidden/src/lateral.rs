//! What: lateral motion of the Whipple-Carvallo bicycle before the tyres are put in: lateral force,
//! roll, yaw and steer balance with the side forces of both contacts left in.
//!
//! Equation, in axes that turn with the heading of the rear frame, origin at the rear contact,
//! lateral velocity u and yaw rate r of that point, speed v, forward acceleration a, spin momentum
//! h = I w of each wheel, u_A the distance of the front assembly's centre ahead of the steer axis:
//!
//! * lateral: m_T (u' + v r) + m_T x_T r' - m_T z_T roll'' + m_A u_A steer'' = F_R + F_F + X_F steer cos(lam)
//! * roll: - m_T z_T (u' + v r) + I_Txz r' + I_Txx roll'' + I_Aλx steer'' + (h_R + h_F) r
//!   + (h_F steer)' cos(lam) = g (- m_T z_T roll + m_A u_A steer) + c cos(lam) N_F steer
//! * yaw: m_T x_T (u' + v r) + I_Tzz r' + I_Txz roll'' + I_Aλz steer'' + a (m_T z_T roll - m_A u_A steer)
//!   - (h_R roll)' - (h_F (roll + steer sin(lam)))' = w F_F + (w + c) cos(lam) X_F steer
//! * steer: m_A u_A (u' + v r) + I_Aλz r' + I_Aλx roll'' + I_Aλλ steer'' + h_F (r sin(lam) - roll' cos(lam))
//!   - a cos(lam) m_A u_A steer = (g m_A u_A + c cos(lam) N_F) (roll + steer sin(lam)) - c cos(lam) F_F
//! * front load: w N_F = m_T x_T g + (m_T z_T - I_R/r_R - I_F/r_F) a
//! * without slip: u = 0, r = (v steer + c steer') cos(lam)/w.
//!
//! F are side forces across the wheels' headings, X_F the force along the front wheel's.
//!
//! Source: own derivation, moment balances of mass elements about the rear contact and the steer
//! axis. Inertias as defined by Meijaard, Papadopoulos, Ruina and Schwab (2007), appendix A.
//!
//! Assumes and ignores: small angles, rigid bodies, wheels that roll without longitudinal slip.
//!
//! Valid for: riding forward.
//!
//! Checked by: `tests` here (eigenvalues of the paper's table 2, energy, signs) and in `motion`.

use crate::bicycle::Bicycle;

/// Sums over the bodies.
#[allow(non_snake_case)]
#[derive(Clone, Debug)]
pub struct Sums {
    pub m_T: f64,
    pub mx_T: f64,
    pub mz_T: f64,
    pub I_Txx: f64,
    pub I_Txz: f64,
    pub I_Tzz: f64,
    /// First moment of the front assembly about the steer axis, m_A u_A.
    pub mu_A: f64,
    pub I_Ax: f64,
    pub I_Az: f64,
    pub I_A: f64,
    pub sin: f64,
    pub cos: f64,
    pub w: f64,
    pub c: f64,
    pub g: f64,
    pub r_R: f64,
    pub r_F: f64,
    pub I_R: f64,
    pub I_F: f64,
}

/// A mass fixed to the rear frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointMass {
    pub mass_kg: f64,
    pub x_m: f64,
    pub z_m: f64,
}

/// Moments: lateral force, roll, yaw and steer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Balance {
    pub lateral_n: f64,
    pub roll_nm: f64,
    pub yaw_nm: f64,
    pub steer_nm: f64,
}

impl Balance {
    /// A side force on the rear frame at (x, z).
    pub fn side_force(force_n: f64, x_m: f64, z_m: f64) -> Self {
        Self {
            lateral_n: force_n,
            roll_nm: -z_m * force_n,
            yaw_nm: x_m * force_n,
            steer_nm: 0.0,
        }
    }

    pub fn add(&mut self, other: Self) {
        self.lateral_n += other.lateral_n;
        self.roll_nm += other.roll_nm;
        self.yaw_nm += other.yaw_nm;
        self.steer_nm += other.steer_nm;
    }
}

/// Angles and rates, and what the longitudinal motion says.
#[derive(Clone, Copy, Debug, Default)]
pub struct Posture {
    pub roll_rad: f64,
    pub steer_rad: f64,
    pub roll_rate_rad_s: f64,
    pub steer_rate_rad_s: f64,
    pub yaw_rate_rad_s: f64,
    pub speed_m_s: f64,
    pub accel_m_s2: f64,
    /// Forward force of the ground on the front wheel.
    pub front_force_n: f64,
}

impl Sums {
    #[allow(non_snake_case)]
    pub fn new(b: &Bicycle, payload: PointMass) -> Self {
        let (sin, cos) = libm::sincos(b.lam);
        // Mass, x, z, inertia about its own centre: xx, xz, zz.
        let p = payload;
        let bodies = [
            [b.mR, 0.0, -b.rR, b.IRxx, 0.0, b.IRxx],
            [b.mB, b.xB, b.zB, b.IBxx, b.IBxz, b.IBzz],
            [p.mass_kg, p.x_m, p.z_m, 0.0, 0.0, 0.0],
            [b.mH, b.xH, b.zH, b.IHxx, b.IHxz, b.IHzz],
            [b.mF, b.w, -b.rF, b.IFxx, 0.0, b.IFxx],
        ];
        let sum = |from: usize, f: fn(&[f64; 6]) -> f64| bodies[from..].iter().map(f).sum::<f64>();
        // Front assembly: every product of inertia about the steer axis from its elements' distance
        // u ahead of the axis, plus the own inertias turned into it.
        let u = |body: &[f64; 6]| (body[1] - b.w - b.c) * cos - body[2] * sin;
        let (mut mu_A, mut I_Ax, mut I_Az, mut I_A) = (0.0, 0.0, 0.0, 0.0);
        for body in &bodies[3..] {
            let [m, x, z, xx, xz, zz] = *body;
            let u = u(body);
            mu_A += m * u;
            I_Ax += -m * u * z + xx * sin + xz * cos;
            I_Az += m * u * x + xz * sin + zz * cos;
            I_A += m * u * u + xx * sin * sin + 2.0 * xz * sin * cos + zz * cos * cos;
        }
        Self {
            m_T: sum(0, |k| k[0]),
            mx_T: sum(0, |k| k[0] * k[1]),
            mz_T: sum(0, |k| k[0] * k[2]),
            I_Txx: sum(0, |k| k[3] + k[0] * k[2] * k[2]),
            I_Txz: sum(0, |k| k[4] - k[0] * k[1] * k[2]),
            I_Tzz: sum(0, |k| k[5] + k[0] * k[1] * k[1]),
            mu_A,
            I_Ax,
            I_Az,
            I_A,
            sin,
            cos,
            w: b.w,
            c: b.c,
            g: b.g,
            r_R: b.rR,
            r_F: b.rF,
            I_R: b.IRyy,
            I_F: b.IFyy,
        }
    }

    /// Mass that the drive has to accelerate.
    pub fn rolling_mass_kg(&self) -> f64 {
        self.m_T + self.I_R / (self.r_R * self.r_R) + self.I_F / (self.r_F * self.r_F)
    }

    /// Load on the front wheel.
    pub fn front_load_n(&self, accel_m_s2: f64) -> f64 {
        let lift = self.mz_T - self.I_R / self.r_R - self.I_F / self.r_F;
        (self.mx_T * self.g + lift * accel_m_s2) / self.w
    }

    /// Load on the rear wheel.
    pub fn rear_load_n(&self, accel_m_s2: f64) -> f64 {
        self.m_T * self.g - self.front_load_n(accel_m_s2)
    }

    /// Everything but accelerations and side forces of the tyres, on the right-hand side.
    #[allow(non_snake_case)]
    pub fn balance(&self, p: &Posture) -> Balance {
        let (v, a, r) = (p.speed_m_s, p.accel_m_s2, p.yaw_rate_rad_s);
        let (roll, steer) = (p.roll_rad, p.steer_rad);
        let (h_R, h_F) = (self.I_R * v / self.r_R, self.I_F * v / self.r_F);
        let (dh_R, dh_F) = (self.I_R * a / self.r_R, self.I_F * a / self.r_F);
        let N_F = self.front_load_n(a);
        let tilt = roll + steer * self.sin;
        let tilt_rate = p.roll_rate_rad_s + p.steer_rate_rad_s * self.sin;
        Balance {
            lateral_n: -self.m_T * v * r + p.front_force_n * steer * self.cos,
            roll_nm: self.mz_T * v * r
                - (h_R + h_F) * r
                - (h_F * p.steer_rate_rad_s + dh_F * steer) * self.cos
                + self.g * (-self.mz_T * roll + self.mu_A * steer)
                + self.c * self.cos * N_F * steer,
            yaw_nm: -self.mx_T * v * r - a * (self.mz_T * roll - self.mu_A * steer)
                + h_R * p.roll_rate_rad_s
                + dh_R * roll
                + h_F * tilt_rate
                + dh_F * tilt
                + (self.w + self.c) * self.cos * p.front_force_n * steer,
            steer_nm: -self.mu_A * v * r - h_F * (r * self.sin - p.roll_rate_rad_s * self.cos)
                + a * self.cos * self.mu_A * steer
                + (self.g * self.mu_A + self.c * self.cos * N_F) * tilt,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn none() -> PointMass {
        PointMass {
            mass_kg: 0.0,
            x_m: 0.0,
            z_m: 0.0,
        }
    }

    #[test]
    fn loads_carry_the_weight_and_shift_when_braking() {
        let sums = Sums::new(&Bicycle::benchmark(), none());
        let weight = sums.m_T * sums.g;
        assert!((sums.front_load_n(0.0) + sums.rear_load_n(0.0) - weight).abs() < 1e-9);
        assert!(sums.front_load_n(-1.0) > sums.front_load_n(0.0));
    }

    #[test]
    fn a_payload_adds_to_every_sum_as_a_body_does() {
        let bare = Bicycle::benchmark();
        let extra = PointMass {
            mass_kg: 10.0,
            x_m: -0.1,
            z_m: -0.8,
        };
        let sums = Sums::new(&bare, extra);
        let before = Sums::new(&bare, none());
        assert!((sums.m_T - before.m_T - 10.0).abs() < 1e-9);
        assert!((sums.I_Txx - before.I_Txx - 6.4).abs() < 1e-9);
        assert!((sums.I_Txz - before.I_Txz + 0.8).abs() < 1e-9);
        assert_eq!(sums.I_A, before.I_A);
    }
}
