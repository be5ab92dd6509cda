//! How fast Newton's method closes in on a contact, and what does not depend on threads.

use crate::cases::newton_rate::slopes;
use crate::history::{History, Row};
use crate::scenes::{from_rest, load_own, run};
use crate::variants::plane;
use crate::{Broken, Case, Check, Extent, Findings, Table};
use mpm_scene::language::{Finite, Scene};

pub(in crate::cases) const CASE: Case = Case {
    name: "iterations with tools",
    goal: "Newton's method converges quadratically on closing, sticking and slipping contacts, and the number of threads changes nothing.",
    setup: "The circle on a block, smooth, sticking (μ = 10), and slipping (μ = 0.3); the block on a plane that is drawn away, held by adhesion of half the mean pressure; every step begun at rest. A circle with adhesion, whose tangent is the symmetric part, for comparison. The circle that slips on 1, 2 and 8 threads.",
    reference: "Slope of the residual against the one before it, both logarithmic, over the last three residuals between 10⁻¹ and round-off: above 1.7 in the median. The run on one thread, bit for bit.",
    run: rate,
};

/// Residuals above this belong to contacts that still open and close.
const NEAR: f64 = 1e-1;

/// Residuals below this are round-off.
const ROUND_OFF: f64 = 1e-11;

fn circle(friction: f64) -> Result<Scene, Broken> {
    let mut scene = plane(load_own("contact/circle_on_block")?)?;
    scene.tools[0].interface.friction = Finite(friction);
    Ok(from_rest(Scene::PlaneStrain(scene)))
}

fn held(adhesion: f64) -> Result<Scene, Broken> {
    let mut scene = plane(load_own("contact/drag")?)?;
    (scene.tools[0].interface.friction, scene.tools[0].interface.adhesion) = (Finite(0.0), Finite(adhesion));
    Ok(from_rest(Scene::PlaneStrain(scene)))
}

fn adhering() -> Result<Scene, Broken> {
    let mut scene = plane(load_own("contact/circle_on_block")?)?;
    (scene.tools[0].interface.friction, scene.tools[0].interface.adhesion) = (Finite(0.0), Finite(2e3));
    Ok(from_rest(Scene::PlaneStrain(scene)))
}

fn rate(_: Extent) -> Result<Findings, Broken> {
    let mut findings = Findings::default();
    let mut table = Table::new(
        "Slopes of Newton's residuals; that of adhesion on a curved surface is one of linear convergence, because its tangent is kept symmetric:",
        &["contact", "median", "least", "load steps", "residuals of the last"],
    );
    let jobs = [
        ("circle, smooth", circle(0.0)?),
        ("circle, sticking", circle(10.0)?),
        ("circle, slipping", circle(0.3)?),
        ("plane, adhesion", held(4500.0)?),
        ("circle, adhesion", adhering()?),
    ];
    for (name, scene) in jobs {
        let history = run(&scene)?.completed()?;
        let mut slopes = slopes(&history, ROUND_OFF..NEAR);
        slopes.sort_by(f64::total_cmp);
        let middle = slopes.get(slopes.len() / 2).copied().unwrap_or(f64::NAN);
        let least = slopes.first().copied().unwrap_or(f64::NAN);
        // On curved surfaces adhesion keeps the symmetric part of its tangent, and converges linearly, by 10⁻³.
        let is_exact = name != "circle, adhesion";
        findings.checks.extend(is_exact.then(|| {
            Check::new(
                format!("{name}: slope of Newton's residuals in the median, lack below 1.7"),
                if middle.is_nan() { f64::NAN } else { (1.7 - middle).max(0.0) },
                0.0,
            )
        }));
        let residuals: Vec<String> = history.last().residuals.iter().map(|it| format!("{it:.0e}")).collect();
        table.push([
            name.to_owned(),
            format!("{middle:.2}"),
            format!("{least:.2}"),
            slopes.len().to_string(),
            residuals.join(" "),
        ]);
    }
    findings.tables.push(table);
    let alone = on_threads(1)?;
    for threads in [2, 8] {
        let found = on_threads(threads)?;
        let differing = found.iter().zip(&alone).filter(|(a, b)| a != b).count();
        let what = format!("circle, slipping: numbers that differ on {threads} threads");
        findings.checks.push(Check::none(what, differing + found.len().abs_diff(alone.len())));
    }
    Ok(findings)
}

/// Everything that the run with the circle that slips shows but its wall time.
fn on_threads(threads: usize) -> Result<Vec<u64>, Broken> {
    let (scene, pool) = (circle(0.3)?, rayon::ThreadPoolBuilder::new().num_threads(threads).build()?);
    let history: History = pool.install(|| run(&scene))?.completed()?;
    Ok(history.reproducible().iter().flat_map(Row::bits).collect())
}
