//! What a scene says is what is run, or it is refused.

use super::{Answer, Kind, compiled, refusal, remarks, run, text};
use crate::Broken;
use crate::cases::{fixed, largest, relative};
use mpm_solver::observe::Field;

/// Bases of the plane.
const PLANE: [&str; 5] = ["Smpm", "Gimp", "Cpdi1", "Cpdi2q", "Cpdi2t"];

pub(super) const KINDS: &[Kind] = &[
    Kind { input: "points on lines of the mesh", scene: "bar_on_a_mesh_line", answer: bar },
    Kind {
        input: "points on lines and on the rim, moved as a rigid body",
        scene: "bar_on_a_mesh_line",
        answer: moved,
    },
    Kind {
        input: "a prescribed motion that does not begin at rest",
        scene: "ramp_from_one_to_zero",
        answer: jump,
    },
    Kind { input: "the same as a motion of the mesh", scene: "ramp_from_one_to_zero", answer: mesh_jump },
    Kind { input: "a moment about an axis other than z", scene: "torque_about_x", answer: torque },
    Kind { input: "knots of a ramp between load steps", scene: "cycle_between_steps", answer: cycle },
    Kind { input: "a traction on a plane through the body", scene: "traction_inside", answer: traction_inside },
    Kind { input: "volumes of points in other units", scene: "points_in_mm2", answer: units },
    Kind { input: "a ring in a box mesh", scene: "ring_in_a_box_mesh", answer: ring },
    Kind { input: "a force far from its body", scene: "force_far_away", answer: far_force },
    Kind { input: "a probe far from its body", scene: "force_far_away", answer: far_probe },
    Kind { input: "a support that touches nothing", scene: "corner_counted_twice", answer: idle_support },
    Kind { input: "nodes of two supports", scene: "corner_counted_twice", answer: total },
    Kind { input: "the moment of a traction", scene: "overturning_moment", answer: overturning },
    Kind { input: "a force in the middle of a symmetric body", scene: "overturning_moment", answer: middle },
    Kind { input: "an end between the lines of a graded mesh", scene: "graded_mesh", answer: graded },
];

/// The scene with another basis.
fn with_basis(text: &str, basis: &str) -> String {
    let bases = ["basis: Smpm", "basis: Cpdi1"];
    bases.iter().fold(text.to_string(), |text, old| text.replace(old, &format!("basis: {basis}")))
}

/// The largest of the errors that every basis of the plane makes.
fn of_every_basis(of: impl Fn(&str) -> Result<f64, Broken>) -> Result<f64, Broken> {
    let errors: Vec<f64> = PLANE.iter().map(|basis| of(basis)).collect::<Result<_, _>>()?;
    Ok(largest(errors))
}

fn last(values: &[f64]) -> f64 {
    values.last().copied().unwrap_or(f64::NAN)
}

fn bar(scene: &str) -> Result<Answer, Broken> {
    let text = text(scene)?;
    let stretch: f64 = 1.1;
    let exact = 1000.0 / (1.0 - 0.0625) * stretch.ln() / stretch * 0.5;
    let error = of_every_basis(|basis| {
        let pulled = run(&with_basis(&text, basis))?.history.series("reaction/top", 1);
        Ok(last(&pulled) / exact - 1.0)
    })?;
    Ok(Answer::new(format!("pulled with {}", fixed(exact, 4)), error, 1e-8))
}

/// Points on lines inside the mesh, and one half of each domain beyond its rim.
fn moved(scene: &str) -> Result<Answer, Broken> {
    let held = text(scene)?;
    let (head, _) = held.split_once("    supports:").ok_or("the scene has supports")?;
    let head = head.replace("    motion: Stretch([(axis: Y, anchor: 0, driven: 3, displacement: 0.3)]),\n", "");
    let all = |head: &str, at: &str| {
        format!(
            r#"{} supports: [(name: "all", region: Everywhere, displace: [(axis: X, by: {at}), (axis: Y, by: -0.01)])],
            schedule: (steps: 1), output: (fields: [DeformationGradient, CauchyStress]))"#,
            head
        )
    };
    let error = of_every_basis(|basis| {
        let mut worst = 0.0_f64;
        for by in ["0.01", "-0.01"] {
            let run = run(&with_basis(&all(&head, by), basis))?;
            let (row, history) = (run.history.rows().len() - 1, &run.history);
            let strained = history
                .field(Field::DEFORMATION_GRADIENT, row)
                .chunks_exact(9)
                .flat_map(|f| f.iter().enumerate().map(|(k, x)| (x - f64::from(u8::from(k % 4 == 0))).abs()));
            let stressed = history.field(Field::CAUCHY_STRESS, row).iter().map(|s| s.abs() / 1000.0);
            worst = worst.max(largest(strained.chain(stressed)));
        }
        Ok(worst)
    })?;
    Ok(Answer::new("F = I, no stress", error, 1e-13))
}

fn jump(scene: &str) -> Result<Answer, Broken> {
    let text = text(scene)?;
    let plate = run(&text)?.history.series("displacement/plate", 1);
    let remarked = remarks(&text)?;
    let error = relative(&plate, &[0.0, -0.075, -0.05, -0.025, 0.0]) + missing(&remarked, "jumps");
    Ok(Answer::new(format!("displacements {}; `mpm check`: {remarked}", listed(&plate)), error, 1e-9))
}

fn mesh_jump(scene: &str) -> Result<Answer, Broken> {
    let text = text(scene)?
        .replace(
            "    basis: Smpm,",
            "    motion: Stretch([(axis: Y, anchor: 0, driven: 2, displacement: -0.1, ramp: [(0, 1), (1, 0)])]),\n    basis: Smpm,",
        )
        .replace("displace: [(axis: Y, by: -0.1, ramp: [(0, 1), (1, 0)])]", "follow_mesh: [Y]");
    let history = run(&text)?.history;
    let plate = history.series("displacement/plate", 1);
    let left = last(&history.series("reaction/plate", 1)).abs() / 100.0;
    let error = relative(&plate, &[0.0, -0.075, -0.05, -0.025, 0.0]) + left;
    Ok(Answer::new(format!("displacements {}", listed(&plate)), error, 1e-7))
}

fn torque(scene: &str) -> Result<Answer, Broken> {
    let history = run(&text(scene)?)?.history;
    let [head, base] = ["head", "base"].map(|name| history.series(&format!("reaction_moment/{name}"), 0));
    let work = last(&history.series("energy/external_work", 0));
    let exact = work / (0.5 * 2_f64.to_radians());
    let error = (last(&head) / exact - 1.0).abs() + (last(&head) + last(&base)).abs() / exact;
    Ok(Answer::new(format!("{} at the head", fixed(last(&head), 1)), error, 2e-3))
}

fn cycle(scene: &str) -> Result<Answer, Broken> {
    let text = text(scene)?;
    let history = run(&text)?.history;
    let lowest = history.series("displacement/plate", 1).into_iter().fold(0.0, f64::min);
    let dissipated = last(&history.series("energy/dissipated", 0));
    // Every half cycle is straight, so that a step more or less in it changes what a step's own error is.
    let error =
        (lowest + 0.1).abs() + (dissipated / 2.68 - 1.0).abs() + missing(&remarks(&text)?, "0.25 and 0.75");
    let said = format!("{} reached, {} dissipated", -lowest, fixed(dissipated, 2));
    Ok(Answer::new(said, error, 0.05))
}

fn traction_inside(scene: &str) -> Result<Answer, Broken> {
    Ok(Answer::message(refusal(&text(scene)?)?, "has no boundary on the loaded part of the plane"))
}

fn units(scene: &str) -> Result<Answer, Broken> {
    let text = text(scene)?;
    let remarked = remarks(&text)?;
    let body = &compiled(&text)?.1?.estimate()?.volumes[0];
    let error = (body.points / 4e6 - 1.0).abs() + missing(&remarked, "points of body `b`");
    Ok(Answer::new(format!("`mpm check`: volume {}; {remarked}", body.points), error, 1e-12))
}

fn ring(scene: &str) -> Result<Answer, Broken> {
    let text = text(scene)?;
    let exact = 3.0 * std::f64::consts::PI;
    let error = of_every_basis(|basis| {
        let text = with_basis(&text, basis);
        let body = &compiled(&text)?.1?.estimate()?.volumes[0];
        let weight = last(&run(&text)?.history.series("reaction/e", 1));
        let wrong = [body.points, body.shape.unwrap_or(f64::NAN), body.mass.unwrap_or(f64::NAN), weight];
        Ok(largest(wrong.map(|found| (found / exact - 1.0).abs())))
    })?;
    Ok(Answer::new(format!("weight {}", fixed(exact, 4)), error, 1e-9))
}

fn far_force(scene: &str) -> Result<Answer, Broken> {
    Ok(Answer::message(refusal(&text(scene)?)?, "is 2233.72 away"))
}

fn far_probe(scene: &str) -> Result<Answer, Broken> {
    let text = text(scene)?.replace(
        "loads: [PointForce(body: \"b\", near: (1000, 2000), force: (0, -1))]",
        "probes: [(name: \"p\", body: \"b\", points: Near(0, 20))]",
    );
    Ok(Answer::message(refusal(&text)?, "away"))
}

fn idle_support(scene: &str) -> Result<Answer, Broken> {
    let idle = "supports: [\n        (name: \"idle\", region: Plane(axis: X, at: 4), fix: [X]),";
    let text = text(scene)?.replace("supports: [", idle);
    Ok(Answer::message(remarks(&text)?, "support `idle` touches no material"))
}

fn total(scene: &str) -> Result<Answer, Broken> {
    let text = text(scene)?;
    let history = run(&text)?.history;
    let total = [0, 1].map(|i| last(&history.series("reaction/total", i)));
    let remarked = remarks(&text)?;
    let error = relative(&total, &[-10.0, 7.0]) + missing(&remarked, "`left` and `bottom` share a node");
    Ok(Answer::new(
        format!("total ({}, {}); `mpm check`: {remarked}", fixed(total[0], 4), fixed(total[1], 4)),
        error,
        1e-7,
    ))
}

fn overturning(scene: &str) -> Result<Answer, Broken> {
    let text = text(scene)?;
    let error = of_every_basis(|basis| {
        let moment = last(&run(&with_basis(&text, basis))?.history.series("reaction_moment/bottom", 0));
        Ok((moment / 0.02 - 1.0).abs())
    })?;
    Ok(Answer::new("moment 0.02 about the base", error, 1e-7))
}

fn middle(scene: &str) -> Result<Answer, Broken> {
    let text = text(scene)?.replace(
        "Traction(body: \"b\", axis: Y, at: 2, resultant: (0.01, 0))",
        "PointForce(body: \"b\", near: (1, 1), force: (0.01, 0))",
    );
    let error = of_every_basis(|basis| {
        let moment = last(&run(&with_basis(&text, basis))?.history.series("reaction_moment/bottom", 0));
        Ok((moment / 0.01 - 1.0).abs())
    })?;
    Ok(Answer::new("moment 0.01 about the base", error, 1e-7))
}

/// A bar pulled by its weight: `σ = ρ a (L - x)`, nearly.
fn graded(scene: &str) -> Result<Answer, Broken> {
    let text = text(scene)?;
    let estimate = compiled(&text)?.1?.estimate()?;
    let body = &estimate.volumes[0];
    let error = of_every_basis(|basis| {
        let pull = last(&run(&with_basis(&text, basis))?.history.series("reaction/clamp", 0));
        Ok((pull / -(0.1 * 9.7 * 2.0) - 1.0).abs())
    })?;
    let empty = 40 - estimate.cells_with_material;
    let error = error + (body.points / 19.4 - 1.0).abs() + empty as f64;
    Ok(Answer::new(format!("{empty} cells are empty, weight {}", fixed(1.94, 2)), error, 1e-7))
}

/// 1 where a text lacks some words.
fn missing(text: &str, words: &str) -> f64 {
    f64::from(u8::from(!text.contains(words)))
}

fn listed(values: &[f64]) -> String {
    let values: Vec<String> = values[1..].iter().map(|x| fixed(*x, 3)).collect();
    values.join(", ")
}
