//! Every case of the validation but the long one, see `determinism.rs`; and the pages tell of each.

use mpm_validation::{CASES, Case, Check, Extent, case, pages};
use std::path::Path;

fn page(case: &Case) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("cases").join(pages::file_name(case));
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn passes(name: &str) {
    let case = case(name).unwrap_or_else(|| panic!("there is no case `{name}`"));
    let checks = (case.run)(Extent::Tests).unwrap_or_else(|broken| panic!("{name}: {broken}")).checks;
    assert!(!checks.is_empty(), "{name} compares nothing");
    let failed: Vec<&Check> = checks.iter().filter(|check| !check.passes()).collect();
    assert!(failed.is_empty(), "{name}: {failed:#?}");
    let page = page(case);
    for check in &checks {
        let row = format!("| {} | ", check.what);
        let tolerance = format!(" | {:.0e} |", check.tolerance);
        let told = page.lines().any(|line| line.starts_with(&row) && line.contains(&tolerance));
        assert!(told, "the page of {name} has no row `{row}…{tolerance}`");
    }
}

/// A test for each case: its name, and that of the case.
macro_rules! tests {
    ($($test:ident($case:literal))*) => {
        $(#[test]
        fn $test() {
            passes($case);
        })*
    };
}

tests! {
    simple_stretch_with_free_sides("simple stretch, sides free")
    simple_stretch_on_rollers("simple stretch, rollers")
    corner_stretch_on_the_kite("corner stretch, kite")
    corner_stretch_on_squares("corner stretch, rectilinear")
    cylinder_that_is_twisted("cylinder that is twisted")
    pile_turned_and_pulled("pile turned and pulled")
    thick_walls_of_revolution("thick walls of revolution")
    cavities_of_revolution("cavities of revolution")
    flat_elastic_punch("flat elastic punch")
    pile_pushed_and_pulled("pile pushed and pulled")
    cone_in_clay("cone in clay")
    circular_footing("circular footing")
    elastic_doughnut("doughnut twist, elastic")
    doughnut_of_rubber("doughnut twist, rubber")
    elastic_doughnut_refined("doughnut twist, error by cause")
    slides_doughnut("doughnut twist, the slides'")
    doughnut_turned_around("doughnut twist, full turns")
    doughnut_at_the_limit_torque("doughnut twist, limit torque")
    carried_around("carried around")
    doughnut_in_space("doughnut twist in space")
    remedies("remedies for distorted domains")
    health_of_domains("health of domains")
    inversion("a domain that inverts")
    column("self-weight column")
    column_in_space("self-weight column in space")
    cantilever("cantilever")
    collapse("collapse")
    cantilever_in_space("cantilever in space")
    collapse_in_space("collapse in space")
    round_bodies_and_points_of_a_table("cylinder, tube, points from a table")
    bar_of_a_surface("bar of STL shape")
    newton_rate("Newton's rate")
    tangent("tangent")
    rigid_rotation("rigid rotation")
    patch_test("patch test")
    a_load_step_that_cannot_be_solved("a load step that cannot be solved")
    step_control("step control")
    domain_control("domains under large shear")
    rigid_footing("rigid footing")
    ground_at_rest("ground at rest")
    circular_footing_in_space("circular footing in space")
    columns_of_soil("columns of soil")
    cavity_in_a_ring("cavity in a ring")
    cavity_in_unbounded_clay("cavity in unbounded clay")
    strip_footing_on_clay("strip footing on clay")
    strip_footing_on_sand("strip footing on sand")
    strip_footing_on_heavy_sand("strip footing on heavy sand")
    smooth_wall("smooth wall")
    vertical_cut("vertical cut")
    infinite_slope("infinite slope")
    blocks_under_rigid_plates("blocks under rigid plates")
    circle_on_a_block("circle on a block")
    cylinder_on_a_block("cylinder on a block")
    iterations_with_tools("iterations with tools")
    sliding_blocks("sliding blocks")
    cylinder_in_clay("cylinder in clay")
    ploughs("ploughs")
    sphere_on_a_block("sphere on a block")
    ball_t_bar_and_turned_cylinder_in_space("ball, T-bar and turned cylinder in space")
    cylinder_pile_and_vane_in_clay("cylinder, pile and vane in clay")
    vane_in_space("vane in space")
    screws_and_full_turns("screws and full turns")
    footing_and_blade("footing and blade")
    generalised_vortex("generalised vortex")
    generalised_vortex_of_rubber("generalised vortex, rubber")
    snap_through("snap-through of an arch")
    snap_back("snap-back of the doughnut")
    inputs_easily_answered_wrongly("inputs that are easily answered wrongly")
    column_on_splines("self-weight column on splines")
    ring_of_splines("ring of splines")
    patch_test_on_splines("patch test on splines")
    vortex_on_splines("generalised vortex on splines")
    regularised_doughnut("doughnut twist, regularised")
    regularised_ring_that_softens("ring that softens, regularised")
    regularised_strip_that_softens("strip that softens, regularised")
    inclined_column("inclined column")
    pressurised_cylinder("pressurised cylinder")
    plate_with_a_hole("plate with a hole")
    boundaries_in_space("boundaries in space")
    rolled_cantilever("rolled cantilever")
    cone_in_sand("cone in sand")
    screw_pile_in_sand("screw pile in sand")
}

#[test]
fn screw_pile() {
    passes("screw pile");
    passes("screw pile installed and pulled");
}

#[test]
fn every_case_has_a_test() {
    let tests = [include_str!("cases.rs"), include_str!("determinism.rs")];
    for case in CASES {
        let call = format!("(\"{}\")", case.name);
        assert!(tests.iter().any(|text| text.contains(&call)), "no test runs `{}`", case.name);
    }
}

#[test]
fn the_pages_tell_of_every_case() {
    for case in CASES {
        let page = page(case);
        for text in [&format!("# {}\n", case.name), case.goal, case.setup, case.reference] {
            assert!(page.contains(text), "the page of `{}` lacks: {text}", case.name);
        }
    }
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let table = pages::overview(CASES, folder).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(include_str!("../README.md"), table, "write it by `mpm-validation --pages validation`");
    let files = std::fs::read_dir(folder.join("cases")).expect("the folder is there").count();
    assert_eq!(files, CASES.len(), "a page is left of a case that is no more");
}
