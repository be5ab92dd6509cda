//! What a run will have to do and to hold, found by connecting the points once.

mod driven;
mod initial;
mod rehearsal;
mod remarks;
mod sizes;
mod start;

use crate::connection::{Connected, lines, places};
use crate::error::Error;
use crate::failure::StepFailure;
use crate::model::{Active, Model, NamedBody, UnheldMotion};
use crate::ranks::{Ranks, count};
use crate::remedy::advice;
use crate::rigid::unheld_at_start;
use crate::steps::stations;
use mpm_assembly::{Constraints, OccupiedCell, of_points, views};
use mpm_grid::{LoadFraction, Mesh};
use mpm_linear::{Prediction, predict};
pub use rehearsal::Seconds;
use rehearsal::{Rehearsal, are_pushed, is_iterative, rehearse};
pub use remarks::doubts;
pub use sizes::Memory;
use sizes::{Sizes, sizes, sizes_once_moved};
use start::{connected, supported};

/// Size of a model at the start of its first load step.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// Dimensions of space.
    pub dimensions: usize,
    /// Material points.
    pub points: usize,
    /// Cells of the mesh.
    pub cells: usize,
    /// Cells in which a material point lies.
    pub cells_with_material: usize,
    /// Nodes of the mesh.
    pub nodes: usize,
    /// Nodes that carry material.
    pub active_nodes: usize,
    /// Components of displacement to be found.
    pub equations: usize,
    /// Components of displacement of active nodes that supports prescribe.
    pub prescribed: usize,
    /// Stored entries of the tangent, its lower triangle.
    pub tangent_entries: usize,
    /// Stored entries of the triangular factor once bodies have moved; about, where the solver is iterative.
    pub factor_entries: usize,
    /// Whether linear systems are solved by iteration.
    pub is_iterative: bool,
    /// What the two solvers would cost.
    pub prediction: Prediction,
    /// How long its parts take.
    pub seconds: Seconds,
    /// Nominal load steps; those that end at knots of ramps between the equal ones are among them.
    pub steps: u32,
    /// The same of every stage.
    pub stages: Vec<StageSteps>,
    /// Volume and mass of every body.
    pub volumes: Vec<BodyVolume>,
    /// Rigid tools, and what else has a size of its own: a clause for each.
    pub tools: Vec<String>,
    /// What in the model is probably not meant, then what is good to know: sentences for people.
    pub remarks: Vec<String>,
    /// Columns of the points that are not stored for any body, because the scene needs them nowhere.
    pub columns_not_stored: Vec<&'static str>,
    /// Where the memory goes.
    pub memory: Memory,
    /// What will end the run, or may do so, and what the scene can have against it.
    pub warnings: Vec<String>,
}

/// A stage of the schedule in an [`Estimate`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StageSteps {
    /// Its name; empty where there is no other.
    pub name: String,
    /// Nominal load steps, those included that end at knots of ramps.
    pub steps: u32,
    /// Names of the supports that begin with it; in the first stage none are named.
    pub begun: Vec<String>,
    /// Names of the supports that end in it.
    pub ended: Vec<String>,
}

/// Volume of a body, told by its points and by its shape.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyVolume {
    /// Name of the body.
    pub body: String,
    /// Sum of its points' volumes `[L^D]`.
    pub points: f64,
    /// Volume of the shape, where it is known: of a surface, by the divergence theorem `[L^D]`.
    pub shape: Option<f64>,
    /// Mass of its points, where its density is known `[M]`.
    pub mass: Option<f64>,
}

/// See [`crate::estimate()`].
pub(crate) fn estimate<const D: usize>(model: &mut Model<D>) -> Result<Estimate, Error> {
    model.check()?;
    model.check_whole()?;
    let mesh = model.motion.mesh_at(&model.layout, LoadFraction::START);
    let mesh = mesh.map_err(|it| Error::Start(StepFailure::Mesh(it.to_string())))?;
    let nominal = nominal_steps(model);
    let may_move = nominal > 1 || are_pushed(model);
    let once_moved = if may_move { sizes_once_moved(model)? } else { None };
    let (connected, connect) = connected(model, &mesh)?;
    let Connected { active, pattern, .. } = &connected;

    let constraints = supported(model, active, 0);
    let (lattice, lines) = (active.lattice_indices(), lines(model));
    let places = places(model, &lattice, &lines);
    let prediction = predict(pattern.for_solver(), places);
    let stage = Rehearsal {
        model,
        mesh: &mesh,
        connected: &connected,
        connect,
        constraints: &constraints,
        places,
        prediction: &prediction,
    };
    let seconds = rehearse(&stage)?;
    // Of a solver of one's own nothing is known; it is taken to factorise.
    let is_iterative = is_iterative(&stage);
    let sizes = once_moved.map_or_else(|| sizes(&stage), Ok)?;
    let Sizes { factor_entries, memory } = sizes;

    let per_body: Vec<_> = model.bodies.iter().map(|named| named.body.columns()).collect();
    let stored: usize = per_body.iter().flatten().map(|(_, bytes)| bytes).sum();
    let n_points = model.bodies.iter().map(|named| named.body.n_points()).sum::<usize>();
    let stages: Vec<StageSteps> = (0..model.stages.len() as u32).map(|stage| steps_of(model, stage)).collect();
    let (entries, n) = (pattern.n_entries(), pattern.n_equations());
    Ok(Estimate {
        dimensions: model.coordinates(),
        points: n_points,
        cells: mesh.lattice().n_cells(),
        cells_with_material: cells_with_material(model, &mesh),
        nodes: model.n_nodes(),
        active_nodes: active.len(),
        equations: constraints.n_free(),
        prescribed: n - constraints.n_free(),
        tangent_entries: entries,
        factor_entries,
        seconds,
        steps: stages.iter().fold(0, |sum, stage| stage.steps.saturating_add(sum)),
        stages,
        volumes: model.bodies.iter().map(volume).collect(),
        tools: sizes_of_tools(model),
        remarks: {
            let unbalanced = initial::of(model, &mesh, &connected, &constraints);
            let good_to_know = remarks::good_to_know(model, &mesh, active);
            remarks::of(model, &mesh, active).into_iter().chain(unbalanced).chain(good_to_know).collect()
        },
        columns_not_stored: columns_not_stored(&model.bodies),
        memory: Memory {
            points: 2 * stored,
            work: memory.work + 2 * 3 * size_of::<f64>() * n_points + kept_records(n_points, nominal),
            ..memory
        },
        is_iterative,
        prediction,
        warnings: warnings(model, &mesh, &connected, &constraints),
    })
}

/// Load steps of all stages, without those that end at knots of ramps.
fn nominal_steps<const D: usize>(model: &Model<D>) -> u32 {
    model.stages.iter().fold(0_u32, |sum, stage| sum.saturating_add(stage.steps))
}

fn steps_of<const D: usize>(model: &Model<D>, stage: u32) -> StageSteps {
    let named = |of: &dyn Fn(&Active) -> bool| {
        let supports = model.supports.iter().filter(|support| of(&support.active));
        supports.map(|support| support.name.clone()).collect()
    };
    StageSteps {
        name: model.stages[stage as usize].name.clone(),
        steps: stations(model, stage).steps().try_into().unwrap_or(u32::MAX),
        begun: named(&|active| stage > 0 && active.from == stage),
        ended: named(&|active| active.until == Some(stage)),
    }
}

/// What will end the run, or may do so.
fn warnings<const D: usize>(
    model: &Model<D>,
    mesh: &Mesh<D>,
    connected: &Connected<D>,
    constraints: &Constraints<D>,
) -> Vec<String> {
    let unheld = unheld_at_start(model, mesh, connected, constraints);
    let unheld = (!unheld.is_empty()).then(|| {
        let kept = match model.unheld_motion {
            UnheldMotion::Refuse => "the run will end in its first load step",
            UnheldMotion::Zero => "which is kept at zero if no load acts along it",
        };
        format!("nothing holds {}: {kept}", unheld.join("; nor "))
    });
    let later = if unheld.is_some() { None } else { unheld_later(model, mesh, connected) };
    unheld.into_iter().chain(later).chain(advice(model)).collect()
}

/// What nothing holds once supports have ended, in the first stage of which that is true; nothing is said where tools move,
/// which may hold it by then.
fn unheld_later<const D: usize>(model: &Model<D>, mesh: &Mesh<D>, connected: &Connected<D>) -> Option<String> {
    if are_pushed(model) {
        return None;
    }
    let acting = |stage: u32| model.supports.iter().map(move |support| support.acts_in(stage));
    let mut stages = (1..).zip(model.stages.iter().skip(1));
    stages.find_map(|(number, stage)| {
        if acting(number).eq(acting(number - 1)) {
            return None;
        }
        let constraints = supported(model, &connected.active, number);
        let unheld = unheld_at_start(model, mesh, connected, &constraints);
        let end = match model.unheld_motion {
            UnheldMotion::Refuse => "the run will end there",
            UnheldMotion::Zero => "which is kept at zero if no load acts along it",
        };
        let what = unheld.join("; nor ");
        (!unheld.is_empty())
            .then(|| format!("in stage `{}` nothing holds {what}, as bodies now stand: {end}", stage.name))
    })
}

/// Bytes of load steps that are recorded and not yet written, and of their copies on the way to the file.
fn kept_records(n_points: usize, steps: u32) -> usize {
    /// Numbers of a point that are recorded in most scenes: position and a tensor.
    const NUMBERS: usize = 10;
    const MOST: usize = 8 << 20;
    let all = n_points.saturating_mul(2 * NUMBERS * size_of::<f64>()).saturating_mul(1 + steps as usize);
    all.min(MOST)
}

fn sizes_of_tools<const D: usize>(model: &Model<D>) -> Vec<String> {
    let bodies = model.bodies_by_name();
    model.contributions.iter().filter_map(|named| named.contribution.size(&bodies)).collect()
}

fn volume<const D: usize>(named: &NamedBody<D>) -> BodyVolume {
    let points: f64 = views(&*named.body).map(|view| view.reference_volume).sum();
    let mass = named.density.map(|density| density * points);
    BodyVolume { body: named.name.clone(), points, shape: named.shape_volume, mass }
}

/// Columns of the points that no body stores.
pub(crate) fn columns_not_stored<const D: usize>(bodies: &[NamedBody<D>]) -> Vec<&'static str> {
    let per_body: Vec<_> = bodies.iter().map(|named| named.body.columns()).collect();
    per_body.first().map_or(Vec::new(), |columns| {
        let absent = |k: &usize| per_body.iter().all(|columns| columns[*k].1 == 0);
        (0..columns.len()).filter(absent).map(|k| columns[k].0).collect()
    })
}

/// Cells of the mesh at a load fraction in which no material point lies; 0 where there is no mesh.
pub(crate) fn cells_without_material<const D: usize>(
    model: &Model<D>,
    at: LoadFraction,
    ranks: &dyn Ranks<D>,
) -> u64 {
    let Ok(mesh) = model.motion.mesh_at(&model.layout, at) else { return 0 };
    let lattice = mesh.lattice();
    let occupied = cells_of_points(model, &mesh).into_iter().map(|cell| OccupiedCell {
        cell: lattice.cell(cell),
        volume: 0.0,
        stiffness: 0.0,
    });
    // Several ranks may have points in a cell; its owner counts it.
    let joined = ranks.joined(lattice, occupied.collect());
    let own = joined.iter().filter(|it| ranks.is_own(lattice.cell_index(it.cell))).count();
    lattice.n_cells() as u64 - count(ranks, own as u64)
}

fn cells_with_material<const D: usize>(model: &Model<D>, mesh: &Mesh<D>) -> usize {
    cells_of_points(model, mesh).len()
}

/// The cells in which points lie, each once.
fn cells_of_points<const D: usize>(model: &Model<D>, mesh: &Mesh<D>) -> Vec<[u32; D]> {
    let of_body = |named: &'_ NamedBody<D>| {
        let body = &*named.body;
        let cell = |point| mesh.locate(&body.point(point).position, 0.0).ok().map(|place| place.cell);
        of_points(body, cell).flatten().collect::<Vec<_>>()
    };
    let mut cells: Vec<[u32; D]> = model.bodies.iter().flat_map(of_body).collect();
    // Points mostly stand in the order of their cells.
    cells.dedup();
    cells.sort_unstable();
    cells.dedup();
    cells
}
