//! What scenes cannot have where the functions of the mesh are splines.

use crate::error::SceneError;
use crate::language::SceneIn;
use crate::pieces::{Shape, pieces_of_box};
use mpm_grid::{Axis, Layout, Mesh, NodeId, NodeKind, NodeSpace, Region};
use mpm_solver::NamedBody;

/// Refuses what does not go together with splines.
///
/// # Errors
/// What that is, with its path.
pub(super) fn check<const D: usize, B>(scene: &SceneIn<D, B>, mesh: &Mesh<D>) -> Result<(), SceneError> {
    if mesh.functions() == NodeKind::Vertices {
        return Ok(());
    }
    if let Some(k) = scene.bodies.iter().position(|body| body.mean_dilatation.is_some()) {
        let reason = "volume changes are averaged over cells of linear functions: with splines expected no \
                      `mean_dilatation`";
        return Err(SceneError::new(format!("bodies[{k}].mean_dilatation"), reason));
    }
    Ok(())
}

/// Refuses bodies without corners that tools could touch.
///
/// # Errors
/// The first such body.
pub(super) fn check_tools<const D: usize>(bodies: &[NamedBody<D>], mesh: &Mesh<D>) -> Result<(), SceneError> {
    for named in bodies.iter().filter(|named| named.body.n_points() > 0) {
        let mut corners = Vec::new();
        named.body.corners(mesh, 0, &mut corners).map_err(|it| SceneError::new("tools", it))?;
        if corners.is_empty() {
            let (name, basis) = (&named.name, named.body.basis());
            let reason = format!(
                "body `{name}` has no corners that a tool could touch: with splines expected a basis with domains, \
                 got {basis}"
            );
            return Err(SceneError::new("tools", reason));
        }
    }
    Ok(())
}

/// Refuses bodies with fewer columns of corners than splines along a direction, or as many along two: some of these would
/// have no stiffness. Strains of domains are means, which do not feel corners that move like the fields of a checkerboard.
///
/// # Errors
/// How many points there are, and have to be.
pub(super) fn check_rank<const D: usize>(
    mesh: &Mesh<D>,
    shape: &Shape<'_, D>,
    per_cell: u32,
    names: [&str; 3],
) -> Result<(), String> {
    let NodeKind::ControlPoints { degree } = mesh.functions() else { return Ok(()) };
    let closed = mesh.lattice().periodic();
    let (cells, pieces): ([f64; D], [f64; D]) = match (shape, mesh.rectilinear()) {
        (Shape::Box { from, to }, Some(axes)) => {
            let cells = std::array::from_fn(|d| {
                let ((first, local), last) = (axes[d].locate(from[d]), axes[d].locate(to[d]).0);
                let first = if local >= 1.0 { first + 1 } else { first };
                f64::from(last) + 1.0 - f64::from(first)
            });
            (cells, pieces_of_box(mesh, (from, to), per_cell, names)?)
        }
        (Shape::Cells { low, high, .. }, None) => {
            let cells: [f64; D] = std::array::from_fn(|d| f64::from(high[d] - low[d]));
            (cells, cells.map(|n| n * f64::from(per_cell)))
        }
        _ => return Ok(()),
    };
    let mut even = Vec::new();
    for d in (0..D).filter(|&d| !closed[d]) {
        let splines = cells[d] + f64::from(degree);
        if pieces[d] + 1.0 < splines {
            return Err(format!(
                "along direction {} of the mesh the body has {} points, and their domains {} columns of corners for \
                 {splines} splines of degree {degree}: some splines would have no stiffness, expected at least {} \
                 points there",
                d + 1,
                pieces[d],
                pieces[d] + 1.0,
                splines - 1.0
            ));
        }
        if pieces[d] + 1.0 == splines {
            even.push(d + 1);
        }
    }
    match even[..] {
        [first, second, ..] => Err(format!(
            "along directions {first} and {second} of the mesh the body has as many columns of corners as splines, so \
             that displacements like the fields of a checkerboard would have no stiffness: expected more points"
        )),
        _ => Ok(()),
    }
}

/// Refuses nodes of splines that are no places of a body.
///
/// # Errors
/// Where nodes may be.
pub(super) fn check_region<const D: usize>(
    region: &Region<D>,
    nodes: &[NodeId],
    (layout, space): (&Layout<D>, &NodeSpace<D>),
) -> Result<(), String> {
    if space.kind() == NodeKind::Vertices {
        return Ok(());
    }
    let (last, closed) = (space.lattice().nodes().map(|n| n - 1), space.lattice().periodic());
    let is_corner = |node: NodeId| {
        let index = space.lattice().node_index(node);
        (0..D).all(|d| !closed[d] && (index[d] == 0 || index[d] == last[d]))
    };
    // A single control point within a face is no place, either: its neighbours count there.
    let is_point = matches!(region, Region::Point(_));
    if nodes.iter().all(|&node| space.interpolates_at(node) && (!is_point || is_corner(node))) {
        return Ok(());
    }
    Err(off_faces(layout))
}

/// Where nodes of splines can be held.
pub(super) fn off_faces<const D: usize>(layout: &Layout<D>) -> String {
    let ends = |what: &str, axis: &Axis| format!("{what} = {} and {}", axis.first(), axis.last());
    let faces: Vec<String> = match layout {
        Layout::Box { axes, .. } => axes.iter().zip(["x", "y", "z"]).map(|(axis, it)| ends(it, axis)).collect(),
        Layout::Ring { radii, height, .. } => {
            std::iter::once(ends("radius", radii)).chain(height.iter().map(|axis| ends("z", axis))).collect()
        }
    };
    format!(
        "splines have their nodes at control points, which are places of a body on faces of the mesh only, single ones at \
         its corners: expected a region on a face, {}",
        faces.join(", ")
    )
}
