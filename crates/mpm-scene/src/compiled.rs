//! A model of either space.

use crate::error::SceneError;
use crate::language::{FieldInput, OutputInput};
use mpm_solver::observe::{Field, Observer};
use mpm_solver::{Error, Estimate, Model, NamedBody, State, StateLayout, Summary, estimate, resume, run};

/// A model in the space of its scene.
pub enum Compiled {
    /// Plane strain.
    Plane(Model<2>),
    /// Three dimensions.
    Solid(Model<3>),
}

impl Compiled {
    /// Runs the model, see [`mpm_solver::run`].
    ///
    /// # Errors
    /// As [`mpm_solver::run`].
    pub fn run(&mut self, observer: &mut dyn Observer) -> Result<Summary, Error> {
        match self {
            Compiled::Plane(model) => run(model, observer),
            Compiled::Solid(model) => run(model, observer),
        }
    }

    /// Goes on from a state, see [`mpm_solver::resume`].
    ///
    /// # Errors
    /// As [`mpm_solver::resume`].
    pub fn resume(&mut self, state: &State, observer: &mut dyn Observer) -> Result<Summary, Error> {
        match self {
            Compiled::Plane(model) => resume(model, state, observer),
            Compiled::Solid(model) => resume(model, state, observer),
        }
    }

    /// What the states of a model that has not begun to run look like.
    pub fn state_layout(&self) -> StateLayout {
        match self {
            Compiled::Plane(model) => StateLayout::of(model),
            Compiled::Solid(model) => StateLayout::of(model),
        }
    }

    /// The fields of the points that are recorded.
    ///
    /// # Errors
    /// A field that is named twice, or one that neither points nor the laws of the scene's bodies have, with those that there are.
    pub fn fields(&self, output: &OutputInput) -> Result<Vec<Field>, SceneError> {
        match self {
            Compiled::Plane(model) => fields(&model.bodies, output),
            Compiled::Solid(model) => fields(&model.bodies, output),
        }
    }

    /// All fields that the points have: those of any points, then what their laws remember, each once.
    pub fn known_fields(&self) -> Vec<Field> {
        match self {
            Compiled::Plane(model) => known_fields(&model.bodies),
            Compiled::Solid(model) => known_fields(&model.bodies),
        }
    }

    /// Connects the points at the start and counts, see [`mpm_solver::estimate`].
    ///
    /// # Errors
    /// As [`mpm_solver::estimate`].
    pub fn estimate(&mut self) -> Result<Estimate, Error> {
        match self {
            Compiled::Plane(model) => estimate(model),
            Compiled::Solid(model) => estimate(model),
        }
    }
}

fn known_fields<const D: usize>(bodies: &[NamedBody<D>]) -> Vec<Field> {
    let mut known = Field::OF_POINTS.to_vec();
    for field in bodies.iter().flat_map(|named| named.body.history_fields()).map(Field::from) {
        if !known.contains(&field) {
            known.push(field);
        }
    }
    known
}

/// The fields of bodies' points that are recorded; none of them twice.
pub(crate) fn fields<const D: usize>(
    bodies: &[NamedBody<D>],
    output: &OutputInput,
) -> Result<Vec<Field>, SceneError> {
    let remembered = || bodies.iter().flat_map(|named| named.body.history_fields()).map(Field::from);
    let field = |(k, input): (usize, &FieldInput)| {
        if output.fields[..k].contains(input) {
            return Err(SceneError::new(format!("output.fields[{k}]"), "the field is named twice"));
        }
        let FieldInput::Remembered(name) = input else {
            return Ok(input.of_points().expect("a field of points"));
        };
        remembered().find(|field| as_written(field.name()) == *name).ok_or_else(|| {
            let mut known: Vec<String> = Field::OF_POINTS.map(|field| as_written(field.name())).into();
            known.extend(remembered().map(|field| as_written(field.name())));
            known.dedup();
            let reason = format!("no point has a field `{name}`, expected one of {}", known.join(", "));
            SceneError::new(format!("output.fields[{k}]"), reason)
        })
    };
    output.fields.iter().enumerate().map(field).collect()
}

/// The name of a field as scenes write it: `plastic_strain` is `PlasticStrain`.
pub(crate) fn as_written(name: &str) -> String {
    let word = |word: &str| {
        let mut letters = word.chars();
        letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
    };
    name.split('_').map(word).collect()
}
