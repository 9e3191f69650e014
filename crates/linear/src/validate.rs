//! Which parameter values can be.
//!
//! Errors are for what cannot be meant: NaN, negative mass, a mass centre below the ground (z
//! points down), a moment of inertia that exceeds the sum of the two others by half. Measured sets
//! break the triangle inequality by some per cent, because frames are nearly flat and pendulum
//! tests have errors; such cases are reported as remarks.

use crate::error::BicycleError;
use crate::parameters::{Parameters, SYMBOLS};

/// Largest moment of inertia over the sum of the two others: above it is an error.
const TRIANGLE_LIMIT: f64 = 1.5;

/// Checks one value by itself.
pub(crate) fn single(symbol: &str, value: f64) -> Result<(), BicycleError> {
    let fail = |accepted| {
        Err(BicycleError::Value {
            symbol: symbol.to_owned(),
            value,
            accepted,
        })
    };
    if !value.is_finite() {
        return fail("a finite number");
    }
    match symbol {
        "w" if value <= 0.0 => fail("a wheelbase above 0 m"),
        "lam" if value.abs() >= 1.5 => {
            fail("a steer axis tilt between -1.5 and 1.5 rad (not degrees)")
        }
        "g" if value < 0.0 => fail("gravity of at least 0 m/s^2"),
        "rR" | "rF" if value < 0.0 => fail("a radius of at least 0 m (0 is a skate)"),
        "mR" | "mB" | "mH" | "mF" if value < 0.0 => fail("a mass of at least 0 kg"),
        "zB" | "zH" if value > 0.0 => {
            fail("at most 0 m: z points down, a mass centre above the ground is negative")
        }
        "IRxx" | "IRyy" | "IBxx" | "IByy" | "IBzz" | "IHxx" | "IHyy" | "IHzz" | "IFxx" | "IFyy"
            if value < 0.0 =>
        {
            fail("a moment of inertia of at least 0 kg m^2")
        }
        _ => Ok(()),
    }
}

/// Principal moments in the plane of symmetry, and the one across it.
fn principal(ixx: f64, iyy: f64, izz: f64, ixz: f64) -> [f64; 3] {
    let mean = 0.5 * (ixx + izz);
    let radius = libm::hypot(0.5 * (ixx - izz), ixz);
    [mean + radius, mean - radius, iyy]
}

fn body(
    name: &'static str,
    ixx: f64,
    iyy: f64,
    izz: f64,
    ixz: f64,
    remarks: &mut Vec<String>,
) -> Result<(), BicycleError> {
    let [high, low, across] = principal(ixx, iyy, izz, ixz);
    if low < -1e-9 * high {
        return Err(BicycleError::Inertia {
            body: name,
            what: format!(
                "Ixx = {ixx}, Izz = {izz}, Ixz = {ixz} give a negative principal moment {low:.4e} kg m^2"
            ),
            accepted: "Ixz^2 at most Ixx Izz",
        });
    }
    let largest = high.max(across);
    let others = high + low + across - largest;
    let ratio = if largest > 0.0 { largest / others } else { 0.0 };
    if ratio > TRIANGLE_LIMIT {
        return Err(BicycleError::Inertia {
            body: name,
            what: format!(
                "the largest principal moment is {ratio:.2} times the sum of the two others (principal moments {high:.4}, {low:.4}, across {across:.4} kg m^2)"
            ),
            accepted: "at most 1; up to 1.5 is taken as measurement error",
        });
    }
    if ratio > 1.0 + 1e-9 {
        remarks.push(format!(
            "inertia of {name}: largest principal moment {ratio:.3} times the sum of the others; no rigid body exceeds 1"
        ));
    }
    Ok(())
}

impl Parameters {
    /// Checks every value and every body; gives remarks on what is doubtful.
    pub fn validate(&self) -> Result<Vec<String>, BicycleError> {
        for symbol in SYMBOLS {
            single(symbol, self.get(symbol).unwrap_or(f64::NAN))?;
        }
        let p = self;
        let value = |symbol: &str, value, accepted| BicycleError::Value {
            symbol: symbol.to_owned(),
            value,
            accepted,
        };
        if p.mR + p.mB + p.mH + p.mF <= 0.0 {
            return Err(value("mB", p.mB, "a bicycle with some mass"));
        }
        for (radius, inertia, symbol) in [(p.rR, p.IRyy, "IRyy"), (p.rF, p.IFyy, "IFyy")] {
            if radius == 0.0 && inertia != 0.0 {
                return Err(value(
                    symbol,
                    inertia,
                    "0 for a skate (radius 0 does not spin), or a radius above 0 m",
                ));
            }
        }
        let mut remarks = Vec::new();
        body(
            "the rear wheel (R)",
            p.IRxx,
            p.IRyy,
            p.IRxx,
            0.0,
            &mut remarks,
        )?;
        body(
            "the rear body (B)",
            p.IBxx,
            p.IByy,
            p.IBzz,
            p.IBxz,
            &mut remarks,
        )?;
        body(
            "the front assembly (H)",
            p.IHxx,
            p.IHyy,
            p.IHzz,
            p.IHxz,
            &mut remarks,
        )?;
        body(
            "the front wheel (F)",
            p.IFxx,
            p.IFyy,
            p.IFxx,
            0.0,
            &mut remarks,
        )?;
        for (name, inertia, mass, radius) in
            [("rear", p.IRyy, p.mR, p.rR), ("front", p.IFyy, p.mF, p.rF)]
        {
            if inertia > mass * radius * radius {
                remarks.push(format!(
                    "{name} wheel: spin inertia {inertia} kg m^2 exceeds all its mass at its radius"
                ));
            }
        }
        Ok(remarks)
    }
}
