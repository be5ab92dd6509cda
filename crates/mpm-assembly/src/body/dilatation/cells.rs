//! Cells over which volume changes are averaged, and their quadrature.

use crate::body::space::Space;
use mpm_basis::parallel::each_point;
use mpm_basis::{ActiveNodes, Cells, Connectivity, UnconnectedPoint};
use mpm_grid::{CellId, Mesh, NodeKind, Place, Vector};

/// How far outside the mesh a point may stand, as parts of domains may `[cells]`.
const BEYOND: f64 = 0.5;

/// What the volume change of a cell is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeanDilatation {
    /// The mean over the points in it: for bodies whose surface moves through cells.
    Points,
    /// That of the cell itself, wherever its points stand: for cells full of material. A cell with a node
    /// that no point influences takes the mean over its points.
    Cell,
}

/// Cells over which volume changes are averaged.
#[derive(Clone, Debug)]
pub struct Dilatation<const D: usize> {
    pub(super) cells: Cells,
    /// Quadrature points of the cells, where the mean is not over the material points.
    pub(super) quadrature: Quadrature<D>,
}

/// 2^D Gauss points for each of some cells: exact for the volume of a multilinear cell, and for that of its ring.
#[derive(Clone, Debug, Default)]
pub(super) struct Quadrature<const D: usize> {
    /// Number of such cells before each cell; empty where there are none at all.
    before: Vec<u32>,
    /// Weights, 2^D per cell; with a hoop times their radius `[L^D]`.
    weight: Vec<f64>,
    /// Positions of the 2^D corners among the nodes of the cell.
    corner: Vec<u32>,
    /// `∇N`, `[Gauss point][corner]` `[1/L]`.
    gradient: Vec<Vector<D>>,
    /// N over the radius of the Gauss point, `[Gauss point][corner]`; empty where there is no hoop `[1/L]`.
    hoop: Vec<f64>,
}

/// Gauss points of a cell, see [`Quadrature`].
#[derive(Clone, Copy)]
pub(super) struct OfCell<'a, const D: usize> {
    pub weights: &'a [f64],
    pub corners: &'a [u32],
    pub gradients: &'a [Vector<D>],
    hoops: &'a [f64],
}

impl<'a, const D: usize> OfCell<'a, D> {
    /// Weights of the Gauss points, with gradients and hoops (none where there is no hoop) of the corners.
    pub fn points(self) -> impl Iterator<Item = (f64, &'a [Vector<D>], &'a [f64])> {
        let n = 1 << D;
        let points = self.weights.iter().zip(self.gradients.chunks_exact(n)).enumerate();
        points.map(move |(q, (&weight, gradients))| {
            (weight, gradients, self.hoops.get(q * n..(q + 1) * n).unwrap_or_default())
        })
    }
}

impl<const D: usize> Dilatation<D> {
    /// Gathers the points at `positions` by the cells of `mesh`, in a space.
    ///
    /// # Errors
    /// The first point outside the mesh.
    ///
    /// # Panics
    /// The nodes are not the vertices of the mesh.
    pub fn of(
        (mean, space): (MeanDilatation, Space),
        positions: &[Vector<D>],
        connectivity: &Connectivity<D>,
        mesh: &Mesh<D>,
        active: &ActiveNodes<D>,
    ) -> Result<Self, UnconnectedPoint<D>> {
        assert_eq!(active.space().kind(), NodeKind::Vertices, "cells have their nodes at their corners");
        let locate = |point: usize| {
            let x = &positions[point];
            let place =
                mesh.locate(x, BEYOND).map_err(|reason| UnconnectedPoint { point, position: *x, reason })?;
            Ok(mesh.lattice().cell(place.cell).index() as u32)
        };
        let located: Vec<Result<u32, UnconnectedPoint<D>>> = each_point(positions.len(), &locate);
        let cell: Vec<u32> = located.into_iter().collect::<Result<_, _>>()?;

        let corners = |cell: u32| -> Option<Vec<u32>> {
            if mean == MeanDilatation::Points {
                return None;
            }
            let index = mesh.lattice().cell_index(CellId::from_index(cell as usize)?);
            let corners = mesh.lattice().corners(index);
            corners[..1 << D].iter().map(|&node| active.number(node).map(|it| it as u32)).collect()
        };
        let cells = Cells::of(connectivity, &cell, |cell| corners(cell).unwrap_or_default());
        let mut quadrature = Quadrature::default();
        if mean == MeanDilatation::Cell {
            for k in 0..cells.len() {
                quadrature.before.push((quadrature.weight.len() >> D) as u32);
                let number = cells.number(k);
                if let (Some(corners), Some(id)) = (corners(number), CellId::from_index(number as usize)) {
                    let place = |it: &u32| cells.nodes(k).partition_point(|node| node < it) as u32;
                    quadrature.corner.extend(corners.iter().map(place));
                    quadrature.push(mesh, mesh.lattice().cell_index(id), space);
                }
            }
            quadrature.before.push((quadrature.weight.len() >> D) as u32);
        }
        Ok(Self { cells, quadrature })
    }

    /// The cells.
    pub fn cells(&self) -> &Cells {
        &self.cells
    }
}

impl<const D: usize> Quadrature<D> {
    fn push(&mut self, mesh: &Mesh<D>, cell: [u32; D], space: Space) {
        let shape = mesh.linear_cell(cell);
        let a = 1.0 / 3.0_f64.sqrt();
        for q in 0..1 << D {
            let local = Vector::<D>::from_fn(|d, _| if q >> d & 1 == 0 { -a } else { a });
            let radius = if space.is_axisymmetric() { Some(shape.position(&local)[0]) } else { None };
            self.weight.push(shape.determinant(&local).abs() * radius.unwrap_or(1.0));
            mesh.values_and_gradients(&Place { cell, local }, |_, value, gradient| {
                self.gradient.push(gradient);
                self.hoop.extend(radius.map(|radius| value / radius));
            });
        }
    }

    /// Those of a cell; nothing where the mean is over its points.
    pub fn of(&self, cell: usize) -> Option<OfCell<'_, D>> {
        let range = self.before.get(cell..cell + 2)?;
        let (k, end) = (range[0] as usize, range[1] as usize);
        let n = 1 << D;
        (k < end).then(|| OfCell {
            weights: &self.weight[k * n..end * n],
            corners: &self.corner[k * n..end * n],
            gradients: &self.gradient[k * n * n..end * n * n],
            hoops: self.hoop.get(k * n * n..end * n * n).unwrap_or_default(),
        })
    }
}
