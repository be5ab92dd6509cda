//! What a scene will take, counted by hand.

use mpm_scene::{Scene, compile};

/// A body of 2 × 1 cells in a mesh of 4 × 3, held at its left side and pulled at its right.
const SCENE: &str = r#"PlaneStrain(
    mesh: Box(axes: [Uniform(from: 0, to: 4, cells: 4), Uniform(from: 0, to: 3, cells: 3)]),
    basis: Smpm,
    materials: { "a": Hencky(young: 1, poisson: 0) },
    bodies: [(name: "b", material: "a", shape: Box(from: (0, 0), to: (2, 1)), points_per_cell: 2)],
    supports: [
        (name: "left", region: Plane(axis: X, at: 0), fix: [X, Y]),
        (name: "right", region: Plane(axis: X, at: 2), displace: [(axis: X, by: 1)]),
    ],
    schedule: (steps: 3),
)"#;

#[test]
fn a_small_scene_is_counted_by_hand() {
    let scene = Scene::from_ron(SCENE).unwrap();
    let estimate = compile(&scene).unwrap().estimate().unwrap();
    assert_eq!((estimate.points, estimate.cells, estimate.cells_with_material), (8, 12, 2));
    assert_eq!((estimate.nodes, estimate.active_nodes), (20, 6));
    // Three components are prescribed on 2 nodes each.
    assert_eq!((estimate.equations, estimate.prescribed), (6, 6));
    // Pairs of nodes that share a cell: 6 per cell, 1 on the common side; blocks of 4 and of 3.
    assert_eq!(estimate.tangent_entries, 11 * 4 + 6 * 3);
    assert!(estimate.factor_entries >= estimate.tangent_entries);
    // Position, position at rest, F (2 × 2), elastic state (6) and volume, twice.
    assert_eq!(estimate.memory.points, 2 * 8 * 8 * (2 + 2 + 4 + 6 + 1));
    assert_eq!(estimate.columns_not_stored, ["mass", "domain", "history of the law", "plastic state"]);
    assert_eq!(estimate.steps, 3);
}

/// What only a stage after the first leaves unheld is named, and where that is.
#[test]
fn what_later_stages_leave_unheld_is_said_before() {
    let stages = "schedule: (stages: [(name: \"one\", steps: 3), (name: \"two\", steps: 3)])";
    let text = |until: &str| {
        SCENE
            .replace("fix: [X, Y])", &format!("fix: [X, Y]{until})"))
            .replace("displace: [(axis: X, by: 1)]", "fix: [Y]")
            .replace("schedule: (steps: 3)", stages)
    };
    let warnings = |text: &str| compile(&Scene::from_ron(text).unwrap()).unwrap().estimate().unwrap().warnings;
    let said = warnings(&text(", active: (until: \"two\")")).join("; ");
    assert!(said.contains("in stage `two` nothing holds body `b` along x"), "{said}");
    let said = warnings(&text("")).join("; ");
    assert!(!said.contains("nothing holds"), "{said}");
}
