//! Multigrid on lattices of every second line, as `mpm-linear` has it, parted among ranks.

use crate::assembly::Assembly;
use crate::error::PetscError;
use crate::handles::{Mat, Others};
use crate::numbering::Numbering;
use crate::owners::Owners;
use crate::product::{Product, Weight, Weights};
use crate::session::Session;
use mpm_cluster::Wire;
use mpm_linear::{Coarsening, LatticeLines, LatticePlaces};
use std::rc::Rc;

/// Nodes of the coarsest level, whose matrix every rank factorises for itself, at most.
pub(crate) const COARSEST: usize = 400;

/// The next coarser lattice of one level.
pub(crate) struct Coarser {
    pub(crate) interpolation: Mat,
    /// How the coarse matrix comes from this level's, and the coarse matrix, with zeros.
    pub(crate) product: Option<(Product, Mat)>,
    /// Who tells what other ranks have in a vector of this level.
    pub(crate) others: Option<Others>,
}

/// Nodes of one level: own ones first, then those of other ranks that own ones are coupled with.
struct Nodes {
    /// How many are own ones.
    own: usize,
    /// Lines on which they stand.
    index: Vec<[u32; 3]>,
    /// Bit i says that component i is held.
    held: Vec<u8>,
}

impl Nodes {
    /// From own ones; `others` tells of the others where the matrix couples with any.
    fn of(
        (index, held): (Vec<[u32; 3]>, Vec<u8>),
        block: usize,
        matrix: &Mat,
        others: &mut Option<Others>,
    ) -> Result<Self, PetscError> {
        let mut it = Self { own: index.len(), index, held };
        let Some(others) = others else { return Ok(it) };
        let (mut told, _) = matrix.vectors()?;
        // Three lines, and what is held.
        for d in 0..4 {
            told.with(|told| {
                for (node, told) in told.chunks_exact_mut(block).enumerate() {
                    told.fill(if d < 3 { it.index[node][d].into() } else { it.held[node].into() });
                }
            })?;
            others.hear(&told, |heard| {
                let heard = heard.chunks_exact(block).map(|it| it[0] as u32);
                if d == 0 {
                    it.index.extend(heard.map(|first| [first, 0, 0]));
                } else if d < 3 {
                    it.index[it.own..].iter_mut().zip(heard).for_each(|(index, heard)| index[d] = heard);
                } else {
                    it.held.extend(heard.map(|held| held as u8));
                }
            })?;
        }
        Ok(it)
    }

    /// The nodes that they are interpolated from, in order.
    fn parents(&self, coarsening: &Coarsening) -> Vec<[u32; 3]> {
        let mut parents = Vec::new();
        self.index.iter().for_each(|&it| coarsening.for_each_parent(it, |parent, _| parents.push(parent)));
        parents.sort_unstable();
        parents.dedup();
        parents
    }
}

/// The coarser lattices from the finest on, whose matrix this is; with Galerkin products where they are `with_products`. Bit i of `held` says that
/// component i of an own node is held.
///
/// Held components couple with nothing and are interpolated from no others. Where all that a coarse component would move is
/// held, it is, too: it is interpolated to held ones alone, so that coarse matrices have a diagonal everywhere.
pub(crate) fn coarser_lattices(
    (session, wire, owners): (&Rc<Session>, &dyn Wire, &dyn Owners),
    places: LatticePlaces<'_>,
    (finest, matrix): (&Numbering, &Mat),
    (held, block, is_symmetric): (&[u8], usize, bool),
    with_products: bool,
) -> Result<Vec<Coarser>, PetscError> {
    let (low, high) = bounds(wire, &finest.own);
    let mut lines = LatticeLines::of(places.lines, places.periods, low, high);
    let offset: [u32; 3] = std::array::from_fn(|d| if places.periods[d].is_some() { 0 } else { low[d] });
    let index = finest.own.iter().map(|it| std::array::from_fn(|d| it[d] - offset[d])).collect();
    let mut own = (index, held.to_vec());
    let (mut first, mut total) = (finest.first, finest.total);
    let (mut shift, mut levels) = ([0; 3], Vec::<Coarser>::new());
    while total > COARSEST {
        let Some(coarsening) = lines.coarser() else { break };
        (0..3).filter(|&d| coarsening.directions[d]).for_each(|d| shift[d] += 1);
        let finer = levels.last().and_then(|it| it.product.as_ref()).map_or(matrix, |it| &it.1);
        let mut others = if with_products { finer.others()? } else { None };
        let nodes = Nodes::of(own, block, finer, &mut others)?;
        let list = nodes.parents(&coarsening);
        // A coarse node is its finest node's owner's; a line beyond the last belongs to the last.
        let owner = |it: [u32; 3]| {
            owners.owner(std::array::from_fn(|d| ((it[d] << shift[d]) + offset[d]).min(high[d])))
        };
        let coarse = Numbering::of(wire, &list, owner);
        let (parents, free_of_own) = weights(wire, &nodes, &coarsening, (&list, &coarse));
        let interpolation = interpolation(session, &parents, (first, nodes.own), &coarse, block)?;
        let product = if with_products {
            let owners: Vec<u32> = list.iter().map(|&it| owner(it) as u32).collect();
            let product = product((session, wire), finer, parents, (nodes.own, block), (&coarse, &owners))?;
            product.1.say(is_symmetric, is_symmetric)?;
            Some(product)
        } else {
            None
        };
        levels.push(Coarser { interpolation, product, others });
        (first, total) = (coarse.first, coarse.total);
        own = (coarse.own, free_of_own.iter().map(|free| !free).collect());
        lines = coarsening.lines;
    }
    Ok(levels)
}

/// The parents of every node by their places in the list, and which components of own coarse nodes are free.
fn weights(
    wire: &dyn Wire,
    nodes: &Nodes,
    coarsening: &Coarsening,
    (list, coarse): (&[[u32; 3]], &Numbering),
) -> (Weights, Vec<u8>) {
    let place = |parent: [u32; 3]| list.binary_search(&parent).expect("parents are listed");
    let mut free = vec![0_u8; list.len()];
    for (&index, held) in nodes.index.iter().zip(&nodes.held) {
        coarsening.for_each_parent(index, |parent, _| free[place(parent)] |= !held);
    }
    let free_of_own = coarse.unite(wire, &mut free);
    let mut parents = Weights::new();
    for (&index, held) in nodes.index.iter().zip(&nodes.held) {
        coarsening.for_each_parent(index, |parent, weight| {
            let at = place(parent);
            // Free from free, held from held.
            let components = held ^ free[at];
            parents.push(Weight { node: at as u32, components, weight });
        });
        parents.end();
    }
    (parents, free_of_own)
}

/// The interpolation to so many own nodes, the first of which has this number.
fn interpolation(
    session: &Rc<Session>,
    parents: &Weights,
    (first, own): (usize, usize),
    coarse: &Numbering,
    block: usize,
) -> Result<Mat, PetscError> {
    let sizes = [own * block, coarse.own.len() * block];
    let interpolation = Mat::rectangular(session, sizes, 1 << block.min(3), block)?;
    for node in 0..own {
        for parent in parents.of(node) {
            let column = coarse.number[parent.node as usize] as usize * block;
            for i in (0..block).filter(|i| parent.components & (1 << i) != 0) {
                interpolation.put((first + node) * block + i, column + i, parent.weight)?;
            }
        }
    }
    interpolation.assemble()?;
    Ok(interpolation)
}

/// The product with the matrix of `own` nodes, and its matrix.
fn product(
    (session, wire): (&Rc<Session>, &dyn Wire),
    matrix: &Mat,
    parents: Weights,
    (own, block): (usize, usize),
    (coarse, owners): (&Numbering, &[u32]),
) -> Result<(Product, Mat), PetscError> {
    let n = owners.len();
    let children = parents.transposed(own, n);
    let mut blocks = None;
    matrix.with_parts(|parts| {
        blocks = Some(Product::blocks(&parts, block, (&parents, &children), n));
    })?;
    let blocks = blocks.expect("the rows are shown");
    let (assembly, coarse) = Assembly::of((session, wire), block, (coarse, owners), |see| {
        (0..n).for_each(|row| blocks.row(row).iter().for_each(|&column| see(row, column as usize)));
    })?;
    Ok((Product::of((parents, children), blocks, assembly), coarse))
}

/// First and last lines on which a node of any rank stands.
fn bounds(wire: &dyn Wire, own: &[[u32; 3]]) -> ([u32; 3], [u32; 3]) {
    let mut numbers = [0.0; 6];
    for d in 0..3 {
        numbers[d] = own.iter().map(|it| it[d]).min().map_or(f64::INFINITY, f64::from);
        numbers[3 + d] = own.iter().map(|it| it[d]).max().map_or(0.0, f64::from);
    }
    let mut all = vec![0.0; 6 * wire.size()];
    wire.gather(&numbers, &mut all);
    let low = |d: usize| all.chunks_exact(6).fold(f64::INFINITY, |least, it| least.min(it[d]));
    let high = |d: usize| all.chunks_exact(6).fold(0.0, |most: f64, it| most.max(it[3 + d]));
    // A float of infinity, where nobody has a node, becomes the last line.
    (std::array::from_fn(|d| (low(d).min(high(d))) as u32), std::array::from_fn(|d| high(d) as u32))
}
