//! disturbance
