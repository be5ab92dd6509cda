//! A law under a nodal field, and what it remembers of the points.

use super::measure::ShearMeasure;
use super::pass;
use super::plan::{FieldPoint, lumped_energy};
use super::trial::{FieldLaw, Regularised, at_rest};
use crate::body::advance::PreparedState;
use crate::body::assembly_plan::AssemblyPlan;
use crate::body::body_law::BodyLaw;
use crate::body::by_point::{Asked, ByPoint, PointLaw};
use crate::body::kinematics::block;
use crate::body::law_of_body::{LawOf, LawOfBody};
use crate::body::points::Points;
use crate::body::scatter::{PassInput, Sums};
use crate::body::space::Space;
use crate::body::start::{PointStart, RefusedStart};
use crate::body::stored::ForeignPoints;
use crate::body::trial::{Committed, InadmissiblePoint};
use mpm_grid::{Block, Vector};
use mpm_linear::Symmetry;
use mpm_material::{
    Elasticity, FieldCoupling, FieldDriver, FieldInfo, FieldResponse, FieldUpdate, History, Material, NoReturn,
    ParameterError, Regularisable, Regularisation, SymmetricTensor, Update, respond_with_field,
};
use nalgebra::{Matrix3, Vector3};

impl<const D: usize> LawOfBody<D> {
    /// Takes a law whose plastic strain drives a nodal field.
    ///
    /// # Errors
    /// The strength falls as fast as h, or faster: short waves of the strain would grow all the same.
    ///
    /// # Panics
    /// The regularisation has another driver.
    pub fn regularised<M: Regularisable + 'static>(
        law: M,
        regularisation: Regularisation,
    ) -> Result<Self, ParameterError> {
        assert_eq!(regularisation.driver(), FieldDriver::PlasticStrain, "the driver is the plastic strain");
        let (softening, modulus) = (law.fastest_softening(), regularisation.modulus());
        let expected = "above the fastest softening -dρ/dκ, or it holds no shear band together";
        ParameterError::unless(modulus > softening, "modulus", modulus, expected)?;
        let band = (softening > 0.0).then(|| regularisation.band_width(softening));
        Ok(Self(Box::new(RegularisedLaw::new(law, M::update_with_field, (regularisation, band)))))
    }

    /// Takes a law beside which the total shear drives a nodal field.
    ///
    /// # Panics
    /// The regularisation has another driver.
    pub fn regularised_by_strain<M: Material + 'static>(law: M, regularisation: Regularisation) -> Self {
        assert_eq!(regularisation.driver(), FieldDriver::Strain, "the driver is the strain");
        let answer = |law: &M, trial: &Vector3<f64>, history: &M::History, _field: FieldCoupling| {
            law.update(trial, history).map(|update| FieldUpdate::uncoupled(update, 0.0))
        };
        // A strength that falls as fast as h would.
        let band = regularisation.band_width(regularisation.modulus());
        Self(Box::new(RegularisedLaw::new(law, answer, (regularisation, Some(band)))))
    }
}

/// As [`Regularisable::update_with_field`].
type Answer<M> = fn(
    &M,
    &Vector3<f64>,
    &<M as Material>::History,
    FieldCoupling,
) -> Result<FieldUpdate<<M as Material>::History>, NoReturn>;

/// What is remembered of the field at a point.
#[derive(Clone, Copy, Debug, Default)]
struct FieldState {
    /// k `[-]`.
    field: f64,
    /// d `[-]`.
    driver: f64,
    /// By how much the last load step changed d.
    driver_step: f64,
    /// ½ A |Grad k|², and by how much a field that stands in part on the diagonal exceeds ½ h k² `[F/L²]`.
    gradient_energy: f64,
}

/// Numbers of a stored [`FieldState`].
const NUMBERS: usize = 4;

/// A law under a nodal field.
struct RegularisedLaw<M: Material> {
    law: LawOf<M, false>,
    answer: Answer<M>,
    regularisation: Regularisation,
    /// About the width of shear bands, if any can form `[L]`.
    band_width: Option<f64>,
    /// One for each point.
    state: Vec<FieldState>,
    /// Of the next step.
    next_state: Vec<FieldState>,
}

impl<M: Material> RegularisedLaw<M> {
    fn new(law: M, answer: Answer<M>, (regularisation, band_width): (Regularisation, Option<f64>)) -> Self {
        let law = LawOf::new(law);
        Self { law, answer, regularisation, band_width, state: Vec::new(), next_state: Vec::new() }
    }

    fn coupling(&self, value: f64) -> FieldCoupling {
        FieldCoupling { modulus: self.regularisation.modulus(), value }
    }

    fn of<'a, const D: usize>(&'a self, points: &'a Points<D>) -> Regularised<'a, D> {
        Regularised { law: self, points, regularisation: self.regularisation }
    }

    /// The field and its gradient energy at every point, under the unknowns `own`, with the numbers of the points.
    fn at_points<const D: usize>(
        &self,
        points: &Points<D>,
        plan: &AssemblyPlan<D>,
        own: &[f64],
    ) -> (Vec<Asked>, Vec<f64>) {
        let (connectivity, nodes) = (plan.connectivity(), &plan.field().nodes);
        let values = nodes.values(own);
        let mut asked = Asked::all(points.len());
        let mut energy = vec![0.0; points.len()];
        for group in (0..connectivity.n_groups()).map(|group| connectivity.group(group)) {
            for k in 0..group.points {
                let p = group.first_point + k;
                let (shapes, slopes) = group.point(k);
                let (mut gradient, mut mean_of_squares) = (Vector::<D>::zeros(), 0.0);
                for ((&node, shape), slope) in group.nodes.iter().zip(shapes).zip(slopes) {
                    let value = values[nodes.entry(node as usize)];
                    asked[p].field += value * shape;
                    gradient += slope * value;
                    mean_of_squares += shape * value * value;
                }
                let gradient = at_rest(&points.deformation_gradient[p], &gradient);
                energy[p] = 0.5 * self.regularisation.gradient_modulus() * gradient.norm_squared()
                    + lumped_energy(&self.regularisation, mean_of_squares, asked[p].field);
            }
        }
        (asked, energy)
    }
}

impl<M: Material> PointLaw for RegularisedLaw<M> {
    fn has_symmetric_tangent(&self) -> bool {
        self.law.law.has_symmetric_tangent()
    }

    fn elasticity(&self) -> Elasticity {
        self.law.law.elasticity()
    }

    fn stored_energy(&self, point: usize, elastic_strain: &Vector3<f64>) -> f64 {
        PointLaw::stored_energy(&self.law, point, elastic_strain)
    }

    fn fluid_stress(&self, point: usize, volumetric: f64) -> f64 {
        PointLaw::fluid_stress(&self.law, point, volumetric)
    }

    fn update(&self, point: usize, trial: &Vector3<f64>, field: f64) -> Result<Update<()>, NoReturn> {
        let LawOf { law, history, .. } = &self.law;
        Ok((self.answer)(law, trial, &history[point], self.coupling(field))?.update.without_history())
    }
}

impl<M: Material> FieldLaw for RegularisedLaw<M> {
    fn respond(
        &self,
        point: usize,
        trial_excess: &SymmetricTensor,
        field: f64,
    ) -> Result<FieldResponse<Asked>, NoReturn> {
        let LawOf { law, history, .. } = &self.law;
        let answer = |trial: &Vector3<f64>| {
            let found = (self.answer)(law, trial, &history[point], self.coupling(field))?;
            let asked = Asked::of(point, field, trial);
            let FieldUpdate { update, by_field, driver, driver_by_field } = found;
            let update = update.without_history().with_history(asked);
            Ok(FieldUpdate { update, by_field, driver, driver_by_field })
        };
        respond_with_field(answer, trial_excess)
    }

    fn driver(&self, point: usize) -> f64 {
        self.state[point].driver
    }
}

impl<const D: usize, M: Material + 'static> BodyLaw<D> for RegularisedLaw<M> {
    fn space(&self) -> Space {
        Space::Cartesian
    }

    fn with_twist(self: Box<Self>) -> Box<dyn BodyLaw<3>> {
        unreachable!("no body of revolution is regularised")
    }

    fn regularisation(&self) -> Option<Regularisation> {
        Some(self.regularisation)
    }

    fn band_width(&self) -> Option<f64> {
        self.band_width
    }

    fn field_point(&self, points: &Points<D>, point: usize) -> FieldPoint<D> {
        let FieldState { driver, driver_step, .. } = self.state[point];
        FieldPoint {
            volume: points.reference_volume[point],
            deformation_gradient: points.deformation_gradient[point],
            driver,
            driver_step,
        }
    }

    fn can_yield(&self) -> bool {
        M::PLASTIC
    }

    fn symmetry(&self) -> Symmetry {
        BodyLaw::<D>::symmetry(&self.law)
    }

    fn elasticity(&self) -> Elasticity {
        self.law.law.elasticity()
    }

    fn history_fields(&self) -> Vec<FieldInfo> {
        let name = match self.regularisation.driver() {
            FieldDriver::PlasticStrain => "nonlocal_plastic_strain",
            FieldDriver::Strain => "nonlocal_shear_measure",
        };
        let mut fields = BodyLaw::<D>::history_fields(&self.law);
        fields.push(FieldInfo { name, components: 1, unit: "-" });
        fields
    }

    fn show_history(&self, point: usize, to: &mut Vec<f64>) {
        BodyLaw::<D>::show_history(&self.law, point, to);
        to.push(self.state[point].field);
    }

    fn has_apex(&self) -> bool {
        BodyLaw::<D>::has_apex(&self.law)
    }

    fn points_at_apex(&self, points: &Points<D>) -> usize {
        self.law.points_at_apex(points)
    }

    fn undrained_strength(&self, point: usize) -> Option<f64> {
        BodyLaw::<D>::undrained_strength(&self.law, point)
    }

    fn history_bytes(&self) -> usize {
        BodyLaw::<D>::history_bytes(&self.law) + size_of_val(&self.state[..])
    }

    fn begin(&mut self, points: &mut Points<D>, starts: &[PointStart]) -> Result<(), RefusedStart> {
        self.law.begin(points, starts)?;
        self.state = vec![FieldState::default(); points.len()];
        Ok(())
    }

    fn assemble(
        &self,
        points: &Points<D>,
        plan: &AssemblyPlan<D>,
        input: PassInput<'_, D>,
        sums: Sums<'_, D>,
    ) -> Result<f64, InadmissiblePoint> {
        pass::assemble(self.of(points), plan, input, sums)
    }

    /// Summed point by point in order. The gradient is that of a law whose yield stress stays.
    fn dissipation(
        &self,
        points: &Points<D>,
        plan: &AssemblyPlan<D>,
        (increment, own): (&[Vector<D>], &[f64]),
        gradient: &mut [Vector<D>],
    ) -> Result<f64, InadmissiblePoint> {
        let (connectivity, nodes, of) = (plan.connectivity(), &plan.field().nodes, self.of(points));
        let (values, law) = (nodes.values(own), ByPoint(self));
        let (mut du, mut field, mut energy) = (Vec::new(), Vec::new(), 0.0);
        for group in (0..connectivity.n_groups()).map(|group| connectivity.group(group)) {
            du.clear();
            du.extend(group.nodes.iter().map(|&node| increment[node as usize]));
            field.clear();
            field.extend(group.nodes.iter().map(|&node| values[nodes.entry(node as usize)]));
            for k in 0..group.points {
                let (p, influences) = (group.first_point + k, group.point(k));
                let trial = of.trial(p, &du, &field, influences)?;
                if !trial.response.plastic {
                    continue;
                }
                let volume = points.reference_volume[p];
                energy += volume * of.dissipated(p, &trial, &law);
                let tau = trial.response.kirchhoff;
                let deviator = block::<D>(&tau) - Block::identity() * (tau.trace() / 3.0);
                for (&node, slope) in group.nodes.iter().zip(influences.1) {
                    gradient[node as usize] += deviator * trial.step.inverse.tr_mul(slope) * volume;
                }
            }
        }
        Ok(energy)
    }

    fn advance(
        &mut self,
        points: &Points<D>,
        plan: &AssemblyPlan<D>,
        (increment, own): (&[Vector<D>], &[f64]),
        next: &mut PreparedState<D>,
    ) -> Result<(), InadmissiblePoint> {
        let (asked, energy) = self.at_points(points, plan, own);
        let mut next_asked = Vec::new();
        let committed = Committed { law: &ByPoint(&*self), points, history: &asked };
        next.advance::<ByPoint<'_>, false>(&mut next_asked, committed, plan, increment)?;
        // The law answers the same strains again, now with what it remembers.
        let mut history = std::mem::take(&mut self.law.next_history);
        history.clear();
        self.next_state.clear();
        for (p, (asked, gradient_energy)) in next_asked.iter().zip(energy).enumerate() {
            let (law, before) = (&self.law.law, &self.law.history[p]);
            let found = (self.answer)(law, &asked.trial, before, self.coupling(asked.field))
                .map_err(|reason| InadmissiblePoint::no_return(p, reason))?;
            history.push(found.update.history);
            let driver = match self.regularisation.driver() {
                FieldDriver::PlasticStrain => found.driver,
                FieldDriver::Strain => ShearMeasure::of(&next.deformation_gradient()[p]).value,
            };
            let driver_step = driver - self.state[p].driver;
            self.next_state.push(FieldState { field: asked.field, driver, driver_step, gradient_energy });
        }
        self.law.next_history = history;
        Ok(())
    }

    fn commit(&mut self) {
        BodyLaw::<D>::commit(&mut self.law);
        std::mem::swap(&mut self.state, &mut self.next_state);
    }

    fn divide(&mut self, parts: &[(usize, f64)]) {
        BodyLaw::<D>::divide(&mut self.law, parts);
        self.state = parts.iter().map(|&(point, _)| self.state[point]).collect();
    }

    fn kirchhoff(&self, points: &Points<D>, point: usize) -> SymmetricTensor {
        let field = self.state[point].field;
        let mut tau = FieldLaw::respond(self, point, &points.elastic_excess[point], field)
            .map_or(SymmetricTensor::from_matrix(&Matrix3::repeat(f64::NAN)), |it| it.response.kirchhoff);
        if self.regularisation.driver() == FieldDriver::Strain {
            let measure = ShearMeasure::of(&points.deformation_gradient[point]);
            let added = measure.slope() * (self.regularisation.modulus() * (measure.value - field));
            let mut all = tau.to_matrix();
            for (i, j) in (0..D * D).map(|k| (k / D, k % D)) {
                all[(i, j)] += added[(i, j)];
            }
            tau = SymmetricTensor::from_matrix(&all);
        }
        tau
    }

    fn stored_energy(&self, points: &Points<D>, point: usize) -> f64 {
        let FieldState { field, driver, gradient_energy, .. } = self.state[point];
        let of_field = 0.5 * self.regularisation.modulus() * (driver - field).powi(2) + gradient_energy;
        BodyLaw::stored_energy(&self.law, points, point) + of_field
    }

    fn history_numbers(&self) -> usize {
        M::History::NUMBERS + NUMBERS
    }

    fn store_history(&self, to: &mut Vec<f64>) {
        for (history, state) in self.law.history.iter().zip(&self.state) {
            history.store(to);
            to.extend([state.field, state.driver, state.driver_step, state.gradient_energy]);
        }
    }

    fn restore_history(&mut self, values: &[f64], n: usize) -> Result<(), ForeignPoints> {
        let width = M::History::NUMBERS;
        let mut of_law = Vec::with_capacity(n * width);
        self.next_state.clear();
        for point in values.chunks_exact(width + NUMBERS) {
            of_law.extend_from_slice(&point[..width]);
            let [field, driver, driver_step, gradient_energy] = std::array::from_fn(|k| point[width + k]);
            self.next_state.push(FieldState { field, driver, driver_step, gradient_energy });
        }
        BodyLaw::<D>::restore_history(&mut self.law, &of_law, n)
    }
}
