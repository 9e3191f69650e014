//! A list of sensors with faults laid over them.

use serde::{Deserialize, Serialize};
use twinhub_types::{Instant, Measurement};

use super::{Fault, FaultInjector, Sensor, SensorKind, SensorModel, SensorParameters, SensorTruth};
use crate::admissible::OutOfRange;

/// The sensors of a bicycle, and what is wrong with them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SuiteParameters {
    /// The sensors, each kind at most once; a kind that is not listed is not on the bicycle.
    pub sensor: Vec<SensorParameters>,
    /// The faults.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub fault: Vec<Fault>,
}

/// Why a suite cannot be built.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SuiteError {
    /// A parameter of a sensor is out of range.
    #[error("sensor {name}: {error}")]
    Sensor {
        /// The sensor.
        name: &'static str,
        /// What is wrong.
        error: OutOfRange,
    },
    /// A parameter of a fault is out of range.
    #[error("fault {number}: {error}")]
    Fault {
        /// Which of the list, counted from 1.
        number: usize,
        /// What is wrong.
        error: OutOfRange,
    },
    /// Two sensors would write to the same place.
    #[error("sensor {name} is listed {found} times; accepted is once")]
    Twice {
        /// The sensor.
        name: &'static str,
        /// How often.
        found: usize,
    },
}

/// Sensors in use.
#[derive(Clone, Debug)]
pub struct SensorSuite {
    sensors: Vec<Sensor>,
    faults: FaultInjector,
    healthy: Measurement,
}

impl SensorSuite {
    /// The suite with the random streams of `seed`.
    pub fn new(parameters: &SuiteParameters, seed: u64) -> Result<Self, SuiteError> {
        for sensor in &parameters.sensor {
            let name = sensor.name();
            sensor
                .validate()
                .map_err(|error| SuiteError::Sensor { name, error })?;
            let found = parameters
                .sensor
                .iter()
                .filter(|s| s.name() == name)
                .count();
            if found > 1 {
                return Err(SuiteError::Twice { name, found });
            }
        }
        for (i, fault) in parameters.fault.iter().enumerate() {
            fault.validate().map_err(|error| SuiteError::Fault {
                number: i + 1,
                error,
            })?;
        }
        Ok(Self {
            sensors: parameters.sensor.iter().map(|s| s.build(seed)).collect(),
            faults: FaultInjector::new(&parameters.fault, seed),
            healthy: Measurement::default(),
        })
    }

    /// One tick: what the controller is told at `now`. Call it every tick, in order.
    pub fn sample(&mut self, now: Instant, truth: &SensorTruth) -> Measurement {
        for sensor in &mut self.sensors {
            sensor.sample(now, truth, &mut self.healthy);
        }
        let mut told = self.healthy;
        self.faults.apply(now, &mut told);
        told
    }

    /// What the controller would have been told in the last tick without faults.
    pub fn healthy(&self) -> &Measurement {
        &self.healthy
    }

    /// The sensors.
    pub fn sensors(&self) -> &[Sensor] {
        &self.sensors
    }
}
