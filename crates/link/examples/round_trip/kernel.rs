//! Ways on which the kernel wakes the other side.

use crate::spin::{Mailbox, Map};
use crate::{Any, Times, measure, start};
use rustix::thread::futex;
use std::io::{Read, Write};
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::process::Stdio;
use std::sync::atomic::Ordering;
use twinhub_types::{ControllerFrame, PlantFrame, Wire};

fn sleep_for<T: Copy>(mailbox: &Mailbox<T>, tick: u64) -> T {
    let wanted = tick as u32 + 1;
    loop {
        let seen = mailbox.full.load(Ordering::Acquire);
        if seen == wanted {
            return mailbox.take();
        }
        // Returns at once if the number has changed meanwhile.
        let _ = futex::wait(&mailbox.full, futex::Flags::empty(), seen, None);
    }
}

fn put_and_wake<T: Copy>(mailbox: &Mailbox<T>, tick: u64, frame: &T) {
    mailbox.put(tick, frame);
    let _ = futex::wake(&mailbox.full, futex::Flags::empty(), 1);
}

pub fn futex_plant(ride: &str, ticks: u64) -> Result<Times, Any> {
    let map = Map::new(ride, true)?;
    let mut other = start(ride, ticks, Stdio::null(), Stdio::null())?;
    let mut frame = PlantFrame::default();
    let times = measure(ticks, |tick| {
        frame.header.tick = tick;
        put_and_wake(&map.shared.out, tick, &frame);
        std::hint::black_box(sleep_for(&map.shared.back, tick));
        Ok(())
    })?;
    other.wait()?;
    Ok(times)
}

pub fn futex_controller(ride: &str, ticks: u64) -> Result<(), Any> {
    let map = Map::new(ride, false)?;
    let mut answer = ControllerFrame::default();
    for tick in 0..ticks {
        answer.header = sleep_for(&map.shared.out, tick).header;
        put_and_wake(&map.shared.back, tick, &answer);
    }
    Ok(())
}

/// Frames over a stream of bytes each way.
fn stream_plant(mut to: impl Write, mut from: impl Read, ticks: u64) -> Result<Times, Any> {
    let mut frame = PlantFrame::default();
    let mut out = [0; PlantFrame::SIZE];
    let mut back = [0; ControllerFrame::SIZE];
    measure(ticks, |tick| {
        frame.header.tick = tick;
        frame.put(&mut out).ok_or("room for a frame")?;
        to.write_all(&out)?;
        from.read_exact(&mut back)?;
        std::hint::black_box(ControllerFrame::get(&back));
        Ok(())
    })
}

fn stream_controller(mut to: impl Write, mut from: impl Read, ticks: u64) -> Result<(), Any> {
    let mut answer = ControllerFrame::default();
    let mut input = [0; PlantFrame::SIZE];
    let mut out = [0; ControllerFrame::SIZE];
    for _ in 0..ticks {
        from.read_exact(&mut input)?;
        answer.header = PlantFrame::get(&input).ok_or("a frame")?.0.header;
        answer.put(&mut out).ok_or("room for a frame")?;
        to.write_all(&out)?;
    }
    Ok(())
}

/// The other side has the pipes or the socket as standard input and output.
fn stream_other(ticks: u64) -> Result<(), Any> {
    let input = std::fs::File::from(rustix::io::dup(std::io::stdin())?);
    let output = std::fs::File::from(rustix::io::dup(std::io::stdout())?);
    stream_controller(output, input, ticks)
}

pub fn pipe_plant(ride: &str, ticks: u64) -> Result<Times, Any> {
    let mut other = start(ride, ticks, Stdio::piped(), Stdio::piped())?;
    let to = std::fs::File::from(OwnedFd::from(other.stdin.take().ok_or("a pipe")?));
    let from = std::fs::File::from(OwnedFd::from(other.stdout.take().ok_or("a pipe")?));
    let times = stream_plant(to, from, ticks)?;
    other.wait()?;
    Ok(times)
}

pub fn pipe_controller(_ride: &str, ticks: u64) -> Result<(), Any> {
    stream_other(ticks)
}

pub fn socket_plant(ride: &str, ticks: u64) -> Result<Times, Any> {
    let (ours, theirs) = UnixStream::pair()?;
    let input = OwnedFd::from(theirs.try_clone()?);
    let mut other = start(ride, ticks, input.into(), OwnedFd::from(theirs).into())?;
    let times = stream_plant(&ours, &ours, ticks)?;
    other.wait()?;
    Ok(times)
}

pub fn socket_controller(_ride: &str, ticks: u64) -> Result<(), Any> {
    stream_other(ticks)
}
