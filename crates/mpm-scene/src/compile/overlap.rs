//! Bodies that would fill the same space.

use super::mesh::plane_point;
use super::shapes::WithSurface;
use crate::language::{BodyInput, Coordinates, Direction, Finite, PlanePoint, ShapeInput};
use mpm_geometry::{Prism, Surface};

/// What a body covers.
enum Cover<'a, const D: usize> {
    Box {
        from: &'a [f64; D],
        to: &'a [f64; D],
    },
    /// All between two radii around an axis, and between two ends.
    Round {
        axis: Direction,
        centre: [f64; 2],
        radii: [f64; 2],
        ends: [f64; 2],
    },
    Ball {
        centre: &'a [f64; D],
        radius: f64,
    },
    Surface(&'a Surface),
    Prism(&'a Prism),
}

/// A body with its shape.
type Placed<'a, const D: usize> = (&'a BodyInput<D>, &'a WithSurface<'a, D>);

/// Whether two bodies cover the same space, and neither is cut out of the other. Points, surfaces beside others than
/// boxes, polygons beside round bodies, round bodies whose axes differ, spheres beside them, and bodies that are `turned` in
/// space are left to the user.
pub(super) fn overlap<const D: usize>((a, of_a): Placed<'_, D>, (b, of_b): Placed<'_, D>) -> bool {
    if a.turned.is_some() || b.turned.is_some() {
        return false;
    }
    let (Some(first), Some(second)) = (Cover::of(of_a), Cover::of(of_b)) else { return false };
    match (&first, &second) {
        (Cover::Box { from: a0, to: a1 }, Cover::Box { from: b0, to: b1 }) => {
            (0..D).all(|d| common([a0[d], a1[d]], [b0[d], b1[d]]))
        }
        (_, Cover::Box { from, to }) => !is_cut_out(a, b) && first.meets_box(from, to),
        (Cover::Box { from, to }, _) => !is_cut_out(b, a) && second.meets_box(from, to),
        (
            Cover::Round { axis, centre, radii, ends },
            Cover::Round { axis: other_axis, centre: other_centre, radii: other_radii, ends: other_ends },
        ) => {
            // Distances of the first's points from the axis of the second.
            let [dx, dy] = [0, 1].map(|k| centre[k] - other_centre[k]);
            let apart = dx.hypot(dy);
            let nearest = (apart - radii[1]).max(radii[0] - apart).max(0.0);
            axis == other_axis
                && common(*ends, *other_ends)
                && common([nearest, apart + radii[1]], *other_radii)
        }
        (Cover::Ball { centre, radius }, Cover::Ball { centre: other, radius: others }) => {
            let apart = (0..D).map(|d| (centre[d] - other[d]).powi(2)).sum::<f64>().sqrt();
            apart < (radius + others) * (1.0 - 1e-9)
        }
        (Cover::Prism(one), Cover::Prism(other)) => one.overlaps(other),
        _ => false,
    }
}

/// Whether a box leaves out another body.
fn is_cut_out<const D: usize>(body: &BodyInput<D>, of: &BodyInput<D>) -> bool {
    matches!(&of.shape, ShapeInput::Box { without, .. } if without.contains(&body.name))
}

/// Whether two intervals share more than what rounding can make them share.
fn common(a: [f64; 2], b: [f64; 2]) -> bool {
    a[1].min(b[1]) - a[0].max(b[0]) > 1e-9 * (a[1] - a[0]).abs().min((b[1] - b[0]).abs()).min(f64::MAX)
}

impl<'a, const D: usize> Cover<'a, D> {
    fn of(placed: &'a WithSurface<'a, D>) -> Option<Self> {
        let round = |axis, centre: &PlanePoint, radii, extent: Option<(Finite, Finite)>| {
            let ends = extent.map_or([f64::NEG_INFINITY, f64::INFINITY], |(from, to)| [from.0, to.0]);
            Some(Self::Round { axis, centre: plane_point(centre), radii, ends })
        };
        match placed.shape {
            ShapeInput::Box { from: Coordinates(from), to: Coordinates(to), turned, .. } => {
                match &placed.prism {
                    Some(turned_box) if turned.0 != 0.0 => Some(Self::Prism(turned_box)),
                    _ => Some(Self::Box { from, to }),
                }
            }
            ShapeInput::Ring { centre, inner, outer, .. } => {
                round(Direction::Z, centre, [inner.0, outer.0], None)
            }
            ShapeInput::Cylinder { axis, centre, radius, extent } => {
                round(*axis, centre, [0.0, radius.0], *extent)
            }
            ShapeInput::Tube { axis, centre, inner, outer, extent, .. } => {
                round(*axis, centre, [inner.0, outer.0], *extent)
            }
            ShapeInput::Sphere { centre: Coordinates(centre), radius } => {
                Some(Self::Ball { centre, radius: radius.0 })
            }
            ShapeInput::Surface { .. } => placed.surface.as_ref().map(Self::Surface),
            ShapeInput::Polygon { .. } => placed.prism.as_ref().map(Self::Prism),
            ShapeInput::Points { .. } => None,
        }
    }

    /// Whether what is not a box itself has something in common with one.
    fn meets_box(&self, from: &[f64; D], to: &[f64; D]) -> bool {
        match self {
            Self::Box { .. } => false,
            Self::Round { axis, centre, radii, ends } => {
                let along = axis.index();
                // The distances of the box's points from the axis are all from the nearest one's to the farthest one's.
                let (mut nearest, mut farthest) = (0.0_f64, 0.0_f64);
                for (d, centre) in (0..D).filter(|&d| d != along).zip(centre) {
                    nearest = nearest.hypot((from[d] - centre).max(centre - to[d]).max(0.0));
                    farthest = farthest.hypot((from[d] - centre).abs().max((to[d] - centre).abs()));
                }
                (along >= D || common(*ends, [from[along], to[along]])) && common([nearest, farthest], *radii)
            }
            Self::Ball { centre, radius } => {
                let away = |d: usize| (from[d] - centre[d]).max(centre[d] - to[d]).max(0.0);
                let nearest = (0..D).map(|d| away(d) * away(d)).sum::<f64>().sqrt();
                nearest < radius * (1.0 - 1e-9)
            }
            // Files have single precision.
            Self::Surface(surface) => {
                let (from, to, volume) = in_space(from, to);
                surface.volume_in(&from, &to) > 1e-6 * surface.volume().min(volume)
            }
            Self::Prism(prism) => {
                let (from, to, volume) = in_space(from, to);
                prism.volume_in(&from, &to) > 1e-9 * prism.volume().min(volume)
            }
        }
    }
}

/// A box in space, in the plane of thickness 1, and its volume.
fn in_space<const D: usize>(from: &[f64; D], to: &[f64; D]) -> ([f64; 3], [f64; 3], f64) {
    let [from, to] = [(from, 0.0), (to, 1.0)]
        .map(|(x, end)| std::array::from_fn::<f64, 3, _>(|d| x.get(d).copied().unwrap_or(end)));
    let volume = (0..3).map(|d| to[d] - from[d]).product();
    (from, to, volume)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::language::{Scene, SceneIn, SolidBasis};

    /// Whether the second of two bodies overlaps the first.
    fn overlaps(first: &str, second: &str) -> bool {
        let text = format!(
            "Solid(mesh: Box(axes: []), basis: Smpm, materials: {{}}, schedule: (steps: 1), bodies: [
                (name: \"a\", material: \"m\", shape: {first}), (name: \"b\", material: \"m\", shape: {second}),
            ])"
        );
        let Scene::Solid(SceneIn::<3, SolidBasis> { bodies, .. }) = Scene::from_ron(&text).unwrap() else {
            panic!("a solid")
        };
        let [a, b] = [&bodies[0], &bodies[1]];
        let placed =
            [a, b].map(|body| WithSurface { shape: &body.shape, surface: None, prism: None, open: [false; 3] });
        overlap((a, &placed[0]), (b, &placed[1]))
    }

    #[test]
    fn what_only_touches_does_not_overlap() {
        let pile = "Cylinder(centre: (0, 0), radius: 1, extent: (0, 2))";
        let block = |x: f64, z: f64| format!("Box(from: ({x}, -1, {z}), to: (3, 1, {}))", z + 1.0);
        assert!(overlaps(pile, &block(0.9, 0.0)) && overlaps(&block(0.9, 0.0), pile));
        assert!(!overlaps(pile, &block(1.0, 0.0)) && !overlaps(pile, &block(0.9, 2.0)));
        // Near a corner.
        assert!(!overlaps(pile, "Box(from: (0.8, 0.8, 0), to: (3, 3, 1))"));
        assert!(overlaps(pile, "Box(from: (0.7, 0.7, 0), to: (3, 3, 1))"));
        // In the hole of a tube, across its wall, round it.
        let tube = "Tube(centre: (0, 0), inner: 1, outer: 2)";
        assert!(!overlaps(tube, "Box(from: (-0.5, -0.5, 0), to: (0.5, 0.5, 1))"));
        assert!(overlaps(tube, "Box(from: (-0.5, -0.5, 0), to: (1.1, 0.5, 1))"));
        assert!(overlaps(tube, "Box(from: (-5, -5, 0), to: (5, 5, 1))"));
        assert!(!overlaps(tube, pile) && !overlaps(pile, tube));
        assert!(!overlaps(tube, "Tube(centre: (0, 0), inner: 2, outer: 3)"));
        assert!(overlaps(tube, "Tube(centre: (0.5, 0), inner: 2, outer: 3)"));
        assert!(!overlaps(tube, "Cylinder(centre: (0.2, 0), radius: 0.7)"));
        assert!(overlaps(tube, "Cylinder(centre: (0.4, 0), radius: 0.7)"));
        assert!(!overlaps("Cylinder(centre: (9, 0), radius: 0.7)", tube));
        assert!(overlaps("Cylinder(centre: (1.5, 0), radius: 0.1)", tube));
    }

    #[test]
    fn what_is_cut_out_does_not_overlap() {
        let pile = "Cylinder(centre: (0, 0), radius: 1)";
        assert!(overlaps(pile, "Box(from: (-2, -2, 0), to: (2, 2, 1))"));
        assert!(!overlaps(pile, "Box(from: (-2, -2, 0), to: (2, 2, 1), without: [\"a\"])"));
    }
}
