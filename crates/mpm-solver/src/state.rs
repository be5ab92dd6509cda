//! The state of a run between two load steps, from which it goes on bit for bit: plain data, nothing of
//! files.

use crate::model::{Model, NamedContribution, Share};
use crate::progress::{Progress, StageProgress, StepsProgress};
use mpm_assembly::{Space, StoredPoints};
use mpm_basis::DomainControl;
use mpm_grid::Vector;
use mpm_linear::Saved;

/// Everything that the rest of a run depends on, besides its scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State {
    /// The space of the bodies.
    pub space: Space,
    /// How far the run has come.
    pub progress: Progress,
    /// The points of every body.
    pub bodies: Vec<StoredPoints>,
    /// Of every load on points: the points and what each carries.
    pub shares: Vec<Vec<StoredShare>>,
    /// The state of every contribution, in the order of the model.
    pub contributions: Vec<StoredContribution>,
    /// Displacement of the last step, where the next one is predicted from it.
    pub predictor: StoredPredictor,
    /// What the linear solver needs in order to go on bit for bit, if anything.
    pub linear_solver: Option<Saved>,
}

/// What a contribution remembers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StoredContribution {
    /// Its name in the model.
    pub name: String,
    /// See [`mpm_assembly::Contribution::save`].
    pub numbers: Vec<f64>,
}

/// A point's part of a load, see [`Share`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StoredShare {
    /// The point.
    pub point: usize,
    /// Part of the force that it carries `[-]`.
    pub part: f64,
    /// From the point to where its part acts, at rest; 0 in directions that do not exist `[L]`.
    pub arm: [f64; 3],
}

impl StoredShare {
    /// The part of a load as plain numbers.
    pub fn of<const D: usize>(share: &Share<D>) -> Self {
        let arm = std::array::from_fn(|d| if d < D { share.arm[d] } else { 0.0 });
        Self { point: share.point, part: share.part, arm }
    }

    fn share<const D: usize>(&self) -> Share<D> {
        Share { point: self.point, part: self.part, arm: Vector::from_fn(|d, _| self.arm[d]) }
    }
}

/// Displacement of the last step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StoredPredictor {
    /// Numbers of the nodes, ascending.
    pub nodes: Vec<u64>,
    /// One component after the other `[L]`.
    pub increment: Vec<f64>,
}

/// A state that is none of the scene.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{item}: {reason}")]
pub struct StateError {
    /// The part of the state.
    pub item: String,
    /// What it is, and what was expected.
    pub reason: String,
}

impl StateError {
    /// An error of `item`.
    pub fn new(item: impl Into<String>, reason: impl ToString) -> Self {
        Self { item: item.into(), reason: reason.to_string() }
    }
}

/// What the parts of a state must look like: all that is to be known before any of it is read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StateLayout {
    /// The space of the bodies.
    pub space: Space,
    /// One per body.
    pub bodies: Vec<BodyLayout>,
    /// Loads on points.
    pub loads: usize,
    /// Names of the contributions.
    pub contributions: Vec<String>,
    /// Nodes of the grid; no list of nodes is longer.
    pub nodes: usize,
    /// Components of a displacement.
    pub dimensions: usize,
}

/// What the stored points of a body must look like.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BodyLayout {
    /// Name and numbers per point of every column.
    pub columns: Vec<(&'static str, usize)>,
    /// Fewest points.
    pub least: usize,
    /// Most points.
    pub most: usize,
}

impl StateLayout {
    /// The layout of the states of a model that has not begun to run.
    pub fn of<const D: usize>(model: &Model<D>) -> Self {
        let points = |k: usize| model.bodies[k].body.n_points();
        let all: usize = (0..model.bodies.len()).map(points).sum();
        let split = model.domain_limit.filter(|limit| matches!(limit.control, DomainControl::Split { .. }));
        let more = split.map_or(0, |limit| limit.most_points.saturating_sub(all));
        let body = |k: usize| BodyLayout {
            columns: model.bodies[k].body.stored_columns(),
            least: points(k),
            most: points(k) + more,
        };
        Self {
            space: model.space(),
            bodies: (0..model.bodies.len()).map(body).collect(),
            loads: model.loads.point_loads.len(),
            contributions: model.contributions.iter().map(|named| named.name.clone()).collect(),
            nodes: model.nodes.lattice().n_nodes(),
            dimensions: D,
        }
    }

    /// Refuses a state of another space.
    ///
    /// # Errors
    /// The space that it is of, and what was expected.
    pub fn check_space(&self, space: Space) -> Result<(), StateError> {
        if space == self.space {
            return Ok(());
        }
        let reason = format!("is {}, expected {}, that of the scene", space.name(), self.space.name());
        Err(StateError::new("space", reason))
    }
}

impl State {
    /// The points of the model, with how far its load steps have come. What the record and the clock add to the
    /// progress is added by them.
    pub(crate) fn of<const D: usize>(
        model: &Model<D>,
        (stage, control, predictor): (StageProgress, StepsProgress, StoredPredictor),
        linear_solver: Option<Saved>,
    ) -> Self {
        let resets = model.stages.iter().any(|stage| stage.resets_displacements);
        let probes = model.probes.iter().filter(|_| resets);
        let probes = probes.map(|probe| probe.rest.iter().copied().collect()).collect();
        Self {
            space: model.space(),
            progress: Progress { stage, control, probes, ..Progress::default() },
            bodies: model.bodies.iter().map(|named| named.body.store()).collect(),
            shares: model
                .loads
                .point_loads
                .iter()
                .map(|load| load.shares.iter().map(StoredShare::of).collect())
                .collect(),
            contributions: model.contributions.iter().map(saved).collect(),
            predictor,
            linear_solver,
        }
    }

    /// Puts the points and their loads of the state into a model that has not begun to run.
    ///
    /// # Errors
    /// What is none of the model; the model may then hold a part of the state.
    pub(crate) fn restore<const D: usize>(&self, model: &mut Model<D>) -> Result<(), StateError> {
        let layout = StateLayout::of(model);
        layout.check_space(self.space)?;
        let count = |item: &str, found: usize, expected: usize| {
            if found == expected {
                return Ok(());
            }
            Err(StateError::new(item, format!("there are {found}, expected {expected}")))
        };
        count("bodies", self.bodies.len(), layout.bodies.len())?;
        count("loads", self.shares.len(), layout.loads)?;
        let found: Vec<&String> = self.contributions.iter().map(|it| &it.name).collect();
        if found != layout.contributions.iter().collect::<Vec<_>>() {
            let reason = format!("are {found:?}, expected {:?}", layout.contributions);
            return Err(StateError::new("contributions", reason));
        }
        for (k, (stored, expected)) in self.bodies.iter().zip(&layout.bodies).enumerate() {
            if !(expected.least..=expected.most).contains(&stored.points) {
                let BodyLayout { least, most, .. } = expected;
                let reason = format!("has {} points, expected {least} to {most}", stored.points);
                return Err(StateError::new(format!("bodies/{k}"), reason));
            }
            let restored = model.bodies[k].body.restore(stored);
            restored.map_err(|it| StateError::new(format!("bodies/{k}/{}", it.column), it.reason))?;
        }
        for (k, (load, shares)) in model.loads.point_loads.iter_mut().zip(&self.shares).enumerate() {
            check_shares(shares, model.bodies[load.body].body.n_points())
                .map_err(|(item, reason)| StateError::new(format!("loads/{k}/{item}"), reason))?;
            load.shares = shares.iter().map(StoredShare::share).collect();
        }
        restore_probes(model, &self.progress.probes)?;
        for (named, stored) in model.contributions.iter_mut().zip(&self.contributions) {
            let item = || format!("contributions/{}", named.name);
            if let Some(number) = stored.numbers.iter().find(|number| !number.is_finite()) {
                return Err(StateError::new(item(), format!("holds {number}, expected finite numbers")));
            }
            let restored = named.contribution.restore(&stored.numbers);
            restored.map_err(|it| StateError::new(item(), it))?;
        }
        Ok(())
    }
}

/// Sets where the displacements of probes count from; nothing where no stage has reset them.
fn restore_probes<const D: usize>(model: &mut Model<D>, stored: &[Vec<f64>]) -> Result<(), StateError> {
    if stored.is_empty() {
        return Ok(());
    }
    let is_place = |rest: &Vec<f64>| rest.len() == D && rest.iter().all(|x| x.is_finite());
    if stored.len() != model.probes.len() || !stored.iter().all(is_place) {
        let reason = format!("are not {} positions of {D} finite numbers", model.probes.len());
        return Err(StateError::new("probes", reason));
    }
    for (probe, rest) in model.probes.iter_mut().zip(stored) {
        probe.rest = Vector::from_column_slice(rest);
    }
    Ok(())
}

/// Whether shares can be those of a load on a body of so many points; else the item that is wrong, and how.
fn check_shares(shares: &[StoredShare], points: usize) -> Result<(), (&'static str, String)> {
    let ascend = shares.windows(2).all(|pair| pair[0].point <= pair[1].point);
    if shares.is_empty() || !ascend || shares.iter().any(|it| it.point >= points) {
        return Err(("point", format!("expected points that ascend below {points}")));
    }
    if let Some(StoredShare { part, .. }) = shares.iter().find(|it| !(0.0..=1.0).contains(&it.part)) {
        return Err(("share", format!("is {part}, expected 0 to 1")));
    }
    if !shares.iter().flat_map(|it| it.arm).all(f64::is_finite) {
        return Err(("arm", "is not finite".into()));
    }
    Ok(())
}

fn saved<const D: usize>(named: &NamedContribution<D>) -> StoredContribution {
    StoredContribution { name: named.name.clone(), numbers: named.contribution.save() }
}
