//! The end of a load step: points take the state of the converged displacement.

use crate::dilatation::Dilated;
use crate::pass::{Connection, Trial, trial, trial_of};
use crate::{InvertedPoint, Points};
use mpm_basis::{ActiveNodes, Basis, Convection, ConvectionError};
use mpm_grid::{Block, Mesh, Vector};
use mpm_material::{Material, SymmetricTensor};

/// Groups per task; fixed, so that nothing depends on the number of threads.
const GROUPS: usize = 256;

/// A point that could not be carried through a load step.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum AdvanceError {
    /// Its increment of deformation is not admissible.
    #[error(transparent)]
    Inverted(#[from] InvertedPoint),
    /// Its domain cannot be carried on.
    #[error("material point {point} at {position:?}: {reason}")]
    Domain {
        /// Index of the point in its body.
        point: usize,
        /// Where it is at the start of the step `[L]`.
        position: Vec<f64>,
        /// What is wrong with its domain.
        reason: ConvectionError,
    },
}

/// What a converged load step is for the points.
#[derive(Clone, Copy)]
pub struct Converged<'a, const D: usize> {
    /// Mesh of the step.
    pub mesh: &'a Mesh<D>,
    /// Nodes of the step.
    pub active: &'a ActiveNodes<D>,
    /// `Δu_v` of every active node `[L]`.
    pub increment: &'a [Vector<D>],
}

/// The columns of the points that a load step changes, worked out beside the present ones.
///
/// Kept from step to step: a step writes them all, and [`Prepared::swap`] exchanges them for the
/// present ones.
pub struct Prepared<const D: usize, B: Basis<D>, M: Material> {
    position: Vec<Vector<D>>,
    domain: Vec<B::Domain>,
    deformation_gradient: Vec<Block<D>>,
    elastic_excess: Vec<SymmetricTensor>,
    history: Vec<M::History>,
    plastic: Vec<bool>,
}

// Derived `Default` would ask for `B: Default` and `M: Default`.
impl<const D: usize, B: Basis<D>, M: Material> Default for Prepared<D, B, M> {
    fn default() -> Self {
        Self {
            position: Vec::new(),
            domain: Vec::new(),
            deformation_gradient: Vec::new(),
            elastic_excess: Vec::new(),
            history: Vec::new(),
            plastic: Vec::new(),
        }
    }
}

impl<const D: usize, B: Basis<D>, M: Material> Prepared<D, B, M> {
    /// Works out the points after the step: positions move by `Σ_v S_vp Δu_v`, domains are convected,
    /// the trial state of the law becomes the committed one.
    ///
    /// # Errors
    /// The first point (in order) that cannot be carried on.
    pub fn advance(
        &mut self,
        basis: &B,
        law: &M,
        points: &Points<D, B, M>,
        connection: &Connection<D>,
        step: Converged<'_, D>,
    ) -> Result<(), AdvanceError> {
        let n = points.len();
        // Points move from where they are; all else is written anew.
        self.position.clone_from(&points.position);
        self.domain.clone_from(&points.domain);
        self.deformation_gradient.resize(n, Block::zeros());
        self.elastic_excess.resize(n, SymmetricTensor::ZERO);
        self.history.resize(n, M::History::default());
        self.plastic.resize(points.plastic.len(), false);
        let columns = Columns {
            position: &mut self.position,
            domain: &mut self.domain,
            deformation_gradient: &mut self.deformation_gradient,
            elastic_excess: &mut self.elastic_excess,
            history: &mut self.history,
            plastic: &mut self.plastic,
        };
        let links = connection.links();
        let dilated = match connection.dilatation() {
            None => Vec::new(),
            Some(dilatation) => {
                Dilated { law, points, links, dilatation, increment: step.increment }.steps()?
            }
        };
        let work = Work { basis, law, points, connection, step, dilated };
        work.groups(0, connection.links().n_groups(), columns)
    }

    /// Makes the prepared columns the present ones.
    pub fn swap(&mut self, points: &mut Points<D, B, M>) {
        std::mem::swap(&mut self.position, &mut points.position);
        std::mem::swap(&mut self.domain, &mut points.domain);
        std::mem::swap(&mut self.deformation_gradient, &mut points.deformation_gradient);
        std::mem::swap(&mut self.elastic_excess, &mut points.elastic_excess);
        std::mem::swap(&mut self.history, &mut points.history);
        std::mem::swap(&mut self.plastic, &mut points.plastic);
    }
}

struct Work<'a, const D: usize, B: Basis<D>, M: Material> {
    basis: &'a B,
    law: &'a M,
    points: &'a Points<D, B, M>,
    connection: &'a Connection<D>,
    step: Converged<'a, D>,
    /// `ΔF̄ - I` of every point; empty without mean dilatation.
    dilated: Vec<Block<D>>,
}

/// The written columns of a run of points.
struct Columns<'a, const D: usize, Domain, History> {
    position: &'a mut [Vector<D>],
    domain: &'a mut [Domain],
    deformation_gradient: &'a mut [Block<D>],
    elastic_excess: &'a mut [SymmetricTensor],
    history: &'a mut [History],
    plastic: &'a mut [bool],
}

impl<'a, const D: usize, Domain, History> Columns<'a, D, Domain, History> {
    fn split_at(self, at: usize) -> (Self, Self) {
        let (position, position_rest) = self.position.split_at_mut(at);
        let (domain, domain_rest) = self.domain.split_at_mut(at);
        let (deformation_gradient, deformation_gradient_rest) = self.deformation_gradient.split_at_mut(at);
        let (elastic_excess, elastic_excess_rest) = self.elastic_excess.split_at_mut(at);
        let (history, history_rest) = self.history.split_at_mut(at);
        let (plastic, plastic_rest) = self.plastic.split_at_mut(at.min(self.plastic.len()));
        (
            Self { position, domain, deformation_gradient, elastic_excess, history, plastic },
            Self {
                position: position_rest,
                domain: domain_rest,
                deformation_gradient: deformation_gradient_rest,
                elastic_excess: elastic_excess_rest,
                history: history_rest,
                plastic: plastic_rest,
            },
        )
    }
}

impl<const D: usize, B: Basis<D>, M: Material> Work<'_, D, B, M> {
    /// Advances the points of the groups `from..to`, halving the range until it is small.
    fn groups(
        &self,
        from: usize,
        to: usize,
        mut columns: Columns<'_, D, B::Domain, M::History>,
    ) -> Result<(), AdvanceError> {
        let links = self.connection.links();
        if to - from > GROUPS {
            let middle = (from + to) / 2;
            let at = links.group_points(middle).start - links.group_points(from).start;
            let (low, high) = columns.split_at(at);
            let (low, high) = rayon::join(|| self.groups(from, middle, low), || self.groups(middle, to, high));
            return low.and(high);
        }
        let mut du = Vec::new();
        let mut at = 0;
        for group in from..to {
            let view = links.group(group);
            du.clear();
            du.extend(view.nodes.iter().map(|&node| self.step.increment[node as usize]));
            for k in 0..view.points {
                let (values, gradients) = view.point(k);
                let p = view.first_point + k;
                let state = match self.dilated.get(p) {
                    None => trial(self.law, self.points, p, &du, gradients)?,
                    Some(step) => trial_of(self.law, self.points, p, *step)?,
                };
                let mut displacement = Vector::zeros();
                for (value, du) in values.iter().zip(&du) {
                    displacement += du * *value;
                }
                self.write(p, displacement, state, &mut columns, at)?;
                at += 1;
            }
        }
        Ok(())
    }

    /// Writes the state of point `p` to place `at` of the columns.
    fn write(
        &self,
        p: usize,
        displacement: Vector<D>,
        state: Trial<D, M::History>,
        columns: &mut Columns<'_, D, B::Domain, M::History>,
        at: usize,
    ) -> Result<(), AdvanceError> {
        let deformation_gradient = state.step * self.points.deformation_gradient[p];
        columns.deformation_gradient[at] = deformation_gradient;
        columns.elastic_excess[at] = state.response.elastic_excess;
        columns.history[at] = state.response.history;
        if M::PLASTIC {
            columns.plastic[at] = state.response.plastic;
        }
        let convection = Convection {
            displacement,
            deformation_gradient,
            mesh: self.step.mesh,
            active: self.step.active,
            increment: self.step.increment,
        };
        self.basis.convect(&mut columns.domain[at], &mut columns.position[at], &convection).map_err(|reason| {
            AdvanceError::Domain {
                point: p,
                position: self.points.position[p].iter().copied().collect(),
                reason,
            }
        })
    }
}
