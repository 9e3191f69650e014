//! Who sleeps: one page shared by both sides, without a name, that vanishes with them.
//!
//! Each side raises its flag before it sleeps and looks once more for a frame; the other side
//! publishes its frame and then looks at that flag. Both use sequentially consistent order, so
//! one of the two always sees the other. A flag that lies costs at most one needless or one late
//! wake-up: every sleep is bounded.

use crate::LinkError;
use crate::hello::Role;
use rustix::fs::{
    MemfdFlags, SealFlags, fcntl_add_seals, fcntl_get_seals, ftruncate, memfd_create,
};
use rustix::mm::{MapFlags, ProtFlags, mmap, munmap};
use std::os::fd::OwnedFd;
use std::sync::atomic::{AtomicU32, Ordering, fence};

const BYTES: usize = 4096;
/// The flags lie in cache lines of their own.
const STRIDE_WORDS: usize = 32;

pub(crate) struct Bell {
    page: *mut AtomicU32,
    own: usize,
    other: usize,
}

impl Bell {
    /// A new page, and the file to hand to the other side.
    pub(crate) fn create(role: Role) -> Result<(Self, OwnedFd), LinkError> {
        let file = memfd_create(
            "twinhub-bell",
            MemfdFlags::CLOEXEC | MemfdFlags::ALLOW_SEALING,
        )
        .map_err(|e| LinkError::os("creating the shared page", e))?;
        ftruncate(&file, BYTES as u64).map_err(|e| LinkError::os("sizing the shared page", e))?;
        // Nobody can shrink it under us, which would end the ride with a bus error.
        fcntl_add_seals(&file, SealFlags::SHRINK | SealFlags::GROW | SealFlags::SEAL)
            .map_err(|e| LinkError::os("sealing the shared page", e))?;
        Ok((Self::map(role, &file)?, file))
    }

    /// The page of the other side.
    pub(crate) fn open(role: Role, file: &OwnedFd) -> Result<Self, LinkError> {
        let seals =
            fcntl_get_seals(file).map_err(|e| LinkError::os("checking the shared page", e))?;
        let size = rustix::fs::fstat(file).map_err(|e| LinkError::os("checking the page", e))?;
        if !seals.contains(SealFlags::SHRINK) || size.st_size < BYTES as i64 {
            return Err(LinkError::shared_memory(
                "mapping the shared page",
                "not sealed or short",
            ));
        }
        Self::map(role, file)
    }

    fn map(role: Role, file: &OwnedFd) -> Result<Self, LinkError> {
        // SAFETY: a new mapping at an address of the kernel's choice; the file cannot shrink.
        let page = unsafe {
            mmap(
                std::ptr::null_mut(),
                BYTES,
                ProtFlags::READ | ProtFlags::WRITE,
                MapFlags::SHARED,
                file,
                0,
            )
        }
        .map_err(|e| LinkError::os("mapping the shared page", e))?;
        let (own, other) = match role {
            Role::Plant => (0, STRIDE_WORDS),
            Role::Controller => (STRIDE_WORDS, 0),
        };
        Ok(Self {
            page: page.cast(),
            own,
            other,
        })
    }

    fn flag(&self, at: usize) -> &AtomicU32 {
        // SAFETY: `at` is 0 or STRIDE_WORDS, inside the mapped page, which lives as long as self;
        // an AtomicU32 may be changed by others at any time.
        unsafe { &*self.page.add(at) }
    }

    /// Says that this side is about to sleep. Look for a frame once more after this.
    pub(crate) fn lie_down(&self) {
        self.flag(self.own).store(1, Ordering::SeqCst);
        fence(Ordering::SeqCst);
    }

    /// Says that this side is awake.
    pub(crate) fn get_up(&self) {
        self.flag(self.own).store(0, Ordering::SeqCst);
    }

    /// True if the other side sleeps. Ask after publishing a frame.
    pub(crate) fn other_sleeps(&self) -> bool {
        fence(Ordering::SeqCst);
        self.flag(self.other).load(Ordering::SeqCst) != 0
    }
}

impl Drop for Bell {
    fn drop(&mut self) {
        // SAFETY: mapped in `map`, unmapped only here.
        let _ = unsafe { munmap(self.page.cast(), BYTES) };
    }
}
