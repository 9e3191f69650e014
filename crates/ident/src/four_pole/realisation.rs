//! Poles of the free response, by a realisation of order four: singular values of the Hankel
//! matrix of the outputs after the input has ended.

use super::{FourPoleError, Response};
use nalgebra::{Complex, DMatrix, DVector};

/// Samples after the input that are needed at least.
pub(super) const LEAST: usize = 40;
/// Samples that the Hankel matrix is made of, at most: it has half as many rows per output.
const MOST: usize = 160;
/// Singular values below this, relative to the largest, are rounding.
const ROUNDING: f64 = 1.0e-12;

/// Four poles that say most of the free response, 1/s.
pub(super) fn poles(
    record: &Response<'_>,
    outputs: &[DVector<f64>],
) -> Result<[Complex<f64>; 4], FourPoleError> {
    let n = record.input.len();
    let end = record
        .input
        .iter()
        .rposition(|u| *u != 0.0)
        .map_or(0, |k| k + 1);
    let free = n - end;
    if free < LEAST {
        return Err(FourPoleError::Samples {
            samples: free,
            shortest: free,
            least: LEAST,
        });
    }
    let stride = free.div_ceil(MOST);
    let count = free / stride;
    let rows = count / 2;
    let columns = count - rows;
    let m = outputs.len();
    let hankel = DMatrix::from_fn(m * rows, columns, |i, j| {
        outputs[i % m][end + (i / m + j) * stride]
    });
    let svd = hankel.svd(true, false);
    let Some(u) = svd.u.as_ref() else {
        return Err(FourPoleError::Order { found: 0 });
    };
    let mut order: Vec<usize> = (0..svd.singular_values.len()).collect();
    order.sort_by(|&a, &b| svd.singular_values[b].total_cmp(&svd.singular_values[a]));
    let largest = svd.singular_values[order[0]];
    let found = order
        .iter()
        .take_while(|&&k| svd.singular_values[k] > ROUNDING * largest)
        .count();
    if found < 4 {
        return Err(FourPoleError::Order { found });
    }
    // The observability matrix, one output row of blocks down, is itself times A: least squares.
    let observability = DMatrix::from_fn(m * rows, 4, |i, k| {
        u[(i, order[k])] * libm::sqrt(svd.singular_values[order[k]])
    });
    let shifted = m * (rows - 1);
    let upper = observability.rows(0, shifted).into_owned();
    let lower = observability.rows(m, shifted).into_owned();
    let a = upper
        .svd(true, true)
        .solve(&lower, 0.0)
        .map_err(|_| FourPoleError::Order { found: 0 })?;
    let interval = stride as f64 * record.step_s;
    let discrete = a.complex_eigenvalues();
    let mut poles: Vec<Complex<f64>> = discrete.iter().map(|z| continuous(*z, interval)).collect();
    // Conjugates stand side by side, equal to rounding: to the last bit from here on.
    for k in 0..3 {
        if poles[k].im * poles[k + 1].im < 0.0 {
            poles[k + 1] = poles[k].conj();
        }
    }
    Ok([poles[0], poles[1], poles[2], poles[3]])
}

/// ln z / T. A real negative or vanishing z is decay within the sampling interval.
fn continuous(z: Complex<f64>, interval_s: f64) -> Complex<f64> {
    let size = libm::hypot(z.re, z.im).max(1.0e-6);
    if z.im == 0.0 {
        let size = if z.re > 1.0e-6 {
            z.re
        } else {
            1.0e-6_f64.max(0.1 * size)
        };
        return Complex::new(libm::log(size) / interval_s, 0.0);
    }
    Complex::new(libm::log(size), libm::atan2(z.im, z.re)) / interval_s
}
