//! The record of a run: history columns, fields of the points, and the summary at its end.

use crate::domains::DomainCounts;
use crate::energy::{StepEnergy, elastic};
use crate::error::Error;
use crate::load_step::Connected;
use crate::model::{Model, NamedBody, Probe};
use crate::newton::Equilibrium;
use crate::observe::{Column, ColumnKind, Entry, Field, Fields, LoadStep, Observer, Resumed, RunStart, Timing};
use crate::schedule::Step;
use crate::state::Progress;
use crate::timing::{Phase, Timings};
use mpm_assembly::{PointView, views};
use mpm_basis::{DomainControl, DomainReport};
use mpm_grid::{LoadFraction, Mesh, Vector};
use mpm_linear::{Analysis, Choice, Method};
use mpm_material::{SymmetricTensor, log_strain};
use nalgebra::Matrix3;
use std::time::Instant;

/// What one converged load step leaves for the record.
pub(crate) struct StepResult<const D: usize> {
    pub mesh: Mesh<D>,
    pub connected: Connected<D>,
    pub equilibrium: Equilibrium<D>,
    /// Free components of displacement.
    pub equations: usize,
    /// Faces across which jumps were penalised.
    pub analysis: Analysis,
    pub domains: DomainCounts,
    /// Where energies are recorded.
    pub energy: Option<StepEnergy>,
}

/// A run in a few numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// Converged load steps.
    pub steps: usize,
    /// Linear solutions on the way to the states that were kept.
    pub iterations: u64,
    /// Linear solutions for guesses of these states that were dropped.
    pub dropped_iterations: u64,
    /// Times a step was halved.
    pub cuts: u64,
    /// Newton corrections of which only a part was taken.
    pub shortened: u64,
    /// Steps that had to be balanced in stages.
    pub staged_steps: u64,
    /// Steps in which the tangent was not positive definite.
    pub indefinite_steps: u64,
    /// Smallest `det ΔF` of any point in any step `[-]`.
    pub smallest_determinant: f64,
    /// Largest relative out-of-balance force that a step was left with `[-]`.
    pub residual: f64,
    /// Largest componentwise backward error of a linear solution `[-]`.
    pub backward_error: f64,
    /// Steps of iterative refinement of linear solutions.
    pub refinements: u64,
    /// Largest ratio of the pivots of one factorisation: the condition number was that large or larger `[-]`.
    pub pivot_spread: f64,
    /// Largest estimate of the condition number (by power and inverse iteration, from below), where it was asked
    /// for `[-]`.
    pub condition: Option<f64>,
    /// Times a domain was shortened to the size of its cell.
    pub domains_capped: u64,
    /// Times a point was split because its domain had outgrown its cell.
    pub domains_split: u64,
    /// Material points at the end.
    pub points: usize,
    /// Seconds and counts per phase.
    pub timings: Vec<Timing>,
    /// What the scene did not need and the run did not do: a name and a count.
    pub skipped: Vec<(&'static str, u64)>,
}

/// Builds the rows of the history and keeps the running totals.
pub(crate) struct Record {
    columns: Vec<Column>,
    points: usize,
    nominal_steps: usize,
    rows: usize,
    at: LoadFraction,
    /// Mean displacement of each support's nodes so far.
    displacement: Vec<Vec<f64>>,
    clock: Instant,
    cuts_before: u64,
    summary: Totals,
}

/// Counts of a state beyond this are none of a run.
pub(crate) const MOST_COUNTED: u64 = 1 << 53;

/// Running totals of the summary, and what the next row needs of the rows before.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct Totals {
    iterations: u64,
    dropped: u64,
    cuts: u64,
    shortened: u64,
    staged_steps: u64,
    indefinite_steps: u64,
    domains: DomainCounts,
    smallest_determinant: Option<f64>,
    /// Energy dissipated, and work done from outside `[F L]`.
    #[serde(default)]
    dissipated: f64,
    #[serde(default)]
    external_work: f64,
    residual: f64,
    backward_error: f64,
    refinements: u64,
    pivot_spread: f64,
    condition: Option<f64>,
}

impl Record {
    pub(crate) fn new<const D: usize>(model: &Model<D>) -> Self {
        let count = |name: &str| Column { name: name.into(), kind: ColumnKind::Count, width: 1 };
        let real = |name: String, width| Column { name, kind: ColumnKind::Real, width };
        let mut columns = vec![
            real("load_fraction".into(), 1),
            count("newton_iterations"),
            real("residual".into(), 1),
            count("equations"),
            count("active_nodes"),
            count("symbolic_reused"),
            count("factorization"),
            count("unstable_node"),
            count("cuts"),
            count("shortened_corrections"),
            count("stages"),
            real("smallest_det_increment".into(), 1),
            real("backward_error".into(), 1),
            count("refinements"),
            real("pivot_spread".into(), 1),
            real("wall_seconds".into(), 1),
        ];
        for support in &model.supports {
            columns.push(real(format!("reaction/{}", support.name), D));
            columns.push(real(format!("displacement/{}", support.name), D));
            if support.moment_about.is_some() {
                columns.push(real(format!("reaction_moment/{}", support.name), 1));
            }
        }
        if let Some(limit) = model.domain_limit {
            columns.push(count(match limit.control {
                DomainControl::Cap { .. } | DomainControl::Reshape { .. } => "domains_capped",
                DomainControl::Split { .. } => "domains_split",
            }));
        }
        if model.ghost.is_some() {
            columns.push(count("ghost_faces"));
        }
        if model.condition_history {
            columns.push(real("condition".into(), 1));
        }
        if may_iterate(model) {
            columns.push(count("linear_iterations"));
        }
        if model.domain_history {
            columns.extend([
                real("domain_smallest_measure".into(), 1),
                real("domain_smallest_corner_weight".into(), 1),
                real("domain_largest_distortion".into(), 1),
                count("domain_single_corner_nodes"),
                count("domain_corners_outside"),
                count("domain_fallen_back"),
                real("smallest_volume_ratio".into(), 1),
            ]);
        }
        if model.energies {
            columns.extend(
                ["elastic", "dissipated", "external_work", "unbalanced"]
                    .map(|name| real(format!("energy/{name}"), 1)),
            );
        }
        columns.extend(model.probes.iter().flat_map(Probe::columns));
        Self {
            columns,
            points: model.bodies.iter().map(|named| named.body.n_points()).sum(),
            nominal_steps: model.schedule.steps as usize,
            rows: 0,
            at: LoadFraction::START,
            displacement: vec![vec![0.0; D]; model.supports.len()],
            clock: Instant::now(),
            cuts_before: 0,
            summary: Totals::default(),
        }
    }

    pub(crate) fn start(&self) -> RunStart {
        RunStart { columns: self.columns.clone(), points: self.points, steps: self.nominal_steps }
    }

    /// What of it the rest of the run needs; the control is not the record's.
    pub(crate) fn store(&self, progress: &mut Progress) {
        progress.rows = self.rows as u64;
        progress.displacement.clone_from(&self.displacement);
        progress.cuts_before = self.cuts_before;
        progress.totals = self.summary.clone();
    }

    /// Takes up a record again.
    ///
    /// # Errors
    /// What cannot be one of this model.
    pub(crate) fn recall(&mut self, progress: &Progress) -> Result<(), String> {
        let Progress { rows, control, displacement, cuts_before, totals, .. } = progress;
        let shape = |columns: &[Vec<f64>]| columns.iter().map(Vec::len).collect::<Vec<_>>();
        if shape(displacement) != shape(&self.displacement) {
            let (found, expected) = (shape(displacement), shape(&self.displacement));
            return Err(format!(
                "has displacements of supports with {found:?} components, expected {expected:?}"
            ));
        }
        if !displacement.iter().flatten().all(|u| u.is_finite()) {
            return Err("has a displacement of a support that is not finite".into());
        }
        if *rows == 0 || *rows > u64::from(u32::MAX) {
            return Err(format!("has {rows} rows of history, expected 1 to {}", u32::MAX));
        }
        let Totals { iterations, dropped, cuts, shortened, indefinite_steps, domains, refinements, .. } =
            *totals;
        let counters = [iterations, dropped, cuts, shortened, indefinite_steps, refinements];
        let of_domains = [domains.capped, domains.split];
        if let Some(counter) = counters.iter().chain(&of_domains).find(|counter| **counter > MOST_COUNTED) {
            return Err(format!("has counted {counter}, expected at most {MOST_COUNTED}"));
        }
        if !(totals.dissipated.is_finite() && totals.external_work.is_finite()) {
            return Err("has an energy that is not finite".into());
        }
        let cuts = control.cuts();
        if *cuts_before > cuts || cuts > MOST_COUNTED {
            return Err(format!("has {cuts_before} halvings before the last of {cuts}, expected no more"));
        }
        self.rows = *rows as usize;
        self.displacement.clone_from(displacement);
        self.cuts_before = *cuts_before;
        self.summary = totals.clone();
        Ok(())
    }

    /// Tells the observer what the run has behind it.
    pub(crate) fn show_resumed<const D: usize>(
        &mut self,
        model: &Model<D>,
        at: LoadFraction,
        observer: &mut dyn Observer,
    ) -> Result<(), Error> {
        self.at = at;
        let mesh = mesh_after(model, at, &Mesh::at_rest(&model.layout));
        let fields = BodyFields { bodies: &model.bodies, mesh: &mesh };
        let resumed = Resumed { rows: self.rows, fraction: at.get(), fields: &fields };
        observer.resume(&self.start(), &resumed).map_err(Error::Observer)
    }

    /// Load fraction of the last row.
    pub(crate) fn at(&self) -> LoadFraction {
        self.at
    }

    /// Rows shown so far; the number of the next load step.
    pub(crate) fn rows(&self) -> usize {
        self.rows
    }

    /// Shows the state before the first load step.
    pub(crate) fn show_initial<const D: usize>(
        &mut self,
        model: &Model<D>,
        observer: &mut dyn Observer,
        timings: &mut Timings,
    ) -> Result<(), Error> {
        let mut row: Vec<Entry> = self
            .columns
            .iter()
            .map(|column| match column.kind {
                ColumnKind::Count => Entry::Count(vec![0; column.width]),
                ColumnKind::Real if column.name == "smallest_det_increment" => Entry::Real(vec![1.0]),
                ColumnKind::Real => Entry::Real(vec![0.0; column.width]),
            })
            .collect();
        let probes: Vec<Entry> = model.probes.iter().flat_map(|probe| probe.entries(&model.bodies)).collect();
        row.truncate(row.len() - probes.len());
        row.extend(probes);
        let mesh = mesh_after(model, LoadFraction::START, &Mesh::at_rest(&model.layout));
        self.show(model, &mesh, 0.0, &row, &[], observer, timings)
    }

    /// Shows a converged load step; the bodies hold its state.
    pub(crate) fn show_step<const D: usize>(
        &mut self,
        model: &Model<D>,
        step: &Step,
        result: &StepResult<D>,
        cuts: u64,
        observer: &mut dyn Observer,
        timings: &mut Timings,
    ) -> Result<(), Error> {
        let StepResult { mesh, connected, equilibrium, equations, analysis, domains, energy } = result;
        let active = &connected.active;
        let ghost_faces = connected.ghost.as_ref().map_or(0, |ghost| ghost.faces.len());
        let cuts_here = cuts - self.cuts_before;
        self.cuts_before = cuts;
        let seconds = self.clock.elapsed().as_secs_f64();
        self.clock = Instant::now();
        let iterations = equilibrium.residuals.len() as u64;
        let method = match equilibrium.method {
            Method::Llt => 0,
            Method::Lblt => 1,
            Method::Lu => 2,
            Method::ConjugateGradients => 3,
        };
        let accuracy = equilibrium.accuracy;
        let residual = equilibrium.residuals.last().copied().unwrap_or(0.0);
        let mut row = vec![
            Entry::Real(vec![step.end.get()]),
            Entry::Count(vec![iterations]),
            Entry::Real(vec![residual]),
            Entry::Count(vec![*equations as u64]),
            Entry::Count(vec![active.len() as u64]),
            Entry::Count(vec![u64::from(*analysis == Analysis::Reused)]),
            Entry::Count(vec![method]),
            // Number of the node from 1; 0 where the tangent was positive definite.
            Entry::Count(vec![equilibrium.unstable_node.map_or(0, |node| node.index() as u64 + 1)]),
            Entry::Count(vec![cuts_here]),
            Entry::Count(vec![equilibrium.shortened.into()]),
            Entry::Count(vec![equilibrium.stages.into()]),
            Entry::Real(vec![equilibrium.smallest_determinant]),
            Entry::Real(vec![accuracy.backward_error]),
            Entry::Count(vec![accuracy.refinements.into()]),
            Entry::Real(vec![accuracy.pivot_spread]),
            Entry::Real(vec![seconds]),
        ];
        for (support, displacement) in model.supports.iter().zip(&mut self.displacement) {
            let (mut reaction, mut moved, mut carrying) = (Vector::<D>::zeros(), Vector::<D>::zeros(), 0);
            let mut moment = 0.0;
            for &node in &support.nodes {
                let Some(number) = active.number(node) else { continue };
                moved += equilibrium.increment[number];
                carrying += 1;
                let mut force = equilibrium.reaction[number];
                for i in (0..D).filter(|&i| support.components[i].is_none()) {
                    force[i] = 0.0;
                }
                reaction += force;
                if let Some([x, y]) = support.moment_about {
                    // The arm reaches to where the node is at the end of the step.
                    let end = mesh.position(node) + equilibrium.increment[number];
                    moment += (end[0] - x) * force[1] - (end[1] - y) * force[0];
                }
            }
            for (total, moved) in displacement.iter_mut().zip(moved.iter()) {
                *total += moved / f64::from(carrying.max(1));
            }
            row.push(Entry::Real(reaction.iter().copied().collect()));
            row.push(Entry::Real(displacement.clone()));
            if support.moment_about.is_some() {
                row.push(Entry::Real(vec![moment]));
            }
        }
        let mesh_after = mesh_after(model, step.end, mesh);
        if model.domain_limit.is_some() {
            row.push(Entry::Count(vec![domains.capped + domains.split]));
        }
        if model.ghost.is_some() {
            row.push(Entry::Count(vec![ghost_faces as u64]));
        }
        if model.condition_history {
            row.push(Entry::Real(vec![accuracy.condition.unwrap_or(0.0)]));
        }
        if may_iterate(model) {
            row.push(Entry::Count(vec![equilibrium.linear_iterations]));
        }
        if model.domain_history {
            row.extend(domain_entries(model, &mesh_after));
        }
        if let Some(energy) = energy {
            let totals = &mut self.summary;
            totals.dissipated += energy.dissipated;
            totals.external_work += energy.work;
            let (stored, dissipated, work) = (elastic(&model.bodies), totals.dissipated, totals.external_work);
            row.extend([stored, dissipated, work, work - stored - dissipated].map(|it| Entry::Real(vec![it])));
        }
        row.extend(model.probes.iter().flat_map(|probe| probe.entries(&model.bodies)));

        self.at = step.end;
        let totals = &mut self.summary;
        totals.iterations += iterations;
        totals.dropped += equilibrium.dropped;
        totals.cuts = cuts;
        totals.shortened += u64::from(equilibrium.shortened);
        totals.staged_steps += u64::from(equilibrium.stages > 0);
        totals.domains.capped += domains.capped;
        totals.domains.split += domains.split;
        totals.indefinite_steps += u64::from(equilibrium.method > Method::Llt);
        let smallest = totals.smallest_determinant.unwrap_or(f64::INFINITY);
        totals.smallest_determinant = Some(smallest.min(equilibrium.smallest_determinant));
        totals.residual = totals.residual.max(residual);
        totals.backward_error = totals.backward_error.max(accuracy.backward_error);
        totals.refinements += u64::from(accuracy.refinements);
        totals.pivot_spread = totals.pivot_spread.max(accuracy.pivot_spread);
        totals.condition = accuracy.condition.into_iter().chain(totals.condition).reduce(f64::max);
        self.show(model, &mesh_after, step.end.get(), &row, &equilibrium.residuals, observer, timings)
    }

    #[expect(clippy::too_many_arguments, reason = "one row, as its parts")]
    fn show<const D: usize>(
        &mut self,
        model: &Model<D>,
        mesh: &Mesh<D>,
        fraction: f64,
        row: &[Entry],
        residuals: &[f64],
        observer: &mut dyn Observer,
        timings: &mut Timings,
    ) -> Result<(), Error> {
        let so_far = timings.with_skipped();
        let fields = BodyFields { bodies: &model.bodies, mesh };
        let step = LoadStep { index: self.rows, fraction, row, residuals, timings: &so_far, fields: &fields };
        timings.time(Phase::Output, || observer.load_step(&step)).map_err(Error::Observer)?;
        self.rows += 1;
        Ok(())
    }

    pub(crate) fn summary<const D: usize>(&self, model: &Model<D>, timings: &Timings) -> Summary {
        let totals = &self.summary;
        Summary {
            steps: self.rows.saturating_sub(1),
            iterations: totals.iterations,
            dropped_iterations: totals.dropped,
            cuts: totals.cuts,
            shortened: totals.shortened,
            staged_steps: totals.staged_steps,
            indefinite_steps: totals.indefinite_steps,
            domains_capped: totals.domains.capped,
            domains_split: totals.domains.split,
            smallest_determinant: totals.smallest_determinant.unwrap_or(1.0),
            residual: totals.residual,
            backward_error: totals.backward_error,
            refinements: totals.refinements,
            pivot_spread: totals.pivot_spread,
            condition: totals.condition,
            points: model.bodies.iter().map(|named| named.body.n_points()).sum(),
            timings: timings.phases().to_vec(),
            skipped: timings.skipped.list().to_vec(),
        }
    }
}

/// The mesh that the points meet next; `present` where the motion cannot place it.
fn mesh_after<const D: usize>(model: &Model<D>, at: LoadFraction, present: &Mesh<D>) -> Mesh<D> {
    model.motion.mesh_at(&model.layout, at).unwrap_or_else(|_| present.clone())
}

/// The worst of the points' domains in a mesh.
fn domain_entries<const D: usize>(model: &Model<D>, mesh: &Mesh<D>) -> [Entry; 7] {
    let reports: Vec<DomainReport> = model.bodies.iter().flat_map(|named| named.body.diagnose(mesh)).collect();
    let least = |of: fn(&DomainReport) -> f64| reports.iter().map(of).fold(f64::INFINITY, f64::min);
    let sum = |of: fn(&DomainReport) -> usize| reports.iter().map(|it| of(it) as u64).sum();
    let volume_ratio = model
        .bodies
        .iter()
        .flat_map(|named| views(&*named.body))
        .map(|view| view.volume_ratio)
        .fold(f64::INFINITY, f64::min);
    [
        Entry::Real(vec![least(|it| it.measure)]),
        Entry::Real(vec![least(|it| it.smallest_weight)]),
        Entry::Real(vec![-least(|it| -it.distortion)]),
        Entry::Count(vec![sum(|it| it.single_corner_nodes)]),
        Entry::Count(vec![sum(|it| it.corners_outside)]),
        Entry::Count(vec![sum(|it| usize::from(it.fallen_back))]),
        Entry::Real(vec![volume_ratio]),
    ]
}

/// The material points of all bodies, one after the other.
struct BodyFields<'a, const D: usize> {
    bodies: &'a [NamedBody<D>],
    /// The mesh in which domains are judged.
    mesh: &'a Mesh<D>,
}

impl<const D: usize> BodyFields<'_, D> {
    fn collect(
        &self,
        components: usize,
        mut each: impl FnMut(usize, &PointView<D>, &mut Vec<f64>),
    ) -> Vec<f64> {
        let mut values = Vec::with_capacity(self.n_points() * components);
        for (index, named) in self.bodies.iter().enumerate() {
            for view in views(&*named.body) {
                each(index, &view, &mut values);
            }
        }
        values
    }
}

impl<const D: usize> BodyFields<'_, D> {
    fn diagnose(&self, value: impl Fn(&DomainReport) -> f64) -> Vec<f64> {
        self.bodies.iter().flat_map(|named| named.body.diagnose(self.mesh)).map(|it| value(&it)).collect()
    }

    /// Four corners of (x, y) per point, see [`Field::Outline`].
    fn plane_outlines(&self) -> Vec<f64> {
        let mut values = Vec::with_capacity(self.n_points() * Field::Outline.components());
        for named in self.bodies {
            for (point, view) in views(&*named.body).enumerate() {
                let corners = named.body.outline(point);
                let last = corners.last().copied().unwrap_or(view.position);
                let corners = corners.into_iter().chain(std::iter::repeat(last)).take(4);
                values.extend(corners.flat_map(|x| [x[0], x[1]]));
            }
        }
        values
    }
}

impl<const D: usize> Fields for BodyFields<'_, D> {
    fn n_points(&self) -> usize {
        self.bodies.iter().map(|named| named.body.n_points()).sum()
    }

    fn positions(&self) -> Vec<f64> {
        self.collect(3, |_, view, out| out.extend(spatial(&view.position)))
    }

    fn field(&self, field: Field) -> Vec<f64> {
        match field {
            Field::DomainMeasure => self.diagnose(|it| it.measure),
            Field::SmallestCornerWeight => self.diagnose(|it| it.smallest_weight),
            Field::SingleCornerNodes => self.diagnose(|it| it.single_corner_nodes as f64),
            Field::CornersOutside => self.diagnose(|it| it.corners_outside as f64),
            Field::FallenBack => self.diagnose(|it| f64::from(u8::from(it.fallen_back))),
            Field::Outline => self.plane_outlines(),
            _ => self.collect(field.components(), |body, view, out| point_field(field, body, view, out)),
        }
    }

    fn outlines(&self) -> Vec<Vec<[f64; 3]>> {
        let outline = |named: &NamedBody<D>, point| named.body.outline(point).iter().map(spatial).collect();
        self.bodies
            .iter()
            .flat_map(|named| (0..named.body.n_points()).map(move |point| outline(named, point)))
            .collect()
    }
}

/// Appends a field of the point's state.
fn point_field<const D: usize>(field: Field, body: usize, view: &PointView<D>, out: &mut Vec<f64>) {
    match field {
        Field::Displacement => {
            let rest = view.reference_position.unwrap_or(view.position);
            out.extend(spatial(&(view.position - rest)));
        }
        Field::DeformationGradient => {
            let mut f = Matrix3::identity();
            for i in 0..D {
                for j in 0..D {
                    f[(i, j)] = view.deformation_gradient[(i, j)];
                }
            }
            out.extend(f.transpose().iter());
        }
        Field::CauchyStress => extend(out, &view.kirchhoff, 1.0 / view.volume_ratio),
        Field::ElasticStrain => extend(out, &log_strain(&view.elastic_excess), 1.0),
        Field::Volume => out.push(view.volume_ratio * view.reference_volume),
        Field::VolumeRatio => out.push(view.volume_ratio),
        Field::Rho => out.push(rho(&view.kirchhoff)),
        Field::Plastic => out.push(f64::from(u8::from(view.plastic))),
        Field::Body => out.push(body as f64),
        Field::DomainMeasure
        | Field::SmallestCornerWeight
        | Field::SingleCornerNodes
        | Field::CornersOutside
        | Field::FallenBack
        | Field::Outline => unreachable!("worked out from the domains"),
    }
}

/// Padded with zeros to three components.
fn spatial<const D: usize>(x: &Vector<D>) -> [f64; 3] {
    std::array::from_fn(|i| if i < D { x[i] } else { 0.0 })
}

fn extend(out: &mut Vec<f64>, t: &SymmetricTensor, scale: f64) {
    out.extend([t.xx, t.xy, t.zx, t.xy, t.yy, t.yz, t.zx, t.yz, t.zz].map(|x| x * scale));
}

/// `|dev τ|`.
fn rho(tau: &SymmetricTensor) -> f64 {
    let mean = tau.trace() / 3.0;
    let deviator = SymmetricTensor { xx: tau.xx - mean, yy: tau.yy - mean, zz: tau.zz - mean, ..*tau };
    deviator.norm()
}

/// Nodes of a grid in the plane up to which nothing is predicted to be iterated.
const SMALL: usize = 2000;

/// Whether conjugate gradients may solve a model's linear systems.
fn may_iterate<const D: usize>(model: &Model<D>) -> bool {
    match model.linear_solver() {
        Choice::Direct => false,
        Choice::Iterative => true,
        Choice::Auto => D == 3 || model.layout.lattice().n_nodes() > SMALL,
    }
}
