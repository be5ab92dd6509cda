//! Stages that are added to the schedule of a run that goes on: the scene of before, and what comes with them.

use crate::compiled::Compiled;
use crate::error::SceneError;
use crate::language::{
    ActiveInput, ControlInput, Finite, Fraction, Knots, LoadInput, MotionInput, RampInput, Scene, SceneIn,
};
use mpm_solver::{Kept, State, StateError, extended};
use std::collections::BTreeMap;

/// Stages that a scene has behind those of another, and nothing else but what begins with them or ends in them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AddedStages {
    /// Their names.
    pub names: Vec<String>,
    kept: Kept,
}

impl AddedStages {
    /// What `after` has besides `before`.
    ///
    /// # Errors
    /// The first part of `after` that is another in `before`, and concerns not only stages that are added. Title and
    /// checkpoints may differ.
    pub fn between(before: &Scene, after: &Scene) -> Result<Self, SceneError> {
        match (before, after) {
            (Scene::PlaneStrain(before), Scene::PlaneStrain(after)) => added(before, after),
            (Scene::Axisymmetric(before), Scene::Axisymmetric(after)) => added(before, after),
            (Scene::Solid(before), Scene::Solid(after)) => added(before, after),
            _ => Err(SceneError::new("", differs("the space"))),
        }
    }

    /// The state of a run of `before`, as that of a run of `after`.
    ///
    /// # Errors
    /// The state is none of `before`, or support and loads do not match.
    pub fn extend(&self, state: State, before: &Compiled, after: &Compiled) -> Result<State, StateError> {
        match (before, after) {
            (Compiled::Plane(before), Compiled::Plane(after)) => extended(state, before, after, &self.kept),
            (Compiled::Solid(before), Compiled::Solid(after)) => extended(state, before, after, &self.kept),
            _ => Err(StateError::new("scene", "is of another space")),
        }
    }
}

fn differs(what: &str) -> String {
    format!(
        "{what} differs from that of the checkpoint; a run can only go on with stages behind the others, and with supports, \
         loads and ramps that begin with them or end in them"
    )
}

fn added<const D: usize, B: Clone + PartialEq>(
    before: &SceneIn<D, B>,
    after: &SceneIn<D, B>,
) -> Result<AddedStages, SceneError> {
    let (old, new) = (&before.schedule.stages, &after.schedule.stages);
    if old.is_empty() {
        let reason = "the schedule of the checkpoint has no `stages`, behind which others could be added";
        return Err(SceneError::new("schedule", reason));
    }
    if let Some(k) = (0..old.len()).find(|&k| new.get(k) != Some(&old[k])) {
        let path = format!("schedule.stages[{k}]");
        return Err(SceneError::new(path, differs(&format!("stage `{}`", old[k].name))));
    }
    let is_old = |name: &String| old.iter().any(|stage| stage.name == *name);
    let begins_before = |active: &ActiveInput| active.from.as_ref().is_none_or(is_old);
    let kept = Kept {
        supports: after.supports.iter().map(|support| begins_before(&support.active)).collect(),
        point_loads: point_loads(&after.loads).map(begins_before).collect(),
    };
    let (mut was, mut is) = (before.clone(), after.clone());
    is.schedule.stages.truncate(old.len());
    is.supports.retain(|support| begins_before(&support.active));
    is.loads.retain(|load| begins_before(active(load)));
    let first = &old[0].name;
    for scene in [&mut was, &mut is] {
        scene.title.clear();
        scene.output.checkpoint = None;
        for support in &mut scene.supports {
            end_before(&mut support.active, is_old);
            let from = support.active.from.clone().unwrap_or(first.clone());
            let displaced = support.displace.iter_mut().map(|it| &mut it.ramp);
            displaced
                .chain(support.turn.as_mut().map(|it| &mut it.ramp))
                .for_each(|it| name(it, &from, is_old));
        }
        for load in &mut scene.loads {
            let (ramp, active) = parts(load);
            end_before(active, is_old);
            name(ramp, &active.from.clone().unwrap_or(first.clone()), is_old);
        }
        ramps(&mut scene.motion).into_iter().for_each(|ramp| name(ramp, first, is_old));
    }
    compare(&was, &is)?;
    let splits = matches!(after.domains.control, Some(ControlInput::Split { .. }));
    if splits && kept.point_loads.contains(&false) {
        let reason =
            "points are split by `domains.control`: which of them a load that is added acts on is not known";
        return Err(SceneError::new("loads", reason));
    }
    let names = new[old.len()..].iter().map(|stage| stage.name.clone()).collect();
    Ok(AddedStages { names, kept })
}

/// Refuses scenes that differ.
fn compare<const D: usize, B: PartialEq>(was: &SceneIn<D, B>, is: &SceneIn<D, B>) -> Result<(), SceneError> {
    let listed = |name: &str, same: Vec<bool>, lengths: [usize; 2]| {
        let k = same.iter().position(|same| !same);
        k.or((lengths[0] != lengths[1]).then(|| lengths[0].min(lengths[1]))).map(|k| format!("{name}[{k}]"))
    };
    let supports = was.supports.iter().zip(&is.supports).map(|(a, b)| a == b).collect();
    let loads = was.loads.iter().zip(&is.loads).map(|(a, b)| a == b).collect();
    let whole = |name: &str, same: bool| (!same).then(|| name.to_string());
    let first = [
        whole("mesh", was.mesh == is.mesh),
        whole("twist", was.twist == is.twist),
        whole("motion", was.motion == is.motion),
        whole("basis", was.basis == is.basis),
        whole("domains", was.domains == is.domains),
        whole("stabilisation", was.stabilisation == is.stabilisation),
        whole("materials", was.materials == is.materials),
        whole("bodies", was.bodies == is.bodies),
        listed("supports", supports, [was.supports.len(), is.supports.len()]),
        listed("loads", loads, [was.loads.len(), is.loads.len()]),
        whole("probes", was.probes == is.probes),
        whole("schedule", was.schedule == is.schedule),
        whole("tolerance", was.tolerance == is.tolerance),
        whole("unheld_motion", was.unheld_motion == is.unheld_motion),
        whole("solver", was.solver == is.solver),
        whole("output", was.output == is.output),
        // Whatever else a scene may have.
        whole("", was == is),
    ];
    match first.into_iter().flatten().next() {
        None => Ok(()),
        Some(path) if path.is_empty() => Err(SceneError::new("", differs("the scene"))),
        Some(path) => Err(SceneError::new(&path, differs(&format!("`{path}`")))),
    }
}

fn active<const D: usize>(load: &LoadInput<D>) -> &ActiveInput {
    let (LoadInput::BodyForce { active, .. }
    | LoadInput::Vortex { active, .. }
    | LoadInput::PointForce { active, .. }
    | LoadInput::Traction { active, .. }
    | LoadInput::Pressure { active, .. }) = load;
    active
}

fn parts<const D: usize>(load: &mut LoadInput<D>) -> (&mut RampInput, &mut ActiveInput) {
    let (LoadInput::BodyForce { ramp, active, .. }
    | LoadInput::Vortex { ramp, active, .. }
    | LoadInput::PointForce { ramp, active, .. }
    | LoadInput::Traction { ramp, active, .. }
    | LoadInput::Pressure { ramp, active, .. }) = load;
    (ramp, active)
}

/// When the loads act that points carry.
fn point_loads<const D: usize>(loads: &[LoadInput<D>]) -> impl Iterator<Item = &ActiveInput> {
    let on_points = |load: &&LoadInput<D>| {
        matches!(load, LoadInput::PointForce { .. } | LoadInput::Traction { side: None, .. })
    };
    loads.iter().filter(on_points).map(active)
}

fn ramps<const D: usize>(motion: &mut MotionInput<D>) -> Vec<&mut RampInput> {
    match motion {
        MotionInput::Fixed => Vec::new(),
        MotionInput::Stretch(stretches) => stretches.iter_mut().map(|it| &mut it.ramp).collect(),
        MotionInput::Corners(corners) => corners.iter_mut().map(|it| &mut it.ramp).collect(),
        MotionInput::Rotate { ramp, .. } | MotionInput::Expand { ramp, .. } => vec![ramp],
        MotionInput::Twist { ramp, outer_ramp, .. } => {
            let mut ramps = vec![ramp];
            ramps.extend(outer_ramp.as_mut());
            ramps
        }
    }
}

/// Without its end, if that is in a stage that has been added.
fn end_before(active: &mut ActiveInput, is_old: impl Fn(&String) -> bool) {
    if !active.until.as_ref().is_some_and(is_old) {
        (active.until, active.release) = (None, Default::default());
    }
}

/// The ramp by the names of stages, with a knot at the start of each, without stages that have been added.
fn name(ramp: &mut RampInput, from: &str, is_old: impl Fn(&String) -> bool) {
    let begin = |mut knots: Knots, before: Option<Finite>| {
        if let Some(&(_, value)) = knots.first().filter(|knot| knot.0.0 > 0.0) {
            knots.insert(0, (Fraction(0.0), before.unwrap_or(value)));
        }
        knots
    };
    *ramp = RampInput::Stages(match std::mem::take(ramp) {
        RampInput::Knots(knots) => BTreeMap::from([(from.to_string(), begin(knots, None))]),
        RampInput::Stages(stages) => {
            let old = stages.into_iter().filter(|(stage, _)| is_old(stage));
            // Only in the first of its stages is it known where the ramp begins; the others are compared as they are.
            let named = old.map(|(stage, knots)| {
                let knots = if stage == from { begin(knots, Some(Finite(0.0))) } else { knots };
                (stage, knots)
            });
            named.collect()
        }
    });
}
