//! A column that leans between three walls.

use super::seen::{functions, run};

/// The hard self-weight column of so many cells, 12.5 wide, turned in a square grid whose corner is `offset` cells below that
/// of the box round the column, and held by walls on its base and both sides.
struct Column {
    degree: u32,
    cells: u32,
    angle: f64,
    offset: [f64; 2],
    in_space: bool,
}

const HEIGHT: f64 = 50.0;
const WIDTH: f64 = 12.5;
/// ρ₀ g H.
const PRESSURE: f64 = 80.0 * 10.0 * HEIGHT;

impl Column {
    /// Directions across and along the column.
    fn directions(&self) -> [[f64; 2]; 2] {
        let (sine, cosine) = self.angle.to_radians().sin_cos();
        [[cosine, sine], [-sine, cosine]]
    }

    fn size(&self) -> f64 {
        HEIGHT / f64::from(self.cells)
    }

    fn foot(&self) -> [f64; 2] {
        let [[_, sine], _] = self.directions();
        [self.offset[0] * self.size() + HEIGHT * sine, self.offset[1] * self.size()]
    }

    fn scene(&self) -> String {
        let ([across, along], h, [x, y]) = (self.directions(), self.size(), self.foot());
        let cells = |extent: f64, offset: f64| (extent / h + offset).ceil() + 3.0;
        let nx = cells(HEIGHT * across[1] + WIDTH * across[0], self.offset[0]);
        let ny = cells(HEIGHT * across[0] + WIDTH * across[1], self.offset[1]);
        // In space one cell deep, between faces of the mesh.
        let at = |x: f64, y: f64, z: f64| {
            if self.in_space { format!("({x:?}, {y:?}, {z:?})") } else { format!("({x:?}, {y:?})") }
        };
        let wall = |side: &str, from: f64, normal: [f64; 2], sign: f64| {
            let through = at(x + from * across[0], y + from * across[1], 0.0);
            let normal = at(sign * normal[0], sign * normal[1], 0.0);
            // In space the lower end along y is in front.
            let of_body = if self.in_space && side == "bottom" { "front" } else { side };
            format!(
                r#"(name: "{side}", body: "column", side: "{of_body}", surface: Plane(through: {through}, normal: {normal}))"#
            )
        };
        let walls = [
            wall("bottom", 0.0, along, 1.0),
            wall("left", 0.0, across, 1.0),
            wall("right", WIDTH, across, -1.0),
        ];
        let (kind, basis, depth, supports) = match self.in_space {
            false => ("PlaneStrain", "Cpdi2q", String::new(), String::new()),
            true => {
                let face = |name: &str, at: f64| {
                    format!(r#"(name: "{name}", region: Plane(axis: Z, at: {at:?}), fix: [Z])"#)
                };
                let faces = format!("supports: [{}, {}],", face("near", 0.0), face("far", h));
                ("Solid", "Cpdi2Hexahedron", format!(", Uniform(from: 0, to: {h:?}, cells: 1)"), faces)
            }
        };
        format!(
            r#"{kind}(
                mesh: Box(axes: [Uniform(from: 0, to: {:?}, cells: {nx}), Uniform(from: 0, to: {:?}, cells: {ny}){depth}], functions: {}),
                basis: {basis}, stabilisation: Ghost(), materials: {{ "soil": Hencky(young: 1e4, poisson: 0, density: 80) }},
                bodies: [(name: "column", material: "soil", tiling: Shape, points_per_cell: 2,
                    shape: Box(from: {}, to: {}, turned: {:?}))],
                walls: [{}], {supports} loads: [BodyForce(acceleration: {})],
                schedule: (steps: 40), output: (fields: [CauchyStress]),
            )"#,
            nx * h,
            ny * h,
            functions(self.degree),
            at(x, y, 0.0),
            at(x + WIDTH, y + HEIGHT, h),
            self.angle,
            walls.join(", "),
            at(-10.0 * along[0], -10.0 * along[1], 0.0),
        )
    }

    /// Mean error of the stress along the column, and the largest stress across it, over ρ₀ g H; the largest gap.
    fn errors(&self) -> [f64; 3] {
        let (seen, [across, along], [x, y]) = (run(&self.scene()), self.directions(), self.foot());
        let depth =
            seen.rest.chunks_exact(3).map(|at| HEIGHT - ((at[0] - x) * along[0] + (at[1] - y) * along[1]));
        let errors = seen.along(along).into_iter().zip(depth).map(|(s, depth)| (s + 800.0 * depth).abs());
        let errors: Vec<f64> = errors.collect();
        let lateral = seen.along(across).into_iter().map(f64::abs).fold(0.0, f64::max);
        let gaps = ["bottom", "left", "right"].map(|wall| seen.real(&format!("wall/{wall}/gap"))[0]);
        [
            errors.iter().sum::<f64>() / (errors.len() as f64 * PRESSURE),
            lateral / PRESSURE,
            gaps.into_iter().fold(0.0, f64::max),
        ]
    }
}

/// Columns, with the error, the largest gap and the largest lateral stress of an independent implementation.
const COLUMNS: &[(Column, [f64; 3])] = &[
    (
        Column { degree: 1, cells: 4, angle: 30.0, offset: [2.137, 2.291], in_space: false },
        [4.8845e-3, 1.2912e-2, 1.4323e-2],
    ),
    (
        Column { degree: 1, cells: 8, angle: 30.0, offset: [2.137, 2.291], in_space: false },
        [3.4165e-3, 6.4479e-3, 1.0053e-2],
    ),
    (
        Column { degree: 2, cells: 4, angle: 30.0, offset: [2.137, 2.291], in_space: false },
        [3.8448e-4, 1.2506e-2, 4.1696e-4],
    ),
    (
        Column { degree: 2, cells: 8, angle: 30.0, offset: [2.137, 2.291], in_space: false },
        [1.4913e-4, 6.2534e-3, 1.8605e-4],
    ),
    (
        Column { degree: 2, cells: 16, angle: 30.0, offset: [2.137, 2.291], in_space: false },
        [2.2955e-5, 3.1254e-3, 4.1606e-5],
    ),
    (
        Column { degree: 3, cells: 4, angle: 30.0, offset: [2.137, 2.291], in_space: false },
        [5.3912e-5, 1.2500e-2, 2.8741e-5],
    ),
    (
        Column { degree: 3, cells: 8, angle: 30.0, offset: [2.137, 2.291], in_space: false },
        [1.7603e-5, 6.2503e-3, 3.9231e-5],
    ),
    (
        Column { degree: 2, cells: 8, angle: 17.0, offset: [2.41, 2.77], in_space: false },
        [2.4028e-4, 6.2519e-3, 1.4255e-4],
    ),
    (
        Column { degree: 2, cells: 8, angle: 45.0, offset: [2.2, 2.6], in_space: false },
        [1.0141e-4, 6.2511e-3, 1.5692e-4],
    ),
];

#[test]
fn inclined_columns_are_those_of_an_independent_implementation() {
    for (column, [error, gap, lateral]) in COLUMNS {
        let found = column.errors();
        let Column { degree, cells, angle, .. } = column;
        let named = format!("degree {degree}, {cells} cells, {angle} degrees: {found:?}");
        assert!((0.85..1.05).contains(&(found[0] / error)), "{named}, expected {error:e}");
        assert!(found[1] < 1.05 * lateral, "{named}, expected {lateral:e}");
        assert!((found[2] / gap - 1.0).abs() < 0.01, "{named}, expected {gap:e}");
    }
}

#[test]
fn columns_at_any_angle() {
    for step in 0..13 {
        let angle = 7.0 * f64::from(step);
        let [error, ..] =
            Column { degree: 2, cells: 8, angle, offset: [2.137, 2.291], in_space: false }.errors();
        assert!(error < 6e-4, "{angle} degrees: {error:e}");
    }
}

/// One cell deep in space: the same numbers.
#[test]
fn an_inclined_column_in_space() {
    let column = Column { degree: 2, cells: 8, angle: 30.0, offset: [2.137, 2.291], in_space: true };
    let [error, _, gap] = column.errors();
    assert!((error / 1.4913e-4 - 1.0).abs() < 0.02, "{error:e}");
    assert!((gap / 6.2534e-3 - 1.0).abs() < 0.01, "{gap:e}");
}
