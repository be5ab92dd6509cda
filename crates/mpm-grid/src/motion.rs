//! Motions of the mesh with the load: pure functions of the load fraction, always from rest.

use std::array::from_fn;
use std::fmt::Debug;
use std::sync::Arc;

use crate::affine::Affine;
use crate::cell::LinearCell;
use crate::layout::Layout;
use crate::placed::{PlacedMotion, Profile, Squares, Stretching, cos_sin};
use crate::ramp::{LoadFraction, Ramp};
use crate::{Block, NodeKind, Vector};

/// How the mesh moves with the load; node numbers never change.
///
/// At load fraction 0 every motion is at rest, and at the start of a later stage where the stage before has left it, whatever
/// its ramps say there: a ramp that begins elsewhere jumps in the first load step of the stage. Only the checked constructors make one. A motion that does not suit the layout it is used
/// with is a [`MotionError`] of every method.
#[derive(Clone, Debug)]
pub enum MeshMotion<const D: usize> {
    /// Ordinary MPM: the mesh returns to rest after every load step.
    Fixed,
    /// A box re-spaced between anchored and driven planes.
    #[non_exhaustive]
    Stretch {
        /// Per direction, the plane that is driven there.
        axes: [Option<DrivenPlane>; D],
    },
    /// The multilinear image of a box whose corners move.
    #[non_exhaustive]
    Corners {
        /// Displacement `[L]` of the 2^D corners, lexicographic, first direction fastest.
        path: Vec<[Ramp; D]>,
    },
    /// A rigid rotation, in three dimensions about the third axis.
    #[non_exhaustive]
    Rotate {
        /// Centre `[L]` in the plane of the first two coordinates.
        centre: [f64; 2],
        /// Angle `[rad]`, anticlockwise.
        angle: Ramp,
    },
    /// A ring whose rings of nodes turn by an angle linear in their radius, and whose layers of nodes may be re-spaced
    /// along the axis: what follows a screw.
    #[non_exhaustive]
    Twist {
        /// Centre `[L]` of the ring.
        centre: [f64; 2],
        /// Radius `[L]` up to which the first angle `[rad]` holds.
        inner: (f64, Ramp),
        /// Radius `[L]` from which the second angle `[rad]` holds.
        outer: (f64, Ramp),
        /// Whether each ring's angle is reduced by whole cells.
        reindexing: Reindexing,
        /// The plane that is driven along the axis, in three dimensions.
        stretch: Option<DrivenPlane>,
    },
    /// A ring whose rings of nodes are re-spaced between an anchored and a driven radius, so that the areas between
    /// them change in one ratio.
    #[non_exhaustive]
    Expand {
        /// The radii, in place of planes.
        radii: DrivenPlane,
    },
    /// A box under an affine map of the load fraction that someone else has written.
    #[non_exhaustive]
    Affine {
        /// The map.
        map: Arc<dyn AffineMotion<D>>,
    },
}

/// Two affine motions are equal where they share their map.
impl<const D: usize> PartialEq for MeshMotion<D> {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Fixed, Self::Fixed) => true,
            (Self::Stretch { axes }, Self::Stretch { axes: others }) => axes == others,
            (Self::Corners { path }, Self::Corners { path: other }) => path == other,
            (Self::Rotate { centre, angle }, Self::Rotate { centre: other, angle: by }) => {
                centre == other && angle == by
            }
            (
                Self::Twist { centre, inner, outer, reindexing, stretch },
                Self::Twist { centre: c, inner: i, outer: o, reindexing: r, stretch: s },
            ) => (centre, inner, outer, reindexing, stretch) == (c, i, o, r, s),
            (Self::Expand { radii }, Self::Expand { radii: other }) => radii == other,
            (Self::Affine { map }, Self::Affine { map: other }) => Arc::ptr_eq(map, other),
            _ => false,
        }
    }
}

/// A motion of one's own: the affine map of a box at every load fraction.
///
/// Affine maps take every cell to a parallelepiped, so that shape functions, location of points and
/// prescribed displacements stay exact. The map must be a pure function of the load fraction, the
/// identity at its start: meshes are made anew from rest, also after a cut and on resuming. In a schedule of several
/// stages it is the same at the end of a stage and at the start of the next: see [`LoadFraction::total`].
pub trait AffineMotion<const D: usize>: Debug + Send + Sync {
    /// `A` `[-]` and `b` `[L]` of `x = A X + b`; `det A` must stay above zero.
    fn at(&self, fraction: LoadFraction) -> (Block<D>, Vector<D>);
}

/// A plane of one direction that moves while another stays; nodes between them are re-spaced
/// linearly, nodes beyond the driven plane move with it, nodes beyond the anchor stay.
#[derive(Clone, Debug, PartialEq)]
pub struct DrivenPlane {
    /// Coordinate `[L]` that stays.
    pub anchor: f64,
    /// Coordinate `[L]` that moves, on either side of the anchor.
    pub driven: f64,
    /// Displacement `[L]` of the driven plane.
    pub displacement: Ramp,
}

impl DrivenPlane {
    /// Refuses planes of the direction `axis` that coincide, at rest or later.
    fn check(&self, axis: usize) -> Result<(), MotionError> {
        let span = self.driven - self.anchor;
        if !(span.is_finite() && self.displacement.is_finite()) {
            return Err(MotionError::NotFinite);
        }
        if span == 0.0 {
            return Err(MotionError::CoincidentPlanes { axis });
        }
        // Between knots the displacement is linear, so the knots decide.
        for (at, delta) in self.displacement.knots() {
            if (span + delta) / span <= 0.0 {
                return Err(MotionError::ThroughAnchor { axis, fraction: at.total() });
            }
        }
        Ok(())
    }

    fn placed(&self, at: LoadFraction) -> Stretching {
        Stretching { anchor: self.anchor, driven: self.driven, displacement: self.displacement.from_rest(at) }
    }
}

/// What a twist does with angles larger than a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reindexing {
    /// Rings keep their angle; the mesh shears until a cell folds, which is an error.
    Off,
    /// Each ring's angle is reduced to (-π/n, π/n] by whole cells of its n: sheared by at most one cell between rings.
    WholeCells,
    /// As `WholeCells` of each ring's angle against the next one's outside: sheared by half a cell at most.
    Neighbours,
}

/// Why a motion cannot be made, or cannot be used with a layout.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MotionError {
    /// A number of the motion is infinite or not a number.
    #[error("every number of a mesh motion must be finite")]
    NotFinite,
    /// A stretch between two planes that coincide.
    #[error("anchor and driven plane of the axis {} coincide", letter(*axis))]
    CoincidentPlanes {
        /// Direction, from 0.
        axis: usize,
    },
    /// A stretch that carries the driven plane to or through its anchor.
    #[error("the driven plane of the axis {} reaches its anchor at load fraction {fraction}", letter(*axis))]
    ThroughAnchor {
        /// Direction, from 0.
        axis: usize,
        /// Load fraction of the first knot where it has.
        fraction: f64,
    },
    /// An expansion between two radii that coincide or are not above 0.
    #[error("an expansion needs two different radii above 0, not {anchor} and {driven}")]
    ExpandedRadii {
        /// Radius that stays `[L]`.
        anchor: f64,
        /// Radius that moves `[L]`.
        driven: f64,
    },
    /// An expansion that carries the driven radius to or through its anchor or the centre.
    #[error("the driven radius reaches its anchor or the centre at load fraction {fraction}")]
    ThroughRadius {
        /// Load fraction of the first knot where it has.
        fraction: f64,
    },
    /// Paths for too few or too many corners.
    #[error("a box has {needed} corners; paths for {found} were given")]
    CornerCount {
        /// 2^D.
        needed: usize,
        /// Paths given.
        found: usize,
    },
    /// A rotation on a line.
    #[error("rotations need two or three dimensions")]
    NeedsPlane,
    /// A motion of boxes used with a ring.
    #[error("stretch, corner and affine motions need a box layout")]
    NeedsBox,
    /// An affine motion that moves the mesh before any load.
    #[error("an affine motion must be the identity at load fraction 0")]
    NotAtRest,
    /// A motion of rings used with a box.
    #[error("twists and expansions need a ring layout")]
    NeedsRing,
    /// A twist of a ring with splines.
    #[error("splines do not contain the map of a twist: expected a mesh at rest, rotated or expanded")]
    Splines,
    /// A twist about another centre than the ring's.
    #[error("a twist turns about the ring's centre {ring:?}, not {twist:?}")]
    OffCentre {
        /// Centre of the layout.
        ring: [f64; 2],
        /// Centre of the motion.
        twist: [f64; 2],
    },
    /// A twist whose inner radius is not the smaller one.
    #[error("a twist needs 0 <= inner < outer radius, not {inner} and {outer}")]
    TwistRadii {
        /// Inner radius `[L]`.
        inner: f64,
        /// Outer radius `[L]`.
        outer: f64,
    },
    /// A stretch along the axis of something else than a twist.
    #[error("only a twist can be stretched along its axis")]
    NotTwisted,
    /// A stretch along the axis of a ring in the plane.
    #[error("a twist can be stretched along its axis only where the ring has a height")]
    NeedsHeight,
    /// Re-indexing of a ring that does not close.
    #[error("only a full ring can be re-indexed by whole cells")]
    OpenRing,
    /// A mesh folded over or squeezed flat.
    #[error("the motion folds cells of the mesh at load fraction {fraction}")]
    Folded {
        /// The load fraction asked for.
        fraction: f64,
    },
    /// A position no position at rest is carried to.
    #[error("no position at rest is carried to {position:?}")]
    OutOfReach {
        /// The position `[L]`.
        position: Vec<f64>,
    },
}

/// What a direction is called.
fn letter(axis: usize) -> char {
    "XYZ".chars().nth(axis).unwrap_or('?')
}

impl<const D: usize> MeshMotion<D> {
    /// A box re-spaced between the anchored and driven planes given per direction.
    pub fn stretch(axes: [Option<DrivenPlane>; D]) -> Result<Self, MotionError> {
        for (axis, plane) in axes.iter().enumerate() {
            plane.as_ref().map_or(Ok(()), |plane| plane.check(axis))?;
        }
        Ok(Self::Stretch { axes })
    }

    /// A box whose 2^D corners, lexicographic with the first direction fastest, follow `path`.
    pub fn corners(path: Vec<[Ramp; D]>) -> Result<Self, MotionError> {
        if path.len() != 1 << D {
            return Err(MotionError::CornerCount { needed: 1 << D, found: path.len() });
        }
        if !path.iter().flatten().all(Ramp::is_finite) {
            return Err(MotionError::NotFinite);
        }
        Ok(Self::Corners { path })
    }

    /// A rigid rotation by `angle` `[rad]`.
    pub fn rotate(centre: [f64; 2], angle: Ramp) -> Result<Self, MotionError> {
        if D == 1 {
            return Err(MotionError::NeedsPlane);
        }
        if !(centre.iter().all(|c| c.is_finite()) && angle.is_finite()) {
            return Err(MotionError::NotFinite);
        }
        Ok(Self::Rotate { centre, angle })
    }

    /// A twist between an inner and an outer (radius `[L]`, angle `[rad]`).
    pub fn twist(
        centre: [f64; 2],
        inner: (f64, Ramp),
        outer: (f64, Ramp),
        reindexing: Reindexing,
    ) -> Result<Self, MotionError> {
        let numbers = [centre[0], centre[1], inner.0, outer.0];
        let ramps = inner.1.is_finite() && outer.1.is_finite();
        if !(ramps && numbers.iter().all(|c| c.is_finite())) {
            return Err(MotionError::NotFinite);
        }
        if !(0.0 <= inner.0 && inner.0 < outer.0) {
            return Err(MotionError::TwistRadii { inner: inner.0, outer: outer.0 });
        }
        Ok(Self::Twist { centre, inner, outer, reindexing, stretch: None })
    }

    /// This twist composed with a stretch along its axis: what stands in a layer between the anchored and the driven
    /// plane turns with its ring and moves along the axis; layers beyond the driven plane move with it.
    ///
    /// # Errors
    /// As of [`Self::stretch`]; [`MotionError::NotTwisted`] if this is no twist.
    pub fn stretched_along_axis(self, plane: DrivenPlane) -> Result<Self, MotionError> {
        plane.check(2)?;
        match self {
            Self::Twist { centre, inner, outer, reindexing, .. } => {
                Ok(Self::Twist { centre, inner, outer, reindexing, stretch: Some(plane) })
            }
            _ => Err(MotionError::NotTwisted),
        }
    }

    /// A ring whose rings of nodes are re-spaced between an anchored and a driven radius: the squares of their radii
    /// linearly, so that the areas between rings change in one ratio. Beyond the driven radius areas are kept, beyond the
    /// anchor rings stay. A medium that all but keeps its volume moves so.
    pub fn expand(radii: DrivenPlane) -> Result<Self, MotionError> {
        let DrivenPlane { anchor, driven, ref displacement } = radii;
        if !(anchor.is_finite() && driven.is_finite() && displacement.is_finite()) {
            return Err(MotionError::NotFinite);
        }
        if anchor == driven || anchor <= 0.0 || driven <= 0.0 {
            return Err(MotionError::ExpandedRadii { anchor, driven });
        }
        // Between knots the displacement is linear, so the knots decide.
        for (at, delta) in displacement.knots() {
            let span = driven - anchor;
            if (span + delta) / span <= 0.0 || driven + delta <= 0.0 {
                return Err(MotionError::ThroughRadius { fraction: at.total() });
            }
        }
        Ok(Self::Expand { radii })
    }

    /// A box under an affine map, which must be the identity at the start of the load.
    pub fn affine(map: Arc<dyn AffineMotion<D>>) -> Result<Self, MotionError> {
        let (matrix, shift) = map.at(LoadFraction::START);
        if matrix != Block::<D>::identity() || shift != Vector::<D>::zeros() {
            return Err(MotionError::NotAtRest);
        }
        Ok(Self::Affine { map })
    }

    /// Its ramps; an affine motion has none to show.
    pub fn ramps(&self) -> Vec<&Ramp> {
        match self {
            Self::Fixed | Self::Affine { .. } => Vec::new(),
            Self::Stretch { axes } => axes.iter().flatten().map(|plane| &plane.displacement).collect(),
            Self::Corners { path } => path.iter().flatten().collect(),
            Self::Rotate { angle, .. } => vec![angle],
            Self::Twist { inner, outer, stretch, .. } => {
                let along = stretch.iter().map(|plane| &plane.displacement);
                [&inner.1, &outer.1].into_iter().chain(along).collect()
            }
            Self::Expand { radii } => vec![&radii.displacement],
        }
    }

    /// Where the motion carries what stands at `rest` `[L]`; re-indexing only renames nodes.
    pub fn place(
        &self,
        layout: &Layout<D>,
        rest: &Vector<D>,
        at: LoadFraction,
    ) -> Result<Vector<D>, MotionError> {
        Ok(self.placed(layout, at)?.place(rest))
    }

    /// The inverse of [`Self::place`].
    pub fn recall(
        &self,
        layout: &Layout<D>,
        x: &Vector<D>,
        at: LoadFraction,
    ) -> Result<Vector<D>, MotionError> {
        let rest = self.placed(layout, at)?.recall(x);
        rest.ok_or_else(|| MotionError::OutOfReach { position: x.as_slice().to_vec() })
    }

    /// The ramps' values, after a check that the motion suits the layout.
    pub(crate) fn placed(&self, layout: &Layout<D>, at: LoadFraction) -> Result<PlacedMotion<D>, MotionError> {
        match (self, layout) {
            (Self::Fixed, _) => Ok(PlacedMotion::Rest),
            (Self::Stretch { axes }, Layout::Box { .. }) => {
                Ok(PlacedMotion::Stretch(axes.each_ref().map(|a| a.as_ref().map(|plane| plane.placed(at)))))
            }
            (Self::Expand { radii }, Layout::Ring { centre, .. }) => {
                let DrivenPlane { anchor, driven, displacement } = radii;
                let squares = Squares::new(*anchor, *driven, displacement.from_rest(at));
                Ok(PlacedMotion::Expand { centre: *centre, squares })
            }
            (Self::Corners { path }, Layout::Box { axes, .. }) => {
                let from = Vector::from_fn(|d, _| axes[d].first());
                let to = Vector::from_fn(|d, _| axes[d].last());
                let corner = |c: usize, path: &[Ramp; D]| {
                    Vector::from_fn(|d, _| {
                        let rest = if c >> d & 1 == 0 { from[d] } else { to[d] };
                        rest + path[d].from_rest(at)
                    })
                };
                let corners = from_fn(|c| path.get(c).map_or(Vector::zeros(), |p| corner(c, p)));
                Ok(PlacedMotion::Corners { from, to, image: LinearCell::new(corners) })
            }
            (Self::Rotate { centre, angle }, _) => {
                let angle = angle.from_rest(at);
                Ok(PlacedMotion::Rotation { centre: *centre, angle, cos_sin: cos_sin(angle) })
            }
            (Self::Twist { .. }, _) if layout.functions() != NodeKind::Vertices => Err(MotionError::Splines),
            (
                Self::Twist { centre: twist, inner, outer, reindexing, stretch },
                Layout::Ring { centre: ring, radii, span, height, .. },
            ) => {
                let apart = (twist[0] - ring[0]).hypot(twist[1] - ring[1]);
                if apart > 1e-9 * radii.first() {
                    return Err(MotionError::OffCentre { ring: *ring, twist: *twist });
                }
                if *reindexing != Reindexing::Off && !span.is_full() {
                    return Err(MotionError::OpenRing);
                }
                if stretch.is_some() && height.is_none() {
                    return Err(MotionError::NeedsHeight);
                }
                let profile = Profile {
                    inner: (inner.0, inner.1.from_rest(at)),
                    outer: (outer.0, outer.1.from_rest(at)),
                };
                Ok(PlacedMotion::Twist {
                    centre: *ring,
                    profile,
                    along: stretch.as_ref().map(|it| it.placed(at)),
                })
            }
            (Self::Affine { map }, Layout::Box { .. }) => {
                let (matrix, shift) = map.at(at);
                if !matrix.iter().chain(shift.iter()).all(|number| number.is_finite()) {
                    return Err(MotionError::NotFinite);
                }
                let affine = Affine::new(matrix, shift).ok_or(MotionError::Folded { fraction: at.total() })?;
                Ok(PlacedMotion::Affine(affine))
            }
            (Self::Stretch { .. } | Self::Corners { .. } | Self::Affine { .. }, Layout::Ring { .. }) => {
                Err(MotionError::NeedsBox)
            }
            (Self::Twist { .. } | Self::Expand { .. }, Layout::Box { .. }) => Err(MotionError::NeedsRing),
        }
    }
}
