//! Courses, riders, laws, roads and winds that ship with the program, by name.

/// A file that is built into the program.
#[derive(Clone, Copy, Debug)]
pub struct Shipped {
    /// The name that a course or the command line gives.
    pub name: &'static str,
    /// The TOML text.
    pub text: &'static str,
}

macro_rules! shipped {
    ($folder:literal : $($name:literal),* $(,)?) => {
        &[$(Shipped { name: $name, text: include_str!(concat!($folder, $name, ".toml")) }),*]
    };
}

/// Courses that ship.
pub const COURSES: &[Shipped] = shipped!("../courses/": "three_to_eight", "first_ride");
/// The course that is ridden if none is named.
pub const DEFAULT_COURSE: &str = "three_to_eight";
/// Riders that ship.
pub const RIDERS: &[Shipped] = shipped!("../riders/":
    "young", "older", "young_firm", "older_firm", "older_6_to_7",
    "bulsink2017_steer_torque_young", "bulsink2017_steer_torque_older",
    "bulsink2017_steer_angle_young", "bulsink2017_steer_angle_older",
    "bulsink2017_trunk_lean_young", "bulsink2017_trunk_lean_older",
);
/// Laws that ship.
pub const LAWS: &[Shipped] = shipped!("../../control/laws/": "off", "constant", "constant_80_nm", "scheduled", "scheduled_20_nm", "scheduled_low_energy",
        "roll_steer_feedback", "steering_spring", "steering_motor");
/// Scenarios that ship.
pub const SCENARIOS: &[Shipped] = shipped!("../scenarios/": "push_7ms_off", "push_7ms_pair", "push_7ms_pair_until_20s",
    "corner_off", "corner_front", "corner_rear", "past_friction", "pedalling", "rig");

/// Roads that ship.
pub const ROADS: &[Shipped] = shipped!("../roads/": "dry", "wet", "leaves", "rough");
/// Winds that ship.
pub const WINDS: &[Shipped] = shipped!("../winds/": "still", "gusty");

/// The names in a table.
pub fn names(table: &[Shipped]) -> Vec<&'static str> {
    table.iter().map(|file| file.name).collect()
}

#[cfg(test)]
mod tests {
    use crate::setup::load_rider;
    use twinhub_plant::bicycles::load_multibody;
    use twinhub_plant::multibody::Multibody;
    use twinhub_plant::rider::closed_loop::stability;
    use twinhub_plant::rider::presets::{BICYCLE, PRESETS};
    use twinhub_plant::rider::published::{self, Group, Table};

    #[test]
    fn published_riders_ship_as_they_are_printed() {
        for table in Table::ALL {
            for group in Group::ALL {
                let name = format!("bulsink2017_{}_{}", table.channel(), group.name());
                let shipped = load_rider(&name).expect("ships");
                assert_eq!(shipped, published::rider(table, group), "{name}");
            }
        }
    }

    #[test]
    fn designed_riders_stay_up_from_3_to_8_m_s_without_and_with_the_pair() {
        let none: [&str; 0] = [];
        let bicycle = load_multibody(BICYCLE, &none).expect("ships");
        let model = Multibody::new(&bicycle).expect("valid");
        // Between the rows of the gain table too.
        let speeds: Vec<f64> = (0..=20).map(|i| 3.0 + 0.25 * f64::from(i)).collect();
        for preset in PRESETS {
            let rider = load_rider(preset.name).expect("ships");
            let delay = rider.rider.linear(3.0)[0].delay_s;
            assert_eq!(delay, preset.delay_s, "{}", preset.name);
            for pair_nm in [0.0, 20.0, 40.0] {
                for at in stability(&model, &rider, pair_nm, &speeds).expect("steady") {
                    assert!(at.growth_per_s < -0.1, "{}: {at:?}", preset.name);
                }
            }
        }
    }
}
