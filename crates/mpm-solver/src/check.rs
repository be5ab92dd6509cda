//! What every run refuses before it begins.

use crate::model::{Model, NamedContribution, Prescribed, Support};
use crate::nodes::NodeMismatch;
use crate::record::columns::columns;
use mpm_assembly::Body;
use mpm_grid::{LoadFraction, NodeId};
use std::collections::BTreeSet;

/// A model that cannot be run.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ModelError {
    /// Parts of the model need different nodes.
    #[error(transparent)]
    Nodes(#[from] NodeMismatch),
    /// A share of the points, and no ranks that have the others.
    #[error("it has a share of the points, expected all of them, or ranks that make the others")]
    Share,
    /// No stage, and so no load steps.
    #[error("there are no load steps, expected a stage at least")]
    NoStages,
    /// A stage that resets displacements, and a force that is a function of positions at rest.
    #[error(
        "stage `{stage}` resets displacements, and with them the positions at rest, of which a force per volume is a function"
    )]
    NoRestAfterReset {
        /// Name of the stage.
        stage: String,
    },
    /// Two contributions of one name, which checkpoints could not tell apart.
    #[error("there are two contributions of the name `{name}`, expected a name for each")]
    SameContribution {
        /// The name.
        name: String,
    },
    /// Two columns of the history of one name.
    #[error(
        "contribution `{contribution}` has a column `{column}`, which the history has already, expected another name"
    )]
    SameColumn {
        /// Name of the second contribution that has it.
        contribution: String,
        /// Name of the column.
        column: String,
    },
    /// A body force on points without masses.
    #[error(
        "body forces act, and the points of body `{body}` have no masses, expected `MaterialBody::with_density`"
    )]
    NoMasses {
        /// Name of the body.
        body: String,
    },
    /// Bodies of different spaces.
    #[error(
        "body `{body}` and the first one are not in the same space, expected bodies of revolution only, or none"
    )]
    Spaces {
        /// Name of the body.
        body: String,
    },
    /// A mesh of bodies of revolution that reaches across their axis.
    #[error("the mesh of bodies of revolution reaches to r = {radius}, expected r of at least 0")]
    BeyondAxis {
        /// The lowest radius, at the start or at the end of a stage `[L]`.
        radius: f64,
    },
    /// A mesh of bodies of revolution whose line at the axis moves.
    #[error("the mesh moves away from the axis: a node that is on it at the start is at r = {radius} later")]
    LeavesAxis {
        /// Radius of the node at the end of a stage `[L]`.
        radius: f64,
    },
    /// A support that drives nodes on the axis of bodies of revolution away from it.
    #[error("support `{support}` drives a node on the axis r = 0 along r, where nothing can leave the axis")]
    DrivenAxis {
        /// Name of the support.
        support: String,
    },
    /// A force per volume on points that do not know where they rested.
    #[error(
        "a force per volume acts on body `{body}`, whose points do not keep their positions at rest, expected \
        `MaterialBody::with_reference_positions`"
    )]
    NoRest {
        /// Name of the body.
        body: String,
    },
}

impl<const D: usize> Model<D> {
    /// Refuses a model of which nobody has the other points.
    pub(crate) fn check_whole(&self) -> Result<(), ModelError> {
        if self.share.is_some() { Err(ModelError::Share) } else { Ok(()) }
    }

    /// Refuses models that cannot be run; every run begins with this check.
    ///
    /// # Errors
    /// The first thing that is wrong.
    pub fn check(&self) -> Result<(), ModelError> {
        self.check_nodes()?;
        self.check_stages()?;
        self.check_axis()?;
        let weightless = self.bodies.iter().find(|named| !named.body.has_masses());
        if let Some(named) = weightless.filter(|_| !self.loads.body_forces.is_empty()) {
            return Err(ModelError::NoMasses { body: named.name.clone() });
        }
        let keeps_rest =
            |body: &dyn Body<D>| body.n_points() == 0 || body.point(0).reference_position.is_some();
        let mut pushed = self.loads.fields.iter().map(|&(index, _)| &self.bodies[index]);
        if let Some(named) = pushed.find(|named| !keeps_rest(&*named.body)) {
            return Err(ModelError::NoRest { body: named.name.clone() });
        }
        let mut seen = BTreeSet::new();
        if let Some(named) = self.contributions.iter().find(|named| !seen.insert(&named.name)) {
            return Err(ModelError::SameContribution { name: named.name.clone() });
        }
        let mut seen = BTreeSet::new();
        let mut columns = columns(self).into_iter().map(|column| column.name);
        if let Some(column) = columns.find(|name| !seen.insert(name.clone())) {
            let has =
                |named: &&NamedContribution<D>| named.contribution.history().iter().any(|it| it.name == column);
            let last = self.contributions.iter().rfind(has).map_or("", |named| &named.name);
            return Err(ModelError::SameColumn { contribution: last.into(), column });
        }
        Ok(())
    }

    /// Refuses bodies of different spaces and, of bodies of revolution, a mesh and supports that would leave the half plane
    /// r ≥ 0 at the start of the run or at the end of a stage.
    ///
    /// # Errors
    /// The first thing that is wrong.
    pub fn check_axis(&self) -> Result<(), ModelError> {
        let space = self.space();
        if let Some(named) = self.bodies.iter().find(|named| named.body.space() != space) {
            return Err(ModelError::Spaces { body: named.name.clone() });
        }
        let Some(mesh) = self.motion.mesh_at(&self.layout, LoadFraction::START).ok() else { return Ok(()) };
        if !space.is_axisymmetric() {
            return Ok(());
        }
        let (radius, width) = (mesh.bounds().0[0], mesh.axis_width());
        if radius < -width {
            return Err(ModelError::BeyondAxis { radius });
        }
        let ends = (0..self.stages.len() as u32).map(|stage| LoadFraction::start_of(stage).with_value(1.0));
        for moved in ends.filter_map(|end| self.motion.mesh_at(&self.layout, end).ok()) {
            let (low, away) = (moved.bounds().0[0], moved.distance_from_axis(&mesh));
            if low < -width {
                return Err(ModelError::BeyondAxis { radius: low });
            }
            if away > width {
                return Err(ModelError::LeavesAxis { radius: away });
            }
        }
        let is_on_axis = |&node: &NodeId| self.nodes.position(&mesh, node)[0] <= width;
        let drives = |support: &&Support<D>| {
            matches!(support.components[0], Some(Prescribed::Driven(_) | Prescribed::Turned(_)))
        };
        match self.supports.iter().filter(drives).find(|support| support.nodes.iter().any(is_on_axis)) {
            Some(support) => Err(ModelError::DrivenAxis { support: support.name.clone() }),
            None => Ok(()),
        }
    }

    fn check_stages(&self) -> Result<(), ModelError> {
        if self.stages.is_empty() {
            return Err(ModelError::NoStages);
        }
        let mut resets = self.stages.iter().filter(|stage| stage.resets_displacements);
        match resets.next().filter(|_| !self.loads.fields.is_empty()) {
            Some(stage) => Err(ModelError::NoRestAfterReset { stage: stage.name.clone() }),
            None => Ok(()),
        }
    }
}
