//! Why a figure cannot be computed.

use twinhub_ident::FourPoleError;
use twinhub_linear::BicycleError;
use twinhub_plant::multibody::MultibodyError;

/// Why a figure cannot be computed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReproduceError {
    /// The benchmark's parameters are refused.
    #[error(transparent)]
    Bicycle(#[from] BicycleError),
    /// The model refuses.
    #[error(transparent)]
    Model(#[from] MultibodyError),
    /// The fit refuses.
    #[error(transparent)]
    Fit(#[from] FourPoleError),
}
