//! Helical plates: the points within half a thickness of a piece of a helicoid.

use crate::bounds::Bounds;
use crate::error::ContactError;
use crate::helix_surface;
use crate::shape::{Near, Outline, Sample, Shape, keep_distinct};
use crate::sheet::{Foot, Sheet};
use mpm_grid::Block;
use nalgebra::{Vector2, Vector3};
use std::f64::consts::TAU;

/// The plate of a screw: all points within half a thickness of the sheet
/// `(r cos θ, r sin θ, c θ)`, `r` between two radii, `θ` between 0 and some turns. Its edges are round.
#[derive(Clone, Debug, PartialEq)]
pub struct Helix {
    frame: Frame,
    sheet: Sheet,
    half_thickness: f64,
}

/// Where the sheet's frame stands: its origin and axes as columns.
#[derive(Clone, Debug, PartialEq)]
struct Frame {
    origin: Vector3<f64>,
    axes: Block<3>,
}

/// What a helix is made of, beside its frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HelixSize {
    /// Inner and outer radius `[L]`.
    pub radii: [f64; 2],
    /// Rise per turn `[L]`; positive where it is right-handed about the axis.
    pub pitch: f64,
    /// Number of turns `[-]`.
    pub turns: f64,
    /// Of the plate `[L]`.
    pub thickness: f64,
}

impl Helix {
    /// A helical plate about the axis through `start` `[L]`, which begins there at the angle 0, in the direction that
    /// `from` shows across the axis.
    ///
    /// # Errors
    /// `start`, `axis`, `from`: not finite, or without length (across the axis); `radii`: not 0 ≤ inner < outer;
    /// `pitch`: 0; `turns`: not between 0 and 1000; `thickness`: not positive, or not below the pitch.
    pub fn new(
        start: Vector3<f64>,
        axis: Vector3<f64>,
        from: Vector3<f64>,
        size: &HelixSize,
    ) -> Result<Self, ContactError> {
        ContactError::unless_finite("start", start.as_slice())?;
        ContactError::unless_finite("axis", axis.as_slice())?;
        ContactError::unless_finite("from", from.as_slice())?;
        let axis = axis / ContactError::unless_positive("axis", axis.norm())?;
        let across = from - axis * axis.dot(&from);
        let across = across / ContactError::unless_positive("from", across.norm())?;
        let [inner, outer] = size.radii;
        ContactError::unless_not_negative("radii", inner)?;
        ContactError::unless(outer > inner && outer.is_finite(), "radii", outer, "more than the inner radius")?;
        let pitched = size.pitch != 0.0 && size.pitch.is_finite();
        ContactError::unless(pitched, "pitch", size.pitch, "a finite number other than 0")?;
        let some = size.turns > 0.0 && size.turns <= 1000.0;
        ContactError::unless(some, "turns", size.turns, "a number above 0 and at most 1000")?;
        ContactError::unless_positive("thickness", size.thickness)?;
        let thin = size.thickness < size.pitch.abs();
        ContactError::unless(thin, "thickness", size.thickness, "less than the pitch")?;
        let axes = Block::<3>::from_columns(&[across, axis.cross(&across), axis]);
        let sheet = Sheet { radii: size.radii, rise: size.pitch / TAU, end: TAU * size.turns };
        Ok(Self { frame: Frame { origin: start, axes }, sheet, half_thickness: 0.5 * size.thickness })
    }
}

impl Shape<3> for Helix {
    fn near(&self, x: &Vector3<f64>, reach: f64, out: &mut Vec<Near<3>>) {
        let local = self.frame.axes.tr_mul(&(x - self.frame.origin));
        let rho = Vector2::new(local[0], local[1]).norm();
        let alpha = if rho > 0.0 { local[1].atan2(local[0]) } else { 0.0 };
        let to_sheet = reach + self.half_thickness;
        let outside = rho - self.sheet.radii[1];
        if outside >= to_sheet || to_sheet <= 0.0 {
            return;
        }
        let from = out.len();
        for angle in self.sheet.minima(rho, alpha, local[2], to_sheet) {
            let toward = rho * (angle - alpha).cos();
            let foot = Foot { radius: self.sheet.radius(rho, angle - alpha), angle };
            let from_foot = local - self.sheet.position(foot.radius, foot.angle);
            let distance = from_foot.norm();
            if distance >= to_sheet {
                continue;
            }
            let free = [foot.radius == toward, 0.0 < angle && angle < self.sheet.end];
            let (normal, hessian) = if distance > 1e-9 * self.half_thickness {
                (from_foot / distance, self.sheet.hessian(&foot, free, &from_foot, distance))
            } else {
                // In the middle of the plate either side is as near.
                (self.sheet.normal(foot.radius, foot.angle), Block::zeros())
            };
            let axes = self.frame.axes;
            // Number of the turn: the plate meets itself from above and below.
            let feature = (angle / TAU) as u32;
            out.push(Near {
                distance: distance - self.half_thickness,
                normal: axes * normal,
                hessian: axes * hessian * axes.transpose(),
                feature,
            });
        }
        keep_distinct(out, from);
    }

    fn kind(&self) -> &'static str {
        "helix"
    }

    fn bounds(&self) -> Bounds<3> {
        let axis = self.frame.axes.column(2).into_owned();
        let reach = axis.map(|a| self.sheet.radii[1] * (1.0 - a * a).max(0.0).sqrt());
        let ends = [0.0, self.sheet.rise * self.sheet.end].map(|z| self.frame.origin + axis * z);
        let around = ends.map(|end| Bounds { from: end - reach, to: end + reach });
        around[0].with(&around[1]).grown(self.half_thickness)
    }

    fn samples(&self, spacing: f64, _within: &Bounds<3>, out: &mut Vec<Sample<3>>) {
        let placed = |it: Sample<3>| Sample {
            position: self.frame.origin + self.frame.axes * it.position,
            normal: self.frame.axes * it.normal,
            ..it
        };
        out.extend(helix_surface::samples(&self.sheet, self.half_thickness, spacing).into_iter().map(placed));
    }

    fn outline(&self, spacing: f64, _within: &Bounds<3>) -> Outline<3> {
        let mut outline = helix_surface::outline(&self.sheet, self.half_thickness, spacing);
        outline.vertices.iter_mut().for_each(|x| *x = self.frame.origin + self.frame.axes * *x);
        outline
    }

    fn thickness(&self) -> f64 {
        2.0 * self.half_thickness
    }
}
