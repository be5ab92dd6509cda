//! The law of a body and what it remembers of the points, behind an interface that does not name the law.

use crate::body::advance::PreparedState;
use crate::body::assembly_plan::AssemblyPlan;
use crate::body::dissipation;
use crate::body::pass;
use crate::body::points::{Points, at_rest};
use crate::body::scatter::{PassInput, Sums};
use crate::body::space::Space;
use crate::body::start::{PointStart, RefusedStart};
use crate::body::stored::ForeignPoints;
use crate::body::trial::{Committed, InadmissiblePoint};
use mpm_grid::Vector;
use mpm_linear::Symmetry;
use mpm_material::{
    Elasticity, FieldInfo, History, Material, PointParameters, SymmetricTensor, is_at_apex, respond,
    start_under, stored_energy,
};
use nalgebra::Matrix3;

/// What is compiled for each law. `points` are those of the body.
pub(crate) trait BodyLaw<const D: usize>: Send + Sync {
    /// The space that it is compiled for.
    fn space(&self) -> Space;

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

    /// As [`pass::assemble`].
    fn assemble(
        &self,
        points: &Points<D>,
        plan: &AssemblyPlan<D>,
        input: PassInput<'_, D>,
        sums: Sums<'_, D>,
    ) -> Result<f64, InadmissiblePoint>;

    /// As [`dissipation::dissipation`].
    fn dissipation(
        &self,
        points: &Points<D>,
        plan: &AssemblyPlan<D>,
        increment: &[Vector<D>],
        gradient: &mut [Vector<D>],
    ) -> Result<f64, InadmissiblePoint>;

    /// Works out the state after a load step; the histories are kept here until [`Self::commit`].
    fn advance(
        &mut self,
        points: &Points<D>,
        plan: &AssemblyPlan<D>,
        increment: &[Vector<D>],
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

/// A law that a body can be given in the place of its own, see [`Body::set_law`](super::interface::Body::set_law).
pub struct LawOfBody<const D: usize>(pub(super) Box<dyn BodyLaw<D>>);

impl<const D: usize> LawOfBody<D> {
    /// Takes a law.
    pub fn new<M: Material + 'static>(law: M) -> Self {
        Self(Box::new(LawOf::<M, false>::new(law)))
    }

    /// The space that the law is compiled for.
    pub fn space(&self) -> Space {
        self.0.space()
    }
}

impl LawOfBody<2> {
    /// Takes a law for a body of revolution: the hoop is its third axis.
    pub fn axisymmetric<M: Material + 'static>(law: M) -> Self {
        Self(Box::new(LawOf::<M, true>::new(law)))
    }
}

/// A law and its histories; compiled with or without a hoop.
struct LawOf<M: Material, const HOOP: bool> {
    law: M,
    /// One for each point; zero bytes for elasticity.
    history: Vec<M::History>,
    /// Of the next step, kept for its memory.
    next_history: Vec<M::History>,
}

impl<M: Material, const HOOP: bool> LawOf<M, HOOP> {
    fn new(law: M) -> Self {
        Self { law, history: Vec::new(), next_history: Vec::new() }
    }

    fn committed<'a, const D: usize>(&'a self, points: &'a Points<D>) -> Committed<'a, D, M> {
        Committed { law: &self.law, points, history: &self.history }
    }
}

impl<const D: usize, M: Material, const HOOP: bool> BodyLaw<D> for LawOf<M, HOOP> {
    fn space(&self) -> Space {
        if HOOP { Space::Axisymmetric } else { Space::Cartesian }
    }

    fn can_yield(&self) -> bool {
        M::PLASTIC
    }

    fn symmetry(&self) -> Symmetry {
        if self.law.has_symmetric_tangent() { Symmetry::Symmetric } else { Symmetry::Unsymmetric }
    }

    fn elasticity(&self) -> Elasticity {
        self.law.elasticity()
    }

    fn history_fields(&self) -> Vec<FieldInfo> {
        self.law.history_fields()
    }

    fn show_history(&self, point: usize, to: &mut Vec<f64>) {
        self.law.show(&self.history[point], to);
    }

    fn has_apex(&self) -> bool {
        M::PLASTIC && self.history.iter().any(|history| self.law.apex(history).is_some())
    }

    fn points_at_apex(&self, points: &Points<D>) -> usize {
        let is_there = |&p: &usize| {
            points.plastic[p] && is_at_apex(&self.law, &points.elastic_excess[p], &self.history[p])
        };
        (0..points.len()).filter(is_there).count()
    }

    fn undrained_strength(&self, point: usize) -> Option<f64> {
        self.law.undrained_strength(&self.history[point])
    }

    fn history_bytes(&self) -> usize {
        size_of_val(&self.history[..])
    }

    fn begin(&mut self, points: &mut Points<D>, starts: &[PointStart]) -> Result<(), RefusedStart> {
        let default = PointStart::default();
        self.history.clear();
        for (point, position) in points.position.iter().enumerate() {
            let start = starts.get(point).unwrap_or(&default);
            let mut parameters = PointParameters::at(at_rest(position));
            (parameters.own, parameters.consolidation) = (start.own, start.consolidation);
            let (excess, history) = match &start.stress {
                None => (SymmetricTensor::ZERO, self.law.initial(&parameters)),
                Some(stress) => start_under(&self.law, &parameters, stress)
                    .map_err(|reason| RefusedStart { point, reason })?,
            };
            points.elastic_excess[point] = excess;
            self.history.push(history);
        }
        Ok(())
    }

    fn assemble(
        &self,
        points: &Points<D>,
        plan: &AssemblyPlan<D>,
        input: PassInput<'_, D>,
        sums: Sums<'_, D>,
    ) -> Result<f64, InadmissiblePoint> {
        pass::assemble::<D, M, HOOP>(self.committed(points), plan, input, sums)
    }

    fn dissipation(
        &self,
        points: &Points<D>,
        plan: &AssemblyPlan<D>,
        increment: &[Vector<D>],
        gradient: &mut [Vector<D>],
    ) -> Result<f64, InadmissiblePoint> {
        dissipation::dissipation::<D, M, HOOP>(self.committed(points), plan, increment, gradient)
    }

    fn advance(
        &mut self,
        points: &Points<D>,
        plan: &AssemblyPlan<D>,
        increment: &[Vector<D>],
        next: &mut PreparedState<D>,
    ) -> Result<(), InadmissiblePoint> {
        let committed = Committed { law: &self.law, points, history: &self.history };
        next.advance::<M, HOOP>(&mut self.next_history, committed, plan, increment)
    }

    fn commit(&mut self) {
        std::mem::swap(&mut self.history, &mut self.next_history);
    }

    fn divide(&mut self, parts: &[(usize, f64)]) {
        self.history = parts.iter().map(|&(point, _)| self.history[point]).collect();
    }

    fn kirchhoff(&self, points: &Points<D>, point: usize) -> SymmetricTensor {
        // The committed elastic state is admissible, so the law answers elastically.
        respond(&self.law, &points.elastic_excess[point], &self.history[point])
            .map_or(SymmetricTensor::from_matrix(&Matrix3::repeat(f64::NAN)), |it| it.kirchhoff)
    }

    fn stored_energy(&self, points: &Points<D>, point: usize) -> f64 {
        stored_energy(&self.law, &points.elastic_excess[point], &self.history[point])
    }

    fn history_numbers(&self) -> usize {
        M::History::NUMBERS
    }

    fn store_history(&self, to: &mut Vec<f64>) {
        self.history.iter().for_each(|history| history.store(to));
    }

    fn restore_history(&mut self, values: &[f64], n: usize) -> Result<(), ForeignPoints> {
        let width = M::History::NUMBERS;
        let restore = |p: usize| {
            M::History::restore(&values[p * width..(p + 1) * width])
                .map_err(|reason| ForeignPoints { column: "history", reason: format!("point {p}: {reason}") })
        };
        self.next_history = (0..n).map(restore).collect::<Result<_, _>>()?;
        Ok(())
    }
}
