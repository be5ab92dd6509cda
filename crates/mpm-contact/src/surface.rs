//! Closed surfaces of triangles: signed distances by angle-weighted pseudo-normals (Bærentzen & Aanæs 2005).

use crate::bounds::Bounds;
use crate::error::{ContactError, TRIANGLE};
use crate::plane::parts;
use crate::shape::{Near, Outline, SMOOTH, Sample, Shape, keep_distinct};
use crate::tree::{Tree, squared_distance};
use crate::triangle::{Region, crossed, nearest, parts_of_triangle};
use mpm_grid::Block;
use nalgebra::Vector3;
use std::f64::consts::TAU;

/// A body between triangles, grown by the radius ρ of its rounded edges.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    vertices: Vec<Vector3<f64>>,
    facets: Vec<[u32; 3]>,
    tree: Tree,
    /// Unit normals of facets, edges (three to a facet, each from a corner to the next), and vertices.
    facet_normals: Vec<Vector3<f64>>,
    edge_normals: Vec<Vector3<f64>>,
    vertex_normals: Vec<Vector3<f64>>,
    /// For every side of every facet the facet beyond it.
    neighbours: Vec<u32>,
    /// How many facets meet at a vertex.
    valence: Vec<u32>,
    /// 2π less the angles of the facets at a vertex `[rad]`.
    defects: Vec<f64>,
    rounding: f64,
}

/// A feature near a point, and how many facets say so.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    squared: f64,
    feature: u32,
    facet: u32,
    region: Region,
    place: Vector3<f64>,
}

impl Surface {
    /// The body between triangles, each by the numbers of its corners, anticlockwise seen from outside. Every edge must
    /// join two triangles. Nobody checks whether triangles cross.
    ///
    /// # Errors
    /// `vertices`: not finite; `number of triangles`: none; `triangle`, with its number from 1: a corner that does not
    /// exist, no area, an edge that does not join two triangles that face the same way; `volume`: not positive; `rounding`:
    /// negative.
    pub fn new(
        vertices: Vec<Vector3<f64>>,
        triangles: Vec<[u32; 3]>,
        rounding: f64,
    ) -> Result<Self, ContactError> {
        vertices.iter().try_for_each(|x| ContactError::unless_finite("vertices", x.as_slice()))?;
        ContactError::unless_not_negative("rounding", rounding)?;
        let enough = !triangles.is_empty() && triangles.len() < 1 << 29;
        ContactError::unless(
            enough,
            "number of triangles",
            count(triangles.len()),
            "at least 4 and fewer than 2^29",
        )?;
        let neighbours = check(&vertices, &triangles)?;
        let corners = |facet: &[u32; 3]| facet.map(|k| vertices[index(k)]);
        let facet_normals: Vec<Vector3<f64>> =
            triangles.iter().map(|facet| area_vector(&corners(facet)).normalize()).collect();
        let mut edge_normals = Vec::with_capacity(3 * triangles.len());
        let mut vertex_normals = vec![Vector3::zeros(); vertices.len()];
        let mut valence = vec![0; vertices.len()];
        let mut defects = vec![TAU; vertices.len()];
        for (k, facet) in triangles.iter().enumerate() {
            let x = corners(facet);
            for side in 0..3 {
                let (to, back) = (x[(side + 1) % 3] - x[side], x[(side + 2) % 3] - x[side]);
                let angle = to.cross(&back).norm().atan2(to.dot(&back));
                vertex_normals[index(facet[side])] += facet_normals[k] * angle;
                valence[index(facet[side])] += 1;
                defects[index(facet[side])] -= angle;
                edge_normals.push(facet_normals[k] + facet_normals[index(neighbours[3 * k + side])]);
            }
        }
        let unit = |n: &Vector3<f64>| n.try_normalize(0.0).unwrap_or_else(Vector3::zeros);
        let boxes: Vec<Bounds<3>> = triangles.iter().map(|facet| Bounds::around(&corners(facet))).collect();
        Ok(Self {
            tree: Tree::new(&boxes),
            edge_normals: edge_normals.iter().map(unit).collect(),
            vertex_normals: vertex_normals.iter().map(unit).collect(),
            vertices,
            facets: triangles,
            facet_normals,
            neighbours,
            valence,
            defects,
            rounding,
        })
    }

    fn corners(&self, facet: usize) -> [Vector3<f64>; 3] {
        self.facets[facet].map(|k| self.vertices[index(k)])
    }

    /// Number of a feature: facets first, then edges by the lower of their two sides, then vertices.
    fn feature(&self, facet: usize, region: Region) -> u32 {
        let n = numbered(self.facets.len());
        match region {
            Region::Face => numbered(facet),
            Region::Edge(side) => {
                let own = 3 * facet + side;
                let beyond = index(self.neighbours[own]);
                let start = self.facets[facet][(side + 1) % 3];
                let other = (0..3).find(|&s| self.facets[beyond][s] == start).unwrap_or(0);
                n + numbered(own.min(3 * beyond + other))
            }
            Region::Vertex(corner) => 4 * n + self.facets[facet][corner],
        }
    }

    fn candidate(&self, facet: usize, x: &Vector3<f64>) -> Candidate {
        let corners = self.corners(facet);
        let (region, place) = nearest(&corners, x);
        // Of a face the distance along the normal: it loses no digits close to the face.
        let squared = match region {
            Region::Face => self.facet_normals[facet].dot(&(x - corners[0])).powi(2),
            _ => (x - place).norm_squared(),
        };
        Candidate { squared, feature: self.feature(facet, region), facet: numbered(facet), region, place }
    }

    /// The local minima of the distance whose squares are at most `squared_reach`, the nearest first. A place on an
    /// edge or vertex is one where all facets that meet there have it for their nearest.
    fn minima(&self, x: &Vector3<f64>, squared_reach: f64) -> Vec<Candidate> {
        let mut found: Vec<Candidate> = Vec::new();
        let near = |bounds: &Bounds<3>| squared_distance(bounds, x) <= squared_reach;
        self.tree.visit(near, |facet| {
            let candidate = self.candidate(facet, x);
            if candidate.squared <= squared_reach {
                found.push(candidate);
            }
        });
        let order = |a: &Candidate, b: &Candidate| {
            a.squared.total_cmp(&b.squared).then(a.feature.cmp(&b.feature)).then(a.facet.cmp(&b.facet))
        };
        found.sort_by(|a, b| a.feature.cmp(&b.feature).then(order(a, b)));
        let nearest = found.iter().copied().min_by(order);
        let mut minima: Vec<Candidate> = found
            .chunk_by(|a, b| a.feature == b.feature)
            .filter(|same| {
                let needed = match same[0].region {
                    Region::Face => 1,
                    Region::Edge(_) => 2,
                    Region::Vertex(corner) => {
                        index(self.valence[index(self.facets[index(same[0].facet)][corner])])
                    }
                };
                // Rounding at the border of two regions must not lose the nearest place of all.
                same.len() >= needed || nearest.is_some_and(|it| it.feature == same[0].feature)
            })
            .map(|same| same[0])
            .collect();
        minima.sort_by(order);
        minima
    }

    /// The pseudo-normal of a feature.
    fn pseudo_normal(&self, at: &Candidate) -> Vector3<f64> {
        let facet = index(at.facet);
        match at.region {
            Region::Face => self.facet_normals[facet],
            Region::Edge(side) => self.edge_normals[3 * facet + side],
            Region::Vertex(corner) => self.vertex_normals[index(self.facets[facet][corner])],
        }
    }

    /// Signed distance to the triangles with its derivatives, before they grow by ρ.
    fn near_of(&self, at: &Candidate, x: &Vector3<f64>) -> Near<3> {
        let facet = index(at.facet);
        let pseudo = self.pseudo_normal(at);
        let corners = self.corners(facet);
        if at.region == Region::Face {
            let distance = pseudo.dot(&(x - corners[0]));
            return Near { distance, normal: pseudo, hessian: Block::zeros(), feature: at.feature };
        }
        let from = x - at.place;
        let apart = from.norm();
        let outward = if from.dot(&pseudo) < 0.0 { -1.0 } else { 1.0 };
        // On an edge or vertex itself its own normal stands for all.
        if apart <= 1e-14 * corners.iter().map(Vector3::amax).fold(0.0, f64::max) {
            return Near {
                distance: outward * apart,
                normal: pseudo,
                hessian: Block::zeros(),
                feature: at.feature,
            };
        }
        let normal = from * (outward / apart);
        let mut hessian = Block::<3>::identity() - normal * normal.transpose();
        if let Region::Edge(side) = at.region {
            let along = (corners[(side + 1) % 3] - corners[side]).normalize();
            hessian -= along * along.transpose();
        }
        Near { distance: outward * apart, normal, hessian: hessian * (outward / apart), feature: at.feature }
    }

    /// Whether no triangle stands between `x` and a place of the surface.
    fn sees(&self, x: &Vector3<f64>, place: &Vector3<f64>) -> bool {
        let by = place - x;
        let line = Bounds::around([x, place]);
        let mut free = true;
        self.tree.visit(
            |bounds| bounds.meets(&line),
            |facet| {
                let at = crossed(&self.corners(facet), x, &by);
                free &= !at.is_some_and(|share| share > 0.0 && share < 1.0 - 1e-9);
            },
        );
        free
    }

    /// How far the surface behind a place is, straight through the body.
    fn through(&self, from: &Vector3<f64>, normal: &Vector3<f64>, own: usize) -> f64 {
        let whole = self.tree.bounds();
        let length = (whole.to - whole.from).norm();
        let by = -normal * length;
        let line = Bounds::around([from, &(from + by)]);
        let mut least = f64::INFINITY;
        self.tree.visit(
            |bounds| bounds.meets(&line),
            |facet| {
                let hit = crossed(&self.corners(facet), from, &by).filter(|&share| share > 0.0 && facet != own);
                least = least.min(hit.map_or(f64::INFINITY, |share| share * length));
            },
        );
        least
    }

    fn sample_facets(&self, spacing: f64, within: &Bounds<3>, out: &mut Vec<Sample<3>>) {
        for facet in 0..self.facets.len() {
            let normal = self.facet_normals[facet];
            let grown = normal * self.rounding;
            let parts = parts_of_triangle(&self.corners(facet), spacing);
            let samples = parts.map(|(middle, area)| Sample { position: middle + grown, normal, area });
            out.extend(samples.filter(|it| within.contains(&it.position)));
        }
    }

    /// The strips of cylinders that edges become when the surface grows; concave edges lose what they overlap.
    fn sample_edges(&self, spacing: f64, out: &mut Vec<Sample<3>>) {
        for facet in 0..self.facets.len() {
            let x = self.corners(facet);
            for side in 0..3 {
                let beyond = index(self.neighbours[3 * facet + side]);
                if beyond < facet {
                    continue;
                }
                let edge = x[(side + 1) % 3] - x[side];
                let (a, b) = (self.facet_normals[facet], self.facet_normals[beyond]);
                let turn = a.cross(&b).dot(&edge).signum() * a.angle(&b);
                let arc = self.rounding * turn;
                if arc <= 1e-12 * edge.norm() {
                    continue;
                }
                let (n, m) = (parts(edge.norm(), spacing), parts(arc, spacing));
                let area = edge.norm() * arc / f64::from(n * m);
                let across = edge.normalize().cross(&a);
                for i in 0..m {
                    let (sine, cosine) = (turn * (f64::from(i) + 0.5) / f64::from(m)).sin_cos();
                    let normal = a * cosine + across * sine;
                    for k in 0..n {
                        let at = x[side] + edge * ((f64::from(k) + 0.5) / f64::from(n));
                        out.push(Sample { position: at + normal * self.rounding, normal, area });
                    }
                }
            }
        }
    }
}

impl Shape<3> for Surface {
    fn near(&self, x: &Vector3<f64>, reach: f64, out: &mut Vec<Near<3>>) {
        let grown = reach + self.rounding;
        // Inside, how far the surface is away does not count; a point far outside is none's business.
        let outside = squared_distance(&self.tree.bounds(), x);
        if grown <= 0.0 && outside > 0.0 || outside > grown * grown {
            return;
        }
        let least = self.tree.least(x, |facet| self.candidate(facet, x).squared);
        let squared_reach = (grown.max(0.0) * grown.max(0.0)).max(least);
        let minima = self.minima(x, squared_reach);
        let Some(first) = minima.first() else { return };
        let first = self.near_of(first, x);
        let from = out.len();
        out.push(first);
        if first.distance >= 0.0 {
            for at in &minima[1..] {
                let near = self.near_of(at, x);
                if near.distance >= 0.0 && self.sees(x, &at.place) {
                    out.push(near);
                }
            }
            keep_distinct(out, from);
        }
        out[from..].iter_mut().for_each(|near| near.distance -= self.rounding);
        let within = out[from..].iter().take_while(|near| near.distance < reach).count();
        out.truncate(from + within);
    }

    fn kind(&self) -> &'static str {
        "surface"
    }

    fn facet_turn(&self) -> f64 {
        let turn =
            |side: usize| self.facet_normals[side / 3].angle(&self.facet_normals[index(self.neighbours[side])]);
        (0..self.neighbours.len()).map(turn).filter(|turn| *turn < SMOOTH).fold(0.0, f64::max)
    }

    /// Looks at the nearest place alone.
    fn distance(&self, x: &Vector3<f64>) -> f64 {
        let least = self.tree.least(x, |facet| self.candidate(facet, x).squared);
        self.minima(x, least).first().map_or(f64::INFINITY, |at| self.near_of(at, x).distance) - self.rounding
    }

    fn bounds(&self) -> Bounds<3> {
        self.tree.bounds().grown(self.rounding)
    }

    fn samples(&self, spacing: f64, within: &Bounds<3>, out: &mut Vec<Sample<3>>) {
        self.sample_facets(spacing, within, out);
        if self.rounding > 0.0 {
            self.sample_edges(spacing, out);
            for (vertex, normal) in self.vertex_normals.iter().enumerate() {
                let area = self.defects[vertex] * self.rounding * self.rounding;
                if area > 0.0 {
                    out.push(Sample {
                        position: self.vertices[vertex] + normal * self.rounding,
                        normal: *normal,
                        area,
                    });
                }
            }
        }
    }

    fn outline(&self, _spacing: f64, _within: &Bounds<3>) -> Outline<3> {
        Outline { vertices: self.vertices.clone(), facets: self.facets.clone() }
    }

    fn thickness(&self) -> f64 {
        let through = |facet: usize| {
            let x = self.corners(facet);
            self.through(&((x[0] + x[1] + x[2]) / 3.0), &self.facet_normals[facet], facet)
        };
        (0..self.facets.len()).map(through).fold(f64::INFINITY, f64::min) + 2.0 * self.rounding
    }
}

/// Twice the area along the normal `[L²]`.
fn area_vector(corners: &[Vector3<f64>; 3]) -> Vector3<f64> {
    (corners[1] - corners[0]).cross(&(corners[2] - corners[0]))
}

/// Checks that triangles enclose a volume; returns the facet beyond every side.
fn check(vertices: &[Vector3<f64>], triangles: &[[u32; 3]]) -> Result<Vec<u32>, ContactError> {
    let refuse =
        |facet: usize, expected| Err(ContactError { name: TRIANGLE, value: count(facet + 1), expected });
    let mut edges: Vec<([u32; 2], u32)> = Vec::with_capacity(3 * triangles.len());
    let mut volume = 0.0;
    for (k, facet) in triangles.iter().enumerate() {
        if facet.iter().any(|&corner| index(corner) >= vertices.len()) {
            return refuse(k, "triangles whose corners exist");
        }
        let x = facet.map(|corner| vertices[index(corner)]);
        let longest = (0..3).map(|k| (x[(k + 1) % 3] - x[k]).norm_squared()).fold(0.0, f64::max);
        // Also where a side has no length; the bound is the rounding of a cross product.
        if area_vector(&x).norm() <= 1e-14 * longest {
            return refuse(k, "triangles that have an area");
        }
        volume += (x[0] - vertices[0]).dot(&area_vector(&x.map(|x| x - vertices[0])));
        edges.extend(
            (0..3).zip(0..).map(|(side, s)| ([facet[side], facet[(side + 1) % 3]], 3 * numbered(k) + s)),
        );
    }
    edges.sort_unstable();
    if let Some(pair) = edges.windows(2).find(|pair| pair[0].0 == pair[1].0) {
        return refuse(index(pair[1].1) / 3, "edges that join two triangles that face the same way");
    }
    let mut neighbours = vec![0; edges.len()];
    for &([from, to], side) in &edges {
        match edges.binary_search_by_key(&[to, from], |it| it.0) {
            Ok(at) => neighbours[index(side)] = edges[at].1 / 3,
            Err(_) => {
                return refuse(index(side) / 3, "a closed surface, in which every edge joins two triangles");
            }
        }
    }
    ContactError::unless(
        volume > 0.0,
        "volume",
        volume / 6.0,
        "a positive number: triangles that face outwards",
    )?;
    Ok(neighbours)
}

fn count(n: usize) -> f64 {
    f64::from(u32::try_from(n).unwrap_or(u32::MAX))
}

fn numbered(index: usize) -> u32 {
    u32::try_from(index).expect("a surface has fewer than 2^32 facets")
}

fn index(number: u32) -> usize {
    number as usize
}
