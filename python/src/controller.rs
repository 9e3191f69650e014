//! The controller, tick by tick.

use crate::errors;
use pyo3::prelude::*;
use twinhub_control::belief::{Believer, Known, NEVER_S};
use twinhub_control::law::{Demand, Mechanism as _};
use twinhub_control::{Config, Controller, Law};
use twinhub_sim::Ride;
use twinhub_sim::setup::load_law;
use twinhub_types::{
    Estimate, Health, ImuSample, Instant, LimitedBy, Measurement, Mode, MotorSample, Output,
    RiderIntent, RollSample, SteerSample, WheelSample,
};

/// Stamp, gyro, accelerometer.
type Imu = (u64, [f32; 3], [f32; 3]);
/// Stamp, angle, rate.
type Angle = (u64, f32, f32);
/// Stamp, front and rear wheel, speed.
type Wheels = (u64, f32, f32, f32);
/// Stamp, front brake, rear traction, bus voltage and current, winding.
type Motors = (u64, f32, f32, f32, f32, f32);
/// Stamp, assist on, pedalling, front and rear brake, pedal torque, cadence.
type Intent = (u64, bool, bool, f32, f32, f32, f32);
/// Torques and demand, mode, health, limits, estimate.
type Answer = (
    f32,
    f32,
    f32,
    &'static str,
    Vec<&'static str>,
    Vec<&'static str>,
    [f32; 8],
);

/// What the firmware runs.
#[pyclass(name = "_Controller", module = "twinhub._twinhub")]
pub struct PyController {
    config: Config,
    controller: Controller,
    believer: Believer,
}

#[pymethods]
impl PyController {
    /// `law`: a name that ships, or a file.
    #[new]
    fn new(law: &str, assignments: Vec<String>) -> PyResult<Self> {
        let config = load_law(law, &assignments).map_err(errors::setup)?;
        Ok(Self::of(config))
    }

    /// The controller of a ride, from the configuration in its log.
    #[staticmethod]
    fn of_ride(config: &str) -> PyResult<Self> {
        let ride: Ride = toml::from_str(config).map_err(|e| {
            errors::input(format!(
                "the ride's configuration: {}",
                e.to_string().trim_end()
            ))
        })?;
        Ok(Self::of(ride.law))
    }

    /// At rest again.
    fn reset(&mut self) {
        *self = Self::of(self.config);
    }

    /// The law file, TOML.
    fn to_toml(&self) -> PyResult<String> {
        toml::to_string(&self.config).map_err(errors::input)
    }

    /// The pair that the law settles at, Nm: least and most.
    fn settled_nm(&self, speed_m_s: f32) -> [f32; 2] {
        self.config.law.settled_nm(speed_m_s)
    }

    #[allow(clippy::too_many_arguments)] // the messages of the link, one each
    fn step(
        &mut self,
        t_ns: u64,
        imu: Imu,
        roll: Angle,
        steer: Angle,
        wheels: Wheels,
        motors: Motors,
        intent: Intent,
    ) -> Answer {
        let measurement = Measurement {
            imu: ImuSample {
                stamp_ns: imu.0,
                gyro_rad_s: imu.1,
                accel_m_s2: imu.2,
            },
            roll: RollSample {
                stamp_ns: roll.0,
                roll_rad: roll.1,
                roll_rate_rad_s: roll.2,
            },
            steer: SteerSample {
                stamp_ns: steer.0,
                steer_rad: steer.1,
                steer_rate_rad_s: steer.2,
            },
            wheels: WheelSample {
                stamp_ns: wheels.0,
                front_rad_s: wheels.1,
                rear_rad_s: wheels.2,
                speed_m_s: wheels.3,
                reserved: 0,
            },
            motors: MotorSample {
                stamp_ns: motors.0,
                front_brake_nm: motors.1,
                rear_traction_nm: motors.2,
                bus_v: motors.3,
                bus_a: motors.4,
                winding_celsius: motors.5,
                reserved: 0,
            },
        };
        let intent = RiderIntent {
            stamp_ns: intent.0,
            assist_on: u32::from(intent.1),
            pedalling: u32::from(intent.2),
            front_brake_ratio: intent.3,
            rear_brake_ratio: intent.4,
            pedal_nm: intent.5,
            cadence_rad_s: intent.6,
        };
        let now = Instant::from_nanos(t_ns);
        let output = self.controller.step(now, &measurement, &intent);
        self.believer
            .update(now, &measurement, &intent, &output.estimate);
        answer(&output)
    }

    /// What is believed after the last step: name, value, standard deviation, age.
    fn belief(&self) -> Vec<(&'static str, f32, f32, f32)> {
        let b = self.believer.belief();
        let named: [(&'static str, Option<Known>); 12] = [
            ("roll_rad", Some(b.roll_rad)),
            ("roll_rate_rad_s", Some(b.roll_rate_rad_s)),
            ("steer_rad", Some(b.steer_rad)),
            ("steer_rate_rad_s", Some(b.steer_rate_rad_s)),
            ("yaw_rate_rad_s", Some(b.yaw_rate_rad_s)),
            ("speed_m_s", Some(b.speed_m_s)),
            ("road_lean_rad", Some(b.road_lean_rad)),
            ("front_load_n", Some(b.front_load_n)),
            ("rear_load_n", Some(b.rear_load_n)),
            ("front_slip_ratio", Some(b.front_slip_ratio)),
            ("rear_slip_ratio", Some(b.rear_slip_ratio)),
            ("friction_ratio", b.friction_ratio),
        ];
        let known = |(name, known): (&'static str, Option<Known>)| {
            let k = known?;
            let age_s = if k.age_s < NEVER_S {
                k.age_s
            } else {
                f32::INFINITY
            };
            Some((name, k.value, k.sd, age_s))
        };
        named.into_iter().filter_map(known).collect()
    }
}

impl PyController {
    fn of(config: Config) -> Self {
        Self {
            controller: Controller::new(&config),
            believer: Believer::new(&config.bicycle),
            config,
        }
    }
}

fn answer(output: &Output) -> Answer {
    (
        output.command.front_brake_nm,
        output.command.rear_traction_nm,
        output.demand_nm,
        Mode::from_u32(output.mode).name(),
        health(output.health),
        limits(output.limited_by),
        numbers(&output.estimate),
    )
}

/// Codes of the health flags that are raised.
pub fn health(bits: u32) -> Vec<&'static str> {
    let raised = Health::from_bits(bits);
    let entries = Health::TABLE.iter().filter(|e| raised.any(e.flag));
    entries.map(|e| e.code).collect()
}

/// Codes of what held the command back.
pub fn limits(bits: u32) -> Vec<&'static str> {
    let held = LimitedBy::from_bits(bits);
    let entries = LimitedBy::TABLE.iter().filter(|e| held.any(e.limit));
    entries.map(|e| e.code).collect()
}

/// An estimate as Python has it.
pub fn numbers(x: &Estimate) -> [f32; 8] {
    [
        x.roll_rad,
        x.roll_rate_rad_s,
        x.steer_rad,
        x.steer_rate_rad_s,
        x.speed_m_s,
        x.yaw_rate_rad_s,
        x.roll_sd_rad,
        x.speed_sd_m_s,
    ]
}

/// Names of the laws in the registry.
#[pyfunction]
pub fn law_kinds() -> Vec<&'static str> {
    Law::NAMES.to_vec()
}

/// Names of the law files that ship.
#[pyfunction]
pub fn laws() -> Vec<&'static str> {
    twinhub_sim::shipped::names(twinhub_sim::shipped::LAWS)
}

/// A law written in Python: estimate and time in, pair (and trim) out. What it raises is kept.
pub struct PythonLaw<'a> {
    pub callable: &'a Py<PyAny>,
    pub raised: &'a std::sync::Mutex<Option<PyErr>>,
}

impl PythonLaw<'_> {
    /// What it asks for; no torque once it has raised.
    pub fn demand(&self, x: &Estimate, dt_s: f32) -> Demand {
        let asked = Python::attach(|py| -> PyResult<(f32, f32)> {
            let found = self.callable.bind(py).call1((numbers(x), dt_s))?;
            let pair = found.extract::<(f32, f32)>();
            let asked = pair.or_else(|_| found.extract::<f32>().map(|pair_nm| (pair_nm, 0.0)));
            match asked {
                Ok((pair_nm, trim_nm)) if pair_nm.is_finite() && trim_nm.is_finite() => {
                    Ok((pair_nm, trim_nm))
                }
                _ => Err(errors::input(format!(
                    "a law gave {found}; accepted: pair_nm, or (pair_nm, trim_nm), as finite floats"
                ))),
            }
        });
        match asked {
            Ok((pair_nm, trim_nm)) => Demand {
                pair_nm,
                trim_nm,
                ..Demand::default()
            },
            Err(error) => {
                errors::keep(self.raised, error);
                Demand::default()
            }
        }
    }
}
