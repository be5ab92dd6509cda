//! How points begin: their own parameters, and the stress that they are under.

use super::law::{Refusal, Refused, Site, cam_clay, place};
use super::parameters::{density, fields_of, of_points};
use super::quantity::{Fields, check_layers, integral};
use crate::error::SceneError;
use crate::files::{NamedColumns, SceneFiles};
use crate::fill::Density;
use crate::language::{InitialInput, MaterialInput, PointField, Positive, Quantity};
use mpm_assembly::{PointStart, Space};
use mpm_material::{Consolidation, SymmetricTensor};
use nalgebra::Vector3;

/// What decides how the points of a body begin.
#[derive(Clone, Copy)]
pub(crate) struct Beginning<'a> {
    pub law: &'a MaterialInput,
    pub initial: Option<&'a InitialInput>,
    pub files: &'a dyn SceneFiles,
}

/// How every point begins, and the point whose parameters the law of the body has.
pub(super) struct Starts {
    /// Empty where points begin without stress and without parameters of their own.
    pub points: Vec<PointStart>,
    /// Whether points have parameters of their own.
    pub has_own: bool,
    pub stiffest: usize,
    pub density: Option<Density>,
}

/// Refuses what needs no point to be known as wrong; `path` is the body's.
pub(super) fn check(
    input: &InitialInput,
    law: &MaterialInput,
    dimensions: usize,
    path: &str,
) -> Result<(), SceneError> {
    let refuse = |field: &str, reason: &str| Err(SceneError::new(format!("{path}.initial{field}"), reason));
    match input {
        InitialInput::Geostatic { unit_weight, k0, over_consolidation, surcharge, .. } => {
            for (name, quantity) in [
                (".unit_weight", Some(unit_weight)),
                (".k0", Some(k0)),
                (".over_consolidation", over_consolidation.as_ref()),
            ] {
                if let Some(Quantity::Field(PointField::Layers(layers))) = quantity {
                    check_layers(layers).map_err(|it| SceneError::new(format!("{path}.initial{name}"), it))?;
                }
            }
            if let Quantity::Field(field @ (PointField::Table { .. } | PointField::Random { .. })) = unit_weight
            {
                integral(field, 0.0, 0.0)
                    .map_err(|it| SceneError::new(format!("{path}.initial.unit_weight"), it))?;
            }
            if surcharge.0 < 0.0 {
                return refuse(".surcharge", "expected a pressure of at least 0");
            }
            if over_consolidation.is_some() && !matches!(law, MaterialInput::CamClay { .. }) {
                return refuse(
                    ".over_consolidation",
                    "the law of the body remembers no consolidation; only `CamClay` does",
                );
            }
            if over_consolidation.as_ref().and_then(Quantity::number).is_some_and(|ratio| ratio < 1.0) {
                return refuse(".over_consolidation", "expected a ratio of at least 1");
            }
        }
        InitialInput::Stress { yz, zx, .. } => {
            if dimensions == 2 && (yz.0 != 0.0 || zx.0 != 0.0) {
                return refuse("", "σ_yz and σ_zx are zero in the plane");
            }
        }
        InitialInput::Table { .. } => {}
    }
    Ok(())
}

/// How the points at `positions` begin.
///
/// # Errors
/// What a field, a table or a law says of the first point that cannot.
pub(super) fn starts<const D: usize>(
    beginning: &Beginning<'_>,
    positions: &[[f64; D]],
) -> Result<Starts, Refusal> {
    let fields = Fields::new(beginning.files);
    let has_own = !fields_of(beginning.law).is_empty();
    let density = density(beginning.law, &fields, positions).map_err(Refusal::Law)?;
    if !has_own && beginning.initial.is_none() {
        return Ok(Starts { points: Vec::new(), has_own, stiffest: 0, density });
    }
    let mut starts = vec![PointStart::default(); positions.len()];
    let mut stiffest = 0;
    if has_own {
        let own = of_points(beginning.law, &fields, positions).map_err(Refusal::Law)?;
        stiffest = own.stiffest;
        for (start, own) in starts.iter_mut().zip(&own.points) {
            start.own = Some(own.own);
            start.consolidation = own.preconsolidation.map_or(Consolidation::OfLaw, Consolidation::Pressure);
        }
    }
    if let Some(initial) = beginning.initial {
        let stress = Stress { initial, law: beginning.law, fields: &fields };
        for (start, position) in starts.iter_mut().zip(positions) {
            let refuse =
                |reason: String| Refusal::Initial(format!("at the point {}: {reason}", place(position)));
            stress.begin(start, position).map_err(refuse)?;
        }
    }
    Ok(Starts { points: starts, has_own, stiffest, density })
}

struct Stress<'a> {
    initial: &'a InitialInput,
    law: &'a MaterialInput,
    fields: &'a Fields<'a>,
}

impl Stress<'_> {
    fn begin(&self, start: &mut PointStart, x: &[f64]) -> Result<(), String> {
        match self.initial {
            InitialInput::Geostatic { surface, unit_weight, k0, surcharge, over_consolidation } => {
                let height = x[x.len() - 1];
                if height > surface.0 {
                    return Err(format!("it lies above the surface at {}", surface.0));
                }
                let weight = match unit_weight {
                    Quantity::Number(weight) => weight.0 * (surface.0 - height),
                    Quantity::Field(field) => integral(field, height, surface.0)?,
                };
                let vertical = -(weight + surcharge.0);
                let k0 = self.value(k0, x)?;
                start.stress = Some(at_rest(vertical, k0, x.len()));
                if let Some(ratio) = over_consolidation {
                    let ratio = self.value(ratio, x)?;
                    let own = self.k0_of_law(x)?;
                    let past = ratio * vertical;
                    start.consolidation = Consolidation::Stress(Vector3::new(own * past, past, own * past));
                }
            }
            &InitialInput::Stress { xx, yy, zz, xy, yz, zx } => {
                let [xx, yy, zz, xy, yz, zx] = [xx, yy, zz, xy, yz, zx].map(f64::from);
                start.stress = Some(SymmetricTensor { xx, yy, zz, xy, yz, zx });
            }
            InitialInput::Table { file } => {
                let (stress, pressure) = self.fields.with_table(file, |table| row(table, x))??;
                start.stress = Some(stress);
                if let Some(pressure) = pressure {
                    start.consolidation = Consolidation::Pressure(pressure);
                }
            }
        }
        Ok(())
    }

    fn value(&self, quantity: &Quantity<Positive>, x: &[f64]) -> Result<f64, String> {
        match quantity {
            Quantity::Number(number) => Ok(number.0),
            Quantity::Field(field) => self.fields.at(field, x),
        }
    }

    fn k0_of_law(&self, x: &[f64]) -> Result<f64, String> {
        let site = Site { fields: self.fields, position: x };
        let law = cam_clay(self.law, Some(site)).map_err(Refused::into_reason)?;
        Ok(law.k0())
    }
}

/// σ_v along the last axis of `dimensions`, K₀ σ_v along the others.
fn at_rest(vertical: f64, k0: f64, dimensions: usize) -> SymmetricTensor {
    let lateral = k0 * vertical;
    let (yy, zz) = if dimensions == 2 { (vertical, lateral) } else { (lateral, vertical) };
    SymmetricTensor { xx: lateral, yy, zz, ..SymmetricTensor::ZERO }
}

/// Stress and p_c, if there is one, in the row nearest to `x`.
fn row(table: &NamedColumns, x: &[f64]) -> Result<(SymmetricTensor, Option<f64>), String> {
    let row = table.nearest(x)?;
    let at = |name: &str| table.column(name).map(|column| column[row]);
    let in_space = |name: &str| if x.len() == 3 { at(name) } else { Ok(0.0) };
    let stress = SymmetricTensor {
        xx: at("sxx")?,
        yy: at("syy")?,
        zz: at("szz")?,
        xy: at("sxy")?,
        yz: in_space("syz")?,
        zx: in_space("szx")?,
    };
    let pressure = if table.has("preconsolidation") { Some(at("preconsolidation")?) } else { None };
    if pressure.is_some_and(|pressure| pressure <= 0.0) {
        return Err(format!(
            "{}: the preconsolidation is {}, expected above 0",
            table.file,
            at("preconsolidation")?
        ));
    }
    Ok((stress, pressure))
}

/// What a body says of a point that its law does not let begin under its stress.
pub(super) fn refused(
    initial: Option<&InitialInput>,
    (stress, space): (&SymmetricTensor, Space),
    position: &[f64],
    reason: &str,
) -> String {
    let depth = match initial {
        Some(InitialInput::Geostatic { surface, .. }) => {
            format!(", {} below the surface,", surface.0 - position[position.len() - 1])
        }
        _ => String::new(),
    };
    let (SymmetricTensor { xx, yy, zz, .. }, [a, b, c]) = (*stress, space.axes());
    format!(
        "the point {}{depth} cannot begin under the stress σ_{a}{a} = {xx}, σ_{b}{b} = {yy}, σ_{c}{c} = {zz}: {reason}",
        place(position)
    )
}
