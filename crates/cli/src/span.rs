//! Evenly spaced numbers on the command line: `A:B:STEP`.

use anyhow::anyhow;

/// Most numbers in one request.
const MOST: f64 = 100_000.0;

/// The numbers of `text` as `A:B:STEP`, both ends included where the step meets them, none below
/// `least`; `flag` and `unit` are for the message.
pub fn numbers(flag: &str, text: &str, unit: &str, least: f64) -> anyhow::Result<Vec<f64>> {
    let wrong = |why: &str| {
        anyhow!(
            "{flag} `{text}`: {why}; accepted: A:B:STEP with {least} <= A <= B and STEP > 0 in {unit}, for instance {least}:10:0.5"
        )
    };
    let numbers: Vec<f64> = text
        .split(':')
        .map(|s| s.trim().parse())
        .collect::<Result<_, _>>()
        .map_err(|_| wrong("not three numbers"))?;
    let [from, to, step] = numbers[..] else {
        return Err(wrong("not three numbers"));
    };
    if !numbers.iter().all(|v| v.is_finite()) {
        return Err(wrong("a number is not finite"));
    }
    if from < least || to < from || step <= 0.0 {
        return Err(wrong("out of range"));
    }
    let count = (to - from) / step + 1e-9;
    if count > MOST {
        return Err(wrong("more than 100000 of them"));
    }
    Ok((0..=count as usize)
        .map(|i| (from + i as f64 * step).min(to))
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn speeds(text: &str) -> anyhow::Result<Vec<f64>> {
        numbers("--speeds-m-s", text, "m/s", 0.0)
    }

    #[test]
    fn both_ends_are_included() {
        assert_eq!(speeds("0:1:0.25").unwrap(), [0.0, 0.25, 0.5, 0.75, 1.0]);
        assert_eq!(speeds("0:0.3:0.1").unwrap().len(), 4);
        assert_eq!(speeds("5:5:1").unwrap(), [5.0]);
    }

    #[test]
    fn a_bad_span_is_quoted_with_what_would_be_accepted() {
        for bad in [
            "",
            "1:2",
            "a:b:c",
            "0:10:0",
            "3:1:0.1",
            "-1:2:1",
            "0:nan:1",
            "0:1e9:1e-3",
            "0:1:1:1",
        ] {
            let message = speeds(bad).unwrap_err().to_string();
            assert!(
                message.contains("A:B:STEP") && message.contains(bad),
                "{message}"
            );
        }
    }
}
