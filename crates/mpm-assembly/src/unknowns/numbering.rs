//! The numbers of the unknowns of a load step.
//!
//! The displacement of the active nodes comes first, `D` unknowns for each node. Behind it contributions have blocks of
//! their own: a value for each node of a field, or the motion of a rigid tool. Unknowns that couple as one form a
//! *place*: the `D` components of a node's displacement, or the components of an entry of a block. No other file
//! computes the number of an equation.

use mpm_grid::Vector;

/// Number of an unknown, and of its equation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct UnknownId(u32);

impl UnknownId {
    /// Its equation in the linear system.
    #[inline]
    pub fn equation(self) -> usize {
        self.0 as usize
    }
}

/// Number of a place: active nodes first, then the entries of the blocks.
pub type Place = u32;

/// Equation of a component of a node's displacement.
#[inline]
pub(crate) fn node_equation<const D: usize>(node: usize, component: usize) -> usize {
    node * D + component
}

/// The unknowns of a load step.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unknowns<const D: usize> {
    nodes: usize,
    blocks: Vec<Block>,
}

/// Unknowns of a contribution: `count` places of `components` unknowns each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Block {
    first_place: u32,
    first_equation: u32,
    /// Number of the first unknown among those that belong to no node's displacement.
    first_own: u32,
    count: u32,
    components: u32,
}

impl Block {
    /// The place of an entry.
    pub fn place(&self, entry: usize) -> Place {
        self.first_place + entry as u32
    }

    /// A component of an entry.
    pub fn unknown(&self, entry: usize, component: usize) -> UnknownId {
        UnknownId(self.first_equation + entry as u32 * self.components + component as u32)
    }

    /// The values of the block in [`UnknownVector::own`], entry by entry.
    pub fn of<'a>(&self, own: &'a [f64]) -> &'a [f64] {
        let first = self.first_own as usize;
        &own[first..first + (self.count * self.components) as usize]
    }
}

impl<const D: usize> Unknowns<D> {
    /// The displacement of so many active nodes.
    pub fn of_nodes(nodes: usize) -> Self {
        Self { nodes, blocks: Vec::new() }
    }

    /// Puts `count` places of `components` unknowns each behind the others.
    pub fn push(&mut self, count: usize, components: usize) -> Block {
        let block = Block {
            first_place: narrow(self.n_places()),
            first_equation: narrow(self.n_equations()),
            first_own: narrow(self.n_own()),
            count: narrow(count),
            components: narrow(components),
        };
        self.blocks.push(block);
        block
    }

    /// Number of active nodes.
    pub fn n_nodes(&self) -> usize {
        self.nodes
    }

    /// Number of places.
    pub fn n_places(&self) -> usize {
        self.nodes + self.blocks.iter().map(|it| it.count as usize).sum::<usize>()
    }

    /// Number of unknowns that belong to no node's displacement.
    pub fn n_own(&self) -> usize {
        self.blocks.iter().map(|it| (it.count * it.components) as usize).sum()
    }

    /// Number of unknowns, and of equations.
    pub fn n_equations(&self) -> usize {
        node_equation::<D>(self.nodes, 0) + self.n_own()
    }

    /// A component of the displacement of an active node.
    pub fn displacement(&self, node: usize, component: usize) -> UnknownId {
        UnknownId(narrow(node_equation::<D>(node, component)))
    }

    /// The place of an active node's displacement.
    pub fn place(&self, node: usize) -> Place {
        assert!(node < self.nodes, "node {node} of {}", self.nodes);
        narrow(node)
    }

    /// Equations of a place.
    pub(crate) fn equations(&self, place: usize) -> std::ops::Range<usize> {
        if place < self.nodes {
            return node_equation::<D>(place, 0)..node_equation::<D>(place + 1, 0);
        }
        let holds = |it: &&Block| place < (it.first_place + it.count) as usize;
        let block = self.blocks.iter().find(holds).expect("a place of these unknowns");
        let first = block.unknown(place - block.first_place as usize, 0).equation();
        first..first + block.components as usize
    }

    /// The node and the component of an equation of a node's displacement.
    pub fn node_of(&self, equation: usize) -> Option<(usize, usize)> {
        let node = equation / D;
        (node < self.nodes).then_some((node, equation % D))
    }
}

fn narrow(number: usize) -> u32 {
    u32::try_from(number).expect("fewer than 2^32 unknowns")
}

/// One number for each unknown: the displacement of nodes (or the forces on them), then the blocks of contributions.
#[derive(Clone, Debug, PartialEq)]
pub struct UnknownVector<const D: usize> {
    /// Of every active node.
    pub nodes: Vec<Vector<D>>,
    /// Of the unknowns that belong to no node's displacement, block by block.
    pub own: Vec<f64>,
}

impl<const D: usize> UnknownVector<D> {
    /// Zero everywhere.
    pub fn zeros(unknowns: &Unknowns<D>) -> Self {
        Self { nodes: vec![Vector::zeros(); unknowns.n_nodes()], own: vec![0.0; unknowns.n_own()] }
    }

    /// Sets every number to zero.
    pub fn clear(&mut self) {
        self.nodes.fill(Vector::zeros());
        self.own.fill(0.0);
    }

    /// Takes the numbers of another vector of the same unknowns.
    pub fn copy_from(&mut self, other: &Self) {
        self.nodes.copy_from_slice(&other.nodes);
        self.own.copy_from_slice(&other.own);
    }

    /// Adds `factor` times another vector of the same unknowns.
    pub fn add(&mut self, factor: f64, other: &Self) {
        for (sum, it) in self.nodes.iter_mut().zip(&other.nodes) {
            *sum += it * factor;
        }
        for (sum, it) in self.own.iter_mut().zip(&other.own) {
            *sum += it * factor;
        }
    }

    /// Subtracts another vector of the same unknowns.
    pub fn subtract(&mut self, other: &Self) {
        for (sum, it) in self.nodes.iter_mut().zip(&other.nodes) {
            *sum -= it;
        }
        for (sum, it) in self.own.iter_mut().zip(&other.own) {
            *sum -= it;
        }
    }

    /// Scalar product, summed node by node.
    pub fn dot(&self, other: &Self) -> f64 {
        let nodes: f64 = self.nodes.iter().zip(&other.nodes).map(|(a, b)| a.dot(b)).sum();
        self.own.iter().zip(&other.own).fold(nodes, |sum, (a, b)| sum + a * b)
    }

    /// The numbers in the order of the equations.
    pub fn write_equations(&self, to: &mut Vec<f64>) {
        to.clear();
        to.extend(self.nodes.iter().flat_map(|node| node.iter().copied()));
        to.extend(&self.own);
    }

    /// Takes numbers in the order of the equations.
    pub fn read_equations(&mut self, from: &[f64]) {
        let (nodes, own) = from.split_at(node_equation::<D>(self.nodes.len(), 0));
        for (node, x) in self.nodes.iter_mut().zip(nodes.chunks_exact(D)) {
            node.copy_from_slice(x);
        }
        self.own.copy_from_slice(own);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_follow_the_displacement() {
        let mut unknowns = Unknowns::<2>::of_nodes(3);
        let (field, tool) = (unknowns.push(3, 1), unknowns.push(1, 3));
        assert_eq!((unknowns.n_places(), unknowns.n_own(), unknowns.n_equations()), (7, 6, 12));
        assert_eq!((unknowns.displacement(2, 1).equation(), unknowns.place(2)), (5, 2));
        assert_eq!((field.unknown(2, 0).equation(), tool.unknown(0, 2).equation()), (8, 11));
        assert_eq!((unknowns.equations(1), unknowns.equations(4), unknowns.equations(6)), (2..4, 7..8, 9..12));
        assert_eq!((field.place(1), tool.place(0)), (4, 6));
        assert_eq!((unknowns.node_of(5), unknowns.node_of(6)), (Some((2, 1)), None));
        let own = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0];
        assert_eq!((field.of(&own), tool.of(&own)), (&own[..3], &own[3..]));
    }

    #[test]
    fn a_vector_is_read_as_it_was_written() {
        let mut unknowns = Unknowns::<2>::of_nodes(2);
        unknowns.push(1, 1);
        let (mut vector, mut equations) = (UnknownVector::zeros(&unknowns), Vec::new());
        vector.read_equations(&[1.0, 2.0, 3.0, 4.0, 5.0]);
        vector.write_equations(&mut equations);
        assert_eq!(equations, [1.0, 2.0, 3.0, 4.0, 5.0]);
        assert_eq!(vector.dot(&vector), 55.0);
    }
}
