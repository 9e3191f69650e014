//! What: how a mode depends on every parameter.
//!
//! Equation: dλ/dp = wᴴ (dA/dp) v / (wᴴ v), with v and w the right and left eigenvector; dA/dp is
//! the central difference of exact state matrices, each about its own steady state. The weave
//! speed moves by -Re(dλ/dp) / Re(dλ/dv).
//!
//! Source: Lancaster (1964), Numerische Mathematik 6 (eigenvalue derivatives).
//!
//! Assumes and ignores: a simple eigenvalue.
//!
//! Valid for: any parameter that is a number; flags are not differentiated.
//!
//! Checked by: `sensitivities_agree_with_differences_of_the_mode` in `multibody/tests`.

use super::error::MultibodyError;
use super::model::Multibody;
use super::parameters::Parameters;
use super::steady::{Course, Steady};
use nalgebra::{Complex, DMatrix, DVector};
use twinhub_linear::ModeName;

/// Dependence of one eigenvalue on one parameter.
#[derive(Clone, Debug)]
pub struct Sensitivity {
    /// Dotted path of the parameter.
    pub path: String,
    /// Its value.
    pub value: f64,
    /// Derivative of the eigenvalue, 1/s per unit of the parameter.
    pub per_unit: Complex<f64>,
}

impl Sensitivity {
    /// Change of the eigenvalue per relative change of the parameter, 1/s.
    pub fn relative(&self) -> Complex<f64> {
        self.per_unit * self.value
    }
}

/// How a critical speed depends on every parameter.
#[derive(Clone, Debug)]
pub struct SpeedSensitivity {
    /// The eigenvalue that crosses, 1/s.
    pub eigenvalue: Complex<f64>,
    /// Its derivative with respect to speed, 1/m.
    pub per_speed: Complex<f64>,
    /// Its derivatives with respect to the parameters.
    pub parameters: Vec<Sensitivity>,
}

impl SpeedSensitivity {
    /// Change of the critical speed per unit of a parameter, m/s.
    pub fn speed_per_unit(&self, parameter: &Sensitivity) -> f64 {
        -parameter.per_unit.re / self.per_speed.re
    }
}

impl Multibody {
    /// Sensitivities of the critical speed of `mode`, where `course` runs at that speed.
    ///
    /// # Errors
    /// If there is no steady state there, or no such mode.
    pub fn speed_sensitivities(
        &self,
        course: &Course,
        mode: ModeName,
    ) -> Result<SpeedSensitivity, MultibodyError> {
        let here = self.named_modes(course, &[course.speed_m_s])?;
        let named = here.modes.points.iter().flat_map(|p| &p.modes);
        // At its critical speed the mode of that name that is nearest the axis.
        let eigenvalue = named
            .filter(|m| m.name == mode)
            .map(|m| m.pair.value)
            .min_by(|a, b| a.re.abs().total_cmp(&b.re.abs()))
            .ok_or_else(|| MultibodyError::Eigenvalues {
                message: format!("no {mode} mode at {} m/s", course.speed_m_s),
            })?;
        Ok(SpeedSensitivity {
            eigenvalue,
            per_speed: self.eigenvalue_per_speed(course, eigenvalue)?,
            parameters: self.sensitivities(course, eigenvalue)?,
        })
    }

    /// Sensitivity of the eigenvalue nearest `eigenvalue` to every number in the parameters.
    /// Parameters without effect, or that cannot move (a tyre without that term), are left out.
    pub fn sensitivities(
        &self,
        course: &Course,
        eigenvalue: Complex<f64>,
    ) -> Result<Vec<Sensitivity>, MultibodyError> {
        let steady = self.steady(course, None)?;
        let (left, right) = vectors(&self.lateral_if_straight(&steady).a, eigenvalue);
        let scale = left.dotc(&right);
        let mut found = Vec::new();
        for path in self.parameters.paths() {
            let value = self.parameters.get(&path)?;
            let step = 1.0e-5 * value.abs().max(1.0e-3);
            let (Some(up), Some(down)) = (
                self.moved(&path, value + step, course, &steady),
                self.moved(&path, value - step, course, &steady),
            ) else {
                continue;
            };
            let change: DMatrix<f64> = (up - down) / (2.0 * step);
            if change.amax() == 0.0 {
                continue;
            }
            let moved = change.map(|v| Complex::new(v, 0.0)) * &right;
            found.push(Sensitivity {
                path,
                value,
                per_unit: left.dotc(&moved) / scale,
            });
        }
        Ok(found)
    }

    /// Derivative of the eigenvalue nearest `eigenvalue` with respect to speed, 1/m.
    ///
    /// # Errors
    /// If there is no steady state at this speed or beside it.
    pub fn eigenvalue_per_speed(
        &self,
        course: &Course,
        eigenvalue: Complex<f64>,
    ) -> Result<Complex<f64>, MultibodyError> {
        let steady = self.steady(course, None)?;
        let (left, right) = vectors(&self.lateral_if_straight(&steady).a, eigenvalue);
        let step = 1.0e-5 * course.speed_m_s;
        let at = |speed_m_s: f64| -> Result<DMatrix<f64>, MultibodyError> {
            let near = Course {
                speed_m_s,
                ..*course
            };
            let steady = self.steady(&near, Some(&steady))?;
            Ok(self.lateral_if_straight(&steady).a)
        };
        let change = (at(course.speed_m_s + step)? - at(course.speed_m_s - step)?) / (2.0 * step);
        let moved = change.map(|v| Complex::new(v, 0.0)) * &right;
        Ok(left.dotc(&moved) / left.dotc(&right))
    }

    /// State matrix with one parameter changed; `None` if the value is not admitted.
    fn moved(
        &self,
        path: &str,
        value: f64,
        course: &Course,
        near: &Steady,
    ) -> Option<DMatrix<f64>> {
        let mut parameters: Parameters = self.parameters.clone();
        parameters.set(path, value).ok()?;
        let model = Multibody::new(&parameters).ok()?;
        let steady = model.steady(course, Some(near)).ok()?;
        let a = model.lateral_if_straight(&steady).a;
        a.iter().all(|v| v.is_finite()).then_some(a)
    }
}

/// Left and right eigenvector of the eigenvalue nearest `at`, by inverse iteration.
fn vectors(a: &DMatrix<f64>, at: Complex<f64>) -> (DVector<Complex<f64>>, DVector<Complex<f64>>) {
    let n = a.nrows();
    let whole = a.map(|v| Complex::new(v, 0.0));
    // A hair beside the eigenvalue, so that the matrix can be inverted.
    let shift = at + Complex::new(1.0e-9, 1.0e-9) * (1.0 + at.norm_sqr().sqrt());
    let solve = |m: DMatrix<Complex<f64>>, shift: Complex<f64>| {
        let lu = (m - DMatrix::identity(n, n) * shift).lu();
        let mut v = DVector::from_element(n, Complex::new(1.0, 0.3));
        for _ in 0..6 {
            if let Some(next) = lu.solve(&v) {
                let size = next.norm();
                v = next / Complex::new(size, 0.0);
            }
        }
        v
    };
    let right = solve(whole.clone(), shift);
    let left = solve(whole.adjoint(), shift.conj());
    (left, right)
}
