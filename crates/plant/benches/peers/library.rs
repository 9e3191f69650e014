//! A peer's shared library, loaded where it was built.

use std::ffi::{CStr, CString, c_char, c_int, c_long, c_void};
use std::path::Path;

/// A loaded library and the model that it built. Stays loaded until the process ends.
pub struct Library {
    handle: *mut c_void,
    prefix: &'static str,
    model: *mut c_void,
}

fn loader_error() -> String {
    // SAFETY: `dlerror` gives null or a string that lives until the next call of the loader.
    let text = unsafe { libc::dlerror() };
    if text.is_null() {
        return "unknown error of the loader".to_owned();
    }
    // SAFETY: not null, so a string.
    unsafe { CStr::from_ptr(text) }
        .to_string_lossy()
        .into_owned()
}

impl Library {
    /// Loads `libPREFIX_peer.so` from `folder`; says why where it cannot.
    pub fn open(folder: &Path, prefix: &'static str) -> Result<Self, String> {
        let path = folder.join(format!("lib{prefix}_peer.so"));
        let name = CString::new(path.to_string_lossy().as_bytes()).map_err(|e| e.to_string())?;
        // SAFETY: a path to one of our own peers, whose initialisers have no conditions.
        let handle = unsafe { libc::dlopen(name.as_ptr(), libc::RTLD_NOW | libc::RTLD_LOCAL) };
        if handle.is_null() {
            return Err(loader_error());
        }
        Ok(Self {
            handle,
            prefix,
            model: core::ptr::null_mut(),
        })
    }

    fn symbol(&self, name: &str) -> *mut c_void {
        let full = CString::new(format!("{}_{name}", self.prefix)).expect("a plain name");
        // SAFETY: the handle is open.
        let found = unsafe { libc::dlsym(self.handle, full.as_ptr()) };
        assert!(
            !found.is_null(),
            "{}_peer has no {}_{name}",
            self.prefix,
            self.prefix
        );
        found
    }

    /// Builds the model from text; `more` is what the peer wants besides (null for none).
    pub fn build(&mut self, text: &str, more: Option<&[f64]>) -> Result<(), String> {
        let text = CString::new(text).map_err(|e| e.to_string())?;
        let mut error = [0 as c_char; 1000];
        let symbol = self.symbol("build");
        // SAFETY: the signatures are those of the peers' sources; buffers outlive the calls.
        self.model = unsafe {
            match more {
                None => {
                    type Build = extern "C" fn(*const c_char, *mut c_char, c_int) -> *mut c_void;
                    core::mem::transmute::<*mut c_void, Build>(symbol)(
                        text.as_ptr(),
                        error.as_mut_ptr(),
                        1000,
                    )
                }
                Some(numbers) => {
                    type Build =
                        extern "C" fn(*const c_char, *const f64, *mut c_char, c_int) -> *mut c_void;
                    core::mem::transmute::<*mut c_void, Build>(symbol)(
                        text.as_ptr(),
                        numbers.as_ptr(),
                        error.as_mut_ptr(),
                        1000,
                    )
                }
            }
        };
        if self.model.is_null() {
            // SAFETY: the peer ended its message within the buffer, which began as zeros.
            return Err(unsafe { CStr::from_ptr(error.as_ptr()) }
                .to_string_lossy()
                .into_owned());
        }
        Ok(())
    }

    /// Version of the peer.
    pub fn version(&self) -> String {
        type Version = extern "C" fn() -> *const c_char;
        // SAFETY: signature as in the peers' sources; a string that never ends its life.
        unsafe {
            let version = core::mem::transmute::<*mut c_void, Version>(self.symbol("version"));
            CStr::from_ptr(version()).to_string_lossy().into_owned()
        }
    }

    fn size(&self, name: &str) -> usize {
        type Size = extern "C" fn(*const c_void) -> c_int;
        // SAFETY: signature as in the peers' sources; the model is built.
        let size =
            unsafe { core::mem::transmute::<*mut c_void, Size>(self.symbol(name))(self.model) };
        size as usize
    }

    /// Sets positions, velocities and generalized forces.
    pub fn set(&self, q: &[f64], v: &[f64], force: &[f64]) {
        type Set = extern "C" fn(*mut c_void, *const f64, *const f64, *const f64);
        assert_eq!(
            (q.len(), v.len(), force.len()),
            (
                self.size("positions"),
                self.size("velocities"),
                self.size("velocities")
            )
        );
        // SAFETY: signature as in the peers' sources, lengths checked above.
        unsafe {
            core::mem::transmute::<*mut c_void, Set>(self.symbol("state"))(
                self.model,
                q.as_ptr(),
                v.as_ptr(),
                force.as_ptr(),
            );
        }
    }

    /// A function that repeats a piece of work.
    pub fn repeated(&self, name: &str) -> impl Fn(usize) + use<> {
        type Work = extern "C" fn(*mut c_void, c_long);
        // SAFETY: signature as in the peers' sources.
        let work = unsafe { core::mem::transmute::<*mut c_void, Work>(self.symbol(name)) };
        let model = self.model;
        move |count| work(model, count as c_long)
    }

    /// Pinocchio: the accelerations of the last `aba`.
    pub fn accelerations(&self) -> Vec<f64> {
        type Read = extern "C" fn(*const c_void, *mut f64);
        let mut out = vec![0.0; self.size("velocities")];
        // SAFETY: signature as in the peer's source; room for every velocity.
        unsafe {
            core::mem::transmute::<*mut c_void, Read>(self.symbol("accelerations"))(
                self.model,
                out.as_mut_ptr(),
            );
        }
        out
    }

    /// MuJoCo: positions, velocities and accelerations.
    pub fn read(&self) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
        type Read = extern "C" fn(*const c_void, *mut f64, *mut f64, *mut f64);
        let mut q = vec![0.0; self.size("positions")];
        let mut v = vec![0.0; self.size("velocities")];
        let mut a = v.clone();
        // SAFETY: signature as in the peer's source; room for everything it writes.
        unsafe {
            core::mem::transmute::<*mut c_void, Read>(self.symbol("read"))(
                self.model,
                q.as_mut_ptr(),
                v.as_mut_ptr(),
                a.as_mut_ptr(),
            );
        }
        (q, v, a)
    }
}
