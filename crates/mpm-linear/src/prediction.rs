//! What both ways to solve a system will cost, from where its nodes stand.

use crate::matrix::Pattern;
use crate::multigrid::RESTART;
use crate::solver::LatticePlaces;

/// Operations that the direct solver makes in the time in which the iteration moves a byte, in the plane and in
/// space, where fronts are larger: with it both take as long for a cube of about 10³ cells, as measured, and
/// the iteration has half the time of the other where it is first chosen in the plane.
const OPERATIONS_PER_BYTE: [f64; 2] = [1.0, 2.0];

/// Iterations of an average linear solution of Newton's method.
const ITERATIONS: f64 = 12.0;

/// The same of matrices that are not symmetric, in the plane and in space, where frictional material flows: up to a
/// residual of 1e-3 GMRES took 10 to 54 iterations in space; in the plane near failure over 200.
const UNSYMMETRIC_ITERATIONS: [f64; 2] = [200.0, 40.0];

/// Iterations of GMRES that are reckoned with on a symmetric matrix that is not positive definite, in the plane and in space: a
/// guess. Cubes of 8³ cells with one to three springs of the wrong sign take 16 to 23 to ten digits; contact was not measured.
const INDEFINITE_ITERATIONS: [f64; 2] = [200.0, 60.0];

/// Operations that LU makes in the time in which GMRES moves a byte, in the plane and in space: 4.7 at 7,000 equations
/// in space, 8.5 at 47,000, 9.4 at 108,000.
const UNSYMMETRIC_OPERATIONS_PER_BYTE: [f64; 2] = [2.0, 8.0];

/// Entries of a factor beyond which an unsymmetric matrix is iterated on, whatever that takes: 8 GB.
const MOST_FACTOR_ENTRIES: f64 = 1e9;

/// Entries of a factor for which an iterative run still takes the direct solver's help: 8 GB.
const MOST_ENTRIES_AS_HELP: f64 = 1e9;

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
    /// Bytes of vectors that GMRES holds besides, where a symmetric matrix proves not to be positive definite.
    pub indefinite_bytes: f64,
    /// Bytes that GMRES moves on such a matrix.
    indefinite_traffic: f64,
    /// Operations that the direct solver makes in the time in which the iteration moves a byte.
    operations_per_byte: f64,
    /// Bytes that an iteration moves, and one of GMRES on a symmetric matrix that is not positive definite.
    of_one: f64,
    of_one_indefinite: f64,
    /// Whether the factor should not be stored.
    is_too_large: bool,
}

impl Prediction {
    /// Whether the iteration is predicted to be quicker, or the factor of an unsymmetric matrix to be too large.
    pub fn prefers_iterative(&self) -> bool {
        self.is_too_large || self.factor_operations > self.operations_per_byte * self.iterative_traffic
    }

    /// Whether a matrix that the iteration does not solve is factorised.
    pub fn is_factorised_as_help(&self) -> bool {
        self.factor_entries <= MOST_ENTRIES_AS_HELP
    }

    /// Whether a symmetric matrix that is not positive definite is left to GMRES rather than to the direct solver.
    pub fn prefers_gmres_where_indefinite(&self) -> bool {
        self.is_too_large || self.factor_operations > self.operations_per_byte * self.indefinite_traffic
    }

    /// Iterations that take as long as a factorisation.
    pub(crate) fn break_even(&self, is_indefinite: bool) -> f64 {
        let of_one = if is_indefinite { self.of_one_indefinite } else { self.of_one };
        self.factor_operations / (self.operations_per_byte * of_one)
    }
}

/// What an iteration takes besides the passes over the matrix.
struct Iteration {
    /// Iterations of an average solution.
    number: f64,
    /// Bytes of vectors that an iteration moves.
    traffic: f64,
    /// Bytes of vectors that are held.
    held: f64,
    operations_per_byte: f64,
}

impl Iteration {
    /// With `vector` bytes a vector; `is_space` is 1 in space, else 0.
    fn of(is_symmetric: bool, vector: f64, is_space: usize) -> Self {
        if is_symmetric {
            let operations_per_byte = OPERATIONS_PER_BYTE[is_space];
            return Self { number: ITERATIONS, traffic: 0.0, held: 0.0, operations_per_byte };
        }
        Self::of_gmres(UNSYMMETRIC_ITERATIONS[is_space], vector, UNSYMMETRIC_OPERATIONS_PER_BYTE[is_space])
    }

    fn of_gmres(number: f64, vector: f64, operations_per_byte: f64) -> Self {
        let most = RESTART as f64;
        // For each vector of the Krylov space, half of them on average, five vectors are read or written.
        let traffic = 5.0 * 0.5 * number.min(most) * vector;
        // Each in double precision, and preconditioned in single.
        Self { number, traffic, held: 1.5 * most * vector, operations_per_byte }
    }
}

/// All of a system that its cost is predicted from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SystemSize {
    nodes: f64,
    equations: f64,
    stored: f64,
    block: usize,
    is_symmetric: bool,
    has_blocks_only: bool,
    /// The box of lattice lines in which the nodes stand.
    low: [f64; 3],
    high: [f64; 3],
    /// Directions in which the lattice is closed on itself.
    is_closed: [bool; 3],
}

impl SystemSize {
    /// Of a pattern whose nodes stand on a lattice.
    pub fn of(pattern: Pattern<'_>, places: LatticePlaces<'_>) -> Self {
        let (mut low, mut high) = ([u32::MAX; 3], [0; 3]);
        for index in places.index {
            for d in 0..3 {
                (low[d], high[d]) = (low[d].min(index[d]), high[d].max(index[d]));
            }
        }
        Self {
            nodes: places.index.len() as f64,
            equations: pattern.n_equations() as f64,
            stored: pattern.n_entries() as f64,
            block: pattern.block,
            is_symmetric: pattern.is_symmetric(),
            has_blocks_only: pattern.has_blocks_only(),
            low: low.map(f64::from),
            high: high.map(f64::from),
            is_closed: places.periods.map(|period| period.is_some()),
        }
    }

    /// Of a system that several processes share, each with this part of it: `gather` returns the numbers of all of them, one
    /// process after the other. What two of them have counts twice.
    pub fn summed(self, gather: impl FnOnce(&[f64]) -> Vec<f64>) -> Self {
        let [x, y, z] = self.low;
        let [u, v, w] = self.high;
        let all = gather(&[self.nodes, self.equations, self.stored, x, y, z, u, v, w]);
        let mut sum = Self { nodes: 0.0, equations: 0.0, stored: 0.0, ..self };
        for part in all.as_chunks::<9>().0 {
            sum.nodes += part[0];
            sum.equations += part[1];
            sum.stored += part[2];
            for d in 0..3 {
                sum.low[d] = sum.low[d].min(part[3 + d]);
                sum.high[d] = sum.high[d].max(part[6 + d]);
            }
        }
        sum
    }

    /// Predicts from the box that the nodes stand in and how many they are. There is one equation a node for
    /// each dimension of space, and behind these at most one more a node, of a further field.
    pub fn predict(&self) -> Prediction {
        predicted(self)
    }
}

/// What [`SystemSize::predict`] says of a system of this process.
pub fn predict(pattern: Pattern<'_>, places: LatticePlaces<'_>) -> Prediction {
    SystemSize::of(pattern, places).predict()
}

fn predicted(size: &SystemSize) -> Prediction {
    let SystemSize { nodes: n, block: dimensions, low, high, .. } = *size;
    let mut sides: [f64; 3] = std::array::from_fn(|d| high[d] + 1.0 - low[d].min(high[d]));
    // A box of the same proportions with as many nodes as there are.
    let wide = sides.iter().filter(|&&side| side > 1.0).count().max(1);
    let shrink = (n / sides.iter().product::<f64>()).powf(1.0 / wide as f64);
    sides.iter_mut().filter(|side| **side > 1.0).for_each(|side| *side = (*side * shrink).max(1.0));

    // Both triangles of the matrix have that many blocks; the factors of an unsymmetric one are two.
    let (stored, factors) = if size.is_symmetric { (2.0, 1.0) } else { (1.0, 2.0) };
    let equations = size.equations / n;
    let blocks = size.stored / equations.powi(2) * stored;
    // A layer of nodes thick enough to part a region: half the couplings of a node along one direction.
    let layer = (0.5 * ((blocks / n).powf(1.0 / dimensions as f64) - 1.0)).max(1.0);
    let mut dissection = Dissection { layer, equations, entries: 0.0, operations: 0.0 };
    let (sides, border) = dissection.open(sides, size.is_closed);
    dissection.cut(sides, border);

    let is_space = usize::from(dimensions > 2);
    // The blocks of the iteration have an equation of the further field at every node.
    let side = if size.has_blocks_only { dimensions } else { dimensions + 1 };
    let vector = n * (side * size_of::<f64>()) as f64;
    let iteration = Iteration::of(size.is_symmetric, vector, is_space);
    let indefinite = match size.is_symmetric {
        true => Iteration::of_gmres(INDEFINITE_ITERATIONS[is_space], vector, iteration.operations_per_byte),
        false => Iteration { held: 0.0, ..iteration },
    };
    let block = (side * side * size_of::<f64>() + 4) as f64;
    // In single precision each column of a block fills a register.
    let single = (side * side.next_power_of_two() * size_of::<f32>()) as f64;
    let levels = 1.0 + 1.0 / ((1 << dimensions) as f64 - 1.0);
    // Of each block also where it comes from; of each node vectors, interpolation, a diagonal block.
    let per_node = (14 * side * size_of::<f64>() + 2 * side * side * size_of::<f64>() + 100) as f64;
    let factor_entries = dissection.entries * factors;
    // A matrix with a further field is written anew, with where its entries come from.
    let entry = 2 * size_of::<f64>() + size_of::<u32>();
    let interleaved = if side > dimensions { blocks / stored * (side * side * entry) as f64 } else { 0.0 };
    let pass = blocks * block;
    let [of_one, of_one_indefinite] = [&iteration, &indefinite].map(|it| pass * PASSES + it.traffic);
    let is_too_large = !size.is_symmetric && factor_entries > MOST_FACTOR_ENTRIES;
    Prediction {
        factor_entries,
        factor_operations: dissection.operations * factors,
        iterative_bytes: blocks * (levels * (block + single) + 8.0)
            + n * levels * per_node
            + iteration.held
            + interleaved,
        iterative_traffic: pass * PREPARATION + iteration.number * of_one,
        indefinite_bytes: indefinite.held,
        indefinite_traffic: pass * PREPARATION + indefinite.number * of_one_indefinite,
        operations_per_byte: iteration.operations_per_byte,
        of_one,
        of_one_indefinite,
        is_too_large,
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
    /// Cuts a region open where it is closed on itself: a separator more, which both of its new sides have.
    fn open(&mut self, mut sides: [f64; 3], is_closed: [bool; 3]) -> ([f64; 3], [f64; 3]) {
        let (layer, mut border) = (self.layer, [0.0; 3]);
        for d in 0..3 {
            if !is_closed[d] || sides[d] < 2.0 * layer + 1.0 {
                continue;
            }
            let area = |e: usize| sides[(e + 1) % 3] * sides[(e + 2) % 3] * layer * self.equations;
            let (pivots, around) = (area(d), (0..3).map(|e| border[e] * area(e)).sum());
            self.eliminate(pivots, around);
            (sides[d], border[d]) = (sides[d] - layer, 2.0);
        }
        (sides, border)
    }

    /// Adds a front with so many pivots and so many equations around them.
    fn eliminate(&mut self, pivots: f64, around: f64) {
        let front = pivots + around;
        self.entries += pivots * (front - 0.5 * pivots);
        self.operations += (front.powi(3) - around.powi(3)) / 3.0;
    }

    /// Halves a region; `border` is how many of the two sides across each direction are already cut.
    fn cut(&mut self, sides: [f64; 3], border: [f64; 3]) {
        let area = |d: usize| sides[(d + 1) % 3] * sides[(d + 2) % 3] * self.layer;
        let nodes: f64 = sides.iter().product();
        let around: f64 = (0..3).map(|d| border[d] * area(d)).sum();
        let longest = (0..3).fold(0, |most, d| if sides[d] > sides[most] { d } else { most });
        let is_leaf = nodes <= SMALL || sides[longest] < 2.0 * self.layer + 1.0;
        let pivots = if is_leaf { nodes } else { area(longest) } * self.equations;
        self.eliminate(pivots, around * self.equations);
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
