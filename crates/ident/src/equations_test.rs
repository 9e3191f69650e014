//! Signs by physics, and the sensors' filters against their frequency response.

use crate::equations::*;
use crate::ride::{NoiseLevel, Output, Ride, Sensor};
use crate::signal::Signal;
use twinhub_linear::{Bicycle, MotorPair};

fn sensor(output: Output) -> Sensor {
    Sensor {
        output,
        samples: vec![],
        noise: NoiseLevel::Known(1.0),
        bias_sd: 0.0,
        delay_s: 0.0,
        quantum: 0.0,
        lag_s: 0.0,
        moving_average_s: 0.0,
    }
}

fn ride(sensors: Vec<Sensor>) -> Ride {
    Ride {
        speed: Signal::constant(5.0),
        front_brake: None,
        rear_traction: None,
        drives: vec![],
        laws: vec![],
        sensors,
        windows: vec![],
        clock_jitter_sd_s: 0.0,
    }
}

fn benchmark() -> Equations {
    Equations::new(&Bicycle::load("meijaard2007_benchmark").unwrap()).unwrap()
}

#[test]
fn signs_by_physics() {
    let equations = benchmark();
    let bare = ride(vec![]);
    let layout = Layout::new(&bare);
    let still = equations.matrices(&bare, &layout, 0.0, MotorPair::OFF, true);
    assert!(
        still.a[2 * 4] > 0.0,
        "leaning right and standing still it falls right"
    );
    let [roll, steer] = equations.side_force_arm_m(0.3, -0.9);
    assert!(
        roll == 0.9 && steer > 0.0,
        "pushed right above the ground it rolls right, and steers right through the trail"
    );
    let readings = ride(vec![
        sensor(Output::YawRate),
        sensor(Output::LateralAccel { x_m: 0.0, z_m: 0.0 }),
    ]);
    let layout = Layout::new(&readings);
    let moving = equations.matrices(&readings, &layout, 5.0, MotorPair::OFF, true);
    let yaw = equations.reading(&readings, &layout, &moving, 0, 5.0);
    assert!(yaw.state[1] > 0.0, "steered right it turns right");
    let accel = equations.reading(&readings, &layout, &moving, 1, 5.0);
    assert!(
        (accel.state[0] + 9.81).abs() < 1e-12,
        "leaning right the accelerometer reads gravity to its left"
    );
    assert!(
        (accel.state[1] - 5.0 * yaw.state[1]).abs() < 1e-12,
        "steered right it reads the turn's acceleration"
    );
}

/// The running mean's filter against its exact frequency response (1 - exp(-j w T))/(j w T).
#[test]
fn running_mean() {
    let t = 0.3;
    let equations = benchmark();
    let averaged = ride(vec![Sensor {
        moving_average_s: t,
        ..sensor(Output::Roll)
    }]);
    let layout = Layout::new(&averaged);
    let n = layout.states;
    let a = equations
        .matrices(&averaged, &layout, 5.0, MotorPair::OFF, true)
        .a;
    for (turn, in_gain, in_phase_deg) in
        [(0.5, 0.002, 0.1), (1.0, 0.002, 0.1), (2.0, 0.012, 1.1f64)]
    {
        let omega = turn / t;
        // z1' = z2, z2' = k u - k z1 - d z2.
        let (k_in, k, d) = (
            a[(n - 1) * n],
            -a[(n - 1) * n + n - 2],
            -a[(n - 1) * n + n - 1],
        );
        let (re, im) = (k - omega * omega, d * omega);
        let gain = k_in / libm::hypot(re, im);
        let phase = -libm::atan2(im, re);
        let half = 0.5 * omega * t;
        assert!(
            (gain / (libm::sin(half) / half) - 1.0).abs() < in_gain,
            "gain {gain} at {omega}"
        );
        assert!(
            (phase + half).abs() < in_phase_deg.to_radians(),
            "phase {phase} at {omega}"
        );
    }
}
