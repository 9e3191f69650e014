//! tyre
