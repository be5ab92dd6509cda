//! Where each node stands in sets of nodes.

use super::Couplings;

/// Which sets each node belongs to, and at which position.
pub(super) struct Incidence {
    start: Vec<usize>,
    entry: Vec<(u32, u32)>,
}

impl Incidence {
    pub(super) fn of(n_active: usize, couplings: &dyn Couplings) -> Self {
        let mut start = vec![0; n_active + 1];
        for set in 0..couplings.n_sets() {
            for &node in couplings.set(set) {
                start[node as usize + 1] += 1;
            }
        }
        for node in 0..n_active {
            start[node + 1] += start[node];
        }
        let mut next = start.clone();
        let mut entry = vec![(0, 0); start[n_active]];
        for set in 0..couplings.n_sets() {
            for (position, &node) in couplings.set(set).iter().enumerate() {
                let slot = &mut next[node as usize];
                entry[*slot] = (set as u32, position as u32);
                *slot += 1;
            }
        }
        Self { start, entry }
    }

    pub(super) fn at(&self, node: usize) -> &[(u32, u32)] {
        &self.entry[self.start[node]..self.start[node + 1]]
    }
}
