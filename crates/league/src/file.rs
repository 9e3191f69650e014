//! League files: the spec in the first line, then a part a line. A league that was broken off goes on
//! where it was; shards are put together by [`merge`].

use crate::error::LeagueError;
use crate::league::Part;
use crate::spec::Spec;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

/// A league file that is open for more parts.
#[derive(Debug)]
pub struct Kept {
    path: PathBuf,
    file: File,
    /// The parts that it held when it was opened.
    pub parts: Vec<Part>,
}

impl Kept {
    /// Opens the file, or begins it. A line that a kill left unfinished is cut off.
    ///
    /// # Errors
    /// If the file cannot be used, or belongs to another league.
    pub fn open(path: &Path, spec: &Spec) -> Result<Self, LeagueError> {
        let wrap = |source| LeagueError::File {
            path: path.to_owned(),
            source,
        };
        let mut file = File::options()
            .create(true)
            .truncate(false)
            .read(true)
            .write(true)
            .open(path)
            .map_err(wrap)?;
        let mut text = String::new();
        file.read_to_string(&mut text).map_err(wrap)?;
        let whole = text.rfind('\n').map_or(0, |end| end + 1);
        let parts = if whole == 0 {
            Vec::new()
        } else {
            let (found, parts) = parse(path, &text[..whole])?;
            if let Some(detail) = spec.difference(&found) {
                return Err(LeagueError::OtherLeague {
                    path: path.to_owned(),
                    detail,
                });
            }
            parts
        };
        if whole > 0 || text.is_empty() {
            file.set_len(whole as u64).map_err(wrap)?;
        } else {
            return Err(LeagueError::Format {
                path: path.to_owned(),
                line: 1,
                detail: "no league file".into(),
            });
        }
        file.seek(SeekFrom::End(0)).map_err(wrap)?;
        let mut kept = Self {
            path: path.to_owned(),
            file,
            parts,
        };
        if whole == 0 {
            kept.line(spec)?;
        }
        Ok(kept)
    }

    /// Adds a part.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn add(&mut self, part: &Part) -> Result<(), LeagueError> {
        self.line(part)
    }

    fn line(&mut self, value: &impl serde::Serialize) -> Result<(), LeagueError> {
        let text = serde_json::to_string(value).map_err(std::io::Error::other);
        text.and_then(|text| self.file.write_all(format!("{text}\n").as_bytes()))
            .map_err(|source| LeagueError::File {
                path: self.path.clone(),
                source,
            })
    }
}

fn parse(path: &Path, text: &str) -> Result<(Spec, Vec<Part>), LeagueError> {
    let bad = |line: usize, error: serde_json::Error| LeagueError::Format {
        path: path.to_owned(),
        line,
        detail: error.to_string(),
    };
    let mut lines = text.lines().enumerate();
    let (_, first) = lines.next().unwrap_or((0, ""));
    let spec: Spec = serde_json::from_str(first).map_err(|e| bad(1, e))?;
    let mut parts: Vec<Part> = Vec::new();
    for (index, line) in lines {
        let part: Part = serde_json::from_str(line).map_err(|e| bad(index + 1, e))?;
        let wrong = if part.part >= spec.parts() {
            Some(format!(
                "part {} of a league of {}",
                part.part,
                spec.parts()
            ))
        } else if part.scores.len() != spec.controllers.len() {
            Some(format!(
                "part {} has {} scores for {} controllers",
                part.part,
                part.scores.len(),
                spec.controllers.len()
            ))
        } else {
            None
        };
        if let Some(detail) = wrong {
            return Err(LeagueError::Format {
                path: path.to_owned(),
                line: index + 1,
                detail,
            });
        }
        parts.push(part);
    }
    Ok((spec, parts))
}

/// Puts files of one league together: the spec, the parts in order, and how many are missing. The
/// result is exactly that of a run in one piece.
///
/// # Errors
/// If a file cannot be read, belongs to another league, or says otherwise than another.
pub fn merge(paths: &[PathBuf]) -> Result<(Spec, Vec<Part>, u64), LeagueError> {
    let mut of_all: Option<Spec> = None;
    let mut parts: BTreeMap<u64, Part> = BTreeMap::new();
    for path in paths {
        let text = std::fs::read_to_string(path).map_err(|source| LeagueError::File {
            path: path.clone(),
            source,
        })?;
        let whole = text.rfind('\n').map_or(0, |end| end + 1);
        let (spec, found) = parse(path, &text[..whole])?;
        match &of_all {
            None => of_all = Some(spec),
            Some(first) => {
                if let Some(detail) = first.difference(&spec) {
                    return Err(LeagueError::OtherLeague {
                        path: path.clone(),
                        detail,
                    });
                }
            }
        }
        for part in found {
            let number = part.part;
            if let Some(known) = parts.insert(number, part.clone())
                && known != part
            {
                return Err(LeagueError::Conflict {
                    path: path.clone(),
                    part: number,
                });
            }
        }
    }
    let spec = of_all.ok_or_else(|| LeagueError::OutOfRange {
        key: "files",
        found: "none".into(),
        accepted: "at least one league file".into(),
    })?;
    let missing = spec.parts() - parts.len() as u64;
    Ok((spec, parts.into_values().collect(), missing))
}
