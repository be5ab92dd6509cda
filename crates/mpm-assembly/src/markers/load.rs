//! Loads on a side of a body.

use super::moving::Moving;
use super::side::BodySide;
use crate::unknowns::CoupledPlaces;
use mpm_grid::{LoadFraction, Ramp, Vector};
use mpm_linear::Symmetry;

/// What acts on a side at full load.
#[derive(Clone, Debug, PartialEq)]
pub enum MarkerForce<const D: usize> {
    /// A pressure on the present boundary, against its outward normal `[F/L²]`.
    Pressure(f64),
    /// Forces on the markers that do not change with the motion `[F]`.
    Dead(Vec<Vector<D>>),
}

impl<const D: usize> MarkerForce<D> {
    /// A traction per area at rest `[F/L²]`, the same everywhere: half of each edge's force at either end.
    pub fn traction(side: &BodySide<D>, traction: &Vector<D>) -> Self {
        Self::Dead(side.measures().into_iter().map(|measure| traction * measure).collect())
    }
}

/// A load on a side of a body, as a contribution.
///
/// A pressure p gives every corner of a facet `−p A/D` with the facet's present area vector A. Summed over facets this is
/// the derivative of p times a volume: its own derivative is symmetric but for the ends of the side.
#[derive(Debug)]
pub struct MarkerLoad<const D: usize> {
    pub(super) markers: Moving<D>,
    pub(super) force: MarkerForce<D>,
    pub(super) ramp: Ramp,
    pub(super) symmetry: Symmetry,
    pub(super) from: LoadFraction,
    pub(super) couplings: CoupledPlaces,
}

impl<const D: usize> MarkerLoad<D> {
    /// A load on a side, in parts by the ramp. With [`Symmetry::Symmetric`] the tangent of a pressure is without what the
    /// side's ends add to it: nothing where the side is closed or its ends are held across the plane on which they slide.
    pub fn new(side: BodySide<D>, force: MarkerForce<D>, ramp: Ramp, symmetry: Symmetry) -> Self {
        let markers = Moving::new(side);
        let (from, couplings) = (LoadFraction::START, CoupledPlaces::default());
        Self { markers, force, ramp, symmetry, from, couplings }
    }

    /// The side.
    pub fn side(&self) -> &BodySide<D> {
        &self.markers.side
    }

    /// Forces on the markers where they stand at `positions` `[F]`.
    pub(super) fn forces(&self, positions: &[Vector<D>], at: LoadFraction) -> Vec<Vector<D>> {
        let part = self.ramp.value(at);
        match &self.force {
            MarkerForce::Dead(forces) => {
                let mut own = vec![Vector::zeros(); forces.len()];
                self.markers.own.iter().for_each(|&marker| own[marker] = forces[marker] * part);
                own
            }
            MarkerForce::Pressure(p) => {
                let areas = self.side().areas_of(&self.markers.facets, positions);
                areas.into_iter().map(|area| area * (-p * part)).collect()
            }
        }
    }

    /// p/D, which a facet of one layer gives to each of its corners `[F/L²]`.
    pub(super) fn pressure_on_corner(&self, at: LoadFraction) -> f64 {
        match self.force {
            MarkerForce::Pressure(p) => p * self.ramp.value(at) / (D as f64 * f64::from(self.side().layers)),
            MarkerForce::Dead(_) => 0.0,
        }
    }
}
