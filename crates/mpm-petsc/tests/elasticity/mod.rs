//! Stiffness of a lattice of elastic cells, as a rank that has some of the cells sums it.

use std::collections::BTreeMap;

/// What a rank has: lattice indices of its nodes, starts of columns, rows, values.
pub type Assembled = (Vec<[u32; 3]>, Vec<usize>, Vec<usize>, Vec<f64>);

/// A block of elastic cubes whose stiffness varies, held at its first plane of nodes.
pub struct Lattice<const D: usize> {
    cells: [u32; D],
    skew: f64,
    shift: f64,
    floats: bool,
}

impl<const D: usize> Lattice<D> {
    pub fn of(cells: [u32; D]) -> Self {
        Self { cells, skew: 0.0, shift: 0.0, floats: false }
    }

    /// With a tangent that is not symmetric, as that of frictional flow.
    pub fn skewed(self) -> Self {
        Self { skew: 0.3, ..self }
    }

    pub fn is_skewed(&self) -> bool {
        self.skew != 0.0
    }

    /// Less a multiple of the mass, so that some eigenvalues are negative.
    pub fn shifted(self) -> Self {
        Self { shift: 0.2, ..self }
    }

    /// Held nowhere.
    pub fn floating(self) -> Self {
        Self { floats: true, ..self }
    }

    pub fn lines(&self) -> [Vec<f64>; 3] {
        std::array::from_fn(|d| (0..=if d < D { self.cells[d] } else { 0 }).map(f64::from).collect())
    }

    /// Slabs of cells along the first direction.
    pub fn owner(&self, ranks: usize) -> impl Fn([u32; 3]) -> usize + 'static {
        let n = self.cells[0];
        move |node| node[0].min(n - 1) as usize * ranks / n as usize
    }

    /// A force at every node that is not held.
    pub fn force(&self, node: [u32; 3]) -> [f64; D] {
        let number = f64::from(node[0] + 7 * node[1] + 31 * node[2]);
        let is_held = node[0] == 0 && !self.floats;
        std::array::from_fn(|d| if is_held { 0.0 } else { (number + d as f64).sin() + 0.5 })
    }

    /// The sum over the cells of a rank. Held diagonals are set by the owners of their nodes.
    pub fn assembled(&self, rank: usize, ranks: usize) -> Assembled {
        let owner = self.owner(ranks);
        let mut blocks: BTreeMap<([u32; 3], [u32; 3]), [[f64; D]; D]> = BTreeMap::new();
        let element = self.element();
        for cell in indices(self.cells).filter(|it| owner(*it) == rank) {
            let stiffness = 1.0 + 0.5 * f64::from(cell[0] + 2 * cell[1] + 3 * cell[2]).sin();
            let corners: Vec<[u32; 3]> = (0..1 << D).map(|c| corner(cell, c)).collect();
            for (a, node) in corners.iter().enumerate() {
                for (b, other) in corners.iter().enumerate() {
                    let block = blocks.entry((key(*other), key(*node))).or_insert([[0.0; D]; D]);
                    for i in 0..D {
                        for j in 0..D {
                            block[i][j] += stiffness * element[a][b][i][j];
                        }
                    }
                }
            }
        }
        let all = indices(self.cells.map(|n| n + 1));
        let mut nodes: Vec<[u32; 3]> = blocks.keys().map(|it| it.1).collect();
        nodes.extend(all.filter(|it| owner(*it) == rank).map(key));
        nodes.sort_unstable();
        nodes.dedup();
        for node in &nodes {
            blocks.entry((*node, *node)).or_insert([[0.0; D]; D]);
        }
        self.by_columns(&nodes, &blocks, &|node| owner(key(node)) == rank)
    }

    fn by_columns(
        &self,
        nodes: &[[u32; 3]],
        blocks: &BTreeMap<([u32; 3], [u32; 3]), [[f64; D]; D]>,
        owns: &dyn Fn([u32; 3]) -> bool,
    ) -> Assembled {
        let number = |node: &[u32; 3]| nodes.binary_search(node).expect("every node is listed");
        let is_held = |node: [u32; 3]| node[2] == 0 && !self.floats;
        let (mut start, mut row, mut values) = (vec![0], Vec::new(), Vec::new());
        for column in nodes {
            let of_column = blocks.range((*column, [0; 3])..=(*column, [u32::MAX; 3]));
            let of_column: Vec<_> = of_column.collect();
            for j in 0..D {
                for ((_, node), block) in &of_column {
                    for i in 0..D {
                        let (r, c) = (number(node) * D + i, number(column) * D + j);
                        if r < c && !self.is_skewed() {
                            continue;
                        }
                        row.push(r);
                        values.push(match (is_held(*node) || is_held(*column), r == c) {
                            (true, true) if is_held(*node) => f64::from(u8::from(owns(*node))),
                            (true, _) => 0.0,
                            _ => block[i][j],
                        });
                    }
                }
                start.push(row.len());
            }
        }
        (nodes.iter().map(|it| key(*it)).collect(), start, row, values)
    }

    /// `∫ λ Na,i Nb,j + μ (Na,j Nb,i + δij Na,k Nb,k)` over a unit cube, with two points a direction.
    fn element(&self) -> Vec<Vec<[[f64; D]; D]>> {
        let (lambda, mu, n) = (1.5, 1.0, 1 << D);
        let mut sum = vec![vec![[[0.0; D]; D]; n]; n];
        for point in 0..n {
            let x: [f64; D] =
                std::array::from_fn(|d| 0.5 + (f64::from((point >> d & 1) as u8) - 0.5) / 3_f64.sqrt());
            let shape = |a: usize, d: usize| if a >> d & 1 == 1 { x[d] } else { 1.0 - x[d] };
            let value = |a: usize| (0..D).map(|d| shape(a, d)).product::<f64>();
            let slope = |a: usize, along: usize| {
                let sign = if a >> along & 1 == 1 { 1.0 } else { -1.0 };
                sign * (0..D).filter(|&d| d != along).map(|d| shape(a, d)).product::<f64>()
            };
            let weight = 0.5_f64.powi(D as i32);
            for a in 0..n {
                for b in 0..n {
                    let same: f64 = (0..D).map(|k| slope(a, k) * slope(b, k)).sum();
                    for i in 0..D {
                        for j in 0..D {
                            let mut k = lambda * slope(a, i) * slope(b, j) + mu * slope(a, j) * slope(b, i);
                            if i == j {
                                k += mu * same - self.shift * value(a) * value(b);
                            } else if i == 0 {
                                k += self.skew * slope(a, i) * slope(b, j);
                            }
                            sum[a][b][i][j] += weight * k;
                        }
                    }
                }
            }
        }
        sum
    }
}

/// Nodes sort as lattices number them; the same turns a key back.
fn key(index: [u32; 3]) -> [u32; 3] {
    [index[2], index[1], index[0]]
}

fn corner(cell: [u32; 3], number: usize) -> [u32; 3] {
    std::array::from_fn(|d| cell[d] + (number >> d & 1) as u32)
}

fn indices<const D: usize>(n: [u32; D]) -> impl Iterator<Item = [u32; 3]> {
    let count = |d: usize| if d < D { n[d] } else { 1 };
    let (x, y, z) = (count(0), count(1), count(2));
    (0..z).flat_map(move |k| (0..y).flat_map(move |j| (0..x).map(move |i| [i, j, k])))
}
