//! Parts of a body, from which material points are made.

use mpm_grid::{Block, Vector};

/// A part of a body: a parallelepiped that points are seeded from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part<const D: usize> {
    /// Its middle `[L]`.
    pub centre: Vector<D>,
    /// Its columns lead from the centre to the middles of the sides `[L]`.
    pub half_vectors: Block<D>,
    /// What the part holds, its own volume or not `[L^D]`.
    pub volume: f64,
}

/// The parts of a body, and of its faces.
#[derive(Clone, Debug, Default)]
pub struct Parts<const D: usize> {
    /// In the order of the mesh's cells.
    pub parts: Vec<Part<D>>,
    /// For each face asked for, the parts that carry it with their areas of it.
    pub faces: Vec<Vec<Share<D>>>,
    /// What the parts hold together if nothing is lost, where that is known otherwise `[L^D]`.
    pub volume: Option<f64>,
}

/// What a part carries of a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Share<const D: usize> {
    /// Index of the part.
    pub part: usize,
    /// Its area of the face `[L^(D-1)]`.
    pub area: f64,
    /// The middle of that area `[L]`.
    pub centre: Vector<D>,
}

/// A part of a plane across an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Face<const D: usize> {
    /// Direction that the plane cuts, from 0.
    pub axis: usize,
    /// Coordinate of the plane `[L]`.
    pub at: f64,
    /// Lowest and highest corner of the part, where it is not the whole plane `[L]`.
    pub within: Option<([f64; D], [f64; D])>,
}
