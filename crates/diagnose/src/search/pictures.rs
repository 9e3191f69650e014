//! Series for the report.

/// Everything that the page draws.
#[derive(Clone, Debug, Default)]
pub struct Pictures {
    pub spectra: Vec<Spectrum>,
    pub traces: Vec<Trace>,
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
