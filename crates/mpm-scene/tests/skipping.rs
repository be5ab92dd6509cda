//! What a scene does not need is not done: counted, and compared with a scene that needs it.

use mpm_scene::Scene;
use mpm_scene::compile;
use mpm_solver::Summary;

fn scene(basis: &str, law: &str, motion: &str, mesh: u32) -> Scene {
    let text = format!(
        r#"PlaneStrain(
            mesh: Box(axes: [
                Uniform(from: 0, to: {mesh}, cells: {mesh}),
                Uniform(from: 0, to: {mesh}, cells: {mesh}),
            ]),
            {motion}
            basis: {basis},
            materials: {{ "a": {law} }},
            bodies: [(name: "b", material: "a", shape: Box(from: (0, 0), to: (4, 2)), points_per_cell: 2)],
            supports: [
                (name: "left", region: Plane(axis: X, at: 0), fix: [X, Y]),
                (name: "right", region: Plane(axis: X, at: 4), displace: [(axis: X, by: 0.2)]),
            ],
            schedule: (steps: 4),
            output: (fields: []),
        )"#
    );
    Scene::from_ron(&text).unwrap()
}

fn run(basis: &str, law: &str, motion: &str, mesh: u32) -> Summary {
    compile(&scene(basis, law, motion, mesh)).unwrap().run(&mut ()).unwrap()
}

fn skipped(summary: &Summary, name: &str) -> u64 {
    let name = format!("skipped: {name}");
    summary.skipped.iter().find(|it| it.0 == name).unwrap_or_else(|| panic!("{name} is counted")).1
}

/// Times a phase was entered.
fn entered(summary: &Summary, phase: &str) -> u64 {
    summary.timings.iter().find(|it| it.phase == phase).unwrap().count
}

const ELASTIC: &str = "Hencky(young: 1e3, poisson: 0.3)";
const PLASTIC: &str = "VonMises(young: 1e3, poisson: 0.3, yield_radius: 20)";
const MOVING: &str = "motion: Stretch([(axis: X, anchor: 0, driven: 4, displacement: 0.2)]),";

#[test]
fn elastic_points_are_never_checked_for_yield() {
    let (elastic, plastic) = (run("Smpm", ELASTIC, "", 6), run("Smpm", PLASTIC, "", 6));
    let passes = entered(&elastic, "stress") + entered(&elastic, "assemble");
    assert_eq!(skipped(&elastic, "yield checks"), 32 * passes);
    assert_eq!(skipped(&plastic, "yield checks"), 0);
    // History and plastic state.
    assert_eq!(skipped(&elastic, "columns of points"), skipped(&plastic, "columns of points") + 2);
    for summary in [&elastic, &plastic] {
        let passes = entered(summary, "stress") + entered(summary, "assemble");
        assert_eq!(skipped(summary, "out-of-plane spectra"), 32 * passes);
    }
}

#[test]
fn only_bases_with_domains_carry_them() {
    let (without, with) = (run("Smpm", ELASTIC, "", 6), run("Cpdi1", ELASTIC, "", 6));
    assert_eq!(skipped(&without, "domains"), 32 * 4);
    assert_eq!(skipped(&with, "domains"), 0);
    assert_eq!(skipped(&without, "columns of points"), skipped(&with, "columns of points") + 1);
}

#[test]
fn what_moves_with_its_mesh_is_connected_once() {
    let (fixed, moving) = (run("Smpm", ELASTIC, "", 6), run("Smpm", ELASTIC, MOVING, 6));
    assert_eq!((skipped(&fixed, "mesh moves"), skipped(&moving, "mesh moves")), (4, 0));
    // Homogeneous stretch in a mesh that stretches alike: no point leaves its cell.
    assert_eq!((skipped(&moving, "patterns"), skipped(&moving, "orders and analyses")), (3, 3));
}

#[test]
fn empty_cells_and_nodes_are_only_counted() {
    let (narrow, wide) = (run("Smpm", ELASTIC, "", 6), run("Smpm", ELASTIC, "", 60));
    assert_eq!((skipped(&narrow, "grid cells"), skipped(&wide, "grid cells")), (36 - 8, 3600 - 8));
    assert_eq!((skipped(&narrow, "grid nodes"), skipped(&wide, "grid nodes")), (49 - 15, 3721 - 15));
    assert_eq!(narrow.iterations, wide.iterations);
    assert_eq!(skipped(&narrow, "upper triangle"), skipped(&wide, "upper triangle"));

    // Memory follows the material.
    let memory = |mesh| compile(&scene("Cpdi1", PLASTIC, "", mesh)).unwrap().estimate().unwrap().memory.total();
    assert_eq!(memory(6), memory(60));
}
