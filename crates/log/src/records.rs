//! The records of an MCAP file, in order, borrowed from its bytes.
//!
//! Source: the MCAP specification, <https://mcap.dev/spec>: magic, then records of one byte of
//! opcode, eight bytes of length and the content; messages stand in chunks of such records. The
//! contents are parsed by the `mcap` crate; only the framing is done here, so that a million
//! messages are neither copied nor allocated.
//! Assumes and ignores: chunks are not compressed.

use std::collections::BTreeMap;

use mcap::records::{Record, op};

use crate::reader::{Attachment, Recovery};
use crate::schema::{Layout, layout};

/// A channel and its messages.
pub(crate) struct ChannelRecords<'a> {
    pub topic: String,
    pub schema_name: String,
    pub is_json: bool,
    pub digested: bool,
    /// Where the columns stand, or why there are none.
    pub layout: Result<Layout, String>,
    pub publish_time_ns: Vec<u64>,
    pub log_time_ns: Vec<u64>,
    pub payloads: Vec<&'a [u8]>,
}

/// What a file holds.
#[derive(Default)]
pub(crate) struct Contents<'a> {
    pub channels: BTreeMap<u16, ChannelRecords<'a>>,
    pub metadata: BTreeMap<String, BTreeMap<String, String>>,
    pub attachments: Vec<Attachment>,
    pub has_header: bool,
}

/// Name, encoding, text.
type Schema = (String, String, Vec<u8>);

struct Walk<'a, F> {
    contents: Contents<'a>,
    schemas: BTreeMap<u16, Schema>,
    digest: F,
}

/// Goes through the file until its end or the first thing that cannot be read; `digest` gets
/// topic, publish time and payload of every record of a digested topic.
pub(crate) fn walk<'a>(
    bytes: &'a [u8],
    digest: impl FnMut(&str, u64, &[u8]),
) -> (Contents<'a>, Option<Recovery>) {
    let mut walk = Walk {
        contents: Contents::default(),
        schemas: BTreeMap::new(),
        digest,
    };
    let mut at = mcap::MAGIC.len();
    let reason = loop {
        let rest = bytes.get(at..).unwrap_or_default();
        match frame(rest) {
            Err(reason) => break reason,
            Ok((op::FOOTER, _, after)) => match after {
                after if after == mcap::MAGIC => return (walk.contents, None),
                after if after.starts_with(mcap::MAGIC) => {
                    break format!("{} bytes follow the end", after.len() - mcap::MAGIC.len());
                }
                _ => break "the last bytes are missing".into(),
            },
            Ok((opcode, body, after)) => {
                if let Err(reason) = walk.record(opcode, body) {
                    break reason;
                }
                at = bytes.len() - after.len();
            }
        }
    };
    let (used_bytes, lost_bytes) = (at as u64, bytes.len().saturating_sub(at) as u64);
    (
        walk.contents,
        Some(Recovery {
            used_bytes,
            lost_bytes,
            reason: format!("at byte {at}: {reason}"),
        }),
    )
}

/// One record: opcode, content, and what follows.
fn frame(bytes: &[u8]) -> Result<(u8, &[u8], &[u8]), String> {
    let cut = || {
        if bytes.is_empty() {
            "the file ends without a summary".to_string()
        } else {
            "the file ends within a record".to_string()
        }
    };
    let (&opcode, rest) = bytes.split_first().ok_or_else(cut)?;
    let (length, rest) = rest.split_first_chunk().ok_or_else(cut)?;
    let length = usize::try_from(u64::from_le_bytes(*length)).map_err(|_| cut())?;
    let (body, rest) = rest.split_at_checked(length).ok_or_else(cut)?;
    Ok((opcode, body, rest))
}

impl<'a, F: FnMut(&str, u64, &[u8])> Walk<'a, F> {
    fn record(&mut self, opcode: u8, body: &'a [u8]) -> Result<(), String> {
        let parsed = || mcap::parse_record(opcode, body).map_err(|error| words(&error));
        match opcode {
            op::HEADER => {
                parsed()?;
                self.contents.has_header = true;
            }
            op::CHUNK => self.chunk(body)?,
            op::MESSAGE => self.message(body)?,
            op::SCHEMA => {
                if let Record::Schema { header, data } = parsed()? {
                    self.schemas
                        .entry(header.id)
                        .or_insert_with(|| (header.name, header.encoding, data.into_owned()));
                }
            }
            op::CHANNEL => {
                if let Record::Channel(channel) = parsed()? {
                    self.channel(channel)?;
                }
            }
            op::METADATA => {
                if let Record::Metadata(metadata) = parsed()? {
                    self.contents
                        .metadata
                        .entry(metadata.name)
                        .or_default()
                        .extend(metadata.metadata);
                }
            }
            op::ATTACHMENT => {
                if !attachment_fits(body) {
                    return Err("an attachment is longer than its record".into());
                }
                if let Record::Attachment { header, data, .. } = parsed()? {
                    self.contents.attachments.push(Attachment {
                        name: header.name,
                        media_type: header.media_type,
                        data: data.into_owned(),
                    });
                }
            }
            0 => return Err("there is no record of type 0".into()),
            // Indexes, statistics, the end of the data section, private records.
            _ => {}
        }
        Ok(())
    }

    /// Nothing of a chunk is used before its checksum is.
    fn chunk(&mut self, body: &'a [u8]) -> Result<(), String> {
        let record = mcap::parse_record(op::CHUNK, body).map_err(|error| words(&error))?;
        let Record::Chunk { header, .. } = record else {
            return Err("a chunk is no chunk".into());
        };
        if !header.compression.is_empty() {
            return Err(format!(
                "a chunk is compressed with {}; `mcap decompress` makes it readable",
                header.compression
            ));
        }
        // The fixed fields are 40 bytes; the name of the compression is empty.
        let size = usize::try_from(header.compressed_size).unwrap_or(usize::MAX);
        let data = body
            .get(40..)
            .and_then(|rest| rest.get(..size))
            .ok_or("a chunk is cut off")?;
        let found = crc32fast::hash(data);
        if header.uncompressed_crc != 0 && header.uncompressed_crc != found {
            return Err(format!(
                "a chunk has the checksum {found:08x} instead of {:08x}",
                header.uncompressed_crc
            ));
        }
        let mut rest = data;
        while !rest.is_empty() {
            let (opcode, body, after) = frame(rest)?;
            match opcode {
                op::SCHEMA | op::CHANNEL | op::MESSAGE => self.record(opcode, body)?,
                other => return Err(format!("a chunk holds a record of type {other}")),
            }
            rest = after;
        }
        Ok(())
    }

    fn channel(&mut self, channel: mcap::records::Channel) -> Result<(), String> {
        if self.contents.channels.contains_key(&channel.id) {
            return Ok(());
        }
        let (schema_name, layout) = match self.schemas.get(&channel.schema_id) {
            None => (String::new(), Err("it has no schema".to_string())),
            Some((name, encoding, text)) if encoding == "ros2msg" => (
                name.clone(),
                std::str::from_utf8(text)
                    .map_err(|e| e.to_string())
                    .and_then(layout),
            ),
            Some((name, encoding, _)) => (name.clone(), Err(format!("its schema is `{encoding}`"))),
        };
        let layout = match channel.message_encoding.as_str() {
            "cdr" => layout,
            other => Err(format!("its encoding is `{other}`")),
        };
        self.contents.channels.insert(
            channel.id,
            ChannelRecords {
                topic: channel.topic,
                schema_name,
                is_json: channel.message_encoding == "json",
                digested: channel
                    .metadata
                    .get("digested")
                    .is_some_and(|yes| yes == "yes"),
                layout,
                publish_time_ns: Vec::new(),
                log_time_ns: Vec::new(),
                payloads: Vec::new(),
            },
        );
        Ok(())
    }

    /// Channel, sequence, log time, publish time, payload.
    fn message(&mut self, body: &'a [u8]) -> Result<(), String> {
        let cut = "a message is cut off";
        let (id, rest) = body.split_first_chunk().ok_or(cut)?;
        let (_sequence, rest) = rest.split_first_chunk::<4>().ok_or(cut)?;
        let (log_time, rest) = rest.split_first_chunk().ok_or(cut)?;
        let (publish_time, payload) = rest.split_first_chunk().ok_or(cut)?;
        let id = u16::from_le_bytes(*id);
        let channel = self
            .contents
            .channels
            .get_mut(&id)
            .ok_or_else(|| format!("a message belongs to the unknown channel {id}"))?;
        if let Ok(layout) = &channel.layout {
            if payload.len() < layout.size {
                return Err(format!(
                    "a record of {} has {} bytes instead of {}",
                    channel.topic,
                    payload.len(),
                    layout.size
                ));
            }
            if payload.get(1) != Some(&1) {
                return Err(format!(
                    "a record of {} is not little-endian CDR",
                    channel.topic
                ));
            }
        }
        let publish_time = u64::from_le_bytes(*publish_time);
        if channel.digested {
            (self.digest)(&channel.topic, publish_time, payload);
        }
        channel.publish_time_ns.push(publish_time);
        channel.log_time_ns.push(u64::from_le_bytes(*log_time));
        channel.payloads.push(payload);
        Ok(())
    }
}

/// The parser of attachments takes the four bytes of checksum for granted.
fn attachment_fits(body: &[u8]) -> bool {
    let length_at = |at: usize| -> Option<usize> {
        let bytes = body.get(at..)?.first_chunk()?;
        usize::try_from(u32::from_le_bytes(*bytes)).ok()
    };
    let name = 16;
    let Some(media_type) = length_at(name).and_then(|n| n.checked_add(name + 4)) else {
        return false;
    };
    let Some(data) = length_at(media_type).and_then(|n| n.checked_add(media_type + 4)) else {
        return false;
    };
    body.len() >= data.saturating_add(8 + 4)
}

/// An error of the parser with its causes, on one line.
fn words(error: &mcap::McapError) -> String {
    let mut text = error.to_string();
    let mut source = std::error::Error::source(error);
    while let Some(cause) = source {
        text = format!(
            "{text}: {}",
            cause.to_string().lines().next().unwrap_or_default()
        );
        source = cause.source();
    }
    text
}
