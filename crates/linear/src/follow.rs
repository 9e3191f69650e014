//! Which eigenvalue of the next speed continues which of this one.
//!
//! Neighbouring sets are matched as a whole, with least total cost: distance of the eigenvalues and
//! unlikeness of the shapes (one less the modal assurance criterion, Allemang 1982). Steps must be
//! small against the change of the modes.

use crate::eigen::Eigenpair;

/// Weight of a wholly unlike shape against a relative distance of eigenvalues.
const SHAPE_WEIGHT: f64 = 0.3;

/// Cost of taking `b` as the continuation of `a`.
fn cost(a: &Eigenpair, b: &Eigenpair) -> f64 {
    let d = a.value - b.value;
    let distance = libm::hypot(d.re, d.im) / (1.0 + libm::hypot(a.value.re, a.value.im));
    let inner: nalgebra::Complex<f64> = a
        .shape
        .iter()
        .zip(&b.shape)
        .map(|(x, y)| x.conj() * y)
        .sum();
    distance + SHAPE_WEIGHT * (1.0 - inner.norm_sqr().min(1.0))
}

/// For each of `from`, the index of its continuation in `to` (both of the same length).
pub fn continuation(from: &[Eigenpair], to: &[Eigenpair]) -> Vec<usize> {
    let n = from.len().min(to.len());
    let table: Vec<Vec<f64>> = from[..n]
        .iter()
        .map(|a| to[..n].iter().map(|b| cost(a, b).min(1e300)).collect())
        .collect();
    assignment(&table)
}

/// Follows every branch through a family: `result[k][b]` is the index in `family[k]` of the branch
/// that has index `b` in `family[start]`.
pub fn follow(family: &[Vec<Eigenpair>], start: usize) -> Vec<Vec<usize>> {
    let mut branches = vec![Vec::new(); family.len()];
    let Some(first) = family.get(start) else {
        return branches;
    };
    branches[start] = (0..first.len()).collect();
    let mut walk = |from: usize, to: usize| {
        let next = continuation(&family[from], &family[to]);
        branches[to] = branches[from]
            .iter()
            .map(|i| next.get(*i).copied().unwrap_or(*i))
            .collect();
    };
    for k in start + 1..family.len() {
        walk(k - 1, k);
    }
    for k in (0..start).rev() {
        walk(k + 1, k);
    }
    branches
}

/// Assignment of least total cost (shortest augmenting paths, Jonker and Volgenant 1987).
fn assignment(cost: &[Vec<f64>]) -> Vec<usize> {
    let n = cost.len();
    const FREE: usize = usize::MAX;
    let (mut row_price, mut column_price) = (vec![0.0; n], vec![0.0; n + 1]);
    // Row that holds each column; the last, virtual column holds the row to be placed.
    let mut holder = vec![FREE; n + 1];
    for row in 0..n {
        holder[n] = row;
        let mut column = n;
        let mut least = vec![f64::INFINITY; n];
        let mut via = vec![n; n];
        let mut used = vec![false; n + 1];
        while holder[column] != FREE {
            used[column] = true;
            let i = holder[column];
            let (mut delta, mut next) = (f64::INFINITY, n);
            for j in (0..n).filter(|j| !used[*j]) {
                let reduced = cost[i][j] - row_price[i] - column_price[j];
                if reduced < least[j] {
                    least[j] = reduced;
                    via[j] = column;
                }
                if least[j] < delta {
                    delta = least[j];
                    next = j;
                }
            }
            for j in 0..=n {
                if used[j] {
                    row_price[holder[j]] += delta;
                    column_price[j] -= delta;
                } else if j < n {
                    least[j] -= delta;
                }
            }
            column = next;
        }
        while column != n {
            holder[column] = holder[via[column]];
            column = via[column];
        }
    }
    let mut result = vec![0; n];
    for (column, row) in holder[..n].iter().enumerate() {
        result[*row] = column;
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn best_by_trying(cost: &[Vec<f64>], row: usize, used: &mut Vec<bool>) -> f64 {
        if row == cost.len() {
            return 0.0;
        }
        let mut best = f64::INFINITY;
        for j in 0..cost.len() {
            if !used[j] {
                used[j] = true;
                best = best.min(cost[row][j] + best_by_trying(cost, row + 1, used));
                used[j] = false;
            }
        }
        best
    }

    proptest! {
        #[test]
        fn no_assignment_is_cheaper(cost in (1usize..6).prop_flat_map(|n| {
            proptest::collection::vec(proptest::collection::vec(0.0..10.0_f64, n), n)
        })) {
            let a = assignment(&cost);
            let mut sorted = a.clone();
            sorted.sort_unstable();
            prop_assert!(sorted.iter().enumerate().all(|(i, j)| i == *j));
            let total: f64 = a.iter().enumerate().map(|(i, j)| cost[i][*j]).sum();
            let best = best_by_trying(&cost, 0, &mut vec![false; cost.len()]);
            prop_assert!((total - best).abs() < 1e-9, "{total} {best}");
        }
    }
}
