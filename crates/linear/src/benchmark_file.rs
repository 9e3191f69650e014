//! `*Benchmark.txt` files of the BicycleParameters project (J. K. Moore): lines `symbol = value` or
//! `symbol = value+/-standard deviation`, in the symbols and axes of Meijaard et al. (2007).

use crate::error::BicycleError;
use crate::parameters::SYMBOLS;
use std::collections::BTreeMap;
use std::path::Path;

/// Keys that these files may carry beyond the benchmark's: wheel inertias about the third axis,
/// lateral offsets (bicycles are symmetric here), and handlebar (G) and fork (S) that H contains.
const BESIDE: &[&str] = &[
    "IRzz", "IFzz", "yB", "yH", "mG", "xG", "yG", "zG", "IGxx", "IGyy", "IGzz", "IGxz", "mS", "xS",
    "yS", "zS", "ISxx", "ISyy", "ISzz", "ISxz",
];

/// A value with its standard deviation, if given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Entry {
    pub value: f64,
    pub sd: Option<f64>,
}

/// What a file says about the benchmark's symbols.
pub(crate) type Entries = BTreeMap<&'static str, Entry>;

/// Reads the text of a file.
pub(crate) fn parse(text: &str, path: &Path) -> Result<Entries, BicycleError> {
    let mut entries = Entries::new();
    let mut seen = BTreeMap::new();
    for (index, raw) in text.lines().enumerate() {
        let line = raw
            .split('#')
            .next()
            .unwrap_or("")
            .trim()
            .trim_start_matches('\u{feff}');
        if line.is_empty() {
            continue;
        }
        let fail = |key: &str, found: &str, accepted: String| BicycleError::Line {
            path: path.to_owned(),
            line: index + 1,
            key: key.to_owned(),
            found: found.to_owned(),
            accepted,
        };
        let Some((key, text)) = line.split_once('=').map(|(k, v)| (k.trim(), v.trim())) else {
            return Err(fail(
                "",
                line,
                "`symbol = value` or `symbol = value +/- standard deviation`".to_owned(),
            ));
        };
        if let Some(first) = seen.insert(key.to_owned(), index + 1) {
            return Err(fail(
                key,
                line,
                format!("each key once (first on line {first})"),
            ));
        }
        let (value, sd) = match text.split_once("+/-") {
            Some((value, sd)) => (value.trim(), Some(sd.trim())),
            None => (text, None),
        };
        let number = |text: &str| text.parse::<f64>().ok().filter(|v| v.is_finite());
        let value = number(value).ok_or_else(|| fail(key, value, "a finite number".to_owned()))?;
        let sd = match sd {
            None => None,
            Some(text) => Some(number(text).filter(|sd| *sd >= 0.0).ok_or_else(|| {
                fail(
                    key,
                    text,
                    "a standard deviation of at least 0 after `+/-`".to_owned(),
                )
            })?),
        };
        if let Some(symbol) = SYMBOLS.iter().find(|s| **s == key) {
            crate::validate::single(symbol, value).map_err(|e| match e {
                BicycleError::Value { accepted, .. } => {
                    fail(key, &value.to_string(), accepted.to_owned())
                }
                other => other,
            })?;
            entries.insert(symbol, Entry { value, sd });
        } else if !BESIDE.contains(&key) {
            return Err(fail(
                key,
                key,
                format!(
                    "the keys {}; beside them, unused: {}",
                    SYMBOLS.join(", "),
                    BESIDE.join(", ")
                ),
            ));
        }
    }
    Ok(entries)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(text: &str) -> String {
        parse(text, Path::new("X.txt")).unwrap_err().to_string()
    }

    #[test]
    fn values_and_deviations() {
        let e = parse(
            "w = 1.02+/-0.002\r\n\n# remark\nmB=85 +/- 1 \nxB = 3e-1\nyB = 0.1\n",
            Path::new("X.txt"),
        )
        .unwrap();
        assert_eq!(e.len(), 3);
        assert_eq!(
            e["w"],
            Entry {
                value: 1.02,
                sd: Some(0.002)
            }
        );
        assert_eq!(
            e["mB"],
            Entry {
                value: 85.0,
                sd: Some(1.0)
            }
        );
        assert_eq!(
            e["xB"],
            Entry {
                value: 0.3,
                sd: None
            }
        );
    }

    #[test]
    fn a_bad_line_is_named_with_its_place() {
        for (text, parts) in [
            (
                "w = 1\nc = abc",
                vec!["X.txt, line 2", "`c`", "`abc`", "finite number"],
            ),
            (
                "w = 1\n\nnonsense",
                vec!["line 3", "nonsense", "symbol = value"],
            ),
            ("w = NaN", vec!["line 1", "`w`", "NaN", "finite"]),
            ("w = 1+/--2", vec!["line 1", "-2", "standard deviation"]),
            ("w = 1\nw = 2", vec!["line 2", "first on line 1"]),
            ("wheelbase = 1", vec!["`wheelbase`", "IBxx"]),
            ("mB = -3", vec!["line 1", "`mB`", "-3", "at least 0 kg"]),
            ("w = 0", vec!["`w`", "above 0 m"]),
        ] {
            let m = message(text);
            for part in parts {
                assert!(m.contains(part), "{m} lacks {part}");
            }
        }
    }
}
