//! One page shared by both sides, without a name, that vanishes with them: who sleeps, when the
//! last frame was sent, and the controller's account of itself.
//!
//! The bell: each side raises its flag before it sleeps and looks once more for a frame; the other side
//! publishes its frame and then looks at that flag. Both use sequentially consistent order, so
//! one of the two always sees the other. A flag that lies costs at most one needless or one late
//! wake-up: every sleep is bounded. Everything else on the page is whole numbers for reports; no
//! decision rests on them.

use crate::LinkError;
use crate::account::{Account, WORDS};
use crate::hello::Role;
use rustix::fs::{
    MemfdFlags, SealFlags, fcntl_add_seals, fcntl_get_seals, ftruncate, memfd_create,
};
use rustix::mm::{MapFlags, ProtFlags, mmap, munmap};
use std::os::fd::OwnedFd;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering, fence};

const BYTES: usize = 4096;
/// The sides' flags lie in cache lines of their own.
const FLAG_BYTES: [usize; 2] = [0, 128];
/// When the plant sent its last frame, in a cache line of its own.
const SENT_BYTE: usize = 64;
/// In lockstep the plant notes that for one frame out of so many: it costs a tenth of an exchange.
pub(crate) const SENT_EVERY: u64 = 16;
/// The core on which each side was when it last rang, plus one; beside its flag.
const CORE_BYTES: [usize; 2] = [8, 136];
/// The controller's account.
const ACCOUNT_BYTE: usize = 256;

pub(crate) struct Page {
    page: *mut u8,
    own: usize,
    other: usize,
    /// Where the cores of this and of the other side stand.
    cores: [usize; 2],
}

impl Page {
    /// A new page, and the file to hand to the other side.
    pub(crate) fn create(role: Role) -> Result<(Self, OwnedFd), LinkError> {
        let file = memfd_create(
            "twinhub-page",
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
        let [plant, controller] = FLAG_BYTES;
        let [plant_core, controller_core] = CORE_BYTES;
        let (own, other, cores) = match role {
            Role::Plant => (plant, controller, [plant_core, controller_core]),
            Role::Controller => (controller, plant, [controller_core, plant_core]),
        };
        Ok(Self {
            page: page.cast(),
            own,
            other,
            cores,
        })
    }

    fn flag(&self, byte: usize) -> &AtomicU32 {
        // SAFETY: `byte` is one of FLAG_BYTES: aligned, inside the mapped page, which lives as
        // long as self; an atomic may be changed by others at any time.
        unsafe { &*self.page.add(byte).cast() }
    }

    fn number(&self, byte: usize) -> &AtomicU64 {
        assert!(byte.is_multiple_of(8) && byte + 8 <= BYTES);
        // SAFETY: aligned and inside the mapped page, as above.
        unsafe { &*self.page.add(byte).cast() }
    }

    /// Notes when the plant sends a frame, ns of the monotonic clock.
    #[inline]
    pub(crate) fn sent(&self, at_ns: u64) {
        self.number(SENT_BYTE).store(at_ns, Ordering::Relaxed);
    }

    /// When the plant sent its last frame, as it says.
    #[inline]
    pub(crate) fn sent_ns(&self) -> u64 {
        self.number(SENT_BYTE).load(Ordering::Relaxed)
    }

    /// Notes the core on which this side runs.
    pub(crate) fn put_core(&self, core: usize) {
        self.number(self.cores[0])
            .store(core as u64 + 1, Ordering::Relaxed);
    }

    /// The core on which the other side was when it last rang, as it says.
    pub(crate) fn other_core(&self) -> Option<usize> {
        let noted = self.number(self.cores[1]).load(Ordering::Relaxed);
        usize::try_from(noted.checked_sub(1)?).ok()
    }

    /// Puts down the controller's account of itself.
    pub(crate) fn put_account(&self, account: &Account) {
        for (i, word) in account.words().into_iter().enumerate() {
            self.number(ACCOUNT_BYTE + 8 * i)
                .store(word, Ordering::Relaxed);
        }
    }

    /// The controller's account of itself, as it says; its words may stem from two accounts.
    pub(crate) fn account(&self) -> Account {
        let mut words = [0; WORDS];
        for (i, word) in words.iter_mut().enumerate() {
            *word = self.number(ACCOUNT_BYTE + 8 * i).load(Ordering::Relaxed);
        }
        Account::from_words(words)
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

impl Drop for Page {
    fn drop(&mut self) {
        // SAFETY: mapped in `map`, unmapped only here.
        let _ = unsafe { munmap(self.page.cast(), BYTES) };
    }
}
