//! Solids of revolution: cylinders, cones, tubes, and whole piles by their profile.

use crate::bounds::Bounds;
use crate::error::ContactError;
use crate::plane::parts;
use crate::polygon::{Foot, Piece, Polygon};
use crate::shape::{Near, Outline, Sample, Shape, keep_distinct};
use mpm_grid::{Block, Vector};
use nalgebra::Vector3;
use std::f64::consts::TAU;

type Vec2 = Vector<2>;

/// A body that a polygon with rounded corners sweeps round an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Revolution {
    through: Vector3<f64>,
    axis: Vector3<f64>,
    /// Two directions across the axis, right-handed with it.
    across: [Vector3<f64>; 2],
    /// In the half plane (r, z); of a solid with its mirror image, so that its edges do not end on the axis.
    meridian: Polygon,
    /// How far apart features on the axis may stand from it by rounding `[L]`.
    hair: f64,
}

impl Revolution {
    /// The body whose `profile` of (distance from the axis, place along it) `[L]` turns about the axis through
    /// `through` `[L]`; places count from there. A profile that begins and ends on the axis makes a solid; one that
    /// stays away from it is closed to a ring. Convex corners are rounded by `rounding` `[L]`.
    ///
    /// # Errors
    /// `through`, `axis`: not finite, or an axis without length; `profile`: a negative distance, or a profile that
    /// meets the axis elsewhere than at both its ends; `vertices`, `rounding`: as of [`Polygon::new`].
    pub fn new(
        through: Vector3<f64>,
        axis: Vector3<f64>,
        profile: &[[f64; 2]],
        rounding: f64,
    ) -> Result<Self, ContactError> {
        ContactError::unless_finite("through", through.as_slice())?;
        ContactError::unless_finite("axis", axis.as_slice())?;
        let length = ContactError::unless_positive("axis", axis.norm())?;
        let on_axis = profile.iter().filter(|it| it[0] == 0.0).count();
        let ends = [profile.first(), profile.last()];
        let solid = on_axis == 2 && ends.iter().all(|end| end.is_some_and(|it| it[0] == 0.0));
        for place in profile {
            let expected = "a distance from the axis above 0, or of 0 at both ends of the profile";
            ContactError::unless(place[0] > 0.0 || (solid && place[0] == 0.0), "profile", place[0], expected)?;
        }
        let mut vertices: Vec<Vec2> = profile.iter().map(|&place| Vec2::from(place)).collect();
        if solid {
            let mirrored = profile.iter().rev().filter(|it| it[0] > 0.0).map(|it| Vec2::new(-it[0], it[1]));
            vertices.extend(mirrored);
        }
        let meridian = Polygon::new(vertices, rounding)?;
        let axis = axis / length;
        // Of the three axes the one farthest from this axis, made orthogonal.
        let first = Vector3::ith(axis.iamin(), 1.0);
        let first = (first - axis * axis.dot(&first)).normalize();
        let size = profile.iter().flatten().fold(0.0, |a: f64, b| a.max(b.abs()));
        Ok(Self { through, axis, across: [first, axis.cross(&first)], meridian, hair: 1e-12 * size })
    }

    /// The cylinder from `start` to `end` `[L]`, both ends in the middle, with rims rounded by `rounding` `[L]`.
    ///
    /// # Errors
    /// `extent`: the ends are not finite or coincide; `radius`: not positive; `rounding`: negative or too large.
    pub fn cylinder(
        start: Vector3<f64>,
        end: Vector3<f64>,
        radius: f64,
        rounding: f64,
    ) -> Result<Self, ContactError> {
        let length = Self::length(&start, &end)?;
        ContactError::unless_positive("radius", radius)?;
        let profile = [[0.0, 0.0], [radius, 0.0], [radius, length], [0.0, length]];
        Self::new(start, end - start, &profile, rounding)
    }

    /// The cone from its tip to the middle of its base `[L]`, with a radius `[L]` at either end; a frustum where the
    /// radius at the tip is not 0. Tip and rims are rounded by `rounding` `[L]`.
    ///
    /// # Errors
    /// `extent`: the ends are not finite or coincide; `radius`: negative at the tip, or not larger at the base;
    /// `rounding`: negative or too large.
    pub fn cone(
        tip: Vector3<f64>,
        base: Vector3<f64>,
        radii: [f64; 2],
        rounding: f64,
    ) -> Result<Self, ContactError> {
        let length = Self::length(&tip, &base)?;
        ContactError::unless_not_negative("radius", radii[0])?;
        let wider = radii[1] > radii[0] && radii[1].is_finite();
        ContactError::unless(wider, "radius", radii[1], "a finite number above the radius at the tip")?;
        let mut profile = vec![[0.0, 0.0], [radii[0], 0.0], [radii[1], length], [0.0, length]];
        if radii[0] == 0.0 {
            profile.remove(1);
        }
        Self::new(tip, base - tip, &profile, rounding)
    }

    fn length(start: &Vector3<f64>, end: &Vector3<f64>) -> Result<f64, ContactError> {
        ContactError::unless_finite("extent", start.as_slice())?;
        ContactError::unless_finite("extent", end.as_slice())?;
        ContactError::unless_positive("extent", (end - start).norm())
    }

    /// Distance from the axis, place along it, and the direction away from it.
    fn cylindrical(&self, x: &Vector3<f64>) -> (Vec2, Vector3<f64>) {
        let from = x - self.through;
        let along = self.axis.dot(&from);
        let outwards = from - self.axis * along;
        let radius = outwards.norm();
        let radial = if radius > 0.0 { outwards / radius } else { self.across[0] };
        (Vec2::new(radius, along), radial)
    }

    fn near_of(&self, foot: &Foot, place: &Vec2, radial: &Vector3<f64>) -> Near<3> {
        let [n_r, n_z] = [foot.normal[0], foot.normal[1]];
        let normal = radial * n_r + self.axis * n_z;
        let meridional = self.axis * n_r - radial * n_z;
        let hoop = self.axis.cross(radial);
        // ∂n/∂(arc round the axis); what is round about a place on the axis curves equally both ways.
        let on_axis = foot.centre.is_some_and(|centre| centre[0].abs() <= self.hair);
        let around = match (on_axis, place[0] > 0.0 && n_r.abs() > 1e-12) {
            (true, _) => foot.curvature,
            (false, true) => n_r / place[0],
            (false, false) => 0.0,
        };
        let hessian: Block<3> =
            meridional * meridional.transpose() * foot.curvature + hoop * hoop.transpose() * around;
        Near { distance: foot.distance, normal, hessian, feature: foot.feature }
    }

    fn radial(&self, angle: f64) -> Vector3<f64> {
        self.across[0] * angle.cos() + self.across[1] * angle.sin()
    }

    fn in_space(&self, place: &Vec2, radial: &Vector3<f64>) -> Vector3<f64> {
        self.through + radial * place[0] + self.axis * place[1]
    }

    /// The parts of the profile on the positive side of the axis.
    fn pieces(&self, spacing: f64, least_arcs: u32) -> Vec<Piece> {
        let mut pieces = self.meridian.pieces(spacing, least_arcs);
        pieces.retain(|piece| piece.mean[0] > 0.0);
        pieces
    }
}

impl Shape<3> for Revolution {
    fn near(&self, x: &Vector3<f64>, reach: f64, out: &mut Vec<Near<3>>) {
        let (place, radial) = self.cylindrical(x);
        let from = out.len();
        let feet = self.meridian.feet(&place, reach);
        // Beyond the axis a place of the profile is the farthest on its circle, not the nearest.
        let this_side = |foot: &&Foot| place[0] - foot.distance * foot.normal[0] >= -self.hair;
        out.extend(feet.iter().filter(this_side).map(|foot| self.near_of(foot, &place, &radial)));
        keep_distinct(out, from);
    }

    fn kind(&self) -> &'static str {
        "body of revolution"
    }

    fn bounds(&self) -> Bounds<3> {
        self.meridian.vertices().fold(Bounds::empty(), |bounds, vertex| {
            let centre = self.through + self.axis * vertex[1];
            let reach = self.axis.map(|a| vertex[0].abs() * (1.0 - a * a).max(0.0).sqrt());
            bounds.with(&Bounds { from: centre - reach, to: centre + reach })
        })
    }

    fn samples(&self, spacing: f64, within: &Bounds<3>, out: &mut Vec<Sample<3>>) {
        for piece in self.pieces(spacing, 1) {
            let around = TAU * piece.mean[0];
            let n = parts(around, spacing).max(3);
            let area = around * piece.length / f64::from(n);
            for k in 0..n {
                let radial = self.radial(TAU * (f64::from(k) + 0.5) / f64::from(n));
                let normal = radial * piece.normal[0] + self.axis * piece.normal[1];
                let position = self.in_space(&piece.middle, &radial);
                if within.contains(&position) {
                    out.push(Sample { position, normal, area });
                }
            }
        }
    }

    fn outline(&self, spacing: f64, _within: &Bounds<3>) -> Outline<3> {
        let mut outline = Outline::default();
        let widest = self.meridian.vertices().fold(0.0, |r: f64, vertex| r.max(vertex[0]));
        let n = parts(TAU * widest, spacing).clamp(48, 256);
        for piece in self.pieces(f64::INFINITY, 4) {
            let ring = |outline: &mut Outline<3>, place: &Vec2| -> Vec<u32> {
                let at = |k: u32| self.in_space(place, &self.radial(TAU * f64::from(k) / f64::from(n)));
                if place[0] <= self.hair {
                    vec![outline.add(at(0))]
                } else {
                    (0..n).map(|k| outline.add(at(k))).collect()
                }
            };
            let [below, above] = piece.ends.map(|place| ring(&mut outline, &place));
            let pick = |ring: &[u32], k: usize| ring[k % ring.len()];
            for k in 0..below.len().max(above.len()) {
                let [a, b] = [pick(&below, k), pick(&below, k + 1)];
                let [c, d] = [pick(&above, k + 1), pick(&above, k)];
                if a != b {
                    outline.facets.push([a, b, c]);
                }
                if c != d {
                    outline.facets.push([a, c, d]);
                }
            }
        }
        outline
    }

    fn thickness(&self) -> f64 {
        self.meridian.thickness()
    }
}
