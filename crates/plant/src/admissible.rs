//! Parameters that a model refuses, with the range that it would accept.

/// A parameter outside its range.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{field} is {found}; accepted is {low} to {high}")]
pub struct OutOfRange {
    /// Name of the parameter as in TOML, unit at its end.
    pub field: &'static str,
    /// What was found.
    pub found: f64,
    /// The smallest accepted value.
    pub low: f64,
    /// The largest accepted value.
    pub high: f64,
}

/// `Ok` if `found` lies in `[low, high]`; NaN never does.
pub fn within(field: &'static str, found: f64, low: f64, high: f64) -> Result<(), OutOfRange> {
    if found >= low && found <= high {
        Ok(())
    } else {
        Err(OutOfRange {
            field,
            found,
            low,
            high,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_names_field_value_and_range_and_nan_is_refused() {
        assert!(within("lag_s", 0.1, 0.0, 1.0).is_ok());
        let error = within("lag_s", -0.1, 0.0, 1.0).unwrap_err();
        assert_eq!(error.to_string(), "lag_s is -0.1; accepted is 0 to 1");
        assert!(within("lag_s", f64::NAN, 0.0, 1.0).is_err());
    }
}
