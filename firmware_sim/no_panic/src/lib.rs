#![no_std]
//! The controller behind two C functions. The panic handler calls a function that exists nowhere:
//! a panic path anywhere in the controller fails the link. `.ci/check_no_panic` links it.

use twinhub_control::{Config, Controller};
use twinhub_types::{Instant, Measurement, Output, RiderIntent};

unsafe extern "C" {
    safe fn the_controller_can_panic() -> !;
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    the_controller_can_panic()
}

/// Bytes of a controller's memory.
#[unsafe(no_mangle)]
pub static TWINHUB_CONTROLLER_BYTES: usize = size_of::<Controller>();

/// [`Controller::new`].
#[unsafe(no_mangle)]
pub extern "C" fn twinhub_new(config: &Config, controller: &mut Controller) {
    *controller = Controller::new(config);
}

/// [`Controller::step`].
#[unsafe(no_mangle)]
pub extern "C" fn twinhub_step(
    controller: &mut Controller,
    now_ns: u64,
    measurement: &Measurement,
    rider: &RiderIntent,
    output: &mut Output,
) {
    *output = controller.step(Instant::from_nanos(now_ns), measurement, rider);
}
