//! Matrices of a few rows in flat arrays, for loops that run a million times.

/// `out = a b`, all n by n.
pub fn mul(out: &mut [f64], a: &[f64], b: &[f64], n: usize) {
    // Lengths that the compiler knows: the loops unroll.
    match n {
        4 => mul_of::<4>(out, a, b),
        5 => mul_of::<5>(out, a, b),
        6 => mul_of::<6>(out, a, b),
        _ => {
            for (row, a) in out.chunks_exact_mut(n).zip(a.chunks_exact(n)) {
                row.fill(0.0);
                for (factor, b) in a.iter().zip(b.chunks_exact(n)) {
                    for (o, x) in row.iter_mut().zip(b) {
                        *o += factor * x;
                    }
                }
            }
        }
    }
}

fn mul_of<const N: usize>(out: &mut [f64], a: &[f64], b: &[f64]) {
    for (row, a) in out
        .as_chunks_mut::<N>()
        .0
        .iter_mut()
        .zip(a.as_chunks::<N>().0)
    {
        let mut sum = [0.0; N];
        for (factor, b) in a.iter().zip(b.as_chunks::<N>().0) {
            for k in 0..N {
                sum[k] += factor * b[k];
            }
        }
        *row = sum;
    }
}

/// `out = x' a`, n columns; entries of x that are zero cost nothing.
pub fn sparse_mul(out: &mut [f64], x: &[f64], a: &[f64], n: usize) {
    out[..n].fill(0.0);
    for (factor, row) in x.iter().zip(a.chunks_exact(n)) {
        if *factor != 0.0 {
            for (o, y) in out.iter_mut().zip(row) {
                *o += factor * y;
            }
        }
    }
}

/// `out = a x`, n rows.
pub fn mul_vec(out: &mut [f64], a: &[f64], x: &[f64], n: usize) {
    for (o, row) in out[..n].iter_mut().zip(a.chunks_exact(n)) {
        *o = row.iter().zip(x).map(|(p, q)| p * q).sum();
    }
}

/// Scalar product; four sums side by side, so that none waits for the one before.
#[inline]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let (p, q) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest: f64 = p
        .remainder()
        .iter()
        .zip(q.remainder())
        .map(|(x, y)| x * y)
        .sum();
    for (x, y) in p.zip(q) {
        for k in 0..4 {
            sums[k] += x[k] * y[k];
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}

/// Solves a symmetric positive definite system, n rows, for several right-hand sides, or none.
pub fn solve(a: &[f64], b: &[Vec<f64>]) -> Option<Vec<Vec<f64>>> {
    let n = b.first()?.len();
    let cholesky = nalgebra::DMatrix::from_row_slice(n, n, a).cholesky()?;
    Some(
        b.iter()
            .map(|column| {
                cholesky
                    .solve(&nalgebra::DVector::from_column_slice(column))
                    .as_slice()
                    .to_vec()
            })
            .collect(),
    )
}
