//! Multigrid on lattices of every second line, as `mpm-linear` has it, parted among ranks.

use crate::error::PetscError;
use crate::handles::Mat;
use crate::numbering::Numbering;
use crate::owners::Owners;
use crate::session::Session;
use mpm_cluster::Wire;
use mpm_linear::{LatticeLines, LatticePlaces};
use std::rc::Rc;

/// Nodes of the coarsest level, whose matrix every rank factorises for itself, at most.
pub(crate) const COARSEST: usize = 400;

/// Interpolations from each coarser lattice, the finest first. Bit i of `held` says that component i of an own node is held.
///
/// Held components couple with nothing and are interpolated from no others. Where all that a coarse component would move is
/// held, it is, too: it is interpolated to held ones alone, so that coarse matrices have a diagonal everywhere.
pub(crate) fn interpolations(
    session: &Rc<Session>,
    (wire, owners): (&dyn Wire, &dyn Owners),
    places: LatticePlaces<'_>,
    finest: &Numbering,
    held: &[u8],
    block: usize,
) -> Result<Vec<Mat>, PetscError> {
    let (low, high) = bounds(wire, &finest.own);
    let mut lines = LatticeLines::of(places.lines, places.periods, low, high);
    let offset: [u32; 3] = std::array::from_fn(|d| if places.periods[d].is_some() { 0 } else { low[d] });
    let mut fine: Vec<[u32; 3]> =
        finest.own.iter().map(|it| std::array::from_fn(|d| it[d] - offset[d])).collect();
    let (mut first, mut total, mut held) = (finest.first, finest.total, held.to_vec());
    let (mut shift, mut interpolations) = ([0; 3], Vec::new());
    while total > COARSEST {
        let Some(coarsening) = lines.coarser() else { break };
        (0..3).filter(|&d| coarsening.directions[d]).for_each(|d| shift[d] += 1);
        let mut wanted = Vec::new();
        fine.iter().for_each(|&it| coarsening.for_each_parent(it, |parent, _| wanted.push(parent)));
        wanted.sort_unstable();
        wanted.dedup();
        // A coarse node is its finest node's owner's; a line beyond the last belongs to the last.
        let owner = |it: [u32; 3]| {
            owners.owner(std::array::from_fn(|d| ((it[d] << shift[d]) + offset[d]).min(high[d])))
        };
        let coarse = Numbering::of(wire, &wanted, owner);
        let mut free = vec![0_u8; wanted.len()];
        let place = |parent: [u32; 3]| wanted.binary_search(&parent).expect("parents are listed");
        for (&index, held) in fine.iter().zip(&held) {
            coarsening.for_each_parent(index, |parent, _| free[place(parent)] |= !held);
        }
        let free_of_own = coarse.unite(wire, &mut free);
        let sizes = [fine.len() * block, coarse.own.len() * block];
        let interpolation = Mat::rectangular(session, sizes, 1 << block.min(3), block)?;
        for (k, &index) in fine.iter().enumerate() {
            let mut done = Ok(());
            coarsening.for_each_parent(index, |parent, weight| {
                let at = place(parent);
                let column = coarse.number[at] as usize * block;
                // Free from free, held from held.
                let of_its_kind = held[k] ^ free[at];
                for i in (0..block).filter(|i| of_its_kind & (1 << i) != 0) {
                    if done.is_ok() {
                        done = interpolation.put((first + k) * block + i, column + i, weight);
                    }
                }
            });
            done?;
        }
        interpolation.assemble()?;
        interpolations.push(interpolation);
        held = free_of_own.iter().map(|free| !free).collect();
        (first, total) = (coarse.first, coarse.total);
        fine = coarse.own;
        lines = coarsening.lines;
    }
    Ok(interpolations)
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
