//! Prints the page of two made-up rides, to look at: `sample_ride_page > page.html`.

use twinhub_report::ride::{Ride, RidePage, Signals, Stretch, ride_page};

/// A made-up ride: a swaying bicycle, pushed at 20 s.
fn ride(name: &str, damping_1_s: f64, torque_nm: f64, end_s: f64) -> Ride {
    let mut s = Signals::default();
    for k in 0..(end_s * 1000.0) as u32 {
        let t = f64::from(k) * 1e-3;
        let since = (t - 20.0).max(0.0);
        let push = if t > 20.0 {
            0.12 * (-damping_1_s * since).exp() * (5.0 * since).sin()
        } else {
            0.0
        };
        let noise = 0.012 * (3.1 * t).sin() * (0.37 * t).cos() + 0.002 * (91.0 * t).sin();
        let ramp = ((t - 2.0) / 3.0).clamp(0.0, 1.0);
        s.t_s.push(t);
        s.roll_rad.push(noise + push);
        s.steer_rad.push(-1.4 * push + 0.5 * noise);
        s.rider_torque_nm.push(-12.0 * push + 40.0 * noise);
        s.speed_m_s.push(6.0 + (t / 60.0) + 0.02 * (2.0 * t).sin());
        s.front_brake_nm.push(torque_nm * ramp);
        s.rear_traction_nm
            .push(torque_nm * ramp + 4.0 * ramp.min(torque_nm) * (0.8 * t).sin());
    }
    let rms = |v: &[f64]| (v.iter().map(|x| x * x).sum::<f64>() / v.len() as f64).sqrt();
    Ride {
        name: name.into(),
        fell: false,
        roll_rms_rad: rms(&s.roll_rad),
        steer_rms_rad: rms(&s.steer_rad),
        rider_effort_rms_nm: rms(&s.rider_torque_nm),
        energy_j: 100.0 + 30.0 * torque_nm,
        distance_m: 390.0,
        ticks: s.t_s.len() as u64,
        missed_ticks: 0,
        digest: "5b4ad93f4b5c4e18f2cdc6b6be85e97c".into(),
        log: format!("rides/first_{}.mcap", name.replace(' ', "_")),
        signals: s,
    }
}

fn main() {
    let page = RidePage {
        title: "Sample: first ride, 6 to 7 m/s".into(),
        lead: "made-up signals, to look at the page".into(),
        rides: vec![
            ride("stabilizer off", 0.25, 0.0, 60.0),
            ride("stabilizer on", 0.6, 30.0, 60.0),
        ],
        stretches: vec![
            Stretch {
                from_s: 20.0,
                to_s: 20.4,
                name: "push 80 N".into(),
            },
            Stretch {
                from_s: 35.0,
                to_s: 45.0,
                name: "gusts".into(),
            },
        ],
        no_slip: true,
        notes: vec![],
        provenance: [
            ("version", "0.1.0"),
            ("commit", "abcdef0"),
            ("seed", "7"),
            ("configuration digest", "af1349b9f5f9a1a6a0404dea36dcc949"),
        ]
        .map(|(k, v)| (k.to_string(), v.to_string()))
        .into(),
        config_text: "seed = 7\nduration_s = 60.0\n".into(),
        commands: vec![
            "twinhub modes --bicycle bulsink2017_bicycle1".into(),
            "twinhub ride --torque-nm 20".into(),
        ],
    };
    print!("{}", ride_page(&page));
}
