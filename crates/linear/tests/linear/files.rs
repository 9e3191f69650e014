//! Bicycle files of one's own.

use crate::built_in;
use std::path::Path;
use twinhub_linear::Bicycle;

#[test]
fn a_bicycle_file_is_read_back_without_loss() {
    let (mut bicycle, _) = built_in("bulsink2017_bicycle2");
    bicycle.standard_deviations.insert("c", 0.001);
    let again = Bicycle::from_toml(&bicycle.to_toml(), Path::new("b.toml")).unwrap();
    assert_eq!(again.parameters, bicycle.parameters);
    assert_eq!((again.name, again.source), (bicycle.name, bicycle.source));
    assert_eq!(again.standard_deviations["c"], 0.001);
}

#[test]
fn a_bad_bicycle_file_is_refused_with_its_place() {
    let good = built_in("meijaard2007_benchmark").0.to_toml();
    for (from, to, parts) in [
        (
            "mB = 85.0",
            "mB = 85.0\nmass_of_b = 3.0",
            vec!["line", "column", "mass_of_b"],
        ),
        (
            "mB = 85.0",
            "mB = \"heavy\"",
            vec!["line", "column", "heavy"],
        ),
        ("mB = 85.0\n", "", vec!["mB"]),
        (
            "mB = 85.0",
            "mB = -85.0",
            vec!["mB", "-85", "at least 0 kg"],
        ),
        ("mB = 85.0", "mB = nan", vec!["mB", "finite"]),
        (
            "schema_version = 1",
            "schema_version = 2",
            vec!["schema_version", "accepted: 1"],
        ),
        (
            "schema_version = 1",
            "schema_version = 1\ncolour = \"red\"",
            vec!["line", "column", "colour"],
        ),
        (
            "[parameters]",
            "[standard_deviations]\nxx = 1.0\n[parameters]",
            vec!["xx", "IBxx"],
        ),
        (
            "[parameters]",
            "[standard_deviations]\nw = -1.0\n[parameters]",
            vec!["`w`", "-1"],
        ),
    ] {
        assert!(good.contains(from), "{from}");
        let message = Bicycle::from_toml(&good.replacen(from, to, 1), Path::new("my.toml"))
            .unwrap_err()
            .to_string();
        for part in parts.into_iter().chain(["my.toml"]) {
            assert!(message.contains(part), "{to}: `{message}` lacks `{part}`");
        }
    }
}
