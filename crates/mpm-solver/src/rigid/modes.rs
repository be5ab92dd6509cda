//! Rigid motions of the parts that supports leave free.

use super::null_space::{Triangle, reduce};
use super::parts::RigidParts;
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
    pub parts: &'a RigidParts,
    pub positions: &'a [Vector<D>],
    /// Centre and size of every part `[L]`.
    frames: Vec<(Vector<D>, f64)>,
}

impl<'a, const D: usize> Frames<'a, D> {
    pub(crate) fn of(parts: &'a RigidParts, positions: &'a [Vector<D>]) -> Self {
        let frame = |part: usize| {
            let nodes = || parts.nodes(part).iter().map(|&node| positions[node as usize]);
            let n = nodes().count() as f64;
            let centre = nodes().fold(Vector::zeros(), |sum: Vector<D>, x| sum + x) / n;
            let size = nodes().map(|x| (x - centre).norm()).fold(0.0, f64::max);
            (centre, if size > 0.0 { size } else { 1.0 })
        };
        Self { parts, positions, frames: (0..parts.len()).map(frame).collect() }
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

    /// Displacement of a node in a part's motion.
    fn displacement(&self, part: usize, motion: &Motion, node: u32) -> Vector<D> {
        motion.at(&(self.positions[node as usize] - self.frames[part].0))
    }

    /// Displacement of the nodes in a mode; 0 for all others.
    pub(crate) fn field(&self, mode: &Mode) -> Vec<Vector<D>> {
        let mut field = vec![Vector::zeros(); self.positions.len()];
        for (&part, motion) in mode {
            for &node in self.parts.nodes(part) {
                field[node as usize] = self.displacement(part, motion, node);
            }
        }
        field
    }

    /// Motions of the assembly of these parts that move no node that is held, in the components that `is_held` tells.
    pub(crate) fn free(&self, parts: &[usize], is_held: impl Fn(usize, usize) -> bool) -> Vec<Mode> {
        let per_part = rotations::<D>() + D;
        let as_one = parts.len() > MOST_PARTS;
        // All parts as one: their frame is that of the first.
        let columns = if as_one { per_part } else { parts.len() * per_part };
        let mut owner: BTreeMap<u32, usize> = BTreeMap::new();
        let mut triangle = Triangle::new(columns);
        let (mut rows, mut look) = (0, 4 * columns);
        for (k, &part) in parts.iter().enumerate() {
            let (frame, first) = if as_one { (parts[0], 0) } else { (part, k * per_part) };
            for &node in self.parts.nodes(part) {
                let hinged = if as_one || parts.len() == 1 { None } else { owner.insert(node, k) };
                for component in 0..D {
                    let is_held = is_held(node as usize, component);
                    if !is_held && hinged.is_none() {
                        continue;
                    }
                    let mut row = vec![0.0; columns];
                    self.write(frame, node, component, &mut row[first..first + per_part]);
                    if let (Some(before), false) = (hinged, is_held) {
                        let place = before * per_part..(before + 1) * per_part;
                        self.write(parts[before], node, component, &mut row[place.clone()]);
                        row[place].iter_mut().for_each(|it| *it = -*it);
                    }
                    triangle.add(&mut row);
                    rows += 1;
                }
                // One part alone is mostly held by a few nodes.
                if columns == per_part && rows >= look {
                    if triangle.null_space(FREE).is_empty() {
                        return Vec::new();
                    }
                    look *= 2;
                }
            }
        }
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
        modes.filter(|mode| self.field(mode).iter().any(|u| u.amax() > FREE)).collect()
    }

    /// What each of a part's numbers adds to a component of a node's displacement.
    fn write(&self, part: usize, node: u32, component: usize, row: &mut [f64]) {
        for (number, entry) in row.iter_mut().enumerate() {
            *entry = self.displacement(part, &self.unit(part, number), node)[component];
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
