//! Transition of the states over a step, and what inputs add to it.

use super::small::{mul, mul_vec};

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
        if n == 4 && is_second_order(a, columns) {
            self.series_of_two(a, columns, part, terms);
        } else {
            self.series(a, columns, part, terms);
        }
        if parts > 1.0 {
            self.repeat(parts as usize, columns);
        }
    }

    /// One part, any states.
    fn series(&mut self, a: &[f64], columns: &[Vec<f64>; 2], part: f64, terms: usize) {
        let n = self.n;
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
    }

    /// One part of two second-order equations, q'' = L q + R q' + columns: a^k [0; I] is
    /// [Y_k; Y_k+1] with Y_k+1 = L Y_k-1 + R Y_k, and a [I; 0] is [0; L], so that two by two
    /// matrices are enough.
    fn series_of_two(&mut self, a: &[f64], columns: &[Vec<f64>; 2], part: f64, terms: usize) {
        let left = [a[8], a[9], a[12], a[13]];
        let right = [a[10], a[11], a[14], a[15]];
        let (mut y, mut next) = ([0.0; 4], [1.0, 0.0, 0.0, 1.0]);
        // Sums of both halves of a^k [0; I], with the factors of exp, held, ramp and half.
        let mut sums = [[[0.0; 4]; 2]; 4];
        let mut factors = [1.0, part, 0.5 * part, 1.0];
        for k in 0..=terms {
            for (sum, factor) in sums.iter_mut().zip(factors) {
                for i in 0..4 {
                    sum[0][i] += factor * y[i];
                    sum[1][i] += factor * next[i];
                }
            }
            let (p, q) = (product(&left, &y), product(&right, &next));
            y = next;
            next = [p[0] + q[0], p[1] + q[1], p[2] + q[2], p[3] + q[3]];
            let step = (k + 1) as f64;
            factors[0] *= part / step;
            factors[1] *= part / (step + 1.0);
            factors[2] *= part / (step + 2.0);
            factors[3] *= 0.5 * part / step;
        }
        let input = [columns[0][2], columns[1][2], columns[0][3], columns[1][3]];
        for half in 0..2 {
            let angles = product(&sums[1][half], &left);
            let [held, ramp, middle] = [1, 2, 3].map(|s| product(&sums[s][half], &input));
            for i in 0..2 {
                let row = 2 * half + i;
                for j in 0..2 {
                    let own = if half == 0 && i == j { 1.0 } else { 0.0 };
                    self.phi[row * 4 + j] = own + angles[2 * i + j];
                    self.phi[row * 4 + 2 + j] = sums[0][half][2 * i + j];
                    self.held[j][row] = held[2 * i + j];
                    self.ramp[j][row] = ramp[2 * i + j];
                    self.half[j][row] = middle[2 * i + j];
                }
            }
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

/// Whether the states are two angles and their rates, and inputs are torques.
fn is_second_order(a: &[f64], columns: &[Vec<f64>; 2]) -> bool {
    a[..8] == [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]
        && columns.iter().all(|c| c[..2] == [0.0, 0.0])
}

/// Two by two, by rows.
fn product(a: &[f64; 4], b: &[f64; 4]) -> [f64; 4] {
    [
        a[0] * b[0] + a[1] * b[2],
        a[0] * b[1] + a[1] * b[3],
        a[2] * b[0] + a[3] * b[2],
        a[2] * b[1] + a[3] * b[3],
    ]
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

    /// Two by two matrices say the same as four by four ones.
    #[test]
    fn two_equations_as_any_states() {
        let a = [
            [0.0, 0.0, 1.0, 0.0],
            [0.0, 0.0, 0.0, 1.0],
            [9.5, -14.0, -0.1, -1.7],
            [12.0, -32.0, 18.0, -16.0],
        ]
        .concat();
        let columns = [vec![0.0, 0.0, 0.02, -0.1], vec![0.0, 0.0, -0.1, 4.0]];
        for h in [0.002, 0.01, 0.08] {
            let (mut two, mut any) = (Flow::new(4), Flow::new(4));
            two.compute(&a, &columns, h);
            any.series(&a, &columns, h / 64.0, TERMS);
            any.repeat(64, &columns);
            let both =
                |f: &Flow| [&[f.phi.clone()], &f.held[..], &f.ramp[..], &f.half[..]].concat();
            for (p, q) in both(&two).concat().iter().zip(both(&any).concat()) {
                assert!((p - q).abs() < 1e-7, "{h}: {p} {q}");
            }
        }
    }
}
