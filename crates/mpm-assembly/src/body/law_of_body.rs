//! What is compiled for each law: passes over the points of a body, and what the law remembers of these.

use crate::body::advance::PreparedState;
use crate::body::assembly_plan::AssemblyPlan;
use crate::body::body_law::BodyLaw;
use crate::body::by_point::{Asked, PointLaw};
use crate::body::dissipation;
use crate::body::pass;
use crate::body::points::{Points, at_rest};
use crate::body::scatter::{PassInput, Sums};
use crate::body::space::Space;
use crate::body::start::{PointStart, RefusedStart};
use crate::body::stored::ForeignPoints;
use crate::body::trial::{Committed, InadmissiblePoint};
use crate::body::turning_law::Turning;
use mpm_basis::parallel::each_point;
use mpm_grid::Vector;
use mpm_linear::Symmetry;
use mpm_material::{
    Elasticity, FieldInfo, History, Material, NoReturn, PointParameters, SymmetricTensor, Update, is_at_apex,
    respond, start_under, stored_energy,
};
use nalgebra::{Matrix3, Vector3};

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
pub(super) struct LawOf<M: Material, const HOOP: bool> {
    pub law: M,
    /// One for each point; zero bytes for elasticity.
    pub history: Vec<M::History>,
    /// Of the next step, kept for its memory.
    pub next_history: Vec<M::History>,
}

impl<M: Material, const HOOP: bool> LawOf<M, HOOP> {
    pub fn new(law: M) -> Self {
        Self { law, history: Vec::new(), next_history: Vec::new() }
    }

    fn committed<'a, const D: usize>(&'a self, points: &'a Points<D>) -> Committed<'a, D, M> {
        Committed { law: &self.law, points, history: &self.history }
    }
}

impl<const D: usize, M: Material + 'static, const HOOP: bool> BodyLaw<D> for LawOf<M, HOOP> {
    fn space(&self) -> Space {
        if HOOP { Space::Axisymmetric } else { Space::Cartesian }
    }

    fn with_twist(self: Box<Self>) -> Box<dyn BodyLaw<3>> {
        let Self { law, history, next_history } = *self;
        let asked = Asked::all(history.len());
        Box::new(TurningLaw { law: LawOf { law, history, next_history }, asked, next: Vec::new() })
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
        let begun = |point: usize| {
            let start = starts.get(point).unwrap_or(&default);
            let mut parameters = PointParameters::at(at_rest(&points.position[point]));
            (parameters.own, parameters.consolidation) = (start.own, start.consolidation);
            match &start.stress {
                None => Ok((SymmetricTensor::ZERO, self.law.initial(&parameters))),
                Some(stress) => {
                    start_under(&self.law, &parameters, stress).map_err(|reason| RefusedStart { point, reason })
                }
            }
        };
        let n = points.len();
        if starts.is_empty() {
            // Points that begin free of stress are refused by no law.
            let history = |point| begun(point).map_or_else(|_| unreachable!("no stress"), |it| it.1);
            self.history = each_point(n, &history);
            points.elastic_excess = each_point(n, &|_| SymmetricTensor::ZERO);
            return Ok(());
        }
        let begun: Vec<_> = each_point(n, &begun).into_iter().collect::<Result<_, _>>()?;
        (points.elastic_excess, self.history) = begun.into_iter().unzip();
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
        (increment, _): (&[Vector<D>], &[f64]),
        gradient: &mut [Vector<D>],
    ) -> Result<f64, InadmissiblePoint> {
        dissipation::dissipation::<D, M, HOOP>(self.committed(points), plan, increment, gradient)
    }

    fn advance(
        &mut self,
        points: &Points<D>,
        plan: &AssemblyPlan<D>,
        (increment, _): (&[Vector<D>], &[f64]),
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

impl<M: Material> PointLaw for LawOf<M, false> {
    fn has_symmetric_tangent(&self) -> bool {
        self.law.has_symmetric_tangent()
    }

    fn elasticity(&self) -> Elasticity {
        self.law.elasticity()
    }

    fn stored_energy(&self, point: usize, elastic_strain: &Vector3<f64>) -> f64 {
        self.law.stored_energy(elastic_strain, &self.history[point])
    }

    fn fluid_stress(&self, point: usize, volumetric: f64) -> f64 {
        self.law.fluid_stress(volumetric, &self.history[point])
    }

    fn update(&self, point: usize, trial: &Vector3<f64>, _field: f64) -> Result<Update<()>, NoReturn> {
        Ok(self.law.update(trial, &self.history[point])?.without_history())
    }
}

/// The law of a body of revolution that turns: no pass is compiled for it, see `turning_law.rs`.
struct TurningLaw<M: Material> {
    law: LawOf<M, false>,
    /// One for each point.
    asked: Vec<Asked>,
    /// Of the next step, kept for its memory.
    next: Vec<Asked>,
}

impl<M: Material + 'static> TurningLaw<M> {
    fn turning<'a>(&'a self, points: &'a Points<3>) -> Turning<'a> {
        Turning { law: &self.law, asked: &self.asked, points }
    }

    /// Numbers the points anew.
    fn count(&mut self) {
        self.asked = Asked::all(self.law.history.len());
    }
}

impl<M: Material + 'static> BodyLaw<3> for TurningLaw<M> {
    fn space(&self) -> Space {
        Space::Axisymmetric
    }

    fn with_twist(self: Box<Self>) -> Box<dyn BodyLaw<3>> {
        self
    }

    fn can_yield(&self) -> bool {
        BodyLaw::<3>::can_yield(&self.law)
    }

    fn symmetry(&self) -> Symmetry {
        BodyLaw::<3>::symmetry(&self.law)
    }

    fn elasticity(&self) -> Elasticity {
        BodyLaw::<3>::elasticity(&self.law)
    }

    fn history_fields(&self) -> Vec<FieldInfo> {
        BodyLaw::<3>::history_fields(&self.law)
    }

    fn show_history(&self, point: usize, to: &mut Vec<f64>) {
        BodyLaw::<3>::show_history(&self.law, point, to);
    }

    fn has_apex(&self) -> bool {
        BodyLaw::<3>::has_apex(&self.law)
    }

    fn points_at_apex(&self, points: &Points<3>) -> usize {
        BodyLaw::<3>::points_at_apex(&self.law, points)
    }

    fn undrained_strength(&self, point: usize) -> Option<f64> {
        BodyLaw::<3>::undrained_strength(&self.law, point)
    }

    fn history_bytes(&self) -> usize {
        BodyLaw::<3>::history_bytes(&self.law) + size_of_val(&self.asked[..])
    }

    fn begin(&mut self, points: &mut Points<3>, starts: &[PointStart]) -> Result<(), RefusedStart> {
        BodyLaw::<3>::begin(&mut self.law, points, starts)?;
        self.count();
        Ok(())
    }

    fn assemble(
        &self,
        points: &Points<3>,
        plan: &AssemblyPlan<3>,
        input: PassInput<'_, 3>,
        sums: Sums<'_, 3>,
    ) -> Result<f64, InadmissiblePoint> {
        self.turning(points).assemble(plan, input, sums)
    }

    fn dissipation(
        &self,
        points: &Points<3>,
        plan: &AssemblyPlan<3>,
        (increment, _): (&[Vector<3>], &[f64]),
        gradient: &mut [Vector<3>],
    ) -> Result<f64, InadmissiblePoint> {
        self.turning(points).dissipation(plan, increment, gradient)
    }

    fn advance(
        &mut self,
        points: &Points<3>,
        plan: &AssemblyPlan<3>,
        (increment, _): (&[Vector<3>], &[f64]),
        next: &mut PreparedState<3>,
    ) -> Result<(), InadmissiblePoint> {
        let mut asked = std::mem::take(&mut self.next);
        self.turning(points).advance(plan, increment, next, &mut asked)?;
        // The law answers the same strains again, now with what it remembers.
        let LawOf { law, history, next_history } = &mut self.law;
        next_history.clear();
        for (point, (asked, history)) in asked.iter().zip(&*history).enumerate() {
            let update = law.update(&asked.trial, history);
            next_history.push(update.map_err(|reason| InadmissiblePoint::no_return(point, reason))?.history);
        }
        self.next = asked;
        Ok(())
    }

    fn commit(&mut self) {
        BodyLaw::<3>::commit(&mut self.law);
        if self.asked.len() != self.law.history.len() {
            self.count();
        }
    }

    fn divide(&mut self, parts: &[(usize, f64)]) {
        BodyLaw::<3>::divide(&mut self.law, parts);
        self.count();
    }

    fn kirchhoff(&self, points: &Points<3>, point: usize) -> SymmetricTensor {
        BodyLaw::<3>::kirchhoff(&self.law, points, point)
    }

    fn stored_energy(&self, points: &Points<3>, point: usize) -> f64 {
        BodyLaw::<3>::stored_energy(&self.law, points, point)
    }

    fn history_numbers(&self) -> usize {
        BodyLaw::<3>::history_numbers(&self.law)
    }

    fn store_history(&self, to: &mut Vec<f64>) {
        BodyLaw::<3>::store_history(&self.law, to);
    }

    fn restore_history(&mut self, values: &[f64], n: usize) -> Result<(), ForeignPoints> {
        BodyLaw::<3>::restore_history(&mut self.law, values, n)
    }
}
