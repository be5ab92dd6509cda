//! Bodies that nothing holds, or that stand beside much stiffer ones.

use super::said_and_run::{last, missing, of_every_basis, with_basis};
use super::{Answer, Kind, compiled, run, text};
use crate::Broken;
use crate::cases::largest;
use crate::scenes::run_compiled;

pub(super) const KINDS: &[Kind] = &[
    Kind { input: "a block on rollers", scene: "unheld_on_rollers", answer: unheld },
    Kind { input: "the same with the sideways motion set to zero", scene: "unheld_on_rollers", answer: zero },
    Kind { input: "a soft body on a base 10¹² times as stiff", scene: "soft_on_stiff", answer: stiff_base },
];

const SOLVERS: [&str; 2] = ["Direct", "Iterative"];

/// The scene with a solver and another field before its schedule.
fn with(text: &str, solver: &str, field: &str) -> String {
    text.replace("    schedule:", &format!("    solver: {solver},\n    {field}\n    schedule:"))
        .replace("basis: Cpdi2t", "basis: Cpdi1")
}

fn unheld(scene: &str) -> Result<Answer, Broken> {
    let text = text(scene)?;
    let end = |text: &str| {
        let (scene, compiled) = compiled(text)?;
        let ended = run_compiled(&mut compiled?, &scene).outcome;
        Ok::<_, Broken>(ended.err().map_or("completed".into(), |error| error.to_string()))
    };
    let error = of_every_basis(|basis| {
        let mut error = 0.0;
        for solver in SOLVERS {
            let why = end(&with_basis(&with(&text, solver, ""), basis))?;
            error += missing(&why, "nothing holds body `b` along x");
        }
        Ok(error)
    })?;
    Ok(Answer::new(end(&text)?, error, 0.0))
}

fn zero(scene: &str) -> Result<Answer, Broken> {
    let text = text(scene)?;
    let error = of_every_basis(|basis| {
        let drifts = SOLVERS.map(|solver| {
            let run = run(&with_basis(&with(&text, solver, "unheld_motion: Zero,"), basis))?;
            Ok::<_, Broken>(largest(run.history.series("probe/all/displacement", 0)))
        });
        Ok(largest(drifts.into_iter().collect::<Result<Vec<_>, _>>()?))
    })?;
    Ok(Answer::new("the mean of the sideways displacements stays", error, 1e-12))
}

fn stiff_base(scene: &str) -> Result<Answer, Broken> {
    let history = run(&text(scene)?)?.history;
    let [top, base] = ["top", "base"].map(|name| last(&history.series(&format!("reaction/{name}"), 1)));
    // Uniaxial strain of 1 % in a body of height 1: E ln λ / λ.
    let stretch: f64 = 0.99;
    let exact = 100.0 * stretch.ln() / stretch;
    let error = (top / exact - 1.0).abs() + (top + base).abs() / exact.abs();
    Ok(Answer::new(format!("reactions {top:.6} and {base:.6}"), error, 1e-9))
}
