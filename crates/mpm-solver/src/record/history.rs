//! The history of a run: one row per load step.

use super::columns::{AT_APEX, GAP, STAGE, STEP_STRAIN, columns, may_iterate};
use super::contributions::{contribution_entries, entry};
use super::energy::elastic;
use super::fields::{BodyFields, look_at_points, mesh_after};
use super::grip::{Grip, MOST, driven, taken_away};
use super::summary::Summary;
use super::supports::{support_entries, total_reaction};
use super::{Balanced, StepResult};
use crate::error::Error;
use crate::model::{Model, Support};
use crate::observe::{Column, ColumnKind, Counted, Entry, LoadStep, Observer, Resumed, RunStart, Space};
use crate::progress::{Progress, Totals};
use crate::ranks::{Ranks, count, largest, least, total};
use crate::timing::{MOST_COUNTED, Phase, Timings};
use mpm_assembly::views;
use mpm_basis::DomainReport;
use mpm_grid::{LoadFraction, Mesh, MeshMotion};
use mpm_linear::{Analysis, Method};
use std::time::Instant;

/// Builds the rows of the history and keeps the running totals.
pub(crate) struct Record {
    space: Space,
    columns: Vec<Column>,
    /// Whether points at an apex are counted.
    has_apex: bool,
    /// Whether points can yield.
    can_yield: bool,
    points: usize,
    nominal_steps: usize,
    stages: usize,
    counted: Counted,
    rows: usize,
    at: LoadFraction,
    /// Mean displacement of each support's nodes so far.
    displacement: Vec<Vec<f64>>,
    /// How driven supports hold their bodies.
    grips: Vec<Grip>,
    clock: Instant,
    cuts_before: u64,
    totals: Totals,
}

impl Record {
    /// Of a model whose points ranks have divided, or which has them all.
    pub(crate) fn new<const D: usize>(model: &Model<D>, ranks: &dyn Ranks<D>) -> Self {
        let stored_before = if model.energies { total(ranks, elastic(&model.bodies)) } else { 0.0 };
        let points: usize = model.bodies.iter().map(|named| named.body.n_points()).sum();
        let columns = columns(model);
        Self {
            space: model.space(),
            has_apex: columns.iter().any(|column| column.name == AT_APEX),
            can_yield: columns.iter().any(|column| column.name == STEP_STRAIN),
            columns,
            points: count(ranks, points as u64) as usize,
            nominal_steps: model.stages.iter().map(|stage| stage.steps as usize).sum(),
            stages: model.stages.len(),
            counted: match model.follows_path() {
                false => Counted::EqualSteps(model.stages.iter().map(|stage| stage.steps).collect()),
                true => Counted::Rows,
            },
            rows: 0,
            at: LoadFraction::START,
            displacement: vec![vec![0.0; D]; model.supports.len()],
            grips: vec![Grip::default(); driven(model).count()],
            clock: Instant::now(),
            cuts_before: 0,
            totals: Totals { stored_before, ..Totals::default() },
        }
    }

    pub(crate) fn start(&self) -> RunStart {
        let (columns, counted) = (self.columns.clone(), self.counted.clone());
        RunStart {
            space: self.space,
            columns,
            points: self.points,
            steps: self.nominal_steps,
            stages: self.stages,
            counted,
        }
    }

    /// What of it the rest of the run needs; the control is not the record's.
    pub(crate) fn save(&self, progress: &mut Progress) {
        progress.rows = self.rows as u64;
        progress.displacement.clone_from(&self.displacement);
        progress.grips.clone_from(&self.grips);
        progress.cuts_before = self.cuts_before;
        progress.totals = self.totals.clone();
    }

    /// Takes up a record again.
    ///
    /// # Errors
    /// What cannot be one of this model.
    pub(crate) fn restore(&mut self, progress: &Progress) -> Result<(), String> {
        let Progress { rows, control, displacement, grips, cuts_before, totals, .. } = progress;
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
        if grips.len() != self.grips.len() || !grips.iter().all(Grip::is_possible) {
            let expected = self.grips.len();
            return Err(format!("has {} gaps of driven supports, expected {expected} of 0 to 1", grips.len()));
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
        let energies = [totals.dissipated, totals.external_work, totals.stored_before];
        if !energies.iter().all(|energy| energy.is_finite()) {
            return Err("has an energy that is not finite".into());
        }
        let cuts = control.cuts();
        if *cuts_before > cuts || cuts > MOST_COUNTED {
            return Err(format!("has {cuts_before} halvings before the last of {cuts}, expected no more"));
        }
        self.rows = *rows as usize;
        self.displacement.clone_from(displacement);
        self.grips.clone_from(grips);
        self.cuts_before = *cuts_before;
        self.totals = totals.clone();
        Ok(())
    }

    /// Tells the observer what the run has behind it.
    pub(crate) fn show_resumed(&mut self, at: LoadFraction, observer: &mut dyn Observer) -> Result<(), Error> {
        self.at = at;
        let resumed = Resumed { rows: self.rows, fraction: at.total() };
        observer.resume(&self.start(), &resumed).map_err(Error::Observer)
    }

    /// Shows the points of the last row again, before the end.
    pub(crate) fn show_last<const D: usize>(
        &self,
        model: &Model<D>,
        observer: &mut dyn Observer,
    ) -> Result<(), Error> {
        if self.rows == 0 {
            return Ok(());
        }
        let at = self.at;
        look_at_points(model, at, |fields| observer.last(at.total(), fields)).map_err(Error::Observer)
    }

    /// Begins a stage, whose supports take hold of what they now find, and sets displacements to zero where the stage wants
    /// that.
    pub(crate) fn begin_stage<const D: usize>(&mut self, model: &Model<D>, number: u32, ranks: &dyn Ranks<D>) {
        let stage = &model.stages[number as usize];
        if stage.resets_displacements {
            self.displacement.iter_mut().for_each(|displacement| displacement.fill(0.0));
        }
        let mesh = mesh_after(model, LoadFraction::start_of(number), &Mesh::at_rest(&model.layout));
        for (grip, support) in self.grips.iter_mut().zip(driven(model)) {
            if support.active.from == number {
                *grip = Grip::at_start(model, support, &mesh, ranks);
            }
        }
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
        (timings, ranks): (&mut Timings, &dyn Ranks<D>),
    ) -> Result<(), Error> {
        let mut row: Vec<Entry> = self
            .columns
            .iter()
            .map(|column| match column.kind {
                ColumnKind::Count if column.name == STAGE => Entry::Count(vec![1]),
                ColumnKind::Count => Entry::Count(vec![0; column.width]),
                ColumnKind::Real if column.name == "smallest_det_increment" => Entry::Real(vec![1.0]),
                ColumnKind::Real => Entry::Real(vec![0.0; column.width]),
            })
            .collect();
        let probes: Vec<Entry> =
            model.probes.iter().flat_map(|probe| probe.entries(&model.bodies, ranks)).collect();
        row.truncate(row.len() - probes.len());
        row.extend(probes);
        let told = model.contributions.iter().flat_map(|named| named.contribution.history());
        for recorded in told {
            let place = self.columns.iter().position(|column| column.name == recorded.name);
            row[place.expect("a column for each that a contribution tells of")] = entry(recorded);
        }
        let mesh = mesh_after(model, LoadFraction::START, &Mesh::at_rest(&model.layout));
        let grip = |support: &Support<D>| match support.acts_in(0) {
            true => Grip::at_start(model, support, &mesh, ranks),
            false => Grip::default(),
        };
        self.grips = driven(model).map(grip).collect();
        let of_gaps = self.columns.iter().zip(&mut row).filter(|(column, _)| column.name.starts_with(GAP));
        for ((_, entry), grip) in of_gaps.zip(&self.grips) {
            *entry = Entry::Real(vec![grip.at_start]);
        }
        let shown = Shown { mesh: &mesh, fraction: 0.0, row: &row, residuals: &[] };
        self.show(model, &shown, observer, timings)
    }

    /// Shows a converged load step; the bodies hold its state, and `cuts` counts the halvings of the run so far.
    ///
    /// # Errors
    /// Whatever keeps the observer from going on.
    pub(crate) fn show_step<const D: usize>(
        &mut self,
        model: &Model<D>,
        result: &StepResult<D>,
        cuts: u64,
        observer: &mut dyn Observer,
        timings: &mut Timings,
    ) -> Result<(), Error> {
        let cuts_here = cuts - self.cuts_before;
        self.cuts_before = cuts;
        let seconds = self.clock.elapsed().as_secs_f64();
        self.clock = Instant::now();
        let mut row = solution_entries(result, cuts_here, seconds);
        let stage = result.balanced.end.stage();
        if model.has_named_stages() {
            row.push(Entry::Count(vec![u64::from(stage) + 1]));
            row.push(Entry::Real(vec![result.balanced.end.get()]));
        }
        row.extend(total_reaction(&model.supports, result, model.turns()));
        let mesh_after = mesh_after(model, result.balanced.end, &result.mesh);
        let ranks = &*result.connected.shared.ranks;
        for (grip, support) in self.grips.iter_mut().zip(driven(model)) {
            match support.acts_in(stage) {
                true => grip.look(model, support, (&mesh_after, result.balanced.end), ranks),
                false => grip.rest(),
            }
        }
        row.extend(self.grips.iter().map(|grip| Entry::Real(vec![grip.now()])));
        for (support, displacement) in model.supports.iter().zip(&mut self.displacement) {
            row.extend(support_entries(support, result, model.turns(), displacement));
        }
        row.extend(self.optional_entries(model, result, &mesh_after));
        row.extend(model.probes.iter().flat_map(|probe| probe.entries(&model.bodies, ranks)));

        self.at = result.balanced.end;
        self.totals.cuts = cuts;
        self.totals.add(result);
        let shown = Shown {
            mesh: &mesh_after,
            fraction: result.balanced.end.total(),
            row: &row,
            residuals: &result.balanced.equilibrium.effort.residuals,
        };
        self.show(model, &shown, observer, timings)
    }

    /// Ends a run before a load step of a stage in which a support would not hold its body.
    ///
    /// # Errors
    /// [`Error::LostBody`] for the first of them.
    pub(crate) fn check_grips<const D: usize>(
        &self,
        model: &Model<D>,
        stage: u32,
        ranks: &dyn Ranks<D>,
    ) -> Result<(), Error> {
        if !model.needs_grip {
            return Ok(());
        }
        let lost = |(gap, start): (f64, f64), support: &Support<D>| {
            let (fraction, support) = (self.at.total(), support.name.clone());
            Err(Error::LostBody { step: self.rows - 1, fraction, support, gap, start })
        };
        let is_lost = |(grip, support): &(&Grip, &Support<D>)| support.acts_in(stage) && grip.is_lost();
        if let Some((grip, support)) = self.grips.iter().zip(driven(model)).find(is_lost) {
            return lost((grip.now(), grip.at_start), support);
        }
        if matches!(model.motion, MeshMotion::Fixed) {
            return Ok(());
        }
        let mesh = mesh_after(model, self.at, &Mesh::at_rest(&model.layout));
        for support in model.supports.iter().filter(|support| support.acts_in(stage)) {
            let gap = taken_away(model, support, (&mesh, self.at), ranks);
            if gap > MOST {
                return lost((gap, 0.0), support);
            }
        }
        Ok(())
    }

    /// Entries of the columns that only some models have.
    fn optional_entries<const D: usize>(
        &mut self,
        model: &Model<D>,
        result: &StepResult<D>,
        mesh_after: &Mesh<D>,
    ) -> Vec<Entry> {
        let StepResult { balanced, domains, connected, .. } = result;
        let ranks = &*connected.shared.ranks;
        let mut entries = Vec::new();
        if model.domain_limit.is_some() {
            entries.push(Entry::Count(vec![domains.capped + domains.split]));
        }
        entries.extend(model.contributions.iter().flat_map(|named| contribution_entries(named, ranks)));
        if self.has_apex {
            let counts = model.bodies.iter().filter_map(|named| named.body.points_at_apex());
            entries.push(Entry::Count(vec![count(ranks, counts.map(|count| count as u64).sum())]));
        }
        if self.can_yield {
            let strains = model.bodies.iter().map(|named| named.body.largest_step_strain());
            entries.push(Entry::Real(vec![largest(ranks, strains.fold(0.0, f64::max))]));
        }
        if model.condition_history {
            entries.push(Entry::Real(vec![balanced.condition.unwrap_or(0.0)]));
        }
        if may_iterate(model) {
            entries.push(Entry::Count(vec![balanced.equilibrium.effort.linear_iterations]));
        }
        if model.domain_history {
            entries.extend(domain_entries(model, mesh_after, ranks));
        }
        if let Some(energy) = &balanced.energy {
            let totals = &mut self.totals;
            totals.dissipated += energy.dissipated;
            totals.external_work += energy.work;
            let stored = total(ranks, elastic(&model.bodies)) + energy.stored;
            let (dissipated, work) = (totals.dissipated, totals.external_work);
            let unbalanced = work - (stored - totals.stored_before) - dissipated;
            entries.extend([stored, dissipated, work, unbalanced].map(|it| Entry::Real(vec![it])));
        }
        entries
    }

    fn show<const D: usize>(
        &mut self,
        model: &Model<D>,
        shown: &Shown<'_, D>,
        observer: &mut dyn Observer,
        timings: &mut Timings,
    ) -> Result<(), Error> {
        let &Shown { mesh, fraction, row, residuals } = shown;
        let so_far = timings.with_skipped();
        let fields = BodyFields { bodies: &model.bodies, contributions: &model.contributions, mesh };
        let step = LoadStep { index: self.rows, fraction, row, residuals, timings: &so_far, fields: &fields };
        timings.time(Phase::Output, || observer.load_step(&step)).map_err(Error::Observer)?;
        self.rows += 1;
        Ok(())
    }

    /// The run in a few numbers.
    pub(crate) fn summary<const D: usize>(
        &self,
        model: &Model<D>,
        timings: &Timings,
        ranks: &dyn Ranks<D>,
    ) -> Summary {
        Summary::of((self.rows.saturating_sub(1), self.at()), &self.totals, model, timings, ranks)
    }
}

/// One row of the history and what else an observer sees with it.
struct Shown<'a, const D: usize> {
    /// The mesh that the points meet next.
    mesh: &'a Mesh<D>,
    fraction: f64,
    row: &'a [Entry],
    residuals: &'a [f64],
}

/// Entries of the columns that every run has.
fn solution_entries<const D: usize>(result: &StepResult<D>, cuts: u64, seconds: f64) -> Vec<Entry> {
    let Balanced { end, equilibrium, equations, analysis, .. } = &result.balanced;
    let effort = &equilibrium.effort;
    let method = match effort.method {
        Method::Llt => 0,
        Method::Lblt => 1,
        Method::Lu => 2,
        Method::ConjugateGradients => 3,
        Method::Other(_) => 4,
        Method::Gmres => 5,
    };
    vec![
        Entry::Real(vec![end.total()]),
        Entry::Count(vec![effort.residuals.len() as u64]),
        Entry::Real(vec![effort.residual]),
        Entry::Count(vec![*equations]),
        Entry::Count(vec![result.connected.n_nodes()]),
        Entry::Count(vec![u64::from(*analysis == Analysis::Reused)]),
        Entry::Count(vec![method]),
        // Number of the node from 1; 0 where the tangent was positive definite.
        Entry::Count(vec![effort.unstable_node.map_or(0, |node| node.index() as u64 + 1)]),
        Entry::Count(vec![cuts]),
        Entry::Count(vec![effort.shortened.into()]),
        Entry::Count(vec![effort.relaxations.into()]),
        Entry::Real(vec![equilibrium.smallest_determinant]),
        // 0 where it is not known, as of iterative solutions.
        Entry::Real(vec![effort.backward_error.unwrap_or(0.0)]),
        Entry::Count(vec![effort.refinements.into()]),
        Entry::Real(vec![effort.pivot_spread.unwrap_or(0.0)]),
        Entry::Real(vec![seconds]),
    ]
}

/// The worst of the points' domains in a mesh.
fn domain_entries<const D: usize>(model: &Model<D>, mesh: &Mesh<D>, ranks: &dyn Ranks<D>) -> [Entry; 7] {
    let reports: Vec<DomainReport> = model.bodies.iter().flat_map(|named| named.body.diagnose(mesh)).collect();
    let least_of =
        |of: fn(&DomainReport) -> f64| least(ranks, reports.iter().map(of).fold(f64::INFINITY, f64::min));
    let sum = |of: fn(&DomainReport) -> usize| count(ranks, reports.iter().map(|it| of(it) as u64).sum());
    let volume_ratio = model
        .bodies
        .iter()
        .flat_map(|named| views(&*named.body))
        .map(|view| view.volume_ratio)
        .fold(f64::INFINITY, f64::min);
    [
        Entry::Real(vec![least_of(|it| it.measure)]),
        Entry::Real(vec![least_of(|it| it.smallest_weight)]),
        Entry::Real(vec![-least_of(|it| -it.distortion)]),
        Entry::Count(vec![sum(|it| it.single_corner_nodes)]),
        Entry::Count(vec![sum(|it| it.corners_outside)]),
        Entry::Count(vec![sum(|it| usize::from(it.fallen_back))]),
        Entry::Real(vec![least(ranks, volume_ratio)]),
    ]
}
