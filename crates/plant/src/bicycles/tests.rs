//! Every name loads, every file that is written loads again, and errors say what is accepted.

use super::*;
use crate::multibody::Multibody;

fn none() -> [&'static str; 0] {
    []
}

#[test]
fn every_name_loads_and_survives_its_file() {
    let folder = tempfile::tempdir().unwrap();
    let names = names();
    assert!(names.len() > 15, "{names:?}");
    for name in &names {
        let bicycle = load(name, &none()).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(bicycle.name(), name);
        assert!(
            describe(name).is_some_and(|about| about.len() > 20),
            "{name}"
        );
        let file = folder.path().join(format!("{name}.toml"));
        std::fs::write(&file, bicycle.to_toml()).unwrap();
        let again = load(file.to_str().unwrap(), &none()).unwrap();
        match (&bicycle, &again) {
            (Bicycle::Benchmark(a), Bicycle::Benchmark(b)) => {
                assert_eq!(a.parameters, b.parameters, "{name}");
            }
            (a, b) => assert_eq!(a, b, "{name}"),
        }
        Multibody::new(&load_multibody(name, &none()).unwrap()).unwrap();
    }
}

#[test]
fn sets_take_options_and_assignments() {
    let p = load_multibody(
        "bulsink2017_bicycle1_full:products=tensor,wheel_k=0.47,arms=linear,tyre=bulsink2017_600n",
        &["tyre.front.twisting_gain=0.1", "joints.legs.free = false"],
    )
    .unwrap();
    assert_eq!(p.arms.stiffness_n_m, 525.0);
    assert_eq!(p.frame.inertia_xz_kg_m2, 0.103);
    assert_eq!(p.get("tyre.front.twisting_gain").unwrap(), 0.1);
    assert!(!p.joints.legs.free);
    // Both tyres at once: one after the other would pass through a mixture that is refused.
    let p = load_multibody("bulsink2017_bicycle1_case6", &["tyre=no_slip"]).unwrap();
    assert!(Multibody::new(&p).unwrap().is_no_slip());
    let two = ["tyre.front=no_slip", "tyre.rear=no_slip"];
    assert_eq!(
        load_multibody("bulsink2017_bicycle1_case6", &two).unwrap(),
        p
    );
}

#[test]
fn refusals_name_the_place_and_what_is_accepted() {
    let folder = tempfile::tempdir().unwrap();
    let said = |spec: &str, set: &[&str]| load(spec, set).unwrap_err().to_string();
    let file = folder.path().join("mine.toml");
    let plain = load("bulsink2017_bicycle1_case6", &none())
        .unwrap()
        .to_toml();
    let written = |text: String| {
        std::fs::write(&file, text).unwrap();
        said(file.to_str().unwrap(), &[])
    };
    for (message, parts) in [
        (
            written(plain.replace("trail_m", "trial_m")),
            &["mine.toml", "trial_m", "line"][..],
        ),
        (
            written(plain.replace("wheelbase_m = 1.15", "wheelbase_m = nan")),
            &["mine.toml", "geometry.wheelbase_m", "0.1 to 10"],
        ),
        (
            written(plain.replace("[geometry]", "[geometry")),
            &["mine.toml", "line"],
        ),
        (
            said("nobody2030", &[]),
            &["nobody2030", "bulsink2017_bicycle1_full"],
        ),
        (
            said("bulsink2017_bicycle1_full:arms=long", &[]),
            &["arms=long", "torsional|linear"],
        ),
        (
            said("meijaard2007_tyres:arms=linear", &[]),
            &["arms=linear", "tyre=NAME"],
        ),
        (
            said("meijaard2007_benchmark", &["tyre.front.twisting_gain=0.1"]),
            &["meijaard2007_benchmark", "dotted"],
        ),
        (
            said("bulsink2017_bicycle1_full", &["tyre.front.twistin_gain=1"]),
            &["--set", "twistin_gain"],
        ),
        (
            said("bulsink2017_bicycle1_full", &["geometry.trail_m"]),
            &["geometry.trail_m", "path=value"],
        ),
        (
            said("bulsink2017_bicycle1_full", &["tyre.front=rubber"]),
            &["tyre.front=rubber", "bulsink2017_600n"],
        ),
        (
            said("bulsink2017_bicycle1_full", &["tyre.front=no_slip"]),
            &["both no_slip"],
        ),
    ] {
        for part in parts {
            assert!(message.contains(part), "`{part}` is missing in: {message}");
        }
    }
}
