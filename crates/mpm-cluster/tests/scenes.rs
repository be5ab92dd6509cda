//! Scenes that ship, shared by several ranks.

mod setup;

use setup::{alone, assert_same, repository_scene, shared};

/// Runs the scenes on one rank and on so many; tells all that differ.
fn check(scenes: &[(&str, &[(&str, &str)])], ranks: &[usize]) {
    for (path, changes) in scenes {
        let text = repository_scene(path, changes);
        let (one, summary) = alone(&text, &[]);
        let summary = summary.unwrap_or_else(|it| panic!("{path}: {it}"));
        for &size in ranks {
            let all = shared(&text, size, &[]);
            let several = all[0].1.as_ref().unwrap_or_else(|it| panic!("{path} on {size} ranks: {it}"));
            assert_same(path, (&one, &all[0].0), &format!("{size} ranks"));
            assert_eq!(several.iterations, summary.iterations, "{path} on {size} ranks");
            assert_eq!((several.cuts, several.points), (summary.cuts, summary.points), "{path}");
        }
    }
}

#[test]
fn driven_bodies_in_fixed_meshes() {
    check(
        &[
            ("scenes/simple_stretch.ron", &[("steps: 40", "steps: 8")]),
            ("scenes/simple_stretch_rollers.ron", &[("steps: 40", "steps: 8")]),
            ("validation/scenes/pulled_block.ron", &[]),
        ],
        &[2, 3],
    );
}

#[test]
fn loads_and_columns() {
    check(
        &[
            ("scenes/cantilever.ron", &[("steps: 50", "steps: 6")]),
            ("scenes/column.ron", &[("steps: 40", "steps: 8")]),
            ("scenes/column_solid.ron", &[("steps: 40", "steps: 8")]),
            ("scenes/collapse.ron", &[("steps: 40", "steps: 10")]),
        ],
        &[2, 4],
    );
}

#[test]
fn meshes_that_move_and_rings_that_are_cut_along() {
    check(
        &[
            ("scenes/doughnut_elastic.ron", &[("steps: 20", "steps: 6")]),
            ("scenes/doughnut.ron", &[("steps: 90", "steps: 20")]),
            ("scenes/doughnut_carried.ron", &[("steps: 100", "steps: 10")]),
            ("validation/scenes/carried_block.ron", &[("steps: 100", "steps: 40")]),
        ],
        &[2, 3, 4],
    );
}

#[test]
fn splines() {
    check(
        &[
            ("validation/scenes/patch_splines.ron", &[]),
            ("validation/scenes/ring_splines.ron", &[("steps: 20", "steps: 6")]),
            ("scenes/column_splines.ron", &[("steps: 40", "steps: 8")]),
        ],
        &[2, 3],
    );
}

#[test]
fn bodies_of_revolution() {
    check(
        &[
            ("scenes/tube_twist.ron", &[("steps: 20", "steps: 5")]),
            ("scenes/cylinder.ron", &[("steps: 40", "steps: 6")]),
        ],
        &[2, 3],
    );
}

#[test]
fn along_a_path() {
    check(&[("scenes/path_arch.ron", &[])], &[2, 3]);
}

#[test]
fn volume_changes_of_cells_and_domains_that_are_shortened() {
    check(
        &[
            ("scenes/circular_footing.ron", &[("steps: 20", "steps: 4")]),
            ("scenes/footing.ron", &[("steps: 40", "steps: 8")]),
            ("scenes/footing_stages.ron", &[]),
            ("scenes/doughnut_limit.ron", &[("steps: 180", "steps: 20"), ("inner: 180", "inner: 20")]),
            (
                "scenes/doughnut_limit.ron",
                &[("steps: 180", "steps: 20"), ("inner: 180", "inner: 20"), ("Reshape(cells: 0.7)", "Split()")],
            ),
        ],
        &[2, 3],
    );
}

#[test]
fn ghost_faces() {
    check(
        &[
            ("scenes/collapse_solid.ron", &[("steps: 40", "steps: 4")]),
            ("scenes/slope.ron", &[("steps: 20", "steps: 4")]),
        ],
        &[2, 3, 7],
    );
}
