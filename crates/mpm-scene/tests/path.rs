//! Path control past limit points.

use mpm_scene::Scene;
use mpm_scene::compile;
use mpm_solver::observe::{Entry, LoadStep, Observer, ObserverError, RunStart};
use mpm_solver::{Error, Summary};

/// Load fraction, and one component of one column, per row.
struct Curve {
    column: &'static str,
    component: usize,
    at: usize,
    points: Vec<(f64, f64)>,
}

impl Curve {
    fn of(column: &'static str, component: usize) -> Self {
        Self { column, component, at: 0, points: Vec::new() }
    }
}

impl Observer for Curve {
    fn start(&mut self, run: &RunStart) -> Result<(), ObserverError> {
        self.at = run.columns.iter().position(|column| column.name == self.column).ok_or("no such column")?;
        Ok(())
    }

    fn load_step(&mut self, step: &LoadStep<'_>) -> Result<(), ObserverError> {
        if let Entry::Real(values) = &step.row[self.at] {
            self.points.push((step.fraction, values[self.component]));
        }
        Ok(())
    }
}

fn run(scene: &str, curve: &mut Curve) -> Result<Summary, Error> {
    let scene = Scene::from_ron(scene).expect("a valid scene");
    compile(&scene).expect("a scene that compiles").run(curve)
}

/// The scene with one line, recognised by how it begins, replaced.
fn with(scene: &str, line: &str, by: &str) -> String {
    assert_eq!(scene.lines().filter(|it| it.trim_start().starts_with(line)).count(), 1, "{line}");
    let replaced = scene.lines().map(|it| if it.trim_start().starts_with(line) { by } else { it });
    replaced.collect::<Vec<_>>().join("\n")
}

fn linear(curve: &[(f64, f64)], x: f64) -> f64 {
    let k = curve.iter().position(|point| point.0 >= x).expect("inside the curve").max(1);
    let ((x0, y0), (x1, y1)) = (curve[k - 1], curve[k]);
    y0 + (y1 - y0) * (x - x0) / (x1 - x0)
}

const DOUGHNUT: &str = include_str!("../../../scenes/path_doughnut.ron");
const ARCH: &str = include_str!("../../../scenes/path_arch.ron");

#[test]
fn the_doughnut_snaps_back_and_goes_on_to_the_end() {
    let mut torque = Curve::of("reaction_moment/inner", 0);
    run(DOUGHNUT, &mut torque).expect("reaches the end");
    let degrees: Vec<(f64, f64)> = torque.points.iter().map(|(t, moment)| (90.0 * t, moment / 1e7)).collect();
    assert_eq!(degrees.last().map(|it| it.0), Some(90.0));

    let top = (0..degrees.len()).max_by(|&a, &b| degrees[a].1.total_cmp(&degrees[b].1)).expect("rows");
    let (turn, peak) = degrees[top];
    assert!((peak - 8.50).abs() < 0.03 && (turn - 27.4).abs() < 0.2, "peak {peak} at {turn}");
    let back =
        degrees[top..top + 15].iter().copied().fold((f64::MAX, 0.0), |a, b| if b.0 < a.0 { b } else { a });
    assert!((back.0 - 26.54).abs() < 0.1 && (5.5..7.0).contains(&back.1), "back to {back:?}");
    // Down the whole branch that rotation control jumps across, in steps of a tenth of the peak at most.
    for pair in degrees[top..top + 10].windows(2) {
        assert!(pair[1].1 < pair[0].1 && pair[0].1 - pair[1].1 < 0.85, "{pair:?}");
    }
}

#[test]
fn rotation_control_jumps_where_path_control_does_not() {
    let mut torque = Curve::of("reaction_moment/inner", 0);
    let scene = with(DOUGHNUT, "motion:", "motion: Twist(inner: 30),");
    let _ = run(&with(&scene, "schedule:", "schedule: (steps: 30),"), &mut torque);
    let jump = torque.points.windows(2).map(|pair| pair[0].1 - pair[1].1).fold(0.0, f64::max);
    assert!(torque.points.len() < 31 || jump > 1.5e7, "{jump}");
}

#[test]
fn arc_length_turns_back_at_first_yield_and_says_so() {
    let mut torque = Curve::of("reaction_moment/inner", 0);
    let control = "schedule: (steps: 90, control: Path(first: 0.011111, measure: ArcLength(most: 0.05))),";
    let outcome = run(&with(DOUGHNUT, "schedule:", control), &mut torque);
    assert!(matches!(outcome, Err(Error::Step { .. } | Error::StepLimit { .. })), "{outcome:?}");
    let farthest = torque.points.iter().map(|it| 90.0 * it.0).fold(0.0, f64::max);
    assert!(farthest < 28.0, "{farthest}");
}

#[test]
fn the_step_limit_is_named() {
    let control = "schedule: (steps: 3, control: Path(first: 0.011111)),";
    let outcome = run(&with(DOUGHNUT, "schedule:", control), &mut Curve::of("residual", 0));
    assert!(
        matches!(outcome, Err(Error::StepLimit { steps: 3, fraction }) if (fraction - 0.033333).abs() < 1e-9)
    );
}

#[test]
fn a_shallow_arch_snaps_through_along_the_curve_of_displacement_control() {
    // Independent: the crown is driven down, the load is the reaction.
    let drop = 3.3;
    let driven = "(name: \"apex\", region: Plane(axis: X, at: 0), fix: [X], displace: [(axis: Y, by: -3.3)]),";
    let scene = with(&with(ARCH, "(name: \"apex\"", driven), "loads:", "");
    let mut reaction = Curve::of("reaction/apex", 1);
    run(&with(&scene, "schedule:", "schedule: (steps: 66),"), &mut reaction)
        .expect("displacement control passes");
    let driven: Vec<(f64, f64)> = reaction.points.iter().map(|(t, force)| (drop * t, -force)).collect();

    let mut crown = Curve::of("displacement/apex", 1);
    run(ARCH, &mut crown).expect("up to the load on the far branch");
    let path: Vec<(f64, f64)> = crown.points.iter().map(|(t, sunk)| (-sunk, 250.0 * t)).collect();

    let top = (1..path.len()).find(|&k| path[k + 1].1 < path[k].1).expect("rises");
    let bottom = (top..path.len()).find(|&k| path[k + 1].1 > path[k].1).expect("falls");
    let (maximum, minimum) = (path[top].1, path[bottom].1);
    assert!((maximum - 212.0).abs() < 1.0 && (minimum - 167.0).abs() < 1.0, "{maximum}, {minimum}");
    assert!(path[bottom..].windows(2).all(|pair| pair[1].1 > pair[0].1), "rises to the end: {path:?}");
    assert_eq!(path.last().map(|it| it.1), Some(250.0));
    for &(sunk, load) in &path[1..] {
        assert!((load - linear(&driven, sunk)).abs() < 0.02 * maximum, "{load} at {sunk}");
    }
}
