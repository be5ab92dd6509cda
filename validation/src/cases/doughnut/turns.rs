//! The slides' doughnut carried on for two turns.

use super::super::{domains::doughnut_to, fixed, framed, largest, sweep};
use crate::history::{Frame, History};
use crate::picture::{Curve, Curves, Legend, Panel, Picture, Shapes, Stroke};
use crate::problems::doughnut::{EXACT_AT_20, torque};
use crate::scenes::Run;
use crate::variants::{
    BACKSLASH, CPDI1, CPDI2Q, CROSS, Method, PlaneScene, SLASH, SMPM, falling_back, with_control,
};
use crate::{Broken, Case, Check, Extent, Findings, Table};
use mpm_scene::compile;
use mpm_scene::language::{ControlInput, Count, Positive, Scene};
use mpm_solver::{Error, StepFailure};

pub(in super::super) const CASE: Case = Case {
    name: "doughnut twist, full turns",
    goal: "How far does each basis go on, what ends it, and do the remedies for domains help?",
    setup: "The slides' doughnut (ρ_y = E = 10⁶, 5 × 32 cells, 1° a load step, up to 100 corrections, whole cells taken off) turned on to two full turns: every basis as published, then with points that fall back to parallelograms and with domains shortened to one cell.",
    reference: "Torques of an independent implementation at 45°, 90° and 180°, to two digits; quadrilaterals that are not convex from 44° on. In one dimension, with the same five elements, the torque peaks at 9.74·10⁷ (32°) and falls to 5.86 (57°), 4.50 (115°), 4.30·10⁷ (172°).",
    run,
};

/// One-dimensional torque over 10⁷ on five elements, against the angle in degrees.
const ONE_DIMENSION: [(f64, f64); 4] = [(32.0, 9.74), (57.0, 5.86), (115.0, 4.50), (172.0, 4.30)];

/// Angles of the frames in degrees.
const FRAMES: [u32; 6] = [0, 30, 60, 90, 180, 360];

#[derive(Clone, Copy, Debug, PartialEq)]
enum Remedy {
    None,
    /// Falling back beyond so much distortion.
    Fallback(f64),
    /// Shortened to so many cells.
    Cap(f64),
}

impl Remedy {
    fn name(self) -> String {
        match self {
            Remedy::None => "as published".into(),
            Remedy::Fallback(beyond) => format!("fallback beyond {beyond}"),
            Remedy::Cap(cells) => format!("domains of {cells} cell at most"),
        }
    }

    fn apply(self, scene: PlaneScene) -> PlaneScene {
        match self {
            Remedy::None => scene,
            Remedy::Fallback(beyond) => falling_back(scene, beyond),
            Remedy::Cap(cells) => with_control(scene, ControlInput::Cap { cells: Positive(cells) }),
        }
    }
}

struct Job {
    method: Method,
    remedy: Remedy,
    /// Torques over 10⁷ at 45°, 90° and 180° of an independent implementation.
    known: Option<[f64; 3]>,
}

fn jobs(extent: Extent) -> Vec<Job> {
    let job = |method, remedy, known| Job { method, remedy, known };
    let mut jobs =
        vec![job(SMPM, Remedy::None, Some([3.6, 3.1, 3.3])), job(CPDI1, Remedy::None, Some([5.4, 5.1, 5.9]))];
    if extent == Extent::Full {
        jobs.push(job(CPDI2Q, Remedy::None, Some([6.0, 7.0, 6.6])));
        jobs.push(job(SLASH, Remedy::None, Some([8.2, 16.8, 28.2])));
        jobs.push(job(BACKSLASH, Remedy::None, None));
        jobs.push(job(CROSS, Remedy::None, None));
        jobs.push(job(CPDI2Q, Remedy::Fallback(0.5), None));
        jobs.extend([SLASH, BACKSLASH, CROSS].map(|method| job(method, Remedy::Fallback(2.0), None)));
        jobs.extend([CPDI1, CPDI2Q, SLASH].map(|method| job(method, Remedy::Cap(1.0), None)));
    }
    jobs
}

/// A run and its scene.
struct Turned {
    scene: Scene,
    run: Run,
    degrees: f64,
}

impl Turned {
    fn of(job: &Job, degrees: u32) -> Result<Self, Broken> {
        let mut scene = job.remedy.apply(doughnut_to(&job.method, degrees)?);
        scene.output.domain_history = true;
        // Needles take many corrections.
        scene.tolerance.iterations = Count(100);
        scene.output.fields.clear();
        let scene = Scene::PlaneStrain(scene);
        let degrees = f64::from(degrees);
        let frames = FRAMES.map(|angle| f64::from(angle) / degrees);
        let mut history = History::default().with_outlines().with_frames(frames);
        let outcome = compile(&scene)?.run(&mut history);
        Ok(Self { scene, run: Run { history, outcome }, degrees })
    }

    /// Angle reached in degrees.
    fn reached(&self) -> f64 {
        self.degrees * self.run.history.last().fraction
    }

    /// A column against the angle in degrees, without the initial state.
    fn series(&self, column: &str) -> Vec<(f64, f64)> {
        let angles = self.run.history.rows().iter().map(|row| self.degrees * row.fraction);
        angles.zip(self.run.history.series(column, 0)).skip(1).collect()
    }

    /// Torque over 10⁷ against the angle in degrees.
    fn curve(&self) -> Vec<(f64, f64)> {
        let angles = self.run.history.rows()[1..].iter().map(|row| self.degrees * row.fraction);
        angles.zip(torque(&self.run.history)).map(|(angle, torque)| (angle, torque / 1e7)).collect()
    }

    /// Torque over 10⁷ at an angle in degrees; not a number where the run did not get there.
    fn torque(&self, angle: f64) -> f64 {
        let curve = self.curve();
        curve.iter().find(|(at, _)| (at - angle).abs() < 1e-6).map_or(f64::NAN, |&(_, torque)| torque)
    }

    /// First angle in degrees at which a column is such, if it ever is.
    fn first(&self, column: &str, is: impl Fn(f64) -> bool) -> Option<f64> {
        self.series(column).into_iter().find(|&(_, value)| is(value)).map(|(angle, _)| angle)
    }

    /// Why the run ended before its time, in few words.
    fn reason(&self) -> String {
        match &self.run.outcome {
            Ok(_) => "-".into(),
            Err(Error::Step { reason, .. }) => match reason {
                StepFailure::NotConverged { .. } => "no equilibrium".into(),
                StepFailure::Inverted { .. } => "a point would be inverted".into(),
                StepFailure::NoReturn { reason, .. } => reason.to_string(),
                StepFailure::Outside { .. } => "a domain reaches too far out of the mesh".into(),
                StepFailure::Advance { .. } => "a domain turned inside out".into(),
                other => other.to_string(),
            },
            Err(other) => other.to_string(),
        }
    }

    /// Iterations a load step (mean, largest), halvings, steps balanced in stages.
    fn effort(&self) -> String {
        let history = &self.run.history;
        let sum = |column: &str| history.series(column, 0).iter().sum::<f64>();
        let iterations = history.series("newton_iterations", 0);
        let mean = sum("newton_iterations") / (iterations.len() - 1) as f64;
        let staged = history.series("stages", 0).iter().filter(|&&stages| stages > 0.0).count();
        let mut effort = format!("{mean:.1} / {}; {} halvings", largest(iterations), sum("cuts"));
        if staged > 0 {
            effort += &format!(", {staged} in stages");
        }
        effort
    }

    /// The worst of the domains in the run, and since when they are bad.
    fn domains(&self, method: &Method) -> String {
        let least = |column: &str| self.series(column).iter().fold(f64::INFINITY, |a, &(_, b)| a.min(b));
        let volume = least("smallest_volume_ratio");
        let since = |what: &str, angle: Option<f64>| match angle {
            Some(angle) => format!("{what} from {angle:.0}° on"),
            None => format!("never {what}"),
        };
        let distortion = largest(self.series("domain_largest_distortion").iter().map(|&(_, it)| it));
        if *method == CPDI2Q {
            let weight = least("domain_smallest_corner_weight");
            let concave = self.first("domain_largest_distortion", |it| it > 1.0);
            let negative = self.first("domain_smallest_corner_weight", |it| it < 0.0);
            format!(
                "{}; {}; distortion {}, weights {}, area {}",
                since("concave", concave),
                since("with weights below 0", negative),
                two(distortion),
                two(weight),
                two(volume)
            )
        } else if method.triangles.is_some() {
            let halved = self.first("domain_smallest_measure", |it| it < 0.5);
            let area = least("domain_smallest_measure");
            format!(
                "{}; distortion {}, area {}",
                since("below half the area", halved),
                two(distortion),
                two(area)
            )
        } else {
            format!("volume {}", two(volume))
        }
    }

    /// Longest domain of the last frame at an angle or before, in cells at rest.
    fn longest(&self, angle: f64) -> f64 {
        let mut frames = self.run.history.frames().iter();
        let frame = frames.rfind(|frame| frame.fraction * self.degrees <= angle + 1e-6);
        frame.map_or(0.0, |frame| largest(frame.outlines.iter().map(|corners| length(corners))))
    }
}

/// Two digits.
fn two(x: f64) -> String {
    if (0.095..999.5).contains(&x.abs()) { format!("{x:.2}") } else { format!("{x:.1e}") }
}

/// Largest distance between corners of a domain; cells are as long as 1 across the ring.
fn length(corners: &[[f64; 3]]) -> f64 {
    let between = |a: &[f64; 3], b: &[f64; 3]| (a[0] - b[0]).hypot(a[1] - b[1]);
    largest(corners.iter().flat_map(|a| corners.iter().map(move |b| between(a, b))))
}

fn run(extent: Extent) -> Result<Findings, Broken> {
    let jobs = jobs(extent);
    let turned = sweep(&jobs, |job| Turned::of(job, extent.pick(360, 720)))?;

    let mut findings = Findings::default();
    for (job, it) in jobs.iter().zip(&turned) {
        let name = job.method.name;
        if job.remedy == Remedy::None && (job.method == SMPM || job.method == CPDI1) {
            findings.checks.push(
                Check::new(format!("{name}: degrees short of 360"), (360.0 - it.reached()).max(0.0), 0.0)
                    .remark(format!("{:.0}° in all; iterations {}", it.reached(), it.effort())),
            );
        }
        if let Some(known) = job.known {
            let found = [45.0, 90.0, 180.0].map(|angle| it.torque(angle));
            let off = largest(found.iter().zip(known).map(|(a, b)| (a - b).abs()));
            let what = format!("{name}: torque over 10⁷ at 45°, 90°, 180° against {known:?}");
            findings.checks.push(Check::new(what, off, 0.06).remark(found.map(|t| fixed(t, 2)).join(", ")));
        }
        if job.method == CPDI2Q && job.remedy == Remedy::None {
            let at = it.first("domain_largest_distortion", |it| it > 1.0).unwrap_or(f64::NAN);
            let what = "CPDI2q: angle from which a domain is not convex against 44° (degrees)";
            findings.checks.push(Check::new(what, (at - 44.0).abs(), 1.0).remark(format!("{at:.0}°")));
        }
    }
    findings.tables.push(table(&jobs, &turned));
    if extent == Extent::Full {
        findings.pictures.push(curves(&jobs, &turned));
        findings.pictures.push(frames(&jobs, &turned)?);
    }
    Ok(findings)
}

const TEXT: &str = "Standard MPM and parallelograms go on for more than a turn, and the torque of standard MPM stays near the one-dimensional one for two. Parallelograms become needles of many cells' length that take the mesh's motion at their far ends for their own: the torque swings between a half and twice its elastic peak, and the run ends when a needle reaches more than half a cell out of the mesh. From about 300° on rounding breaks the ring's symmetry: with 25 corrections at most, arithmetic that differs in the last place decided whether a run ended at 291° or at 368°. Quadrilaterals are concave from 44° on, as nothing resists their hourglass modes, and have negative weights from 74° on; the torque drifts up as their area goes. Triangles lose their area (with them it is the point's volume): slivers that cannot shear without being compressed, and the torque grows without bound until no equilibrium is found. Falling back brings the torques of both down to those of parallelograms, needles included. Domains that are kept as short as a cell keep the torque at or below the elastic peak for two turns with CPDI1; load steps are halved where domains are cut, and points of one cell may still lose volume to each other. That does not cure triangles, which are slivers before they are long.\n\nDistortion: above 1 a quadrilateral is concave; of a triangle it is √(2A) over its smallest height, 1.4 at rest. Areas and volumes over those at rest:";

fn table(jobs: &[Job], turned: &[Turned]) -> Table {
    let heads = [
        "basis",
        "remedy",
        "error at 20°",
        "reached",
        "torque / 10⁷ at 45, 90, 180, 360°",
        "largest",
        "longest domain to 360°",
        "worst of the domains",
        "iterations: mean / most",
        "ended by",
    ];
    let mut table = Table::new(TEXT, &heads);
    for (job, it) in jobs.iter().zip(turned) {
        let torques: Vec<String> = [45.0, 90.0, 180.0, 360.0]
            .iter()
            .map(|&angle| it.torque(angle))
            .filter(|torque| !torque.is_nan())
            .map(|torque| fixed(torque, 1))
            .collect();
        let peak = largest(it.curve().iter().map(|&(_, torque)| torque));
        let longest = it.longest(360.0);
        table.push([
            job.method.name.into(),
            job.remedy.name(),
            format!("{:+.1e}", it.torque(20.0) * 1e7 / EXACT_AT_20 - 1.0),
            format!("{:.0}°", it.reached()),
            torques.join(", "),
            if peak < 1000.0 { fixed(peak, 1) } else { format!("{peak:.0e}") },
            if longest > 0.0 { format!("{} cells", fixed(longest, 1)) } else { "-".into() },
            it.domains(&job.method),
            it.effort(),
            it.reason(),
        ]);
    }
    table
}

/// Torque against the angle: as published, and with remedies.
fn curves(jobs: &[Job], turned: &[Turned]) -> Picture {
    const MOST: f64 = 30.0;
    let panel = |title: &str, remedied: bool| {
        let chosen = jobs.iter().zip(turned).filter(|(job, _)| (job.remedy != Remedy::None) == remedied);
        let mut curves: Vec<Curve> = chosen
            .enumerate()
            .map(|(colour, (job, it))| Curve {
                name: match job.remedy {
                    Remedy::None => job.method.name.into(),
                    Remedy::Fallback(_) => format!("{}, fallback", job.method.name),
                    Remedy::Cap(_) => format!("{}, shortened", job.method.name),
                },
                colour,
                stroke: Stroke::Line,
                points: it.curve().into_iter().take_while(|&(_, torque)| torque <= MOST).collect(),
            })
            .collect();
        curves.push(Curve {
            name: "one dimension".into(),
            colour: 7,
            stroke: Stroke::Marks,
            points: ONE_DIMENSION.to_vec(),
        });
        Panel::Curves(Curves {
            title: title.into(),
            axes: ["angle of the inner edge (degrees)", "torque / 10⁷"].map(String::from),
            range: [(0.0, 720.0), (0.0, MOST)],
            logarithmic: [false; 2],
            legend: Legend::UpperRight,
            curves,
        })
    };
    Picture {
        file: "doughnut_turns.svg",
        caption: "Two turns of the slides' doughnut, 5 × 32 cells: torque against the angle, as published and with remedies.".into(),
        panels: vec![panel("As published", false), panel("With remedies", true)],
    }
}

/// Domains at several angles, a row for each basis.
fn frames(jobs: &[Job], turned: &[Turned]) -> Result<Picture, Broken> {
    let mut panels = Vec::new();
    for (job, it) in jobs.iter().zip(turned) {
        if job.remedy != Remedy::None || ![CPDI1, CPDI2Q, SLASH].contains(&job.method) {
            continue;
        }
        let mut frames: Vec<Frame> = it.run.history.frames().to_vec();
        // Where the run ended before, its end stands for the rest.
        if frames.len() < FRAMES.len() {
            frames.push(it.run.history.last_frame());
        }
        for k in 0..FRAMES.len() {
            let Some(frame) = frames.get(k) else {
                panels.push(Panel::Shapes(Shapes { range: [(0.0, 1.0); 2], ..Shapes::default() }));
                continue;
            };
            let angle = frame.fraction * it.degrees;
            let title = format!("{}, {angle:.0}°", job.method.name);
            // From half a cell, as at rest, to three cells.
            let shade = |corners: &[[f64; 3]]| (length(corners) - 1.0) / 3.0;
            panels.push(framed(title, &it.scene, frame, [(0.0, 7.6), (0.0, 7.6)], shade)?);
        }
    }
    Ok(Picture {
        file: "doughnut_turns.png",
        caption: "Domains of the slides' doughnut in the first quadrant near the inner edge, coloured from blue to red by their length (1 to 4 cells), and the mesh in red.".into(),
        panels,
    })
}
