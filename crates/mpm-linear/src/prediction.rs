//! What both ways to solve a system will cost, from where its nodes stand.

use crate::matrix::Pattern;
use crate::solver::LatticePlaces;

/// Operations that the direct solver makes in the time in which the iteration moves a byte, in the plane and in
/// space, where fronts are larger: with it both take as long for a cube of about 10³ cells, as measured, and
/// the iteration has half the time of the other where it is first chosen in the plane.
const OPERATIONS_PER_BYTE: [f64; 2] = [1.0, 2.0];

/// Iterations of an average linear solution of Newton's method.
const ITERATIONS: f64 = 12.0;

/// Passes over all blocks in an iteration: product, two sweeps and a residual make three, coarser levels
/// a seventh more in space and a third more in the plane.
const PASSES: f64 = 3.4;

/// Passes over all blocks to set up the hierarchy.
const PREPARATION: f64 = 8.0;

/// Nodes of a region that is no longer dissected.
const SMALL: f64 = 16.0;

/// Predicted cost of one linear system.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prediction {
    /// Entries of the triangular factor.
    pub factor_entries: f64,
    /// Multiplications and additions of the factorisation.
    pub factor_operations: f64,
    /// Bytes of matrices and vectors of the multigrid hierarchy.
    pub iterative_bytes: f64,
    /// Bytes that setting it up and iterating move.
    pub iterative_traffic: f64,
    /// Operations that the direct solver makes in the time in which the iteration moves a byte.
    operations_per_byte: f64,
}

impl Prediction {
    /// Whether conjugate gradients are predicted to be quicker.
    pub fn prefers_iterative(&self) -> bool {
        self.factor_operations > self.operations_per_byte * self.iterative_traffic
    }

    /// Iterations that take as long as a factorisation.
    pub(crate) fn break_even(&self) -> f64 {
        let of_one = self.iterative_traffic * PASSES / (PASSES * ITERATIONS + PREPARATION);
        self.factor_operations / (self.operations_per_byte * of_one)
    }
}

/// Predicts from the box that the nodes stand in and how many they are. There is one equation a node for
/// each dimension of space.
pub fn predict(pattern: Pattern<'_>, places: LatticePlaces<'_>) -> Prediction {
    let dimensions = pattern.block;
    let n = places.index.len();
    let (mut low, mut high) = ([u32::MAX; 3], [0; 3]);
    for index in places.index {
        for d in 0..3 {
            (low[d], high[d]) = (low[d].min(index[d]), high[d].max(index[d]));
        }
    }
    let mut sides: [f64; 3] = std::array::from_fn(|d| f64::from(high[d] + 1 - low[d].min(high[d])));
    // A box of the same proportions with as many nodes as there are.
    let wide = sides.iter().filter(|&&side| side > 1.0).count().max(1);
    let shrink = (n as f64 / sides.iter().product::<f64>()).powf(1.0 / wide as f64);
    sides.iter_mut().filter(|side| **side > 1.0).for_each(|side| *side = (*side * shrink).max(1.0));

    // Both triangles of the matrix have that many blocks; the factors of an unsymmetric one are two.
    let (stored, factors) = if pattern.is_symmetric() { (2.0, 1.0) } else { (1.0, 2.0) };
    let blocks = pattern.row.len() as f64 / (dimensions * dimensions) as f64 * stored;
    // A layer of nodes thick enough to part a region: half the couplings of a node along one direction.
    let layer = (0.5 * ((blocks / n as f64).powf(1.0 / dimensions as f64) - 1.0)).max(1.0);
    let mut dissection = Dissection { layer, equations: dimensions as f64, entries: 0.0, operations: 0.0 };
    dissection.cut(sides, [0.0; 3]);

    let block = (dimensions * dimensions * size_of::<f64>() + 4) as f64;
    let levels = 1.0 + 1.0 / ((1 << dimensions) as f64 - 1.0);
    // Of each block also where it comes from; of each node vectors, interpolation, a diagonal block.
    let per_node =
        (14 * dimensions * size_of::<f64>() + 2 * dimensions * dimensions * size_of::<f64>() + 100) as f64;
    Prediction {
        factor_entries: dissection.entries * factors,
        factor_operations: dissection.operations * factors,
        iterative_bytes: blocks * (levels * block + 8.0) + n as f64 * levels * per_node,
        iterative_traffic: blocks * block * (PASSES * ITERATIONS + PREPARATION),
        operations_per_byte: OPERATIONS_PER_BYTE[usize::from(dimensions > 2)],
    }
}

/// Nested dissection of a box.
struct Dissection {
    layer: f64,
    equations: f64,
    entries: f64,
    operations: f64,
}

impl Dissection {
    /// Halves a region; `border` is how many of the two sides across each direction are already cut.
    fn cut(&mut self, sides: [f64; 3], border: [f64; 3]) {
        let area = |d: usize| sides[(d + 1) % 3] * sides[(d + 2) % 3] * self.layer;
        let nodes: f64 = sides.iter().product();
        let around: f64 = (0..3).map(|d| border[d] * area(d)).sum();
        let longest = (0..3).fold(0, |most, d| if sides[d] > sides[most] { d } else { most });
        let is_leaf = nodes <= SMALL || sides[longest] < 2.0 * self.layer + 1.0;
        let pivots = if is_leaf { nodes } else { area(longest) } * self.equations;
        let front = pivots + around * self.equations;
        self.entries += pivots * (front - 0.5 * pivots);
        self.operations += (front.powi(3) - (front - pivots).powi(3)) / 3.0;
        if is_leaf {
            return;
        }
        let half = 0.5 * (sides[longest] - self.layer);
        let (mut sides, mut border) = (sides, border);
        sides[longest] = half;
        // Both halves gain a side; where one was cut before, one of them has it.
        border[longest] = 1.0 + 0.5 * border[longest].min(2.0);
        let before = (self.entries, self.operations);
        self.cut(sides, border);
        // The other half is as the first.
        self.entries += self.entries - before.0;
        self.operations += self.operations - before.1;
    }
}
