//! Between load steps: domains that have outgrown their cells, see [`mpm_basis::domain_control`].

use crate::error::Error;
use crate::model::{Loads, Model, Share};
use crate::progress::DomainCounts;
use crate::ranks::{Ranks, any, count};
use mpm_grid::LoadFraction;

/// Shortens or splits the domains that are too long in the mesh at a load fraction, and hands the loads
/// of points that were split to their parts.
///
/// # Errors
/// More points than the limit; the body that could not be split has not changed.
pub(crate) fn control_domains<const D: usize>(
    model: &mut Model<D>,
    (at, step): (LoadFraction, usize),
    ranks: &dyn Ranks<D>,
) -> Result<DomainCounts, Error> {
    let mut counts = DomainCounts::default();
    let Some(limit) = model.domain_limit else { return Ok(counts) };
    // A mesh that cannot be placed stops the next load step, with its reason.
    let Ok(mesh) = model.motion.mesh_at(&model.layout, at) else { return Ok(counts) };
    let of_all = |points: usize| count(ranks, points as u64) as usize;
    let mut points = of_all(model.bodies.iter().map(|named| named.body.n_points()).sum());
    for index in 0..model.bodies.len() {
        let named = &mut model.bodies[index];
        // Those of other bodies, and those of other ranks.
        let others = points - of_all(named.body.n_points());
        let elsewhere = points - named.body.n_points();
        let room = limit.most_points.saturating_sub(elsewhere);
        let controlled = named.body.control(&mesh, limit.control, room);
        let after = others + of_all(named.body.n_points());
        let is_full = any(ranks, controlled.is_err()) || after > limit.most_points.max(points);
        let controlled = controlled.ok().filter(|_| !is_full).ok_or_else(|| {
            let body = named.name.clone();
            Error::TooManyPoints { step, body, points, most: limit.most_points }
        })?;
        points = after;
        counts.capped += controlled.capped as u64;
        counts.split += controlled.split as u64;
        if !controlled.parts.is_empty() {
            divide_shares(&mut model.loads, index, &controlled.parts);
            for named in &mut model.contributions {
                named.contribution.divide(index, &controlled.parts);
            }
        }
        ranks.split(index, &controlled.parts);
    }
    let DomainCounts { capped, split } = counts;
    Ok(DomainCounts { capped: count(ranks, capped), split: count(ranks, split) })
}

/// Every part of a point carries its share of the point's.
fn divide_shares<const D: usize>(loads: &mut Loads<D>, body: usize, parts: &[(usize, f64)]) {
    for load in loads.point_loads.iter_mut().filter(|load| load.body == body) {
        let shares = std::mem::take(&mut load.shares);
        for share in shares {
            let first = parts.partition_point(|&(parent, _)| parent < share.point);
            let own = parts[first..].iter().take_while(|&&(parent, _)| parent == share.point);
            // The parts keep their point's centre and deformation gradient, so that with its arm they keep the moment.
            load.shares.extend(own.enumerate().map(|(k, &(_, part))| Share {
                point: first + k,
                part: share.part * part,
                arm: share.arm,
            }));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::PointLoad;
    use mpm_grid::{Ramp, Vector};

    #[test]
    fn shares_follow_the_parts_and_keep_their_sum() {
        let share = |(point, part)| Share { point, part, arm: Vector::<2>::new(0.0, 0.5) };
        let load = |body, shares: Vec<(usize, f64)>| PointLoad {
            body,
            shares: shares.into_iter().map(share).collect(),
            force: Vector::<2>::new(1.0, 0.0),
            ramp: Ramp::new(vec![(0.0, 0.0), (1.0, 1.0)]).unwrap(),
        };
        let mut loads = Loads {
            body_forces: Vec::new(),
            point_loads: vec![load(0, vec![(1, 0.25), (2, 0.75)]), load(1, vec![(1, 1.0)])],
            side_loads: Vec::new(),
            fields: Vec::new(),
        };
        // Point 0 became two, point 1 stayed, point 2 became three.
        divide_shares(&mut loads, 0, &[(0, 0.5), (0, 0.5), (1, 1.0), (2, 0.5), (2, 0.25), (2, 0.25)]);
        let shares = [(2, 0.25), (3, 0.375), (4, 0.1875), (5, 0.1875)].map(share);
        assert_eq!(loads.point_loads[0].shares, shares);
        assert_eq!(shares.iter().map(|it| it.part).sum::<f64>(), 1.0);
        assert_eq!(loads.point_loads[1].shares, [share((1, 1.0))]);
    }
}
