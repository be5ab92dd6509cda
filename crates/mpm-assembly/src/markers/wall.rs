//! Walls: rigid surfaces that hold a side of a body, wherever the mesh has its nodes.

use super::carriers::BEYOND;
use super::held::Held;
use super::moving::Moving;
use super::side::BodySide;
use super::summary::Summary;
use crate::contact::ToolLoad;
use crate::contact::loaded::Standing;
use crate::contribution::{Inadmissible, Refused, StepStart};
use crate::unknowns::{Block, CoupledPlaces};
use mpm_contact::{Near, Pose, Tool, ToolMotion};
use mpm_grid::{Block as Matrix, LoadFraction, Mesh, Place, Vector};

/// What a wall holds.
#[derive(Debug)]
pub enum Hold<const D: usize> {
    /// Every marker where the wall carries what stood there at rest.
    All,
    /// Markers on the surface of this shape, along which they slide.
    Normal(Tool<D>),
    /// Markers outside this shape: they can part from it.
    Contact(Tool<D>),
}

/// A wall: what it holds, how, and how it moves.
#[derive(Debug)]
pub struct Wall<const D: usize> {
    /// What it holds.
    pub side: BodySide<D>,
    /// How.
    pub hold: Hold<D>,
    /// How it moves.
    pub motion: ToolMotion<D>,
    /// What else moves it: a load, in the components of its motion that are free. Only walls that hold all have one, and
    /// in space it turns nothing.
    pub load: Option<ToolLoad<D>>,
    /// c: gaps have the stiffness β = c E/h per area `[-]`.
    pub stiffness: f64,
    /// Whether a step is balanced again until there are no gaps.
    pub exact: bool,
    /// Point of the wall at rest about which its moment acts and is recorded; it moves with the wall `[L]`.
    pub moment_about: Vector<D>,
}

/// A wall as a contribution. With the gap g of a marker and its part L of the boundary at rest
///
/// ```text
/// q = λ + β g      f_v += Σ_b L q n N_v(x_b)      K_vw += Σ_b L (β n⊗n + q ∇∇φ) N_v N_w
/// ```
///
/// where λ is the q of the last step, so that the gap is that of one step's change of q: an augmented Lagrangian that is spread
/// over the load steps. Here q is positive where the wall pulls at the body, unlike the normal force of tools.
#[derive(Debug)]
pub struct WallContact<const D: usize> {
    pub(super) name: String,
    pub(super) wall: Wall<D>,
    pub(super) markers: Moving<D>,
    /// Length of every marker's cell across the wall in this step `[L]`, and β `[F/L³]`, in the plane per thickness.
    pub(super) width: Vec<f64>,
    pub(super) beta: Vec<f64>,
    /// λ of every marker, one component or D: of the last step, in this one, and for the next `[F/L^(D-1)]`.
    pub(super) carried: Vec<f64>,
    pub(super) held: Vec<f64>,
    pub(super) prepared: Vec<f64>,
    /// Where the wall stands: at the start of the step, and at the end of the one that has been balanced.
    pub(super) standing: Standing<D>,
    pub(super) prepared_standing: Standing<D>,
    pub(super) from: LoadFraction,
    /// Unknowns of a wall with a load, and whether its load is added here.
    pub(super) block: Option<Block>,
    pub(super) adds_load: bool,
    /// Largest gap of the round before, while a step is balanced again.
    pub(super) gap_before: f64,
    pub(super) couplings: CoupledPlaces,
    pub(super) summary: Summary<D>,
    pub(super) prepared_summary: Summary<D>,
}

impl<const D: usize> WallContact<D> {
    /// A wall that has held nothing yet. The history of the run has `wall/<name>/…`.
    pub fn new(name: impl Into<String>, wall: Wall<D>) -> Self {
        let markers = Moving::new(wall.side.clone());
        let components = if matches!(wall.hold, Hold::All) { D } else { 1 };
        let carried = vec![0.0; components * markers.position.len()];
        let pose = wall.motion.pose(LoadFraction::START);
        let standing = Standing { pose, angle: 0.0 };
        let summary = Summary::at(pose.place(&wall.moment_about), 0.0);
        Self {
            name: name.into(),
            wall,
            markers,
            width: Vec::new(),
            beta: Vec::new(),
            held: carried.clone(),
            prepared: carried.clone(),
            carried,
            standing,
            prepared_standing: standing,
            from: LoadFraction::START,
            block: None,
            adds_load: true,
            gap_before: f64::INFINITY,
            couplings: CoupledPlaces::default(),
            prepared_summary: summary.clone(),
            summary,
        }
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What the wall is.
    pub fn wall(&self) -> &Wall<D> {
        &self.wall
    }

    /// The largest distance of the side at rest from the wall where that stands at the start; 0 where it holds all, or
    /// where markers may part from it and do not stand inside `[L]`.
    pub fn gap_at_rest(&self) -> f64 {
        let pose = self.wall.motion.pose(LoadFraction::START);
        let markers = self.wall.side.markers.iter();
        let distance =
            |tool: &Tool<D>, x: &Vector<D>| nearest(tool, &pose, x).map_or(0.0, |near| near.distance);
        let gap = |x: &Vector<D>| match &self.wall.hold {
            Hold::All => 0.0,
            Hold::Normal(tool) => distance(tool, x).abs(),
            Hold::Contact(tool) => (-distance(tool, x)).max(0.0),
        };
        markers.map(gap).fold(0.0, f64::max)
    }

    /// The components of a marker.
    pub(super) fn of_marker<'a>(&self, all: &'a [f64], marker: usize) -> &'a [f64] {
        let n = all.len() / self.markers.position.len();
        &all[n * marker..n * (marker + 1)]
    }

    /// One's own markers at `positions` `[L]` with the wall at `pose`.
    ///
    /// # Errors
    /// A marker has no distance from the wall, because its position is no number.
    pub(super) fn holds(&self, positions: &[Vector<D>], pose: &Pose<D>) -> Result<Vec<Held<D>>, Inadmissible> {
        let held = self.markers.own.iter().map(|&marker| self.hold(marker, &positions[marker], pose));
        let held: Option<Vec<_>> = held.collect();
        held.ok_or_else(|| Inadmissible::Contribution("has a marker that is nowhere".into()))
    }

    fn hold(&self, marker: usize, x: &Vector<D>, pose: &Pose<D>) -> Option<Held<D>> {
        let (beta, measure) = (self.beta[marker], self.markers.measure[marker]);
        let held = self.of_marker(&self.held, marker);
        let tool = match &self.wall.hold {
            Hold::Normal(tool) | Hold::Contact(tool) => tool,
            Hold::All => {
                let foot = pose.place(&self.markers.side.markers[marker]);
                let gap = x - foot;
                let q = Vector::from_column_slice(held) + gap * beta;
                return Some(Held {
                    marker,
                    force: q * measure,
                    stiffness: Matrix::identity() * (beta * measure),
                    foot,
                    normal: None,
                    q: q.iter().copied().collect(),
                    gap: gap.norm(),
                });
            }
        };
        let Near { distance, normal, hessian, .. } = nearest(tool, pose, x)?;
        let q = held[0] + beta * distance;
        let foot = x - normal * distance;
        if q > 0.0 && matches!(self.wall.hold, Hold::Contact(_)) {
            let (force, stiffness) = (Vector::zeros(), Matrix::zeros());
            return Some(Held {
                marker,
                force,
                stiffness,
                foot,
                normal: Some(normal),
                q: vec![0.0],
                gap: (-distance).max(0.0),
            });
        }
        Some(Held {
            marker,
            force: normal * (q * measure),
            stiffness: (normal * normal.transpose() * beta + hessian * q) * measure,
            foot,
            normal: Some(normal),
            q: vec![q],
            gap: distance.abs(),
        })
    }

    /// Works out β of every marker: c E over the length of its cell across the wall.
    pub(super) fn stiffen(&mut self, step: &StepStart<'_, D>) -> Result<(), Refused> {
        let body = step.bodies.iter().find(|it| it.name == self.wall.side.body);
        let body = body.ok_or_else(|| Refused::here(format!("holds no body `{}`", self.wall.side.body)))?;
        let young = body.body.young();
        let pose = &self.standing.pose;
        let mut widths = Vec::with_capacity(self.markers.position.len());
        for x in &self.markers.position {
            let normal = match &self.wall.hold {
                Hold::All => None,
                Hold::Normal(tool) | Hold::Contact(tool) => nearest(tool, pose, x).map(|near| near.normal),
            };
            let place = step.mesh.locate(x, BEYOND).map_err(|it| Refused::here(it.to_string()))?;
            widths.push(width(step.mesh, &place, normal.as_ref()));
        }
        self.beta = widths.iter().map(|width| self.wall.stiffness * young / width).collect();
        self.width = widths;
        Ok(())
    }
}

/// The nearest place of a surface to `x` `[L]`; none where that is no number.
fn nearest<const D: usize>(tool: &Tool<D>, pose: &Pose<D>, x: &Vector<D>) -> Option<Near<D>> {
    let mut near = Vec::new();
    for part in 0..tool.n_parts() {
        tool.near(part, pose, x, f64::INFINITY, &mut near);
    }
    near.into_iter().min_by(|a, b| a.distance.abs().total_cmp(&b.distance.abs()))
}

/// Length of a cell across a surface with the normal `normal`, or the root mean square along all directions `[L]`.
fn width<const D: usize>(mesh: &Mesh<D>, place: &Place<D>, normal: Option<&Vector<D>>) -> f64 {
    // Columns are half the edges.
    let edges = mesh.linear_cell(place.cell).jacobian(&place.local) * 2.0;
    match normal {
        Some(normal) => edges.tr_mul(normal).norm(),
        None => edges.norm() / (D as f64).sqrt(),
    }
}
