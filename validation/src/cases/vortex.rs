//! The generalised vortex (Brannon, Kamojjala & Sadeghirad 2011): large shear with a known answer.

use super::{fixed, scientific, sweep};
use crate::problems::vortex::{Errors, errors, exact};
use crate::scenes::{run, text};
use crate::variants::{ALL, BACKSLASH, CPDI1, CPDI2Q, CROSS, Method, PlaneScene, SLASH, plane, refined};
use crate::{Broken, Case, Check, Extent, Findings, Table, problems};
use mpm_scene::Scene;
use mpm_scene::language::{Edited, set_value};

pub(super) const CASE: Case = Case {
    name: "generalised vortex",
    goal: "Shear and rotation in a mesh that does not move, with an exact answer: orders of convergence of every basis.",
    setup: "A ring 0.75 to 1.25 whose circles turn by up to a quarter of a radian (simple shear up to 1.77), held by the body force of that motion, in 20 load steps; E = 10³, ν = 0.3. Nodes beyond the ring's edges are held; points of the ring are cut from it, not from the mesh. 24², 48² and 96² cells on [-1.5, 1.5]², 2² points a cell.",
    reference: "The exact motion and its Hencky stress. Beyond a shear of 2.23 (0.316 radian) the Hencky law is no longer elliptic in simple shear: the exact motion is then no stable equilibrium, and no mesh holds it.",
    run: vortex,
};

pub(super) const RUBBER: Case = Case {
    name: "generalised vortex, rubber",
    goal: "The vortex as it was published, turned by a whole radian: the bases that follow a shear of 7, and their orders of convergence.",
    setup: "As the generalised vortex, with the neo-Hookean law and circles that turn by up to one radian (simple shear up to 7.1) in 20 load steps.",
    reference: "The exact motion and its neo-Hookean stress; this law is elliptic at any shear. Standard MPM and GIMP cannot follow: in a mesh that does not move, points and rectangles that are not sheared with the material lose their neighbours, and the runs end at 0.60 to 0.95 of the load.",
    run: rubber,
};

fn vortex(extent: Extent) -> Result<Findings, Broken> {
    turned(extent, &ALL, [1.9, 1.0], &|method, factor| problems::vortex::vortex(method, factor))
}

fn rubber(extent: Extent) -> Result<Findings, Broken> {
    let methods = extent.pick(&[CPDI1, CPDI2Q][..], &[CPDI1, CPDI2Q, SLASH, BACKSLASH, CROSS]);
    turned(extent, methods, [1.6, 0.8], &|method, factor| {
        let mut scene = text("vortex")?;
        for (path, value) in
            [("materials.jelly", "NeoHooke(young: 1e3, poisson: 0.3)"), ("loads[0].angle", "57.29577951308232")]
        {
            Edited { text: scene, .. } = set_value(&scene, path, value)?;
        }
        Ok(refined(method.of(plane(Scene::from_ron(&scene)?)?), factor))
    })
}

/// Runs the vortices of all methods on all meshes; CPDI1 and CPDI2q have to reach the orders of displacement and stress.
fn turned(
    extent: Extent,
    methods: &[Method],
    [of_displacement, of_stress]: [f64; 2],
    scene: &(dyn Fn(&Method, u32) -> Result<PlaneScene, Broken> + Sync),
) -> Result<Findings, Broken> {
    let factors: &[u32] = extent.pick(&[1, 2], &[1, 2, 4]);
    let jobs: Vec<(&Method, u32)> =
        methods.iter().flat_map(|method| factors.iter().map(move |&factor| (method, factor))).collect();
    let results = sweep(&jobs, |(method, factor)| {
        let scene = scene(method, *factor)?;
        let field = exact(&scene)?;
        let history = run(&Scene::PlaneStrain(scene))?.history;
        Ok((errors(&history, &field)?, history.last().fraction))
    })?;

    let mut findings = Findings::default();
    let heads = ["basis", "cells", "displacement", "order", "stress", "order", "reached"];
    let mut table =
        Table::new("Relative errors in the mean square at the end (or where the run ended).", &heads);
    for (method, results) in methods.iter().zip(results.chunks_exact(factors.len())) {
        let mut before: Option<&Errors> = None;
        for ((errors, reached), factor) in results.iter().zip(factors) {
            let order = |of: fn(&Errors) -> f64| before.map(|coarse| (of(coarse) / of(errors)).log2());
            let orders = [order(|it| it.displacement), order(|it| it.stress)];
            let told = orders.map(|order| order.map_or(String::new(), |order| fixed(order, 2)));
            table.push([
                method.name.into(),
                format!("{}²", 24 * factor),
                scientific(errors.displacement, 3),
                told[0].clone(),
                scientific(errors.stress, 3),
                told[1].clone(),
                fixed(*reached, 3),
            ]);
            if let (true, [Some(displacement), Some(stress)]) = (*method == CPDI1 || *method == CPDI2Q, orders)
            {
                let name = format!("{}, {}² cells", method.name, 24 * factor);
                let lack = |order: f64, least: f64| (least - order).max(0.0);
                findings.checks.push(Check::new(
                    format!(
                        "{name}: order of displacement below {of_displacement}, of stress below {of_stress}"
                    ),
                    lack(displacement, of_displacement).max(lack(stress, of_stress)) + (1.0 - reached),
                    0.0,
                ));
            }
            before = Some(errors);
        }
    }
    findings.tables.push(table);
    Ok(findings)
}
