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
use mpm_grid::{Mesh, NodeId, OutsideMesh, Place, Vector};

/// Corners of a domain at most.
const CORNERS: usize = 8;

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
    // Corners in a cell met before add to the entries that are there: mostly all share one cell.
    let mut cells = [[0; D]; CORNERS];
    let mut n_cells = 0;
    let mut before = None;
    for sample in samples {
        let place = locate(mesh, &sample.position, &mut before)?;
        let (w, g) = (sample.weight, sample.gradient);
        if let Some(met) = cells[..n_cells].iter().position(|cell| *cell == place.cell) {
            let mut at = met << D;
            mesh.values(&place, |_, n| {
                stencil.add_to(at, w * n, g * n);
                at += 1;
            });
        } else {
            cells[n_cells] = place.cell;
            n_cells += 1;
            mesh.values(&place, |node, n| stencil.add(node, w * n, g * n));
        }
    }
    stencil.drop_zeros();
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
