//! Law files: what the stabilizer is told once, as TOML.

use std::path::{Path, PathBuf};
use twinhub_control::{Config, ConfigError};

/// Why a law file is refused.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LawFileError {
    /// The file cannot be read.
    #[error("{}: cannot be read: {source}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// The system's answer.
        source: std::io::Error,
    },
    /// The file is no law file; the message holds line and column.
    #[error("{}: {source}", path.display())]
    Syntax {
        /// The file.
        path: PathBuf,
        /// What is wrong, and where.
        source: Box<toml::de::Error>,
    },
    /// A value breaks a rule.
    #[error("{}: {rule}", path.display())]
    Rule {
        /// The file.
        path: PathBuf,
        /// The rule.
        rule: ConfigError,
    },
}

/// Reads and checks the law file at `path`.
pub fn read_law(path: &Path) -> Result<Config, LawFileError> {
    let text = std::fs::read_to_string(path).map_err(|source| LawFileError::Unreadable {
        path: path.to_owned(),
        source,
    })?;
    parse_law(&text, path)
}

/// Reads and checks a law file's text; `path` serves messages.
pub fn parse_law(text: &str, path: &Path) -> Result<Config, LawFileError> {
    let path = path.to_owned();
    let config: Config = match toml::from_str(text) {
        Ok(config) => config,
        Err(source) => {
            return Err(LawFileError::Syntax {
                path,
                source: Box::new(source),
            });
        }
    };
    match config.check() {
        Ok(()) => Ok(config),
        Err(rule) => Err(LawFileError::Rule { path, rule }),
    }
}
