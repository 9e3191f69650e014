//! The parameters of the benchmark bicycle, by the symbols of the paper.
//!
//! Source: Meijaard, Papadopoulos, Ruina and Schwab (2007), Proc. R. Soc. A 463, 1955-1982,
//! table 1. SI units; x forward, y right, z down, origin in the rear contact point. The paper's
//! forward speed `v` is not a parameter here. `IByy` and `IHyy` stand in the table but have no
//! influence on the lateral motion.

use crate::error::BicycleError;

macro_rules! parameters {
    ($($(#[$doc:meta])* $symbol:ident [$unit:literal],)*) => {
        /// Parameters of the Whipple-Carvallo bicycle (Meijaard et al. 2007, table 1), SI.
        ///
        /// The fields carry the symbols of the paper, which study and bicycle files use too.
        #[allow(non_snake_case)]
        #[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(deny_unknown_fields)]
        pub struct Parameters { $($(#[$doc])* pub $symbol: f64,)* }

        /// All symbols, in the order of the paper.
        pub const SYMBOLS: &[&str] = &[$(stringify!($symbol)),*];
        const UNITS: &[&str] = &[$($unit),*];

        impl Parameters {
            /// All zero: to be filled by `set`.
            pub(crate) const ZERO: Self = Self { $($symbol: 0.0,)* };

            fn slot(&mut self, symbol: &str) -> Option<&mut f64> {
                match symbol { $(stringify!($symbol) => Some(&mut self.$symbol),)* _ => None }
            }

            /// The value of a symbol.
            pub fn get(&self, symbol: &str) -> Option<f64> {
                match symbol { $(stringify!($symbol) => Some(self.$symbol),)* _ => None }
            }
        }
    };
}

parameters! {
    /// Wheelbase, m.
    w["m"],
    /// Trail, m.
    c["m"],
    /// Steer axis tilt (90 degrees less the head angle), rad.
    lam["rad"],
    /// Gravity, m/s².
    g["m/s^2"],
    /// Rear wheel radius, m; zero is a skate.
    rR["m"],
    /// Rear wheel mass, kg.
    mR["kg"],
    /// Rear wheel moment of inertia about a diameter, kg m².
    IRxx["kg m^2"],
    /// Rear wheel moment of inertia about the axle, kg m².
    IRyy["kg m^2"],
    /// Rear body (with rider): position of the centre of mass, m.
    xB["m"],
    /// Rear body: height of the centre of mass, m, negative above the ground.
    zB["m"],
    /// Rear body: mass, kg.
    mB["kg"],
    /// Rear body: moment of inertia about x, kg m².
    IBxx["kg m^2"],
    /// Rear body: moment of inertia about y, kg m²; without influence here.
    IByy["kg m^2"],
    /// Rear body: moment of inertia about z, kg m².
    IBzz["kg m^2"],
    /// Rear body: product of inertia, -∫xz dm, kg m².
    IBxz["kg m^2"],
    /// Front assembly (fork and handlebar): position of the centre of mass, m.
    xH["m"],
    /// Front assembly: height of the centre of mass, m, negative above the ground.
    zH["m"],
    /// Front assembly: mass, kg.
    mH["kg"],
    /// Front assembly: moment of inertia about x, kg m².
    IHxx["kg m^2"],
    /// Front assembly: moment of inertia about y, kg m²; without influence here.
    IHyy["kg m^2"],
    /// Front assembly: moment of inertia about z, kg m².
    IHzz["kg m^2"],
    /// Front assembly: product of inertia, -∫xz dm, kg m².
    IHxz["kg m^2"],
    /// Front wheel radius, m; zero is a skate.
    rF["m"],
    /// Front wheel mass, kg.
    mF["kg"],
    /// Front wheel moment of inertia about a diameter, kg m².
    IFxx["kg m^2"],
    /// Front wheel moment of inertia about the axle, kg m².
    IFyy["kg m^2"],
}

/// The unit of a symbol.
pub fn unit(symbol: &str) -> Option<&'static str> {
    SYMBOLS.iter().position(|s| *s == symbol).map(|i| UNITS[i])
}

/// The symbol's own spelling, whatever the case it was typed in (symbols stay distinct).
fn suggestion(found: &str) -> Option<&'static str> {
    SYMBOLS
        .iter()
        .find(|s| s.eq_ignore_ascii_case(found))
        .copied()
}

impl Parameters {
    /// Sets one value, checked by itself. Bodies and wheels are checked as a whole by `validate`,
    /// so that several values can be set one after the other.
    pub fn set(&mut self, symbol: &str, value: f64) -> Result<(), BicycleError> {
        let slot = self
            .slot(symbol)
            .ok_or_else(|| BicycleError::UnknownSymbol {
                found: symbol.to_owned(),
                hint: suggestion(symbol)
                    .map(|s| format!(" (did you mean `{s}`?)"))
                    .unwrap_or_default(),
            })?;
        crate::validate::single(symbol, value)?;
        *slot = value;
        Ok(())
    }
}

impl Parameters {
    /// Sets one value without any check.
    pub(crate) fn nudge(&mut self, symbol: &str, value: f64) {
        if let Some(slot) = self.slot(symbol) {
            *slot = value;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_symbol_can_be_set_and_read() {
        let mut p = Parameters::ZERO;
        for (i, symbol) in SYMBOLS.iter().enumerate() {
            let value = if symbol.starts_with('z') { -0.1 } else { 0.01 } * (i + 1) as f64;
            p.set(symbol, value).unwrap();
            assert_eq!(p.get(symbol), Some(value));
            assert!(unit(symbol).is_some());
        }
        let set = SYMBOLS
            .iter()
            .map(|s| p.get(s).unwrap().to_bits())
            .collect::<std::collections::HashSet<_>>();
        assert_eq!(set.len(), SYMBOLS.len());
    }

    #[test]
    fn a_wrong_symbol_gets_the_right_one_suggested() {
        let error = { Parameters::ZERO }
            .set("ibxx", 1.0)
            .unwrap_err()
            .to_string();
        assert!(error.contains("IBxx") && error.contains("ibxx"), "{error}");
    }
}
