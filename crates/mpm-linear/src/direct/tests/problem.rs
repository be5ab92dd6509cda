//! Matrices to solve: elasticity on boxes, random values on lattice couplings.

use crate::direct::Factorization;
use crate::matrix::{Matrix, Pattern, Symmetry};
use crate::report::{Factored, Method, Solved};
use crate::solver::{Hints, LatticePlaces, LinearSolver};
use std::collections::BTreeMap;

/// A matrix with the places of its nodes.
pub(super) struct Problem {
    pub(super) column_start: Vec<usize>,
    pub(super) row: Vec<usize>,
    pub(super) values: Vec<f64>,
    pub(super) lattice: Vec<[u32; 3]>,
    pub(super) periodic: [Option<u32>; 3],
    pub(super) components: usize,
    pub(super) symmetry: Symmetry,
    lines: [Vec<f64>; 3],
}

impl Problem {
    pub(super) fn new(
        lattice: Vec<[u32; 3]>,
        components: usize,
        entries: &BTreeMap<(usize, usize), f64>,
    ) -> Self {
        let n = lattice.len() * components;
        let (mut column_start, mut row, mut values) = (vec![0; n + 1], Vec::new(), Vec::new());
        for (&(j, i), &k) in entries {
            column_start[j + 1] += 1;
            row.push(i);
            values.push(k);
        }
        for j in 0..n {
            column_start[j + 1] += column_start[j];
        }
        let lines = std::array::from_fn(|_| (0..80).map(f64::from).collect());
        let (periodic, symmetry) = ([None; 3], Symmetry::Symmetric);
        Self { column_start, row, values, lattice, periodic, components, symmetry, lines }
    }

    pub(super) fn pattern(&self) -> Pattern<'_> {
        let Self { column_start, row, symmetry, components, lattice, .. } = self;
        Pattern { column_start, row, symmetry: *symmetry, block: *components, blocks: lattice.len() }
    }

    pub(super) fn matrix(&self) -> Matrix<'_> {
        self.with(&self.values)
    }

    /// The matrix with other values.
    pub(super) fn with<'a>(&'a self, values: &'a [f64]) -> Matrix<'a> {
        Matrix { pattern: self.pattern(), values }
    }

    pub(super) fn places(&self) -> LatticePlaces<'_> {
        LatticePlaces { index: &self.lattice, lines: &self.lines, periods: self.periodic, degree: [1; 3] }
    }

    pub(super) fn hints(&self) -> Hints<'_> {
        Hints::on_lattice(self.places())
    }

    pub(super) fn n(&self) -> usize {
        self.column_start.len() - 1
    }

    pub(super) fn analysed(&self) -> Factorization {
        let mut factorization = Factorization::new();
        factorization.analyse(self.pattern(), &self.hints()).unwrap();
        factorization
    }

    /// ‖b − K x‖ / ‖b‖ after a solution by `start` or what follows it.
    pub(super) fn solve(&self, factorization: &mut Factorization, start: Method) -> (Factored, Solved, f64) {
        let b: Vec<f64> = (0..self.n()).map(|i| ((i * 7919) % 1000) as f64 / 1000.0 - 0.3).collect();
        let report = factorization.factorise_from(self.matrix(), start).unwrap();
        let mut x = b.clone();
        let solved = factorization.solve(self.matrix(), &mut x, 0.0).unwrap();
        let norm = |v: &mut dyn Iterator<Item = f64>| v.map(|v| v * v).sum::<f64>().sqrt();
        let r = norm(&mut self.matrix().times(&x).iter().zip(&b).map(|(kx, b)| b - kx))
            / norm(&mut b.iter().copied());
        (report, solved, r)
    }

    /// Both triangles, with the entry `of(i, j, k)` in row i and column j where the symmetric matrix has k.
    pub(super) fn unsymmetric(&self, of: impl Fn(usize, usize, f64) -> f64) -> Self {
        let mut entries = BTreeMap::new();
        for j in 0..self.n() {
            for e in self.column_start[j]..self.column_start[j + 1] {
                let (i, k) = (self.row[e], self.values[e]);
                entries.insert((j, i), of(i, j, k));
                entries.insert((i, j), of(j, i, k));
            }
        }
        let both = Self::new(self.lattice.clone(), self.components, &entries);
        Self { symmetry: Symmetry::Unsymmetric, periodic: self.periodic, ..both }
    }

    /// Sets row and column of an equation to zero, the diagonal to `diagonal`.
    pub(super) fn detach(&mut self, equation: usize, diagonal: f64) {
        for j in 0..self.n() {
            for e in self.column_start[j]..self.column_start[j + 1] {
                if j == equation || self.row[e] == equation {
                    self.values[e] = 0.0;
                }
            }
        }
        self.values[self.column_start[equation]] = diagonal;
    }
}

/// Gradients of the corners' shape functions of the unit cell at x.
fn gradients<const D: usize>(x: [f64; D]) -> Vec<[f64; D]> {
    let one = |corner: usize, d: usize, along: usize| match (corner >> d & 1 == 1, d == along) {
        (true, true) => 1.0,
        (false, true) => -1.0,
        (true, false) => x[d],
        (false, false) => 1.0 - x[d],
    };
    (0..1 << D).map(|c| std::array::from_fn(|along| (0..D).map(|d| one(c, d, along)).product())).collect()
}

/// Linear elasticity (E = 1, ν = 0.3, plane strain for D = 2) on a box of unit cells, clamped at
/// index 0 of the last direction, closed on itself in direction 0 if `ring`.
pub(super) fn elasticity<const D: usize>(cells: [u32; D], ring: bool) -> Problem {
    let (lambda, mu) = (0.3 / (1.3 * 0.4), 1.0 / 2.6);
    let nodes: [u32; D] = std::array::from_fn(|d| cells[d] + u32::from(d > 0 || !ring));
    let number = |p: [u32; D]| (0..D).rev().fold(0, |n, d| n * nodes[d] as usize + p[d] as usize);
    let count = |n: [u32; D]| n.iter().map(|&n| n as usize).product::<usize>();
    let place = |n: [u32; D], mut i: usize| -> [u32; D] {
        std::array::from_fn(|d| {
            let at = i % n[d] as usize;
            i /= n[d] as usize;
            at as u32
        })
    };
    let g = 0.5 / 3.0_f64.sqrt();
    let mut entries = BTreeMap::new();
    for cell in 0..count(cells) {
        let origin = place(cells, cell);
        let corner: Vec<usize> = (0..1 << D)
            .map(|c| number(std::array::from_fn(|d| (origin[d] + (c >> d & 1)) % nodes[d])))
            .collect();
        let clamped = |a: usize| origin[D - 1] == 0 && a >> (D - 1) & 1 == 0;
        for q in 0..1 << D {
            let dn = gradients::<D>(std::array::from_fn(|d| 0.5 + if q >> d & 1 == 1 { g } else { -g }));
            for (a, b) in (0..1 << D).flat_map(|a| (0..1 << D).map(move |b| (a, b))) {
                let dot: f64 = (0..D).map(|d| dn[a][d] * dn[b][d]).sum();
                for (i, j) in (0..D).flat_map(|i| (0..D).map(move |j| (i, j))) {
                    let (r, c) = (corner[a] * D + i, corner[b] * D + j);
                    let same = if i == j { mu * dot } else { 0.0 };
                    let k =
                        (lambda * dn[a][i] * dn[b][j] + mu * dn[a][j] * dn[b][i] + same) / f64::from(1 << D);
                    let k = match (clamped(a) || clamped(b), r == c) {
                        (true, diagonal) => f64::from(u8::from(diagonal)),
                        (false, _) => k,
                    };
                    if r >= c {
                        *entries.entry((c, r)).or_insert(0.0) += k;
                    }
                }
            }
        }
    }
    let lattice = (0..count(nodes)).map(|v| {
        let p = place(nodes, v);
        std::array::from_fn(|d| if d < D { p[d] } else { 0 })
    });
    let mut problem = Problem::new(lattice.collect(), D, &entries);
    problem.periodic[0] = ring.then_some(nodes[0]);
    problem
}

/// Random values on the couplings of nodes at most `reach` lines apart in a box, with the
/// diagonals `diagonal(equation, sum of the other entries' sizes)`.
pub(super) fn random(
    n: [u32; 3],
    reach: u32,
    components: usize,
    diagonal: impl Fn(usize, f64) -> f64,
) -> Problem {
    let mut lattice = Vec::new();
    for z in 0..n[2] {
        for y in 0..n[1] {
            lattice.extend((0..n[0]).map(|x| [x, y, z]));
        }
    }
    let mut state = 7_u64;
    let mut uniform = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    let mut entries = BTreeMap::new();
    let mut sum = vec![0.0; lattice.len() * components];
    for (v, w) in (0..lattice.len()).flat_map(|v| (v..lattice.len()).map(move |w| (v, w))) {
        if (0..3).any(|d: usize| lattice[v][d].abs_diff(lattice[w][d]) > reach) {
            continue;
        }
        for (i, j) in (0..components).flat_map(|i| (0..components).map(move |j| (i, j))) {
            let (r, c) = (w * components + i, v * components + j);
            if r > c {
                let k = uniform();
                entries.insert((c, r), k);
                sum[r] += k.abs();
                sum[c] += k.abs();
            }
        }
    }
    for (e, &sum) in sum.iter().enumerate() {
        entries.insert((e, e), diagonal(e, sum));
    }
    Problem::new(lattice, components, &entries)
}
