//! Tangents against differences of the force: for the tests of a new law, basis, or contribution.

use crate::body::{AssemblyPlan, Body, BodyConnectivity, FieldNodes};
use crate::contribution::{ConnectedBody, Contribution, Inadmissible};
use crate::trial::{SystemSums, SystemTangent, Trial};
use crate::unknowns::{Constraints, Couplings, SparsityPattern, UnknownVector, Unknowns};
use mpm_basis::{ActiveNodes, Connectivity, UnconnectedPoint};
use mpm_grid::{LoadFraction, Mesh, NodeSpace, NodeSpaceError, Vector};
use std::sync::Arc;

/// By how much the unknowns are varied on either side, as part of a direction whose entries are of order one.
const STEP: f64 = 1e-6;

/// Size of a nodal field that a body is compared with differences under, if one regularises it.
const FIELD: f64 = 0.02;

/// How far a contribution's tangent under a trial is from differences of its force: the product of the tangent and a
/// direction in which every unknown takes part, less central differences along it, as part of the largest of them.
///
/// Nothing may be prescribed. The unknowns are varied by 1e-6, so they should be of order one; an error of about 1e-8 is
/// that of differences. Where the force has a kink under the trial (first yield, a contact that opens), they mean nothing.
///
/// # Errors
/// The trial, or one beside it, is not admissible.
pub fn stiffness_error<const D: usize>(
    contribution: &dyn Contribution<D>,
    trial: &Trial<'_, D>,
) -> Result<f64, Inadmissible> {
    let unknowns = trial.pattern.unknowns();
    let mut direction = UnknownVector::zeros(unknowns);
    let entries = (0..unknowns.n_equations()).map(|k| (1.7 * k as f64 + 0.6 * (k % D) as f64).sin());
    direction.read_equations(&entries.collect::<Vec<_>>());
    let force = |by: f64, values: Option<&mut [f64]>| {
        let mut increment = trial.increment.clone();
        increment.add(by, &direction);
        let mut force = UnknownVector::zeros(unknowns);
        let tangent = values.map(|values| SystemTangent { values, lift: None });
        let mut sums = SystemSums::new(&mut force, tangent);
        contribution.add(&Trial { increment: &increment, ..*trial }, &mut sums)?;
        Ok(force)
    };
    let mut values = vec![0.0; trial.pattern.n_entries()];
    force(0.0, Some(&mut values))?;
    let mut difference = force(STEP, None)?;
    difference.subtract(&force(-STEP, None)?);
    let (mut along, mut error) = (Vec::new(), Vec::new());
    direction.write_equations(&mut along);
    difference.write_equations(&mut error);
    error.iter_mut().for_each(|it| *it /= 2.0 * STEP);
    let size = largest(&error);
    trial.pattern.subtract_product(&values, &along, &mut error);
    Ok(largest(&error) / size)
}

/// [`stiffness_error`] of a body alone on a mesh, under the displacement that `displacement` gives every node by its
/// position `[L]`; under a nodal field of 0 to 0.04 that varies from node to node, if one regularises the body.
///
/// # Errors
/// The mesh does not suit the body, or the displacement is not admissible.
pub fn body_stiffness_error<const D: usize>(
    body: &dyn Body<D>,
    mesh: &Mesh<D>,
    displacement: impl Fn(&Vector<D>) -> Vector<D>,
) -> Result<f64, NotCompared<D>> {
    let space = NodeSpace::of(body.node_kind(mesh), mesh)?;
    let stencils = body.stencils(mesh)?;
    let active = ActiveNodes::of(&space, std::slice::from_ref(&stencils));
    let connectivity = Connectivity::of(stencils, &active);
    let dilatation = body.dilatation(&connectivity, mesh, &active)?;
    let connected = BodyConnectivity { connectivity, dilatation };
    let mut unknowns = Unknowns::of_nodes(active.len());
    let field = body.regularisation().is_some();
    let field = field.then(|| Arc::new(FieldNodes::of(&[&connected.connectivity], &mut unknowns)));
    let with_field = field.as_ref().map(|nodes| nodes.couplings(&connected.connectivity));
    let couplings: &dyn Couplings = with_field.as_ref().map_or(&connected as _, |it| it as _);
    let pattern = SparsityPattern::reusing(None, &unknowns, body.symmetry(), &[couplings]);
    let mut plan = AssemblyPlan::new(connected, &pattern);
    if let Some(nodes) = field {
        plan = plan.with_field(nodes, &pattern);
    }
    if let Some(regularisation) = body.regularisation() {
        plan.begin_field(&regularisation, &|point| body.field_point(point));
    }
    let mut increment = UnknownVector::zeros(pattern.unknowns());
    increment.own.iter_mut().enumerate().for_each(|(k, value)| *value = FIELD * (1.0 + (k as f64).sin()));
    for (to, &node) in increment.nodes.iter_mut().zip(active.nodes()) {
        *to = displacement(&space.position(mesh, node));
    }
    let trial = Trial {
        pattern: &pattern,
        constraints: &Constraints::none(active.len()),
        increment: &increment,
        end: LoadFraction::END,
        is_first: false,
    };
    Ok(stiffness_error(&ConnectedBody { body, plan: &plan }, &trial)?)
}

/// Why a body's tangent is not compared with differences.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NotCompared<const D: usize> {
    /// The mesh has no such nodes as its basis needs.
    #[error(transparent)]
    Nodes(#[from] NodeSpaceError),
    /// A point is not in the mesh.
    #[error(transparent)]
    Point(#[from] UnconnectedPoint<D>),
    /// The displacement, or one beside it, is not admissible.
    #[error(transparent)]
    Trial(#[from] Inadmissible),
}

/// The largest size; NaN if one is NaN, which `f64::max` would pass over.
fn largest(numbers: &[f64]) -> f64 {
    numbers.iter().fold(0.0, |most: f64, it| if it.abs() > most || it.is_nan() { it.abs() } else { most })
}
