//! What is judged: anything that turns a study file into an answer.

use crate::reading::Reading;
use std::path::Path;

/// What a diagnosis is told besides the study.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ask {
    /// Mechanisms that its library has to do without.
    pub without: Vec<String>,
    /// If not empty, its whole library: the oracle, told what there is to find.
    pub only: Vec<String>,
}

/// A diagnosis, as the suite sees it.
pub trait Engine: Sync {
    /// Diagnoses the study at this path.
    ///
    /// # Errors
    /// Its own message, where it refuses the study.
    fn diagnose(&self, study: &Path, ask: &Ask) -> Result<Reading, String>;

    /// Detection limits of the study's rides, as printed before anything is named.
    ///
    /// # Errors
    /// As `diagnose`.
    fn limits(&self, study: &Path) -> Result<Reading, String> {
        self.diagnose(study, &Ask::default())
    }
}
