//! What all bases of the CPDI family share: influences sampled at the corners of a domain.
//!
//! `S_vp = Σ_c w_c N_v(x_c)`, `∇S_vp = Σ_c N_v(x_c) g_c` with the corners `x_c` of the domain, weights
//! `w_c` and gradient vectors `g_c` (Sadeghirad, Brannon & Burghardt 2011, equations 13–17): the means
//! over the domain of the interpolation of N_v from its corners, and of that interpolation's
//! gradient. A basis only says where its corners are and how they move; completeness follows from
//! `Σ w_c = 1`, `Σ g_c = 0` and `Σ x_c ⊗ g_c = I`.

use crate::basis::{Convection, ConvectionError, DomainReport};
use crate::corner::{BEYOND, Corner, CornerPoint};
use crate::influence::Stencil;
use mpm_grid::{Mesh, NodeId, NodeKind, OutsideMesh, Place, SplineProduct, Vector};
use std::array::from_fn;

/// Corners of a domain at most.
const CORNERS: usize = 8;

/// Part of the way to its point after which a corner on a face lies in a cell `[-]`.
const INWARDS: f64 = 1e-6;

/// One corner of a domain.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample<const D: usize> {
    /// `x_c` `[L]`.
    pub position: Vector<D>,
    /// `w_c` `[-]`.
    pub weight: f64,
    /// `g_c` `[1/L]`.
    pub gradient: Vector<D>,
}

/// The corners of a domain that is sampled at them.
///
/// # Errors
/// The first corner farther than half a cell outside the mesh.
pub(crate) fn corners<const D: usize>(
    mesh: &Mesh<D>,
    point: &CornerPoint<D>,
    samples: &[Sample<D>],
    to: &mut Vec<Corner<D>>,
) -> Result<(), OutsideMesh<D>> {
    for sample in samples {
        to.push(Corner::at(mesh, sample.position, (sample.gradient * point.volume, sample.weight))?);
    }
    Ok(())
}

/// Place of a corner, looked for from the corner before.
#[inline]
fn locate<const D: usize>(
    mesh: &Mesh<D>,
    x: &Vector<D>,
    before: &mut Option<Place<D>>,
) -> Result<Place<D>, OutsideMesh<D>> {
    let place = match before {
        Some(near) => mesh.locate_near(x, BEYOND, near)?,
        None => mesh.locate(x, BEYOND)?,
    };
    *before = Some(place);
    Ok(place)
}

/// Adds the influences of a domain with these corners to an empty stencil.
///
/// # Errors
/// The first corner farther than half a cell outside the mesh.
#[inline]
pub(crate) fn influences<const D: usize>(
    mesh: &Mesh<D>,
    samples: &[Sample<D>],
    stencil: &mut Stencil<D>,
) -> Result<(), OutsideMesh<D>> {
    debug_assert!(stencil.entries().is_empty(), "a stencil is filled by one point");
    if mesh.functions() != NodeKind::Vertices {
        return spline_influences(mesh, samples, stencil);
    }
    let mut places = [Place { cell: [0; D], local: Vector::zeros() }; CORNERS];
    let places = &mut places[..samples.len()];
    mesh.locate_each(samples.iter().map(|it| &it.position), BEYOND, places)?;
    if !sum_over_neighbours(mesh, places, samples, stencil) {
        sum_by_cells(mesh, places, samples, stencil);
    }
    Ok(())
}

/// Numbers of cells along a direction in which the corners of most domains lie.
const ACROSS: u32 = 2;

/// Places in the table of nodes of 2 x 2 (x 2) cells: of its first cell's corners, and of the steps to the others.
const CORNER_IN_TABLE: [usize; 8] = [0, 1, 3, 4, 9, 10, 12, 13];
const STEP_IN_TABLE: [usize; 3] = [1, 3, 9];

/// Adds the influences of a domain whose corners lie in neighbouring cells, by node; whether they do.
#[inline]
fn sum_over_neighbours<const D: usize>(
    mesh: &Mesh<D>,
    places: &[Place<D>],
    samples: &[Sample<D>],
    stencil: &mut Stencil<D>,
) -> bool {
    let (mut low, mut high) = (places[0].cell, places[0].cell);
    for place in &places[1..] {
        for d in 0..D {
            low[d] = low[d].min(place.cell[d]);
            high[d] = high[d].max(place.cell[d]);
        }
    }
    // Not across the seam of a ring, where nodes do not ascend.
    let nodes = mesh.lattice().nodes();
    if (0..D).any(|d| high[d] - low[d] >= ACROSS || high[d] + 1 >= nodes[d]) {
        return false;
    }
    let mut table = [(0.0, Vector::<D>::zeros()); 27];
    for (place, sample) in places.iter().zip(samples) {
        let first: usize = (0..D).map(|d| (place.cell[d] - low[d]) as usize * STEP_IN_TABLE[d]).sum();
        let mut corner = 0;
        mesh.values(place, |_, n| {
            let (value, gradient) = &mut table[first + CORNER_IN_TABLE[corner]];
            *value += sample.weight * n;
            *gradient += sample.gradient * n;
            corner += 1;
        });
    }
    let steps: [usize; D] = from_fn(|d| nodes[..d].iter().map(|&n| n as usize).product());
    let first = mesh.lattice().node(low).index();
    let width = |d: usize| if d < D { (high[d] - low[d]) as usize + 2 } else { 1 };
    let step = |d: usize| if d < D { steps[d] } else { 0 };
    for k in 0..width(2) {
        for j in 0..width(1) {
            for i in 0..width(0) {
                let (value, gradient) = table[9 * k + 3 * j + i];
                // Nodes opposite to the grid line that a corner lies on have none.
                if value != 0.0 || gradient != Vector::<D>::zeros() {
                    let node = NodeId::from_index(first + i * step(0) + j * step(1) + k * step(2));
                    stencil.add(node.expect("a node of the lattice"), value, gradient);
                }
            }
        }
    }
    true
}

/// Adds the influences of a domain cell by cell.
#[inline(never)]
fn sum_by_cells<const D: usize>(
    mesh: &Mesh<D>,
    places: &[Place<D>],
    samples: &[Sample<D>],
    stencil: &mut Stencil<D>,
) {
    // Corners in a cell met before add to the entries that are there.
    let mut cells = [[0; D]; CORNERS];
    let mut n_cells = 0;
    for (place, sample) in places.iter().zip(samples) {
        let (w, g) = (sample.weight, sample.gradient);
        if let Some(met) = cells[..n_cells].iter().position(|cell| *cell == place.cell) {
            let mut at = met << D;
            mesh.values(place, |_, n| {
                stencil.add_to(at, w * n, g * n);
                at += 1;
            });
        } else {
            cells[n_cells] = place.cell;
            n_cells += 1;
            mesh.values(place, |node, n| stencil.add(node, w * n, g * n));
        }
    }
    stencil.drop_zeros();
}

/// Nodes of splines that the corners of a domain may span, so that their influences are summed in a table.
const TABLE: u64 = 512;

/// As [`influences`] where the functions of the mesh are splines.
#[inline(never)]
fn spline_influences<const D: usize>(
    mesh: &Mesh<D>,
    samples: &[Sample<D>],
    stencil: &mut Stencil<D>,
) -> Result<(), OutsideMesh<D>> {
    let mut products: [Option<SplineProduct<D>>; CORNERS] = [None; CORNERS];
    let mut before = None;
    for (product, sample) in products.iter_mut().zip(samples) {
        *product = mesh.spline_product(&locate(mesh, &sample.position, &mut before)?);
    }
    let products = &mut products[..samples.len()];
    close_seam(mesh, products);
    let (mut low, mut high) = ([u32::MAX; D], [0; D]);
    for product in products.iter().flatten() {
        for d in 0..D {
            low[d] = low[d].min(product.first[d]);
            high[d] = high[d].max(product.first[d] + product.count[d] as u32);
        }
    }
    let extent: [u64; D] = from_fn(|d| u64::from(high[d].saturating_sub(low[d])));
    let corners = || products.iter().flatten().zip(samples);
    if extent.iter().product::<u64>() > TABLE {
        for (product, sample) in corners() {
            product.entries().for_each(|(node, n)| stencil.add(node, sample.weight * n, sample.gradient * n));
        }
    } else {
        add_table(mesh, low, extent.map(|n| n as usize), stencil);
        for (product, sample) in corners() {
            add_product(product, low, &extent.map(|n| n as usize), |at, n| {
                stencil.add_to(at, sample.weight * n, sample.gradient * n);
            });
        }
    }
    stencil.drop_zeros();
    Ok(())
}

/// Numbers the functions of corners on both sides of the seam of a ring on, so that neighbours have neighbouring indices.
fn close_seam<const D: usize>(mesh: &Mesh<D>, products: &mut [Option<SplineProduct<D>>]) {
    let (cells, periodic) = (mesh.lattice().cells(), mesh.lattice().periodic());
    for d in (0..D).filter(|&d| periodic[d]) {
        let firsts = || products.iter().flatten().map(|it| it.first[d]);
        if let (Some(low), Some(high)) = (firsts().min(), firsts().max())
            && high - low > cells[d] / 2
        {
            for product in products.iter_mut().flatten().filter(|it| it.first[d] < cells[d] / 2) {
                product.first[d] += cells[d];
            }
        }
    }
}

/// Adds the nodes from the index `low` on, each with no influence yet, the first direction fastest.
fn add_table<const D: usize>(mesh: &Mesh<D>, low: [u32; D], extent: [usize; D], stencil: &mut Stencil<D>) {
    for number in 0..extent.iter().product() {
        let mut rest = number;
        let index = from_fn(|d| {
            let along = rest % extent[d];
            rest /= extent[d];
            low[d] + along as u32
        });
        let node = mesh.control_point(index).expect("the functions of the mesh are splines");
        stencil.add(node, 0.0, Vector::zeros());
    }
}

/// Calls `add` with the place in a table of nodes from the index `low` on and the value of every function.
#[inline]
fn add_product<const D: usize>(
    product: &SplineProduct<D>,
    low: [u32; D],
    extent: &[usize; D],
    mut add: impl FnMut(usize, f64),
) {
    let from: [usize; D] = from_fn(|d| (product.first[d] - low[d]) as usize);
    // Directions that do not exist have one function, 1.
    let count = |d: usize| if d < D { product.count[d] } else { 1 };
    let value = |d: usize, k: usize| if d < D { product.values[d][k] } else { 1.0 };
    let at = |d: usize, k: usize| if d < D { from[d] + k } else { 0 };
    let width = |d: usize| if d < D { extent[d] } else { 1 };
    for k in 0..count(2) {
        for j in 0..count(1) {
            let (across, row) = (value(2, k) * value(1, j), (at(2, k) * width(1) + at(1, j)) * width(0));
            for i in 0..count(0) {
                add(row + at(0, i), across * value(0, i));
            }
        }
    }
}

/// Hands out the cells of the corners of a domain around `x`; a corner on a face counts for the cell on the domain's side.
///
/// # Errors
/// The first corner farther than half a cell outside the mesh.
pub(crate) fn cells<const D: usize>(
    mesh: &Mesh<D>,
    x: &Vector<D>,
    samples: &[Sample<D>],
    take: &mut dyn FnMut([u32; D]),
) -> Result<(), OutsideMesh<D>> {
    for sample in samples {
        take(mesh.locate(&(sample.position + (x - sample.position) * INWARDS), BEYOND)?.cell);
    }
    Ok(())
}

/// Moves corners with the displacement of the step: `x_c += Σ_v N_v(x_c) Δu_v`
/// (Sadeghirad, Brannon & Guilkey 2013).
///
/// # Errors
/// The first corner farther than half a cell outside the mesh at the start of the step.
pub(crate) fn convect<'a, const D: usize>(
    corners: impl IntoIterator<Item = &'a mut Vector<D>>,
    step: &Convection<'_, D>,
) -> Result<(), ConvectionError> {
    let mut before = None;
    // Mostly all corners share one cell: its displacements are looked up once.
    let (mut cell, mut increment) = (None, [Vector::zeros(); CORNERS]);
    for x in corners {
        let place = locate(step.mesh, x, &mut before).map_err(|it| ConvectionError::Outside(it.to_string()))?;
        if let Some(product) = step.mesh.spline_product(&place) {
            let moved: Vector<D> = product.entries().map(|(node, n)| step.at_node(node) * n).sum();
            *x += moved;
            continue;
        }
        let mut corner = 0;
        if cell != Some(place.cell) {
            step.mesh.values(&place, |node, _| {
                increment[corner] = step.at_node(node);
                corner += 1;
            });
            cell = Some(place.cell);
        }
        let mut u = Vector::zeros();
        corner = 0;
        step.mesh.values(&place, |_, n| {
            u += increment[corner] * n;
            corner += 1;
        });
        *x += u;
    }
    Ok(())
}

/// Signed volume of a domain over its initial one, which must be positive.
///
/// # Errors
/// The volume, where the domain has turned inside out or has none.
pub(crate) fn sound(volume: f64, initial: f64) -> Result<(), ConvectionError> {
    if volume / initial > 0.0 {
        Ok(())
    } else {
        Err(ConvectionError::Inverted { volume: volume * initial.signum() })
    }
}

/// What there is to say about a domain with these corners.
///
/// # Errors
/// The first corner farther than half a cell outside the mesh.
pub(crate) fn report<const D: usize>(
    mesh: &Mesh<D>,
    samples: &[Sample<D>],
    measure: f64,
    distortion: f64,
) -> Result<DomainReport, OutsideMesh<D>> {
    let mut report = DomainReport {
        measure,
        distortion,
        smallest_weight: samples.iter().fold(f64::INFINITY, |least, it| least.min(it.weight)),
        ..DomainReport::default()
    };
    let mut receiving: Vec<NodeId> = Vec::new();
    let mut before = None;
    for sample in samples {
        let place = locate(mesh, &sample.position, &mut before)?;
        report.corners_outside += usize::from(place.local.amax() > 1.0);
        mesh.values(&place, |node, n| {
            if n != 0.0 {
                receiving.push(node);
            }
        });
    }
    receiving.sort_unstable();
    report.single_corner_nodes = receiving.chunk_by(|a, b| a == b).filter(|corners| corners.len() == 1).count();
    Ok(report)
}
