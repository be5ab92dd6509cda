//! Ghost stabilisation: stiffness for cells that a body barely reaches into.
//!
//! Where a body ends just inside a cell, the cell's outer nodes carry next to no stiffness and the
//! tangent is all but singular. Across the faces between such a boundary cell and its neighbours that
//! hold material, jumps of the displacement gradient are penalised:
//!
//! ```text
//! K_vw = Σ_F γ_F h_F/3 ∫_F [∇N_v]·[∇N_w] dΓ I        γ_F = factor · E_F
//! ```
//!
//! (Coombs 2023, "Ghost stabilisation of the material point method for stable quasi-static and dynamic
//! analysis of large deformation problems"; Sticko, Ludvigsson & Kreiss 2020). `[·]` is the jump across the face; as
//! displacement is continuous along it, only the normal derivative jumps, whatever way the face lies.
//! E_F is the Young's modulus of both cells weighted by the volume of material in them, h_F the mean
//! extent of the cells across the face (their volume over the face's area). The published form has h³
//! for h; with h the stiffness has its unit and scales with the problem. It acts on the displacement of
//! the load step: constant through Newton's iterations, symmetric, without memory, and zero wherever the
//! gradient is continuous.
//!
//! Splines of degree p are of class C^(p-1), and only their p-th derivatives jump, see `splines.rs`.

mod face;
mod splines;

use crate::body::{OccupiedCell, PassInput, Space, Sums};
use crate::contribution::{
    Begun, BodyAtStart, Contribution, ContributionEnergy, Inadmissible, Recorded, Refused, StepStart,
};
use crate::sharing::{Sharing, Unshared};
use crate::trial::{SystemSums, Trial};
use crate::unknowns::{Couplings, SparsityPattern, Unknowns};
use face::{face_area, face_points};
use mpm_basis::ActiveNodes;
use mpm_grid::{LinearCell, Mesh, NodeKind, Place, Vector};
use mpm_linear::Symmetry;
use std::f64::consts::TAU;

/// A mesh, its active nodes, and two of its cells, the second above the first in a direction.
type Face<'a, const D: usize> = (&'a Mesh<D>, &'a ActiveNodes<D>, [[u32; D]; 2], usize);

/// Faces across which jumps of the displacement gradient are penalised, with their stiffness.
#[derive(Clone, Debug)]
pub struct GhostFaces<const D: usize> {
    /// Start of every face's nodes in `node`, and its length at the end.
    node_start: Vec<usize>,
    /// Active numbers, ascending in each face.
    node: Vec<u32>,
    /// `γ h/3 ∫ [∇N_v]·[∇N_w] dΓ` for v ≥ w, column by column, of every face in turn `[F/L]`.
    stiffness: Vec<f64>,
    /// Mean extent of the cells across every face `[L]`.
    extent: Vec<f64>,
    /// Radius of the middle of every face, whose square is the part of the stiffness that the turn has, of bodies that turn
    /// about their axis; else empty `[L]`.
    radius: Vec<f64>,
}

impl<const D: usize> GhostFaces<D> {
    /// The faces between occupied cells at least one of which has an empty neighbour. `factor` is γ over
    /// Young's modulus; `cells` as the bodies gave them, in any order. Faces of bodies of revolution are whole rings:
    /// their stiffness is that per length times `2π r` of their middle; of those that turn, the stiffness of the turn is that
    /// of an arc, `2π r³`.
    ///
    /// The edge of the mesh is no empty neighbour: a body that ends there fills its cells.
    ///
    /// # Panics
    /// The nodes are not those of the mesh's functions.
    pub fn of(
        mesh: &Mesh<D>,
        active: &ActiveNodes<D>,
        cells: Vec<OccupiedCell>,
        (factor, space): (f64, Space),
    ) -> Self {
        Self::above_own(mesh, active, cells, (factor, space), &Unshared)
    }

    /// Those of the faces that are above cells of one's own.
    fn above_own(
        mesh: &Mesh<D>,
        active: &ActiveNodes<D>,
        mut cells: Vec<OccupiedCell>,
        (factor, space): (f64, Space),
        shared: &dyn Sharing<D>,
    ) -> Self {
        assert_eq!(active.space().kind(), mesh.functions(), "faces join cells of the mesh");
        // Stable: cells that occur more than once are summed in the order of the bodies.
        cells.sort_by_key(|it| it.cell);
        cells.dedup_by(|next, kept| {
            let same = next.cell == kept.cell;
            if same {
                kept.volume += next.volume;
                kept.stiffness += next.stiffness;
            }
            same
        });
        let lattice = mesh.lattice();
        let has_splines = mesh.functions() != NodeKind::Vertices;
        if has_splines {
            cells.retain(|it| is_active(mesh, active, lattice.cell_index(it.cell)));
        }
        let find = |index: [u32; D]| {
            cells.binary_search_by_key(&lattice.cell(index), |it| it.cell).ok().map(|at| &cells[at])
        };
        let is_at_boundary = |index: [u32; D]| {
            (0..D).any(|d| {
                let beside = [lattice.below(index, d), lattice.above(index, d)];
                beside.into_iter().flatten().any(|beside| find(beside).is_none())
            })
        };

        let mut faces = Self::none();
        for lower in &cells {
            let index = lattice.cell_index(lower.cell);
            if !shared.is_own(index) {
                continue;
            }
            for d in 0..D {
                let Some((above, upper)) = lattice.above(index, d).and_then(|it| Some((it, find(it)?))) else {
                    continue;
                };
                if is_at_boundary(index) || is_at_boundary(above) {
                    let young = (lower.stiffness + upper.stiffness) / (lower.volume + upper.volume);
                    let face = (mesh, active, [index, above], d);
                    if has_splines {
                        faces.push_splines(face, (factor * young, space));
                    } else {
                        faces.push(face, (factor * young, space));
                    }
                }
            }
        }
        faces
    }

    fn none() -> Self {
        Self {
            node_start: vec![0],
            node: Vec::new(),
            stiffness: Vec::new(),
            extent: Vec::new(),
            radius: Vec::new(),
        }
    }

    /// Number of faces.
    pub fn len(&self) -> usize {
        self.node_start.len() - 1
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Where the faces' stiffness goes in a pattern that was made with them.
    pub fn slots(&self, pattern: &SparsityPattern<D>) -> Vec<u32> {
        pattern.slots(self)
    }

    /// The face between two cells, the second above the first in a direction.
    fn push(&mut self, (mesh, active, cells, direction): Face<'_, D>, (mut penalty, space): (f64, Space)) {
        // Of a layer only the lower side has nodes.
        let is_layer = space.is_axisymmetric() && D == 3;
        let n_corners = if is_layer { 4 } else { 1 << D };
        let corners = cells.map(|cell| {
            let corners = mesh.lattice().corners(cell);
            let number = |c: usize| active.number(corners[c]).expect("nodes of occupied cells are active");
            (0..n_corners).map(|c| number(c) as u32).collect::<Vec<u32>>()
        });
        let mut nodes: Vec<u32> = corners.iter().flatten().copied().collect();
        nodes.sort_unstable();
        nodes.dedup();
        let linear = cells.map(|cell| mesh.linear_cell(cell));

        let n = nodes.len();
        let first = self.stiffness.len();
        self.stiffness.resize(first + n * (n + 1) / 2, 0.0);
        let mut area = 0.0;
        let mut jump = vec![Vector::<D>::zeros(); n];
        for (side, weight) in face_points::<D>(direction) {
            jump.fill(Vector::zeros());
            for (which, sign) in [(0, -1.0), (1, 1.0)] {
                let mut local = side;
                local[direction] = -sign;
                if is_layer {
                    local[D - 1] = -1.0;
                }
                let gradients = linear[which].gradients(&local);
                for (node, mut gradient) in corners[which].iter().zip(gradients) {
                    if is_layer {
                        gradient[D - 1] = 0.0;
                    }
                    let v = nodes.binary_search(node).expect("listed above");
                    jump[v] += gradient * sign;
                }
            }
            let mut local = side;
            local[direction] = 1.0;
            let patch = weight * face_area(&linear[0].jacobian(&local), direction);
            area += patch;
            let mut at = first;
            for w in 0..n {
                for v in w..n {
                    self.stiffness[at] += patch * jump[v].dot(&jump[w]);
                    at += 1;
                }
            }
        }
        if space.is_axisymmetric() {
            let mut middle = Vector::zeros();
            middle[direction] = 1.0;
            let radius = linear[0].position(&middle)[0];
            penalty *= TAU * radius;
            if is_layer {
                self.radius.push(radius);
            }
        }
        let extent = linear.iter().map(LinearCell::volume).sum::<f64>() / (2.0 * area);
        for value in &mut self.stiffness[first..] {
            *value *= penalty * extent / 3.0;
        }
        self.extent.push(extent);
        self.node.extend(nodes);
        self.node_start.push(self.node.len());
    }

    /// As [`Self::push`], where the functions are splines.
    fn push_splines(&mut self, face: Face<'_, D>, (mut penalty, space): (f64, Space)) {
        let (mesh, active, cells, direction) = face;
        let made = splines::face(mesh, cells, direction);
        let linear = cells.map(|cell| mesh.linear_cell(cell));
        if space.is_axisymmetric() {
            let mut middle = Vector::zeros();
            middle[direction] = 1.0;
            penalty *= TAU * linear[0].position(&middle)[0];
        }
        let extent = linear.iter().map(LinearCell::volume).sum::<f64>() / (2.0 * made.area);
        let mut numbered: Vec<(u32, usize)> = made
            .nodes
            .iter()
            .enumerate()
            .map(|(at, &node)| (active.number(node).expect("nodes of occupied cells are active") as u32, at))
            .collect();
        numbered.sort_unstable();
        for (w, &(_, of_w)) in numbered.iter().enumerate() {
            for &(_, of_v) in &numbered[w..] {
                self.stiffness.push(penalty / extent * made.product(of_v, of_w));
            }
        }
        self.extent.push(extent);
        self.node.extend(numbered.iter().map(|it| it.0));
        self.node_start.push(self.node.len());
    }

    /// Adds to every node the size of the forces whose sum over a face is none where all of it moves by the extent of its
    /// cells, `h Σ_w |K_vw|` `[F]`.
    fn round_off(&self, sizes: &mut [f64]) {
        let mut at = 0;
        for (face, extent) in self.extent.iter().enumerate() {
            let nodes = self.set(face);
            for (w, &of_w) in nodes.iter().enumerate() {
                for &of_v in &nodes[w..] {
                    let size = extent * self.stiffness[at].abs();
                    at += 1;
                    sizes[of_v as usize] += size;
                    if of_v != of_w {
                        sizes[of_w as usize] += size;
                    }
                }
            }
        }
    }

    /// Adds force and tangent under the trial displacement of `input`; `slots` are those of these
    /// faces in its pattern.
    pub fn assemble(&self, slots: &[u32], input: PassInput<'_, D>, mut sums: Sums<'_, D>) {
        let (mut at, mut slot) = (0, 0);
        for face in 0..self.len() {
            let nodes = self.set(face);
            let n = nodes.len();
            let stiffness = &self.stiffness[at..at + n * (n + 1) / 2];
            at += stiffness.len();
            let mut factors = Vector::repeat(1.0);
            if let Some(radius) = self.radius.get(face) {
                factors[D - 1] = radius * radius;
            }
            let pairs = || (0..n).flat_map(|w| (w..n).map(move |v| (v, w))).zip(stiffness);
            for ((v, w), &value) in pairs() {
                let [v, w] = [v, w].map(|k| nodes[k] as usize);
                sums.internal[v] += (input.increment[w] * value).component_mul(&factors);
                if v != w {
                    sums.internal[w] += (input.increment[v] * value).component_mul(&factors);
                }
            }
            let Some(tangent) = &mut sums.tangent else { continue };
            if let Some(lift) = &mut tangent.lift {
                for ((v, w), &value) in pairs() {
                    let [v, w] = [v, w].map(|k| nodes[k] as usize);
                    lift[v] += (input.constraints.increment()[w] * value).component_mul(&factors);
                    if v != w {
                        lift[w] += (input.constraints.increment()[v] * value).component_mul(&factors);
                    }
                }
            }
            let slots = &slots[slot..slot + input.pattern.n_slots(n)];
            slot += slots.len();
            let stiffness = (stiffness, &factors);
            input.pattern.add_by_component(nodes, slots, stiffness, input.constraints, tangent.values);
        }
    }
}

/// Ghost stabilisation of all bodies, as a contribution.
#[derive(Clone, Debug)]
pub struct GhostStabilisation<const D: usize> {
    /// γ over Young's modulus `[-]`.
    factor: f64,
    faces: GhostFaces<D>,
    /// Where the stiffness of the faces goes.
    slots: Vec<u32>,
}

impl<const D: usize> GhostStabilisation<D> {
    /// γ over Young's modulus that suits the functions of a mesh `[-]`: with splines more of it costs accuracy next to
    /// boundaries.
    pub fn usual_factor(functions: NodeKind) -> f64 {
        match functions {
            NodeKind::ControlPoints { degree: 2 } => 1e-3,
            NodeKind::ControlPoints { degree: 3.. } => 1e-4,
            _ => 1.0 / 30.0,
        }
    }

    /// `factor` is γ over Young's modulus `[-]`.
    pub fn new(factor: f64) -> Self {
        Self { factor, faces: GhostFaces::none(), slots: Vec::new() }
    }
}

impl<const D: usize> Contribution<D> for GhostStabilisation<D> {
    fn begin(&mut self, step: &StepStart<'_, D>, _unknowns: &mut Unknowns<D>) -> Result<Begun, Refused> {
        if step.is_retry {
            return Ok(Begun::AsBefore);
        }
        let mut cells = Vec::new();
        let space = step.bodies.first().map_or(Space::default(), |it| it.body.space());
        for BodyAtStart { body, connectivity, .. } in step.bodies {
            body.occupied_cells(connectivity, step.mesh, step.active, &mut cells)
                .map_err(|it| Refused { reason: it.to_string(), is_step_too_long: false })?;
        }
        let cells = step.sharing.joined(step.mesh.lattice(), cells);
        self.faces = GhostFaces::above_own(step.mesh, step.active, cells, (self.factor, space), step.sharing);
        Ok(Begun::Anew)
    }

    fn couplings(&self) -> &dyn Couplings {
        &self.faces
    }

    fn symmetry(&self) -> Symmetry {
        Symmetry::Symmetric
    }

    fn locate(&mut self, pattern: &SparsityPattern<D>) {
        self.slots = self.faces.slots(pattern);
    }

    fn add(&self, trial: &Trial<'_, D>, sums: &mut SystemSums<'_, D>) -> Result<(), Inadmissible> {
        self.faces.assemble(&self.slots, trial.input(), sums.sums());
        Ok(())
    }

    fn round_off(&self, sizes: &mut [f64]) {
        self.faces.round_off(sizes);
    }

    fn needs_functions_of_mesh(&self) -> bool {
        true
    }

    fn stabilises(&self) -> bool {
        true
    }

    fn can_be_shared(&self) -> bool {
        true
    }

    /// The faces forget each load step, so that what is worked against them is lost: `Δu K Δu`, because their force is
    /// `K Δu` from one end of a step to the next. On prescribed components the work of a step counts from bodies
    /// alone: there it is half of that.
    fn energy(&self, trial: &Trial<'_, D>) -> ContributionEnergy {
        let increment = &trial.increment.nodes;
        let mut force = vec![Vector::<D>::zeros(); increment.len()];
        let sums = Sums { internal: &mut force, own: &mut [], tangent: None };
        self.faces.assemble(&self.slots, trial.input(), sums);
        let mut dissipated = 0.0;
        for (v, (force, u)) in force.iter().zip(increment).enumerate() {
            for i in 0..D {
                let part = if trial.constraints.is_prescribed(v, i) { 0.5 } else { 1.0 };
                dissipated += part * force[i] * u[i];
            }
        }
        ContributionEnergy { dissipated, ..ContributionEnergy::default() }
    }

    fn history(&self) -> Vec<Recorded> {
        vec![Recorded::count("ghost_faces", self.faces.len() as u64)]
    }
}

impl<const D: usize> Couplings for GhostFaces<D> {
    fn n_sets(&self) -> usize {
        self.len()
    }

    fn set(&self, face: usize) -> &[u32] {
        &self.node[self.node_start[face]..self.node_start[face + 1]]
    }
}

/// Whether a body reaches all functions of a cell.
fn is_active<const D: usize>(mesh: &Mesh<D>, active: &ActiveNodes<D>, cell: [u32; D]) -> bool {
    let mut all = true;
    mesh.values(&Place { cell, local: Vector::zeros() }, |node, _| all &= active.number(node).is_some());
    all
}
