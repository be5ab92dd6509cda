//! Elasticity with a further field on the nodes of a part of the cells, which follows their shear.

use super::{element, lines};
use mpm_linear::{Automatic, Choice, Hints, LatticePlaces, LinearSolver, Matrix, Method, Pattern};
use std::collections::BTreeMap;

/// h, in units of Young's modulus, and l, in units of the edge of the cube.
const FIELD: (f64, f64) = (2.0, 0.1);

/// A cube of n³ cells, held at its base: ½ ε:C:ε + ½ h (d − k)² + ½ h l² |∇k|² with d = ∂u_x/∂z where 2 x < n.
struct Coupled {
    index: Vec<[u32; 3]>,
    lines: [Vec<f64>; 3],
    column_start: Vec<usize>,
    row: Vec<usize>,
    values: Vec<f64>,
    /// Nodes of the equations behind those of the nodes.
    field: Vec<usize>,
}

impl Coupled {
    fn cube(n: u32) -> Self {
        let nodes = n + 1;
        let place = |[x, y, z]: [u32; 3]| (x + nodes * (y + nodes * z)) as usize;
        let each = |n: u32| (0..n).flat_map(move |z| (0..n).flat_map(move |y| (0..n).map(move |x| [x, y, z])));
        let index: Vec<[u32; 3]> = each(nodes).collect();
        let is_regularised = |[x, ..]: [u32; 3]| 2 * x < n;
        let field: Vec<usize> = (0..index.len()).filter(|&node| 2 * index[node][0] <= n + 1).collect();
        let stiffness = element([1.0; 3], 0.3);
        let mut entries: BTreeMap<(usize, usize), f64> = BTreeMap::new();
        let mut add = |row: usize, column: usize, value: f64| {
            if row >= column {
                *entries.entry((column, row)).or_default() += value;
            }
        };
        for cell in each(n) {
            let corners: Vec<usize> = (0..8)
                .map(|c: u32| place([cell[0] + (c & 1), cell[1] + (c >> 1 & 1), cell[2] + (c >> 2)]))
                .collect();
            let mut equations: Vec<(usize, bool)> = Vec::new();
            for &node in &corners {
                equations.extend((0..3).map(|i| (3 * node + i, index[node][2] == 0)));
            }
            let own = |node: &usize| 3 * index.len() + field.binary_search(node).unwrap();
            if is_regularised(cell) {
                equations.extend(corners.iter().map(|node| (own(node), false)));
            }
            let coupled = coupled(f64::from(n));
            for (a, &(row, is_held)) in equations.iter().enumerate() {
                for (b, &(column, is_other_held)) in equations.iter().enumerate() {
                    let of_cell = if is_regularised(cell) { coupled(a, b) } else { 0.0 };
                    let value = of_cell + if a < 24 && b < 24 { stiffness[(a, b)] } else { 0.0 };
                    if a == b || !(is_held || is_other_held) {
                        add(row, column, value);
                    } else {
                        add(row, column, 0.0);
                    }
                }
            }
        }
        let n_equations = 3 * index.len() + field.len();
        let (mut column_start, mut row, mut values) = (vec![0; n_equations + 1], Vec::new(), Vec::new());
        for (&(column, at), &value) in &entries {
            column_start[column + 1] += 1;
            row.push(at);
            values.push(value);
        }
        for column in 0..n_equations {
            column_start[column + 1] += column_start[column];
        }
        Self { index, lines: lines([n; 3]), column_start, row, values, field }
    }

    fn matrix(&self) -> Matrix<'_> {
        let of_equations = Pattern::symmetric(&self.column_start, &self.row, 1);
        Matrix { pattern: Pattern { block: 3, blocks: self.index.len(), ..of_equations }, values: &self.values }
    }

    /// Solves for a force on the top and a source of the field.
    fn solve(&self, choice: Choice, tolerance: f64) -> (Vec<f64>, Method, u32) {
        let places =
            LatticePlaces { index: &self.index, lines: &self.lines, periods: [None; 3], degree: [1; 3] };
        let behind = 3 * self.index.len();
        let further = |equation: usize| self.field.get(equation - behind).copied();
        let hints = Hints { further: Some(&further), ..Hints::on_lattice(places) };
        let mut solver = Automatic::new(choice);
        solver.analyse(self.matrix().pattern, &hints).unwrap();
        solver.factorise(self.matrix()).unwrap();
        let top = self.index.iter().map(|index| index[2]).max().unwrap();
        let force = |(k, index): (usize, &[u32; 3])| {
            let x = f64::from(index[0]) / f64::from(top);
            if index[2] == top && k < 2 { 1.0 + x } else { 0.0 }
        };
        let nodes = self.index.iter().flat_map(|index| (0..3).map(move |k| force((k, index))));
        let mut x: Vec<f64> = nodes.chain(self.field.iter().map(|node| (*node as f64).sin())).collect();
        let solved = solver.solve(self.matrix(), &mut x, tolerance).unwrap();
        assert!(solved.taken_over.is_none(), "{solved:?}");
        (x, solved.method, solved.iterations)
    }
}

/// What the field adds to the stiffness of a regularised unit cell, one of n along the edge, by its equations.
fn coupled(n: f64) -> impl Fn(usize, usize) -> f64 {
    let (modulus, length) = (FIELD.0, FIELD.1 * n);
    let gauss = |at: usize| -> [f64; 3] {
        std::array::from_fn(|d| 0.5 + if at >> d & 1 == 1 { 0.5 } else { -0.5 } / 3.0_f64.sqrt())
    };
    let factor = |corner: usize, d: usize, x: f64| if corner >> d & 1 == 1 { x } else { 1.0 - x };
    let shape = move |corner: usize, x: [f64; 3]| (0..3).map(|d| factor(corner, d, x[d])).product::<f64>();
    let slope = move |corner: usize, d: usize, x: [f64; 3]| {
        let others = (0..3).filter(|e| *e != d).map(|e| factor(corner, e, x[e])).product::<f64>();
        if corner >> d & 1 == 1 { others } else { -others }
    };
    move |a: usize, b: usize| {
        // d − k by an equation: ∂/∂z of the displacement along x, and the field.
        let difference = |equation: usize, x: [f64; 3]| match equation {
            24.. => -shape(equation - 24, x),
            of_x if of_x % 3 == 0 => slope(of_x / 3, 2, x),
            _ => 0.0,
        };
        let of_point = |x: [f64; 3]| {
            let gradients = match (a.checked_sub(24), b.checked_sub(24)) {
                (Some(v), Some(w)) => (0..3).map(|d| slope(v, d, x) * slope(w, d, x)).sum(),
                _ => 0.0,
            };
            modulus * (difference(a, x) * difference(b, x) + length * length * gradients)
        };
        (0..8).map(|at| of_point(gauss(at)) / 8.0).sum()
    }
}

#[test]
fn the_solution_is_that_of_the_factorisation() {
    let system = Coupled::cube(8);
    let (exact, method, _) = system.solve(Choice::Direct, 0.0);
    assert_eq!(method, Method::Llt);
    let (found, method, iterations) = system.solve(Choice::Iterative, 1e-10);
    assert_eq!(method, Method::ConjugateGradients);
    assert!(iterations < 30, "{iterations}");
    let size = exact.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    for (k, (found, exact)) in found.iter().zip(&exact).enumerate() {
        assert!((found - exact).abs() < 1e-8 * size, "{k}: {found} {exact}");
    }
}

#[test]
fn iterations_do_not_grow_with_the_mesh() {
    let iterations = [6, 12, 24].map(|n| Coupled::cube(n).solve(Choice::Iterative, 1e-8).2);
    assert!(iterations[2] <= iterations[0] + 4 && iterations[2] < 30, "{iterations:?}");
}

/// An equation behind the nodes that belongs to none of them makes the system one for the direct solver.
#[test]
fn equations_of_no_node_are_factorised() {
    let system = Coupled::cube(3);
    let places =
        LatticePlaces { index: &system.index, lines: &system.lines, periods: [None; 3], degree: [1; 3] };
    let further = |equation: usize| Some(system.field[equation - 3 * system.index.len()]).filter(|v| *v > 0);
    let hints = Hints { further: Some(&further), ..Hints::on_lattice(places) };
    assert!(!Automatic::can_iterate(system.matrix().pattern, &hints));
    let mut solver = Automatic::new(Choice::Iterative);
    solver.analyse(system.matrix().pattern, &hints).unwrap();
    assert_eq!(solver.factorise(system.matrix()).unwrap().method, Method::Llt);
}
