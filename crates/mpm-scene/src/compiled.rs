//! A model of either space.

use crate::error::SceneError;
use crate::language::{ComponentsInput, FieldInput, OutputInput};
use mpm_grid::LoadFraction;
use mpm_solver::observe::{Field, Fields, Observer};
use mpm_solver::{
    Error, Estimate, Model, State, StateLayout, Summary, doubts, estimate, look_at_points, resume, run,
};

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
    /// A field that is named twice, or one that neither points, nor the laws of the scene's bodies, nor its tools have, with
    /// those that there are.
    pub fn fields(&self, output: &OutputInput) -> Result<Vec<Field>, SceneError> {
        match self {
            Compiled::Plane(model) => fields(model, output),
            Compiled::Solid(model) => fields(model, output),
        }
    }

    /// All fields that the points have: those of any points, then what their laws remember and what contributions
    /// know of them, each once.
    pub fn known_fields(&self) -> Vec<Field> {
        match self {
            Compiled::Plane(model) => known_fields(model),
            Compiled::Solid(model) => known_fields(model),
        }
    }

    /// Hands the points on as they are at a load fraction, see [`mpm_solver::look_at_points`].
    pub fn look_at_points<R>(&self, at: LoadFraction, look: impl FnOnce(&dyn Fields) -> R) -> R {
        match self {
            Compiled::Plane(model) => look_at_points(model, at, look),
            Compiled::Solid(model) => look_at_points(model, at, look),
        }
    }

    /// What in the model is probably not meant, see [`mpm_solver::doubts`].
    pub fn doubts(&self) -> Vec<String> {
        match self {
            Compiled::Plane(model) => doubts(model),
            Compiled::Solid(model) => doubts(model),
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

/// What the laws of the bodies remember, then what contributions know of points; each once.
fn further_fields<const D: usize>(model: &Model<D>) -> Vec<Field> {
    let of_laws = model.bodies.iter().flat_map(|named| named.body.history_fields());
    let of_contributions =
        model.contributions.iter().flat_map(|named| named.contribution.point_fields()).map(|it| it.info);
    let mut further = Vec::new();
    for field in of_laws.chain(of_contributions).map(Field::from) {
        if !further.contains(&field) {
            further.push(field);
        }
    }
    further
}

fn known_fields<const D: usize>(model: &Model<D>) -> Vec<Field> {
    Field::OF_POINTS.into_iter().chain(further_fields(model)).collect()
}

/// The fields of points that are recorded; none of them twice.
pub(crate) fn fields<const D: usize>(model: &Model<D>, output: &OutputInput) -> Result<Vec<Field>, SceneError> {
    let is_plane_strain = D == 2 && !model.space().is_axisymmetric();
    if output.components == ComponentsInput::InPlane && !is_plane_strain {
        let reason = "only bodies in plane strain have no other components, expected `All`";
        return Err(SceneError::new("output.components", reason));
    }
    let field = |(k, input): (usize, &FieldInput)| {
        if output.fields[..k].contains(input) {
            return Err(SceneError::new(format!("output.fields[{k}]"), "the field is named twice"));
        }
        let FieldInput::Remembered(name) = input else {
            return Ok(input.of_points().expect("a field of points"));
        };
        further_fields(model).into_iter().find(|field| as_written(field.name()) == *name).ok_or_else(|| {
            let known: Vec<String> =
                known_fields(model).into_iter().map(|field| as_written(field.name())).collect();
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
