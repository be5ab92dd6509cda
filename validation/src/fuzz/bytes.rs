//! Damage to bytes.

use super::random::Random;

/// Changes bytes here and there; they may become fewer or more.
pub(super) fn change(bytes: &mut Vec<u8>, random: &mut Random) {
    for _ in 0..1 + random.below(4) {
        if bytes.is_empty() {
            return;
        }
        let at = random.below(bytes.len());
        match random.below(12) {
            0..=3 => bytes[at] ^= 1 << random.below(8),
            4 => bytes[at] = random.next() as u8,
            5..=8 => {
                let number = match random.below(6) {
                    0 => 0,
                    1 => u64::MAX,
                    2 => 1 << random.below(64),
                    3 => (1 << 63) - random.below(3) as u64,
                    4 => random.below(1000) as u64,
                    _ => random.next(),
                };
                let width = 1 << random.below(4);
                bytes.iter_mut().skip(at).zip(&number.to_le_bytes()[..width]).for_each(|(it, by)| *it = *by);
            }
            9 => {
                let (from, length) = (random.below(bytes.len()), random.below(64));
                let copy = bytes[from..bytes.len().min(from + length)].to_vec();
                bytes.iter_mut().skip(at).zip(copy).for_each(|(it, by)| *it = by);
            }
            10 => bytes.truncate(at),
            _ => {
                let more: Vec<u8> = (0..1 + random.below(40)).map(|_| random.next() as u8).collect();
                bytes.splice(at..at, more);
            }
        }
    }
}
