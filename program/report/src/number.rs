//! Numbers as text.

/// 10 to a whole power, as "10⁻¹²".
pub(super) fn power_of_ten(exponent: i32) -> String {
    let digits = exponent.to_string();
    let raised = digits.chars().map(|digit| match digit {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '0' => '⁰',
        '4' => '⁴',
        '5' => '⁵',
        '6' => '⁶',
        '7' => '⁷',
        '8' => '⁸',
        _ => '⁹',
    });
    std::iter::once('1').chain(['0']).chain(raised).collect()
}

/// A number with the given count of significant digits, as "0.25", "1000" or "3.1×10⁻¹³".
pub(super) fn number(value: f64, digits: usize) -> String {
    if value.is_nan() {
        return "NaN".to_owned();
    }
    if value.is_infinite() {
        return if value > 0.0 { "∞" } else { "−∞" }.to_owned();
    }
    if value == 0.0 {
        return "0".to_owned();
    }
    let scientific = format!("{value:.*e}", digits.saturating_sub(1));
    let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let trimmed = |text: &str| match text.contains('.') {
        true => text
            .trim_end_matches('0')
            .trim_end_matches('.')
            .replace('-', "−"),
        false => text.replace('-', "−"),
    };
    if (-4..6).contains(&exponent) {
        let decimals = (digits as i32 - 1 - exponent).max(0) as usize;
        return trimmed(&format!("{value:.decimals$}"));
    }
    format!("{}×{}", trimmed(mantissa), power_of_ten(exponent))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_as_physicists_write_them() {
        assert_eq!(number(0.25, 3), "0.25");
        assert_eq!(number(-3.14159e-13, 3), "−3.14×10⁻¹³");
        assert_eq!(number(1000.0, 3), "1000");
        assert_eq!(number(f64::NAN, 3), "NaN");
        assert_eq!(number(0.0, 3), "0");
        assert_eq!(number(1e300, 2), "1×10³⁰⁰");
    }
}
