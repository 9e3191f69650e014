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

/// `out = a x`, n rows.
pub fn mul_vec(out: &mut [f64], a: &[f64], x: &[f64], n: usize) {
    for (o, row) in out[..n].iter_mut().zip(a.chunks_exact(n)) {
        *o = row.iter().zip(x).map(|(p, q)| p * q).sum();
    }
}

/// Scalar product; four sums side by side, so that none waits for the one before.
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

/// Terms of the series, at most. In states that are scaled by their own time constants the norm of
/// a h is a quarter of the plain one and less, so that the rest stays below 1e-8.
const TERMS: usize = 9;
/// Terms end before one whose bound is smaller than this.
const SMALLEST_TERM: f64 = 1e-11;
/// Largest norm of a h for one part.
const LARGEST_NORM: f64 = 1.0;

/// exp(a h), and for a column b the responses to an input of one, held, and to one that rises from
/// 0 to 1 over h: columns of `held` and `ramp`, n values each.
#[derive(Clone)]
pub struct Flow {
    pub n: usize,
    pub phi: Vec<f64>,
    pub held: [Vec<f64>; 2],
    pub ramp: [Vec<f64>; 2],
    /// exp(a h/2) b.
    pub half: [Vec<f64>; 2],
    term: Vec<f64>,
    next: Vec<f64>,
}

impl Flow {
    pub fn new(n: usize) -> Self {
        let pair = || [vec![0.0; n], vec![0.0; n]];
        Self {
            n,
            phi: vec![0.0; n * n],
            held: pair(),
            ramp: pair(),
            half: pair(),
            term: vec![0.0; n * n],
            next: vec![0.0; n * n],
        }
    }

    /// For two input columns.
    pub fn compute(&mut self, a: &[f64], columns: &[Vec<f64>; 2], h: f64) {
        let n = self.n;
        let norm = a
            .chunks_exact(n)
            .map(|row| row.iter().map(|x| x.abs()).sum::<f64>())
            .fold(0.0, f64::max);
        let parts = libm::ceil(norm * h / LARGEST_NORM).clamp(1.0, 64.0);
        let part = h / parts;
        let mut terms = 1;
        let mut bound = norm * part;
        while terms < TERMS && bound > SMALLEST_TERM {
            terms += 1;
            bound *= norm * part / terms as f64;
        }
        // exp over one part by Horner's scheme.
        self.phi.fill(0.0);
        for i in 0..n {
            self.phi[i * n + i] = 1.0;
        }
        for k in (1..=terms).rev() {
            mul(&mut self.next, a, &self.phi, n);
            let factor = part / k as f64;
            for (x, y) in self.phi.iter_mut().zip(&self.next) {
                *x = y * factor;
            }
            for i in 0..n {
                self.phi[i * n + i] += 1.0;
            }
        }
        for (c, column) in columns.iter().enumerate() {
            // held = sum a^k b h^(k+1)/(k+1)!, ramp = sum a^k b h^(k+1)/(k+2)!,
            // half = sum a^k b (h/2)^k/k!.
            let (mut held_f, mut ramp_f, mut half_f) = (part, 0.5 * part, 1.0);
            self.term[..n].copy_from_slice(column);
            for i in 0..n {
                self.held[c][i] = held_f * column[i];
                self.ramp[c][i] = ramp_f * column[i];
                self.half[c][i] = half_f * column[i];
            }
            for k in 1..=terms {
                let (term, next) = (&self.term, &mut self.next);
                mul_vec(next, a, term, n);
                held_f *= part / (k + 1) as f64;
                ramp_f *= part / (k + 2) as f64;
                half_f *= 0.5 * part / k as f64;
                for i in 0..n {
                    self.held[c][i] += held_f * self.next[i];
                    self.ramp[c][i] += ramp_f * self.next[i];
                    self.half[c][i] += half_f * self.next[i];
                }
                self.term[..n].copy_from_slice(&self.next[..n]);
            }
        }
        if parts > 1.0 {
            self.repeat(parts as usize, columns);
        }
    }

    /// From one part to the whole step.
    fn repeat(&mut self, parts: usize, columns: &[Vec<f64>; 2]) {
        let n = self.n;
        let one = self.phi.clone();
        let (held, ramp) = (self.held.clone(), self.ramp.clone());
        // exp over half of the parts: from b itself, or from b after half a part.
        let mut half = if parts % 2 == 0 {
            columns.clone()
        } else {
            self.half.clone()
        };
        for done in 1..parts {
            let share = done as f64;
            for c in 0..2 {
                // x after the next part: one x + held u0 + ramp du.
                let mut next = vec![0.0; n];
                mul_vec(&mut next, &one, &self.ramp[c], n);
                for i in 0..n {
                    // The ramp's value at the start of this part is `done` of `parts`.
                    next[i] += held[c][i] * share + ramp[c][i];
                }
                self.ramp[c].copy_from_slice(&next);
                mul_vec(&mut next, &one, &self.held[c], n);
                for i in 0..n {
                    next[i] += held[c][i];
                }
                self.held[c].copy_from_slice(&next);
                if 2 * done <= parts {
                    mul_vec(&mut next, &one, &half[c], n);
                    half[c].copy_from_slice(&next);
                }
            }
            mul(&mut self.next, &one, &self.phi, n);
            std::mem::swap(&mut self.phi, &mut self.next);
        }
        for c in 0..2 {
            for x in &mut self.ramp[c] {
                *x /= parts as f64;
            }
        }
        self.half = half;
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A first-order lag and a double integrator have closed forms, also over several parts.
    #[test]
    fn closed_forms() {
        for (rate, h) in [(1.0, 0.01), (80.0, 0.05)] {
            let a = [-rate, 0.0, 0.0, 0.0];
            let mut flow = Flow::new(2);
            flow.compute(&a, &[vec![rate, 0.0], vec![0.0, 1.0]], h);
            let decay = libm::exp(-rate * h);
            assert!((flow.phi[0] - decay).abs() < 1e-6);
            assert!((flow.held[0][0] - (1.0 - decay)).abs() < 1e-6);
            let ramp = 1.0 - (1.0 - decay) / (rate * h);
            assert!(
                (flow.ramp[0][0] - ramp).abs() < 1e-6,
                "{} {ramp}",
                flow.ramp[0][0]
            );
            assert!((flow.ramp[1][1] - 0.5 * h).abs() < 1e-15);
        }
        let a = [0.0, 1.0, 0.0, 0.0];
        let mut flow = Flow::new(2);
        flow.compute(&a, &[vec![0.0, 1.0], vec![0.0, 0.0]], 0.1);
        assert!((flow.held[0][0] - 0.005).abs() < 1e-15);
        assert!((flow.ramp[0][0] - 0.001 / 6.0 / 0.1 * 1.0).abs() < 1e-12);
        assert!((flow.half[0][0] - 0.05).abs() < 1e-15);
    }
}
