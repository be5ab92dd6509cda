//! Completeness on a sheared ring, and the patch test through the solver.

use super::*;
use mpm_grid::{Axis, Block, Layout, LoadFraction, Reindexing, Span};

#[test]
fn linear_fields_are_reproduced() -> Result<(), Box<dyn Error>> {
    let layout = Layout::ring([0.0, 0.0], Axis::uniform(5.0, 10.0, 5)?, 32, Span::Full, None)?;
    let turned = (5.0, Ramp::linear(0.4));
    let twist = MeshMotion::twist([0.0, 0.0], turned, (10.0, Ramp::constant(0.0)), Reindexing::Off)?;
    for mesh in [Mesh::at_rest(&layout), twist.mesh_at(&layout, LoadFraction::END)?] {
        for k in 0..100 {
            let (radius, angle) = (5.5 + 0.04 * f64::from(k), 0.7 * f64::from(k));
            let x = Vector::<2>::new(radius * angle.cos(), radius * angle.sin());
            let mut stencil = Stencil::new();
            Averaged.influences(&mesh, &x, &HalfEdge(0.3), &mut stencil)?;
            stencil.finish();
            let (mut one, mut here) = (0.0, Vector::<2>::zeros());
            let (mut zero, mut identity) = (Vector::<2>::zeros(), Block::<2>::zeros());
            for it in stencil.entries() {
                one += it.value;
                here += it.value * mesh.position(it.node);
                zero += it.gradient;
                identity += mesh.position(it.node) * it.gradient.transpose();
            }
            assert!((one - 1.0).abs() < 1e-13, "Σ S = {one}");
            assert!((here - x).norm() < 1e-12, "Σ S x_v = {here}, not {x}");
            assert!(zero.norm() < 1e-12, "Σ ∇S = {zero}");
            assert!((identity - Block::<2>::identity()).norm() < 1e-11, "Σ x_v ⊗ ∇S = {identity}");
        }
    }
    Ok(())
}

#[test]
fn a_homogeneous_stretch_stays_so() -> Result<(), Box<dyn Error>> {
    let error = pull()?;
    assert!(error < 1e-9, "{error:e}");
    Ok(())
}
