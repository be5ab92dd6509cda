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

#[test]
fn simple_stretch_with_free_sides() {
    passes("simple stretch, sides free");
}

#[test]
fn simple_stretch_on_rollers() {
    passes("simple stretch, rollers");
}

#[test]
fn corner_stretch_on_the_kite() {
    passes("corner stretch, kite");
}

#[test]
fn corner_stretch_on_squares() {
    passes("corner stretch, rectilinear");
}

#[test]
fn cylinder_that_is_twisted() {
    passes("cylinder that is twisted");
}

#[test]
fn pile_turned_and_pulled() {
    passes("pile turned and pulled");
}

#[test]
fn thick_walls_of_revolution() {
    passes("thick walls of revolution");
}

#[test]
fn cavities_of_revolution() {
    passes("cavities of revolution");
}

#[test]
fn flat_elastic_punch() {
    passes("flat elastic punch");
}

#[test]
fn pile_pushed_and_pulled() {
    passes("pile pushed and pulled");
}

#[test]
fn cone_in_clay() {
    passes("cone in clay");
}

#[test]
fn circular_footing() {
    passes("circular footing");
}

#[test]
fn elastic_doughnut() {
    passes("doughnut twist, elastic");
}

#[test]
fn doughnut_of_rubber() {
    passes("doughnut twist, rubber");
}

#[test]
fn elastic_doughnut_refined() {
    passes("doughnut twist, error by cause");
}

#[test]
fn slides_doughnut() {
    passes("doughnut twist, the slides'");
}

#[test]
fn doughnut_turned_around() {
    passes("doughnut twist, full turns");
}

#[test]
fn doughnut_at_the_limit_torque() {
    passes("doughnut twist, limit torque");
}

#[test]
fn carried_around() {
    passes("carried around");
}

#[test]
fn doughnut_in_space() {
    passes("doughnut twist in space");
}

#[test]
fn remedies() {
    passes("remedies for distorted domains");
}

#[test]
fn health_of_domains() {
    passes("health of domains");
}

#[test]
fn inversion() {
    passes("a domain that inverts");
}

#[test]
fn column() {
    passes("self-weight column");
}

#[test]
fn column_in_space() {
    passes("self-weight column in space");
}

#[test]
fn cantilever() {
    passes("cantilever");
}

#[test]
fn collapse() {
    passes("collapse");
}

#[test]
fn cantilever_in_space() {
    passes("cantilever in space");
}

#[test]
fn collapse_in_space() {
    passes("collapse in space");
}

#[test]
fn round_bodies_and_points_of_a_table() {
    passes("cylinder, tube, points from a table");
}

#[test]
fn bar_of_a_surface() {
    passes("bar of STL shape");
}

#[test]
fn newton_rate() {
    passes("Newton's rate");
}

#[test]
fn tangent() {
    passes("tangent");
}

#[test]
fn rigid_rotation() {
    passes("rigid rotation");
}

#[test]
fn patch_test() {
    passes("patch test");
}

#[test]
fn a_load_step_that_cannot_be_solved() {
    passes("a load step that cannot be solved");
}

#[test]
fn step_control() {
    passes("step control");
}

#[test]
fn domain_control() {
    passes("domains under large shear");
}

#[test]
fn rigid_footing() {
    passes("rigid footing");
}

#[test]
fn ground_at_rest() {
    passes("ground at rest");
}

#[test]
fn circular_footing_in_space() {
    passes("circular footing in space");
}

#[test]
fn columns_of_soil() {
    passes("columns of soil");
}

#[test]
fn cavity_in_a_ring() {
    passes("cavity in a ring");
}

#[test]
fn cavity_in_unbounded_clay() {
    passes("cavity in unbounded clay");
}

#[test]
fn strip_footing_on_clay() {
    passes("strip footing on clay");
}

#[test]
fn strip_footing_on_sand() {
    passes("strip footing on sand");
}

#[test]
fn strip_footing_on_heavy_sand() {
    passes("strip footing on heavy sand");
}

#[test]
fn smooth_wall() {
    passes("smooth wall");
}

#[test]
fn vertical_cut() {
    passes("vertical cut");
}

#[test]
fn infinite_slope() {
    passes("infinite slope");
}

#[test]
fn blocks_under_rigid_plates() {
    passes("blocks under rigid plates");
}

#[test]
fn circle_on_a_block() {
    passes("circle on a block");
}

#[test]
fn cylinder_on_a_block() {
    passes("cylinder on a block");
}

#[test]
fn iterations_with_tools() {
    passes("iterations with tools");
}

#[test]
fn sliding_blocks() {
    passes("sliding blocks");
}

#[test]
fn cylinder_in_clay() {
    passes("cylinder in clay");
}

#[test]
fn ploughs() {
    passes("ploughs");
}

#[test]
fn screw_pile() {
    passes("screw pile");
    passes("screw pile installed and pulled");
}

#[test]
fn sphere_on_a_block() {
    passes("sphere on a block");
}

#[test]
fn ball_t_bar_and_turned_cylinder_in_space() {
    passes("ball, T-bar and turned cylinder in space");
}

#[test]
fn cylinder_pile_and_vane_in_clay() {
    passes("cylinder, pile and vane in clay");
}

#[test]
fn screws_and_full_turns() {
    passes("screws and full turns");
}

#[test]
fn footing_and_blade() {
    passes("footing and blade");
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

#[test]
fn generalised_vortex() {
    passes("generalised vortex");
}

#[test]
fn generalised_vortex_of_rubber() {
    passes("generalised vortex, rubber");
}

#[test]
fn snap_through() {
    passes("snap-through of an arch");
}

#[test]
fn snap_back() {
    passes("snap-back of the doughnut");
}

#[test]
fn inputs_easily_answered_wrongly() {
    passes("inputs that are easily answered wrongly");
}

#[test]
fn column_on_splines() {
    passes("self-weight column on splines");
}

#[test]
fn ring_of_splines() {
    passes("ring of splines");
}

#[test]
fn patch_test_on_splines() {
    passes("patch test on splines");
}

#[test]
fn vortex_on_splines() {
    passes("generalised vortex on splines");
}

#[test]
fn regularised_doughnut() {
    passes("doughnut twist, regularised");
}

#[test]
fn regularised_ring_that_softens() {
    passes("ring that softens, regularised");
}

#[test]
fn regularised_strip_that_softens() {
    passes("strip that softens, regularised");
}

#[test]
fn inclined_column() {
    passes("inclined column");
}

#[test]
fn pressurised_cylinder() {
    passes("pressurised cylinder");
}

#[test]
fn plate_with_a_hole() {
    passes("plate with a hole");
}

#[test]
fn boundaries_in_space() {
    passes("boundaries in space");
}

#[test]
fn rolled_cantilever() {
    passes("rolled cantilever");
}
