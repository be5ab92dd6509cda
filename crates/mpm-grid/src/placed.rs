//! A mesh motion at one load fraction: a map of positions with its inverse.

use crate::affine::Affine;
use crate::cell::{LinearCell, inverse};
use crate::{Axis, Block, Vector};

/// Numbers of a motion, its ramps evaluated.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum PlacedMotion<const D: usize> {
    Rest,
    Stretch([Option<Stretching>; D]),
    /// The box between `from` and `to` becomes `image`.
    Corners {
        from: Vector<D>,
        to: Vector<D>,
        image: LinearCell<D>,
    },
    Rotation {
        centre: [f64; 2],
        angle: f64,
        cos_sin: [f64; 2],
    },
    Twist {
        centre: [f64; 2],
        profile: Profile,
        /// Along the third axis.
        along: Option<Stretching>,
    },
    Expand {
        centre: [f64; 2],
        squares: Squares,
    },
    Affine(Affine<D>),
}

impl<const D: usize> PlacedMotion<D> {
    /// Position `[L]` of what stands at `rest` before the motion.
    pub(crate) fn place(&self, rest: &Vector<D>) -> Vector<D> {
        match self {
            Self::Rest => *rest,
            Self::Stretch(axes) => Vector::from_fn(|d, _| axes[d].map_or(rest[d], |s| s.place(rest[d]))),
            Self::Corners { from, to, image } => {
                let local = |d: usize| 2.0 * ((rest[d] - from[d]) / (to[d] - from[d])) - 1.0;
                image.position(&Vector::from_fn(|d, _| local(d)))
            }
            Self::Rotation { centre, cos_sin, .. } => rotate(rest, centre, *cos_sin),
            Self::Twist { centre, profile, along } => {
                let turned = rotate(rest, centre, cos_sin(profile.angle(radius(rest, centre))));
                raised(turned, along.map(|it| it.place(rest[D - 1])))
            }
            Self::Expand { centre, squares } => {
                let r = radius(rest, centre);
                scale(rest, centre, if r > 0.0 { squares.place(r) / r } else { 1.0 })
            }
            Self::Affine(map) => map.place(rest),
        }
    }

    /// The inverse of [`Self::place`]; `None` where the map of the corners cannot be inverted.
    pub(crate) fn recall(&self, x: &Vector<D>) -> Option<Vector<D>> {
        Some(match self {
            Self::Rest => *x,
            Self::Stretch(axes) => Vector::from_fn(|d, _| axes[d].map_or(x[d], |s| s.recall(x[d]))),
            Self::Corners { from, to, image } => {
                let local = image.local(x)?;
                Vector::from_fn(|d, _| from[d] + (to[d] - from[d]) * (0.5 * (local[d] + 1.0)))
            }
            Self::Rotation { centre, cos_sin: [c, s], .. } => rotate(x, centre, [*c, -s]),
            Self::Twist { centre, profile, along } => {
                let turned = rotate(x, centre, cos_sin(-profile.angle(radius(x, centre))));
                raised(turned, along.map(|it| it.recall(x[D - 1])))
            }
            Self::Expand { centre, squares } => {
                let now = radius(x, centre);
                scale(x, centre, if now > 0.0 { squares.recall(now)? / now } else { 1.0 })
            }
            Self::Affine(map) => map.recall(x),
        })
    }

    /// (∂rest/∂x)ᵀ at a position at rest, for the motions of a bent box: turns gradients with
    /// respect to positions at rest into gradients with respect to positions.
    pub(crate) fn push_gradients(&self, rest: &Vector<D>) -> Block<D> {
        match self {
            Self::Corners { from, to, image } => {
                let half = (to - from) * 0.5;
                let local = (rest - from).component_div(&half).add_scalar(-1.0);
                inverse(&image.jacobian(&local)).transpose() * Block::from_diagonal(&half)
            }
            Self::Rotation { cos_sin, .. } => Block::from_fn(|i, j| match (i, j) {
                (0, 0) | (1, 1) => cos_sin[0],
                (1, 0) => cos_sin[1],
                (0, 1) => -cos_sin[1],
                _ => f64::from(u8::from(i == j)),
            }),
            Self::Affine(map) => map.push_gradients(),
            Self::Rest | Self::Stretch(_) | Self::Twist { .. } | Self::Expand { .. } => {
                unreachable!("meshes under this motion are not bent boxes")
            }
        }
    }
}

/// Linear re-spacing of one coordinate between an anchored and a driven plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Stretching {
    pub(crate) anchor: f64,
    pub(crate) driven: f64,
    pub(crate) displacement: f64,
}

impl Stretching {
    pub(crate) fn place(self, x: f64) -> f64 {
        let span = self.driven - self.anchor;
        self.pass(x, span, (span + self.displacement) / span, self.displacement)
    }

    fn recall(self, x: f64) -> f64 {
        let span = self.driven - self.anchor + self.displacement;
        self.pass(x, span, (self.driven - self.anchor) / span, -self.displacement)
    }

    fn pass(self, x: f64, span: f64, factor: f64, shift: f64) -> f64 {
        match (x - self.anchor) / span {
            share if share <= 0.0 => x,
            share if share >= 1.0 => x + shift,
            _ => self.anchor + (x - self.anchor) * factor,
        }
    }

    /// The axis re-spaced; `None` where neighbouring nodes would meet in one rounded coordinate.
    pub(crate) fn respaced(self, axis: &Axis) -> Option<Axis> {
        let (from, to) = (axis.first(), axis.last());
        if axis.is_uniform() && self.is_affine_on(from, to) {
            return Axis::uniform(self.place(from), self.place(to), axis.cells()).ok();
        }
        let nodes = (0..=axis.cells()).map(|i| self.place(axis.node(i)));
        Axis::graded(nodes.collect()).ok()
    }

    /// Whether one straight line maps all of [from, to].
    fn is_affine_on(self, from: f64, to: f64) -> bool {
        self.anchor.min(self.driven) <= from && self.anchor.max(self.driven) >= to
    }
}

/// Linear re-spacing of the squares of radii: areas between rings change in one ratio.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Squares(Stretching);

impl Squares {
    pub(crate) fn new(anchor: f64, driven: f64, displacement: f64) -> Self {
        let displacement = (2.0 * driven + displacement) * displacement;
        Self(Stretching { anchor: anchor * anchor, driven: driven * driven, displacement })
    }

    /// Radius now of a radius at rest; not a number for what has passed through the centre.
    fn place(self, radius: f64) -> f64 {
        if self.0.displacement == 0.0 {
            return radius;
        }
        self.0.place(radius * radius).sqrt()
    }

    /// The inverse; `None` within a hole that has opened around the centre.
    fn recall(self, radius: f64) -> Option<f64> {
        if self.0.displacement == 0.0 {
            return Some(radius);
        }
        let square = self.0.recall(radius * radius);
        (square > 0.0).then(|| square.sqrt())
    }

    /// The axis of radii re-spaced; `None` where a ring has come to the centre or to the next one.
    pub(crate) fn axis(self, radii: &Axis) -> Option<Axis> {
        if self.0.displacement == 0.0 {
            return Some(radii.clone());
        }
        let nodes: Vec<f64> = (0..=radii.cells()).map(|i| self.place(radii.node(i))).collect();
        if nodes.first().is_some_and(|inner| *inner > 0.0) { Axis::graded(nodes).ok() } else { None }
    }
}

/// Angle of a twist `[rad]` against the radius `[L]`: linear between two radii, constant beyond.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Profile {
    pub(crate) inner: (f64, f64),
    pub(crate) outer: (f64, f64),
}

impl Profile {
    pub(crate) fn angle(self, radius: f64) -> f64 {
        let ((r0, a0), (r1, a1)) = (self.inner, self.outer);
        let t = ((radius - r0) / (r1 - r0)).clamp(0.0, 1.0);
        a0 * (1.0 - t) + a1 * t
    }
}

/// `angle` less whole multiples of `sector`, in (-sector/2, sector/2].
///
/// Half a sector counts as such up to 1e-9 sectors of rounding.
pub(crate) fn reduce(angle: f64, sector: f64) -> f64 {
    angle - sector * (angle / sector - 0.5 - 1e-9).ceil()
}

/// Rotation in the plane of the first two coordinates.
#[inline]
pub(crate) fn rotate<const D: usize>(x: &Vector<D>, centre: &[f64; 2], [cos, sin]: [f64; 2]) -> Vector<D> {
    let (dx, dy) = (x[0] - centre[0], x[1] - centre[1]);
    Vector::from_fn(|d, _| match d {
        0 => centre[0] + (cos * dx - sin * dy),
        1 => centre[1] + (sin * dx + cos * dy),
        _ => x[d],
    })
}

/// Stretch by a factor away from the centre in the plane of the first two coordinates.
fn scale<const D: usize>(x: &Vector<D>, centre: &[f64; 2], factor: f64) -> Vector<D> {
    Vector::from_fn(|d, _| match d {
        0 | 1 => centre[d] + (x[d] - centre[d]) * factor,
        _ => x[d],
    })
}

pub(crate) fn cos_sin(angle: f64) -> [f64; 2] {
    [angle.cos(), angle.sin()]
}

/// (R(angle) - I)(x - centre), accurate for small angles: cos a - 1 = -2 sin²(a/2).
pub(crate) fn turn<const D: usize>(x: &Vector<D>, centre: &[f64; 2], angle: f64) -> Vector<D> {
    let sin = angle.sin();
    let cos_less_one = -2.0 * (0.5 * angle).sin().powi(2);
    let (dx, dy) = (x[0] - centre[0], x[1] - centre[1]);
    Vector::from_fn(|d, _| match d {
        0 => cos_less_one * dx - sin * dy,
        1 => sin * dx + cos_less_one * dy,
        _ => 0.0,
    })
}

/// `x` with another last coordinate, if there is one.
fn raised<const D: usize>(mut x: Vector<D>, height: Option<f64>) -> Vector<D> {
    x[D - 1] = height.unwrap_or(x[D - 1]);
    x
}

fn radius<const D: usize>(x: &Vector<D>, centre: &[f64; 2]) -> f64 {
    (x[0] - centre[0]).hypot(x[1] - centre[1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn angles_reduce_by_whole_sectors() {
        let sector = PI / 16.0;
        for (sectors, reduced) in [(0.5, 0.5), (-0.5, 0.5), (0.6, -0.4), (7.25, 0.25), (-3.0, 0.0)] {
            let angle = reduce(sectors * sector, sector);
            assert!((angle - reduced * sector).abs() < 1e-14, "{sectors} sectors");
        }
        // One rounding error above half a sector must not choose the other side.
        assert!(reduce(0.5 * sector * (1.0 + 1e-15), sector) > 0.0);
    }

    #[test]
    fn a_small_turn_keeps_its_digits() {
        let x = Vector::<2>::new(1.0, 0.0);
        let by = turn(&x, &[0.0; 2], 1e-9);
        assert!((by[0] + 5e-19).abs() < 1e-30 && (by[1] - 1e-9).abs() < 1e-24);
    }
}
