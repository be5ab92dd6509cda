//! Points to nodes: what the bodies' points reach in the mesh of a load step, and the pattern of the tangent.

use crate::failure::StepFailure;
use crate::model::{Model, NamedBody, NamedContribution};
use crate::nodal_field::{NodalField, nodal_field};
use crate::ranks::{Ranks, Shared, agreed, all, count, total};
use crate::skipped::Skipped;
use crate::timing::{Phase, Timings};
use mpm_assembly::{
    AssemblyPlan, Begun, BodyAtStart, BodyConnectivity, ConnectedBody, Contribution, CoupledPlaces, Couplings,
    FieldNodes, SparsityPattern, StepStart, UnknownVector, Unknowns, reached,
};
use mpm_basis::{ActiveNodes, Connectivity, Stencils, UnconnectedPoint};
use mpm_grid::{LoadFraction, Mesh, MeshMotion, NodeId};
use mpm_linear::{LatticePlaces, Symmetry};
use std::cell::Cell;
use std::ops::Range;
use std::rc::Rc;
use std::sync::Arc;

/// Points to nodes: the active nodes, each body's connection to them, and the tangent's pattern.
pub(crate) struct Connected<const D: usize> {
    pub active: ActiveNodes<D>,
    /// Of every body.
    pub assembly_plans: Vec<AssemblyPlan<D>>,
    pub pattern: SparsityPattern<D>,
    /// Of every contribution of the model: which of the unknowns that belong to no node's displacement are its own.
    pub own: Vec<Range<usize>>,
    /// The nodal field of regularised bodies, where there are any.
    pub field: Option<NodalField>,
    /// Whether the linear solver has analysed the pattern.
    pub is_analysed: Cell<bool>,
    /// With whom the nodes are shared.
    pub shared: Shared<D>,
}

impl<const D: usize> Connected<D> {
    /// The unknowns of the step.
    pub(crate) fn unknowns(&self) -> &Unknowns<D> {
        self.pattern.unknowns()
    }

    /// The unknowns at the start of the step: nothing has moved, and the nodal field follows the points.
    pub(crate) fn at_rest(&self) -> UnknownVector<D> {
        let mut rest = UnknownVector::zeros(self.unknowns());
        if let Some(field) = &self.field {
            rest.own[..field.nodes.len()].copy_from_slice(&field.start.field);
        }
        rest
    }

    /// The same with the nodal field as it will be if the last step goes on, `times` as long.
    pub(crate) fn onwards(&self, times: f64) -> UnknownVector<D> {
        let mut onwards = self.at_rest();
        let change = self.field.iter().flat_map(|field| &field.start.change);
        onwards.own.iter_mut().zip(change).for_each(|(value, change)| *value += times * change);
        onwards
    }

    /// Number of active nodes of all ranks.
    pub(crate) fn n_nodes(&self) -> u64 {
        let counted = self.shared.counted(self.active.nodes().iter()).count();
        count(&*self.shared.ranks, counted as u64)
    }

    /// The nodes of the nodal field; none without one.
    pub(crate) fn field_nodes(&self) -> &[usize] {
        self.field.as_ref().map_or(&[], |field| &field.active)
    }

    /// Adds what other ranks have of forces on the same unknowns.
    pub(crate) fn complete(&self, force: &mut UnknownVector<D>) {
        let (of_field, rest) = force.own.split_at_mut(self.n_field());
        self.shared.ranks.complete(&mut force.nodes);
        if self.field.is_some() {
            self.shared.complete_at(self.field_nodes(), of_field, self.active.len());
        }
        self.shared.ranks.sum(rest);
    }

    /// Whether this rank counts an equation: every equation is counted by one.
    pub(crate) fn counts_equation(&self, equation: usize) -> bool {
        let node = self.unknowns().node_of(equation).map(|it| it.0).or_else(|| self.field_node(equation));
        node.map_or_else(|| self.shared.ranks.leads(), |node| self.shared.counts(node))
    }

    /// Scalar product of unknowns, summed node by node; those behind the nodes are the same on all ranks.
    pub(crate) fn dot(&self, a: &UnknownVector<D>, b: &UnknownVector<D>) -> f64 {
        let of_nodes: f64 = self.shared.counted(a.nodes.iter().zip(&b.nodes)).map(|(_, (a, b))| a.dot(b)).sum();
        let ((a_field, a_rest), (b_field, b_rest)) =
            (a.own.split_at(self.n_field()), b.own.split_at(self.n_field()));
        let of_field = self.shared.counted_at(self.field_nodes(), a_field.iter().zip(b_field));
        let here = of_field.fold(of_nodes, |sum, (a, b)| sum + a * b);
        a_rest.iter().zip(b_rest).fold(total(&*self.shared.ranks, here), |sum, (a, b)| sum + a * b)
    }

    /// Number of unknowns of the nodal field.
    pub(crate) fn n_field(&self) -> usize {
        self.field.as_ref().map_or(0, |field| field.nodes.len())
    }

    /// The active node at which an equation of the nodal field stands.
    pub(crate) fn field_node(&self, equation: usize) -> Option<usize> {
        let first = self.unknowns().displacement(self.active.len(), 0).equation();
        self.field.as_ref()?.active.get(equation.checked_sub(first)?).copied()
    }

    /// The bodies with their connections.
    pub(crate) fn bodies<'a>(&'a self, bodies: &'a [NamedBody<D>]) -> Vec<ConnectedBody<'a, D>> {
        let connected = bodies.iter().zip(&self.assembly_plans);
        connected
            .map(|(named, assembly_plan)| ConnectedBody { body: &*named.body, plan: assembly_plan })
            .collect()
    }
}

/// All that adds to force and tangent: the bodies, then the contributions of the model.
pub(crate) fn contributions<'a, const D: usize>(
    bodies: &'a [ConnectedBody<'a, D>],
    contributions: &'a [NamedContribution<D>],
) -> Vec<&'a dyn Contribution<D>> {
    let bodies = bodies.iter().map(|body| body as &dyn Contribution<D>);
    bodies.chain(contributions.iter().map(|named| &*named.contribution)).collect()
}

/// The connectivity of the load step that was tried last.
pub(crate) struct Former<const D: usize> {
    pub connected: Connected<D>,
    /// Load fraction at the start of that step, if it failed: the points are still as they were there.
    pub start_of_failed_step: Option<LoadFraction>,
}

/// Load fractions at the start and at the end of a load step.
#[derive(Clone, Copy)]
pub(crate) struct Interval {
    pub from: LoadFraction,
    pub to: LoadFraction,
}

/// Connects the points to the nodes of `mesh` for a load step, and counts what need not be done anew.
///
/// # Errors
/// A point, or a part of its domain, lies outside the mesh, or a contribution cannot begin the step.
pub(crate) fn connect_step<const D: usize>(
    model: &mut Model<D>,
    mesh: &Mesh<D>,
    interval: Interval,
    former: &mut Option<Former<D>>,
    (ranks, timings): (&Rc<dyn Ranks<D>>, &mut Timings),
) -> Result<Connected<D>, StepFailure> {
    let (connected, kept) = match former.take() {
        // Neither points nor mesh have changed since the step failed.
        Some(former) if former.start_of_failed_step == Some(interval.from) => {
            begin_again(model, mesh, interval, former.connected)?
        }
        former => {
            let former = former.map(|former| former.connected);
            timings.time(Phase::Connect, || connect(model, mesh, interval, former, ranks))?
        }
    };
    let skipped = &mut timings.skipped;
    kept.count(skipped);
    skipped.nodes = model.n_nodes() as u64 - connected.n_nodes();
    skipped.upper_triangle = match connected.pattern.symmetry() {
        Symmetry::Symmetric => (connected.pattern.n_entries() - connected.pattern.n_equations()) as u64,
        Symmetry::Unsymmetric => 0,
    };
    skipped.mesh_moves += u64::from(model.motion == MeshMotion::Fixed);
    Ok(connected)
}

/// Influences of all bodies' points on the nodes of `mesh`.
pub(crate) fn stencils<const D: usize>(
    model: &Model<D>,
    mesh: &Mesh<D>,
    ranks: &dyn Ranks<D>,
) -> Result<Vec<Stencils<D>>, StepFailure> {
    let stencils = model
        .bodies
        .iter()
        .enumerate()
        .map(|(index, named)| named.body.stencils(mesh).map_err(|it| outside((index, named), it, ranks)));
    agreed(ranks, stencils.collect())
}

fn outside<const D: usize>(
    (index, named): (usize, &NamedBody<D>),
    it: UnconnectedPoint<D>,
    ranks: &dyn Ranks<D>,
) -> StepFailure {
    let it = UnconnectedPoint { point: ranks.number_of_point(index, it.point), ..it };
    StepFailure::Outside { body: named.name.clone(), basis: named.body.basis(), reason: it.to_string() }
}

/// How much of the connectivity before could be kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kept {
    /// Its memory.
    Memory,
    /// The pattern and the order of sums: no point has changed its nodes.
    Pattern,
    /// All of it: neither points nor mesh have changed.
    All,
}

impl Kept {
    /// Counts what need not be made anew.
    pub(crate) fn count(self, skipped: &mut Skipped) {
        match self {
            Kept::Memory => {}
            Kept::Pattern => skipped.patterns += 1,
            Kept::All => skipped.connections += 1,
        }
    }
}

/// Connects the points to the nodes of `mesh`; `former` is the connectivity of the step before.
pub(crate) fn connect<const D: usize>(
    model: &mut Model<D>,
    mesh: &Mesh<D>,
    interval: Interval,
    former: Option<Connected<D>>,
    ranks: &Rc<dyn Ranks<D>>,
) -> Result<(Connected<D>, Kept), StepFailure> {
    let stencils = stencils(model, mesh, &**ranks)?;
    let active = ranks.activate(model, mesh, &stencils);
    let shared = Shared::of(ranks);
    let linked = stencils.into_iter().zip(model.bodies.iter().enumerate()).map(|(stencils, body)| {
        let connectivity = Connectivity::of(stencils, &active);
        let dilatation = body.1.body.dilatation(&connectivity, mesh, &active);
        let dilatation = dilatation.map_err(|it| outside(body, it, &**ranks))?;
        Ok(BodyConnectivity { connectivity, dilatation })
    });
    let linked: Vec<BodyConnectivity<D>> = agreed(&**ranks, linked.collect())?;
    let connectivity: Vec<&Connectivity<D>> = linked.iter().map(|it| &it.connectivity).collect();
    let (is_retry, ranks_of) = (false, &**ranks);
    let start =
        Start { mesh, active: &active, connectivity: &connectivity, interval, is_retry, ranks: ranks_of };
    let Numbered { unknowns, own, field, begun } = begin(model, &start)?;
    let same = begun == Begun::AsBefore
        && former.as_ref().is_some_and(|former| {
            former.active == active
                && *former.unknowns() == unknowns
                && linked.iter().zip(&former.assembly_plans).all(|(now, before)| before.is_connected_as(now))
        });
    // Whoever changes the pattern of the matrix that all ranks share changes it for all.
    let same = all(&**ranks, same);
    match former {
        Some(Connected { assembly_plans, pattern, is_analysed, .. }) if same => {
            let mut assembly_plans: Vec<AssemblyPlan<D>> = assembly_plans
                .into_iter()
                .zip(linked)
                .map(|(kept, now)| kept.relinked(now.connectivity))
                .collect();
            let field = field.map(|nodes| nodal_field(model, nodes, &mut assembly_plans, (&pattern, &shared)));
            Ok((Connected { active, assembly_plans, pattern, own, field, is_analysed, shared }, Kept::Pattern))
        }
        former => {
            let former = former.map(|former| former.pattern);
            Ok((couple(model, (active, shared), linked, (unknowns, own, field), former), Kept::Memory))
        }
    }
}

/// Begins a step that starts where the one before it failed: the points are connected as they were.
fn begin_again<const D: usize>(
    model: &mut Model<D>,
    mesh: &Mesh<D>,
    interval: Interval,
    former: Connected<D>,
) -> Result<(Connected<D>, Kept), StepFailure> {
    let connectivity: Vec<&Connectivity<D>> =
        former.assembly_plans.iter().map(AssemblyPlan::connectivity).collect();
    let ranks = &*former.shared.ranks;
    let is_retry = true;
    let start = Start { mesh, active: &former.active, connectivity: &connectivity, interval, is_retry, ranks };
    let Numbered { unknowns, own, field, begun } = begin(model, &start)?;
    if all(ranks, begun == Begun::AsBefore && unknowns == *former.unknowns()) {
        return Ok((former, Kept::All));
    }
    let Connected { active, assembly_plans, pattern, shared, .. } = former;
    let linked = assembly_plans.into_iter().map(AssemblyPlan::into_body_connectivity).collect();
    Ok((couple(model, (active, shared), linked, (unknowns, own, field), Some(pattern)), Kept::Memory))
}

/// Makes the pattern of what all contributions couple, in the memory of a former one.
fn couple<const D: usize>(
    model: &mut Model<D>,
    (active, shared): (ActiveNodes<D>, Shared<D>),
    linked: Vec<BodyConnectivity<D>>,
    (unknowns, own, field): (Unknowns<D>, Vec<Range<usize>>, Option<Arc<FieldNodes>>),
    former: Option<SparsityPattern<D>>,
) -> Connected<D> {
    // A regularised body couples the field of its nodes, too.
    let regularised = |k: usize| field.as_ref().filter(|_| model.bodies[k].body.regularisation().is_some());
    let with_field = |(k, linked): (usize, &BodyConnectivity<D>)| {
        regularised(k).map(|nodes| nodes.couplings(&linked.connectivity))
    };
    let with_field: Vec<Option<CoupledPlaces>> = linked.iter().enumerate().map(with_field).collect();
    let of_body = linked.iter().zip(&with_field);
    let mut couplings: Vec<&dyn Couplings> =
        of_body.map(|(plain, with_field)| with_field.as_ref().map_or(plain as _, |it| it as _)).collect();
    couplings.extend(model.contributions.iter().map(|named| named.contribution.couplings()));
    let pattern = SparsityPattern::reusing(former, &unknowns, model.symmetry(), &couplings);
    let plan = |(k, linked)| {
        let plan = AssemblyPlan::new(linked, &pattern);
        match regularised(k) {
            Some(nodes) => plan.with_field(nodes.clone(), &pattern),
            None => plan,
        }
    };
    let mut assembly_plans: Vec<AssemblyPlan<D>> = linked.into_iter().enumerate().map(plan).collect();
    let field = field.map(|nodes| nodal_field(model, nodes, &mut assembly_plans, (&pattern, &shared)));
    for named in &mut model.contributions {
        named.contribution.locate(&pattern);
    }
    Connected { active, assembly_plans, pattern, own, field, is_analysed: Cell::new(false), shared }
}

/// What contributions may know when a load step begins.
struct Start<'a, const D: usize> {
    mesh: &'a Mesh<D>,
    active: &'a ActiveNodes<D>,
    /// Of every body.
    connectivity: &'a [&'a Connectivity<D>],
    interval: Interval,
    is_retry: bool,
    ranks: &'a dyn Ranks<D>,
}

/// The unknowns of a load step.
struct Numbered<const D: usize> {
    unknowns: Unknowns<D>,
    /// See [`Connected::own`].
    own: Vec<Range<usize>>,
    /// Nodes of the nodal field of regularised bodies.
    field: Option<Arc<FieldNodes>>,
    begun: Begun,
}

/// Begins the load step in every contribution of the model.
fn begin<const D: usize>(model: &mut Model<D>, start: &Start<'_, D>) -> Result<Numbered<D>, StepFailure> {
    let Start { mesh, active, connectivity, interval: Interval { from, to }, is_retry, ranks } = *start;
    let mut unknowns = Unknowns::of_nodes(active.len());
    let (mut own, mut begun) = (Vec::new(), Begun::AsBefore);
    let is_regularised =
        |(named, _): &(&NamedBody<D>, &&Connectivity<D>)| named.body.regularisation().is_some();
    let regularised: Vec<&Connectivity<D>> = model
        .bodies
        .iter()
        .zip(connectivity)
        .filter(is_regularised)
        .map(|(_, connectivity)| *connectivity)
        .collect();
    let field = (!regularised.is_empty()).then(|| {
        let mut by_any = reached(&regularised, active.len());
        ranks.complete_numbers(&mut by_any);
        Arc::new(FieldNodes::where_reached(&by_any, &mut unknowns))
    });
    let bodies = model.bodies.iter().zip(connectivity);
    let bodies: Vec<BodyAtStart<'_, D>> = bodies
        .map(|(named, connectivity)| BodyAtStart { name: &named.name, body: &*named.body, connectivity })
        .collect();
    let step = StepStart { mesh, active, bodies: &bodies, from, to, is_retry, sharing: ranks };
    for NamedContribution { name, contribution } in &mut model.contributions {
        let first = unknowns.n_own();
        let here = contribution.begin(&step, &mut unknowns).map_err(|it| StepFailure::Refused {
            contribution: name.clone(),
            reason: it.reason,
            is_step_too_long: it.is_step_too_long,
        });
        let here = agreed(ranks, here)?;
        if here == Begun::Anew {
            begun = Begun::Anew;
        }
        own.push(first..unknowns.n_own());
    }
    Ok(Numbered { unknowns, own, field, begun })
}

/// Where the lines of nodes of each direction stand at rest `[L]`; in directions that do not exist there is one.
pub(crate) fn lines<const D: usize>(model: &Model<D>) -> [Vec<f64>; 3] {
    let mut lines: [Vec<f64>; 3] = std::array::from_fn(|_| vec![0.0]);
    for (padded, lines) in lines.iter_mut().zip(model.nodes.lines(&model.layout)) {
        *padded = lines;
    }
    lines
}

/// Where nodes with these indices stand on the lattice of a model's nodes with these lines.
pub(crate) fn places<'a, const D: usize>(
    model: &Model<D>,
    index: &'a [[u32; 3]],
    lines: &'a [Vec<f64>; 3],
) -> LatticePlaces<'a> {
    let (periodic, nodes) = (model.nodes.lattice().periodic(), model.nodes.lattice().nodes());
    let degree = model.nodes.degrees();
    LatticePlaces {
        index,
        lines,
        periods: std::array::from_fn(|d| (d < D && periodic[d]).then(|| nodes[d])),
        degree: std::array::from_fn(|d| if d < D { degree[d] } else { 1 }),
    }
}

/// Where a node stands `[L]`, 0 in directions that do not exist.
pub(crate) fn position<const D: usize>(model: &Model<D>, mesh: &Mesh<D>, node: NodeId) -> [f64; 3] {
    let position = model.nodes.position(mesh, node);
    std::array::from_fn(|d| if d < D { position[d] } else { 0.0 })
}
