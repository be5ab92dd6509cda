//! What stands beside axes and bars: the font, and numbers as text.

/// Name of the font of all pictures.
pub(crate) const FONT: &str = "sans-serif";

/// 10 with an exponent in raised digits.
pub(crate) fn power_of_ten(exponent: i32) -> String {
    let raised = |digit: char| match digit {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        digit => char::from_u32('⁰' as u32 + digit.to_digit(10).unwrap_or(0)).unwrap_or(digit),
    };
    format!("10{}", exponent.to_string().chars().map(raised).collect::<String>())
}

/// A tick of an axis: rounded so that 0.30000000000000004 is 0.3, with an exponent where it would be long.
pub(crate) fn short(v: f64, ends: (f64, f64)) -> String {
    let span = (ends.1 - ends.0).abs();
    let large = ends.0.abs().max(ends.1.abs());
    if v.abs() < 1e-9 * span {
        return "0".into();
    }
    if !(1e-3..1e5).contains(&large) {
        return format!("{:e}", format!("{v:.3e}").parse::<f64>().unwrap_or(v));
    }
    let digits = (3.0 - span.log10().floor()).clamp(0.0, 12.0) as usize;
    let text = format!("{v:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_are_raised() {
        assert_eq!(power_of_ten(-4), "10⁻⁴");
        assert_eq!(power_of_ten(13), "10¹³");
        assert_eq!(power_of_ten(0), "10⁰");
    }

    #[test]
    fn ticks_are_short() {
        assert_eq!(short(0.1 + 0.2, (0.0, 1.0)), "0.3");
        assert_eq!(short(-1e-17, (0.0, 1.0)), "0");
        assert_eq!(short(1_200_000.0, (0.0, 2e6)), "1.2e6");
        assert_eq!(short(2.5e-8, (0.0, 1e-7)), "2.5e-8");
        assert_eq!(short(1200.0, (0.0, 2000.0)), "1200");
    }
}
