//! Files that scenes name.

use super::{Answer, Kind, compiled, refusal, text};
use crate::Broken;

pub(super) const KINDS: &[Kind] = &[
    Kind { input: "an STL text of several solids", scene: "two_solids", answer: |scene| volume(scene, 2.0) },
    Kind { input: "an STL text in capitals", scene: "capitals", answer: |scene| volume(scene, 64.0) },
    Kind { input: "a point whose domain leaves the mesh", scene: "domain_corner", answer: domain_corner },
];

fn volume(scene: &str, exact: f64) -> Result<Answer, Broken> {
    let body = &compiled(&text(scene)?)?.1?.estimate()?.volumes[0];
    Ok(Answer::new(format!("volume {exact}"), (body.points / exact - 1.0).abs(), 1e-12))
}

fn domain_corner(scene: &str) -> Result<Answer, Broken> {
    let expected =
        "material point 0 at (1, 1): a corner of its domain: (0.5, -3) lies 3 cells outside the mesh";
    Ok(Answer::message(refusal(&text(scene)?)?, expected))
}
