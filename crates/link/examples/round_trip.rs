//! Round trip of one tick, beside a bare iceoryx2 ping-pong of the same frames.
//!
//! `cargo run --release -p twinhub-link --example round_trip [TICKS]` starts itself as the other
//! side. Frames as in a ride: the plant's out, the controller's back.

use hdrhistogram::Histogram;
use iceoryx2::prelude::*;
use std::process::{Child, Command};
use std::time::Instant;
use twinhub_link::{
    ControllerEnd, ControllerPort, PlantOffer, RideName, Settings, Waiting, watch_parent,
};
use twinhub_types::messages::PROTOCOL_HASH;
use twinhub_types::{ControllerFrame, PlantFrame, RideState, Wire};

type Any = Box<dyn std::error::Error>;

#[derive(Clone, Copy, Debug, ZeroCopySend)]
#[repr(C)]
struct Out([u8; PlantFrame::SIZE]);

#[derive(Clone, Copy, Debug, ZeroCopySend)]
#[repr(C)]
struct Back([u8; ControllerFrame::SIZE]);

fn settings(ride: &str, waiting: Waiting) -> Result<Settings, Any> {
    Ok(Settings {
        waiting,
        ..Settings::new(RideName::new(ride)?)
    })
}

fn link_child(ride: &str, waiting: Waiting) -> Result<(), Any> {
    let mut end = ControllerEnd::connect(settings(ride, waiting)?)?;
    let mut answer = ControllerFrame::default();
    loop {
        let frame = end.receive()?;
        answer.header = frame.header;
        end.send(&answer)?;
        if RideState::from_u32(frame.header.state) != RideState::Running {
            return Ok(end.finish()?);
        }
    }
}

fn link_plant(ride: &str, waiting: Waiting, ticks: u64) -> Result<Histogram<u64>, Any> {
    let offer = PlantOffer::open(settings(ride, waiting)?)?;
    let mut child = start("link", ride, waiting)?;
    let mut end = offer.accept()?;
    let mut times = Histogram::new(3)?;
    let mut frame = PlantFrame::default();
    frame.header.protocol_hash = PROTOCOL_HASH;
    for tick in 0..ticks {
        frame.header.tick = tick;
        frame.header.sequence = tick;
        if tick + 1 == ticks {
            frame.header.state = RideState::Finished as u32;
        }
        let start = Instant::now();
        end.exchange(&frame)?;
        times.record(start.elapsed().as_nanos() as u64)?;
    }
    drop(end);
    child.wait()?;
    Ok(times)
}

type Service<T> =
    iceoryx2::service::port_factory::publish_subscribe::PortFactory<ipc::Service, T, ()>;

fn bare_config(ride: &str) -> Result<Config, Any> {
    let mut config = Config::default();
    config
        .global
        .set_root_path(&Path::new(format!("/tmp/{ride}").as_bytes())?);
    config.global.prefix = FileName::new(format!("{ride}.").as_bytes())?;
    Ok(config)
}

fn bare_service<T: std::fmt::Debug + ZeroCopySend + 'static>(
    node: &Node<ipc::Service>,
    name: &str,
) -> Result<Service<T>, Any> {
    Ok(node
        .service_builder(&name.try_into()?)
        .publish_subscribe::<T>()
        .enable_safe_overflow(false)
        .history_size(0)
        .subscriber_max_buffer_size(2)
        .max_publishers(1)
        .open_or_create()?)
}

fn bare_child(ride: &str, ticks: u64) -> Result<(), Any> {
    let node = NodeBuilder::new()
        .config(&bare_config(ride)?)
        .create::<ipc::Service>()?;
    let receive = bare_service::<Out>(&node, "out")?
        .subscriber_builder()
        .create()?;
    let send = bare_service::<Back>(&node, "back")?
        .publisher_builder()
        .create()?;
    for _ in 0..ticks {
        let frame = loop {
            if let Some(sample) = receive.receive()? {
                break *sample;
            }
            std::hint::spin_loop();
        };
        send.loan_uninit()?
            .write_payload(Back([frame.0[0]; ControllerFrame::SIZE]))
            .send()?;
    }
    std::thread::sleep(std::time::Duration::from_millis(200));
    Ok(())
}

fn bare_plant(ride: &str, ticks: u64) -> Result<Histogram<u64>, Any> {
    let mut times = Histogram::new(3)?;
    {
        let node = NodeBuilder::new()
            .config(&bare_config(ride)?)
            .create::<ipc::Service>()?;
        let out = bare_service::<Out>(&node, "out")?;
        let send = out.publisher_builder().create()?;
        let back = bare_service::<Back>(&node, "back")?;
        let receive = back.subscriber_builder().create()?;
        let mut child = start("bare", ride, Waiting::Spin)?;
        while out.dynamic_config().number_of_subscribers() < 1
            || back.dynamic_config().number_of_publishers() < 1
        {
            std::thread::yield_now();
        }
        for tick in 0..ticks {
            let start = Instant::now();
            send.loan_uninit()?
                .write_payload(Out([tick as u8; PlantFrame::SIZE]))
                .send()?;
            loop {
                if let Some(sample) = receive.receive()? {
                    std::hint::black_box(*sample);
                    break;
                }
                std::hint::spin_loop();
            }
            times.record(start.elapsed().as_nanos() as u64)?;
        }
        child.wait()?;
    }
    let _ = std::fs::remove_dir_all(format!("/tmp/{ride}"));
    for entry in std::fs::read_dir("/dev/shm")?.flatten() {
        if entry
            .file_name()
            .to_string_lossy()
            .starts_with(&format!("{ride}."))
        {
            std::fs::remove_file(entry.path())?;
        }
    }
    Ok(times)
}

fn start(role: &str, ride: &str, waiting: Waiting) -> Result<Child, Any> {
    let ticks = std::env::args().nth(1).unwrap_or_default();
    Ok(Command::new(std::env::current_exe()?)
        .arg(ticks)
        .env("ROUND_TRIP_ROLE", role)
        .env("ROUND_TRIP_RIDE", ride)
        .env(
            "ROUND_TRIP_WAITING",
            if waiting == Waiting::Spin {
                "spin"
            } else {
                "block"
            },
        )
        .env("ROUND_TRIP_PARENT", std::process::id().to_string())
        .spawn()?)
}

fn main() -> Result<(), Any> {
    let ticks: u64 = std::env::args()
        .nth(1)
        .map_or(Ok(200_000), |text| text.parse())?;
    let var = |name: &str| std::env::var(name).unwrap_or_default();
    set_log_level(LogLevel::Error);
    let ride = var("ROUND_TRIP_RIDE");
    let role = var("ROUND_TRIP_ROLE");
    if !role.is_empty() && !watch_parent(var("ROUND_TRIP_PARENT").parse()?) {
        return Ok(());
    }
    match role.as_str() {
        "link" => return link_child(&ride, var("ROUND_TRIP_WAITING").parse()?),
        "bare" => return bare_child(&ride, ticks),
        _ => {}
    }
    let pid = std::process::id();
    println!("{ticks} ticks, us     mean      p50      p99    p99.9      max");
    let row = |name: &str, times: Histogram<u64>| {
        let us = |q: f64| times.value_at_quantile(q) as f64 * 1e-3;
        let max = times.max() as f64 * 1e-3;
        println!(
            "{name:<18} {:8.2} {:8.2} {:8.2} {:8.2} {max:8.0}",
            times.mean() * 1e-3,
            us(0.5),
            us(0.99),
            us(0.999)
        );
    };
    for round in 0..3 {
        row(
            "bare iceoryx2",
            bare_plant(&format!("round_trip_{pid}_{round}"), ticks)?,
        );
        row(
            "link, spin",
            link_plant(&format!("round_trip_{pid}"), Waiting::Spin, ticks)?,
        );
    }
    row(
        "link, block",
        link_plant(&format!("round_trip_{pid}"), Waiting::Block, ticks / 10)?,
    );
    Ok(())
}
