//! Strips that a frame rolls up.

use super::super::{framed, largest, sweep};
use crate::history::History;
use crate::picture::{Panel, Picture};
use crate::scenes::{changed, compiled};
use crate::{Broken, Case, Check, Extent, Findings};
use mpm_solver::observe::Field;
use std::f64::consts::TAU;

pub(in crate::cases) const STRIP: Case = Case {
    name: "rolled cantilever",
    goal: "A strip is rolled up through a full circle, and further, by a moment at its end, and back: the angle is that of bending at finite strain, which in the slender limit is M = E I κ, and the strip is straight again.",
    setup: "A strip of 16 by 0.5, E = 1200, ν = 0, on splines of degree 2, clamped at one end; a frame that is free to move and turn holds the other one and has a moment, which grows and then falls to nothing. 4 tiles through the height, in the full run 8, too. A strip with the same E everywhere is rolled to eleven twelfths of a circle: its ends would meet at the full one, and ends that have less than two cells between them share functions of the mesh and stick to each other. One whose E falls to a half towards the frame is rolled to a full circle, and in the full run one whose E falls to three tenths to a circle and a quarter: their free ends curl in beside the clamped ones.",
    reference: "∫ κ ds with the moment of a strip bent to κ, M = E I κ (1 − 0.3 (κ h)² + …), from its equilibrium across the height h, integrated in one dimension. Strain is the same all over a tile, so that n tiles through the height have I (1 − 1/n²); moments are as large as slender strips of so many tiles need.",
    run: strips,
};

/// Length and height of a strip `[L]`, and E at the clamped end `[F/L²]`.
const LENGTH: f64 = 16.0;
const HEIGHT: f64 = 0.5;
const YOUNG: f64 = 1200.0;

/// An upright strip that a frame rolls up to the left and lets go of again.
const SCENE: &str = r#"PlaneStrain(
    mesh: Box(axes: [Uniform(from: -12.88, to: 1.12, cells: 56), Uniform(from: -4.13, to: 17.12, cells: 85)], functions: Splines(degree: 2)),
    basis: Cpdi2q, stabilisation: Ghost(factor: 1e-5), materials: { "steel": Hencky(young: 1200, poisson: 0) },
    bodies: [(name: "strip", material: "steel", shape: Box(from: (0, 0), to: (0.5, 16)), points_per_cell: 2, tiling: Shape)],
    walls: [
        (name: "clamp", body: "strip", side: "bottom", hold: All),
        (name: "tip", body: "strip", side: "top", hold: All, moment_about: (0.25, 16),
            motion: Loaded(free: [X, Y, Turn], moment: 1, ramp: [(0, 0), (0.5, 1), (1, 0)])),
    ],
    schedule: (steps: 96), output: (fields: [CauchyStress]),
)"#;

/// A strip that is to be rolled up.
#[derive(Clone, Copy)]
struct Strip {
    /// Turns of a slender strip.
    turns: f64,
    /// By how much E falls towards the frame, over that at the clamped end.
    softer: f64,
    points_per_cell: u32,
}

impl Strip {
    /// Tiles through the height.
    fn tiles(&self) -> f64 {
        f64::from(2 * self.points_per_cell)
    }

    fn name(&self) -> String {
        let softer = if self.softer > 0.0 {
            format!(", E down to {:.1} of it", 1.0 - self.softer)
        } else {
            String::new()
        };
        format!("{:.0}°{softer}, {} tiles", 360.0 * self.turns, self.tiles())
    }

    /// E over that at the clamped end.
    fn stiffness(&self, part: f64) -> f64 {
        1.0 - self.softer * part
    }

    /// κ E/M I at the clamped end of a slender strip, over its whole angle: 1/L where E is the same everywhere `[1/L]`.
    fn curvature(&self) -> f64 {
        let mean = if self.softer > 0.0 { -(-self.softer).ln_1p() / self.softer } else { 1.0 };
        TAU * self.turns / (LENGTH * mean)
    }

    /// Angle at the full moment by bending at finite strain `[degrees]`.
    fn angle(&self) -> f64 {
        let n = 64;
        let angle = |k: i32| {
            let slender = self.curvature() / self.stiffness((f64::from(k) + 0.5) / f64::from(n));
            // The moment of a slender strip of this curvature bends one of this height further.
            let bent = (0..8).fold(slender, |bent, _| slender * slender_moment(bent) / moment(bent));
            bent * LENGTH / f64::from(n)
        };
        (0..n).map(angle).sum::<f64>().to_degrees()
    }

    fn rolled(&self) -> Result<Rolled, Broken> {
        let whole = YOUNG * slender_moment(self.curvature()) * (1.0 - self.tiles().powi(-2));
        let gradient = YOUNG * self.softer / LENGTH;
        let young = format!("Linear(at: 0, value: {YOUNG:?}, gradient: {gradient:?})");
        let scene = changed(
            SCENE.into(),
            &[
                ("bodies[0].points_per_cell", self.points_per_cell.to_string()),
                ("walls[1].motion.moment", format!("{whole:?}")),
                ("materials.steel.young", if self.softer > 0.0 { young } else { format!("{YOUNG:?}") }),
            ],
        )?;
        let mut history = History::of(&[Field::CAUCHY_STRESS]).with_frames([0.125, 0.25, 0.5]);
        compiled(&scene)?.run(&mut history)?;
        let angle = largest(history.series("wall/tip/angle", 0));
        let last = history.rows().len() - 1;
        let tip = [0, 1].map(|d| history.series("wall/tip/position", d)[last]);
        let stress = largest(history.field(Field::CAUCHY_STRESS, last).iter().map(|s| s.abs()));
        let away = (tip[0] - 0.5 * HEIGHT).hypot(tip[1] - LENGTH);
        let panels = history.frames().iter().map(|frame| {
            let title = format!("{:.0} % of the moment", 200.0 * frame.fraction);
            framed(title, &scene, frame, [(-12.5, 1.2), (-2.2, 12.0)], |_| 0.4)
        });
        let panels = panels.collect::<Result<_, _>>()?;
        Ok(Rolled { angle, away: away / LENGTH, stress: stress / YOUNG, panels })
    }
}

/// What became of a strip.
struct Rolled {
    /// The largest angle of the frame `[degrees]`.
    angle: f64,
    /// How far the tip is from where it was, over the length, and the stress that is left, over E.
    away: f64,
    stress: f64,
    panels: Vec<Panel>,
}

/// M/E of a slender strip bent to a curvature `[L²]`.
fn slender_moment(curvature: f64) -> f64 {
    HEIGHT.powi(3) / 12.0 * curvature
}

/// M/E of a strip bent to a curvature κ, with ν = 0 `[L²]`. Its fibres at the rest heights Y stand at the radii r(Y): with the energy
/// ½ E (ln² κr + ln² r') the radial stress P = E ln r'/r' has P' = E ln(κr)/r, and is nothing at both faces; M is E/κ ∫ ln κr dY.
fn moment(curvature: f64) -> f64 {
    let stretch = |p: f64| (0..8).fold(1.0 + p, |s: f64, _| s - (s.ln() / s - p) * s * s / (1.0 - s.ln()));
    let rate = |[r, p]: [f64; 2]| [stretch(p), (curvature * r).ln() / r];
    let steps = 64;
    let h = HEIGHT / f64::from(steps);
    // P at the outer face and the moment, with the inner face at a radius.
    let across = |inner: f64| {
        let (mut y, mut sum) = ([inner, 0.0], 0.0);
        for _ in 0..steps {
            let step = |rate: [f64; 2], by: f64| [y[0] + by * rate[0], y[1] + by * rate[1]];
            let a = rate(y);
            let b = rate(step(a, 0.5 * h));
            let middle = step(b, 0.5 * h);
            let c = rate(middle);
            let d = rate(step(c, h));
            let end = [0, 1].map(|i| y[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]));
            let log = |r: f64| (curvature * r).ln();
            sum += h / 6.0 * (log(y[0]) + 4.0 * log(middle[0]) + log(end[0]));
            y = end;
        }
        (y[1], sum / curvature)
    };
    let mut ends = [1.0 / curvature - HEIGHT, 1.0 / curvature];
    for _ in 0..50 {
        let middle = 0.5 * (ends[0] + ends[1]);
        ends[usize::from(across(middle).0 > 0.0)] = middle;
    }
    across(ends[0]).1
}

fn strips(extent: Extent) -> Result<Findings, Broken> {
    let uniform = Strip { turns: 11.0 / 12.0, softer: 0.0, points_per_cell: 2 };
    let circle = Strip { turns: 1.0, softer: 0.5, points_per_cell: 2 };
    let further = Strip { turns: 1.25, softer: 0.7, points_per_cell: 2 };
    let fine = |strip: Strip| Strip { points_per_cell: 4, ..strip };
    let all = [uniform, circle, fine(uniform), fine(circle), further, fine(further)];
    let jobs = &all[..extent.pick(2, 6)];
    let mut found = sweep(jobs, Strip::rolled)?;
    let mut findings = Findings::default();
    let slender = moment(1e-3) / slender_moment(1e-3);
    findings.checks.push(Check::new(
        "the reference: M over E I κ of a slender strip, off 1",
        (slender - 1.0).abs(),
        1e-6,
    ));
    for (job, Rolled { angle, away, stress, .. }) in jobs.iter().zip(&found) {
        let (name, expected) = (job.name(), job.angle());
        let most = if job.points_per_cell == 2 { 3e-3 } else { 1e-3 };
        let of_slender = 360.0 * job.turns;
        // Fibres are strained by a quarter beyond a full circle.
        let left = if job.turns > 1.0 { 4e-4 } else { 2e-4 };
        findings.checks.push(
            Check::new(format!("{name}: angle at the full moment"), (angle / expected - 1.0).abs(), most)
                .remark(format!("{angle:.2}° for {expected:.2}°, slender {of_slender:.0}°")),
        );
        findings.checks.push(Check::new(format!("{name}: the tip is back, over the length"), *away, 1e-4));
        findings.checks.push(Check::new(format!("{name}: stress that is left, over E"), *stress, left));
    }
    if extent == Extent::Full {
        findings.pictures.push(Picture {
            file: "rolled_strip.png",
            caption: "A strip whose E falls to three tenths towards its free end, at a quarter of the moment, at a half, and at the whole, which rolls it to a circle and a quarter; it then goes back.".into(),
            panels: found.pop().map_or_else(Vec::new, |it| it.panels),
        });
    }
    Ok(findings)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first term beyond the slender strip's, −0.3 (κ h)².
    #[test]
    fn a_strip_bent_far_is_softer() {
        let off = |curvature: f64| {
            (1.0 - moment(curvature) / slender_moment(curvature)) / (curvature * HEIGHT).powi(2)
        };
        assert!((off(0.1) - 0.3).abs() < 1e-3, "{}", off(0.1));
    }
}
