//! A model of either space.

use mpm_solver::observe::Observer;
use mpm_solver::{Error, Estimate, Model, State, StateLayout, Summary, estimate, resume, run};

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
