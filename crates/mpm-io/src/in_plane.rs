//! Fields of bodies in plane strain without the components that are zero or equal to others.

use mpm_solver::observe::Field;

/// Which components of a field are stored, and where each of them stands among all.
pub(crate) struct InPlane {
    /// Names of the stored components, as the attribute `components` of the dataset tells them.
    pub(crate) names: &'static str,
    /// Number of all components.
    all: usize,
    /// Places of each stored component among all; the first is the one that is stored.
    places: &'static [&'static [usize]],
}

const VECTOR: InPlane = InPlane { names: "x y", all: 3, places: &[&[0], &[1]] };
const TENSOR: InPlane = InPlane { names: "xx xy yx yy zz", all: 9, places: &[&[0], &[1], &[3], &[4], &[8]] };
const SYMMETRIC: InPlane = InPlane { names: "xx xy yy zz", all: 9, places: &[&[0], &[1, 3], &[4], &[8]] };

impl InPlane {
    /// Of a field; none where all its components are stored.
    pub(crate) fn of(field: Field) -> Option<&'static Self> {
        match field {
            Field::DISPLACEMENT => Some(&VECTOR),
            Field::DEFORMATION_GRADIENT => Some(&TENSOR),
            Field::CAUCHY_STRESS | Field::ELASTIC_STRAIN => Some(&SYMMETRIC),
            _ => None,
        }
    }

    /// By the names of the stored components.
    pub(crate) fn named(names: &str) -> Option<&'static Self> {
        [&VECTOR, &TENSOR, &SYMMETRIC].into_iter().find(|it| it.names == names)
    }

    /// Number of stored components.
    pub(crate) fn width(&self) -> usize {
        self.places.len()
    }

    /// Number of all components.
    pub(crate) fn all(&self) -> usize {
        self.all
    }

    /// The stored components of whole rows.
    pub(crate) fn pick(&self, values: &[f64]) -> Vec<f64> {
        values.chunks_exact(self.all).flat_map(|row| self.places.iter().map(|at| row[at[0]])).collect()
    }

    /// Whole rows of stored components; the others are zero.
    pub(crate) fn expand(&self, stored: &[f64]) -> Vec<f64> {
        let mut values = vec![0.0; stored.len() / self.width() * self.all];
        for (row, stored) in values.chunks_exact_mut(self.all).zip(stored.chunks_exact(self.width())) {
            for (places, value) in self.places.iter().zip(stored) {
                places.iter().for_each(|&place| row[place] = *value);
            }
        }
        values
    }
}
