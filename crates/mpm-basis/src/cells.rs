//! Points gathered by the cell that holds them, for what couples all points of a cell.

use crate::Links;
use std::ops::Range;

/// A body's points by cell, with the nodes that the points of each cell influence together.
///
/// Derived from [`Links`] and from nothing but a number per point that tells cells apart.
#[derive(Clone, Debug, PartialEq)]
pub struct Cells {
    /// What the caller calls each cell.
    number: Vec<u32>,
    /// Start of every cell's nodes in `node`, and its length at the end.
    node_start: Vec<usize>,
    /// Active numbers, ascending within a cell.
    node: Vec<u32>,
    /// Start of every cell's parts in `part`, and its length at the end.
    part_start: Vec<usize>,
    part: Vec<Part>,
    /// For every part, positions of its group's nodes among the cell's.
    place: Vec<u32>,
}

/// Consecutive points of one group that lie in one cell.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Part {
    group: u32,
    /// Number of the first point in its group.
    first: u32,
    points: u32,
    /// Start in `place`.
    place: usize,
}

/// Some points of a group.
#[derive(Clone, Debug)]
pub struct CellPart<'a> {
    /// The group.
    pub group: usize,
    /// Its points that lie in the cell, numbered from the group's first.
    pub points: Range<usize>,
    /// Positions of the group's nodes among the nodes of the cell, ascending.
    pub place: &'a [u32],
}

impl Cells {
    /// Gathers the points of `links`; `cell` has a number per point, equal for points of one cell. `more` names
    /// further nodes of a cell, active numbers in any order.
    ///
    /// Cells are in the order of these numbers, the points of a cell in their own order.
    pub fn of<const D: usize>(links: &Links<D>, cell: &[u32], more: impl Fn(u32) -> Vec<u32>) -> Self {
        assert_eq!(links.n_points(), cell.len(), "one cell per point");
        let mut runs: Vec<(u32, Part)> = Vec::new();
        for group in 0..links.n_groups() {
            let points = links.group_points(group);
            let mut first = points.start;
            while first < points.end {
                let same = cell[first..points.end].iter().take_while(|&&it| it == cell[first]).count();
                let part = Part {
                    group: group as u32,
                    first: (first - points.start) as u32,
                    points: same as u32,
                    place: 0,
                };
                runs.push((cell[first], part));
                first += same;
            }
        }
        runs.sort_by_key(|&(cell, _)| cell);

        let mut cells = Self {
            number: Vec::new(),
            node_start: vec![0],
            node: Vec::new(),
            part_start: vec![0],
            part: Vec::with_capacity(runs.len()),
            place: Vec::new(),
        };
        let mut nodes: Vec<u32> = Vec::new();
        for of_cell in runs.chunk_by(|a, b| a.0 == b.0) {
            nodes.clear();
            nodes.extend(more(of_cell[0].0));
            for (_, part) in of_cell {
                nodes.extend_from_slice(links.group_nodes(part.group as usize));
            }
            nodes.sort_unstable();
            nodes.dedup();
            for (_, part) in of_cell {
                let place = cells.place.len();
                let mut at = 0;
                for &node in links.group_nodes(part.group as usize) {
                    at += nodes[at..].partition_point(|&it| it < node);
                    cells.place.push(at as u32);
                }
                cells.part.push(Part { place, ..*part });
            }
            cells.number.push(of_cell[0].0);
            cells.node.extend_from_slice(&nodes);
            cells.node_start.push(cells.node.len());
            cells.part_start.push(cells.part.len());
        }
        cells
    }

    /// Number of cells that hold points.
    pub fn len(&self) -> usize {
        self.number.len()
    }

    /// What the caller calls a cell.
    pub fn number(&self, cell: usize) -> u32 {
        self.number[cell]
    }

    /// Whether no cell holds a point.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Active numbers of the nodes of a cell: those that its points influence, and those named besides; ascending.
    #[inline]
    pub fn nodes(&self, cell: usize) -> &[u32] {
        &self.node[self.node_start[cell]..self.node_start[cell + 1]]
    }

    /// The points of a cell.
    #[inline]
    pub fn parts<'a, const D: usize>(
        &'a self,
        links: &'a Links<D>,
        cell: usize,
    ) -> impl Iterator<Item = CellPart<'a>> + Clone {
        self.part_range(cell).map(move |part| {
            let (group, first) = (part.group as usize, part.first as usize);
            let nodes = links.group_nodes(group).len();
            CellPart {
                group,
                points: first..first + part.points as usize,
                place: &self.place[part.place..part.place + nodes],
            }
        })
    }

    /// Number of points of a cell.
    pub fn n_points(&self, cell: usize) -> usize {
        self.part_range(cell).map(|part| part.points as usize).sum()
    }

    #[inline]
    fn part_range(&self, cell: usize) -> impl Iterator<Item = &Part> + Clone {
        self.part[self.part_start[cell]..self.part_start[cell + 1]].iter()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ActiveNodes, Gimp, Seed, Stencils};
    use mpm_grid::{Axis, Layout, Mesh, NodeSpace, Vector};

    #[test]
    fn every_point_is_in_its_cell_with_its_nodes() {
        // Two points a cell and direction, the rows of the upper half after those of the lower.
        let axis = Axis::uniform(0.0, 4.0, 4).unwrap();
        let mesh = Mesh::at_rest(&Layout::on_axes([axis.clone(), axis]).unwrap());
        let mut seeds: Vec<Seed<2, _>> = Vec::new();
        for cell in [[1, 1], [2, 1], [1, 2]] {
            for piece in [[-1.0, -1.0], [0.0, -1.0], [-1.0, 0.0], [0.0, 0.0]] {
                let low = Vector::<2>::new(piece[0], piece[1]);
                let piece = mesh.piece(cell, &low, &low.add_scalar(1.0));
                crate::Basis::seed(&Gimp::default(), &piece, &mut |seed| seeds.push(seed));
            }
        }
        seeds.rotate_left(6);
        let positions: Vec<Vector<2>> = seeds.iter().map(|seed| seed.position).collect();
        let domains: Vec<_> = seeds.iter().map(|seed| seed.domain).collect();
        let stencils = Stencils::of(&Gimp::default(), &mesh, &positions, &domains).unwrap();
        let active =
            ActiveNodes::of(&NodeSpace::vertices(mesh.lattice().clone()), std::slice::from_ref(&stencils));
        let links = Links::of(stencils, &active);
        let cell: Vec<u32> = positions.iter().map(|x| x.x as u32 + 4 * x.y as u32).collect();
        let cells = Cells::of(&links, &cell, |cell| if cell == 9 { vec![2, 0] } else { Vec::new() });

        assert_eq!((0..cells.len()).map(|k| cells.number(k)).collect::<Vec<_>>(), [5, 6, 9]);
        let mut seen = vec![0; positions.len()];
        for k in 0..cells.len() {
            assert_eq!(cells.n_points(k), 4);
            assert!(cells.nodes(k).windows(2).all(|pair| pair[0] < pair[1]));
            assert!(cells.number(k) != 9 || cells.nodes(k).starts_with(&[0, 2]));
            let mut order = Vec::new();
            for part in cells.parts(&links, k) {
                for (&at, node) in part.place.iter().zip(links.group_nodes(part.group)) {
                    assert_eq!(cells.nodes(k)[at as usize], *node);
                }
                order.extend(part.points.map(|it| links.group_points(part.group).start + it));
            }
            assert!(order.is_sorted());
            for p in order {
                assert_eq!(cell[p], cells.number(k));
                seen[p] += 1;
            }
        }
        assert_eq!(seen, [1; 12]);
    }
}
