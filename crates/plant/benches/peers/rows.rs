//! What is measured: our right-hand side and step, alone and in lanes, and the peers'.

use crate::library::Library;
use crate::measure::Row;
use crate::{mapping, mujoco, tree};
use std::cell::RefCell;
use std::hint::black_box;
use std::path::Path;
use std::rc::Rc;
use twinhub_plant::lanes::Lanes;
use twinhub_plant::multibody::{
    BulsinkBicycle, Case, Course, Input, Multibody, Parameters, Reading, Ride, STATES, State,
    advance_lanes, rhs_lanes,
};

/// Step of the plant, s.
pub const STEP_S: f64 = 1.0e-3;
/// Speed of the rides, m/s.
const SPEED_M_S: f64 = 5.0;
/// Steps after which a ride starts again: nobody steers.
const AGAIN: usize = 200;
/// Largest difference of accelerations, relative, that is taken for the same tree.
pub const SAME_TREE: f64 = 1.0e-9;
/// Largest difference of any coordinate (m, rad) to MuJoCo after half a second from the same
/// disturbed start that is taken for the same motion: both integrate the attitude in their own way.
pub const SAME_MOTION: f64 = 1.0e-4;
/// Random states in which accelerations are compared.
const COMPARED_STATES: usize = 200;
/// Steps of the comparison of motions.
const COMPARED_STEPS: usize = 500;

/// What is known of a peer.
pub struct Peer {
    pub name: &'static str,
    /// Its version and how far it is from ours, or why it is not there.
    pub found: Result<(String, f64), String>,
    pub accepted: f64,
    pub what: &'static str,
}

/// Everything to be measured.
pub struct Bench {
    pub rows: Vec<Row>,
    pub peers: Vec<Peer>,
    /// Parts into which our step was divided.
    pub parts: usize,
}

/// The full model: 14 degrees of freedom, tyres, springs, linear arms.
pub fn parameters() -> Parameters {
    let reading = Reading {
        linear_arms: true,
        ..Reading::default()
    };
    Parameters::bulsink2017(BulsinkBicycle::One, Case::Full, &reading)
}

fn row(
    name: &'static str,
    about: &'static str,
    results: usize,
    run: impl Fn(usize) + 'static,
) -> Row {
    Row {
        name,
        about,
        results,
        run: Box::new(run),
    }
}

/// Rides `count` steps, from the start again and again.
fn rounds(count: usize, mut ride: impl FnMut(usize)) {
    let mut left = count;
    while left > 0 {
        let steps = left.min(AGAIN);
        ride(steps);
        left -= steps;
    }
}

fn lanes_rhs<const N: usize>(model: Rc<Multibody>, state: State, input: Input) -> impl Fn(usize) {
    let x: State<Lanes<N>> = state.map(|v| Lanes([v; N]));
    let input: Input<Lanes<N>> = input.lifted();
    move |count| {
        let mut dx = [Lanes([0.0; N]); STATES];
        for _ in 0..count {
            rhs_lanes(&model, black_box(&x), black_box(&input), None, &mut dx);
            black_box(&mut dx);
        }
    }
}

fn lanes_step<const N: usize>(model: Rc<Multibody>, state: State, input: Input) -> impl Fn(usize) {
    let start: State<Lanes<N>> = state.map(|v| Lanes([v; N]));
    let input: Input<Lanes<N>> = input.lifted();
    move |count| {
        rounds(count, |steps| {
            let mut x = start;
            advance_lanes(&model, &mut x, &input, None, STEP_S, steps);
            black_box(&mut x);
        });
    }
}

impl Bench {
    /// Our rows, and those of the peers that are in `folder`; compares their physics with ours, or
    /// only puts them into a state.
    pub fn new(p: &Parameters, folder: Option<&Path>, compare: bool) -> Self {
        let ride = Ride::new(p, None, SPEED_M_S).expect("the published bicycle rides straight");
        let model = Rc::new(ride.model().clone());
        let (state, input) = (*ride.state(), *ride.input());
        let mut rows = vec![row("rhs", "right-hand side with tyres", 1, {
            let model = model.clone();
            move |count| {
                let mut dx = [0.0; STATES];
                for _ in 0..count {
                    model.rhs(black_box(&state), black_box(&input), None, &mut dx);
                    black_box(&mut dx);
                }
            }
        })];
        rows.push(row(
            "rhs_4_lanes",
            "the same, 4 SIMD lanes",
            4,
            lanes_rhs::<4>(model.clone(), state, input),
        ));
        rows.push(row(
            "rhs_8_lanes",
            "the same, 8 SIMD lanes",
            8,
            lanes_rhs::<8>(model.clone(), state, input),
        ));
        let parts = ride.parts(STEP_S);
        let moving = RefCell::new(ride.clone());
        rows.push(row(
            "step",
            "RK4 step of 1 ms with tyres",
            1,
            move |count| {
                let mut ride = moving.borrow_mut();
                rounds(count, |steps| {
                    ride.set_state(&state);
                    for _ in 0..steps {
                        ride.advance(black_box(&input), STEP_S);
                    }
                });
                black_box(ride.state());
            },
        ));
        let still = ride
            .model()
            .steady(&Course::straight(SPEED_M_S), None)
            .expect("rides straight");
        let of_map = model.clone();
        rows.push(row(
            "map_point",
            "steady state and lateral eigenvalues",
            1,
            move |count| {
                let mut last = still.clone();
                for k in 0..count {
                    let course = Course::pair(SPEED_M_S + 0.01 * (k % 50) as f64, 20.0);
                    last = of_map
                        .steady(&course, Some(&last))
                        .expect("a steady state nearby");
                    black_box(of_map.lateral_eigenvalues(&last));
                }
            },
        ));
        rows.push(row(
            "step_4_lanes",
            "the same, 4 SIMD lanes",
            4,
            lanes_step::<4>(model.clone(), state, input),
        ));
        rows.push(row(
            "step_8_lanes",
            "the same, 8 SIMD lanes",
            8,
            lanes_step::<8>(model, state, input),
        ));
        let mut peers = Vec::new();
        for (name, what, accepted) in [
            (
                "pinocchio",
                "accelerations, relative, 200 random states",
                SAME_TREE,
            ),
            (
                "mujoco",
                "any coordinate after 0.5 s, m and rad",
                SAME_MOTION,
            ),
        ] {
            let found = folder
                .ok_or_else(|| "no --peers FOLDER given".to_owned())
                .and_then(|folder| Library::open(folder, name))
                .and_then(|library| match name {
                    "pinocchio" => pinocchio(p, library, compare, &mut rows),
                    _ => with_mujoco(p, &ride, library, compare, &mut rows),
                });
            peers.push(Peer {
                name,
                found,
                accepted,
                what,
            });
        }
        Self { rows, peers, parts }
    }
}

fn pinocchio(
    p: &Parameters,
    mut library: Library,
    compare: bool,
    rows: &mut Vec<Row>,
) -> Result<(String, f64), String> {
    library.build(&tree::json(p).to_string(), None)?;
    let difference =
        mapping::difference_to_pinocchio(p, &library, if compare { COMPARED_STATES } else { 1 });
    rows.push(row(
        "pinocchio_aba",
        "Pinocchio aba, bare tree",
        1,
        library.repeated("aba"),
    ));
    rows.push(row(
        "pinocchio_aba_world",
        "the same, its world convention",
        1,
        library.repeated("aba_world"),
    ));
    Ok((library.version(), difference))
}

fn with_mujoco(
    p: &Parameters,
    ride: &Ride,
    mut library: Library,
    compare: bool,
    rows: &mut Vec<Row>,
) -> Result<(String, f64), String> {
    library.build(&tree::mjcf(p, STEP_S), Some(&mujoco::tyres(p)?))?;
    let steps = if compare { COMPARED_STEPS } else { 1 };
    let (difference, steered) = mapping::difference_to_mujoco(ride, steps, STEP_S, &library);
    if compare && steered < 0.01 {
        return Err(format!("the comparison hardly steered: {steered} rad"));
    }
    let library = Rc::new(library);
    let (state, input) = (*ride.state(), *ride.input());
    let forward = library.repeated("forward");
    let own = library.clone();
    rows.push(row(
        "mujoco_forward",
        "MuJoCo mj_forward with tyres",
        1,
        move |count| {
            mapping::set_mujoco(&state, &input, &own);
            forward(count);
        },
    ));
    let (step, own) = (library.repeated("step"), library.clone());
    rows.push(row(
        "mujoco_step",
        "MuJoCo RK4 step of 1 ms with tyres",
        1,
        move |count| {
            rounds(count, |steps| {
                mapping::set_mujoco(&state, &input, &own);
                step(steps);
            });
        },
    ));
    Ok((library.version(), difference))
}
