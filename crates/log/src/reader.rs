//! Reading a ride back, complete or cut off.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::digest::DigestStream;
use crate::error::LogError;
use crate::records::{Contents, walk};
use crate::table::{Table, TextRecord, decode};

/// Largest file that is read, bytes.
pub const FILE_MAX: u64 = 8 << 30;

/// A file inside the log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Attachment {
    /// Its name: `config.toml`.
    pub name: String,
    /// Its type: `application/toml`.
    pub media_type: String,
    /// Its content.
    pub data: Vec<u8>,
}

/// How a log that is not complete was read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Recovery {
    /// Bytes from the start of the file that were used.
    pub used_bytes: u64,
    /// Bytes after them that were not.
    pub lost_bytes: u64,
    /// What stopped the reader.
    pub reason: String,
}

/// A log in memory.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LogFile {
    /// The file.
    pub path: PathBuf,
    /// CDR topics.
    pub tables: BTreeMap<String, Table>,
    /// JSON topics.
    pub texts: BTreeMap<String, Vec<TextRecord>>,
    /// Topics that have no columns, and why.
    pub undecoded: BTreeMap<String, String>,
    /// Metadata records by name: `twinhub` (how it was made) and `twinhub_end` (what came out).
    pub metadata: BTreeMap<String, BTreeMap<String, String>>,
    /// Attachments, the configuration among them.
    pub attachments: Vec<Attachment>,
    /// Set if the file has no proper end; then everything up to the last whole chunk is here.
    pub recovery: Option<Recovery>,
    /// Digest of the tick topics as read.
    pub digest: String,
}

/// Reads the log `path`.
///
/// A log that was cut off (`kill -9`, full disk) or damaged is read up to the last whole chunk,
/// and [`recovery`](LogFile::recovery) says so.
pub fn read(path: impl AsRef<Path>) -> Result<LogFile, LogError> {
    let path = path.as_ref();
    let failed = |source| LogError::Read {
        path: path.into(),
        source,
    };
    let bytes = std::fs::metadata(path).map_err(failed)?.len();
    if bytes > FILE_MAX {
        return Err(LogError::TooLarge {
            path: path.into(),
            bytes,
            limit: FILE_MAX,
        });
    }
    let bytes = std::fs::read(path).map_err(failed)?;
    from_bytes(path, &bytes)
}

/// Reads a log from memory; `path` is what errors call it.
pub(crate) fn from_bytes(path: &Path, bytes: &[u8]) -> Result<LogFile, LogError> {
    if !bytes.starts_with(mcap::MAGIC) {
        return Err(LogError::NotMcap {
            path: path.into(),
            found: beginning(bytes),
        });
    }
    let mut digest = DigestStream::default();
    let (contents, recovery) = walk(bytes, |topic, publish_time, payload| {
        digest.add(topic, publish_time, payload);
    });
    let Contents {
        channels,
        metadata,
        attachments,
        has_header,
    } = contents;
    if let Some(recovery) = &recovery
        && (!has_header || (channels.is_empty() && metadata.is_empty()))
    {
        return Err(LogError::Nothing {
            path: path.into(),
            bytes: bytes.len() as u64,
            found: recovery.reason.clone(),
        });
    }
    let mut log = LogFile {
        path: path.into(),
        metadata,
        attachments,
        recovery,
        digest: digest.hex(),
        ..LogFile::default()
    };
    for channel in channels.into_values() {
        if channel.is_json {
            let texts = channel
                .payloads
                .iter()
                .zip(&channel.publish_time_ns)
                .zip(&channel.log_time_ns);
            let texts = texts.map(|((payload, &publish_time_ns), &log_time_ns)| TextRecord {
                publish_time_ns,
                log_time_ns,
                text: String::from_utf8_lossy(payload).into_owned(),
            });
            log.texts.entry(channel.topic).or_default().extend(texts);
        } else {
            match channel.layout {
                Err(why) => {
                    log.undecoded.insert(channel.topic, why);
                }
                Ok(layout) => {
                    let columns = decode(&layout, &channel.payloads);
                    let table = Table {
                        schema_name: channel.schema_name,
                        digested: channel.digested,
                        publish_time_ns: channel.publish_time_ns,
                        log_time_ns: channel.log_time_ns,
                        columns,
                    };
                    log.tables.insert(channel.topic, table);
                }
            }
        }
    }
    Ok(log)
}

impl LogFile {
    /// The tick topic `topic`.
    pub fn table(&self, topic: &str) -> Result<&Table, LogError> {
        self.tables.get(topic).ok_or_else(|| LogError::NoTopic {
            path: self.path.clone(),
            topic: topic.into(),
            available: list(self.tables.keys()),
        })
    }

    /// Column `column` of the tick topic `topic`.
    pub fn column(&self, topic: &str, column: &str) -> Result<&[f64], LogError> {
        let table = self.table(topic)?;
        table.column(column).ok_or_else(|| LogError::NoColumn {
            path: self.path.clone(),
            topic: topic.into(),
            column: column.into(),
            available: list(table.columns.iter().map(|c| &c.name)),
        })
    }

    /// The resolved configuration of the ride.
    pub fn config_text(&self) -> Option<&str> {
        let attachment = self.attachments.iter().find(|a| a.name == "config.toml")?;
        std::str::from_utf8(&attachment.data).ok()
    }

    /// What the log says under `key`: how it was made, or what came out.
    pub fn about(&self, key: &str) -> Option<&str> {
        let of = |name: &str| self.metadata.get(name)?.get(key).map(String::as_str);
        of("twinhub").or_else(|| of("twinhub_end"))
    }

    /// The digest that the file states; a log that was cut off states none.
    pub fn stated_digest(&self) -> Option<&str> {
        self.metadata
            .get("twinhub_end")?
            .get("digest")
            .map(String::as_str)
    }

    /// True if the file has no proper end, and a part of the ride may be missing.
    pub fn recovered(&self) -> bool {
        self.recovery.is_some()
    }

    /// Compares the records with the digest that the file states.
    pub fn verify(&self) -> Result<(), LogError> {
        let found = self.digest.clone();
        match self.stated_digest() {
            None => Err(LogError::NoDigest {
                path: self.path.clone(),
                found,
            }),
            Some(stated) if stated == found => Ok(()),
            Some(stated) => Err(LogError::DigestMismatch {
                path: self.path.clone(),
                stated: stated.into(),
                found,
            }),
        }
    }
}

fn list<'a>(names: impl Iterator<Item = &'a String>) -> String {
    names.map(String::as_str).collect::<Vec<_>>().join(", ")
}

/// What a file that is no log begins with, in words.
fn beginning(bytes: &[u8]) -> String {
    if bytes.is_empty() {
        return "it is empty".into();
    }
    let head = &bytes[..bytes.len().min(8)];
    if head
        .iter()
        .all(|b| (0x20..0x7f).contains(b) || b.is_ascii_whitespace())
    {
        format!(
            "it begins with the text {:?}",
            String::from_utf8_lossy(head)
        )
    } else {
        let hex: Vec<String> = head.iter().map(|b| format!("{b:02x}")).collect();
        format!(
            "it begins with the bytes {}, not with 89 4d 43 41 50 30 0d 0a",
            hex.join(" ")
        )
    }
}
