//! The generalised interpolation method (GIMP): N_v averaged over a box around the point.
//!
//! `S_vp = (1/V) ∫ N_v dV` over the box `|x - x_p|_d <= l_d`, `∇S_vp` the mean of `∇N_v` (Bardenhagen &
//! Kober 2004). On a rectilinear mesh both are products over the directions. In each, the domain is
//! cut at the grid lines: N_v is linear in every part, so that its mean over the part is its value in
//! the middle, exactly and without cancellation, for graded axes and any half length.

use crate::basis::{Basis, Convection, ConvectionError, DomainPart, DomainReport, RingSide, Seed};
use crate::corner::BEYOND;
use crate::corner::{self, Corner, CornerPoint};
use crate::domain::{Domain, vector};
use crate::domain_control::longest;
use crate::influence::Stencil;
use crate::tensor::{determinant, outline, right_stretch, signs};
use mpm_grid::{Axis, Block, LinearCell, Mesh, NodeId, NodeKind, OutsideMesh, Vector};
use std::array::from_fn;

/// Slack of [`BEYOND`], that of `Mesh::locate` [cells].
const SLACK: f64 = 1e-9;

/// GIMP on rectilinear meshes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Gimp {
    /// How half lengths follow the deformation.
    pub update: GimpUpdate,
}

/// How the half lengths `l_d` follow the deformation gradient F (Coombs et al. 2020 compare them).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GimpUpdate {
    /// `l_d = U_dd l⁰_d` with `U = √(FᵀF)` (Charlton, Coombs & Augarde 2017): blind to rotation.
    #[default]
    Stretch,
    /// `l_d = F_dd l⁰_d`: exact for stretches along the axes, an error past a quarter turn.
    Diagonal,
    /// `l_d = (det F)^(1/D) l⁰_d`.
    Volume,
    /// `l_d = l⁰_d`.
    Fixed,
}

/// Half lengths of a point's box `[L]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfLengths<const D: usize> {
    /// At rest, `l⁰_d`.
    pub initial: Vector<D>,
    /// Now, `l_d`.
    pub current: Vector<D>,
}

impl<const D: usize> HalfLengths<D> {
    /// A box at rest with half lengths `l⁰_d` `[L]`, which must be positive.
    pub fn at_rest(half_lengths: Vector<D>) -> Self {
        assert!(half_lengths.iter().all(|&l| l > 0.0), "half lengths are positive");
        Self { initial: half_lengths, current: half_lengths }
    }
}

/// The part of one axis that a domain covers.
#[derive(Clone, Copy)]
struct Overlap {
    /// First and last cell touched.
    first: u32,
    last: u32,
    /// Middle and half length of the domain.
    x: f64,
    l: f64,
}

/// Means along r of the hat function of a node over a domain that stands for a ring.
#[derive(Clone, Copy)]
struct Radial {
    /// As without weights.
    value: f64,
    /// Weighted by r.
    mass: f64,
    /// That of the slope, weighted by r.
    slope: f64,
}

/// An end of the domain too far outside, and how far [cells].
struct Beyond {
    end: f64,
    distance: f64,
}

impl Overlap {
    #[inline]
    fn of(axis: &Axis, x: f64, l: f64) -> Result<Self, Beyond> {
        let (low, below) = axis.locate(x - l);
        let (last, above) = axis.locate(x + l);
        for (end, local) in [(x - l, below), (x + l, above)] {
            let distance = 0.5 * (local.abs() - 1.0);
            let accepted = distance <= BEYOND * (1.0 + SLACK);
            if !accepted {
                return Err(Beyond { end, distance });
            }
        }
        // A domain that begins on a grid line does not touch the cell below.
        let first = if below == 1.0 && low < last { low + 1 } else { low };
        Ok(Self { first, last, x, l })
    }

    /// Ends of a cell, and of the part of the domain in it, relative to the point: so parts add up to the whole wherever
    /// the origin is.
    #[inline]
    fn ends(&self, axis: &Axis, cell: u32) -> (f64, f64, f64, f64) {
        let (a, b) = (axis.node(cell) - self.x, axis.node(cell + 1) - self.x);
        let from = if cell == self.first { -self.l } else { a };
        let to = if cell == self.last { self.l } else { b };
        (a, b, from, to)
    }

    /// Shares of a cell in the means of its lower and upper node's N_v, and in that of the upper's slope.
    ///
    /// The outermost cells reach to the ends of the domain, also where these lie outside the mesh.
    #[inline]
    fn part(&self, axis: &Axis, cell: u32) -> (f64, f64, f64) {
        let (a, b, from, to) = self.ends(axis, cell);
        let slope = (to - from) / (2.0 * self.l) / (b - a);
        let middle = 0.5 * (from + to);
        (slope * (b - middle), slope * (middle - a), slope)
    }

    /// As [`Self::at`] along r. With the part from m - L/2 to m + L/2 of a cell, `∫ N r dr = L (m N(m) + N' L²/12)` and
    /// `∫ N' r dr = L m N'`.
    fn along_radius(&self, axis: &Axis, node: u32) -> Radial {
        let (value, _) = self.at(axis, node);
        let (mut mass, mut slope) = (0.0, 0.0);
        let mut add = |cell: u32, is_upper: bool| {
            let (_, _, from, to) = self.ends(axis, cell);
            let (lower, upper, share) = self.part(axis, cell);
            let (middle, length) = (self.x + 0.5 * (from + to), to - from);
            let bow = share * length * length / 12.0;
            mass += if is_upper { upper * middle + bow } else { lower * middle - bow };
            slope += if is_upper { share * middle } else { -share * middle };
        };
        if node > self.first {
            add(node - 1, true);
        }
        if node <= self.last {
            add(node, false);
        }
        Radial { value, mass: mass / self.x, slope: slope / self.x }
    }

    /// Mean value and slope of the hat function of one node.
    #[inline]
    fn at(&self, axis: &Axis, node: u32) -> (f64, f64) {
        let (mut value, mut slope) = (0.0, 0.0);
        if node > self.first {
            let (_, upper, rise) = self.part(axis, node - 1);
            value += upper;
            slope += rise;
        }
        if node <= self.last {
            let (lower, _, fall) = self.part(axis, node);
            value += lower;
            slope -= fall;
        }
        (value, slope)
    }
}

/// The parts of all axes that a domain covers.
#[inline]
fn overlaps<const D: usize>(
    axes: &[Axis; D],
    x: &Vector<D>,
    domain: &HalfLengths<D>,
) -> Result<[Overlap; D], OutsideMesh<D>> {
    let mut overlaps = [Overlap { first: 0, last: 0, x: 0.0, l: 0.0 }; D];
    for d in 0..D {
        overlaps[d] = Overlap::of(&axes[d], x[d], domain.current[d]).map_err(|beyond| {
            let mut position = *x;
            position[d] = beyond.end;
            OutsideMesh { position, distance: beyond.distance }
        })?;
    }
    Ok(overlaps)
}

/// The place of a box that is nearest to `x`, within it and on its surface.
fn onto_box<const D: usize>(end: &Vector<D>, x: &Vector<D>, domain: &HalfLengths<D>) -> Vector<D> {
    let mut arm = end - x;
    let half = &domain.current;
    let across = (0..D).max_by(|&a, &b| (arm[a].abs() / half[a]).total_cmp(&(arm[b].abs() / half[b])));
    for d in 0..D {
        let is_across = across == Some(d);
        arm[d] = if is_across { half[d].copysign(arm[d]) } else { arm[d].clamp(-half[d], half[d]) };
    }
    x + arm
}

/// Hands out the nodes that a ring's box reaches, with their means along r and z.
fn ring_nodes<const D: usize>(
    mesh: &Mesh<D>,
    x: &Vector<D>,
    domain: &HalfLengths<D>,
    mut take: impl FnMut(NodeId, Radial, (f64, f64)),
) -> Result<(), OutsideMesh<D>> {
    let axes = mesh.rectilinear().expect("`suits` has refused every other mesh");
    let along = overlaps(axes, x, domain)?;
    let mut index = [0; D];
    for z in along[1].first..=along[1].last + 1 {
        let axial = along[1].at(&axes[1], z);
        for r in along[0].first..=along[0].last + 1 {
            (index[0], index[1]) = (r, z);
            take(mesh.lattice().node(index), along[0].along_radius(&axes[0], r), axial);
        }
    }
    Ok(())
}

impl Gimp {
    /// Ratio of current to initial half lengths.
    fn stretches<const D: usize>(self, f: &Block<D>) -> Vector<D> {
        match self.update {
            GimpUpdate::Stretch => right_stretch(f).diagonal(),
            GimpUpdate::Diagonal => f.diagonal(),
            GimpUpdate::Volume => Vector::repeat(determinant(f).powf(1.0 / D as f64)),
            GimpUpdate::Fixed => Vector::repeat(1.0),
        }
    }
}

impl<const D: usize> Domain<D> for HalfLengths<D> {
    const NUMBERS: usize = 2 * D;

    fn store(&self, to: &mut Vec<f64>) {
        to.extend(self.initial.iter().chain(self.current.iter()));
    }

    fn restore(from: &[f64]) -> Result<Self, String> {
        match from.iter().find(|length| **length <= 0.0) {
            Some(length) => Err(format!("a half length is {length}, expected above 0")),
            None => Ok(Self { initial: vector(from), current: vector(&from[D..]) }),
        }
    }

    fn spread(&self) -> Option<Block<D>> {
        Some(Block::from_diagonal(&self.current.component_mul(&self.current)))
    }

    fn scale(&mut self, _x: &Vector<D>, map: &Block<D>) {
        self.current.component_mul_assign(&map.diagonal());
        self.initial.component_mul_assign(&map.diagonal());
    }

    fn outline(&self, x: &Vector<D>) -> Vec<Vector<D>> {
        let corner = |c| x + self.current.component_mul(&signs(c));
        outline(&(0..1 << D).map(corner).collect::<Vec<_>>())
    }
}

impl<const D: usize> Basis<D> for Gimp {
    type Domain = HalfLengths<D>;

    fn name(&self) -> &'static str {
        "GIMP"
    }

    fn suits(&self, mesh: &Mesh<D>) -> Result<(), &'static str> {
        if mesh.functions() != NodeKind::Vertices {
            return Err(
                "GIMP averages linear functions over boxes: expected linear functions of the mesh, or a \
                        basis that samples splines at corners (`Cpdi1`, `Cpdi2q`, `Cpdi2Hexahedron`)",
            );
        }
        match mesh.rectilinear() {
            Some(_) => Ok(()),
            None => Err("GIMP needs a mesh whose grid lines stay parallel to the coordinate axes: \
                         a box that is at rest or stretched, not bent, rotated or a ring"),
        }
    }

    fn seed(&self, piece: &LinearCell<D>, place: &mut dyn FnMut(Seed<D, HalfLengths<D>>)) {
        let centre = Vector::<D>::zeros();
        let (directions, volume) = (piece.jacobian(&centre), piece.volume());
        // Half the piece's extent along each axis; a piece that stands askew is as large as its box.
        let mut half = Vector::<D>::from_fn(|d, _| directions.row(d).iter().map(|r: &f64| r.abs()).sum());
        let askew = (0..D).any(|d| (0..D).any(|k| k != d && directions[(d, k)] != 0.0));
        if askew {
            half *= (volume / half.iter().map(|l| 2.0 * l).product::<f64>()).powf(1.0 / D as f64);
        }
        place(Seed { position: piece.position(&centre), volume, domain: HalfLengths::at_rest(half) });
    }

    fn influences(
        &self,
        mesh: &Mesh<D>,
        x: &Vector<D>,
        domain: &HalfLengths<D>,
        stencil: &mut Stencil<D>,
    ) -> Result<(), OutsideMesh<D>> {
        let axes = mesh.rectilinear().expect("`suits` has refused every other mesh");
        let overlaps = overlaps(axes, x, domain)?;
        let start: [(f64, f64); D] = from_fn(|d| overlaps[d].at(&axes[d], overlaps[d].first));
        let mut index = overlaps.map(|it| it.first);
        let mut factor = start;
        loop {
            let value = factor.iter().map(|it| it.0).product();
            let gradient = Vector::from_fn(|d, _| {
                factor.iter().enumerate().map(|(e, it)| if e == d { it.1 } else { it.0 }).product()
            });
            stencil.add(mesh.lattice().node(index), value, gradient);
            let Some(d) = (0..D).find(|&d| index[d] <= overlaps[d].last) else { return Ok(()) };
            index[d] += 1;
            factor[d] = overlaps[d].at(&axes[d], index[d]);
            for e in 0..d {
                index[e] = overlaps[e].first;
                factor[e] = start[e];
            }
        }
    }

    fn ring_influences(
        &self,
        mesh: &Mesh<D>,
        x: &Vector<D>,
        domain: &HalfLengths<D>,
        stencil: &mut Stencil<D>,
    ) -> Result<(), OutsideMesh<D>> {
        ring_nodes(mesh, x, domain, |node, radial, (value, slope)| {
            let gradient = [radial.slope * value, radial.mass * slope];
            stencil.add(node, radial.value * value, Vector::from_fn(|d, _| gradient[d]));
        })
    }

    fn ring_masses(
        &self,
        mesh: &Mesh<D>,
        x: &Vector<D>,
        domain: &HalfLengths<D>,
        stencil: &mut Stencil<D>,
    ) -> Result<(), OutsideMesh<D>> {
        ring_nodes(mesh, x, domain, |node, radial, (value, _)| {
            stencil.add(node, radial.mass * value, Vector::zeros());
        })
    }

    /// Means of N_v along the side, cut at the grid lines: at its corners alone, lines that cut it would see too little.
    fn ring_side(
        &self,
        mesh: &Mesh<D>,
        x: &Vector<D>,
        domain: &HalfLengths<D>,
        side: &RingSide<D>,
        stencil: &mut Stencil<D>,
    ) -> Result<(), OutsideMesh<D>> {
        let axes = mesh.rectilinear().expect("`suits` has refused every other mesh");
        let [from, to] = side.ends.map(|end| onto_box(&end, x, domain));
        let along = to - from;
        // Where grid lines cut the side, from 0 to 1.
        let mut cuts = vec![0.0, 1.0];
        for (d, axis) in axes.iter().enumerate().filter(|(d, _)| along[*d] != 0.0) {
            let lines = (0..=axis.cells()).map(|k| (axis.node(k) - from[d]) / along[d]);
            cuts.extend(lines.filter(|at| (0.0..1.0).contains(at)));
        }
        cuts.sort_by(f64::total_cmp);
        // The density whose moments are the parts: q_0 (1 - s) + q_1 s.
        let [a, b] = side.parts;
        let density = |s: f64| (4.0 * a - 2.0 * b) * (1.0 - s) + (4.0 * b - 2.0 * a) * s;
        let gauss = 0.5 / 3.0_f64.sqrt();
        for part in cuts.windows(2).filter(|part| part[1] > part[0]) {
            let (middle, length) = (0.5 * (part[0] + part[1]), part[1] - part[0]);
            for s in [middle - gauss * length, middle + gauss * length] {
                let place = mesh.locate(&(from + along * s), BEYOND)?;
                let weight = 0.5 * length * density(s);
                mesh.values(&place, |node, n| stencil.add(node, n * weight, Vector::zeros()));
            }
        }
        Ok(())
    }

    fn convect(
        &self,
        domain: &mut HalfLengths<D>,
        position: &mut Vector<D>,
        step: &Convection<'_, D>,
    ) -> Result<(), ConvectionError> {
        let f = &step.deformation_gradient;
        let j = determinant(f);
        if j.is_nan() || j <= 0.0 {
            let volume = j * domain.initial.iter().map(|l| 2.0 * l).product::<f64>();
            return Err(ConvectionError::Inverted { volume });
        }
        let current = domain.initial.component_mul(&self.stretches(f));
        if let Some(axis) = (0..D).find(|&d| current[d].is_nan() || current[d] <= 0.0) {
            return Err(ConvectionError::HalfLength { axis, half_length: current[axis] });
        }
        domain.current = current;
        *position += step.displacement;
        Ok(())
    }

    fn halve(
        &self,
        domain: &HalfLengths<D>,
        x: &Vector<D>,
        to_cells: &Block<D>,
    ) -> Option<[DomainPart<D, HalfLengths<D>>; 2]> {
        let lengths = Block::from_diagonal(&domain.current);
        let d = longest(lengths.column_iter().map(|l| l.into_owned()), to_cells);
        let mut half = *domain;
        half.current[d] *= 0.5;
        half.initial[d] *= 0.5;
        Some([-1.0, 1.0].map(|side| {
            let mut position = *x;
            position[d] += side * half.current[d];
            DomainPart { position, domain: half, share: 0.5 }
        }))
    }

    fn n_corners(&self) -> usize {
        1 << D
    }

    fn corners(
        &self,
        mesh: &Mesh<D>,
        point: &CornerPoint<D>,
        domain: &HalfLengths<D>,
        to: &mut Vec<Corner<D>>,
    ) -> Result<(), OutsideMesh<D>> {
        corner::of_box(mesh, (&point.position, point.is_ring), &domain.current, to)
    }

    fn diagnose(
        &self,
        mesh: &Mesh<D>,
        x: &Vector<D>,
        domain: &HalfLengths<D>,
    ) -> Result<DomainReport, OutsideMesh<D>> {
        let measure = domain.current.component_div(&domain.initial).product();
        let mut report = DomainReport { measure, ..DomainReport::default() };
        for corner in domain.outline(x) {
            let place = mesh.locate(&corner, BEYOND)?;
            report.corners_outside += usize::from(place.local.amax() > 1.0);
        }
        Ok(report)
    }
}
