//! A tree of boxes around facets: which of them lie near a point or along a line.

use crate::bounds::Bounds;
use nalgebra::Vector3;

/// Facets in a leaf at most.
const LEAF: usize = 4;

/// Boxes within boxes, cut at medians; the same tree for the same facets.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Tree {
    nodes: Vec<Node>,
    /// Numbers of the facets in the order of the leaves.
    order: Vec<u32>,
}

#[derive(Clone, Debug, PartialEq)]
struct Node {
    bounds: Bounds<3>,
    /// Range of `order`.
    range: (u32, u32),
    /// The second child; the first one follows its parent. 0 in a leaf.
    second: u32,
}

impl Tree {
    /// The tree of facets with these boxes.
    pub(crate) fn new(boxes: &[Bounds<3>]) -> Self {
        let mut tree = Self { nodes: Vec::new(), order: (0..numbered(boxes.len())).collect() };
        let mut order = std::mem::take(&mut tree.order);
        tree.build(boxes, &mut order, 0);
        tree.order = order;
        tree
    }

    /// Adds the node of `order`, which begins at `first` of the whole, and all below it.
    fn build(&mut self, boxes: &[Bounds<3>], order: &mut [u32], first: usize) {
        let of = |facet: u32| &boxes[index(facet)];
        let bounds = order.iter().fold(Bounds::empty(), |all, &facet| all.with(of(facet)));
        let range = (numbered(first), numbered(first + order.len()));
        let node = self.nodes.len();
        self.nodes.push(Node { bounds, range, second: 0 });
        if order.len() <= LEAF {
            return;
        }
        let axis = (bounds.to - bounds.from).imax();
        let middle = |facet: u32| of(facet).from[axis] + of(facet).to[axis];
        let half = order.len() / 2;
        order.select_nth_unstable_by(half, |&a, &b| middle(a).total_cmp(&middle(b)).then(a.cmp(&b)));
        let (below, above) = order.split_at_mut(half);
        below.sort_unstable();
        above.sort_unstable();
        self.build(boxes, below, first);
        self.nodes[node].second = numbered(self.nodes.len());
        self.build(boxes, above, first + half);
    }

    /// A box around everything.
    pub(crate) fn bounds(&self) -> Bounds<3> {
        self.nodes.first().map_or_else(Bounds::empty, |node| node.bounds)
    }

    /// Calls `visit` with every facet of the leaves whose box `enters` accepts, in the order of the tree.
    pub(crate) fn visit(&self, mut enters: impl FnMut(&Bounds<3>) -> bool, mut visit: impl FnMut(usize)) {
        let mut waiting: Vec<usize> = vec![0];
        while let Some(at) = waiting.pop() {
            let node = &self.nodes[at];
            if !enters(&node.bounds) {
                continue;
            }
            if node.second == 0 {
                let (from, to) = node.range;
                self.order[index(from)..index(to)].iter().for_each(|&facet| visit(index(facet)));
            } else {
                waiting.extend([index(node.second), at + 1]);
            }
        }
    }

    /// The least value of `measure`, which tells a facet's squared distance from `x`, over all facets.
    pub(crate) fn least(&self, x: &Vector3<f64>, mut measure: impl FnMut(usize) -> f64) -> f64 {
        let mut least = f64::INFINITY;
        let mut waiting: Vec<usize> = vec![0];
        while let Some(at) = waiting.pop() {
            let node = &self.nodes[at];
            if squared_distance(&node.bounds, x) > least {
                continue;
            }
            if node.second == 0 {
                let (from, to) = node.range;
                for &facet in &self.order[index(from)..index(to)] {
                    least = least.min(measure(index(facet)));
                }
                continue;
            }
            // The nearer child first.
            let (one, two) = (at + 1, index(node.second));
            let away = |node: usize| squared_distance(&self.nodes[node].bounds, x);
            if away(one) <= away(two) { waiting.extend([two, one]) } else { waiting.extend([one, two]) }
        }
        least
    }
}

/// Squared distance from a point to a box `[L²]`, 0 inside.
pub(crate) fn squared_distance(bounds: &Bounds<3>, x: &Vector3<f64>) -> f64 {
    let beyond = (bounds.from - x).sup(&(x - bounds.to)).sup(&Vector3::zeros());
    beyond.norm_squared()
}

fn numbered(index: usize) -> u32 {
    u32::try_from(index).expect("a surface has fewer than 2^32 facets")
}

fn index(number: u32) -> usize {
    number as usize
}
