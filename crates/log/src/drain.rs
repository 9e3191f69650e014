//! The thread that writes the file: one chunk per batch, handed to the system at once.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender};

use mcap::records::{MessageHeader, Metadata as MetadataRecord};
use mcap::{Attachment, McapError, WriteOptions, Writer};
use twinhub_types::Instant;

use crate::bicycle::{BicycleShape, ScenePose};
use crate::digest::DigestStream;
use crate::writer::{LogSummary, Metadata};

/// How the records of a topic are written.
#[derive(Clone, Debug)]
pub(crate) enum Kind {
    /// CDR, as they come.
    Tick { digested: bool },
    /// JSON, as it comes.
    Json,
    /// A [`ScenePose`] that becomes a `foxglove.SceneUpdate`.
    Scene(BicycleShape),
}

/// A topic that was registered since the last batch.
#[derive(Debug)]
pub(crate) struct TopicDef {
    pub name: String,
    pub kind: Kind,
    pub schema_name: String,
    pub schema: Vec<u8>,
}

/// What the tick hands over.
#[derive(Debug, Default)]
pub(crate) struct Batch {
    pub topics: Vec<TopicDef>,
    pub notes: Vec<(String, String)>,
    /// Records, each after a header of [`HEADER`] bytes.
    pub bytes: Vec<u8>,
}

/// Topic, payload length, publish time, log time.
pub(crate) const HEADER: usize = 4 + 4 + 8 + 8;

/// Appends the header of a record of `length` bytes.
#[inline]
pub(crate) fn put_header(
    out: &mut Vec<u8>,
    topic: u32,
    sample: Instant,
    now: Instant,
    length: usize,
) {
    let mut header = [0; HEADER];
    header[..4].copy_from_slice(&topic.to_le_bytes());
    header[4..8].copy_from_slice(&(length as u32).to_le_bytes());
    header[8..16].copy_from_slice(&sample.as_nanos().to_le_bytes());
    header[16..].copy_from_slice(&now.as_nanos().to_le_bytes());
    out.extend_from_slice(&header);
}

/// One record of a batch.
struct Taken<'a> {
    topic: usize,
    publish_time: u64,
    log_time: u64,
    payload: &'a [u8],
}

/// The first record of a batch and the rest of the batch.
fn take_record(bytes: &[u8]) -> Option<(Taken<'_>, &[u8])> {
    let (topic, rest) = bytes.split_first_chunk()?;
    let (length, rest) = rest.split_first_chunk()?;
    let (publish, rest) = rest.split_first_chunk()?;
    let (log, rest) = rest.split_first_chunk()?;
    let (payload, rest) = rest.split_at_checked(u32::from_le_bytes(*length) as usize)?;
    let taken = Taken {
        topic: u32::from_le_bytes(*topic) as usize,
        publish_time: u64::from_le_bytes(*publish),
        log_time: u64::from_le_bytes(*log),
        payload,
    };
    Some((taken, rest))
}

struct Open {
    channel_id: u16,
    name: String,
    kind: Kind,
    sequence: u32,
}

pub(crate) struct Drain {
    path: PathBuf,
    writer: Writer<BufWriter<File>>,
    topics: Vec<Open>,
    digest: DigestStream,
    messages: u64,
    notes: BTreeMap<String, String>,
}

impl Drain {
    /// Writes header, metadata and configuration.
    pub(crate) fn start(
        path: &Path,
        file: File,
        metadata: &Metadata,
        config_text: &str,
    ) -> Result<Self, McapError> {
        let mut writer = WriteOptions::new()
            .profile("ros2")
            .library(concat!("twinhub ", env!("CARGO_PKG_VERSION")))
            .compression(None)
            .chunk_size(None)
            // Every chunk has a checksum of its own.
            .calculate_data_section_crc(false)
            // A chunk is put together in memory and written in one go.
            .disable_seeking(true)
            .create(BufWriter::with_capacity(1 << 18, file))?;
        let mut entries = metadata.extra.clone();
        entries.insert("version".into(), metadata.version.clone());
        entries.insert("git_hash".into(), metadata.git_hash.clone());
        entries.insert("config_digest".into(), metadata.config_digest.clone());
        entries.insert("seed".into(), metadata.seed.to_string());
        writer.write_metadata(&MetadataRecord {
            name: "twinhub".into(),
            metadata: entries,
        })?;
        writer.attach(&Attachment {
            log_time: 0,
            create_time: 0,
            name: "config.toml".into(),
            media_type: "application/toml".into(),
            data: Cow::Borrowed(config_text.as_bytes()),
        })?;
        writer.flush()?;
        Ok(Self {
            path: path.into(),
            writer,
            topics: Vec::new(),
            digest: DigestStream::default(),
            messages: 0,
            notes: BTreeMap::new(),
        })
    }

    /// Writes batches until the log is closed.
    pub(crate) fn run(
        mut self,
        batches: &Receiver<Batch>,
        give_back: &Sender<Vec<u8>>,
    ) -> Result<LogSummary, McapError> {
        for batch in batches {
            let mut bytes = self.write(batch)?;
            bytes.clear();
            // The log may be closed by now; then nobody wants the buffer back.
            let _ = give_back.send(bytes);
        }
        self.finish()
    }

    fn write(&mut self, batch: Batch) -> Result<Vec<u8>, McapError> {
        for def in batch.topics {
            self.open(def)?;
        }
        self.notes.extend(batch.notes);
        let mut rest = &batch.bytes[..];
        while let Some((record, after)) = take_record(rest) {
            rest = after;
            let Taken {
                topic,
                publish_time,
                log_time,
                payload,
            } = record;
            let Some(topic) = self.topics.get_mut(topic) else {
                continue;
            };
            let header = MessageHeader {
                channel_id: topic.channel_id,
                sequence: topic.sequence,
                log_time,
                publish_time,
            };
            topic.sequence = topic.sequence.wrapping_add(1);
            self.messages += 1;
            match &topic.kind {
                Kind::Tick { digested } => {
                    if *digested {
                        self.digest.add(&topic.name, publish_time, payload);
                    }
                    self.writer.write_to_known_channel(&header, payload)?;
                }
                Kind::Json => self.writer.write_to_known_channel(&header, payload)?,
                Kind::Scene(shape) => {
                    let pose = ScenePose::from_bytes(payload);
                    let json = shape.scene_json(Instant::from_nanos(publish_time), &pose);
                    self.writer
                        .write_to_known_channel(&header, json.as_bytes())?;
                }
            }
        }
        self.writer.flush()?;
        Ok(batch.bytes)
    }

    fn open(&mut self, def: TopicDef) -> Result<(), McapError> {
        let (schema_encoding, message_encoding, digested) = match def.kind {
            Kind::Tick { digested } => ("ros2msg", "cdr", digested),
            Kind::Json | Kind::Scene(_) => ("jsonschema", "json", false),
        };
        let schema = self
            .writer
            .add_schema(&def.schema_name, schema_encoding, &def.schema)?;
        let about = BTreeMap::from([(
            "digested".to_string(),
            if digested { "yes" } else { "no" }.to_string(),
        )]);
        let channel_id = self
            .writer
            .add_channel(schema, &def.name, message_encoding, &about)?;
        self.topics.push(Open {
            channel_id,
            name: def.name,
            kind: def.kind,
            sequence: 0,
        });
        Ok(())
    }

    fn finish(mut self) -> Result<LogSummary, McapError> {
        let digest = self.digest.hex();
        let mut entries = std::mem::take(&mut self.notes);
        entries.insert("digest".into(), digest.clone());
        entries.insert("messages".into(), self.messages.to_string());
        self.writer.write_metadata(&MetadataRecord {
            name: "twinhub_end".into(),
            metadata: entries,
        })?;
        self.writer.finish()?;
        let mut file = self
            .writer
            .into_inner()
            .into_inner()
            .map_err(|e| e.into_error())?;
        let bytes = file.seek(SeekFrom::End(0))?;
        Ok(LogSummary {
            path: self.path,
            digest,
            messages: self.messages,
            bytes,
        })
    }
}
