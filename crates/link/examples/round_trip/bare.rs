//! iceoryx2's patterns, with nothing around them: no handshake, no check, no watch of the peer.

use crate::{Any, Times, measure, start};
use iceoryx2::prelude::*;
use iceoryx2::service::port_factory::{blackboard, publish_subscribe, request_response};
use std::process::Stdio;
use twinhub_types::{ControllerFrame, PlantFrame, Wire};

#[derive(Clone, Copy, Debug, ZeroCopySend)]
#[repr(C)]
#[repr(align(8))]
struct Out([u8; PlantFrame::SIZE]);

#[derive(Clone, Copy, Debug, ZeroCopySend)]
#[repr(C)]
#[repr(align(8))]
struct Back([u8; ControllerFrame::SIZE]);

fn out(tick: u64) -> Out {
    Out([tick as u8; PlantFrame::SIZE])
}

fn back(to: &Out) -> Back {
    Back([to.0[0]; ControllerFrame::SIZE])
}

/// A node with names of its own; the plant's removes them.
struct Place {
    node: Node<ipc::Service>,
    ride: String,
    own: bool,
}

impl Place {
    fn new(ride: &str, own: bool) -> Result<Self, Any> {
        let mut config = Config::default();
        let root = format!("/tmp/{ride}");
        config.global.set_root_path(&Path::new(root.as_bytes())?);
        config.global.prefix = FileName::new(format!("{ride}.").as_bytes())?;
        let node = NodeBuilder::new()
            .config(&config)
            .create::<ipc::Service>()?;
        Ok(Self {
            node,
            ride: ride.to_owned(),
            own,
        })
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        if !self.own {
            return;
        }
        let _ = std::fs::remove_dir_all(format!("/tmp/{}", self.ride));
        for entry in std::fs::read_dir("/dev/shm")
            .into_iter()
            .flatten()
            .flatten()
        {
            let name = entry.file_name();
            if name
                .to_string_lossy()
                .starts_with(&format!("{}.", self.ride))
            {
                let _ = std::fs::remove_file(entry.path());
            }
        }
    }
}

/// Spins until `take` yields something.
fn spin<T>(mut take: impl FnMut() -> Result<Option<T>, Any>) -> Result<T, Any> {
    loop {
        if let Some(found) = take()? {
            return Ok(found);
        }
        std::hint::spin_loop();
    }
}

type PubSub<T> = publish_subscribe::PortFactory<ipc::Service, T, ()>;

fn pub_sub<T: std::fmt::Debug + ZeroCopySend + 'static>(
    place: &Place,
    name: &str,
) -> Result<PubSub<T>, Any> {
    Ok(place
        .node
        .service_builder(&name.try_into()?)
        .publish_subscribe::<T>()
        .enable_safe_overflow(false)
        .history_size(0)
        .subscriber_max_buffer_size(2)
        .max_publishers(1)
        .open_or_create()?)
}

pub fn pub_sub_controller(ride: &str, ticks: u64) -> Result<(), Any> {
    let place = Place::new(ride, false)?;
    let input = pub_sub::<Out>(&place, "out")?
        .subscriber_builder()
        .create()?;
    let send = pub_sub::<Back>(&place, "back")?
        .publisher_builder()
        .create()?;
    for _ in 0..ticks {
        let frame = spin(|| Ok(input.receive()?.map(|sample| *sample)))?;
        send.loan_uninit()?.write_payload(back(&frame)).send()?;
    }
    // The last answer goes with us.
    std::thread::sleep(std::time::Duration::from_millis(100));
    Ok(())
}

pub fn pub_sub_plant(ride: &str, ticks: u64) -> Result<Times, Any> {
    let place = Place::new(ride, true)?;
    let to = pub_sub::<Out>(&place, "out")?;
    let send = to.publisher_builder().create()?;
    let from = pub_sub::<Back>(&place, "back")?;
    let input = from.subscriber_builder().create()?;
    let mut other = start(ride, ticks, Stdio::null(), Stdio::null())?;
    while to.dynamic_config().number_of_subscribers() < 1
        || from.dynamic_config().number_of_publishers() < 1
    {
        std::thread::yield_now();
    }
    let times = measure(ticks, |tick| {
        send.loan_uninit()?.write_payload(out(tick)).send()?;
        std::hint::black_box(spin(|| Ok(input.receive()?.map(|sample| *sample)))?);
        Ok(())
    })?;
    other.wait()?;
    Ok(times)
}

type Requests = request_response::PortFactory<ipc::Service, Out, (), Back, ()>;

fn requests(place: &Place) -> Result<Requests, Any> {
    Ok(place
        .node
        .service_builder(&"tick".try_into()?)
        .request_response::<Out, Back>()
        .max_clients(1)
        .max_servers(1)
        .open_or_create()?)
}

pub fn request_controller(ride: &str, ticks: u64) -> Result<(), Any> {
    let place = Place::new(ride, false)?;
    let server = requests(&place)?.server_builder().create()?;
    for _ in 0..ticks {
        let request = spin(|| Ok(server.receive()?))?;
        let answer = back(&request);
        request.loan_uninit()?.write_payload(answer).send()?;
    }
    std::thread::sleep(std::time::Duration::from_millis(100));
    Ok(())
}

pub fn request_plant(ride: &str, ticks: u64) -> Result<Times, Any> {
    let place = Place::new(ride, true)?;
    let service = requests(&place)?;
    let client = service.client_builder().create()?;
    let mut other = start(ride, ticks, Stdio::null(), Stdio::null())?;
    while service.dynamic_config().number_of_servers() < 1 {
        std::thread::yield_now();
    }
    let times = measure(ticks, |tick| {
        let pending = client.loan_uninit()?.write_payload(out(tick)).send()?;
        std::hint::black_box(spin(|| Ok(pending.receive()?.map(|answer| *answer)))?);
        Ok(())
    })?;
    other.wait()?;
    Ok(times)
}

type Board = blackboard::PortFactory<ipc::Service, u64>;

fn board<T: Copy + std::fmt::Debug + ZeroCopySend + 'static>(
    place: &Place,
    name: &str,
    first: T,
) -> Result<Board, Any> {
    let builder = place.node.service_builder(&name.try_into()?);
    Ok(if place.own {
        builder
            .blackboard_creator::<u64>()
            .max_readers(1)
            .add::<T>(0, first)
            .create()?
    } else {
        builder.blackboard_opener::<u64>().open()?
    })
}

pub fn blackboard_controller(ride: &str, ticks: u64) -> Result<(), Any> {
    let place = Place::new(ride, false)?;
    let reader = board(&place, "out", out(0))?.reader_builder().create()?;
    let input = reader.entry::<Out>(&0)?;
    let mut seen = input.get();
    let writer = board(&place, "back", back(&out(0)))?
        .writer_builder()
        .create()?;
    let send = writer.entry::<Back>(&0)?;
    // Ready.
    send.update_with_copy(back(&out(0)));
    for _ in 0..ticks {
        while input.is_up_to_date(&seen) {
            std::hint::spin_loop();
        }
        seen = input.get();
        send.update_with_copy(back(&seen));
    }
    std::thread::sleep(std::time::Duration::from_millis(100));
    Ok(())
}

pub fn blackboard_plant(ride: &str, ticks: u64) -> Result<Times, Any> {
    let place = Place::new(ride, true)?;
    let writer = board(&place, "out", out(0))?.writer_builder().create()?;
    let send = writer.entry::<Out>(&0)?;
    let reader = board(&place, "back", back(&out(0)))?
        .reader_builder()
        .create()?;
    let input = reader.entry::<Back>(&0)?;
    let mut seen = input.get();
    let mut other = start(ride, ticks, Stdio::null(), Stdio::null())?;
    let mut wait = || {
        while input.is_up_to_date(&seen) {
            std::hint::spin_loop();
        }
        seen = input.get();
        std::hint::black_box(*seen);
    };
    wait();
    let times = measure(ticks, |tick| {
        send.update_with_copy(out(tick));
        wait();
        Ok(())
    })?;
    other.wait()?;
    Ok(times)
}
