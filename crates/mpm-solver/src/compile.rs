//! A scene becomes a model: the only place that asks what kind of thing something is.

use crate::domains::DomainLimit;
use crate::error::{Error, SceneError};
use crate::files::{NoFiles, SceneFiles, Surface};
use crate::fill::{Face, Filled, Plan, Shape, fill, line_at};
use crate::linear::Choice;
use crate::load_step::{resume, run, stencils};
use crate::model::{
    Loads, Model, NamedBody, PathControl, PathMeasure, PointLoad, Predictor, Prescribed, Probe, Schedule,
    Support, Tolerance, Turn,
};
use crate::observe::{Field, Observer};
use crate::record::Summary;
use crate::room::Room;
use crate::scene::{
    AxisInput, BodyInput, ControlInput, CornerWeightsInput, Direction, DomainsInput, Finite, GimpUpdateInput,
    LoadInput, MaterialInput, MeanDilatationInput, MeshInput, MotionInput, PathMeasureInput, PlaneBasis,
    PlanePoint, PredictorInput, ProbePointsInput, RampInput, RegionInput, ReindexingInput, Scene, SceneIn,
    ShapeInput, SolidBasis, SolverInput, StabilisationInput, StepControlInput, SupportInput, ToleranceInput,
    TrianglesInput, TurnInput,
};
use crate::state::{State, StateLayout};
use crate::surface::Round;
use crate::surface::parts::Solid;
use crate::vortex::Vortex;
use mpm_assembly::MeanDilatation;
use mpm_basis::{
    ActiveNodes, Basis, CornerWeights, Cpdi1, Cpdi2Hexahedron, Cpdi2Tetrahedron, Cpdi2q, Cpdi2t, DomainControl,
    Fallback, Gimp, GimpUpdate, Smpm, TriangleSplit,
};
use mpm_grid::{
    Axis, DrivenPlane, LatticeError, Layout, LayoutError, LoadFraction, Mesh, MeshMotion, NodeId, Ramp, Region,
    Reindexing, Span, Vector,
};
use mpm_material::{Elasticity, Hencky, VonMises};

/// A model in the space of its scene.
pub enum Compiled {
    /// Plane strain.
    Plane(Model<2>),
    /// Three dimensions.
    Solid(Model<3>),
}

impl Compiled {
    /// Runs the model, see [`run`].
    ///
    /// # Errors
    /// As [`run`].
    pub fn run(&mut self, observer: &mut dyn Observer) -> Result<Summary, Error> {
        match self {
            Compiled::Plane(model) => run(model, observer),
            Compiled::Solid(model) => run(model, observer),
        }
    }

    /// Goes on from a state, see [`resume`].
    ///
    /// # Errors
    /// As [`resume`].
    pub fn resume(&mut self, state: &State, observer: &mut dyn Observer) -> Result<Summary, Error> {
        match self {
            Compiled::Plane(model) => resume(model, state, observer),
            Compiled::Solid(model) => resume(model, state, observer),
        }
    }

    /// What the states of a model that has not begun to run look like.
    pub fn state_layout(&self) -> StateLayout {
        match self {
            Compiled::Plane(model) => StateLayout::of(model),
            Compiled::Solid(model) => StateLayout::of(model),
        }
    }
}

/// Makes a model of a scene that names no files, see [`compile_with`].
///
/// # Errors
/// As [`compile_with`].
pub fn compile(scene: &Scene) -> Result<Compiled, SceneError> {
    compile_with(scene, &NoFiles)
}

/// Makes a model of a scene and checks all that can be checked before the first load step.
///
/// What would not fit into the memory that this machine has left is refused before any of it is asked for.
///
/// # Errors
/// The first thing that is wrong with the scene, or with a file that it names, with its path.
pub fn compile_with(scene: &Scene, files: &dyn SceneFiles) -> Result<Compiled, SceneError> {
    made(scene, files, Room::of_machine())
}

/// As [`compile_with`], with so many bytes of memory in place of the machine's.
///
/// # Errors
/// As [`compile_with`].
pub fn compile_within(scene: &Scene, files: &dyn SceneFiles, bytes: u64) -> Result<Compiled, SceneError> {
    made(scene, files, Room { bytes })
}

fn made(scene: &Scene, files: &dyn SceneFiles, room: Room) -> Result<Compiled, SceneError> {
    Ok(match scene {
        Scene::PlaneStrain(scene) => Compiled::Plane(model(scene, files, room)?),
        Scene::Solid(scene) => Compiled::Solid(model(scene, files, room)?),
    })
}

/// Why a shape has no place in a ring mesh.
const NEEDS_BOX: &str =
    "such a body can only be filled in a box mesh; a ring mesh takes `Ring`, `Tube` and `Points`";

/// The bases of one space: makes bodies of points under the one that the scene names.
trait FillBody<const D: usize>: std::fmt::Debug {
    fn fill(
        &self,
        domains: &DomainsInput,
        law: &MaterialInput,
        plan: &Plan<'_, D>,
    ) -> Result<Filled<D>, String>;

    /// Fields of [`DomainsInput`] that the basis has a use for.
    fn options(&self) -> &'static [&'static str];
}

impl FillBody<2> for PlaneBasis {
    fn fill(
        &self,
        domains: &DomainsInput,
        law: &MaterialInput,
        plan: &Plan<'_, 2>,
    ) -> Result<Filled<2>, String> {
        match self {
            PlaneBasis::Smpm => fill_with(Smpm, law, plan),
            PlaneBasis::Gimp => fill_with(gimp(domains), law, plan),
            PlaneBasis::Cpdi1 => fill_with(Cpdi1, law, plan),
            PlaneBasis::Cpdi2q => {
                let weights = match domains.corner_weights {
                    None | Some(CornerWeightsInput::Current) => CornerWeights::Current,
                    Some(CornerWeightsInput::Frozen) => CornerWeights::Frozen,
                };
                fill_convected(Cpdi2q { weights }, domains, law, plan)
            }
            PlaneBasis::Cpdi2t => {
                let split = match domains.triangles {
                    None | Some(TrianglesInput::Cross) => TriangleSplit::Cross,
                    Some(TrianglesInput::Slash) => TriangleSplit::Slash,
                    Some(TrianglesInput::Backslash) => TriangleSplit::Backslash,
                };
                fill_convected(Cpdi2t { split }, domains, law, plan)
            }
        }
    }

    fn options(&self) -> &'static [&'static str] {
        match self {
            PlaneBasis::Smpm => &[],
            PlaneBasis::Cpdi1 => &["control"],
            PlaneBasis::Gimp => &["gimp_update", "control"],
            PlaneBasis::Cpdi2q => &["corner_weights", "fallback_beyond", "control"],
            PlaneBasis::Cpdi2t => &["triangles", "fallback_beyond", "control"],
        }
    }
}

impl FillBody<3> for SolidBasis {
    fn fill(
        &self,
        domains: &DomainsInput,
        law: &MaterialInput,
        plan: &Plan<'_, 3>,
    ) -> Result<Filled<3>, String> {
        match self {
            SolidBasis::Smpm => fill_with(Smpm, law, plan),
            SolidBasis::Gimp => fill_with(gimp(domains), law, plan),
            SolidBasis::Cpdi1 => fill_with(Cpdi1, law, plan),
            SolidBasis::Cpdi2Hexahedron => fill_convected(Cpdi2Hexahedron, domains, law, plan),
            SolidBasis::Cpdi2Tetrahedron => fill_convected(Cpdi2Tetrahedron, domains, law, plan),
        }
    }

    fn options(&self) -> &'static [&'static str] {
        match self {
            SolidBasis::Smpm => &[],
            SolidBasis::Cpdi1 => &["control"],
            SolidBasis::Gimp => &["gimp_update", "control"],
            SolidBasis::Cpdi2Hexahedron | SolidBasis::Cpdi2Tetrahedron => &["fallback_beyond", "control"],
        }
    }
}

fn gimp(domains: &DomainsInput) -> Gimp {
    let update = match domains.gimp_update {
        None | Some(GimpUpdateInput::Stretch) => GimpUpdate::Stretch,
        Some(GimpUpdateInput::Diagonal) => GimpUpdate::Diagonal,
        Some(GimpUpdateInput::Volume) => GimpUpdate::Volume,
        Some(GimpUpdateInput::None) => GimpUpdate::None,
    };
    Gimp { update }
}

/// An option that the basis would ignore is refused.
fn check_domains<const D: usize, B: FillBody<D>>(basis: &B, domains: &DomainsInput) -> Result<(), SceneError> {
    let given = [
        ("gimp_update", domains.gimp_update.is_some()),
        ("triangles", domains.triangles.is_some()),
        ("corner_weights", domains.corner_weights.is_some()),
        ("fallback_beyond", domains.fallback_beyond.is_some()),
        ("control", domains.control.is_some()),
    ];
    match given.into_iter().find(|(name, given)| *given && !basis.options().contains(name)) {
        None => Ok(()),
        Some((name, _)) => {
            let options: Vec<String> = basis.options().iter().map(|option| format!("`{option}`")).collect();
            let has = if options.is_empty() { "none".into() } else { options.join(", ") };
            let reason = format!("the basis `{basis:?}` has no option `{name}`; it has {has}");
            Err(SceneError::new(format!("domains.{name}"), reason))
        }
    }
}

/// What the scene wants done about domains that have outgrown their cells.
fn domain_limit<const D: usize>(domains: &DomainsInput, bodies: &[NamedBody<D>]) -> Option<DomainLimit> {
    let points: usize = bodies.iter().map(|named| named.body.n_points()).sum();
    Some(match domains.control? {
        ControlInput::Cap { cells } => {
            DomainLimit { control: DomainControl::Cap { cells: cells.0 }, most_points: points }
        }
        ControlInput::Reshape { cells } => {
            DomainLimit { control: DomainControl::Reshape { cells: cells.0 }, most_points: points }
        }
        ControlInput::Split { cells, growth } => {
            let control = DomainControl::Split { cells: cells.0 };
            DomainLimit { control, most_points: ((points as f64 * growth.0) as usize).max(points) }
        }
    })
}

fn fill_convected<const D: usize, B: Basis<D> + 'static>(
    basis: B,
    domains: &DomainsInput,
    law: &MaterialInput,
    plan: &Plan<'_, D>,
) -> Result<Filled<D>, String> {
    match domains.fallback_beyond {
        None => fill_with(basis, law, plan),
        Some(beyond) => fill_with(Fallback { basis, beyond: beyond.0 }, law, plan),
    }
}

fn fill_with<const D: usize, B: Basis<D> + 'static>(
    basis: B,
    law: &MaterialInput,
    plan: &Plan<'_, D>,
) -> Result<Filled<D>, String> {
    let elasticity =
        |young: f64, poisson: f64| Elasticity::from_young_poisson(young, poisson).map_err(|it| it.to_string());
    match law {
        MaterialInput::Hencky { young, poisson, .. } => {
            fill(basis, Hencky(elasticity(young.0, poisson.0)?), plan)
        }
        MaterialInput::VonMises { young, poisson, yield_radius, .. } => {
            let law = VonMises::new(elasticity(young.0, poisson.0)?, yield_radius.0);
            fill(basis, law.map_err(|it| it.to_string())?, plan)
        }
    }
}

fn tolerance(input: &ToleranceInput) -> Result<Tolerance, SceneError> {
    let keep_factor_below = input.keep_factor_below.map(|part| part.0);
    if let Some(part) = keep_factor_below.filter(|part| *part >= 1.0) {
        return Err(SceneError::new("tolerance.keep_factor_below", format!("is {part}, expected less than 1")));
    }
    Ok(Tolerance { residual: input.residual.0, iterations: input.iterations.0, keep_factor_below })
}

fn model<const D: usize, B: FillBody<D>>(
    scene: &SceneIn<D, B>,
    files: &dyn SceneFiles,
    room: Room,
) -> Result<Model<D>, SceneError> {
    check_domains(&scene.basis, &scene.domains)?;
    if scene.output.checkpoint.as_ref().is_some_and(|it| it.every.is_none() && it.seconds.is_none()) {
        return Err(SceneError::new("output.checkpoint", "expected `every` or `seconds`"));
    }
    let layout = layout(&scene.mesh, room)?;
    let motion = motion(&scene.motion, &layout, room)?;
    let mesh = motion.mesh_at(&layout, LoadFraction::START).map_err(|it| SceneError::new("motion", it))?;
    motion.mesh_at(&layout, LoadFraction::END).map_err(|it| SceneError::new("motion", it))?;

    let (bodies, faces) = bodies(scene, &layout, &mesh, files, room)?;
    let probes = probes(scene, &bodies)?;
    let model = Model {
        supports: supports(scene, &layout)?,
        loads: loads(scene, &bodies, faces)?,
        layout,
        motion,
        domain_limit: domain_limit(&scene.domains, &bodies),
        bodies,
        schedule: schedule(scene)?,
        path: path_control(&scene.schedule.control),
        ghost: scene.stabilisation.map(|StabilisationInput::Ghost { factor }| factor.0),
        domain_history: scene.output.domain_history,
        energies: scene.output.energies,
        probes,
        condition_history: scene.output.condition,
        solver: match scene.solver {
            SolverInput::Auto => Choice::Auto,
            SolverInput::Direct => Choice::Direct,
            SolverInput::Iterative => Choice::Iterative,
        },
        tolerance: tolerance(&scene.tolerance)?,
    };
    check_start(&model, &mesh, room)?;
    Ok(model)
}

fn layout<const D: usize>(mesh: &MeshInput, room: Room) -> Result<Layout<D>, SceneError> {
    let axes = match mesh {
        MeshInput::Box { axes } => axes,
        MeshInput::Ring { centre, radii, sectors, angles, height } => {
            let radii = axis(radii, room).map_err(|it| SceneError::new("mesh.radii", it))?;
            let height = height.as_ref().map(|it| axis(it, room)).transpose();
            let height = height.map_err(|it| SceneError::new("mesh.height", it))?;
            let span = angles.map_or(Span::Full, |(from, to)| Span::Sector {
                from: from.0.to_radians(),
                to: to.0.to_radians(),
            });
            check_ring(&radii, sectors.0, room).map_err(|it| SceneError::new("mesh", it))?;
            let ring = Layout::ring(plane_point(centre), radii, sectors.0, span, height);
            return ring.map_err(|it| match it {
                LayoutError::Lattice(LatticeError::TooFewCells { direction: 0, cells, least }) => {
                    let reason = format!("expected at least {least} cells around a full ring, got {cells}");
                    SceneError::new("mesh.sectors", reason)
                }
                it => SceneError::new("mesh", it),
            });
        }
    };
    let made: Vec<Axis> = axes
        .iter()
        .enumerate()
        .map(|(d, input)| axis(input, room).map_err(|it| SceneError::new(format!("mesh.axes[{d}]"), it)))
        .collect::<Result<_, _>>()?;
    let made: [Axis; D] = made.try_into().map_err(|made: Vec<Axis>| {
        SceneError::new("mesh.axes", format!("expected {D} axes, one per dimension, got {}", made.len()))
    })?;
    Layout::on_axes(made).map_err(|it| SceneError::new("mesh", it))
}

fn axis(input: &AxisInput, room: Room) -> Result<Axis, String> {
    match input {
        AxisInput::Uniform { from, to, cells } => Axis::uniform(from.0, to.0, cells.0),
        AxisInput::Graded { from, to, cells, ratio } => {
            room.check("the axis", f64::from(cells.0) + 1.0, size_of::<f64>())?;
            Axis::geometric(from.0, to.0, cells.0, ratio.0)
        }
        AxisInput::Nodes(nodes) => Axis::graded(nodes.iter().map(|x| x.0).collect()),
    }
    .map_err(|it| it.to_string())
}

/// A ring mesh has tables of its angles.
fn check_ring(radii: &Axis, sectors: u32, room: Room) -> Result<(), String> {
    room.check("the ring", f64::from(sectors) + f64::from(radii.cells()), 3 * size_of::<f64>())
}

fn plane_point(point: &PlanePoint) -> [f64; 2] {
    let PlanePoint((x, y)) = point;
    [x.0, y.0]
}

fn ramp(input: &RampInput, scale: f64, path: &str) -> Result<Ramp, SceneError> {
    let knots = input.0.iter().map(|(fraction, factor)| (fraction.0, factor.0 * scale)).collect();
    Ramp::new(knots).map_err(|it| SceneError::new(path, it))
}

fn component<const D: usize>(direction: Direction, path: &str) -> Result<usize, SceneError> {
    let index = direction.index();
    if index < D {
        return Ok(index);
    }
    Err(SceneError::new(path, format!("{direction:?} is not a direction of a scene in {D} dimensions")))
}

/// An even axis that is stretched in part is one no more: its nodes are listed.
fn check_stretch<const D: usize>(
    layout: &Layout<D>,
    axis: usize,
    (anchor, driven): (f64, f64),
    room: Room,
) -> Result<(), String> {
    let Layout::Box { axes, .. } = layout else { return Ok(()) };
    let axis = &axes[axis];
    if anchor.min(driven) <= axis.first() && anchor.max(driven) >= axis.last() {
        return Ok(());
    }
    room.check("the axis that is stretched in part", f64::from(axis.cells()) + 1.0, size_of::<f64>())
}

fn motion<const D: usize>(
    input: &MotionInput<D>,
    layout: &Layout<D>,
    room: Room,
) -> Result<MeshMotion<D>, SceneError> {
    match input {
        MotionInput::Fixed => Ok(MeshMotion::Fixed),
        MotionInput::Stretch(stretches) => {
            let mut planes = [const { None }; D];
            for (k, stretch) in stretches.iter().enumerate() {
                let path = format!("motion[{k}]");
                let axis = component::<D>(stretch.axis, &format!("{path}.axis"))?;
                if planes[axis].is_some() {
                    return Err(SceneError::new(path, format!("axis {:?} is stretched twice", stretch.axis)));
                }
                check_stretch(layout, axis, (stretch.anchor.0, stretch.driven.0), room)
                    .map_err(|it| SceneError::new(&path, it))?;
                planes[axis] = Some(DrivenPlane {
                    anchor: stretch.anchor.0,
                    driven: stretch.driven.0,
                    displacement: ramp(&stretch.ramp, stretch.displacement.0, &format!("{path}.ramp"))?,
                });
            }
            MeshMotion::stretch(planes).map_err(|it| SceneError::new("motion", it))
        }
        MotionInput::Corners(moved) => {
            let mut path: Vec<[Ramp; D]> = vec![std::array::from_fn(|_| Ramp::constant(0.0)); 1 << D];
            let mut given = vec![false; 1 << D];
            for (k, input) in moved.iter().enumerate() {
                let at = format!("motion[{k}]");
                let corner = box_corner(layout, &input.corner.0)
                    .map_err(|reason| SceneError::new(format!("{at}.corner"), reason))?;
                if std::mem::replace(&mut given[corner], true) {
                    return Err(SceneError::new(at, "this corner is moved twice"));
                }
                for (ramp_of, displacement) in path[corner].iter_mut().zip(input.displacement.0) {
                    *ramp_of = ramp(&input.ramp, displacement, &format!("{at}.ramp"))?;
                }
            }
            MeshMotion::corners(path).map_err(|it| SceneError::new("motion", it))
        }
        MotionInput::Rotate { centre, angle, ramp: input } => {
            let angle = ramp(input, angle.0.to_radians(), "motion.ramp")?;
            MeshMotion::rotate(plane_point(centre), angle).map_err(|it| SceneError::new("motion", it))
        }
        MotionInput::Twist { inner, outer, ramp: input, outer_ramp, reindexing } => {
            let Layout::Ring { centre, radii, .. } = layout else {
                return Err(SceneError::new("motion", "a twist needs a ring mesh"));
            };
            let inner = ramp(input, inner.0.to_radians(), "motion.ramp")?;
            let outer = match outer_ramp {
                None => ramp(input, outer.0.to_radians(), "motion.ramp")?,
                Some(input) => ramp(input, outer.0.to_radians(), "motion.outer_ramp")?,
            };
            let reindexing = match reindexing {
                ReindexingInput::WholeCells => Reindexing::WholeCells,
                ReindexingInput::Off => Reindexing::Off,
            };
            let (inner, outer) = ((radii.first(), inner), (radii.last(), outer));
            MeshMotion::twist(*centre, inner, outer, reindexing).map_err(|it| SceneError::new("motion", it))
        }
    }
}

/// Number of the corner of a box layout that stands at `x`.
fn box_corner<const D: usize>(layout: &Layout<D>, x: &[f64; D]) -> Result<usize, String> {
    let Layout::Box { axes, .. } = layout else { return Err("only a box has corners".into()) };
    let mut corner = 0;
    for (d, axis) in axes.iter().enumerate() {
        let near = 1e-9 * (axis.last() - axis.first());
        if (x[d] - axis.last()).abs() <= near {
            corner |= 1 << d;
        } else if (x[d] - axis.first()).abs() > near {
            return Err(format!("expected a corner of the mesh's box at rest, got {x:?}"));
        }
    }
    Ok(corner)
}

type BodiesAndFaces<const D: usize> = (Vec<NamedBody<D>>, Vec<Vec<Vec<(usize, f64)>>>);

/// The bodies, and for each of them the points next to the faces of its tractions, in the order of
/// the loads.
fn bodies<const D: usize, B: FillBody<D>>(
    scene: &SceneIn<D, B>,
    layout: &Layout<D>,
    start: &Mesh<D>,
    files: &dyn SceneFiles,
    room: Room,
) -> Result<BodiesAndFaces<D>, SceneError> {
    let mesh = &Mesh::at_rest(layout);
    if scene.bodies.is_empty() {
        return Err(SceneError::new("bodies", "expected at least one body"));
    }
    if let Some(k) = scene.output.fields.iter().position(|field| *field == Field::Outline).filter(|_| D != 2) {
        return Err(SceneError::new(
            format!("output.fields[{k}]"),
            format!("`Outline` is recorded in the plane only, and the scene has {D} dimensions"),
        ));
    }
    let heavy = scene.loads.iter().any(|load| matches!(load, LoadInput::BodyForce { .. }));
    let (mut bodies, mut all_faces): BodiesAndFaces<D> = (Vec::new(), Vec::new());
    for (b, input) in scene.bodies.iter().enumerate() {
        let path = format!("bodies[{b}]");
        if scene.bodies[..b].iter().any(|other| other.name == input.name) {
            return Err(SceneError::new(
                format!("{path}.name"),
                format!("a second body named `{}`", input.name),
            ));
        }
        if let Some(other) = scene.bodies[..b].iter().find(|other| overlap(other, input)) {
            return Err(SceneError::new(
                format!("{path}.shape"),
                format!("body `{}` overlaps body `{}`", input.name, other.name),
            ));
        }
        let law = scene.materials.get(&input.material).ok_or_else(|| {
            let known: Vec<&str> = scene.materials.keys().map(String::as_str).collect();
            SceneError::new(
                format!("{path}.material"),
                format!("no material named `{}`; the scene has: {}", input.material, known.join(", ")),
            )
        })?;
        let (MaterialInput::Hencky { density, .. } | MaterialInput::VonMises { density, .. }) = law;
        if heavy && density.is_none() {
            return Err(SceneError::new(
                format!("materials.{}", input.material),
                "a body force acts, so a `density` is needed",
            ));
        }
        let faces = scene.loads.iter().enumerate().filter_map(|(k, load)| match load {
            LoadInput::Traction { body, axis, at, within, .. } if *body == input.name => {
                let axis = component::<D>(*axis, &format!("loads[{k}].axis"));
                Some(axis.map(|axis| Face {
                    axis,
                    at: at.0,
                    within: within.as_ref().map(|bounds| (bounds.from.0, bounds.to.0)),
                }))
            }
            _ => None,
        });
        let refuse = |it| SceneError::new(format!("{path}.shape"), it);
        let own = WithSurface::of(&input.shape, files).map_err(refuse)?;
        let cut = cut_out(input, &scene.bodies[..b], files).map_err(refuse)?;
        let (shape, shape_mesh) = shape(&own, &cut, layout, mesh, files, room).map_err(refuse)?;
        let points_per_cell = match (&input.points_per_cell, &shape) {
            (None, Shape::Parts(_)) => 1,
            (Some(_), Shape::Parts(_)) => {
                let reason = "points that are given have no number per cell";
                return Err(SceneError::new(format!("{path}.points_per_cell"), reason));
            }
            (Some(count), _) => count.0,
            (None, _) => return Err(SceneError::new(path, "expected `points_per_cell`")),
        };
        let plan = Plan {
            start,
            shape,
            shape_mesh: &shape_mesh,
            points_per_cell,
            density: density.filter(|_| heavy).map(|density| density.0),
            keep_reference_positions: scene.output.fields.contains(&Field::Displacement)
                || scene.loads.iter().any(|load| matches!(load, LoadInput::Vortex { .. })),
            faces: faces.collect::<Result<_, _>>()?,
            room,
            mean_dilatation: input.mean_dilatation.map(|mean| match mean {
                MeanDilatationInput::Points => MeanDilatation::Points,
                MeanDilatationInput::Cell => MeanDilatation::Cell,
            }),
        };
        let filled = scene.basis.fill(&scene.domains, law, &plan).map_err(refuse)?;
        bodies.push(NamedBody {
            name: input.name.clone(),
            body: filled.body,
            shape_volume: filled.shape_volume,
        });
        all_faces.push(filled.faces);
    }
    Ok((bodies, all_faces))
}

/// A shape with the surface that it names, if it names one.
struct WithSurface<'a, const D: usize> {
    shape: &'a ShapeInput<D>,
    surface: Option<Surface>,
}

impl<'a, const D: usize> WithSurface<'a, D> {
    fn of(shape: &'a ShapeInput<D>, files: &dyn SceneFiles) -> Result<Self, String> {
        let ShapeInput::Surface { file, scale, shift } = shape else {
            return Ok(Self { shape, surface: None });
        };
        let &[x, y, z] = &shift.0[..] else {
            return Err("a surface encloses a body in three dimensions only".into());
        };
        Ok(Self { shape, surface: Some(files.surface(file)?.placed(scale.0, &[x, y, z])) })
    }

    /// What it encloses in a box mesh.
    fn solid(&self, layout: &Layout<D>) -> Result<Solid<'_>, String> {
        match (self.shape, &self.surface) {
            (_, Some(surface)) => Ok(Solid::Surface(surface)),
            (ShapeInput::Cylinder { axis, centre, radius, extent }, _) => {
                round(layout, *axis, centre, (0.0, radius.0), *extent).map(Solid::Round)
            }
            (ShapeInput::Tube { axis, centre, inner, outer, extent }, _) => {
                round(layout, *axis, centre, (inner.0, outer.0), *extent).map(Solid::Round)
            }
            _ => Err("`without`: expected bodies whose shapes are `Cylinder`, `Tube` or `Surface`".into()),
        }
    }
}

/// The shapes that are cut out of a body.
fn cut_out<'a, const D: usize>(
    body: &BodyInput<D>,
    before: &'a [BodyInput<D>],
    files: &dyn SceneFiles,
) -> Result<Vec<WithSurface<'a, D>>, String> {
    let ShapeInput::Box { without, .. } = &body.shape else { return Ok(Vec::new()) };
    let of = |name: &String| {
        let other = before.iter().find(|other| other.name == *name);
        let other = other.ok_or_else(|| format!("`without`: no body named `{name}` stands before this one"))?;
        if other.points_per_cell != body.points_per_cell {
            return Err(format!("`without`: body `{name}` has another number of points per cell"));
        }
        WithSurface::of(&other.shape, files)
    };
    without.iter().map(of).collect()
}

/// What is to be filled, and the mesh whose cells it is filled by.
fn shape<'a, const D: usize>(
    own: &'a WithSurface<'_, D>,
    cut: &'a [WithSurface<'_, D>],
    layout: &Layout<D>,
    mesh: &Mesh<D>,
    files: &dyn SceneFiles,
    room: Room,
) -> Result<(Shape<'a, D>, Mesh<D>), String> {
    let in_box = |shape| match layout {
        Layout::Box { .. } => Ok((shape, mesh.clone())),
        Layout::Ring { .. } => Err(NEEDS_BOX.into()),
    };
    match own.shape {
        ShapeInput::Box { from, to, .. } if cut.is_empty() => in_box(Shape::Box { from: from.0, to: to.0 }),
        ShapeInput::Box { from, to, .. } => {
            let without = cut.iter().map(|it| it.solid(layout)).collect::<Result<_, _>>()?;
            in_box(Shape::Rest { from: from.0, to: to.0, without })
        }
        ShapeInput::Points { file } => Ok((Shape::Parts(files.points(file, D)?.parts(mesh)?), mesh.clone())),
        ShapeInput::Cylinder { .. } | ShapeInput::Surface { .. } => in_box(Shape::Solid(own.solid(layout)?)),
        ShapeInput::Ring { inner, outer, .. } if inner.0 <= 0.0 || inner.0 >= outer.0 => {
            Err(format!("expected radii 0 < inner < outer, got {} and {}", inner.0, outer.0))
        }
        ShapeInput::Tube { inner, outer, .. } if inner.0 >= outer.0 => {
            Err(format!("expected radii 0 < inner < outer, got {} and {}", inner.0, outer.0))
        }
        ShapeInput::Ring { inner, outer, centre } => match layout {
            Layout::Ring { .. } => ring_cells(layout, mesh, centre, (inner.0, outer.0), None),
            Layout::Box { axes, .. } => ring_of_its_own(axes, centre, (inner.0, outer.0), room),
        },
        ShapeInput::Tube { axis, centre, inner, outer, extent } => match layout {
            Layout::Box { .. } => in_box(Shape::Solid(own.solid(layout)?)),
            Layout::Ring { .. } if *axis != Direction::Z => {
                Err("a tube in a ring mesh has its axis along `Z`".into())
            }
            Layout::Ring { .. } => ring_cells(layout, mesh, centre, (inner.0, outer.0), *extent),
        },
    }
}

/// The cells of a ring mesh between two of its rings of nodes, and between two heights.
fn ring_cells<'a, const D: usize>(
    layout: &Layout<D>,
    mesh: &Mesh<D>,
    centre: &PlanePoint,
    (inner, outer): (f64, f64),
    extent: Option<(Finite, Finite)>,
) -> Result<(Shape<'a, D>, Mesh<D>), String> {
    let Layout::Ring { radii, centre: mesh_centre, height, .. } = layout else {
        return Err("expected a ring mesh".into());
    };
    if plane_point(centre) != *mesh_centre {
        let [found, expected] = [plane_point(centre), *mesh_centre];
        return Err(format!("a ring in a ring mesh has the mesh's centre {expected:?}, got {found:?}"));
    }
    let ring = |radius: f64| {
        line_at(radii, radius).ok_or_else(|| format!("the mesh has no ring of nodes at radius {radius}"))
    };
    let (mut low, mut high) = ([0; D], layout.lattice().cells());
    (low[1], high[1]) = (ring(inner)?, ring(outer)?);
    if let Some((from, to)) = extent {
        let axis = height.as_ref().ok_or("`extent` is for three dimensions")?;
        let layer =
            |z: f64| line_at(axis, z).ok_or_else(|| format!("the mesh has no layer of nodes at height {z}"));
        (low[D - 1], high[D - 1]) = (layer(from.0)?, layer(to.0)?);
        if from.0 >= to.0 {
            return Err(format!("expected `extent` to ascend, got {} and {}", from.0, to.0));
        }
    }
    Ok((Shape::Cells { low, high }, mesh.clone()))
}

/// A ring of pieces about as large as the cells of a box mesh.
fn ring_of_its_own<'a, const D: usize>(
    axes: &[Axis; D],
    centre: &PlanePoint,
    (inner, outer): (f64, f64),
    room: Room,
) -> Result<(Shape<'a, D>, Mesh<D>), String> {
    let h = 0.5 * (mean_cell(&axes[0]) + mean_cell(&axes[1]));
    let pieces = |length: f64| match (length / h - 1e-9).ceil().max(1.0) {
        pieces if pieces < f64::from(u32::MAX) => Ok(pieces as u32),
        pieces => Err(format!("the ring would have {pieces:e} cells along one direction")),
    };
    let radii = Axis::uniform(inner, outer, pieces(outer - inner)?).map_err(|it| it.to_string())?;
    let sectors = pieces(std::f64::consts::PI * (inner + outer))?.max(8);
    check_ring(&radii, sectors, room)?;
    let height = axes.get(2).cloned();
    let ring = Layout::ring(plane_point(centre), radii, sectors, Span::Full, height);
    let ring = ring.map_err(|it| it.to_string())?;
    let cells = ring.lattice().cells();
    Ok((Shape::Cells { low: [0; D], high: cells }, Mesh::at_rest(&ring)))
}

/// A cylinder or tube; in the plane of thickness 1.
fn round<const D: usize>(
    layout: &Layout<D>,
    axis: Direction,
    centre: &PlanePoint,
    (inner, outer): (f64, f64),
    extent: Option<(Finite, Finite)>,
) -> Result<Round, String> {
    let Layout::Box { axes, .. } = layout else {
        return Err(NEEDS_BOX.into());
    };
    let ends = match (D, extent) {
        (2, _) if axis != Direction::Z => return Err("a disc of the plane has its axis along `Z`".into()),
        (2, Some(_)) => return Err("`extent` is for three dimensions".into()),
        (2, None) => (0.0, 1.0),
        (_, Some((from, to))) if from.0 >= to.0 => {
            return Err(format!("expected `extent` to ascend, got {} and {}", from.0, to.0));
        }
        (_, Some((from, to))) => (from.0, to.0),
        (_, None) => (axes[axis.index()].first(), axes[axis.index()].last()),
    };
    Ok(Round { axis: axis.index(), centre: plane_point(centre), inner, outer, ends })
}

fn mean_cell(axis: &Axis) -> f64 {
    (axis.last() - axis.first()) / f64::from(axis.cells())
}

fn overlap<const D: usize>(a: &BodyInput<D>, b: &BodyInput<D>) -> bool {
    let common = |a: (f64, f64), b: (f64, f64)| {
        a.1.min(b.1) - a.0.max(b.0) > 1e-9 * (a.1 - a.0).abs().min((b.1 - b.0).abs())
    };
    match (&a.shape, &b.shape) {
        (ShapeInput::Box { from: a0, to: a1, .. }, ShapeInput::Box { from: b0, to: b1, .. }) => {
            (0..D).all(|d| common((a0.0[d], a1.0[d]), (b0.0[d], b1.0[d])))
        }
        (
            ShapeInput::Ring { inner: a0, outer: a1, centre: a },
            ShapeInput::Ring { inner: b0, outer: b1, centre: b },
        ) => {
            let [[ax, ay], [bx, by]] = [plane_point(a), plane_point(b)];
            let distance = (ax - bx).hypot(ay - by);
            if distance == 0.0 { common((a0.0, a1.0), (b0.0, b1.0)) } else { distance < a1.0 + b1.0 }
        }
        // Boxes live in box meshes only; a ring beside a box is left to the user.
        _ => false,
    }
}

fn region<const D: usize>(input: &RegionInput<D>, path: &str) -> Result<Region<D>, SceneError> {
    Ok(match input {
        RegionInput::Plane { axis, at } => {
            Region::Plane { axis: component::<D>(*axis, &format!("{path}.axis"))?, at: at.0 }
        }
        RegionInput::Box { from, to } => Region::Box { from: Vector::from(from.0), to: Vector::from(to.0) },
        RegionInput::Point(x) => Region::Point(Vector::from(x.0)),
        RegionInput::Circle { centre, radius } => {
            Region::Circle { centre: plane_point(centre), radius: radius.0 }
        }
        RegionInput::Annulus { centre, inner, outer } => {
            Region::Annulus { centre: plane_point(centre), inner: inner.0, outer: outer.0 }
        }
        RegionInput::Ray { centre, angle } => {
            let (sine, cosine) = angle.0.to_radians().sin_cos();
            // At right angles exactly along the axes.
            let along = [cosine, sine].map(|x| if x.abs() < 1e-15 { 0.0 } else { x });
            Region::Ray { centre: plane_point(centre), along }
        }
        RegionInput::Everywhere => Region::Everywhere,
        RegionInput::All(regions) => Region::All(
            regions
                .iter()
                .enumerate()
                .map(|(k, input)| region(input, &format!("{path}[{k}]")))
                .collect::<Result<_, _>>()?,
        ),
    })
}

fn supports<const D: usize, B>(
    scene: &SceneIn<D, B>,
    layout: &Layout<D>,
) -> Result<Vec<Support<D>>, SceneError> {
    let mut supports: Vec<Support<D>> = Vec::with_capacity(scene.supports.len());
    let mut sought = 0.0;
    for (k, input) in scene.supports.iter().enumerate() {
        let path = format!("supports[{k}]");
        if input.name.is_empty() || input.name.contains('/') || supports.iter().any(|it| it.name == input.name)
        {
            return Err(SceneError::new(
                format!("{path}.name"),
                format!("expected a name of its own, not empty and without `/`, got `{}`", input.name),
            ));
        }
        let region = region(&input.region, &format!("{path}.region"))?;
        sought += region.candidates(layout);
        Room::check_search(sought).map_err(|it| SceneError::new(format!("{path}.region"), it))?;
        let nodes = region.nodes(layout);
        if nodes.is_empty() {
            return Err(SceneError::new(format!("{path}.region"), no_node(&region, layout)));
        }
        supports.push(Support {
            name: input.name.clone(),
            nodes,
            components: components(input, &path)?,
            moment_about: input.moment_about.as_ref().map(plane_point),
        });
    }
    refuse_contradictions(&supports)?;
    Ok(supports)
}

/// Why a region holds no node: where nodes stand instead, if that can be said.
fn no_node<const D: usize>(region: &Region<D>, layout: &Layout<D>) -> String {
    let missed = "the region holds no node of the mesh";
    match (region, layout) {
        (Region::Plane { axis, at }, Layout::Box { axes, .. }) => {
            let axis = &axes[*axis];
            let (cell, _) = axis.locate(at.clamp(axis.first(), axis.last()));
            format!("{missed}: it is at {at}, nodes are at {} and {}", axis.node(cell), axis.node(cell + 1))
        }
        _ => missed.into(),
    }
}

fn components<const D: usize>(
    input: &SupportInput<D>,
    path: &str,
) -> Result<[Option<Prescribed>; D], SceneError> {
    let held = input.fix.iter().map(|axis| Ok((*axis, Prescribed::Held)));
    let following = input.follow_mesh.iter().map(|axis| Ok((*axis, Prescribed::FollowMesh)));
    let driven = input.displace.iter().enumerate().map(|(k, displace)| {
        let ramp = ramp(&displace.ramp, displace.by.0, &format!("{path}.displace[{k}].ramp"))?;
        Ok((displace.axis, Prescribed::Driven(ramp)))
    });
    let turned = input.turn.as_ref().map(|it| turn::<D>(it, &format!("{path}.turn"))).transpose()?;
    let turned = turned.iter().flat_map(|turn| {
        let directions = [Direction::X, Direction::Y, Direction::Z];
        turn.across().map(|axis| Ok((directions[axis], Prescribed::Turned(turn.clone()))))
    });
    let mut components = [const { None }; D];
    for entry in held.chain(following).chain(driven).chain(turned) {
        let (axis, prescribed) = entry?;
        let component = component::<D>(axis, path)?;
        if components[component].is_some() {
            return Err(SceneError::new(path, format!("component {axis:?} is prescribed twice")));
        }
        components[component] = Some(prescribed);
    }
    if components.iter().all(Option::is_none) {
        return Err(SceneError::new(
            path,
            "expected `fix`, `displace` or `follow_mesh` with at least one direction, or `turn`",
        ));
    }
    Ok(components)
}

fn turn<const D: usize>(input: &TurnInput, path: &str) -> Result<Turn, SceneError> {
    if D == 2 && input.axis != Direction::Z {
        return Err(SceneError::new(format!("{path}.axis"), "in the plane nodes turn about `Z`"));
    }
    let angle = ramp(&input.ramp, input.angle.0.to_radians(), &format!("{path}.ramp"))?;
    Ok(Turn { axis: input.axis.index(), centre: plane_point(&input.centre), angle })
}

/// Two supports may share nodes only where they prescribe the same.
fn refuse_contradictions<const D: usize>(supports: &[Support<D>]) -> Result<(), SceneError> {
    for component in 0..D {
        let mut claims: Vec<(NodeId, usize)> = supports
            .iter()
            .enumerate()
            .filter(|(_, support)| support.components[component].is_some())
            .flat_map(|(k, support)| support.nodes.iter().map(move |&node| (node, k)))
            .collect();
        claims.sort_unstable();
        for pair in claims.windows(2) {
            let [(node, first), (other, second)] = [pair[0], pair[1]];
            let (a, b) = (&supports[first], &supports[second]);
            if node == other && a.components[component] != b.components[component] {
                return Err(SceneError::new(
                    format!("supports[{second}]"),
                    format!(
                        "supports `{}` and `{}` prescribe different displacements of component {} of node {}",
                        a.name,
                        b.name,
                        ["X", "Y", "Z"][component],
                        node.index()
                    ),
                ));
            }
        }
    }
    Ok(())
}

fn loads<const D: usize, B>(
    scene: &SceneIn<D, B>,
    bodies: &[NamedBody<D>],
    faces: Vec<Vec<Vec<(usize, f64)>>>,
) -> Result<Loads<D>, SceneError> {
    let mut loads = Loads { body_forces: Vec::new(), point_loads: Vec::new(), vortices: Vec::new() };
    let mut faces: Vec<_> = faces.into_iter().map(Vec::into_iter).collect();
    for (k, input) in scene.loads.iter().enumerate() {
        let path = format!("loads[{k}]");
        let find = |name: &str| {
            bodies.iter().position(|named| named.name == name).ok_or_else(|| {
                let known: Vec<&str> = bodies.iter().map(|named| named.name.as_str()).collect();
                SceneError::new(
                    format!("{path}.body"),
                    format!("no body named `{name}`; the scene has: {}", known.join(", ")),
                )
            })
        };
        let ramp_path = format!("{path}.ramp");
        match input {
            LoadInput::BodyForce { acceleration, ramp: input } => {
                loads.body_forces.push((Vector::from(acceleration.0), ramp(input, 1.0, &ramp_path)?));
            }
            LoadInput::Vortex { body: name, angle, ramp: input } => {
                let body = find(name)?;
                let material = scene.bodies[body].material.as_str();
                let Some(MaterialInput::Hencky { young, poisson, .. }) = scene.materials.get(material) else {
                    return Err(SceneError::new(path, "a vortex needs a body of `Hencky` elasticity"));
                };
                if D != 2 {
                    return Err(SceneError::new(path, "a vortex needs a scene in the plane"));
                }
                let shear = young.0 / (2.0 * (1.0 + poisson.0));
                let angle = ramp(input, angle.0.to_radians(), &ramp_path)?;
                loads.vortices.push((body, Vortex::new(shear, angle)));
            }
            LoadInput::PointForce { body: name, near, points, force, ramp: input } => {
                let body = find(name)?;
                let shares = nearest(&*bodies[body].body, &Vector::from(near.0), points.0 as usize)
                    .map_err(|it| SceneError::new(format!("{path}.points"), it))?;
                let force = Vector::from(force.0);
                loads.point_loads.push(PointLoad { body, shares, force, ramp: ramp(input, 1.0, &ramp_path)? });
            }
            LoadInput::Traction { body: name, at, resultant, ramp: input, .. } => {
                let body = find(name)?;
                let areas = faces[body].next().expect("one list of points per traction");
                let whole: f64 = areas.iter().map(|(_, area)| area).sum();
                if areas.is_empty() {
                    return Err(SceneError::new(
                        path,
                        format!("body `{name}` has no boundary on the loaded part of the plane at {}", at.0),
                    ));
                }
                let shares = areas.into_iter().map(|(point, area)| (point, area / whole)).collect();
                let force = Vector::from(resultant.0);
                loads.point_loads.push(PointLoad { body, shares, force, ramp: ramp(input, 1.0, &ramp_path)? });
            }
        }
    }
    Ok(loads)
}

fn probes<const D: usize, B>(
    scene: &SceneIn<D, B>,
    bodies: &[NamedBody<D>],
) -> Result<Vec<Probe<D>>, SceneError> {
    let mut probes: Vec<Probe<D>> = Vec::new();
    for (k, input) in scene.probes.iter().enumerate() {
        let path = format!("probes[{k}]");
        let name = &input.name;
        let is_taken = probes.iter().any(|other| other.name == *name);
        if name.is_empty() || name.contains('/') || is_taken {
            let reason = format!("expected a name of its own, without `/`, got `{name}`");
            return Err(SceneError::new(format!("{path}.name"), reason));
        }
        if let Some(ControlInput::Split { .. }) = scene.domains.control {
            let reason = "points are split by `domains.control`, and a probe cannot follow their parts";
            return Err(SceneError::new(path, reason));
        }
        let Some(body) = bodies.iter().position(|named| named.name == input.body) else {
            let known: Vec<&str> = bodies.iter().map(|named| named.name.as_str()).collect();
            let reason = format!("no body named `{}`; the scene has: {}", input.body, known.join(", "));
            return Err(SceneError::new(format!("{path}.body"), reason));
        };
        let points = &*bodies[body].body;
        let positions = || (0..points.n_points()).map(|point| points.point(point).position);
        let chosen: Vec<usize> = match &input.points {
            ProbePointsInput::All => (0..points.n_points()).collect(),
            ProbePointsInput::Near(at) => {
                let found = nearest(points, &Vector::from(at.0), 1);
                let found = found.map_err(|it| SceneError::new(format!("{path}.points"), it))?;
                found.into_iter().map(|(point, _)| point).collect()
            }
            ProbePointsInput::Within { from, to } => {
                let inside = |x: &Vector<D>| (0..D).all(|d| (from.0[d]..=to.0[d]).contains(&x[d]));
                positions().enumerate().filter(|(_, x)| inside(x)).map(|(point, _)| point).collect()
            }
        };
        if chosen.is_empty() {
            let reason = format!("holds no material point of body `{}`", input.body);
            return Err(SceneError::new(format!("{path}.points"), reason));
        }
        let mut probe = Probe { name: name.clone(), body, points: chosen, rest: Vector::zeros() };
        probe.rest = probe.mean_position(bodies);
        probes.push(probe);
    }
    Ok(probes)
}

/// The `count` points nearest to `x`, with equal shares.
fn nearest<const D: usize>(
    body: &dyn mpm_assembly::Body<D>,
    x: &Vector<D>,
    count: usize,
) -> Result<Vec<(usize, f64)>, String> {
    if count > body.n_points() {
        return Err(format!("the body has only {} material points", body.n_points()));
    }
    // Distances that differ by rounding alone count as equal, and then the order of points decides.
    let mut distances: Vec<(f64, usize)> =
        (0..body.n_points()).map(|p| ((body.point(p).position - x).norm(), p)).collect();
    let scale = distances.iter().map(|(distance, _)| *distance).fold(0.0, f64::max);
    for (distance, _) in &mut distances {
        *distance = (*distance / scale.max(f64::MIN_POSITIVE) * 1e9).round();
    }
    distances.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut shares: Vec<(usize, f64)> =
        distances[..count].iter().map(|&(_, point)| (point, 1.0 / count as f64)).collect();
    shares.sort_by_key(|&(point, _)| point);
    Ok(shares)
}

fn schedule<const D: usize, B>(scene: &SceneIn<D, B>) -> Result<Schedule, SceneError> {
    let cuts = scene.schedule.cuts;
    if cuts > Schedule::MOST_CUTS {
        let reason = format!("expected at most {} halvings, got {cuts}", Schedule::MOST_CUTS);
        return Err(SceneError::new("schedule.cuts", reason));
    }
    let predictor = match scene.schedule.predictor {
        PredictorInput::LastStep => Predictor::LastStep,
        PredictorInput::Rest => Predictor::Rest,
    };
    Ok(Schedule { steps: scene.schedule.steps.0, cuts, predictor })
}

fn path_control(control: &StepControlInput) -> Option<PathControl> {
    let StepControlInput::Path { first, longest, iterations, measure } = control else { return None };
    let measure = match measure {
        PathMeasureInput::Dissipation { most } => PathMeasure::Dissipation { most: most.map(|it| it.0) },
        PathMeasureInput::ArcLength { most } => PathMeasure::ArcLength { most: most.map(|it| it.0) },
    };
    let longest = longest.as_ref().map_or(first.0, |it| it.0);
    Some(PathControl { measure, first: first.0, longest, iterations: iterations.0 })
}

/// The start of the first load step: the mesh covers every point, and what is driven carries material.
fn check_start<const D: usize>(model: &Model<D>, mesh: &Mesh<D>, room: Room) -> Result<(), SceneError> {
    let stencils = stencils(model, mesh).map_err(|it| SceneError::new("bodies", it))?;
    let around = ActiveNodes::nodes_around(mesh.lattice(), &stencils);
    let room_for = room.check("the part of the mesh around the bodies", around as f64, size_of::<u32>());
    room_for.map_err(|it| SceneError::new("bodies", it))?;
    let active = ActiveNodes::of(mesh.lattice(), &stencils);
    for (k, support) in model.supports.iter().enumerate() {
        let driven = support.components.iter().flatten().any(|it| *it != Prescribed::Held);
        if driven && !support.nodes.iter().any(|&node| active.number(node).is_some()) {
            return Err(SceneError::new(
                format!("supports[{k}].region"),
                format!("support `{}` drives nodes, but none of them carries material", support.name),
            ));
        }
    }
    Ok(())
}
