//! Circles of a body that are held where they were, by springs at the corners of domains on them.

use mpm_assembly::{
    Begun, Contribution, CoupledPlaces, Couplings, Inadmissible, Refused, Scale, StepStart, SystemSums, Trial,
    UnknownId, Unknowns,
};
use mpm_basis::Corner;
use mpm_grid::Vector;
use mpm_linear::Symmetry;

/// Springs between the corners on circles about the origin and where these corners were at rest, so stiff per length of the
/// circle that a coarse mesh may give way: where the exact solution neither moves nor has a traction, it stays exact.
#[derive(Debug, Default)]
pub struct HeldCircles {
    radii: Vec<f64>,
    /// Per length `[F/L²]`.
    stiffness: f64,
    held: Vec<Held>,
    /// Nodes that carry each held corner.
    places: CoupledPlaces,
}

/// A corner on a circle.
#[derive(Debug)]
struct Held {
    point: usize,
    corner: usize,
    rest: Vector<2>,
    /// Half of the domain's side on the circle `[L]`.
    length: f64,
    /// Where it is at the start of the load step, and the active nodes that carry it with their weights.
    start: Vector<2>,
    carriers: Vec<(usize, f64)>,
}

impl HeldCircles {
    /// Circles of these radii `[L]`, held by `stiffness` per length `[F/L²]`.
    pub fn new(radii: &[f64], stiffness: f64) -> Self {
        Self { radii: radii.to_vec(), stiffness, ..Self::default() }
    }

    /// The corners of a domain at rest that are on one of the circles.
    fn of_domain(&self, point: usize, corners: &[Corner<2>]) -> Vec<Held> {
        // Parallelograms stand next to the circle by the square of their size.
        let apart =
            |a: &Corner<2>| corners.iter().map(|b| (a.position - b.position).norm()).fold(0.0, f64::max);
        let near = 0.1 * corners.iter().map(apart).fold(0.0, f64::max);
        let on = |x: &Vector<2>| self.radii.iter().position(|radius| (x.norm() - radius).abs() < near);
        let on_circles = corners.iter().enumerate().filter(|(_, corner)| on(&corner.position).is_some());
        on_circles
            .map(|(k, corner)| {
                let same = |other: &&Corner<2>| on(&other.position) == on(&corner.position);
                let side = corners.iter().filter(same).map(|other| (other.position - corner.position).norm());
                Held {
                    point,
                    corner: k,
                    rest: corner.position,
                    length: 0.5 * side.fold(0.0, f64::max),
                    start: corner.position,
                    carriers: Vec::new(),
                }
            })
            .collect()
    }

    /// By how much a corner has left its place under a trial `[L]`.
    fn gap(held: &Held, trial: &Trial<'_, 2>) -> Vector<2> {
        let moved: Vector<2> = held.carriers.iter().map(|&(v, weight)| trial.increment.nodes[v] * weight).sum();
        held.start + moved - held.rest
    }
}

impl Contribution<2> for HeldCircles {
    fn begin(&mut self, step: &StepStart<'_, 2>, unknowns: &mut Unknowns<2>) -> Result<Begun, Refused> {
        let body = step.bodies[0].body;
        let corners_of = |point: usize| {
            let mut corners = Vec::new();
            body.corners(step.mesh, point, &mut corners)
                .map(|()| corners)
                .map_err(|it| Refused::here(it.to_string()))
        };
        if self.held.is_empty() {
            for point in 0..body.n_points() {
                let held = self.of_domain(point, &corners_of(point)?);
                self.held.extend(held);
            }
        }
        let mut places = CoupledPlaces::default();
        for held in &mut self.held {
            let corner = corners_of(held.point)?[held.corner];
            held.start = corner.position;
            let active = |(node, weight)| Some((step.active.number(node)?, weight));
            held.carriers = corner.weights().filter_map(active).collect();
            places.push(held.carriers.iter().map(|it| unknowns.place(it.0)));
        }
        self.places = places;
        Ok(Begun::Anew)
    }

    fn couplings(&self) -> &dyn Couplings {
        &self.places
    }

    fn symmetry(&self) -> Symmetry {
        Symmetry::Symmetric
    }

    fn add(&self, trial: &Trial<'_, 2>, sums: &mut SystemSums<'_, 2>) -> Result<(), Inadmissible> {
        let numbering = trial.pattern.unknowns();
        for held in &self.held {
            let (gap, k) = (Self::gap(held, trial), self.stiffness * held.length);
            let entries = || held.carriers.iter().flat_map(|&(v, weight)| [(v, weight, 0), (v, weight, 1)]);
            let unknowns: Vec<UnknownId> = entries().map(|(v, _, i)| numbering.displacement(v, i)).collect();
            let force: Vec<f64> = entries().map(|(_, weight, i)| weight * k * gap[i]).collect();
            let pairs = entries()
                .flat_map(|(_, w, j)| entries().map(move |(_, v, i)| if i == j { v * w * k } else { 0.0 }));
            sums.add(trial, &unknowns, &force, &pairs.collect::<Vec<f64>>());
        }
        Ok(())
    }

    fn scale(&self, trial: &Trial<'_, 2>) -> Scale<2> {
        let forces = self.held.iter().map(|held| Self::gap(held, trial).norm() * self.stiffness * held.length);
        forces.map(|force| force * force).sum::<f64>().sqrt().into()
    }
}
