//! Driven nodes and the bodies that they are to move.

use super::said_and_run::{last, missing, of_every_basis, with_basis};
use super::{Answer, Kind, compiled, refusal, remarks, run, text};
use crate::Broken;
use crate::cases::fixed;
use crate::history::History;
use crate::scenes::run_compiled;

pub(super) const KINDS: &[Kind] = &[
    Kind { input: "a body pressed away from its nodes", scene: "plate_on_fixed_mesh", answer: pressed },
    Kind { input: "a body pulled through its nodes", scene: "plate_on_fixed_mesh", answer: pulled },
    Kind { input: "the same with a mesh that follows", scene: "plate_on_fixed_mesh", answer: followed },
    Kind { input: "a body that slides along driven nodes", scene: "plate_on_fixed_mesh", answer: sliding },
    Kind {
        input: "a footing whose ground sinks below its nodes",
        scene: "footing_leaves_its_nodes",
        answer: footing,
    },
    Kind { input: "a line of nodes that soil can pass", scene: "line_of_driven_nodes", answer: line },
    Kind { input: "a block of nodes, and a mesh that follows", scene: "block_of_driven_nodes", answer: block },
    Kind { input: "a turn of nodes on its axis", scene: "turn_on_the_axis", answer: on_the_axis },
    Kind {
        input: "a block of nodes dragged through the middle of a body",
        scene: "block_dragged_inside",
        answer: dragged,
    },
    Kind { input: "a line of nodes turned like a vane", scene: "block_dragged_inside", answer: vane },
    Kind { input: "a disc of nodes turned on itself", scene: "block_dragged_inside", answer: disc },
    Kind { input: "a ring of nodes pushed aside", scene: "ring_pushed_aside", answer: pushed_aside },
    Kind { input: "an arm turned in a ring", scene: "ring_pushed_aside", answer: arm_in_ring },
    Kind { input: "a ring of nodes turned on itself", scene: "ring_pushed_aside", answer: circle_in_ring },
    Kind {
        input: "nodes that hold a body, moved away by their mesh",
        scene: "wall_taken_away",
        answer: taken_away,
    },
    Kind { input: "nodes that hold a body a cell away", scene: "wall_taken_away", answer: far },
];

/// A run that ends because a support has lost its body: why, and what was recorded.
fn ended(text: &str) -> Result<(String, History), Broken> {
    let (scene, compiled) = compiled(text)?;
    let run = run_compiled(&mut compiled?, &scene);
    Ok((run.outcome.err().map_or("completed".into(), |error| error.to_string()), run.history))
}

/// How far the gap at the end is from just above half a cell, of every basis.
fn loses(text: &str) -> Result<f64, Broken> {
    of_every_basis(|basis| {
        let (why, history) = ended(&with_basis(text, basis))?;
        let gap = last(&history.series("driven_gap/plate", 0));
        // A load step moves the plate by a twentieth of a cell.
        let wrong = if (0.5..0.551).contains(&gap) { 0.0 } else { gap };
        Ok(wrong + missing(&why, "support `plate` have lost the body"))
    })
}

fn pressed(scene: &str) -> Result<Answer, Broken> {
    let text = text(scene)?;
    let remarked = remarks(&text)?;
    let error = loses(&text)? + missing(&remarked, "the body leaves its nodes by more than half a cell");
    Ok(Answer::new(format!("ends at a gap above 0.5; `mpm check`: {remarked}"), error, 0.0))
}

fn pulled(scene: &str) -> Result<Answer, Broken> {
    Ok(Answer::new("ends at a gap above 0.5", loses(&text(scene)?.replace("by: -0.5", "by: 0.5"))?, 0.0))
}

fn followed(scene: &str) -> Result<Answer, Broken> {
    let motion =
        "    motion: Stretch([(axis: Y, anchor: 0, driven: 2, displacement: -0.5)]),\n    basis: Cpdi1,";
    let text = text(scene)?
        .replace("    basis: Cpdi1,", motion)
        .replace("displace: [(axis: Y, by: -0.5)]", "follow_mesh: [Y]");
    let stretch: f64 = 0.75;
    let exact = 2.0 * 1000.0 / (1.0 - 0.0625) * stretch.ln() / stretch;
    let error = of_every_basis(|basis| {
        let pressed = run(&with_basis(&text, basis))?.history.series("reaction/plate", 1);
        Ok((last(&pressed) / exact - 1.0).abs())
    })?;
    Ok(Answer::new(
        format!("reaction {}", fixed(exact, 4)),
        error + f64::from(u8::from(remarks(&text)?.contains("leaves"))),
        1e-7,
    ))
}

fn sliding(scene: &str) -> Result<Answer, Broken> {
    let text = text(scene)?
        .replace("(name: \"left\", region: Plane(axis: X, at: 0), fix: [X]),", "")
        .replace("(name: \"plate\", region: Plane(axis: Y, at: 2), displace: [(axis: Y, by: -0.5)]),", "")
        .replace("fix: [Y])", "fix: [Y], displace: [(axis: X, by: 1.7)])");
    let error = of_every_basis(|basis| {
        let gap = run(&with_basis(&text, basis))?.history.series("driven_gap/bottom", 0);
        Ok(gap.iter().fold(0.0, |most, gap| f64::max(most, gap - gap.min(0.25))))
    })?;
    let remarked = remarks(&text)?;
    let error = error + f64::from(u8::from(remarked.contains("bottom")));
    Ok(Answer::new("completed, without a gap", error, 0.2))
}

fn footing(scene: &str) -> Result<Answer, Broken> {
    let text = text(scene)?;
    let remarked = remarks(&text)?;
    let (why, history) = ended(&text)?;
    let load = history.series("reaction/footing", 1);
    // It still rises there; the exact limit is 257.
    let falls = f64::from(u8::from(!(230.0..260.0).contains(&-last(&load))));
    let error = missing(&why, "support `footing` have lost the body")
        + missing(&remarked, "support `footing` moves in a mesh that does not move with it")
        + falls;
    Ok(Answer::new(format!("ends at a load of {}: {why}", fixed(-last(&load), 0)), error, 0.0))
}

fn line(scene: &str) -> Result<Answer, Broken> {
    Ok(Answer::message(remarks(&text(scene)?)?, "support `footing` is a line of driven nodes"))
}

/// As far as a settlement of 0.02, where the load is 178.
fn block(scene: &str) -> Result<Answer, Broken> {
    let text =
        text(scene)?.replace("displacement: -0.5", "displacement: -0.02").replace("steps: 100", "steps: 4");
    let remarked = remarks(&text)?;
    let load = -last(&run(&text)?.history.series("reaction/footing", 1));
    let named = f64::from(u8::from(remarked.contains("line of driven") || remarked.contains("leaves")));
    Ok(Answer::new(format!("load {}", fixed(load, 1)), (load / 178.0 - 1.0).abs() + named, 0.01))
}

/// Ends in the step in which the material has passed half a cell; `mpm check` says so before.
fn ends_within(text: &str, per_step: f64) -> Result<f64, Broken> {
    let (why, history) = ended(text)?;
    let gap = last(&history.series("driven_gap/inside", 0));
    let wrong = if (0.5..0.5 + per_step).contains(&gap) { 0.0 } else { 1.0 };
    let named = missing(&remarks(text)?, "support `inside` moves in a mesh that does not move with it");
    Ok(wrong + named + missing(&why, "support `inside` have lost the body"))
}

/// The same under every basis.
fn ends_under_every_basis(text: &str, per_step: f64) -> Result<Answer, Broken> {
    let error = of_every_basis(|basis| ends_within(&with_basis(text, basis), per_step))?;
    Ok(Answer::new("ends at a gap above 0.5", error, 0.0))
}

/// Runs to its end, and nobody says that nodes lose their body.
fn turns_on_itself(text: &str) -> Result<Answer, Broken> {
    let named = f64::from(u8::from(remarks(text)?.contains("support `inside`")));
    let gap = run(text)?.history.series("driven_gap/inside", 0);
    let most = gap.iter().fold(0.0, |most, gap| f64::max(most, *gap));
    Ok(Answer::new("completed, without a gap", most + named, 0.1))
}

fn dragged(scene: &str) -> Result<Answer, Broken> {
    ends_under_every_basis(&text(scene)?, 0.1501)
}

/// The scene with nodes that are turned about the middle of the block.
fn turned(scene: &str, region: &str) -> Result<String, Broken> {
    let dragged = "region: Box(from: (2, 3.5), to: (3, 4.5)), fix: [Y], displace: [(axis: X, by: 1.5)]";
    let turned = format!("region: {region}, turn: (angle: 60, centre: (4, 4))");
    Ok(text(scene)?.replace(dragged, &turned))
}

fn vane(scene: &str) -> Result<Answer, Broken> {
    ends_under_every_basis(&turned(scene, "Box(from: (2.5, 4), to: (5.5, 4))")?, 0.11)
}

fn disc(scene: &str) -> Result<Answer, Broken> {
    turns_on_itself(&turned(scene, "Annulus(centre: (4, 4), outer: 1.6)")?)
}

fn pushed_aside(scene: &str) -> Result<Answer, Broken> {
    Ok(Answer::new("ends at a gap above 0.5", ends_within(&text(scene)?, 0.0601)?, 0.0))
}

/// The ring with nodes that are turned about its centre.
fn turned_in_ring(scene: &str, region: &str) -> Result<String, Broken> {
    let pushed = "region: Circle(radius: 1), fix: [Y], displace: [(axis: X, by: 0.3)]";
    Ok(text(scene)?.replace(pushed, &format!("region: {region}, turn: (angle: 20)")))
}

/// A cell has 15 degrees.
fn arm_in_ring(scene: &str) -> Result<Answer, Broken> {
    let text = turned_in_ring(scene, "All([Ray(angle: 0), Annulus(outer: 2)])")?;
    Ok(Answer::new("ends at a gap above 0.5", ends_within(&text, 0.0667)?, 0.0))
}

fn circle_in_ring(scene: &str) -> Result<Answer, Broken> {
    turns_on_itself(&turned_in_ring(scene, "Circle(radius: 1)")?)
}

fn taken_away(scene: &str) -> Result<Answer, Broken> {
    let text = text(scene)?;
    let remarked = remarks(&text)?;
    let (why, _) = ended(&text)?;
    let error = missing(&why, "support `wall` have lost the body")
        + missing(&remarked, "support `wall` holds the body in a mesh that moves");
    Ok(Answer::new(why, error, 0.0))
}

fn far(scene: &str) -> Result<Answer, Broken> {
    let text = text(scene)?.replace("from: (0, 0), to: (4, 1)", "from: (0.4, 0), to: (4, 1)");
    Ok(Answer::message(remarks(&text)?, "support `wall` is nearly a cell away from the body that it holds"))
}

fn on_the_axis(scene: &str) -> Result<Answer, Broken> {
    Ok(Answer::message(refusal(&text(scene)?)?, "lies on the axis: nothing turns"))
}
