//! iceoryx2, and nothing else of this crate knows it: one blackboard each way, with one entry.
//!
//! A blackboard holds the newest frame and no queue, which is all that one frame each way and tick
//! need: measured in `examples/round_trip.rs`, it is the fastest of iceoryx2's patterns, and a
//! receiver that comes late finds the newest frame and not the oldest.

use crate::LinkError;
use crate::hello::Role;
use crate::ride::{close_to_others, session_prefix};
use iceoryx2::port::reader::{BlackboardValue, EntryHandle, Reader};
use iceoryx2::port::writer::{EntryHandleMut, Writer};
use iceoryx2::prelude::*;
use iceoryx2::service::port_factory::blackboard::PortFactory;
use std::fmt::Debug;
use std::time::Duration;
use twinhub_types::{ControllerFrame, PlantFrame};

/// The key of the only entry of a blackboard.
const KEY: u64 = 0;

type Ipc = ipc::Service;

/// Room for one frame in shared memory.
pub(crate) trait Slot: ZeroCopySend + Debug + Copy + Default + 'static {
    /// What lies in it.
    type Frame: Copy;
    /// Name of the service.
    const SERVICE: &'static str;
    /// Puts a frame in.
    fn of(frame: &Self::Frame) -> Self;
    /// Takes the frame out.
    fn frame(&self) -> Self::Frame;
}

#[cfg(target_endian = "big")]
compile_error!("frames lie in shared memory as on the wire: little endian");

macro_rules! slot {
    ($slot:ident, $frame:ident, $name:literal, $service:literal) => {
        /// One frame: `repr(C)`, without padding, its bytes as on the wire.
        #[derive(Clone, Copy, Debug, Default)]
        #[repr(transparent)]
        pub(crate) struct $slot($frame);

        // SAFETY: `repr(C)` all the way down, integers and floats only (`message!` sees to it):
        // no pointers, no value that can be invalid, and nothing that runs when it is dropped.
        unsafe impl ZeroCopySend for $slot {
            unsafe fn type_name() -> &'static str {
                $name
            }
        }

        impl Slot for $slot {
            type Frame = $frame;
            const SERVICE: &'static str = $service;
            #[inline]
            fn of(frame: &$frame) -> Self {
                Self(*frame)
            }
            #[inline]
            fn frame(&self) -> $frame {
                self.0
            }
        }
    };
}
slot!(
    PlantSlot,
    PlantFrame,
    "twinhub::PlantFrame",
    "twinhub/plant"
);
slot!(
    ControllerSlot,
    ControllerFrame,
    "twinhub::ControllerFrame",
    "twinhub/controller"
);

/// One side's two services: `O` goes out, `I` comes in.
pub(crate) struct Channels<O: Slot, I: Slot> {
    // In the order of destruction: entries and ports before the node that they belong to.
    out: EntryHandleMut<Ipc, u64, O>,
    input: EntryHandle<Ipc, u64, I>,
    last: BlackboardValue<I>,
    _writer: Writer<Ipc, u64>,
    _reader: Reader<Ipc, u64>,
    _node: Node<Ipc>,
}

impl<O: Slot, I: Slot> Channels<O, I> {
    /// The plant creates the services of a session, the controller opens them.
    pub(crate) fn new(role: Role, root: &std::path::Path, session: u64) -> Result<Self, LinkError> {
        set_log_level(LogLevel::Fatal);
        let mut config = Config::default();
        let root = root.to_str().unwrap_or_default();
        config.global.set_root_path(
            &Path::new(root.as_bytes()).map_err(|e| failed("naming the run directory", e))?,
        );
        config.global.prefix = FileName::new(session_prefix(session).as_bytes())
            .map_err(|e| failed("naming the session", e))?;
        // Each session has names of its own: there are never dead nodes of others in it.
        config.global.node.cleanup_dead_nodes_on_creation = false;
        config.global.node.cleanup_dead_nodes_on_destruction = false;
        config.global.service.cleanup_dead_nodes_on_open = false;
        config.global.creation_timeout = Duration::from_secs(2);
        let node = NodeBuilder::new()
            .config(&config)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<Ipc>()
            .map_err(|e| failed("creating a node", e))?;
        let writer = service::<O>(&node, role)?
            .writer_builder()
            .create()
            .map_err(|e| failed("creating the writer", e))?;
        let out = writer
            .entry::<O>(&KEY)
            .map_err(|e| failed("finding room for our frames", e))?;
        let reader = service::<I>(&node, role)?
            .reader_builder()
            .create()
            .map_err(|e| failed("creating the reader", e))?;
        let input = reader
            .entry::<I>(&KEY)
            .map_err(|e| failed("finding the other side's frames", e))?;
        close_to_others(session)?;
        Ok(Self {
            out,
            last: input.get(),
            input,
            _writer: writer,
            _reader: reader,
            _node: node,
        })
    }

    /// Publishes `frame` in place of the last one.
    #[inline]
    pub(crate) fn send(&self, frame: &O::Frame) {
        self.out.update_with_copy(O::of(frame));
    }

    /// True if a frame has come since the last call of [`receive`](Self::receive).
    #[inline]
    pub(crate) fn has_news(&self) -> bool {
        !self.input.is_up_to_date(&self.last)
    }

    /// The newest frame, if one has come since the last call: copied once, not yet validated.
    #[inline]
    pub(crate) fn receive(&mut self) -> Option<I::Frame> {
        if !self.has_news() {
            return None;
        }
        self.last = self.input.get();
        Some(self.last.frame())
    }
}

fn service<S: Slot>(node: &Node<Ipc>, role: Role) -> Result<PortFactory<Ipc, u64>, LinkError> {
    let name = ServiceName::new(S::SERVICE).map_err(|e| failed("naming the service", e))?;
    match role {
        Role::Plant => node
            .service_builder(&name)
            .blackboard_creator::<u64>()
            .max_readers(1)
            .max_nodes(2)
            .add::<S>(KEY, S::default())
            .create()
            .map_err(|e| failed("creating the service", e)),
        Role::Controller => node
            .service_builder(&name)
            .blackboard_opener::<u64>()
            .open()
            .map_err(|e| failed("opening the service", e)),
    }
}

fn failed(what: &'static str, detail: impl Debug) -> LinkError {
    LinkError::shared_memory(what, detail)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ride::{Claim, RideName, RunDir, session_root};
    use std::sync::atomic::{AtomicBool, Ordering};

    /// Never waiting for its reader, a writer that never stops is the worst that a peer can do to
    /// a blackboard.
    #[test]
    fn a_peer_that_writes_without_end_cannot_hold_a_reader_up() {
        let dir = tempfile::tempdir().expect("a directory");
        let run_dir = RunDir::at(dir.path().join("run"));
        let name = RideName::new("flood").expect("a name");
        let claim = Claim::new(&run_dir, &name).expect("a ride");
        let root = session_root(&run_dir.ride(&name), claim.session());
        let flooding = AtomicBool::new(true);
        let mut plant =
            Channels::<PlantSlot, ControllerSlot>::new(Role::Plant, &root, claim.session())
                .expect("the plant's channels");
        std::thread::scope(|scope| {
            let writer = scope.spawn(|| {
                let hostile = Channels::<ControllerSlot, PlantSlot>::new(
                    Role::Controller,
                    &root,
                    claim.session(),
                )
                .expect("the controller's channels");
                let mut frame = ControllerFrame::default();
                while flooding.load(Ordering::Relaxed) {
                    // Each frame says the same in two places.
                    frame.header.tick = frame.header.tick.wrapping_add(1);
                    frame.header.sequence = frame.header.tick;
                    hostile.send(&frame);
                }
            });
            let mut read = 0;
            while read < 20_000 && !writer.is_finished() {
                if let Some(frame) = plant.receive() {
                    assert_eq!(frame.header.tick, frame.header.sequence, "a torn frame");
                    read += 1;
                }
            }
            flooding.store(false, Ordering::Relaxed);
            writer.join().expect("the writer ends");
            assert_eq!(read, 20_000);
        });
    }
}
