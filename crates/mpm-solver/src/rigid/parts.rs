//! Rigid parts: nodes that cannot move against each other without straining a material point.

use super::growth::{NONE, find, grown, grown_of_sets, united};
use crate::ranks::Ranks;
use mpm_basis::Connectivity;
use mpm_grid::{NodeId, Vector};

/// The nodes of all bodies, by parts that move as one wherever no point is strained.
///
/// Node sets of points that share as many nodes as a hinge needs (a point in the plane and in the layer of bodies that turn
/// about an axis, a line in space) and one more
/// turn together; parts that share fewer are hinged to each other. Parts that share no node are not connected.
///
/// A rank finds the parts of its own points, and tells all ranks of the *joints*: the nodes of these that other parts or other
/// ranks have as well. Joined by the same rule they are the parts of all points, the same on all ranks.
pub(crate) struct RigidParts<const D: usize> {
    /// Of every part: bodies with points in it, and how many.
    pub points: Vec<Vec<(usize, usize)>>,
    /// Parts of each assembly, which shares no node with others; ascending.
    pub assemblies: Vec<Vec<usize>>,
    /// Of every part, the active numbers of its nodes that are no joints, on this rank.
    inner: Vec<Vec<u32>>,
    /// Of every part, its joints; ascending.
    joints: Vec<Vec<u32>>,
    joint: Vec<Joint<D>>,
    /// Number of points of every body.
    pub n_points: Vec<usize>,
}

/// A node that several parts or several ranks have.
#[derive(Clone, Copy)]
pub(crate) struct Joint<const D: usize> {
    /// Where it stands `[L]`.
    pub position: Vector<D>,
    /// Its active number, where this rank has it.
    pub here: Option<u32>,
    /// Bit i is set if something holds it along direction i.
    held: u8,
}

impl<const D: usize> Joint<D> {
    pub(crate) fn is_held(&self, component: usize) -> bool {
        self.held & (1 << component) != 0
    }
}

/// The active nodes of a rank as parts see them.
#[derive(Clone, Copy)]
pub(crate) struct NodesAt<'a, const D: usize> {
    /// Ascending.
    pub nodes: &'a [NodeId],
    pub position: &'a dyn Fn(NodeId) -> Vector<D>,
    /// Whether a support holds an active node in a component.
    pub is_held: &'a dyn Fn(usize, usize) -> bool,
    /// Coordinates of their places.
    pub coordinates: usize,
    /// Number of points of every body, on this rank.
    pub n_points: &'a [usize],
}

/// The parts of the points of one rank: a place in the order of one rank alone, the points of bodies, and joints.
#[derive(Default)]
struct Told {
    /// The first body with points in it, and the least number of a point of its first node set.
    place: (usize, usize),
    points: Vec<(usize, usize)>,
    /// Nodes, and in which components they are held; ascending.
    joints: Vec<(u64, u8)>,
}

impl<const D: usize> RigidParts<D> {
    /// Of the bodies' node sets.
    pub(crate) fn of(bodies: &[&Connectivity<D>], at: NodesAt<'_, D>, ranks: &dyn Ranks<D>) -> Self {
        let sets: Vec<(usize, usize)> = bodies
            .iter()
            .enumerate()
            .flat_map(|(body, connectivity)| (0..connectivity.n_node_sets()).map(move |set| (body, set)))
            .collect();
        let nodes_of = |set: usize| bodies[sets[set].0].node_set(sets[set].1);
        let positions: Vec<Vector<D>> = at.nodes.iter().map(|&node| (at.position)(node)).collect();
        let groups = grown_of_sets(sets.len(), nodes_of, &positions, at.coordinates);
        let mut seen = vec![NONE; at.nodes.len()];
        let nodes: Vec<Vec<u32>> = groups.iter().map(|sets| united(sets, nodes_of, &mut seen)).collect();
        let is_joint = joints(&nodes, at.nodes.len(), ranks);
        let told = groups.iter().zip(&nodes).map(|(group, nodes)| {
            let joints = nodes.iter().filter(|node| is_joint[**node as usize]).map(|&node| {
                let held = (0..D).filter(|&i| (at.is_held)(node as usize, i)).fold(0, |held, i| held | 1 << i);
                (at.nodes[node as usize].index() as u64, held)
            });
            Told { joints: joints.collect(), ..told(group, &sets, bodies, ranks) }
        });
        let told: Vec<Told> = told.collect();
        let inner = nodes
            .into_iter()
            .map(|nodes| nodes.into_iter().filter(|node| !is_joint[*node as usize]).collect::<Vec<u32>>());
        Self::joined((&told, inner.collect()), at, ranks)
    }

    /// Joins the parts that all ranks tell of; `inner` are the nodes of the own ones that are no joints.
    fn joined((own, inner): (&[Told], Vec<Vec<u32>>), at: NodesAt<'_, D>, ranks: &dyn Ranks<D>) -> Self {
        let (all, first) = told_by_all(own, ranks);
        let mut ids: Vec<u64> = all.iter().flat_map(|it| it.joints.iter().map(|joint| joint.0)).collect();
        ids.sort_unstable();
        ids.dedup();
        let number = |id: u64| ids.binary_search(&id).expect("a joint of all") as u32;
        let mut joint: Vec<Joint<D>> = ids
            .iter()
            .filter_map(|&id| NodeId::from_index(id as usize))
            .map(|node| Joint {
                position: (at.position)(node),
                here: at.nodes.binary_search(&node).ok().map(|node| node as u32),
                held: 0,
            })
            .collect();
        for &(id, held) in all.iter().flat_map(|it| &it.joints) {
            joint[number(id) as usize].held |= held;
        }
        let of_told: Vec<Vec<u32>> =
            all.iter().map(|it| it.joints.iter().map(|joint| number(joint.0)).collect()).collect();
        let positions: Vec<Vector<D>> = joint.iter().map(|joint| joint.position).collect();
        let mut groups = grown(all.len(), |k| &of_told[k][..], &positions, at.coordinates);
        // Those without joints are parts of their own.
        groups.extend((0..all.len()).filter(|&k| of_told[k].is_empty()).map(|k| vec![k]));
        groups.sort_by_key(|group| group.iter().map(|&k| all[k].place).min());
        let mut parts = Self {
            points: Vec::new(),
            assemblies: Vec::new(),
            inner: Vec::new(),
            joints: Vec::new(),
            joint,
            n_points: all_points(at.n_points, ranks),
        };
        let mut seen = vec![NONE; ids.len()];
        for group in &groups {
            let of_body = |body: usize| {
                let points = group.iter().flat_map(|&k| &all[k].points).filter(|it| it.0 == body);
                (body, points.map(|it| it.1).sum::<usize>())
            };
            parts.points.push((0..at.n_points.len()).map(of_body).filter(|it| it.1 > 0).collect());
            let here = group.iter().filter_map(|&k| inner.get(k.checked_sub(first)?));
            parts.inner.push(here.flatten().copied().collect());
            parts.joints.push(united(group, |k| &of_told[k][..], &mut seen));
        }
        parts.assemblies = assemblies(&parts.joints, ids.len());
        parts
    }

    /// Number of parts.
    pub(crate) fn len(&self) -> usize {
        self.points.len()
    }

    /// Active numbers of those of a part's nodes that are no joints, on this rank.
    pub(crate) fn inner(&self, part: usize) -> &[u32] {
        &self.inner[part]
    }

    /// Joints of a part with their numbers.
    pub(crate) fn joints(&self, part: usize) -> impl Iterator<Item = (u32, &Joint<D>)> {
        self.joints[part].iter().map(|&number| (number, &self.joint[number as usize]))
    }
}

/// Whether a node belongs to several of these parts, or to another rank as well.
fn joints<const D: usize>(parts: &[Vec<u32>], n_nodes: usize, ranks: &dyn Ranks<D>) -> Vec<bool> {
    let mut times = vec![0_u32; n_nodes];
    parts.iter().flatten().for_each(|&node| times[node as usize] += 1);
    let mut having = vec![1.0; n_nodes];
    ranks.complete_numbers(&mut having);
    times.iter().zip(&having).map(|(&times, &ranks)| times > 1 || ranks > 1.0).collect()
}

/// What is told of the part of some node sets, but for its joints.
fn told<const D: usize>(
    group: &[usize],
    sets: &[(usize, usize)],
    bodies: &[&Connectivity<D>],
    ranks: &dyn Ranks<D>,
) -> Told {
    let mut points = vec![0; bodies.len()];
    let mut place = (usize::MAX, usize::MAX);
    for &(body, set) in group.iter().map(|&set| &sets[set]) {
        for &group in bodies[body].node_set_groups(set) {
            let here = bodies[body].group_points(group as usize);
            place = place.min((body, ranks.number_of_point(body, here.start)));
            points[body] += here.len();
        }
    }
    let points = points.into_iter().enumerate().filter(|(_, points)| *points > 0).collect();
    Told { place, points, joints: Vec::new() }
}

/// The parts that all ranks tell of, rank by rank, and how many come before the own ones.
fn told_by_all<const D: usize>(own: &[Told], ranks: &dyn Ranks<D>) -> (Vec<Told>, usize) {
    let mut numbers = Vec::new();
    let mut write = |number: usize| numbers.push(number as f64);
    for told in own {
        [told.place.0, told.place.1, told.points.len(), told.joints.len()].into_iter().for_each(&mut write);
        told.points.iter().flat_map(|it| [it.0, it.1]).for_each(&mut write);
        told.joints.iter().flat_map(|it| [it.0 as usize, usize::from(it.1)]).for_each(&mut write);
    }
    let (numbers, range) = ranks.gathered(numbers);
    let (mut all, mut first, mut at) = (Vec::new(), 0, 0);
    while at < numbers.len() {
        if at < range.start {
            first += 1;
        }
        let mut read = || {
            at += 1;
            numbers[at - 1] as usize
        };
        let (place, n_bodies, n_joints) = ((read(), read()), read(), read());
        let points = (0..n_bodies).map(|_| (read(), read())).collect();
        let joints = (0..n_joints).map(|_| (read() as u64, read() as u8)).collect();
        all.push(Told { place, points, joints });
    }
    (all, first)
}

/// Sums of counts over all ranks.
fn all_points<const D: usize>(here: &[usize], ranks: &dyn Ranks<D>) -> Vec<usize> {
    let mut counts: Vec<f64> = here.iter().map(|&count| count as f64).collect();
    ranks.sum(&mut counts);
    counts.into_iter().map(|count| count as usize).collect()
}

/// Groups of parts that share joints.
fn assemblies(joints: &[Vec<u32>], n_joints: usize) -> Vec<Vec<usize>> {
    let mut leader: Vec<usize> = (0..joints.len()).collect();
    let mut owner = vec![NONE; n_joints];
    for (part, joints) in joints.iter().enumerate() {
        for &joint in joints {
            let before = std::mem::replace(&mut owner[joint as usize], part as u32);
            if before != NONE {
                let (a, b) = (find(&mut leader, before as usize), find(&mut leader, part));
                leader[a.max(b)] = a.min(b);
            }
        }
    }
    let mut assemblies: Vec<Vec<usize>> = vec![Vec::new(); joints.len()];
    for part in 0..joints.len() {
        assemblies[find(&mut leader, part)].push(part);
    }
    assemblies.retain(|parts| !parts.is_empty());
    assemblies
}
