//! Everything on the plant's side of the link, a tick at a time.

use crate::course::Course;
use crate::error::SetupError;
use crate::record::{RiderRow, TruthRow, truth_row};
use crate::setup::Ride;
use crate::{TICK, TICK_S};
use twinhub_control::law::{Device, Mechanism as _};
use twinhub_plant::disturbance::{Disturbances, Wrench};
use twinhub_plant::motor::{PowerOutput, PowerTrain};
use twinhub_plant::rider::{Action, Perception, Rider};
use twinhub_plant::sensor::{SensorSuite, SensorTruth};
use twinhub_plant::steering::{Steering, SteeringOutput, SteeringParameters, SteeringSenses};
use twinhub_plant::{PlantInput, PlantModel, Truth};
use twinhub_types::messages::PROTOCOL_HASH;
use twinhub_types::{
    ControllerFrame, Header, Instant, Measurement, NEVER_NS, PlantFrame, RideState, RiderIntent,
};

/// What rider and disturbances do in a tick.
pub(crate) struct Acts {
    wanted_speed_m_s: f64,
    rider: Action,
    side: Wrench,
}

/// Everything on the plant's side of the link.
pub(crate) struct Bench<'a> {
    course: Course,
    pub(crate) plant: Box<dyn PlantModel + Send>,
    rider: Who<'a>,
    sensors: SensorSuite,
    disturbances: Disturbances,
    power: PowerTrain,
    power_out: PowerOutput,
    /// The rider's switch.
    pub(crate) assist_on: bool,
    /// A comparator's device on the handlebar, and the roll rate and speed that it is told.
    steering: Option<Steering>,
    told: [f64; 2],
}

/// A rider of the caller's own: what is perceived in a tick, and the tick's length, s.
pub type OwnRider<'a> = &'a mut (dyn FnMut(&Perception, f64) -> Action + Send + 'a);

/// Who rides.
enum Who<'a> {
    /// The rider of the rider file.
    Modelled(Rider),
    /// A rider of the caller's own.
    Own(OwnRider<'a>),
}

impl Who<'_> {
    fn act(&mut self, perception: &Perception) -> Action {
        match self {
            Self::Modelled(rider) => rider.act(perception, TICK_S),
            Self::Own(rider) => rider(perception, TICK_S),
        }
    }
}

/// The device that a law brings along, as the plant has it.
pub fn device(law: &twinhub_control::Law) -> Option<SteeringParameters> {
    match law.device() {
        Device::None => None,
        Device::Spring { stiffness_nm_rad } => Some(SteeringParameters::Spring {
            stiffness_nm_rad: stiffness_nm_rad.into(),
        }),
        Device::Motor {
            gain_nms_rad_per_m_s,
            speed_m_s,
            torque_max_nm,
        } => Some(SteeringParameters::Motor {
            gain_nms_rad_per_m_s: gain_nms_rad_per_m_s.into(),
            speed_m_s: speed_m_s.into(),
            torque_max_nm: torque_max_nm.into(),
        }),
    }
}

/// Roll rate and speed as the sensors say, rad/s and m/s; 0 for what no sensor gives.
fn told(measurement: &Measurement) -> [f64; 2] {
    let roll_rate = if measurement.imu.stamp_ns != NEVER_NS {
        measurement.imu.gyro_rad_s[0]
    } else if measurement.roll.stamp_ns != NEVER_NS {
        measurement.roll.roll_rate_rad_s
    } else {
        0.0
    };
    let speed = measurement.wheels.speed_m_s;
    [roll_rate, speed].map(|x| if x.is_finite() { f64::from(x) } else { 0.0 })
}

impl<'a> Bench<'a> {
    /// Everything at the start of `ride`, under its own rider or the caller's.
    pub(crate) fn new(ride: &Ride, own: Option<OwnRider<'a>>) -> Result<Self, SetupError> {
        let bicycle = &ride.bicycle;
        let plant = ride
            .course
            .plant
            .build(bicycle, ride.course.speed_m_s(0.0))?;
        let modelled = || {
            let started = ride.rider.start(ride.course.seed, TICK_S);
            started.map_err(|source| SetupError::Rider {
                origin: ride.course.rider.clone(),
                source,
            })
        };
        let rider = match own {
            Some(own) => Who::Own(own),
            None => Who::Modelled(modelled()?),
        };
        Ok(Self {
            course: ride.course.clone(),
            plant,
            rider,
            sensors: ride.course.build_sensors(bicycle.shape().rear_radius_m)?,
            disturbances: ride.course.build_disturbances(bicycle)?,
            power: ride.course.build_motors()?,
            power_out: PowerOutput::default(),
            assist_on: ride.stabilizer_on,
            // A bicycle whose stabilizer is off in a comparison has none of its parts either.
            steering: device(&ride.law.law)
                .filter(|_| ride.stabilizer_on)
                .map(Steering::new),
            told: [0.0; 2],
        })
    }

    /// What the controller is told at `now`.
    pub(crate) fn frame(
        &mut self,
        now: Instant,
        tick: u64,
        state: RideState,
        truth: &Truth,
    ) -> PlantFrame {
        let measurement: Measurement = self
            .sensors
            .sample(now, &SensorTruth::new(truth, &self.power_out));
        self.told = told(&measurement);
        PlantFrame {
            header: Header {
                protocol_hash: PROTOCOL_HASH,
                sequence: tick,
                tick,
                time_ns: now.as_nanos(),
                state: state as u32,
                reserved: 0,
            },
            measurement,
            intent: RiderIntent {
                stamp_ns: now.as_nanos(),
                assist_on: u32::from(self.assist_on),
                // The pedals always turn; how hard is `pedal_nm`.
                pedalling: 1,
                ..RiderIntent::default()
            },
        }
    }

    /// True while neither drive drives its motor.
    pub(crate) fn torque_is_zero(&self) -> bool {
        self.power_out.front_reported_nm == 0.0 && self.power_out.rear_reported_nm == 0.0
    }

    /// What rider and disturbances do in this tick: nothing of it hangs on the controller's answer,
    /// so it is worked out while that is on its way.
    pub(crate) fn act(&mut self, now: Instant, truth: &Truth) -> Acts {
        let wanted_speed_m_s = self.course.speed_m_s(now.as_secs_f64());
        Acts {
            wanted_speed_m_s,
            rider: self.rider.act(&perception(truth, wanted_speed_m_s)),
            side: self.disturbances.at(now.as_secs_f64()),
        }
    }

    /// Goes on by one tick under the controller's answer; `None` is silence.
    pub(crate) fn step(
        &mut self,
        now: Instant,
        truth: &Truth,
        acts: &Acts,
        answer: Option<&ControllerFrame>,
    ) -> (TruthRow, RiderRow) {
        let (action, side) = (&acts.rider, &acts.side);
        self.power_out = self.power.step(
            now,
            answer.map(|a| a.output.command),
            truth.front_wheel_rate_rad_s,
            truth.rear_wheel_rate_rad_s,
            TICK,
        );
        let device = self.device(truth);
        let wind = self.course.plant.wind();
        let input = PlantInput {
            front_brake_nm: self.power_out.front_brake_nm,
            rear_traction_nm: self.power_out.rear_traction_nm,
            steer_torque_nm: action.steer_torque_nm + side.steer_torque_nm + device.torque_nm,
            pedal_force_n: action.pedal_force_n,
            lateral_force_n: side.lateral_force_n,
            lateral_force_x_m: side.point_x_m,
            lateral_force_height_m: side.point_height_m,
            roll_torque_nm: side.roll_torque_nm,
            yaw_torque_nm: side.yaw_torque_nm,
            trunk_lean_torque_nm: action.trunk_lean_torque_nm,
            leg_torque_nm: action.leg_torque_nm,
            wind_m_s: wind.map_or([0.0; 2], |w| w.velocity_m_s(now.as_secs_f64())),
            rear_road_y_m_s: side.rear_road_y_m_s,
        };
        self.plant.step(&input, TICK_S);
        let row = TruthRow {
            front_brake_nm: input.front_brake_nm,
            rear_traction_nm: input.rear_traction_nm,
            lateral_force_n: input.lateral_force_n,
            battery_w: self.power_out.bus_v * self.power_out.bus_a + device.battery_w,
            ..truth_row(truth)
        };
        let rider = RiderRow {
            steer_torque_nm: action.steer_torque_nm,
            trunk_lean_torque_nm: action.trunk_lean_torque_nm,
            left_leg_torque_nm: action.leg_torque_nm[0],
            right_leg_torque_nm: action.leg_torque_nm[1],
            pedal_force_n: action.pedal_force_n,
            wanted_speed_m_s: acts.wanted_speed_m_s,
        };
        (row, rider)
    }
}

impl Bench<'_> {
    fn device(&mut self, truth: &Truth) -> SteeringOutput {
        let [roll_rate_rad_s, speed_m_s] = self.told;
        let senses = SteeringSenses {
            roll_rate_rad_s,
            speed_m_s,
            steer_rad: truth.steer_rad,
            steer_rate_rad_s: truth.steer_rate_rad_s,
        };
        self.steering
            .as_mut()
            .map(|device| device.step(self.assist_on, &senses, TICK_S))
            .unwrap_or_default()
    }
}

fn perception(t: &Truth, wanted_speed_m_s: f64) -> Perception {
    Perception {
        roll_rad: t.roll_rad,
        roll_rate_rad_s: t.roll_rate_rad_s,
        steer_rad: t.steer_rad,
        steer_rate_rad_s: t.steer_rate_rad_s,
        trunk_lean_rad: t.trunk_lean_rad,
        trunk_lean_rate_rad_s: t.trunk_lean_rate_rad_s,
        legs_rad: t.legs_rad,
        leg_rates_rad_s: t.leg_rates_rad_s,
        yaw_rad: t.yaw_rad,
        speed_m_s: t.speed_m_s,
        wanted_speed_m_s,
    }
}
