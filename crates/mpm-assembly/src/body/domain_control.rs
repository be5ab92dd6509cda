//! Between load steps: points whose domains have outgrown their cells, see [`mpm_basis::domain_control`].

use crate::body::kinematics::inverse_and_determinant;
use crate::body::points::Points;
use crate::body::space::Space;
use mpm_basis::domain_control::{cap, is_too_long, reshape, split};
use mpm_basis::parallel::each_point;
use mpm_basis::{Basis, DomainControl, DomainPart};
use mpm_grid::{Mesh, Vector};

/// What has been done about the domains of a body.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Controlled {
    /// Domains that were shortened.
    pub capped: usize,
    /// Points that were split.
    pub split: usize,
    /// Where points were split, for every point of now its point of before and its share of that, in
    /// the order of the points; else empty.
    pub parts: Vec<(usize, f64)>,
}

/// Splitting would make more points than it may; nothing has been done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("points would be split into more than {most} points")]
pub struct TooManyPoints {
    /// The most points that were allowed.
    pub most: usize,
}

/// Shortens or splits all domains that are too long in `mesh`.
///
/// Parts take the place of their point, see [`Points::divided`]; where any point was split, the positions of all
/// points are returned, too.
///
/// # Errors
/// More points than `most`; nothing has changed.
pub(crate) fn control<const D: usize, B: Basis<D>>(
    basis: &B,
    position: &[Vector<D>],
    domains: &mut Vec<B::Domain>,
    mesh: &Mesh<D>,
    control: DomainControl,
    (most, space): (usize, Space),
) -> Result<(Controlled, Vec<Vector<D>>), TooManyPoints> {
    match control {
        DomainControl::Cap { cells } => {
            let done = shortened(position, domains, |x, domain| cap(mesh, x, domain, cells));
            Ok((done, Vec::new()))
        }
        DomainControl::Reshape { cells } => {
            let done = shortened(position, domains, |x, domain| reshape(mesh, x, domain, cells));
            Ok((done, Vec::new()))
        }
        DomainControl::Split { cells } => {
            let (split, parts) = divided(basis, (position, domains), mesh, cells, (most, space))?;
            if split == 0 {
                return Ok((Controlled::default(), Vec::new()));
            }
            let positions = parts.iter().map(|(_, part)| part.position).collect();
            let shares = parts.iter().map(|(p, part)| (*p, part.share)).collect();
            *domains = parts.into_iter().map(|(_, part)| part.domain).collect();
            Ok((Controlled { split, parts: shares, ..Controlled::default() }, positions))
        }
    }
}

/// Counts the domains that `shorten` has found too long.
fn shortened<const D: usize, Domain: Clone + Send + Sync>(
    position: &[Vector<D>],
    domains: &mut [Domain],
    shorten: impl Fn(&Vector<D>, &mut Domain) -> bool + Sync,
) -> Controlled {
    let next: Vec<(bool, Domain)> = each_point(domains.len(), &|p| {
        let mut domain = domains[p].clone();
        (shorten(&position[p], &mut domain), domain)
    });
    let mut capped = 0;
    for (domain, (is_shorter, next)) in domains.iter_mut().zip(next) {
        *domain = next;
        capped += usize::from(is_shorter);
    }
    Controlled { capped, ..Controlled::default() }
}

/// Parts of points, each with the number of its point.
type PartsOf<const D: usize, Domain> = Vec<(usize, DomainPart<D, Domain>)>;

/// Number of points that are split, and if any is, the parts of all points in order; a point that is not split is
/// its own part.
fn divided<const D: usize, B: Basis<D>>(
    basis: &B,
    (position, domains): (&[Vector<D>], &[B::Domain]),
    mesh: &Mesh<D>,
    cells: f64,
    (most, space): (usize, Space),
) -> Result<(usize, PartsOf<D, B::Domain>), TooManyPoints> {
    let long: Vec<bool> = each_point(domains.len(), &|p| is_too_long(mesh, &position[p], &domains[p], cells));
    if !long.contains(&true) {
        return Ok((0, Vec::new()));
    }
    let mut next = Vec::with_capacity(long.len());
    let mut n_split = 0;
    for (p, &is_long) in long.iter().enumerate() {
        let (position, domain) = (position[p], &domains[p]);
        // Every point after this one needs its place too.
        let room = most.saturating_sub(next.len() + long.len() - p - 1);
        let mut parts = if is_long { split(basis, mesh, &position, domain, cells, room) } else { Vec::new() };
        if space.is_axisymmetric() && parts.iter().any(|part| part.position[0] <= 0.0) {
            // A part beyond the axis would stand for no ring.
            parts.clear();
        }
        if parts.len() > room {
            return Err(TooManyPoints { most });
        }
        if parts.is_empty() {
            next.push((p, DomainPart { position, domain: domain.clone(), share: 1.0 }));
        }
        n_split += usize::from(!parts.is_empty());
        next.extend(parts.into_iter().map(|part| (p, part)));
    }
    Ok((n_split, next))
}

impl<const D: usize> Points<D> {
    /// The points of now, of which `parts` says the point of before and the share of that. They have its F and elastic
    /// state, their shares of its volume and mass, and rest where F says they did.
    pub(crate) fn divided(&self, parts: &[(usize, f64)], position: &[Vector<D>]) -> Self {
        let mut next = Self { space: self.space, ..Self::default() };
        for (&(p, share), x) in parts.iter().zip(position) {
            next.push_part(self, p, *x, share);
        }
        next
    }

    /// Adds a part of point `p` of `points`, which stands at `position`; columns that are empty there stay so.
    fn push_part(&mut self, points: &Self, p: usize, position: Vector<D>, share: f64) {
        let f = points.deformation_gradient[p];
        if let Some(rest) = points.reference_position.get(p) {
            let offset = position - points.position[p];
            self.reference_position.push(rest + inverse_and_determinant(&f).0 * offset);
        }
        self.position.push(position);
        self.reference_volume.push(points.reference_volume[p] * share);
        self.mass.extend(points.mass.get(p).map(|mass| mass * share));
        self.deformation_gradient.push(f);
        self.hoop_stretch.extend(points.hoop_stretch.get(p));
        self.angle.extend(points.angle.get(p));
        self.elastic_excess.push(points.elastic_excess[p]);
        self.plastic.extend(points.plastic.get(p));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mpm_basis::Cpdi1;
    use mpm_grid::{Axis, Block, Layout, LinearCell};
    use mpm_material::SymmetricTensor;

    type Domains = Vec<<Cpdi1 as Basis<2>>::Domain>;

    /// Two points of a body that has been sheared by 6, and a third that has not.
    fn sheared() -> (Points<2>, Domains, Mesh<2>) {
        let axis = || Axis::uniform(0.0, 10.0, 10).unwrap();
        let mesh = Mesh::at_rest(&Layout::on_axes([axis(), axis()]).unwrap());
        let (mut places, mut domains) = (Vec::new(), Domains::new());
        for x in [4.5, 5.0, 5.5] {
            let corner = |c: usize| Vector::<2>::new(x + 0.5 * (c & 1) as f64, 5.0 + 0.25 * (c & 2) as f64);
            Cpdi1.seed(&LinearCell::new(std::array::from_fn(corner)), &mut |seed| {
                places.push((seed.position, seed.volume));
                domains.push(seed.domain);
            });
        }
        let mut points = Points::<2>::at_rest(Space::Cartesian, &places, true);
        points.elastic_excess = vec![SymmetricTensor::ZERO; places.len()];
        points.reference_position = points.position.clone();
        points.mass = points.reference_volume.iter().map(|volume| 3.0 * volume).collect();
        let f = Block::<2>::new(1.0, 6.0, 0.0, 1.0);
        for (p, domain) in domains.iter_mut().enumerate().take(2) {
            points.position[p] += Vector::<2>::new(0.1, 0.2);
            points.deformation_gradient[p] = f;
            domain.current = f * domain.initial;
            points.elastic_excess[p] = SymmetricTensor { xy: 0.01 * (p + 1) as f64, ..SymmetricTensor::ZERO };
            points.plastic[p] = p == 1;
        }
        (points, domains, mesh)
    }

    fn total<const D: usize>(x: &[Vector<D>], weight: &[f64]) -> Vector<D> {
        x.iter().zip(weight).map(|(x, weight)| x * *weight).sum()
    }

    #[test]
    fn splitting_keeps_mass_volume_their_centres_and_the_state() {
        let (before, mut domains_after, mesh) = sheared();
        let how = DomainControl::Split { cells: 1.0 };
        let (done, position) =
            control(&Cpdi1, &before.position, &mut domains_after, &mesh, how, (100, Space::Cartesian)).unwrap();
        let after = before.divided(&done.parts, &position);
        assert_eq!((done.capped, done.split), (0, 2));
        assert!(after.len() > 4 && done.parts.len() == after.len());
        assert_eq!(done.parts[after.len() - 1], (2, 1.0));
        for column in [&after.mass, &after.reference_volume] {
            assert_eq!(column.len(), after.len());
        }
        assert_eq!(after.mass.iter().sum::<f64>(), before.mass.iter().sum::<f64>());
        assert_eq!(after.reference_volume.iter().sum::<f64>(), before.reference_volume.iter().sum::<f64>());
        for (now, then) in
            [(&after.position, &before.position), (&after.reference_position, &before.reference_position)]
        {
            let off = total(now, &after.mass) - total(then, &before.mass);
            assert!(off.norm() < 1e-12, "{off}");
        }
        for (p, &(parent, share)) in done.parts.iter().enumerate() {
            assert_eq!(after.mass[p], before.mass[parent] * share);
            assert_eq!(after.deformation_gradient[p], before.deformation_gradient[parent]);
            assert_eq!(after.elastic_excess[p], before.elastic_excess[parent]);
            assert_eq!(after.plastic[p], before.plastic[parent]);
            let domain = &domains_after[p];
            assert!((after.deformation_gradient[p] * domain.initial - domain.current).norm() < 1e-15);
        }
    }

    #[test]
    fn shortening_changes_nothing_but_domains() {
        let (before, domains, mesh) = sheared();
        for how in [DomainControl::Cap { cells: 1.0 }, DomainControl::Reshape { cells: 1.0 }] {
            let mut after = domains.clone();
            let (done, position) =
                control(&Cpdi1, &before.position, &mut after, &mesh, how, (3, Space::Cartesian)).unwrap();
            assert_eq!(done, Controlled { capped: 2, ..Controlled::default() });
            assert!(position.is_empty(), "the points stay");
            assert!(after[0] != domains[0] && after[2] == domains[2]);
        }
    }

    #[test]
    fn too_many_points_are_refused_and_nothing_changes() {
        let (before, domains, mesh) = sheared();
        let mut after = domains.clone();
        let how = DomainControl::Split { cells: 1.0 };
        let refused = control(&Cpdi1, &before.position, &mut after, &mesh, how, (5, Space::Cartesian));
        assert_eq!(refused, Err(TooManyPoints { most: 5 }));
        assert_eq!(after, domains);
    }
}
