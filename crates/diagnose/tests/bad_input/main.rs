//! Bad studies and bad rides: every message names the file and the place.

mod good;

use good::*;
use std::io::Write as _;
use twinhub_diagnose::data::{DataFolders, read_ride};
use twinhub_diagnose::study::Study;

#[test]
fn the_good_study_is_good() {
    let rides = complaint("good", STUDY, &rows()).unwrap();
    assert_eq!(rides[0].channels[2].samples.len(), 200);
}

#[test]
fn studies_are_refused_with_file_and_line() {
    for (case, from, to, line, parts) in [
        (
            "key",
            "use = \"fit\"",
            "use = \"fit\"\nwind = 3",
            11,
            &["wind", "expected one of", "windows"][..],
        ),
        (
            "syntax",
            "name = \"small\"",
            "name = \"small",
            2,
            &["small.toml"],
        ),
        ("type", "IBxx = 9.2", "IBxx = \"heavy\"", 7, &["string"]),
        (
            "quantity",
            "quantity = \"roll_rad\"",
            "quantity = \"roll_deg\"",
            24,
            &["roll_deg", "roll_rad"],
        ),
        (
            "role",
            "role = \"output\"",
            "role = \"outptu\"",
            25,
            &["outptu", "check"],
        ),
        (
            "input",
            "quantity = \"lateral_force_n\"",
            "quantity = \"crank_angle_rad\"",
            19,
            &["crank_angle_rad", "steer_torque_nm"],
        ),
        ("symbol", "IBxx = 9.2", "IByx = 9.2", 7, &["IByx", "IBxx"]),
        ("absurd", "IBxx = 9.2", "mB = -85.0", 7, &["mB", "-85"]),
        ("nan", "IBxx = 9.2", "IBxx = nan", 7, &["IBxx", "NaN"]),
        (
            "inf",
            "arm_m = [0.9, 0.01]",
            "arm_m = [inf, 0.01]",
            21,
            &["arm_m", "inf"],
        ),
        (
            "arm",
            "arm_m = [0.9, 0.01]\n",
            "",
            17,
            &["lateral_force_n", "point_m"],
        ),
        (
            "set",
            "meijaard2007_benchmark",
            "meijard",
            5,
            &["meijard", "meijaard2007_benchmark"],
        ),
        (
            "window",
            "[0.0, 1.0]",
            "[1.0, 0.0]",
            12,
            &["[1, 0]", "a < b"],
        ),
        (
            "order",
            "{ s = [0.0, 1.0] }",
            "{ s = [0.5, 1.0] }, { s = [0.2, 0.4] }",
            12,
            &["ends at 1", "overlapping"],
        ),
        (
            "outside",
            "[0.0, 1.0]",
            "[0.0, 3.0]",
            12,
            &["[0, 3]", "inside the data"],
        ),
        (
            "noise",
            "role = \"output\"",
            "role = \"output\"\nnoise_sd = 0.0",
            26,
            &["noise_sd = 0", "above 0"],
        ),
        (
            "scale",
            "role = \"output\"",
            "role = \"output\"\nscale = nan",
            26,
            &["scale = NaN", "finite"],
        ),
        (
            "time",
            "{ column = \"t_s\" }",
            "{ column = \"t_s\", rate_hz = 10.0 }",
            11,
            &["either"],
        ),
        (
            "version",
            "schema_version = 1",
            "schema_version = 2",
            1,
            &["schema_version = 2", "accepted: 1"],
        ),
        (
            "speed",
            "quantity = \"speed_m_s\"",
            "quantity = \"roll_torque_nm\"",
            8,
            &["speed_m_s"],
        ),
        (
            "tolerance",
            "[bicycle.values]",
            "[bicycle.tolerances]\nIBxx = { ratio = -0.1 }\n[bicycle.values]",
            7,
            &["ratio", "above zero"],
        ),
        (
            "column",
            "column = \"roll\"",
            "column = \"rol\"",
            23,
            &["`rol`", "ride.csv", "t_s, v, force, roll"],
        ),
        (
            "law",
            "[[ride.channel]]\ncolumn = \"roll\"",
            "[[ride.law]]\nquantity = \"steer_torque_nm\"\nkind = \"speed_scheduled_rate\"\nof = \"roll_rate_rad_s\"\ngain = 1.0\n[[ride.channel]]\ncolumn = \"roll\"",
            22,
            &["speed0_m_s"],
        ),
    ] {
        let message = complaint(case, &study(from, to), &rows()).unwrap_err();
        println!("{case}: {message}");
        let place = format!("small.toml, line {line}");
        assert!(
            message.contains(&place),
            "{case}: no `{place}` in: {message}"
        );
        for part in parts {
            assert!(message.contains(part), "{case}: no `{part}` in: {message}");
        }
    }
}

#[test]
fn rides_are_refused_with_file_line_and_column() {
    let change = |line: usize, text: &str| {
        let mut rows = rows();
        rows[line - 1] = text.to_owned();
        rows
    };
    for (case, csv, parts) in [
        (
            "cell",
            change(52, "0.5,5.0,0.0,abc"),
            &["ride.csv", "line 52", "column roll", "`abc`"][..],
        ),
        (
            "infinite",
            change(52, "0.5,5.0,inf,0.0"),
            &["ride.csv", "line 52", "column force", "`inf`"],
        ),
        (
            "cells",
            change(52, "0.5,5.0,0.0"),
            &["ride.csv", "line 52", "3 cells", "4, as in the header"],
        ),
        (
            "backwards",
            change(52, "0.2,5.0,0.0,0.0"),
            &["ride.csv", "line 52", "0.2 s after 0.49"],
        ),
        (
            "no time",
            change(52, ",5.0,0.0,0.0"),
            &["ride.csv", "line 52", "t_s"],
        ),
        (
            "kmh",
            change(52, "0.5,5.0,0.0,12.0"),
            &["small.toml, line 23", "roll_rad = 12", "0.5 s", "ride.csv"],
        ),
        (
            "empty",
            vec!["t_s,v,force,roll".into()],
            &["ride.csv", "0 rows"],
        ),
        ("twice", change(1, "t_s,v,roll,roll"), &["ride.csv"]),
    ] {
        let message =
            complaint(&format!("csv-{}", case.replace(' ', "-")), STUDY, &csv).unwrap_err();
        println!("{case}: {message}");
        for part in parts {
            assert!(message.contains(part), "{case}: no `{part}` in: {message}");
        }
    }
}

#[test]
fn gap_of_an_input_is_refused_and_of_an_output_skipped() {
    let with = |column: usize, from: usize, to: usize| {
        let mut rows = rows();
        for row in &mut rows[from..to] {
            let mut cells: Vec<&str> = row.split(',').collect();
            cells[column] = if from.is_multiple_of(2) { "" } else { "NaN" };
            *row = cells.join(",");
        }
        rows
    };
    let message = complaint("gap-input", STUDY, &with(2, 30, 50)).unwrap_err();
    assert!(
        message.contains("small.toml, line 18")
            && message.contains("force has no value from 0.280 to 0.490"),
        "{message}"
    );
    // Short gaps of an input are bridged by its hold; an output's are skipped.
    let rides = complaint("gap-short", STUDY, &with(2, 31, 34)).unwrap();
    assert_eq!(rides[0].channels[1].missing, 3);
    let rides = complaint("gap-output", STUDY, &with(3, 30, 50)).unwrap();
    assert_eq!(rides[0].channels[2].samples.len(), 180);
    assert!(
        rides[0]
            .findings
            .iter()
            .any(|f| f.text.contains("20 missing")),
        "{:?}",
        rides[0].findings
    );
}

#[test]
fn missing_ride_says_where_it_was_looked_for() {
    let folder = Folder::new("missing");
    let path = folder.file("small.toml", STUDY);
    let study = Study::read(&path.to_string_lossy(), &[]).unwrap();
    let elsewhere = folder.0.join("elsewhere");
    let message = read_ride(&study.rides[0], &DataFolders::new(&study, Some(&elsewhere)))
        .unwrap_err()
        .to_string();
    println!("{message}");
    for part in [
        "small.toml, line 9",
        "ride.csv",
        "elsewhere",
        "--data DIR",
        "$TWINHUB_DATA",
    ] {
        assert!(message.contains(part), "{part}: {message}");
    }
    let message = Study::read("nowhere.toml", &[]).unwrap_err().to_string();
    assert!(
        message.contains("nowhere.toml") && message.contains("davis_instrumented_105"),
        "{message}"
    );
}

#[test]
fn compressed_ride_reads_the_same() {
    let folder = Folder::new("gz");
    let path = folder.file("small.toml", &study("ride.csv", "sub/ride.csv.gz"));
    std::fs::create_dir_all(folder.0.join("sub")).unwrap();
    let file = std::fs::File::create(folder.0.join("sub/ride.csv.gz")).unwrap();
    let mut gz = flate2::write::GzEncoder::new(file, flate2::Compression::default());
    gz.write_all(rows().join("\n").as_bytes()).unwrap();
    gz.finish().unwrap();
    let compressed = load(&path).unwrap();
    let plain = complaint("plain", STUDY, &rows()).unwrap();
    assert_eq!(
        compressed[0].channels[2].samples,
        plain[0].channels[2].samples
    );
}

#[test]
fn overrides() {
    let folder = Folder::new("set");
    let path = folder
        .file("small.toml", STUDY)
        .to_string_lossy()
        .into_owned();
    let read = |set: &str| Study::read(&path, &[set.to_owned()]).map_err(|e| e.to_string());
    assert_eq!(
        read("bicycle.values.IBxx=10.5").unwrap().values["IBxx"],
        10.5
    );
    assert_eq!(
        read("ride.0.channel.1.scale=-1").unwrap().rides[0].channels[1].scale,
        -1.0
    );
    assert_eq!(
        read("ride.0.use=held_out").unwrap().rides[0].usage,
        twinhub_diagnose::study::Use::HeldOut
    );
    assert_eq!(
        read("bicycle.values.mB=80").unwrap().rides[0].channels[2]
            .place
            .line,
        23,
        "a change of the study must not move the places that errors name"
    );
    for (set, part) in [
        ("bicycle.values.mB=-1", "mB"),
        ("ride.3.use=fit", "0 to 0"),
        ("IBxx", "PATH=VALUE"),
        ("wind=1", "wind"),
    ] {
        let message = read(set).unwrap_err();
        assert!(!message.contains("line"), "{message}");
        assert!(
            message.starts_with(&format!("--set {set}: ")) && message.contains(part),
            "{set}: {message}"
        );
    }
}
