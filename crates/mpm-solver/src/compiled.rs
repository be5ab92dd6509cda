//! Runs in the plane and in space, compiled once, in this crate.
//!
//! A generic function is compiled anew by every crate that calls it, here with all of the solver. Only models of other
//! dimensions are.

use crate::error::Error;
use crate::estimate::Estimate;
use crate::model::Model;
use crate::observe::Observer;
use crate::record::summary::Summary;
use crate::state::State;
use std::any::Any;

/// The same model by its number of dimensions, which is E.
fn of<const D: usize, const E: usize>(model: &mut Model<D>) -> &mut Model<E> {
    let model: &mut dyn Any = model;
    model.downcast_mut().expect("E is asked for where D is E")
}

macro_rules! compiled_here {
    ($(#[$doc:meta])* $name:ident($($argument:ident: $type:ty),*) -> $result:ty, $generic:path) => {
        $(#[$doc])*
        pub fn $name<const D: usize>(model: &mut Model<D>, $($argument: $type),*) -> $result {
            #[inline(never)]
            fn plane(model: &mut Model<2>, $($argument: $type),*) -> $result {
                $generic(model, $($argument),*)
            }
            #[inline(never)]
            fn solid(model: &mut Model<3>, $($argument: $type),*) -> $result {
                $generic(model, $($argument),*)
            }
            // What a constant rules out is not compiled.
            if const { D == 2 } {
                plane(of(model), $($argument),*)
            } else if const { D == 3 } {
                solid(of(model), $($argument),*)
            } else {
                $generic(model, $($argument),*)
            }
        }
    };
}

compiled_here! {
    /// Runs a model through its load steps.
    ///
    /// A step that cannot be solved is halved. At the shortest step length it is tried again with relaxation: the
    /// unbalanced forces are released in parts. Domains that have grown too long for their cells are shortened or split
    /// after a step, where the model asks for it.
    ///
    /// # Errors
    /// [`Error::Step`] where a step fails at its smallest length, [`Error::TooManyPoints`] where domains
    /// would be split into too many, [`Error::Observer`] where the record cannot be written. All load steps before have been shown to the observer.
    run(observer: &mut dyn Observer) -> Result<Summary, Error>, crate::run::run
}

compiled_here! {
    /// As [`run`], from a state of an earlier run of the same model on. What follows is bit for bit what would
    /// have followed there.
    ///
    /// # Errors
    /// [`Error::State`] where the state is none of the model; else as [`run`].
    resume(state: &State, observer: &mut dyn Observer) -> Result<Summary, Error>, crate::run::resume
}

compiled_here! {
    /// Connects the points of a model at the start and counts.
    ///
    /// # Errors
    /// [`Error::Start`] where the mesh of the first step cannot be placed or does not cover the points,
    /// [`Error::TooLarge`] where not even the structure of the factor fits into memory.
    estimate() -> Result<Estimate, Error>, crate::estimate::estimate
}
