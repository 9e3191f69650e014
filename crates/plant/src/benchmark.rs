//! The benchmark bicycle as a plant: linear, no tyre slip, with speed as a state.
//!
//! Equation: M q'' + v C1 q' + K(v, F, a) q = f with q = (roll, steer), Meijaard, Papadopoulos,
//! Ruina and Schwab (2007), equation 5.3; K holds the exact no-slip terms of the motor torques
//! (`twinhub_linear`). Yaw rate (v δ + c δ') cos λ / w (their equation B7). Speed:
//! (m_T + I_Ryy / r_R² + I_Fyy / r_F²) v' = sum of the longitudinal forces.
//!
//! Assumes and ignores: small roll and steer, rigid rider (torques on trunk and legs do nothing), no
//! tyre slip, flat road that does not move, still air. Rolling
//! resistance is a constant force, air drag ½ ρ C_d A v². Both wheels' loads are the static ones
//! with the load transfer of the acceleration. Causes that the bicycle's file names
//! (`twinhub_mechanism`) push as they do in a diagnosis.
//!
//! Valid for: roll below about 0.5 rad; beyond `fall_roll_rad` the ride ends.
//!
//! Checked by: the eigenvalue test below (growth of the free bicycle against `twinhub_linear`).

use crate::integrate::rk4;
use crate::truth::{PlantInput, PlantModel, Truth};
use nalgebra::Vector2;
use serde::{Deserialize, Serialize};
use twinhub_linear::{Bicycle, BicycleError, Canonical, MotorPair};
use twinhub_mechanism::{Body, Inputs, Mechanism, Moment, Wrench};
use twinhub_types::conventions::GRAVITY_M_S2;

/// Resistance to rolling and to air.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Resistance {
    /// Rolling resistance per weight.
    pub rolling_ratio: f64,
    /// Drag area C_d A, m².
    pub drag_area_m2: f64,
    /// Air density, kg/m³.
    pub air_density_kg_m3: f64,
}

/// The benchmark bicycle in motion.
#[derive(Clone, Debug)]
pub struct Benchmark {
    bicycle: Bicycle,
    canonical: Canonical,
    total_mass_kg: f64,
    effective_mass_kg: f64,
    /// Centre of mass of the whole, forward of the rear contact and above the road, m.
    centre_m: [f64; 2],
    resistance: Resistance,
    /// Roll, steer, their rates, yaw, x, y, speed.
    state: [f64; 8],
    input: PlantInput,
    /// Time derivatives at the end of the last step, for the accelerometer.
    rate: [f64; 8],
    /// What pushes besides; none for a bicycle that no diagnosis has extended.
    causes: Option<Causes>,
}

/// Named causes with their memories.
#[derive(Clone, Debug)]
struct Causes {
    body: Body,
    list: Vec<(&'static dyn Mechanism, Vec<f64>)>,
    memory: Vec<Vec<f64>>,
    t_s: f64,
    travel_m: f64,
    step_s: f64,
    fresh: bool,
}

impl Causes {
    fn new(bicycle: &Bicycle) -> Result<Option<Self>, BicycleError> {
        let list =
            twinhub_mechanism::extended::pushing(bicycle).map_err(|e| BicycleError::Toml {
                path: bicycle.name.clone().into(),
                message: e.to_string(),
            })?;
        if list.is_empty() {
            return Ok(None);
        }
        Ok(Some(Self {
            body: Body::new(bicycle)?,
            memory: list.iter().map(|(m, _)| vec![0.0; m.memory()]).collect(),
            list,
            t_s: 0.0,
            travel_m: 0.0,
            step_s: 1e-3,
            fresh: true,
        }))
    }

    fn moment(
        &self,
        x: &[f64; 8],
        accel: Vector2<f64>,
        forward: f64,
        input: &PlantInput,
    ) -> Moment<'_> {
        Moment {
            body: &self.body,
            t_s: self.t_s,
            dt_s: self.step_s,
            speed_m_s: x[7],
            accel_m_s2: forward,
            travel_m: self.travel_m,
            angle_rad: [x[0], x[1]],
            rate_rad_s: [x[2], x[3]],
            accel_rad_s2: [accel.x, accel.y],
            inputs: Inputs {
                roll_torque_nm: input.roll_torque_nm,
                steer_torque_nm: input.steer_torque_nm,
                front_brake_nm: input.front_brake_nm,
                rear_traction_nm: input.rear_traction_nm,
                ..Inputs::default()
            },
            crank_rad: None,
            wheel_rad: None,
            trunk_lean_rad: None,
            way: 1.0,
        }
    }

    fn wrench(&self, at: &Moment<'_>) -> Wrench {
        let mut sum = Wrench::default();
        for ((mechanism, p), memory) in self.list.iter().zip(&self.memory) {
            sum += mechanism.wrench(p, at, memory);
        }
        sum
    }

    /// Moves the memories over a step that begins at `at`.
    fn remember(&mut self, x: &[f64; 8], accel: Vector2<f64>, forward: f64, input: &PlantInput) {
        let mut memory = std::mem::take(&mut self.memory);
        let at = self.moment(x, accel, forward, input);
        for ((mechanism, p), memory) in self.list.iter().zip(&mut memory) {
            if self.fresh {
                mechanism.remember(p, &at, memory, true);
            }
            mechanism.remember(p, &at, memory, false);
        }
        self.memory = memory;
        self.fresh = false;
        self.t_s += self.step_s;
        self.travel_m += x[7] * self.step_s;
    }
}

/// Half of a right angle: the linear equations say nothing beyond it.
const FALL_ROLL_RAD: f64 = 0.8;

impl Benchmark {
    /// Upright and straight at `speed_m_s`.
    ///
    /// # Errors
    /// If the bicycle's values cannot be, or its mass matrix has no inverse.
    pub fn new(
        bicycle: &Bicycle,
        resistance: Resistance,
        speed_m_s: f64,
    ) -> Result<Self, BicycleError> {
        let canonical = Canonical::new(bicycle)?;
        let p = &bicycle.parameters;
        let total_mass_kg = p.mR + p.mB + p.mH + p.mF;
        let first_moment = [
            p.mB * p.xB + p.mH * p.xH + p.mF * p.w,
            p.mR * p.rR - p.mB * p.zB - p.mH * p.zH + p.mF * p.rF,
        ];
        let spin = |inertia: f64, radius: f64| {
            if radius > 0.0 {
                inertia / (radius * radius)
            } else {
                0.0
            }
        };
        let mut plant = Self {
            bicycle: bicycle.clone(),
            canonical,
            total_mass_kg,
            effective_mass_kg: total_mass_kg + spin(p.IRyy, p.rR) + spin(p.IFyy, p.rF),
            centre_m: first_moment.map(|m| m / total_mass_kg),
            resistance,
            state: [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, speed_m_s],
            input: PlantInput::default(),
            rate: [0.0; 8],
            causes: Causes::new(bicycle)?,
        };
        plant.rate = plant.derivative(&plant.state);
        Ok(plant)
    }

    /// Sets roll and steer, rad, and their rates, rad/s.
    pub fn set_lateral(&mut self, roll_steer_and_rates: [f64; 4]) {
        self.state[..4].copy_from_slice(&roll_steer_and_rates);
        self.rate = self.derivative(&self.state);
    }

    fn acceleration_m_s2(&self, speed_m_s: f64) -> f64 {
        let p = &self.bicycle.parameters;
        let r = &self.resistance;
        let rolling = if speed_m_s > 0.0 {
            r.rolling_ratio * self.total_mass_kg * GRAVITY_M_S2
        } else {
            0.0
        };
        let air = 0.5 * r.air_density_kg_m3 * r.drag_area_m2 * speed_m_s * speed_m_s;
        let drive = per_radius(self.input.rear_traction_nm, p.rR) + self.input.pedal_force_n;
        let brake = per_radius(self.input.front_brake_nm, p.rF);
        (drive - brake - rolling - air) / self.effective_mass_kg
    }

    fn derivative(&self, x: &[f64; 8]) -> [f64; 8] {
        let p = &self.bicycle.parameters;
        let (yaw, speed) = (x[4], x[7]);
        let acceleration = self.acceleration_m_s2(speed);
        // Only the front torque and the acceleration act on the lateral motion; this pair has both.
        let pair = MotorPair {
            front_brake_nm: self.input.front_brake_nm,
            rear_traction_nm: p.rR
                * (acceleration * self.effective_mass_kg
                    + per_radius(self.input.front_brake_nm, p.rF)),
        };
        let force_n = self.input.lateral_force_n;
        let yaw_per_steer = self.canonical.yaw_rate_rad_s(0.0, 0.0, 1.0);
        let torque = Vector2::new(
            self.input.roll_torque_nm + force_n * self.input.lateral_force_height_m,
            self.input.steer_torque_nm
                + (force_n * self.input.lateral_force_x_m + self.input.yaw_torque_nm)
                    * yaw_per_steer,
        );
        let (angle, rate) = (Vector2::new(x[0], x[1]), Vector2::new(x[2], x[3]));
        let mut accel = self
            .canonical
            .acceleration(speed, pair, angle, rate, torque);
        let mut acceleration = acceleration;
        let mut slip = 0.0;
        if let Some(causes) = &self.causes {
            let wrench = causes.wrench(&causes.moment(x, accel, acceleration, &self.input));
            acceleration += wrench.force_n / self.effective_mass_kg;
            slip = wrench.yaw_rate_rad_s;
            accel = self.canonical.acceleration(
                speed,
                pair,
                angle,
                rate,
                torque + Vector2::new(wrench.roll_nm, wrench.steer_nm),
            );
        }
        let (sin_yaw, cos_yaw) = libm::sincos(yaw);
        [
            x[2],
            x[3],
            accel.x,
            accel.y,
            self.canonical.yaw_rate_rad_s(speed, x[1], x[3]) + slip,
            speed * cos_yaw,
            speed * sin_yaw,
            acceleration,
        ]
    }
}

fn per_radius(torque_nm: f64, radius_m: f64) -> f64 {
    if radius_m > 0.0 {
        torque_nm / radius_m
    } else {
        0.0
    }
}

impl PlantModel for Benchmark {
    fn step(&mut self, input: &PlantInput, step_s: f64) {
        self.input = *input;
        let mut x = self.state;
        if let Some(mut causes) = self.causes.take() {
            causes.step_s = step_s;
            self.causes = None;
            let bare = self.derivative(&x);
            causes.remember(&x, Vector2::new(bare[2], bare[3]), bare[7], input);
            self.causes = Some(causes);
        }
        rk4(&mut x, step_s, |x, dx| *dx = self.derivative(x));
        x[7] = x[7].max(0.0);
        self.state = x;
        self.rate = self.derivative(&x);
    }

    fn truth(&self) -> Truth {
        let (x, dx, p) = (&self.state, &self.rate, &self.bicycle.parameters);
        let (speed, acceleration, yaw_rate) = (x[7], dx[7], dx[4]);
        let yaw_accel = self.canonical.yaw_rate_rad_s(speed, x[3], dx[3])
            + self.canonical.yaw_rate_rad_s(acceleration, x[1], 0.0);
        // At the centre of mass of the rear frame, z down: x_B forward, z_B negative.
        let lateral_accel = speed * yaw_rate + p.xB * yaw_accel - p.zB * dx[2];
        let (sin_roll, cos_roll) = libm::sincos(x[0]);
        let weight_n = self.total_mass_kg * p.g;
        let front_load_n = (weight_n * self.centre_m[0]
            - self.total_mass_kg * acceleration * self.centre_m[1])
            / p.w;
        Truth {
            roll_rad: x[0],
            steer_rad: x[1],
            yaw_rad: x[4],
            pitch_rad: 0.0,
            roll_rate_rad_s: x[2],
            steer_rate_rad_s: x[3],
            yaw_rate_rad_s: yaw_rate,
            x_m: x[5],
            y_m: x[6],
            speed_m_s: speed,
            front_wheel_rate_rad_s: per_radius(speed, p.rF),
            rear_wheel_rate_rad_s: per_radius(speed, p.rR),
            front_load_n,
            rear_load_n: weight_n - front_load_n,
            front_slip_ratio: 0.0,
            rear_slip_ratio: 0.0,
            trunk_lean_rad: 0.0,
            trunk_lean_rate_rad_s: 0.0,
            legs_rad: [0.0; 2],
            leg_rates_rad_s: [0.0; 2],
            body_rates_rad_s: [x[2], yaw_rate * sin_roll, yaw_rate * cos_roll],
            specific_force_m_s2: [
                acceleration,
                lateral_accel * cos_roll - p.g * sin_roll,
                -lateral_accel * sin_roll - p.g * cos_roll,
            ],
        }
    }

    fn fall_roll_rad(&self) -> f64 {
        FALL_ROLL_RAD
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FREE: Resistance = Resistance {
        rolling_ratio: 0.0,
        drag_area_m2: 0.0,
        air_density_kg_m3: 1.2,
    };

    fn benchmark(speed_m_s: f64) -> Benchmark {
        let bicycle = Bicycle::load("meijaard2007_benchmark").expect("built in");
        Benchmark::new(&bicycle, FREE, speed_m_s).expect("valid")
    }

    #[test]
    fn standing_still_hands_off_and_leaning_right_it_falls_right() {
        let mut plant = benchmark(0.0);
        plant.set_lateral([0.01, 0.0, 0.0, 0.0]);
        for _ in 0..1000 {
            plant.step(&PlantInput::default(), 0.001);
        }
        assert!(
            plant.truth().roll_rad > 0.02,
            "roll {}",
            plant.truth().roll_rad
        );
    }

    #[test]
    fn the_free_bicycle_follows_the_matrix_exponential_of_its_state_matrix() {
        let bicycle = Bicycle::load("meijaard2007_benchmark").expect("built in");
        let a = Canonical::new(&bicycle)
            .expect("valid")
            .state_matrix(5.0, MotorPair::OFF);
        let start = nalgebra::Vector4::new(0.01, -0.02, 0.03, 0.04);
        let expected = (a * 2.0).exp() * start;
        let mut plant = benchmark(5.0);
        plant.set_lateral([0.01, -0.02, 0.03, 0.04]);
        for _ in 0..2000 {
            plant.step(&PlantInput::default(), 0.001);
        }
        let t = plant.truth();
        let got = nalgebra::Vector4::new(
            t.roll_rad,
            t.steer_rad,
            t.roll_rate_rad_s,
            t.steer_rate_rad_s,
        );
        assert!(
            (got - expected).norm() < 1e-9 * start.norm(),
            "{got} against {expected}"
        );
    }

    #[test]
    fn a_balanced_pair_keeps_the_speed_and_a_brake_alone_does_not() {
        let (mut pair, mut brake) = (benchmark(5.0), benchmark(5.0));
        // Radii 0.35 and 0.30 m.
        let balanced = PlantInput {
            front_brake_nm: 35.0,
            rear_traction_nm: 30.0,
            ..PlantInput::default()
        };
        let alone = PlantInput {
            front_brake_nm: 35.0,
            ..PlantInput::default()
        };
        for _ in 0..1000 {
            pair.step(&balanced, 0.001);
            brake.step(&alone, 0.001);
        }
        assert!((pair.truth().speed_m_s - 5.0).abs() < 1e-12);
        // 100 N on 94 kg and the wheels' spin (0.28/0.35² + 0.12/0.3² = 3.62 kg).
        assert!(
            (brake.truth().speed_m_s - (5.0 - 100.0 / 97.619)).abs() < 1e-5,
            "{}",
            brake.truth().speed_m_s
        );
        assert!(brake.truth().front_load_n > pair.truth().front_load_n);
    }

    /// Friction that a bicycle's file names holds its steering still.
    #[test]
    fn named_causes_act() {
        let base = Bicycle::load("meijaard2007_benchmark").expect("built in");
        let friction = twinhub_mechanism::Accepted {
            mechanism: twinhub_mechanism::find("steer_coulomb_friction").expect("in the list"),
            confirmed: true,
            p: vec![5.0],
            sd: vec![],
        };
        let extended = twinhub_mechanism::extended::extended(&base, "rubs", "a test", &[friction])
            .expect("valid");
        let mut plant = Benchmark::new(&extended, FREE, 5.0).expect("valid");
        let pull = PlantInput {
            steer_torque_nm: 3.0,
            ..PlantInput::default()
        };
        for _ in 0..100 {
            plant.step(&pull, 0.001);
        }
        assert!(
            plant.truth().steer_rad.abs() < 1e-3,
            "{}",
            plant.truth().steer_rad
        );
        let mut bare = Benchmark::new(&base, FREE, 5.0).expect("valid");
        for _ in 0..100 {
            bare.step(&pull, 0.001);
        }
        assert!(bare.truth().steer_rad > 0.02);
    }

    #[test]
    fn an_accelerometer_at_rest_reads_gravity_upwards() {
        let [x, y, z] = benchmark(0.0).truth().specific_force_m_s2;
        assert_eq!((x, y), (0.0, 0.0));
        assert!((z + 9.81).abs() < 1e-12);
    }
}
