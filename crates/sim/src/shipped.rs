//! Courses, riders and laws that ship with the program, by name.

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
pub const COURSES: &[Shipped] = shipped!("../courses/": "first_ride");
/// Riders that ship.
pub const RIDERS: &[Shipped] = shipped!("../riders/": "older_6_to_7");
/// Laws that ship.
pub const LAWS: &[Shipped] = shipped!("../../control/laws/": "off", "constant", "scheduled");
/// Scenarios that ship.
pub const SCENARIOS: &[Shipped] = shipped!("../scenarios/": "push_7ms_off", "push_7ms_pair", "push_7ms_pair_until_20s",
    "corner_off", "corner_front", "corner_rear", "past_friction", "pedalling", "rig");

/// The names in a table.
pub fn names(table: &[Shipped]) -> Vec<&'static str> {
    table.iter().map(|file| file.name).collect()
}
