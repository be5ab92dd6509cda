//! Sets of nodes grow into parts that turn together.

use mpm_grid::Vector;

/// No set, and no part.
pub(super) const NONE: u32 = u32::MAX;

/// Groups of sets that turn together, as [`grown`] finds them when it is asked again for groups of groups. It is quicker: of most
/// bodies a set and one before it in the list share enough nodes, and these are all one.
pub(super) fn grown_of_sets<'a, const D: usize>(
    n_sets: usize,
    nodes_of: impl Fn(usize) -> &'a [u32],
    positions: &[Vector<D>],
    coordinates: usize,
) -> Vec<Vec<usize>> {
    let clusters = clusters(n_sets, &nodes_of, positions, coordinates);
    if clusters.len() <= 1 {
        return clusters;
    }
    let mut seen = vec![NONE; positions.len()];
    let nodes: Vec<Vec<u32>> = clusters.iter().map(|sets| united(sets, &nodes_of, &mut seen)).collect();
    let groups = grown(clusters.len(), |cluster| &nodes[cluster][..], positions, coordinates);
    let sets = |group: Vec<usize>| group.into_iter().flat_map(|cluster| &clusters[cluster]).copied().collect();
    groups.into_iter().map(sets).collect()
}

/// Groups of sets that pairs which turn together hold together, by their first set; sets without nodes are in none. Each set
/// is compared with the last one before it that has one of its nodes.
fn clusters<'a, const D: usize>(
    n_sets: usize,
    nodes_of: &impl Fn(usize) -> &'a [u32],
    positions: &[Vector<D>],
    coordinates: usize,
) -> Vec<Vec<usize>> {
    let mut leader: Vec<usize> = (0..n_sets).collect();
    let mut latest = vec![NONE; positions.len()];
    for set in 0..n_sets {
        for &node in nodes_of(set) {
            let before = std::mem::replace(&mut latest[node as usize], set as u32);
            if before == NONE {
                continue;
            }
            let (a, b) = (find(&mut leader, before as usize), find(&mut leader, set));
            let mut shared = Shared::NOTHING;
            let mut turns = |node| shared.turns_with(0, node, (positions, coordinates));
            if a != b && common(nodes_of(before as usize), nodes_of(set)).any(&mut turns) {
                leader[a.max(b)] = a.min(b);
            }
        }
    }
    let mut number = vec![NONE; n_sets];
    let mut clusters: Vec<Vec<usize>> = Vec::new();
    for set in (0..n_sets).filter(|&set| !nodes_of(set).is_empty()) {
        let first = find(&mut leader, set);
        if number[first] == NONE {
            number[first] = clusters.len() as u32;
            clusters.push(Vec::new());
        }
        clusters[number[first] as usize].push(set);
    }
    clusters
}

/// What two ascending lists have in common, ascending.
fn common<'a>(a: &'a [u32], b: &'a [u32]) -> impl Iterator<Item = u32> + 'a {
    let mut rest = b;
    a.iter().copied().filter(move |it| {
        while rest.first().is_some_and(|other| other < it) {
            rest = &rest[1..];
        }
        rest.first() == Some(it)
    })
}

/// Groups of sets that turn together, by their first set; sets without nodes are in none.
pub(super) fn grown<'a, const D: usize>(
    n_sets: usize,
    nodes_of: impl Fn(usize) -> &'a [u32],
    positions: &[Vector<D>],
    coordinates: usize,
) -> Vec<Vec<usize>> {
    let (first, around) = sets_of_nodes(n_sets, positions.len(), &nodes_of);
    let mut part_of = vec![NONE; n_sets];
    let mut shared = vec![Shared::NOTHING; n_sets];
    let mut reached = vec![NONE; positions.len()];
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for seed in 0..n_sets {
        if part_of[seed] != NONE || nodes_of(seed).is_empty() {
            continue;
        }
        let part = groups.len() as u32;
        let (mut group, mut nodes, mut joined, mut next) = (vec![seed], Vec::new(), vec![seed], 0);
        part_of[seed] = part;
        loop {
            while let Some(set) = joined.pop() {
                for &node in nodes_of(set) {
                    if std::mem::replace(&mut reached[node as usize], part) != part {
                        nodes.push(node);
                    }
                }
            }
            let Some(&node) = nodes.get(next) else { break };
            next += 1;
            for &set in &around[first[node as usize]..first[node as usize + 1]] {
                let set = set as usize;
                if part_of[set] == NONE && shared[set].turns_with(part, node, (positions, coordinates)) {
                    part_of[set] = part;
                    group.push(set);
                    joined.push(set);
                }
            }
        }
        groups.push(group);
    }
    groups
}

/// The nodes of some sets, ascending; `seen` has an entry for each node there is, none of which is the first of these sets.
pub(super) fn united<'a>(sets: &[usize], nodes_of: impl Fn(usize) -> &'a [u32], seen: &mut [u32]) -> Vec<u32> {
    let Some(&mark) = sets.first() else { return Vec::new() };
    let is_new = |node: &u32| std::mem::replace(&mut seen[*node as usize], mark as u32) != mark as u32;
    let mut nodes: Vec<u32> =
        sets.iter().flat_map(|&set| nodes_of(set).iter().copied()).filter(is_new).collect();
    nodes.sort_unstable();
    nodes
}

/// The first member of a group, to which every member leads.
pub(super) fn find(leader: &mut [usize], mut member: usize) -> usize {
    while leader[member] != member {
        leader[member] = leader[leader[member]];
        member = leader[member];
    }
    member
}

/// The sets around every node: where they start, and their numbers.
fn sets_of_nodes<'a>(
    n_sets: usize,
    n_nodes: usize,
    nodes_of: &impl Fn(usize) -> &'a [u32],
) -> (Vec<usize>, Vec<u32>) {
    let mut first = vec![0; n_nodes + 1];
    for &node in (0..n_sets).flat_map(nodes_of) {
        first[node as usize + 1] += 1;
    }
    for node in 0..n_nodes {
        first[node + 1] += first[node];
    }
    let (mut next, mut around) = (first.clone(), vec![0; first[n_nodes]]);
    for set in 0..n_sets {
        for &node in nodes_of(set) {
            around[next[node as usize]] = set as u32;
            next[node as usize] += 1;
        }
    }
    (first, around)
}

/// Nodes that a set shares with the part that grows: those that fix the most of it.
#[derive(Clone, Copy)]
struct Shared {
    part: u32,
    count: u8,
    nodes: [u32; 2],
}

impl Shared {
    const NOTHING: Self = Self { part: NONE, count: 0, nodes: [0; 2] };

    /// Takes note of one more node that the set shares with the part; whether the two now move as one.
    fn turns_with<const D: usize>(
        &mut self,
        part: u32,
        node: u32,
        (positions, coordinates): (&[Vector<D>], usize),
    ) -> bool {
        if self.part != part {
            *self = Self { part, ..Self::NOTHING };
        }
        let count = usize::from(self.count);
        if count + 1 < coordinates {
            self.nodes[count] = node;
            self.count += 1;
            return false;
        }
        if coordinates < 3 {
            return true;
        }
        // A third node off the line through two.
        let [a, b] = self.nodes.map(|node| positions[node as usize]);
        let (along, aside) = (b - a, positions[node as usize] - a);
        let off = aside - along * (aside.dot(&along) / along.norm_squared());
        off.norm_squared() > 1e-12 * aside.norm_squared()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sets of a few nodes that are near each other by number, as cells in a row have them, and some that are not.
    fn random_sets(seed: u64, n_nodes: u32) -> Vec<Vec<u32>> {
        let mut state = seed;
        let mut random = |below: u32| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as u32 % below
        };
        let set = |_| {
            let (first, width) = (random(n_nodes), 2 + random(8));
            let mut nodes: Vec<u32> =
                (0..random(6)).map(|_| (first + random(width)).min(n_nodes - 1)).collect();
            nodes.sort_unstable();
            nodes.dedup();
            nodes
        };
        let mut sets: Vec<Vec<u32>> = (0..24).map(set).collect();
        sets.sort_by_key(|set| set.first().copied().unwrap_or(0));
        sets
    }

    /// Joins groups that turn together until there are none.
    fn joined<const D: usize>(
        sets: &[Vec<u32>],
        mut groups: Vec<Vec<usize>>,
        positions: &[Vector<D>],
        coordinates: usize,
    ) -> Vec<Vec<usize>> {
        loop {
            let mut seen = vec![NONE; positions.len()];
            let nodes: Vec<Vec<u32>> =
                groups.iter().map(|group| united(group, |set| &sets[set][..], &mut seen)).collect();
            let larger = grown(groups.len(), |group| &nodes[group][..], positions, coordinates);
            let is_last = larger.len() == groups.len();
            let of = |group: &Vec<usize>| group.iter().flat_map(|&part| groups[part].clone()).collect();
            groups = larger.iter().map(of).collect();
            groups.iter_mut().for_each(|group: &mut Vec<usize>| group.sort_unstable());
            groups.sort();
            if is_last {
                return groups;
            }
        }
    }

    /// Parts of sets by way of clusters and without, joined; without clusters it can take a turn more.
    fn of_sets<const D: usize>(
        sets: &[Vec<u32>],
        positions: &[Vector<D>],
        coordinates: usize,
    ) -> [Vec<Vec<usize>>; 2] {
        let nodes_of = |set: usize| &sets[set][..];
        let plain = grown(sets.len(), nodes_of, positions, coordinates);
        let by_clusters = grown_of_sets(sets.len(), nodes_of, positions, coordinates);
        assert!(by_clusters.len() <= plain.len());
        [plain, by_clusters].map(|groups| joined(sets, groups, positions, coordinates))
    }

    #[test]
    fn parts_are_the_same_by_way_of_clusters() {
        let mut several = 0;
        for seed in 0..400 {
            let sets = random_sets(seed, 40);
            let plane: Vec<Vector<2>> =
                (0..40).map(|k| Vector::<2>::new(f64::from(k % 7), f64::from(k / 7))).collect();
            let [expected, found] = of_sets(&sets, &plane, 2);
            assert_eq!(found, expected, "{sets:?}");
            several += usize::from(expected.len() > 1 && expected.iter().any(|group| group.len() > 2));
            // In space half of the nodes stand on one line, about which parts can turn.
            let at =
                |k: i32| Vector::<3>::new(f64::from(k), f64::from((k % 2) * k * k), f64::from((k % 4) * 3));
            let space: Vec<Vector<3>> = (0..40).map(at).collect();
            let [expected, found] = of_sets(&sets, &space, 3);
            assert_eq!(found, expected, "{sets:?}");
            several += usize::from(expected.len() > 1 && expected.iter().any(|group| group.len() > 2));
        }
        assert!(several > 100, "many have several parts, some of several sets: {several}");
    }
}
