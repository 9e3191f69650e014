//! Symmetric matrices as their upper triangle by rows: files and programs hold no entry twice.

use nalgebra::DMatrix;

/// Places of the upper triangle of an n by n matrix, by rows.
pub fn places(n: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..n).flat_map(move |i| (i..n).map(move |j| (i, j)))
}

/// The upper triangle of `p`.
pub fn upper(p: &DMatrix<f64>) -> Vec<f64> {
    places(p.nrows()).map(|ij| p[ij]).collect()
}

/// The n by n matrix of an upper triangle of n (n + 1) / 2 entries or more.
pub fn full(n: usize, upper: &[f64]) -> DMatrix<f64> {
    let mut p = DMatrix::zeros(n, n);
    for ((i, j), value) in places(n).zip(upper) {
        p[(i, j)] = *value;
        p[(j, i)] = *value;
    }
    p
}
