//! A cone that is pushed into sand.

use super::{lines, list};
use crate::cases::contact::of_tool;
use crate::cases::{fixed, largest, sweep};
use crate::scenes::{changed, run, text};
use crate::{Broken, Case, Check, Extent, Findings, Table};
use std::f64::consts::PI;

pub(in crate::cases) const CASE: Case = Case {
    name: "cone in sand",
    goal: "A cone that is pushed from the surface into loose sand with friction finds a resistance that grows with depth, changes by less than a tenth when cells are halved, and, from two diameters on, lies between what a spherical cavity bears and what tests in calibration chambers found.",
    setup: "scenes/cone_sand.ron: a cone of 60°, radius a = 0.4 m, in sand of relative density 32 % (E = 19.2 MPa (K₀ σ_v/100 kPa)^0.6 of the initial depth, ν = 0.25, φ = 32°, ψ = 2°, c = 0.3 kPa, K₀ = 0.47, 16.3 kN/m³; these, the cone's size, and the friction of 0.3 are those of the cone penetration test of the AMPSSIE tutorials, there with Willam and Warnke's surface, here Mohr and Coulomb's), ground of radius 12.8 m and depth 24.6 m, pushed in by 4 m in load steps of a fifth of the width of a cell at the cone; n cells over a, growing by 1.4 beyond 1.5 a and below the way; 2² points a cell, CPDI1 with reshaped domains, ghost faces, mean dilatation over points. A smooth cone and shaft besides. Resistance: force on cone and shaft over π a², mean over 0.4 m of the way. The quick run goes down by 0.8 m on the coarsest mesh.",
    reference: "Below: the limit pressure p of a spherical cavity in the same sand with the mean stress at rest (Yu & Houlsby, Géotechnique 41, 1991), taken as the pressure on the face of the cone: p (1 + μ cot 30°). Above: Baldi et al. 1986, normally consolidated Ticino sand in calibration chambers, q = 157 σ_v^0.55 exp(2.41 D_r) in kPa (coefficients from memory), for cones much deeper than these five diameters. Near the surface, where sand is pushed up, the resistance is below both. The base bears the ground and what pushes the cone.",
    run: cone,
};

/// Radius of the cone, depth and radius of the ground `[m]`.
const RADIUS: f64 = 0.4;
const DEPTH: f64 = 24.6;
const WIDTH: f64 = 12.8;

/// Where the tip stands above the ground at the start `[m]`.
const ABOVE: f64 = 0.02;

const UNIT_WEIGHT: f64 = 16.3;
const FRICTION: f64 = 0.3;

/// Half of the way over which means are taken `[m]`.
const HALF: f64 = 0.2;

/// Depths of the tip at which the resistance is told `[m]`.
const DEPTHS: [f64; 4] = [0.6, 1.8, 2.8, 3.8];

/// Depth from which it is compared `[m]`.
const DEEP: f64 = 1.8;

#[derive(Clone, Copy, PartialEq)]
struct Test {
    cells: u32,
    friction: f64,
    way: f64,
}

impl Test {
    fn name(self) -> String {
        let surface = if self.friction > 0.0 { "" } else { "smooth, " };
        format!("{surface}{} cells over a", self.cells)
    }

    /// Lines along the axis: fine from two cells above the ground to a diameter below the last place of the tip.
    fn heights(self) -> Vec<f64> {
        let size = RADIUS / f64::from(self.cells);
        let per_unit = |length: f64| length / RADIUS;
        // The unit of `lines` is the radius.
        let below = lines(self.cells, per_unit(4.8), 1.4, per_unit(DEPTH));
        let below = below.iter().rev().map(|z| -z * RADIUS);
        below.chain([1.0, 2.0, 4.0, 6.0].map(|k| k * size)).collect()
    }

    /// Way of the tip below the ground and resistance, and the largest imbalance of vertical forces over the largest
    /// force on the cone.
    fn path(self) -> Result<(Vec<(f64, f64)>, f64), Broken> {
        let radii = lines(self.cells, 1.5, 1.4, WIDTH / RADIUS).into_iter().map(|r| r * RADIUS);
        let steps = (self.way / RADIUS * f64::from(self.cells) * 5.0).round();
        let scene = changed(
            text("cone_sand")?,
            &[
                ("mesh.axes[0]", format!("Nodes({})", list(radii))),
                ("mesh.axes[1]", format!("Nodes({})", list(self.heights()))),
                ("tools[0].motion.by", format!("(0, {:?})", -self.way - ABOVE)),
                ("tools[0].interface.friction", format!("{:?}", self.friction)),
                ("schedule.steps", steps.to_string()),
                ("output.fields", "[]".into()),
            ],
        )?;
        let history = run(&scene)?.completed()?;
        let force = of_tool(&history, "cone", "force", 1);
        let base = history.series("reaction/base", 1);
        let weight = PI * WIDTH * WIDTH * DEPTH * UNIT_WEIGHT;
        let most = largest(force.iter().copied());
        // The base bears the ground and what pushes the cone.
        let rest = force.iter().zip(&base).skip(1).map(|(force, base)| (base - force - weight).abs() / most);
        let imbalance = largest(rest);
        let ways = history.rows().iter().map(|row| (self.way + ABOVE) * row.fraction - ABOVE);
        Ok((ways.zip(force).map(|(way, force)| (way, force / (PI * RADIUS * RADIUS))).collect(), imbalance))
    }
}

/// Mean resistance about a depth of the tip.
fn mean(path: &[(f64, f64)], depth: f64) -> f64 {
    let near: Vec<f64> = path.iter().filter(|it| (it.0 - depth).abs() <= HALF + 1e-9).map(|it| it.1).collect();
    near.iter().sum::<f64>() / near.len() as f64
}

/// Limit pressure of a spherical cavity in the sand at a depth (Yu & Houlsby 1991, equations of k = 2).
fn limit_of_cavity(depth: f64) -> f64 {
    let (poisson, cohesion) = (0.25, 0.3);
    let stress = UNIT_WEIGHT * depth;
    let at_rest = stress * (1.0 + 2.0 * 0.47) / 3.0;
    let young = 19_200.0 * (0.47 * stress / 100.0).powf(0.6);
    let shear = 0.5 * young / (1.0 + poisson);
    let passive = |degrees: f64| {
        let sine = degrees.to_radians().sin();
        (1.0 + sine) / (1.0 - sine)
    };
    let (alpha, beta) = (passive(32.0), passive(2.0));
    let yield_stress = 2.0 * cohesion * alpha.sqrt();
    let excess = yield_stress + (alpha - 1.0) * at_rest;
    let gamma = alpha * (beta + 2.0) / (2.0 * (alpha - 1.0) * beta);
    let delta = excess / (2.0 * (2.0 + alpha) * shear);
    let eta = ((beta + 2.0) * (1.0 - 2.0 * poisson) * excess / (young * (alpha - 1.0) * beta)).exp();
    let xi = 3.0 * delta / ((1.0 + poisson) * (alpha - 1.0) * beta)
        * (alpha * beta + 2.0 * (1.0 - 2.0 * poisson) + 2.0 * poisson - 2.0 * poisson * (alpha + beta));
    let series = |ratio: f64| {
        let (mut sum, mut term) = (0.0, 1.0);
        for n in 0..60 {
            let n = f64::from(n);
            sum += term / (n - gamma) * (ratio.powf(n - gamma) - 1.0);
            term *= xi / (n + 1.0);
        }
        sum
    };
    let wanted = eta / gamma * (1.0 - delta).powf((beta + 2.0) / beta);
    let (mut low, mut high) = (1.0, 1e3);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if series(middle) < wanted { low = middle } else { high = middle }
    }
    (low * alpha * 3.0 * excess / (2.0 + alpha) - yield_stress) / (alpha - 1.0)
}

/// Resistance between which the cone's is to lie.
fn band(depth: f64, friction: f64) -> [f64; 2] {
    let low = limit_of_cavity(depth) * (1.0 + friction * 3.0_f64.sqrt());
    [low, 157.0 * (UNIT_WEIGHT * depth).powf(0.55) * (2.41_f64 * 0.32).exp()]
}

fn cone(extent: Extent) -> Result<Findings, Broken> {
    let test = |cells: u32| Test { cells, friction: FRICTION, way: extent.pick(0.8, 4.0) };
    let coarse = [test(2)];
    let all = [test(4), Test { friction: 0.0, ..test(2) }, test(2)];
    let tests = extent.pick(&coarse[..], &all[..]);
    let runs: Vec<_> = tests.iter().zip(sweep(tests, |test| test.path())?).collect();
    let mut findings = Findings::default();
    let depths: Vec<f64> = DEPTHS.into_iter().filter(|depth| depth + HALF <= tests[0].way + 1e-9).collect();
    for (test, (path, imbalance)) in runs.iter().rev() {
        let name = test.name();
        let what = format!("{name}: base, weight and cone out of balance, over the largest force on the cone");
        findings.checks.push(Check::new(what, *imbalance, 1e-5));
        let shallow = [0.2, 0.4, 0.6].map(|depth| mean(path, depth));
        let grows = shallow.windows(2).filter(|pair| pair[1] > pair[0]).count();
        let falls = shallow.len() - 1 - grows;
        findings
            .checks
            .push(Check::none(format!("{name}: falls of the resistance from 0.2 to 0.4 and 0.6 m"), falls));
        for &depth in depths.iter().filter(|depth| **depth >= DEEP) {
            let ([low, high], found) = (band(depth, test.friction), mean(path, depth));
            let what = format!("{name}: resistance at {depth} m outside the band");
            let said = format!("{found:.0} in {low:.0} to {high:.0} kPa");
            findings.checks.push(Check::none(what, usize::from(!(low..=high).contains(&found))).remark(said));
        }
    }
    let heads: Vec<String> = depths.iter().map(|depth| format!("{depth} m")).collect();
    let heads: Vec<&str> = std::iter::once("cone").chain(heads.iter().map(String::as_str)).collect();
    let mut table = Table::new("Resistance, kPa, of cone and shaft at depths of the tip:", &heads);
    for (test, (path, _)) in runs.iter().rev() {
        table.push([test.name()].into_iter().chain(depths.iter().map(|&depth| fixed(mean(path, depth), 0))));
    }
    let of_band = |k: usize| depths.iter().map(move |&depth| fixed(band(depth, FRICTION)[k], 0));
    table.push(["spherical cavity and friction".to_owned()].into_iter().chain(of_band(0)));
    table.push(["calibration chambers".to_owned()].into_iter().chain(of_band(1)));
    findings.tables.push(table);
    if extent == Extent::Full {
        let at_end = |test: Test| {
            let of = runs.iter().find(|(of, _)| **of == test);
            of.map_or(f64::NAN, |(_, (path, _))| mean(path, 3.8))
        };
        let change = at_end(test(4)) / at_end(test(2)) - 1.0;
        let what = "resistance at 3.8 m, from 2 to 4 cells over a: change (relative)";
        findings.checks.push(Check::new(what, change.abs(), 0.1).remark(fixed(change, 4)));
    }
    Ok(findings)
}
