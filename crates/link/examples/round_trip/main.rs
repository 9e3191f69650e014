//! Round trip of one tick between two processes, beside what it could be made of.
//!
//! `cargo run --release -p twinhub-link --example round_trip -- [TICKS] [--rounds N] [--json]`
//! starts itself as the other side. All ways in one run, round after round, one after the other;
//! the best round of each counts, because a shared machine only ever makes things slower. Frames
//! as in a ride: the plant's out, the controller's back.

mod bare;
mod kernel;
mod spin;

use hdrhistogram::Histogram;
use std::process::{Child, Command, Stdio};
use std::time::Instant;
use twinhub_link::timing::Quantiles;
use twinhub_link::{
    ControllerEnd, ControllerPort, PlantOffer, RideName, Settings, Waiting, watch_parent,
};
use twinhub_types::messages::PROTOCOL_HASH;
use twinhub_types::{ControllerFrame, PlantFrame, RideState};

type Any = Box<dyn std::error::Error>;
type Times = Histogram<u64>;

/// A way of sending a frame and getting one back.
struct Way {
    name: &'static str,
    /// Wakes the other side by the kernel each time, which takes much longer.
    sleeps: bool,
    plant: fn(&str, u64) -> Result<Times, Any>,
    controller: fn(&str, u64) -> Result<(), Any>,
}

const WAYS: &[Way] = &[
    Way {
        name: "raw shared memory, spinning",
        sleeps: false,
        plant: spin::plant,
        controller: spin::controller,
    },
    Way {
        name: "iceoryx2 publish-subscribe",
        sleeps: false,
        plant: bare::pub_sub_plant,
        controller: bare::pub_sub_controller,
    },
    Way {
        name: "iceoryx2 request-response",
        sleeps: false,
        plant: bare::request_plant,
        controller: bare::request_controller,
    },
    Way {
        name: "iceoryx2 blackboard",
        sleeps: false,
        plant: bare::blackboard_plant,
        controller: bare::blackboard_controller,
    },
    Way {
        name: "link, spin",
        sleeps: false,
        plant: |ride, ticks| link_plant(ride, ticks, Waiting::Spin),
        controller: |ride, _| link_controller(ride, Waiting::Spin),
    },
    Way {
        name: "link, block",
        sleeps: true,
        plant: |ride, ticks| link_plant(ride, ticks, Waiting::Block),
        controller: |ride, _| link_controller(ride, Waiting::Block),
    },
    Way {
        name: "futex",
        sleeps: true,
        plant: kernel::futex_plant,
        controller: kernel::futex_controller,
    },
    Way {
        name: "pipe",
        sleeps: true,
        plant: kernel::pipe_plant,
        controller: kernel::pipe_controller,
    },
    Way {
        name: "Unix socket",
        sleeps: true,
        plant: kernel::socket_plant,
        controller: kernel::socket_controller,
    },
];

fn settings(ride: &str, waiting: Waiting) -> Result<Settings, Any> {
    Ok(Settings {
        waiting,
        ..Settings::new(RideName::new(ride)?)
    })
}

fn link_controller(ride: &str, waiting: Waiting) -> Result<(), Any> {
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

fn link_plant(ride: &str, ticks: u64, waiting: Waiting) -> Result<Times, Any> {
    let offer = PlantOffer::open(settings(ride, waiting)?)?;
    let mut other = start(ride, ticks, Stdio::null(), Stdio::null())?;
    let mut end = offer.accept()?;
    let mut frame = PlantFrame::default();
    frame.header.protocol_hash = PROTOCOL_HASH;
    let times = measure(ticks, |tick| {
        frame.header.tick = tick;
        frame.header.sequence = tick;
        if tick + 1 == ticks {
            frame.header.state = RideState::Finished as u32;
        }
        end.exchange(&frame)?;
        Ok(())
    })?;
    drop(end);
    other.wait()?;
    Ok(times)
}

/// Times of `ticks` exchanges.
fn measure(ticks: u64, mut exchange: impl FnMut(u64) -> Result<(), Any>) -> Result<Times, Any> {
    let mut times = Times::new(3)?;
    for tick in 0..ticks {
        let start = Instant::now();
        exchange(tick)?;
        times.record(start.elapsed().as_nanos() as u64)?;
    }
    Ok(times)
}

/// This program again, as the other side of the way that runs in `ride`.
fn start(ride: &str, ticks: u64, input: Stdio, output: Stdio) -> Result<Child, Any> {
    Ok(Command::new(std::env::current_exe()?)
        .arg(ticks.to_string())
        .env("ROUND_TRIP_RIDE", ride)
        .env("ROUND_TRIP_PARENT", std::process::id().to_string())
        .stdin(input)
        .stdout(output)
        .spawn()?)
}

/// Name of a ride from which the other side knows the way.
fn ride_name(way: usize, round: usize) -> String {
    format!("round_trip_{way}_{}_{round}", std::process::id())
}

/// Cores of the two sides.
const OWN_CORE: usize = 0;
const OTHER_CORE: usize = 1;

/// Keeps this thread on core number `number` of the machine's, if there are as many: two
/// sides that share a core cannot spin, and where they land is chance on a busy machine.
fn stay_on(number: usize) -> Result<(), Any> {
    use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};
    // A child has inherited its parent's one core; what the machine has is asked of process 1.
    let all = sched_getaffinity(rustix::process::Pid::from_raw(1))?;
    let mut cores = (0..CpuSet::MAX_CPU).filter(|core| all.is_set(*core));
    if let Some(core) = cores.nth(number) {
        let mut one = CpuSet::new();
        one.set(core);
        // A container may allow other cores only; then chance decides.
        let _ = sched_setaffinity(None, &one);
    }
    Ok(())
}

fn other_side(ride: &str) -> Result<(), Any> {
    if !watch_parent(std::env::var("ROUND_TRIP_PARENT")?.parse()?) {
        return Ok(());
    }
    stay_on(OTHER_CORE)?;
    let way: usize = ride
        .split('_')
        .nth(2)
        .ok_or("no way in the name")?
        .parse()?;
    let ticks = std::env::args().nth(1).ok_or("no ticks")?.parse()?;
    (WAYS[way].controller)(ride, ticks)
}

fn main() -> Result<(), Any> {
    iceoryx2::prelude::set_log_level(iceoryx2::prelude::LogLevel::Error);
    if let Ok(ride) = std::env::var("ROUND_TRIP_RIDE") {
        return other_side(&ride);
    }
    let (mut ticks, mut rounds, mut json) = (200_000, 5, false);
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        match word.as_str() {
            "--json" => json = true,
            "--rounds" => rounds = words.next().ok_or("--rounds N")?.parse()?,
            number => ticks = number.parse()?,
        }
    }
    stay_on(OWN_CORE)?;
    let mut best: Vec<Option<Times>> = WAYS.iter().map(|_| None).collect();
    for round in 0..rounds {
        for (i, way) in WAYS.iter().enumerate() {
            let ticks = if way.sleeps { ticks / 20 } else { ticks };
            let times = (way.plant)(&ride_name(i, round), ticks.max(100))
                .map_err(|e| format!("{}: {e}", way.name))?;
            let better = |old: &Times| times.value_at_quantile(0.5) < old.value_at_quantile(0.5);
            if best[i].as_ref().is_none_or(better) {
                best[i] = Some(times);
            }
        }
    }
    let rows: Vec<(&str, f64, Quantiles)> = WAYS
        .iter()
        .zip(&best)
        .filter_map(|(way, times)| {
            let times = times.as_ref()?;
            Some((way.name, times.min() as f64 * 1e-3, Quantiles::of(times)))
        })
        .collect();
    if json {
        let words: Vec<String> = rows
            .iter()
            .map(|(name, least, q)| {
                format!(
                    r#"{{"name":"{name}","least_us":{least},"p50_us":{},"p99_us":{},"p999_us":{},"max_us":{}}}"#,
                    q.p50, q.p99, q.p999, q.max
                )
            })
            .collect();
        println!(r#"{{"schema_version":1,"ways":[{}]}}"#, words.join(","));
        return Ok(());
    }
    println!("best of {rounds} rounds, us       least      p50      p99    p99.9      max");
    for (name, least, q) in rows {
        println!(
            "{name:<28} {least:8.3} {:8.3} {:8.3} {:8.3} {:8.0}",
            q.p50, q.p99, q.p999, q.max
        );
    }
    Ok(())
}
