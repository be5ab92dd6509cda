//! Numbers and strains that are the same on every machine.

use nalgebra::Vector3;

/// A generator of numbers (Steele, Lea and Flood 2014, SplitMix64).
pub struct Numbers(pub u64);

impl Numbers {
    /// Between `low` and `high`.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        bits ^= bits >> 31;
        low + (high - low) * ((bits >> 11) as f64 / (1_u64 << 53) as f64)
    }

    /// Between `low` and `high`, both positive, with equal chances for every factor.
    pub fn of_any_size(&mut self, low: f64, high: f64) -> f64 {
        self.between(low.ln(), high.ln()).exp()
    }

    /// Principal strains about a volumetric one, both up to `size` and of any order of magnitude below.
    pub fn strain(&mut self, size: f64) -> Vector3<f64> {
        let (shape, volume) = (self.of_any_size(1e-4 * size, size), self.of_any_size(1e-4 * size, size));
        let deviator = Vector3::new(self.between(-1.0, 1.0), self.between(-1.0, 1.0), self.between(-1.0, 1.0));
        let sign = if self.between(-1.0, 1.0) < 0.0 { -1.0 } else { 1.0 };
        let e = deviator.add_scalar(-deviator.sum() / 3.0) * shape;
        let mut strain = e.add_scalar(sign * volume / 3.0);
        // Now and then two strains are equal, or nearly so.
        match self.between(0.0, 10.0) as u32 {
            0 => strain[1] = strain[0],
            1 => strain[2] = strain[1] * (1.0 + self.of_any_size(1e-12, 1e-6)),
            _ => {}
        }
        strain
    }
}
