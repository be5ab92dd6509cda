//! Contributions that several ranks share, each with some of the points of the same bodies.

use crate::body::OccupiedCell;
use mpm_grid::{Lattice, Vector};
use std::ops::Range;

/// Who else holds points of the same bodies. Every method has the body of one who holds all; all ranks call it together, so
/// that one that fails does so after the call.
pub trait Sharing<const D: usize> {
    /// The cells that anybody occupies, each once or more often, of what one occupies: those that are one's own, and those
    /// around them that are at most two cells away.
    fn joined(&self, lattice: &Lattice<D>, occupied: Vec<OccupiedCell>) -> Vec<OccupiedCell> {
        let _ = lattice;
        occupied
    }

    /// Whether a cell is one's own: every cell is that of one.
    fn is_own(&self, cell: [u32; D]) -> bool {
        let _ = cell;
        true
    }

    /// Whether one adds what belongs to no point, such as the load on a tool: there is one who does.
    fn leads(&self) -> bool {
        true
    }

    /// The numbers that all have, one after the other, and where one's own stand among them.
    fn gathered(&self, own: Vec<f64>) -> (Vec<f64>, Range<usize>) {
        let range = 0..own.len();
        (own, range)
    }
}

/// One holds all points.
#[derive(Clone, Copy, Debug, Default)]
pub struct Unshared;

impl<const D: usize> Sharing<D> for Unshared {}

/// A size with which an out-of-balance force is compared `[F]`.
#[derive(Clone, Debug, PartialEq)]
pub enum Scale<const D: usize> {
    /// The size.
    Size(f64),
    /// The norm of these forces on the active nodes, of which each rank that shares the contribution has a part.
    OfNodes(Vec<Vector<D>>),
}

impl<const D: usize> From<f64> for Scale<D> {
    fn from(size: f64) -> Self {
        Self::Size(size)
    }
}

/// What a contribution remembers of a point.
#[derive(Clone, Debug, PartialEq)]
pub struct OfPoint {
    /// Number of the body.
    pub body: usize,
    /// Number of the point in it.
    pub point: usize,
    /// What is remembered.
    pub numbers: Vec<f64>,
}

/// What is the same for all who share a contribution, and what belongs to points, ascending.
pub type TakenApart = (Vec<f64>, Vec<OfPoint>);

/// How the numbers that a contribution [saves](crate::Contribution::save) are shared out with the points.
#[derive(Clone, Copy, Debug)]
pub struct SavedByPoint {
    /// What is the same, and what belongs to points.
    pub apart: fn(&[f64]) -> TakenApart,
    /// The reverse, of the points that one has, ascending.
    pub together: fn(&[f64], &[OfPoint]) -> Vec<f64>,
}
