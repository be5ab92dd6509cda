//! Elasticity on boxes, random matrices, and matrices that must fail.

mod problem;
mod threads;
mod unsymmetric;

use super::symbolic;
use super::*;
use crate::prediction::predict;
use crate::report::{Analysis, Cause, Factored, Method, Pivot, Singular};
use crate::solver::LinearSolver;
use problem::{Problem, elasticity, random};
use std::collections::BTreeMap;

/// Number of negative eigenvalues that a factorisation has found.
fn negative(factored: &Factored) -> Option<usize> {
    factored.inertia.map(|inertia| inertia.negative)
}

fn check_spd(problem: &Problem) {
    let mut factorization = problem.analysed();
    let (report, solved, r) = problem.solve(&mut factorization, Method::Llt);
    assert_eq!((report.method, solved.method), (Method::Llt, Method::Llt));
    assert_eq!((report.not_positive, negative(&report)), (None, Some(0)));
    assert!(report.weakest.unwrap().relative > 1e-3);
    assert!(solved.backward_error.unwrap() < 1e-12 && r < 1e-12, "{solved:?} {r}");
    for start in [Method::Lblt, Method::Lu] {
        let (report, solved, r) = problem.solve(&mut factorization, start);
        assert_eq!((report.method, solved.method), (start, start));
        assert!(solved.backward_error.unwrap() < 1e-12 && r < 1e-12, "{start:?} {solved:?} {r}");
    }
}

#[test]
fn plane_strain_elasticity() {
    check_spd(&elasticity([23, 17], false));
}

#[test]
fn hexahedral_elasticity() {
    check_spd(&elasticity([7, 6, 5], false));
}

#[test]
fn a_ring_of_cells() {
    check_spd(&elasticity([40, 6], true));
    check_spd(&elasticity([12, 4, 5], true));
}

#[test]
fn random_positive_definite_with_thick_coupling() {
    for (n, reach, components) in [([14, 11, 1], 2, 2), ([6, 5, 4], 2, 3), ([9, 9, 1], 3, 1)] {
        check_spd(&random(n, reach, components, |_, sum| 1.1 * sum + 0.1));
    }
}

#[test]
fn no_equations_and_one_equation() {
    let empty = Problem::new(Vec::new(), 2, &BTreeMap::new());
    let mut factorization = empty.analysed();
    assert_eq!(factorization.factorise_from(empty.matrix(), Method::Llt).unwrap().weakest, None);
    assert_eq!(factorization.solve(empty.matrix(), &mut [], 0.0).unwrap().backward_error, Some(0.0));
    assert_eq!(factorization.factorise_from(empty.matrix(), Method::Lblt).unwrap().method, Method::Lblt);

    for (k, method) in [(4.0, Method::Llt), (-4.0, Method::Lblt)] {
        let one = Problem::new(vec![[3, 0, 0]], 1, &BTreeMap::from([((0, 0), k)]));
        let mut factorization = one.analysed();
        let report = factorization.factorise_from(one.matrix(), Method::Llt).unwrap();
        let weakest = Pivot { equation: 0, value: k, relative: 1.0 };
        assert_eq!((report.method, report.weakest, report.pivot_ratio), (method, Some(weakest), Some(1.0)));
        let mut x = [2.0];
        factorization.solve(one.matrix(), &mut x, 0.0).unwrap();
        assert_eq!(x, [2.0 / k]);
    }
}

#[test]
fn indefinite_matrices_go_to_lblt_with_the_right_inertia() {
    // Diagonally dominant with signs: the inertia is that of the diagonal (Gershgorin).
    let sign = |e: usize| if e % 5 == 2 { -1.0 } else { 1.0 };
    for (n, reach, components) in [([12, 9, 1], 1, 2), ([6, 5, 4], 2, 3)] {
        let problem = random(n, reach, components, |e, sum| sign(e) * (1.1 * sum + 0.1));
        let mut factorization = problem.analysed();
        let (report, solved, r) = problem.solve(&mut factorization, Method::Llt);
        assert_eq!((report.method, solved.method), (Method::Lblt, Method::Lblt));
        let expected = (0..problem.n()).filter(|&e| sign(e) < 0.0).count();
        assert_eq!(negative(&report), Some(expected));
        let stop = report.not_positive.unwrap();
        assert!(sign(stop.equation) < 0.0 && stop.value < 0.0, "{stop:?}");
        assert!(solved.backward_error.unwrap() < 1e-12 && r < 1e-12, "{solved:?} {r}");

        // With the hint the failing LLᵀ is saved; the factor is the same.
        let (hinted, again, _) = problem.solve(&mut factorization, Method::Lblt);
        assert_eq!(hinted, Factored { not_positive: None, ..report });
        assert_eq!(again, solved);
    }
}

#[test]
fn after_an_indefinite_matrix_llt_is_tried_again_only_after_a_restart() {
    let spd = elasticity([6, 5], false);
    let mut indefinite = spd.values.clone();
    indefinite[spd.column_start[20]] *= -1.0;
    let mut factorization = spd.analysed();
    let mut method = |values: &[f64], restarts: bool| {
        if restarts {
            factorization.restart();
        }
        let factored = factorization.factorise(spd.with(values)).unwrap();
        (factored.method, factored.not_positive.is_some(), factored.shows_instability())
    };
    assert_eq!(method(&spd.values, false), (Method::Llt, false, false));
    assert_eq!(method(&indefinite, false), (Method::Lblt, true, true));
    assert_eq!(method(&indefinite, false), (Method::Lblt, false, true));
    assert_eq!(method(&spd.values, false), (Method::Lblt, false, false));
    assert_eq!(method(&spd.values, true), (Method::Llt, false, false));
    assert_eq!(method(&indefinite, true), (Method::Lblt, true, true));
}

#[test]
fn general_indefinite_matrices_are_solved() {
    // No dominance at all: pivots inside supernodes are weak, refinement or LU must repair it.
    for reach in [1, 2] {
        let problem = random([9, 8, 1], reach, 2, |e, _| if e % 2 == 0 { 0.0 } else { 0.3 });
        let mut factorization = problem.analysed();
        let (report, solved, r) = problem.solve(&mut factorization, Method::Llt);
        assert!(report.not_positive.is_some() && report.method != Method::Llt);
        assert!(solved.backward_error.unwrap() < 1e-12 && r < 1e-9, "{solved:?} {r}");
    }
}

#[test]
fn what_supernodes_cannot_pivot_goes_to_lu() {
    // No diagonal at all, so a supernode of one column has no pivot; with a diagonal of 1e-14 it
    // has one, but the solution is worthless: found out by `solve`.
    for n in [[30, 30, 1], [12, 12, 12]] {
        for (diagonal, method) in [(0.0, Method::Lu), (1e-14, Method::Lblt)] {
            let problem = random(n, 1, 1, |_, _| diagonal);
            let mut factorization = problem.analysed();
            let (report, solved, r) = problem.solve(&mut factorization, Method::Llt);
            assert_eq!((report.method, solved.method), (method, Method::Lu));
            assert!(solved.backward_error.unwrap() < 1e-12 && r < 1e-9, "{solved:?} {r}");
            // The next right-hand side meets the LU factor at once.
            let mut x = problem.matrix().times(&vec![1.0; problem.n()]);
            assert_eq!(factorization.solve(problem.matrix(), &mut x, 0.0).unwrap().method, Method::Lu);
            assert!(x.iter().all(|x| (x - 1.0).abs() < 1e-8));
        }
    }
}

#[test]
fn weak_pivots_are_repaired_by_refinement() {
    let problem = random([30, 30, 1], 1, 1, |_, _| 1e-9);
    let (_, solved, r) = problem.solve(&mut problem.analysed(), Method::Llt);
    assert_eq!(solved.method, Method::Lblt);
    assert!((1..=3).contains(&solved.refinements), "{solved:?}");
    assert!(solved.backward_error.unwrap() < 1e-12 && r < 1e-9, "{solved:?} {r}");
}

#[test]
fn the_pivot_that_fails_is_named_and_valued() {
    // A detached equation keeps its diagonal as its pivot, wherever it stands in the order.
    let base = elasticity([9, 8], false);
    for equation in [20, 45, 77, 101, base.n() - 1] {
        let mut problem = elasticity([9, 8], false);
        problem.detach(equation, -0.25);
        let (report, ..) = problem.solve(&mut problem.analysed(), Method::Llt);
        let pivot = Pivot { equation, value: -0.25, relative: 1.0 };
        assert_eq!(report.not_positive, Some(pivot));
        assert_eq!(negative(&report), Some(1));
    }
    // One large dense supernode, to see faer's blocks: the pivot 150 fails with a known value.
    let n = 200;
    let mut entries = BTreeMap::new();
    for j in 0..n {
        for i in j..n {
            entries.insert((j, i), if i == j { 2.0 } else { 1.0 });
        }
    }
    let mut problem = Problem::new((0..n as u32).map(|x| [x, 0, 0]).collect(), 1, &entries);
    let at = problem.column_start[150];
    problem.values[at] = -3.0;
    let report = problem.analysed().factorise_from(problem.matrix(), Method::Llt).unwrap();
    let stop = report.not_positive.unwrap();
    assert_eq!((stop.equation, report.method, negative(&report)), (150, Method::Lblt, Some(1)));
    // Schur complement of I + 1 1ᵀ of size 150: d − 150/151, if eliminated in natural order.
    assert!((stop.value - (-3.0 - 150.0 / 151.0)).abs() < 1e-12, "{stop:?}");
}

#[test]
fn a_free_node_is_named() {
    for equation in [0, 31, 100] {
        let mut problem = elasticity([8, 7], false);
        problem.detach(equation, 0.0);
        for start in [Method::Llt, Method::Lblt, Method::Lu] {
            let error = problem.analysed().factorise_from(problem.matrix(), start).unwrap_err();
            assert_eq!(error, Singular { equation, pivot: Some(0.0), cause: Cause::EmptyRow });
        }
    }
}

#[test]
fn a_singular_block_is_named() {
    // Equations 30 and 31, detached from the rest, make the exactly singular [[1, 1], [1, 1]].
    let mut problem = elasticity([8, 7], false);
    problem.detach(30, 1.0);
    problem.detach(31, 1.0);
    let coupling = problem.column_start[30] + 1;
    assert_eq!(problem.row[coupling], 31);
    problem.values[coupling] = 1.0;
    let error = problem.analysed().factorise_from(problem.matrix(), Method::Llt).unwrap_err();
    assert!(error.equation == 30 || error.equation == 31, "{error:?}");
    assert_eq!((error.pivot, error.cause), (Some(0.0), Cause::NoPivot));
}

#[test]
fn a_weak_node_is_named_without_failing() {
    // A node held by a stiffness of 1e-9 beside neighbours of order 1, K = H + 1e-9 e eᵀ where
    // H e = 0: digits of its diagonal cancel and the report says where.
    let problem = {
        let mut p = elasticity([6, 6], false);
        p.detach(60, 1.0);
        p.detach(61, 1.0 + 1e-9);
        let coupling = p.column_start[60] + 1;
        p.values[coupling] = 1.0;
        p
    };
    let (report, solved, _) = problem.solve(&mut problem.analysed(), Method::Llt);
    let weakest = report.weakest.unwrap();
    assert!(weakest.equation == 61 || weakest.equation == 60);
    assert!((weakest.relative / 1e-9 - 1.0).abs() < 1e-3, "{weakest:?}");
    assert!(solved.backward_error.unwrap() < 1e-12);
}

#[test]
fn what_is_not_finite_is_an_error_and_not_a_panic() {
    let problem = elasticity([5, 4], false);
    let mut factorization = problem.analysed();
    for bad in [f64::NAN, f64::INFINITY] {
        let mut values = problem.values.clone();
        values[problem.column_start[17] + 2] = bad;
        for start in [Method::Llt, Method::Lblt, Method::Lu] {
            let error = factorization.factorise_from(problem.with(&values), start).unwrap_err();
            assert_eq!((error.equation, error.cause), (17, Cause::MatrixNotFinite));
        }
        factorization.factorise_from(problem.matrix(), Method::Llt).unwrap();
        let mut b = vec![1.0; problem.n()];
        b[5] = bad;
        let error = factorization.solve(problem.matrix(), &mut b, 0.0).unwrap_err();
        assert_eq!((error.equation, error.cause), (5, Cause::RightHandSideNotFinite));
    }
    // Overflow on the way: finite entries, infinite products.
    let huge = random([6, 5, 1], 1, 2, |_, _| 1e-200);
    let values: Vec<f64> = huge.values.iter().map(|v| v * 1e300).collect();
    for start in [Method::Llt, Method::Lblt, Method::Lu] {
        let mut factorization = huge.analysed();
        if factorization.factorise_from(huge.with(&values), start).is_ok() {
            let mut b = vec![1e300; huge.n()];
            if factorization.solve(huge.with(&values), &mut b, 0.0).is_ok() {
                assert!(b.iter().all(|x| x.is_finite()));
            }
        }
    }
}

#[test]
fn the_analysis_is_kept_while_the_pattern_is_equal() {
    let (a, b) = (elasticity([9, 5], false), elasticity([5, 9], false));
    let mut factorization = Factorization::new();
    let mut analyse = |p: &Problem| {
        let analysis = factorization.analyse(p.pattern(), &p.hints()).unwrap();
        let (_, _, r) = p.solve(&mut factorization, Method::Llt);
        assert!(r < 1e-12);
        analysis
    };
    assert_eq!(a.n(), b.n());
    let seen = [&a, &a, &b, &a, &a].map(&mut analyse);
    use Analysis::{New, Reused};
    assert_eq!(seen, [New, Reused, New, New, Reused]);
}

#[test]
fn a_reused_factorization_gives_the_bits_of_a_fresh_one() {
    let spd = elasticity([6, 5, 4], false);
    let mut indefinite = elasticity([6, 5, 4], false);
    for e in (0..indefinite.n()).step_by(7) {
        indefinite.values[indefinite.column_start[e]] *= -1.0;
    }
    let bits = |factorization: &mut Factorization, p: &Problem| {
        factorization.factorise_from(p.matrix(), Method::Llt).unwrap();
        let mut x: Vec<f64> = (0..p.n()).map(|i| (i as f64).sin()).collect();
        factorization.solve(p.matrix(), &mut x, 0.0).unwrap();
        x.iter().map(|x| x.to_bits()).collect::<Vec<_>>()
    };
    let mut kept = spd.analysed();
    for problem in [&spd, &indefinite, &spd, &indefinite, &indefinite] {
        assert_eq!(bits(&mut kept, problem), bits(&mut problem.analysed(), problem));
    }
}

#[test]
fn predicted_entries_are_those_of_the_factor() {
    let problem = elasticity([11, 9], false);
    let FactorSize { entries: predicted, bytes } = predict_factor(problem.pattern(), &problem.hints()).unwrap();
    assert!(bytes > 8 * predicted && bytes < 40 * predicted, "{bytes} bytes for {predicted} entries");
    assert_eq!(predicted, problem.analysed().factor_entries());
    let n = problem.n();
    assert!(predicted > problem.row.len() && predicted < n * n / 2, "{predicted} entries for {n} equations");
}

#[test]
fn fill_is_below_that_of_minimum_degree() {
    let problem = elasticity([12, 12, 12], false);
    let ours = problem.analysed().factor_entries() as f64;
    let amd = symbolic::entries_by_minimum_degree(problem.pattern()) as f64;
    assert!(ours < 0.8 * amd, "{ours} entries, {amd} by minimum degree");
}

#[test]
fn the_condition_number_is_estimated_from_below() {
    // tridiag(-1, 2, -1): eigenvalues 2 - 2 cos(k π/(n + 1)).
    let n = 60;
    let mut entries = BTreeMap::new();
    for j in 0..n {
        entries.insert((j, j), 2.0);
        if j + 1 < n {
            entries.insert((j, j + 1), -1.0);
        }
    }
    let chain = |entries: &BTreeMap<_, _>| Problem::new((0..n as u32).map(|x| [x, 0, 0]).collect(), 1, entries);
    let problem = chain(&entries);
    let mut factorization = problem.analysed();
    assert_eq!(factorization.condition(problem.matrix()), None);
    factorization.factorise_from(problem.matrix(), Method::Llt).unwrap();
    let angle = std::f64::consts::PI / (2.0 * (n + 1) as f64);
    let exact = angle.tan().powi(-2);
    let estimate = factorization.condition(problem.matrix()).unwrap();
    assert!((0.5 * exact..exact * (1.0 + 1e-12)).contains(&estimate), "{estimate} of {exact}");
    // Indefinite: sizes count. Eigenvalues are shifted by 1.9, the smallest size is then some 0.03.
    for j in 0..n {
        entries.insert((j, j), 0.1);
    }
    let problem = chain(&entries);
    let report = problem.solve(&mut problem.analysed(), Method::Llt).0;
    assert_eq!(report.method, Method::Lblt);
    let mut factorization = problem.analysed();
    factorization.factorise_from(problem.matrix(), Method::Lblt).unwrap();
    let eigenvalue = |k: usize| (0.1 - 2.0 * (2.0 * k as f64 * angle).cos()).abs();
    let (least, most) = (1..=n).map(eigenvalue).fold((f64::MAX, 0.0_f64), |(l, m), e| (l.min(e), m.max(e)));
    let estimate = factorization.condition(problem.matrix()).unwrap();
    assert!(
        (0.4 * most / least..most / least * (1.0 + 1e-12)).contains(&estimate),
        "{estimate} of {}",
        most / least
    );
}

#[test]
fn costs_are_predicted_from_the_box_of_the_nodes() {
    use crate::multigrid::Multigrid;
    for cells in [[12, 12, 12], [60, 5, 5], [20, 20, 4]] {
        let problem = elasticity(cells, false);
        let (pattern, places) = (problem.pattern(), problem.places());
        let prediction = predict(pattern, places);
        let entries = predict_factor(pattern, &problem.hints()).unwrap().entries as f64;
        let ratio = prediction.factor_entries / entries;
        assert!((0.5..1.5).contains(&ratio), "{cells:?}: {ratio} of the entries");
        let bytes = Multigrid::<3>::analyse(pattern, places).unwrap().size().bytes as f64;
        let ratio = prediction.iterative_bytes / bytes;
        assert!((0.7..1.3).contains(&ratio), "{cells:?}: {ratio} of the bytes");
    }
}
