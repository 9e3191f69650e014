//! Responses of two second-order systems to the input of a record.

use super::Response;
use nalgebra::{DVector, Matrix3, SVector, Vector2};

/// Both states of both systems, sampled as the record, each of unit length.
pub(super) struct Basis {
    pub columns: Vec<DVector<f64>>,
}

impl Basis {
    /// Coefficients (a1, a0, b1, b0); `None` if a response leaves the range of numbers or is zero.
    pub(super) fn new(record: &Response<'_>, theta: &SVector<f64, 4>) -> Option<Self> {
        let mut columns = Vec::with_capacity(4);
        for k in [0, 2] {
            let [position, rate] = response(record, theta[k], theta[k + 1]);
            for column in [position, rate] {
                let length = column.norm();
                if !(length.is_finite() && length > 0.0) {
                    return None;
                }
                columns.push(column / length);
            }
        }
        Some(Self { columns })
    }
}

/// x and x' of x'' + a1 x' + a0 x = u, exact for an input held from sample to sample.
fn response(record: &Response<'_>, a1: f64, a0: f64) -> [DVector<f64>; 2] {
    // exp of the system with its input as a third, constant state.
    #[rustfmt::skip]
    let generator = Matrix3::new(
        0.0, 1.0, 0.0,
        -a0, -a1, 1.0,
        0.0, 0.0, 0.0,
    ) * record.step_s;
    let step = generator.exp();
    let transition = step.fixed_view::<2, 2>(0, 0).into_owned();
    let drive = step.fixed_view::<2, 1>(0, 2).into_owned();
    let n = record.input.len();
    let mut out = [DVector::zeros(n), DVector::zeros(n)];
    let mut x = Vector2::zeros();
    for k in 0..n {
        out[0][k] = x[0];
        out[1][k] = x[1];
        x = transition * x + drive * record.input[k];
    }
    out
}
