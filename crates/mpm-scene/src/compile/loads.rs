//! Loads and probes: which points of which body.

use super::names::{A_NAME, is_name};
use super::stages::Stages;
use crate::error::SceneError;
use crate::language::{ControlInput, Coordinates, Count, LoadInput, MaterialInput, ProbePointsInput, SceneIn};
use crate::places::{FaceShare, Place};
use crate::vortex::Vortex;
use mpm_assembly::Space;
use mpm_grid::{Mesh, Position, Ramp, Vector, six_digits};
use mpm_solver::{Loads, NamedBody, PointLoad, Probe, Share, Side, SideLoad};
use std::f64::consts::TAU;
use std::sync::Arc;

/// A torque on sides of rings, with the parts of it at their ends.
pub(super) struct Torque<const D: usize = 2> {
    pub body: usize,
    pub sides: Vec<Side<D>>,
    /// At full load `[F L]`.
    pub moment: f64,
    pub ramp: Ramp,
}

/// Forces, and torques about the axis of bodies of revolution.
pub(super) fn loads<const D: usize, B>(
    scene: &SceneIn<D, B>,
    (bodies, places): (&[NamedBody<D>], &[Vec<Place<D>>]),
    start: &Mesh<D>,
    faces: Vec<Vec<Vec<FaceShare<D>>>>,
) -> Result<(Loads<D>, Vec<Torque<D>>), SceneError> {
    let stages = Stages::of(&scene.schedule);
    let mut loads = Loads::default();
    let mut torques = Vec::new();
    let mut faces: Vec<_> = faces.into_iter().map(Vec::into_iter).collect();
    for (k, input) in scene.loads.iter().enumerate() {
        let path = format!("loads[{k}]");
        let find = |name: &str| body_named(bodies, name, &path);
        match input {
            LoadInput::BodyForce { acceleration, ramp, active } => {
                let ramp = stages.load_ramp(ramp, 1.0, active, &path)?;
                loads.body_forces.push((Vector::from(acceleration.0), ramp));
            }
            LoadInput::Vortex { body: name, angle, ramp, active } => {
                let body = find(name)?;
                if D != 2 {
                    return Err(SceneError::new(path, "a vortex needs a scene in the plane"));
                }
                let law = scene.materials.get(&scene.bodies[body].material);
                let angle = stages.load_ramp(ramp, angle.0.to_radians(), active, &path)?;
                let vortex = vortex(law, angle).map_err(|reason| SceneError::new(path, reason))?;
                loads.fields.push((body, Arc::new(vortex)));
            }
            LoadInput::PointForce { body: name, near, points, force, ramp, active } => {
                let body = find(name)?;
                let shares = point_shares((name, &places[body]), start, &Vector::from(near.0), *points, &path)?;
                let force = Vector::from(force.0);
                let ramp = stages.load_ramp(ramp, 1.0, active, &path)?;
                loads.point_loads.push(PointLoad { body, shares, force, ramp });
            }
            // On sides, see `sides.rs`.
            LoadInput::Traction { side: Some(_), .. } | LoadInput::Pressure { .. } => {}
            LoadInput::Traction { body: name, axis, at, resultant, value, moment, ramp, active, .. } => {
                // Refused with the faces of bodies.
                let (Some(axis), Some(at)) = (axis, at) else { continue };
                let body = find(name)?;
                let areas = faces[body].next().expect("one list of points per traction");
                if areas.is_empty() {
                    return Err(SceneError::new(
                        path,
                        format!("body `{name}` has no boundary on the loaded part of the plane at {}", at.0),
                    ));
                }
                let ramp = stages.load_ramp(ramp, 1.0, active, &path)?;
                let points_of = &places[body][..];
                if bodies[body].body.space().is_axisymmetric() {
                    refuse_split(scene, &path)?;
                    if let Some(moment) = moment {
                        let sides = torque_sides(points_of, axis.index(), &areas);
                        torques.push(Torque { body, sides, moment: moment.0, ramp: ramp.clone() });
                        if resultant.is_none() && value.is_none() {
                            continue;
                        }
                    }
                    let (sides, whole) = sides(points_of, axis.index(), &areas);
                    let force = whole_force(resultant, value, whole, &path)?;
                    loads.side_loads.push(SideLoad { body, sides, force, ramp });
                    continue;
                }
                if moment.is_some() {
                    return Err(SceneError::new(format!("{path}.moment"), NO_MOMENT));
                }
                let whole: f64 = areas.iter().map(|share| share.area).sum();
                let share = |it: FaceShare<D>| Share { point: it.point, part: it.area / whole, arm: it.arm };
                let shares = areas.into_iter().map(share).collect();
                let force = whole_force(resultant, value, whole, &path)?;
                loads.point_loads.push(PointLoad { body, shares, force, ramp });
            }
        }
    }
    Ok((loads, torques))
}

/// The points of a body that carry a force at `near` `[L]`.
fn point_shares<const D: usize>(
    (name, places): (&str, &[Place<D>]),
    start: &Mesh<D>,
    near: &Vector<D>,
    points: Option<Count>,
    path: &str,
) -> Result<Vec<Share<D>>, SceneError> {
    let nearest = nearest(places, near, points.map_or(1, |points| points.0 as usize))
        .map_err(|it| SceneError::new(format!("{path}.points"), it))?;
    check_hit(name, &places[nearest[0]], start, near)
        .map_err(|it| SceneError::new(format!("{path}.near"), it))?;
    let arm = if points.is_some() { Vector::zeros() } else { arm(places, &nearest, near) };
    Ok(equal_shares(nearest, arm))
}

pub(super) fn body_named<const D: usize>(
    bodies: &[NamedBody<D>],
    name: &str,
    path: &str,
) -> Result<usize, SceneError> {
    bodies.iter().position(|named| named.name == name).ok_or_else(|| {
        let known: Vec<&str> = bodies.iter().map(|named| named.name.as_str()).collect();
        SceneError::new(
            format!("{path}.body"),
            format!("no body named `{name}`; the scene has: {}", known.join(", ")),
        )
    })
}

/// What a moment of a traction needs.
pub(super) const NO_MOMENT: &str =
    "acts about the axis of bodies of revolution, which need `twist: true` to turn";

/// The force of a traction on an area.
pub(super) fn whole_force<const D: usize>(
    resultant: &Option<Coordinates<D>>,
    value: &Option<Coordinates<D>>,
    area: f64,
    path: &str,
) -> Result<Vector<D>, SceneError> {
    match (resultant, value) {
        (Some(resultant), None) => Ok(Vector::from(resultant.0)),
        (None, Some(value)) => Ok(Vector::from(value.0) * area),
        _ => {
            Err(SceneError::new(path, "expected either `resultant`, the whole force, or `value`, the traction"))
        }
    }
}

/// The sides of rings that lie on a plane across an axis, with the parts of a uniform traction at their ends, and the
/// area of all. The part of a side of length L at the end with the radius a is `2π L (a/3 + b/6)`, b the other's.
fn sides<const D: usize>(places: &[Place<D>], across: usize, shares: &[FaceShare<D>]) -> (Vec<Side<D>>, f64) {
    let (sides, whole) = weighed(places, across, shares, |a, b| a / 3.0 + b / 6.0);
    (sides, TAU * whole)
}

/// The same with the parts of the torque of a shear traction about the axis that grows with r: with a linear weight of the end,
/// `∫ w r³ ds = L (4a³ + 3a²b + 2ab² + b³)/20`.
fn torque_sides<const D: usize>(places: &[Place<D>], across: usize, shares: &[FaceShare<D>]) -> Vec<Side<D>> {
    let moment = |a: f64, b: f64| (4.0 * a * a * a + 3.0 * a * a * b + 2.0 * a * b * b + b * b * b) / 20.0;
    weighed(places, across, shares, moment).0
}

/// Sides, with parts at their ends in proportion to a weight by the radii of this end and of the other, per length; and the
/// sum of all weights.
fn weighed<const D: usize>(
    places: &[Place<D>],
    across: usize,
    shares: &[FaceShare<D>],
    weight: impl Fn(f64, f64) -> f64,
) -> (Vec<Side<D>>, f64) {
    let side = |it: &FaceShare<D>| {
        let mut half = Vector::zeros();
        half[1 - across] = 0.5 * it.area;
        let arms = [it.arm - half, it.arm + half];
        let [a, b] = arms.map(|arm| places[it.point].position[0] + arm[0]);
        Side { point: it.point, arms, parts: [weight(a, b), weight(b, a)].map(|weight| it.area * weight) }
    };
    let mut sides: Vec<Side<D>> = shares.iter().map(side).collect();
    let whole: f64 = sides.iter().flat_map(|side| side.parts).sum();
    sides.iter_mut().for_each(|side| side.parts = side.parts.map(|part| part / whole));
    (sides, whole)
}

/// Parts of points that are split do not know which of them have the side.
fn refuse_split<const D: usize, B>(scene: &SceneIn<D, B>, path: &str) -> Result<(), SceneError> {
    match scene.domains.control {
        Some(ControlInput::Split { .. }) => {
            let reason =
                "points are split by `domains.control`, and a traction on rings cannot follow their parts";
            Err(SceneError::new(path, reason))
        }
        _ => Ok(()),
    }
}

/// The vortex of a body under a law.
fn vortex(law: Option<&MaterialInput>, angle: Ramp) -> Result<Vortex, &'static str> {
    let Some(MaterialInput::Hencky { young, poisson, .. } | MaterialInput::NeoHooke { young, poisson, .. }) =
        law
    else {
        return Err("a vortex needs a body of `Hencky` or `NeoHooke` elasticity");
    };
    let young = young.number().ok_or("a vortex needs the same stiffness everywhere")?;
    let shear = young / (2.0 * (1.0 + poisson.0));
    Ok(match law {
        Some(MaterialInput::NeoHooke { .. }) => Vortex::of_rubber(shear, angle),
        _ => Vortex::new(shear, angle),
    })
}

pub(super) fn probes<const D: usize, B>(
    scene: &SceneIn<D, B>,
    (bodies, places): (&[NamedBody<D>], &[Vec<Place<D>>]),
    start: &Mesh<D>,
) -> Result<Vec<Probe<D>>, SceneError> {
    let mut probes: Vec<Probe<D>> = Vec::new();
    for (k, input) in scene.probes.iter().enumerate() {
        let path = format!("probes[{k}]");
        let name = &input.name;
        let is_taken = probes.iter().any(|other| other.name == *name);
        if !is_name(name) || is_taken {
            let reason = format!("expected {A_NAME}, got {name:?}");
            return Err(SceneError::new(format!("{path}.name"), reason));
        }
        if let Some(ControlInput::Split { .. }) = scene.domains.control {
            let reason = "points are split by `domains.control`, and a probe cannot follow their parts";
            return Err(SceneError::new(path, reason));
        }
        let Some(body) = bodies.iter().position(|named| named.name == input.body) else {
            let known: Vec<&str> = bodies.iter().map(|named| named.name.as_str()).collect();
            let reason = format!("no body named `{}`; the scene has: {}", input.body, known.join(", "));
            return Err(SceneError::new(format!("{path}.body"), reason));
        };
        let points = &places[body][..];
        let chosen: Vec<usize> = match &input.points {
            ProbePointsInput::All => (0..points.len()).collect(),
            ProbePointsInput::Near(at) => {
                let at = Vector::from(at.0);
                let found = nearest(points, &at, 1);
                let found = found.map_err(|it| SceneError::new(format!("{path}.points"), it))?;
                check_hit(&input.body, &points[found[0]], start, &at)
                    .map_err(|it| SceneError::new(format!("{path}.points"), it))?;
                found[..1].to_vec()
            }
            ProbePointsInput::Within { from, to } => {
                let inside = |x: &Vector<D>| (0..D).all(|d| (from.0[d]..=to.0[d]).contains(&x[d]));
                (0..points.len()).filter(|&point| inside(&points[point].position)).collect()
            }
        };
        if chosen.is_empty() {
            let reason = format!("holds no material point of body `{}`", input.body);
            return Err(SceneError::new(format!("{path}.points"), reason));
        }
        let rest = mean(points, &chosen, bodies[body].body.space());
        probes.push(Probe { name: name.clone(), body, points: chosen, rest });
    }
    Ok(probes)
}

/// Mean position of some points, weighted by their volumes `[L]`.
fn mean<const D: usize>(places: &[Place<D>], points: &[usize], space: Space) -> Vector<D> {
    let (mut sum, mut volume) = (Vector::zeros(), 0.0);
    for place in points.iter().map(|&point| &places[point]) {
        sum += place.position * place.volume(space);
        volume += place.volume(space);
    }
    sum / volume
}

/// Refuses a position that lies farther from a body than a cell is long: `point` is the body's nearest.
fn check_hit<const D: usize>(
    name: &str,
    point: &Place<D>,
    start: &Mesh<D>,
    at: &Vector<D>,
) -> Result<(), String> {
    let distance = length(&(point.position - at));
    let around = start.locate(&point.position, 0.5).map(|place| {
        let corners = [-1.0, 1.0].map(Vector::repeat);
        let cell = start.piece(place.cell, &corners[0], &corners[1]);
        let corners = &cell.corners()[..1 << D];
        corners.iter().map(|corner| (corner - corners[0]).norm()).fold(0.0, f64::max)
    });
    let own = 2.0 * point.size.powf(1.0 / D as f64);
    // Not a number where the position is none.
    if distance <= around.unwrap_or(0.0).max(own) {
        return Ok(());
    }
    Err(format!(
        "the nearest material point of body `{name}`, at {}, is {} away",
        Position(&point.position),
        six_digits(distance)
    ))
}

/// From the middle of some points to a position; 0 where only rounding parts them.
fn arm<const D: usize>(places: &[Place<D>], points: &[usize], at: &Vector<D>) -> Vector<D> {
    let sum: Vector<D> = points.iter().map(|&point| places[point].position).sum();
    let arm = at - sum / points.len() as f64;
    let size = places[points[0]].size.powf(1.0 / D as f64);
    if arm.norm() > 1e-9 * size { arm } else { Vector::zeros() }
}

/// Equal parts of a force, each at `arm` from one of some points; ascending.
fn equal_shares<const D: usize>(mut points: Vec<usize>, arm: Vector<D>) -> Vec<Share<D>> {
    points.sort_unstable();
    let part = 1.0 / points.len() as f64;
    points.into_iter().map(|point| Share { point, part, arm }).collect()
}

/// Length of a vector, whose square may overflow `[L]`.
fn length<const D: usize>(x: &Vector<D>) -> f64 {
    let largest = x.amax();
    if largest > 0.0 { largest * (x / largest).norm() } else { 0.0 }
}

/// The `count` points nearest to `x`, nearest first, and those that are as near as the last of them.
fn nearest<const D: usize>(places: &[Place<D>], x: &Vector<D>, count: usize) -> Result<Vec<usize>, String> {
    if count > places.len() {
        return Err(format!("the body has only {} material points", places.len()));
    }
    // Distances that differ by rounding alone count as equal.
    let mut distances: Vec<(f64, usize)> =
        places.iter().enumerate().map(|(p, it)| (length(&((it.position - x) * 0.25)), p)).collect();
    let scale = distances.iter().map(|(distance, _)| *distance).fold(0.0, f64::max);
    for (distance, _) in &mut distances {
        *distance = (*distance / scale.max(f64::MIN_POSITIVE) * 1e9).round();
    }
    distances.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let farthest = distances[count - 1].0;
    let chosen = distances.iter().take_while(|(distance, _)| *distance <= farthest);
    Ok(chosen.map(|&(_, point)| point).collect())
}
