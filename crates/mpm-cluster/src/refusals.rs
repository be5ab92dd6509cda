//! What ranks cannot share yet.

use mpm_solver::{Model, SolverChoice, UnheldMotion};

/// The first thing in a model that several ranks cannot share, as a sentence; none if they can.
pub(crate) fn refused<const D: usize>(model: &Model<D>) -> Option<String> {
    let of_bodies = model.bodies.iter().find_map(|named| {
        let body = &named.body;
        if body.mean_dilatation().is_some() {
            return Some(format!(
                "body `{}` averages volume changes, expected none (`mean_dilatation`)",
                named.name
            ));
        }
        let field = body.regularisation().is_some();
        field.then(|| format!("the law of body `{}` has a nodal field, expected a law without one", named.name))
    });
    let of_contributions = || {
        let named = model.contributions.first()?;
        Some(format!(
            "`{}` acts on all bodies as one rank sees them, expected supports and loads only",
            named.name
        ))
    };
    let of_the_rest = || {
        let rest = [
            (model.domain_limit.is_some(), "domains are controlled, expected `domains` without `control`"),
            (!model.loads.side_loads.is_empty(), "a traction acts on sides of rings, expected none"),
            (
                model.unheld_motion == UnheldMotion::Zero,
                "motions that nothing holds are kept at zero, expected `unheld_motion: Refuse`",
            ),
            (
                matches!(model.solver, SolverChoice::Custom(_)),
                "the linear solver is one of its own, expected one of those that ship",
            ),
        ];
        rest.iter().find(|it| it.0).map(|it| it.1.to_owned())
    };
    of_bodies.or_else(of_contributions).or_else(of_the_rest)
}
