//! The law of a body and what it remembers of the points, behind an interface that does not name the law.

use crate::body::advance::PreparedState;
use crate::body::assembly_plan::AssemblyPlan;
use crate::body::points::Points;
use crate::body::regularised::FieldPoint;
use crate::body::scatter::{PassInput, Sums};
use crate::body::space::Space;
use crate::body::start::{PointStart, RefusedStart};
use crate::body::stored::ForeignPoints;
use crate::body::trial::InadmissiblePoint;
use mpm_grid::Vector;
use mpm_linear::Symmetry;
use mpm_material::{Elasticity, FieldInfo, Regularisation, SymmetricTensor};

/// What is compiled for each law. `points` are those of the body.
pub(crate) trait BodyLaw<const D: usize>: Send + Sync {
    /// The space that it is compiled for.
    fn space(&self) -> Space;

    /// The law, with what it remembers of the points, of a body of revolution that turns.
    fn with_twist(self: Box<Self>) -> Box<dyn BodyLaw<3>>;

    /// The nodal field that regularises it, if one does.
    fn regularisation(&self) -> Option<Regularisation> {
        None
    }

    /// About the width of shear bands that the field allows, where there is one and bands can form `[L]`.
    fn band_width(&self) -> Option<f64> {
        None
    }

    /// What the field sees of a point, where there is one.
    fn field_point(&self, points: &Points<D>, point: usize) -> FieldPoint<D> {
        let (volume, deformation_gradient) =
            (points.reference_volume[point], points.deformation_gradient[point]);
        FieldPoint { volume, deformation_gradient, driver: 0.0, driver_step: 0.0 }
    }

    fn can_yield(&self) -> bool;

    fn symmetry(&self) -> Symmetry;

    /// Of small strains around no stress.
    fn elasticity(&self) -> Elasticity;

    fn history_fields(&self) -> Vec<FieldInfo>;

    /// Appends what is shown of a point's history.
    fn show_history(&self, point: usize, to: &mut Vec<f64>);

    /// Whether the law has an apex at any point.
    fn has_apex(&self) -> bool;

    /// Points that yield there.
    fn points_at_apex(&self, points: &Points<D>) -> usize;

    /// As [`Material::undrained_strength`], of a point.
    fn undrained_strength(&self, point: usize) -> Option<f64>;

    /// Bytes of all histories.
    fn history_bytes(&self) -> usize;

    /// Gives points the histories and elastic states with which they begin: one start for each point, or none if all
    /// begin free of stress.
    fn begin(&mut self, points: &mut Points<D>, starts: &[PointStart]) -> Result<(), RefusedStart>;

    /// As [`pass::assemble`], and of a law under a nodal field as [`regularised::pass::assemble`].
    fn assemble(
        &self,
        points: &Points<D>,
        plan: &AssemblyPlan<D>,
        input: PassInput<'_, D>,
        sums: Sums<'_, D>,
    ) -> Result<f64, InadmissiblePoint>;

    /// As [`dissipation::dissipation`]; the trial displacement comes with the unknowns that belong to no node's
    /// displacement.
    fn dissipation(
        &self,
        points: &Points<D>,
        plan: &AssemblyPlan<D>,
        trial: (&[Vector<D>], &[f64]),
        gradient: &mut [Vector<D>],
    ) -> Result<f64, InadmissiblePoint>;

    /// Works out the state after a load step of a balanced displacement and the other unknowns; the histories are kept here until [`Self::commit`].
    fn advance(
        &mut self,
        points: &Points<D>,
        plan: &AssemblyPlan<D>,
        balanced: (&[Vector<D>], &[f64]),
        next: &mut PreparedState<D>,
    ) -> Result<(), InadmissiblePoint>;

    /// Makes the histories that were worked out or read the present ones.
    fn commit(&mut self);

    /// Gives each point the history of the point of before that `parts` names with its share.
    fn divide(&mut self, parts: &[(usize, f64)]);

    /// Kirchhoff's stress of a point `[F/L²]`.
    fn kirchhoff(&self, points: &Points<D>, point: usize) -> SymmetricTensor;

    /// Energy that a point stores per volume at rest `[F/L²]`.
    fn stored_energy(&self, points: &Points<D>, point: usize) -> f64;

    /// Numbers of a stored history.
    fn history_numbers(&self) -> usize;

    /// Appends the numbers of all histories.
    fn store_history(&self, to: &mut Vec<f64>);

    /// Reads the histories of `n` points; they are kept here until [`Self::commit`].
    fn restore_history(&mut self, values: &[f64], n: usize) -> Result<(), ForeignPoints>;
}
