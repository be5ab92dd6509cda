//! Pictures of few colours.

use std::collections::BTreeMap;

/// Steps to which colours are rounded, one after the other, until no more than 256 are left; the last
/// leaves 6³ at most.
const STEPS: [u32; 6] = [8, 16, 24, 32, 40, 51];

/// The colours, three numbers each, and for each pixel the number of its colour.
pub(crate) fn reduced(pixels: &[u8]) -> (Vec<u8>, Vec<u8>) {
    let colours = |step: u32| {
        let round = move |x: u8| ((u32::from(x) + step / 2) / step * step).min(255) as u8;
        pixels.chunks_exact(3).map(move |pixel| [round(pixel[0]), round(pixel[1]), round(pixel[2])])
    };
    let numbered = |step: u32| {
        let mut numbers: BTreeMap<[u8; 3], usize> = colours(step).map(|colour| (colour, 0)).collect();
        numbers.values_mut().enumerate().for_each(|(k, number)| *number = k);
        numbers
    };
    let mut step = STEPS[0];
    let mut numbers = numbered(step);
    for &coarser in &STEPS[1..] {
        if numbers.len() > 256 {
            step = coarser;
            numbers = numbered(step);
        }
    }
    let indices = colours(step).map(|colour| numbers[&colour] as u8).collect();
    (numbers.into_keys().flatten().collect(), indices)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_colours_are_kept_and_many_are_rounded() {
        let (palette, indices) = reduced(&[0, 0, 0, 255, 255, 255, 0, 0, 0]);
        assert_eq!((palette, indices), (vec![0, 0, 0, 255, 255, 255], vec![0, 1, 0]));

        let many: Vec<u8> = (0..30_000_u32).flat_map(|k| [k as u8, (k >> 4) as u8, (k >> 8) as u8]).collect();
        let (palette, indices) = reduced(&many);
        assert!(palette.len() <= 3 * 256);
        for (pixel, &index) in many.chunks_exact(3).zip(&indices) {
            let colour = &palette[3 * usize::from(index)..][..3];
            assert!(pixel.iter().zip(colour).all(|(a, b)| a.abs_diff(*b) <= 26), "{pixel:?} became {colour:?}");
        }
    }
}
