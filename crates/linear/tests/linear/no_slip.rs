//! An independent nonlinear model of the same bicycle, and its numerical derivative.
//!
//! Built on velocities alone: the rear contact runs along its wheel's heading, the front wheel's
//! point at the ground does not move, the pitch follows from the front contact's height. Kane's
//! method with derivatives by differences; no formula of the linear theory, and the motors enter
//! only as torques between wheel and frame.

use crate::built_in;
use nalgebra::{Matrix3, Rotation3, Unit, Vector3};
use twinhub_linear::{Canonical, MotorPair, Parameters};

type V3 = Vector3<f64>;

/// Speeds u = (forward speed of the rear contact, roll rate, steer rate).
struct Model {
    p: Parameters,
    pair: MotorPair,
}

/// Velocity of a centre of mass, angular velocity and angular momentum of each body.
struct Motion {
    /// Rear wheel, rear body, front assembly, front wheel.
    bodies: [(f64, V3, V3, V3); 4],
    /// Spin of the wheels against frame and fork about the axle (negative forward).
    spins: [f64; 2],
    yaw_rate: f64,
    pitch_rate: f64,
}

impl Model {
    fn turn(axis: V3, angle: f64) -> Rotation3<f64> {
        Rotation3::from_axis_angle(&Unit::new_normalize(axis), angle)
    }

    fn steer_axis(&self) -> V3 {
        V3::new(self.p.lam.sin(), 0.0, self.p.lam.cos())
    }

    /// Rotations of rear frame and fork, positions from the rear contact, at heading zero.
    fn pose(&self, roll: f64, steer: f64, pitch: f64) -> (Rotation3<f64>, Rotation3<f64>, [V3; 4]) {
        let p = &self.p;
        let lean = Self::turn(V3::x(), roll);
        let b = lean * Self::turn(V3::y(), pitch);
        let fork_in_b = Self::turn(self.steer_axis(), steer);
        let h = b * fork_in_b;
        let hub = V3::new(0.0, 0.0, -p.rR);
        let axis_at = V3::new(p.w + p.c, 0.0, 0.0);
        let rear = lean * hub;
        let on_rear = |r: V3| rear + b * (r - hub);
        let on_fork = |r: V3| rear + b * (axis_at - hub + fork_in_b * (r - axis_at));
        let centres = [
            rear,
            on_rear(V3::new(p.xB, 0.0, p.zB)),
            on_fork(V3::new(p.xH, 0.0, p.zH)),
            on_fork(V3::new(p.w, 0.0, -p.rF)),
        ];
        (b, h, centres)
    }

    /// From the front hub to the lowest point of the wheel.
    fn down(&self, h: &Rotation3<f64>) -> V3 {
        let axle = h * V3::y();
        (V3::z() - axle * axle.z).normalize() * self.p.rF
    }

    fn pitch(&self, roll: f64, steer: f64) -> f64 {
        let height = |pitch: f64| {
            let (_, h, c) = self.pose(roll, steer, pitch);
            c[3].z + self.down(&h).z
        };
        let mut x = 0.0;
        for _ in 0..30 {
            let slope = (height(x + 1e-5) - height(x - 1e-5)) / 2e-5;
            x -= height(x) / slope;
        }
        x
    }

    fn motion(&self, roll: f64, steer: f64, u: [f64; 3]) -> Motion {
        let p = &self.p;
        let pitch = self.pitch(roll, steer);
        let (b, h, centres) = self.pose(roll, steer, pitch);
        let lean_axis = V3::x();
        let pitch_axis = Self::turn(V3::x(), roll) * V3::y();
        let steer_axis = b * self.steer_axis();
        let axle = h * V3::y();
        let pivot = centres[0] + b * (V3::new(p.w + p.c, 0.0, p.rR));
        // Velocities for given yaw and pitch rate.
        let velocities =
            |yaw_rate: f64, pitch_rate: f64, v: f64, roll_rate: f64, steer_rate: f64| {
                let lean = V3::z() * yaw_rate + lean_axis * roll_rate;
                let frame = lean + pitch_axis * pitch_rate;
                let fork = frame + steer_axis * steer_rate;
                let rear = V3::x() * v + lean.cross(&centres[0]);
                let body = rear + frame.cross(&(centres[1] - centres[0]));
                let at_pivot = rear + frame.cross(&(pivot - centres[0]));
                let on_fork = |c: V3| at_pivot + fork.cross(&(c - pivot));
                (
                    lean,
                    frame,
                    fork,
                    [rear, body, on_fork(centres[2]), on_fork(centres[3])],
                )
            };
        // The front wheel's point at the ground rests: three equations, linear in yaw rate, pitch
        // rate and spin.
        let down = self.down(&h);
        let slip = |yaw: f64, pitch: f64, spin: f64, u: [f64; 3]| {
            let (_, _, fork, v) = velocities(yaw, pitch, u[0], u[1], u[2]);
            v[3] + (fork + axle * spin).cross(&down)
        };
        let rest = slip(0.0, 0.0, 0.0, u);
        let columns = Matrix3::from_columns(&[
            slip(1.0, 0.0, 0.0, [0.0; 3]),
            slip(0.0, 1.0, 0.0, [0.0; 3]),
            slip(0.0, 0.0, 1.0, [0.0; 3]),
        ]);
        let x = columns.lu().solve(&-rest).unwrap();
        let (lean, frame, fork, v) = velocities(x[0], x[1], u[0], u[1], u[2]);
        let rear_axle = pitch_axis;
        // Rolling without slip along the heading: spin -v/rR about the axle, against the leaning
        // plane; against the frame less its pitch rate.
        let rear_spin = -u[0] / p.rR;
        let wheel = |ixx: f64, iyy: f64, omega: V3, axle: V3| {
            omega * ixx + axle * ((iyy - ixx) * omega.dot(&axle))
        };
        let solid = |r: &Rotation3<f64>, i: [f64; 4], omega: V3| {
            let [xx, yy, zz, xz] = i;
            r * (Matrix3::new(xx, 0.0, xz, 0.0, yy, 0.0, xz, 0.0, zz) * (r.inverse() * omega))
        };
        let (omega_r, omega_f) = (lean + rear_axle * rear_spin, fork + axle * x[2]);
        Motion {
            bodies: [
                (
                    p.mR,
                    v[0],
                    omega_r,
                    wheel(p.IRxx, p.IRyy, omega_r, rear_axle),
                ),
                (
                    p.mB,
                    v[1],
                    frame,
                    solid(&b, [p.IBxx, p.IByy, p.IBzz, p.IBxz], frame),
                ),
                (
                    p.mH,
                    v[2],
                    fork,
                    solid(&h, [p.IHxx, p.IHyy, p.IHzz, p.IHxz], fork),
                ),
                (p.mF, v[3], omega_f, wheel(p.IFxx, p.IFyy, omega_f, axle)),
            ],
            spins: [rear_spin - x[1], x[2]],
            yaw_rate: x[0],
            pitch_rate: x[1],
        }
    }

    /// Generalised force less inertia for accelerations `du`.
    fn residual(&self, roll: f64, steer: f64, u: [f64; 3], du: [f64; 3]) -> V3 {
        let here = self.motion(roll, steer, u);
        // Time derivatives along the motion, in axes that do not turn: the heading turns with the
        // yaw rate, and the pose above is given at heading zero.
        let at = |t: f64| {
            let m = self.motion(
                roll + t * u[1],
                steer + t * u[2],
                core::array::from_fn(|i| u[i] + t * du[i]),
            );
            let turn = Self::turn(V3::z(), t * here.yaw_rate);
            m.bodies
                .map(|(mass, v, _, momentum)| (turn * v * mass, turn * momentum))
        };
        let h = 1e-3;
        let (a, b, c, d) = (at(-2.0 * h), at(-h), at(h), at(2.0 * h));
        V3::from_fn(|r, _| {
            let mut unit = [0.0; 3];
            unit[r] = 1.0;
            let partial = self.motion(roll, steer, unit);
            let mut sum = -partial.spins[0] * self.pair.rear_traction_nm
                + partial.spins[1] * self.pair.front_brake_nm;
            for i in 0..4 {
                let (mass, v, omega, _) = partial.bodies[i];
                let slope = |f: &dyn Fn(&(V3, V3)) -> V3| {
                    ((f(&a[i]) - f(&d[i])) + 8.0 * (f(&c[i]) - f(&b[i]))) / (12.0 * h)
                };
                sum +=
                    mass * self.p.g * v.z - slope(&|s| s.0).dot(&v) - slope(&|s| s.1).dot(&omega);
            }
            sum
        })
    }

    /// Accelerations (forward, roll, steer), hands off.
    fn accelerations(&self, x: [f64; 4], v: f64) -> V3 {
        let u = [v, x[2], x[3]];
        let free = self.residual(x[0], x[1], u, [0.0; 3]);
        let columns: Vec<V3> = (0..3)
            .map(|i| {
                let mut du = [0.0; 3];
                du[i] = 1.0;
                free - self.residual(x[0], x[1], u, du)
            })
            .collect();
        Matrix3::from_columns(&columns).lu().solve(&free).unwrap()
    }
}

fn compare(name: &str, v: f64, pair: MotorPair) -> f64 {
    let (bicycle, equations) = built_in(name);
    let model = Model {
        p: bicycle.parameters,
        pair,
    };
    let a = equations.state_matrix(v, pair);
    let straight = model.accelerations([0.0; 4], v);
    let forward = equations.longitudinal_accel_m_s2(pair);
    assert!(
        (straight[0] - forward).abs() < 1e-9 * (1.0 + forward.abs()),
        "{} against {forward}",
        straight[0]
    );
    assert!(
        straight[1].abs() + straight[2].abs() < 1e-9,
        "straight and upright the pair does not push: {straight}"
    );
    let mut worst: f64 = 0.0;
    for column in 0..4 {
        let at = |e: f64| {
            let mut x = [0.0; 4];
            x[column] = e;
            model.accelerations(x, v)
        };
        let e = 2e-3;
        let slope = ((at(-2.0 * e) - at(2.0 * e)) + 8.0 * (at(e) - at(-e))) / (12.0 * e);
        for row in 0..2 {
            let (got, want) = (a[(2 + row, column)], slope[1 + row]);
            worst = worst.max((got - want).abs() / (1.0 + want.abs()));
        }
    }
    worst
}

#[test]
fn the_linear_equations_are_the_derivative_of_the_nonlinear_ones() {
    let pair = |front_brake_nm, rear_traction_nm| MotorPair {
        front_brake_nm,
        rear_traction_nm,
    };
    for name in [
        "meijaard2007_benchmark",
        "bulsink2017_bicycle1",
        "bulsink2017_bicycle2",
    ] {
        let (bicycle, _) = built_in(name);
        for (what, motors) in [
            ("off", MotorPair::OFF),
            ("balanced 80 Nm", MotorPair::balanced(80.0, &bicycle)),
            ("rear drive 40 Nm", pair(0.0, 40.0)),
            ("front brake 60 Nm", pair(60.0, 0.0)),
            ("front drive 30 Nm", pair(-30.0, 0.0)),
            ("unequal", pair(70.0, 20.0)),
        ] {
            for v in [0.5, 5.0, 9.0] {
                let worst = compare(name, v, motors);
                println!("{name}, {what}, {v} m/s: {worst:.1e}");
                assert!(worst < 1e-6, "{name}, {what}, {v} m/s: {worst:e}");
            }
        }
    }
}

#[test]
fn the_balanced_pair_is_a_steering_spring_and_nothing_else() {
    let (bicycle, equations) = built_in("bulsink2017_bicycle1");
    let p = &bicycle.parameters;
    for torque in [20.0, 80.0] {
        let change = equations.stiffness(5.0, MotorPair::balanced(torque, &bicycle))
            - equations.stiffness(5.0, MotorPair::OFF);
        let want = torque / p.rF * p.c * (p.w + p.c) / p.w * p.lam.cos().powi(2);
        assert!((change[(1, 1)] - want).abs() < 1e-11, "{change} {want}");
        assert_eq!(
            (change[(0, 0)], change[(0, 1)], change[(1, 0)]),
            (0.0, 0.0, 0.0)
        );
    }
}

#[test]
fn yaw_rate_and_mirror() {
    let (bicycle, equations) = built_in("meijaard2007_benchmark");
    let model = Model {
        p: bicycle.parameters,
        pair: MotorPair::balanced(40.0, &bicycle),
    };
    let e = 1e-5;
    let yaw = model.motion(0.0, e, [4.0, 0.0, 3.0 * e]).yaw_rate;
    let linear = equations.yaw_rate_rad_s(4.0, e, 3.0 * e);
    assert!((yaw / linear - 1.0).abs() < 1e-8, "{yaw} {linear}");
    // Far from upright, mirrored states have mirrored accelerations; the pitch rate is even.
    let x = [0.3, -0.2, 0.4, 0.5];
    let (right, left) = (
        model.accelerations(x, 5.0),
        model.accelerations(x.map(|v| -v), 5.0),
    );
    assert!(
        (right[0] - left[0]).abs() < 1e-8
            && (right[1] + left[1]).abs() < 1e-8
            && (right[2] + left[2]).abs() < 1e-7
    );
    let pitch = |s: f64| {
        model
            .motion(s * 0.3, s * -0.2, [5.0, s * 0.4, s * 0.5])
            .pitch_rate
    };
    assert!((pitch(1.0) - pitch(-1.0)).abs() < 1e-12);
    let _: &Canonical = &equations;
}
