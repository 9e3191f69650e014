//! iceoryx2, and nothing else of this crate knows it: one publish-subscribe service each way.

use crate::LinkError;
use crate::hello::Role;
use crate::ride::{close_to_others, session_prefix};
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::*;
use std::fmt::Debug;
use std::time::Duration;
use twinhub_types::{ControllerFrame, PlantFrame, Wire};

/// Room for one frame in shared memory: its bytes as on the wire, little endian, no padding.
pub(crate) trait Slot: ZeroCopySend + Debug + Copy + 'static {
    /// What lies in it.
    type Frame: Wire;
    /// Name of the service.
    const SERVICE: &'static str;
    /// Puts a frame in.
    fn of(frame: &Self::Frame) -> Self;
    /// Takes the frame out.
    fn frame(&self) -> Option<Self::Frame>;
}

macro_rules! slot {
    ($slot:ident, $frame:ident, $name:literal, $service:literal) => {
        /// Bytes of one frame.
        #[derive(Clone, Copy, Debug, ZeroCopySend)]
        #[repr(C)]
        #[repr(align(8))]
        #[type_name($name)]
        pub(crate) struct $slot {
            bytes: [u8; $frame::SIZE],
        }

        impl Slot for $slot {
            type Frame = $frame;
            const SERVICE: &'static str = $service;
            #[inline]
            fn of(frame: &$frame) -> Self {
                let mut slot = Self {
                    bytes: [0; $frame::SIZE],
                };
                let _full = frame.put(&mut slot.bytes);
                slot
            }
            #[inline]
            fn frame(&self) -> Option<$frame> {
                $frame::get(&self.bytes).map(|(frame, _)| frame)
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
    // In the order of destruction: ports before the node that they belong to.
    publisher: Publisher<ipc::Service, O, ()>,
    subscriber: Subscriber<ipc::Service, I, ()>,
    _node: Node<ipc::Service>,
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
            .create::<ipc::Service>()
            .map_err(|e| failed("creating a node", e))?;
        let out = service::<O>(&node, role)?;
        let publisher = out
            .publisher_builder()
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .max_loaned_samples(1)
            .create()
            .map_err(|e| failed("creating the publisher", e))?;
        let subscriber = service::<I>(&node, role)?
            .subscriber_builder()
            .create()
            .map_err(|e| failed("creating the subscriber", e))?;
        close_to_others(session)?;
        Ok(Self {
            publisher,
            subscriber,
            _node: node,
        })
    }

    /// Publishes `frame`. A frame that finds no room is lost, which the receiver sees by its
    /// sequence number; in lockstep there is always room.
    #[inline]
    pub(crate) fn send(&self, frame: &O::Frame) -> Result<(), LinkError> {
        let sample = self
            .publisher
            .loan_uninit()
            .map_err(|e| failed("finding room", e))?;
        sample
            .write_payload(O::of(frame))
            .send()
            .map(|_receivers| ())
            .map_err(|e| failed("publishing a frame", e))
    }

    /// The next frame, if one has come: copied once, not yet validated.
    #[inline]
    pub(crate) fn receive(&self) -> Result<Option<I::Frame>, LinkError> {
        let sample = self
            .subscriber
            .receive()
            .map_err(|e| failed("receiving a frame", e))?;
        // SAFETY: the payload is aligned and as long as the slot, and any bytes are a valid slot.
        // Volatile, because a broken peer may still write while we copy.
        let slot =
            sample.map(|sample| unsafe { std::ptr::from_ref(sample.payload()).read_volatile() });
        Ok(slot.and_then(|slot| slot.frame()))
    }
}

fn service<S: Slot>(
    node: &Node<ipc::Service>,
    role: Role,
) -> Result<
    iceoryx2::service::port_factory::publish_subscribe::PortFactory<ipc::Service, S, ()>,
    LinkError,
> {
    let name = ServiceName::new(S::SERVICE).map_err(|e| failed("naming the service", e))?;
    let builder = node
        .service_builder(&name)
        .publish_subscribe::<S>()
        .enable_safe_overflow(false)
        .history_size(0)
        .subscriber_max_buffer_size(2)
        .subscriber_max_borrowed_samples(1)
        .max_publishers(1)
        .max_subscribers(1)
        .max_nodes(2);
    match role {
        Role::Plant => builder
            .create()
            .map_err(|e| failed("creating the service", e)),
        Role::Controller => builder.open().map_err(|e| failed("opening the service", e)),
    }
}

fn failed(what: &'static str, detail: impl Debug) -> LinkError {
    LinkError::shared_memory(what, detail)
}
