//! The mesh and how it moves.

use super::stages::Stages;
use crate::error::SceneError;
use crate::language::{
    AxisInput, Direction, FunctionsInput, MeshInput, MotionInput, PlanePoint, RampInput, ReindexingInput,
    StretchInput,
};
use mpm_assembly::Space;
use mpm_geometry::MemoryLimit;
use mpm_grid::{
    Axis, DrivenPlane, LatticeError, Layout, LayoutError, MeshMotion, MotionError, Ramp, Reindexing, Span,
};
use mpm_solver::Active;

pub(super) fn layout<const D: usize>(mesh: &MeshInput, memory: MemoryLimit) -> Result<Layout<D>, SceneError> {
    let layout = cells(mesh, memory)?;
    let (MeshInput::Box { functions, .. } | MeshInput::Ring { functions, .. }) = mesh;
    match functions {
        FunctionsInput::Linear => Ok(layout),
        FunctionsInput::Splines { degree } => {
            layout.with_splines(degree.0).map_err(|it| SceneError::new("mesh.functions", it))
        }
    }
}

fn cells<const D: usize>(mesh: &MeshInput, memory: MemoryLimit) -> Result<Layout<D>, SceneError> {
    let axes = match mesh {
        MeshInput::Box { axes, .. } => axes,
        MeshInput::Ring { centre, radii, sectors, angles, height, .. } => {
            let radii = axis(radii, memory).map_err(|it| SceneError::new("mesh.radii", it))?;
            let height = height.as_ref().map(|it| axis(it, memory)).transpose();
            let height = height.map_err(|it| SceneError::new("mesh.height", it))?;
            let span = angles.map_or(Span::Full, |(from, to)| Span::Sector {
                from: from.0.to_radians(),
                to: to.0.to_radians(),
            });
            check_ring(&radii, sectors.0, memory).map_err(|it| SceneError::new("mesh", it))?;
            let ring = Layout::ring(plane_point(centre), radii, sectors.0, span, height);
            return ring.map_err(|it| match it {
                LayoutError::Lattice(LatticeError::TooFewCells { direction: 0, cells, least }) => {
                    let reason = format!("expected at least {least} cells around a full ring, got {cells}");
                    SceneError::new("mesh.sectors", reason)
                }
                it => SceneError::new("mesh", it),
            });
        }
    };
    let made: Vec<Axis> = axes
        .iter()
        .enumerate()
        .map(|(d, input)| axis(input, memory).map_err(|it| SceneError::new(format!("mesh.axes[{d}]"), it)))
        .collect::<Result<_, _>>()?;
    let made: [Axis; D] = made.try_into().map_err(|made: Vec<Axis>| {
        SceneError::new("mesh.axes", format!("expected {D} axes, one per dimension, got {}", made.len()))
    })?;
    Layout::on_axes(made).map_err(|it| SceneError::new("mesh", it))
}

fn axis(input: &AxisInput, memory: MemoryLimit) -> Result<Axis, String> {
    match input {
        AxisInput::Uniform { from, to, cells } => Axis::uniform(from.0, to.0, cells.0),
        AxisInput::Graded { from, to, cells, ratio } => {
            memory.check("the axis", f64::from(cells.0) + 1.0, size_of::<f64>())?;
            Axis::geometric(from.0, to.0, cells.0, ratio.0)
        }
        AxisInput::Nodes(nodes) => Axis::graded(nodes.iter().map(|x| x.0).collect()),
    }
    .map_err(|it| it.to_string())
}

/// A ring mesh has tables of its angles.
pub(super) fn check_ring(radii: &Axis, sectors: u32, memory: MemoryLimit) -> Result<(), String> {
    memory.check("the ring", f64::from(sectors) + f64::from(radii.cells()), 3 * size_of::<f64>())
}

pub(super) fn plane_point(point: &PlanePoint) -> [f64; 2] {
    let PlanePoint((x, y)) = point;
    [x.0, y.0]
}

pub(super) fn component<const D: usize>(direction: Direction, path: &str) -> Result<usize, SceneError> {
    let index = direction.index();
    if direction == Direction::R {
        return Err(SceneError::new(path, "R is a direction of `Axisymmetric` scenes only"));
    }
    if direction == Direction::Theta {
        return Err(SceneError::new(
            path,
            "Theta is a direction of `Axisymmetric` scenes with `twist: true` only",
        ));
    }
    if index < D {
        return Ok(index);
    }
    Err(SceneError::new(path, format!("{direction:?} is not a direction of a scene in {D} dimensions")))
}

/// An even axis that is stretched in part is one no more: its nodes are listed.
fn check_stretch(axis: &Axis, (anchor, driven): (f64, f64), memory: MemoryLimit) -> Result<(), String> {
    if anchor.min(driven) <= axis.first() && anchor.max(driven) >= axis.last() {
        return Ok(());
    }
    memory.check("the axis that is stretched in part", f64::from(axis.cells()) + 1.0, size_of::<f64>())
}

pub(super) fn motion<const D: usize>(
    input: &MotionInput<D>,
    stages: Stages<'_>,
    (layout, space): (&Layout<D>, Space),
    memory: MemoryLimit,
) -> Result<MeshMotion<D>, SceneError> {
    let ramp = |input: &RampInput, scale: f64, path: &str| stages.ramp(input, scale, Active::default(), path);
    match input {
        MotionInput::Fixed => Ok(MeshMotion::Fixed),
        MotionInput::Stretch(stretches) => {
            let mut planes = [const { None }; D];
            for (k, stretch) in stretches.iter().enumerate() {
                let path = format!("motion[{k}]");
                let axis = component::<D>(stretch.axis, &format!("{path}.axis"))?;
                if planes[axis].is_some() {
                    let name = space.directions()[axis];
                    return Err(SceneError::new(path, format!("axis {name} is stretched twice")));
                }
                if let Layout::Box { axes, .. } = layout {
                    check_stretch(&axes[axis], (stretch.anchor.0, stretch.driven.0), memory)
                        .map_err(|it| SceneError::new(&path, it))?;
                }
                planes[axis] = Some(driven_plane(stretch, stages, &path)?);
            }
            MeshMotion::stretch(planes).map_err(|it| SceneError::new("motion", told(&it, space)))
        }
        MotionInput::Corners(moved) => {
            let mut path: Vec<[Ramp; D]> = vec![std::array::from_fn(|_| Ramp::constant(0.0)); 1 << D];
            let mut given = vec![false; 1 << D];
            for (k, input) in moved.iter().enumerate() {
                let at = format!("motion[{k}]");
                let corner = box_corner(layout, &input.corner.0)
                    .map_err(|reason| SceneError::new(format!("{at}.corner"), reason))?;
                if std::mem::replace(&mut given[corner], true) {
                    return Err(SceneError::new(at, "this corner is moved twice"));
                }
                for (ramp_of, displacement) in path[corner].iter_mut().zip(input.displacement.0) {
                    *ramp_of = ramp(&input.ramp, displacement, &format!("{at}.ramp"))?;
                }
            }
            MeshMotion::corners(path).map_err(|it| SceneError::new("motion", it))
        }
        MotionInput::Rotate { centre, angle, ramp: input } => {
            let angle = ramp(input, angle.0.to_radians(), "motion.ramp")?;
            MeshMotion::rotate(plane_point(centre), angle).map_err(|it| SceneError::new("motion", it))
        }
        MotionInput::Twist { inner, outer, ramp: input, outer_ramp, reindexing, stretch } => {
            let Layout::Ring { centre, radii, .. } = layout else {
                return Err(SceneError::new("motion", "a twist needs a ring mesh"));
            };
            let inner = ramp(input, inner.0.to_radians(), "motion.ramp")?;
            let outer = match outer_ramp {
                None => ramp(input, outer.0.to_radians(), "motion.ramp")?,
                Some(input) => ramp(input, outer.0.to_radians(), "motion.outer_ramp")?,
            };
            let reindexing = match reindexing {
                ReindexingInput::WholeCells => Reindexing::WholeCells,
                ReindexingInput::Neighbours => Reindexing::Neighbours,
                ReindexingInput::Off => Reindexing::Off,
            };
            let (inner, outer) = ((radii.first(), inner), (radii.last(), outer));
            let twist = MeshMotion::twist(*centre, inner, outer, reindexing)
                .map_err(|it| SceneError::new("motion", it))?;
            let Some(stretch) = stretch else { return Ok(twist) };
            stretched(twist, stretch, stages, layout, memory)
        }
        MotionInput::Expand { anchor, driven, displacement, ramp: input } => {
            let Layout::Ring { radii, .. } = layout else {
                return Err(SceneError::new("motion", "an expansion needs a ring mesh"));
            };
            check_stretch(radii, (anchor.0, driven.0), memory).map_err(|it| SceneError::new("motion", it))?;
            let displacement = ramp(input, displacement.0, "motion.ramp")?;
            MeshMotion::expand(DrivenPlane { anchor: anchor.0, driven: driven.0, displacement })
                .map_err(|it| SceneError::new("motion", it))
        }
    }
}

/// What is wrong with planes that are driven, by the names of the directions in a space.
fn told(error: &MotionError, space: Space) -> String {
    let sentence = error.to_string();
    match *error {
        MotionError::CoincidentPlanes { axis } | MotionError::ThroughAnchor { axis, .. } => {
            let named = |space: Space| format!("the axis {} ", space.directions()[axis]);
            sentence.replace(&named(Space::Cartesian), &named(space))
        }
        _ => sentence,
    }
}

fn driven_plane(stretch: &StretchInput, stages: Stages<'_>, path: &str) -> Result<DrivenPlane, SceneError> {
    let (by, path) = (stretch.displacement.0, format!("{path}.ramp"));
    let displacement = stages.ramp(&stretch.ramp, by, Active::default(), &path)?;
    Ok(DrivenPlane { anchor: stretch.anchor.0, driven: stretch.driven.0, displacement })
}

/// The twist composed with a stretch along its axis.
fn stretched<const D: usize>(
    twist: MeshMotion<D>,
    stretch: &StretchInput,
    stages: Stages<'_>,
    layout: &Layout<D>,
    memory: MemoryLimit,
) -> Result<MeshMotion<D>, SceneError> {
    let path = "motion.stretch";
    let axis = component::<D>(stretch.axis, "motion.stretch.axis")?;
    if axis != 2 {
        let reason = format!("a twist is stretched along its axis: expected Z, got {:?}", stretch.axis);
        return Err(SceneError::new("motion.stretch.axis", reason));
    }
    if let Layout::Ring { height: Some(height), .. } = layout {
        let planes = (stretch.anchor.0, stretch.driven.0);
        check_stretch(height, planes, memory).map_err(|it| SceneError::new(path, it))?;
    }
    twist.stretched_along_axis(driven_plane(stretch, stages, path)?).map_err(|it| SceneError::new(path, it))
}

/// Number of the corner of a box layout that stands at `x`.
fn box_corner<const D: usize>(layout: &Layout<D>, x: &[f64; D]) -> Result<usize, String> {
    let Layout::Box { axes, .. } = layout else { return Err("only a box has corners".into()) };
    let mut corner = 0;
    for (d, axis) in axes.iter().enumerate() {
        let near = 1e-9 * (axis.last() - axis.first());
        if (x[d] - axis.last()).abs() <= near {
            corner |= 1 << d;
        } else if (x[d] - axis.first()).abs() > near {
            return Err(format!("expected a corner of the mesh's box at rest, got {x:?}"));
        }
    }
    Ok(corner)
}
