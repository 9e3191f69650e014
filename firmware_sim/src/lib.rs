//! firmware_sim
