//! Bases and laws: what points of a body are under.

use super::gradient::regularisation;
use super::initial::{Beginning, Starts, refused, starts};
use super::law::{Refusal, Refused, Site, WithLaw, inside, with_law};
use super::parameters::fields_of;
use super::quantity::Fields;
use crate::error::SceneError;
use crate::fill::{Filled, Plan, body, seeds};
use crate::language::{
    ControlInput, CornerWeightsInput, DomainsInput, GimpUpdateInput, MaterialInput, PlaneBasis, SolidBasis,
    TrianglesInput,
};
use crate::places::{Place, at};
use mpm_assembly::{InSpace, RefusedStart, ShippedBasis, ShippedLaw};
use mpm_basis::{
    CornerWeights, Cpdi1, Cpdi2Hexahedron, Cpdi2Tetrahedron, Cpdi2q, Cpdi2t, DomainControl, Fallback, Gimp,
    GimpUpdate, Smpm, TriangleSplit,
};
use mpm_material::{PerPoint, PointHistory, SymmetricTensor, Varied};
use mpm_solver::DomainLimit;

/// The bases of one space: makes bodies of points under the one that the scene names.
pub(super) trait FillBody<const D: usize>: std::fmt::Debug {
    fn fill(
        &self,
        domains: &DomainsInput,
        beginning: &Beginning<'_>,
        plan: &Plan<'_, D>,
    ) -> Result<Filled<D>, Refusal>;

    /// Fields of [`DomainsInput`] that the basis has a use for.
    fn options(&self) -> &'static [&'static str];
}

impl FillBody<2> for PlaneBasis {
    fn fill(
        &self,
        domains: &DomainsInput,
        beginning: &Beginning<'_>,
        plan: &Plan<'_, 2>,
    ) -> Result<Filled<2>, Refusal> {
        match self {
            PlaneBasis::Smpm => fill_with(Smpm, beginning, plan),
            PlaneBasis::Gimp => fill_with(gimp(domains), beginning, plan),
            PlaneBasis::Cpdi1 => fill_with(Cpdi1, beginning, plan),
            PlaneBasis::Cpdi2q => {
                let weights = match domains.corner_weights {
                    None | Some(CornerWeightsInput::Current) => CornerWeights::Current,
                    Some(CornerWeightsInput::Frozen) => CornerWeights::Frozen,
                };
                fill_convected(Cpdi2q { weights }, domains, beginning, plan)
            }
            PlaneBasis::Cpdi2t => {
                let split = match domains.triangles {
                    None | Some(TrianglesInput::Cross) => TriangleSplit::Cross,
                    Some(TrianglesInput::Slash) => TriangleSplit::Slash,
                    Some(TrianglesInput::Backslash) => TriangleSplit::Backslash,
                };
                fill_convected(Cpdi2t { split }, domains, beginning, plan)
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
        beginning: &Beginning<'_>,
        plan: &Plan<'_, 3>,
    ) -> Result<Filled<3>, Refusal> {
        match self {
            SolidBasis::Smpm => fill_with(Smpm, beginning, plan),
            SolidBasis::Gimp => fill_with(gimp(domains), beginning, plan),
            SolidBasis::Cpdi1 => fill_with(Cpdi1, beginning, plan),
            SolidBasis::Cpdi2Hexahedron => fill_convected(Cpdi2Hexahedron, domains, beginning, plan),
            SolidBasis::Cpdi2Tetrahedron => fill_convected(Cpdi2Tetrahedron, domains, beginning, plan),
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
    places: &[Vec<Place<D>>],
) -> Option<DomainLimit> {
    let points: usize = places.iter().map(Vec::len).sum();
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

fn fill_convected<const D: usize, B: ShippedBasis<D>>(
    basis: B,
    domains: &DomainsInput,
    beginning: &Beginning<'_>,
    plan: &Plan<'_, D>,
) -> Result<Filled<D>, Refusal>
where
    Fallback<B>: ShippedBasis<D>,
    ShippedLaw: InSpace<D>,
{
    match domains.fallback_beyond {
        None => fill_with(basis, beginning, plan),
        Some(beyond) => fill_with(Fallback { basis, beyond: beyond.0 }, beginning, plan),
    }
}

fn fill_with<const D: usize, B: ShippedBasis<D>>(
    basis: B,
    beginning: &Beginning<'_>,
    plan: &Plan<'_, D>,
) -> Result<Filled<D>, Refusal>
where
    ShippedLaw: InSpace<D>,
{
    let law = beginning.law;
    let seeded = seeds(&basis, plan, history_bytes(law).map_err(Refusal::Law)?)?;
    let positions = seeded.positions();
    let mut starts = starts(beginning, &positions)?;
    let numbers = seeded.numbers.clone();
    if let Some(numbers) = numbers.as_ref().filter(|_| !starts.points.is_empty()) {
        starts.points = at(&starts.points, numbers);
    }
    let fields = Fields::new(beginning.files);
    let site = positions.get(starts.stiffest).map(|position| Site { fields: &fields, position });
    let shipped = with_law(law, site, Chosen(&starts)).map_err(Refusal::Law)?;
    let law = match law.gradient() {
        None => shipped.in_space(plan.space),
        Some(input) => {
            let refused = |it| Refusal::Law(inside(".gradient")(it));
            let law = regularisation(input).and_then(|it| shipped.regularised(it)).map_err(refused)?;
            law.expect("a law without plastic strain is refused before")
        }
    };
    body(basis, law, seeded, (&starts.points, starts.density.as_ref()), plan).map_err(
        |RefusedStart { point, reason }| {
            let stress = starts.points[point].stress.unwrap_or(SymmetricTensor::ZERO);
            Refusal::Initial(refused(
                beginning.initial,
                (&stress, plan.space),
                &positions[numbers.map_or(point, |numbers| numbers[point] as usize)],
                reason.reason,
            ))
        },
    )
}

/// The law under which points are: wrapped laws are the one for points with parameters of their own, too, so that fewer
/// kinds of bodies are compiled.
struct Chosen<'a>(&'a Starts);

impl WithLaw for Chosen<'_> {
    type Answer = ShippedLaw;

    fn with<M: Varied + Into<ShippedLaw>>(self, law: M) -> ShippedLaw {
        if self.0.has_own { self.with_wrapped(law) } else { law.into() }
    }

    fn with_wrapped<M: Varied>(self, law: M) -> ShippedLaw {
        let Self(starts) = self;
        let law = PerPoint::new(law);
        if starts.has_own {
            law.for_points(starts.points.iter().filter_map(|start| start.own.as_ref())).into()
        } else {
            law.into()
        }
    }
}

/// Bytes that a law remembers of each point.
fn history_bytes(input: &MaterialInput) -> Result<usize, Refused> {
    struct Size;
    impl WithLaw for Size {
        type Answer = usize;

        fn with<M: Varied + Into<ShippedLaw>>(self, _law: M) -> usize {
            size_of::<M::History>()
        }

        fn with_wrapped<M: Varied>(self, _law: M) -> usize {
            size_of::<PointHistory>()
        }
    }
    if fields_of(input).is_empty() { with_law(input, None, Size) } else { Ok(size_of::<PointHistory>()) }
}
