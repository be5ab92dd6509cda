//! What ranks cannot share yet.

use mpm_basis::DomainControl;
use mpm_solver::{Model, SolverChoice};

/// The first thing in a model that several ranks cannot share, as a sentence; none if they can.
pub(crate) fn refused<const D: usize>(model: &Model<D>) -> Option<String> {
    if let Some(named) = model.contributions.iter().find(|named| !named.contribution.can_be_shared()) {
        let name = &named.name;
        return Some(format!("`{name}` acts on all bodies as one rank sees them, expected none such"));
    }
    let splits = model.domain_limit.is_some_and(|it| matches!(it.control, DomainControl::Split { .. }));
    let is_custom = matches!(model.solver, SolverChoice::Custom(_));
    let rest = [
        (
            splits && !model.probes.is_empty(),
            "points that are followed may be split, expected no `probes` or no `Split` in `domains.control`",
        ),
        (is_custom, "the linear solver is one of its own, expected one of those that ship"),
    ];
    rest.iter().find(|it| it.0).map(|it| it.1.to_owned())
}
