//! Two cache lines' worth of frames in a shared page, and two counters to spin on: nothing can be
//! faster between two processes.

use crate::{Any, Times, measure, start};
use rustix::mm::{MapFlags, ProtFlags, mmap, munmap};
use std::fs::OpenOptions;
use std::process::Stdio;
use std::sync::atomic::{AtomicU32, Ordering};
use twinhub_types::{ControllerFrame, PlantFrame};

/// What both sides map.
#[repr(C, align(128))]
pub struct Shared {
    pub out: Mailbox<PlantFrame>,
    pub back: Mailbox<ControllerFrame>,
}

/// A frame with the number of its tick, plus one.
#[repr(C, align(128))]
pub struct Mailbox<T> {
    pub full: AtomicU32,
    frame: std::cell::UnsafeCell<T>,
}

impl<T: Copy> Mailbox<T> {
    /// Puts a frame in for `tick`; only its one writer does.
    pub fn put(&self, tick: u64, frame: &T) {
        // SAFETY: the reader has taken the frame before, or it would not have answered.
        unsafe { self.frame.get().write(*frame) };
        self.full.store(tick as u32 + 1, Ordering::Release);
    }

    /// Takes the frame out; call it once `full` says that it is there.
    pub fn take(&self) -> T {
        // SAFETY: the writer waits for our answer before it writes again.
        unsafe { self.frame.get().read() }
    }

    fn wait(&self, tick: u64) -> T {
        while self.full.load(Ordering::Acquire) != tick as u32 + 1 {
            std::hint::spin_loop();
        }
        self.take()
    }
}

/// A file in shared memory, mapped; removed by the side that made it.
pub struct Map {
    pub shared: &'static Shared,
    path: Option<String>,
}

impl Map {
    pub fn new(ride: &str, create: bool) -> Result<Self, Any> {
        let path = format!("/dev/shm/{ride}");
        let file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(create)
            .truncate(create)
            .open(&path)?;
        let size = std::mem::size_of::<Shared>();
        if create {
            file.set_len(size as u64)?;
        }
        // SAFETY: a new mapping, as long as the file; zeros are a valid `Shared`.
        let page = unsafe {
            mmap(
                std::ptr::null_mut(),
                size,
                ProtFlags::READ | ProtFlags::WRITE,
                MapFlags::SHARED,
                &file,
                0,
            )?
        };
        Ok(Self {
            // SAFETY: unmapped in `drop`, after the last use.
            shared: unsafe { &*page.cast() },
            path: create.then_some(path),
        })
    }
}

impl Drop for Map {
    fn drop(&mut self) {
        let page = std::ptr::from_ref(self.shared).cast_mut().cast();
        // SAFETY: mapped in `new`.
        let _ = unsafe { munmap(page, std::mem::size_of::<Shared>()) };
        if let Some(path) = &self.path {
            let _ = std::fs::remove_file(path);
        }
    }
}

pub fn plant(ride: &str, ticks: u64) -> Result<Times, Any> {
    let map = Map::new(ride, true)?;
    let mut other = start(ride, ticks, Stdio::null(), Stdio::null())?;
    let mut frame = PlantFrame::default();
    let times = measure(ticks, |tick| {
        frame.header.tick = tick;
        map.shared.out.put(tick, &frame);
        std::hint::black_box(map.shared.back.wait(tick));
        Ok(())
    })?;
    other.wait()?;
    Ok(times)
}

pub fn controller(ride: &str, ticks: u64) -> Result<(), Any> {
    let map = Map::new(ride, false)?;
    let mut answer = ControllerFrame::default();
    for tick in 0..ticks {
        answer.header = map.shared.out.wait(tick).header;
        map.shared.back.put(tick, &answer);
    }
    Ok(())
}
