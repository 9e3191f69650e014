//! The run: step by step, rows as they come.

use super::columns::{Columns, Now};
use super::drive::Drive;
use super::steering::{Felt, Turn};
use super::summary::{EnergyBalance, Summary, Tally};
use super::{HoldRoll, Scenario};
use crate::error::{RideError, SetupError};
use crate::{TICK, TICK_S};
use twinhub_plant::PlantModel;
use twinhub_plant::disturbance::{Disturbances, Wrench};
use twinhub_plant::motor::{self, PowerOutput, PowerTrain};
use twinhub_plant::multibody::{Course, Input, Interaction, Ride, Steady};
use twinhub_plant::sensor::{self, SensorSuite, SensorTruth};
use twinhub_types::{Command, Instant, Measurement};

/// A row that is written down: values in the order of the columns' names.
pub type Row = [f64];

/// Runs a scenario. `watch` is told at each row how far it is, 0 to 1, and returns false to stop;
/// `keep` gets the columns' names and each row.
///
/// # Errors
/// If the scenario cannot be set up, or the model gives a number that is none.
pub fn run(
    scenario: &Scenario,
    watch: &mut dyn FnMut(f64) -> bool,
    keep: &mut dyn FnMut(&Columns, &Row),
) -> Result<Summary, RideError> {
    let mut bench = Bench::new(scenario)?;
    let columns = Columns::new(scenario, bench.ride.pedals());
    let (steps, every) = (scenario.steps(), scenario.steps_per_row());
    let mut tally = Tally::new(scenario, &bench.ride);
    let mut values = Vec::with_capacity(columns.names().len());
    let mut last = steps;
    let mut step = 0;
    loop {
        let t_s = step as f64 * scenario.step_s;
        let (input, pedal_force_n) = bench.input(t_s);
        let acting = bench.ride.with_pedals(&input, pedal_force_n);
        let truth = bench.ride.truth();
        if !bench.ride.state().iter().all(|v| v.is_finite()) {
            return Err(RideError::NotFinite { tick: step });
        }
        if tally.look(t_s, &truth, bench.ride.fall_roll_rad()) {
            let after = libm::round(scenario.after_fall_s / scenario.step_s) as u64;
            last = last.min(step + after);
        }
        let measured = bench.measure(step, &truth);
        if step % every == 0 || step >= last {
            let now = Now {
                t_s,
                ride: &bench.ride,
                input: &acting,
                pedal_force_n,
                truth: &truth,
                interaction: &bench.interaction,
                disturbance: &bench.acting,
                power: &bench.power_out,
                measured,
            };
            values.clear();
            columns.fill(&now, &mut values);
            tally.row(&now);
            keep(&columns, &values);
            if !watch(step as f64 / steps as f64) {
                last = step;
            }
        }
        if step >= last {
            break;
        }
        tally.before(&bench.ride, &acting);
        bench.ride.pedal(&input, pedal_force_n, scenario.step_s);
        tally.after(&bench.ride, &acting, scenario.step_s);
        step += 1;
    }
    Ok(tally.finish(&bench.ride, step as f64 * scenario.step_s))
}

/// Everything that acts.
struct Bench<'a> {
    scenario: &'a Scenario,
    ride: Ride,
    interaction: Interaction,
    /// Rear torque that holds the speed of the start, Nm.
    steady_nm: f64,
    corners: Vec<(HoldRoll, Turn)>,
    disturbances: Disturbances,
    acting: Wrench,
    power: Option<PowerTrain>,
    power_out: PowerOutput,
    sensors: Option<SensorSuite>,
}

impl<'a> Bench<'a> {
    fn new(scenario: &'a Scenario) -> Result<Self, SetupError> {
        let parameters = scenario.bicycle()?;
        let start = &scenario.start;
        let mut ride = Ride::new(&parameters, scenario.road.clone(), start.speed_m_s)?;
        let steady_nm = ride.input().rear_traction_nm;
        let turn = |roll_rad: f64| -> Result<Steady, SetupError> {
            let course = Course {
                roll_rad,
                ..Course::straight(start.speed_m_s)
            };
            Ok(ride.model().steady(&course, None)?)
        };
        let corners = scenario
            .hold_roll
            .iter()
            .map(|hold| {
                let steady = turn(hold.roll_rad)?;
                let turn = Turn {
                    steer_rad: steady.steer_rad(),
                    steer_torque_nm: steady.input.steer_torque_nm,
                };
                Ok((*hold, turn))
            })
            .collect::<Result<Vec<_>, SetupError>>()?;
        let from = (start.turn_roll_rad != 0.0)
            .then(|| turn(start.turn_roll_rad))
            .transpose()?;
        if let Some(steady) = from {
            ride.start_from(&steady);
        }
        ride.disturb(&twinhub_plant::multibody::Disturbed {
            roll_rad: start.roll_rad,
            roll_rate_rad_s: start.roll_rate_rad_s,
            steer_rad: start.steer_rad,
            steer_rate_rad_s: start.steer_rate_rad_s,
            trunk_rad: start.trunk_rad,
            legs_rad: start.legs_rad,
        });
        let power = scenario
            .motors
            .as_deref()
            .and_then(motor::sets::named)
            .map(|set| PowerTrain::new(&set))
            .transpose()
            .map_err(|e| SetupError::Format {
                origin: "scenario: motors".to_owned(),
                detail: e.to_string(),
            })?;
        let sensors = scenario
            .sensors
            .as_deref()
            .and_then(sensor::sets::named)
            .map(|suite| {
                let suite = suite.with_rear_radius_m(parameters.rear_wheel.radius_m);
                SensorSuite::new(&suite, scenario.seed)
            })
            .transpose()
            .map_err(|e| SetupError::Format {
                origin: "scenario: sensors".to_owned(),
                detail: e.to_string(),
            })?;
        Ok(Self {
            scenario,
            interaction: Interaction::new(&parameters),
            ride,
            steady_nm,
            corners,
            disturbances: scenario.disturbances(&parameters)?,
            acting: Wrench::default(),
            power,
            power_out: PowerOutput::default(),
            sensors,
        })
    }

    /// What acts from `t_s` on, and the force of the pedals, N.
    fn input(&mut self, t_s: f64) -> (Input, f64) {
        let scenario = self.scenario;
        let parameters = self.ride.model().parameters();
        let radii_m = [
            parameters.rear_wheel.radius_m,
            parameters.front_wheel.radius_m,
        ];
        let mut input = Input::default();
        let mut pedal_force_n = 0.0;
        for one in &scenario.input {
            pedal_force_n += one.add(t_s, radii_m, &mut input);
        }
        let truth = self.ride.truth();
        if let Some(power) = &mut self.power {
            let silent = scenario.commands_end_s.is_some_and(|end| t_s >= end - 1e-9);
            let command = (!silent).then_some(Command {
                front_brake_nm: input.front_brake_nm as f32,
                rear_traction_nm: input.rear_traction_nm as f32,
                ..Command::default()
            });
            let now = Instant::from_nanos(libm::round(t_s / TICK_S) as u64 * TICK.as_nanos());
            self.power_out = power.step(
                now,
                command,
                truth.front_wheel_rate_rad_s,
                truth.rear_wheel_rate_rad_s,
                TICK,
            );
            input.front_brake_nm = self.power_out.front_brake_nm;
            input.rear_traction_nm = self.power_out.rear_traction_nm;
        }
        let drive: &Drive = &scenario.drive;
        let wanted = scenario.start.speed_m_s;
        input.rear_traction_nm +=
            drive.torque_nm(self.steady_nm, wanted, truth.speed_m_s, radii_m[0]);
        let felt = Felt {
            roll_rad: truth.roll_rad,
            roll_rate_rad_s: truth.roll_rate_rad_s,
            steer_rad: truth.steer_rad,
            steer_rate_rad_s: truth.steer_rate_rad_s,
        };
        for (hold, turn) in &self.corners {
            input.steer_torque_nm += hold.torque_nm(t_s, turn, &felt);
        }
        let side = self.disturbances.at(t_s);
        self.acting = side;
        input.steer_torque_nm += side.steer_torque_nm;
        input.force_n = [0.0, side.lateral_force_n, 0.0];
        input.force_at_m = [side.point_x_m, 0.0, -side.point_height_m];
        input.moment_nm = [side.roll_torque_nm, 0.0, side.yaw_torque_nm];
        input.rear_road_y_m_s = side.rear_road_y_m_s;
        if let Some(wind) = &scenario.wind {
            let [along, across] = wind.velocity_m_s(t_s);
            input.wind_m_s = [along, across, 0.0];
        }
        (input, pedal_force_n)
    }

    /// What the sensors say at a step.
    fn measure(&mut self, step: u64, truth: &twinhub_plant::Truth) -> Option<Measurement> {
        let power = &self.power_out;
        self.sensors.as_mut().map(|sensors| {
            let now = Instant::from_nanos(step * TICK.as_nanos());
            sensors.sample(now, &SensorTruth::new(truth, power))
        })
    }
}

impl EnergyBalance {
    /// Of the model now: motion, gravity and springs, J.
    pub(super) fn stored_j(ride: &Ride) -> f64 {
        ride.model().energy_on(ride.state(), ride.road()).total_j()
    }
}
