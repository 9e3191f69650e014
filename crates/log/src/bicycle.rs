//! `/scene`: the bicycle as lines in three dimensions, for Foxglove's 3D panel.
//!
//! The scene stands in a frame `bicycle` that travels with the rear contact point, so that the
//! bicycle stays in view without any transform; lines on the ground move past below it. Foxglove
//! has z up: y and z of the frame of [`twinhub_types::conventions`] change sign.
//!
//! Assumes and ignores: pitch is zero and the wheels stay on the ground's height when upright;
//! it is a picture, not a measurement.

use twinhub_types::Instant;

use crate::scene::{self, Line, line};

/// What the picture needs to know of the bicycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BicycleShape {
    /// Wheel base, m.
    pub wheelbase_m: f64,
    /// Tilt of the steer axis from the vertical, rad.
    pub steer_axis_tilt_rad: f64,
    /// Trail, m.
    pub trail_m: f64,
    /// Radius of the rear wheel, m.
    pub rear_radius_m: f64,
    /// Radius of the front wheel, m.
    pub front_radius_m: f64,
}

crate::row! {
    /// Where the bicycle is.
    pub struct ScenePose {
        /// Rear contact, forward, m.
        x_m,
        /// Rear contact, to the right, m.
        y_m,
        /// Yaw, rad.
        yaw_rad,
        /// Roll, rad.
        roll_rad,
        /// Steer, rad.
        steer_rad,
        /// Angle that the rear wheel has turned, rad.
        rear_turned_rad,
        /// Angle that the front wheel has turned, rad.
        front_turned_rad,
    }
}

impl ScenePose {
    pub(crate) fn from_bytes(bytes: &[u8]) -> Self {
        let mut values = bytes.chunks_exact(8).map(|chunk| {
            let value = chunk.try_into().map_or(0.0, f64::from_le_bytes);
            if value.is_finite() { value } else { 0.0 }
        });
        let mut next = || values.next().unwrap_or(0.0);
        Self {
            x_m: next(),
            y_m: next(),
            yaw_rad: next(),
            roll_rad: next(),
            steer_rad: next(),
            rear_turned_rad: next(),
            front_turned_rad: next(),
        }
    }
}

type Point = [f64; 3];
type Rotation = [Point; 3];

const GREY: [f64; 4] = [0.55, 0.55, 0.58, 0.5];
const FRAME: [f64; 4] = [0.0, 0.45, 0.70, 1.0];
const FORK: [f64; 4] = [0.84, 0.37, 0.0, 1.0];
const TYRE: [f64; 4] = [0.25, 0.25, 0.28, 1.0];
/// Spacing of the lines on the ground, m.
const GRID_M: f64 = 1.0;

impl BicycleShape {
    /// The scene at `at` as a `foxglove.SceneUpdate`.
    pub(crate) fn scene_json(&self, at: Instant, pose: &ScenePose) -> String {
        let lean = product(about_z(pose.yaw_rad), about_x(pose.roll_rad));
        let rear_hub = [0.0, 0.0, -self.rear_radius_m];
        let front_hub = [self.wheelbase_m, 0.0, -self.front_radius_m];
        // The steer axis passes the ground `trail_m` before the front contact and leans back.
        let tilt = self.steer_axis_tilt_rad;
        let down = [libm::sin(tilt), 0.0, libm::cos(tilt)];
        let ground = [self.wheelbase_m + self.trail_m, 0.0, 0.0];
        let on_axis = |up_m: f64| std::array::from_fn(|i| ground[i] - up_m * down[i]);
        let (crown, head): (Point, Point) = (
            on_axis(2.1 * self.front_radius_m),
            on_axis(2.9 * self.front_radius_m),
        );
        let saddle = [0.1 * self.wheelbase_m, 0.0, -2.7 * self.rear_radius_m];
        let crank = [0.42 * self.wheelbase_m, 0.0, -0.85 * self.rear_radius_m];

        let steer = about(down, pose.steer_rad);
        let turn = |point: Point| {
            let arm = std::array::from_fn(|i| point[i] - ground[i]);
            let turned = apply(&steer, arm);
            std::array::from_fn(|i| ground[i] + turned[i])
        };
        let fixed =
            |points: &[Point]| -> Vec<Point> { points.iter().map(|p| apply(&lean, *p)).collect() };
        let steered = |points: &[Point]| -> Vec<Point> {
            points.iter().map(|p| apply(&lean, turn(*p))).collect()
        };
        let bar = |side: f64| [head[0] - 0.05, side * 0.3, head[2] - 0.05];

        let mut lines = ground_lines(pose);
        lines.push(line(
            0,
            0.05,
            TYRE,
            &fixed(&wheel(rear_hub, self.rear_radius_m, 0.0, 32)),
        ));
        lines.push(line(
            2,
            0.008,
            TYRE,
            &fixed(&spokes(rear_hub, self.rear_radius_m, pose.rear_turned_rad)),
        ));
        lines.push(line(
            0,
            0.05,
            TYRE,
            &steered(&wheel(front_hub, self.front_radius_m, 0.0, 32)),
        ));
        lines.push(line(
            2,
            0.008,
            TYRE,
            &steered(&spokes(
                front_hub,
                self.front_radius_m,
                pose.front_turned_rad,
            )),
        ));
        lines.push(line(
            0,
            0.04,
            FRAME,
            &fixed(&[crank, rear_hub, saddle, crank, crown, head, saddle]),
        ));
        lines.push(line(0, 0.035, FORK, &steered(&[front_hub, crown, head])));
        lines.push(line(0, 0.03, FORK, &steered(&[bar(-1.0), head, bar(1.0)])));

        scene::json(at, lines)
    }
}

/// A closed rim in the plane of the frame.
fn wheel(hub: Point, radius_m: f64, turned_rad: f64, parts: u32) -> Vec<Point> {
    (0..=parts)
        .map(|part| {
            let angle = turned_rad + core::f64::consts::TAU * f64::from(part) / f64::from(parts);
            [
                hub[0] + radius_m * libm::cos(angle),
                0.0,
                hub[2] + radius_m * libm::sin(angle),
            ]
        })
        .collect()
}

/// Hub to rim, as pairs of points.
fn spokes(hub: Point, radius_m: f64, turned_rad: f64) -> Vec<Point> {
    wheel(hub, radius_m, turned_rad, 6)
        .into_iter()
        .take(6)
        .flat_map(|rim| [hub, rim])
        .collect()
}

/// A square of ground around the bicycle; the lines stay where they are while it moves.
fn ground_lines(pose: &ScenePose) -> Vec<Line> {
    let reach = 5;
    let first = |at_m: f64| libm::floor(at_m / GRID_M) * GRID_M - at_m;
    let (x0, y0) = (first(pose.x_m), first(pose.y_m));
    let far = f64::from(reach) * GRID_M;
    let mut points: Vec<Point> = Vec::new();
    for step in -reach..=reach {
        let x = x0 + f64::from(step) * GRID_M;
        points.extend([[x, -far, 0.0], [x, far, 0.0]]);
        let y = y0 + f64::from(step) * GRID_M;
        points.extend([[-far, y, 0.0], [far, y, 0.0]]);
    }
    vec![line(2, 0.01, GREY, &points)]
}

fn about_x(angle: f64) -> Rotation {
    let (s, c) = (libm::sin(angle), libm::cos(angle));
    [[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]]
}

fn about_z(angle: f64) -> Rotation {
    let (s, c) = (libm::sin(angle), libm::cos(angle));
    [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]
}

/// Rotation about the unit vector `axis` (Rodrigues).
fn about(axis: Point, angle: f64) -> Rotation {
    let (s, c) = (libm::sin(angle), libm::cos(angle));
    let [x, y, z] = axis;
    let v = 1.0 - c;
    [
        [c + x * x * v, x * y * v - z * s, x * z * v + y * s],
        [y * x * v + z * s, c + y * y * v, y * z * v - x * s],
        [z * x * v - y * s, z * y * v + x * s, c + z * z * v],
    ]
}

fn product(a: Rotation, b: Rotation) -> Rotation {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
}

fn apply(rotation: &Rotation, p: Point) -> Point {
    std::array::from_fn(|i| (0..3).map(|k| rotation[i][k] * p[k]).sum())
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::Value;

    const SHAPE: BicycleShape = BicycleShape {
        wheelbase_m: 1.02,
        steer_axis_tilt_rad: core::f64::consts::PI / 10.0,
        trail_m: 0.08,
        rear_radius_m: 0.3,
        front_radius_m: 0.35,
    };

    fn scene(pose: &ScenePose) -> Value {
        serde_json::from_str(&SHAPE.scene_json(Instant::from_nanos(1_500_000_000), pose))
            .expect("JSON")
    }

    fn points(scene: &Value, line: usize) -> Vec<Point> {
        let list = scene["entities"][0]["lines"][line]["points"]
            .as_array()
            .expect("points");
        list.iter()
            .map(|p| ["x", "y", "z"].map(|k| p[k].as_f64().expect("number")))
            .collect()
    }

    #[test]
    fn upright_and_straight_both_wheels_touch_the_ground() {
        let scene = scene(&ScenePose::default());
        for (line, contact_m) in [(1, 0.0), (3, SHAPE.wheelbase_m)] {
            let rim = points(&scene, line);
            let low = rim.iter().map(|p| p[2]).fold(f64::INFINITY, f64::min);
            assert!(low.abs() < 1e-3, "line {line}: {low}");
            assert!(
                rim.iter()
                    .any(|p| p[2] < 1e-3 && (p[0] - contact_m).abs() < 1e-3)
            );
        }
    }

    #[test]
    fn positive_roll_and_steer_go_to_the_right_which_is_negative_y_in_foxglove() {
        let leaning = scene(&ScenePose {
            roll_rad: 0.3,
            ..ScenePose::default()
        });
        let saddle = points(&leaning, 5)[2];
        assert!(saddle[1] < -0.1 && saddle[2] > 0.5, "{saddle:?}");
        let steering = scene(&ScenePose {
            steer_rad: 0.5,
            ..ScenePose::default()
        });
        let foremost = points(&steering, 3)
            .into_iter()
            .max_by(|a, b| a[0].total_cmp(&b[0]));
        assert!(foremost.expect("points")[1] < -0.05, "{foremost:?}");
        let turned = scene(&ScenePose {
            yaw_rad: 0.5,
            ..ScenePose::default()
        });
        assert!(points(&turned, 6)[0][1] < -0.3);
    }

    #[test]
    fn a_scene_has_the_fields_of_its_schema() {
        let schema: Value = serde_json::from_str(&scene::schema()).expect("schema is JSON");
        let scene = scene(&ScenePose::from_bytes(&f64::NAN.to_le_bytes()));
        let entity = &schema["properties"]["entities"]["items"]["properties"];
        let line = &entity["lines"]["items"]["properties"];
        for (fields, value) in [
            (entity, &scene["entities"][0]),
            (line, &scene["entities"][0]["lines"][0]),
        ] {
            let mut known: Vec<_> = fields.as_object().expect("object").keys().collect();
            let mut used: Vec<_> = value.as_object().expect("object").keys().collect();
            known.sort();
            used.sort();
            assert_eq!(known, used);
        }
    }
}
