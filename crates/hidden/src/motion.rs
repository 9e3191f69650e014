//! What: motion of the ridden bicycle, with everything that may be hidden in it.
//!
//! Equation: the balances of `lateral`, m_eff v' = M_rear/r_R - M_front/r_F - drag for the speed,
//! w = v/r for the wheels, and
//!
//! * no slip: the constraint itself; yaw times c cos(lam)/w added to steer removes F_F;
//! * path that lags (tyre relaxation): r' = (r_noslip - r) v/length;
//! * slipping tyres: F = -(lateral speed across the wheel)/(v k), at most mu N on a patch;
//! * Coulomb friction: the torque, within its limit, that stops the steer at the end of the step:
//!   it sticks;
//! * backlash, fork torsion: the bar is a body of its own, coupled over a dead band or a spring.
//!
//! Source: own derivation; slip and relaxation in the sense of Pacejka, "Tyre and vehicle dynamics"
//! (2012), chapters 4 and 5.
//!
//! Assumes and ignores: what `lateral` does; the bar's inertia counts about the steer axis only.
//!
//! Valid for: 1 to 12 m/s.
//!
//! Checked by: `motion_test`.

use crate::lateral::{Balance, PointMass, Posture, Sums};
use crate::state::*;
use crate::truth::Truth;
use nalgebra::{SMatrix, SVector};

/// Natural frequency and damping ratio of the rider's arms.
const ARMS_RAD_S: f64 = 30.0;
const ARMS_DAMPING: f64 = 0.75;
const AIR_KG_M3: f64 = 1.225;
/// Side area times coefficient, and where the wind presses.
const SIDE_AREA_M2: f64 = 0.7;
const WIND_AT_M: [f64; 2] = [0.45, -1.0];
/// The bar's part of the front assembly's inertia, when it is a body of its own.
const BAR_KG_M2: f64 = 0.05;
const HEADSET_NM_RAD: f64 = 3000.0;
/// Side slip per force of a wheel that grips, where grip can be lost.
pub(crate) const STIFF_RAD_N: f64 = 4e-6;

/// The bicycle, ready to move.
#[derive(Clone, Debug)]
pub struct Motion {
    pub truth: Truth,
    pub sums: Sums,
    swing: Swing,
}

/// A body that swings sideways on the rear frame.
#[derive(Clone, Copy, Debug)]
struct Swing {
    mass: PointMass,
    /// Length of the pendulum.
    length_m: f64,
    stiffness_nm_rad: f64,
    damping_nms_rad: f64,
}

impl Motion {
    pub fn new(truth: &Truth) -> Self {
        let liquid = truth.outside.slosh_kg;
        let at = |mass_kg: f64, x_m: f64, z_m: f64| PointMass { mass_kg, x_m, z_m };
        // The upper body is part of the rigid rider and stands on the hip; the liquid hangs.
        let swing = if liquid > 0.0 {
            Swing {
                mass: at(liquid, -0.1, -0.7),
                length_m: -0.17,
                stiffness_nm_rad: 0.0,
                damping_nms_rad: 0.01 * liquid,
            }
        } else {
            let m = truth.upper_body_kg;
            let length = 0.3;
            Swing {
                mass: at(m, 0.3, -1.15),
                length_m: length,
                stiffness_nm_rad: m * length * (truth.bicycle.g + length * 80.0),
                damping_nms_rad: m * length * length * 4.0,
            }
        };
        Self {
            sums: Sums::new(&truth.bicycle, truth.payload),
            truth: truth.clone(),
            swing,
        }
    }

    /// A longest step with which the classical Runge-Kutta method stays stable and accurate.
    pub fn longest_step_s(&self, speed_m_s: f64) -> f64 {
        let t = &self.truth;
        let mut fastest = 300.0_f64;
        let mut see = |rate: f64| fastest = fastest.max(rate);
        if t.slips() {
            let k = if t.compliance_rad_n > 0.0 {
                t.compliance_rad_n
            } else {
                STIFF_RAD_N
            };
            // Steer, yaw and roll all give way at the front contact: it resists with a few kilograms.
            see(1.0 / (k * speed_m_s.max(1.0) * 0.03 * self.sums.m_T));
        }
        if t.relaxation_m > 0.0 {
            see(speed_m_s / t.relaxation_m);
        }
        for lag in [t.front_lag_s, t.rear_lag_s] {
            if lag > 0.0 {
                see(1.0 / lag);
            }
        }
        if t.backlash_rad > 0.0 {
            see(2.0 * libm::sqrt(HEADSET_NM_RAD / BAR_KG_M2));
        }
        1.2 / fastest
    }

    /// Whether the bar moves on its own.
    pub fn has_bar(&self) -> bool {
        self.truth.backlash_rad > 0.0 || self.truth.outside.fork_hz > 0.0
    }

    /// Torque from bar to fork.
    fn headset_nm(&self, x: &State) -> f64 {
        let (twist, rate) = (x[BAR] - x[STEER], x[BAR_RATE] - x[STEER_RATE]);
        let hz = self.truth.outside.fork_hz;
        if hz > 0.0 {
            let omega = 2.0 * core::f64::consts::PI * hz;
            // Both sides swing against each other.
            let reduced = BAR_KG_M2 * (self.sums.I_A - BAR_KG_M2) / self.sums.I_A;
            return reduced * (omega * omega * twist + 2.0 * 0.06 * omega * rate);
        }
        let half = 0.5 * self.truth.backlash_rad;
        let beyond = twist - twist.clamp(-half, half);
        if beyond == 0.0 {
            0.0
        } else {
            HEADSET_NM_RAD * beyond + 4.0 * rate
        }
    }

    fn noslip_yaw_rate_rad_s(&self, x: &State) -> f64 {
        (x[SPEED] * x[STEER] + self.sums.c * x[STEER_RATE]) * self.sums.cos / self.sums.w
    }

    /// Yaw rate of the state.
    pub fn yaw_rate_rad_s(&self, x: &State) -> f64 {
        if self.truth.slips() || self.truth.relaxation_m > 0.0 {
            x[YAW_RATE]
        } else {
            self.noslip_yaw_rate_rad_s(x)
        }
    }

    /// Forward acceleration, and the forward force of the ground on the front wheel.
    fn longitudinal(&self, x: &State, d: &Drive) -> (f64, f64) {
        let (t, s) = (&self.truth, &self.sums);
        let limit = |torque: f64| torque.clamp(-t.saturation_nm, t.saturation_nm);
        let front = if t.front_lag_s > 0.0 {
            x[FRONT_MOTOR]
        } else {
            d.front_brake_nm
        };
        let rear = if t.rear_lag_s > 0.0 {
            x[REAR_MOTOR]
        } else {
            d.rear_traction_nm
        };
        let (front, rear) = (limit(t.front_gain * front), limit(t.rear_gain * rear));
        let v = x[SPEED];
        let moving = (v / 0.05).clamp(-1.0, 1.0);
        let resistance = moving * (t.rolling_n + t.brake_drag_n)
            + t.drag_kg_m * v * v.abs()
            + s.m_T * s.g * libm::sin(t.slope_rad) * d.direction;
        let force = rear / s.r_R - front / s.r_F + d.push_n - resistance;
        let accel = force / s.rolling_mass_kg();
        (accel, -front / s.r_F - s.I_F * accel / (s.r_F * s.r_F))
    }

    /// Passive steer torques that depend on the state, and those of them that no library names.
    fn steer_nm(&self, x: &State, d: &Drive) -> (f64, f64) {
        let t = &self.truth;
        let hands = f64::from(u8::from(d.hands_on));
        let known = d.friction_nm
            - t.steer_damping_nms_rad * x[STEER_RATE]
            - hands * (t.arm_stiffness_nm_rad * x[STEER] + t.arm_damping_nms_rad * x[STEER_RATE])
            + t.imbalance_nm_s2 * (x[SPEED] / self.sums.r_F).powi(2) * libm::sin(x[FRONT_ANGLE]);
        let o = &t.outside;
        let unknown = -o.cubic_nm_rad3 * x[STEER].powi(3)
            - o.maxwell_nm_rad * x[MEMORY]
            - o.hysteresis_nm * x[MEMORY]
            + o.speed_torque_nm * libm::sin(1.7 * x[SPEED]);
        // One memory serves both; only one of them is there.
        (known, unknown)
    }

    /// Rates of change at a state.
    pub fn change(&self, x: &State, d: &Drive) -> Change {
        let (t, s) = (&self.truth, &self.sums);
        let v = x[SPEED];
        let (accel, front_force_n) = self.longitudinal(x, d);
        let r = self.yaw_rate_rad_s(x);
        let posture = Posture {
            roll_rad: x[ROLL],
            steer_rad: x[STEER],
            roll_rate_rad_s: x[ROLL_RATE],
            steer_rate_rad_s: x[STEER_RATE],
            yaw_rate_rad_s: r,
            speed_m_s: v,
            accel_m_s2: accel,
            front_force_n,
        };
        let mut q = s.balance(&posture);
        q.add(Balance::side_force(
            t.sensors.force_gain * d.pull_n,
            d.pull_at_m[0],
            d.pull_at_m[1],
        ));
        let wind = t.wind_m_s * d.direction;
        let pressure = 0.5 * AIR_KG_M3 * SIDE_AREA_M2 * libm::hypot(v, wind) * wind;
        q.add(Balance::side_force(
            pressure + d.gust_n,
            WIND_AT_M[0],
            WIND_AT_M[1],
        ));
        let across = s.g * t.cross_slope_rad * d.direction;
        q.add(Balance {
            lateral_n: s.m_T * across,
            roll_nm: -s.mz_T * across,
            yaw_nm: s.mx_T * across,
            steer_nm: s.mu_A * across,
        });
        q.roll_nm += d.road_roll_nm + s.g * t.offset_kg_m;
        q.yaw_nm += accel * t.offset_kg_m;
        q.roll_nm += t.pedal_nm * (libm::sin(x[CRANK]) + 0.4 * libm::sin(2.0 * x[CRANK] + 0.5));
        let camber_front = x[ROLL] + x[STEER] * s.sin;
        q.yaw_nm += t.twisting_nm_rad * (x[ROLL] + camber_front);
        q.steer_nm += t.twisting_nm_rad * camber_front * s.cos + d.road_steer_nm;
        let (known, unknown) = self.steer_nm(x, d);
        q.steer_nm += known + unknown;
        let hands = f64::from(u8::from(d.hands_on));
        let mut steer_inertia = s.I_A + hands * t.arm_inertia_kg_m2;
        let mut rate = [0.0; STATES];
        let torque_nm = t.sensors.torque_gain * x[TORQUE];
        if self.has_bar() {
            let through = self.headset_nm(x);
            q.steer_nm += through;
            steer_inertia -= BAR_KG_M2;
            rate[BAR] = x[BAR_RATE];
            rate[BAR_RATE] = (torque_nm - through) / BAR_KG_M2;
        } else {
            q.steer_nm += torque_nm;
        }
        let swing_torque = self.accelerate(x, &mut rate, q, steer_inertia, accel, d);
        rate[ROLL] = x[ROLL_RATE];
        rate[STEER] = x[STEER_RATE];
        rate[YAW] = r;
        rate[SPEED] = accel;
        rate[FRONT_ANGLE] = v / s.r_F;
        rate[CRANK] = 2.0 * core::f64::consts::PI * v / d.development_m;
        if t.front_lag_s > 0.0 {
            rate[FRONT_MOTOR] = (d.front_brake_nm - x[FRONT_MOTOR]) / t.front_lag_s;
        }
        if t.rear_lag_s > 0.0 {
            rate[REAR_MOTOR] = (d.rear_traction_nm - x[REAR_MOTOR]) / t.rear_lag_s;
        }
        rate[TORQUE] = x[TORQUE_RATE];
        rate[TORQUE_RATE] = ARMS_RAD_S * ARMS_RAD_S * (d.asked_nm - x[TORQUE])
            - 2.0 * ARMS_DAMPING * ARMS_RAD_S * x[TORQUE_RATE];
        rate[MEMORY] = self.memory_rate(x);
        rate[DISTANCE] = v;
        let slosh = if t.outside.slosh_kg > 0.0 {
            swing_torque
        } else {
            0.0
        };
        Change {
            rate,
            accel_m_s2: accel,
            yaw_rate_rad_s: r,
            outside_nm: [slosh, unknown],
        }
    }

    fn memory_rate(&self, x: &State) -> f64 {
        let o = &self.truth.outside;
        if o.maxwell_nm_rad > 0.0 {
            // Spring and damper in line, time constant 0.25 s: stretch of the spring.
            x[STEER_RATE] - x[MEMORY] / 0.25
        } else if o.hysteresis_nm > 0.0 {
            // Bouc-Wen with exponent 1, full torque after about 0.03 rad.
            let (z, rate) = (x[MEMORY], x[STEER_RATE]);
            (rate - 0.5 * rate.abs() * z - 0.5 * rate * z.abs()) / 0.015
        } else {
            0.0
        }
    }

    /// Solves the balances for the accelerations; gives the roll torque of what swings.
    fn accelerate(
        &self,
        x: &State,
        rate: &mut State,
        q: Balance,
        steer_inertia: f64,
        accel: f64,
        d: &Drive,
    ) -> f64 {
        let (t, s) = (&self.truth, &self.sums);
        let w = &self.swing;
        let (m, l) = (w.mass.mass_kg, w.length_m);
        let (ml, ml2) = (m * l, (m * l * l).max(1e-12));
        // Unknowns: u', r', roll'', steer'', swing'', front side force, rear side force.
        let mut a = SMatrix::<f64, 7, 7>::zeros();
        let mut b = SVector::<f64, 7>::zeros();
        let rows = [
            [s.m_T, s.mx_T, -s.mz_T, s.mu_A, ml],
            [s.mx_T, s.I_Tzz, s.I_Txz, s.I_Az, ml * w.mass.x_m],
            [-s.mz_T, s.I_Txz, s.I_Txx, s.I_Ax, -ml * w.mass.z_m],
            [s.mu_A, s.I_Az, s.I_Ax, steer_inertia, 0.0],
            [ml, ml * w.mass.x_m, -ml * w.mass.z_m, 0.0, ml2],
        ];
        for (i, row) in rows.iter().enumerate() {
            for (j, value) in row.iter().enumerate() {
                a[(i, j)] = *value;
            }
        }
        let weight = ml * s.g;
        let (swing, swing_rate) = (x[SWING], x[SWING_RATE]);
        let v = x[SPEED];
        let r = self.yaw_rate_rad_s(x);
        b[0] = q.lateral_n;
        // Its mass, beside the middle, lags behind when the bicycle accelerates.
        b[1] = q.yaw_nm + accel * ml * swing;
        b[2] = q.roll_nm + weight * swing;
        b[3] = q.steer_nm;
        b[4] = -ml * v * r + weight * (x[ROLL] + swing + t.cross_slope_rad * d.direction)
            - w.stiffness_nm_rad * swing
            - w.damping_nms_rad * swing_rate;
        // Side forces of front and rear.
        a[(0, 5)] = -1.0;
        a[(0, 6)] = -1.0;
        a[(1, 5)] = -s.w;
        a[(3, 5)] = s.c * s.cos;
        if t.slips() {
            let [front, rear] = self.side_forces_n(x, accel);
            a[(5, 5)] = 1.0;
            b[5] = front;
            a[(6, 6)] = 1.0;
            b[6] = rear;
        } else {
            a[(6, 0)] = 1.0;
            a[(5, 1)] = 1.0;
            if t.relaxation_m > 0.0 {
                b[5] = (self.noslip_yaw_rate_rad_s(x) - r) * v / t.relaxation_m;
            } else {
                a[(5, 3)] = -s.c * s.cos / s.w;
                b[5] = (accel * x[STEER] + v * x[STEER_RATE]) * s.cos / s.w;
            }
        }
        let found = a.lu().solve(&b).unwrap_or_else(SVector::zeros);
        rate[SIDE] = found[0];
        rate[YAW_RATE] = found[1];
        rate[ROLL_RATE] = found[2];
        rate[STEER_RATE] = found[3];
        if m > 0.0 {
            rate[SWING] = swing_rate;
            rate[SWING_RATE] = found[4];
        }
        weight * swing + ml * w.mass.z_m * found[4]
    }

    /// One step of the classical Runge-Kutta method; what drives is constant within it.
    pub fn step(&self, x: &State, drive: &Drive, step_s: f64) -> State {
        let d = Drive {
            friction_nm: self.friction_nm(x, drive, step_s),
            ..*drive
        };
        let ahead = |k: &State, h: f64| -> State { core::array::from_fn(|i| x[i] + h * k[i]) };
        let k1 = self.change(x, &d).rate;
        let k2 = self.change(&ahead(&k1, 0.5 * step_s), &d).rate;
        let k3 = self.change(&ahead(&k2, 0.5 * step_s), &d).rate;
        let k4 = self.change(&ahead(&k3, step_s), &d).rate;
        core::array::from_fn(|i| x[i] + step_s / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]))
    }
}
