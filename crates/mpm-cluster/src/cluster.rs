//! A rank of several that share a model.

use crate::cells::{joined, more, needs_more};
use crate::cuts::Cuts;
use crate::exchange::Exchange;
use crate::gathered::Gathered;
use crate::key::Key;
use crate::observer::Whole;
use crate::points::{Named, Points, keep, migrate};
use crate::refusals::refused;
use crate::wire::Wire;
use mpm_assembly::{OccupiedCell, Sharing};
use mpm_basis::{ActiveNodes, Stencils};
use mpm_grid::{Lattice, LoadFraction, Mesh, NodeId, Vector};
use mpm_linear::LinearSolver;
use mpm_solver::observe::{Field, Observer};
use mpm_solver::{Model, NamedBody, Ranks, StepFailure};
use std::cell::RefCell;
use std::ops::Range;
use std::rc::Rc;

/// Makes the linear solver of a rank, for a model, of what ranks exchange.
pub type SolverOfRanks<const D: usize, W> = dyn Fn(&Model<D>, Rc<Exchange<D, W>>) -> Box<dyn LinearSolver>;

/// The rank that shall have a point of a body.
pub type Placement = dyn Fn(usize, Key) -> usize;

/// Ranks take new boxes where one has more than this times the mean number of points.
const UNEVEN: f64 = 1.2;

/// A rank of several that share a model, for [`mpm_solver::run_on`].
pub struct Cluster<const D: usize, W: Wire> {
    exchange: Rc<Exchange<D, W>>,
    solver: Box<SolverOfRanks<D, W>>,
    points: Rc<RefCell<Points<D>>>,
    placement: Option<Box<Placement>>,
}

impl<const D: usize, W: Wire + 'static> Cluster<D, W> {
    /// A rank whose linear systems are solved on rank 0, see [`Gathered`].
    pub fn new(wire: W, model: &Model<D>) -> Self {
        let cells = Mesh::at_rest(&model.layout).lattice().cells();
        let fields = Field::OF_POINTS.into_iter().chain(further_fields(model)).collect();
        let points = Rc::new(RefCell::new(Points::of(model, fields)));
        let solver =
            |model: &Model<D>, exchange| Box::new(Gathered::new(model, exchange)) as Box<dyn LinearSolver>;
        Self {
            exchange: Rc::new(Exchange::new(wire, cells)),
            solver: Box::new(solver),
            points,
            placement: None,
        }
    }

    /// The same with a linear solver of the ranks' own.
    pub fn with_solver(
        self,
        solver: impl Fn(&Model<D>, Rc<Exchange<D, W>>) -> Box<dyn LinearSolver> + 'static,
    ) -> Self {
        Self { solver: Box::new(solver), ..self }
    }

    /// The same with points that are where `placement` says in place of the owners of their cells: the answer is the same
    /// wherever they are, where no volume changes are averaged over cells.
    pub fn with_placement(self, placement: impl Fn(usize, Key) -> usize + 'static) -> Self {
        Self { placement: Some(Box::new(placement)), ..self }
    }

    /// What the ranks exchange.
    pub fn exchange(&self) -> &Rc<Exchange<D, W>> {
        &self.exchange
    }

    /// Keys of the points that this rank has, body by body.
    pub fn keys(&self) -> Vec<Vec<Key>> {
        self.points.borrow().keys.clone()
    }

    /// An observer for this rank that shows `inner` the points of all ranks, on rank 0; on the others it is told nothing.
    pub fn whole<'a>(&self, inner: &'a mut dyn Observer) -> Whole<'a, D, W> {
        Whole { exchange: self.exchange.clone(), points: self.points.clone(), inner }
    }

    /// The cell of every point, body by body; none where it lies outside the mesh.
    fn cells(model: &Model<D>, mesh: &Mesh<D>) -> Vec<Vec<Option<[u32; D]>>> {
        let cell = |x: Vector<D>| mesh.locate(&x, 0.5).ok().map(|place| place.cell);
        let of_body = |named: &NamedBody<D>| {
            (0..named.body.n_points()).map(|p| cell(named.body.point(p).position)).collect()
        };
        model.bodies.iter().map(of_body).collect()
    }

    /// Takes the points that every rank has made, which have these numbers, to the owners of their cells.
    fn bring(
        &self,
        model: &mut Model<D>,
        (mesh, cells): (&Mesh<D>, &[Vec<Option<[u32; D]>>]),
        numbers: &[Vec<u64>],
    ) {
        let own: Vec<[u32; D]> = cells.iter().flatten().flatten().copied().collect();
        self.exchange.set_cuts(Cuts::balanced(mesh.lattice().cells(), &own, self.exchange.wire()));
        let keys: Vec<Vec<Key>> = numbers.iter().map(|numbers| Key::numbered(numbers)).collect();
        let mut owners = self.owners(cells, &keys);
        // A point outside the mesh is refused by the first load step, on one rank.
        for (cell, owner) in cells.iter().flatten().zip(owners.iter_mut().flatten()) {
            if cell.is_none() {
                *owner = 0;
            }
        }
        let named = Named::of(model);
        {
            let mut points = self.points.borrow_mut();
            (points.named, points.keys) = (named, keys);
        }
        self.take_to(model, &owners);
    }

    /// Takes the points of all ranks to these, with what names and remembers them.
    fn take_to(&self, model: &mut Model<D>, owners: &[Vec<usize>]) {
        let (mut points, wire) = (self.points.borrow_mut(), self.exchange.wire());
        let points = &mut *points;
        let remembered = points.memories.of(model, &points.keys);
        let before = points.keys.clone();
        migrate(model, &mut points.keys, owners, wire);
        points.named.write(model, &points.keys);
        points.memories.migrate(model, remembered, (&before, owners), (&points.keys, wire));
    }

    /// The owner of every point of these keys; where it lies outside the mesh, this rank.
    fn owners(&self, cells: &[Vec<Option<[u32; D]>>], keys: &[Vec<Key>]) -> Vec<Vec<usize>> {
        if let Some(placement) = &self.placement {
            let of_body =
                |(body, keys): (usize, &Vec<Key>)| keys.iter().map(|key| placement(body, *key)).collect();
            return keys.iter().enumerate().map(of_body).collect();
        }
        let (cuts, me) = (self.exchange.cuts(), self.exchange.wire().rank());
        let owner = |cell: &Option<[u32; D]>| cell.map_or(me, |cell| cuts.owner(cell));
        cells.iter().map(|cells| cells.iter().map(owner).collect()).collect()
    }
}

impl<const D: usize, W: Wire + 'static> Sharing<D> for Cluster<D, W> {
    fn joined(&self, lattice: &Lattice<D>, occupied: Vec<OccupiedCell>) -> Vec<OccupiedCell> {
        joined(lattice, &occupied, &self.exchange.cuts(), self.exchange.wire())
    }

    fn is_own(&self, cell: [u32; D]) -> bool {
        self.exchange.cuts().owner(cell) == self.exchange.wire().rank()
    }

    fn leads(&self) -> bool {
        self.exchange.wire().rank() == 0
    }

    fn gathered(&self, own: Vec<f64>) -> (Vec<f64>, Range<usize>) {
        self.exchange.gathered(&own)
    }
}

impl<const D: usize, W: Wire + 'static> Ranks<D> for Cluster<D, W> {
    fn size(&self) -> usize {
        self.exchange.wire().size()
    }

    fn divide(&self, model: &mut Model<D>, at: LoadFraction) -> Result<(), String> {
        let wire = self.exchange.wire();
        if let Some(reason) = refused(model).filter(|_| wire.size() > 1) {
            return Err(reason);
        }
        let mesh = model.motion.mesh_at(&model.layout, at).map_err(|it| format!("the mesh: {it}"))?;
        let cells = Self::cells(model, &mesh);
        if let Some(numbers) = model.share.take() {
            self.bring(model, (&mesh, &cells), &numbers);
            return Ok(());
        }
        // Every rank has all points; each gives its share of them, as if they were dealt out in turn.
        let in_turn = cells.iter().flatten().skip(wire.rank()).step_by(wire.size());
        let in_turn: Vec<[u32; D]> = in_turn.flatten().copied().collect();
        self.exchange.set_cuts(Cuts::balanced(mesh.lattice().cells(), &in_turn, wire));
        // A point outside the mesh is refused by the first load step, on one rank.
        let all: Vec<Vec<Key>> = cells.iter().map(|cells| Key::first(cells.len())).collect();
        let mut owners = self.owners(&cells, &all);
        for (cells, owners) in cells.iter().zip(&mut owners) {
            cells.iter().zip(owners).filter(|it| it.0.is_none()).for_each(|(_, owner)| *owner = 0);
        }
        let mut points = self.points.borrow_mut();
        // A state may have had other shares.
        points.named = Named::of(model);
        points.keys = keep(model, &owners, wire.rank());
        points.named.write(model, &points.keys);
        points.memories.keep(model, &points.keys, &all);
        Ok(())
    }

    fn activate(&self, model: &Model<D>, mesh: &Mesh<D>, stencils: &[Stencils<D>]) -> ActiveNodes<D> {
        let more = |own: &[NodeId]| more(model, mesh, own, self);
        self.exchange.activate(&model.nodes, stencils, if needs_more(model) { Some(&more) } else { None })
    }

    fn owned(&self) -> Option<Rc<[bool]>> {
        Some(self.exchange.numbering().owned.clone())
    }

    fn complete(&self, field: &mut [Vector<D>]) {
        self.exchange.complete_vectors(field);
    }

    fn complete_numbers(&self, field: &mut [f64]) {
        self.exchange.complete(field, 1);
    }

    fn sum(&self, values: &mut [f64]) {
        self.exchange.sum(values);
    }

    fn least(&self, values: &mut [f64]) {
        self.exchange.least(values);
    }

    fn unite(&self, bits: &mut [u8]) {
        let mut apart: Vec<f64> =
            bits.iter().flat_map(|byte| (0..8).map(move |bit| f64::from(byte >> bit & 1))).collect();
        self.exchange.sum(&mut apart);
        for (byte, apart) in bits.iter_mut().zip(apart.chunks_exact(8)) {
            *byte = (0..8).filter(|&bit| apart[bit] > 0.0).fold(0, |all, bit| all | 1 << bit);
        }
    }

    fn tell(&self, failure: Option<StepFailure>) -> Option<StepFailure> {
        let wire = self.exchange.wire();
        let mut failed = vec![0.0; wire.size()];
        wire.gather(&[f64::from(u8::from(failure.is_some()))], &mut failed);
        let first = failed.iter().position(|&it| it > 0.0)?;
        let bytes = failure.filter(|_| first == wire.rank()).map(|failure| failure.to_bytes());
        let to_all = |bytes: Vec<u8>| (0..wire.size()).map(|rank| (rank, bytes.clone())).collect::<Vec<_>>();
        let told = wire.exchange(&bytes.map(to_all).unwrap_or_default());
        told.first().map(|(_, bytes)| StepFailure::from_bytes(bytes))
    }

    fn settle(&self, model: &mut Model<D>, at: LoadFraction) {
        // Where there is no mesh the next load step says so.
        let Ok(mesh) = model.motion.mesh_at(&model.layout, at) else { return };
        let wire = self.exchange.wire();
        let cells = Self::cells(model, &mesh);
        let mut owners = self.owners(&cells, &self.points.borrow().keys);
        let mut counts = vec![0.0; wire.size()];
        owners.iter().flatten().for_each(|&owner| counts[owner] += 1.0);
        self.exchange.sum(&mut counts);
        let most = counts.iter().copied().fold(0.0, f64::max);
        if most * wire.size() as f64 > UNEVEN * counts.iter().sum::<f64>() {
            let own: Vec<[u32; D]> = cells.iter().flatten().flatten().copied().collect();
            self.exchange.set_cuts(Cuts::balanced(mesh.lattice().cells(), &own, wire));
            owners = self.owners(&cells, &self.points.borrow().keys);
        }
        let mut leaving = [owners.iter().flatten().filter(|&&owner| owner != wire.rank()).count() as f64];
        self.exchange.sum(&mut leaving);
        if leaving[0] > 0.0 {
            self.take_to(model, &owners);
        }
    }

    fn split(&self, body: usize, parts: &[(usize, f64)]) {
        self.points.borrow_mut().split(body, parts, self.exchange.wire());
    }

    fn sees_all(&self) -> bool {
        self.size() == 1
    }

    fn number_of_point(&self, body: usize, point: usize) -> usize {
        let points = self.points.borrow();
        points.keys.get(body).and_then(|keys| keys.get(point)).map_or(point, |key| key.number as usize)
    }

    fn solver(&self, model: &Model<D>) -> Option<Box<dyn LinearSolver>> {
        Some((self.solver)(model, self.exchange.clone()))
    }
}

/// What the laws of the bodies remember, and what contributions know of points.
fn further_fields<const D: usize>(model: &Model<D>) -> Vec<Field> {
    let of_laws = model.bodies.iter().flat_map(|named| named.body.history_fields());
    let of_contributions =
        model.contributions.iter().flat_map(|named| named.contribution.point_fields()).map(|it| it.info);
    of_laws.chain(of_contributions).map(Field::from).collect()
}
