//! The surface of a helical plate: two faces, rounded rims and ends, rounded corners.

use crate::plane::parts;
use crate::shape::{Outline, Sample};
use crate::sheet::Sheet;
use nalgebra::Vector3;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Samples of the points that stand half a thickness `h` off a sheet.
pub(crate) fn samples(sheet: &Sheet, h: f64, spacing: f64) -> Vec<Sample<3>> {
    let mut out = Vec::new();
    faces(sheet, h, spacing, &mut out);
    for outer in [false, true] {
        rim(sheet, h, spacing, outer, &mut out);
        end(sheet, h, spacing, outer, &mut out);
        corners(sheet, h, outer, &mut out);
    }
    out
}

/// `A = ∫∫ (√(r² + c²) - h² c²/(r² + c²)^(3/2)) dr dθ`: a helicoid is a minimal surface, so that only its Gaussian
/// curvature changes the area of a face off it.
fn faces(sheet: &Sheet, h: f64, spacing: f64, out: &mut Vec<Sample<3>>) {
    let [inner, outer] = sheet.radii;
    let c = sheet.rise.abs();
    let integral = |r: f64| {
        let s = r.hypot(c);
        0.5 * (r * s + c * c * (r / c).asinh()) - h * h * r / s
    };
    let bands = parts(outer - inner, spacing);
    let width = (outer - inner) / f64::from(bands);
    for band in 0..bands {
        let r = inner + width * f64::from(band);
        let middle = r + 0.5 * width;
        let n = parts(sheet.end * (r + width).hypot(c), spacing);
        let step = sheet.end / f64::from(n);
        let area = step * (integral(r + width) - integral(r));
        for k in 0..n {
            let angle = step * (f64::from(k) + 0.5);
            let (position, normal) = (sheet.position(middle, angle), sheet.normal(middle, angle));
            for normal in [normal, -normal] {
                out.push(Sample { position: position + normal * h, normal, area });
            }
        }
    }
}

/// Angles that part a half circle of radius `h`, from -π/2 to π/2: their middles and ends.
fn half_circle(h: f64, spacing: f64) -> impl Iterator<Item = (f64, [f64; 2])> {
    let n = parts(PI * h, spacing).max(2);
    let step = PI / f64::from(n);
    (0..n).map(move |k| {
        let from = step * f64::from(k) - FRAC_PI_2;
        (from + 0.5 * step, [from, from + step])
    })
}

/// Half a tube about a rim: `dA = h (1 ± h κ cos β) dβ ds` with the curvature κ of the rim.
fn rim(sheet: &Sheet, h: f64, spacing: f64, outer: bool, out: &mut Vec<Sample<3>>) {
    let (r, sign) = if outer { (sheet.radii[1], 1.0) } else { (sheet.radii[0], -1.0) };
    let length = r.hypot(sheet.rise);
    let curvature = r / (length * length);
    let n = parts(sheet.end * length, spacing);
    let step = sheet.end / f64::from(n);
    for k in 0..n {
        let angle = step * (f64::from(k) + 0.5);
        let (position, up) = (sheet.position(r, angle), sheet.normal(r, angle));
        let outwards = Vector3::new(angle.cos(), angle.sin(), 0.0) * sign;
        for (beta, [from, to]) in half_circle(h, spacing) {
            let normal = outwards * beta.cos() + up * beta.sin();
            let bent = to - from + sign * h * curvature * (to.sin() - from.sin());
            // The inner side of a narrow helix may have folded away.
            let area = (h * length * step * bent).max(0.0);
            out.push(Sample { position: position + normal * h, normal, area });
        }
    }
}

/// The direction in which the sheet ends.
fn onwards(sheet: &Sheet, r: f64, last: bool) -> (f64, Vector3<f64>) {
    let (angle, sign) = if last { (sheet.end, 1.0) } else { (0.0, -1.0) };
    let along = Vector3::new(-r * angle.sin(), r * angle.cos(), sheet.rise);
    (angle, along * (sign / along.norm()))
}

/// Half a tube about the straight edge at the first or last angle.
fn end(sheet: &Sheet, h: f64, spacing: f64, last: bool, out: &mut Vec<Sample<3>>) {
    let [inner, outer] = sheet.radii;
    let n = parts(outer - inner, spacing);
    let step = (outer - inner) / f64::from(n);
    for k in 0..n {
        let r = inner + step * (f64::from(k) + 0.5);
        let (angle, along) = onwards(sheet, r, last);
        let (position, up) = (sheet.position(r, angle), sheet.normal(r, angle));
        for (beta, [from, to]) in half_circle(h, spacing) {
            let normal = along * beta.cos() + up * beta.sin();
            out.push(Sample { position: position + normal * h, normal, area: h * step * (to - from) });
        }
    }
}

/// A quarter of a sphere at both ends of a rim, as eight samples.
fn corners(sheet: &Sheet, h: f64, outer: bool, out: &mut Vec<Sample<3>>) {
    let (r, sign) = if outer { (sheet.radii[1], 1.0) } else { (sheet.radii[0], -1.0) };
    for last in [false, true] {
        let (angle, along) = onwards(sheet, r, last);
        let outwards = Vector3::new(angle.cos(), angle.sin(), 0.0) * sign;
        let (position, up) = (sheet.position(r, angle), sheet.normal(r, angle));
        for (beta, [from, to]) in half_circle(1.0, 1.0) {
            for half in [0.25, 0.75] {
                let (sine, cosine) = (FRAC_PI_2 * half).sin_cos();
                let normal = (outwards * cosine + along * sine) * beta.cos() + up * beta.sin();
                let area = h * h * (to.sin() - from.sin()) * 0.25 * PI;
                out.push(Sample { position: position + normal * h, normal, area });
            }
        }
    }
}

/// Cross sections with round rims, joined along the helix, with flat ends.
pub(crate) fn outline(sheet: &Sheet, h: f64, spacing: f64) -> Outline<3> {
    let mut outline = Outline::default();
    let per_turn = parts(TAU * sheet.radii[1], spacing).clamp(24, 256);
    let sections = parts(sheet.end, TAU / f64::from(per_turn));
    const ARC: u32 = 6;
    for k in 0..=sections {
        let angle = sheet.end * f64::from(k) / f64::from(sections);
        for (r, sign) in [(sheet.radii[1], 1.0), (sheet.radii[0], -1.0)] {
            let outwards = Vector3::new(angle.cos(), angle.sin(), 0.0) * sign;
            for i in 0..=ARC {
                let (sine, cosine) = (PI * f64::from(i) / f64::from(ARC)).sin_cos();
                let normal = outwards * sine + sheet.normal(r, angle) * (cosine * sign);
                outline.add(sheet.position(r, angle) + normal * h);
            }
        }
    }
    let around = 2 * (ARC + 1);
    for k in 0..sections {
        for i in 0..around {
            let [a, b] = [i, (i + 1) % around].map(|it| k * around + it);
            outline.facets.push([a, b, b + around]);
            outline.facets.push([a, b + around, a + around]);
        }
    }
    let last = sections * around;
    for i in 1..around - 1 {
        outline.facets.push([0, i + 1, i]);
        outline.facets.push([last, last + i, last + i + 1]);
    }
    outline
}
