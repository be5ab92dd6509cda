//! Rigid parts: nodes that cannot move against each other without straining a material point.

use mpm_basis::Connectivity;
use mpm_grid::Vector;

const NONE: u32 = u32::MAX;

/// The nodes of all bodies, by parts that move as one wherever no point is strained.
///
/// Node sets of points that share as many nodes as a hinge needs (a point in the plane and in the layer of bodies that turn
/// about an axis, a line in space) and one more
/// turn together; parts that share fewer are hinged to each other. Parts that share no node are not connected.
pub(crate) struct RigidParts {
    /// Start of every part's nodes in `node`, and its length at the end.
    start: Vec<usize>,
    node: Vec<u32>,
    /// Of every part: bodies with points in it, and how many.
    pub points: Vec<Vec<(usize, usize)>>,
    /// Parts of each assembly, which shares no node with others; ascending.
    pub assemblies: Vec<Vec<usize>>,
}

impl RigidParts {
    /// Of the bodies' node sets, at the positions of the active nodes, which have so many coordinates.
    pub(crate) fn of<const D: usize>(
        bodies: &[&Connectivity<D>],
        positions: &[Vector<D>],
        coordinates: usize,
    ) -> Self {
        let sets: Vec<(usize, usize)> = bodies
            .iter()
            .enumerate()
            .flat_map(|(body, connectivity)| (0..connectivity.n_node_sets()).map(move |set| (body, set)))
            .collect();
        let nodes_of = |set: usize| bodies[sets[set].0].node_set(sets[set].1);
        let (first, around) = sets_of_nodes(sets.len(), positions.len(), nodes_of);

        let mut part_of = vec![NONE; sets.len()];
        let mut shared = vec![Shared::NOTHING; sets.len()];
        let mut reached = vec![NONE; positions.len()];
        let mut parts = Self { start: vec![0], node: Vec::new(), points: Vec::new(), assemblies: Vec::new() };
        for seed in 0..sets.len() {
            if part_of[seed] != NONE || nodes_of(seed).is_empty() {
                continue;
            }
            let part = parts.points.len() as u32;
            let mut points = vec![0; bodies.len()];
            let mut joined = vec![seed];
            part_of[seed] = part;
            let mut next = *parts.start.last().expect("begins with 0");
            loop {
                while let Some(set) = joined.pop() {
                    let (body, number) = sets[set];
                    let connectivity = bodies[body];
                    let groups = connectivity.node_set_groups(number).iter();
                    points[body] +=
                        groups.map(|&group| connectivity.group_points(group as usize).len()).sum::<usize>();
                    for &node in nodes_of(set).iter().filter(|node| reached[**node as usize] != part) {
                        parts.node.push(node);
                    }
                    nodes_of(set).iter().for_each(|&node| reached[node as usize] = part);
                }
                let Some(&node) = parts.node.get(next) else { break };
                next += 1;
                for &set in &around[first[node as usize]..first[node as usize + 1]] {
                    let set = set as usize;
                    if part_of[set] == NONE && shared[set].turns_with(part, node, (positions, coordinates)) {
                        part_of[set] = part;
                        joined.push(set);
                    }
                }
            }
            parts.start.push(parts.node.len());
            parts.points.push(points.into_iter().enumerate().filter(|(_, points)| *points > 0).collect());
        }
        parts.assemblies = parts.assemble(positions.len());
        parts
    }

    /// Number of parts.
    pub(crate) fn len(&self) -> usize {
        self.points.len()
    }

    /// Active numbers of a part's nodes.
    pub(crate) fn nodes(&self, part: usize) -> &[u32] {
        &self.node[self.start[part]..self.start[part + 1]]
    }

    /// Groups of parts that share nodes.
    fn assemble(&self, n_nodes: usize) -> Vec<Vec<usize>> {
        let mut leader: Vec<usize> = (0..self.len()).collect();
        let mut owner = vec![NONE; n_nodes];
        for part in 0..self.len() {
            for &node in self.nodes(part) {
                let before = std::mem::replace(&mut owner[node as usize], part as u32);
                if before != NONE {
                    let (a, b) = (find(&mut leader, before as usize), find(&mut leader, part));
                    leader[a.max(b)] = a.min(b);
                }
            }
        }
        let mut assemblies: Vec<Vec<usize>> = vec![Vec::new(); self.len()];
        for part in 0..self.len() {
            assemblies[find(&mut leader, part)].push(part);
        }
        assemblies.retain(|parts| !parts.is_empty());
        assemblies
    }
}

fn find(leader: &mut [usize], mut part: usize) -> usize {
    while leader[part] != part {
        leader[part] = leader[leader[part]];
        part = leader[part];
    }
    part
}

/// The sets around every node: where they start, and their numbers.
fn sets_of_nodes<'a>(
    n_sets: usize,
    n_nodes: usize,
    nodes_of: impl Fn(usize) -> &'a [u32],
) -> (Vec<usize>, Vec<u32>) {
    let mut first = vec![0; n_nodes + 1];
    for &node in (0..n_sets).flat_map(&nodes_of) {
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
