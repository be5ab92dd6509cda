//! The state of a run as that of another model, which has more stages, and more supports and loads that begin with them.

use crate::model::Model;
use crate::record::grip::{Grip, driven};
use crate::state::{State, StateError, StoredShare};

/// What of a model was there before stages were added.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Kept {
    /// Of every support.
    pub supports: Vec<bool>,
    /// Of every load on points.
    pub point_loads: Vec<bool>,
}

/// The state of a run of `before` as that of a run of `after`, whose kept supports and loads are those of `before`.
///
/// # Errors
/// The state is none of `before`, or what is kept is not what `before` has.
pub fn extended<const D: usize>(
    mut state: State,
    before: &Model<D>,
    after: &Model<D>,
    kept: &Kept,
) -> Result<State, StateError> {
    let progress = &mut state.progress;
    let names = |model: &Model<D>| model.supports.iter().map(|it| it.name.clone()).collect::<Vec<_>>();
    let kept_names: Vec<String> =
        names(after).into_iter().zip(&kept.supports).filter(|it| *it.1).map(|it| it.0).collect();
    let expected = (before.supports.len(), driven(before).count(), before.loads.point_loads.len());
    let found = (progress.displacement.len(), progress.grips.len(), state.shares.len());
    let is_kept = |name: &String| kept_names.contains(name);
    let moving = |model| driven(model).map(|it| it.name.clone()).filter(is_kept).collect::<Vec<_>>();
    if kept_names != names(before) || found != expected {
        return Err(StateError::new("supports and loads", "are not those of the scene before"));
    }
    if moving(before) != moving(after) {
        return Err(StateError::new("supports", "one that was at rest is driven by the new scene"));
    }
    let mut displacement = std::mem::take(&mut progress.displacement).into_iter();
    progress.displacement = kept
        .supports
        .iter()
        .map(|&kept| if kept { displacement.next() } else { None }.unwrap_or_else(|| vec![0.0; D]))
        .collect();
    let mut grips = std::mem::take(&mut progress.grips).into_iter();
    progress.grips = driven(after)
        .map(|support| if is_kept(&support.name) { grips.next() } else { None }.unwrap_or_else(Grip::default))
        .collect();
    let mut shares = std::mem::take(&mut state.shares).into_iter();
    let loads = after.loads.point_loads.iter().zip(&kept.point_loads);
    state.shares = loads
        .map(|(load, &kept)| {
            let new = || load.shares.iter().map(StoredShare::of).collect();
            if kept { shares.next() } else { None }.unwrap_or_else(new)
        })
        .collect();
    Ok(state)
}
