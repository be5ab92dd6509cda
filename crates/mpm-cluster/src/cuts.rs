//! Boxes of cells, one for each rank: recursive bisection in the space of cell indices.
//!
//! Meshes that move or turn keep the indices of their cells, and with them who owns what. The planes are known to every
//! rank, so that an owner is found by a few comparisons. Nodes belong to the owner of the cell that has their index.

use crate::wire::Wire;

/// A box of cells: lowest index, and that behind the highest, in each direction.
type CellBox<const D: usize> = ([u32; D], [u32; D]);

/// Boxes of cells that cover a lattice, one for each rank.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Cuts<const D: usize> {
    /// Cells of the lattice.
    cells: [u32; D],
    /// In the order of the halvings; the first one cuts the lattice.
    planes: Vec<Plane>,
}

/// A plane between two lines of cells. What is below it belongs to the first half of the ranks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Plane {
    /// The ranks whose boxes it cuts apart, from `first` to before `middle` below, and from there to before `end` above.
    first: usize,
    middle: usize,
    end: usize,
    direction: usize,
    at: u32,
    /// The planes of the halves, where these are cut.
    below: Option<usize>,
    above: Option<usize>,
}

/// A box that is to be cut for the ranks from `first` to before `end`.
#[derive(Clone, Copy)]
struct Part<const D: usize> {
    first: usize,
    end: usize,
    cells: CellBox<D>,
    /// The plane that has made it, and whether it is above it.
    parent: Option<(usize, bool)>,
}

impl<const D: usize> Cuts<D> {
    /// One box: all cells belong to rank 0.
    pub fn whole(cells: [u32; D]) -> Self {
        Self { cells, planes: Vec::new() }
    }

    /// Boxes with about as many points each, for all ranks of `wire`, which give the cells of their points.
    pub fn balanced(cells: [u32; D], of_points: &[[u32; D]], wire: &impl Wire) -> Self {
        let mut cuts = Self::whole(cells);
        let mut level = vec![Part { first: 0, end: wire.size(), cells: ([0; D], cells), parent: None }];
        // Points by part; those that are in boxes of single ranks are done.
        let mut within: Vec<Vec<[u32; D]>> = vec![of_points.to_vec()];
        while level.iter().any(|part| part.end - part.first > 1) {
            let directions = directions(&level, &within, wire);
            let histograms = histograms(&level, &within, &directions, wire);
            let mut next = (Vec::new(), Vec::new());
            for (k, part) in level.iter().enumerate().filter(|(_, part)| part.end - part.first > 1) {
                let middle = (part.first + part.end) / 2;
                let direction = directions[k];
                let share = ((middle - part.first) as u64, (part.end - part.first) as u64);
                let at = part.cells.0[direction] + halves(&histograms[k], share);
                let number = cuts.planes.len();
                let plane =
                    Plane { first: part.first, middle, end: part.end, direction, at, below: None, above: None };
                cuts.planes.push(plane);
                if let Some((parent, is_above)) = part.parent {
                    let parent = &mut cuts.planes[parent];
                    let place = if is_above { &mut parent.above } else { &mut parent.below };
                    *place = Some(number);
                }
                let (mut low, mut high) = (part.cells, part.cells);
                (low.1[direction], high.0[direction]) = (at, at);
                let (below, above) = within[k].iter().partition(|cell| cell[direction] < at);
                next.0.push(Part { first: part.first, end: middle, cells: low, parent: Some((number, false)) });
                next.0.push(Part { first: middle, end: part.end, cells: high, parent: Some((number, true)) });
                next.1.extend([below, above]);
            }
            (level, within) = next;
        }
        cuts
    }

    /// The rank that owns a cell, or a node of the same index; indices beyond the last cell are those of the last.
    pub fn owner(&self, index: [u32; D]) -> usize {
        let Some(mut plane) = self.planes.first() else { return 0 };
        loop {
            let d = plane.direction;
            let is_above = index[d].min(self.cells[d] - 1) >= plane.at;
            let (next, alone) = if is_above { (plane.above, plane.middle) } else { (plane.below, plane.first) };
            match next {
                Some(next) => plane = &self.planes[next],
                None => return alone,
            }
        }
    }
}

/// Along which direction each part is cut: that in which its points reach farthest.
fn directions<const D: usize>(level: &[Part<D>], within: &[Vec<[u32; D]>], wire: &impl Wire) -> Vec<usize> {
    let mut own = Vec::with_capacity(2 * D * level.len());
    for cells in within {
        for d in 0..D {
            let of = || cells.iter().map(|cell| f64::from(cell[d]));
            own.push(of().fold(f64::INFINITY, f64::min));
            own.push(of().fold(f64::INFINITY, |least, x| least.min(-x)));
        }
    }
    let mut all = vec![0.0; own.len() * wire.size()];
    wire.gather(&own, &mut all);
    let least = |k: usize| all.iter().skip(k).step_by(own.len()).fold(f64::INFINITY, |a, &b| a.min(b));
    let extent = |part: &Part<D>, k: usize, d: usize| {
        let found = -least(2 * (k * D + d) + 1) - least(2 * (k * D + d));
        // Without points the box itself is cut.
        let whole = f64::from(part.cells.1[d]) - f64::from(part.cells.0[d]);
        if found.is_finite() { found } else { whole }
    };
    let longest = |(k, part): (usize, &Part<D>)| {
        (0..D).rev().max_by(|&a, &b| extent(part, k, a).total_cmp(&extent(part, k, b))).unwrap_or(0)
    };
    level.iter().enumerate().map(longest).collect()
}

/// Points of all ranks by line of cells across the direction of each part.
fn histograms<const D: usize>(
    level: &[Part<D>],
    within: &[Vec<[u32; D]>],
    directions: &[usize],
    wire: &impl Wire,
) -> Vec<Vec<u64>> {
    let lines = |part: &Part<D>, d: usize| (part.cells.1[d] - part.cells.0[d]) as usize;
    let mut own = Vec::new();
    for ((part, cells), &d) in level.iter().zip(within).zip(directions) {
        let first = own.len();
        own.resize(first + lines(part, d), 0.0);
        for cell in cells {
            own[first + (cell[d] - part.cells.0[d]) as usize] += 1.0;
        }
    }
    let mut all = vec![0.0; own.len() * wire.size()];
    wire.gather(&own, &mut all);
    let sum = |line: usize| all.iter().skip(line).step_by(own.len().max(1)).map(|&n| n as u64).sum();
    let mut first = 0;
    let of_part = |(part, &d): (&Part<D>, &usize)| {
        let range = first..first + lines(part, d);
        first = range.end;
        range.map(sum).collect()
    };
    level.iter().zip(directions).map(of_part).collect()
}

/// Lines below the plane that comes nearest to a share of the points; where there is a choice, the least.
fn halves(lines: &[u64], (part, of): (u64, u64)) -> u32 {
    let all: u64 = lines.iter().sum();
    if all == 0 {
        return (lines.len() as u64 * part / of) as u32;
    }
    // Compared in units of 1/of points: whole numbers.
    let (wanted, mut below) = (all * part, 0);
    let (mut best, mut at) = (wanted, 0);
    for (line, count) in lines.iter().enumerate() {
        below += count * of;
        if below.abs_diff(wanted) < best {
            (best, at) = (below.abs_diff(wanted), line + 1);
        }
    }
    at as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::threads::on_threads;

    /// Cells of a block with a corner cut off, four points each, dealt out to the ranks in turn.
    fn cuts(size: usize, part: impl Fn(usize, usize) -> bool + Sync) -> (Vec<[u32; 2]>, Vec<Cuts<2>>) {
        let cells: Vec<[u32; 2]> =
            (0..12).flat_map(|j| (0..20).map(move |i| [i, j])).filter(|c| c[0] + c[1] < 24).collect();
        let points: Vec<[u32; 2]> = cells.iter().flat_map(|&cell| [cell; 4]).collect();
        let cuts = on_threads(size, |wire| {
            let own = points.iter().enumerate().filter(|(k, _)| part(*k, wire.rank()));
            Cuts::balanced([30, 14], &own.map(|it| *it.1).collect::<Vec<_>>(), &wire)
        });
        (points, cuts)
    }

    #[test]
    fn every_rank_finds_the_same_boxes_and_points_are_shared_evenly() {
        for size in [1, 2, 3, 4, 7] {
            let (points, in_turn) = cuts(size, |k, rank| k % size == rank);
            let (_, on_last) = cuts(size, |_, rank| rank == size - 1);
            assert!(in_turn.iter().chain(&on_last).all(|cuts| *cuts == in_turn[0]), "{size} ranks");
            let mut counts = vec![0; size];
            points.iter().for_each(|&cell| counts[in_turn[0].owner(cell)] += 1);
            let (most, mean) = (*counts.iter().max().unwrap() as f64, points.len() as f64 / size as f64);
            // Whole lines of cells are the smallest piece: of 20 lines for 7 ranks, one is a third of a part.
            assert!(most / mean <= 1.0 + 0.07 * (size - 1) as f64, "{size} ranks: {counts:?}");
        }
    }

    #[test]
    fn every_cell_and_node_has_one_owner() {
        let (_, cuts) = cuts(7, |k, rank| k % 7 == rank);
        let mut cells = [0; 7];
        for (i, j) in (0..30).flat_map(|i| (0..14).map(move |j| (i, j))) {
            cells[cuts[0].owner([i, j])] += 1;
        }
        assert!(cells.iter().all(|&n| n > 0), "{cells:?}");
        assert_eq!(cells.iter().sum::<i32>(), 30 * 14);
        // The last nodes belong to the last cells.
        assert_eq!(cuts[0].owner([30, 14]), cuts[0].owner([29, 13]));
    }

    #[test]
    fn no_points_and_fewer_cells_than_ranks_are_cut_too() {
        let cuts = on_threads(7, |wire| Cuts::<2>::balanced([2, 1], &[], &wire));
        let owners = [cuts[0].owner([0, 0]), cuts[0].owner([1, 0])];
        assert!(owners[0] < owners[1], "{owners:?}");
        let all_in_one = on_threads(4, |wire| Cuts::<2>::balanced([5, 5], &[[2, 2]; 10], &wire));
        let owner = all_in_one[0].owner([2, 2]);
        assert!(owner < 4 && all_in_one.iter().all(|cuts| cuts.owner([2, 2]) == owner));
    }
}
