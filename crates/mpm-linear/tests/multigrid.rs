//! Linear elasticity of trilinear cells on lattices: whole, cut, graded and closed on themselves.

#[path = "multigrid/further_field.rs"]
mod further_field;
#[path = "multigrid/indefinite.rs"]
mod indefinite;
#[path = "multigrid/precision.rs"]
mod precision;
#[path = "multigrid/splines.rs"]
mod splines;
#[path = "multigrid/unsymmetric.rs"]
mod unsymmetric;

use mpm_linear::multigrid::{Failure, Multigrid};
use mpm_linear::{LatticePlaces, Matrix, Pattern};
use nalgebra::{DMatrix, SMatrix, Vector3};

type Element = SMatrix<f64, 24, 24>;

/// Stiffness of a box-shaped cell.
fn element(size: [f64; 3], poisson: f64) -> Element {
    let shear = 0.5 / (1.0 + poisson);
    let lame = poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
    let volume = size.iter().product::<f64>();
    let mut stiffness = Element::zeros();
    for gauss in 0..8 {
        let at: [f64; 3] =
            std::array::from_fn(|d| 0.5 + if gauss >> d & 1 == 1 { 0.5 } else { -0.5 } / 3.0_f64.sqrt());
        let gradient: Vec<Vector3<f64>> = (0..8)
            .map(|corner| {
                Vector3::from_fn(|d, _| {
                    (0..3)
                        .map(|e| match (e == d, corner >> e & 1 == 1) {
                            (true, upper) => (if upper { 1.0 } else { -1.0 }) / size[e],
                            (false, true) => at[e],
                            (false, false) => 1.0 - at[e],
                        })
                        .product()
                })
            })
            .collect();
        for (a, ga) in gradient.iter().enumerate() {
            for (b, gb) in gradient.iter().enumerate() {
                for i in 0..3 {
                    for j in 0..3 {
                        let same = if i == j { ga.dot(gb) } else { 0.0 };
                        stiffness[(3 * a + i, 3 * b + j)] +=
                            volume / 8.0 * (lame * ga[i] * gb[j] + shear * (ga[j] * gb[i] + same));
                    }
                }
            }
        }
    }
    stiffness
}

/// A matrix on the nodes of cells with weights, held where asked.
struct System {
    index: Vec<[u32; 3]>,
    lines: [Vec<f64>; 3],
    periodic: [Option<u32>; 3],
    column_start: Vec<usize>,
    row: Vec<usize>,
    values: Vec<f64>,
}

/// Columns and rows of the lower triangle where the nodes of every cell are all connected, three components a node.
fn lower_triangle(n_nodes: usize, cells: &[Vec<usize>]) -> (Vec<usize>, Vec<usize>) {
    let mut below: Vec<Vec<usize>> = vec![Vec::new(); n_nodes];
    for nodes in cells {
        for &a in nodes {
            for &b in nodes {
                if b > a && !below[a].contains(&b) {
                    below[a].push(b);
                }
            }
        }
    }
    let (mut column_start, mut row) = (vec![0], Vec::new());
    for (node, below) in below.iter_mut().enumerate() {
        below.sort_unstable();
        for component in 0..3 {
            row.extend((component..3).map(|i| 3 * node + i));
            below.iter().for_each(|&other| row.extend((0..3).map(|i| 3 * other + i)));
            column_start.push(row.len());
        }
    }
    (column_start, row)
}

impl System {
    /// Cells of `lines`, `weight` times as stiff (none where 0); components of nodes `held` are fixed.
    fn new(
        lines: [Vec<f64>; 3],
        periodic: [Option<u32>; 3],
        poisson: f64,
        weight: impl Fn([u32; 3]) -> f64,
        held: impl Fn([u32; 3], usize) -> bool,
    ) -> Self {
        let nodes: [u32; 3] = std::array::from_fn(|d| periodic[d].unwrap_or(lines[d].len() as u32));
        let cells: [u32; 3] = std::array::from_fn(|d| periodic[d].unwrap_or(lines[d].len() as u32 - 1));
        let place = |[x, y, z]: [u32; 3]| (x + nodes[0] * (y + nodes[1] * z)) as usize;
        let mut number = vec![usize::MAX; (nodes[0] * nodes[1] * nodes[2]) as usize];
        let mut filled = Vec::new();
        for z in 0..cells[2] {
            for y in 0..cells[1] {
                for x in 0..cells[0] {
                    let weight = weight([x, y, z]);
                    if weight == 0.0 {
                        continue;
                    }
                    let corners: Vec<[u32; 3]> = (0..8_u32)
                        .map(|c| {
                            [(x + (c & 1)) % nodes[0], (y + (c >> 1 & 1)) % nodes[1], (z + (c >> 2)) % nodes[2]]
                        })
                        .collect();
                    let size = std::array::from_fn(|d| {
                        let at = [x, y, z][d] as usize;
                        if periodic[d].is_some() {
                            lines[d][1] - lines[d][0]
                        } else {
                            lines[d][at + 1] - lines[d][at]
                        }
                    });
                    corners.iter().for_each(|&corner| number[place(corner)] = 0);
                    filled.push((corners, element(size, poisson) * weight));
                }
            }
        }
        let mut index = Vec::new();
        for z in 0..nodes[2] {
            for y in 0..nodes[1] {
                for x in 0..nodes[0] {
                    if number[place([x, y, z])] == 0 {
                        number[place([x, y, z])] = index.len();
                        index.push([x, y, z]);
                    }
                }
            }
        }
        let connected: Vec<Vec<usize>> = filled
            .iter()
            .map(|(corners, _)| corners.iter().map(|&corner| number[place(corner)]).collect())
            .collect();
        let (column_start, row) = lower_triangle(index.len(), &connected);
        let mut values = vec![0.0; row.len()];
        let fixed = |node: usize, i: usize| held(index[node], i);
        for (corners, stiffness) in &filled {
            for (a, &corner) in corners.iter().enumerate() {
                let node = number[place(corner)];
                for (b, &other) in corners.iter().enumerate() {
                    let other = number[place(other)];
                    for j in 0..3 {
                        for i in (0..3).filter(|&i| 3 * other + i >= 3 * node + j) {
                            let is_diagonal = 3 * other + i == 3 * node + j;
                            if !is_diagonal && (fixed(node, j) || fixed(other, i)) {
                                continue;
                            }
                            let column = column_start[3 * node + j]..column_start[3 * node + j + 1];
                            let at = row[column.clone()].binary_search(&(3 * other + i)).unwrap();
                            values[column.start + at] += stiffness[(3 * b + i, 3 * a + j)];
                        }
                    }
                }
            }
        }
        Self { index, lines, periodic, column_start, row, values }
    }

    /// A cube of n³ unit cells held at its base.
    fn cube(n: u32, poisson: f64) -> Self {
        Self::new(lines([n; 3]), [None; 3], poisson, |_| 1.0, |[_, _, z], _| z == 0)
    }

    fn matrix(&self) -> Matrix<'_> {
        Matrix { pattern: Pattern::symmetric(&self.column_start, &self.row, 3), values: &self.values }
    }

    fn multigrid(&self) -> Multigrid<3> {
        let places =
            LatticePlaces { index: &self.index, lines: &self.lines, periods: self.periodic, degree: [1; 3] };
        Multigrid::analyse(self.matrix().pattern, places).expect("symmetric")
    }

    /// A load that is free of held components, without regularity.
    fn load(&self) -> Vec<f64> {
        let n = self.column_start.len() - 1;
        let coupled: Vec<bool> = (0..n).map(|equation| self.couples(equation)).collect();
        (0..n).map(|i| if coupled[i] { ((i * 7919) % 101) as f64 / 50.0 - 1.0 } else { 0.0 }).collect()
    }

    fn couples(&self, equation: usize) -> bool {
        let first = equation / 3 * 3;
        let column = self.column_start[equation] + 1..self.column_start[equation + 1];
        column.clone().any(|entry| self.values[entry] != 0.0)
            || (first..equation).any(|j| self.values[self.column_start[j] + equation - j] != 0.0)
    }

    fn solve(&self, tolerance: f64) -> (Vec<f64>, u32) {
        let mut multigrid = self.multigrid();
        multigrid.prepare(self.matrix()).expect("positive definite");
        let mut x = self.load();
        let solved = multigrid.solve(&mut x, tolerance, 500).expect("converges");
        assert!(solved.residual <= tolerance);
        (x, solved.iterations)
    }
}

fn lines(cells: [u32; 3]) -> [Vec<f64>; 3] {
    cells.map(|n| (0..=n).map(f64::from).collect())
}

#[test]
fn the_solution_is_that_of_a_dense_factorisation() {
    let system = System::cube(5, 0.3);
    let (x, _) = system.solve(1e-12);
    let n = x.len();
    let mut dense = DMatrix::zeros(n, n);
    for j in 0..n {
        for entry in system.column_start[j]..system.column_start[j + 1] {
            dense[(system.row[entry], j)] = system.values[entry];
            dense[(j, system.row[entry])] = system.values[entry];
        }
    }
    let expected = dense.cholesky().unwrap().solve(&nalgebra::DVector::from_vec(system.load()));
    let error = x.iter().zip(expected.iter()).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
    assert!(error < 1e-9 * expected.amax(), "{error:e}");
}

#[test]
fn iterations_hardly_grow_with_the_mesh() {
    let iterations: Vec<u32> = [8, 16, 32].map(|n| System::cube(n, 0.3).solve(1e-8).1).to_vec();
    println!("{iterations:?}");
    assert!(iterations[2] <= 20 && 2 * iterations[2] <= 3 * iterations[0], "{iterations:?}");
}

#[test]
fn cells_cut_to_a_millionth_are_solved_as_well() {
    let n = 16;
    let whole = System::cube(n, 0.3).solve(1e-8).1;
    for cut in [0.5, 1e-2, 1e-4, 1e-6] {
        // The cells of three faces, and those of a ball's rim.
        let weight = |[x, y, z]: [u32; 3]| {
            if x == n - 1 || y == n - 1 || z == n - 1 { cut } else { 1.0 }
        };
        let system = System::new(lines([n; 3]), [None; 3], 0.3, weight, |[_, _, z], _| z == 0);
        let faces = system.solve(1e-8).1;
        let ball = |[x, y, z]: [u32; 3]| {
            let r = [x, y, z].map(|i| f64::from(i) + 0.5 - 8.0).iter().map(|r| r * r).sum::<f64>().sqrt();
            if r > 8.0 {
                0.0
            } else if r > 7.0 {
                cut
            } else {
                1.0
            }
        };
        let system = System::new(lines([n; 3]), [None; 3], 0.3, ball, |[_, _, z], _| z == 7);
        let rim = system.solve(1e-8).1;
        println!("cut {cut:e}: whole {whole}, faces {faces}, ball {rim}");
        assert!(faces <= 3 * whole && rim <= 3 * whole, "{cut:e}: {whole}, {faces}, {rim}");
    }
}

#[test]
fn flat_cells_graded_lines_and_rings_are_coarsened_where_lines_are_close() {
    let held = |[_, _, z]: [u32; 3], _: usize| z == 0;
    let flat: [Vec<f64>; 3] =
        std::array::from_fn(|d| (0..=24).map(|i| f64::from(i) * if d == 2 { 0.05 } else { 1.0 }).collect());
    let graded: [Vec<f64>; 3] = std::array::from_fn(|_| (0..=20).map(|i| 1.15_f64.powi(i)).collect());
    let beam = lines([64, 4, 4]);
    let found =
        [flat, graded, beam].map(|lines| System::new(lines, [None; 3], 0.3, |_| 1.0, held).solve(1e-8).1);
    let mut ring = lines([32, 8, 8]);
    ring[0].truncate(32);
    let ring = System::new(ring, [Some(32), None, None], 0.3, |_| 1.0, held).solve(1e-8).1;
    println!("{found:?}, ring {ring}");
    assert!(found[0].max(found[2]).max(ring) < 20, "{found:?}, ring {ring}");
    // Cells that are flat in different directions at different places are a point smoother's worst case.
    assert!(found[1] < 80, "{found:?}");
}

/// Solves on one thread and on several.
fn same_bits_on_all_threads(solve: impl Fn() -> Vec<f64> + Sync) {
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(&solve)
    };
    let one = with(1);
    for threads in [2, 3, 8] {
        let same = with(threads).iter().zip(&one).all(|(x, y)| x.to_bits() == y.to_bits());
        assert!(same, "{threads} threads");
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    let system = System::cube(12, 0.3);
    same_bits_on_all_threads(|| system.solve(1e-10).0);
}

#[test]
fn what_is_not_positive_definite_is_refused() {
    let mut system = System::cube(6, 0.3);
    let mut multigrid = system.multigrid();
    // A soft spring with the wrong sign at one node: all its pivots stay positive.
    let node = system.index.iter().position(|&index| index == [3, 3, 6]).unwrap();
    for i in 0..3 {
        let diagonal = system.column_start[3 * node + i];
        system.values[diagonal] -= 0.9 * system.values[diagonal];
    }
    let failed = multigrid.prepare(system.matrix()).and_then(|()| {
        let mut x = system.load();
        multigrid.solve(&mut x, 1e-8, 500).map(|_| ())
    });
    assert!(matches!(failed, Err(Failure::Indefinite { .. })), "{failed:?}");
    system.values[7] = f64::NAN;
    let failed = multigrid.prepare(system.matrix());
    assert!(matches!(failed, Err(Failure::NotFinite { .. })), "{failed:?}");
}

#[test]
fn too_few_iterations_are_reported_with_what_they_reached() {
    let system = System::cube(8, 0.3);
    let mut multigrid = system.multigrid();
    multigrid.prepare(system.matrix()).unwrap();
    let mut x = system.load();
    match multigrid.solve(&mut x, 1e-12, 3) {
        Err(Failure::NotConverged { iterations: 3, residual }) => assert!(residual < 0.5, "{residual}"),
        other => panic!("{other:?}"),
    }
}

#[test]
fn what_is_held_does_not_weigh_on_coarse_lattices() {
    // Nodes that are held one by one, in between such as are not.
    let held = |[x, _, z]: [u32; 3], _: usize| z == 0 && x % 4 == 1;
    let spotted = || System::new(lines([16; 3]), [None; 3], 0.3, |_| 1.0, held);
    let (system, mut heavy) = (spotted(), spotted());
    for equation in (0..heavy.column_start.len() - 1).filter(|&equation| !system.couples(equation)) {
        heavy.values[heavy.column_start[equation]] *= 1e9;
    }
    assert_eq!(heavy.solve(1e-8).1, system.solve(1e-8).1);
}

#[test]
fn equations_without_a_node_and_parts_of_blocks_are_declined() {
    let index = [[0, 0, 0], [1, 0, 0]];
    let lines = [vec![0.0, 1.0], vec![0.0], vec![0.0]];
    let places = LatticePlaces { index: &index, lines: &lines, periods: [None; 3], degree: [1; 3] };
    let (column_start, row) = ([0, 2, 4, 5], [0, 2, 1, 2, 2]);
    let bordered = Pattern { blocks: 2, ..Pattern::symmetric(&column_start, &row, 1) };
    assert!(Multigrid::<1>::analyse(bordered, places).is_none());
    // Components that do not couple are no blocks.
    let (column_start, row) = ([0, 1, 2, 3, 4], [0, 1, 2, 3]);
    assert!(Multigrid::<2>::analyse(Pattern::symmetric(&column_start, &row, 2), places).is_none());
    assert!(Multigrid::<2>::analyse(Pattern::unsymmetric(&column_start, &row, 2), places).is_none());
}
