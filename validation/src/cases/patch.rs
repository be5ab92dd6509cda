//! Patch tests.

use super::largest;
use crate::history::History;
use crate::probe::{plane, solid};
use crate::scenes::load_own;
use crate::{Broken, Case, Check, Extent, Findings};
use mpm_grid::{Block, NodeId, Ramp, Vector};
use mpm_scene::language::{MaterialInput, MeanDilatationInput, Scene, SolidBasis};
use mpm_solver::observe::Field;
use mpm_solver::{Model, Prescribed, Support};

pub(super) const CASE: Case = Case {
    name: "patch test",
    goal: "A deformation that is the same everywhere is found exactly.",
    setup: "Blocks in the plane and in space, of graded cells, and of cells in which the points stand off centre; every node that has not all its cells full is displaced by a linear field with stretch, shear and rotation, up to 30 %. Elastic and von Mises under standard MPM; elastic in space under every other basis; some of these with mean dilatation.",
    reference: "The deformation gradient of the linear field at every point; the same stress at every point.",
    run,
};

fn run(_: Extent) -> Result<Findings, Broken> {
    let mut checks = Vec::new();
    for elastic in [true, false] {
        checks.extend(patch(plane(&scene("patch_plane_graded", elastic)?)?, "plane, graded", (0.0, 4.0))?);
        checks.extend(patch(plane(&scene("patch_plane_shifted", elastic)?)?, "plane, off centre", (0.5, 3.5))?);
        checks.extend(patch(solid(&scene("patch_solid_graded", elastic)?)?, "space, graded", (0.0, 4.0))?);
        checks.extend(patch(solid(&scene("patch_solid_shifted", elastic)?)?, "space, off centre", (0.5, 3.5))?);
    }
    let bases = [
        (SolidBasis::Gimp, "GIMP"),
        (SolidBasis::Cpdi1, "CPDI1"),
        (SolidBasis::Cpdi2Hexahedron, "CPDI2 hexahedra"),
        (SolidBasis::Cpdi2Tetrahedron, "CPDI2 tetrahedra"),
    ];
    for (basis, name) in bases {
        for (file, place, free) in
            // The domains fill the cells from 1 to 4 only, so the nodes at 1 have cells that are not full.
            [
                ("patch_solid_graded", "graded", (0.0, 4.0)),
                ("patch_solid_shifted", "off centre", (1.5, 3.5)),
            ]
        {
            let mut scene = scene(file, true)?;
            if let Scene::Solid(scene) = &mut scene {
                scene.basis = basis;
            }
            checks.extend(patch(solid(&scene)?, &format!("space, {place}, {name}"), free)?);
        }
    }
    for mean in [MeanDilatationInput::Points, MeanDilatationInput::Cell] {
        for (file, place, free) in
            [("patch_plane_graded", "graded", (0.0, 4.0)), ("patch_plane_shifted", "off centre", (0.5, 3.5))]
        {
            let mut scene = scene(file, false)?;
            if let Scene::PlaneStrain(scene) = &mut scene {
                scene.bodies.iter_mut().for_each(|body| body.mean_dilatation = Some(mean));
            }
            checks.extend(patch(plane(&scene)?, &format!("plane, {place}, mean dilatation {mean:?}"), free)?);
        }
        let mut scene = scene("patch_solid_graded", true)?;
        if let Scene::Solid(scene) = &mut scene {
            scene.basis = SolidBasis::Cpdi1;
            scene.bodies.iter_mut().for_each(|body| body.mean_dilatation = Some(mean));
        }
        let name = format!("space, graded, CPDI1, mean dilatation {mean:?}");
        checks.extend(patch(solid(&scene)?, &name, (0.0, 4.0))?);
    }
    Ok(checks.into())
}

/// The scene with its von Mises metal, or without the yielding.
fn scene(name: &str, elastic: bool) -> Result<Scene, Broken> {
    let mut scene = load_own(name)?;
    let materials = match &mut scene {
        Scene::PlaneStrain(scene) | Scene::Axisymmetric(scene) => &mut scene.materials,
        Scene::Solid(scene) => &mut scene.materials,
    };
    for law in materials.values_mut() {
        if let (true, MaterialInput::VonMises { young, poisson, density, .. }) = (elastic, law.clone()) {
            *law = MaterialInput::Hencky { young, poisson, gradient: None, density };
        }
    }
    Ok(scene)
}

/// Nodes with all coordinates strictly inside `free` are free.
fn patch<const D: usize>(mut model: Model<D>, name: &str, free: (f64, f64)) -> Result<Vec<Check>, Broken> {
    let rows = [[0.2, 0.3, -0.1], [-0.1, -0.15, 0.2], [0.15, 0.1, 0.1]];
    let gradient = Block::<D>::from_fn(|i, j| rows[i][j]);
    let outer = model.supports.pop().expect("the scene has a support to start from");
    let nodes = (0..model.layout.lattice().n_nodes()).filter_map(NodeId::from_index);
    model.supports = nodes
        .filter_map(|node| {
            let x: Vector<D> = model.layout.position(node);
            let held = x.iter().any(|&x| x <= free.0 || x >= free.1);
            let driven = (gradient * x).map(|by| Some(Prescribed::Driven(Ramp::linear(by))));
            let components = std::array::from_fn(|i| driven[i].clone());
            held.then(|| Support {
                name: node.index().to_string(),
                nodes: vec![node],
                components,
                ..outer.clone()
            })
        })
        .collect();

    let mut history = History::of(&[Field::DEFORMATION_GRADIENT, Field::CAUCHY_STRESS, Field::PLASTIC]);
    mpm_solver::run(&mut model, &mut history)?;
    let free_components = history.series("equations", 0)[1];
    let plastic = history.field(Field::PLASTIC, 1);
    let kind = if plastic.contains(&1.0) { "plastic" } else { "elastic" };

    let f = history.field(Field::DEFORMATION_GRADIENT, 1).chunks_exact(9);
    let error = largest(f.flat_map(|f| {
        let expected = |i: usize, j: usize| f64::from(u8::from(i == j)) + gradient[(i, j)];
        (0..D * D).map(move |k| (f[3 * (k / D) + k % D] - expected(k / D, k % D)).abs()).collect::<Vec<_>>()
    }));
    let stress = history.field(Field::CAUCHY_STRESS, 1);
    let size = largest(stress.iter().map(|x| x.abs()));
    let spread =
        largest(stress.chunks_exact(9).flat_map(|s| s.iter().zip(stress).map(|(a, b)| (a - b).abs() / size)));
    Ok(vec![
        Check::new(format!("deformation gradient, {name}, {kind}"), error, 1e-11)
            .remark(format!("{free_components} free components of displacement")),
        Check::new(format!("stress, difference between points, {name}, {kind}"), spread, 1e-10),
    ])
}
