//! The schedule: stages by their names, what acts in which of them, and ramps over them.

use super::names::{A_NAME, is_name};
use crate::error::SceneError;
use crate::language::{
    ActiveInput, Knots, PathMeasureInput, PredictorInput, RampInput, ReleaseInput, ScheduleInput, StageInput,
    StepControlInput,
};
use mpm_grid::{LoadFraction, Ramp};
use mpm_solver::{Active, Model, PathControl, PathMeasure, PredictorKind, Release, Stage};

/// The stages of a scene; none where it has steps alone.
#[derive(Clone, Copy)]
pub(super) struct Stages<'a> {
    input: &'a [StageInput],
}

impl<'a> Stages<'a> {
    pub(super) fn of(schedule: &'a ScheduleInput) -> Self {
        Self { input: &schedule.stages }
    }

    /// Number of a stage, from 0.
    fn number(&self, name: &str, path: &str) -> Result<u32, SceneError> {
        if let Some(number) = self.input.iter().position(|stage| stage.name == name) {
            return Ok(number as u32);
        }
        let known: Vec<&str> = self.input.iter().map(|stage| stage.name.as_str()).collect();
        let reason = if known.is_empty() {
            format!("no stage named `{name}`: the schedule has no `stages`")
        } else {
            format!("no stage named `{name}`; the schedule has: {}", known.join(", "))
        };
        Err(SceneError::new(path, reason))
    }

    /// When something acts.
    pub(super) fn active(&self, input: &ActiveInput, path: &str) -> Result<Active, SceneError> {
        let number = |name: &Option<String>, field: &str| {
            name.as_ref().map(|name| self.number(name, &format!("{path}.active.{field}"))).transpose()
        };
        let from = number(&input.from, "from")?.unwrap_or(0);
        let until = number(&input.until, "until")?;
        if let Some(until) = until.filter(|&until| until <= from) {
            let [until, from] = [until, from].map(|stage| &self.input[stage as usize].name);
            let reason = format!("expected a stage after `{from}`, with which it begins, got `{until}`");
            return Err(SceneError::new(format!("{path}.active.until"), reason));
        }
        let release = match input.release {
            ReleaseInput::Linear => Release::Linear,
            ReleaseInput::AtOnce => Release::AtOnce,
        };
        if until.is_none() && release == Release::AtOnce {
            let reason = "it does not end: expected `until`, the stage in which it does";
            return Err(SceneError::new(format!("{path}.active.release"), reason));
        }
        Ok(Active { from, until, release })
    }

    /// `scale` times the ramp of something that acts in these stages.
    pub(super) fn ramp(
        &self,
        input: &RampInput,
        scale: f64,
        active: Active,
        path: &str,
    ) -> Result<Ramp, SceneError> {
        let scaled = |knots: &Knots| knots.iter().map(|(at, factor)| (at.0, factor.0 * scale)).collect();
        let ramp = match input {
            RampInput::Knots(knots) => Ramp::in_stage(active.from, scaled(knots)),
            RampInput::Stages(stages) => {
                let mut pieces = Vec::with_capacity(stages.len());
                for (name, knots) in stages {
                    let number = self.number(name, path)?;
                    if number < active.from || active.until.is_some_and(|until| number >= until) {
                        let reason = format!("stage `{name}` is none of those in which it acts");
                        return Err(SceneError::new(path, reason));
                    }
                    pieces.push((number, scaled(knots)));
                }
                pieces.sort_by_key(|piece| piece.0);
                Ramp::of_stages(pieces)
            }
        };
        ramp.map_err(|it| SceneError::new(path, it))
    }

    /// The ramp of a load, which ends where it does.
    pub(super) fn load_ramp(
        &self,
        input: &RampInput,
        scale: f64,
        active: &ActiveInput,
        path: &str,
    ) -> Result<Ramp, SceneError> {
        let active = self.active(active, path)?;
        let ramp = self.ramp(input, scale, active, &format!("{path}.ramp"))?;
        let Some(until) = active.until else { return Ok(ramp) };
        let at_once = active.release == Release::AtOnce;
        if at_once && !matches!(self.input[until as usize].control, StepControlInput::Load) {
            return Err(self.at_once_on_a_path(until, path));
        }
        Ok(ramp.released(until, at_once))
    }

    /// A path begins in equilibrium.
    pub(super) fn at_once_on_a_path(&self, stage: u32, path: &str) -> SceneError {
        let reason = format!(
            "path control begins stage `{}` in equilibrium, where nothing can end at once: expected `Linear`",
            self.input[stage as usize].name
        );
        SceneError::new(format!("{path}.active.release"), reason)
    }

    /// Whether a stage is one of path control.
    pub(super) fn follows_path(&self, stage: u32) -> bool {
        self.input.get(stage as usize).is_some_and(|it| !matches!(it.control, StepControlInput::Load))
    }

    /// Ends of all stages.
    pub(super) fn ends(&self) -> impl Iterator<Item = LoadFraction> {
        (0..self.input.len().max(1) as u32).map(LoadFraction::end_of)
    }
}

/// The stages of a model.
pub(super) fn stages(input: &ScheduleInput) -> Result<Vec<Stage>, SceneError> {
    let cuts = |cuts: u8, path: &str| {
        if cuts <= Stage::MOST_CUTS {
            return Ok(cuts);
        }
        let reason = format!("expected at most {} halvings, got {cuts}", Stage::MOST_CUTS);
        Err(SceneError::new(format!("{path}.cuts"), reason))
    };
    let all = cuts(input.cuts, "schedule")?;
    match (&input.steps, &input.stages[..]) {
        (None, []) => Err(SceneError::new("schedule", "expected `steps`, or `stages`")),
        (Some(steps), []) => Ok(vec![Stage {
            cuts: all,
            predictor: predictor(input.predictor),
            path: path_control(&input.control),
            ..Stage::equal(steps.0)
        }]),
        (Some(_), _) => Err(SceneError::new("schedule.steps", "each of the `stages` has steps of its own")),
        (None, stages) => {
            if input.control != StepControlInput::Load {
                let reason = "each of the `stages` has a control of its own";
                return Err(SceneError::new("schedule.control", reason));
            }
            let made = stages.iter().enumerate().map(|(k, stage)| {
                let path = format!("schedule.stages[{k}]");
                if !is_name(&stage.name) || stages[..k].iter().any(|other| other.name == stage.name) {
                    let reason = format!("expected {A_NAME}, got {:?}", stage.name);
                    return Err(SceneError::new(format!("{path}.name"), reason));
                }
                Ok(Stage {
                    name: stage.name.clone(),
                    cuts: cuts(stage.cuts.unwrap_or(all), &path)?,
                    predictor: predictor(stage.predictor.unwrap_or(input.predictor)),
                    path: path_control(&stage.control),
                    resets_displacements: stage.reset_displacements,
                    ..Stage::equal(stage.steps.0)
                })
            });
            made.collect()
        }
    }
}

fn predictor(input: PredictorInput) -> PredictorKind {
    match input {
        PredictorInput::LastStep => PredictorKind::LastStep,
        PredictorInput::Rest => PredictorKind::Rest,
    }
}

fn path_control(control: &StepControlInput) -> Option<PathControl> {
    let StepControlInput::Path { first, longest, iterations, measure } = control else { return None };
    let measure = match measure {
        PathMeasureInput::Dissipation { most } => PathMeasure::Dissipation { most: most.map(|it| it.0) },
        PathMeasureInput::ArcLength { most } => PathMeasure::ArcLength { most: most.map(|it| it.0) },
    };
    let longest = longest.as_ref().map_or(first.0, |it| it.0);
    Some(PathControl { measure, first: first.0, longest, iterations: iterations.0 })
}

/// A path is followed from an equilibrium on: what jumps at its start has no beginning there.
pub(super) fn refuse_jumps_along_a_path<const D: usize>(model: &Model<D>) -> Result<(), SceneError> {
    let paths = model.stages.iter().enumerate().filter(|(_, stage)| stage.path.is_some());
    for (number, stage) in paths {
        let number = number as u32;
        let reason = match number {
            0 => "the ramp is not 0 at load fraction 0, where path control begins at rest".to_string(),
            _ => format!(
                "the ramp begins stage `{}` elsewhere than where the stage before has left it, and path control begins there",
                stage.name
            ),
        };
        let supports = model.supports.iter().enumerate();
        let mut jumping = supports.filter(|(_, support)| {
            support.acts_in(number) && support.components.iter().flatten().any(|it| it.jumps_in(number))
        });
        if let Some((k, _)) = jumping.next() {
            return Err(SceneError::new(format!("supports[{k}]"), reason));
        }
        if model.motion.ramps().iter().any(|ramp| ramp.jumps_in(number)) {
            return Err(SceneError::new("motion", reason));
        }
    }
    Ok(())
}

/// Displacements count from the positions that points have at a reset: what needs those at rest is refused.
pub(super) fn refuse_resets<const D: usize>(model: &Model<D>, splits: bool) -> Result<(), SceneError> {
    let Some(k) = model.stages.iter().position(|stage| stage.resets_displacements) else { return Ok(()) };
    let refuse =
        |reason: &str| Err(SceneError::new(format!("schedule.stages[{k}].reset_displacements"), reason));
    if splits {
        return refuse("points are split by `domains.control`, and their parts have no place at a reset");
    }
    if !model.loads.fields.is_empty() {
        return refuse("the force of a vortex is a function of positions at rest, which a reset replaces");
    }
    Ok(())
}
