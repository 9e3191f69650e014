//! Bad input ends in exit code 2 and a message that names the file and the place.

use std::path::Path;
use std::process::Command;

/// Runs `twinhub` and returns what it said on its way out.
fn refused(dir: &Path, arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_twinhub"))
        .args(arguments)
        .current_dir(dir)
        .env_remove("TWINHUB_DATA")
        .output()
        .expect("starts");
    let words = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {words}");
    assert!(
        output.stdout.is_empty(),
        "no result beside the error: {arguments:?}"
    );
    words
}

fn write(dir: &Path, name: &str, text: &str) {
    std::fs::write(dir.join(name), text).expect("written");
}

fn expect(words: &str, parts: &[&str]) {
    for part in parts {
        assert!(words.contains(part), "`{part}` is missing in: {words}");
    }
}

const COURSE: &str = include_str!("../../sim/courses/first_ride.toml");

#[test]
fn courses() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let dir = dir.path();
    write(
        dir,
        "typo.toml",
        &COURSE.replace("duration_s", "duration_ms"),
    );
    expect(
        &refused(dir, &["ride", "typo.toml"]),
        &["typo.toml", "line 3", "duration_ms", "duration_s"],
    );
    write(
        dir,
        "absurd.toml",
        &COURSE.replace("speed_m_s = 7.0", "speed_m_s = 700.0"),
    );
    expect(
        &refused(dir, &["ride", "absurd.toml"]),
        &["absurd.toml", "speed.2.speed_m_s", "700", "0.3 to 20"],
    );
    write(
        dir,
        "nan.toml",
        &COURSE.replace("duration_s = 60.0", "duration_s = nan"),
    );
    expect(
        &refused(dir, &["ride", "nan.toml"]),
        &["nan.toml", "duration_s", "NaN"],
    );
    write(dir, "broken.toml", "schema_version = 1\nabout = \n");
    expect(
        &refused(dir, &["ride", "broken.toml"]),
        &["broken.toml", "line 2"],
    );
    expect(
        &refused(dir, &["ride", "missing.toml"]),
        &["missing.toml", "first_ride"],
    );
    expect(
        &refused(dir, &["ride", "--set", "seed"]),
        &["seed", "path=value"],
    );
    expect(
        &refused(dir, &["ride", "--set", "wind=3"]),
        &["wind", "duration_s"],
    );
}

#[test]
fn bicycles() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let dir = dir.path();
    expect(
        &refused(dir, &["modes", "--bicycle", "unicycle"]),
        &["unicycle", "meijaard2007_benchmark"],
    );
    write(dir, "BadBenchmark.txt", "w = 1.0+/-0.1\nc = much\n");
    expect(
        &refused(dir, &["modes", "--bicycle", "BadBenchmark.txt"]),
        &["BadBenchmark.txt", "line 2", "much"],
    );
    write(dir, "RiderBenchmark.txt", "IBxx = 8.0\nmB = 72.0\n");
    expect(
        &refused(dir, &["modes", "--bicycle", "RiderBenchmark.txt"]),
        &["RiderBenchmark.txt", "rF"],
    );
    expect(&refused(dir, &["modes", "--set", "mB=-3"]), &["mB", "-3"]);
    expect(&refused(dir, &["modes", "--set", "mB=nan"]), &["mB"]);
    expect(
        &refused(dir, &["modes", "--speeds-m-s", "0:10"]),
        &["A:B:STEP"],
    );
}

#[test]
fn multibody_bicycles_and_scenarios() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let dir = dir.path();
    let full = "bulsink2017_bicycle1_full";
    let modes = |more: &[&str]| {
        let mut arguments = vec!["modes", "--bicycle", full];
        arguments.extend(more);
        refused(dir, &arguments)
    };
    expect(
        &modes(&["--set", "tyre.front.twistin_gain=1"]),
        &["tyre.front.twistin_gain"],
    );
    expect(
        &modes(&["--set", "frame.mass_kg=-1"]),
        &["frame.mass_kg", "0 to 10,000"],
    );
    expect(&modes(&["--roll-deg", "95"]), &["--roll-deg", "-60 to 60"]);
    expect(&modes(&["--speeds-m-s", "0:0:1"]), &["0.05 to 60"]);
    expect(
        &refused(dir, &["modes", "--sensitivities"]),
        &["meijaard2007_benchmark", "multibody"],
    );
    write(dir, "plant.toml", "gravity_m_s2 = 9.81\nwheels = 3\n");
    expect(
        &refused(dir, &["modes", "--bicycle", "plant.toml"]),
        &["plant.toml", "line 2", "wheels"],
    );
    write(dir, "run.toml", "schema_version = 1\nabout = 3\n");
    expect(
        &refused(dir, &["simulate", "run.toml"]),
        &["run.toml", "line 2"],
    );
    expect(
        &refused(
            dir,
            &["simulate", "push_7ms_off", "--set", "start.speed_m_s=99"],
        ),
        &["start.speed_m_s", "0.3 to 15"],
    );
    expect(
        &refused(
            dir,
            &["simulate", "push_7ms_off", "--csv", "nowhere/rows.csv"],
        ),
        &["nowhere/rows.csv"],
    );
    expect(&refused(dir, &["bicycle", "unicycle"]), &["unicycle", full]);
}

#[test]
fn studies() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let dir = dir.path();
    expect(
        &refused(dir, &["compare", "none.toml"]),
        &["none.toml", "davis_instrumented_105"],
    );
    expect(
        &refused(dir, &["compare", "davis_instrumented_105"]),
        &["run105_0-40s.csv.gz", "--data", "TWINHUB_DATA"],
    );
    let study = "schema_version = 1\nname = \"x\"\n[bicycle]\nmodel = \"benchmark\"\n\
        parameters = \"meijaard2007_benchmark\"\ntolerance_ratio = 0.02\n\
        [[ride]]\nfile = \"a.csv\"\nuse = \"fit\"\nrider = \"none\"\nhands = \"off\"\nground = \"road\"\n\
        time = { column = \"t\" }\n\
        [[ride.channel]]\ncolumn = \"v\"\nquantity = \"speed_m_s\"\nrole = \"input\"\n\
        [[ride.channel]]\ncolumn = \"p\"\nquantity = \"roll_rad\"\nrole = \"output\"\n";
    write(
        dir,
        "unit.toml",
        &study.replace("\"roll_rad\"", "\"roll_deg\""),
    );
    expect(
        &refused(dir, &["compare", "unit.toml"]),
        &["unit.toml", "roll_deg", "roll_rad"],
    );
    write(dir, "key.toml", &study.replace("ground", "grund"));
    expect(
        &refused(dir, &["compare", "key.toml"]),
        &["key.toml", "grund", "line"],
    );
    write(dir, "study.toml", study);
    let mut csv = String::from("t,v,p\n");
    for i in 0..400 {
        csv += &format!("{},5.0,0.001\n", f64::from(i) * 0.01);
    }
    write(dir, "a.csv", &csv.replace("0.05,5.0,", "0.05,fast,"));
    expect(
        &refused(dir, &["compare", "study.toml"]),
        &["a.csv", "line 7", "fast"],
    );
}

#[test]
fn names() {
    let dir = tempfile::tempdir().expect("temporary directory");
    expect(
        &refused(dir.path(), &["explain", "nothing"]),
        &["nothing", "twinhub list"],
    );
    expect(
        &refused(dir.path(), &["list", "wheels"]),
        &["wheels", "courses"],
    );
    expect(
        &refused(dir.path(), &["tyre", "--model", "square"]),
        &["square", "magic_formula"],
    );
    refused(dir.path(), &["no-such-command"]);
}
