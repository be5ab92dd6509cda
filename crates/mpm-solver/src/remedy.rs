//! What a scene can have against failures of load steps.

use crate::connection::Connected;
use crate::error::{Error, Remedy};
use crate::model::{Model, NamedContribution};
use crate::ranks::{Ranks, largest};
use mpm_grid::{LoadFraction, MeshMotion};

/// Stiffness of the node that bodies reach least, over the median, from which on no node is barely reached: at the
/// corner of a body that fills its cells it is an eighth.
const FULL: f64 = 0.1;

/// Pressure over the shear stress of flowing points from which on averages over points are to be doubted: a cavity in
/// Tresca clay is wrong by some per cent at 40 and unstable at 60 to 90.
const PRESSED: f64 = 30.0;

/// Pressure that cells misjudge over the shear stress of flowing points from which on volume changes of cells are to be
/// doubted: a cylinder in clay is right to 0.3 per cent with 3, and wrong by 8 per cent with 50.
const CROWDED: f64 = 10.0;

/// Whether the model could have ghost stabilisation and does not.
fn can_be_stabilised<const D: usize>(model: &Model<D>) -> bool {
    model.nodes.kind() == model.layout.functions()
        && !model.contributions.iter().any(|named| named.contribution.stabilises())
}

/// The error with the remedy that the model can have, where the nodes of the step that failed show the cause.
pub(crate) fn with_remedy<const D: usize>(
    error: Error,
    model: &Model<D>,
    connected: Option<&Connected<D>>,
    ranks: &dyn Ranks<D>,
) -> Error {
    let pressed = pressure_over_shear(model, ranks);
    match (error, connected) {
        (Error::Step { step, from, to, level, reason, remedy: None }, _)
            if reason.may_be_of_motions() && pressed.is_some() =>
        {
            let remedy = pressed.map(|ratio| Remedy::CellVolumes { ratio });
            Error::Step { step, from, to, level, reason, remedy }
        }
        (Error::Step { step, from, to, level, reason, remedy: None }, Some(connected))
            if ranks.sees_all() && reason.may_need_stabilisation() && can_be_stabilised(model) =>
        {
            let part = least_reached(model, connected);
            let remedy = (part < FULL).then_some(Remedy::Stabilisation { part });
            Error::Step { step, from, to, level, reason, remedy }
        }
        (error, _) => error,
    }
}

/// Pressure over the shear stress of flowing points, where it is so large that volume changes should be those of cells.
pub(crate) fn pressure_over_shear<const D: usize>(model: &Model<D>, ranks: &dyn Ranks<D>) -> Option<f64> {
    let ratios = model.bodies.iter().filter_map(|named| mpm_assembly::pressure_over_shear(&*named.body));
    Some(largest(ranks, ratios.fold(0.0, f64::max))).filter(|ratio| *ratio >= PRESSED)
}

/// Pressure that cells misjudge at a load fraction over the shear stress of flowing points, where it is so large that volume
/// changes should be those of points.
pub(crate) fn crowding_over_shear<const D: usize>(
    model: &Model<D>,
    at: LoadFraction,
    ranks: &dyn Ranks<D>,
) -> Option<f64> {
    let mesh = model.motion.mesh_at(&model.layout, at).ok()?;
    let ratios = model.bodies.iter().filter_map(|named| mpm_assembly::crowding_over_shear(&*named.body, &mesh));
    Some(largest(ranks, ratios.fold(0.0, f64::max))).filter(|ratio| *ratio >= CROWDED)
}

/// Stiffness of the node that bodies reach least, over the median of all nodes.
fn least_reached<const D: usize>(model: &Model<D>, connected: &Connected<D>) -> f64 {
    let mut stiffness = vec![0.0; connected.active.len()];
    for (named, plan) in model.bodies.iter().zip(&connected.assembly_plans) {
        named.body.stiffness_force(plan.connectivity(), &mut stiffness);
    }
    stiffness.sort_by(f64::total_cmp);
    match stiffness.get(stiffness.len() / 2) {
        Some(median) => stiffness[0] / median,
        None => 1.0,
    }
}

/// What can be said of a model before it runs.
pub(crate) fn advice<const D: usize>(model: &Model<D>) -> Option<String> {
    let moves =
        |named: &NamedContribution<D>| named.contribution.moves_with_load() && !named.contribution.is_load();
    let why = match model.contributions.iter().find(|named| moves(named)) {
        // A mesh that moves with the material keeps the cells filled.
        _ if model.motion == MeshMotion::Fixed => "the mesh is fixed, so that bodies which move far".to_owned(),
        Some(tool) => format!("`{}` moves through the mesh, so that bodies which it pushes", tool.name),
        None => return None,
    };
    can_be_stabilised(model).then(|| {
        format!("{why} come to barely reach some nodes, which makes steps fail: the remedy is `stabilisation: Ghost()`")
    })
}
