//! A study and a ride that are good, to be broken.

use std::path::{Path, PathBuf};
use twinhub_diagnose::compare::compare;
use twinhub_diagnose::data::{DataFolders, RideData, read_ride};
use twinhub_diagnose::study::Study;

pub const STUDY: &str = r#"schema_version = 1
name = "small"
[bicycle]
model = "benchmark"
parameters = "meijaard2007_benchmark"
[bicycle.values]
IBxx = 9.2
[[ride]]
file = "ride.csv"
use = "fit"
time = { column = "t_s" }
windows = [{ s = [0.0, 1.0] }]
[[ride.channel]]
column = "v"
quantity = "speed_m_s"
role = "input"
[[ride.channel]]
column = "force"
quantity = "lateral_force_n"
role = "input"
arm_m = [0.9, 0.01]
[[ride.channel]]
column = "roll"
quantity = "roll_rad"
role = "output"
"#;

/// A folder of its own, gone afterwards.
pub struct Folder(pub PathBuf);

impl Folder {
    pub fn new(name: &str) -> Self {
        let path =
            std::env::temp_dir().join(format!("twinhub-bad-input-{}-{name}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    pub fn file(&self, name: &str, text: &str) -> PathBuf {
        let path = self.0.join(name);
        std::fs::write(&path, text).unwrap();
        path
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

pub fn rows() -> Vec<String> {
    let row = |k: usize| {
        let t = k as f64 * 0.01;
        format!(
            "{t},5.0,{},{}",
            if k.is_multiple_of(40) { 30.0 } else { 0.0 },
            0.01 * libm::sin(3.0 * t)
        )
    };
    ["t_s,v,force,roll".to_owned()]
        .into_iter()
        .chain((0..200).map(row))
        .collect()
}

pub fn study(from: &str, to: &str) -> String {
    assert!(STUDY.contains(from), "{from}");
    STUDY.replacen(from, to, 1)
}

/// Reads study and rides; the error's text.
pub fn complaint(name: &str, study: &str, csv: &[String]) -> Result<Vec<RideData>, String> {
    let folder = Folder::new(name);
    let path = folder.file("small.toml", study);
    folder.file("ride.csv", &csv.join("\n"));
    load(&path)
}

pub fn load(path: &Path) -> Result<Vec<RideData>, String> {
    let study = Study::read(&path.to_string_lossy(), &[]).map_err(|e| e.to_string())?;
    let folders = DataFolders::new(&study, None);
    let rides = study
        .rides
        .iter()
        .map(|r| read_ride(r, &folders))
        .collect::<Result<Vec<_>, _>>();
    let rides = rides.map_err(|e| e.to_string())?;
    compare(&study, &rides, |_| {}).map_err(|e| e.to_string())?;
    Ok(rides)
}
