//! Completeness on a sheared ring, and the patch test through the solver.

use super::*;
use mpm_basis::Completeness;
use mpm_grid::{Axis, Layout, LoadFraction, Reindexing, Span};

#[test]
fn linear_fields_are_reproduced() -> Result<(), Box<dyn Error>> {
    let layout = Layout::ring([0.0, 0.0], Axis::uniform(5.0, 10.0, 5)?, 32, Span::Full, None)?;
    let turned = (5.0, Ramp::linear(0.4));
    let twist = MeshMotion::twist([0.0, 0.0], turned, (10.0, Ramp::constant(0.0)), Reindexing::Off)?;
    for mesh in [Mesh::at_rest(&layout), twist.mesh_at(&layout, LoadFraction::END)?] {
        for k in 0..100 {
            let (radius, angle) = (5.5 + 0.04 * f64::from(k), 0.7 * f64::from(k));
            let x = Vector::<2>::new(radius * angle.cos(), radius * angle.sin());
            let found = Completeness::of(&Averaged, &mesh, &x, &HalfEdge(0.3))?;
            assert!(found.is_within(1e-12), "{found}");
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
