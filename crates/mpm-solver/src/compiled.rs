//! Runs in the plane and in space, compiled once, in this crate.
//!
//! A generic function is compiled anew by every crate that calls it, here with all of the solver. Only models of other
//! dimensions are.

use crate::error::Error;
use crate::estimate::Estimate;
use crate::model::Model;
use crate::observe::Observer;
use crate::ranks::{Alone, Ranks};
use crate::record::summary::Summary;
use crate::state::State;
use std::any::Any;
use std::rc::Rc;

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
    run(observer: &mut dyn Observer) -> Result<Summary, Error>, alone
}

compiled_here! {
    /// As [`run`], from a state of an earlier run of the same model on. What follows is bit for bit what would
    /// have followed there.
    ///
    /// # Errors
    /// [`Error::State`] where the state is none of the model; else as [`run`].
    resume(state: &State, observer: &mut dyn Observer) -> Result<Summary, Error>, resume_alone
}

compiled_here! {
    /// Connects the points of a model at the start and counts.
    ///
    /// # Errors
    /// [`Error::Start`] where the mesh of the first step cannot be placed or does not cover the points,
    /// [`Error::TooLarge`] where not even the structure of the factor fits into memory.
    estimate() -> Result<Estimate, Error>, crate::estimate::estimate
}

fn alone<const D: usize>(model: &mut Model<D>, observer: &mut dyn Observer) -> Result<Summary, Error> {
    crate::run::run(model, Rc::new(Alone), observer)
}

fn resume_alone<const D: usize>(
    model: &mut Model<D>,
    state: &State,
    observer: &mut dyn Observer,
) -> Result<Summary, Error> {
    crate::run::resume(model, Rc::new(Alone), state, observer)
}

/// The same ranks by their number of dimensions, which is E.
fn ranks_of<const D: usize, const E: usize>(ranks: Rc<dyn Ranks<D>>) -> Rc<dyn Ranks<E>> {
    let ranks: Box<dyn Any> = Box::new(ranks);
    *ranks.downcast().expect("E is asked for where D is E")
}

/// As [`run`], of a model that several ranks share: each calls it with the same model, see [`Ranks::divide`], and with an
/// observer of its own, which sees the points of the rank and the history of all.
///
/// # Errors
/// As [`run`], the same on all ranks, but for what one rank's observer refuses; [`Error::Ranks`] where the ranks cannot share
/// the model.
pub fn run_on<const D: usize>(
    model: &mut Model<D>,
    ranks: Rc<dyn Ranks<D>>,
    observer: &mut dyn Observer,
) -> Result<Summary, Error> {
    #[inline(never)]
    fn plane(
        model: &mut Model<2>,
        ranks: Rc<dyn Ranks<2>>,
        observer: &mut dyn Observer,
    ) -> Result<Summary, Error> {
        crate::run::run(model, ranks, observer)
    }
    #[inline(never)]
    fn solid(
        model: &mut Model<3>,
        ranks: Rc<dyn Ranks<3>>,
        observer: &mut dyn Observer,
    ) -> Result<Summary, Error> {
        crate::run::run(model, ranks, observer)
    }
    if const { D == 2 } {
        plane(of(model), ranks_of(ranks), observer)
    } else if const { D == 3 } {
        solid(of(model), ranks_of(ranks), observer)
    } else {
        crate::run::run(model, ranks, observer)
    }
}

/// As [`resume`], of a model that several ranks share, from the state of all points.
///
/// # Errors
/// As [`resume`] and [`run_on`].
pub fn resume_on<const D: usize>(
    model: &mut Model<D>,
    ranks: Rc<dyn Ranks<D>>,
    state: &State,
    observer: &mut dyn Observer,
) -> Result<Summary, Error> {
    #[inline(never)]
    fn plane(
        model: &mut Model<2>,
        ranks: Rc<dyn Ranks<2>>,
        state: &State,
        observer: &mut dyn Observer,
    ) -> Result<Summary, Error> {
        crate::run::resume(model, ranks, state, observer)
    }
    #[inline(never)]
    fn solid(
        model: &mut Model<3>,
        ranks: Rc<dyn Ranks<3>>,
        state: &State,
        observer: &mut dyn Observer,
    ) -> Result<Summary, Error> {
        crate::run::resume(model, ranks, state, observer)
    }
    if const { D == 2 } {
        plane(of(model), ranks_of(ranks), state, observer)
    } else if const { D == 3 } {
        solid(of(model), ranks_of(ranks), state, observer)
    } else {
        crate::run::resume(model, ranks, state, observer)
    }
}
