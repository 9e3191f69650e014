//! Our state in the coordinates of the peers, and the checks that both compute the same.

use crate::library::Library;
use rand_pcg::Pcg64Mcg;
use twinhub_plant::multibody::state::{ANGULAR, STEER, STEER_RATE, TRUNK, TRUNK_RATE, VELOCITY};
use twinhub_plant::multibody::{Input, Multibody, Parameters, Ride, STATES, State, StateAccess};

type Vec3 = [f64; 3];

fn dot(a: Vec3, b: Vec3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// Rows: world axes in base components, of the unit quaternion (w, x, y, z).
fn rotation([w, x, y, z]: [f64; 4]) -> [Vec3; 3] {
    [
        [
            1.0 - 2.0 * (y * y + z * z),
            2.0 * (x * y - w * z),
            2.0 * (x * z + w * y),
        ],
        [
            2.0 * (x * y + w * z),
            1.0 - 2.0 * (x * x + z * z),
            2.0 * (y * z - w * x),
        ],
        [
            2.0 * (x * z - w * y),
            2.0 * (y * z + w * x),
            1.0 - 2.0 * (x * x + y * y),
        ],
    ]
}

/// The trunk's joint: axes of lean, pitch and twist in base axes, the trunk's axes in base axes
/// (columns), its attitude as a quaternion (w, x, y, z).
struct Waist {
    axes: [Vec3; 3],
    trunk: [Vec3; 3],
    quaternion: [f64; 4],
}

impl Waist {
    fn of(x: &State) -> Self {
        let half: [(f64, f64); 3] = core::array::from_fn(|k| (0.5 * x[TRUNK + k]).sin_cos());
        let [(s1, c1), (s2, c2), (s3, c3)] = half;
        // Lean about x, then pitch about y, then twist about z.
        let (w, i, j, k) = (c1 * c2, s1 * c2, c1 * s2, s1 * s2);
        let quaternion = [
            w * c3 - k * s3,
            i * c3 + j * s3,
            j * c3 - i * s3,
            k * c3 + w * s3,
        ];
        let rows = rotation(quaternion);
        let trunk: [Vec3; 3] = core::array::from_fn(|c| core::array::from_fn(|r| rows[r][c]));
        let (s, c) = x[TRUNK].sin_cos();
        Self {
            axes: [[1.0, 0.0, 0.0], [0.0, c, s], trunk[2]],
            trunk,
            quaternion,
        }
    }

    /// Rates of lean, pitch and twist as a vector of base axes, in trunk axes.
    fn in_trunk(&self, rates: Vec3) -> Vec3 {
        let whole: Vec3 =
            core::array::from_fn(|k| (0..3).map(|a| rates[a] * self.axes[a][k]).sum());
        self.trunk.map(|axis| dot(axis, whole))
    }

    /// Angular acceleration in trunk axes of these accelerations of lean, pitch and twist.
    fn acceleration(&self, rates: Vec3, accelerations: Vec3) -> Vec3 {
        let part = |k: usize| self.axes[k].map(|v| v * rates[k]);
        let (lean, pitch, twist) = (part(0), part(1), part(2));
        let both: Vec3 = core::array::from_fn(|k| lean[k] + pitch[k]);
        let (a, b) = (cross(lean, pitch), cross(both, twist));
        let turning: Vec3 = core::array::from_fn(|k| a[k] + b[k]);
        let direct = self.in_trunk(accelerations);
        core::array::from_fn(|k| direct[k] + dot(self.trunk[k], turning))
    }
}

/// Positions of Pinocchio's model: quaternions end with w.
fn pinocchio_positions(x: &State, waist: &Waist) -> Vec<f64> {
    let last = |q: [f64; 4]| [q[1], q[2], q[3], q[0]];
    let mut q = x[..3].to_vec();
    q.extend(last(x.attitude()));
    q.extend([x[13], x[STEER], x[14]]);
    q.extend(last(waist.quaternion));
    q.extend([x[11], x[12]]);
    q
}

/// Velocities, or accelerations and forces alike: base linear, base angular, rear wheel, steer, front
/// wheel, trunk, legs.
fn in_order(linear: &[f64], angular: &[f64], joints: &[f64], trunk: Vec3) -> Vec<f64> {
    // Joints as in our state: steer, trunk (3), legs (2), wheels (2).
    let mut v = linear.to_vec();
    v.extend(angular);
    v.extend([joints[6], joints[0], joints[7]]);
    v.extend(trunk);
    v.extend([joints[4], joints[5]]);
    v
}

/// The parameters without springs, dampers, arms and air: what is left is the bare tree.
fn bare(p: &Parameters) -> Parameters {
    let mut p = p.clone();
    let j = &mut p.joints;
    for joint in [
        &mut j.steer,
        &mut j.trunk_lean,
        &mut j.trunk_pitch,
        &mut j.trunk_twist,
        &mut j.legs,
        &mut j.rear_wheel,
        &mut j.front_wheel,
    ] {
        joint.stiffness_nm_rad = 0.0;
        joint.damping_nm_s_rad = 0.0;
        joint.preload_nm = 0.0;
    }
    let a = &mut p.arms;
    (a.stiffness_n_m, a.damping_n_s_m) = (0.0, 0.0);
    (a.torsional_stiffness_nm_rad, a.torsional_damping_nm_s_rad) = (0.0, 0.0);
    a.torque_on_trunk = false;
    (p.air.drag_area_m2, p.air.side_area_m2) = (0.0, 0.0);
    p
}

/// Random numbers in [-size, size].
fn random<const N: usize>(source: &mut Pcg64Mcg, size: f64) -> [f64; N] {
    use rand::RngExt;
    core::array::from_fn(|_| size * (2.0 * source.random::<f64>() - 1.0))
}

/// Accelerations of Pinocchio's `aba` against ours, high above the road, in random states under
/// random torques: the largest difference over the size of the accelerations. Leaves the peer in
/// the last state.
pub fn difference_to_pinocchio(p: &Parameters, peer: &Library, states: usize) -> f64 {
    let model = Multibody::new(&bare(p)).expect("a published set without its springs");
    let mut source = Pcg64Mcg::new(2017);
    let aba = peer.repeated("aba");
    let mut worst: f64 = 0.0;
    for _ in 0..states {
        let mut x: State = model.upright(0.0);
        let [yaw, roll, pitch] = random(&mut source, 0.8);
        x.set_attitude_rad(yaw, roll, pitch);
        x[2] = -100.0;
        x[STEER..STEER + 6].copy_from_slice(&random::<6>(&mut source, 0.6));
        x[VELOCITY..VELOCITY + 3].copy_from_slice(&random::<3>(&mut source, 5.0));
        x[ANGULAR..ANGULAR + 3].copy_from_slice(&random::<3>(&mut source, 3.0));
        x[STEER_RATE..STEER_RATE + 6].copy_from_slice(&random::<6>(&mut source, 3.0));
        x[27..29].copy_from_slice(&random::<2>(&mut source, 20.0));
        let torque: [f64; 8] = random(&mut source, 20.0);
        let (force, moment) = (
            random::<3>(&mut source, 100.0),
            random::<3>(&mut source, 50.0),
        );
        let waist = Waist::of(&x);
        // A moment on the trunk; the torques on the joints are its parts along their axes.
        let on_trunk = [torque[1], torque[2], torque[3]];
        let input = Input {
            front_brake_nm: -torque[7],
            rear_traction_nm: torque[6],
            steer_torque_nm: torque[0],
            trunk_torque_nm: waist.axes.map(|axis| dot(axis, on_trunk)),
            leg_torque_nm: [torque[4], torque[5]],
            force_n: force,
            // At the origin of the base: the hub of the rear wheel.
            force_at_m: [0.0, 0.0, -p.rear_wheel.radius_m],
            moment_nm: moment,
            ..Input::default()
        };
        let mut dx = [0.0; STATES];
        model.rhs(&x, &input, None, &mut dx);
        let three = |at: usize, a: &State| [a[at], a[at + 1], a[at + 2]];
        let rates = three(TRUNK_RATE, &x);
        let ours = in_order(
            &dx[VELOCITY..VELOCITY + 3],
            &dx[ANGULAR..ANGULAR + 3],
            &dx[STEER_RATE..STEER_RATE + 8],
            waist.acceleration(rates, three(TRUNK_RATE, &dx)),
        );
        peer.set(
            &pinocchio_positions(&x, &waist),
            &in_order(
                &x[VELOCITY..VELOCITY + 3],
                &x[ANGULAR..ANGULAR + 3],
                &x[STEER_RATE..STEER_RATE + 8],
                waist.in_trunk(rates),
            ),
            &in_order(
                &force,
                &moment,
                &torque,
                waist.trunk.map(|axis| dot(axis, on_trunk)),
            ),
        );
        aba(1);
        let theirs = peer.accelerations();
        let size = ours.iter().fold(1.0_f64, |a, v| a.max(v.abs()));
        for (a, b) in ours.iter().zip(&theirs) {
            worst = worst.max((a - b).abs() / size);
        }
    }
    worst
}

/// Puts MuJoCo into our state, with the constant torques that our model gets.
pub fn set_mujoco(x: &State, input: &Input, peer: &Library) {
    let r = rotation(x.attitude());
    let world: Vec3 =
        core::array::from_fn(|k| dot(r[k], [x[VELOCITY], x[VELOCITY + 1], x[VELOCITY + 2]]));
    let mut q = x[..7].to_vec();
    q.extend([
        x[13],
        x[STEER],
        x[14],
        x[TRUNK],
        x[TRUNK + 1],
        x[TRUNK + 2],
        x[11],
        x[12],
    ]);
    let trunk = [x[TRUNK_RATE], x[TRUNK_RATE + 1], x[TRUNK_RATE + 2]];
    let v = in_order(
        &world,
        &x[ANGULAR..ANGULAR + 3],
        &x[STEER_RATE..STEER_RATE + 8],
        trunk,
    );
    let torques = [
        input.steer_torque_nm,
        0.0,
        0.0,
        0.0,
        input.leg_torque_nm[0],
        input.leg_torque_nm[1],
        input.rear_traction_nm,
        -input.front_brake_nm,
    ];
    peer.set(
        &q,
        &v,
        &in_order(&[0.0; 3], &[0.0; 3], &torques, input.trunk_torque_nm),
    );
}

/// Motion of MuJoCo against ours from the same disturbed start, `steps` steps long: the largest
/// difference of any coordinate (m, rad), and how far our steer angle went.
pub fn difference_to_mujoco(ride: &Ride, steps: usize, step_s: f64, peer: &Library) -> (f64, f64) {
    let mut ride = ride.clone();
    let mut x = *ride.state();
    let (_, roll, pitch) = x.yaw_roll_pitch_rad();
    x.set_attitude_rad(0.2, roll + 0.1, pitch);
    x[STEER_RATE] = 0.5;
    x[TRUNK] = 0.05;
    x[11] = -0.03;
    ride.set_state(&x);
    let input = *ride.input();
    set_mujoco(&x, &input, peer);
    peer.repeated("step")(steps);
    let mut most: f64 = 0.0;
    for _ in 0..steps {
        ride.advance(&input, step_s);
        most = most.max(ride.state()[STEER].abs());
    }
    let x = ride.state();
    let (q, _, _) = peer.read();
    let mut ours = x[..7].to_vec();
    ours.extend([
        x[13],
        x[STEER],
        x[14],
        x[TRUNK],
        x[TRUNK + 1],
        x[TRUNK + 2],
        x[11],
        x[12],
    ]);
    let worst = ours
        .iter()
        .zip(&q)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max);
    (worst, most)
}
