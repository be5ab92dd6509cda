//! Completeness and gradients on graded boxes, the patch test, and what the model refuses.

use super::*;
use mpm_assembly::{GhostStabilisation, MaterialBody, MeanDilatation};
use mpm_basis::{Completeness, Smpm};
use mpm_grid::{Layout, LoadFraction};
use mpm_solver::Model;

const KIND: NodeKind = NodeKind::ControlPoints { degree: 2 };

fn graded() -> Result<Layout<2>, Box<dyn Error>> {
    Ok(Layout::on_axes([Axis::geometric(-1.0, 2.0, 5, 3.0)?, Axis::graded(vec![0.0, 0.4, 1.0])?])?)
}

#[test]
fn linear_fields_are_reproduced_and_gradients_are_differences() -> Result<(), Box<dyn Error>> {
    let layout = graded()?;
    let pulled = DrivenPlane { anchor: -1.0, driven: 1.1, displacement: Ramp::linear(0.7) };
    let motion = MeshMotion::stretch([Some(pulled), None])?;
    for mesh in [Mesh::at_rest(&layout), motion.mesh_at(&layout, LoadFraction::END)?] {
        let basis = QuadraticSplines { nodes: NodeSpace::of(KIND, &mesh)? };
        let stencil = |x: Vector<2>| {
            let mut stencil = Stencil::new();
            basis.influences(&mesh, &x, &(), &mut stencil).map(|()| stencil)
        };
        for k in 0..200 {
            let share = |step: f64| (0.013 + step * f64::from(k)).fract();
            let x = Vector::<2>::new(-0.99 + 2.97 * share(0.618_034), 0.01 + 0.98 * share(0.414_214));
            let found = Completeness::of(&basis, &mesh, &x, &())?;
            assert!(found.is_within(1e-12), "{x}: {found}");
            for d in 0..2 {
                let mut step = Vector::<2>::zeros();
                step[d] = 1e-6;
                let (above, below) = (stencil(x + step)?, stencil(x - step)?);
                for (it, (a, b)) in
                    stencil(x)?.entries().iter().zip(above.entries().iter().zip(below.entries()))
                {
                    // Quadratic in the cell: the difference has no error but rounding, unless a knot is in between.
                    let difference = (a.value - b.value) / 2e-6;
                    assert!(a.node != it.node || (difference - it.gradient[d]).abs() < 1e-5, "{x}, {d}");
                }
            }
        }
    }
    Ok(())
}

#[test]
fn a_homogeneous_stretch_stays_so() -> Result<(), Box<dyn Error>> {
    let error = patch()?;
    assert!(error < 1e-12, "{error:e}");
    Ok(())
}

/// Why the model that `change` makes of a square of splines does not run.
fn refusal(change: impl FnOnce(&mut Model<2>)) -> Result<String, Box<dyn Error>> {
    let mesh = Mesh::at_rest(&mpm_examples::layout()?);
    let basis = QuadraticSplines { nodes: NodeSpace::of(KIND, &mesh)? };
    let law = Hencky(Elasticity::from_young_poisson(1000.0, 0.3)?);
    let mut square = model((basis, law), MeshMotion::Fixed, Vec::new(), 1)?;
    change(&mut square);
    Ok(run(&mut square, &mut ()).expect_err("the model is refused").to_string())
}

#[test]
fn what_needs_other_nodes_is_refused() -> Result<(), Box<dyn Error>> {
    let law = || Hencky(Elasticity::from_young_poisson(1000.0, 0.3).expect("possible constants"));
    let other = || Box::new(MaterialBody::new(Smpm, law(), []));
    assert_eq!(
        refusal(|model| model.add_body("other", other()))?,
        "body `other` lives on vertices (basis sMPM), the model on control points of degree 2: \
         all bodies of a model need its nodes, expected a basis on them"
    );
    assert_eq!(
        refusal(|model| model.add_contribution("ghost", Box::new(GhostStabilisation::new(0.1))))?,
        "contribution `ghost` needs vertices, and the model lives on control points of degree 2"
    );
    let nodes = NodeSpace::of(KIND, &Mesh::at_rest(&mpm_examples::layout()?))?;
    let body = MaterialBody::new(QuadraticSplines { nodes }, law(), []);
    let mean = body.with_mean_dilatation(Some(MeanDilatation::Cell));
    assert_eq!(
        refusal(|model| model.add_body("soft", Box::new(mean)))?,
        "body `soft` averages volume changes over cells, which needs vertices, and lives on control points of degree 2 \
         (basis quadratic splines)"
    );
    let middle = Region::Plane { axis: 0, at: 0.25 };
    let said = refusal(|model| model.add_support("middle", &middle, [Some(Prescribed::Held), None]))?;
    assert!(said.starts_with("support `middle` holds node 5 of the control points of degree 2"), "{said}");
    Ok(())
}
