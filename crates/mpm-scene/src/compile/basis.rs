//! Bases and laws: what points of a body are under.

use super::law::{WithLaw, with_law};
use crate::error::SceneError;
use crate::fill::{Filled, Plan, fill};
use crate::language::{
    ControlInput, CornerWeightsInput, DomainsInput, GimpUpdateInput, MaterialInput, PlaneBasis, SolidBasis,
    TrianglesInput,
};
use mpm_basis::{
    Basis, CornerWeights, Cpdi1, Cpdi2Hexahedron, Cpdi2Tetrahedron, Cpdi2q, Cpdi2t, DomainControl, Fallback,
    Gimp, GimpUpdate, Smpm, TriangleSplit,
};
use mpm_material::Material;
use mpm_solver::DomainLimit;
use mpm_solver::NamedBody;

/// The bases of one space: makes bodies of points under the one that the scene names.
pub(super) trait FillBody<const D: usize>: std::fmt::Debug {
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
        Some(GimpUpdateInput::Fixed) => GimpUpdate::Fixed,
    };
    Gimp { update }
}

/// An option that the basis would ignore is refused.
pub(super) fn check_domains<const D: usize, B: FillBody<D>>(
    basis: &B,
    domains: &DomainsInput,
) -> Result<(), SceneError> {
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
pub(super) fn domain_limit<const D: usize>(
    domains: &DomainsInput,
    bodies: &[NamedBody<D>],
) -> Option<DomainLimit> {
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
    struct Filling<'a, const D: usize, B> {
        basis: B,
        plan: &'a Plan<'a, D>,
    }
    impl<const D: usize, B: Basis<D> + 'static> WithLaw for Filling<'_, D, B> {
        type Answer = Result<Filled<D>, String>;

        fn with<M: Material + 'static>(self, law: M) -> Self::Answer {
            fill(self.basis, law, self.plan)
        }
    }
    with_law(law, Filling { basis, plan }).map_err(|it| it.to_string())?
}
