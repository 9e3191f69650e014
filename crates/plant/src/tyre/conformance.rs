//! What every tyre must do, run over the whole registry.
