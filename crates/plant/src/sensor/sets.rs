//! Named suites.
//!
//! `as_bought`: gyro 0.007 °/s/√Hz, accelerometer 160 µg/√Hz and offsets of 0.5 °/s and 20 mg are
//! the typical figures of Bosch's BMI270 data sheet (BST-BMI270-DS000, 2020-2023), a consumer part
//! of the price class; users of it report gyro offsets of up to 3 °/s before calibration.
//! Bias random walks, scale errors, misalignment, and all figures of encoder, hall sensors and
//! drives are estimates of the order of magnitude, not measured. `laboratory`: motion capture at
//! 200 Hz and a good encoder; estimates too. A suite's wheel radius is a placeholder until
//! [`SuiteParameters::with_rear_radius_m`] sets the bicycle's.

use super::{
    AngleError, CurrentError, ForceError, ImuParameters, MotorReportParameters, RateError,
    RollParameters, SensorParameters, SteerEncoderParameters, SteerRate, SuiteParameters,
    TemperatureError, Timing, TorqueError, VoltageError, WheelHallParameters,
};

/// Names of the suites of [`named`], each with one sentence.
pub const SUITES: &[(&str, &str)] = &[
    ("ideal", "every quantity exactly, every tick, at once"),
    (
        "laboratory",
        "roll from motion capture, good encoder and inertial unit",
    ),
    (
        "as_bought",
        "consumer inertial unit, encoder, motor halls and drive reports; no roll",
    ),
];

/// The suite called `name`.
pub fn named(name: &str) -> Option<SuiteParameters> {
    let sensor = match name {
        "ideal" => vec![
            SensorParameters::Imu(ImuParameters {
                misalignment_sd_rad: 0.0,
                timing: Timing::IDEAL,
                gyro: RateError::IDEAL,
                accel: ForceError::IDEAL,
            }),
            SensorParameters::Roll(RollParameters {
                timing: Timing::IDEAL,
                angle: AngleError::IDEAL,
                rate: RateError::IDEAL,
            }),
            SensorParameters::SteerEncoder(SteerEncoderParameters {
                timing: Timing::IDEAL,
                angle: AngleError::IDEAL,
                rate: SteerRate::Measured(RateError::IDEAL),
            }),
            SensorParameters::WheelHall(WheelHallParameters {
                edges_per_turn: 0,
                edge_placement_sd_rad: 0.0,
                radius_error_ratio: 0.0,
                timing: Timing::IDEAL,
                ..halls()
            }),
            SensorParameters::MotorReport(MotorReportParameters {
                timing: Timing::IDEAL,
                torque: TorqueError::IDEAL,
                voltage: VoltageError::IDEAL,
                current: CurrentError::IDEAL,
                temperature: TemperatureError::IDEAL,
            }),
        ],
        "laboratory" => vec![
            SensorParameters::Imu(good_imu()),
            SensorParameters::Roll(motion_capture()),
            SensorParameters::SteerEncoder(good_encoder()),
            SensorParameters::WheelHall(halls()),
            SensorParameters::MotorReport(drive_report()),
        ],
        "as_bought" => vec![
            SensorParameters::Imu(consumer_imu()),
            SensorParameters::SteerEncoder(magnetic_encoder()),
            SensorParameters::WheelHall(halls()),
            SensorParameters::MotorReport(drive_report()),
        ],
        _ => return None,
    };
    Some(SuiteParameters {
        sensor,
        fault: Vec::new(),
    })
}

impl SuiteParameters {
    /// The suite on a bicycle whose rear wheel has the radius `radius_m`.
    pub fn with_rear_radius_m(mut self, radius_m: f64) -> Self {
        for sensor in &mut self.sensor {
            if let SensorParameters::WheelHall(halls) = sensor {
                halls.rear_radius_m = radius_m;
            }
        }
        self
    }
}

const DEGREE: f64 = core::f64::consts::PI / 180.0;

fn consumer_imu() -> ImuParameters {
    ImuParameters {
        misalignment_sd_rad: 1.0 * DEGREE,
        timing: Timing {
            rate_hz: 1000.0,
            delay_s: 0.002,
            dropout_ratio: 0.0,
        },
        gyro: RateError {
            noise_rad_s_per_sqrt_hz: 0.007 * DEGREE,
            bias_sd_rad_s: 0.5 * DEGREE,
            bias_walk_rad_s_per_sqrt_s: 0.002 * DEGREE,
            scale_sd_ratio: 0.01,
            quantum_rad_s: 500.0 * DEGREE / 32768.0,
            range_rad_s: 500.0 * DEGREE,
        },
        accel: ForceError {
            noise_m_s2_per_sqrt_hz: 160e-6 * 9.81,
            bias_sd_m_s2: 0.020 * 9.81,
            bias_walk_m_s2_per_sqrt_s: 1e-4,
            scale_sd_ratio: 0.005,
            quantum_m_s2: 8.0 * 9.81 / 32768.0,
            range_m_s2: 8.0 * 9.81,
        },
    }
}

fn good_imu() -> ImuParameters {
    let consumer = consumer_imu();
    ImuParameters {
        misalignment_sd_rad: 0.2 * DEGREE,
        timing: Timing {
            rate_hz: 1000.0,
            delay_s: 0.001,
            dropout_ratio: 0.0,
        },
        gyro: RateError {
            bias_sd_rad_s: 0.05 * DEGREE,
            bias_walk_rad_s_per_sqrt_s: 0.0005 * DEGREE,
            scale_sd_ratio: 0.002,
            ..consumer.gyro
        },
        accel: ForceError {
            bias_sd_m_s2: 0.005 * 9.81,
            scale_sd_ratio: 0.001,
            ..consumer.accel
        },
    }
}

fn motion_capture() -> RollParameters {
    RollParameters {
        timing: Timing {
            rate_hz: 200.0,
            delay_s: 0.005,
            dropout_ratio: 0.001,
        },
        angle: AngleError {
            noise_rad_per_sqrt_hz: 0.005 * DEGREE,
            bias_sd_rad: 0.2 * DEGREE,
            bias_walk_rad_per_sqrt_s: 0.0,
            scale_sd_ratio: 0.0,
            quantum_rad: 0.0,
            range_rad: 1.5,
        },
        rate: RateError {
            noise_rad_s_per_sqrt_hz: 0.05 * DEGREE,
            bias_sd_rad_s: 0.0,
            bias_walk_rad_s_per_sqrt_s: 0.0,
            scale_sd_ratio: 0.0,
            quantum_rad_s: 0.0,
            range_rad_s: 20.0,
        },
    }
}

fn magnetic_encoder() -> SteerEncoderParameters {
    SteerEncoderParameters {
        timing: Timing {
            rate_hz: 500.0,
            delay_s: 0.002,
            dropout_ratio: 0.0005,
        },
        angle: AngleError {
            noise_rad_per_sqrt_hz: 0.002 * DEGREE,
            bias_sd_rad: 0.5 * DEGREE,
            bias_walk_rad_per_sqrt_s: 0.0,
            scale_sd_ratio: 0.002,
            quantum_rad: 360.0 * DEGREE / 4096.0,
            range_rad: 1.5,
        },
        rate: SteerRate::Absent {},
    }
}

fn good_encoder() -> SteerEncoderParameters {
    SteerEncoderParameters {
        timing: Timing {
            rate_hz: 1000.0,
            delay_s: 0.001,
            dropout_ratio: 0.0,
        },
        angle: AngleError {
            noise_rad_per_sqrt_hz: 0.0005 * DEGREE,
            bias_sd_rad: 0.1 * DEGREE,
            bias_walk_rad_per_sqrt_s: 0.0,
            scale_sd_ratio: 0.0,
            quantum_rad: 360.0 * DEGREE / 65536.0,
            range_rad: 1.5,
        },
        rate: SteerRate::Difference { lag_s: 0.005 },
    }
}

fn halls() -> WheelHallParameters {
    WheelHallParameters {
        edges_per_turn: 138,
        edge_placement_sd_rad: 0.1 * DEGREE,
        edges_averaged: 6,
        timer_s: 1e-6,
        standstill_s: 0.3,
        rear_radius_m: 0.35,
        radius_error_ratio: 0.01,
        timing: Timing {
            rate_hz: 200.0,
            delay_s: 0.003,
            dropout_ratio: 0.0005,
        },
    }
}

fn drive_report() -> MotorReportParameters {
    MotorReportParameters {
        timing: Timing {
            rate_hz: 200.0,
            delay_s: 0.003,
            dropout_ratio: 0.0005,
        },
        torque: TorqueError {
            noise_nm_per_sqrt_hz: 0.03,
            bias_sd_nm: 0.2,
            bias_walk_nm_per_sqrt_s: 0.0,
            scale_sd_ratio: 0.03,
            quantum_nm: 0.1,
            range_nm: 150.0,
        },
        voltage: VoltageError {
            noise_v_per_sqrt_hz: 0.01,
            bias_sd_v: 0.2,
            bias_walk_v_per_sqrt_s: 0.0,
            scale_sd_ratio: 0.01,
            quantum_v: 0.1,
            range_v: 80.0,
        },
        current: CurrentError {
            noise_a_per_sqrt_hz: 0.02,
            bias_sd_a: 0.1,
            bias_walk_a_per_sqrt_s: 0.0,
            scale_sd_ratio: 0.02,
            quantum_a: 0.1,
            range_a: 60.0,
        },
        temperature: TemperatureError {
            noise_k_per_sqrt_hz: 0.02,
            bias_sd_k: 2.0,
            bias_walk_k_per_sqrt_s: 0.0,
            scale_sd_ratio: 0.0,
            quantum_k: 1.0,
            range_k: 250.0,
        },
    }
}
