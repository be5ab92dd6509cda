//! Mends what programs that write surfaces leave behind: corners that are equal up to rounding, and facets without area.
//!
//! Nothing moves where corners at equal coordinates close the surface already.

use crate::crossing::is_flat;
use crate::triangles::Triangles;
use nalgebra::Vector3;
use std::collections::BTreeMap;

/// Corners of an open surface that are so close are one vertex [extent of the surface].
const CLOSE: f64 = 2e-8;

/// The same of the largest coordinate: files that have single precision round each corner by itself.
const ROUNDING: f64 = f32::EPSILON as f64;

/// Triangles, and what they were before they were mended.
pub(crate) struct Numbered {
    pub(crate) triangles: Triangles,
    /// The triangle that each facet came from, counted from 1.
    pub(crate) numbers: Vec<usize>,
}

impl Numbered {
    /// Facets of triangles whose corners are equal, without those that have no area; or, if `nearly`, none up to rounding.
    pub(crate) fn of(triangles: &[[[f64; 3]; 3]], nearly: bool) -> Self {
        let numbers = (1..=triangles.len()).collect();
        let mut it = Self { triangles: Triangles::weld(triangles), numbers };
        it.drop_collapsed();
        let open = it.open_vertices();
        if !open.is_empty() {
            it.weld_close(&open);
            it.drop_collapsed();
        }
        it.flip_flat(if nearly { it.close() } else { 0.0 });
        it
    }

    /// What corners are off by `[L]`.
    fn close(&self) -> f64 {
        let (low, high) = self.triangles.bounds();
        CLOSE * (high - low).max() + ROUNDING * low.amax().max(high.amax())
    }

    /// Whether the corners of a facet lie on a line, or so close to it `[L]`.
    fn is_flat(&self, facet: &[u32; 3], close: f64) -> bool {
        let corners = facet.map(|vertex| self.triangles.vertices[vertex as usize]);
        let [a, b, c] = corners;
        let longest = [b - a, c - b, a - c].iter().map(Vector3::norm).fold(0.0, f64::max);
        is_flat(&corners) || (b - a).cross(&(c - a)).norm() <= close * longest
    }

    /// Drops facets with fewer than three vertices: their sides cancel each other.
    fn drop_collapsed(&mut self) {
        let keep = |facet: &[u32; 3]| facet[0] != facet[1] && facet[1] != facet[2] && facet[2] != facet[0];
        if self.triangles.facets.iter().all(keep) {
            return;
        }
        let kept: Vec<usize> =
            (0..self.triangles.facets.len()).filter(|&k| keep(&self.triangles.facets[k])).collect();
        self.numbers = kept.iter().map(|&k| self.numbers[k]).collect();
        self.triangles.facets = kept.iter().map(|&k| self.triangles.facets[k]).collect();
        self.drop_unused();
    }

    /// Drops vertices of no facet.
    fn drop_unused(&mut self) {
        let Triangles { vertices, facets } = &mut self.triangles;
        let mut is_used = vec![false; vertices.len()];
        facets.iter().flatten().for_each(|&vertex| is_used[vertex as usize] = true);
        let mut next = 0;
        let number: Vec<u32> = is_used.iter().map(|&used| (next, next += u32::from(used)).0).collect();
        let mut used = is_used.iter();
        vertices.retain(|_| used.next() == Some(&true));
        facets.iter_mut().flatten().for_each(|vertex| *vertex = number[*vertex as usize]);
    }

    /// Ends of edges that belong to one facet only, in ascending order.
    fn open_vertices(&self) -> Vec<u32> {
        let mut edges: Vec<[u32; 2]> = self.triangles.facets.iter().flat_map(sides).collect();
        edges.iter_mut().for_each(|edge| edge.sort_unstable());
        edges.sort_unstable();
        let open = edges.chunk_by(|a, b| a == b).filter(|same| same.len() == 1);
        let mut vertices: Vec<u32> = open.flat_map(|same| same[0]).collect();
        vertices.sort_unstable();
        vertices.dedup();
        vertices
    }

    /// Makes one of vertices that are close to each other.
    fn weld_close(&mut self, candidates: &[u32]) {
        let (low, close) = (self.triangles.bounds().0, self.close());
        let at = |vertex: u32| self.triangles.vertices[vertex as usize];
        // Boxes of that size: what is close lies in a neighbour.
        let place = |x: &Vector3<f64>| [0, 1, 2].map(|d| ((x[d] - low[d]) / close).floor() as i64);
        let mut boxes: BTreeMap<[i64; 3], Vec<u32>> = BTreeMap::new();
        let mut one_of: Vec<u32> = (0..self.triangles.vertices.len() as u32).collect();
        let root = |one_of: &[u32], mut vertex: u32| {
            while one_of[vertex as usize] != vertex {
                vertex = one_of[vertex as usize];
            }
            vertex
        };
        for &vertex in candidates {
            let x = at(vertex);
            let here = place(&x);
            for neighbour in 0..27_i64 {
                let shift = [neighbour % 3 - 1, neighbour / 3 % 3 - 1, neighbour / 9 - 1];
                let there = boxes.get(&[0, 1, 2].map(|d| here[d] + shift[d]));
                for &other in there.into_iter().flatten().filter(|&&other| (at(other) - x).amax() <= close) {
                    let (a, b) = (root(&one_of, vertex), root(&one_of, other));
                    one_of[a.max(b) as usize] = a.min(b);
                }
            }
            boxes.entry(here).or_default().push(vertex);
        }
        let mut facets = std::mem::take(&mut self.triangles.facets);
        facets.iter_mut().flatten().for_each(|vertex| *vertex = root(&one_of, *vertex));
        self.triangles.facets = facets;
        self.drop_unused();
    }

    /// Gives the middle corner of every facet without area to the neighbour at its longest side: the two become two others
    /// that cover the same.
    fn flip_flat(&mut self, close: f64) {
        let facets = self.triangles.facets.iter().enumerate();
        let mut flat: Vec<usize> =
            facets.filter(|(_, facet)| self.is_flat(facet, close)).map(|it| it.0).collect();
        if flat.is_empty() {
            return;
        }
        let mut facet_at: BTreeMap<[u32; 2], usize> = BTreeMap::new();
        for (k, facet) in self.triangles.facets.iter().enumerate() {
            for side in sides(facet) {
                if facet_at.insert(side, k).is_some() {
                    // No surface, which is for the checks to tell.
                    return;
                }
            }
        }
        let mut gone = vec![false; self.numbers.len()];
        loop {
            let before = flat.len();
            let mut next = Vec::new();
            for k in std::mem::take(&mut flat) {
                if !gone[k] && !self.flip(k, close, &mut facet_at, &mut gone) {
                    next.push(k);
                }
            }
            flat = next;
            if flat.is_empty() || flat.len() == before {
                break;
            }
        }
        let mut kept = gone.iter();
        self.triangles.facets.retain(|_| kept.next() == Some(&false));
        let mut kept = gone.iter();
        self.numbers.retain(|_| kept.next() == Some(&false));
        self.drop_unused();
    }

    /// Flips the longest side of a facet without area; whether neither of the two has none afterwards, or both are gone.
    fn flip(
        &mut self,
        k: usize,
        close: f64,
        facet_at: &mut BTreeMap<[u32; 2], usize>,
        gone: &mut [bool],
    ) -> bool {
        let facet = self.triangles.facets[k];
        let at = |vertex: u32| self.triangles.vertices[vertex as usize];
        let length = |[a, b]: [u32; 2]| (at(b) - at(a)).norm_squared();
        let longest =
            (0..3).max_by(|&i, &j| length(sides(&facet)[i]).total_cmp(&length(sides(&facet)[j]))).unwrap_or(0);
        let [a, b, middle] = [0, 1, 2].map(|corner| facet[(longest + corner) % 3]);
        let Some(&neighbour) = facet_at.get(&[b, a]) else { return false };
        let other = self.triangles.facets[neighbour];
        let Some(apex) = other.into_iter().find(|&vertex| vertex != a && vertex != b) else { return false };
        if apex == middle {
            // They cover each other.
            for side in sides(&facet).iter().chain(&sides(&other)) {
                facet_at.remove(side);
            }
            (gone[k], gone[neighbour]) = (true, true);
            return true;
        }
        let is_there = |side| facet_at.contains_key(&side);
        if self.is_flat(&other, close) || is_there([middle, apex]) || is_there([apex, middle]) {
            return false;
        }
        for side in sides(&facet).iter().chain(&sides(&other)) {
            facet_at.remove(side);
        }
        for (place, new) in [(k, [b, middle, apex]), (neighbour, [middle, a, apex])] {
            self.triangles.facets[place] = new;
            facet_at.extend(sides(&new).map(|side| (side, place)));
        }
        true
    }
}

/// The sides of a facet, each from its start to its end.
fn sides(facet: &[u32; 3]) -> [[u32; 2]; 3] {
    let [a, b, c] = *facet;
    [[a, b], [b, c], [c, a]]
}

#[cfg(test)]
mod tests {
    use crate::Surface;

    type Triangle = [[f64; 3]; 3];

    fn cube(size: f64) -> Vec<Triangle> {
        let corner = |c: usize| [0, 1, 2].map(|d| if c >> d & 1 == 1 { size } else { 0.0 });
        let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).map(|facet| facet.map(corner)).collect()
    }

    /// One facet cut at the middles of a side, which opens the surface until a facet without area closes it.
    fn with_flat(mut triangles: Vec<Triangle>, which: usize, parts: usize) -> Vec<Triangle> {
        let [a, b, c] = triangles.remove(which);
        let on = |k: usize| [0, 1, 2].map(|d| a[d] + (b[d] - a[d]) * k as f64 / parts as f64);
        triangles.extend((0..parts).map(|k| [on(k), on(k + 1), c]));
        // A fan from the first corner: every facet of it is flat.
        triangles.extend((1..parts).map(|k| [a, on(k + 1), on(k)]));
        triangles
    }

    #[test]
    fn facets_without_area_change_nothing() {
        for which in 0..12 {
            for parts in [2, 4, 8] {
                let surface = Surface::new(&with_flat(cube(2.0), which, parts)).unwrap();
                assert_eq!(surface.volume(), 8.0, "{which} {parts}");
                assert_eq!(surface.n_facets(), 12 + 2 * (parts - 1));
            }
        }
        // Two corners of a facet at one place.
        let mut doubled = cube(2.0);
        doubled.push([[0.0; 3], [0.0; 3], [2.0, 0.0, 0.0]]);
        doubled.push([[2.0; 3], [2.0; 3], [2.0; 3]]);
        assert_eq!(Surface::new(&doubled).unwrap().n_facets(), 12);
        // Two that cover each other.
        let (a, b, c) = ([0.5, 0.5, 5.0], [1.5, 0.5, 5.0], [1.0, 0.5, 5.0]);
        doubled.extend([[a, b, c], [b, a, c]]);
        assert_eq!(Surface::new(&doubled).unwrap().n_facets(), 12);
    }

    #[test]
    fn corners_that_are_equal_up_to_rounding_are_one() {
        let shaken = |part: f64| {
            let mut triangles = cube(4.0);
            for (k, x) in triangles.iter_mut().flatten().flatten().enumerate() {
                *x += 4.0 * part * f64::from((k * 7919 % 13) as u32) / 12.0;
            }
            Surface::new(&triangles)
        };
        for part in [1e-15, 1e-10, 1e-8] {
            let surface = shaken(part).unwrap();
            assert_eq!(surface.triangles().vertices.len(), 8);
            assert!((surface.volume() - 64.0).abs() <= 400.0 * part, "{}", surface.volume());
        }
        assert!(shaken(1e-4).unwrap_err().to_string().contains("the surface is open"));
        // As single precision rounds them, whatever lies between two numbers.
        let third = 1.0 / 3.0;
        let mut triangles = cube(1.0);
        for (k, x) in triangles.iter_mut().flatten().flatten().enumerate() {
            *x = f64::from((*x + third + 1e-8 * f64::from((k % 3) as u32)) as f32);
        }
        let surface = Surface::new(&triangles).unwrap();
        assert!((surface.volume() - 1.0).abs() < 1e-6, "{}", surface.volume());
    }

    #[test]
    fn slanted_facets_without_area_are_mended_in_single_precision() {
        // Turned about two axes: corners on a line are so up to rounding only.
        let (s, c) = 0.7_f64.sin_cos();
        let turned = |[x, y, z]: [f64; 3]| {
            let [x, y] = [c * x - s * y, s * x + c * y];
            [x, c * y - s * z, s * y + c * z].map(|x| f64::from(x as f32))
        };
        for which in 0..12 {
            let triangles: Vec<Triangle> =
                with_flat(cube(2.0), which, 3).iter().map(|facet| facet.map(turned)).collect();
            let surface = Surface::new(&triangles).unwrap_or_else(|error| panic!("{which}: {error}"));
            assert!((surface.volume() - 8.0).abs() < 1e-5, "{}", surface.volume());
        }
    }
}
