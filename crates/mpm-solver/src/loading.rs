//! Loading of a load step: prescribed displacements and external forces at a load fraction.

use crate::connection::Connected;
use crate::equilibrium::round_off::{BodyScale, RoundOff};
use crate::failure::{PathFailure, StepFailure};
use crate::model::{Model, Prescribed};
use crate::ranks::agreed;
use mpm_assembly::{BodyLoads, Constraints, SideForces};
use mpm_grid::{LoadFraction, Mesh, Vector};

/// Half the difference of load fractions over which loading is differentiated.
pub(crate) const HALF_DIFFERENCE: f64 = 1e-5;

/// What loads a connected model in a load step.
#[derive(Clone, Copy)]
pub(crate) struct StepLoading<'a, const D: usize> {
    pub model: &'a Model<D>,
    pub mesh: &'a Mesh<D>,
    pub connected: &'a Connected<D>,
    /// Load fraction at the start of the step.
    pub start: LoadFraction,
    /// Components of active nodes that are held besides the supports, because nothing else holds a rigid motion.
    pub pins: &'a [(usize, usize)],
    /// What supports that have ended carry at the start of the step.
    pub carried: &'a [Carried],
}

/// A component of the force that a support carries which has ended, see `release.rs`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Carried {
    /// Number of the active node.
    pub node: usize,
    pub component: usize,
    /// At the start of the load step `[F]`.
    pub force: f64,
}

/// Loading at a load fraction t and its derivative.
pub(crate) struct LoadingAt<const D: usize> {
    /// The load fraction, or the nearest that a run knows.
    pub at: LoadFraction,
    /// `ū` over the step `[L]`.
    pub prescribed: Vec<Vector<D>>,
    /// `∂ū/∂t` `[L]`, as the increments of constraints.
    pub rates: Constraints<D>,
    /// `f_ext` `[F]`.
    pub external: Vec<Vector<D>>,
    /// `∂f_ext/∂t` `[F]`.
    pub external_rate: Vec<Vector<D>>,
}

impl<const D: usize> StepLoading<'_, D> {
    /// What the supports prescribe on the active nodes from the start of the step to `end`.
    ///
    /// # Errors
    /// The mesh cannot be placed at `end`, and a support follows it.
    pub(crate) fn constraints(&self, end: LoadFraction) -> Result<Constraints<D>, StepFailure> {
        agreed(&*self.connected.shared.ranks, self.constraints_of_rank(end))
    }

    fn constraints_of_rank(&self, end: LoadFraction) -> Result<Constraints<D>, StepFailure> {
        let Self { model, mesh, connected, start, pins, .. } = *self;
        let mut constraints = Constraints::none(connected.active.len());
        for support in model.supports.iter().filter(|support| support.acts_in(end.stage())) {
            for &node in &support.nodes {
                let Some(number) = connected.active.number(node) else { continue };
                for (component, prescribed) in support.components.iter().enumerate() {
                    let increment = match prescribed {
                        None => continue,
                        Some(Prescribed::Held) => 0.0,
                        Some(Prescribed::Driven(ramp)) => ramp.from_rest(end) - ramp.from_rest(start),
                        Some(Prescribed::Turned(turn)) => {
                            turn.displacement(&model.nodes.position(mesh, node), start, end)[component]
                        }
                        Some(Prescribed::FollowMesh) => model
                            .nodes
                            .displacement((&model.motion, &model.layout), node, mesh, (start, end))
                            .map_err(|it| StepFailure::Mesh(it.to_string()))?[component],
                    };
                    constraints.prescribe(number, component, increment);
                }
            }
        }
        if model.space().is_axisymmetric() {
            // Whatever the supports say: a ring of radius 0 stays a point.
            let width = mesh.axis_width();
            for (number, &node) in connected.active.nodes().iter().enumerate() {
                if model.nodes.position(mesh, node)[0] <= width {
                    constraints.hold_on_axis(number);
                }
            }
        }
        for &(number, component) in pins {
            constraints.prescribe(number, component, 0.0);
        }
        Ok(constraints)
    }

    /// `f_ext` of every active node at a load fraction `[F]`.
    pub(crate) fn external_force(&self, at: LoadFraction) -> Vec<Vector<D>> {
        let Self { model, connected, start, carried, .. } = *self;
        let mut external = vec![Vector::zeros(); connected.active.len()];
        let acceleration = model.loads.acceleration(at);
        for (index, (named, assembly_plan)) in model.bodies.iter().zip(&connected.assembly_plans).enumerate() {
            let point_forces = model.loads.point_forces(index, &*named.body, at);
            let side_forces = model.loads.side_forces(index, at);
            let on = SideForces { mesh: self.mesh, active: &connected.active, forces: &side_forces };
            let side_forces = (!side_forces.is_empty()).then_some(on);
            let loads = BodyLoads { acceleration, point_forces: &point_forces, side_forces };
            named.body.external_force(assembly_plan.connectivity(), &loads, &mut external);
        }
        connected.shared.ranks.complete(&mut external);
        // At the start of the step this much is left of a force that falls to 0 by the end of the stage.
        let left = 1.0 - start.get();
        for &Carried { node, component, force } in carried {
            external[node][component] += force * ((1.0 - at.get()) / left);
        }
        external
    }

    /// Forces that rounding can cause: a few units in the last place of strain in every point.
    pub(crate) fn round_off(&self) -> RoundOff {
        let n_nodes = self.connected.active.len();
        let (several, shared) = (self.model.bodies.len() > 1, &self.connected.shared);
        let (mut stiffness, mut bodies) = (vec![0.0; n_nodes], Vec::new());
        for (named, assembly_plan) in self.model.bodies.iter().zip(&self.connected.assembly_plans) {
            let connectivity = assembly_plan.connectivity();
            if !several {
                named.body.stiffness_force(connectivity, &mut stiffness);
                continue;
            }
            let mut own = vec![0.0; n_nodes];
            named.body.stiffness_force(connectivity, &mut own);
            stiffness.iter_mut().zip(&own).for_each(|(sum, own)| *sum += own);
            shared.ranks.complete_numbers(&mut own);
            let mut reached = vec![0.0; n_nodes];
            for set in 0..connectivity.n_node_sets() {
                connectivity.node_set(set).iter().for_each(|&node| reached[node as usize] = 1.0);
            }
            shared.ranks.complete_numbers(&mut reached);
            let nodes = (0..n_nodes as u32).filter(|&node| reached[node as usize] > 0.0).collect();
            bodies.push(BodyScale { nodes, stiffness: shared.norm_of(&own) });
        }
        for named in &self.model.contributions {
            named.contribution.round_off(&mut stiffness);
        }
        shared.ranks.complete_numbers(&mut stiffness);
        let all = 2.0 * f64::EPSILON * shared.norm_of(&stiffness);
        RoundOff { stiffness, all, bodies }
    }

    /// Loading at a load fraction and its derivative by central differences; beyond 0 and 1 the loading goes on in a
    /// straight line.
    ///
    /// # Errors
    /// The load fraction is not finite, or as [`Self::constraints`].
    pub(crate) fn linearised(&self, at: f64) -> Result<LoadingAt<D>, StepFailure> {
        if !at.is_finite() {
            return Err(StepFailure::Path(PathFailure::Leaves { fraction: at }));
        }
        let here = self.start.with_value(at);
        let before = here.with_value(here.get() - HALF_DIFFERENCE);
        let after = here.with_value(here.get() + HALF_DIFFERENCE);
        let (constraints, mut external) = (self.constraints(here)?, self.external_force(here));
        let (low, low_force) = (self.constraints(before)?, self.external_force(before));
        let (high, high_force) = (self.constraints(after)?, self.external_force(after));
        let (span, beyond) = (after.get() - before.get(), at - here.get());

        let mut prescribed = constraints.increment().to_vec();
        let mut rates = Constraints::none(constraints.n_nodes());
        for (v, prescribed) in prescribed.iter_mut().enumerate() {
            for i in (0..D).filter(|&i| constraints.is_prescribed(v, i)) {
                let rate = (high.increment()[v][i] - low.increment()[v][i]) / span;
                rates.prescribe(v, i, rate);
                prescribed[i] += rate * beyond;
            }
        }
        let external_rate: Vec<Vector<D>> =
            low_force.iter().zip(&high_force).map(|(low, high)| (high - low) / span).collect();
        for (force, rate) in external.iter_mut().zip(&external_rate) {
            *force += rate * beyond;
        }
        Ok(LoadingAt { at: here, prescribed, rates, external, external_rate })
    }
}

/// Sets the components that `constraints` prescribes to `prescribed` `[L]`.
pub(crate) fn impose<const D: usize>(
    constraints: &Constraints<D>,
    prescribed: &[Vector<D>],
    increment: &mut [Vector<D>],
) {
    constraints.free_part(increment);
    for (increment, prescribed) in increment.iter_mut().zip(prescribed) {
        *increment += prescribed;
    }
}
