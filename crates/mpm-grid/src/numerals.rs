//! Numbers in messages.

/// A number with at most six digits, written shortest.
pub fn six_digits(x: f64) -> String {
    let rounded: f64 = format!("{x:.5e}").parse().unwrap_or(x);
    let plain = rounded == 0.0 || (1e-3..1e6).contains(&rounded.abs()) || !rounded.is_finite();
    if plain { rounded.to_string() } else { format!("{rounded:e}") }
}

/// A message in which numbers have at most six digits, but for what stands between backquotes, for parts of names, and
/// where two different numbers would then be told as one.
pub fn rounded(message: &str) -> String {
    let found = numbers(message);
    let texts: Vec<&str> = found.iter().map(|&(start, end)| &message[start..end]).collect();
    let short: Vec<String> = texts.iter().map(|text| shortened(text)).collect();
    let mut out = String::with_capacity(message.len());
    let mut at = 0;
    for (k, &(start, end)) in found.iter().enumerate() {
        let value = |text: &str| text.parse::<f64>().ok();
        let is_confused = (0..texts.len())
            .any(|other| value(&short[other]) == value(&short[k]) && value(texts[other]) != value(texts[k]));
        out.push_str(&message[at..start]);
        out.push_str(if is_confused { texts[k] } else { &short[k] });
        at = end;
    }
    out.push_str(&message[at..]);
    out
}

/// Where numbers stand in a text.
fn numbers(text: &str) -> Vec<(usize, usize)> {
    let bytes = text.as_bytes();
    let is_word = |byte: u8| {
        byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'.' | b'/' | b'\\' | b':') || byte >= 128
    };
    let (mut found, mut at, mut quoted) = (Vec::new(), 0, false);
    while at < bytes.len() {
        if bytes[at] == b'`' {
            quoted = !quoted;
        }
        if quoted || !bytes[at].is_ascii_digit() {
            at += 1;
            continue;
        }
        let start = at;
        let digits = |mut at: usize| {
            while at < bytes.len() && bytes[at].is_ascii_digit() {
                at += 1;
            }
            at
        };
        at = digits(at);
        if bytes.get(at) == Some(&b'.') && bytes.get(at + 1).is_some_and(u8::is_ascii_digit) {
            at = digits(at + 1);
        }
        if matches!(bytes.get(at), Some(b'e' | b'E')) {
            let sign = at + 1 + usize::from(matches!(bytes.get(at + 1), Some(b'-' | b'+')));
            if bytes.get(sign).is_some_and(u8::is_ascii_digit) {
                at = digits(sign);
            }
        }
        // Part of a name, a path, a version or a place in a file.
        let before = start.checked_sub(1).map(|before| bytes[before]);
        let ends_sentence = |at: usize| bytes.get(at + 1).is_none_or(|next| !is_word(*next));
        let behind = bytes.get(at).copied().filter(|&byte| !matches!(byte, b'.' | b':') || !ends_sentence(at));
        if !before.is_some_and(is_word) && !behind.is_some_and(is_word) {
            found.push((start, at));
        } else {
            while at < bytes.len() && is_word(bytes[at]) {
                at += 1;
            }
        }
    }
    found
}

/// A number as it is written, or with six digits if it has more; whole numbers stay, because they count something.
fn shortened(text: &str) -> String {
    let mantissa = text.split(['e', 'E']).next().unwrap_or_default();
    let digits = mantissa.chars().filter(char::is_ascii_digit).collect::<String>();
    let significant = digits.trim_start_matches('0').len();
    let is_whole = mantissa.len() == text.len() && !mantissa.contains('.');
    match text.parse::<f64>() {
        Ok(value) if significant > 6 && !is_whole => six_digits(value),
        _ => text.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::{rounded, six_digits};

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

    #[test]
    fn numbers_of_messages_have_six_digits() {
        for (message, expected) in [
            ("at (1.6666666666666667, -0.333333333333, 2)", "at (1.66667, -0.333333, 2)"),
            ("a volume of -1.3333333333333333e0: inwards", "a volume of -1.33333: inwards"),
            ("1e-300 and 1.23456789e-300 and 12345678.9", "1e-300 and 1.23457e-300 and 1.23457e7"),
            ("123456789 points", "123456789 points"),
            (
                "run_1.23456789.h5: `0.123456789` in mpm 1.23456789.0",
                "run_1.23456789.h5: `0.123456789` in mpm 1.23456789.0",
            ),
            ("expected at most 1, got 1.00000001", "expected at most 1, got 1.00000001"),
            ("ends at 0.12345678.", "ends at 0.123457."),
            ("from 0.12345678 to 0.12345679", "from 0.12345678 to 0.12345679"),
            ("scene.ron:12:123456789: 2.5", "scene.ron:12:123456789: 2.5"),
            ("x³ 0.1234567 ≤ 7.7654321 m", "x³ 0.123457 ≤ 7.76543 m"),
        ] {
            assert_eq!(rounded(message), expected);
        }
    }
}
