//! The columns of the history of a model.

use super::grip::driven;
use crate::model::Model;
use crate::observe::{Column, ColumnKind};
use mpm_assembly::RecordedValues;
use mpm_basis::DomainControl;
use mpm_linear::Choice;

/// The columns, in the order in which [`super::history::Record`] fills them.
pub(crate) fn columns<const D: usize>(model: &Model<D>) -> Vec<Column> {
    let (width, turns) = (model.coordinates(), model.turns());
    let mut columns = columns_of_every_run();
    if model.has_named_stages() {
        columns.extend([count(STAGE), real("stage/fraction", 1)]);
    }
    if !model.supports.is_empty() {
        columns.push(real(&format!("reaction/{TOTAL}"), width));
        if turns {
            columns.push(real(&format!("reaction_moment/{TOTAL}"), 1));
        }
    }
    for support in driven(model) {
        columns.push(real(&format!("{GAP}{}", support.name), 1));
    }
    for support in &model.supports {
        columns.push(real(&format!("reaction/{}", support.name), width));
        columns.push(real(&format!("displacement/{}", support.name), width));
        if turns {
            columns.push(real(&format!("reaction_moment/{}", support.name), 1));
            columns.push(real(&format!("angle/{}", support.name), 1));
        }
        if support.moment_about.is_some() {
            columns.push(real(&format!("reaction_moment/{}", support.name), moments(D)));
        }
    }
    if let Some(limit) = model.domain_limit {
        columns.push(count(match limit.control {
            DomainControl::Cap { .. } | DomainControl::Reshape { .. } => "domains_capped",
            DomainControl::Split { .. } => "domains_split",
        }));
    }
    for recorded in model.contributions.iter().flat_map(|named| named.contribution.history()) {
        columns.push(match recorded.values {
            RecordedValues::Count(_) => count(&recorded.name),
            RecordedValues::Real(values) => real(&recorded.name, values.len()),
        });
    }
    if model.bodies.iter().any(|named| named.body.points_at_apex().is_some()) {
        columns.push(count(AT_APEX));
    }
    if model.bodies.iter().any(|named| named.body.can_yield()) {
        columns.push(real(STEP_STRAIN, 1));
    }
    if model.condition_history {
        columns.push(real("condition", 1));
    }
    if may_iterate(model) {
        columns.push(count("linear_iterations"));
    }
    if model.domain_history {
        columns.extend([
            real("domain_smallest_measure", 1),
            real("domain_smallest_corner_weight", 1),
            real("domain_largest_distortion", 1),
            count("domain_single_corner_nodes"),
            count("domain_corners_outside"),
            count("domain_fallen_back"),
            real("smallest_volume_ratio", 1),
        ]);
    }
    if model.energies {
        columns.extend(
            ["elastic", "dissipated", "external_work", "unbalanced"]
                .map(|name| real(&format!("energy/{name}"), 1)),
        );
    }
    columns.extend(model.probes.iter().flat_map(|probe| probe.columns(model.space())));
    columns
}

/// Before the name of a support, its column of gaps.
pub(crate) const GAP: &str = "driven_gap/";

/// Column of the points that yield at the apex of their law.
pub(crate) const AT_APEX: &str = "points_at_apex";

/// Column of the largest principal strain of a load step among the points that yield in it.
pub(crate) const STEP_STRAIN: &str = "largest_step_strain";

/// Name of the column of the stage, counted from 1.
pub(crate) const STAGE: &str = "stage/number";

/// Name of the sum of all reactions; no support has it.
pub(crate) const TOTAL: &str = "total";

/// Components of a moment: about z in the plane, about x, y and z in space.
const fn moments(dimensions: usize) -> usize {
    if dimensions == 3 { 3 } else { 1 }
}

fn count(name: &str) -> Column {
    Column { name: name.into(), kind: ColumnKind::Count, width: 1 }
}

fn real(name: &str, width: usize) -> Column {
    Column { name: name.into(), kind: ColumnKind::Real, width }
}

/// The columns that do not depend on the model.
fn columns_of_every_run() -> Vec<Column> {
    vec![
        real("load_fraction", 1),
        count("newton_iterations"),
        real("residual", 1),
        count("equations"),
        count("active_nodes"),
        count("symbolic_reused"),
        count("factorization"),
        count("unstable_node"),
        count("cuts"),
        count("shortened_corrections"),
        count("stages"),
        real("smallest_det_increment", 1),
        real("backward_error", 1),
        count("refinements"),
        real("pivot_spread", 1),
        real("wall_seconds", 1),
    ]
}

/// Nodes of a grid in the plane up to which nothing is predicted to be iterated.
const SMALL: usize = 2000;

/// Whether a model's linear systems may be solved by iteration; a solver of one's own may do so.
pub(crate) fn may_iterate<const D: usize>(model: &Model<D>) -> bool {
    match model.choice() {
        Some(Choice::Direct) => false,
        Some(Choice::Iterative) | None => true,
        Some(Choice::Auto) => model.coordinates() == 3 || model.n_nodes() > SMALL,
    }
}
