//! The pivots of a factorisation, seen one after another.

use crate::report::{Factored, Inertia, Method, Pivot};

/// Pivots seen so far.
#[derive(Default)]
pub(super) struct Pivots {
    positive: usize,
    negative: usize,
    weakest: Option<Pivot>,
    /// Smallest and largest in size.
    range: Option<(f64, f64)>,
    /// The first that is zero or not finite.
    pub(super) unusable: Option<Pivot>,
}

impl Pivots {
    pub(super) fn add(&mut self, pivot: Pivot) {
        let size = pivot.value.abs();
        if (size == 0.0 || !size.is_finite()) && self.unusable.is_none() {
            self.unusable = Some(pivot);
        }
        self.positive += usize::from(pivot.value > 0.0);
        self.negative += usize::from(pivot.value < 0.0);
        if self.weakest.is_none_or(|w| pivot.relative < w.relative) {
            self.weakest = Some(pivot);
        }
        let (least, most) = self.range.unwrap_or((size, size));
        self.range = Some((least.min(size), most.max(size)));
    }

    /// What they say of the matrix.
    pub(super) fn report(self, method: Method) -> Factored {
        Factored {
            inertia: Some(Inertia { positive: self.positive, negative: self.negative }),
            weakest: self.weakest,
            pivot_ratio: self.range.map(|(least, most)| least / most),
            ..Factored::by(method)
        }
    }
}
