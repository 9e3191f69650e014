//! What: the multibody model as a plant that a controller rides on.
//!
//! Equation: the steps of `step`.
//!
//! Source: as there.
//!
//! Assumes and ignores: forces of motors and rider are constant over a step; the rider's pedal force
//! acts as a torque on the rear wheel, reacted by the frame.
//!
//! Valid for: 0.3 to 12 m/s; a fall stays finite.
//!
//! Checked by: `multibody/tests`.

use super::contact::WheelContact;
use super::error::MultibodyError;
use super::model::{Input, Multibody, Prepared};
use super::parameters::Parameters;
use super::state::{
    ANGULAR, ATTITUDE, LEG_RATE, LEGS, SPIN, STEER, STEER_RATE, State, StateAccess, TRUNK,
    TRUNK_RATE, VELOCITY,
};
use super::steady::Course;
use super::vector::{Vec3, add, columns_times, cross, rows_times, sub};
use crate::road::Road;
use crate::truth::{PlantInput, PlantModel, Truth};
use std::cell::OnceCell;

/// Roll beyond which the bicycle counts as fallen, rad.
const FALL_ROLL_RAD: f64 = 0.8;

/// A multibody bicycle in motion.
#[derive(Clone, Debug)]
pub struct Ride {
    model: Multibody,
    road: Option<Road>,
    state: State,
    input: Input,
    /// What the truth of the present state has worked out already and the next step needs too.
    prepared: OnceCell<Prepared<f64>>,
    /// Accelerometer, coordinates of the parameters, m.
    sensor_at_m: [f64; 3],
    /// Angle of the right crank from its upper dead centre, forward, rad.
    pub(super) crank_rad: f64,
}

impl Ride {
    /// Upright and straight at `speed_m_s`, settled on its tyres, motors off. The accelerometer
    /// sits in the centre of mass of the frame.
    pub fn new(
        parameters: &Parameters,
        road: Option<Road>,
        speed_m_s: f64,
    ) -> Result<Self, MultibodyError> {
        let model = Multibody::new(parameters)?;
        let steady = model.steady(&Course::straight(speed_m_s), None)?;
        let frame = &parameters.frame;
        let mut state = steady.state;
        if let Some(road) = &road {
            state[2] -= road.height_m(0.0, 0.0);
        }
        Ok(Self {
            road,
            state,
            input: steady.input,
            prepared: OnceCell::new(),
            sensor_at_m: [frame.x_m, 0.0, frame.z_m],
            crank_rad: 0.0,
            model,
        })
    }

    /// Puts the accelerometer elsewhere on the frame, coordinates of the parameters, m.
    pub fn with_sensor_at(mut self, at_m: [f64; 3]) -> Self {
        self.sensor_at_m = at_m;
        self
    }

    /// The model.
    pub fn model(&self) -> &Multibody {
        &self.model
    }

    /// The state.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Sets the state; without slip it is moved onto the constraints.
    pub fn set_state(&mut self, state: &State) {
        self.state = *state;
        self.prepared.take();
        self.model.project(&mut self.state);
    }

    /// The road; none is level with friction 1.
    pub fn road(&self) -> Option<&Road> {
        self.road.as_ref()
    }

    /// What acted in the last step.
    pub fn input(&self) -> &Input {
        &self.input
    }

    /// Derivative of the state now, under what acted last.
    pub fn derivative(&self) -> State {
        let mut dx = [0.0; super::STATES];
        self.model
            .rhs(&self.state, &self.input, self.road.as_ref(), &mut dx);
        dx
    }

    /// Parts into which a step of `step_s` would be divided now.
    pub fn parts(&self, step_s: f64) -> usize {
        self.model
            .parts_of_step(&self.state, &self.input, self.road.as_ref(), step_s)
    }

    /// Goes on by `step_s` seconds under `input`.
    pub fn advance(&mut self, input: &Input, step_s: f64) {
        let road = self.road.as_ref();
        let known = self
            .prepared
            .take()
            .filter(|_| self.input.rear_road_y_m_s == input.rear_road_y_m_s);
        self.input = *input;
        match known {
            Some(prepared) => super::batch::advance_prepared(
                &self.model,
                &mut self.state,
                input,
                road,
                step_s,
                &prepared,
            ),
            None => super::batch::advance(&self.model, &mut self.state, input, road, step_s, 1),
        }
    }

    /// Contacts of rear and front wheel; of a wheel without slip the load alone is meaningful.
    pub fn contacts(&self) -> [WheelContact<f64>; 2] {
        self.contacts_under(&self.input)
    }

    /// The same where `input` acts.
    pub fn contacts_under(&self, input: &Input) -> [WheelContact<f64>; 2] {
        let mut dx = [0.0; super::STATES];
        self.model
            .observed(&self.state, input, self.road.as_ref(), &mut dx)
    }

    /// Torques and forces of a tick as the model takes them, pedals left out.
    pub fn inputs(&self, input: &PlantInput) -> Input {
        Input {
            front_brake_nm: input.front_brake_nm,
            rear_traction_nm: input.rear_traction_nm,
            steer_torque_nm: input.steer_torque_nm,
            force_n: [0.0, input.lateral_force_n, 0.0],
            force_at_m: [input.lateral_force_x_m, 0.0, -input.lateral_force_height_m],
            moment_nm: [input.roll_torque_nm, 0.0, input.yaw_torque_nm],
            trunk_torque_nm: [input.trunk_lean_torque_nm, 0.0, 0.0],
            leg_torque_nm: input.leg_torque_nm,
            wind_m_s: [input.wind_m_s[0], input.wind_m_s[1], 0.0],
            rear_road_y_m_s: input.rear_road_y_m_s,
        }
    }
}

impl Multibody {
    /// Derivative of the state, and contacts.
    pub(super) fn observed(
        &self,
        x: &State,
        input: &Input,
        road: Option<&Road>,
        dx: &mut State,
    ) -> [WheelContact<f64>; 2] {
        if !self.no_slip
            && let Some(contacts) = super::batch::rhs(self, x, input, road, dx)
        {
            return contacts;
        }
        let pose = self.tree.pose(x);
        let grounds = self.grounds(x, &pose, road);
        let applied = self.applied(x, input, &pose);
        let lambda = self.rhs_no_slip(x, &pose, &applied, &grounds, dx);
        let points = super::contact::contact_points(&self.tree, x, &pose, &grounds, true);
        core::array::from_fn(|k| {
            let mut tyre = crate::tyre::TyreOutput::zero();
            tyre.longitudinal_n = lambda[3 * k];
            tyre.lateral_n = lambda[3 * k + 1];
            WheelContact {
                load_n: -lambda[3 * k + 2],
                deflection_m: 0.0,
                slip_ratio: 0.0,
                slip_angle_rad: 0.0,
                camber_rad: libm::atan(points[k].sin_camber * points[k].inverse_cos),
                speed_m_s: super::vector::dot(points[k].velocity, points[k].forward),
                tyre,
            }
        })
    }

    /// What is true in state `x` under `input`; the accelerometer at `sensor_at_m`.
    pub fn truth(
        &self,
        x: &State,
        input: &Input,
        road: Option<&Road>,
        sensor_at_m: [f64; 3],
    ) -> Truth {
        let mut dx = [0.0; super::STATES];
        let contacts = self.observed(x, input, road, &mut dx);
        self.truth_of(x, road, sensor_at_m, &dx, &contacts)
    }

    fn truth_of(
        &self,
        x: &State,
        road: Option<&Road>,
        sensor_at_m: [f64; 3],
        dx: &State,
        contacts: &[WheelContact<f64>; 2],
    ) -> Truth {
        let rotation = super::vector::rotation(&x.attitude());
        let rear = super::contact::rear_point(
            &x.base_motion(),
            [x[0], x[1], x[2]],
            &rotation,
            &Self::rear_ground(x, road),
            self.no_slip.then_some(self.tree.wheels[0].radius),
        );
        let (yaw, roll, pitch) = super::vector::yaw_roll_pitch(&rotation);
        let ((_, cr), (sp, cp)) = (libm::sincos(roll), libm::sincos(pitch));
        let w: Vec3<f64> = [x[ANGULAR], x[ANGULAR + 1], x[ANGULAR + 2]];
        let v: Vec3<f64> = [x[VELOCITY], x[VELOCITY + 1], x[VELOCITY + 2]];
        // Acceleration of the sensor less gravity, frame axes.
        let at = sub(sensor_at_m, self.tree.origin);
        let alpha = [dx[ANGULAR], dx[ANGULAR + 1], dx[ANGULAR + 2]];
        let linear = add(
            [dx[VELOCITY], dx[VELOCITY + 1], dx[VELOCITY + 2]],
            cross(w, v),
        );
        let sensed = add(linear, add(cross(alpha, at), cross(w, cross(w, at))));
        let gravity = columns_times(&rotation, [0.0, 0.0, self.parameters.gravity_m_s2]);
        let contact = rows_times(&rotation, rear.arm);
        Truth {
            roll_rad: roll,
            steer_rad: x[STEER],
            yaw_rad: yaw,
            pitch_rad: pitch,
            roll_rate_rad_s: cp * w[0] + sp * w[2],
            steer_rate_rad_s: x[STEER_RATE],
            // Heading has no rate when the frame lies flat: held finite there.
            yaw_rate_rad_s: (cp * w[2] - sp * w[0]) / cr.max(0.05),
            x_m: x[0] + contact[0],
            y_m: x[1] + contact[1],
            speed_m_s: contacts[0].speed_m_s,
            front_wheel_rate_rad_s: x[SPIN + 1],
            rear_wheel_rate_rad_s: x[SPIN],
            front_load_n: contacts[1].load_n,
            rear_load_n: contacts[0].load_n,
            front_slip_ratio: contacts[1].slip_ratio,
            rear_slip_ratio: contacts[0].slip_ratio,
            trunk_lean_rad: x[TRUNK],
            trunk_lean_rate_rad_s: x[TRUNK_RATE],
            legs_rad: [x[LEGS], x[LEGS + 1]],
            leg_rates_rad_s: [x[LEG_RATE], x[LEG_RATE + 1]],
            body_rates_rad_s: w,
            specific_force_m_s2: sub(sensed, gravity),
        }
    }
}

impl PlantModel for Ride {
    fn step(&mut self, input: &PlantInput, step_s: f64) {
        let pedal_force_n = input.pedal_force_n;
        let input = self.inputs(input);
        self.pedal(&input, pedal_force_n, step_s);
    }

    fn truth(&self) -> Truth {
        let (model, x, road) = (&self.model, &self.state, self.road.as_ref());
        if model.no_slip {
            return model.truth(x, &self.input, road, self.sensor_at_m);
        }
        let prepared = self
            .prepared
            .get_or_init(|| super::batch::prepare(model, x, self.input.rear_road_y_m_s, road));
        let mut dx = [0.0; super::STATES];
        super::batch::finish(model, prepared, x, &self.input, &mut dx);
        model.truth_of(x, road, self.sensor_at_m, &dx, &prepared.tyres.contacts)
    }

    fn fall_roll_rad(&self) -> f64 {
        FALL_ROLL_RAD
    }
}

/// The mirror image of a state: left and right exchanged.
pub fn mirrored(x: &State) -> State {
    let mut m = *x;
    for k in [
        1,
        ATTITUDE + 1,
        ATTITUDE + 3,
        STEER,
        8,
        10,
        VELOCITY + 1,
        ANGULAR,
        ANGULAR + 2,
        STEER_RATE,
        22,
        24,
        29,
        30,
    ] {
        m[k] = -m[k];
    }
    m.swap(11, 12);
    m.swap(25, 26);
    m
}
