//! Points that are followed through the history.

use crate::model::{NamedBody, Probe};
use crate::observe::{Column, ColumnKind, Entry};
use crate::ranks::{Alone, Ranks, total};
use mpm_assembly::{PointView, Space};
use mpm_grid::Vector;
use mpm_material::SymmetricTensor;

impl<const D: usize> Probe<D> {
    /// Follows points of a body, ascending, from where they are.
    pub fn new(name: impl Into<String>, body: usize, points: Vec<usize>, bodies: &[NamedBody<D>]) -> Self {
        let mut probe = Self { name: name.into(), body, points, rest: Vector::zeros() };
        probe.rest = probe.mean_position(bodies, &Alone);
        probe
    }

    /// Columns of its entries.
    pub(crate) fn columns(&self, space: Space) -> Vec<Column> {
        let column = |what: &str, width| {
            let name = format!("probe/{}/{what}", self.name);
            Column { name, kind: ColumnKind::Real, width }
        };
        let width = space.coordinates::<D>();
        let mut columns =
            vec![column("position", width), column("displacement", width), column("cauchy_stress", 9)];
        if space.turns::<D>() {
            columns.push(column("angle", 1));
        }
        columns
    }

    /// Mean position and displacement, weighted by the volume at rest `[L]`; mean Cauchy stress `[F/L²]`, weighted
    /// by the present volume: `Σ V⁰ τ / Σ V`; of bodies that turn about their axis the mean angle `[degrees]`.
    pub(crate) fn entries(&self, bodies: &[NamedBody<D>], ranks: &dyn Ranks<D>) -> Vec<Entry> {
        let position = self.mean_position(bodies, ranks);
        let (mut stress, mut volume) = ([0.0; 9], 0.0);
        let width = bodies[self.body].body.space().coordinates::<D>();
        for (view, &point) in self.views(bodies).zip(&self.points) {
            volume += view.reference_volume * view.volume_ratio;
            for (sum, tau) in stress.iter_mut().zip(rows(&bodies[self.body].body.kirchhoff(point))) {
                *sum += view.reference_volume * tau;
            }
        }
        ranks.sum(&mut stress);
        let volume = total(ranks, volume);
        let in_place = |x: Vector<D>| Entry::Real(x.iter().take(width).copied().collect());
        let mut entries = vec![
            in_place(position),
            in_place(position - self.rest),
            Entry::Real(stress.iter().map(|sum| sum / volume).collect()),
        ];
        let turned = self.views(bodies).filter_map(|view| Some((view.reference_volume, view.angle?)));
        let mut sums = turned.fold([0.0, 0.0], |[whole, sum], (v, angle)| [whole + v, sum + v * angle]);
        ranks.sum(&mut sums);
        if sums[0] > 0.0 {
            entries.push(Entry::Real(vec![(sums[1] / sums[0]).to_degrees()]));
        }
        entries
    }

    /// Mean position of its points `[L]`.
    pub(crate) fn mean_position(&self, bodies: &[NamedBody<D>], ranks: &dyn Ranks<D>) -> Vector<D> {
        let (mut sum, mut volume) = (Vector::<D>::zeros(), 0.0);
        for view in self.views(bodies) {
            sum += view.position * view.reference_volume;
            volume += view.reference_volume;
        }
        ranks.sum(sum.as_mut_slice());
        sum / total(ranks, volume)
    }

    fn views(&self, bodies: &[NamedBody<D>]) -> impl Iterator<Item = PointView<D>> {
        self.points.iter().map(|&point| bodies[self.body].body.point(point))
    }
}

fn rows(t: &SymmetricTensor) -> [f64; 9] {
    [t.xx, t.xy, t.zx, t.xy, t.yy, t.yz, t.zx, t.yz, t.zz]
}
