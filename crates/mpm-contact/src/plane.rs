//! Half spaces.

use crate::bounds::Bounds;
use crate::error::ContactError;
use crate::shape::{Near, Outline, Sample, Shape, unit};
use mpm_grid::{Block, Vector};

/// Everything behind a plane.
#[derive(Clone, Debug, PartialEq)]
pub struct Plane<const D: usize> {
    through: Vector<D>,
    normal: Vector<D>,
    /// Unit vectors in the plane, at right angles; the first D - 1 of them.
    tangents: Vec<Vector<D>>,
}

impl<const D: usize> Plane<D> {
    /// The half space behind the plane through a point `[L]` whose outward normal has the direction `normal`.
    ///
    /// # Errors
    /// `through`, `normal`: a number is not finite, or the normal has no length.
    pub fn new(through: Vector<D>, normal: Vector<D>) -> Result<Self, ContactError> {
        ContactError::unless_finite("through", through.as_slice())?;
        ContactError::unless_finite("normal", normal.as_slice())?;
        let length = ContactError::unless_positive("normal", normal.norm())?;
        let normal = normal / length;
        let mut tangents: Vec<Vector<D>> = Vec::new();
        // Of the axes those that lie closest to the plane, made orthogonal.
        let mut axes: Vec<usize> = (0..D).collect();
        axes.sort_by(|&a, &b| normal[a].abs().total_cmp(&normal[b].abs()));
        for &axis in axes.iter().take(D - 1) {
            let mut tangent = unit::<D>(axis);
            for other in tangents.iter().chain([&normal]) {
                tangent -= other * other.dot(&tangent);
            }
            tangents.push(tangent.normalize());
        }
        Ok(Self { through, normal, tangents })
    }

    fn distance(&self, x: &Vector<D>) -> f64 {
        self.normal.dot(&(x - self.through))
    }

    /// A grid of equal cells over as much of the plane as the box needs: its first place, its steps, their numbers.
    fn grid(&self, spacing: f64, within: &Bounds<D>) -> Option<Grid<D>> {
        if !within.is_finite() || within.corners().all(|x| self.distance(&x) > 0.0) {
            return None;
        }
        let mut grid = Grid { first: self.through, steps: Vec::new(), numbers: Vec::new() };
        for tangent in &self.tangents {
            let places = within.corners().map(|x| tangent.dot(&(x - self.through)));
            let (low, high) = places.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), s| (a.min(s), b.max(s)));
            let number = parts(high - low, spacing);
            grid.first += tangent * low;
            grid.steps.push(tangent * ((high - low) / f64::from(number)));
            grid.numbers.push(number);
        }
        Some(grid)
    }
}

struct Grid<const D: usize> {
    first: Vector<D>,
    steps: Vec<Vector<D>>,
    numbers: Vec<u32>,
}

impl<const D: usize> Grid<D> {
    /// The place at `i` steps one way and `j` the other.
    fn at(&self, i: f64, j: f64) -> Vector<D> {
        self.steps.iter().zip([i, j]).fold(self.first, |x, (step, n)| x + step * n)
    }

    fn number(&self, way: usize) -> u32 {
        self.numbers.get(way).copied().unwrap_or(1)
    }
}

/// Parts of a length, none longer than `spacing`; at most 2^16.
pub(crate) fn parts(length: f64, spacing: f64) -> u32 {
    // A float-to-integer `as` saturates.
    ((length / spacing).ceil() as u32).clamp(1, 1 << 16)
}

impl<const D: usize> Shape<D> for Plane<D> {
    fn near(&self, x: &Vector<D>, reach: f64, out: &mut Vec<Near<D>>) {
        let distance = self.distance(x);
        if distance < reach {
            out.push(Near { distance, normal: self.normal, hessian: Block::zeros(), feature: 0 });
        }
    }

    fn kind(&self) -> &'static str {
        "plane"
    }

    fn bounds(&self) -> Bounds<D> {
        let mut bounds = Bounds::everything();
        // A plane along the axes ends at its surface.
        for d in 0..D {
            if self.normal[d] == 1.0 {
                bounds.to[d] = self.through[d];
            } else if self.normal[d] == -1.0 {
                bounds.from[d] = self.through[d];
            }
        }
        bounds
    }

    fn samples(&self, spacing: f64, within: &Bounds<D>, out: &mut Vec<Sample<D>>) {
        let Some(grid) = self.grid(spacing, within) else { return };
        let area = grid.steps.iter().map(Vector::norm).product();
        for j in 0..grid.number(1) {
            for i in 0..grid.number(0) {
                let position = grid.at(f64::from(i) + 0.5, f64::from(j) + 0.5);
                if within.contains(&position) {
                    out.push(Sample { position, normal: self.normal, area });
                }
            }
        }
    }

    fn outline(&self, _spacing: f64, within: &Bounds<D>) -> Outline<D> {
        let mut outline = Outline::default();
        let Some(grid) = self.grid(f64::INFINITY, within) else { return outline };
        let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(i, j)| grid.at(i, j));
        // The solid lies on the left of a segment and behind a triangle.
        let along = grid.steps.first().copied().unwrap_or_else(Vector::zeros);
        let straight = match grid.steps.get(1) {
            None => self.normal[0] * along[1] - self.normal[1] * along[0] > 0.0,
            Some(up) => {
                let whole = |v: &Vector<D>| nalgebra::Vector3::from_fn(|d, _| if d < D { v[d] } else { 0.0 });
                whole(&along).cross(&whole(up)).dot(&whole(&self.normal)) > 0.0
            }
        };
        let order: [usize; 4] = match (D, straight) {
            (2, true) => [0, 1, 0, 1],
            (2, false) => [1, 0, 0, 1],
            (_, true) => [0, 1, 2, 3],
            (_, false) => [0, 3, 2, 1],
        };
        let numbers: Vec<u32> = order.iter().take(2 * (D - 1)).map(|&c| outline.add(corners[c])).collect();
        if D == 2 {
            outline.facets.push(std::array::from_fn(|k| numbers[k]));
        } else {
            outline.facets.push(std::array::from_fn(|k| numbers[k]));
            outline.facets.push(std::array::from_fn(|k| numbers[[0, 2, 3][k]]));
        }
        outline
    }

    fn thickness(&self) -> f64 {
        f64::INFINITY
    }
}
