//! The field that colours a body.

use crate::drawn::{Drawn, complain};
use crate::error::PictureError;
use mpm_io::component_name;
use mpm_solver::observe::{Field, Space};

/// What colours the body.
pub(crate) struct Colour {
    field: String,
    component: Component,
    /// Name and unit.
    pub(crate) label: String,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Component {
    /// One of the numbers.
    Number(usize),
    /// Root of the sum of squares.
    Norm,
    /// A third of the trace.
    Mean,
    /// Norm of the deviator.
    Deviator,
}

impl Component {
    fn of(self, x: &[f64]) -> f64 {
        let norm = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
        let mean = || (x[0] + x[4] + x[8]) / 3.0;
        match self {
            Component::Number(c) => x[c],
            Component::Norm => norm(x),
            Component::Mean => mean(),
            Component::Deviator => {
                let mut deviator = [0.0; 9];
                deviator.copy_from_slice(x);
                [0, 4, 8].into_iter().for_each(|i| deviator[i] -= mean());
                norm(&deviator)
            }
        }
    }

    /// Components of a field of so many numbers, by name; the first is that of the field's bare name.
    fn all(space: Space, width: usize, is_gradient: bool) -> Vec<(String, Self)> {
        let numbers = (0..width).map(|c| (component_name(space, width, c), Component::Number(c)));
        let named = |name: &str, it| (format!(".{name}"), it);
        let first = match width {
            1 => Vec::new(),
            9 if is_gradient => vec![named("norm", Component::Norm), named("mean", Component::Mean)],
            9 => vec![
                named("deviator", Component::Deviator),
                named("mean", Component::Mean),
                named("norm", Component::Norm),
            ],
            _ => vec![named("norm", Component::Norm)],
        };
        first.into_iter().chain(numbers).collect()
    }
}

impl Colour {
    /// The field that is wanted, or the most telling one of those that are recorded.
    pub(crate) fn of(file: &Drawn, wanted: Option<&str>) -> Result<Option<Self>, PictureError> {
        let mut names = file.results.fields().map_err(complain)?;
        names.retain(|name| name != Field::OUTLINE.name());
        // The default is the first of these that is recorded.
        let telling = [Field::RHO, Field::CAUCHY_STRESS, Field::DISPLACEMENT];
        names
            .sort_by_key(|name| telling.iter().position(|field| field.name() == name).unwrap_or(telling.len()));
        let Some(wanted) = wanted.or(names.first().map(String::as_str)) else { return Ok(None) };
        let (field, of) = wanted.split_at(wanted.find(['.', '[']).unwrap_or(wanted.len()));
        if !names.iter().any(|name| name == field) {
            let recorded = if names.is_empty() { "none".into() } else { names.join(", ") };
            let reason = format!("no field `{field}` is recorded; there are {recorded}");
            return Err(PictureError::of("field", reason));
        }
        let width = file.results.field(field, 0).map_err(complain)?.width();
        let is_gradient = field == Field::DEFORMATION_GRADIENT.name();
        let components = Component::all(file.results.space(), width, is_gradient);
        let found = if of.is_empty() { components.first() } else { components.iter().find(|it| it.0 == of) };
        let Some((name, component)) = found else {
            let names: Vec<&str> = components.iter().map(|it| it.0.as_str()).collect();
            let reason = format!("`{field}` has no component `{of}`; there are {}", names.join(", "));
            return Err(PictureError::of("field", reason));
        };
        let unit = file.results.unit(field).map_err(complain)?;
        let label = format!("{field}{name} [{unit}]");
        Ok(Some(Self { field: field.to_string(), component: *component, label }))
    }

    /// Of every point at a recorded step.
    pub(crate) fn values(&self, file: &Drawn, step: usize) -> Result<Vec<f64>, PictureError> {
        let table = file.results.field(&self.field, step).map_err(complain)?;
        Ok((0..table.len()).map(|point| self.component.of(table.row(point))).collect())
    }
}
