//! Parameters of the bicycle that rides, and how far they lie from the declared ones.
//!
//! Source: symbols and values of Meijaard, Papadopoulos, Ruina and Schwab (2007), Proc. R. Soc. A
//! 463, table 1 (benchmark bicycle with rider), typed in from there.

use crate::random::Stream;

macro_rules! parameters {
    ($($symbol:ident = $value:expr),* $(,)?) => {
        /// The symbols of Meijaard et al. (2007), SI units.
        #[allow(non_snake_case)]
        #[derive(Clone, Debug, PartialEq)]
        pub struct Bicycle { $(pub $symbol: f64),* }

        impl Bicycle {
            /// The benchmark bicycle.
            pub fn benchmark() -> Self {
                Self { $($symbol: $value),* }
            }

            fn each(&mut self, mut change: impl FnMut(&str, &mut f64)) {
                $(change(stringify!($symbol), &mut self.$symbol);)*
            }
        }
    };
}

parameters! {
    w = 1.02, c = 0.08, lam = core::f64::consts::PI / 10.0, g = 9.81,
    rR = 0.3, mR = 2.0, IRxx = 0.0603, IRyy = 0.12,
    xB = 0.3, zB = -0.9, mB = 85.0, IBxx = 9.2, IByy = 11.0, IBzz = 2.8, IBxz = 2.4,
    xH = 0.9, zH = -0.7, mH = 4.0, IHxx = 0.05892, IHyy = 0.06, IHzz = 0.00708, IHxz = -0.00756,
    rF = 0.35, mF = 3.0, IFxx = 0.1405, IFyy = 0.28,
}

/// Farthest that a parameter is drawn from its declared value, in standard deviations.
const FARTHEST_SD: f64 = 2.5;

impl Bicycle {
    /// A bicycle whose parameters are spread about these with the standard deviation `ratio` of
    /// each value; gravity is known.
    pub fn spread(&self, ratio: f64, stream: &mut Stream) -> Self {
        let mut found = self.clone();
        found.each(|symbol, value| {
            let drawn = stream.normal_within(FARTHEST_SD);
            if symbol != "g" {
                *value *= 1.0 + ratio * drawn;
            }
        });
        found
    }

    /// Another bicycle, far beyond any tolerance: loaded, steeper, with less trail.
    pub fn another(&self) -> Self {
        Self {
            mB: self.mB + 18.0,
            IBxx: self.IBxx + 1.6,
            zB: self.zB * 0.9,
            c: self.c * 0.6,
            IHzz: self.IHzz + 0.12,
            ..self.clone()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spread_is_as_declared_and_leaves_gravity() {
        let nominal = Bicycle::benchmark();
        let mut stream = Stream::new(1, "spread");
        let drawn: Vec<Bicycle> = (0..4000)
            .map(|_| nominal.spread(0.02, &mut stream))
            .collect();
        assert!(drawn.iter().all(|b| b.g == 9.81));
        let ratio = |b: &Bicycle| (b.mB / nominal.mB - 1.0).powi(2);
        let sd = (drawn.iter().map(ratio).sum::<f64>() / 4000.0).sqrt();
        // Cut at 2.5 sd, a normal has 0.956 of its spread left.
        assert!((sd / (0.02 * 0.956) - 1.0).abs() < 0.05, "{sd}");
    }
}
