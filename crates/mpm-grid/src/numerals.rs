//! Numbers in messages.

/// A number with at most six digits, written shortest.
pub fn six_digits(x: f64) -> String {
    let rounded: f64 = format!("{x:.5e}").parse().unwrap_or(x);
    let plain = rounded == 0.0 || (1e-3..1e6).contains(&rounded.abs()) || !rounded.is_finite();
    if plain { rounded.to_string() } else { format!("{rounded:e}") }
}

#[cfg(test)]
mod tests {
    use super::six_digits;

    #[test]
    fn six_digits_are_enough() {
        for (x, expected) in [
            (0.0, "0"),
            (1.5, "1.5"),
            (2_234.654_119_55, "2234.65"),
            (-0.1, "-0.1"),
            (1e6, "1e6"),
            (-1.234_567_89e-7, "-1.23457e-7"),
            (f64::NAN, "NaN"),
        ] {
            assert_eq!(six_digits(x), expected);
        }
    }
}
