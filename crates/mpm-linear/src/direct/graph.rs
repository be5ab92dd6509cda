//! Which nodes the pattern couples.

use crate::matrix::Pattern;

/// The couplings between nodes: for each node its neighbours, below and above, without itself.
pub(super) struct BlockGraph {
    start: Vec<usize>,
    neighbour: Vec<u32>,
}

impl BlockGraph {
    /// Reads the couplings of nodes off a pattern whose structure is symmetric.
    pub(super) fn new(pattern: Pattern<'_>) -> Self {
        let Pattern { column_start, row, block: components, blocks: n, .. } = pattern;
        assert!(n < u32::MAX as usize, "node numbers have 32 bits");

        // Each coupling once, by its lower-numbered node.
        let mut lower_start = Vec::with_capacity(n + 1);
        let mut lower = Vec::with_capacity(row.len() / (components * components) + n);
        let mut seen_by = vec![u32::MAX; n];
        let mut start = vec![0; n + 1];
        lower_start.push(0);
        for v in 0..n {
            seen_by[v] = v as u32;
            let entries = column_start[v * components]..column_start[(v + 1) * components];
            for &r in &row[entries] {
                let w = r / components;
                if w >= n || w < v {
                    continue;
                }
                if seen_by[w] != v as u32 {
                    seen_by[w] = v as u32;
                    lower.push(w as u32);
                    start[w + 1] += 1;
                    start[v + 1] += 1;
                }
            }
            lower_start.push(lower.len());
        }

        for v in 0..n {
            start[v + 1] += start[v];
        }
        let mut next = start.clone();
        let mut neighbour = vec![0; start[n]];
        for v in 0..n {
            for &w in &lower[lower_start[v]..lower_start[v + 1]] {
                neighbour[next[v]] = w;
                neighbour[next[w as usize]] = v as u32;
                next[v] += 1;
                next[w as usize] += 1;
            }
        }
        Self { start, neighbour }
    }

    /// Number of nodes.
    pub(super) fn len(&self) -> usize {
        self.start.len() - 1
    }

    /// Nodes coupled to node `v`.
    pub(super) fn neighbours(&self, v: usize) -> &[u32] {
        &self.neighbour[self.start[v]..self.start[v + 1]]
    }

    /// The largest distance in lattice lines between coupled nodes, per direction, the short way
    /// round in a periodic direction.
    pub(super) fn reach(&self, lattice: &[[u32; 3]], periodic: [Option<u32>; 3]) -> [u32; 3] {
        let mut reach = [0; 3];
        for v in 0..self.len() {
            for &w in self.neighbours(v) {
                for d in 0..3 {
                    let apart = lattice[v][d].abs_diff(lattice[w as usize][d]);
                    let apart = periodic[d].map_or(apart, |length| apart.min(length - apart));
                    reach[d] = reach[d].max(apart);
                }
            }
        }
        reach
    }

    /// Rearranges an elimination order (new to old) into a post-order of its elimination tree.
    ///
    /// The tree is Liu's (SIAM J. Matrix Anal. Appl. 11, 1990): the parent of a node is the first
    /// node eliminated after it whose pivot its elimination changes. Fill is the same for both orders.
    pub(super) fn postorder(&self, order: &[u32]) -> Vec<u32> {
        const NONE: u32 = u32::MAX;
        let n = self.len();
        let mut position = vec![0; n];
        for (k, &v) in order.iter().enumerate() {
            position[v as usize] = k as u32;
        }

        let (mut parent, mut ancestor) = (vec![NONE; n], vec![NONE; n]);
        for k in 0..n as u32 {
            for &w in self.neighbours(order[k as usize] as usize) {
                let mut i = position[w as usize];
                while i < k {
                    let above = ancestor[i as usize];
                    ancestor[i as usize] = k;
                    if above == NONE {
                        parent[i as usize] = k;
                        break;
                    }
                    i = above;
                }
            }
        }

        // Children in ascending order, as linked lists.
        let (mut first_child, mut sibling) = (vec![NONE; n], vec![NONE; n]);
        for i in (0..n).rev().filter(|&i| parent[i] != NONE) {
            let p = parent[i] as usize;
            sibling[i] = first_child[p];
            first_child[p] = i as u32;
        }
        let mut post = Vec::with_capacity(n);
        let mut path = Vec::new();
        for root in (0..n).filter(|&i| parent[i] == NONE) {
            path.push(root as u32);
            while let Some(&i) = path.last() {
                let child = first_child[i as usize];
                if child == NONE {
                    post.push(order[i as usize]);
                    path.pop();
                } else {
                    first_child[i as usize] = sibling[child as usize];
                    path.push(child);
                }
            }
        }
        post
    }
}
