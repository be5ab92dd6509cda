//! Filling a shape with material points.

use crate::boundary::Boundary;
use crate::pieces::{MOST_POINTS, Pieces, Shape, box_piece, count_pieces};
use crate::places::{FaceShare, Place, Points, at, face_share};
use crate::seeding::{SeededPieces, Seeding};
use crate::share::ShareOfPoints;
use mpm_assembly::{
    Body, LawOfBody, MaterialBody, MeanDilatation, PointStart, RefusedStart, ShippedBasis, Space,
};
use mpm_basis::parallel::each_point;
use mpm_basis::{Basis, Seed};
use mpm_contact::{Pose, Tool};
use mpm_geometry::{Face, MemoryLimit, Part, Parts, parts, rest};
use mpm_grid::{Block, LinearCell, Mesh, Position, Vector};
use mpm_material::SymmetricTensor;

/// What a body is to be filled with.
pub(crate) struct Plan<'a, const D: usize> {
    /// The mesh of the first load step.
    pub start: &'a Mesh<D>,
    pub space: Space,
    pub shape: Shape<'a, D>,
    /// The mesh whose cells the shape is filled by: the background mesh, or the shape's own.
    pub shape_mesh: &'a Mesh<D>,
    /// Where the shape's pieces are moved to.
    pub pose: Option<Pose<D>>,
    /// Material points per cell and direction; of no use for points that are given.
    pub points_per_cell: u32,
    /// Whether a body force acts.
    pub needs_mass: bool,
    /// Whether positions at rest must be kept.
    pub keep_reference_positions: bool,
    /// Parts of the boundary that carry tractions.
    pub faces: Vec<Face<D>>,
    /// Whether loads or walls name sides of the body.
    pub needs_sides: bool,
    /// Memory that there is.
    pub memory: MemoryLimit,
    /// What the volume change of a cell is, where points take it.
    pub mean_dilatation: Option<MeanDilatation>,
    /// Points inside these are left out.
    pub tools: Vec<Tool<D>>,
    /// Which points are made.
    pub share: ShareOfPoints,
}

/// A body, and for every face of the plan the points next to it with their areas of it.
pub(crate) struct Filled<const D: usize> {
    pub body: Box<dyn Body<D>>,
    pub faces: Vec<Vec<FaceShare<D>>>,
    /// The sides of its pieces, where they are needed.
    pub boundary: Boundary<D>,
    /// The shape's own volume, where it is known `[L^D]`.
    pub shape_volume: Option<f64>,
    /// Mass over volume of all points, where it is known `[M/L^D]`.
    pub density: Option<f64>,
    /// The places of all points.
    pub places: Vec<Place<D>>,
    /// Numbers of the body's points among these, where it has not all.
    pub numbers: Option<Vec<u64>>,
}

/// Mass per reference volume `[M/L^D]`.
#[derive(Clone, Debug)]
pub(crate) enum Density {
    /// The same everywhere.
    Even(f64),
    /// Of every point.
    OfPoints(Vec<f64>),
}

/// Makes a body of points of one basis and law, which begin as `starts` say; with none of them, at rest and free of
/// stress. `density` is given where a body force acts.
///
/// # Errors
/// The point that its law does not let begin under its stress.
pub(crate) fn body<const D: usize, B: ShippedBasis<D>>(
    basis: B,
    law: LawOfBody<D>,
    seeded: Seeded<SeedOf<D, B>, D>,
    (starts, density): (&[PointStart], Option<&Density>),
    plan: &Plan<'_, D>,
) -> Result<Filled<D>, RefusedStart> {
    let Seeded { seeds, places, numbers, faces, boundary, shape_volume } = seeded;
    let shape_volume = plan.shape.volume().or(shape_volume);
    let shape_volume = match plan.space {
        Space::Cartesian => shape_volume,
        Space::Axisymmetric => None,
    };
    let mean = density.map(|density| match density {
        Density::Even(density) => *density,
        Density::OfPoints(densities) => {
            let volumes = || places.iter().map(|place| place.volume(plan.space));
            let volume: f64 = volumes().sum();
            let mass: f64 = volumes().zip(densities).map(|(volume, density)| density * volume).sum();
            mass / volume
        }
    });
    let own: Vec<_> = each_point(seeds.len(), &|k| (seeds[k].position, seeds[k].volume));
    let domains: Vec<_> = each_point(seeds.len(), &|k| seeds[k].domain.clone());
    drop(seeds);
    let body = MaterialBody::of(law, basis.domains_of_body(domains), own);
    let mut body = body.with_mean_dilatation(plan.mean_dilatation);
    if !starts.is_empty() {
        body = body.with_starts(starts)?;
    }
    match density.filter(|_| plan.needs_mass) {
        None => {}
        Some(Density::Even(density)) => body = body.with_density(*density),
        Some(Density::OfPoints(densities)) => {
            body = match &numbers {
                None => body.with_densities(densities),
                Some(numbers) => body.with_densities(&at(densities, numbers)),
            }
        }
    }
    if plan.keep_reference_positions {
        body = body.with_reference_positions();
    }
    Ok(Filled { body: Box::new(body), faces, boundary, shape_volume, density: mean, places, numbers })
}

/// A point of a basis at rest.
pub(crate) type SeedOf<const D: usize, B> = Seed<D, <B as Basis<D>>::Domain>;

/// The points of a body at rest; the rest as in [`Filled`].
pub(crate) struct Seeded<S, const D: usize> {
    seeds: Vec<S>,
    places: Vec<Place<D>>,
    /// Numbers of the seeds among the places, where they are not all.
    pub numbers: Option<Vec<u64>>,
    faces: Vec<Vec<FaceShare<D>>>,
    boundary: Boundary<D>,
    shape_volume: Option<f64>,
}

impl<const D: usize, Own> Seeded<Seed<D, Own>, D> {
    /// Positions at rest of all points.
    pub fn positions(&self) -> Vec<[f64; D]> {
        self.places.iter().map(|place| place.position.into()).collect()
    }
}

/// Places the points that fill a shape; the law remembers at least `history` bytes of each.
pub(crate) fn seeds<const D: usize, B: Basis<D>>(
    basis: &B,
    plan: &Plan<'_, D>,
    history: usize,
) -> Result<Seeded<SeedOf<D, B>, D>, String> {
    let bytes_per_point = bytes_of_point::<D, B>(history);
    basis.suits(plan.start)?;
    let made = made_parts(basis, plan)?;
    let pieces = match &made {
        Some(parts) => parts.parts.len() as f64,
        None => {
            let pieces_per_cell = basis.pieces_per_cell(plan.points_per_cell)?;
            count_pieces(plan.shape_mesh, &plan.shape, pieces_per_cell, plan.space.axes())?
        }
    };
    let mut points_per_piece = 0.0;
    basis.seed(&box_piece(&Vector::zeros(), &Vector::repeat(1.0)), &mut |_| points_per_piece += 1.0);
    let count = pieces * points_per_piece;
    if count > MOST_POINTS {
        return Err(format!(
            "{count:e} material points are more than the {MOST_POINTS:e} that a body can have"
        ));
    }
    check_room::<D>(plan, count, bytes_per_point)?;
    let flat = made.as_ref().and_then(flat_part);
    let seeded = match (&made, flat) {
        (_, Some(corner)) => Err(corner),
        (Some(parts), None) => {
            let mut faces = vec![Vec::new(); plan.faces.len()];
            let mut points = Points::of(plan.share, count, 0);
            seed_parts(basis, parts, &mut points, &mut faces);
            Ok(SeededPieces { points, faces, boundary: Boundary::default() })
        }
        (None, None) => {
            let cut = (basis.pieces_per_cell(plan.points_per_cell)?, plan.space.axes());
            let pieces = Pieces::of(plan.shape_mesh, &plan.shape, cut)?;
            let (pose, faces, needs_sides) = (plan.pose.as_ref(), &plan.faces[..], plan.needs_sides);
            Seeding { pieces, pose, faces, needs_sides, share: plan.share }.seed(basis, count)
        }
    };
    let SeededPieces { mut points, mut faces, boundary } = seeded.map_err(|corner| {
        let at = corner.as_slice();
        format!("the part of a cell at {at:?} that a point stands for has no volume that can be computed")
    })?;
    for shares in &mut faces {
        shares.sort_by_key(|share| share.point);
    }
    if let Shape::Cells { volume, is_exact: true, .. } = plan.shape {
        points.fill(volume);
    }
    points.leave_out(&plan.tools, &mut faces)?;
    let Points { seeds, places, numbers, .. } = points;
    if let Some(place) = places.iter().find(|it| plan.space.is_axisymmetric() && it.position[0] <= 0.0) {
        let at = Position(&place.position);
        return Err(format!("a material point at {at} stands at r ≤ 0, expected beside the axis, r > 0"));
    }
    let numbers = (!plan.share.is_all()).then_some(numbers);
    let shape_volume = made.and_then(|parts| parts.volume);
    Ok(Seeded { seeds, places, numbers, faces, boundary, shape_volume })
}

/// Where the first part stands that has no volume.
fn flat_part<const D: usize>(parts: &Parts<D>) -> Option<Vector<D>> {
    let is_solid = |part: &&Part<D>| {
        let sides = part.half_vectors.column_iter().map(|side| side.norm());
        let volumes = [part.volume, parallelepiped(part).volume()];
        sides.chain(volumes).all(|it| it > 0.0 && it.is_finite())
    };
    parts.parts.iter().find(|part| !is_solid(part)).map(|part| part.centre)
}

/// Refuses more points than there is memory for: those that are made here, and the places of all.
fn check_room<const D: usize>(plan: &Plan<'_, D>, count: f64, bytes_per_point: usize) -> Result<(), String> {
    if plan.share.is_all() {
        return plan.memory.check(format_args!("{count:e} material points"), count, bytes_per_point);
    }
    let (own, ranks) = (plan.share.range(count).len() as f64, plan.share.ranks);
    // The places of all, and their positions once more for what points begin with.
    let place = size_of::<Place<D>>() + size_of::<Vector<D>>();
    let places = (count / own.max(1.0) * place as f64) as usize;
    let what = format_args!("{own:e} of {count:e} material points on one of {ranks} ranks");
    plan.memory.check(what, own.max(1.0), bytes_per_point.saturating_add(places))
}

/// The parts of shapes that are not filled piece by piece.
fn made_parts<const D: usize, B: Basis<D>>(basis: &B, plan: &Plan<'_, D>) -> Result<Option<Parts<D>>, String> {
    let axes = || plan.shape_mesh.rectilinear().ok_or("a body of parts can only be filled in a box mesh");
    match &plan.shape {
        Shape::Box { .. } | Shape::Cells { .. } | Shape::Disc(_) => Ok(None),
        Shape::Solid { solid, open } => {
            let pieces = basis.pieces_per_cell(plan.points_per_cell)?;
            parts(solid, *open, axes()?, pieces, &plan.faces, plan.memory).map(Some)
        }
        Shape::Rest { from, to, without } => {
            if !plan.faces.is_empty() {
                return Err("a box without other bodies can carry no traction".into());
            }
            rest((from, to), without, axes()?, basis.pieces_per_cell(plan.points_per_cell)?, plan.memory)
                .map(Some)
        }
        Shape::Parts(parts) => Ok(Some(parts.clone())),
    }
}

/// Points of given parts, and those that carry faces.
fn seed_parts<const D: usize, B: Basis<D>>(
    basis: &B,
    parts: &Parts<D>,
    points: &mut Points<SeedOf<D, B>, D>,
    faces: &mut [Vec<FaceShare<D>>],
) {
    // Number of the first point of every part.
    let mut starts = Vec::with_capacity(parts.parts.len() + 1);
    let mut seeds: Vec<SeedOf<D, B>> = Vec::new();
    for part in &parts.parts {
        basis.seed(&parallelepiped(part), &mut |seed| seeds.push(seed));
        // A part may hold more or less than its domain.
        let seeded: f64 = seeds.iter().map(|seed| seed.volume).sum();
        seeds.iter_mut().for_each(|seed| seed.volume *= part.volume / seeded);
        starts.push(points.take(&mut seeds).start);
    }
    starts.push(points.places.len());
    for (shares, face) in faces.iter_mut().zip(&parts.faces) {
        for share in face {
            let of_part = starts[share.part]..starts[share.part + 1];
            shares.extend(face_share(&points.places, of_part, share.area, &share.centre));
        }
    }
}

fn parallelepiped<const D: usize>(part: &Part<D>) -> LinearCell<D> {
    LinearCell::new(std::array::from_fn(|corner| {
        let signs = Vector::from_fn(|d, _| if corner >> d & 1 == 1 { 1.0 } else { -1.0 });
        part.centre + part.half_vectors * signs
    }))
}

/// Bytes that a point takes at least: its state, the next one, and its influence on the nodes of a cell.
fn bytes_of_point<const D: usize, B: Basis<D>>(history: usize) -> usize {
    let state = size_of::<Vector<D>>()
        + size_of::<f64>()
        + size_of::<B::Domain>()
        + size_of::<Block<D>>()
        + size_of::<SymmetricTensor>()
        + history;
    2 * state + (size_of::<Vector<D>>() + size_of::<f64>()) * (1 << D)
}
