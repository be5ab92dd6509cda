//! What a history tells of a wall.

use super::held::Held;
use crate::contribution::{OfParts, Recorded};
use mpm_contact::moment;
use mpm_grid::Vector;
use nalgebra::Vector3;

/// Sums over the markers that a wall holds.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Summary<const D: usize> {
    /// Force on the body `[F]`, and its moment about the wall's reference point `[F L]`.
    pub reaction: Vector<D>,
    pub moment: Vector3<f64>,
    /// Largest gap `[L]`.
    pub gap: f64,
    /// Where the reference point stands `[L]`.
    pub position: Vector<D>,
    /// How far the wall has turned `[rad]`.
    pub angle: f64,
}

impl<const D: usize> Summary<D> {
    /// Of a wall that holds nothing.
    pub fn at(position: Vector<D>, angle: f64) -> Self {
        Self { reaction: Vector::zeros(), moment: Vector3::zeros(), gap: 0.0, position, angle }
    }

    /// Takes markers in, of those at some positions `[L]`.
    pub fn add(&mut self, held: &[Held<D>], positions: &[Vector<D>]) {
        for held in held {
            self.reaction -= held.force;
            self.moment -= moment(&(positions[held.marker] - self.position), &held.force);
            self.gap = self.gap.max(held.gap);
        }
    }

    /// Columns below `wall/<name>/`.
    pub fn columns(&self, name: &str) -> Vec<Recorded> {
        let path = |column: &str| format!("wall/{name}/{column}");
        let moment = if D == 2 { vec![self.moment.z] } else { self.moment.iter().copied().collect() };
        vec![
            Recorded::real(path("reaction"), self.reaction.as_slice()),
            Recorded::real(path("moment"), moment),
            Recorded::real(path("gap"), [self.gap]).of_parts(OfParts::Largest),
            Recorded::real(path("position"), self.position.as_slice()).of_parts(OfParts::Same),
            Recorded::real(path("angle"), [self.angle.to_degrees()]).of_parts(OfParts::Same),
        ]
    }
}
