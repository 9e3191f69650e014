//! Series for the report.

/// Everything that the page draws.
#[derive(Clone, Debug, Default)]
pub struct Pictures {
    pub spectra: Vec<Spectrum>,
    pub traces: Vec<Trace>,
    pub latent: Option<LatentPicture>,
}

/// Power of the latent torque of one equation, relative to what noise would give.
#[derive(Clone, Debug)]
pub struct Spectrum {
    pub equation: String,
    pub frequency_hz: Vec<f64>,
    pub before: Vec<f64>,
    pub after: Vec<f64>,
    /// 99 % of noise lies below.
    pub limit: Vec<f64>,
}

/// One channel over the worst stretch: measured, and predicted half a second ahead.
#[derive(Clone, Debug)]
pub struct Trace {
    pub ride: String,
    pub quantity: String,
    pub t_s: Vec<f64>,
    pub measured: Vec<f64>,
    pub calibrated: Vec<f64>,
    pub extended: Vec<f64>,
}

/// The torque that has no name.
#[derive(Clone, Debug)]
pub struct LatentPicture {
    pub equation: String,
    pub trace: ForceTrace,
    /// Over the quantity with which it goes, if it goes with any.
    pub curve: Option<Curve>,
}

/// Its course over the stretch where it is largest.
#[derive(Clone, Debug, Default)]
pub struct ForceTrace {
    pub ride: String,
    pub t_s: Vec<f64>,
    pub torque_nm: Vec<f64>,
}

/// Mean torque over a quantity, with 95 % interval.
#[derive(Clone, Debug, Default)]
pub struct Curve {
    pub over: String,
    pub unit: String,
    pub x: Vec<f64>,
    pub torque_nm: Vec<f64>,
    pub low_nm: Vec<f64>,
    pub high_nm: Vec<f64>,
}
