//! Small dense matrices in row-major slices. The predictor multiplies matrices of four to sixteen
//! rows some hundred thousand times, with sizes known only at run time: slices without allocation.

/// `out = a (rows x inner) * b (inner x cols)`.
pub fn mul(out: &mut [f64], a: &[f64], b: &[f64], rows: usize, inner: usize, cols: usize) {
    for i in 0..rows {
        let row = &mut out[i * cols..(i + 1) * cols];
        row.fill(0.0);
        for k in 0..inner {
            let factor = a[i * inner + k];
            if factor != 0.0 {
                for (o, x) in row.iter_mut().zip(&b[k * cols..(k + 1) * cols]) {
                    *o += factor * x;
                }
            }
        }
    }
}

/// `out = a (rows x cols) * x`.
pub fn mul_vec(out: &mut [f64], a: &[f64], x: &[f64]) {
    for (o, row) in out.iter_mut().zip(a.chunks_exact(x.len())) {
        *o = dot(row, x);
    }
}

/// Scalar product.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// Solves `a x = b` for a symmetric positive definite `a` by Cholesky decomposition, or `None`.
pub fn solve_spd(a: &[f64], b: &[f64]) -> Option<Vec<f64>> {
    let n = b.len();
    let matrix = nalgebra::DMatrix::from_row_slice(n, n, a);
    let solution = matrix
        .cholesky()?
        .solve(&nalgebra::DVector::from_column_slice(b));
    Some(solution.as_slice().to_vec())
}
