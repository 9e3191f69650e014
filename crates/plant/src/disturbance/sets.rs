//! Named disturbances. Sizes without a publication are examples, chosen by us.

use super::{
    Disturbance, Gust, HalfSine, HandlebarPull, Kick, MultisineForce, Place, Push, RigMultisine,
    SideForce, Step,
};

/// Every named disturbance with one sentence; every kind of the registry occurs.
pub fn all() -> [(&'static str, &'static str, Disturbance); 11] {
    let rig = |amplitude_m| {
        Disturbance::RigMultisine(RigMultisine {
            amplitude_m,
            slope: 1.0,
            duration_s: 100.0,
            fade_s: 1.0,
        })
    };
    let frame = Place::FrameCentre {};
    let saddle = Place::Saddle {};
    [
        (
            "bulsink2017_push",
            "0.1 N for 0.1 s at the rear frame's centre of mass, as in the thesis's linearisation",
            Disturbance::Push(Push {
                force_n: 0.1,
                duration_s: 0.1,
                place: frame,
            }),
        ),
        (
            "bulsink2017_rig_young",
            "the rig's platform with 1.75 cm, as for young riders",
            rig(0.0175),
        ),
        (
            "bulsink2017_rig_older",
            "the rig's platform with 1.25 cm, as for older riders",
            rig(0.0125),
        ),
        (
            "rig_as_force",
            "the rig's lines as a force of up to 40 N at the frame's centre of mass",
            Disturbance::MultisineForce(MultisineForce {
                force_n: 40.0,
                slope: 1.0,
                duration_s: 100.0,
                fade_s: 1.0,
                place: frame,
            }),
        ),
        (
            "shoulder_bump",
            "half a sine of 80 N and 0.3 s at the saddle",
            Disturbance::HalfSine(HalfSine {
                force_n: 80.0,
                duration_s: 0.3,
                place: saddle,
            }),
        ),
        (
            "lean_on_rider",
            "10 N at the saddle that stay",
            Disturbance::Step(Step {
                force_n: 10.0,
                place: saddle,
            }),
        ),
        (
            "kick",
            "an impulse of 8 N s within 50 ms near the rear hub",
            Disturbance::Kick(Kick {
                impulse_n_s: 8.0,
                duration_s: 0.05,
                place: Place::Point {
                    x_m: 0.0,
                    height_m: 0.35,
                },
            }),
        ),
        (
            "rough_ride",
            "random side force of 20 N rms between 0.1 and 3 Hz at the frame's centre of mass",
            Disturbance::SideForce(SideForce {
                rms_n: 20.0,
                low_hz: 0.1,
                high_hz: 3.0,
                lines: 24,
                duration_s: 3600.0,
                fade_s: 1.0,
                place: frame,
            }),
        ),
        (
            "side_gust",
            "a side wind of 8 m/s for 1.5 s at 5 m/s (side-force area 0.8 m², a guess)",
            Disturbance::Gust(Gust {
                wind_m_s: 8.0,
                duration_s: 1.5,
                speed_m_s: 5.0,
                side_area_m2: 0.8,
                air_density_kg_m3: 1.2,
                place: Place::Point {
                    x_m: 0.4,
                    height_m: 1.0,
                },
            }),
        ),
        (
            "bar_pull_right",
            "5 Nm at the handlebar for 0.2 s",
            Disturbance::HandlebarPull(HandlebarPull {
                torque_nm: 5.0,
                duration_s: 0.2,
            }),
        ),
        (
            "saddle_push",
            "50 N for 0.2 s at the saddle",
            Disturbance::Push(Push {
                force_n: 50.0,
                duration_s: 0.2,
                place: saddle,
            }),
        ),
    ]
}

/// The disturbance called `name`.
pub fn named(name: &str) -> Option<Disturbance> {
    all()
        .into_iter()
        .find(|(n, _, _)| *n == name)
        .map(|(_, _, d)| d)
}
