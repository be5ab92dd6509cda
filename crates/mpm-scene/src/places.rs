//! The places of the points of a body as they are made, of which a rank keeps its share.

use crate::share::ShareOfPoints;
use mpm_assembly::Space;
use mpm_basis::Seed;
use mpm_contact::Tool;
use mpm_grid::Vector;
use std::f64::consts::TAU;
use std::ops::Range;

/// A point of a body as loads and probes see it, also one that another rank makes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place<const D: usize> {
    /// Position at rest `[L]`.
    pub position: Vector<D>,
    /// Its volume, of a body of revolution the area of its cross section `[L^D]`.
    pub size: f64,
}

impl<const D: usize> Place<D> {
    /// Volume at rest, of a body of revolution that of the ring `[L^D]` or `[L³]`.
    pub(crate) fn volume(&self, space: Space) -> f64 {
        match space {
            Space::Cartesian => self.size,
            Space::Axisymmetric => TAU * self.position[0] * self.size,
        }
    }
}

/// What a point carries of a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FaceShare<const D: usize> {
    pub point: usize,
    /// Its area of the face `[L^(D-1)]`.
    pub area: f64,
    /// From the point to the middle of that area `[L]`.
    pub arm: Vector<D>,
}

/// Those of some values that have these numbers.
pub(crate) fn at<T: Clone>(values: &[T], numbers: &[u64]) -> Vec<T> {
    numbers.iter().map(|&number| values[number as usize].clone()).collect()
}

/// The points of a body as they are made.
pub(crate) struct Points<S, const D: usize> {
    /// Numbers of those that are made here.
    own: Range<usize>,
    /// Number of the first place.
    first: usize,
    pub seeds: Vec<S>,
    /// Numbers of the seeds, where they are not all.
    pub numbers: Vec<u64>,
    is_share: bool,
    pub places: Vec<Place<D>>,
}

impl<const D: usize, Domain> Points<Seed<D, Domain>, D> {
    /// None yet, of so many, from this number on.
    pub fn of(share: ShareOfPoints, count: f64, first: usize) -> Self {
        let (seeds, numbers, places) = (Vec::new(), Vec::new(), Vec::new());
        let mut own = share.range(count);
        if share.rank + 1 == share.ranks {
            // A point more than was counted is lost on no rank.
            own.end = usize::MAX;
        }
        Self { own, first, seeds, numbers, is_share: !share.is_all(), places }
    }

    /// Adds those that come next.
    pub fn append(&mut self, next: Self) {
        self.seeds.extend(next.seeds);
        self.numbers.extend(next.numbers);
        self.places.extend(next.places);
    }

    /// Makes room for so many in all.
    pub fn reserve(&mut self, count: f64) {
        let count = count as usize;
        let own = self.own.end.min(count).saturating_sub(self.own.start);
        self.seeds.reserve_exact(own);
        self.places.reserve_exact(count);
        if self.is_share {
            self.numbers.reserve_exact(own);
        }
    }

    /// Takes the next ones, and keeps those that are made here; their places among those taken.
    pub fn take(&mut self, next: &mut Vec<Seed<D, Domain>>) -> Range<usize> {
        let first = self.places.len();
        for seed in next.drain(..) {
            let number = self.first + self.places.len();
            self.places.push(Place { position: seed.position, size: seed.volume });
            if !self.is_share {
                self.seeds.push(seed);
            } else if self.own.contains(&number) {
                self.seeds.push(seed);
                self.numbers.push(number as u64);
            }
        }
        first..self.places.len()
    }

    /// Gives all of them together this volume.
    pub fn fill(&mut self, volume: f64) {
        let filled: f64 = self.places.iter().map(|place| place.size).sum();
        self.places.iter_mut().for_each(|place| place.size *= volume / filled);
        self.seeds.iter_mut().for_each(|seed| seed.volume *= volume / filled);
    }

    /// Leaves out those that stand inside a tool.
    pub fn leave_out(&mut self, tools: &[Tool<D>], faces: &mut [Vec<FaceShare<D>>]) -> Result<(), String> {
        if tools.is_empty() {
            return Ok(());
        }
        let mut kept = 0;
        let number = |place: &Place<D>| {
            let is_kept = !tools.iter().any(|tool| tool.contains(&place.position));
            kept += usize::from(is_kept);
            is_kept.then(|| kept - 1)
        };
        let now: Vec<Option<usize>> = self.places.iter().map(number).collect();
        if kept == 0 {
            return Err("all of its points stand inside the tools that it is without".into());
        }
        let before = |k: usize| if self.is_share { self.numbers[k] as usize } else { k };
        let of_seeds: Vec<Option<usize>> = (0..self.seeds.len()).map(|k| now[before(k)]).collect();
        retain(&mut self.seeds, &of_seeds);
        retain(&mut self.places, &now);
        if self.is_share {
            self.numbers = of_seeds.into_iter().flatten().map(|number| number as u64).collect();
        }
        for shares in faces {
            let renumbered = |share: &FaceShare<D>| Some(FaceShare { point: now[share.point]?, ..*share });
            *shares = shares.iter().filter_map(renumbered).collect();
        }
        Ok(())
    }
}

/// Keeps the items that still have a number.
fn retain<T>(items: &mut Vec<T>, numbers: &[Option<usize>]) {
    let mut number = numbers.iter();
    items.retain(|_| number.next().is_some_and(Option::is_some));
}

/// A part of a face, given to the one of some points that is nearest to its centre.
pub(crate) fn face_share<const D: usize>(
    places: &[Place<D>],
    of: Range<usize>,
    area: f64,
    centre: &Vector<D>,
) -> Option<FaceShare<D>> {
    let distance = |p: usize| (places[p].position - centre).norm_squared();
    let point = of.min_by(|&a, &b| distance(a).total_cmp(&distance(b)))?;
    Some(FaceShare { point, area, arm: centre - places[point].position })
}
