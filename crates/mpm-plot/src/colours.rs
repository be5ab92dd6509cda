//! Colours of curves and of values.

use plotters::style::RGBColor;

/// Colours of curves, by number (Okabe & Ito, distinct for all kinds of eyes).
pub(crate) const CURVES: [RGBColor; 10] = [
    RGBColor(0, 0, 0),
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(150, 150, 0),
    RGBColor(86, 180, 233),
    RGBColor(130, 130, 130),
    RGBColor(230, 159, 0),
    RGBColor(110, 60, 20),
];

/// From pale blue over yellow to red: for shapes that matter more than their values.
pub(crate) fn pale(value: f64) -> RGBColor {
    mixed(&[[200.0, 220.0, 240.0], [250.0, 225.0, 120.0], [205.0, 70.0, 40.0]], value)
}

/// Viridis (Smith & van der Walt 2015): equal differences of value look equal.
pub(crate) fn even(value: f64) -> RGBColor {
    const STOPS: [[f64; 3]; 9] = [
        [68.0, 1.0, 84.0],
        [71.0, 44.0, 122.0],
        [59.0, 81.0, 139.0],
        [44.0, 113.0, 142.0],
        [33.0, 144.0, 141.0],
        [39.0, 173.0, 129.0],
        [92.0, 200.0, 99.0],
        [170.0, 220.0, 50.0],
        [253.0, 231.0, 37.0],
    ];
    mixed(&STOPS, value)
}

/// Between equally spaced stops; grey for what is no number.
fn mixed(stops: &[[f64; 3]], value: f64) -> RGBColor {
    if value.is_nan() {
        return RGBColor(170, 170, 170);
    }
    let last = stops.len() - 1;
    let at = last as f64 * value.clamp(0.0, 1.0);
    let low = (at.floor() as usize).min(last - 1);
    let mix =
        |c: usize| (stops[low][c] + (stops[low + 1][c] - stops[low][c]) * (at - low as f64)).round() as u8;
    RGBColor(mix(0), mix(1), mix(2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_reach_from_end_to_end() {
        assert_eq!(even(0.0), RGBColor(68, 1, 84));
        assert_eq!([even(1.0), even(7.0)], [RGBColor(253, 231, 37); 2]);
        assert_eq!(even(0.5), RGBColor(33, 144, 141));
        assert_eq!(pale(0.25), RGBColor(225, 223, 180));
        assert_eq!(even(f64::NAN), RGBColor(170, 170, 170));
    }
}
