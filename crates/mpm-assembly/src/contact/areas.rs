//! The area of adhesion: the tool's surface, shared by the corners next to it.
//!
//! Areas of domains are no measure of it: of a body that is cut at an angle to its domains only a few tips touch. Each
//! sample of the tool's surface that lies before a domain at the surface is shared by the corners whose feet lie within
//! their reach w of it, by `1 - d/w`, so that the corners' areas sum to that of the surface in the soil.

use mpm_contact::{Bounds, Sample, Tool};
use mpm_grid::Vector;
use std::array::from_fn;

/// Samples for each width of a domain.
const SAMPLES: f64 = 4.0;

/// How far around the box in which samples are needed they are made, in its longest edge: the box moves with the tool.
const AROUND: f64 = 0.05;

/// A corner that lies at the tool's surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Member<const D: usize> {
    /// The nearest place of the surface, in the tool's frame `[L]`.
    pub foot: Vector<D>,
    /// Width of its point's domain `[L]`.
    pub width: f64,
    /// Distance from the foot within which samples are shared: the width, or the domain's extent along the surface `[L]`.
    reach: f64,
    /// Unit vectors along the surface; the first D - 1 count.
    along: [Vector<D>; 2],
    /// How far the domain reaches along each, from the foot `[L]`.
    extent: [[f64; 2]; 2],
}

impl<const D: usize> Member<D> {
    /// Numbers of a member.
    pub const NUMBERS: usize = 2 + 2 * (D + 2) + D;

    pub fn write(&self, to: &mut Vec<f64>) {
        to.extend(self.foot.iter().chain([&self.width, &self.reach]));
        to.extend(self.along.iter().flat_map(|along| along.iter()));
        to.extend(self.extent.as_flattened());
    }

    /// What was [written](Self::write).
    pub fn read(from: &[f64]) -> Self {
        let vector = |at: usize| Vector::<D>::from_column_slice(&from[at..at + D]);
        let last = &from[2 + 3 * D..];
        Self {
            foot: vector(0),
            width: from[D],
            reach: from[D + 1],
            along: [vector(D + 2), vector(2 * D + 2)],
            extent: [[last[0], last[1]], [last[2], last[3]]],
        }
    }
}

/// Part of a domain's width within which a sample counts as being before it.
const AT_THE_EDGE: f64 = 1e-9;

impl<const D: usize> Member<D> {
    /// A corner of a domain whose `corners`, all in the tool's frame, is next to the surface at `foot` `[L]`, where that
    /// has the normal `n`.
    pub fn new(foot: Vector<D>, n: &Vector<D>, width: f64, corners: impl Iterator<Item = Vector<D>>) -> Self {
        let along = tangents(n);
        let mut extent = [[0.0_f64; 2]; 2];
        for corner in corners {
            for (along, extent) in along.iter().zip(&mut extent).take(D - 1) {
                let at = along.dot(&(corner - foot));
                *extent = [extent[0].min(at), extent[1].max(at)];
            }
        }
        let longest = extent.iter().map(|[low, high]| high - low).fold(0.0, f64::max);
        Self { foot, width, reach: width.max(longest), along, extent }
    }

    /// Whether a place of the surface lies before the domain.
    fn covers(&self, x: &Vector<D>) -> bool {
        let slack = AT_THE_EDGE * self.width;
        let within = |d: usize| {
            let at = self.along[d].dot(&(x - self.foot));
            self.extent[d][0] - slack <= at && at <= self.extent[d][1] + slack
        };
        (0..D - 1).all(within)
    }
}

/// D - 1 unit vectors at right angles to a unit vector and to each other.
fn tangents<const D: usize>(n: &Vector<D>) -> [Vector<D>; 2] {
    let mut tangents = [Vector::zeros(); 2];
    // The axes that lie closest to the plane, made orthogonal.
    let mut axes: [usize; D] = from_fn(|d| d);
    axes.sort_by(|&a, &b| n[a].abs().total_cmp(&n[b].abs()));
    for k in 0..D - 1 {
        let mut tangent = Vector::<D>::from_fn(|d, _| f64::from(u8::from(d == axes[k])));
        for other in tangents[..k].iter().chain([n]) {
            tangent -= other * other.dot(&tangent);
        }
        tangents[k] = tangent.normalize();
    }
    tangents
}

/// How close samples lie, and the box that they are needed in; none without members.
pub(super) fn sampling<'a, const D: usize>(
    members: impl Iterator<Item = &'a Member<D>> + Clone,
) -> Option<(f64, Bounds<D>)> {
    let least = members.clone().map(|member| member.width).fold(f64::INFINITY, f64::min);
    let most = members.clone().map(|member| member.reach).fold(0.0, f64::max);
    let bounds = Bounds::around(members.map(|member| &member.foot));
    least.is_finite().then(|| (least / SAMPLES, bounds.grown(most)))
}

/// Samples of a tool's surface, part by part, in the tool's frame.
#[derive(Clone, Debug)]
pub(super) struct Samples<const D: usize> {
    spacing: f64,
    within: Bounds<D>,
    of_parts: Vec<Vec<Sample<D>>>,
}

impl<const D: usize> Default for Samples<D> {
    fn default() -> Self {
        Self { spacing: 0.0, within: Bounds::empty(), of_parts: Vec::new() }
    }
}

impl<const D: usize> Samples<D> {
    /// Samples in a box; of a tool of finite size those around it are made, too, for later steps.
    pub fn of(&mut self, tool: &Tool<D>, spacing: f64, within: &Bounds<D>) -> &[Vec<Sample<D>>] {
        let is_finite = tool.bounds().is_finite();
        let holds = |x: &Vector<D>| self.within.contains(x);
        let is_kept = is_finite && self.spacing == spacing && holds(&within.from) && holds(&within.to);
        if !is_kept {
            let margin = if is_finite { AROUND * (within.to - within.from).amax() } else { 0.0 };
            let within = within.grown(margin);
            *self = Self { spacing, within, of_parts: tool.samples(spacing, &within) };
        }
        &self.of_parts
    }
}

/// Each member's share of the surface of a part `[L^(D-1)]`; `area` is that of a sample, or nothing where it does not count.
pub(super) fn shares<const D: usize>(
    members: &[Member<D>],
    samples: &[Sample<D>],
    area: impl Fn(&Sample<D>) -> Option<f64>,
) -> Vec<f64> {
    let mut shares = vec![0.0; members.len()];
    let reach = members.iter().map(|member| member.reach).fold(0.0, f64::max);
    if reach == 0.0 {
        return shares;
    }
    let cell = |x: &Vector<D>| -> [i64; D] { from_fn(|d| (x[d] / reach).floor() as i64) };
    let mut by_cell: Vec<([i64; D], usize)> =
        members.iter().enumerate().map(|(k, member)| (cell(&member.foot), k)).collect();
    by_cell.sort_unstable();
    let mut near: Vec<(usize, f64)> = Vec::new();
    for sample in samples {
        near.clear();
        let mut is_covered = false;
        let own = cell(&sample.position);
        // Cells beside each other along the last direction follow each other in the list.
        for side in 0..3_usize.pow(D as u32 - 1) {
            let beside = |d: usize| own[d].saturating_add((side / 3_usize.pow(d as u32) % 3) as i64 - 1);
            let first: [i64; D] = from_fn(|d| if d == D - 1 { own[d].saturating_sub(1) } else { beside(d) });
            let last: [i64; D] = from_fn(|d| if d == D - 1 { own[d].saturating_add(1) } else { beside(d) });
            let start = by_cell.partition_point(|(at, _)| *at < first);
            for (_, k) in by_cell[start..].iter().take_while(|(at, _)| *at <= last) {
                let weight = 1.0 - (members[*k].foot - sample.position).norm() / members[*k].reach;
                if weight > 0.0 {
                    near.push((*k, weight));
                    is_covered |= members[*k].covers(&sample.position);
                }
            }
        }
        let Some(area) = is_covered.then(|| area(sample)).flatten() else { continue };
        let whole: f64 = near.iter().map(|(_, weight)| weight).sum();
        for (k, weight) in &near {
            shares[*k] += area * weight / whole;
        }
    }
    shares
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_sum_to_the_surface_within_reach() {
        // Ten squares of 0.1 on the x axis: two corners each.
        let normal = Vector::<2>::new(0.0, 1.0);
        let at = |x: f64, y: f64| Vector::<2>::new(x, y);
        let square = |k: usize| {
            let (low, high) = (0.1 * k as f64, 0.1 * (k + 1) as f64);
            let corners = [at(low, 0.0), at(high, 0.0), at(low, 0.1), at(high, 0.1)];
            [low, high].map(|x| Member::new(at(x, 0.0), &normal, 0.1, corners.into_iter()))
        };
        let members: Vec<Member<2>> = (0..10).flat_map(square).collect();
        let (spacing, within) = sampling(members.iter()).unwrap();
        assert!((spacing - 0.025).abs() < 1e-15);
        assert!(within.contains(&Vector::<2>::new(1.1, -0.1)));
        let sample = |k: usize| Sample { position: at(0.025 * k as f64 - 0.9875, 0.0), normal, area: 0.025 };
        let samples: Vec<Sample<2>> = (0..120).map(sample).collect();
        let shares = shares(&members, &samples, |it| Some(it.area));
        assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-14);
        assert!(shares[3..17].iter().all(|share| (share - 0.05).abs() < 1e-13), "{shares:?}");
    }

    #[test]
    fn what_lies_far_away_is_nobodys() {
        let corners = [Vector::<3>::zeros(), Vector::<3>::new(0.0, 0.5, 0.0)];
        let member = Member::new(Vector::<3>::zeros(), &Vector::<3>::z(), 0.5, corners.into_iter());
        let sample = Sample { position: Vector::<3>::new(0.0, 0.6, 0.0), normal: Vector::<3>::z(), area: 1.0 };
        assert_eq!(shares(&[member], &[sample], |it| Some(it.area)), [0.0]);
        assert_eq!(shares::<3>(&[], &[sample], |it| Some(it.area)), [] as [f64; 0]);
    }
}
