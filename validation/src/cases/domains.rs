//! The health of domains: what is recorded of it, and how a run ends without it.

use super::largest;
use crate::history::History;
use crate::probe;
use crate::scenes::{load, load_own, run};
use crate::variants::{CPDI2Q, CROSS, GIMP, Method, PlaneScene, plane};
use crate::{Broken, Case, Check, Extent, Findings};
use mpm_assembly::AdvanceError;
use mpm_basis::ConvectionError;
use mpm_grid::{NodeId, Ramp, Vector};
use mpm_scene::language::{Count, FieldInput, Finite, GimpUpdateInput, MotionInput, Scene};
use mpm_solver::observe::Field;
use mpm_solver::{Error, Prescribed, StepFailure, Support};

pub(super) const HEALTH: Case = Case {
    name: "health of domains",
    goal: "What becomes of the domains can be seen in the history and at every point.",
    setup: "The corner stretch on the kite with quadrilaterals and with crossed triangles, 2² points, with the history of domains.",
    reference: "The columns of the history are the extremes of the points' fields. Nodes that receive points through single corners of their domains are there from the first step on, many more with triangles, which is why these are so stiff.",
    run: health,
};

pub(super) const INVERSION: Case = Case {
    name: "a domain that inverts",
    goal: "A run that loses a domain ends with a reason that says which point, where, and under which basis.",
    setup: "The slab of crush.ron with quadrilaterals, pushed too far in one load step; a block of GIMP boxes whose half lengths follow F_ii, on its way to 120°; the slides' doughnut with crossed triangles on its way to 180°.",
    reference: "The named reasons. The doughnut: the independent implementation fails at 160°; ours finds no equilibrium there.",
    run: inversion,
};

/// Columns of the history of domains.
const COLUMNS: [&str; 7] = [
    "domain_smallest_measure",
    "domain_smallest_corner_weight",
    "domain_largest_distortion",
    "domain_single_corner_nodes",
    "domain_corners_outside",
    "domain_fallen_back",
    "smallest_volume_ratio",
];

fn health(_: Extent) -> Result<Findings, Broken> {
    let mut checks = Vec::new();
    for method in [CPDI2Q, CROSS] {
        let name = method.name;
        let mut scene = method.of(plane(load("corner_stretch_kite")?)?);
        scene.output.domain_history = true;
        scene.output.fields = vec![
            FieldInput::DomainMeasure,
            FieldInput::SmallestCornerWeight,
            FieldInput::SingleCornerNodes,
            FieldInput::CornersOutside,
            FieldInput::FallenBack,
            FieldInput::VolumeRatio,
        ];
        let history = run(&Scene::PlaneStrain(scene))?.completed()?;
        let missing =
            COLUMNS.iter().filter(|it| !history.columns().iter().any(|column| column.name == **it)).count();
        checks.push(Check::none(format!("{name}: columns missing"), missing));

        let rows = 1..history.rows().len();
        let least =
            |field: Field, row: usize| history.field(field, row).iter().fold(f64::INFINITY, |a, &b| a.min(b));
        let sum = |field: Field, row: usize| history.field(field, row).iter().sum::<f64>();
        let pairs: [(&str, &dyn Fn(usize) -> f64); 6] = [
            (COLUMNS[0], &|row| least(Field::DOMAIN_MEASURE, row)),
            (COLUMNS[1], &|row| least(Field::SMALLEST_CORNER_WEIGHT, row)),
            (COLUMNS[3], &|row| sum(Field::SINGLE_CORNER_NODES, row)),
            (COLUMNS[4], &|row| sum(Field::CORNERS_OUTSIDE, row)),
            (COLUMNS[5], &|row| sum(Field::FALLEN_BACK, row)),
            (COLUMNS[6], &|row| least(Field::VOLUME_RATIO, row)),
        ];
        let differing: usize = pairs
            .iter()
            .map(|(column, of)| {
                let series = history.series(column, 0);
                rows.clone().filter(|&row| series[row] != of(row)).count()
            })
            .sum();
        checks.push(Check::none(
            format!("{name}: entries of the history that are not the fields' extremes"),
            differing,
        ));

        let measure = history.series(COLUMNS[0], 0)[1..].iter().fold(f64::INFINITY, |a, &b| a.min(b));
        checks.push(
            Check::none(format!("{name}: domains that lost their area"), usize::from(measure <= 0.0))
                .remark(format!("smallest area over that at rest {measure:.3}")),
        );
        let single = history.series(COLUMNS[3], 0)[1..].to_vec();
        let distortion = largest(history.series(COLUMNS[2], 0));
        let weight = history.series(COLUMNS[1], 0)[1..].iter().fold(f64::INFINITY, |a, &b| a.min(b));
        let remark = format!(
            "{} to {} nodes, largest distortion {distortion:.3}, smallest weight {weight:.3}",
            single.iter().fold(f64::INFINITY, |a, &b| a.min(b)),
            largest(single.iter().copied())
        );
        if method == CROSS {
            let without = single.iter().filter(|&&nodes| nodes == 0.0).count();
            checks.push(
                Check::none(format!("{name}: load steps without nodes held by a single corner"), without)
                    .remark(remark),
            );
            let odd = usize::from((weight - 1.0 / 3.0).abs() > 1e-15);
            checks.push(Check::none(format!("{name}: corners that do not weigh a third"), odd));
        } else {
            let odd = usize::from(distortion <= 0.0);
            checks.push(Check::none(format!("{name}: lack of distortion"), odd).remark(remark));
        }
    }
    Ok(checks.into())
}

/// The slides' doughnut up to an angle, one degree in each load step.
pub(super) fn doughnut_to(method: &Method, degrees: u32) -> Result<PlaneScene, Broken> {
    let mut scene = method.of(plane(load("doughnut")?)?);
    if let MotionInput::Twist { inner, .. } = &mut scene.motion {
        *inner = Finite(f64::from(degrees));
    }
    scene.schedule.steps = Some(Count(degrees));
    Ok(scene)
}

fn inversion(_: Extent) -> Result<Findings, Broken> {
    let mut checks = Vec::new();

    let crushed = run(&Scene::PlaneStrain(CPDI2Q.of(plane(load_own("crush")?)?)))?;
    let error = crushed.outcome.err().ok_or("the slab was crushed after all")?;
    let named = matches!(&error, Error::Step { reason: StepFailure::Inverted { basis: "CPDI2q", .. }, .. });
    checks.push(
        Check::none("crushed slab: reason other than an inverted point", usize::from(!named))
            .remark(error.to_string()),
    );
    checks.push(Check::none("crushed slab: parts missing in the message", missing(&error, "`slab`", "CPDI2q")));

    let error = turn_a_box()?;
    let named = matches!(
        &error,
        Error::Step {
            reason: StepFailure::Advance {
                reason: AdvanceError::Domain { reason: ConvectionError::HalfLength { .. }, .. },
                ..
            },
            ..
        }
    );
    checks.push(
        Check::none("turned box: reason other than a lost half length", usize::from(!named))
            .remark(error.to_string()),
    );
    checks.push(Check::none("turned box: parts missing in the message", missing(&error, "`block`", "GIMP")));

    let twisted = run(&Scene::PlaneStrain(doughnut_to(&CROSS, 180)?))?;
    let angle = 180.0 * twisted.history.last().fraction;
    let error = twisted.outcome.err().ok_or("the twist reached 180° after all")?;
    checks.push(
        Check::new("doughnut: angle at which it ends against 160° (degrees)", (angle - 160.0).abs(), 2.0)
            .remark(format!("{angle:.2}°: {error}")),
    );
    Ok(checks.into())
}

/// Parts that the message of an error lacks.
fn missing(error: &Error, body: &str, basis: &str) -> usize {
    let text = error.to_string();
    [body, basis, "material point ", " at ["].iter().filter(|part| !text.contains(*part)).count()
}

/// How a block of GIMP boxes whose sides follow F_ii ends on its way to 120°.
fn turn_a_box() -> Result<Error, Broken> {
    let mut scene = GIMP.of(plane(load_own("patch_plane_graded")?)?);
    scene.domains.gimp_update = Some(GimpUpdateInput::Diagonal);
    scene.schedule.cuts = 0;
    let mut model = probe::plane(&Scene::PlaneStrain(scene))?;
    let outer = model.supports.pop().expect("the scene has a support to start from");
    let (sin, cos) = 120_f64.to_radians().sin_cos();
    let nodes = (0..model.layout.lattice().n_nodes()).filter_map(NodeId::from_index);
    model.supports = nodes
        .map(|node| {
            let x: Vector<2> = model.layout.position(node);
            let by = [(cos - 1.0) * x[0] - sin * x[1], sin * x[0] + (cos - 1.0) * x[1]];
            let components = by.map(|by| Some(Prescribed::Driven(Ramp::linear(by))));
            Support { name: node.index().to_string(), nodes: vec![node], components, ..outer.clone() }
        })
        .collect();
    mpm_solver::run(&mut model, &mut History::default())
        .err()
        .ok_or_else(|| "the box was turned after all".into())
}
