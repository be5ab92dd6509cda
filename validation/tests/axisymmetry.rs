//! Bodies of revolution against tables of another code, and the faults that other codes had.

use mpm_scene::Scene;
use mpm_solver::observe::Field;
use mpm_validation::history::{History, Row};
use mpm_validation::scenes;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::path::Path;

fn run(text: &str) -> History {
    let scene = Scene::from_ron(text).unwrap_or_else(|error| panic!("{error}: {text}"));
    let run = scenes::run(&scene).unwrap_or_else(|error| panic!("{error}: {text}"));
    run.completed().unwrap_or_else(|error| panic!("{error}: {text}"))
}

/// Rows of `reference/axisymmetry/<name>.csv` below its comments and its head.
fn table(name: &str) -> Vec<Vec<String>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("reference/axisymmetry");
    let text = std::fs::read_to_string(folder.join(name)).unwrap();
    let rows = text.lines().filter(|line| !line.starts_with('#')).skip(1);
    rows.map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

fn basis(name: &str) -> &'static str {
    match name {
        "smpm" => "Smpm",
        "gimp" => "Gimp",
        "cpdi1" => "Cpdi1",
        "cpdi2q" => "Cpdi2q",
        other => panic!("no basis {other}"),
    }
}

fn last(history: &History, column: &str, component: usize) -> f64 {
    *history.series(column, component).last().unwrap()
}

/// `driven_ring.csv`: a disc whose inner edge is driven outward while its lines follow.
#[test]
fn a_driven_ring_agrees_with_the_table() {
    let table = table("driven_ring.csv");
    assert_eq!(table.len(), 24);
    for rows in table.chunks(3) {
        let (name, cells) = (basis(&rows[0][0]), rows[0][1].parse::<u32>().unwrap());
        let history = run(&format!(
            r#"Axisymmetric(
                mesh: Box(axes: [Uniform(from: 1, to: 2, cells: {cells}), Uniform(from: 0, to: 0.125, cells: 1)]),
                motion: Stretch([(axis: R, anchor: 2, driven: 1, displacement: 0.3)]), basis: {name},
                materials: {{ "m": Hencky(young: 1000, poisson: 0.3) }},
                bodies: [(name: "disc", material: "m", shape: Box(from: (1, 0), to: (2, 0.125)), points_per_cell: 2)],
                supports: [
                    (name: "z", region: Everywhere, fix: [Z]),
                    (name: "inner", region: Plane(axis: R, at: 1), displace: [(axis: R, by: 0.3)]),
                    (name: "outer", region: Plane(axis: R, at: 2), fix: [R]),
                ],
                schedule: (steps: 6), tolerance: (residual: 1e-12), output: (fields: []),
            )"#
        ));
        let force = history.series("reaction/inner", 0);
        for row in rows {
            let (step, expected) = (row[2].parse::<usize>().unwrap(), row[4].parse::<f64>().unwrap());
            let error = force[step] / 0.125 / expected - 1.0;
            assert!(error.abs() < 1e-10, "{name}, {cells} cells, step {step}: {error:e}");
        }
        let radii: f64 = history.last().positions.chunks_exact(3).map(|x| x[0]).sum();
        let expected = rows[2][5].parse::<f64>().unwrap();
        assert!((radii / expected - 1.0).abs() < 1e-10, "{name}, {cells} cells: {radii} {expected}");
    }
}

/// `sphere_sector.csv`: a hollow ball, its inside driven while the mesh rests.
#[test]
fn a_sector_of_a_ball_agrees_with_the_table() {
    let table = table("sphere_sector.csv");
    let rows: Vec<_> = table.iter().filter(|row| row[0] != "exact").collect();
    assert_eq!(rows.len(), 24);
    for row in rows {
        let number = |column: usize| row[column].parse::<f64>().unwrap();
        let (name, cells, steps) = (basis(&row[0]), number(2), number(4));
        let mean = if row[1] == "none" { "" } else { ", mean_dilatation: Points" };
        let law = match row[3].as_str() {
            "inf" => "Hencky(young: 1000, poisson: 0.3)".to_owned(),
            radius => format!("VonMises(young: 1000, poisson: 0.3, yield_radius: {radius})"),
        };
        let along = |k: u32| {
            let (sin, cos) = (FRAC_PI_2 * f64::from(k) / cells).sin_cos();
            [if f64::from(k) == cells { 0.0 } else { cos }, sin]
        };
        let support = |k: u32| {
            let driven: Vec<String> = ["R", "Z"]
                .iter()
                .zip(along(k))
                .filter(|it| it.1 != 0.0)
                .map(|(axis, part)| format!("(axis: {axis}, by: {})", 0.01 * part))
                .collect();
            let (angle, driven) = (90.0 * f64::from(k) / cells, driven.join(", "));
            format!(
                "(name: \"i{k}\", region: All([Circle(radius: 1), Ray(angle: {angle})]), displace: [{driven}]), "
            )
        };
        let supports: String = (0..=cells as u32).map(support).collect();
        let history = run(&format!(
            r#"Axisymmetric(
                mesh: Ring(radii: Uniform(from: 1, to: 3, cells: {cells}), sectors: {cells}, angles: (0, 90)),
                basis: {name}, materials: {{ "m": {law} }},
                bodies: [(name: "ball", material: "m", shape: Ring(inner: 1, outer: 3), points_per_cell: 2{mean})],
                supports: [(name: "floor", region: Plane(axis: Z, at: 0), fix: [Z]), {supports}],
                schedule: (steps: {steps}), tolerance: (residual: 1e-12), output: (fields: []),
            )"#
        ));
        let force: f64 = (0..=cells as u32)
            .map(|k| (0..2).map(|c| along(k)[c] * last(&history, &format!("reaction/i{k}"), c)).sum::<f64>())
            .sum();
        let error = force / (TAU * 1.01 * 1.01) / number(5) - 1.0;
        // Where quadrilaterals have deformed, their points follow the corners here, and the shape functions there.
        let allowed = if name == "Cpdi2q" && steps > 1.0 { 1e-5 } else { 1e-9 };
        assert!(error.abs() < allowed, "{row:?}: {error:e}");
    }
}

/// The column under its own weight of linear shape functions, wherever it stands: points per cell, cells, mean error of the
/// stress, highest point, sum of the heights, stress of the lowest point.
const COLUMN: [(u32, u32, [f64; 4]); 6] = [
    (2, 4, [2.789_831_317_9e-2, 21.364_206_241_4, 78.734_340_708_1, -33_506.094_911_3]),
    (2, 8, [9.023_004_508_2e-3, 22.631_826_474_7, 156.940_655_675, -36_661.428_623_3]),
    (2, 16, [2.569_811_610_1e-3, 23.315_783_964_8, 313.662_996_508, -38_298.255_908]),
    (3, 4, [3.088_341_528_8e-2, 22.165_190_447_5, 117.935_351_438, -33_482.894_591_6]),
    (3, 8, [9.654_556_588_3e-3, 23.079_173_478_9, 235.330_914_152, -36_644.232_084_2]),
    (3, 16, [2.847_310_235_8e-3, 23.556_101_550_7, 470.449_055_144, -38_295.960_237_2]),
];

#[test]
fn a_column_of_its_own_weight_is_that_of_one_dimension_at_any_radius() {
    for (points, cells, expected) in COLUMN {
        for (from, to, basis) in [(0.0, 10.0, "Cpdi1"), (7.0, 17.0, "Cpdi1"), (0.0, 3.0, "Cpdi2q")] {
            let history = run(&format!(
                r#"Axisymmetric(
                    mesh: Box(axes: [Uniform(from: {from}, to: {to}, cells: 1), Uniform(from: 0, to: 50, cells: {cells})]),
                    basis: {basis}, materials: {{ "m": Hencky(young: 10000, poisson: 0, density: 80) }},
                    bodies: [(name: "c", material: "m", shape: Box(from: ({from}, 0), to: ({to}, 50)), points_per_cell: {points})],
                    supports: [
                        (name: "sides", region: Everywhere, fix: [R]), (name: "base", region: Plane(axis: Z, at: 0), fix: [Z]),
                    ],
                    loads: [BodyForce(acceleration: (0, -10))],
                    schedule: (steps: 40), tolerance: (residual: 1e-12), output: (fields: [CauchyStress]),
                )"#
            ));
            let rest = history.rows()[0].positions.chunks_exact(3).map(|x| x[1]);
            let now: Vec<f64> = history.last().positions.chunks_exact(3).map(|x| x[1]).collect();
            let stress: Vec<f64> = history
                .field(Field::CAUCHY_STRESS, history.rows().len() - 1)
                .chunks_exact(9)
                .map(|it| it[4])
                .collect();
            let count = stress.len() as f64;
            let error: f64 = rest.zip(&stress).map(|(z, stress)| (stress + 800.0 * (50.0 - z)).abs()).sum();
            let found = [
                error / (800.0 * 50.0 * count),
                now.iter().copied().fold(0.0, f64::max),
                now.iter().sum::<f64>() / f64::from(points),
                stress.iter().copied().fold(0.0, f64::min),
            ];
            for (found, expected) in found.iter().zip(expected) {
                let error = found / expected - 1.0;
                assert!(error.abs() < 1e-9, "{basis} from {from}, {points}, {cells}: {found} {expected}");
            }
        }
    }
}

/// A ball of clay pressed between plates, with averages of dilatation, ghost faces and a tool: the same bits on any number of
/// threads.
#[test]
fn threads_change_nothing() {
    let scene = Scene::from_ron(
        r#"Axisymmetric(
            mesh: Box(axes: [Uniform(from: 0, to: 2, cells: 50), Uniform(from: 0, to: 2, cells: 50)]),
            basis: Cpdi1, stabilisation: Ghost(), materials: { "m": VonMises(young: 1e3, poisson: 0.49, yield_radius: 4) },
            bodies: [(name: "b", material: "m", shape: Box(from: (0, 0), to: (1.8, 1.8)), points_per_cell: 2,
                mean_dilatation: Points)],
            supports: [(name: "base", region: Plane(axis: Z, at: 0), fix: [Z])],
            tools: [(name: "plate", parts: [Disc(centre: (0, 2.3), radius: 0.5)], interface: (adhesion: 1),
                motion: Move(by: (0, -0.06)))],
            schedule: (steps: 3), output: (fields: [CauchyStress]),
        )"#,
    )
    .unwrap();
    let bits = |threads: usize| -> Vec<u64> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let history = pool.install(|| scenes::run(&scene)).unwrap().completed().unwrap();
        assert!(last(&history, "tool/plate/force", 1) > 1.0);
        history.reproducible().iter().flat_map(Row::bits).collect()
    };
    let alone = bits(1);
    for threads in [2, 5] {
        assert!(bits(threads) == alone, "{threads} threads");
    }
}

/// A cylinder on rollers, its side across the cells, all but incompressible, pressed to yielding; nothing holds the axis.
fn cylinder(mean: &str) -> History {
    run(&format!(
        r#"Axisymmetric(
            mesh: Box(axes: [Uniform(from: 0, to: 1.4, cells: 7), Uniform(from: 0, to: 1, cells: 4)]),
            motion: Stretch([(axis: Z, anchor: 0, driven: 1, displacement: -0.2)]),
            basis: Cpdi1, stabilisation: Ghost(), materials: {{ "m": VonMises(young: 1000, poisson: 0.4999, yield_radius: 40) }},
            bodies: [(name: "c", material: "m", shape: Box(from: (0, 0), to: (0.9, 1)), points_per_cell: 2{mean})],
            supports: [
                (name: "base", region: Plane(axis: Z, at: 0), fix: [Z]),
                (name: "top", region: Plane(axis: Z, at: 1), follow_mesh: [Z]),
            ],
            schedule: (steps: 4), tolerance: (residual: 1e-12), output: (fields: [CauchyStress]),
        )"#
    ))
}

/// MOOSE 10866, 12437, 12489 (averages of dilatation divided by the radius at r = 0), SU2 1373 (odd values beside the axis),
/// Kratos 14403 (a body whose axis was not held moved most beside it).
#[test]
fn averages_of_dilatation_are_exact_up_to_an_axis_that_no_support_holds() {
    for mean in ["", ", mean_dilatation: Points"] {
        let history = cylinder(mean);
        let stress = history.field(Field::CAUCHY_STRESS, history.rows().len() - 1);
        let pressed = stress[4];
        assert!(pressed < -40.0, "{pressed}");
        for (point, it) in stress.chunks_exact(9).enumerate() {
            assert!((it[4] / pressed - 1.0).abs() < 1e-9, "{mean}: point {point}: {}, {pressed}", it[4]);
            assert!(it[0].abs().max(it[8].abs()) < 1e-9 * pressed.abs(), "{mean}: point {point}: {it:?}");
        }
        let stretch = |(now, rest): (&[f64], &[f64])| now[0] / rest[0];
        let rest = &history.rows()[0].positions;
        let stretches: Vec<f64> =
            history.last().positions.chunks_exact(3).zip(rest.chunks_exact(3)).map(stretch).collect();
        for it in &stretches {
            assert!((it / stretches[0] - 1.0).abs() < 1e-9, "{mean}: {it} {}", stretches[0]);
        }
    }
}

/// felupe 326: averages that forgot the radius in the volume did not converge.
#[test]
fn newton_converges_with_averages_of_dilatation() {
    for mean in ["", ", mean_dilatation: Points", ", mean_dilatation: Cell"] {
        let history = run(&format!(
            r#"Axisymmetric(
                mesh: Box(axes: [Uniform(from: 0, to: 2, cells: 4), Uniform(from: 0, to: 2, cells: 4)]),
                basis: Cpdi1, materials: {{ "m": VonMises(young: 1000, poisson: 0.49, yield_radius: 5) }},
                bodies: [(name: "b", material: "m", shape: Box(from: (0, 0), to: (2, 2)), points_per_cell: 2{mean})],
                supports: [
                    (name: "base", region: Plane(axis: Z, at: 0), fix: [R, Z]),
                    (name: "top", region: Plane(axis: Z, at: 2), fix: [R], displace: [(axis: Z, by: -0.1)]),
                ],
                schedule: (steps: 5), tolerance: (residual: 1e-12), output: (fields: [Plastic]),
            )"#
        ));
        // From rest to the load's end every step is solved in a few corrections, with the points yielding.
        let most = history.rows().iter().map(|row| row.residuals.len()).max();
        assert!(most.is_some_and(|most| (3..=8).contains(&most)), "{mean}: {most:?}");
        assert_eq!(history.rows().len(), 6, "{mean}: steps were cut");
        let plastic: f64 = history.field(Field::PLASTIC, 5).iter().sum();
        assert!(plastic > 32.0, "{mean}: {plastic} points yield");
    }
}

/// nairn-mpm-fea (areas of contact nil at r = 0), and everything that is a length made of a volume: a plate enters a body by
/// the same part of a point's size, p/(s E), at the axis and far from it.
#[test]
fn a_plate_enters_a_body_alike_at_any_radius() {
    let deepest = |from: f64| {
        let history = run(&format!(
            r#"Axisymmetric(
                mesh: Box(axes: [Uniform(from: {from}, to: {}, cells: 4), Uniform(from: 0, to: 1.2, cells: 6)]),
                basis: Cpdi1, stabilisation: Ghost(), materials: {{ "m": Hencky(young: 1000, poisson: 0) }},
                bodies: [(name: "b", material: "m", shape: Box(from: ({from}, 0), to: ({}, 1)), points_per_cell: 2)],
                supports: [(name: "base", region: Everywhere, fix: [R]), (name: "floor", region: Plane(axis: Z, at: 0), fix: [Z])],
                tools: [(name: "plate", parts: [Plane(through: (0, 1), normal: (0, -1))], motion: Move(by: (0, -0.1)))],
                schedule: (steps: 2), output: (fields: []),
            )"#,
            from + 0.8,
            from + 0.8,
        ));
        last(&history, "tool/plate/deepest", 0)
    };
    let (near, far) = (deepest(0.0), deepest(100.0));
    // Compressed by about a tenth: ln(0.9)/0.9 of E, over s = 20.
    let expected = -(0.9_f64.ln()) / 20.0;
    assert!((near / far - 1.0).abs() < 1e-6 && (near / expected - 1.0).abs() < 0.2, "{near} {far} {expected}");
}

/// Ground under a surcharge that its initial stress balances, loaded further in a stage and released in the next: uniform
/// compression between a side and a base that are held, in logarithmic strains.
#[test]
fn stages_begin_from_an_initial_stress() {
    const YOUNG: f64 = 1e4;
    // ν = 0.25.
    let (lame, shear) = (0.4 * YOUNG, 0.4 * YOUNG);
    for basis in ["Gimp", "Cpdi1", "Cpdi2q", "Cpdi2t"] {
        let history = run(&format!(
            r#"Axisymmetric(
                mesh: Box(axes: [Uniform(from: 0, to: 2, cells: 4), Uniform(from: 0, to: 1.5, cells: 6)]),
                basis: {basis}, stabilisation: Ghost(), materials: {{ "m": Hencky(young: {YOUNG}, poisson: 0.25) }},
                bodies: [(name: "b", material: "m", shape: Box(from: (0, 0), to: (2, 1)), points_per_cell: 2,
                    initial: Stress(xx: -50, yy: -100, zz: -50))],
                supports: [
                    (name: "base", region: Plane(axis: Z, at: 0), fix: [Z]), (name: "side", region: Plane(axis: R, at: 2), fix: [R]),
                ],
                loads: [
                    Traction(body: "b", axis: Z, at: 1, value: (0, -100), ramp: [(0, 1)]),
                    Traction(body: "b", axis: Z, at: 1, value: (0, -500), active: (from: "load", until: "release")),
                ],
                schedule: (stages: [(name: "rest", steps: 1), (name: "load", steps: 2), (name: "release", steps: 2)]),
                tolerance: (residual: 1e-12), output: (fields: [CauchyStress]),
            )"#
        ));
        // (-100 + (λ + 2 μ) ln s)/s = -600 by Newton's method.
        let stretch = (0..20).fold(1.0_f64, |s, _| {
            let excess = -100.0 + (lame + 2.0 * shear) * s.ln() + 600.0 * s;
            s - excess / ((lame + 2.0 * shear) / s + 600.0)
        });
        let radial = (-50.0 + lame * stretch.ln()) / stretch;
        for (row, [rr, zz]) in [(1, [-50.0, -100.0]), (3, [radial, -600.0]), (5, [-50.0, -100.0])] {
            for stress in history.field(Field::CAUCHY_STRESS, row).chunks_exact(9) {
                for (found, expected) in [(stress[0], rr), (stress[4], zz), (stress[8], rr)] {
                    assert!((found / expected - 1.0).abs() < 1e-10, "{basis}, row {row}: {found} {expected}");
                }
            }
        }
    }
}

/// A shaft is pulled through ground that presses on it: Coulomb's friction of the pressure on its area.
#[test]
fn friction_on_a_shaft_is_that_of_the_pressure() {
    let history = run(r#"Axisymmetric(
            mesh: Box(axes: [Nodes([0, 0.25, 0.5, 0.6, 0.7, 0.85, 1.1, 1.5, 2]), Uniform(from: 0, to: 1, cells: 8)]),
            basis: Cpdi1, materials: { "m": Hencky(young: 10000, poisson: 0.3) },
            bodies: [(name: "b", material: "m", shape: Box(from: (0.5, 0), to: (2, 1)), points_per_cell: 2,
                initial: Stress(xx: -10, yy: -10, zz: -10))],
            supports: [
                (name: "ends", region: Everywhere, fix: [Z]), (name: "side", region: Plane(axis: R, at: 2), fix: [R]),
            ],
            tools: [(name: "shaft", parts: [Cylinder(radius: 0.5, extent: (-1, 2))], motion: Move(by: (0, 0.05)),
                interface: (friction: 0.3, stiffness: 1000))],
            schedule: (steps: 4), output: (fields: []),
        )"#);
    let force = last(&history, "tool/shaft/force", 1);
    // μ p 2π R L.
    assert!((force / (0.3 * 10.0 * PI) + 1.0).abs() < 1e-3, "{force}");
}
