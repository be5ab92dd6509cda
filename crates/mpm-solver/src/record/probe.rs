//! Points that are followed through the history.

use crate::model::{NamedBody, Probe};
use crate::observe::{Column, ColumnKind, Entry};
use mpm_assembly::PointView;
use mpm_grid::Vector;
use mpm_material::SymmetricTensor;

impl<const D: usize> Probe<D> {
    /// Follows points of a body, ascending, from where they are.
    pub fn new(name: impl Into<String>, body: usize, points: Vec<usize>, bodies: &[NamedBody<D>]) -> Self {
        let mut probe = Self { name: name.into(), body, points, rest: Vector::zeros() };
        probe.rest = probe.mean_position(bodies);
        probe
    }

    /// Columns of its entries.
    pub(crate) fn columns(&self) -> [Column; 3] {
        let column = |what: &str, width| {
            let name = format!("probe/{}/{what}", self.name);
            Column { name, kind: ColumnKind::Real, width }
        };
        [column("position", D), column("displacement", D), column("cauchy_stress", 9)]
    }

    /// Mean position and displacement, weighted by the volume at rest `[L]`; mean Cauchy stress `[F/L²]`, weighted
    /// by the present volume: `Σ V⁰ τ / Σ V`.
    pub(crate) fn entries(&self, bodies: &[NamedBody<D>]) -> [Entry; 3] {
        let position = self.mean_position(bodies);
        let (mut stress, mut volume) = ([0.0; 9], 0.0);
        for view in self.views(bodies) {
            volume += view.reference_volume * view.volume_ratio;
            for (sum, tau) in stress.iter_mut().zip(rows(&view.kirchhoff)) {
                *sum += view.reference_volume * tau;
            }
        }
        [
            Entry::Real(position.iter().copied().collect()),
            Entry::Real((position - self.rest).iter().copied().collect()),
            Entry::Real(stress.iter().map(|sum| sum / volume).collect()),
        ]
    }

    /// Mean position of its points `[L]`.
    pub(crate) fn mean_position(&self, bodies: &[NamedBody<D>]) -> Vector<D> {
        let (mut sum, mut volume) = (Vector::zeros(), 0.0);
        for view in self.views(bodies) {
            sum += view.position * view.reference_volume;
            volume += view.reference_volume;
        }
        sum / volume
    }

    fn views(&self, bodies: &[NamedBody<D>]) -> impl Iterator<Item = PointView<D>> {
        self.points.iter().map(|&point| bodies[self.body].body.point(point))
    }
}

fn rows(t: &SymmetricTensor) -> [f64; 9] {
    [t.xx, t.xy, t.zx, t.xy, t.yy, t.yz, t.zx, t.yz, t.zz]
}
