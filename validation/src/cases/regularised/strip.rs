//! A strip in tension whose material softens: on several meshes, and askew in them.

use super::super::{fixed, framed, largest, sweep};
use super::at;
use crate::picture::{Curve, Curves, Legend, Panel, Picture, Stroke};
use crate::scenes::{Run, changed, run, text};
use crate::variants::plane;
use crate::{Broken, Case, Check, Extent, Findings, Table};
use mpm_material::FieldInfo;
use mpm_scene::language::{FieldInput, MaterialInput, Scene};
use mpm_solver::observe::Field;

pub(in crate::cases) const STRIP: Case = Case {
    name: "strip that softens, regularised",
    goal: "With a nodal field that follows the plastic strain, a strip that softens where it is pulled apart has one load-displacement curve, whatever the size and the direction of the cells.",
    setup: "A strip, 1 × 2, of a clay that softens to 0.3 of its strength, pulled by 0.06 between smooth plates (walls) in 40 load steps; its lower left corner is weaker by a tenth. CPDI1, tiles half a cell wide, ghost faces; h = 7 times the fastest softening, l = 0.07, so that what flows is about 0.6 wide. 8 cells a unit of length (in the full run 16 and 24, too), along the strip and turned against it by 30°. Then without the field.",
    reference: "Each other: no other code is known that has it.",
    run: strips,
};

/// A strip in its mesh.
#[derive(Clone, Copy)]
struct Strip {
    /// Cells a unit of length.
    cells: u32,
    /// Angle between strip and mesh `[degrees]`.
    angle: f64,
    field: bool,
}

/// A run, its scene, and the force at the top against the part of the way.
struct Pulled {
    scene: Scene,
    run: Run,
    curve: (Vec<f64>, Vec<f64>),
}

impl Strip {
    fn name(&self) -> String {
        let field = if self.field { "" } else { "no field, " };
        format!("{field}{} cells, {}°", self.cells, self.angle)
    }

    fn scene(&self) -> Result<Scene, Broken> {
        let (sine, cosine) = self.angle.to_radians().sin_cos();
        let place = |x: f64, y: f64| [cosine * x - sine * y, sine * x + cosine * y];
        // As many cells beside the strip as its corners need, on the same lines on every mesh.
        let axis = |of: usize| {
            let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 2.0), (1.0, 2.0)].map(|(x, y)| place(x, y)[of]);
            let low = corners.iter().copied().fold(f64::INFINITY, f64::min);
            let high = corners.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let (from, to) = ((4.0 * low - 1.5).floor() / 4.0, (4.0 * high + 1.5).ceil() / 4.0);
            let cells = ((to - from) * f64::from(self.cells)).round();
            format!("Uniform(from: {from:?}, to: {to:?}, cells: {cells})")
        };
        let part = |x: f64, y: f64, width: f64, height: f64| {
            let [a, b] = place(x, y);
            let turned = self.angle;
            format!("Box(from: ({a:?}, {b:?}), to: ({:?}, {:?}), turned: {turned:?})", a + width, b + height)
        };
        let wall = |y: f64, up: f64| {
            let ([a, b], [nx, ny]) = (place(0.0, y), place(0.0, up));
            format!("Plane(through: ({a:?}, {b:?}), normal: ({nx:?}, {ny:?}))")
        };
        let [pull_x, pull_y] = place(0.0, WAY);
        let changes = [
            ("mesh.axes[0]", axis(0)),
            ("mesh.axes[1]", axis(1)),
            ("bodies[0].shape", part(0.0, 0.0, 0.25, 0.25)),
            ("bodies[1].shape", part(0.25, 0.0, 0.75, 0.25)),
            ("bodies[2].shape", part(0.0, 0.25, 1.0, 1.75)),
            ("walls[0].surface", wall(0.0, 1.0)),
            ("walls[1].surface", wall(0.0, 1.0)),
            ("walls[2].surface", wall(2.0, -1.0)),
            ("walls[2].motion", format!("Move(by: ({pull_x:?}, {pull_y:?}))")),
        ];
        let mut scene = plane(changed(text("soil/strip_softening")?, &changes)?)?;
        scene.output.fields = vec![FieldInput::Remembered("PlasticStrain".into())];
        for law in scene.materials.values_mut().filter(|_| !self.field) {
            if let MaterialInput::VonMises { gradient, .. } = law {
                *gradient = None;
            }
        }
        Ok(Scene::PlaneStrain(scene))
    }

    fn pull(&self) -> Result<Pulled, Broken> {
        let scene = self.scene()?;
        let run = run(&scene)?;
        let force = |component| run.history.series("wall/top/reaction", component);
        let force = force(0).into_iter().zip(force(1)).map(|(x, y)| x.hypot(y));
        let way = run.history.rows().iter().map(|row| row.fraction);
        let curve = (way.skip(1).collect(), force.skip(1).collect());
        Ok(Pulled { scene, run, curve })
    }
}

/// By how much the top is moved `[L]`.
const WAY: f64 = 0.06;

/// The width of the strip is 1, and forces are shown over the strength.
const STRENGTH: f64 = 100.0;

fn strips(extent: Extent) -> Result<Findings, Broken> {
    let job = |cells, angle, field| Strip { cells, angle, field };
    let jobs = extent.pick(
        vec![job(8, 0.0, true), job(8, 30.0, true)],
        vec![
            job(8, 0.0, true),
            job(16, 0.0, true),
            job(24, 0.0, true),
            job(8, 30.0, true),
            job(16, 30.0, true),
            job(24, 30.0, true),
            job(8, 0.0, false),
            job(16, 0.0, false),
            job(24, 0.0, false),
        ],
    );
    let found = sweep(&jobs, Strip::pull)?;
    let mut findings = Findings::default();
    let finest = (0..jobs.len()).rfind(|&k| jobs[k].field && jobs[k].angle == 0.0).unwrap_or(0);
    let heads = ["strip", "largest force", "force at the end", "largest difference", "ends at"];
    let title =
        "Forces over the undrained strength times the width, and the difference from the finest upright mesh.";
    let mut table = Table::new(title, &heads);
    let stations: Vec<f64> = (1..=40).map(|k| f64::from(k) / 40.0).collect();
    for (job, pulled) in jobs.iter().zip(&found) {
        let Pulled { curve, run, .. } = pulled;
        let end = curve.0.last().copied().unwrap_or(0.0);
        let inside = stations.iter().filter(|station| **station <= end + 1e-9);
        let apart = inside.map(|&station| (at(station, curve) / at(station, &found[finest].curve) - 1.0).abs());
        let apart = largest(apart);
        table.push([
            job.name(),
            fixed(largest(curve.1.iter().copied()) / STRENGTH, 4),
            fixed(curve.1.last().copied().unwrap_or(f64::NAN) / STRENGTH, 4),
            format!("{} %", fixed(100.0 * apart, 2)),
            fixed(end * WAY, 4),
        ]);
        if job.field {
            run.outcome.as_ref().map_err(|error| format!("{}: {error}", job.name()))?;
            let what = format!("{}: force against the finest upright mesh", job.name());
            findings.checks.push(Check::new(what, apart, if job.cells >= 16 { 0.005 } else { 0.01 }));
        } else {
            let agrees = end > 1.0 - 1e-9 && apart < 0.03;
            let what = format!("{}: a curve of its own, all the same", job.name());
            findings.checks.push(Check::none(what, usize::from(agrees)));
        }
    }
    findings.tables.push(table);
    if extent == Extent::Full {
        findings.pictures.extend([curves(&jobs, &found), bands(&jobs, &found)?]);
    }
    Ok(findings)
}

/// Forces against the way of the top.
fn curves(jobs: &[Strip], found: &[Pulled]) -> Picture {
    let panel = |field: bool| {
        let chosen = jobs.iter().zip(found).filter(|(job, _)| job.field == field);
        let curves = chosen.enumerate().map(|(k, (job, Pulled { curve, .. }))| Curve {
            name: job.name(),
            colour: k,
            stroke: if job.angle == 0.0 { Stroke::Line } else { Stroke::Dashes },
            points: curve.0.iter().zip(&curve.1).map(|(way, force)| (way * WAY, force / STRENGTH)).collect(),
        });
        Panel::Curves(Curves {
            title: format!("A strip that softens, {} field", if field { "with the" } else { "without a" }),
            axes: ["displacement of the top", "force over strength and width"].map(String::from),
            range: [(0.0, WAY), (0.0, 2.0)],
            logarithmic: [false; 2],
            legend: Legend::LowerRight,
            curves: curves.collect(),
        })
    };
    Picture {
        file: "strip_softening.svg",
        caption: "A strip that softens: force against the displacement of its top, on three meshes and turned in them.".into(),
        panels: vec![panel(true), panel(false)],
    }
}

/// The bands at the end, coloured by the plastic strain.
fn bands(jobs: &[Strip], found: &[Pulled]) -> Result<Picture, Broken> {
    let shown = |job: &Strip| job.cells != 24 && (job.angle == 0.0 || job.cells == 16);
    let mut panels = Vec::new();
    for (job, Pulled { scene, run, .. }) in jobs.iter().zip(found).filter(|(job, _)| shown(job)) {
        let last = run.history.rows().len() - 1;
        let info = FieldInfo { name: "plastic_strain", components: 1, unit: "-" };
        let strain = run.history.field(Field::from(info), last);
        let most = largest(strain.iter().copied()).max(f64::MIN_POSITIVE);
        let frame = run.history.last_frame();
        let (sine, cosine) = job.angle.to_radians().sin_cos();
        let range = [(-2.0 * sine - 0.15, cosine + 0.15), (-0.15, sine + 2.0 * cosine + 0.2)];
        let mut shades = strain.iter().map(|kappa| kappa / most);
        let shade = |_: &[[f64; 3]]| 0.0;
        let Panel::Shapes(mut shapes) = framed(job.name(), scene, &frame, range, shade)? else { continue };
        shapes.patches.iter_mut().for_each(|patch| patch.value = shades.next().unwrap_or(0.0));
        shapes.lines.clear();
        panels.push(Panel::Shapes(shapes));
    }
    Ok(Picture {
        file: "strip_bands.png",
        caption: "The strip at the end of its run, coloured by the plastic strain over its largest: with the field the same zone on every mesh, without it a band of a few points, which is as wide as the mesh lets it be.".into(),
        panels,
    })
}
