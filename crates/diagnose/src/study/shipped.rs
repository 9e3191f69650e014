//! Studies that ship inside the binary. Their rides are the publishers' and do not.

/// Names of the studies.
pub const NAMES: &[&str] = &[
    "davis_instrumented_105",
    "delft_steer_by_wire",
    "davis_robot_bicycle",
    "delft_balance_assist",
];

/// The text of a study.
pub fn text(name: &str) -> Option<&'static str> {
    match name {
        "davis_instrumented_105" => Some(include_str!("../../studies/davis_instrumented_105.toml")),
        "delft_steer_by_wire" => Some(include_str!("../../studies/delft_steer_by_wire.toml")),
        "davis_robot_bicycle" => Some(include_str!("../../studies/davis_robot_bicycle.toml")),
        "delft_balance_assist" => Some(include_str!("../../studies/delft_balance_assist.toml")),
        _ => None,
    }
}
