//! Writing a ride: the tick copies bytes into a batch; another thread writes the file.

use std::collections::BTreeMap;
use std::marker::PhantomData;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, SyncSender, channel, sync_channel};
use std::thread::JoinHandle;

use twinhub_types::{Duration, Instant};

use crate::bicycle::{BicycleShape, ScenePose};
use crate::drain::{self, Batch, Kind, TopicDef};
use crate::error::LogError;
use crate::event::{self, Event};
use crate::record::{Record, Row};
use crate::schema;
use crate::topics;

/// Ride time that one chunk of the file holds.
pub const BATCH: Duration = Duration::from_millis(20);

/// Batches that may wait for the writing thread.
const QUEUE: usize = 2;

/// The same in real time.
const QUEUE_REAL_TIME: usize = 50;

/// Ride time that a kill can lose at most (not in real time, with a disk that lags): one batch being filled, two waiting, one being
/// written.
pub const IN_FLIGHT_MAX: Duration = Duration::from_nanos(BATCH.as_nanos() * (QUEUE as u64 + 2));

/// A batch is handed over early when it holds this many bytes.
const BATCH_BYTES: usize = 1 << 20;

/// What a ride was made of; the first thing in the log.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Metadata {
    /// Version of twinhub.
    pub version: String,
    /// Commit that it was built from, or `unknown`.
    pub git_hash: String,
    /// [`digest_text`](crate::digest_text) of the resolved configuration.
    pub config_digest: String,
    /// Seed of everything random in the ride.
    pub seed: u64,
    /// Whatever else belongs to the ride: course, rider, bicycle, stabilizer on or off.
    pub extra: BTreeMap<String, String>,
}

/// Whether records of a topic enter the digest of the ride.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Digest {
    /// They do: they must be the same in every run.
    Digested,
    /// They do not: they tell about this run alone (timing).
    Left,
}

/// A registered tick topic of records `R`.
#[derive(Debug)]
pub struct Topic<R> {
    index: u32,
    record: PhantomData<fn(&R)>,
}

impl<R> Clone for Topic<R> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<R> Copy for Topic<R> {}

/// What became of a log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LogSummary {
    /// The file.
    pub path: PathBuf,
    /// Digest of the tick topics, 32 hex characters.
    pub digest: String,
    /// Messages in the file.
    pub messages: u64,
    /// Size of the file.
    pub bytes: u64,
}

/// A log that is being written.
///
/// The tick never waits for the disk unless 60 ms of ride time are already waiting for it; then
/// a write blocks until there is room, because a kill may lose at most [`IN_FLIGHT_MAX`]. A log
/// that is dropped without [`finish`](Self::finish) still becomes a complete file.
pub struct RideLog {
    path: PathBuf,
    batch: Batch,
    batch_start: Option<Instant>,
    now: Instant,
    names: Vec<String>,
    to_disk: Option<SyncSender<Batch>>,
    empties: Receiver<Vec<u8>>,
    thread: Option<JoinHandle<Result<LogSummary, mcap::McapError>>>,
    scene: Option<u32>,
    event: u32,
}

impl RideLog {
    /// Creates the file (an existing one is replaced), writes metadata and configuration, and
    /// registers the topic `/event`.
    pub fn create(path: &Path, metadata: &Metadata, config_text: &str) -> Result<Self, LogError> {
        Self::create_with_queue(path, metadata, config_text, QUEUE)
    }

    /// The same for a ride that must not wait for the disk: a second of it may wait to be
    /// written, all of which a kill loses.
    pub fn create_for_real_time(
        path: &Path,
        metadata: &Metadata,
        config_text: &str,
    ) -> Result<Self, LogError> {
        Self::create_with_queue(path, metadata, config_text, QUEUE_REAL_TIME)
    }

    fn create_with_queue(
        path: &Path,
        metadata: &Metadata,
        config_text: &str,
        queue: usize,
    ) -> Result<Self, LogError> {
        let file = std::fs::File::create(path).map_err(|source| LogError::Create {
            path: path.into(),
            source,
        })?;
        let drain = drain::Drain::start(path, file, metadata, config_text).map_err(|source| {
            LogError::Write {
                path: path.into(),
                source,
            }
        })?;
        let (to_disk, batches) = sync_channel(queue);
        let (give_back, empties) = channel();
        let thread = std::thread::Builder::new()
            .name("twinhub-log".into())
            .spawn(move || drain.run(&batches, &give_back))
            .map_err(|source| LogError::Create {
                path: path.into(),
                source,
            })?;
        let mut log = Self {
            path: path.into(),
            batch: Batch::default(),
            batch_start: None,
            now: Instant::START,
            names: Vec::new(),
            to_disk: Some(to_disk),
            empties,
            thread: Some(thread),
            scene: None,
            event: 0,
        };
        let (name, text) = (event::SCHEMA_NAME.to_string(), event::SCHEMA.into());
        log.event = log.register(topics::EVENT, Kind::Json, name, text)?;
        Ok(log)
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Registers the tick topic `name` with records `R`.
    pub fn topic<R: Record>(&mut self, name: &str, digest: Digest) -> Result<Topic<R>, LogError> {
        let kind = Kind::Tick {
            digested: digest == Digest::Digested,
        };
        let index = self.register(
            name,
            kind,
            schema::schema_name(R::NAME),
            R::schema().into_bytes(),
        )?;
        Ok(Topic {
            index,
            record: PhantomData,
        })
    }

    /// Logs `record`, taken at `sample`. Log time is the latest sample time so far.
    #[inline]
    pub fn write<R: Record>(
        &mut self,
        topic: Topic<R>,
        sample: Instant,
        record: &R,
    ) -> Result<(), LogError> {
        self.begin(sample)?;
        let length = schema::ENCAPSULATION.len() + R::SIZE;
        drain::put_header(&mut self.batch.bytes, topic.index, sample, self.now, length);
        self.batch.bytes.extend_from_slice(&schema::ENCAPSULATION);
        record.put(&mut self.batch.bytes);
        Ok(())
    }

    /// Logs an event.
    pub fn event(&mut self, at: Instant, event: &Event<'_>) -> Result<(), LogError> {
        self.begin(at)?;
        let json = event.json(at);
        drain::put_header(&mut self.batch.bytes, self.event, at, self.now, json.len());
        self.batch.bytes.extend_from_slice(json.as_bytes());
        Ok(())
    }

    /// Registers the topic `/scene`, in which [`scene`](Self::scene) draws a bicycle of `shape`.
    pub fn scene_topic(&mut self, shape: BicycleShape) -> Result<(), LogError> {
        let name = crate::scene::SCHEMA_NAME.to_string();
        let text = crate::scene::schema().into_bytes();
        self.scene = Some(self.register(topics::SCENE, Kind::Scene(shape), name, text)?);
        Ok(())
    }

    /// Logs where the bicycle is; 20 times a second are enough. Without
    /// [`scene_topic`](Self::scene_topic) nothing is logged. The picture is drawn by the writing
    /// thread.
    pub fn scene(&mut self, at: Instant, pose: &ScenePose) -> Result<(), LogError> {
        let Some(index) = self.scene else {
            return Ok(());
        };
        self.begin(at)?;
        let start = self.batch.bytes.len() + drain::HEADER;
        drain::put_header(
            &mut self.batch.bytes,
            index,
            at,
            self.now,
            8 * ScenePose::COLUMNS.len(),
        );
        pose.put(&mut self.batch.bytes);
        debug_assert_eq!(self.batch.bytes.len(), start + ScenePose::SIZE);
        Ok(())
    }

    /// Adds a note (a result of the ride, say) to the metadata at the end of the file.
    pub fn note(&mut self, key: &str, value: &str) {
        self.batch.notes.push((key.into(), value.into()));
    }

    /// Writes what is left, the digest and the summary, and closes the file.
    pub fn finish(mut self) -> Result<LogSummary, LogError> {
        // The error that stopped the thread, if any, comes out of `close`.
        let handed = self.hand_over();
        let closed = self.close();
        handed?;
        closed
    }

    fn register(
        &mut self,
        name: &str,
        kind: Kind,
        schema_name: String,
        schema: Vec<u8>,
    ) -> Result<u32, LogError> {
        let refuse = |reason| {
            Err(LogError::Topic {
                topic: name.into(),
                reason,
            })
        };
        if !name.starts_with('/') || name.len() < 2 || name.contains(char::is_whitespace) {
            return refuse("a topic begins with `/` and has no blanks");
        }
        if self.names.iter().any(|known| known == name) {
            return refuse("it is registered already");
        }
        if self.names.len() >= usize::from(u16::MAX) {
            return refuse("there are too many topics");
        }
        let index = self.names.len() as u32;
        self.names.push(name.into());
        self.batch.topics.push(TopicDef {
            name: name.into(),
            kind,
            schema_name,
            schema,
        });
        Ok(index)
    }

    /// Makes room for a record that is written now.
    #[inline]
    fn begin(&mut self, sample: Instant) -> Result<(), LogError> {
        self.now = self.now.max(sample);
        let start = *self.batch_start.get_or_insert(self.now);
        if self.now.since(start) >= BATCH || self.batch.bytes.len() >= BATCH_BYTES {
            self.hand_over()?;
            self.batch_start = Some(self.now);
        }
        Ok(())
    }

    fn hand_over(&mut self) -> Result<(), LogError> {
        let Some(to_disk) = &self.to_disk else {
            return Err(LogError::Closed {
                path: self.path.clone(),
            });
        };
        let bytes = self.empties.try_recv().unwrap_or_default();
        let full = std::mem::replace(
            &mut self.batch,
            Batch {
                bytes,
                ..Batch::default()
            },
        );
        if to_disk.send(full).is_err() {
            // The thread has ended, so it has an error to tell.
            self.close()?;
            return Err(LogError::Closed {
                path: self.path.clone(),
            });
        }
        Ok(())
    }

    fn close(&mut self) -> Result<LogSummary, LogError> {
        self.to_disk = None;
        let path = || self.path.clone();
        match self.thread.take().map(JoinHandle::join) {
            None => Err(LogError::Closed { path: path() }),
            Some(Err(_)) => Err(LogError::WriterPanicked { path: path() }),
            Some(Ok(Err(source))) => Err(LogError::Write {
                path: path(),
                source,
            }),
            Some(Ok(Ok(summary))) => Ok(summary),
        }
    }
}

impl Drop for RideLog {
    fn drop(&mut self) {
        if self.thread.is_some() {
            // Nobody is left to hear of an error.
            let _ = self.hand_over();
            let _ = self.close();
        }
    }
}
