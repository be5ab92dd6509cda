//! Random numbers and checks of distances that the tests of all shapes share.
#![allow(dead_code, reason = "every test program uses a part")]

use mpm_contact::{Near, Shape};
use mpm_grid::{Block, Vector};

/// Splitmix64: the same numbers everywhere.
pub struct Random(pub u64);

impl Random {
    /// In [0, 1).
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        f64::from(u32::try_from((z ^ (z >> 31)) >> 32).unwrap()) / 4_294_967_296.0
    }

    pub fn between(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.unit()
    }

    pub fn vector<const D: usize>(&mut self, from: f64, to: f64) -> Vector<D> {
        Vector::from_fn(|_, _| self.between(from, to))
    }
}

pub fn near<const D: usize>(shape: &dyn Shape<D>, x: &Vector<D>) -> Vec<Near<D>> {
    let mut out = Vec::new();
    shape.near(x, f64::INFINITY, &mut out);
    out
}

/// Compares normals with differences of the distance, and Hessians with differences of the normal, at `x`; only where
/// the nearest feature stays the same within the steps. Tells whether it could.
pub fn derivatives_hold<const D: usize>(
    shape: &dyn Shape<D>,
    x: &Vector<D>,
    step: f64,
    tolerance: f64,
) -> bool {
    let here = near(shape, x);
    assert!((here[0].normal.norm() - 1.0).abs() < 1e-12, "{x:?}");
    let mut gradient = Vector::<D>::zeros();
    let mut hessian = Block::<D>::zeros();
    for d in 0..D {
        let by = Vector::<D>::from_fn(|e, _| if e == d { step } else { 0.0 });
        let (above, below) = (near(shape, &(x + by)), near(shape, &(x - by)));
        if above[0].feature != here[0].feature || below[0].feature != here[0].feature {
            return false;
        }
        gradient[d] = (above[0].distance - below[0].distance) / (2.0 * step);
        hessian.set_column(d, &((above[0].normal - below[0].normal) / (2.0 * step)));
    }
    let scale = 1.0 + hessian.norm();
    assert!((gradient - here[0].normal).norm() < tolerance * scale, "{x:?}: {gradient:?} {here:?}");
    assert!((hessian - here[0].hessian).norm() < tolerance * scale * scale, "{x:?}: {hessian:?} {here:?}");
    assert!((here[0].hessian - here[0].hessian.transpose()).norm() < 1e-12 * scale);
    assert!((here[0].hessian * here[0].normal).norm() < 1e-10 * scale);
    true
}
