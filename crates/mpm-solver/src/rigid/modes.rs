//! Rigid motions of the parts that supports leave free.

use super::null_space::{Triangle, reduce};
use super::parts::RigidParts;
use crate::ranks::Ranks;
use mpm_grid::Vector;
use std::collections::{BTreeMap, BTreeSet};

/// Singular value of the supports' conditions on a motion below which they do not hold it; a motion of size 1 moves the
/// part's outermost node by 1.
const FREE: f64 = 1e-9;

/// Parts of an assembly that are hinged to each other one by one; more are taken as one.
const MOST_PARTS: usize = 40;

/// Numbers of a rigid motion: rotation, then translation, so that motions are written by their rotations first.
const ROTATIONS: usize = 3;

/// A rigid motion, small: `t + ω × (x - c)` with c the centre of the part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Motion {
    /// ω, per length; in the plane its third component alone.
    pub rotation: [f64; 3],
    /// t.
    pub translation: [f64; 3],
}

impl Motion {
    const REST: Self = Self { rotation: [0.0; 3], translation: [0.0; 3] };

    /// Displacement at a place from the centre.
    fn at<const D: usize>(&self, arm: &Vector<D>) -> Vector<D> {
        let x: [f64; 3] = std::array::from_fn(|i| if i < D { arm[i] } else { 0.0 });
        let turned = cross(self.rotation, x);
        Vector::from_fn(|i, _| self.translation[i] + turned[i])
    }
}

/// The vector product.
pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// A motion that strains no point: of each part that takes part in it.
pub(crate) type Mode = BTreeMap<usize, Motion>;

/// Whether a mode turns any part.
pub(crate) fn turns(mode: &Mode) -> bool {
    mode.values().any(|motion| motion.rotation != [0.0; 3])
}

/// The parts and their places, by which motions are numbers.
pub(crate) struct Frames<'a, const D: usize> {
    pub parts: &'a RigidParts<D>,
    /// Of the active nodes of this rank.
    pub positions: &'a [Vector<D>],
    ranks: &'a dyn Ranks<D>,
    /// Centre and size of every part `[L]`.
    frames: Vec<(Vector<D>, f64)>,
}

impl<'a, const D: usize> Frames<'a, D> {
    pub(crate) fn of(parts: &'a RigidParts<D>, positions: &'a [Vector<D>], ranks: &'a dyn Ranks<D>) -> Self {
        let inner = |part: usize| parts.inner(part).iter().map(|&node| positions[node as usize]);
        let joints = |part: usize| parts.joints(part).map(|(_, joint)| joint.position);
        let sum = |places: &mut dyn Iterator<Item = Vector<D>>| {
            places.fold((0.0, Vector::zeros()), |(n, sum), x| (n + 1.0, sum + x))
        };
        let mut sums = Vec::with_capacity(parts.len() * (D + 1));
        for part in 0..parts.len() {
            let (n, sum) = sum(&mut inner(part));
            sums.push(n);
            sums.extend(sum.iter());
        }
        ranks.sum(&mut sums);
        let centre = |(part, sums): (usize, &[f64])| {
            let (n, joints) = sum(&mut joints(part));
            (Vector::from_fn(|i, _| sums[1 + i]) + joints) / (sums[0] + n)
        };
        let centres: Vec<Vector<D>> = sums.chunks_exact(D + 1).enumerate().map(centre).collect();
        let farthest = |part: usize| {
            inner(part).chain(joints(part)).map(|x| (x - centres[part]).norm()).fold(0.0, f64::max)
        };
        let mut sizes: Vec<f64> = (0..parts.len()).map(|part| -farthest(part)).collect();
        ranks.least(&mut sizes);
        let frames = centres.iter().zip(sizes);
        let frames = frames.map(|(&centre, size)| (centre, if size < 0.0 { -size } else { 1.0 })).collect();
        Self { parts, positions, ranks, frames }
    }

    /// Centre of a part `[L]`.
    pub(crate) fn centre(&self, part: usize) -> Vector<D> {
        self.frames[part].0
    }

    /// Distance of a part's outermost node from its centre `[L]`.
    pub(crate) fn size(&self, part: usize) -> f64 {
        self.frames[part].1
    }

    /// The motion of size 1 in one of a part's numbers.
    fn unit(&self, part: usize, number: usize) -> Motion {
        let mut unit = Motion::REST;
        match number.checked_sub(rotations::<D>()) {
            None => unit.rotation[ROTATIONS - rotations::<D>() + number] = 1.0 / self.frames[part].1,
            Some(component) => unit.translation[component] = 1.0,
        }
        unit
    }

    /// Displacement at a place in a part's motion.
    fn displacement(&self, part: usize, motion: &Motion, place: Vector<D>) -> Vector<D> {
        motion.at(&(place - self.frames[part].0))
    }

    /// Displacement of the nodes of this rank in a mode; 0 for all others.
    pub(crate) fn field(&self, mode: &Mode) -> Vec<Vector<D>> {
        let mut field = vec![Vector::zeros(); self.positions.len()];
        for (&part, motion) in mode {
            let inner = self.parts.inner(part).iter().copied();
            for node in inner.chain(self.parts.joints(part).filter_map(|(_, joint)| joint.here)) {
                field[node as usize] = self.displacement(part, motion, self.positions[node as usize]);
            }
        }
        field
    }

    /// Whether each of some modes moves any node of any rank.
    fn are_motions(&self, modes: &[Mode]) -> Vec<bool> {
        let moves = |mode: &Mode| self.field(mode).iter().any(|u| u.amax() > FREE);
        let mut moving: Vec<f64> = modes.iter().map(|mode| f64::from(u8::from(moves(mode)))).collect();
        self.ranks.sum(&mut moving);
        moving.into_iter().map(|ranks| ranks > 0.0).collect()
    }

    /// Motions of the assembly of these parts that move no node that is held; `is_held` tells of the active nodes of this rank, in
    /// which components.
    pub(crate) fn free(&self, parts: &[usize], is_held: impl Fn(usize, usize) -> bool) -> Vec<Mode> {
        let per_part = rotations::<D>() + D;
        let as_one = parts.len() > MOST_PARTS;
        // All parts as one: their frame is that of the first.
        let columns = if as_one { per_part } else { parts.len() * per_part };
        let frame = |k: usize| if as_one { (parts[0], 0) } else { (parts[k], k * per_part) };
        let mut triangle = Triangle::new(columns);
        let (mut rows, mut look) = (0, 4 * columns);
        'nodes: for (k, &part) in parts.iter().enumerate() {
            let (frame, first) = frame(k);
            for &node in self.parts.inner(part) {
                for component in (0..D).filter(|&i| is_held(node as usize, i)) {
                    let mut row = vec![0.0; columns];
                    let place = self.positions[node as usize];
                    self.write(frame, place, component, &mut row[first..first + per_part]);
                    triangle.add(&mut row);
                    rows += 1;
                }
                // One part alone is mostly held by a few nodes.
                if columns == per_part && rows >= look {
                    if triangle.null_space(FREE).is_empty() {
                        break 'nodes;
                    }
                    look *= 2;
                }
            }
        }
        // All ranks know the joints.
        if self.ranks.leads() {
            self.add_joints(parts, frame, &mut triangle);
        }
        let triangle = self.of_all(triangle);
        let null = triangle.null_space(FREE);
        let modes = null.iter().map(|vector| {
            let at = |k: usize| if as_one { 0 } else { k * per_part };
            let moved = |(k, &part): (usize, &usize)| {
                let frame = if as_one { parts[0] } else { part };
                let numbers = &vector[at(k)..at(k) + per_part];
                let motion = self.motion(frame, numbers);
                // About the part's own centre.
                let translation = motion.at(&(self.centre(part) - self.centre(frame)));
                let translation = std::array::from_fn(|i| if i < D { translation[i] } else { 0.0 });
                (part, Motion { translation, ..motion })
            };
            parts.iter().enumerate().map(moved).collect::<Mode>()
        });
        let modes: Vec<Mode> = modes.collect();
        let are_motions = self.are_motions(&modes);
        modes.into_iter().zip(are_motions).filter(|it| it.1).map(|it| it.0).collect()
    }

    /// Adds that held joints stay, and that hinged parts move alike in their joints; `frame` tells a part's frame, and the first of its
    /// columns.
    fn add_joints(&self, parts: &[usize], frame: impl Fn(usize) -> (usize, usize), triangle: &mut Triangle) {
        let (per_part, columns) = (rotations::<D>() + D, triangle.n());
        let is_hinged = columns > per_part;
        let mut owner: BTreeMap<u32, usize> = BTreeMap::new();
        for (k, &part) in parts.iter().enumerate() {
            let (own, first) = frame(k);
            for (number, joint) in self.parts.joints(part) {
                let hinged = if is_hinged { owner.insert(number, k) } else { None };
                for component in 0..D {
                    let is_held = joint.is_held(component);
                    if !is_held && hinged.is_none() {
                        continue;
                    }
                    let mut row = vec![0.0; columns];
                    self.write(own, joint.position, component, &mut row[first..first + per_part]);
                    if let (Some(before), false) = (hinged, is_held) {
                        let (other, place) = frame(before);
                        let place = place..place + per_part;
                        self.write(other, joint.position, component, &mut row[place.clone()]);
                        row[place].iter_mut().for_each(|it| *it = -*it);
                    }
                    triangle.add(&mut row);
                }
            }
        }
    }

    /// The triangle of the rows of all ranks.
    pub(super) fn of_all(&self, own: Triangle) -> Triangle {
        if self.ranks.size() == 1 {
            return own;
        }
        let n = own.n();
        let mut all = Triangle::new(n);
        for row in self.ranks.gathered(own.into_numbers()).0.chunks_exact_mut(n.max(1)) {
            all.add(row);
        }
        all
    }

    /// What each of a part's numbers adds to a component of a node's displacement.
    fn write(&self, part: usize, place: Vector<D>, component: usize, row: &mut [f64]) {
        for (number, entry) in row.iter_mut().enumerate() {
            *entry = self.displacement(part, &self.unit(part, number), place)[component];
        }
    }

    fn motion(&self, part: usize, numbers: &[f64]) -> Motion {
        let mut motion = Motion::REST;
        for (number, value) in numbers.iter().enumerate() {
            let unit = self.unit(part, number);
            for i in 0..3 {
                motion.rotation[i] += value * unit.rotation[i];
                motion.translation[i] += value * unit.translation[i];
            }
        }
        motion
    }

    /// The combinations of modes with these coefficients, written by as few motions each as can be: rotations without
    /// the translations that are free themselves, then translations.
    pub(crate) fn combine(&self, modes: &[Mode], coefficients: &[Vec<f64>]) -> Vec<Mode> {
        let parts: BTreeSet<usize> = modes.iter().flat_map(|mode| mode.keys().copied()).collect();
        let parts: Vec<usize> = parts.into_iter().collect();
        let sum = |coefficients: &Vec<f64>| {
            let mut rotations = Vec::new();
            let mut translations = Vec::new();
            for part in &parts {
                let mut sum = Motion::REST;
                for (mode, c) in modes.iter().zip(coefficients) {
                    let Some(motion) = mode.get(part) else { continue };
                    for i in 0..3 {
                        sum.rotation[i] += c * motion.rotation[i] * self.frames[*part].1;
                        sum.translation[i] += c * motion.translation[i];
                    }
                }
                rotations.extend(sum.rotation);
                translations.extend(sum.translation);
            }
            rotations.extend(translations);
            rotations
        };
        let mut vectors: Vec<Vec<f64>> = coefficients.iter().map(sum).collect();
        reduce(&mut vectors, FREE);
        let mode = |vector: &Vec<f64>| {
            let three = |first: usize| [vector[first], vector[first + 1], vector[first + 2]];
            let motions = parts.iter().enumerate().map(|(k, &part)| {
                let rotation = three(3 * k).map(|it| it / self.frames[part].1);
                (part, Motion { rotation, translation: three(3 * (parts.len() + k)) })
            });
            motions.filter(|(_, motion)| *motion != Motion::REST).collect()
        };
        vectors.iter().map(mode).collect()
    }
}

/// Independent rotations in D dimensions.
fn rotations<const D: usize>() -> usize {
    if D == 3 { 3 } else { 1 }
}
