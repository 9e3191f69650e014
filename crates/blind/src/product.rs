//! The diagnosis of this program as the suite's engine: the study goes in as a file, the answer comes
//! out as the JSON that users get.

use crate::engine::{Ask, Engine};
use crate::reading::Reading;
use std::path::Path;
use twinhub_diagnose::data::DataFolders;
use twinhub_diagnose::{Options, Study, diagnose_in};

/// `twinhub diagnose`, in this process.
#[derive(Clone, Copy, Debug, Default)]
pub struct Product;

impl Engine for Product {
    fn diagnose(&self, study: &Path, ask: &Ask) -> Result<Reading, String> {
        let study = Study::read(&study.to_string_lossy(), &[]).map_err(|e| e.to_string())?;
        let options = Options {
            without: ask.without.clone(),
            only: ask.only.clone(),
        };
        let folders = DataFolders::new(&study, None);
        let answer =
            diagnose_in(&study, &folders, &options, &mut |_| {}).map_err(|e| e.to_string())?;
        let json = serde_json::to_value(&answer).map_err(|e| e.to_string())?;
        serde_json::from_value(json).map_err(|e| format!("the answer cannot be read: {e}"))
    }
}
