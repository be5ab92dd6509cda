//! The committed points of a body as plain numbers, for a file from which a run goes on.

use crate::body::kinematics::determinant;
use crate::body::points::Points;
use mpm_grid::{Block, Vector};
use mpm_material::SymmetricTensor;

/// Names of the columns that a body's points can have.
pub const COLUMNS: [&str; 11] = [
    "position",
    "reference_position",
    "reference_volume",
    "mass",
    "domain",
    "deformation_gradient",
    "hoop_stretch",
    "angle",
    "elastic_excess",
    "history",
    "plastic",
];

/// One column of the points: `width` numbers per point, point by point.
#[derive(Clone, Debug, PartialEq)]
pub struct StoredColumn {
    /// One of [`COLUMNS`].
    pub name: &'static str,
    /// Numbers per point.
    pub width: usize,
    /// All numbers.
    pub values: Vec<f64>,
}

/// All columns that a body's points have, in the order of [`COLUMNS`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StoredPoints {
    /// Number of points.
    pub points: usize,
    /// The columns; one that the scene does not need is not there.
    pub columns: Vec<StoredColumn>,
}

/// Points that cannot be those of the body.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{column}: {reason}")]
pub struct ForeignPoints {
    /// The column.
    pub column: &'static str,
    /// What is wrong with it, and what was expected.
    pub reason: String,
}

/// Numbers per point of the columns that basis and law decide; no column where there are none.
#[derive(Clone, Copy)]
pub(crate) struct Widths {
    pub domain: usize,
    pub history: usize,
    pub plastic: usize,
}

impl<const D: usize> Points<D> {
    /// Name and numbers per point of every column that these points have.
    pub(crate) fn stored_columns(&self, widths: Widths) -> Vec<(&'static str, usize)> {
        let kept = |is_kept: bool, width| if is_kept { width } else { 0 };
        let widths = [
            D,
            kept(self.kept().reference_position, D),
            1,
            kept(self.kept().mass, 1),
            widths.domain,
            D * D,
            kept(self.space.is_axisymmetric() && D == 2, 1),
            kept(self.space.turns::<D>(), 1),
            6,
            widths.history,
            widths.plastic,
        ];
        COLUMNS.into_iter().zip(widths).filter(|(_, width)| *width > 0).collect()
    }

    /// These points as plain numbers; `others` appends the columns of basis and law.
    pub(crate) fn store(&self, widths: Widths, others: &dyn Fn(&str, &mut Vec<f64>)) -> StoredPoints {
        let column = |(name, width)| {
            let mut values = Vec::with_capacity(width * self.len());
            match name {
                "position" => values.extend(self.position.iter().flat_map(|x| x.iter())),
                "reference_position" => values.extend(self.reference_position.iter().flat_map(|x| x.iter())),
                "reference_volume" => values.extend(&self.reference_volume),
                "mass" => values.extend(&self.mass),
                "domain" | "history" => others(name, &mut values),
                "deformation_gradient" => {
                    values.extend(self.deformation_gradient.iter().flat_map(|f| f.iter()))
                }
                "hoop_stretch" => values.extend(&self.hoop_stretch),
                "angle" => values.extend(&self.angle),
                "elastic_excess" => values.extend(self.elastic_excess.iter().flat_map(components)),
                _ => values.extend(self.plastic.iter().map(|&plastic| f64::from(u8::from(plastic)))),
            }
            StoredColumn { name, width, values }
        };
        StoredPoints {
            points: self.len(),
            columns: self.stored_columns(widths).into_iter().map(column).collect(),
        }
    }

    /// The points that were stored, of a body whose points are `self`.
    ///
    /// # Errors
    /// The first column that is not what [`Self::stored_columns`] says, or holds what no point can be; domains and
    /// histories are numbers, and not looked into.
    pub(crate) fn restore(&self, stored: &StoredPoints, widths: Widths) -> Result<Self, ForeignPoints> {
        let expected = self.stored_columns(widths);
        let wrong = |column, reason: String| ForeignPoints { column, reason };
        let mut next = Self { space: self.space, kept: self.kept(), ..Self::default() };
        for (k, &(name, width)) in expected.iter().enumerate() {
            let column = stored.columns.get(k).filter(|column| column.name == name && column.width == width);
            let column = column.ok_or_else(|| wrong(name, format!("expected {width} numbers per point")))?;
            let (n, values) = (stored.points, &column.values);
            if Some(values.len()) != n.checked_mul(width) {
                return Err(wrong(
                    name,
                    format!("holds {} numbers, expected {width} for each of {n} points", values.len()),
                ));
            }
            if let Some(at) = values.iter().position(|value| !value.is_finite()) {
                let reason = format!("is {} at point {}, expected a finite number", values[at], at / width);
                return Err(wrong(name, reason));
            }
            let rows = || values.chunks_exact(width);
            let above_zero = || match values.iter().position(|value| *value <= 0.0) {
                Some(at) => Err(wrong(name, format!("is {} at point {at}, expected above 0", values[at]))),
                None => Ok(values.clone()),
            };
            let at_point = |p: usize, reason| wrong(name, format!("point {p}: {reason}"));
            match name {
                "position" => {
                    next.position = rows().map(Vector::from_column_slice).collect();
                    let is_off = |x: &Vector<D>| self.space.is_axisymmetric() && x[0] <= 0.0;
                    if let Some(p) = next.position.iter().position(is_off) {
                        let radius = next.position[p][0];
                        return Err(at_point(p, format!("its radius is {radius}, expected above 0")));
                    }
                }
                "reference_position" => {
                    next.reference_position = rows().map(Vector::from_column_slice).collect()
                }
                "reference_volume" => next.reference_volume = above_zero()?,
                "mass" => next.mass = above_zero()?,
                "domain" | "history" => {}
                "deformation_gradient" => {
                    let gradients: Vec<Block<D>> = rows().map(Block::from_column_slice).collect();
                    let inverted = |f: &Block<D>| !(determinant(f) > 0.0 && determinant(f).is_finite());
                    if let Some(p) = gradients.iter().position(inverted) {
                        let value = determinant(&gradients[p]);
                        return Err(at_point(p, format!("its determinant is {value}, expected above 0")));
                    }
                    next.deformation_gradient = gradients;
                }
                "hoop_stretch" => next.hoop_stretch = above_zero()?,
                "angle" => next.angle.clone_from(values),
                "elastic_excess" => next.elastic_excess = rows().map(tensor).collect(),
                _ => {
                    if let Some(p) = values.iter().position(|value| *value != 0.0 && *value != 1.0) {
                        return Err(at_point(p, format!("is {}, expected 0 or 1", values[p])));
                    }
                    next.plastic = values.iter().map(|value| *value == 1.0).collect();
                }
            }
        }
        if stored.columns.len() > expected.len() {
            let strange = stored.columns[expected.len()].name;
            return Err(wrong(strange, "the scene's points have no such column".into()));
        }
        Ok(next)
    }
}

impl StoredPoints {
    /// Numbers of a column; none where the points have no such column.
    pub(crate) fn values(&self, name: &str) -> &[f64] {
        self.columns.iter().find(|column| column.name == name).map_or(&[], |column| &column.values)
    }
}

fn components(tensor: &SymmetricTensor) -> [f64; 6] {
    [tensor.xx, tensor.yy, tensor.zz, tensor.xy, tensor.yz, tensor.zx]
}

fn tensor(from: &[f64]) -> SymmetricTensor {
    SymmetricTensor { xx: from[0], yy: from[1], zz: from[2], xy: from[3], yz: from[4], zx: from[5] }
}
