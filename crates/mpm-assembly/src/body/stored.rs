//! The committed points of a body as plain numbers, for a file from which a run goes on.

use crate::body::kinematics::determinant;
use crate::body::points::Points;
use mpm_basis::StoredDomain;
use mpm_grid::{Block, Vector};
use mpm_material::{History, Material, SymmetricTensor};

/// Names of the columns that a body's points can have.
pub const COLUMNS: [&str; 9] = [
    "position",
    "reference_position",
    "reference_volume",
    "mass",
    "domain",
    "deformation_gradient",
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

impl<const D: usize, M: Material> Points<D, M> {
    /// Name and numbers per point of every column that these points have, with domains of `domain_width` numbers.
    pub(crate) fn stored_columns(&self, domain_width: usize) -> Vec<(&'static str, usize)> {
        let kept = |is_kept: bool, width| if is_kept { width } else { 0 };
        let widths = [
            D,
            kept(!self.reference_position.is_empty(), D),
            1,
            kept(!self.mass.is_empty(), 1),
            domain_width,
            D * D,
            6,
            M::History::NUMBERS,
            kept(M::PLASTIC, 1),
        ];
        COLUMNS.into_iter().zip(widths).filter(|(_, width)| *width > 0).collect()
    }

    /// These points and their `domains` as plain numbers.
    pub(crate) fn store<Domain: StoredDomain>(&self, domains: &[Domain]) -> StoredPoints {
        let column = |(name, width)| {
            let mut values = Vec::with_capacity(width * self.len());
            match name {
                "position" => values.extend(self.position.iter().flat_map(|x| x.iter())),
                "reference_position" => values.extend(self.reference_position.iter().flat_map(|x| x.iter())),
                "reference_volume" => values.extend(&self.reference_volume),
                "mass" => values.extend(&self.mass),
                "domain" => domains.iter().for_each(|domain| domain.store(&mut values)),
                "deformation_gradient" => {
                    values.extend(self.deformation_gradient.iter().flat_map(|f| f.iter()))
                }
                "elastic_excess" => values.extend(self.elastic_excess.iter().flat_map(components)),
                "history" => self.history.iter().for_each(|history| history.store(&mut values)),
                _ => values.extend(self.plastic.iter().map(|&plastic| f64::from(u8::from(plastic)))),
            }
            StoredColumn { name, width, values }
        };
        StoredPoints {
            points: self.len(),
            columns: self.stored_columns(Domain::NUMBERS).into_iter().map(column).collect(),
        }
    }

    /// The points that were stored, of a body whose points are `self`, with domains of `domain_width` numbers.
    ///
    /// # Errors
    /// The first column that is not what [`Self::stored_columns`] says, or holds what no point can be; domains are
    /// not looked into.
    pub(crate) fn restore(&self, stored: &StoredPoints, domain_width: usize) -> Result<Self, ForeignPoints> {
        let expected = self.stored_columns(domain_width);
        let wrong = |column, reason: String| ForeignPoints { column, reason };
        let mut next = Self::default();
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
                "position" => next.position = rows().map(Vector::from_column_slice).collect(),
                "reference_position" => {
                    next.reference_position = rows().map(Vector::from_column_slice).collect()
                }
                "reference_volume" => next.reference_volume = above_zero()?,
                "mass" => next.mass = above_zero()?,
                "domain" => {}
                "deformation_gradient" => {
                    let gradients: Vec<Block<D>> = rows().map(Block::from_column_slice).collect();
                    let inverted = |f: &Block<D>| !(determinant(f) > 0.0 && determinant(f).is_finite());
                    if let Some(p) = gradients.iter().position(inverted) {
                        let value = determinant(&gradients[p]);
                        return Err(at_point(p, format!("its determinant is {value}, expected above 0")));
                    }
                    next.deformation_gradient = gradients;
                }
                "elastic_excess" => next.elastic_excess = rows().map(tensor).collect(),
                "history" => {
                    let histories = rows().map(M::History::restore).enumerate();
                    let histories = histories.map(|(p, history)| history.map_err(|reason| at_point(p, reason)));
                    next.history = histories.collect::<Result<_, _>>()?;
                }
                _ => {
                    if let Some(p) = values.iter().position(|value| *value != 0.0 && *value != 1.0) {
                        return Err(at_point(p, format!("is {}, expected 0 or 1", values[p])));
                    }
                    next.plastic = values.iter().map(|value| *value == 1.0).collect();
                }
            }
        }
        if M::History::NUMBERS == 0 {
            let history = M::History::restore(&[]).map_err(|reason| wrong("history", reason))?;
            next.history = vec![history; stored.points];
        }
        if stored.columns.len() > expected.len() {
            let strange = stored.columns[expected.len()].name;
            return Err(wrong(strange, "the scene's points have no such column".into()));
        }
        Ok(next)
    }
}

/// The domains that were stored with points whose columns are as expected.
///
/// # Errors
/// The first point whose numbers are no domain.
pub(crate) fn restore_domains<Domain: StoredDomain>(
    stored: &StoredPoints,
) -> Result<Vec<Domain>, ForeignPoints> {
    let values = stored.columns.iter().find(|column| column.name == "domain").map_or(&[][..], |it| &it.values);
    let restore = |p: usize| {
        let domain = Domain::recall(&values[p * Domain::NUMBERS..(p + 1) * Domain::NUMBERS]);
        domain.map_err(|reason| ForeignPoints { column: "domain", reason: format!("point {p}: {reason}") })
    };
    (0..stored.points).map(restore).collect()
}

fn components(tensor: &SymmetricTensor) -> [f64; 6] {
    [tensor.xx, tensor.yy, tensor.zz, tensor.xy, tensor.yz, tensor.zx]
}

fn tensor(from: &[f64]) -> SymmetricTensor {
    SymmetricTensor { xx: from[0], yy: from[1], zz: from[2], xy: from[3], yz: from[4], zx: from[5] }
}
