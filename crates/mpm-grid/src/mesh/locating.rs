//! Where positions lie in a mesh.

use super::{Mesh, Shape};
use crate::Vector;
use crate::location::{OutsideMesh, Place, place_on, within};

/// Cells that location in a ring may cross from its first guess to the cell sought.
const WALK: usize = 32;
/// The same from a hint; past that, a guess is cheaper.
const WALK_FROM_HINT: usize = 4;

impl<const D: usize> Mesh<D> {
    /// The place of position `x` `[L]`, accepted up to `beyond` cells outside the mesh.
    ///
    /// * A position on a face belongs to the lower of the two cells; on the seam of a full ring to
    ///   the last cell, so that every line of nodes is treated alike.
    /// * Local coordinates within 2e-9 of ±1 become ±1; up to 1e-9 cells outside count as inside.
    /// * Farther outside, local coordinates of the boundary cell continue to 1 + 2 `beyond`.
    #[inline]
    pub fn locate(&self, x: &Vector<D>, beyond: f64) -> Result<Place<D>, OutsideMesh<D>> {
        match &self.shape {
            Shape::Rectilinear(axes) => within(x, place_on(axes, x), beyond),
            Shape::Bent { axes, motion } => {
                // The map of the whole box restricted to a cell is the cell's own map.
                let Some(rest) = motion.recall(x) else {
                    return Err(OutsideMesh { position: *x, distance: f64::INFINITY });
                };
                within(x, place_on(axes, &rest), beyond)
            }
            Shape::Ring(ring) if self.splines.is_some() => {
                within(x, ring.place_round(&self.lattice, x), beyond)
            }
            Shape::Ring(ring) => match ring.walk(&self.lattice, x, ring.guess(x), WALK) {
                Ok(place) => within(x, place, beyond),
                Err(distance) => Err(OutsideMesh { position: *x, distance }),
            },
        }
    }

    /// As [`Self::locate`], for a position expected in or near the cell of `hint`: a ring is
    /// searched from there first, without trigonometry.
    #[inline]
    pub fn locate_near(&self, x: &Vector<D>, beyond: f64, hint: &Place<D>) -> Result<Place<D>, OutsideMesh<D>> {
        if let Shape::Ring(ring) = &self.shape
            && self.splines.is_none()
            && let Ok(place) = ring.walk(&self.lattice, x, hint.cell, WALK_FROM_HINT)
        {
            return within(x, place, beyond);
        }
        self.locate(x, beyond)
    }

    /// As [`Self::locate`] for positions near one another, such as the corners of a domain; fills `places` in their order.
    ///
    /// # Errors
    /// The first position farther than `beyond` cells outside the mesh.
    #[inline]
    pub fn locate_each<'a>(
        &self,
        positions: impl Iterator<Item = &'a Vector<D>> + Clone,
        beyond: f64,
        places: &mut [Place<D>],
    ) -> Result<(), OutsideMesh<D>> {
        if let Shape::Rectilinear(axes) = &self.shape {
            for (d, axis) in axes.iter().enumerate() {
                axis.locate_each(positions.clone().map(|x| x[d]), |k, cell, local| {
                    (places[k].cell[d], places[k].local[d]) = (cell, local);
                });
            }
            return places.iter().zip(positions).try_for_each(|(place, x)| within(x, *place, beyond).map(drop));
        }
        let mut before = None;
        for (place, x) in places.iter_mut().zip(positions) {
            *place = match &before {
                Some(near) => self.locate_near(x, beyond, near)?,
                None => self.locate(x, beyond)?,
            };
            before = Some(*place);
        }
        Ok(())
    }
}
