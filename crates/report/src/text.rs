//! Text and numbers as a page shows them.

/// Plain text made safe for HTML and SVG, between tags and in attributes. Control characters
/// that XML forbids are dropped.
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            '\n' | '\t' => out.push(c),
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => {}
            c => out.push(c),
        }
    }
    out
}

/// `value` with `digits` significant digits and a true minus sign; `not a number` in words.
pub fn number(value: f64, digits: usize) -> String {
    if value.is_nan() {
        return "n/a".into();
    }
    if value.is_infinite() {
        return if value > 0.0 { "∞" } else { "−∞" }.into();
    }
    let digits = digits.clamp(1, 17);
    if value == 0.0 {
        return "0".into();
    }
    // Round first: 9.99 with two digits is 10, which has one place less after the point.
    let scientific = format!("{:.*e}", digits - 1, value);
    let exponent: i32 = scientific
        .split_once('e')
        .and_then(|(_, e)| e.parse().ok())
        .unwrap_or(0);
    let text = if (-5..=digits.max(6) as i32).contains(&exponent) {
        let places = (digits as i32 - 1 - exponent).max(0) as usize;
        format!("{value:.places$}")
    } else {
        scientific.replace('e', "·10^")
    };
    text.replace('-', "−")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_in_a_text_can_become_markup() {
        assert_eq!(
            escape("<a href='x'>\"&\u{0}\u{b}</a>"),
            "&lt;a href=&#39;x&#39;&gt;&quot;&amp;&lt;/a&gt;"
        );
        assert_eq!(escape("Wöhler, 3 µs\n"), "Wöhler, 3 µs\n");
    }

    #[test]
    fn numbers_have_the_digits_that_were_asked_for() {
        for (value, digits, text) in [
            (0.0, 3, "0"),
            (1234.567, 3, "1235"),
            (0.012345, 3, "0.0123"),
            (-2.5, 2, "−2.5"),
            (9.99, 2, "10"),
            (0.0996, 2, "0.10"),
            (1e-9, 2, "1.0·10^−9"),
            (f64::NAN, 3, "n/a"),
            (f64::NEG_INFINITY, 3, "−∞"),
        ] {
            assert_eq!(number(value, digits), text);
        }
    }
}
