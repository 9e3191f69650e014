//! What: one pass of the predictor over the lateral motion of a ride.
//!
//! Equation: x = (roll, steer, their rates, [heading], [latent torques], [recorders' filters]) with
//! constant biases behind; M q'' = torque + wrench(x) - C q' - K q. Within a step the wrench is
//! J x + rest: J moves with the state, the rest is held (and corrected to a straight line once the
//! end of the step is known). Covariance and gain follow from the linear part; readings are taken
//! one after the other.
//!
//! Source: Harvey (1989), chapter 3, for the filter; statistical linearisation of the wrench by
//! central differences over one standard deviation of the state: A. Gelb, Applied Optimal
//! Estimation (1974), section 6.2.
//!
//! Assumes and ignores: small angles; noises white; a mechanism with a memory is driven by the
//! predicted state and left out of the covariance.
//!
//! Valid for: readings in the order of time.
//!
//! Checked by: `tests` of the engine: consistency on simulated rides, sensitivities against
//! differences.

use super::course::Course;
use super::flow::Flow;
use super::layout::{HEADING, Layout};
use super::pass::Pass;
use super::ride::Ride;
use super::setup::{Model, Setup};
use super::small::{dot, sparse_mul};
use super::state::{self, Balance, Pace, Which};
use nalgebra::Vector2;

/// Derivatives of the wrench's roll and steer torque by the four states.
pub(super) type Slope = [[f64; 4]; 2];

#[derive(Clone)]
pub(super) struct Work<'a> {
    pub(super) ride: &'a Ride,
    pub(super) setup: &'a Setup,
    pub(super) model: &'a Model,
    pub(super) layout: &'a Layout,
    pub(super) flow: Flow,
    pub(super) a: Vec<f64>,
    pub(super) columns: [Vec<f64>; 2],
    pub(super) x: Vec<f64>,
    pub(super) p: Vec<f64>,
    /// Transition of the dynamic states, all columns.
    pub(super) top: Vec<f64>,
    pub(super) w: Vec<f64>,
    pub(super) row: Vec<f64>,
    pub(super) gain: Vec<f64>,
    pub(super) memory: Vec<f64>,
    pub(super) next: Vec<f64>,
    pub(super) before: Vec<f64>,
    /// Running free: nothing is read, the covariance stays.
    pub(super) blind: bool,
    pub(super) said: Vec<(usize, f64)>,
}

/// Runs the predictor; `paces` holds the pace at the end of each step.
pub fn run(
    ride: &Ride,
    course: &Course,
    setup: &Setup,
    model: &Model,
    paces: &[Pace],
    pass: &mut Pass,
) {
    walk(ride, course, setup, model, paces, pass, &mut |_, _| {});
}

/// Runs the predictor, and looks at it after every step.
pub(super) fn walk(
    ride: &Ride,
    course: &Course,
    setup: &Setup,
    model: &Model,
    paces: &[Pace],
    pass: &mut Pass,
    after_step: &mut dyn FnMut(&Work<'_>, usize),
) {
    let layout = Layout::new(ride, model);
    let (n, nd) = (layout.states, layout.dynamic);
    let prior = layout.prior(ride);
    let mut work = Work {
        ride,
        setup,
        model,
        layout: &layout,
        flow: Flow::new(nd),
        a: vec![0.0; nd * nd],
        columns: [vec![0.0; nd], vec![0.0; nd]],
        x: vec![0.0; n],
        p: vec![0.0; n * n],
        top: vec![0.0; nd * n],
        w: vec![0.0; nd * n],
        row: vec![0.0; n],
        gain: vec![0.0; n],
        memory: vec![0.0; setup.memory],
        next: vec![0.0; nd],
        before: vec![0.0; n],
        blind: false,
        said: vec![],
    };
    for i in nd..n {
        work.p[i * n + i] = prior[i];
    }
    let inverse = setup.plant.body.mass_inverse;
    for i in 0..2 {
        for j in 0..2 {
            work.columns[j][2 + i] = inverse[(i, j)];
        }
    }
    let mut pace = Pace::default();
    for (index, step) in course.steps.iter().enumerate() {
        if step.fresh {
            work.restart(&prior);
            pace = paces[index];
        }
        let after = paces[index];
        let slip = if step.dt_s > 0.0 {
            work.advance(step, &pace, &after, pass)
        } else {
            pass.record_still(nd, n);
            0.0
        };
        work.read(course, index, &after, slip, pass);
        if step.fresh {
            // Memories start from what the first readings say.
            work.start_memory(step, &after);
        }
        pace = after;
        pass.end_step(&work.x);
        after_step(&work, index);
    }
}

impl Work<'_> {
    fn restart(&mut self, prior: &[f64]) {
        let (n, nd) = (self.layout.states, self.layout.dynamic);
        self.x[..nd].fill(0.0);
        for i in 0..nd {
            for j in 0..n {
                self.p[i * n + j] = 0.0;
                self.p[j * n + i] = 0.0;
            }
            self.p[i * n + i] = prior[i];
        }
        self.memory.fill(0.0);
    }

    pub(super) fn accel(&self, balance: &Balance, x: &[f64]) -> Vector2<f64> {
        let mut torque = balance.net(x);
        for (index, latent) in self.layout.latent.iter().flatten() {
            torque += Vector2::from(latent.arm) * x[*index];
        }
        for (bias, arm) in self.layout.drive_bias.iter().zip(&self.setup.arms) {
            if let Some(bias) = bias {
                torque.x -= arm[0] * x[*bias];
                torque.y -= arm[1] * x[*bias];
            }
        }
        self.setup.plant.body.mass_inverse * torque
    }

    fn start_memory(&mut self, step: &super::course::Step, pace: &Pace) {
        if self.setup.memory > 0 {
            let at = state::moment(
                self.setup,
                self.ride,
                &step.to,
                pace,
                &self.x,
                Vector2::zeros(),
                step.t_s,
                0.0,
            );
            let mut memory = std::mem::take(&mut self.memory);
            state::remember(self.setup, &at, &mut memory, true);
            self.memory = memory;
        }
    }

    /// Over one step; gives the yaw rate that slip adds at its end.
    pub(super) fn advance(
        &mut self,
        step: &super::course::Step,
        from: &Pace,
        to: &Pace,
        pass: &mut Pass,
    ) -> f64 {
        let (n, nd) = (self.layout.states, self.layout.dynamic);
        let (setup, ride, h) = (self.setup, self.ride, step.dt_s);
        let start_s = step.t_s - h;
        let to = &to.at_end();
        self.before.copy_from_slice(&self.x);
        let pushed = state::is_pushed(setup, ride);
        let feedback = !ride.laws.is_empty()
            || setup
                .pushing
                .iter()
                .any(|(i, _)| setup.plant.active[*i].mechanism.feeds_back());
        let begin = Balance::new(setup, &step.from, from);
        let end = Balance::new(setup, &step.to, to);
        let middle = Balance {
            damping: (begin.damping + end.damping) * 0.5,
            stiffness: (begin.stiffness + end.stiffness) * 0.5,
            torque: begin.torque,
        };
        let mid_pace = Pace {
            speed_m_s: 0.5 * (from.speed_m_s + to.speed_m_s),
            travel_m: from.travel_m,
            ..*to
        };
        let x0: [f64; 4] = std::array::from_fn(|i| self.x[i]);
        let mut slope = None;
        let mut rest0 = Vector2::zeros();
        let mut slip = [0.0; 2];
        let mut memory = std::mem::take(&mut self.memory);
        if pushed {
            let accel = self.accel(&begin, &self.x);
            let at = state::moment(setup, ride, &step.from, from, &x0, accel, start_s, h);
            self.memory = memory;
            let w = state::wrench(setup, ride, &at, &self.memory, Which::All);
            if feedback {
                slope = Some(self.slope(&at, &begin));
            }
            rest0 = rest(&w, slope.as_ref(), &x0);
            slip[0] = w.yaw_rate_rad_s;
            memory = std::mem::take(&mut self.memory);
            state::remember(setup, &at, &mut memory, false);
        }
        self.memory = memory;
        self.fill_a(&middle, slope.as_ref(), &mid_pace);
        let columns = std::mem::take(&mut self.columns);
        self.flow.compute(&self.a, &columns, h);
        self.columns = columns;
        // Transition with the drives' biases, which subtract from the torque.
        for i in 0..nd {
            self.top[i * n..i * n + nd].copy_from_slice(&self.flow.phi[i * nd..(i + 1) * nd]);
            self.top[i * n + nd..(i + 1) * n].fill(0.0);
        }
        for (bias, arm) in self.layout.drive_bias.iter().zip(&setup.arms) {
            if let Some(bias) = bias {
                for i in 0..nd {
                    self.top[i * n + bias] =
                        -arm[0] * self.flow.held[0][i] - arm[1] * self.flow.held[1][i];
                }
            }
        }
        // Mean.
        let mut next = std::mem::take(&mut self.next);
        for (i, value) in next.iter_mut().enumerate() {
            *value = dot(&self.top[i * n..(i + 1) * n], &self.x);
        }
        let (u0, u1) = (begin.torque + rest0, end.torque + rest0);
        for i in 0..nd {
            for c in 0..2 {
                next[i] += self.flow.held[c][i] * u0[c] + self.flow.ramp[c][i] * (u1[c] - u0[c]);
            }
        }
        self.x[..nd].copy_from_slice(&next);
        self.next = next;
        if pushed {
            let accel = self.accel(&end, &self.x);
            let x1: [f64; 4] = std::array::from_fn(|i| self.x[i]);
            let at = state::moment(setup, ride, &step.to, to, &x1, accel, step.t_s, h);
            let w = state::wrench(setup, ride, &at, &self.memory, Which::All);
            let change = rest(&w, slope.as_ref(), &x1) - rest0;
            slip[1] = w.yaw_rate_rad_s;
            for i in 0..nd {
                self.x[i] += self.flow.ramp[0][i] * change.x + self.flow.ramp[1][i] * change.y;
            }
            if self.layout.heading {
                self.x[HEADING] += 0.5 * h * (slip[0] + slip[1]);
            }
        }
        if self.blind {
            return slip[1];
        }
        self.covariance(h);
        pass.record_step(&self.top, &self.flow, &self.before, &self.x, n);
        slip[1]
    }

    fn covariance(&mut self, h: f64) {
        let (n, nd) = (self.layout.states, self.layout.dynamic);
        // Torque noise of the equations and of the measured inputs.
        let [roll, steer, _] = self.model.levels.process;
        let mut s = [roll * roll, 0.0, steer * steer];
        for (drive, arm) in self.ride.drives.iter().zip(&self.setup.arms) {
            if drive.noise_sd > 0.0 {
                let q = drive.noise_sd * drive.noise_sd * drive.interval_s;
                s[0] += q * arm[0] * arm[0];
                s[1] += q * arm[0] * arm[1];
                s[2] += q * arm[1] * arm[1];
            }
        }
        for i in 0..nd {
            let row = &self.top[i * n..(i + 1) * n];
            sparse_mul(&mut self.w[i * n..(i + 1) * n], row, &self.p, n);
        }
        // Simpson's rule over the step: after h, h/2 and 0.
        let mut late = [[0.0; 2]; 24];
        let phi = &self.flow.phi;
        for (i, row) in phi.chunks_exact(nd).enumerate().take(24) {
            for c in 0..2 {
                late[i][c] = row[2] * self.columns[c][2] + row[3] * self.columns[c][3];
            }
        }
        let weigh = |a: [f64; 2], b: [f64; 2]| {
            s[0] * a[0] * b[0] + s[1] * (a[0] * b[1] + a[1] * b[0]) + s[2] * a[1] * b[1]
        };
        for i in 0..nd {
            for j in 0..=i {
                let mut sum = dot(&self.w[i * n..(i + 1) * n], &self.top[j * n..(j + 1) * n]);
                let pick = |v: &[Vec<f64>; 2], k: usize| [v[0][k], v[1][k]];
                sum += h / 6.0
                    * (weigh(late[i], late[j])
                        + 4.0 * weigh(pick(&self.flow.half, i), pick(&self.flow.half, j))
                        + weigh(pick(&self.columns, i), pick(&self.columns, j)));
                self.p[i * n + j] = sum;
                self.p[j * n + i] = sum;
            }
            for j in nd..n {
                self.p[i * n + j] = self.w[i * n + j];
                self.p[j * n + i] = self.w[i * n + j];
            }
        }
        for (index, latent) in self.layout.latent.iter().flatten() {
            self.p[index * n + index] += 2.0 * latent.sd * latent.sd * h / latent.time_s;
        }
    }
}

fn rest(w: &twinhub_mechanism::Wrench, slope: Option<&Slope>, x: &[f64; 4]) -> Vector2<f64> {
    let mut rest = Vector2::new(w.roll_nm, w.steer_nm);
    if let Some(slope) = slope {
        rest.x -= dot(&slope[0], x);
        rest.y -= dot(&slope[1], x);
    }
    rest
}
