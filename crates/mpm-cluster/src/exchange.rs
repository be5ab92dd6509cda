//! What ranks exchange of the nodes of a load step.

use crate::cuts::Cuts;
use crate::message::{Reader, Writer};
use crate::numbering::{Common, Numbering};
use crate::wire::Wire;
use mpm_basis::{ACTIVE, ActiveNodes, Stencils};
use mpm_grid::{Lattice, NodeId, NodeSpace, Vector};
use std::cell::{Cell, Ref, RefCell};
use std::ops::Range;

/// In place of a node's number: no rank's points reach it.
const INACTIVE: u64 = u64::MAX;

/// What a rank exchanges with others of the nodes that were [activated](Self::activate) last.
pub struct Exchange<const D: usize, W> {
    wire: W,
    cuts: RefCell<Cuts<D>>,
    numbering: RefCell<Numbering>,
    generation: Cell<u64>,
}

/// Which nodes a rank asks for besides those that its points reach, from the active nodes that it owns.
pub type MoreNodes<'a> = dyn Fn(&[NodeId]) -> Vec<NodeId> + 'a;

impl<const D: usize, W: Wire> Exchange<D, W> {
    /// One box of cells and no nodes.
    pub fn new(wire: W, cells: [u32; D]) -> Self {
        let (cuts, numbering) = (RefCell::new(Cuts::whole(cells)), RefCell::new(Numbering::default()));
        Self { wire, cuts, numbering, generation: Cell::new(0) }
    }

    /// What carries the bytes.
    pub fn wire(&self) -> &W {
        &self.wire
    }

    /// Who owns what.
    pub fn cuts(&self) -> Ref<'_, Cuts<D>> {
        self.cuts.borrow()
    }

    /// Shares cells and nodes out anew.
    pub fn set_cuts(&self, cuts: Cuts<D>) {
        self.cuts.replace(cuts);
    }

    /// The nodes of this rank.
    pub fn numbering(&self) -> Ref<'_, Numbering> {
        self.numbering.borrow()
    }

    /// Counts up whenever the numbering of the nodes has changed on any rank.
    pub fn generation(&self) -> u64 {
        self.generation.get()
    }

    /// Finds the active nodes of all ranks. A node is active where the sum of all influences on it says so, which its owner
    /// knows: every rank tells the owners what its points reach. It asks them for the numbers of these nodes and of those that
    /// `more` says besides, who is told the active nodes that the rank owns; the same of all ranks, or none.
    pub fn activate(
        &self,
        space: &NodeSpace<D>,
        stencils: &[Stencils<D>],
        more: Option<&MoreNodes<'_>>,
    ) -> ActiveNodes<D> {
        let (me, lattice) = (self.wire.rank(), space.lattice());
        let touched = ActiveNodes::touched(space, stencils);
        let mut questions = self.asked(lattice, &touched);
        let own = active_of(&questions);
        let mut asked = touched;
        if let Some(more) = more {
            asked.extend(more(&own).into_iter().map(|node| (node, 0.0)));
            asked.sort_by_key(|it| it.0);
            asked.dedup_by_key(|it| it.0);
            questions = self.asked(lattice, &asked);
        }
        let asked: Vec<(NodeId, usize)> = {
            let cuts = self.cuts.borrow();
            asked.iter().map(|&(node, _)| (node, cuts.owner(lattice.node_index(node)))).collect()
        };
        let (first, n_all) = self.sum_before(own.len());

        let mut out: Vec<Option<Writer>> = vec![None; self.wire.size()];
        for (rank, asked) in &questions {
            let out = out[*rank].get_or_insert_with(Writer::default);
            for (node, _) in asked {
                let place = own.binary_search(node);
                out.count(place.map_or(INACTIVE, |place| first + place as u64));
            }
        }
        let mut answers: Vec<Vec<u64>> = vec![Vec::new(); self.wire.size()];
        for (rank, bytes) in self.wire.exchange(&sent(out)) {
            let mut reader = Reader::new(&bytes);
            while !reader.is_at_end() {
                answers[rank].push(reader.count());
            }
        }
        let mut answers: Vec<_> = answers.into_iter().map(Vec::into_iter).collect();
        // Own nodes are those that anybody reaches; the others are those that this rank reaches.
        let mut nodes: Vec<(NodeId, usize, u64)> =
            own.iter().enumerate().map(|(k, &node)| (node, me, first + k as u64)).collect();
        for &(node, owner) in &asked {
            let number = answers[owner].next().expect("an answer to every question");
            if owner != me && number != INACTIVE {
                nodes.push((node, owner, number));
            }
        }
        nodes.sort_unstable();
        self.number(&nodes, lattice, &questions, (first, own.len(), n_all));
        ActiveNodes::listed(space, nodes.iter().map(|it| it.0).collect())
    }

    /// Tells the owners of nodes what this rank has of them, and hears what others have of its own.
    fn asked(&self, lattice: &Lattice<D>, asked: &[(NodeId, f64)]) -> Vec<(usize, Vec<(NodeId, f64)>)> {
        let mut out: Vec<Option<Writer>> = vec![None; self.wire.size()];
        for &(node, weight) in asked {
            let owner = self.cuts.borrow().owner(lattice.node_index(node));
            let out = out[owner].get_or_insert_with(Writer::default);
            out.count(node.index() as u64);
            out.number(weight);
        }
        self.wire.exchange(&sent(out)).iter().map(|(rank, bytes)| (*rank, read_question(bytes))).collect()
    }

    /// Takes note of the nodes of this rank, their owners and numbers, and of who has asked for them.
    fn number(
        &self,
        nodes: &[(NodeId, usize, u64)],
        lattice: &Lattice<D>,
        questions: &[(usize, Vec<(NodeId, f64)>)],
        (first, n_owned, n_all): (u64, usize, u64),
    ) {
        let (me, size) = (self.wire.rank(), self.wire.size());
        let place = |node: &NodeId| nodes.binary_search_by_key(node, |it| it.0).ok();
        let of_rank = |rank: usize| {
            let owned = nodes.iter().enumerate().filter(|(_, it)| it.1 == rank && rank != me);
            Common { rank, nodes: owned.map(|(v, _)| v as u32).collect() }
        };
        let mut of_owner: Vec<Common> = vec![];
        let mut has: Vec<bool> = vec![false; size];
        nodes.iter().for_each(|it| has[it.1] = true);
        of_owner.extend((0..size).filter(|&rank| rank != me && has[rank]).map(of_rank));
        let asked = questions.iter().filter(|it| it.0 != me).map(|(rank, asked)| Common {
            rank: *rank,
            nodes: asked.iter().filter_map(|it| place(&it.0)).map(|v| v as u32).collect(),
        });
        let of_sharer = asked.filter(|common| !common.nodes.is_empty()).collect();
        let padded = |node: NodeId| {
            let index = lattice.node_index(node);
            std::array::from_fn(|d| if d < D { index[d] } else { 0 })
        };
        let next = Numbering {
            nodes: nodes.iter().map(|it| it.0).collect(),
            index: nodes.iter().map(|it| padded(it.0)).collect(),
            owned: nodes.iter().map(|it| it.1 == me).collect(),
            global: nodes.iter().map(|it| it.2).collect(),
            first,
            n_owned,
            n_all,
            of_owner,
            of_sharer,
        };
        let mut changed = [f64::from(u8::from(next != *self.numbering.borrow()))];
        self.sum(&mut changed);
        if changed[0] > 0.0 {
            self.generation.set(self.generation.get() + 1);
            self.numbering.replace(next);
        }
    }

    /// Sum of a count over lower ranks, and over all.
    pub fn sum_before(&self, count: usize) -> (u64, u64) {
        let mut all = vec![0.0; self.wire.size()];
        self.wire.gather(&[count as f64], &mut all);
        let sum = |counts: &[f64]| counts.iter().map(|&n| n as u64).sum();
        (sum(&all[..self.wire.rank()]), sum(&all))
    }

    /// The numbers of all ranks, one after the other, and where those of this one stand among them.
    pub fn gathered(&self, own: &[f64]) -> (Vec<f64>, Range<usize>) {
        let bytes: Vec<u8> = own.iter().flat_map(|x| x.to_le_bytes()).collect();
        let out: Vec<(usize, Vec<u8>)> = (0..self.wire.size()).map(|rank| (rank, bytes.clone())).collect();
        let (mut all, mut range) = (Vec::new(), 0..own.len());
        for (rank, bytes) in self.wire.exchange(&out) {
            if rank == self.wire.rank() {
                range = all.len()..all.len() + own.len();
            }
            let numbers = bytes.chunks_exact(8).map(|it| it.try_into().expect("eight bytes"));
            all.extend(numbers.map(f64::from_le_bytes));
        }
        (all, range)
    }

    /// Sums over all ranks, number by number, in the order of the ranks.
    pub fn sum(&self, values: &mut [f64]) {
        self.fold(values, |a, b| a + b);
    }

    /// The least of all ranks, number by number; not a number where any rank has none.
    pub fn least(&self, values: &mut [f64]) {
        self.fold(values, |a, b| if a.is_nan() || a < b { a } else { b });
    }

    fn fold(&self, values: &mut [f64], join: impl Fn(f64, f64) -> f64) {
        if values.is_empty() {
            return;
        }
        let mut all = vec![0.0; values.len() * self.wire.size()];
        self.wire.gather(values, &mut all);
        let (first, others) = all.split_at(values.len());
        values.copy_from_slice(first);
        for of_rank in others.chunks_exact(values.len()) {
            values.iter_mut().zip(of_rank).for_each(|(value, it)| *value = join(*value, *it));
        }
    }

    /// Adds to `width` numbers per node what other ranks have of the same nodes: partial sums go to the owners, are added there
    /// in the order of the ranks, and come back as sums. All who share a node have the same bits then.
    pub fn complete(&self, field: &mut [f64], width: usize) {
        {
            let numbering = self.numbering.borrow();
            let out: Vec<(usize, Vec<u8>)> =
                numbering.of_owner.iter().map(|common| (common.rank, packed(field, width, common))).collect();
            let incoming = self.wire.exchange(&out);
            assert_eq!(incoming.len(), numbering.of_sharer.len(), "all who share a node send their part");
            for (common, (rank, bytes)) in numbering.of_sharer.iter().zip(&incoming) {
                assert_eq!(common.rank, *rank, "ranks are in order");
                unpack(bytes, width, common, |k, value| field[k] += value);
            }
        }
        self.spread(field, width);
    }

    /// Sets `width` numbers per node to those that the owner of the node has.
    pub fn spread(&self, field: &mut [f64], width: usize) {
        let numbering = self.numbering.borrow();
        let out: Vec<(usize, Vec<u8>)> =
            numbering.of_sharer.iter().map(|common| (common.rank, packed(field, width, common))).collect();
        let incoming = self.wire.exchange(&out);
        assert_eq!(incoming.len(), numbering.of_owner.len(), "all owners send their sums");
        for (common, (rank, bytes)) in numbering.of_owner.iter().zip(&incoming) {
            assert_eq!(common.rank, *rank, "ranks are in order");
            unpack(bytes, width, common, |k, value| field[k] = value);
        }
    }

    /// As [`Self::complete`], of vectors.
    pub fn complete_vectors(&self, field: &mut [Vector<D>]) {
        let mut flat: Vec<f64> = field.iter().flat_map(|x| x.iter().copied()).collect();
        self.complete(&mut flat, D);
        field.iter_mut().zip(flat.chunks_exact(D)).for_each(|(x, it)| x.copy_from_slice(it));
    }
}

/// Ranks and bytes of what has been written.
fn sent(out: Vec<Option<Writer>>) -> Vec<(usize, Vec<u8>)> {
    out.into_iter().enumerate().filter_map(|(rank, out)| Some((rank, out?.finish()))).collect()
}

fn read_question(bytes: &[u8]) -> Vec<(NodeId, f64)> {
    let (mut reader, mut asked) = (Reader::new(bytes), Vec::new());
    while !reader.is_at_end() {
        let node = NodeId::from_index(reader.index()).expect("the number of a node");
        asked.push((node, reader.number()));
    }
    asked
}

/// The nodes whose influences, added in the order of the ranks, make them active; ascending.
fn active_of(questions: &[(usize, Vec<(NodeId, f64)>)]) -> Vec<NodeId> {
    let mut all: Vec<(NodeId, f64)> = questions.iter().flat_map(|it| it.1.iter().copied()).collect();
    // Stable, so that the weights of a node stay in the order of the ranks.
    all.sort_by_key(|it| it.0);
    let sums = all.chunk_by(|a, b| a.0 == b.0);
    let active = sums.filter(|of_node| of_node.iter().map(|it| it.1).sum::<f64>() > ACTIVE);
    active.map(|of_node| of_node[0].0).collect()
}

fn packed(field: &[f64], width: usize, common: &Common) -> Vec<u8> {
    let of_node = |&v: &u32| &field[v as usize * width..(v as usize + 1) * width];
    common.nodes.iter().flat_map(of_node).flat_map(|x| x.to_le_bytes()).collect()
}

fn unpack(bytes: &[u8], width: usize, common: &Common, mut take: impl FnMut(usize, f64)) {
    assert_eq!(bytes.len(), 8 * width * common.nodes.len(), "the numbers of the nodes in common");
    let places = common.nodes.iter().flat_map(|&v| (0..width).map(move |i| v as usize * width + i));
    for (place, bytes) in places.zip(bytes.chunks_exact(8)) {
        take(place, f64::from_le_bytes(bytes.try_into().expect("eight bytes")));
    }
}
