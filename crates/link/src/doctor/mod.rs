//! What this machine allows a ride, what is missing, and how to get it.
//!
//! Nothing is changed, except that a trial ride of one second's worth of ticks is ridden and
//! removed. *Needed* is what every ride needs; *advised* is what makes real time better.

mod machine;
mod trial;

use crate::ride::{RunDir, leftovers};
use serde::Serialize;

/// One thing that was looked at.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// What was looked at.
    pub name: &'static str,
    /// True if no ride works without it.
    pub needed: bool,
    /// True if it is as wanted.
    pub ok: bool,
    /// What was found.
    pub found: String,
    /// What is wanted.
    pub wanted: &'static str,
    /// How to get it; empty if it is as wanted.
    pub how: String,
}

impl Finding {
    fn new(
        name: &'static str,
        needed: bool,
        result: Result<String, String>,
        wanted: &'static str,
        how: &str,
    ) -> Self {
        let ok = result.is_ok();
        Self {
            name,
            needed,
            ok,
            found: result.unwrap_or_else(|found| found),
            wanted,
            how: if ok { String::new() } else { how.to_owned() },
        }
    }

    fn needed(
        name: &'static str,
        result: Result<String, String>,
        wanted: &'static str,
        how: &str,
    ) -> Self {
        Self::new(name, true, result, wanted, how)
    }

    fn advised(
        name: &'static str,
        result: Result<String, String>,
        wanted: &'static str,
        how: &str,
    ) -> Self {
        Self::new(name, false, result, wanted, how)
    }
}

/// Looks at everything.
pub fn examine(run_dir: &RunDir) -> Vec<Finding> {
    let mut findings = trial::findings(run_dir);
    findings.extend(machine::findings());
    findings.push(left_over(run_dir));
    findings
}

fn left_over(run_dir: &RunDir) -> Finding {
    let found = leftovers(run_dir);
    let result = if found.is_empty() {
        Ok("none".to_owned())
    } else {
        let paths: Vec<_> = found
            .iter()
            .map(|path| path.display().to_string())
            .collect();
        Err(paths.join(", "))
    };
    Finding::advised(
        "leftovers of dead rides",
        result,
        "none",
        "the next ride of this user removes them",
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::PermissionsExt;

    #[test]
    fn a_machine_that_rides_has_all_that_is_needed_and_every_lack_has_a_remedy() {
        let dir = tempfile::Builder::new()
            .permissions(std::fs::Permissions::from_mode(0o700))
            .tempdir()
            .expect("a temporary directory");
        let findings = examine(&RunDir::at(dir.path()));
        for finding in &findings {
            assert!(finding.ok || !finding.needed, "{finding:?}");
            assert!(finding.ok || !finding.how.is_empty(), "{finding:?}");
            assert!(!finding.found.is_empty() && !finding.wanted.is_empty());
        }
        assert!(findings.len() > 12);
        assert_eq!(std::fs::read_dir(dir.path()).expect("run dir").count(), 0);
    }

    #[test]
    fn an_open_run_directory_is_a_lack_of_something_needed() {
        let dir = tempfile::tempdir().expect("a temporary directory");
        std::fs::set_permissions(dir.path(), std::fs::Permissions::from_mode(0o755)).expect("ours");
        let findings = examine(&RunDir::at(dir.path()));
        let lacks: Vec<_> = findings.iter().filter(|f| f.needed && !f.ok).collect();
        assert!(!lacks.is_empty());
        assert!(lacks.iter().any(|f| f.found.contains("0755")), "{lacks:?}");
    }
}
