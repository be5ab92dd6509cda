//! A fixed set of small pieces of work: timed by criterion, counted by callgrind.

use crate::{Failure, blocks};
use mpm_assembly::{
    AssemblyPlan, Body, Constraints, Converged, PassInput, SparsityPattern, Sums, TangentSums, finish_tangent,
};
use mpm_basis::{ActiveNodes, Connectivity, Stencils};
use mpm_grid::{LoadFraction, Mesh, NodeSpace, Vector};
use mpm_linear::{Factorization, Hints, LatticePlaces, LinearSolver, Matrix, Symmetry};
use mpm_material::{
    CamClay, CamClayParameters, DruckerPrager, Elasticity, Hencky, Material, MohrCoulomb, PointParameters,
    SymmetricTensor, Tresca, UndrainedStrength, VonMises, log_strain, respond,
};
use mpm_scene::language::{Scene, SolidBasis};
use mpm_scene::{Compiled, compile};
use mpm_solver::Model;
use mpm_validation::scenes::load;
use mpm_validation::variants::{ALL, Method, SMPM};
use std::hint::black_box;

/// Work that can be done again and again.
pub type Work = Box<dyn FnMut() + Send>;

/// A piece of work.
pub struct Kernel {
    /// Its name: what is done, then to what.
    pub name: String,
    prepare: Box<dyn Fn() -> Result<Work, Failure>>,
}

impl Kernel {
    fn new(name: impl Into<String>, prepare: impl Fn() -> Result<Work, Failure> + 'static) -> Self {
        Self { name: name.into(), prepare: Box::new(prepare) }
    }

    /// Prepares the work.
    ///
    /// # Errors
    /// A scene of it cannot be made or run.
    pub fn work(&self) -> Result<Work, Failure> {
        (self.prepare)()
    }
}

/// What is done, and the function that does it.
type Step<T> = (&'static str, fn(&mut T));

/// States per call of a law's kernel.
pub const STATES: usize = 1000;

/// All of them.
pub fn all() -> Vec<Kernel> {
    let mut kernels = vec![
        Kernel::new("law, Hencky, plane", || law(Hencky(elasticity()?), true)),
        Kernel::new("law, Hencky, space", || law(Hencky(elasticity()?), false)),
        Kernel::new("law, von Mises, plane", || law(VonMises::new(elasticity()?, 20.0)?, true)),
        Kernel::new("law, von Mises, space", || law(VonMises::new(elasticity()?, 20.0)?, false)),
        Kernel::new("law, Tresca, plane", || {
            law(Tresca::new(elasticity()?, UndrainedStrength::perfect(14.0)?)?, true)
        }),
        Kernel::new("law, Mohr-Coulomb, plane", || law(sand()?, true)),
        Kernel::new("law, Mohr-Coulomb with cut-off, plane", || law(sand()?.with_cut_off(5.0)?, true)),
        Kernel::new("law, Drucker-Prager, plane", || {
            law(DruckerPrager::new(elasticity()?, 0.7, 0.2, 20.0)?, true)
        }),
        Kernel::new("law, Cam-Clay, plane", || law(clay()?, true)),
        Kernel::new("logarithm of a tensor, plane", || Ok(logarithm(true))),
        Kernel::new("logarithm of a tensor, space", || Ok(logarithm(false))),
    ];
    for method in ALL {
        kernels.extend(of_body(method.name, move || plane(&method, 24)));
    }
    let solids = [
        ("sMPM 3-D", SolidBasis::Smpm),
        ("GIMP 3-D", SolidBasis::Gimp),
        ("CPDI1 3-D", SolidBasis::Cpdi1),
        ("CPDI2 hexahedra", SolidBasis::Cpdi2Hexahedron),
        ("CPDI2 tetrahedra", SolidBasis::Cpdi2Tetrahedron),
    ];
    for (name, basis) in solids {
        kernels.extend(of_body(name, move || solid(basis, 5)));
    }
    let steps: [Step<System>; 3] =
        [("order and analyse", System::analyse), ("factorise", System::factorise), ("solve", System::solve)];
    for (name, step) in steps {
        kernels.push(Kernel::new(format!("{name}, plane"), move || {
            let mut system = System::of(plane(&SMPM, 48)?)?;
            Ok(Box::new(move || step(&mut system)))
        }));
    }
    for scene in ["column", "doughnut_elastic"] {
        kernels.push(Kernel::new(format!("whole run, {scene}"), move || {
            let scene = load(scene)?;
            // It has run before, as a test of the validation: a failure here would show as a count of nothing.
            Ok(Box::new(move || drop(black_box(whole(&scene)))))
        }));
    }
    kernels
}

fn whole(scene: &Scene) -> Result<(), Failure> {
    compile(scene)?.run(&mut ())?;
    Ok(())
}

fn elasticity() -> Result<Elasticity, Failure> {
    Ok(Elasticity::from_young_poisson(1e3, 0.3)?)
}

fn sand() -> Result<MohrCoulomb, Failure> {
    Ok(MohrCoulomb::new(elasticity()?, 14.0, 20.0, 5.0)?)
}

/// Soft enough for the strains of [`states`]: κ and λ are ten times those of a clay.
fn clay() -> Result<CamClay, Failure> {
    Ok(CamClay::new(CamClayParameters {
        critical_ratio: 1.0,
        compression: 1.2,
        swelling: 0.25,
        shear: 150.0,
        shear_ratio: 0.0,
        reference_pressure: 50.0,
        preconsolidation: 50.0,
    })?)
}

/// Trial states of some ten per cent of strain, the same on every machine.
fn states(plane: bool) -> Vec<SymmetricTensor> {
    // Weyl sequences: the fractional parts of multiples of irrational numbers.
    let number = |k: usize, root: f64| 0.2 * ((k as f64 * root).fract() - 0.5);
    let state = |k: usize| SymmetricTensor {
        xx: number(k, 2_f64.sqrt()),
        yy: number(k, 3_f64.sqrt()),
        zz: number(k, 5_f64.sqrt()),
        xy: number(k, 7_f64.sqrt()),
        yz: if plane { 0.0 } else { number(k, 11_f64.sqrt()) },
        zx: if plane { 0.0 } else { number(k, 13_f64.sqrt()) },
    };
    (1..=STATES).map(state).collect()
}

/// Stress and spatial moduli of many states.
fn law<M: Material + 'static>(law: M, plane: bool) -> Result<Work, Failure> {
    let (states, history) = (states(plane), law.initial(&PointParameters::at(nalgebra::Vector3::zeros())));
    Ok(Box::new(move || {
        for state in &states {
            let Ok(response) = respond(&law, black_box(state), &history) else { return };
            if plane {
                black_box((response.kirchhoff, response.tangent.spatial_tangent::<2>()));
            } else {
                black_box((response.kirchhoff, response.tangent.spatial_tangent::<3>()));
            }
        }
    }))
}

fn logarithm(plane: bool) -> Work {
    let states = states(plane);
    Box::new(move || {
        for state in &states {
            black_box(log_strain(black_box(state)));
        }
    })
}

/// A body connected to its mesh, and a small increment.
pub(crate) struct Connected<const D: usize> {
    pub body: Box<dyn Body<D>>,
    pub mesh: Mesh<D>,
    pub active: ActiveNodes<D>,
    pub pattern: SparsityPattern<D>,
    pub plan: AssemblyPlan<D>,
    pub constraints: Constraints<D>,
    increment: Vec<Vector<D>>,
    internal: Vec<Vector<D>>,
    /// Of the tangent, after a pass with it.
    pub values: Vec<f64>,
}

type Parts<const D: usize> = (ActiveNodes<D>, SparsityPattern<D>, AssemblyPlan<D>);

fn connect<const D: usize>(mesh: &Mesh<D>, stencils: Stencils<D>, symmetry: Symmetry) -> Parts<D> {
    let active = ActiveNodes::of(&NodeSpace::vertices(mesh.lattice().clone()), std::slice::from_ref(&stencils));
    let connectivity = Connectivity::of(stencils, &active);
    let pattern = SparsityPattern::of(active.len(), symmetry, &[&connectivity]);
    let plan = AssemblyPlan::new(connectivity, &pattern);
    (active, pattern, plan)
}

impl<const D: usize> Connected<D> {
    /// The first body of a model in the mesh of a load fraction.
    pub fn of(model: Model<D>, at: LoadFraction) -> Result<Self, Failure> {
        let mesh = model.motion.mesh_at(&model.layout, at)?;
        let supports = model.supports;
        let body = model.bodies.into_iter().next().ok_or("the scene has no body")?.body;
        let (active, pattern, plan) = connect(&mesh, body.stencils(&mesh)?, body.symmetry());
        let mut constraints = Constraints::none(active.len());
        for support in &supports {
            for node in support.nodes.iter().filter_map(|&node| active.number(node)) {
                for component in (0..D).filter(|&i| support.components[i].is_some()) {
                    constraints.prescribe(node, component, 0.0);
                }
            }
        }
        let increment = active.nodes().iter().map(|&node| {
            let x = mesh.position(node);
            Vector::from_fn(|i, _| 1e-3 * x[i] * x[(i + 1) % D] / x.norm().max(1.0))
        });
        let increment = increment.collect();
        let (internal, values) = (vec![Vector::zeros(); active.len()], vec![0.0; pattern.n_entries()]);
        Ok(Self { body, mesh, active, pattern, plan, constraints, increment, internal, values })
    }

    /// The same with the increment `field` of the nodes' positions `[L]`.
    pub fn strained(mut self, field: impl Fn(Vector<D>) -> Vector<D>) -> Self {
        let nodes = self.active.nodes().iter();
        self.increment = nodes.map(|&node| field(self.mesh.position(node))).collect();
        self
    }

    fn stencils(&mut self) {
        drop(black_box(self.body.stencils(&self.mesh)));
    }

    /// Connects the points to the mesh anew and forgets it.
    pub fn connect(&mut self) {
        if let Ok(stencils) = self.body.stencils(&self.mesh) {
            black_box(connect(&self.mesh, stencils, self.body.symmetry()));
        }
    }

    /// Internal force under the increment, and the tangent where asked for.
    pub fn pass(&mut self, tangent: bool) {
        let input = PassInput {
            pattern: &self.pattern,
            constraints: &self.constraints,
            increment: &self.increment,
            own: &[],
        };
        self.internal.fill(Vector::zeros());
        self.values.fill(0.0);
        let tangent =
            tangent.then_some(TangentSums { values: &mut self.values, lift: None, own_lift: &mut [] });
        let sums = Sums { internal: &mut self.internal, own: &mut [], tangent };
        let _ = black_box(self.body.assemble(&self.plan, input, sums));
    }

    /// Works out the points at the end of the increment and forgets them with the next call.
    pub fn advance(&mut self) {
        let step = Converged { mesh: &self.mesh, active: &self.active, increment: &self.increment, own: &[] };
        let _ = black_box(self.body.prepare(&self.plan, step));
    }
}

fn plane(method: &Method, cells: u32) -> Result<Connected<2>, Failure> {
    match run(&blocks::plane(method, cells, 1)?)? {
        Compiled::Plane(model) => Connected::of(model, LoadFraction::END),
        Compiled::Solid(_) => Err("expected a scene in plane strain".into()),
    }
}

fn solid(basis: SolidBasis, cells: u32) -> Result<Connected<3>, Failure> {
    match run(&blocks::solid(basis, cells, 1)?)? {
        Compiled::Solid(model) => Connected::of(model, LoadFraction::END),
        Compiled::Plane(_) => Err("expected a scene in space".into()),
    }
}

fn run(scene: &Scene) -> Result<Compiled, Failure> {
    let mut compiled = compile(scene)?;
    compiled.run(&mut ())?;
    Ok(compiled)
}

/// What is done with a body in a load step.
fn of_body<const D: usize>(
    name: &'static str,
    make: impl Fn() -> Result<Connected<D>, Failure> + Clone + 'static,
) -> Vec<Kernel> {
    let steps: [Step<Connected<D>>; 5] = [
        ("stencils", Connected::stencils),
        ("connect", Connected::connect),
        ("internal force", |it| it.pass(false)),
        ("force and tangent", |it| it.pass(true)),
        ("advance", Connected::advance),
    ];
    let kernel = |(what, step): Step<Connected<D>>| {
        let make = make.clone();
        Kernel::new(format!("{what}, {name}"), move || {
            let mut connected = make()?;
            // A kernel that fails would be counted as very fast: try it once before.
            connected.body.stencils(&connected.mesh)?;
            Ok(Box::new(move || step(&mut connected)))
        })
    };
    steps.into_iter().map(kernel).collect()
}

/// The linear system of a connected body.
struct System {
    pattern: SparsityPattern<2>,
    values: Vec<f64>,
    lattice: Vec<[u32; 3]>,
    rhs: Vec<f64>,
    factorization: Factorization,
}

impl System {
    fn of(mut connected: Connected<2>) -> Result<Self, Failure> {
        connected.pass(true);
        finish_tangent(&connected.pattern, &connected.constraints, &mut connected.values);
        let pattern = connected.pattern;
        let mut system = Self {
            values: connected.values,
            lattice: connected.active.lattice_indices(),
            rhs: vec![1.0; pattern.n_equations()],
            factorization: Factorization::new(),
            pattern,
        };
        system.analyse();
        system
            .factorization
            .factorise(Matrix { pattern: system.pattern.for_solver(), values: &system.values })?;
        Ok(system)
    }

    fn analyse(&mut self) {
        // The direct solver does not ask where the lines stand.
        let lines = Default::default();
        let places = LatticePlaces { index: &self.lattice, lines: &lines, periods: [None; 3], degree: [1; 3] };
        // A solver that has seen the pattern before would keep its analysis.
        self.factorization = Factorization::new();
        let _ = black_box(self.factorization.analyse(self.pattern.for_solver(), &Hints::on_lattice(places)));
    }

    fn factorise(&mut self) {
        let matrix = Matrix { pattern: self.pattern.for_solver(), values: &self.values };
        let _ = black_box(self.factorization.factorise(matrix));
    }

    fn solve(&mut self) {
        let mut x = self.rhs.clone();
        let matrix = Matrix { pattern: self.pattern.for_solver(), values: &self.values };
        let _ = black_box(self.factorization.solve(matrix, &mut x, 0.0));
    }
}

/// Where callgrind begins and ends to count: nothing may be inlined here, and the name is part of
/// how `counts` calls callgrind.
#[inline(never)]
pub fn counted_region(work: &mut Work) {
    work();
}
