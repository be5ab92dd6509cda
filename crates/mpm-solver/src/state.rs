//! The state of a run between two load steps, from which it goes on bit for bit: plain data, nothing of
//! files.

use crate::error::Error;
use crate::load_step::stencils;
use crate::model::Model;
use crate::record::{Record, Totals};
use crate::timing::{Spent, Timings};
use mpm_assembly::StoredPoints;
use mpm_basis::DomainControl;
use mpm_grid::LoadFraction;
use mpm_linear::{LinearSolver, StoredOrder};
use serde::{Deserialize, Serialize};

/// Everything that the rest of a run depends on, besides its scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State {
    /// How far the run has come.
    pub progress: Progress,
    /// The points of every body.
    pub bodies: Vec<StoredPoints>,
    /// Of every load on points: the points and the part that each carries.
    pub shares: Vec<Vec<(usize, f64)>>,
    /// Displacement of the last step, where the next one is guessed from it.
    pub secant: StoredSecant,
    /// The order of elimination that was at hand, if any.
    pub order: Option<StoredOrder>,
}

/// How far a run has come.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Progress {
    pub(crate) rows: u64,
    pub(crate) control: ControlProgress,
    pub(crate) displacement: Vec<Vec<f64>>,
    pub(crate) cuts_before: u64,
    pub(crate) totals: Totals,
    pub(crate) spent: Spent,
}

/// How far the choice of load steps has come.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum ControlProgress {
    /// Equal load steps.
    Load {
        /// Nominal steps completed.
        done: u32,
        /// Position inside the present one, in its smallest parts.
        position: u64,
        /// Times that it is halved.
        level: u8,
        /// Halvings so far.
        cuts: u64,
        /// Change of the load fraction in the last step, where the next one is guessed from it.
        last: Option<f64>,
    },
    /// Steps along the path.
    Path {
        /// Load fraction reached.
        at: f64,
        /// Change of the load fraction of the next load step.
        span: f64,
        /// Length of the next step along the path.
        aim: Option<f64>,
        /// Whether the next step is one along the path.
        along: bool,
        /// Whether the end lies within the next step.
        landing: bool,
        /// Times that the next step is halved.
        level: u8,
        /// Halvings so far.
        cuts: u64,
        /// Change of the load fraction in the last step, and its length.
        secant: Option<(f64, f64)>,
    },
}

impl ControlProgress {
    /// Halvings so far.
    pub(crate) fn cuts(&self) -> u64 {
        match *self {
            Self::Load { cuts, .. } | Self::Path { cuts, .. } => cuts,
        }
    }
}

impl Default for ControlProgress {
    fn default() -> Self {
        Self::Load { done: 0, position: 0, level: 0, cuts: 0, last: None }
    }
}

/// Displacement of the last step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StoredSecant {
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
    /// One per body.
    pub bodies: Vec<BodyLayout>,
    /// Loads on points.
    pub loads: usize,
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

impl Progress {
    /// Rows of the history that were shown: the initial state and the load steps taken.
    pub fn rows(&self) -> usize {
        self.rows as usize
    }

    /// As text, from which [`Self::from_text`] gets every bit back.
    ///
    /// # Errors
    /// Says why it cannot be written.
    pub fn to_text(&self) -> Result<String, String> {
        ron::to_string(self).map_err(|error| error.to_string())
    }

    /// From text.
    ///
    /// # Errors
    /// Says what is wrong with the text.
    pub fn from_text(text: &str) -> Result<Self, String> {
        ron::from_str(text).map_err(|error| error.to_string())
    }
}

impl StateLayout {
    /// The layout of the states of a model that has not begun to run.
    pub(crate) fn of<const D: usize>(model: &Model<D>) -> Self {
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
            bodies: (0..model.bodies.len()).map(body).collect(),
            loads: model.loads.point_loads.len(),
            nodes: model.layout.lattice().n_nodes(),
            dimensions: D,
        }
    }
}

impl State {
    pub(crate) fn of<const D: usize>(
        model: &Model<D>,
        record: &Record,
        (control, secant): (ControlProgress, StoredSecant),
        linear: &LinearSolver<D>,
        timings: &Timings,
    ) -> Self {
        let mut progress = Progress { control, spent: timings.store(), ..Progress::default() };
        record.store(&mut progress);
        Self {
            progress,
            bodies: model.bodies.iter().map(|named| named.body.store()).collect(),
            shares: model.loads.point_loads.iter().map(|load| load.shares.clone()).collect(),
            secant,
            order: linear.store(),
        }
    }

    /// Puts the points and their loads of the state into a model that has not begun to run.
    ///
    /// # Errors
    /// What is none of the model; the model may then hold a part of the state.
    pub(crate) fn recall<const D: usize>(&self, model: &mut Model<D>) -> Result<(), StateError> {
        let layout = StateLayout::of(model);
        let count = |item: &str, found: usize, expected: usize| {
            if found == expected {
                return Ok(());
            }
            Err(StateError::new(item, format!("there are {found}, expected {expected}")))
        };
        count("bodies", self.bodies.len(), layout.bodies.len())?;
        count("loads", self.shares.len(), layout.loads)?;
        for (k, (stored, expected)) in self.bodies.iter().zip(&layout.bodies).enumerate() {
            if !(expected.least..=expected.most).contains(&stored.points) {
                let BodyLayout { least, most, .. } = expected;
                let reason = format!("has {} points, expected {least} to {most}", stored.points);
                return Err(StateError::new(format!("bodies/{k}"), reason));
            }
            let recalled = model.bodies[k].body.recall(stored);
            recalled.map_err(|it| StateError::new(format!("bodies/{k}/{}", it.column), it.reason))?;
        }
        for (k, (load, shares)) in model.loads.point_loads.iter_mut().zip(&self.shares).enumerate() {
            let points = model.bodies[load.body].body.n_points();
            let ascend = shares.windows(2).all(|pair| pair[0].0 <= pair[1].0);
            if shares.is_empty() || !ascend || shares.iter().any(|&(point, _)| point >= points) {
                let reason = format!("expected points that ascend below {points}");
                return Err(StateError::new(format!("loads/{k}/point"), reason));
            }
            if let Some((_, share)) = shares.iter().find(|(_, share)| !(0.0..=1.0).contains(share)) {
                return Err(StateError::new(
                    format!("loads/{k}/share"),
                    format!("is {share}, expected 0 to 1"),
                ));
            }
            load.shares.clone_from(shares);
        }
        if let Some(order) = &self.order {
            let equations = layout.nodes * layout.dimensions;
            if order.order.len() > equations || !order.is_permutation() {
                let n = order.order.len();
                return Err(StateError::new(
                    "order",
                    format!("is no order of {n} equations, of {equations} at most"),
                ));
            }
        }
        Ok(())
    }
}

/// Refuses points that the mesh at a load fraction does not cover.
pub(crate) fn check_covered<const D: usize>(model: &Model<D>, at: LoadFraction) -> Result<(), Error> {
    let mesh = model.motion.mesh_at(&model.layout, at).map_err(|it| StateError::new("the mesh", it))?;
    stencils(model, &mesh).map_err(|it| StateError::new("bodies", it))?;
    Ok(())
}
