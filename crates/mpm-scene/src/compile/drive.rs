//! One material point along its path.

use super::law::{WithLaw, fields_of, with_law};
use crate::error::SceneError;
use crate::language::{DriveInput, PointControlInput, SegmentInput};
use mpm_assembly::ShippedLaw;
use mpm_material::{
    Control, DrivenPoint, Material, PerPoint, PointParameters, StepControl, SymmetricTensor, Undrained, Varied,
    invariants,
};
use nalgebra::Vector3;

/// A path as a table.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DrivenPath {
    /// Names of the columns: `step`, `segment`, F and J, Cauchy stresses, p and q, what the law remembers, `plastic`.
    pub columns: Vec<String>,
    /// Units of the columns.
    pub units: Vec<&'static str>,
    /// One row per step, the first is the start.
    pub rows: Vec<Vec<f64>>,
    /// Why the path ends before its end, if it does.
    pub stopped: Option<String>,
}

impl DrivenPath {
    /// The numbers of a column; none where there is no such column.
    pub fn column(&self, name: &str) -> Vec<f64> {
        let place = self.columns.iter().position(|column| column == name);
        place.map_or(Vec::new(), |place| self.rows.iter().map(|row| row[place]).collect())
    }
}

/// Drives a point along its path. A point that its law does not lead on ends the path early.
///
/// # Errors
/// What the law says of its parameters, or of the stress at the start; with its path in the text.
pub fn drive(input: &DriveInput) -> Result<DrivenPath, SceneError> {
    if let Some((name, _)) = fields_of(&input.law).first() {
        return Err(SceneError::new(format!("law.{name}"), "expected a number: one point needs no field"));
    }
    if input.path.is_empty() {
        return Err(SceneError::new("path", "expected at least one segment"));
    }
    struct Along<'a>(&'a DriveInput);
    impl WithLaw for Along<'_> {
        type Answer = Result<DrivenPath, SceneError>;

        fn with<M: Varied + Into<ShippedLaw>>(self, law: M, fluid: Option<f64>) -> Self::Answer {
            match fluid {
                None => along(self.0, &law),
                Some(bulk) => {
                    let law = Undrained::new(PerPoint::new(law), bulk).expect("a positive bulk modulus");
                    along(self.0, &law)
                }
            }
        }
    }
    with_law(&input.law, None, Along(input)).map_err(|refused| refused.at("law"))?
}

fn along<M: Material>(input: &DriveInput, law: &M) -> Result<DrivenPath, SceneError> {
    let (s1, s2, s3) = input.stress;
    let stress = SymmetricTensor { xx: s1.0, yy: s2.0, zz: s3.0, ..SymmetricTensor::ZERO };
    let begin = |it| SceneError::new("stress", format!("the point cannot begin under this stress: {it}"));
    let mut point = DrivenPoint::new(law, &PointParameters::at(Vector3::zeros()), &stress).map_err(begin)?;
    let fields = law.history_fields();
    let known = [
        ("step", "-"),
        ("segment", "-"),
        ("f11", "-"),
        ("f12", "-"),
        ("f22", "-"),
        ("f33", "-"),
        ("j", "-"),
        ("s11", "F/L²"),
        ("s22", "F/L²"),
        ("s33", "F/L²"),
        ("s12", "F/L²"),
        ("p", "F/L²"),
        ("q", "F/L²"),
    ];
    let named = known.into_iter().chain(fields.iter().map(|field| (field.name, field.unit)));
    let (columns, units) = named.chain([("plastic", "-")]).map(|(name, unit)| (name.to_string(), unit)).unzip();
    let mut path = DrivenPath { columns, units, rows: vec![row(&point, 0, 0)], stopped: None };
    let mut taken = 0;
    for (k, segment) in input.path.iter().enumerate() {
        let start = *point.stress();
        for step in 1..=segment.steps() {
            if let Err(reason) = point.step(&control(segment, &start, step)) {
                path.stopped = Some(format!("path[{k}] ends at step {step} of {}: {reason}", segment.steps()));
                return Ok(path);
            }
            taken += 1;
            path.rows.push(row(&point, taken, k));
        }
    }
    Ok(path)
}

/// What step `step` of a segment does that began under the stress `start`.
fn control(segment: &SegmentInput, start: &SymmetricTensor, step: u32) -> StepControl {
    use Control::{Strain, Stress};
    let count = f64::from(segment.steps());
    let kept = Strain(0.0);
    match *segment {
        SegmentInput::Isotropic { by, .. } => {
            [Strain(by.0 / count), Strain(by.0 / count), Strain(by.0 / count), kept]
        }
        SegmentInput::Oedometer { by, .. } => [Strain(by.0 / count), kept, kept, kept],
        SegmentInput::Triaxial { by, .. } => [Strain(by.0 / count), Stress(start.yy), Stress(start.zz), kept],
        SegmentInput::UndrainedTriaxial { by, .. } => {
            let lateral = Strain(-0.5 * by.0 / count);
            [Strain(by.0 / count), lateral, lateral, kept]
        }
        SegmentInput::PlaneStrain { by, .. } => [Strain(by.0 / count), Strain(-by.0 / count), kept, kept],
        SegmentInput::SimpleShear { by, .. } => [kept, kept, kept, Strain(by.0 / count)],
        SegmentInput::DirectShear { by, .. } => [kept, Stress(start.yy), kept, Strain(by.0 / count)],
        SegmentInput::Mixed { axis_1, axis_2, axis_3, shear, .. } => {
            let part = f64::from(step) / count;
            let of = |input: PointControlInput, from: f64| match input {
                PointControlInput::Strain(by) => Strain(by.0 / count),
                PointControlInput::Stress(to) => Stress(from + part * (to.0 - from)),
            };
            [of(axis_1, start.xx), of(axis_2, start.yy), of(axis_3, start.zz), of(shear, start.xy)]
        }
    }
}

fn row<M: Material>(point: &DrivenPoint<'_, M>, step: u32, segment: usize) -> Vec<f64> {
    let (f, stress) = (point.deformation(), point.stress());
    let (p, q) = invariants(stress);
    let mut row = vec![f64::from(step), segment as f64];
    row.extend([f[(0, 0)], f[(0, 1)], f[(1, 1)], f[(2, 2)], f.determinant()]);
    row.extend([stress.xx, stress.yy, stress.zz, stress.xy, p, q]);
    row.extend(point.history());
    row.push(f64::from(u8::from(point.is_plastic())));
    row
}
